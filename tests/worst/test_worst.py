"""The worst utility of a class, against exact linear programs, a checker of the evidence, and a solver that lies."""

from __future__ import annotations

import json
import random
import statistics
from fractions import Fraction
from itertools import permutations, product
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tiers
from envelopes import result_of
from lying_solver import LIES, lying
from worst_oracle import CLASSES, Oracle, certificate_or_none, checks, instance, random_law, solve_or_none

from fairaudit import InputError, Law
from fairaudit.audits.worst_utility import certify_worst_case
from fairaudit.cli import main
from fairaudit.measures.ratios import local_supremum
from fairaudit.model.utility_class import Ball, Family, UtilityClass
from fairaudit.worst.methods import worst_case

F = Fraction
INSTANCES = 500 if tiers.FULL else 24
"""Random instances per class; all 500: FAIRAUDIT_FULL=1 pytest -n0 tests/worst"""


@pytest.mark.parametrize("kind", CLASSES)
def test_contains_the_exact_optimum(kind: str) -> None:
    gaps = []
    for number in range(INSTANCES):
        law, of, quantity = instance(kind, number, 50)
        found = solve_or_none(law, of, quantity)
        truth = Oracle(law, of, quantity).worst()
        if found is None:
            assert truth is None, number
            continue
        assert found.lower <= truth <= found.upper, number
        if kind == "range":
            assert found.lower == truth == found.upper
            assert found.method == "closed form"
        gaps.append(found.gap)
        document = json.loads(json.dumps(certificate_or_none(found)))
        assert document is None or checks(document), number
    assert statistics.median(gaps) <= 1e-9
    print(f"{kind}: {len(gaps)} instances, {sum(gap == 0 for gap in gaps)} exact, greatest gap {max(gaps):.2g}")


# The closed form


def neyman_pearson(p: list[Fraction], q: list[Fraction], of: UtilityClass) -> Fraction:
    """T4 by its one-k form: the least of k + max(0, (γ−m)·H_k − (k−1)·m)/τ over all k, at the places where that bends."""
    tau = of.floor
    if tau == of.gamma:
        return F(1)
    width = of.gamma - of.m

    def bound(k: Fraction) -> Fraction:
        stick = sum((max(F(0), v - k * w) for v, w in zip(p, q, strict=True)), F(0))
        return k + max(F(0), width * stick - (k - 1) * of.m) / tau

    bends = sorted({F(0), *(v / w for v, w in zip(p, q, strict=True) if w)})
    ends = [bound(k) for k in bends]
    for k in bends:  # where the positive part begins, on the piece to the right of each bend
        top = sum((v for v, w in zip(p, q, strict=True) if v > k * w), F(0))
        bottom = sum((w for v, w in zip(p, q, strict=True) if v > k * w), F(0))
        if width * bottom + of.m:
            root = (width * top + of.m) / (width * bottom + of.m)
            ends.append(bound(root) if root >= k else ends[0])
    return max(F(1), min(ends))


def test_closed_form_on_random_laws() -> None:
    rng = random.Random(tiers.fresh(3))
    for number in range(1500 if tiers.FULL else 300):
        law = random_law(rng, (rng.randint(1, 4), rng.randint(2, 5), rng.randint(2, 7)))
        of = UtilityClass(
            m=rng.choice([F(0), F(1, 7), F(1, 2), F(1)]),
            tau=rng.choice([F(1, 1000), F(1, 7), F(1, 2), F(99, 100), F(1)]),
            tau_on=rng.choice(["all", "pair"]),
        )
        quantity: Any = rng.choice(["local", "global"])
        found = worst_case(law, of, quantity)
        oracle = Oracle(law, of, quantity)
        truth = F(1)
        for block in oracle.blocks():
            for high, low in permutations(block, 2):
                p, q = oracle.mean(high), oracle.mean(low)
                keys = list({*p, *q})
                truth = max(truth, neyman_pearson([p.get(k, F(0)) for k in keys], [q.get(k, F(0)) for k in keys], of))
        assert found.upper == truth == found.lower, number
        assert checks(certify_worst_case(found).document), number


@pytest.mark.parametrize("n", [20, 1000])
def test_closed_form_is_exact_for_long_rows(n: int) -> None:
    rng = random.Random(tiers.fresh(n))
    for tau, m in ((F(1, 3), F(0)), (F(1, 50), F(1, 100)), (F(9, 10), F(1, 10))):
        table = [[rng.randint(0, 10**6) for _ in range(n)] for _ in range(3)]
        law = Law.from_array(table, kind="counts")
        of = UtilityClass(m=m, tau=tau)
        found = worst_case(law, of)
        rows = [[F(v, sum(row)) for v in row] for row in table]
        truth = max(best_threshold(rows[i], rows[j], of) for i, j in permutations(range(3), 2))
        assert found.lower == found.upper == truth


def best_threshold(p: list[Fraction], q: list[Fraction], of: UtilityClass) -> Fraction:
    """T3 and T4 along the Neyman–Pearson curve."""
    order = sorted(range(len(p)), key=lambda j: p[j] / q[j] if q[j] else F(10**9999), reverse=True)
    start = (of.floor - of.m) / (of.gamma - of.m)
    width, s, power, best = of.gamma - of.m, F(0), F(0), F(1)
    for j in order:
        if s <= start <= s + q[j]:
            share = (start - s) / q[j] if q[j] else F(1)
            best = max(best, (of.m + width * (power + share * p[j])) / (of.m + width * start))
        s, power = s + q[j], power + p[j]
        if s >= start:
            best = max(best, (of.m + width * power) / (of.m + width * s))
    return best


@pytest.mark.parametrize("kind", ["counts", "float", "wide"])
def test_equal_and_nearly_equal_rows(kind: str) -> None:
    if kind == "float":
        table: Any = np.array([[[0.1, 0.9], [0.1, 0.9]], [[0.1, 0.9], [0.1 + 2**-50, 0.9 - 2**-50]]])
        law = Law.from_array(table, kind="probabilities")
    else:
        big = 10**30 if kind == "wide" else 10**9
        law = Law.from_array([[[big, big], [2 * big, 2 * big]], [[big, big], [big + 1, big]]], kind="counts")
    found = worst_case(law, UtilityClass(tau="1/2"))
    assert found.lower == found.upper > 1
    assert checks(certify_worst_case(found).document)
    same = worst_case(Law.from_array([[1, 2], [2, 4]], kind="counts"), UtilityClass(tau="1/2"))
    assert (same.lower, same.upper) == (1, 1)
    assert checks(certify_worst_case(same).document)


@pytest.mark.parametrize("tau", ["1e-200", "1e-310", "1e-2000"])
def test_a_tiny_floor(tau: str) -> None:
    law = Law.from_array([[3, 1, 0], [1, 1, 5], [0, 2, 2]], kind="counts")
    found = worst_case(law, UtilityClass(tau=tau))
    assert found.lower == found.upper == F(3, 4) / F(tau) + F(1, 2)
    assert checks(certify_worst_case(found).document)


def test_weights_of_every_size() -> None:
    rng = random.Random(tiers.fresh(6))
    for number in range(60):
        table = [[rng.choice([0.0, 1.0, 10.0 ** rng.randint(-300, 300), rng.random()]) for _ in range(4)] for _ in range(3)]
        table = [row if any(row) else [1.0] * 4 for row in table]
        law = Law.from_array([[table[i], table[(i + 1) % 3]] for i in range(3)], kind="counts")
        of = UtilityClass(tau=rng.choice([F(1, 10**12), F(1, 3), F(1)]), m=rng.choice([0, F(1, 10**20), F(1, 4)]))
        found = worst_case(law, of)
        rows = [[F(v) / sum(map(F, row)) for v in row] for row in table]
        pairs = [(i, (i + 1) % 3) for i in range(3)]
        truth = max([F(1), *(best_threshold(rows[i], rows[j], of) for pair in pairs for i, j in (pair, pair[::-1]) if of.floor < 1)])
        assert found.lower == found.upper == truth, number
        assert checks(certify_worst_case(found).document)


# Relations, infinite answers


def test_lipschitz_constant_zero_is_blind() -> None:
    rng = random.Random(tiers.fresh(8))
    for _ in range(40):
        law = random_law(rng, (rng.randint(1, 2), rng.randint(2, 3), rng.randint(2, 5)))
        tau = rng.choice([None, F(1, 5), F(1, 2)])
        for quantity in ("local", "global"):
            blind = worst_case(law, UtilityClass(tau=tau), quantity)
            other = worst_case(law, UtilityClass(tau=tau, blind=False, lipschitz=0), quantity)
            assert (blind.lower, blind.upper) == (other.lower, other.upper)


def test_without_a_floor_it_is_the_supremum() -> None:
    rng = random.Random(tiers.fresh(9))
    for _ in range(40):
        law = random_law(rng, (2, 3, 4))
        found, known = worst_case(law, UtilityClass()), local_supremum(law)
        assert known is not None
        assert found.lower == found.upper == known.ratio
        assert checks(certify_worst_case(found).document)


@pytest.mark.parametrize(
    "of",
    [
        UtilityClass(),
        UtilityClass(order=["a", "c"]),
        UtilityClass(blind=False, lipschitz="1/100"),
        UtilityClass(blind=False),
        UtilityClass(rows=[({"a": 1, "c": -1}, 0)]),
        UtilityClass(family=Family({"one": {"a": 1}, "two": {"b": 1, "c": 2}}, 0, "1/2")),
        UtilityClass(tau=0, order=["a", "c"]),
    ],
)
@pytest.mark.parametrize("quantity", ["local", "global"])
def test_infinite_with_a_witness(of: UtilityClass, quantity: Any) -> None:
    law = Law.from_array([[0, 1, 3], [2, 2, 0]], kind="counts", decisions=["a", "b", "c"])
    found = worst_case(law, of, quantity)
    assert found.upper == found.lower == inf
    assert found.witness.expectations[0] > 0 == found.witness.expectations[1]
    assert found.gap == 0
    document = certify_worst_case(found).document
    assert document["metrics"][quantity]["ratio"] == document["claims"][-1]["value"] == "inf"
    assert checks(document)


def test_global_against_all_vertices() -> None:
    """The floor cuts edges of the box: every optimum lies on an edge between two 0/1 utilities."""
    rng = random.Random(tiers.fresh(4))
    for _ in range(30):
        law = random_law(rng, (2, 2, 3))
        tau = rng.choice([F(1, 10), F(1, 3), F(3, 4)])
        oracle = Oracle(law, UtilityClass(tau=tau), "global")
        best = F(1)
        for high, low in permutations(law.global_groups, 2):
            p, q = oracle.mean(high), oracle.mean(low)
            keys = sorted({*p, *q})
            for free in range(len(keys)):
                for bits in product((0, 1), repeat=len(keys) - 1):
                    g = dict(zip([k for k in keys if k != keys[free]], map(F, bits), strict=True))
                    top, bottom = (sum((v[k] * g[k] for k in g if k in v), F(0)) for v in (p, q))
                    slope = q.get(keys[free], F(0))
                    for t in {F(0), F(1)} | ({(tau - bottom) / slope} if slope else set()):
                        if 0 <= t <= 1 and bottom + t * slope >= tau:
                            best = max(best, (top + t * p.get(keys[free], F(0))) / (bottom + t * slope))
        found = worst_case(law, UtilityClass(tau=tau), "global")
        assert found.lower == found.upper == best
        same = worst_case(law, UtilityClass(tau=tau, order=[(law.decisions[0], law.decisions[0])]), "global")
        assert same.method == "lp"
        assert same.lower == same.upper == best


def test_a_cycle_makes_decisions_equal() -> None:
    law = Law.from_array([[3, 1, 2], [1, 1, 4]], kind="counts", decisions=["a", "b", "c"])
    merged = Law.from_array([[4, 2], [2, 4]], kind="counts", decisions=["ab", "c"])
    one = worst_case(law, UtilityClass(tau="1/4", order=[("a", "b"), ("b", "a")]))
    assert one.lower == one.upper == worst_case(merged, UtilityClass(tau="1/4")).upper


def test_the_example_of_the_page() -> None:
    """A monotone utility cannot be as unfair as any utility."""
    law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    assert worst_case(law, UtilityClass(tau="1/4")).upper == 2
    found = worst_case(law, UtilityClass(tau="3/4", order=["no", "yes"]))
    assert (found.lower, found.upper) == (F(7, 6), F(7, 6))
    assert found.utility.values == {"yes": F(1), "no": F(1, 2)}
    assert found.witness.expectations == (F(7, 8), F(3, 4))


# A solver that lies


def test_a_lying_solver_never_makes_a_false_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(tiers.fresh(11))
    kinds = [kind for kind in CLASSES if kind != "range"]
    cases = []
    for number in range(8 if tiers.FULL else 2):
        for kind in kinds:
            law, of, quantity = instance(kind, 6 * number + 1, 6)
            cases.append((law, of, quantity, Oracle(law, of, quantity).worst()))
    refused = loose = 0
    total = 10_000 if tiers.FULL else 600
    for number in range(total):
        way = LIES[number % len(LIES)]
        law, of, quantity, truth = cases[number // len(LIES) % len(cases)]
        lying(monkeypatch, rng, way)
        try:
            found = worst_case(law, of, quantity)
        except InputError as error:
            assert truth is None or "exactly in the class" in str(error), (number, way)
            refused += 1
            continue
        assert truth is not None
        assert found.lower <= truth <= found.upper, (number, way)
        loose += found.gap > 1e-9
        try:
            document = certify_worst_case(found).document
        except InputError:
            refused += 1
            continue
        if number % 5 == 0:
            assert checks(document), (number, way)
    print(f"{total} lies: {refused} refusals, {loose} loose answers, no false claim")


# Bad input


TWO = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
THREE = Law.from_array([[3, 1], [1, 1], [1, 2]], kind="counts", decisions=["yes", "no"], groups=["f", "m", "o"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"tau": 2}, "the floor 2 lies outside"),
        ({"tau": -1}, "lies outside"),
        ({"m": 2}, "holds no utilities"),
        ({"gamma": 0}, "holds no utilities"),
        ({"m": -1}, "holds no utilities"),
        ({"gamma": inf}, "gamma: inf is not a finite number"),
        ({"gamma": "many"}, "gamma: 'many' is not a number"),
        ({"tau_on": "both"}, "use 'all' or 'pair'"),
        ({"lipschitz": 1}, "set blind=False"),
        ({"lipschitz": -1, "blind": False}, "is negative"),
        ({"order": ["yes"]}, "names one decision"),
        ({"order": [("yes", "no", "no")]}, "is not a pair"),
        ({"order": ["yes", "nope"]}, "'nope', which does not occur"),
        ({"rows": [({"maybe": 1}, 1)]}, "'maybe', which does not occur"),
        ({"rows": [({("yes", "x"): 1}, 1)]}, "names the context ('x',), which does not occur"),
        ({"rows": [({("yes", None, "f"): 1}, 1)]}, "but the class is blind"),
        ({"rows": [({"yes": 1}, 1)], "blind": False}, "names no group"),
        ({"rows": [({("yes", None, "q"): 1}, 1)], "blind": False}, "which has no decisions"),
        ({"rows": [({"yes": 1}, "1/4"), ({"yes": -1}, "-1/2")]}, "contradict each other"),
        ({"rows": [({"yes": 1, "no": 1}, "1/2")], "tau": "0.9"}, "contradict each other or the floor"),
        ({"metric": lambda a, b: 1}, "a metric goes with a Lipschitz constant"),
    ],
)
def test_bad_classes(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        worst_case(TWO, UtilityClass(**options))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("metric", "said"),
    [
        (
            [[0, 1, 3], [1, 0, 1], [3, 1, 0]],
            "triangle inequality: {'group': 'f'} to {'group': 'o'} is 3, but through {'group': 'm'} it is 1 + 1",
        ),
        ([[0, 1, 1], [2, 0, 1], [1, 1, 0]], "not symmetric: 1 from {'group': 'f'} to {'group': 'm'}, but 2 back"),
        ([[0, 0, 1], [0, 0, 1], [1, 1, 0]], "the distance 0 from {'group': 'f'} to {'group': 'm'}"),
        ([[1, 1, 1], [1, 0, 1], [1, 1, 0]], "the distance 1 from {'group': 'f'} to {'group': 'f'}"),
        ([[0, 1], [1, 0]], "square table over the 3 groups"),
        (lambda a, b: "far", "the metric: 'far' is not a number"),
    ],
)
def test_what_is_not_a_metric(metric: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        worst_case(THREE, UtilityClass(blind=False, lipschitz=1, metric=metric))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (({},), "has no features"),
        (({"a": {}}, 1, 0), "no utility is in the class"),
        (({"a": {}}, {"b": 1}), "no bound for 'a'"),
        (({"a": {}}, 0, inf), "is not a finite number"),
        (({"a": {}}, 0, 1, [({"b": 1}, 1)]), "a row of the family names 'b'"),
        (({"a": {"maybe": 1}},), "'maybe', which does not occur"),
        (({"a": lambda u, x, a: int(a == ("f",))},), "but the class is blind"),
        (({"a": {"yes": 2}}, 1, 1), "contradict each other"),
    ],
)
def test_bad_families(arguments: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        worst_case(TWO, UtilityClass(family=Family(*arguments)))
    assert said in str(caught.value)


def test_what_cannot_be_compared() -> None:
    apart = Law.from_array([[[1, 1], [0, 0]], [[0, 0], [1, 1]]], kind="counts")
    with pytest.raises(InputError, match="no context has two groups"):
        worst_case(apart, UtilityClass())
    probabilities = Law.from_array([[[0.5, 0.5], [0.25, 0.75]], [[0, 0], [0.5, 0.5]]])
    with pytest.raises(InputError, match="global ratio is undefined"):
        worst_case(probabilities, UtilityClass(), "global")
    with pytest.raises(InputError, match="use 'local' or 'global'"):
        worst_case(TWO, UtilityClass(), "both")  # type: ignore[arg-type]


# Classes from cvxpy, and balls


SLOTS = Law.from_array([[[3, 1, 2], [1, 1, 4]], [[2, 2, 1], [1, 1, 1]]], kind="counts", decisions=["a", "b", "c"], contexts=["x", "y"])


def test_rows_from_cvxpy() -> None:
    import cvxpy as cp

    g = cp.Variable((2, 3))
    constraints = [g[0, 0] <= 0.5, g[1, 0] - g[1, 1] >= -0.125, cp.sum(g[0]) == 1, g[:, 2] <= g[:, 1], 2 * (g[0, 0] + 1) - 3 <= g[1, 2]]
    of = UtilityClass.from_cvxpy(SLOTS, g, constraints, tau="1/4")
    same = UtilityClass(
        tau="1/4",
        rows=[
            ({("a", "x"): 1}, "1/2"),
            ({("a", "y"): -1, ("b", "y"): 1}, "1/8"),
            ({("a", "x"): 1, ("b", "x"): 1, ("c", "x"): 1}, 1),
            ({("a", "x"): -1, ("b", "x"): -1, ("c", "x"): -1}, -1),
            ({("b", "x"): -1, ("c", "x"): 1}, 0),
            ({("b", "y"): -1, ("c", "y"): 1}, 0),
            ({("a", "x"): 2, ("c", "y"): -1}, 1),
        ],
    )
    assert [({t[:3]: t[3] for t in row.terms}, row.bound) for row in of.rows] == [
        ({t[:3]: t[3] for t in row.terms}, row.bound) for row in same.rows
    ]
    found, other = worst_case(SLOTS, of), worst_case(SLOTS, same)
    assert found.lower == found.upper == other.upper == Oracle(SLOTS, of, "local").worst()
    assert checks(certify_worst_case(found).document)


def test_coefficients_from_cvxpy_are_the_floats_that_they_are() -> None:
    import cvxpy as cp

    g = cp.Variable((4, 3))
    of = UtilityClass.from_cvxpy(SLOTS, g, [0.1 * g[1, 2] <= 0.3], blind=False)
    assert of.rows[0].terms == ((("x",), ("1",), "c", F(0.1)),)
    assert of.rows[0].bound == F(0.3)


def test_what_is_not_linear() -> None:
    import cvxpy as cp

    g, other = cp.Variable((2, 3)), cp.Variable()
    for bad, said in (
        (cp.abs(g[0, 0]) <= 1, "'abs("),
        (cp.sum_squares(g) <= 1, "is not affine"),
        (cp.sqrt(g[0, 0]) >= 1, "is not affine"),
        (g[0, 0] + other <= 1, "is not one on the utility alone"),
        (cp.SOC(g[0, 0], g[1]), "is not affine"),
    ):
        with pytest.raises(InputError) as caught:
            UtilityClass.from_cvxpy(SLOTS, g, [bad])
        assert said in str(caught.value)
    with pytest.raises(InputError, match="it must be"):
        UtilityClass.from_cvxpy(SLOTS, cp.Variable((3, 2)), [])
    with pytest.raises(InputError, match="has attributes"):
        UtilityClass.from_cvxpy(SLOTS, cp.Variable((2, 3), nonneg=True), [])


@pytest.mark.parametrize("divergence", ["chi2", "kl"])
@pytest.mark.parametrize("radius", ["0.01", "0.1", "1"])
def test_ball(divergence: Any, radius: str) -> None:
    reference = {"a": 1, "b": "1/2", "c": "0.7"}
    of = UtilityClass(gamma=3, tau="1/4", ball=Ball(reference, radius, divergence))
    found = worst_case(SLOTS, of)
    assert found.method == "conic"
    assert not found.certified
    assert 1 < found.lower <= found.upper
    assert found.estimate == pytest.approx(float(found.lower), rel=1e-5)
    table = found.utility.on(SLOTS)
    for cell in range(4):
        g = [float(F(v, table.scale)) for v in table.row(cell)]
        centre = [1.0, 0.5, 0.7]
        if divergence == "chi2":
            spread = sum((v - w) ** 2 / w for v, w in zip(g, centre, strict=True))
        else:
            spread = sum(v * float(np.log(v / w)) - v + w if v else w for v, w in zip(g, centre, strict=True))
        assert spread <= float(F(radius)) + 1e-12
    rng = random.Random(tiers.fresh(radius))
    for _ in range(200):  # no utility of the ball exceeds the bound
        g = [F(w) * F(rng.randint(500, 1500), 1000) for w in reference.values()]
        spread = sum(float((v - F(w)) ** 2 / F(w)) for v, w in zip(g, reference.values(), strict=True))
        if divergence == "chi2" and spread <= float(F(radius)):
            means = [
                [sum(F(int(c)) * v for c, v in zip(row, g, strict=True)) / int(sum(row)) for row in SLOTS.weights[i : i + 2]]
                for i in (0, 2)
            ]
            assert all(max(m) / min(m) <= found.upper for m in means)


@pytest.mark.parametrize(
    ("ball", "said"),
    [
        (lambda: Ball({"a": 1}, -1), "is negative"),
        (lambda: Ball({"a": 1}, 1, "tv"), "use 'chi2' or 'kl'"),  # type: ignore[arg-type]
        (lambda: Ball({"a": 1}, 1), "not positive for every decision"),
    ],
)
def test_bad_balls(ball: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        worst_case(SLOTS, UtilityClass(ball=ball()))
    assert said in str(caught.value)


# The command


TABLE = "dept,sex,grade,n\n" + "".join(
    f"{dept},{sex},{grade},{n}\n"
    for (dept, sex), counts in {("A", "f"): (1, 2, 3), ("A", "m"): (3, 2, 1), ("B", "f"): (2, 2, 2), ("B", "m"): (2, 3, 2)}.items()
    for grade, n in zip(("low", "mid", "high"), counts, strict=True)
)


@pytest.fixture
def table(tmp_path: Path) -> str:
    path = tmp_path / "table.csv"
    path.write_text(TABLE)
    return str(path)


ROLES = ["--decision", "grade", "--group", "sex", "--context", "dept", "--count", "n"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--tau", "0.3"], "closed form"),
        (["--tau", "0.3", "--tau-on", "pair"], "closed form"),
        (["--tau", "0.3", "--order", "low,mid,high"], "linear programs"),
        (["--tau", "0.3", "--not-blind", "--lipschitz", "0.1"], "linear programs"),
        (["--tau", "0.3", "--not-blind", "--lipschitz", "0.1", "--global"], "linear programs"),
        (["--not-blind"], "infinite"),
        (["--g-min", "1", "--gamma", "1"], "No utility of the class tells any two groups apart"),
    ],
)
def test_command(options: list[str], said: str, table: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = str(tmp_path / "certificate.json")
    assert main(["worst-case", table, *ROLES, *options, "-o", output]) == 0
    printed = capsys.readouterr().out
    assert said in printed
    assert "fairaudit verify" in printed
    assert checks(json.loads(Path(output).read_text()))
    assert main(["worst-case", table, *ROLES, *options, "--format", "json"]) == 0
    entry = result_of(capsys.readouterr().out)
    assert checks(entry["certificate"])
    assert entry["upper"] == entry["certificate"]["claims"][-1]["value"]


def test_command_says_what_stands_behind_the_pair(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Spellings, hardly any decisions, and what was left out, as certify says them."""
    path = tmp_path / "log.csv"
    path.write_text("answer,race\n" + "yes,Black\n" * 4 + "no,BLACK\n" * 3 + "yes,White\nno,White\n" * 20 + ",White\nyes,\n")
    args = ["worst-case", str(path), "--decision", "answer", "--group", "race", "--missing", "drop", "--tau", "0.1"]
    assert main(args) == 0
    told = capsys.readouterr().out
    assert told.startswith("SPELLINGS    column 'race': 'BLACK' and 'Black'")
    assert "Only 3 decisions stand behind race=BLACK and 4 decisions behind race=Black. race=BLACK is favoured over race=Black" in told
    assert "(n = 3 and 4)" in told
    assert "  - 2 of 49 decisions have a missing label and were left out ('answer': 1, 'race': 1; by group: 'White' 1 of 41)\n" in told
    assert "2 of 49 decisions have a missing label and were left out; they are taken to be no different from the others" in told
    assert main([*args, "--fold-labels"]) == 0
    told = capsys.readouterr().out
    assert "SPELLINGS" not in told and "in column 'race', 'BLACK' counts as 'Black'" in told


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--tau", "2"], "the floor 2 lies outside"),
        (["--order", "low"], "names fewer than two decisions"),
        (["--order", "low,best"], "'best', which does not occur"),
        (["--lipschitz", "1"], "set blind=False"),
        (["--weight", "n"], "--weight goes with --probability"),
        (["--no-table"], "--no-table needs -o FILE"),
    ],
)
def test_command_with_bad_input(options: list[str], said: str, table: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["worst-case", table, *ROLES, *options]) == 2
    assert said in capsys.readouterr().err
