"""Differences of expected utilities of two groups, D within contexts and D̄ over all of them, each with its witness.

A difference does not depend on the origin of the utility, so that utilities of any sign have one. It is found for the utility less its
least value, which is at least 0, by the same enclosures as ratios: a float64 pass rules out what cannot be the maximum, integers
decide the rest, and ties go to input order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from fairaudit.measures.expectations import Grid, expectation_grid, least_expectation, mean_grid
from fairaudit.measures.ratios import Witness
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.words import brief

__all__ = ["MeanDifference", "furthest_contexts", "global_difference", "least_signed_expectation", "local_difference", "outermost_means"]


@brief
@dataclass(frozen=True, repr=False)
class MeanDifference:
    """The greatest difference of the expected utilities of two groups.

    Attributes
    ----------
    value : Fraction
        The exact difference, at least 0.
    witness : Witness
        Where it is attained; ties go to input order.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"answer": ["better", "worse", "better", "worse"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> utility = {"better": 1, "worse": -1}
    >>> result = fa.audit(table, decision="answer", group="sex", count="n", utility=utility, difference=True, confidence=None)
    >>> found = result.differences.measured["local"]
    >>> found.value, found.witness.higher, found.witness.expectations
    (Fraction(1, 2), {'sex': 'f'}, (Fraction(1, 2), Fraction(0, 1)))
    """

    value: Fraction
    witness: Witness


def local_difference(law: Law, utility: UtilityTable) -> MeanDifference | None:
    """The greatest difference of expected utilities between two groups within a context; None if no context has two groups.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> local_difference(law, Utility({"yes": 1, "no": -1}, signed=True).on(law)).value
    Fraction(1, 2)
    """
    found = _widest(expectation_grid(law, _raised(utility)))
    return None if found is None else _local_difference(law, utility, found)


def furthest_contexts(law: Law, utility: UtilityTable, count: int) -> tuple[MeanDifference, ...]:
    """Rank contexts by the difference of the two groups that are furthest apart in them; those without a difference are left out.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[[3, 1], [1, 1]], [[1, 1], [0, 1]]], kind="counts", decisions=["yes", "no"])
    >>> [str(found.value) for found in furthest_contexts(law, Utility({"yes": 1}).on(law), 5)]
    ['1/2', '1/4']
    """
    grid = expectation_grid(law, _raised(utility))
    if len(grid.starts) < 2:
        return ()
    found = [(_of_block(grid, block), block) for block in _candidates(grid, count)]
    found.sort(key=lambda entry: (entry[0][0][1] - entry[0][0][0], entry[1]))
    return tuple(_local_difference(law, utility, own) for own, _ in found[:count] if own[0][0] > own[0][1])


def outermost_means(law: Law, utility: UtilityTable, count: int, *, greatest: bool) -> list[tuple[int, Fraction]]:
    """Exact means of those global groups among which are so many with the least means, or the greatest, and the last one at the other end.

    Others are left out whose enclosures in floats show that they are neither; the rest stand in the order of the law.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([["0.1", "0.9"], ["0.5", "0.5"], ["0.4", "0.6"], ["0.7", "0.3"]], decisions=["yes", "no"], groups=list("abcd"))
    >>> [(a, str(mean)) for a, mean in outermost_means(law, Utility({"yes": 1}).on(law), 1, greatest=False)]
    [(0, '1/10'), (3, '7/10')]
    """
    grid, least = mean_grid(law, _raised(utility)), min(utility.m, Fraction(0))
    lo, hi = grid.lo[:, 0], grid.hi[:, 0]
    if greatest:
        lo, hi = -hi, -lo
    limit = np.sort(hi)[min(count, len(hi)) - 1]
    chosen = np.flatnonzero((lo <= limit) | (hi >= lo.max()))
    return [(law.global_groups[i], Fraction(*grid.exact(i, 0)) + least) for i in chosen.tolist()]


def _local_difference(law: Law, utility: UtilityTable, found: tuple[tuple[Fraction, Fraction], int, int]) -> MeanDifference:
    cells = np.flatnonzero(law.compared)
    high, low = (int(cells[i]) for i in found[1:])
    context = law.context_label(int(law.cell_context[high]))
    groups = [law.group_label(int(law.cell_group[i])) for i in (high, low)]
    return _difference(utility, found[0], context, groups)


def global_difference(law: Law, utility: UtilityTable) -> MeanDifference | None:
    """The greatest difference of group means, after averaging over the contexts of each group; None where they are not compared."""
    found = _widest(mean_grid(law, _raised(utility)))
    groups = law.global_groups
    return None if found is None else _difference(utility, found[0], None, [law.group_label(groups[i]) for i in found[1:]])


def least_signed_expectation(law: Law, utility: UtilityTable) -> Fraction | None:
    """The least expected utility over the compared cells, for a utility of any sign; None if no cell is compared."""
    least = least_expectation(law, _raised(utility))
    return None if least is None else least + min(utility.m, Fraction(0))


def _raised(utility: UtilityTable) -> UtilityTable:
    """The utility less its least value, where that is negative."""
    if not utility.signed:
        return utility
    values = utility.values.astype(object) + int(utility.scale * -utility.m)
    if utility.given is not None:
        values[~utility.given] = 0
    small = int(values.max()) < 2**62
    return replace(utility, values=values.astype(np.int64) if small else values)


def _difference(
    utility: UtilityTable, pair: tuple[Fraction, Fraction], context: dict[str, str] | None, groups: list[dict[str, str]]
) -> MeanDifference:
    low = min(utility.m, Fraction(0))
    return MeanDifference(pair[0] - pair[1], Witness(context, groups[0], groups[1], (pair[0] + low, pair[1] + low)))


def _widest(grid: Grid) -> tuple[tuple[Fraction, Fraction], int, int] | None:
    """The two expectations of one block that are furthest apart, and their members; the first two if nothing differs."""
    if len(grid.starts) < 2 or not len(grid.lo):
        return None
    best = _of_block(grid, 0)
    for block in _candidates(grid):
        found = _of_block(grid, block)
        if found[0][0] - found[0][1] > best[0][0] - best[0][1]:
            best = found
    return best


def _candidates(grid: Grid, count: int = 1) -> Iterator[int]:
    """The blocks that may hold one of the greatest differences, in order; those of equal rows have none."""
    edges, lo, hi = grid.starts[:-1], grid.lo[:, 0], grid.hi[:, 0]
    apart = np.maximum.reduceat(hi, edges) - np.minimum.reduceat(lo, edges)
    surely = np.maximum.reduceat(lo, edges) - np.minimum.reduceat(hi, edges)
    upper, lower = np.nextafter(apart, np.inf), np.nextafter(surely, -np.inf)
    blocks = np.flatnonzero(~(upper < np.sort(lower)[-min(count, lower.size)]))
    yield from blocks[~grid.same(blocks)].tolist()


def _of_block(grid: Grid, block: int) -> tuple[tuple[Fraction, Fraction], int, int]:
    """The first greatest and the first least member of a block, with their values."""
    start, end = int(grid.starts[block]), int(grid.starts[block + 1])
    lo, hi = grid.lo[start:end, 0], grid.hi[start:end, 0]
    tops, bottoms = np.flatnonzero(hi >= lo.max()).tolist(), np.flatnonzero(lo <= hi.min()).tolist()
    values = {i: Fraction(*grid.exact(start + i, 0)) for i in {*tops, *bottoms, 0, 1}}
    high, low = max(tops, key=lambda i: (values[i], -i)), min(bottoms, key=lambda i: (values[i], i))
    if values[high] == values[low]:
        high, low = 0, 1
    return (values[high], values[low]), start + high, start + low
