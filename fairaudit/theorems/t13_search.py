"""Which pairs of groups may attain the greatest ratio of T13: sums S(V) in float64, their error bounded, rule out the rest."""

from __future__ import annotations

from fractions import Fraction
from math import inf, nextafter

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.theorems.t13_problems import Problems
from fairaudit.theorems.t13_tables import Ints, Tables

CHUNK = 1 << 17  # entries of an array, a mebibyte, which stays in the cache of a core

TRIED = 1 << 14  # entries of the most promising pairs that are looked at whole for a greater ratio

MAX_VALUE = 1e200
"""Ratios beyond are left to integers, so that nothing overflows."""

TINY = 1e-300  # more than underflow can lose in a sum, for masses and utilities of at most 1

Bools = NDArray[np.bool_]


class Search:
    """The pairs of a deployment in floats.

    Parameters
    ----------
    problems : Problems
        The ordered pairs of groups.
    tables : Tables
        What decisions are worth.
    """

    def __init__(self, problems: Problems, tables: Tables) -> None:
        self._problems, self._tables = problems, tables
        self._laws = problems.laws.levels
        values = np.array(
            [
                [[v * scale.numerator / scale.denominator for v in block] for block in blocks]
                for blocks, scale in zip(tables.blocks, tables.scales, strict=True)
            ]
        )
        self._values = np.ascontiguousarray(np.moveaxis(values, 2, 0))  # decisions, tables, blocks
        self._greatest = self._values.max(axis=0).sum(axis=1)

    def infinite(self) -> int | None:
        """The first pair for which some policy gives the second group nothing and the first something; decided exactly."""
        zero: Bools = np.array([[[v == 0 for v in block] for block in blocks] for blocks in self._tables.blocks])
        nothing: Bools = np.logical_and.reduce(np.logical_or.reduce(zero, axis=2), axis=1)
        something: Bools = ~np.logical_and.reduce(zero, axis=(1, 2))
        lost = np.array([columns[0][1] == 0 for columns in self._problems.laws.columns])
        shared = np.array([columns[-1][1] > 0 and any(p and q for p, q in columns) for columns in self._problems.laws.columns])
        kind, higher, lower = self._problems.kind, self._problems.higher, self._problems.lower
        found = nothing[lower] & lost[kind] & something[higher]
        open_ = np.flatnonzero(nothing[lower] & ~found & shared[kind])
        step = max(1, CHUNK // (zero.shape[1] * zero.shape[2]))
        for start in range(0, len(open_), step):
            some = open_[start : start + step]
            found[some] = np.logical_or.reduce(zero[lower[some]] & ~zero[higher[some]], axis=(1, 2))
        at = np.flatnonzero(found)
        return int(at[0]) if len(at) else None

    def possible(self, at: Ints, value: Fraction, level: int) -> tuple[Ints, Floats]:
        """Those of the given pairs that may attain at least a value, as seen at a level, and S of each at the value, off upwards."""
        if value > MAX_VALUE:
            return at, np.zeros(len(at))
        sums, slack = self.sums(at, value, level)
        kept = sums >= -slack
        return at[kept], sums[kept]

    @property
    def levels(self) -> range:
        """How closely pairs are looked at, the last time without any loss but that of float64."""
        return range(len(self._laws))

    def promising(self, at: Ints, sums: Floats, value: Fraction) -> int | None:
        """The pair with the greatest ratio of those with the greatest sums, by Newton's method; None if it is not above the value."""
        if not len(at) or value > MAX_VALUE:
            return None
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            gain = np.nan_to_num(sums / self._greatest[self._problems.lower[at]], nan=0.0, posinf=MAX_VALUE)
        count = max(8, TRIED // (self._values.shape[0] * self._values.shape[2]))
        tried = at[np.argpartition(-gain, count)[:count]] if count < len(at) else at
        found, v = None, float(value) * (1 + 1e-12)
        while v < MAX_VALUE:
            ratios = self._ratios(tried, v)
            best = int(np.argmax(ratios))
            if not ratios[best] > v:
                break
            found, v = int(tried[best]), float(ratios[best])
        return found

    def sums(self, at: Ints, value: Fraction, level: int) -> tuple[Floats, Floats]:
        """Σ max_u [P·A_u − v·Q·B_u] of pairs at a value, off upwards, and a bound on its error.

        Each of the n terms is off by less than 8 units of its two parts, all of which are at most γ_a + v·γ_a'; adding them is by n more.
        """
        law, v = self._laws[level], below(value)
        kind, higher, lower = self._problems.kind[at], self._problems.higher[at], self._problems.lower[at]
        decisions, _, blocks = self._values.shape
        result = np.empty(len(at))
        step = max(1, CHUNK // (decisions * blocks))
        for start in range(0, len(at), step):
            some = slice(start, start + step)
            tops, lows = self._values[:, higher[some]], self._values[:, lower[some]] * v
            p, q = law.p[kind[some]], law.q[kind[some]]
            total = np.zeros(tops.shape[1:])
            one, two = np.empty_like(tops), np.empty_like(tops)
            for j in range(int(law.sizes[kind[some]].max())):
                np.multiply(tops, p[:, j, None], out=one)
                np.multiply(lows, q[:, j, None], out=two)
                np.subtract(one, two, out=one)
                total += one.max(axis=0)
            result[some] = total.sum(axis=1)
        size = self._greatest[higher] + v * self._greatest[lower]
        slack = 1.01 * size * (law.error[kind] + (blocks * law.p.shape[1] + 40) * UNIT) + TINY * (1 + v)
        return result, slack

    def _ratios(self, at: Ints, v: float) -> Floats:
        """Ratios of the policies that maximise Σ p − v·Σ q."""
        law = self._laws[-1]
        kind = self._problems.kind[at]
        tops, lows = self._values[:, self._problems.higher[at]], self._values[:, self._problems.lower[at]]
        sums = np.zeros((2, *tops.shape[1:]))
        for p, q in zip(law.p[kind].T, law.q[kind].T, strict=True):
            one, two = tops * p[:, None], lows * q[:, None]
            best = np.argmax(one - v * two, axis=0)[None]
            sums += np.take_along_axis(one, best, 0)[0], np.take_along_axis(two, best, 0)[0]
        top, low = sums.sum(axis=2)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ratios: Floats = np.nan_to_num(top / low, nan=0.0, posinf=MAX_VALUE)
        return ratios


def below(value: Fraction) -> float:
    """A float that is not above a value."""
    near = float(value)
    return near if Fraction(near) <= value else nextafter(near, -inf)
