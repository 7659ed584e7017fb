"""The linear program of a filter, and the bounds that its multipliers prove.

The solver's answer is only a proposal, of which `fairaudit.filters.repair` makes a filter. Its multipliers, rounded, give an exact
lower bound on what any filter costs, or a proof that there is none, whatever the solver said.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import ONE, ZERO
from fairaudit.exact.linear_programs import LARGEST, Answer, LinearProgram, rounded_multipliers, solver_floats
from fairaudit.filters.problem import Problem
from fairaudit.filters.targets import ratio_and_log

DUAL_GRID = 1 << 60
"""Multipliers of filters are rounded to this grid, finer than doubles near 1: the bound then loses less than the grid of the filters."""

TOLERANCE = 1e-10
"""What the solver may miss a constraint by, the least that HiGHS accepts: entries of a filter are on a grid of 10^-12."""

BISECTIONS = 30
"""Steps in which the least target within reach is found, to nine digits; six are said."""

MOST_EXCESS = 1 << 20
"""Beyond this multiple of the target no target within reach is looked for."""


@dataclass(frozen=True)
class TableProgram:
    """The linear program of a table: rows over its entries and auxiliary variables ≥ 0; every row of the table sums to 1."""

    size: int
    linear: LinearProgram
    lifts: dict[int, list[int]]
    """For an auxiliary variable the rows in which its coefficient is 1, of multipliers that may be raised."""
    under: list[tuple[list[int], int]]
    """For other auxiliary variables the rows in which their coefficient is −1, and the one in which it is 1, whose multiplier stays."""


def entry_prices(problem: Problem) -> list[Fraction]:
    """P(a)·c(a,ã) by entry of the table."""
    return [Fraction(v, problem.price_scale) for row in problem.prices for v in row]


def table_rows(size: int) -> list[range]:
    """The entries of each row of a table."""
    return [range(a * size, (a + 1) * size) for a in range(size)]


def linear_program(problem: Problem, *, slack: bool = False) -> TableProgram:
    """Target and cap: m ≤ E(x,a) ≤ R*·m for a least mean m of each context, b ≤ M(ã|a) ≤ e^ε·b for each release.

    For every policy A·M(ã|a) − B·M(ã|a') ≤ s for each decision, block and release, and Σ s ≤ room. With `slack` every row is loosened by
    the last variable, which may be negative.
    """
    size = problem.size
    rows: list[list[tuple[int, Fraction]]] = []
    bounds: dict[int, Fraction] = {}
    lifts: dict[int, list[int]] = {}
    under: list[tuple[list[int], int]] = []
    following = size * size

    def between(least: int, groups: Iterable[list[tuple[int, Fraction]]], factor: Fraction) -> None:
        for row in groups:
            lifts.setdefault(least, []).append(len(rows))
            rows.append([(least, ONE), *((v, -c) for v, c in row)])
            rows.append([*row, (least, -factor)])

    if problem.target is not None:
        for block in problem.gains:
            top = max(v for row in block for v in row)
            means = [[(a * size + j, Fraction(v, top)) for j, v in enumerate(row) if v] for a, row in enumerate(block)]
            between(following, means, problem.target)
            following += 1
        for part in problem.sums:
            unit = max((v for better in part.blocks for pair in better for v in pair), default=1)
            total: list[tuple[int, Fraction]] = []
            below: list[list[int]] = []
            for better, j in product(part.blocks, range(size)):
                below.append(list(range(len(rows), len(rows) + len(better))))
                at = part.first * size + j, part.second * size + j
                rows += [[(at[0], Fraction(a, unit)), (at[1], Fraction(-b, unit)), (following, -ONE)] for a, b in better]
                total.append((following, ONE))
                following += 1
            under += [(places, len(rows)) for places in below]
            bounds[len(rows)] = Fraction(part.room, unit)
            rows.append(total)
    if problem.cap is not None:
        for j in range(size):
            between(following, [[(a * size + j, ONE)] for a in range(size)], problem.cap)
            following += 1
    low = [ZERO] * following
    if slack:
        rows = [[*row, (following, -ONE)] for row in rows]
        low.append(-ONE)
    constraints = [(row, bounds.get(i, ZERO)) for i, row in enumerate(rows)]
    return TableProgram(size, LinearProgram(low, [ONE] * len(low), constraints, table_rows(size), range(len(low))), lifts, under)


def solve_in_floats(program: TableProgram, prices: Sequence[Fraction]) -> Answer | None:
    """Ask for the cheapest table, prices being of its entries: the variables and the multipliers of the rows, or None."""
    costs, scale = np.zeros(len(program.linear.low)), 1.0
    if prices:
        floats = solver_floats(prices)
        scale = float(floats.max()) or 1.0
        costs[: len(prices)] = floats / scale
    found = program.linear.ask(costs, TOLERANCE)
    if found is None:
        return None
    with np.errstate(over="ignore"):
        return found[0], found[1] * scale


def deepest_in_floats(problem: Problem) -> Answer | None:
    """Ask for the table that is farthest inside the constraints."""
    linear = linear_program(problem, slack=True).linear
    costs = np.zeros(len(linear.low))
    costs[-1] = 1.0
    return linear.ask(costs, TOLERANCE)


def _lifted(program: TableProgram, duals: Floats) -> dict[int, Fraction]:
    """Exact multipliers y ≥ 0 near the given ones for which no auxiliary variable has a negative coefficient in Σ y_i·row_i."""
    exact = rounded_multipliers(duals, DUAL_GRID)
    for places, total in program.under:
        most = exact.get(total, ZERO)
        for i in places:
            exact[i] = min(exact.get(i, ZERO), most)
            most -= exact[i]
    rest, _ = program.linear.reduced({}, exact)
    for v, lifting in program.lifts.items():
        missing = rest.get(v, ZERO)
        if missing > 0:
            raised = max(lifting, key=lambda i: exact.get(i, ZERO))
            exact[raised] = exact.get(raised, ZERO) + missing
    return exact


def dual_bound(program: TableProgram, prices: Sequence[Fraction], duals: Floats) -> Fraction:
    """No table costs less: Σ_a min_ã of price plus Σ y_i·row_i, for any y ≥ 0."""
    gains = {v: -price for v, price in enumerate(prices)}
    most = min(program.linear.dual_bound(gains, _lifted(program, duals)), program.linear.dual_bound(gains, {}))
    return -Fraction(most)


def why_infeasible(problem: Problem) -> str:
    """Why no filter meets the target, with a proof in integers where the multipliers give one, and about what would be in reach."""
    if problem.target is None or problem.group_free:
        return "the linear program was not solved"
    loosened = deepest_in_floats(problem)
    program = linear_program(problem)
    proved = loosened is not None and program.linear.emptiness(_lifted(program, loosened[1])) > 0
    known = "proved exactly" if proved else "as far as floating point tells"
    said = f"no filter meets the target, because the utility itself depends on the group ({known})"

    def reached(excess: Fraction, target: Fraction = problem.target) -> bool:
        return solve_in_floats(linear_program(replace(problem, target=target * (1 + excess))), entry_prices(problem)) is not None

    low, high = Fraction(0), Fraction(1)
    while not reached(high):
        if high > MOST_EXCESS or problem.target * high > LARGEST:
            return f"{said}; change the utility or the policy, or loosen the cap"
        low, high = high, high * 2
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if reached(middle) else (middle, high)
    ratio, logarithm = ratio_and_log(problem.target * (1 + high))
    return f"{said}; a target ratio of about {ratio} (log {logarithm}) is within reach"
