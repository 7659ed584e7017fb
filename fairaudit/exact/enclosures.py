"""Logarithms and exponentials of rationals, as enclosures; comparing them raises the precision until it is decided.

And the two constants with which passes in floating point bound their own error.
"""

from __future__ import annotations

from fractions import Fraction

from fairaudit.errors import InputError

__all__ = ["HUGE", "UNIT", "compare_log", "exp_below", "exp_enclosure", "log_enclosure"]


LOG_DIGITS = 12  # decimals of a logarithm as certificates state it; the format fixes them

UNIT = 2.0**-53
"""The relative error of one rounding to the nearest float64 is at most this."""

HUGE = 1e300
"""Stands for infinity where floats must stay finite: a few of them may still be added or multiplied by small numbers."""


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


def exp_below(exponent: Fraction, bits: int) -> Fraction:
    """e^q of a rational q from 0 to 10,000, rounded down by a few units of 2^-bits, and at least 1.

    A target that was given as a logarithm, or a cap on ε, is kept when its exponential is taken too low.

    Examples
    --------
    >>> exp_below(Fraction(0), 80), float(exp_below(Fraction(1), 80))
    (Fraction(1, 1), 2.718281828459045)
    """
    low, _ = exp_enclosure((exponent.numerator, exponent.denominator), bits)
    return max(Fraction(1), Fraction(low, 1 << bits))


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
