"""Classes of utilities and their certificates, by dense loops over plain fractions and exact linear programs."""

import copy
import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import permutations
from math import lcm
from typing import Any

import pytest
import tiers
from jsonschema import Draft202012Validator
from plain_certificates import false_statements, make

from fairaudit.certificates.certificate import schema

ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")

SCOPE = "every utility of the class"
SCHEMA = Draft202012Validator(schema())
F = Fraction
TINY = F(1, 10**9)
Vector = list[Fraction]
Pair = tuple[int | None, int, int]


def integers(*values: Fraction) -> list[int]:
    common = lcm(*(value.denominator for value in values))
    return [int(value * common) for value in values]


def at_most(coefficients: Sequence[Fraction], bound: Fraction) -> Any:
    scaled = integers(*coefficients, bound)
    return ppl.Linear_Expression(scaled[:-1], -scaled[-1]) <= 0


def solved(constraints: Sequence[tuple[Sequence[Fraction], Fraction]], least: Sequence[Fraction]) -> Vector | None:
    """Find a point at which the objective is least, among all those that satisfy the constraints; None if there are none."""
    problem = ppl.MIP_Problem(len(least))
    for coefficients, bound in constraints:
        if any(coefficients):
            problem.add_constraint(at_most(coefficients, bound))
        elif bound < 0:
            return None
    if not problem.is_satisfiable():
        return None
    problem.set_optimization_mode("minimization")
    problem.set_objective_function(ppl.Linear_Expression(integers(*least), 0))
    point = problem.optimizing_point()
    return [F(int(point.coefficient(ppl.Variable(i))), int(point.divisor())) for i in range(len(least))]


def dot(left: Sequence[Fraction], right: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(left, right, strict=True)), F(0))


def added(*terms: tuple[Fraction, Vector]) -> Vector:
    return [sum((c * v[j] for c, v in terms), F(0)) for j in range(len(terms[0][1]))]


class Case:
    """A random class that holds a utility chosen beforehand, on a random table."""

    def __init__(self, seed: int, kind: str | None = None) -> None:
        pick = self.pick = random.Random(tiers.fresh(seed))
        self.kind = kind or pick.choice(["plain", "plain", "blind", "blind", "family", "rows", "mixed"])
        self.nx, self.na, self.n = pick.randint(1, 2), pick.choice([2, 2, 3]), pick.randint(2, 3)
        cells = [(x, a) for x in range(self.nx) for a in range(self.na) if pick.random() < pick.choice([0.8, 1])]
        self.cells = cells if len(cells) > 1 else [(0, 0), (0, 1)]
        self.population = pick.choice(["counts", "weights", "equal"])
        self.weights: dict[Any, list[str]] = {}
        self.P: dict[Any, Vector] = {}
        masses = {cell: pick.choice([0, 1, 2, 3]) for cell in self.cells}
        masses[self.cells[0]] += 1
        self.M = {cell: F(mass, sum(masses.values())) for cell, mass in masses.items()}
        alike = pick.random() < 0.15
        for cell in self.cells:
            w = [pick.choice([0, 1, 1, 2, 3]) for _ in range(self.n)]
            w[pick.randrange(self.n)] += 1
            if alike:
                w = [1 + cell[0], *[2] * (self.n - 1)]
            self.P[cell] = [F(v, sum(w)) for v in w]
            self.weights[cell] = [str(v) for v in (w if self.population == "counts" else self.P[cell])]
            if self.population != "weights":
                self.M[cell] = F(sum(w)) if self.population == "counts" else F(1)
        self.quantity = pick.choice(["local", "global"])
        self.blind = self.kind == "blind" or (self.kind != "plain" and pick.random() < 0.4)
        self.places = list(dict.fromkeys(x for x, _ in self.cells)) if self.blind else self.cells
        self.choose(pick)
        self.bound(pick)

    def place(self, x: int, a: int) -> int:
        return self.places.index(x if self.blind else (x, a))  # type: ignore[arg-type]

    def choose(self, pick: random.Random) -> None:
        """Choose variables, their boxes, and a utility."""
        of_family = self.kind == "family" or (self.kind == "mixed" and pick.random() < 0.5)
        count = len(self.places) * self.n
        self.family: dict[str, Any] | None = None
        values = [F(0), F(1, 3), F(1, 2), F(1), F(2)]
        if not of_family:
            self.own = [pick.choice(values) for _ in range(count)]
            self.G = [[F(i == j) for j in range(count)] for i in range(count)]
            utility = self.own
        else:
            k = pick.randint(1, 2)
            while True:
                self.G = [[pick.choice([F(0), F(1), F(1, 2), F(-1, 2)]) for _ in range(k)] for _ in range(count)]
                self.own = [pick.choice([F(1), F(2), F(1, 3), F(-1)]) for _ in range(k)]
                utility = [dot(phi, self.own) for phi in self.G]
                if min(utility) >= 0:
                    break
        self.gamma = max(utility) + pick.choice([0, 0, F(1, 2)]) or F(1)
        self.m = min(utility) * pick.choice([0, F(1, 2), 1])
        ends = [(self.m, self.gamma)] * count
        if of_family:
            ends = [(v - pick.choice([0, 1]), v + pick.choice([F(0), F(1, 2), F(3)])) for v in self.own]
            rows = [[pick.choice([F(0), F(1), F(-1)]) for _ in self.own] for _ in range(pick.choice([0, 0, 1, 2]))]
            per_place = {p: self.G[i * self.n : (i + 1) * self.n] for i, p in enumerate(self.places)}
            self.family_rows = [(row, dot(row, self.own) + pick.choice([F(0), F(1, 4)])) for row in rows]
            self.family = {
                "names": [f"t{k}" for k in range(len(self.own))],
                "lower": [str(low) for low, _ in ends],
                "upper": [str(high) for _, high in ends],
                "features": [[[str(v) for v in phi] for phi in per_place[x if self.blind else (x, a)]] for x, a in self.cells],
                "rows": [{"coefficients": [str(v) for v in row], "bound": str(b)} for row, b in self.family_rows],
            }
        self.box = ends

    def bound(self, pick: random.Random) -> None:
        """Choose constraints that the utility satisfies."""
        self.order: list[tuple[int, int]] = []
        self.rows: list[tuple[list[Any], Fraction]] = []
        self.L: Fraction | None = None
        self.metric: list[Vector] | None = None
        closed_form = self.kind == "blind" and pick.random() < 0.7
        g = {cell: self.gains(self.own, *cell) for cell in self.cells}
        if not closed_form:
            fits = [(u, v) for u, v in permutations(range(self.n), 2) if all(g[cell][u] <= g[cell][v] for cell in self.cells)]
            self.order = [pair for pair in fits if pick.random() < 0.4]
        if not self.blind and pick.random() < 0.5:
            if pick.random() < 0.5:
                at = [pick.choice([F(1), F(2), F(5, 2)]) * a for a in range(1, self.na + 1)]
                self.metric = [[abs(p - q) for q in at] for p in at]
                if len(set(at)) < self.na:
                    self.metric = [[F(a != b) * 2 for b in range(self.na)] for a in range(self.na)]
            needed = [
                abs(p - q) / self.distance(a, b)
                for (x, a), (y, b) in permutations(self.cells, 2)
                if x == y
                for p, q in zip(g[x, a], g[x, b], strict=True)
            ]
            self.L = max(needed, default=F(0)) + pick.choice([F(0), F(1, 5)])
        if self.kind in ("rows", "mixed"):
            for _ in range(pick.randint(1, 2)):
                terms = [
                    [x, None if self.blind else a, pick.randrange(self.n), pick.choice([F(1), F(-1), F(1, 2)])]
                    for x, a in pick.choices(self.cells, k=pick.randint(1, 3))
                ]
                value = sum((c * g[x, self.group_in(x, a)][u] for x, a, u, c in terms), F(0))
                self.rows.append((terms, value + pick.choice([F(0), F(1, 3)])))
        means = [self.mean(x, a) for x, a in self.cells] + [self.mean(None, a) for a in self.everywhere()]
        self.tau = None if pick.random() < 0.3 else min(dot(e, self.own) for e in means) * pick.choice([F(1), F(1, 2), F(1)])
        self.tau_on = "all" if closed_form else pick.choice(["pair", "all"])

    def group_in(self, x: int, a: int | None) -> int:
        return next(b for y, b in self.cells if y == x) if a is None else a

    def distance(self, a: int, b: int) -> Fraction:
        return F(1) if self.metric is None else self.metric[a][b]

    def gains(self, point: Vector, x: int, a: int) -> Vector:
        start = self.place(x, a) * self.n
        return [dot(phi, point) for phi in self.G[start : start + self.n]]

    def g(self, x: int, a: int, u: int) -> Vector:
        return self.G[self.place(x, a) * self.n + u]

    def everywhere(self) -> list[int]:
        if self.population == "equal" and len(self.cells) < self.na * self.shape()[0]:
            return []
        groups = [a for a in range(self.na) if sum(self.M[c] for c in self.cells if c[1] == a) > 0]
        return groups if len(groups) > 1 else []

    def shape(self) -> tuple[int, int]:
        return self.nx, self.na

    def mean(self, x: int | None, a: int) -> Vector:
        if x is not None:
            return added(*((p, self.g(x, a, u)) for u, p in enumerate(self.P[x, a])))
        own = [cell for cell in self.cells if cell[1] == a]
        return added(*((self.M[c] / sum(self.M[d] for d in own), self.mean(*c)) for c in own))

    def groups(self, x: int | None) -> list[int]:
        return self.everywhere() if x is None else [a for y, a in self.cells if y == x]

    def pairs(self) -> list[Pair]:
        places = [None] if self.quantity == "global" else list(range(self.nx))
        return [(x, a, b) for x in places for a, b in permutations(self.groups(x), 2)]

    def constraints(self, pair: Pair | None) -> list[tuple[Vector, Fraction]]:
        """List A and b in the order of the page; without a pair, everything but the floors."""
        rows: list[tuple[Vector, Fraction]] = []
        if pair is not None and self.tau is not None:
            floors = pair[1:] if self.tau_on == "pair" else self.groups(pair[0])
            rows += [(added((F(-1), self.mean(pair[0], a))), -self.tau) for a in floors]
        all_of_them = pair is None or pair[0] is None or self.rows or self.family
        concerned = [c for c in self.cells if all_of_them or c[0] == pair[0]]  # type: ignore[index]
        once = [c for i, c in enumerate(concerned) if not self.blind or c[0] not in [d[0] for d in concerned[:i]]]
        for cell in once:
            rows += [(added((F(1), self.g(*cell, u)), (F(-1), self.g(*cell, v))), F(0)) for u, v in self.order]
        if self.L is not None:
            for (x, a), (y, b) in [(c, d) for c in concerned for d in concerned]:
                if x == y and a != b:
                    allowed = self.L * self.distance(a, b)
                    rows += [(added((F(1), self.g(x, a, u)), (F(-1), self.g(x, b, u))), allowed) for u in range(self.n)]
        for terms, bound in self.rows:
            rows.append((added(*((c, self.g(x, self.group_in(x, a), u)) for x, a, u, c in terms)), bound))
        if self.family is not None:
            for phi in self.G:
                rows += [(added((F(-1), phi)), -self.m), (phi, self.gamma)]
            rows += self.family_rows
        return rows

    def within_box(self) -> list[tuple[Vector, Fraction]]:
        rows: list[tuple[Vector, Fraction]] = []
        for j, (low, high) in enumerate(self.box):
            unit = [F(i == j) for i in range(len(self.box))]
            rows += [(added((F(-1), unit)), -low), (unit, high)]
        return rows

    def least_ratio(self, pair: Pair, value: Fraction | None = None) -> tuple[Fraction, list[list[Any]]] | None:
        """Find the least R >= 1 (or take the given one) that multipliers prove, and such multipliers; None if there are none."""
        p, q = self.mean(pair[0], pair[1]), self.mean(pair[0], pair[2])
        rows = self.constraints(pair)
        used = [j for j in range(len(p)) if p[j] or q[j] or any(a[j] for a, _ in rows)]
        k, n = len(rows), len(used)
        size = 1 + k + n  # the unknowns: R, y, and t_j >= max(0, c_j)
        program: list[tuple[Vector, Fraction]] = [([F(-(i == j)) for j in range(size)], F(-(i == 0))) for i in range(size)]
        total = [F(0)] * size
        constant = F(0)
        for i, j in enumerate(used):
            low, high = self.box[j]
            c = [-q[j], *(-a[j] for a, _ in rows)]
            program.append(([*c, *(F(-(i == h)) for h in range(n))], -p[j]))
            for h, coefficient in enumerate(c):
                total[h] += low * coefficient
            total[1 + k + i] += high - low
            constant += low * p[j]
        for h, (_, b) in enumerate(rows):
            total[1 + h] += b
        program.append((total, -constant))
        if value is not None:
            program.append(([F(1)] + [F(0)] * (size - 1), value))
        objective = [F(1)] + [F(0)] * (size - 1)
        if value is not None:  # stay at the given R
            program.append(([F(-1)] + [F(0)] * (size - 1), -value))
        point = solved(program, objective)
        if point is None:
            return None
        return point[0], [[i, str(y)] for i, y in enumerate(point[1 : 1 + k]) if y]

    def proves(self, pair: Pair, value: Fraction, multipliers: list[list[Any]]) -> bool:
        """Evaluate the inequality of the page, densely."""
        rows = self.constraints(pair)
        if any(i >= len(rows) for i, _ in multipliers):
            return False
        y = [(F(v), *rows[i]) for i, v in multipliers]
        c = added((F(1), self.mean(pair[0], pair[1])), (-value, self.mean(pair[0], pair[2])), *((-v, a) for v, a, _ in y))
        boxes = sum((max(e * low, e * high) for e, (low, high) in zip(c, self.box, strict=True)), F(0))
        return boxes + sum((v * b for v, _, b in y), F(0)) <= 0

    def needless(self, pair: Pair, value: Fraction) -> bool:
        x = pair[0]
        same = self.blind and x is not None and len({tuple(self.P[x, a]) for a in self.groups(x)}) == 1
        floor = max(self.tau or F(0), self.m)
        return same or (floor > 0 and self.gamma / floor <= value)

    def contains(self, point: Vector, certificate: dict[str, Any]) -> bool:
        """Say whether the point is in the class, with the floors where the metric of the certificate has its witness."""
        rows = self.constraints(None) + self.within_box()
        metric = certificate["metrics"][self.quantity]
        if metric is not None:
            at = metric["witness"]
            x = int(at["context"]["C"][1:]) if self.quantity == "local" else None
            rows += self.constraints((x, int(at["higher"]["G"][1:]), int(at["lower"]["G"][1:])))
        return all(dot(a, point) <= b for a, b in rows)

    def table(self, point: Vector) -> dict[str, Any]:
        return make(
            self.weights,
            {cell: [str(v) for v in self.gains(point, *cell)] for cell in self.cells},
            population=self.population,
            masses={cell: str(mass) for cell, mass in self.M.items()} if self.population == "weights" else None,
            shape=self.shape(),
        )

    def described(self) -> dict[str, Any]:
        return {
            "quantity": self.quantity,
            "gamma": str(self.gamma),
            "m": str(self.m),
            "tau": None if self.tau is None else str(self.tau),
            "tau_on": self.tau_on,
            "blind": self.blind,
            "lipschitz": None if self.L is None else str(self.L),
            "metric": None if self.metric is None else [[str(d) for d in row] for row in self.metric],
            "order": [[f"u{u}", f"u{v}"] for u, v in self.order],
            "rows": [{"terms": [[*t[:3], str(t[3])] for t in terms], "bound": str(b)} for terms, b in self.rows],
            "family": self.family,
        }

    def certificate(self, point: Vector, value: str, by: str, evidence: dict[str, Any]) -> dict[str, Any]:
        document = self.table(point)
        document["subject"]["class"] = self.described()
        claim = {"quantity": f"{self.quantity}_ratio", "relation": "<=", "value": value, "scope": SCOPE, "by": by}
        document["claims"].append(claim | {"assumptions": [], "evidence": evidence})
        return document

    def dual(self, entries: dict[Pair, list[list[Any]]], point: Vector) -> dict[str, Any]:
        listed = [
            ({} if x is None else {"context": x}) | {"higher": a, "lower": b, "multipliers": y} for (x, a, b), y in sorted(entries.items())
        ]
        return {"pairs": listed} | ({"theta": [str(v) for v in point]} if self.family else {})

    def closed_form(self) -> bool:
        return self.blind and (self.tau is None or self.tau_on == "all") and not (self.order or self.rows or self.family)


class Solved:
    """The greatest ratio of a case, multipliers that prove it, and a utility that attains it if one was found."""

    def __init__(self, case: Case) -> None:
        self.case = case
        best = {pair: case.least_ratio(pair) for pair in case.pairs()}
        self.infinite = [pair for pair, found in best.items() if found is None]
        found = {pair: r for pair, r in best.items() if r is not None}
        self.value = max((r for r, _ in found.values()), default=F(1))
        self.entries = {pair: y for pair, (_, y) in found.items()}
        if case.family and not self.infinite:
            again = {pair: case.least_ratio(pair, self.value) for pair in found}
            self.entries = {pair: r[1] for pair, r in again.items() if r is not None}
            assert len(self.entries) == len(found)
        self.worst = [pair for pair, (r, _) in found.items() if r == self.value and r > 1]
        self.point = case.own
        self.tight = False
        for pair in self.worst[:1]:
            self.look(pair)

    def look(self, pair: Pair) -> None:
        """Solve the other side: a utility of the class for which E = value E'; that shows, without multipliers, that no less will do."""
        case = self.case
        p, q = case.mean(pair[0], pair[1]), case.mean(pair[0], pair[2])
        rows = case.constraints(None) + case.constraints(pair) + case.within_box()
        floors = [
            (added((F(-1), case.mean(x, a))), -case.tau)
            for x in ([None] if case.quantity == "global" else range(case.nx))
            for a in case.groups(x)
            if case.tau is not None
        ]
        for further in ([], floors):
            point = solved(rows + further, added((F(-1), p), (self.value, q)))
            if point is not None and dot(q, point) > 0 and dot(p, point) == self.value * dot(q, point):
                metric = case.table(point)["metrics"][case.quantity]["ratio"]
                if case.contains(point, case.table(point)) and metric == str(self.value):
                    self.point, self.tight = point, True
                    return


def true_certificate(s: Solved) -> dict[str, Any]:
    value = "inf" if s.infinite else str(s.value)
    entries = {} if s.infinite else {pair: y for pair, y in s.entries.items() if not s.case.needless(pair, s.value) or s.case.nx % 2}
    return s.case.certificate(s.point, value, "lp-dual", s.case.dual(entries, s.point))


def tampered(s: Solved, certificate: dict[str, Any]) -> dict[str, Any]:
    """Change the evidence at random."""
    pick = s.case.pick
    certificate = copy.deepcopy(certificate)
    entries = certificate["claims"][-1]["evidence"]["pairs"]
    entry = pick.choice(entries)
    y = entry["multipliers"]
    match pick.choice(["drop", "scale", "shift", "remove", "swap", "extra"]):
        case "drop" if y:
            y.pop(pick.randrange(len(y)))
        case "scale" if y:
            at = pick.choice(y)
            at[1] = str(F(at[1]) * pick.choice([F(1, 2), 2, 1 + F(1, 10**6), 1 - F(1, 10**6)]))
        case "shift" if y:
            by = pick.choice([1, 2, 100])
            for at in y:
                at[0] += by
        case "swap":
            other = pick.choice(entries)
            entry["multipliers"], other["multipliers"] = other["multipliers"], y
        case "extra":
            entry["multipliers"] = [*y, [y[-1][0] + 1 if y else 0, "1/7"]]
        case _:
            entries.remove(entry)
    return certificate


def by_hand(value: str = "3", by: str = "T3", evidence: Any = None, **keys: Any) -> dict[str, Any]:
    """Two contexts, two groups: P = (3/4, 1/4) and (1/4, 3/4) in the first, equal rows in the second."""
    document = make({(0, 0): ["3", "1"], (0, 1): ["1", "3"], (1, 0): ["1", "1"], (1, 1): ["2", "2"]}, ["1", "0"])
    document["subject"]["class"] = {
        "quantity": "local",
        "gamma": "1",
        "m": "0",
        "tau": "1/4",
        "tau_on": "all",
        "blind": True,
        "lipschitz": None,
        "metric": None,
        "order": [],
        "rows": [],
        "family": None,
    } | keys
    if evidence is None:
        evidence = {"multipliers": ["3", "1/3"]}
    claim = {"quantity": "local_ratio", "relation": "<=", "value": value, "scope": SCOPE, "by": by, "assumptions": [], "evidence": evidence}
    document["claims"].append(claim)
    return document


def entries(*given: tuple[Any, ...]) -> dict[str, Any]:
    return {"pairs": [{"context": x, "higher": a, "lower": b, "multipliers": y} for x, a, b, y in given]}


def claim_fault(document: dict[str, Any]) -> str:
    wrong = [line for line in false_statements(document) if line.startswith(f"claims[{len(document['claims']) - 1}]")]
    return wrong[0] if wrong else ""


FAMILY = {"names": ["t"], "lower": ["0"], "upper": ["1"], "features": [[["1"], ["0"]]] * 4, "rows": []}
SQUARE = [["0", "1"], ["1", "0"]]
