"""Tables with a column of counts for each decision: they become a row for each decision, and totals are checked, not counted."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number, exact, parse_rational
from fairaudit.tables.label_text import label_text
from fairaudit.tables.tally import counted
from fairaudit.tables.values import column, locator, names, numbers
from fairaudit.words import approximate, brief

__all__ = ["LongTable", "Wide", "is_total", "lengthened", "read_wide", "wide_of", "written_wide"]

OTHERS = "none of these"

QUOTED = '"(?:[^"]|"")*"'
ITEM = re.compile(rf'\s*(?:({QUOTED}|[^",=/]+)(?:/({QUOTED}|[^",=]+))?=)?\s*({QUOTED}|[^",=]+)(,|$)')
TOTALS = re.compile(
    r"(grand |sub)?totals?|all|overall|sums?|both( sexes)?|combined|everyone|everybody|insgesamt|gesamt|summe|alle|ensemble|tou(s|tes)|"
    r"totale|suma",
    re.IGNORECASE,
)

Columns = Mapping[str, str] | Mapping[tuple[str, str], str] | Sequence[str] | str
"""Columns of counts by decision, or by decision and group; or those whose names are the decisions."""

Totals = str | Number | Mapping[str, str]
"""The column of all decisions, one for each group, or the number that shares are of: 1, or 100 for percentages."""


@dataclass(frozen=True)
class Wide:
    """Which columns hold which counts.

    Attributes
    ----------
    counts : tuple of (str, str, str)
        Decision, group and column; the group is empty where rows say it.
    totals : tuple of (str, str)
        Group and column of all decisions.
    of : Fraction or None
        What shares are of; None for counts.
    """

    counts: tuple[tuple[str, str, str], ...]
    totals: tuple[tuple[str, str], ...] = ()
    of: Fraction | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of numbers."""
        return tuple(dict.fromkeys([name for *_, name in self.counts] + [name for _, name in self.totals]))

    @property
    def headers(self) -> bool:
        """Whether the header says the group."""
        return bool(self.counts[0][1])

    @property
    def number(self) -> str:
        """What the column of counts or shares is called."""
        return "count of decisions" if self.of is None else "share of decisions"

    @property
    def rest(self) -> str:
        """What is said of decisions that no column counts."""
        decisions = dict.fromkeys(decision for decision, _, _ in self.counts)
        return f"not {next(iter(decisions))}" if len(decisions) == 1 else OTHERS


@brief
@dataclass(frozen=True, eq=False, repr=False)
class LongTable:
    """A row for each decision of a row, with its count or share.

    Attributes
    ----------
    name : str or None
        Name of what was read, for messages.
    cells : dict of str to list
        Its columns.
    at : list of str
        Where each row comes from.
    notes : tuple of str
        What was noticed.
    preparation : tuple of mapping
        What was done to labels since (`fairaudit.tables.preparation`).
    """

    name: str | None
    cells: dict[str, list[Any]] = field(repr=False)
    at: list[str] = field(repr=False)
    notes: tuple[str, ...] = ()
    preparation: tuple[Any, ...] = ()

    @property
    def columns(self) -> list[str]:
        """Column names, in order."""
        return list(self.cells)

    def __getitem__(self, name: str) -> list[Any]:
        """Values of a column."""
        return self.cells[name]

    def locate(self, position: int) -> str:
        """Name a row."""
        return self.at[position]


def is_total(label: str) -> bool:
    """Whether a label is a word for all together.

    Examples
    --------
    >>> is_total("Total"), is_total("Totally Spies")
    (True, False)
    """
    return TOTALS.fullmatch(label.strip()) is not None


def read_wide(counts: Columns, total: Totals | None = None, *, spelled: Callable[[str], str] = str) -> Wide:
    """Read which columns hold which counts.

    Parameters
    ----------
    counts : mapping, sequence of str, or str
        Columns by decision, or by (decision, group); columns whose names are the decisions; or a text such as ``yes=admitted,no=rejected``
        or ``yes/men=men_yes,yes/women=women_yes``.
    total : str, number or mapping of str to str, optional
        The column of all decisions, or one for each group; or what shares are of: 1, or 100 for percentages.
    spelled : callable
        How the one who asks writes the name of an option, for messages.

    Raises
    ------
    InputError
        If something is named twice, or some columns have a group and others none.

    Examples
    --------
    >>> read_wide("yes=admitted", "applicants")
    Wide(counts=(('yes', '', 'admitted'),), totals=(('', 'applicants'),), of=None)
    >>> read_wide({("yes", "men"): "men_yes", ("yes", "women"): "women_yes"}, 100).of
    Fraction(100, 1)
    """
    what = spelled("wide")
    found: list[tuple[str, str, str]] = []
    if isinstance(counts, str):
        found = [(label or name, group, name) for label, group, name in _items(counts, what)]
    elif isinstance(counts, Mapping):
        for key, name in counts.items():
            pair = (key, "") if isinstance(key, str) else key
            if not isinstance(pair, tuple) or len(pair) != 2 or not all(isinstance(part, str) and part for part in (pair[0], name)):
                raise InputError(f"{what}: {shown(key)} is neither a decision nor a pair of a decision and a group, with a column")
            found.append((pair[0], pair[1], name))
    else:
        found = [(str(name), "", str(name)) for name in counts]
    if not found:
        raise InputError(f"{what} names no column of counts; give one for each decision, such as yes=admitted,no=rejected")
    for position, said in ((slice(0, 2), "decision"), (slice(2, 3), "column")):
        keys = [item[position] for item in found]
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise InputError(f"{what} names the {said} {shown('/'.join(filter(None, twice)))} twice; name each once")
    groups = list(dict.fromkeys(group for _, group, _ in found))
    if "" in groups and len(groups) > 1:
        raise InputError(f"{what} names a group for some columns and none for others; name one for all, such as yes/men=men_yes")
    wide = Wide(tuple(found), *_totals(total, groups, spelled))
    for group in groups:
        listed = [decision for decision, own, _ in found if own == group]
        if not wide.totals and wide.of is None and len(listed) < 2:
            of = f" for {shown(group)}" if group else ""
            raise InputError(
                f"{what} names one decision{of}, {shown(listed[0])}; name the column of the others, too, or that of all with "
                f"{spelled('total')}"
            )
    if any(name == other for _, name in wide.totals for _, _, other in wide.counts):
        raise InputError(f"{spelled('total')} names a column that {what} names, too; a column holds one or the other")
    if wide.rest in {decision for decision, _, _ in found}:
        raise InputError(f"{what} names the decision {shown(wide.rest)}, which stands for what no column counts; call it something else")
    return wide


def _totals(total: Totals | None, groups: list[str], spelled: Callable[[str], str]) -> tuple[tuple[tuple[str, str], ...], Fraction | None]:
    if total is None:
        return (), None
    what = spelled("total")
    if isinstance(total, str):
        of = _number(total)
        listed = () if of is not None else tuple((group, name) for group, _, name in _items(total, what))
    elif isinstance(total, Mapping):
        of, listed = None, tuple(total.items())
    else:
        of, listed = exact(total), ()
    if of is not None:
        if of <= 0:
            raise InputError(f"{what} {shown(total)}: shares are of a number above 0, such as 1, or 100 for percentages")
        return (), of
    own = [group for group, _ in listed]
    if sorted(own) != sorted(groups):
        wanted = "one column" if groups == [""] else "a column for each group, such as " + ",".join(f"{g}=COL" for g in groups[:2])
        raise InputError(f"{what} {shown(total)}: it needs {wanted}")
    return listed, None


def _number(text: str) -> Fraction | None:
    try:
        return Fraction(*parse_rational(text))
    except InputError:
        return None


def _items(text: str, what: str) -> Iterator[tuple[str, str, str]]:
    position = 0
    while position < len(text):
        match = ITEM.match(text, position)
        if match is None:
            raise InputError(
                f"{what} {shown(text)} is not of the form decision=column,… near {shown(text[position:])}; quote what has a comma, a slash "
                "or an equals sign as in CSV"
            )
        label, group, name = (_unquoted(part or "") for part in match.groups()[:3])
        yield label, group, name
        position = match.end() if match.group(4) else len(text)


def _unquoted(text: str) -> str:
    text = text.strip()
    return text[1:-1].replace('""', '"') if text.startswith('"') else text


def written_wide(wide: Wide) -> tuple[str, str]:
    """What `read_wide` reads again: the columns and the totals as texts.

    Examples
    --------
    >>> written_wide(read_wide({("yes", "men"): "men, yes", ("no", "men"): "no"}))
    ('yes/men="men, yes",no/men=no', '')
    """

    def quoted(text: str, marks: str = ',="') -> str:
        return '"' + text.replace('"', '""') + '"' if text != text.strip() or any(mark in text for mark in marks) else text

    items = []
    for decision, group, name in wide.counts:
        of = f"/{quoted(group)}" if group else ""
        label = quoted(decision, ',="/') + of
        items.append(quoted(name) if label == name else f"{label}={quoted(name)}")
    totals = [f"{quoted(group)}={quoted(name)}" if group else quoted(name) for group, name in wide.totals]
    return ",".join(items), ",".join(totals) if wide.of is None else str(wide.of)


def wide_of(wide: Columns | None, total: Totals | None, *, spelled: Callable[[str], str] = str) -> Wide | None:
    """Read which columns hold counts, where they were named.

    Raises
    ------
    InputError
        As `read_wide` does, or if totals are named of nothing.
    """
    if wide is not None:
        return read_wide(wide, total, spelled=spelled)
    if total is not None:
        raise InputError(f"{spelled('total')} goes with {spelled('wide')}, the columns of counts or shares that it is the total of")
    return None


def lengthened(
    table: Any,
    wide: Wide,
    *,
    decision: str,
    group: str | Sequence[str],
    context: str | Sequence[str] = (),
    weight: str | None = None,
    spelled: Callable[[str], str] = str,
) -> LongTable:
    """Make a row for each decision of each row.

    Parameters
    ----------
    table : DataFrame, mapping of str to sequence, CsvTable, or Tally
        The table.
    wide : Wide
        Which columns hold which counts.
    decision : str
        What the column of decisions is to be called.
    group, context : str or sequence of str
        Columns of groups and contexts; where the header says the group, the first of `group` is what that is to be called.
    weight : str, optional
        With shares, how many decisions a row stands for.
    spelled : callable
        As for `read_wide`.

    Returns
    -------
    LongTable
        The rows; of a row that says it is a total, and is that of the others, there are none.

    Raises
    ------
    InputError
        If a number is no count, counts are more than their total, or a row that says it is a total is not.

    Examples
    --------
    >>> table = {"sex": ["f", "m", "Total"], "hired": [3, 4, 7], "applied": [9, 8, 17]}
    >>> found = lengthened(table, read_wide(["hired"], "applied"), decision="decision", group="sex")
    >>> list(zip(found["sex"], found["decision"], found["count of decisions"]))
    [('f', 'hired', 3), ('f', 'not hired', 6), ('m', 'hired', 4), ('m', 'not hired', 4)]
    """
    groups, contexts = names(group), names(context)
    if not groups:
        raise InputError(f"no group column was named; give {spelled('group')}")
    labelled = tuple(dict.fromkeys((*(groups[1:] if wide.headers else groups), *contexts)))
    for name in (decision, wide.number):
        if name in (*groups, *contexts):
            raise InputError(f"a group or context is called {shown(name)}, as the decisions or their numbers are to be; rename the column")
    where = locator(table)
    cells = {name: column(table, name) for name in labelled}
    held = {name: _counts(table, name, wide, spelled) for name in wide.columns}
    rows = len(next(iter(held.values())))
    times = counted(table, rows).tolist()
    labels = [tuple(label_text(cells[name][i]) for name in labelled) for i in range(rows)]
    twice = next((i for i, often in enumerate(times) if often > 1 and wide.of is not None), None)
    if twice is not None:
        raise InputError(f"{where(twice)}: the row occurs {times[twice]} times; of shares each combination has one row")
    left_out = _totals_rows(labels, labelled, held, where, times, wide)
    kept = [i for i in range(rows) if i not in left_out]
    found = list(_decided(wide, held, kept, where, spelled))
    if not any(value for _, _, which, value in found if which == wide.rest):
        found = [row for row in found if row[2] != wide.rest]
    columns: dict[str, list[Any]] = {name: [cells[name][i] for i, *_ in found] for name in labelled}
    if wide.headers:
        columns[groups[0]] = [own for _, own, _, _ in found]
    columns[decision] = [which for _, _, which, _ in found]
    columns[wide.number] = [_plain(value * (times[i] if wide.of is None else 1)) for i, _, _, value in found]
    if weight is not None:
        if wide.headers:
            raise InputError(f"{spelled('weight')} does not go with groups in the header; it is one number for a row, not for each group")
        weights = column(table, weight)
        columns[weight] = [weights[i] for i, *_ in found]
    others = sum(value * times[i] for i, _, which, value in found if which == wide.rest == OTHERS)
    notes = (*getattr(table, "notes", ()), *_said(wide, held, kept, left_out, where, labels), *_said_of_others(wide, others))
    return LongTable(getattr(table, "name", None), columns, [where(i) for i, *_ in found], notes)


def _plain(value: Fraction) -> int | str:
    return value.numerator if value.denominator == 1 else str(value)


def _counts(table: Any, name: str, wide: Wide, spelled: Callable[[str], str]) -> list[Fraction]:
    """Numbers of a column: whole ones, or shares."""
    values, where = column(table, name), locator(table)
    percent = next((i for i, value in enumerate(values) if isinstance(value, str) and value.rstrip().endswith("%")), None)
    if percent is not None and wide.of is None:
        raise InputError(f"column {shown(name)}, {where(percent)}: {shown(values[percent])} is a percentage; {_shares(spelled)}")
    if percent is not None:
        values = [value.rstrip().removesuffix("%") if isinstance(value, str) else value for value in values]
    found, scale = numbers(values, name, where, "amount" if wide.of is None else "share")
    exact = [Fraction(value) / scale for value in found.tolist()]
    broken = next((i for i, value in enumerate(exact) if wide.of is None and value.denominator > 1), None)
    if broken is not None:
        raise InputError(
            f"column {shown(name)}, {where(broken)}: {shown(values[broken])} is not a whole number of decisions; {_shares(spelled)}"
        )
    return exact


def _shares(spelled: Callable[[str], str]) -> str:
    total, weight = spelled("total"), spelled("weight")
    return f"counts are wanted; shares are read with {total} 1, percentages with {total} 100 (and {weight} COL, of how many they are)"


def _decided(
    wide: Wide, held: Mapping[str, list[Fraction]], kept: Sequence[int], where: Callable[[int], str], spelled: Callable[[str], str]
) -> Iterator[tuple[int, str, str, Fraction]]:
    """Row, group, decision and count or share, with what no column counts."""
    totals = dict(wide.totals)
    for i in kept:
        for own in dict.fromkeys(group for _, group, _ in wide.counts):
            listed = [(which, name) for which, group, name in wide.counts if group == own]
            for which, name in listed:
                yield i, own, which, held[name][i] / (wide.of or 1)
            if not totals and wide.of is None:
                continue
            whole = wide.of if wide.of is not None else held[totals[own]][i]
            counted_ = sum(held[name][i] for _, name in listed)
            if counted_ > whole:
                told = str if wide.of is None else approximate
                said = " and ".join(f"{told(held[name][i])} in column {shown(name)}" for _, name in listed)
                more = f"{where(i)}: {said} {'is' if len(listed) == 1 else 'are together'} more than"
                if wide.of is not None:
                    raise InputError(f"{more} the {told(whole)} that they are shares of")
                percent = f"{spelled('total')} 100 {spelled('weight')} {totals[own]}"
                raise InputError(f"{more} {whole} in column {shown(totals[own])}; if these are percentages, say {percent}")
            yield i, own, wide.rest, (whole - counted_) / (wide.of or 1)


def _totals_rows(
    labels: list[tuple[str | None, ...]],
    labelled: tuple[str, ...],
    held: Mapping[str, list[Fraction]],
    where: Callable[[int], str],
    times: list[int],
    wide: Wide,
) -> dict[int, str]:
    """Rows that say that they are totals, or have no label, and are: the sums of the others with the same other labels."""
    found: dict[int, str] = {}
    marked = {i: _mark(row) for i, row in enumerate(labels)}
    parts: dict[tuple[int, ...], dict[tuple[str | None, ...], list[int]]] = {}
    added_up: dict[tuple[Any, ...], dict[str, Fraction | int]] = {}
    for i, word in marked.items():
        if word is None:
            continue
        own = tuple(place for place, label in enumerate(labels[i]) if label is not None and not is_total(label))
        if own not in parts:
            parts[own] = {}
            for j in (j for j, mark in marked.items() if mark is None):
                parts[own].setdefault(tuple(labels[j][place] for place in own), []).append(j)
        key = tuple(labels[i][place] for place in own)
        others = parts[own].get(key, [])
        if (own, key) not in added_up:
            added_up[own, key] = {name: sum(values[j] * times[j] for j in others) for name, values in held.items()}
        sums = added_up[own, key]
        wrong = next((name for name, added in sums.items() if wide.of is not None or added != held[name][i]), None)
        if wrong is None and (word or len(others) > 1):
            found[i] = word or "without a label"
        elif word:
            at = labelled[labels[i].index(word)]
            why = (
                f"the others have {sums[wrong]} in column {shown(wrong)} where it has {held[wrong][i]}" if wrong and wide.of is None else ""
            )
            raise InputError(
                f"{where(i)}: the label {shown(word)} in column {shown(at)} says that the row is a total of others, but "
                f"{why or 'shares do not say so'}; remove the row, or call it something else"
            )
    return found


def _said_of_others(wide: Wide, others: Fraction | int) -> Iterator[str]:
    """What is in no column of several."""
    if others:
        columns = ", ".join(dict.fromkeys(shown(name) for *_, name in wide.counts))
        one = others == 1 and wide.of is None
        many = f"{int(others):,} decision{'' if one else 's'} of the totals" if wide.of is None else "some shares"
        yield f"{columns} do not add up to the total: {many} {'is' if one else 'are'} counted as {shown(OTHERS)}"


def _mark(row: tuple[str | None, ...]) -> str | None:
    """The word for a total in a row; empty if a label is missing, None if neither is so."""
    return next((label for label in row if label is not None and is_total(label)), "" if None in row else None)


def _said(
    wide: Wide,
    held: Mapping[str, list[Fraction]],
    kept: Sequence[int],
    left_out: Mapping[int, str],
    where: Callable[[int], str],
    labels: list[tuple[str | None, ...]],
) -> Iterator[str]:
    if left_out:
        first = next(iter(left_out))
        rows = f"{where(first)} is the total" if len(left_out) == 1 else f"{len(left_out)} rows, first {where(first)}, are totals"
        named = ", ".join(shown(label) for label in labels[first] if label is not None) or "without a label"
        yield f"{rows} of others ({named}) and not counted again"
    columns = ", ".join(dict.fromkeys(shown(name) for *_, name in wide.counts))
    if wide.of is not None:
        said = "of how many decisions is not known, so that nothing is said beyond this table"
        yield f"the numbers in {columns} are shares of {wide.of}; {said}"
    elif wide.totals and kept:
        most = max(held[name][i] for *_, name in wide.counts for i in kept)
        least = min(held[name][i] for _, name in wide.totals for i in kept)
        if most <= 100 < least:
            said = "if they are percentages and not counts, all that follows is wrong"
            yield f"no number in {columns} is above 100, and every total is: {said}"
