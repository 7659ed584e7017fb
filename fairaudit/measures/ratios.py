"""Ratios of expected utilities of two groups, R within contexts and R̄ over all of them, and their suprema, each with its witness.

A float64 pass with a rigorous error bound rules out what cannot be the maximum; what is left is decided in integers. The result is
therefore exact, and ties go to input order.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, cmp_to_key

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.enclosures import UNIT, log_enclosure
from fairaudit.exact.rationals import quotient
from fairaudit.measures.expectations import Grid, Pair, expectation_grid, mean_grid, mixed_grid, probability_grid
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.words import brief

__all__ = [
    "Ratio",
    "Witness",
    "global_fairness",
    "global_supremum",
    "local_fairness",
    "local_supremum",
    "most_unequal_contexts",
    "most_unequal_ratios",
]


@brief
@dataclass(frozen=True, repr=False)
class Witness:
    """Where a ratio is attained.

    Attributes
    ----------
    context : dict of str to str or None
        The context; None for a global measure.
    higher, lower : dict of str to str
        The groups in numerator and denominator.
    expectations : tuple of Fraction
        The two values compared: expected utilities, or probabilities of `decision`.
    decision : str or None
        The decision, for a supremum over utilities (T6).

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> result.local.witness
    Witness(context={}, higher={'sex': 'f'}, lower={'sex': 'm'}, expectations=(Fraction(3, 4), Fraction(1, 2)), decision=None)
    """

    context: dict[str, str] | None
    higher: dict[str, str]
    lower: dict[str, str]
    expectations: tuple[Fraction, Fraction]
    decision: str | None = None


@brief
@dataclass(frozen=True, repr=False)
class Ratio:
    """A worst ratio between two groups.

    Attributes
    ----------
    ratio : Fraction or float
        The exact ratio R ≥ 1, or `math.inf`.
    witness : Witness
        Where it is attained; ties go to input order.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> result.local.ratio, result.local.witness.higher
    (Fraction(3, 2), {'sex': 'f'})
    """

    ratio: Fraction | float
    witness: Witness

    @cached_property
    def pair(self) -> Pair:
        """R as numerator and denominator; ``(1, 0)`` for infinity."""
        return (self.ratio.numerator, self.ratio.denominator) if isinstance(self.ratio, Fraction) else (1, 0)

    @cached_property
    def log(self) -> tuple[Decimal, Decimal]:
        """Enclosure of log R in nats."""
        lo, hi = log_enclosure(self.pair)
        return Decimal(lo), Decimal(hi)


def local_fairness(law: Law, utility: UtilityTable) -> Ratio | None:
    """Local g-fairness: the worst ratio of expected utilities between two groups within a context.

    Parameters
    ----------
    law : Law
        The law P(u|x,a).
    utility : UtilityTable
        The utility on that law.

    Returns
    -------
    Ratio or None
        R with L = log R, and its witness; None if no context has two groups. Source: paper, definition of local g-fairness.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> local_fairness(law, Utility({"yes": 1}).on(law)).ratio
    Fraction(3, 2)
    """
    found = most_unequal_ratios(law, utility, 1, within_context=True)
    return found[0] if found else None


def global_fairness(law: Law, utility: UtilityTable) -> Ratio | None:
    """Global g-fairness: the worst ratio of group means, after averaging over the contexts of each group.

    Parameters
    ----------
    law : Law
        The law with its population.
    utility : UtilityTable
        The utility on that law.

    Returns
    -------
    Ratio or None
        R̄ with L̄ = log R̄, and its witness; None if it is undefined (`Law.global_groups` is empty). Source: paper, definition of
        global g-fairness.
    """
    found = most_unequal_ratios(law, utility, 1, within_context=False)
    return found[0] if found else None


def local_supremum(law: Law) -> Ratio | None:
    """Supremum of the local ratio over all utilities g(u,x) ≥ 0 that are blind to the group, max P(u|x,a)/P(u|x,a') (T6).

    Source: T6; Coq `T6_local`, `T6_attained`, `T6_zero_denominator`.
    """
    grid = probability_grid(law)
    found = _rank(grid, 1)
    return _local_ratio(law, grid, *found[0], decision=True) if found else None


def global_supremum(law: Law) -> Ratio | None:
    """Supremum of the global ratio over all utilities g(u) ≥ 0, max P(u|a)/P(u|a') (T6).

    Source: T6; Coq `T6_global`, `T6_global_attained`.
    """
    groups = law.global_groups
    if not groups:
        return None
    grid = mixed_grid(law)
    ((column, high, low),) = _rank(grid, 1)
    values = (Fraction(*grid.exact(high, column)), Fraction(*grid.exact(low, column)))
    witness = Witness(None, law.group_label(groups[high]), law.group_label(groups[low]), values, law.decisions[column])
    return Ratio(quotient(*values), witness)


def most_unequal_ratios(law: Law, utility: UtilityTable, count: int, *, within_context: bool) -> tuple[Ratio, ...]:
    """Rank pairs of groups by the ratio of their expected utilities.

    Parameters
    ----------
    law : Law
        The law.
    utility : UtilityTable
        The utility on that law.
    count : int
        How many pairs at the most.
    within_context : bool
        Whether groups are compared within each context, or by their means over contexts.

    Returns
    -------
    tuple of Ratio
        The most unequal pairs first; pairs that are equal are left out unless nothing else is there.
    """
    if within_context:
        grid = expectation_grid(law, utility)
        return tuple(_local_ratio(law, grid, *found) for found in _rank(grid, count))
    grid = mean_grid(law, utility)
    return tuple(_global_ratio(law, grid, high, low) for _, high, low in _rank(grid, count))


def most_unequal_contexts(law: Law, utility: UtilityTable, count: int) -> tuple[Ratio, ...]:
    """Rank contexts by the ratio of their most unequal pair of groups.

    Returns
    -------
    tuple of Ratio
        That pair of each of the `count` most unequal contexts, most unequal first; contexts in which all groups get the same are left out.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[[3, 1], [1, 1]], [[1, 1], [1, 3]]], kind="counts", decisions=["yes", "no"])
    >>> [(str(found.ratio), found.witness.context) for found in most_unequal_contexts(law, Utility({"yes": 1}).on(law), 5)]
    [('2', {'context': '1'}), ('3/2', {'context': '0'})]
    """
    grid = expectation_grid(law, utility)
    return tuple(_local_ratio(law, grid, *found) for found in _unequal(grid, count, of_block=1))


def _rank(grid: Grid, count: int) -> list[tuple[int, int, int]]:
    """Find the `count` greatest ratios as (column, higher, lower), by member; equal pairs only if nothing else is there."""
    if len(grid.starts) < 2 or not len(grid.lo):
        return []
    return _unequal(grid, count, of_block=count) or [(0, 0, 1)]


def _unequal(grid: Grid, count: int, *, of_block: int) -> list[tuple[int, int, int]]:
    """Find the `count` greatest ratios above 1, so many of a block and column at the most."""
    if len(grid.starts) < 2 or not len(grid.lo):
        return []
    candidates = _candidates(grid, count)
    blocks = np.flatnonzero(candidates.any(axis=1))
    same = blocks[grid.same(blocks)]
    candidates[same] = False
    if grid.refine is not None:
        members = np.flatnonzero(np.repeat(candidates.any(axis=1), np.diff(grid.starts)))
        lo, hi = grid.lo.copy(), grid.hi.copy()
        lo[members], hi[members] = grid.refine(members)
        grid = replace(grid, lo=lo, hi=hi)
        candidates &= _candidates(grid, count)
    found: list[tuple[Pair, int, int, int, int]] = []
    infinite = 0
    for block, column in np.argwhere(candidates).tolist():
        for ratio, high, low in _rank_block(grid, block, column, of_block):
            found.append((ratio, block, column, high, low))
            infinite += ratio[1] == 0
        if infinite >= count:  # nothing is greater, and of equal ratios the first count
            break
        if len(found) > 64 * count:
            found = _best(found, count)
    return [(column, high, low) for _, _, column, high, low in _best(found, count)]


def _candidates(grid: Grid, count: int) -> NDArray[np.bool_]:
    """Tell which blocks, by column, may hold one of the `count` greatest ratios."""
    edges = grid.starts[:-1]
    top_lo, top_hi = np.maximum.reduceat(grid.lo, edges), np.maximum.reduceat(grid.hi, edges)
    low_lo, low_hi = np.minimum.reduceat(grid.lo, edges), np.minimum.reduceat(grid.hi, edges)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        upper = np.where(low_lo > 0, top_hi / low_lo * (1 + 4 * UNIT), np.where(top_hi > 0, np.inf, 1.0))
        lower = np.where(low_hi > 0, top_lo / low_hi * (1 - 4 * UNIT), np.where(top_lo > 0, np.inf, 1.0))
    upper, lower = np.nan_to_num(upper, nan=np.inf, posinf=np.inf), np.maximum(np.nan_to_num(lower, nan=1.0, posinf=np.inf), 1.0)
    ranked = np.sort(lower, axis=None)
    return np.asarray(upper >= ranked[-min(count, ranked.size)])


def _best(found: list[tuple[Pair, int, int, int, int]], count: int) -> list[tuple[Pair, int, int, int, int]]:
    def order(p: tuple[Pair, int, int, int, int], q: tuple[Pair, int, int, int, int]) -> int:
        left, right = p[0][0] * q[0][1], q[0][0] * p[0][1]
        if left != right and (p[0][1] or q[0][1]):
            return -1 if left > right else 1
        return -1 if p[1:] < q[1:] else 1

    return heapq.nsmallest(count, found, key=cmp_to_key(order))


def _rank_block(grid: Grid, block: int, column: int, count: int) -> list[tuple[Pair, int, int]]:
    """The `count` greatest ratios above 1 within a block."""
    start, end = int(grid.starts[block]), int(grid.starts[block + 1])
    lo, hi = grid.lo[start:end, column], grid.hi[start:end, column]
    size = end - start
    keep = min(count + 1, size)
    needed = np.flatnonzero((hi >= np.partition(lo, size - keep)[size - keep]) | (lo <= np.partition(hi, keep - 1)[keep - 1]))
    values: dict[int, Fraction] = {i: Fraction(*grid.exact(start + i, column)) for i in needed.tolist()}
    if any(v == 0 for v in values.values()):
        # Against a zero every positive member gives the same infinite ratio, and the first in input order count.
        positive = 0
        for i in range(size):
            if i not in values:
                values[i] = Fraction(*grid.exact(start + i, column))
            positive += values[i] > 0
            if positive > count:
                break
    members = sorted(values)
    by_low = sorted(members, key=lambda i: (values[i], i))[:keep]
    by_high = sorted(members, key=lambda i: (-values[i], i))[:keep]
    tops = set(by_high) | set([i for i in members if values[i] > 0][:keep])
    pairs = []
    for low in by_low:
        for high in tops:
            if values[high] > values[low]:
                v, w = values[high], values[low]
                ratio = (v.numerator * w.denominator, v.denominator * w.numerator) if w else (1, 0)
                pairs.append((ratio, block, column, start + high, start + low))
    return [(ratio, high, low) for ratio, _, _, high, low in _best(pairs, count)]


def _local_ratio(law: Law, grid: Grid, column: int, high: int, low: int, *, decision: bool = False) -> Ratio:
    cells = np.flatnonzero(law.compared)
    values = (Fraction(*grid.exact(high, column)), Fraction(*grid.exact(low, column)))
    witness = Witness(
        law.context_label(int(law.cell_context[cells[high]])),
        law.group_label(int(law.cell_group[cells[high]])),
        law.group_label(int(law.cell_group[cells[low]])),
        values,
        law.decisions[column] if decision else None,
    )
    return Ratio(quotient(*values), witness)


def _global_ratio(law: Law, grid: Grid, high: int, low: int) -> Ratio:
    groups = law.global_groups
    values = (Fraction(*grid.exact(high, 0)), Fraction(*grid.exact(low, 0)))
    return Ratio(quotient(*values), Witness(None, law.group_label(groups[high]), law.group_label(groups[low]), values))
