"""The greatest ratio over all ordered pairs of rows under one range and one floor (T3, T4), exactly."""

from __future__ import annotations

from fractions import Fraction
from math import gcd, inf

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.exact.extended import ONE
from fairaudit.worst.most_powerful import Best, Span, most_powerful, proved
from fairaudit.worst.rows import LOOKED_AT, ComparedRows, Indices
from fairaudit.worst.stick_bounds import StickBounds

FEW = 256
"""Pairs that are evaluated exactly rather than bounded: so many cost about as much as one pass in floats."""


class Sieve:
    """Finds the greatest ratio over all ordered pairs of a block, evaluating exactly only what could be it.

    A pair whose rigorous bound at some k stays below the best exact ratio is out, and that k proves so in the certificate.
    """

    def __init__(self, rows: ComparedRows, span: Span) -> None:
        self.rows, self.span = rows, span
        self.bounds = StickBounds(rows, span)
        self.used: list[Fraction] = []
        self.cache: dict[tuple[tuple[int, ...], tuple[int, ...]], Best] = {}
        self.best: Best | None = None
        self.rest: tuple[Indices, Indices] = (np.zeros(0, np.int64), np.zeros(0, np.int64))

    @property
    def level(self) -> float:
        """A float that is surely at most the best exact ratio."""
        if self.best is None:
            return 1.0
        return float(min(self.best.ratio, Fraction(10) ** 300)) * (1 - 4 * UNIT)

    def run(self) -> Best:
        """The exact answer for the pair of the greatest ratio."""
        slope, _, _ = self.span.scaled
        first = (int(self.rows.starts[0]), int(self.rows.starts[0]) + 1)
        self.best = Best(ONE, ONE, [self.span.gamma] * self.rows.floats.shape[1], first)
        if slope == inf or sum(size * (size - 1) for size in np.diff(self.rows.starts).tolist()) <= FEW // 4:
            self._everything()
            return self.best
        self._seed()
        for _ in range(2):
            # The bound at k is at least k, so a k at the ratio itself would rule out nobody.
            level = self.level
            k = min(float(self.best.k), max(level - 4 * float(self.bounds.error(level)), 0.0))
            highs, lows, bounds = self._above(k)
            self._note(k)
            self.rest = (highs, lows)
            if len(highs) <= LOOKED_AT:
                break
            before = self.best
            self._try(highs, lows, bounds)
            if self.best is before:
                break
        self._finish()
        return self.best

    def _note(self, k: float) -> None:
        exact = Fraction(k)
        if exact not in self.used:
            self.used.append(exact)

    def _seed(self) -> None:
        """Look at the pairs that are farthest apart in total variation."""
        tops: list[tuple[Floats, Indices, Indices]] = []
        for base, size, bounds in self.bounds.everywhere(1.0):
            flat = bounds.reshape(len(base), -1)
            chosen = flat.argmax(axis=1)
            tops.append((flat[np.arange(len(base)), chosen], base + chosen // size, base + chosen % size))
        values, highs, lows = (np.concatenate(part) for part in zip(*tops, strict=True))
        keep = values > 0
        self._try(highs[keep], lows[keep], values[keep])

    def _above(self, k: float) -> tuple[Indices, Indices, Floats]:
        """Ordered pairs whose bound at k exceeds the best ratio."""
        found: list[tuple[Indices, Indices, Floats]] = []
        level = self.level
        for base, size, bounds in self.bounds.everywhere(k):
            where = np.flatnonzero(bounds > level)
            block, pair = where // (size * size), where % (size * size)
            found.append((base[block] + pair // size, base[block] + pair % size, bounds.ravel()[where]))
        highs, lows, values = (np.concatenate(part) for part in zip(*found, strict=True))
        return highs, lows, values

    def _try(self, highs: Indices, lows: Indices, bounds: Floats) -> None:
        """Evaluate the most promising pairs in floats, and the best of them exactly."""
        if not len(highs):
            return
        most = np.argsort(-bounds)[:LOOKED_AT]
        values, _ = self.bounds.curve(highs[most], lows[most])
        at = most[int(np.argmax(values))]
        self._evaluate(int(highs[at]), int(lows[at]))

    def _finish(self) -> None:
        """Evaluate exactly every pair that could still be better."""
        highs, lows = self.rest
        if not len(highs):
            return
        values, ks = self.bounds.curve(highs, lows)
        at = int(np.argmax(values))
        self._evaluate(int(highs[at]), int(lows[at]))
        bounds = self.bounds.of_pairs(highs, lows, ks)
        for i in np.flatnonzero(bounds > self.level).tolist():
            if bounds[i] > self.level:
                self._evaluate(int(highs[i]), int(lows[i]))

    def _everything(self) -> None:
        """Evaluate all pairs exactly, where floats do not reach."""
        highs: list[int] = []
        lows: list[int] = []
        for start, end in zip(self.rows.starts[:-1].tolist(), self.rows.starts[1:].tolist(), strict=True):
            for i in range(start, end):
                for j in range(start, end):
                    if i != j:
                        highs.append(i)
                        lows.append(j)
                        self._evaluate(i, j)
        self.rest = (np.array(highs), np.array(lows))

    def _exactly(self, high: int, low: int) -> Best:
        keys = []
        for member in (high, low):
            row = self.rows.exact(member)
            common = gcd(*row)
            keys.append(tuple(v // common for v in row))
        key = (keys[0], keys[1])
        if key not in self.cache:
            self.cache[key] = most_powerful(self.rows, (high, low), self.span)
        return self.cache[key]

    def _evaluate(self, high: int, low: int) -> None:
        found = self._exactly(high, low)
        if self.best is None or found.ratio > self.best.ratio:
            self.best = Best(found.ratio, found.k, found.values, (high, low))

    def multipliers(self) -> list[Fraction]:
        """Return k such that each ordered pair is proved by one of them."""
        assert self.best is not None  # noqa: S101 - run comes first
        span, level = self.span, self.level
        listed = list(self.used)
        highs, lows = self.rest
        candidates = [self.best.k]
        exactly = self.span.scaled[0] == inf
        while len(highs):
            k = candidates.pop() if candidates else self._exactly(int(highs[0]), int(lows[0])).k
            covered = np.zeros(len(highs), dtype=bool)
            if len(highs) > FEW and not exactly:
                value = float(k)
                covered = self.bounds.of_pairs(highs, lows, np.full(len(highs), value)) <= level
                if value != k and covered.any():
                    listed.append(Fraction(value))
            for i in np.flatnonzero(~covered)[: len(highs) if exactly else FEW].tolist():
                covered[i] = proved(self.rows, (int(highs[i]), int(lows[i])), k, span, self.best.ratio)
            listed.append(k)
            highs, lows = highs[~covered], lows[~covered]
        return list(dict.fromkeys(listed)) or [ONE]
