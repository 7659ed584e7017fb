"""Positive numbers as a mantissa and an exponent of 2, rounded down or up on purpose: products and powers bounded from one side."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

BITS = 128  # a probability or a wealth is known to one part in 2^128, far below any level that is asked for

WORK = BITS + 64  # of powers that are rounded up: what a few dozen roundings cost stays below one part in 2^128


def power_above(top: int, bottom: int, exponent: int) -> tuple[int, int]:
    """Mantissa m and exponent e with m·2^e ≥ (top/bottom)^exponent, barely."""
    shift = WORK + bottom.bit_length() - top.bit_length()
    base, base_at = -(-(top << shift) // bottom), -shift
    result, at = 1, 0
    while exponent:
        if exponent & 1:
            result, at = _rounded_up(result * base, at + base_at)
        base, base_at = _rounded_up(base * base, 2 * base_at)
        exponent >>= 1
    return result, at


def _rounded_up(mantissa: int, at: int) -> tuple[int, int]:
    drop = mantissa.bit_length() - WORK
    return (-(-mantissa >> drop), at + drop) if drop > 0 else (mantissa, at)


Number = tuple[int, int]
"""Mantissa and exponent of 2, rounded down."""


def number_below(value: Fraction) -> Number:
    """The greatest number of `BITS` digits that is at most a positive rational."""
    shift = BITS - value.numerator.bit_length() + value.denominator.bit_length()
    return _cut((value.numerator << shift) // value.denominator if shift >= 0 else value.numerator // (value.denominator << -shift), -shift)


def _cut(m: int, e: int) -> Number:
    drop = max(0, m.bit_length() - BITS)
    return m >> drop, e + drop


def product_below(a: Number, b: Number) -> Number:
    """The product of two numbers, rounded down."""
    return _cut(a[0] * b[0], a[1] + b[1])


def power_below(base: Number, exponent: int) -> Number:
    """A power of a number, rounded down at each squaring."""
    result: Number = (1, 0)
    while exponent:
        if exponent & 1:
            result = product_below(result, base)
        base = product_below(base, base)
        exponent >>= 1
    return result


def sum_below(parts: Sequence[Number]) -> Number:
    """The sum of some numbers, rounded down: digits 2^256 times smaller than the greatest are left out."""
    top = max(m.bit_length() + e for m, e in parts)
    at = top - 2 * BITS
    return sum(m << (e - at) if e >= at else m >> (at - e) for m, e in parts), at
