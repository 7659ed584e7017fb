"""`fairaudit inspect`: what is in a table, and a certify command to try."""

from __future__ import annotations

import argparse
import shlex
import shutil
from collections.abc import Sequence
from typing import Any

from fairaudit.cli import CORE
from fairaudit.cli.columns import Column, described, is_complete, looked_at, named, open_questions, suggested, warnings
from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format
from fairaudit.cli.source import add_lexicon, add_source
from fairaudit.tables.evaluations.extraction import FORMATS
from fairaudit.words import noun

DESCRIPTION = """\
List columns, levels and missing values of a table, and print a certify command to try. The table may be all that certify reads as a
log; whatever holds it counts, and of a column with more than 10,000 different values only the 10,000 most common are looked at."""

EPILOG = "exit codes: 0 done; 2 bad input"


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "inspect", run, CORE["inspect"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "table",
        metavar="TABLE",
        nargs="+",
        help="files (CSV, Parquet, JSON lines), logs of evaluations, or a database (sqlite:FILE, duckdb:FILE, delta:FOLDER, postgresql://…)",
    )
    rest = parser.add_argument_group("input and output")
    add_source(rest)
    rest.add_argument("--all", action="store_true", help="also list the paths of a log that are hardly a decision, group, context or unit")
    rest.add_argument("--log-format", choices=FORMATS, help="the format of a log of an evaluation, where its content does not say it")
    add_lexicon(rest)
    add_format(rest)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    survey, found, roles = looked_at(arguments)
    command, said = suggested(arguments, roles), (*roles.said, *open_questions(roles))
    size = f"{survey.rows} {noun(survey.rows, 'row')}, {len(found)} {noun(len(found), 'column')}"
    samples = survey.samples
    technical = frozenset[str]() if samples is None or arguments.all else samples.technical - named(roles)
    listed = [column for column in found if column.name not in technical]
    width = None if samples is None else shutil.get_terminal_size((140, 24)).columns
    return Answer(
        "inspect",
        sentence=f"{size}.",
        notes=survey.notes,
        result=lambda: {
            "rows": survey.rows,
            "columns": [_entry(column) for column in found],
            "said": list(said),
            "command": command,
            "complete": is_complete(roles),
        },
        text=lambda: _text(size, listed, len(technical), said, command, width, complete=is_complete(roles)),
    )


def _text(size: str, found: list[Column], folded: int, said: Sequence[str], command: list[str], line: int | None, *, complete: bool) -> str:
    from fairaudit.words import plain

    width = max((len(plain(column.name)) for column in found), default=0)
    room = None if line is None else max(line - width - 4, 40)
    lines = [size, ""]
    for column in found:
        lines.append(f"  {plain(column.name).ljust(width)}  {described(column, room)}")
        lines += [f"  {' ' * width}  ! {plain(warning)}" for warning in warnings(column)]
    lines += [
        *([f"  and {folded} more {noun(folded, 'path')}: --all"] if folded else []),
        "",
        *(f"Note: {plain(text)}." for text in said),
        *([""] if said else []),
        "A command to try (check which column is which):" if complete else "A command to complete, with a name for each word in capitals:",
        "",
    ]
    return "\n".join([*lines, f"  {plain(shlex.join(command))}"])


def _entry(column: Column) -> dict[str, Any]:
    return {
        "name": column.name,
        "levels": column.levels,
        "different": column.different,
        "missing": column.missing,
        "numeric": column.numeric,
        "fault": column.fault,
        "warnings": warnings(column),
    }
