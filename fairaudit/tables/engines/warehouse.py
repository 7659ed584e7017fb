"""Warehouses (BigQuery, Snowflake, Trino and others) by ibis (extra `ibis`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, TypeVar
from urllib.parse import urlsplit

from fairaudit.errors import FairauditError, InputError, nearest, shown
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.engines.request import SAME_ROWS, Request, attended, database_source
from fairaudit.tables.engines.survey import MOST, Survey
from fairaudit.tables.label_text import native_values
from fairaudit.tables.sql import DIALECTS, RowsRead, common_statement, count_statement
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column

__all__ = ["read", "survey"]

T = TypeVar("T")


def read(url: str, request: Request) -> Tally:
    """Count the rows of a table, or of the result of a query, in a warehouse that ibis reaches."""
    scheme = urlsplit(url).scheme

    def work(connection: Any, source: str, dialect: str, schema: Any) -> tuple[Tally, set[str]]:
        for name in request.columns:
            column(dict.fromkeys(schema.names, ()), name)
        cut = {name for name in request.bins if schema[name].is_numeric()}
        statement = count_statement(request.columns, source, dialect, bins={name: request.bins[name] for name in cut}, read=request.read)
        rows = RowsRead(_rows(connection.sql(statement)))
        return Tally.of(scheme, request.columns, rows).conserving(rows.rows, scheme, SAME_ROWS), cut

    tally, cut = _attended(url, request, work)
    if not len(tally):
        raise InputError(f"{scheme}: the table has no rows")
    return apply_bins(tally, request.bins, cut)


def survey(url: str, request: Request) -> Survey:
    """Look at every column of a table, or of the result of a query, in a warehouse that ibis reaches."""

    def work(connection: Any, source: str, dialect: str, schema: Any) -> Survey:
        return Survey.of(schema.names, lambda name: _rows(connection.sql(common_statement(name, source, dialect, MOST))))

    return _attended(url, request, work)


def _attended(url: str, request: Request, work: Callable[[Any, str, str, Any], T]) -> T:
    """Connect, and do the work with the connection, what is counted, the dialect, and the schema of what is counted."""
    try:
        import ibis
    except ImportError:
        raise InputError("this database needs ibis; install fairaudit-certify[ibis] and its driver, or use --print-sql") from None
    scheme = urlsplit(url).scheme
    dialect = {"pyspark": "spark"}.get(scheme, scheme)
    if dialect not in DIALECTS:
        raise InputError(f"the database {shown(scheme)} is not known; {nearest(dialect, DIALECTS)}")
    source = database_source(request, dialect)
    held: list[Any] = []

    def connected() -> T:
        held.append(ibis.connect(url))
        return work(held[0], source, dialect, held[0].sql(f"select * from {source}").schema())  # noqa: S608

    def give_up() -> None:
        with suppress(Exception):
            for connection in held:
                connection.disconnect()

    try:
        return attended(connected, give_up, request)
    except (FairauditError, KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:
        said = " ".join(str(error).split("\n")[0].split())[:300] or type(error).__name__
        raise InputError(f"{scheme}: {said}") from None


def _rows(result: Any) -> Iterator[tuple[Any, ...]]:
    for batch in result.to_pyarrow_batches():
        yield from zip(*map(native_values, batch.columns), strict=True)
