"""The product region of a stream, for cells that are a martingale together.

Two cells are compared by the product of the wealth against one mean and the wealth against the other, again a supermartingale, so that
all pairs of means whose product reaches 1/β are excluded. The proofs are in docs/certificate-monitor.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise, permutations
from math import ceil, floor, inf, log, log10
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.inference.betting import DIGITS, IDLE, LOG_IDLE, Tally, greatest_excluded, wealth, wealth_reaches
from fairaudit.inference.interval import Places, evidence_text
from fairaudit.inference.levels import pair_levels
from fairaudit.inference.rounding import Number, number_below

POINTS = 400

SLACK = 0.025

ROUNDING = 4e-3

MAX_KNOTS = 2_000


class StreamProduct:
    """Products of the wealths of two cells: narrower, for cells that are a martingale together."""

    places: Places = (None, None)

    def __init__(
        self, cells: list[list[Tally]], ranks: list[list[int]], expected: int, limits: tuple[Fraction, Fraction], alpha: Fraction
    ) -> None:
        self.cells, self.limits = cells, limits
        self.levels = pair_levels(ranks, expected, alpha)
        self.low, self.width = float(limits[0]), float(limits[1] - limits[0])
        self.curves = [
            [_Curves(cell, max(-log(float(v)) for k, v in levels.items() if i in k) - LOG_IDLE + 1) for i, cell in enumerate(block)]
            for block, levels in zip(cells, self.levels, strict=True)
        ]

    def estimate(self) -> tuple[Fraction, Fraction | float]:
        lower, pair = self._lower()
        upper, outer = self._upper()
        self.places = pair, outer
        return Fraction(lower), Fraction(upper) if upper < inf else inf

    def places_of(self, evidence: Mapping[str, Any]) -> Places:
        """Where the pairs behind both ends are that a certificate stores."""
        return None if evidence["lower"] is None else evidence["lower"]["pair"], self._upper()[1]

    def _theta(self, block: int, i: int, j: int) -> float:
        return -log(float(self.levels[block][frozenset((i, j))]))

    def _mean(self, unit: Any) -> Any:
        return self.low + self.width * unit

    def _unit(self, mean: Any) -> Any:
        return np.clip((mean - self.low) / self.width, 0, 1) if self.width else np.zeros_like(mean)

    def _upper(self) -> tuple[float, tuple[int, int, int] | None]:
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

    def _lower(self) -> tuple[float, tuple[int, int, int] | None]:
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

    def prove(self) -> tuple[Fraction, Fraction | float, dict[str, Any]]:
        upper, ladders, outer = self._prove_upper()
        lower, proof = self._prove_lower()
        self.places = None if proof is None else proof["pair"], outer
        return lower, upper, {"upper": ladders, "lower": proof}

    def _prove_upper(self) -> tuple[Fraction | float, list[list[str]] | None, tuple[int, int, int] | None]:
        ratio, where = self._upper()
        for attempt in range(8):
            if ratio == inf:
                break
            exact = max(Fraction(1), _rounded(ratio, up=True))
            ladders = []
            for b, curves in enumerate(self.curves):
                every = range(len(curves))
                ladder = self._ladder(b, every, every, exact)
                if ladder is None:
                    break
                ladders.append([evidence_text(knot) for knot in ladder])
            else:
                return exact, ladders, where
            ratio *= 1 + 0.002 * 2**attempt
        return inf, None, where

    def _prove_lower(self) -> tuple[Fraction, dict[str, Any] | None]:
        ratio, where = self._lower()
        for attempt in range(8):
            exact = _rounded(ratio, up=False)
            if where is None or exact <= 1:
                break
            b, higher, lower = where
            ladder = self._ladder(b, [lower], [higher], 1 / exact)
            if ladder is not None:
                return exact, {"pair": [b, higher, lower], "knots": [evidence_text(knot) for knot in ladder]}
            ratio /= 1 + 0.002 * 2**attempt
        return Fraction(1), None

    def _ladder(self, b: int, tops: Sequence[int], bottoms: Sequence[int], ratio: Fraction) -> list[Fraction] | None:
        """Knots that prove μ_i ≤ ratio·μ_j for all different tops i and bottoms j, or None; found in floats, proved in integers."""
        curves, r = self.curves[b], float(ratio)
        low, high = self.limits
        pairs = [(i, j) for i in tops for j in bottoms if i != j]
        need = {(i, j): self._theta(b, i, j) + ROUNDING for i, j in pairs}
        start = max(self.low, min(self._mean(curves[j].above_inverse(need[i, j] - LOG_IDLE)) for i, j in pairs))
        if start <= 0:
            return None
        knots = [_rounded(start, up=False)] if start > self.low else [low]
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
            knot = high if further >= float(high) else _rounded(further, up=False, digits=10)
            if knot <= knots[-1]:
                return None
            knots.append(knot)
        else:
            return None
        return knots if self._holds(b, pairs, knots, ratio) else None

    def _holds(self, b: int, pairs: Sequence[tuple[int, int]], knots: Sequence[Fraction], ratio: Fraction) -> bool:
        low, high = self.limits
        idle = number_below(IDLE)
        levels = self.levels[b]

        def below(i: int, mean: Fraction) -> Number | None:
            """Wealth of a top against a mean; None if its mean cannot be so great."""
            return None if mean >= high else idle if mean <= low else wealth(self.cells[b][i], (mean - low) / (high - low), "below")

        def above(j: int, mean: Fraction) -> Number:
            return idle if mean <= low else wealth(self.cells[b][j], (mean - low) / (high - low), "above")

        tops, bottoms = sorted({i for i, _ in pairs}), sorted({j for _, j in pairs})
        before: list[tuple[Fraction | None, Fraction | None]] = [(None, knots[0])]
        before += pairwise(knots)
        before.append((knots[-1], None))
        for p, q in before:
            if (p is None and q is not None and q <= low) or (q is None and p is not None and p >= high):
                continue
            ups = {i: idle if p is None else below(i, ratio * p) for i in tops}
            downs = {j: idle if q is None else above(j, q) for j in bottoms}
            for i, j in pairs:
                one = ups[i]
                if one is not None and not wealth_reaches([one, downs[j]], levels[frozenset((i, j))]):
                    return False
        return True


class _Curves:
    """The logarithms of both wealths of a cell on a grid of means, in floats."""

    def __init__(self, tally: Tally, need: float) -> None:
        self.mean = float(tally.mean)
        mirrored = Tally({1 - x: n for x, n in tally.counts.items()})
        self.start = greatest_excluded(tally, need) if self.mean > 0 else 0.0
        self.end = 1 - greatest_excluded(mirrored, need) if self.mean < 1 else 1.0
        angles = np.linspace(np.arcsin(np.sqrt(self.start)), np.arcsin(np.sqrt(self.end)), POINTS)
        grid: Floats = np.unique(np.clip(np.sin(angles) ** 2, self.start, self.end))
        self.grid = grid
        self._above = np.minimum.accumulate(tally.log_wealth(grid, "above"))
        self._below = np.maximum.accumulate(tally.log_wealth(grid, "below"))

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


def _rounded(value: float, *, up: bool, digits: int = DIGITS) -> Fraction:
    """A decimal of some digits on the stated side of a positive number."""
    scale = Fraction(10) ** (digits - 1 - floor(log10(value)))
    scaled = Fraction(value) * scale
    return Fraction(ceil(scaled) if up else floor(scaled)) / scale
