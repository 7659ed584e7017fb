"""Bounds on the ratios of many ordered pairs at once, in floats, with a rigorous error."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import HUGE, UNIT
from fairaudit.worst.most_powerful import Span
from fairaudit.worst.rows import ENTRIES, ComparedRows, Indices


@dataclass(frozen=True, eq=False)
class StickBounds:
    """Every k ≥ 0 bounds every pair: R ≤ k + max(0, (γ − m)·H_k − (k − 1)·m)/τ (T4), at the price of one pass."""

    rows: ComparedRows
    span: Span

    def error(self, k: Any) -> Any:
        """Bound on the float error of the bound at k."""
        slope, least, _ = self.span.scaled
        n = self.rows.floats.shape[1]
        return (slope + least + 1.0) * (1.0 + k) * (4 * n + 64) * UNIT

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

    def curve(self, highs: Indices, lows: Indices) -> tuple[Floats, Floats]:
        """Ratios of pairs and the k that prove them, by sorting, in floats, without an error bound."""
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

    def of_pairs(self, highs: Indices, lows: Indices, ks: Floats) -> Floats:
        """Rigorous float bounds of pairs, each at its own k."""
        bounds = np.empty(len(highs))
        step = max(1, ENTRIES // self.rows.floats.shape[1])
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            k = ks[part]
            sticks = np.maximum(self.rows.floats[highs[part]] - k[:, None] * self.rows.floats[lows[part]], 0.0).sum(axis=1)
            bounds[part] = self.at(k, sticks)
        return bounds
