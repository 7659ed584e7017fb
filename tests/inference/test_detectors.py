"""Change by an e-detector: its sums against plain fractions, its memory, and how often and how soon it raises an alarm."""

from __future__ import annotations

import json
from fractions import Fraction
from statistics import mean, median
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from fairaudit.inference.detectors import BETS, ONE, Detection, Detector, ratio_above

F = Fraction
VALUES = [F(0), F(1, 3), F(1)]
DECISIONS = st.lists(st.tuples(st.sampled_from([1, 2, 3]), st.sampled_from(VALUES)), max_size=60)


def sums(decisions: list[tuple[int, Fraction]], limit: Fraction) -> dict[tuple[int, int, int], Fraction]:
    """The sums by their definition: for each moment k the product of all bets since, added up.

    Pairs are found by a plain loop over what came once both had been seen.
    """
    found = {}
    members = sorted({member for member, _ in decisions})
    for one in members:
        for other in members:
            waiting: list[tuple[int, Fraction]] = []
            pairs: list[dict[int, Fraction]] = []
            seen: set[int] = set()
            for member, value in decisions:
                seen.add(member)
                if one == other or member not in (one, other) or not {one, other} <= seen:
                    continue
                if waiting and waiting[0][0] != member:
                    pairs.append({member: value, waiting[0][0]: waiting.pop()[1]})
                elif not waiting:
                    waiting.append((member, value))
            for bet in range(1, BETS + 1):
                total = F(0)
                for k in range(len(pairs)):
                    product = F(1)
                    for pair in pairs[k:]:
                        product *= 1 + F(1, 2**bet) * (pair[one] / limit - pair[other])
                    total += product
                if pairs:
                    found[one, other, bet] = total
    return found


@settings(deadline=None)
@given(DECISIONS, st.sampled_from([F(1), F(5, 4), F(22, 7)]), st.integers(0, 60))
def test_the_sums_are_those_of_all_moments_and_survive_a_restart(decisions: Any, limit: Fraction, cut: int) -> None:
    detector = Detector(limit, F(1), 10**9)
    known: list[int] = []
    for number, (member, value) in enumerate(decisions):
        if number == cut:
            detector = Detector(limit, F(1), 10**9, json.loads(json.dumps(detector.kept())))
            for earlier in known:
                detector.join("job", earlier)
        known += [member] * (member not in known)
        assert detector.take("job", member, value, (number, None)) is None
    expected = sums(decisions, limit)
    elapsed, pairs = detector.kept()
    read: dict[tuple[int, int, int], Fraction] = {}
    for a, b, _, _, _, complete, forth, back in pairs:
        for one, other, (summed, _, _) in ((a, b, forth), (b, a, back)):
            read |= {(one, other, bet + 1): F(summed[bet], ONE) for bet in range(BETS) if complete}
    assert read.keys() == expected.keys() and detector.directions == len(expected) // BETS
    assert all(expected[key] * (1 - F(1, 2**50)) <= read[key] <= expected[key] for key in expected)
    assert F(elapsed, ONE) == detector.pairs


def test_groups_are_compared_within_their_block_and_extras_are_dropped() -> None:
    detector = Detector(F(5, 4), F(2), 1000)
    for number, (block, member, value) in enumerate(
        [("a", 1, 0), ("b", 2, 0), ("a", 4, 2), ("b", 3, 2), ("a", 4, 0), ("a", 4, 0), ("a", 1, 2), ("b", 2, 0)]
    ):
        detector.take(block, member, F(value), (number, 1.5 * number))
    _, pairs = detector.kept()
    [(_, _, waiting, _, _, complete, forth, back)] = [pair for pair in pairs if pair[:2] == [1, 4]]
    assert (waiting, complete) == (None, True) and sorted(pair[:2] for pair in pairs) == [[1, 4], [2, 3]]
    assert [float(F(side[0][0], ONE)) for side in (forth, back)] == pytest.approx(
        [1 + 0.5 * (0.8 - 1)] * 2
    )  # the last of 1 against the first of 4
    assert detector.directions == 4 and detector.pairs == F(2, 2) + F(2, 4)


def stream(rng: Any, means: tuple[float, float], limit: Fraction, length: int, warm: int = 0) -> Detection | None:
    detector = Detector(limit, F(1), length)
    draws = rng.random((40 * length + warm, 2))
    for number, (x, y) in enumerate(draws):
        one = means[0] if number >= warm else means[1]
        for member, hit in ((1, x < one), (2, y < means[1])):
            found = detector.take(None, member, F(int(hit)), (number, None))
            if found:
                return found
    return None


def test_false_alarms_are_no_more_often_than_stated() -> None:
    """At the boundary of both directions: the limit is 1 and the means are the same."""
    length, streams = 200, 200
    rng = np.random.default_rng(17)
    until = [found.pairs for found in (stream(rng, (0.5, 0.5), F(1), length) for _ in range(streams)) if found]
    assert len(until) == streams
    assert length * (1 - 3 / streams**0.5) <= mean(until) <= 3 * length
    for share in (0.1, 0.3, 0.6):
        assert sum(pairs <= share * length for pairs in until) <= binom.isf(0.001, streams, share)


def test_a_ratio_of_five_thirds_is_seen_within_500_pairs() -> None:
    rng = np.random.default_rng(5)
    found = [stream(rng, (0.5, 0.3), F(5, 4), 20_000, warm=500) for _ in range(15)]
    assert all(one and (one.higher, one.lower) == (1, 2) and one.since[0] > 300 for one in found)
    assert median(float(one.pairs) - 500 for one in found if one) <= 500


@given(st.fractions(0, 40))
@settings(deadline=None)
def test_a_limit_on_a_logarithm_becomes_a_ratio_that_is_not_under_it(limit: Fraction) -> None:
    import math

    ratio = ratio_above(limit, "log")
    assert ratio is not None and float(ratio) == pytest.approx(math.exp(limit), rel=1e-9) and ratio >= 1
    assert ratio_above(F(7, 5), "ratio") == F(7, 5)
