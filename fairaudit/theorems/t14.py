"""T14: how strong an unrecorded factor would have to be to explain a ratio away, and what a declared one leaves of it.

V is a factor that the table does not record. In one context it is at most k times as common in one group as in another, and over its values
the expectations of one of two groups differ at most m times. Then among people who are alike in it, too, some ratio is at least a part of
the one that was seen: (m + k)/(1 + mk). The whole table, contexts and all, is one context for the global ratio.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from math import inf, isqrt
from typing import Any, Literal, get_args

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import at_least
from fairaudit.theorems.constants import read_ratio
from fairaudit.words import brief

__all__ = ["Direction", "Frontier", "HiddenContext", "attaining", "balanced_strength", "frontier", "least_change", "least_ratio"]

Direction = Literal["both", "higher", "lower"]

DIGITS = 6
"""Decimals of a balanced strength, which is rounded down."""

ROWS = 4
"""Rows of a frontier."""

MOST = 10**9
"""A frontier of a ratio above this has no rows: the balanced strength is about twice the ratio."""


@brief
@dataclass(frozen=True, repr=False)
class HiddenContext:
    """What is declared of an unrecorded factor.

    Attributes
    ----------
    k : Fraction
        How many times as common each of its values is at most in one group as in another of the same context.
    m : Fraction or float
        How many times the expectation of one of the two groups differs at most over its values; `math.inf` is no limit.
    direction : {"both", "higher", "lower"}
        Where k is a limit: whichever group comes first; only where a value is more common in the group with the higher expectation; only
        where it is more common in that with the lower. The last two allow values that one group never has, and m is then about the group
        with the lower expectation, or with the higher.

    Examples
    --------
    >>> HiddenContext.of("2,5/2"), HiddenContext.of(("2", "inf", "lower")).remaining
    (HiddenContext(k=Fraction(2, 1), m=Fraction(5, 2), direction='both'), Fraction(0, 1))
    """

    k: Fraction
    m: Extended
    direction: Direction = "both"

    @classmethod
    def of(cls, given: Any) -> HiddenContext:
        """Read ``"k,m"`` or ``"k,m,direction"``, or the two or three as a sequence.

        Raises
        ------
        InputError
            If it is not that, a number is below 1, or k is infinite.
        """
        if isinstance(given, HiddenContext):
            return given
        parts = [part.strip() for part in given.split(",")] if isinstance(given, str) else given
        if not isinstance(parts, (list, tuple)) or len(parts) not in (2, 3):
            raise InputError(
                f"hidden_context is {shown(str(given))}; K,M or K,M,higher or K,M,lower is accepted, such as 2,3: at most twice as common "
                "in one group as in another, changing what one of them gets at most 3 times"
            )
        k = at_least("k of hidden_context", parts[0], 1)
        m = inf if parts[1] in ("inf", inf) else at_least("m of hidden_context", parts[1], 1)
        direction: Any = parts[2] if len(parts) == 3 else "both"
        if direction not in get_args(Direction):
            raise InputError(f"the direction of hidden_context is {shown(str(direction))}; {nearest(str(direction), get_args(Direction))}")
        return cls(k, m, direction)

    @property
    def remaining(self) -> Fraction:
        """The part of a ratio that the factor leaves at the least: 1 if it cannot explain anything, 0 if it can explain everything."""
        k, m = self.k, self.m
        if not isinstance(m, Fraction):
            return 1 / k if self.direction != "lower" else Fraction(k == 1)
        if self.direction == "both":
            return (m + k) / (1 + m * k)
        return (m + k - 1) / (m * k) if self.direction == "higher" else k / (m * k - m + 1)


def least_ratio(ratio: Any, hidden: Any) -> Extended:
    """The least that the greatest ratio can be among people who are alike in an unrecorded factor, too (T14); at least 1, and sharp.

    Source: T14, (m + k)/(1 + mk); one-sided (m + k − 1)/(mk) and k/(mk − m + 1).

    Parameters
    ----------
    ratio : number or str
        The ratio that was seen, at least 1, or `math.inf`.
    hidden : HiddenContext, str or sequence
        What is declared of the factor: k, m and direction.

    Returns
    -------
    Fraction or float
        The bound on the greatest ratio of two groups that are both seen with a value of the factor.

    Raises
    ------
    InputError
        If the ratio or a number of the factor is below 1, or k is infinite.

    Examples
    --------
    >>> least_ratio("3/2", "2,2"), least_ratio("3/2", "2,2,higher"), least_ratio("inf", "2,2")
    (Fraction(6, 5), Fraction(9, 8), inf)
    """
    seen = inf if ratio == "inf" else read_ratio("the ratio", ratio)
    part = HiddenContext.of(hidden).remaining
    if not isinstance(seen, Fraction):
        return inf if part else Fraction(1)
    return max(Fraction(1), seen * part)


def least_change(ratio: Fraction, k: Fraction) -> Extended:
    """How many times a factor that is k times as common has to change what both of two groups get, to explain a ratio above 1 away.

    Source: T14, m ≥ (Rk − 1)/(k − R).

    Parameters
    ----------
    ratio : Fraction
        The ratio, over the one that is to be left.
    k : Fraction
        How many times as common the factor is in one of the groups.

    Returns
    -------
    Fraction or float
        The least m; `math.inf` where no finite one is enough, because k is at most the ratio.

    Examples
    --------
    >>> least_change(Fraction(3, 2), Fraction(2)), least_change(Fraction(3, 2), Fraction(3, 2))
    (Fraction(4, 1), inf)
    """
    return (ratio * k - 1) / (k - ratio) if k > ratio else inf


def balanced_strength(ratio: Extended) -> Extended:
    """R + √(R² − 1), rounded down: a factor with k and m both below it cannot explain a ratio R away.

    Source: T14.

    Examples
    --------
    >>> balanced_strength(Fraction(5, 4)), balanced_strength(Fraction(3, 2))
    (Fraction(2, 1), Fraction(2618033, 1000000))
    """
    if not isinstance(ratio, Fraction):
        return inf
    p, q, unit = ratio.numerator, ratio.denominator, 10**DIGITS
    return Fraction((p * unit + isqrt((p * p - q * q) * unit * unit)) // q, unit)


@brief
@dataclass(frozen=True, repr=False)
class Frontier:
    """What it would take of an unrecorded factor to bring a ratio down.

    Attributes
    ----------
    ratio : Fraction or float
        The ratio that was seen.
    to : Fraction
        The ratio that would be left: 1, or a target.
    balanced : Fraction or float
        A factor with k and m both below this is too weak; rounded down. `math.inf` if no factor explains it.
    pairs : tuple of (Fraction, Fraction)
        For some k the least m, exactly.

    Examples
    --------
    >>> frontier(Fraction(3, 2)).pairs[0]
    (Fraction(2, 1), Fraction(4, 1))
    """

    ratio: Extended
    to: Fraction
    balanced: Extended
    pairs: tuple[tuple[Fraction, Fraction], ...]

    @property
    def excess(self) -> Extended:
        """The ratio over the one that would be left: neither k nor m may be less."""
        return self.ratio / self.to if isinstance(self.ratio, Fraction) else inf


def frontier(ratio: Extended, to: Fraction = Fraction(1)) -> Frontier:
    """What it would take of an unrecorded factor to bring a ratio down to another: the balanced strength, and m for some k.

    Source: T14. The k are the four least numbers above R of 5/4, 3/2, and 1, 2, 3 and 5 times the powers of 10.

    Parameters
    ----------
    ratio : Fraction or float
        The ratio that was seen, above `to`.
    to : Fraction
        What is to be left of it, at least 1.

    Returns
    -------
    Frontier
        The strength of such factors.

    Examples
    --------
    >>> found = frontier(Fraction(3, 2))
    >>> [(str(k), str(m)) for k, m in found.pairs], str(found.balanced)
    ([('2', '4'), ('3', '7/3'), ('5', '13/7'), ('10', '28/17')], '2618033/1000000')
    """
    if not isinstance(ratio, Fraction):
        return Frontier(ratio, to, inf, ())
    excess = ratio / to
    steps = () if excess > MOST else islice((k for k in _steps() if k > excess), ROWS)
    return Frontier(ratio, to, balanced_strength(excess), tuple((k, (excess * k - 1) / (k - excess)) for k in steps))


def _steps() -> Iterator[Fraction]:
    """Numbers that say how many times as common something is."""
    yield from (Fraction(5, 4), Fraction(3, 2))
    power = 1
    while True:
        yield from (Fraction(power * digit) for digit in (1, 2, 3, 5))
        power *= 10


def attaining(hidden: HiddenContext) -> tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction], tuple[Fraction, Fraction]]:
    """A factor of two values with which nothing more than the bound is left: its law in both groups, and what the group with m gets.

    Returns
    -------
    tuple
        The law in the group with the higher expectation; that in the other; and the expectations, up to a factor, of the group that m is
        about: the one with the higher expectation where the direction is "lower", else the other. m has to be finite, or its expectations
        are 1 and 0.

    Examples
    --------
    >>> [[str(one) for one in two] for two in attaining(HiddenContext.of("2,3"))]
    [['2/3', '1/3'], ['1/3', '2/3'], ['3', '1']]
    """
    k, one, zero = hidden.k, Fraction(1), Fraction(0)
    values = (hidden.m, one) if isinstance(hidden.m, Fraction) else (one, zero)
    if hidden.direction == "higher":
        return (one, zero), (1 / k, 1 - 1 / k), values
    if hidden.direction == "lower" and k > 1:
        return (1 - 1 / k, 1 / k), (zero, one), values
    return (k / (k + 1), 1 / (k + 1)), (1 / (k + 1), k / (k + 1)), values
