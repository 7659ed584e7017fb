"""The exact bound of the ratio, or difference, of the means of two independent binomial cells: whether a ladder of knots proves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate, pairwise
from math import isqrt

from .rationals import as_pair, bits_of
from .text import shown
from .work import keep, spend

MOST_DRAWS = 10**6  # of a cell
GUARD = Fraction(1, 50)  # of the level is for means outside the ends of the two cells, a quarter of it for each end
UNIT = 1 << 64  # the term of a binomial law at its mode
CHUNK = 64  # terms that are paid for at once


def order_scale(level: Fraction) -> Fraction:
    """Say which z^2 the order of the outcomes takes at the level of a one-sided end."""
    if level >= Fraction(1, 100):
        return Fraction(25, 16)
    return Fraction(4) if level >= Fraction(1, 2000) else Fraction(9)


@lru_cache(maxsize=1 << 16)
def score_ends(k: int, n: int, scale: Fraction) -> tuple[int, int]:
    """Solve (x - k/n)^2 = z^2 x (1 - x)/n: the floors of 2^64 times the two roots."""
    spend(20, 256, 256)
    keep(4)
    a, b = scale.numerator, scale.denominator
    radicand = a * n * (4 * b * k * (n - k) + a * n) << 128
    root = isqrt(radicand)
    twice, below = (n * (2 * b * k + a)) << 64, 2 * n * (b * n + a)
    return (twice - root - (root * root != radicand)) // below, (twice + root) // below


@dataclass(frozen=True)
class Pair:
    """Successes and draws of two cells, z^2, and whether the difference of their means is meant, or their ratio."""

    higher: tuple[int, int]
    lower: tuple[int, int]
    scale: Fraction
    difference: bool

    def comes_first(self, k: int, other: int) -> bool:
        """Decide whether an outcome comes no later in the order than the observed one."""
        (_, above), (below, _) = score_ends(k, self.higher[1], self.scale), score_ends(other, self.lower[1], self.scale)
        (_, top), (bottom, _) = score_ends(*self.higher, self.scale), score_ends(*self.lower, self.scale)
        spend(2)
        return above - below <= top - bottom if self.difference else above * bottom <= top * below

    def stair(self, k: int, least: int) -> int:
        """Find the least outcome of the lower cell, from `least` on, that comes first with k; one more than its draws if none does."""
        step, n = 1, self.lower[1]
        while least + step <= n + 1 and not self.comes_first(k, least + step - 1):
            least, step = least + step, 2 * step
        most = min(least + step - 1, n + 1)
        while least < most:
            middle = (least + most) // 2
            least, most = (least, middle) if self.comes_first(k, middle) else (middle + 1, most)
        return least

    def image(self, mean: Fraction, limit: Fraction) -> Fraction:
        """The least mean of the higher cell that the null allows with a mean of the lower one."""
        return min(max(mean + limit if self.difference else mean * limit, Fraction(0)), Fraction(1))


@dataclass(frozen=True)
class Law:
    """Terms of a binomial law from `start` on and the sums of those before and after, from above; the sum of all of them from below."""

    draws: int
    start: int
    terms: list[int]
    before: int
    after: int
    total: int

    def tails(self) -> list[int]:
        """Sum each term and all after it, then those after the last."""
        spend(len(self.terms))
        return [*accumulate(reversed(self.terms), initial=self.after)][::-1]

    def exceeds(self, k: int, below: bool, share: Fraction) -> bool:
        """Decide whether outcomes of at most k, or of at least k, may have more than a share."""
        spend(len(self.terms) + 5, bits_of(share))
        at = min(max(k + below - self.start, 0), len(self.terms))
        if below:
            listed = self.before + sum(self.terms[:at]) + self.after * (k >= self.start + len(self.terms))
        else:
            listed = self.before * (k < self.start) + sum(self.terms[at:]) + self.after
        return listed * share.denominator > share.numerator * self.total


def binomial_law(draws: int, mean: Fraction) -> Law:
    """Compute a law from its mode outwards.

    Quotients of successive terms are at most 1 there, so that rounding up makes a term too great by less than its distance from the mode.
    They fall, so that a geometric series bounds what comes after a term; a term that is no greater than its distance is the last.
    """
    a, b = mean.numerator, mean.denominator - mean.numerator
    if a <= 0 or b <= 0:
        return Law(draws, 0 if a <= 0 else draws, [UNIT], 0, 0, UNIT)
    mode = (draws + 1) * a // (a + b)
    up, after = _side(draws - mode, mode + 1, a, b)
    down, before = _side(mode, draws - mode + 1, b, a)
    excess = (len(up) * (len(up) + 1) + len(down) * (len(down) + 1)) // 2
    return Law(draws, mode - len(down), [*reversed(down), UNIT, *up], before, after, UNIT + sum(up) + sum(down) - excess)


def _side(count: int, divisor: int, a: int, b: int) -> tuple[list[int], int]:
    """Compute the terms on one side of the mode, with quotients count a / (divisor b), and bound the sum of the others."""
    bits = max(a.bit_length(), b.bit_length())
    terms: list[int] = []
    term = UNIT
    while count and term > len(terms):
        if len(terms) % CHUNK == 0:
            spend(5 * CHUNK, 64 + bits)
        term = -(-term * count * a // (divisor * b))
        terms.append(term)
        count, divisor = count - 1, divisor + 1
    spend(5, bits)
    return terms, -(-term * count * a // (divisor * b - count * a)) if count else 0


def fault_of_ladder(pair: Pair, limit: Fraction, level: Fraction, knots: Sequence[Fraction]) -> str:
    """Say why knots do not prove that the ratio (or difference) is less than a limit, at a level; nothing if they do.

    The null is p >= limit q (or p >= limit + q), for the means p, q of the higher and the lower cell. A knot is an end of q if the draws
    of the lower cell are rare there, and gives one of p if those of the higher cell are rare at its image.
    """
    (k, n), (other, m) = pair.higher, pair.lower
    if not (0 <= k <= n and 0 <= other <= m and min(n, m) >= 1 and max(n, m) <= MOST_DRAWS):
        return f"is for cells of 1 to {MOST_DRAWS} draws"
    if not knots or knots[0] < 0 or knots[-1] > 1 or any(q <= p for p, q in pairwise(knots)):
        return "is not a strictly rising list of knots from 0 to 1"
    if not pair.difference and (limit <= 0 or not other):
        return "is not for a ratio that can be bounded"
    share = level * GUARD / 4
    images = [pair.image(knot, limit) for knot in (knots[0], knots[-1])]
    starts = [binomial_law(m, knots[0]), binomial_law(n, images[0])]
    stops = [binomial_law(m, knots[-1]), binomial_law(n, images[1])]
    short, beyond = starts[0].exceeds(other, False, share), not stops[1].exceeds(k, True, share)
    if len(knots) == 1:
        separate = (beyond and knots[0] == 0) or ((beyond or images[1] == 1) and not short)
        return "" if separate else "does not separate the ends of the two means"
    if knots[0] > 0 and images[0] > 0 and short and starts[1].exceeds(k, False, share):
        return f"starts at {shown(as_pair(knots[0]))}, which is above the lower ends of the means"
    if not beyond and images[1] < 1 and knots[-1] < 1 and stops[0].exceeds(other, True, share):
        return f"stops at {shown(as_pair(knots[-1]))}, which is below the upper ends of the means"
    stairs: dict[int, int] = {}
    goal = level - level * GUARD
    for p, q in pairwise(knots):
        law, lower = binomial_law(n, pair.image(p, limit)), binomial_law(m, q)
        spend(10, 256, bits_of(goal))
        if _weight(pair, law, lower, stairs) * goal.denominator > goal.numerator * law.total * lower.total:
            return f"does not hold between the knots {shown(as_pair(p))} and {shown(as_pair(q))}"
    return ""


def _weight(pair: Pair, law: Law, lower: Law, stairs: dict[int, int]) -> int:
    """Bound the weight of the outcomes that come no later than the observed one; `stairs` are those known so far."""
    tails = lower.tails()
    everything = tails[0] + lower.before
    found = (law.before + law.after) * everything
    spend(4 * len(law.terms))
    for k, term in enumerate(law.terms, law.start):
        stair = stairs.get(k)
        if stair is None:
            keep(1)
            stair = stairs[k] = pair.stair(k, stairs.get(k - 1, 0))
        at = stair - lower.start
        if at < 0:
            found += term * everything
        elif stair <= lower.draws:
            found += term * tails[min(at, len(tails) - 1)]
    return found
