"""The linear program of a class of utilities on a table: its variables, compared pairs and constraints."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, permutations

from .header import Cell
from .json_values import read_list
from .rationals import (
    CONSTANT,
    ONE,
    ZERO,
    Affine,
    Rational,
    affine_sum,
    constant_form,
    negated,
    over_common_denominator,
    product_of,
    sum_of,
)
from .table import Table, globally_compared
from .text import malformed, shown
from .utility_class import Family, UtilityClass
from .work import keep, spend


class Program:
    """The variables, boxes and constraints of a class of utilities on a table.

    A place is a cell, or when the class is blind a context that has cells: where g(u) can be chosen anew.  The
    variables are numbered by place and decision; those of a family are its parameters.
    """

    def __init__(self, utilities: UtilityClass, table: Table) -> None:
        header = table.header
        self.utilities, self.table = utilities, table
        self.decisions = len(header.decisions)
        self.by_context, self.by_group = table.by_context(), table.by_group()
        if utilities.metric is not None and len(utilities.metric) != len(header.groups):
            raise malformed("subject.class.metric", f"must have {len(header.groups)} rows, one for each group")
        numbers = {label: u for u, label in enumerate(header.decisions)}
        for i, label in ((i, label) for i, pair in enumerate(utilities.order) for label in pair):
            if label not in numbers:
                raise malformed(f"subject.class.order[{i}]", f"names a decision that the table does not have: {shown(label)}")
        self.order = [(numbers[lower], numbers[higher]) for lower, higher in utilities.order]
        self.places: dict[tuple[int, int | None], int] = {}  # by context and group
        for cell in table.cells:
            self.places.setdefault((cell.context, None if utilities.blind else cell.group), len(self.places))
        self.places_of: dict[int, list[int]] = {-1: [*self.places.values()]}  # by context; -1 stands for all of them
        for (context, _), place in self.places.items():
            self.places_of.setdefault(context, []).append(place)
        self.everywhere = globally_compared(table)
        box = [utilities.m, utilities.gamma] * (len(self.places) * self.decisions)
        self.values: list[Affine] = [({j: 1}, 1) for j in range(len(self.places) * self.decisions)]  # g by place and decision
        if utilities.family is not None:
            self.values = self._features(utilities.family)
            box = [end for ends in zip(utilities.family.lower, utilities.family.upper, strict=True) for end in ends]
        ends, self.unit_of_box = over_common_denominator(box)
        self.box = [*zip(ends[::2], ends[1::2], strict=True)]
        self.rows = [self._row(terms, bound, f"subject.class.rows[{i}]") for i, (terms, bound) in enumerate(utilities.rows)]
        self._means: dict[tuple[int, int], Affine] = {}
        self._differing: dict[int, list[tuple[Cell, Cell]]] = {}

    def place(self, cell: Cell) -> int:
        """Number the place of a cell."""
        return self.places[cell.context, None if self.utilities.blind else cell.group]

    def _features(self, family: Family) -> list[Affine]:
        """Write g by place and decision as forms in the parameters."""
        where = "subject.class.family.features"
        read_list(family.features, where, len(self.table.cells))
        chosen: dict[int, list[list[Rational]]] = {}
        for i, (cell, features) in enumerate(zip(self.table.cells, family.features, strict=True)):
            read_list(features, f"{where}[{i}]", self.decisions)
            if chosen.setdefault(self.place(cell), features) != features:
                raise malformed(f"{where}[{i}]", "differ from those of another group, but the class is blind")
        forms: list[Affine] = []
        for phi in chain.from_iterable(chosen.values()):
            coefficients, denominator = over_common_denominator(phi)
            forms.append((dict(enumerate(coefficients)), denominator))
        return forms

    def _row(self, terms: Sequence[tuple[int, int | None, int, Rational]], bound: Rational, where: str) -> Affine:
        """Write a further constraint as its slack."""
        parts = [(ONE, constant_form(bound))]
        for i, (context, group, decision, coefficient) in enumerate(terms):
            if (context, group) not in self.places or decision >= self.decisions:
                raise malformed(f"{where}.terms[{i}]", "names what the table does not have")
            parts.append((negated(coefficient), self.value(self.places[context, group], decision)))
        return affine_sum(parts)

    def value(self, place: int, decision: int) -> Affine:
        """Write g(u) at a place."""
        return self.values[place * self.decisions + decision]

    def _expectation(self, cell: Cell) -> Affine:
        weights, total = cell.law
        place = self.place(cell)
        return affine_sum(((w, total), self.value(place, u)) for u, w in enumerate(weights))

    def mean(self, context: int, group: int) -> Affine:
        """Write E(x,a), or the mean of E(.,a) when the context is -1."""
        if (context, group) not in self._means:
            if context >= 0:
                spend(len(self.by_context[context]))
                form = self._expectation(next(cell for cell in self.by_context[context] if cell.group == group))
            else:
                n, d = sum_of(cell.mass for cell in self.by_group[group])
                form = affine_sum(((c.mass[0] * d, c.mass[1] * n), self._expectation(c)) for c in self.by_group[group] if c.mass[0])
            self._means[context, group] = form
        return self._means[context, group]

    def compared(self) -> list[tuple[int, list[int]]]:
        """List the groups that are compared, by context; the context is -1 where the means of groups are compared."""
        if self.utilities.quantity == "global":
            return [(-1, self.everywhere)]
        return [(x, [cell.group for cell in cells]) for x, cells in enumerate(self.by_context) if len(cells) > 1]

    def groups_with_floor(self, context: int, higher: int, lower: int) -> list[int]:
        """List the groups that keep the floor where these two are compared."""
        if self.utilities.tau is None:
            return []
        if self.utilities.tau_on == "pair":
            return [higher, lower]
        spend(len(self.everywhere if context < 0 else self.by_context[context]))
        return self.everywhere if context < 0 else [cell.group for cell in self.by_context[context]]

    def _differing_cells(self, context: int) -> list[tuple[Cell, Cell]]:
        """List the ordered pairs of different cells of a context, or of every context when it is -1."""
        if context not in self._differing:
            lists = self.by_context if context < 0 else [self.by_context[context]]
            count = sum(len(cells) ** 2 for cells in lists)
            spend(3 * count)
            keep(3 * count)
            self._differing[context] = [pair for cells in lists for pair in permutations(cells, 2)]
        return self._differing[context]

    def slack(self, pair: tuple[int, int, int], number: int) -> Affine | None:
        """Write the slack of a constraint by its number; the floors, and what of the table matters, depend on the pair."""
        utilities, family = self.utilities, self.utilities.family
        concerned = -1 if utilities.rows or family is not None else pair[0]
        floors = self.groups_with_floor(*pair)
        if number < len(floors):
            return affine_sum([(ONE, self.mean(pair[0], floors[number])), (negated(utilities.tau or ZERO), constant_form(ONE))])
        number -= len(floors)

        places = self.places_of[concerned]
        if number < len(places) * len(self.order):
            lower, higher = self.order[number % len(self.order)]
            place = places[number // len(self.order)]
            return affine_sum([(ONE, self.value(place, higher)), ((-1, 1), self.value(place, lower))])
        number -= len(places) * len(self.order)

        if utilities.lipschitz is not None:
            pairs = self._differing_cells(concerned)
            if number < len(pairs) * self.decisions:
                left, right = pairs[number // self.decisions]
                one, other = (self.value(self.place(cell), number % self.decisions) for cell in (left, right))
                return affine_sum([(ONE, constant_form(self.allowed(left, right))), ((-1, 1), one), (ONE, other)])
            number -= len(pairs) * self.decisions

        if number < len(self.rows):
            return self.rows[number]
        number -= len(self.rows)

        if family is None:
            return None
        if number < 2 * len(self.values):
            g = self.values[number // 2]
            if number % 2 == 0:
                return affine_sum([(ONE, g), (negated(utilities.m), constant_form(ONE))])
            return affine_sum([(utilities.gamma, constant_form(ONE)), ((-1, 1), g)])
        number -= 2 * len(self.values)
        if number < len(family.rows):
            coefficients, bound = family.rows[number]
            return affine_sum([(ONE, constant_form(bound)), *((negated(c), ({k: 1}, 1)) for k, c in enumerate(coefficients))])
        return None

    def allowed(self, left: Cell, right: Cell) -> Rational:
        """How much g may differ between two groups: L d(a,a')."""
        metric = self.utilities.metric
        distance = ONE if metric is None else metric[left.group][right.group]
        return product_of([self.utilities.lipschitz or ZERO, distance])

    def greatest(self, form: Affine) -> Rational:
        """Find the greatest value of an affine form when every variable is in its box, whatever the constraints say."""
        coefficients, denominator = form
        spend(3 * len(coefficients), max(map(int.bit_length, coefficients.values()), default=0), self.unit_of_box.bit_length())
        total = coefficients.get(CONSTANT, 0) * self.unit_of_box
        for j, coefficient in coefficients.items():
            if j != CONSTANT:
                low, high = self.box[j]
                total += coefficient * (high if coefficient > 0 else low)
        return total, denominator * self.unit_of_box
