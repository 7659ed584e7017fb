"""Real servers, real Spark, a real terminal, signals and full disks: what happens outside of this process."""

from __future__ import annotations

import gzip
import json
import os
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pandas as pd
import pytest
from logs import COLUMNS, as_csv, certificate, counts, log
from needs import POSIX
from servers import absent

from fairaudit import InputError, Law, audit, certify
from fairaudit.cli import main
from fairaudit.tables.engines.logs import read_log, survey_log
from fairaudit.tables.engines.tallies import tally
from fairaudit.tables.tally import Tally

COMMAND = ("--decision", "answer", "--group", "sex", "--context", "dept", "--utility", "yes")
ENDLESS = {
    "duckdb": "select 'yes' as answer, 'f' as sex, 'x' as dept from range(1000000000000000)",
    "sqlite": "with recursive r(i) as (select 1 union all select i + 1 from r) select 'yes' as answer, 'f' as sex, 'x' as dept from r",
    "postgres": "select 'yes' as answer, 'f' as sex, 'x' as dept from generate_series(1, 1000000000000)",
}


def test_postgres_gives_the_certificate_of_the_rows(postgres: str) -> None:
    rows = log()
    plain = {column: [row[column] for row in rows] for column in rows[0]}
    where = {"table": "logs.Decisions"}
    assert certificate(read_log(postgres, COLUMNS, **where)) == certificate(plain)
    assert certificate(read_log(postgres, (*COLUMNS, "run"), **where), unit="run") == certificate(plain, unit="run")
    query = {"query": 'select * from logs."Decisions" -- all\n;'}
    assert certificate(read_log(postgres, COLUMNS, **query)) == certificate(plain)
    for column in ("age", "score"):
        found = read_log(postgres, (column, "sex"), bins={column: [18, "44.5"]}, **where)
        expected: dict[tuple[str, str], int] = {}
        for row in rows:
            label = "under 18" if row["age"] < 18 else "18 to under 44.5" if row["age"] < 44.5 else "44.5 and over"
            expected[label, row["sex"]] = expected.get((label, row["sex"]), 0) + 1
        assert counts(found) == expected


def test_postgres_cuts_scores_as_the_rows_do(postgres: str) -> None:
    rows = log()
    table = {name: [row[name] for row in rows] for name in rows[0]}
    expected = audit(table | {"score": table["age"]}, score="score", above="median", group=["sex", "dept"])
    found = audit(postgres, score="score", above="median", group=["sex", "dept"], table="logs.Decisions")
    assert found.certificate.text == expected.certificate.text


@pytest.mark.deep  # pays for what tests that are slow share
def test_inspect_of_postgres(postgres: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import psycopg

    (tmp_path / "log.csv").write_text(as_csv(log()))
    assert main(["inspect", str(tmp_path / "log.csv")]) == 0
    expected = capsys.readouterr().out.splitlines()
    query = 'select answer, sex, dept, age, run from logs."Decisions"'
    assert main(["inspect", postgres, "--query", query]) == 0
    *lines, command = capsys.readouterr().out.splitlines()
    assert lines == expected[:-1]
    assert "secret" not in command and "postgresql://auditor@127.0.0.1" in command
    with psycopg.connect(postgres) as connection:
        connection.execute("create table logs.mixed as select answer, '{}'::json as kept, array[1] as listed from logs.\"Decisions\"")
    assert main(["inspect", postgres, "--table", "logs.mixed"]) == 0
    out = capsys.readouterr().out
    assert "400 rows, 3 columns" in out and out.count("no labels: ") == 2
    assert main(["inspect", postgres, "--table", "logs.nothing"]) == 2
    assert "does not exist" in capsys.readouterr().err


def test_postgres_says_what_is_wrong_and_keeps_the_password(postgres: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    closed = postgres.rpartition(":")[0] + ":1/postgres"
    for url, words, said in (
        (postgres, ["--table", "logs.Nothing"], "does not exist"),
        (postgres, [], "--table"),
        (postgres, ["--query", "select from where"], "syntax error"),
        (postgres, ["--query", 'delete from logs."Decisions" returning *'], "PostgreSQL says"),
        (postgres, ["--table", "logs.Decisions", "--unit", "nothing"], "there is no column 'nothing'"),
        (postgres.replace("a%3Asecret", "wrong"), ["--table", "logs.Decisions"], "password authentication failed"),
        (closed, ["--table", "logs.Decisions"], "PostgreSQL says"),
    ):
        assert main(["certify", url, *words, *COMMAND, "-o", str(tmp_path / "c.json")]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and said in err
        assert "secret" not in err and "wrong" not in err
    assert list(tmp_path.iterdir()) == []


def test_a_certificate_of_a_database_says_nothing_of_the_connection(postgres: str, tmp_path: Path) -> None:
    out = tmp_path / "c.json"
    assert main(["certify", postgres, "--table", "logs.Decisions", *COMMAND, "-o", str(out)]) == 0
    assert "secret" not in out.read_text() and "127.0.0.1" not in out.read_text()


@pytest.fixture(scope="module")
def spark() -> Iterator[object]:
    pyspark = pytest.importorskip("pyspark.sql", reason="PySpark is not installed")
    if shutil.which("java") is None:
        absent("Spark needs Java, and there is none on this machine")
    os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    builder = (
        pyspark.SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false").config("spark.sql.shuffle.partitions", "2")
    )
    session = builder.config("spark.driver.memory", "1g").getOrCreate()
    session.sparkContext.setLogLevel("OFF")
    yield session
    session.stop()


@pytest.mark.filterwarnings("ignore")
@pytest.mark.core
def test_spark_gives_the_certificate_of_duckdb(spark: object, tmp_path: Path) -> None:
    import duckdb

    rows = log(900)
    (tmp_path / "log.csv").write_text(as_csv(rows))
    duckdb.sql(
        f"copy (select * replace (age::bigint as age, age::double / 4 as run) from '{tmp_path}/log.csv') to '{tmp_path}/log.parquet'"
    )
    for name in ("log.csv", "log.parquet"):
        texts = set()
        for engine in (spark, "duckdb"):
            tally = read_log(tmp_path / name, (*COLUMNS, "age", "run"), bins={"age": [18, 30]}, engine=engine)
            texts.add(certificate(tally, age=True, unit="run"))
        assert len(texts) == 1, name
    frame = spark.read.parquet(str(tmp_path / "log.parquet"))  # type: ignore[attr-defined]
    columns = {"decision": "answer", "group": "sex", "context": ["dept", "age"], "unit": "run"}
    laws = [Law.from_log(table, **columns) for table in (frame, read_log(tmp_path / "log.parquet", (*COLUMNS, "age", "run")))]
    assert len({certify(law, {"yes": 1}).certificate.text for law in laws}) == 1
    frame.createOrReplaceTempView("held")
    (tmp_path / "bad.csv").write_text(as_csv(rows) + "yes,f\n")
    (tmp_path / "latin.csv").write_bytes("answer,sex,dept\nyes,f,é\n".encode("latin-1"))
    for name, said in (("bad.csv", "Spark cannot read it"), ("latin.csv", "not UTF-8"), ("none.csv", "no such file")):
        with pytest.raises(InputError, match=said):
            read_log(tmp_path / name, COLUMNS, engine=spark)
    with pytest.raises(InputError, match="there is no column 'gender'"):
        read_log(tmp_path / "log.csv", ("answer", "gender"), engine=spark)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "engine",
    ["python", "duckdb", "sqlite", pytest.param("postgres", marks=pytest.mark.deep), pytest.param("spark", marks=pytest.mark.deep)],
)
def test_every_engine_counts_by_group_what_was_left_out(engine: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """Counted here row by row, of one log in which labels of every column may be missing."""
    pick = random.Random(7)
    rows = [tuple(pick.choice([*labels, None]) for labels in (("yes", "no"), "fmd", "xy")) for _ in range(400)]
    lost, of = Counter[str](), Counter[str]()
    for answer, sex, dept in rows:
        if sex is not None:
            of[sex] += 1
            lost[sex] += answer is None or dept is None
    path, where = tmp_path / "log.csv", {}
    pd.DataFrame(rows, columns=["answer", "sex", "dept"]).to_csv(path, index=False)
    source: object = path
    if engine == "sqlite":
        with closing(sqlite3.connect(tmp_path / "log.db")) as database, database:
            database.execute("create table log (answer, sex, dept)")
            database.executemany("insert into log values (?, ?, ?)", rows)
        source, where = f"sqlite:{tmp_path / 'log.db'}", {"table": "log"}
    elif engine == "postgres":
        import psycopg

        source = url = request.getfixturevalue("postgres")
        with psycopg.connect(url) as connection:
            connection.execute("create table logs.lost (answer text, sex text, dept text)")
            with connection.cursor() as cursor:
                cursor.executemany("insert into logs.lost values (%s, %s, %s)", rows)
        where = {"table": "logs.lost"}
    else:
        where = {"engine": request.getfixturevalue("spark") if engine == "spark" else engine}
    made = audit(source, decision="answer", group="sex", context="dept", utility="yes", missing="drop", **where)
    [entry] = made.preparation
    assert entry["decisions"] == str(sum(None in row for row in rows)) and entry["of"] == "400"
    assert entry["groups"] == [{"group": [sex], "decisions": str(lost[sex]), "of": str(of[sex])} for sex in sorted(of)]


@pytest.mark.filterwarnings("ignore")
def test_spark_does_not_take_counts_of_a_tally_for_decisions(spark: object, tmp_path: Path) -> None:
    """Nor beside a file that is none, whose columns Spark may take for those of both."""
    part, other = tmp_path / "part.parquet", tmp_path / "log.parquet"
    held = {name: [row[name] for row in log(50)] for name in COLUMNS}
    pd.DataFrame(held).to_parquet(other)
    tally(other, part, COLUMNS)
    frame = spark.read.parquet(str(part))  # type: ignore[attr-defined]
    for source, engine, said in (
        (part, spark, "these are counts that fairaudit tally wrote"),
        ([part, other], spark, "is a tally and .* is none|these are counts"),
        ([other, part], spark, "is a tally and .* is none|these are counts"),
        (frame, "auto", "these are counts that fairaudit tally wrote"),
    ):
        for count in (None, "n"):
            with pytest.raises(InputError, match=said):
                read_log(source, COLUMNS, engine=engine, count=count)


@pytest.mark.filterwarnings("ignore")
def test_spark_takes_json_as_duckdb_does(spark: object, tmp_path: Path) -> None:
    """No type is guessed: a number, a text that looks like one, a truth value, and numbers whose texts differ though they are equal."""
    rows = [{**row, "score": row["age"] / 4, "old": row["age"] > 40, "code": str(row["age"])} for row in log(900)]
    lines = [json.dumps(row, ensure_ascii=bool(i % 2)) for i, row in enumerate(rows)]
    (tmp_path / "log.jsonl").write_text("\n\n".join(lines) + "\r\n")
    (tmp_path / "log.jsonl.gz").write_bytes(gzip.compress("\n".join(lines).encode()))
    half = len(lines) // 2
    for number, part in enumerate((lines[:half], lines[half:])):
        (tmp_path / f"part{number}.ndjson").write_text("\n".join(part) + "\n")
    for name in ("log.jsonl", "log.jsonl.gz", "part*.ndjson"):
        texts, seen = set(), []
        for engine in (spark, "duckdb"):
            held = (*COLUMNS, "age", "run", "score", "old", "code")
            tally = read_log(tmp_path / name, held, bins={"age": [18, 30], "score": ["7.5"]}, engine=engine)
            law = Law.from_log(tally, decision="answer", group=["sex", "old", "code"], context=["dept", "age", "score"], unit="run")
            texts.add(certify(law, {"yes": 1}).certificate.text)
            seen.append(survey_log(tmp_path / name, engine=engine))
        assert len(texts) == 1, name
        assert seen[0] == seen[1], name
    values = ["1.50", "1.5", "1e2", "0.1000000000000000055", "1e400", "-0.0", "123456789012345678901234567890", '"\\u00fc"', '"ü"']
    values += ["true", "null", '""', '"a\\\\b"', '"true "']
    (tmp_path / "values.jsonl").write_text("".join(f'{{"v": {value}, "w": 1}}\n' for value in values) + '{"w": 1}\n', "utf-8")
    found = [dict(zip(map(repr, t["v"]), t.counts.tolist(), strict=True)) for t in read_both(spark, tmp_path / "values.jsonl", "v")]
    assert found[0] == found[1] and len(found[0]) > 8
    for value in ("1", '"1"', "true", '"true"'):
        (tmp_path / "one.jsonl").write_text(f'{{"v": {value}}}\n')
        (first,), (second,) = (t.levels["v"] for t in read_both(spark, tmp_path / "one.jsonl", "v"))
        assert first == second and type(first) is type(second)
    for two in (("1", '"1"'), ("true", '"true"')):
        (tmp_path / "two.jsonl").write_text("".join(f'{{"answer": "yes", "sex": {value}}}\n' for value in two))
        for engine in (spark, "duckdb"):
            with pytest.raises(InputError, match="different values with the same text"):
                Law.from_log(read_log(tmp_path / "two.jsonl", ("answer", "sex"), engine=engine), decision="answer", group="sex")


def read_both(spark: object, path: Path, *columns: str) -> list[Tally]:
    return [read_log(path, columns, engine=engine) for engine in (spark, "duckdb")]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b'{"v": 1}\n{"v": \n', "line 2 is not JSON"),
        (b'{"v": 1}\n\n[1]\n', "line 3 is not a JSON object"),
        (b'{"v": 1} {"v": 2}\n', "line 1 is not JSON"),
        (b'{"v": 1}\n{"v": "\xff"}\n', "line 2 is not UTF-8"),
        (b'{"v": [1, 2]}\n', "a label is a text, a number or a truth value"),
        (b'{"v": NaN}\n', "'NaN', which is not a JSON value"),
        (b'{"w": 1}\n', "there is no column 'v'; known: 'w'"),
        (b"", "no rows"),
    ],
)
def test_spark_refuses_the_json_lines_that_duckdb_refuses(spark: object, tmp_path: Path, content: bytes, said: str) -> None:
    (tmp_path / "log.jsonl").write_bytes(content)
    messages = []
    for engine in (spark, "duckdb"):
        with pytest.raises(InputError, match=re.escape(said)) as error:
            read_log(tmp_path / "log.jsonl", ["v"], engine=engine)
        messages.append(str(error.value))
    assert messages[0] == messages[1] and "\n" not in messages[0]
    (tmp_path / "twice.jsonl").write_text('{"v": 1, "v": 2}\n')
    with pytest.raises(InputError, match="has a key twice"):
        read_log(tmp_path / "twice.jsonl", ["v"], engine=spark)


@pytest.mark.filterwarnings("ignore")
def test_inspect_of_spark_and_duckdb(spark: object, tmp_path: Path) -> None:
    import duckdb

    (tmp_path / "log.csv").write_text(as_csv(log(900)))
    duckdb.sql(f"copy (from '{tmp_path}/log.csv') to '{tmp_path}/log.parquet'")
    for name in ("log.csv", "log.parquet"):
        assert survey_log(tmp_path / name, engine=spark) == survey_log(tmp_path / name, engine="duckdb")
    (tmp_path / "bad.jsonl").write_text('{"v": 1}\n{"v": \n')
    with pytest.raises(InputError, match="line 2 is not JSON"):
        survey_log(tmp_path / "bad.jsonl", engine=spark)


def test_spark_from_the_command_line(tmp_path: Path) -> None:
    pytest.importorskip("pyspark", reason="PySpark is not installed")
    if shutil.which("java") is None:
        absent("Spark needs Java, and there is none on this machine")
    (tmp_path / "log.csv").write_text(as_csv(log()))
    (tmp_path / "log.jsonl").write_text("".join(json.dumps(row) + "\n" for row in log()))
    (tmp_path / "bad.jsonl").write_text('{"answer": "yes", "sex": "f", "dept": "x"}\n{"answer"\n')
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    environment = {name: value for name, value in os.environ.items() if name != "PYSPARK_PYTHON"}
    environment |= {"TMPDIR": str(scratch), "FAIRAUDIT_SPARK_MASTER": "local[2]", "PATH": f"{os.defpath}:/bin:/usr/bin"}
    texts = set()
    for name, engine in (("log.csv", "spark"), ("log.csv", "duckdb"), ("log.jsonl", "spark"), ("log.jsonl", "duckdb")):
        out = tmp_path / "c.json"
        words = [sys.executable, "-m", "fairaudit", "certify", str(tmp_path / name), *COMMAND, "--engine", engine, "-o", str(out)]
        done = subprocess.run(words, capture_output=True, text=True, env=environment, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        texts.add(out.read_text())
    assert len(texts) == 1
    words[4] = str(tmp_path / "bad.jsonl")
    words[words.index("duckdb")] = "spark"
    done = subprocess.run(words, capture_output=True, text=True, env=environment, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"fairaudit: {words[4]}: line 2 is not JSON") and done.stderr.count("\n") == 1
    assert [path.name for path in scratch.iterdir() if path.name.startswith("fairaudit")] == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.jsonl", "c.json", "log.csv", "log.jsonl", "scratch"]


def endless(name: str, folder: Path, url: str = "") -> list[str]:
    """A command whose query does not end."""
    import duckdb

    if name == "duckdb":
        duckdb.connect(str(folder / "t.duckdb")).close()
        url = f"duckdb:{folder / 't.duckdb'}"
    elif name == "sqlite":
        sqlite3.connect(folder / "t.db").close()
        (folder / "t.db").touch()
        url = f"sqlite:{folder / 't.db'}"
    return [sys.executable, "-m", "fairaudit", "certify", url, "--query", ENDLESS[name], *COMMAND, "-o", str(folder / "c.json")]


def until_counting(terminal: int) -> bytes:
    """What appears on a terminal until the progress of a query does."""
    seen = b""
    while b"counting: " not in seen:
        piece = os.read(terminal, 1000)
        if not piece:
            raise AssertionError(seen)
        seen += piece
    return seen


@POSIX
@pytest.mark.parametrize("name", ["duckdb", "sqlite", "postgres"])
@pytest.mark.parametrize("how", [signal.SIGINT, getattr(signal, "SIGKILL", None)])  # Windows has no SIGKILL, and the test skips there
def test_a_query_that_is_stopped_leaves_nothing(name: str, how: signal.Signals, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    url = request.getfixturevalue("postgres") if name == "postgres" else ""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    words = endless(name, tmp_path, url)
    before = sorted(path.name for path in tmp_path.iterdir())
    master, terminal = pytest.importorskip("pty").openpty()
    try:
        started = subprocess.Popen(words, stderr=terminal, stdout=subprocess.PIPE, env={**os.environ, "TMPDIR": str(scratch)})
        os.close(terminal)
        until_counting(master)
        started.send_signal(how)
        out, _ = started.communicate(timeout=60)
    finally:
        os.close(master)
    assert started.returncode == (130 if how == signal.SIGINT else -how)
    assert out == b""
    assert sorted(path.name for path in tmp_path.iterdir()) == before
    if how == signal.SIGINT:
        assert list(scratch.iterdir()) == []
    if name == "postgres":
        return
    # The next run finds nothing in its way.
    finite = ["--query", "select unnest(['yes', 'no', 'yes']) as answer, unnest(['f', 'm', 'm']) as sex, 'x' as dept"]
    if name == "sqlite":
        finite[1] = "select column1 as answer, column2 as sex, 'x' as dept from (values ('yes', 'f'), ('no', 'm'), ('yes', 'm'))"
    assert main([*words[3:5], *finite, *words[7:]]) in (0, 3)
    assert (tmp_path / "c.json").exists()


def many_units(path: Path, rows: int) -> None:
    import duckdb

    duckdb.sql(
        "copy (select if(i % 3 = 0, 'yes', 'no') as answer, if(i % 2 = 0, 'f', 'm') as sex, 'x' as dept, "
        f"md5(i::varchar) || md5((i + 1)::varchar) as run from range({rows}) t(i)) to '{path}'"
    )


@POSIX
def test_a_disk_that_is_full_while_spilling(tmp_path: Path) -> None:
    """No file may grow beyond 64 kB, as on a full disk; the counting does not fit into the memory that it may use."""
    resource = pytest.importorskip("resource")
    many_units(tmp_path / "log.parquet", 1_500_000)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    words = ["certify", str(tmp_path / "log.parquet"), *COMMAND, "--unit", "run", "--memory", "50MB", "-o", str(tmp_path / "c.json")]
    done = subprocess.run(
        [sys.executable, "-m", "fairaudit", *words],
        capture_output=True,
        text=True,
        env={**os.environ, "TMPDIR": str(scratch), "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (65_536, 65_536)),
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("fairaudit: ") and done.stderr.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.parquet", "scratch"]
    assert list(scratch.iterdir()) == []


@POSIX
def test_a_pipe_is_read_once(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    text = as_csv(log())
    (tmp_path / "log.csv").write_text(text)
    writer = subprocess.Popen([sys.executable, "-c", f"open({str(path)!r}, 'w').write({text!r})"])
    out = tmp_path / "c.json"
    assert main(["certify", str(path), *COMMAND, "-o", str(out)]) == 0
    assert writer.wait(30) == 0
    assert out.read_text() == certificate_of(tmp_path / "log.csv")


def certificate_of(path: Path) -> str:
    out = path.with_suffix(".json")
    assert main(["certify", str(path), *COMMAND, "-o", str(out)]) == 0
    return out.read_text()


@POSIX
def test_nothing_is_said_of_progress_but_on_a_terminal(tmp_path: Path) -> None:
    words = endless("duckdb", tmp_path)
    started = subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    time.sleep(3)
    started.send_signal(signal.SIGINT)
    out, err = started.communicate(timeout=60)
    assert (out, err) == (b"", b"fairaudit: interrupted\n")


WRITING = [
    "select 'yes' as answer, 'f' as sex from logs.wrote()",
    "select answer, sex from (select set_config('transaction_read_only', 'off', false)) as off, logs.wrote(), logs.\"Decisions\"",
    "select 'yes' as answer, nextval('logs.places')::text as sex",
    "select 'yes' as answer, 'f' as sex) as log; commit; insert into logs.written values (1); commit; select * from (select 1",
    "select 'yes' as answer, 'f' as sex limit 0) as log; commit; begin read write; insert into logs.written values (1); commit; begin --",
    "with more as (insert into logs.written values (1) returning 1) select 'yes' as answer, 'f' as sex from more",
]


@pytest.mark.parametrize("query", WRITING)
def test_a_query_of_postgres_cannot_write(postgres: str, query: str) -> None:
    """A query may call a function that writes, or close the parentheses around it; the transaction and the protocol refuse both."""
    import psycopg

    with psycopg.connect(postgres, autocommit=True) as connection:
        connection.execute("create table if not exists logs.written (n int); create sequence if not exists logs.places")
        connection.execute(
            "create or replace function logs.wrote() returns int language sql as 'insert into logs.written values (1) returning n'"
        )
        for look in (lambda: read_log(postgres, ["answer", "sex"], query=query), lambda: survey_log(postgres, query=query)):
            with pytest.raises(InputError, match="PostgreSQL says"):
                look()
        assert connection.execute("select count(*) from logs.written").fetchone() == (0,)
        assert connection.execute("select is_called from logs.places").fetchone() == (False,)
        connection.execute("select logs.wrote()")  # which writes where it may
        assert connection.execute("select count(*) from logs.written").fetchone() == (1,)
        connection.execute("truncate logs.written")
