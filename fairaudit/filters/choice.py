"""The cheapest of the filters that were proposed and meet every constraint exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import inf

from fairaudit.exact.extended import ONE, Extended
from fairaudit.filters.calibration import calibrate_range
from fairaudit.filters.design_result import Design
from fairaudit.filters.problem import Problem
from fairaudit.filters.search import Search
from fairaudit.model.mechanism import Constant, Identity, Mechanism, RandomizedResponse
from fairaudit.privacy.epsilon_delta import exp_epsilon
from fairaudit.theorems.t13_range import UtilityRange


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
    factors: list[Extended] = [] if problem.cap is None else [problem.cap]
    if problem.target is not None and problem.floored is not None:
        factors.append(_floored_factor(size, problem.target, problem.floored))
    elif problem.target is not None and problem.sums:
        factor = _factor_for_sums(problem)
        if factor is None:
            return None
        factors.append(factor)
    factor = min(factors, default=inf)
    if factor == inf:
        return replace(Identity(problem.labels), columns=problem.columns)
    return replace(RandomizedResponse(problem.labels, exp_epsilon=factor), columns=problem.columns)


def _floored_factor(size: int, target: Fraction, declared: UtilityRange) -> Extended:
    """The greatest e^ε of randomized response whose guarantee for every policy that keeps a floor is at most the target."""
    if declared.m or declared.gap:
        return calibrate_range(target, size, declared).exp_epsilon if target > 1 else ONE
    level = declared.tau / declared.gamma
    part = level * (target - 1)
    options = [target, (1 - level) / (1 - level * target)]
    return max([*options, (1 + (size - 1) * part) / (1 - part)] if part < 1 else options)


def _factor_for_sums(problem: Problem) -> Extended | None:
    """The greatest e^ε of randomized response that keeps the sums of every ordered pair of groups, if these are alike; else None.

    They are where all pairs have one block with one better decision, worth the same to both groups: H_{R*} ≤ c.
    """
    size, target = problem.size, problem.target
    (blocks, room), *others = {(part.blocks, part.room) for part in problem.sums}
    if others or len(problem.sums) < size * (size - 1) or [len(better) for better in blocks] != [1] or room < 0 or target is None:
        return None
    ((worth, lost),) = blocks[0]
    if lost != target * worth:
        return None
    keep = ((size - 1) * Fraction(room, worth) + target) / (size - 1 + target)
    return keep * (size - 1) / (1 - keep) if keep < 1 else inf
