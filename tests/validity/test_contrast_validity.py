"""Contrasts of units and of independent cells: how often they err, and how wide they are.

The medians of ends that are expected were simulated by other code.

Each setting fails only when so many miss that the probability of it, were the error exactly its level, is below one in a million.
FAIRAUDIT_FULL=1 runs 2,000 repetitions of each setting, and medians of 400 to 1,000.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import log
from typing import Any

import numpy as np
import pytest
import tiers
from scipy import stats

from fairaudit.inference import paired_betting, symmetric_betting
from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.paired_betting import Contrasts, contrasts, crossing

F = Fraction
Draws = np.ndarray[Any, np.dtype[Any]]
Generator = np.random.Generator
UNIT = (F(0), F(1))


def cell(values: Draws) -> ValueCounts:
    found, counts = np.unique(values, return_counts=True)
    return ValueCounts({F(v): n for v, n in zip(found.astype(np.float64).tolist(), counts.tolist(), strict=True)})


def pair(x: Draws, y: Draws) -> Contrasts:
    found, counts = np.unique(np.array([x, y], dtype=np.float64), axis=1, return_counts=True)
    return Contrasts({(F(a), F(b)): n for a, b, n in zip(*found.tolist(), counts.tolist(), strict=True)})


def judge(misses: int, count: int, level: float) -> None:
    print(f"missed {misses / count:.4f} of {count}, at most {level} wanted")
    assert stats.binom.sf(misses - 1, count, level) >= 1e-6, f"{misses} of {count} miss"


def six(source: Generator, chances: Draws) -> Draws:
    return source.binomial(6, chances) / 6


def repeated(source: Generator, units: int, ratio: float) -> tuple[Draws, Draws]:
    """Six answers for each of two groups, of units that differ in how often it is yes."""
    p = source.uniform(0.2, 1, units)
    return six(source, p), six(source, p / ratio)


Paired = Callable[[Generator], tuple[Draws, Draws]]

PAIRED: dict[str, tuple[Paired, float, float]] = {  # with the true ratio and difference
    "six repeats, one ratio": (lambda s: repeated(s, 100, 1), 1, 0),
    "six repeats, 5/4": (lambda s: repeated(s, 100, 1.25), 1.25, 0.12),
    "rare": (lambda s: (s.random(300) < 0.01, s.random(300) < 0.01), 1, 0),
    "certain": (lambda s: (np.ones(30), s.random(30) < 0.5), 2, 0.5),
    "one unit": (lambda s: (s.random(1) < 0.5, s.random(1) < 0.5), 1, 0),
    "opposed": (lambda s: (lambda u: (u < 0.5, u > 0.5))(s.random(60)), 1, 0),
}

Cells = Callable[[Generator], tuple[Draws, Draws]]

INDEPENDENT: dict[str, tuple[Cells, float, float]] = {
    "three values": (lambda s: tuple(s.choice([0, 0.5, 1], n, p=[0.1, 0.8, 0.1]) for n in (50, 50)), 1, 0),  # type: ignore[dict-item,return-value]
    "skew, unequal": (lambda s: (s.beta(0.5, 3, 80), s.beta(0.5, 3, 25)), 1, 0),
    "skew, unequal, turned": (lambda s: (s.beta(0.5, 3, 25), s.beta(0.5, 3, 80)), 1, 0),
    "5/4": (lambda s: (s.beta(2, 2, 40), s.beta(2, 2, 40) / 1.25), 1.25, 0.1),
    "rare": (lambda s: (s.random(200) < 0.02, s.random(200) < 0.01), 2, 0.01),
    "one draw": (lambda s: (s.random(1), s.random(40)), 1, 0),
}


@pytest.mark.parametrize("claim", ["ratio", "difference"])
@pytest.mark.parametrize("setting", PAIRED)
def test_contrasts_of_units_err_with_at_most_the_level(setting: str, claim: Any) -> None:
    draw, ratio, difference = PAIRED[setting]
    source, count, limit = np.random.default_rng(20), 4_000 if tiers.FULL else 300, ratio if claim == "ratio" else difference
    won = [paired_betting.log_wealth(pair(*draw(source)), limit, claim) for _ in range(count)]
    for level in (0.5, 0.05, 0.025):
        judge(sum(each >= -log(level) for each in won), count, level)


@pytest.mark.parametrize("claim", ["ratio", "difference"])
@pytest.mark.parametrize("setting", INDEPENDENT)
def test_contrasts_of_cells_err_with_at_most_the_level(setting: str, claim: Any) -> None:
    draw, ratio, difference = INDEPENDENT[setting]
    source, count, limit = np.random.default_rng(21), 2_000 if tiers.FULL else 100, ratio if claim == "ratio" else difference
    won = []
    for _ in range(count):
        x, y = draw(source)
        won.append(symmetric_betting.log_wealth(cell(x), cell(y), claim)(limit))
    for level in (0.5, 0.05, 0.025):
        judge(sum(each >= -log(level) for each in won), count, level)


@pytest.mark.parametrize("claim", ["ratio", "difference"])
def test_units_that_are_missing_where_it_hurts_make_no_error(claim: Any) -> None:
    """A refusal is hidden: the unit is missing in the lower group where it got nothing, in the higher one where it got all."""
    source, count, won = np.random.default_rng(22), 4_000 if tiers.FULL else 300, []
    for _ in range(count):
        x, y = (source.random(60) < p for p in (0.6, 0.4))
        profiles: dict[Any, int] = {}
        for a, b in zip(x.tolist(), y.tolist(), strict=True):
            key = (None if a and source.random() < 0.2 else F(a), None if not b and source.random() < 0.2 else F(b))
            profiles[key] = profiles.get(key, 0) + 1
        won.append(paired_betting.log_wealth(contrasts(profiles, 0, 1, UNIT), 1.5 if claim == "ratio" else 0.2, claim))
    for level in (0.5, 0.05):
        judge(sum(each >= -log(level) for each in won), count, level)


@pytest.mark.parametrize(("ratio", "expected"), [(1, 1.119), (1.25, 1.427)])
def test_six_repeats_of_a_hundred_units_are_as_narrow_as_elsewhere(ratio: float, expected: float) -> None:
    source = np.random.default_rng(23)
    pairs = [pair(*repeated(source, 100, ratio)) for _ in range(1_000 if tiers.FULL else 200)]
    ends = [crossing(lambda limit, p=p: paired_betting.log_wealth(p, limit), F(1, 20), "ratio") for p in pairs]  # type: ignore[misc]
    print(f"median {np.median(ends):.4f}, {expected} elsewhere")
    assert np.median(ends) == pytest.approx(expected, rel=0.03)


THREE, SKEW, WIDE = (
    lambda s, n: s.choice([0, 0.5, 1], n, p=[0.1, 0.8, 0.1]),
    lambda s, n: s.beta(0.5, 3, n),
    lambda s, n: s.beta(2, 2, n),
)


@pytest.mark.parametrize(
    ("shape", "ratio", "n", "expected"),
    [
        (THREE, 1, 50, 1.353),
        (THREE, 1, 400, 1.116),
        (SKEW, 1, 50, 2.163),
        (SKEW, 1, 400, 1.326),
        (WIDE, 1.25, 50, 1.611),
        (WIDE, 1.25, 400, 1.363),
    ],
)
def test_contrasts_of_cells_are_as_narrow_as_elsewhere(shape: Any, ratio: float, n: int, expected: float) -> None:
    source = np.random.default_rng(24)
    ends = []
    for _ in range((400 if n == 50 else 200) if tiers.FULL else 100 if n == 50 else 24):
        x, y = cell(shape(source, n)), cell(shape(source, n) / ratio)
        ends.append(max(crossing(symmetric_betting.log_wealth(*cells), F(1, 20), "ratio") for cells in ((x, y), (y, x))))
    print(f"median {np.median(ends):.4f}, {expected} elsewhere")
    assert np.median(ends) == pytest.approx(expected, rel=0.03 if tiers.FULL else 0.06)
