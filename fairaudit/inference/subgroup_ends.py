"""Ends of the means of a subgroup and of the rest, which hold for all conjunctions of a family at once."""

from __future__ import annotations

from fractions import Fraction
from math import inf

from fairaudit.exact.extended import Extended
from fairaudit.inference.cells import Cell, Ends
from fairaudit.inference.ends import cell_ends

__all__ = ["both_ends", "end_level", "ratio_ends"]


def end_level(confidence: Fraction, family: int) -> Fraction:
    """The error of each of the four ends of a conjunction: an interval for its mean and one for the rest, at α/(2M) each.

    Examples
    --------
    >>> end_level(Fraction(19, 20), 20)
    Fraction(1, 1600)
    """
    return (1 - confidence) / (4 * family)


def both_ends(own: Cell, rest: Cell, confidence: Fraction, family: int) -> tuple[Ends, Ends]:
    """Ends of the mean of a subgroup and of that of the rest, of any of `family` conjunctions that were fixed beforehand.

    Examples
    --------
    >>> ten, many = (Cell(n, Fraction(n, 2), None, Fraction(0), Fraction(1), True) for n in (10, 1000))
    >>> both_ends(ten, many, Fraction(19, 20), 20)[1]
    (Fraction(224311, 500000), Fraction(275689, 500000))
    """
    level = end_level(confidence, family)
    return cell_ends(own, level), cell_ends(rest, level)


def ratio_ends(own: Ends, rest: Ends) -> tuple[Extended, Extended]:
    """What ends of two means leave of the greater over the less.

    Examples
    --------
    >>> ratio_ends((Fraction(1, 4), Fraction(1, 2)), (Fraction(3, 4), Fraction(1)))
    (Fraction(3, 2), Fraction(4, 1))
    """
    lower = max(Fraction(1), _over(own[0], rest[1]), _over(rest[0], own[1]))
    return lower, max(Fraction(1), _over(own[1], rest[0]), _over(rest[1], own[0]))


def _over(one: Fraction, other: Fraction) -> Extended:
    return one / other if other else Fraction(1) if one == 0 else inf
