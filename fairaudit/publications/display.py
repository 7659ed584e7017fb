"""How figures of a publication are written: rounded half up, with more digits where rounding would move one across a limit."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from fairaudit.exact.rationals import rational_text

__all__ = ["NONE", "WITHHELD", "deviations_text", "exact_text", "half_up", "rate_text", "ratio_text"]

NONE = "–"
"""Stands where there is no figure."""

WITHHELD = "withheld"
"""Stands where there is one that is not published."""

LIMITS = (Fraction(0), Fraction(4, 5), Fraction(1))
"""No figure moves across one of these, or onto it."""


def half_up(value: Fraction, digits: int, limits: tuple[Fraction, ...] = ()) -> str:
    """Write a number with so many digits after the point, half up (away from zero), with more where it would cross or meet a limit.

    Examples
    --------
    >>> half_up(Fraction(1, 8), 2), half_up(Fraction(-1, 8), 2)
    ('0.13', '-0.13')
    >>> half_up(Fraction(7999, 10000), 3, LIMITS), half_up(Fraction(4, 5), 3, LIMITS)
    ('0.7999', '0.800')
    """
    top, bottom = abs(value.numerator), value.denominator
    while True:
        scaled = (2 * top * 10**digits + bottom) // (2 * bottom)
        written = Fraction(scaled if value >= 0 else -scaled, 10**digits)
        if all(_side(written, limit) == _side(value, limit) for limit in limits):
            return f"{'-' if written < 0 else ''}{_pointed(scaled, digits)}"
        digits += 1


def _side(value: Fraction, limit: Fraction) -> int:
    return (value > limit) - (value < limit)


def _pointed(scaled: int, digits: int) -> str:
    text = str(scaled).rjust(digits + 1, "0")
    return f"{text[:-digits]}.{text[-digits:]}" if digits else text


def rate_text(rate: Fraction | None) -> str:
    """A rate as a percentage with one decimal.

    Examples
    --------
    >>> rate_text(Fraction(205, 408)), rate_text(Fraction(9999, 10000)), rate_text(None)
    ('50.2 %', '99.99 %', '–')
    """
    return NONE if rate is None else f"{half_up(100 * rate, 1, tuple(100 * limit for limit in LIMITS))} %"


def ratio_text(ratio: Fraction | None) -> str:
    """A ratio with three decimals.

    Examples
    --------
    >>> ratio_text(Fraction(555 * 1390, 1181 * 667)), ratio_text(Fraction(9999, 10000)), ratio_text(Fraction(1))
    ('0.979', '0.9999', '1.000')
    """
    return NONE if ratio is None else half_up(ratio, 3, LIMITS)


def exact_text(value: Fraction | None) -> str | None:
    """A rational as every JSON has it; None where there is none.

    Examples
    --------
    >>> exact_text(Fraction(2, 4)), exact_text(None)
    ('1/2', None)
    """
    return None if value is None else rational_text((value.numerator, value.denominator))


def deviations_text(square: Fraction | None) -> str:
    """The root of a squared number of standard deviations with two decimals, exactly half up; 2 is neither crossed nor met.

    Examples
    --------
    >>> deviations_text(Fraction(4)), deviations_text(Fraction(40001, 10000)), deviations_text(Fraction(9, 4))
    ('2.00', '2.00002', '1.50')
    """
    if square is None:
        return NONE
    digits = 2
    while True:
        scaled = (isqrt(4 * 10 ** (2 * digits) * square.numerator // square.denominator) + 1) // 2
        if _side(Fraction(scaled, 10**digits), Fraction(2)) == _side(square, Fraction(4)):
            return _pointed(scaled, digits)
        digits += 1
