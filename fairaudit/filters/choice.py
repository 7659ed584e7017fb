"""The cheapest of the filters that were proposed and meet every constraint exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import inf

from fairaudit.filters.design_result import Design
from fairaudit.filters.problem import Problem
from fairaudit.filters.search import Search
from fairaudit.model.mechanism import Constant, Identity, Mechanism, RandomizedResponse
from fairaudit.privacy.epsilon_delta import exp_epsilon


def best_design(problem: Problem, response: Sequence[Mechanism], search: Search) -> Design:
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
        found, lower, reason = search(problem)
        proposed = [*found, *proposed]
    figures: list[tuple[Fraction, Fraction, int, Mechanism, str]] = []
    for mechanism, method in proposed:
        rows, bottom = problem.rows_of(mechanism)
        if problem.holds(rows, bottom):
            figures.append((problem.cost(rows, bottom), -problem.truth(rows, bottom), len(figures), mechanism, method))
    compared = min(((c, -t) for c, t, _, m, _ in figures if any(m is r for r in response)), default=(None, None))
    answer = Design(
        target=problem.target,
        max_exp_epsilon=problem.cap,
        feasible=False,
        mechanism=None,
        distortion=None,
        truth_kept=None,
        lower_bound=lower,
        achieved=None,
        exp_epsilon=inf,
        multipliers=(),
        method="",
        scope="",
        assumptions=(),
        response_distortion=compared[0],
        response_truth_kept=compared[1],
        reason=reason,
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
