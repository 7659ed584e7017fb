"""`fairaudit tally`: count a part of a log once, so that certify adds it to the others without reading it again."""

from __future__ import annotations

import argparse
import shlex
from typing import Any

from fairaudit.cli import CORE
from fairaudit.cli.destinations import refuse_output
from fairaudit.cli.keeping import UNCOUNTED, count, quoted
from fairaudit.cli.options import add_command, column_roles
from fairaudit.cli.output import Answer, add_format
from fairaudit.cli.source import add_source, option, progress
from fairaudit.words import noun

DESCRIPTION = """\
Count the equal rows of a log, or of a part of one (a day, a branch), by the columns that an audit will ask for, and write the counts
to a Parquet file. `certify` with --count takes any number of such files together: the certificate is that of the whole log, byte for
byte, and nothing that was counted before is read again. `certify --keep` does both in one step. The log is whatever certify reads,
except logs of evaluations."""

EPILOG = """\
exit codes: 0 done; 2 bad input

examples:
  fairaudit tally monday.csv --decision answer --group sex,age:18,65 --context department -o monday.parquet
  fairaudit certify monday.parquet tuesday.parquet --decision answer --group sex,age --context department --utility yes --count n"""

ELSEWHERE = {
    **UNCOUNTED,
    "missing": "a tally keeps missing labels as they are; give it to certify",
    "unknown": "a tally keeps all labels as they are; give it to certify",
    "fold_labels": "a tally keeps all labels as they are; give it to certify",
    "map": "a tally keeps all labels as they are; give it to certify",
    "where": "rows are chosen by a query of a database (--query), or before the log is written",
}
"""Options of certify that a tally does not have, and what to do instead."""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "tally", run, CORE["tally"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "table",
        metavar="TABLE",
        nargs="+",
        help="files (CSV, Parquet, JSON lines), or a database (sqlite:FILE, duckdb:FILE, postgresql://…)",
    )
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help="where the counts go: FILE.parquet")
    roles = parser.add_argument_group("columns (several: separate with commas, or repeat the option)")
    decided = roles.add_mutually_exclusive_group(required=True)
    decided.add_argument("--decision", metavar="COL", help="what was decided")
    decided.add_argument("--score", metavar="COL", help="a column of numbers, which certify cuts in two")
    roles.add_argument("--group", metavar="COL", action="append", required=True, help="sensitive attribute")
    roles.add_argument(
        "--context", metavar="COL", action="append", help="what may legitimately matter; age:18,30,65 cuts numbers into intervals"
    )
    roles.add_argument("--truth", metavar="COL", help="true label: what should have been decided")
    roles.add_argument("--count", metavar="NAME", default="n", help="what the column of counts is called (default: n)")
    for name in ELSEWHERE:
        parser.add_argument(option(name), nargs="?", const=True, action="append", help=argparse.SUPPRESS)
    rest = parser.add_argument_group("input and output")
    add_source(rest)
    add_format(rest)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.tallies import check_ending
    from fairaudit.words import plain

    for name, why in ELSEWHERE.items():
        if getattr(arguments, name) is not None:
            raise InputError(f"{option(name)} does not go with tally: {why}")
    check_ending(arguments.output)
    refuse_output(arguments.output, arguments.table)
    with progress() as told:
        made = count(arguments, arguments.table, arguments.output, told)
    words = _certify(arguments)
    sentence = (
        f"{made.rows:,} {noun(made.rows, 'row')}, {len(made):,} of them different, "
        f"{'is' if made.rows == 1 else 'are'} counted in {arguments.output}."
    )
    return Answer(
        "tally",
        sentence=sentence,
        notes=made.notes,
        result=lambda: {"file": arguments.output, "rows": made.rows, "different": len(made), "command": words},
        text=lambda: f"{plain(sentence)}\n\nNext: {plain(shlex.join(words))}",
    )


def _certify(arguments: argparse.Namespace) -> list[str]:
    """The words of the command that certifies the counts, alone or with others."""
    words = ["fairaudit", "certify", arguments.output]
    group, context = (",".join(map(quoted, column_roles(given).names)) for given in (arguments.group, arguments.context))
    named = {"decision": arguments.decision, "score": arguments.score, "group": group}
    named |= {"context": context, "truth": arguments.truth, "count": arguments.count}
    for name, value in named.items():
        words += [option(name), value] if value else []
    return [*words, *(["--above-median"] if arguments.score else ["--utility", "DECISION"])]
