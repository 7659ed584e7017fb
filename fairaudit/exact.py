"""Exact numbers: text and Python values read as the rationals that they are, and enclosures of logarithms.

A rational is carried as a pair of Python integers ``(numerator, denominator)`` with a positive denominator; infinity, where it can
occur, is ``(1, 0)``. Loops over cells stay in integers over one common denominator; `fractions.Fraction` appears only in results.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal, localcontext
from fractions import Fraction
from math import gcd, inf, lcm
from numbers import Integral, Rational
from typing import Any, Literal

__all__ = [
    "InputError",
    "approximate",
    "at_least",
    "common_denominator",
    "compare_log",
    "exp_enclosure",
    "fraction",
    "integer_text",
    "log_enclosure",
    "nearest",
    "option_value",
    "parse_rational",
    "quotient",
    "rational",
    "rational_text",
]

MAX_DIGITS = 4_000
MAX_EXPONENT = 4_000
MAX_OUTPUT_DIGITS = 100_000
LOG_DIGITS = 12

_NUMBER = re.compile(r"([+-]?)(?:(\d+)(?:\.(\d*))?|\.(\d+))(?:[eE]([+-]?\d+))?", re.ASCII)
_QUOTIENT = re.compile(r"([+-]?)(\d+)/(\d+)", re.ASCII)
_CHUNK = 4_000


class InputError(ValueError):
    """Input that cannot be audited; the message is one sentence: what, where, and what would be accepted."""


def shown(value: object, width: int = 60) -> str:
    """`repr` of a value from the input, cut to `width` characters, for use in a message."""
    try:
        text = repr(value)
    except ValueError:
        text = f"a number of about {int(getattr(value, 'bit_length', lambda: 0)()) * 3 // 10} digits"
    return text if len(text) <= width else text[: width - 1] + "…"


def nearest(word: str, known: Iterable[str]) -> str:
    """End a message with the known names and, where there is one, the name that was probably meant."""
    import difflib

    names = list(known)
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    meant = f"; did you mean {shown(close[0])}?" if close else ""
    listed = ", ".join(shown(name) for name in names[:20]) + (f", … ({len(names)} in all)" if len(names) > 20 else "")
    return f"known: {listed}{meant}"


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
    raise InputError(f"{shown(text)} is not a number such as 12, 0.25, 1e-3 or 1/3")


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


def approximate(value: Fraction | float, rounding: Literal["nearest", "down", "up"] = "nearest") -> str:
    """Four significant digits of an exact value, for a person.

    Examples
    --------
    >>> approximate(Fraction(24475, 18432)), approximate(Fraction(10**400, 3)), approximate(float("inf"))
    ('1.328', '3.333e+399', 'infinite')
    >>> approximate(Fraction(24475, 18432), "down"), approximate(Fraction(2, 3), "up")
    ('1.327', '0.6667')
    """
    if not isinstance(value, Fraction):
        return "infinite"
    if rounding == "nearest" and (value == 0 or Fraction(1, 10**300) < value < 10**300):
        return f"{float(value):.4g}"
    towards = {"nearest": ROUND_HALF_EVEN, "down": ROUND_FLOOR, "up": ROUND_CEILING}[rounding]
    with localcontext(Context(prec=4, rounding=towards, Emin=-999_999, Emax=999_999)) as context:
        return format(context.divide(Decimal(value.numerator), Decimal(value.denominator)), ".4g")


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


def log_enclosure(pair: tuple[int, int]) -> tuple[str, str]:
    """Enclose log R of a rational R ≥ 1 between two decimals of twelve digits.

    Parameters
    ----------
    pair : tuple of int
        R; ``(1, 0)`` for infinity.

    Returns
    -------
    tuple of str
        Lower and upper end, in nats; equal for R = 1 and R = ∞.

    Examples
    --------
    >>> log_enclosure((24475, 18432))
    ('0.283563903903', '0.283563903904')
    >>> log_enclosure((1, 1)), log_enclosure((1, 0))
    (('0', '0'), ('inf', 'inf'))
    """
    top, bottom = pair
    if bottom == 0:
        return "inf", "inf"
    if top == bottom:
        return "0", "0"
    if top < bottom:
        raise ValueError("log_enclosure takes a ratio of at least 1")
    scale = 10**LOG_DIGITS
    bits = 64
    while True:
        lo, hi = log_fixed(top, bottom, bits)
        below, above = (max(lo, 0) * scale) >> bits, (hi * scale) >> bits
        if below == above:
            return _decimal(below), _decimal(below + 1)
        bits *= 2


def compare_log(pair: tuple[int, int], limit: tuple[int, int]) -> int:
    """Compare log R with a rational limit, exactly.

    Parameters
    ----------
    pair : tuple of int
        R ≥ 1; ``(1, 0)`` for infinity.
    limit : tuple of int
        The limit ≥ 0, in nats.

    Returns
    -------
    int
        -1, 0 or 1 as log R is less than, equal to or greater than the limit. Equality is possible only at R = 1, limit 0: the
        logarithm of any other rational is irrational.

    Examples
    --------
    >>> compare_log((5, 4), (1, 5)), compare_log((1, 1), (0, 1)), compare_log((1, 0), (10, 1))
    (1, 0, 1)
    """
    top, bottom = pair
    at, over = limit
    if bottom == 0:
        return 1
    if top == bottom:
        return -1 if at > 0 else 0
    if at == 0:
        return 1
    if at >= over * (top.bit_length() - bottom.bit_length() + 1):
        return -1
    bits = 64
    while True:
        lo, hi = log_fixed(top, bottom, bits)
        if lo * over > at << bits:
            return 1
        if hi * over < at << bits:
            return -1
        bits *= 2


def exp_enclosure(exponent: tuple[int, int], bits: int) -> tuple[int, int]:
    """Enclose e^q for a rational q ≥ 0.

    Parameters
    ----------
    exponent : tuple of int
        q as numerator and denominator; at most 10,000.
    bits : int
        Binary digits after the point.

    Returns
    -------
    tuple of int
        lo, hi with lo ≤ 2^bits·e^q ≤ hi, a few units apart.

    Raises
    ------
    InputError
        If q is greater than 10,000.

    Examples
    --------
    >>> lo, hi = exp_enclosure((1, 1), 20)
    >>> lo <= 2.718281828 * 2**20 <= hi, hi - lo <= 4
    (True, True)
    """
    top, bottom = exponent
    if top > 10_000 * bottom:
        raise InputError("an exponent above 10,000 is not accepted")
    # e^q = (e^(q/2^s))^(2^s) with q/2^s < 1/2^8; squaring s times loses at most s + 1 bits beyond the size of the result.
    squarings = 8 + max(0, top.bit_length() - bottom.bit_length() + 1)
    work = bits + 2 * squarings + 16 + 2 * (top // bottom + 1)
    z_low = (top << work) // (bottom << squarings)
    low = _exp_series(z_low, work, 0)
    high = _exp_series(z_low + 1, work, 1)
    for _ in range(squarings):
        low, high = (low * low) >> work, ((high * high) >> work) + 1
    drop = work - bits
    return low >> drop, -(-high >> drop)


def _exp_series(z: int, work: int, up: int) -> int:
    """Σ z^n/n! in units of 2^-work, every step rounded down (`up` 0) or up (1); all terms are positive.

    Rounded up, the first term of one unit or less ends the sum; what is left out is less than one unit, for z ≤ 2^-8.
    """
    total, term, n = 1 << work, 1 << work, 1
    while term > up:
        term = (term * z >> work) // n + up
        total += term
        n += 1
    return total + up


def _lowest(top: int, bottom: int) -> tuple[int, int]:
    common = gcd(top, bottom)
    return top // common, bottom // common


def _decimal(units: int) -> str:
    whole, rest = divmod(units, 10**LOG_DIGITS)
    return f"{whole}.{rest:0{LOG_DIGITS}d}"


def log_fixed(top: int, bottom: int, bits: int) -> tuple[int, int]:
    """Integers lo, hi with lo ≤ 2^bits·log(top/bottom) ≤ hi."""
    shift = top.bit_length() - bottom.bit_length()
    work = bits + 16 + abs(shift).bit_length()
    if shift >= 0:
        bottom <<= shift
    else:
        top <<= -shift
    # top/bottom now lies strictly between 1/2 and 2, so |(top − bottom)/(top + bottom)| < 1/3.
    low, high = _atanh_fixed(top - bottom, top + bottom, work)
    low2, high2 = _atanh_fixed(1, 3, work)
    total_low = 2 * low + 2 * (shift * low2 if shift >= 0 else shift * high2)
    total_high = 2 * high + 2 * (shift * high2 if shift >= 0 else shift * low2)
    drop = work - bits
    return total_low >> drop, -(-total_high >> drop)


def _atanh_fixed(top: int, bottom: int, work: int) -> tuple[int, int]:
    """Integers around 2^work·atanh(top/bottom), for |top/bottom| ≤ 1/3.

    With z and its powers rounded down at every step, the error e of a power obeys e' ≤ e/9 + 1.6, so e < 2; a term is off by less than
    2/(2j+1) + 1 ≤ 3 units, the truncated tail by less than 3, and z itself by one unit times atanh' ≤ 9/8.
    """
    if top < 0:
        low, high = _atanh_fixed(-top, bottom, work)
        return -high, -low
    z = (top << work) // bottom
    square = (z * z) >> work
    power, order, total, terms = z, 1, 0, 0
    while power:
        total += power // order
        power = (power * square) >> work
        order += 2
        terms += 1
    slack = 3 * terms + 6
    return total - slack, total + slack
