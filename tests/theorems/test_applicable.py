"""Which theorems are applied to a policy behind filters: those that have what they need, in the order of the registry, and as it says."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.theorems.applicable import applicable_bounds, applied, to_judge
from fairaudit.theorems.assumptions import DECLARED_FLOOR, FRESH, GROUP_FREE, POPULATION
from fairaudit.theorems.bound import ANY_POLICY, THIS_LAW
from fairaudit.theorems.case import Case
from fairaudit.theorems.registry import BY_ID, BY_KEY, KINDS
from fairaudit.theorems.t02 import t2, t2_in

F = Fraction


def case(utility: Any = None, keep: Any = "3/4", context: bool = False, **declared: Any) -> Case:
    """Two contexts, two groups, and a coin in front of the group."""
    policy = fa.Policy.from_array(
        [[["0.9", "0.1"], ["0.2", "0.8"]], [["0.5", "0.5"], ["0.4", "0.6"]]],
        decisions=["hire", "pass"],
        groups=["f", "m"],
        contexts=["x", "y"],
    )
    coin = fa.RandomizedResponse(["f", "m"], keep_probability=keep)
    places = fa.RandomizedResponse(["x", "y"], keep_probability="2/3") if context else None
    deployment = policy.behind(group=coin, context=places)
    table = fa.Utility(utility or {"hire": 1}).on(deployment.law)
    return Case(deployment, deployment.law, table, {name: F(value) for name, value in declared.items()})


def ids(found: Case, tau: Any = "1/10") -> list[str]:
    return [BY_KEY[bound.quantity, "<=", bound.theorem, bound.scope].id for bound in applicable_bounds(found, F(tau))]


def test_they_come_in_the_order_of_the_registry_floor_by_floor() -> None:
    under = ["floor", "T1", "T1-paper", "T3"]
    assert ids(case(context=True)) == ["T2", "T12", "T3-any-filter", *under, "T5-any-policy", "T5-decision", "T8"]
    assert ids(case(tau="1/20")) == ["T2", "T12", "T3-any-filter", *under, *under, "T5-any-policy", "T5-decision"]
    assert ids(case(m="1/5"), 0)[:4] == ["T2", "T12", "T4", "T3-any-filter"]
    order = [kind.id for kind in KINDS]
    assert sorted(set(ids(case(context=True))), key=order.index) == ids(case(context=True))


def test_what_a_theorem_needs_is_asked_before_it_is_applied() -> None:
    assert not {"T2", "T12", "T4", "T3-any-filter", "T5-any-policy"} & set(ids(case(lipschitz="1/10")))
    assert not {"T2", "T1-paper", "T5-any-policy", "T5-decision"} & set(ids(case(keep=1)))
    assert "T8" not in ids(case())


def test_a_bound_that_rests_on_more_than_its_kind_says_is_never_claimed() -> None:
    found, kind = case(), BY_ID["T2"]
    more = replace(kind, applies=lambda at: replace(t2_in(at), assumptions=(*t2_in(at).assumptions, "the draws were watched")))
    elsewhere = replace(kind, applies=lambda at: replace(t2_in(at), scope=THIS_LAW))
    silent = replace(kind, applies=lambda at: replace(t2_in(at), assumptions=(GROUP_FREE,)))
    assert applied(kind, found) == t2(3)
    for wrong in (more, elsewhere, silent):
        with pytest.raises(AssertionError, match="not what the registry says"):
            applied(wrong, found)


def test_what_the_table_shows_is_not_for_the_reader_to_judge() -> None:
    for bound in applicable_bounds(case(tau="1/20", context=True), F(1, 10)):
        floor = DECLARED_FLOOR.replace("{tau}", "1/20")
        assert set(to_judge(bound)) <= {FRESH, POPULATION, floor}
        assert (floor in to_judge(bound)) == bound.scope.endswith("that keeps the declared floor")
        assert FRESH in to_judge(bound)


def test_a_filter_too_wide_for_a_reader_has_no_bound_by_multipliers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fairaudit.theorems.case.PAIR_RATIOS", 1)
    assert {"T2", "T12"} <= set(ids(case())) and not {"T1", "T3", "T4"} & set(ids(case()))


def test_bounds_for_any_policy_say_so() -> None:
    assert {bound.scope for bound in applicable_bounds(case(), None) if bound.theorem in ("T2", "T5", "T5-decision")} == {ANY_POLICY}
