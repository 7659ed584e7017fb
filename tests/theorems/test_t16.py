"""T16: how far cells may move while a verdict stands, against the dual of each linear program and laws that attain it."""

from __future__ import annotations

import os
import random
from collections.abc import Callable
from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any, Literal

import pytest
import tiers

import fairaudit as fa
from fairaudit.measures.ratios import global_fairness, local_fairness
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.theorems.t16 import Moving, can_drift, differing, drifted_extremes, law_radius, moved_row

F = Fraction
CASES = int(os.environ.get("FAIRAUDIT_DRIFT_CASES", "150"))
"""Random tables of each kind; what the documentation says was found with 2,000."""

Ends = Callable[[int, Fraction], tuple[Fraction, Fraction]]
Form = Literal["radius", "factor"]


def by_dual(p: list[Fraction], g: list[Fraction], form: Form, amount: Fraction) -> tuple[Fraction, Fraction]:
    """Least and greatest expectation, as the optima of the dual programs, which are at a threshold that is a utility."""
    expected = sum(x * y for x, y in zip(p, g, strict=True))

    def greatest(g: list[Fraction], expected: Fraction) -> Fraction:
        if form == "radius":
            return min(expected + amount * (max(g) - t) + sum(x * max(0, t - y) for x, y in zip(p, g, strict=True)) for t in g)
        return min(t + sum(x * (amount * max(0, y - t) - max(0, t - y) / amount) for x, y in zip(p, g, strict=True)) for t in g)

    return -greatest([-y for y in g], -expected), greatest(g, expected)


class Table:
    """A random table, with its rows as fractions."""

    def __init__(self, pick: random.Random) -> None:
        contexts, groups, decisions = pick.choice([1, 1, 2, 3]), pick.choice([2, 2, 3]), pick.choice([2, 2, 3, 4])
        rows = [[self.row(pick, decisions) for _ in range(groups)] for _ in range(contexts)]
        population: dict[Any, Any] = {}
        names = [f"x{i}" for i in range(contexts)], [f"a{i}" for i in range(groups)]
        if kind := pick.randrange(3):
            masses = [[pick.choice([0, 1, 1, 2, 5]) if kind == 2 else pick.randint(1, 4) for _ in range(groups)] for _ in range(contexts)]
            if not any(map(any, masses)):
                masses[0][0] = 1
            population = {"population": masses}
        self.law = Law.from_array(
            [[[str(p) for p in row] for row in part] for part in rows],
            decisions=[f"u{i}" for i in range(decisions)],
            groups=names[1],
            contexts=names[0],
            **population,
        )
        values = [F(pick.choice([0, 0, 1, 1, 2, 3])) for _ in range(decisions)]
        if pick.random() < 0.3:
            worth = {}
            for x in names[0]:
                for a in names[1]:
                    for i in range(decisions):
                        worth[f"u{i}", (x,), (a,)] = F(pick.choice([0, 1, 2, 3]))
            utility = fa.Utility.from_function(lambda u, x, a: worth[u, tuple(x), tuple(a)], self.law)
            self.g = [[[worth[f"u{i}", (x,), (a,)] for i in range(decisions)] for a in names[1]] for x in names[0]]
        else:
            utility = fa.Utility({f"u{i}": v for i, v in enumerate(values)})
            self.g = [[values for _ in names[1]] for _ in names[0]]
        self.table: UtilityTable = utility.on(self.law)
        self.rows = rows
        self.masses = population.get("population", [[1] * groups for _ in range(contexts)])

    @staticmethod
    def row(pick: random.Random, decisions: int) -> list[Fraction]:
        weights = [pick.choice([0, 0, 1, 1, 2, 3, 7]) for _ in range(decisions)]
        weights[pick.randrange(decisions)] += 1
        return [F(w, sum(weights)) for w in weights]

    def blocks(self, quantity: str, form: Form, amount: Fraction) -> list[dict[int, tuple[Fraction, Fraction]]]:
        """Ends of what is compared, by dual programs."""
        ends = [
            [by_dual(p, g, form, amount) for p, g in zip(rows, values, strict=True)] for rows, values in zip(self.rows, self.g, strict=True)
        ]
        if quantity == "local":
            return [dict(enumerate(block)) for block in ends]
        means: dict[int, tuple[Fraction, Fraction]] = {}
        for a in range(len(self.rows[0])):
            total = sum(masses[a] for masses in self.masses)
            if total:
                weighted = [(F(masses[a], total), block[a]) for masses, block in zip(self.masses, ends, strict=True)]
                means[a] = sum((w * e[0] for w, e in weighted), F(0)), sum((w * e[1] for w, e in weighted), F(0))
        return [means]

    def worst(self, quantity: str, form: Form, amount: Fraction) -> Fraction | float:
        return max(ratio(block[a][1], block[b][0]) for block in self.blocks(quantity, form, amount) for a, b in permutations(block, 2))

    def best(self, quantity: str, form: Form, amount: Fraction) -> Fraction | float:
        found = [ratio(block[a][0], block[b][1]) for block in self.blocks(quantity, form, amount) for a, b in permutations(block, 2)]
        return max([F(1), *found])


def ratio(top: Fraction, bottom: Fraction) -> Fraction | float:
    return F(1) if top == bottom == 0 else inf if bottom == 0 else top / bottom


def tables(seed: int) -> list[Table]:
    pick = random.Random(tiers.fresh(seed))
    return [Table(pick) for _ in range(CASES)]


@pytest.mark.parametrize("quantity", ["local", "global"])
@pytest.mark.parametrize("form", ["radius", "factor"])
def test_a_radius_is_where_the_verdict_flips(quantity: Literal["local", "global"], form: Form) -> None:
    seen = dict.fromkeys(("within", "exceeds", "never", "rounded", "exact"), 0)
    for i, made in enumerate(tables(1)):
        measured = (local_fairness if quantity == "local" else global_fairness)(made.law, made.table)
        if measured is None:
            continue
        pick = random.Random(tiers.fresh(i))
        for limit in (F(pick.choice([1, 1, 2, 3, 4]), pick.choice([1, 2, 3])), measured.ratio):
            if limit < 1 or limit == inf:
                continue
            assert isinstance(limit, Fraction)
            found = law_radius(Moving(made.law, made.table, quantity), measured.ratio, limit, "ratio", form)
            assert found.verdict == ("within" if measured.ratio <= limit else "exceeds")
            extreme = made.worst if found.verdict == "within" else made.best
            seen[found.verdict] += 1
            if found.value == inf:
                seen["never"] += 1
                far = F(1) if form == "radius" else F(10**9)
                assert (extreme(quantity, form, far) <= limit) == (found.verdict == "within")
                continue
            assert isinstance(found.value, Fraction)
            seen["exact" if found.exact else "rounded"] += 1
            at, tiny = found.value, F(1, 10**9)
            assert (F(0) <= at <= 1) if form == "radius" else at >= 1
            if found.verdict == "within":
                assert extreme(quantity, form, at) <= limit < extreme(quantity, form, at * (1 + tiny) + tiny)
                if found.exact and at > (form == "factor"):  # at first 0/0 can become infinite at once
                    assert extreme(quantity, form, at) == limit
            else:
                before = at - tiny * at
                if before > (0 if form == "radius" else 1):
                    assert extreme(quantity, form, before) > limit
                if found.exact:
                    assert extreme(quantity, form, at) <= limit  # less where 0/0 is 1
                else:
                    assert extreme(quantity, form, at) > limit >= extreme(quantity, form, at * (1 + tiny))
    assert tiers.enough(all(seen[name] for name in seen if (form, name) != ("radius", "rounded"))), seen


@pytest.mark.parametrize("quantity", ["local", "global"])
def test_a_radius_of_a_limit_on_the_logarithm_is_rounded_inwards(quantity: Literal["local", "global"]) -> None:
    from fairaudit.exact.enclosures import compare_log

    for made in tables(2)[: CASES // 3]:
        measured = (local_fairness if quantity == "local" else global_fairness)(made.law, made.table)
        if measured is None:
            continue
        for form in ("radius", "factor"):
            limit = F(1, 3)
            found = law_radius(Moving(made.law, made.table, quantity), measured.ratio, limit, "log", form)
            if found.value == inf:
                continue
            assert isinstance(found.value, Fraction) and not found.exact
            before = found.value if found.verdict == "within" else found.value * (1 - F(1, 10**9))
            if before < (form == "factor"):
                continue
            beyond = min(found.value + F(1, 10**9), F(1)) if form == "radius" else found.value * (1 + F(1, 10**9))
            for amount, same in ((before, True), (beyond, False)):
                extreme = (made.worst if found.verdict == "within" else made.best)(quantity, form, amount)
                pair = (1, 0) if extreme == inf else F(extreme).as_integer_ratio()
                within = compare_log(pair, (1, 3)) <= 0
                assert (within == (found.verdict == "within")) is same


@pytest.mark.parametrize("quantity", ["local", "global"])
def test_worst_and_best_within_a_drift(quantity: Literal["local", "global"]) -> None:
    for i, made in enumerate(tables(3)):
        drift = F(random.Random(tiers.fresh(i)).choice([0, 1, 2, 5, 20]), 20)
        found = drifted_extremes(Moving(made.law, made.table, quantity), drift)
        if found is None:
            continue
        worst, best = found
        assert worst.value == made.worst(quantity, "radius", drift)
        assert best.value == made.best(quantity, "radius", drift)
        if drift == 0:
            measured = (local_fairness if quantity == "local" else global_fairness)(made.law, made.table)
            assert measured is not None and worst.value == best.value == measured.ratio


def test_moved_laws_are_near_and_attain_the_ends() -> None:
    pick = random.Random(tiers.fresh(4))
    for _ in range(10 * CASES):
        decisions = pick.choice([2, 3, 4])
        weights, values = [pick.choice([0, 1, 1, 2, 7]) for _ in range(decisions)], [pick.choice([0, 1, 2]) for _ in range(decisions)]
        weights[0] += 1
        p, g = [F(w, sum(weights)) for w in weights], list(map(F, values))
        for form, amount in (("radius", F(pick.randint(0, 10), 10)), ("factor", F(pick.randint(10, 90), 10))):
            low, high = by_dual(p, g, form, amount)
            for up, end in ((True, high), (False, low)):
                moved = moved_row(weights, values, form, amount, up=up)
                assert sum(moved) == 1 and min(moved) >= 0
                assert sum(x * y for x, y in zip(moved, g, strict=True)) == end
                if form == "radius":
                    assert differing(p, moved) <= amount
                else:
                    assert all(x / amount <= y <= amount * x for x, y in zip(p, moved, strict=True))


def test_the_examples_of_the_page() -> None:
    law = Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["a", "b"])
    table = fa.Utility({"yes": 1}).on(law)
    measured = local_fairness(law, table)
    assert measured is not None
    found = law_radius(Moving(law, table, "local"), measured.ratio, F(2), "ratio", "radius")
    assert (found.value, found.exact, found.pair) == (F(1, 10), True, (0, 1))
    quarter = Law.from_array([["1/4", "3/4"], ["1/4", "3/4"]], decisions=["yes", "no"], groups=["a", "b"])
    table = fa.Utility({"yes": 1}).on(quarter)
    measured = local_fairness(quarter, table)
    assert measured is not None
    found = law_radius(Moving(quarter, table, "local"), measured.ratio, F(2), "ratio", "factor")
    assert isinstance(found.value, Fraction) and not found.exact
    assert found.value**2 <= 2 < (found.value + F(2, 10**12)) ** 2


def test_drift_is_not_measured_where_a_utility_is_not_given() -> None:
    table = {"d": ["yes", "no", "yes"], "sex": ["f", "f", "m"], "n": [1, 1, 2], "worth": [1, 0, 1]}
    law = Law.from_counts({k: table[k] for k in ("d", "sex", "n")}, decision="d", group="sex", count="n")
    utility = fa.Utility({"yes": 1}).on(law)
    assert can_drift(law, utility, "local") and can_drift(law, utility, "global")
