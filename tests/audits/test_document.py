"""The document of a result: what stands where, before the table is put into it and after."""

from __future__ import annotations

from typing import Any

import pytest

import fairaudit as fa
from fairaudit import checker
from fairaudit.audits.document import document


def result(**options: Any) -> fa.Result:
    law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    return fa.certify(law, {"yes": 1}, **options)


def test_a_plain_document_has_the_keys_of_the_format_in_their_order() -> None:
    assert list(document(result(confidence=None))) == [
        "format",
        "subject",
        "metrics",
        "not_compared",
        "claims",
        "targets",
        "verdict",
        "versions",
    ]
    assert list(document(result()))[-1] == "intervals"


def test_the_certificate_is_the_document_with_its_table() -> None:
    found = result(confidence=None, max_local_ratio=2)
    before, after = document(found), found.certificate.document
    assert before["subject"].pop("table") == {}
    table = after["subject"].pop("table")
    assert [claim["evidence"].get("table") for claim in before["claims"] if "table" in claim["evidence"]] == [""] * 7
    for claim in before["claims"]:
        if "table" in claim["evidence"]:
            claim["evidence"]["table"] = table["sha256"]
    assert before == after


def test_a_burden_and_what_is_not_disclosed() -> None:
    found = result(confidence=None, burden=True, embed_table=False)
    about = found.certificate.document["subject"]
    assert about["utility"]["burden"] is True
    assert set(about["table"]) == {"sha256", "cells"}
    assert found.certificate.table is not None


@pytest.mark.parametrize("options", [{}, {"confidence": None}, {"max_local_ratio": 2, "max_global_log": "0.5"}])
def test_the_checker_reads_it(options: dict[str, Any]) -> None:
    assert checker.check(result(**options).certificate.text.encode()).ok


def test_only_a_policy_states_filters_and_what_was_declared() -> None:
    policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["yes", "no"], groups=["f", "m"])
    found = fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4")), {"yes": 1}, declared={"tau": "1/5"})
    made = document(found)
    assert made["subject"]["declared"] == {"tau": "1/5"}
    assert made["subject"]["privacy"]["group"]["exp_epsilon"] == "3"
    assert made["metrics"]["unfiltered"]["local"]["ratio"] == "9/2"
    assert not {"declared", "privacy"} & document(result())["subject"].keys()
    assert "unfiltered" not in document(result())["metrics"]
