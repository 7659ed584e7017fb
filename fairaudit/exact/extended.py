"""Exact numbers and infinity: as one type, as a pair, as a text."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

from fairaudit.exact.rationals import rational_text

Extended = Fraction | float
"""A rational, or `math.inf`."""

ZERO: Final = Fraction(0)

ONE: Final = Fraction(1)


def extended_text(value: Extended) -> str:
    """Write a rational in lowest terms, infinity as ``inf``."""
    top, bottom = extended_pair(value)
    small = bottom > 0 and top.bit_length() + bottom.bit_length() < 1_000  # in lowest terms already
    return (f"{top}/{bottom}" if bottom > 1 else str(top)) if small else rational_text((top, bottom))


def extended_pair(value: Extended) -> tuple[int, int]:
    """Numerator and denominator; ``(1, 0)`` for infinity."""
    return (1, 0) if isinstance(value, float) else (value.numerator, value.denominator)
