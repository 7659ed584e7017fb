"""Statements of small certificates that are made by brute force over plain fractions, and alterations of them."""

import copy
import hashlib
import json
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
import tiers
from plain_certificates import COUNTS, LIMITS, checker, detached, edited, false_statements, lines_of, make, raw


@pytest.fixture
def good() -> dict[str, Any]:
    return make(COUNTS, ["1", "0"], limits=LIMITS)


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
    pick = random.Random(tiers.fresh(seed))
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


def test_long_numbers_in_a_certificate() -> None:
    certificate = make({(0, 0): ["1", "0"], (0, 1): ["1", "1"]}, ["1", "0"])
    certificate["metrics"]["local"]["ratio"] = "9" * 100_000
    certificate["claims"][0]["value"] = "1/1" + "0" * 50_000
    lines = false_statements(certificate)
    assert len(lines) == 2 and all(len(line) < 300 for line in lines)
