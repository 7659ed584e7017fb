"""The tables of New York City's rule with small counts withheld: every figure is of the categories that are shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from fairaudit.errors import InputError
from fairaudit.publications.categories import RACES, SEXES
from fairaudit.publications.counts import Decisions
from fairaudit.publications.display import NONE, WITHHELD, rate_text, ratio_text
from fairaudit.publications.ll144 import ImpactTable, People, Unknown, impact_table
from fairaudit.publications.ll144_page import HEADER, TITLES, Part, exact, facts, gaps, reading_of, words_of
from fairaudit.publications.ll144_people import Reading
from fairaudit.publications.ll144_statement import Stated, findings
from fairaudit.publications.publication import Publication, Row, Section, Table
from fairaudit.publications.small import Place, Withholding, chosen_of_two, least_shown
from fairaudit.publications.withheld import Parts, is_small

__all__ = ["Class", "chosen_of", "publish_small"]

COLUMNS = ("sex", "race")

LESS = (
    "The rule asks for the figures of all categories. Where some are withheld this page gives less than it asks for; whether that may be "
    "is for the reader to judge."
)

OF_SHOWN = (
    "Impact ratios are to the highest rate of the categories shown: one that is withheld may have a higher rate, and then each of these "
    "would be smaller. How many people are in a table, their shares, and what the unknown could change rest on all categories and are not "
    "shown."
)


@dataclass(frozen=True)
class Class:
    """What people can be selected for.

    Attributes
    ----------
    favourable : tuple of str
        The decisions that count as selected.
    people : mapping
        For each sex and race the selected and all.
    apart : Unknown
        People of whom a category is unknown, it is not recorded which.
    label : str or None
        The class, where the tool sorts people into several.
    last : bool
        Whether everybody is in this class or in one before it.
    """

    favourable: tuple[str, ...]
    people: People
    apart: Unknown
    label: str | None = None
    last: bool = False


def chosen_of(classes: Sequence[Class], least: int, *, sex: bool, race: bool) -> frozenset[Place]:
    """Which categories are shown: sex and race, None for what their table is not about.

    A category is shown with all classes or with none.

    Parameters
    ----------
    classes : sequence of Class
        One, or those that the tool sorts people into.
    least : int
        The least count that is not small.
    sex, race : bool
        Whether it is recorded.
    """
    cells = {
        (one, other): _kinds([each.people.get((one if sex else None, other if race else None), (0, 0)) for each in classes], classes)
        for one, other in product(SEXES if sex else ("",), RACES if race else ("",))
    }
    if sex and race:
        return chosen_of_two(cells, least, [frozenset({"sex"}), frozenset({"race"}), frozenset(COLUMNS)], COLUMNS)
    return frozenset((one or None, other or None) for (one, other), kinds in cells.items() if not is_small(kinds, least))


def _kinds(counts: Sequence[tuple[int, int]], classes: Sequence[Class]) -> Parts:
    """How many people are of each class, and of none of them where there can be such."""
    people, taken = counts[0][1], [s for s, _ in counts]
    return tuple(taken) if len(classes) > 1 and classes[-1].last else (*taken, people - sum(taken))


def publish_small(
    stated: Stated, decisions: Decisions, reading: Reading, classes: Sequence[Class], least: int, chosen: frozenset[Place]
) -> Publication:
    """Write the tables with the categories that are chosen.

    Parameters
    ----------
    stated : Stated
        What the auditor states.
    decisions : Decisions
        The counts of the certificate.
    reading : Reading
        What its labels mean.
    classes : sequence of Class
        One, or those that the tool sorts people into.
    least : int
        The least count that is not small.
    chosen : frozenset
        The categories that are shown.

    Raises
    ------
    InputError
        If categories are to be left out by their share of all people.
    """
    if stated.justification is not None:
        raise InputError("--exclude-below-2-percent does not go with --small: shares of all people would tell those who are withheld")
    parts = [Part(each.favourable, tuple(_tables(each, reading, chosen)), each.label) for each in classes]
    unknown = _unknown(classes, reading, least)
    why = Withholding(least, {}, linked=reading.sex is not None and reading.race is not None).why
    classed = classes[0].label is not None
    words = words_of(None, classes=classed)
    found = (*findings(stated), *gaps(decisions, replace(reading, left_out=0), parts, None))
    hidden = any(_hidden(table, chosen) for table in parts[0].tables)
    return Publication(
        rule="ll144",
        title=f"Results of a bias audit: {stated.tool}" if stated.tool else "Results of a bias audit",
        lead=_lead(parts),
        points=found,
        facts=(
            *((name, text) for name, text in facts(stated, decisions, reading, parts, None) if name != "People of unknown category"),
            ("People of unknown category", WITHHELD if unknown is None else f"{unknown[0]} (in no table)"),
            least_shown(least),
        ),
        sections=(
            *(
                Section(
                    "Impact ratios" if part.label is None else f"Impact ratios of the class {part.label}",
                    (),
                    tuple(
                        Table(
                            TITLES[table.name],
                            ("Category", "Applicants", words.selected, words.rate, "Impact ratio"),
                            (*_rows(table, chosen), Row(("Unknown, not in the table", *_outside(unknown, place), NONE, NONE), "unknown")),
                            (why(len(_hidden(table, chosen)), len(_all(table))),),
                        )
                        for table in part.tables
                    ),
                )
                for place, part in enumerate(parts)
            ),
            Section("What is withheld", (*([LESS] if hidden else []), OF_SHOWN)),
            reading_of(words, stated),
        ),
        header=("class", *HEADER) if classed else HEADER,
        rows=tuple(
            (part.label, *row) if part.label is not None else row
            for place, part in enumerate(parts)
            for row in _csv(part, chosen, _outside(unknown, place))
        ),
        summary={
            "unknown": None if unknown is None else unknown[0],
            "findings": list(found),
            "parts": [
                {"class": part.label, "favourable": list(part.favourable), "tables": [_entry(table) for table in part.tables]}
                for part in parts
            ],
        },
    )


def _tables(of: Class, reading: Reading, chosen: frozenset[Place]) -> Iterator[ImpactTable]:
    """The tables of the categories that are shown."""
    there = reading.sex is not None, reading.race is not None
    for name, about in (("sex", (True, False)), ("race", (False, True)), ("intersection", (True, True))):
        if any(wanted and not recorded for wanted, recorded in zip(about, there, strict=True)):
            continue
        counts: dict[tuple[str, str], tuple[int, int]] = {}
        for (sex, race), (s, n) in of.people.items():
            if (there[0] and sex is None) or (there[1] and race is None):
                continue
            place = sex if about[0] else None, race if about[1] else None
            if place in chosen:
                before = counts.get((place[0] or "", place[1] or ""), (0, 0))
                counts[place[0] or "", place[1] or ""] = before[0] + s, before[1] + n
        ordered = product(SEXES if about[0] else ("",), RACES if about[1] else ("",))
        yield impact_table(name, {category: counts[category] for category in ordered if category in counts}, Unknown())


def _all(table: ImpactTable) -> list[tuple[str, str]]:
    """All categories of a table."""
    return [*product(("",) if table.name == "race" else SEXES, ("",) if table.name == "sex" else RACES)]


def _hidden(table: ImpactTable, chosen: frozenset[Place]) -> list[tuple[str, str]]:
    return [(sex, race) for sex, race in _all(table) if (sex or None, race or None) not in chosen]


def _unknown(classes: Sequence[Class], reading: Reading, least: int) -> tuple[int, list[int]] | None:
    """The people outside the tables, and those of them who are of each class; None where that is withheld."""
    outside = []
    for each in classes:
        s, n = each.apart.selected, each.apart.selected + each.apart.unselected
        for (sex, race), (selected, people) in each.people.items():
            if (reading.sex is not None and sex is None) or (reading.race is not None and race is None):
                s, n = s + selected, n + people
        outside.append((s, n))
    if is_small(_kinds(outside, classes), least) or classes[0].apart.undecided:
        return None
    return outside[0][1], [s for s, _ in outside]


def _outside(unknown: tuple[int, list[int]] | None, place: int) -> tuple[str, str]:
    return (WITHHELD, WITHHELD) if unknown is None else (str(unknown[0]), str(unknown[1][place]))


def _name(category: tuple[str, str]) -> str:
    return ", ".join(filter(None, category))


def _lead(parts: Sequence[Part]) -> str:
    """The least impact ratio of the categories shown."""
    found = [(line.ratio, line) for part in parts for table in part.tables if (line := table.least()) and line.ratio is not None]
    if not found:
        return "Every category is withheld, so that nothing is compared."
    ratio, line = min(found, key=lambda pair: pair[0])
    return (
        f"Of the categories shown the least impact ratio is {ratio_text(ratio)}: {_name((line.sex, line.race))}. These are figures that "
        "the rule asks for; the page does not say what they are worth in law."
    )


def _rows(table: ImpactTable, chosen: frozenset[Place]) -> Iterator[Row]:
    lines = {(line.sex, line.race): line for line in table.lines}
    hidden = {*_hidden(table, chosen)}
    for category in _all(table):
        if category in hidden:
            yield Row((_name(category), *[WITHHELD] * 4), WITHHELD)
        else:
            line = lines[category]
            status = "highest" if table.top is not None and line.rate == table.top.rate else ""
            yield Row((_name(category), str(line.applicants), str(line.selected), rate_text(line.rate), ratio_text(line.ratio)), status)


def _csv(part: Part, chosen: frozenset[Place], outside: tuple[str, str]) -> Iterator[tuple[str, ...]]:
    """The rows of the CSV; no share of all people is in it."""
    for table in part.tables:
        lines = {(line.sex, line.race): line for line in table.lines}
        for row, category in zip(_rows(table, chosen), _all(table), strict=True):
            if row.status == WITHHELD:
                yield (table.name, *category, *[""] * 7, WITHHELD)
            else:
                line = lines[category]
                yield (table.name, *category, *row.cells[1:], exact(line.rate), exact(line.ratio), "", line.status)
        shown = ("", "") if WITHHELD in outside else outside
        yield (table.name, "", "", *shown, "", "", "", "", "", "unknown" if shown[0] else WITHHELD)


def _entry(table: ImpactTable) -> Mapping[str, Any]:
    lines = {(line.sex, line.race): line for line in table.lines}
    entries = []
    for sex, race in _all(table):
        entry: dict[str, Any] = {"sex": sex or None, "race_ethnicity": race or None, "status": WITHHELD}
        if (sex, race) in lines:
            line = lines[sex, race]
            entry |= {
                "applicants": line.applicants,
                "selected": line.selected,
                "rate": rate_text(line.rate),
                "impact_ratio": ratio_text(line.ratio),
                "status": "compared",
            }
        entries.append(entry)
    return {"table": table.name, "categories": entries}
