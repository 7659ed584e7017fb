"""Tails of sums of independent draws: exact binomial sums, and enclosures of the bounds beyond them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from math import comb, prod
from typing import NamedTuple

from .logarithms import log_bounds
from .rationals import Rational, as_pair, bits_of
from .text import shown
from .work import keep, spend

SUMMED = 5000  # draws up to which binomial tails are exact sums, which take a step for each draw; beyond, bounds take their place
PRECISION = 256  # bits after the point of the enclosures here: far below every level that a test is made at
COARSE = 64  # bits after the point of the logarithm of a level, where a quick test is enough


class Sample(NamedTuple):
    """Independent draws of a number between low and high that have the same mean; binary if they are low or high.

    Everything is in integers: what is counted in parts is so many times 1/unit, the sum of the squares so many times 1/unit^2.
    """

    draws: int
    total_parts: int
    squares_parts: int
    low_parts: int
    high_parts: int
    unit: int
    binary: bool

    @property
    def total(self) -> Fraction:
        """The sum of the draws."""
        return Fraction(self.total_parts, self.unit)

    @property
    def squares(self) -> Fraction:
        """The sum of their squares."""
        return Fraction(self.squares_parts, self.unit**2)

    @property
    def low(self) -> Fraction:
        """The least that a draw can be."""
        return Fraction(self.low_parts, self.unit)

    @property
    def high(self) -> Fraction:
        """The greatest that a draw can be."""
        return Fraction(self.high_parts, self.unit)

    @property
    def range(self) -> tuple[Rational, Rational]:
        """Both, in integers."""
        return (self.low_parts, self.unit), (self.high_parts, self.unit)

    @property
    def informative(self) -> bool:
        """Whether the draws say more of the mean than the range does."""
        return self.draws > 0 and self.low_parts < self.high_parts

    def tail(self, mean: Fraction, below: bool) -> Tail:
        """The lower tail, or the upper one, at a mean; for informative samples."""
        n, width = self.draws, self.high - self.low
        k, p = (self.total - n * self.low) / width, (mean - self.low) / width
        return (n, k, p, self.binary) if below else (n, n - k, 1 - p, self.binary)


def reach_of(level: Fraction) -> int:
    """Bound 2^COARSE log(1/level) from above."""
    return -(log_of_level(level) >> (PRECISION - COARSE))


def are_far(sample: Sample, ends: tuple[Rational, Rational], reach: int) -> bool:
    """Decide quickly that draws exclude all that is beyond the ends of their mean, by an inequality that holds of those far from it only.

    With z the mean of the draws and p an end, both on the scale where the range is [0, 1], the bound of the tail is at most exp(-nD) with
    D the integral of (t - z) / (t (1 - t)) over t from z to p: at least (p - z)^2 / (2v), v being the greatest t (1 - t) on the way.
    """
    n, total, _, low, high, unit, _ = sample
    (a, d), (b, e) = ends
    above, below = (high - low) * d * n, (high - low) * e * n  # 1, in the units of either end
    if not above or not below:
        return False
    z, p = (total - n * low) * d, (a * unit - low * d) * n
    if p and not (0 < p < z and _is_far(n, z, p, above, reach)):
        return False
    z, p = (total - n * low) * e, (b * unit - low * e) * n
    return p == below or (z < p < below and _is_far(n, z, p, below, reach))


def _is_far(n: int, z: int, p: int, one: int, reach: int) -> bool:
    """Decide n (p - z)^2 / (2v) >= reach / 2^COARSE, for z and p in units of which ``one`` are 1."""
    if one.bit_length() > 256:
        spend(8, one.bit_length(), one.bit_length())
    middle = sorted((2 * z, 2 * p, one))[1]  # twice the t between z and p that is closest to 1/2
    return 2 * n * (p - z) ** 2 << COARSE >= reach * middle * (2 * one - middle)


def fault_of_ends(sample: Sample, lo: Fraction, hi: Fraction, level: Fraction, method: str) -> str:
    """Say what is wrong with the ends of a mean at a level; nothing if the draws exclude all that is beyond them."""
    if not sample.low <= lo <= hi <= sample.high:
        return "are not ends in the range of the cell"
    if not sample.informative:
        return "" if (lo, hi) == (sample.low, sample.high) else "are not the range of the cell, of which nothing else is known"
    if lo > sample.low and not _excluded(sample, lo, level, method, above=False):
        return f"has the lower end {shown(as_pair(lo))}, which is not excluded from below at the level {shown(as_pair(level))}"
    if hi < sample.high and not _excluded(sample, hi, level, method, above=True):
        return f"has the upper end {shown(as_pair(hi))}, which is not excluded from above at the level {shown(as_pair(level))}"
    return ""


def _excluded(sample: Sample, mean: Fraction, level: Fraction, method: str, above: bool) -> bool:
    """Decide whether a test at this level rejects a mean as too great, or as too small."""
    if sample.binary or method == "hoeffding-kl":
        return tails_at_most([sample.tail(mean, above)], level)
    if method == "intersection":
        level /= 2
        return tails_at_most([sample.tail(mean, above)], level) or _bernstein(sample, mean, level, above)
    return _bernstein(sample, mean, level, above)


def _bernstein(sample: Sample, mean: Fraction, level: Fraction, above: bool) -> bool:
    """Decide |mean - z| >= sqrt(2 V log(2/level) / n) + 7 log(2/level) / (3 (n - 1)), z being the mean of the sample and V its variance."""
    n, width = sample.draws, sample.high - sample.low
    if n < 2 or level == 0:
        return False
    logarithm = Fraction(-log_form([(Fraction(1), level / 2)]), 1 << PRECISION)
    variance = (sample.squares - sample.total**2 / n) / (n - 1) / width**2
    distance = (mean - sample.total / n if above else sample.total / n - mean) / width - 7 * logarithm / (3 * (n - 1))
    return distance >= 0 and distance**2 >= 2 * variance * logarithm / n


# A bound of the probability that the sum of n draws from [0, 1] with mean p is at most k: n, k, p, and whether all draws
# are 0 or 1.
Tail = tuple[int, Fraction, Fraction, bool]


def log_form(terms: Sequence[tuple[Fraction, Fraction]]) -> int:
    """Bound 2^PRECISION (the sum of c log x) from below, for terms (c, x), x > 0."""
    for c, x in terms:
        spend(100, bits_of(c), bits_of(x))
    bits = PRECISION + max(int(abs(c)).bit_length() for c, _ in terms)
    total = 0
    for c, x in terms:
        n, d = x.numerator, x.denominator
        if n < d:
            n, d, c = d, n, -c
        if n > d:
            low, high = log_bounds(n, d, bits)
            total += c.numerator * (low if c > 0 else high) // c.denominator
    return total >> (bits - PRECISION)


def _is_summed(tail: Tail) -> bool:
    """Whether the bound is the binomial sum; for k = 0 that is the other bound too, and can be compared exactly."""
    n, k, _, binary = tail
    return n <= SUMMED and (binary or k == 0)


@lru_cache(maxsize=1 << 16)
def tail_rarity(tail: Tail) -> int | None:
    """Bound -2^PRECISION log B from below, where B is the bound of a tail; None if B is 0."""
    n, k, p, binary = tail
    keep(20, bits_of(k) + bits_of(p))
    if p <= 0 or k == n:
        return 0
    if p >= 1:
        return None
    spend(250, bits_of(k) + bits_of(p), bits_of(k) + bits_of(p))
    if _is_summed(tail):
        terms = [(k, 1 / p), (n - k, 1 / (1 - p)), (Fraction(1), Fraction(1 << PRECISION, comb(n, int(k)) * _relative_sum(n, int(k), p)))]
        return max(0, log_form(terms))
    if k >= n * p:
        return 0
    terms = [(n - k, (n - k) / (n * (1 - p)))]
    if k:
        terms.append((k, k / (n * p)))
        rho = k * (1 - p) / ((n - k + 1) * p)
        square = Fraction(53 * n, 333) / (k * (n - k) * (1 - rho) ** 2)
        if binary and square < 1:
            terms.append((Fraction(-1, 2), square))
    return max(0, log_form(terms))


def _relative_sum(n: int, k: int, p: Fraction) -> int:
    """Add up the terms of a binomial tail, the one for k first, as multiples of 2^-PRECISION of that one, rounded up."""
    a, b = p.numerator, p.denominator - p.numerator
    total = term = 1 << PRECISION
    for i in range(k, 0, -1):
        if i % 64 == 0 or i == k:
            spend(8 * min(i, 64), bits_of(p))
        term = -(-term * i * b // ((n - i + 1) * a))
        total += term
        if term == 1:  # the quotients of successive terms fall: no term from here on is greater
            return total + i - 1
    return total


def _binomial(tail: Tail) -> Fraction:
    """The binomial sum itself."""
    n, k, p, _ = tail
    if p <= 0:
        return Fraction(1)
    a, b = p.numerator, p.denominator - p.numerator
    total, term = 0, 1
    bits = bits_of(p)
    spend(4 * int(k) + 4, n * bits, bits)
    spend(2, n * bits, n * bits)
    for i in range(int(k) + 1):
        total = total * b + term
        term = term * (n - i) * a // (i + 1)
    return Fraction(total * b ** (n - int(k)), p.denominator**n)


def tails_at_most(tails: Sequence[Tail], level: Fraction) -> bool:
    """Decide whether the product of the bounds of some tails is at most a level less than 1."""
    rarities = [tail_rarity(tail) for tail in tails]
    known = [rarity for rarity in rarities if rarity is not None]
    if len(known) < len(rarities) or level == 0:
        return len(known) < len(rarities)
    excess = sum(known) + log_of_level(level)
    if excess >= 0:
        return True
    # Equality cannot be seen by logarithms.
    return excess >> (PRECISION - 64) == -1 and all(map(_is_summed, tails)) and prod(map(_binomial, tails)) <= level


@lru_cache(maxsize=64)
def log_of_level(level: Fraction) -> int:
    """Bound 2^PRECISION log(level) from below."""
    return log_form([(Fraction(1), level)])
