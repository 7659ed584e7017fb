"""A class of utilities laid out over a law: variables with boxes, and constraints with their numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import ONE, ZERO
from fairaudit.exact.linear_programs import greatest_over_box, reduced
from fairaudit.exact.rationals import option_value, rational
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.model.utility_class import LinearRow, UtilityClass, read_number
from fairaudit.tables.label_text import label_text
from fairaudit.tables.values import Label

Terms = dict[int, Fraction]


# The class on a law: variables, constraints and their numbers, as docs/certificate-worst-case.md lists them


@dataclass(frozen=True, eq=False)
class Setting:
    """A class laid out over a law."""

    law: Law
    of: UtilityClass
    quantity: Quantity
    contexts: list[int]
    """Contexts that have a cell."""
    cells: list[list[int]]
    """The cells of each of them."""
    members: list[list[int]]
    """What is compared: the cells of each context with two or more, or the global groups."""
    places: list[int | None]
    """For each block of members the position of its context."""
    order: list[tuple[int, int]]
    metric: list[list[Fraction]] | None
    rows: list[tuple[Terms, Fraction]]
    """Rows over the variables g."""
    features: list[list[list[Fraction]]] | None
    """By cell, decision and parameter."""

    @property
    def n(self) -> int:
        """Number of decisions."""
        return len(self.law.decisions)

    @cached_property
    def chain(self) -> list[int] | None:
        """The decisions in increasing order, if the order is one chain of all of them and the class is blind."""
        order = self.order
        if not self.of.blind or not order or any(one[1] != other[0] for one, other in pairwise(order)):
            return None
        listed = [order[0][0], *(high for _, high in order)]
        return listed if len(listed) == len(set(listed)) == self.n else None

    @cached_property
    def place_of(self) -> list[int]:
        """Position of the context of each cell."""
        where = {x: position for position, x in enumerate(self.contexts)}
        return [where[x] for x in self.law.cell_context.tolist()]

    @cached_property
    def group_of(self) -> list[int]:
        """Group of each cell."""
        return [int(a) for a in self.law.cell_group.tolist()]

    def variable(self, cell: int, u: int) -> int:
        """Variable g(u,x,a) of a cell."""
        return (self.place_of[cell] if self.of.blind else cell) * self.n + u

    def slots(self, place: int) -> list[int]:
        """One cell for each utility row in a context: its first cell when the class is blind."""
        return self.cells[place][:1] if self.of.blind else self.cells[place]

    @cached_property
    def probabilities(self) -> dict[int, list[Fraction]]:
        """P(·|x,a) of the cells that were asked for, kept."""
        return {}

    def row(self, cell: int) -> list[Fraction]:
        """P(·|x,a), exact."""
        if cell not in self.probabilities:
            row = self.law.row(cell)
            total = sum(row)
            self.probabilities[cell] = [Fraction(v, total) for v in row]
        return self.probabilities[cell]

    @cached_property
    def shares(self) -> dict[int, dict[int, Fraction]]:
        """P(x|a) of the global groups, by group and cell."""
        found: dict[int, dict[int, Fraction]] = {a: {} for a in self.law.global_groups}
        for cell, (a, mass) in enumerate(zip(self.group_of, self.law.cell_mass, strict=True)):
            if a in found and mass:
                found[a][cell] = Fraction(mass)
        for weights in found.values():
            total = sum(weights.values())
            for cell in weights:
                weights[cell] /= total
        return found

    def mean(self, member: int) -> Terms:
        """E(x,a) of a cell or Ē(a) of a group, as coefficients of g."""
        shares = {member: ONE} if self.quantity == "local" else self.shares[member]
        terms: Terms = {}
        for cell, share in shares.items():
            for u, p in enumerate(self.row(cell)):
                if p:
                    v = self.variable(cell, u)
                    terms[v] = terms.get(v, ZERO) + share * p
        return terms

    @cached_property
    def means(self) -> dict[int, Terms]:
        """Group means in the variables that were asked for, kept."""
        return {}

    def vector(self, member: int) -> Terms:
        """The mean of a member in the variables: g, or θ with a family."""
        if member not in self.means:
            self.means[member] = self.in_variables(self.mean(member))
        return self.means[member]

    def in_variables(self, terms: Terms) -> Terms:
        """Coefficients of g as coefficients of the variables."""
        if self.features is None:
            return terms
        result: Terms = {}
        for v, coefficient in terms.items():
            row, u = divmod(v, self.n)
            cell = self.cells[row][0] if self.of.blind else row
            for k, feature in enumerate(self.features[cell][u]):
                if feature:
                    result[k] = result.get(k, ZERO) + coefficient * feature
        return {k: value for k, value in result.items() if value}

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

    def box(self, variable: int) -> tuple[Fraction, Fraction]:
        """Ends between which a variable lies."""
        if self.of.family is not None:
            return self.of.family.lower[variable], self.of.family.upper[variable]
        return self.of.m, self.of.gamma

    @property
    def size(self) -> int:
        """Number of variables."""
        if self.of.family is not None:
            return len(self.of.family.names)
        return (len(self.contexts) if self.of.blind else len(self.law.weights)) * self.n

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


@dataclass(frozen=True)
class _Numbering:
    """Where constraints begin, the floors not counted: by cell, by context, and of the rows at the end."""

    orders: dict[int, int]
    distances: dict[int, int]
    rows: int
    ranges: dict[int, int]
    family: int
    end: int


def lay_out(law: Law, of: UtilityClass, quantity: Quantity) -> Setting:
    """Lay a class out over a law; refuses one that does not fit it."""
    if quantity not in ("local", "global"):
        raise InputError(f"quantity={shown(quantity)} is not accepted; use 'local' or 'global'")
    by_context: dict[int, list[int]] = {}
    for cell, x in enumerate(law.cell_context.tolist()):
        by_context.setdefault(x, []).append(cell)
    contexts, cells = list(by_context), list(by_context.values())
    places: list[int | None]
    if quantity == "local":
        places = [i for i, listed in enumerate(cells) if len(listed) > 1]
        members = [cells[i] for i in places if i is not None]
        if not members:
            raise InputError("no context has two groups, so nobody is compared within a context")
    else:
        places, members = [None], [list(law.global_groups)]
        if not law.global_groups:
            raise InputError(
                "the global ratio is undefined: fewer than two groups have a population, or one is missing in a context and no population "
                "was given"
            )
    index = {label: u for u, label in enumerate(law.decisions)}
    order = []
    for pair in of.order:
        for label in pair:
            if label not in index:
                raise InputError(f"the order names the decision {shown(label)}, which does not occur; {nearest(label, law.decisions)}")
        order.append((index[pair[0]], index[pair[1]]))
    setting = Setting(law, of, quantity, contexts, cells, members, places, order, _metric(law, of), [], _features(law, of))
    setting.rows.extend(_resolved(setting, row) for row in of.rows)
    return setting


def _metric(law: Law, of: UtilityClass) -> list[list[Fraction]] | None:
    """Distances between groups; an error unless they form a metric."""
    if of.metric is None:
        return None
    if of.lipschitz is None:
        raise InputError("a metric goes with a Lipschitz constant; give lipschitz too")
    size = len(law.groups)
    if callable(of.metric):
        raw = [[of.metric(a, b) for b in law.groups] for a in law.groups]
    else:
        raw = [list(row) for row in of.metric]
        if len(raw) != size or any(len(row) != size for row in raw):
            raise InputError(f"the metric is not a square table over the {size} groups of the law")
    read = rational if isinstance(of.metric, np.ndarray) else option_value
    d = [[read_number("the metric", value, read) for value in row] for row in raw]
    name = law.group_label
    for i in range(size):
        for j in range(size):
            if (d[i][j] <= 0) != (i == j) or d[i][j] < 0:
                raise InputError(
                    f"the metric gives the distance {d[i][j]} from {name(i)} to {name(j)}; it is zero from a group to itself, else positive"
                )
            if d[i][j] != d[j][i]:
                raise InputError(f"the metric is not symmetric: {d[i][j]} from {name(i)} to {name(j)}, but {d[j][i]} back")
    for i in range(size):
        for j in range(size):
            for k in range(size):
                if d[i][k] > d[i][j] + d[j][k]:
                    raise InputError(
                        f"the metric breaks the triangle inequality: {name(i)} to {name(k)} is {d[i][k]}, but through {name(j)} it is "
                        f"{d[i][j]} + {d[j][k]}"
                    )
    return d


def _features(law: Law, of: UtilityClass) -> list[list[list[Fraction]]] | None:
    if of.family is None:
        return None
    features = []
    first: dict[int, list[list[Fraction]]] = {}
    for named in of.family.features.values():
        if isinstance(named, Mapping):
            for label in named:
                if label_text(label) not in law.decisions:
                    raise InputError(
                        f"the family names the decision {shown(label)}, which does not occur; {nearest(str(label), law.decisions)}"
                    )
    for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
        rows = [[_feature(name, phi, u, law.contexts[x], law.groups[a]) for name, phi in of.family.features.items()] for u in law.decisions]
        if of.blind and first.setdefault(x, rows) != rows:
            raise InputError(f"the features differ between groups at {law.context_label(x)}, but the class is blind; set blind=False")
        features.append(rows)
    return features


def _feature(name: str, phi: Any, u: str, x: Label, a: Label) -> Fraction:
    value = phi.get(u, 0) if isinstance(phi, Mapping) else phi(u, x, a)
    return read_number(f"the feature {shown(name)} of decision {shown(u)}", value)


def _resolved(setting: Setting, row: LinearRow) -> tuple[Terms, Fraction]:
    """Read the labels of a row as variables."""
    law = setting.law
    terms: Terms = {}
    for context, group, decision, coefficient in row.terms:
        if decision not in law.decisions:
            raise InputError(f"a row names the decision {shown(decision)}, which does not occur; {nearest(decision, law.decisions)}")
        if context is None and len(setting.contexts) > 1:
            raise InputError(f"a row names the decision {shown(decision)} without a context, but there are {len(setting.contexts)}")
        if context is not None and context not in law.contexts:
            raise InputError(f"a row names the context {shown(context)}, which does not occur")
        x = setting.contexts[0] if context is None else law.contexts.index(context)
        if x not in setting.contexts:
            raise InputError(f"a row names the context {shown(context)}, in which no decisions are recorded")
        cells = setting.cells[setting.contexts.index(x)]
        if setting.of.blind == (group is not None):
            raise InputError(
                f"a row names the group {shown(group)}, but the class is blind"
                if setting.of.blind
                else "a row names no group, but the class is not blind to groups"
            )
        found = cells[:1] if group is None else [cell for cell in cells if law.groups[setting.group_of[cell]] == group]
        if not found:
            raise InputError(f"a row names the group {shown(group)}, which has no decisions at {law.context_label(x)}")
        v = setting.variable(found[0], law.decisions.index(decision))
        terms[v] = terms.get(v, ZERO) + coefficient
    return {v: c for v, c in terms.items() if c}, row.bound
