"""Calibration: the guarantee holds at the returned filter, the next one breaks it, infeasible exactly when the theory says."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import inf, prod
from pathlib import Path
from typing import Any

import pytest
import tiers
from envelopes import result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from theorem_oracle import best_in_range, response_rows
from worst_policy_oracle import Setting, by_linear_program, random_utility

import fairaudit as fa
from fairaudit import InputError
from fairaudit.cli import main
from fairaudit.exact.enclosures import compare_log
from fairaudit.filters.calibration import calibrate
from fairaudit.filters.calibration_with_policy import calibrate_policy
from fairaudit.filters.calibration_with_utility import calibrate_utility
from fairaudit.filters.responses import SPLITS
from fairaudit.privacy.pairs import pair_laws, power
from fairaudit.theorems.assumptions import DECLARED_RANGE, INDEPENDENT
from fairaudit.theorems.bound import ANY_POLICY, ANY_UTILITY, ANY_UTILITY_FLOORED, THIS_LAW
from fairaudit.theorems.t03 import t3_approx

F = Fraction
SETTINGS = 10_000 if tiers.FULL else 400
"""Random settings per rule."""


def response_factor(keep: Fraction, k: int) -> Any:
    """e^ε of k-ary randomized response, by its definition."""
    lie = (1 - keep) / (k - 1)
    return inf if lie == 0 else max(keep / lie, lie / keep) if keep else inf


def worst_ratio(keep: Fraction, k: int, t: Fraction) -> Fraction:
    """Greatest ratio over all policies with floor t behind k-ary randomized response: the closed form of T3, worked out by regime."""
    lie = (1 - keep) / (k - 1)
    if t <= lie:
        return keep / lie
    if t <= 1 - keep:
        return 1 + (keep - lie) / t
    return (1 - lie / keep * (1 - t)) / t


@pytest.mark.parametrize(("k", "keep", "paper"), [(16, 0.125, 0.075), (64, 0.081, 0.019)])
def test_the_lever_of_the_paper_and_ours(k: int, keep: float, paper: float) -> None:
    found = calibrate(max_log="0.2", groups=k, tau="0.3")
    assert round(float(found.keep_probabilities[0]), 3) == keep
    assert round(float(found.paper_keep_probabilities[0]), 3) == paper
    realised = worst_ratio(found.keep_probabilities[0], k, F(3, 10))
    assert found.achieved == realised == max(power(pair, F(3, 10))[0] for pair in pair_laws(found.mechanism)) / F(3, 10)
    assert compare_log((realised.numerator, realised.denominator), (2, 10)) <= 0
    assert compare_log((realised.numerator, realised.denominator), (199, 1000)) > 0


@pytest.mark.parametrize("rule", ["paper", "tight", "sharp", "exact", "contraction"])
def test_random_settings(rule: Any) -> None:
    """The formulas of the theory, solved for e^ε, against the search."""
    rng = random.Random(tiers.fresh(rule))
    for _ in range(SETTINGS):
        k = rng.choice([2, 3, 5, 16, 64])
        gamma = F(rng.randint(1, 20), rng.randint(1, 4))
        tau = gamma * F(rng.randint(1, 99), 100)
        delta = F(0) if rule in ("exact", "contraction") else rng.choice([F(0), F(rng.randint(1, 30), 100)])
        gap = F(0) if rule in ("sharp", "contraction", "exact") else rng.choice([F(0), gamma * F(rng.randint(1, 20), 100)])
        target = 1 + F(rng.randint(1, 300), 100) ** rng.choice([1, 3]) / rng.choice([1, 10])
        raw = 1 + F(rng.randint(1, 900), 100)
        options = {"raw_ratio": raw} if rule == "contraction" else {"tau": tau, "delta": delta, "lipschitz": gap}
        found = calibrate(max_ratio=target, groups=k, gamma=gamma, bound=rule, **options)
        t, excess = tau / gamma, (gap + delta * gamma) / tau
        wanted: Any
        if rule == "contraction":
            wanted = inf if target >= raw else (target * raw - 1) / (raw - target)
        elif target * t >= 1:
            wanted = inf
        elif rule == "paper":
            wanted = target / (1 + excess)
        elif rule == "tight":
            wanted = target - excess
        elif rule == "sharp":
            infeasible = target < min(1 / t, 1 + delta / t)
            wanted = 0 if infeasible else max(target - delta / t, (1 - delta - t) / (1 - t * target))
        else:
            c = t * (target - 1)
            wanted = max(target, (1 + (k - 1) * c) / (1 - c), (1 - t) / (1 - t * target))
        assert found.feasible == (wanted >= 1), (rule, k, gamma, tau, delta, gap, target)
        if not found.feasible:
            assert found.reason
            continue
        if wanted == inf:
            assert found.keep_probabilities == (1,)
            continue
        keep = found.keep_probabilities[0]
        exact = wanted / (wanted + k - 1)
        # The greatest keep probability on the grid of 1e-12, but never below 1/k.
        assert exact - F(2, 10**12) < keep <= max(exact, F(1, k))
        assert found.achieved <= target
        if keep + F(1, 10**6) < 1:
            following = response_factor(keep + F(1, 10**6), k)
            broken: Any
            if rule == "exact":
                broken = worst_ratio(keep + F(1, 10**6), k, t)
            elif rule == "contraction":
                broken = (1 + raw * following) / (raw + following)
            elif rule == "sharp":
                broken = t3_approx(following, delta, t).value
            else:
                broken = min(gamma / tau, following * (1 + excess) if rule == "paper" else following + excess)
            assert broken > target


@pytest.mark.parametrize(
    ("k", "least", "target", "keep"), [(16, F(1, 10), F(5, 4), F(4, 39)), (64, F(3, 10), F(6, 5), F(11, 107)), (2, 0, 2, F(2, 3))]
)
def test_the_closed_form(k: int, least: Any, target: Any, keep: Fraction) -> None:
    """((k − 1)c + R*)/(k − 1 + R*), c = m(R* − 1)/(γ − m): a short fraction is given as it is, and attains the target."""
    c = least * (target - 1) / (1 - F(least))
    assert keep == ((k - 1) * c + target) / (k - 1 + target)
    found = calibrate(max_ratio=target, groups=k, g_min=least)
    assert found.keep_probabilities == (keep,)
    assert found.achieved == target == (least + (1 - least) * keep) / (least + (1 - least) * (1 - keep) / (k - 1))
    long = calibrate(max_log="0.2", groups=k, g_min=least)
    exact = ((k - 1) * least * (long.target - 1) / (1 - F(least)) + long.target) / (k - 1 + long.target)
    assert long.keep_probabilities[0].denominator <= 10**12
    assert exact - F(1, 10**12) < long.keep_probabilities[0] <= exact


def response_pair(k: int, keep: Fraction) -> tuple[list[Fraction], list[Fraction]]:
    """Two rows of randomized response; outputs that neither of them is the truth for are one."""
    lie = (1 - keep) / (k - 1)
    rest = [(k - 2) * lie] if k > 2 else []
    return [keep, lie, *rest], [lie, keep, *rest]


def worst_by_outputs(k: int, keep: Fraction, gamma: Fraction, least: Fraction, gap: Fraction) -> Any:
    """The greatest ratio over all sets of outputs at which the most is paid: the first group has `gap` more than the second throughout."""
    span, worst = gamma - gap - least, F(1)
    for paid in product([0, 1], repeat=2 if k == 2 else 3):
        top, low = (sum(v for v, taken in zip(row, paid, strict=True) if taken) for row in response_pair(k, keep))
        above, below = gap + least + span * top, least + span * low
        worst = max(worst, above / below if below else inf if above else F(1))
    return worst


def test_the_closed_form_keeps_every_target_and_the_next_step_breaks_it() -> None:
    """Numbers of values, least utilities, gaps between groups and targets, without a floor."""
    rng = random.Random(tiers.fresh("closed form"))
    kept = missed = 0
    for _ in range(SETTINGS):
        k = rng.choice([2, 3, 4, 7, 16, 64, 200])
        gamma = F(rng.randint(1, 50), rng.randint(1, 10))
        least = gamma * F(rng.choice([0, rng.randint(0, 99), rng.randint(1, 1000)]), 1000)
        target = 1 + F(rng.randint(1, 400), 100) ** rng.choice([1, 2]) / rng.choice([1, 10])
        # A gap of up to twice what the target leaves room for, where there is any, so that both answers are frequent.
        gap = min(gamma - least, rng.choice([F(0), F(rng.randint(1, 200), 100) * least * (target - 1)]))
        found = calibrate(max_ratio=target, groups=k, gamma=gamma, g_min=least, lipschitz=gap)
        if not found.feasible:
            missed += 1
            assert found.settled
            assert worst_by_outputs(k, F(1, k), gamma, least, gap) > target
            continue
        keep = found.keep_probabilities[0]
        assert worst_by_outputs(k, keep, gamma, least, gap) == found.achieved <= target
        if keep + F(1, 10**6) <= 1:
            kept += 1
            assert worst_by_outputs(k, keep + F(1, 10**6), gamma, least, gap) > target
        else:
            assert keep == 1 or worst_by_outputs(k, F(1), gamma, least, gap) > target
    assert tiers.enough(kept > SETTINGS // 2 and missed > SETTINGS // 50)


def worst_in_range(keeps: Sequence[tuple[int, Fraction]], numbers: Sequence[Fraction]) -> Any:
    """The greatest ratio over all pairs of tuples, by exact linear programs: attributes are equal or differ."""
    equal, worst = ([F(1)], [F(1)]), F(1)
    for differ in product([False, True], repeat=len(keeps)):
        parts = [response_pair(k, keep) if d else equal for d, (k, keep) in zip(differ, keeps, strict=True)]
        rows = [[prod(entries) for entries in product(*(part[side] for part in parts))] for side in (0, 1)]
        if any(differ):
            worst = max(worst, best_in_range(rows[0], rows[1], *numbers))
    return worst


def test_the_exact_rule_never_exceeds_a_target_and_the_next_step_breaks_it() -> None:
    """Greatest and least utility, a gap between groups, a floor, one or two attributes; linear programs say what is attained."""
    rng = random.Random(tiers.fresh("exact"))
    feasible = infeasible = 0
    for _ in range(SETTINGS):
        sizes = [rng.choice([2, 3, 5, 16, 64])] if rng.random() < 0.8 else [rng.choice([2, 3, 4]) for _ in range(2)]
        gamma = F(rng.randint(1, 20), rng.randint(1, 4))
        least = gamma * rng.choice([F(0), F(rng.randint(1, 60), 100)])
        gap = (gamma - least) * rng.choice([F(0), F(0), F(rng.randint(1, 30), 100), F(rng.randint(1, 100), 100)])
        tau = rng.choice([F(0), least + (gamma - least) * F(rng.randint(1, 99), 100)])
        target = 1 + F(rng.randint(1, 300), 100) ** rng.choice([1, 3]) / rng.choice([1, 10])
        split = rng.choice(SPLITS[:2])
        found = calibrate(
            max_ratio=target,
            groups={f"a{i}": k for i, k in enumerate(sizes)},
            gamma=gamma,
            g_min=least,
            lipschitz=gap,
            tau=tau,
            split=split,
        )
        numbers = (gamma, least, gap, tau)
        setting = (sizes, target, split, numbers)
        if not found.feasible:
            infeasible += 1
            assert found.settled
            assert worst_in_range([(k, F(1, k)) for k in sizes], numbers) > target, setting
            continue
        feasible += 1
        keeps = list(zip(sizes, found.keep_probabilities, strict=True))
        attained = worst_in_range(keeps, numbers)
        assert attained == found.achieved <= target, setting
        if max(found.keep_probabilities) + F(1, 10**6) < 1:
            assert worst_in_range([(k, keep + F(1, 10**6)) for k, keep in keeps], numbers) > target, setting
        else:
            assert found.keep_probabilities == (1,) * len(sizes) or len(sizes) > 1, setting
    assert tiers.enough(min(feasible, infeasible) > SETTINGS // 20)


@pytest.mark.parametrize("split", SPLITS)
def test_products_keep_the_target_for_every_pair_of_tuples(split: Any) -> None:
    found = calibrate(max_ratio="3/2", groups={"a": 2, "b": 3, "c": 2}, tau="0.2", split=split)
    mechanism = found.mechanism
    worst = F(0)
    t = F(1, 5)
    for a, b in product(mechanism.inputs, repeat=2):
        if a == b:
            continue
        pairs = sorted(
            ((F(p, mechanism.denominator), F(q, mechanism.denominator)) for p, q in zip(mechanism.row(a), mechanism.row(b), strict=True)),
            key=lambda pq: pq[0] / pq[1],
            reverse=True,
        )
        spent = gained = F(0)
        for p, q in pairs:
            part = min(F(1), (t - spent) / q) if q else F(1)
            spent, gained = spent + part * q, gained + part * p
            if spent >= t:
                break
        worst = max(worst, gained / t)
    assert worst == found.achieved <= F(3, 2)
    assert worst > F(3, 2) - F(1, 10**6)


def test_most_truth_keeps_at_least_as_much_as_the_other_splits() -> None:
    kept = {}
    for split in SPLITS:
        found = calibrate(max_log="0.5", groups={"a": 2, "b": 5, "c": 9}, tau="0.3", split=split)
        kept[split] = found.keep_probabilities[0] * found.keep_probabilities[1] * found.keep_probabilities[2]
    assert kept["most-truth"] >= max(kept.values())


def some_groups(sizes: Sequence[int], contexts: int, decisions: Sequence[str]) -> fa.Policy:
    """A policy of groups that are tuples, whatever it decides."""
    columns = [f"a{i}" for i in range(len(sizes))]
    rows = [(f"x{x}", *label, u) for x in range(contexts) for label in product(*(map(str, range(k)) for k in sizes)) for u in decisions]
    table: dict[str, list[Any]] = dict(zip(["x", *columns, "u"], map(list, zip(*rows, strict=True)), strict=True))
    table["p"] = [int(row[-1] == decisions[0]) for row in rows]
    return fa.Policy.from_probabilities(table, decision="u", group=columns, context="x", probability="p")


@pytest.mark.parametrize("uses", ["decision", "context", "group"])
@pytest.mark.parametrize("quantity", ["local", "global"])
def test_a_known_utility_never_exceeds_a_target_and_the_next_step_breaks_it(uses: str, quantity: Any) -> None:
    """Against the exact linear program of the worst policy, for one and two attributes, with contexts that are spread differently."""
    rng = random.Random(tiers.fresh(f"{uses} {quantity}"))
    counts = {"kept": 0, "hidden": 0, "whole": 0}
    for _ in range(SETTINGS // 10):
        sizes = rng.choice([[2], [3], [4], [2, 2]])
        contexts, groups = rng.choice([1, 2]), prod(sizes)
        utility = random_utility(rng, uses, contexts, groups, rng.choice([2, 3]))
        population = rng.choice([None, [[F(rng.randint(1, 3)) for _ in range(groups)] for _ in range(contexts)]])
        policy = some_groups(sizes, contexts, names := [f"u{i}" for i in range(len(utility[0][0]))])
        place = {label: a for a, label in enumerate(product(*(map(str, range(k)) for k in sizes)))}
        worth = fa.Utility.from_function(
            lambda u, x, a, utility=utility, place=place, names=names: utility[int(x[0][1:])][place[a]][names.index(u)], policy.law
        )
        target, split = 1 + F(rng.randint(1, 60), 20), rng.choice(SPLITS[:2])
        found = calibrate_utility(policy, worth, max_ratio=target, quantity=quantity, population=population, split=split)

        def worst(keeps: Sequence[Fraction], sizes: Any = sizes, utility: Any = utility, population: Any = population) -> Any:
            factors = [response_rows(k, max(F(1, k), min(F(1), keep))) for k, keep in zip(sizes, keeps, strict=True)]
            return max(by_linear_program(sums) for *_, sums in Setting(factors, utility, None, population).sums(quantity))

        if not found.feasible:
            counts["hidden"] += 1
            assert found.settled and found.reason
            assert worst([F(0)] * len(sizes)) > target
            continue
        assert worst(found.keep_probabilities) == found.achieved <= target
        if max(found.keep_probabilities) == 1:
            counts["whole"] += 1
            continue
        counts["kept"] += 1
        assert worst([keep + F(1, 10**6) for keep in found.keep_probabilities]) > target
    assert tiers.enough(counts["kept"] >= SETTINGS // 80)
    assert counts["hidden"] or uses == "decision" or (uses, quantity) == ("context", "local")


def test_a_known_utility_in_short_fractions() -> None:
    """A utility of no group is the closed form; of one that depends on it the fraction is found as well."""
    policy = some_groups([16], 1, ["go", "stay"])
    found = calibrate_utility(policy, {"go": 10, "stay": 1}, max_ratio="5/4")
    assert (found.keep_probabilities, found.achieved, found.scope) == ((F(4, 39),), F(5, 4), ANY_POLICY)
    pair = some_groups([2], 1, ["go", "stay"])
    worth = fa.Utility.from_function(lambda u, _, a: 3 + (a == ("1",)) if u == "go" else 1, pair.law)
    # The worst policy goes at what group 1 releases more often: (4p + 1 − p)/(3(1 − p) + p) = 2 at p = 5/7.
    found = calibrate_utility(pair, worth, max_ratio=2)
    assert (found.keep_probabilities, found.achieved) == ((F(5, 7),), 2)


def test_what_no_policy_should_decide_for_a_known_utility() -> None:
    """A utility that is not known everywhere, or that one group alone can get, is told as such."""
    pair = some_groups([2], 1, ["go", "stay"])
    only = fa.Utility.from_function(lambda u, _, a: int(u == "go" and a == ("0",)), pair.law)
    found = calibrate_utility(pair, only, max_ratio=2)
    assert not found.feasible and found.settled and "one group nothing and another something" in found.reason
    differs = fa.Utility.from_function(lambda u, _, a: 2 + (a == ("0",)), pair.law)
    assert "at least 1.5 " in calibrate_utility(pair, differs, max_ratio="5/4").reason
    assert calibrate_utility(pair, differs, max_ratio="3/2").keep_probabilities == (1,)
    partial = fa.Policy.from_probabilities(
        {"u": ["a", "b", "a", "a"], "x": ["1", "1", "2", "2"], "g": ["f", "m", "f", "m"], "p": [1, 1, 1, 1]},
        decision="u", group="g", context="x", probability="p",
    )  # fmt: skip
    entries = {"u": [*"ababaa"], "x": [*"111122"], "g": [*"ffmmfm"], "w": [1, 2, 1, 2, 3, 3]}
    known = fa.Utility.from_table(entries, utility="w", decision="u", context="x", group="g")
    with pytest.raises(InputError, match="other policies may take it there"):
        calibrate_utility(partial, known, max_ratio=2)


def test_a_known_policy_is_calibrated_on_its_own_ratio() -> None:
    policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    found = calibrate_policy(policy, {"hire": 1}, max_ratio=2)
    keep = found.keep_probabilities[0]
    # E(f)/E(m) = (0.2 + 0.7p)/(0.9 − 0.7p) = 2 at p = 16/21.
    assert F(16, 21) - F(2, 10**12) < keep <= F(16, 21)
    assert found.achieved == (F(1, 5) + F(7, 10) * keep) / (F(9, 10) - F(7, 10) * keep) <= 2
    contraction = calibrate(max_ratio=2, groups=2, bound="contraction", raw_ratio="9/2")
    assert contraction.keep_probabilities[0] <= keep
    assert calibrate_policy(policy, {"hire": 1}, max_ratio=5).keep_probabilities == (1,)


def test_a_ratio_that_falls_before_it_rises() -> None:
    """Behind a filter that hides the group, f has half of m; at a keep probability of 3/4 they are equal."""
    policy = fa.Policy.from_array([[[1, 0], [0, 1]]], decisions=["yes", "no"], groups=["f", "m"])
    worth = fa.Utility.from_function(lambda u, _, a: (1 if a == ("f",) else 3) if u == "yes" else 0, policy.law)
    found = calibrate_policy(policy, worth, max_ratio="1.000001")
    # E(f) = p and E(m) = 3·(1 − p) are equal at 3/4; their ratio is at the target a little above.
    assert found.feasible and F(3, 4) <= found.keep_probabilities[0] < F(3, 4) + F(1, 10**6)
    assert found.achieved is not None and 1 <= found.achieved <= F("1.000001")
    missed = calibrate_policy(policy, {"yes": 1}, max_ratio="1.000001")
    assert missed.feasible and missed.keep_probabilities[0] > F(1, 2)


Rates = st.lists(st.integers(0, 4), min_size=12, max_size=12)


@given(
    k=st.sampled_from([2, 3]), contexts=st.sampled_from([1, 2]), rates=Rates, worth=Rates, excess=st.integers(1, 12), whole=st.booleans()
)
@settings(max_examples=200, deadline=None)
def test_one_attribute_is_settled_whatever_the_utility(
    k: int, contexts: int, rates: list[int], worth: list[int], excess: int, whole: bool
) -> None:
    """Against all keep probabilities n/360 and all at which a pair of groups meets the target exactly, worked out by hand."""
    target = 1 + F(excess, 6)
    quantity = "global" if whole else "local"
    groups, places = "abc"[:k], "xy"[:contexts]
    yes = {(x, a): F(rates[3 * i + j], 4) for i, x in enumerate(places) for j, a in enumerate(groups)}
    value = {(x, a): worth[3 * i + j] for i, x in enumerate(places) for j, a in enumerate(groups)}
    policy = fa.Policy.from_array(
        [[[yes[x, a], 1 - yes[x, a]] for a in groups] for x in places], decisions=["yes", "no"], groups=list(groups), contexts=list(places)
    )
    utility = fa.Utility.from_function(lambda u, x, a: value[x[0] if x else "x", a[0]] if u == "yes" else 0, policy.law)

    def blocks(keep: F) -> list[list[F]]:
        lie = (1 - keep) / (k - 1)
        found = [[value[x, a] * sum((keep if a == b else lie) * yes[x, b] for b in groups) for a in groups] for x in places]
        return [[sum(column) / contexts for column in zip(*found, strict=True)]] if whole else found

    def holds(keep: F) -> bool:
        return all(max(block) <= target * min(block) for block in blocks(keep))

    crossings = []
    at = [blocks(F(n)) for n in (0, 1)]
    for first, last in zip(*at, strict=True):
        for i, j in product(range(k), repeat=2):
            start, slope = first[i] - target * first[j], (last[i] - first[i]) - target * (last[j] - first[j])
            crossings += [-start / slope] if slope else []
    tried = [p for p in (*(F(n, 360) for n in range(361)), *crossings) if F(1, k) <= p <= 1]
    best = max(filter(holds, tried), default=None)
    try:
        found = calibrate_policy(policy, utility, max_ratio=target, quantity=quantity)  # type: ignore[arg-type]
    except InputError as error:
        assert "always 0" in str(error) and not any(worth[3 * i + j] for i in range(contexts) for j in range(k))
        return
    assert found.settled
    assert found.feasible == (best is not None)
    if best is not None:
        assert holds(found.keep_probabilities[0])
        assert found.keep_probabilities[0] == best or best - F(1, 10**12) < found.keep_probabilities[0] < best


@given(rates=Rates, worth=Rates, excess=st.integers(1, 12), split=st.sampled_from(SPLITS))
@settings(max_examples=40, deadline=None)
def test_several_attributes_are_searched_along_their_line(rates: list[int], worth: list[int], excess: int, split: Any) -> None:
    """No step of a fine grid that meets the target lies above what is found, and infeasible is said of nothing that is feasible."""
    target = 1 + F(excess, 6)
    pairs = list(product("fm", "abc"))
    yes = {pair: F(rate, 4) for pair, rate in zip(pairs, rates, strict=False)}
    value = dict(zip(pairs, worth, strict=False))
    if not any(value.values()):
        return
    policy = fa.Policy.from_probabilities(
        {
            "sex": [s for s, _ in pairs for _ in "yn"],
            "age": [a for _, a in pairs for _ in "yn"],
            "answer": ["yes", "no"] * 6,
            "p": [str(p) for pair in pairs for p in (yes[pair], 1 - yes[pair])],
        },
        decision="answer",
        group=("sex", "age"),
        probability="p",
    )
    utility = fa.Utility.from_function(lambda u, _, a: value[a] if u == "yes" else 0, policy.law)

    def ratio(keeps: tuple[F, ...]) -> Any:
        chance = [lambda t, r, p=keeps[0]: p if t == r else 1 - p, lambda t, r, p=keeps[1]: p if t == r else (1 - p) / 2]
        means = [value[a] * sum(chance[0](a[0], b[0]) * chance[1](a[1], b[1]) * yes[b] for b in pairs) for a in pairs]
        return 1 if max(means) == min(means) else inf if min(means) == 0 else max(means) / min(means)

    def line(n: int) -> tuple[F, ...]:
        s = F(n, 200)
        if split == "equal-epsilon":
            return tuple((1 + s) / ((1 + s) + (k - 1) * (1 - s)) for k in (2, 3))
        return tuple(max(F(1, k), s) for k in (2, 3))

    found = calibrate_policy(policy, utility, max_ratio=target, split=split)
    best = max((n for n in range(201) if ratio(line(n)) <= target), default=None)
    if not found.feasible:
        assert best is None
        if found.settled:
            assert all(ratio((F(n, 20), F(m, 20))) > target for n in range(10, 21) for m in range(7, 21))
        return
    assert ratio(found.keep_probabilities) == found.achieved <= target
    if best is not None and split != "most-truth":
        assert all(keep > least - F(2, 10**12) for keep, least in zip(found.keep_probabilities, line(best), strict=True))


def test_a_least_utility_is_a_floor_for_every_policy() -> None:
    """T4 with the least utility as the floor: no floor is declared, and every policy is covered."""
    for bound in ("exact", "tight", "sharp", "paper"):
        found = calibrate(max_ratio="3/2", groups=2, gamma=4, g_min=1, bound=bound)  # type: ignore[arg-type]
        if bound == "exact":
            assert found.scope == ANY_UTILITY
            assert DECLARED_RANGE.format(m=1, gamma=4, lipschitz=0) in found.assumptions
            continue
        assert found.scope == ANY_POLICY
        assert not any("declared" in text for text in found.assumptions)
        assert "no utility is below 1" in found.assumptions
    exact = calibrate(max_ratio="3/2", groups=2, gamma=4, g_min=1)
    # (1 + 3p)/(1 + 3(1 − p)) = 3/2 at p = 2/3; some policy that never pays less than 1 attains it.
    assert exact.keep_probabilities[0] == F(2, 3)
    assert exact.achieved == F(3, 2)
    declared = calibrate(max_ratio="3/2", groups=2, gamma=4, g_min=1, tau=2)
    assert declared.scope == ANY_UTILITY_FLOORED
    assert any("declared" in text for text in declared.assumptions)


def test_a_global_target_names_independence() -> None:
    found = calibrate(max_log="0.2", quantity="global", groups=3, tau="0.3")
    assert INDEPENDENT in found.assumptions
    assert found.quantity == "global"


def test_a_least_utility_serves_every_policy() -> None:
    found = calibrate(max_ratio="3/2", groups=2, gamma=4, g_min=1, bound="contraction")
    assert found.scope == "any policy behind this filter"
    # (1 + 4e)/(4 + e) = 3/2 at e = 2.
    assert F(2, 3) - F(2, 10**12) < found.keep_probabilities[0] <= F(2, 3)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"max_log": 0, "groups": 2}, "above 0"),
        ({"max_log": -1, "groups": 2}, "at least 0"),
        ({"max_ratio": 1, "groups": 2}, "other than 1"),
        ({"groups": 2}, "no limit was given; give one of max_ratio"),
        ({"max_log": 1, "max_ratio": 2, "groups": 2}, "max_ratio and max_log were given"),
        ({"max_log": "x", "groups": 2}, "not a number"),
        ({"max_log": 1, "groups": 1}, "at least two"),
        ({"max_log": 1, "groups": {}}, "no attribute"),
        ({"max_log": 1, "groups": 2, "gamma": 1, "tau": 2}, "above gamma"),
        ({"max_log": 1, "groups": 2, "gamma": 0}, "gamma is 0"),
        ({"max_log": 1, "groups": 2, "delta": 2}, "from 0 to 1"),
        ({"max_log": 1, "groups": 2, "tau": -1}, "at least 0"),
        ({"max_log": 1, "groups": 2, "bound": "contraction"}, "raw_ratio"),
        ({"max_log": 1, "groups": 2, "raw_ratio": 2}, "contraction"),
        ({"max_log": 1, "groups": 2, "tau": "0.1", "delta": "0.01"}, "the very filter, whose delta is 0"),
        ({"max_log": 1, "groups": 2, "bound": "contraction", "raw_ratio": 2, "tau": "0.1"}, "needs no floor"),
        ({"max_log": 1, "groups": 2, "bound": "contraction", "raw_ratio": 2, "g_min": "0.1"}, "both given"),
        ({"max_log": 1, "groups": 2, "bound": "sharpe"}, "did you mean 'sharp'"),
        ({"max_log": 1, "groups": 2, "split": "equal"}, "split"),
        ({"max_log": 1, "groups": 2, "bound": "sharp", "lipschitz": 1}, "does not depend"),
    ],
)
def test_refusals(options: dict[str, Any], word: str) -> None:
    with pytest.raises(InputError, match=word):
        calibrate(**options)


@pytest.mark.parametrize(
    ("options", "code", "word"),
    [
        (["--max-log", "0.2", "--groups", "16", "--tau", "0.3"], 0, "0.12477"),
        (["--max-log", "0.1,0.2", "--groups", "name=2,age=3", "--tau", "0.3"], 0, "keep probability"),
        (["--max-log", "0.1", "--groups", "3", "--lipschitz", "0.5", "--tau", "0.2"], 1, "INFEASIBLE"),
        (["--max-log", "0.1", "--groups", "3", "--lipschitz", "0.5"], 1, "Without a floor"),
        (["--max-log", "0", "--groups", "3"], 2, "above 0"),
        (["--max-log", "0.1", "--groups", "3,a=2"], 2, "mixes forms"),
        (["--max-log", "0.1", "--groups", "a=2,a=2"], 2, "twice"),
        (["--max-log", "0.1", "--groups", "x"], 2, "not a number"),
        (["--max-log", "0.1", "--groups", "1"], 2, "at least two"),
        (["--max-log", "0.1"], 2, "--groups is missing"),
        (["--max-log", "0.1", "--bound", "policy"], 2, "needs an audit file"),
        (["--max-log", "0.1", "--groups", "2", "--tau", "0.2", "--delta", "0.01"], 2, "whose delta is 0"),
        (["--max-log", "0.1", "--groups", "2", "nothing.toml"], 2, "goes without"),
        (["--max-log", "0.1", "nothing.toml"], 2, "no such file"),
        (["--max-log", "0.1", "--tau", "0.1", "nothing.toml"], 2, "--tau does not go with --bound exact or policy"),
        (["--max-log", "0.1", "--bound", "sharp", "nothing.toml"], 2, "--bound exact, policy or contraction"),
        (["--max-log", "0.1", "--groups", "2", "--tau", "2"], 2, "above gamma"),
        (["--groups", "2"], 2, "--max-log"),
        (["--max-ratio", "5/4", "--groups", "16", "--g-min", "0.1"], 0, "0.102564"),
    ],
)
def test_the_command(capsys: pytest.CaptureFixture[str], options: list[str], code: int, word: str) -> None:
    import re

    try:
        found = main(["calibrate", *options])
    except SystemExit as stop:
        found = stop.code
    out, err = capsys.readouterr()
    assert found == code
    assert re.search(word, err if code == 2 else out), (out, err)
    if code == 2:
        assert out == ""
        assert err.count("\n") == 1


def test_the_command_names_whom_an_audit_file_guards(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every policy by default, the policy of the file by --bound policy."""
    (tmp_path / "policy.csv").write_text("choice,sex,p\nhire,f,0.9\npass,f,0.1\nhire,m,0.2\npass,m,0.8\n")
    audit = tmp_path / "audit.toml"
    audit.write_text(
        '[policy]\ntable = "policy.csv"\ndecision = "choice"\ngroup = "sex"\nprobability = "p"\n[utility]\nvalues = {hire = 1}\n'
    )
    for options, rule, keep, scope in (([], "exact", "2/3", ANY_POLICY), (["--bound", "policy"], "policy", "16/21", THIS_LAW)):
        for measure in ([], ["--global"]):
            assert main(["calibrate", str(audit), "--max-ratio", "2", *options, *measure]) == 0
            said = capsys.readouterr().out
            assert f"by the rule {rule}" in said and scope in said and "paper" not in said
            assert main(["calibrate", str(audit), "--max-ratio", "2", *options, *measure, "--format", "json"]) == 0
            (found,) = result_of(capsys.readouterr().out)["found"]
            assert (found["feasible"], found["rule"], found["keep_probabilities"], found["scope"]) == (True, rule, [keep], scope)


def test_the_command_draws_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    target = tmp_path / "c.png"
    assert main(["calibrate", "--max-log", "0.1,0.2,0.4", "--groups", "16", "--tau", "0.3", "--plot", str(target)]) == 0
    assert target.read_bytes().startswith(b"\x89PNG")
    assert main(["calibrate", "--max-log", "0.1", "--groups", "16", "--plot", str(tmp_path / "c.gif")]) == 2
    assert "ends in" in capsys.readouterr().err
