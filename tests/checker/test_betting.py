"""The checker on intervals of streams: every alteration of the evidence is found."""

from __future__ import annotations

import contextlib
import copy
import json
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit import checker
from fairaudit.audits.certify import certify
from fairaudit.certificates.certificate import schema
from fairaudit.inference.anytime import Arrivals
from fairaudit.inference.betting import ValueCounts, wealth
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

F = Fraction
SCHEMA = jsonschema.Draft202012Validator(schema())
TABLE = {
    "u": ["no", "half", "yes"] * 5,
    "a": [label for label in "fmnfm" for _ in range(3)],
    "x": [label for label in "11122" for _ in range(3)],
    "n": [400, 50, 550, 640, 60, 300, 300, 20, 200, 50, 0, 50, 70, 10, 120],
}


@cache
def made(joint: bool = True, high: str = "1") -> str:
    law = Law.from_counts(TABLE, decision="u", group="a", context="x", count="n")
    order = ((("2",), ("f",)), (("1",), ("m",)), (("1",), ("f",)), (("2",), ("m",)), (("1",), ("n",)))
    utility = Utility({"half": "1/2", "yes": 1})
    targets = {"max_local_ratio": "6/5"}
    result = certify(law, utility, declared={"m": 0, "gamma": high}, arrivals=Arrivals(order, 4, joint), **targets)  # type: ignore[arg-type]
    return result.certificate.text


def certificate(joint: bool = True) -> Any:
    return json.loads(made(joint))


def false_statements(document: Any) -> list[str]:
    return [f.statement for f in checker.check(json.dumps(document).encode()).findings if not f.true]


@pytest.mark.parametrize("joint", [True, False])
def test_certificates_of_streams_are_true_and_fit_the_schema(joint: bool) -> None:
    document = certificate(joint)
    assert not false_statements(document)
    SCHEMA.validate(document)
    interval = document["intervals"]["local"]
    assert interval["region"] == ("product" if joint else "box")
    assert interval["levels"] == {"expected": 4, "order": [3, 2, 5, 1, 4]}
    assert ("global" in document["intervals"]) == joint  # with units in several contexts there is none
    assert document["verdict"] == ("exceeds" if joint else "inconclusive") or F(interval["ratio"][0]) > 1


Alteration = Callable[[Any], None]


def local(key: str, value: Any) -> Alteration:
    def alter(document: Any) -> None:
        document["intervals"]["local"][key] = value(document["intervals"]["local"][key]) if callable(value) else value

    return alter


def smaller(ratio: list[str]) -> list[str]:
    return [ratio[0], str(F(ratio[1]) * F(9, 10))]


def greater(ratio: list[str]) -> list[str]:
    return [str(F(ratio[0]) * F(11, 10)), ratio[1]]


def without(index: int) -> Callable[[Any], Any]:
    return lambda ladders: [[knot for k, knot in enumerate(ladder) if k != index % len(ladder)] for ladder in ladders]


ALTERED: dict[str, tuple[bool, Alteration]] = {
    "a smaller upper end": (True, local("ratio", smaller)),
    "a greater lower end": (True, local("ratio", greater)),
    "a greater confidence": (True, local("confidence", "99/100")),
    "independent cells": (True, local("independent", True)),
    "another method": (True, local("method", "hoeffding-kl")),
    "no limits": (True, local("limits", None)),
    "wider limits": (True, local("limits", ["0", "100"])),
    "narrower limits": (True, local("limits", ["0", "1/2"])),
    "limits that are one": (True, local("limits", ["1", "1"])),
    "another number of cells expected": (True, local("levels", lambda levels: {**levels, "expected": 100_000})),
    "later ranks": (False, local("levels", lambda levels: {**levels, "order": [10**6 + r for r in levels["order"]]})),
    "a rank twice": (True, local("levels", lambda levels: {**levels, "order": [1, 1, 2, 3, 4]})),
    "a rank of 0": (True, local("levels", lambda levels: {**levels, "order": [0, 1, 2, 3, 4]})),
    "a rank too few": (True, local("levels", lambda levels: {**levels, "order": levels["order"][:4]})),
    "no first knot": (True, local("upper", without(0))),
    "no last knot": (True, local("upper", without(-1))),
    "knots that fall": (True, local("upper", lambda ladders: [ladder[::-1] for ladder in ladders])),
    "no ladders": (True, local("upper", None)),
    "a ladder too few": (True, local("upper", lambda ladders: ladders[:1])),
    "no proof of the lower end": (True, local("lower", None)),
    "the pair turned round": (True, local("lower", lambda proof: {**proof, "pair": [0, proof["pair"][2], proof["pair"][1]]})),
    "a pair that is not there": (True, local("lower", lambda proof: {**proof, "pair": [7, 0, 1]})),
    "a pair of one cell": (True, local("lower", lambda proof: {**proof, "pair": [0, 1, 1]})),
    "units": (True, local("units", [])),
    "a box with a higher lower end": (False, local("upper", lambda ends: [[str(F(ends[0][0]) * F(11, 10)), ends[0][1]], *ends[1:]])),
    "two different boxes": (False, local("lower", lambda ends: [["0", "1"], *ends[1:]])),
    "a box with a lower upper end": (False, local("ratio", smaller)),
    "a box and a greater lower end": (False, local("ratio", greater)),
    "a box too small": (False, local("upper", lambda ends: ends[:2])),
    "a box with more confidence": (False, local("confidence", "999/1000")),
}


@pytest.mark.parametrize("name", ALTERED)
def test_alterations_are_found(name: str) -> None:
    joint, alter = ALTERED[name]
    document = copy.deepcopy(certificate(joint))
    alter(document)
    if name == "a box with a higher lower end":
        document["intervals"]["local"]["lower"] = document["intervals"]["local"]["upper"]
    with contextlib.suppress(checker.FormatError):
        assert false_statements(document)


@settings(max_examples=15, deadline=None)
@given(st.sampled_from([0, 1]), st.integers(0, 10_000), st.sampled_from([F(1, 2), F(9, 10), F(21, 20), F(2)]))
def test_a_knot_or_an_end_moved_is_found_or_still_proves(block: int, place: int, factor: Fraction) -> None:
    """A second reading of the evidence, by the writer's wealth: what the checker accepts really holds."""
    document = copy.deepcopy(certificate())
    interval = document["intervals"]["local"]
    knots = interval["upper"][block]
    at = place % len(knots)
    knots[at] = str(F(knots[at]) * factor)
    if any(F(p) >= F(q) for p, q in pairwise(knots)):
        assert false_statements(document)
        return
    cells = [[[400, 50, 550], [640, 60, 300], [300, 20, 200]], [[50, 0, 50], [70, 10, 120]]][block]
    tallies = [ValueCounts({F(0): row[0], F(1, 2): row[1], F(1): row[2]}) for row in cells]
    ranks = [[3, 2, 5], [1, 4]][block]
    number = {3: 1, 4: 2, 5: 3}
    ratio = F(interval["ratio"][1])

    def value(found: tuple[int, int]) -> Fraction:
        return F(found[0]) * F(2) ** found[1]

    def holds(p: Fraction | None, q: Fraction | None, i: int, j: int) -> bool:
        last = max(ranks[i], ranks[j])
        k = number[last]
        level = F(1, 20) * F(2, (k + 1) * (k + 2)) / (2 * sum(rank < last for rank in ranks))
        top = F(1, 32) if p is None or ratio * p <= 0 else None if ratio * p >= 1 else value(wealth(tallies[i], ratio * p, "below"))
        bottom = F(1, 32) if q is None else value(wealth(tallies[j], q, "above"))
        return top is None or top * bottom * level >= 1

    read = [F(knot) for knot in knots]
    steps = [(None, read[0]), *pairwise(read), *([(read[-1], None)] if read[-1] < 1 else [])]
    proved = all(holds(p, q, i, j) for p, q in steps for i in range(len(cells)) for j in range(len(cells)) if i != j)
    assert bool(false_statements(document)) != proved


def test_a_count_that_was_changed_is_found() -> None:
    document = certificate()
    rows = document["subject"]["table"]["rows"]
    rows[0]["weights"][0], rows[0]["weights"][2] = rows[0]["weights"][2], rows[0]["weights"][0]
    assert any("intervals.local" in text for text in false_statements(document))


def test_a_stream_is_of_counts_only() -> None:
    document = certificate()
    for row in document["subject"]["table"]["rows"]:
        row["weights"] = [str(F(w) / 2) for w in row["weights"]]
    assert any("intervals.local" in text for text in false_statements(document))


def test_many_decisions_are_checked_quickly() -> None:
    law = Law.from_array(
        [[10**6, 10**6 + 4000], [10**6 + 3000, 10**6], [7 * 10**5, 7 * 10**5]],
        kind="counts",
        decisions=["no", "yes"],
        groups=["f", "m", "n"],
    )
    arrivals = Arrivals(tuple(((), group) for group in law.groups))
    result = certify(law, {"yes": 1}, declared={"m": 0, "gamma": 1}, arrivals=arrivals, max_local_ratio="11/10")
    assert result.verdict == "within"
    assert checker.check(result.certificate.text.encode()).ok
