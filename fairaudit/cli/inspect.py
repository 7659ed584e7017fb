"""`fairaudit inspect`: what is in a table, and a certify command to try."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format
from fairaudit.cli.source import add_source, progress
from fairaudit.tables.sources import PASSWORD

if TYPE_CHECKING:
    from fairaudit.audits.roles import Roles
    from fairaudit.tables.engines.survey import Seen

DESCRIPTION = """\
List columns, levels and missing values of a table, and print a certify command to try. The table may be all that certify reads as a
log; whatever holds it counts, and of a column with more than 10,000 different values only the 10,000 most common are looked at."""

MISSING_WORDS = {"na", "n/a", "nan", "null", "none", "unknown", "?", "-", "."}


@dataclass(frozen=True)
class _Column:
    """What a column looks like."""

    name: str
    levels: dict[str, int]
    different: int
    missing: int
    numeric: bool
    fault: str


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "inspect", run, "list the columns of a table and suggest a certify command", DESCRIPTION)
    parser.add_argument(
        "table",
        metavar="TABLE",
        nargs="+",
        help="files (CSV, Parquet, JSON lines) or a database (sqlite:FILE, duckdb:FILE, delta:FOLDER, postgresql://…)",
    )
    rest = parser.add_argument_group("input and output")
    add_source(rest)
    add_format(rest)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.audits.roles import proposed
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.logs import survey_log

    given = arguments.table if len(arguments.table) > 1 else arguments.table[0]
    where = {
        "engine": arguments.engine,
        "table": arguments.database_table,
        "query": arguments.query,
        "memory": arguments.memory,
        "skip": arguments.skip,
    }
    try:
        with progress() as report:
            survey = survey_log(given, **where, report=report)
    except InputError as error:
        raise InputError(PASSWORD.sub(r"\1:…", str(error))) from None
    comma = any("separated by" in note for note in survey.notes)
    found = [_look(seen, decimal_comma=comma) for seen in survey.columns]
    command = _suggest(arguments, proposed(survey.columns, survey.rows, decimal_comma=comma))
    size = f"{survey.rows} rows, {len(found)} columns"
    return Answer(
        "inspect",
        sentence=f"{size}.",
        notes=survey.notes,
        result=lambda: {"rows": survey.rows, "columns": [_entry(column) for column in found], "command": command},
        text=lambda: _text(size, found, command),
    )


def _text(size: str, found: list[_Column], command: list[str]) -> str:
    from fairaudit.words import plain

    width = max(len(plain(column.name)) for column in found)
    lines = [size, ""]
    for column in found:
        lines.append(f"  {plain(column.name).ljust(width)}  {_describe(column)}")
        lines += [f"  {' ' * width}  ! {plain(warning)}" for warning in _warnings(column)]
    lines += ["", "A command to try (check which column is which):", ""]
    return "\n".join([*lines, f"  {plain(shlex.join(command))}"])


def _entry(column: _Column) -> dict[str, Any]:
    return {
        "name": column.name,
        "levels": column.levels,
        "different": column.different,
        "missing": column.missing,
        "numeric": column.numeric,
        "fault": column.fault,
        "warnings": _warnings(column),
    }


def _look(seen: Seen, *, decimal_comma: bool) -> _Column:
    from fairaudit.audits.roles import as_number

    numeric = bool(seen.levels) and all(as_number(text, decimal_comma=decimal_comma) is not None for text in seen.levels)
    return _Column(seen.name, seen.levels, seen.different, seen.missing, numeric, seen.fault)


def _describe(column: _Column) -> str:
    from fairaudit.words import plain

    if column.fault:
        return plain(f"no labels: {column.fault}")
    absent = f"; {column.missing} missing" if column.missing else ""
    if not column.levels:
        return f"empty{absent}"
    if column.numeric and column.different > 12:
        return f"numbers, {column.different} different{absent}"
    shown = ", ".join(f"{plain(label)[:40]} ({count})" for label, count in islice(column.levels.items(), 8))
    more = f", … ({column.different} levels)" if column.different > 8 else ""
    return f"{shown}{more}{absent}"


def _warnings(column: _Column) -> list[str]:
    from fairaudit.tables.labels import spellings
    from fairaudit.tables.preparation import said

    found = () if column.numeric and column.different > 12 else spellings([(column.name, column.levels)])
    warnings = [f"{text.partition(': ')[2]} (--fold-labels, or --map FILE)" for text in said({"spellings": found})]
    unset = [label for label in column.levels if " ".join(label.lower().split()) in MISSING_WORDS]
    warnings += [f"'{label}' counts as a level; only empty cells are missing" for label in unset]
    return warnings[:5]


def _suggest(arguments: argparse.Namespace, found: Roles) -> list[str]:
    """The words of a certify command that fits the columns as far as their names and labels say."""
    paths = [PASSWORD.sub(r"\1", path) for path in arguments.table]
    words = ["fairaudit", "certify", *(f"./{path}" if path.startswith("-") else path for path in paths)]
    edges = {name: ":" + ",".join(map(str, cut)) for name, cut in found.bins.items()}
    for option, value in (
        ("--engine", "" if arguments.engine == "auto" else arguments.engine),
        ("--table", arguments.database_table or ""),
        ("--query", arguments.query or ""),
        ("--memory", arguments.memory or ""),
        ("--skip", str(arguments.skip or "")),
        ("--decision", found.decision or "COL"),
        ("--group", ",".join(_quoted(name) + edges.get(name, "") for name in found.group) or "COL"),
        ("--context", ",".join(map(_quoted, found.context))),
        ("--count", found.count or ""),
        ("--probability", found.probability or ""),
        ("--weight", found.weight or ""),
        ("--unit", _quoted(found.unit or "")),
        ("--utility", _quoted(found.utility) if found.decision else "DECISION"),
        ("--missing", "drop" if found.missing else ""),
    ):
        if value:
            words += [f"{option}={value}"] if value.startswith("-") else [option, value]
    return [*words, *(["--burden"] if found.burden else [])]


def _quoted(label: str) -> str:
    """Quote a name or label as `--group` and `--utility` read it, where that is needed."""
    needed = label != label.strip() or any(c in label for c in ',="\r\n')
    return '"' + label.replace('"', '""') + '"' if needed else label
