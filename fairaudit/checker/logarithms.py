"""Logarithms of rationals: compared and enclosed in integers."""

from __future__ import annotations

from math import isqrt

from .rationals import INFINITY, ONE, ZERO, Rational, at_most
from .work import spend

LOG_SCALE = 10**12  # the format has twelve decimals


def _atanh(z: int, bits: int, up: int) -> int:
    """Bound 2^bits atanh(z / 2^bits), 0 <= 3z <= 2^bits (a few units more do no harm), from below or above.

    All terms of z + z^3/3 + z^5/5 + ... are positive, so rounding every step down (``up`` 0) gives a lower bound, and
    rounding every step up (``up`` 1) an upper bound.  Rounded up, a power never falls below one unit; from there the
    terms left out add up to less than two units.
    """
    total, power, square, odd = 0, z, (z * z >> bits) + up, 1
    while power > up:
        total += power // odd + up
        power = (power * square >> bits) + up
        odd += 2
    return total + 2 * up


def log_bounds(n: int, d: int, bits: int) -> tuple[int, int]:
    """Integers low, high with low <= 2^bits log(n/d) <= high, for n > d > 0; closer together for more bits.

    log R = 2^r log R^(1/2^r), and log m = 2 atanh((m - 1) / (m + 1)).  Square roots bring m close to 1, where the
    series needs few terms; an R that is close to 1 already needs fewer roots.
    """
    size, closeness = n.bit_length() - d.bit_length() + 1, d.bit_length() - (n - d).bit_length()
    roots = max(0, size.bit_length() + 8 + isqrt(bits) // 4 - max(0, closeness))
    spend(4 * (roots + bits // (roots + 4)) + 40, bits, bits)
    spend(2, n.bit_length() + bits, d.bit_length())
    one = 1 << bits
    low = (n << bits) // d
    high = low + 1
    for _ in range(roots):
        low, high = isqrt(low << bits), isqrt(high << bits) + 1
    z_low = ((low - one) << bits) // (low + one)
    z_high = ((high - one) << bits) // (high + one) + 1
    return _atanh(z_low, bits, 0) << (roots + 1), _atanh(z_high, bits, 1) << (roots + 1)


def log_floor(ratio: Rational, scale: int) -> int:
    """Compute floor(scale log R) for a finite R > 1 (an irrational logarithm: some precision decides)."""
    bits = 128
    while True:
        low, high = log_bounds(*ratio, bits)
        if low * scale >> bits == high * scale >> bits:
            return low * scale >> bits
        bits *= 2


def log_at_most(ratio: Rational, limit: Rational) -> bool:
    """Decide log R <= q exactly, for R >= 1 (possibly infinite) and a finite q >= 0."""
    n, d = ratio
    if d == 0 or limit == ZERO or n == d:
        return n == d
    if limit[0] >= (n.bit_length() - d.bit_length() + 1) * limit[1]:  # log R < log2 R < this
        return True
    if at_most((n - d, d), limit):  # log R < R - 1
        return True
    if at_most(limit, (n - d, n)):  # log R > 1 - 1/R
        return False
    bits = 128
    while True:  # log R is irrational, q is not, so that some precision tells them apart
        low, high = log_bounds(n, d, bits)
        if high * limit[1] <= limit[0] << bits:
            return True
        if low * limit[1] >= limit[0] << bits:
            return False
        bits *= 2


def log_enclosure(ratio: Rational) -> tuple[str, str]:
    """Write the enclosure of log R, for R >= 1, as the format wants it."""
    if ratio == ONE:
        return "0", "0"
    if ratio == INFINITY:
        return "inf", "inf"
    low = log_floor(ratio, LOG_SCALE)
    return _decimal(low), _decimal(low + 1)


def _decimal(units: int) -> str:
    return f"{units // LOG_SCALE}.{units % LOG_SCALE:012d}"
