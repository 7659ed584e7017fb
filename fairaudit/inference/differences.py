"""An interval for the greatest difference of two means: of rates of positive decisions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heapify, heapreplace, nlargest, nsmallest
from typing import Any

from fairaudit.exact.extended import extended_text
from fairaudit.inference.cells import Cell, Ends
from fairaudit.inference.ends import cell_ends, wide_ends
from fairaudit.inference.levels import box_levels, confidence_level
from fairaudit.inference.quotients import FOREMOST, are_many
from fairaudit.words import brief


@brief
@dataclass(frozen=True)
class DifferenceInterval:
    """A confidence interval of the greatest difference of two rates.

    Attributes
    ----------
    lower, upper : Fraction
        Between 0 and 1.
    confidence : Fraction
        The probability, before the draws, that both ends are right.
    assumptions : tuple of str
        What the reader must accept.
    evidence : dict
        What a checker needs, as docs/certificate-samples.md describes it.
    """

    lower: Fraction
    upper: Fraction
    confidence: Fraction
    assumptions: tuple[str, ...]
    evidence: dict[str, Any]


def difference_interval(
    blocks: Sequence[Sequence[tuple[int, int]]], confidence: Any, assumptions: tuple[str, ...] = ()
) -> DifferenceInterval:
    """Bound the greatest difference between two rates of one block, from the binomial ends of each.

    Parameters
    ----------
    blocks : sequence of sequence of (int, int)
        Rates that are compared with each other, at least two in a block: how many draws were positive, and how many there were.
    confidence : number
        Between 0 and 1.
    assumptions : tuple of str
        What the reader must accept of the draws.

    Returns
    -------
    DifferenceInterval
        The interval.

    Examples
    --------
    >>> found = difference_interval([[(90, 100), (50, 100)]], "0.95")
    >>> round(float(found.lower), 3), round(float(found.upper), 3)
    (0.197, 0.571)
    """
    level = confidence_level(confidence)
    cells = [Cell(n, Fraction(k), None, Fraction(0), Fraction(1), binary=True) for block in blocks for k, n in block]
    numbers = iter(range(len(cells)))
    places = [[next(numbers) for _ in block] for block in blocks]
    upper_level, lower_level = box_levels(len(cells), 2, 1 - level, independent=False)
    outer, upper = _outer_difference(cells, places, upper_level)
    inner, lower = _inner_difference(cells, places, lower_level)
    evidence = {
        "confidence": extended_text(level),
        "levels": {"upper": extended_text(upper_level), "lower": extended_text(lower_level)},
        "upper": [[extended_text(a), extended_text(b)] for a, b in outer],
        "lower": [[extended_text(a), extended_text(b)] for a, b in inner],
        "difference": [extended_text(lower), extended_text(upper)],
    }
    return DifferenceInterval(lower, upper, level, assumptions, evidence)


def _widest(members: Sequence[int], tops: Sequence[Fraction], bottoms: Sequence[Fraction]) -> tuple[Fraction, int, int]:
    """Greatest difference of the top of a rate and the bottom of another one, and where it is."""
    first, low = nlargest(2, members, key=tops.__getitem__), nsmallest(2, members, key=bottoms.__getitem__)
    return max((tops[i] - bottoms[j], i, j) for i in first for j in low if i != j)


def _outer_difference(cells: Sequence[Cell], places: Sequence[Sequence[int]], level: Fraction) -> tuple[list[Ends], Fraction]:
    """Ends of all rates, as narrow as can be where they decide, and the greatest difference that they allow."""
    many = are_many(cells)
    ends = wide_ends(cells, level) if many else [cell_ends(cell, level) for cell in cells]
    narrow = [not many] * len(cells)
    low, high = ([end[k] for end in ends] for k in (0, 1))
    heap = [(-found, number, i, j) for number, members in enumerate(places) for found, i, j in [_widest(members, high, low)]]
    heapify(heap)
    while True:
        negative, number, i, j = heap[0]
        wide = [cell for cell in (i, j) if not narrow[cell]]
        if not wide:
            return ends, min(Fraction(1), -negative)
        for cell in wide:
            own = cell_ends(cells[cell], level)
            low[cell], high[cell] = max(own[0], low[cell]), min(own[1], high[cell])
            ends[cell], narrow[cell] = (low[cell], high[cell]), True
        found, i, j = _widest(places[number], high, low)
        heapreplace(heap, (-found, number, i, j))


def _inner_difference(cells: Sequence[Cell], places: Sequence[Sequence[int]], level: Fraction) -> tuple[list[Ends], Fraction]:
    """Ends of all rates, of which one pair proves that there is such a difference; where they do not decide, the whole range."""
    if not are_many(cells):
        ends = [cell_ends(cell, level) for cell in cells]
        chosen = places
    else:
        wide = wide_ends(cells, level)
        low, high = ([end[k] for end in wide] for k in (0, 1))
        promising = nlargest(FOREMOST, (_widest(members, low, high) for members in places))
        ends = [(Fraction(0), Fraction(1))] * len(cells)
        for i in {cell for _, *pair in promising for cell in pair}:
            ends[i] = cell_ends(cells[i], level)
        chosen = [pair for _, *pair in promising]
    low, high = ([end[k] for end in ends] for k in (0, 1))
    return ends, max(Fraction(0), *(_widest(members, low, high)[0] for members in chosen))
