"""Wealth of a gambler against its definition in fractions."""

from __future__ import annotations

from fractions import Fraction
from math import log
from typing import Any

import numpy as np
import pytest
from betting_oracle import SHARES, by_definition, mirrored
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.inference.betting import ValueCounts, log_wealth, wealth, wealth_reaches

F = Fraction


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


def test_wealth_of_a_known_game() -> None:
    """One decision, a success: the wealth is 1/32 + Σ share·(1 + λ(1 − p)) over the bets."""
    expected = F(1, 32) + sum(s * (1 + min(F(2) ** i, F(15, 8)) * F(1, 2)) for i, s in SHARES.items())
    assert float(log_wealth(np.array([1.0]), np.array([1.0]), np.array(0.5))) == pytest.approx(log(expected), abs=1e-12)
