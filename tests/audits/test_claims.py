"""What a result claims: each claim of a kind of the registry, in one order, with what its kind lists and carries."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from typing import Any

import fairaudit as fa
from fairaudit.theorems.assumptions import FRESH
from fairaudit.theorems.registry import kind_of

F = Fraction


def law(**options: Any) -> fa.Law:
    return fa.Law.from_array([[[3, 1], [1, 1]], [[3, 1], [1, 1]]], kind="counts", decisions=["yes", "no"], groups=["f", "m"], **options)


def behind(**options: Any) -> fa.Result:
    policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["yes", "no"], groups=["f", "m"])
    return fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4")), {"yes": 1}, **options)


def said(result: fa.Result) -> list[tuple[str, str, Any, str]]:
    return [(claim.quantity, claim.relation, claim.value, claim.by) for claim in result.claims]


def test_of_a_table_figures_come_first_then_what_follows_from_them() -> None:
    result = fa.certify(law(), {"yes": 1}, confidence=None)
    assert said(result) == [
        ("local_ratio", "=", F(3, 2), "enumeration"),
        ("global_ratio", "=", F(3, 2), "enumeration"),
        ("demographic_parity", "=", F(1, 4), "enumeration"),
        ("equalized_odds", "=", F(1, 4), "enumeration"),
        ("local_ratio_supremum", "=", F(2), "T6"),
        ("equalized_odds", "<=", F(1, 3), "T7"),
        ("global_ratio_supremum", "=", F(2), "T6"),
        ("demographic_parity", "<=", F(1, 3), "T7"),
        ("global_ratio", "<=", F(3, 2), "T5"),
        ("local_hidden_context", ">=", F("2.618033"), "T14"),
        ("global_hidden_context", ">=", F("2.618033"), "T14"),
    ]
    assert {claim.scope for claim in result.claims} == {"this law"}
    assert {claim.assumptions for claim in result.claims} == {()}


def test_context_and_group_that_depend_on_each_other_carry_nothing_over() -> None:
    dependent = fa.Law.from_array([[[3, 1], [1, 1]], [[3, 1], [2, 2]]], kind="counts", decisions=["yes", "no"])
    assert "T5" not in {claim.by for claim in fa.certify(dependent, {"yes": 1}, confidence=None).claims}


def test_an_infinite_supremum_bounds_the_distance_by_1() -> None:
    apart = fa.Law.from_array([[1, 0], [1, 1]], kind="counts", decisions=["yes", "no"])
    claims = fa.certify(apart, {"yes": 1}, confidence=None).claims
    assert [claim.value for claim in claims if claim.by == "T6"] == [inf, inf]
    assert [(claim.value, claim.entry["evidence"]) for claim in claims if claim.by == "T7"] == [(F(1), {"supremum": "inf"})] * 2


def test_both_ends_of_an_interval_are_claimed_for_the_population() -> None:
    result = fa.certify(law(), {"yes": 1}, confidence="0.9")
    ends = [claim for claim in result.claims if claim.scope == "population at confidence 9/10"]
    assert [(claim.quantity, claim.relation) for claim in ends] == [
        (quantity, relation) for quantity in ("local_ratio", "global_ratio") for relation in (">=", "<=")
    ]
    for claim in ends:
        interval = result.intervals["local" if claim.quantity == "local_ratio" else "global"]
        assert claim.value == (interval.lower if claim.relation == ">=" else interval.upper)
        assert claim.assumptions == interval.assumptions != ()


def test_of_a_policy_every_claim_says_that_the_filters_are_fresh_and_none_says_what_the_table_shows() -> None:
    result = behind(declared={"tau": "1/5"})
    for claim in result.claims:
        assert claim.assumptions[0] == FRESH
        assert not any("does not depend on the group" in text or "multiplies" in text for text in claim.assumptions)
    floored = [claim for claim in result.claims if "declared floor" in claim.scope]
    assert floored and all(
        claim.assumptions[-1] == "every compared group's expected utility is at least 1/5 behind the filter (declared)" for claim in floored
    )


def test_evidence_is_what_the_kind_carries() -> None:
    result = behind(declared={"tau": "1/5", "m": 0})
    for claim in result.claims:
        kind = kind_of(claim.entry)
        assert kind is not None
        assert list(claim.evidence) == [key for key in (kind.evidence, *kind.beside) if key]
    assert next(claim for claim in result.claims if claim.by == "T12").evidence == {"raw_ratio": "9/2"}
