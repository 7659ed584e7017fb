"""Claims about the population behind a sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from .claims import FLOORED, POLICIES, POPULATION, Claim
from .facts import Facts
from .intervals import BETTING, METHODS, Proven
from .rates import DIFFERENCES
from .rationals import INFINITY, ONE, ZERO, Rational, at_most
from .text import shown


def is_about_population(key: tuple[str, str, str, str]) -> bool:
    quantity, relation, by, scope = key
    of_ratio = quantity in ("local_ratio", "global_ratio") and by in ("binomial", *METHODS, BETTING)
    known = (of_ratio or (quantity in DIFFERENCES and by == "binomial")) and relation in ("<=", ">=")
    return known and scope.startswith(POPULATION)


def fault_about_population(claim: Claim, proven: Mapping[str, Proven]) -> str:
    """Judge a claim that repeats an end of an interval, or has a weaker one."""
    quantity, relation, by, scope = claim.key
    interval = proven.get(quantity.removesuffix("_ratio"))
    if interval is None:
        return "there is no interval that holds"
    if claim.evidence != quantity.removesuffix("_ratio"):
        return "the evidence is the interval of the other ratio"
    if scope != interval.scope:
        return f"the interval is for {shown(interval.scope)}"
    if by != interval.by:
        return f"the method is {shown(interval.by)}"
    low, high = interval.ratio
    least = ZERO if quantity in DIFFERENCES else ONE
    true = at_most(high, claim.value) if relation == "<=" else at_most(least, claim.value) and at_most(claim.value, low)
    return "" if true else f"the interval is from {shown(low)} to {shown(high)}"


def ends_of_population(quantity: str, facts: Facts, true_claims: Iterable[Claim]) -> tuple[Rational, Rational]:
    """Find the ends of a ratio of the population: those of the interval, and bounds that hold whatever was sampled."""
    low, high = facts.proven[quantity].ratio if quantity in facts.proven else (ONE, INFINITY)
    declared = facts.declared.keys()
    for claim in true_claims:
        _, _, by, scope = claim.key
        needed = {POLICIES: {"gamma", "m"} if by == "T4" else set(), FLOORED: {"gamma"}}.get(scope)
        holds = needed is not None and needed <= declared
        if holds and claim.key[0] == f"{quantity}_ratio" and at_most(claim.value, high):
            high = claim.value
    return low, high
