"""Certificates of evaluation logs that are published: what was lost is said, and nothing is withheld that they disclose."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from evaluation_changes import audited, log_of

import fairaudit as fa
from fairaudit.cli import main

ROWS: list[tuple[Any, ...]] = [("A", "a", "age", 60), ("B", "a", "age", 40), ("A", "b", "age", 30), ("B", "b", "age", 60)]
LOG = log_of([*ROWS, ("refused", "b", "age", 10), ("error", "b", "age", 5)], errors="drop")


def test_lost_answers_are_published(tmp_path: Path) -> None:
    audited(LOG, utility={"A": 1, "refused": 0}).certificate.save(tmp_path / "c.json")
    assert main(["publish", str(tmp_path / "c.json"), "--rule", "four-fifths", "-o", str(tmp_path / "out")]) == 0
    text = (tmp_path / "out" / "index.html").read_text()
    assert "Lost answers: 15 of 205 decide nothing: 10 were refused, 5 ended in an error and were left out. By group: " in text
    assert "By group: b 15 of 105 (14.3 %), a 0 of 100 (0 %)." in text and "Most unequal" not in text
    assert "questions were drawn; epochs of a question count once" in text


def test_the_context_that_lost_most_unequally_is_named(tmp_path: Path) -> None:
    """Over all 10 of 110 beside 10 of 110; for loans 10 of 20 beside none. A table beside the certificate says the same."""
    cells = [("A", "a", "loan", 10), ("B", "a", "loan", 10), ("A", "b", "loan", 10), ("refused", "b", "loan", 10)]
    log = log_of([*cells, ("A", "a", "job", 80), ("refused", "a", "job", 10), ("B", "b", "job", 90)])
    for name, embedded in (("in", True), ("beside", False)):
        audited(log, utility={"A": 1, "refused": 0}, embed_table=embedded, confidence=None).certificate.save(tmp_path / f"{name}.json")
        words = ["publish", str(tmp_path / f"{name}.json"), "--rule", "four-fifths", "-o", str(tmp_path / name)]
        assert main([*words, *([] if embedded else ["--table", str(tmp_path / "beside.table.jsonl"), "--with-table"])]) == 0
        text = (tmp_path / name / "index.html").read_text()
        assert "Lost answers: 20 of 220 decide nothing" in text
        worst = "Most unequal within topic=loan: b 10 of 20 (50.0 %), a 0 of 20 (0 %)."
        assert (worst in text) == embedded


def test_nothing_is_withheld_that_the_certificate_discloses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    audited(LOG, utility={"A": 1, "refused": 0}, embed_table=False, confidence=None).certificate.save(tmp_path / "c.json")
    words = ["report", str(tmp_path / "c.json"), "--table", str(tmp_path / "c.table.jsonl"), "--small", "10"]
    assert main([*words, "-o", str(tmp_path / "p.html")]) == 2
    assert "--small does not go with an evaluation log" in capsys.readouterr().err


RULES = (["four-fifths"], ["air", "--control", "b"], ["ll144", "--race", "race"])


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("favourable", [[], ["--favourable", "A"]])
def test_what_decisions_meant_is_not_passed_over(
    rule: list[str], favourable: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At face value 30 of 100 beside 60 of 100 are below four fifths; had the 30 that were refused meant A, they would be 60."""
    rows = [("A", "a", "age", 60), ("B", "a", "age", 40), ("A", "b", "age", 30), ("B", "b", "age", 40), ("refused", "b", "age", 30)]
    audited(log_of(rows)).certificate.save(tmp_path / "c.json")
    assert main(["publish", str(tmp_path / "c.json"), "--rule", *rule, *favourable, "-o", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and "leaves open what the decision 'refused' meant" in err and "--utility" in err
    assert not (tmp_path / "out").exists()


def test_nor_in_a_report_for_the_public(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = {"d": ["yes", "no", "refused", "unread"] * 2, "g": ["f"] * 4 + ["m"] * 4, "n": [60, 40, 0, 12, 30, 40, 30, 11]}
    asked: dict[str, Any] = {"decision": "d", "group": "g", "count": "n", "utility": "yes", "embed_table": False}
    fa.audit(table, **asked, undecided=["refused", "unread"]).certificate.save(tmp_path / "c.json")
    words = [
        "report",
        str(tmp_path / "c.json"),
        "--table",
        str(tmp_path / "c.table.jsonl"),
        "--small",
        "10",
        "-o",
        str(tmp_path / "p.html"),
    ]
    assert main(words) == 2 and not (tmp_path / "p.html").exists()
    assert "leaves open what the decision 'refused' and 1 more meant" in capsys.readouterr().err
