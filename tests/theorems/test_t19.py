"""T19: the ends of ratios over everything that undecided decisions may have meant, against going through meanings one by one."""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from math import inf
from typing import Any

import pytest
import tiers

from fairaudit.theorems.t19 import ratio_range

TABLES = int(os.environ.get("FAIRAUDIT_UNDECIDED", "60"))
"""How many random tables; more whenever somebody doubts."""

F = Fraction

Cell = tuple[tuple[Fraction, ...], int]
"""What the decided rows are worth, and how many rows are undecided."""


def quotient(top: Fraction, bottom: Fraction) -> Any:
    return (inf if top else F(1)) if not bottom else top / bottom


def greatest_ratio(blocks: list[list[Fraction]]) -> Any:
    return max((quotient(a, b) for means in blocks for a, b in product(means, means)), default=F(1))


def random_tables() -> Iterator[tuple[list[list[Cell]], tuple[Fraction, Fraction]]]:
    """Small tables with zeros and ties; some cells have undecided rows only."""
    pick = random.Random(tiers.fresh(19))
    for _ in range(TABLES):
        low, high = pick.choice([(F(0), F(1)), (F(0), F(1)), (F(1, 2), F(2)), (F(1), F(1))])
        values = [low, high, (low + high) / 2]
        left, tables = 5, []
        for _ in range(pick.randint(1, 2)):
            block = []
            for _ in range(pick.randint(2, 3)):
                undecided = pick.randint(0, min(left, 2))
                left -= undecided
                decided = pick.randint(0 if undecided else 1, 4)
                block.append((tuple(pick.choice(values) for _ in range(decided)), undecided))
            tables.append(block)
        yield tables, (low, high)


def mean(cell: Cell, meanings: tuple[Fraction, ...]) -> Fraction:
    return sum((*cell[0], *meanings), F(0)) / (len(cell[0]) + len(meanings))


def ratios(table: list[list[Cell]], worth: list[Fraction]) -> Iterator[Any]:
    """The greatest ratio for every way in which single undecided rows can be worth one of some values."""
    rows = sum(undecided for block in table for _, undecided in block)
    for meanings in product(worth, repeat=rows):
        left = iter(meanings)
        yield greatest_ratio([[mean(cell, tuple(next(left) for _ in range(cell[1]))) for cell in block] for block in table])


def ends(table: list[list[Cell]], limits: tuple[Fraction, Fraction]) -> list[list[tuple[Fraction, Fraction]]]:
    return [[(mean(cell, limits[:1] * cell[1]), mean(cell, limits[1:] * cell[1])) for cell in block] for block in table]


def test_no_meaning_of_single_rows_leaves_the_range_and_one_attains_its_upper_end() -> None:
    seen = set()
    for table, (low, high) in random_tables():
        found = ratio_range(ends(table, (low, high)))
        every = list(ratios(table, [low, (2 * low + high) / 3, high]))
        assert max(every) == found.greatest and min(every) >= found.least, table
        seen |= {found.greatest == inf, found.least > 1, found.least == 1 < found.greatest}
    assert tiers.enough(seen == {True, False})


def test_the_lower_end_is_attained_by_values_between() -> None:
    """Where the ends of a block leave room, all means are one value there; else every mean is as near as it can be."""
    apart = 0
    for table, limits in random_tables():
        boxes = ends(table, limits)
        found = ratio_range(boxes)
        blocks = []
        for block in boxes:
            top, bottom = max(low for low, _ in block), min(high for _, high in block)
            middle = (top + bottom) / 2
            blocks.append([min(max(middle, low), high) for low, high in block])
        assert all(
            low <= value <= high for box, own in zip(boxes, blocks, strict=True) for (low, high), value in zip(box, own, strict=True)
        )
        assert greatest_ratio(blocks) == found.least
        apart += found.least > 1
    assert apart


def test_the_places_attain_the_ends() -> None:
    for table, limits in random_tables():
        boxes = ends(table, limits)
        found = ratio_range(boxes)
        assert (found.greatest_at is None) == (found.greatest == 1) and (found.least_at is None) == (found.least == 1)
        for at, ratio, side in ((found.greatest_at, found.greatest, 1), (found.least_at, found.least, 0)):
            if at is not None:
                block, higher, lower = at
                assert quotient(boxes[block][higher][side], boxes[block][lower][1 - side]) == ratio and higher != lower


@pytest.mark.parametrize(
    ("blocks", "least", "greatest"),
    [
        ([[(F(0), F(0)), (F(0), F(0))]], 1, 1),  # 0/0 is parity
        ([[(F(0), F(0)), (F(1), F(1))]], inf, inf),
        ([[(F(0), F(1)), (F(1), F(1))]], 1, inf),
        ([[(F(0), F(1)), (F(0), F(1))]], 1, inf),  # undecided alone
        ([[(F(0), F(1))], [(F(1), F(1))]], 1, 1),  # no context has two groups
        ([[(F(1), F(2)), (F(3), F(3))], [(F(1), F(1)), (F(1), F(4))]], F(3, 2), 4),
        ([[(F(1), F(4)), (F(2), F(3))]], 1, 3),  # the widest cell has both outer ends: its own quotient of 4 is none
        ([], 1, 1),
    ],
)
def test_edges(blocks: list[list[tuple[Fraction, Fraction]]], least: Any, greatest: Any) -> None:
    found = ratio_range(blocks)
    assert (found.least, found.greatest) == (least, greatest)
