"""Policies behind filters and their certificates, by dense loops over plain fractions."""

import hashlib
import random
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from itertools import chain, permutations, product
from math import prod
from typing import Any

from assumptions import complete
from jsonschema import Draft202012Validator
from plain_certificates import INF, lines_of, make, ratio, text

from fairaudit.certificates.certificate import schema

LAW = "this law"
POLICIES = "any policy behind this filter"
FLOORED = "any policy behind this filter that keeps the declared floor"
GROUP_FILTERS = "this policy and context filter, any group filter at most this epsilon that releases the same values"
CONTEXT_FILTERS = "this policy and group filter, any context filter that releases these contexts"
SCHEMA = Draft202012Validator(schema())
TINY = Fraction(1, 10**9)
Matrix = list[list[Fraction]]


def randomized(k: int, keep: Fraction) -> Matrix:
    return [[keep if i == j else (1 - keep) / (k - 1) for j in range(k)] for i in range(k)]


def random_matrix(pick: random.Random, n: int, m: int) -> Matrix:
    kind = pick.choice(["response", "response", "any", "any", "zeros", "same", "mixture"])
    if kind == "response" and n == m > 1:
        return randomized(n, Fraction(pick.randint(0, 6), 6))
    if kind == "mixture" and n == m:  # keep the truth, more or less often, or else draw from one distribution
        other = random_matrix(pick, 1, m)[0]
        keep = [Fraction(pick.randint(0, 3), 3) for _ in range(n)]
        return [[(1 - keep[i]) * other[j] + keep[i] * (i == j) for j in range(m)] for i in range(n)]
    rows = [[pick.choice([0, 1, 2] if kind == "zeros" else [1, 2, 3]) for _ in range(m)] for _ in range(n)]
    for row in rows:
        row[pick.randrange(m)] += 1
    if kind == "same":
        rows = [rows[0]] * n
    return [[Fraction(w, sum(row)) for w in row] for row in rows]


class Filter:
    """Factors of labels and matrices; ``dense`` is the matrix of their product."""

    def __init__(self, factors: list[tuple[list[list[str]], list[list[str]], Matrix]]) -> None:
        self.factors = factors
        self.inputs = [[*chain(*labels)] for labels in product(*(f[0] for f in factors))]
        self.outputs = [[*chain(*labels)] for labels in product(*(f[1] for f in factors))]
        self.dense = [[prod(row) for row in product(*rows)] for rows in product(*(f[2] for f in factors))]
        self.reachable = [j for j in range(len(self.outputs)) if any(row[j] for row in self.dense)]

    def text(self) -> list[dict[str, Any]]:
        return [{"inputs": i, "outputs": o, "rows": [[str(p) for p in row] for row in m]} for i, o, m in self.factors]

    def privacy(self) -> dict[str, Any]:
        return {"exp_epsilon": text(exp_epsilon(self.dense)), "attributes": [text(exp_epsilon(m)) for _, _, m in self.factors]}


def exp_epsilon(matrix: Matrix) -> Any:
    ratios = [ratio(p, q) for one, other in permutations(matrix, 2) for p, q in zip(one, other, strict=True) if p or q]
    return max(ratios, default=Fraction(1))


def random_filter(pick: random.Random, name: str, most: int) -> tuple[Filter, int]:
    factors, columns, size = [], 0, 1
    for f in range(pick.choice([1, 1, 2, 3])):
        n, m, width = pick.choice([1, 2, 2, 3]), pick.choice([1, 2, 2, 3]), pick.choice([1, 1, 2])
        if size * n > most:
            n = 1
        size *= n
        m = n if pick.random() < 0.6 else m
        changed = "" if pick.random() < 0.7 else "~"
        labels = [[f"{name}{f}{i}", *["w"] * (width - 1)] for i in range(max(n, m))]
        factors.append((labels[:n], [[label[0] + changed, *label[1:]] for label in labels[:m]], random_matrix(pick, n, m)))
        columns += width
    return Filter(factors), columns


class Policy:
    """A random policy behind random filters, and what follows from it."""

    def __init__(self, seed: int) -> None:
        pick = self.pick = random.Random(seed)
        self.group, group_columns = random_filter(pick, "a", 6)
        while len(self.group.inputs) < 2:
            self.group, group_columns = random_filter(pick, "a", 6)
        self.context: Filter | None = None
        if pick.random() < 0.6:
            self.context, context_columns = random_filter(pick, "x", 3)
            self.true_x, released_x = self.context.inputs, self.context.outputs
        else:
            context_columns = pick.choice([0, 1, 2])
            count = pick.randint(1, 3) if context_columns else 1
            self.true_x = released_x = [[f"x{i}"] * context_columns for i in range(count)]
        self.true_a = self.group.inputs
        self.X = (
            self.context.dense if self.context else [[Fraction(i == j) for j in range(len(released_x))] for i in range(len(released_x))]
        )
        self.A = self.group.dense
        self.reach_x = self.context.reachable if self.context else list(range(len(released_x)))
        self.reach_a = self.group.reachable
        self.released_x, self.released_a = released_x, self.group.outputs
        self.n = pick.randint(1, 3)
        # The labels under which rows stand, in any order, some of them released by no filter.
        extra = [[], [*self.true_x]][pick.random() < 0.5] if self.context else []
        contexts = [released_x[j] for j in self.reach_x] if pick.random() < 0.5 else [*released_x]
        self.contexts = contexts + [x for x in extra if x not in contexts]
        groups = [self.released_a[j] for j in self.reach_a] if pick.random() < 0.5 else [*self.released_a]
        self.groups = groups + [a for a in self.true_a if a not in groups and pick.random() < 0.8]
        if self.context:  # without a filter the order of contexts is that of the header
            pick.shuffle(self.contexts)
        pick.shuffle(self.groups)
        must = {(self.contexts.index(released_x[i]), self.groups.index(self.released_a[j])) for i in self.reach_x for j in self.reach_a}
        self.must = must
        self.T: dict[tuple[int, int], list[Fraction]] = {}
        sure = pick.random() < 0.2
        for i, j in product(range(len(self.contexts)), range(len(self.groups))):
            if (i, j) in must or pick.random() < 0.7:
                w = [pick.choice([0, 1, 1, 2, 3]) for _ in range(self.n)]
                w[pick.randrange(self.n)] += 1
                self.T[i, j] = [Fraction(v, sum(w)) for v in w]
                if sure:
                    at = pick.randrange(self.n)
                    self.T[i, j] = [Fraction(u == at) for u in range(self.n)]
        self.utility(pick)
        self.masses(pick)
        self.columns = {
            "decision": "D",
            "group": [f"G{i}" for i in range(group_columns)],
            "context": [f"C{i}" for i in range(context_columns)],
        }
        self.declare(pick)
        self.releases = random.Random(f"releases {seed}").choice([1, 1, 1, 1, 2, 2, 3])

    def cells(self) -> list[tuple[int, int]]:
        return [*product(range(len(self.true_x)), range(len(self.true_a)))]

    def utility(self, pick: random.Random) -> None:
        values = pick.choice([["0", "1", "2"], ["1", "3/2", "2"], ["0", "1"], ["1"]])
        kind = pick.choice(["u", "u", "ux", "uxa"])
        of_u = [pick.choice(values) for _ in range(self.n)]
        of_x = [[pick.choice(values) for _ in range(self.n)] for _ in self.true_x]
        self.given: Any = of_u if kind == "u" else {}
        self.g: dict[tuple[int, int], list[Fraction]] = {}
        for x, a in self.cells():
            entry = of_u if kind == "u" else of_x[x] if kind == "ux" else [pick.choice(values) for _ in range(self.n)]
            self.g[x, a] = [Fraction(e) for e in entry]
            if kind != "u":
                self.given[x, a] = entry

    def masses(self, pick: random.Random) -> None:
        self.mass: dict[tuple[int, int], Fraction] | None = None
        if pick.random() < 0.6:
            zeros = pick.choice([[1, 2], [0, 1, 2]])
            of_x, of_a = [pick.choice(zeros) for _ in self.true_x], [pick.choice(zeros) for _ in self.true_a]
            free = pick.random() < 0.5
            m = {(x, a): pick.choice(zeros) if free else of_x[x] * of_a[a] for x, a in self.cells()}
            if not any(m.values()):
                m[0, 0] = 1
            self.mass = {cell: Fraction(v, sum(m.values())) for cell, v in m.items()}

    def induced(self) -> dict[tuple[int, int], list[Fraction]]:
        return {
            (x, a): [
                sum((self.X[x][i] * self.A[a][j] * self.at(i, j)[u] for i in self.reach_x for j in self.reach_a), Fraction(0))
                for u in range(self.n)
            ]
            for x, a in self.cells()
        }

    def at(self, i: int, j: int) -> list[Fraction]:
        return self.T[self.contexts.index(self.released_x[i]), self.groups.index(self.released_a[j])]

    def value(self, i: int, j: int, x: int, a: int) -> Fraction:
        return sum((p * g for p, g in zip(self.at(i, j), self.g[x, a], strict=True)), Fraction(0))

    def declare(self, pick: random.Random) -> None:
        self.P = self.induced()
        given = [e for entries in self.g.values() for e in entries]
        self.tau = min(self.mean(x, a) for x, a in self.cells())
        spread = max(
            abs(p - q) for x, a in self.cells() for b in range(len(self.true_a)) for p, q in zip(self.g[x, a], self.g[x, b], strict=True)
        )
        self.own = {"gamma": max(given), "m": min(given), "tau": self.tau, "lipschitz": spread}
        self.declared: dict[str, Fraction] = {}
        self.declared_in: dict[int, dict[str, Fraction]] = {}
        for key, up in (("gamma", True), ("lipschitz", True), ("m", False), ("tau", False)):
            if pick.random() < (0.5 if key == "tau" else 0.2):
                change = pick.choice([Fraction(0), Fraction(1, 3)]) * (1 if up else -self.own[key])
                self.declared[key] = self.own[key] + change
        used = self.own | self.declared
        self.gamma, self.m, self.L = used["gamma"], used["m"], used["lipschitz"]

    def mean(self, x: int, a: int) -> Fraction:
        return sum((p * g for p, g in zip(self.P[x, a], self.g[x, a], strict=True)), Fraction(0))

    # What the claims are about

    def pairs(self) -> list[tuple[list[Fraction], list[Fraction]]]:
        return [*permutations(self.A, 2)]

    def raw_ratio(self) -> Any:
        def h(x: int, j: int) -> Fraction:
            return sum((self.X[x][i] * self.value(i, j, x, 0) for i in self.reach_x), Fraction(0))

        return max(ratio(h(x, j), h(x, k)) for x in range(len(self.true_x)) for j in self.reach_a for k in self.reach_a)

    def policy_floor(self) -> Fraction:
        places = [(i, x) for x in range(len(self.true_x)) for i in self.reach_x if self.X[x][i]]
        return min(self.value(i, j, x, a) for i, x in places for j in self.reach_a for a in range(len(self.true_a)))

    def context_ratio(self) -> Any:
        def h(i: int, a: int) -> Fraction:
            return sum((self.A[a][j] * self.value(i, j, 0, 0) for j in self.reach_a), Fraction(0))

        groups = range(len(self.true_a))
        return max(ratio(h(i, a), h(i, b)) for i in self.reach_x for a, b in permutations(groups, 2))

    def weight(self, x: int, a: int) -> Fraction:
        return self.mass[x, a] if self.mass is not None else Fraction(1)

    def of_group(self, a: int) -> Fraction:
        return sum((self.weight(x, a) for x in range(len(self.true_x))), Fraction(0))

    def composition(self) -> Any:
        def share(i: int, a: int) -> Fraction:
            return sum((self.X[x][i] * self.weight(x, a) for x in range(len(self.true_x))), Fraction(0)) / self.of_group(a)

        groups = [a for a in range(len(self.true_a)) if self.of_group(a)]
        pairs = [(share(i, a), share(i, b)) for i in range(len(self.released_x)) for a, b in permutations(groups, 2)]
        return max((ratio(p, q) for p, q in pairs if p or q), default=Fraction(1))

    def independent(self) -> bool:
        whole = sum(self.weight(x, a) for x, a in self.cells())
        return all(
            self.weight(x, a) * whole == sum(self.weight(x, b) for b in range(len(self.true_a))) * self.of_group(a) for x, a in self.cells()
        )

    def multipliers(self) -> list[Fraction]:
        ratios = {ratio(p, q) for one, other in self.pairs() for p, q in zip(one, other, strict=True) if p or q}
        finite = sorted(k for k in ratios if k != INF)
        return [Fraction(0), Fraction(1), Fraction(1, 2), *finite]


def hockey_stick(pair: tuple[list[Fraction], list[Fraction]], k: Fraction) -> Fraction:
    return sum((max(Fraction(0), p - k * q) for p, q in zip(*pair, strict=True)), Fraction(0))


@cache
def bounds(p: Policy) -> list[tuple[dict[str, Any], Any]]:
    """List every claim that a policy certificate adds, with the least true value; None if no value is."""
    e = exp_epsilon(p.A)
    finite, free, by_decision = e != INF, p.L == 0, isinstance(p.given, list)
    comparable = sum(p.of_group(a) > 0 for a in range(len(p.true_a))) > 1
    ks = p.multipliers()
    one = p.releases == 1  # the other theorems speak of policies that see one release
    found: list[tuple[dict[str, Any], Any]] = []

    def add(by: str, scope: str, holds: bool, least: Callable[[], Any], quantity: str = "local_ratio", **evidence: Any) -> None:
        claim = {"quantity": quantity, "relation": "<=", "by": by, "scope": scope, "assumptions": [], "evidence": evidence}
        found.append((claim, least() if holds and (one or scope not in (POLICIES, FLOORED)) else None))

    def covered(bound: Callable[[Fraction, Fraction], Fraction], pairs: Any = None) -> Callable[[], Fraction]:
        return lambda: max(min(bound(k, hockey_stick(pair, k)) for k in ks) for pair in (pairs or p.pairs()))

    given = {"multipliers": [str(k) for k in ks]}
    add("T2", POLICIES, free and finite, lambda: e)
    floors = [(LAW, p.tau), (FLOORED, p.declared.get("tau"))]
    for scope, floor in floors:
        ok, tau = bool(floor), floor or Fraction(1)
        add("T1-paper", scope, ok and finite, lambda tau=tau: e * (1 + p.L / tau))
        add("T1", scope, ok, covered(lambda k, h, tau=tau: k + (p.L + h * p.gamma) / tau), **given)
        add("T3", scope, ok and tau <= p.gamma - p.L, covered(lambda k, h, tau=tau: k + (p.L + (p.gamma - p.L) * h) / tau), **given)
        add("floor", scope, ok, lambda tau=tau: p.gamma / tau)
    lowest = p.policy_floor()
    pair = ([Fraction(1), Fraction(0)], [Fraction(0), Fraction(1)])
    if e != INF:
        pair = ([e / (1 + e), 1 / (1 + e)], [1 / (1 + e), e / (1 + e)])
    add("T3", GROUP_FILTERS, free and lowest > 0, covered(lambda k, h: k + p.gamma * h / lowest, [pair]), **given)
    wide = p.gamma - p.m
    add("T4", POLICIES, free and p.m > 0, covered(lambda k, h: k + max(Fraction(0), wide * h - (k - 1) * p.m) / p.m), **given)
    raw_ratio = p.raw_ratio() if free else Fraction(1)

    def contraction() -> Any:
        if raw_ratio == INF:
            return e
        return raw_ratio if e == INF else (1 + raw_ratio * e) / (raw_ratio + e)

    add("T12", GROUP_FILTERS, free, contraction, raw_ratio=text(raw_ratio))
    add("T8", CONTEXT_FILTERS, by_decision and p.context is not None, lambda: p.context_ratio())
    add("T5", POLICIES, free and finite and comparable and p.independent(), lambda: e, "global_ratio")
    C = p.composition()
    add("T5-decision", POLICIES, by_decision and finite and comparable, lambda: e * C, "global_ratio", composition=text(C))
    return found


def renamed(value: Any, p: Policy) -> Any:
    """Put the names of the policy's columns and labels where make() has put its own."""
    if isinstance(value, dict):
        if value.keys() == {"G"}:
            return dict(zip(p.columns["group"], p.true_a[int(value["G"][1:])], strict=True))
        if value.keys() == {"C"}:
            return dict(zip(p.columns["context"], p.true_x[int(value["C"][1:])], strict=True))
        return {key: renamed(item, p) for key, item in value.items()}
    if isinstance(value, list):
        if len(value) == 1 and isinstance(value[0], str) and value[0][:1] in ("a", "x"):
            return (p.true_a if value[0][0] == "a" else p.true_x)[int(value[0][1:])]
        return [renamed(item, p) for item in value]
    return value


def figures(p: Policy, law: dict[tuple[int, int], list[Fraction]], limits: Any = ()) -> dict[str, Any]:
    masses = {cell: str(m) for cell, m in p.mass.items()} if p.mass is not None else None
    weights = {cell: [str(v) for v in entries] for cell, entries in law.items()}
    population = "equal" if p.mass is None else "weights"
    shape = (len(p.true_x), len(p.true_a))
    certificate: dict[str, Any] = renamed(make(weights, p.given, population=population, masses=masses, shape=shape, limits=limits), p)
    return certificate


def digested(certificate: dict[str, Any]) -> dict[str, Any]:
    """Compute the digest again, also where claims have it."""
    table = certificate["subject"]["table"]
    old, table["sha256"] = table["sha256"], hashlib.sha256(b"".join(lines_of(table))).hexdigest()
    for claim in certificate["claims"]:
        if claim["evidence"].get("table") == old:
            claim["evidence"]["table"] = table["sha256"]
    return certificate


def write(p: Policy) -> dict[str, Any]:
    limits = (("local", "ratio", "3"), ("global", "log", "1/2"))
    certificate = figures(p, p.P, limits)
    at = [(p.contexts.index(x) if x in p.contexts else -1, p.groups.index(a) if a in p.groups else -1) for x in p.true_x for a in p.true_a]
    certificate["metrics"]["unfiltered"] = None
    if all(place in p.T for place in at):
        plain = figures(p, {cell: p.T[place] for cell, place in zip(p.cells(), at, strict=True)})["metrics"]
        certificate["metrics"]["unfiltered"] = {name: plain[name] for name in ("local", "global")}
    header: dict[str, Any] = {
        "format": "fairaudit-table/1",
        "kind": "policy",
        "columns": p.columns,
        "population": "equal" if p.mass is None else "weights",
        "decisions": [f"u{i}" for i in range(p.n)],
        "groups": p.groups,
        "contexts": p.contexts,
        "utility": p.given if isinstance(p.given, list) else None,
        "filters": {"group": p.group.text(), "context": p.context.text() if p.context else None}
        | ({"releases": p.releases} if p.releases > 1 else {}),
    }
    rows: list[dict[str, Any]] = [{"context": i, "group": j, "weights": [str(v) for v in p.T[i, j]]} for i, j in sorted(p.T)]
    if p.mass is not None or not isinstance(p.given, list):
        for x, a in p.cells():
            row: dict[str, Any] = {"true_context": x, "true_group": a}
            row |= {"mass": str(p.mass[x, a])} if p.mass is not None else {}
            rows.append(row | ({} if isinstance(p.given, list) else {"utility": p.given[x, a]}))
    subject = certificate["subject"]
    subject |= {"kind": "policy", "columns": p.columns}
    subject["table"] |= {"cells": len(p.T) * p.n, "header": header, "rows": rows}
    subject["privacy"] = {"group": p.group.privacy(), "context": p.context.privacy() if p.context else None}
    in_contexts = [{"context": p.true_x[x]} | {key: str(v) for key, v in own.items()} for x, own in p.declared_in.items()]
    subject["declared"] = {key: str(value) for key, value in p.declared.items()} | ({"by_context": in_contexts} if in_contexts else {})
    certificate["claims"] += [claim | {"value": text(least)} for claim, least in bounds(p) if least is not None]
    return digested(complete(certificate))


SEEDS = range(400)


def stated(
    group: Filter,
    rows: list[list[list[Any]]],
    given: Any,
    *,
    context: Filter | None = None,
    contexts: Any = (["A"],),
    mass: Any = None,
    releases: int = 1,
) -> Policy:
    """A policy written out: its laws by released context and group, g(u) or g by true cell, and perhaps the mass of each true cell."""
    p = Policy.__new__(Policy)
    p.group, p.context, p.releases = group, context, releases
    p.true_x, p.released_x = (context.inputs, context.outputs) if context else ([*contexts], [*contexts])
    p.contexts, p.true_a, p.released_a, p.groups = p.released_x, group.inputs, group.outputs, group.outputs
    p.A, p.X = group.dense, context.dense if context else [[Fraction(i == j) for j in range(len(contexts))] for i in range(len(contexts))]
    p.reach_x, p.reach_a = context.reachable if context else [*range(len(contexts))], group.reachable
    p.T = {(i, j): [Fraction(v) for v in law] for i, of_groups in enumerate(rows) for j, law in enumerate(of_groups)}
    p.n = len(rows[0][0])
    p.given = given
    p.g = {cell: [Fraction(v) for v in (given if isinstance(given, list) else given[cell])] for cell in p.cells()}
    p.mass = None if mass is None else {cell: Fraction(v) for cell, v in mass.items()}
    p.columns = {"decision": "D", "group": ["G"], "context": ["X"]}
    p.declare(random.Random(0))
    p.declared, p.declared_in = {}, {}
    return p


def coin(keep: Any, first: str = "f", second: str = "m") -> Filter:
    """Two groups, each released as it is with some probability."""
    return Filter([([[first], [second]], [[first], [second]], randomized(2, Fraction(keep)))])


def by_hand() -> dict[str, Any]:
    """Two groups, released as they are with probability 2/3; they are hired with probability 1/2 and 1/4."""
    p = stated(coin("2/3"), [[["1/2", "1/2"], ["1/4", "3/4"]]], ["1", "0"])
    p.declared = {"tau": Fraction(1, 4)}
    return write(p)
