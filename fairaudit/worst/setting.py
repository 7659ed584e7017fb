"""The constraints of a class over a law, with their numbers, as docs/certificate-worst-case.md lists them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from fairaudit.exact.extended import ONE, ZERO
from fairaudit.exact.linear_programs import greatest_over_box, reduced
from fairaudit.worst.layout import Layout, Terms


@dataclass(frozen=True)
class _Numbering:
    """Where constraints begin, the floors not counted: by cell, by context, and of the rows at the end."""

    orders: dict[int, int]
    distances: dict[int, int]
    rows: int
    ranges: dict[int, int]
    family: int
    end: int


@dataclass(frozen=True, eq=False)
class Setting(Layout):
    """A class laid out over a law, with its constraints: floors, order, distances, rows, and those of a family, numbered in this order."""

    order: list[tuple[int, int]]
    metric: list[list[Fraction]] | None
    rows: list[tuple[Terms, Fraction]]
    """Rows over the variables g."""

    @cached_property
    def chain(self) -> list[int] | None:
        """The decisions in increasing order, if the order is one chain of all of them and the class is blind."""
        order = self.order
        if not self.of.blind or not order or any(one[1] != other[0] for one, other in pairwise(order)):
            return None
        listed = [order[0][0], *(high for _, high in order)]
        return listed if len(listed) == len(set(listed)) == self.n else None

    def concerned(self, block: int) -> list[int]:
        """Positions of the contexts whose constraints concern a block."""
        place = self.places[block]
        return list(range(len(self.contexts))) if place is None or self.of.couples else [place]

    def floors(self, block: int, pair: tuple[int, int]) -> list[int]:
        """Members that keep the floor, in the order of their constraints."""
        if self.of.tau is None:
            return []
        return list(pair) if self.of.tau_on == "pair" else self.members[block]

    @cached_property
    def tables(self) -> dict[tuple[int, ...], _Numbering]:
        """Numberings of variables that were asked for, kept."""
        return {}

    def numbering(self, block: int) -> _Numbering:
        """Where each kind of constraint begins, without the floors."""
        key = tuple(self.concerned(block))
        if key not in self.tables:
            at, orders, distances = 0, {}, {}
            for place in key:
                for cell in self.slots(place):
                    orders[cell] = at
                    at += len(self.order)
            for place in key:
                distances[place] = at
                if self.of.lipschitz is not None:
                    size = len(self.cells[place])
                    at += size * (size - 1) * self.n
            rows = at
            at += len(self.rows)
            ranges: dict[int, int] = {}
            if self.of.family is not None:
                for place in range(len(self.contexts)):
                    for cell in self.slots(place):
                        ranges[cell] = at
                        at += 2 * self.n
            family = at
            at += len(self.of.family.rows) if self.of.family is not None else 0
            self.tables[key] = _Numbering(orders, distances, rows, ranges, family, at)
        return self.tables[key]

    def order_numbers(self, block: int, cell: int) -> range:
        """Constraints of the order in one row of the utility, without the floors."""
        start = self.numbering(block).orders[cell]
        return range(start, start + len(self.order))

    def distance_numbers(self, block: int, first: int, second: int) -> range:
        """Constraints g(first) − g(second) ≤ L·d between two cells of a context, without the floors."""
        place = self.place_of[first]
        cells = self.cells[place]
        i, j = cells.index(first), cells.index(second)
        start = self.numbering(block).distances[place] + (i * (len(cells) - 1) + j - (j > i)) * self.n
        return range(start, start + self.n)

    def reach(self, first: int, second: int) -> Fraction:
        """L·d of the groups of two cells."""
        a, b = self.group_of[first], self.group_of[second]
        distance = (ONE if a != b else ZERO) if self.metric is None else self.metric[a][b]
        constant: Fraction = self.of.lipschitz * distance
        return constant

    def all_constraints(self, block: int) -> list[tuple[Terms, Fraction]]:
        """Every constraint but the floors and the box, in order."""
        listed: list[tuple[Terms, Fraction]] = []
        for place in self.concerned(block):
            for cell in self.slots(place):
                listed += [self._order_row(cell, low, high) for low, high in self.order]
        if self.of.lipschitz is not None:
            for place in self.concerned(block):
                for first in self.cells[place]:
                    for second in self.cells[place]:
                        if first != second:
                            listed += [self._distance_row(first, second, u) for u in range(self.n)]
        listed += [(self.in_variables(terms), bound) for terms, bound in self.rows]
        if self.of.family is not None:
            for place in range(len(self.contexts)):
                for cell in self.slots(place):
                    for u in range(self.n):
                        v = self.variable(cell, u)
                        listed.append((self.in_variables({v: -ONE}), -self.of.m))
                        listed.append((self.in_variables({v: ONE}), self.of.gamma))
            for coefficients, bound in self.of.family.rows:
                listed.append(({k: c for k, c in enumerate(coefficients) if c}, bound))
        return listed

    @cached_property
    def listed(self) -> dict[tuple[int, ...], list[tuple[Terms, Fraction]]]:
        """Constraints that were asked for, kept."""
        return {}

    def constraint(self, block: int, pair: tuple[int, int], number: int) -> tuple[Terms, Fraction]:
        """A constraint by its number."""
        floors = self.floors(block, pair)
        if number < len(floors):
            return {v: -c for v, c in self.vector(floors[number]).items()}, -self.of.tau
        number -= len(floors)
        numbering = self.numbering(block)
        for cell, start in numbering.orders.items():
            if self.order and start <= number < start + len(self.order):
                return self._order_row(cell, *self.order[number - start])
        for place, start in numbering.distances.items():
            size = len(self.cells[place])
            if self.of.lipschitz is not None and start <= number < start + size * (size - 1) * self.n:
                index, u = divmod(number - start, self.n)
                i, j = divmod(index, size - 1)
                cells = self.cells[place]
                return self._distance_row(cells[i], cells[j + (j >= i)], u)
        key = tuple(self.concerned(block))
        if key not in self.listed:
            self.listed[key] = self.all_constraints(block)
        return self.listed[key][number]

    def _order_row(self, cell: int, low: int, high: int) -> tuple[Terms, Fraction]:
        if low == high:
            return {}, ZERO
        return self.in_variables({self.variable(cell, low): ONE, self.variable(cell, high): -ONE}), ZERO

    def _distance_row(self, first: int, second: int, u: int) -> tuple[Terms, Fraction]:
        return self.in_variables({self.variable(first, u): ONE, self.variable(second, u): -ONE}), self.reach(first, second)

    def proves(self, block: int, pair: tuple[int, int], multipliers: Mapping[int, Fraction], ratio: Fraction) -> bool:
        """Whether multipliers prove that no utility of the class has a greater ratio of the pair: F(ratio) ≤ 0."""
        return self.excess(block, pair, multipliers, ratio) <= 0

    def excess(self, block: int, pair: tuple[int, int], multipliers: Mapping[int, Fraction], ratio: Fraction) -> Fraction:
        """F(ratio)."""
        c = dict(self.vector(pair[0]))
        for v, q in self.vector(pair[1]).items():
            c[v] = c.get(v, ZERO) - ratio * q
        constraints = ((y, *self.constraint(block, pair, number)) for number, y in multipliers.items())
        rest, total = reduced(c, ((y, terms.items(), bound) for y, terms, bound in constraints))
        return total + greatest_over_box((value, *self.box(v)) for v, value in rest.items())
