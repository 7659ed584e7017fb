"""Intervals for streams at every moment: how often the truth is ever excluded, and how soon a difference is seen."""

from __future__ import annotations

from fractions import Fraction
from math import log, sqrt
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
import tiers
from scipy.stats import binom

from fairaudit.inference.anytime import Arrivals, stream_interval
from fairaudit.inference.anytime_joint import joint_bets
from fairaudit.inference.betting import log_wealth
from fairaudit.inference.levels import pair_levels, weight
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

STREAMS, EVENTS = (2_000, 10_000) if tiers.FULL else (200, 2_000)
ALPHA = Fraction(1, 20)
UNIT = (Fraction(0), Fraction(1))
NEVER_BY_CHANCE = 0.001  # of a procedure whose error is α, this share would fail the test

# Where the next decision falls, given how far the stream is and what was seen: the probability of the second group.
SCENARIOS: dict[str, tuple[tuple[float, float], Any]] = {
    "equality": ((0.5, 0.5), lambda share, counts, hits: np.full(len(counts), 0.5)),
    "rare events": ((0.004, 0.004), lambda share, counts, hits: np.full(len(counts), 0.5)),
    "drifting arrival": ((0.3, 0.2), lambda share, counts, hits: np.full(len(counts), 0.02 + 0.96 * share)),
    # Whoever looks worse than the truth is asked again, until the record looks good: sampling to a foregone conclusion.
    "optional stopping": ((0.4, 0.4), lambda share, counts, hits: np.where(hits[:, 0] < 0.4 * counts[:, 0], 0.9, 0.1)),
}


def streams(scenario: str, number: int, events: int, rng: np.random.Generator) -> tuple[Any, Any]:
    """Counts and successes of both groups after each event: arrays of streams × events × groups."""
    means, arrival = SCENARIOS[scenario]
    counts, hits = np.zeros((number, 2)), np.zeros((number, 2))
    counted, successes = np.zeros((number, events, 2)), np.zeros((number, events, 2))
    rows = np.arange(number)
    for t in range(events):
        group = (rng.random(number) < arrival(t / events, counts, hits)).astype(int)
        counts[rows, group] += 1
        hits[rows, group] += rng.random(number) < np.array(means)[group]
        counted[:, t], successes[:, t] = counts, hits
    return counted, successes


def log_evidence(counted: Any, successes: Any, mean: float) -> tuple[Any, Any]:
    """Wealth against the true mean, that it is too low and that it is too high, after each event."""
    tallied = np.stack([counted - successes, successes], axis=-1)
    values = np.array([0.0, 1.0])
    return log_wealth(values, tallied, np.array(mean)), log_wealth(1 - values, tallied, np.array(1 - mean))


def ever_excluded(scenario: str, number: int, rng: np.random.Generator) -> tuple[int, int]:
    """Of some streams, how many ever exclude the true pair of means by products, and how many a true mean by a box."""
    means, _ = SCENARIOS[scenario]
    [levels] = pair_levels([[1, 2]], 4, ALPHA)
    need = -log(levels[frozenset((0, 1))])
    box = [-log(ALPHA * weight(rank, 4) / 2) for rank in (1, 2)]
    products = boxes = 0
    for start in range(0, number, 50):
        counted, successes = streams(scenario, min(50, number - start), EVENTS, rng)
        above, below = zip(*(log_evidence(counted[..., a], successes[..., a], means[a]) for a in (0, 1)), strict=True)
        products += int(((above[0] + below[1] >= need) | (above[1] + below[0] >= need)).any(axis=1).sum())
        boxes += int(np.any([(side >= box[a]).any(axis=1) for a in (0, 1) for side in (above[a], below[a])], axis=0).sum())
    return products, boxes


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_truth_is_excluded_in_no_more_streams_than_stated(scenario: str) -> None:
    products, boxes = ever_excluded(scenario, STREAMS, np.random.default_rng([5, len(scenario)]))
    limit = binom.isf(NEVER_BY_CHANCE, STREAMS, float(ALPHA))
    print(f"{scenario}: of {STREAMS} streams of {EVENTS}, excluded by products {products}, by a box {boxes}; limit {limit:.0f}")
    assert products <= limit
    assert boxes <= limit


def joint_excluded(scenario: str, number: int, events: int, rng: np.random.Generator, levels: list[Fraction]) -> list[int]:
    """Of some streams, how many ever exclude the true ratio by joint bets at each level: at the true mean they would."""
    means, _ = SCENARIOS[scenario]
    bets = joint_bets([Fraction(1), Fraction(5, 4)])
    found = [0] * len(levels)
    for start in range(0, number, 50):
        counted, successes = streams(scenario, min(50, number - start), events, rng)
        ever = np.full(counted.shape[:2], -np.inf)
        for i, j in ((0, 1), (1, 0)):
            total = np.full(counted.shape[:2], -np.inf)
            for one, other, share in bets:
                won = np.full(counted.shape[:2], log(share))
                for a, bet in ((i, -float(one)), (j, float(other))):
                    hits, misses = successes[..., a], counted[..., a] - successes[..., a]
                    won += hits * log(1 + bet * (1 - means[a])) + misses * log(1 - bet * means[a])
                total = np.logaddexp(total, won)
            ever = np.maximum(ever, total)
        for k, level in enumerate(levels):
            found[k] += int((ever >= -log(level)).any(axis=1).sum())
    return found


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_joint_bets_exclude_the_truth_in_no_more_streams_than_stated(scenario: str) -> None:
    """At 95 % and, where an error rate is seen, at 50 %."""
    events = EVENTS // 5
    errors = [ALPHA, Fraction(1, 2)]
    levels = [pair_levels([[1, 2]], 1, error)[0][frozenset((0, 1))] for error in errors]
    found = joint_excluded(scenario, STREAMS, events, np.random.default_rng([6, len(scenario)]), levels)
    print(f"{scenario}: of {STREAMS} streams of {events}, excluded by joint bets {found} at errors {[str(error) for error in errors]}")
    for misses, error in zip(found, errors, strict=True):
        assert misses <= binom.isf(NEVER_BY_CHANCE, STREAMS, float(error))


def interval(counts: list[list[int]], joint: bool) -> tuple[float, float]:
    law = Law.from_array(counts, kind="counts", decisions=["no", "yes"], groups=["f", "m"])
    arrivals = Arrivals((((), ("f",)), ((), ("m",))), 4, joint)
    found = stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "local", UNIT, 1 - ALPHA, exact=False)
    return float(found.lower), float(found.upper)


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("joint", [True, False])
def test_an_interval_that_misses_the_ratio_excludes_the_true_means(scenario: str, joint: bool) -> None:
    """What the simulation counts is what the interval does: a level so low that the truth is often excluded shows it."""
    (p, q), _ = SCENARIOS[scenario]
    truth = max(p, q) / min(p, q)
    counted, successes = streams(scenario, 20, 600, np.random.default_rng(11))
    for n, k in zip(counted[:, 59::180].reshape(-1, 2), successes[:, 59::180].reshape(-1, 2), strict=True):
        if not n.all():
            continue
        low, high = interval([[int(n[a] - k[a]), int(k[a])] for a in (0, 1)], joint)
        above, below = zip(*(log_evidence(n[a], k[a], (p, q)[a]) for a in (0, 1)), strict=True)
        [levels] = pair_levels([[1, 2]], 4, ALPHA)
        products = max(above[0] + below[1], above[1] + below[0]) >= -log(levels[frozenset((0, 1))])
        boxes = any(side[a] >= -log(ALPHA * weight(a + 1, 4) / 2) for a in (0, 1) for side in (above, below))
        assert low <= truth <= high or (products if joint else boxes)


def fixed_n(p: float, q: float, alpha: float, power: float) -> float:
    """Decisions per group with which a test of equality at a size known beforehand finds this difference."""
    z = NormalDist().inv_cdf
    return (p * (1 - p) + q * (1 - q)) * (z(1 - alpha / 2) + z(power)) ** 2 / (p - q) ** 2


def detection(p: float, q: float, number: int, rng: np.random.Generator, expected: int = 2) -> Any:
    """Decisions per group after which R > 1 is established, by stream."""
    size = int(8 * fixed_n(p, q, float(ALPHA), 0.8))
    times = np.unique(np.linspace(size / 400, size, 400).astype(int))
    [levels] = pair_levels([[1, 2]], expected, ALPHA)
    need = -log(levels[frozenset((0, 1))])
    hits = [rng.random((number, size)) < mean for mean in (p, q)]
    one, other = (h.cumsum(axis=1)[:, times - 1].astype(float) for h in hits)
    least = np.full(one.shape, np.inf)
    spread = 4 * sqrt(p * (1 - p) / times[0])
    values = np.array([0.0, 1.0])
    for common in np.linspace(max(q / 4, q - spread), min(0.999, p + spread), 160):
        above = log_wealth(values, np.stack([times - one, one], axis=-1), np.array(common))
        below = log_wealth(1 - values, np.stack([times - other, other], axis=-1), np.array(1 - common))
        least = np.minimum(least, above + below)
    found = least >= need
    return np.where(found.any(axis=1), times[found.argmax(axis=1)], size)


@pytest.mark.parametrize(("p", "q"), [(0.6, 0.4), (0.3, 0.2), (0.06, 0.04)])
def test_a_ratio_of_three_halves_is_seen_soon(p: float, q: float) -> None:
    found = detection(p, q, 1_000 if tiers.FULL else 60, np.random.default_rng(3))
    known = fixed_n(p, q, float(ALPHA), 0.8)
    print(f"{p} against {q}: mean {found.mean():.0f}, median {np.median(found):.0f}, 80 % {np.quantile(found, 0.8):.0f}; knew {known:.0f}")
    assert found.mean() <= 2 * known * (1 if tiers.FULL else 1.15)
