"""Passes over big float matrices: blocks of rows that fit into a cache, on all cores, without a copy of the whole.

The matrices may be memory-mapped files. float32 entries are converted block by block, exactly, so that sums are always formed in float64.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.rationals import Number

__all__ = ["Numbers", "Weights", "each_block", "equal_to_previous", "least_and_sums", "products", "quotients"]


BLOCK_BYTES = 1 << 22  # 4 MiB: two blocks and their results stay in the cache of one core

Floats = NDArray[np.float64]
"""An array of float64."""

Weights = NDArray[Any]
"""An array of exact numbers: int64, Python integers, or float64."""

Numbers = (
    NDArray[np.integer]
    | NDArray[np.floating]
    | NDArray[np.object_]
    | Sequence[Number]
    | Sequence[Sequence[Number]]
    | Sequence[Sequence[Sequence[Number]]]
)
"""Numbers in one, two or three dimensions: an array, or nested lists."""


def each_block(rows: int, step: int, work: Callable[[int, int], None]) -> None:
    """Call `work` with the first row of every block of `step` rows and the one after its last, on all cores if there are many blocks.

    Examples
    --------
    >>> each_block(5, 2, print)
    0 2
    2 4
    4 5
    """
    blocks = [(first, min(first + step, rows)) for first in range(0, rows, step)]
    parts = 1 if len(blocks) <= 8 else os.cpu_count() or 1

    def every(part: int) -> None:
        for first, last in blocks[part * len(blocks) // parts : (part + 1) * len(blocks) // parts]:
            work(first, last)

    if parts == 1:
        every(0)
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(parts) as pool:
        list(pool.map(every, range(parts)))


def _block_rows(matrix: NDArray[Any]) -> int:
    """How many rows of a matrix fit into a cache."""
    return max(1, BLOCK_BYTES // max(1, int(matrix.shape[1]) * matrix.itemsize))


def least_and_sums(matrix: NDArray[Any]) -> tuple[float, Floats]:
    """Least entry of a float matrix (nan if any entry is), and the sum of every row in float64.

    Examples
    --------
    >>> least_and_sums(np.array([[0.5, 0.25], [1, 2]]))
    (0.25, array([0.75, 3.  ]))
    """
    sums = np.empty(len(matrix))
    least: list[float] = []

    def work(first: int, last: int) -> None:
        block = matrix[first:last]
        least.append(float(block.min()))
        np.add.reduce(block, axis=1, dtype=np.float64, out=sums[first:last])

    with np.errstate(over="ignore", invalid="ignore"):
        each_block(len(matrix), _block_rows(matrix), work)
    return float(np.min(least)), sums


def products(matrix: NDArray[Any], values: NDArray[Any]) -> Floats:
    """Row sums of matrix * values; `values` is one row for all, or a row for each.

    They are formed in float32 if `values` are, else in float64. Integers are converted to float64 as well; the caller makes sure that the
    sums stay below 2^53, where that is exact.

    Examples
    --------
    >>> products(np.array([[1, 2], [3, 4]]), np.array([1.0, 0.5]))
    array([2., 5.])
    """
    result = np.empty(len(matrix))
    kind = np.float32 if values.dtype == np.float32 else np.float64

    def work(first: int, last: int) -> None:
        g = values if values.ndim == 1 else values[first:last]
        result[first:last] = np.vecdot(matrix[first:last].astype(kind, copy=False), g.astype(kind, copy=False))

    each_block(len(matrix), _block_rows(matrix), work)
    return result


def equal_to_previous(matrix: NDArray[Any], wanted: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which rows equal the row before them; rows that are not wanted are not looked at, and the first row equals nothing.

    Examples
    --------
    >>> equal_to_previous(np.array([[1, 2], [1, 2], [3, 4]]), np.ones(3, dtype=bool))
    array([False,  True, False])
    """
    result = np.zeros(len(matrix), dtype=bool)

    def work(first: int, last: int) -> None:
        begin = max(first, 1)
        if wanted[begin:last].any():
            np.logical_and.reduce(matrix[begin:last] == matrix[begin - 1 : last - 1], axis=1, out=result[begin:last])

    each_block(len(matrix), _block_rows(matrix), work)
    return result


def quotients(weights: NDArray[Any], sums: NDArray[Any]) -> NDArray[np.float64]:
    """Rows divided by their sums in float64, each entry off by three roundings at most where these are exact, underflow aside."""
    if weights.dtype == object or sums.dtype == object:
        try:
            weights, sums = weights.astype(np.float64), sums.astype(np.float64)
        except OverflowError:
            return np.array(
                [[w / total for w in row] for row, total in zip(weights.tolist(), sums.tolist(), strict=True)], dtype=np.float64
            )
    rows: NDArray[np.float64] = np.divide(weights, sums[:, None], dtype=np.float64)
    return rows
