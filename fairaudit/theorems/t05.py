"""T5: from the local ratio to the global one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import permutations
from math import inf, lcm
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.measures.expectations import cell_expectation
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.model.utility import UtilityTable
from fairaudit.theorems.assumptions import DECISION_ONLY, FRESH, GROUP_FREE, INDEPENDENT, POPULATION
from fairaudit.theorems.bound import (
    ANY_POLICY,
    THIS_LAW,
    Bound,
    Floor,
    as_multipliers,
    finite_constants,
    floor_terms,
    privacy_premise,
)
from fairaudit.theorems.case import Case
from fairaudit.theorems.constants import read_factor, read_level, read_ratio
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t03 import t3_mechanism

# T5: from local to global


def t5_independent(local_ratio: Any) -> Bound:
    """T5: where context and group are independent the global ratio is at most the local one.

    Source: T5; Coq `T5_independent`, `T5_independent_filter`.

    Parameters
    ----------
    local_ratio : number, str or Bound
        R ≥ 1 (or `math.inf`) of a law, or a bound on it, whose evidence, assumptions and scope then carry over.

    Returns
    -------
    Bound
        On the global ratio. Without independence it is false: every context can be fair while the groups are spread differently.

    Raises
    ------
    InputError
        If the ratio is below 1, or the bound is on something else.

    Examples
    --------
    >>> from fairaudit.theorems.t02 import t2
    >>> t5_independent(t2(2)).quantity
    'global_ratio'
    """
    if isinstance(local_ratio, Bound):
        if local_ratio.quantity != "local_ratio":
            raise InputError(f"the bound is on {local_ratio.quantity}; T5 starts from a bound on the local ratio")
        return replace(local_ratio, theorem="T5", quantity="global_ratio", assumptions=(*local_ratio.assumptions, INDEPENDENT))
    ratio = read_ratio("the local ratio", local_ratio)
    return Bound("T5", "global_ratio", ratio, finite_constants(local_ratio=ratio), (), (INDEPENDENT,), THIS_LAW)


def t5_general(law: Law, utility: UtilityTable) -> Bound:
    """T5 without independence: the global ratio is at most the greatest P(x|a)·E(x,a) / (P(x|a')·E(x,a')) over contexts and pairs.

    Source: T5; Coq `T5_general`, `T5_general_global`.

    Parameters
    ----------
    law : Law
        The law, with its population.
    utility : UtilityTable
        The utility on that law.

    Returns
    -------
    Bound
        On the global ratio. It is at most R times `context_ratio`.

    Raises
    ------
    InputError
        If the law has no population over which two groups can be compared.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [3, 1]]], kind="counts", decisions=["yes", "no"])
    >>> t5_general(law, Utility({"yes": 1}).on(law)).value
    Fraction(3, 2)
    """
    shares = _shares(law)
    parts: dict[int, dict[int, Fraction]] = {group: {} for group in shares}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        if a in shares and shares[a].get(x):
            parts[a][x] = shares[a][x] * Fraction(*cell_expectation(law, utility, cell))
    value = _termwise(parts)
    return Bound("T5", "global_ratio", value, {}, (), (POPULATION,), THIS_LAW)


def context_ratio(law: Law, context_filter: Mechanism | None = None) -> Extended:
    """Find the greatest P(x|a)/P(x|a') over contexts and groups; with a filter, the same of the released contexts x̃.

    Source: T5; Coq `T5_general_global`, `T5_decision`.

    Parameters
    ----------
    law : Law
        The law, with its population.
    context_filter : Mechanism, optional
        The context filter; its inputs are the contexts of the law.

    Returns
    -------
    Fraction or float
        At least 1; `math.inf` if a context occurs in one group only.

    Raises
    ------
    InputError
        If the law has no population over which two groups can be compared, or the filter does not know a context.

    Examples
    --------
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [3, 1]]], kind="counts")
    >>> context_ratio(law)
    Fraction(3, 2)
    """
    masses = _masses(law)
    if context_filter is not None:
        masses = {group: _released(law, context_filter, of_group) for group, of_group in masses.items()}
    return _termwise({group: _parts(of_group) for group, of_group in masses.items()})


def t5_decision(
    exp_epsilon_group: Any, utility: UtilityTable, *, released_ratio: Any = inf, exp_epsilon_context: Any = inf, context_ratio: Any = inf
) -> Bound:
    """T5 for g = g(u): the global ratio is at most e^(ε_A) times the greatest P(x̃|a)/P(x̃|a').

    That in turn is at most e^(ε_X) and at most the greatest P(x|a)/P(x|a').

    Source: T5; Coq `T5_decision`, `T5_decision_min`.

    Parameters
    ----------
    exp_epsilon_group : number or str
        e^(ε_A) ≥ 1 of the group filter (or `math.inf`).
    utility : UtilityTable
        The utility; it must depend on the decision alone (for g(u,x) the statement is false).
    released_ratio, exp_epsilon_context, context_ratio : number or str
        What is known, each ≥ 1: the greatest P(x̃|a)/P(x̃|a') (see `context_ratio`), e^(ε_X) of the context filter, the greatest
        P(x|a)/P(x|a'). The least of them counts.

    Returns
    -------
    Bound
        On the global ratio, for every policy.

    Raises
    ------
    InputError
        If the utility depends on more than the decision, or a number is below 1.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[1, 1], [1, 1]], decisions=["yes", "no"], kind="counts")
    >>> t5_decision(2, Utility({"yes": 1}).on(law), exp_epsilon_context=3).value
    Fraction(6, 1)
    """
    if not utility.by_decision:
        raise InputError("the utility depends on context or group; this bound holds only for a utility that depends on the decision alone")
    factor = read_factor(exp_epsilon_group)
    spreads = {
        "released_ratio": read_ratio("released_ratio", released_ratio),
        "exp_epsilon_context": read_ratio("exp_epsilon_context", exp_epsilon_context),
        "context_ratio": read_ratio("context_ratio", context_ratio),
    }
    least = min(spreads.values())
    value = factor * least
    within = spreads["exp_epsilon_context"]
    spread = privacy_premise(within, Fraction(0), "the context filter") if within == least < inf else POPULATION
    assumptions = (FRESH, DECISION_ONLY, privacy_premise(factor, Fraction(0)), spread)
    constants = finite_constants(exp_epsilon_group=factor, **spreads)
    note = "" if isinstance(value, Fraction) else "neither filter nor population bounds the ratio"
    return Bound("T5", "global_ratio", value, constants, as_multipliers(factor), assumptions, ANY_POLICY, note=note)


def t5_floor(law: Law, mechanism: Mechanism, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for the global ratio: the rows P(x|a)·M(ã|a) in place of the filter's, and the floor under the group means.

    Source: T5; Coq `T5_floor`.

    Parameters
    ----------
    law : Law
        The law, for its population.
    mechanism : Mechanism
        The group filter; its inputs are the groups of the law.
    t : number or str
        Floor under every group's mean utility, as a part of the greatest utility, in (0, 1].
    floor : {"table", "declared", "policy"}
        As in `t3_mechanism`.

    Returns
    -------
    Bound
        On the global ratio, for a utility that ignores the group (it may depend on the context).

    Raises
    ------
    InputError
        If t is out of range, there is no population, or the filter does not know a group.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Constant
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [3, 1]]], kind="counts", groups=["a", "b"])
    >>> t5_floor(law, Constant(["a", "b"]), "0.5").value
    Fraction(4, 3)
    """
    level = read_level(t)
    shares = _shares(law)
    contexts = sorted({x for masses in shares.values() for x in masses})
    bottom = lcm(*(mass.denominator for masses in shares.values() for mass in masses.values()))
    rows = []
    for group, masses in shares.items():
        row = mechanism.row(law.groups[group])
        rows.append(tuple(int(masses.get(x, 0) * bottom) * weight for x in contexts for weight in row))
    names = tuple(law.groups[group] for group in shares)
    outputs = tuple((*law.contexts[x], *released) for x in contexts for released in mechanism.outputs)
    joint = Mechanism((Factor(names, outputs, tuple(rows), bottom * mechanism.denominator),))
    found = t3_mechanism(joint, level, floor=floor)
    scope, extra = floor_terms(floor, f"{level} of the greatest utility", any_filter=False, mean=True)
    return replace(found, theorem="T5", quantity="global_ratio", assumptions=(FRESH, GROUP_FREE, POPULATION, *extra), scope=scope)


def t5_in(case: Case) -> Bound | None:
    """T5 in a case whose context and group are independent: T2 for the global ratio; None without a population."""
    if not case.law.global_groups:
        return None
    bound = t5_independent(t2(case.exp_epsilon))
    return replace(bound, multipliers=(), assumptions=(*bound.assumptions, POPULATION))


def t5_decision_in(case: Case) -> Bound | None:
    """T5 for a utility of the decision alone in a case; None without a population, or where some context is for one group only."""
    if not case.law.global_groups:
        return None
    spread = context_ratio(case.law, case.deployment.context_filter)
    if spread == inf:
        return None
    bound = t5_decision(case.exp_epsilon, case.utility, released_ratio=spread)
    return replace(bound, constants={"composition": Fraction(spread)}, multipliers=())


# Populations


def _masses(law: Law) -> dict[int, dict[int, int]]:
    """P(x,a) of the globally compared groups, up to a common factor."""
    if not law.global_groups:
        raise InputError("the table has no population over which groups could be compared; give weights, or every group in every context")
    masses: dict[int, dict[int, int]] = {group: {} for group in law.global_groups}
    for x, group, mass in zip(law.cell_context.tolist(), law.cell_group.tolist(), law.cell_mass, strict=True):
        if group in masses:
            masses[group][x] = mass
    return masses


def _released(law: Law, context_filter: Mechanism, masses: Mapping[int, int]) -> dict[int, int]:
    """Masses of the contexts that a filter releases, up to a common factor."""
    released = [0] * len(context_filter.outputs)
    for x, mass in masses.items():
        released = [sum_ + mass * weight for sum_, weight in zip(released, context_filter.row(law.contexts[x]), strict=True)]
    return dict(enumerate(released))


def _parts(masses: Mapping[int, int]) -> dict[int, Fraction]:
    """Masses as parts of their sum."""
    total = sum(masses.values())
    return {x: Fraction(mass, total) for x, mass in masses.items()}


def _shares(law: Law) -> dict[int, dict[int, Fraction]]:
    """P(x|a) of the globally compared groups."""
    return {group: _parts(masses) for group, masses in _masses(law).items()}


def _termwise(parts: dict[int, dict[int, Fraction]]) -> Extended:
    """Greatest ratio of two groups' terms; terms that are zero in both compare nothing."""
    worst: Extended = Fraction(1)
    for first, second in permutations(parts.values(), 2):
        for x, top in first.items():
            bottom = second.get(x, Fraction(0))
            if top and not bottom:
                return inf
            if top:
                worst = max(worst, top / bottom)
    return worst
