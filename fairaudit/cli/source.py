"""Where a command's table comes from: its options, columns with intervals, progress on a terminal, and the reader that fits."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fairaudit.model.law import Law
    from fairaudit.tables.csv import CsvTable
    from fairaudit.tables.engines.request import Report
    from fairaudit.tables.tally import Tally

PASSWORD = re.compile(r"(?<=://)([^/@:]*):[^/@]*(?=@)")

DATABASE = re.compile(r"(sqlite|duckdb|delta):|[a-z][a-z0-9+.-]*://")


def add_source(parser: argparse._ArgumentGroup) -> None:
    """Declare the options."""
    parser.add_argument(
        "--engine",
        choices=("auto", "duckdb", "python", "spark"),
        default="auto",
        help="who reads files (default: DuckDB, if they are large)",
    )
    parser.add_argument("--table", dest="database_table", metavar="NAME", help="of a database: the table that holds the log")
    parser.add_argument("--query", metavar="SQL", help="of a database: a query whose result is the log")
    parser.add_argument("--memory", metavar="SIZE", help="what DuckDB may use before it spills to disk, such as 2GB")


def add_label_options(parser: argparse._ArgumentGroup) -> None:
    """Declare the options that merge labels."""
    parser.add_argument(
        "--fold-labels",
        action="store_true",
        help="merge labels that differ in case, blanks or Unicode form alone, under the most frequent spelling",
    )
    parser.add_argument("--map", metavar="FILE", help='write labels anew: TOML with a table for each column, "old" = "new"')


def with_labels(arguments: argparse.Namespace, table: CsvTable | Tally, columns: Sequence[str]) -> CsvTable | Tally:
    """Merge labels as the options say.

    Raises
    ------
    InputError
        If the map is not one of these columns and labels.
    """
    from fairaudit.tables.labels import merge_labels, read_label_map

    if not (arguments.fold_labels or arguments.map):
        return table
    label_map = None if arguments.map is None else read_label_map(arguments.map)
    merged: CsvTable | Tally = merge_labels(table, columns, fold=arguments.fold_labels, label_map=label_map)
    return merged


def source_name(source: Any) -> str:
    """Name a table in a message; passwords in URLs are left out.

    Examples
    --------
    >>> source_name("postgresql://me:secret@host/db"), source_name(["a.csv", "b.csv"])
    ('postgresql://me:…@host/db', 'a.csv and 1 more')
    """
    if isinstance(source, list):
        return f"{source[0]} and {len(source) - 1} more"
    return PASSWORD.sub(r"\1:…", source) if isinstance(source, str) else str(getattr(source, "name", source))


def is_database(source: Any) -> bool:
    """Whether a table is named by a URL."""
    return isinstance(source, str) and DATABASE.match(source) is not None


def read_source(
    arguments: argparse.Namespace,
    table: Any,
    columns: Sequence[str],
    edges: dict[str, tuple[str, ...]],
    numeric: Sequence[str],
    most: int | None = None,
    by: Sequence[str] = (),
) -> CsvTable | Tally:
    """Read the table that the options describe: the counted rows of a log, or a table of counts or probabilities as it is.

    Raises
    ------
    InputError
        If it cannot be read, or a column is not there.
    """
    from fairaudit.errors import InputError
    from fairaudit.tables.csv import CsvTable, read_csv
    from fairaudit.tables.engines.request import ManyRowsError
    from fairaudit.tables.values import column

    try:
        if isinstance(table, CsvTable):
            found = table
        elif (arguments.count is None and arguments.probability is None) or isinstance(table, list) or not _is_csv(table):
            return _counted(arguments, table, columns, edges, numeric, most, by)
        else:
            found = read_csv(table)
        if edges:
            raise InputError(f"intervals such as {next(iter(edges))}:{','.join(next(iter(edges.values())))} go with a log")
        if arguments.database_table is not None or arguments.query is not None:
            raise InputError("--table and --query go with a database")
    except ManyRowsError:
        raise
    except InputError as error:
        raise InputError(PASSWORD.sub(r"\1:…", str(error))) from None
    try:
        for name in columns:
            column(found, name)
        return found.with_numbers(numeric)
    except InputError as error:
        raise InputError(f"{found.name}: {error}") from None


def _counted(
    arguments: argparse.Namespace,
    table: Any,
    columns: Sequence[str],
    edges: dict[str, tuple[str, ...]],
    numeric: Sequence[str],
    most: int | None,
    by: Sequence[str],
) -> Tally:
    """Count the rows of a log, or of a table of counts that is no CSV file."""
    from fairaudit.tables.engines.logs import read_log

    with progress() as report:
        tally = read_log(
            table,
            columns,
            bins=edges,
            engine=arguments.engine,
            table=arguments.database_table,
            query=arguments.query,
            memory=arguments.memory,
            report=report,
            meanwhile=_warm,
            most=most,
            by=by,
        )
    return _with_numbers(tally, numeric)


def _with_numbers(tally: Tally, columns: Sequence[str]) -> Tally:
    """Turn decimal commas into points where commas do not separate columns."""
    import numpy as np

    from fairaudit.errors import shown
    from fairaudit.tables.csv import decimal_commas

    levels, notes = dict(tally.levels), list(tally.notes)
    if not any("separated by" in note for note in notes):
        return tally
    for name in columns:
        at = tally.codes[name]
        found = decimal_commas(name, levels[name], lambda level, at=at: tally.locate(int(np.flatnonzero(at == level)[0])))  # type: ignore[misc]
        if found is not None:
            levels[name] = found
            notes.append(f"the numbers in column {shown(name)} have decimal commas")
    return replace(tally, levels=levels, notes=tuple(notes))


def _is_csv(table: str) -> bool:
    """Whether a table is a file of delimited text, as far as its name and first bytes say."""
    from pathlib import Path

    from fairaudit.errors import InputError
    from fairaudit.tables.engines.paths import form

    if is_database(table) and not Path(table).exists():
        return False
    try:
        return Path(table).is_fifo() or form(table) == "csv"
    except (InputError, OSError, ValueError):
        return not any(character in table for character in "*?[")  # the reader says what is wrong with it


def _warm() -> None:
    """Load what comes after the table while an engine reads it."""
    import fairaudit.audits.certify  # noqa: F401


@contextmanager
def progress() -> Iterator[Report | None]:
    """Say on a terminal how far long work is, and clear the line afterwards."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    started, written = time.monotonic(), False

    def report(share: float | None, rows: int | None) -> None:
        nonlocal written
        if time.monotonic() - started > 1:
            said = f"{rows:,} rows" if rows is not None else f"{share:.0%}" if share is not None else f"{time.monotonic() - started:.0f} s"
            sys.stderr.write(f"\r\x1b[Kcounting: {said} (Ctrl-C stops)")
            sys.stderr.flush()
            written = True

    try:
        yield report
    finally:
        if written:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def law_from_options(
    arguments: argparse.Namespace,
    table: CsvTable | Tally,
    decision: str,
    groups: tuple[str, ...],
    contexts: tuple[str, ...],
    unit: tuple[str, ...] = (),
    truth: str | None = None,
) -> Law:
    """Read the law that the options describe."""
    from dataclasses import replace

    from fairaudit.model.law import Law

    if arguments.count is not None:
        columns: dict[str, Any] = {"decision": decision, "group": groups, "context": contexts, "truth": truth}
        law = Law.from_counts(table, **columns, count=arguments.count, missing=arguments.missing)
    elif arguments.probability is not None:
        law = Law.from_probabilities(
            table,
            decision=decision,
            group=groups,
            context=contexts,
            probability=arguments.probability,
            weight=arguments.weight,
            missing=arguments.missing,
        )
    else:
        law = Law.from_log(table, decision=decision, group=groups, context=contexts, missing=arguments.missing, unit=unit, truth=truth)
    return replace(law, notes=(*table.notes, *law.notes))
