"""Joint bets of streams: what they exclude against their definition, that they nest, and what is refused."""

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
from fairaudit.inference.anytime import Arrivals, stream_interval
from fairaudit.inference.anytime_joint import joint_bets, joint_log_wealth
from fairaudit.inference.levels import pair_levels
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

F = Fraction
UNIT = (F(0), F(1))
rows = st.lists(st.integers(0, 60), min_size=3, max_size=3).filter(any)


def found(counts: list[list[int]], ratios: tuple[Fraction, ...] = (F(1), F(5, 4)), exact: bool = True, confidence: str = "0.9") -> Any:
    groups = [f"g{i}" for i in range(len(counts))]
    law = Law.from_array(counts, kind="counts", decisions=["no", "half", "yes"], groups=groups)
    arrivals = Arrivals(tuple(((), group) for group in law.groups), 4, True, ratios)
    return stream_interval(law, Utility({"half": "1/2", "yes": 1}).on(law), arrivals, "local", UNIT, confidence, exact=exact)


def by_definition(x: list[int], y: list[int], r: Fraction, q: Fraction, ratios: tuple[Fraction, ...]) -> float:
    """Logarithm of Σ w Π(1 − λ(x − rq)) Π(1 + λ'(y − q)), bet by bet and value by value."""
    total = 0.0
    bets = [(2.0**-k, min(15 / 16, float(ratio) * 2.0**-k), 0.8 / 7 / len(ratios)) for ratio in ratios for k in range(1, 8)]
    for one, other, share in [*bets, (0.25, 0, 0.05), (0.5, 0, 0.05), (0, 0.25, 0.05), (0, 0.5, 0.05)]:
        won = log(share)
        for value, n, m in zip((0, 0.5, 1), x, y, strict=True):
            won += n * log(1 - one * (value - float(r * q))) + m * log(1 + other * (value - float(q)))
        total = np.logaddexp(total, won) if total else won
    return float(total)


@settings(max_examples=6, deadline=None)
@given(st.lists(rows, min_size=2, max_size=3))
def test_joint_bets_exclude_every_mean_outside_the_interval(counts: list[list[int]]) -> None:
    ratios = (F(1), F(5, 4))
    interval = found(counts, ratios)
    [levels] = pair_levels([list(range(1, len(counts) + 1))], 4, F(1, 10))

    def excluded(i: int, j: int, ratio: Fraction) -> bool:
        grid = [min(F(1), 1 / ratio) * F(k, 40) for k in range(41)]
        need = -log(float(levels[frozenset((i, j))]))
        return all(by_definition(counts[i], counts[j], ratio, q, ratios) >= need - 1e-9 for q in grid)

    if interval.upper < inf:
        for beyond in (interval.upper, interval.upper * F(3, 2), interval.upper * 40):
            assert all(excluded(i, j, beyond) for i, j in permutations(range(len(counts)), 2))
    if interval.lower > 1:
        assert any(excluded(i, j, 1 / interval.lower) for i, j in permutations(range(len(counts)), 2))


@settings(deadline=None)
@given(rows, rows, st.floats(0.2, 5), st.floats(0, 1))
def test_the_logarithm_of_what_was_won_is_that_of_the_definition(x: list[int], y: list[int], ratio: float, share: float) -> None:
    values, ratios, q = np.array([0, 0.5, 1]), (F(1), F(7, 2)), share * min(1, 1 / ratio)
    made = joint_log_wealth((values, np.array(x, float)), (values, np.array(y, float)), ratio, np.array([q]), joint_bets(ratios))
    assert np.log(np.exp(made).sum()) == pytest.approx(by_definition(x, y, F(ratio), F(q), ratios), rel=1e-6, abs=1e-9)


@settings(max_examples=10, deadline=None)
@given(st.lists(rows, min_size=2, max_size=3))
def test_estimates_are_the_proved_ends_and_more_confidence_is_wider(counts: list[list[int]]) -> None:
    proved, estimate, surer = found(counts), found(counts, exact=False), found(counts, confidence="0.99", exact=False)
    assert float(proved.lower) == pytest.approx(float(estimate.lower), rel=4e-3)
    assert float(proved.upper) == pytest.approx(float(estimate.upper), rel=4e-3) or estimate.upper > 1e8
    assert surer.lower <= estimate.lower * (1 + 1e-6) and estimate.upper <= surer.upper * (1 + 1e-6)
    assert proved.lower == 1 or proved.pairs[0] is not None


def test_a_group_without_any_utility_has_no_upper_end() -> None:
    assert found([[10, 0, 0], [10, 1, 0]]).upper == inf
    assert found([[10, 0, 0], [10, 0, 0]]).lower == 1


def test_bets_that_cannot_be_made_are_refused() -> None:
    for joint, ratios in ((False, (F(1),)), (True, (F(0),)), (True, (F(1),) * 9)):
        with pytest.raises(InputError, match="joint bets need"):
            Arrivals((), 4, joint, ratios)
