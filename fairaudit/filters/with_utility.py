"""The best filter for a known utility and every policy: least expected distortion, as one linear program.

That no policy behind a filter exceeds R* is convex in the filter: by T13, Σ max_u [p(o,u) − R*·q(o,u)] ≤ 0 for each ordered pair of groups,
within each context or over the releases of all contexts, and p and q are linear in M. The filter is found in floating point, repaired, and
measured by T13.
"""

from __future__ import annotations

from dataclasses import replace

from fairaudit.errors import InputError
from fairaudit.exact.rationals import Number
from fairaudit.filters.calibration_with_utility import calibrate_utility, every_policy, why_not_for_every_policy
from fairaudit.filters.choice import best_design
from fairaudit.filters.design_result import Design, checked_design
from fairaudit.filters.policy_sums import sums_of_tables
from fairaudit.filters.problem import MAX_GROUPS, Distortion, read_problem
from fairaudit.filters.responses import alphabets
from fairaudit.filters.search import filters_by_program
from fairaudit.filters.targets import QUANTITIES, read_cap, read_target, require_target_or_cap
from fairaudit.filters.with_policy import joint_response
from fairaudit.measures.limits import ALONE, Quantity, without_bare_limits
from fairaudit.model.mechanism import RandomizedResponse
from fairaudit.model.policy import Policy, Population
from fairaudit.model.utility import Utility, Values
from fairaudit.theorems.assumptions import FRESH, POPULATION
from fairaudit.theorems.bound import ANY_POLICY
from fairaudit.theorems.t13 import greatest_ratio
from fairaudit.theorems.t13_tables import utility_tables


@without_bare_limits(ALONE)
def design_utility(
    policy: Policy,
    utility: Utility | Values,
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    quantity: Quantity = "local",
    population: Population | None = None,
    distortion: Distortion | None = None,
    max_epsilon: Number | None = None,
    max_exp_epsilon: Number | None = None,
) -> Design:
    """Find the filter of least expected distortion behind which no policy exceeds a target, for a known utility.

    The filter acts on the groups of the policy as they are, as in `design`. Contexts are not filtered.

    Parameters
    ----------
    policy : Policy
        Which groups, contexts and decisions there are; what it decides does not matter.
    utility : Utility or mapping
        g; it may depend on decision, context and group, and is needed for every decision in every context.
    max_ratio, max_log, distortion, max_epsilon, max_exp_epsilon
        As in `design`.
    quantity : {"local", "global"}
        Whether the target is for R, within contexts, or R̄, of group means in the population.
    population : array_like, mapping or Law, optional
        P(x,a) as in `Policy.behind`, for the distortion and for R̄.

    Returns
    -------
    Design
        The filter, with the greatest ratio of any policy behind it; scope "any policy behind this filter". Source: T13.

    Raises
    ------
    InputError
        As in `design`, if g is not given for some decision, and if the linear program is too large.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> found = fa.design_utility(policy, {"hire": 3, "pass": 1}, max_ratio="7/5", population=[[1, 3]])
    >>> found.truth_kept, found.achieved
    (Fraction(4, 5), Fraction(7, 5))
    """
    target = read_target(max_ratio, max_log)
    cap = read_cap(max_epsilon, max_exp_epsilon)
    require_target_or_cap(target, cap)
    if quantity not in QUANTITIES:
        raise InputError(f"quantity={quantity!r} is not accepted; local or global is")
    law = policy.law
    if not law.complete:
        raise InputError("the policy lacks a law for some group in some context; a design needs every group in every context")
    count = len(law.groups)
    if count > MAX_GROUPS:
        raise InputError(f"the policy has {count} groups; a design accepts up to {MAX_GROUPS}")
    hidden, table = every_policy(policy, utility, RandomizedResponse(law.groups, exp_epsilon=1), population)
    mass = hidden.mass
    weights = [1] * count if mass is None else [sum(mass[i::count]) for i in range(count)]
    problem = read_problem(law.groups, law.columns.group, weights, distortion, target, cap)
    tables = utility_tables(hidden, table, quantity)
    least = greatest_ratio(hidden, table, quantity)
    if tables is None or least is None:
        raise InputError("no two groups are compared, so that there is no ratio to design for")
    response = [RandomizedResponse(law.groups, exp_epsilon=1)]
    if target is not None:
        problem = replace(problem, sums=sums_of_tables(tables, target))
        if least.value > target:
            why = why_not_for_every_policy(least.value, quantity)
            found = best_design(problem, [], lambda _: ([], None, why))
            return replace(found, quantity=quantity, scope=ANY_POLICY)
        if target > 1:
            calibrated = calibrate_utility(policy, utility, max_ratio=target, quantity=quantity, population=population)
            joint = joint_response(problem) if cap is not None or len(alphabets(policy)) > 1 else None
            response += [mechanism for mechanism in (joint, calibrated.mechanism) if mechanism is not None]
    if cap is not None:
        response.append(RandomizedResponse(law.groups, exp_epsilon=cap))
    found = best_design(problem, response, filters_by_program)
    if found.mechanism is not None:
        measured = greatest_ratio(replace(hidden, group_filter=found.mechanism), table, quantity)
        found = replace(found, achieved=measured.value if measured else None)
    assumptions = (FRESH, POPULATION) if quantity == "global" else (FRESH,)
    return checked_design(replace(found, quantity=quantity, scope=ANY_POLICY, assumptions=assumptions))
