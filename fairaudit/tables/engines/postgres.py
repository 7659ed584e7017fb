"""PostgreSQL, by psycopg (extra `postgres`), in a transaction that can only read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from fairaudit.errors import InputError
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.engines.duckdb import readers
from fairaudit.tables.engines.request import SAME_ROWS, Request, attended, database_source
from fairaudit.tables.engines.survey import MOST, Survey, read_first
from fairaudit.tables.evaluations.paths import json_value
from fairaudit.tables.sql import RowsRead, Written, common_statement, count_statement, written
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column

__all__ = ["read", "survey"]

BATCH = 50_000  # rows that are fetched at a time: a few MB
NUMERIC = frozenset(("int2", "int4", "int8", "float4", "float8", "numeric"))
SETTINGS = "set local timezone = 'UTC'; set local datestyle = 'ISO, YMD'; set local extra_float_digits = 3"
TYPES = """
select oid, case when typcategory = 'S' then 'string' when typcategory = 'E' then 'enum' else typname end from pg_type where oid = any(%s)
"""


def read(url: str, request: Request) -> Tally:
    """Count the rows of a table, or of the result of a query, on a PostgreSQL server.

    What the URL leaves out comes from the environment (``PGPASSWORD``, ``PGSERVICE``, …) and ``~/.pgpass``, as libpq has it.
    """
    name = _name(url)
    with _opened(url, request) as (connection, source, types):
        for wanted in request.columns:
            column(dict.fromkeys(types, ()), wanted)
        kinds = {wanted: _writing(types[wanted], wanted) for wanted in request.columns}
        cut = {wanted for wanted in request.bins if types[wanted] in NUMERIC}
        kinds = {wanted: kind for wanted, kind in kinds.items() if wanted not in cut}
        bins = {wanted: request.bins[wanted] for wanted in cut}
        statement = count_statement(request.columns, source, "postgres", bins=bins, kinds=kinds, read=request.read)

        def work() -> Tally:
            with connection.cursor("fairaudit") as cursor:
                cursor.itersize = BATCH
                cursor.execute(statement)
                json_texts = [wanted for wanted in kinds if types[wanted] == "jsonb"]
                rows = RowsRead(cursor)
                counted = Tally.of(name, request.columns, rows, read=readers(kinds), equal=json_texts)
                return counted.conserving(rows.rows, "PostgreSQL", SAME_ROWS)

        tally = attended(work, connection.cancel_safe, request)
    if not len(tally):
        raise InputError(f"{name}: the table has no rows")
    return apply_bins(tally, request.bins, cut)


def survey(url: str, request: Request) -> Survey:
    """Look at every column of a table, or of the result of a query, on a PostgreSQL server."""
    with _opened(url, request) as (connection, source, types):

        def common(wanted: str) -> Iterable[Sequence[Any]]:
            kind = _writing(types[wanted], wanted)
            rows = list(connection.execute(common_statement(wanted, source, "postgres", MOST, kind)))
            return read_first(rows, wanted, kind)

        return attended(lambda: Survey.of(list(types), common), connection.cancel_safe, request)


def _writing(kind: str, name: str) -> Written:
    return Written("cast({} as text)", json_value) if kind == "jsonb" else written(kind, "postgres", name)


@contextmanager
def _opened(url: str, request: Request) -> Iterator[tuple[Any, str, dict[str, str]]]:
    """Connect in a transaction that cannot write, and say what is counted and which columns of which types it has."""
    try:
        import psycopg
    except ImportError:
        raise InputError("PostgreSQL needs psycopg; install fairaudit-certify[postgres]") from None
    source = database_source(request, "postgres")
    try:
        with psycopg.connect(url, connect_timeout=30, application_name="fairaudit") as connection:
            connection.read_only = True
            connection.execute(SETTINGS)
            # In binary form one statement goes to the server: a query that closes the parentheses around it cannot end the transaction.
            described = connection.execute(f"select * from {source} limit 0", binary=True).description or []  # noqa: S608
            named: dict[int, str] = dict(connection.execute(TYPES, [[entry.type_code for entry in described]]).fetchall())
            yield connection, source, {entry.name: named[entry.type_code] for entry in described}
    except psycopg.Error as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{_name(url)}: PostgreSQL says: {said[:400]}") from None


def _name(url: str) -> str:
    host = urlsplit(url)
    return f"{host.path.lstrip('/') or 'postgres'} on {host.hostname or 'the local server'}"
