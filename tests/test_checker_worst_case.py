"""The checker on certificates of a worst-case utility, against dense loops over plain fractions and exact linear programs."""

import copy
import json
import random
import time
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from itertools import permutations
from math import lcm
from typing import Any

import ppl
import pytest
from jsonschema import Draft202012Validator
from test_checker_unit import checker, false_statements, make, raw

from fairaudit.certificates.certificate import schema

SCOPE = "every utility of the class"
SCHEMA = Draft202012Validator(schema())
F = Fraction
TINY = F(1, 10**9)
Vector = list[Fraction]
Pair = tuple[int | None, int, int]


# Linear programs in exact arithmetic


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


# A tiny writer: a random table, a random class, everything by definition


class Case:
    """A random class that holds a utility chosen beforehand, on a random table."""

    def __init__(self, seed: int, kind: str | None = None) -> None:
        pick = self.pick = random.Random(seed)
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


@cache
def solved_case(seed: int) -> Solved:
    return Solved(Case(seed))


def true_certificate(s: Solved) -> dict[str, Any]:
    value = "inf" if s.infinite else str(s.value)
    entries = {} if s.infinite else {pair: y for pair, y in s.entries.items() if not s.case.needless(pair, s.value) or s.case.nx % 2}
    return s.case.certificate(s.point, value, "lp-dual", s.case.dual(entries, s.point))


def claims_true(certificate: dict[str, Any]) -> bool:
    """Whether the last claim is true by the checker."""
    findings = [f for f in checker.check(raw(certificate)).findings if f.statement.startswith(f"claims[{len(certificate['claims']) - 1}]")]
    return all(f.true for f in findings)


def multipliers_of(case: Case, pair: Pair) -> list[Fraction]:
    """List the k at which k t + max(0, (gamma - m) H_k - (k - 1) m) can be least."""
    P, Q = (joint(case, pair[0], a) for a in pair[1:])
    breaks = sorted({F(0), F(1), *(p / q for p, q in zip(P, Q, strict=True) if q)})

    def excess(k: Fraction) -> Fraction:
        return (case.gamma - case.m) * sum((max(F(0), p - k * q) for p, q in zip(P, Q, strict=True)), F(0)) - (k - 1) * case.m

    roots = []
    for low, high in zip(breaks, [*breaks[1:], breaks[-1] + 1], strict=True):
        at, further = excess(low), excess(high)
        if at != further:
            root = low + (high - low) * at / (at - further)
            if root >= low:
                roots.append(root)
    return breaks + roots


def joint(case: Case, x: int | None, a: int) -> Vector:
    return case.mean(x, a)  # blind and without a family: the coefficients are the probabilities P(u,x|a) or P(u|x,a)


def closed_bound(case: Case, pair: Pair, k: Fraction) -> Fraction | None:
    P, Q = (joint(case, pair[0], a) for a in pair[1:])
    if P == Q:
        return F(1)
    floor = max(case.tau or F(0), case.m)
    h = sum((max(F(0), p - k * q) for p, q in zip(P, Q, strict=True)), F(0))
    if floor == 0:
        return k if h == 0 else None
    return k + max(F(0), (case.gamma - case.m) * h - (k - 1) * case.m) / floor


# True certificates


BLOCKS = 8
PER_BLOCK = 40


@pytest.mark.parametrize("block", range(BLOCKS))
def test_least_values_and_what_is_less(block: int) -> None:
    """The claim at the exact optimum is true; 10^-9 below, no multipliers make it true."""
    tight = finite = 0
    for seed in range(block * PER_BLOCK, (block + 1) * PER_BLOCK):
        s = solved_case(seed)
        certificate = true_certificate(s)
        exists = certificate["metrics"][s.case.quantity] is not None
        wrong = false_statements(certificate)
        if not exists:
            assert len(wrong) == 1 and "does not give this quantity" in wrong[0], seed
            continue
        assert wrong == [], seed
        assert not list(SCHEMA.iter_errors(certificate)), seed
        if s.infinite or s.value == 1:
            continue
        finite += 1
        tight += s.tight
        less = s.value - TINY
        assert any(s.case.least_ratio(pair, less) is None and not s.case.needless(pair, less) for pair in s.worst), seed
        lower = copy.deepcopy(certificate)
        lower["claims"][-1]["value"] = str(less)
        for _ in range(3):
            assert not claims_true(lower), seed
            for entry in lower["claims"][-1]["evidence"]["pairs"]:
                for pair in entry["multipliers"]:
                    pair[1] = str(F(pair[1]) * s.case.pick.choice([1 - TINY, 1 + TINY, F(1, 2), 2, 1]))
    assert finite >= PER_BLOCK // 4 and tight >= finite // 2


def test_every_kind_occurs() -> None:
    seen = [solved_case(seed) for seed in range(BLOCKS * PER_BLOCK)]
    settled = [s for s in seen if s.tight]
    tests: list[Callable[[Case], Any]] = [
        lambda c: c.family and c.blind,
        lambda c: c.family and not c.blind and c.quantity == "local" and c.nx > 1,
        lambda c: c.family and c.quantity == "global",
        lambda c: c.L is not None and c.metric,
        lambda c: c.L is not None and c.metric is None,
        lambda c: c.rows and c.quantity == "local" and c.nx > 1,
        lambda c: c.rows and c.quantity == "global",
        lambda c: c.order and c.blind,
        lambda c: c.order and not c.blind and c.tau_on == "pair",
        lambda c: c.tau is not None and c.tau_on == "all" and c.na > 2,
        lambda c: c.m > 0 and c.tau is not None,
    ]
    for i, test in enumerate(tests):
        assert sum(bool(test(s.case)) for s in settled) >= 4, i
    assert sum(bool(s.infinite) for s in seen) >= 10


@pytest.mark.parametrize("block", range(4))
def test_closed_form(block: int) -> None:
    """T3 at the least value that multipliers prove; two groups: no greater than the linear program's."""
    count = sharp = 0
    for seed in range(block * 40, block * 40 + 40):
        case = Case(10_000 + seed, "blind")
        if not case.closed_form() or not case.pairs():
            continue
        ks = sorted({k for pair in case.pairs() for k in multipliers_of(case, pair)})
        least = [min((b for k in ks if (b := closed_bound(case, pair, k)) is not None), default=None) for pair in case.pairs()]
        rational = [str(k) for k in ks]
        if None in least:
            assert false_statements(case.certificate(case.own, "inf", "T3", {"multipliers": rational})) == []
            assert not claims_true(case.certificate(case.own, "1000", "T3", {"multipliers": [*rational, "1000"]}))
            count += 1
            continue
        value = max([F(1), *(b for b in least if b is not None)])
        count += 1
        assert false_statements(case.certificate(case.own, str(value), "T3", {"multipliers": rational})) == [], seed
        shuffled = case.pick.sample(rational, len(rational))
        assert claims_true(case.certificate(case.own, str(value + TINY), "T3", {"multipliers": shuffled + shuffled}))
        linear = [case.least_ratio(pair) for pair in case.pairs()]
        best = max(r[0] for r in linear if r is not None)
        assert best <= value
        sharp += best == value
        if value > 1:
            more = [str(k + case.pick.choice([-1, 1]) * TINY) for k in ks if k > TINY]
            assert not claims_true(case.certificate(case.own, str(value - TINY), "T3", {"multipliers": rational + more})), seed
        # Which lists of multipliers do: the checker's search against trying all of them.
        for _ in range(5):
            some = case.pick.sample(ks, min(len(ks), case.pick.randint(0, 3)))
            at = case.pick.choice([value, value + F(1, 2), value * 2])
            each = [any((b := closed_bound(case, pair, k)) is not None and b <= at and k <= at for k in some) for pair in case.pairs()]
            alike = [joint(case, x, a) == joint(case, x, b) for x, a, b in case.pairs()]
            true = all(e or same for e, same in zip(each, alike, strict=True))
            certificate = case.certificate(case.own, str(at), "T3", {"multipliers": [str(k) for k in some]})
            assert claims_true(certificate) == true, (seed, some, at)
            assert not list(SCHEMA.iter_errors(certificate))
    assert count >= 15 and sharp >= 8


# False certificates


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


@pytest.mark.parametrize("block", range(BLOCKS))
def test_tampered_evidence(block: int) -> None:
    """Whatever is done to the evidence, the checker and the dense inequality agree."""
    false = 0
    for seed in range(block * PER_BLOCK, (block + 1) * PER_BLOCK):
        s = solved_case(seed)
        if s.infinite or not s.entries:
            continue
        certificate = s.case.certificate(s.point, str(s.value), "lp-dual", s.case.dual(s.entries, s.point))
        for _ in range(6):
            changed = tampered(s, certificate)
            evidence = changed["claims"][-1]["evidence"]["pairs"]
            given = {(e.get("context"), e["higher"], e["lower"]): e["multipliers"] for e in evidence}
            true = all(
                s.case.proves(pair, s.value, given[pair]) if pair in given else s.case.needless(pair, s.value) for pair in s.case.pairs()
            )
            assert claims_true(changed) == true, (seed, evidence)
            false += not true
    assert false >= PER_BLOCK


def outside(s: Solved) -> list[tuple[str, dict[str, Any]]]:
    """Shrink the class in every way that puts the utility outside, if only just."""
    case, certificate = s.case, true_certificate(s)
    g = {cell: case.gains(s.point, *cell) for cell in case.cells}
    flat = [v for row in g.values() for v in row]
    found: list[tuple[str, dict[str, Any]]] = []

    def change(word: str, **keys: Any) -> None:
        changed = copy.deepcopy(certificate)
        changed["subject"]["class"] |= keys
        found.append((word, changed))

    own = case.described()
    if max(flat) > max(TINY, case.m + TINY, (case.tau or 0) + TINY):
        change("leaves", gamma=str(max(flat) - TINY))
    if min(flat) + TINY <= case.gamma:
        change("leaves", m=str(min(flat) + TINY))
    metric = certificate["metrics"][case.quantity]
    if metric is not None:
        pair = metric["witness"]["expectations"]
        floor = min(map(F, pair)) + TINY
        if floor <= case.gamma:
            change("floor", tau=str(floor), tau_on=case.pick.choice(["pair", "all"]))
    worse = [(u, v) for u in range(case.n) for v in range(case.n) if any(row[u] > row[v] for row in g.values())]
    if worse:
        u, v = case.pick.choice(worse)
        change("order", order=[*own["order"], [f"u{u}", f"u{v}"]])
    cell = case.pick.choice(case.cells)
    u = case.pick.randrange(case.n)
    term = [cell[0], None if case.blind else cell[1], u]
    change("rows", rows=[*own["rows"], {"terms": [[*term, "1"], [*term, "1"]], "bound": str(2 * g[cell][u] - TINY)}])
    spreads = [
        (abs(p - q), a, b) for (x, a), (y, b) in permutations(case.cells, 2) if x == y for p, q in zip(g[x, a], g[y, b], strict=True)
    ]
    if not case.blind and spreads:
        spread, a, b = max(spreads)
        if spread > TINY:
            change("Lipschitz", lipschitz=str(spread - TINY), metric=None)
            near = [[str(F(i != j) * (1 if {i, j} == {a, b} else 2)) for j in range(case.na)] for i in range(case.na)]
            change("Lipschitz", lipschitz=str(spread - TINY), metric=near)
        if spread > 0 and not case.family and not case.rows:
            change("depends on the group", blind=True, lipschitz=None)
    if case.family:
        theta = certificate["claims"][-1]["evidence"]["theta"]
        changed = copy.deepcopy(certificate)
        changed["claims"][-1]["evidence"]["theta"] = [str(F(theta[0]) + TINY), *theta[1:]]
        found.append(("theta", changed))
        changed = copy.deepcopy(certificate)
        changed["subject"]["class"]["family"]["upper"][0] = changed["subject"]["class"]["family"]["lower"][0] = str(F(theta[0]) + TINY)
        found.append(("theta", changed))
        row = {"coefficients": ["1"] + ["0"] * (len(theta) - 1), "bound": str(F(theta[0]) - TINY)}
        changed = copy.deepcopy(certificate)
        changed["subject"]["class"]["family"]["rows"].append(row)
        found.append(("theta", changed))
        changed = copy.deepcopy(certificate)
        changed["claims"].pop()
        found.append(("theta", changed))
    return found


@pytest.mark.parametrize("block", range(BLOCKS))
def test_utilities_outside(block: int) -> None:
    count = 0
    for seed in range(block * PER_BLOCK, (block + 1) * PER_BLOCK):
        for word, changed in outside(solved_case(seed)):
            wrong = [line for line in false_statements(changed) if line.startswith("the utility is in subject.class")]
            floor_first = word == "theta" and wrong and "theta" not in wrong[0]
            assert len(wrong) == 1 and (word in wrong[0] or floor_first), (seed, word, wrong)
            count += 1
    assert count >= 3 * PER_BLOCK


# By hand


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


DUAL = entries((0, 0, 1, []), (0, 1, 0, []))  # P - 3 Q = (0, -2) and (-2, 0): nothing but the box is needed


def test_by_hand() -> None:
    assert false_statements(by_hand()) == []
    assert false_statements(by_hand(by="lp-dual", evidence=DUAL)) == []
    assert claim_fault(by_hand("2999999999/1000000000"))  # the utility attains 3
    assert claim_fault(by_hand("2999999999/1000000000", by="lp-dual", evidence=DUAL))
    statement = checker.check(raw(by_hand())).findings
    assert any("local ratio, 0 <= g <= 1, floor 1/4 for all groups compared, the same for all groups" in f.statement for f in statement)


def test_missing_and_superfluous_pairs() -> None:
    assert "lacks context 0, groups 0 and 1" in claim_fault(by_hand(by="lp-dual", evidence=entries((0, 1, 0, []))))
    assert "lacks context 0, groups 1 and 0" in claim_fault(by_hand(by="lp-dual", evidence=entries((0, 0, 1, []))))
    more = entries((0, 0, 1, []), (0, 1, 0, []), (1, 0, 1, []), (1, 1, 0, []))
    assert not claim_fault(by_hand(by="lp-dual", evidence=more))
    for pair in [(1, 0, 0), (1, 0, 2), (2, 0, 1)]:
        evidence = entries((0, 0, 1, []), (0, 1, 0, []), (*pair, []))
        assert "not compared" in claim_fault(by_hand(by="lp-dual", evidence=evidence))

    def equal(blind: bool) -> dict[str, Any]:
        document = make({(0, 0): ["1", "1"], (0, 1): ["1", "1"]}, ["1", "0"])
        document["subject"]["class"] = by_hand(blind=blind)["subject"]["class"]
        document["claims"].append(by_hand(by="lp-dual", evidence={"pairs": []})["claims"][-1])
        return document

    assert not claim_fault(equal(True))
    assert "lacks context 0" in claim_fault(equal(False))  # equal rows do not help when g depends on the group


def test_floors_make_pairs_needless() -> None:
    assert not claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}))  # gamma/tau = 4
    assert not claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}, tau_on="pair"))
    assert claim_fault(by_hand("3999/1000", by="lp-dual", evidence={"pairs": []}))
    assert claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}, tau=None))
    assert claim_fault(by_hand("1000000", by="lp-dual", evidence={"pairs": []}, tau="0"))
    assert claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}, tau="1/5"))
    bad = entries((0, 0, 1, [[0, "1000"]]))
    assert "more than 0" in claim_fault(by_hand("4", by="lp-dual", evidence=bad))  # an entry that is there has to be right


def test_infinity() -> None:
    assert not claim_fault(by_hand("inf", by="lp-dual", evidence={"pairs": []}, tau=None))
    assert not claim_fault(by_hand("inf", evidence={"multipliers": []}, tau=None))
    certain = by_hand("inf", by="lp-dual", evidence={"pairs": []}, tau=None)
    certain["claims"][-1]["relation"] = "="
    assert "unknown claim" in claim_fault(certain)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"blind": False}, "blind classes"),
        ({"tau_on": "pair"}, "all groups keep the floor"),
        ({"order": [["u1", "u0"]]}, "without further constraints"),
        ({"rows": [{"terms": [], "bound": "0"}]}, "without further constraints"),
        ({"quantity": "global"}, "the class is about the global ratio"),
    ],
)
def test_t3_has_conditions(keys: dict[str, Any], words: str) -> None:
    assert words in claim_fault(by_hand(**keys))
    assert words in claim_fault(by_hand("inf", **keys))
    assert not claim_fault(by_hand(tau=None, tau_on="pair"))


def test_values_contradict() -> None:
    assert "greater quantity" in claim_fault(by_hand("5/2", tau="1/3", evidence={"multipliers": ["5/2", "0", "1"]}))
    assert "less than 1" in claim_fault(by_hand("1/2"))
    assert "less than 1" in claim_fault(by_hand("-3"))
    constant = make({(0, 0): ["1", "1"], (0, 1): ["1", "1"]}, ["0", "0"])  # 0/0 everywhere
    constant["subject"]["class"] = by_hand()["subject"]["class"] | {"tau": None}
    claim = by_hand()["claims"][-1] | {"by": "lp-dual", "evidence": {"pairs": []}}
    for value, true in [("0", False), ("999999/1000000", False), ("1", True)]:
        constant["claims"] = [claim | {"value": value}]
        assert (false_statements(constant) == []) == true


def test_other_claims() -> None:
    twice = by_hand()
    twice["claims"].append(copy.deepcopy(twice["claims"][-1]))
    assert "occurs twice" in claim_fault(twice)
    both = by_hand()
    both["claims"].append(by_hand(by="lp-dual", evidence=DUAL)["claims"][-1])
    assert false_statements(both) == [] and not list(SCHEMA.iter_errors(both))
    classless = by_hand()
    del classless["subject"]["class"]
    assert "unknown claim" in claim_fault(classless)
    assert list(SCHEMA.iter_errors(classless))
    for change in ({"scope": "this law"}, {"scope": "any policy behind this filter"}, {"by": "T4"}, {"quantity": "equalized_odds"}):
        other = by_hand()
        other["claims"][-1] |= change
        assert "unknown claim" in claim_fault(other)
        assert list(SCHEMA.iter_errors(other))
    without = by_hand()
    without["claims"].pop()
    assert false_statements(without) == []


def test_null_quantity() -> None:
    lonely = make({(0, 0): ["1", "1"], (1, 1): ["1", "1"]}, ["1", "0"])
    lonely["subject"]["class"] = by_hand()["subject"]["class"]
    assert false_statements(lonely) == []
    lonely["claims"].append(by_hand("inf")["claims"][-1])
    assert "does not give this quantity" in claim_fault(lonely)


def test_only_given_entries() -> None:
    document = make({(0, 0): ["1", "0"], (0, 1): ["1", "0"]}, {(0, 0): ["1", None], (0, 1): ["1", "0"]})
    document["subject"]["class"] = by_hand()["subject"]["class"]
    assert "not given everywhere" in false_statements(document)[0]


# Malformed


FAMILY = {"names": ["t"], "lower": ["0"], "upper": ["1"], "features": [[["1"], ["0"]]] * 4, "rows": []}
SQUARE = [["0", "1"], ["1", "0"]]
ROW = {"terms": [[0, None, 0, "1"]], "bound": "5"}


def test_family_by_hand() -> None:
    evidence = entries((0, 0, 1, []), (0, 1, 0, [[3, "1"]])) | {"theta": ["1"]}
    # In theta: E = 3/4, E' = 1/4. The value 3 suffices for the one pair, 1 for the other; the evidence for it does no harm or does.
    document = by_hand(by="lp-dual", evidence=evidence, family=FAMILY)
    assert "groups 1 and 0" in claim_fault(document)
    document["claims"][-1]["evidence"]["pairs"][1]["multipliers"] = []
    assert false_statements(document) == []
    assert not list(SCHEMA.iter_errors(document))


MALFORMED = {
    "gamma 0": {"gamma": "0"},
    "m above gamma": {"m": "2"},
    "negative m": {"m": "-1"},
    "tau above gamma": {"tau": "2"},
    "negative tau": {"tau": "-1/4"},
    "tau_on": {"tau_on": "some"},
    "tau_on null": {"tau_on": None, "tau": None},
    "quantity": {"quantity": "local_ratio"},
    "blind": {"blind": 1},
    "lipschitz when blind": {"lipschitz": "1"},
    "negative lipschitz": {"blind": False, "lipschitz": "-1"},
    "infinite gamma": {"gamma": "inf"},
    "not in lowest terms": {"gamma": "2/2"},
    "unknown key": {"note": "x"},
    "not square": {"metric": [["0", "1"]]},
    "empty": {"metric": []},
    "one group far from itself": {"metric": [["1"]]},
    "too small": {"metric": [["0"]]},
    "too large": {"metric": [["0", "1", "1"], ["1", "0", "1"], ["1", "1", "0"]]},
    "asymmetric": {"metric": [["0", "1"], ["2", "0"]]},
    "zero distance": {"metric": [["0", "0"], ["0", "0"]]},
    "diagonal": {"metric": [["1", "1"], ["1", "0"]]},
    "negative distance": {"metric": [["0", "-1"], ["-1", "0"]]},
    "order of one": {"order": [["u0"]]},
    "order unknown": {"order": [["u0", "u7"]]},
    "rows group when blind": {"rows": [{"terms": [[0, 0, 0, "1"]], "bound": "5"}]},
    "rows without group": {"blind": False, "rows": [ROW]},
    "rows context": {"rows": [{"terms": [[2, None, 0, "1"]], "bound": "5"}]},
    "rows decision": {"rows": [{"terms": [[0, None, 2, "1"]], "bound": "5"}]},
    "rows negative": {"rows": [{"terms": [[0, None, -1, "1"]], "bound": "5"}]},
    "rows boolean": {"rows": [{"terms": [[False, None, 0, "1"]], "bound": "5"}]},
    "rows number": {"rows": [{"terms": [[0, None, 0, 1]], "bound": "5"}]},
    "rows bound": {"rows": [{"terms": [], "bound": "inf"}]},
    "rows cell": {"blind": False, "rows": [{"terms": [[0, 2, 0, "1"]], "bound": "5"}]},
    "family names": {"family": FAMILY | {"names": ["t", "t"]}},
    "family no names": {"family": FAMILY | {"names": [], "lower": [], "upper": [], "features": [[[], []]] * 4}},
    "family ends": {"family": FAMILY | {"lower": ["2"]}},
    "family lengths": {"family": FAMILY | {"upper": ["1", "1"]}},
    "family cells": {"family": FAMILY | {"features": [[["1"], ["0"]]] * 3}},
    "family decisions": {"family": FAMILY | {"features": [[["1"]]] * 4}},
    "family features": {"family": FAMILY | {"features": [[["1"], ["0", "1"]]] * 4}},
    "family not blind": {"family": FAMILY | {"features": [[["1"], ["0"]]] * 3 + [[["1"], ["1"]]]}},
    "family rows": {"family": FAMILY | {"rows": [{"coefficients": [], "bound": "1"}]}},
}


@pytest.mark.parametrize("name", MALFORMED)
def test_malformed_classes(name: str) -> None:
    document = by_hand(**MALFORMED[name])
    document["claims"].pop()
    with pytest.raises(checker.FormatError, match=r"subject\.class"):
        checker.check(raw(document))


def test_metric() -> None:
    weights = {(0, a): ["1", "1"] for a in range(3)}
    document = make(weights, ["1", "0"])
    far = [["0", "1", "{d}"], ["1", "0", "1"], ["{d}", "1", "0"]]
    for d, true in [("2", True), ("2000000001/1000000000", False), ("1/2", True), ("0", False)]:
        metric = [[e.replace("{d}", d) for e in row] for row in far]
        document["subject"]["class"] = by_hand(blind=False, lipschitz="1", metric=metric)["subject"]["class"]
        if true:
            assert false_statements(document) == []
        else:
            with pytest.raises(checker.FormatError, match="metric"):
                checker.check(raw(document))


@pytest.mark.parametrize(
    "evidence",
    [
        {"pairs": [], "theta": []},
        {"pairs": [], "multipliers": []},
        {"multipliers": ["1"]},
        {},
        {"pairs": [{"higher": 0, "lower": 1, "multipliers": []}]},
        entries((0, 1, 0, []), (0, 0, 1, [])),
        entries((0, 0, 1, []), (0, 0, 1, [])),
        entries((0, 0, 1, [[0, "0"]])),
        entries((0, 0, 1, [[0, "-1"]])),
        entries((0, 0, 1, [[0, "inf"]])),
        entries((0, 0, 1, [[-1, "1"]])),
        entries((0, 0, 1, [[True, "1"]])),
        entries((0, 0, 1, [["0", "1"]])),
        entries((0, 0, 1, [[0, 1]])),
        entries((0, 0, 1, [[1, "1"], [0, "1"]])),
        entries((0, 0, 1, [[1, "1"], [1, "1"]])),
        entries((0, 0, 1, [[1]])),
        entries((None, 0, 1, [])),
        entries((-1, 0, 1, [])),
        entries((0, 0, -1, [])),
    ],
)
def test_malformed_evidence(evidence: Any) -> None:
    for value in ("3", "inf"):
        with pytest.raises(checker.FormatError, match="evidence"):
            checker.check(raw(by_hand(value, by="lp-dual", evidence=evidence)))
    for wrong in ({"multipliers": ["-1"]}, {"multipliers": ["inf"]}, {"pairs": []}, {"multipliers": ["1"], "theta": ["1"]}):
        with pytest.raises(checker.FormatError, match="evidence"):
            checker.check(raw(by_hand(evidence=wrong)))


def test_malformed_theta() -> None:
    for evidence in ({"pairs": []}, {"pairs": [], "theta": []}, {"pairs": [], "theta": ["1", "1"]}, {"pairs": [], "theta": [1]}):
        with pytest.raises(checker.FormatError, match="theta"):
            checker.check(raw(by_hand("4", by="lp-dual", evidence=evidence, family=FAMILY)))


def test_constraints_that_do_not_exist() -> None:
    for number, true in [(0, True), (1, True), (2, False), (10**17, False)]:
        document = by_hand(by="lp-dual", evidence=entries((0, 0, 1, [[number, "1/1000000"]]), (0, 1, 0, [])))
        assert ("there is no constraint" in claim_fault(document)) != true


def test_policies_have_no_class() -> None:
    document = by_hand()
    document["subject"] |= {"kind": "policy", "population": "equal", "privacy": {}, "declared": {}}
    with pytest.raises(checker.FormatError, match="class"):
        checker.check(raw(document))
    assert list(SCHEMA.iter_errors(document))


# Speed


def test_speed_of_t3() -> None:
    pick = random.Random(5)
    weights = {(x, a): [str(pick.randint(1, 99)) for _ in range(20)] for x in range(100) for a in range(30)}
    columns = {"decision": "D", "group": ["G"], "context": ["C"]}
    decisions, groups, contexts = [f"u{u}" for u in range(20)], [[f"a{a}"] for a in range(30)], [[f"x{x}"] for x in range(100)]
    head = {"format": "fairaudit-table/1", "kind": "counts", "columns": columns, "population": "counts", "decisions": decisions}
    head |= {"groups": groups, "contexts": contexts, "utility": ["1"] * 20}
    rows = [{"context": x, "group": a, "weights": w} for (x, a), w in weights.items()]
    table = checker.rows.read_table((f"line {i}", value, None) for i, value in enumerate([head, *rows]))
    members = by_hand(tau="1/10")["subject"]["class"]
    program = checker.program.Program(checker.utility_class.read_class(members, "class"), table)
    laws = [[cell.law for cell in cells] for cells in table.by_context()]
    ks = sorted({F(p[0][u] * q[1], p[1] * q[0][u]) for law in laws[:40] for p, q in permutations(law[:9], 2) for u in range(20)})
    ks = pick.sample(ks, 30_000)
    start = time.perf_counter()
    assert checker.worst_case._fault_of_closed_form((15, 2), ks, program) == ""
    fault = checker.worst_case._fault_of_closed_form((2, 1), ks, program)
    assert "no multiplier proves" in fault
    assert time.perf_counter() - start < 30


def test_speed_of_lp_dual() -> None:
    pick = random.Random(6)
    weights = {(0, a): [str(pick.randint(1, 9)) for _ in range(50)] for a in range(20)}
    rows: dict[str, Any] = {
        "quantity": "local",
        "gamma": "1",
        "m": "1/2",
        "tau": "3/5",
        "order": [[f"u{u}", f"u{u + 1}"] for u in range(49)],
    }
    document = make(weights, ["1"] * 50)
    document["subject"]["class"] = by_hand(**rows)["subject"]["class"]
    multipliers = [[i, "1/1000"] for i in range(0, 69, 2)]
    evidence = entries(*((0, a, b, multipliers) for a, b in permutations(range(20), 2)))
    document["claims"].append(by_hand("8", by="lp-dual", evidence=evidence)["claims"][-1])
    data = json.dumps(document).encode()
    start = time.perf_counter()
    findings = checker.check(data).findings
    assert time.perf_counter() - start < 5
    assert all(f.true for f in findings)
