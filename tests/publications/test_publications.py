"""`fairaudit publish` as a whole: its answer, its files, and the three of them telling one story."""

from __future__ import annotations

import csv
import io
import json
import re
import shlex
from fractions import Fraction
from hashlib import sha256
from html import unescape
from pathlib import Path

import pytest
from envelopes import result_of

import fairaudit as fa
from fairaudit.cli import main

TABLE = {
    "out": ["y", "n"] * 4,
    "sex": ["f", "f", "f", "f", "m", "m", "m", "m"],
    "race": ["a", "a", "b", "b", "a", "a", "b", "b"],
    "n": [30, 70, 1, 9, 60, 40, 8, 2],
}


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    path = tmp_path / "c.json"
    fa.audit(TABLE, decision="out", group=["sex", "race"], count="n", utility="y", confidence=None).save(path)
    return path


def test_the_answer_names_the_files_and_holds_the_summary(certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["publish", str(certificate), "--rule", "four-fifths", "-o", str(tmp_path / "out"), "--format", "json"]) == 0
    found = result_of(capsys.readouterr().out)
    folder = Path(found["folder"])
    assert {entry["name"]: entry["sha256"] for entry in found["files"]} == {
        path.name: sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()
    }
    assert found["summary"] == json.loads((folder / "summary.json").read_text("ascii"))
    assert found["summary"]["certificate"]["sha256"] == sha256(certificate.read_bytes()).hexdigest()


def test_page_table_and_summary_have_the_same_figures(certificate: Path, tmp_path: Path) -> None:
    assert main(["publish", str(certificate), "--rule", "four-fifths", "-o", str(tmp_path / "out")]) == 0
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out" / "table.csv").read_text("utf-8"))))
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))
    page = (tmp_path / "out" / "index.html").read_text("utf-8").replace("\u00a0", " ")
    entries = [entry for table in summary["tables"] for entry in table["groups"]]
    assert len(rows) == len(entries) == 2 + 2 + 4
    for row, entry in zip(rows, entries, strict=True):
        assert (int(row["applicants"]), int(row["selected"])) == (entry["applicants"], entry["selected"])
        assert row["rate_exact"] == entry["rate"] == str(Fraction(entry["selected"], entry["applicants"]))
        assert row["ratio_exact"] == entry["ratio"]
        for shown in (row["rate"], row["ratio"]):
            assert f">{shown}<" in page
        if "findings" in entry:
            found = entry["findings"]
            for name in ("below_four_fifths", "fisher_p_at_most_1_20", "holm_p_at_most_1_20", "one_person"):
                assert row[name] == ("yes" if found[name] else "no")
            low, high = (Fraction(end) for end in found["fisher_p"])
            assert low * Fraction(999_999, 10**6) <= Fraction(row["fisher_p"]) <= high * Fraction(1_000_001, 10**6)
            assert row["squared_deviations_exact"] == found["squared_deviations"]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("--by age", "no group column of the certificate; known: 'sex', 'race'"),
        ("--by sex --favourable maybe", "there is no decision 'maybe'"),
        ("--control m", "--control belongs to --rule air"),
        ("--rule air", "name it with --control LABEL"),
        ("--rule air --control m", "no label of the column 'race'"),
        ("--rule other", "invalid choice: 'other'"),
        ("--table nowhere.jsonl", "cannot be read"),
    ],
)
def test_bad_options_are_one_sentence_and_leave_nothing(
    more: str, said: str, certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["publish", str(certificate), "--rule", "four-fifths", "-o", str(tmp_path / "out"), *more.split()])
    except SystemExit as stop:
        code = int(str(stop.code))
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert said in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["c.json"]


@pytest.mark.parametrize(
    "more", [[], ["--by", "race,sex", "--by=sex", "--favourable=-y z"], ["--rule", "air", "--control", "m", "--control", "race=a b"]]
)
def test_the_command_on_the_page_makes_the_same_files(more: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    table = {**TABLE, "out": ["-y z", "it's"] * 4, "race": [{"a": "a b"}.get(label, label) for label in TABLE["race"]]}  # type: ignore[call-overload]
    law = fa.Law.from_counts(table, decision="out", group=["sex", "race"], count="n")
    fa.certify(law, {"-y z": 1}, confidence=None, embed_table=False).certificate.save("c.json")
    assert main(["publish", "c.json", "--table", "c.table.jsonl", "--with-table", "--rule", "four-fifths", "-o", "out", *more]) == 0
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    found = re.search(r"<pre>fairaudit (publish .*)</pre>", re.sub(r"</?span[^>]*>", "", page))
    assert found
    monkeypatch.chdir(tmp_path / "out")
    assert main(shlex.split(unescape(found[1]))) == 0
    names = {path.name for path in (tmp_path / "out").iterdir()} - {"again"}
    assert names == {path.name for path in (tmp_path / "out" / "again").iterdir()}
    for name in names:
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "out" / "again" / name).read_bytes()
