"""Delta tables, by their library (extra `delta`): the table's log says which files count, and what their partitions are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from fairaudit.errors import InputError
from fairaudit.tables.engines.request import Request
from fairaudit.tables.engines.survey import Survey
from fairaudit.tables.frames import tally_frame
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column

__all__ = ["read", "survey"]


def read(folder: str, request: Request) -> Tally:
    """Count the rows of a table as it stands now."""
    dataset = _opened(folder, request)
    for name in request.columns:
        column(dict.fromkeys(dataset.schema.names, ()), name)
    found = tally_frame(_fetched(folder, dataset, request.columns), request.columns, request.bins)
    if found is None:
        raise InputError(f"{folder}: the table cannot be counted")
    return found


def survey(folder: str, request: Request) -> Survey:
    """Look at every column of a table as it stands now."""
    dataset = _opened(folder, request)

    def common(name: str) -> Iterable[Sequence[Any]]:
        tally = tally_frame(_fetched(folder, dataset, [name]), [name])
        if tally is None:
            raise InputError("the column cannot be counted")
        counts = np.bincount(tally.codes[name], weights=tally.counts).astype(np.int64).tolist()
        return [(value, count, len(counts), tally.rows) for value, count in zip(tally.levels[name], counts, strict=True)]

    return Survey.of(dataset.schema.names, common)


def _opened(folder: str, request: Request) -> Any:
    """The files that count, with the values of their partitions; a table whose files need more than that is refused."""
    if request.table is not None or request.query is not None:
        raise InputError("a table or a query goes with a database; a Delta table is named by its folder")
    try:
        import pyarrow.dataset  # noqa: F401
        from deltalake import DeltaTable
        from deltalake.exceptions import DeltaError
    except ImportError:
        raise InputError(
            f"{folder}: this folder is a Delta table, which its library reads; install fairaudit-certify[delta], or write the rows to "
            "Parquet files in another folder"
        ) from None
    try:
        table = DeltaTable(folder)
        mapped = table.metadata().configuration.get("delta.columnMapping.mode", "none")
        if mapped != "none":
            raise InputError(
                f"{folder}: the Delta table maps the names of its columns, which is not read here; write its rows to Parquet files in "
                "another folder"
            )
        return table.to_pyarrow_dataset()
    except (DeltaError, OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{folder}: the Delta table cannot be read: {_said(error)}") from None


def _fetched(folder: str, dataset: Any, names: Sequence[str]) -> Any:
    """The wanted columns, in memory."""
    from pyarrow import ArrowException

    try:
        return dataset.to_table(columns=list(dict.fromkeys(names)))
    except (ArrowException, OSError) as error:
        raise InputError(f"{folder}: the Delta table cannot be read: {_said(error)}") from None


def _said(error: Exception) -> str:
    return " ".join(str(error).split("\n")[0].split())[:300] or type(error).__name__
