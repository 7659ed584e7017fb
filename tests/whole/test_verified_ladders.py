"""Intervals by ladders for pairs of cells, as the verified program and the Python checker judge them.

One alteration in 12 in .ci/run; all: FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_ladders.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import tiers
from certificate_changes import put
from certificate_kinds import as_bytes
from verified_roads import FALSE, MALFORMED, OPEN, TRUE, Tally, natively

import fairaudit as fa


def with_ladders() -> list[dict[str, Any]]:
    """True certificates whose intervals rest on ladders: both ends together or each, one that needs none, other values."""
    found = []
    made: list[tuple[list[Any], str, dict[str, Any]]] = [
        ([[[30, 70], [55, 45]]], "1", {}),
        ([[[9, 31], [22, 18], [40, 3]]], "7/3", {"confidence": "99/100"}),
        ([[[0, 12], [8, 4]], [[5, 5], [1, 30]]], "1", {"max_local_ratio": "3/2", "max_global_log": "0.2"}),
        ([[[3, 0], [2, 2]]] * 3, "1/2", {"confidence": "1/2"}),
    ]
    for counts, worth, options in made:
        given: dict[str, Any] = {"confidence": "19/20", "independent": True, **options}
        found.append(fa.certify(fa.Law.from_array(counts, kind="counts"), {"0": Fraction(worth)}, **given).certificate.document)
    law = fa.Law.from_array([[[4, 40], [30, 12]], [[20, 15], [9, 33]]], kind="counts")
    worth_of = dict(zip(law.groups, (1, 3), strict=True))
    utility = fa.Utility.from_function(lambda u, _, a: worth_of[a] * (u == "0"), law)
    return [*found, fa.certify(law, utility, confidence="9/10", independent=True).certificate.document]


Change = tuple[tuple[Any, ...], Any]
"""A place, and what stands there then."""


def changed_knots(knots: list[str]) -> Iterator[Change]:
    middle = len(knots) // 2
    for listed in (knots[1:], knots[:-1], knots[::-1], knots[: middle or 1], knots[:middle] + knots[middle + 1 :], knots[:1], knots * 2):
        yield (), listed
    for listed in (["0", *knots], [*knots, "1"], [*knots, "2"], ["-1", *knots], ["0"], ["1"], ["0", "1"], []):
        yield (), listed
    yield (), None
    for n in {0, middle, len(knots) - 1}:
        for part in (Fraction(-1, 100), Fraction(-1, 10**6), Fraction(1, 10**6), Fraction(1, 100)):
            yield (n,), str(Fraction(knots[n]) * (1 + part))


def changed_upper(interval: dict[str, Any]) -> Iterator[Change]:
    listed = interval["upper"] or []
    for n, knots in enumerate(listed):
        yield from ((("upper", n, *place), value) for place, value in changed_knots(knots))
    if listed:
        for ladders in (listed[::-1], listed[1:], [*listed, listed[0]], [], [*listed[1:], listed[0]], None, listed[0]):
            yield ("upper",), ladders
        yield (), {**interval, "upper": None, "ratio": [interval["ratio"][0], "inf"]}


def changed_lower(interval: dict[str, Any]) -> Iterator[Change]:
    if interval["lower"]:
        yield from ((("lower", "knots", *place), value) for place, value in changed_knots(interval["lower"]["knots"]))
        for pair in ([0, 1, 0], [0, 0, 1], [0, 0, 0], [0, 0, 2], [1, 0, 1], [1, 1, 0], [9, 0, 1], [0, 0, -1], [0, 1], None):
            yield ("lower", "pair"), pair
    proofs: list[Any] = [None, {}, {"pair": [0, 0, 1]}, {"pair": [0, 0, 1], "knots": ["1/2"], "more": 1}, []]
    for proof in proofs:
        yield ("lower",), proof
    yield (), {**interval, "lower": None, "ratio": ["1", interval["ratio"][1]]}


def changed_interval(interval: dict[str, Any]) -> Iterator[Change]:
    yield (), {**interval, "lower": None, "upper": None, "ratio": ["1", "inf"]}
    for side in ("upper", "lower"):
        level = Fraction(interval["levels"][side])
        for near in (level / 2, 2 * level, level + Fraction(1, 10**12), level - Fraction(1, 10**12), Fraction(0), Fraction(1)):
            yield ("levels", side), str(near)
    yield ("levels",), {"upper": interval["levels"]["lower"], "lower": interval["levels"]["upper"]}
    for i, end in enumerate(interval["ratio"]):
        if end != "inf":
            for part in (Fraction(-1, 50), Fraction(-1, 10**9), Fraction(1, 10**9), Fraction(1, 50)):
                yield ("ratio", i), str(Fraction(end) * (1 + part))
        for other in ("1", "1/2", "0", "inf", "-1"):
            yield ("ratio", i), other
    others: dict[str, list[Any]] = {
        "independent": [False],
        "ends": ["each", "together", "upper"],
        "region": ["box", "product", "contrasts", "paired"],
        "method": ["empirical-bernstein", "pair-exact", "betting"],
        "limits": [["0", "1"], ["0", "7/3"], ["1/2", "1"]],
        "confidence": ["9/10", "19/20", "96/100", "999/1000", "1/3", "1", "0", "2"],
    }
    yield from (((key,), other) for key, values in others.items() for other in values)
    yield (), {**interval, "split": {"seed": "0" * 64}}
    yield (), {**interval, "pair": [0, 0, 1]}
    yield (), {key: value for key, value in interval.items() if key != "lower"}


def changed_claim(claim: dict[str, Any]) -> Iterator[Change]:
    for method in ("binomial", "hoeffding-kl", "symmetric-betting", "T14"):
        yield ("by",), method
    yield ("scope",), "this law"
    yield ("value",), "2" if claim["value"] == "inf" else str(Fraction(claim["value"]) + Fraction(1, 10**6))
    yield ("value",), "1"
    yield ("evidence", "interval"), "local"
    for n in range(len(claim["assumptions"])):
        yield ("assumptions",), claim["assumptions"][:n] + claim["assumptions"][n + 1 :]


def changed_ladders(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text = json.dumps(document)
    for name, interval in document["intervals"].items():
        for changes in (changed_upper, changed_lower, changed_interval):
            yield from (put(text, ("intervals", name, *place), value) for place, value in changes(interval))
    for i, claim in enumerate(document["claims"]):
        if claim["by"] == "pair-exact":
            yield from (put(text, ("claims", i, *place), value) for place, value in changed_claim(claim))


def test_ladders_of_pairs(program: Path) -> None:
    """Intervals by pair-exact are judged, with all that is claimed of them, and what is altered as by the other checker."""
    documents_, tally = with_ladders(), Tally()
    for document, judged in zip(documents_, natively(program, [as_bytes(document) for document in documents_]), strict=True):
        assert {interval["region"] for interval in document["intervals"].values()} == {"pairs"}
        for label, true in judged.statements:
            if label.startswith("intervals") or "pair-exact" in label:
                means = "global" in label and document["subject"]["utility"]["depends_on_group"]  # their pools are not covered
                assert true is (None if means else True), label
    assert {interval["lower"] is None for document in documents_ for interval in document["intervals"].values()} == {True, False}
    assert {interval["upper"] is None for document in documents_ for interval in document["intervals"].values()} == {True, False}
    altered = [as_bytes(changed) for document in documents_ for changed in changed_ladders(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if tiers.FULL else altered[::12])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
    assert tally.codes[FALSE, OPEN] * 2 < tally.codes[FALSE, FALSE]


def test_ladders_of_many_draws(program: Path) -> None:
    """Of cells of ten thousands of draws ladders are judged; those of more draws than score ends are computed of are not."""
    found = []
    for thousands in (1, 20, 60):
        counts = [[[1000 * thousands, 1400 * thousands], [1300 * thousands, 1200 * thousands]]]
        result = fa.certify(fa.Law.from_array(counts, kind="counts"), {"0": 1}, confidence="19/20", independent=True)
        found.append(result.certificate.document)
    assert all(document["intervals"]["local"]["region"] == "pairs" for document in found)
    outcomes = [dict(judged.statements) for judged in natively(program, [as_bytes(document) for document in found])]
    assert [outcome["intervals.local"] for outcome in outcomes] == [True, True, None]
