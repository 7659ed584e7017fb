"""A report for the public whose small counts are withheld: whatever it says can be computed from the groups that it shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.inference.verdicts import verdict
from fairaudit.measures.limits import limit_text
from fairaudit.publications.circulation import is_small
from fairaudit.publications.comparison import sheets_by
from fairaudit.publications.counts import Counts, Decisions, Source, decisions_of, summed_of, worth_one
from fairaudit.publications.display import NONE, WITHHELD, rate_text, ratio_text
from fairaudit.publications.folder import page
from fairaudit.publications.publication import Page, Section, Table
from fairaudit.publications.withholding import (
    BESIDES,
    CHECKED,
    MOST_CELLS,
    WHO,
    Private,
    by_label,
    check_hidden,
    least_shown,
    parts_of,
    withholding_of,
)
from fairaudit.reports.endings import Form, form_of
from fairaudit.reports.markdown import code, prose, table
from fairaudit.reports.paper import print_page
from fairaudit.reports.words import clip, scope
from fairaudit.tables.preparation import uncounted
from fairaudit.words import THIS_TABLE, noun

__all__ = ["public_files", "public_markdown", "public_report", "text_of"]

NOT_SAID = "not said here: it depends on counts that this page does not show, and could tell them"

WORDS = {
    "within": "within the limit",
    "exceeds": "exceeds the limit",
    "inconclusive": "inconclusive",
    "depends": "depends on what was not recorded",
    "changed": "the ratio changed over time",
}


def public_report(source: Source, least: int) -> Page:
    """What may be said of a certificate in public without telling a count below the least one.

    Of the groups that are shown it says everything, of the others nothing but that they are there.  No total is published, and a verdict
    only where the groups shown determine it, or where no count of the whole table is small.  So what is published is a function of the
    counts of the groups shown, and of which these are, and for all that the figures say every small count could be any below the least one.
    Groups by two columns are shown with those by each of them, which a publication by a rule shows, too: both withhold the same.

    Parameters
    ----------
    source : Source
        The certificate, with its table beside it.
    least : int
        The least count that is published.

    Raises
    ------
    InputError
        If small counts could be guessed from the digest of the table, or the decisions are not worth 0 or 1.
    """
    check_hidden(source, least)
    decisions, counted = by_label(decisions_of(source)), sorted(worth_one(next(source.lines)) or ())
    if not counted:
        raise InputError(
            "--small needs decisions of which each is worth 0 or 1 to everybody, so that a group's mean is how often they are taken; "
            "the utility of this certificate is another"
        )
    counts = decisions.selected(counted)
    linked = len(counts.columns) == 2 and len(counts.groups) <= MOST_CELLS
    tables = sheets_by(counts.columns, []) if linked else [counts.columns]
    parts = parts_of(counts, tables, withholding_of(counts, tables, least, done="counted"))
    visible = parts[-1]
    rates = dict(zip(visible.groups, map(Fraction, visible.selected, visible.applicants), strict=True))
    burden = bool(source.document["subject"]["utility"].get("burden"))
    limits = [*_limits(source, least, rates, complete=not visible.withheld)]
    return Page(
        title=f"{source.document['subject']['columns']['decision']} by {', '.join(decisions.columns)}",
        lead=_lead(rates, len(counts.groups)),
        facts=(*_facts(source, decisions, counts, least, counted), *limits),
        sections=(
            Section("What each group gets", (), tuple(_table(part, burden=burden) for part in parts)),
            Section("What is withheld, and what this page says nothing about", _limits_of_the_page(least)),
        ),
        footer="These are figures of this table alone",
    )


def _lead(rates: Mapping[tuple[str, ...], Fraction], groups: int) -> str:
    said = f"Of {groups} {noun(groups, 'group')} {len(rates)} {'is' if len(rates) == 1 else 'are'} shown."
    if len(rates) < 2:
        return f"{said} Fewer than two leave nothing to compare."
    high, low = max(rates, key=lambda group: rates[group]), min(rates, key=lambda group: rates[group])
    if rates[high] == rates[low]:
        return f"{said} They have the same rate, {rate_text(rates[high])}."
    return (
        f"{said} {_name(high)} has the highest rate of these, {rate_text(rates[high])}, and {_name(low)} the lowest, "
        f"{rate_text(rates[low])}: {ratio_text(rates[low] / rates[high])} of it."
    )


def _name(group: tuple[str, ...]) -> str:
    return clip(", ".join(group))


def _facts(source: Source, decisions: Decisions, counts: Counts, least: int, counted: Sequence[str]) -> Iterator[tuple[str, str]]:
    yield "Decision", source.document["subject"]["columns"]["decision"]
    yield "Counted", f"{', '.join(map(shown, counted))} (of {', '.join(map(shown, decisions.labels))})"
    yield "Groups by", ", ".join(decisions.columns)
    yield from summed_of(decisions)
    if "unknown" in next(source.lines):
        people, taken = counts.unknown
        yield (
            "Group unknown",
            WITHHELD
            if is_small((taken, people - taken), least)
            else f"{people:,} more {noun(people, 'decision')}, {taken:,} of them counted, which are in no group",
        )
    yield least_shown(least)


def _limits(source: Source, least: int, rates: Mapping[tuple[str, ...], Fraction], *, complete: bool) -> Iterator[tuple[str, str]]:
    """Each limit with the verdict on it, or that it is not said."""
    document = source.document
    everything = not _any_small(source, least)
    for target in document["targets"]:
        known = everything or _determined(target, rates, complete=complete)
        said = f"{WORDS[target['verdict']]}, judged for {scope(target['judged'])}" if known else NOT_SAID
        yield "Limit", f"{limit_text(target['quantity'], target['unit'], Fraction(target['limit']))}: {said}"
    if not document["targets"]:
        yield "Limit", "none was set, so that there is no verdict"


def _any_small(source: Source, least: int) -> bool:
    """Whether any count of the table is small, those of labels and contexts that nobody sees included."""
    lines = source.lines
    header = next(lines)
    cells = 0
    for row in lines:
        cells += "unknown" not in row
        entries = [row["unknown"]] if "unknown" in row else [row["weights"], *row.get("truth", [])]
        if any(is_small(map(Fraction, entry), least) for entry in entries):
            return True
    return cells < len(header["groups"]) * len(header["contexts"])


def _determined(target: Mapping[str, Any], rates: Mapping[tuple[str, ...], Fraction], *, complete: bool) -> bool:
    """Whether the rates shown alone give the verdict: all of them are, or two of them are too far apart already."""
    if target["quantity"] != "global" or target["judged"] != THIS_TABLE or len(rates) < 2:
        return False
    if complete:
        return True
    high, low, limit = max(rates.values()), min(rates.values()), Fraction(target["limit"])
    if target["unit"] == "difference":
        return high - low > limit
    return verdict((high / low, high / low), **{f"max_{target['unit']}": limit}) == "exceeds"


def _table(visible: Counts, *, burden: bool) -> Table:
    rates = [Fraction(s, n) for s, n in zip(visible.selected, visible.applicants, strict=True)]
    best, end = ("lowest", min(rates, default=None)) if burden else ("highest", max(rates, default=None))
    rows: list[tuple[str, ...]] = [
        (_name(group), f"{n:,}", f"{s:,}", rate_text(rate), ratio_text(rate / end) if end else NONE)
        for group, n, s, rate in zip(visible.groups, visible.applicants, visible.selected, rates, strict=True)
    ]
    rows += [(_name(group), *[WITHHELD] * 4) for group in visible.withheld]
    notes = [visible.why]
    if visible.withheld and rates:
        notes.append(f"The {best} rate is that of the groups shown; a group that is withheld may have another.")
    return Table(
        f"Rates by {' and '.join(visible.columns)}",
        ("Group", "Decisions", "Counted", "Rate", f"Ratio to the {best} rate shown"),
        tuple(rows),
        tuple(notes),
    )


def _limits_of_the_page(least: int) -> tuple[str, ...]:
    return (
        (
            f"Of a group with fewer than {least} decisions of one kind this page shows no figure, and neither a total nor any other number "
            f"from which one could be computed: for all that its figures say, each count below {least} could be any from 0 to "
            f"{least - 1}. Which others are withheld besides may say more to whoever retraces how they were chosen."
        ),
        (
            "Contexts, intervals for the population, the pairs that differ most, and how many rows were left out are not shown at all: "
            "they rest on smaller counts."
        ),
        "No count was rounded or changed. Rates and ratios of the groups shown are rounded half up from the exact counts beside them.",
    )


def public_files(source: Source, least: int, paths: Sequence[str]) -> list[tuple[Path, list[bytes]]]:
    """The report for the public as files, of each what its ending says, for `write_together`.

    Raises
    ------
    InputError
        If the name of one says that the certificate itself is to be written.
    """
    forms = [form_of(path) for path in paths]
    for path, form in zip(paths, forms, strict=True):
        if form == "picture":
            raise InputError(f"{path} would be a picture of the exact figures, which --small withholds; name .html, .pdf or .md")
        if form == "json":
            raise InputError(
                f"{path} would be the certificate itself, which tells the counts that --small withholds; name .html, .pdf or .md"
            )
    made = public_report(source, least)
    texts = {written: _text(made, source, least, written) for written in dict.fromkeys("html" if form == "pdf" else form for form in forms)}
    return [
        (Path(path), [print_page(texts["html"]) if form == "pdf" else texts[form].encode("utf-8")])
        for path, form in zip(paths, forms, strict=True)
    ]


def text_of(source: Source, least: int, form: Form) -> str:
    """The report for the public as a page, or as markdown."""
    return _text(public_report(source, least), source, least, form)


def _text(made: Page, source: Source, least: int, form: Form) -> str:
    return public_markdown(made, source, least) if form == "markdown" else page(made, source, private(least))


def private(least: int) -> Private:
    """Who can check such a report."""
    given = "certificate.json --table certificate.table.jsonl"
    return Private(least, (f"fairaudit verify {given}", f"fairaudit report {given} --small {least} -o page.html"))


def public_markdown(made: Page, source: Source, least: int) -> str:
    """The report for the public as markdown."""
    lines = [f"## {prose(made.title)}", prose(made.lead), CHECKED]
    lines.append("\n".join(f"* {prose(f'{name}: {text}')}" for name, text in made.facts))
    for section in made.sections:
        lines += [f"### {section.title}", *section.paragraphs]
        for found in section.tables:
            lines += [
                f"#### {prose(found.title)}",
                table(tuple(map(prose, found.head)), [(code(row[0]), *row[1:]) for row in found.rows]),
                *found.notes,
            ]
    prepared = uncounted(source.document["subject"])
    if prepared:
        lines += ["### What was done before it was counted", "\n".join(f"* {prose(text)}" for text in prepared), BESIDES]
    digest = source.document["subject"]["table"]["sha256"]
    commands = "\n".join(f"    {line}" for line in private(least).commands)
    lines += ["### Who can check this", *WHO, commands, f"Salted digest of the table, SHA-256: `{digest}`"]
    return "\n\n".join(lines) + "\n"
