"""What each decision is worth to each group, wherever something is released besides the group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import gcd

from .filters import map_of, map_through
from .rationals import over_common_denominator
from .table import Policy, Table, globally_compared
from .work import keep, spend


@dataclass(frozen=True)
class Site:
    """What is released besides the group, where it matters: contexts whose numbers are multiples of each other are one site."""

    start: int  # of its decisions in each vector
    contexts: tuple[tuple[int, int], ...]  # true contexts that are compared here, each with the factor by which its numbers are greater


@dataclass(frozen=True)
class Sides:
    """What each decision is worth to each group, wherever something is released besides the group.

    For the local ratio the sites are the true contexts, each compared by itself, and the numbers g(u,x,a).  For the global ratio they are
    the released contexts, whose sums are compared, and the numbers those of G_a(x~,u), the sum over x of P(x|a) M_X(x~|x) g(u,x,a).
    """

    local: bool
    decisions: int
    groups: tuple[int, ...]  # that are compared
    sites: tuple[Site, ...]
    vectors: dict[int, tuple[int, ...]]  # by group, site after site
    scales: dict[int, int]  # by group: its numbers are those of the vector over unit * scale
    unit: int

    @cached_property
    def bits(self) -> int:
        """The length of the longest number."""
        return max((abs(entry).bit_length() for vector in self.vectors.values() for entry in vector), default=0)


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


def _gains(table: Table) -> tuple[list[list[int]], int]:
    """Write the utilities of each true cell over one denominator."""
    decisions = len(table.header.decisions)
    entries, unit = over_common_denominator([entry or (0, 1) for cell in table.cells for entry in cell.utility])
    keep(len(entries))
    return [entries[i : i + decisions] for i in range(0, len(entries), decisions)], unit


def local_sides(table: Table) -> Sides:
    """Lay out the utilities by true context."""
    gains, unit = _gains(table)
    groups, decisions = len(table.header.groups), len(table.header.decisions)
    rows = [[entry for cell in gains[i : i + groups] for entry in cell] for i in range(0, len(gains), groups)]
    return _laid_out(rows, True, dict.fromkeys(range(groups), 1), unit, decisions)


def global_sides(table: Table, policy: Policy) -> Sides:
    """Add up masses times utilities over what the context filter makes of each true context."""
    gains, unit = _gains(table)
    groups, decisions = len(table.header.groups), len(table.header.decisions)
    masses, _ = over_common_denominator([cell.mass for cell in table.cells])
    spend(len(masses) * (decisions + 1), max(masses).bit_length(), unit.bit_length())
    keep(len(masses) * decisions, max(masses).bit_length() + unit.bit_length())
    values = [mass * gain for mass, own in zip(masses, gains, strict=True) for gain in own]
    maps = [] if policy.context is None else [map_of([*zip(*f.matrix, strict=True)], f.total) for f in policy.context.factors]
    for each in maps:
        unit *= each.denominator
    width = groups * decisions
    values = map_through(values, maps)
    rows = [values[i : i + width] for i in range(0, len(values), width)]
    scales = {a: sum(masses[a::groups]) for a in globally_compared(table)}
    return _laid_out(rows, False, scales, unit, decisions)


def _laid_out(rows: list[list[int]], local: bool, scales: dict[int, int], unit: int, decisions: int) -> Sides:
    keys, places = _sites(rows, not local)
    spend(4 * sum(map(len, rows)))
    sites = tuple(Site(i * decisions, contexts) for i, contexts in enumerate(places))
    vectors: dict[int, tuple[int, ...]] = {}
    known: dict[tuple[int, ...], tuple[int, ...]] = {}
    for a, scale in scales.items():
        vector = tuple(entry for key in keys for entry in key[a * decisions : (a + 1) * decisions])
        divisor = gcd(scale, *vector)
        vector = tuple(entry // divisor for entry in vector)
        vectors[a] = known.setdefault(vector, vector)  # equal vectors are one object
        scales[a] = scale // divisor
    return Sides(local, decisions, tuple(scales), sites, vectors, scales, unit)
