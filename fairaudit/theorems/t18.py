"""T18: how unequal a subgroup is beside the rest, and when no part of it can be as unequal as some limit."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import accumulate
from math import inf
from typing import Literal

from fairaudit.exact.extended import Extended

Side = Literal["more", "less", "equal"]
"""Whether a subgroup gets more than the rest, or less."""

INDEPENDENT_ROWS = (
    "the rows of the log are independent draws from one population, and how many there are does not depend on how they came out"
)

CHOSEN_BEFOREHAND = (
    "attributes, their values, depth, the least number of rows, utility and confidence were chosen without looking at the decisions"
)


def subgroup_ratio(rows: int, total: int, all_rows: int, all_total: int) -> tuple[Extended, Side]:
    """The mean of some of all rows beside the mean of the rest: the greater of the two ratios, and who gets more.

    Source: T18.

    Parameters
    ----------
    rows, total : int
        How many rows the subgroup has, and the sum of their utilities, which are at least 0.
    all_rows, all_total : int
        The same of all rows, of which there are more.

    Examples
    --------
    >>> subgroup_ratio(10, 2, 40, 18)
    (Fraction(8, 3), 'less')
    >>> subgroup_ratio(2, 2, 20, 2), subgroup_ratio(1, 0, 2, 0)
    ((inf, 'more'), (Fraction(1, 1), 'equal'))
    """
    own, rest = total * (all_rows - rows), (all_total - total) * rows
    if own == rest:
        return Fraction(1), "equal"
    return (Fraction(max(own, rest), low) if (low := min(own, rest)) else inf), "more" if own > rest else "less"


def refinements_below(
    counts: Sequence[int], values: Sequence[int], all_rows: int, all_total: int, least_rows: int, limit: Extended
) -> bool:
    """Whether every part of a subgroup that has enough rows, and not all rows there are, is less unequal than a limit.

    Some j of its n rows have a sum between Bottom(j) and Top(j), those of its j least and j greatest utilities. Between the ends of a
    class of equal utilities what is compared is concave in j, so that the least j, the ends beyond it, and the greatest j decide.

    Source: T18.

    Parameters
    ----------
    counts : sequence of int
        How many rows of the subgroup have each value.
    values : sequence of int
        The values, rising from at least 0.
    all_rows, all_total : int
        How many rows there are, and the sum of their utilities.
    least_rows : int
        How many rows a part has at least.
    limit : Fraction or inf
        At least 1.

    Examples
    --------
    Four positive rows, all in a subgroup of 10 of 20 rows: two of them give 9, all four of them infinity.

    >>> refinements_below([6, 4], [0, 1], 20, 4, 2, Fraction(10)), refinements_below([6, 4], [0, 1], 20, 4, 5, Fraction(100))
    (False, False)
    >>> refinements_below([6, 4], [0, 1], 20, 10, 8, Fraction(3))
    True
    """
    most = min(sum(counts), all_rows - 1)
    if most < least_rows:
        return True
    upwards, downwards = list(zip(counts, values, strict=True)), list(zip(counts, values, strict=True))[::-1]
    return all(
        _below(j, part, all_rows, all_total, limit) for classes in (upwards, downwards) for j, part in _extremes(classes, least_rows, most)
    )


def _extremes(classes: Sequence[tuple[int, int]], least: int, most: int) -> list[tuple[int, int]]:
    """The sums of the first j rows, class by class: for the least and the greatest j, and the ends of classes between them."""
    ends = [0, *accumulate(count for count, _ in classes)]
    sums = [0, *accumulate(count * value for count, value in classes)]
    found = []
    for j in sorted({least, most, *(end for end in ends if least < end < most)}):
        at = next(i for i in range(len(classes)) if ends[i + 1] >= j)
        found.append((j, sums[at] + (j - ends[at]) * classes[at][1]))
    return found


def _below(rows: int, total: int, all_rows: int, all_total: int, limit: Extended) -> bool:
    found, _ = subgroup_ratio(rows, total, all_rows, all_total)
    return found < limit
