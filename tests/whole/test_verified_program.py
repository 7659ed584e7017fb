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


def with_plain_ends() -> list[dict[str, Any]]:
    """True certificates whose intervals list the ends of the cells that decide alone: of few and of many draws, none in some cells."""
    pick, found = Pick(7), []
    for contexts, groups, most in ((60, 3, 40), (120, 2, 6), (30, 5, 300)):
        counts = [[[pick.randrange(most), pick.randrange(1, most)] for _ in range(groups)] for _ in range(contexts)]
        law = fa.Law.from_array(counts, kind="counts")
        for worth, options in (("1", {}), ("2/7", {"confidence": "9/10"}), ("3", {"max_local_ratio": "3/2"})):
            found.append(fa.certify(law, {"0": Fraction(worth)}, **{"confidence": "19/20", **options}).certificate.document)
    return found


def changed_plain_ends(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text, interval = json.dumps(document), document["intervals"]["local"]
    for side, other in (("upper", "lower"), ("lower", "upper")):
        at, cells, ends = ("intervals", "local", side), interval[side]["cells"], interval[side]["ends"]
        for listed in (
            [],
            cells[1:],
            cells[::-1],
            [*cells[:-1], sum(cells[-1:]) + 1],
            [*cells[:-1], 10**6],
            [*cells, 10**30],
            [-1, *cells[1:]],
            None,
        ):
            yield put(text, (*at, "cells"), listed)
        for listed in ([], ends[1:], ends[::-1], [[high, low] for low, high in ends], [["0", "1000"]] * len(ends), None):
            yield put(text, (*at, "ends"), listed)
        yield put(text, at, {"cells": [], "ends": []})
        yield put(text, at, {"cells": [10**6], "ends": [["0", "1"]]})
        yield put(text, at, {**interval[side], "more": []})
        yield put(text, at, interval[other])
        yield put(text, at, ends)
        level = Fraction(interval["levels"][side])
        for near in (level / 2, 2 * level, level + Fraction(1, 10**12), Fraction(0), Fraction(1)):
            yield put(text, ("intervals", "local", "levels", side), str(near))
    for i, end in enumerate(interval["ratio"]):
        if end != "inf":
            for near in (Fraction(end) * (1 + Fraction(s, 10**9)) for s in (-1, 1)):
                yield put(text, ("intervals", "local", "ratio", i), str(near))


def with_many_draws() -> list[dict[str, Any]]:
    """True certificates of cells in which up to 40 million were drawn, some of which got nothing or next to nothing."""
    pick, found = Pick(8), []
    for contexts, groups, most in ((1, 2, 12_000), (2, 3, 400_000), (1, 2, 40_000_000)):
        counts = [[[pick.choice([0, 5, pick.randrange(most)]), pick.randrange(1, most)] for _ in range(groups)] for _ in range(contexts)]
        law = fa.Law.from_array(counts, kind="counts")
        found += [fa.certify(law, {"0": Fraction(2, 7)}, confidence=confidence).certificate.document for confidence in ("9/10", "999/1000")]
    return found


def changed_ends(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text = json.dumps(document)
    for quantity, interval in document["intervals"].items():
        for side in ("upper", "lower"):
            for i, end in enumerate(interval[side]):
                for near in (Fraction(end[s]) + k * Fraction(1, n) for s in (0, 1) for k in (-1, 1) for n in (10**4, 10**6, 10**12)):
                    if near >= 0:
                        yield put(text, ("intervals", quantity, side, i, int(near > Fraction(end[1]))), str(near))


@pytest.mark.slow
def test_ends_of_many_draws(program: Path) -> None:
    """Beyond 5,000 draws an end has to be excluded by the bound of the page as well as by the tail itself."""
    documents_, tally = with_many_draws(), Tally()
    for judged in natively(program, [as_bytes(document) for document in documents_]):
        assert {dict(judged.statements)[f"intervals.{quantity}"] for quantity in ("local", "global")} == {True}
    altered = [as_bytes(changed) for document in documents_ for changed in changed_ends(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if FULL else altered[::8])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE}


@pytest.mark.slow
def test_ends_in_closed_form(program: Path) -> None:
    """Intervals whose cells are not all listed are judged, and one that is narrower by a billionth as by the other checker."""
    documents_, tally = with_plain_ends(), Tally()
    for judged in natively(program, [as_bytes(document) for document in documents_]):
        assert dict(judged.statements)["intervals.local"] is True
    altered = [as_bytes(changed) for document in documents_ for changed in changed_plain_ends(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if FULL else altered[::8])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
