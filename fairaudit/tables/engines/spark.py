"""Spark, by PySpark (extra `spark`): files and tables that one machine should not read alone."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fairaudit.columns import Tally, column
from fairaudit.exact import InputError
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.csv import layout, same_layout
from fairaudit.tables.engines import Request, attended, database_source
from fairaudit.tables.engines.files import expand, form
from fairaudit.tables.sql import count_statement, identifier

__all__ = ["read"]

NUMERIC = ("tinyint", "smallint", "int", "bigint", "float", "double", "decimal")
VIEW = "fairaudit_log"
REPLACED = "\ufffd"


def read(sources: Sequence[str], request: Request, session: Any = None) -> Tally:
    """Count the rows of files, or of a table of Spark's catalogue, in the given session or one of this machine."""
    try:
        from pyspark.errors import PySparkException
    except ImportError:
        raise InputError("Spark needs PySpark and Java; install fairaudit-certify[spark]") from None
    with _session(session) as spark:
        try:
            text = _view(spark, sources, request) if sources else False
            source = VIEW if sources else database_source(request, "spark")
            types = dict(spark.sql(f"select * from {source} limit 0").dtypes)  # noqa: S608
            for name in request.columns:
                column(dict.fromkeys(types, ()), name)
            cut = {name for name in request.bins if types[name].startswith(NUMERIC)}
            bins = {name: request.bins[name] for name in cut}
            statement = count_statement(request.columns, source, "spark", bins=bins)
            name = Path(sources[0]).name if sources else str(request.table or "query")

            def work() -> Tally:
                return Tally.of(name, request.columns, spark.sql(statement).toLocalIterator())

            tally = attended(work, lambda: spark.sparkContext.cancelAllJobs(), request)
        except PySparkException as error:
            raise InputError(f"{sources[0] if sources else request.table}: Spark cannot read it: {_said(error)}") from None
        except Exception as error:
            if type(error).__module__.partition(".")[0] not in ("py4j", "pyspark"):
                raise
            raise InputError(f"{sources[0] if sources else request.table}: Spark cannot read it: {_said(error)}") from None
    if not len(tally):
        raise InputError("the table has no rows")
    if text and any(isinstance(value, str) and REPLACED in value for levels in tally.levels.values() for value in levels):
        raise InputError(
            f"{sources[0]}: a label has the character U+FFFD, which Spark puts for bytes that are not UTF-8; read it with DuckDB"
        )
    return apply_bins(tally, request.bins, cut)


def _view(spark: Any, sources: Sequence[str], request: Request) -> bool:
    """Name files so that a statement can count them; say whether they are text."""
    if request.table is not None or request.query is not None:
        raise InputError("a table or a query is of Spark's catalogue, not of a file; give one of the two")
    remote = [source for source in sources if "://" in source]
    if remote:
        paths, kind = list(sources), "csv" if remote[0].lower().endswith((".csv", ".csv.gz")) else "parquet"
        header = None
    else:
        paths = expand(sources)
        found = {form(path) for path in paths}
        kind = found.pop()
        if found or kind not in ("csv", "parquet"):
            raise InputError(f"{paths[0]}: Spark reads CSV and Parquet files of one kind here; leave --engine out for others")
        header = None
        for path in paths if kind == "csv" else ():
            try:
                header = same_layout(header, layout(path))
            except InputError as error:
                raise InputError(f"{path}: {error}") from None
    if kind == "parquet":
        spark.read.parquet(*map(_uri, paths)).createOrReplaceTempView(VIEW)
        return False
    spark.conf.set("spark.sql.csv.parser.columnPruning.enabled", "false")  # so that every row is checked whole
    schema = None if header is None else ", ".join(f"{identifier(name, 'spark')} string" for name in header.columns)
    reader = spark.read.options(
        header=True, sep=header.delimiter if header else ",", quote='"', escape='"', mode="FAILFAST", multiLine=True
    )
    frame = (reader.schema(schema) if schema else reader).csv(list(map(_uri, paths)))
    frame.createOrReplaceTempView(VIEW)
    return True


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
        with _quiet():
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
    return " ".join(str(error).split("\n")[0].split())[:300] or type(error).__name__
