"""The publication that New York City's rule on automated employment decision tools asks for: page, CSV and summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.errors import shown
from fairaudit.publications.counts import Decisions
from fairaudit.publications.display import NONE, WITHHELD, exact_text, rate_text, ratio_text
from fairaudit.publications.ll144.people import Reading, Scores
from fairaudit.publications.ll144.stated import Stated, findings, last_day
from fairaudit.publications.ll144.tables import ImpactTable, Line
from fairaudit.publications.ll144.worst_case import WorstCase
from fairaudit.publications.publication import AMISS, Page, Publication, Section, Table
from fairaudit.publications.withholding import least_shown
from fairaudit.words import noun

__all__ = ["Part", "publish"]


HEADER = (
    "table",
    "sex",
    "race_ethnicity",
    "applicants",
    "selected",
    "rate",
    "impact_ratio",
    "rate_exact",
    "impact_ratio_exact",
    "share_exact",
    "status",
)

TITLES = {"sex": "Sex", "race": "Race or ethnicity", "intersection": "Sex and race or ethnicity"}

NOT_STATED = "not stated"


WORST = (
    "The rule does not ask for this. People of unknown category belong to some category. The worst case is the least impact ratio that "
    "any way of adding them to categories gives, among the categories that the table compares: those who were not selected all in one of "
    "them, those who were all in another. Where one of sex and race or ethnicity is known of somebody, this is not used."
)

RATIOS = (
    "Impact ratio: the rate of a category over the highest rate in the same table. Categories are those of EEO-1 component 1; of race or "
    "ethnicity, all but the first are of people who are not Hispanic or Latino."
)

LESS = (
    "The rule asks for the figures of all categories. Where some are withheld this page gives less than it asks for; whether that may be "
    "is for the reader to judge."
)

OF_SHOWN = (
    "Impact ratios are to the highest rate of the categories shown: one that is withheld may have a higher rate, and then each of these "
    "would be smaller. How many people are in a table, their shares, and what the unknown could change rest on all categories and are not "
    "shown."
)

ROUNDED = (
    "Every figure is computed from whole numbers of people and rounded half up for display alone; table.csv has the exact fractions. Where "
    "rounding would move a figure onto or across 0.8 or 1, it has more digits."
)


@dataclass(frozen=True)
class Part:
    """The tables of what people can be selected for.

    Attributes
    ----------
    favourable : tuple of str
        The decisions that count as selected.
    tables : tuple of ImpactTable
        Those of sex, of race, and of both, as far as they are recorded.
    label : str or None
        The class, where the tool sorts people into several.
    """

    favourable: tuple[str, ...]
    tables: tuple[ImpactTable, ...]
    label: str | None = None


@dataclass(frozen=True)
class Words:
    """What a rate is called."""

    rate: str
    selected: str
    means: str


def publish(
    stated: Stated,
    decisions: Decisions,
    reading: Reading,
    parts: Sequence[Part],
    scores: Scores | None = None,
    *,
    available: bool = False,
    remarks: Sequence[str] = (),
    least: int | None = None,
) -> Publication:
    """Write the tables of a certificate as the rule asks for.

    Parameters
    ----------
    stated : Stated
        What the auditor states.
    decisions : Decisions
        The counts of the certificate.
    reading : Reading
        What its labels mean.
    parts : sequence of Part
        The tables; of a tool that sorts into classes those of each class.
    scores : Scores, optional
        The median at which scores were cut.
    available : bool
        Whether each table has all people whose category in it is known.
    remarks : sequence of str
        What else is remarkable.
    least : int, optional
        The least count that is shown, where the tables withhold some: then nothing is said that rests on others.
    """
    words = _words(scores, classes=parts[0].label is not None)
    found = (*findings(stated), *_gaps(decisions, reading, parts, scores), *(reading.notes if least is None else ()), *remarks)
    found += (*_few(parts, excluded=stated.justification is not None),)
    classed = parts[0].label is not None
    page = Page(
        title=f"Results of a bias audit: {stated.tool}" if stated.tool else "Results of a bias audit",
        lead=_lead(parts, remarks=bool(found)),
        points=found,
        facts=(
            *_facts(stated, decisions, reading, parts, scores, available=available),
            *([] if least is None else [least_shown(least)]),
        ),
        sections=(
            *(_tables(part, words) for part in parts),
            *_exclusions(stated, parts),
            _worst(parts) if least is None else _less(parts),
            _reading_of(words, stated),
        ),
    )
    return Publication(
        page,
        rule="ll144",
        header=("class", *HEADER) if classed else HEADER,
        rows=tuple((part.label, *row) if part.label is not None else row for part in parts for row in _rows(part)),
        summary=_summary(stated, reading, parts, scores, found, available=available),
    )


def _words(scores: Scores | None, *, classes: bool) -> Words:
    """What rates are called: of scores, of classes, or of a selection."""
    if scores is not None:
        return Words("Scoring rate", "Above the median", "received a score above the median of all scores")
    if classes:
        return Words("Selection rate", "Assigned", "were assigned to the class")
    return Words("Selection rate", "Selected", "were selected")


def _gaps(decisions: Decisions, reading: Reading, parts: Sequence[Part], scores: Scores | None) -> Iterator[str]:
    """What the rule asks for and the certificate does not have."""
    if reading.sex is None or reading.race is None:
        there, absent = ("race or ethnicity", "sex") if reading.sex is None else ("sex", "race or ethnicity")
        yield (
            "The rule asks for three tables: of sex, of race or ethnicity, and of both together. "
            f"This page has that of {there} alone; {absent} is not in it."
        )
    without = [label for label in decisions.labels if parts[0].label is not None and label not in {part.label for part in parts}]
    if without:
        yield f"The rule asks for the tables of each class; there are none here of {', '.join(map(shown, without))}."
    if scores is not None and reading.left_out:
        yield (
            f"The rule's median is that of all who were scored. This one is of {int(scores.of):,} scores, without those of the "
            f"{reading.left_out:,} {noun(reading.left_out, 'person', 'people')} of whom a category is missing."
        )


def _name(line: Line) -> str:
    return _named(line.sex, line.race)


def _named(sex: str, race: str) -> str:
    return ", ".join(filter(None, (sex, race)))


def _counted(line: Line) -> str:
    return f"{_name(line)} ({line.selected:,} of {line.applicants:,})"


def _few(parts: Sequence[Part], *, excluded: bool) -> Iterator[str]:
    """Which figures rest on few people, of tables that say how many people there are."""
    for part in parts:
        of = f" of the class {shown(part.label)}" if part.label is not None else ""
        for table in part.tables:
            alike = [line for line in table.lines if table.top is not None and line.status == "compared" and line.rate == table.top.rate]
            if alike and not table.why and not table.nobody_selected and all(map(table.below_2_percent, alike)):
                people = sum(line.applicants for line in alike)
                share = rate_text(Fraction(people, table.applicants))
                yield (
                    f"The highest rate of the table {TITLES[table.name].lower()}{of} is that of {people:,} "
                    f"{noun(people, 'person', 'people')} ({share} of the table), {' and '.join(map(_name, alike))}; all its impact "
                    "ratios rest on them."
                )
    small = [
        f"{TITLES[table.name].lower()}: {'; '.join(_name(line) for line in table.lines if table.below_2_percent(line))}"
        for table in parts[0].tables
        if not table.why and any(map(table.below_2_percent, table.lines))
    ]
    if small and not excluded:
        yield (
            f"Categories below 2 % of the people in their table ({' | '.join(small)}) have impact ratios here. The rule lets an auditor "
            "leave them out with a justification: --exclude-below-2-percent and --justification."
        )


def _lead(parts: Sequence[Part], *, remarks: bool) -> str:
    """The least impact ratio of all tables, and whether something is amiss."""
    candidates = [(line, table, part) for part in parts for table in part.tables if (line := table.least()) is not None]
    amiss = AMISS if remarks else ""
    if not candidates:
        if parts[0].tables[0].why:
            return f"Every category is withheld, so that nothing is compared.{amiss}"
        return f"Nobody in the certificate has a known category, so there is nothing to compare.{amiss}"
    line, table, part = min(candidates, key=lambda found: found[0].ratio or Fraction(0))
    top = table.top
    against = f" against {_counted(top)}" if top is not None and line.ratio is not None and line.ratio < 1 else ""
    of = f" of the class {shown(part.label)}" if part.label is not None else ""
    among = "Of the categories shown the" if table.why else "The"
    return (
        f"{among} least impact ratio{of} is {ratio_text(line.ratio)}: {_counted(line)}{against}. These are figures that the rule asks for; "
        f"the page does not say what they are worth in law.{amiss}"
    )


def _facts(
    stated: Stated, decisions: Decisions, reading: Reading, parts: Sequence[Part], scores: Scores | None, *, available: bool = False
) -> Iterator[tuple[str, str]]:
    """The tool, the dates, the data, the unknown: in this order."""
    version = f", version {stated.tool_version}" if stated.tool_version else ""
    yield "Tool", f"{stated.tool}{version}" if stated.tool else NOT_STATED
    yield "Auditor", stated.auditor or NOT_STATED
    yield "Date of the latest bias audit", _day(stated.audit_date)
    yield "Distribution date", _day(stated.distribution_date)
    yield "Source and explanation of the data", stated.data_source or NOT_STATED
    yield "Kind of data", {"historical": "historical data", "test": "test data", None: NOT_STATED}[stated.data_kind]
    if stated.test_data:
        yield "Why test data, and how it was made", stated.test_data
    if stated.period:
        yield "Period of the data", f"{stated.period[0]} to {stated.period[1]}"
    yield "People of unknown category", _unknown_fact(parts[0].tables, available=available)
    if scores is not None:
        said = f"the median of all {int(scores.of):,} is {scores.median}, and above it is what is strictly greater"
        yield "Scores", f"column {shown(scores.column)}; {said}"
    elif parts[0].label is None:
        yield "Selected are people with the decision", " or ".join(map(shown, parts[0].favourable))
    else:
        yield "Classes", ", ".join(shown(part.label) for part in parts)
    for attribute in filter(None, (reading.sex, reading.race)):
        labels = {group[decisions.columns.index(attribute.column)] for group in decisions.groups}
        renamed = attribute.renamed(labels)
        if renamed:
            meant = "; ".join(f"{category}: {', '.join(map(shown, own))}" for category, own in renamed.items())
            yield f"Labels of column {shown(attribute.column)}", meant
        silent = sorted(label for label in labels if label in attribute.unknown)
        if silent:
            yield f"Unknown in column {shown(attribute.column)}", ", ".join(map(shown, silent))
    used = {attribute.column for attribute in (reading.sex, reading.race) if attribute}
    summed = [*(name for name in decisions.columns if name not in used), *decisions.contexts]
    if summed:
        yield "Summed over", ", ".join(map(shown, summed))


def _day(value: object) -> str:
    return NOT_STATED if value is None else str(value)


def _unknown_fact(tables: Sequence[ImpactTable], *, available: bool) -> str:
    if available and len(tables) > 1:
        counted = "; ".join(f"{TITLES[table.name].lower()}: {table.unknown.people:,}" for table in tables if table.unknown)
        return f"{counted} (each table has all whose category is known)"
    if tables[0].unknown is None:
        return WITHHELD
    people = tables[0].unknown.people
    both = " (the tables have the people of whom both sex and race or ethnicity are known)" if len(tables) > 1 else ""
    return f"{people:,}{both}"


def _tables(part: Part, words: Words) -> Section:
    shown_tables = tuple(
        Table(
            title=TITLES[table.name],
            head=("Category", "Applicants", words.selected, words.rate, "Impact ratio"),
            rows=(
                *(_row(line) for line in table.lines),
                *((_named(*category), *[WITHHELD] * 4) for category in table.withheld),
                ("Unknown, not in the table", *_unknown_counts(table), NONE, NONE),
            ),
            notes=tuple(_notes(table, words)),
        )
        for table in part.tables
    )
    return Section("Impact ratios" if part.label is None else f"Impact ratios of the class {shown(part.label)}", (), shown_tables)


def _unknown_counts(table: ImpactTable) -> tuple[str, str]:
    if table.unknown is None:
        return WITHHELD, WITHHELD
    return f"{table.unknown.people:,}", NONE if table.unknown.undecided else f"{table.unknown.selected:,}"


def _row(line: Line) -> tuple[str, ...]:
    ratio = "left out" if line.status == "excluded" else ratio_text(line.ratio)
    return _name(line), f"{line.applicants:,}", f"{line.selected:,}", rate_text(line.rate), ratio


def _notes(table: ImpactTable, words: Words) -> Iterator[str]:
    top = table.top
    if table.why:
        yield table.why
        return
    if top is None:
        yield "Nobody has a known category, so there is no rate."
        return
    alike = [_name(line) for line in table.lines if line.status == "compared" and line.rate == top.rate]
    if table.nobody_selected:
        yield "All rates that are compared are 0, so each is the highest and each impact ratio is 1."
    else:
        yield f"Impact ratios are rates over {rate_text(top.rate)}, the highest {words.rate.lower()}: {' and '.join(alike)}."
    yield f"{table.applicants:,} {noun(table.applicants, 'person is', 'people are')} in this table."
    excluded = [_name(line) for line in table.lines if line.status == "excluded"]
    if excluded:
        yield f"Below 2 % of these {table.applicants:,} and left out of the impact ratios: {'; '.join(excluded)}."
    if any(line.status == "empty" for line in table.lines):
        yield f"{NONE}: a category without people has no rate and no impact ratio."


def _exclusions(stated: Stated, parts: Sequence[Part]) -> Iterator[Section]:
    if stated.justification is None:
        return
    rows = tuple(
        (
            f"{f'{part.label}: ' if part.label is not None else ''}{_name(line)}",
            TITLES[table.name],
            f"{line.applicants:,}",
            f"{table.applicants:,}",
            rate_text(line.share),
            rate_text(line.rate),
        )
        for part in parts
        for table in part.tables
        for line in table.lines
        if line.status == "excluded"
    )
    head = ("Category", "Table", "Applicants", "People in the table", "Share", "Rate")
    nothing = () if rows else ("No category with people is below 2 % of its table, so nothing was left out.",)
    yield Section(
        "Categories left out of the impact ratios",
        (
            "The rule lets an auditor leave out a category that is less than 2 % of the data, here: of the people in the same table.",
            f"Justification: {stated.justification}",
            *nothing,
        ),
        (Table("Left out", head, rows),) if rows else (),
    )


def _worst(parts: Sequence[Part]) -> Section:
    """What the unknown could change."""
    rows: list[tuple[str, ...]] = []
    notes: list[str] = []
    for part in parts:
        of = f"{part.label}: " if part.label is not None else ""
        for table in part.tables:
            least, worst, every = table.least(), table.worst, table.worst_of_all
            name = f"{of}{TITLES[table.name]}"
            pair = (NONE, NONE) if worst is None or worst.pair is None else tuple(_name(table.lines[i]) for i in worst.pair)
            figures = (ratio_text(least.ratio if least else None), ratio_text(worst.ratio if worst else None))
            rows.append((name, _unknown_counts(table)[0], *figures, *pair))
            if every is not None and worst is not None and every.ratio < worst.ratio and every.pair is not None:
                low, high = (_name(table.lines[i]) for i in every.pair)
                notes.append(f"{name}, with the categories that are empty or left out: {ratio_text(every.ratio)} ({low} against {high}).")
    unknown = [table.unknown for part in parts for table in part.tables if table.unknown is not None]
    if not any(each.people for each in unknown):
        text = ("Nobody is outside the tables because a category is unknown.",)
        return Section("What the unknown could change", text)
    undecided = max(each.undecided for each in unknown)
    also = (
        (f"Whether {undecided:,} of them were selected is unknown, too; the worst case is over whatever it could be.",) if undecided else ()
    )
    return Section(
        "What the unknown could change",
        (WORST, *also),
        (
            Table(
                "Worst case",
                ("Table", "Unknown people", "Least impact ratio", "In the worst case", "Lowest", "Highest"),
                tuple(rows),
                tuple(notes),
            ),
        ),
    )


def _less(parts: Sequence[Part]) -> Section:
    """What is not said because it rests on categories that are withheld."""
    hidden = any(table.withheld for table in parts[0].tables)
    return Section("What is withheld", (*([LESS] if hidden else []), OF_SHOWN))


def _reading_of(words: Words, stated: Stated) -> Section:
    """How the tables are to be read."""
    limit = None if stated.audit_date is None else last_day(stated.audit_date)
    until = (
        ()
        if limit is None
        else (f"The rule does not let a tool be used when more than one year has passed since its audit; here: after {limit}.",)
    )
    return Section(
        "How to read the tables",
        (
            f"{words.rate}: of the people in a category, the share who {words.means}.",
            RATIOS,
            ROUNDED,
            *until,
        ),
    )


def _rows(part: Part) -> Iterator[tuple[str, ...]]:
    for table in part.tables:
        for line in table.lines:
            yield (
                table.name,
                line.sex,
                line.race,
                str(line.applicants),
                str(line.selected),
                rate_text(line.rate),
                ratio_text(line.ratio),
                exact_text(line.rate) or "",
                exact_text(line.ratio) or "",
                exact_text(line.share) or "",
                line.status,
            )
        for category in table.withheld:
            yield (table.name, *category, *[""] * 7, WITHHELD)
        if table.unknown is None:
            yield (table.name, *[""] * 9, WITHHELD)
        else:
            selected = "" if table.unknown.undecided else str(table.unknown.selected)
            yield (table.name, "", "", str(table.unknown.people), selected, *[""] * 5, "unknown")


def _summary(
    stated: Stated, reading: Reading, parts: Sequence[Part], scores: Scores | None, found: Sequence[str], *, available: bool
) -> Mapping[str, Any]:
    return {
        "stated": {
            "tool": stated.tool,
            "tool_version": stated.tool_version,
            "auditor": stated.auditor,
            "audit_date": _iso(stated.audit_date),
            "distribution_date": _iso(stated.distribution_date),
            "data_source": stated.data_source,
            "data_kind": stated.data_kind,
            "test_data_explanation": stated.test_data,
            "period": None if stated.period is None else {"start": str(stated.period[0]), "end": str(stated.period[1])},
            "justification": stated.justification,
        },
        "unknown_in": "available" if available else "complete",
        "columns": {
            "sex": None if reading.sex is None else reading.sex.column,
            "race_ethnicity": None if reading.race is None else reading.race.column,
        },
        "rate": "selection" if scores is None else "scoring",
        "median": None if scores is None else scores.median,
        "findings": list(found),
        "parts": [
            {
                "class": part.label,
                "favourable": list(part.favourable),
                "tables": [_table_summary(table) for table in part.tables],
            }
            for part in parts
        ],
    }


def _iso(value: object) -> str | None:
    return None if value is None else str(value)


def _table_summary(table: ImpactTable) -> Mapping[str, Any]:
    unknown = table.unknown
    whole = not table.why
    return {
        "table": table.name,
        **({"applicants": table.applicants} if whole else {}),
        "unknown": None if unknown is None else {"people": unknown.people, "selected": None if unknown.undecided else unknown.selected},
        "categories": [
            *(
                {
                    "sex": line.sex or None,
                    "race_ethnicity": line.race or None,
                    "applicants": line.applicants,
                    "selected": line.selected,
                    "rate": exact_text(line.rate),
                    "impact_ratio": exact_text(line.ratio),
                    **({"share": exact_text(line.share)} if whole else {}),
                    "status": line.status,
                }
                for line in table.lines
            ),
            *({"sex": sex or None, "race_ethnicity": race or None, "status": WITHHELD} for sex, race in table.withheld),
        ],
        **({"worst_case": _worst_text(table.worst), "worst_case_of_all_categories": _worst_text(table.worst_of_all)} if whole else {}),
    }


def _worst_text(worst: WorstCase | None) -> str | None:
    return None if worst is None else exact_text(worst.ratio)
