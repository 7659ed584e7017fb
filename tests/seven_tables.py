"""A product of filters that has too many kinds of pairs of rows to go through, and the pairs that are the worst ones of it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import prod

from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.privacy.pairs import MAX_KINDS, factor_kinds

TOTAL = 100**7
"""What the weights of a row of the product add up to."""


def seven_tables() -> Mechanism:
    """Seven different tables of four rows; in each the rows in between are mixtures of the outer two."""
    parts = []
    for n in range(7):
        rows = ((90 - n, 10 + n), (70, 30), (50, 50), (20 + n, 80 - n))
        parts.append(Factor((("a",), ("b",), ("c",), ("d",)), (("0",), ("1",)), rows, 100))
    assert prod(len(factor_kinds(part)[0]) for part in parts) == 13**7 > MAX_KINDS
    return Mechanism(tuple(parts))


def outer_pairs(mechanism: Mechanism) -> Iterator[tuple[list[int], list[int]]]:
    """The weights of two rows of the product, of outer rows of all tables, some of them exchanged."""
    for turned in product([False, True], repeat=len(mechanism.factors)):
        ends = [part.rows[::-3] if turn else part.rows[::3] for part, turn in zip(mechanism.factors, turned, strict=True)]
        first, second = ([prod(entries) for entries in product(*(rows[i] for rows in ends))] for i in range(2))
        yield first, second
