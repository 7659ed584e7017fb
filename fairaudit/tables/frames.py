"""Frames of pandas, polars, pyarrow, DuckDB, PySpark and others, lazy or not: the library that holds a frame counts its rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.columns import Tally, column
from fairaudit.exact import InputError
from fairaudit.tables.binning import Bins, apply_bins
from fairaudit.tables.sql import COUNT_COLUMN

__all__ = ["is_frame", "tally_frame"]

LIBRARIES = frozenset(
    ("cudf", "dask", "dask_expr", "duckdb", "_duckdb", "ibis", "modin", "narwhals", "pandas", "polars", "pyarrow", "pyspark", "sqlframe")
)
WHOLE = frozenset(("string", "boolean", "integer", "floating", "date", "datetime", "decimal", "empty"))
DENSE = 1 << 20
BLOCK = 1 << 16


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
    if wrapped.implementation.is_pandas_like() and not all(_one_type(frame[name]) for name in names):
        return None
    if not bins and (parts := _coded(frame, wrapped, names)) is not None:
        tally = Tally.of(type(frame).__name__, names, _dense_counts(parts))
        if not len(tally):
            raise InputError("the table has no rows")
        return tally
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


def _coded(frame: Any, wrapped: Any, names: Sequence[str]) -> list[tuple[NDArray[Any], int, list[Any]]] | None:
    """Columns of a frame in memory as small integers, the least of them, and what they stand for; None if that is not cheap."""
    pandas = type(frame).__module__.startswith("pandas")
    if not pandas and not (wrapped.implementation.is_polars() and hasattr(frame, "rows")):
        return None
    parts = []
    size = 1
    for name in names:
        part = _pandas_codes(frame[name]) if pandas else _whole_codes(frame[name].to_numpy() if frame[name].dtype.is_integer() else None)
        size *= len(part[2]) if part else 0
        if part is None or size > DENSE:
            return None
        parts.append(part)
    return parts


def _pandas_codes(series: Any) -> tuple[NDArray[Any], int, list[Any]] | None:
    if str(series.dtype) == "category":
        return series.cat.codes.to_numpy(), -1, [None, *series.cat.categories.tolist()]
    found = _whole_codes(series.to_numpy() if isinstance(series.dtype, np.dtype) else None)
    if found is not None:
        return found
    codes, values = series.factorize()
    return codes, -1, [None, *values.tolist()]


def _whole_codes(values: NDArray[Any] | None) -> tuple[NDArray[Any], int, list[Any]] | None:
    """Whole numbers or truth values of a small range."""
    if values is None or values.dtype.kind not in "iub" or not len(values):
        return None
    low, high = int(values.min()), int(values.max())
    if high - low >= DENSE or high >= 2**62:
        return None
    return values, low, [bool(v) if values.dtype.kind == "b" else v for v in range(low, high + 1)]


def _dense_counts(parts: Sequence[tuple[NDArray[Any], int, list[Any]]]) -> Iterator[tuple[Any, ...]]:
    """Count combinations of small integers, a block of rows at a time, so that a block stays in the cache."""
    shape = tuple(len(values) for _, _, values in parts)
    counts = np.zeros(int(np.prod(shape)), dtype=np.int64)
    rows = len(parts[0][0])
    block = max(BLOCK, len(counts))
    for start in range(0, rows, block):
        key = np.zeros(min(block, rows - start), dtype=np.int64)
        for codes, low, values in parts:
            key *= len(values)
            key += codes[start : start + block].astype(np.int64) - low
        counts += np.bincount(key, minlength=len(counts))
    cells = np.flatnonzero(counts)
    for place, count in zip(zip(*np.unravel_index(cells, shape), strict=True), counts[cells].tolist(), strict=True):
        yield (*(values[at] for (_, _, values), at in zip(parts, place, strict=True)), count)


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
