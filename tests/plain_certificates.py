"""Certificates of tables, made here by definition over all pairs of groups in plain fractions, and what the checker says of them."""

import copy
import hashlib
import importlib.util
import json
import math
import os
import subprocess
import sys
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

from assumptions import complete

CHECKER = Path(__file__).resolve().parents[1] / "fairaudit" / "checker"
_SPEC = importlib.util.spec_from_file_location("lone_checker", CHECKER / "__init__.py", submodule_search_locations=[str(CHECKER)])
assert _SPEC is not None and _SPEC.loader is not None
checker = importlib.util.module_from_spec(_SPEC)
sys.modules["lone_checker"] = checker
_SPEC.loader.exec_module(checker)
INF = math.inf  # stands for c/0 in the brute force below


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


def detached(certificate: dict[str, Any]) -> tuple[dict[str, Any], list[bytes]]:
    table = certificate["subject"]["table"]
    lines = lines_of(table)
    certificate["subject"]["table"] = {"sha256": table["sha256"], "cells": table["cells"]}
    return certificate, lines


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


def run(*arguments: str, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-I", str(CHECKER), *arguments]
    return subprocess.run(command, capture_output=True, cwd=cwd, env=os.environ | environment, check=False)
