"""Linear programs whose solver is asked and never believed.

Floats only search. What a solver says is checked for shape and finiteness, rounded to rationals, and solved again exactly; wrong
answers cost tightness, never truth.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import gcd
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import ZERO
from fairaudit.exact.rationals import common_denominator

ROUNDING = 2**44

LARGEST = Fraction(10) ** 200


def solver_float(value: Fraction) -> float:
    """Round to a float that a solver can work with; only its search depends on it."""
    return float(max(min(value, LARGEST), -LARGEST))


def dot(left: Sequence[Fraction], right: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(left, right, strict=True) if a), ZERO)


def solve_with_highs(c: Floats, a: Any, b: Floats, equal: tuple[Any, Floats] | None, bounds: Any) -> tuple[Floats, Floats] | None:
    """Minimise c·x over A x ≤ b by HiGHS; returns x and the multipliers of the rows, or nothing. Nothing that it says is believed."""
    import warnings

    from scipy.optimize import linprog

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            options: dict[str, Any] = {"A_eq": equal[0], "b_eq": equal[1]} if equal else {}
            found = linprog(c, A_ub=a, b_ub=b, bounds=bounds, method="highs-ds", **options)
    except (ValueError, ArithmeticError, RuntimeError):
        return None
    if found.status != 0 or found.x is None:
        return None
    return np.asarray(found.x, dtype=np.float64), -np.asarray(found.ineqlin.marginals, dtype=np.float64)


def ask_solver(c: Floats, a: Any, b: Floats, equal: tuple[Any, Floats] | None, bounds: Any) -> tuple[Floats, Floats] | None:
    """Ask the solver, and drop answers that are not even numbers of the right shape."""
    try:
        found = solve_with_highs(c, a, b, equal, bounds)
    except Exception:  # whatever a solver does, it only may cost tightness
        return None
    if found is None or len(found[0]) != len(c) or len(found[1]) != len(b):
        return None
    return found if np.isfinite(found[0]).all() and np.isfinite(found[1]).all() else None


def rounded_multipliers(multipliers: Floats) -> dict[int, Fraction]:
    """Multipliers as dyadic rationals ≥ 0."""
    found = {}
    for i in np.flatnonzero(multipliers > 0).tolist():
        value = Fraction(round(Fraction(float(multipliers[i])) * ROUNDING), ROUNDING)
        if value:
            found[i] = value
    return found


def eliminate(
    equations: Sequence[tuple[dict[int, Fraction], Fraction]], guess: Mapping[int, Fraction], needed: int | None = None
) -> dict[int, Fraction] | None:
    """Solve sparse linear equations in rationals; unknowns that they leave free keep their guess.

    None if one of the first `needed` (all by default) contradicts those before it; later ones that do are left out.
    """
    needed = len(equations) if needed is None else needed
    pivots: list[tuple[int, dict[int, Fraction], Fraction]] = []
    where: dict[int, int] = {}
    for number, (given, bound) in enumerate(equations):
        terms, rest = {j: a for j, a in given.items() if a}, bound
        while terms:
            known = [where[j] for j in terms if j in where]
            if not known:
                break
            unknown, others, value = pivots[min(known)]
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
        pivot = min(terms, key=lambda j: (terms[j].denominator.bit_length() + terms[j].numerator.bit_length(), j))
        factor = terms.pop(pivot)
        where[pivot] = len(pivots)
        pivots.append((pivot, {j: a / factor for j, a in terms.items()}, rest / factor))
    solved = dict(guess)
    for unknown, others, value in reversed(pivots):
        solved[unknown] = value - sum((a * solved[j] for j, a in others.items()), ZERO)
    return solved


Row = list[tuple[int, Fraction]]

MOST_BITS = 12_000


def solve_over_tables(
    costs: Sequence[float], matrix: Any, limits: Sequence[float], size: int, lower: Sequence[float]
) -> tuple[list[float], list[float]] | None:
    """Minimise over tables whose rows sum to 1 by the simplex method."""
    from scipy.optimize import linprog
    from scipy.sparse import csr_array

    square = size * size
    sums: Any = csr_array(
        (np.ones(square), (np.repeat(np.arange(size), size), np.arange(square))),
        shape=(size, len(costs)),
    )
    limit: Any = np.array(limits) if matrix is not None else None
    solved: Any = linprog(
        np.array(costs),
        A_ub=matrix,
        b_ub=limit,
        A_eq=sums,
        b_eq=np.ones(size),
        bounds=[(low, None) for low in lower],
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if solved.status != 0:
        return None
    duals = [-float(d) for d in solved.ineqlin.marginals] if matrix is not None else []
    return [float(v) for v in solved.x], duals


def solved_exactly(equations: Iterable[tuple[Row, Fraction]], count: int) -> list[Fraction] | None:
    """The one solution of linear equations, by elimination in integers; None if there is none, or more than one, or it is very long."""
    pivots: dict[int, list[int]] = {}
    for terms, value in equations:
        whole, _ = common_denominator([*((c.numerator, c.denominator) for _, c in terms), (value.numerator, value.denominator)])
        row = [0] * (count + 1)
        for (i, _), c in zip(terms, whole, strict=False):
            row[i] += c
        row[count] = whole[-1]
        for i, pivot in pivots.items():
            if row[i]:
                row = _eliminated(row, pivot, i)
        first = next((i for i in range(count) if row[i]), None)
        if first is None:
            if row[count]:
                return None
            continue
        for i, pivot in pivots.items():
            if pivot[first]:
                pivots[i] = _eliminated(pivot, row, first)
        pivots[first] = row
        if max(map(abs, row)).bit_length() > 4 * MOST_BITS:
            return None
    if len(pivots) < count:
        return None
    return [Fraction(pivots[i][count], pivots[i][i]) for i in range(count)]


def _eliminated(row: list[int], pivot: list[int], at: int) -> list[int]:
    """Subtract a multiple of the pivot row so that the entry vanishes; the result is divided by what is common."""
    common = gcd(row[at], pivot[at])
    up, down = pivot[at] // common, row[at] // common
    result = [up * v - down * w for v, w in zip(row, pivot, strict=True)]
    divisor = gcd(*result)
    return [v // divisor for v in result] if divisor > 1 else result
