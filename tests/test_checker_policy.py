"""The checker on certificates of policies behind filters, against dense loops over plain fractions."""

import copy
import hashlib
import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from itertools import chain, permutations, product
from math import prod
from typing import Any

import pytest
from assumptions import complete
from jsonschema import Draft202012Validator
from test_checker_unit import INF, canonical, checker, edited, false_statements, lines_of, make, ratio, raw, text

from fairaudit.certificates.certificate import schema

LAW = "this law"
POLICIES = "any policy behind this filter"
FLOORED = "any policy behind this filter that keeps the declared floor"
GROUP_FILTERS = "this policy and context filter, any group filter at most this epsilon that releases the same values"
CONTEXT_FILTERS = "this policy and group filter, any context filter that releases these contexts"
SCHEMA = Draft202012Validator(schema())
TINY = Fraction(1, 10**9)
Matrix = list[list[Fraction]]


# A tiny writer: everything by definition, dense, over all pairs


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
    found: list[tuple[dict[str, Any], Any]] = []

    def add(by: str, scope: str, holds: bool, least: Callable[[], Any], quantity: str = "local_ratio", **evidence: Any) -> None:
        claim = {"quantity": quantity, "relation": "<=", "by": by, "scope": scope, "assumptions": [], "evidence": evidence}
        found.append((claim, least() if holds else None))

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
        "filters": {"group": p.group.text(), "context": p.context.text() if p.context else None},
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
    subject["declared"] = {key: str(value) for key, value in p.declared.items()}
    certificate["claims"] += [claim | {"value": text(least)} for claim, least in bounds(p) if least is not None]
    return digested(complete(certificate))


SEEDS = range(400)
BLOCKS = 8


def blocks(index: int) -> range:
    return range(index * len(SEEDS) // BLOCKS, (index + 1) * len(SEEDS) // BLOCKS)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_random_certificates(block: int) -> None:
    """True ones are accepted; with a claim that is false, or a value that is a little too small, they are not."""
    for seed in blocks(block):
        p = Policy(seed)
        certificate = write(p)
        assert false_statements(certificate) == [], seed
        assert seed % 4 or [error.message for error in SCHEMA.iter_errors(certificate)] == [], seed
        lines = lines_of(certificate["subject"]["table"])
        apart = copy.deepcopy(certificate)
        apart["subject"]["table"] = {key: apart["subject"]["table"][key] for key in ("sha256", "cells")}
        assert checker.check(raw(apart), lines).ok
        # Each claim with several values: infinity, the least true one, a little more, and a little less.
        for number in range(4):
            claims, true = [], []
            for claim, least in bounds(p):
                finite = Fraction(0) if least in (None, INF) else least
                values = ["inf", text(least or INF), str(finite + TINY), str(finite - TINY)]
                claims.append(claim | {"value": values[number]})
                true.append(least is not None and (values[number] == "inf" or (least != INF and number < 3)))
            certificate["claims"] = claims
            found = [f.true for f in checker.check(raw(complete(certificate))).findings if f.statement.startswith("claims[")]
            assert found == true, (seed, claims, found)


def test_the_random_certificates_are_of_many_kinds() -> None:
    seen: dict[Any, list[int]] = {}
    for seed in SEEDS:
        p = Policy(seed)
        for claim, least in bounds(p):
            counts = seen.setdefault((claim["by"], claim["scope"]), [0, 0, 0])
            counts[(least is None) + 2 * (least == INF)] += 1
    assert len(seen) == 15
    for key, (true, none, infinite) in seen.items():
        assert true >= 40 and none + infinite >= 40, key


@pytest.mark.parametrize("block", range(BLOCKS))
def test_claims_hold_for_what_they_speak_of(block: int) -> None:
    """Search for counterexamples: other policies behind the filter, other group filters, other context filters."""
    for seed in blocks(block)[::3]:
        p = Policy(seed)
        claims = [(claim, least) for claim, least in bounds(p) if least not in (None, INF)]
        e = exp_epsilon(p.A)
        for trial in range(3):
            pick = random.Random(seed * 100 + trial)
            others = {scope: copy.deepcopy(p) for scope in (POLICIES, GROUP_FILTERS, CONTEXT_FILTERS)}
            for i, j in p.T:
                w = [pick.choice([0, 0, 1, 5]) for _ in range(p.n)]
                w[pick.randrange(p.n)] += 1
                others[POLICIES].T[i, j] = [Fraction(v, sum(w)) for v in w]
            # Mixing with one row lowers epsilon; so does taking a row of the product that has it for the pair of lies.
            other = random_matrix(pick, 1, len(p.reach_a))[0]
            mixed = [[Fraction(0)] * len(p.released_a) for _ in p.true_a]
            for a, row in enumerate(mixed):
                own = random_matrix(pick, 1, len(p.reach_a))[0]
                share = Fraction(pick.randint(0, 2), 2)
                for j, v, w in zip(p.reach_a, own, other, strict=True):
                    row[j] = share * v + (1 - share) * w if trial else share * p.A[a][j] + (1 - share) * w
            if exp_epsilon(mixed) <= e:
                others[GROUP_FILTERS].A = mixed
            others[CONTEXT_FILTERS].X = [[Fraction(0)] * len(p.released_x) for _ in p.true_x]
            for row in others[CONTEXT_FILTERS].X:
                for i, v in zip(p.reach_x, random_matrix(pick, 1, len(p.reach_x))[0], strict=True):
                    row[i] = v
            others[FLOORED] = others[POLICIES]
            others[LAW] = p
            for scope, q in others.items():
                q.P = q.induced()
                metrics = figures(q, q.P)["metrics"]
                keeps = min(q.mean(x, a) for x, a in q.cells()) >= p.declared.get("tau", Fraction(0))
                for claim, least in claims:
                    name = claim["quantity"].split("_")[0]
                    if claim["scope"] == scope and metrics[name] and (scope != FLOORED or keeps):
                        measured = metrics[name]["ratio"]
                        assert measured != "inf" and Fraction(measured) <= least, (seed, claim)


# One certificate by hand


def by_hand() -> dict[str, Any]:
    """Two groups, released as they are with probability 2/3; they are hired with probability 1/2 and 1/4."""
    p = Policy.__new__(Policy)
    p.group = Filter([([["f"], ["m"]], [["f"], ["m"]], randomized(2, Fraction(2, 3)))])
    p.context = None
    p.true_x = p.released_x = p.contexts = [["A"]]
    p.true_a = p.released_a = p.groups = [["f"], ["m"]]
    p.X, p.A, p.reach_x, p.reach_a = [[Fraction(1)]], p.group.dense, [0], [0, 1]
    p.n = 2
    p.T = {(0, 0): [Fraction(1, 2)] * 2, (0, 1): [Fraction(1, 4), Fraction(3, 4)]}
    p.given, p.g, p.mass = ["1", "0"], {(0, 0): [Fraction(1), Fraction(0)], (0, 1): [Fraction(1), Fraction(0)]}, None
    p.columns = {"decision": "D", "group": ["G"], "context": ["X"]}
    p.declare(random.Random(0))
    p.declared = {"tau": Fraction(1, 4)}
    return write(p)


@pytest.fixture
def good() -> dict[str, Any]:
    return by_hand()


def place_of(certificate: dict[str, Any], by: str, scope: str) -> str:
    [at] = [i for i, c in enumerate(certificate["claims"]) if (c["by"], c["scope"]) == (by, scope)]
    return f"claims.{at}"


def test_by_hand(good: dict[str, Any]) -> None:
    """The chances are 5/12 and 1/3, the ratio 5/4; unfiltered it is 2, and 2 and e^eps = 2 contract to 5/4."""
    assert false_statements(good) == []
    assert good["metrics"]["local"]["ratio"] == "5/4" and good["metrics"]["unfiltered"]["local"]["ratio"] == "2"
    values = {(c["by"], c["scope"]): c["value"] for c in good["claims"]}
    assert values["T12", GROUP_FILTERS] == "5/4" and values["T2", POLICIES] == "2" and values["floor", LAW] == "3"
    # k = 1 has H = 1/3 and gives 1 + (1/3) / (1/3); k = 1/2 has H = 1/2 and gives 1/2 + (1/2) / (1/3)
    assert values["T3", LAW] == "2" and values["T5-decision", POLICIES] == "2"
    assert values["T3", FLOORED] == "2" and values["floor", FLOORED] == "4"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("subject.privacy.group.exp_epsilon", "3"),
        ("subject.privacy.group.exp_epsilon", "inf"),
        ("subject.privacy.group.attributes", []),
        ("subject.privacy.group.attributes.0", "3"),
        ("subject.privacy.context", {"exp_epsilon": "1", "attributes": []}),
        ("subject.declared.tau", "2/5"),
        ("subject.declared", {"gamma": "1/2"}),
        ("subject.declared", {"m": "1/2"}),
        ("subject.declared", {"lipschitz": "1"}),
        ("subject.utility.tau", "1/4"),
        ("subject.table.cells", 2),
        ("metrics.unfiltered", None),
        ("metrics.unfiltered.local", None),
        ("metrics.unfiltered.local.ratio", "5/4"),
        ("metrics.unfiltered.global.witness.expectations", ["5/12", "1/3"]),
        ("metrics.local.ratio", "2"),
        ("subject.kind", "policy2"),
    ],
)
def test_false(good: dict[str, Any], path: str, value: Any) -> None:
    if value == "policy2":  # a certificate of the first kind about the table of a policy
        good["subject"] = {key: item for key, item in good["subject"].items() if key not in ("privacy", "declared")}
        good["subject"] |= {"kind": "probabilities"}
        lines = lines_of(good["subject"].pop("table"))
        good["subject"]["table"] = {"sha256": hashlib.sha256(b"".join(lines)).hexdigest(), "cells": 4}
        del good["metrics"]["unfiltered"]
        assert any(line.startswith("subject.kind") for line in false_statements(good, lines))
        return
    assert false_statements(edited(good, path, value)) != []


def test_false_claims(good: dict[str, Any]) -> None:
    scopes = (LAW, POLICIES, FLOORED, GROUP_FILTERS, CONTEXT_FILTERS, "", "every law")
    keys = {(c["quantity"], c["by"], c["scope"]) for c in good["claims"]}
    for i, claim in enumerate(good["claims"]):
        at = f"claims.{i}"
        for scope in scopes:
            if (claim["quantity"], claim["by"], scope) not in keys:
                lines = false_statements(edited(copy.deepcopy(good), f"{at}.scope", scope))
                assert len(lines) == 1 and ("unknown claim" in lines[0] or claim["by"] == "T8"), (claim, scope, lines)
        double = copy.deepcopy(good)
        double["claims"].append(claim)
        assert "occurs twice" in false_statements(double)[0]
        if claim["by"] not in ("T7", "T5-decision", "T12"):
            continue
        [evidence] = claim["evidence"]
        assert "the evidence is" in false_statements(edited(copy.deepcopy(good), f"{at}.evidence.{evidence}", "7/5"))[0]
    for by, bad in (("T3", ["3"]), ("T1", ["1/9"])):
        assert (
            "the multipliers prove no less"
            in false_statements(edited(copy.deepcopy(good), f"{place_of(good, by, LAW)}.evidence.multipliers", bad))[0]
        )


@pytest.mark.parametrize("by", ["T1-paper", "T1", "T3", "floor"])
def test_a_declared_floor_has_to_be_declared(good: dict[str, Any], by: str) -> None:
    place = place_of(good, by, FLOORED)
    del good["subject"]["declared"]["tau"]
    lines = false_statements(good)
    assert len(lines) == 4 and all("no floor is declared" in line for line in lines)
    good["subject"]["declared"]["tau"] = "0"
    assert sum("the floor is 0" in line for line in false_statements(good)) == 4
    good["claims"] = [good["claims"][int(place.split(".")[1])] | {"value": "inf"}]
    assert "the floor is 0" in false_statements(good)[0]


def test_declared_constants_are_used(good: dict[str, Any]) -> None:
    good["subject"]["declared"]["gamma"] = "3/2"
    assert sorted({line.split('"')[-4 if " for " in line else -2] for line in false_statements(good)}) >= ["T1", "T3", "floor"]
    good["subject"]["declared"] = {"lipschitz": "1/8", "tau": "1/4"}
    lines = "".join(false_statements(good))
    for by in ("T2", "T12", "T3", "T1", "T1-paper"):
        assert f'by "{by}"' in lines
    assert 'by "T5-decision"' not in lines and 'by "floor"' not in lines


def test_other_rows_of_the_filter(good: dict[str, Any]) -> None:
    factor = good["subject"]["table"]["header"]["filters"]["group"][0]
    for rows in ([["3/4", "1/4"], ["1/3", "2/3"]], [["1", "0"], ["0", "1"]], [["1/3", "2/3"], ["2/3", "1/3"]]):
        factor["rows"] = rows
        assert false_statements(digested(good)) != []
    factor["rows"] = [["2/3", "1/3"], ["1/3", "2/3"]]
    assert false_statements(digested(good)) == []


def test_missing_rows() -> None:
    accepted = 0
    for seed in range(80):
        p = Policy(seed)
        certificate = write(p)
        table = certificate["subject"]["table"]
        for at in range(len(p.T)):
            fewer = copy.deepcopy(certificate)
            row = fewer["subject"]["table"]["rows"].pop(at)
            fewer["subject"]["table"]["cells"] -= p.n
            if (row["context"], row["group"]) in p.must:
                with pytest.raises(checker.FormatError, match="lacks a row"):
                    checker.check(raw(digested(fewer)))
            else:
                lines = [line for line in false_statements(digested(fewer)) if not line.startswith("metrics.unfiltered")]
                assert lines == [], seed
                accepted += 1
        assert table["cells"] == len(p.T) * p.n
    assert accepted > 50


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("subject.privacy", ...),
        ("subject.declared", ...),
        ("metrics.unfiltered", ...),
        ("subject.declared", None),
        ("subject.declared", {"epsilon": "1"}),
        ("subject.declared", {"tau": "-1"}),
        ("subject.declared", {"tau": "inf"}),
        ("subject.privacy.group", None),
        ("subject.privacy.group.attributes", "2"),
        ("subject.privacy.other", None),
        ("subject.population", "counts"),
        ("metrics.unfiltered.equalized_odds", None),
        ("metrics.unfiltered.global", ...),
        ("subject.table.header.filters", ...),
        ("subject.table.header.filters.context", ...),
        ("subject.table.header.filters.context", []),
        ("subject.table.header.filters.group", []),
        ("subject.table.header.filters.group", None),
        ("subject.table.header.filters.group.0.rows", [["1", "0"]]),
        ("subject.table.header.filters.group.0.rows.0", ["1"]),
        ("subject.table.header.filters.group.0.rows.0", ["2/3", "1/2"]),
        ("subject.table.header.filters.group.0.rows.0", ["4/3", "-1/3"]),
        ("subject.table.header.filters.group.0.inputs", [["f"], ["f"]]),
        ("subject.table.header.filters.group.0.inputs", [[], []]),
        ("subject.table.header.filters.group.0.inputs", []),
        ("subject.table.header.filters.group.0.inputs", [["f", "g"], ["m", "g"]]),
        ("subject.table.header.filters.group.0.outputs", [["f"], ["m", "g"]]),
        ("subject.table.header.filters.group.0.outputs", [["f"], ["d"]]),
        ("subject.table.header.groups", [["f"], ["d"]]),
        ("subject.table.rows.0.weights", ["1/2", "1/4"]),
        ("subject.table.rows.0.mass", "1"),
        ("subject.table.rows.1.group", 0),
        ("subject.table.rows.1.true_group", 0),
        ("subject.table.rows.2", {"true_context": 0, "true_group": 0}),
        ("claims.0.evidence", {}),
    ],
)
def test_malformed(good: dict[str, Any], path: str, value: Any) -> None:
    if path.endswith("rows.2"):
        good["subject"]["table"]["rows"].append(None)
    with pytest.raises(checker.FormatError):
        checker.check(raw(edited(good, path, value)))


@pytest.mark.parametrize("by", ["T1", "T2", "T3", "T12", "T5-decision", "floor"])
def test_malformed_evidence(good: dict[str, Any], by: str) -> None:
    claim = next(c for c in good["claims"] if c["by"] == by)
    wrong: list[Any] = [{"table": "0" * 64}, {"multipliers": []}, {"multipliers": ["-1"]}, {"multipliers": ["inf"]}, {"raw_ratio": "x"}]
    for evidence in [*wrong, {"composition": 1}, None, claim["evidence"] | {"more": "1"}]:
        claim_before = claim["evidence"]
        claim["evidence"] = evidence
        with pytest.raises(checker.FormatError):
            checker.check(raw(good))
        assert not SCHEMA.is_valid(good)
        claim["evidence"] = claim_before


def test_true_cells_are_listed_in_order() -> None:
    p = next(p for p in map(Policy, SEEDS) if p.mass is not None and not isinstance(p.given, list))
    certificate = write(p)
    rows = certificate["subject"]["table"]["rows"]
    first, count = len(p.T), len(rows)
    assert false_statements(certificate) == []
    spoiled = [
        rows[:-1],
        rows[:first],
        [*rows, rows[-1]],
        [*rows[:first], *rows[first:][::-1]],
        [*rows[first:], *rows[:first]],
        [*rows[: count - 1], rows[-1] | {"mass": "1/977"}],
        [*rows[: count - 1], rows[-1] | {"utility": [None] * p.n}],
        [*rows[: count - 1], {key: item for key, item in rows[-1].items() if key != "utility"}],
        [*rows[: count - 1], {key: item for key, item in rows[-1].items() if key != "mass"}],
        [*rows[: count - 1], rows[-1] | {"true_group": len(p.true_a)}],
    ]
    for other in spoiled:
        certificate["subject"]["table"]["rows"] = other
        with pytest.raises(checker.FormatError):
            checker.check(raw(digested(certificate)))


def test_keys_of_a_policy_are_unknown_elsewhere() -> None:
    certificate = make({(0, 0): ["1", "1"], (0, 1): ["1", "3"]}, ["1", "0"])
    assert false_statements(certificate) == []
    for path, value in (
        ("subject.privacy", {}),
        ("subject.declared", {}),
        ("metrics.unfiltered", None),
        ("subject.table.header.filters", {}),
    ):
        with pytest.raises(checker.FormatError):
            checker.check(raw(edited(copy.deepcopy(certificate), path, value)))
        assert not SCHEMA.is_valid(edited(copy.deepcopy(certificate), path, value))
    foreign = {"quantity": "local_ratio", "relation": "<=", "value": "inf", "assumptions": []}
    for by, scope, evidence in (("T2", POLICIES, {}), ("floor", LAW, {}), ("T3", LAW, {"multipliers": ["1"]})):
        certificate["claims"] = [foreign | {"by": by, "scope": scope, "evidence": evidence}]
        assert "unknown claim" in false_statements(certificate)[0]
        assert not SCHEMA.is_valid(certificate)


def test_every_value_of_a_wrong_type() -> None:
    """Whatever stands anywhere, the outcome is a report or a FormatError."""
    certificate = write(next(p for p in map(Policy, SEEDS) if p.context and p.mass and not isinstance(p.given, list) and len(p.T) < 7))

    def replace_all(value: Any, put: Callable[[Any], None]) -> None:
        junk: Any
        for junk in (None, True, 7, "", "1/3", "inf", [], {}, [[]], [None], {"a": []}):
            put(junk)
            try:
                checker.check(raw(certificate))
            except checker.FormatError as error:
                assert len(str(error)) < 1000
        put(value)
        for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
            replace_all(value[key], lambda item, key=key: value.__setitem__(key, item))  # type: ignore[misc]

    for key in ("subject", "metrics", "claims"):
        replace_all(certificate[key], lambda item, key=key: certificate.__setitem__(key, item))  # type: ignore[misc]
    assert checker.check(raw(certificate)).ok


def test_figures_that_are_a_little_different() -> None:
    """Each number in the subject and the metrics is changed; looser declared constants are true, nothing else is."""
    for seed in range(0, 60, 3):
        certificate = write(Policy(seed))
        places = list(numbers(certificate["subject"], ["subject"])) + list(numbers(certificate["metrics"], ["metrics"]))
        for path in places:
            parent: Any = certificate
            for step in path[:-1]:
                parent = parent[step]
            before = parent[path[-1]]
            change = TINY if path[-1] in ("gamma", "lipschitz") or "declared" not in path else -TINY
            parent[path[-1]] = "2" if before == "inf" else str(max(Fraction(0), Fraction(before) + change))
            if parent[path[-1]] != before:
                try:
                    lines = [line for line in false_statements(certificate) if not line.startswith("claims")]
                except checker.FormatError:
                    assert "table" in path  # probabilities that do not sum to 1
                else:
                    assert (lines == []) is ("declared" in path), (seed, path)
            parent[path[-1]] = before
        assert false_statements(certificate) == []


def numbers(value: Any, path: list[Any]) -> Iterator[list[Any]]:
    if isinstance(value, str) and (value == "inf" or value[:1].isdigit()) and len(value) < 60 and "log" not in path:
        yield path
    for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from numbers(value[key], [*path, key])


# Why the scopes say what they say


def test_a_filter_that_releases_other_values_breaks_the_contraction() -> None:
    """A policy that treats two values alike has R0 = 1; a filter that releases a third one shows that it is treated otherwise."""
    h = [Fraction(1), Fraction(1), Fraction(0)]
    other = [[Fraction(1, 2), Fraction(1, 4), Fraction(1, 4)], [Fraction(1, 4), Fraction(1, 4), Fraction(1, 2)]]
    assert exp_epsilon(other) == 2
    one, two = (sum(p * v for p, v in zip(row, h, strict=True)) for row in other)
    assert one / two > (1 + 1 * 2) / Fraction(1 + 2)


def test_a_policy_that_breaks_the_declared_floor_breaks_its_bound() -> None:
    """With the floor at its highest, k = 0 proves R <= 1; behind the same filter another policy has 2."""
    row = [Fraction(2, 3), Fraction(1, 3)]
    assert 0 + 1 * hockey_stick((row, row[::-1]), Fraction(0)) / 1 == 1
    assert row[0] / row[1] == 2


# Large filters


def test_factors_are_applied_one_by_one() -> None:
    """Eight factors of three values, 6561 groups, whose product would have 43 million entries."""
    factors = [([[f"{i}"] for i in range(3)], [[f"{i}"] for i in range(3)], randomized(3, Fraction(1, 2))) for _ in range(8)]
    groups = [list(labels) for labels in product("012", repeat=8)]
    header = {
        "format": "fairaudit-table/1",
        "kind": "policy",
        "columns": {"decision": "D", "group": [f"G{i}" for i in range(8)], "context": []},
        "population": "equal",
        "decisions": ["yes", "no"],
        "groups": groups,
        "contexts": [[]],
        "utility": ["1", "0"],
        "filters": {
            "group": [{"inputs": i, "outputs": o, "rows": [[str(p) for p in row] for row in m]} for i, o, m in factors],
            "context": None,
        },
    }
    rows = [
        {"context": 0, "group": j, "weights": [str(Fraction(g.count("0") + 1, 9)), str(Fraction(8 - g.count("0"), 9))]}
        for j, g in enumerate(groups)
    ]
    lines = [canonical(header), *map(canonical, rows)]
    table = checker.rows.read_table(checker.rows.lines_of_file(lines))
    # Released zeros: one half of those that are there, a quarter of the others.
    for cell, g in zip(table.cells, groups, strict=True):
        zeros = g.count("0")
        assert Fraction(*cell.expectation) == (1 + Fraction(zeros, 2) + Fraction(8 - zeros, 4)) / 9
    assert table.policy.group.exp_epsilon == (2**8, 1)
    differing, unit = table.policy.group.pairs
    assert len(differing) == 8 and unit == 4**8


@pytest.mark.parametrize("name", ["inputs", "outputs"])
def test_more_true_cells_than_fit(good: dict[str, Any], name: str) -> None:
    """A short header can speak of 10^40 groups, true or released; it is refused without listing them."""
    labels = {"inputs": [["0"], ["1"]], "outputs": [["0"], ["1"]]} | {name: [[f"{i}"] for i in range(100)]}
    rows = [[str(Fraction(1, len(labels["outputs"])))] * len(labels["outputs"])] * len(labels["inputs"])
    table = good["subject"]["table"]
    header = copy.deepcopy(table.pop("header"))
    del table["rows"]
    header["columns"]["group"] = [f"G{i}" for i in range(20)]
    header["groups"] = [["0"] * 20, ["1"] * 20]
    header["filters"]["group"] = [labels | {"rows": rows}] * 20
    with pytest.raises(checker.TooMuch, match=r"the law that the filters induce takes more than the (steps|memory) of a document of 1 MB"):
        checker.check(raw(good), [canonical(header)])


@pytest.mark.parametrize("decisions", [3, 5])
def test_screen_leaves_out_no_pair_that_matters(decisions: int) -> None:
    for seed in range(40):
        pick = random.Random(seed)
        laws = []
        for _ in range(60):
            weights = [pick.choice([0, 1, 2, pick.randint(0, 10**9)]) for _ in range(decisions)]
            weights[pick.randrange(decisions)] += 1
            laws.append(checker.laws.reduced_law(weights, sum(weights)))
        fractions = [[Fraction(w, total) for w in weights] for weights, total in laws]
        distances = {
            (i, j): sum((max(Fraction(0), p - q) for p, q in zip(fractions[i], fractions[j], strict=True)), Fraction(0))
            for i in range(60)
            for j in range(i + 1, 60)
        }
        most = max(distances.values())
        (n, d), i, j = checker.laws.widest_distance(laws)
        assert Fraction(n, d) == most and (i, j) == min(pair for pair, value in distances.items() if value == most)
