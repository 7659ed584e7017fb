"""Two logs in which the same units were asked the same: how what a unit gets in one differs from what it gets in the other.

Let E and E' be the mean utilities of a cell in the first and in the second log, and let U bound E'/E from above for each cell, W bound
E/E', both at the level ε. If the ratio R' of the second log is attained by the groups a and a' of a context, then

    R' = E'(a)/E'(a') <= U(a)·W(a')·E(a)/E(a') <= U(a)·W(a')·R

but with the probability 2ε, because the pair that attains R' does not depend on the draws; and the same with the logs exchanged. So the
greatest U(a)·W(a') of two groups of a context bounds R'/R and R/R', each but with the probability 2ε, and no error is shared out among
pairs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from math import inf

from fairaudit.exact.extended import Extended
from fairaudit.inference.cells import Profiles
from fairaudit.inference.levels import equal_share
from fairaudit.inference.paired_betting import Contrasts, contrasts, upper_end
from fairaudit.tables.values import Label
from fairaudit.words import brief

__all__ = ["Cells", "PairedRate", "greatest_change", "paired_rates", "units_alike"]

Cells = Mapping[tuple[Label, Label], Profiles]
"""For each context and group how many units got these values in the two logs, None where a unit is not there."""

OLD, NEW = 0, 1

DIRECTIONS = ((NEW, OLD), (OLD, NEW))


@brief
@dataclass(frozen=True, repr=False)
class PairedRate:
    """The mean utility of a cell in two logs, with what is known of its change.

    Attributes
    ----------
    context, group : tuple of str
        The cell.
    units : int
        How many units are in both logs.
    old, new : Fraction
        The means over these units.
    ratio : tuple of Fraction or float
        Between which ends new/old lies.
    difference : tuple of Fraction
        Between which ends new − old lies.
    """

    context: Label
    group: Label
    units: int
    old: Fraction
    new: Fraction
    ratio: tuple[Extended, Extended]
    difference: tuple[Fraction, Fraction]


def units_alike(cells: Cells) -> bool:
    """Whether each unit of a cell is in both logs."""
    return all(None not in values for profiles in cells.values() for values in profiles)


def paired_rates(cells: Cells, most: Fraction, alpha: Fraction) -> tuple[PairedRate, ...]:
    """Bound how the mean of each cell changed: all ends of ratios hold together but with the probability α, and so do those of differences.

    Parameters
    ----------
    cells : mapping
        What units got; those that are not in both logs are left out.
    most : Fraction
        The greatest utility; the least is 0.
    alpha : Fraction
        The error.
    """
    level = equal_share(alpha, 2 * len(cells))
    return tuple(_rate(place, profiles, most, level) for place, profiles in cells.items())


def _rate(place: tuple[Label, Label], profiles: Profiles, most: Fraction, level: Fraction) -> PairedRate:
    up, down = (_contrasts(profiles, pair, most) for pair in DIRECTIONS)
    both = {values: n for values, n in profiles.items() if None not in values}
    units = sum(both.values())
    old, new = (sum((n * (values[at] or Fraction(0)) for values, n in both.items()), Fraction(0)) / max(1, units) for at in (OLD, NEW))
    higher, lower = upper_end(up, level), upper_end(down, level)
    least = Fraction(0) if lower == inf else 1 / Fraction(lower)
    ends = tuple(most * Fraction(upper_end(own, level, "difference")) for own in (down, up))
    return PairedRate(*place, units, old, new, (least, higher), (-ends[0], ends[1]))


def greatest_change(cells: Cells, most: Fraction, alpha: Fraction) -> Extended:
    """What R'/R is at most, and R/R' too, each but with the probability α.

    Examples
    --------
    >>> one, none = Fraction(1), Fraction(0)
    >>> alike = {(one, one): 200, (none, none): 100}
    >>> round(float(greatest_change({(("x",), ("f",)): alike, (("x",), ("m",)): alike}, one, Fraction(1, 20))), 3)
    1.057
    """
    level = equal_share(alpha, 2)
    grown, shrunk = (
        {place: upper_end(_contrasts(profiles, pair, most), level) for place, profiles in cells.items()}
        for pair in ((NEW, OLD), (OLD, NEW))
    )
    greatest: Extended = Fraction(1)
    for (context, one), (other_context, other) in permutations(cells, 2):
        if context == other_context:
            factors = grown[context, one], shrunk[context, other]
            greatest = max(greatest, inf if inf in factors else Fraction(factors[0]) * Fraction(factors[1]))
    return greatest


def _contrasts(profiles: Profiles, pair: tuple[int, int], most: Fraction) -> Contrasts:
    higher, lower = pair
    return contrasts(profiles, higher, lower, (Fraction(0), most), drop=True)
