"""Differences of selection rates beyond chance: as scipy has them, exact, and decided at the limit."""

from __future__ import annotations

from fractions import Fraction
from math import comb
from random import Random

import numpy as np
import pytest
import tiers
from scipy.stats import chi2_contingency, fisher_exact

from fairaudit.publications import significance
from fairaudit.publications.significance import LEVEL, Pair, fisher, holm, judged

PAIRS = 12_000 if tiers.FULL else 400


def random_pair(rng: Random, most: int) -> Pair:
    n, m = rng.randint(1, most), rng.randint(1, most)
    return Pair(rng.randint(0, n), n, rng.randint(0, m), m)


def table_of(pair: Pair) -> np.ndarray:
    return np.array([[pair.selected, pair.applicants - pair.selected], [pair.other_selected, pair.other_applicants - pair.other_selected]])


def plain_fisher(pair: Pair) -> Fraction:
    """The definition, term by term."""
    n, m, taken = pair.applicants, pair.other_applicants, pair.selected + pair.other_selected
    weights = {k: comb(n, k) * comb(m, taken - k) for k in range(max(0, taken - m), min(n, taken) + 1)}
    return Fraction(sum(w for w in weights.values() if w <= weights[pair.selected]), comb(n + m, taken))


def test_fisher_and_deviations_are_those_of_scipy() -> None:
    rng = Random(tiers.fresh("scipy"))
    for i in range(PAIRS):
        pair = random_pair(rng, (6, 40, 300, 3000)[i % 4])
        table = table_of(pair)
        found = fisher(pair)
        assert abs(float(found.low) - fisher_exact(table).pvalue) < 1e-12
        assert 0 <= found.high - found.low < Fraction(1, 10**20)
        if (table.sum(axis=0) > 0).all():
            assert abs(float(pair.squared_deviations or 0) - chi2_contingency(table, correction=False).statistic) <= 1e-12 * max(
                1, float(pair.squared_deviations or 0)
            )
        else:
            assert pair.squared_deviations is None


def test_holm_is_that_of_the_values_of_scipy() -> None:
    rng = Random(tiers.fresh("families"))
    for _ in range(PAIRS // 4):
        pairs = [random_pair(rng, rng.choice((8, 60, 300))) for _ in range(rng.randint(2, 8))]
        ps = [float(fisher_exact(table_of(pair)).pvalue) for pair in pairs]
        before = 0.0
        expected = [0.0] * len(ps)
        for rank, place in enumerate(sorted(range(len(ps)), key=ps.__getitem__)):
            before = max(before, min(1.0, ps[place] * (len(ps) - rank)))
            expected[place] = before
        for one, value in zip(judged(pairs), expected, strict=True):
            assert one.adjusted.low == one.adjusted.high
            assert abs(float(one.adjusted.low) - value) < 1e-12
            assert one.significant_adjusted == (one.adjusted.low <= LEVEL)


def test_fisher_is_its_definition() -> None:
    rng = Random(tiers.fresh("definition"))
    for _ in range(300):
        pair = random_pair(rng, 30)
        found = fisher(pair)
        assert found.low == found.high == plain_fisher(pair)


def test_bounds_hold_the_exact_probability(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is done for great numbers, done for small ones, where the definition can be computed."""
    monkeypatch.setattr(significance, "FEW", 0)
    rng = Random(tiers.fresh("bounds"))
    for i in range(400):
        pair = random_pair(rng, (12, 80)[i % 2])
        if i % 3 == 0:  # of groups of one size each weight occurs twice
            pair = Pair(min(pair.selected, pair.other_applicants), pair.other_applicants, pair.other_selected, pair.other_applicants)
        exact = plain_fisher(pair)
        for bits in (4, 8, 16, 128):
            found = fisher(pair, bits)
            assert found.low <= exact <= found.high
        assert found.high - found.low < Fraction(1, 10**18)
        assert fisher(pair, None).low == exact


def test_a_million_people_are_tested() -> None:
    for n, m in ((10**6, 10**6), (10**6, 10**6 // 7), (10**9, 10**9 // 3)):
        for apart in (0, 333, 1000, 5000):
            pair = Pair(n // 3 - apart * n // 10**6, n, m // 3, m)
            found = fisher(pair)
            assert found.high - found.low < Fraction(1, 10**18)
            table = [[pair.selected, n - pair.selected], [pair.other_selected, m - pair.other_selected]]
            if n == 10**6:
                assert abs(float(found.low) - fisher_exact(table).pvalue) < 1e-7  # scipy's own error with such numbers
        assert fisher(Pair(n // 2, n, 0, m)).high < Fraction(1, 10**30)


def test_values_of_published_examples() -> None:
    for counts, p, square, digits in (
        ((555, 1181, 667, 1390), 0.63449, 0.25171, 5),
        ((170, 390, 412, 797), 0.0094301, 6.8819, 7),
        ((18, 41, 412, 797), 0.34162, 0.94752, 5),
        ((2, 40, 3, 40), 1.0, 0.21333, 5),
    ):
        pair = Pair(*counts)
        assert round(float(fisher(pair).low), digits) == p
        assert float(f"{float(pair.squared_deviations or 0):.5g}") == square
    assert fisher(Pair(3, 12, 12, 16)).low == Fraction(6692, 334305)
    assert Pair(2, 40, 3, 40).one_person and Pair(2, 40, 3, 40).ratio == Fraction(2, 3)


def test_what_is_exactly_at_the_limit_is_at_most_the_limit() -> None:
    """One selected of N people: the probability that it is the single one of the first group is 1/N."""
    assert fisher(Pair(1, 1, 0, 19)).low == LEVEL
    assert [found.significant for found in judged([Pair(1, 1, 0, 19)])] == [True]
    assert [found.significant for found in judged([Pair(1, 1, 0, 18)])] == [False]
    million = Pair(1, 1, 10**6 - 1, 20 * 10**6 - 1)
    assert fisher(million).low == LEVEL
    assert judged([million])[0].significant
    assert not judged([Pair(1, 1, 10**6, 20 * 10**6 - 1)])[0].significant
    found = judged([Pair(1, 1, 0, 39), Pair(1, 2, 1, 2)])  # adjusted: twice 1/40
    assert [one.significant_adjusted for one in found] == [True, False]
    assert found[0].adjusted.low == LEVEL


def test_the_limit_is_decided_where_bounds_alone_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(significance, "FEW", 0)
    assert judged([Pair(1, 1, 0, 19)])[0].significant
    pair = Pair(1, 1, 10**6 - 1, 20 * 10**6 - 1)
    assert judged([pair])[0].significant


def test_four_fifths_and_two_deviations_at_their_limits() -> None:
    share = Fraction(4, 5)
    assert not Pair(48, 100, 60, 100).below(share)
    assert Pair(48 * 10**17 - 1, 10**19, 6 * 10**18, 10**19).below(share)
    assert Pair(45, 100, 60, 100).below(share) and not Pair(51, 100, 60, 100).below(share)
    assert Pair(48, 100, 60, 100).further(share) == 0 and Pair(47, 100, 60, 100).further(share) == 1
    at = Pair(0, 4, 2, 4)  # (2·4)²·8 ÷ (4·4·2·6) = 8/3
    assert at.squared_deviations == Fraction(8, 3)
    assert Pair(0, 2, 2, 2).squared_deviations == 4


def test_the_shortfall_and_the_least_number_are_what_they_say() -> None:
    rng = Random(tiers.fresh("shortfall"))
    for _ in range(500):
        pair = random_pair(rng, 60)
        s, n, h, m = pair.selected, pair.applicants, pair.other_selected, pair.other_applicants
        assert pair.shortfall == Fraction(n * (s + h), n + m) - s
        least = next(k for k in range(n + 1) if Fraction(s + k, n) >= Fraction(4, 5) * Fraction(h, m) or s + k == n)
        assert pair.further(Fraction(4, 5)) == least
        rate, other = Fraction(s, n), Fraction(h, m)
        if rate < other:
            reversed_by_one = s < n and Fraction(s + 1, n) > Fraction(h - 1, m)
        else:
            reversed_by_one = rate > other and h < m and Fraction(h + 1, m) > Fraction(s - 1, n)
        assert pair.one_person == reversed_by_one


def test_holm_is_its_definition() -> None:
    """The greatest p by which a hypothesis falls in the step-down procedure, over all that fall before it."""
    rng = Random(tiers.fresh("holm"))
    for _ in range(300):
        ps = [Fraction(rng.randint(0, 30), 100) for _ in range(rng.randint(1, 7))]
        found = holm(ps)
        for level in {*found, Fraction(1, 20), Fraction(1, 10)}:
            rejected: set[int] = set()
            for rank, place in enumerate(sorted(range(len(ps)), key=lambda i: ps[i])):
                if ps[place] * (len(ps) - rank) > level:
                    break
                rejected.add(place)
            if level < 1:
                assert {place for place, value in enumerate(found) if value <= level} == rejected
