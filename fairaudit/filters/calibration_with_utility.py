"""The keep probability for a known utility and every policy: T13 at the very filter.

Less truth is more privacy: a release with a smaller keep probability, from one over the number of values on, is that of the greater one
released once more, so that whatever a policy does behind it another does behind the greater. The greatest ratio over all policies
therefore does not fall as the keep probabilities grow, for utilities of any dependence, within contexts and of group means.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import Number
from fairaudit.filters.calibration import Calibration, best_tilt, climb, greatest_keep
from fairaudit.filters.responses import ResponseLine, Split, alphabets
from fairaudit.filters.targets import calibration_target, ratio_and_log
from fairaudit.measures.limits import ALONE, Quantity, without_bare_limits
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.policy import Deployment, Policy, Population
from fairaudit.model.utility import Utility, UtilityTable, Values, known_utility
from fairaudit.theorems.assumptions import FRESH, POPULATION
from fairaudit.theorems.bound import ANY_POLICY
from fairaudit.theorems.t13 import greatest_ratio
from fairaudit.theorems.t13_range import UtilityRange


@without_bare_limits(ALONE)
def calibrate_utility(
    policy: Policy,
    utility: Utility | Values,
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    quantity: Quantity = "local",
    population: Population | None = None,
    split: Split = "equal-epsilon",
) -> Calibration:
    """Find the randomized response that keeps most truth and holds a target for every policy behind it, for a known utility.

    Without filters on the context. The answer is the greatest keep probability on a grid of 10⁻¹² at which the greatest ratio that any
    policy attains (T13), computed exactly at the filter that is returned, is at most the target. A target that even a filter that hides
    the group misses is infeasible for every group filter; that is proved.

    Parameters
    ----------
    policy : Policy
        Which groups, contexts and decisions there are; what it decides does not matter.
    utility : Utility or mapping
        g; it may depend on decision, context and group, and is needed for every decision in every context.
    max_ratio, max_log, quantity
        As in `calibrate`.
    population : array_like, mapping or Law, optional
        As in `Policy.behind`; for the global ratio.
    split : {"equal-epsilon", "equal-keep", "most-truth"}
        As in `calibrate`.

    Returns
    -------
    Calibration
        The filter; scope "any policy behind this filter". Source: T13.

    Raises
    ------
    InputError
        As in `calibrate`, if the policy lacks a combination of its attributes' values, and if g is not given for some decision.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> found = fa.calibrate_utility(policy, {"hire": 3, "pass": 1}, max_ratio="7/5")
    >>> found.require().keep_probabilities, found.achieved
    ((Fraction(2, 3),), Fraction(7, 5))
    """
    target = calibration_target(max_ratio, max_log, quantity)
    attributes = alphabets(policy)
    hidden, table = every_policy(policy, utility, ResponseLine(attributes, split).on_grid(0), population)

    def value(mechanism: Mechanism) -> Extended:
        found = greatest_ratio(replace(hidden, group_filter=mechanism), table, quantity)
        if found is None:
            raise InputError("no two groups are compared, so that there is no ratio to calibrate for")
        return found.value

    declared = _widest_range(table) if quantity == "local" and not table.depends_on_group else None

    def on_line(line: ResponseLine) -> Calibration:
        return climb(target, "exact", line, value, greatest_keep(target, line, declared) if declared else None)

    found = best_tilt(on_line, attributes, split)
    if not found.feasible:
        found = replace(found, reason=why_not_for_every_policy(value(hidden.group_filter), quantity))
    assumptions = (FRESH, POPULATION) if quantity == "global" else (FRESH,)
    return replace(found, quantity=quantity, scope=ANY_POLICY, assumptions=assumptions)


def every_policy(
    policy: Policy, utility: Utility | Values, hiding: Mechanism, population: Population | None
) -> tuple[Deployment, UtilityTable]:
    """Groups, contexts and population behind a filter that hides the group, and the utility of every decision there.

    Raises
    ------
    InputError
        If the utility of a decision that some policy may take is not given.
    """
    wanted = known_utility(policy.law, utility)
    # Behind a filter that hides the group every decision that can follow has weight, so that a utility with gaps is refused here.
    hidden = policy.behind(group=hiding, population=population)
    table = wanted.on(hidden.law)
    if table.given is not None:
        raise InputError(
            "the utility of a decision that this policy never takes in some context is not given, and other policies may take it there; "
            "give it, or ask for this policy alone (--bound policy)"
        )
    return hidden, table


def _widest_range(table: UtilityTable) -> UtilityRange | None:
    """The utilities of the context whose greatest is the greatest multiple of its least; None where g is 0 everywhere."""
    rows = [table.row(0)] if table.by_decision else table.values.tolist()
    ends = [(max(row), min(row)) for row in rows if max(row)]
    if not ends:
        return None
    top, least = min(ends, key=lambda pair: Fraction(pair[1], pair[0]))
    return UtilityRange(Fraction(top), Fraction(least))


def why_not_for_every_policy(hidden: Extended, quantity: Quantity) -> str:
    """Why no filter of the group holds a target for every policy, from what one that hides the group guarantees, and what would."""
    cause = "the utility itself depends on the group"
    if quantity == "global":
        cause += ", or groups are spread over the contexts differently"
    alone = "; for this policy alone a target may be within reach (--bound policy)"
    if not isinstance(hidden, Fraction):
        return (
            f"even behind a filter that hides the group some policy gives one group nothing and another something, because {cause}{alone}"
        )
    ratio, logarithm = ratio_and_log(hidden)
    return (
        f"even behind a filter that hides the group some policy attains a ratio of {ratio}, because {cause}; "
        f"for every policy a target of at least {ratio} (log {logarithm}) is feasible{alone}"
    )
