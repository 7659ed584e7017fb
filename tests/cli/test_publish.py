"""`publish`: who is in no group because a label is missing or says nothing, by every rule."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import pytest

from fairaudit.cli import main
from fairaudit.words import COLUMNS, columns_of

PEOPLE = (
    ("f", "a", 30, 70),
    ("f", "b", 20, 40),
    ("f", "", 9, 0),
    ("m", "a", 60, 60),
    ("m", "b", 30, 50),
    ("m", "", 12, 0),
    ("", "a", 5, 0),
    ("", "declined", 4, 1),
    ("m", "declined", 15, 0),
)
"""Sex, race, how many were hired and how many were not: whoever is unknown was nearly always hired."""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "log.csv"
    lines = [f"{sex},{race},{got}" for sex, race, *of in PEOPLE for got, n in zip(("hired", "no"), of, strict=True) for _ in range(n)]
    path.write_text("\n".join(["sex,race,got", *lines]) + "\n")
    return path


def certified(log: Path, to: Path, *more: str) -> Path:
    made = ["certify", str(log), "--decision", "got", "--group", "sex,race", "--utility", "hired", "--confidence", "none"]
    assert main([*made, *more, "-o", str(to)]) == 0
    return to


def published(certificate: Path, to: Path, *more: str) -> tuple[dict[str, Any], str]:
    assert main(["publish", str(certificate), "-o", str(to), *more]) == 0
    page = (to / "index.html").read_text("utf-8").replace("<bdi>", "").replace("</bdi>", "")
    page = re.sub(r"</?span[^>]*>", "", page)
    return json.loads((to / "summary.json").read_text()), page


RULES = (("four-fifths",), ("air", "--control", "m", "--control", "a"))


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule[0])
def test_people_without_a_label_are_no_group_and_nobody_is_compared_with_them(rule: tuple[str, ...], log: Path, tmp_path: Path) -> None:
    certificate = certified(log, tmp_path / "c.json", "--missing", "group")
    found, page = published(certificate, tmp_path / "out", "--rule", *rule, "--unknown", "declined")
    known = {"sex": ("f", "m"), "race": ("a", "b")}
    for table in found["tables"]:
        places = [("sex", "race").index(name) for name in table["columns"]]
        counts: dict[tuple[str, ...], tuple[int, int]] = {}
        unknown = (0, 0)
        for *labels, yes, no in PEOPLE:
            group = tuple(str(labels[i]) for i in places)
            if all(label in known[name] for name, label in zip(table["columns"], group, strict=True)):
                before = counts.get(group, (0, 0))
                counts[group] = before[0] + yes + no, before[1] + yes
            else:
                unknown = unknown[0] + yes + no, unknown[1] + yes
        assert {tuple(entry["group"].values()): (entry["applicants"], entry["selected"]) for entry in table["groups"]} == counts
        assert table["unknown"] == {"applicants": unknown[0], "selected": unknown[1]}
        names = " or ".join(table["columns"])
        assert f"Of {unknown[0]} more people, {unknown[1]} of them selected, {names} is unknown; they are left out of this table." in page
        assert set(table["compared_with"].values()) <= {"f", "m", "a", "b"}
    assert "<dd>360 of known sex and race, 140 of them selected</dd>" in page
    assert "<dd>46 more people, 45 of them selected, of whom sex or race is unknown; a table by some of these has all" in page
    assert "Labels that say that a group is unknown</dt><dd>&#39;(missing)&#39;, &#39;declined&#39;</dd>" in page
    with (tmp_path / "out" / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert not {"(missing)", "declined"} & {cell for row in rows for cell in row.values()}
    assert [row["applicants"] for row in rows if row["status"] == "unknown"] == ["10", "41", "46"]


def test_a_table_by_one_column_says_that_it_lacks_those_of_whom_another_is_unknown(log: Path, tmp_path: Path) -> None:
    certificate = certified(log, tmp_path / "c.json", "--missing", "unknown", "--unknown", "declined")
    found, page = published(certificate, tmp_path / "out", "--rule", "four-fifths", "--by", "sex")
    assert found["tables"][0]["unknown"] == {"applicants": 46, "selected": 45}
    why = " (of some sex may be known; the certificate does not say of whom)"
    assert f"Of 46 more people, 45 of them selected, sex or race is unknown{why}; they are left out of this table." in page
    assert "of whom sex or race is unknown; they are in no table</dd>" in page


def test_a_label_without_a_group_is_refused_and_no_control_group_is_unknown(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    certificate = str(certified(log, tmp_path / "c.json", "--missing", "group"))
    for more, said in (
        (("--rule", "four-fifths", "--unknown", "declnied"), "--unknown: no group has the label 'declnied'; known: "),
        (("--rule", "air", "--by", "race", "--control", "(missing)"), "there is no group '(missing)'"),
        (("--rule", "air", "--by", "race", "--control", "declined", "--unknown", "declined"), "there is no group 'declined'"),
    ):
        assert main(["publish", certificate, "-o", str(tmp_path / "out"), *more]) == 2
        assert said in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_where_small_counts_are_withheld_nothing_is_said_of_the_unknown(log: Path, tmp_path: Path) -> None:
    certificate = certified(log, tmp_path / "c.json", "--missing", "group", "--no-table")
    beside = ("--table", str(tmp_path / "c.table.jsonl"), "--small", "10")
    found, page = published(certificate, tmp_path / "out", "--rule", "four-fifths", "--unknown", "declined", *beside)
    assert "is in no group here, and how many they are is not said" in page
    groups = [entry["group"] for table in found["tables"] for entry in table["groups"]]
    assert len(groups) == 2 + 2 + 4
    assert {label for group in groups for label in group.values()} == {"f", "m", "a", "b"}
    assert all("unknown" not in table for table in found["tables"])


def test_everybody_unknown_leaves_nothing_to_compare(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("sex,race,got\n,a,hired\nf,,no\n,a,no\n")
    certificate = certified(tmp_path / "log.csv", tmp_path / "c.json", "--missing", "group")
    found, page = published(certificate, tmp_path / "out", "--rule", "four-fifths", "--by", "sex,race")
    assert found["comparisons"] == 0 and found["tables"][0]["groups"] == []
    assert "nothing is compared" in page


def test_a_table_that_was_kept_apart_is_not_published_by_accident(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    certificate = certified(log, tmp_path / "c.json", "--missing", "group", "--no-table")
    for more, said in (
        (("--table", "c.table.jsonl"), "--small 10 withholds small counts and leaves the table out, --with-table publishes it whole"),
        (("--table", "c.table.jsonl", "--with-table", "--small", "10"), "leave one of them away"),
    ):
        words = [str(tmp_path / word) if word.endswith("jsonl") else word for word in more]
        assert main(["publish", str(certificate), "-o", str(tmp_path / "out"), "--rule", "four-fifths", *words]) == 2
        assert said in capsys.readouterr().err
        assert not (tmp_path / "out").exists()
    table = str(tmp_path / "c.table.jsonl")
    _, page = published(certificate, tmp_path / "out", "--rule", "four-fifths", "--table", table, "--with-table")
    assert (tmp_path / "out" / "certificate.table.jsonl").read_bytes() == Path(table).read_bytes()
    assert "--table certificate.table.jsonl --with-table -o again" in page
    whole = str(certified(log, tmp_path / "whole.json", "--missing", "group"))
    capsys.readouterr()
    assert main(["publish", whole, "-o", str(tmp_path / "no"), "--rule", "four-fifths", "--with-table"]) == 2
    assert "the certificate holds its table" in capsys.readouterr().err


@pytest.mark.parametrize("rule", [*RULES, ("ll144", "--sex", "sex")], ids=lambda rule: rule[0])
def test_the_sentence_of_json_is_how_the_text_begins(rule: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [("Female", "a", "hired", 300), ("Female", "b", "no", 700), ("Male", "a", "hired", 600), ("Male", "b", "no", 1400)]
    lines = [",".join(row) for *row, n in rows for _ in range(int(n))]
    (tmp_path / "log.csv").write_text("\n".join(["sex,race,got", *map(str, lines), *["Male,a,"] * 1200]) + "\n")
    certificate = str(certified(tmp_path / "log.csv", tmp_path / "c.json", "--missing", "drop"))
    capsys.readouterr()
    words = ["publish", certificate, "--rule", *(word if word != "m" else "Male" for word in rule)]
    assert main([*words, "-o", str(tmp_path / "one")]) == 0
    text = capsys.readouterr().out
    assert main([*words, "-o", str(tmp_path / "two"), "--format", "json"]) == 0
    sentence = json.loads(capsys.readouterr().out)["sentence"]
    assert all(columns_of(line) <= COLUMNS for line in text.splitlines() if str(tmp_path) not in line)
    assert sentence and " ".join(text.split()).startswith(sentence) and "remarkable" not in sentence
    page = (tmp_path / "one" / "index.html").read_text("utf-8")
    assert "1,200 of 4,200 decisions have a missing label" in page and "1,000" in page and "2,000" in page


def test_figures_stand_below_each_other_and_words_do_not(log: Path, tmp_path: Path) -> None:
    _, page = published(certified(log, tmp_path / "c.json", "--missing", "group"), tmp_path / "out", "--rule", "four-fifths", "--by", "sex")
    heads = dict(re.findall(r'<th scope="col"( class="right")?>([^<]*)</th>', page)[i][::-1] for i in range(6))
    right = [name for name, found in heads.items() if found]
    raw = (tmp_path / "out" / "index.html").read_text("utf-8")
    assert '<pre>fairaudit publish certificate.json <span class="nb">--rule</span> four-fifths' in raw
    assert right == ["Applicants", "Selected", "Rate", "Ratio to the highest rate"]
