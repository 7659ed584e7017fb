"""The greatest ratio of one ordered pair of rows under one range and one floor (T3, T4), exactly, and whether a k proves one."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, inf

from fairaudit.exact.extended import ONE, ZERO
from fairaudit.worst.rows import ComparedRows


@dataclass(frozen=True)
class Span:
    """γ, m and the floor, exactly and in floats."""

    gamma: Fraction
    m: Fraction
    floor: Fraction

    @property
    def width(self) -> Fraction:
        """γ − m."""
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
class Best:
    """The exact answer for an ordered pair of rows, the k that proves it, and the utility row that attains it."""

    ratio: Fraction
    k: Fraction
    values: list[Fraction]
    pair: tuple[int, int]


def most_powerful(rows: ComparedRows, pair: tuple[int, int], span: Span) -> Best:
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
    return Best(best, k, [m + width * chosen.get(j, ZERO) for j in range(len(p))], pair)


def proved(rows: ComparedRows, pair: tuple[int, int], k: Fraction, span: Span, ratio: Fraction) -> bool:
    """Whether k proves the ratio for a pair, exactly."""
    p, q = rows.exact(pair[0]), rows.exact(pair[1])
    top, bottom = sum(p), sum(q)
    stick = Fraction(
        sum(max(0, v * bottom * k.denominator - k.numerator * w * top) for v, w in zip(p, q, strict=True)), top * bottom * k.denominator
    )
    return k * span.floor + max(ZERO, span.width * stick - (k - 1) * span.m) <= ratio * span.floor
