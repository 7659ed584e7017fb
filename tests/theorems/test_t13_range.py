"""T13 for an unknown utility in a declared range: equal to exact linear programs, T4 and T2 inside it, and no deployment beyond it.

3,000 random filters and ranges: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t13_range.py
"""

from __future__ import annotations

from itertools import permutations
from math import inf, lcm
from random import Random
from typing import Any

import pytest
import tiers
from theorem_oracle import F, Row, best_in_range, deployments, kron, pure, random_filter, random_row, stick, table_filter

from fairaudit.errors import InputError
from fairaudit.model.mechanism import Constant, RandomizedResponse
from fairaudit.privacy.pairs import pair_laws
from fairaudit.theorems.bound import ANY_UTILITY, ANY_UTILITY_FLOORED
from fairaudit.theorems.t03 import t3_general
from fairaudit.theorems.t04 import t4
from fairaudit.theorems.t13_range import (
    UtilityRange,
    in_each_range,
    in_population,
    range_value,
    read_utility_range,
    t13_range,
)

TIMES = 20 if tiers.FULL else 1


def attained(p: Row, q: Row, declared: UtilityRange, floor: F) -> Any:
    return best_in_range(p, q, declared.gamma, declared.m, declared.gap, floor)


def random_range(rng: Random) -> UtilityRange:
    gamma = F(rng.randint(1, 6))
    m = rng.choice([F(0), gamma * F(rng.randint(0, 4), 4), gamma * F(rng.randint(1, 9), 10)])
    gap = rng.choice([F(0), (gamma - m) * F(rng.randint(0, 5), 4)])
    tau = m + (gamma - m) * F(rng.randint(0, 8), 8)
    return read_utility_range(gamma, m, gap, tau)


def test_the_values_are_those_of_exact_linear_programs() -> None:
    rng = Random(tiers.fresh("range"))
    for _ in range(150 * TIMES):
        rows, mechanism = random_filter(rng, groups=2)
        declared = random_range(rng)
        both = list(permutations(rows, 2))
        value = t13_range(in_each_range(mechanism, [declared])).value
        assert value == max(attained(p, q, declared, F(0)) for p, q in both), (rows, declared)
        if declared.tau:
            bound = t13_range(in_each_range(mechanism, [declared]), floored=True)
            assert bound.value == max(attained(p, q, declared, declared.tau) for p, q in both), (rows, declared)
            assert bound.value <= min(value, declared.gamma / declared.tau)
            assert bound.scope == ANY_UTILITY_FLOORED
            for p, q in both:
                assert any(
                    k + max(F(0), declared.gap + declared.span * stick(p, q, k) - (k - 1) * declared.m) / declared.tau <= bound.value
                    for k in bound.multipliers
                )


def holds(p: Row, q: Row, declared: UtilityRange, v: F) -> bool:
    return declared.gap + declared.span * stick(p, q, v) <= declared.m * (v - 1)


def test_the_least_value_that_holds_and_nothing_below() -> None:
    rng = Random(tiers.fresh("least"))
    for _ in range(300 * TIMES):
        rows, mechanism = random_filter(rng)
        declared = random_range(rng)
        value = range_value(pair_laws(mechanism), declared.gamma, declared.m, declared.gap)
        both = list(permutations(rows, 2))
        if value == inf:
            assert not all(holds(p, q, declared, F(10**9)) for p, q in both)
            continue
        assert value >= 1
        assert all(holds(p, q, declared, value) for p, q in both)
        if value > 1:
            assert not all(holds(p, q, declared, value - (value - 1) * F(1, 10**9)) for p, q in both)


def test_what_it_contains() -> None:
    """K = 0 is T4; m = 0 is T2 without a floor, and T3 with one; m = 0 < K is nothing."""
    rng = Random(tiers.fresh("contains"))
    for _ in range(150 * TIMES):
        rows, mechanism = random_filter(rng)
        declared = random_range(rng)
        gamma, m, gap, tau = declared.gamma, declared.m, declared.gap, declared.tau
        laws = pair_laws(mechanism)
        assert range_value(laws, gamma) == pure(rows)
        if gap:
            assert range_value(laws, gamma, 0, gap) == inf
        if m:
            assert range_value(laws, gamma, m) == t4(mechanism, gamma, m).value
        if tau:
            alike = [UtilityRange(gamma, m, F(0), tau)]
            assert t13_range(in_each_range(mechanism, alike), floored=True).value == t4(mechanism, gamma, m, tau).value
            free = [read_utility_range(gamma, 0, gap, tau)]
            assert t13_range(in_each_range(mechanism, free), floored=True).value == t3_general(mechanism, gamma, tau, gap).value


@pytest.mark.parametrize("least", [F(0), F(1, 4), F(3)])
def test_no_deployment_exceeds_it(least: F) -> None:
    for _, d in deployments(120 * TIMES, uses="group", least=least, masses=True):
        declared = read_utility_range(d.gamma, d.least, d.gap)
        local = t13_range(in_each_range(d.mechanism, [declared]))
        assert d.local <= local.value
        assert local.scope == ANY_UTILITY
        mass = [int(v) for row in d.population for v in row]
        count = len(d.rows_a)
        overall = t13_range(in_population(d.mechanism, mass, [declared] * count), quantity="global")
        assert d.overall <= overall.value
        assert overall.quantity == "global_ratio"
        if d.floor > 0:
            above = read_utility_range(d.gamma, d.least, d.gap, d.floor)
            assert d.local <= t13_range(in_each_range(d.mechanism, [above]), floored=True).value <= local.value
        means = [d.mean(a) for a in d.groups]
        if min(means) > 0:
            own = [read_utility_range(d.gamma, d.least, d.gap, mean) for mean in means]
            assert d.overall <= t13_range(in_population(d.mechanism, mass, own), quantity="global", floored=True).value <= overall.value


def test_the_population_is_that_of_the_joint_rows() -> None:
    rng = Random(tiers.fresh("joint"))
    for _ in range(80 * TIMES):
        rows, mechanism = random_filter(rng)
        count, contexts = len(rows), rng.randint(1, 3)
        shares = [random_row(rng, contexts) for _ in rows]
        population = [[shares[a][x] * rng.choice([1, 1, 2]) if x == 0 else shares[a][x] for a in range(count)] for x in range(contexts)]
        missing = rng.choice([None, 0])
        if missing is not None:
            population = [[F(0) if a == missing else v for a, v in enumerate(row)] for row in population]
        declared = random_range(rng)
        present = [a for a in range(count) if any(row[a] for row in population)]
        joint = [[v / sum(row[a] for row in population) * w for v in (row[a] for row in population) for w in rows[a]] for a in present]
        scale = lcm(*(v.denominator for row in population for v in row))
        mass = [v * scale for row in population for v in row]
        found = t13_range(in_population(mechanism, [int(v) for v in mass], [declared] * count), quantity="global").value
        wanted = range_value(pair_laws(table_filter(joint)), declared.gamma, declared.m, declared.gap) if len(present) > 1 else F(1)
        assert found == wanted


def test_contexts_with_their_own_ranges() -> None:
    """The greatest of the contexts' own values, and one list of multipliers for all of them."""
    coin = RandomizedResponse(["a", "b"], keep_probability="2/3")
    ranges = [read_utility_range(3, 1, 0, 2), read_utility_range(2, "1/2", "1/4", 1), read_utility_range(1, 1)]
    single = [t13_range(in_each_range(coin, [declared])).value for declared in ranges]
    assert t13_range(in_each_range(coin, ranges)).value == max(single)
    bound = t13_range(in_each_range(coin, ranges[:2]), floored=True)
    assert bound.value == max(t13_range(in_each_range(coin, [declared]), floored=True).value for declared in ranges[:2])
    with pytest.raises(InputError, match="a floor is 0"):
        t13_range(in_each_range(coin, ranges), floored=True)


def test_the_examples_of_the_theory() -> None:
    coin = pair_laws(RandomizedResponse(["a", "b"], keep_probability="2/3"))
    assert range_value(coin, 3, 1) == F(7, 5)
    assert range_value(coin, 1) == 2
    product = pair_laws(table_filter(kron([[F(2, 3), F(1, 3)], [F(1, 3), F(2, 3)]], [[F(1)], [F(1)]])))
    assert range_value(product, 3, 1) == F(7, 5)
    k, p, m, gamma = 16, F(1, 8), F(1, 10), F(1)
    q = (1 - p) / (k - 1)
    response = pair_laws(RandomizedResponse(list(range(k)), keep_probability=p))
    assert range_value(response, gamma, m) == (m + (gamma - m) * p) / (m + (gamma - m) * q)


def test_hiding_the_group_leaves_what_the_utility_itself_does() -> None:
    """Behind a constant the second group gets h, the first at most h + K, and least of all where h = m."""
    hidden = pair_laws(Constant(["a", "b"]))
    assert range_value(hidden, 4, 1) == 1
    assert range_value(hidden, 4, 1, 2) == 3
    assert range_value(hidden, 4, 0, 2) == inf


@pytest.mark.parametrize(
    ("numbers", "word"),
    [((0,), "gamma is 0"), ((1, 2), "above gamma"), ((1, 0, -1), "at least 0"), ((1, 0, 0, 2), "above gamma"), ((1, "x"), "not a number")],
)
def test_refusals(numbers: tuple[Any, ...], word: str) -> None:
    with pytest.raises(InputError, match=word):
        read_utility_range(*numbers)
