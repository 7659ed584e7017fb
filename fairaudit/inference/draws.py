"""The draws behind a law of counts, as cells: rows, or the means over the rows of sampling units, with the range of a utility."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import lcm
from operator import mul
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import option_value
from fairaudit.inference.cells import Cell, Ends, Profiles, pooled_cell
from fairaudit.model.law import MAX_DRAWS, Law
from fairaudit.model.layout import Units
from fairaudit.model.utility import UtilityTable
from fairaudit.theorems.assumptions import OWN_RANGE, range_said


def whole_counts(law: Law, cell: int) -> list[int]:
    """How often each decision was drawn in a cell; weights that are no whole numbers are no draws."""
    if law.kind != "counts":
        raise InputError("probabilities carry no sample size; an interval needs counts, or a log")
    row: list[int] = law.weights[cell].tolist()
    if law.scale != 1:
        for u, w in zip(law.decisions, row, strict=True):
            if w % law.scale:
                where = {**law.context_label(int(law.cell_context[cell])), **law.group_label(int(law.cell_group[cell]))}
                raise InputError(
                    f"the count of {shown(u)} at {where} is not whole; an interval needs whole counts, because a weighted count carries "
                    "no sample size"
                )
        row = [w // law.scale for w in row]
    if sum(row) > MAX_DRAWS:
        raise InputError(f"{shown(str(sum(row)))} decisions in one cell are not accepted as draws; an interval needs at most 10^18")
    return row


def range_assumption(utility: UtilityTable, limits: Ends | None) -> str:
    """What the reader must accept of the range of a draw: the declared one, else that of all decisions, or of each cell its own."""
    whole = min(Fraction(0), utility.m), max(Fraction(0), utility.gamma)
    return OWN_RANGE if limits is None and not utility.by_decision else range_said(*(limits or whole))


class SampledUtility:
    """The utilities that were drawn, as cells.

    Parameters
    ----------
    utility : UtilityTable
        The utility on a law of counts.
    limits : pair of Fraction or None
        Its declared range.
    """

    def __init__(self, utility: UtilityTable, limits: Ends | None) -> None:
        self.utility = utility
        self.declared = (Fraction(0), utility.gamma) if limits is None and utility.given is not None else limits
        self.common = scaled_values(_values(utility, 0), self.declared) if utility.by_decision and utility.given is None else None

    def cells(self, chosen: NDArray[np.bool_]) -> list[Cell]:
        """The cells of a law, those that are chosen."""
        law, units = self.utility.law, self.utility.law.units
        at = np.flatnonzero(chosen)
        places = zip(law.cell_context[at].tolist(), law.cell_group[at].tolist(), strict=True)
        labels = [(law.contexts[x], law.groups[a]) for x, a in places]
        if self.common and not (units and units.repeated) and _summable(law, self.common):
            return self._summed(law.weights[at], labels)
        return [self._cell(i, label) for i, label in zip(at.tolist(), labels, strict=True)]

    def pooled(self, groups: Sequence[int]) -> list[Cell]:
        """A cell for each group, of its rows in all contexts."""
        law = self.utility.law
        labels = [(law.groups[a],) for a in groups]
        if self.common and _summable(law, self.common, over_contexts=True):
            sums = np.zeros((len(law.groups), law.weights.shape[1]), dtype=np.int64)
            np.add.at(sums, law.cell_group, law.weights)
            return self._summed(sums[list(groups)], labels)
        cells = self.cells(np.ones(len(law.weights), dtype=np.bool_))
        return [
            pooled_cell([cells[i] for i in np.flatnonzero(law.cell_group == a).tolist()], label)
            for a, label in zip(groups, labels, strict=True)
        ]

    def tallies(self, chosen: NDArray[np.bool_]) -> list[dict[Fraction, int]]:
        """How often each value was drawn in the cells that are chosen, if ever; of sampling units each mean."""
        return [self._tally(i) for i in np.flatnonzero(chosen).tolist()]

    def pooled_tallies(self, groups: Sequence[int]) -> list[dict[Fraction, int]]:
        """The same for each group, of its rows in all contexts."""
        found: dict[int, Counter[Fraction]] = {a: Counter() for a in groups}
        for i, a in enumerate(self.utility.law.cell_group.tolist()):
            if a in found:
                found[a].update(self._tally(i))
        return [dict(found[a]) for a in groups]

    def _tally(self, index: int) -> dict[Fraction, int]:
        law, found = self.utility.law, Counter[Fraction]()
        values = _values(self.utility, index)
        if law.units and law.units.repeated:
            for n, rows in law.units.profiles[index]:
                found[_unit_mean(rows, values)] += n
        else:
            for n, value in zip(whole_counts(law, index), values, strict=True):
                found[value] += n
        return dict(found)

    def _summed(self, weights: NDArray[np.int64], labels: Sequence[tuple[Any, ...]]) -> list[Cell]:
        values = self.common
        assert values is not None  # noqa: S101
        bottom, low, high, binary = values.bottom, values.low, values.high, values.binary
        sums = (weights @ np.array([[1, v, v * v] for v in values.whole])).tolist()
        totals = {total: Fraction(total, bottom) for total in {total for _, total, _ in sums}}
        squares = {square: Fraction(square, bottom * bottom) for square in {square for _, _, square in sums}}
        return [Cell(n, totals[t], squares[s], low, high, binary, label) for (n, t, s), label in zip(sums, labels, strict=True)]

    def _cell(self, index: int, label: tuple[Any, ...]) -> Cell:
        row = whole_counts(self.utility.law, index)
        values = self.common or scaled_values(_values(self.utility, index), self.declared)
        cell = sampled_cell(row, values, label)
        units = self.utility.law.units
        if units and units.repeated:
            cell = _by_unit(cell, units.profiles[index], values.values)
        return cell


def unit_profiles(utility: UtilityTable) -> tuple[Profiles, ...]:
    """What the sampling units got in the groups of each context that is compared: the mean over their rows, None where they were not seen.

    Empty if no unit was seen in two groups of a context.
    """
    law = utility.law
    if law.units is None or not law.units.together:
        return ()
    shared = _values(utility, 0) if utility.by_decision and utility.given is None else None
    found: list[Profiles] = []
    for start, end in pairwise(law.starts.tolist()):
        if end - start < 2:
            continue
        means: list[list[Fraction]] = []
        for cell in range(start, end):
            values = shared or _values(utility, cell)
            means.append([_unit_mean(rows, values) for _, rows in law.units.profiles[cell]])
        profiles: dict[tuple[Fraction | None, ...], int] = {}
        for n, positions in law.units.together[int(law.cell_context[start])]:
            got = tuple(None if k < 0 else own[k] for k, own in zip(positions, means, strict=True))
            profiles[got] = profiles.get(got, 0) + n
        found.append(profiles)
    return tuple(found)


def _summable(law: Law, values: _Scaled, *, over_contexts: bool = False) -> bool:
    """Whether sums over the draws of a cell, or of all, fit into 64 bits with their squares, and no value is outside the range."""
    if law.kind != "counts" or law.scale != 1 or law.weights.dtype != np.int64 or values.outside:
        return False
    most = 2 * float(law.weights.sum(dtype=np.float64)) if over_contexts else int(law.weights.max()) * law.weights.shape[1]
    return bool(most <= MAX_DRAWS and int(most) * max(1, *(v * v for v in values.whole)) < 2**63)


def declared_range(limits: tuple[Any, Any]) -> Ends:
    """Read the declared range of a utility."""
    low, high = (Fraction(*option_value(v)) for v in limits)
    if low > high:
        raise InputError(f"a utility between {low} and {high} is not accepted; the lower limit comes first")
    return low, high


def _values(utility: UtilityTable, cell: int) -> list[Fraction]:
    """Values of g in a cell; one that was not given (nothing was drawn there) counts as the greatest."""
    row = [Fraction(v, utility.scale) for v in utility.row(cell)]
    if utility.given is None:
        return row
    return [v if g else utility.gamma for v, g in zip(row, utility.given[cell].tolist(), strict=True)]


@dataclass(frozen=True)
class _Scaled:
    """Values of g in a cell, also as integers over one denominator; their range, which lie outside it, whether they are its ends."""

    values: tuple[Fraction, ...]
    whole: tuple[int, ...]
    bottom: int
    low: Fraction
    high: Fraction
    outside: tuple[int, ...]
    binary: bool


def scaled_values(values: Sequence[Fraction], declared: Ends | None) -> _Scaled:
    """Lay out the values of g in a cell; without a declared range it goes from 0, or the least of them, to the greatest, or 0."""
    low, high = declared or (min(Fraction(0), *values), max(Fraction(0), *values))
    bottom = lcm(*(v.denominator for v in values))
    whole = tuple(v.numerator * (bottom // v.denominator) for v in values)
    outside = tuple(i for i, v in enumerate(values) if not low <= v <= high)
    # Where a range was declared, what could have been drawn is only known to lie in it; that two values were seen does not make them all.
    return _Scaled(tuple(values), whole, bottom, low, high, outside, declared is None and {*values} <= {low, high})


def sampled_cell(row: Sequence[int], values: _Scaled, label: tuple[Any, ...]) -> Cell:
    """A cell in which each value was drawn as often as the row says."""
    for i in values.outside:
        if row[i]:
            raise InputError(f"a utility of {values.values[i]} was drawn, outside the declared limits {values.low} and {values.high}")
    total = Fraction(sum(map(mul, row, values.whole)), values.bottom)
    squares = Fraction(sum(w * v * v for w, v in zip(row, values.whole, strict=True)), values.bottom**2)
    return Cell(sum(row), total, squares, values.low, values.high, values.binary, label)


def unit_columns(units: Units) -> str:
    """The columns of the sampling unit, for a sentence."""
    listed = ", ".join(map(shown, units.columns))
    return f"column{'s' if len(units.columns) > 1 else ''} {listed}"


def unit_notes(units: Units, cells: Sequence[Cell]) -> tuple[str, ...]:
    """How many draws the units are, and whether they make cells dependent."""
    drawn = f"{sum(cell.draws for cell in cells)} draws, one for each unit of {unit_columns(units)} in each cell"
    if not units.spanning:
        return (drawn,)
    return drawn, f"{units.spanning} of {units.total} units have rows in several cells, so cells are not independent"


def _unit_mean(rows: Sequence[int], values: Sequence[Fraction]) -> Fraction:
    """The mean over the rows of a unit in a cell."""
    return sum((w * v for w, v in zip(rows, values, strict=True)), Fraction(0)) / sum(rows)


def _by_unit(cell: Cell, profiles: Sequence[tuple[int, tuple[int, ...]]], values: Sequence[Fraction]) -> Cell:
    """The same cell with the mean over the rows of a unit as one draw."""
    draws, total, squares = 0, Fraction(0), Fraction(0)
    for n, rows in profiles:
        mean = _unit_mean(rows, values)
        draws, total, squares = draws + n, total + n * mean, squares + n * mean * mean
    return replace(cell, draws=draws, total=total, squares=squares, binary=False)
