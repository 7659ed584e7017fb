"""Targets and caps of a filter, as they are given and as they are said."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.enclosures import exp_below, log_enclosure
from fairaudit.exact.rationals import at_least
from fairaudit.measures.limits import Quantity, one_limit
from fairaudit.words import approximate

QUANTITIES: tuple[Quantity, ...] = ("local", "global")

TARGET_BITS = 80
"""A logarithm is read as its exponential rounded down to these binary digits: below 10^-23, far less than the grids of the filters."""

MOST_LOG = 10_000
"""The greatest logarithm that is read; its exponential has 4,343 digits."""


def read_target(max_ratio: Any, max_log: Any) -> Fraction | None:
    """The target of a design as a ratio, rounded down where a logarithm was given; None for a cap alone."""
    if max_ratio is None and max_log is None:
        return None
    unit, limit = one_limit(max_ratio, max_log)
    return limit if unit == "ratio" else _exp_of("max_log", max_log)


def read_cap(epsilon: Any, factor: Any) -> Fraction | None:
    """The cap on ε as e^ε, rounded down where ε was given; None for no cap."""
    if epsilon is not None and factor is not None:
        raise InputError("max_epsilon and max_exp_epsilon were given; give at most one")
    if factor is not None:
        number = at_least("max_exp_epsilon", factor, 0)
        if number < 1:
            raise InputError(f"max_exp_epsilon is {shown(factor)}; a factor e^ε of at least 1 is accepted")
        return number
    return None if epsilon is None else _exp_of("max_epsilon", epsilon)


def require_target_or_cap(target: Fraction | None, cap: Fraction | None) -> None:
    """Refuse a design that nothing limits."""
    if target is None and cap is None:
        raise InputError("neither a target nor a cap on epsilon was given; the identity filter distorts nothing")


def calibration_target(max_ratio: Any, max_log: Any, quantity: str) -> Fraction:
    """The target of a calibration as a ratio above 1, rounded down where a logarithm was given."""
    if quantity not in QUANTITIES:
        raise InputError(f"quantity={shown(quantity)} is not accepted; {nearest(str(quantity), QUANTITIES)}")
    unit, limit = one_limit(max_ratio, max_log)
    if unit == "ratio":
        if limit == 1:
            raise InputError(f"max_ratio is {shown(max_ratio)}; a ratio other than 1 is accepted (1 needs a filter that hides everything)")
        return limit
    if limit == 0:
        raise InputError(f"max_log is {shown(max_log)}; a logarithm above 0 is accepted (0 needs a filter that hides everything)")
    return _exp_of("max_log", max_log)


def _exp_of(name: str, value: Any) -> Fraction:
    """Exponential of the value, rounded down, and at least 1."""
    number = at_least(name, value, 0)
    if number > MOST_LOG:
        raise InputError(f"{name} is {shown(value)}; a number from 0 to {MOST_LOG:,} is accepted")
    return exp_below(number, TARGET_BITS)


def ratio_and_log(ratio: Fraction) -> tuple[str, str]:
    """A finite ratio and its logarithm in six digits for a sentence, rounded up: as targets they are no smaller.

    Examples
    --------
    >>> ratio_and_log(Fraction(4, 3)), ratio_and_log(Fraction(5, 4))
    (('1.33334', '0.287683'), ('1.25', '0.223144'))
    """
    logarithm = Fraction(log_enclosure(ratio.as_integer_ratio())[1])
    return approximate(ratio, "up", 6), approximate(logarithm, "up", 6)
