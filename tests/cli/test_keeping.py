"""A log that is counted, kept and certified in one step gives what two steps give, and leaves nothing where it fails."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import duckdb
import numpy as np
import pandas as pd
import pytest

import fairaudit as fa
from fairaudit.cli import main

ROLES = ["--decision", "u", "--group", "a", "--context", "age:18,40", "--truth", "y"]
ASKED = ["--utility", "yes", "--positive", "good", "--missing", "drop", "--max-local-ratio", "5/4"]
PLAIN = ["--decision", "u", "--group", "a", "--context", "age", "--truth", "y"]


def frame(day: int, rows: int = 300) -> pd.DataFrame:
    """The log of a day, with missing labels."""
    drawn = np.random.default_rng(day)
    columns = {"u": ["yes", "no", "no", None], "a": ["f", "m", "d", None], "y": ["good", "bad"]}
    held = {name: [values[i] for i in drawn.integers(0, len(values), rows)] for name, values in columns.items()}
    return pd.DataFrame({**held, "age": drawn.integers(10, 60, rows)})


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four days in several formats, of which two are tallies."""
    monkeypatch.chdir(tmp_path)
    for day in range(4):
        frame(day).to_csv(f"{day}.csv", index=False)
    frame(2).to_parquet("2.log.parquet")
    frame(2).to_json("2.jsonl", orient="records", lines=True)
    with duckdb.connect("2.db") as connection:
        connection.execute("create table log as from read_csv('2.csv', all_varchar=true)")
    pd.concat(map(frame, range(3))).to_csv("all.csv", index=False)
    for day in (0, 1):
        assert main(["tally", f"{day}.csv", *ROLES, "-o", f"{day}.parquet"]) == 0
    return tmp_path


def test_one_step_gives_what_two_steps_give_whatever_holds_the_log(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    expected = main(["certify", "all.csv", *ROLES, *ASKED, "-o", "all.json"])
    for log in (["2.csv"], ["2.log.parquet"], ["2.jsonl"], ["duckdb:2.db", "--table", "log"], ["2.csv", "--engine", "duckdb"]):
        assert main(["tally", *log, *ROLES, "-o", "two.parquet"]) == 0
        capsys.readouterr()
        assert (
            main(["certify", "[01].parquet", *log, *ROLES, *ASKED, "--keep", "2.parquet", "-o", "c.json", "--attest", "s.json"]) == expected
        )
        assert "note: 300 rows of " in capsys.readouterr().err
        assert Path("c.json").read_bytes() == Path("all.json").read_bytes()
        assert Path("2.parquet").read_bytes() == Path("two.parquet").read_bytes()
        Path("two.parquet").rename("2.parquet")
        words = json.loads(Path("s.json").read_text())["predicate"]["command"]
        assert main([*words, "--format", "json"]) == expected  # which the statement names, and which takes the tallies alone
        assert json.loads(capsys.readouterr().out)["result"] == json.loads(Path("all.json").read_text())
        assert fa.recount("c.json", "s.json", ["0.parquet", "1.parquet", "2.parquet"]).ok
        assert not fa.recount("c.json", "s.json", ["0.parquet", "1.parquet"]).ok
        Path("2.parquet").unlink()


def test_the_first_day_and_several_logs_of_one_day_are_kept(folder: Path) -> None:
    assert main(["certify", "all.csv", *ROLES, *ASKED, "-o", "all.json"]) in (0, 1, 3)
    assert main(["certify", "0.csv", *ROLES, *ASKED, "--keep", "first.parquet"]) in (0, 1, 3)
    assert Path("first.parquet").read_bytes() == Path("0.parquet").read_bytes()
    both = ["certify", "1.csv", "0.parquet", "2.csv", *ROLES, *ASKED, "--keep", "both.parquet", "-o", "c.json"]
    assert main(both) in (0, 1, 3)
    assert Path("c.json").read_bytes() == Path("all.json").read_bytes()
    tallies = ["certify", "0.parquet", "both.parquet", *PLAIN, *ASKED, "--count", "n", "-o", "d.json"]
    assert main(tallies) in (0, 1, 3) and Path("d.json").read_bytes() == Path("all.json").read_bytes()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("0.parquet 1.parquet --keep 2.parquet", "every file that is named is a tally; name the log, too"),
        ("0.parquet 2.csv --keep 2.csv", "2.csv does not end in .parquet"),
        ("0.parquet 2.csv --keep 0.parquet", "0.parquet is the table itself; name another file to write"),
        ("0.parquet 2.log.parquet --keep 2.log.parquet", "2.log.parquet is the table itself"),
        ("2.csv --keep none/2.parquet", "cannot be written: there is no directory none"),
        ("2.csv --keep 2.parquet -o c.json -o 2.parquet", "2.parquet"),
        ("0.parquet 2.csv --keep 2.parquet --context age:18", "age' is used twice|twice"),
        ("0.parquet missing.csv --keep 2.parquet", "missing.csv: there is no such file"),
        ("2.csv --keep 2.parquet --unit y", "--unit does not go with --keep: rows of one sampling unit may lie in several files"),
        ("2.csv --keep 2.parquet --probability y", "--probability does not go with --keep, which counts a log of one decision per row"),
        ("2.csv --keep 2.parquet --where u=yes", "--where does not go with --keep"),
        ("--example ucb-admissions --keep 2.parquet", "--example does not go with --keep"),
        ("audit.toml --keep 2.parquet", "--keep does not go with an audit file"),
        ("0.parquet 2.csv --count m --keep 2.parquet", "the counts are in column 'n' of 0.parquet and in column 'm' of 2.parquet"),
    ],
)
def test_wrong_uses_are_one_sentence_and_leave_nothing(folder: Path, words: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.read_bytes() for path in folder.iterdir()}
    capsys.readouterr()
    assert main(["certify", *shlex.split(words), *ROLES, *ASKED]) == 2
    out, err = capsys.readouterr()
    assert not out and err.count("\n") == 1 and any(part in err for part in said.split("|")), err
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_where_no_certificate_is_made_no_counts_are_kept(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(folder.iterdir())
    for more, said in (
        (["--missing", "error"], "the label is missing"),
        (["--utility", "perhaps"], "perhaps"),
        (["--group", "b"], "there is no column 'b'"),
    ):
        assert main(["certify", "0.parquet", "2.csv", *ROLES, *ASKED, *more, "--keep", "2.parquet", "-o", "c.json"]) == 2
        assert said in capsys.readouterr().err
        assert sorted(folder.iterdir()) == before
    roles = ["--decision", "u", "--group", "a", "--context", "age:18,41", "--truth", "y"]
    assert main(["certify", "0.parquet", "2.csv", *roles, *ASKED, "--keep", "2.parquet"]) == 2
    assert "0.parquet and 2.parquet were cut into different intervals" in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before


def test_contexts_are_read_in_parts_with_what_is_kept(folder: Path) -> None:
    asked = ["--utility", "yes", "--missing", "drop", "--confidence", "none", "--in-parts"]
    assert main(["certify", "0.parquet", "2.csv", *ROLES[:6], *asked, "--keep", "2.parquet", "-o", "kept.json"]) == 0
    assert main(["certify", "0.parquet", "2.parquet", *PLAIN[:6], *asked, "--count", "n", "-o", "parts.json"]) == 0
    assert Path("kept.json").read_bytes() == Path("parts.json").read_bytes()
