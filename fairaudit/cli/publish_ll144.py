"""What `publish --rule ll144` asks for, and the publication that it makes of it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from fairaudit.cli.options import column_list

if TYPE_CHECKING:
    from fairaudit.publications.counts import Decisions, Source
    from fairaudit.publications.ll144.people import Scores
    from fairaudit.publications.ll144.stated import Stated
    from fairaudit.publications.publication import Publication

__all__ = ["OPTIONS", "add_options", "publication"]


OPTIONS = (
    "sex",
    "race",
    "categories",
    "unknown",
    "unknown_in",
    "class",
    "exclude_below_2_percent",
    "justification",
    "tool",
    "tool_version",
    "auditor",
    "audit_date",
    "distribution_date",
    "data_source",
    "data_kind",
    "test_data_explanation",
    "period",
)
"""The options that belong to this rule alone."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Declare them."""
    group = parser.add_argument_group("with --rule ll144, tables")
    group.add_argument("--sex", metavar="COL", help="the group column of sex")
    group.add_argument("--race", metavar="COL", help="the group column of race or ethnicity")
    group.add_argument(
        "--categories",
        metavar="MAP.toml",
        help='what labels mean, where they are not those of EEO-1: a table for each column, and under it "own label" = "category"',
    )
    group.add_argument(
        "--unknown-in",
        choices=("complete", "available"),
        help="who is in a table: people of whom both are known (complete, default), or all whose category in it is known (available)",
    )
    group.add_argument(
        "--class",
        metavar="LABEL[,LABEL]",
        action="append",
        help="of a tool that sorts people into several classes: the tables of each class (instead of --favourable)",
    )
    group.add_argument(
        "--exclude-below-2-percent",
        action="store_true",
        default=None,
        help="leave categories below 2 %% of a table out of its impact ratios; needs --justification",
    )
    group.add_argument("--justification", metavar="TEXT", help="why they are left out")
    said = parser.add_argument_group("with --rule ll144, what is stated")
    said.add_argument("--tool", metavar="TEXT", help="the name of the tool")
    said.add_argument("--tool-version", metavar="TEXT", help="its version")
    said.add_argument("--auditor", metavar="TEXT", help="who made the audit")
    said.add_argument("--audit-date", metavar="YYYY-MM-DD", help="the day of the latest audit")
    said.add_argument("--distribution-date", metavar="YYYY-MM-DD", help="the day on which this employer began to use the tool")
    said.add_argument("--data-source", metavar="TEXT", help="source and explanation of the data")
    said.add_argument("--data-kind", choices=("historical", "test"), help="which data it is")
    said.add_argument(
        "--test-data-explanation", metavar="TEXT", help="why there is no historical data, and how the test data was made; needed with it"
    )
    said.add_argument("--period", metavar="START/END", help="the first and the last day of the data")


def publication(source: Source, arguments: argparse.Namespace) -> tuple[Publication, str]:
    """Make the publication, and say what is to be known of small counts in it.

    Raises
    ------
    InputError
        If options are missing, do not go together, or say what the certificate does not have.
    """
    from fairaudit.errors import InputError
    from fairaudit.publications.counts import decisions_of
    from fairaudit.publications.ll144.page import Part, publish
    from fairaudit.publications.ll144.people import cut_at, people_of, read_labels, scores_of
    from fairaudit.publications.ll144.tables import shown_of, three_tables
    from fairaudit.publications.withholding import by_label, remark_on_small

    stated = _stated(arguments)
    decisions, scores = decisions_of(source), scores_of(source.document)
    if arguments.small is not None:
        decisions = by_label(decisions)
    available = arguments.unknown_in == "available"
    if arguments.small is not None and available:
        raise InputError(
            "--small goes with --unknown-in complete: tables of other people each would tell of those who are in one of them alone"
        )
    if arguments.small is not None and stated.justification is not None:
        raise InputError("--exclude-below-2-percent does not go with --small: shares of all people would tell those who are withheld")
    reading = read_labels(
        source.document,
        decisions,
        sex=arguments.sex,
        race=arguments.race,
        map_file=arguments.categories,
        unknown=column_list(arguments.unknown),
        available=available,
    )
    selections = _selections(source, decisions, scores, arguments)
    counts = [decisions.selected(favourable) for _, favourable in selections]
    counted = [people_of(reading, each) for each in counts]
    recorded = {"sex": reading.sex is not None, "race": reading.race is not None}
    remark, shown = "", None
    if arguments.small is None:
        remark = next(filter(None, map(remark_on_small, counts)), "")
    else:
        every = {*decisions.labels} == {label for _, favourable in selections for label in favourable}
        shown = shown_of(counted, arguments.small, every=every, **recorded)
    exclude = stated.justification is not None
    parts = [
        Part(favourable, three_tables(people, apart, available=available, exclude=exclude, shown=shown, **recorded), label)
        for (label, favourable), (people, apart) in zip(selections, counted, strict=True)
    ]
    remarks = (*cut_at(source.document), *_contradictions(source, stated))
    return publish(stated, decisions, reading, parts, scores, available=available, remarks=remarks, least=arguments.small), remark


def _contradictions(source: Source, stated: Stated) -> tuple[str, ...]:
    """Where the attestation, if there is one, states something else."""
    from fairaudit.publications.ll144.stated import contradictions

    return () if source.provenance is None else contradictions(stated, source.provenance.statement.stated)


def _stated(arguments: argparse.Namespace) -> Stated:
    from fairaudit.errors import InputError
    from fairaudit.publications.ll144.stated import Stated, day, period, stated_text

    if bool(arguments.exclude_below_2_percent) != (arguments.justification is not None):
        raise InputError(
            "--exclude-below-2-percent and --justification go together: the rule asks why categories are left out of the impact ratios"
        )
    return Stated(
        tool=stated_text(arguments.tool, "--tool"),
        tool_version=stated_text(arguments.tool_version, "--tool-version"),
        auditor=stated_text(arguments.auditor, "--auditor"),
        audit_date=day(arguments.audit_date, "--audit-date"),
        distribution_date=day(arguments.distribution_date, "--distribution-date"),
        data_source=stated_text(arguments.data_source, "--data-source"),
        data_kind=arguments.data_kind,
        test_data=stated_text(arguments.test_data_explanation, "--test-data-explanation"),
        period=period(arguments.period),
        justification=stated_text(arguments.justification, "--justification"),
    )


def _selections(
    source: Source, decisions: Decisions, scores: Scores | None, arguments: argparse.Namespace
) -> list[tuple[str | None, tuple[str, ...]]]:
    """What counts as selected: once, or for each class."""
    from fairaudit.errors import InputError, nearest, shown
    from fairaudit.publications.counts import favourable_of
    from fairaudit.tables.scores import ABOVE

    classes = column_list(getattr(arguments, "class"))
    given = column_list(arguments.favourable)
    if classes and given:
        raise InputError("--class and --favourable do not go together: what counts in the tables of a class is that class")
    if scores is not None and (classes or given not in ((), (ABOVE,))):
        raise InputError(
            f"the certificate is of scores above their median, so what counts is {shown(ABOVE)}; leave --class and --favourable away"
        )
    for label in classes:
        if label not in decisions.labels:
            raise InputError(f"--class: there is no decision {shown(label)}; {nearest(label, decisions.labels)}")
        if classes.count(label) > 1:
            raise InputError(f"--class names {shown(label)} twice")
    if classes:
        return [(label, (label,)) for label in classes]
    if scores is not None:
        return [(None, (ABOVE,))]
    found = favourable_of(source, given)
    return [(None, found if arguments.small is None else tuple(sorted(found)))]
