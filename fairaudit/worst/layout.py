"""A class of utilities laid out over a law: its variables, and means of groups as their coefficients."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from fairaudit.exact.extended import ONE, ZERO
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.model.utility_class import UtilityClass

Terms = dict[int, Fraction]
"""Variables and their coefficients."""


@dataclass(frozen=True, eq=False)
class Layout:
    """The variables of a class over a law: g(u,x,a), g(u,x) where the class is blind, or the parameters of a family."""

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
    features: list[list[list[Fraction]]] | None
    """Of a family, by cell, decision and parameter."""

    @property
    def n(self) -> int:
        """Number of decisions."""
        return len(self.law.decisions)

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

    def cells_of(self, member: int) -> list[int]:
        """The cells of what is compared: a cell itself, or those of a global group."""
        return [member] if self.quantity == "local" else [i for i, a in enumerate(self.group_of) if a == member]

    @property
    def size(self) -> int:
        """Number of variables."""
        if self.of.family is not None:
            return len(self.of.family.names)
        return (len(self.contexts) if self.of.blind else len(self.law.weights)) * self.n

    def box(self, variable: int) -> tuple[Fraction, Fraction]:
        """Ends between which a variable lies."""
        if self.of.family is not None:
            return self.of.family.lower[variable], self.of.family.upper[variable]
        return self.of.m, self.of.gamma

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
