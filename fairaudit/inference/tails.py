"""Tails of sums of draws, bounded from above in integers."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import comb, isqrt
from typing import Literal

from fairaudit.exact.enclosures import exp_enclosure, log_fixed
from fairaudit.inference.cells import Cell
from fairaudit.inference.rounding import BITS, power_above

EXACT_DRAWS = 5_000  # as docs/certificate-samples.md has it: up to here the binomial sum is formed, beyond it a bound takes its place

ONE = 1 << BITS  # the probability 1, in units of 2^-BITS

PI_BELOW = Fraction(333, 106)  # 3.14150…: Stirling's bound rises as π falls, so π is rounded down


def tail_bound(cell: Cell, mean: Fraction, side: Literal["lower", "upper"]) -> int:
    """Bound the probability of a sum as small, or as large, as the observed one.

    Parameters
    ----------
    cell : Cell
        The draws.
    mean : Fraction
        The supposed mean of one draw.
    side : {"lower", "upper"}
        Whether sums at most, or at least, the observed one are meant.

    Returns
    -------
    int
        An upper bound of the probability in units of 2^-128, at most 2^128. Binary draws, up to 5,000 of them: the binomial tail, every
        step rounded up. More: exp(−n·kl) times min(1, 1/((1 − ρ)·sqrt(2πk(n−k)/n))), ρ the ratio of the two extreme terms (Stirling's
        bound for the extreme term, a geometric series for the others). Others: exp(−n·kl), which holds for all draws in [0, 1] because
        exp is convex.

    Examples
    --------
    >>> ten = Cell(10, Fraction(0), None, Fraction(0), Fraction(1), True)
    >>> tail_bound(ten, Fraction(1, 2), "lower") == 2**118
    True
    """
    if not cell.informative:
        return ONE
    width = cell.high - cell.low
    p = (mean - cell.low) / width
    k = cell.successes
    if side == "upper":
        p, k = 1 - p, cell.draws - k
    if p <= 0 or k == cell.draws:
        return ONE
    if p >= 1:
        return ONE if k == cell.draws else 0
    return _below(cell.draws, k, p, cell.binary)


@lru_cache(maxsize=200_000)
def _below(n: int, k: Fraction, p: Fraction, binary: bool) -> int:
    """Upper bound of P(sum ≤ k), 0 < p < 1, k < n, in units of 2^-BITS."""
    if not binary:
        return _chernoff(n, k, p, sharp=False)
    if n > EXACT_DRAWS:
        return _chernoff(n, k, p, sharp=True)
    top, bottom = p.numerator, p.denominator
    rest = bottom - top
    last = int(k)
    start = min(last, (n + 1) * top // bottom)
    high, high_at = power_above(top, bottom, start)
    low, low_at = power_above(rest, bottom, n - start)
    at = high_at + low_at + BITS
    term = comb(n, start) * high * low
    first = term << at if at >= 0 else -(-term >> -at)
    total = first
    for i, step in ((start, -1), (start, 1)):
        term = first
        while i > 0 if step < 0 else i < last:
            up, down = (i * rest, (n - i + 1) * top) if step < 0 else ((n - i) * top, (i + 1) * rest)
            term = -(-term * up // down)
            i += step
            if term <= 1:
                total += i + 1 if step < 0 else last - i + 1
                break
            total += term
    return min(total, ONE)


def _chernoff(n: int, k: Fraction, p: Fraction, *, sharp: bool) -> int:
    """exp(−n·kl(k/n, p)), with the factor for binomial tails if `sharp`, rounded up; units of 2^-BITS."""
    if k >= n * p:
        return ONE
    bits = BITS + 16 + n.bit_length()
    exponent = 0
    for part, expected in ((k, n * p), (n - k, n * (1 - p))):
        if part:
            ratio = part / expected
            low, _ = log_fixed(ratio.numerator, ratio.denominator, bits)
            exponent += part.numerator * low // part.denominator
    if exponent <= 0:
        return ONE
    if exponent >= 90 << bits:
        return 1
    low, _ = exp_enclosure((exponent, 1 << bits), BITS + 16)
    value = -(-(1 << (2 * BITS + 16)) // low)
    if sharp and k:
        ratio = k * (1 - p) / ((n - k + 1) * p)
        if ratio < 1:
            square = n / (2 * PI_BELOW * k * (n - k) * (1 - ratio) ** 2)
            if square < 1:
                root = isqrt((square.numerator << 2 * BITS) // square.denominator) + 1
                value = -(-value * root >> BITS)
    return min(value, ONE)
