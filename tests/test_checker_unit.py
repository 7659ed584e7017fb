"""Unit tests of the checker on small certificates that are made here, by brute force over plain fractions."""

import copy
import hashlib
import importlib.util
import io
import json
import math
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest
from assumptions import complete

CHECKER = Path(__file__).resolve().parents[1] / "fairaudit" / "checker"
_SPEC = importlib.util.spec_from_file_location("lone_checker", CHECKER / "__init__.py", submodule_search_locations=[str(CHECKER)])
assert _SPEC is not None and _SPEC.loader is not None
checker = importlib.util.module_from_spec(_SPEC)
sys.modules["lone_checker"] = checker
_SPEC.loader.exec_module(checker)

INF = math.inf  # stands for c/0 in the brute force below


# A tiny writer of certificates, for tests only: everything by definition, over all pairs.


def text(value: Any) -> str:
    return "inf" if value == INF else str(value)


def ratio(a: Fraction, b: Fraction) -> Any:
    return a / b if b else (Fraction(1) if a == 0 else INF)


def log_pair(value: Any) -> list[str]:
    if value == 1:
        return ["0", "0"]
    if value == INF:
        return ["inf", "inf"]
    with localcontext() as context:
        context.prec = 60
        low = (Decimal(value.numerator).ln() - Decimal(value.denominator).ln()).quantize(Decimal("1e-12"), "ROUND_FLOOR")
        return [f"{low:f}", f"{low + Decimal('1e-12'):f}"]


def canonical(value: Any) -> bytes:
    return json.dumps(value, sort_keys=True, separators=(",", ":")).encode() + b"\n"


def lines_of(table: dict[str, Any]) -> list[bytes]:
    return [canonical(table["header"]), *map(canonical, table["rows"])]


def make(
    weights: dict[tuple[int, int], list[str]],
    utility: Any,
    *,
    population: str = "counts",
    masses: dict[tuple[int, int], str] | None = None,
    shape: tuple[int, int] | None = None,
    limits: tuple[tuple[str, str, str], ...] = (),
) -> dict[str, Any]:
    """Write the true certificate of a table given by its rows."""
    kind = "counts" if population == "counts" else "probabilities"
    n_contexts, n_groups = shape or (max(x for x, _ in weights) + 1, max(a for _, a in weights) + 1)
    n = len(next(iter(weights.values())))
    contexts, groups, decisions = (
        [[f"x{i}"] for i in range(n_contexts)],
        [[f"a{i}"] for i in range(n_groups)],
        [f"u{i}" for i in range(n)],
    )
    columns = {"decision": "D", "group": ["G"], "context": ["C"]}
    header: dict[str, Any] = {
        "format": "fairaudit-table/1",
        "kind": kind,
        "columns": columns,
        "population": population,
        "decisions": decisions,
    }
    header |= {"groups": groups, "contexts": contexts, "utility": utility if isinstance(utility, list) else None}
    rows: list[dict[str, Any]] = []
    g: dict[tuple[int, int], list[Fraction | None]] = {}
    P, M, E = {}, {}, {}
    for cell in sorted(weights):
        row: dict[str, Any] = {"context": cell[0], "group": cell[1], "weights": list(weights[cell])}
        entries = utility if isinstance(utility, list) else utility[cell]
        g[cell] = [None if e is None else Fraction(e) for e in entries]
        if masses is not None:
            row["mass"] = masses[cell]
        if not isinstance(utility, list):
            row["utility"] = utility[cell]
        rows.append(row)
        w = [Fraction(value) for value in weights[cell]]
        P[cell] = [value / sum(w) for value in w]
        M[cell] = sum(w) if population == "counts" else Fraction(masses[cell]) if masses is not None else Fraction(1)
        E[cell] = sum((p * (e or 0) for p, e in zip(P[cell], g[cell], strict=True)), Fraction(0))
    present = {x: [a for a in range(n_groups) if (x, a) in weights] for x in range(n_contexts)}
    compared = [x for x in present if len(present[x]) > 1]
    of_group = {a: [(x, b) for x, b in sorted(weights) if b == a] for a in range(n_groups)}
    mass = {a: sum((M[c] for c in of_group[a]), Fraction(0)) for a in of_group}
    populated = [a for a in mass if mass[a] > 0]
    lacking = population == "equal" and len(weights) < n_contexts * n_groups
    everywhere = populated if len(populated) > 1 and not lacking else []
    GP = {a: [sum(M[c] * P[c][u] for c in of_group[a]) / mass[a] for u in range(n)] for a in populated}
    GE = {a: sum(M[c] * E[c] for c in of_group[a]) / mass[a] for a in populated}

    def names(x: int | None, u: int | None, a: int, b: int) -> dict[str, Any]:
        place = {"context": {"C": f"x{x}"}} if x is not None else {}
        return place | ({"decision": f"u{u}"} if u is not None else {}) | {"higher": {"G": f"a{a}"}, "lower": {"G": f"a{b}"}}

    def ratios(cases: list[Any], key: str) -> Any:
        if not cases:
            return None
        best = max(ratio(c[4], c[5]) for c in cases)
        x, u, a, b, p, q = next(c for c in cases if ratio(c[4], c[5]) == best)
        return {"ratio": text(best), "log": log_pair(best), "witness": names(x, u, a, b) | {key: [str(p), str(q)]}}

    def distances(cases: list[Any]) -> Any:
        def tv(c: Any) -> Fraction:
            return sum((max(p - q, Fraction(0)) for p, q in zip(c[3], c[4], strict=True)), Fraction(0))

        if not cases:
            return None
        best = max(map(tv, cases))
        x, a, b, p, q = next(c for c in cases if tv(c) == best)
        return {
            "value": str(best),
            "witness": names(x, None, a, b) | {"decisions": [f"u{u}" for u in range(n) if p[u] > q[u]]},
        }

    local_pairs = [(x, a, b) for x in compared for a, b in permutations(present[x], 2)]
    global_pairs = list(permutations(everywhere, 2))
    metrics = {
        "local": ratios([(x, None, a, b, E[x, a], E[x, b]) for x, a, b in local_pairs], "expectations"),
        "global": ratios([(None, None, a, b, GE[a], GE[b]) for a, b in global_pairs], "expectations"),
        "demographic_parity": distances([(None, a, b, GP[a], GP[b]) for a, b in global_pairs if a < b]),
        "equalized_odds": distances([(x, a, b, P[x, a], P[x, b]) for x, a, b in local_pairs if a < b]),
        "local_supremum": ratios(
            [(x, u, a, b, P[x, a][u], P[x, b][u]) for x in compared for u in range(n) for a, b in permutations(present[x], 2)],
            "probabilities",
        ),
        "global_supremum": ratios([(None, u, a, b, GP[a][u], GP[b][u]) for u in range(n) for a, b in global_pairs], "probabilities"),
    }
    left_out: list[dict[str, Any]] = []
    for x in range(n_contexts):
        if missing := [groups[a] for a in range(n_groups) if a not in present[x]]:
            left_out.append({"context": contexts[x], "groups": missing, "reason": "no decisions recorded"})
    left_out += [{"context": contexts[x], "reason": "fewer than two groups"} for x in present if x not in compared]
    if nobody := [groups[a] for a in of_group if of_group[a] and mass[a] == 0]:
        left_out.append({"groups": nobody, "reason": "no population"})
    if not everywhere:
        reason = "a group is missing in a context and no population was given" if lacking else "fewer than two groups"
        left_out.append({"quantity": "global", "reason": reason})
    given = [e for cell in g for e in g[cell] if e is not None]
    if isinstance(utility, list):
        given = [Fraction(e) for e in utility]
    spreads = [abs(p - q) for x, a, b in local_pairs for p, q in zip(g[x, a], g[x, b], strict=True) if p is not None and q is not None]
    lipschitz = max(spreads, default=Fraction(0))
    table = {"header": header, "rows": rows}
    sha = hashlib.sha256(b"".join(lines_of(table))).hexdigest()
    compared_values = [E[x, a] for x in compared for a in present[x]]
    subject = {"kind": kind, "columns": columns, "population": population}
    subject["table"] = {"sha256": sha, "cells": n * len(rows), **table}
    subject["utility"] = {
        "gamma": str(max(given)),
        "m": str(min(given)),
        "tau": str(min(compared_values)) if compared_values else None,
        "lipschitz": str(lipschitz),
        "depends_on_group": lipschitz > 0,
    }
    claims: list[dict[str, Any]] = []

    def claim(quantity: str, relation: str, by: str, value: str, evidence: dict[str, str]) -> None:
        entry = {"quantity": quantity, "relation": relation, "by": by, "value": value, "evidence": evidence}
        claims.append(entry | {"scope": "this law", "assumptions": []})

    for quantity, name, by, key in [
        ("local_ratio", "local", "enumeration", "ratio"),
        ("global_ratio", "global", "enumeration", "ratio"),
        ("demographic_parity", "demographic_parity", "enumeration", "value"),
        ("equalized_odds", "equalized_odds", "enumeration", "value"),
        ("local_ratio_supremum", "local_supremum", "T6", "ratio"),
        ("global_ratio_supremum", "global_supremum", "T6", "ratio"),
    ]:
        if metrics[name]:
            claim(quantity, "=", by, metrics[name][key], {"table": sha})
    for quantity, name in [("equalized_odds", "local_supremum"), ("demographic_parity", "global_supremum")]:
        if metrics[name]:
            R = metrics[name]["ratio"]
            claim(quantity, "<=", "T7", "1" if R == "inf" else str((Fraction(R) - 1) / (Fraction(R) + 1)), {"supremum": R})
    total = sum(M.values(), Fraction(0))
    if len(weights) == n_contexts * n_groups and everywhere:
        of_context = {x: sum(M[x, a] for a in range(n_groups)) for x in present}
        if all(M[x, a] * total == of_context[x] * mass[a] for x, a in M):
            claim("global_ratio", "<=", "T5", metrics["local"]["ratio"], {"table": sha})
    targets = []
    for quantity, unit, limit in limits:
        metric = metrics[quantity]
        verdict = "inconclusive"
        if metric:
            R = INF if metric["ratio"] == "inf" else Fraction(metric["ratio"])
            measured = R if unit == "ratio" or R == INF else Fraction(0) if R == 1 else Fraction(metric["log"][1])
            verdict = "within" if measured <= Fraction(limit) else "exceeds"
        targets.append({"quantity": quantity, "limit": limit, "unit": unit, "judged": "this table", "verdict": verdict})
    stated = [t["verdict"] for t in targets] or ["none"]
    return {
        "format": "fairaudit-certificate/1",
        "subject": subject,
        "metrics": metrics,
        "not_compared": left_out,
        "claims": claims,
        "targets": targets,
        "verdict": next(v for v in ("exceeds", "inconclusive", "within", "none") if v in stated),
        "versions": {"fairaudit": "0"},
    }


def raw(certificate: Any) -> bytes:
    return json.dumps(certificate).encode()


def false_statements(certificate: Any, table: Any = None) -> list[str]:
    """What is false of a certificate whose claims list the assumptions that they have to."""
    report = checker.check(raw(complete(copy.deepcopy(certificate))), table)
    return [f"{f.statement} ({f.detail})" for f in report.findings if not f.true]


COUNTS = {(0, 0): ["3", "1"], (0, 1): ["1", "3"], (1, 0): ["1", "1"], (1, 1): ["2", "2"]}
LIMITS = (("local", "ratio", "3"), ("local", "log", "11/10"), ("global", "log", "1"))


@pytest.fixture
def good() -> dict[str, Any]:
    return make(COUNTS, ["1", "0"], limits=LIMITS)


def detached(certificate: dict[str, Any]) -> tuple[dict[str, Any], list[bytes]]:
    table = certificate["subject"]["table"]
    lines = lines_of(table)
    certificate["subject"]["table"] = {"sha256": table["sha256"], "cells": table["cells"]}
    return certificate, lines


# True certificates


def test_by_hand(good: dict[str, Any]) -> None:
    """The figures of the fixture, worked out on paper."""
    report = checker.check(raw(good))
    assert report.ok and report.verdict == "within"
    assert good["metrics"]["local"] == {
        "ratio": "3",
        "log": ["1.098612288668", "1.098612288669"],
        "witness": {
            "context": {"C": "x0"},
            "higher": {"G": "a0"},
            "lower": {"G": "a1"},
            "expectations": ["3/4", "1/4"],
        },
    }
    assert good["metrics"]["global"]["ratio"] == "16/9"  # group a0 has u0 in 4 of 6 cases, group a1 in 3 of 8
    assert not false_statements(good)


def random_table(seed: int) -> dict[str, Any]:
    pick = random.Random(seed)
    n_contexts, n_groups, n = pick.randint(1, 3), pick.randint(1, 4), pick.randint(1, 4)
    cells = [(x, a) for x in range(n_contexts) for a in range(n_groups) if pick.random() < pick.choice([0.6, 1])]
    cells = cells or [(0, 0)]
    population = pick.choice(["counts", "weights", "equal"])
    weights, utility, integers = {}, {}, {}
    for cell in cells:
        row = [pick.choice([0, 0, 1, 1, 2, 3]) for _ in range(n)]
        row[pick.randrange(n)] += 1
        fractional = [Fraction(w, sum(row)) if population != "counts" else Fraction(w, pick.choice([1, 1, 2])) for w in row]
        weights[cell] = [str(w) for w in fractional]
        utility[cell] = [None if w == 0 and pick.random() < 0.5 else pick.choice(["0", "1", "1", "3/2"]) for w in row]
        integers[cell] = pick.choice([0, 1, 2])
    masses = None
    if population == "weights":
        integers[cells[0]] += 1
        masses = {cell: str(Fraction(m, sum(integers.values()))) for cell, m in integers.items()}
    common = [pick.choice(["0", "1", "5/3"]) for _ in range(n)]
    limits = tuple((q, u, pick.choice(["1", "3/2", "4"])) for q in ("local", "global") for u in ("log", "ratio"))
    return make(
        weights,
        pick.choice([utility, common]),
        population=population,
        masses=masses,
        shape=(n_contexts, n_groups),
        limits=limits,
    )


@pytest.mark.parametrize("block", range(8))
def test_brute_force_agrees(block: int) -> None:
    for seed in range(block * 100, block * 100 + 100):
        certificate = random_table(seed)
        assert false_statements(certificate) == [], seed
        outside, lines = detached(certificate)
        assert checker.check(raw(outside), lines).ok


def test_t5_and_its_condition(good: dict[str, Any]) -> None:
    independent = make({(0, 0): ["3", "1"], (0, 1): ["1", "3"], (1, 0): ["1", "1"], (1, 1): ["1", "1"]}, ["1", "0"])
    assert any(c["by"] == "T5" for c in independent["claims"])
    assert not false_statements(independent)
    claim = copy.deepcopy(good["claims"][0]) | {"quantity": "global_ratio", "relation": "<=", "by": "T5", "value": "3"}
    good["claims"].append(claim)
    assert "not independent" in false_statements(good)[0]


def test_no_context_columns(good: dict[str, Any]) -> None:
    certificate = make({(0, 0): ["3", "1"], (0, 1): ["1", "3"]}, ["1", "0"])
    certificate["subject"]["columns"]["context"] = []
    certificate["subject"]["table"]["header"]["contexts"] = [[]]
    for name in ("local", "local_supremum", "equalized_odds"):
        certificate["metrics"][name]["witness"]["context"] = {}
    sha = hashlib.sha256(b"".join(lines_of(certificate["subject"]["table"]))).hexdigest()
    certificate = json.loads(json.dumps(certificate).replace(certificate["subject"]["table"]["sha256"], sha))
    assert not false_statements(certificate)


# Untrue statements


def edited(certificate: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    *steps, last = [int(s) if s.isdigit() else s for s in path.split(".")]
    place: Any = certificate
    for step in steps:
        place = place[step]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return certificate


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("subject.table.sha256", "0" * 64),
        ("subject.table.cells", 9),
        ("subject.table.rows.0.weights.0", "4"),
        ("subject.table.header.salt", "0" * 32),
        ("subject.utility.gamma", "2"),
        ("subject.utility.m", "1"),
        ("subject.utility.tau", None),
        ("subject.utility.tau", "1/3"),
        ("subject.utility.lipschitz", "1"),
        ("subject.utility.depends_on_group", True),
        ("subject.columns.decision", "Other"),
        ("metrics.local", None),
        ("metrics.local.ratio", "2"),
        ("metrics.local.ratio", "inf"),
        ("metrics.local.log", ["1.098612288668", "1.098612288670"]),
        ("metrics.local.log", ["1.098612288667", "1.098612288668"]),
        ("metrics.local.log", ["0", "0"]),
        ("metrics.local.witness.context.C", "x1"),
        ("metrics.local.witness.higher.G", "a1"),
        ("metrics.local.witness.expectations", ["3/4", "1/2"]),
        ("metrics.local_supremum.witness.decision", "u1"),
        ("metrics.equalized_odds.value", "1/3"),
        ("metrics.equalized_odds.witness.decisions", ["u1"]),
        ("not_compared", [{"context": ["x0"], "reason": "fewer than two groups"}]),
        ("claims.0.value", "2"),
        ("claims.0.by", "hope"),
        ("claims.0.quantity", "justice"),
        ("claims.0.scope", "every law"),
        ("claims.0.evidence.table", "0" * 64),
        ("claims.6.evidence.supremum", "4"),
        ("claims.6.value", "1/3"),
        ("targets.0.verdict", "exceeds"),
        ("targets.0.judged", "the population"),
        ("targets.1.limit", "1"),
        ("verdict", "exceeds"),
        ("verdict", "none"),
    ],
)
def test_false(good: dict[str, Any], path: str, value: Any) -> None:
    report = checker.check(raw(edited(good, path, value)))
    assert not report.ok


def test_false_is_found_where_it_stands(good: dict[str, Any]) -> None:
    lines = false_statements(edited(copy.deepcopy(good), "metrics.global.ratio", "2"))
    assert lines == ["metrics.global.ratio is 2 (the table gives 16/9)"]
    assert "unknown claim" in false_statements(edited(good, "claims.0.by", "hope"))[-1]


def test_repetitions(good: dict[str, Any]) -> None:
    good["claims"].append(good["claims"][0])
    good["targets"].append(good["targets"][0])
    assert ["occurs twice" in line for line in false_statements(good)] == [True, True]


def test_limits_of_zero_and_one() -> None:
    equal, unequal = make({(0, 0): ["1", "1"], (0, 1): ["2", "2"]}, ["1", "0"]), make(COUNTS, ["1", "0"])
    never = make({(0, 0): ["1", "1"]}, ["1", "0"], shape=(1, 2))
    for certificate, true in ((equal, "within"), (unequal, "exceeds"), (never, "inconclusive")):
        for quantity in ("local", "global"):
            for unit, limit in (("log", "0"), ("ratio", "1")):
                for verdict in ("within", "exceeds", "inconclusive"):
                    target = {"quantity": quantity, "limit": limit, "unit": unit, "judged": "this table", "verdict": verdict}
                    stated = certificate | {"targets": [target], "verdict": verdict}
                    assert checker.check(raw(stated)).ok is (verdict == true)


def test_what_is_left_out_is_compared_entry_by_entry(good: dict[str, Any]) -> None:
    """A table of a hundred kilobytes that leaves out a hundred million pairs is refused without listing them."""
    header = good["subject"]["table"]["header"]
    header["contexts"] += [[f"y{i}"] for i in range(10_000)]
    header["groups"] += [[f"b{i}"] for i in range(10_000)]
    for stated in ([], [{"context": ["x0"], "groups": [], "reason": "no decisions recorded"}]):
        good["not_compared"] = stated
        assert any(line.startswith("not_compared[0] is ") for line in false_statements(good))
    one = make({(0, 0): ["1", "1"]}, ["1", "0"], shape=(2, 2))
    entries = one["not_compared"]
    assert len(entries) == 5 and not false_statements(one)
    for i in range(5):
        assert f"not_compared[{i}] is " in false_statements(one | {"not_compared": entries[:i] + entries[i + 1 :]})[0]
    assert "not_compared[5] is " in false_statements(one | {"not_compared": [*entries, entries[4]]})[0]


def test_claim_about_null() -> None:
    certificate = make({(0, 0): ["1", "1"]}, ["1", "0"], shape=(1, 2))
    donor = make(COUNTS, ["1", "0"])["claims"]
    for claim in donor:
        certificate["claims"] = [claim]
        assert len(false_statements(certificate)) == 1


# Malformed documents


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("format", "fairaudit-certificate/2"),
        ("extra", 1),
        ("verdict", ...),
        ("verdict", "fine"),
        ("versions", {"a": 1}),
        ("versions", []),
        ("metrics.local.ratio", "2/4"),
        ("metrics.local.ratio", "3/1"),
        ("metrics.local.ratio", "03"),
        ("metrics.local.ratio", "+3"),
        ("metrics.local.ratio", "3.0"),
        ("metrics.local.ratio", "-0"),
        ("metrics.local.ratio", "3\n"),
        ("metrics.local.ratio", "\u0663"),
        ("metrics.local.ratio", "1/0"),
        ("metrics.local.ratio", "0/5"),
        ("metrics.local.ratio", ""),
        ("metrics.local.ratio", 3),
        ("metrics.local.ratio", True),
        ("metrics.local.ratio", None),
        ("metrics.local.ratio", "1" * 100_001),
        ("metrics.local.log", ["1.1", "1.2"]),
        ("metrics.local.log", ["01.098612288668", "1.098612288669"]),
        ("metrics.local.log", ["1.098612288668"]),
        ("metrics.local.witness.higher", {"H": "a0"}),
        ("metrics.local.witness.higher", {"G": "a0", "H": "a0"}),
        ("metrics.local.witness.decision", "u0"),
        ("metrics.equalized_odds.value", "inf"),
        ("metrics.equalized_odds.log", ["0", "0"]),
        ("metrics.other", None),
        ("subject.kind", "probabilities"),
        ("subject.population", "equal"),
        ("subject.columns.group", []),
        ("subject.columns.context", ["G"]),
        ("subject.utility.gamma", None),
        ("subject.utility.depends_on_group", 0),
        ("subject.table.rows", ...),
        ("subject.table.cells", True),
        ("subject.table.cells", 8.0),
        ("subject.table.cells", "8"),
        ("subject.table.cells", -8),
        ("subject.table.sha256", "0" * 63),
        ("subject.table.sha256", "A" * 64),
        ("subject.table.header.salt", "0"),
        ("subject.table.header.groups", [["a0"], ["a0"]]),
        ("subject.table.header.groups", [["a0", "b"], ["a1", "b"]]),
        ("subject.table.header.decisions", []),
        ("subject.table.header.utility", ["1"]),
        ("subject.table.header.utility", ["1", "-1"]),
        ("subject.table.rows.0.weights", ["0", "0"]),
        ("subject.table.rows.0.weights", ["1", "-1"]),
        ("subject.table.rows.0.weights", ["1"]),
        ("subject.table.rows.0.weights", ["1", "inf"]),
        ("subject.table.rows.0.group", 2),
        ("subject.table.rows.0.group", 1),
        ("subject.table.rows.0.group", False),
        ("subject.table.rows.0.mass", "1"),
        ("subject.table.rows.0.utility", ["1", "0"]),
        ("subject.table.rows.3.context", 0),
        ("claims.0.evidence", {"supremum": "3"}),
        ("claims.0.evidence.table", "3"),
        ("claims.0.assumptions", "none"),
        ("claims.0.assumptions", [1]),
        ("targets.0.limit", "1/2"),
        ("targets.1.limit", "-1"),
        ("targets.0.limit", "inf"),
        ("targets.0.unit", "bits"),
        ("not_compared", [{}]),
        ("not_compared", [{"context": "x0", "reason": "fewer than two groups"}]),
        ("not_compared", {}),
        ("claims", None),
    ],
)
def test_malformed(good: dict[str, Any], path: str, value: Any) -> None:
    with pytest.raises(checker.FormatError) as caught:
        checker.check(raw(edited(good, path, value)))
    assert path.split(".")[0] in str(caught.value) or "certificate" in str(caught.value)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 1000


@pytest.mark.parametrize(
    "document",
    [
        b"",
        b"{",
        b"[]",
        b"null",
        b"\xff",
        b"\xef\xbb\xbf{}",
        b"[" * 100_000,
        b'{"a":' * 100_000,
        b"NaN",
        b"1" * 10_000,
        b"1e999",
    ],
)
def test_not_a_certificate(document: bytes) -> None:
    with pytest.raises(checker.FormatError):
        checker.check(document)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"cells": 8', b'"cells": ' + b"8" * 10_000),
        (b'"cells": 8', b'"cells": -0'),
        (b'"cells": 8', b'"cells": NaN'),
        (b'"cells": 8', b'"cells": 8, "cells": 8'),
        (b'"fairaudit": "0"', b'"fairaudit": "\\ud800"'),
        (b'"fairaudit": "0"', b'"\\udfff": "0"'),
        (b'"fairaudit": "0"', b'"fairaudit": Infinity'),
    ],
)
def test_malformed_json(good: dict[str, Any], old: bytes, new: bytes) -> None:
    assert old in raw(good)
    with pytest.raises(checker.FormatError):
        checker.check(raw(good).replace(old, new))


def test_every_value_of_a_wrong_type(good: dict[str, Any]) -> None:
    """Whatever stands anywhere, the outcome is a report or a FormatError; most replacements are malformed."""

    def replace_all(value: Any, put: Callable[[Any], None]) -> None:
        junk: Any
        for junk in (None, True, 7, 1.5, "", "\u202e", [], {}, [[]], {"a": []}):
            put(junk)
            try:
                checker.check(raw(good))
            except checker.FormatError as error:
                assert "\u202e" not in str(error)
        put(value)
        for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
            replace_all(value[key], lambda item, key=key: value.__setitem__(key, item))  # type: ignore[misc]

    for key in list(good):
        replace_all(good[key], lambda item, key=key: good.__setitem__(key, item))  # type: ignore[misc]
    assert checker.check(raw(good)).ok


# Tables beside the certificate


def test_table_needed(good: dict[str, Any]) -> None:
    outside, lines = detached(good)
    with pytest.raises(checker.TableNeeded):
        checker.check(raw(outside))
    assert checker.check(raw(outside), iter(lines)).ok


@pytest.mark.parametrize(
    "spoil",
    [
        lambda lines: [*lines[:-1], lines[-1][:-1]],
        lambda lines: [*lines, b"\n"],
        lambda lines: [lines[0], lines[1].replace(b",", b", ", 1), *lines[2:]],
        lambda lines: [lines[0], lines[1].replace(b"\n", b"\r\n"), *lines[2:]],
        lambda lines: [lines[0], lines[2], lines[1], *lines[3:]],
        lambda lines: [lines[0], lines[1], lines[1], *lines[2:]],
        lambda lines: [lines[0].replace(b"x0", b"\xc3\xa9"), *lines[1:]],
        lambda lines: [lines[0].replace(b"x0", b"\\ud800"), *lines[1:]],
        lambda lines: [],
        lambda lines: lines[1:],
    ],
)
def test_spoiled_table(good: dict[str, Any], spoil: Callable[[list[bytes]], list[bytes]]) -> None:
    outside, lines = detached(good)
    with pytest.raises(checker.FormatError, match="table"):
        checker.check(raw(outside), spoil(lines))


def test_another_table(good: dict[str, Any]) -> None:
    outside, lines = detached(good)
    assert any("sha256" in line for line in false_statements(outside, lines[:-1]))
    other = make({(0, 0): ["1/2", "1/4", "1/4"], (0, 1): ["1", "0", "0"]}, ["1", "0", "2"], population="equal")
    assert any("subject.kind" in line for line in false_statements(outside, lines_of(other["subject"]["table"])))


def test_table_given_besides_the_embedded_one(good: dict[str, Any]) -> None:
    lines = lines_of(good["subject"]["table"])
    assert checker.check(raw(good), lines).ok
    assert not checker.check(raw(good), lines[:-1]).ok


@pytest.mark.parametrize("change", [{"mass": "1/3"}, {"weights": ["1/2", "1/3"]}, {"utility": [None, "0"]}])
def test_probabilities(change: dict[str, Any]) -> None:
    utility = {(0, 0): ["1", "0"], (0, 1): ["2", "0"]}
    certificate = make(
        {(0, 0): ["1/2", "1/2"], (0, 1): ["1", "0"]},
        utility,
        population="weights",
        masses={(0, 0): "1/2", (0, 1): "1/2"},
    )
    assert not false_statements(certificate)
    certificate["subject"]["table"]["rows"][0].update(change)
    with pytest.raises(checker.FormatError):
        checker.check(raw(certificate))


# Logarithms


def scaled_log(value: Fraction, digits: int) -> int:
    with localcontext() as context:
        context.prec = digits + 40
        context.Emax, context.Emin = 10**9, -(10**9)
        log = (Decimal(value.numerator) / Decimal(value.denominator)).ln()
        return int((log.scaleb(digits)).to_integral_value("ROUND_FLOOR"))


@pytest.mark.parametrize("seed", range(60))
def test_log_floor(seed: int) -> None:
    pick = random.Random(seed)
    size = 10 ** pick.choice([1, 2, 5, 20, 300])
    d = pick.randint(1, size)
    value = Fraction(d + pick.randint(1, pick.choice([3, size, size**3])), d)
    pair = value.numerator, value.denominator
    for digits in (0, 12, 50):
        assert checker.logarithms.log_floor(pair, 10**digits) == scaled_log(value, digits)
    floor = Fraction(scaled_log(value, 50), 10**50)
    above = floor + Fraction(1, 10**50)
    assert not checker.logarithms.log_at_most(pair, (floor.numerator, floor.denominator))
    assert checker.logarithms.log_at_most(pair, (above.numerator, above.denominator))


def test_log_extremes() -> None:
    tiny = 10**400 + 1, 10**400
    assert checker.logarithms.log_enclosure(tiny) == ("0.000000000000", "0.000000000001")
    assert checker.logarithms.log_at_most(tiny, (1, 10**400))
    assert not checker.logarithms.log_at_most(tiny, (10**400 - 1, 10**800))  # R - 1 - (R - 1)^2
    assert not checker.logarithms.log_at_most(tiny, (1, 10**4000)) and checker.logarithms.log_at_most(tiny, (10**4000, 1))
    assert not checker.logarithms.log_at_most(tiny, (2 * 10**400 - 1, 2 * 10**800))  # R - 1 - (R - 1)^2 / 2, the cubic is above
    assert checker.logarithms.log_at_most(tiny, (6 * 10**800 - 3 * 10**400 + 2, 6 * 10**1200))  # with the cubic, log R is below
    huge = 10**99_999, 1
    assert checker.logarithms.log_floor(huge, 10**12) == scaled_log(Fraction(10), 20) * 99_999 // 10**8
    assert checker.logarithms.log_floor((10**99_999 + 1, 10**99_999), 10**12) == 0
    assert checker.logarithms.log_enclosure((1, 1)) == ("0", "0") and checker.logarithms.log_enclosure((1, 0)) == ("inf", "inf")
    assert checker.logarithms.log_at_most((1, 1), (0, 1)) and not checker.logarithms.log_at_most((2, 1), (0, 1))
    assert not checker.logarithms.log_at_most((1, 0), (10**4000, 1))


def test_close_limit_of_a_thousand_digits() -> None:
    floor = scaled_log(Fraction(24475, 18432), 1000)
    assert not checker.logarithms.log_at_most((24475, 18432), (floor, 10**1000))
    assert checker.logarithms.log_at_most((24475, 18432), (floor + 1, 10**1000))


def test_long_numbers_are_read() -> None:
    digits = "9" * 99_999 + "7"
    number, one = checker.rationals.read_rational(digits, "here")
    assert number == 10**100_000 - 3 and one == 1
    assert checker.rationals.read_rational(f"-2/{digits}", "here") == (-2, number)


def test_long_numbers_in_a_certificate() -> None:
    certificate = make({(0, 0): ["1", "0"], (0, 1): ["1", "1"]}, ["1", "0"])
    certificate["metrics"]["local"]["ratio"] = "9" * 100_000
    certificate["claims"][0]["value"] = "1/1" + "0" * 50_000
    lines = false_statements(certificate)
    assert len(lines) == 2 and all(len(line) < 300 for line in lines)


# The command


def run(*arguments: str, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-I", str(CHECKER), *arguments]
    return subprocess.run(command, capture_output=True, cwd=cwd, env=os.environ | environment, check=False)


def test_command(tmp_path: Path, good: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    path, table = tmp_path / "c.json", tmp_path / "t.jsonl"
    path.write_bytes(raw(good))
    assert checker.main([str(path), "--require", "within"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert all(line.startswith("true   ") for line in out[:-1]) and "'within'" in out[-1]
    path.write_bytes(raw(edited(copy.deepcopy(good), "verdict", "none")))
    assert checker.main([str(path)]) == 1
    assert "FALSE  verdict" in capsys.readouterr().out
    path.write_bytes(raw(make(COUNTS, ["1", "0"])))
    assert checker.main([str(path)]) == 0 and checker.main([str(path), "--require", "within"]) == 1
    outside, lines = detached(good)
    path.write_bytes(raw(outside))
    table.write_bytes(b"".join(lines))
    assert checker.main([str(path)]) == 3
    assert checker.main([str(path), "--table", str(table)]) == 0
    assert checker.main([str(path), "--table", str(tmp_path)]) == 2


@pytest.mark.parametrize("arguments", [[], ["nowhere"], ["."], ["a\0b"], ["x", "--require", "exceeds"], ["x", "--req", "within"]])
def test_usage(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert checker.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err and not captured.out and "Traceback" not in captured.err


def test_lone_folder(tmp_path: Path, good: dict[str, Any]) -> None:
    shutil.copytree(CHECKER, tmp_path / "any name", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "c.json").write_bytes(raw(good))
    done = subprocess.run([sys.executable, "-I", "-S", "any name", "c.json"], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0 and not done.stderr


def test_nothing_steers_the_terminal(tmp_path: Path, good: dict[str, Any]) -> None:
    evil = "\x1b[2J\u202e\u2028\ufeff\ue000\u0378\U000e0001é"
    path = tmp_path / "c.json"
    for place in ("claims.0.quantity", "metrics.local.witness.higher.G", "targets.0.judged", "verdict", "format", evil):
        path.write_bytes(raw(edited(copy.deepcopy(good), place, evil)))
        for encoding in ("utf-8", "ascii"):
            done = subprocess.run(
                [sys.executable, str(CHECKER), str(path)],
                capture_output=True,
                env=os.environ | {"PYTHONIOENCODING": encoding},
                check=False,
            )
            assert done.returncode in (1, 2) and b"Traceback" not in done.stderr
            printed = (done.stdout + done.stderr).decode(encoding)
            assert all(c.isprintable() or c == "\n" for c in printed)
            assert "\\u202e" in printed and "\\u2028" in printed


def test_low_digit_limit(tmp_path: Path, good: dict[str, Any]) -> None:
    path = tmp_path / "c.json"
    path.write_bytes(raw(edited(good, "metrics.local.ratio", "9" * 5000)))
    done = subprocess.run([sys.executable, "-X", "int_max_str_digits=640", str(CHECKER), str(path)], capture_output=True, check=False)
    assert done.returncode == 1 and not done.stderr


def test_closed_streams(tmp_path: Path, good: dict[str, Any]) -> None:
    """The exit code tells what is true even where nothing can be printed."""
    path = tmp_path / "c.json"
    for certificate, code in ((good, 0), (edited(copy.deepcopy(good), "verdict", "none"), 1)):
        path.write_bytes(raw(certificate))
        for closed in (">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            script = f'"$1" -I "$2" "$3" {closed}'
            done = subprocess.run(["sh", "-c", script, "sh", sys.executable, str(CHECKER), str(path)], capture_output=True, check=False)
            assert done.returncode == code and not done.stderr


def test_output_goes_to_any_stream(tmp_path: Path, good: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.json"
    path.write_bytes(raw(good))
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stdout", stream)
    assert checker.main([str(path)]) == 0
    assert stream.getvalue().endswith("'within'\n")
