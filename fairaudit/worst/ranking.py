"""Ordered pairs by a cheap rigorous bound on their ratio, which one k proves, and that k as multipliers."""

from __future__ import annotations

from fractions import Fraction
from math import inf

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.exact.extended import ONE, ZERO
from fairaudit.worst.rows import ENTRIES, ComparedRows, Indices, compared_rows
from fairaudit.worst.setting import Setting


def ranked_pairs(setting: Setting) -> list[tuple[float, Fraction, int, tuple[int, int]]]:
    """All ordered pairs with a cheap rigorous bound and the k that gives it, greatest first."""
    pairs = [(block, (i, j)) for block, members in enumerate(setting.members) for i in members for j in members if i != j]
    if setting.of.cap > 10**250 or setting.of.gamma > 10**250 or setting.of.family is not None:
        return [(inf, ZERO, block, pair) for block, pair in pairs]
    rows = compared_rows(setting)
    index = {(block, source): i for i, source in enumerate(rows.sources) for block in (rows.block(i),)}
    highs = np.array([index[block, pair[0]] for block, pair in pairs])
    lows = np.array([index[block, pair[1]] for block, pair in pairs])
    width = setting.of.gamma - setting.of.m
    if setting.of.blind:
        gaps = np.zeros(len(pairs))
    elif setting.of.lipschitz is None:
        gaps = np.full(len(pairs), float(width))
    else:
        gaps = np.array([float(min(width, _gap(setting, pair))) for _, pair in pairs])
    best, ks = np.full(len(pairs), np.inf), np.zeros(len(pairs))
    cap = float(min(setting.of.cap, Fraction(10) ** 6))
    for k in (0.0, *(round(k * 64) / 64 for k in np.geomspace(1.0, max(cap, 1.001), 24).tolist())):
        bounds = _bounds(setting, rows, highs, lows, gaps, k)
        better = bounds < best
        best[better], ks[better] = bounds[better], k
    order = np.argsort(-best, kind="stable").tolist()
    return [(float(best[i]), Fraction(float(ks[i])), *pairs[i]) for i in order]


def _gap(setting: Setting, pair: tuple[int, int]) -> Fraction:
    a, b = pair if setting.quantity == "global" else (setting.group_of[pair[0]], setting.group_of[pair[1]])
    gap: Fraction = setting.of.lipschitz * (ONE if setting.metric is None else setting.metric[a][b])
    return gap


def _bounds(setting: Setting, rows: ComparedRows, highs: Indices, lows: Indices, gaps: Floats, k: float) -> Floats:
    """R ≤ k + max(0, Σ_u max over g of P·min(γ, g + K) − k·Q·g)/τ, rounded up."""
    of = setting.of
    gamma, m, floor = float(of.gamma), float(of.m), float(of.floor)
    bounds = np.empty(len(highs))
    n, chain = rows.floats.shape[1], setting.chain
    error = (gamma / floor + 1.0) * (1.0 + k) * (8 * n + 128) * UNIT
    step = max(1, ENTRIES // n)
    for begin in range(0, len(highs), step):
        part = slice(begin, begin + step)
        p, q = rows.floats[highs[part]], k * rows.floats[lows[part]]
        gap = gaps[part, None]
        difference = p - q
        if chain is not None:
            # A monotone utility is m plus steps: the best one is m + (γ − m) on an upper set of the chain, in each context.
            tails = np.cumsum(difference.reshape(len(p), -1, len(chain))[:, :, chain[::-1]], axis=2).max(axis=2)
            total = m * difference.sum(axis=1) + (gamma - m) * np.maximum(tails, 0.0).sum(axis=1)
            bounds[part] = k + np.maximum(total, 0.0) / floor + error
            continue
        apart = np.where(difference > 0, difference * gamma, difference * m) + np.minimum(p, q) * gap
        total = np.minimum(apart, p * gamma - q * m).sum(axis=1)
        bounds[part] = k + np.maximum(total, 0.0) / floor + error
    return bounds


def stick_multipliers(setting: Setting, block: int, pair: tuple[int, int], k: Fraction, ratio: Fraction) -> dict[int, Fraction]:
    """Write the k of a cheap bound as multipliers: R − k on the floor of the lower group, and what joins the two utilities."""
    of = setting.of
    found: dict[int, Fraction] = {}
    floors = setting.floors(block, pair)
    if floors and of.tau > of.m and ratio > k:
        found[floors.index(pair[1])] = ratio - k
    else:
        k = ratio
    if setting.chain is not None:
        found |= _up_the_chain(setting, block, pair, k, len(floors))
    if of.blind or of.lipschitz is None:
        return found
    second = {setting.place_of[cell]: cell for cell in setting.cells_of(pair[1])}
    means = setting.vector(pair[0]), setting.vector(pair[1])
    for cell in setting.cells_of(pair[0]):
        other = second.get(setting.place_of[cell])
        if other is None:
            continue
        reach = setting.reach(cell, other)
        for u, number in enumerate(setting.distance_numbers(block, cell, other)):
            p = means[0].get(setting.variable(cell, u), ZERO)
            q = k * means[1].get(setting.variable(other, u), ZERO)
            apart = (p - q) * (of.gamma if p > q else of.m) + min(p, q) * reach
            if min(p, q) > 0 and apart < p * of.gamma - q * of.m:
                found[len(floors) + number] = min(p, q)
    return found


def _up_the_chain(setting: Setting, block: int, pair: tuple[int, int], k: Fraction, offset: int) -> dict[int, Fraction]:
    """Multipliers of the order that push what is positive in P − k·Q up the chain, where it cancels what is negative."""
    high, low = setting.vector(pair[0]), setting.vector(pair[1])
    found: dict[int, Fraction] = {}
    for cell in sorted({setting.cells[setting.place_of[c]][0] for member in pair for c in setting.cells_of(member)}):
        pushed = ZERO
        for number, (u, _) in zip(setting.order_numbers(block, cell), setting.order, strict=True):
            v = setting.variable(cell, u)
            pushed = max(ZERO, pushed + high.get(v, ZERO) - k * low.get(v, ZERO))
            if pushed:
                found[offset + number] = pushed
    return found
