"""Classes of utilities and evidence that are not well formed."""

from typing import Any

import pytest
from class_certificates import FAMILY, SCHEMA, by_hand, claim_fault, entries
from plain_certificates import checker, false_statements, make, raw

ROW = {"terms": [[0, None, 0, "1"]], "bound": "5"}


MALFORMED = {
    "gamma 0": {"gamma": "0"},
    "m above gamma": {"m": "2"},
    "negative m": {"m": "-1"},
    "tau above gamma": {"tau": "2"},
    "negative tau": {"tau": "-1/4"},
    "tau_on": {"tau_on": "some"},
    "tau_on null": {"tau_on": None, "tau": None},
    "quantity": {"quantity": "local_ratio"},
    "blind": {"blind": 1},
    "lipschitz when blind": {"lipschitz": "1"},
    "negative lipschitz": {"blind": False, "lipschitz": "-1"},
    "infinite gamma": {"gamma": "inf"},
    "not in lowest terms": {"gamma": "2/2"},
    "unknown key": {"note": "x"},
    "not square": {"metric": [["0", "1"]]},
    "empty": {"metric": []},
    "one group far from itself": {"metric": [["1"]]},
    "too small": {"metric": [["0"]]},
    "too large": {"metric": [["0", "1", "1"], ["1", "0", "1"], ["1", "1", "0"]]},
    "asymmetric": {"metric": [["0", "1"], ["2", "0"]]},
    "zero distance": {"metric": [["0", "0"], ["0", "0"]]},
    "diagonal": {"metric": [["1", "1"], ["1", "0"]]},
    "negative distance": {"metric": [["0", "-1"], ["-1", "0"]]},
    "order of one": {"order": [["u0"]]},
    "order unknown": {"order": [["u0", "u7"]]},
    "rows group when blind": {"rows": [{"terms": [[0, 0, 0, "1"]], "bound": "5"}]},
    "rows without group": {"blind": False, "rows": [ROW]},
    "rows context": {"rows": [{"terms": [[2, None, 0, "1"]], "bound": "5"}]},
    "rows decision": {"rows": [{"terms": [[0, None, 2, "1"]], "bound": "5"}]},
    "rows negative": {"rows": [{"terms": [[0, None, -1, "1"]], "bound": "5"}]},
    "rows boolean": {"rows": [{"terms": [[False, None, 0, "1"]], "bound": "5"}]},
    "rows number": {"rows": [{"terms": [[0, None, 0, 1]], "bound": "5"}]},
    "rows bound": {"rows": [{"terms": [], "bound": "inf"}]},
    "rows cell": {"blind": False, "rows": [{"terms": [[0, 2, 0, "1"]], "bound": "5"}]},
    "family names": {"family": FAMILY | {"names": ["t", "t"]}},
    "family no names": {"family": FAMILY | {"names": [], "lower": [], "upper": [], "features": [[[], []]] * 4}},
    "family ends": {"family": FAMILY | {"lower": ["2"]}},
    "family lengths": {"family": FAMILY | {"upper": ["1", "1"]}},
    "family cells": {"family": FAMILY | {"features": [[["1"], ["0"]]] * 3}},
    "family decisions": {"family": FAMILY | {"features": [[["1"]]] * 4}},
    "family features": {"family": FAMILY | {"features": [[["1"], ["0", "1"]]] * 4}},
    "family not blind": {"family": FAMILY | {"features": [[["1"], ["0"]]] * 3 + [[["1"], ["1"]]]}},
    "family rows": {"family": FAMILY | {"rows": [{"coefficients": [], "bound": "1"}]}},
}


@pytest.mark.parametrize("name", MALFORMED)
def test_malformed_classes(name: str) -> None:
    document = by_hand(**MALFORMED[name])
    document["claims"].pop()
    with pytest.raises(checker.FormatError, match=r"subject\.class"):
        checker.check(raw(document))


def test_metric() -> None:
    weights = {(0, a): ["1", "1"] for a in range(3)}
    document = make(weights, ["1", "0"])
    far = [["0", "1", "{d}"], ["1", "0", "1"], ["{d}", "1", "0"]]
    for d, true in [("2", True), ("2000000001/1000000000", False), ("1/2", True), ("0", False)]:
        metric = [[e.replace("{d}", d) for e in row] for row in far]
        document["subject"]["class"] = by_hand(blind=False, lipschitz="1", metric=metric)["subject"]["class"]
        if true:
            assert false_statements(document) == []
        else:
            with pytest.raises(checker.FormatError, match="metric"):
                checker.check(raw(document))


@pytest.mark.parametrize(
    "evidence",
    [
        {"pairs": [], "theta": []},
        {"pairs": [], "multipliers": []},
        {"multipliers": ["1"]},
        {},
        {"pairs": [{"higher": 0, "lower": 1, "multipliers": []}]},
        entries((0, 1, 0, []), (0, 0, 1, [])),
        entries((0, 0, 1, []), (0, 0, 1, [])),
        entries((0, 0, 1, [[0, "0"]])),
        entries((0, 0, 1, [[0, "-1"]])),
        entries((0, 0, 1, [[0, "inf"]])),
        entries((0, 0, 1, [[-1, "1"]])),
        entries((0, 0, 1, [[True, "1"]])),
        entries((0, 0, 1, [["0", "1"]])),
        entries((0, 0, 1, [[0, 1]])),
        entries((0, 0, 1, [[1, "1"], [0, "1"]])),
        entries((0, 0, 1, [[1, "1"], [1, "1"]])),
        entries((0, 0, 1, [[1]])),
        entries((None, 0, 1, [])),
        entries((-1, 0, 1, [])),
        entries((0, 0, -1, [])),
    ],
)
def test_malformed_evidence(evidence: Any) -> None:
    for value in ("3", "inf"):
        with pytest.raises(checker.FormatError, match="evidence"):
            checker.check(raw(by_hand(value, by="lp-dual", evidence=evidence)))
    for wrong in ({"multipliers": ["-1"]}, {"multipliers": ["inf"]}, {"pairs": []}, {"multipliers": ["1"], "theta": ["1"]}):
        with pytest.raises(checker.FormatError, match="evidence"):
            checker.check(raw(by_hand(evidence=wrong)))


def test_malformed_theta() -> None:
    for evidence in ({"pairs": []}, {"pairs": [], "theta": []}, {"pairs": [], "theta": ["1", "1"]}, {"pairs": [], "theta": [1]}):
        with pytest.raises(checker.FormatError, match="theta"):
            checker.check(raw(by_hand("4", by="lp-dual", evidence=evidence, family=FAMILY)))


def test_constraints_that_do_not_exist() -> None:
    for number, true in [(0, True), (1, True), (2, False), (10**17, False)]:
        document = by_hand(by="lp-dual", evidence=entries((0, 0, 1, [[number, "1/1000000"]]), (0, 1, 0, [])))
        assert ("there is no constraint" in claim_fault(document)) != true


def test_policies_have_no_class() -> None:
    document = by_hand()
    document["subject"] |= {"kind": "policy", "population": "equal", "privacy": {}, "declared": {}}
    with pytest.raises(checker.FormatError, match="class"):
        checker.check(raw(document))
    assert list(SCHEMA.iter_errors(document))
