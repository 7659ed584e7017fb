"""The best filter for a known policy: least expected distortion, found in floating point, repaired and measured exactly.

A filter M(ã|a) costs Σ P(a)·M(ã|a)·c(a,ã), by default the probability that a lie is released. For a known policy the target
E(x,a) ≤ R*·E(x,a') is linear in M, and so is a cap M(ã|a) ≤ e^ε·M(ã|a'): a linear program.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import gcd

from fairaudit.errors import InputError
from fairaudit.exact.rationals import Number, common_denominator
from fairaudit.filters.calibration_with_policy import calibrate_policy
from fairaudit.filters.choice import best_design
from fairaudit.filters.design_result import Design, checked_design
from fairaudit.filters.problem import MAX_GROUPS, Distortion, Problem, read_problem
from fairaudit.filters.responses import GRID
from fairaudit.filters.search import filters_by_program
from fairaudit.filters.targets import read_cap, read_target, require_target_or_cap
from fairaudit.measures.limits import ALONE, without_bare_limits
from fairaudit.measures.ratios import local_fairness
from fairaudit.model.mechanism import Constant, Identity, Mechanism, RandomizedResponse
from fairaudit.model.policy import Policy, Population
from fairaudit.model.utility import Utility, Values, known_utility
from fairaudit.theorems.assumptions import FRESH
from fairaudit.theorems.bound import THIS_LAW
from fairaudit.words import noun

MAX_ENTRIES = 2_000_000
"""Ordered pairs of groups over all contexts: each is an integer, and a coefficient of the linear program."""


@without_bare_limits(ALONE)
def design(
    policy: Policy,
    utility: Utility | Values,
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    population: Population | None = None,
    distortion: Distortion | None = None,
    max_epsilon: Number | None = None,
    max_exp_epsilon: Number | None = None,
) -> Design:
    """Find the filter of least expected distortion for a known policy.

    The filter acts on the groups of the policy as they are: where a group is a tuple of attributes, on the joint tuples, so that a product
    of filters is a special case. Contexts are not filtered.

    Parameters
    ----------
    policy : Policy
        The known policy; it needs a law for every group in every context.
    utility : Utility or mapping
        g; it may depend on the group, but then a target may be infeasible.
    max_ratio : number or str, optional
        Target R* ≥ 1 for R; one under 1 is least over greatest, so that 0.8 is 5/4.
    max_log : number or str, optional
        Target L* ≥ 0 for L, its natural logarithm. At most one of the two; none for a cap alone.
    population : array_like, mapping or Law, optional
        P(x,a) as in `Policy.behind`; only P(a) matters here. Without one, groups are equally frequent.
    distortion : mapping, table or callable, optional
        c(a,ã) ≥ 0: a mapping from (a, ã), in which pairs with ã = a may be left out and are 0; a square table in the order of the policy's
        groups; or a callable of two labels (texts, or tuples for several columns). By default 1 for a lie.
    max_epsilon : number or str, optional
        Cap on ε of the filter, in nats.
    max_exp_epsilon : number or str, optional
        The same as e^ε ≥ 1. At most one of the two.

    Returns
    -------
    Design
        The filter with its exact figures, or why there is none; scope "this law". Source: section 6 of docs/theory.md.

    Raises
    ------
    InputError
        If a number is out of range, neither target nor cap is given, or the distortion names unknown groups.

    Examples
    --------
    >>> policy = Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> found = design(policy, {"hire": 1}, max_ratio=2)
    >>> found.achieved, found.truth_kept, found.response_truth_kept < found.truth_kept
    (Fraction(2, 1), Fraction(23, 28), True)
    """
    target = read_target(max_ratio, max_log)
    cap = read_cap(max_epsilon, max_exp_epsilon)
    require_target_or_cap(target, cap)
    law = policy.law
    if not law.complete:
        raise InputError("the policy lacks a law for some group in some context; a design needs every group in every context")
    count = len(law.groups)
    if count > MAX_GROUPS or count * count * len(law.contexts) > MAX_ENTRIES:
        size = f"{count} {noun(count, 'group')} in {len(law.contexts)} {noun(len(law.contexts), 'context')}"
        raise InputError(f"the policy has {size}; a design accepts up to {MAX_GROUPS} groups, and fewer with many contexts")
    wanted = known_utility(policy.law, utility)
    mass = policy.behind(group=Identity(law.groups), population=population).mass
    weights = [1] * count if mass is None else [sum(mass[i::count]) for i in range(count)]
    problem = read_problem(law.groups, law.columns.group, weights, distortion, target, cap)
    problem = replace(problem, gains=policy_gains(policy, wanted))

    def measured(mechanism: Mechanism) -> Fraction | float:
        table = wanted.on(policy.behind(group=mechanism, population=population).law)
        found = local_fairness(table.law, table)
        return Fraction(1) if found is None else found.ratio

    found = best_design(problem, _policy_response(problem, policy, wanted), filters_by_program)
    if found.mechanism is not None:
        found = replace(found, achieved=measured(found.mechanism))
    return checked_design(replace(found, scope=THIS_LAW, assumptions=(FRESH,)))


def policy_gains(policy: Policy, utility: Utility) -> tuple[tuple[tuple[int, ...], ...], ...]:
    """Σ_u T(u|x,ã)·g(u,x,a) for each context, true group and released group; contexts in which all are 0 are left out."""
    law = policy.law
    count = len(law.groups)
    # Behind a filter that hides the group every decision that can follow has weight, so that a utility with gaps is refused here.
    table = utility.on(policy.behind(group=Constant(law.groups)).law)
    blocks = []
    for start in range(0, len(law.cell_context), count):
        rows = [law.row(start + j) for j in range(count)]
        whole, _ = common_denominator([(1, sum(row)) for row in rows])
        gains: list[list[int]] = []
        for a in range(count):
            if a and table.by_decision:
                gains.append(gains[0])
                continue
            values = table.row(start + a)[: len(law.decisions)]
            gains.append(
                [scale * sum(w * g for w, g in zip(row, values, strict=True) if w) for scale, row in zip(whole, rows, strict=True)]
            )
        common = gcd(*(v for row in gains for v in row))
        if common:
            blocks.append(tuple(tuple(v // common for v in row) for row in gains))
    return tuple(blocks)


def _policy_response(problem: Problem, policy: Policy, utility: Utility) -> list[Mechanism]:
    """The calibrated randomized response, and one over the joint tuples that is also held to the cap."""
    if problem.target == 1:
        return [RandomizedResponse(problem.labels, exp_epsilon=1)]
    found = [joint_response(problem)]
    if problem.target is not None:
        found.append(calibrate_policy(policy, utility, max_ratio=problem.target).mechanism)
    if problem.cap is not None:
        found.append(RandomizedResponse(problem.labels, exp_epsilon=problem.cap))
    return [mechanism for mechanism in found if mechanism is not None]


def joint_response(problem: Problem) -> Mechanism | None:
    """Randomized response over the labels that keeps as much as the constraints allow, by bisection on the grid."""
    size = problem.size

    def attempt(step: int) -> tuple[list[list[int]], int]:
        return [[step * (size - 1) if i == j else GRID - step for j in range(size)] for i in range(size)], GRID * (size - 1)

    low, high = -(-GRID // size), GRID + 1
    if not problem.holds(*attempt(low)):
        uniform = RandomizedResponse(problem.labels, exp_epsilon=1)
        return uniform if problem.holds(*problem.rows_of(uniform)) else None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if problem.holds(*attempt(middle)) else (low, middle)
    return problem.mechanism(*attempt(low))
