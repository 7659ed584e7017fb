"""Wealth, levels and intervals of streams against their definitions in fractions."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from math import inf, log
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.inference.anytime import Arrivals, stream_interval, value_counts
from fairaudit.inference.betting import ValueCounts, log_wealth, wealth, wealth_reaches
from fairaudit.inference.levels import pair_levels, weight
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

F = Fraction
UNIT = (F(0), F(1))
SHARES = {i: F(29, 20) / ((abs(i + 2) + 2) * (abs(i + 2) + 3)) for i in range(-16, 5)}


def by_definition(counts: dict[Fraction, int], p: Fraction) -> Fraction:
    total = F(1, 32)
    for i, share in SHARES.items():
        bet = min(F(2) ** i, F(15, 16) / p)
        part = share
        for x, n in counts.items():
            part *= (1 + bet * (x - p)) ** n
        total += part
    return total


def mirrored(counts: dict[Fraction, int]) -> dict[Fraction, int]:
    return {1 - x: n for x, n in counts.items()}


values = st.sampled_from([F(0), F(1, 3), F(1, 2), F(3, 4), F(1)])
tallied = st.dictionaries(values, st.integers(0, 12), min_size=1).filter(lambda c: sum(c.values()) > 0)
inner = st.fractions(F(1, 100), F(99, 100), max_denominator=100)


def test_the_money_is_not_more_than_one() -> None:
    assert F(1, 32) + sum(SHARES.values()) <= 1


@settings(max_examples=30, deadline=None)
@given(tallied, inner)
def test_wealth_in_integers_is_the_mixture_barely_rounded_down(counts: dict[Fraction, int], p: Fraction) -> None:
    for side, expected in (("above", by_definition(counts, p)), ("below", by_definition(mirrored(counts), 1 - p))):
        m, e = wealth(ValueCounts(counts), p, side)  # type: ignore[arg-type]
        found = F(m) * F(2) ** e
        assert expected * (1 - F(1, 2**100)) <= found <= expected
        assert abs(float(ValueCounts(counts).log_wealth(np.array(float(p)), side)) - log(expected)) < 1e-9  # type: ignore[arg-type]


@settings(max_examples=30, deadline=None)
@given(tallied, inner, inner)
def test_wealth_falls_in_the_mean(counts: dict[Fraction, int], p: Fraction, q: Fraction) -> None:
    low, high = min(p, q), max(p, q)
    assert by_definition(counts, low) >= by_definition(counts, high)


@given(inner, st.lists(values, min_size=2, max_size=3, unique=True), st.integers(1, 4), st.data())
def test_a_further_decision_leaves_the_expected_wealth_as_it_is(p: Fraction, xs: list[Fraction], n: int, data: Any) -> None:
    """The property behind Ville's inequality, for a law with the mean p on two of the values."""
    lower, upper = min(xs), max(xs)
    if not lower <= p <= upper:
        return
    before = {lower: data.draw(st.integers(0, 5)), upper: n}
    chance = (p - lower) / (upper - lower)
    after = sum(c * by_definition({**before, x: before[x] + 1}, p) for x, c in ((lower, 1 - chance), (upper, chance)))
    assert after == by_definition(before, p)


def test_many_decisions_are_counted_quickly_and_safely() -> None:
    m, e = wealth(ValueCounts({F(0): 10**18, F(1): 10**18}), F(1, 2), "above")
    assert m * F(2) ** e <= 1


@given(st.fractions(F(1, 1000), F(999, 1000)), tallied, inner)
def test_reaching_a_level_is_decided_exactly(level: Fraction, counts: dict[Fraction, int], p: Fraction) -> None:
    number = wealth(ValueCounts(counts), p, "above")
    exact = F(number[0]) * F(2) ** number[1]
    assert wealth_reaches([number], level) == (exact * level >= 1)
    assert wealth_reaches([number, number], level) == (exact * exact * level >= 1)


@given(st.lists(st.integers(1, 4), min_size=1, max_size=5), st.integers(1, 20), st.randoms(use_true_random=False))
def test_levels_of_pairs_never_sum_to_more_than_the_error(sizes: list[int], expected: int, random: Any) -> None:
    ranks = list(range(1, sum(sizes) + 1))
    random.shuffle(ranks)
    blocks = [[ranks.pop() for _ in range(size)] for size in sizes]
    levels = pair_levels(blocks, expected, F(1, 20))
    assert sum(2 * level for block in levels for level in block.values()) < F(1, 20)
    assert [len(block) for block in levels] == [size * (size - 1) // 2 for size in sizes]
    assert sum(weight(rank, expected) for rank in range(1, 500)) < 1


def law_of(counts: list[list[int]]) -> Law:
    groups = [f"g{i}" for i in range(len(counts))]
    return Law.from_array(counts, kind="counts", decisions=["no", "half", "yes"][: len(counts[0])], groups=groups)


def found(counts: list[list[int]], joint: bool, exact: bool = True) -> Any:
    law = law_of(counts)
    utility = Utility({"half": "1/2", "yes": 1} if len(counts[0]) == 3 else {"half": 1}).on(law)
    arrivals = Arrivals(tuple(((), group) for group in law.groups), 4, joint)
    return stream_interval(law, utility, arrivals, "local", UNIT, "0.9", exact=exact)


rows = st.lists(st.integers(0, 60), min_size=3, max_size=3).filter(any)


@settings(max_examples=5, deadline=None)
@given(st.lists(rows, min_size=2, max_size=3))
def test_products_exclude_every_pair_of_means_outside_the_interval(counts: list[list[int]]) -> None:
    """The ends against their meaning: every pair of means with a quotient outside has a product of wealths of 1/level."""
    interval = found(counts, joint=True)
    cells = [{F(0): row[0], F(1, 2): row[1], F(1): row[2]} for row in counts]
    [levels] = pair_levels([list(range(1, len(cells) + 1))], 4, F(1, 10))
    grid = [F(k, 16) for k in range(1, 16)]
    above = [[by_definition(cell, p) for p in grid] for cell in cells]
    below = [[by_definition(mirrored(cell), 1 - p) for p in grid] for cell in cells]
    for (i, j), (k, p), (m, q) in ((a, b, c) for a in permutations(range(len(cells)), 2) for b in enumerate(grid) for c in enumerate(grid)):
        level = levels[frozenset((i, j))]
        if interval.upper < inf and p > interval.upper * q:
            assert below[i][k] * above[j][m] * level >= 1
    if interval.lower > 1:
        assert any(
            all(
                below[i][k] * above[j][m] * levels[frozenset((i, j))] >= 1
                for k, p in enumerate(grid)
                for m, q in enumerate(grid)
                if q < interval.lower * p
            )
            for i, j in permutations(range(len(cells)), 2)
        )


@settings(max_examples=20, deadline=None)
@given(st.lists(rows, min_size=2, max_size=3))
def test_the_ends_of_a_box_are_excluded(counts: list[list[int]]) -> None:
    interval = found(counts, joint=False)
    for rank, (row, (low, high)) in enumerate(zip(counts, interval.evidence["upper"], strict=True), 1):
        cell = {F(0): row[0], F(1, 2): row[1], F(1): row[2]}
        level = F(1, 10) * weight(rank, 4) / 2
        assert F(low) == 0 or by_definition(cell, F(low)) * level >= 1
        assert F(high) == 1 or by_definition(mirrored(cell), 1 - F(high)) * level >= 1
        assert F(low) == 0 or by_definition(cell, F(low) * F(1_001, 1_000)) * level < F(11, 10)  # and hardly more could be


@pytest.mark.parametrize("joint", [True, False])
@pytest.mark.parametrize(
    "counts", [[[100, 0], [0, 100]], [[3, 0], [2, 0]], [[900, 100], [850, 150], [10, 0]], [[10**7, 10**6], [10**7, 10**6]]]
)
def test_estimates_for_a_display_are_the_proved_ends(counts: list[list[int]], joint: bool) -> None:
    proved, shown = found(counts, joint), found(counts, joint, exact=False)
    assert float(proved.lower) == pytest.approx(float(shown.lower), rel=1e-3)
    assert float(proved.upper) == pytest.approx(float(shown.upper), rel=1e-3)


def test_many_groups_with_different_means_are_bounded_in_one_ladder() -> None:
    counts = [[900 - 60 * k, 100 + 60 * k] for k in range(10)]
    proved, shown = found(counts, True), found(counts, True, exact=False)
    assert proved.upper < 20
    assert float(proved.upper) == pytest.approx(float(shown.upper), rel=1e-3)
    assert float(proved.lower) == pytest.approx(float(shown.lower), rel=1e-3)


def test_products_are_narrower_and_say_what_they_assume() -> None:
    product, box = found([[300, 700], [500, 500]], True), found([[300, 700], [500, 500]], False)
    assert box.lower < product.lower < F(7, 5) < product.upper < box.upper
    assert any("everything recorded before" in text for text in product.assumptions)
    assert not any("everything recorded before" in text for text in box.assumptions)


def test_values_are_scaled_to_the_range() -> None:
    law = law_of([[2, 1, 1], [4, 0, 0]])
    utility = Utility({"half": 2, "yes": 3}).on(law)
    [block] = value_counts(law, utility, (F(0), F(4)), "local")
    assert [tally.counts for _, tally in block] == [{F(0): 2, F(1, 2): 1, F(3, 4): 1}, {F(0): 4}]
    with pytest.raises(InputError, match="outside the declared limits"):
        value_counts(law, utility, (F(0), F(2)), "local")


def test_nothing_compared_is_refused() -> None:
    log = {"a": ["f", "m"], "x": ["1", "2"], "u": ["yes", "no"]}
    law = Law.from_log(log, decision="u", group="a", context="x")
    arrivals = Arrivals(((("1",), ("f",)), (("2",), ("m",))))
    with pytest.raises(InputError, match="no two groups"):
        stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "local", UNIT)
    assert stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "global", UNIT).upper == inf


def test_wealth_of_a_known_game() -> None:
    """One decision, a success: the wealth is 1/32 + Σ share·(1 + λ(1 − p)) over the bets."""
    expected = F(1, 32) + sum(s * (1 + min(F(2) ** i, F(15, 8)) * F(1, 2)) for i, s in SHARES.items())
    assert float(log_wealth(np.array([1.0]), np.array([1.0]), np.array(0.5))) == pytest.approx(log(expected), abs=1e-12)
