"""The tables of New York City's rule on automated employment decision tools (6 RCNY 5-300 to 5-304), from whole numbers of people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Literal

from fairaudit.publications.circulation import Parts, is_small
from fairaudit.publications.ll144.categories import RACES, SEXES
from fairaudit.publications.ll144.worst_case import WorstCase, worst_case
from fairaudit.publications.withholding import Place, chosen_of_two, why_withheld

__all__ = ["Count", "ImpactTable", "Line", "People", "Shown", "Unknown", "impact_table", "shown_of", "three_tables"]


TABLES = ("sex", "race", "intersection")

PART = 50  # a category of which 50 times its people are fewer than all is below 2 %


Count = tuple[int, int]
"""The people selected, and all of them."""

People = Mapping[Place, Count]
"""By sex and race or ethnicity; None where it is unknown, and where nothing is recorded of it."""


@dataclass(frozen=True)
class Unknown:
    """The people outside a table because a category is unknown.

    Attributes
    ----------
    selected, unselected : int
        Those who were selected, and who were not.
    undecided : int
        Those of whom not even that is known.
    """

    selected: int = 0
    unselected: int = 0
    undecided: int = 0

    @property
    def people(self) -> int:
        """All of them."""
        return self.selected + self.unselected + self.undecided


@dataclass(frozen=True)
class Line:
    """A category in a table.

    Attributes
    ----------
    sex, race : str
        The category; empty where the table is not about it.
    selected, applicants : int
        The people of the category who were selected, and all of them.
    status : str
        ``compared``, ``excluded`` (below 2 % of the table), or ``empty``.
    rate : Fraction or None
        Selected of applicants; None where there are none.
    ratio : Fraction or None
        The rate over the highest rate that is compared; None where the category is not compared.
    share : Fraction or None
        Applicants of all in the table; None where nobody is in it.
    """

    sex: str
    race: str
    selected: int
    applicants: int
    status: Literal["compared", "excluded", "empty"]
    rate: Fraction | None
    ratio: Fraction | None
    share: Fraction | None


@dataclass(frozen=True)
class ImpactTable:
    """One of the three tables.

    Attributes
    ----------
    name : str
        ``sex``, ``race`` or ``intersection``.
    lines : tuple of Line
        All categories, in the order of the rule.
    unknown : Unknown or None
        The people outside it; None where nothing may be said of them.
    worst : WorstCase or None
        The least impact ratio of the categories compared, whoever the unknown are; its pair are places in `lines`.
    worst_of_all : WorstCase or None
        The same of all categories, those that are left out or have no people included.
    withheld : tuple of (str, str)
        Further categories, of which nothing may be said; then nothing is said of all people either.
    why : str
        How many these are, and why; empty where nothing was to be withheld.
    """

    name: str
    lines: tuple[Line, ...]
    unknown: Unknown | None
    worst: WorstCase | None
    worst_of_all: WorstCase | None
    withheld: tuple[tuple[str, str], ...] = ()
    why: str = ""

    @property
    def applicants(self) -> int:
        """The people in the table."""
        return sum(line.applicants for line in self.lines)

    @property
    def top(self) -> Line | None:
        """The category with the highest rate of those compared, of equal ones the first; None where none is."""
        compared = [line for line in self.lines if line.rate is not None and line.status == "compared"]
        return max(compared, key=lambda line: line.rate or Fraction(0), default=None)

    @property
    def nobody_selected(self) -> bool:
        """Whether all rates that are compared are 0, so that each of them is the highest."""
        return self.top is not None and self.top.rate == 0

    def below_2_percent(self, line: Line) -> bool:
        """Whether a category has people, and less than 2 % of those in the table."""
        return 0 < PART * line.applicants < self.applicants

    def least(self) -> Line | None:
        """The category with the least impact ratio, of equal ones the first."""
        return min((line for line in self.lines if line.ratio is not None), key=lambda line: line.ratio or Fraction(0), default=None)


@dataclass(frozen=True)
class Shown:
    """What may be shown where small counts are withheld.

    Attributes
    ----------
    least : int
        The least count that is not small.
    categories : frozenset of (str or None, str or None)
        Sex and race; None for what a table is not about.
    unknown : bool
        Whether the people of unknown category may be.
    """

    least: int
    categories: frozenset[Place]
    unknown: bool


def impact_table(name: str, counts: Mapping[tuple[str, str], Count], unknown: Unknown, *, exclude: bool = False) -> ImpactTable:
    """Compare the rate of each category with the highest one.

    Parameters
    ----------
    name : str
        The table.
    counts : mapping of (str, str) to (int, int)
        For each category, sex and race with an empty text for what the table is not about, the selected and all.
    unknown : Unknown
        The people outside the table.
    exclude : bool
        Whether categories below 2 % of the people in the table are left out of the ratios.

    Returns
    -------
    ImpactTable
        With rates of all categories, and ratios of those compared; where all rates are 0 each ratio is 1.

    Examples
    --------
    >>> table = impact_table("sex", {("Male", ""): (667, 1390), ("Female", ""): (555, 1181)}, Unknown(100, 150))
    >>> [line.ratio for line in table.lines], table.worst.ratio
    ([Fraction(1, 1), Fraction(771450, 787727)], Fraction(826950, 1020877))
    """
    everybody = sum(n for _, n in counts.values())
    status: dict[tuple[str, str], Literal["compared", "excluded", "empty"]] = {
        category: "empty" if n == 0 else "excluded" if exclude and PART * n < everybody else "compared"
        for category, (_, n) in counts.items()
    }
    rates = {category: Fraction(s, n) for category, (s, n) in counts.items() if n}
    top = max((rates[category] for category in rates if status[category] == "compared"), default=None)
    lines = tuple(
        Line(
            sex=category[0],
            race=category[1],
            selected=s,
            applicants=n,
            status=status[category],
            rate=rates.get(category),
            ratio=None if top is None or status[category] != "compared" else rates[category] / top if top else Fraction(1),
            share=Fraction(n, everybody) if everybody else None,
        )
        for category, (s, n) in counts.items()
    )
    of_all = _worst(lines, range(len(lines)), unknown)
    return ImpactTable(
        name, lines, unknown, _worst(lines, [i for i, line in enumerate(lines) if line.status == "compared"], unknown), of_all
    )


def _worst(lines: Sequence[Line], places: Sequence[int], unknown: Unknown) -> WorstCase | None:
    found = worst_case([(lines[i].selected, lines[i].applicants) for i in places], unknown.selected, unknown.unselected, unknown.undecided)
    return found if found is None or found.pair is None else WorstCase(found.ratio, (places[found.pair[0]], places[found.pair[1]]))


def three_tables(
    people: People,
    apart: Unknown,
    *,
    sex: bool = True,
    race: bool = True,
    available: bool = False,
    exclude: bool = False,
    shown: Shown | None = None,
) -> tuple[ImpactTable, ...]:
    """Make the tables of sex, of race or ethnicity, and of both; of one attribute only its own.

    Parameters
    ----------
    people : mapping of (str or None, str or None) to (int, int)
        For each sex and race the selected and all.
    apart : Unknown
        People of whom a category is unknown, it is not recorded which.
    sex, race : bool
        Whether it is recorded.
    available : bool
        Whether each table has all people whose category in it is known, rather than those of whom both are.
    exclude : bool
        Whether categories below 2 % of a table are left out of its ratios.
    shown : Shown, optional
        The only categories that may be shown.

    Examples
    --------
    >>> people = {("Male", "White"): (2, 4), ("Female", "White"): (1, 4), ("Male", None): (1, 1)}
    >>> [(table.name, table.applicants, table.unknown.people) for table in three_tables(people, Unknown())]
    [('sex', 8, 1), ('race', 8, 1), ('intersection', 8, 1)]
    >>> [(table.name, table.applicants, table.unknown.people) for table in three_tables(people, Unknown(), available=True)]
    [('sex', 9, 0), ('race', 8, 1), ('intersection', 8, 1)]
    """
    made: list[ImpactTable] = []
    for name in TABLES:
        about = (name != "race", name != "sex")
        if (about[0] and not sex) or (about[1] and not race):
            continue
        asked = about if available else (sex, race)
        unknown = _unknown(people, apart, asked)
        counts: dict[tuple[str, str], Count] = dict.fromkeys(product(SEXES if about[0] else ("",), RACES if about[1] else ("",)), (0, 0))
        for category, (s, n) in people.items():
            if _known(category, asked):
                own = category[0] or "" if about[0] else "", category[1] or "" if about[1] else ""
                counts[own] = counts[own][0] + s, counts[own][1] + n
        if shown is None:
            made.append(impact_table(name, counts, unknown, exclude=exclude))
        else:
            made.append(_only(shown, name, counts, unknown, linked=sex and race))
    return tuple(made)


def _known(category: Place, asked: tuple[bool, bool]) -> bool:
    return all(label is not None for label, needed in zip(category, asked, strict=True) if needed)


def _unknown(people: People, apart: Unknown, asked: tuple[bool, bool]) -> Unknown:
    """All people of whom something that is asked is unknown."""
    outside = [count for category, count in people.items() if not _known(category, asked)]
    selected = sum(s for s, _ in outside)
    return Unknown(apart.selected + selected, apart.unselected + sum(n for _, n in outside) - selected, apart.undecided)


def _only(shown: Shown, name: str, counts: Mapping[tuple[str, str], Count], unknown: Unknown, *, linked: bool) -> ImpactTable:
    """A table of the categories that may be shown, with nothing in it that rests on others."""
    withheld = tuple(category for category in counts if (category[0] or None, category[1] or None) not in shown.categories)
    table = impact_table(name, {category: count for category, count in counts.items() if category not in withheld}, Unknown())
    return ImpactTable(
        name,
        tuple(replace(line, share=None) for line in table.lines),
        unknown if shown.unknown else None,
        None,
        None,
        withheld,
        why_withheld(shown.least, len(withheld), len(counts), linked=linked),
    )


def shown_of(classes: Sequence[tuple[People, Unknown]], least: int, *, sex: bool, race: bool, every: bool) -> Shown:
    """Decide which categories are shown so that no small count can be computed; each is shown with all classes or with none.

    Parameters
    ----------
    classes : sequence of (mapping, Unknown)
        As for `three_tables`: once, or for each class that the tool sorts people into.
    least : int
        The least count that is not small.
    sex, race : bool
        Whether it is recorded.
    every : bool
        Whether everybody is in one of the classes.
    """

    def kinds(counts: Sequence[Count]) -> Parts:
        """How many people are of each class, and of none of them where there can be such."""
        taken = [s for s, _ in counts]
        return tuple(taken) if len(classes) > 1 and every else (*taken, counts[0][1] - sum(taken))

    cells = {
        (one, other): kinds([people.get((one if sex else None, other if race else None), (0, 0)) for people, _ in classes])
        for one, other in product(SEXES if sex else ("",), RACES if race else ("",))
    }
    if sex and race:
        categories = chosen_of_two(cells, least, [frozenset({"sex"}), frozenset({"race"}), frozenset({"sex", "race"})], ("sex", "race"))
    else:
        categories = frozenset((one or None, other or None) for (one, other), parts in cells.items() if not is_small(parts, least))
    outside = [_unknown(people, apart, (sex, race)) for people, apart in classes]
    undecided = any(unknown.undecided for unknown in outside)
    return Shown(least, categories, not undecided and not is_small(kinds([(each.selected, each.people) for each in outside]), least))
