"""Linear-fractional programs, one per ordered pair of groups, enclosed between exact ends.

Solved by HiGHS (Charnes–Cooper), whose vertex and multipliers are solved again in rationals. For multipliers y ≥ 0 of the
constraints A v ≤ b and a box around the variables v, every R with

    F(R) = Σ_j max over the box of c_j(R)·v_j + y·b ≤ 0,   c(R) = p − R·q − y·A,

bounds p·v/q·v, however the multipliers were found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import HUGE
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.exact.linear_programs import (
    Answer,
    LinearProgram,
    ask_solver,
    dot,
    eliminate,
    rounded_multipliers,
    solver_float,
    solver_floats,
)
from fairaudit.worst.attained import ratio_of_means

TOLERANCES = (1e-9, 1e-7, 1e-11, 1e-5)
"""What counts as tight, tried in turn: what solvers reach as a rule, then looser, for long rows, and stricter, for near ties."""


@dataclass(frozen=True, eq=False)
class FractionalProgram:
    """Maximise p·v/q·v over a linear program, whose variables and rows carry their numbers in the class."""

    linear: LinearProgram
    variables: list[int]
    numbers: list[int]
    p: list[Fraction]
    q: list[Fraction]
    floor: int | None
    """The row that keeps q·v at the floor."""
    cap: Extended

    def ratio(self, point: Sequence[Fraction]) -> Extended:
        """The ratio at a point."""
        return ratio_of_means(dot(self.p, point), dot(self.q, point))

    def with_rows(self, rows: Sequence[tuple[list[tuple[int, Fraction]], Fraction]]) -> FractionalProgram:
        """The same with further rows, which have no number."""
        linear = replace(self.linear, rows=[*self.linear.rows, *rows])
        return replace(self, linear=linear, numbers=[*self.numbers, *(-1 for _ in rows)])

    @cached_property
    def floats(self) -> tuple[Any, Floats, Floats, Floats, Floats, Floats]:
        """A (sparse), b, p, q and the box, in floats."""
        matrix, b, low, high = self.linear.floats
        return matrix, b, solver_floats(self.p), solver_floats(self.q), low, high

    def excess(self, multipliers: Mapping[int, Fraction], ratio: Fraction) -> tuple[Fraction, Fraction]:
        """F(ratio) and its slope to the right."""
        rest, total = self.linear.reduced({j: p - ratio * q for j, (p, q) in enumerate(zip(self.p, self.q, strict=True))}, multipliers)
        slope = ZERO
        for j, (q, low, high) in enumerate(zip(self.q, self.linear.low, self.linear.high, strict=True)):
            value = rest[j]
            at = high if value > 0 or (value == 0 and q < 0) else low
            total += value * at
            slope -= q * at
        return total, slope


@dataclass(frozen=True)
class Enclosed:
    """What is known of a pair: R_hi with its multipliers (by row), and an exact point of the class, if one was found."""

    upper: Extended
    multipliers: dict[int, Fraction]
    point: list[Fraction] | None
    empty: bool = False


@dataclass(frozen=True, eq=False)
class _Answer:
    """What the solver said: a point, the multipliers of the rows, and the point in the coordinates of Charnes and Cooper."""

    point: Floats
    multipliers: Floats
    stretched: Floats | None = None
    """w = (v − low)·s, then s = 1/q·v."""


def _charnes_cooper(program: FractionalProgram) -> _Answer | None:
    """Solve the fractional program in w = (v − low)·s and s = 1/q·v, which is measured in units of 1/floor."""
    from scipy.sparse import csr_array, diags_array, hstack, vstack

    matrix, b, p, q, low, high = program.floats
    n = len(p)
    width = high - low
    unit = 1.0 if program.floor is None else max(solver_float(-program.linear.rows[program.floor][1]), 1e-13)
    top = hstack([matrix, csr_array(((matrix @ low - b) / unit)[:, None])])
    sides = hstack([diags_array(np.ones(n)), csr_array((-width / unit)[:, None])])
    one = csr_array(np.append(q, q @ low / unit)[None, :])
    a = vstack([top, sides], format="csr")
    found = ask_solver(-np.append(p, p @ low / unit), a, np.zeros(a.shape[0]), (one, np.ones(1)), (0, None))
    if found is None or found[0][-1] <= 0:
        return None
    stretched = np.append(found[0][:-1], found[0][-1] / unit)
    point = np.nan_to_num(low + stretched[:-1] / stretched[-1], nan=0.0, posinf=HUGE, neginf=-HUGE)
    return _Answer(np.clip(point, low, high), found[1][: len(b)], stretched)


def _stretched_vertex(program: FractionalProgram, answer: _Answer, tolerance: float) -> list[Fraction] | None:
    """As `_vertex`, in the coordinates of Charnes and Cooper, where values far below γ can still be told apart."""
    if answer.stretched is None:
        return None
    matrix, b, _, _, low, high = program.floats
    w, s = answer.stretched[:-1], float(answer.stretched[-1])
    n, scale = len(w), tolerance * max(float(np.abs(w).max()), 1e-300)
    if not np.isfinite(scale):
        return None
    at_low, at_high = w <= scale, (high - low) * s - w <= scale
    equations: list[tuple[dict[int, Fraction], Fraction]] = [
        ({**dict(enumerate(program.q)), n: dot(program.q, program.linear.low)}, ONE),
        *(({j: ONE}, ZERO) for j in np.flatnonzero(at_low).tolist()),
        *(({j: ONE, n: program.linear.low[j] - program.linear.high[j]}, ZERO) for j in np.flatnonzero(at_high & ~at_low).tolist()),
    ]
    if len(b):
        slack = (b - matrix @ low) * s - matrix @ w
        size = np.abs(b - matrix @ low) * s + abs(matrix) @ np.abs(w) + 1e-300
        tight = np.flatnonzero(slack <= tolerance * size)
        for i in tight[np.argsort(-answer.multipliers[tight], kind="stable")].tolist():
            terms, bound = program.linear.rows[i]
            equations.append(({**dict(terms), n: sum((a * program.linear.low[j] for j, a in terms), -bound)}, ZERO))
    guess = {j: Fraction(float(v)) for j, v in enumerate(answer.stretched)}
    solved = eliminate(equations, guess)
    if solved is None or solved[n] <= 0:
        return None
    values = [lo + solved[j] / solved[n] for j, lo in enumerate(program.linear.low)]
    return values if program.linear.feasible(values) else None


def answer_at_ratio(program: FractionalProgram, ratio: Extended) -> Answer | None:
    """Maximise p·v − ratio·q·v; multipliers of an optimum of at most 0 prove the ratio."""
    matrix, b, p, q, low, high = program.floats
    factor = solver_float(ratio) if isinstance(ratio, Fraction) else HUGE
    return ask_solver(-(p - factor * q), matrix, b, None, np.column_stack((low, high)))


def least_proved_ratio(
    program: FractionalProgram, multipliers: Mapping[int, Fraction], start: Fraction
) -> tuple[Extended, dict[int, Fraction]]:
    """Least R ≥ start that multipliers prove, exactly: F is convex and piecewise linear, so Newton's method from the left ends there.

    Where there is a floor, its multiplier may also grow with R, which proves some R whatever the multipliers are.
    """
    best: tuple[Extended, dict[int, Fraction]] = (inf, {})
    ratio = start
    for _ in range(len(program.p) + 2):
        total, slope = program.excess(multipliers, ratio)
        if total <= 0:
            best = (ratio, dict(multipliers))
            break
        if slope >= 0:
            break
        ratio -= total / slope
    if program.floor is not None and best[0] != start:
        others = {i: y for i, y in multipliers.items() if i != program.floor}
        k = start - multipliers.get(program.floor, ZERO)
        total, _ = program.excess(others, k)
        grown = max(ZERO, total) / -program.linear.rows[program.floor][1]
        if k + grown < start:
            grown = start - k
        if k + grown < best[0]:
            best = (k + grown, {**others, program.floor: grown})
    return best


def _vertex(program: FractionalProgram, point: Floats, multipliers: Floats, tolerance: float) -> list[Fraction] | None:
    """Solve the constraints that look tight exactly; None if the result is not in the class."""
    matrix, b, _, _, low, high = program.floats
    width = np.maximum(high - low, 1e-300)
    at_low, at_high = (point - low) <= tolerance * width, (high - point) <= tolerance * width
    values = [
        lo if is_low else hi if is_high else Fraction(v)
        for lo, hi, is_low, is_high, v in zip(
            program.linear.low, program.linear.high, at_low.tolist(), at_high.tolist(), point.tolist(), strict=True
        )
    ]
    free = {j for j, (one, other) in enumerate(zip(at_low.tolist(), at_high.tolist(), strict=True)) if not (one or other)}
    if len(b):
        slack = b - matrix @ point
        scale = np.abs(b) + abs(matrix) @ np.maximum(np.abs(low), np.abs(high)) + 1e-300
        tight = np.flatnonzero(slack <= tolerance * scale)
        equations = []
        for i in tight[np.argsort(-multipliers[tight], kind="stable")].tolist():
            terms, bound = program.linear.rows[i]
            rest = bound - sum((a * values[j] for j, a in terms if j not in free), ZERO)
            equations.append(({j: a for j, a in terms if j in free}, rest))
        solved = eliminate(equations, {j: values[j] for j in free})
        if solved is None:
            return None
        for j, value in solved.items():
            values[j] = value
    return values if program.linear.feasible(values) else None


def _mixed(program: FractionalProgram, point: Floats, interior: Sequence[Fraction]) -> list[Fraction]:
    """Move a point of floats towards a point that is exactly in the class, until it is in the class too."""
    values = program.linear.clipped(point)
    share = ZERO
    for i in range(len(program.linear.rows)):
        miss = -program.linear.slack(i, values)
        if miss > 0:
            share = max(share, miss / (miss + program.linear.slack(i, interior)))
    return [v + share * (w - v) for v, w in zip(values, interior, strict=True)]


def _exact_multipliers(
    program: FractionalProgram, point: Sequence[Fraction], multipliers: Floats, ratio: Fraction
) -> Iterator[dict[int, Fraction]]:
    """Yield multipliers that are exactly complementary to a point, first on the rows that the solver used, then on all tight ones.

    They make the coefficients of variables inside their box exactly zero, and, where that leaves a choice, other coefficients that the
    solver made nearly zero.
    """
    inner = [j for j, (low, v, high) in enumerate(zip(program.linear.low, point, program.linear.high, strict=True)) if low < v < high]
    tight = [i for i in range(len(program.linear.rows)) if program.linear.slack(i, point) == 0]
    guess = rounded_multipliers(multipliers)
    used = [i for i in tight if i in guess]
    matrix, _, p, q, _, _ = program.floats
    left = np.abs(p - solver_float(ratio) * q - matrix.T @ multipliers)
    left[inner] = np.inf
    close = np.flatnonzero(left <= 1e-9 * max(1.0, solver_float(ratio)))
    wished = [*inner, *close[np.argsort(left[close], kind="stable")].tolist()]
    columns: dict[int, dict[int, Fraction]] = {j: {} for j in wished}
    wanted = set(tight)
    for i in wanted:
        for j, a in program.linear.rows[i][0]:
            if j in columns:
                columns[j][i] = a
    for rows in (used, tight):
        allowed = set(rows)
        equations = [({i: a for i, a in columns[j].items() if i in allowed}, program.p[j] - ratio * program.q[j]) for j in wished]
        solved = eliminate(equations, {i: guess.get(i, ZERO) for i in rows}, len(inner))
        if solved is not None and all(y >= 0 for y in solved.values()):
            yield {i: y for i, y in solved.items() if y}


def enclose(program: FractionalProgram, interior: list[Fraction] | None) -> Enclosed:
    """Enclose the greatest ratio of a program."""
    if program.cap == inf:
        ray = _ray(program)
        if ray is not None:
            return Enclosed(inf, {}, ray)
    answer = _charnes_cooper(program)
    if answer is None:
        found = answer_at_ratio(program, ONE)
        if found is None:
            return Enclosed(program.cap, {}, interior)
        answer = _Answer(*found)
    best = interior
    upper: Extended = inf
    proof: dict[int, Fraction] = {}
    for exact in _vertices(program, answer, interior):
        if best is None or program.ratio(exact) >= program.ratio(best):
            best = exact
        if program.ratio(best) == inf:
            return Enclosed(inf, {}, best)
        bound, found_proof = _prove(program, best, answer.multipliers)
        if bound < upper:
            upper, proof = bound, found_proof
        if upper == program.ratio(best):
            break
    else:
        bound, found_proof = _prove(program, best, answer.multipliers)
        if bound < upper:
            upper, proof = bound, found_proof
    return Enclosed(upper, proof, best) if upper <= program.cap else Enclosed(program.cap, {}, best)


def _vertices(program: FractionalProgram, answer: _Answer, interior: list[Fraction] | None) -> Iterator[list[Fraction]]:
    """Yield exact points of the class near the solver's: by rounding what looks tight, in two coordinates, and by mixing."""
    found = False
    for tolerance in TOLERANCES:
        exact = _vertex(program, answer.point, answer.multipliers, tolerance)
        if exact is not None:
            found = True
            yield exact
            break
    for tolerance in TOLERANCES:
        exact = _stretched_vertex(program, answer, tolerance)
        if exact is not None:
            found = True
            yield exact
            break
    if interior is not None and not found:
        yield _mixed(program, answer.point, interior)


def _prove(program: FractionalProgram, exact: list[Fraction] | None, multipliers: Floats) -> tuple[Extended, dict[int, Fraction]]:
    """Find the least proved R_hi: with exact multipliers first, then with rounded ones, then with those of another program."""
    attained = program.ratio(exact) if exact is not None else ONE
    if not isinstance(attained, Fraction):
        return inf, {}
    start = max(attained, ONE)
    best: tuple[Extended, dict[int, Fraction]] = (inf, {})
    if exact is not None and start == attained:
        for solved in _exact_multipliers(program, exact, multipliers, start):
            best = min(best, least_proved_ratio(program, solved, start), key=lambda e: e[0])
            if best[0] == start:
                return best
    best = min(best, least_proved_ratio(program, rounded_multipliers(multipliers), start), key=lambda e: e[0])
    if best[0] > start * (1 + Fraction(1, 10**9)):
        again = answer_at_ratio(program, start)
        if again is not None:
            best = min(best, least_proved_ratio(program, rounded_multipliers(again[1]), start), key=lambda e: e[0])
            for solved in refined_multipliers(program, again, start):
                best = min(best, least_proved_ratio(program, solved, start), key=lambda e: e[0])
    return best


def refined_multipliers(program: FractionalProgram, found: Answer, ratio: Fraction) -> Iterator[dict[int, Fraction]]:
    """Yield exact multipliers from the solution of a program at a fixed ratio."""
    for tolerance in TOLERANCES:
        exact = _vertex(program, found[0], found[1], tolerance)
        if exact is not None:
            yield from _exact_multipliers(program, exact, found[1], ratio)
            return


def _ray(program: FractionalProgram) -> list[Fraction] | None:
    """Find a point of the class at which q·v = 0 < p·v, exactly."""
    row = ([(j, q) for j, q in enumerate(program.q) if q], ZERO)
    wide = replace(program.with_rows([row]), floor=None)
    matrix, b, p, _, low, high = wide.floats
    found = ask_solver(-p, matrix, b, None, np.column_stack((low, high)))
    if found is None:
        return None
    for tolerance in TOLERANCES:
        point = _vertex(wide, np.clip(found[0], low, high), found[1], tolerance)
        if point is not None and program.ratio(point) == inf:
            return point
    return None


def phase_one(program: FractionalProgram) -> tuple[list[Fraction] | None, dict[int, Fraction] | None]:
    """Look for a point inside the class, or for multipliers that prove it empty."""
    from scipy.sparse import csr_array, hstack

    matrix, b, p, _, low, high = program.floats
    if not len(b):
        return list(program.linear.low), None
    a = hstack([matrix, csr_array(-np.ones((len(b), 1)))], format="csr")
    bounds = np.vstack((np.column_stack((low, high)), [[-np.inf, np.inf]]))
    found = ask_solver(np.append(np.zeros(len(p)), 1.0), a, b, None, bounds)
    if found is None:
        return None, None
    proof = rounded_multipliers(found[1])
    if program.linear.emptiness(proof) > 0:
        return None, proof
    values = program.linear.clipped(found[0][:-1])
    if program.linear.feasible(values):
        return values, None
    for tolerance in TOLERANCES:
        exact = _vertex(program, np.clip(found[0][:-1], low, high), found[1], tolerance)
        if exact is not None:
            return exact, None
    return None, None
