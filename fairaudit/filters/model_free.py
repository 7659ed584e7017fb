"""A good filter for every policy and every utility of a range.

Without a floor what a target asks is convex in the filter (T13), and the best filter is that of one linear program. At a declared floor τ
one k that serves all ordered pairs of rows makes the guarantee linear; for a utility from 0 to γ, with t = τ/γ, it is
H_k(M_a, M_a') ≤ t·(R* − k). Every k is sound; the search takes the best one. One k for each ordered pair can be better still: for
two groups, equally frequent, 0/1 distortion, t = 0.5 and R* = 1.4 a common k costs 0.375, and k = (0.6, 1.4) costs 0.357; that
set of filters is not convex, and is not searched.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number, at_least
from fairaudit.filters.calibration import calibrate_range, premises
from fairaudit.filters.choice import best_design
from fairaudit.filters.design_result import Design, checked_design
from fairaudit.filters.groups import Groups, Masses, read_attributes, read_masses
from fairaudit.filters.one_k import filters_by_one_k
from fairaudit.filters.policy_sums import sums_of_range
from fairaudit.filters.problem import MAX_GROUPS, Distortion, Problem, read_problem
from fairaudit.filters.targets import read_cap, read_target, require_target_or_cap
from fairaudit.measures.limits import ALONE, without_bare_limits
from fairaudit.model.mechanism import Mechanism, RandomizedResponse
from fairaudit.tables.values import Label
from fairaudit.theorems.t01 import floor_cap
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t13_range import UtilityRange, in_each_range, read_utility_range, t13_range


@without_bare_limits(ALONE)
def design_model_free(
    groups: Groups,
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    tau: Number = 0,
    gamma: Number = 1,
    g_min: Number = 0,
    lipschitz: Number = 0,
    population: Masses | None = None,
    distortion: Distortion | None = None,
    max_epsilon: Number | None = None,
    max_exp_epsilon: Number | None = None,
) -> Design:
    """Find a filter of small expected distortion that guarantees a target for every policy, or every one that keeps a floor.

    Without a floor above the least utility the filter is the best there is: K + (γ − K − m)·H_{R*}(M_a, M_a') ≤ m·(R* − 1) for each ordered
    pair of rows holds exactly for the filters behind which no policy exceeds the target, and is one linear program; where m = K = 0 it is
    a cap e^ε ≤ R* (T2). With a floor the search covers the filters that one k certifies for all ordered pairs of rows: a linear program
    for each k, on a grid and then by golden section. Every k is sound, and the filter is measured at the end by the exact T13. One k
    for each ordered pair can be better (see the module), and is not searched.

    Parameters
    ----------
    groups : int, sequence, or mapping of name to int or sequence
        Number or labels of the groups (tuples for several columns); for several attributes the filter acts on the joint tuples.
    max_ratio, max_log, distortion, max_epsilon, max_exp_epsilon
        As in `design`.
    tau, gamma : number or str
        Declared floor of every group's expected utility behind the filter (0 for none), and the greatest utility.
    g_min, lipschitz : number or str
        Least utility m, which every policy pays, and K, the greatest difference of utility between two groups for the same decision and
        context.
    population : mapping or sequence, optional
        P(a) up to a factor, by group or in the order of the groups; equally frequent by default.

    Returns
    -------
    Design
        The filter, for any policy behind it (that keeps the floor, where one is declared). With equally frequent groups and 0/1
        distortion it is randomized response, the best filter of all, with a floor of those that a common k certifies.

    Raises
    ------
    InputError
        As in `design`, and if `gamma` is below `tau` or `g_min`.

    Examples
    --------
    >>> found = design_model_free(2, max_ratio="1.4", tau="0.5")
    >>> found.distortion, found.achieved
    (Fraction(3, 8), Fraction(7, 5))
    >>> found = design_model_free(2, max_ratio="7/5", gamma=3, g_min=1)
    >>> found.truth_kept, found.achieved
    (Fraction(2, 3), Fraction(7, 5))
    >>> design_model_free(["a", "b", "c"], max_exp_epsilon=2).truth_kept
    Fraction(1, 2)
    """
    target = read_target(max_ratio, max_log)
    cap = read_cap(max_epsilon, max_exp_epsilon)
    require_target_or_cap(target, cap)
    floor, top, least = at_least("tau", tau, 0), at_least("gamma", gamma, 0), at_least("g_min", g_min, 0)
    if top == 0:
        raise InputError("gamma is 0; a utility that is always 0 treats everybody alike, and needs no filter")
    for name, value, number in (("tau", tau, floor), ("g_min", g_min, least)):
        if number > top:
            raise InputError(f"{name} is {shown(value)}, above gamma, which is {shown(gamma)}; at most the greatest utility is accepted")
    declared = read_utility_range(top, least, at_least("lipschitz", lipschitz, 0), floor if floor > least else 0)
    attributes = read_attributes(groups, MAX_GROUPS)
    labels = tuple(sum(parts, ()) for parts in product(*attributes.values()))
    if len(labels) > MAX_GROUPS:
        raise InputError(f"there are {len(labels)} joint groups; a design accepts up to {MAX_GROUPS}")
    columns = tuple(attributes) if isinstance(groups, Mapping) else ()
    problem = read_problem(labels, columns, read_masses(population, labels), distortion, target, cap)
    if target is not None and not _within_reach(target, declared):
        why = f"even a filter that hides everything misses the target, because the utility differs between groups by {declared.gap}"
        return best_design(replace(problem, sums=sums_of_range(len(labels), declared, target)), [], lambda _: ([], None, why))
    free = target is not None and (declared.tau * target >= top or not declared.span)
    if target is None or free:
        problem = replace(problem, target=None)
    elif declared.tau:
        problem = replace(problem, floored=declared)
    elif declared.m or declared.gap:
        problem = replace(problem, sums=sums_of_range(len(labels), declared, target))
    else:
        problem = replace(problem, cap=target if cap is None else min(cap, target), target=None)
    found = best_design(problem, _free_response(problem, target, attributes, declared), filters_by_one_k)
    if problem.floored is not None:
        found = replace(found, lower_bound=None)
    found = replace(found, target=target, max_exp_epsilon=cap)
    mechanism = found.mechanism
    if mechanism is None:
        return found
    if target is not None and declared.tau * target >= top:
        proof = floor_cap(top, floor, floor="declared")
        found = replace(found, reason="the floor alone keeps the ratio under the target, whatever the filter")
    elif declared.m or declared.gap or problem.floored:
        proof = t13_range(in_each_range(mechanism, [declared]), floored=problem.floored is not None)
    else:
        proof = t2(found.exp_epsilon)
    return checked_design(
        replace(found, achieved=proof.value, multipliers=proof.multipliers, scope=proof.scope, assumptions=premises(proof))
    )


def _within_reach(target: Fraction, declared: UtilityRange) -> bool:
    """Whether a filter that hides the group meets the target for every policy: if not, none does."""
    return declared.gap <= max(declared.m, declared.tau) * (target - 1) or declared.gamma <= declared.tau * target


def _free_response(
    problem: Problem, target: Fraction | None, attributes: Mapping[str, tuple[Label, ...]], declared: UtilityRange
) -> list[Mechanism]:
    """The calibrated randomized response, for each attribute and over the joint tuples, and the latter at the cap."""
    found = [RandomizedResponse(problem.labels, exp_epsilon=1)]
    if target is not None and target > 1:
        settings: list[Any] = [attributes, problem.labels] if len(attributes) > 1 else [attributes]
        for groups in settings:
            calibrated = calibrate_range(target, groups, declared)
            found += [calibrated.mechanism] if calibrated.mechanism is not None else []
    if problem.cap is not None:
        found.append(RandomizedResponse(problem.labels, exp_epsilon=problem.cap))
    return found
