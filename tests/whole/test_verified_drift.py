"""How far cells may move before a verdict falls, and ratios within a declared drift (T16): all roads say the same of them.

One alteration in some in .ci/run; all: FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_drift.py
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from random import Random as Pick
from typing import Any

import tiers
from certificate_changes import put
from certificate_kinds import as_bytes
from verified_roads import FALSE, MALFORMED, TRUE, Tally, natively

import fairaudit as fa


def with_drift() -> list[dict[str, Any]]:
    """True certificates with what drift changes: counts and probabilities, by variation and by factor, all kinds of limits, zeros, ties."""
    pick, found = Pick(7), []
    tables: list[tuple[fa.Law, Any]] = []
    for counts in (
        [[[30, 70], [55, 45]]],
        [[[0, 9], [5, 4]], [[3, 3], [4, 2]]],
        [[[8, 2], [5, 5], [1, 9]]] * 2,
        [[[0, 1], [0, 2]]],
        [[[1, 0], [2, 0]]],
    ):
        tables.append((fa.Law.from_array(counts, kind="counts"), {"0": 1}))
    for utility in ({"0": 1, "1": "1/3"}, {"0": 2, "1": 2, "2": 1}, {"0": 1, "1": 1, "2": 1}):
        counts = [[[pick.randint(0, 6) + (u == a) for u in range(3)] for a in range(3)] for _ in range(2)]
        tables.append((fa.Law.from_array(counts, kind="counts"), utility))
    probabilities = [[[Fraction(n, 10), Fraction(10 - n, 10)] for n in pick.sample(range(11), 3)]]
    law = fa.Law.from_array(probabilities, kind="probabilities")
    tables.append((law, fa.Utility.from_function(lambda u, x, a: (2 + int(a[0])) * (u == "0") + (u == "1"), law)))
    for law, utility in tables:
        for options in (
            {"max_local_ratio": "2", "max_global_ratio": "11/10"},
            {"max_local_ratio": "1", "max_local_log": "0", "max_global_log": "1/5"},
            {"max_local_ratio": "8", "max_global_log": "0.2", "max_drift": "1/20"},
            {"max_local_log": "0.5", "max_global_ratio": "1", "max_drift": "0"},
            {"max_local_ratio": "3/2", "max_global_ratio": "3/2", "max_drift": "1"},
        ):
            found.append(fa.certify(law, utility, **options, confidence=None).certificate.document)
    return found


def changed_drift(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text = json.dumps(document)
    if "max_drift" in document["subject"]:
        for other in ("0", "1", "1/20", "1/21", "21/20", "inf", None):
            yield put(text, ("subject", "max_drift"), other)
        for i, target in enumerate(document["targets"]):
            changes = [("verdict", word) for word in ("within", "exceeds", "depends", "inconclusive", "changed")]
            changes += [("limit", near) for near in ("1", "0", "3/2", "100", str(Fraction(target["limit"]) + Fraction(1, 1000)))]
            changes += [("unit", "log"), ("unit", "ratio"), ("quantity", "local"), ("quantity", "global"), ("judged", "this table")]
            for name, other in changes:
                yield put(text, ("targets", i, name), other)
        for verdict in ("within", "exceeds", "depends"):
            yield put(text, ("verdict",), verdict)
        for i, claim in enumerate(document["claims"]):
            if claim["by"] == "T16":
                yield {**json.loads(text), "claims": document["claims"][:i] + document["claims"][i + 1 :]}
                yield {**json.loads(text), "claims": [*document["claims"], claim]}
    for i, claim in enumerate(document["claims"]):
        if claim["by"] != "T16":
            continue
        evidence, at = claim["evidence"], ("claims", i)
        numbers = [(("value",), claim["value"])] + ([(("evidence", "limit"), evidence["limit"])] if "limit" in evidence else [])
        for path, number in numbers:
            value = Fraction(number) if number != "inf" else Fraction(3)
            for near in (
                value + Fraction(1, 10**6),
                value - Fraction(1, 10**6),
                2 * value,
                1 / (value + 1),
                Fraction(0),
                Fraction(1),
                -value,
            ):
                yield put(text, (*at, *path), str(near))
            yield put(text, (*at, *path), "inf")
        others: list[tuple[str, Any]] = [("followed", other) for other in ([], [["0"]], [["0"], ["0"]], [["9"]], [["0", "1"]], [[]], None)]
        others += [
            ("followed", evidence["followed"][::-1]),
            ("followed", evidence["followed"][1:]),
            ("verdict", "within"),
            ("verdict", "exceeds"),
        ]
        others += [
            ("pair", other) for other in (None, {"context": None, "higher": ["0"], "lower": ["1"]}, {"context": ["0"], "higher": ["1"]})
        ]
        if evidence["pair"] is not None:
            pair = evidence["pair"]
            others += [("pair", {**pair, "higher": pair["lower"], "lower": pair["higher"]}), ("pair", {**pair, "higher": pair["lower"]})]
            others += [("pair", {**pair, name: other}) for name in pair for other in (["0"], ["1"], ["2"], ["0", "1"], [], None, "0")]
        for name, other in others:
            yield put(text, (*at, "evidence", name), other)
        words = [("relation", word) for word in ("=", ">=", "<=")] + [
            ("by", "T14"),
            ("scope", "this law"),
            ("scope", "this law, within the declared drift"),
        ]
        words += [
            ("quantity", f"{first}_{unit}")
            for first in ("local", "global")
            for unit in ("ratio_radius", "log_radius", "log_factor", "ratio_factor", "ratio")
        ]
        for name, word in words:
            yield put(text, (*at, name), word)
        for listed in (claim["assumptions"][1:], claim["assumptions"] * 2, [*claim["assumptions"], "more"], []):
            yield put(text, (*at, "assumptions"), listed)


def test_verdicts_under_drift(program: Path) -> None:
    """T16 of the table, and targets within a drift: every number, pair and group changed, other quantities, scopes and assumptions."""
    documents_, tally = with_drift(), Tally()
    covered = Counter[tuple[str, str]]()
    for document, found in zip(documents_, natively(program, [as_bytes(document) for document in documents_]), strict=True):
        for label, true in found.statements:
            if '"T16"' in label:
                claim = document["claims"][int(label.split("]")[0].removeprefix("claims["))]
                assert true
                covered[claim["quantity"].partition("_")[2], claim["relation"]] += 1
            if label.startswith("targets[") or label == "verdict":
                assert true
    forms = {(f"{unit}_{form}", sign) for unit in ("ratio", "log") for form in ("radius", "factor") for sign in ("=", ">=")}
    assert covered.keys() >= forms - {("ratio_radius", ">=")} | {("ratio", "<="), ("ratio", ">=")}
    altered = [as_bytes(changed) for document in documents_ for changed in changed_drift(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if tiers.FULL else altered[::29])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
