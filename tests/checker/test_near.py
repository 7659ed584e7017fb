"""The greatest ratio over the policies near one, against dense tables of plain fractions and every extreme point.

All 400 random policies: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_near.py
"""

from __future__ import annotations

import random
from fractions import Fraction
from math import factorial
from typing import Any

import pytest
import tiers
from assumptions import complete
from plain_certificates import INF, checker, raw, text
from policy_certificates import TINY, Filter, Policy, coin, stated, write
from policy_suprema import Compared, compared, laws_of, near_by_enumeration, near_by_steps

NEAR = checker.claims.NEAR
SEEDS = range(0, 400, 1 if tiers.FULL else 5)
BLOCKS = 4


def place(p: Policy, case: Compared) -> dict[str, Any]:
    context = None if case.context is None else p.true_x[case.context]
    return {"context": context, "higher": p.true_a[case.higher], "lower": p.true_a[case.lower]}


def true(certificate: dict[str, Any], local: bool, value: Any, attained: Any) -> bool:
    """Whether the checker finds a certificate true that has one claim."""
    claim = {"quantity": f"{'local' if local else 'global'}_ratio_supremum", "relation": "=", "by": "T13", "scope": NEAR}
    certificate["claims"] = [claim | {"value": text(value), "assumptions": [], "evidence": {"attained": attained}}]
    return bool(checker.check(raw(complete(certificate))).ok)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_the_greatest_ratio_nearby_and_where_it_is_attained(block: int) -> None:
    for seed in SEEDS[block::BLOCKS]:
        p = Policy(tiers.fresh(seed))
        drift = random.Random(tiers.fresh(seed)).choice([Fraction(0), Fraction(1), *[Fraction(i, 12) for i in range(1, 9)]])
        p.declared = {"max_drift": drift}
        certificate, laws = write(p), laws_of(p)
        for local in (True, False):
            if p.releases > 1:
                assert not true(certificate, local, 10**9, place(p, compared(p, True)[0])) and not true(certificate, local, 1, None)
                continue
            values = {case: near_by_steps(case, laws, drift) for case in compared(p, local)}
            if not values:
                continue
            for case, value in values.items():
                assert factorial(p.n) ** len(laws) > 300 or near_by_enumeration(case, laws, drift) == value, seed
            greatest = max(values.values())
            assert true(certificate, local, greatest, None) == (greatest == 1)
            for case, value in values.items():
                attains = value == greatest != 1
                assert true(certificate, local, greatest, place(p, case)) == attains, (seed, case)
                if attains and greatest != INF:
                    assert not true(certificate, local, greatest + TINY, place(p, case))
                    assert not true(certificate, local, greatest - TINY, place(p, case))
                assert value == greatest or not true(certificate, local, value, place(p, case))


def example() -> Policy:
    return stated(coin("3/4"), [[["1/2", "1/4", "1/4"], ["1/4", "1/4", "1/2"]]], ["4", "2", "1"])


@pytest.mark.parametrize(("drift", "value"), [("0", "41/35"), ("1/20", "211/169"), ("1", "13/7")])
def test_a_policy_that_may_drift(drift: str, value: str) -> None:
    """Means 11/4 and 2 under the two values, which mass 1/20 changes by 3/20: (3·29/10 + 37/20)/(29/10 + 3·37/20)."""
    p = example()
    p.declared = {"max_drift": Fraction(drift)}
    certificate = write(p)
    [up, down] = [{"context": ["A"], "higher": [a], "lower": [b]} for a, b in ("fm", "mf")]
    assert true(certificate, True, Fraction(value), up)
    assert not true(certificate, True, Fraction(value), down) or drift == "1"
    assert not true(certificate, True, Fraction(value) - TINY, up) and not true(certificate, True, Fraction(value) + TINY, up)
    assert not true(certificate, True, Fraction(value), None) and not true(certificate, True, INF, up)


def test_without_a_drift_nothing_is_claimed_and_it_is_at_most_1() -> None:
    p = example()
    up = {"context": ["A"], "higher": ["f"], "lower": ["m"]}
    assert not true(write(p), True, Fraction(13, 7), up)
    p.declared = {"max_drift": 1 + TINY}
    with pytest.raises(checker.FormatError):
        true(write(p), True, Fraction(13, 7), up)


def test_what_is_behind_a_context_filter_is_seen_through_it() -> None:
    """One context is shown as either value with probability 1/2. Where the policy knows the group it hires, and elsewhere it does not."""
    group = Filter([([["f"], ["m"]], [["f"], ["m"]], [[Fraction(1), Fraction(0)], [Fraction(0), Fraction(1)]])])
    half = Fraction(1, 2)
    context = Filter([([["A"]], [["A"], ["B"]], [[half, half]])])
    p = stated(group, [[["1", "0"], ["1", "0"]], [["0", "1"], ["0", "1"]]], ["1", "0"], context=context)
    # Mass 1/4 may move under each value: f gets between 3/8 and 5/8, as m does.
    p.declared = {"max_drift": Fraction(1, 4)}
    up = {"context": ["A"], "higher": ["f"], "lower": ["m"]}
    assert true(write(p), True, Fraction(5, 3), up) and not true(write(p), True, Fraction(5, 3) - TINY, up)
    p.declared = {"max_drift": Fraction(1)}
    assert true(write(p), True, INF, up)


def test_claims_list_the_drift() -> None:
    p = example()
    p.declared = {"max_drift": Fraction(1, 20), "tau": Fraction(1), "gamma": Fraction(4)}
    certificate = write(p)
    sentence = (
        "for everything that the filters release, the law of the decision is within total variation {} of the law of this policy (declared)"
    )
    up = {"context": ["A"], "higher": ["f"], "lower": ["m"]}
    assert true(certificate, True, Fraction(211, 169), up)
    [claim] = certificate["claims"]
    fresh, drift = claim["assumptions"]
    assert drift == sentence.format("1/20")
    for wrong, error in (
        ([fresh], checker.Incomplete),
        ([drift], checker.Incomplete),
        ([fresh, sentence.format("1/21")], checker.Incomplete),
    ):
        claim["assumptions"] = wrong
        with pytest.raises(error):
            checker.check(raw(certificate))
