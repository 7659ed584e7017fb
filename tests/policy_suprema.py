"""The greatest ratio over policies behind filters, over dense tables of plain fractions."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise, permutations, product
from math import prod
from typing import Any

import tiers
from plain_certificates import INF, ratio
from policy_certificates import Policy, hockey_stick

ZERO = Fraction(0)
Worth = list[list[Fraction]]  # by output and decision


@dataclass(frozen=True, eq=False)
class Compared:
    """An ordered pair of groups, and what each decision under each output (x̃,ã) adds to the expectation of either."""

    context: int | None
    higher: int
    lower: int
    p: Worth
    q: Worth


def shares(p: Policy, a: int) -> dict[int, Fraction]:
    """P(x|a)."""
    return {x: p.weight(x, a) / p.of_group(a) for x in range(len(p.true_x))}


def releases_of(p: Policy, a: int) -> list[Fraction]:
    """M_A(ã|a) of all releases together."""
    return [prod(row, start=Fraction(1)) for row in product([p.A[a][j] for j in p.reach_a], repeat=p.releases)]


def worth(p: Policy, of_x: dict[int, Fraction], a: int) -> Worth:
    """What a decision under an output adds to a mean of E(x,a) with weights of the contexts."""
    return [
        [sum((w * p.X[x][i] * m * p.g[x, a][u] for x, w in of_x.items()), ZERO) for u in range(p.n)]
        for i in p.reach_x
        for m in releases_of(p, a)
    ]


@cache
def compared(p: Policy, local: bool) -> tuple[Compared, ...]:
    """Everything that is compared."""
    groups = range(len(p.true_a))
    found = []
    if local:
        for x in range(len(p.true_x)):
            of = {a: worth(p, {x: Fraction(1)}, a) for a in groups}
            found += [Compared(x, a, b, of[a], of[b]) for a, b in permutations(groups, 2)]
        return tuple(found)
    of = {a: worth(p, shares(p, a), a) for a in groups if p.of_group(a)}
    return tuple(Compared(None, a, b, of[a], of[b]) for a, b in permutations(of, 2))


def by_enumeration(case: Compared) -> Any:
    """The greatest ratio of all deterministic policies."""
    choices = product(*(range(len(row)) for row in case.p))
    sums = (tuple(sum((w[u] for w, u in zip(rows, choice, strict=True)), ZERO) for rows in (case.p, case.q)) for choice in choices)
    return max([Fraction(1), *(ratio(*pair) for pair in sums)])


def by_steps(case: Compared) -> Any:
    """The greatest ratio, at least 1: the best policy for a value has a ratio that is the next value, until it is no better."""
    value = Fraction(1)
    while True:
        best = [
            max(zip((x - value * y for x, y in zip(p, q, strict=True)), q, p, strict=True)) for p, q in zip(case.p, case.q, strict=True)
        ]
        if sum(excess for excess, _, _ in best) <= 0:
            return value
        below = sum(q for _, q, _ in best)
        if not below:
            return INF
        value = sum(p for _, _, p in best) / below


# Near a policy


def laws_of(p: Policy) -> list[list[Fraction]]:
    """The laws of the policy under each output."""
    return [p.at(i, j) for i in p.reach_x for j in p.reach_a]


def moved(law: list[Fraction], drift: Fraction, order: Sequence[int]) -> list[Fraction]:
    """Move so much of a law from the decisions that come first in an order to the one that comes last."""
    found, left = [*law], drift
    for u in order:
        part = min(left, found[u])
        found[u] -= part
        left -= part
    found[order[-1]] += drift - left
    return found


def sums(case: Compared, laws: list[list[Fraction]]) -> tuple[Fraction, Fraction]:
    """What both groups get of a policy."""
    both = (
        sum((t * v for law, row in zip(laws, rows, strict=True) for t, v in zip(law, row, strict=True)), ZERO) for rows in (case.p, case.q)
    )
    return next(both), next(both)


def near_by_enumeration(case: Compared, laws: list[list[Fraction]], drift: Fraction) -> Any:
    """The greatest ratio over policies of which each law comes of some order of the decisions: among them are all extreme points."""
    choices = product(*({tuple(moved(law, drift, order)) for order in permutations(range(len(law)))} for law in laws))
    return max([Fraction(1), *(ratio(*sums(case, [*map(list, choice)])) for choice in choices)])


def near_by_steps(case: Compared, laws: list[list[Fraction]], drift: Fraction) -> Any:
    """The same by steps, as for all policies."""
    value = Fraction(1)
    while True:
        best = []
        for law, p, q in zip(laws, case.p, case.q, strict=True):
            best.append(moved(law, drift, sorted(range(len(law)), key=lambda u: (p[u] - value * q[u], q[u]))))
        above, below = sums(case, best)
        if above <= value * below:
            return value
        if not below:
            return INF
        value = above / below


# What is declared


def declare(p: Policy, seed: int) -> None:
    """Declare a range of the utility, perhaps also of single contexts, perhaps floors."""
    pick = random.Random(tiers.fresh(f"declared {seed}"))

    def above(value: Fraction) -> Fraction:
        return value + pick.choice([0, 0, Fraction(1, 3), 1])

    def below(value: Fraction) -> Fraction:
        return value * pick.choice([0, Fraction(1, 2), 1, 1, 1])

    p.declared = {"gamma": above(p.own["gamma"]), "m": below(p.own["m"])}
    if pick.random() < 0.5:
        p.declared["lipschitz"] = above(p.own["lipschitz"])
    groups = range(len(p.true_a))
    means = [sum(p.weight(x, a) * p.mean(x, a) for x in range(len(p.true_x))) / p.of_group(a) for a in groups if p.of_group(a)]
    if pick.random() < 0.6:
        p.declared["tau"] = below(p.tau)
    if pick.random() < 0.4:
        p.declared["global_tau"] = below(min(means))
    p.declared_in = {}
    for x in range(len(p.true_x)):
        given = [e for a in groups for e in p.g[x, a]]
        own = {"gamma": above(max(given)), "m": below(min(given)), "tau": below(min(p.mean(x, a) for a in groups))}
        own = {key: value for key, value in own.items() if pick.random() < 0.4}
        if own and pick.random() < 0.6:
            p.declared_in[x] = own


def floor_in(p: Policy, x: int) -> Fraction:
    """The declared floor of a true context."""
    return max(p.declared.get("tau", ZERO), p.declared_in.get(x, {}).get("tau", ZERO))


def mean_floor(p: Policy, a: int) -> Fraction:
    """What the declared floors leave for the mean of a group."""
    return max(p.declared.get("global_tau", ZERO), sum((w * floor_in(p, x) for x, w in shares(p, a).items()), ZERO))


# Any utility of the declared range


@dataclass(frozen=True)
class Ranged:
    """Two rows, and the range of the utility by which they are compared, with the floor of what the second group gets."""

    rows: tuple[list[Fraction], list[Fraction]]
    gamma: Fraction
    m: Fraction
    gap: Fraction
    tau: Fraction

    def excess(self, k: Fraction) -> Fraction:
        """K + (γ − K − m)·H_k − (k − 1)·m."""
        return self.gap + (self.gamma - self.gap - self.m) * hockey_stick(self.rows, k) - (k - 1) * self.m

    def proved(self, k: Fraction) -> Any:
        """What one multiplier proves of policies that keep the floor."""
        return k + max(ZERO, self.excess(k)) / self.tau

    def turns(self) -> list[Fraction]:
        """Where the excess is not linear in k ≥ 0."""
        return sorted({ZERO, *(p / q for p, q in zip(*self.rows, strict=True) if q)})

    def least(self) -> Any:
        """The least V ≥ 1 at which the excess is not positive; it falls, and is linear between the turns."""
        turns = [Fraction(1), *(k for k in self.turns() if k > 1)]
        if self.excess(turns[0]) <= 0:
            return turns[0]
        for low, high in pairwise([*turns, turns[-1] + 1]):
            rest, fall = self.excess(low), self.excess(low) - self.excess(high)
            root = low + rest * (high - low) / fall if fall else INF
            if root <= high or (high > turns[-1]):
                return root
        raise AssertionError


def ranged(p: Policy, local: bool) -> list[Ranged]:
    """All pairs of rows with their ranges."""
    rows = [releases_of(p, a) for a in range(len(p.true_a))]

    def of(own: dict[str, Fraction], one: list[Fraction], other: list[Fraction], tau: Fraction) -> Ranged:
        gamma, m = (own.get(key, p.declared[key]) for key in ("gamma", "m"))
        return Ranged((one, other), gamma, m, min(p.declared.get("lipschitz", p.own["lipschitz"]), gamma - m), tau)

    if local:
        return [
            of(p.declared_in.get(x, {}), one, other, floor_in(p, x)) for x in range(len(p.true_x)) for one, other in permutations(rows, 2)
        ]
    mixed = {a: [w * m for w in shares(p, a).values() for m in rows[a]] for a in range(len(rows)) if p.of_group(a)}
    return [of({}, mixed[a], mixed[b], mean_floor(p, b)) for a, b in permutations(mixed, 2)]
