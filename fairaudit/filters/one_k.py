"""Filters that one k certifies for all ordered pairs of rows: a linear program for each k, on a grid and then by golden section."""

from __future__ import annotations

from fractions import Fraction
from math import inf, sqrt

import numpy as np

from fairaudit.exact.linear_programs import solve_over_tables
from fairaudit.filters.problem import Problem
from fairaudit.filters.program import entry_prices

GRID_POINTS = 9

GOLDEN_STEPS = 10


def tables_over_k(problem: Problem, level: Fraction, target: Fraction, least: Fraction) -> list[list[float]]:
    """Grid, then golden section around its best point; the best table of each."""
    low, high = float(least), float(target)
    known: dict[float, tuple[float, list[float]]] = {}

    def value(k: float) -> float:
        if k not in known:
            known[k] = _solve_for_k(problem, float(level), float(target), k)
        return known[k][0]

    inside = [low * (high / low) ** (i / (GRID_POINTS + 1)) for i in range(1, GRID_POINTS + 1)]
    points = sorted({*inside, *([1.0] if low < 1 < high else [])})
    best = min(range(len(points)), key=lambda i: value(points[i]))
    tables = [known[points[best]][1]]
    left, right = ([low, *points][best], [*points, high][best + 1])
    ratio = (sqrt(5) - 1) / 2
    inner, outer = right - ratio * (right - left), left + ratio * (right - left)
    for _ in range(GOLDEN_STEPS):
        if value(inner) <= value(outer):
            right, outer = outer, inner
            inner = right - ratio * (right - left)
        else:
            left, inner = inner, outer
            outer = left + ratio * (right - left)
    finest = min(known, key=value)
    tables.append(known[finest][1])
    return [table for table in tables if table]


def _solve_for_k(problem: Problem, level: float, target: float, k: float) -> tuple[float, list[float]]:
    """The least distortion in floating point among filters that k certifies, and the table; Σ_ã s ≤ t·(R* − k), s ≥ M(ã|a) − k·M(ã|a')."""
    from scipy.sparse import coo_array

    size = problem.size
    square, pairs = size * size, size * (size - 1)
    first, second = (np.array(side) for side in zip(*((a, b) for a in range(size) for b in range(size) if a != b), strict=True))
    column = np.arange(size)
    count = pairs * size
    slack = square + np.arange(count)
    excess = np.arange(count)
    owner = [excess, excess, excess, count + np.repeat(np.arange(pairs), size)]
    place = [(first[:, None] * size + column).ravel(), (second[:, None] * size + column).ravel(), slack, slack]
    entries = [np.ones(count), np.full(count, -k), np.full(count, -1.0), np.ones(count)]
    limits = [0.0] * count + [level * (target - k)] * pairs
    variables = square + count
    if problem.cap is not None:
        cells = np.arange(square)
        floor = variables + cells % size
        start = count + pairs
        owner += [start + cells, start + cells, start + square + cells, start + square + cells]
        place += [floor, cells, cells, floor]
        entries += [np.ones(square), np.full(square, -1.0), np.ones(square), np.full(square, -float(problem.cap))]
        limits += [0.0] * (2 * square)
        variables += size
    matrix = coo_array((np.concatenate(entries), (np.concatenate(owner), np.concatenate(place))), shape=(len(limits), variables)).tocsr()
    prices = [float(p) for p in entry_prices(problem)]
    scale = max(prices) or 1.0
    solved = solve_over_tables([p / scale for p in prices] + [0.0] * (variables - square), matrix, limits, size, [0.0] * variables)
    if solved is None:
        return inf, []
    values = solved[0][:square]
    return sum(p * v for p, v in zip(prices, values, strict=True)), values
