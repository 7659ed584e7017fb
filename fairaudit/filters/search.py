"""Filters by one linear program: for a known policy, or for a cap on ε alone."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from fairaudit.errors import InputError
from fairaudit.filters.problem import Problem
from fairaudit.filters.program import dual_bound, entry_prices, linear_program, solve_in_floats, why_infeasible
from fairaudit.filters.repair import MOST_BITS, deepest_table, exact_vertex, repaired_filter
from fairaudit.filters.responses import GRID
from fairaudit.model.mechanism import Mechanism

Found = tuple[list[tuple[Mechanism, str]], Fraction | None, str]
"""Filters and how they were made, a lower bound on the distortion of all if there is one, and why none was found."""

Search = Callable[[Problem], Found]

EASY_BITS = 256
"""Where the rounded filter costs next to nothing, an exact one is worth only denominators of up to 77 digits."""

GAP = 10**9
"""A rounded filter that costs less than 1/GAP above the lower bound is as good as exact to every reader."""


MAX_EXCESSES = 25_000
"""Variables of a program for every policy besides the filter, for each pair of groups, context and release: some 15 seconds."""


def filters_by_program(problem: Problem) -> Found:
    """Filters by linear programming, an exact lower bound on the distortion where there is one, and why nothing was found."""
    excesses = sum(len(part.blocks) for part in problem.sums) * problem.size
    if excesses > MAX_EXCESSES:
        raise InputError(
            f"the linear program for {problem.size} groups and every policy has {excesses:,} variables besides the filter; up to "
            f"{MAX_EXCESSES:,} are accepted: fewer groups or contexts, or fairaudit calibrate, which has no such limit"
        )
    program = linear_program(problem)
    prices = entry_prices(problem)
    solved = solve_in_floats(program, prices)
    if solved is None:
        deepest = deepest_table(problem)
        if deepest is not None and problem.holds(deepest, GRID):
            return [(problem.mechanism(deepest, GRID), "linear program, well inside the constraints")], None, ""
        return [], None, why_infeasible(problem)
    values, duals = solved[0].tolist(), solved[1]
    lower = dual_bound(program, prices, duals)
    found: list[tuple[Mechanism, str]] = []
    repaired = repaired_filter(problem, values[: problem.size**2])
    if repaired is not None:
        found.append((repaired, "linear program, rounded and mixed until exact"))
    close = repaired is not None and problem.cost(*problem.rows_of(repaired)) - lower < Fraction(1, GAP)
    vertex = exact_vertex(problem, program, values, EASY_BITS if close else MOST_BITS)
    if vertex is not None:
        found.append((vertex, "linear program, exactly solved"))
    if not found:
        return found, lower, "a filter may exist, but none was found that holds exactly; a slightly larger target leaves room for rounding"
    return found, lower, ""
