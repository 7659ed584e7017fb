"""Text and Python values read as the rationals that they are, and rationals written as text.

A rational is carried as a pair of Python integers ``(numerator, denominator)`` with a positive denominator; infinity, where it can
occur, is ``(1, 0)``. Loops over cells stay in integers over one denominator.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from math import gcd, inf, lcm
from numbers import Integral, Rational
from typing import Any

from fairaudit.errors import InputError, shown

__all__ = [
    "Number",
    "at_least",
    "common_denominator",
    "decimal_text",
    "exact",
    "fraction",
    "integer_text",
    "number",
    "option_value",
    "parse_rational",
    "quotient",
    "rational",
    "rational_text",
    "shortened",
]


Number = int | str | Fraction | Decimal | float
"""A number in Python: exact as it is, but for a float, which is read as `option_value` or `rational` says."""

MAX_DIGITS = 4_000  # below the 4,300 digits at which Python refuses to read a number

MAX_EXPONENT = 4_000  # so that 1e4000 has as many digits as may be written out

MAX_OUTPUT_DIGITS = 100_000  # what the checker reads, too


_NUMBER = re.compile(r"([+-]?)(?:(\d+)(?:\.(\d*))?|\.(\d+))(?:[eE]([+-]?\d+))?", re.ASCII)

_QUOTIENT = re.compile(r"([+-]?)(\d+)/(\d+)", re.ASCII)

SHORT_BITS = 4_000
"""Denominators of up to so many bits are divided by as they are."""

SHORT_PLACES = 400
"""Decimals that a person may be shown, and many more."""

_CHUNK = 4_000  # digits that Python writes at once; below its limit of 4,300


def parse_rational(text: str) -> tuple[int, int]:
    """Read a number from text as exactly the rational that it says.

    Parameters
    ----------
    text : str
        A decimal (``0.1``, ``12``, ``1e-3``) or a quotient of integers (``1/3``); blanks around it are ignored.

    Returns
    -------
    tuple of int
        Numerator and positive denominator, in lowest terms.

    Raises
    ------
    InputError
        If the text is not such a number, has more than 4,000 digits, or an exponent beyond ±4,000.

    Examples
    --------
    >>> parse_rational("0.1"), parse_rational("1/3"), parse_rational("-2.50e1")
    ((1, 10), (1, 3), (-25, 1))
    """
    text = text.strip()
    if len(text) > 2 * MAX_DIGITS + 10:
        raise InputError(f"a number of {len(text)} characters is too long; at most {MAX_DIGITS} digits are accepted")
    match = _NUMBER.fullmatch(text)
    if match:
        sign, whole, point, bare, power = match.groups()
        decimals = (point if bare is None else bare) or ""
        digits = (whole or "") + decimals
        if len(digits) > MAX_DIGITS or (power is not None and (len(power) > 6 or abs(int(power)) > MAX_EXPONENT)):
            raise InputError(f"the number {shown(text)} has more than {MAX_DIGITS} digits or an exponent beyond ±{MAX_EXPONENT}")
        exponent = int(power or 0) - len(decimals)
        numerator = -int(digits) if sign == "-" else int(digits)
        if exponent >= 0:
            return numerator * 10**exponent, 1
        return _lowest(numerator, 10**-exponent)
    match = _QUOTIENT.fullmatch(text)
    if match:
        sign, top, bottom = match.groups()
        if max(len(top), len(bottom)) > MAX_DIGITS:
            raise InputError(f"the number {shown(text)} has more than {MAX_DIGITS} digits")
        if int(bottom) == 0:
            raise InputError(f"{shown(text)} divides by zero")
        return _lowest(-int(top) if sign == "-" else int(top), int(bottom))
    percent = re.fullmatch(r"([0-9]{1,6}) ?%", text)
    meant = f"; {shown(text)} is {int(percent[1]) / 100:g}" if percent else ""
    raise InputError(f"{shown(text)} is not a number such as 12, 0.25, 1e-3 or 1/3{meant}")


def rational(value: object) -> tuple[int, int]:
    """Read a Python or numpy number, or a text, as the exact rational that it is.

    A float is the dyadic rational that it stores: ``0.1`` is 3602879701896397/36028797018963968; write ``"0.1"`` for 1/10,
    or read it with `option_value`.

    Parameters
    ----------
    value : int, float, Fraction, Decimal, str or numpy scalar
        The number.

    Returns
    -------
    tuple of int
        Numerator and positive denominator, in lowest terms.

    Raises
    ------
    InputError
        If it is not a finite number.

    Examples
    --------
    >>> rational(0.5), rational("0.1"), rational(Fraction(2, 3))
    ((1, 2), (1, 10), (2, 3))
    """
    if isinstance(value, str):
        return parse_rational(value)
    if isinstance(value, bool):
        raise InputError(f"{value} is a truth value, not a number")
    if isinstance(value, Integral):
        return int(value), 1
    if isinstance(value, Rational):
        return int(value.numerator), int(value.denominator)
    if isinstance(value, Decimal) and value.is_finite():
        exponent = value.as_tuple().exponent
        if isinstance(exponent, int) and abs(exponent) > MAX_EXPONENT:
            raise InputError(f"the number {shown(value)} has an exponent beyond ±{MAX_EXPONENT}")
    parts: Callable[[], tuple[int, int]] | None = getattr(value, "as_integer_ratio", None)
    if parts is None:
        raise InputError(f"{shown(value)} is not a number")
    try:
        return parts()
    except (OverflowError, ValueError):
        raise InputError(f"{shown(value)} is not a finite number") from None


def exact(value: object, where: str = "") -> Fraction:
    """Read a number as `rational` does, as a `Fraction`.

    Raises
    ------
    InputError
        If it is not a finite number; the message begins with `where`.

    Examples
    --------
    >>> exact("0.1"), exact(0.5)
    (Fraction(1, 10), Fraction(1, 2))
    """
    try:
        return Fraction(*rational(value))
    except InputError as error:
        raise InputError(f"{where}{error}") from None


def option_value(value: object) -> tuple[int, int]:
    """Read a number that was given as an option: as `rational` does, but a float is the decimal that it is printed as.

    Who writes 0.2 means 1/5. An entry of an array of floats stays the dyadic rational that it stores.

    Raises
    ------
    InputError
        If it is not a finite number.

    Examples
    --------
    >>> option_value(0.2), option_value("1/3"), option_value(Fraction(0.2)) == rational(0.2)
    ((1, 5), (1, 3), True)
    """
    pair = rational(value)
    if isinstance(value, (str, Decimal, Rational)):
        return pair
    return parse_rational(str(value))


def at_least(name: str, value: object, least: int, read: Callable[[object], tuple[int, int]] = option_value) -> Fraction:
    """Read a named number that must not be below a least value, exactly; by default one that was given as an option.

    Raises
    ------
    InputError
        If it is not a finite number, or below `least`; the message begins with the name.

    Examples
    --------
    >>> at_least("exp_epsilon", "7/3", 1)
    Fraction(7, 3)
    """
    try:
        number = Fraction(*read(value))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    if number < least:
        raise InputError(f"{name} is {shown(value)}; a number of at least {least} is accepted")
    return number


def fraction(pair: tuple[int, int]) -> Fraction | float:
    """Turn a pair into a `Fraction`, and ``(1, 0)`` into `math.inf`.

    Examples
    --------
    >>> fraction((2, 4)), fraction((1, 0))
    (Fraction(1, 2), inf)
    """
    return Fraction(*pair) if pair[1] else inf


def quotient(top: Any, bottom: Any) -> Any:
    """Divide non-negative exact numbers by the conventions for ratios: 0/0 is parity, 1, and c/0 infinite.

    Examples
    --------
    >>> quotient(Fraction(1), Fraction(2)), quotient(Fraction(0), Fraction(0)), quotient(Fraction(1), Fraction(0))
    (Fraction(1, 2), Fraction(1, 1), inf)
    """
    if bottom == 0:
        return Fraction(1) if top == 0 else inf
    return top / bottom


def common_denominator(pairs: Sequence[tuple[int, int]]) -> tuple[list[int], int]:
    """Write rationals as integers over their least common denominator.

    Examples
    --------
    >>> common_denominator([(1, 2), (1, 3)])
    ([3, 2], 6)
    """
    bottom = lcm(*{d for _, d in pairs})
    if bottom.bit_length() > MAX_OUTPUT_DIGITS * 10 // 3:
        raise InputError(f"the common denominator of the numbers has more than {MAX_OUTPUT_DIGITS} digits; use fewer denominators")
    if bottom == 1:
        return [n for n, _ in pairs], 1
    return [n * (bottom // d) for n, d in pairs], bottom


def integer_text(number: int) -> str:
    """Write an integer of any length in decimal, without the interpreter's limit of 4,300 digits.

    Examples
    --------
    >>> integer_text(-10**5000)[:3], len(integer_text(10**5000))
    ('-10', 5001)
    """
    if number < 0:
        return "-" + integer_text(-number)
    if number.bit_length() < 14_000:
        return str(number)
    half = _CHUNK
    while 10 ** (2 * half) <= number:
        half *= 2
    high, low = divmod(number, 10**half)
    return integer_text(high) + integer_text(low).zfill(half)


def rational_text(pair: tuple[int, int]) -> str:
    """Write a rational in lowest terms, as a certificate stores it; ``(1, 0)`` is ``inf``.

    Raises
    ------
    InputError
        If it needs more than 100,000 digits.

    Examples
    --------
    >>> rational_text((2, 4)), rational_text((3, 1)), rational_text((1, 0))
    ('1/2', '3', 'inf')
    """
    top, bottom = pair
    if bottom == 0:
        return "inf"
    top, bottom = _lowest(top, bottom)
    if max(top.bit_length(), bottom.bit_length()) > MAX_OUTPUT_DIGITS * 3:
        raise InputError(f"an exact result has more than {MAX_OUTPUT_DIGITS * 9 // 10} digits; use numbers with fewer denominators")
    return integer_text(top) if bottom == 1 else f"{integer_text(top)}/{integer_text(bottom)}"


def number(value: Fraction | float) -> str:
    """Write a result as a certificate stores it: a `Fraction`, or `math.inf`.

    Examples
    --------
    >>> number(Fraction(5, 4)), number(inf)
    ('5/4', 'inf')
    """
    return rational_text((value.numerator, value.denominator) if isinstance(value, Fraction) else (1, 0))


def shortened(value: Fraction) -> Fraction:
    """The value itself if it is short, else a short one that every decimal of at most 400 places is below, or above, as it is of the value.

    It is rounded alike to all those decimals.

    Examples
    --------
    >>> shortened(Fraction(1, 3))
    Fraction(1, 3)
    >>> shortened(Fraction(10**2000, 3 * 10**2000 + 1)).denominator == 2 * 10**400
    True
    """
    if value.denominator.bit_length() < SHORT_BITS:
        return value
    whole, rest = divmod(value.numerator * 10**SHORT_PLACES, value.denominator)
    return Fraction(2 * whole + (rest > 0), 2 * 10**SHORT_PLACES)


def decimal_text(value: Fraction) -> str:
    """Write a rational with at most 30 decimals as these, any other as a quotient.

    Examples
    --------
    >>> decimal_text(Fraction(129, 2)), decimal_text(Fraction(-1, 3))
    ('64.5', '-1/3')
    """
    places = next((n for n in range(31) if 10**n % value.denominator == 0), None)
    if not places:
        return number(value)
    digits = integer_text(abs(value.numerator) * (10**places // value.denominator)).rjust(places + 1, "0")
    return f"{'-' * (value < 0)}{digits[:-places]}.{digits[-places:]}"


def _lowest(top: int, bottom: int) -> tuple[int, int]:
    common = gcd(top, bottom)
    return top // common, bottom // common
