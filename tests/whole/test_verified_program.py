"""The checker that is extracted from its proof says what the other says, natively and as JavaScript; none accepts forged certificates.

5,000 true and altered documents in .ci/run, half as many by hand; 100,000, and each forged one:
FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_program.py
"""

from __future__ import annotations

import json
import os
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from random import Random as Pick
from typing import Any

import pytest
from assumptions import complete
from built_proofs import PROOFS, build
from certificate_changes import put
from certificate_kinds import as_bytes
from forged_certificates import FAMILIES, Forged
from plain_certificates import make
from verified_roads import FALSE, MALFORMED, OPEN, TRUE, Tally, documents, driver, natively

import fairaudit as fa

FULL = os.environ.get("FAIRAUDIT_FULL") == "1"
BLOCKS = 10
EACH = 49
"""Alterations of each true document."""
PER_BLOCK = 100_000 // BLOCKS if FULL else 5 * int(os.environ.get("FAIRAUDIT_EXAMPLES", "50"))


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program, which judges many documents in one process, where the proofs were built before or have to be."""
    if os.environ.get("FAIRAUDIT_COQ") != "1" and not (PROOFS / "checker" / "Certificate.vo").is_file():
        pytest.skip("the proofs are not built: make -C proofs, see docs/proofs.md")
    return driver(build("build/fairaudit-check") / "build", tmp_path_factory.mktemp("driver"))


@pytest.mark.parametrize("block", range(BLOCKS))
def test_the_same_verdicts(block: int, program: Path) -> None:
    tally, per_block = Tally(), -(-PER_BLOCK // (1 + EACH))
    for first in range(block * per_block, (block + 1) * per_block, 20):  # so that a process judges a thousand documents
        tally.judge(program, documents(range(first, min(first + 20, (block + 1) * per_block)), EACH))
    print(dict(tally.codes), dict(tally.open.most_common()))
    assert tally.different[:3] == []
    assert sum(tally.codes.values()) >= PER_BLOCK
    assert {code for code, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}


@pytest.mark.parametrize("family", FAMILIES)
def test_no_forged_certificate_is_accepted(family: Callable[[], Iterator[Forged]], program: Path) -> None:
    """Where what was forged is not covered, that is not said to be true."""
    forged = list(family())
    step = 1 if FULL else max(1, len(forged) // 65)
    tally = Tally()
    tally.judge(program, [document for _, document in forged[::step]])
    print(family.__name__, len(forged), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} <= {FALSE, MALFORMED}
    assert {verified for _, verified in tally.codes} <= {FALSE, MALFORMED, OPEN}


@pytest.mark.parametrize(
    ("document", "code"),
    [
        (b"[" * 1_000_000, 2),
        (b"[" * 300_000 + b"]" * 300_000, 2),
        (b'{"a": 1, "a": 1}', 2),
        (b'{"\\ud83d\\ude00": 1, "\xf0\x9f\x98\x80": 1}', 2),
        (b'{"format": "fairaudit-certificate/1"}', 2),
        (b"9" * 200_000, 2),
    ],
)
def test_hostile_files(document: bytes, code: int, program: Path, tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    path.write_bytes(document)
    assert subprocess.run([str(PROOFS / "build" / "fairaudit-check"), str(path)], capture_output=True).returncode == code


@pytest.mark.slow
def test_long_numbers(program: Path) -> None:
    """Counts of 1,000 digits, and numbers of as many digits as the format has: all roads say the same, and none runs out of memory."""
    pick = Pick(0)
    weights = {(0, a): [str(pick.randrange(10**999, 10**1000)) for _ in range(2)] for a in range(2)}
    given = complete(make(weights, ["0", "1"], shape=(1, 2), limits=(("local", "ratio", "2"),)))
    [claim, *_] = given["claims"]
    altered = [put(json.dumps(given), ("claims", 0, "value"), value) for value in (f"{claim['value']}1", "9" * 100_000, "9" * 100_001)]
    altered.append(put(json.dumps(given), ("targets", 0, "limit"), "9" * 100_000))
    tally = Tally()
    tally.judge(program, [as_bytes(document) for document in (given, *altered)])
    assert tally.different == []
    assert tally.codes == {(TRUE, TRUE): 1, (FALSE, FALSE): 3, (MALFORMED, MALFORMED): 1}


@pytest.mark.parametrize(
    ("labels", "covered"),
    [(["a a", "Aa "], False), (["1", "2"], True), (["1", "1.0"], False), (["é", "b"], False), (["e", "E2"], False), (["e", "<30"], True)],
)
def test_labels_that_may_be_spellings_of_one_another_are_left_to_the_other_checker(labels: list[str], covered: bool, program: Path) -> None:
    law = fa.Law.from_array([[[3, 1], [1, 4]]] * 2, kind="counts", contexts=labels)
    [judged] = natively(program, [json.dumps(fa.certify(law, {"0": 1}).certificate.document).encode()])
    assert (("subject.spellings", None) not in judged.statements) is covered
    assert all(true is not False for _, true in judged.statements)


def with_frontiers() -> list[dict[str, Any]]:
    """True certificates with what a hidden factor would have to be: of tables and populations, with targets, zeros and many groups."""
    pick, found = Pick(5), []
    for counts in ([[[30, 70], [55, 45]]], [[[0, 9], [5, 4]], [[3, 3], [4, 2]]], [[[8, 2], [5, 5], [1, 9]]] * 2):
        law = fa.Law.from_array(counts, kind="counts")
        for options in ({}, {"max_local_ratio": "11/10"}, {"max_global_ratio": "6/5", "confidence": "9/10", "independent": True}):
            found.append(fa.certify(law, {"0": 1}, **options).certificate.document)
    probabilities = [[[Fraction(n, 10), Fraction(10 - n, 10)] for n in pick.sample(range(11), 3)]]
    return [*found, fa.certify(fa.Law.from_array(probabilities, kind="probabilities"), {"0": 1}).certificate.document]


def changed_frontiers(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text = json.dumps(document)
    for i, claim in enumerate(document["claims"]):
        levels = claim["evidence"].get("frontier")
        if levels is None:
            continue
        leaves = [(("value",), claim["value"])]
        for n, level in enumerate(levels):
            at = ("evidence", "frontier", n)
            leaves += [((*at, name), level[name]) for name in ("to", "balanced")]
            leaves += [((*at, "pairs", p, side), number) for p, pair in enumerate(level["pairs"]) for side, number in enumerate(pair)]
            others = ([], level["pairs"][::-1], level["pairs"][1:], level["pairs"] * 5, [*level["pairs"], ["1", "2"]], [["2"]], None)
            for other in others:
                yield put(text, ("claims", i, *at, "pairs"), other)
        for path, number in leaves:
            value = Fraction(number) if number != "inf" else Fraction(3)
            for near in (value + Fraction(1, 10**6), value - Fraction(1, 10**6), 2 * value, Fraction(1), -value):
                yield put(text, ("claims", i, *path), str(near))
            yield put(text, ("claims", i, *path), "inf")
        for other in ([], levels[1:], levels[::-1], levels * 2, levels * 9, [{**levels[0], "more": "1"}]):
            yield put(text, ("claims", i, "evidence", "frontier"), other)
        for name, other in (
            ("quantity", "global_hidden_context"),
            ("scope", "population at confidence 19/20"),
            ("by", "T7"),
            ("relation", "="),
        ):
            yield put(text, ("claims", i, name), other)
        yield put(text, ("claims", i, "assumptions"), claim["assumptions"][1:])


def test_frontiers_of_hidden_factors(program: Path) -> None:
    """T14 of the table and of the population: every number changed, pairs and levels exchanged and left out, other claims."""
    documents_, tally = with_frontiers(), Tally()
    judged = natively(program, [as_bytes(document) for document in documents_])
    covered = Counter[str]()
    for document, found in zip(documents_, judged, strict=True):
        scopes = {f"claims[{i}]": claim["scope"] for i, claim in enumerate(document["claims"]) if "frontier" in claim["evidence"]}
        for label, true in found.statements:
            if '"T14"' in label:
                scope = scopes[label.split(":")[0]]
                assert true if scope == "this law" else true is not False
                covered[scope] += bool(true)
    assert {scope.split(" at ")[0] for scope, count in covered.items() if count} == {"this law", "population", "population, one-sided"}
    altered = [as_bytes(changed) for document in documents_ for changed in changed_frontiers(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if FULL else altered[::3])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}


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
    tally.judge(program, [*map(as_bytes, documents_), *(altered if FULL else altered[::29])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
