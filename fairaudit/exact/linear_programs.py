"""Linear programs whose solver is asked and never believed.

Floats only search. What a solver says is checked for shape and finiteness, rounded to rationals, and solved again exactly; wrong
answers cost tightness, never truth. What is concluded rests on weak duality: for multipliers y ≥ 0 of the rows A v ≤ b and any
domain that holds all points,

    c·v ≤ y·b + max over the domain of (c − y·A)·v,

however the multipliers were found.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf, lcm
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.exact.lifting import MOST_UNKNOWNS, solve_by_lifting

Row = Iterable[tuple[int, Fraction]]
"""Variables and their coefficients."""

Answer = tuple[Floats, Floats]
"""What a solver said: a point, and the multipliers of the rows."""

LARGEST = Fraction(10) ** 200
"""What is greater is this to a solver, and answers beyond it are none: floats end at 10^308, and products of two must not."""

ROUNDING = 2**44
"""Multipliers are rounded to this grid: what a double near 1 still tells apart from noise, in numbers that stay short."""

PATIENCE = 1_000
"""Numbers that elimination may change before another way is looked for: a millisecond or two."""


# Weak duality


def reduced(objective: Mapping[int, Fraction], cited: Iterable[tuple[Fraction, Row, Fraction]]) -> tuple[dict[int, Fraction], Fraction]:
    """C − y·A and y·b for rows that are cited as y, coefficients and bound."""
    rest, total = dict(objective), ZERO
    for y, terms, bound in cited:
        total += y * bound
        for v, a in terms:
            rest[v] = rest.get(v, ZERO) - y * a
    return rest, total


def greatest_over_box(coefficients: Iterable[tuple[Fraction, Fraction, Fraction]]) -> Fraction:
    """The greatest Σ c·v of variables between two ends each."""
    return sum((c * (high if c > 0 else low) for c, low, high in coefficients), ZERO)


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """The points of a linear program: rows A v ≤ b, a box, and distributions.

    Attributes
    ----------
    low, high : sequence of Fraction
        The box.
    rows : sequence of (coefficients, bound)
        A and b.
    distributions : sequence of range
        Variables that are at least 0 and sum to 1.
    unbounded : range
        Variables whose upper end is infinite, or need not be said; `high` is not read there.
    """

    low: Sequence[Fraction]
    high: Sequence[Fraction]
    rows: Sequence[tuple[Sequence[tuple[int, Fraction]], Fraction]]
    distributions: Sequence[range] = ()
    unbounded: range = range(0)

    def slack(self, row: int, point: Sequence[Fraction]) -> Fraction:
        """By how much a point keeps a row."""
        terms, bound = self.rows[row]
        return bound - sum((a * point[j] for j, a in terms), ZERO)

    def feasible(self, point: Sequence[Fraction]) -> bool:
        """Whether a point keeps all constraints, exactly."""
        ends = enumerate(zip(self.low, point, self.high, strict=True))
        inside = all(low <= v and (v <= high or j in self.unbounded) for j, (low, v, high) in ends)
        whole = all(sum((point[j] for j in part), ZERO) == ONE for part in self.distributions)
        return inside and whole and all(self.slack(i, point) >= 0 for i in range(len(self.rows)))

    def clipped(self, point: Floats) -> list[Fraction]:
        """A point of floats as the rationals that they are, moved into the box."""
        return [min(max(Fraction(v), low), high) for v, low, high in zip(point.tolist(), self.low, self.high, strict=True)]

    def reduced(self, objective: Mapping[int, Fraction], multipliers: Mapping[int, Fraction]) -> tuple[dict[int, Fraction], Fraction]:
        """C − y·A and y·b for multipliers by row."""
        return reduced(objective, ((y, *self.rows[i]) for i, y in multipliers.items()))

    def greatest(self, objective: Mapping[int, Fraction]) -> Extended:
        """The greatest c·v over box and distributions, whatever the rows say."""
        total = sum((max(objective.get(j, ZERO) for j in part) for part in self.distributions), ZERO)
        inside = {j for part in self.distributions for j in part}
        others = {j: c for j, c in objective.items() if j not in inside}
        if any(c > 0 and j in self.unbounded for j, c in others.items()):
            return inf
        return total + greatest_over_box((c, self.low[j], self.high[j]) for j, c in others.items())

    def dual_bound(self, objective: Mapping[int, Fraction], multipliers: Mapping[int, Fraction]) -> Extended:
        """Weak duality: no point of the program has a greater c·v, for any multipliers y ≥ 0."""
        rest, total = self.reduced(objective, multipliers)
        most = self.greatest(rest)
        return total + most if isinstance(most, Fraction) else most

    def emptiness(self, multipliers: Mapping[int, Fraction]) -> Extended:
        """By how much multipliers contradict the constraints: positive proves that no point satisfies them (Farkas)."""
        return -self.dual_bound({}, multipliers)

    @cached_property
    def floats(self) -> tuple[Any, Floats, Floats, Floats]:
        """A (sparse), b and the box, in floats."""
        from scipy.sparse import csr_array

        entries = [(i, j, solver_float(a)) for i, (terms, _) in enumerate(self.rows) for j, a in terms]
        at = np.array([(i, j) for i, j, _ in entries], dtype=np.int64).reshape(-1, 2)
        matrix = csr_array(
            (np.array([a for _, _, a in entries], dtype=np.float64), (at[:, 0], at[:, 1])), shape=(len(self.rows), len(self.low))
        )
        high = solver_floats(self.high)
        high[list(self.unbounded)] = np.inf
        return matrix, solver_floats([bound for _, bound in self.rows]), solver_floats(self.low), high

    def ask(self, costs: Floats, tolerance: float | None = None) -> Answer | None:
        """Ask the solver for a point of least cost."""
        matrix, b, low, high = self.floats
        sums = distribution_sums(self.distributions, len(self.low)) if self.distributions else None
        return ask_solver(costs, matrix, b, sums, np.column_stack((low, high)), tolerance)


# Asking


def solver_float(value: Fraction) -> float:
    """Round to a float that a solver can work with; only its search depends on it."""
    return float(max(min(value, LARGEST), -LARGEST))


def solver_floats(values: Sequence[Fraction]) -> Floats:
    """Numbers as floats that a solver can work with."""
    return np.array([solver_float(v) for v in values], dtype=np.float64)


def distribution_sums(distributions: Sequence[range], variables: int) -> tuple[Any, Floats]:
    """The equations that distributions sum to 1, in floats."""
    from scipy.sparse import csr_array

    owner = np.repeat(np.arange(len(distributions)), [len(part) for part in distributions])
    place = np.array([j for part in distributions for j in part])
    return csr_array((np.ones(len(place)), (owner, place)), shape=(len(distributions), variables)), np.ones(len(distributions))


def solve_with_highs(c: Floats, a: Any, b: Floats, equal: tuple[Any, Floats] | None, bounds: Any, tolerance: float | None) -> Answer | None:
    """Minimise c·x over A x ≤ b by HiGHS; returns x and the multipliers of the rows, or nothing. Nothing that it says is believed."""
    import warnings

    from scipy.optimize import linprog

    options: dict[str, Any] = {"A_eq": equal[0], "b_eq": equal[1]} if equal else {}
    if tolerance is not None:
        options["options"] = {"primal_feasibility_tolerance": tolerance, "dual_feasibility_tolerance": tolerance}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = linprog(c, A_ub=a, b_ub=b, bounds=bounds, method="highs-ds", **options)
    return (np.asarray(found.x), -np.asarray(found.ineqlin.marginals)) if found.status == 0 else None


def ask_solver(
    c: Floats, a: Any, b: Floats, equal: tuple[Any, Floats] | None, bounds: Any, tolerance: float | None = None
) -> Answer | None:
    """Ask the solver, and drop answers that are not even numbers of the right shape; None means that it was not solved."""
    try:
        found = solve_with_highs(c, a, b, equal, bounds, tolerance)
        if found is None:
            return None
        point, multipliers = (np.asarray(part, dtype=np.float64) for part in found)
    except Exception:  # whatever a solver does, it only may cost tightness
        return None
    if point.shape != (len(c),) or multipliers.shape != (len(b),):
        return None
    most = float(LARGEST)
    return (point, multipliers) if (np.abs(point) <= most).all() and (np.abs(multipliers) <= most).all() else None


def rounded_multipliers(multipliers: Floats, grid: int = ROUNDING) -> dict[int, Fraction]:
    """Multipliers as rationals ≥ 0 on a dyadic grid."""
    found = {}
    for i in np.flatnonzero((multipliers > 0) & np.isfinite(multipliers)).tolist():
        value = Fraction(round(Fraction(float(multipliers[i])) * grid), grid)
        if value:
            found[i] = value
    return found


# Solving again, exactly


def dot(left: Sequence[Fraction], right: Sequence[Fraction]) -> Fraction:
    """Σ a·b, exactly."""
    return sum((a * b for a, b in zip(left, right, strict=True) if a), ZERO)


def eliminate(
    equations: Sequence[tuple[Mapping[int, Fraction], Fraction]],
    guess: Mapping[int, Fraction],
    needed: int | None = None,
    most_bits: float = inf,
) -> dict[int, Fraction] | None:
    """Solve sparse linear equations in rationals; unknowns that they leave free keep their guess.

    None if one of the first `needed` (all by default) contradicts those before it, later ones that do are left out; or if an
    unknown that they leave free has no guess; or if a number on the way is longer than `most_bits`.

    Equations that fill up, so that more numbers are changed than a full matrix holds, are solved by `solve_by_lifting` where they have
    one solution: it is the same one, and nothing on the way to it is long. Where they do not, whoever gave `most_bits` gets None.
    """
    needed = len(equations) if needed is None else needed
    unknowns = len({j for given, _ in equations for j in given})
    left: float = max(PATIENCE, min(unknowns, MOST_UNKNOWNS) ** 2)
    pivots: list[tuple[int, dict[int, Fraction], Fraction]] = []
    where: dict[int, int] = {}
    for number, (given, bound) in enumerate(equations):
        terms, rest = {j: a for j, a in given.items() if a}, bound
        while terms:
            known = [where[j] for j in terms if j in where]
            if not known:
                break
            unknown, others, value = pivots[min(known)]
            left -= len(others)
            if left < 0:
                alone = _only_solution(equations, most_bits)
                if alone is not None:
                    return {**guess, **alone}
                if most_bits < inf:
                    return None
                left = inf
            factor = terms.pop(unknown)
            rest -= factor * value
            for j, a in others.items():
                terms[j] = terms.get(j, ZERO) - factor * a
                if not terms[j]:
                    del terms[j]
        if not terms:
            if rest and number < needed:
                return None
            continue
        pivot = min(terms, key=lambda j: (_bits(terms[j]), j))
        factor = terms.pop(pivot)
        where[pivot] = len(pivots)
        others, value = {j: a / factor for j, a in terms.items()}, rest / factor
        if most_bits < inf and any(
            max(a.numerator.bit_length(), a.denominator.bit_length()) > most_bits for a in (value, *others.values())
        ):
            return None
        pivots.append((pivot, others, value))
    solved = dict(guess)
    if any(j not in where and j not in guess for _, others, _ in pivots for j in others):
        return None
    for unknown, others, value in reversed(pivots):
        solved[unknown] = value - sum((a * solved[j] for j, a in others.items()), ZERO)
    return solved


def _only_solution(equations: Sequence[tuple[Mapping[int, Fraction], Fraction]], most_bits: float) -> dict[int, Fraction] | None:
    """The solution of equations that have one and no other; None where that is not so, or not quickly found."""
    unknowns = sorted({j for terms, _ in equations for j, a in terms.items() if a})
    rows, right = [], []
    for terms, bound in equations:
        scale = lcm(bound.denominator, *(a.denominator for a in terms.values()))
        rows.append([int(terms[j] * scale) if j in terms else 0 for j in unknowns])
        right.append(int(bound * scale))
    found = solve_by_lifting(rows, right, most_bits)
    return None if found is None else dict(zip(unknowns, found, strict=True))


def _bits(value: Fraction) -> int:
    return value.numerator.bit_length() + value.denominator.bit_length()
