"""`fairaudit inspect`: what is in a table, and a certify command to try."""

from __future__ import annotations

import argparse
import re
import shlex
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format
from fairaudit.cli.source import add_source, progress
from fairaudit.tables.sources import PASSWORD

if TYPE_CHECKING:
    from fairaudit.tables.engines.survey import Seen

DESCRIPTION = """\
List columns, levels and missing values of a table, and print a certify command to try. The table may be all that certify reads as a
log; whatever holds it counts, and of a column with more than 10,000 different values only the 10,000 most common are looked at."""

HINTS = {
    "count": r"n|freq(uency)?|counts?|num(ber)?|total|cases|size",
    "probability": r"p|pr|prob(ability|abilities)?|share|rate",
    "weight": r"w|weights?|mass|population|prior",
    "decision": r".*(decision|outcome|admi(t|ssion)|hired?|accept|approv|select|cho(sen|ice)|recommend|result|label|predict|grant).*|u|y",
    "group": r".*(gender|sex|race|ethnic|group|name|age|religion|nationality|disab|minority|origin|placebo).*|a|s",
}
MISSING_WORDS = {"na", "n/a", "nan", "null", "none", "unknown", "?", "-", "."}
MANY = 50


@dataclass(frozen=True)
class _Column:
    """What a column looks like."""

    name: str
    levels: dict[str, int]
    different: int
    missing: int
    numeric: bool
    fault: str

    def is_a(self, role: str) -> bool:
        """Whether the name suggests the role."""
        return re.fullmatch(HINTS[role], self.name.strip().lower()) is not None


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
    command = _suggest(arguments, found)
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
    from fairaudit.errors import InputError
    from fairaudit.exact.rationals import parse_rational

    def number(text: str) -> bool:
        try:
            parse_rational(text.replace(",", ".", 1) if decimal_comma else text)
        except InputError:
            return False
        return True

    return _Column(seen.name, seen.levels, seen.different, seen.missing, bool(seen.levels) and all(map(number, seen.levels)), seen.fault)


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


def _suggest(arguments: argparse.Namespace, found: list[_Column]) -> list[str]:
    """The words of a certify command that fits the columns as far as their names say."""
    left = list(found)

    def take(role: str, numeric: bool) -> _Column | None:
        for column in left:
            if column.is_a(role) and column.numeric >= numeric and column.levels:
                left.remove(column)
                return column
        return None

    count = take("count", numeric=True)
    probability = None if count else take("probability", numeric=True)
    weight = take("weight", numeric=True) if probability else None
    groups = [column for column in left if column.is_a("group") and 2 <= column.different <= 10 * MANY]
    for column in groups:
        left.remove(column)
    usable = [column for column in left if 2 <= column.different <= MANY and not (column.numeric and column.different > 12)]
    decision = next((column for column in usable if column.is_a("decision")), None) or next(
        (column for column in sorted(usable, key=lambda c: c.different)), None
    )
    usable = [column for column in usable if column is not decision and not column.numeric]
    if not groups and usable:
        groups = [usable.pop(0)]
    paths = [PASSWORD.sub(r"\1", path) for path in arguments.table]
    words = ["fairaudit", "certify", *(f"./{path}" if path.startswith("-") else path for path in paths)]
    for option, value in (
        ("--engine", "" if arguments.engine == "auto" else arguments.engine),
        ("--table", arguments.database_table or ""),
        ("--query", arguments.query or ""),
        ("--memory", arguments.memory or ""),
        ("--skip", str(arguments.skip or "")),
        ("--decision", decision.name if decision else "COL"),
        ("--group", ",".join(_quoted(column.name) for column in groups) or "COL"),
        ("--context", ",".join(_quoted(column.name) for column in usable)),
        ("--count", count.name if count else ""),
        ("--probability", probability.name if probability else ""),
        ("--weight", weight.name if weight else ""),
        ("--utility", _quoted(_good(decision)) if decision else "DECISION"),
    ):
        if value:
            words += [f"{option}={value}"] if value.startswith("-") else [option, value]
    return words


def _good(decision: _Column) -> str:
    """The level that most likely is the good one."""
    good = re.compile(r"(yes|true|1|admit\w*|accept\w*|hired?|approv\w*|granted|selected|chosen|first|pass\w*|positive)", re.IGNORECASE)
    return next((label for label in decision.levels if good.fullmatch(label.strip())), next(iter(decision.levels)))


def _quoted(label: str) -> str:
    """Quote a name or label as `--group` and `--utility` read it, where that is needed."""
    needed = label != label.strip() or any(c in label for c in ',="\r\n')
    return '"' + label.replace('"', '""') + '"' if needed else label
