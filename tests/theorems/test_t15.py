"""T15: the ends of a ratio over all assignments of rows of unknown group, against going through all of them; what tips a limit."""

from __future__ import annotations

import os
import random
from collections.abc import Callable
from fractions import Fraction
from math import inf

import pytest
import tiers
from unknown_rows import Enumerated, enumerated, quotient, random_block

from fairaudit.theorems.t15 import Block, Pair, greatest, greatest_of, least_apart, levels, rows_until_above, rows_until_below
from fairaudit.theorems.t15_assignments import least_of_all, levelled, ratio_of

TABLES = int(os.environ.get("FAIRAUDIT_UNKNOWN", "150"))
"""How many random blocks; 500 in the measurement that docs/unknown-groups.md names, and more whenever somebody doubts."""

F = Fraction


def free(counts: tuple[int, ...], sums: tuple[int, ...], values: tuple[int, ...], numbers: tuple[int, ...]) -> Block:
    """A block without limits."""
    total = sum(numbers)
    return Block(counts, sums, values, numbers, (0,) * len(counts), (total,) * len(counts), (0, total))


def found(pair: Pair | None) -> Pair:
    assert pair is not None
    return pair


@pytest.fixture(scope="module")
def blocks() -> list[tuple[Block, Enumerated]]:
    pick = random.Random(tiers.fresh(15))
    return [(block, enumerated(block)) for block in (random_block(pick) for _ in range(TABLES))]


def test_the_greatest_ratio_is_that_of_all_assignments(blocks: list[tuple[Block, Enumerated]]) -> None:
    for block, true in blocks:
        assert found(greatest(block)).ratio == true.greatest, block
    assert {inf, F(1)} & {true.greatest for _, true in blocks}


def test_each_ordered_pair_attains_its_greatest_ratio(blocks: list[tuple[Block, Enumerated]]) -> None:
    for block, true in blocks:
        for (higher, lower), ratio in true.pairs.items():
            pair = greatest_of(block, higher, lower)
            assert pair.ratio == ratio, block
            i, j = pair.received
            assert (i, j) in {(rows[higher], rows[lower]) for rows in true.received}, block
            one = F(block.sums[higher] + block.top(i), block.counts[higher] + i)
            assert quotient(one, F(block.sums[lower] + block.bottom(j), block.counts[lower] + j)) == ratio


def test_a_group_receives_what_some_assignment_gives_it(blocks: list[tuple[Block, Enumerated]]) -> None:
    for block, true in blocks:
        for a, limits in enumerate(block.ranges):
            own = {rows[a] for rows in true.received}
            assert limits == (min(own), max(own)), block
            means = [means[a] for means in true.means]
            best, worst = block.best(a), block.worst(a)
            assert best in own and F(*block.mean(a, best, block.top)) == max(means), block
            assert worst in own and F(*block.mean(a, worst, block.bottom)) == min(means), block


def test_the_least_ratio_is_that_of_all_assignments_and_the_pairs_bound_it(blocks: list[tuple[Block, Enumerated]]) -> None:
    for block, true in blocks:
        pair = least_apart(block)
        bounds = [quotient(F(1), F(ratio)) for ratio in true.pairs.values() if ratio < 1]
        assert (F(1) if pair is None else pair.ratio) == max([F(1), *bounds]), block
        if pair is not None and len(block.counts) == 2:
            assert pair.ratio == true.least  # sharp for two groups
        if pair is not None:
            assert pair.received in {(rows[pair.higher], rows[pair.lower]) for rows in true.received}, block
        exact = least_of_all(block, 10**6)
        assert exact is not None and exact[0] == true.least and ratio_of(block, exact[1]) == true.least, block


def test_no_assignment_is_more_level_than_all_groups_together_allow(blocks: list[tuple[Block, Enumerated]]) -> None:
    better = 0
    for block, true in blocks:
        low, high = levels(block)
        assert quotient(high, low) <= true.least, block
        pair = least_apart(block)
        better += len(block.counts) > 2 and quotient(high, low) > (F(1) if pair is None else pair.ratio)
    assert better


def test_levels_are_where_groups_lack_as_much_as_they_can_receive(blocks: list[tuple[Block, Enumerated]]) -> None:
    step = F(1, 10**9)
    for block, _ in blocks:
        groups, rows = list(zip(block.sums, block.counts, strict=True)), list(zip(block.values, block.numbers, strict=True))
        low, high = levels(block)
        lacking = [sum(max(F(0), at * n - s) for s, n in groups) - sum(max(F(0), v - at) * m for v, m in rows) for at in (low, low + step)]
        beyond = [sum(max(F(0), s - at * n) for s, n in groups) - sum(max(F(0), at - v) * m for v, m in rows) for at in (high, high - step)]
        assert lacking[0] <= 0 < lacking[1] and beyond[0] <= 0 < beyond[1], block


def test_without_limits_every_assignment_of_so_many_rows_is_possible() -> None:
    pick = random.Random(17)
    for _ in range(TABLES // 15):
        block = random_block(pick, most=6)
        every = enumerated(free(block.counts, block.sums, block.values, block.numbers)).received
        for rows in range(block.unknown + 1):
            assert enumerated(block.freely(rows)).received == {given for given in every if sum(given) <= rows}, block


def test_levelling_finds_assignments_that_keep_the_limits(blocks: list[tuple[Block, Enumerated]]) -> None:
    best = 0
    for block, true in blocks:
        level = levelled(block)
        if level is not None:
            assert ratio_of(block, level[1]) == level[0] >= true.least
            best += level[0] == true.least
    assert 4 * best > 3 * len(blocks)


@pytest.mark.parametrize("limit", [F(1), F(5, 4), F(2)])
def test_what_tips_a_limit(limit: Fraction) -> None:
    pick = random.Random(tiers.fresh(16))
    for _ in range(TABLES // 5):
        block = random_block(pick, most=6)
        by_rows = [enumerated(block.freely(rows)) for rows in range(block.unknown + 1)]

        def first(holds: Callable[[Enumerated], bool], cases: list[Enumerated] = by_rows) -> int | None:
            return next((rows for rows, true in enumerate(cases) if holds(true)), None)

        if by_rows[0].greatest <= limit:
            needed = first(lambda true: true.greatest > limit)
            assert rows_until_above(block, limit) == needed
            assert needed is None or rows_until_above(block, limit, needed) is None
        else:
            true, mine = first(lambda true: true.least <= limit), rows_until_below(block, limit)
            assert mine is not None or true is None
            assert true is None or (mine is not None and mine[0] <= true)
            if mine is not None and len(block.counts) == 2:
                reverse = mine[1].lower, mine[1].higher
                assert first(lambda true, pair=reverse: true.pairs[pair] * limit >= 1) == mine[0]  # type: ignore[misc]


def test_examples_of_the_page() -> None:
    two = free((4, 4), (3, 2), (1, 0), (1, 1))
    assert found(greatest(two)).ratio == 2
    least = least_of_all(two, 100)
    assert least is not None and least[0] == 1
    three = free((2, 2, 2), (2, 1, 1), (1,), (1,))
    least = least_of_all(three, 100)
    assert found(least_apart(three)).ratio == F(3, 2) and least is not None and least[0] == 2


def test_ratios_on_both_sides_of_1_need_not_attain_it() -> None:
    forced = Block((1, 1), (1, 1), (0,), (1,), (0, 0), (1, 1), (0, 0))
    least = least_of_all(forced, 100)
    assert found(greatest(forced)).ratio == 2 and least_apart(forced) is None and least is not None and least[0] == 2


def test_inside_one_value_an_interior_split_can_be_best() -> None:
    """All rows are alike and go to the pair: neither end of the range is best."""
    block = Block((1, 1), (0, 3), (1,), (4,), (0, 0), (4, 4), (0, 0))
    by_hand = {i: F(i, 1 + i) / F(3 + 4 - i, 1 + 4 - i) for i in range(5)}
    pair = greatest_of(block, 0, 1)
    assert pair.ratio == max(by_hand.values()) == by_hand[pair.received[0]]
    wide = Block((10, 10), (0, 30), (1,), (1000,), (0, 0), (1000, 1000), (0, 0))
    split = greatest_of(wide, 0, 1)
    assert split.ratio == max(F(i, 10 + i) / F(30 + 1000 - i, 10 + 1000 - i) for i in range(1001)) and 0 < split.received[0] < 1000


def test_nobody_gets_anything() -> None:
    nothing = free((3, 3), (0, 0), (0,), (2,))
    assert found(greatest(nothing)).ratio == 1
    assert found(greatest(free((3, 3), (0, 0), (1,), (1,)))).ratio == inf


def test_a_million_rows_are_no_more_work_than_one() -> None:
    block = free((10**9, 10**9), (5 * 10**8, 4 * 10**8), (1, 0), (10**9, 10**9))
    assert found(greatest(block)).ratio == F(15 * 10**8, 4 * 10**8)
    level = levelled(block)
    assert level is not None and level[0] < F(1000001, 1000000)


def test_an_assignment_that_breaks_a_limit_has_no_ratio() -> None:
    assert ratio_of(Block((1, 1), (1, 1), (1,), (2,), (0, 0), (1, 2), (0, 2)), ((2, 0),)) is None
    assert ratio_of(Block((1, 1), (1, 1), (1,), (2,), (0, 0), (2, 2), (0, 0)), ((1, 0),)) is None
    assert ratio_of(Block((1, 1), (1, 1), (1,), (2,), (0, 0), (2, 2), (0, 2)), ((2, 1),)) is None
