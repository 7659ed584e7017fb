"""Claims about ratios whatever decisions of unknown meaning meant (T19): both ends, of the table and of the population behind it.

Each mean that is compared lies between that with every undecided decision worth the least and that with every one worth the most.
The greatest ratio is that of one mean at its most and another one at its least; the least is the greatest mean at its least over the
least mean at its most, of all contexts the greatest, and at least 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from .claims import LAW, ONE_SIDED, POPULATION, WHATEVER, Claim, without_objection
from .figures import Maximum
from .intervals import Proven
from .json_values import Labels, read_choice, read_object
from .meanings import Undecided, valued
from .policy_evidence import Attained, read_attained
from .rationals import ONE, Rational, at_most, extreme_positions, greatest_quotient, quotient, reduced, sum_of
from .table import Table, globally_compared
from .text import shown
from .work import spend

T19 = "T19"

Ends = tuple[Rational, Rational]  # of a mean, the least and the greatest that it can be
Block = dict[tuple[Labels | None, Labels], Ends]  # by context, none of group means, and group


@dataclass(frozen=True)
class Evidence:
    """Where an end is attained, or of which quantity the interval is."""

    pair: Attained | None
    interval: str = ""


def is_by_t19(key: tuple[str, str, str, str]) -> bool:
    """Whether a claim is about a ratio whatever undecided decisions meant."""
    quantity, relation, by, scope = key
    about, under = without_objection(scope)
    known = by == T19 and quantity in ("local_ratio", "global_ratio") and relation in ("<=", ">=") and under == WHATEVER
    return known and (about == LAW or about.startswith((POPULATION, ONE_SIDED)))


def read_evidence(value: object, where: str, key: tuple[str, str, str, str]) -> Evidence:
    """Read the evidence of a claim."""
    if without_objection(key[3])[0] != LAW:
        members = read_object(value, where, ("ends",))
        return Evidence(None, read_choice(members["ends"], f"{where}.ends", ("local", "global")))
    return Evidence(read_attained(read_object(value, where, ("pair",))["pair"], f"{where}.pair"))


def fault_of_undecided(
    claim: Claim, table: Table, undecided: Undecided | None, metrics: Mapping[str, Maximum | None], proven: Mapping[str, Proven]
) -> str:
    """Judge a claim: of the table by its cells, of the population by the interval."""
    quantity, relation, _, scope = claim.key
    name, evidence = quantity.removesuffix("_ratio"), claim.evidence
    if undecided is None or not isinstance(evidence, Evidence):
        return "no decisions are said to be undecided"
    if metrics.get(name) is None:
        return "the table does not give this quantity"
    if without_objection(scope)[0] != LAW:
        interval = proven.get(name)
        if interval is None or evidence.interval != name:
            return "there is no interval that holds"
        if scope != interval.scope:
            return f"the interval is for {shown(interval.scope)}"
        low, high = interval.ratio
        true = at_most(high, claim.value) if relation == "<=" else at_most(ONE, claim.value) and at_most(claim.value, low)
        return "" if true else f"the interval is from {shown(low)} to {shown(high)}"
    blocks = _blocks(table, undecided, name == "local")
    up = relation == "<="
    found = ONE
    for block in blocks:
        ends = [*block.values()]
        spend(20 * len(ends), max(max(map(max, pair)) for pair in ends).bit_length())
        own = greatest_quotient([high for _, high in ends], [low for low, _ in ends]) if up else _least(ends)
        found = own if not at_most(own, found) else found
    found = reduced(*found)
    if claim.value != found:
        return f"the ends of the means give {shown(found)}"
    if (found == ONE) is not (evidence.pair is None):
        return "a ratio of 1 needs no pair that attains it, and any other one does"
    if evidence.pair is None:
        return ""
    place = evidence.pair
    named = next((block for block in blocks if (place.context, place.higher) in block and (place.context, place.lower) in block), None)
    if named is None or place.higher == place.lower:
        return "the pair is not one that is compared"
    one, other = named[place.context, place.higher], named[place.context, place.lower]
    ratio = quotient(one[up], other[not up])
    return "" if at_most(ratio, found) and at_most(found, ratio) else "the pair does not attain it"


def _least(ends: Iterable[Ends]) -> Rational:
    """The least that the greatest ratio of some means can be."""
    lows, highs = zip(*ends, strict=True)
    top, bottom = lows[extreme_positions(lows)[0]], highs[extreme_positions(highs)[1]]
    return ONE if at_most(top, bottom) else quotient(top, bottom)


def _blocks(table: Table, undecided: Undecided, local: bool) -> list[Block]:
    """What is compared with each other: the cells of each context, or the means of all groups."""
    header, extremes = table.header, [valued(table, undecided, worth) for worth in (undecided.least, undecided.most)]
    if local:
        means = [[cell.expectation for cell in one.cells] for one in extremes]
        blocks: dict[int, Block] = {}
        for cell, low, high in zip(table.cells, *means, strict=True):
            blocks.setdefault(cell.context, {})[header.contexts[cell.context], header.groups[cell.group]] = low, high
        return [block for block in blocks.values() if len(block) > 1]
    of_groups: Block = {}
    for a in globally_compared(table):
        low, high = (_mean([(cell.mass, cell.expectation) for cell in one.by_group()[a]]) for one in extremes)
        of_groups[None, header.groups[a]] = low, high
    return [of_groups] if of_groups else []


def _mean(parts: Iterable[tuple[Rational, Rational]]) -> Rational:
    """The mean of expectations with masses, which need not sum to 1."""
    listed = [*parts]
    spend(8 * len(listed), max(max(map(max, pair)) for pair in listed).bit_length())
    (n, d), (mass, below) = sum_of((m * e, w * b) for (m, w), (e, b) in listed), sum_of(mass for mass, _ in listed)
    return reduced(n * below, d * mass)


def stated_ends(quantity: str, of_population: bool, true_claims: Iterable[Claim]) -> dict[str, Rational]:
    """The ends of a ratio that true claims state, whatever undecided decisions meant, by their relation."""
    return {
        claim.key[1]: claim.value
        for claim in true_claims
        if is_by_t19(claim.key) and claim.key[0] == f"{quantity}_ratio" and (without_objection(claim.key[3])[0] != LAW) == of_population
    }
