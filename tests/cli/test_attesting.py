"""`certify --attest`: a statement beside the certificate, of every kind of table, or nothing at all."""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import sqlite3
import subprocess
import sys
import threading
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from needs import POSIX

from fairaudit import __version__
from fairaudit.attestations.options import reading_of
from fairaudit.attestations.statement import Statement, read_statement
from fairaudit.cli import attesting, main
from fairaudit.tables.examples import example

ROLES = ["--decision", "answer", "--group", "sex", "--utility", "yes"]

LOG = "answer,sex\n" + "yes,f\nno,f\nyes,f\nyes,m\nno,m\nno,\n"  # 6 decisions, of which one has no group

COUNTS = "answer,sex,n\nyes,f,5/2\nno,f,1\nyes,m,4\nno,m,2\nyes,,3\n"

POLICY = "answer,sex,p\nyes,f,0.9\nno,f,0.1\nyes,m,0.4\nno,m,0.6\n"

AUDIT = """
[law]
table = "data/log.csv"
map = "names.toml"
decision = "answer"
group = "sex"
missing = "drop"
[utility]
values = { yes = 1, map = "0/1" }
[attestation]
issuer = "Example Audits"
title = "From the file"
"""


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "log.csv").write_text(LOG)
    (tmp_path / "data" / "counts.csv").write_text(COUNTS)
    (tmp_path / "data" / "policy.csv").write_text(POLICY)
    (tmp_path / "names.toml").write_text('[answer]\n"no" = "nein"\n')
    (tmp_path / "audit.toml").write_text(AUDIT)
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def attested(folder: Path, *words: str, code: int = 0) -> Statement:
    """Certify with a statement, and check what every statement has to say."""
    before = datetime.now(UTC).replace(microsecond=0)
    assert main(["certify", *words, "-o", str(folder / "out" / "c.json"), "--attest", str(folder / "out" / "a.json")]) == code
    raw = (folder / "out" / "a.json").read_bytes()
    made = read_statement(raw)
    document = json.loads((folder / "out" / "c.json").read_bytes())
    assert [(subject.name, subject.sha256) for subject in made.subjects] == [("c.json", digest(folder / "out" / "c.json"))]
    assert made.table == document["subject"]["table"]["sha256"]
    assert made.rows.add_up
    assert before <= datetime.fromisoformat(made.issued_at) <= datetime.now(UTC)
    assert made.versions == {"fairaudit": __version__}
    assert str(folder).encode() not in raw
    table = folder / "out" / "c.table.jsonl"
    beside = ["--table", str(table)] if table.exists() else []
    checked = ["verify", str(folder / "out" / "c.json"), *beside, "--attestation", str(folder / "out" / "a.json")]
    assert main(checked) == 0
    if made.options and "pipe" not in words:  # which can be read only once
        files = words[: next((i for i, word in enumerate(words) if word.startswith("--")), len(words))]
        query = words[words.index("--query") :][:2] if "--query" in words else ()
        listed = files or [str(example("ucb-admissions").path)]
        assert main([*checked, "--recount", *listed, *query]) == 0
    return made


def test_a_log_with_everything_that_is_stated(folder: Path) -> None:
    said = ["--issuer", "Ä. Auditor", "--contact", "a@example.org", "--title", "Hiring", "--system", "ranker", "--system-version", "3"]
    made = attested(folder, str(folder / "data/log.csv"), *ROLES, "--missing", "drop", *said, "--period", "2025-01-01/2025-12-31")
    [source] = made.sources
    assert (source.name, source.sha256, source.bytes, source.rows) == ("log.csv", digest(folder / "data/log.csv"), len(LOG), 6)
    assert (made.rows.unit, made.rows.read, made.rows.counted, made.rows.dropped) == ("decisions", 6, 5, {"missing label": 1})
    assert made.options == {"decision": "answer", "group": ["sex"], "utility": {"yes": "1"}, "missing": "drop"}
    assert made.command[:4] == ("certify", "log.csv", "--decision", "answer")
    assert (made.stated.issuer, made.stated.contact, made.stated.title) == ("Ä. Auditor", "a@example.org", "Hiring")
    assert (made.stated.system, made.stated.system_version, made.stated.period) == ("ranker", "3", ("2025-01-01", "2025-12-31"))


def test_the_next_step_checks_the_statement_too(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["certify", "data/log.csv", *ROLES, "--missing", "drop", "--no-table", "-o", "out/c.json", "--attest", "out/a b.json"]
    assert main(words) == 0
    assert "fairaudit verify out/c.json --table out/c.table.jsonl --attestation 'out/a b.json'" in capsys.readouterr().out


def test_unknown_groups_are_counted(folder: Path) -> None:
    made = attested(folder, "data/log.csv", *ROLES, "--missing", "unknown")
    assert (made.rows.read, made.rows.counted, made.rows.dropped) == (6, 6, {})


def test_counts_may_be_fractions(folder: Path) -> None:
    made = attested(folder, "data/counts.csv", *ROLES, "--count", "n", "--missing", "drop")
    assert (made.rows.read, made.rows.counted, made.rows.dropped) == (12.5, 9.5, {"missing label": 3})
    assert made.sources[0].rows is None  # how many rows made the three decisions that were dropped, nobody counted
    assert attested(folder, "data/counts.csv", *ROLES, "--count", "n", "--missing", "group").sources[0].rows == 5


def test_probabilities_are_rows(folder: Path) -> None:
    made = attested(folder, "data/policy.csv", *ROLES, "--probability", "p")
    assert (made.rows.unit, made.rows.read, made.rows.counted, made.sources[0].rows) == ("rows", 4, 4, 4)
    (folder / "data" / "policy.csv").write_text(POLICY + "yes,,0.5\n")
    made = attested(folder, "data/policy.csv", *ROLES, "--probability", "p", "--missing", "drop")
    assert (made.rows.read, made.rows.counted, made.rows.dropped, made.sources[0].rows) == (5, 4, {"missing label": 1}, 5)


def test_scores_are_recorded_with_what_being_above_is_worth(folder: Path) -> None:
    (folder / "scores.csv").write_text("score,sex\n1,f\n2,f\n3,m\n4,m\n2.5,f\n")
    made = attested(folder, "scores.csv", "--score", "score", "--above-median", "--group", "sex")
    assert made.options == {"score": {"column": "score", "above": "median"}, "group": ["sex"], "utility": {"above": "1"}}
    assert (made.rows.counted, made.sources[0].rows) == (5, 5)


def test_columns_of_counts(folder: Path) -> None:
    (folder / "wide.csv").write_text("sex,hired,rejected\nf,3,4\nm,5,6\n")
    made = attested(folder, "wide.csv", "--group", "sex", "--wide", "yes=hired,no=rejected", "--utility", "yes")
    assert (made.rows.unit, made.rows.counted, made.sources[0].rows) == ("decisions", 18, None)
    assert made.options["wide"] == "yes=hired,no=rejected"


def test_several_files_and_a_pattern(folder: Path) -> None:
    (folder / "data" / "more.csv").write_text(LOG + "\n")
    made = attested(folder, "data/log.csv", str(folder / "data/m*.csv"), *ROLES, "--missing", "drop")
    assert [(source.name, source.rows) for source in made.sources] == [("log.csv", None), ("more.csv", None)]
    assert made.rows.read == 12
    assert made.command[1:3] == ("log.csv", "m*.csv")


def test_files_of_other_forms(folder: Path) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"answer": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]})
    frame.to_parquet(folder / "log.parquet")
    (folder / "log.jsonl").write_text("".join(json.dumps(row) + "\n" for row in frame.to_dict("records")))
    (folder / "log.csv.gz").write_bytes(gzip.compress(frame.to_csv(index=False).encode()))
    for name in ("log.parquet", "log.jsonl", "log.csv.gz"):
        [source] = attested(folder, name, *ROLES).sources
        assert (source.name, source.sha256, source.rows) == (name, digest(folder / name), 4)
        assert source.bytes == (folder / name).stat().st_size


def test_a_log_in_parts(folder: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pandas.DataFrame({"answer": list("ynyn"), "sex": list("ffmm"), "shop": list("aaaa")}).to_parquet(folder / "log.parquet")
    made = attested(folder, "log.parquet", "--decision", "answer", "--group", "sex", "--context", "shop", "--utility", "y", "--in-parts")
    assert (made.rows.read, made.sources[0].rows, made.sources[0].sha256) == (4, 4, digest(folder / "log.parquet"))
    assert made.options == {"decision": "answer", "group": ["sex"], "context": ["shop"], "utility": {"y": "1"}}


def test_a_log_that_turns_out_to_be_read_in_parts(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pandas = pytest.importorskip("pandas")
    shops = [f"s{i}" for i in range(20)]
    frame = pandas.DataFrame({"answer": ["yes", "no"] * 40, "sex": ["f", "m", "m", "f"] * 20, "shop": shops * 4})
    frame.to_parquet(folder / "log.parquet")
    monkeypatch.setattr("fairaudit.audits.reading.MOST_ROWS", 10)
    made = attested(folder, "log.parquet", *ROLES, "--context", "shop")
    assert [*folder.rglob("*.table.jsonl")]
    assert (made.rows.read, made.sources[0].rows) == (80, 80)
    assert made.options == {"decision": "answer", "group": ["sex"], "context": ["shop"], "utility": {"yes": "1"}}


def test_databases_have_a_query_and_no_digest(folder: Path) -> None:
    with sqlite3.connect(folder / "data" / "log.db") as connection:
        connection.execute("create table log (answer text, sex text)")
        connection.executemany("insert into log values (?, ?)", [("yes", "f"), ("no", "f"), ("no", "m")])
    connection.close()
    url = f"sqlite:{folder}/data/log.db"
    [source] = attested(folder, url, *ROLES, "--table", "log").sources
    assert (source.name, source.sha256, source.bytes, source.rows) == ("sqlite:log.db", None, None, 3)
    assert (source.table, source.query) == ("log", None)
    made = attested(folder, url, *ROLES, "--query", "SELECT * FROM log WHERE sex <> 'x'")
    assert made.sources[0].query == made.options["query"] == "SELECT * FROM log WHERE sex <> 'x'"
    assert made.command[1] == "sqlite:log.db"


def test_a_server_is_not_named(folder: Path, postgres: str) -> None:
    words = ["--decision", "answer", "--group", "sex", "--utility", "yes", "--table", "logs.Decisions", "--confidence", "none"]
    made = attested(folder, postgres, *words)
    [source] = made.sources
    assert (source.name, source.sha256, source.rows, source.table) == ("postgresql:postgres", None, 400, "logs.Decisions")
    raw = (folder / "out" / "a.json").read_text()
    assert not any(secret in raw for secret in ("auditor", "secret", "127.0.0.1"))


def test_an_audit_file_and_what_it_names(folder: Path) -> None:
    made = attested(folder, "audit.toml", "--title", "From the option")
    assert [(s.name, s.sha256, s.rows) for s in made.sources] == [
        ("log.csv", digest(folder / "data/log.csv"), 6),
        ("audit.toml", digest(folder / "audit.toml"), None),
        ("names.toml", digest(folder / "names.toml"), None),
    ]
    assert (made.stated.issuer, made.stated.title) == ("Example Audits", "From the option")
    assert list(made.options) == ["audit"]
    assert made.options["audit"]["law"]["table"] == "log.csv"
    assert made.options["audit"]["utility"]["values"] == {"yes": 1, "map": "0/1"}  # a decision of that name is no file
    assert "attestation" not in made.options["audit"]
    assert (made.rows.read, made.rows.counted) == (6, 5)


@pytest.mark.parametrize(("column", "unit", "counted"), [("probability", "rows", 4), ("count", "decisions", 100)])
def test_a_policy(folder: Path, column: str, unit: str, counted: int) -> None:
    weights = POLICY if column == "probability" else "answer,sex,p\nyes,f,40\nno,f,10\nyes,m,30\nno,m,20\n"
    (folder / "data" / "policy.csv").write_text(weights)
    (folder / "filter.csv").write_text("input,f,m\nf,0.7,0.3\nm,0.3,0.7\n")
    filters = '[filter.group]\nkind = "table"\ntable = "filter.csv"\n'
    text = AUDIT.replace("law]", "policy]").replace("log.csv", "policy.csv").replace("[utility]", f'{column} = "p"\n{filters}[utility]')
    (folder / "audit.toml").write_text(text)
    made = attested(folder, "audit.toml")
    assert (made.rows.unit, made.rows.counted) == (unit, counted)
    assert [s.name for s in made.sources] == ["policy.csv", "audit.toml", "names.toml", "filter.csv"]
    assert made.sources[0].rows == 4


def test_an_example(folder: Path) -> None:
    made = attested(folder, "--example", "ucb-admissions")
    assert (made.rows.read, made.sources[0].name, made.sources[0].rows) == (4526, "ucb-admissions.csv", 24)
    assert made.command[:3] == ("certify", "--example", "ucb-admissions")
    assert reading_of(made.options)[0].count == "Freq"


def test_groups_that_were_not_recorded(folder: Path) -> None:
    (folder / "log.csv").write_text("answer,area\n" + "yes,1\nno,1\nyes,2\nno,2\nno,2\n")
    (folder / "given.csv").write_text("area,race,probability\n1,a,0.9\n1,b,0.1\n2,a,0.2\n2,b,0.8\n")
    roles = ["--decision", "answer", "--group", "race", "--utility", "yes", "--group-probability", "given.csv"]
    made = attested(folder, "log.csv", *roles)
    assert [source.name for source in made.sources] == ["log.csv", "given.csv"]
    assert (made.rows.unit, made.rows.read, made.options) == ("decisions", 5, {})


def test_what_a_monitor_counted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [json.dumps({"answer": u, "sex": a}) for u, a in [("yes", "f"), ("no", "f"), ("yes", "m"), ("no", "m")] * 5]
    (folder / "log.jsonl").write_text("\n".join([*lines, "nothing"]) + "\n")
    monitor = ["monitor", "log.jsonl", *ROLES, "--max-local-ratio", "3", "--state", "state.db"]
    assert main(monitor) in (0, 3)
    made = attested(folder, "--from-monitor", str(folder / "state.db"), code=3)
    assert [(source.name, source.sha256, source.rows) for source in made.sources] == [("state.db", None, None)]
    assert (made.rows.read, made.rows.counted, made.rows.dropped, made.options) == (21, 20, {"unreadable line": 1}, {})


@pytest.mark.parametrize(
    ("monitor", "certify"),
    [(["--event-id", "id"], []), (["--unit", "id"], []), (["--max-local-ratio", "1.0001", "--confidence", "0.1"], ["--at-alarm"])],
)
def test_what_a_monitor_left_out_is_not_passed_over(
    folder: Path, capsys: pytest.CaptureFixture[str], monitor: list[str], certify: list[str]
) -> None:
    rows = [("yes", "f"), ("no", "f"), ("yes", "m"), ("no", "m")] * 3 + [("yes", "f"), ("no", "m")] * 40
    lines = [json.dumps({"answer": u, "sex": a, "id": i % 80}) for i, (u, a) in enumerate(rows)]
    (folder / "log.jsonl").write_text("\n".join(lines) + "\n")
    limits = [] if certify else ["--max-local-ratio", "3"]
    assert main(["monitor", "log.jsonl", *ROLES, *limits, "--state", "state.db", *monitor]) in (0, 1, 3)
    assert main(["certify", "--from-monitor", "state.db", *certify, *WITH]) == 2
    assert "--attest says how much was read" in capsys.readouterr().err
    assert not any((folder / "out").iterdir())


def test_every_file_or_none(folder: Path) -> None:
    (folder / "out" / "a.json").mkdir()
    words = ["certify", "data/log.csv", *ROLES, "--missing", "drop", "-o", "out/c.json", "-o", "out/page.md", "--attest", "out/a.json"]
    assert main(words) == 2
    assert not (folder / "out" / "c.json").exists()
    (folder / "out" / "a.json").rmdir()
    assert main(words) == 0
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["a.json", "c.json", "page.md"]


KILLED = """
import os, signal, sys
from fairaudit.cli import main
sys.addaudithook(lambda event, words: event == "os.rename" and str(words[1]).endswith("/c.json") and os.kill(os.getpid(), signal.SIGKILL))
main(sys.argv[1:])
"""


@POSIX
def test_a_command_that_is_killed_leaves_no_certificate_without_its_attestation(folder: Path) -> None:
    words = ["certify", "data/log.csv", *ROLES, "--missing", "drop", *WITH, "--no-table"]
    done = subprocess.run([sys.executable, "-c", KILLED, *words], capture_output=True, check=False)
    assert done.returncode == -9, done.stderr
    assert {path.name for path in (folder / "out").iterdir() if not path.name.endswith(".part")} == {"a.json", "c.table.jsonl"}


@pytest.mark.parametrize(
    "url",
    ["Postgresql://me:hush@h/x", "postgres:/me:hush@h/x", "postgresql://h/x?user=me&password=hush", "POSTGRESQL:me:hush@h/x"],
)
def test_no_screen_shows_a_password(folder: Path, capsys: pytest.CaptureFixture[str], url: str) -> None:
    assert main(["certify", "data/log.csv", *ROLES, "--missing", "drop", *WITH]) == 0
    (folder / "secret.toml").write_text(AUDIT.replace("data/log.csv", url))
    capsys.readouterr()
    for words in (
        ["verify", "out/c.json", "--attestation", "out/a.json", "--recount", url],
        ["verify", url],
        ["verify", "out/c.json", "--attestation", url],
        ["attest", url, "--sign-key", url],
        ["attest", "--new-key", url],
        ["report", url, "-o", "out/page.md"],
        ["publish", url, "--rule", "four-fifths", "-o", "out/page"],
        ["inspect", url],
        ["certify", url, *ROLES],
        ["certify", "secret.toml"],
        ["certify", "secret.toml", "-o", "out/d.json", "--attest", "out/b.json"],
        ["certify", "data/log.csv", *ROLES, "-o", url],
        ["certify", "data/log.csv", *ROLES, "--tabel", url],
    ):
        try:
            assert main(words) in (2, 3), words
        except SystemExit as stop:
            assert stop.code == 2
        said = "".join(capsys.readouterr())
        assert said and "hush" not in said, words


@pytest.mark.parametrize("option", ["-o", "--attest"])
@pytest.mark.parametrize(
    "source",
    ["sqlite:data/log.json", "sqlite://data/log.json", "duckdb:data/log.json", "data/l*.json", "delta:data", "data", "of_database.toml"],
)
def test_what_is_read_is_not_written_over(folder: Path, source: str, option: str, capsys: pytest.CaptureFixture[str]) -> None:
    target = folder / "data" / "log.json"
    target.write_text('{"answer": "yes", "sex": "f"}\n')
    if source in ("delta:data", "data"):
        (folder / "data" / "_delta_log").mkdir()
    (folder / "of_database.toml").write_text(AUDIT.replace("data/log.csv", "sqlite:data/log.json"))
    before = target.read_bytes()
    written = {"-o": "out/c.json", "--attest": "out/a.json", option: "data/log.json"}
    asked = () if source.endswith(".toml") else ROLES
    assert main(["certify", source, *asked, *(word for pair in written.items() for word in pair)]) == 2
    said = capsys.readouterr().err
    assert "data/log.json is the table itself" in said or "data/log.json is a file that the audit file names, itself" in said
    assert target.read_bytes() == before and not any((folder / "out").iterdir())


def test_a_file_that_a_query_names_is_not_written_over(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "data" / "log.json").write_text('{"answer": "yes", "sex": "f"}\n')
    query = ["--query", "select * from 'data/log.json'"]
    assert main(["certify", "duckdb:data/x.db", *ROLES, *query, "-o", "data/log.json", "--attest", "out/a.json"]) == 2
    assert "data/log.json is a file that the query names, itself" in capsys.readouterr().err


def test_neither_file_is_new_where_the_other_cannot_be_replaced(folder: Path) -> None:
    words = ["certify", "data/log.csv", *ROLES, "--missing", "drop", *WITH]
    assert main(words) == 0
    before = {path.name: path.read_bytes() for path in (folder / "out").iterdir()}
    for name in before:
        target = folder / "out" / name
        if subprocess.run(["mount", "--bind", str(target), str(target)], capture_output=True, check=False).returncode:
            pytest.skip("nothing may be mounted here")
        try:
            assert main([*words, "--title", "x", "--max-local-ratio", "2"]) == 2
        finally:
            subprocess.run(["umount", str(target)], check=True)
        assert {path.name: path.read_bytes() for path in (folder / "out").iterdir()} == before


WITH = ["-o", "out/c.json", "--attest", "out/a.json"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["data/log.csv", *ROLES, "--attest", "out/a.json"], "--attest needs -o FILE.json"),
        (["data/log.csv", *ROLES, "-o", "out/page.html", "--attest", "out/a.json"], "--attest needs -o FILE.json"),
        (["data/log.csv", *ROLES, "-o", "out/c.json", "--attest", "out/c.json"], "named twice"),
        (["data/log.csv", *ROLES, "-o", "out/c.json", "--attest", "out/c.table.jsonl"], "named twice"),
        (["data/log.csv", *ROLES, "-o", "out/c.json", "--attest", "data/log.csv"], "is the table itself"),
        (["audit.toml", "-o", "out/c.json", "--attest", "names.toml"], "is a file that the audit file names, itself"),
        (["data/log.csv", *ROLES, "-o", "out/c.json", "--attest", "out/key.pem"], "--attest out/key.pem does not end in .json"),
        (["data/log.csv", *ROLES, "-o", "out/c.json", "--attest", "none/a.json"], "there is no directory none"),
        (["data/log.csv", *ROLES, "-o", "out/c.json", "--issuer", "Jane"], "--issuer goes with --attest FILE"),
        (["data/log.csv", *ROLES, "--period", "2025-01-01/2025-12-31"], "--period goes with --attest FILE"),
        (["data/log.csv", *ROLES, *WITH, "--contact", "a@b.c"], "--contact goes with --issuer"),
        (["data/log.csv", *ROLES, *WITH, "--system-version", "2"], "--system-version goes with --system"),
        (["data/log.csv", *ROLES, *WITH, "--issuer", " "], "--issuer is ' '"),
        (["data/log.csv", *ROLES, *WITH, "--title", "a\nb"], "title holds the control character"),
        (["data/log.csv", *ROLES, *WITH, "--title", "x" * 5000], "title has 5000 characters"),
        (["data/log.csv", *ROLES, *WITH, "--period", "2025"], "START/END"),
        (["data/log.csv", *ROLES, *WITH, "--period", "2025-02-01/2025-01-01"], "before it begins"),
        (["data/log.csv", *ROLES, *WITH, "--period", "2025-02-30/2025-03-01"], "the day '2025-02-30'"),
        (["data/log.csv", *ROLES, *WITH, "--print-sql", "duckdb"], "--attest does not go with --print-sql"),
        (["data/log.csv", "--slots", "a,b", "--winner", "c", *WITH], "--attest does not go with --slots"),
        (["none.csv", *ROLES, *WITH], "none.csv: there is no such file"),
        (["none*.csv", *ROLES, *WITH], "none that the pattern fits"),
        (["data", *ROLES, *WITH], "this is a directory"),
        (["postgresql://a:hush@h/db", *ROLES, *WITH, "--query", "SELECT dblink('password=x')"], "looks like a password"),
        (["sqlite:x.db", *ROLES, *WITH, "--query", "SELECT\n1"], "query holds the control character"),
    ],
)
def test_what_makes_no_sense_is_refused(folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    assert main(["certify", *words]) == 2
    printed = capsys.readouterr().err
    assert said in printed
    assert "hush" not in printed
    assert not any((folder / "out").iterdir())


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ('isuer = "x"', "[attestation] has the unknown key 'isuer'"),
        ("issuer = 3", "[attestation] issuer is 3"),
        ('period = "2025"', "[attestation] period is '2025'"),
        ('contact = "x"', "[attestation] contact goes with"),
    ],
)
def test_a_section_that_makes_no_sense_is_refused(folder: Path, capsys: pytest.CaptureFixture[str], section: str, said: str) -> None:
    text = (folder / "audit.toml").read_text()
    (folder / "audit.toml").write_text(text.partition("[attestation]")[0] + f"[attestation]\n{section}\n")
    assert main(["certify", "audit.toml", *WITH]) == 2
    assert said in capsys.readouterr().err
    assert not any((folder / "out").iterdir())


def test_a_file_that_somebody_writes_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, done = folder / "data" / "log.csv", threading.Event()

    def write() -> None:
        with path.open("a") as file:
            while not done.wait(0.001):
                file.write("yes,f\n")
                file.flush()

    path.write_text(LOG * 1 + "yes,f\n" * 20_000)
    writer = threading.Thread(target=write)
    writer.start()
    try:
        assert main(["certify", "data/log.csv", *ROLES, "--missing", "drop", *WITH]) == 2
    finally:
        done.set()
        writer.join()
    assert "was changed while it was read" in capsys.readouterr().err
    assert not any((folder / "out").iterdir())


def test_hostile_names_and_labels(folder: Path) -> None:
    name = "\u202egnp.csv <script>alert(1)</script>.csv".replace("/", "∕")
    (folder / name).write_text(LOG)
    made: Any = attested(folder, name, *ROLES, "--missing", "drop", "--issuer", "=1+1\u202e</script>", "--title", "{{ 7 * 7 }}")
    assert (made.sources[0].name, made.stated.issuer, made.stated.title) == (name, "=1+1\u202e</script>", "{{ 7 * 7 }}")
    raw = (folder / "out" / "a.json").read_bytes()
    assert raw.isascii()


def test_a_name_that_no_statement_holds_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a\nb.csv").write_text(LOG)
    assert main(["certify", "a\nb.csv", *ROLES, "--missing", "drop", *WITH]) == 2
    assert "rename the file" in capsys.readouterr().err
    assert not any((folder / "out").iterdir())


@pytest.mark.parametrize("words", [["--difference"], ["--max-difference", "1"], ["--max-global-difference", "1"]])
def test_utilities_that_may_be_negative_are_recorded(folder: Path, words: list[str]) -> None:
    roles = ["--decision", "answer", "--group", "sex", "--utility", "yes=1,no=-1", "--missing", "drop", "--confidence", "none"]
    made = attested(folder, "data/log.csv", *roles, *words)
    assert made.options["signed"] is True
    assert made.options["utility"] == {"yes": "1", "no": "-1"}


@POSIX
def test_a_pipe_has_no_digest(folder: Path) -> None:
    os.mkfifo(folder / "pipe")
    for _ in range(2):  # a log, and a table of counts, are read by different readers
        writer = threading.Thread(target=(folder / "pipe").write_text, args=(LOG,))
        writer.start()
        made = attested(folder, "pipe", *ROLES, "--missing", "drop")
        writer.join()
        assert [(s.name, s.sha256, s.bytes, s.rows) for s in made.sources] == [("a pipe", None, None, 6)]


def test_what_is_redirected_is_a_file(folder: Path) -> None:
    words = ["certify", "/dev/stdin", *ROLES, "--missing", "drop", "-o", "out/c.json", "--attest", "out/a.json"]
    with (folder / "data/log.csv").open("rb") as log:
        subprocess.run([sys.executable, "-m", "fairaudit", *words], stdin=log, check=True, capture_output=True)
    [source] = read_statement((folder / "out/a.json").read_bytes()).sources
    assert (source.name, source.sha256, source.rows) == ("stdin", digest(folder / "data/log.csv"), 6)


def test_spreadsheets_and_other_encodings(folder: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl", reason="openpyxl is not installed, which writes spreadsheets")
    pytest.importorskip("python_calamine", reason="python-calamine is not installed (extra files)")
    frame = pandas.DataFrame({"answer": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]})
    with pandas.ExcelWriter(folder / "log.xlsx") as book:
        pandas.DataFrame({"x": [1]}).to_excel(book, sheet_name="notes", index=False)
        frame.to_excel(book, sheet_name="log", index=False)
    made = attested(folder, "log.xlsx", *ROLES, "--table", "log")
    assert (made.sources[0].name, made.sources[0].sha256, made.sources[0].rows) == ("log.xlsx", digest(folder / "log.xlsx"), 4)
    assert made.sources[0].table is None
    assert made.options["table"] == "log"
    (folder / "log16.csv").write_text("title\n" + frame.to_csv(index=False), "utf-16")
    made = attested(folder, "log16.csv", *ROLES, "--skip", "1")
    assert (made.sources[0].sha256, made.options["skip"]) == (digest(folder / "log16.csv"), 1)


def test_a_link_is_what_it_leads_to(folder: Path) -> None:
    (folder / "link.csv").symlink_to(folder / "data/log.csv")
    [source] = attested(folder, "link.csv", *ROLES, "--missing", "drop").sources
    assert (source.name, source.sha256) == ("link.csv", digest(folder / "data/log.csv"))


def test_two_names_for_one_certificate_are_both_subjects(folder: Path) -> None:
    words = ["certify", "data/log.csv", *ROLES, "--missing", "drop", "-o", "out/c.json", "-o", "out/d.json", "--attest", "out/a.json"]
    assert main(words) == 0
    made = read_statement((folder / "out/a.json").read_bytes())
    assert [(subject.name, subject.sha256) for subject in made.subjects] == [(n, digest(folder / "out" / n)) for n in ("c.json", "d.json")]
    for name in ("c.json", "d.json"):
        assert main(["verify", f"out/{name}", "--attestation", "out/a.json"]) == 0


def test_an_audit_file_that_is_changed_once_it_was_read_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    audit = attesting._audit

    def read_and_changed(arguments: Any) -> dict[str, Any]:
        found = audit(arguments)
        Path("audit.toml").write_text(AUDIT.replace("yes = 1", "yes = 2"))
        return found

    monkeypatch.setattr(attesting, "_audit", read_and_changed)
    assert main(["certify", "audit.toml", "-o", "out/c.json", "--attest", "out/a.json"]) == 2
    assert "was changed while it was read" in capsys.readouterr().err and not list((folder / "out").iterdir())
