"""T10: two persons in one decision, in random order."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations, product
from math import inf
from random import Random

import pytest
import tiers
from theorem_oracle import F, Row, Table, maximize, most_power, pure, random_filter, random_row, ratio, response_rows, stick, table_filter

from fairaudit.model.mechanism import RandomizedResponse
from fairaudit.theorems.t01 import t1
from fairaudit.theorems.t10 import exchange_laws, t10, t10_floor

Policy = dict[tuple[int, ...], Row]


def chances(policy: Policy, rows: Table, profiles: tuple[int, ...], orders: list[tuple[int, ...]]) -> Row:
    """Chance of each person to be chosen, over orders (order[slot] = person) and releases."""
    result = [F(0)] * len(profiles)
    for order in orders:
        for released in product(range(len(rows[0])), repeat=len(profiles)):
            weight = F(1, len(orders))
            for slot, value in enumerate(released):
                weight *= rows[profiles[order[slot]]][value]
            for slot, person in enumerate(order):
                result[person] += weight * policy[released][slot]
    return result


def best_chance_ratio(rows: Table, profiles: tuple[int, ...], orders: list[tuple[int, ...]], *, nobody: bool) -> Fraction:
    """The greatest ratio of the chances of persons 0 and 1 over all policies, which may choose `nobody` or must choose."""
    n, alphabet = len(profiles), list(product(range(len(rows[0])), repeat=len(profiles)))
    size = len(alphabet) * n
    weights = [[F(0)] * size for _ in range(n)]
    for order in orders:
        for i, released in enumerate(alphabet):
            weight = F(1, len(orders))
            for slot, value in enumerate(released):
                weight *= rows[profiles[order[slot]]][value]
            for slot, person in enumerate(order):
                weights[person][i * n + slot] += weight
    # y = T·z with z = 1/chance of person 1: rows of y sum to z, or to at most z.
    sums = [[*(F(-int(j // n == i)) for j in range(size)), F(1), F(0)] for i in range(len(alphabet))]
    chance = [*weights[1], 0, -1]
    return maximize(size + 1, [*weights[0], 0], [chance] if nobody else [*sums, chance], sums if nobody else [])


def all_orders(n: int) -> list[tuple[int, ...]]:
    return list(permutations(range(n)))


def rotations(n: int) -> list[tuple[int, ...]]:
    return [tuple((i + shift) % n for i in range(n)) for shift in range(n)]


@pytest.mark.parametrize("n", [2, 3])
def test_no_policy_exceeds_twice_epsilon_or_the_forms_with_a_floor(n: int) -> None:
    rng, seen = Random(tiers.fresh(f"persons {n}")), 0
    for _ in range(60):
        rows, mechanism = random_filter(rng, rng.randint(2, 3))
        if len(rows[0]) > 3:
            continue
        policy = {released: random_row(rng, n + rng.randint(0, 1)) for released in product(range(len(rows[0])), repeat=n)}
        profiles = tuple(rng.randrange(len(rows)) for _ in range(n))
        found = chances(policy, rows, profiles, all_orders(n))
        reached = max(ratio(a, b) for a, b in permutations(found, 2))
        e, tau = pure(rows), min(found)
        assert reached <= t10(e).value
        if tau:
            seen += 1
            exact, form = t10_floor(mechanism, tau), t10(e, tau)
            assert reached <= exact.value <= form.value <= t10(e).value
            both = list(product(range(len(rows[0])), repeat=2))
            exchanges = [([p[i] * q[j] for i, j in both], [q[i] * p[j] for i, j in both]) for p, q in permutations(rows, 2)]
            assert exact.value == max(most_power(p, q, tau) / tau for p, q in exchanges)
            for p, q in exchanges:
                assert p == q or any(k + stick(p, q, k) / tau <= exact.value for k in exact.multipliers)
    assert tiers.enough(seen > 20)


def test_one_epsilon_is_too_little_and_twice_is_attained() -> None:
    rows = response_rows(2, F(3, 4))
    e = pure(rows)
    assert e < best_chance_ratio(rows, (0, 1, 0), all_orders(3), nobody=False) <= t10(e).value
    assert best_chance_ratio(rows, (0, 1, 0), all_orders(3), nobody=True) == t10(e).value == e**2


def test_a_cyclic_rotation_of_three_gives_only_three_epsilon() -> None:
    rows = response_rows(3, F(1, 2))
    e = pure(rows)
    assert best_chance_ratio(rows, (0, 1, 2), all_orders(3), nobody=True) <= t10(e).value
    assert best_chance_ratio(rows, (0, 1, 2), rotations(3), nobody=True) == e**3 > t10(e).value


def test_the_exchange_of_two_profiles_costs_exactly_twice_epsilon_in_randomized_response() -> None:
    (pair,) = exchange_laws(RandomizedResponse(["a", "b", "c"], exp_epsilon="7/3"))
    assert Fraction(*pair.columns[0]) == F(7, 3) ** 2
    assert sum(p for p, _ in pair.columns) == sum(q for _, q in pair.columns) == pair.denominator


def test_a_policy_that_looks_at_the_slot_alone() -> None:
    """Fixed slots: infinitely unfair at ε = 0. Uniform order: perfectly fair. The bound needs the order, and says so."""
    rows = response_rows(2, F(1, 2))
    policy = {released: [F(1), F(0)] for released in product(range(2), repeat=2)}
    fixed, uniform = (chances(policy, rows, (0, 1), orders) for orders in ([(0, 1)], all_orders(2)))
    assert ratio(*fixed) == inf
    assert ratio(*uniform) == 1
    bound = t10(1)
    assert bound.value == 1
    assert any("order of the candidates is drawn uniformly" in sentence for sentence in bound.assumptions)
    # As a utility of the group under fixed slots it has K = 1, and T1 leaves the cap.
    assert t1(table_filter(rows), 1, "0.1", 1).value == 10


def test_no_privacy_gives_no_bound_without_a_floor() -> None:
    assert t10(inf).value == inf
    assert t10(inf).note
    assert t10(inf, "0.25").value == 4
    assert t10(inf, "0.25").quantity == "selection_ratio"
