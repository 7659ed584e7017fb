"""What T13 asks of a filter so that no policy behind it exceeds a target: sums that are convex in the filter, one for each ordered pair.

At V = R* the sum S(V) = Σ max_u [p − V·q] of a pair of groups must be at most 0. Whatever the filter is, always taking the decision that
is worth least adds the same to it; of each better decision only what it is worth beyond that depends on the filter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from math import gcd, lcm

from fairaudit.theorems.t13_range import UtilityRange
from fairaudit.theorems.t13_tables import Tables

Better = tuple[tuple[int, int], ...]
"""For each decision A and B: beyond the one that is worth least it is worth A to the first group, and B times the target is lost."""


@dataclass(frozen=True)
class PolicySum:
    """One ordered pair of groups: Σ over blocks and ã of max(0, A·M(ã|first) − B·M(ã|second)) ≤ room, of each block the greatest.

    Attributes
    ----------
    first, second : int
        Positions of the groups.
    blocks : tuple of Better
        One for each released context that policies tell apart; one within a context.
    room : int
        What the decisions that are worth least leave.
    """

    first: int
    second: int
    blocks: tuple[Better, ...]
    room: int

    @property
    def hidden(self) -> bool:
        """Whether a filter that hides the group keeps it; if not, none does, since hiding is what can be done behind any filter."""
        return sum(max([0, *(a - b for a, b in better)]) for better in self.blocks) <= self.room

    def holds(self, rows: Sequence[Sequence[int]], bottom: int) -> bool:
        """Whether a table of integers over a denominator keeps it."""
        pairs = list(zip(rows[self.first], rows[self.second], strict=True))
        total = sum(max([0, *(a * p - b * q for a, b in better)]) for better in self.blocks for p, q in pairs)
        return total <= self.room * bottom


def sums_of_tables(tables: Tables, target: Fraction) -> tuple[PolicySum, ...]:
    """The sums of a known utility, each different one once."""
    envelopes = {}
    found = []
    for row in tables.of.tolist():
        compared = [a for a, table in enumerate(row) if table >= 0]
        for first, second in permutations(compared, 2):
            key = row[first], row[second]
            if key not in envelopes:
                envelopes[key] = _beyond_the_least(tables.envelopes(*key), target)
            found.append(PolicySum(first, second, *envelopes[key]))
    return tuple(dict.fromkeys(found))


def sums_of_range(size: int, declared: UtilityRange, target: Fraction) -> tuple[PolicySum, ...]:
    """The sums of every utility of a range: K + (γ − K − m)·H_{R*} ≤ m·(R* − 1) for each ordered pair of rows.

    Examples
    --------
    >>> sums_of_range(2, UtilityRange(Fraction(3), Fraction(1)), Fraction(7, 5))[0]
    PolicySum(first=0, second=1, blocks=(((5, 7),),), room=1)
    """
    scale = lcm(declared.span.denominator, declared.m.denominator, declared.gap.denominator)
    span, least, most = (int(v * scale) for v in (declared.span, declared.m, declared.m + declared.gap))
    points = [(span + most, span + least), (most, least)]
    blocks, room = _beyond_the_least([points], target)
    return tuple(PolicySum(first, second, blocks, room) for first, second in permutations(range(size), 2))


def _beyond_the_least(envelopes: Sequence[Sequence[tuple[int, int]]], target: Fraction) -> tuple[tuple[Better, ...], int]:
    """Blocks and room of decisions (A, B) that fall in both, in lowest terms; blocks without a choice are left out."""
    n, d = target.numerator, target.denominator
    blocks, room = [], 0
    for *others, (least_a, least_b) in envelopes:
        room += n * least_b - d * least_a
        blocks.append([(d * (a - least_a), n * (b - least_b)) for a, b in others if a > least_a])
    common = gcd(room, *(v for better in blocks for pair in better for v in pair)) or 1
    return tuple(tuple((a // common, b // common) for a, b in better) for better in blocks if better), room // common
