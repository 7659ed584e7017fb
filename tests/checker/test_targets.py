"""Verdicts and claims about the population behind a sample."""

import copy
import json
from typing import Any

import pytest
from assumptions import complete
from interval_certificates import COUNTS, TINY, F, accepted, both_intervals, claims, rejected, rows_of
from mpmath import mp
from plain_certificates import checker, false_statements, make, raw
from policy_certificates import FLOORED, POLICIES, SCHEMA, Policy, coin, digested, write
from policy_certificates import by_hand as policy_by_hand
from policy_certificates import stated as policy_stated

import fairaudit as fa

ANY_UTILITY, ANY_UTILITY_FLOORED = checker.claims.ANY_UTILITY, checker.claims.ANY_UTILITY_FLOORED


@pytest.fixture
def good() -> Any:
    return both_intervals()


def target(quantity: str, unit: str, limit: Any, verdict: str, judged: str = "9/10") -> dict[str, Any]:
    return {"quantity": quantity, "limit": str(limit), "unit": unit, "judged": f"population at confidence {judged}", "verdict": verdict}


def judged(certificate: Any, *targets: dict[str, Any]) -> Any:
    certificate = copy.deepcopy(certificate)
    certificate["targets"] = [*targets]
    verdicts = {t["verdict"] for t in targets}
    certificate["verdict"] = next(v for v in ("exceeds", "inconclusive", "within", "none") if v in verdicts or v == "none")
    return certificate


def test_verdicts_about_the_population(good: Any) -> None:
    low, high = map(F, good["intervals"]["local"]["ratio"])
    assert 1 < low < 4 < high
    mp.dps = 50
    log_low, log_high = (F(int(mp.log(mp.mpf(v.numerator) / v.denominator) * 10**30), 10**30) for v in (low, high))
    for unit, least, most, rounded in (("ratio", low, high, F(0)), ("log", log_low, log_high, F(1, 10**30))):
        for limit, verdict in (
            (least - TINY, "exceeds"),
            (least + rounded, "inconclusive"),
            (most - TINY, "inconclusive"),
            (most + rounded, "within"),
        ):
            for stated in ("within", "exceeds", "inconclusive"):
                certificate = judged(good, target("local", unit, limit, stated))
                assert accepted(certificate) is (stated == verdict), (unit, limit, stated)
                certificate["verdict"] = "within" if stated != "within" else "inconclusive"
                assert rejected(certificate)
    # The table's own figure is judged beside it, but not twice in one unit.
    own = {"quantity": "local", "limit": "4", "unit": "log", "judged": "this table", "verdict": "within"}
    assert accepted(judged(good, target("local", "ratio", high, "within"), own))
    assert rejected(judged(good, target("local", "log", high, "within"), own))


def test_verdicts_hold_together(good: Any) -> None:
    both = target("local", "ratio", 10**6, "within"), target("global", "ratio", 10**6, "within")
    assert rejected(judged(good, *both))  # each at 9/10: together at 8/10
    together = [t | {"judged": "population at confidence 4/5"} for t in both]
    assert accepted(judged(good, *together))
    assert rejected(judged(good, *[t | {"judged": "population at confidence 81/100"} for t in both]))
    assert rejected(judged(good, together[0], both[1]))
    assert accepted(judged(good, both[0], target("local", "log", 100, "within")))  # one interval, two limits
    assert rejected(judged(good, both[0] | {"judged": "population at confidence 91/100"}))
    assert accepted(judged(good, both[0] | {"judged": "population at confidence 1/100"}))
    for other in ("population", "the population at confidence 9/10", "population at confidence 9/10 ", "population at confidence 0.9"):
        assert rejected(judged(good, both[0] | {"judged": other}))
    for confidence in ("0", "1", "18/20", "11/10", "-1/2", "inf", ""):
        assert rejected(judged(good, both[0] | {"judged": f"population at confidence {confidence}"}))


def test_ends_by_themselves_have_an_error_for_each_target() -> None:
    """Each verdict rests on one end: two limits on one quantity are two targets."""
    apart = both_intervals("each")
    one, other = target("local", "ratio", 10**6, "within"), target("local", "log", 100, "within")
    assert accepted(judged(apart, one))
    assert rejected(judged(apart, one | {"judged": "population at confidence 91/100"}))
    assert rejected(judged(apart, one, other))
    for pair in ((one, other), (one, target("global", "ratio", 10**6, "within"))):
        assert accepted(judged(apart, *[t | {"judged": "population at confidence 4/5"} for t in pair]))
        assert rejected(judged(apart, *[t | {"judged": "population at confidence 81/100"} for t in pair]))
    three = [t | {"judged": "population at confidence 7/10"} for t in (one, other, target("global", "ratio", 10**6, "within"))]
    assert accepted(judged(apart, *three))
    assert rejected(judged(apart, *[t | {"judged": "population at confidence 71/100"} for t in three]))
    mixed = both_intervals()
    mixed["intervals"]["local"] = apart["intervals"]["local"]
    mixed["claims"] = [c for c in mixed["claims"] if (c["quantity"], c["by"]) != ("local_ratio", "binomial")]
    mixed["claims"] += claims("local", apart["intervals"]["local"], "binomial")
    assert accepted(judged(complete(mixed), *three))
    assert rejected(judged(complete(mixed), one | {"judged": "population, one-sided at confidence 9/10"}))


@pytest.mark.parametrize(("ends", "other"), [("each", "together"), ("together", "each")])
def test_ends_are_claimed_as_they_hold(ends: str, other: str) -> None:
    """The scope is that of the interval; levels of ends by themselves are more than ends that hold together may have."""
    openings = {"each": "population, one-sided at confidence ", "together": "population at confidence "}
    certificate = both_intervals(ends)
    assert accepted(certificate)
    for i in (-1, -2):
        false = copy.deepcopy(certificate)
        false["claims"][i]["scope"] = f"{openings[other]}9/10"
        assert rejected(false)
    false = copy.deepcopy(certificate)
    for claim in false["claims"]:
        if claim["by"] == "binomial":
            claim["scope"] = f"{openings[other]}9/10"
    assert rejected(false)
    for interval in false["intervals"].values():
        interval["ends"] = other
    # What holds together holds each by itself, but for the statement itself.
    assert accepted(false) is (ends == "together")


def test_where_the_ends_cross_nothing_is_decided() -> None:
    """An upper end below the lower one follows from no draws here, but from bounds beside them: the rule is asked directly."""
    crossing = (4, 3), (6, 5)
    for limit, verdict in ((F(5, 4), "inconclusive"), (F(11, 10), "exceeds"), (F(7, 5), "within")):
        stated = checker.certificate.Target("local", (limit.numerator, limit.denominator), "ratio", "", F(9, 10), verdict, False)
        assert checker.targets._judge(stated, crossing) == verdict


def test_without_an_interval_nothing_is_known(good: Any) -> None:
    del good["intervals"]["global"]
    good["claims"] = [c for c in good["claims"] if c["quantity"] != "global_ratio" or c["scope"] == "this law"]
    assert accepted(judged(good, target("global", "ratio", 10**6, "inconclusive", "99/100")))
    assert rejected(judged(good, target("global", "ratio", 10**6, "within", "99/100")))
    probabilities = make({c: ["1/2", "1/2"] for c in COUNTS}, ["1", "0"], population="equal")
    assert accepted(probabilities)
    assert rejected(judged(probabilities, target("local", "ratio", 2, "inconclusive")))
    probabilities["intervals"] = good["intervals"]
    with pytest.raises(checker.FormatError):
        checker.check(raw(probabilities))
    assert not SCHEMA.is_valid(probabilities)


@pytest.mark.parametrize(
    ("at", "change"),
    [
        (-1, {"value": "1"}),
        (-2, {"value": "1000"}),
        (-2, {"value": "inf"}),
        (-2, {"value": "1/2"}),
        (-1, {"by": "hoeffding-kl"}),
        (-1, {"by": "T2"}),
        (-1, {"relation": "="}),
        (-1, {"relation": ">="}),
        (-1, {"quantity": "local_ratio"}),
        (-1, {"quantity": "equalized_odds"}),
        (-1, {"scope": "population at confidence 19/20"}),
        (-1, {"scope": "population at confidence 18/20"}),
        (-1, {"scope": "population"}),
        (-1, {"scope": "this law"}),
        (-1, {"evidence": {"interval": "local"}}),
        (-1, {"evidence": {"interval": "other"}}),
        (-1, {"evidence": {"interval": None}}),
        (-1, {"evidence": {}}),
        (-1, {"evidence": {"interval": "global", "table": "0" * 64}}),
    ],
)
def test_false_claims(good: Any, at: int, change: dict[str, Any]) -> None:
    assert accepted(good)
    good["claims"][at] |= change
    assert rejected(good)


def test_claims(good: Any) -> None:
    low, high = map(F, good["intervals"]["local"]["ratio"])
    own = claims("local", good["intervals"]["local"], "binomial")
    certificate = copy.deepcopy(good)
    others = certificate["claims"] = [*certificate["claims"][:-4], *certificate["claims"][-2:]]
    for claim, bound, away in ((own[0], low, -1), (own[1], high, 1)):
        for value, true in ((bound, True), (bound + away * TINY, True), (bound - away * TINY, False)):
            certificate["claims"].append(claim | {"value": str(value)})
            assert accepted(certificate) is true
            certificate["claims"].pop()
    for extra in (own[1] | {"value": "inf"}, own[0] | {"value": "1"}):
        certificate["claims"] = [*others, extra]
        assert accepted(certificate)
    certificate["claims"] += [extra]
    assert "occurs twice" in "".join(false_statements(certificate))
    del certificate["intervals"]["local"]
    assert "no interval" in "".join(false_statements(certificate))
    good["intervals"]["local"]["ratio"][1] = str(high - TINY)
    assert any("no interval" in line for line in false_statements(good) if line.startswith("claims"))


def test_declared_constants_bound_a_policy_that_was_sampled() -> None:
    """e^eps is 2; nothing is known of the policy but that it stands behind its filter."""
    for draws in (None, 4):
        certificate = policy_by_hand()
        if draws:
            for row in rows_of(certificate)[1]:
                row["draws"] = draws
            digested(certificate)
        for limit, verdict in (("2", "within"), ("199/100", "inconclusive")):
            assert accepted(judged(certificate, target("local", "ratio", limit, verdict, "999/1000"))), draws
            assert accepted(judged(certificate, target("global", "ratio", limit, verdict, "999/1000")))
        certificate["claims"] = [c for c in certificate["claims"] if c["by"] not in ("T2", "T5", "T5-decision")]
        # T3, T12 and the floor of this law are about this policy; those of the declared floor need gamma declared, too.
        for limit in ("2", "4", "1000000"):
            assert accepted(judged(certificate, target("local", "ratio", limit, "inconclusive", "1/2")))
            assert accepted(judged(certificate, target("global", "ratio", limit, "inconclusive", "1/2")))
        certificate["subject"]["declared"]["gamma"] = "1"
        floored = min(F(c["value"]) for c in certificate["claims"] if c["scope"] == FLOORED)
        assert floored == 2
        assert accepted(judged(certificate, target("local", "ratio", 2, "within", "1/2")))
        assert accepted(judged(certificate, target("local", "ratio", "199/100", "inconclusive", "1/2")))


def test_t4_counts_with_declared_constants_only() -> None:
    pick = next(p for p in map(Policy, range(400)) if p.L == 0 and p.own["m"] > 0 and not p.declared and p.own["gamma"] > p.own["m"])
    certificate = write(pick)
    value = next(c["value"] for c in certificate["claims"] if c["by"] == "T4")
    certificate["claims"] = [c for c in certificate["claims"] if c["by"] not in ("T2", "T5", "T5-decision")]
    stated = judged(certificate, target("local", "ratio", value, "within"))
    constants = {key: str(pick.own[key]) for key in ("gamma", "m")}
    for declared in ({}, {"gamma": constants["gamma"]}, {"m": constants["m"]}):
        stated["subject"]["declared"] = declared
        assert rejected(stated)
    stated["subject"]["declared"] = constants
    assert accepted(stated)
    stated["claims"] = [c for c in stated["claims"] if c["by"] != "T4"]
    assert rejected(stated)
    stated["claims"].append({"quantity": "local_ratio", "relation": "<=", "value": value, "scope": POLICIES, "by": "T4", "assumptions": []})
    stated["claims"][-1]["evidence"] = {"multipliers": ["1000000"]}  # proves less
    assert rejected(stated)


@pytest.mark.parametrize(
    ("by_group", "gap", "floor", "value", "counts"),
    [
        (False, None, None, "7/5", True),
        (False, "1/2", None, "5/3", True),
        (True, "1/2", None, "5/3", True),
        (True, None, None, "5/3", False),  # that groups differ by so much is known of this table only
        (False, None, "2", "5/4", True),
        (True, None, "7/4", "3/2", False),
        (True, "1/2", "7/4", "3/2", True),
    ],
)
def test_ranges_count_with_declared_constants_only(by_group: bool, gap: Any, floor: Any, value: str, counts: bool) -> None:
    """The coin (2/3, 1/3), g from 1 to 3 and perhaps 1/2 apart; with a floor of 2, 7/6 + k/6 is proved by k from 1/2, else 3/2 - k/2."""
    given = {(0, 0): ["3", "1"], (0, 1): ["5/2", "1"]} if by_group else ["3", "1"]
    p = policy_stated(coin("2/3"), [[["1/2", "1/2"], ["1/2", "1/2"]]], given)
    p.declared = {"gamma": F(3), "m": F(1)} | ({"lipschitz": F(gap)} if gap else {}) | ({"tau": F(floor)} if floor else {})
    certificate = write(p)
    scope, evidence = (ANY_UTILITY_FLOORED, {"multipliers": ["1/2"]}) if floor else (ANY_UTILITY, {})
    claim = {
        "quantity": "local_ratio",
        "relation": "<=",
        "value": value,
        "scope": scope,
        "by": "T13",
        "assumptions": [],
        "evidence": evidence,
    }
    certificate["claims"] = [claim]

    def holds(*stated: Any) -> bool:
        return not false_statements(judged(certificate, target(*stated)))

    assert holds("local", "ratio", value, "within") is counts
    assert holds("local", "ratio", value, "inconclusive") is not counts
    assert holds("local", "ratio", F(value) - TINY, "inconclusive")
    assert holds("global", "ratio", 10**6, "inconclusive")


def test_the_greatest_ratio_over_policies_is_not_about_the_population() -> None:
    """It rests on the utility of the table, of which nothing was declared."""
    p = policy_stated(coin("2/3"), [[["1/2", "1/2"], ["1/2", "1/2"]]], ["3", "1"])
    certificate = write(p)
    claim = {"quantity": "local_ratio_supremum", "relation": "=", "value": "7/5", "scope": POLICIES, "by": "T13"}
    place = {"context": ["A"], "higher": ["f"], "lower": ["m"]}
    certificate["claims"] = [claim | {"evidence": {"attained": place}}]
    assert not false_statements(judged(certificate, target("local", "ratio", 10**6, "inconclusive")))
    assert false_statements(judged(certificate, target("local", "ratio", 10**6, "within")))


def test_t5_of_a_table_is_not_about_the_population() -> None:
    certificate = make({(0, 0): ["30", "20"], (0, 1): ["20", "30"], (1, 0): ["3", "2"], (1, 1): ["2", "3"]}, ["1", "0"])
    assert any(c["by"] == "T5" for c in certificate["claims"])
    assert accepted(certificate)
    assert accepted(judged(certificate, target("global", "ratio", 10, "inconclusive")))
    assert rejected(judged(certificate, target("global", "ratio", 10, "within")))


def test_a_difference_of_nobody_exceeds_nothing() -> None:
    """Where no context has two groups, a limit on the difference is open, however low it is."""
    table = {"d": ["yes", "no"] * 2, "g": ["a", "a", "b", "b"], "c": ["x", "x", "y", "y"], "n": [30, 20, 10, 40]}
    result = fa.audit(table, decision="d", group="g", context="c", count="n", utility="yes", max_difference="1/2", confidence=None)
    document = json.loads(result.certificate.text)
    assert document["verdict"] == "inconclusive" and all(finding.true for finding in checker.check(raw(document)).findings)
    document["targets"][0]["verdict"] = document["verdict"] = "exceeds"
    assert not all(finding.true for finding in checker.check(raw(document)).findings)
