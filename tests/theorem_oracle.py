"""Finite deployments, the laws that they induce, and exact linear programs: plain loops over fractions, nothing from the package
but the filter object that the bounds take."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, permutations
from math import inf, lcm
from random import Random
from typing import Any

import pytest

from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism, Product, RandomizedResponse
from fairaudit.model.utility import Utility

F = Fraction
ZERO = F(0)
Row = list[Fraction]
Table = list[Row]


@dataclass
class Deployment:
    """Policy[x̃][ã][u], filters rows_x[x][x̃] and rows_a[a][ã], utility[x][a][u], population[x][a]."""

    policy: list[list[Row]]
    rows_x: Table
    rows_a: Table
    utility: list[list[Row]]
    population: Table
    mechanism: Mechanism

    @property
    def contexts(self) -> range:
        return range(len(self.rows_x))

    @property
    def groups(self) -> range:
        return range(len(self.rows_a))

    @property
    def decisions(self) -> range:
        return range(len(self.utility[0][0]))

    def law(self, x: int, a: int) -> Row:
        """P(u|x,a)."""
        result = [F(0)] * len(self.decisions)
        for xt, wx in enumerate(self.rows_x[x]):
            for at, wa in enumerate(self.rows_a[a]):
                for u in self.decisions:
                    result[u] += wx * wa * self.policy[xt][at][u]
        return result

    def expectation(self, x: int, a: int) -> Fraction:
        return sum((p * g for p, g in zip(self.law(x, a), self.utility[x][a], strict=True)), F(0))

    def share(self, x: int, a: int) -> Fraction:
        """P(x|a)."""
        return self.population[x][a] / sum(self.population[y][a] for y in self.contexts)

    def mean(self, a: int) -> Fraction:
        return sum((self.share(x, a) * self.expectation(x, a) for x in self.contexts), F(0))

    def mixture(self, a: int) -> Row:
        """P(u|a)."""
        laws = [(self.share(x, a), self.law(x, a)) for x in self.contexts]
        return [sum((w * row[u] for w, row in laws), F(0)) for u in self.decisions]

    def response(self, x: int, at: int, a: int) -> Fraction:
        """h(x,ã): the expected utility given the released group value."""
        return sum(
            (wx * self.policy[xt][at][u] * self.utility[x][a][u] for xt, wx in enumerate(self.rows_x[x]) for u in self.decisions),
            F(0),
        )

    @property
    def local(self) -> Any:
        table = [[self.expectation(x, a) for a in self.groups] for x in self.contexts]
        return max(ratio(row[a], row[b]) for row in table for a, b in permutations(self.groups, 2))

    @property
    def overall(self) -> Any:
        means = [self.mean(a) for a in self.groups]
        return max(ratio(means[a], means[b]) for a, b in permutations(self.groups, 2))

    @property
    def gamma(self) -> Fraction:
        return max(v for block in self.utility for row in block for v in row)

    @property
    def least(self) -> Fraction:
        return min(v for block in self.utility for row in block for v in row)

    @property
    def floor(self) -> Fraction:
        return min(self.expectation(x, a) for x in self.contexts for a in self.groups)

    @property
    def gap(self) -> Fraction:
        return max(
            abs(block[a][u] - block[b][u]) for block in self.utility for a, b in permutations(self.groups, 2) for u in self.decisions
        )

    @property
    def policy_floor(self) -> Fraction:
        """The least expected utility over everything that the filters can release."""
        return min(
            sum((self.policy[xt][at][u] * self.utility[x][a][u] for u in self.decisions), F(0))
            for x in self.contexts
            for xt, wx in enumerate(self.rows_x[x])
            if wx
            for at in range(len(self.rows_a[0]))
            for a in self.groups
        )

    def audited(self) -> tuple[Law, Utility]:
        """The induced law and the utility as the package reads them."""
        array = [[self.law(x, a) for a in self.groups] for x in self.contexts]
        law = Law.from_array(array, population=self.population, decisions=[str(u) for u in self.decisions])
        values = {(str(u), (str(x),), (str(a),)): self.utility[x][a][u] for x in self.contexts for a in self.groups for u in self.decisions}
        if all(len({self.utility[x][a][u] for x in self.contexts for a in self.groups}) == 1 for u in self.decisions):
            return law, Utility({str(u): self.utility[0][0][u] for u in self.decisions})
        return law, Utility.from_function(lambda u, x, a: values[u, x, a], law)


def ratio(top: Fraction, bottom: Fraction) -> Any:
    if bottom == 0:
        return F(1) if top == 0 else inf
    return top / bottom


def stick(p: Row, q: Row, k: Fraction) -> Fraction:
    """H_k(P,Q)."""
    return sum((max(F(0), v - k * w) for v, w in zip(p, q, strict=True)), F(0))


def pure(rows: Table) -> Any:
    """e^ε of a table."""
    return max((ratio(v, w) for p, q in permutations(rows, 2) for v, w in zip(p, q, strict=True)), default=F(1))


def worst_stick(rows: Table, k: Fraction) -> Fraction:
    """δ at e^ε = k."""
    return max((stick(p, q, k) for p, q in permutations(rows, 2)), default=F(0))


def distance(p: Row, q: Row) -> Fraction:
    return sum((abs(v - w) for v, w in zip(p, q, strict=True)), F(0)) / 2


def falling(p: Row, q: Row) -> list[tuple[Fraction, Fraction]]:
    """Outputs in falling order of p/q, those with q = 0 first."""
    return sorted(zip(p, q, strict=True), key=lambda e: (e[1] > 0, -e[0] / e[1] if e[1] else 0))


def most_power(p: Row, q: Row, level: Fraction) -> Fraction:
    """The greatest E_P φ with E_Q φ ≤ level, filling outputs in falling order of p/q."""
    left, gained = level, F(0)
    for v, w in falling(p, q):
        part = F(1) if w <= left else left / w
        left -= part * w
        gained += part * v
    return gained


def curve(p: Row, q: Row) -> list[tuple[Fraction, Fraction]]:
    """Vertices of the trade-off function of one ordered pair."""
    ordered = falling(p, q)
    x, y = F(0), F(1) - sum((v for v, w in ordered if not w), F(0))
    vertices = [(x, y)]
    for v, w in ordered:
        if w:
            x, y = x + w, y - v
            vertices.append((x, y))
    return vertices


def at(vertices: Sequence[tuple[Fraction, Fraction]], level: Fraction) -> Fraction:
    """Value of a piecewise linear function."""
    for (x, y), (x2, y2) in pairwise(vertices):
        if x <= level <= x2:
            return y + (y2 - y) * (level - x) / (x2 - x)
    raise AssertionError


def proved(bound: Any, rows: Table, inequality: Callable[[Row, Row, Fraction], Any]) -> bool:
    """Whether for every ordered pair of rows some multiplier proves the value."""
    return all(p == q or any(inequality(p, q, k) <= bound.value for k in bound.multipliers) for p, q in permutations(rows, 2))


# Random parts


def random_row(rng: Random, size: int, zeros: bool = True) -> Row:
    while True:
        weights = [rng.choice([0, 0, 1, 1, 2, 3, 7] if zeros else [1, 1, 2, 3, 7]) for _ in range(size)]
        if any(weights):
            return [F(w, sum(weights)) for w in weights]


def response_rows(k: int, keep: Fraction) -> Table:
    """Rows of randomized response."""
    lie = (1 - keep) / (k - 1)
    return [[keep if i == j else lie for j in range(k)] for i in range(k)]


def kron(one: Table, two: Table) -> Table:
    return [[v * w for v in p for w in q] for p in one for q in two]


def random_filter(rng: Random, groups: int | None = None) -> tuple[Table, Mechanism]:
    """Rows and the filter object: a table with zeros, a full table, randomized response, or a product of two of them."""
    kind = rng.choice(["zeros", "full", "response", "product"])
    if kind == "product" and groups in (None, 4):
        one, two = (response_rows(2, F(rng.randint(0, 8), 8)) for _ in range(2))
        parts = {name: RandomizedResponse(["0", "1"], keep_probability=rows[0][0]) for name, rows in (("s", one), ("t", two))}
        return kron(one, two), Product(parts)
    size = groups or rng.randint(2, 4)
    if kind == "response":
        keep = F(rng.randint(0, 9), 9)
        return response_rows(size, keep), RandomizedResponse(list(range(size)), keep_probability=keep)
    outputs = rng.randint(1, 4)
    rows = [random_row(rng, outputs, zeros=kind == "zeros") for _ in range(size)]
    return rows, table_filter(rows)


def table_filter(rows: Table) -> Mechanism:
    return Mechanism.from_array(rows, list(range(len(rows))), [f"o{j}" for j in range(len(rows[0]))])


def random_deployment(
    rng: Random, *, uses: str = "group", least: Fraction = ZERO, independent: bool = False, masses: bool = True
) -> Deployment:
    """A deployment whose utility may depend on the decision ("decision"), the context too ("context"), or the group too ("group")."""
    rows_a, mechanism = random_filter(rng)
    x_size, u_size, released = rng.randint(1, 3), rng.randint(1, 3), rng.randint(1, 3)
    rows_x = [random_row(rng, released) for _ in range(x_size)]
    policy = [[random_row(rng, u_size) for _ in rows_a[0]] for _ in range(released)]
    values = [least, least, least + 1, least + 2, least + F(1, 3), least + 5]
    base = [rng.choice(values) for _ in range(u_size)]
    base[rng.randrange(u_size)] = least + rng.choice([1, 2, 5])
    by_context = [base if uses == "decision" else [rng.choice(values) for _ in base] for _ in range(x_size)]
    by_context[0] = base
    utility = [[list(row) for _ in rows_a] for row in by_context]
    if uses == "group":
        for block in utility:
            for row in block:
                if rng.random() < 0.5:
                    place = rng.randrange(u_size)
                    row[place] = max(least, row[place] + rng.choice([F(1, 4), F(-1, 4), F(1)]))
    if independent:
        by_x, by_a = ([rng.randint(1, 5) for _ in range(n)] for n in (x_size, len(rows_a)))
        population = [[F(v * w) for w in by_a] for v in by_x]
    else:
        low = 0 if masses else 1
        population = [[F(rng.randint(low, 4)) for _ in rows_a] for _ in range(x_size)]
        for a in range(len(rows_a)):
            if not any(row[a] for row in population):
                population[0][a] = F(1)
    return Deployment(policy, rows_x, rows_a, utility, population, mechanism)


def deployments(count: int, **options: Any) -> Iterator[tuple[Random, Deployment]]:
    for seed in range(count):
        rng = Random(f"{seed} {sorted(options)}")
        yield rng, random_deployment(rng, **options)


# Exact linear programs


def maximize(size: int, target: Sequence[Any], zero: Sequence[Sequence[Any]], nonnegative: Sequence[Sequence[Any]]) -> Fraction:
    """Maximize target·v over v ≥ 0; a constraint is a row with a constant at its end: row·v + constant = 0, or ≥ 0."""
    ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")
    program = ppl.MIP_Problem(size)

    def expression(row: Sequence[Any]) -> Any:
        values = [F(v) for v in row]
        bottom = lcm(*(v.denominator for v in values))
        total = ppl.Linear_Expression(int(values[-1] * bottom))
        for i, v in enumerate(values[:-1]):
            if v:
                total = total + int(v * bottom) * ppl.Variable(i)
        return total

    for i in range(size):
        program.add_constraint(ppl.Variable(i) >= 0)
    for row in zero:
        program.add_constraint(expression(row) == 0)
    for row in nonnegative:
        program.add_constraint(expression(row) >= 0)
    values = [F(v) for v in target]
    bottom = lcm(*(v.denominator for v in values))
    program.set_objective_function(sum((int(v * bottom) * ppl.Variable(i) for i, v in enumerate(values) if v), ppl.Linear_Expression(0)))
    program.set_optimization_mode("maximization")
    value = program.optimal_value()
    return F(int(value.numerator), int(value.denominator)) / bottom


def best_ratio(rows: Table, low: Fraction, high: Fraction, floor: Fraction, pair: tuple[int, int], everyone: bool = True) -> Fraction:
    """The greatest E(a)/E(a') over responses h: outputs → [low, high] that keep every group's (or only the second's) mean at the floor.

    With z = 1/E(a') and y = h·z that is linear.
    """
    n = len(rows[0])
    a, b = pair
    bounds = []
    for j in range(n):
        unit = [F(int(i == j)) for i in range(n)]
        bounds += [[*unit, -low, 0], [*(-v for v in unit), high, 0]]
    keeping = rows if everyone else [rows[b]]
    floors = [[*row, -floor, 0] for row in keeping]
    return maximize(n + 1, [*rows[a], 0], [[*rows[b], 0, -1]], bounds + floors)


def best_over_pairs(rows: Table, low: Fraction, high: Fraction, floor: Fraction, everyone: bool = True) -> Fraction:
    return max((best_ratio(rows, low, high, floor, pair, everyone) for pair in permutations(range(len(rows)), 2)), default=F(1))


def best_in_range(p: Row, q: Row, high: Fraction, low: Fraction, gap: Fraction, floor: Fraction) -> Any:
    """The greatest E(a)/E(a') over utilities in [low, high] that the decision may tell apart, where E(a') is at least the floor.

    Responses h and h' of the two groups to each output lie in the range and differ by at most the gap; z = 1/E(a') makes it linear.
    """
    n = len(p)
    if floor == 0 and low == 0 and (gap > 0 or any(v and not w for v, w in zip(p, q, strict=True))):
        return inf  # what the second group gets can be 0 while the first gets something
    bounds = []
    for j in range(n):
        ends = []
        for place in (j, n + j):
            unit = [F(int(i == place)) for i in range(2 * n)]
            ends.append(unit)
            bounds += [[*unit, -low, 0], [*(-v for v in unit), high, 0]]
        apart = [v - w for v, w in zip(*ends, strict=True)]
        bounds += [[*apart, gap, 0], [*(-v for v in apart), gap, 0]]
    second = [*([ZERO] * n), *q]
    return maximize(2 * n + 1, [*p, *([ZERO] * (n + 1))], [[*second, 0, -1]], [*bounds, [*second, -floor, 0]])
