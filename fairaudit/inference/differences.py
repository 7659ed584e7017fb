"""Intervals for the greatest difference of two means: of expected utilities of any sign, and of rates of positive decisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heapify, heapreplace, nlargest, nsmallest
from itertools import permutations
from typing import Any, get_args

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import extended_text
from fairaudit.exact.rationals import exact
from fairaudit.inference.cells import Cell, Ends, cell_entries
from fairaudit.inference.comparisons import Comparison, Estimand, Form, Place, unit_form, witness_of
from fairaudit.inference.difference_contrasts import (
    difference_contrasts_driver,
    difference_contrasts_interval,
    fits_difference_contrasts,
)
from fairaudit.inference.ends import Method, cell_ends, ends_of_cells, wide_ends
from fairaudit.inference.interval import Region
from fairaudit.inference.levels import Holding, box_levels, confidence_level
from fairaudit.inference.pair_region import fits_pairs, pairs_driver, pairs_interval
from fairaudit.inference.quotients import FOREMOST, are_many
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.ratios import Witness
from fairaudit.theorems.assumptions import CELLS
from fairaudit.words import brief


@brief
@dataclass(frozen=True, repr=False)
class DifferenceInterval:
    """A confidence interval of the greatest difference of two means.

    Attributes
    ----------
    lower, upper : Fraction
        At least 0, and at most the width of the range of a draw.
    confidence : Fraction
        The probability, before the draws, that the ends are right, as `ends` says.
    assumptions : tuple of str
        What the reader must accept.
    evidence : dict
        What a checker needs, as docs/certificate-samples.md describes it.
    ends : {"together", "each"}
        Whether the confidence is that of both ends together, or of each by itself.
    region : {"box", "pairs", "contrasts"}
        How the ends of the cells are joined.
    methods : tuple of str
        How the ends of the cells were found.
    estimand : {"mean over rows", "mean over units"}
        What the means are.
    of_units : MeanDifference or None
        With sampling units of several rows in a cell, the difference of the sample itself as the mean over units.
    """

    lower: Fraction
    upper: Fraction
    confidence: Fraction
    assumptions: tuple[str, ...]
    evidence: dict[str, Any]
    ends: Holding = "together"
    region: Region = "box"
    methods: tuple[str, ...] = ("binomial",)
    estimand: Estimand = "mean over rows"
    of_units: MeanDifference | None = None


def difference_interval(
    comparison: Comparison,
    confidence: Any = "0.95",
    *,
    method: Method = "hoeffding-kl",
    region: Region = "box",
    independent: bool = False,
    ends: Holding = "together",
) -> DifferenceInterval:
    """Bound the greatest difference of two compared forms at a confidence, for finite samples.

    Parameters
    ----------
    comparison : Comparison
        What is compared; ranges of draws may be of any sign.
    confidence : number or str
        The probability with which the ends are to hold.
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For cells whose draws are not binary; to be chosen before looking.
    region : {"box", "pairs", "contrasts"}
        "pairs" is for independent cells of draws of two values, the same two everywhere, "contrasts" for those of more values in one range.
    independent : bool
        Whether the draws of different cells are independent, which the reader must then accept.
    ends : {"together", "each"}
        What the confidence is of: both ends at once, or each end by itself, as a verdict on a limit needs it.

    Returns
    -------
    DifferenceInterval
        Both ends with evidence.

    Raises
    ------
    InputError
        If the confidence is not in (0, 1), the method is not known, nothing is compared, or the region does not fit.

    Examples
    --------
    >>> from fairaudit.inference.table_comparisons import local_comparison
    >>> from fairaudit.model.law import Law
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[90, 10], [50, 50]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> compared = local_comparison(law, Utility({"yes": 1, "no": -1}, signed=True).on(law))
    >>> found = difference_interval(compared)
    >>> round(float(found.lower), 3), round(float(found.upper), 3)
    (0.394, 1.143)
    >>> found = difference_interval(compared, region="pairs", independent=True, ends="each")
    >>> round(float(found.lower), 3), round(float(found.upper), 3)
    (0.558, 1.006)
    """
    level = confidence_level(confidence)
    if method not in get_args(Method):
        raise InputError(f"the method {shown(method)} is not known; {nearest(str(method), get_args(Method))}")
    if not any(len(block) > 1 for block in comparison.blocks):
        raise InputError("nothing is compared: no context has two groups")
    if independent and comparison.dependent:
        raise InputError("cells share draws or sampling units, so they are not independent")
    alpha = 1 - level
    pairs = region == "pairs"
    if pairs and not (independent and fits_pairs(comparison, alpha, contrast="difference")):
        raise InputError(
            "the exact pair bound needs independent cells of draws of two values, not too many pairs, and a confidence between 10 and "
            "100 %; use the box"
        )
    if region == "contrasts" and not (independent and fits_difference_contrasts(comparison)):
        raise InputError("contrasts need independent cells with draws in one range, some of them of more than two values; use the box")
    if region == "contrasts":
        lower, upper, evidence = difference_contrasts_interval(comparison, alpha, ends)
    elif pairs:
        low, high, evidence = pairs_interval(comparison, alpha, ends, contrast="difference")
        lower, upper = low, Fraction(high)
    else:
        lower, upper, evidence = _box_interval(comparison, alpha, method, independent, ends)
    evidence = {
        "confidence": extended_text(level),
        "ends": ends,
        "region": region,
        "independent": independent,
        "method": method,
        "cells": cell_entries(comparison.cells),
        "blocks": [[[[i, extended_text(w)] for i, w in form] for form in block] for block in comparison.blocks],
        **evidence,
    }
    named = {"pairs": "pair-exact", "contrasts": "symmetric-betting"}
    kinds = {named[region]} if region in named else {"binomial" if comparison.cells[i].binary else method for i in comparison.used}
    assumptions = (*comparison.assumptions, *((CELLS,) if independent else ()))
    estimand = comparison.estimand
    of_units = None if estimand == "mean over rows" else _of_units(comparison)
    return DifferenceInterval(lower, upper, level, assumptions, evidence, ends, region, tuple(sorted(kinds)), estimand, of_units)


def default_difference_region(comparison: Comparison, method: Method | None = None, *, independent: bool, alpha: Fraction) -> Region:
    """Choose a region by what is known before the draws.

    Of independent cells with draws of two values every pair by itself, by the exact pair bound; with draws of more values, unless a method
    was asked for, by bets on their contrast. Else the box.
    """
    if independent and fits_pairs(comparison, alpha, contrast="difference"):
        return "pairs"
    return "contrasts" if independent and method is None and fits_difference_contrasts(comparison) else "box"


def difference_drivers(comparison: Comparison, evidence: Mapping[str, Any], upper: Fraction) -> tuple[Witness | None, Witness | None]:
    """Name the pairs that drive the lower and the upper end of an interval, with the means of their draws; None for a lower end of 0."""
    alpha = 1 - exact(evidence["confidence"])
    if evidence["region"] == "pairs":
        low: Place | None = None if evidence["lower"] is None else evidence["lower"]["pair"]
        high = pairs_driver(comparison, alpha, evidence["ends"], upper, "difference")
    elif evidence["region"] == "contrasts":
        low = evidence["pair"]
        high = difference_contrasts_driver(comparison, alpha, evidence["ends"], upper)
    else:
        inner, outer = ([(exact(a), exact(b)) for a, b in evidence[name]] for name in ("lower", "upper"))
        least, low = _extreme(comparison, inner, upper=False)
        low = low if least > 0 else None
        _, high = _extreme(comparison, outer, upper=True)
    return witness_of(comparison, low), witness_of(comparison, high)


def difference_of_rates(
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
    >>> found = difference_of_rates([[(90, 100), (50, 100)]], "0.95")
    >>> round(float(found.lower), 3), round(float(found.upper), 3)
    (0.197, 0.571)
    """
    level = confidence_level(confidence)
    cells = [Cell(n, Fraction(k), None, Fraction(0), Fraction(1), binary=True) for block in blocks for k, n in block]
    numbers = iter(range(len(cells)))
    comparison = Comparison(tuple(cells), tuple(tuple(unit_form(next(numbers)) for _ in block) for block in blocks))
    lower, upper, evidence = _box_interval(comparison, 1 - level, "hoeffding-kl", False, "together")
    stated = {"confidence": extended_text(level), **evidence, "difference": [extended_text(lower), extended_text(upper)]}
    return DifferenceInterval(lower, upper, level, assumptions, stated)


def _of_units(comparison: Comparison) -> MeanDifference | None:
    """The greatest difference of the means over units in the sample."""
    means = [(mean, mean) for mean in (cell.mean if cell.draws else cell.low for cell in comparison.cells)]
    value, where = _extreme(comparison, means, upper=True)
    if not value:
        where = next(((b, 0, 1) for b, block in enumerate(comparison.blocks) if len(block) > 1), None)
    witness = witness_of(comparison, where)
    return None if witness is None else MeanDifference(value, witness)


def _box_interval(
    comparison: Comparison, alpha: Fraction, method: Method, independent: bool, ends: Holding
) -> tuple[Fraction, Fraction, dict[str, Any]]:
    """Both ends over the box of the ends of cells, with their evidence."""
    upper_level, lower_level = box_levels(len(comparison.used), comparison.span, alpha, independent=independent, ends=ends)
    closed = all(comparison.cells[i].binary for i in comparison.used) or method == "hoeffding-kl"
    many = are_many(comparison.used) and comparison.single and closed and all(level > 0 for level in (upper_level, lower_level))
    if many:
        outer, inner = _decisive_outer(comparison, upper_level, method), _decisive_inner(comparison, lower_level, method)
    else:
        outer, inner = (ends_of_cells(comparison, level, method) for level in (upper_level, lower_level))
    evidence = {
        "levels": {"upper": extended_text(upper_level), "lower": extended_text(lower_level)},
        "upper": [[extended_text(a), extended_text(b)] for a, b in outer],
        "lower": [[extended_text(a), extended_text(b)] for a, b in inner],
    }
    return _extreme(comparison, inner, upper=False)[0], _extreme(comparison, outer, upper=True)[0], evidence


def _extreme(comparison: Comparison, ends: Sequence[Ends], *, upper: bool) -> tuple[Fraction, Place | None]:
    """The greatest difference that ends allow, or the greatest that they prove, at least 0, and where it is."""
    best, where = Fraction(0), None
    for number, block in enumerate(comparison.blocks):
        if len(block) < 2:
            continue
        if comparison.single:
            tops, bottoms = ([ends[form[0][0]][side] for form in block] for side in ((1, 0) if upper else (0, 1)))
            found = _widest(range(len(block)), tops, bottoms)
        else:
            found = max(((_apart(block[i], block[j], ends, upper=upper), -i, -j) for i, j in permutations(range(len(block)), 2)))
            found = found[0], -found[1], -found[2]
        if where is None or found[0] > best:
            best, where = max(best, found[0]), (number, found[1], found[2])
    return best, where


def _apart(top: Form, bottom: Form, ends: Sequence[Ends], *, upper: bool) -> Fraction:
    """The greatest, or the least, difference of two forms over a box."""
    weights: dict[int, Fraction] = dict(top)
    for i, w in bottom:
        weights[i] = weights.get(i, Fraction(0)) - w
    return sum((w * ends[i][(w > 0) is upper] for i, w in weights.items()), Fraction(0))


def _widest(members: Sequence[int], tops: Sequence[Fraction], bottoms: Sequence[Fraction]) -> tuple[Fraction, int, int]:
    """Greatest difference of the top of a cell and the bottom of another one, and where it is."""
    first, low = nlargest(2, members, key=tops.__getitem__), nsmallest(2, members, key=bottoms.__getitem__)
    return max(((tops[i] - bottoms[j], i, j) for i in first for j in low if i != j), key=lambda found: found[0])


def _members(comparison: Comparison) -> list[list[int]]:
    return [[form[0][0] for form in block] for block in comparison.blocks if len(block) > 1]


def _wide(comparison: Comparison, level: Fraction) -> list[Ends]:
    """Ends in closed form of the cells that are compared and informative; the others have their range."""
    wide = dict(zip(comparison.used, wide_ends([comparison.cells[i] for i in comparison.used], level), strict=True))
    return [wide.get(i, (cell.low, cell.high)) for i, cell in enumerate(comparison.cells)]


def _decisive_outer(comparison: Comparison, level: Fraction, method: Method) -> list[Ends]:
    """Ends of many cells, as narrow as can be where they decide the greatest difference."""
    cells, places, ends = comparison.cells, _members(comparison), _wide(comparison, level)
    used = set(comparison.used)
    narrow = [i not in used for i in range(len(cells))]
    low, high = ([end[k] for end in ends] for k in (0, 1))
    heap = [(-found, number, i, j) for number, members in enumerate(places) for found, i, j in [_widest(members, high, low)]]
    heapify(heap)
    while True:
        _, number, i, j = heap[0]
        wide = [cell for cell in (i, j) if not narrow[cell]]
        if not wide:
            return ends
        for cell in wide:
            own = cell_ends(cells[cell], level, method)
            low[cell], high[cell] = max(own[0], low[cell]), min(own[1], high[cell])
            ends[cell], narrow[cell] = (low[cell], high[cell]), True
        found, i, j = _widest(places[number], high, low)
        heapreplace(heap, (-found, number, i, j))


def _decisive_inner(comparison: Comparison, level: Fraction, method: Method) -> list[Ends]:
    """Ends of many cells, of which one pair proves that there is such a difference; where they do not decide, the whole range."""
    low, high = ([end[k] for end in _wide(comparison, level)] for k in (0, 1))
    promising = nlargest(FOREMOST, (_widest(members, low, high) for members in _members(comparison)))
    ends = [(cell.low, cell.high) for cell in comparison.cells]
    used = set(comparison.used)
    for i in {cell for _, *pair in promising for cell in pair} & used:
        ends[i] = cell_ends(comparison.cells[i], level, method)
    return ends
