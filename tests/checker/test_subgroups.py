"""Certificates of subgroups: true ones are accepted; whatever is altered or left out of one is found.

5,000 mutations of frontiers and 20,000 of documents: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_subgroups.py
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterator
from fractions import Fraction
from random import Random
from time import process_time
from typing import Any

import pytest
import tiers
from subgroup_oracle import Case, random_case, worst

from fairaudit.audits.subgroups import subgroups
from fairaudit.checker import FormatError, TableNeeded, TooMuch, check
from fairaudit.errors import InputError


def made(case: Case, **options: Any) -> dict[str, Any]:
    """The certificate of a case."""
    found = subgroups(
        case.columns,
        decision="got",
        attributes=case.attributes,
        utility=case.worth,
        depth=case.depth,
        min_rows=case.least,
        top=case.keep,
        **options,
    )
    return found.certificate.document


def cases(seed: str, number: int) -> Iterator[Case]:
    """Random cases that have a subgroup."""
    rng, given = Random(tiers.fresh(seed)), 0
    while given < number:
        case = random_case(rng)
        if worst(case):
            given += 1
            yield case


def accepted(document: dict[str, Any]) -> bool:
    """Whether the checker finds every statement true."""
    return check(json.dumps(document).encode()).ok


def rejected(document: dict[str, Any]) -> bool:
    """Whether a statement is false, or the document is refused."""
    try:
        return not accepted(document)
    except (FormatError, TableNeeded):
        return True


@pytest.mark.parametrize("confidence", [None, 0.9])
def test_true_certificates_are_accepted(confidence: float | None) -> None:
    rng = Random(tiers.fresh("targets"))
    seen = set()
    for case in cases(f"true {confidence}", 1000 if tiers.FULL else 60):
        limit = rng.choice([None, 1, "5/4", 2, 10, 100])
        document = made(case, confidence=confidence, max_ratio=limit)
        report = check(json.dumps(document).encode())
        assert report.ok, [finding for finding in report.findings if not finding.true]
        seen.add(report.verdict)
    assert tiers.enough(seen >= {"none", "within", "exceeds"})


def of_frontiers(rng: Random, document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Each node left out, counted differently, or put elsewhere; and one that is none."""
    nodes = document["frontier"]["nodes"]
    for i in range(len(nodes)):
        without = copy.deepcopy(document)
        del without["frontier"]["nodes"][i]
        yield without
        for j in range(len(nodes[i]["counts"])):
            for step in (1, -1, rng.randint(2, 9)):
                altered = copy.deepcopy(document)
                altered["frontier"]["nodes"][i]["counts"][j] += step
                yield altered
        moved = copy.deepcopy(document)
        condition = rng.choice(moved["frontier"]["nodes"][i]["conditions"])
        condition[rng.randrange(2)] += rng.choice([-1, 1])
        yield moved
        twice = copy.deepcopy(document)
        twice["frontier"]["nodes"].append(nodes[i])
        yield twice
        deeper = copy.deepcopy(document)
        deeper["frontier"]["nodes"][i]["conditions"].append([nodes[i]["conditions"][-1][0] + 1, 0])
        yield deeper
    more = copy.deepcopy(document)
    more["frontier"]["nodes"].append({"conditions": [[0, 0]], "counts": [1] * len(document["subject"]["table"]["header"]["decisions"])})
    yield more


def test_an_altered_frontier_is_rejected() -> None:
    rng, tried, wanted = Random(tiers.fresh("frontiers")), 0, 6000 if tiers.FULL else 300
    for case in cases("frontiers", 100_000):
        document = made(case, confidence=None)
        if not document["frontier"]["nodes"]:
            continue
        assert accepted(document)
        for altered in of_frontiers(rng, document):
            tried += 1
            assert rejected(altered), (document, altered["frontier"])
        if tried >= wanted:
            break
    assert tiers.enough(tried >= wanted)


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where something stands that can be altered."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, (*path, key))
    elif isinstance(value, list):
        yield path
        for i, item in enumerate(value):
            yield from leaves(item, (*path, i))
    else:
        yield path


def altered(rng: Random, document: dict[str, Any], path: tuple[Any, ...]) -> dict[str, Any]:
    """A document with something else at a place."""
    found = copy.deepcopy(document)
    place = found
    for key in path[:-1]:
        place = place[key]
    old = place[path[-1]]
    if isinstance(old, bool):
        place[path[-1]] = not old
    elif isinstance(old, int):
        place[path[-1]] = rng.choice([old + 1, max(0, old - 1), old * 2 + 1, 0])
    elif isinstance(old, list):
        place[path[-1]] = rng.choice([old[:-1], old + old[:1], old[::-1]])
    else:
        place[path[-1]] = rng.choice(["1", "2", "3/2", "inf", "within", "exceeds", "less", "more", "a", "b", "a b", "7/3", "0"])
    return found


ODD: tuple[Any, ...] = (None, [], {}, "", -1, 10**17, 10**20, 1.5, "-1/2", "inf", True, [[]], {"a": "b"}, "00", [0, 0], "\ud800")


def test_odd_values_are_refused_in_a_sentence() -> None:
    """Whatever stands anywhere: no error but those of the format."""
    rng = Random(tiers.fresh("odd"))
    for case in cases("odd", 400 if tiers.FULL else 25):
        document = made(case, confidence=rng.choice([None, 0.8]), max_ratio=rng.choice([None, 2]))
        paths = list(leaves(document))
        for path in rng.sample(paths, min(len(paths), 25)):
            changed = copy.deepcopy(document)
            place = _at(changed, path[:-1])
            if rng.random() < 0.15:
                del place[path[-1]]
            else:
                place[path[-1]] = copy.deepcopy(rng.choice(ODD))
            rejected(changed)


def test_an_altered_document_is_rejected() -> None:
    rng, tried, wanted = Random(tiers.fresh("documents")), 0, 20_000 if tiers.FULL else 600
    for case in cases("documents", 100_000):
        document = made(case, confidence=rng.choice([None, 0.8]), max_ratio=rng.choice([None, 2, 30]))
        paths = [path for path in leaves(document) if path[0] != "versions"]
        for path in rng.sample(paths, min(len(paths), 60)):
            changed = altered(rng, document, path)
            if changed == document or _still_true(path, document, changed):
                continue
            tried += 1
            assert rejected(changed), (path, document, changed)
        if tried >= wanted:
            break


def _still_true(path: tuple[Any, ...], document: dict[str, Any], changed: dict[str, Any]) -> Any:
    """Whether an alteration leaves what is stated true."""
    if "assumptions" in path or path == ("claims",) or path == ("family", "ends"):  # in another order
        return sorted(map(str, _at(document, path))) == sorted(map(str, _at(changed, path)))
    if path == ("family", "depth"):  # beyond the number of attributes nothing is added
        return min(document["family"]["depth"], changed["family"]["depth"]) >= len(document["subject"]["columns"]["attributes"])
    if path == ("targets",):  # twice the same
        return len(changed["targets"]) > 1
    if path == ("findings",):  # the most unequal of the most unequal
        return len(changed["findings"]) < len(document["findings"])
    if path == ("family", "least_rows"):  # there may be none of as many rows
        return True
    if path == ("frontier", "nodes"):
        return sorted(map(str, _at(document, path))) == sorted(map(str, _at(changed, path)))
    if path == ("frontier", "ratio"):  # a search that leaves less out finds the same, and its frontier may be the same
        new, last = changed["frontier"]["ratio"], document["findings"][-1]["ratio"]
        return new not in ("inf", "0") and re.fullmatch("[0-9/]+", new) and (last == "inf" or Fraction(new) <= Fraction(last))
    if path[0] == "claims" and path[-1] == "value":  # of a population what is weaker is true as well
        return document["claims"][path[1]]["relation"] != "="
    if "ends" in path or path[-1] == "finding":  # wider ends, and a weaker finding that still proves the claim
        return True
    return path[0] == "targets" and path[-1] == "limit"


def _at(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def test_ends_that_are_too_narrow_are_rejected() -> None:
    document = made(next(cases("ends", 1)), confidence=0.95, max_ratio=1000)
    for what in ("subgroup", "rest"):
        for i, value in ((0, "999/1000"), (1, "1/1000")):
            narrow = copy.deepcopy(document)
            narrow["findings"][0]["ends"][what][i] = value
            assert rejected(narrow)


def test_a_verdict_that_the_ends_do_not_prove_is_rejected() -> None:
    for case in cases("verdicts", 40):
        document = made(case, confidence=0.95, max_ratio=3)
        for verdict in {"within", "exceeds", "inconclusive"} - {document["verdict"]}:
            forged = copy.deepcopy(document)
            forged["verdict"] = forged["targets"][0]["verdict"] = verdict
            assert rejected(forged)


def test_an_upper_claim_needs_the_whole_family() -> None:
    """A claim that all subgroups keep a limit is refused without the ends of each, and with one of them left out."""
    rows = {"sex": ["f", "m"] * 2, "got": ["yes", "yes", "no", "no"], "n": [5000, 5000, 5000, 5010]}
    found = subgroups(rows, decision="got", attributes="sex", utility="yes", count="n", max_ratio=2)
    document = found.certificate.document
    assert (found.verdict, len(document["family"]["ends"])) == ("within", 2)
    assert accepted(document)
    without = copy.deepcopy(document)
    del without["family"]["ends"][0]
    without["claims"][2]["evidence"]["ends"] = 1
    assert rejected(without)
    none = copy.deepcopy(document)
    del none["family"]["ends"]
    assert rejected(none)


def test_the_table_stands_beside_the_certificate_if_asked(tmp_path: Any) -> None:
    case = next(cases("beside", 1))
    found = subgroups(case.columns, decision="got", attributes=case.attributes, utility=case.worth, min_rows=1, embed_table=False)
    certificate, table = found.save(tmp_path / "c.json")
    raw = certificate.read_bytes()
    with pytest.raises(TableNeeded):
        check(raw)
    lines = table.read_bytes().splitlines(keepends=True)
    assert check(raw, lines).ok
    assert not check(raw, [*lines[:-1], lines[-1].replace(b"]]", b",0]]")][: len(lines) - 1]).ok
    with pytest.raises(FormatError, match="canonical"):
        check(raw, [lines[0], b" " + lines[1], *lines[2:]])
    with pytest.raises(FormatError, match="come after"):
        check(raw, [*lines, lines[-1]])


def test_a_short_document_cannot_keep_the_checker_busy() -> None:
    names = [f"a{i}" for i in range(60)]
    rows = [[[i // 2**k % 2 for k in range(60)], [1, 1]] for i in range(400)]
    header = {
        "format": "fairaudit-subgroup-table/1",
        "columns": {"decision": "d", "attributes": names},
        "labels": [["x", "y"]] * 60,
        "decisions": [["no", "0"], ["yes", "1"]],
    }
    document = made(next(cases("busy", 1)), confidence=None)
    document["subject"] = {"columns": header["columns"], "table": {"sha256": "0" * 64, "cells": 0, "header": header, "rows": sorted(rows)}}
    document["findings"] = [document["findings"][0] | {"conditions": {"a0": "x"}, "same": []}]
    document["family"] = {"depth": 12, "least_rows": 1, "conjunctions": "1"}
    with pytest.raises(TooMuch):
        accepted(document)


def test_what_is_no_certificate_is_refused_in_a_sentence() -> None:
    document = made(next(cases("shape", 1)), confidence=None)
    for key in document:
        if key != "format":
            without = {name: item for name, item in document.items() if name != key}
            with pytest.raises(FormatError, match="lacks the key"):
                accepted(without)
    with pytest.raises(InputError, match="no conjunction"):
        subgroups({"a": ["x"], "got": ["1"]}, decision="got", attributes="a", utility="1", min_rows=1)


def test_very_many_decisions_are_read_in_no_time() -> None:
    """A hundred thousand utilities and one row, in a document of 1.5 MB: their places are looked up, not searched for."""
    document = made(next(cases("many", 1)))
    head = document["subject"]["table"]["header"]
    head["decisions"] = [["", str(i)] for i in range(100_000)]
    document["subject"]["table"]["rows"] = [[[0] * len(head["labels"]), [1] + [0] * 99_999]]
    started = process_time()
    assert rejected(document)
    assert process_time() - started < 20
