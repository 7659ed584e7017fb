"""Logs of any size: the engine that holds a log counts its equal rows, and only those counts travel back."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from fairaudit.arguments import answered
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.rationals import Number
from fairaudit.tables.binning import Bins
from fairaudit.tables.engines.databases import listed, tables_of
from fairaudit.tables.engines.folders import table_format
from fairaudit.tables.engines.request import PartsMissing, Report, Request, database_source
from fairaudit.tables.evaluations.extraction import Errors, MissingSamples, extraction_of
from fairaudit.tables.preparation import Entry, intervals
from fairaudit.tables.sources import SameContent, Source, source_name
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column, names

if TYPE_CHECKING:
    from fairaudit.tables.engines.survey import Survey

__all__ = ["ENGINES", "Engine", "counted_log", "cut_columns", "log_request", "read_log", "read_parts", "survey_log"]


ENGINES = ("auto", "duckdb", "python", "spark")


class SparkSession(Protocol):
    """A session of PySpark that is there already."""

    def createDataFrame(self, *given: Any, **options: Any) -> Any:  # noqa: N802
        """Make a frame."""


Engine = Literal["auto", "duckdb", "python", "spark"] | SparkSession

FAR = frozenset(("http", "https", "ftp", "s3", "gs", "gcs", "az", "abfs", "abfss", "hdfs"))
"""How names of files begin that are read by nothing here."""

Task = Literal["read", "survey"]


@answered
def read_log(
    source: Source,
    columns: str | Sequence[str],
    *,
    bins: Mapping[str, Sequence[Number] | Bins] | None = None,
    engine: Engine = "auto",
    table: str | None = None,
    query: str | None = None,
    memory: str | None = None,
    report: Report | None = None,
    meanwhile: Callable[[], object] | None = None,
    most: int | None = None,
    by: Sequence[str] = (),
    skip: int = 0,
    encoding: str | None = None,
    decision: str | None = None,
    group: str | Sequence[str] = (),
    unit: str | Sequence[str] = (),
    count: str | None = None,
    log_format: str | None = None,
    extract: str | None = None,
    options: str | Sequence[str] = (),
    join: str | None = None,
    where: Mapping[str, str] | Sequence[str] = (),
    errors: Errors = "refuse",
    missing_samples: MissingSamples = "refuse",
    recipe: str | None = None,
    same_content: SameContent = "refuse",
) -> Tally:
    """Count the equal rows of a log, whatever holds it.

    Parameters
    ----------
    source : path, sequence of paths, URL or frame
        Files (CSV, Parquet, JSON lines; compressed; patterns such as ``logs/*.parquet``; with the extra ``files`` spreadsheets, files of
        Stata, SPSS and SAS, Feather, ORC); ``sqlite:FILE``, ``duckdb:FILE``,
        ``delta:FOLDER``, ``postgresql://…``, or a URL that ibis knows (``bigquery://…``, ``snowflake://…``, ``trino://…``); a frame, lazy
        frame or relation of pandas, polars, pyarrow, DuckDB or PySpark.
    columns : str or sequence of str
        The columns that tell rows apart: decision, groups, contexts, and, where wanted, unit and utility.
    bins : mapping of str to sequence of number, optional
        Numeric columns to cut into intervals at these edges; an interval holds its lower edge. A number in a text is the rational that it
        says; floats are compared with the edges rounded to floats.
    engine : {"auto", "duckdb", "python", "spark"} or SparkSession
        Who reads files. "auto" reads small text files itself and gives everything else to DuckDB; all give the same counts.
    table, query : str, optional
        Of a database: the table, or a query whose result is the log. Of a spreadsheet: the sheet.
    memory : str, optional
        What DuckDB may use before it spills to the directory for temporary files, such as ``"2GB"``.
    report, meanwhile : callable, optional
        Told how far the work is; run once beside it.
    most : int, optional
        How many different rows may come back from Parquet files or a table of a DuckDB database; more are for `read_parts`.
    by : sequence of str, optional
        The columns for `read_parts` to keep together; if it cannot, all rows come back however many they are.
    skip : int
        How many lines stand above the header of a text or a spreadsheet.
    encoding : str, optional
        How the characters of a text are written, where that is not UTF-8: ``"cp1252"``, ``"latin-1"``.
    decision, group, unit : str or sequence of str
        Of an evaluation log: which of the columns is the decision, which are groups, and which the sampling unit.
    count : str, optional
        Of files that `tally` wrote: which of the columns says how often a row occurred.
    log_format, extract, options, join, where, errors, missing_samples, recipe
        Of an evaluation log, as for `audit`.
    same_content : {"refuse", "accept"}
        What becomes of several files with the same content, packed or not. One file under two names is always refused.

    Returns
    -------
    Tally
        The different rows and their counts, for `Law.from_log` and `Utility.from_table`.

    Raises
    ------
    InputError
        If the source cannot be read, or a column is not there.
    ManyRowsError
        If there are more different rows than `most`.

    Examples
    --------
    >>> import pandas as pd
    >>> frame = pd.DataFrame({"hired": ["yes", "no", "yes"], "age": [17, 18, 70]})
    >>> tally = read_log(frame, ["hired", "age"], bins={"age": [18, 65]})
    >>> sorted(zip(tally["hired"], tally["age"]))
    [('no', '18 to under 65'), ('yes', '65 and over'), ('yes', 'under 18')]
    """
    request = log_request(
        names(columns),
        bins,
        table=table,
        query=query,
        memory=memory,
        report=report,
        meanwhile=meanwhile,
        most=most,
        by=tuple(by),
        skip=skip,
        encoding=encoding,
        decision=decision,
        group=names(group),
        unit=names(unit),
        count=count,
        same_content=same_content,
        extraction=extraction_of(
            log_format=log_format,
            extract=extract,
            options=options,
            join=join,
            where=where,
            errors=errors,
            missing_samples=missing_samples,
            recipe=recipe,
        ),
    )
    return counted_log(source, request, engine)


def counted_log(source: Source, request: Request, engine: Engine = "auto") -> Tally:
    """Count the equal rows of a log as `read_log` does.

    Raises
    ------
    InputError
        If the source cannot be read, or a column is not there.
    ManyRowsError
        If there are more different rows than `request.most`.
    """
    _check(request, engine)
    if _is_text(source) or _is_paths(source):
        tally: Tally = _from_text(source, request, engine or "auto", "read")
        return replace(tally, preparation=(*tally.preparation, *cut_columns(request.bins)))
    from fairaudit.tables.frames import tally_frame

    for name, given in (("table", request.table), ("query", request.query)):
        if given is not None:
            raise InputError(f"a {name} goes with a database, not with a frame")
    request.extraction.refuse("a frame")
    if request.skip:
        raise InputError("lines are skipped above the header of text and of spreadsheets, not of a frame")
    if request.encoding:
        raise InputError("an encoding is that of a text, not of a frame")
    found = tally_frame(source, request.columns, request.bins)
    if found is None:
        if hasattr(source, "columns"):
            for name in request.columns:
                column(source, name)  # which occurs twice, say
        from fairaudit.tables.arriving import unreadable

        raise unreadable(source)
    return replace(found, preparation=cut_columns(request.bins))


def cut_columns(bins: Mapping[str, Bins]) -> tuple[Entry, ...]:
    """Say which columns were cut into intervals, as a certificate records it."""
    return tuple(intervals(name, cut.limits) for name, cut in bins.items())


def read_parts(
    source: Any,
    columns: Sequence[str],
    by: Sequence[str],
    *,
    bins: Mapping[str, Sequence[Number] | Bins] | None = None,
    table: str | None = None,
    memory: str | None = None,
    report: Report | None = None,
    count: str | None = None,
    missing: PartsMissing = "error",
    group: Sequence[str] = (),
) -> Generator[Tally, None, None]:
    """Count the equal rows of a log that has too many different ones to hold them all: in Parquet files, or a table of a DuckDB database.

    Parameters
    ----------
    source : path, sequence of paths, or str
        Parquet files, or ``duckdb:FILE``.
    columns : sequence of str
        The columns that tell rows apart.
    by : sequence of str
        Those among them whose values are kept together: texts, whole numbers, or numbers cut into intervals.
    bins, table, memory, report
        As for `read_log`.
    count : str, optional
        A column of whole numbers, which say how often each row occurred.
    missing : {"error", "drop", "group"}
        Whether rows without some label are left out, or have a level of their own; the first tally says so in its `preparation`.
    group : sequence of str
        The columns of groups, needed where rows are left out: how many of each group are, is said, too.

    Yields
    ------
    Tally
        First the counts without the columns `by`; then those with them, some values of `by` at a time, in the order of their texts.

    Raises
    ------
    InputError
        If the source cannot be read in parts, or a column is not there.
    """
    request = log_request(columns, bins, table=table, memory=memory, report=report, count=count, missing=missing)
    request = replace(request, group=tuple(group))
    _check(request, "duckdb")
    from fairaudit.tables.engines import duckdb
    from fairaudit.tables.engines.contents import refuse_twice
    from fairaudit.tables.engines.paths import expand, form

    sources = [os.fspath(part) for part in ([source] if _is_text(source) else source)]
    if sources[0].startswith("duckdb:") and not Path(sources[0]).exists():
        if len(sources) > 1:
            raise InputError("a database is read on its own; name one")
        database_source(request, "duckdb")
        yield from duckdb.read_parts([sources[0].removeprefix("duckdb:")], request, by)
        return
    if table is not None:
        raise InputError("a table goes with a database, such as duckdb:decisions.db")
    paths = expand(sources)
    refuse_twice(paths, "refuse")
    for path in paths:
        if form(path) != "parquet":
            raise InputError(f"{path} is no Parquet file; a log is read in parts from Parquet files or a table of a DuckDB database")
    yield from duckdb.read_parts(paths, request, by)


def log_request(columns: Sequence[str], bins: Mapping[str, Sequence[Number] | Bins] | None = None, **others: Any) -> Request:
    """Write down what is wanted of an engine.

    Parameters
    ----------
    columns : sequence of str
        The columns.
    bins : mapping of str to sequence of number, optional
        Those to cut into intervals, with the edges.
    **others
        As in `Request`.

    Raises
    ------
    InputError
        If there are intervals of a column that is not wanted, or no column is.
    """
    cut = {name: edges if isinstance(edges, Bins) else Bins.of(name, edges) for name, edges in (bins or {}).items()}
    for name in cut:
        if name not in columns:
            raise InputError(f"intervals were given for column {shown(name)}, which is not among the columns; {nearest(name, columns)}")
    if not columns:
        raise InputError("no column was named; name at least one")
    return Request(tuple(dict.fromkeys(columns)), cut, **others)


def survey_log(
    source: Any,
    *,
    engine: Engine = "auto",
    table: str | None = None,
    query: str | None = None,
    memory: str | None = None,
    report: Report | None = None,
    skip: int = 0,
    log_format: str | None = None,
    same_content: SameContent = "refuse",
    encoding: str | None = None,
) -> Survey:
    r"""Look at every column of a log: its most common labels, how many different values there are, and how many labels are missing.

    Parameters
    ----------
    source : path, sequence of paths, or URL
        What `read_log` reads, frames excepted.
    engine, table, query, memory, report, skip, log_format, same_content, encoding
        As for `read_log`.

    Returns
    -------
    Survey
        The columns.

    Raises
    ------
    InputError
        If the source cannot be read, or has no rows.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "log.csv"
    ...     _ = path.write_text("hired,sex\nyes,f\nno,f\nyes,\n")
    ...     found = survey_log(path)
    >>> found.rows, [(seen.name, seen.levels, seen.missing) for seen in found.columns]
    (3, [('hired', {'yes': 2, 'no': 1}, 0), ('sex', {'f': 2}, 1)])
    """
    extraction = extraction_of(log_format=log_format)
    where: dict[str, Any] = {"skip": skip, "encoding": encoding, "extraction": extraction, "same_content": same_content}
    request = Request((), {}, table, query, memory, report, **where)
    _check(request, engine)
    found: Survey = _from_text(source, request, engine, "survey")
    if not found.rows:
        name = source if _is_text(source) else source[0]
        raise InputError(f"{name}: {next((seen.fault for seen in found.columns if seen.fault), 'the table has no rows')}")
    return found


def _check(request: Request, engine: Any) -> None:
    """Refuse what no engine takes."""
    if request.table is not None and request.query is not None:
        raise InputError("both a table and a query were given; give one")
    if request.skip < 0:
        raise InputError(f"{request.skip} lines above the header cannot be skipped; name a number from 0")
    if request.encoding is not None:
        from fairaudit.tables.engines.converted import check_encoding

        check_encoding(request.encoding)
    if request.memory is not None and not re.fullmatch(r"[0-9]{1,6}(\.[0-9]+)? ?[KMGT]i?B", request.memory, re.IGNORECASE):
        raise InputError(f"the memory {shown(request.memory)} is not an amount such as 500MB or 2GB")
    if isinstance(engine, str) and engine not in ENGINES:
        raise InputError(f"the engine {shown(engine)} is not known; {nearest(engine, ENGINES)}")


def _is_text(source: Any) -> bool:
    return isinstance(source, (str, os.PathLike))


def _is_paths(source: Any) -> bool:
    return isinstance(source, (list, tuple)) and bool(source) and all(map(_is_text, source))


def _from_text(source: Any, request: Request, engine: Any, task: Task) -> Any:
    sources = [os.fspath(part) for part in ([source] if _is_text(source) else source)]
    scheme = re.match(r"([a-z][a-z0-9+.-]*):", sources[0])
    kind = scheme.group(1) if scheme and not Path(sources[0]).exists() else ""
    if kind in FAR:
        raise InputError(f"{source_name(sources[0])} is not on this machine; fetch the file, and name it where it is")
    database = kind in ("sqlite", "duckdb", "postgres", "postgresql") or "://" in sources[0]
    if (request.skip or request.encoding) and (database or kind == "delta" or not isinstance(engine, str) or engine == "spark"):
        what = "lines are skipped above the header of text and of spreadsheets" if request.skip else "an encoding is that of texts"
        raise InputError(f"{what} that are read here, by no database and not by Spark")
    if kind and database:
        request.extraction.refuse("a database")
        if len(sources) > 1:
            raise InputError("a database is read on its own; name one")
        if engine != "auto":
            raise InputError("an engine is chosen for files; a database is its own engine")
        return _database(kind, sources[0], request, task)
    if kind == "delta":
        sources[0] = sources[0].removeprefix("delta:")
        if table_format(Path(sources[0])) != "Delta":
            raise InputError(f"{sources[0]}: this is no Delta table; the folder of one holds a folder _delta_log")
    if not isinstance(engine, str) or engine == "spark":
        request.extraction.refuse("Spark")
        _refuse_logs(sources)
        from fairaudit.tables.engines import spark

        return getattr(spark, task)(sources, request, None if isinstance(engine, str) else engine)
    from fairaudit.tables.engines import files

    return getattr(files, task)(sources, request, engine)


def _refuse_logs(sources: Sequence[str]) -> None:
    """Refuse logs of evaluations, which only the reader that is chosen by itself reads."""
    import glob

    from fairaudit.tables.engines.converted import format_of_file

    for path in (path for source in sources for path in (glob.glob(source) or [source])):  # noqa: PTH207
        known = format_of_file(path) if os.path.isfile(path) else None  # noqa: PTH113
        if known is not None:
            raise InputError(f"{path} is a log of {known.name}, which Spark does not read; leave the engine out")


def _database(kind: str, url: str, request: Request, task: Task) -> Any:
    if request.table is None and request.query is None and (found := tables_of(url)):
        held = f"the table{'s' * (len(found) > 1)} {listed(found)}"
        raise InputError(f"{source_name(url)} holds {held}; name one with table (--table), or give a query (--query)")
    if kind == "sqlite":
        from fairaudit.tables.engines import sqlite

        return getattr(sqlite, task)(url.removeprefix("sqlite:"), request)
    if kind == "duckdb":
        from fairaudit.tables.engines import duckdb, survey

        return (duckdb.read_database if task == "read" else survey.of_database)(url.removeprefix("duckdb:"), request)
    if kind in ("postgres", "postgresql"):
        from fairaudit.tables.engines import postgres

        return getattr(postgres, task)(url, request)
    from fairaudit.tables.engines import warehouse

    return getattr(warehouse, task)(url, request)
