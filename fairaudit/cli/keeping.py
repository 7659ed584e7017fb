"""A log that is counted, and its counts kept: alone (`fairaudit tally`), or certified with those of other logs (`certify --keep`)."""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fairaudit.cli.destinations import check_output
from fairaudit.cli.options import column_roles
from fairaudit.cli.source import extraction_from, option, progress
from fairaudit.words import noun

if TYPE_CHECKING:
    from fairaudit.tables.engines.request import Report
    from fairaudit.tables.tally import Tally

__all__ = ["UNCOUNTED", "Kept", "add_keep", "count", "keeping", "quoted", "refuse_beside_keep"]

ELSEWHERE = ("from_monitor", "example", "print_sql", "slots", "group_probability", "probability", "weight", "wide", "total")
"""Options whose tables are no log that could be counted."""

UNCOUNTED = {
    "unit": "rows of one sampling unit may lie in several files; certify the log itself",
    "utility_column": "a tally counts labels and holds no other numbers; name the decision, and give --utility to certify",
}
"""Options of certify about columns that a tally does not have, and what to do instead."""

BLOCK = 1 << 24  # bytes that are copied at a time


@dataclass(frozen=True)
class Kept:
    """Counts that are written with the certificate, or not at all.

    Attributes
    ----------
    path : Path
        Where they go.
    held : Path
        Where they are until then.
    notes : tuple of str
        What was counted.
    """

    path: Path
    held: Path
    notes: tuple[str, ...]

    def blocks(self) -> Iterator[bytes]:
        """What the file holds."""
        with self.held.open("rb") as file:
            while block := file.read(BLOCK):
                yield block


def add_keep(rest: argparse._ArgumentGroup) -> None:
    """Declare the option."""
    rest.add_argument(
        "--keep",
        metavar="FILE",
        help="count the log, keep its counts in FILE.parquet, and certify it with all tables that are such counts already",
    )


@contextmanager
def keeping(arguments: argparse.Namespace) -> Iterator[Kept]:
    """Count the log among the tables that are named, and let the options name its tally, with the others, in its place.

    Raises
    ------
    InputError
        If the options do not go together, there is no log, or it cannot be counted.
    """
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.tallies import COUNT, check_ending

    for name, why in UNCOUNTED.items():
        if getattr(arguments, name):
            raise InputError(f"{option(name)} does not go with --keep: {why}")
    check_ending(arguments.keep)
    check_output(arguments)
    tallies, logs = _apart(arguments.table)
    arguments.count = arguments.count or COUNT
    with tempfile.TemporaryDirectory(prefix="fairaudit-") as folder:
        held = os.path.join(folder, Path(arguments.keep).name)  # noqa: PTH118
        with progress() as told:
            made = count(arguments, logs, held, told)
        for name in ("group", "context"):  # whose intervals were cut while they were counted
            named = map(quoted, column_roles(getattr(arguments, name)).names)
            setattr(arguments, name, [",".join(named)] if getattr(arguments, name) else None)
        arguments.table, arguments.engine, arguments.skip = [*tallies, held], "auto", 0
        arguments.database_table = arguments.query = arguments.encoding = None
        try:
            yield Kept(Path(arguments.keep), Path(held), _notes(made, logs, arguments.keep))
        except InputError as error:
            if held not in str(error):
                raise
            raise InputError(str(error).replace(held, arguments.keep)) from None


def count(arguments: argparse.Namespace, source: Sequence[str], output: str, told: Report | None) -> Tally:
    """Count a log by the columns that the options name, and write the counts to a file.

    Raises
    ------
    InputError
        If no decision or no group is named, or the log cannot be counted.
    """
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.tallies import tally
    from fairaudit.tables.values import names

    group, context, decision = column_roles(arguments.group), column_roles(arguments.context), arguments.decision or arguments.score
    if decision is None or not group.names:
        role = "decision" if decision is None else "group"
        raise InputError(f"no {role} column was named; use --{role} COL")
    where = {name: getattr(arguments, name) for name in ("engine", "query", "memory", "skip", "encoding", "count", "same_content")}
    columns, bins = (decision, *group.names, *context.names, *names(arguments.truth)), {**group.edges, **context.edges}
    return tally(source, output, columns, bins=bins, table=arguments.database_table, report=told, **where)


def refuse_beside_keep(arguments: argparse.Namespace) -> None:
    """Refuse what is no log that could be counted.

    Raises
    ------
    InputError
        If it is asked for.
    """
    from fairaudit.errors import InputError
    from fairaudit.tables.sources import is_audit_file

    asked = {name: getattr(arguments, name) for name in ELSEWHERE} | dict(extraction_from(vars(arguments)).asked)
    for name, value in asked.items():
        if value:
            raise InputError(f"{option(name)} does not go with --keep, which counts a log of one decision per row")
    if is_audit_file(arguments.table):
        raise InputError("--keep does not go with an audit file; name the log and the columns as options")


def _apart(table: str | Sequence[str]) -> tuple[list[str], list[str]]:
    """The tallies among tables, and the others."""
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.paths import expand
    from fairaudit.tables.engines.tally_files import is_tally
    from fairaudit.tables.sources import is_database

    named = [table] if isinstance(table, str) else list(table)
    far = [name for name in named if is_database(name) and not os.path.exists(name)]  # noqa: PTH110
    found = expand([name for name in named if name not in far])
    tallies = [path for path in found if is_tally(path)]
    logs = [*far, *(path for path in found if path not in tallies)]
    if not logs:
        raise InputError("--keep FILE is where the counts of a log go, and every file that is named is a tally; name the log, too")
    return tallies, logs


def _notes(made: Tally, logs: Sequence[str], kept: str) -> tuple[str, ...]:
    from fairaudit.tables.sources import source_name

    return (
        *made.notes,
        (
            f"{made.rows:,} {noun(made.rows, 'row')} of {source_name(logs)}, of which {len(made):,} "
            f"{'is' if len(made) == 1 else 'are'} different, are kept in {kept}"
        ),
    )


def quoted(name: str) -> str:
    """Quote a name as `--group` reads it, where that is needed."""
    return '"' + name.replace('"', '""') + '"' if name != name.strip() or any(c in name for c in ',:"\r\n') else name
