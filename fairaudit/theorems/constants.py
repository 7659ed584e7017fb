"""The constants of theorems as they are given: e^ε, probabilities, floors and ranges, read and checked."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import at_least

# Reading numbers


def is_infinite(value: object) -> bool:
    """Whether a number was given as `math.inf`."""
    return isinstance(value, float) and value == inf


def read_ratio(name: str, value: Any) -> Extended:
    """A ratio of at least 1, possibly infinite; `name` is what an error calls it."""
    return inf if is_infinite(value) else at_least(name, value, 1)


def read_factor(exp_epsilon: Any) -> Extended:
    """e^ε of a filter."""
    return read_ratio("exp_epsilon (e to the power epsilon)", exp_epsilon)


def read_probability(name: str, value: Any) -> Fraction:
    """A number from 0 to 1; `name` is what an error calls it."""
    number = at_least(name, value, 0)
    if number > 1:
        raise InputError(f"{name} is {shown(value)}; a number from 0 to 1 is accepted")
    return number


def read_level(t: Any) -> Fraction:
    """A floor as a part of the greatest utility."""
    number = at_least("t", t, 0)
    if not 0 < number <= 1:
        raise InputError(f"t is {shown(t)}; a floor above 0 and at most 1, as a part of the greatest utility, is accepted")
    return number


def read_chance(tau: Any) -> Fraction:
    """A floor under the chance of each of at least two persons."""
    number = at_least("tau", tau, 0)
    if not 0 < number <= Fraction(1, 2):
        raise InputError(f"tau is {shown(tau)}; a chance above 0 and at most 1/2, that of every one of at least two persons, is accepted")
    return number


def read_range(gamma: Any, tau: Any) -> tuple[Fraction, Fraction]:
    """The greatest utility and a floor under it."""
    top, low = at_least("gamma", gamma, 0), at_least("tau", tau, 0)
    if top == 0:
        raise InputError("gamma is 0; the greatest utility must be above 0")
    if low > top:
        raise InputError(f"tau is {shown(tau)}, above gamma, which is {shown(gamma)}; a floor of at most the greatest utility is accepted")
    return top, low
