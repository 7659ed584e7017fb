"""What each decision is worth to each group, wherever something is released besides the group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import chain
from math import gcd

from .filters import map_of, map_through
from .rationals import as_pair, over_common_denominator
from .table import Policy, Table, globally_compared
from .work import keep, spend


@dataclass(frozen=True)
class Site:
    """What is released besides the group, where it matters: contexts whose numbers are multiples of each other are one site."""

    start: int  # of its decisions in each vector
    contexts: tuple[tuple[int, int], ...]  # true contexts that are compared here, each with the factor by which its numbers are greater


Side = tuple[tuple[int, ...], int]  # numbers site after site, over the unit of all sides times the second


@dataclass(frozen=True)
class Sides:
    """What each decision is worth to each group, wherever something is released besides the group.

    For the local ratio the sites are the true contexts, each compared by itself, and the numbers g(u,x,a).  For the global ratio they are
    the released contexts, whose sums are compared, and the numbers those of G_a(x~,u), the sum over x of P(x|a) M_X(x~|x) g(u,x,a).

    Where any utility of a range will do, there are two decisions, which are worth most and least of it, and with regard to either a group
    can get more as the higher one of a pair than as the lower one.
    """

    local: bool
    decisions: int
    sites: tuple[Site, ...]
    higher: dict[int, Side]  # by group that is compared; equal sides are one object
    lower: dict[int, Side]
    unit: int

    @property
    def groups(self) -> tuple[int, ...]:
        """The groups that are compared."""
        return tuple(self.higher)

    @cached_property
    def bits(self) -> int:
        """The length of the longest number."""
        return max((abs(entry).bit_length() for vector, _ in {*self.higher.values(), *self.lower.values()} for entry in vector), default=0)


def _sites(flat: Sequence[Sequence[int]], merged: bool) -> tuple[list[tuple[int, ...]], list[tuple[tuple[int, int], ...]]]:
    """Find the different directions of some vectors; and for each of them which vectors are multiples of it, with their factors.

    Where sums over sites are compared, the vectors of one direction are added up.  Vectors of zeros are left out: they add nothing.
    """
    found: dict[tuple[int, ...], list[tuple[int, int]]] = {}
    for i, vector in enumerate(flat):
        if divisor := gcd(*vector):
            found.setdefault(tuple(entry // divisor for entry in vector), []).append((i, divisor))
    if not merged:
        return list(found), [tuple(places) for places in found.values()]
    sums = [sum(divisor for _, divisor in places) for places in found.values()]
    return [tuple(total * entry for entry in key) for total, key in zip(sums, found, strict=True)], [()] * len(sums)


@dataclass(frozen=True)
class Worth:
    """What decisions are worth to the groups: in each true context the g(u,x,a), or in each released one the G_a(x~,u)."""

    rows: list[list[int]]  # by context; in it by group and decision
    scales: dict[int, int]  # by group, of positive mass where masses count: its numbers are over unit * scale
    unit: int
    decisions: int

    def of(self, context: int, group: int) -> list[int]:
        """List what the decisions are worth to a group in a context."""
        start = group * self.decisions
        return self.rows[context][start : start + self.decisions]


def local_worth(table: Table) -> Worth:
    """List the utilities by true context."""
    groups, decisions = len(table.header.groups), len(table.header.decisions)
    entries, unit = over_common_denominator([entry or (0, 1) for cell in table.cells for entry in cell.utility])
    keep(len(entries))
    width = groups * decisions
    return Worth([entries[i : i + width] for i in range(0, len(entries), width)], dict.fromkeys(range(groups), 1), unit, decisions)


def global_worth(table: Table, policy: Policy) -> Worth:
    """Add up masses times utilities over what the context filter makes of each true context."""
    utilities = local_worth(table)
    groups, decisions, unit = len(table.header.groups), utilities.decisions, utilities.unit
    masses, _ = over_common_denominator([cell.mass for cell in table.cells])
    spend(len(masses) * (decisions + 1), max(masses).bit_length(), unit.bit_length())
    keep(len(masses) * decisions, max(masses).bit_length() + unit.bit_length())
    gains = chain.from_iterable(utilities.rows)
    values = [mass * next(gains) for mass in masses for _ in range(decisions)]
    maps = [] if policy.context is None else [map_of([*zip(*f.matrix, strict=True)], f.total) for f in policy.context.factors]
    for each in maps:
        unit *= each.denominator
    width = groups * decisions
    values = map_through(values, maps)
    scales = {a: sum(masses[a::groups]) for a in table.figures.populated()}
    return Worth([values[i : i + width] for i in range(0, len(values), width)], scales, unit, decisions)


def sides_of(worth: Worth, local: bool) -> Sides:
    """Make sites of contexts; only two decisions are needed where what they are worth to different groups is proportional."""
    rows, decisions = worth.rows, worth.decisions
    spend(sum(map(len, rows)))
    extremes = [_extremes(row, decisions) for row in rows]
    if decisions > 2 and all(extremes):
        rows = [[row[i + u] for i in range(0, len(row), decisions) for u in both] for row, both in zip(rows, extremes, strict=True)]
        decisions = 2
    sites, sides = _laid_out(rows, local, worth.scales, decisions)
    return Sides(local, decisions, sites, sides, sides, worth.unit)


def _extremes(row: Sequence[int], decisions: int) -> tuple[int, ...]:
    """Find the decisions that are worth most and least to all groups, if what they are worth to one is a multiple of that to another."""
    found: tuple[int, ...] = (0,) * decisions
    for i in range(0, len(row), decisions):
        own = row[i : i + decisions]
        divisor = gcd(*own)
        direction = tuple(entry // divisor for entry in own) if divisor else found
        if any(found) and direction != found:
            return ()
        found = direction
    return found.index(max(found)), found.index(min(found))


@dataclass(frozen=True)
class Range:
    """The utilities from m to gamma, of two groups at most ``gap`` apart, which is no more than gamma - m."""

    gamma: Fraction
    m: Fraction
    gap: Fraction

    @property
    def worth(self) -> tuple[Fraction, ...]:
        """What the best and the worst decision are worth to the higher group, and then to the lower one, at the most and at the least."""
        return self.gamma, self.m + self.gap, self.gamma - self.gap, self.m


def local_range_sides(ranges: Sequence[Range], groups: int) -> Sides:
    """Lay out the ranges of the true contexts."""
    rows, unit = over_common_denominator([as_pair(value) for each in ranges for value in each.worth])
    sites, sides = _laid_out([rows[i : i + 4] for i in range(0, len(rows), 4)], True, {0: 1, 1: 1}, 2)
    return Sides(True, 2, sites, dict.fromkeys(range(groups), sides[0]), dict.fromkeys(range(groups), sides[1]), unit)


def global_range_sides(table: Table, of_all: Range) -> Sides:
    """Multiply the range with the masses of the true contexts."""
    worth, unit = over_common_denominator([as_pair(value) for value in of_all.worth])
    masses, _ = over_common_denominator([cell.mass for cell in table.cells])
    bits = max(masses).bit_length(), max(worth).bit_length()
    spend(5 * len(masses), *bits)
    keep(4 * len(masses), sum(bits))
    groups = len(table.header.groups)
    at = [masses[i : i + groups] for i in range(0, len(masses), groups)]
    rows = [[mass * value for pair in (worth[:2], worth[2:]) for mass in row for value in pair] for row in at]
    compared = globally_compared(table)
    scales = {a + role: sum(masses[a::groups]) for role in (0, groups) for a in compared}
    sites, sides = _laid_out(rows, False, scales, 2)
    return Sides(False, 2, sites, {a: sides[a] for a in compared}, {a: sides[a + groups] for a in compared}, unit)


def _laid_out(rows: list[list[int]], local: bool, scales: dict[int, int], decisions: int) -> tuple[tuple[Site, ...], dict[int, Side]]:
    """Make sites of rows, each of which has the numbers of all sides; the scales say which sides are needed."""
    keys, places = _sites(rows, not local)
    spend(4 * sum(map(len, rows)))
    sites = tuple(Site(i * decisions, contexts) for i, contexts in enumerate(places))
    sides: dict[int, Side] = {}
    known: dict[Side, Side] = {}
    for a, scale in scales.items():
        vector = tuple(entry for key in keys for entry in key[a * decisions : (a + 1) * decisions])
        divisor = gcd(scale, *vector)
        side = tuple(entry // divisor for entry in vector), scale // divisor
        sides[a] = known.setdefault(side, side)
    return sites, sides
