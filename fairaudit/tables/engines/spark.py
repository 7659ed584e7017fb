"""Spark, by PySpark (extra `spark`): files and tables that one machine should not read alone."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.csv import layout, same_layout
from fairaudit.tables.engines.contents import refuse_twice
from fairaudit.tables.engines.duckdb import JSON, bad_json, connected, parquet_faults, readers, told
from fairaudit.tables.engines.paths import JSON_NAME, expand, form
from fairaudit.tables.engines.request import SAME_ROWS, Request, attended, database_source
from fairaudit.tables.engines.survey import MOST, Survey, read_first
from fairaudit.tables.sql import RowsRead, Written, common_statement, count_statement, identifier, written
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column

__all__ = ["read", "survey"]

NUMERIC = ("tinyint", "smallint", "int", "bigint", "float", "double", "decimal")
VIEW = "fairaudit_log"
REPLACED = "\ufffd"


def read(sources: Sequence[str], request: Request, session: Any = None) -> Tally:
    """Count the rows of files, or of a table of Spark's catalogue, in the given session or one of this machine."""
    with _opened(sources, request, session) as log:
        types = dict(log.spark.sql(f"select * from {log.source} limit 0").dtypes)  # noqa: S608
        for name in request.columns:
            column(dict.fromkeys(types, ()), name)
        kinds = {name: _writing(types[name], name, log) for name in request.columns}
        for name, fault in _faults(log, request.columns, request).items():
            raise InputError(f"column {shown(name)} {fault}")
        cut = {name for name in request.bins if types[name].startswith(NUMERIC)}
        bins = {name: request.bins[name] for name in cut}
        kinds = {name: kind for name, kind in kinds.items() if name not in cut}
        statement = count_statement(request.columns, log.source, "spark", bins=bins, kinds=kinds, read=request.read)

        def work() -> Tally:
            rows = RowsRead(log.spark.sql(statement).toLocalIterator())
            counted = Tally.of(log.name, request.columns, rows, read=readers(kinds), equal=kinds if log.kind == "json" else ())
            return counted.conserving(rows.rows, "Spark", SAME_ROWS)

        tally = attended(work, lambda: log.spark.sparkContext.cancelAllJobs(), request)
        for name in request.columns:
            if log.kind == "json" and tally.levels[name] == [None]:
                column(dict.fromkeys(_keys(log.spark, log.paths), ()), name)
        if not len(tally):
            raise InputError("the table has no rows")
        if log.kind in ("csv", "json") and any(isinstance(v, str) and REPLACED in v for levels in tally.levels.values() for v in levels):
            raise InputError(_replaced(log))
        return apply_bins(tally, request.bins, cut)


def survey(sources: Sequence[str], request: Request, session: Any = None) -> Survey:
    """Look at every column of files, or of a table of Spark's catalogue."""
    with _opened(sources, request, session) as log:
        types = dict(log.spark.sql(f"select * from {log.source} limit 0").dtypes)  # noqa: S608
        faults = _faults(log, list(types), request)

        def common(name: str) -> Iterable[Sequence[Any]]:
            if name in faults:
                raise InputError(f"column {shown(name)} {faults[name]}")
            kind = _writing(types[name], name, log)
            return read_first(log.spark.sql(common_statement(name, log.source, "spark", MOST, kind)).toLocalIterator(), name, kind)

        found = attended(lambda: Survey.of(list(types), common), lambda: log.spark.sparkContext.cancelAllJobs(), request)
    if log.kind in ("csv", "json") and any(REPLACED in text for seen in found.columns for text in seen.levels):
        raise InputError(_replaced(log))
    return found


def _writing(kind: str, name: str, log: _Log) -> Written:
    return JSON if log.kind == "json" else written(kind, "spark", name)


def _faults(log: _Log, columns: Sequence[str], request: Request) -> dict[str, str]:
    """Say what of files on this machine Spark would round, as DuckDB would."""
    if log.kind != "parquet" or not _local(log.paths):
        return {}
    with connected(request) as connection, told(request, log.paths[0]):
        return parquet_faults(connection, log.paths, dict.fromkeys(columns, "TIMESTAMP_NS"))


@dataclass(frozen=True)
class _Log:
    """A log that Spark can count: what stands after ``from``, and the files and their kind, if it is held by files."""

    spark: Any
    name: str
    source: str
    paths: list[str]
    kind: str


@contextmanager
def _opened(sources: Sequence[str], request: Request, session: Any) -> Iterator[_Log]:
    """Find the log, and make one sentence of what Spark complains about."""
    try:
        from pyspark.errors import PySparkException
    except ImportError:
        raise InputError("Spark needs PySpark and Java; install fairaudit-certify[spark]") from None
    with _session(session) as spark:
        paths, kind = _files(sources, request) if sources else ([], "")
        name = Path(sources[0]).name if sources else str(request.table or "query")
        try:
            if sources:
                _view(spark, paths, kind, request)
            yield _Log(spark, name, VIEW if sources else database_source(request, "spark"), paths, kind)
        except InputError as error:
            if not sources or name in str(error):
                raise
            raise InputError(f"{name}: {error}") from None
        except Exception as error:
            if not isinstance(error, PySparkException) and type(error).__module__.partition(".")[0] not in ("py4j", "pyspark"):
                raise
            bad = (bad_json(paths) if _local(paths) else None) if kind == "json" else None
            raise InputError(bad or f"{sources[0] if sources else request.table}: Spark cannot read it: {_said(error)}") from None


def _files(sources: Sequence[str], request: Request) -> tuple[list[str], str]:
    """List the files and say what they hold."""
    if request.table is not None or request.query is not None:
        raise InputError("a table or a query is of Spark's catalogue, not of a file; give one of the two")
    if not _local(sources):
        name = next(source for source in sources if "://" in source).lower()
        return list(sources), "csv" if name.endswith((".csv", ".csv.gz")) else "json" if JSON_NAME.fullmatch(name) else "parquet"
    paths = expand(sources)
    refuse_twice(paths, request.same_content)
    found = {form(path) for path in paths}
    kind = found.pop()
    if found or kind not in ("csv", "json", "parquet"):
        raise InputError(f"{paths[0]}: Spark reads CSV, Parquet and JSON lines of one kind here; leave --engine out for others")
    return paths, kind


def _local(sources: Sequence[str]) -> bool:
    return not any("://" in source for source in sources)


def _view(spark: Any, paths: Sequence[str], kind: str, request: Request) -> None:
    """Name files so that a statement can count them."""
    if kind == "parquet":
        spark.read.parquet(*map(_uri, paths)).createOrReplaceTempView(VIEW)
        return
    if kind == "json":
        from pyspark.sql import functions

        names = request.columns or _keys(spark, paths)
        held = _lines(spark, paths).select(_parsed(names).alias("held"))
        held.select(*(functions.col("held")[i].alias(name) for i, name in enumerate(names))).createOrReplaceTempView(VIEW)
        return
    header = None
    for path in paths if _local(paths) else ():
        try:
            header = same_layout(header, layout(path))
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    spark.conf.set("spark.sql.csv.parser.columnPruning.enabled", "false")  # so that every row is checked whole
    schema = None if header is None else ", ".join(f"{identifier(name, 'spark')} string" for name in header.columns)
    reader = spark.read.options(
        header=True, sep=header.delimiter if header else ",", quote='"', escape='"', mode="FAILFAST", multiLine=True
    )
    frame = (reader.schema(schema) if schema else reader).csv(list(map(_uri, paths)))
    frame.createOrReplaceTempView(VIEW)


def _lines(spark: Any, paths: Sequence[str]) -> Any:
    """Lines that are not blank."""
    from pyspark.sql import functions

    return spark.read.text(list(map(_uri, paths)), lineSep="\n").where(functions.col("value").rlike(r"\S"))


def _keys(spark: Any, paths: Sequence[str]) -> list[str]:
    """Keys of all objects, in order of first appearance."""
    from pyspark.sql import functions

    keys = functions.posexplode(_parsed(None)).alias("place", "key")
    found = _lines(spark, paths).select(functions.monotonically_increasing_id().alias("line"), keys)
    first = found.groupBy("key").agg(functions.min(functions.struct("line", "place")).alias("first"))
    return [row["key"] for row in first.orderBy("first").collect()]


def _parsed(columns: Sequence[str] | None) -> Any:
    """What `_parser` makes of lines, as a column of arrays."""
    from pyspark.sql import functions

    return functions.udf(_parser(columns), "array<string>", useArrow=False)(functions.col("value"))


def _parser(columns: Sequence[str] | None) -> Callable[[str], list[str | None]]:
    """Make a function that reads a line: the values of columns as JSON texts that say what DuckDB reads, or the keys.

    It is sent to Spark's workers, which need not have this package.
    """

    def parse(line: str) -> list[str | None]:
        import json

        def real(text: str) -> tuple[str, str]:
            value = float(text)
            return "number", repr(value) if abs(value) < float("inf") else text

        def whole(text: str) -> tuple[str, str]:
            return "number", text

        def written(name: str) -> str | None:
            value = held.get(name)
            if isinstance(value, tuple) and value[0] == "number":
                return str(value[1])
            if isinstance(value, (tuple, list)):
                return json.dumps(json.loads(line)[name], separators=(",", ":"))
            return None if value is None else json.dumps(value)

        try:
            found = json.loads(
                line, parse_float=real, parse_int=whole, parse_constant=whole, object_pairs_hook=lambda pairs: ("object", pairs)
            )
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, tuple) or found[0] != "object":
            raise ValueError(f"fairaudit: the line {line[:60]!r} is not a JSON object")
        held = dict(found[1])
        if len(held) != len(found[1]):
            raise ValueError(f"fairaudit: the line {line[:60]!r} has a key twice")
        return list(held) if columns is None else [written(name) for name in columns]

    return parse


def _replaced(log: _Log) -> str:
    """Say that bytes were no UTF-8."""
    bad = bad_json(log.paths) if log.kind == "json" and _local(log.paths) else None
    return bad or (f"{log.paths[0]}: a label has the character U+FFFD, which Spark puts for bytes that are not UTF-8; read it with DuckDB")


def _uri(path: str) -> str:
    return path if "://" in path else Path(path).resolve().as_uri()


@contextmanager
def _session(given: Any) -> Iterator[Any]:
    """Use the session that was given, or one of this machine that ends with the work."""
    if given is not None:
        yield given
        return
    from pyspark.sql import SparkSession

    active = SparkSession.getActiveSession()
    if active is not None:
        yield active
        return
    if shutil.which("java") is None and "JAVA_HOME" not in os.environ:
        raise InputError("Spark needs Java, and there is none on this machine; install a Java runtime (17 or later)")
    scratch = tempfile.mkdtemp(prefix="fairaudit-spark-")
    spark = None
    try:
        builder = SparkSession.builder.appName("fairaudit").config("spark.ui.enabled", "false").config("spark.local.dir", scratch)
        builder = builder.config("spark.sql.warehouse.dir", scratch).config("spark.ui.showConsoleProgress", "false")
        if not any(name in os.environ for name in ("SPARK_MASTER", "MASTER", "SPARK_REMOTE")):
            builder = builder.master(os.environ.get("FAIRAUDIT_SPARK_MASTER", "local[*]"))
        with _quiet(), _same_python():
            try:
                spark = builder.getOrCreate()
            except Exception as error:
                raise InputError(f"Spark cannot be started: {_said(error)}") from None
            spark.sparkContext.setLogLevel("OFF")
        yield spark
    finally:
        if spark is not None:
            with _quiet():
                spark.stop()
        shutil.rmtree(scratch, ignore_errors=True)


@contextmanager
def _same_python() -> Iterator[None]:
    """Let Spark's workers run this Python unless the environment names one."""
    given = "PYSPARK_PYTHON" in os.environ
    os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    try:
        yield
    finally:
        if not given:
            del os.environ["PYSPARK_PYTHON"]


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what the Java process says while it starts off the terminal; it inherits this process's error stream."""
    kept = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere:  # noqa: PTH123
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _said(error: Exception) -> str:
    own = re.search(r"ValueError: fairaudit: (.*)", str(error))
    if own:
        return own.group(1)
    return " ".join(str(error).split("\n")[0].split())[:300] or type(error).__name__
