"""Columns of frames in memory as small integers, counted a block of rows at a time on all cores."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import prod
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import FairauditError
from fairaudit.tables.label_text import native_values

__all__ = ["DENSE", "Coded", "UnknownValueError", "coded_column", "count_combinations"]

Codes = NDArray[Any]
DENSE = 1 << 20  # combinations that are counted in one array of 8 MiB; more are sorted
BLOCK_ROWS = 1 << 17  # rows whose codes stay in the cache of one core
PART_ROWS = 1 << 15  # rows for whose codes Arrow does not ask the operating system for memory
SAMPLE = 100_000  # rows that say which values there are; the rest is checked against them
FEW = 250  # different values that fit a byte, with room for those that the sample lacked
SLOT_BITS = 16  # 65,536 slots for at most 250 values: one factor in a few keeps them apart


class UnknownValueError(FairauditError):
    """A column has a value that its sample has not."""


@dataclass(frozen=True)
class Coded:
    """A column as small integers.

    Attributes
    ----------
    rows : int
        Its length.
    values : list
        What the integers stand for; several may stand for the same.
    codes : callable
        The integers of the rows from one position to another.
    low : int
        The integer of the first value.
    """

    rows: int
    values: list[Any]
    codes: Callable[[int, int], Codes]
    low: int = 0

    @staticmethod
    def of(codes: Codes, values: list[Any], low: int = 0) -> Coded:
        """Wrap an array of integers."""
        return Coded(len(codes), values, lambda first, last: codes[first:last], low)


def coded_column(column: Any, *, sampled: bool = False) -> Coded | None:
    """Write a column as small integers.

    Parameters
    ----------
    column : pandas Series or ndarray
        The column.
    sampled : bool
        Whether to look for values in the first rows only; counting raises `UnknownValueError` where they do not suffice.

    Returns
    -------
    Coded or None
        None if that is not cheap.

    Examples
    --------
    >>> column = coded_column(np.array([4, 3, 4]))
    >>> column.values, column.low, column.codes(0, 2).tolist()
    ([3, 4], 3, [4, 3])
    """
    if isinstance(column, np.ndarray):
        return _whole(column, sampled)
    from pandas import CategoricalDtype, StringDtype

    if isinstance(column.dtype, CategoricalDtype):
        return _levels(column.array.codes, native_values(column.dtype.categories.to_series()), sampled)
    if isinstance(column.dtype, np.dtype):
        values = column.to_numpy()
        found = _same_objects(values, sampled) if values.dtype == object else _whole(values, sampled)
    elif "Arrow" in type(column.array).__name__:
        found = _arrow_texts(column.array, sampled)
    else:
        found = _same_objects(np.asarray(column.array), sampled) if isinstance(column.dtype, StringDtype) else None
    return found


def count_combinations(columns: Sequence[Coded]) -> Iterator[tuple[Any, ...]]:
    """Count the combinations of values: a value for each column, and how many rows have them.

    Raises
    ------
    UnknownValueError
        If a column that was sampled has other values, too.

    Examples
    --------
    >>> list(count_combinations([coded_column(np.array([4, 3, 4])), coded_column(np.array([True, True, True]))]))
    [(3, True, 1), (4, True, 2)]
    """
    shape = tuple(len(column.values) for column in columns)
    counts = _of_equal_values(_counted(columns, prod(shape)), columns)
    cells = np.flatnonzero(counts)
    places = [at.tolist() for at in np.unravel_index(cells, shape)]
    held = [[column.values[at] for at in own] for column, own in zip(columns, places, strict=True)]
    yield from zip(*held, counts[cells].tolist(), strict=True)


def _counted(columns: Sequence[Coded], cells: int) -> Codes:
    """How many rows have each combination; where a byte tells them apart, two rows that follow each other are counted in one step."""
    rows = columns[0].rows
    kind = next(kind for kind in (np.uint8, np.uint16, np.uint32) if cells - 1 <= np.iinfo(kind).max)
    paired = kind is np.uint8 and rows > BLOCK_ROWS
    counts = np.zeros((1 << 16) + 256 if paired else cells, dtype=np.int64)
    adding = Lock()
    blocks = deque(range(0, rows, BLOCK_ROWS))

    # Modulo a power of two, at least the number of combinations: what wraps around on the way is right in the end.
    least = 0
    for column in columns:
        least = least * len(column.values) + column.low
    offset = kind(least % (int(np.iinfo(kind).max) + 1))

    def work(_: int) -> None:
        keys: Codes = np.empty(min(rows, BLOCK_ROWS), dtype=kind)
        spare = np.empty_like(keys)
        places = np.empty(len(keys), dtype=np.intp)
        found = np.zeros_like(counts)
        try:
            while (first := _next(blocks)) is not None:
                last = min(first + BLOCK_ROWS, rows)
                key = keys[: last - first]
                key[:] = _in_kind(columns[0].codes(first, last), spare)
                for column in columns[1:]:
                    key *= kind(len(column.values))
                    key += _in_kind(column.codes(first, last), spare)
                if offset:
                    key -= offset
                if paired:
                    if len(key) % 2:
                        found[(1 << 16) + int(key[-1])] += 1
                    key = key[: len(key) // 2 * 2].view(np.uint16)
                place = places[: len(key)]
                place[:] = key
                np.add.at(found, place, 1)
        finally:
            blocks.clear()  # nothing more has to be counted after an error
        with adding:
            np.add(counts, found, out=counts)

    parts = min(os.cpu_count() or 1, len(blocks))
    if len(blocks) <= 8:
        work(0)
    else:
        with ThreadPoolExecutor(parts) as pool:
            list(pool.map(work, range(parts)))
    if paired:
        pairs, single = counts[: 1 << 16].reshape(256, 256), counts[1 << 16 :]
        counts = (pairs.sum(axis=0) + pairs.sum(axis=1) + single)[:cells]
    return counts


def _next(blocks: deque[int]) -> int | None:
    try:
        return blocks.popleft()
    except IndexError:
        return None


def _in_kind(codes: Codes, spare: Codes) -> Codes:
    """Codes modulo the range of another type of whole numbers, in place where they are as wide."""
    if codes.itemsize == spare.itemsize and codes.dtype.isnative:
        return codes.view(spare.dtype)
    found = spare[: len(codes)]
    np.copyto(found, codes, casting="unsafe")
    return found


def _of_equal_values(counts: Codes, columns: Sequence[Coded]) -> Codes:
    """Counts with those of equal texts, of which memory holds several, added up in the place of the first."""
    held = counts.reshape([len(column.values) for column in columns])
    for axis, column in enumerate(columns):
        first: dict[tuple[type, Any], int] = {}
        at = [first.setdefault((type(value), value), place) for place, value in enumerate(column.values)]
        if len(first) < len(at):
            added = np.zeros_like(held)
            np.add.at(np.moveaxis(added, axis, 0), at, np.moveaxis(held, axis, 0))
            held = added
    return held.ravel()


def _levels(held: Codes, values: list[Any], sampled: bool) -> Coded:
    """Positions in a list of values, -1 where one is missing; none is, if none is in a sample."""
    if not sampled or held[:SAMPLE].min() < 0:
        return Coded.of(held, [None, *values], -1)

    def codes(first: int, last: int) -> Codes:
        block = held[first:last]
        if block.min() < 0:
            raise UnknownValueError
        return block

    return Coded(len(held), values, codes)


def _whole(values: NDArray[Any], sampled: bool) -> Coded | None:
    """Whole numbers or truth values of a small range."""
    if values.dtype.kind not in "iub" or not len(values):
        return None
    seen = values[:SAMPLE] if sampled else values
    low, high = int(seen.min()), int(seen.max())
    if high - low >= DENSE:
        return None
    unsigned = f"{values.dtype.byteorder}u{values.dtype.itemsize}"

    def codes(first: int, last: int) -> Codes:
        block = values[first:last]
        # as unsigned integers, negative ones are above all others
        if sampled and (block.view(unsigned).max() > high if low == 0 else block.min() < low or block.max() > high):
            raise UnknownValueError
        return block

    return Coded(len(values), [bool(v) if values.dtype.kind == "b" else v for v in range(low, high + 1)], codes, low)


def _arrow_texts(held: Any, sampled: bool) -> Coded | None:
    """Texts that Arrow holds, if they are few."""
    import pyarrow as pa
    import pyarrow.compute as pc

    texts = held.__arrow_array__()
    if not (pa.types.is_string(texts.type) or pa.types.is_large_string(texts.type)):
        return None
    known = pc.unique(texts.slice(0, SAMPLE) if sampled else texts).drop_null()
    if not 0 < len(known) <= FEW:
        return None
    listed = [None, *known.to_pylist()] if texts.null_count else known.to_pylist()
    values = pa.array(listed, type=texts.type)

    def codes(first: int, last: int) -> Codes:
        whole = np.empty(last - first, dtype=np.uint8)
        for start in range(0, len(whole), PART_ROWS):
            part = whole[start : start + PART_ROWS]
            found = pc.index_in(texts.slice(first + start, len(part)), value_set=values)
            if found.null_count:
                raise UnknownValueError
            part[:] = found.to_numpy()
        return whole

    return Coded(len(texts), listed, _letters(texts, listed) or codes)


def _letters(texts: Any, values: list[str]) -> Callable[[int, int], Codes] | None:
    """Codes of texts that are single ASCII characters: their bytes follow each other, so that none has to be looked up."""
    if texts.num_chunks != 1 or texts.null_count or not all(len(value) == 1 and value.isascii() for value in values):
        return None
    chunk = texts.chunk(0)
    _, places, content = chunk.buffers()
    starts: Codes = np.frombuffer(places, np.int64 if "large" in str(texts.type) else np.int32)[chunk.offset :]
    letters = np.frombuffer(content, np.uint8)
    table = np.full(256, 255, dtype=np.uint16)
    table[list(map(ord, values))] = np.arange(len(values))
    pairs = (table[:, np.newaxis] << 8 | table).ravel()  # the same whichever of two letters a machine writes first

    def codes(first: int, last: int) -> Codes:
        ends = starts[first : last + 1]
        steps = ends.astype(np.uint8)  # as many letters as rows, and 1 modulo 256 for each row, is one for each
        block = letters[ends[0] : ends[-1]]
        if len(block) != last - first or (steps[1:] - steps[:-1] != 1).any():
            raise UnknownValueError
        if len(block) % 2:
            block = np.append(block, block[-1])
        found: Codes = pairs.take(block.view(np.uint16)).view(np.uint8)[: last - first]
        if found.max() == 255:
            raise UnknownValueError
        return found

    return codes


def _same_objects(values: NDArray[Any], sampled: bool) -> Coded | None:
    """Texts of which few objects stand in many rows, as most readers of files make them: an object is known by its address."""
    from pandas import NA, isna

    if values.dtype != object or not values.flags.c_contiguous or not len(values):
        return None
    at = np.frombuffer(values, dtype=np.uintp)
    found = _first_places(at[:SAMPLE] if sampled else at)
    if found is None:
        return None
    objects = [values[place] for place in found]
    if not all(isinstance(value, str) or value is None or value is NA or (isinstance(value, float) and isna(value)) for value in objects):
        return None
    addresses = at[found]
    slots = _slots(addresses)
    if slots is None:
        return None
    factor, table = slots
    shift = np.uint64(64 - SLOT_BITS)

    def codes(first: int, last: int) -> Codes:
        block = at[first:last]
        found: Codes = table[(block * factor) >> shift]
        if (addresses[found] != block).any():
            raise UnknownValueError
        return found

    return Coded(len(values), [value if isinstance(value, str) else None for value in objects], codes)


def _first_places(at: NDArray[np.uintp]) -> list[int] | None:
    """First place of each different number; None if they are many."""
    places: dict[int, int] = {}
    for first in range(0, len(at), BLOCK_ROWS):
        numbers, firsts = np.unique(at[first : first + BLOCK_ROWS], return_index=True)
        if len(numbers) > FEW:
            return None
        for number, place in zip(numbers.tolist(), firsts.tolist(), strict=True):
            places.setdefault(number, first + place)
        if len(places) > FEW:
            return None
    return list(places.values())


def _slots(addresses: NDArray[np.uintp]) -> tuple[np.uint64, NDArray[np.uint8]] | None:
    """A factor whose products with the addresses differ in their first bits, and the table from those bits to the addresses."""
    generator = np.random.default_rng(0)
    for _ in range(100):
        factor = np.uint64(generator.integers(2**63, 2**64, dtype=np.uint64) | np.uint64(1))
        slots = (addresses.astype(np.uint64) * factor) >> np.uint64(64 - SLOT_BITS)
        if len(np.unique(slots)) == len(slots):
            table = np.zeros(1 << SLOT_BITS, dtype=np.uint8)
            table[slots] = np.arange(len(slots))
            return factor, table
    return None
