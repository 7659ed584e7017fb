"""The linear program of a filter, the tables that are made of its answer, and the bounds that its multipliers prove.

The solver's answer is only a proposal. It is made an exactly stochastic table of rationals, by solving the active constraints
exactly or by rounding to a grid, and then mixed with a filter inside the constraints (as a rule one that hides the group) by the
least amount on the grid for which every constraint holds in integers. The dual answer, rounded too, gives an exact lower bound on
what any filter costs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import log

from fairaudit.exact.linear_programs import Row, solve_over_tables, solved_exactly
from fairaudit.exact.rationals import common_denominator
from fairaudit.filters.problem import Problem, Rows
from fairaudit.filters.responses import GRID
from fairaudit.model.mechanism import Mechanism

DUAL_GRID = 1 << 60

MAX_UNKNOWNS = 90

BISECTIONS = 30

MOST_EXCESS = 1 << 20

TIGHT = 1e-9


@dataclass(frozen=True)
class _Program:
    """The linear program: rows ≤ 0 over the table's entries and auxiliary variables ≥ 0; every row of the table sums to 1."""

    size: int
    variables: int
    rows: list[Row]
    lifts: dict[int, list[int]] = field(default_factory=dict)
    """For an auxiliary variable the rows in which its coefficient is 1."""


def entry_prices(problem: Problem) -> list[Fraction]:
    return [Fraction(v, problem.price_scale) for row in problem.prices for v in row]


def linear_program(problem: Problem, *, slack: bool = False) -> _Program:
    """Target and cap as rows ≤ 0: m ≤ E(x,a) ≤ R*·m for a least mean m of each context, b ≤ M(ã|a) ≤ e^ε·b for each release.

    With `slack` every row is loosened by the last variable.
    """
    size = problem.size
    rows: list[Row] = []
    lifts: dict[int, list[int]] = {}
    following = size * size

    def between(least: int, groups: Iterable[Row], factor: Fraction) -> None:
        for row in groups:
            lifts.setdefault(least, []).append(len(rows))
            rows.append([(least, Fraction(1)), *((v, -c) for v, c in row)])
            rows.append([*row, (least, -factor)])

    if problem.target is not None:
        for block in problem.gains:
            top = max(v for row in block for v in row)
            means = [[(a * size + j, Fraction(v, top)) for j, v in enumerate(row) if v] for a, row in enumerate(block)]
            between(following, means, problem.target)
            following += 1
    if problem.cap is not None:
        for j in range(size):
            between(following, [[(a * size + j, Fraction(1))] for a in range(size)], problem.cap)
            following += 1
    if slack:
        rows = [[*row, (following, Fraction(-1))] for row in rows]
        following += 1
    return _Program(size, following, rows, lifts)


def solve_in_floats(program: _Program, prices: Sequence[Fraction], *, slack: bool = False) -> tuple[list[float], list[float]] | None:
    """Solve in floating point: the variables and the multipliers of the rows, or None if there is no solution.

    The prices are of the table's entries, or, with `slack`, of nothing but the last variable, which may then be negative.
    """
    from scipy.sparse import csr_array

    owner = [i for i, row in enumerate(program.rows) for _ in row]
    place = [v for row in program.rows for v, _ in row]
    entries = [float(c) for row in program.rows for _, c in row]
    matrix = csr_array((entries, (owner, place)), shape=(len(program.rows), program.variables)) if program.rows else None
    scale = max((float(p) for p in prices), default=0.0) or 1.0
    costs = [float(p) / scale for p in prices] + [0.0] * (program.variables - len(prices))
    lower = [0.0] * program.variables
    if slack:
        costs[-1], lower[-1] = 1.0, -1.0
    solved = solve_over_tables(costs, matrix, [0.0] * len(program.rows), program.size, lower)
    if solved is None:
        return None
    values, duals = solved
    return values, [d * scale for d in duals]


def _combination(program: _Program, duals: Sequence[float]) -> dict[int, Fraction]:
    """Σ y_i·row_i for multipliers y ≥ 0 near the given ones for which no auxiliary variable has a negative coefficient."""
    exact = [Fraction(max(0, round(d * DUAL_GRID)), DUAL_GRID) for d in duals]
    total: dict[int, Fraction] = {}

    def add(i: int, amount: Fraction) -> None:
        for v, c in program.rows[i]:
            total[v] = total.get(v, Fraction(0)) + amount * c

    for i, y in enumerate(exact):
        if y:
            add(i, y)
    for v, lifting in program.lifts.items():
        if total.get(v, 0) < 0:
            add(max(lifting, key=lambda i: exact[i]), -total[v])
    return total


def dual_bound(program: _Program, prices: Sequence[Fraction], duals: Sequence[float]) -> Fraction:
    """No table costs less: Σ_a min_ã of price plus Σ y_i·row_i, for any y ≥ 0."""
    total = _combination(program, duals)
    size = program.size

    def least(extra: Mapping[int, Fraction]) -> Fraction:
        return sum((min(prices[v] + extra.get(v, 0) for v in range(a * size, (a + 1) * size)) for a in range(size)), start=Fraction(0))

    return max(least(total), least({}))


def why_infeasible(problem: Problem) -> str:
    """Why no filter meets the target, with a proof in integers where the multipliers give one, and about what would be in reach."""
    if problem.target is None or problem.group_free:
        return "the linear program was not solved"
    loosened = solve_in_floats(linear_program(problem, slack=True), [], slack=True)
    proved = loosened is not None and _refuted(linear_program(problem), loosened[1])
    known = "proved exactly" if proved else "as far as floating point tells"
    said = f"no filter meets the target, because the utility itself depends on the group ({known})"

    def reached(excess: Fraction, target: Fraction = problem.target) -> bool:
        return solve_in_floats(linear_program(replace(problem, target=target * (1 + excess))), entry_prices(problem)) is not None

    low, high = Fraction(0), Fraction(1)
    while not reached(high):
        if high > MOST_EXCESS:
            return f"{said}; change the utility or the policy, or loosen the cap"
        low, high = high, high * 2
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if reached(middle) else (middle, high)
    reach = float(problem.target * (1 + high))
    return f"{said}; a target ratio of about {reach:.6g} (log {log(reach):.6g}) is within reach"


def _refuted(program: _Program, duals: Sequence[float]) -> bool:
    """Whether the multipliers prove that no table meets all rows: Σ y_i·row_i is positive at every table."""
    total = _combination(program, duals)
    size = program.size
    return sum((min(total.get(v, Fraction(0)) for v in range(a * size, (a + 1) * size)) for a in range(size)), start=Fraction(0)) > 0


def deepest_table(problem: Problem) -> list[list[int]] | None:
    """Among all tables the one that is farthest inside the constraints, rounded to the grid."""
    solved = solve_in_floats(linear_program(problem, slack=True), [], slack=True)
    return None if solved is None else _rounded(solved[0][: problem.size**2], problem.size)


def _rounded(values: Sequence[float], size: int) -> list[list[int]]:
    """A table on the grid, rows summing to it exactly; entries that are zero but for noise are zero."""
    rows = []
    for a in range(size):
        row = [max(0, round(v * GRID)) if v > TIGHT else 0 for v in values[a * size : (a + 1) * size]]
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


def exact_vertex(problem: Problem, program: _Program, values: Sequence[float], bits: int) -> Mechanism | None:
    """Solve the constraints that are active at the answer exactly; None where that is hard, long, or does not hold."""
    size = problem.size
    unknowns = [v for v, value in enumerate(values) if value > TIGHT]
    if len(unknowns) > MAX_UNKNOWNS:
        return None
    place = {v: i for i, v in enumerate(unknowns)}
    tight = []
    for row in program.rows:
        terms = [(place[v], c) for v, c in row if v in place]
        if terms and abs(sum(float(c) * values[unknowns[i]] for i, c in terms)) < TIGHT:
            tight.append((terms, Fraction(0)))
    sums = [([(place[v], Fraction(1)) for v in range(a * size, (a + 1) * size) if v in place], Fraction(1)) for a in range(size)]
    solution = solved_exactly([*sums, *tight], len(unknowns))
    if solution is None:
        return None
    flat = [solution[place[v]] if v in place else Fraction(0) for v in range(size * size)]
    if any(v < 0 for v in flat):
        return None
    whole, bottom = common_denominator([(v.numerator, v.denominator) for v in flat])
    rows = [whole[a * size : (a + 1) * size] for a in range(size)]
    return problem.mechanism(rows, bottom) if bottom.bit_length() <= bits and problem.holds(rows, bottom) else None
