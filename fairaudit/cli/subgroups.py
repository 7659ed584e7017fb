"""`fairaudit subgroups`: who fares most unequally beside everybody else, and a certificate that no subgroup is worse."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.destinations import add_output, check_output, write_outputs
from fairaudit.cli.options import add_command, confidence_option
from fairaudit.cli.output import Answer, add_format, aligned
from fairaudit.cli.source import add_label_options, add_number_form, add_source, progress, reading_of

if TYPE_CHECKING:
    from fairaudit.audits.subgroups import Subgroup, Subgroups

DESCRIPTION = """\
Find the subgroups of a log that fare most unequally beside everybody else: all combinations of up to --depth attribute values with enough
rows are compared, and the certificate proves that none is worse than those listed."""

EPILOG = """\
exit codes: 0 within the target, or no target; 1 the target is exceeded; 2 bad input; 3 inconclusive

examples:
  fairaudit subgroups log.csv --decision hired --attributes sex,age:18,30,65,race --utility yes -o certificate.json
  fairaudit subgroups admissions.csv --decision Admit --attributes Gender,Dept --count Freq --utility Admitted --depth 2 --max-ratio 0.8"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "subgroups", run, CORE["subgroups"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "table", metavar="LOG", nargs="+", help="files (CSV, Parquet, JSON lines) or a database (sqlite:FILE, duckdb:FILE, postgresql://…)"
    )
    roles = parser.add_argument_group("columns (several: separate with commas, or repeat the option)")
    roles.add_argument("--decision", metavar="COL", help="what was decided")
    roles.add_argument(
        "--attributes",
        dest="group",
        metavar="COL",
        action="append",
        required=True,
        help="what subgroups share; age:18,30,65 cuts numbers into intervals",
    )
    roles.add_argument("--count", metavar="COL", help="how often the row occurred")
    worth = parser.add_argument_group("utility (what a decision is worth to the person)")
    kind = worth.add_mutually_exclusive_group(required=True)
    kind.add_argument("--utility", metavar="SPEC", help="decision[=number],…; decisions that are not listed are worth 0")
    kind.add_argument("--utility-column", metavar="COL", help="column with the utility of each row; --decision may then be left out")
    worth.add_argument("--burden", action="store_true", help="the utility counts a burden")
    family = parser.add_argument_group("which subgroups")
    family.add_argument("--depth", metavar="D", type=int, default=3, help="how many attributes a subgroup names at most (3)")
    least = family.add_mutually_exclusive_group()
    least.add_argument("--min-share", metavar="Q", help="the least share of all rows that a subgroup has (0.01)")
    least.add_argument("--min-rows", metavar="N", type=int, help="the least number of rows of a subgroup, instead")
    family.add_argument("--top", metavar="K", type=int, default=10, help="how many to list (10)")
    target = parser.add_argument_group("target (decided exactly)")
    target.add_argument(
        "--max-ratio", metavar="Q", help="limit on the ratio of a subgroup and the rest, either way: 5/4, or 0.8 (least/greatest)"
    )
    target.add_argument(
        "--confidence", metavar="C", help="of intervals that hold for all subgroups at once (0.95), or 'none' to judge the log itself"
    )
    rest = parser.add_argument_group("input and output")
    add_label_options(rest)
    add_source(rest)
    add_number_form(rest)
    add_output(rest)
    add_format(rest)
    parser.set_defaults(context=None, probability=None, weight=None)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.audits.subgroups import find_subgroups
    from fairaudit.model.utility import Utility, utility_values

    check_output(arguments, undrawn="subgroups")
    reading = reading_of(arguments)
    given = None if arguments.utility is None else Utility(utility_values(arguments.utility, "--utility"))
    with progress() as told:
        found = find_subgroups(
            arguments.table,
            reading,
            given,
            depth=arguments.depth,
            min_share=arguments.min_share,
            min_rows=arguments.min_rows,
            max_ratio=arguments.max_ratio,
            confidence=confidence_option(arguments.confidence),
            top=arguments.top,
            burden=arguments.burden,
            embed_table=False if arguments.no_table else None,
            report=told,
        )
    written = write_outputs((found.certificate, arguments.output)) if arguments.output else []
    return Answer(
        "certify-subgroups",
        verdict=found.verdict,
        sentence=found.sentence,
        notes=found.notes,
        result=lambda: found.certificate.document,
        text=lambda: _text(found, written),
        code=found.exit_code,
    )


def _text(found: Subgroups, written: list[str]) -> str:
    from fairaudit.reports.text import prepared_text, written_text
    from fairaudit.words import plain

    lines = [_headline(found), "", plain(found.sentence), "", *_table(found), ""]
    least = f"with at least {found.least_rows:,} of {found.rows:,} rows"
    up_to = f"of up to {found.depth} attribute{'s' * (found.depth > 1)}"
    lines.append(f"Every subgroup {up_to} {least} was compared with everybody else; none is more unequal.")
    if found.confidence is not None:
        lines.append(f"The intervals hold for all {found.conjunctions:,} conceivable ones at once, if the rows are independent draws.")
    if found.log.preparation:
        lines += ["", prepared_text(found.log.preparation)]
    if written:
        lines += ["", written_text(written)]
    return "\n".join(lines)


def _headline(found: Subgroups) -> str:
    from fairaudit.measures.limits import limit_text

    if found.limit is None:
        return "NO TARGET was set; these are the exact figures of the log."
    of = "of the log" if found.confidence is None else "of the population"
    said = {"within": "no subgroup exceeds", "exceeds": "a subgroup exceeds", "inconclusive": "not decided, for want of rows:"}[
        found.verdict
    ]
    return f"{found.verdict.upper()} {of}: {said} the target {limit_text('subgroup', 'ratio', found.limit)}."


def _table(found: Subgroups) -> list[str]:
    """The subgroups, the most unequal first; long ones go on below themselves, so that the table fits a screen."""
    from fairaudit.words import COLUMNS, approximate, place, plain, wrapped

    def interval(one: Subgroup) -> list[str]:
        if found.confidence is None or one.interval is None:
            return []
        return [f"{approximate(one.interval[0], 'down')} to {approximate(one.interval[1], 'up')}"]

    head = ["subgroup", "rows", "mean", "rest", "ratio", *([] if found.confidence is None else [f"at {approximate(found.confidence)}"])]
    rows = [
        [
            plain(place(one.conditions)) + (f" (and {len(one.same)} more with the same rows)" if one.same else ""),
            f"{one.rows:,}",
            approximate(one.mean),
            approximate(one.rest),
            approximate(one.ratio),
            *interval(one),
        ]
        for one in found.found
    ]
    figures = sum(2 + max(len(row[number]) for row in (head, *rows)) for number in range(1, len(head)))
    lines = [head]
    for name, *others in rows:
        first, *more = wrapped(name, 2, max(30, COLUMNS - 2 - figures))
        lines += [[first, *others], *([line] + [""] * len(others) for line in more)]
    return aligned(lines, "  ").splitlines()
