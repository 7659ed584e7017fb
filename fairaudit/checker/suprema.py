"""The greatest ratio over all policies behind a group filter: one sum for each ordered pair of groups.

A policy decides u with some probability T(u|o) where the filters release o.  The numerator of its ratio minus V times the denominator is
the sum over o and u of T(u|o) (p - V q)(o,u), which is at most S(V), the sum over o of the greatest p - V q.  So no policy exceeds V >= 1
exactly if S(V) <= 0 for every ordered pair of groups.  With a floor tau of the denominator, S(k) <= (V - k) tau for some k will do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import permutations
from operator import add

from .claims import Claim
from .likelihoods import Classes, Likelihoods, PairLaw
from .policy_evidence import Attained
from .policy_facts import PolicyFacts
from .rationals import INFINITY, ONE, at_most
from .sides import Sides, Site
from .work import keep, spend

Vertex = tuple[int, int]  # numerator and denominator of a decision at a site: what it is worth to the lower and to the higher group


class Pair:
    """An ordered pair of groups: what decisions are worth to both, and the law of their likelihood ratios.

    All sums are over ``unit`` of the sides, the unit of the law, both scales, and the denominator of k.
    """

    def __init__(self, sides: Sides, law: PairLaw, higher: int, lower: int) -> None:
        self.sides, self.law = sides, law
        self.above, self.scale_below = sides.higher[higher]  # crosswise: each over the product of both
        self.below, self.scale_above = sides.lower[lower]
        self.bits = law.bits + max(self.scale_above, self.scale_below).bit_length()
        self._hulls: dict[int, list[Vertex]] = {}

    def worth(self, sites: Sequence[Site]) -> Iterator[list[tuple[int, int]]]:
        """List what the decisions are worth at some sites, to the higher and to the lower group."""
        n = self.sides.decisions
        for site in sites:
            spend(6 * n * len(self.law.classes), 2 * self.bits, self.sides.bits)
            window = slice(site.start, site.start + n)
            yield list(zip(self.above[window], self.below[window], strict=True))

    def unit(self, of_law: int, k: Fraction) -> int:
        """What sums are over."""
        return self.sides.unit * of_law * self.scale_above * self.scale_below * k.denominator

    def coarse(self, outer: Classes, k: Fraction) -> tuple[list[int], int]:
        """Bound the sums of the greatest p - k q at each site from above, and say what they are over."""
        classes, over = outer
        n = self.sides.decisions
        spend(len(self.above) * len(classes), 2 * self.bits + k.numerator.bit_length(), self.sides.bits)
        totals = [0] * len(self.sides.sites)
        for p, q in classes:
            c, d = p * self.scale_above * k.denominator, q * self.scale_below * k.numerator
            excess = [c * x - d * y for x, y in zip(self.above, self.below, strict=True)]
            totals = [*map(add, totals, excess if n == 1 else map(max, *(excess[u::n] for u in range(n))))]
        return totals, self.unit(over, k)

    def exact(self, k: Fraction, site: Site) -> tuple[int, int]:
        """Compute the sum of the greatest p - k q at a site, and the q that it takes (over the same, but for the denominator of k).

        A decision that is best for some p/q is a vertex of the hull; from one vertex to the next the greater p/q changes over.
        """
        hull = self._hull(site)
        bits = self.bits + k.numerator.bit_length() + k.denominator.bit_length()
        spend(8 * len(hull), bits, bits + self.sides.bits)
        c, d = self.scale_above * k.denominator, self.scale_below * k.numerator
        y, x = hull[0]
        total, taken = self.law.unit * (c * x - d * y), self.law.unit * y
        for next_y, next_x in hull[1:]:
            gain, loss = c * (next_x - x), d * (next_y - y)
            p, q = self.law.above(loss, gain)
            total += p * gain - q * loss
            taken += q * (next_y - y)
            y, x = next_y, next_x
        return total, taken * self.scale_below

    def _hull(self, site: Site) -> list[Vertex]:
        """Find the decisions that are best for some p/q, from the least p/q to the greatest."""
        hull = self._hulls.get(site.start)
        if hull is None:
            n = self.sides.decisions
            spend(12 + 3 * n, self.sides.bits, self.sides.bits)
            hull = []
            window = slice(site.start, site.start + n)
            for y, x in sorted(zip(self.below[window], self.above[window], strict=True)):
                if hull and x <= hull[-1][1]:
                    continue
                while hull and (y == hull[-1][0] or (len(hull) > 1 and _is_inside(hull[-2], hull[-1], (y, x)))):
                    hull.pop()
                hull.append((y, x))
            self._hulls[site.start] = hull
        return hull


def _is_inside(first: Vertex, middle: Vertex, last: Vertex) -> bool:
    """Say whether no p/q prefers the middle one to both others."""
    return (middle[0] - first[0]) * (last[1] - middle[1]) >= (last[0] - middle[0]) * (middle[1] - first[1])


class Prover:
    """Proofs, each by one of some multipliers k, that no policy exceeds a value V >= 1; V must be one of them where there is no floor."""

    def __init__(self, value: Fraction, multipliers: Iterable[Fraction]) -> None:
        self.value = value
        self.multipliers = sorted({k for k in multipliers if k <= value})
        self.hint = len(self.multipliers) - 1  # which of them proved something last

    def leaves(self, pair: Pair, floors: Sequence[Fraction]) -> list[int]:
        """List the numbers of the sites, each compared by itself, where no multiplier proves it; 0 for all of them where sums are compared.

        The floors are those of the denominator, by site or of the sum.
        """
        k, sides = self.multipliers[self.hint], pair.sides
        unproven: list[int] = []
        for outer in [pair.law.outer] if sides.local else [pair.law.outer, pair.law.finer]:
            totals, over = pair.coarse(outer, k)
            room = (self.value - k) * over
            sums = totals if sides.local else [sum(totals)]
            unproven = [i for i, total in enumerate(sums) if total > 0 and (not floors[i] or total > room * floors[i])]
            if not unproven:
                return []
        return [i for i in unproven if not self.proves(pair, sides.sites[i : i + 1] if sides.local else sides.sites, floors[i])]

    def proves(self, pair: Pair, sites: Sequence[Site], floor: Fraction) -> bool:
        """Look for a multiplier that proves it of some sites together; what has to be at most 0 is convex in k."""
        low, high, at = 0, len(self.multipliers), self.hint
        if not floor:  # the sums fall in k: the last one, which is V itself, proves whatever another one does
            low = at = high - 1
        while low < high:
            k = self.multipliers[at]
            sums = [pair.exact(k, site) for site in sites]
            over = pair.unit(pair.law.unit, k)
            if sum(total for total, _ in sums) <= (self.value - k) * floor * over:
                self.hint = at
                return True
            if sum(taken for _, taken in sums) * k.denominator > floor * over:  # the slope is negative
                low = at + 1
            else:
                high = at
            at = (low + high) // 2
        return False


def unproven(
    prover: Prover, sides: Sides, likelihoods: Likelihoods, floors: Mapping[int, Sequence[Fraction]]
) -> Iterator[tuple[int, int, int]]:
    """List the ordered pairs, and numbers of sites, of which no multiplier proves that policies keep the value.

    The floors are by lower group, and equal ones one object.
    """
    found: dict[object, list[int]] = {}
    above = {a: id(side) for a, side in sides.higher.items()}
    below = {a: (id(side), id(floors[a])) for a, side in sides.lower.items()}

    def leaves(law: PairLaw, higher: int, lower: int) -> list[int]:
        key = law, above[higher], below[lower]
        if key not in found:
            keep(4)
            found[key] = prover.leaves(Pair(sides, law, higher, lower), floors[lower])
        return found[key]

    first, second, *_ = sides.groups
    if len({*above.values()}) == len({*below.values()}) == 1 and not any(leaves(law, first, second) for law in likelihoods.every()):
        return
    spend(10 * len(sides.groups) ** 2)
    for higher, lower in permutations(sides.groups, 2):
        for site in leaves(likelihoods.of(higher, lower), higher, lower):
            yield higher, lower, site


def no_floors(sides: Sides) -> dict[int, Sequence[Fraction]]:
    """Say of no site and group that policies keep a floor."""
    return dict.fromkeys(sides.groups, [Fraction(0)] * (len(sides.sites) if sides.local else 1))


def named(facts: PolicyFacts, sides: Sides, higher: int, lower: int, site: int) -> str:
    """Name an ordered pair of groups, and a context of a site where it is compared by itself."""
    return facts.named(sides.sites[site].contexts[0][0] if sides.local else None, higher, lower)


def fault_of_policies(claim: Claim, facts: PolicyFacts) -> str:
    """Judge the greatest ratio over all policies: none exceeds it, and one attains it."""
    attained = claim.evidence if isinstance(claim.evidence, Attained) else None
    if not at_most(ONE, claim.value):
        return "a greatest ratio is at least 1"
    if (attained is None) != (claim.value == ONE):
        return "a value of 1 needs no pair of groups that attains it, and any other value needs one"
    local = claim.key[0].startswith("local")
    sides, likelihoods = facts.sides(local), facts.likelihoods
    if claim.value != INFINITY:
        value = Fraction(*claim.value)
        for exceeding in unproven(Prover(value, [value]), sides, likelihoods, no_floors(sides)):
            return f"some policy exceeds it {named(facts, sides, *exceeding)}"
    if attained is None:
        return ""
    place = facts.place(attained, local)
    if isinstance(place, str):
        return place
    context, higher, lower = place
    sites = [site for site in sides.sites if not local or context in [x for x, _ in site.contexts]]
    pair = Pair(sides, likelihoods.of(higher, lower), higher, lower)
    attains = _gives_nothing(pair, sites) if claim.value == INFINITY else _attains(pair, sites, Fraction(*claim.value))
    return "" if attains else f"no policy attains it {facts.named(context, higher, lower)}"


def _attains(pair: Pair, sites: Sequence[Site], value: Fraction) -> bool:
    """Whether the policy that makes p - V q greatest, and then q, has the ratio V: the sum is 0, and that of q is not."""
    c, d = pair.scale_above * value.denominator, pair.scale_below * value.numerator
    total = taken = 0
    for worth in pair.worth(sites):
        for p, q in pair.law.classes:
            excess, best = max((c * p * x - d * q * y, q * y) for x, y in worth)
            total += excess
            taken += best
    return total == 0 < taken


def _gives_nothing(pair: Pair, sites: Sequence[Site]) -> bool:
    """Whether some policy gives nothing to the lower group and something to the higher one."""
    total = 0
    for worth in pair.worth(sites):
        for p, q in pair.law.classes:
            possible = [p * x for x, y in worth if not q * y]
            if not possible:
                return False
            total += max(possible)
    return total > 0
