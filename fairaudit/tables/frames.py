"""Frames of pandas, polars, pyarrow, DuckDB, PySpark and others, lazy or not: the library that holds a frame counts its rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import ceil
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.arriving import is_frame
from fairaudit.tables.binning import Bins, apply_bins
from fairaudit.tables.coded import DENSE, Coded, UnknownValueError, coded_column, count_combinations
from fairaudit.tables.label_text import label_text, native_values
from fairaudit.tables.sql import AS_IS, COUNT_COLUMN, Written, identifier, refused_type, written
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column, refuse_part_of_tally

__all__ = ["is_lazy", "tally_frame"]

WHOLE = frozenset(("string", "boolean", "integer", "floating", "date", "decimal", "empty"))
MOMENTS = frozenset(("datetime", "datetime64", "time"))
REFUSED = frozenset(("Array", "Binary", "Duration", "List", "Struct"))


def is_lazy(frame: Any) -> bool:
    """Whether a frame is a query that has not been run, so that its columns cannot be read one by one."""
    import narwhals as nw

    try:
        return isinstance(nw.from_native(frame), nw.LazyFrame)
    except Exception:
        return False  # two columns of one name, say; who reads the columns says so


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
    refuse_part_of_tally(frame)
    import narwhals as nw

    try:
        wrapped: Any = nw.from_native(frame)
        schema = wrapped.collect_schema()
    except Exception as error:
        if type(frame).__module__.startswith("pandas") or not hasattr(type(frame), "columns"):
            return None  # two columns of one name, say, or no table; the caller reads the columns one by one and says so
        raise InputError(f"the {type(frame).__name__} cannot be read: {_first_line(error)}") from None
    names = list(dict.fromkeys(columns))
    _refuse_index(frame, names, schema.names())
    for name in names:
        column(dict.fromkeys(schema.names(), ()), name)
        if type(schema[name]).__name__ in REFUSED:
            raise refused_type(name, str(schema[name]))
    if wrapped.implementation.is_pandas_like():
        frame = _with_texts(_decoded(frame, names), names)
        wrapped = nw.from_native(frame)
    elif wrapped.implementation.is_pyarrow():
        wrapped = nw.from_native(_plain_columns(frame.select(names)))
    if not bins and (tally := _dense(frame, wrapped, names)) is not None:
        return tally
    if wrapped.implementation.is_pandas_like() and not all(_one_type(frame[name]) for name in names):
        return None
    tally = _grouped(wrapped, names, {name: edges for name, edges in (bins or {}).items() if schema[name].is_numeric()})
    if not len(tally):
        raise InputError("the table has no rows")
    return apply_bins(tally, bins or {}, [name for name in bins or {} if schema[name].is_numeric()])


def _refuse_index(frame: Any, names: Sequence[str], known: Sequence[str]) -> None:
    """Say of a column that is the index of a frame how it becomes one."""
    index = getattr(getattr(frame, "index", None), "names", ())
    for name in names:
        if name not in known and name in index:
            raise InputError(f"{shown(name)} is the index of the frame, and no column; give frame.reset_index()")


def _grouped(wrapped: Any, names: Sequence[str], cut: Mapping[str, Bins]) -> Tally:
    """Let the library count, numeric columns cut into intervals."""
    import narwhals as nw

    schema = wrapped.collect_schema()
    kinds = {name: kind for name, kind in _kinds(wrapped, names).items() if name not in cut}
    library = type(wrapped.to_native()).__name__
    count = COUNT_COLUMN
    while count in names:
        count += "_"
    try:
        picked = wrapped.select(*(_interval(nw, name, cut[name], schema[name]) if name in cut else nw.col(name) for name in names))
        rows = _rows(picked.group_by(*names, drop_null_keys=False).agg(nw.len().alias(count)).select(*names, count), kinds)
        tally = Tally.of(library, names, rows, read={name: kind.read for name, kind in kinds.items() if kind.read is not None})
        length = _length(wrapped)
    except (InputError, KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:
        raise InputError(f"the rows of the {library} cannot be counted: {_first_line(error)}") from None
    lazy = "collect the frame first, if its rows change from one run to the next; else " if isinstance(wrapped, nw.LazyFrame) else ""
    return tally.conserving(length, str(wrapped.implementation), f"{lazy}give the rows as a CSV or Parquet file")


def _length(wrapped: Any) -> int:
    """How many rows a frame has, by another way than grouping them; a lazy frame is asked by itself."""
    import narwhals as nw

    if not isinstance(wrapped, nw.LazyFrame):
        return len(wrapped)
    native = wrapped.to_native()
    if wrapped.implementation.is_duckdb():
        return int(native.aggregate("count(*)").fetchall()[0][0])
    if wrapped.implementation.is_pyspark() or wrapped.implementation.is_pyspark_connect():
        return int(native.count())
    return int(wrapped.select(nw.len()).collect().item())


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
        if not pandas and not (frame[name].dtype.is_integer() and "128" not in str(frame[name].dtype)):
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
    return tally.conserving(len(frame), "fairaudit")


def _factorized(series: Any) -> tuple[Any, list[Any], int]:
    codes, values = series.factorize()
    return codes, [None, *native_values(values.to_series() if hasattr(values, "to_series") else type(series)(values))], -1


def _decoded(frame: Any, names: Sequence[str]) -> Any:
    """Decode the dictionaries of Arrow in a pandas frame, of which pandas loses missing values while it groups rows."""
    held = {name: getattr(getattr(frame[name], "dtype", None), "pyarrow_dtype", None) for name in names}
    if all(kind is None for kind in held.values()):
        return frame
    import pandas as pd
    import pyarrow as pa

    values = {name: pd.ArrowDtype(kind.value_type) for name, kind in held.items() if kind is not None and pa.types.is_dictionary(kind)}
    return frame.assign(**{name: frame[name].astype(kind) for name, kind in values.items()})


def _with_texts(frame: Any, names: Sequence[str]) -> Any:
    """Write the moments that a pandas column holds as Python objects as texts: two in one hour may be equal to Python and differ."""
    from pandas.api.types import infer_dtype

    objects = [name for name in names if str(getattr(frame[name], "dtype", "")) == "object"]
    texts: dict[str, list[str | None]] = {}
    for name in objects:
        if infer_dtype(frame[name].iloc[:100], skipna=True) != "string" and infer_dtype(frame[name], skipna=True) in MOMENTS:
            try:
                texts[name] = [label_text(value) for value in frame[name]]
            except InputError as error:
                raise InputError(f"column {shown(name)}: {error}") from None
    return frame.assign(**texts) if texts else frame


def _plain_columns(table: Any) -> Any:
    """Decode what Arrow cannot count: values behind a dictionary or an extension."""
    import pyarrow as pa

    for place, entry in enumerate(table.schema):
        if isinstance(entry.type, pa.BaseExtensionType):
            if entry.type.extension_name not in ("arrow.uuid", "arrow.bool8"):
                raise refused_type(entry.name, str(entry.type))
            texts = pa.array(map(label_text, native_values(table.column(place))), pa.string())
            table = table.set_column(place, entry.name, texts)
        elif pa.types.is_dictionary(entry.type):
            table = table.set_column(place, entry.name, table.column(place).cast(entry.type.value_type))
    return table


def _kinds(wrapped: Any, names: Sequence[str]) -> dict[str, Written]:
    """How the engine behind a lazy frame writes its columns."""
    native = wrapped.to_native()
    if wrapped.implementation.is_duckdb():
        types = dict(zip(native.columns, map(str, native.types), strict=True))
        return {name: written(types[name], "duckdb", name) for name in names}
    if wrapped.implementation.is_pyspark() or wrapped.implementation.is_pyspark_connect():
        types = dict(native.dtypes)
        return {name: written(types[name], "spark", name) for name in names}
    return {}


def _rows(grouped: Any, kinds: Mapping[str, Written]) -> Iterable[Sequence[Any]]:
    """Rows of a small frame as values that Python can keep."""
    native = grouped.to_native()
    dialect = "duckdb" if grouped.implementation.is_duckdb() else "spark"
    if kinds or dialect == "duckdb":
        quoted = {name: identifier(name, dialect) for name in native.columns}
        picked = [f"{kinds.get(name, AS_IS).of(alias)} as {alias}" for name, alias in quoted.items()]
        if dialect == "duckdb":
            rows: Iterable[Sequence[Any]] = native.project(", ".join(picked)).fetchall()
            return rows
        return list(native.selectExpr(*picked).toLocalIterator())
    import narwhals as nw

    eager: Any = grouped.collect() if isinstance(grouped, nw.LazyFrame) else grouped
    held = eager.to_native()
    return list(zip(*(native_values(held[name]) for name in eager.columns), strict=True))


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
