"""Pairs in time against a plain loop, their ends against plain fractions, and how often they are ever wrong where means move."""

from __future__ import annotations

import json
from fractions import Fraction
from math import inf, pi, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from fairaudit.inference.levels import pair_levels
from fairaudit.inference.pairing import Pairing
from fairaudit.inference.time_pairs import TimePairs, paired_ends

F = Fraction
BETS = [F(1, 2**k) for k in range(1, 8)]
ALPHA = F(1, 20)
DECISIONS = st.lists(st.tuples(st.sampled_from([1, 2, 3]), st.sampled_from([F(0), F(1, 3), F(1)])), max_size=80)


def plain_pairs(decisions: list[tuple[int, Fraction]], one: int, other: int) -> dict[tuple[Fraction, Fraction], int]:
    """What a plain loop pairs, of the decisions from the moment on that both were seen."""
    seen: set[int] = set()
    waiting: tuple[int, Fraction] | None = None
    found: dict[tuple[Fraction, Fraction], int] = {}
    for member, value in decisions:
        seen.add(member)
        if member not in (one, other) or not {one, other} <= seen:
            continue
        if waiting is None:
            waiting = member, value
        elif waiting[0] != member:
            at = (value, waiting[1]) if member == one else (waiting[1], value)
            found[at] = found.get(at, 0) + 1
            waiting = None
    return found


@settings(deadline=None)
@given(DECISIONS, st.integers(0, 80))
def test_tallies_are_those_of_a_plain_loop_and_survive_a_restart(decisions: Any, cut: int) -> None:
    tallies = TimePairs()
    known: list[int] = []
    for number, (member, value) in enumerate(decisions):
        if number == cut:
            tallies = TimePairs(json.loads(json.dumps(tallies.kept())))
            for old in known:
                tallies.join("job", old)
        if member not in known:
            known.append(member)
        tallies.take("job", member, value)
    for one in (1, 2, 3):
        for other in {1, 2, 3} - {one}:
            assert tallies.of(one, other) == plain_pairs(decisions, one, other)


def wealth(tally: dict[tuple[Fraction, Fraction], int], ratio: Fraction, gamma: Fraction) -> Fraction:
    """What was won on average against "the first mean is at least so many times the second one"."""
    total = F(0)
    for bet in BETS:
        product = F(1)
        for (x, y), n in tally.items():
            product *= (1 + bet * (ratio * y - x) / gamma) ** n
        total += product
    return total / len(BETS)


VALUES = [F(0), F(1), F(2)]
TALLIES = st.dictionaries(st.tuples(st.sampled_from(VALUES), st.sampled_from(VALUES)), st.integers(1, 60), max_size=9)


@settings(deadline=None)
@given(TALLIES, st.integers(1, 6), st.sampled_from([F(1, 2), F(1, 20), F(1, 1000)]))
def test_ends_are_the_last_ratios_that_the_bets_exclude(tally: Any, expected: int, alpha: Fraction) -> None:
    tallies = TimePairs([[[1, 2, None, "0", [0, None]]], [[1, 2, [[str(x), str(y), n] for (x, y), n in tally.items()]]]])
    ends = paired_ends(tallies, [[1, 2]], expected, F(2), alpha)
    about = paired_ends(tallies, [[1, 2]], expected, F(2), alpha, exact=False)
    level = pair_levels([[1, 2]], expected, alpha)[0][frozenset((0, 1))]
    forth, back = tally, {(y, x): n for (x, y), n in tally.items()}
    if ends.upper < inf:
        upper = F(ends.upper)
        for one in (forth, back):
            assert wealth(one, upper, F(2)) >= 1 / level
        assert upper == 1 or min(wealth(one, upper * F(9999, 10000), F(2)) for one in (forth, back)) < 1 / level
        assert abs(float(ends.upper) / float(about.upper) - 1) < 1e-5
    if ends.lower > 1:
        higher = forth if ends.pair == (1, 2) else back
        assert wealth({(y, x): n for (x, y), n in higher.items()}, 1 / ends.lower, F(2)) >= 1 / level
        assert abs(float(ends.lower) / float(about.lower) - 1) < 1e-5
    assert 1 <= ends.lower <= ends.upper


def test_a_pair_that_never_came_leaves_the_upper_end_open() -> None:
    tallies = TimePairs()
    for _ in range(500):
        for member in (1, 2):
            tallies.take("job", member, F(1))
    assert paired_ends(tallies, [[1, 2]], 4, F(1), ALPHA).upper < 2
    tallies.take("job", 3, F(1))
    assert paired_ends(tallies, [[1, 2, 3]], 4, F(1), ALPHA).upper == inf
    assert paired_ends(tallies, [[1, 2], [3]], 4, F(1), ALPHA).upper < 2


def paths(streams: int, decisions: int, seed: int, amplitude: float, ratio: float) -> tuple[int, int, int, float]:
    """How often pairs of a seasonal stream ever exclude the true ratio, at level 1/40 an end; and the median pooled ratio, and pairs.

    Arrivals of the group 1 are .5 ± amplitude, means of group 2 are .4 ± .3, in phase; group 1 has `ratio` times that.
    """
    rng = np.random.default_rng(seed)
    too_high = too_low = pairs_seen = 0
    pooled = []
    season = np.array([sin(2 * pi * k / 1000) for k in range(decisions)])
    mean = 0.4 + 0.3 * season
    for _ in range(streams):
        first = rng.random(decisions) < 0.5 + amplitude * season
        values = rng.random(decisions) < np.where(first, ratio, 1) * mean
        pooled.append(values[first].mean() / values[~first].mean())
        pairing, found = Pairing(), []
        for number, (member, value) in enumerate(zip(np.where(first, 1, 2).tolist(), values.tolist(), strict=True)):
            found += [(pair.members, pair.one, pair.other) for pair in pairing.take("", member, value, (number, None))]
        one, other = (np.array([float(first if members[0] == member else second) for members, first, second in found]) for member in (1, 2))
        bets = np.array([float(bet) for bet in BETS])[:, None]
        for below, (x, y, r) in enumerate(((one, other, ratio), (other, one, 1 / ratio))):
            won = np.exp(np.log1p(bets * (r * y - x)).cumsum(axis=1)).mean(axis=0)
            too_low += bool(below and won.max() >= 40)
            too_high += bool(not below and won.max() >= 40)
        pairs_seen += len(found)
    return too_high, too_low, pairs_seen // streams, float(np.median(pooled))


@pytest.mark.parametrize(("amplitude", "ratio"), [(0.4, 1.0), (0.4, 1.25), (0.0, 1.25)])
def test_the_true_ratio_is_ever_excluded_no_more_often_than_stated(amplitude: float, ratio: float) -> None:
    """Groups treated alike, or in a constant ratio, while arrivals and means move together: pooled means are far apart."""
    streams = 300
    too_high, too_low, pairs, pooled = paths(streams, 4_000, 3, amplitude, ratio)
    print(f"arrivals .5 ± {amplitude}, ratio {ratio}: {too_high} + {too_low} of {streams} wrong ({pairs} pairs); pooled {pooled:.3f}")
    for wrong in (too_high, too_low):
        assert binom.sf(wrong - 1, streams, 1 / 40) > 1e-4
    assert abs(pooled / ratio - (1.857 if amplitude else 1)) < 0.1
