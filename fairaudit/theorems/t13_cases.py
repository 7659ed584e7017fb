"""T13 in a case: for each scope the greatest ratio, or what bounds it, with what the reader has to judge.

Scopes are any policy, any policy that keeps the declared floors, any policy within the declared drift of this one, and any policy with any
utility of the declared range, with floors or without.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from math import inf

from fairaudit.exact.extended import ZERO, extended_text
from fairaudit.measures.limits import Quantity
from fairaudit.theorems.assumptions import (
    DECLARED_FLOOR,
    DECLARED_FLOOR_IN,
    DECLARED_MEAN_FLOOR,
    DECLARED_RANGE,
    DECLARED_RANGE_IN,
    DRIFT,
    FRESH,
    POPULATION,
    RELEASES,
)
from fairaudit.theorems.bound import ANY_POLICY, ANY_UTILITY, ANY_UTILITY_FLOORED, FLOORED, NEAR_POLICY, Bound
from fairaudit.theorems.case import Case
from fairaudit.theorems.supremum import Floors, Supremum
from fairaudit.theorems.t13 import greatest_ratio
from fairaudit.theorems.t13_floors import greatest_ratio_above
from fairaudit.theorems.t13_near import greatest_ratio_near, near_steps
from fairaudit.theorems.t13_problems import MAX_PROBLEMS, TooManyPairs
from fairaudit.theorems.t13_range import UtilityRange, in_each_range, in_population, read_utility_range, t13_range

NEAR_STEPS = 30_000_000
"""Of the steps that docs/certificate.md lets a document ask of its reader, those for one claim about the policies near one."""

TOO_MANY = (
    "what any policy can do behind these filters is left out, for the local ratio, the global one, or both: "
    f"more than {MAX_PROBLEMS:,} pairs of groups differ in utility or filter"
)

TOO_NEAR = (
    "what any policy near this one can do is left out of the certificate, for the local ratio, the global one, or both: these filters "
    "release too many values for a reader to go through"
)


def t13_any_policy_in(case: Case, quantity: Quantity) -> Supremum | None:
    """The greatest ratio of any policy; None where nothing is compared, or there is too much to go through."""
    try:
        found = greatest_ratio(case.deployment, case.utility, quantity) if case.narrow else None
    except TooManyPairs:
        return None
    return found and replace(found, assumptions=assumed(case, quantity, ANY_POLICY))


def t13_near_in(case: Case, quantity: Quantity) -> Supremum | None:
    """The greatest ratio of any policy within the declared drift of this one; None where none was declared, or a reader takes too long."""
    if "max_drift" not in case.declared or near_steps(case.deployment, case.utility, quantity) > NEAR_STEPS:
        return None
    found = greatest_ratio_near(case.deployment, case.utility, quantity, case.declared["max_drift"])
    return found and replace(found, scope=NEAR_POLICY, assumptions=assumed(case, quantity, NEAR_POLICY))


def t13_floored_in(case: Case, quantity: Quantity) -> Supremum | None:
    """The greatest ratio of any policy that keeps the declared floors, or what bounds it; None where none is declared."""
    floors = floors_of(case)
    try:
        found = greatest_ratio_above(case.deployment, case.utility, quantity, floors) if floors and case.narrow else None
    except TooManyPairs:
        return None
    if found is None or (found.value == inf and not found.exact):
        return None
    return replace(found, assumptions=assumed(case, quantity, FLOORED))


def t13_range_in(case: Case, quantity: Quantity) -> Bound | None:
    """What bounds the ratio of any policy for any utility of the declared range; None where none was declared, or nothing does."""
    return _range_in(case, quantity, ANY_UTILITY)


def t13_range_floored_in(case: Case, quantity: Quantity) -> Bound | None:
    """The same of any policy that keeps the declared floors; None where not everybody who is compared has one."""
    return _range_in(case, quantity, ANY_UTILITY_FLOORED)


def _range_in(case: Case, quantity: Quantity, scope: str) -> Bound | None:
    if not case.declared.keys() >= {"gamma", "m"} or not case.narrow:
        return None
    floored = scope == ANY_UTILITY_FLOORED
    ranges = _ranges(case) if quantity == "local" else _mean_ranges(case)
    if not ranges or (floored and not all(one.tau for one in ranges)):
        return None
    at = case.deployment
    pairs = (
        in_each_range(at.group_filter, ranges, at.releases)
        if quantity == "local"
        else in_population(at.group_filter, at.law.cell_mass, ranges, at.releases)
    )
    bound = t13_range(pairs, quantity=quantity, floored=floored, assumptions=assumed(case, quantity, scope))
    return bound if bound.value < inf else None


def floors_of(case: Case) -> Floors:
    """The declared floors: in each true context the greater of its own and of that for all, and the floor of means."""
    general = case.declared.get("tau", ZERO)
    own = (case.declared_in.get(label, {}).get("tau", ZERO) for label in case.deployment.contexts)
    return Floors(tuple(max(general, tau) for tau in own), case.declared.get("global_tau", ZERO))


def _ranges(case: Case) -> list[UtilityRange]:
    """The declared range of each true context, with its floor."""
    found = []
    for label, tau in zip(case.deployment.contexts, floors_of(case).cells, strict=True):
        own = {**case.declared, **case.declared_in.get(label, {})}
        found.append(read_utility_range(own["gamma"], own["m"], case.gap, tau))
    return found


def _mean_ranges(case: Case) -> list[UtilityRange]:
    """The declared range with the floor of the mean of each group; empty where group means are not compared."""
    law, floors = case.deployment.law, floors_of(case)
    if not law.global_groups:
        return []
    groups, mass = len(law.groups), law.cell_mass
    found = []
    for a in range(groups):
        own = mass[a::groups]
        mean = sum((m * tau for m, tau in zip(own, floors.cells, strict=True)), ZERO) / (sum(own) or 1)
        found.append(read_utility_range(case.declared["gamma"], case.declared["m"], case.gap, max(floors.overall, mean)))
    kept = [one.tau for a, one in enumerate(found) if any(mass[a::groups])]
    return [replace(one, tau=one.tau or min(kept)) for one in found]  # groups without mass are not compared, and need no floor


def assumed(case: Case, quantity: Quantity, scope: str) -> tuple[str, ...]:
    """What the reader has to judge of a statement by T13: see "Assumptions" in docs/certificate-policy.md."""
    return tuple(chain([FRESH], [POPULATION] if quantity == "global" else [], _declared(case, quantity, scope), _releases(case)))


def _declared(case: Case, quantity: Quantity, scope: str) -> Iterator[str]:
    declared = case.declared
    if scope in (FLOORED, ANY_UTILITY_FLOORED):
        if declared.get("tau"):
            yield DECLARED_FLOOR.format(tau=extended_text(declared["tau"]))
        for label, own in case.declared_in.items():
            if own.get("tau"):
                yield DECLARED_FLOOR_IN.format(context=_text(label), tau=extended_text(own["tau"]))
        if declared.get("global_tau"):
            yield DECLARED_MEAN_FLOOR.format(tau=extended_text(declared["global_tau"]))
    if scope in (ANY_UTILITY, ANY_UTILITY_FLOORED):
        numbers = {"m": declared["m"], "gamma": declared["gamma"], "lipschitz": case.gap}
        yield DECLARED_RANGE.format_map({name: extended_text(value) for name, value in numbers.items()})
        for label, own in case.declared_in.items() if quantity == "local" else ():
            if own.keys() & {"gamma", "m"}:
                m, gamma = (extended_text(own.get(name, declared[name])) for name in ("m", "gamma"))
                yield DECLARED_RANGE_IN.format(context=_text(label), m=m, gamma=gamma)
    if scope == NEAR_POLICY:
        yield DRIFT.format(drift=extended_text(declared["max_drift"]))


def _releases(case: Case) -> Sequence[str]:
    return [RELEASES.format(releases=case.deployment.releases)] if case.deployment.releases > 1 else []


def _text(label: Sequence[str]) -> str:
    return json.dumps(list(label), ensure_ascii=False)
