"""PostgreSQL, by psycopg (extra `postgres`), in a transaction that can only read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from fairaudit.columns import Tally, column
from fairaudit.exact import InputError
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.engines import Request, attended, database_source
from fairaudit.tables.engines.survey import MOST, Survey
from fairaudit.tables.sql import common_statement, count_statement

__all__ = ["read", "survey"]

BATCH = 50_000
NUMERIC = frozenset((20, 21, 23, 700, 701, 1700))  # int8, int2, int4, float4, float8, numeric
UNEQUAL = frozenset((114, 142, 600, 602, 604))  # json, xml, point, path, polygon


def read(url: str, request: Request) -> Tally:
    """Count the rows of a table, or of the result of a query, on a PostgreSQL server.

    What the URL leaves out comes from the environment (``PGPASSWORD``, ``PGSERVICE``, …) and ``~/.pgpass``, as libpq has it.
    """
    name = _name(url)
    with _opened(url, request) as (connection, source, types):
        for wanted in request.columns:
            column(dict.fromkeys(types, ()), wanted)
        cut = {wanted for wanted in request.bins if types[wanted] in NUMERIC}
        statement = count_statement(request.columns, source, "postgres", bins={wanted: request.bins[wanted] for wanted in cut})

        def work() -> Tally:
            with connection.cursor("fairaudit") as cursor:
                cursor.itersize = BATCH
                cursor.execute(statement)
                return Tally.of(name, request.columns, cursor)

        tally = attended(work, connection.cancel_safe, request)
    if not len(tally):
        raise InputError(f"{name}: the table has no rows")
    return apply_bins(tally, request.bins, cut)


def survey(url: str, request: Request) -> Survey:
    """Look at every column of a table, or of the result of a query, on a PostgreSQL server."""
    with _opened(url, request) as (connection, source, types):

        def common(wanted: str) -> list[Any]:
            if types[wanted] in UNEQUAL:
                raise InputError("a value of such a type equals no other; a label is a text, a number or a truth value")
            return list(connection.execute(common_statement(wanted, source, "postgres", MOST)))

        return attended(lambda: Survey.of(list(types), common), connection.cancel_safe, request)


@contextmanager
def _opened(url: str, request: Request) -> Iterator[tuple[Any, str, dict[str, int]]]:
    """Connect for reading, and say what is counted and which columns of which types it has."""
    try:
        import psycopg
    except ImportError:
        raise InputError("PostgreSQL needs psycopg; install fairaudit-certify[postgres]") from None
    source = database_source(request, "postgres")
    try:
        with psycopg.connect(url, connect_timeout=30, application_name="fairaudit") as connection:
            connection.read_only = True
            described = connection.execute(f"select * from {source} limit 0").description or []  # noqa: S608
            yield connection, source, {entry.name: entry.type_code for entry in described}
    except psycopg.Error as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{_name(url)}: PostgreSQL says: {said[:400]}") from None


def _name(url: str) -> str:
    host = urlsplit(url)
    return f"{host.path.lstrip('/') or 'postgres'} on {host.hostname or 'the local server'}"
