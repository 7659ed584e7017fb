"""PostgreSQL, by psycopg (extra `postgres`), in a transaction that can only read."""

from __future__ import annotations

from urllib.parse import urlsplit

from fairaudit.columns import Tally, column
from fairaudit.exact import InputError
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.engines import Request, attended, database_source
from fairaudit.tables.sql import count_statement

__all__ = ["read"]

BATCH = 50_000
NUMERIC = frozenset((20, 21, 23, 700, 701, 1700))  # int8, int2, int4, float4, float8, numeric


def read(url: str, request: Request) -> Tally:
    """Count the rows of a table, or of the result of a query, on a PostgreSQL server.

    What the URL leaves out comes from the environment (``PGPASSWORD``, ``PGSERVICE``, …) and ``~/.pgpass``, as libpq has it.
    """
    try:
        import psycopg
    except ImportError:
        raise InputError("PostgreSQL needs psycopg; install fairaudit-certify[postgres]") from None
    source = database_source(request, "postgres")
    host = urlsplit(url)
    name = f"{host.path.lstrip('/') or 'postgres'} on {host.hostname or 'the local server'}"
    try:
        with psycopg.connect(url, connect_timeout=30, application_name="fairaudit") as connection:
            connection.read_only = True
            described = connection.execute(f"select * from {source} limit 0").description or []  # noqa: S608
            types = {entry.name: entry.type_code for entry in described}
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
    except psycopg.Error as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{name}: PostgreSQL says: {said[:400]}") from None
    if not len(tally):
        raise InputError(f"{name}: the table has no rows")
    return apply_bins(tally, request.bins, cut)
