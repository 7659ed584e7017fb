"""T19: between which ends the greatest ratio of a table lies, whatever decisions of unknown meaning meant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import quotient
from fairaudit.words import brief

__all__ = ["RatioRange", "ratio_range"]

Ends = tuple[Fraction, Fraction]
"""The least and the greatest mean that one of those that are compared can have."""

Pair = tuple[int, int, int]
"""A block, and the positions of the higher and the lower mean in it."""


@brief
@dataclass(frozen=True, repr=False)
class RatioRange:
    """Both ends of the greatest ratio of two means of a block.

    Attributes
    ----------
    least, greatest : Fraction or float
        The ends, which are attained where every mean can be anywhere between its own ends, whatever the others are.
    least_at, greatest_at : tuple of int or None
        The block, and the positions of the higher and the lower mean that attain each; None where it is 1.
    """

    least: Extended
    greatest: Extended
    least_at: Pair | None
    greatest_at: Pair | None


def ratio_range(blocks: Sequence[Sequence[Ends]]) -> RatioRange:
    """Find between which ends the greatest ratio of two means of a block lies, if each mean is somewhere between its own ends.

    Source: T19, Coq `T19_greatest`, `T19_greatest_attained`, `T19_least` and `T19_level`. The greatest is that of one mean at its upper end
    and another one at its lower end; the least is the greatest lower end over the least upper end of a block, and 1 where these leave room
    for one value that all means of each block can have.

    Parameters
    ----------
    blocks : sequence of sequence of (Fraction, Fraction)
        For each block, such as a context, the ends of its means, at least 0; blocks of one mean compare nothing.

    Returns
    -------
    RatioRange
        Both ends, and where they are attained.

    Examples
    --------
    >>> quarter = Fraction(1, 4)
    >>> found = ratio_range([[(quarter, 2 * quarter), (3 * quarter, 4 * quarter)]])
    >>> found.least, found.greatest, found.greatest_at
    (Fraction(3, 2), Fraction(4, 1), (0, 1, 0))
    """
    least: tuple[Extended, Pair | None] = (Fraction(1), None)
    greatest: tuple[Extended, Pair | None] = (Fraction(1), None)
    for block, ends in enumerate(blocks):
        if len(ends) < 2:
            continue
        rising = sorted(range(len(ends)), key=lambda i: ends[i][0])[:2]
        falling = sorted(range(len(ends)), key=lambda i: -ends[i][1])[:2]
        for higher in falling:
            for lower in rising:
                if higher != lower and (ratio := quotient(ends[higher][1], ends[lower][0])) > greatest[0]:
                    greatest = ratio, (block, higher, lower)
        higher, lower = max(range(len(ends)), key=lambda i: ends[i][0]), min(range(len(ends)), key=lambda i: ends[i][1])
        if ends[higher][0] > ends[lower][1] and (ratio := quotient(ends[higher][0], ends[lower][1])) > least[0]:
            least = ratio, (block, higher, lower)
    return RatioRange(least[0], greatest[0], least[1], greatest[1])
