"""The greatest ratio over all policies behind filters, by plain loops: of every deterministic policy, or as an exact linear program."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations, product
from math import inf, lcm, prod
from random import Random
from typing import Any

import pytest
from theorem_oracle import F, Row, Table, kron, random_row, response_rows

from fairaudit.model.mechanism import Mechanism, RandomizedResponse
from fairaudit.model.policy import Deployment, Policy
from fairaudit.model.utility import Utility, UtilityTable

ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")

Sums = tuple[list[Row], list[Row]]
"""p[o][u] and q[o][u] of an ordered pair of groups."""


@dataclass
class Setting:
    """Filters rows_x[x][x̃] and factors[i][a_i][ã_i], utility[x][a][u], population[x][a]; None is the identity, and equal contexts."""

    factors: list[Table]
    utility: list[list[Row]]
    rows_x: Table | None = None
    population: Table | None = None
    releases: int = 1
    responses: tuple[bool, ...] = ()

    @property
    def rows_a(self) -> Table:
        """All releases of all factors together, multiplied out."""
        one: Table = [[F(1)]]
        for factor in self.factors:
            one = kron(one, factor)
        rows = one
        for _ in range(self.releases - 1):
            rows = [[v * w for v in row for w in more] for row, more in zip(rows, one, strict=True)]
        return rows

    @property
    def released(self) -> Table:
        """M_X."""
        size = len(self.utility)
        return self.rows_x or [[F(int(x == y)) for y in range(size)] for x in range(size)]

    def share(self, x: int, a: int) -> Fraction:
        """P(x|a)."""
        if self.population is None:
            return F(1, len(self.utility))
        return self.population[x][a] / sum(row[a] for row in self.population)

    def sums(self, quantity: str) -> Iterator[tuple[int | None, int, int, Sums]]:
        """p and q of every ordered pair that is compared, in input order."""
        contexts, groups, rows = range(len(self.utility)), range(len(self.rows_a)), self.rows_a
        has_mass = [self.population is None or any(row[a] for row in self.population) for a in groups]

        def cell(shares: dict[int, Fraction], a: int) -> list[Row]:
            return [
                [sum((s * self.released[x][xt] * rows[a][at] * self.utility[x][a][u] for x, s in shares.items()), F(0)) for u in decisions]
                for xt in range(len(self.released[0]))
                for at in range(len(rows[0]))
            ]

        decisions = range(len(self.utility[0][0]))
        if quantity == "local":
            for x in contexts:
                cells = [cell({x: F(1)}, a) for a in groups]
                for a, b in permutations(groups, 2):
                    yield x, a, b, (cells[a], cells[b])
            return
        means = {a: cell({x: self.share(x, a) for x in contexts}, a) for a in groups if has_mass[a]}
        for a, b in permutations(means, 2):
            yield None, a, b, (means[a], means[b])

    def subject(self) -> tuple[Deployment, UtilityTable]:
        """The filters and the utility as the package reads them, with a policy that decides at random."""
        flags = self.responses or (False,) * len(self.factors)
        group = Mechanism(tuple(f for i, rows in enumerate(self.factors) for f in self._filter(rows, f"g{i}", flags[i]).factors))
        context = None if self.rows_x is None else self._filter(self.rows_x, "c", False)
        released_x = context.outputs if context else [(f"c.{x}",) for x in range(len(self.utility))]
        size = len(self.utility[0][0])
        array = [[[F(1, size)] * size for _ in group.outputs] for _ in released_x]
        names = [f"u{u}" for u in range(size)]
        spare = [("never",) * len(group.outputs[0])]
        policy = Policy.from_array(
            [[*rows, rows[0]] for rows in array], decisions=names, groups=[*group.outputs, *spare], contexts=released_x
        )
        more = {"releases": self.releases} if self.releases > 1 else {}
        deployment = policy.behind(group=group, context=context, population=self.population, **more)
        places = {label: i for i, label in enumerate(deployment.contexts)}, {label: i for i, label in enumerate(deployment.groups)}
        if all(row == self.utility[0][0] for block in self.utility for row in block):
            utility = Utility(dict(zip(names, self.utility[0][0], strict=True)))
        else:
            utility = Utility.from_function(lambda u, x, a: self.utility[places[0][x]][places[1][a]][names.index(u)], deployment.law)
        return deployment, utility.on(deployment.law)

    @staticmethod
    def _filter(rows: Table, name: str, response: bool) -> Mechanism:
        inputs = [f"{name}.{i}" for i in range(len(rows))]
        if response:
            return RandomizedResponse(inputs, keep_probability=rows[0][0])
        return Mechanism.from_array(rows, inputs, [f"{name}.{j}" for j in range(len(rows[0]))])


def ratio(top: Fraction, low: Fraction) -> Any:
    """A ratio by the conventions 0/0 = 1 and c/0 = inf."""
    if low == 0:
        return F(1) if top == 0 else inf
    return top / low


def by_enumeration(sums: Sums) -> Any:
    """The greatest ratio of all deterministic policies; there is one that attains it, and 1 is never beaten by less."""
    tops, lows = sums
    best: Any = F(1)
    for choice in product(range(len(tops[0])), repeat=len(tops)):
        top, low = (sum((row[u] for row, u in zip(rows, choice, strict=True)), F(0)) for rows in (tops, lows))
        best = max(best, ratio(top, low))
    return best


def by_linear_program(sums: Sums) -> Any:
    """The greatest ratio of all policies: with y = T·s and Σ q·y = 1 it is linear (Charnes and Cooper)."""
    tops, _ = sums
    outputs, decisions = len(tops), len(tops[0])
    bottom = lcm(*(v.denominator for rows in sums for row in rows for v in row))
    scale = ppl.Variable(outputs * decisions)
    program = ppl.MIP_Problem(outputs * decisions + 1)
    program.add_constraint(scale >= 0)
    means = [ppl.Linear_Expression(0), ppl.Linear_Expression(0)]
    for o in range(outputs):
        row = ppl.Linear_Expression(0)
        for u in range(decisions):
            share = ppl.Variable(o * decisions + u)
            program.add_constraint(share >= 0)
            row = row + share
            means = [mean + int(rows[o][u] * bottom) * share for mean, rows in zip(means, sums, strict=True)]
        program.add_constraint(row == scale)
    program.add_constraint(means[1] == 1)
    program.set_objective_function(means[0])
    program.set_optimization_mode("maximization")
    if not program.is_satisfiable():  # no policy gives the second group anything
        return inf if any(v for row in tops for v in row) else F(1)
    try:
        value = program.optimal_value()
    except ValueError:  # unbounded
        return inf
    return max(F(1), F(int(value.numerator), int(value.denominator)))


# Random settings


def random_factor(rng: Random, size: int, outputs: int) -> tuple[Table, bool]:
    """A table with or without zeros, one that is close to the identity, or randomized response, which a flag marks."""
    kind = rng.choice(["zeros", "full", "near", "response", "response"])
    if kind == "near" and size > 1:
        slip = F(1, rng.choice([10, 1000, 10**9]))
        return response_rows(size, 1 - slip), False
    if kind == "response" and size > 1:
        keep = rng.choice([F(rng.randint(0, 9), 9), 1 - F(1, 10**6)])
        return response_rows(size, keep), True
    return [random_row(rng, outputs, zeros=kind == "zeros") for _ in range(size)], False


def random_setting(rng: Random, *, uses: str, most_groups: int = 8, releases: int = 1, most_outputs: int = 48) -> Setting:
    """Filters, a utility that depends on the decision, the context or the group too (`uses`), and a population.

    A policy has at most `most_outputs` cells.
    """
    sizes = [n for n in [[2], [2], [3], [3], [4], [5], [6], [7], [8], [2, 2], [2, 3], [2, 2, 2]] if prod(n) <= most_groups]
    while True:
        chosen = rng.choice(sizes)
        factors, flags = zip(*(random_factor(rng, size, rng.randint(1, 4 if len(chosen) == 1 else 2)) for size in chosen), strict=True)
        released = rng.randint(1, 3)
        if prod(len(factor[0]) for factor in factors) ** releases * released <= most_outputs:
            break
    groups, decisions = prod(chosen), rng.randint(1, 3)
    rows_x = None if rng.random() < 0.4 else [random_row(rng, released) for _ in range(rng.randint(1, 3))]
    contexts = released if rows_x is None else len(rows_x)
    population = None if rng.random() < 0.2 else [[F(rng.choice([0, 1, 1, 2, 5])) for _ in range(groups)] for _ in range(contexts)]
    if population is not None and not any(v for row in population for v in row):
        population[0][0] = F(1)
    utility = random_utility(rng, uses, contexts, groups, decisions)
    return Setting(list(factors), utility, rows_x, population, releases, tuple(flags))


def random_utility(rng: Random, uses: str, contexts: int, groups: int, decisions: int) -> list[list[Row]]:
    """g(u), g(u,x) or g(u,x,a), often with a 0 or with equal values."""
    least = rng.choice([F(0), F(0), F(1, 10), F(1)])
    values = [least, least, least + 1, least + 2, least + F(1, 3), least + 7]
    base = [rng.choice(values) for _ in range(decisions)]
    by_context = [base if uses == "decision" else [rng.choice(values) for _ in base] for _ in range(contexts)]
    utility = [[list(row) for _ in range(groups)] for row in by_context]
    chance = rng.choice([0.2, 0.5, 1]) if uses == "group" else 0
    for block in utility:
        for a, row in enumerate(block):
            if rng.random() < chance:
                block[a] = [rng.choice([v, v, rng.choice(values), v + F(1, 4)]) for v in row]
    return utility
