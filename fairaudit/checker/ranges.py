"""The greatest ratio over all policies behind a group filter, and all utilities of a declared range.

Let utilities be from m to gamma, and those of two groups at most K <= gamma - m apart.  For rows P and Q of the filter the ratio of every
policy is at most V >= 1 if K + (gamma - K - m) H_V <= m (V - 1), with H_V the sum of max(0, P - V Q).  That is S(V) <= 0 for two
decisions, one of them worth gamma to the higher group and gamma - K to the lower one, the other m + K and m.  With a floor tau of what the
lower group gets, V >= k + max(0, K + (gamma - K - m) H_k - (k - 1) m) / tau for some k >= 0 will do: S(k) <= (V - k) tau.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from .claims import ANY_UTILITY_FLOORED, Claim
from .policy_facts import PolicyFacts
from .rationals import INFINITY, ONE, at_most
from .sides import Sides, global_range_sides, local_range_sides
from .suprema import Prover, named, no_floors, unproven


def fault_of_range(claim: Claim, facts: PolicyFacts) -> str:
    """Judge a bound on the ratio for all policies, or all that keep the declared floors, and all utilities of the declared range."""
    if not facts.declared.keys() >= {"gamma", "m"}:
        return "gamma and m are not both declared"
    if claim.value == INFINITY:
        return "a bound that is infinite says nothing"
    if not at_most(ONE, claim.value):
        return "a bound is at least 1"
    local, value = claim.key[0].startswith("local"), Fraction(*claim.value)
    if any(each.gamma < each.m for each in [facts.range, *facts.ranges]):
        return "a declared range of the utility is empty"
    sides = local_range_sides(facts.ranges, len(facts.table.header.groups)) if local else global_range_sides(facts.table, facts.range)
    if claim.key[3] == ANY_UTILITY_FLOORED:
        if not all(facts.floors if local else facts.mean_floors.values()):
            return "not everybody who is compared has a floor"
        floors = floors_of(facts, sides)
        multipliers = claim.evidence if isinstance(claim.evidence, list) else []
        prover = Prover(value, [Fraction(0), *multipliers])  # with k = 0 it is V >= gamma / tau
    else:
        floors, prover = no_floors(sides), Prover(value, [value])
    for pair in unproven(prover, sides, facts.likelihoods, floors):
        return f"it is not proved {named(facts, sides, *pair)}"
    return ""


def floors_of(facts: PolicyFacts, sides: Sides) -> Mapping[int, Sequence[Fraction]]:
    """List the floors of what the lower group of a pair gets, by site, or of the sum; of like contexts the one that says least."""
    if sides.local:
        of_sites = [min(facts.floors[x] / factor for x, factor in site.contexts) for site in sides.sites]
        return dict.fromkeys(sides.groups, of_sites)
    known: dict[Fraction, list[Fraction]] = {}
    return {a: known.setdefault(facts.mean_floors[a], [facts.mean_floors[a]]) for a in sides.groups}
