"""The cheapest of the filters that were proposed and meet every constraint exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import inf

from fairaudit.errors import InputError
from fairaudit.exact.linear_programs import MOST_BITS
from fairaudit.filters.design_result import Design
from fairaudit.filters.one_k import tables_over_k
from fairaudit.filters.problem import Problem
from fairaudit.filters.program import (
    deepest_table,
    dual_bound,
    entry_prices,
    exact_vertex,
    linear_program,
    repaired_filter,
    solve_in_floats,
    why_infeasible,
)
from fairaudit.filters.responses import GRID
from fairaudit.model.mechanism import Constant, Identity, Mechanism, RandomizedResponse
from fairaudit.privacy.epsilon_delta import exp_epsilon

MAX_MODEL_FREE = 16

EASY_BITS = 256

GAP = 10**9


# Choosing among filters


def best_design(problem: Problem, response: Sequence[Mechanism]) -> Design:
    """The cheapest of everything that was proposed and meets the constraints exactly; `response` is what it is compared with."""
    proposed = [(mechanism, "randomized response") for mechanism in response]
    proposed += [(_constant(problem), "the same release for everybody")]
    lower: Fraction | None = None
    reason = ""
    symmetric = _symmetric(problem)
    if symmetric is not None:
        proposed.insert(0, (symmetric, "randomized response, exactly solved"))
        lower = problem.cost(*problem.rows_of(symmetric))
    else:
        found, lower, reason = searched_filters(problem)
        proposed = [*found, *proposed]
    figures: list[tuple[Fraction, Fraction, int, Mechanism, str]] = []
    for mechanism, method in proposed:
        rows, bottom = problem.rows_of(mechanism)
        if problem.holds(rows, bottom):
            figures.append((problem.cost(rows, bottom), -problem.truth(rows, bottom), len(figures), mechanism, method))
    compared = min(((c, -t) for c, t, _, m, _ in figures if any(m is r for r in response)), default=(None, None))
    answer = Design(
        problem.target, problem.cap, False, None, None, None, lower, None, inf, (), "", "", (), compared[0], compared[1], reason
    )
    if not figures:
        return answer
    cost, lie, _, mechanism, method = min(figures, key=lambda entry: entry[:3])
    return replace(
        answer,
        feasible=True,
        mechanism=mechanism if mechanism.columns else replace(mechanism, columns=problem.columns),
        distortion=cost,
        truth_kept=-lie,
        exp_epsilon=exp_epsilon(mechanism),
        method=method,
        reason="",
    )


def _constant(problem: Problem) -> Mechanism:
    totals = [sum(column) for column in zip(*problem.prices, strict=True)]
    return replace(Constant(problem.labels, problem.labels[totals.index(min(totals))]), columns=problem.columns)


def _symmetric(problem: Problem) -> Mechanism | None:
    """Randomized response in closed form, where all groups look alike: any filter can then be averaged over all renamings of the groups."""
    size = problem.size
    off = {problem.prices[a][j] for a in range(size) for j in range(size) if a != j}
    on = {problem.prices[a][a] for a in range(size)}
    if (problem.gains and problem.target is not None) or len(off) > 1 or len(on) > 1 or min(on) > min(off):
        return None
    factor: Fraction | None = problem.cap
    if problem.target is not None and problem.level is not None:
        part = problem.level * (problem.target - 1)
        options = [problem.target, (1 - problem.level) / (1 - problem.level * problem.target)]
        options += [(1 + (size - 1) * part) / (1 - part)] if part < 1 else []
        factor = max(options) if factor is None else min(factor, max(options))
    if factor is None:
        return replace(Identity(problem.labels), columns=problem.columns)
    return replace(RandomizedResponse(problem.labels, exp_epsilon=factor), columns=problem.columns)


# The linear program and what is made of its answer


def searched_filters(problem: Problem) -> tuple[list[tuple[Mechanism, str]], Fraction | None, str]:
    """Filters by linear programming, an exact lower bound on the distortion where there is one, and why nothing was found."""
    if problem.level is not None and problem.target is not None:
        return _searched_over_k(problem, problem.level, problem.target), None, ""
    program = linear_program(problem)
    prices = entry_prices(problem)
    solved = solve_in_floats(program, prices)
    if solved is None:
        deepest = deepest_table(problem)
        inside = deepest is not None and problem.holds(deepest, GRID)
        return (
            ([(problem.mechanism(deepest, GRID), "linear program, well inside the constraints")], None, "")
            if inside and deepest
            else ([], None, why_infeasible(problem))
        )
    values, duals = solved
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


# Without a policy: one k for all ordered pairs


def _searched_over_k(problem: Problem, level: Fraction, target: Fraction) -> list[tuple[Mechanism, str]]:
    """The best filters that one k certifies. At the ends of its range, R* and (1 − t·R*)/(1 − t), k is a cap on ε."""
    least = (1 - level * target) / (1 - level)
    widest = max(target, 1 / least)
    capped = replace(problem, target=None, level=None, cap=widest if problem.cap is None else min(widest, problem.cap))
    found, _, _ = searched_filters(capped)
    if target == 1:
        return found
    if problem.size > MAX_MODEL_FREE:
        raise InputError(
            f"a design without a policy accepts up to {MAX_MODEL_FREE} groups that differ in frequency or distortion, not {problem.size}; "
            "with equal frequencies and the default distortion there is no such limit"
        )
    tables = tables_over_k(problem, level, target, least)
    for values in tables:
        repaired = repaired_filter(problem, values)
        if repaired is not None:
            found.append((repaired, "linear program for one common k, rounded and mixed until exact"))
    return found
