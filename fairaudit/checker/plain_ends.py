"""Plain ends of means: those that follow from draws and a level in closed form, which evidence does not have to list."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from math import isqrt

from .claims import METHODS
from .intervals import Ends, Listed, Unproven
from .rationals import Rational
from .tails import PRECISION, Sample, log_of_level
from .text import shown
from .work import keep, spend

KNOWN = 1 << 10  # different draws whose ends are remembered
BITS = 32  # plain ends are multiples of 2^-BITS of the range, as is the logarithm of a level that they rest on


@lru_cache(maxsize=64)
def reach_of_plain(level: Fraction) -> int:
    """The least integer that is at least 2^BITS log(1/level)."""
    return -(log_of_level(level) >> (PRECISION - BITS))


def below(n: int, k: int, one: int, reach: int) -> int:
    """The lower end of n draws with the mean z = k/one on the scale where the range is [0, 1], in multiples of 2^-BITS.

    The greater of two: one by squares, and, of few successes, z / 2^m with m >= (1 + reach/2^BITS / (n z)) / log 2.  At p = z / 2^m
    the exponent D of the tail is at least n z (log(z/p) - 1), and log 2 > 9/13.
    """
    if one.bit_length() > 128:
        spend(24, 2 * one.bit_length(), 2 * one.bit_length())
    least = (1 << BITS) - _above(n, one - k, one, reach)
    if not k or k << BITS <= least * one << 2:  # m is at least 2
        return least
    successes = n * k << BITS
    halvings = -(-13 * (successes + reach * one) // (9 * successes))
    return max(least, (k << BITS) // (one << halvings)) if halvings <= BITS else least


def _above(n: int, k: int, one: int, reach: int) -> int:
    """The least integer j for which p = j/2^BITS is above z = k/one and n (p - z)^2 >= 2 v reach/2^BITS, or 2^BITS if that is less.

    v is the greatest t (1 - t) between z and p: as p rises, that of z, or 1/4, or before that of p itself, for which a quadratic decides.
    """
    half, unit = 1 << (BITS - 1), 1 << BITS
    if 2 * k >= one:  # (j one - k unit)^2 n >= 2 reach unit k (one - k), as of the others in integers
        return min(unit, -(-((k << BITS) + _root(reach * k * (one - k) << BITS + 1, n)) // one))
    if n * (one - 2 * k) ** 2 * unit < 2 * reach * one**2:  # 1/2 is not far enough
        return min(unit, -(-(k * unit + _root(reach * half * one**2, n)) // one))
    scaled, twice = n * unit, 2 * reach
    root = _root(twice * unit**2 * (4 * scaled * k * (one - k) + twice * one**2), 1)
    return -(-(unit * (2 * scaled * k + twice * one) + root) // (2 * one * (scaled + twice)))


def _root(value: int, divisor: int) -> int:
    """The least integer that is not negative and whose square is at least a quotient."""
    least = -(-value // divisor)
    return isqrt(least - 1) + 1 if least else 0


class PlainEnds:
    """The plain ends of samples at one level; those of equal draws are found once, while they are not too many."""

    def __init__(self, level: Fraction, method: str) -> None:
        self.reach, self.method = reach_of_plain(level) if level else 0, method
        self.known: dict[tuple[int, int, int], tuple[int, int]] = {}

    def parts(self, sample: Sample) -> tuple[int, int]:
        """The ends of an informative sample, in multiples of 2^-BITS of the range."""
        n, total, _, low, high, _, binary = sample
        if not binary and self.method != METHODS[0]:
            raise Unproven(f"all cells must be listed, as the method {shown(self.method)} has no plain ends")
        k, one = total - n * low, n * (high - low)
        found = self.known.get((n, k, one))
        if found is None:
            spend(40)
            found = below(n, k, one, self.reach), (1 << BITS) - below(n, one - k, one, self.reach)
            if len(self.known) < KNOWN:
                keep(3)
                self.known[n, k, one] = found
        return found

    def around(self, draws: int, low: int, high: int, one: int) -> tuple[int, int]:
        """What holds the ends of all samples of at least so many draws, with means from low/one to high/one where the range is [0, 1].

        Both ends rise with the mean, and more draws bring each closer to it; so they do in multiples of 2^-BITS, rounded one way.
        """
        spend(40)
        if not self.reach:
            return 0, 1 << BITS
        return below(draws, low, one, self.reach), (1 << BITS) - below(draws, one - high, one, self.reach)

    def numerators(self, sample: Sample) -> tuple[int, int]:
        """The ends of a sample, those of the range where it says nothing, as multiples of 2^-BITS of what draws are counted in."""
        low, high = sample.low_parts, sample.high_parts
        least, most = self.parts(sample) if sample.draws and low < high and self.reach else (0, 1 << BITS)
        start, width = low << BITS, high - low
        return start + width * least, start + width * most

    def of(self, sample: Sample, side: int) -> Rational:
        """One of them."""
        return self.numerators(sample)[side], sample.unit << BITS


def completed(given: Ends | Listed, samples: Sequence[Sample], tops: Sequence[Sample], plain: PlainEnds | None) -> Ends:
    """The ends of all cells: of those that are not listed the plain ones, or those of the range."""
    if not isinstance(given, Listed):
        return given
    ends: Ends = []
    listed = dict(zip(given.cells, given.ends, strict=True))
    keep(2 * len(samples))
    for i, (sample, top) in enumerate(zip(samples, tops, strict=True)):
        if i in listed:
            ends.append(listed[i])
        elif plain is None:
            ends.append(((sample.low_parts, sample.unit), (top.high_parts, top.unit)))
        else:
            ends.append((plain.of(sample, 0), plain.of(top, 1)))
    return ends
