"""Contrasts averaged over all pairings against that average, pairing by pairing, and against every outcome of small laws."""

from __future__ import annotations

from fractions import Fraction
from math import inf, log
from typing import Any

import numpy as np
import pytest
from contrast_oracle import bets as expected_bets
from contrast_oracle import is_just_below, outcomes, symmetric, tally, value
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.symmetric_betting import is_below, log_wealth, pairing, upper_end, wealth

F = Fraction
HALF = F(1, 2)
CLAIMS = ["ratio", "difference"]
Generator = np.random.Generator

few = st.lists(st.sampled_from([F(0), F(1, 3), HALF, F(1)]), min_size=1, max_size=4)
limits = st.fractions(F(1, 40), F(3), max_denominator=40)

# Laws of x and of y, with the limits of which their means are on the boundary.
LAWS: list[tuple[dict[Any, Fraction], dict[Any, Fraction], Fraction, Fraction]] = [
    ({F(0): HALF, F(1): HALF}, {HALF: F(1)}, F(1), F(0)),
    ({F(0): F(1, 4), HALF: F(1, 4), F(1): HALF}, {F(0): F(3, 4), F(1): F(1, 4)}, F(5, 2), F(3, 8)),
    ({F(0): F(9, 10), F(1): F(1, 10)}, {HALF: HALF, F(1): HALF}, F(2, 15), F(-13, 20)),
]


def cell(values: Any) -> ValueCounts:
    return ValueCounts(tally(values))  # type: ignore[arg-type]


@settings(max_examples=60)
@given(few, few, limits, st.sampled_from(CLAIMS))
def test_wealth_is_the_average_over_all_pairings(xs: list[Fraction], ys: list[Fraction], limit: Fraction, claim: Any) -> None:
    exact = symmetric(xs, ys, limit, claim)
    assert is_just_below(wealth(cell(xs), cell(ys), limit, claim), exact)
    assert log_wealth(cell(xs), cell(ys), claim)(float(limit)) == pytest.approx(log(exact), abs=1e-9)


@pytest.mark.parametrize("claim", CLAIMS)
@pytest.mark.parametrize("law", range(len(LAWS)))
@pytest.mark.parametrize("sizes", [(1, 1), (1, 3), (3, 2), (3, 3)])
def test_the_expected_wealth_on_the_boundary_is_one(claim: Any, law: int, sizes: tuple[int, int]) -> None:
    """Exactly 1 by definition, at most 1 as it is computed; and a level is reached with at most its probability."""
    of_x, of_y, ratio, difference = LAWS[law]
    limit = ratio if claim == "ratio" else difference
    by_definition, computed = F(0), F(0)
    wrong = dict.fromkeys((F(9, 10), HALF, F(1, 3), F(1, 20)), F(0))
    for xs, chance in outcomes(of_x, sizes[0]):
        for ys, other in outcomes(of_y, sizes[1]):
            number = wealth(cell(xs), cell(ys), limit, claim)
            by_definition += chance * other * symmetric(xs, ys, limit, claim)  # type: ignore[arg-type]
            computed += chance * other * value(number)
            for level in wrong:
                wrong[level] += chance * other * is_below(cell(xs), cell(ys), limit, level, claim)
    assert by_definition == 1
    assert 1 - F(1, 2**100) <= computed <= 1
    assert all(error <= level for level, error in wrong.items())


SHAPES: list[Any] = [
    lambda source, n: source.random(n) < 0.05,
    lambda source, n: source.choice([0.001, 1], n, p=[0.95, 0.05]),
    lambda source, n: source.beta(0.5, 3, n),
    lambda source, n: source.choice([0, 0.5, 1], n, p=[0.1, 0.8, 0.1]),
    lambda source, n: 10.0 ** -source.integers(0, 9, n),
    lambda source, n: source.beta(20, 2, n),
]


def drawn(source: Generator, shape: int, n: int) -> ValueCounts:
    return cell([F(round(float(v) * 10**9), 10**9) for v in SHAPES[shape](source, n)])


@settings(max_examples=40)
@given(
    st.integers(0, 10**6),
    st.tuples(*[st.integers(0, len(SHAPES) - 1)] * 2),
    st.tuples(*[st.sampled_from([1, 7, 60, 300])] * 2),
    st.sampled_from([0.5, 0.9, 1, 1.1, 2, 30]),
    st.sampled_from(CLAIMS),
)
def test_integers_and_floats_agree_by_different_sums(seed: int, shapes: Any, sizes: Any, limit: float, claim: Any) -> None:
    """The recurrence by draws, and convolutions by values: whatever the tilt, all that counts is left."""
    source = np.random.default_rng(seed)
    x, y = (drawn(source, shape, n) for shape, n in zip(shapes, sizes, strict=True))
    limit = limit if claim == "ratio" else min(limit, 1) - 0.75
    mantissa, exponent = wealth(x, y, F(limit), claim)
    assert log(mantissa) + exponent * log(2) == pytest.approx(log_wealth(x, y, claim)(limit), abs=1e-8)


@pytest.mark.parametrize("n", [3, 1_000, 10**6, 10**18])
def test_draws_that_are_all_the_same_are_a_power(n: int) -> None:
    x, y, limit = F(2, 3), HALF, F(7, 5)
    pairs, bets = pairing(ValueCounts({x: n}), ValueCounts({y: 2 * n}))
    assert pairs == min(n, 1_000)
    assert bets == expected_bets(pairs**2 * F(3, 2 * n))
    for claim, gain in (("ratio", limit * y - x), ("difference", (limit - x + y) / 2)):
        exact = sum(((1 + bet * gain) ** pairs for bet in bets), F(0)) / len(bets)
        found = wealth(ValueCounts({x: n}), ValueCounts({y: 2 * n}), limit, claim)  # type: ignore[arg-type]
        assert is_just_below(found, exact, 118 - n.bit_length())  # a power has as many roundings


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.tuples(*[st.integers(0, len(SHAPES) - 1)] * 2), st.tuples(*[st.sampled_from([1, 7, 60])] * 2))
def test_an_upper_end_is_the_least_limit_that_is_proved(seed: int, shapes: Any, sizes: Any) -> None:
    source, level = np.random.default_rng(seed), F(1, 20)
    x, y = (drawn(source, shape, n) for shape, n in zip(shapes, sizes, strict=True))
    for claim, nothing in (("ratio", inf), ("difference", F(1))):
        end: Any = upper_end(x, y, level, claim)  # type: ignore[arg-type]
        if end == nothing:
            assert log_wealth(x, y, claim)(10.0**8 if claim == "ratio" else 1 - 1e-6) < log(20)  # type: ignore[arg-type]
            continue
        less = end * (1 - F(2, 10**6)) if claim == "ratio" else end - F(2, 10**7)
        assert is_below(x, y, end, level, claim) and not is_below(x, y, less, level, claim)  # type: ignore[arg-type]
        assert end <= upper_end(x, y, level / 2, claim)  # type: ignore[arg-type]


def test_order_changes_no_digit() -> None:
    source = np.random.default_rng(3)
    xs, ys = ([F(int(v), 7) for v in source.integers(0, 8, 70)] for _ in range(2))
    found = set()
    for _ in range(4):
        for values in (xs, ys):
            source.shuffle(values)
        found.add(tuple(upper_end(cell(xs), cell(ys), F(1, 20), claim) for claim in CLAIMS))  # type: ignore[arg-type]
    assert len(found) == 1


def test_many_draws_are_searched_by_their_values() -> None:
    one = {F(0): 3, HALF: 4, F(1): 3}
    x = ValueCounts({v: 600 * n for v, n in one.items()})
    end = upper_end(x, x, F(1, 20))
    assert is_below(x, x, F(end), F(1, 20))
    assert log_wealth(x, x)(float(end)) == pytest.approx(log(20), abs=1e-3)
    most = ValueCounts({v: 10**17 * n for v, n in one.items()})
    assert 1 < upper_end(most, most, F(1, 20)) < F(102, 100)


def test_what_says_nothing_proves_nothing() -> None:
    level, none, zero, one = F(1, 20), ValueCounts({}), ValueCounts({F(0): 30}), ValueCounts({F(1): 30})
    for x, y in ((none, one), (one, none), (none, none), (one, zero), (zero, zero)):
        assert upper_end(x, y, level) == inf
        assert upper_end(x, y, level, "difference") == 1 or (x, y) == (zero, zero)
    # One draw each: 1 + 15/16·(r − 1) is 20.
    assert upper_end(ValueCounts({F(1): 1}), ValueCounts({F(1): 1, F(0): 0}), level) == F(21266667, 10**6)
    assert not is_below(one, one, F(-1), F(9, 10)) and not is_below(one, one, F(-2), F(9, 10), "difference")
