"""Differences that were asked for, from the table to the verdict: signs, shared errors, what is refused, and what is said."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from certificates import outcome

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.reports.markdown import markdown

F = Fraction
TABLE = {
    "answer": ["better", "same", "worse"] * 2,
    "sex": ["f"] * 3 + ["m"] * 3,
    "n": [300, 100, 50, 150, 100, 200],
}
SIGNED = {"better": 1, "worse": -1}
ROLES: dict[str, Any] = {"decision": "answer", "group": "sex", "count": "n"}


def audited(utility: Any = SIGNED, **options: Any) -> fa.Result:
    return fa.audit(TABLE, **ROLES, utility=utility, **options)


def test_a_utility_below_0_has_differences_and_nothing_of_ratios() -> None:
    result = audited(difference=True)
    assert result.differences is not None
    assert (result.local, result.global_, result.local_supremum, result.global_supremum) == (None,) * 4
    assert not result.intervals and not result.most_unequal_pairs()["local"] and result.tau == F(-50, 450)
    assert not any("ratio" in claim.quantity or claim.by in ("T5", "T6", "T7") for claim in result.claims)
    found = result.differences.measured["local"]
    assert found is not None and found.value == F(250, 450) + F(50, 450)
    assert any("ratios depend on the origin" in note for note in result.notes)
    assert outcome(json.loads(result.certificate.text)) == "true"


def test_ratios_stay_what_they_are_beside_differences() -> None:
    with_, without = audited({"better": 1}, difference=True), audited({"better": 1})
    assert (with_.local, with_.global_, with_.intervals) == (without.local, without.global_, without.intervals)
    assert without.differences is None and "local_difference" not in without.certificate.document["metrics"]
    assert [claim for claim in with_.claims if "difference" not in claim.quantity] == list(without.claims)


def test_limits_on_a_ratio_and_on_a_difference_share_the_error() -> None:
    one = audited({"better": 1}, max_difference="1/2")
    two = audited({"better": 1}, max_difference="1/2", max_local_ratio=3)
    three = audited({"better": 1}, max_difference="1/2", max_local_ratio=3, max_global_difference="1/2")
    confidences = [result.differences.intervals["local"].confidence for result in (one, two, three) if result.differences]
    assert confidences == [F(19, 20), 1 - F(1, 40), 1 - F(1, 60)]
    assert three.intervals["local"].confidence == 1 - F(1, 60)
    for result in (one, two, three):
        document = json.loads(result.certificate.text)
        assert outcome(document) == "true"
        interval = document["intervals"]["local_difference"]
        assert interval["ends"] == "each"
    document["targets"][0]["judged"] = "population at confidence 96/100".replace("96/100", "24/25")
    assert outcome(document) != "true"


@pytest.mark.parametrize(
    ("limit", "verdict", "confidence"),
    [("9/10", "within", 0.95), ("2/5", "exceeds", 0.95), ("2/3", "inconclusive", 0.95), ("2/3", "within", None), ("3/5", "exceeds", None)],
)
def test_verdicts(limit: str, verdict: str, confidence: float | None) -> None:
    result = audited(max_difference=limit, confidence=confidence)
    assert (result.verdict, result.targets[0].unit, result.targets[0].verdict) == (verdict, "difference", verdict)
    assert outcome(json.loads(result.certificate.text)) == "true"
    assert "sex=f" in result.sentence and "apart" in result.sentence


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "is negative; utilities are at least 0"),
        ({"max_local_ratio": 2, "difference": True}, "max_local_ratio limits a ratio, and utilities can be negative"),
        ({"max_difference": "-1"}, "max_difference is '-1'; a difference of at least 0"),
        ({"max_difference": "x"}, "max_difference: "),
        ({"max_global_difference": 1, "max_global_log": 1}, "max_global_log limits a ratio"),
    ],
)
def test_what_does_not_go_with_a_utility_below_0_is_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        audited(**options)


def test_a_range_below_0_leaves_intervals_to_differences() -> None:
    declared = {"gamma": 1, "m": -1}
    result = audited({"better": 1}, difference=True, declared=declared)
    assert result.local is not None and not result.intervals and result.differences is not None
    assert result.differences.comparisons["local"].cells[0].low == -1
    assert outcome(json.loads(result.certificate.text)) == "true"
    with pytest.raises(InputError, match="ratios depend on the origin"):
        audited({"better": 1}, difference=True, declared=declared, max_local_ratio=2)
    with pytest.raises(InputError, match="unless differences alone are asked for"):
        audited({"better": 1}, declared=declared)


def test_policies_behind_filters_have_differences_of_utilities_that_are_not_below_0() -> None:
    law = fa.Law.from_array([[40, 10], [20, 30]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    behind = fa.Policy(law).behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4"))
    result = fa.certify(behind, {"yes": 1}, difference=True, max_difference="1/2")
    assert result.differences is not None and result.differences.measured["local"] is not None
    assert result.differences.measured["local"].value == F(1, 2) * F(2, 5)
    assert result.differences.intervals["local"].region == "box"
    assert outcome(json.loads(result.certificate.text)) == "true"
    with pytest.raises(InputError, match="a policy behind filters needs utilities of at least 0"):
        fa.certify(behind, {"yes": 1, "no": -1}, difference=True)


def test_scores_of_a_column_need_their_range(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scores.csv"
    path.write_text("score,sex\n" + "".join(f"{v},{s}\n" for s in "fm" for v in ("-1.5", "0", "2", "-0.25", "1e0") * 6))
    options = ["certify", str(path), "--utility-column", "score", "--group", "sex"]
    assert main([*options]) == 2
    assert "column 'score', line 2: '-1.5' is negative" in capsys.readouterr().err
    assert main([*options, "--max-difference", "1"]) == 2
    assert "--utility-range LOW,HIGH" in capsys.readouterr().err
    out = tmp_path / "c.json"
    assert main([*options, "--max-difference", "4", "--utility-range", "-2,2", "-o", str(out)]) == 0
    document = json.loads(out.read_text())
    assert document["intervals"]["local_difference"]["limits"] == ["-2", "2"] and outcome(document) == "true"
    assert main([*options, "--difference", "--format", "json"]) == 0
    assert main([*options, "--difference", "--in-parts"]) == 2


def test_an_audit_file_can_ask_for_differences(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("answer,sex,n\nbetter,f,30\nworse,f,10\nbetter,m,20\nworse,m,20\n")
    head = '[law]\ntable = "log.csv"\ndecision = "answer"\ngroup = "sex"\ncount = "n"\n[utility]\nvalues = {better = 1, worse = -1}\n'
    path = tmp_path / "audit.toml"
    path.write_text(head)
    with pytest.raises(InputError, match="'worse' is negative"):
        fa.audit(path)
    for more in ("difference = true\n", '[targets]\nmax_difference = "1/2"\n'):
        path.write_text(head + more)
        found = fa.audit(path).differences
        assert found is not None and found.measured["local"] is not None and found.measured["local"].value == F(1, 2)
    path.write_text(head)
    assert fa.audit(path, difference=True).differences is not None


def test_units_that_have_several_rows_count_once() -> None:
    log = {"u": ["a", "a", "b", "a", "b", "b"] * 3, "g": ["f", "f", "f", "m", "m", "m"] * 3, "who": [str(i // 2) for i in range(18)]}
    result = fa.audit(log, decision="u", group="g", unit="who", utility={"a": 1, "b": -1}, max_difference=1)
    assert result.differences is not None and result.differences.intervals["local"].estimand == "mean over units"
    document = json.loads(result.certificate.text)
    assert document["targets"][0]["estimand"] == "mean over units" and outcome(document) == "true"


def test_text_and_reports_say_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", "--example", "ucb-admissions", "--max-difference", "0.3", "--independent-cells", "--two-sided"]) == 0
    said = capsys.readouterr().out
    assert "WITHIN       local difference at most 0.3: at least 0.083, at most 0.2665, each at 95 % (0.2035 in the table)" in said
    assert "local difference D  0.072 to 0.2785" in said
    result = audited(max_difference="4/5")
    text = markdown(result.certificate)
    assert "Difference within contexts" in text and "ratio" not in text.partition("###")[0]
    assert "local difference at most 0.8" in text
    page = tmp_path / "page.html"
    result.report(page)
    assert "ratios depend on the origin" in page.read_text() and "Pair by pair" not in page.read_text()
    assert "local difference" in result._repr_html_() and "local ratio" not in result._repr_html_()


def test_a_half_split_is_for_ratios_alone() -> None:
    table = {"u": ["yes", "no"] * 2, "g": ["f", "f", "m", "m"], "n": [90, 60, 40, 80]}
    asked: dict[str, Any] = {"decision": "u", "group": "g", "count": "n", "independent": True, "select": "half-split"}
    result = fa.audit(table, **asked, utility={"yes": 1}, difference=True, max_difference="1/2")
    document = json.loads(result.certificate.text)
    assert "split" in document["intervals"]["local"] and "split" not in document["intervals"]["local_difference"]
    assert outcome(document) == "true"
    document["intervals"]["local_difference"]["split"] = document["intervals"]["local"]["split"]
    assert outcome(document) != "true"
    with pytest.raises(InputError, match="select 'half-split' is for ratios"):
        fa.audit(table, **asked, utility={"yes": 1, "no": -1}, difference=True)
