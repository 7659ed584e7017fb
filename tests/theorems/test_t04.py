"""T4: utilities that are themselves at least m."""

from __future__ import annotations

from itertools import permutations
from random import Random

import pytest
import tiers
from theorem_oracle import F, best_over_pairs, best_ratio, deployments, most_power, proved, random_filter, stick, table_filter

from fairaudit.errors import InputError
from fairaudit.model.mechanism import RandomizedResponse
from fairaudit.theorems.t03 import t3_mechanism
from fairaudit.theorems.t04 import t4


@pytest.mark.parametrize("least", [F(1, 4), F(1), F(3)])
def test_no_deployment_exceeds_the_bound(least: F) -> None:
    for _, d in deployments(120, uses="context", least=least):
        gamma, m, tau = d.gamma, d.least, d.floor
        every, own = t4(d.mechanism, gamma, m), t4(d.mechanism, gamma, m, tau)
        assert d.local <= own.value <= every.value
        assert every.scope == "any policy behind this filter"
        assert not any(sentence.endswith("(declared)") for sentence in every.assumptions)
        for bound, low in ((every, m), (own, tau)):
            assert proved(
                bound,
                d.rows_a,
                lambda p, q, k, c=(gamma, m, low): k + max(F(0), (c[0] - c[1]) * stick(p, q, k) - (k - 1) * c[1]) / c[2],
            )
        assert own.value <= t3_mechanism(d.mechanism, tau / gamma).value


def test_the_value_is_the_supremum_over_levels_and_the_best_response() -> None:
    rng = Random(tiers.fresh("t4"))
    for _ in range(60):
        rows, mechanism = random_filter(rng)
        gamma = F(rng.randint(2, 6))
        m = F(rng.randint(1, 4 * gamma.numerator), 4)
        tau = rng.choice([m, (m + gamma) / 2, gamma, m + (gamma - m) / 7])
        value = t4(mechanism, gamma, m, tau).value
        if m < gamma:
            start = (tau - m) / (gamma - m)
            levels = {start, *(level for q in rows for level in subset_sums(q) if level >= start)}
            formula = max((m + (gamma - m) * most_power(p, q, s)) / (m + (gamma - m) * s) for p, q in permutations(rows, 2) for s in levels)
            assert value == formula
        assert value == best_over_pairs(rows, m, gamma, tau)


def subset_sums(row: list[F]) -> set[F]:
    sums = {F(0)}
    for v in row:
        sums |= {s + v for s in sums}
    return sums


def test_the_supremum_can_lie_above_the_floor() -> None:
    """Reading the formula at the floor alone would be too low: the ratio grows until the test has taken its best outputs."""
    rows = [[F(3, 4), F(1, 4)], [F(1, 4), F(3, 4)]]
    m, gamma = F(1), F(11)
    at_floor = (m + (gamma - m) * 0) / m
    best = best_ratio(rows, m, gamma, m, (0, 1))
    assert best == t4(table_filter(rows), gamma, m).value == (m + 10 * F(3, 4)) / (m + 10 * F(1, 4))
    assert best > at_floor


def test_every_utility_equal_is_parity() -> None:
    assert t4(RandomizedResponse(["a", "b"], keep_probability="0.9"), 3, 3).value == 1


def test_without_any_floor_it_is_refused() -> None:
    with pytest.raises(InputError, match="above 0"):
        t4(RandomizedResponse(["a", "b"], keep_probability="0.9"), 3, 0)
