"""Frames of pandas, polars, pyarrow, DuckDB, PySpark and others, lazy or not: the library that holds a frame counts its rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import ceil
from typing import Any

from fairaudit.columns import Tally, column
from fairaudit.exact import InputError
from fairaudit.tables.binning import Bins, apply_bins, merged
from fairaudit.tables.coded import DENSE, Coded, UnknownValueError, coded_column, count_combinations
from fairaudit.tables.sql import COUNT_COLUMN

__all__ = ["is_frame", "tally_frame"]

LIBRARIES = frozenset(
    ("cudf", "dask", "dask_expr", "duckdb", "_duckdb", "ibis", "modin", "narwhals", "pandas", "polars", "pyarrow", "pyspark", "sqlframe")
)
WHOLE = frozenset(("string", "boolean", "integer", "floating", "date", "datetime", "decimal", "empty"))


def is_frame(table: Any) -> bool:
    """Whether a table belongs to one of the frame libraries."""
    return type(table).__module__.partition(".")[0] in LIBRARIES


def tally_frame(frame: Any, columns: Sequence[str], bins: Mapping[str, Bins] | None = None) -> Tally | None:
    """Count the equal rows of a frame in the library that holds it.

    Parameters
    ----------
    frame : DataFrame, LazyFrame, Table or relation
        The frame.
    columns : sequence of str
        The columns that tell rows apart.
    bins : mapping of str to Bins, optional
        Numeric columns to cut into intervals.

    Returns
    -------
    Tally or None
        The counts; None if it is not such a frame, or a column mixes types that its library would take for equal.

    Raises
    ------
    InputError
        If a column is not there, or the library cannot count.
    """
    if not is_frame(frame):
        return None
    import narwhals as nw

    try:
        wrapped: Any = nw.from_native(frame)
        schema = wrapped.collect_schema()
    except Exception as error:
        if type(frame).__module__.startswith("pandas"):
            return None  # two columns of one name, say; the caller reads the columns one by one and says so
        raise InputError(f"the {type(frame).__name__} cannot be read: {_first_line(error)}") from None
    names = list(dict.fromkeys(columns))
    for name in names:
        column(dict.fromkeys(schema.names(), ()), name)
    if not bins and (tally := _dense(frame, wrapped, names)) is not None:
        return tally
    if wrapped.implementation.is_pandas_like() and not all(_one_type(frame[name]) for name in names):
        return None
    cut = {name for name in bins or {} if schema[name].is_numeric()}
    count = COUNT_COLUMN
    while count in names:
        count += "_"
    try:
        picked = wrapped.select(*(_interval(nw, name, (bins or {})[name], schema[name]) if name in cut else nw.col(name) for name in names))
        grouped = picked.group_by(*names, drop_null_keys=False).agg(nw.len().alias(count))
        tally = Tally.of(type(frame).__name__, names, _rows(grouped.select(*names, count)))
    except InputError:
        raise
    except (KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:
        raise InputError(f"the rows of the {type(frame).__name__} cannot be counted: {_first_line(error)}") from None
    if not len(tally):
        raise InputError("the table has no rows")
    return apply_bins(tally, bins or {}, cut)


def _dense(frame: Any, wrapped: Any, names: Sequence[str], *, sampled: bool = True) -> Tally | None:
    """Count a frame in memory whose columns are, or become at little cost, small integers; None if it is not such a frame."""
    pandas = type(frame).__module__.startswith("pandas")
    if not pandas and not (wrapped.implementation.is_polars() and hasattr(frame, "rows")):
        return None
    if not len(frame):
        return None
    coded = []
    size = 1
    for name in names:
        if not pandas and not frame[name].dtype.is_integer():
            return None
        part = coded_column(frame[name] if pandas else frame[name].to_numpy(), sampled=sampled)
        if part is None and pandas and _one_type(frame[name]):
            part = Coded.of(*_factorized(frame[name]))
        if part is None or (size := size * len(part.values)) > DENSE:
            return None
        coded.append(part)
    try:
        tally = Tally.of(type(frame).__name__, names, count_combinations(coded))
    except UnknownValueError:
        return _dense(frame, wrapped, names, sampled=False)
    return merged(tally) if any(len({*part.values}) < len(part.values) for part in coded) else tally


def _factorized(series: Any) -> tuple[Any, list[Any], int]:
    codes, values = series.factorize()
    return codes, [None, *values.tolist()], -1


def _rows(grouped: Any) -> Iterable[Sequence[Any]]:
    """Rows of a small frame as Python values."""
    native = grouped.to_native()
    if grouped.implementation.is_duckdb():
        rows: Iterable[Sequence[Any]] = native.fetchall()
        return rows
    if grouped.implementation.is_pyspark():
        return list(native.toLocalIterator())
    import narwhals as nw

    eager: Any = grouped.collect() if isinstance(grouped, nw.LazyFrame) else grouped
    return list(eager.rows())


def _one_type(series: Any) -> bool:
    """Whether a column holds values of one kind, so that no two that differ are equal (1 and True)."""
    if str(series.dtype) != "object":
        return getattr(series, "ndim", 1) == 1
    from pandas.api.types import infer_dtype

    return infer_dtype(series, skipna=True) in WHOLE


def _interval(nw: Any, name: str, bins: Bins, kind: Any) -> Any:
    """Interval of a numeric column: integers against the next integer, floats as float64 against the edge rounded to that."""
    value = nw.col(name)
    if kind.is_float():  # float32 would round the edges further
        value = value.cast(nw.Float64)
    edges = [_edge(limit, kind) for limit in bins.limits]
    found = nw.lit(bins.labels[-1])
    for edge, label in zip(reversed(edges), reversed(bins.labels[:-1]), strict=True):
        found = nw.when(value < edge).then(nw.lit(label)).otherwise(found)
    if kind.is_float():  # asked by name: an engine may drop a comparison that the greatest value in statistics without NaN decides
        found = nw.when(~value.is_finite()).then(nw.lit(bins.refused)).otherwise(found)
    return nw.when(~value.is_null()).then(found).alias(name)


def _edge(limit: Fraction, kind: Any) -> int | float:
    if kind.is_integer():
        return ceil(limit)
    return float(limit) if kind.is_float() or limit.denominator != 1 else int(limit)


def _first_line(error: Exception) -> str:
    return " ".join(str(error).split("\n")[0].split())[:300] or type(error).__name__
