"""A log counted again by its attestation: equal to the byte, or the first cell that differs is named, whatever held it."""

from __future__ import annotations

import json
import random
import sqlite3
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelope
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.attestations.making import stated_of, statement_of
from fairaudit.attestations.recount import recounted
from fairaudit.attestations.sources import take
from fairaudit.attestations.verification import stated_in
from fairaudit.cli import main

Row = dict[str, Any]
PAY = {"yes": 2, "maybe": 1, "no": 0}
ROLES = ["--decision", "hired", "--group", "sex", "--context", "dept", "--utility", "yes,maybe=0.5"]
PLAIN = [*ROLES, "--confidence", "none"]
BY_RACE = ["--decision", "hired", "--group", "race", "--utility", "yes", "--confidence", "none"]


def log(rows: int = 300) -> list[Row]:
    source = random.Random(4)
    found = []
    for place in range(rows):
        hired = source.choice(["yes", "no", "maybe"])
        row = {"hired": hired, "sex": source.choice(["f", "m"]), "dept": f"d{source.randrange(4)}", "age": source.randrange(18, 80)}
        own = {"who": f"p{place // 2}", "good": source.choice("yn"), "pay": PAY[hired], "race": source.choice(["a", "b", "?", ""])}
        found.append(row | own)
    for place, row in enumerate(found):  # each of whom is asked once as a woman and once as a man
        row["sex"], row["dept"] = "fm"[place % 2], found[place // 2 * 2]["dept"]
    return found


def as_csv(rows: list[Row]) -> str:
    return "\n".join([",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]) + "\n"


def counts(rows: list[Row]) -> list[Row]:
    cells = Counter((row["hired"], row["sex"], row["dept"]) for row in rows)
    return [{"hired": u, "sex": a, "dept": x, "n": n} for (u, a, x), n in cells.items()]


def wide(rows: list[Row]) -> list[Row]:
    cells = Counter((row["sex"], row["dept"], row["hired"]) for row in rows)
    keys = sorted({(row["sex"], row["dept"]) for row in rows})
    return [{"sex": a, "dept": x, **{u: cells[a, x, u] for u in PAY}, "all": sum(cells[a, x, u] for u in PAY)} for a, x in keys]


def write(folder: Path, rows: list[Row]) -> None:
    """The log in every form."""
    import duckdb
    import pandas as pd

    frame = pd.DataFrame(rows)
    (folder / "log.csv").write_text(as_csv(rows))
    (folder / "titled.csv").write_text(f"A title\n\n{as_csv(rows)}")
    (folder / "counts.csv").write_text(as_csv(counts(rows)))
    (folder / "wide.csv").write_text(as_csv(wide(rows)))
    totals = Counter((row["sex"], row["dept"]) for row in rows)
    shares = [{**row, "p": f"{row['n']}/{totals[row['sex'], row['dept']]}", "w": totals[row["sex"], row["dept"]]} for row in counts(rows)]
    (folder / "shares.csv").write_text(as_csv(shares))
    (folder / "log.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    frame.to_parquet(folder / "log.parquet")
    frame.to_excel(folder / "log.xlsx", sheet_name="first", index=False)
    for name in ("log.db", "log.duckdb"):
        (folder / name).unlink(missing_ok=True)
    with sqlite3.connect(folder / "log.db") as base:
        base.executescript(f"create table log ({', '.join(rows[0])})")
        base.executemany(f"insert into log values ({', '.join('?' * len(rows[0]))})", [tuple(row.values()) for row in rows])
    base.close()
    with duckdb.connect(str(folder / "log.duckdb")) as connection:
        connection.execute("create table log as from frame")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs")
    write(folder, log())
    (folder / "map.toml").write_text('[hired]\n"maybe" = "no"\n')
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, in which the names of the logs can be used."""
    monkeypatch.chdir(tmp_path)
    for path in made.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


Check = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def check(capsys: pytest.CaptureFixture[str]) -> Check:
    """Verify with a recount, and give the exit code and what JSON says of the recount."""

    def run(*words: str) -> tuple[int, dict[str, Any]]:
        capsys.readouterr()
        beside = ["--table", "c.table.jsonl"] if Path("c.table.jsonl").exists() else []
        code = main(["verify", "c.json", *beside, "--attestation", "a.json", "--format", "json", "--recount", *words])
        said = capsys.readouterr()
        return code, envelope(said.out)["result"]["recount"] if said.out.startswith("{") and code != 2 else {"error": said.err or said.out}

    return run


def attest(*words: str) -> None:
    assert main(["certify", *words, "-o", "c.json", "--attest", "a.json"]) in (0, 1, 3)


CASES = {
    "csv": ["log.csv", *ROLES],
    "parquet": ["log.parquet", *PLAIN],
    "json": ["log.jsonl", *PLAIN],
    "spreadsheet": ["log.xlsx", *PLAIN, "--table", "first"],
    "sqlite": ["sqlite:log.db", *PLAIN, "--table", "log"],
    "duckdb": ["duckdb:log.duckdb", *PLAIN, "--table", "log"],
    "lines above": ["titled.csv", *PLAIN, "--skip", "2"],
    "counts": ["counts.csv", *PLAIN, "--count", "n"],
    "probabilities": ["shares.csv", *PLAIN, "--probability", "p"],
    "weights": ["shares.csv", *PLAIN, "--probability", "p", "--weight", "w"],
    "wide": ["wide.csv", "--wide", "yes=yes,maybe=maybe", "--total", "all", *PLAIN[2:]],
    "units": ["log.csv", *ROLES, "--unit", "who"],
    "unknown": ["log.csv", *BY_RACE, "--unknown", "?", "--missing", "unknown"],
    "left out": ["log.csv", *BY_RACE, "--missing", "drop"],
    "salted and left out": ["log.csv", *BY_RACE, "--missing", "drop", "--no-table"],
    "left out in parts": ["log.parquet", *BY_RACE, "--context", "dept", "--missing", "drop", "--in-parts"],
    "a level": ["log.csv", *BY_RACE, "--missing", "group"],
    "folded": ["log.csv", *PLAIN, "--fold-labels"],
    "mapped": ["log.csv", *ROLES[:-2], "--utility", "yes", "--map", "map.toml", "--confidence", "none"],
    "intervals": ["log.csv", "--decision", "hired", "--group", "sex,age:30,50.5", "--utility", "yes", "--confidence", "none"],
    "truth": ["log.csv", *ROLES[:-2], "--utility", "yes", "--truth", "good", "--positive", "y"],
    "utility column": ["log.csv", "--group", "sex", "--context", "dept", "--utility-column", "pay", "--confidence", "none"],
    "differences": ["log.csv", *ROLES[:-2], "--utility", "yes=1,no=-1", "--difference", "--confidence", "none"],
    "scores": ["log.csv", "--score", "age", "--above-median", "--group", "sex", "--context", "dept", "--confidence", "none"],
    "salted": ["log.csv", *PLAIN, "--no-table"],
    "in parts": ["log.parquet", *PLAIN, "--in-parts"],
    "salted in parts": ["log.parquet", *PLAIN, "--in-parts", "--no-table"],
}


@pytest.mark.parametrize("name", CASES)
def test_a_log_gives_its_table_again(folder: Path, check: Check, name: str) -> None:
    attest(*CASES[name])
    code, found = check(CASES[name][0])
    assert (code, found["equal"], found["different_cells"], found["first_cell"]) == (0, True, 0, None)
    assert {entry["what"]: entry["equal"] for entry in found["findings"]}["the table"] is True
    assert "gives the same table, cell for cell" in found["paragraph"]


@pytest.mark.parametrize("name", ["csv", "parquet", "json", "sqlite", "duckdb", "spreadsheet", "counts", "salted", "in parts"])
def test_a_row_that_was_changed_is_a_cell_that_is_named(folder: Path, check: Check, name: str) -> None:
    attest(*CASES[name])
    rows = log()
    row = rows[123]
    before = Counter((r["dept"], r["sex"], r["hired"]) for r in rows)
    was, row["hired"] = row["hired"], "no" if row["hired"] == "yes" else "yes"
    after = Counter((r["dept"], r["sex"], r["hired"]) for r in rows)
    write(folder, rows)
    code, found = check(CASES[name][0])
    assert (code, found["equal"], found["different_cells"]) == (1, False, 1)
    numbers = [
        {"of": f"decision {u!r}", "certificate": str(before[row["dept"], row["sex"], u]), "log": str(after[row["dept"], row["sex"], u])}
        for u in {was, row["hired"]}
    ]
    cell = found["first_cell"]
    assert (cell["context"], cell["group"]) == ({"dept": row["dept"]}, {"sex": row["sex"]})
    assert sorted(cell["numbers"], key=str) == sorted(numbers, key=str)
    file = [entry["equal"] for entry in found["findings"] if entry["what"].startswith("the source")]
    assert file == [None if ":" in CASES[name][0] else False]


def test_a_file_of_other_bytes_and_the_same_rows_is_another_file(folder: Path, check: Check) -> None:
    attest(*CASES["csv"])
    rows = log()
    (folder / "log.csv").write_text(as_csv([*rows[1:], rows[0]]))
    code, found = check("log.csv")
    assert (code, [entry["equal"] for entry in found["findings"]]) == (1, [False, True, True])


def test_sampling_units_are_compared_which_no_table_shows(folder: Path, check: Check) -> None:
    attest(*CASES["units"])
    assert "profiles" in json.loads((folder / "c.json").read_text())["subject"]["table"]["header"]  # what pairs of units got
    rows = log()
    rows[0]["who"], rows[4]["who"] = rows[4]["who"], rows[0]["who"]
    (folder / "log.csv").write_text(as_csv(rows))
    code, found = check("log.csv")
    assert (code, found["different_cells"]) == (1, 0)
    table = next(entry for entry in found["findings"] if entry["what"] == "the table")
    assert table["equal"] is False and "those that were seen in several groups got something else there" in table["detail"]


def test_what_was_left_out_is_compared(folder: Path, check: Check) -> None:
    attest(*CASES["left out"])
    rows = log()
    (folder / "log.csv").write_text(as_csv([*rows, {**rows[0], "race": ""}]))
    code, found = check("log.csv")
    wrong = {entry["what"]: entry["detail"] for entry in found["findings"] if entry["equal"] is False}
    left = sum(row["race"] == "" for row in rows)
    assert (code, found["different_cells"]) == (1, 0)
    assert f"{left} of 300 decisions have a missing label" in wrong["what was done to labels and rows"]
    assert f"{left + 1} of 301 decisions have a missing label" in wrong["what was done to labels and rows"]
    assert (
        f"301 decisions read, {300 - left} counted, dropped 'missing label' {left + 1} in the log"
        in wrong["how much was read, counted and dropped"]
    )


def test_more_rows_than_fit_are_recounted_in_parts(folder: Path, check: Check, monkeypatch: pytest.MonkeyPatch) -> None:
    attest(*CASES["parquet"])
    monkeypatch.setattr("fairaudit.attestations.recounted_log.MOST_ROWS", 5)
    made: list[object] = []
    from fairaudit.attestations import recounted_log

    monkeypatch.setattr(
        recounted_log, "certify_in_parts", lambda *a, _own=recounted_log.certify_in_parts, **k: made.append(0) or _own(*a, **k)
    )
    assert check("log.parquet", "--memory", "500MB", "--engine", "duckdb")[0] == 0
    assert made
    rows = log()
    rows[7]["dept"] = "new"
    write(folder, rows)
    code, found = check("log.parquet")
    assert (code, found["different_cells"]) == (1, 2)


def test_logs_are_found_by_their_names_then_in_order(folder: Path, check: Check) -> None:
    rows = log()
    (folder / "one.csv").write_text(as_csv(rows[:100]))
    (folder / "two.csv").write_text(as_csv(rows[100:]))
    attest("one.csv", "two.csv", *PLAIN)
    assert check("two.csv", "one.csv")[0] == 0
    (folder / "one.csv").rename("other.csv")
    assert check("other.csv", "two.csv")[0] == 0
    code, found = check("two.csv")
    assert (code, found["missing"]) == (3, ["one.csv"])
    code, found = check("two.csv", "away.csv")
    assert (code, found["missing"], found["findings"]) == (3, ["away.csv"], [])
    assert "'away.csv' is not there" in found["paragraph"]
    code, found = check("one*.csv")
    assert (code, found["missing"]) == (3, ["one*.csv"])
    code, found = check("other.csv", "two.csv", "log.csv")
    assert code == 2
    assert "3 logs were given, and the statement has 2; leave 'log.csv' away" in found["error"]


@pytest.mark.parametrize("database", ["sqlite:log.db", "duckdb:log.duckdb"])
def test_a_query_is_run_only_if_it_is_given(folder: Path, check: Check, database: str) -> None:
    query = "select * from log where age > 30 -- 'older'"
    attest(database, *PLAIN, "--query", query)
    code, found = check(database)
    assert code == 2
    assert repr(query) in found["error"] and "--query" in found["error"]
    code, found = check(database, "--query", query.replace("30", "31"))
    assert code == 2
    assert "not the query of the statement" in found["error"]
    assert check(database, "--query", query)[0] == 0


def test_a_query_in_a_place_where_it_could_write_is_refused(folder: Path, check: Check) -> None:
    attest("sqlite:log.db", *PLAIN, "--query", "select * from log")
    code, found = check("trino://somebody@somewhere/log", "--query", "select * from log")
    assert code == 2
    with pytest.raises(fa.InputError, match="trino is none of these"):
        fa.recount("c.json", "a.json", ["trino://somebody@somewhere/log"], query="select * from log")
    assert "trino is none of these" in found["error"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--recount", "log.csv"], "--recount goes with --attestation"),
        (["--attestation", "a.json", "--query", "select 1"], "--query goes with --recount"),
        (["--engine", "duckdb"], "--engine goes with --recount"),
        (["--memory", "2GB"], "--memory goes with --recount"),
        (["--export", "x.pyz", "--recount", "log.csv"], "--recount goes with --attestation"),
        (["--attestation", "a.json", "--recount", "log.csv", "--query", "select 1"], "the statement has no query"),
    ],
)
def test_options_that_make_no_sense_are_refused(folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    attest(*CASES["csv"])
    assert main(["verify", "c.json", *words]) == 2
    assert said in capsys.readouterr().err


def test_the_certificate_comes_before_the_logs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--attestation", "a.json", "--recount", "log.csv", "c.json"]) == 2
    assert "before --recount, which takes all names that follow it" in capsys.readouterr().err


def test_another_log_of_which_there_is_no_table_differs(folder: Path, check: Check) -> None:
    attest(*CASES["csv"])
    rows = log()
    (folder / "log.csv").write_text(as_csv([*rows[:7], {**rows[7], "sex": ""}]))
    code, found = check("log.csv")
    assert (code, [entry["equal"] for entry in found["findings"]]) == (1, [False, False])
    assert "of this log there is none: log.csv: column 'sex', line 9" in found["findings"][1]["detail"]


def test_a_delta_table_is_a_folder_of_files(folder: Path, check: Check) -> None:
    deltalake = pytest.importorskip("deltalake", reason="deltalake is not installed")
    import pandas as pd

    deltalake.write_deltalake(folder / "table", pd.DataFrame(log()))
    attest("delta:table", *PLAIN)
    code, found = check("delta:table")
    assert (code, found["equal"]) == (0, True)
    deltalake.write_deltalake(folder / "table", pd.DataFrame(log(301)[300:]), mode="append")
    assert check("delta:table")[0] != 0


def test_an_attestation_of_files_says_of_no_table_of_a_database(folder: Path, check: Check) -> None:
    attest(*CASES["csv"])
    code, found = check("sqlite:log.db")
    assert code == 2
    assert "write the log to a file" in found["error"]


@pytest.mark.parametrize("altered", ["certificate", "attestation", "page"])
def test_what_is_false_is_not_recounted_and_no_recount_hides_it(folder: Path, capsys: pytest.CaptureFixture[str], altered: str) -> None:
    attest(*CASES["csv"], "-o", "page.html")
    if altered == "certificate":
        document = json.loads((folder / "c.json").read_text())
        document["metrics"]["local"]["ratio"] = "9"
        (folder / "c.json").write_text(json.dumps(document))
    elif altered == "attestation":
        statement = json.loads((folder / "a.json").read_text())
        statement["predicate"]["rows"]["counted"] += 1
        (folder / "a.json").write_text(json.dumps(statement))
    command = ["verify", "page.html" if altered == "page" else "c.json", "--attestation", "a.json", "--recount", "sqlite:log.db"]
    capsys.readouterr()
    assert main(command) == 1
    said = capsys.readouterr()
    assert "FALSE" in said.out
    assert "note: nothing was recounted" in said.err
    assert main([*command, "--format", "json"]) == 1
    answer = envelope(capsys.readouterr().out)
    assert "recount" not in answer["result"]
    assert "nothing was recounted" in answer["notes"][0]
    assert main([*command, "--quiet"]) == 1
    assert capsys.readouterr() == ("", "")


def test_a_recount_that_cannot_be_done_hides_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attest(*CASES["csv"])
    command = ["verify", "c.json", "--attestation", "a.json", "--recount", "sqlite:log.db"]
    capsys.readouterr()
    assert main(command) == 2
    said = capsys.readouterr()
    assert said.out.startswith("All ") and "The attestation fits" in said.out
    assert said.err.startswith("fairaudit: the attestation is of files") and said.err.count("\n") == 1
    assert main([*command, "--format", "json"]) == 2
    answer = envelope(capsys.readouterr().out)
    assert (answer["result"]["true"], answer["result"]["recount"]["equal"]) == (True, None)
    assert "Nothing was recounted: the attestation is of files" in answer["sentence"]
    assert main([*command, "--require", "within"]) == 1
    assert main([*command, "--quiet"]) == 2


def test_a_certificate_that_changes_while_it_is_checked_is_not_recounted(
    folder: Path, check: Check, monkeypatch: pytest.MonkeyPatch
) -> None:
    from fairaudit.cli import checking

    def check_then_change(*given: Any, _own: Any = checking.examine) -> Any:
        found = _own(*given)
        (folder / "c.json").write_bytes((folder / "other.json").read_bytes())
        return found

    attest(*CASES["csv"])
    assert main(["certify", "log.csv", *BY_RACE, "--missing", "drop", "-o", "other.json"]) == 0
    monkeypatch.setattr(checking, "examine", check_then_change)
    code, found = check("log.csv")
    assert code == 2
    assert "c.json was changed while it was checked" in found["error"]


def test_what_the_options_say_is_data(folder: Path, check: Check) -> None:
    attest(*CASES["csv"])
    statement = json.loads((folder / "a.json").read_text())
    options = statement["predicate"]["options"]

    def said(**changes: Any) -> tuple[int, str]:
        statement["predicate"]["options"] = {name: value for name, value in (options | changes).items() if value is not None}
        (folder / "a.json").write_text(json.dumps(statement))
        code, found = check("log.csv")
        return code, json.dumps(found)

    assert said()[0] == 0
    assert said(group=["who"])[0] == 1
    code, text = said(utility={"yes": "1"})
    assert code == 1 and "utility of 'maybe': 1/2 in the certificate, 0 in the log" in text
    assert said(decision="nothing")[0] == said(decision=3)[0] == said(table="log")[0] == said(audit={})[0] == 2
    nothing = dict.fromkeys(options)
    for audit in ([], "log.csv", {}, {"law": 3}, {"law": {"table": 3}}, {"law": {}, "policy": {}}):
        assert said(**nothing, audit=audit)[0] == 2
    statement["predicate"]["options"] = {}
    (folder / "a.json").write_text(json.dumps(statement))
    assert "does not say how its table was made" in check("log.csv")[1]["error"]


LAW = '[law]\ntable = "{log}"\ndecision = "hired"\ngroup = "sex"\ncontext = "dept"\n[utility]\nvalues = {{ yes = 1, map = "1/2" }}\n'
POLICY = (
    '[policy]\ntable = "shares.csv"\ndecision = "hired"\ngroup = "sex"\nprobability = "p"\ncontext = "dept"\n'
    '[filter.group]\nkind = "table"\ntable = "inner/filter.csv"\noutput = "seen"\n[utility]\nvalues = { yes = 1 }\n'
)
FILTER = "sex,f,m\nf,3/4,1/4\nm,1/4,3/4\n"


@pytest.mark.parametrize(("audit", "logs"), [(LAW, ["log.csv"]), (LAW, ["log.parquet"])])
def test_an_audit_file_is_recounted_from_what_the_attestation_says(folder: Path, check: Check, audit: str, logs: list[str]) -> None:
    (folder / "audit.toml").write_text(audit.format(log=logs[0]))
    attest("audit.toml", "--confidence", "none")
    code, found = check("audit.toml", *logs)
    assert (code, found["equal"]) == (0, True)
    code, found = check(*logs)
    assert code == 0
    (folder / "audit.toml").unlink()
    statement = json.loads((folder / "a.json").read_text())
    statement["predicate"]["options"]["audit"]["law"]["table"] = "/etc/hostname"
    (folder / "a.json").write_text(json.dumps(statement))
    code, found = check(*logs)
    assert code == 2
    assert "'/etc/hostname', which is none of the logs" in found["error"]


def test_a_log_on_postgresql(folder: Path, check: Check, postgres: str) -> None:
    import psycopg

    rows = log()
    with psycopg.connect(postgres, autocommit=True) as base:
        base.execute(
            "create schema hr; create table hr.log (hired text, sex text, dept text, age int, who text, good text, pay int, race text)"
        )
        with base.cursor() as cursor:
            cursor.executemany(f"insert into hr.log values ({', '.join(['%s'] * 8)})", [tuple(row.values()) for row in rows])
        attest(postgres, *PLAIN, "--table", "hr.log")
        assert check(postgres)[0] == 0
        attest(postgres, *PLAIN, "--query", "select * from hr.log where age > 20")
        assert check(postgres)[0] == 2
        assert check(postgres, "--query", "select * from hr.log where age > 20")[0] == 0
        changed = next(row for row in rows if row["age"] > 20 and row["hired"] == "no")
        base.execute("update hr.log set hired = 'yes' where who = %s and sex = %s", (changed["who"], changed["sex"]))
        code, found = check(postgres, "--query", "select * from hr.log where age > 20")
        assert (code, found["different_cells"]) == (1, 1)
        assert (found["first_cell"]["context"], found["first_cell"]["group"]) == ({"dept": changed["dept"]}, {"sex": changed["sex"]})
        base.execute("create function hr.wrote() returns int language sql as 'insert into hr.log (hired) values (''x'') returning 1'")
        writing = "select hr.log.* from hr.log, hr.wrote() where age > 20"
        text = (folder / "a.json").read_text().replace("select * from hr.log where age > 20", writing)
        (folder / "a.json").write_text(text)
        code, found = check(postgres, "--query", writing)
        assert code == 2 and "cannot execute INSERT in a read-only transaction" in found["error"]
        assert base.execute("select count(*) from hr.log").fetchone() == (len(rows),)
    assert "secret" not in (folder / "a.json").read_text()


def test_a_person_reads_the_cell_and_both_numbers(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attest(*CASES["counts"])
    held = counts(log())
    held[0]["n"] += 5
    (folder / "counts.csv").write_text(as_csv(held))
    capsys.readouterr()
    assert main(["verify", "c.json", "--attestation", "a.json", "--recount", "counts.csv"]) == 1
    cell, n = held[0], held[0]["n"]
    said = capsys.readouterr().out
    assert f"dept='{cell['dept']}', sex='{cell['sex']}': decision '{cell['hired']}' {n - 5} in the certificate, {n} in the log" in said
    assert "The recount DIFFERS" in said
    assert main(["verify", "c.json", "--attestation", "a.json", "--quiet", "--recount", "counts.csv"]) == 1
    assert capsys.readouterr().out == ""


def test_by_a_statement_that_is_not_the_signers_nothing_is_counted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attest(*CASES["csv"])
    for name in ("one", "two"):
        assert main(["attest", "--new-key", f"{name}.pem"]) == 0
    assert main(["attest", "a.json", "--sign-key", "one.pem", "-o", "signed.json"]) == 0
    command = ["verify", "c.json", "--attestation", "signed.json", "--format", "json", "--recount", "log.csv"]
    for more, code, counted in (([], 3, True), (["--key", "one.pub.pem"], 0, True), (["--key", "two.pub.pem"], 1, False)):
        capsys.readouterr()
        assert main([*command, *more]) == code
        assert ("recount" in envelope(capsys.readouterr().out)["result"]) is counted


def test_in_python_a_log_is_a_file_or_a_frame(folder: Path) -> None:
    import pandas as pd

    attest(*CASES["in parts"])
    rows = log()
    table = "c.table.jsonl"
    found = fa.recount("c.json", "a.json", Path("log.parquet"), table=table)
    assert found and found.exit_code == 0
    frame = pd.DataFrame(rows)
    assert fa.recount("c.json", (folder / "a.json").read_bytes(), frame, table=table).ok
    frame.loc[3, "hired"] = "no" if rows[3]["hired"] == "yes" else "yes"
    found = fa.recount("c.json", "a.json", frame, table=table)
    assert not found and found.exit_code == 1
    assert found.difference is not None and found.difference.first is not None
    assert (found.difference.first.context, found.difference.first.group) == ({"dept": rows[3]["dept"]}, {"sex": rows[3]["sex"]})
    with pytest.raises(fa.TableNeeded):
        fa.recount("c.json", "a.json", frame)
    attest(*CASES["csv"])
    with pytest.raises(fa.FalseCertificate, match="of the attestation"):
        fa.recount("c.json", (folder / "a.json").read_text().replace('"read": 300', '"read": 301').encode(), "log.csv")
    with pytest.raises(fa.InputError, match=r"absent\.pem cannot be read"):
        fa.recount("c.json", "a.json", "log.csv", key="absent.pem")


def test_what_the_certificate_does_not_say_of_the_reading_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attest(*CASES["counts"])
    capsys.readouterr()
    assert main(["verify", "c.json", "--attestation", "a.json", "--recount", "counts.csv"]) == 0
    assert "It was read with count 'n', which the certificate does not say." in " ".join(capsys.readouterr().out.split())


def test_the_same_table_of_other_sampling_units_is_no_equal_log(folder: Path, check: Check) -> None:
    rows = log()
    for place, row in enumerate(rows):  # units of one cell each, of which some have two rows
        row["who"] = f"{row['dept']}{row['sex']}{place // 40}"
    (folder / "log.csv").write_text(as_csv(rows))
    attest(*CASES["units"])
    document = json.loads((folder / "c.json").read_text())
    assert "profiles" not in document["subject"]["table"]["header"]
    assert document["intervals"]["local"]["units"]
    other = [{**row, "who": f"{row['dept']}{row['sex']}{place // 20}"} for place, row in enumerate(rows)]
    (folder / "log.csv").write_text(as_csv(other))
    code, found = check("log.csv")
    assert code == 1
    assert {entry["what"]: entry["equal"] for entry in found["findings"]} == {
        "the source 'log.csv'": False,
        "the table": True,
        "the sampling units": False,
        "how much was read, counted and dropped": True,
    }


def test_a_policy_behind_a_filter_is_recounted(folder: Path, check: Check) -> None:
    (folder / "inner").mkdir()
    (folder / "inner" / "filter.csv").write_text(FILTER)
    (folder / "audit.toml").write_text(POLICY)
    attest("audit.toml")
    assert check("audit.toml", "shares.csv", "inner/filter.csv")[1]["equal"] is True
    (folder / "inner" / "filter.csv").write_text(FILTER.replace("3/4", "4/5").replace("1/4", "1/5"))
    code, found = check("shares.csv", "inner/filter.csv")
    assert (code, found["different_cells"]) == (1, 0)
    table = next(entry for entry in found["findings"] if entry["what"] == "the table")
    assert "filters:" in table["detail"] and "in the log" in table["detail"]
    code, found = check("shares.csv")
    assert (code, found["missing"]) == (3, ["filter.csv"])
    (folder / "inner" / "shares.csv").write_text(FILTER)
    code, found = check("shares.csv", "inner/shares.csv")
    assert code == 2
    assert "two files of the audit are called 'shares.csv'" in found["error"]


@pytest.mark.parametrize("change", [{"sources": 301}, {"read": 301, "dropped": {"unreadable": 1}}])
def test_how_much_was_read_is_counted_again(folder: Path, change: dict[str, Any]) -> None:
    attest(*CASES["csv"])
    statement = json.loads((folder / "a.json").read_text())
    if "sources" in change:
        statement["predicate"]["sources"][0]["rows"] = change["sources"]
    else:
        statement["predicate"]["rows"] |= change
    (folder / "a.json").write_text(json.dumps(statement))
    found = recounted(json.loads((folder / "c.json").read_text()), None, stated_in((folder / "a.json").read_bytes())[0], "log.csv")
    wrong = "the rows of the sources" if "sources" in change else "how much was read, counted and dropped"
    assert [entry.what for entry in found.findings if entry.equal is False] == [wrong]


groups = st.sampled_from(["f", "F ", "m", "x", ""])
people = st.lists(
    st.tuples(st.sampled_from(["yes", "no", "maybe"]), groups, st.integers(0, 9), st.sampled_from("abcd")), min_size=4, max_size=30
)
asked = st.fixed_dictionaries(
    {},
    optional={
        "context": st.just(["age"]),
        "bins": st.just({"age": ["3", "6.5"]}),
        "missing": st.sampled_from(["drop", "group", "unknown"]),
        "unknown": st.just(["x"]),
        "fold_labels": st.just(True),
        "label_map": st.just({"sex": {"m": "man"}}),
        "unit": st.just(["who"]),
        "utility": st.sampled_from([{"yes": "1"}, {"yes": "1", "maybe": "1/3"}, {"yes": "1", "later": "1/2", "no": "0", "maybe": "0"}]),
    },
)


def frame_of(rows: list[tuple[str, str, int, str]]) -> dict[str, list[Any]]:
    return {name: list(values) for name, values in zip(("hired", "sex", "age", "who"), zip(*rows, strict=True), strict=True)}


@settings(max_examples=25)
@given(people, people, asked)
def test_a_recount_is_equal_where_the_tables_are(rows: list[Any], others: list[Any], options: dict[str, Any]) -> None:
    said = {"decision": "hired", "group": ["sex"], "utility": {"yes": "1"}, **options}
    if "context" not in said:
        said.pop("bins", None)

    def audited(held: list[Any]) -> fa.Result | None:
        try:
            return fa.audit(frame_of(held), **said, confidence=None)
        except fa.InputError:  # one group alone, labels that the map has and the log has not, options that do not go together
            return None

    result, other = audited(rows), audited(others)
    assume(result is not None)
    made = statement_of(result, ["c.json"], take(frame_of(rows)), options=said, command=["certify"], stated=stated_of({}))
    attestation = made.text.encode()
    assert fa.recount(result, attestation, frame_of(rows[::-1])).ok
    if other is not None:
        found = fa.recount(result, attestation, frame_of(others))
        digests = [made.certificate.document["subject"]["table"]["sha256"] for made in (result, other)]
        assert {entry.what: entry.equal for entry in found.findings}["the table"] is (digests[0] == digests[1])
        assert (found.difference is None) is (digests[0] == digests[1])
        assert found.difference is None or found.difference.sentences


def test_a_log_that_changes_while_it_is_counted_is_no_finding(folder: Path, check: Check, monkeypatch: pytest.MonkeyPatch) -> None:
    from fairaudit.attestations import recounted_log

    def read_while_somebody_writes(*given: Any, _own: Any = recounted_log.read_audited, **options: Any) -> Any:
        found = _own(*given, **options)
        (folder / "log.csv").write_text(as_csv(log(301)))
        return found

    attest(*CASES["csv"])
    monkeypatch.setattr(recounted_log, "read_audited", read_while_somebody_writes)
    code, found = check("log.csv")
    assert code == 2
    assert "was changed while it was read" in found["error"]
