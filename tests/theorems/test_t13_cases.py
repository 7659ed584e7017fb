"""What T13 says of a policy behind filters, scope by scope: which constants, which floors, and what the reader has to judge."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.theorems.applicable import guarantees
from fairaudit.theorems.assumptions import RELEASES
from fairaudit.theorems.bound import (
    ANY_CONTEXT_FILTER,
    ANY_POLICY,
    ANY_UTILITY,
    ANY_UTILITY_FLOORED,
    FLOORED,
    NEAR_POLICY,
    THIS_LAW,
    THIS_POLICY,
)
from fairaudit.theorems.case import Case
from fairaudit.theorems.supremum import Floors
from fairaudit.theorems.t13_cases import assumed, floors_of, t13_any_policy_in, t13_near_in, t13_range_floored_in, t13_range_in

F = Fraction
FRESH = "the filter's draws for group and context are independent"
POPULATION = "the contexts of each group are distributed as in the stated population"


def case(
    utility: Any = None,
    *,
    keep: Any = "2/3",
    counts: bool = False,
    releases: int = 1,
    population: Any = None,
    declared_in: Any = None,
    context: bool = False,
    **declared: Any,
) -> Case:
    """Two contexts, two groups, and a coin in front of the group."""
    rows = [[[9, 1], [2, 8]], [[5, 5], [4, 6]]]
    named: dict[str, Any] = {"decisions": ["hire", "pass"], "groups": ["f", "m"], "contexts": ["x", "y"]}
    scaled: Any = [[[value if counts else F(value, 10) for value in row] for row in block] for block in rows]
    law = fa.Law.from_array(scaled, kind="counts" if counts else "probabilities", **named)
    places = fa.RandomizedResponse(["x", "y"], keep_probability="2/3") if context else None
    coin = fa.RandomizedResponse(["f", "m"], keep_probability=keep)
    deployment = fa.Policy(law).behind(group=coin, context=places, population=population, releases=releases)
    table = fa.Utility(utility or {"hire": 3, "pass": 1}).on(deployment.law)
    own = {(label,): {name: F(value) for name, value in constants.items()} for label, constants in (declared_in or {}).items()}
    return Case(deployment, deployment.law, table, {name: F(value) for name, value in declared.items()}, declared_in=own)


def reached(found: Case, tau: Any = "1/10", **options: Any) -> set[tuple[str, str]]:
    """By what the ratios are bounded, and in which scopes."""
    said = guarantees(found, F(tau), **options)
    return {(bound.theorem, bound.scope) for bound in said.bounds} | {("T13", one.scope) for one in said.suprema}


def test_one_line_for_each_scope() -> None:
    assert reached(case()) == {("T12", THIS_POLICY), ("T13", ANY_POLICY)}
    everything = case(context=True, gamma=3, m=1, tau="6/5", max_drift="1/20")
    scopes = {NEAR_POLICY, ANY_POLICY, ANY_UTILITY, ANY_UTILITY_FLOORED}
    kept = {pair for pair in reached(everything) if pair[1] not in (FLOORED,)}
    assert kept == {("T12", THIS_POLICY), ("T8", ANY_CONTEXT_FILTER), *(("T13", scope) for scope in scopes)}


def test_all_bounds_adds_what_is_superfluous_and_changes_nothing_else() -> None:
    found = case(context=True, gamma=3, m=1, tau="6/5")
    few, many = reached(found), reached(found, all_bounds=True)
    assert few < many
    assert {("T2", ANY_POLICY), ("T4", ANY_POLICY), ("T1", THIS_LAW), ("T3", THIS_POLICY), ("T5-decision", ANY_POLICY)} <= many - few
    assert guarantees(found, F(1)).suprema == guarantees(found, F(1), all_bounds=True).suprema


def test_no_bound_that_is_left_out_was_sharper() -> None:
    found = case(gamma=3, m=1, population=[[3, 1], [1, 2]])
    least = {one.quantity: one.value for one in guarantees(found, F(1)).suprema if one.scope == ANY_POLICY}
    bounds = [bound for bound in guarantees(found, F(1), all_bounds=True).bounds if bound.scope == ANY_POLICY]
    assert len(bounds) >= 3
    for bound in bounds:
        assert least[bound.quantity.removesuffix("_ratio")] <= bound.value  # type: ignore[index]


def test_of_a_sampled_policy_only_a_declared_range_makes_bounds_superfluous() -> None:
    assert ("T2", ANY_POLICY) in reached(case(counts=True)) and ("T13", ANY_POLICY) in reached(case(counts=True))
    assert ("T2", ANY_POLICY) not in reached(case(counts=True, gamma=3, m=1))
    assert ("T3", FLOORED) in reached(case(counts=True, gamma=3, tau="11/10"))
    assert ("T3", FLOORED) not in reached(case(counts=True, gamma=3, m=1, tau="11/10"))


def test_a_filter_too_wide_for_a_reader_keeps_what_needs_epsilon_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fairaudit.theorems.case.PAIR_RATIOS", 1)
    assert ("T2", ANY_POLICY) in reached(case(gamma=3, m=1))
    assert not {scope for by, scope in reached(case(gamma=3, m=1)) if by == "T13"}


def test_too_many_different_pairs_are_left_out_with_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fairaudit.theorems.t13_problems.MAX_PROBLEMS", 0)
    found = case(tau="6/5")
    assert ("T2", ANY_POLICY) in reached(found) and not {scope for by, scope in reached(found) if by == "T13"}
    result = fa.certify(found.deployment, {"hire": 3, "pass": 1})
    assert any(note.startswith("what any policy can do behind these filters is left out") for note in result.notes)
    assert result.verify().ok


def test_several_releases_leave_only_what_knows_them() -> None:
    found = reached(case(releases=3, gamma=3, m=1, max_drift="1/20"), all_bounds=True)
    assert ("T13", ANY_POLICY) in found and ("T13", ANY_UTILITY) in found
    assert not {scope for by, scope in found if by != "T13"} & {ANY_POLICY, FLOORED} and ("T13", NEAR_POLICY) not in found
    once, thrice = (t13_any_policy_in(case(releases=n), "local") for n in (1, 3))
    assert once is not None and thrice is not None
    # three releases of a coin of 2/3: the four classes of likelihood 8, 2, 1/2, 1/8 with masses 8, 12, 6, 1 of 27
    thresholds = [(F(8), F(1)), (F(20), F(7)), (F(26), F(19))]  # what the likeliest classes have under either group
    assert once.value == F(7, 5) and thrice.value == max((27 + 2 * p) / (27 + 2 * q) for p, q in thresholds)


def test_the_range_of_each_context_counts_by_itself() -> None:
    # the ratio of a coin of 2/3 for utilities from m to γ is (m + (γ − m)·2/3) / (m + (γ − m)/3)
    utility = fa.Utility.from_function(lambda u, x, a: {("x", "hire"): 3, ("x", "pass"): 2}.get((x[0], u), 1), case().law)
    table = case(gamma=3, m=1)
    at = Case(table.deployment, table.law, utility.on(table.law), table.declared)
    own = replace(at, declared_in={("x",): {"m": F(2)}, ("y",): {"gamma": F(1)}})
    assert (t13_range_in(at, "local").value, t13_range_in(own, "local").value) == (F(7, 5), F(8, 7))  # type: ignore[union-attr]
    said = t13_range_in(own, "local").assumptions  # type: ignore[union-attr]
    assert 'in context ["x"], every utility is between 2 and 3 (declared)' in said
    assert 'in context ["y"], every utility is between 1 and 1 (declared)' in said
    # group means mix contexts, so that only the range of all of them counts
    assert t13_range_in(own, "global").value == t13_range_in(at, "global").value == F(7, 5)  # type: ignore[union-attr]
    assert not [text for text in t13_range_in(own, "global").assumptions if text.startswith("in context")]  # type: ignore[union-attr]


def test_floors_are_the_greater_of_those_of_all_and_of_one_context() -> None:
    found = case(tau="11/10", global_tau="3/2", declared_in={"x": {"tau": "6/5"}, "y": {"tau": "1"}})
    assert floors_of(found) == Floors((F(6, 5), F(11, 10)), F(3, 2))
    assert floors_of(case()) == Floors((F(0), F(0))) and not floors_of(case())


def test_a_floor_of_every_context_is_one_of_the_mean_weighted_by_the_population() -> None:
    utility = {"hire": 1}
    options: dict[str, Any] = {"gamma": 1, "m": 0, "keep": "7/10", "population": [[1, 3], [3, 1]]}
    found = case(utility, declared_in={"x": {"tau": "1/5"}, "y": {"tau": "2/5"}}, **options)
    bound = t13_range_floored_in(found, "global")
    # f: 1/4·1/5 + 3/4·2/5 = 7/20, m: 3/4·1/5 + 1/4·2/5 = 1/4; the rows P(x|a)·M(ã|a) are (7, 3, 21, 9)/40 and (9, 21, 3, 7)/40, up to order
    rows = [(F(7, 40), F(9, 40)), (F(3, 40), F(21, 40)), (F(21, 40), F(3, 40)), (F(9, 40), F(7, 40))]

    def above(pairs: list[tuple[Fraction, Fraction]], tau: Fraction) -> Fraction:
        """The least over k of k + H_k/τ, which bends at likelihood ratios."""
        return min(k + sum(max(F(0), p - k * q) for p, q in pairs) / tau for k in [F(0), *(p / q for p, q in pairs)])

    assert bound is not None
    assert bound.value == max(above(rows, F(1, 4)), above([(q, p) for p, q in rows], F(7, 20)))


def test_what_is_not_declared_is_not_claimed() -> None:
    assert t13_range_in(case(), "local") is t13_range_in(case(gamma=3), "local") is t13_range_in(case(m=1), "local") is None
    assert t13_range_floored_in(case(gamma=3, m=1), "local") is None
    assert t13_range_floored_in(case(gamma=3, m=1, declared_in={"x": {"tau": "6/5"}}), "local") is None  # y has no floor
    assert t13_near_in(case(), "local") is None
    assert t13_range_in(case(gamma=3, m=0, lipschitz="1/10"), "local") is None  # infinite: nothing is bounded


def test_groups_without_mass_are_not_compared_and_need_no_floor() -> None:
    policy = fa.Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"], ["0.5", "0.5"]], decisions=["hire", "pass"], groups=["f", "m", "n"])
    at = policy.behind(group=fa.RandomizedResponse(["f", "m", "n"], keep_probability="1/2"), population=[[1, 1, 0]])
    declared = {name: F(value) for name, value in {"gamma": 1, "m": 0, "tau": "1/5"}.items()}
    found = Case(at, at.law, fa.Utility({"hire": 1}).on(at.law), declared)
    bound = t13_range_floored_in(found, "global")
    assert bound is not None and bound.value == 2  # likelihood ratios are 2, 1 and 1/2, and τ is low enough for k = 2


@pytest.mark.parametrize(
    ("scope", "quantity", "said"),
    [
        (ANY_POLICY, "local", []),
        (ANY_POLICY, "global", [POPULATION]),
        (NEAR_POLICY, "local", ["total variation 1/20"]),
        (FLOORED, "local", ["expected utility is at least 6/5 behind", 'in context ["x"], every compared', "mean utility is at least 5/4"]),
        (ANY_UTILITY, "global", [POPULATION, "every utility is between 1 and 3, and for the same decision and context"]),
    ],
)
def test_what_is_left_to_judge(scope: str, quantity: Any, said: list[str]) -> None:
    found = case(gamma=3, m=1, tau="6/5", global_tau="5/4", max_drift="1/20", declared_in={"x": {"tau": "13/10"}})
    texts = assumed(found, quantity, scope)
    assert texts[0].startswith(FRESH) and len(texts) == 1 + len(said)
    assert all(any(part in text for text in texts) for part in said)
    assert RELEASES.format(releases=2) in assumed(case(releases=2), "local", ANY_POLICY)
