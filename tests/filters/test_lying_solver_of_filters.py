"""What a solver says is never believed: designs are exact, on target and truly bounded, or there is none, whatever it says."""

from __future__ import annotations

import random
from fractions import Fraction
from math import inf
from typing import Any

import pytest
import tiers
from lying_solver import LIES, lying

import fairaudit as fa
from fairaudit import InputError, Utility
from fairaudit.filters.design_result import Design
from fairaudit.theorems.t03 import t3_mechanism

F = Fraction
HIRE = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
FAR = "1e310"
"""Beyond floats."""


def some_policy(rng: random.Random, groups: int, contexts: int) -> fa.Policy:
    table = [[[F(rng.randint(0, 12), 12)] for _ in range(groups)] for _ in range(contexts)]
    table = [[[*row, 1 - row[0]] for row in block] for block in table]
    return fa.Policy.from_array(table, decisions=["u", "v"], groups=[f"g{i}" for i in range(groups)])


def worst_ratio(policy: fa.Policy, g: Any, found: Design) -> Any:
    """The worst ratio behind a filter, by its definition."""
    law, mechanism, worst = policy.law, found.mechanism, F(1)
    count = len(law.groups)
    for x in range(len(law.contexts)):
        means = []
        for a, label in enumerate(law.groups):
            total = F(0)
            for j, released in enumerate(law.groups):
                weights = law.row(x * count + j)
                values = [F(w, sum(weights)) * g(u, a) for u, w in zip(law.decisions, weights, strict=True)]
                total += mechanism.probability(label, released) * sum(values)
            means.append(total)
        if max(means) > 0:
            worst = max(worst, inf if min(means) == 0 else max(means) / min(means))
    return worst


def stochastic(found: Design) -> list[list[Fraction]]:
    rows = [[found.mechanism.probability(a, b) for b in found.mechanism.inputs] for a in found.mechanism.inputs]
    assert all(sum(row) == 1 and min(row) >= 0 for row in rows)
    ratios = [F(1), *(max(column) / min(column) if min(column) else inf for column in zip(*rows, strict=True) if max(column))]
    assert found.exp_epsilon == max(ratios)
    assert found.max_exp_epsilon is None or found.exp_epsilon <= found.max_exp_epsilon
    return rows


def cases(number: int) -> tuple[fa.Policy, Any, Any, dict[str, Any]]:
    rng = random.Random(tiers.fresh(number))
    groups = rng.randint(2, 4)
    policy = some_policy(rng, groups, rng.randint(1, 3))
    table = {(u, a): F(rng.randint(1, 6), 6) for u in ("u", "v") for a in range(groups)}
    own = number % 2 == 0

    def g(u: str, a: int) -> Fraction:
        return table[u, a] if own else table[u, 0]

    labels = policy.law.groups
    entries = {
        (u, x, labels[a]): (g(u, a).numerator, g(u, a).denominator) for u in ("u", "v") for x in policy.law.contexts for a in range(groups)
    }
    options: dict[str, Any] = {"max_ratio": rng.choice(["1.05", "1.3", "2"])}
    if rng.random() < 0.5:
        options["max_exp_epsilon"] = rng.choice(["3/2", "4"])
    if rng.random() < 0.5:
        options["distortion"] = [[0 if a == b else rng.randint(0, 4) for b in range(groups)] for a in range(groups)]
    return policy, g, Utility({}, entries) if own else Utility({u: table[u, 0] for u in ("u", "v")}), options


def test_a_known_policy(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(tiers.fresh(7))
    count = 60 if tiers.FULL else 6
    met = refuted = 0
    for number in range(count):
        policy, g, utility, options = cases(number)
        honest = fa.design(policy, utility, **options)
        for way in LIES:
            with monkeypatch.context() as patch:
                lying(patch, rng, way)
                found = fa.design(policy, utility, **options)
            if found.mechanism is not None:
                met += 1
                stochastic(found)
                assert found.achieved == worst_ratio(policy, g, found) <= found.target, (number, way)
                assert honest.feasible or "floating point" in honest.reason, (number, way)
            elif "proved exactly" in found.reason:
                refuted += 1
                assert not honest.feasible, (number, way)
            # A filter that meets the target costs at least what is said that any does.
            for other in (honest, found):
                assert found.lower_bound is None or other.distortion is None or found.lower_bound <= other.distortion, (number, way)
    assert tiers.enough(met > count)
    assert refuted


def test_without_a_policy(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(tiers.fresh(8))
    for number in range(30 if tiers.FULL else 4):
        case = random.Random(tiers.fresh(number))
        size, level = case.randint(2, 4), case.choice([F(1, 5), F(1, 2)])
        options: dict[str, Any] = {"max_ratio": case.choice(["1.2", "1.6"]), "tau": level}
        options["population"] = [case.randint(1, 9) for _ in range(size)]
        if case.random() < 0.5:
            options["max_exp_epsilon"] = 3
        for way in LIES:
            with monkeypatch.context() as patch:
                lying(patch, rng, way)
                found = fa.design_model_free(size, **options)
            stochastic(found)
            assert t3_mechanism(found.mechanism, level, floor="declared").value == found.achieved <= found.target, (number, way)
            with monkeypatch.context() as patch:
                lying(patch, rng, way)
                capped = fa.design_model_free(size, max_exp_epsilon=2, population=options["population"])
            stochastic(capped)
            assert capped.lower_bound is None or capped.lower_bound <= capped.distortion, (number, way)


def test_for_every_policy(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(tiers.fresh(10))
    met = 0
    for number in range(40 if tiers.FULL else 6):
        policy, _, utility, options = cases(number)
        options["max_ratio"] = F(options["max_ratio"]) + number % 3
        calls: list[Any] = [
            lambda p=policy, u=utility, o=options: fa.design_utility(p, u, quantity="global" if o["max_ratio"] > 2 else "local", **o),
            lambda o=options: fa.design_model_free(3, max_ratio=o["max_ratio"], g_min="0.2", population=[1, 2, 4]),
            lambda o=options: fa.design_model_free(
                3, max_ratio=o["max_ratio"], g_min="0.1", tau="0.3", lipschitz="0.01", population=[1, 2, 4]
            ),
        ]
        for call in calls:
            honest = call()
            for way in LIES:
                with monkeypatch.context() as patch:
                    lying(patch, rng, way)
                    found = call()
                assert found.feasible == honest.feasible, (number, way)
                if not found.feasible:
                    continue
                met += 1
                stochastic(found)
                assert found.achieved <= found.target, (number, way)
                for other in (honest, found):
                    assert found.lower_bound is None or found.lower_bound <= other.distortion, (number, way)
    assert met


def test_calibration_asks_no_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    lying(monkeypatch, random.Random(tiers.fresh(9)), "raises")
    found = fa.calibrate(max_ratio="1.4", groups=3, tau="0.3")
    assert found.achieved <= F(7, 5)
    assert fa.calibrate_policy(HIRE, {"hire": 1}, max_ratio=2).achieved <= 2


SMALL = ["1e-310", "1e-2000"]
LARGE = [FAR, "1e2000"]
BARELY = 1 + F(1, 10**400)


@pytest.mark.parametrize(
    "options",
    [
        *({"max_ratio": far} for far in LARGE),
        *({"max_ratio": 2, "distortion": [[0, far], [1, 0]]} for far in (*LARGE, *SMALL)),
        *({"max_ratio": 2, "distortion": [[far, far], [far, far]]} for far in LARGE),
        *({"max_ratio": 2, "max_exp_epsilon": far} for far in LARGE),
        *({"max_ratio": 2, "population": [[1, far]]} for far in (*LARGE, *SMALL)),
        {"max_log": 10_000},
        {"max_epsilon": 10_000},
    ],
)
@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("way", ["honest", "solved"])
def test_numbers_beyond_floats_for_a_known_policy(options: dict[str, Any], own: bool, way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if way != "honest":
        lying(monkeypatch, random.Random(tiers.fresh(1)), way)
    worth: Any = {"hire": 1}
    if own:  # one group gets next to nothing, whatever is decided
        cells = [(u, x, a) for u in HIRE.law.decisions for x in HIRE.law.contexts for a in HIRE.law.groups]
        worth = Utility({}, {cell: (1, 10**400 if cell[2] == ("m",) else 1) for cell in cells})
    for found in (fa.design(HIRE, worth, **options), fa.design_utility(HIRE, worth, **options)):
        if found.mechanism is not None:
            stochastic(found)
            assert found.target is None or found.achieved <= found.target
            assert found.lower_bound is None or found.lower_bound <= found.distortion
        else:
            assert own
            assert found.reason


@pytest.mark.parametrize(
    "options",
    [
        *({"max_ratio": far} for far in LARGE),
        *({"max_ratio": far, "tau": small} for far, small in zip(LARGE, SMALL, strict=True)),
        *({"max_ratio": 2, "tau": small} for small in SMALL),
        *({"max_ratio": 2, "tau": "0.3", "gamma": far} for far in LARGE),
        {"max_ratio": 1 / (F(1, 2) + F(1, 10**400)), "tau": "1/2"},
        {"max_ratio": 2 - F(1, 10**400), "tau": "1/2", "population": [1, 2, 3]},
        *({"max_ratio": "1.2", "tau": "0.3", "distortion": [[0, far, 1], [1, 0, 1], [1, 1, 0]]} for far in LARGE),
        *({"max_ratio": "1.2", "tau": "0.3", "population": [1, 2, far]} for far in (*LARGE, *SMALL)),
        *({"max_exp_epsilon": far, "population": [1, 2, 3]} for far in LARGE),
        *({"max_ratio": far, "g_min": small, "population": [1, 2, 3]} for far, small in zip(LARGE, SMALL, strict=True)),
        *({"max_ratio": 2, "g_min": small, "population": [1, 2, 3]} for small in SMALL),
        *({"max_ratio": 2, "g_min": "0.3", "gamma": far, "population": [1, 2, 3]} for far in LARGE),
        *({"max_ratio": 2, "g_min": small, "tau": "0.3", "population": [1, 2, 3]} for small in SMALL),
        {"max_ratio": BARELY, "g_min": "0.3", "tau": "0.4", "population": [1, 2, 3]},
    ],
)
def test_numbers_beyond_floats_without_a_policy(options: dict[str, Any]) -> None:
    found = fa.design_model_free(3, **options)
    stochastic(found)
    assert found.target is None or found.achieved <= found.target


@pytest.mark.parametrize(
    "options",
    [
        *({"max_ratio": far} for far in LARGE),
        *({"max_ratio": far, "tau": small} for far, small in zip(LARGE, SMALL, strict=True)),
        *({"max_ratio": 2, "tau": small} for small in SMALL),
        *({"max_ratio": 2, "tau": small, "lipschitz": "0.1"} for small in SMALL),
        *({"max_ratio": 2, "tau": small, "lipschitz": "0.1", "bound": "paper", "delta": "0.1"} for small in SMALL),
        *({"max_ratio": 2, "tau": "0.1", "gamma": far} for far in LARGE),
        *({"max_ratio": 2, "bound": "contraction", "raw_ratio": far} for far in LARGE),
        *({"max_ratio": BARELY, "bound": rule, "tau": "0.1"} for rule in ("exact", "sharp", "tight", "paper")),
        *(
            {"max_ratio": 1 + F(1, 10**400), "tau": "0.1", "split": split, "groups": {"a": 2, "b": 3}}
            for split in ("equal-keep", "most-truth")
        ),
        {"max_log": 10_000},
        {"max_log": "1e-400"},
    ],
)
def test_numbers_beyond_floats_in_a_calibration(options: dict[str, Any]) -> None:
    found = fa.calibrate(**{"groups": 3, **options})
    if found.feasible:
        assert found.achieved <= found.target
    else:
        assert found.reason


@pytest.mark.parametrize("far", [*LARGE, BARELY])
@pytest.mark.parametrize("quantity", ["local", "global"])
def test_numbers_beyond_floats_in_a_calibration_for_a_policy(far: Any, quantity: Any) -> None:
    found = fa.calibrate_policy(HIRE, {"hire": 1}, max_ratio=far, quantity=quantity)
    assert found.feasible
    assert found.achieved <= found.target


@pytest.mark.parametrize("far", [FAR, "nan", "inf", "-1"])
def test_what_is_no_number_is_refused(far: str) -> None:
    for options in ({"max_log": far}, {"max_epsilon": far}):
        with pytest.raises(InputError, match="max_"):
            fa.design(HIRE, {"hire": 1}, **options)
