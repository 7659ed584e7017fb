"""Filters that one k certifies for all ordered pairs of rows: a linear program for each k, on a grid and then by golden section."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import inf, sqrt

import numpy as np

from fairaudit.errors import InputError
from fairaudit.exact.extended import ZERO
from fairaudit.exact.linear_programs import ask_solver, distribution_sums, solver_float, solver_floats
from fairaudit.filters.policy_sums import sums_of_range
from fairaudit.filters.problem import Problem
from fairaudit.filters.program import TOLERANCE, entry_prices, table_rows
from fairaudit.filters.repair import repaired_filter
from fairaudit.filters.search import Found, filters_by_program
from fairaudit.model.mechanism import Mechanism
from fairaudit.theorems.t13_range import UtilityRange

GRID_POINTS = 9
"""Values of k between the ends of its range that are looked at first: the cost over k is smooth, with one or two valleys."""

GOLDEN_STEPS = 10
"""Steps of golden section from the best of them: each costs a linear program, and all narrow the range to less than 1/100."""

LEAST_K = 1e-100
"""The range of k begins here at the latest: a fraction of it must not overflow."""

MAX_MODEL_FREE = 16
"""Each of twenty linear programs has a variable for every ordered pair of groups and release: 3,840 at this number of groups."""


def filters_by_one_k(problem: Problem) -> Found:
    """The best filters that one k certifies: H_k ≤ (τ·(R* − k) + (k − 1)·m − K)/(γ − K − m) for each ordered pair of rows.

    At the least k the right side is 1 − k, a cap on ε. At the greatest it is that of a policy without a floor, at R*, or 0, a cap too.
    """
    floored, target = problem.floored, problem.target
    if floored is None or target is None:
        return filters_by_program(problem)
    if target > 1 and problem.size > MAX_MODEL_FREE:
        raise InputError(
            f"a design without a policy accepts up to {MAX_MODEL_FREE} groups that differ in frequency or distortion, not {problem.size}; "
            "with equal frequencies and the default distortion there is no such limit"
        )
    tau, m, gap = floored.tau, floored.m, floored.gap
    least = (floored.gamma - tau * target) / (floored.gamma - gap - tau) if floored.gamma - gap > tau else ZERO
    greatest = min(target, (tau * target - m - gap) / (tau - m))
    caps = [1 / least] if least else []
    found: list[tuple[Mechanism, str]] = []
    if _room(floored, target, greatest):
        found += filters_by_program(replace(problem, floored=None, sums=sums_of_range(problem.size, floored, target)))[0]
    else:
        caps.append(greatest)
    if caps:
        widest = max(caps) if problem.cap is None else min(max(caps), problem.cap)
        found += filters_by_program(replace(problem, target=None, floored=None, cap=widest))[0]
    if target == 1:
        return found, None, ""
    for values in _tables_over_k(problem, floored, target, least, greatest):
        repaired = repaired_filter(problem, values)
        if repaired is not None:
            found.append((repaired, "linear program for one common k, rounded and mixed until exact"))
    return found, None, ""


def _room(floored: UtilityRange, target: Fraction, k: Fraction) -> Fraction:
    """What H_k may be at most."""
    return (floored.tau * (target - k) + (k - 1) * floored.m - floored.gap) / floored.span


def _tables_over_k(problem: Problem, floored: UtilityRange, target: Fraction, least: Fraction, greatest: Fraction) -> list[list[float]]:
    """Grid, then golden section around its best point; the best table of each."""
    low, high = max(solver_float(least), LEAST_K), solver_float(greatest)
    known: dict[float, tuple[float, list[float]]] = {}

    def value(k: float) -> float:
        if k not in known:
            known[k] = _solve_for_k(problem, k, solver_float(_room(floored, target, Fraction(k))))
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


def _solve_for_k(problem: Problem, k: float, room: float) -> tuple[float, list[float]]:
    """The least distortion in floating point among filters that k certifies, and the table; Σ_ã s ≤ room, s ≥ M(ã|a) − k·M(ã|a')."""
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
    limits = [0.0] * count + [room] * pairs
    variables = square + count
    if problem.cap is not None:
        cells = np.arange(square)
        floor = variables + cells % size
        start = count + pairs
        owner += [start + cells, start + cells, start + square + cells, start + square + cells]
        place += [floor, cells, cells, floor]
        entries += [np.ones(square), np.full(square, -1.0), np.ones(square), np.full(square, -solver_float(problem.cap))]
        limits += [0.0] * (2 * square)
        variables += size
    matrix = coo_array((np.concatenate(entries), (np.concatenate(owner), np.concatenate(place))), shape=(len(limits), variables)).tocsr()
    prices = solver_floats(entry_prices(problem))
    costs = np.zeros(variables)
    costs[:square] = prices / (float(prices.max()) or 1.0)
    bounds = np.column_stack((np.zeros(variables), np.full(variables, np.inf)))
    sums = distribution_sums(table_rows(size), variables)
    solved = ask_solver(costs, matrix, np.array(limits), sums, bounds, TOLERANCE)
    if solved is None:
        return inf, []
    values = solved[0][:square].tolist()
    return sum(p * v for p, v in zip(prices.tolist(), values, strict=True)), values
