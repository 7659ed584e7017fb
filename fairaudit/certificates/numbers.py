"""How a certificate writes numbers: exact rationals as text, ends of logarithms as decimals."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

from fairaudit.exact.rationals import rational_text


def number(value: Fraction | float) -> str:
    """A result as a certificate stores it."""
    return rational_text((value.numerator, value.denominator) if isinstance(value, Fraction) else (1, 0))


def log_text(value: Decimal) -> str:
    """One end of an enclosure of a logarithm, all of its decimals."""
    return "inf" if value.is_infinite() else format(value, "f")
