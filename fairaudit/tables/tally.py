"""A log as its equal rows and how often each occurs, whatever counted them."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date, time
from decimal import Decimal
from itertools import islice
from typing import TYPE_CHECKING, Any
from uuid import UUID

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, RowsLost, shown
from fairaudit.tables.label_text import ACCEPTED, Reader, label_text
from fairaudit.tables.preparation import Entry
from fairaudit.tables.values import INT64
from fairaudit.words import brief

if TYPE_CHECKING:
    from fairaudit.tables.evaluations.samples import Evaluation

__all__ = ["Tally", "counted", "merged", "refuse_loss", "relabelled"]


BATCH = 50_000  # rows that an engine hands over at a time: a few MB
GIVE_FILES = "give the rows as a CSV or Parquet file"


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Tally:
    """A log whose equal rows were counted: the distinct rows, and how often each occurs.

    It stands for the log wherever `Law.from_log` and `Utility.from_table` take a table.

    Attributes
    ----------
    name : str
        Name of what was read, for messages.
    codes : dict of str to ndarray of int64
        For each column the values of the distinct rows, as positions in its levels.
    levels : dict of str to list
        For each column its different values.
    counts : ndarray of int64
        How often each row occurs.
    notes : tuple of str
        What was noticed while reading.
    find : callable or None
        Says where a distinct row, given by its position, occurs first: ``line 5``.
    preparation : tuple of mapping
        What was done to the log before it was counted (`fairaudit.tables.preparation`).
    evaluation : Evaluation or None
        How the rows were made of an evaluation log.

    Examples
    --------
    >>> tally = Tally.of("log", ("hired", "sex"), [("yes", "f", 3), ("no", "f", 1), ("yes", "m", 1)])
    >>> len(tally), tally.rows, tally["sex"]
    (3, 5, ['f', 'f', 'm'])
    """

    name: str
    codes: dict[str, NDArray[np.int64]]
    levels: dict[str, list[Any]]
    counts: NDArray[np.int64]
    notes: tuple[str, ...] = ()
    find: Callable[[Tally, int], str] | None = field(default=None, repr=False)
    preparation: tuple[Entry, ...] = ()
    evaluation: Evaluation | None = None

    @staticmethod
    def of(
        name: str,
        columns: Sequence[str],
        cells: Iterable[Sequence[Any]],
        *,
        read: Mapping[str, Reader] | None = None,
        equal: Collection[str] = (),
        find: Callable[[Tally, int], str] | None = None,
        notes: tuple[str, ...] = (),
    ) -> Tally:
        """Encode distinct rows as they come, each a value per column and then a count.

        Parameters
        ----------
        name : str
            Name of what was read.
        columns : sequence of str
            Its columns.
        cells : iterable of sequence
            The rows.
        read : mapping of str to callable, optional
            What makes values of a column of what the engine gives for them.
        equal : collection of str
            Columns in `read` of which different texts, as those of JSON, may have equal values; their rows are added up.
        find, notes
            As in the attributes.

        Raises
        ------
        InputError
            If two rows are equal, because values that the engine tells apart have become one; 0 and -0, and the forms of a missing
            value, are added up.
        """
        readers = {position: Reading(column, (read or {}).get(column)) for position, column in enumerate(columns)}
        later = {position for position, column in enumerate(columns) if column in equal}
        known: list[dict[type, dict[Hashable, int]]] = [{} for _ in columns]
        levels: list[list[Any]] = [[] for _ in columns]
        listed = [array("q") for _ in range(len(columns) + 1)]
        rows = iter(cells)
        while batch := list(islice(rows, BATCH)):
            *values, counts = zip(*batch, strict=True)
            listed[-1].extend(map(int, counts))
            for position, held in enumerate(values):
                part: Sequence[Any] = held
                if position not in later and (readers[position].read or len({*map(type, part)}) > 1 or type(part[0]) not in (str, int)):
                    part = list(map(readers[position], part))
                kinds = {*map(type, part)}
                codes = {kind: known[position].setdefault(kind, {}) for kind in kinds}
                for value in dict.fromkeys(part) if len(kinds) == 1 else part:
                    if value not in (own := codes[type(value)]):
                        own[value] = len(levels[position])
                        levels[position].append(value)
                if len(kinds) == 1:
                    listed[position].extend(map(codes[kinds.pop()].__getitem__, part))
                else:
                    listed[position].extend(codes[type(value)][value] for value in part)
        arrays = [np.array(part, dtype=np.int64) for part in listed]
        found = Tally(name, dict(zip(columns, arrays, strict=False)), dict(zip(columns, levels, strict=True)), arrays[-1], notes, find)
        return _unmarked(found.checked(), [readers[position] if position in later else None for position in range(len(columns))])

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: where rows occur first is known only while what was read is at hand."""
        return {**vars(self), "find": None}

    def checked(self) -> Tally:
        """Give the tally back if its rows differ.

        Raises
        ------
        InputError
            If two rows are equal.
        """
        values, first = np.unique(_keys(self.codes, self.levels), return_index=True)
        if len(values) < len(self):
            again = np.setdiff1d(np.arange(len(self)), first)[0]
            raise InputError(
                f"{self.name}: rows that differ where they are held have become equal ({self.locate(int(again))}); "
                "cast the columns to text so that different values have different texts"
            )
        return self

    @property
    def columns(self) -> list[str]:
        """Column names, in order."""
        return list(self.codes)

    @property
    def rows(self) -> int:
        """How many rows were counted."""
        return int(self.counts.sum())

    def conserving(self, rows: int, library: str, advice: str = GIVE_FILES) -> Tally:
        """Give the tally back if it counts as many rows as were read (`refuse_loss`)."""
        refuse_loss(self.name, self.rows, rows, library, advice)
        return self

    def __len__(self) -> int:
        """Return the number of distinct rows."""
        return len(self.counts)

    def __getitem__(self, name: str) -> list[Any]:
        """Values of a column in the distinct rows."""
        levels = self.levels[name]
        return [levels[code] for code in self.codes[name].tolist()]

    def only(self, rows: NDArray[np.bool_]) -> Tally:
        """The tally of some of the distinct rows, with the levels that occur in them."""
        kept = np.flatnonzero(rows)
        codes: dict[str, NDArray[np.int64]] = {}
        levels: dict[str, list[Any]] = {}
        for name, held in self.codes.items():
            occurring, codes[name] = np.unique(held[kept], return_inverse=True)
            levels[name] = [self.levels[name][code] for code in occurring.tolist()]

        def find(_: Tally, position: int) -> str:
            return self.locate(int(kept[position]))

        return replace(self, codes=codes, levels=levels, counts=self.counts[kept], find=find)

    def locate(self, position: int) -> str:
        """Name the first row that is equal to a distinct one; where rows have no place, name the row by its values."""
        if self.find is not None:
            return self.find(self, position)
        parts = [f"{name}={shown(self.levels[name][codes[position]], 30)}" for name, codes in self.codes.items()]
        return f"the row with {', '.join(parts)}"


def refuse_loss(name: str, counted: int, rows: int, library: str, advice: str = GIVE_FILES) -> None:
    """Refuse a log of which a library counted more or fewer rows than it read.

    Parameters
    ----------
    name : str
        What was read.
    counted, rows : int
        How many rows the groups of equal rows have, and how many were read, counted without groups.
    library : str
        What counted them.
    advice : str
        What to do about it.

    Raises
    ------
    RowsLost
        If the numbers differ.

    Examples
    --------
    >>> try:
    ...     refuse_loss("log", 3, 5, "pandas")
    ... except RowsLost as error:
    ...     print(error)
    log: pandas counted 3 of 5 rows, which is no fault of the log; nothing is certified; give the rows as a CSV or Parquet file
    """
    if counted != rows:
        raise RowsLost(
            f"{name}: {library} counted {counted:,} of {rows:,} rows, which is no fault of the log; nothing is certified; {advice}"
        )


def counted(table: Any, rows: int) -> NDArray[np.int64]:
    """How many rows of the log each row of a table stands for."""
    return table.counts if isinstance(table, Tally) else np.ones(rows, dtype=np.int64)


class _Mark(str):
    """What stands for -0 and for a missing value while rows are told apart."""

    __slots__ = ()


class _NotANumber:
    """What stands for a NaN, which equals no other."""


class Reading:
    """Values of a column as a `Tally` keeps them: numbers, truth values and texts; each different one is looked at once."""

    def __init__(self, column: str, read: Reader | None) -> None:
        self.column, self.read = column, read
        self.known: dict[tuple[type, Hashable], Any] = {}

    def __call__(self, value: Any) -> Any:
        """Read a value."""
        if isinstance(value, (float, np.floating)):
            return _zero_or_number(float(value))
        try:
            if isinstance(value, (date, time)):  # equal to others of another fold
                return self._plain(value)
            key = (type(value), value)
            if key not in self.known:
                self.known[key] = self._plain(value)
        except TypeError:
            raise InputError(f"column {shown(self.column)} holds {shown(value)}, which is not a label; {ACCEPTED}") from None
        except InputError as error:
            raise InputError(f"column {shown(self.column)}: {error}") from None
        return self.known[key]

    def _plain(self, value: Any) -> Any:
        if self.read is not None:
            value = self.read(value)
        if value is None:
            return None
        if type(value).__name__ in ("NAType", "NaTType"):
            return _Mark(type(value).__name__)
        if isinstance(value, np.generic) and not isinstance(value, (np.datetime64, np.timedelta64)):
            value = value.item()
        if isinstance(value, Decimal) and value.is_nan():
            return _NotANumber()
        return label_text(value) if isinstance(value, (date, time, UUID, np.datetime64)) else value


def _zero_or_number(value: float) -> Any:
    if value != value:
        return _NotANumber()
    return _Mark("-0") if value == 0 and str(value) == "-0.0" else value


def _unmarked(tally: Tally, readers: Sequence[Reading | None]) -> Tally:
    """Put values for what stands for them, and add up the rows that have become equal."""
    levels: dict[str, list[Any]] = {}
    for (name, held), reader in zip(tally.levels.items(), readers, strict=True):
        values = list(held if reader is None else map(reader, held))
        levels[name] = [
            (0.0 if value == "-0" else None) if type(value) is _Mark else None if type(value) is _NotANumber else value for value in values
        ]
    return relabelled(tally, levels)


def _keys(columns: Mapping[str, NDArray[np.int64]], levels: Mapping[str, Sequence[Any]]) -> NDArray[np.int64]:
    """A number for each row, equal where all codes are, and in the order of the codes."""
    rows = len(next(iter(columns.values())))
    keys, span = np.zeros(rows, dtype=np.int64), 1
    for column, codes in columns.items():
        size = len(levels[column]) or 1
        if span * size > INT64:
            keys, span = np.unique(keys, return_inverse=True)[1], rows
        keys, span = keys * size + codes, span * size
    return keys


def relabelled(tally: Tally, levels: Mapping[str, list[Any]]) -> Tally:
    """Write the values of columns otherwise, and add up rows if some have become equal."""
    found = replace(tally, levels=dict(levels))
    same = any(len({(type(value), value) for value in values}) < len(values) for values in levels.values())
    return merged(found) if same else found


def merged(tally: Tally) -> Tally:
    """Add up rows that have become equal."""
    codes: dict[str, Any] = {}
    levels: dict[str, list[Any]] = {}
    for name, values in tally.levels.items():
        known = {key: code for code, key in enumerate(dict.fromkeys((type(value), value) for value in values))}
        codes[name] = np.array([known[type(value), value] for value in values], dtype=np.int64)[tally.codes[name]]
        levels[name] = [value for _, value in known]
    _, first, inverse = np.unique(_keys(codes, levels), return_index=True, return_inverse=True)
    counts = np.zeros(len(first), dtype=np.int64)
    np.add.at(counts, inverse, tally.counts)
    return replace(
        tally,
        codes={name: part[first] for name, part in codes.items()},
        levels=levels,
        counts=counts,
        find=lambda _, position: tally.locate(int(first[position])),
    )
