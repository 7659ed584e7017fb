"""Groups compared with one of them: the tables, rows and summary that the rules of selection rates share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.publications.counts import Counts, Decisions
from fairaudit.publications.display import NONE, WITHHELD, deviations_text, exact_text, half_up, rate_text, ratio_text
from fairaudit.publications.publication import Page, Publication, Section, Table
from fairaudit.publications.significance import LEVEL, Judged, Pair, Probability, judged
from fairaudit.tables.values import Label
from fairaudit.words import approximate, noun

__all__ = [
    "FOUR_FIFTHS",
    "Line",
    "Sheet",
    "count_of",
    "lead",
    "points",
    "publication_of",
    "reading",
    "said_of_same",
    "same_groups",
    "section",
    "sheets",
    "sheets_by",
]

FOUR_FIFTHS = Fraction(4, 5)

SMALL_PART = Fraction(1, 50)
"""A group with less of the people of a table is named as small."""

Choice = Callable[[Counts], int | None]
"""Which group the others are compared with, by its place."""


@dataclass(frozen=True)
class Line:
    """A group.

    Attributes
    ----------
    group : Label
        Its labels.
    applicants, selected : int
        Its people.
    status : str
        "reference", "compared", or "empty" without people.
    pair : Pair or None
        It and the group that it is compared with.
    judged : Judged or None
        What Fisher's test says of the pair.
    """

    group: Label
    applicants: int
    selected: int
    status: str
    pair: Pair | None = None
    judged: Judged | None = None

    @property
    def rate(self) -> Fraction | None:
        """Selected ÷ applicants."""
        return Fraction(self.selected, self.applicants) if self.applicants else None

    @property
    def ratio(self) -> Fraction | None:
        """Rate ÷ that of the group that it is compared with."""
        return Fraction(1) if self.status == "reference" else self.pair.ratio if self.pair else None


@dataclass(frozen=True)
class Sheet:
    """The groups by some columns, and the one that they are compared with; none where nobody is left to compare."""

    columns: tuple[str, ...]
    lines: tuple[Line, ...]
    reference: Line | None
    unknown: tuple[int, int] = (0, 0)
    withheld: tuple[Label, ...] = ()
    why: str = ""
    unknown_in: tuple[str, ...] = ()

    @property
    def people(self) -> int:
        """Applicants in all groups."""
        return sum(line.applicants for line in self.lines)


def sheets_by(columns: Sequence[str], given: Sequence[Sequence[str]]) -> list[tuple[str, ...]]:
    """By which columns groups are formed: those that were asked for, else each by itself and, of several, all together.

    Examples
    --------
    >>> sheets_by(["sex", "race"], [])
    [('sex',), ('race',), ('sex', 'race')]
    """
    for by in given:
        for name in by:
            if name not in columns:
                raise InputError(f"--by: {shown(name)} is no group column of the certificate; {nearest(name, columns)}")
        if len({*by}) < len(by) or not by:
            raise InputError(f"--by {','.join(by)} does not name different columns; name each once")
    return list(dict.fromkeys(map(tuple, given))) or list(dict.fromkeys([*((name,) for name in columns), tuple(columns)]))


def same_groups(counts: Counts, tables: Sequence[tuple[str, ...]]) -> dict[tuple[str, ...], tuple[str, ...]]:
    """Tables whose groups are those of one before them, whatever they are called: their comparisons are the same, and count once.

    Examples
    --------
    >>> counts = Counts(("sex", "race"), (("f", "a"), ("f", "b"), ("f", "c")), (50, 50, 50), (20, 33, 25))
    >>> same_groups(counts, [("sex",), ("race",), ("sex", "race")])
    {('sex', 'race'): ('race',)}
    """
    first: dict[frozenset[frozenset[Label]], tuple[str, ...]] = {}
    found = {}
    for by in tables:
        places = [counts.columns.index(name) for name in by]
        made: dict[Label, set[Label]] = {}
        for group in counts.groups:
            label = tuple(group[place] for place in places)
            if counts.silent.isdisjoint(zip(by, label, strict=True)):
                made.setdefault(label, set()).add(group)
        before = first.setdefault(frozenset(map(frozenset, made.values())), by)
        if before != by:
            found[by] = before
    return found


def said_of_same(same: Mapping[tuple[str, ...], tuple[str, ...]]) -> list[tuple[str, str]]:
    """For the head of a page: which tables are not shown, since their groups are those of another."""
    told = "; ".join(f"those by {' and '.join(by)} are those by {' and '.join(before)}" for by, before in same.items())
    return [("Groups that are the same", f"{told}: they are shown once, and count once")] if told else []


def sheets(parts: Sequence[Counts], choice: Choice) -> list[Sheet]:
    """Compare the groups of each table; the tests are adjusted for the number of all comparisons."""
    made = [_sheet(counts, choice) for counts in parts]
    found = iter(judged([line.pair for sheet in made for line in sheet.lines if line.pair]))
    return [replace(sheet, lines=tuple(replace(line, judged=next(found)) if line.pair else line for line in sheet.lines)) for sheet in made]


def _sheet(counts: Counts, choice: Choice) -> Sheet:
    place = choice(counts)
    lines = []
    for i, (group, n, s) in enumerate(zip(counts.groups, counts.applicants, counts.selected, strict=True)):
        if not n:
            lines.append(Line(group, n, s, "empty"))
        elif i == place:
            lines.append(Line(group, n, s, "reference"))
        elif place is None:
            lines.append(Line(group, n, s, "alone"))
        else:
            lines.append(Line(group, n, s, "compared", Pair(s, n, counts.selected[place], counts.applicants[place])))
    reference = None if place is None else lines[place]
    return Sheet(counts.columns, tuple(lines), reference, counts.unknown, counts.withheld, counts.why, counts.unknown_in)


def count_of(found: Sequence[Sheet]) -> dict[str, int]:
    """How many comparisons there are, and of how many each finding holds."""
    lines = [line for sheet in found for line in sheet.lines if line.pair]
    return {
        "comparisons": len(lines),
        "below_four_fifths": sum(line.pair.below(FOUR_FIFTHS) for line in lines if line.pair),
        "fisher_at_most_1_20": sum(line.judged.significant for line in lines if line.judged),
        "holm_at_most_1_20": sum(line.judged.significant_adjusted for line in lines if line.judged),
        "more_than_two_standard_deviations": sum(far_apart(line.pair) for line in lines if line.pair),
        "one_person": sum(line.pair.one_person for line in lines if line.pair),
    }


def far_apart(pair: Pair) -> bool:
    """Whether the rates are more than two standard deviations apart."""
    return (pair.squared_deviations or 0) > 4


def name_of(group: Label) -> str:
    """The labels of a group."""
    return ", ".join(group)


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"


def _probability(p: Probability) -> str:
    """A probability with four decimals, which never seem to be on the other side of 1/20."""
    if p.high < Fraction(1, 10_000):
        return "<\N{NO-BREAK SPACE}0.0001"
    return half_up(p.low, 4, (LEVEL,) if p.at_most(LEVEL) is not None else ())


def section(sheet: Sheet, with_whom: str, comparisons: int, about_small: str = "") -> Section:
    """The part of the page about the groups by some columns.

    Parameters
    ----------
    sheet : Sheet
        The groups.
    with_whom : str
        What the group is called that they are compared with.
    comparisons : int
        How many there are on the page: of several the adjusted p-values are shown, too.
    about_small : str
        What to say of groups with few people.
    """
    by = " and ".join(sheet.columns)
    rates = Table(
        f"Rates by {by}",
        ("Group", "Applicants", "Selected", "Rate", f"Ratio to {with_whom}", "Below 4/5 of it"),
        (*map(_rates, sheet.lines), *((name_of(group), *[WITHHELD] * 5) for group in sheet.withheld)),
        tuple(_said(sheet, with_whom, about_small)),
    )
    compared = [line for line in sheet.lines if line.pair]
    if not compared or sheet.reference is None:
        return Section(f"By {by}", (), (rates,))
    findings = Table(
        f"How far from {name_of(sheet.reference.group)}",
        (
            "Group",
            "Difference in points",
            "Fisher p",
            "p ≤ 0.05",
            *(("Holm-adjusted p", "Adjusted p ≤ 0.05") if comparisons > 1 else ()),
            "Standard deviations",
            "More than two standard deviations",
            "Shortfall",
            "Further selected for 4/5",
            "Hangs on one person",
        ),
        tuple(_findings(line.group, line.pair, line.judged, adjusted=comparisons > 1) for line in compared if line.pair and line.judged),
    )
    return Section(f"By {by}", (), (rates, findings))


def _rates(line: Line) -> tuple[str, ...]:
    figures = (rate_text(line.rate), ratio_text(line.ratio), _yes(line.pair.below(FOUR_FIFTHS)) if line.pair else NONE)
    return name_of(line.group), f"{line.applicants:,}", f"{line.selected:,}", *figures


def _findings(group: Label, pair: Pair, found: Judged, *, adjusted: bool) -> tuple[str, ...]:
    points = 100 * (Fraction(pair.selected, pair.applicants) - Fraction(pair.other_selected, pair.other_applicants))
    return (
        name_of(group),
        half_up(points, 1, (Fraction(0),)),
        _probability(found.p),
        _yes(found.significant),
        *((_probability(found.adjusted), _yes(found.significant_adjusted)) if adjusted else ()),
        deviations_text(pair.squared_deviations),
        _yes(far_apart(pair)),
        half_up(pair.shortfall, 1, (Fraction(0),)),
        f"{pair.further(FOUR_FIFTHS):,}",
        _yes(pair.one_person),
    )


def _said(sheet: Sheet, with_whom: str, about_small: str) -> list[str]:
    """What is to be known of a table of rates."""
    said = []
    there = [line for line in sheet.lines if line.applicants]
    if sheet.reference is None or len(there) < 2:
        said.append(f"Fewer than two groups {'are shown' if sheet.why else 'have people'}, so that nothing is compared.")
    else:
        said.append(f"Compared with {with_whom}: {name_of(sheet.reference.group)}.")
        if not sheet.reference.selected:
            said.append("Nobody of it was selected: the ratio is 1 where nobody of the other group was either, and else there is none.")
    if len(there) < len(sheet.lines):
        said.append("A group without people has no rate.")
    if sheet.unknown[0]:
        blurred = {*sheet.unknown_in} - {*sheet.columns}
        also = f" (of some {' and '.join(sheet.columns)} may be known; the certificate does not say of whom)" if blurred else ""
        said.append(
            f"Of {sheet.unknown[0]:,} more {noun(sheet.unknown[0], 'person', 'people')}, {sheet.unknown[1]:,} of them "
            f"selected, {' or '.join(sheet.unknown_in)} is unknown"
            f"{also}; they are left out of this table."
        )
    if sheet.withheld:
        said.append("A group that is withheld is compared with none, and may have a higher or a lower rate than all that are shown.")
    if sheet.why:
        return [*said, sheet.why]
    small = [name_of(line.group) for line in there if line.applicants < SMALL_PART * sheet.people]
    if small:
        said.append(f"Less than 2 % of the people of this table each: {'; '.join(small)}. {about_small}".rstrip())
    return said


def lead(number: Mapping[str, int], with_whom: str) -> str:
    """How many comparisons there are."""
    if not number["comparisons"]:
        return "There are no two groups to compare, so that nothing is compared."
    return f"{_comparisons(number['comparisons'])} with {with_whom}. Each line below is a finding; none of them is a verdict."


def points(number: Mapping[str, int]) -> tuple[str, ...]:
    """How many comparisons have which finding."""
    found = {
        "below_four_fifths": "below four fifths of it",
        "more_than_two_standard_deviations": "more than two standard deviations apart",
        "fisher_at_most_1_20": "with p ≤ 0.05 by Fisher's exact test",
        "holm_at_most_1_20": "with p ≤ 0.05 when the number of comparisons is taken into account",
        "one_person": "where the order of the two rates hangs on one person",
    }
    shown = found if number["comparisons"] > 1 else {name: text for name, text in found.items() if name != "holm_at_most_1_20"}
    return tuple(f"{number[name]} of {number['comparisons']} {text}" for name, text in shown.items()) if number["comparisons"] else ()


def _comparisons(count: int) -> str:
    return f"{count:,} comparison{'s' * (count != 1)}"


def reading(comparisons: int, with_whom: str) -> tuple[str, ...]:
    """What the findings mean."""
    said = (
        (
            "Below 4/5: the rate is less than four fifths of the other, decided on the counts, so that exactly four fifths is not below. "
            "Further selected for 4/5: the least number of people of the group who, selected besides, would raise it to that."
        ),
        (
            "Fisher p: if the people selected had been drawn by lot from both groups together, how probable it were to see what is no more "
            "probable than this. Standard deviations: the difference of the rates, measured by the same thought. Few people make both "
            "blind; very many let them find differences that matter to nobody."
        ),
        "Shortfall: how many more of the group would have been selected at the rate of both groups together; below 0, so many fewer.",
        (
            "Hangs on one person: had one more of the group with the lower rate been selected, and one less of the other, their order "
            "would be the other way round."
        ),
    )
    if comparisons < 2:
        return said
    return (
        *said,
        (
            f"There are {_comparisons(comparisons)} with {with_whom} on this page, and of many some differ by chance. The Holm-adjusted p "
            "takes all of them into account: the smallest p is multiplied by their number, the next by one less, and so on. Where groups "
            "are formed by several sets of columns, the same people are in several comparisons."
        ),
    )


FINDINGS: tuple[tuple[str, Callable[[Pair, Judged], Any]], ...] = (
    ("below_four_fifths", lambda pair, _: pair.below(FOUR_FIFTHS)),
    ("fisher_p", lambda _, found: found.p),
    ("fisher_p_at_most_1_20", lambda _, found: found.significant),
    ("holm_p", lambda _, found: found.adjusted),
    ("holm_p_at_most_1_20", lambda _, found: found.significant_adjusted),
    ("squared_deviations", lambda pair, _: pair.squared_deviations),
    ("more_than_two_standard_deviations", lambda pair, _: far_apart(pair)),
    ("shortfall", lambda pair, _: pair.shortfall),
    ("missing_to_four_fifths", lambda pair, _: pair.further(FOUR_FIFTHS)),
    ("one_person", lambda pair, _: pair.one_person),
)
"""What is found of a comparison: truth values, whole numbers, rationals and probabilities."""

FIGURES = (
    *("applicants", "selected", "rate", "ratio", "compared_with"),
    *("standard_deviations" if name == "squared_deviations" else name for name, _ in FINDINGS),
    *("rate_exact", "ratio_exact", "squared_deviations_exact", "shortfall_exact", "status"),
)


def publication_of(
    rule: str, page: Page, found: Sequence[Sheet], decisions: Decisions, favourable: Sequence[str], **more: Any
) -> Publication:
    """Put the CSV and the summary beside a page.

    Parameters
    ----------
    rule : str
        As the option names it.
    page : Page
        What is said of the groups.
    found : sequence of Sheet
        Their tables.
    decisions : Decisions
        What was decided.
    favourable : sequence of str
        Which decisions count as selected.
    **more : texts, lists and mappings
        What the summary says besides.
    """
    about = {"selected": list(favourable), "summed_over": list(decisions.contexts), **more, **count_of(found)}
    header = ("table", *(f"group: {name}" for name in decisions.columns), *FIGURES)
    return Publication(page, rule, header, _csv_rows(found, decisions.columns), about | {"tables": _entries(found)})


def _csv_rows(found: Sequence[Sheet], columns: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The rows of the CSV: one for each group of each table, and one of people of unknown group."""
    rows = []
    for sheet in found:
        title = " and ".join(sheet.columns)
        for line in sheet.lines:
            labels = dict(zip(sheet.columns, line.group, strict=True))
            rows.append((title, *(labels.get(name, "") for name in columns), *_csv_figures(line, sheet.reference)))
        for group in sheet.withheld:
            labels = dict(zip(sheet.columns, group, strict=True))
            rows.append((title, *(labels.get(name, "") for name in columns), *("" for _ in FIGURES[1:]), WITHHELD))
        if sheet.unknown[0]:
            unknown = {"applicants": str(sheet.unknown[0]), "selected": str(sheet.unknown[1]), "status": "unknown"}
            rows.append((title, *("" for _ in columns), *(unknown.get(name, "") for name in FIGURES)))
    return tuple(rows)


def _csv_figures(line: Line, reference: Line | None) -> list[str]:
    figures = {
        "applicants": str(line.applicants),
        "selected": str(line.selected),
        "rate": _without(rate_text(line.rate)),
        "ratio": _without(ratio_text(line.ratio)),
        "rate_exact": exact_text(line.rate) or "",
        "ratio_exact": exact_text(line.ratio) or "",
        "status": line.status,
    }
    if line.pair and line.judged and reference:
        square, shortfall = line.pair.squared_deviations, line.pair.shortfall
        figures |= {name: _cell(value(line.pair, line.judged)) for name, value in FINDINGS}
        figures |= {
            "compared_with": name_of(reference.group),
            "standard_deviations": _without(deviations_text(square)),
            "shortfall": half_up(shortfall, 1, (Fraction(0),)),
            "squared_deviations_exact": exact_text(square) or "",
            "shortfall_exact": exact_text(shortfall) or "",
        }
    return [figures.get(name, "") for name in FIGURES]


def _cell(value: Any) -> str:
    """A finding for a spreadsheet."""
    return _yes(value) if isinstance(value, bool) else _rounded(value) if isinstance(value, Probability) else str(value)


def _json(value: Any) -> Any:
    """A finding for programs."""
    return _ends(value) if isinstance(value, Probability) else exact_text(value) if isinstance(value, Fraction) else value


def _rounded(p: Probability) -> str:
    """Six digits, so far as the bounds have them."""
    low, high = (approximate(end, digits=6) for end in (p.low, p.high))
    return low if low == high else f"< {approximate(p.high, 'up', 1)}"


def _without(text: str) -> str:
    return "" if text == NONE else text


def _entries(found: Sequence[Sheet]) -> list[dict[str, Any]]:
    """The tables of the summary."""
    return [
        {
            "columns": list(sheet.columns),
            "compared_with": None if sheet.reference is None else dict(zip(sheet.columns, sheet.reference.group, strict=True)),
            **({} if sheet.why else {"unknown": {"applicants": sheet.unknown[0], "selected": sheet.unknown[1]}}),
            "groups": [
                *(_entry(sheet, line) for line in sheet.lines),
                *({"group": dict(zip(sheet.columns, group, strict=True)), "status": WITHHELD} for group in sheet.withheld),
            ],
        }
        for sheet in found
    ]


def _entry(sheet: Sheet, line: Line) -> dict[str, Any]:
    entry = {
        "group": dict(zip(sheet.columns, line.group, strict=True)),
        "applicants": line.applicants,
        "selected": line.selected,
        "rate": exact_text(line.rate),
        "ratio": exact_text(line.ratio),
        "status": line.status,
    }
    if line.pair and line.judged:
        entry["findings"] = {name: _json(value(line.pair, line.judged)) for name, value in FINDINGS}
    return entry


def _ends(p: Probability) -> list[str]:
    """The probability between two decimals, of twelve digits after the point."""
    low = p.low.numerator * 10**12 // p.low.denominator
    high = -(-p.high.numerator * 10**12 // p.high.denominator)
    return [f"{end // 10**12}.{end % 10**12:012}" for end in (low, high)]
