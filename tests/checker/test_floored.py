"""The greatest ratio over the policies that keep floors, against exact linear programs.

All 400 random policies: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_floored.py
"""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest
import tiers
from assumptions import complete
from plain_certificates import INF, checker, raw, text
from policy_certificates import FLOORED, TINY, Filter, Policy, coin, stated, write
from policy_floors import floors, greatest, priced, prices, witness
from policy_suprema import Compared, by_steps, compared, declare, floor_in, mean_floor

SEEDS = range(0, 400, 1 if tiers.FULL else 8)
LARGEST = 60 if tiers.FULL else 16  # cells of a policy, for linear programs
BLOCKS = 4


def claim(local: bool, relation: str, value: Any, multipliers: Any = (), pairs: Any = (), policy: Any = None) -> dict[str, Any]:
    quantity = f"{'local' if local else 'global'}_ratio_supremum"
    evidence = {"multipliers": [str(k) for k in multipliers], "pairs": [*pairs], "policy": policy}
    return {"quantity": quantity, "relation": relation, "by": "T13", "scope": FLOORED, "value": text(value), "evidence": evidence}


def true(certificate: dict[str, Any], one: dict[str, Any]) -> bool:
    """Whether the checker finds a certificate true that has one claim."""
    certificate["claims"] = [{"assumptions": [], **one}]
    return bool(checker.check(raw(complete(certificate))).ok)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_the_greatest_ratio_with_floors_and_a_policy_that_attains_it(block: int) -> None:
    for seed in SEEDS[block::BLOCKS]:
        p = Policy(tiers.fresh(seed))
        if len(p.must) * p.n > LARGEST:
            continue
        declare(p, seed)
        p.releases = 1
        certificate, kept = write(p), floors(p)
        for local in (True, False):
            found = {case: greatest(case, kept) for case in compared(p, local)}
            if not found:
                continue
            value = max(v for v, _ in found.values())
            attaining = [case for case, (v, _) in found.items() if v == value]
            w = None if value == 1 else witness(p, attaining[0], found[attaining[0]][1])
            if not kept:
                assert not true(certificate, claim(local, "=", value, [1, 2, 3], [], w))
                continue
            if value == INF:
                assert true(certificate, claim(local, "=", INF, [], [], w))
                assert not true(certificate, claim(local, "<=", INF)) and not true(certificate, claim(local, "<=", 10**30))
                continue
            pairs = [priced(p, case, kept, prices(case, kept, value)) for case in found]
            assert true(certificate, claim(local, "=", value, [], pairs, w)), (seed, local)
            assert true(certificate, claim(local, "<=", value, [], pairs)) and true(
                certificate, claim(local, "<=", value + TINY, [], pairs)
            )
            for less in (value - TINY, value + TINY):
                assert not true(certificate, claim(local, "=", less, [], pairs, w)), (seed, local)
            assert not true(certificate, claim(local, "<=", value - TINY, [], pairs))
            # Nor does any other evidence prove less, and no policy that is best for another pair attains as much.
            if value > 1:
                others = [priced(p, case, kept, prices(case, kept, value - TINY)) for case in found]
                assert not true(certificate, claim(local, "<=", value - TINY, list(range(9)), others))
            for case, (v, policy) in found.items():
                assert v == value or not true(certificate, claim(local, "=", value, [], pairs, witness(p, case, policy)))


@pytest.mark.parametrize("block", range(BLOCKS))
def test_a_multiplier_is_enough_where_one_floor_is(block: int) -> None:
    """S(k) <= (V - k) τ* over dense tables, of several releases too."""
    pick = random.Random(tiers.fresh(block))

    def excess(case: Compared, k: Fraction) -> Fraction:
        return sum((max(x - k * y for x, y in zip(p, q, strict=True)) for p, q in zip(case.p, case.q, strict=True)), Fraction(0))

    for seed in SEEDS[block::BLOCKS]:
        p = Policy(tiers.fresh(seed))
        declare(p, seed)
        certificate = write(p)
        for local in (True, False):
            cases = compared(p, local)
            if not cases or not floors_declared(p):
                continue
            for multipliers in ([Fraction(pick.randint(0, 12), 4) for _ in range(4)], []):
                # Of one k the least V is k + S(k)/τ*, or where there is no floor, or k is V, what S says without one.
                least: Any = Fraction(1)
                for case in cases:
                    tau = floor_in(p, case.context) if case.context is not None else mean_floor(p, case.lower)
                    values = [max(k, k + excess(case, k) / tau) for k in multipliers if tau]
                    values += [v for v in [by_steps(case)] if v != INF]
                    least = max(least, min(values, default=INF))
                if least == INF:
                    assert not true(certificate, claim(local, "<=", 10**9, multipliers)), seed
                    continue
                assert true(certificate, claim(local, "<=", least, multipliers)), seed
                assert true(certificate, claim(local, "<=", least + TINY, multipliers))
                assert not true(certificate, claim(local, "<=", least - TINY, multipliers)), seed


def floors_declared(p: Policy) -> bool:
    return any(floor_in(p, x) for x in range(len(p.true_x))) or bool(p.declared.get("global_tau"))


HALF = ["1/2", "1/2"]


def first() -> Policy:
    """Rows (7/10, 3/10) and (3/10, 7/10), one good decision, and a floor of 1/2."""
    p = stated(coin("7/10"), [[HALF, HALF]], ["1", "0"])
    p.declared = {"tau": Fraction(1, 2)}
    return p


UP = {"context": ["A"], "higher": ["f"], "lower": ["m"]}
DOWN = {"context": ["A"], "higher": ["m"], "lower": ["f"]}
BY = {"attained": UP, "rows": [[["1", "0"], ["2/7", "5/7"]]]}  # 7/10 + 3/10·2/7 = 11/14, and 3/10 + 7/10·2/7 = 1/2
ELEVEN = Fraction(11, 7)


def test_one_floor() -> None:
    """The example of the theory page: 11/7, by 8/7 on the floor of the lower group, or by k = 11/7 - 8/7."""
    certificate = write(first())
    pairs = [UP | {"floors": [[0, 1, "8/7"]]}, DOWN | {"floors": [[0, 0, "8/7"]]}]
    for evidence in (([], pairs), (["3/7"], []), (["3/7", "9", "0"], [])):
        assert true(certificate, claim(True, "=", ELEVEN, *evidence, BY)) and true(certificate, claim(True, "<=", ELEVEN, *evidence))
        assert true(certificate, claim(True, "<=", 2, *evidence)) and not true(certificate, claim(True, "<=", ELEVEN - TINY, *evidence))
        assert not true(certificate, claim(True, "=", ELEVEN, *evidence)) and not true(
            certificate, claim(True, "<=", ELEVEN, *evidence, BY)
        )
    assert not true(certificate, claim(True, "<=", ELEVEN)) and not true(certificate, claim(True, "<=", ELEVEN, [], pairs[:1]))
    assert not true(certificate, claim(True, "<=", ELEVEN, ["4/7"], []))
    assert true(certificate, claim(False, "<=", ELEVEN, ["3/7"]))  # the means of one context keep its floor


def test_what_is_wrong_with_entries() -> None:
    certificate = write(first())
    good = [[0, 1, "8/7"]], [[0, 0, "8/7"]]

    def with_floors(*floors: Any, **change: Any) -> bool:
        return true(certificate, claim(True, "<=", ELEVEN, [], [UP | {"floors": floors[0]} | change, DOWN | {"floors": floors[1]}]))

    assert with_floors(*good) and with_floors([[0, 1, "4/7"], [0, 1, "4/7"]], good[1])
    assert with_floors([[0, 1, "8/7"], [0, 0, "1/9"]], good[1]) is False
    for bad in ([[0, 0, "8/7"]], [[0, 1, "7/8"]], [[0, 1, "9/7"]], [], [[1, 1, "8/7"]], [[0, 2, "8/7"]], [[None, 1, "8/7"]]):
        assert not with_floors(bad, good[1]), bad
    assert not with_floors(*good, context=["B"]) and not with_floors(*good, context=None) and not with_floors(*good, higher=["m"])
    assert not with_floors(*good, lower=["x"]) and not with_floors(*good, higher=["m"], lower=["f"])
    for bad in (
        [[0, 1, "0"]],
        [[0, 1, "-8/7"]],
        [[0, 1, 1]],
        [[-1, 1, "8/7"]],
        [["0", 1, "8/7"]],
        [[0, None, "8/7"]],
        [[0, 1]],
        [[0, 1, "inf"]],
    ):
        with pytest.raises((checker.FormatError, ValueError)):
            with_floors(bad, good[1])
    for key in ("multipliers", "pairs", "policy"):
        one = claim(True, "<=", ELEVEN, ["3/7"])
        del one["evidence"][key]
        with pytest.raises(checker.FormatError):
            true(certificate, one)


def test_what_is_wrong_with_a_policy() -> None:
    certificate = write(first())

    def with_rows(rows: Any, attained: Any = UP, value: Any = ELEVEN) -> bool:
        return true(certificate, claim(True, "=", value, ["3/7"], [], {"attained": attained, "rows": rows}))

    assert with_rows(BY["rows"])
    assert with_rows([[["2/7", "5/7"], ["1", "0"]]], DOWN)  # which has the ratio where the other group is the higher one
    for rows in (
        [[["1", "0"], ["1/7", "6/7"]]],  # less than the floor
        [[["1", "0"], ["3/7", "4/7"]]],  # less than the value
        [[["1", "0"], ["2/7", "4/7"]]],
        [[["1", "0"], ["2/7", "6/7"]]],
        [[["2/7", "5/7"], ["1", "0"]]],
        [[["1", "0"]]],
        [[["1", "0"], ["2/7", "5/7"], ["1", "0"]]],
        [[["1", "0"], ["2/7", "5/7"]]] * 2,
        [[["1", "0"], ["2/7", "5/7", "0"]]],
        [],
    ):
        assert not with_rows(rows), rows
    assert (
        not with_rows(BY["rows"], DOWN)
        and not with_rows(BY["rows"], UP | {"context": None})
        and not with_rows(BY["rows"], UP | {"lower": ["x"]})
    )
    for rows in ([[["1", "0"], ["9/7", "-2/7"]]], [[["1", "0"], ["4/14", "5/7"]]], [["1", "0"]], [[["1", "0"], [1, 0]]]):
        with pytest.raises(checker.FormatError):
            with_rows(rows)
    with pytest.raises(checker.FormatError):
        with_rows(BY["rows"], None)


def test_floors_and_policies_are_those_of_one_release() -> None:
    """Of two releases neither prices of floors nor a policy that attains a value can be written down."""
    p = first()
    pairs = [UP | {"floors": [[0, 1, "8/7"]]}, DOWN | {"floors": [[0, 0, "8/7"]]}]
    assert true(write(p), claim(True, "<=", ELEVEN, [], pairs))
    p.releases = 2
    assert not true(write(p), claim(True, "<=", ELEVEN, [], pairs)) and not true(write(p), claim(True, "=", ELEVEN, ["3/7"], [], BY))
    p = in_two_contexts(coin(1), "1/4")
    nobody = {"attained": UP, "rows": [[["1", "0"], ["0", "1"]], [["1", "0"], ["1", "0"]]]}
    assert true(write(p), claim(True, "=", INF, [], [], nobody))
    p.releases = 2
    assert not true(write(p), claim(True, "=", INF, [], [], nobody))


def in_two_contexts(group: Filter, of_means: str) -> Policy:
    """One good decision in two contexts, and a floor of the means."""
    p = stated(group, [[HALF, HALF], [HALF, HALF]], ["1", "0"], contexts=(["A"], ["B"]))
    p.declared = {"global_tau": Fraction(of_means)}
    return p


def test_a_policy_keeps_the_floor_of_means() -> None:
    """In the second context one group gets everything, and the other nothing or more: their means are 1/2 or more."""
    p = in_two_contexts(coin(1), "1/2")
    certificate = write(p)
    place_of = {"context": ["A"], "higher": ["f"], "lower": ["m"]}
    for b, keeps in (("1", True), ("0", False)):
        rows = [[["1", "0"], ["0", "1"]], [["1", "0"], [b, str(1 - int(b))]]]
        assert true(certificate, claim(True, "=", INF, [], [], {"attained": place_of, "rows": rows})) is keeps


def test_contexts_with_like_utilities_have_their_own_floors() -> None:
    """Utilities are twice as great in the second context: as much is a floor of 1/2 in the first one as 1 in the second one."""
    given = {(x, a): [["1", "0"], ["2", "0"]][x] for x in range(2) for a in range(2)}
    p = stated(coin("7/10"), [[HALF, HALF], [HALF, HALF]], given, contexts=(["A"], ["B"]))
    for second, holds in (("1", True), ("99/100", False), ("1/2", False)):
        p.declared_in = {0: {"tau": Fraction(1, 2)}, 1: {"tau": Fraction(second)}}
        assert true(write(p), claim(True, "<=", ELEVEN, ["3/7"])) is holds
    p.declared_in = {0: {"tau": Fraction(1, 2)}, 1: {"tau": Fraction(1, 2)}}  # where 7/3 holds of all policies, and is attained
    assert true(write(p), claim(True, "<=", Fraction(7, 3), ["3/7"])) and not true(
        write(p), claim(True, "<=", Fraction(7, 3) - TINY, ["3/7"])
    )


def test_floors_of_contexts_that_are_shown_alike() -> None:
    """What is good in one context is bad in the other: both floors of 2/5 together give 3/2, by 3/2 and 1; one of them 13/7, by k = 3/7."""
    context = Filter([([["A"], ["B"]], [["C"]], [[Fraction(1)], [Fraction(1)]])])
    p = stated(coin("7/10"), [[HALF, HALF]], {(x, a): [["1", "0"], ["0", "1"]][x] for x in range(2) for a in range(2)}, context=context)
    p.declared = {"tau": Fraction(2, 5)}
    places = [{"context": [x], "higher": [a], "lower": [b]} for x in "AB" for a, b in ("fm", "mf")]
    floors_of = [[[x, 1 - a, "3/2"], [1 - x, a, "1"]] for x in range(2) for a in range(2)]
    pairs = [at | {"floors": of} for at, of in zip(places, floors_of, strict=True)]
    # 3/5 = 7/10·r + 3/10·s and 2/5 = 3/10·r + 7/10·s
    policy = {"attained": places[0], "rows": [[["3/4", "1/4"], ["1/4", "3/4"]]]}
    value = Fraction(3, 2)
    assert true(write(p), claim(True, "=", value, [], pairs, policy))
    assert not true(write(p), claim(True, "<=", value - TINY, [], pairs))
    assert true(write(p), claim(True, "<=", Fraction(13, 7), ["3/7"]))
    assert not true(write(p), claim(True, "<=", Fraction(13, 7) - TINY, [Fraction(i, 14) for i in range(41)]))
    alone = [at | {"floors": of[:1]} for at, of in zip(places, floors_of, strict=True)]
    assert not true(write(p), claim(True, "<=", value, [], alone))
    p.declared_in = {1: {"tau": Fraction(2, 5)}}
    del p.declared["tau"]
    assert not true(write(p), claim(True, "<=", value, [], pairs))
    p.declared_in[0] = {"tau": Fraction(2, 5)}
    p.declared_in = dict(sorted(p.declared_in.items()))
    assert true(write(p), claim(True, "=", value, [], pairs, policy))
    p.declared["tau"] = Fraction(1, 2)
    certificate = write(p)
    assert true(certificate, claim(True, "<=", 1, [], [pair | {"floors": [[x, a, "1"] for x, a, _ in pair["floors"]]} for pair in pairs]))


def test_a_floor_of_a_context_that_is_not_compared_costs_what_it_gives() -> None:
    """What is shown in the other context counts in the sum, too: any y on its floors leaves at least as much as they add."""
    p = stated(coin("7/10"), [[HALF, HALF], [HALF, HALF]], ["1", "0"], contexts=(["A"], ["B"]))
    p.declared = {"tau": Fraction(1, 2)}
    certificate = write(p)
    own = [
        {"context": [x], "higher": [a], "lower": [b], "floors": [[i, j, "8/7"]]}
        for i, x in enumerate("AB")
        for j, (a, b) in enumerate(["mf", "fm"])
    ]
    assert true(certificate, claim(True, "<=", ELEVEN, [], own))
    for y in ("1/1000", "8/7", "1000000"):
        others = [pair | {"floors": [*pair["floors"], [1 - pair["floors"][0][0], 0, y]]} for pair in own]
        assert not true(certificate, claim(True, "<=", ELEVEN - TINY, [], others)), y
        assert not true(certificate, claim(True, "<=", 1, [], others)), y


def test_a_floor_of_means_is_enough() -> None:
    """Nothing is known of either context, and a mean of 1/2 over both of them lets 11/7 happen where they are shown alike."""
    certificate = write(in_two_contexts(coin("7/10"), "1/2"))
    place_of = {"context": None, "higher": ["f"], "lower": ["m"]}
    policy = {"attained": place_of, "rows": BY["rows"] * 2}
    pairs = [place_of | {"floors": [[None, 1, "8/7"]]}, place_of | {"higher": ["m"], "lower": ["f"], "floors": [[None, 0, "8/7"]]}]
    assert true(certificate, claim(False, "=", ELEVEN, [], pairs, policy)) and true(
        certificate, claim(False, "=", ELEVEN, ["3/7"], [], policy)
    )
    assert not true(certificate, claim(False, "<=", ELEVEN - TINY, ["3/7"], pairs))
    # Locally it says nothing: in one context nobody need get anything.
    one = {"attained": UP, "rows": [[["1", "0"], ["0", "1"]], [["1", "0"], ["1", "0"]]]}
    assert true(certificate, claim(True, "=", Fraction(7, 3), [], [], one)) and not true(certificate, claim(True, "=", INF, [], [], one))
    assert not true(certificate, claim(True, "<=", Fraction(7, 3) - TINY, ["3/7", "1"], [pair | UP for pair in pairs[:1]]))


def test_claims_list_the_floors() -> None:
    p = first()
    p.declared = {"tau": Fraction(1, 2), "global_tau": Fraction(1, 3), "gamma": Fraction(2)}
    p.declared_in = {0: {"tau": Fraction(2, 5)}}
    one = claim(False, "<=", 10, ["3/7"])
    certificate = write(p)
    assert true(certificate, one)
    [listed] = [c["assumptions"] for c in certificate["claims"]]
    assert listed[1:] == [
        "the contexts of each group are distributed as in the stated population",
        "every compared group's expected utility is at least 1/2 behind the filter (declared)",
        'in context ["A"], every compared group\'s expected utility is at least 2/5 behind the filter (declared)',
        "every compared group's mean utility is at least 1/3 behind the filter (declared)",
    ]
    for i in range(len(listed)):
        certificate["claims"] = [one | {"assumptions": listed[:i] + listed[i + 1 :]}]
        with pytest.raises(checker.Incomplete):
            checker.check(raw(certificate))
    certificate["claims"] = [
        one | {"assumptions": [*listed, "one memory sees at most 2 releases of a group, each drawn afresh (declared)"]}
    ]
    with pytest.raises(checker.FormatError):
        checker.check(raw(certificate))
