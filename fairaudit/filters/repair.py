"""Filters made of what a solver proposes: exactly stochastic tables of rationals that keep every constraint in integers.

Either the constraints that are active at the proposal are solved exactly, or it is rounded to a grid, and then mixed with a filter
inside the constraints (as a rule one that hides the group) by the least amount on the grid for which every constraint holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import lcm

from fairaudit.exact.extended import ONE, ZERO
from fairaudit.exact.linear_programs import eliminate, solver_float
from fairaudit.filters.problem import Problem, Rows
from fairaudit.filters.program import TableProgram, deepest_in_floats, table_rows
from fairaudit.filters.responses import GRID
from fairaudit.model.mechanism import Mechanism

MOST_BITS = 12_000
"""Exact filters with a common denominator beyond 3,600 digits are given up: numbers of 4,000 digits are not read again."""

MOST_BITS_OF_TABLES = 2**20
"""The same for a whole table, of which every entry above 0 may be as long as the denominator: what is written stays below a megabyte."""

MAX_UNKNOWNS = 3_000
"""Entries and auxiliary variables above 0 up to which the equations are solved: about a second, where few stand in each equation."""

TIGHT = 1e-9
"""What is this near to 0 is taken for 0: ten times the tolerance of the solver. A wrong guess is noticed, and costs the exact solution."""


def deepest_table(problem: Problem) -> list[list[int]] | None:
    """Among all tables the one that is farthest inside the constraints, rounded to the grid."""
    solved = deepest_in_floats(problem)
    return None if solved is None else _rounded(solved[0].tolist(), problem.size)


def _rounded(values: Sequence[float], size: int) -> list[list[int]]:
    """A table on the grid, rows summing to it exactly; entries that are zero but for noise are zero."""
    rows = []
    for part in table_rows(size):
        row = [max(0, round(v * GRID)) if v > TIGHT else 0 for v in values[part.start : part.stop]]
        if sum(row) - max(row) > GRID:  # no row of a table: the greatest entry could not make up for it
            total = sum(row)
            row = [v * GRID // total for v in row]
        row[row.index(max(row))] += GRID - sum(row)
        rows.append(row)
    return rows


def repaired_filter(problem: Problem, values: Sequence[float]) -> Mechanism | None:
    """Round, then mix with a filter inside the constraints by the least amount on the grid for which all of them hold.

    What is mixed in is the average row for everybody; where the utility depends on the group that may be outside, and the table with the
    greatest slack is taken. The constraints, and T3, are convex along the mixture and hold at its end, so that bisection finds the least.
    """
    size = problem.size
    rows = _rounded(values, size)
    inside: list[tuple[Rows, int]] = [([[sum(column) for column in zip(*rows, strict=True)]] * size, GRID * size)]
    if not problem.group_free:
        deepest = deepest_table(problem)
        inside += [(deepest, GRID)] if deepest is not None else []
    found: list[tuple[Fraction, Mechanism]] = []
    for table, bottom in inside:

        def mixed(step: int, table: Rows = table, bottom: int = bottom) -> tuple[list[list[int]], int]:
            part = bottom // GRID
            mixture = [
                [(GRID - step) * part * v + step * w for v, w in zip(row, other, strict=True)]
                for row, other in zip(rows, table, strict=True)
            ]
            return mixture, GRID * bottom

        step = _least_step(lambda step: problem.holds(*mixed(step)))
        if step is not None:
            answer = mixed(step)
            found.append((problem.cost(*answer), problem.mechanism(*answer)))
    return min(found, key=lambda entry: entry[0])[1] if found else None


def _least_step(holds: Callable[[int], bool]) -> int | None:
    """The least step from 0 to `GRID` from which on a condition holds; None if it does not hold at the end."""
    if holds(0):
        return 0
    low, high = 0, 1
    while not holds(high):
        if high == GRID:
            return None
        low, high = high, min(2 * high, GRID)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def exact_vertex(problem: Problem, program: TableProgram, values: Sequence[float], bits: int) -> Mechanism | None:
    """Solve the constraints that are active at the answer exactly; None where that is hard, long, or does not hold."""
    size = problem.size
    unknowns = [v for v, value in enumerate(values) if value > TIGHT]
    if len(unknowns) > MAX_UNKNOWNS:
        return None
    bits = min(bits, MOST_BITS_OF_TABLES // max(1, sum(v < size * size for v in unknowns)))
    kept = set(unknowns)
    equations: list[tuple[dict[int, Fraction], Fraction]] = [({v: ONE for v in part if v in kept}, ONE) for part in table_rows(size)]
    for row, bound in program.linear.rows:
        terms = {v: c for v, c in row if v in kept}
        if terms and abs(sum(solver_float(c) * values[v] for v, c in terms.items()) - solver_float(bound)) < TIGHT:
            equations.append((terms, bound))
    solution = eliminate(equations, {}, most_bits=4 * bits)
    if solution is None or len(solution) < len(unknowns):
        return None
    flat = [solution.get(v, ZERO) for v in range(size * size)]
    bottom = lcm(*(v.denominator for v in flat))
    if bottom.bit_length() > bits or min(flat) < 0:
        return None
    rows = [[int(flat[v] * bottom) for v in part] for part in table_rows(size)]
    return problem.mechanism(rows, bottom) if problem.holds(rows, bottom) else None
