"""Whether the utility of the table is in the class."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import chain, combinations

from .figures import Maximum
from .header import Cell
from .program import Program
from .rationals import Rational, at_most, bits_of
from .table import Table, place_of
from .text import shown
from .utility_class import Family
from .work import spend


def fault_of_membership(program: Program, metric: Maximum | None, theta: Sequence[Rational] | None) -> str:
    """Say which constraint of the class the utility of the table violates; nothing if it is in the class."""
    utilities, table = program.utilities, program.table
    gamma, m = Fraction(*utilities.gamma), Fraction(*utilities.m)
    first: dict[int, list[Fraction]] = {}  # g by place
    gains: list[list[Fraction]] = []  # g by cell
    for cell in table.cells:
        where = place_of(table, cell)
        own = [Fraction(*entry) for entry in cell.utility if entry is not None]
        if len(own) < program.decisions:
            return f"the utility is not given everywhere {where}"
        if not all(m <= g <= gamma for g in own):
            return f"the utility leaves [m, gamma] {where}"
        if first.setdefault(program.place(cell), own) != own:
            return f"the utility depends on the group {where}, but the class is blind"
        for (lower, higher), names in zip(program.order, utilities.order, strict=True):
            if own[lower] > own[higher]:
                return f"the utility violates the order {shown(names)} {where}"
        gains.append(own)
    if utilities.lipschitz is not None:
        by_context: list[list[tuple[Cell, list[Fraction]]]] = [[] for _ in table.header.contexts]
        for cell, own in zip(table.cells, gains, strict=True):
            by_context[cell.context].append((cell, own))
        bits = 2 * max((bits_of(g) for own in gains for g in own), default=0)
        spend(sum(len(cells) ** 2 for cells in by_context) * 15 * (1 + program.decisions), bits, bits)
        for (left, one), (right, other) in chain.from_iterable(combinations(cells, 2) for cells in by_context):
            allowed = Fraction(*program.allowed(left, right))
            if one != other and any(abs(g - h) > allowed for g, h in zip(one, other, strict=True)):
                return f"the utility violates the Lipschitz constraint between group {right.group} and the cell {place_of(table, left)}"
    for i, (terms, bound) in enumerate(utilities.rows):
        bits = bits_of(bound) + sum(bits_of(c) + bits_of(first[program.places[x, a]][u]) for x, a, u, c in terms)
        spend(20 * len(terms), bits // max(1, len(terms)), bits)
        if sum(Fraction(*c) * first[program.places[x, a]][u] for x, a, u, c in terms) > Fraction(*bound):
            return f"the utility violates subject.class.rows[{i}]"
    if utilities.family is not None and (fault := _outside_family(utilities.family, table, gains, theta)):
        return fault
    return _below_floor(program, metric)


def _outside_family(family: Family, table: Table, gains: Sequence[Sequence[Fraction]], theta: Sequence[Rational] | None) -> str:
    """Say why theta does not show that the utility belongs to the family."""
    if theta is None:
        return "no claim by lp-dual about this quantity gives the theta of the utility"
    own = [Fraction(*parameter) for parameter in theta]
    for k, (low, high) in enumerate(zip(family.lower, family.upper, strict=True)):
        if not Fraction(*low) <= own[k] <= Fraction(*high):
            return f"theta[{k}] is not within its ends"
    widest = bits_of(*own)
    for i, (coefficients, bound) in enumerate(family.rows):
        bits = widest + bits_of(*coefficients)
        spend(20 * len(own), bits // len(own), bits)
        if sum(Fraction(*c) * parameter for c, parameter in zip(coefficients, own, strict=True)) > Fraction(*bound):
            return f"theta violates subject.class.family.rows[{i}]"
    for cell, features, values in zip(table.cells, family.features, gains, strict=True):
        for phi, g in zip(features, values, strict=True):
            bits = widest + bits_of(*phi)
            spend(20 * len(own), bits // len(own), bits)
            if sum(Fraction(*f) * parameter for f, parameter in zip(phi, own, strict=True)) != g:
                return f"theta does not give the utility {place_of(table, cell)}"
    return ""


def _below_floor(program: Program, metric: Maximum | None) -> str:
    tau, table = program.utilities.tau, program.table
    if tau is None or metric is None:
        return ""
    context, higher, lower = metric.place
    for group in program.groups_with_floor(-1 if context is None else context, higher, lower):
        if context is None:
            _, mean = table.figures.of_group(group)
        else:
            mean = next(cell.expectation for cell in program.by_context[context] if cell.group == group)
        if not at_most(tau, mean):
            return f"the floor is violated by group {shown(list(table.header.groups[group]))}, whose expectation is {shown(mean)}"
    return ""
