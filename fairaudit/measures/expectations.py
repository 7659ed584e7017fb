"""Expected utilities of cells and groups, exact, with float64 enclosures that say which of them need not be looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.dense import Floats, products, quotients
from fairaudit.exact.enclosures import UNIT
from fairaudit.exact.number_columns import added
from fairaudit.measures.blocks import block_starts, equal_blocks
from fairaudit.model.law import Law
from fairaudit.model.layout import dyadic_rows
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import INT64

__all__ = ["compared_expectations", "least_expectation"]


Pair = tuple[int, int]

TINY = 2.0**-1074  # the least positive float64: what underflow can lose

EXACT = 2**53  # whole numbers up to here are exact as float64


@dataclass(frozen=True)
class Grid:
    """Non-negative exact values on members × columns, enclosed in floats; members are sorted into blocks (contexts)."""

    lo: Floats
    hi: Floats
    starts: NDArray[np.int64]
    exact: Callable[[int, int], Pair]
    same: Callable[[NDArray[np.int64]], NDArray[np.bool_]]
    """Which of the given blocks have members that are byte for byte equal."""
    refine: Callable[[NDArray[np.int64]], tuple[Floats, Floats]] | None = None
    """Sharper ends for the given members, where these here are quick and coarse."""


def least_expectation(law: Law, utility: UtilityTable) -> Fraction | None:
    """τ, the least expected utility E(x,a) over the compared cells; None if no cell is compared."""
    grid = expectation_grid(law, utility)
    if not len(grid.lo):
        return None
    candidates = np.flatnonzero(grid.lo[:, 0] <= grid.hi[:, 0].min())
    best = None
    for i in _one_of_each(law, utility, candidates):
        value = grid.exact(i, 0)
        if best is None or value[0] * best[1] < best[0] * value[1]:
            best = value
    return Fraction(*best) if best else None


def compared_expectations(law: Law, utility: UtilityTable, *, within_context: bool) -> list[list[Fraction]]:
    """Expected utilities that are compared, exactly: by context, or all groups' means in one block.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> compared_expectations(law, Utility({"yes": 1}).on(law), within_context=True)
    [[Fraction(3, 4), Fraction(1, 2)]]
    """
    grid = expectation_grid(law, utility) if within_context else mean_grid(law, utility)
    return [[Fraction(*grid.exact(i, 0)) for i in range(a, b)] for a, b in pairwise(grid.starts.tolist())]


def cell_expectation(law: Law, utility: UtilityTable, cell: int) -> Pair:
    """E(x,a) of a cell as an exact, not necessarily reduced, pair."""
    row = law.row(cell)
    top = sum(w * g for w, g in zip(row, utility.row(cell), strict=True))
    return top, sum(row) * utility.scale


def _refuse_negative(utility: UtilityTable) -> None:
    if utility.signed:
        raise InputError("ratios depend on the origin of the utility, which is negative for some decision; measure differences instead")


def expectation_grid(law: Law, utility: UtilityTable) -> Grid:
    """E(x,a) of the compared cells, for a utility of at least 0."""
    _refuse_negative(utility)
    cells = np.flatnonzero(law.compared)
    everything = len(cells) == len(law.weights)
    weights = law.weights if everything else law.weights[cells]
    values = utility.values if utility.by_decision or everything else utility.values[cells]
    totals = law.float_sums if law.floating else law.totals
    sums = totals if everything else totals[cells]
    factors = _unit_floats(values) if law.floating else values
    lo, hi = _expectation_enclosure(weights, sums, factors)
    starts = block_starts(law, cells)
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
        equal = equal_blocks(weights, starts, blocks)
        return equal if values.ndim == 1 else equal & equal_blocks(values, starts, blocks)

    def refine(members: NDArray[np.int64]) -> tuple[Floats, Floats]:
        some = slice(None) if len(members) == len(cells) else members
        low, high = _expectation_enclosure(weights[some], sums[some], factors if factors.ndim == 1 else factors[some], fine=True)
        return low[:, None], high[:, None]

    return Grid(lo[:, None], hi[:, None], starts, exact, same, refine if weights.dtype == np.float32 else None)


def _row_key(row: NDArray[Any], extra: bytes) -> tuple[bytes, bytes]:
    return row.tobytes(), extra


def _expectation_enclosure(weights: NDArray[Any], sums: NDArray[Any], values: NDArray[Any], *, fine: bool = False) -> tuple[Floats, Floats]:
    """Float bounds on E·scale, all in one common unit; for float rows `values` are floats, and float32 is quick and coarse unless `fine`.

    Integers whose products fit are multiplied as they are; others are divided by their sum first, which is off by three roundings.

    For float rows the n products and sums of non-negative numbers carry a relative error of at most (2n+8)·u·1.01, and underflow adds
    at most 2·(n + Σw)·t to the numerator, with u = 2^-53 and t = 2^-1074 (float32: 2^-24 and 2^-149).
    """
    n = weights.shape[1]
    if weights.dtype.kind == "f":
        coarse = weights.dtype == np.float32 and not fine
        unit, tiny = (2.0**-24, 2.0**-149) if coarse else (UNIT, TINY)
        tops = products(weights, values.astype(np.float32) if coarse else values)
        middle = tops / sums
        relative = (2 * n + 12) * unit * 1.01
        absolute = 2 * (n + sums) * tiny / sums * 1.01 + TINY
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
    return _expectation_enclosure(quotients(weights, sums), np.ones(len(weights)), _unit_floats(values))


def _unit_floats(values: NDArray[Any]) -> Floats:
    """Non-negative integers divided by the greatest, each within a relative 2^-52."""
    top = max(int(values.max(initial=0)), 1)
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


def probability_grid(law: Law) -> Grid:
    """P(u|x,a) of the compared cells."""
    cells = np.flatnonzero(law.compared)
    weights = law.weights if len(cells) == len(law.weights) else law.weights[cells]
    starts = block_starts(law, cells)
    n = weights.shape[1]
    middle = law.float_rows(cells)
    relative = (n + 8) * UNIT * 1.01 if weights.dtype.kind == "f" else 8 * UNIT
    absolute = np.where((middle > 0) & (middle < 2.0**-960), 2 * TINY, 0.0)
    if weights.dtype.kind in "fO":
        absolute[(middle == 0) & np.asarray(weights > 0, dtype=np.bool_)] = 2 * TINY
    lo, hi = np.maximum(middle * (1 - relative) - absolute, 0.0), middle * (1 + relative) + absolute

    def exact(i: int, column: int) -> Pair:
        row = law.row(int(cells[i]))
        return row[column], sum(row)

    return Grid(lo, hi, starts, exact, lambda blocks: equal_blocks(weights, starts, blocks))


def mixed_grid(law: Law) -> Grid:
    """P(u|a) of the globally compared groups, a single block."""
    if law.population == "counts":
        return listed_grid([[(w, sum(row)) for w in row] for row in law.mixed_rows])
    middle, relative, absolute = law.mixed_floats
    lo, hi = np.maximum(middle * (1 - relative) - absolute, 0.0), middle * (1 + relative) + absolute

    def exact(i: int, column: int) -> Pair:
        row = law.mixed_row(i)
        return row[column], sum(row)

    return Grid(lo, hi, np.array([0, len(middle)], dtype=np.int64), exact, lambda blocks: np.zeros(len(blocks), dtype=bool))


def listed_grid(table: Sequence[Sequence[Pair]]) -> Grid:
    """A single block of few members, from exact values."""
    columns = len(table[0]) if table else 1
    lo, hi = (bound.reshape(len(table), columns) for bound in _enclose([pair for row in table for pair in row]))
    starts = np.array([0, len(table)] if table else [0], dtype=np.int64)
    return Grid(lo, hi, starts, lambda i, k: table[i][k], lambda blocks: np.zeros(len(blocks), dtype=bool))


def mean_grid(law: Law, utility: UtilityTable) -> Grid:
    """Ē(a) of the globally compared groups, for a utility of at least 0."""
    _refuse_negative(utility)
    apart = law.floating or law.weights.dtype == object or bool((law.totals != law.totals[0]).any())
    if apart and law.population != "counts" and law.global_groups:
        return _enclosed_mean_grid(law, utility)
    return listed_grid([[mean] for mean in _group_means(law, utility)])


def _enclosed_mean_grid(law: Law, utility: UtilityTable) -> Grid:
    """Ē(a) of rows that share no denominator: enclosed in floats, and exact only where it is asked for."""
    sums, values = (law.float_sums, _unit_floats(utility.values)) if law.floating else (law.totals, utility.values)
    lo, hi = _expectation_enclosure(law.weights, sums, values, fine=True)
    members = [law.cells_of(group) for group in law.global_groups]
    totals = [sum(law.cell_mass[i] for i in cells) for cells in members]
    shares = [np.array([law.cell_mass[i] / total for i in cells]) for cells, total in zip(members, totals, strict=True)]
    slack = [(len(cells) + 8) * UNIT for cells in members]
    low = [float(share @ lo[cells]) * (1 - s) for share, cells, s in zip(shares, members, slack, strict=True)]
    high = [float(share @ hi[cells]) * (1 + s) + len(cells) * TINY for share, cells, s in zip(shares, members, slack, strict=True)]
    low = [v if v > 2.0**-960 else 0.0 for v in low]
    means: dict[int, Pair] = {}

    def exact(i: int, _: int) -> Pair:
        if i not in means:
            rows, values = law.weights[members[i]], utility.values
            rows = dyadic_rows(rows) if law.floating else rows
            g = (values if values.ndim == 1 else values[members[i]]).astype(object)
            tops: dict[int, int] = {}
            for cell, e, d in zip(members[i], (rows * g).sum(axis=1).tolist(), rows.sum(axis=1).tolist(), strict=True):
                tops[d] = tops.get(d, 0) + law.cell_mass[cell] * e
            top, bottom = added([(e, d) for d, e in tops.items()])
            means[i] = top, bottom * totals[i] * utility.scale
        return means[i]

    starts = np.array([0, len(members)], dtype=np.int64)
    return Grid(np.array(low)[:, None], np.array(high)[:, None], starts, exact, lambda blocks: np.zeros(len(blocks), dtype=bool))


def _group_means(law: Law, utility: UtilityTable) -> list[Pair]:
    """Ē(a) of the globally compared groups of integer rows, exact."""
    if not law.global_groups:
        return []
    most = float(np.abs(utility.values).max()) if utility.values.dtype == np.int64 else np.inf
    if law.population == "counts" and law.weights.dtype == np.int64 and float(law.totals.sum(dtype=np.float64)) * max(most, 1.0) < 2.0**62:
        tops_of, bottoms_of = np.zeros((2, len(law.groups)), dtype=np.int64)
        values = law.weights @ utility.values if utility.by_decision else (law.weights * utility.values).sum(axis=1)
        np.add.at(tops_of, law.cell_group, values)
        np.add.at(bottoms_of, law.cell_group, law.totals)
        return [(int(tops_of[group]), int(bottoms_of[group]) * utility.scale) for group in law.global_groups]
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
