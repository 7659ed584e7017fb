"""T13: the greatest ratio over all policies, against exact linear programs and all deterministic policies.

All 5,000 random settings: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t13.py
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import permutations, product
from math import inf
from random import Random
from typing import Any

import numpy as np
import pytest
import tiers
from hypothesis import given
from hypothesis import strategies as st
from theorem_oracle import F, Table, random_row, response_rows
from worst_policy_oracle import Setting, by_enumeration, by_linear_program, random_setting, ratio

from fairaudit.errors import InputError
from fairaudit.measures.ratios import global_fairness, local_fairness
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism, RandomizedResponse
from fairaudit.model.policy import Deployment, Policy
from fairaudit.model.utility import Utility, UtilityTable
from fairaudit.privacy.pairs import joined_columns, merged_columns
from fairaudit.theorems import t13_problems
from fairaudit.theorems.applicable import guarantees
from fairaudit.theorems.bound import ANY_POLICY
from fairaudit.theorems.case import Case
from fairaudit.theorems.supremum import Supremum
from fairaudit.theorems.t04 import t4
from fairaudit.theorems.t13 import greatest_ratio
from fairaudit.theorems.t13_exact import best_sums, envelope
from fairaudit.theorems.t13_laws import LEVELS, filter_laws
from fairaudit.theorems.t13_policy import attaining_policy

SETTINGS, OUTPUTS = (5_040, 48) if tiers.FULL else (120, 12)

TWO_THIRDS = [[F(2, 3), F(1, 3)], [F(1, 3), F(2, 3)]]

MEASURES = {"local": local_fairness, "global": global_fairness}

QUANTITIES = ("local", "global")


def found(setting: Setting, quantity: str) -> Supremum:
    """T13 of a setting that is compared."""
    result = greatest_ratio(*setting.subject(), quantity)
    assert result is not None
    return result


def place(setting: Setting, result: Supremum) -> tuple[int | None, int, int] | None:
    """Where a supremum says that it is attained, by position."""
    deployment, _ = setting.subject()
    if result.higher is None or result.lower is None:
        assert (result.context, result.higher, result.lower, result.value) == (None, None, None, 1)
        return None
    context = None if result.context is None else deployment.contexts.index(result.context)
    return context, deployment.groups.index(result.higher), deployment.groups.index(result.lower)


def attained_by(deployment: Deployment, table: UtilityTable, result: Supremum) -> Any:
    """The figure of the policy that is said to attain it, measured behind the filters."""
    policy = attaining_policy(deployment, table, result)
    assert set(policy.law.weights.ravel().tolist()) <= {0, 1}
    mass = None if deployment.mass is None else np.array(deployment.mass, dtype=object).reshape(len(deployment.contexts), -1)
    behind = policy.behind(group=deployment.group_filter, context=deployment.context_filter, population=mass)
    measured = MEASURES[result.quantity](behind.law, replace(table, law=behind.law))
    assert measured is not None
    return measured.ratio


def settings() -> Iterator[tuple[Setting, str]]:
    """Random settings of every kind, the same in each run."""
    kinds = list(product(["decision", "context", "group", "group"], QUANTITIES, [1, 1, 1, 2, 3]))
    for seed in range(SETTINGS):
        uses, quantity, releases = kinds[seed % len(kinds)]
        yield random_setting(Random(tiers.fresh(f"t13 {seed}")), uses=uses, releases=releases, most_outputs=OUTPUTS), quantity


def test_value_and_place_are_those_of_an_exact_linear_program_and_a_policy_attains_them() -> None:
    seen: dict[str, int] = {}
    for setting, quantity in settings():
        ratios = [(by_linear_program(sums), where) for *where, sums in setting.sums(quantity)]
        deployment, table = setting.subject()
        result = greatest_ratio(deployment, table, quantity)
        if not ratios:
            assert result is None
            seen["nothing is compared"] = seen.get("nothing is compared", 0) + 1
            continue
        assert result is not None
        value = max(v for v, _ in ratios)
        assert (result.value, result.exact) == (value, True)
        assert place(setting, result) == (None if value == 1 else next(tuple(where) for v, where in ratios if v == value))
        if setting.releases == 1:
            assert attained_by(deployment, table, result) == value
        kind = "infinite" if value == inf else "one" if value == 1 else "finite"
        seen[kind] = seen.get(kind, 0) + 1
    assert tiers.enough(min(seen.values()) > SETTINGS // 150), seen
    assert tiers.enough(len(seen) == 4)


def test_a_linear_program_and_an_enumeration_of_policies_agree() -> None:
    for seed in range(25):
        setting = random_setting(Random(tiers.fresh(f"both {seed}")), uses="group", most_groups=3, most_outputs=8)
        for _, _, _, (tops, lows) in setting.sums("local"):
            if len(tops[0]) ** len(tops) <= 300:
                assert by_enumeration((tops, lows)) == by_linear_program((tops, lows))


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_no_policy_exceeds_the_value_and_one_attains_it(quantity: str) -> None:
    """Every deterministic policy, for every pair of groups at once."""
    for seed in range(1000 if tiers.FULL else 15):
        rng = Random(tiers.fresh(f"all {quantity} {seed}"))
        setting = random_setting(rng, uses="group", most_groups=4, releases=rng.choice([1, 1, 2]), most_outputs=6)
        sums = [sums for _, _, _, sums in setting.sums(quantity)]
        if sums:
            assert found(setting, quantity).value == max(map(by_enumeration, sums))


def test_what_is_issued_is_the_supremum_and_no_other_bound_is_below_it() -> None:
    below, closer = 0, 0
    for seed in range(1500 if tiers.FULL else 30):
        setting = random_setting(
            Random(tiers.fresh(f"issued {seed}")), uses=["decision", "context", "group"][seed % 3], most_outputs=OUTPUTS
        )
        deployment, table = setting.subject()
        issued = guarantees(Case(deployment, deployment.law, table, {}), None, all_bounds=True)
        for quantity in QUANTITIES:
            ratios = [by_linear_program(sums) for *_, sums in setting.sums(quantity)]
            assert [one.value for one in issued.suprema if one.quantity == quantity] == ([max(ratios)] if ratios else [])
            others = [one.value for one in issued.bounds if (one.quantity, one.scope) == (f"{quantity}_ratio", ANY_POLICY)]
            assert min(others, default=inf) >= max(ratios, default=1)
            below += bool(others) and min(others) > max(ratios)
            closer += bool(others) and min(others) == max(ratios)
    assert tiers.enough(min(below, closer) > 0)


def test_the_examples_of_the_theory_page() -> None:
    assert found(Setting([TWO_THIRDS], [[[F(1), F(3)]] * 2]), "local").value == F(7, 5)
    shares = [[F(3, 4), F(1, 4)], [F(1, 4), F(3, 4)]]
    crossed = Setting([TWO_THIRDS], [[[F(1), F(2)]] * 2, [[F(3), F(1)]] * 2], None, shares)
    local, overall = found(crossed, "local"), found(crossed, "global")
    assert (local.value, place(crossed, local)) == (F(7, 5), (1, 0, 1))
    assert (overall.value, place(crossed, overall)) == (F(12, 7), (None, 1, 0))
    assert [by_linear_program(sums) for _, _, _, sums in crossed.sums("global")] == [F(7, 5), F(12, 7)]
    assert found(Setting([TWO_THIRDS], [[[F(1), F(2)]] * 2]), "local").value == F(5, 4)
    by_group = Setting([TWO_THIRDS], [[[F(1), F(1)], [F(0), F(2)]]])
    result = found(by_group, "local")
    assert (result.value, place(by_group, result)) == (inf, (0, 0, 1))
    assert found(Setting([TWO_THIRDS], [[[F(1), F(1)], [F(1, 10**9), F(2)]]]), "local").value > 10**8
    assert by_enumeration(next(sums for _, a, _, sums in by_group.sums("local") if a == 1)) == 2


@pytest.mark.parametrize("releases", [1, 2, 7, 20])
def test_releases_of_a_nearly_fair_coin(releases: int) -> None:
    """Utilities from 3/10 to 1: S vanishes at the value, by the number of releases that say the one group."""
    setting = Setting([response_rows(2, F(11, 20))], [[[F(3, 10), F(1)]] * 2], releases=releases)
    total, times = F(0), 1
    value = found(setting, "local").value
    for i in range(releases + 1):
        gap = (11**i * 9 ** (releases - i) - value * 9**i * 11 ** (releases - i)) / F(20) ** releases
        total += times * max(gap, gap * F(3, 10))
        times = times * (releases - i) // (i + 1)
    assert total == 0
    assert 1 < value <= F(11, 9) ** releases


@pytest.mark.parametrize("rows", [response_rows(2, 1 - F(1, 10**40)), response_rows(3, F(1)), response_rows(3, F(0)), [[F(1)], [F(1)]]])
def test_filters_that_say_nearly_all_or_nothing(rows: Table) -> None:
    for quantity, values in product(QUANTITIES, ([F(0), F(1)], [F(1, 10**30), F(1)], [F(2), F(2)])):
        setting = Setting([rows], [[values] * len(rows)])
        expected = max(by_linear_program(sums) for _, _, _, sums in setting.sums(quantity))
        result = found(setting, quantity)
        assert result.value == expected
        assert attained_by(*setting.subject(), result) == expected


def test_without_the_group_it_is_t4_and_without_a_floor_the_greatest_likelihood_ratio() -> None:
    for seed in range(30):
        rng = Random(tiers.fresh(f"free {seed}"))
        setting = random_setting(rng, uses="decision", releases=1)
        values = setting.utility[0][0]
        deployment, table = setting.subject()
        result = greatest_ratio(deployment, table, "local")
        assert result is not None
        if 0 < min(values) < max(values):
            assert result.value == t4(deployment.group_filter, max(values), min(values)).value
        elif min(values) < max(values):
            rows = setting.rows_a
            assert result.value == max(ratio(p, q) for a, b in permutations(rows, 2) for p, q in zip(a, b, strict=True) if p or q)
        else:
            assert result.value == 1


@pytest.mark.parametrize("keep", [F(1, 2), F(3, 5), F(99, 100)])
@pytest.mark.parametrize("k", [2, 5, 16])
def test_randomized_response_has_a_closed_form(k: int, keep: Fraction) -> None:
    m, gamma, lie = F(1, 10), F(2), (1 - keep) / (k - 1)
    result = found(Setting([response_rows(k, keep)], [[[m, gamma, F(1)]] * k]), "local")
    assert result.value == (m + (gamma - m) * keep) / (m + (gamma - m) * lie)
    assert (result.higher, result.lower) == ((("g0.0",), ("g0.1",)) if k > 2 or keep > lie else (None, None))


def test_ties_go_to_the_first_in_input_order() -> None:
    """All contexts and pairs are alike but for the order of decisions and for a factor."""
    rng = Random(tiers.fresh("ties"))
    base = [F(1), F(2), F(5), F(7)]
    rows = [[rng.sample(base, 4) for _ in range(3)] for _ in range(3)]
    setting = Setting([response_rows(3, F(3, 5))], [[list(base)] * 3, [[3 * v for v in reversed(base)]] * 3, *rows])
    ratios = [(by_linear_program(sums), tuple(where)) for *where, sums in setting.sums("local")]
    value = max(v for v, _ in ratios)
    assert place(setting, found(setting, "local")) == next(where for v, where in ratios if v == value)
    free = Setting([response_rows(3, F(3, 5))], setting.utility[:2])
    assert place(free, found(free, "local")) == (0, 0, 1)


def test_contexts_with_only_zeros_do_not_hide_others() -> None:
    zeros, worth = [[F(0), F(0)]] * 2, [[F(1), F(2)]] * 2
    for utility, where in (([zeros, worth], 1), ([worth, zeros], 0)):
        result = found(Setting([TWO_THIRDS], utility), "local")
        assert (result.value, result.context) == (F(5, 4), (f"c.{where}",))
    assert found(Setting([TWO_THIRDS], [zeros, zeros]), "local").value == 1
    assert found(Setting([TWO_THIRDS], [zeros, zeros]), "global").value == 1
    assert found(Setting([TWO_THIRDS], [[[F(0)] * 2, [F(0), F(1)]]]), "local").value == inf


def test_groups_without_mass_are_not_compared_globally() -> None:
    utility = [[[F(1), F(9)], [F(1), F(2)], [F(1), F(2)]]]
    setting = Setting([response_rows(3, F(3, 5))], utility, None, [[F(0), F(1), F(1)]])
    assert place(setting, found(setting, "global")) == (None, 1, 2)
    assert place(setting, found(setting, "local")) == (0, 0, 1)
    alone = Setting([response_rows(3, F(3, 5))], utility, None, [[F(0), F(1), F(0)]])
    assert greatest_ratio(*alone.subject(), "global") is None


def test_numbers_beyond_floats() -> None:
    """Masses, utilities and filters far outside float64 change nothing: what floats cannot decide is left to integers."""
    for seed in range(12):
        rng = Random(tiers.fresh(f"far {seed}"))
        tiny = [F(1, 10 ** rng.choice([3, 200, 400])) for _ in range(2)]
        rows = [[1 - tiny[0], tiny[0]], [tiny[1], 1 - tiny[1]]]
        utility = [
            [[F(10 ** rng.choice([-400, -200, 0, 200, 400]) * rng.randint(1, 9)) for _ in range(3)] for _ in range(2)] for _ in range(2)
        ]
        utility = [[[v if v else F(1, 10**350) for v in row] for row in block] for block in utility]
        population = [[F(rng.choice([1, 10**350])) for _ in range(2)] for _ in range(2)]
        setting = Setting([rows], utility, None, population)
        for quantity in QUANTITIES:
            expected = max(by_linear_program(sums) for _, _, _, sums in setting.sums(quantity))
            result = found(setting, quantity)
            assert result.value == expected
            assert attained_by(*setting.subject(), result) == expected


def test_several_releases_are_the_rows_of_all_of_them_together() -> None:
    for seed in range(12):
        rng = Random(tiers.fresh(f"several {seed}"))
        setting = random_setting(rng, uses="group", most_groups=4, releases=2, most_outputs=36)
        flat = replace(setting, factors=[setting.rows_a], releases=1, responses=())
        for quantity in QUANTITIES:
            one, other = (greatest_ratio(*each.subject(), quantity) for each in (setting, flat))
            assert (one is None) == (other is None)
            if one is not None and other is not None:
                assert one.value == other.value
                assert place(setting, one) == place(flat, other)
                assert attained_by(*flat.subject(), other) == one.value


def test_nothing_is_said_where_a_utility_is_open() -> None:
    law = Law.from_array([[[1, 0], [1, 1]]], kind="counts", decisions=["a", "b"])
    entries = {("a", ("0",), ("0",)): (1, 1), ("a", ("0",), ("1",)): (1, 1), ("b", ("0",), ("1",)): (2, 1)}
    table = Utility({}, entries).on(law)
    assert table.given is not None
    deployment = Policy(law).behind(group=RandomizedResponse(["0", "1"], keep_probability="2/3"))
    assert greatest_ratio(deployment, table, "local") is None


def test_decisions_that_never_occur_can_be_taken() -> None:
    policy = Policy.from_array([["1"], ["1"]], decisions=["pass"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="2/3"))
    table = Utility({"pass": 1, "hire": 3}).on(deployment.law)
    result = greatest_ratio(deployment, table, "local")
    assert result is not None
    assert result.value == F(7, 5)
    assert attaining_policy(deployment, table, result).law.decisions == ("pass", "hire")


def test_a_policy_is_written_down_for_one_release_and_not_too_many_cells() -> None:
    deployment, table = Setting([TWO_THIRDS], [[[F(1), F(3)]] * 2], releases=2).subject()
    result = greatest_ratio(deployment, table, "local")
    assert result is not None
    with pytest.raises(InputError, match=r"sees 2 releases of the group; a policy is a table of one: put it behind"):
        attaining_policy(deployment, table, result)
    contexts = 40_000
    law = Law.from_array(np.ones((contexts, 3, 2), dtype=np.int64), kind="counts")
    wide = Policy(law).behind(group=RandomizedResponse(["0", "1", "2"], keep_probability="1/2"))
    many = Utility({"0": 1, "1": 2}).on(wide.law)
    result = greatest_ratio(wide, many, "local")
    assert result is not None
    with pytest.raises(InputError, match=r"has 120000 cells of context and group; at most 100000 are written down"):
        attaining_policy(wide, many, result)


# The parts


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=7), st.integers(0, 20), st.integers(1, 9))
def test_an_envelope_keeps_what_is_best(points: list[tuple[int, int]], n: int, d: int) -> None:
    kept = envelope([a for a, _ in points], [b for _, b in points])
    assert set(kept) <= set(points)
    assert list(kept) == sorted(set(kept), reverse=True)

    def best(listed: Any) -> tuple[int, int]:
        return max((n * a - d * b, b) for a, b in listed)

    assert best(points) == best(kept)
    assert min(b for _, b in points) == kept[-1][1]
    assert max(a for a, _ in points) == kept[0][0]


def random_columns(rng: Random) -> tuple[tuple[int, int], ...]:
    rows = [random_row(rng, 4, zeros=rng.random() < 0.5) for _ in range(2)]
    return merged_columns([(int(p * 5040), int(q * 5040)) for p, q in zip(*rows, strict=True)])


def test_sums_are_those_of_all_decisions() -> None:
    for seed in range(100):
        rng = Random(tiers.fresh(f"sums {seed}"))
        columns = joined_columns(random_columns(rng), random_columns(rng))
        blocks = [[(rng.randint(0, 5), rng.randint(0, 5)) for _ in range(rng.randint(1, 5))] for _ in range(2)]
        value = F(rng.randint(1, 30), rng.randint(1, 10))
        top = low = F(0)
        for p, q in columns:
            for block in blocks:
                _, taken, given_ = max((p * a - value * q * b, q * b, p * a) for a, b in block)
                top, low = top + given_, low + taken
        assert best_sums(columns, [envelope(*map(list, zip(*block, strict=True))) for block in blocks], value) == (top, low)


@pytest.mark.parametrize("above", [0, 1 << 45])
def test_pairs_that_are_alike_are_one_with_the_least_rank(above: int) -> None:
    rng = Random(tiers.fresh("alike"))
    found, least = t13_problems._Found(repeats=True), dict[int, int]()
    for start in (0, 1000, 500):
        keys, ranks = [above + rng.randint(0, 40) for _ in range(100)], rng.sample(range(start, (1 << 20) + start), 100)
        found.add(np.array(keys), np.array(ranks), at_once=start == 1000)
        for key, rank in zip(keys, ranks, strict=True):
            least[key] = min(rank, least.get(key, rank))
    found.merge()
    assert dict(zip(found.keys.tolist(), found.ranks.tolist(), strict=True)) == least


def test_a_few_ratios_stand_for_all_of_them_on_the_safe_side() -> None:
    """Sums over the ratios that stay are at least those over all, but for the error that is stated, and keep the masses."""
    for seed in range(20):
        rng = Random(tiers.fresh(f"levels {seed}"))
        factors = [[random_row(rng, 4, zeros=rng.random() < 0.3) for _ in range(3)] for _ in range(2)]
        each = [Mechanism.from_array(rows, list("xyz"), list("abcd")).factors[0] for rows in factors]
        laws = filter_laws(Mechanism(tuple(each)), 1)
        whole = laws.levels[-1]
        assert len(laws.levels) <= len(LEVELS) + 1
        utilities = [[(rng.random(), rng.random()) for _ in range(4)] for _ in range(5)]
        for law in laws.levels:
            assert np.allclose(law.p.sum(axis=1), 1) and np.allclose(law.q.sum(axis=1), 1)
            assert (law.error < 1e-12).all()
            for block, v in product(utilities, (0.5, 1.0, 2.5)):
                sums = [np.max([lw.p * a - v * lw.q * b for a, b in block], axis=0).sum(axis=1) for lw in (law, whole)]
                assert (sums[0] >= sums[1] - law.error * (1 + v) - 1e-13).all()
