"""Bounds for all policies and all utilities of a declared range, against sums over dense rows of plain fractions.

All 400 random policies: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_ranges.py
"""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import permutations
from typing import Any

import pytest
import tiers
from assumptions import complete
from plain_certificates import INF, checker, ratio, raw, text
from policy_certificates import TINY, Policy, coin, stated, write
from policy_suprema import declare, ranged

ANY_UTILITY = checker.claims.ANY_UTILITY
FLOORED = checker.claims.ANY_UTILITY_FLOORED
SEEDS = range(0, 400, 1 if tiers.FULL else 5)
BLOCKS = 4


def claim(local: bool, value: Any, multipliers: Any = None) -> dict[str, Any]:
    found = {"quantity": f"{'local' if local else 'global'}_ratio", "relation": "<=", "by": "T13", "value": text(value)}
    if multipliers is None:
        return found | {"scope": ANY_UTILITY, "evidence": {}}
    return found | {"scope": FLOORED, "evidence": {"multipliers": [str(k) for k in multipliers]}}


def true(certificate: dict[str, Any], *claims: dict[str, Any]) -> bool:
    """Whether the checker finds everything true where these are the claims."""
    certificate["claims"] = [{"assumptions": [], **one} for one in claims]
    return bool(checker.check(raw(complete(certificate))).ok)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_a_value_is_accepted_from_the_least_one_that_holds(block: int) -> None:
    for seed in SEEDS[block::BLOCKS]:
        p = Policy(tiers.fresh(seed))
        declare(p, seed)
        certificate = write(p)
        for local in (True, False):
            compared = ranged(p, local)
            if not compared:
                assert not true(certificate, claim(local, 10**9))
                continue
            least = max(pair.least() for pair in compared)
            assert not true(certificate, claim(local, INF))
            if least == INF:
                assert not true(certificate, claim(local, 10**30))
                continue
            assert true(certificate, claim(local, least)) and true(certificate, claim(local, least + TINY)), seed
            assert not true(certificate, claim(local, least - TINY)), seed


@pytest.mark.parametrize("block", range(BLOCKS))
def test_with_floors_a_value_is_accepted_where_the_multipliers_prove_it(block: int) -> None:
    pick = random.Random(tiers.fresh(block))
    for seed in SEEDS[block::BLOCKS]:
        p = Policy(tiers.fresh(seed))
        declare(p, seed)
        certificate = write(p)
        for local in (True, False):
            compared = ranged(p, local)
            if not compared or not all(pair.tau for pair in compared):
                assert not true(certificate, claim(local, 10**9, [0, 1, 2])), seed
                continue
            best = {min([*pair.turns(), *([pair.least()] if pair.least() < INF else [])], key=pair.proved) for pair in compared}
            for multipliers in (best, {pick.choice([*best])}, {Fraction(pick.randint(0, 9), 3)}):
                least = max(min(pair.gamma / pair.tau, *map(pair.proved, multipliers)) for pair in compared)
                assert true(certificate, claim(local, least, multipliers)), (seed, local)
                assert true(certificate, claim(local, least + TINY, multipliers))
                assert not true(certificate, claim(local, least - TINY, multipliers)), (seed, local)
            assert not true(certificate, claim(local, INF, best))


def test_no_policy_and_no_utility_of_the_range_exceeds_it() -> None:
    pick = random.Random(tiers.fresh(0))
    for seed in SEEDS:
        p = Policy(tiers.fresh(seed))
        declare(p, seed)
        p.T = {place: [pick.choice([0, 0, 1, 2]) for _ in row] for place, row in p.T.items()}
        p.T = {place: [Fraction(w, sum(row)) for w in row] if any(row) else [Fraction(1, p.n)] * p.n for place, row in p.T.items()}
        p.P, p.releases = p.induced(), 1
        gap = p.declared.get("lipschitz", p.own["lipschitz"])
        groups = range(len(p.true_a))
        for x in range(len(p.true_x)):
            gamma, m = (p.declared_in.get(x, {}).get(key, p.declared[key]) for key in ("gamma", "m"))
            for u in range(p.n):
                center = pick.choice([m, gamma, (m + gamma) / 2])
                for a in groups:
                    p.g[x, a][u] = min(gamma, max(m, center + pick.choice([-1, 0, 1]) * gap / 2))
        local = max(pair.least() for pair in ranged(p, True))
        assert all(ratio(p.mean(x, a), p.mean(x, b)) <= local for x in range(len(p.true_x)) for a, b in permutations(groups, 2)), seed


COINS = [
    ("2/3", "7/5", "3", "1", None),
    ("2/3", "2", "1", "0", None),
    ("2/3", "5/3", "3", "1", "1/2"),
    ("7/10", "73/37", "1", "1/10", None),
]


@pytest.mark.parametrize(("keep", "value", "gamma", "m", "gap"), COINS)
def test_a_coin(keep: str, value: str, gamma: str, m: str, gap: str | None) -> None:
    p = stated(coin(keep), [[["1/2", "1/2"], ["1/2", "1/2"]]], [gamma, m], mass={(0, 0): "1/3", (0, 1): "2/3"})
    p.declared = {"gamma": Fraction(gamma), "m": Fraction(m), **({"lipschitz": Fraction(gap)} if gap else {})}
    certificate = write(p)
    for local in (True, False):
        assert true(certificate, claim(local, Fraction(value)))
        assert not true(certificate, claim(local, Fraction(value) - TINY))


def test_a_coin_with_a_floor() -> None:
    """Rows (7/10, 3/10) and (3/10, 7/10), g from 0 to 1 and at least 1/2: 11/7 by k = 3/7."""
    p = stated(coin("7/10"), [[["1/2", "1/2"], ["1/2", "1/2"]]], ["1", "0"])
    p.declared = {"gamma": Fraction(1), "m": Fraction(0), "tau": Fraction(1, 2)}
    certificate = write(p)
    value = Fraction(11, 7)
    assert true(certificate, claim(True, value, ["3/7"])) and true(certificate, claim(True, value, [9, "3/7", 0]))
    assert not true(certificate, claim(True, value, [9, "3/8", "1/2"])) and not true(certificate, claim(True, value - TINY, ["3/7"]))
    assert true(certificate, claim(True, 2, [9])) and not true(certificate, claim(True, 2 - TINY, [9]))  # gamma/tau needs no multiplier
    p.declared["tau"] -= TINY
    assert not true(write(p), claim(True, value, ["3/7"]))
    with pytest.raises(checker.FormatError):
        true(certificate, claim(True, value, []))


def test_several_releases() -> None:
    """Two releases of a coin: rows (4, 2, 2, 1)/9 and (1, 2, 2, 4)/9; g from 1 to 3: (1 + 2·4/9)/(1 + 2·1/9)."""
    p = stated(coin("2/3"), [[["1/2", "1/2"], ["1/2", "1/2"]]], ["3", "1"], releases=2)
    p.declared = {"gamma": Fraction(3), "m": Fraction(1)}
    value = max(Fraction(17, 11), Fraction(25, 19))
    assert true(write(p), claim(True, value)) and not true(write(p), claim(True, value - TINY))
    p.releases = 3
    assert not true(write(p), claim(True, value))


def test_what_is_declared_of_a_context_takes_the_place_of_what_is_declared_of_all() -> None:
    """The coin (2/3, 1/3), g from 1 to 3: 7/5; from 2 to 3: (2 + 2/3)/(2 + 1/3). Means are over all contexts, whatever is said of one."""
    flat = [["1/2", "1/2"], ["1/2", "1/2"]]
    given = {(x, a): [["3", "2"], ["2", "2"]][x] for x in range(2) for a in range(2)}
    p = stated(coin("2/3"), [flat, flat], given, contexts=(["A"], ["B"]))
    p.declared = {"gamma": Fraction(3), "m": Fraction(1)}
    in_first = Fraction(8, 7)
    for own, value in (
        ({}, Fraction(7, 5)),
        ({0: {"m": Fraction(2)}}, Fraction(7, 5)),
        ({0: {"m": Fraction(2)}, 1: {"m": Fraction(2), "gamma": Fraction(2)}}, in_first),
    ):
        p.declared_in = own
        certificate = write(p)
        assert true(certificate, claim(True, value)) and not true(certificate, claim(True, value - TINY)), own
        assert true(certificate, claim(False, Fraction(7, 5))) and not true(certificate, claim(False, Fraction(7, 5) - TINY))


RANGE = (
    "every utility is between 1 and 3, and for the same decision and context the utilities of two groups differ by at most {} (declared)"
)
SAID = {
    "fresh": (
        "the filter's draws for group and context are independent of each other and of everything else, fresh for each decision, and the "
        "decision depends on group and context only through what the filters release"
    ),
    "population": "the contexts of each group are distributed as in the stated population",
    "range": RANGE.format("1/2"),
    "range of the table": RANGE.format("0"),
    "range in A": 'in context ["A"], every utility is between 3/2 and 3 (declared)',
    "range in B": 'in context ["B"], every utility is between 1 and 5/2 (declared)',
    "floor": "every compared group's expected utility is at least 1/3 behind the filter (declared)",
    "floor in A": 'in context ["A"], every compared group\'s expected utility is at least 1/5 behind the filter (declared)',
    "floor of means": "every compared group's mean utility is at least 1/7 behind the filter (declared)",
    "releases": "one memory sees at most 2 releases of a group, each drawn afresh (declared)",
}


@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("floored", [True, False])
@pytest.mark.parametrize("single", [True, False])
@pytest.mark.parametrize("releases", [1, 2])
def test_claims_list_what_was_declared_and_nothing_else(local: bool, floored: bool, single: bool, releases: int) -> None:
    flat = [["1/2", "1/2"], ["1/2", "1/2"]]
    p = stated(coin("2/3"), [flat, flat], ["5/2", "3/2"], contexts=(["A"], ["B"]), releases=releases)
    p.declared = {"gamma": Fraction(3), "m": Fraction(1), "tau": Fraction(1, 3), "global_tau": Fraction(1, 7)}
    needed = ["fresh", "range of the table"] + ["population"] * (not local) + ["releases"] * (releases > 1)
    needed += ["floor", "floor of means"] * floored
    if single:
        p.declared["lipschitz"] = Fraction(1, 2)
        p.declared_in = {0: {"m": Fraction(3, 2), "tau": Fraction(1, 5)}, 1: {"gamma": Fraction(5, 2)}}
        needed[1] = "range"
        needed += ["range in A", "range in B"] * local + ["floor in A"] * floored
    certificate = write(p)

    def with_assumptions(*names: str) -> bool:
        certificate["claims"] = [claim(local, 10, [0, 1, 2] if floored else None) | {"assumptions": [SAID[name] for name in names]}]
        return bool(checker.check(raw(certificate)).ok)

    assert with_assumptions(*needed)
    for name in SAID:
        with pytest.raises(checker.Incomplete if name in needed else checker.FormatError):
            with_assumptions(*({*needed} ^ {name}))
