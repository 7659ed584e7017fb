"""Splits of an error budget: each keeps its inequality exactly."""

from __future__ import annotations

from fractions import Fraction
from math import comb
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from interval_oracle import (
    F,
    binary,
    one_block,
)
from mpmath import mp

from fairaudit.errors import InputError
from fairaudit.inference.cells import Cell
from fairaudit.inference.levels import (
    SIDAK_CELLS,
    arrival_levels,
    box_levels,
    confidence_level,
    constancy_error,
    equal_share,
    pair_levels,
    product_area,
    product_levels,
    weight,
    window_share,
)
from fairaudit.inference.ratio_intervals import ratio_interval

holdings = st.sampled_from(["together", "each", "lower", "upper"])
errors = st.fractions(F(1, 10**6), F(99, 100), max_denominator=10**6)


@given(st.integers(1, 60), st.data(), errors, holdings, st.booleans())
def test_levels_of_a_box_keep_their_inequality(cells: int, data: st.DataObject, alpha: Fraction, ends: Any, independent: bool) -> None:
    """By the union bound all of the error is spent; of independent cells all ends that matter hold often enough."""
    span = data.draw(st.integers(1, cells))
    upper, lower = box_levels(cells, span, alpha, independent=independent, ends=ends)
    plain = box_levels(cells, span, alpha, independent=False, ends=ends)
    assert (upper == 0) is (ends == "lower") and (lower == 0) is (ends == "upper")
    assert 1 / F(2) >= upper >= plain[0] and 1 / F(2) >= lower >= plain[1]
    if ends == "together":
        assert lower <= upper and span * plain[0] + (2 * cells - span) * plain[1] == alpha
        assert not independent or (1 - upper - lower) ** span * (1 - 2 * lower) ** (cells - span) >= 1 - alpha
    if ends in ("upper", "each"):
        assert span * plain[0] == min(alpha, F(span, 2)) and (not independent or (1 - upper) ** span >= 1 - alpha)
    if ends in ("lower", "each"):
        assert 2 * cells * plain[1] == alpha and (not independent or (1 - 2 * lower) ** cells >= 1 - alpha)
    assert independent or (upper, lower) == plain


@given(st.integers(1, 60), st.data(), errors, st.booleans())
def test_levels_of_each_end_are_no_less_than_those_of_both(cells: int, data: st.DataObject, alpha: Fraction, independent: bool) -> None:
    """So that the ends, which are nested in their levels, are no further apart."""
    span = data.draw(st.integers(1, cells))
    both, each, half = (
        box_levels(cells, span, error, independent=independent, ends=ends)
        for error, ends in ((alpha, "together"), (alpha, "each"), (alpha / 2, "each"))
    )
    assert each[0] >= both[0] and each[1] >= both[1]
    assert each[0] >= half[0] and each[1] >= half[1]
    assert independent or both[0] == half[0]


def test_no_cells_spend_nothing_and_very_many_the_union_bound() -> None:
    assert box_levels(0, 0, F(1, 20), independent=True) == (0, 0)
    many = SIDAK_CELLS + 1
    assert box_levels(many, 2, F(1, 20), independent=True) == box_levels(many, 2, F(1, 20), independent=False)


def test_a_lower_end_alone_counts_both_ends_of_each_cell() -> None:
    """Five draws against a mean that is known: whatever they are, the lower end is right as often as it says."""
    known = Cell(1, F(1, 2), None, F(1, 2), F(1, 2), False)
    right = F(0)
    for k in range(6):
        found = ratio_interval(one_block(binary(5, k), known), "0.8", ends="lower", independent=True)
        right += F(comb(5, k), 32) * (found.lower <= 1)
    assert right >= F(4, 5)


@given(st.integers(1, 60), st.integers(2, 500), errors, holdings)
def test_levels_of_products_keep_their_inequality(cells: int, pairs: int, alpha: Fraction, ends: Any) -> None:
    found = product_levels(cells, pairs, alpha, ends)
    assert (found.upper is None) is (ends == "lower") and (found.lower is None) is (ends == "upper")
    for each in (found.upper, found.lower):
        assert each is None or 0 < each[0] ** 2 <= each[1] <= each[0] < 1
    if ends == "together":
        assert found.upper is not None and found.lower is not None
        assert found.lower[0] <= found.upper[0] and found.lower[1] <= found.upper[1]
        guards = 2 * found.upper[0] + max(2, 2 * cells - 2) * found.lower[0]
        assert guards + product_area(*found.upper) + (pairs - 1) * product_area(*found.lower) <= alpha
    elif found.upper:
        assert 2 * found.upper[0] + product_area(*found.upper) <= alpha
    if found.lower and ends != "together":
        assert 2 * cells * found.lower[0] + pairs * product_area(*found.lower) <= alpha


@given(st.fractions(F(1, 1000), F(9, 10)), st.fractions(0, 1))
def test_the_area_of_products_is_not_less_than_it_is(guard: Fraction, share: Fraction) -> None:
    """c·log(c/b²) − c + b², from b² at c = b² up to c = b, rounded up by no more than 2^-100."""
    c = guard**2 + share * (guard - guard**2)
    mp.dps = 60
    true = mp.mpf(c.numerator) / c.denominator * mp.log(mp.mpf((c / guard**2).numerator) / (c / guard**2).denominator)
    true += mp.mpf((guard**2 - c).numerator) / (guard**2 - c).denominator
    area = product_area(guard, c)
    assert true - mp.mpf(10) ** -50 <= mp.mpf(area.numerator) / area.denominator <= true + mp.mpf(2) ** -100


@given(errors, st.integers(0, 1000))
def test_equal_shares_sum_to_the_error(alpha: Fraction, statements: int) -> None:
    assert max(1, statements) * equal_share(alpha, statements) == alpha


@given(st.lists(st.integers(1, 4), min_size=1, max_size=5), st.integers(1, 20), st.randoms(use_true_random=False))
def test_levels_of_pairs_never_sum_to_more_than_the_error(sizes: list[int], expected: int, random: Any) -> None:
    ranks = list(range(1, sum(sizes) + 1))
    random.shuffle(ranks)
    blocks = [[ranks.pop() for _ in range(size)] for size in sizes]
    levels = pair_levels(blocks, expected, F(1, 20))
    assert sum(2 * level for block in levels for level in block.values()) < F(1, 20)
    assert [len(block) for block in levels] == [size * (size - 1) // 2 for size in sizes]


@given(st.lists(st.integers(1, 4), min_size=1, max_size=5), st.integers(1, 20), errors, st.randoms(use_true_random=False))
def test_levels_of_arrivals_never_sum_to_more_than_the_error(sizes: list[int], expected: int, alpha: Fraction, random: Any) -> None:
    """Both ends of all cells; the first n of them have n/(n + K) of it, in whatever blocks they are."""
    ranks = list(range(1, sum(sizes) + 1))
    random.shuffle(ranks)
    blocks = [[ranks.pop() for _ in range(size)] for size in sizes]
    levels = arrival_levels(blocks, expected, alpha)
    assert list(map(len, levels)) == sizes
    assert sum(2 * level for block in levels for level in block) == alpha * F(sum(sizes), sum(sizes) + expected)


@given(st.integers(1, 200), st.integers(1, 50))
def test_weights_of_arrivals_sum_to_less_than_1(number: int, expected: int) -> None:
    assert sum(weight(rank, expected) for rank in range(1, number + 1)) == F(number, number + expected)


@given(st.integers(1, 100), errors, errors)
def test_windows_share_one_error(number: int, stream: Fraction, alpha: Fraction) -> None:
    """All windows together have less than the error that they share, and what they had so far follows from the last one."""
    shares = [alpha * window_share(i) for i in range(1, number + 1)]
    assert sum(shares) < alpha
    assert constancy_error(stream, shares[-1], number) == stream + sum(shares)


@pytest.mark.parametrize("value", [0, 1, "1.5", -1, "nan", float("nan"), True, None, "95%"])
def test_confidence_is_a_probability(value: Any) -> None:
    with pytest.raises(InputError):
        ratio_interval(one_block(binary(5, 2), binary(5, 2)), value)


def test_a_float_confidence_is_what_it_says() -> None:
    assert confidence_level(0.95) == F(19, 20) == confidence_level("19/20")
