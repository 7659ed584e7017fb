"""T17: several fresh releases of the same group.

2,000 random filters: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t17.py
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import inf, prod
from random import Random

import numpy as np
import pytest
import tiers
from theorem_oracle import F, best_over_pairs, random_filter, random_row, table_filter

from fairaudit.errors import InputError
from fairaudit.model.mechanism import Constant, Identity, Mechanism, RandomizedResponse
from fairaudit.model.policy import Deployment, Policy
from fairaudit.model.utility import Utility
from fairaudit.privacy.columns import merged_columns
from fairaudit.privacy.pairs import hockey_stick, pair_laws
from fairaudit.tables.values import Label
from fairaudit.theorems.t13 import greatest_ratio
from fairaudit.theorems.t13_exact import best_sums, envelope
from fairaudit.theorems.t17 import LastRelease, last_release, t17

TIMES = 50 if tiers.FULL else 1

COIN = RandomizedResponse(["a", "b"], keep_probability="11/20")

TWENTY = F(84157638225849945906869, 39321600000000000000000)


def dense(rows: list[list[F]], times: int) -> list[list[F]]:
    """The filter that releases `times` values, written out."""
    return [[prod(chosen, start=F(1)) for chosen in product(row, repeat=times)] for row in rows]


@pytest.mark.parametrize(("releases", "value"), [(1, F(11, 9)), (2, F(4, 3)), (20, TWENTY)])
def test_the_values_of_the_page(releases: int, value: F) -> None:
    assert t17(COIN, releases, tau="3/10").value == value


@pytest.mark.parametrize(("target", "releases"), [("3/2", 4), (2, 15), (3, 81)])
def test_where_the_targets_of_the_page_break(target: object, releases: int) -> None:
    assert last_release(COIN, target, tau="3/10") == LastRelease(releases, exact=True)


def test_the_value_is_the_supremum_on_the_product_written_out() -> None:
    rng = Random(tiers.fresh("t17"))
    for _ in range(40 * TIMES):
        rows, mechanism = random_filter(rng)
        times = 2 if len(rows[0]) > 3 else 3
        m = F(rng.randint(1, 4), 4)
        gamma = m + rng.randint(1, 5)
        tau = rng.choice([m, (m + gamma) / 2, gamma])
        bound = t17(mechanism, times, gamma=gamma, m=m, tau=tau)
        assert bound.value == best_over_pairs(dense(rows, times), m, gamma, tau)


def test_the_rows_of_several_releases_are_those_of_the_product() -> None:
    rng = Random(tiers.fresh("rows of T17"))
    for _ in range(60 * TIMES):
        rows, mechanism = random_filter(rng)
        times = rng.randint(1, 2 if len(rows[0]) > 3 else 4)
        counted = {pair.columns for pair in pair_laws(mechanism, times)}
        written_out = table_filter(dense(rows, times))
        assert counted == {pair.columns for pair in pair_laws(written_out)}


def deployment(rng: Random, mechanism: Mechanism, groups: Sequence[str], releases: int, odds: Sequence[Sequence[F]]) -> Deployment:
    """A policy behind a filter of the groups and one of two contexts; what the policy does has no part in what is asked."""
    contexts = ["x", "y"]
    shown = [f"s{i}" for i in range(len(odds[0]))]
    masses = [rng.randint(0, 3) for _ in range(2 * len(groups) - 1)] + [1]
    policy = Policy.from_array(
        np.full((len(shown), len(mechanism.outputs), 3), F(1, 3)),
        decisions=list("uvw"),
        groups=[",".join(label) for label in mechanism.outputs],
        contexts=shown,
    )
    behind = Mechanism.from_array(np.array(odds, dtype=object), contexts, shown)
    return policy.behind(group=mechanism, context=behind, population=np.reshape(masses, (2, -1)), releases=releases)


def test_the_greatest_ratio_over_policies_is_that_of_the_product_written_out() -> None:
    compared = 0
    for seed in range(60 * TIMES):
        rng = Random(tiers.fresh(f"policies {seed}"))
        rows, _ = random_filter(rng)
        if len(rows[0]) < 2:
            continue
        groups, times = [str(a) for a in range(len(rows))], 2 if len(rows[0]) > 3 else 3
        odds = [random_row(rng, rng.choice([1, 2]))] * 2 if seed % 3 else [random_row(rng, 2), random_row(rng, 2)]
        several, once = (
            deployment(
                Random(tiers.fresh(seed)),
                Mechanism.from_array(np.array(table, dtype=object), groups, range(len(table[0]))),
                groups,
                n,
                odds,
            )
            for table, n in ((rows, times), (dense(rows, times), 1))
        )
        drawn = {(u, x, a): F(rng.randint(0, 4), rng.randint(1, 3)) for u in "uvw" for x in "xy" for a in groups}
        worth: dict[tuple[str, Label, Label], tuple[int, int]] = {
            (u, (x,), (a,)): drawn[u, x, a if seed % 2 else groups[0]].as_integer_ratio() for u in "uvw" for x in "xy" for a in groups
        }
        utility = Utility({}, worth)
        for quantity in ("local", "global"):
            found, expected = (greatest_ratio(d, utility.on(d.law), quantity) for d in (several, once))
            assert (found is None) == (expected is None)
            if found is not None and expected is not None:
                compared += 1
                assert (found.value, found.context, found.higher, found.lower) == (
                    expected.value,
                    expected.context,
                    expected.higher,
                    expected.lower,
                )
    assert tiers.enough(compared > 80 * TIMES)


@pytest.mark.parametrize(("groups", "keep", "releases"), [(2, "11/20", 20), (4, "3/10", 60), (3, "1/2", 300)])
def test_for_a_free_utilities_it_is_that_of_their_range(groups: int, keep: str, releases: int) -> None:
    names = [str(a) for a in range(groups)]
    filtered = RandomizedResponse(names, keep_probability=keep)
    policy = Policy.from_array([[F(1, 2), F(1, 2)]] * groups, decisions=["yes", "no"], groups=names)
    behind = policy.behind(group=filtered, releases=releases)
    found = greatest_ratio(behind, Utility({"yes": "3", "no": "1/2"}).on(behind.law), "local")
    assert found is not None and found.value == t17(filtered, releases, gamma=3, m="1/2").value


@pytest.mark.parametrize("most", [5, 60])
def test_sums_over_few_and_many_ratios_are_those_of_the_best_decisions(most: int) -> None:
    rng = Random(tiers.fresh("many ratios"))
    for _ in range(30):
        columns = merged_columns([(rng.randint(0, most), rng.randint(0, most)) for _ in range(most * most // 4)] + [(1, 1)])
        worth = [[(rng.randint(0, 5), rng.randint(0, 5)) for _ in range(4)] for _ in range(rng.randint(1, 3))]
        value = F(rng.randint(4, 12), 4)
        top = low = F(0)
        for p, q in columns:
            for decisions in worth:
                _, taken, at = max((p * a - value * q * b, q * b, p * a) for a, b in decisions)
                top, low = top + at, low + taken
        found = best_sums(columns, [envelope(*zip(*decisions, strict=True)) for decisions in worth], value)
        assert (F(found[0]), F(found[1])) == (top, low)


def test_without_a_floor_or_a_least_utility_only_epsilon_is_left() -> None:
    assert t17(COIN, 7).value == F(11, 9) ** 7
    assert t17(Identity("ab"), 1).value == inf
    assert t17(Identity("ab"), 2, tau="1/4").value == 4
    assert t17(Constant("ab"), 9).value == 1


def test_values_do_not_decrease_in_the_number_of_releases() -> None:
    rng = Random(tiers.fresh("monotone T17"))
    for _ in range(25 * TIMES):
        _, mechanism = random_filter(rng)
        constants = {"gamma": 3, "m": F(rng.randint(1, 4), 4), "tau": rng.choice([0, F(3, 2), 2]), "gap": rng.choice([0, F(1, 3)])}
        values = [t17(mechanism, n, **constants).value for n in range(1, 6)]
        assert values == sorted(values)
        reached = values[rng.randint(0, 4)]
        found = last_release(mechanism, reached, most=5, **constants)
        held = sum(value <= reached for value in values)
        assert found == LastRelease(held, exact=held < 5) or (found.releases == inf and held == 5)


def test_one_k_per_pair_proves_the_value() -> None:
    bound = t17(RandomizedResponse(range(4), keep_probability="0.4"), 50, tau="1/5")
    for pair in pair_laws(RandomizedResponse(range(4), keep_probability="0.4"), 50):
        assert any(k + hockey_stick(pair, k) * 5 <= bound.value for k in bound.multipliers)


def test_a_target_that_the_cap_keeps_holds_for_ever() -> None:
    assert last_release(COIN, "10/3", tau="3/10") == LastRelease(inf, exact=True)
    assert last_release(COIN, 4, m="1/4") == LastRelease(inf, exact=True)
    assert last_release(Constant("ab"), 1) == LastRelease(inf, exact=True)
    assert last_release(COIN, "6/5", tau="3/10") == LastRelease(0, exact=True)


def test_a_target_that_holds_as_far_as_was_looked() -> None:
    assert last_release(COIN, 3, tau="3/10", most=80) == LastRelease(80, exact=False)
    assert last_release(COIN, 3, tau="3/10", most=82) == LastRelease(81, exact=True)


def test_the_sentence_about_releases() -> None:
    said = "one memory sees at most 2 releases of a group, each drawn afresh (declared)"
    assert said in t17(COIN, 2, tau="3/10").assumptions
    assert not any("releases of a group" in sentence for sentence in t17(COIN, 1, tau="3/10").assumptions)


@pytest.mark.parametrize("releases", [0, -1, 10_001, 2.0, True, "2"])
def test_a_number_of_releases_that_is_none(releases: object) -> None:
    with pytest.raises(InputError, match="a whole number from 1 to 10000 is accepted"):
        t17(COIN, releases, tau="3/10")  # type: ignore[arg-type]


def test_releases_with_too_many_ratios_are_refused() -> None:
    numbers = [1000 + i for i in range(100)], [1000 + 7 * i % 101 for i in range(100)]
    many = table_filter([[F(v, sum(row)) for v in row] for row in numbers])
    for releases in (4, 10_000):
        with pytest.raises(InputError, match="too many different likelihood ratios"):
            t17(many, releases, tau="3/10")
    assert last_release(many, "3/2", tau="3/10") == LastRelease(2, exact=False)
