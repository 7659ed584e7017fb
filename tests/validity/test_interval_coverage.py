"""Coverage by simulation: an interval of confidence 1 − α contains the true ratio in at least that share of repetitions.

Each setting fails only when so many intervals miss that the probability of it, were the coverage exactly 1 − α, is below one in a
million. FAIRAUDIT_FULL=1 runs 2,000 repetitions of each setting.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any

import numpy as np
import pytest
import tiers
from scipy import stats

from fairaudit import Law, Policy, RandomizedResponse, Utility, certify
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.estimated_population import sampled_population_interval
from fairaudit.inference.hypothesis_tests import refute_epsilon
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.table_comparisons import local_comparison

ALPHA = 0.1
ERROR = 1e-6
F = Fraction
Generator = np.random.Generator


def repetitions(reduced: int) -> int:
    return 2_000 if tiers.FULL else reduced


def judge(misses: int, count: int, alpha: float = ALPHA) -> None:
    print(f"coverage {1 - misses / count:.4f} of {count}, at least {1 - alpha} wanted")
    assert stats.binom.sf(misses - 1, count, alpha) >= ERROR, f"{misses} of {count} intervals miss"


def one_block(cells: list[Cell]) -> Comparison:
    return Comparison(tuple(cells), (tuple(((i, F(1)),) for i in range(len(cells))),))


def binary(n: int, k: int) -> Cell:
    return Cell(n, F(k), None, F(0), F(1), True)


def greatest(means: list[float]) -> float:
    return max(1.0, *(a / b if b else inf if a else 1.0 for a, b in permutations(means, 2)))


def covers(found: Any, true: float) -> bool:
    return float(found.lower) * (1 - 1e-9) <= true <= float(found.upper) * (1 + 1e-9)


SETTINGS: dict[str, tuple[list[float], list[int]]] = {
    "equal, 2 cells": ([0.5] * 2, [100] * 2),
    "equal, 10 cells": ([0.3] * 10, [200] * 10),
    "equal, 40 cells": ([0.5] * 40, [50] * 40),
    "1 draw": ([0.5, 0.2], [1, 1]),
    "few draws": ([0.5, 0.5, 0.5], [1, 3, 7]),
    "1000 draws": ([0.45, 0.5], [1000, 1000]),
    "unequal sizes": ([0.5, 0.4, 0.45], [5, 60, 1000]),
    "near 0": ([0.01, 0.02, 0.001], [300, 300, 300]),
    "near 1": ([0.99, 0.995, 1.0], [300, 300, 300]),
    "a zero cell": ([0.0, 0.3], [40, 40]),
    "zero cells only": ([0.0, 0.0], [40, 40]),
    "extremes": ([0.95, 0.05], [30, 30]),
    "40 cells, spread": ([0.1 + 0.02 * i for i in range(40)], [300] * 40),
}


@pytest.mark.parametrize("region", ["box", "sidak", "product"])
@pytest.mark.parametrize("name", SETTINGS)
def test_binary(name: str, region: str) -> None:
    p, n = SETTINGS[name]
    options: dict[str, Any] = {"independent": region != "box", "region": "product" if region == "product" else "box"}
    generator = np.random.default_rng(2026)
    true, misses, count = greatest(p), 0, repetitions(12 if region == "product" else 40)
    for _ in range(count):
        cells = [binary(m, int(k)) for m, k in zip(n, generator.binomial(n, p), strict=True)]
        misses += not covers(ratio_interval(one_block(cells), 1 - ALPHA, **options), true)
    judge(misses, count)


@pytest.mark.parametrize("ends", ["lower", "upper"])
@pytest.mark.parametrize("region", ["box", "product"])
def test_one_sided(region: Any, ends: Any) -> None:
    generator = np.random.default_rng(8)
    misses, count = 0, repetitions(25)
    for _ in range(count):
        cells = [binary(80, int(k)) for k in generator.binomial(80, [0.5, 0.5, 0.5])]
        misses += not covers(ratio_interval(one_block(cells), 1 - ALPHA, ends=ends, region=region, independent=True), 1.0)
    judge(misses, count)


def test_region_chosen_by_sizes() -> None:
    generator = np.random.default_rng(9)
    misses, count = 0, repetitions(30)
    for _ in range(count):
        comparison = one_block([binary(100, int(k)) for k in generator.binomial(100, [0.3, 0.35, 0.4, 0.3])])
        region = default_region(comparison, independent=True)
        misses += not covers(ratio_interval(comparison, 1 - ALPHA, region=region, independent=True), 4 / 3)
    judge(misses, count)


BOUNDED: dict[str, tuple[list[list[float]], float]] = {
    "equal": ([[0.2, 0.3, 0.5]] * 3, 1.0),
    "unequal": ([[0.2, 0.3, 0.5], [0.6, 0.3, 0.1]], 0.65 / 0.25),
    "quiet": ([[0.02, 0.96, 0.02], [0.01, 0.98, 0.01]], 1.0),
    "rare": ([[0.99, 0.0, 0.01], [0.98, 0.01, 0.01]], 0.015 / 0.01),
}


@pytest.mark.parametrize("method", ["hoeffding-kl", "empirical-bernstein", "intersection"])
@pytest.mark.parametrize("name", BOUNDED)
def test_bounded(name: str, method: Any) -> None:
    """Utilities 0, 1/2 and 1."""
    chances, true = BOUNDED[name]
    generator = np.random.default_rng(31)
    misses, count = 0, repetitions(60)
    for i in range(count):
        n = (5, 60, 300)[i % 3]
        cells = []
        for row in chances:
            _, half, one = (int(v) for v in generator.multinomial(n, row))
            cells.append(Cell(n, F(half, 2) + one, F(half, 4) + one, F(0), F(1), False))
        misses += not covers(ratio_interval(one_block(cells), 1 - ALPHA, method=method), true)
    judge(misses, count)


def test_bounded_product() -> None:
    generator = np.random.default_rng(32)
    misses, count = 0, repetitions(30)
    for _ in range(count):
        cells = []
        for _ in range(3):
            _, half, one = (int(v) for v in generator.multinomial(120, [0.2, 0.3, 0.5]))
            cells.append(Cell(120, F(half, 2) + one, None, F(0), F(1), False))
        misses += not covers(ratio_interval(one_block(cells), 1 - ALPHA, region="product", independent=True), 1.0)
    judge(misses, count)


UNITS: dict[str, Callable[[Generator, int], tuple[list[str], list[str], list[int], float]]] = {}


def unit_setting(function: Callable[[Generator, int], tuple[list[str], list[str], list[int], float]]) -> None:
    UNITS[function.__name__] = function


@unit_setting
def one_winner_per_run(generator: Generator, runs: int) -> tuple[list[str], list[str], list[int], float]:
    """Cells share their runs, and are negatively correlated."""
    chances = [0.4, 0.35, 0.25]
    winners = generator.choice(3, size=runs, p=chances)
    groups = ["f", "m", "o"] * runs
    return (
        groups,
        ["yes" if winners[r] == g else "no" for r in range(runs) for g in range(3)],
        [r for r in range(runs) for _ in range(3)],
        1.6,
    )


@unit_setting
def copies_of_one_answer(generator: Generator, runs: int) -> tuple[list[str], list[str], list[int], float]:
    """Each profile gives one answer six times."""
    answers = generator.random(2 * runs) < 0.4
    units = [u for u in range(2 * runs) for _ in range(6)]
    return ["fm"[u % 2] for u in units], ["yes" if answers[u] else "no" for u in units], units, 1.0


@unit_setting
def profiles_of_different_quality(generator: Generator, runs: int) -> tuple[list[str], list[str], list[int], float]:
    """Each profile has a chance of its own, is asked up to four times, and has rows in both cells."""
    quality = generator.beta(0.5, 1.5, size=runs)
    groups, answers, units = [], [], []
    for u in range(runs):
        for a in "fm":
            for _ in range(1 + u % 4):
                groups.append(a)
                answers.append("yes" if generator.random() < quality[u] else "no")
                units.append(u)
    return groups, answers, units, 1.0


def by_unit(table: Any, utility: Utility, **columns: str) -> Comparison:
    law = Law.from_log(table, **columns, unit="run")  # type: ignore[arg-type]
    return local_comparison(law, utility.on(law))


@pytest.mark.parametrize("name", UNITS)
@pytest.mark.parametrize("method", ["hoeffding-kl", "empirical-bernstein"])
def test_dependent_units(name: str, method: Any) -> None:
    generator = np.random.default_rng(77)
    misses, count = 0, repetitions(25)
    for _ in range(count):
        groups, answers, units, true = UNITS[name](generator, 40)
        if "yes" not in answers:
            continue
        table = {"a": groups, "u": answers, "run": units}
        comparison = by_unit(table, Utility({"yes": 1}), decision="u", group="a")
        misses += not covers(ratio_interval(comparison, 1 - ALPHA, method=method), true)
    judge(misses, count)


def test_copies_that_count_as_draws_do_not_cover() -> None:
    """Why units matter: the same table, each row taken for a draw."""
    generator = np.random.default_rng(78)
    misses = 0
    for _ in range(100):
        k = generator.binomial(40, [0.4, 0.4])
        misses += not covers(ratio_interval(one_block([binary(800, 20 * int(v)) for v in k]), 1 - ALPHA), 1.0)
    assert stats.binom.sf(misses - 1, 100, ALPHA) < ERROR


POLICY = {("P", "f"): 0.7, ("P", "m"): 0.4, ("P", "o"): 0.5, ("Q", "f"): 0.2, ("Q", "m"): 0.3, ("Q", "o"): 0.0}


def draw_policy(generator: Generator, n: int, lacking: bool) -> Policy:
    rows: dict[str, list[Any]] = {"x": [], "a": [], "u": [], "n": []}
    for (x, a), p in POLICY.items():
        if lacking and (x, a) == ("Q", "m"):
            continue
        k = int(generator.binomial(n, p))
        for u, m in (("yes", k), ("no", n - k)):
            for name, value in zip("xaun", (x, a, u, m), strict=True):
                rows[name].append(value)
    return Policy.from_counts(rows, decision="u", group="a", context="x", count="n")


GROUP = RandomizedResponse(["f", "m", "o"], keep_probability="0.6")
CONTEXT = RandomizedResponse(["P", "Q"], keep_probability="0.8")
POPULATION = {((x,), (a,)): w for (x, a), w in zip(POLICY, [3, 1, 2, 1, 3, 2], strict=True)}


def induced(x: str, a: str) -> float:
    return sum(float(CONTEXT.probability((x,), (s,)) * GROUP.probability((a,), (b,))) * p for (s, b), p in POLICY.items())


def policy_truth(local: bool) -> float:
    if local:
        return max(greatest([induced(x, a) for a in "fmo"]) for x in "PQ")
    means = []
    for a in "fmo":
        mass = {x: POPULATION[(x,), (a,)] for x in "PQ"}
        means.append(sum(mass[x] * induced(x, a) for x in "PQ") / sum(mass.values()))
    return greatest(means)


@pytest.mark.parametrize("local", [True, False], ids=["local", "global"])
@pytest.mark.parametrize("lacking", [False, True], ids=["", "a cell without draws"])
@pytest.mark.parametrize("independent", [False, True], ids=["bonferroni", "sidak"])
def test_filters_in_front(local: bool, lacking: bool, independent: bool) -> None:
    generator = np.random.default_rng(5)
    misses, count = 0, repetitions(25)
    for i in range(count):
        policy = draw_policy(generator, (10, 80)[i % 2], lacking)
        comparison = policy_comparison(policy, Utility({"yes": 1}), GROUP, CONTEXT, POPULATION, local=local)
        misses += not covers(ratio_interval(comparison, 1 - ALPHA, independent=independent), policy_truth(local))
    judge(misses, count)


def test_sampled_population() -> None:
    generator = np.random.default_rng(6)
    misses, count = 0, repetitions(25)
    for _ in range(count):
        policy = draw_policy(generator, 80, lacking=False)
        comparison = policy_comparison(policy, Utility({"yes": 1}), GROUP, CONTEXT)
        shares = [POPULATION[("P",), (a,)] / (POPULATION[("P",), (a,)] + POPULATION[("Q",), (a,)]) for a in "fmo"]
        first = generator.binomial(60, shares).tolist()
        misses += not covers(sampled_population_interval(comparison, [first, [60 - k for k in first]], 1 - ALPHA), policy_truth(False))
    judge(misses, count)


def test_a_true_epsilon_is_rarely_refuted() -> None:
    """Decisions that come through randomized response at its own ε, from the policy that shows most of it."""
    generator = np.random.default_rng(12)
    refuted, count = 0, repetitions(100)
    for _ in range(count):
        cells = [binary(100, int(k)) for k in generator.binomial(100, [0.75, 0.25])]
        refuted += refute_epsilon(one_block(cells), 3, 1 - ALPHA).refuted
    judge(refuted, count)


def test_a_greatest_utility_that_is_never_drawn() -> None:
    """Yes (1) is rarer than one in a sample, maybe (1/2) is drawn: intervals count yes in, and cover where it was not drawn, too."""
    generator = np.random.default_rng(12)
    chances = {"f": (0.02, 0.02, 0.96), "m": (0.0, 0.02, 0.98)}  # yes, maybe, no: the means are 0.03 and 0.01
    misses = seen = without = 0
    count = repetitions(200)
    for _ in range(count):
        drawn = {a: generator.multinomial(30, p) for a, p in chances.items()}
        rows = [(u, a, int(n)) for a, tally in drawn.items() for u, n in zip(("yes", "maybe", "no"), tally, strict=True) if n]
        if not any(u == "maybe" for u, _, _ in rows):
            continue
        table = dict(zip("uan", map(list, zip(*rows, strict=True)), strict=True))
        found = certify(Law.from_counts(table, decision="u", group="a", count="n"), {"yes": 1, "maybe": "0.5"}, confidence=1 - ALPHA)
        seen += 1
        without += not any(u == "yes" for u, _, _ in rows)
        misses += not covers(found.intervals["local"], 3.0)
    assert without > seen / 3
    judge(misses, seen)
