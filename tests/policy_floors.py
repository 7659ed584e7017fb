"""Policies behind filters that keep floors: exact linear programs over dense tables of plain fractions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any

import pytest
from plain_certificates import INF, text
from policy_certificates import Policy
from policy_suprema import ZERO, Compared, Worth, floor_in, shares, sums, worth

ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")


@dataclass(frozen=True, eq=False)
class Floor:
    """A floor above 0 of an expectation, and what each decision under each output adds to that."""

    context: int | None
    group: int
    value: Fraction
    e: Worth


def floors(p: Policy) -> list[Floor]:
    """All declared floors above 0: of cells, and of the means of groups of positive mass."""
    groups = range(len(p.true_a))
    found = [Floor(x, a, floor_in(p, x), worth(p, {x: Fraction(1)}, a)) for x in range(len(p.true_x)) if floor_in(p, x) for a in groups]
    of_all = p.declared.get("global_tau", ZERO)
    return found + [Floor(None, a, of_all, worth(p, shares(p, a), a)) for a in groups if of_all and p.of_group(a)]


def _scaled(terms: Sequence[tuple[Fraction, int]], bound: Fraction) -> Any:
    """The linear expression of some coefficients of variables less a bound, multiplied until it is whole."""
    unit = lcm(bound.denominator, *(c.denominator for c, _ in terms))
    expression = ppl.Linear_Expression(-int(bound * unit))
    for c, i in terms:
        expression = expression + int(c * unit) * ppl.Variable(i)
    return expression, unit


def _number(value: Any) -> Fraction:
    return Fraction(int(value.numerator), int(value.denominator))


def best(case: Compared, kept: Sequence[Floor], value: Fraction) -> list[list[Fraction]]:
    """A policy that keeps the floors and makes p - V q greatest, and of those q."""
    decisions = len(case.p[0])
    tops = [[x - value * y for x, y in zip(p, q, strict=True)] for p, q in zip(case.p, case.q, strict=True)]
    first = _maximize(tops, kept, decisions, [])
    return _maximize(case.q, kept, decisions, [(tops, _total(tops, first))])


def _total(rows: Worth, policy: list[list[Fraction]]) -> Fraction:
    return sum((t * v for law, row in zip(policy, rows, strict=True) for t, v in zip(law, row, strict=True)), ZERO)


def _maximize(rows: Worth, kept: Sequence[Floor], decisions: int, fixed: Sequence[tuple[Worth, Fraction]]) -> list[list[Fraction]]:
    program = ppl.MIP_Problem(len(rows) * decisions)
    for o in range(len(rows)):
        law = ppl.Linear_Expression(-1)
        for u in range(decisions):
            program.add_constraint(ppl.Variable(o * decisions + u) >= 0)
            law = law + ppl.Variable(o * decisions + u)
        program.add_constraint(law == 0)

    def expression(table: Worth, bound: Fraction) -> Any:
        return _scaled([(v, o * decisions + u) for o, row in enumerate(table) for u, v in enumerate(row)], bound)[0]

    for floor in kept:
        program.add_constraint(expression(floor.e, floor.value) >= 0)
    for table, exactly in fixed:
        program.add_constraint(expression(table, exactly) == 0)
    program.set_objective_function(expression(rows, ZERO))
    program.set_optimization_mode("maximization")
    point = program.optimizing_point()
    unit = int(point.divisor())
    found = [Fraction(int(point.coefficient(ppl.Variable(i))), unit) for i in range(len(rows) * decisions)]
    return [found[i : i + decisions] for i in range(0, len(found), decisions)]


def greatest(case: Compared, kept: Sequence[Floor]) -> tuple[Any, list[list[Fraction]]]:
    """The greatest ratio over the policies that keep the floors, at least 1, and a policy that attains it."""
    value = Fraction(1)
    while True:
        policy = best(case, kept, value)
        above, below = sums(case, policy)
        if above <= value * below:
            return value, policy
        if not below:
            return INF, policy
        value = above / below


def prices(case: Compared, kept: Sequence[Floor], value: Fraction) -> list[Fraction]:
    """The y >= 0 with the least sum over o of the greatest p - V q + sum of y e, less the sum of y f; that is at most 0 if V holds."""
    count = len(kept)
    program = ppl.MIP_Problem(count + 2 * len(case.p))  # y, and the greatest numbers as differences of two
    for i in range(count + 2 * len(case.p)):
        program.add_constraint(ppl.Variable(i) >= 0)
    for o, (p, q) in enumerate(zip(case.p, case.q, strict=True)):
        for u in range(len(p)):
            terms = [(Fraction(1), count + 2 * o), (Fraction(-1), count + 2 * o + 1)]
            terms += [(-floor.e[o][u], i) for i, floor in enumerate(kept)]
            program.add_constraint(_scaled(terms, p[u] - value * q[u])[0] >= 0)
    cost = [(-floor.value, i) for i, floor in enumerate(kept)]
    cost += [(Fraction(sign), count + 2 * o + i) for o in range(len(case.p)) for i, sign in enumerate((1, -1))]
    program.set_objective_function(_scaled(cost, ZERO)[0])
    program.set_optimization_mode("minimization")
    point = program.optimizing_point()
    return [Fraction(int(point.coefficient(ppl.Variable(i))), int(point.divisor())) for i in range(count)]


def place(p: Policy, case: Compared) -> dict[str, Any]:
    """An ordered pair of groups as certificates name it."""
    context = None if case.context is None else p.true_x[case.context]
    return {"context": context, "higher": p.true_a[case.higher], "lower": p.true_a[case.lower]}


def priced(p: Policy, case: Compared, kept: Sequence[Floor], y: Sequence[Fraction]) -> dict[str, Any]:
    """An entry of the evidence."""
    return place(p, case) | {"floors": [[f.context, f.group, str(v)] for f, v in zip(kept, y, strict=True) if v]}


def witness(p: Policy, case: Compared, policy: list[list[Fraction]]) -> dict[str, Any]:
    """A policy that attains a value, as certificates write it."""
    width = len(p.reach_a)
    rows = [[[text(v) for v in law] for law in policy[i : i + width]] for i in range(0, len(policy), width)]
    return {"attained": place(p, case), "rows": rows}
