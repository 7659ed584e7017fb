"""T13 with floors by one k for each ordered pair of groups: R ≤ V where S(k) ≤ (V − k)·τ for some k from 0 to V.

Whatever the pair is, Σ T·p ≤ k·Σ T·q + S(k), and Σ T·q is at least the floor τ of the lower group. The least such V is a bound; it is
the greatest ratio of all policies that keep this one floor, if k = 0 is not the best k. k + S(k)/τ is convex and piecewise linear in k.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from math import inf, lcm, nextafter

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.privacy.columns import Column
from fairaudit.theorems.t13_exact import Points, best_sums, greatest_above
from fairaudit.theorems.t13_problems import Problems
from fairaudit.theorems.t13_search import MAX_VALUE, Search, below
from fairaudit.theorems.t13_tables import Ints, Tables


def least_bound(columns: Sequence[Column], blocks: Sequence[Points], floor: Fraction) -> tuple[Extended, Fraction | None]:
    """The least V ≥ 1 that some k proves, and k; None where that is V itself.

    Source: T13.

    Parameters
    ----------
    columns : sequence of (int, int)
        Released values by the likelihood ratio of the two groups, falling.
    blocks : sequence of Points
        For every released context what decisions are worth.
    floor : Fraction
        Of Σ q, in the unit of the sums.

    Examples
    --------
    >>> least_bound([(7, 3), (3, 7)], [((1, 1), (0, 0))], Fraction(5))
    (Fraction(11, 7), Fraction(3, 7))
    >>> least_bound([(2, 1), (1, 2)], [((1, 1), (0, 0))], Fraction(0))
    (Fraction(2, 1), None)
    """
    left = best_sums(columns, blocks, ZERO)
    if floor > 0 and left[1] <= floor:
        return max(left[0] / floor, ONE), ZERO
    right = best_sums(columns, blocks, left[0] / floor) if floor > 0 else left
    while right[1] < floor <= left[1]:
        k = Fraction(left[0] - right[0], left[1] - right[1])
        top, low = best_sums(columns, blocks, k)
        if top - k * low == left[0] - k * left[1]:
            if top <= k * low:
                break
            return max(k + (top - k * low) / floor, ONE), k
        if low < floor:
            right = top, low
        else:
            left = top, low
    greatest = greatest_above(columns, blocks, ONE)
    return (ONE if greatest is None else greatest), None


class OneK:
    """Bounds of all pairs of a deployment by as few k as are needed.

    Floats say which k proves which pair, their error bounded; what they cannot decide is decided in integers.

    Parameters
    ----------
    problems : Problems
        The ordered pairs of groups.
    tables : Tables
        What decisions are worth, and floors.
    """

    def __init__(self, problems: Problems, tables: Tables) -> None:
        self._problems, self._tables = problems, tables
        self._search = Search(problems, tables)
        scaled = zip(tables.floors, tables.scales, tables.bottoms, strict=True)
        self._floors = np.array([below(floor * scale * bottom) for floor, scale, bottom in scaled])[problems.lower]
        self._tops = [Fraction(sum(map(max, blocks)), bottom) for blocks, bottom in zip(tables.blocks, tables.bottoms, strict=True)]
        self._bounds, self._by = np.full(len(problems), np.inf), np.full(len(problems), -1)
        self._tried: list[Fraction] = []
        self._exact: dict[tuple[int, tuple[Points, ...], Fraction], tuple[Extended, Fraction | None]] = {}
        self._needed: dict[int, int] = {}
        self._settled: Fraction | None = None
        self._totals = [sum(p for p, _ in columns) for columns in problems.laws.columns]

    def greatest(self) -> tuple[Extended, int | None]:
        """The greatest of the bounds, and a pair that has it; no pair if it is 1."""
        free = np.flatnonzero(np.array([floor == 0 for floor in self._tables.floors])[self._problems.lower])
        all_ = self._problems
        some = replace(all_, kind=all_.kind[free], higher=all_.higher[free], lower=all_.lower[free], rank=all_.rank[free])
        infinite = Search(some, self._tables).infinite() if len(free) else None
        if infinite is not None:
            return inf, int(free[infinite])
        value, first, _ = self._settle(ONE, raising=True)
        return value, first

    def exceeding(self, value: Fraction, most: int) -> list[int]:
        """The pairs whose bound is above a value; if there are too many, one more than `most` of them."""
        return self._settle(value, raising=False, most=most)[2]

    def bound(self, at: int) -> tuple[Extended, Fraction | None]:
        """The bound of a pair, and its k."""
        columns, blocks, floor = self._terms(at)
        key = int(self._problems.kind[at]), blocks, floor
        if key not in self._exact:
            self._exact[key] = least_bound(columns, blocks, floor)
        return self._exact[key]

    def multipliers(self, value: Fraction) -> tuple[Fraction, ...]:
        """The k that prove a value for all pairs whose bound is not above it, falling."""
        if value != self._settled:
            self._settle(value, raising=False, most=len(self._problems))
        places = {*self._by[self._bounds <= _low(value)].tolist(), *self._needed.values()}
        return tuple(sorted((k for k in (self._tried[place] for place in places) if k < value), reverse=True))

    def _settle(self, value: Fraction, *, raising: bool, most: int = 0) -> tuple[Fraction, int | None, list[int]]:
        """Raise a value until it is a bound of all pairs, or list those of which it is none."""
        left, sums = np.flatnonzero(self._bounds > _low(value)), np.zeros(0)
        first, above = None, list[int]()
        self._needed, self._settled = {}, None
        for level in self._search.levels:
            last = level == self._search.levels[-1]
            for place in range(len(self._tried)):
                self._try(left, place, level)
                left = left[self._bounds[left] > _low(value)]
            left, sums = self._open(left, value, level)
            if last:
                left, sums = self._beyond_zero(left, sums, value)
            searching = True
            while len(left):
                at = self._worst(left, sums, value) if searching else int(left[0])
                count, others = len(left), left != at
                if last and self._known(at, value):
                    left, sums, searching = left[others], sums[others], False
                    continue
                bound, k = self.bound(at)
                if isinstance(bound, Fraction) and bound <= value:
                    if k is not None and last:
                        left, sums = left[others], sums[others]
                        self._needed[at] = len(self._tried)
                elif raising and isinstance(bound, Fraction):
                    value, first = bound, at
                    left, sums = self._open(left, value, level)
                else:
                    above.append(at)
                    if len(above) > most:
                        return value, first, above
                    left, sums = left[others], sums[others]
                if k is not None and k not in self._tried:
                    self._tried.append(k)
                    self._try(left, len(self._tried) - 1, level)
                kept = self._bounds[left] > _low(value)
                left, sums = left[kept], sums[kept]
                if not last and len(left) == count:
                    break
        self._settled = value
        return value, first, above

    def _open(self, left: Ints, value: Fraction, level: int) -> tuple[Ints, Floats]:
        """The pairs that neither V nor any k is seen to prove, and S(V) of each."""
        return self._search.possible(left[self._bounds[left] > _low(value)], value, level)

    def _worst(self, left: Ints, sums: Floats, value: Fraction) -> int:
        """The pair that promises the greatest bound."""
        bounds = self._bounds[left]
        loose = np.isinf(bounds)
        if not loose.any():
            return int(left[np.argmax(bounds)])
        found = self._search.promising(left[loose], sums[loose], value)
        return int(left[loose][np.argmax(sums[loose])]) if found is None else found

    def _known(self, at: int, value: Fraction) -> bool:
        """Whether V, or a k that was tried, proves a value for a pair; take note of k."""
        columns, blocks, floor = self._terms(at)
        for place, k in [(-1, value), *enumerate(self._tried)]:
            if k <= value:
                top, low = best_sums(columns, blocks, k)
                if top - k * low <= (value - k) * floor:
                    if place >= 0:
                        self._needed[at] = place
                    return True
        return False

    def _try(self, left: Ints, place: int, level: int) -> None:
        """See what the k at a place proves for pairs: k + S(k)/τ, off upwards."""
        k = self._tried[place]
        if k > MAX_VALUE:
            return
        sums, slack = self._search.sums(left, k, level)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            gained = np.maximum(sums + slack, 0.0) / self._floors[left]
            bounds = (nextafter(float(k), inf) + gained) * (1 + 16 * UNIT)
        bounds[self._floors[left] == 0] = np.inf
        better = bounds < self._bounds[left]
        self._bounds[left[better]], self._by[left[better]] = bounds[better], place

    def _beyond_zero(self, left: Ints, sums: Floats, value: Fraction) -> tuple[Ints, Floats]:
        """The pairs that k = 0 does not prove, decided exactly: often many are alike, for S(0) is what the higher group can have."""
        if ZERO not in self._tried:
            return left, sums
        kept = np.array([self._tops[high] > value * self._tables.floors[low] for high, low in self._pairs(left)], dtype=bool)
        self._needed |= dict.fromkeys(left[~kept].tolist(), self._tried.index(ZERO))
        return left[kept], sums[kept]

    def _pairs(self, left: Ints) -> Iterator[tuple[int, int]]:
        return zip(self._problems.higher[left].tolist(), self._problems.lower[left].tolist(), strict=True)

    def _terms(self, at: int) -> tuple[tuple[Column, ...], tuple[Points, ...], Fraction]:
        """Likelihood ratios and envelopes of a pair, and its floor in their unit."""
        higher, lower = int(self._problems.higher[at]), int(self._problems.lower[at])
        kind = int(self._problems.kind[at])
        unit = self._totals[kind] * lcm(self._tables.bottoms[higher], self._tables.bottoms[lower])
        return self._problems.laws.columns[kind], tuple(self._tables.envelopes(higher, lower)), self._tables.floors[lower] * unit


def _low(value: Fraction) -> float:
    """A float that is not above a value, and not too large."""
    return below(min(value, Fraction(MAX_VALUE)))
