"""What was done to a log before it was counted: the entries of `subject.preparation` in a certificate, and their words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal

from fairaudit.errors import shown
from fairaudit.exact.rationals import decimal_text, rational_text

__all__ = [
    "ByGroup",
    "Entry",
    "Unit",
    "above",
    "above_median",
    "amount_of",
    "assumption",
    "in_order",
    "intervals",
    "is_uncounted",
    "left_out",
    "level",
    "merged_labels",
    "parted",
    "said",
    "scored",
    "uncounted",
    "undisclosed",
    "unequal_shares",
    "unequally_left_out",
    "unknown_groups",
    "unread",
    "words",
]


Entry = Mapping[str, Any]

Unit = Literal["decisions", "rows"]

ByGroup = Mapping[tuple[str, ...], tuple[Fraction, Fraction]]
"""By the labels of a group, how many of its decisions were left out, and of how many."""

SHOW_GROUPS = 6  # of which decisions were left out, in a sentence

UNEQUAL = Fraction(1, 10)  # shares that were left out of two groups differ by more than this: said first

STEPS = ("above", "above median", "intervals", "mapped", "folded", "left out", "level", "unknown")

MISSING = "missing label"

UNIT_OF_LINES = "lines"

LEFT_OUT = " and were left out"

AMOUNTS = ("decisions", "rows", UNIT_OF_LINES, "of")


def intervals(column: str, edges: Sequence[Fraction]) -> Entry:
    """Numbers of a column were cut into intervals."""
    return {"step": "intervals", "column": column, "edges": [_text(edge) for edge in edges]}


def merged_labels(step: Literal["mapped", "folded"], column: str, label: str, spellings: Iterable[str]) -> Entry:
    """Labels of a column were written as another one."""
    return {"step": step, "column": column, "label": label, "from": sorted(spellings)}


def left_out(unit: Unit, amount: Fraction, of: Fraction, columns: Mapping[str, Fraction], groups: ByGroup | None = None) -> Entry:
    """Decisions (of a table of probabilities: rows) had no label in some column and were left out.

    Parameters
    ----------
    unit : {"decisions", "rows"}
        What is counted.
    amount, of : Fraction
        How many were left out, and of how many.
    columns : mapping of str to Fraction
        How many have no label in each column.
    groups : mapping, optional
        By the labels of a group, how many of its decisions were left out, and of how many; none where that is not known.

    Examples
    --------
    >>> entry = left_out("decisions", Fraction(3), Fraction(10), {"hired": Fraction(3)}, {("f",): (Fraction(3), Fraction(4))})
    >>> words(entry)
    "3 of 10 decisions have a missing label and were left out ('hired': 3; by group: 'f' 3 of 4)"
    """
    without = {column: _text(missing) for column, missing in columns.items() if missing}
    listed = None if groups is None else [_of_group(unit, label, *groups[label]) for label in sorted(groups) if groups[label][0]]
    return {"step": "left out", "reason": MISSING, unit: _text(amount), "of": _text(of), "columns": without, "groups": listed}


def _of_group(unit: Unit, label: Sequence[str], amount: Fraction, of: Fraction) -> dict[str, Any]:
    return {"group": list(label), unit: _text(amount), "of": _text(of)}


def undisclosed(entry: Entry) -> dict[str, Any]:
    """An entry as a certificate has it whose table is not disclosed: without what it says of single groups.

    Examples
    --------
    >>> entry = left_out("decisions", Fraction(3), Fraction(10), {"hired": Fraction(3)}, {("f",): (Fraction(3), Fraction(4))})
    >>> words(undisclosed(entry))
    "3 of 10 decisions have a missing label and were left out ('hired': 3)"
    """
    return {**entry, "groups": None} if "groups" in entry else dict(entry)


def unequally_left_out(entries: Iterable[Entry], groups: Iterable[Sequence[str]]) -> str:
    """A sentence on what was left out of each group, where the shares differ by more than a tenth; else nothing.

    Parameters
    ----------
    entries : iterable of mapping
        What was done to the log.
    groups : iterable of sequence of str
        The groups of the table.

    Examples
    --------
    >>> entry = left_out("decisions", Fraction(480), Fraction(2500), {"d": Fraction(480)}, {("black",): (Fraction(480), Fraction(500))})
    >>> unequally_left_out([entry], [("asian",), ("black",)])
    "Left out for a missing label: 480 of the 500 decisions on 'black' (96 %), and none on other groups. The figures are about the rest."
    """
    for entry in entries:
        if entry["step"] != "left out" or not entry.get("groups"):
            continue
        unit = amount_of(entry)[1]
        shares = {tuple(own["group"]): (Fraction(own[unit]), Fraction(own["of"])) for own in entry["groups"]}
        if said := unequal_shares(shares, groups, unit):
            return f"Left out for a missing label: {said}. The figures are about the rest."
    return ""


def unequal_shares(shares: ByGroup, groups: Iterable[Sequence[str]], unit: str = "decisions") -> str:
    """Which part of each group is concerned, the greatest first, where two differ by more than a tenth; else nothing.

    Examples
    --------
    >>> unequal_shares({("f",): (Fraction(1), Fraction(4)), ("m",): (Fraction(1), Fraction(2))}, [("f",), ("m",)])
    "1 of the 2 decisions on 'm' (50 %), and 1 of the 4 decisions on 'f' (25 %)"
    """
    lost = sorted(((amount / of, label) for label, (amount, of) in shares.items() if amount), key=lambda found: (-found[0], found[1]))
    others = {tuple(label) for label in groups} - {label for _, label in lost}
    if not lost or lost[0][0] - (0 if others else lost[-1][0]) <= UNEQUAL:
        return ""
    first, *rest = [_share_text(label, *shares[label], unit) for _, label in lost[:SHOW_GROUPS]]
    more = len(lost) - SHOW_GROUPS
    after = [*rest, *([f"some on {more:,} more groups"] if more > 0 else []), *(["none on other groups"] if others else [])]
    return ", ".join([first, *after[:-1]]) + (f", and {after[-1]}" if after else "")


def _share_text(label: Sequence[str], amount: Fraction, of: Fraction, unit: str) -> str:
    own = parted({unit: _text(amount), "of": _text(of)})
    return f"{own[unit]} of the {own['of']} {unit} on {', '.join(map(shown, label))} ({float(100 * amount / of):.3g} %)"


def unread(reason: str, lines: int) -> Entry:
    """Lines of a log could not be counted."""
    return {"step": "left out", "reason": reason, UNIT_OF_LINES: str(lines)}


def level(column: str, label: str, unit: Unit, amount: Fraction) -> Entry:
    """Decisions (of a table of probabilities: rows) without a label in a column form a level of their own."""
    return {"step": "level", "column": column, "label": label, unit: _text(amount)}


def unknown_groups(unit: Unit, labels: Iterable[str], amount: Fraction, of: Fraction, columns: Mapping[str, Fraction]) -> Entry:
    """Decisions have a label in some group column that names no group, so many in each; the empty label stands for a missing one.

    Examples
    --------
    >>> words(unknown_groups("decisions", ["n/a", ""], Fraction(3), Fraction(10), {"sex": Fraction(3)}))
    "3 of 10 decisions have no recorded group ('sex': 3), being labelled 'n/a' or not at all"
    """
    named = {column: _text(own) for column, own in columns.items() if own}
    return {"step": "unknown", "labels": sorted(set(labels)), unit: _text(amount), "of": _text(of), "columns": named}


def above(column: str, limit: Fraction) -> Entry:
    """Scores were cut in two at a number."""
    return {"step": "above", "column": column, "limit": _text(limit)}


def above_median(column: str, median: Fraction, of: Fraction) -> Entry:
    """Scores were cut in two at the median of so many.

    Examples
    --------
    >>> words(above_median("points", Fraction(129, 2), Fraction(168)))
    "a number in column 'points' above 64.5, the median of 168, counts as 'above', any other as 'not above'"
    """
    return {"step": "above median", "column": column, "median": _text(median), "of": _text(of)}


def scored(entries: Iterable[Entry]) -> set[str]:
    """Columns of scores that were cut in two: of them a missing one can be no level.

    Examples
    --------
    >>> scored([above("points", Fraction(64))])
    {'points'}
    """
    return {entry["column"] for entry in entries if entry["step"] in ("above", "above median")}


def in_order(entries: Iterable[Entry], columns: Sequence[str], labels: Mapping[str, Iterable[str]]) -> tuple[Entry, ...]:
    """Order entries by step and by column, without those about other columns or about labels of which nothing is left.

    Parameters
    ----------
    entries : iterable of mapping
        The entries.
    columns : sequence of str
        The columns of the law: decision, groups, contexts.
    labels : mapping of str to iterable of str
        For each of them the labels of the law.
    """
    known = {column: set(labels[column]) for column in columns}
    kept = [e for e in entries if "column" not in e or (e["column"] in known and e.get("label", None) in {None, *known[e["column"]]})]
    places = {column: place for place, column in enumerate(columns)}
    return tuple(sorted(kept, key=lambda e: (STEPS.index(e["step"]), places[e["column"]] if "column" in e else 0, e.get("label", ""))))


def assumption(entry: Entry) -> str:
    """What has to be assumed of what was left out; empty for other entries."""
    if entry["step"] not in ("left out", "unknown"):
        return ""
    return f"{_counted(entry)}; they are taken to be no different from the others"


def words(entry: Entry) -> str:
    """An entry in words.

    Examples
    --------
    >>> words(merged_labels("folded", "race", "Black", ["BLACK", " black"]))
    "in column 'race', ' black' and 'BLACK' count as 'Black': they differ in case, blanks or Unicode form alone"
    """
    entry = parted(entry)
    if entry["step"] == "unknown":
        columns = ", ".join(f"{shown(column)}: {amount}" for column, amount in entry["columns"].items())
        held = [shown(label) for label in entry["labels"] if label] + ["not at all"] * ("" in entry["labels"])
        return f"{_counted(entry).removesuffix(LEFT_OUT)} ({columns}), being labelled {' or '.join(held)}"
    if entry["step"] == "left out":
        columns = ", ".join(f"{shown(column)}: {amount}" for column, amount in entry.get("columns", {}).items())
        return _counted(entry) + (f" ({columns}{_by_group(entry)})" if columns else "")
    column = f"column {shown(entry['column'])}"
    if entry["step"] == "intervals":
        return f"{column} was cut into intervals at {', '.join(entry['edges'])}"
    if entry["step"] == "level":
        amount, unit = amount_of(entry)
        return f"{amount} {unit} without a label in {column} form the level {shown(entry['label'])}"
    if entry["step"] in ("above", "above median"):
        limit = decimal_text(Fraction(entry["limit" if entry["step"] == "above" else "median"]))
        what = f", the median of {entry['of']}," if entry["step"] == "above median" else ""
        return f"a number in {column} above {limit}{what} counts as 'above', any other as 'not above'"
    *others, last = map(shown, entry["from"])
    named = f"{', '.join(others)} and {last}" if others else last
    alike = f": {'they differ' if others else 'it differs'} in case, blanks or Unicode form alone"
    why = ", as the map says" if entry["step"] == "mapped" else alike
    return f"in {column}, {named} count{'' if others else 's'} as {shown(entry['label'])}{why}"


def said(about: Mapping[str, Any]) -> tuple[str, ...]:
    """What the subject of a certificate says of labels in several spellings, and of what was done before it was counted.

    Examples
    --------
    >>> said({"spellings": [{"column": "race", "labels": ["BLACK", "Black"]}]})
    ("column 'race': 'BLACK' and 'Black' count as different labels, and differ in spelling alone",)
    """
    return (*map(_spelt, about.get("spellings", ())), *map(words, about.get("preparation", ())))


def uncounted(about: Mapping[str, Any]) -> tuple[str, ...]:
    """What the subject of a certificate says was done, without what says how many decisions something was done to.

    Examples
    --------
    >>> entries = [above("points", Fraction(70)), level("sex", "(missing)", "decisions", Fraction(3))]
    >>> uncounted({"preparation": entries})
    ("a number in column 'points' above 70 counts as 'above', any other as 'not above'",)
    """
    return tuple(words(entry) for entry in about.get("preparation", ()) if is_uncounted(entry))


def is_uncounted(entry: Entry) -> bool:
    """Whether an entry does not say how many decisions something was done to.

    Examples
    --------
    >>> is_uncounted(above("points", Fraction(70)))
    True
    >>> is_uncounted(unread("unreadable", 12000))
    False
    """
    return entry["step"] in ("above", "intervals", "mapped", "folded")


def parted(entry: Mapping[str, Any]) -> Entry:
    """An entry whose whole numbers have their thousands apart, to be said in words.

    Examples
    --------
    >>> words(parted(unread("unreadable", 12000)))
    '12,000 lines of the log could not be counted and were left out (unreadable)'
    """

    def apart(amount: str) -> str:
        return f"{int(amount):,}" if amount.isdecimal() else amount

    columns = {"columns": {column: apart(amount) for column, amount in entry["columns"].items()}} if "columns" in entry else {}
    groups = {"groups": [parted(own) for own in entry["groups"]]} if entry.get("groups") else {}
    return {key: apart(value) if key in AMOUNTS else value for key, value in entry.items()} | columns | groups


def _spelt(entry: Mapping[str, Any]) -> str:
    *others, last = map(shown, entry["labels"])
    return f"column {shown(entry['column'])}: {', '.join(others)} and {last} count as different labels, and differ in spelling alone"


def _by_group(entry: Entry) -> str:
    """Of which groups decisions were left out; nothing where that is not known or where they are of no group."""
    listed, unit = entry.get("groups") or [], amount_of(entry)[1]
    said = [f"{', '.join(map(shown, own['group']))} {own[unit]} of {own['of']}" for own in listed[:SHOW_GROUPS]]
    more = [f"{len(listed) - SHOW_GROUPS:,} more groups"] if len(listed) > SHOW_GROUPS else []
    return f"; by group: {', '.join([*said, *more])}" if said else ""


def _counted(entry: Entry) -> str:
    amount, unit = amount_of(entry)
    if unit == UNIT_OF_LINES:
        return f"{amount} lines of the log could not be counted and were left out ({entry['reason']})"
    if entry["step"] == "unknown":
        return f"{amount} of {entry['of']} {unit} have no recorded group{LEFT_OUT}"
    return f"{amount} of {entry['of']} {unit} have a missing label and were left out"


def amount_of(entry: Entry) -> tuple[str, str]:
    """How much an entry is about, and of what: decisions, rows, or lines."""
    return next((entry[unit], unit) for unit in ("decisions", "rows", UNIT_OF_LINES) if unit in entry)


def _text(value: Fraction) -> str:
    return rational_text((value.numerator, value.denominator))
