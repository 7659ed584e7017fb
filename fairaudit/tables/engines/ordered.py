"""Big tables of counts or probabilities in delimited text: DuckDB reads them, and the rows keep their order."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, naming
from fairaudit.tables.cells import Cells
from fairaudit.tables.csv import CsvTable, line_of_row
from fairaudit.tables.engines.duckdb import connected, delimited_text, progress, told
from fairaudit.tables.engines.request import Request, attended
from fairaudit.tables.values import column

__all__ = ["read_ordered"]

WHOLE = "[0-9]{1,15}"
"""Counts that are read as integers of the machine."""

MOST = 2.0**62
"""More than this they do not add up to; greater sums are of Python's integers."""


@dataclass(frozen=True)
class Lines(Sequence[int]):
    """The lines on which the rows of a text end, looked up where one is asked for."""

    path: str
    rows: int

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.rows

    @overload
    def __getitem__(self, position: int) -> int: ...

    @overload
    def __getitem__(self, position: slice) -> list[int]: ...

    def __getitem__(self, position: int | slice) -> int | list[int]:
        """Number of the line of a row."""
        if isinstance(position, slice):
            return [self[i] for i in range(*position.indices(self.rows))]
        return line_of_row(self.path, position)


def read_ordered(path: str, request: Request, numeric: Collection[str]) -> CsvTable | None:
    """Read columns of a delimited text as the CSV reader does; None if the text is for that reader.

    Parameters
    ----------
    path : str
        The file.
    request : Request
        Which columns are wanted, and which of them holds counts; it is asked for nothing else but memory and progress.
    numeric : collection of str
        Columns of numbers, of which there may be as many different ones as rows.

    Raises
    ------
    InputError
        If a column is not there.
    """
    try:
        text = delimited_text([path])
    except InputError:
        return None
    if text is None:
        return None
    known = text.layout.columns
    places = {name: f"c{known.index(name)}" for name in request.columns if name in known} or {known[0]: "c0"}
    try:
        with connected(request) as connection, told(request, path):
            held = attended(
                lambda: _held(connection, text.source, places, request.count, {*numeric}),
                connection.interrupt,
                request,
                lambda: progress(connection),
            )
    except InputError:
        return None  # whatever is wrong, the CSV reader says on which line; and if nothing is wrong, it reads the file
    rows = len(next(iter(held.values())))
    if not rows or not text.complete(rows):
        return None
    with naming(Path(path).name):
        for name in request.columns:
            column(dict.fromkeys(known, ()), name)
    return CsvTable(Path(path).name, held, Lines(path, rows), text.layout.delimiter, text.layout.notes)


def _held(connection: Any, source: str, places: dict[str, str], count: str | None, numeric: set[str]) -> dict[str, Any]:
    """The columns, in the order of the rows."""
    connection.execute("set preserve_insertion_order = true")
    listed = ", ".join(f"coalesce({place}, '') as {place}" for place in dict.fromkeys(places.values()))
    connection.execute(f"create temporary table held as select {listed} from {source}")  # noqa: S608
    whole = {place for name, place in places.items() if name == count and _is_whole(connection, place)}
    labels = {place: _labels(connection, place) for name, place in places.items() if name not in numeric}
    others = {place: f"cast({place} as bigint) as {place}" if place in whole else place for place in places.values() if place not in labels}
    picked = [*(f"enum_code(cast({place} as of_{place})) as {place}" for place in labels), *others.values()]
    found = connection.execute(f"select rowid as place, {', '.join(picked)} from held").fetchnumpy()  # noqa: S608
    order = found["place"]
    if (np.diff(order) != 1).any():
        found = {name: part[np.argsort(order)] for name, part in found.items()}
    return {name: _column(found[place], labels.get(place), whole=place in whole) for name, place in places.items()}


def _is_whole(connection: Any, place: str) -> bool:
    """Whether all counts are whole numbers of the machine."""
    plain = f"regexp_full_match({place}, '{WHOLE}')"
    ((other,),) = connection.execute(f"select count(*) filter (not {plain}) from held").fetchall()  # noqa: S608
    return not other


def _labels(connection: Any, place: str) -> list[str]:
    """The different labels of a column, in order of first appearance, as the values of a type."""
    first = f"(select {place} as k, min(rowid) as place from held group by k)"  # noqa: S608
    connection.execute(f"create type of_{place} as enum (select k from {first} order by place)")  # noqa: S608
    return [text for (text,) in connection.execute(f"select unnest(enum_range(null::of_{place}))").fetchall()]


def _column(found: NDArray[Any], labels: list[str] | None, *, whole: bool) -> Cells | NDArray[np.int64] | list[str]:
    if labels is not None:
        return Cells(found.astype(np.int64), labels)
    if whole and float(found.sum(dtype=np.float64)) < MOST:
        return found.astype(np.int64, copy=False)
    return list(map(str, found.tolist())) if whole else found.tolist()
