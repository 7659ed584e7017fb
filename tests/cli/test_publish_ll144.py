"""`publish --rule ll144`: what is missing, contradicts itself or cannot be is refused in a sentence, and nothing is written."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main

TABLE: dict[str, Any] = {
    "sex": ["Male", "Male", "Female", "Female"],
    "race": ["White", "White", "Asian", "Asian"],
    "got": ["yes", "no", "yes", "no"],
    "n": [3, 1, 2, 2],
}


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("certificate") / "c.json"
    fa.audit(TABLE, decision="got", group=["sex", "race"], count="n", utility="yes", confidence=None).save(path)
    return path


def run(certificate: Path, to: Path, *more: str) -> int:
    return main(["publish", str(certificate), "--rule", "ll144", "--sex", "sex", "--race", "race", "-o", str(to), *more])


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--exclude-below-2-percent",), "go together"),
        (("--justification", "few"), "go together"),
        (("--exclude-below-2-percent", "--justification", " "), "--justification is empty"),
        (("--data-kind", "test"), "needs --test-data-explanation"),
        (("--test-data-explanation", "new"), "goes with --data-kind test"),
        (("--audit-date", "2026-02-30"), "a day such as"),
        (("--distribution-date", "yesterday"), "a day such as"),
        (("--period", "2026-01-01"), "START/END"),
        (("--period", "2026-01-02/2026-01-01"), "before it begins"),
        (("--period", "2025-01-01/2026-06-30", "--audit-date", "2026-01-15"), "one of them is wrong"),
        (("--tool", "a\nb"), "control character"),
        (("--tool", "x" * 5000), "at most 4096"),
        (("--tool-version", "1"), "goes with --tool"),
        (("--favourable", "maybe"), "no decision 'maybe'"),
        (("--class", "maybe"), "no decision 'maybe'"),
        (("--class", "yes,yes"), "twice"),
        (("--class", "yes", "--favourable", "yes"), "do not go together"),
        (("--categories", "nowhere.toml"), "no such file"),
        (("--control", "White"), "--control"),
    ],
)
def test_bad_options_are_refused_in_a_sentence(
    more: tuple[str, ...], said: str, certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code: int | str | None
    try:
        code = run(certificate, tmp_path / "out", *more)
    except SystemExit as stop:
        code = stop.code
    assert code == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_is_not_stated_is_a_finding_and_no_refusal(certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    late = ("--audit-date", "2024-01-15", "--distribution-date", "2026-02-01", "--period", "2022-01-01/2023-12-31")
    assert run(certificate, tmp_path / "out", *late) == 0
    found = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))["findings"]
    assert [
        any(part in text for text in found) for part in ("more than one year old", "more than one year: 2022", "The tool is not named")
    ] == [True] * 3
    page, printed = (tmp_path / "out" / "index.html").read_text("utf-8"), " ".join(capsys.readouterr().out.split())
    assert len(found) == 5
    assert all(text in page and f" - {text}" in printed for text in found)


def test_an_option_of_this_rule_goes_with_no_other(certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = ["publish", str(certificate), "--rule", "four-fifths", "-o", str(tmp_path / "out")]
    for more in (["--sex", "sex"], ["--class", "yes"], ["--exclude-below-2-percent"], ["--tool", "x"], ["--unknown-in", "complete"]):
        assert main([*other, *more]) == 2
        assert f"{more[0]} belongs to --rule ll144" in capsys.readouterr().err


def test_counts_of_many_digits_and_rows_of_zeros(tmp_path: Path) -> None:
    n = 10**10
    rows = [("Male", "White", n, n + 1), ("Female", "White", 0, 0), ("Female", "Asian", n - 1, n)]
    table: dict[str, Any] = {
        "sex": [row[0] for row in rows for _ in range(2)],
        "race": [row[1] for row in rows for _ in range(2)],
        "got": ["yes", "no"] * 3,
        "n": [value for row in rows for value in row[2:]],
    }
    fa.audit(table, decision="got", group=["sex", "race"], count="n", utility="yes", confidence=None).save(tmp_path / "c.json")
    assert run(tmp_path / "c.json", tmp_path / "out") == 0
    [sex, *_] = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))["parts"][0]["tables"]
    assert [row["rate"] for row in sex["categories"]] == [f"{n}/{2 * n + 1}", f"{n - 1}/{2 * n - 1}"]
    text = (tmp_path / "out" / "table.csv").read_text("utf-8")
    assert f"{n}/{2 * n + 1}" in text


def test_a_class_named_as_a_formula_and_all_rates_zero(tmp_path: Path) -> None:
    table: dict[str, Any] = {**TABLE, "got": ["=1+1", "no", "no", "no"], "n": [0, 4, 2, 2]}
    fa.audit(table, decision="got", group=["sex", "race"], count="n", utility="no", confidence=None).save(tmp_path / "c.json")
    assert run(tmp_path / "c.json", tmp_path / "out", "--class", "=1+1") == 0
    lines = (tmp_path / "out" / "table.csv").read_text("utf-8").splitlines()
    assert lines[1] == "'=1+1,sex,Male,,4,0,0.0 %,1.000,0,1,1/2,compared"
    assert "each impact ratio is 1" in (tmp_path / "out" / "index.html").read_text("utf-8")


def test_all_labels_without_a_category_are_named_with_a_block_to_fill_in(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    column, strange = "Race / Ethnicity", 'a"\\\u202e\n'
    table = {
        "sex": ["f", "f", "Male", "Male", "Male"],
        column: ["aian", "asain", strange, "White", "?"],
        "got": ["yes", "no", "yes", "no", "no"],
    }
    fa.audit(table, decision="got", group=["sex", column], utility="yes", confidence=None).save(tmp_path / "c.json")
    words = ["publish", str(tmp_path / "c.json"), "--rule", "ll144", "--sex", "sex", "--race", column, "--unknown", "?"]
    assert main([*words, "-o", str(tmp_path / "out")]) == 2
    first, block = capsys.readouterr().err.split("\n\n")
    assert first.count("\n") == 0 and "did you mean" not in first
    assert all(repr(label) in first for label in ("f", "aian", "asain", strange))
    assert f'["{column}"]' in block and "\u202e" not in block
    assert tomllib.loads(block) == {"sex": {"f": ""}, column: {"aian": "", "asain": "", strange: ""}}
    (tmp_path / "map.toml").write_text(block)
    assert main([*words, "--categories", str(tmp_path / "map.toml"), "-o", str(tmp_path / "out")]) == 2
    assert "no category of the rule" in capsys.readouterr().err
    filled = block.replace('"f" = ""', '"f" = "Female"').replace('= ""', '= "Asian"')
    (tmp_path / "map.toml").write_text(filled)
    assert main([*words, "--categories", str(tmp_path / "map.toml"), "-o", str(tmp_path / "out")]) == 0
    (tmp_path / "map.toml").write_text(filled.replace('["Race / Ethnicity"]', "[Race / Ethnicity]"))
    capsys.readouterr()
    assert main([*words, "--categories", str(tmp_path / "map.toml"), "-o", str(tmp_path / "no")]) == 2
    assert 'quote the names of columns and the labels: ["Race / Ethnicity"]' in capsys.readouterr().err


def test_the_headline_has_its_counts_and_few_people_are_remarked_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    people = {("Male", "White"): (1200, 3000), ("Female", "White"): (900, 3000), ("Male", "Asian"): (4, 5), ("Female", "Asian"): (0, 5)}
    rows = [(*group, got, n) for group, (s, of) in people.items() for got, n in (("yes", s), ("no", of - s))]
    table = dict(zip(("sex", "race", "got", "n"), map(list, zip(*rows, strict=True)), strict=True))
    fa.audit(table, decision="got", group=["sex", "race"], count="n", utility="yes", confidence=None).save(tmp_path / "c.json")
    assert run(tmp_path / "c.json", tmp_path / "out") == 0
    found = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))["findings"]
    printed = " ".join(capsys.readouterr().out.split())
    assert "is 0.000: Female, Asian (0 of 5) against Male, Asian (4 of 5)." in printed
    for said in (
        "The highest rate of the table race or ethnicity is that of 10 people (0.2 % of the table), Asian; all its",
        "The highest rate of the table sex and race or ethnicity is that of 5 people (0.1 % of the table), Male, Asian; all its",
        "(race or ethnicity: Asian | sex and race or ethnicity: Male, Asian; Female, Asian) have impact ratios here",
    ):
        assert any(said in text for text in found) and said in printed
    assert not any("the table sex is" in text for text in found)
    assert run(tmp_path / "c.json", tmp_path / "without", "--exclude-below-2-percent", "--justification", "ten people of 6,010") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "is 0.748: Female (900 of 3,005) against Male (1,204 of 3,005)." in printed
    assert "below 2 %" not in printed and "highest rate" not in printed


def test_a_level_of_nobody_is_no_category(tmp_path: Path) -> None:
    """A row without a label that counts 0: there is the level, and no step that says how many are in it."""
    log, made, out = (tmp_path / name for name in ("n.csv", "c.json", "out"))
    log.write_text("sex,hired,n\nMale,yes,50\nMale,no,50\nFemale,yes,44\nFemale,no,56\n,yes,0\n")
    options = ["--count", "n", "--decision", "hired", "--group", "sex", "--utility", "yes", "--missing", "group"]
    assert main(["certify", str(log), *options, "-o", str(made)]) == 0
    assert main(["publish", str(made), "--rule", "ll144", "--sex", "sex", "-o", str(out)]) == 0
    (table,) = json.loads((out / "summary.json").read_text("ascii"))["parts"][0]["tables"]
    assert {each["sex"]: each["impact_ratio"] for each in table["categories"]} == {"Female": "22/25", "Male": "1"}
