"""Filters that are cheaper as one table: every ordered pair of rows at once, in vectorised integer arithmetic."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import gcd, prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.columns import Column
from fairaudit.privacy.pairs import pairs_alike

MAX_TABLE = 2**28
"""Products of entries over all ordered pairs of rows, up to which the table is multiplied out."""


def worth_multiplying_out(mechanism: Mechanism) -> bool:
    """Whether the table multiplied out has hardly more entries than there are kinds of pairs to look at."""
    kinds = prod(min(2, len(f.inputs)) if pairs_alike(f) else len(f.inputs) * (len(f.inputs) - 1) + 1 for f in mechanism.factors)
    size = prod(len(f.inputs) for f in mechanism.factors)
    return 4 * kinds > size * size and size * size * prod(len(f.outputs) for f in mechanism.factors) <= MAX_TABLE


def whole_table(mechanism: Mechanism) -> tuple[NDArray[Any], list[int]]:
    """The whole table as Python integers, each row in lowest terms, and what each row sums to."""
    table: NDArray[Any] = np.array([[1]], dtype=object)
    for factor in mechanism.factors:
        table = np.kron(table, np.array([[v // gcd(*row) for v in row] for row in factor.rows], dtype=object))
    return table, [sum(row) for row in table.tolist()]


def hockey_sticks_of_rows(rows: NDArray[Any], bottoms: list[int], k: Fraction) -> Iterator[list[int]]:
    """Σ max(0, P − kQ) of all ordered pairs of rows i and j, row by row, as integers over ``k.denominator·bottoms[i]·bottoms[j]``."""
    dtype = np.int64 if max(bottoms) ** 2 * max(k.numerator, k.denominator) < 2**62 else object
    table, scales = rows.astype(dtype), np.array(bottoms, dtype=dtype)[:, None]
    for row, bottom in zip(table, bottoms, strict=True):
        gaps = (row * k.denominator)[None, :] * scales - table * (k.numerator * bottom)
        sums: list[int] = np.maximum(gaps, 0).sum(axis=1).tolist()
        yield sums


def greatest_ratios_of_rows(rows: NDArray[Any], bottoms: list[int]) -> list[Column]:
    """The greatest P/Q of all ordered pairs of rows, a zero denominator for infinity."""
    table = rows.astype(np.int64 if max(bottoms) < 2**31 else object)
    top = np.zeros((len(rows), len(rows)), dtype=table.dtype)
    low = np.ones_like(top)
    for column in table.T:
        p, q = np.broadcast_to(column[:, None], top.shape), np.broadcast_to(column[None, :], top.shape)
        better = p * low > top * q
        top, low = np.where(better, p, top), np.where(better, q, low)
    pairs = zip(top.tolist(), low.tolist(), bottoms, strict=True)
    return [(p * other, q * own) for tops, lows, own in pairs for p, q, other in zip(tops, lows, bottoms, strict=True)]
