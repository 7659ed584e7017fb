"""`subgroups` from a log to a certificate: published tables, every form of input, and what is refused."""

from __future__ import annotations

import csv
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from envelopes import SUBGROUPS, result_of
from jsonschema import Draft202012Validator
from subgroup_oracle import Case, worst

import fairaudit as fa
from fairaudit.attestations.verification import verify
from fairaudit.audits.subgroups import Subgroups, subgroups
from fairaudit.cli import main
from fairaudit.errors import InputError

ASKED: dict[str, Any] = {"decision": "hired", "attributes": ["sex", "region"], "utility": "yes", "count": "n", "min_rows": 10}

LOG = {"sex": ["f", "f", "m", "m"] * 2, "region": ["n", "s"] * 4, "hired": ["yes"] * 4 + ["no"] * 4, "n": [2, 7, 6, 3, 8, 3, 4, 7]}
"""The example of the theory page."""


def by_loops(path: Path, case: Any) -> Case:
    """A file of counts as rows."""
    attributes, decision, worth, count, least = case
    with path.open(newline="") as file:
        listed = [row for row in csv.DictReader(file) for _ in range(1 if count is None else int(row[count]))]
    log = [(tuple(row[name] for name in attributes), Fraction(worth.get(row[decision], 0))) for row in listed]
    return Case(attributes, log, 3, least, 10)


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("ucb_admissions.csv", (("Gender", "Dept"), "Admit", {"Admitted": 1}, "Freq", 46)),
        ("ucb_admissions.csv", (("Gender", "Dept"), "Admit", {"Rejected": 1}, "Freq", 1)),
        ("hiringbias_firstname.csv", (("model", "name"), "recommend_interview", {"yes": 1, "maybe": "1/2"}, None, 57)),
    ],
)
def test_published_tables_by_plain_loops(data: Path, name: str, asked: Any) -> None:
    case = by_loops(data / name, asked)
    attributes, decision, worth, count, least = asked
    found = subgroups(data / name, decision=decision, attributes=attributes, utility=worth, count=count, min_rows=least)
    expected = [(e.conditions, len(e.rows), Fraction(e.total, len(e.rows)), e.ratio, e.side, tuple(same)) for e, same in worst(case)]
    assert [(f.conditions, f.rows, f.mean, f.ratio, f.side, f.same) for f in found.found] == expected
    assert verify(found).ok


def test_the_example_of_the_page() -> None:
    found = subgroups(LOG, **ASKED)
    assert [(one.conditions, one.ratio) for one in found.found[:2]] == [
        ({"sex": "f", "region": "n"}, Fraction(8, 3)),
        ({"sex": "f", "region": "s"}, Fraction(21, 11)),
    ]
    assert found.conjunctions == 8
    assert found.mean == Fraction(18, 40)


def tables(folder: Path) -> list[Any]:
    """The example as a mapping, a frame, files, and a log without counts."""
    import pandas as pd

    frame = pd.DataFrame(LOG)
    frame.to_csv(folder / "counts.csv", index=False)
    rows = frame.loc[frame.index.repeat(frame["n"])].drop(columns="n")
    rows.to_csv(folder / "log.csv", index=False)
    rows.to_parquet(folder / "log.parquet")
    return [LOG, frame, folder / "counts.csv", rows, folder / "log.csv", folder / "log.parquet", [folder / "log.csv"]]


def test_every_form_of_a_log_gives_one_certificate(tmp_path: Path) -> None:
    documents = set()
    for i, table in enumerate(tables(tmp_path)):
        asked = ASKED if i < 3 else {name: value for name, value in ASKED.items() if name != "count"}
        for engine in ("auto", "python", "duckdb") if i in (4, 6) else ("auto",):
            documents.add(subgroups(table, **asked, engine=engine).certificate.text)
    assert len(documents) == 1


def test_intervals_of_numbers_missing_and_folded_labels_are_recorded() -> None:
    log = {
        "age": [17, 18, 25, 30, 40, 50] * 20,
        "sex": ["f", "F", "m", "", "m", "f"] * 20,
        "hired": ["yes", "no", "no", "yes", "no", "yes"] * 20,
    }
    asked: dict[str, Any] = {"decision": "hired", "attributes": ["age", "sex"], "utility": "yes", "bins": {"age": [18, 30]}}
    with pytest.raises(InputError, match="missing"):
        subgroups(log, **asked)
    dropped = subgroups(log, **asked, missing="drop", fold_labels=True)
    assert dropped.rows == 100
    assert {entry["step"] for entry in dropped.log.preparation} == {"intervals", "folded", "left out"}
    assert verify(dropped).ok
    Draft202012Validator(SUBGROUPS).validate(dropped.certificate.document)
    assert all("left out" in claim["assumptions"][-1] for claim in dropped.certificate.document["claims"])
    level = subgroups(log, **asked, missing="group")
    assert level.rows == 120
    assert verify(level).ok
    forged = json.loads(level.certificate.text)
    (entry,) = (entry for entry in forged["subject"]["preparation"] if entry["step"] == "level")
    entry["decisions"] = "21"
    assert not verify(forged).ok


def test_a_utility_column_may_vary_within_a_decision() -> None:
    log = {"a": ["x", "x", "y", "y"] * 10, "d": ["hit", "hit", "hit", "miss"] * 10, "score": [1, 3, 2, 0] * 10}
    found = subgroups(log, decision="d", attributes="a", utility_column="score")
    assert found.found[0].mean in (2, 1)
    assert found.ratio == 2
    assert verify(found).ok
    alone = subgroups(log, attributes="a", utility_column="score")
    assert alone.ratio == 2


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"min_rows": 0}, "whole number"),
        ({"min_rows": None, "min_share": 2}, "share between 0 and 1"),
        ({"min_share": "0.1"}, "do not go together"),
        ({"depth": 0}, "depth"),
        ({"top": 0}, "top"),
        ({"attributes": ["sex", "sex"]}, "used twice"),
        ({"attributes": []}, "no attribute"),
        ({"attributes": ["sex", "nothing"]}, "nothing"),
        ({"attributes": ["sex", "hired"]}, "used twice"),
        ({"utility": "yess"}, "yess"),
        ({"utility": None}, "no utility"),
        ({"max_ratio": -1}, "max_ratio"),
        ({"confidence": 2}, "confidence|between"),
        ({"min_rows": 41}, "no conjunction"),
    ],
)
def test_what_is_refused(change: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        subgroups(LOG, **{**ASKED, **change})


def test_counts_that_are_no_rows_are_refused() -> None:
    with pytest.raises(InputError, match="whole numbers"):
        subgroups({**LOG, "n": ["1/2"] * 8}, **ASKED)
    assert subgroups({**LOG, "n": [float(n) for n in LOG["n"]]}, **ASKED).ratio == Fraction(8, 3)


@pytest.mark.parametrize(("confidence", "limit", "verdict"), [(None, 3, "within"), (None, "5/2", "exceeds"), (0.95, 2, "inconclusive")])
def test_targets(confidence: float | None, limit: Any, verdict: str) -> None:
    found = subgroups(LOG, **ASKED, confidence=confidence, max_ratio=limit)
    assert found.verdict == verdict
    assert found.exit_code == {"within": 0, "exceeds": 1, "inconclusive": 3}[verdict]


def test_the_population_is_judged_by_the_whole_family() -> None:
    """Many rows put every subgroup within the target, though some were found to be most unequal."""
    found: Subgroups = subgroups({**LOG, "n": [500, 501, 502, 503, 500, 501, 502, 503]}, **ASKED, max_ratio="4/3")
    assert (found.verdict, len(found.everybody)) == ("within", 8)
    assert verify(found).ok


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, _, counts, *_ = tables(tmp_path)
    given = ["subgroups", str(counts), "--decision", "hired", "--attributes", "sex,region", "--count", "n", "--utility", "yes"]
    out = str(tmp_path / "c.json")
    assert main([*given, "--min-rows", "10", "--max-ratio", "0.4", "--confidence", "none", "-o", out]) == 1
    text = capsys.readouterr().out
    assert "EXCEEDS of the log" in text
    assert "sex=f, region=n" in text
    assert main(["verify", out]) == 0
    capsys.readouterr()
    assert main([*given, "--format", "json"]) == 0
    assert result_of(capsys.readouterr().out)["format"] == "fairaudit-subgroups/1"
    assert main([*given, "--min-share", "7"]) == 2
    assert "between 0 and 1" in capsys.readouterr().err
    assert main(["verify", "--export", str(tmp_path / "checker.pyz")]) == 0


def test_a_certificate_of_subgroups_is_no_other(tmp_path: Path) -> None:
    found = fa.subgroups(LOG, **ASKED)
    with pytest.raises(InputError):
        fa.compare(found.certificate, found.certificate)
