"""The greatest ratio over all policies near that of the table: one sum over everything that is released for each ordered pair of groups.

Where the filters release o, the law T'(.|o) of such a policy is within total variation eta of T(.|o).  The sum over u of T'(u|o) (p - V q)
is greatest where mass eta has left the decisions with the least p - V q for one with the greatest.  So no such policy exceeds V >= 1
exactly if the sum of that over all o is at most 0 for every ordered pair.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import permutations
from operator import mul

from .claims import Claim
from .policy_evidence import Attained
from .policy_facts import PolicyFacts
from .rationals import INFINITY, ONE, at_most, common_denominator
from .work import keep, spend

Compared = tuple[int | None, int, int]  # a true context for the local ratio, the higher and the lower group


class Nearby:
    """The policies near that of the table: its laws by what is released, and how much of each may move, over one unit."""

    def __init__(self, facts: PolicyFacts, local: bool, drift: Fraction) -> None:
        self.facts, self.worth = facts, facts.worth(local)
        rows = facts.policy.rows
        unit = common_denominator({total for row in rows for _, total in row})
        self.bits = unit.bit_length() + drift.denominator.bit_length()
        spend(len(rows) * len(rows[0]) * self.worth.decisions, self.bits)
        keep(len(rows) * len(rows[0]) * self.worth.decisions, self.bits)
        self.laws = [[[w * (unit // total) * drift.denominator for w in weights] for weights, total in row] for row in rows]
        self.moved = unit * drift.numerator

    def different(self, context: int | None) -> Iterator[Compared]:
        """List the ordered pairs of groups; groups whose values are shown alike, and for which decisions are worth the same, are one."""
        worth, (released, _) = self.worth, self.facts.released
        contexts = range(len(worth.rows)) if context is None else [context]
        spend(len(worth.scales) * (len(contexts) * worth.decisions + len(released[0])))
        first: dict[object, int] = {}
        for a, scale in worth.scales.items():
            first.setdefault((scale, tuple(released[a]), tuple(tuple(worth.of(x, a)) for x in contexts)), a)
        return ((context, higher, lower) for higher, lower in permutations(first.values(), 2))

    def outputs(self, compared: Compared, value: Fraction) -> Iterator[tuple[list[int], list[int], list[int]]]:
        """List p and V q of the decisions, and their law, for everything that is released with some probability, over one unit."""
        context, higher, lower = compared
        worth, above, below = self.worth, self.facts.released[0][higher], self.facts.released[0][lower]
        c, d = worth.scales[lower] * value.denominator, worth.scales[higher] * value.numerator
        for x in range(len(worth.rows)) if context is None else [context]:
            for i, weight in [(x, 1)] if context is None else self.facts.shown[0][x]:
                p, q = [c * weight * entry for entry in worth.of(x, higher)], [d * weight * entry for entry in worth.of(x, lower)]
                spend(len(above) * (12 + 6 * len(p)), max(*p, *q).bit_length() + max(above).bit_length(), self.bits)
                for m, n, law in zip(above, below, self.laws[i], strict=True):
                    if m or n:
                        yield [m * entry for entry in p], [n * entry for entry in q], law

    def exceeds(self, compared: Compared, value: Fraction) -> bool:
        """Whether some policy nearby has a greater ratio for an ordered pair of groups."""
        return (
            sum(_greatest([x - y for x, y in zip(p, q, strict=True)], law, self.moved) for p, q, law in self.outputs(compared, value)) > 0
        )

    def attains(self, compared: Compared, value: Fraction) -> bool:
        """Whether the policy that makes p - V q greatest, and then q, has the ratio V: the sum is 0, and that of q is not."""
        total = taken = 0
        for p, q, law in self.outputs(compared, value):
            order = sorted((x - y, y, mass) for x, y, mass in zip(p, q, law, strict=True))
            masses = _moved([mass for _, _, mass in order], self.moved)
            total += sum(mass * excess for (excess, _, _), mass in zip(order, masses, strict=True))
            taken += sum(mass * y for (_, y, _), mass in zip(order, masses, strict=True))
        return total == 0 < taken

    def gives_nothing(self, compared: Compared) -> bool:
        """Whether some policy nearby gives nothing to the lower group and something to the higher one."""
        total = 0
        for p, q, law in self.outputs(compared, Fraction(1)):
            order = sorted((x, mass) for x, y, mass in zip(p, q, law, strict=True) if not y)
            left = self.moved - sum(mass for y, mass in zip(q, law, strict=True) if y)
            if left < 0 or not order:
                return False
            gone = self.moved - left
            masses = _moved([mass for _, mass in order], left)
            total += sum(mass * x for (x, _), mass in zip(order, masses, strict=True)) + gone * order[-1][0]
        return total > 0


def _greatest(values: Sequence[int], law: Sequence[int], moved: int) -> int:
    """Find the greatest mean of values when so much of a law may move."""
    order = sorted(zip(values, law, strict=True))
    top = order[-1][0]
    total: int = sum(map(mul, values, law))
    for value, mass in order:
        if mass >= moved:
            return total + moved * (top - value)
        total += mass * (top - value)
        moved -= mass
    return total


def _moved(masses: list[int], moved: int) -> list[int]:
    """Move so much, or as much as there is, from the first to the last."""
    left = moved
    for i, mass in enumerate(masses):
        masses[i] -= min(mass, left)
        left -= min(mass, left)
    masses[-1] += moved - left
    return masses


def fault_of_near(claim: Claim, facts: PolicyFacts) -> str:
    """Judge the greatest ratio over all policies within the declared drift of this one: none exceeds it, and one attains it."""
    attained = claim.evidence if isinstance(claim.evidence, Attained) else None
    if "max_drift" not in facts.declared:
        return "no drift is declared"
    if not at_most(ONE, claim.value):
        return "a greatest ratio is at least 1"
    if (attained is None) != (claim.value == ONE):
        return "a value of 1 needs no pair of groups that attains it, and any other value needs one"
    local = claim.key[0].startswith("local")
    nearby = Nearby(facts, local, facts.declared_number("max_drift"))
    if claim.value != INFINITY:
        value = Fraction(*claim.value)
        for context in range(len(facts.table.header.contexts)) if local else [None]:
            for compared in nearby.different(context):
                if nearby.exceeds(compared, value):
                    return f"some policy exceeds it {facts.named(*compared)}"
    if attained is None:
        return ""
    place = facts.place(attained, local)
    if isinstance(place, str):
        return place
    attains = nearby.gives_nothing(place) if claim.value == INFINITY else nearby.attains(place, Fraction(*claim.value))
    return "" if attains else f"no policy attains it {facts.named(*place)}"
