"""The worst utility of a class by its definition, a checker of the evidence, and random laws and classes."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import permutations, product
from math import inf
from typing import Any

import numpy as np
import pytest
import tiers

from fairaudit import InputError, Law
from fairaudit.audits.worst_utility import certify_worst_case
from fairaudit.model.utility_class import Family, UtilityClass
from fairaudit.worst.methods import worst_case
from fairaudit.worst.result import WorstCase

F = Fraction
CLASSES = ("range", "order", "partial", "lipschitz", "metric", "lipschitz-order", "free", "rows", "free-rows", "family", "free-family")


# An oracle: the definition of the class as one exact linear program over all its variables


class Oracle:
    """Rows of a law and a class as plain fractions, laid out anew from the definitions."""

    def __init__(self, law: Law, of: UtilityClass, quantity: str) -> None:
        self.law, self.of, self.quantity = law, of, quantity
        self.cells = [(int(x), int(a)) for x, a in zip(law.cell_context, law.cell_group, strict=True)]
        self.p = {}
        for (x, a), row in zip(self.cells, law.weights.tolist(), strict=True):
            self.p[x, a] = [F(v) / sum(map(F, row)) for v in row]
        self.mass = dict(zip(self.cells, law.cell_mass, strict=True))
        self.n = len(law.decisions)
        self.keys = sorted({(x, -1 if of.blind else a) for x, a in self.cells})

    def g(self, x: int, a: int, u: int) -> dict[Any, Fraction]:
        """One value of the utility in the free variables."""
        if self.of.family is None:
            return {(x, -1 if self.of.blind else a, u): F(1)}
        return {k: phi for k, phi in enumerate(self.phi(x, a, u)) if phi}

    def phi(self, x: int, a: int, u: int) -> list[Fraction]:
        label = self.law.decisions[u]
        features = self.of.family.features.values()
        return [F(f.get(label, 0)) if isinstance(f, dict) else F(f(label, self.law.contexts[x], self.law.groups[a])) for f in features]

    def mix(self, parts: list[tuple[Fraction, dict[Any, Fraction]]]) -> dict[Any, Fraction]:
        total: dict[Any, Fraction] = {}
        for weight, terms in parts:
            for key, value in terms.items():
                total[key] = total.get(key, F(0)) + weight * value
        return total

    def mean(self, member: Any) -> dict[Any, Fraction]:
        if self.quantity == "local":
            x, a = member
            return self.mix([(self.p[x, a][u], self.g(x, a, u)) for u in range(self.n)])
        whole = sum(m for (_, b), m in self.mass.items() if b == member)
        return self.mix(
            [(F(self.mass[c], whole) * self.p[c][u], self.g(*c, u)) for c in self.cells if c[1] == member for u in range(self.n)]
        )

    def constraints(self) -> list[tuple[dict[Any, Fraction], Fraction]]:
        """Everything but the floors: Σ ≤ bound."""
        of, rows = self.of, []
        index = self.law.decisions.index
        for x, a in self.cells:
            for u in range(self.n):
                rows.append((self.g(x, a, u), of.gamma))
                rows.append((self.mix([(F(-1), self.g(x, a, u))]), -of.m))
            for low, high in of.order:
                rows.append((self.mix([(F(1), self.g(x, a, index(low))), (F(-1), self.g(x, a, index(high)))]), F(0)))
            if of.lipschitz is not None:
                for y, b in self.cells:
                    if y == x and b != a:
                        d = 1 if of.metric is None else of.metric(self.law.groups[a], self.law.groups[b])
                        for u in range(self.n):
                            rows.append((self.mix([(F(1), self.g(x, a, u)), (F(-1), self.g(x, b, u))]), of.lipschitz * F(d)))
        for row in of.rows:
            parts = []
            for context, group, label, coefficient in row.terms:
                x = 0 if context is None else self.law.contexts.index(context)
                a = next(b for y, b in self.cells if y == x) if group is None else self.law.groups.index(group)
                parts.append((coefficient, self.g(x, a, index(label))))
            rows.append((self.mix(parts), row.bound))
        if of.family is not None:
            for k in range(len(of.family.names)):
                rows.append(({k: F(1)}, of.family.upper[k]))
                rows.append(({k: F(-1)}, -of.family.lower[k]))
            for coefficients, bound in of.family.rows:
                rows.append((dict(enumerate(coefficients)), bound))
        return rows

    def blocks(self) -> list[list[Any]]:
        if self.quantity == "global":
            return [list(self.law.global_groups)]
        found: dict[int, list[Any]] = {}
        for x, a in self.cells:
            found.setdefault(x, []).append((x, a))
        return [block for block in found.values() if len(block) > 1]

    def worst(self) -> Any:
        """Exact supremum over the class and all pairs; None if the class is empty for every pair."""
        rows = self.constraints()
        best = None
        for block in self.blocks():
            for high, low in permutations(block, 2):
                floors = [] if self.of.tau is None else [high, low] if self.of.tau_on == "pair" else block
                floored = [(self.mix([(F(-1), self.mean(member))]), -self.of.tau) for member in floors]
                value = supremum([*rows, *floored], self.mean(high), self.mean(low))
                if value is not None and (best is None or value > best):
                    best = value
        return best


def exact_program(rows: list[Any], equal: list[Any], objective: dict[Any, Fraction]) -> Any:
    """Maximise exactly by PPL: None infeasible, inf unbounded."""
    ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")

    names = sorted({key for terms, _ in [*rows, *equal] for key in terms} | set(objective), key=repr)
    index = {name: ppl.Variable(i) for i, name in enumerate(names)}
    problem = ppl.MIP_Problem(len(names))

    def expression(terms: dict[Any, Fraction], bound: Fraction) -> tuple[Any, int]:
        scale = np.lcm.reduce([v.denominator for v in terms.values()] + [bound.denominator], dtype=object)
        total = ppl.Linear_Expression(0)
        for key, value in terms.items():
            total += int(value * scale) * index[key]
        return total - int(bound * scale), int(scale)

    for terms, bound in rows:
        if any(terms.values()):
            problem.add_constraint(expression(terms, bound)[0] <= 0)
        elif bound < 0:
            return None
    for terms, bound in equal:
        if any(terms.values()):
            problem.add_constraint(expression(terms, bound)[0] == 0)
        elif bound:
            return None
    total, scale = expression(objective, F(0))
    problem.set_objective_function(total)
    problem.set_optimization_mode("maximization")
    status = problem.solve()
    if status["status"] == "unfeasible" if isinstance(status, dict) else not problem.is_satisfiable():
        return None
    try:
        value = problem.optimal_value()
    except ValueError:
        return inf
    return F(str(value)) / scale


def supremum(rows: list[Any], p: dict[Any, Fraction], q: dict[Any, Fraction]) -> Any:
    """Greatest p·v/q·v, exactly, with 0/0 = 1."""
    if not satisfiable(rows):
        return None
    homogeneous = [({**terms, "s": -bound}, F(0)) for terms, bound in rows] + [({"s": F(-1)}, F(0))]
    value = exact_program(homogeneous, [(q, F(1))], p)
    if value is not None:
        return max(value, F(1))
    return inf if exact_program(rows, [], p) > 0 else F(1)


def satisfiable(rows: list[Any]) -> bool:
    return exact_program(rows, [], {}) is not None


# A checker of the evidence, from the page


def checks(document: dict[str, Any]) -> bool:
    """Whether the claim about the class is proved, and the utility of the table is in the class; from docs/certificate-worst-case.md."""
    subject, of = document["subject"], document["subject"]["class"]
    claim = document["claims"][-1]
    head, rows = subject["table"]["header"], subject["table"]["rows"]
    n = len(head["decisions"])
    value = inf if claim["value"] == "inf" else F(claim["value"])
    gamma, m, tau = F(of["gamma"]), F(of["m"]), None if of["tau"] is None else F(of["tau"])
    blind, local = of["blind"], of["quantity"] == "local"
    cells = [(row["context"], row["group"]) for row in rows]
    p = {}
    for cell, row in zip(cells, rows, strict=True):
        weights = [F(v) for v in row["weights"]]
        p[cell] = [v / sum(weights) for v in weights]
    if head["population"] == "counts":
        mass = {cell: sum(F(v) for v in row["weights"]) for cell, row in zip(cells, rows, strict=True)}
    else:
        mass = {cell: F(row.get("mass", 1)) for cell, row in zip(cells, rows, strict=True)}
    contexts = list(dict.fromkeys(x for x, _ in cells))
    slots = [(x, None) for x in contexts] if blind else cells
    family = of["family"]

    def variable(x: int, a: int, u: int) -> dict[Any, Fraction]:
        if family is None:
            return {(x, None if blind else a, u): F(1)}
        return {k: F(v) for k, v in enumerate(family["features"][cells.index((x, a))][u]) if F(v)}

    def add(parts: list[tuple[Fraction, dict[Any, Fraction]]]) -> dict[Any, Fraction]:
        total: dict[Any, Fraction] = {}
        for weight, terms in parts:
            for key, v in terms.items():
                total[key] = total.get(key, F(0)) + weight * v
        return total

    def mean(x: int | None, a: int) -> dict[Any, Fraction]:
        if x is not None:
            return add([(p[x, a][u], variable(x, a, u)) for u in range(n)])
        whole = sum(mass[c] for c in cells if c[1] == a)
        return add([(mass[c] / whole * p[c][u], variable(*c, u)) for c in cells if c[1] == a for u in range(n)])

    if local:
        blocks = {x: [a for y, a in cells if y == x] for x in contexts}
        blocks = {x: groups for x, groups in blocks.items() if len(groups) > 1}
    else:
        blocks = {None: [a for a in range(len(head["groups"])) if sum(mass[c] for c in cells if c[1] == a) > 0]}
    couples = bool(of["rows"]) or family is not None
    index = {label: u for u, label in enumerate(head["decisions"])}

    def any_cell(slot: Any) -> tuple[int, int]:
        return slot if slot[1] is not None else next(c for c in cells if c[0] == slot[0])

    def without_floors(x: int | None) -> list[tuple[dict[Any, Fraction], Fraction]]:
        concerned = contexts if x is None or couples else [x]
        found = []
        for slot in slots:
            if slot[0] in concerned:
                for low, high in of["order"]:
                    c = any_cell(slot)
                    found.append((add([(F(1), variable(*c, index[low])), (F(-1), variable(*c, index[high]))]), F(0)))
        if of["lipschitz"] is not None:
            for y in concerned:
                here = [c for c in cells if c[0] == y]
                for first, second in permutations(here, 2):
                    d = F(of["metric"][first[1]][second[1]]) if of["metric"] else F(1)
                    for u in range(n):
                        found.append((add([(F(1), variable(*first, u)), (F(-1), variable(*second, u))]), F(of["lipschitz"]) * d))
        for row in of["rows"]:
            parts = [(F(c), variable(*any_cell((y, a)), u)) for y, a, u, c in row["terms"]]
            found.append((add(parts), F(row["bound"])))
        if family is not None:
            for slot in slots:
                for u in range(n):
                    g = variable(*any_cell(slot), u)
                    found += [(add([(F(-1), g)]), -m), (g, gamma)]
            for row in family["rows"]:
                found.append(({k: F(v) for k, v in enumerate(row["coefficients"]) if F(v)}, F(row["bound"])))
        return found

    def floors(x: int | None, high: int, low: int) -> list[tuple[dict[Any, Fraction], Fraction]]:
        if tau is None:
            return []
        groups = [high, low] if of["tau_on"] == "pair" else blocks[x]
        return [(add([(F(-1), mean(x, a))]), -tau) for a in groups]

    def box(key: Any) -> tuple[Fraction, Fraction]:
        return (m, gamma) if family is None else (F(family["lower"][key]), F(family["upper"][key]))

    # The utility is in the class.
    table = {}
    for cell, row in zip(cells, rows, strict=True):
        for u, v in enumerate(head["utility"] if head["utility"] is not None else row["utility"]):
            table[(cell[0], None if blind else cell[1], u)] = F(v)
            assert not blind or F(v) == table[cell[0], None, u]
    assert all(m <= v <= gamma for v in table.values())
    point = table if family is None else {k: F(v) for k, v in enumerate(claim["evidence"]["theta"])}
    if family is not None:
        assert all(F(a) <= point[k] <= F(b) for k, (a, b) in enumerate(zip(family["lower"], family["upper"], strict=True)))
        for cell in cells:
            for u in range(n):
                assert sum((v * point[k] for k, v in variable(*cell, u).items()), F(0)) == table[cell[0], None if blind else cell[1], u]

    def at(terms: dict[Any, Fraction]) -> Fraction:
        return sum((v * point[k] for k, v in terms.items()), F(0))

    for x in blocks:
        assert all(at(terms) <= bound for terms, bound in without_floors(x))
    metric = document["metrics"]["local" if local else "global"]
    witness = metric["witness"]
    where = None
    if local:
        where = head["contexts"].index(list(witness["context"].values()))
    pair = [head["groups"].index(list(witness[side].values())) for side in ("higher", "lower")]
    assert all(at(terms) <= bound for terms, bound in floors(where, *pair))
    attained = inf if metric["ratio"] == "inf" else F(metric["ratio"])
    assert attained <= value
    # The bound is proved.
    assert value >= 1
    if value == inf:
        return True
    least = max(m, tau or F(0))
    if claim["by"] == "T3":
        assert blind and not of["order"] and not couples and (tau is None or of["tau_on"] == "all")
        for x, groups in blocks.items():
            for high, low in permutations(groups, 2):
                one, other = mean(x, high), mean(x, low)
                if one == other:
                    continue
                proved = False
                for k in map(F, claim["evidence"]["multipliers"]):
                    stick = sum((max(F(0), one.get(j, F(0)) - k * other.get(j, F(0))) for j in {*one, *other}), F(0))
                    if least:
                        proved |= k * least + max(F(0), (gamma - m) * stick - (k - 1) * m) <= value * least
                    else:
                        proved |= stick == 0 and k <= value
                if not proved:
                    return False
        return True
    entries = {(e.get("context"), e["higher"], e["lower"]): e["multipliers"] for e in claim["evidence"]["pairs"]}
    assert len(entries) == len(claim["evidence"]["pairs"])
    for x, groups in blocks.items():
        rest = without_floors(x)
        for high, low in permutations(groups, 2):
            if (x, high, low) not in entries:
                if (local and blind and all(p[x, a] == p[x, groups[0]] for a in groups)) or (least and gamma / least <= value):
                    continue
                return False
            listed = [*floors(x, high, low), *rest]
            c = add([(F(1), mean(x, high)), (-value, mean(x, low))])
            total = F(0)
            numbers = [number for number, _ in entries[x, high, low]]
            assert numbers == sorted(set(numbers))
            for number, y in entries[x, high, low]:
                assert F(y) > 0
                terms, bound = listed[number]
                c = add([(F(1), c), (-F(y), terms)])
                total += F(y) * bound
            for key, v in c.items():
                low_end, high_end = box(key)
                total += max(v * low_end, v * high_end)
            if total > 0:
                return False
    return True


# Instances


def random_law(rng: random.Random, sizes: tuple[int, int, int]) -> Law:
    contexts, groups, n = sizes
    while True:
        table = [
            [[rng.choice([0, 1, 1, 2, 3, rng.randint(1, 50), rng.randint(1, 1000)]) for _ in range(n)] for _ in range(groups)]
            for _ in range(contexts)
        ]
        for x, a in product(range(contexts), range(groups)):
            if contexts > 1 and rng.random() < 0.1:
                table[x][a] = [0] * n
        if sum(any(map(any, zip(*(table[x][a] for x in range(contexts)), strict=True))) for a in range(groups)) < groups:
            continue
        if any(sum(map(any, table[x])) > 1 for x in range(contexts)) and all(any(map(any, context)) for context in table):
            labels = [f"d{u}" for u in range(n)]
            return Law.from_array(table, kind="counts", decisions=labels, contexts=[f"x{i}" for i in range(contexts)])


def random_class(rng: random.Random, kind: str, law: Law) -> UtilityClass:
    labels = list(law.decisions)
    options: dict[str, Any] = {
        "gamma": rng.choice([F(1), F(5, 2)]),
        "m": rng.choice([F(0), F(0), F(1, 10)]),
        "tau": rng.choice([None, F(1, 50), F(1, 4), F(1, 3), F(1, 2), F(9, 10)]),
        "tau_on": rng.choice(["all", "all", "pair"]),
    }
    free = kind.startswith(("free", "lipschitz", "metric"))
    options["blind"] = not free
    if "order" in kind:
        options["order"] = rng.sample(labels, min(len(labels), rng.randint(2, 60)))
    if kind == "partial":
        options["order"] = [tuple(rng.sample(labels, 2)) for _ in range(rng.randint(1, len(labels)))]
    if kind.startswith(("lipschitz", "metric")):
        options["lipschitz"] = rng.choice([F(0), F(1, 20), F(1, 4), F(2)])
    if kind == "metric":
        options["metric"] = lambda a, b: abs(int(a[0]) - int(b[0]))
    if "rows" in kind:
        rows = []
        for _ in range(rng.randint(1, 4)):
            terms = {}
            for _ in range(rng.randint(1, 3)):
                cell = rng.randrange(len(law.weights))
                x, a = law.contexts[int(law.cell_context[cell])], law.groups[int(law.cell_group[cell])]
                key = (rng.choice(labels), x, a) if free else (rng.choice(labels), x)
                terms[key] = F(rng.randint(-4, 4) or 1, rng.randint(1, 4))
            rows.append((terms, F(rng.randint(-1, 4), 2)))
        options["rows"] = rows
    if "family" in kind:
        features: dict[str, Any] = {"constant": dict.fromkeys(labels, 1)}
        for k in range(rng.randint(1, 4)):
            table = {(u, a): F(rng.randint(-4, 4), 4) for u in labels for a in range(9)}
            if free:
                features[f"f{k}"] = lambda u, x, a, table=table: table[u, int(a[0])]
            else:
                features[f"f{k}"] = {u: table[u, 0] for u in labels}
        rows = [({"constant": 1, "f0": 1}, 2)] if rng.random() < 0.5 else []
        options["family"] = Family(features, rng.choice([0, -1]), rng.choice([1, 2]), rows)
    return UtilityClass(**options)


def instance(kind: str, number: int, largest: int) -> tuple[Law, UtilityClass, Any]:
    rng = random.Random(tiers.fresh(f"{kind} {number}"))
    sizes = (1, 2, rng.randint(2, largest)) if number % 6 == 0 else (rng.randint(1, 3), rng.randint(2, 3), rng.randint(2, 6))
    law = random_law(rng, sizes)
    return law, random_class(rng, kind, law), rng.choice(["local", "local", "global"])


def solve_or_none(law: Law, of: UtilityClass, quantity: Any) -> WorstCase | None:
    try:
        return worst_case(law, of, quantity)
    except InputError as error:
        assert "no utility is in the class" in str(error)
        return None


def certificate_or_none(found: WorstCase) -> Any:
    try:
        return certify_worst_case(found).document
    except InputError as error:
        assert "which a certificate cannot express" in str(error)
        assert found.utility_class.couples and found.utility_class.tau is not None
        return None
