"""Tails of sums of draws against exact sums."""

from __future__ import annotations

from fractions import Fraction
from math import comb, exp

import pytest
from hypothesis import given
from hypothesis import strategies as st
from interval_oracle import (
    F,
    binary,
)
from scipy import stats

from fairaudit.inference.cells import Cell
from fairaudit.inference.tails import tail_bound


@given(st.integers(1, 60), st.data())
def test_binomial_tail_is_the_exact_sum_rounded_up(n: int, data: st.DataObject) -> None:
    k = data.draw(st.integers(0, n))
    p = data.draw(st.fractions(0, 1, max_denominator=10**6))
    exact = sum((comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k + 1)), F(0))
    found = F(tail_bound(binary(n, k), p, "lower"), 2**128)
    assert exact <= found <= exact + F(1, 2**110)
    if p:
        assert tail_bound(binary(n, n - k), 1 - p, "upper") == tail_bound(binary(n, k), p, "lower")


@pytest.mark.parametrize(
    ("n", "k", "p"), [(5001, 2000, "0.41"), (10**6, 10, "3e-5"), (10**6, 1, "1e-5"), (10**5, 99_000, "0.9905"), (6000, 0, "0.001")]
)
def test_tail_of_many_draws_is_above_the_true_one_and_close(n: int, k: int, p: str) -> None:
    found = tail_bound(binary(n, k), F(p), "lower") / 2**128
    true = stats.binom.cdf(k, n, float(F(p)))
    assert true * (1 - 1e-9) <= found <= 1.35 * true
    assert found <= exp(-n * stats.entropy([k / n, 1 - k / n], [float(F(p)), 1 - float(F(p))])) * (1 + 1e-9)


def test_tails_bound_the_outcomes_of_bounded_draws() -> None:
    """P(exp(−n·kl) ≤ u) ≤ u at the true mean, by enumeration of all outcomes of three-valued draws."""
    values = [F(0), F(1, 3), F(1)]
    for chances in ([F(1, 2), F(1, 4), F(1, 4)], [F(1, 10), F(4, 5), F(1, 10)], [F(9, 10), F(0), F(1, 10)]):
        mean = sum((p * v for p, v in zip(chances, values, strict=True)), F(0))
        for n in (1, 3, 6):
            outcomes: dict[int, Fraction] = {}
            for a in range(n + 1):
                for b in range(n + 1 - a):
                    chance = F(comb(n, a) * comb(n - a, b)) * chances[0] ** a * chances[1] ** b * chances[2] ** (n - a - b)
                    cell = Cell(n, b * values[1] + (n - a - b), None, F(0), F(1), False)
                    tail = tail_bound(cell, mean, "lower")
                    outcomes[tail] = outcomes.get(tail, F(0)) + chance
            below = F(0)
            for tail in sorted(outcomes):
                below += outcomes[tail]
                assert below * 2**128 <= tail
