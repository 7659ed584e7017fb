"""Where the ends of a stream's product region are, in floats: for displays and searches, never for conclusions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import permutations
from math import ceil, floor, inf, log, log10
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.inference.betting import DIGITS, LOG_IDLE, ValueCounts, greatest_excluded
from fairaudit.inference.levels import PairLevels

POINTS = 400  # of the grid of means, evenly spread in the angle whose sine is the root of the mean: as precise near 0 and 1 as between

SLACK = 0.025  # of the logarithm of the wealth, which interpolation and the steps between knots may cost: a ratio within it has a ladder

ROUNDING = 4e-3  # of the same, which interpolation between points may cost alone

MAX_KNOTS = 2_000  # a proof beyond is longer than the table that it is about


class PairSearch:
    """Ends of the ratio over the pairs of means that the products of wealths leave, and ladders that could prove them.

    Parameters
    ----------
    cells : list of list of ValueCounts
        What was drawn, by blocks.
    levels : list of dict
        The level of each pair of a block.
    limits : pair of Fraction
        The range of the utility.
    """

    def __init__(self, cells: list[list[ValueCounts]], levels: PairLevels, limits: tuple[Fraction, Fraction]) -> None:
        self.levels, self.limits = levels, limits
        self.low, self.width = float(limits[0]), float(limits[1] - limits[0])
        self.curves = [
            [_Curves(cell, max(-log(float(v)) for k, v in by_pair.items() if i in k) - LOG_IDLE + 1) for i, cell in enumerate(block)]
            for block, by_pair in zip(cells, levels, strict=True)
        ]

    def upper(self) -> tuple[float, tuple[int, int, int] | None]:
        """Least r such that μ_i ≤ r·μ_j is proved for all pairs, at least 1, and the block, i and j that need it."""
        tried = []
        for b, curves in enumerate(self.curves):
            for i, j in permutations(range(len(curves)), 2):
                top, bottom = self._mean(curves[i].end), self._mean(curves[j].start)
                high, low = self._mean(curves[i].mean), self._mean(curves[j].mean)
                tried.append((-top / bottom if bottom > 0 else -inf, -high / low if low > 0 else -inf if high > 0 else -1.0, b, i, j))
        best, where = 1.0, None
        for most, _, b, i, j in sorted(tried):
            if -most <= best:
                break
            found = self._least(b, i, j)
            if found > best:
                best, where = found, (b, i, j)
        return best, where

    def lower(self) -> tuple[float, tuple[int, int, int] | None]:
        """Greatest proved R with μ_j ≥ R·μ_i, and the block, the higher j and the lower i."""
        tried = []
        for b, curves in enumerate(self.curves):
            for i, j in permutations(range(len(curves)), 2):
                low, high = self._mean(curves[i].mean), self._mean(curves[j].mean)
                if high > low and self._mean(curves[j].start) > 0:
                    tried.append((low / high, b, i, j))
        best, where = 1.0, None
        for least, b, i, j in sorted(tried):
            if least >= best:
                break
            if self._feasible(b, i, j, best):
                found = self._least(b, i, j)
                if found < best:
                    best, where = found, (b, j, i)
        return 1 / best, where

    def ladder(self, b: int, pairs: Sequence[tuple[int, int]], ratio: Fraction) -> list[Fraction] | None:
        """Knots that should prove μ_i ≤ ratio·μ_j for all of some pairs i, j of a block, or None if floats see none."""
        curves, r = self.curves[b], float(ratio)
        low, high = self.limits
        need = {(i, j): self._theta(b, i, j) + ROUNDING for i, j in pairs}
        start = max(self.low, min(self._mean(curves[j].above_inverse(need[i, j] - LOG_IDLE)) for i, j in pairs))
        if start <= 0:
            return None
        knots = [decimal_near(start, up=False)] if start > self.low else [low]
        if knots[0] <= 0:
            return None
        while len(knots) < MAX_KNOTS:
            reach = r * float(knots[-1])
            if knots[-1] >= high or ratio * knots[-1] >= high:
                break
            below = {i: float(curves[i].below(self._unit(np.array(reach)))) for i in {i for i, _ in pairs}}
            if all(below[i] + LOG_IDLE >= need[i, j] for i, j in pairs):
                break
            further = min(self._mean(curves[j].above_inverse(need[i, j] - below[i])) for i, j in pairs)
            knot = high if further >= float(high) else decimal_near(further, up=False, digits=10)
            if knot <= knots[-1]:
                return None
            knots.append(knot)
        else:
            return None
        return knots

    def _feasible(self, b: int, i: int, j: int, r: float) -> bool:
        """Whether μ_i ≤ r·μ_j is proved, in floats."""
        top, bottom = self.curves[b][i], self.curves[b][j]
        first, last = self._mean(bottom.start), min(self._mean(top.end), self.low + self.width) / r
        if first <= self.low and first > 0:
            first = self.low
        if first <= 0:
            return False
        if first >= last:
            return True
        q = np.concatenate([self._mean(bottom.grid), self._mean(top.grid) / r, [first, last]])
        q = q[(q >= first) & (q <= last)]
        total = top.below(self._unit(r * q)) + bottom.above(self._unit(q))
        return bool(total.min() >= self._theta(b, i, j) + SLACK)

    def _least(self, b: int, i: int, j: int) -> float:
        top, bottom = self.curves[b][i], self.curves[b][j]
        if self._mean(bottom.start) <= 0:
            return inf
        high = self._mean(top.end) / self._mean(bottom.start)
        low = max(self._mean(top.mean) / self._mean(bottom.mean), high * 1e-12)
        if not self._feasible(b, i, j, high):
            return inf
        while high > low * (1 + 1e-9):
            middle = float((low * high) ** 0.5)
            low, high = (low, middle) if self._feasible(b, i, j, middle) else (middle, high)
        return float(high)

    def _theta(self, block: int, i: int, j: int) -> float:
        return -log(float(self.levels[block][frozenset((i, j))]))

    def _mean(self, unit: Any) -> Any:
        return self.low + self.width * unit

    def _unit(self, mean: Any) -> Any:
        return np.clip((mean - self.low) / self.width, 0, 1) if self.width else np.zeros_like(mean)


class _Curves:
    """The logarithms of both wealths of a cell on a grid of means, in floats."""

    def __init__(self, drawn: ValueCounts, need: float) -> None:
        self.mean = float(drawn.mean)
        mirrored = ValueCounts({1 - x: n for x, n in drawn.counts.items()})
        self.start = greatest_excluded(drawn, need) if self.mean > 0 else 0.0
        self.end = 1 - greatest_excluded(mirrored, need) if self.mean < 1 else 1.0
        angles = np.linspace(np.arcsin(np.sqrt(self.start)), np.arcsin(np.sqrt(self.end)), POINTS)
        grid: Floats = np.unique(np.clip(np.sin(angles) ** 2, self.start, self.end))
        self.grid = grid
        self._above = np.minimum.accumulate(drawn.log_wealth(grid, "above"))
        self._below = np.maximum.accumulate(drawn.log_wealth(grid, "below"))

    def above(self, means: Floats) -> Floats:
        """Logarithm of the wealth that says the mean is above these; a lower bound outside the grid."""
        found = np.interp(means, self.grid, self._above)
        return np.where(means > self.grid[-1], LOG_IDLE, found)

    def below(self, means: Floats) -> Floats:
        """Logarithm of the wealth that says the mean is below these."""
        found = np.interp(means, self.grid, self._below)
        return np.where(means < self.grid[0], LOG_IDLE, found)

    def above_inverse(self, need: float) -> float:
        """The greatest mean at which `above` is at least `need`; the start of the grid if there is none."""
        return 1.0 if need <= LOG_IDLE else float(np.interp(need, self._above[::-1], self.grid[::-1]))


def decimal_near(value: float, *, up: bool, digits: int = DIGITS) -> Fraction:
    """A decimal of some digits on the stated side of a positive number."""
    scale = Fraction(10) ** (digits - 1 - floor(log10(value)))
    scaled = Fraction(value) * scale
    return Fraction(ceil(scaled) if up else floor(scaled)) / scale
