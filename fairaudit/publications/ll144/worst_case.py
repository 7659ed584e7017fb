"""The least impact ratio that people of unknown category leave possible, whoever they are: exact, without trying all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations

__all__ = ["WorstCase", "worst_case"]


@dataclass(frozen=True)
class WorstCase:
    """The least impact ratio, and between whom.

    Attributes
    ----------
    ratio : Fraction
        The least rate over the greatest.
    pair : tuple of int or None
        The places of the category with the least and of that with the greatest rate; None where no two differ, whoever the unknown are.
    """

    ratio: Fraction
    pair: tuple[int, int] | None


def worst_case(categories: Sequence[tuple[int, int]], selected: int = 0, unselected: int = 0, undecided: int = 0) -> WorstCase | None:
    """Find the least ratio of two rates over all ways in which people of unknown category may belong to categories.

    Of two categories the ratio is least when all who were not selected belong to the lower one and all who were to the higher one:
    each moves one rate only, and that way.

    Parameters
    ----------
    categories : sequence of (int, int)
        Of each category the people selected, and all of them.
    selected, unselected : int
        People of unknown category who were selected, and who were not.
    undecided : int
        People of unknown category of whom not even that is known.

    Returns
    -------
    WorstCase or None
        None where nobody is in any category, and nobody could be. A category that stays empty has no rate.

    Examples
    --------
    >>> worst_case([(50, 100), (30, 60)], selected=2, unselected=10)
    WorstCase(ratio=Fraction(153, 182), pair=(1, 0))
    >>> worst_case([(50, 100), (30, 60)], undecided=12).ratio < worst_case([(50, 100), (30, 60)], 2, 10).ratio
    True
    """
    found: WorstCase | None = None
    for low, high in permutations(range(len(categories)), 2):
        (s, n), (t, m) = categories[low], categories[high]
        ratio = _least(s, n + unselected, t + selected, m + selected, undecided)
        if ratio is not None and (found is None or ratio < found.ratio):
            found = WorstCase(ratio, (low, high))
    if found is not None and found.ratio < 1:
        return found
    anybody = selected + unselected + undecided > 0 if categories else False
    return WorstCase(Fraction(1), None) if anybody or any(n for _, n in categories) else None


def _least(s: int, n: int, t: int, m: int, undecided: int) -> Fraction | None:
    """The least of s/(n+a) over (t+x)/(m+x), where a of the undecided are not selected and join the first, and the others, x, the second.

    The negative logarithm is concave in a, so the first step that does not lower the ratio is found by bisection. None where there is no
    such ratio: where the first has nobody, or nobody of the second was selected.
    """
    low, high = int(n == 0), undecided - int(t == 0)
    if low > high:
        return None
    if s == 0:
        return Fraction(0)
    while low < high:
        a = (low + high) // 2
        x = undecided - a
        if (m + x - 1) * (n + a) * (t + x) >= (m + x) * (n + a + 1) * (t + x - 1):
            high = a
        else:
            low = a + 1
    x = undecided - low
    return Fraction(s * (m + x), (n + low) * (t + x))
