"""Ladders for pairs of cells: what the writer writes is accepted, what does not prove its limit is not; sums are those of fractions.

All 4,000 altered ladders: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_pair_exact.py
"""

from __future__ import annotations

from fractions import Fraction
from math import comb
from random import Random

import pytest
import tiers
from hypothesis import given
from hypothesis import strategies as st
from pair_oracle import rarity, score_ends

from fairaudit.checker import pair_exact as judge
from fairaudit.checker import text, work
from fairaudit.inference import pair_exact as writer

F = Fraction
ALTERED = 4000 if tiers.FULL else 250
LEVELS = [F(1, 2), F(1, 20), F(1, 40), F(1, 240), F(1, 10**6)]

Counts = tuple[int, int, int, int]
Claim = tuple[Counts, F, F, tuple[F, ...], F, bool]
"""Counts, limit, level, knots, z^2, and whether the difference is meant."""


def fault(claim: Claim) -> str:
    (k, n, other, m), limit, level, knots, scale, difference = claim
    found: str = judge.fault_of_ladder(judge.Pair((k, n), (other, m), scale, difference), limit, level, knots)
    return found


def written(counts: Counts, level: F, difference: bool, limit: F | None = None) -> Claim | None:
    """What the writer proves about a pair: its end, or a limit."""
    scale = writer.order_scale(level)
    pair = writer.Pair(*counts, scale, "difference" if difference else "ratio")
    if limit is None:
        bound = writer.pair_upper(pair, level)
        return None if bound.knots is None else (counts, F(bound.value), level, bound.knots, scale, difference)
    knots = writer.pair_excludes(pair, limit, level)
    return None if knots is None else (counts, limit, level, knots, scale, difference)


@st.composite
def counts(draw: st.DrawFn, most: int = 60) -> Counts:
    n, m = draw(st.integers(1, most)), draw(st.integers(1, most))
    return draw(st.integers(0, n)), n, draw(st.integers(0, m)), m


@given(counts(), st.sampled_from(LEVELS), st.booleans(), st.fractions(F(1, 8), 8, max_denominator=20))
def test_what_the_writer_proves_is_accepted_and_a_smaller_limit_is_not(pair: Counts, level: F, difference: bool, limit: F) -> None:
    claims = [written(pair, level, difference), written(pair, level, difference, limit / 8 - F(1, 2) if difference else limit)]
    for claim in claims:
        assert claim is None or fault(claim) == ""
    if claims[0] is not None:
        _, end, _, knots, scale, _ = claims[0]
        assert fault((pair, end - F(1, 50) if difference else end * F(49, 50), level, knots, scale, difference)) != ""
        assert fault((pair, end, level * F(4, 5), knots, scale, difference)) != ""


@pytest.mark.parametrize(
    ("pair", "limits"),
    [
        ((24, 341, 22, 373), (None, None)),
        ((0, 1, 1, 1), (None, None)),
        ((1, 1, 1, 1), (None, None)),
        ((30, 30, 30, 30), (None, None)),
        ((0, 50, 1, 50), (None, None)),
        ((50, 50, 1, 50), (None, None)),
        ((2500, 5000, 2500, 5000), (None, None)),
        ((7, 10**5, 9, 200), (None, None)),
        ((10**6, 10**6, 3, 4), (F(5), F(9, 10))),
        ((6 * 10**5, 10**6, 5 * 10**5, 10**6), (F(1203, 1000), F(1013, 10**4))),
    ],
)
def test_cells_of_all_sizes(pair: Counts, limits: tuple[F | None, F | None]) -> None:
    for difference in (False, True):
        claim = written(pair, F(1, 20), difference, limits[difference])
        assert claim is not None and fault(claim) == ""


def altered(claim: Claim, random: Random) -> Claim:
    """Alter a ladder, or what it is to prove, in one of many ways."""
    (k, n, other, m), limit, level, knots, scale, difference = claim
    listed = list(knots)
    i = random.randrange(len(listed))
    how = random.randrange(14)
    if how == 0:
        del listed[i]
    elif how == 1:
        del listed[: i + 1]
    elif how == 2:
        del listed[i:]
    elif how == 3:
        listed[i] += (min([*listed[i + 1 :], F(1)]) - listed[i]) * F(random.randint(1, 60), 60)
    elif how == 4:
        listed[i] -= (listed[i] - max([*listed[:i], F(0)])) * F(random.randint(1, 60), 60)
    elif how == 5:
        listed = [q * F(random.randint(900, 1100), 1000) for q in listed]
    elif how == 6:
        random.shuffle(listed)
    elif how == 7:
        limit -= abs(limit) * F(random.randint(1, 300), 1000) + F(1, 10**4)
    elif how == 8:
        level *= F(random.randint(1, 99), 100)
    elif how == 9:
        k = min(n, k + random.randint(1, 3))
    elif how == 10:
        other = max(0, other - random.randint(1, 3))
    elif how == 11:
        n = max(k, 1, n - random.randint(1, 30))
    elif how == 12:
        m += random.randint(1, 30)
    else:
        scale = random.choice([z for z in (F(25, 16), F(4), F(9), F(1)) if z != scale])
    return (k, n, other, m), limit, level, tuple(listed), scale, difference


def test_altered_ladders_are_judged_by_what_they_prove() -> None:
    """The oracle computes all conditions in floats with order and staircase from decimals; most alterations prove nothing any more."""
    random = Random(tiers.fresh(20))
    refused = tried = 0
    while refused < ALTERED:
        n, m = random.choice([1, 4, 20, 50, 120]), random.choice([1, 4, 20, 50, 120])
        claim = written((random.randint(0, n), n, random.randint(0, m), m), random.choice(LEVELS), random.random() < 0.5)
        for _ in range(12 if claim else 0):
            assert claim is not None
            other = altered(claim, random)
            if other != claim and (other[5] or other[1] > 0):
                tried += 1
                hardest = rarity(*other)
                assert abs(hardest - 1) > 1e-10
                assert (fault(other) == "") == (hardest < 1), other
                refused += hardest > 1
    assert tried < 2 * refused


@given(st.integers(1, 80), st.fractions(0, 1, max_denominator=10**6))
def test_terms_and_sums_enclose_those_of_the_binomial_law(n: int, mean: F) -> None:
    law = judge.binomial_law(n, mean)
    exact = [comb(n, k) * mean**k * (1 - mean) ** (n - k) for k in range(n + 1)]
    stop = law.start + len(law.terms)
    unit = F(2**64) / max(exact)
    for k, term in enumerate(law.terms, law.start):
        assert unit * exact[k] <= term <= unit * exact[k] + n
    for bound, some in ((law.before, exact[: law.start]), (law.after, exact[stop:])):
        assert unit * sum(some) <= bound <= 10 * n
    assert unit - n * n <= law.total <= unit
    share = F(1, 1000)
    for k in range(n + 1):
        assert law.exceeds(k, True, share) == (sum(exact[: k + 1]) > share)
        assert law.exceeds(k, False, share) == (sum(exact[k:]) > share)


@given(counts(), st.sampled_from([F(25, 16), F(4), F(9)]), st.booleans())
def test_the_order_is_that_of_decimals(counts: Counts, scale: F, difference: bool) -> None:
    k, n, other, m = counts
    pair = judge.Pair((k, n), (other, m), scale, difference)
    assert all(judge.score_ends(i, n, scale) == score_ends(i, n, scale) for i in range(n + 1))
    for i in range(n + 1):
        first = [pair.comes_first(i, j) for j in range(m + 1)]
        assert first == sorted(first)
        assert pair.stair(i, 0) == m + 1 - sum(first)
    assert pair.comes_first(k, other)


def test_what_is_no_ladder() -> None:
    claim = written((24, 341, 22, 373), F(1, 20), False)
    assert claim is not None
    pair, limit, level, knots, scale, _ = claim
    for listed in ((), knots[::-1], (*knots[:3], *knots[2:]), (F(-1, 10), *knots), (*knots, F(11, 10))):
        assert "rising" in fault((pair, limit, level, listed, scale, False))
    assert "bounded" in fault(((24, 341, 0, 373), limit, level, knots, scale, False))
    for wrong in ((24, 10**6 + 1, 22, 373), (342, 341, 22, 373), (0, 0, 22, 373), (-1, 341, 22, 373), (24, 341, 22, 10**7)):
        assert "draws" in fault((wrong, limit, level, knots, scale, False))


def test_an_empty_range_proves_nothing() -> None:
    """The null p >= q holds in the whole box of 200 of 200 against 2 of 200: a knot between the ends separates nothing."""
    for knots in ((F(1, 2),), (F(1, 100),), (F(1, 10), F(9, 10)), (F(89, 100), F(9, 10))):
        assert fault(((200, 200, 2, 200), F(1), F(1, 20), knots, F(25, 16), False)) != ""
    assert "separate" in fault(((1, 1, 0, 1), F(1), F(1, 20), (F(0),), F(25, 16), True))  # p = 1, q = 0 are in the box


def test_a_single_knot_separates_the_ends_in_each_of_three_ways() -> None:
    """The image of the lower end of q is above the upper end of p; or it is 1; or q has no lower end, and the image of 0 is above."""
    for pair, limit, difference in (
        ((10, 1000, 900, 1000), F(1), False),
        ((50, 50, 40, 50), F(3), False),
        ((34, 60, 0, 5), F(19, 20), True),
    ):
        claim = written(pair, F(1, 20), difference, limit)
        assert claim is not None and len(claim[3]) == 1 and fault(claim) == ""
        assert "separate" in fault((pair, limit, F(1, 20), ((claim[3][0] + 1) / 2,), claim[4], difference))
        assert "separate" in fault((pair, limit / 100, F(1, 20), claim[3], claim[4], difference))


def test_work_is_counted_before_it_is_done() -> None:
    claim = written((2500, 5000, 2500, 5000), F(1, 20), False)
    assert claim is not None

    def within(steps: int, blocks: int) -> bool:
        judge.score_ends.cache_clear()
        token = work.CURRENT_WORK.set(work.Work(steps, blocks))
        try:
            return fault(claim) == ""
        finally:
            work.CURRENT_WORK.reset(token)

    assert within(5_000_000, 100_000)
    for few in ((100_000, 100_000), (5_000_000, 1000)):
        with pytest.raises(text.TooMuch):
            within(*few)
