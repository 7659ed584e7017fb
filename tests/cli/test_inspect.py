"""What `fairaudit inspect` says of a log does not depend on what holds it."""

from __future__ import annotations

import json
import shlex
import sqlite3
from contextlib import closing
from pathlib import Path

import duckdb
import pytest

from fairaudit.cli import main
from fairaudit.tables.engines.logs import survey_log
from fairaudit.tables.engines.survey import MOST

SOURCES = ("log.csv", "log.csv.gz", "log.csv.bz2", "log.csv.xz", "log.jsonl", "log.jsonl.gz", "log.parquet", "part*.csv", "p?.parquet")
DATABASES = (("sqlite:log.db", "decisions"), ("duckdb:log.duckdb", '"Log of ""all"""'))


def said(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[list[str], str]:
    """What inspect prints above its suggestion, and the suggestion."""
    assert main(["inspect", *words]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    *lines, _, _, _, command = out.splitlines()
    return lines, command


@pytest.mark.parametrize("engine", ["auto", "duckdb"])
def test_every_file_shows_the_same(files: dict[str, str], capsys: pytest.CaptureFixture[str], engine: str) -> None:
    expected, _ = said(capsys, files["log.csv"])
    assert expected[0] == "400 rows, 5 columns"
    for name in SOURCES:
        lines, command = said(capsys, files[name], "--engine", engine)
        assert lines == expected, name
        assert main(shlex.split(command)[1:]) in (0, 3)
        capsys.readouterr()


def test_several_files_are_one_log(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    expected, _ = said(capsys, files["log.csv"])
    parts = [files["part*.csv"].replace("*", number) for number in "01"]
    lines, command = said(capsys, *parts)
    assert lines == expected
    assert shlex.split(command)[2:4] == parts


@pytest.mark.parametrize(("url", "table"), DATABASES)
def test_databases_show_the_same(
    files: dict[str, str],
    capsys: pytest.CaptureFixture[str],
    url: str,
    table: str,
) -> None:
    expected, _ = said(capsys, files["log.csv"])
    kind, _, name = url.partition(":")
    for options in (["--table", table], ["--query", f"select * from {table}"]):
        lines, command = said(capsys, f"{kind}:{files[name]}", *options)
        assert lines == expected
        assert options[1] in shlex.split(command)
        assert main(shlex.split(command)[1:]) in (0, 3)
        capsys.readouterr()


@pytest.mark.parametrize("engine", ["python", "duckdb"])
def test_blanks_are_missing_and_case_is_warned_about(tmp_path: Path, capsys: pytest.CaptureFixture[str], engine: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text("answer;sex;score\nyes;f;1,5\nYes;;2,5\nno; ;3\nn/a;m;4\n")
    assert main(["inspect", str(path), "--engine", engine]) == 0
    out, err = capsys.readouterr()
    assert err == "note: the columns are separated by semicolons\n"
    assert "sex     f (1), m (1); 2 missing" in out
    assert "! 'Yes' and 'yes' count as different labels, and differ in spelling alone (--fold-labels, or --map FILE)" in out
    assert "! 'n/a' counts as a level" in out
    assert survey_log(path, engine=engine).columns[2].levels == {"1,5": 1, "2,5": 1, "3": 1, "4": 1}


def test_values_are_counted_where_they_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of a column with more different values than are fetched, what is missing and how many there are is exact all the same."""
    import duckdb

    rows = 3 * MOST
    path = tmp_path / "log.parquet"
    duckdb.sql(
        "copy (select if(i % 2 = 0, 'yes', 'no') as answer, if(i % 3 = 0, 'f', 'm') as sex, if(i = 7, ' ', 'run' || (i // 2)) as run, "
        f"i * 0.25 as score, if(i % 10 = 0, null, i) as id from range({rows}) t(i)) to '{path}'"
    )
    found = survey_log(path)
    run, score, number = found.columns[2:]
    assert (found.rows, run.different, run.missing, len(run.levels)) == (rows, rows // 2, 1, MOST - 1)
    assert (score.different, score.missing, len(score.levels)) == (rows, 0, MOST)
    assert (number.different, number.missing) == (rows * 9 // 10, rows // 10)
    lines, command = said(capsys, str(path))
    assert f"  score   numbers, {rows} different" in lines
    assert f"  id      numbers, {rows * 9 // 10} different; {rows // 10} missing" in lines
    assert main(shlex.split(command)[1:]) in (0, 3)


def test_what_is_in_objects_and_lists_is_shown_by_its_path(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import duckdb

    path = tmp_path / "log.jsonl"
    path.write_text("".join(json.dumps({"answer": u, "sex": "f", "tags": [u], "by": {"who": u}}) + "\n" for u in ("yes", "no", "yes")))
    duckdb.sql(f"copy (select * from read_json('{path}')) to '{tmp_path}/log.parquet'")
    for name in ("log.jsonl", "log.parquet"):
        lines, _ = said(capsys, str(tmp_path / name))
        assert lines[2:] == ["  answer   yes (2), no (1)", "  sex      f (3)", "  tags[0]  yes (2), no (1)", "  by.who   yes (2), no (1)"]


def test_json_is_taken_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    values = ['"1"', "true", "1.50", "null", '""', "1.5", '"2026-01-31"', '"\\u00fc"', '"ü"']
    path.write_text("".join(f'{{"v": {value}, "Answer": "yes"}}\n' for value in values) + '{"Answer": "no"}\n')
    seen = survey_log(path).columns[0]
    assert (seen.levels, seen.different, seen.missing) == ({"1.5": 2, "ü": 2, "1": 1, "2026-01-31": 1, "true": 1}, 5, 3)


@pytest.mark.parametrize(
    ("name", "content", "options", "words"),
    [
        ("none.parquet", None, (), "none.parquet: there is no such file"),
        ("log.jsonl", b'{"a": 1}\n{"a": \n', (), "line 2 is not JSON"),
        ("log.jsonl", b"", (), "log.jsonl"),
        ("log.parquet", b"PAR1 but no more", (), "DuckDB cannot read it"),
        ("log.csv", b"a,b\n1\n", (), "line 2 has 1 cell where the header has 2"),
        ("log.csv", b"a,b\n1\n", ("--engine", "duckdb"), "line 2 has 1 cell where the header has 2"),
        ("log.csv", b"a,b\n1,2,\n", ("--engine", "duckdb"), "line 2 has 3 cells where the header has 2"),
        ("log.csv", b"a,b\n", (), "no rows"),
        ("log.csv", b"a,b\n1,2\n", ("--table", "t"), "a table goes with a database"),
        ("log.csv", b"a,b\n1,2\n", ("--memory", "much"), "'much' is not an amount"),
        ("log.jsonl", b'{"a": 1}\n', ("--engine", "python"), "the engine 'python' reads delimited text"),
        ("log.db", b"SQLite format 3\x00", (), "name it as sqlite:"),
    ],
)
def test_refusals(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, content: bytes | None, options: tuple[str, ...], words: str
) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    assert main(["inspect", str(path), *options]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and words in err


def test_refusals_of_databases(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    for words, expected in (
        (["sqlite:none.db"], "none.db: there is no such file"),
        ([f"sqlite:{files['log.db']}", "--table", "other"], "SQLite cannot read it: no such table: other"),
        ([f"duckdb:{files['log.duckdb']}", "--table", "other"], "DuckDB cannot read it"),
        ([f"sqlite:{files['log.db']}", "--query", "select * from decisions where age < 0"], "the table has no rows"),
        (["duckdb:none.duckdb", "--table", "t"], "none.duckdb: there is no such file"),
        (["postgresql://me:secret@127.0.0.1:1/db", "--table", "t"], "PostgreSQL says"),
    ):
        assert main(["inspect", *words]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and expected in err and "secret" not in err


def test_the_tables_of_a_database_are_listed_and_the_only_one_is_taken(
    files: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    expected, _ = said(capsys, files["log.csv"])
    for url, name in DATABASES:
        kind, _, file = url.partition(":")
        assert main(["inspect", f"{kind}:{files[file]}"]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[: len(expected)] == expected and f"Note: {name} is the only table." in lines
        assert shlex.split(lines[-1])[3:5] == ["--table", name]
        assert main(shlex.split(lines[-1])[1:]) in (0, 3)
        assert main(["certify", f"{kind}:{files[file]}", "--decision", "answer", "--group", "sex", "--utility", "yes"]) == 2
        assert f"holds the table {name}; name one with table (--table)" in capsys.readouterr().err
        assert main(["inspect", files[file]]) == 2
        words = capsys.readouterr().err.partition("is a database; name it as ")[2]
        assert main(["inspect", *shlex.split(words)]) == 0
        assert capsys.readouterr().out.splitlines()[: len(expected)] == expected
    names = ["b", "a.b", *(f"t{i:02}" for i in range(9))]
    with closing(sqlite3.connect(tmp_path / "hr.db")) as database:
        for name in names:
            database.execute(f'create table "{name}" (x integer primary key autoincrement)')
    for given in ("sqlite:hr.db", "hr.db"):
        assert main(["inspect", str(tmp_path / given) if given == "hr.db" else f"sqlite:{tmp_path / 'hr.db'}"]) == 2
        out, err = capsys.readouterr()
        assert out == "" and '"a.b", b, t00, t01, t02, t03, t04, t05, t06, t07 and 1 more' in err and "sqlite_sequence" not in err
    with duckdb.connect(str(tmp_path / "hr.duckdb")) as connection:
        connection.execute("create schema logs; create table logs.people (x int); create view v as select 1 as x")
    assert main(["inspect", f"duckdb:{tmp_path / 'hr.duckdb'}"]) == 2
    assert "holds the tables logs.people, v; name one" in capsys.readouterr().err


WIDE = {
    "dslabs.csv": ("major,gender,admitted,applicants\nA,men,62,825\nA,women,82,108\nB,women,68,25\nB,men,63,560\n", 0),
    "titled.csv": (
        "Applications\n\nDept;hired;rejected;Sex\nA;3;4;f\nA;5;6;m\nTotal;8;10;\n".replace("Applications", "Applications;;;"),
        2,
    ),
    "ranked.csv": ("shown_order,ranked_order\n" + "ann bob,bob ann\nbob ann,bob ann\n" * 9, 0),
}


@pytest.mark.parametrize("name", WIDE)
def test_the_command_for_other_forms_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    text, skip = WIDE[name]
    path = tmp_path / name
    path.write_text(text)
    assert main(["inspect", str(path)]) == 0
    out = capsys.readouterr().out
    command = shlex.split(out.splitlines()[-1])
    assert ("--skip" in command) == bool(skip)
    assert ("'Total' may be a row of totals" in out) == (name == "titled.csv")
    assert ("are taken for percentages; counts are not made of them" in out) == (name == "dslabs.csv")
    assert main(command[1:]) == 0
    capsys.readouterr()


REAL = {
    "ucb_admissions.csv": "--decision Admit --group Gender --context Dept --count Freq --utility Admitted",
    "gpt_resume_first_counts.csv": "--decision decision --group group --context model,job --count n --utility first",
    "bloomberg_gpt_rankings.csv": "--slots shown_order --winner ranked_order --context model,job",
    "hiringbias_firstname.csv": "--decision recommend_interview --group name --context model --utility yes",
    "hiringbias_placebo.csv": "--decision recommend_interview --group placebo --context model --utility yes",
}


@pytest.mark.parametrize("name", REAL)
def test_the_intended_outcome_of_real_tables_is_proposed(data: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    _, command = said(capsys, str(data / name))
    assert shlex.split(command)[3:] == REAL[name].split()


def test_paths_of_a_log_with_objects_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [{"id": n, "who": {"sex": "fm"[n % 2]}, "tags": ["x", "y"], "out": {"hired": "yes" if n % 3 else "no"}} for n in range(60)]
    lines = tmp_path / "log.jsonl"
    lines.write_text("".join(json.dumps(row) + "\n" for row in rows))
    (tmp_path / "log.json").write_text(json.dumps(rows))
    duckdb.sql(f"copy (select * from read_json('{lines}')) to '{tmp_path / 'log.parquet'}'")
    for name in ("log.jsonl", "log.json", "log.parquet"):
        found, command = said(capsys, str(tmp_path / name))
        assert found[0] == "60 rows, 5 columns"
        assert [line.split() for line in found[3:]] == [
            ["who.sex", "f", "(30),", "m", "(30)"],
            ["tags[0]", "x", "(60)"],
            ["tags[last]", "y", "(60)"],
            ["out.hired", "yes", "(40),", "no", "(20)"],
        ]
        assert shlex.split(command)[3:] == ["--decision", "out.hired", "--group", "who.sex", "--utility", "yes"]
        assert main(shlex.split(command)[1:]) == 0
        capsys.readouterr()


LOGS = Path(__file__).parents[1] / "tables" / "evaluations" / "logs"


@pytest.mark.parametrize(
    ("log", "shown", "folded"),
    [
        ("inspect/data_arc_qwen.json", ["id", "epoch", "scores.choice.answer", "eval.model"], ["uuid", "total_time", "eval.config.limit"]),
        ("promptfoo/loans.json", ["metadata.race", "vars.person", "response.output", "promptIdx"], ["latencyMs", "testCase.vars.person"]),
        ("eee/mmlu_samples.jsonl", ["sample_id", "answer", "evaluation_result_id"], ["token_usage.input_tokens", "schema_version"]),
        ("helm/published", ["instance.id", "answer", "stats.exact_match", "stats.exact_match@5"], ["request.temperature"]),
        ("openai/output.jsonl", ["custom_id", "response.body.choices[0].message.content"], ["response.status_code", "response.body.id"]),
    ],
)
def test_what_can_be_audited_is_listed_first(log: str, shown: list[str], folded: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    def listed(*options: str) -> tuple[list[str], str]:
        assert main(["inspect", str(LOGS / log), *options]) == 0
        out = capsys.readouterr().out
        above = out.splitlines()[2:]
        return [line.split()[0] for line in above[: above.index("")] if line.split()[0] not in ("!", "and")], out

    (few, said), (every, whole) = listed(), listed("--all")
    assert {*shown} <= {*few} <= {*every} and {*folded} <= {*every} - {*few}
    assert f"  and {len(every) - len(few)} more paths: --all\n" in said and "more paths" not in whole
    assert said.splitlines()[-1] == whole.splitlines()[-1]
    assert main(["inspect", str(LOGS / log), "--format", "json"]) == 0
    assert [column["name"] for column in json.loads(capsys.readouterr().out)["result"]["columns"]] == every


def test_levels_of_paths_end_where_the_line_does(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "90")
    assert main(["inspect", str(LOGS / "helm" / "published")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  instance.id                 id147 (1), id11 (1), id65 (1), id344 (1), … (10 levels)" in lines
    assert all(len(line) <= 90 for line in lines if ", … (" in line)


def test_rows_of_many_paths_show_those_of_few_labels(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [{"id": n, "a": {"sex": "fm"[n % 2], "text": str(n)}, "t": {f"k{k}": n for k in range(20)}} for n in range(30)]
    path = tmp_path / "log.jsonl"
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    lines, _ = said(capsys, str(path))
    assert [line.split()[0] for line in lines[2:]] == ["id", "a.sex", "and"] and lines[-1] == "  and 21 more paths: --all"
    path.write_text("".join(json.dumps({"id": row["id"], "a": row["a"]}) + "\n" for row in rows))
    lines, _ = said(capsys, str(path))
    assert [line.split()[0] for line in lines[2:]] == ["id", "a.sex", "a.text"]


@pytest.mark.parametrize(("rows", "words"), [(10_000, "numbers, 10000 different"), (10_002, "numbers, more than 10,000 different")])
def test_no_number_is_said_of_labels_that_were_not_all_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: int, words: str
) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text("".join(f'{{"id": {n}, "who": {{"sex": "{"fm"[n % 2]}"}}, "out": "{"yn"[n % 3 > 0]}"}}\n' for n in range(rows)))
    lines, _ = said(capsys, str(path))
    assert lines[2].split(None, 1) == ["id", words]


@pytest.mark.parametrize(
    ("answers", "chosen"), [(("Yes.", "I say no"), ["scores.includes.value", "C"]), (("A", "B"), ["scores.includes.answer", "A"])]
)
def test_sentences_are_no_decisions_where_a_scorer_judged_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], answers: tuple[str, str], chosen: list[str]
) -> None:
    samples = [
        {
            "id": n,
            "epoch": 1,
            "input": "?",
            "target": "x",
            "metadata": {"race": "bw"[n // 2 % 2], "question_polarity": "neg", "context_condition": "ambig"},
            "output": {"choices": [{"stop_reason": "stop", "message": {"role": "assistant", "content": answers[n % 2]}}]},
            "scores": {"includes": {"value": "CI"[n % 2], "answer": answers[n % 2]}},
        }
        for n in range(40)
    ]
    path = tmp_path / "log.json"
    header = {"version": 2, "status": "success", "eval": {"task": "t", "model": "m", "dataset": {"samples": 40}, "config": {}}}
    path.write_text(json.dumps(header | {"samples": samples}))
    lines, command = said(capsys, str(path))
    words = shlex.split(command)
    assert [words[words.index(name) + 1] for name in ("--decision", "--utility")] == chosen
    assert main(["certify", *words[2:], "-o", str(tmp_path / "c.json")]) in (0, 3)
    assert "questions look like those of BBQ" in " ".join(lines) or "--recipe bbq" in " ".join(lines)
