"""Balls of utilities: bounded by a box around them, and attained by a conic solver's utility, moved until it is surely inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np

from fairaudit.errors import InputError
from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import log_enclosure
from fairaudit.exact.extended import ZERO
from fairaudit.model.utility_class import Ball, LinearRow
from fairaudit.worst.fractional_program import FractionalProgram
from fairaudit.worst.pair_programs import pair_program
from fairaudit.worst.ranking import ranked_pairs
from fairaudit.worst.reading import lay_out
from fairaudit.worst.result import WorstCase
from fairaudit.worst.search import LinearSearch
from fairaudit.worst.setting import Setting
from fairaudit.worst.whole_utility import Attained, attained_by


def _root_above(value: Fraction) -> Fraction:
    """Round the square root of a rational up."""
    scale = 2**96
    return Fraction(isqrt(value.numerator * scale * scale // value.denominator) + 1, scale)


def _reference(setting: Setting) -> dict[int, list[Fraction]]:
    """The reference of a ball by row of the utility."""
    law, ball = setting.law, setting.of.ball
    assert ball is not None  # noqa: S101 - only classes with a ball come here
    table = ball.reference.on(law)
    if table.law is not law:
        raise InputError("the reference of the ball names a decision that does not occur; leave it out")
    found: dict[int, list[Fraction]] = {}
    for place, cells in enumerate(setting.cells):
        for cell in cells:
            row = [Fraction(v, table.scale) for v in table.row(cell)]
            if min(row) <= 0 or (table.given is not None and not table.given[cell].all()):
                raise InputError("the reference of the ball is not positive for every decision; give it a positive value everywhere")
            if found.setdefault(place if setting.of.blind else cell, row) != row:
                raise InputError("the reference of the ball depends on the group, but the class is blind; set blind=False")
    return found


def _interval(centre: Fraction, ball: Ball) -> tuple[Fraction, Fraction]:
    """Ends between which a value stays when the divergence of the row is at most the radius, rounded outward.

    χ²: (g − g0)² ≤ r·g0. KL, with x = g/g0 − 1 and c = r/g0: (1 + x)·log(1 + x) − x is at least x²/(2 + 2x/3) for x ≥ 0, and x²/2 below.
    """
    if ball.divergence == "chi2":
        reach = _root_above(ball.radius * centre)
        return centre - reach, centre + reach
    c = ball.radius / centre
    return centre * (1 - _root_above(2 * c)), centre * (1 + c / 3 + _root_above(c * c / 9 + 2 * c))


def _divergence(values: Sequence[Fraction], centres: Sequence[Fraction], ball: Ball) -> Fraction:
    """Divergence of a row from the reference, rounded up."""
    if ball.divergence == "chi2":
        return sum(((g - g0) ** 2 / g0 for g, g0 in zip(values, centres, strict=True)), ZERO)
    total = ZERO
    for g, g0 in zip(values, centres, strict=True):
        total += g0 - g
        if g > g0:
            total += g * Fraction(log_enclosure((g / g0).as_integer_ratio())[1])
        elif 0 < g < g0:
            total -= g * Fraction(log_enclosure((g0 / g).as_integer_ratio())[0])
    return total


def conic_case(setting: Setting) -> WorstCase:
    """A ball: bounded by a box around it, and attained by the solver's utility, moved towards the reference until it is surely inside."""
    of, law = setting.of, setting.law
    if of.family is not None or of.ball is None:
        raise InputError("a ball and a family do not go together; give one")
    centres, ball = _reference(setting), of.ball
    rows = list(of.rows)
    for row, values in centres.items():
        x = setting.contexts[row] if of.blind else int(law.cell_context[row])
        a = None if of.blind else law.groups[setting.group_of[row]]
        for label, centre in zip(law.decisions, values, strict=True):
            low, high = _interval(centre, ball)
            rows += [LinearRow([(law.contexts[x], a, label, 1)], high), LinearRow([(law.contexts[x], a, label, -1)], -low)]
    outer = lay_out(law, replace(of, ball=None, rows=tuple(rows)), setting.quantity)
    box = LinearSearch(outer).run()
    best: Attained | None = None
    estimate = 1.0
    for _, _, block, pair in ranked_pairs(outer):
        program = pair_program(outer, block, pair)
        found = _conic_point(program, centres, ball, setting.n)
        if found is None:
            continue
        estimate = max(estimate, found[1])
        inside = _into_ball(program, found[0], centres, ball, setting.n)
        if inside is not None:
            attained = attained_by(outer, block, pair, program, inside)
            if best is None or attained.ratio > best.ratio:
                best = attained
    if best is None:
        raise InputError(
            "no utility that is exactly in the ball was found; the reference itself has to keep the floor and the other constraints"
        )
    return replace(
        box,
        utility_class=of,
        lower=best.ratio,
        witness=best.witness,
        method="conic",
        certified=False,
        estimate=estimate,
        values=best.rows,
        shown=None,
    )


def _conic_point(program: FractionalProgram, centres: Mapping[int, Sequence[Fraction]], ball: Ball, n: int) -> tuple[Floats, float] | None:
    """Solve the fractional program over the ball by Clarabel, in y = v·s and s = 1/q·v."""
    import warnings

    import cvxpy

    cp: Any = cvxpy
    matrix, b, p, q, low, high = program.floats
    y, s = cp.Variable(len(p)), cp.Variable(nonneg=True)
    constraints = [q @ y == 1, y >= low * s, y <= high * s]
    if len(b):
        constraints.append(matrix.toarray() @ y <= b * s)
    for row, values in centres.items():
        at = [program.variables.index(row * n + u) for u in range(n)]
        centre = np.array([float(v) for v in values])
        if ball.divergence == "chi2":
            spread = cp.quad_over_lin(cp.multiply(1 / np.sqrt(centre), y[at] - centre * s), s)
        else:
            spread = cp.sum(cp.kl_div(y[at], centre * s))
        constraints.append(spread <= float(ball.radius) * s)
    problem = cp.Problem(cp.Maximize(p @ y), constraints)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            problem.solve(solver=cp.CLARABEL)
    except (cp.SolverError, ValueError, ArithmeticError):
        return None
    if y.value is None or s.value is None or not s.value > 0 or not np.isfinite(y.value).all():
        return None
    return np.clip(y.value / s.value, low, high), float(problem.value)


def _into_ball(
    program: FractionalProgram, point: Floats, centres: Mapping[int, Sequence[Fraction]], ball: Ball, n: int
) -> list[Fraction] | None:
    """Mix a point with the reference until it is exactly in the ball and the linear constraints."""
    position = {v: j for j, v in enumerate(program.variables)}
    reference = list(program.linear.high)
    for row, values in centres.items():
        for u, value in enumerate(values):
            reference[position[row * n + u]] = value
    if not program.linear.feasible(reference):
        return None
    start = [
        min(max(Fraction(round(v * 2**40), 2**40), lo), hi)
        for v, lo, hi in zip(point.tolist(), program.linear.low, program.linear.high, strict=True)
    ]
    share = Fraction(0)
    for step in range(-36, 1):
        values = [v + share * (w - v) for v, w in zip(start, reference, strict=True)]
        near = all(
            _divergence([values[position[row * n + u]] for u in range(n)], centre, ball) <= ball.radius for row, centre in centres.items()
        )
        if near and program.linear.feasible(values):
            return values
        share = Fraction(2) ** step
    return reference
