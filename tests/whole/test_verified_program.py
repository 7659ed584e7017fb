"""The checker that is extracted from its proof says what the other says, natively and as JavaScript; none accepts forged certificates.

2,500 true and altered documents of every kind, and with those of the other tests of the program some 7,000; 100,000, and each forged one:
FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_program.py
"""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from random import Random as Pick
from typing import Any

import over_policies
import pytest
import tiers
from assumptions import complete
from built_proofs import PROOFS
from certificate_changes import other_values, places, put
from certificate_kinds import as_bytes
from forged_certificates import FAMILIES, Forged
from plain_certificates import make
from policy_certificates import FLOORED, POLICIES
from prepared_logs import PREPARED, alterations, prepared
from truth_certificates import truth_certificate
from verified_roads import FALSE, MALFORMED, OPEN, TRUE, Tally, documents, natively, of_true_labels

import fairaudit as fa

BLOCKS = 10
EACH = 49
"""Alterations of each true document."""
PER_BLOCK = 100_000 // BLOCKS if tiers.FULL else 5 * int(os.environ.get("FAIRAUDIT_EXAMPLES", "50"))


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
    step = 1 if tiers.FULL else max(1, len(forged) // 65)
    tally = Tally()
    tally.judge(program, [document for _, document in forged[::step]])
    print(family.__name__, len(forged), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} <= {FALSE, MALFORMED}
    assert {verified for _, verified in tally.codes} <= {FALSE, MALFORMED, OPEN}


def test_no_altered_preparation_is_accepted(program: Path) -> None:
    """What was done to the log is under the digest of the table, here too: it is not even left open."""
    tally = Tally()
    true = [as_bytes(prepared(seed)) for seed in range(PREPARED)]
    assert not any(found is False for judged in natively(program, true) for _, found in judged.statements)
    tally.judge(program, [as_bytes(document) for document in alterations(1000 if tiers.FULL else 100)])
    print(dict(tally.codes))
    assert tally.different[:3] == []
    assert {code for codes in tally.codes for code in codes} <= {FALSE, MALFORMED}


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
    tally.judge(program, [*map(as_bytes, documents_), *(altered if tiers.FULL else altered[::9])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}


def changed_rates(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Every value of rates, of their differences, of claims about them and of what is not compared by them changed; lists exchanged."""
    text = json.dumps(document)
    names = [name for name in document["metrics"] if "rate" in name or "opportunity" in name or "true_label" in name]
    at: list[tuple[Any, ...]] = [("metrics", name) for name in names] + [("not_compared",), ("subject", "positive")]
    at += [("claims", i) for i, claim in enumerate(document["claims"]) if claim["quantity"] in names]
    pool = ["true_positive_rate", "false_positive_rate_overall", "fewer than two groups", "no decisions with another true label", "f"]
    for path in at:
        whole = document
        for step in path:
            whole = whole[step]
        for inner, value in places(whole):
            yield from (put(text, (*path, *inner), other) for other in other_values(value, pool) if not isinstance(other, float))
        for name in names:
            yield put(text, path, document["metrics"][name])


def test_rates_with_true_labels(program: Path) -> None:
    """Every statement of a table with true labels is judged, but for intervals; all roads agree on altered ones."""
    given = [of_true_labels(seed) for seed in range(300 if tiers.FULL else 60)]
    covered = Counter[str]()
    for document, found in zip(given, natively(program, given), strict=True):
        names = {name for name in json.loads(document)["metrics"] if "rate" in name or "opportunity" in name or "true_label" in name}
        outcomes = dict(found.statements)
        assert all(outcomes[f"metrics.{name}"] for name in names)
        assert outcomes["not_compared"] is True
        for label, true in outcomes.items():
            assert true or (true is None and re.search(r"intervals|spellings|population|claims|rate_difference|targets|verdict", label)), (
                label
            )
        claimed = [true for label, true in outcomes.items() if 'by "enumeration"' in label]
        assert all(claimed)
        covered.update(names)
    assert len(covered) == 8
    assert all(covered.values())
    pick, tally = Pick(3), Tally()
    for document in given[:: 1 if tiers.FULL else 6]:
        altered = [as_bytes(changed) for changed in changed_rates(json.loads(document))]
        tally.judge(program, [document, *pick.sample(altered, min(len(altered), 2000 if tiers.FULL else 80))])
    print(dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}


def test_tables_with_true_labels_at_the_edge(program: Path) -> None:
    """One group alone, nobody with the positive true label, all with it, and a table of ten thousand cells."""
    one = [["3", "1"], ["1", "6"]]
    nobody = [["0", "0"], ["1", "6"]]
    edges = [{(0, 0): one}, {(0, 0): one, (0, 1): nobody}, {(0, 0): nobody, (0, 1): nobody}, {(0, 0): one, (1, 1): one}]
    edges += [{(0, 0): rows, (0, 1): rows} for rows in ([["1"], ["2"]], [["2", "5"]], [["0", "5"], ["0", "1"]])]
    given = [as_bytes(complete(truth_certificate(counts))) for counts in edges]
    many = [(u, t, f"a{a}", f"x{x}", (u + 2 * t + x * a) % 5) for x in range(500) for a in range(20) for u in range(2) for t in range(2)]
    data = {name: list(values) for name, values in zip("utaxn", zip(*many, strict=True), strict=True)}
    law = fa.Law.from_counts(data, decision="u", group="a", context="x", count="n", truth="t")
    given.append(fa.certify(law, {"1": 1}, positive="1", confidence=None).certificate.text.encode())
    tally = Tally()
    tally.judge(program, given)
    assert tally.different == []
    assert tally.codes == {(TRUE, TRUE): len(given)}


def test_what_is_claimed_of_other_policies(program: Path) -> None:
    """T13 in all its scopes: every true certificate is found true, and every alteration gets the same verdict on all roads."""
    documents_, tally = [over_policies.certificate(tiers.fresh(seed)) for seed in range(400 if tiers.FULL else 40)], Tally()
    said = Counter[tuple[str, ...]]()
    for document, judged in zip(documents_, natively(program, [as_bytes(document) for document in documents_]), strict=True):
        assert judged.code == TRUE and all(true for _, true in judged.statements), judged
        said.update((c["quantity"], c["relation"], c["scope"]) for c in document["claims"] if c["by"] == "T13")
    scopes = POLICIES, over_policies.NEAR, FLOORED, over_policies.RANGE, over_policies.FLOORED_RANGE
    expected = [("_supremum", scope, "=") for scope in scopes[:3]] + [
        ("_supremum", scopes[2], "<="),
        ("", scopes[3], "<="),
        ("", scopes[4], "<="),
    ]
    assert {*said} == {(f"{name}_ratio{of}", sign, scope) for name in ("local", "global") for of, scope, sign in expected}
    altered = [as_bytes(changed) for i, document in enumerate(documents_) for changed in over_policies.altered(document, Pick(i))]
    tally.judge(program, altered if tiers.FULL else altered[::12])
    print(len(altered), dict(tally.codes), dict(tally.open.most_common(5)))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
