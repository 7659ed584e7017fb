"""The greatest ratio over the policies that keep the declared floors.

A policy that gives the lower group at least tau has a ratio of at most V if S(k) <= (V - k) tau for some k, which takes one sum as for all
policies.  All floors together say more: some policy keeps them, that of the table, so that V bounds the ratio of all that do exactly if
there are y >= 0 with which the sum over o of the greatest p - V q + sum of y e is at most the sum of y f.  There e is what a decision adds
to an expectation that has the floor f, and o everything that may be released, be it in the context that is compared or in another one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import chain
from operator import mul

from .claims import Claim
from .filters import mixed_laws, seen_in_contexts, spend_on_law
from .laws import expectation, reduced_law
from .policy_evidence import FlooredEvidence, Priced, Witness
from .policy_facts import PolicyFacts
from .ranges import floors_of
from .rationals import INFINITY, ONE, Rational, as_pair, at_most, over_common_denominator, product_of, reduced, sum_of
from .suprema import Pair, Prover, unproven
from .text import shown
from .work import keep, spend

Compared = tuple[int | None, int, int]  # a true context for the local ratio, the higher and the lower group
Floor = tuple[int | None, int, Fraction]  # of a true context, or none for that of a mean, and a group; and a multiple of it


def fault_of_floored(claim: Claim, facts: PolicyFacts) -> str:
    """Judge the greatest ratio over the policies that keep the declared floors: none exceeds it, and one attains it if it is stated so."""
    evidence = claim.evidence if isinstance(claim.evidence, FlooredEvidence) else FlooredEvidence([], [], None)
    exact, local = claim.key[1] == "=", claim.key[0].startswith("local")
    if not any(facts.floors) and not facts.declared_number("global_tau"):
        return "no floor above 0 is declared"
    if not at_most(ONE, claim.value):
        return "a greatest ratio is at least 1"
    if (evidence.policy is None) == (exact and claim.value != ONE):
        return "a policy that attains the value is needed where it is greater than 1 and stated exactly, and nowhere else"
    entries = _entries(evidence.pairs, facts, local)
    if isinstance(entries, str):
        return entries
    if claim.value != INFINITY:
        fault = _fault_of_proofs(Fraction(*claim.value), evidence.multipliers, entries, facts, local)
        if fault:
            return fault
    elif not exact:
        return "a bound that is infinite says nothing"
    return "" if evidence.policy is None else _fault_of_policy(claim.value, evidence.policy, facts, local)


def _entries(pairs: Sequence[Priced], facts: PolicyFacts, local: bool) -> dict[Compared, Priced] | str:
    """List the entries by what they are about, or say what is wrong with one."""
    entries: dict[Compared, Priced] = {}
    for entry in pairs:
        place = facts.place(entry.place, local)
        if isinstance(place, str):
            return place
        if place in entries:
            return f"two entries are {facts.named(*place)}"
        for context, group, _ in entry.floors:
            if not _floor(facts, context, group):
                return f"there is no floor above 0 for {shown([context, group])}"
        entries[place] = entry
    return entries


def _floor(facts: PolicyFacts, context: int | None, group: int) -> Fraction:
    """Find a declared floor, that of a group's mean if no true context is named; 0 where there is none."""
    header = facts.table.header
    if context is None:
        return facts.declared_number("global_tau") if group in facts.worth(local=False).scales else Fraction(0)
    return facts.floors[context] if context < len(header.contexts) and group < len(header.groups) else Fraction(0)


def _fault_of_proofs(
    value: Fraction, multipliers: Sequence[Fraction], entries: Mapping[Compared, Priced], facts: PolicyFacts, local: bool
) -> str:
    """Look for a pair that is proved neither by a multiplier nor by floors."""
    sides, likelihoods, prover = facts.sides(local), facts.likelihoods, Prover(value, [value, *multipliers])
    for higher, lower, number in unproven(prover, sides, likelihoods, floors_of(facts, sides)):
        site = sides.sites[number] if local else None
        pair = Pair(sides, likelihoods.of(higher, lower), higher, lower)
        for context, factor in site.contexts if site else [(None, 1)]:
            compared = context, higher, lower
            if site and context is not None and prover.proves(pair, [site], facts.floors[context] / factor):
                continue  # another context that is alike has a lesser floor
            if compared not in entries:
                return f"no multiplier proves it {facts.named(*compared)}"
            if facts.policy.releases > 1:
                return f"no multiplier proves it {facts.named(*compared)}, and floors prove nothing of several releases"
            if not _proved_by_floors(value, compared, entries[compared].floors, facts):
                return f"the floors do not prove it {facts.named(*compared)}"
    return ""


def _proved_by_floors(value: Fraction, compared: Compared, floors: Sequence[Floor], facts: PolicyFacts) -> bool:
    """Whether the sum over all o of the greatest p - V q + sum of y e is at most the sum of y f."""
    context, higher, lower = compared
    added, over = _added([(context, higher, Fraction(1)), (context, lower, -value), *floors], facts)
    released, total = facts.released
    sums = 0
    for by_group in added.values():
        rows = [released[a] for a in by_group]
        columns = [*zip(*by_group.values(), strict=True)]
        bits = max(abs(entry).bit_length() for column in columns for entry in column)
        spend(2 * len(rows[0]) * len(columns) * (1 + len(rows)), bits, total.bit_length())
        sums += sum(max(sum(map(mul, shares, column)) for column in columns) for shares in zip(*rows, strict=True))
    return sums <= sum((y * _floor(facts, x, a) for x, a, y in floors), Fraction(0)) * over * total


def _added(terms: Sequence[Floor], facts: PolicyFacts) -> tuple[dict[int, dict[int, list[int]]], int]:
    """Add up multiples of what decisions add to expectations, by released context and true group, and say what the sums are over.

    They are to be multiplied with the probabilities of the released groups.
    """
    shown_in, total = facts.shown
    coefficients: list[Rational] = []
    for x, a, y in terms:
        worth = facts.worth(local=x is not None)
        coefficients.append(reduced(y.numerator, y.denominator * worth.unit * (worth.scales[a] if x is None else total)))
    factors, over = over_common_denominator(coefficients)
    added: dict[int, dict[int, list[int]]] = {}
    for (x, a, _), factor in zip(terms, factors, strict=True):
        worth = facts.worth(local=x is not None)
        for i, weight in [(i, 1) for i in range(len(worth.rows))] if x is None else shown_in[x]:
            own = worth.of(i if x is None else x, a)
            spend(4 + 3 * len(own), factor.bit_length(), max(own).bit_length() + weight.bit_length())
            by_group = added.setdefault(i, {})
            if a not in by_group:
                keep(len(own), factor.bit_length() + max(own).bit_length() + weight.bit_length())
                by_group[a] = [0] * len(own)
            by_group[a] = [before + factor * weight * entry for before, entry in zip(by_group[a], own, strict=True)]
    return added, over


def _fault_of_policy(value: Rational, witness: Witness, facts: PolicyFacts, local: bool) -> str:
    """Say why a policy does not keep the declared floors, or does not have exactly this ratio."""
    if facts.policy.releases > 1:
        return "policies that see several releases are not written down"
    place = facts.place(witness.attained, local)
    if isinstance(place, str):
        return place
    means = _means(witness.rows, facts)
    if isinstance(means, str):
        return means
    groups = len(facts.table.header.groups)
    for i, mean in enumerate(means):
        context, group = divmod(i, groups)
        if not at_most(as_pair(facts.floors[context]), mean):
            return f"the policy does not keep the floor of {shown([context, group])}"
    of_groups: dict[int, Rational] = {}
    for a in facts.table.figures.populated():
        masses = [cell.mass for cell in facts.table.cells[a::groups]]
        total = sum_of(product_of(pair) for pair in zip(masses, means[a::groups], strict=True))
        n, d = sum_of(masses)
        of_groups[a] = product_of([total, (d, n)])
        if not at_most(as_pair(facts.declared_number("global_tau")), of_groups[a]):
            return f"the policy does not keep the floor of means for group {a}"
    where, *pair = place
    above, below = (of_groups[a] if where is None else means[where * groups + a] for a in pair)
    ratio = product_of([above, (below[1], below[0])]) if below[0] else INFINITY if above[0] else ONE
    return "" if ratio == value else f"the policy has the ratio {shown(ratio)} {facts.named(*place)}"


def _means(rows: Sequence[Sequence[Sequence[Rational]]], facts: PolicyFacts) -> list[Rational] | str:
    """Compute the expectations E(x,a) of a policy behind the filters."""
    policy, header = facts.policy, facts.table.header
    shape = [[len(header.decisions)] * len(row) for row in policy.rows]
    if [[len(law) for law in row] for row in rows] != shape:
        return "the policy does not have a law over the decisions for each released context and group"
    written = [[over_common_denominator(law) for law in row] for row in rows]
    if any(sum(weights) != total for row in written for weights, total in row):
        return "the policy has probabilities that do not sum to 1"
    laws = [[reduced_law(*law) for law in row] for row in written]
    spend_on_law(len(header.contexts), policy.group, len(header.decisions))
    induced = chain.from_iterable(mixed_laws(of_context, policy.group.maps) for of_context in seen_in_contexts(laws, policy.context))
    return [expectation(law, cell.utility) for law, cell in zip(induced, facts.table.cells, strict=True)]
