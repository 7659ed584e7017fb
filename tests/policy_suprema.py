"""The greatest ratio over policies behind filters, over dense tables of plain fractions."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import permutations, product
from math import prod
from typing import Any

from plain_certificates import INF, ratio
from policy_certificates import Policy

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
