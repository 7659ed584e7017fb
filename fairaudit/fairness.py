"""Exact fairness measures of a law, each with its witness.

A float64 pass with a rigorous error bound rules out what cannot be the maximum; what is left is decided in integers. The result is
therefore exact, and ties go to input order.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, cmp_to_key
from itertools import pairwise
from math import gcd
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.columns import INT64
from fairaudit.dense import equal_to_previous, products
from fairaudit.exact import InputError, log_enclosure, quotient
from fairaudit.law import Law
from fairaudit.utility import UtilityTable

__all__ = [
    "Distance",
    "DistanceWitness",
    "Ratio",
    "Witness",
    "compared_expectations",
    "demographic_parity",
    "equalized_odds",
    "global_fairness",
    "global_supremum",
    "least_expectation",
    "local_fairness",
    "local_supremum",
    "most_unequal_distances",
    "most_unequal_ratios",
]

Pair = tuple[int, int]
Floats = NDArray[np.float64]
UNIT = 2.0**-53
TINY = 2.0**-1074
EXACT = 2**53
BLOCK = 1 << 17


@dataclass(frozen=True)
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
    """

    context: dict[str, str] | None
    higher: dict[str, str]
    lower: dict[str, str]
    expectations: tuple[Fraction, Fraction]
    decision: str | None = None


@dataclass(frozen=True)
class Ratio:
    """A worst ratio between two groups.

    Attributes
    ----------
    ratio : Fraction or float
        The exact ratio R ≥ 1, or `math.inf`.
    witness : Witness
        Where it is attained; ties go to input order.
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


@dataclass(frozen=True)
class DistanceWitness:
    """Where a total variation distance is attained: on the event that the decision is one of `decisions`."""

    context: dict[str, str] | None
    higher: dict[str, str]
    lower: dict[str, str]
    decisions: tuple[str, ...]


@dataclass(frozen=True)
class Distance:
    """A greatest total variation distance between two groups, exact, with its witness."""

    value: Fraction
    witness: DistanceWitness


@dataclass(frozen=True)
class _Grid:
    """Non-negative exact values on members × columns, enclosed in floats; members are sorted into blocks (contexts)."""

    lo: Floats
    hi: Floats
    starts: NDArray[np.int64]
    exact: Callable[[int, int], Pair]
    same: Callable[[NDArray[np.int64]], NDArray[np.bool_]]
    """Which of the given blocks have members that are byte for byte equal."""
    refine: Callable[[NDArray[np.int64]], tuple[Floats, Floats]] | None = None
    """Sharper ends for the given members, where these here are quick and coarse."""


@dataclass(frozen=True)
class _Rows:
    """Laws of members, sorted into blocks: floats with an absolute error bound per distance, and exact integer rows."""

    floats: Floats
    error: float
    starts: NDArray[np.int64]
    exact: Callable[[int], list[int]]
    exact_key: NDArray[Any]
    """The rows as they are stored: members with equal stored rows are surely equal."""


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
    >>> from fairaudit.utility import Utility
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
    """Supremum of the local ratio over all utilities g(u,x) ≥ 0 that are blind to the group, max P(u|x,a)/P(u|x,a') (T6)."""
    grid = _probability_grid(law)
    found = _rank(grid, 1)
    return _local_ratio(law, grid, *found[0], decision=True) if found else None


def global_supremum(law: Law) -> Ratio | None:
    """Supremum of the global ratio over all utilities g(u) ≥ 0, max P(u|a)/P(u|a') (T6)."""
    rows, groups = law.mixed_rows, law.global_groups
    if not groups:
        return None
    grid = _listed_grid([[(w, sum(row)) for w in row] for row in rows])
    ((column, high, low),) = _rank(grid, 1)
    values = (Fraction(*grid.exact(high, column)), Fraction(*grid.exact(low, column)))
    witness = Witness(None, law.group_label(groups[high]), law.group_label(groups[low]), values, law.decisions[column])
    return Ratio(quotient(*values), witness)


def demographic_parity(law: Law) -> Distance | None:
    """Demographic parity: the greatest total variation distance between P(·|a) and P(·|a'); None if undefined."""
    found = most_unequal_distances(law, 1, within_context=False)
    return found[0] if found else None


def equalized_odds(law: Law) -> Distance | None:
    """Equalized odds in the paper's form, conditioned on the context: the greatest distance between P(·|x,a) and P(·|x,a')."""
    found = most_unequal_distances(law, 1, within_context=True)
    return found[0] if found else None


def least_expectation(law: Law, utility: UtilityTable) -> Fraction | None:
    """τ, the least expected utility E(x,a) over the compared cells; None if no cell is compared."""
    grid = _expectation_grid(law, utility)
    if not len(grid.lo):
        return None
    candidates = np.flatnonzero(grid.lo[:, 0] <= grid.hi[:, 0].min())
    best = None
    for i in _one_of_each(law, utility, candidates):
        value = grid.exact(i, 0)
        if best is None or value[0] * best[1] < best[0] * value[1]:
            best = value
    return Fraction(*best) if best else None


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
        grid = _expectation_grid(law, utility)
        return tuple(_local_ratio(law, grid, *found) for found in _rank(grid, count))
    grid = _mean_grid(law, utility)
    return tuple(_global_ratio(law, grid, high, low) for _, high, low in _rank(grid, count))


def most_unequal_distances(law: Law, count: int, *, within_context: bool) -> tuple[Distance, ...]:
    """Rank pairs of groups by the total variation distance of their decisions.

    Parameters
    ----------
    law : Law
        The law.
    count : int
        How many pairs at the most.
    within_context : bool
        Whether groups are compared within each context (equalized odds) or over all (demographic parity).

    Returns
    -------
    tuple of Distance
        The most unequal pairs first; pairs that are equal are left out unless nothing else is there.
    """
    if within_context:
        cells = np.flatnonzero(law.compared)
        rows = _law_rows(law, cells)
        owner = [int(g) for g in law.cell_group[cells]]
    else:
        owner = list(law.global_groups)
        rows = _listed_rows(law.mixed_rows)
        cells = np.zeros(len(owner), dtype=np.int64)
    results = []
    for value, i, j in _rank_distances(rows, count):
        p, q = rows.exact(i), rows.exact(j)
        total_p, total_q = sum(p), sum(q)
        chosen = tuple(u for u, v, w in zip(law.decisions, p, q, strict=True) if v * total_q > w * total_p)
        context = law.context_label(int(law.cell_context[cells[i]])) if within_context else None
        results.append(Distance(value, DistanceWitness(context, law.group_label(owner[i]), law.group_label(owner[j]), chosen)))
    return tuple(results)


def compared_expectations(law: Law, utility: UtilityTable, *, within_context: bool) -> list[list[Fraction]]:
    """Expected utilities that are compared, exactly: by context, or all groups' means in one block.

    Examples
    --------
    >>> from fairaudit.utility import Utility
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> compared_expectations(law, Utility({"yes": 1}).on(law), within_context=True)
    [[Fraction(3, 4), Fraction(1, 2)]]
    """
    grid = _expectation_grid(law, utility) if within_context else _mean_grid(law, utility)
    return [[Fraction(*grid.exact(i, 0)) for i in range(a, b)] for a, b in pairwise(grid.starts.tolist())]


def cell_expectation(law: Law, utility: UtilityTable, cell: int) -> Pair:
    """E(x,a) of a cell as an exact, not necessarily reduced, pair."""
    row = law.row(cell)
    top = sum(w * g for w, g in zip(row, utility.row(cell), strict=True))
    return top, sum(row) * utility.scale


# Grids: what is compared, with enclosures


def _block_starts(law: Law, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    if not len(cells):
        return np.zeros(1, dtype=np.int64)
    edges = np.flatnonzero(np.diff(law.cell_context[cells])) + 1
    return np.concatenate(([0], edges, [len(cells)])).astype(np.int64)


def _expectation_grid(law: Law, utility: UtilityTable) -> _Grid:
    cells = np.flatnonzero(law.compared)
    everything = len(cells) == len(law.weights)
    weights = law.weights if everything else law.weights[cells]
    values = utility.values if utility.by_decision or everything else utility.values[cells]
    totals = law.float_sums if law.floating else law.totals
    sums = totals if everything else totals[cells]
    factors = _unit_floats(values) if law.floating else values
    lo, hi = _expectation_enclosure(weights, sums, factors)
    starts = _block_starts(law, cells)
    cache: dict[tuple[bytes, bytes], Pair] = {}

    def exact(i: int, _: int) -> Pair:
        key = (
            _row_key(weights[i], b"" if values.ndim == 1 else values[i].tobytes())
            if weights.dtype != object and values.dtype != object
            else None
        )
        if key is None:
            return cell_expectation(law, utility, int(cells[i]))
        if key not in cache:
            cache[key] = cell_expectation(law, utility, int(cells[i]))
        return cache[key]

    def same(blocks: NDArray[np.int64]) -> NDArray[np.bool_]:
        equal = _equal_blocks(weights, starts, blocks)
        return equal if values.ndim == 1 else equal & _equal_blocks(values, starts, blocks)

    def refine(members: NDArray[np.int64]) -> tuple[Floats, Floats]:
        some = slice(None) if len(members) == len(cells) else members
        low, high = _expectation_enclosure(weights[some], sums[some], factors if factors.ndim == 1 else factors[some], fine=True)
        return low[:, None], high[:, None]

    return _Grid(lo[:, None], hi[:, None], starts, exact, same, refine if weights.dtype == np.float32 else None)


def _row_key(row: NDArray[Any], extra: bytes) -> tuple[bytes, bytes]:
    return row.tobytes(), extra


def _expectation_enclosure(weights: NDArray[Any], sums: NDArray[Any], values: NDArray[Any], *, fine: bool = False) -> tuple[Floats, Floats]:
    """Float bounds on E·scale, all in one common unit; for float rows `values` are floats, and float32 is quick and coarse unless `fine`.

    For float rows the n products and sums of non-negative numbers carry a relative error of at most (2n+8)·u·1.01, and underflow adds
    at most (n + Σw)·t to the numerator, with u = 2^-53 and t = 2^-1074 (float32: 2^-24 and 2^-149).
    """
    n = weights.shape[1]
    if weights.dtype.kind == "f":
        coarse = weights.dtype == np.float32 and not fine
        unit, tiny = (2.0**-24, 2.0**-149) if coarse else (UNIT, TINY)
        tops = products(weights, values.astype(np.float32) if coarse else values)
        middle = tops / sums
        relative = (2 * n + 12) * unit * 1.01
        absolute = (n + sums) * tiny / sums * 1.01 + TINY
        absolute = np.where(tops > n * tiny * 2.0 ** (30 if coarse else 114), 0.0, absolute)
        return np.maximum(middle * (1 - relative) - absolute, 0.0), middle * (1 + relative) + absolute
    if weights.dtype != object and values.dtype != object:
        greatest = int(sums.max()) * int(values.max()) if len(sums) else 0
        if greatest <= INT64:
            if greatest < EXACT:
                tops = products(weights, values)
            else:
                tops = weights @ values if values.ndim == 1 else (weights * values).sum(axis=1)
            middle = tops / sums
            return middle * (1 - 8 * UNIT), middle * (1 + 8 * UNIT)
    wide, g = weights.astype(object), values.astype(object)
    numerators = wide @ g if g.ndim == 1 else (wide * g).sum(axis=1)
    return _enclose(list(zip(numerators.tolist(), sums.tolist(), strict=True)))


def _unit_floats(values: NDArray[Any]) -> Floats:
    """Non-negative integers divided by the greatest, each within a relative 2^-52."""
    top = max(int(values.max()), 1)
    if values.dtype != object:
        return values.astype(np.float64) / top
    return np.array([int(v) / top for v in values.ravel()], dtype=np.float64).reshape(values.shape)


def _enclose(pairs: Sequence[Pair]) -> tuple[Floats, Floats]:
    """Float neighbours of exact quotients; Python's division of integers is correctly rounded."""
    middle = np.empty(len(pairs))
    for i, (top, bottom) in enumerate(pairs):
        try:
            middle[i] = top / bottom
        except OverflowError:
            middle[i] = np.inf
    zero = np.array([top == 0 for top, _ in pairs], dtype=bool)
    lo = np.where(np.isinf(middle), np.finfo(np.float64).max, np.maximum(np.nextafter(middle, -np.inf), 0.0))
    hi = np.nextafter(middle, np.inf)
    lo[zero] = hi[zero] = 0.0
    return lo, hi


def _probability_grid(law: Law) -> _Grid:
    cells = np.flatnonzero(law.compared)
    weights = law.weights if len(cells) == len(law.weights) else law.weights[cells]
    starts = _block_starts(law, cells)
    n = weights.shape[1]
    if weights.dtype == object:
        flat = [(w, total) for row in weights.tolist() for total in (sum(row),) for w in row]
        lo, hi = (bound.reshape(weights.shape) for bound in _enclose(flat))
    else:
        middle = law.float_rows(cells)
        relative = (n + 8) * UNIT * 1.01 if weights.dtype.kind == "f" else 8 * UNIT
        absolute = np.where((middle > 0) & (middle < 2.0**-960), 2 * TINY, 0.0)
        if weights.dtype.kind == "f":
            absolute[(middle == 0) & (weights > 0)] = 2 * TINY
        lo, hi = np.maximum(middle * (1 - relative) - absolute, 0.0), middle * (1 + relative) + absolute

    def exact(i: int, column: int) -> Pair:
        row = law.row(int(cells[i]))
        return row[column], sum(row)

    return _Grid(lo, hi, starts, exact, lambda blocks: _equal_blocks(weights, starts, blocks))


def _equal_blocks(matrix: NDArray[Any], starts: NDArray[np.int64], blocks: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell which of the given blocks have equal rows only."""
    chosen = np.zeros(len(starts) - 1, dtype=bool)
    chosen[blocks] = True
    equal = equal_to_previous(matrix, np.repeat(chosen, np.diff(starts)))
    equal[starts[:-1]] = True
    return np.asarray(np.logical_and.reduceat(equal, starts[:-1])[blocks]) if len(blocks) else np.zeros(0, dtype=bool)


def _listed_grid(table: Sequence[Sequence[Pair]]) -> _Grid:
    """A single block of few members, from exact values."""
    columns = len(table[0]) if table else 1
    lo, hi = (bound.reshape(len(table), columns) for bound in _enclose([pair for row in table for pair in row]))
    starts = np.array([0, len(table)] if table else [0], dtype=np.int64)
    return _Grid(lo, hi, starts, lambda i, k: table[i][k], lambda blocks: np.zeros(len(blocks), dtype=bool))


def _mean_grid(law: Law, utility: UtilityTable) -> _Grid:
    """Ē(a) of the globally compared groups."""
    if law.floating and law.global_groups:
        return _float_mean_grid(law, utility)
    return _listed_grid([[mean] for mean in _group_means(law, utility)])


def _float_mean_grid(law: Law, utility: UtilityTable) -> _Grid:
    """Ē(a) of float rows, which share no denominator: enclosed in floats, and exact only where it is asked for."""
    lo, hi = _expectation_enclosure(law.weights, law.float_sums, _unit_floats(utility.values), fine=True)
    members = [[i for i in np.flatnonzero(law.cell_group == group).tolist() if law.cell_mass[i]] for group in law.global_groups]
    totals = [sum(law.cell_mass[i] for i in cells) for cells in members]
    shares = [np.array([law.cell_mass[i] / total for i in cells]) for cells, total in zip(members, totals, strict=True)]
    slack = [(len(cells) + 8) * UNIT for cells in members]
    low = [float(share @ lo[cells]) * (1 - s) for share, cells, s in zip(shares, members, slack, strict=True)]
    high = [float(share @ hi[cells]) * (1 + s) + len(cells) * TINY for share, cells, s in zip(shares, members, slack, strict=True)]
    low = [v if v > 2.0**-960 else 0.0 for v in low]
    known: dict[bytes, Pair] = {}
    means: dict[int, Pair] = {}

    def expectation(cell: int) -> Pair:
        key = law.weights[cell].tobytes() + (b"" if utility.by_decision else str(utility.row(cell)).encode())
        if key not in known:
            known[key] = cell_expectation(law, utility, cell)
        return known[key]

    def exact(i: int, _: int) -> Pair:
        if i not in means:
            top, bottom = _sum([(law.cell_mass[cell] * e, d) for cell in members[i] for e, d in (expectation(cell),)])
            means[i] = top, bottom * totals[i]
        return means[i]

    starts = np.array([0, len(members)], dtype=np.int64)
    return _Grid(np.array(low)[:, None], np.array(high)[:, None], starts, exact, lambda blocks: np.zeros(len(blocks), dtype=bool))


def _sum(pairs: Sequence[Pair]) -> Pair:
    """Sum of quotients, in lowest terms, by halves so that the numbers stay short for long."""
    if len(pairs) == 1:
        top, bottom = pairs[0]
    else:
        (a, b), (c, d) = _sum(pairs[: len(pairs) // 2]), _sum(pairs[len(pairs) // 2 :])
        top, bottom = (a + c, b) if b == d else (a * d + c * b, b * d)
    common = gcd(top, bottom)
    if bottom.bit_length() - common.bit_length() > 300_000:
        raise InputError(
            "the exact global figures of this table need more than 90,000 digits; give the probabilities as decimals of the "
            "same length, so that rows share a denominator"
        )
    return top // common, bottom // common


def _group_means(law: Law, utility: UtilityTable) -> list[Pair]:
    """Ē(a) of the globally compared groups of integer rows, exact."""
    if not law.global_groups:
        return []
    coefficients, totals = law.mixing
    if law.weights.dtype == np.int64 == utility.values.dtype and int(law.totals.max()) * int(utility.values.max()) <= INT64:
        tops = law.weights @ utility.values if utility.by_decision else (law.weights * utility.values).sum(axis=1)
        listed: list[int] = tops.tolist()
    else:
        listed = [
            sum(w * g for w, g in zip(row, utility.row(i), strict=True)) if coefficients[i] else 0 for i, row in enumerate(law.integer_rows)
        ]
    sums: dict[int, int] = {}
    for group, coefficient, top in zip(law.cell_group.tolist(), coefficients.tolist(), listed, strict=True):
        sums[group] = sums.get(group, 0) + coefficient * top
    return [(sums[group], totals[group] * utility.scale) for group in law.global_groups]


def _law_rows(law: Law, cells: NDArray[np.int64]) -> _Rows:
    weights = law.weights if len(cells) == len(law.weights) else law.weights[cells]

    def exact(i: int) -> list[int]:
        return law.row(int(cells[i]))

    return _Rows(law.float_rows(cells), _distance_error(len(law.decisions)), _block_starts(law, cells), exact, weights)


def _listed_rows(rows: Sequence[list[int]]) -> _Rows:
    starts = np.array([0, len(rows)] if rows else [0], dtype=np.int64)
    columns = len(rows[0]) if rows else 1
    return _Rows(
        _object_rows(rows).reshape(len(rows), columns),
        _distance_error(columns),
        starts,
        rows.__getitem__,
        np.array(rows, dtype=object).reshape(len(rows), columns),
    )


def _object_rows(rows: Sequence[Sequence[int]]) -> Floats:
    return np.array([[w / total for w in row] for row in rows for total in (sum(row),)], dtype=np.float64)


def _distance_error(columns: int) -> float:
    """Bound on the error of Σ max(0, p − q): two rows with relative errors of (n+4) units each, differences, and the sum."""
    return (4 * columns + 64) * UNIT


# Ranking ratios


def _rank(grid: _Grid, count: int) -> list[tuple[int, int, int]]:
    """Find the `count` greatest ratios as (column, higher, lower), by member; equal pairs only if nothing else is there."""
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
        for ratio, high, low in _rank_block(grid, block, column, count):
            found.append((ratio, block, column, high, low))
            infinite += ratio[1] == 0
        if infinite >= count:  # nothing is greater, and of equal ratios the first count
            break
        if len(found) > 64 * count:
            found = _best(found, count)
    found = _best(found, count)
    if found:
        return [(column, high, low) for _, _, column, high, low in found]
    return [(0, 0, 1)]


def _candidates(grid: _Grid, count: int) -> NDArray[np.bool_]:
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


def _rank_block(grid: _Grid, block: int, column: int, count: int) -> list[tuple[Pair, int, int]]:
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


def _local_ratio(law: Law, grid: _Grid, column: int, high: int, low: int, *, decision: bool = False) -> Ratio:
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


def _global_ratio(law: Law, grid: _Grid, high: int, low: int) -> Ratio:
    groups = law.global_groups
    values = (Fraction(*grid.exact(high, 0)), Fraction(*grid.exact(low, 0)))
    return Ratio(quotient(*values), Witness(None, law.group_label(groups[high]), law.group_label(groups[low]), values))


def _one_of_each(law: Law, utility: UtilityTable, candidates: NDArray[np.int64]) -> Iterator[int]:
    """Members of a list of compared cells, rows that repeat byte for byte only once."""
    cells = np.flatnonzero(law.compared)
    if law.weights.dtype == object or utility.values.dtype == object:
        yield from candidates.tolist()
        return
    seen: set[bytes] = set()
    for i in candidates.tolist():
        cell = int(cells[i])
        key = law.weights[cell].tobytes() + (b"" if utility.by_decision else utility.values[cell].tobytes())
        if key not in seen:
            seen.add(key)
            yield i


# Ranking distances


def _rank_distances(rows: _Rows, count: int) -> list[tuple[Fraction, int, int]]:
    """Find the `count` greatest total variation distances as (value, first, second); equal pairs only if nothing else is there."""
    if len(rows.starts) < 2 or not len(rows.floats):
        return []
    _, firsts, seconds = _distance_candidates(rows, count)
    order = np.lexsort((seconds, firsts))
    classes: dict[tuple[int, ...], int] = {}
    class_of: dict[int, int] = {}

    def row_class(i: int) -> int:
        if i not in class_of:
            row = rows.exact(i)
            common = gcd(*row)
            class_of[i] = classes.setdefault(tuple(v // common for v in row), len(classes))
        return class_of[i]

    exact: dict[tuple[int, int], Fraction] = {}
    found: list[tuple[Fraction, int, int]] = []
    certain = 0
    for i, j in zip(firsts[order].tolist(), seconds[order].tolist(), strict=True):
        p, q = row_class(i), row_class(j)
        if p == q:
            continue
        key = (min(p, q), max(p, q))
        if key not in exact:
            exact[key] = _distance(rows.exact(i), rows.exact(j))
        found.append((exact[key], i, j))
        certain += exact[key] == 1
        if certain >= count:
            break
    best = heapq.nsmallest(count, found, key=lambda entry: (-entry[0], entry[1], entry[2]))
    return best or [(Fraction(0), 0, 1)]


def _distance(p: list[int], q: list[int]) -> Fraction:
    total_p, total_q = sum(p), sum(q)
    return Fraction(sum(max(0, v * total_q - w * total_p) for v, w in zip(p, q, strict=True)), total_p * total_q)


def _distance_candidates(rows: _Rows, count: int) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Pairs (first < second) whose float distance could be among the `count` greatest."""
    sizes = np.diff(rows.starts)
    sizes[_equal_blocks(rows.exact_key, rows.starts, np.arange(len(sizes)))] = 0
    kept: list[tuple[Floats, NDArray[np.int64], NDArray[np.int64]]] = []
    floor = 0.0
    for size in np.unique(sizes[sizes > 1]).tolist():
        blocks = np.flatnonzero(sizes == size)
        first_rows = rows.starts[:-1][blocks]
        for values, firsts, seconds in _block_distances(rows.floats, first_rows, size):
            if values.size > count:
                floor = max(floor, float(np.partition(values, values.size - count)[values.size - count]))
            good = values >= floor - 2 * rows.error
            kept.append((values[good], firsts[good], seconds[good]))
    if not kept:
        nothing = np.zeros(0, dtype=np.int64)
        return nothing.astype(np.float64), nothing, nothing
    values, firsts, seconds = (np.concatenate(part) for part in zip(*kept, strict=True))
    if values.size > count:
        floor = max(floor, float(np.partition(values, values.size - count)[values.size - count]))
    good = values >= floor - 2 * rows.error
    values, firsts, seconds = values[good], firsts[good], seconds[good]
    differ = np.ones(len(values), dtype=bool)
    close = np.flatnonzero(values <= 2 * rows.error)
    for part in np.array_split(close, max(1, len(close) * rows.floats.shape[1] // 10_000_000)):
        differ[part] = (rows.floats[firsts[part]] != rows.floats[seconds[part]]).any(axis=1)
    # Float rows that agree to the last bit may still differ exactly; only rows that are certainly equal may be skipped.
    doubtful = np.flatnonzero(~differ)
    if len(doubtful):
        differ[doubtful] = _exactly_different(rows, firsts[doubtful], seconds[doubtful])
    return values[differ], firsts[differ], seconds[differ]


def _exactly_different(rows: _Rows, firsts: NDArray[np.int64], seconds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Decide which pairs of rows differ as laws, evaluating every row once."""
    classes: dict[tuple[int, ...], int] = {}
    involved = np.unique(np.concatenate((firsts, seconds)))
    code = np.empty(len(rows.floats), dtype=np.int64)
    for i in involved.tolist():
        row = rows.exact(i)
        common = gcd(*row)
        code[i] = classes.setdefault(tuple(v // common for v in row), len(classes))
    return np.asarray(code[firsts] != code[seconds])


def _block_distances(
    floats: Floats, first_rows: NDArray[np.int64], size: int
) -> Iterator[tuple[Floats, NDArray[np.int64], NDArray[np.int64]]]:
    """Float distances of all pairs in blocks of one size, in chunks: vectorised over blocks when they are many, else over members."""
    if size * (size - 1) // 2 <= len(first_rows):
        step = max(1, 4_000_000 // max(1, size * floats.shape[1]))
        for begin in range(0, len(first_rows), step):
            base = first_rows[begin : begin + step]
            for i in range(size - 1):
                left = floats[base + i]
                for j in range(i + 1, size):
                    values = np.maximum(left - floats[base + j], 0.0).sum(axis=1)
                    yield values, base + i, base + j
        return
    ones = np.ones(floats.shape[1])
    step = max(1, BLOCK // (size * floats.shape[1]))
    for base in first_rows.tolist():
        block = floats[base : base + size]
        for start in range(0, size - 1, step):
            firsts = block[start : min(start + step, size - 1)]
            values = np.maximum(firsts[:, None] - block[None, start + 1 :], 0.0) @ ones
            first, second = np.nonzero(np.tri(*values.shape[::-1], dtype=np.bool_).T)
            yield values[first, second], base + start + first, base + start + 1 + second
