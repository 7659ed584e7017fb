"""Verdicts on limits that are judged of a population: the verified program and the Python checker say the same of them.

One alteration in 20 in .ci/run; all: FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_verdicts.py
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tiers
from certificate_changes import put
from certificate_kinds import admissions, as_bytes
from verified_roads import FALSE, MALFORMED, OPEN, TRUE, Tally, in_python, natively

import fairaudit as fa

LIMITS: tuple[dict[str, Any], ...] = (
    {"max_local_ratio": "5/4"},
    {"max_global_ratio": "11/10"},
    {"max_local_ratio": "10", "max_local_log": "1/100"},
    {"max_local_log": "2", "max_global_log": "1"},
    {"max_local_ratio": "1", "max_local_log": "0", "max_global_ratio": "4/3", "max_global_log": "1/3"},
)
DRAWS = (
    "the draws within a cell are independent, each with the law of the cell, and how many there are does not depend on how they came out"
)
UNDER = (", whoever the unknown are", ", with the declared hidden context", ", within the declared drift", ", whatever the undecided meant")


def certain(**options: Any) -> fa.Result:
    """A group that gets nothing, beside one that gets all: ratios of the table are infinite."""
    return fa.certify(fa.Law.from_array([[[40, 0], [0, 40]], [[9, 31], [20, 20]]], kind="counts"), {"0": 1}, **options)


def alone(**options: Any) -> fa.Result:
    """One group in each context: nobody is compared within a context, and no interval of that ratio is stated."""
    return fa.certify(fa.Law.from_array([[[30, 10], [0, 0]], [[0, 0], [9, 31]]], kind="counts"), {"0": 1}, **options)


def written() -> Iterator[dict[str, Any]]:
    """As the package writes them, with ends that hold each by itself; and the same of cells that were drawn independently."""
    for make in (admissions, certain, alone):
        for limits in LIMITS:
            document = make(**limits, confidence="19/20").certificate.document
            yield document
            yield independently(document)


def independently(document: dict[str, Any]) -> dict[str, Any]:
    """The same evidence, which proves no less of independent cells; claims say that they rest on that."""
    changed = json.loads(json.dumps(document))
    for interval in changed.get("intervals", {}).values():
        interval["independent"] = True
    for claim in changed["claims"]:
        if DRAWS in claim["assumptions"]:
            claim["assumptions"].append("the draws of different cells are independent of each other")
    return changed


def together() -> Iterator[dict[str, Any]]:
    """Limits that are added to certificates whose ends hold together, two errors of 1/40 each, and further ones that spend no more."""
    document = admissions(confidence="39/40").certificate.document
    assert {interval["ends"] for interval in document["intervals"].values()} == {"together"}
    rows: tuple[tuple[str, str, str, str], ...] = (
        ("local", "ratio", "100", "within"),
        ("global", "ratio", "11/10", "exceeds"),
        ("local", "log", "1/10", "inconclusive"),
        ("global", "log", "1", "within"),
    )
    made = [target(*row) for row in rows]
    for chosen, verdict in ((made, "exceeds"), (made[::2], "inconclusive"), (made[3:], "within")):
        yield {**document, "targets": chosen, "verdict": verdict}


def target(quantity: str, unit: str, limit: str, verdict: str, confidence: str = "19/20") -> dict[str, Any]:
    judged = f"population at confidence {confidence}"
    return {"quantity": quantity, "limit": limit, "unit": unit, "judged": judged, "verdict": verdict}


def altered(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Every key of each target changed, targets taken away, repeated and added, other verdicts, other ends and confidences."""
    text, targets = json.dumps(document), document["targets"]
    for verdict in ("none", "within", "exceeds", "inconclusive", "depends", "changed", "true"):
        yield put(text, ("verdict",), verdict)
    for i, one in enumerate(targets):
        other: dict[str, tuple[Any, ...]] = {
            "quantity": ("local", "global", "local_difference"),
            "limit": ("1", "0", "1/2", "11/10", "5/4", "13/10", "2", "50", "1/1000", "9" * 40, "-1", "2/4", "inf", 2),
            "unit": ("ratio", "log", "difference"),
            "verdict": ("within", "exceeds", "inconclusive", "depends", "changed", "none"),
            "judged": (
                *(f"population at confidence {c}" for c in ("9/10", "39/40", "18/20", "0.95", "1", "0", "-1/2", "1/1000", "", "19/20 ")),
                *(f"{about}{under}" for about in ("this table", one["judged"]) for under in UNDER),
                *("this table", "population, one-sided at confidence 19/20", "population", "Population at confidence 19/20", ""),
            ),
        }
        for key, values in other.items():
            for value in values:
                yield put(text, ("targets", i, key), value)
        for key, value in (("estimand", "mean over units"), ("estimand", "mean"), ("tips", {}), ("more", 1)):
            yield put(text, ("targets", i), {**one, key: value})
        for rest in ([*targets[:i], *targets[i + 1 :]], [*targets, one], [one], targets[::-1]):
            yield put(text, ("targets",), rest)
        for quantity, unit in (("local", "ratio"), ("local", "log"), ("global", "ratio"), ("global", "log"), ("global", "difference")):
            for verdict, confidence in (("inconclusive", "19/20"), ("exceeds", "19/20"), ("inconclusive", "9/10"), ("exceeds", "1/2")):
                yield put(text, ("targets",), [*targets, target(quantity, unit, "5/4", verdict, confidence)])
    for c in ("1/10", "3/5", "99/100"):
        yield put(text, ("targets",), [{**one, "judged": f"population at confidence {c}"} for one in targets])
    yield put(text, ("targets",), [{**one, "judged": "this table"} for one in targets])
    yield put(text, ("targets",), [])
    yield put(text, ("subject", "kind"), "probabilities")
    intervals = document.get("intervals", {})
    for name, interval in intervals.items():
        for ends in (interval["ratio"][::-1], ["1", "inf"], ["1", interval["ratio"][1]], ["inf", "inf"], ["1", "1"], ["1/2", "3"]):
            yield put(text, ("intervals", name, "ratio"), ends)
        for key, value in (("ends", "each"), ("ends", "together"), ("confidence", "9/10"), ("confidence", "1/2"), ("region", "product")):
            yield put(text, ("intervals", name, key), value)
        yield put(text, ("intervals",), {other: intervals[other] for other in intervals if other != name})
        kept = [claim for claim in document["claims"] if claim["evidence"].get("interval") != name]
        yield {**document, "claims": kept}


def of_probabilities() -> Iterator[dict[str, Any]]:
    """Probabilities were drawn from no population, whatever kind of subject is stated."""
    law = fa.Law.from_array([[["1/2", "1/2"], ["1/4", "3/4"]]], kind="probabilities")
    document = fa.certify(law, {"0": 1}, max_local_ratio="5/4").certificate.document
    for verdict in ("inconclusive", "exceeds"):
        judged = {**document, "targets": [target("local", "ratio", "5/4", verdict)], "verdict": verdict}
        yield judged
        yield put(json.dumps(judged), ("subject", "kind"), "counts")


def documents() -> list[dict[str, Any]]:
    return [*written(), *together()]


def test_true_verdicts(program: Path) -> None:
    """All verdicts, in ratios and in nats, of both ratios, and that on all of them: none is left open, and labels are the same."""
    found = Counter[tuple[str, str, str]]()
    of_pairs = [admissions(**limits, confidence="19/20", independent=True).certificate.document for limits in LIMITS[1::2]]
    given = [*documents(), *of_pairs]
    for document, judged in zip(given, natively(program, [as_bytes(document) for document in given]), strict=True):
        assert ("verdict", True) in judged.statements
        said = [(label, true) for label, true in judged.statements if label.startswith("targets[")]
        assert said == [one for one in in_python(as_bytes(document)).statements if one[0].startswith("targets[")]
        assert len(said) == len(document["targets"])
        assert all(true for _, true in said)
        ends = {name: interval["ends"] for name, interval in document.get("intervals", {}).items()}
        found.update((one["verdict"], one["unit"], ends.get(one["quantity"], "none")) for one in document["targets"])
    units = ("ratio", "log")
    assert {*found} >= {(verdict, unit, "each") for verdict in ("within", "exceeds", "inconclusive") for unit in units}
    assert {ends for _, _, ends in found} == {"each", "together", "none"}
    whole = natively(program, [as_bytes(admissions(max_local_ratio="5/4").certificate.document)])
    assert whole[0].code == TRUE


def test_altered_verdicts(program: Path) -> None:
    tally, changes = Tally(), [as_bytes(changed) for document in documents() for changed in altered(document)]
    chosen = [*map(as_bytes, of_probabilities()), *(changes if tiers.FULL else changes[::20])]
    for first in range(0, len(chosen), 1000):  # so that a process judges a thousand documents
        tally.judge(program, chosen[first : first + 1000])
    print(len(changes), dict(tally.codes), dict(tally.open))
    assert tally.different[:3] == []
    assert {code for code, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
    assert {verified for python, verified in tally.codes if python == TRUE} <= {TRUE, OPEN}
