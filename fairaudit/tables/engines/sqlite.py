"""SQLite, by the standard library; the file is opened for reading only."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from urllib.parse import quote

from fairaudit.errors import InputError
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.engines.request import SAME_ROWS, Request, attended, database_source
from fairaudit.tables.engines.survey import MOST, Survey
from fairaudit.tables.sql import RowsRead, common_statement, count_statement, identifier, written_name
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column

__all__ = ["read", "survey", "tables"]


def read(path: str, request: Request) -> Tally:
    """Count the rows of a table, or of the result of a query, of an SQLite file."""
    with _opened(path, request) as (connection, source, known):
        # A name that is no column would silently be a text, so names are looked up first.
        for name in request.columns:
            column(dict.fromkeys(known, ()), name)
        cut = {name for name in request.bins if _numeric(connection, source, name)}
        statement = count_statement(request.columns, source, "sqlite", bins={name: request.bins[name] for name in cut}, read=request.read)

        def work() -> Tally:
            rows = RowsRead(connection.execute(statement))
            return Tally.of(Path(path).name, request.columns, rows).conserving(rows.rows, "SQLite", SAME_ROWS)

        tally = attended(work, connection.interrupt, request)
    if not len(tally):
        raise InputError(f"{path.removeprefix('//')}: the table has no rows")
    return apply_bins(tally, request.bins, cut)


def survey(path: str, request: Request) -> Survey:
    """Look at every column of a table, or of the result of a query, of an SQLite file."""
    with _opened(path, request) as (connection, source, known):

        def work() -> Survey:
            return Survey.of(known, lambda name: connection.execute(common_statement(name, source, "sqlite", MOST)))

        return attended(work, connection.interrupt, request)


def tables(path: str) -> list[str]:
    """Names of the tables and views of an SQLite file."""
    path = path.removeprefix("//")
    with _connected(path) as connection:
        found = connection.execute("select name from sqlite_master where type in ('table', 'view') and substr(name, 1, 7) <> 'sqlite_'")
        return sorted(written_name(name) for (name,) in found)


@contextmanager
def _opened(path: str, request: Request) -> Iterator[tuple[sqlite3.Connection, str, list[str]]]:
    """Open a file for reading, and say what is counted and which columns it has."""
    source = database_source(request, "sqlite")
    with _connected(path.removeprefix("//")) as connection:
        yield connection, source, [entry[0] for entry in connection.execute(f"select * from {source} limit 0").description]  # noqa: S608


@contextmanager
def _connected(path: str) -> Iterator[sqlite3.Connection]:
    """Open a file for reading, and make one sentence of what SQLite complains about."""
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file")
    try:
        with closing(sqlite3.connect(f"file:{quote(path)}?mode=ro", uri=True, check_same_thread=False)) as connection:
            yield connection
    except sqlite3.Error as error:
        raise InputError(f"{path}: SQLite cannot read it: {error}") from None
    except UnicodeDecodeError:  # a damaged schema, of which SQLite's own message quotes bytes
        raise InputError(f"{path}: SQLite cannot read it: names in it are not UTF-8") from None


def _numeric(connection: sqlite3.Connection, source: str, name: str) -> bool:
    """Whether a column holds numbers only; SQLite types values, not columns."""
    held = identifier(name, "sqlite")
    found = connection.execute(f"select 1 from {source} where typeof({held}) not in ('integer', 'real', 'null') limit 1").fetchone()  # noqa: S608
    return found is None
