"""The keep probability for a known policy, whose induced law is measured exactly.

The ratio of a known policy may fall and rise again where the utility depends on the group: E(a) ≤ R*·E(a') are then polynomials
in one number, linear for one attribute, and the greatest point at which all hold is found exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain, permutations
from math import inf
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.bernstein import coefficients, greatest_nonnegative
from fairaudit.exact.rationals import Number
from fairaudit.filters.calibration import UNNEEDED, Calibration, best_tilt, calibrated
from fairaudit.filters.responses import GRID, ResponseLine, Split, alphabets, identity_filter, rounded_keep
from fairaudit.filters.targets import calibration_target
from fairaudit.measures.expectations import compared_expectations
from fairaudit.measures.limits import ALONE, Quantity, without_bare_limits
from fairaudit.measures.ratios import global_fairness, local_fairness
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.policy import Policy, Population
from fairaudit.model.utility import Utility, UtilityTable, Values, known_utility
from fairaudit.theorems.assumptions import FRESH
from fairaudit.theorems.bound import THIS_LAW

Blocks = list[list[Fraction]]


@without_bare_limits(ALONE)
def calibrate_policy(
    policy: Policy,
    utility: Utility | Values,
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    quantity: Quantity = "local",
    population: Population | None = None,
    split: Split = "equal-epsilon",
) -> Calibration:
    """Find the randomized response that keeps most truth and whose induced law, measured exactly, meets a target.

    Without filters on the context. For one attribute the answer is the greatest keep probability from 1/k on that meets the target
    (rounded down to 10⁻¹² where that meets it too), and an infeasible target is proved to be so: the ratio may fall and rise again where
    the utility depends on the group, or the target is for L̄, and all its pieces are looked at. With several attributes the same is
    done along one line of filters, the `split`; whether another combination meets a target that none on it meets is then left open,
    except where the measure cannot fall as the keep probabilities grow (T9: L, and a utility that ignores the group).

    Parameters
    ----------
    policy : Policy
        The known policy; its group alphabet is filtered.
    utility : Utility or mapping
        g.
    max_ratio, max_log, quantity
        As in `calibrate`.
    population : array_like, mapping or Law, optional
        As in `Policy.behind`.
    split : {"equal-epsilon", "equal-keep", "most-truth"}
        As in `calibrate`.

    Returns
    -------
    Calibration
        The filter; scope "this law".

    Raises
    ------
    InputError
        As in `calibrate`, and if the policy lacks a combination of its attributes' values.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> found = fa.calibrate_policy(policy, {"hire": 1}, max_ratio=2)
    >>> found.require().keep_probabilities, found.achieved
    ((Fraction(16, 21),), Fraction(2, 1))
    """
    target = calibration_target(max_ratio, max_log, quantity)
    attributes = alphabets(policy)
    wanted = known_utility(policy.law, utility)
    measure = local_fairness if quantity == "local" else global_fairness

    def value(mechanism: Mechanism) -> Fraction | float:
        found = measure(*_induced(policy, mechanism, population, wanted))
        return inf if found is None else found.ratio

    def blocks(mechanism: Mechanism) -> Blocks:
        return compared_expectations(*_induced(policy, mechanism, population, wanted), within_context=quantity == "local")

    without = measure(*(unfiltered := _induced(policy, identity_filter(attributes), population, wanted)))
    if without is None:
        raise InputError("no two groups are compared, so that there is no ratio to calibrate for")
    if without.ratio <= target:
        found = calibrated(target, "policy", identity_filter(attributes), without.ratio, UNNEEDED)
    else:
        found = best_tilt(lambda line: _greatest(target, line, blocks, value), attributes, split)
    if not found.feasible:
        rises = quantity == "local" and not unfiltered[1].depends_on_group
        settled = found.settled and (len(attributes) == 1 or rises)
        found = replace(found, settled=settled, reason=_why_not(attributes, split, settled=settled))
    return replace(found, quantity=quantity, scope=THIS_LAW, assumptions=(FRESH,))


def _induced(policy: Policy, mechanism: Mechanism, population: Any, utility: Utility) -> tuple[Law, UtilityTable]:
    table = utility.on(policy.behind(group=mechanism, population=population).law)
    return table.law, table


def _greatest(
    target: Fraction, line: ResponseLine, blocks: Callable[[Mechanism], Blocks], value: Callable[[Mechanism], Fraction | float]
) -> Calibration:
    """The last filter of a line whose induced law meets the target, found from polynomials and measured again."""
    settled = True
    for low, high, rising in line.pieces():
        places = [low + (high - low) * Fraction(j, max(1, len(rising))) for j in range(len(rising) + 1)]
        scaled = [[[e * line.weight(s, rising) for e in block] for block in blocks(line.filters(line.keeps(s)))] for s in places]
        constraints = [
            _constraints(target, [coefficients(values) for values in zip(*block, strict=True)]) for block in zip(*scaled, strict=True)
        ]
        point, sure = greatest_nonnegative(list(chain(*constraints)), low, high)
        if point is not None:
            return _measured(target, line, line.keeps(point), value)
        settled &= sure
    return Calibration("local", target, "policy", False, None, (), inf, None, "", (), settled=settled)


def _constraints(target: Fraction, means: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    """target·E(a') − E(a) for each ordered pair of groups, except where the coefficients alone show that it is nonnegative."""
    ends = [(max(mean), target * min(mean)) for mean in means]
    return [
        [target * below - above for above, below in zip(means[i], means[j], strict=True)]
        for i, j in permutations(range(len(means)), 2)
        if ends[i][0] > ends[j][1]
    ]


def _measured(
    target: Fraction, line: ResponseLine, keeps: Sequence[Fraction], value: Callable[[Mechanism], Fraction | float]
) -> Calibration:
    """The filter with these keep probabilities; with decimals of 12 digits instead of long fractions where those meet the target too."""
    short = all(keep.denominator <= GRID for keep in keeps)
    for tried in (keeps,) if short else ([rounded_keep(keep) for keep in keeps], keeps):
        mechanism = line.filters(tried)
        achieved = value(mechanism)
        if achieved <= target:
            return calibrated(target, "policy", mechanism, achieved, "")
    raise InputError("the ratio behind the filter that was found exceeds the target; this is a fault of the program, please report it")


def _why_not(attributes: Mapping[str, tuple[Any, ...]], split: Split, *, settled: bool) -> str:
    """Why no filter meets the target of a known policy, or that none was found."""
    if settled:
        return (
            "every keep probability from one over the number of values, which hides the group, up to 1 leaves more than the target (all of "
            "them were looked at, exactly); change the utility, the policy or the target"
        )
    if len(attributes) > 1:
        return (
            f"none was found among the filters of the split {split}; others, which keep the attributes with other probabilities, were not "
            "looked at; try another split, or fairaudit design, which looks at every filter"
        )
    return "none was found, and none was ruled out; try fairaudit design, which looks at every filter, or another target"
