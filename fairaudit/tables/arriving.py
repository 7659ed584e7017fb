"""Tables that other libraries hand over: streams and datasets of Arrow, datasets of Hugging Face, Iceberg tables, records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fairaudit.errors import InputError, kind_of
from fairaudit.tables.values import column, refuse_part_of_tally

__all__ = ["as_table", "unreadable"]


LIBRARIES = frozenset(
    ("cudf", "dask", "dask_expr", "duckdb", "_duckdb", "ibis", "modin", "narwhals", "pandas", "polars", "pyarrow", "pyspark", "sqlframe")
)


def is_frame(table: Any) -> bool:
    """Whether a table belongs to one of the frame libraries."""
    return type(table).__module__.partition(".")[0] in LIBRARIES


def as_table(source: Any, columns: Sequence[str]) -> Any:
    """A frame or a mapping of column to list for what is neither, of which those columns are read; anything else as it is.

    Parameters
    ----------
    source : object
        Records (a list of mappings); whatever exports an Arrow stream (``__arrow_c_stream__``); a dataset, scanner, batch or reader of
        pyarrow; a `Dataset` of Hugging Face; a table of pyiceberg.
    columns : sequence of str
        The columns that are wanted.

    Raises
    ------
    InputError
        If a column is not there, or the library that reads it is not.

    Examples
    --------
    >>> as_table([{"hired": "yes", "sex": "f"}, {"hired": "no"}], ["hired", "sex"])
    {'hired': ['yes', 'no'], 'sex': ['f', None]}
    """
    refuse_part_of_tally(source)
    if isinstance(source, (list, tuple)) and source and all(isinstance(record, Mapping) for record in source):
        names = list(dict.fromkeys(name for record in source for name in record))
        return {name: [record.get(name) for record in source] for name in names}
    library = type(source).__module__.partition(".")[0]
    if isinstance(source, type):
        raise unreadable(source)
    if library == "datasets" and hasattr(source, "with_format"):
        return _of_hugging_face(source, columns)
    if library == "pyiceberg" and hasattr(source, "scan"):
        source = source.scan()
    if library == "pyiceberg":
        return _selected(source.to_arrow_batch_reader(), columns)
    if library == "pyarrow" and hasattr(source, "to_table"):
        _check(getattr(source, "schema", None) or source.dataset_schema, columns)
        return source.to_table(columns=list(columns)) if hasattr(source, "schema") else _arrow().Table.from_batches(source.to_reader())
    streams = hasattr(source, "__arrow_c_stream__") and (not is_frame(source) or type(source).__name__ == "RecordBatchReader")
    if streams:
        arrow = _arrow()
        return _selected(arrow.RecordBatchReader.from_stream(source), columns)
    return _arrow().Table.from_batches([source]) if library == "pyarrow" and type(source).__name__ == "RecordBatch" else source


def unreadable(source: Any) -> InputError:
    """What is wrong with something that is no table, and what to give in its place.

    Examples
    --------
    >>> print(unreadable([[1, "f"], [0, "m"]]))
    a table cannot be read from a list whose values have no names; give a list of dicts, or a dict of column to list
    """
    what, remedy = kind_of(source), "use a file, a database, a frame, an Arrow stream, a list of records, or a mapping of column to list"
    if isinstance(source, Iterator):
        remedy = "give a list of records, such as list(…) makes of it, or a dict of column to list"
    elif hasattr(source, "to_frame"):
        what, remedy = f"{what}, which is one column", "give the frame that it is a column of"
    elif hasattr(source, "__array__"):
        unnamed = "" if getattr(getattr(source, "dtype", None), "names", None) else ", whose columns have no names"
        what, remedy = f"{what}{unnamed}", "give a frame of it, such as pandas.DataFrame makes, or a dict of column to list"
    elif isinstance(source, (list, tuple)):
        what = f"{what} whose values have no names" if source else f"{what} without a row"
        remedy = "give a list of dicts, or a dict of column to list"
    return InputError(f"a table cannot be read from {what}; {remedy}")


def _selected(reader: Any, columns: Sequence[str]) -> Any:
    """The wanted columns of a stream, which is read once."""
    _check(reader.schema, columns)
    names = list(dict.fromkeys(columns))
    batches = [batch.select(names) for batch in reader]
    return _arrow().Table.from_batches(batches, schema=_arrow().schema([reader.schema.field(name) for name in names]))


def _of_hugging_face(source: Any, columns: Sequence[str]) -> Any:
    if isinstance(source, Mapping):
        raise InputError(f"a {type(source).__name__} has several tables ({', '.join(map(str, source))}); give one of them")
    if not hasattr(source, "select_columns") or not hasattr(source, "__len__"):
        raise InputError(f"a {type(source).__name__} cannot be counted as it is; give a Dataset that is loaded")
    for name in columns:
        column(dict.fromkeys(source.column_names, ()), name)
    return source.select_columns(list(dict.fromkeys(columns))).with_format("arrow")[:]


def _check(schema: Any, columns: Sequence[str]) -> None:
    for name in columns:
        column(dict.fromkeys(schema.names, ()), name)


def _arrow() -> Any:
    try:
        import pyarrow as pa
    except ImportError:
        raise InputError("this table needs the library pyarrow: pip install 'fairaudit-certify[files]'") from None
    return pa
