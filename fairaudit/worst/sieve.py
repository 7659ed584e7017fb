"""The greatest ratio over all ordered pairs of rows under one range and one floor (T3, T4), exactly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, inf
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import HUGE, UNIT
from fairaudit.exact.extended import ONE, ZERO
from fairaudit.worst.rows import ENTRIES, LOOKED_AT, ComparedRows, Indices

FEW = 256


@dataclass(frozen=True)
class Span:
    """γ, m and the floor, exactly and in floats."""

    gamma: Fraction
    m: Fraction
    floor: Fraction

    @property
    def width(self) -> Fraction:
        return self.gamma - self.m

    @cached_property
    def start(self) -> Fraction:
        """Least E_Q φ for g = m + (γ − m)φ."""
        return (self.floor - self.m) / self.width

    @cached_property
    def scaled(self) -> tuple[float, float, float]:
        """(γ − m)/τ, m/τ and the start; the first infinite where floats do not reach."""
        if self.width > self.floor * 10**290 or 0 < self.start < Fraction(1, 10**290):
            return inf, 0.0, 0.0
        return float(self.width / self.floor), float(self.m / self.floor), float(self.start)


@dataclass(frozen=True)
class _Best:
    """The exact answer for an ordered pair of rows, the k that proves it, and the utility row that attains it."""

    ratio: Fraction
    k: Fraction
    values: list[Fraction]
    pair: tuple[int, int]


def _most_powerful(rows: ComparedRows, pair: tuple[int, int], span: Span) -> _Best:
    """T3 and T4 for one ordered pair: the greatest E_P g/E_Q g over m ≤ g ≤ γ with E_Q g at least the floor.

    With g = m + (γ − m)φ the ratio along the Neyman–Pearson curve is greatest where s = E_Q φ is least, or at a vertex.
    """
    p, q = rows.exact(pair[0]), rows.exact(pair[1])
    top, bottom = sum(p), sum(q)
    scale = gcd(top, bottom)
    up, down = bottom // scale, top // scale
    parts = [(v * up, w * down, j) for j, (v, w) in enumerate(zip(p, q, strict=True)) if v or w]
    whole = top * up  # both rows now sum to it
    infinite = [part for part in parts if not part[1]]
    finite = sorted((part for part in parts if part[1]), key=lambda part: Fraction(part[0], part[1]), reverse=True)
    start, width, m = span.start, span.width, span.m
    phi = {j: ONE for _, _, j in infinite}
    s, power = ZERO, Fraction(sum(v for v, _, _ in infinite), whole)

    def ratio(level: Fraction, value: Fraction) -> Fraction:
        return (m + width * value) / (m + width * level)

    position = 0
    while position < len(finite) and s + Fraction(finite[position][1], whole) <= start:
        v, w, j = finite[position]
        s, power, phi[j] = s + Fraction(w, whole), power + Fraction(v, whole), ONE
        position += 1
    if s < start:
        v, w, j = finite[position]
        share = (start - s) / Fraction(w, whole)
        s, power, phi[j] = start, power + share * Fraction(v, whole), share
    k = Fraction(finite[position][0], finite[position][1]) if position < len(finite) else ZERO
    best, chosen = ratio(s, power), dict(phi)
    while position < len(finite) and m:
        v, w, j = finite[position]
        if Fraction(v, w) <= best:
            break
        rest = 1 - phi.get(j, ZERO)
        s, power, phi[j] = s + rest * Fraction(w, whole), power + rest * Fraction(v, whole), ONE
        position += 1
        best, chosen = ratio(s, power), dict(phi)
        k = best
    return _Best(best, k, [m + width * chosen.get(j, ZERO) for j in range(len(p))], pair)


class Sieve:
    """Finds the greatest ratio over all ordered pairs of a block, evaluating exactly only what could be it.

    Every k bounds every pair, R ≤ k + max(0, (γ − m)·H_k − (k − 1)·m)/τ (T4), at the price of one pass; a pair whose bound with a rigorous
    error stays below the best exact ratio is out, and that k proves so in the certificate.
    """

    def __init__(self, rows: ComparedRows, span: Span) -> None:
        self.rows, self.span = rows, span
        self.used: list[Fraction] = []
        self.cache: dict[tuple[tuple[int, ...], tuple[int, ...]], _Best] = {}
        self.best: _Best | None = None
        self.rest: tuple[Indices, Indices] = (np.zeros(0, np.int64), np.zeros(0, np.int64))

    def error(self, k: Any) -> Any:
        """Bound on the float error of the bound at k."""
        slope, least, _ = self.span.scaled
        n = self.rows.floats.shape[1]
        return (slope + least + 1.0) * (1.0 + k) * (4 * n + 64) * UNIT

    @property
    def level(self) -> float:
        """A float that is surely at most the best exact ratio."""
        if self.best is None:
            return 1.0
        return float(min(self.best.ratio, Fraction(10) ** 300)) * (1 - 4 * UNIT)

    def at(self, k: Any, sticks: Floats) -> Floats:
        """Upper bounds of ratios, from float hockey sticks H_k."""
        slope, least, _ = self.span.scaled
        with np.errstate(over="ignore", invalid="ignore"):
            bound: Floats = k + np.maximum(slope * sticks - (k - 1.0) * least, 0.0) + self.error(k)
        return np.nan_to_num(bound, nan=np.inf, posinf=np.inf)

    def everywhere(self, k: float) -> Iterator[tuple[Indices, int, Floats]]:
        """Bounds at k of all ordered pairs, by blocks of one size: first rows of blocks, size, bounds (block, higher, lower)."""
        rows = self.rows
        sizes = np.diff(rows.starts)
        n = rows.floats.shape[1]
        ones = np.ones(n)
        for size in np.unique(sizes).tolist():
            every = rows.starts[:-1][sizes == size]
            step = max(1, 200_000 // (size * n))
            for begin in range(0, len(every), step):
                base = every[begin : begin + step]
                block = rows.floats[base[:, None] + np.arange(size)]
                scaled = block * k
                buffer = np.empty_like(block)
                sticks = np.empty((len(base), size, size))
                for i in range(size):
                    np.maximum(block[:, i : i + 1], scaled, out=buffer)
                    sticks[:, i] = buffer @ ones
                sticks -= k
                np.maximum(sticks, 0.0, out=sticks)
                bounds = self.at(k, sticks)
                bounds[:, np.arange(size), np.arange(size)] = 0.0
                if rows.stored is not None:
                    # Rows that agree in floats may still differ exactly.
                    alike = np.flatnonzero((block == block[:, :1]).all(axis=(1, 2)))
                    stored = rows.stored[base[alike][:, None] + np.arange(size)]
                    bounds[alike[(stored == stored[:, :1]).all(axis=(1, 2))]] = 0.0
                yield base, size, bounds

    def run(self) -> _Best:
        slope, _, _ = self.span.scaled
        first = (int(self.rows.starts[0]), int(self.rows.starts[0]) + 1)
        self.best = _Best(ONE, ONE, [self.span.gamma] * self.rows.floats.shape[1], first)
        if slope == inf or sum(size * (size - 1) for size in np.diff(self.rows.starts).tolist()) <= FEW // 4:
            self._everything()
            return self.best
        self._seed()
        for _ in range(2):
            # The bound at k is at least k, so a k at the ratio itself would rule out nobody.
            level = self.level
            k = min(float(self.best.k), max(level - 4 * float(self.error(level)), 0.0))
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
        for base, size, bounds in self.everywhere(1.0):
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
        for base, size, bounds in self.everywhere(k):
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
        values, _ = self._curve(highs[most], lows[most])
        at = most[int(np.argmax(values))]
        self._evaluate(int(highs[at]), int(lows[at]))

    def _curve(self, highs: Indices, lows: Indices) -> tuple[Floats, Floats]:
        """Ratios and multipliers of pairs by sorting, in floats, without an error bound."""
        slope, least, start = self.span.scaled
        ratios, ks = np.empty(len(highs)), np.empty(len(highs))
        step = max(1, ENTRIES // self.rows.floats.shape[1])
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            p, q = self.rows.floats[highs[part]], self.rows.floats[lows[part]]
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                quotient = np.nan_to_num(np.where(q > 0, p / q, np.where(p > 0, np.inf, -1.0)), nan=-1.0, posinf=np.inf)
            order = np.argsort(-quotient, axis=1)
            p, q = np.take_along_axis(p, order, 1), np.take_along_axis(q, order, 1)
            quotient = np.take_along_axis(quotient, order, 1)
            power, level = np.cumsum(p, axis=1), np.cumsum(q, axis=1)
            count = np.minimum((level <= start).sum(axis=1), level.shape[1] - 1)
            line = np.arange(len(p))
            slopes = np.clip(np.nan_to_num(quotient[line, count], posinf=0.0), 0.0, HUGE)
            before_s = np.where(count > 0, level[line, count - 1], 0.0)
            before_p = np.where(count > 0, power[line, count - 1], 0.0)
            with np.errstate(over="ignore", invalid="ignore"):
                value = least + slope * (before_p + np.nan_to_num(np.maximum(start - before_s, 0.0) * slopes))
            k = slopes
            if least > 0:
                after = np.where(level >= start, (least + slope * power) / (least + slope * level), 0.0)
                greatest = after.max(axis=1)
                k = np.where(greatest > value, greatest, k)
                value = np.maximum(value, greatest)
            ratios[part], ks[part] = value, k
        return ratios, ks

    def _pair_bounds(self, highs: Indices, lows: Indices, ks: Floats) -> Floats:
        """Rigorous float bounds of pairs, each at its own k."""
        bounds = np.empty(len(highs))
        step = max(1, ENTRIES // self.rows.floats.shape[1])
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            k = ks[part]
            sticks = np.maximum(self.rows.floats[highs[part]] - k[:, None] * self.rows.floats[lows[part]], 0.0).sum(axis=1)
            bounds[part] = self.at(k, sticks)
        return bounds

    def _finish(self) -> None:
        """Evaluate exactly every pair that could still be better."""
        highs, lows = self.rest
        if not len(highs):
            return
        values, ks = self._curve(highs, lows)
        at = int(np.argmax(values))
        self._evaluate(int(highs[at]), int(lows[at]))
        bounds = self._pair_bounds(highs, lows, ks)
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

    def _exactly(self, high: int, low: int) -> _Best:
        keys = []
        for member in (high, low):
            row = self.rows.exact(member)
            common = gcd(*row)
            keys.append(tuple(v // common for v in row))
        key = (keys[0], keys[1])
        if key not in self.cache:
            self.cache[key] = _most_powerful(self.rows, (high, low), self.span)
        return self.cache[key]

    def _evaluate(self, high: int, low: int) -> None:
        found = self._exactly(high, low)
        if self.best is None or found.ratio > self.best.ratio:
            self.best = _Best(found.ratio, found.k, found.values, (high, low))

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
                covered = self._pair_bounds(highs, lows, np.full(len(highs), value)) <= level
                if value != k and covered.any():
                    listed.append(Fraction(value))
            for i in np.flatnonzero(~covered)[: len(highs) if exactly else FEW].tolist():
                covered[i] = _proved(self.rows, (int(highs[i]), int(lows[i])), k, span, self.best.ratio)
            listed.append(k)
            highs, lows = highs[~covered], lows[~covered]
        return list(dict.fromkeys(listed)) or [ONE]


def _proved(rows: ComparedRows, pair: tuple[int, int], k: Fraction, span: Span, ratio: Fraction) -> bool:
    """Whether k proves the ratio for a pair, exactly."""
    p, q = rows.exact(pair[0]), rows.exact(pair[1])
    top, bottom = sum(p), sum(q)
    stick = Fraction(
        sum(max(0, v * bottom * k.denominator - k.numerator * w * top) for v, w in zip(p, q, strict=True)), top * bottom * k.denominator
    )
    return k * span.floor + max(ZERO, span.width * stick - (k - 1) * span.m) <= ratio * span.floor
