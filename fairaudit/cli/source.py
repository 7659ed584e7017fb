"""Where a command's table comes from: its options, columns with intervals, progress on a terminal, and the reader that fits."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, get_args

from fairaudit.cli.output import rewritten
from fairaudit.tables.evaluations.extraction import FORMATS, RECIPES, Errors, MissingSamples

if TYPE_CHECKING:
    from fairaudit.audits.reading import Access, Reading
    from fairaudit.model.law import Law
    from fairaudit.tables.engines.request import Report
    from fairaudit.tables.evaluations.extraction import Extraction


def add_source(parser: argparse._ArgumentGroup) -> None:
    """Declare the options."""
    parser.add_argument(
        "--engine",
        choices=("auto", "duckdb", "python", "spark"),
        default="auto",
        help="who reads files (default: DuckDB, if they are large)",
    )
    parser.add_argument(
        "--table", dest="database_table", metavar="NAME", help="of a database: the table that holds the log; of a spreadsheet: the sheet"
    )
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="how many lines stand above the header, such as a title")
    parser.add_argument("--encoding", metavar="NAME", help="how the characters of a text are written, if not UTF-8: cp1252, latin-1, …")
    parser.add_argument("--query", metavar="SQL", help="of a database: a query whose result is the log")
    parser.add_argument(
        "--same-content",
        choices=("refuse", "accept"),
        default="refuse",
        help="files with the same content, packed or not: refuse (default), or count each; one file under two names is always refused",
    )
    parser.add_argument("--memory", metavar="SIZE", help="what DuckDB may use before it spills to disk, such as 2GB")


def add_samples(parser: argparse.ArgumentParser) -> None:
    """Declare what is asked of logs of evaluations beyond columns."""
    samples = parser.add_argument_group("logs of evaluations, JSON lines and nested Parquet (columns are paths such as metadata.race)")
    samples.add_argument(
        "--log-format",
        choices=FORMATS,
        help="the format of a log of an evaluation, where its content does not say it (monitor's is the form of lines)",
    )
    samples.add_argument(
        "--extract", metavar="REGEX", help="the decision is the group of exactly one match in the answer, such as '^\\s*(yes|no)\\b'"
    )
    samples.add_argument(
        "--options",
        metavar="LABELS",
        help="the decision is the one of these, such as yes,no, that an answer in words clearly chooses; of others, and of prose, none",
    )
    samples.add_argument("--join", metavar="FILE:COLUMN", help="rows of another file that belong to samples by a column of that name")
    samples.add_argument("--where", metavar="PATH=VALUE", action="append", help="only samples with this value count")
    samples.add_argument(
        "--errors",
        choices=get_args(Errors),
        default="refuse",
        help="samples without an answer: refuse (default), leave them out and state them, or let them have meant anything",
    )
    samples.add_argument(
        "--missing-samples", choices=get_args(MissingSamples), default="refuse", help="a log with fewer samples than it should have"
    )
    samples.add_argument(
        "--recipe",
        metavar="NAME[:PATH]",
        help=f"make the rows of a known data set as its authors count them ({', '.join(RECIPES)}); PATH is where the answers stand",
    )


def add_table_form(roles: argparse._ArgumentGroup) -> None:
    """Declare the columns of numbers that a table may have; without them it is a log."""
    form = roles.add_mutually_exclusive_group()
    form.add_argument("--count", metavar="COL", help="how often the row occurred")
    form.add_argument("--probability", metavar="COL", help="P(decision | context, group)")
    roles.add_argument("--weight", metavar="COL", help="P(context, group) up to a factor, with --probability")
    add_number_form(roles)


def add_number_form(roles: argparse._ArgumentGroup) -> None:
    """Declare how the texts of numbers are written."""
    roles.add_argument("--decimal", choices=(".", ","), help="the decimal mark of numbers in texts, where 1.306 or 1,306 could be either")
    roles.add_argument(
        "--thousands", metavar="MARK", help="what separates groups of three digits in numbers: . or , or ' or space (1.306 is then 1306)"
    )
    roles.add_argument(
        "--number-sign",
        metavar="SIGN",
        action="append",
        help="signs that numbers bear: %% (51.2%% is 0.512), or a currency such as € or EUR",
    )


def add_score(roles: argparse._ArgumentGroup) -> None:
    """Declare the column of scores that takes the place of the decision."""
    roles.add_argument(
        "--score", metavar="COL", help="instead of --decision: a column of numbers; a score is above the cut (worth 1), or not above"
    )
    cut = roles.add_mutually_exclusive_group()
    cut.add_argument(
        "--above-median", action="store_const", const="median", dest="above", help="with --score: cut at the median of all that are counted"
    )
    cut.add_argument("--above", metavar="NUMBER", help="with --score: cut at a number, which was fixed before the scores were seen")


def add_wide(roles: argparse._ArgumentGroup) -> None:
    """Declare the columns of counts of a table that has several in a row."""
    roles.add_argument(
        "--wide",
        metavar="SPEC",
        help="columns of counts, one for each decision: yes=admitted,no=rejected; of groups in the header yes/men=men_yes,no/men=men_no,… "
        "(--group then says what the groups are)",
    )
    roles.add_argument(
        "--total",
        metavar="COL",
        help="with --wide: the column of all decisions (of groups in the header: men=COL,women=COL), or what shares are of: 1, or 100 for "
        "percentages",
    )


def add_lexicon(group: argparse._ArgumentGroup) -> None:
    """Declare the option that adds labels to the lexicon of those that look undecided."""
    group.add_argument(
        "--lexicon", metavar="FILE", help="labels, one a line, that look undecided besides those known, such as pending, offen, en attente"
    )


def lexicon_of(arguments: argparse.Namespace) -> tuple[str, ...]:
    """The labels of `--lexicon`."""
    from fairaudit.tables.label_meaning import read_lexicon

    return () if arguments.lexicon is None else read_lexicon(arguments.lexicon)


def add_label_options(rest: argparse._ArgumentGroup, *, unknown: bool = False) -> None:
    """Declare what becomes of labels that are missing, or spelt in several ways, and which of them name no group."""
    others = "; unknown: of group columns, the group is unknown; undecided: the decision may have been any" if unknown else ""
    rest.add_argument(
        "--missing",
        choices=("error", "drop", "group", *(("unknown", "undecided") if unknown else ())),
        default="error",
        help=f"what to do with empty labels: refuse (default), leave the row out, make them a level of their own{others}",
    )
    if unknown:
        rest.add_argument(
            "--unknown",
            metavar="LABEL",
            action="append",
            help="labels of group columns that name no group, such as n/a,declined: targets are judged whoever these are",
        )
        rest.add_argument(
            "--unknown-share",
            metavar="GROUP=LOW,HIGH",
            action="append",
            help="between which shares of them are of a group, in every context and over all (of several columns: f/white=0.1,0.2; none of "
            "the groups: *=0,0)",
        )
    rest.add_argument(
        "--fold-labels",
        action="store_true",
        help="merge labels that differ in case, blanks or Unicode form alone, under the most frequent spelling",
    )
    rest.add_argument("--map", metavar="FILE", help='write labels anew: TOML with a table for each column, "old" = "new"')


def option(name: str) -> str:
    """An option as it is written on the command line.

    Examples
    --------
    >>> option("fold_labels")
    '--fold-labels'
    """
    return f"--{name.replace('_', '-')}"


def access_of(arguments: argparse.Namespace) -> Access:
    """How the table is reached, as the options say."""
    from fairaudit.audits.reading import Access
    from fairaudit.cli.options import column_list
    from fairaudit.tables.number_form import number_form

    given = vars(arguments)
    signs = column_list(given.get("number_sign"))
    return Access(
        arguments.engine,
        arguments.database_table,
        arguments.query,
        arguments.memory,
        arguments.skip,
        extraction_from(given),
        evaluations="log_format" in arguments,
        same_content=arguments.same_content,
        encoding=arguments.encoding,
        form=number_form(given.get("decimal"), given.get("thousands"), signs, spelled=option),
    )


def extraction_from(given: Mapping[str, Any]) -> Extraction:
    """What is asked of an evaluation log, as the options say; those that the command does not have are left out."""
    from fairaudit.tables.evaluations.extraction import NAMES, extraction_of

    return extraction_of(**{name: given[name] for name in NAMES if given.get(name) is not None})


def fill_recipe(arguments: argparse.Namespace) -> None:
    """Give the columns of a recipe the roles that are not named otherwise."""
    if arguments.recipe is None:
        return
    from fairaudit.tables.evaluations.recipes.known import recipe_of

    recipe, given = recipe_of(arguments.recipe), vars(arguments)
    for name, value in (("decision", recipe.decision), ("group", [recipe.group]), ("context", [recipe.context]), ("unit", [*recipe.unit])):
        if not given.get(name):
            given[name] = value
    if given.get("utility") is None and given.get("utility_column") is None:
        given["utility"] = recipe.utility


def reading_of(arguments: argparse.Namespace) -> Reading:
    """What the columns are and what is done to them first, as the options say; those that the command does not have are left out.

    Raises
    ------
    InputError
        If no decision or no group column was named.
    """
    from fairaudit.audits.reading import Reading, refuse_half_a_score
    from fairaudit.cli.options import column_list, column_roles
    from fairaudit.errors import InputError
    from fairaudit.tables.labels import read_label_map
    from fairaudit.tables.scores import score_cut
    from fairaudit.tables.wide import wide_of

    given = vars(arguments)
    wide = wide_of(given.get("wide"), given.get("total"), spelled=option)
    above, score = given.get("above"), given.get("score")
    spelled = {"above": "--above-median or --above NUMBER"}
    refuse_half_a_score(score, above, arguments.decision, lambda name: spelled.get(name, option(name)))
    decision = arguments.decision or score or given.get("utility_column") or ("decision" if wide is not None else None)
    if decision is None:
        raise InputError("no decision column was named; use --decision COL")
    group, context = column_roles(arguments.group), column_roles(arguments.context)
    if not group.names:
        raise InputError("no group column was named; use --group COL")
    return Reading(
        decision=decision,
        group=group.names,
        context=context.names,
        bins={**group.edges, **context.edges},
        truth=given.get("truth"),
        count=arguments.count,
        probability=arguments.probability,
        weight=arguments.weight,
        unit=column_list(given.get("unit")),
        utility_column=given.get("utility_column"),
        missing=arguments.missing,
        unknown=column_list(given.get("unknown")),
        fold_labels=arguments.fold_labels,
        label_map=None if arguments.map is None else read_label_map(arguments.map),
        access=access_of(arguments),
        spelled=option,
        wide=wide,
        above=None if above is None else score_cut(above, "--above"),
    )


def law_from_options(arguments: argparse.Namespace) -> Law:
    """Read the law that the options describe, with progress on a terminal."""
    from fairaudit.audits.reading import read_law

    reading = reading_of(arguments)
    with progress() as report:
        return read_law(arguments.table, reading, report=report)


@contextmanager
def progress() -> Iterator[Report | None]:
    """Say on a terminal how far long work is, and clear the line afterwards."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    started = time.monotonic()
    with rewritten(after=1.0) as say:

        def report(share: float | None, rows: int | None) -> None:
            said = f"{rows:,} rows" if rows is not None else f"{share:.0%}" if share is not None else f"{time.monotonic() - started:.0f} s"
            say(f"counting: {said} (Ctrl-C stops)")

        yield report
