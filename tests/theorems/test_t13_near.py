"""T13 near a policy: against exact linear programs over the balls of total variation, and against bisection.

All 2,000 random deployments: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t13_near.py
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import permutations, product
from math import exp, inf, lcm
from random import Random
from typing import Any

import numpy as np
import pytest
import theorem_oracle
import tiers
from theorem_oracle import F, Row, random_deployment, random_row, ratio, response_rows

from fairaudit.errors import InputError
from fairaudit.exact.enclosures import exp_enclosure
from fairaudit.model.mechanism import Mechanism, RandomizedResponse
from fairaudit.model.policy import Deployment, Policy
from fairaudit.model.utility import Utility, UtilityTable
from fairaudit.theorems import t13_near
from fairaudit.theorems.t13 import greatest_ratio
from fairaudit.theorems.t13_near import DriftRadius, drift_radius, greatest_ratio_near, read_drift

ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")

CASES = 2000 if tiers.FULL else 60
QUANTITIES = ("local", "global")

Weights = dict[tuple[int, int], Row]
"""For every released (x̃,ã) what each decision adds to the expected utility of a group."""


# The definition: plain loops over fractions, and linear programs over all policies of a ball


def pairs(d: theorem_oracle.Deployment, quantity: str) -> Iterator[tuple[Any, Weights, Weights]]:
    """What is compared: where, and p and q of the ordered pair."""
    if quantity == "local":
        for x, (a, b) in product(d.contexts, permutations(d.groups, 2)):
            yield (x, a, b), terms(d, {x: F(1)}, a), terms(d, {x: F(1)}, b)
        return
    present = [a for a in d.groups if any(row[a] for row in d.population)]
    for a, b in permutations(present, 2):
        yield (None, a, b), terms(d, {x: d.share(x, a) for x in d.contexts}, a), terms(d, {x: d.share(x, b) for x in d.contexts}, b)


def terms(d: theorem_oracle.Deployment, shares: dict[int, Fraction], a: int) -> Weights:
    return {
        (xt, at): [sum((w * d.rows_x[x][xt] * d.rows_a[a][at] * d.utility[x][a][u] for x, w in shares.items()), F(0)) for u in d.decisions]
        for xt in range(len(d.policy))
        for at in range(len(d.rows_a[0]))
    }


def total(policy: Weights, weights: Weights) -> Fraction:
    return sum((t * w for o, row in policy.items() for t, w in zip(row, weights[o], strict=True)), F(0))


def own(d: theorem_oracle.Deployment) -> Weights:
    return {(xt, at): row for xt, block in enumerate(d.policy) for at, row in enumerate(block)}


def greatest(policy: Weights, weights: Weights, drift: Fraction) -> Fraction:
    """The greatest total over the ball: mass leaves the decisions of least weight first."""
    gained = total(policy, weights)
    for o, row in policy.items():
        left = drift
        for weight, mass in sorted(zip(weights[o], row, strict=True)):
            part = min(left, mass)
            gained += part * (max(weights[o]) - weight)
            left -= part
    return gained


def mixed(p: Weights, q: Weights, value: Fraction) -> Weights:
    return {o: [v - value * w for v, w in zip(p[o], q[o], strict=True)] for o in p}


def program(policy: Weights, drift: Fraction, target: Weights, one: Weights | None) -> Any:
    """The greatest total over the ball by a linear program, infinity or None; with `one`, over policies times z, which have that total 1.

    Variables are z, and at every o the policy T' and the mass w that it has more than T, all times z.
    """
    cells = [(o, u) for o, row in policy.items() for u in range(len(row))]
    size = 1 + 2 * len(cells)
    found = ppl.MIP_Problem(size)
    z = ppl.Variable(0)
    kept = {cell: ppl.Variable(1 + i) for i, cell in enumerate(cells)}
    more = {cell: ppl.Variable(1 + len(cells) + i) for i, cell in enumerate(cells)}
    for i in range(size):
        found.add_constraint(ppl.Variable(i) >= 0)
    for o, row in policy.items():
        found.add_constraint(sum((kept[o, u] for u in range(len(row))), ppl.Linear_Expression(0)) == z)
        found.add_constraint(
            drift.denominator * sum((more[o, u] for u in range(len(row))), ppl.Linear_Expression(0)) <= drift.numerator * z
        )
        for u, mass in enumerate(row):
            found.add_constraint(mass.denominator * kept[o, u] - mass.numerator * z <= mass.denominator * more[o, u])
    unit, bottom = (z, 1) if one is None else expression(one, kept)
    found.add_constraint(unit == bottom)
    if not found.is_satisfiable():
        return None
    objective, bottom = expression(target, kept)
    found.set_objective_function(objective)
    found.set_optimization_mode("maximization")
    if "UNBOUNDED" in str(found.solve()).upper():
        return inf
    value = found.optimal_value()
    return F(int(value.numerator), int(value.denominator)) / bottom


def expression(weights: Weights, kept: dict[Any, Any]) -> tuple[Any, int]:
    bottom = lcm(*(w.denominator for row in weights.values() for w in row))
    parts = (int(w * bottom) * kept[o, u] for o, row in weights.items() for u, w in enumerate(row) if w)
    return sum(parts, ppl.Linear_Expression(0)), bottom


def best(policy: Weights, drift: Fraction, p: Weights, q: Weights) -> Any:
    """The greatest ratio of one ordered pair over the ball, by linear programs; 0/0 is 1."""
    most = program(policy, drift, p, q)
    if most in (None, inf):
        nothing = {o: [-w for w in row] for o, row in q.items()}
        assert most == inf or program(policy, drift, nothing, None) == 0
        return inf if most == inf or program(policy, drift, p, None) > 0 else F(1)
    return most


# Deployments of the package


def deployed(d: theorem_oracle.Deployment, filtered: bool = True) -> tuple[Deployment, UtilityTable]:
    """The deployment as the package has it; without a context filter if that is the identity."""
    contexts = [f"x{i}" for i in d.contexts]
    released = [f"y{i}" for i in range(len(d.policy))] if filtered else contexts
    decisions = [str(u) for u in d.decisions]
    policy = Policy.from_array(d.policy, decisions=decisions, contexts=released, groups=list(d.mechanism.outputs))
    context = Mechanism.from_array(d.rows_x, contexts, released) if filtered else None
    deployment = policy.behind(group=Mechanism(d.mechanism.factors), context=context, population=d.population)
    values = {
        (str(u), x, a): d.utility[i][j][u]
        for u in d.decisions
        for i, x in enumerate(deployment.contexts)
        for j, a in enumerate(deployment.groups)
    }
    utility = Utility.from_function(lambda u, x, a: values[u, x, a], deployment.law)
    return deployment, utility.on(deployment.law)


def random_drift(rng: Random, d: theorem_oracle.Deployment) -> Fraction:
    masses = [mass for block in d.policy for row in block for mass in row]
    return rng.choice([F(0), F(1), F(1, 20), F(rng.randint(0, 12), 12), rng.choice(masses), F(rng.randint(1, 999), 1000)])


def cases(count: int, name: str) -> Iterator[tuple[Random, theorem_oracle.Deployment, Deployment, UtilityTable]]:
    for seed in range(count):
        rng = Random(tiers.fresh(f"{name} {seed}"))
        d = random_deployment(rng, uses=rng.choice(["decision", "context", "group", "group"]), least=rng.choice([F(0), F(0), F(1, 3)]))
        filtered = rng.random() < 0.6
        if not filtered:
            d.policy = [[random_row(rng, len(d.decisions)) for _ in d.rows_a[0]] for _ in d.contexts]
            d.rows_x = [[F(int(i == j)) for j in d.contexts] for i in d.contexts]
        if rng.random() < 0.3:
            lost = rng.choice(d.groups)
            d.population = [[F(0) if a == lost else m for a, m in enumerate(row)] for row in d.population]
        if len(d.rows_a[0]) == 1 or not any(map(any, d.population)):
            continue
        yield rng, d, *deployed(d, filtered)


def as_weights(d: theorem_oracle.Deployment, rows: Sequence[Row]) -> Weights:
    """Rows over what can be released, back on all outputs; the rest keeps the policy."""
    reach_x = [xt for xt in range(len(d.policy)) if any(row[xt] for row in d.rows_x)]
    reach_a = [at for at in range(len(d.rows_a[0])) if any(row[at] for row in d.rows_a)]
    assert len(rows) == len(reach_x) * len(reach_a)
    return own(d) | dict(zip(product(reach_x, reach_a), map(list, rows), strict=True))


def place(d: theorem_oracle.Deployment, deployment: Deployment, found: Any) -> tuple[int | None, int, int]:
    context = None if found.context is None else deployment.contexts.index(found.context)
    return context, deployment.groups.index(found.higher), deployment.groups.index(found.lower)


# The example of the theory page


def example(keep: str = "3/4") -> tuple[Deployment, UtilityTable]:
    policy = Policy.from_array([["1/2", "1/4", "1/4"], ["1/4", "1/4", "1/2"]], decisions=["a", "b", "c"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability=keep), population=[[1, 1]])
    return deployment, Utility({"a": 4, "b": 2, "c": 1}).on(deployment.law)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_example_of_the_theory_page(quantity: Any) -> None:
    none = greatest_ratio_near(*example(), quantity, 0)
    every = greatest_ratio_near(*example(), quantity, 1)
    assert none is not None
    assert every is not None
    assert (none.value, every.value) == (F(41, 35), F(13, 7))
    assert none.rows == ((F(1, 2), F(1, 4), F(1, 4)), (F(1, 4), F(1, 4), F(1, 2)))
    assert every.rows == ((1, 0, 0), (0, 0, 1))
    assert (every.higher, every.lower, every.context) == (("f",), ("m",), () if quantity == "local" else None)


def test_the_radius_of_the_example_by_hand() -> None:
    """(7/16)(11/4 + 3η) = (11/16)(2 − 3η) at η = 11/216; and exceeding 8/7 < 41/35: (13/28)(11/4 − 3η) = (17/28)(2 + 3η) at η = 7/360."""
    assert drift_radius(*example(), "local", "5/4", "ratio") == DriftRadius("within", F(11, 216), always=False)
    assert drift_radius(*example(), "local", "13/7", "ratio") == DriftRadius("within", F(1), always=True)
    assert drift_radius(*example(), "local", "41/35", "ratio") == DriftRadius("within", F(0), always=False)
    assert drift_radius(*example(), "local", "8/7", "ratio") == DriftRadius("exceeds", F(7, 360), always=False, exact=False)


# Against linear programs


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_it_is_the_optimum_of_a_linear_program_and_the_policy_attains_it(quantity: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(t13_near, "FEW", 1)
    seen = {"infinite": 0, "one": 0, "between": 0}
    for rng, d, deployment, utility in cases(CASES, f"programs {quantity}"):
        drift = random_drift(rng, d)
        found = greatest_ratio_near(deployment, utility, quantity, drift)
        compared = {where: (p, q) for where, p, q in pairs(d, quantity)}
        if not compared:
            assert found is None
            continue
        assert found is not None
        assert found.exact
        policy = own(d)
        expected = max(best(policy, drift, p, q) for p, q in compared.values())
        assert found.value == max(expected, 1)
        seen["infinite" if found.value == inf else "one" if found.value == 1 else "between"] += 1
        if found.value == 1:
            assert (found.context, found.higher, found.lower, found.rows) == (None, None, None, ())
            continue
        attaining = as_weights(d, found.rows)
        for o, row in attaining.items():
            assert min(row) >= 0
            assert sum(row) == 1
            assert sum(abs(v - w) for v, w in zip(row, policy[o], strict=True)) <= 2 * drift
        where = place(d, deployment, found)
        p, q = compared[where]
        assert ratio(total(attaining, p), total(attaining, q)) == found.value
        ties = [pair for pair, (v, w) in compared.items() if best(policy, drift, v, w) == found.value]
        assert where == ties[0]
    assert tiers.enough(min(seen.values()) > CASES // 60)


def test_without_drift_it_is_the_ratio_of_the_policy_and_it_grows_with_the_drift() -> None:
    for _, d, deployment, utility in cases(40, "ends"):
        for quantity, measured in (("local", d.local), ("global", None)):
            values = [greatest_ratio_near(deployment, utility, quantity, drift) for drift in (0, "1/10", "1/2", 1)]  # type: ignore[arg-type]
            if values[0] is None:
                continue
            numbers = [found.value for found in values if found]
            assert numbers == sorted(numbers)
            assert measured is None or numbers[0] == measured


def test_with_full_drift_every_pair_of_deterministic_policies_is_covered() -> None:
    for _, d, deployment, utility in cases(25, "deterministic"):
        reached = list(own(d))
        if len(d.decisions) ** len(reached) > 64:
            continue
        for quantity in QUANTITIES:
            found = greatest_ratio_near(deployment, utility, quantity, 1)  # type: ignore[arg-type]
            values = [F(1)]
            for choice in product(d.decisions, repeat=len(reached)):
                policy = {o: [F(int(u == v)) for v in d.decisions] for o, u in zip(reached, choice, strict=True)}
                values += [ratio(total(policy, p), total(policy, q)) for _, p, q in pairs(d, quantity)]
            assert (found.value if found else 1) == max(values)


# Radii


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_radius_is_where_the_verdict_changes(quantity: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(t13_near, "FEW", 1)
    seen = {"within": 0, "exceeds": 0, "always": 0}
    tiny = F(1, 10**9)
    for rng, d, deployment, utility in cases(CASES, f"radius {quantity}"):
        policy = own(d)
        compared = list(pairs(d, quantity))
        ratios = [ratio(total(policy, p), total(policy, q)) for _, p, q in compared]
        most = greatest_ratio_near(deployment, utility, quantity, 1)
        near = [value for value in (*ratios, most.value if most else 1) if 1 <= value < inf]
        limit = rng.choice(
            [*near, F(rng.randint(10, 60), 10), F(rng.randint(100, 150), 100), *(1 + (v - 1) * F(rng.randint(1, 19), 10) for v in near)]
        )
        found = drift_radius(deployment, utility, quantity, limit, "ratio")
        if not compared:
            assert found == DriftRadius("inconclusive", F(0), always=False)
            continue
        assert found.verdict == ("within" if max(ratios) <= limit else "exceeds")
        seen["always" if found.always else found.verdict] += 1

        stands = partial(every_policy, policy, [mixed(p, q, limit) for _, p, q in compared], found.verdict)
        assert found.exact == (found.verdict == "within" or found.always)
        if found.always:
            assert found.radius == 1
            assert stands(F(1))
            continue
        assert found.radius < 1 or found.verdict == "exceeds"
        low, high = F(0), F(1)
        for _ in range(12):
            middle = (low + high) / 2
            low, high = (middle, high) if stands(middle) else (low, middle)
        assert abs(low - found.radius) <= F(1, 2**11)
        assert stands(found.radius) == (found.verdict == "within")
        assert not stands(min(found.radius + tiny, F(1)))
        assert found.radius == 0 or stands(found.radius * (1 - tiny))
        if found.verdict == "exceeds" and found.radius:
            assert all(exceeding(rng, d, compared, limit, found.radius * (1 - tiny)) for _ in range(5))
    assert tiers.enough(min(seen.values()) > CASES // 60)


def every_policy(policy: Weights, differences: Sequence[Weights], verdict: str, drift: Fraction) -> bool:
    """Whether p − R*q is at most 0 for all pairs and policies of the ball; or above 0 for all policies, with one and the same pair."""
    if verdict == "within":
        return all(greatest(policy, weights, drift) <= 0 for weights in differences)
    reverse = ({o: [-w for w in row] for o, row in weights.items()} for weights in differences)
    return any(greatest(policy, weights, drift) < 0 for weights in reverse)


def exceeding(rng: Random, d: theorem_oracle.Deployment, compared: Sequence[Any], limit: Fraction, drift: Fraction) -> bool:
    """Whether a random policy within the drift exceeds the limit."""
    policy = {o: [(1 - drift) * v + drift * w for v, w in zip(row, random_row(rng, len(row)), strict=True)] for o, row in own(d).items()}
    return any(ratio(total(policy, p), total(policy, q)) > limit for _, p, q in compared)


def test_a_limit_on_the_logarithm_is_rounded_inward() -> None:
    seen = set()
    for rng, _, deployment, utility in cases(60, "logarithms"):
        log = F(rng.randint(1, 80), 100)
        found = drift_radius(deployment, utility, "local", log, "log")
        around = [drift_radius(deployment, utility, "local", F(exp(log)) * (1 + F(sign, 10**14)), "ratio") for sign in (-1, 1)]
        assert {found.verdict} == {each.verdict for each in around}
        assert found.always == around[0].always == around[1].always
        low, high = sorted(each.radius for each in around)
        assert low - F(2, 10**12) <= found.radius <= high
        assert not found.exact or found.always
        seen.add((found.verdict, found.always))
    assert tiers.enough({verdict for verdict, _ in seen} == {"within", "exceeds"})


@pytest.mark.parametrize("above", [0, 1])
def test_a_limit_as_close_as_60_digits_to_the_greatest_ratio_is_told_from_it(above: int) -> None:
    """Groups are seen, one decision is worth 1 and one √e, rounded down or up: every policy is within √e, or not."""
    worth = Fraction(exp_enclosure((1, 2), 200)[above], 1 << 200)
    policy = Policy.from_array([["1/2", "1/2"], ["1/2", "1/2"]], decisions=["yes", "no"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="1"))
    found = drift_radius(deployment, Utility({"yes": worth, "no": 1}).on(deployment.law), "local", "1/2", "log")
    assert (found.verdict, found.always) == ("within", not above)
    assert (found.radius == 1, found.exact) == (not above, not above)


def test_parity_of_nothing_is_not_infinite_without_drift() -> None:
    """Both groups get nothing, and some other decision gives one of them something: 0/0 is 1, and infinite as soon as anything moves."""
    policy = Policy.from_array([["1", "0"], ["1", "0"]], decisions=["no", "yes"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="3/4"))
    utility = Utility.from_function(lambda u, x, a: int(u == "yes" and a == ("f",)), deployment.law).on(deployment.law)
    found = [greatest_ratio_near(deployment, utility, "local", drift) for drift in (0, "1/1000")]
    assert [each and each.value for each in found] == [1, inf]
    assert found[1] is not None
    assert (found[1].higher, found[1].lower) == (("f",), ("m",))
    assert drift_radius(deployment, utility, "local", 10**9, "ratio") == DriftRadius("within", F(0), always=False)


def test_a_limit_of_parity_and_one_beyond_all_numbers() -> None:
    assert drift_radius(*example(), "local", 0, "log") == drift_radius(*example(), "local", 1, "ratio")
    assert drift_radius(*example(), "local", 10**6, "log") == DriftRadius("within", F(1), always=True)
    policy = Policy.from_array([["1", "0"], ["0", "1"]], decisions=["yes", "no"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="1"))
    utility = Utility({"yes": 1}).on(deployment.law)
    assert drift_radius(deployment, utility, "local", 10**6, "log") == DriftRadius("exceeds", F(0), always=False, exact=False)
    assert drift_radius(deployment, utility, "local", 2, "ratio") == DriftRadius("exceeds", F(1, 3), always=False, exact=False)


# Numbers and sizes


def test_floats_that_cannot_tell_leave_the_decision_to_integers() -> None:
    """Utilities and odds of very different sizes: ratios far beyond what floats resolve."""
    for seed in range(12 if CASES < 1000 else 200):
        rng = Random(tiers.fresh(f"wide {seed}"))
        d = random_deployment(rng, uses=rng.choice(["decision", "context", "group"]), masses=False)
        d.utility = [[[v * F(10) ** rng.randint(-200, 200) for v in row] for row in block] for block in d.utility]
        keep = rng.choice([F(1, 2), 1 - F(1, 10**30), F(1, 10**400), F(3, 4) + F(1, 10**17)])
        d.rows_a, d.mechanism = response_rows(2, keep), RandomizedResponse([0, 1], keep_probability=keep)
        d.policy = [[random_row(rng, len(d.decisions)) for _ in range(2)] for _ in d.policy]
        d.utility = [(block * 2)[:2] for block in d.utility]
        d.population = [(row * 2)[:2] for row in d.population]
        deployment, utility = deployed(d)
        drift = rng.choice([F(0), F(1), F(1, 10**50), F(1, 7)])
        for quantity in QUANTITIES:
            found = greatest_ratio_near(deployment, utility, quantity, drift)  # type: ignore[arg-type]
            assert found is not None
            policy, value = own(d), found.value
            if value == inf:
                attaining = as_weights(d, found.rows)
                p, q = {where: (v, w) for where, v, w in pairs(d, quantity)}[place(d, deployment, found)]
                assert (total(attaining, p) > 0, total(attaining, q)) == (True, 0)
                continue
            tops = [greatest(policy, mixed(p, q, F(value)), drift) for _, p, q in pairs(d, quantity)]
            assert max(tops) == 0 if value > 1 else max(tops) <= 0


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_floats_with_their_slack_enclose_what_integers_give(quantity: Any) -> None:
    tight = 0
    for rng, d, deployment, utility in cases(40, "enclosures"):
        found = t13_near._comparison(deployment, utility, quantity)
        if found is None:
            continue
        limit, drift = F(rng.randint(100, 400), 100), random_drift(rng, d)
        everything = np.arange(len(found.pairs))
        for weights in ((limit.denominator, -limit.numerator), (-limit.denominator, limit.numerator)):
            middle, slack = found.screen(everything, weights, drift)
            sums, _ = found.sums(everything, weights, drift)
            for float_sum, error, exact in zip(middle.tolist(), slack.tolist(), sums.tolist(), strict=True):
                assert 0 < error < 1e-10
                assert (exact > 0) <= (float_sum + error > 0)
                assert (exact < 0) <= (float_sum - error < 0)
                tight += exact != 0 and abs(float_sum) > error
    assert tiers.enough(tight > 100)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_a_bound_without_sorting_is_one_and_often_rules_pairs_out(quantity: Any) -> None:
    useful = 0
    for rng, d, deployment, utility in cases(80, "rough bounds"):
        found = t13_near._comparison(deployment, utility, quantity)
        if found is None:
            continue
        limit, drift = F(rng.randint(100, 400), 100), random_drift(rng, d)
        everything = np.arange(len(found.pairs))
        for sign, weights in ((1, (limit.denominator, -limit.numerator)), (-1, (-limit.denominator, limit.numerator))):
            bound, sizes = found.rough(everything, weights, drift, sign)
            middle, slack = found.screen(everything, weights, drift)
            assert (sizes > 0).all()
            sums, _ = found.sums(everything, weights, drift)
            assert all(high > 0 for high, exact in zip(bound.tolist(), sums.tolist(), strict=True) if sign * exact > 0)
            assert (bound >= sign * middle - 2 * slack).all()
            useful += int((bound <= 0).sum())
    assert tiers.enough(useful > 100)


def test_decisions_that_only_the_utility_names_can_be_moved_to() -> None:
    policy = Policy.from_array([["1/2", "1/2"], ["1/2", "1/2"]], decisions=["no", "later"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="3/4"))
    found = greatest_ratio_near(deployment, Utility({"yes": 1, "no": 0, "later": 1}).on(deployment.law), "local", "1/4")
    assert found is not None
    assert found.value == (F(3, 4) * F(3, 4) + F(1, 4) * F(1, 4)) / (F(1, 4) * F(3, 4) + F(3, 4) * F(1, 4))
    assert [len(row) for row in found.rows] == [3, 3]


def test_a_utility_with_gaps_is_no_reason_to_guess() -> None:
    policy = Policy.from_array([["1", "0"], ["1/2", "1/2"]], decisions=["yes", "no"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="1"))
    utility = Utility({}, {("yes", (), ("f",)): (2, 1), ("yes", (), ("m",)): (1, 1), ("no", (), ("m",)): (3, 1)}).on(deployment.law)
    assert greatest_ratio_near(deployment, utility, "local", "1/2") is None
    assert drift_radius(deployment, utility, "local", 1, "ratio") == DriftRadius("within", F(0), always=False, exact=False)


def test_several_releases_are_refused() -> None:
    policy = Policy.from_array([["1/2", "1/2"], ["1/4", "3/4"]], decisions=["yes", "no"], groups=["f", "m"])
    deployment = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="3/4"), releases=2)
    utility = Utility({"yes": 1}).on(deployment.law)
    with pytest.raises(InputError, match="sees 2"):
        greatest_ratio_near(deployment, utility, "local", 0)
    with pytest.raises(InputError, match="sees 2"):
        drift_radius(deployment, utility, "local", 2, "ratio")


def test_every_policy_is_what_the_largest_drift_allows() -> None:
    for _, _, deployment, utility in cases(CASES, "all policies"):
        for quantity in QUANTITIES:
            near = greatest_ratio_near(deployment, utility, quantity, 1)  # type: ignore[arg-type]
            every = greatest_ratio(deployment, utility, quantity)  # type: ignore[arg-type]
            assert (near and near.value) == (every and every.value)


def test_many_pairs_that_attain_it_are_told_in_order() -> None:
    """Randomized response is symmetric: all 30 pairs of all contexts attain the same, and the first is named."""
    labels = [str(i) for i in range(6)]
    table = np.full((4, 6, 2), Fraction(1, 2))
    policy = Policy.from_array(table, decisions=["yes", "no"], groups=labels)
    deployment = policy.behind(group=RandomizedResponse(labels, keep_probability="1/2"))
    found = greatest_ratio_near(deployment, Utility({"yes": 3, "no": 1}).on(deployment.law), "local", "1/8")
    assert found is not None
    up, down, keep, lie = 2 + F(1, 4), 2 - F(1, 4), F(1, 2), F(1, 10)
    assert found.value == (keep * up + (1 - keep) * down) / (lie * up + (1 - lie) * down)
    assert (found.context, found.higher, found.lower) == (("0",), ("0",), ("1",))


@pytest.mark.parametrize(("value", "says"), [("3/2", "0 to 1"), (-1, "at least 0"), ("x", "not a number"), (float("nan"), "finite")])
def test_what_is_no_total_variation_is_refused(value: Any, says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_drift(value)
    with pytest.raises(InputError, match=says):
        greatest_ratio_near(*example(), "local", value)
