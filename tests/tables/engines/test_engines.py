"""Logs of any size: every engine counts the same rows, and bad input is one sentence wherever it is found."""

from __future__ import annotations

import contextlib
import sqlite3
from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from envelopes import result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import COLUMNS, as_csv, certificate, counts, log

from fairaudit import InputError, Law, Utility
from fairaudit.cli import main
from fairaudit.tables.binning import Bins
from fairaudit.tables.engines.logs import read_log, survey_log
from fairaudit.tables.sql import DIALECTS, count_statement, identifier, table_name
from fairaudit.tables.tally import Tally

SOURCES = ("log.csv", "log.csv.gz", "log.csv.bz2", "log.csv.xz", "log.jsonl", "log.jsonl.gz", "log.parquet", "part*.csv", "p?.parquet")


@pytest.mark.parametrize("name", SOURCES)
@pytest.mark.parametrize("engine", ["auto", "duckdb"])
def test_every_file_gives_the_certificate_of_the_rows(files: dict[str, str], name: str, engine: str) -> None:
    rows = log()
    plain = {column: [row[column] for row in rows] for column in rows[0]}
    assert certificate(read_log(files[name], COLUMNS, engine=engine)) == certificate(plain)
    units = [certificate(t, unit="run") for t in (read_log(files[name], (*COLUMNS, "run"), engine=engine), plain)]
    assert units[0] == units[1]
    bins = {"age": [18, 30, "45", 65.0]}
    binned = read_log(files[name], (*COLUMNS, "age"), bins=bins, engine=engine)
    assert binned.rows == len(rows)
    cut = {**plain, "age": [Bins.of("age", bins["age"]).label_of(age) for age in plain["age"]]}
    said = {"step": "intervals", "column": "age", "edges": ["18", "30", "45", "65"]}
    assert certificate(binned, age=True) == certificate(cut, age=True, cut=[said])


@pytest.mark.parametrize(
    ("url", "options"),
    [
        ("sqlite:{log.db}", {"table": "decisions"}),
        ("sqlite:{log.db}", {"query": "select * from decisions where 1 = 1;"}),
        ("duckdb:{log.duckdb}", {"table": '"Log of ""all"""'}),
        ("duckdb:{log.duckdb}", {"query": 'select * from "Log of ""all""" -- all of them'}),
    ],
)
def test_embedded_databases(files: dict[str, str], url: str, options: dict[str, str]) -> None:
    for name, path in files.items():
        url = url.replace(f"{{{name}}}", path)
    rows = log()
    plain = {column: [row[column] for row in rows] for column in rows[0]}
    assert certificate(read_log(url, COLUMNS, **options)) == certificate(plain)
    bins = {"age": [18, 45]}
    assert counts(read_log(url, ("age", *COLUMNS), bins=bins, **options)) == counts(
        read_log(files["log.csv"], ("age", *COLUMNS), bins=bins)
    )


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_texts_are_counted_as_they_are_however_few_or_rare(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """Texts of which a sample has few are counted as small integers, and those that the sample lacks are not lost."""
    import duckdb

    from fairaudit.tables.engines import duckdb as engine

    labels = st.one_of(st.none(), st.sampled_from(["", " ", "a", "A", "a ", "ä", "a\u0308", "null", "'", "\U0001f600"]))
    rows = data.draw(st.lists(st.tuples(labels, labels), min_size=1, max_size=40))
    folder = tmp_path_factory.mktemp("texts")
    connection = duckdb.connect(str(folder / "log.duckdb"))
    connection.execute("create table log (answer varchar, sex varchar)")
    connection.executemany("insert into log values (?, ?)", rows)
    connection.execute(f"copy log to '{folder / 'log.parquet'}' (format parquet)")
    connection.close()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "SAMPLE", data.draw(st.sampled_from([1, 3, 100])))
        patch.setattr(engine, "FEW", data.draw(st.sampled_from([1, 4, 100])))
        assert counts(read_log(str(folder / "log.parquet"), ["answer", "sex"])) == Counter(rows)
        assert counts(read_log(f"duckdb:{folder / 'log.duckdb'}", ["answer", "sex"], table="log")) == Counter(rows)


def test_collations_do_not_merge_labels(tmp_path: Path) -> None:
    path = tmp_path / "t.db"
    with sqlite3.connect(path) as database:
        database.execute("create table t (u text collate nocase, a text collate rtrim)")
        database.executemany("insert into t values (?, ?)", [("Yes", "f"), ("yes", "f "), ("YES", "f")])
    database.close()
    assert counts(read_log(f"sqlite:{path}", ["u", "a"], table="t")) == Counter({("Yes", "f"): 1, ("yes", "f "): 1, ("YES", "f"): 1})


def test_a_column_that_is_not_there_is_no_text_in_sqlite(files: dict[str, str]) -> None:
    with pytest.raises(InputError, match="there is no column 'gender'"):
        read_log(f"sqlite:{files['log.db']}", ["answer", "gender"], table="decisions")


CELLS = st.sampled_from(
    (
        "yes",
        "no",
        "",
        " ",
        '"',
        '"yes"',
        '""',
        ' "yes"',
        '"yes" ',
        '"a,b"',
        '"a\nb"',
        "é",
        "\x85",
        "a'b",
        "\\",
        "=1",
        "NULL",
        "\x00",
        "x" * 40,
    )
)
ENDS = st.sampled_from(("\n", "\n", "\n", "\r\n", "\r", "\n\n", ",\n", ',""\n', " \n", ",x\n"))


@given(st.data())
def test_duckdb_reads_text_as_the_csv_reader_does(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """Odd quotes, blanks, line ends and widths: the same counts, or the same refusal."""
    width = data.draw(st.integers(2, 3))
    end = data.draw(st.one_of(st.just("\n"), st.just("\r\n"), st.none()))
    rows = data.draw(st.lists(st.lists(CELLS, min_size=width, max_size=width), max_size=6))
    parts = [data.draw(st.sampled_from(("", "", "", "\ufeff", "\n"))), ",".join("abc"[:width]), end or "\n"]
    for row in rows:
        parts += [",".join(row), end or data.draw(ENDS)]
    path = tmp_path_factory.getbasetemp() / "odd.csv"
    path.write_bytes("".join(parts).encode())
    outcomes = []
    for engine in ("python", "duckdb"):
        try:
            tally = read_log(path, ["b", "a"], engine=engine)
            # A cell without text is missing, however it is written.
            found = Counter()
            for row, n in counts(tally).items():
                found[tuple(cell or None for cell in row)] += n
            outcomes.append(found)
        except InputError as error:
            outcomes.append(str(error))
    assert outcomes[0] == outcomes[1]


NUMBERS = st.one_of(
    st.integers(-5, 100).map(str),
    st.decimals(-5, 100, places=3).map(str),
    st.sampled_from(
        (
            "18",
            "18.0",
            "1.8e1",
            "17.99999999999999999999",
            "18.00000000000000000001",
            "0.3",
            "0.29999999999999999999",
            " 30",
            "1/3",
            "",
            "-0",
            "1e400",
            "1e-400",
        )
    ),
)


@settings(max_examples=40)
@given(st.lists(NUMBERS, min_size=1, max_size=12))
def test_intervals_are_exact(tmp_path_factory: pytest.TempPathFactory, cells: list[str]) -> None:
    """Texts next to an edge are not rounded onto it, in either reader."""
    path = tmp_path_factory.getbasetemp() / "numbers.csv"
    path.write_text("age,u\n" + "".join(f"{cell},y\n" for cell in cells))
    edges = ["0", "0.3", "18", "65"]
    labels = ("under 0", "0 to under 0.3", "0.3 to under 18", "18 to under 65", "65 and over")

    def interval(cell: str) -> str | None:
        return labels[sum(Fraction(cell.strip()) >= Fraction(edge) for edge in edges)] if cell else None

    expected = Counter((interval(cell),) for cell in cells)
    for engine in ("python", "duckdb"):
        assert counts(read_log(path, ["age"], bins={"age": edges}, engine=engine)) == expected


@pytest.mark.parametrize("engine", ["python", "duckdb"])
def test_an_interval_needs_numbers(tmp_path: Path, engine: str) -> None:
    path = tmp_path / "t.csv"
    for cell in ("old", "nan", "inf", "0x10", "1_000", "=30", "30 to under 65"):
        path.write_text(f"age,u\n30,y\n{cell},n\n30,y\n")
        with pytest.raises(InputError, match=r"column 'age', line 3: .* is not a number such as .*; intervals need numbers"):
            read_log(path, ["age", "u"], bins={"age": [18, 65]}, engine=engine)


def test_values_that_are_not_finite_are_in_no_interval(tmp_path: Path) -> None:
    import duckdb

    path = tmp_path / "t.parquet"
    for value in ("nan", "inf", "-inf"):
        duckdb.sql(f"copy (select unnest([1.5, '{value}'::double, null]) as age, 'y' as u) to '{path}'")
        with pytest.raises(InputError, match=r"column 'age'.*infinite or not numbers"):
            read_log(path, ["age", "u"], bins={"age": [18]})


def test_nan_is_in_no_interval_though_statistics_do_not_know_of_it(tmp_path: Path) -> None:
    """Most writers of Parquet leave NaN out of a column's statistics, and DuckDB concludes that nothing is above the greatest value."""
    import duckdb
    import pyarrow as pa
    from pyarrow import parquet

    path = tmp_path / "t.parquet"
    parquet.write_table(pa.table({"age": [1.5, float("nan"), 2.0], "u": ["y", "n", "y"]}), path)
    for source in (path, duckdb.read_parquet(str(path))):
        with pytest.raises(InputError, match=r"column 'age'.*infinite or not numbers"):
            read_log(source, ["age", "u"], bins={"age": [1]})


@pytest.mark.parametrize(
    ("values", "kind", "edges"),
    [
        ([0.3, 0.1, 0.7], "float", ["0.3", "0.7"]),  # as float32 the first is above 3/10, the last below 7/10
        ([0.3, 0.1, 0.7], "double", ["0.3", "0.7"]),
        ([2**24, 2**24 + 2], "float", [2**24 + 1]),
        ([2**53, 2**53 + 2], "double", [2**53 + 1]),
        ([2**53, 2**53 + 1], "bigint", [f"{2**53}.5"]),
        ([2**62 - 1, 2**62], "bigint", [2**62]),
    ],
)
def test_every_holder_of_a_number_cuts_it_alike(tmp_path: Path, values: list[float], kind: str, edges: list[Any]) -> None:
    """As `Bins.label_of` does: a number is what it is, and a float is compared with the edge rounded to float64."""
    import duckdb
    import polars as pl
    from pyarrow import parquet

    path = str(tmp_path / "t.parquet")
    duckdb.sql(f"copy (select unnest({values})::{kind} as v, 'y' as u) to '{path}'")
    table = parquet.read_table(path)
    bins = Bins.of("v", edges)
    expected = Counter((bins.label_of(value),) for value in table["v"].to_pylist())
    for source in (path, table, table.to_pandas(), pl.read_parquet(path), pl.scan_parquet(path), duckdb.read_parquet(path)):
        assert counts(read_log(source, ["v"], bins={"v": edges})) == expected, type(source)


@pytest.mark.parametrize(
    ("edges", "words"), [([], "no edge"), ([3, 3], "must rise"), (["x"], "not a number"), (["1/3"], "decimals"), ([float("nan")], "edge")]
)
def test_edges(edges: list[Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Bins.of("age", edges)


def run(*words: object) -> int:
    return main([str(word) for word in words])


COMMAND = ("--decision", "answer", "--group", "sex", "--context", "dept", "--utility", "yes")


def test_the_command_line_reads_every_source(files: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Several files, patterns, databases and engines: one certificate."""
    folder = Path(files["log.csv"]).parent
    texts = set()
    for words in (
        [files["log.csv"]],
        [files["log.csv"], "--engine", "duckdb"],
        [files["log.parquet"]],
        [files["part*.csv"]],
        [folder / "part0.csv", folder / "part1.csv"],
        [f"sqlite:{files['log.db']}", "--table", "decisions"],
        [f"duckdb:{files['log.duckdb']}", "--query", 'select * from "Log of ""all"""'],
    ):
        out = tmp_path / "c.json"
        assert run("certify", *words, *COMMAND, "-o", out) == 0, capsys.readouterr().err
        texts.add(out.read_text())
    assert len(texts) == 1
    capsys.readouterr()


def test_intervals_on_the_command_line(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    for group, context, expected in (("sex", "dept,age:18,30,65", ("dept", "age")), ("age:18,sex", "dept", ("dept",))):
        assert run(
            "certify",
            files["log.parquet"],
            "--decision=answer",
            f"--group={group}",
            f"--context={context}",
            "--utility=yes",
            "--format=json",
        ) in (0, 3)
        document = result_of(capsys.readouterr().out)
        assert tuple(document["subject"]["columns"]["context"]) == expected
        header = document["subject"]["table"]["header"]
        labels = [label[-1] for label in header["contexts"]] if "age" in expected else [label[0] for label in header["groups"]]
        assert set(labels) == (
            {"under 18", "18 to under 30", "30 to under 65", "65 and over"} if "age" in expected else {"under 18", "18 and over"}
        )


def test_a_utility_column_comes_back_exact(tmp_path: Path) -> None:
    rows = log()
    text = {"yes": "0.1", "no": "0", "maybe, later": "1/3"}
    (tmp_path / "t.csv").write_text(as_csv([{**row, "worth": text[row["answer"]]} for row in rows]))
    tally = read_log(tmp_path / "t.csv", (*COLUMNS, "worth"), engine="duckdb")
    utility = Utility.from_table(tally, utility="worth", decision="answer", group="sex", context="dept")
    assert utility.values == {"yes": Fraction(1, 10), "no": 0, "maybe, later": Fraction(1, 3)}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_print_sql(dialect: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = (
        "certify",
        "--print-sql",
        dialect,
        "--table",
        "s.decisions",
        "--decision",
        "answer",
        "--group",
        "sex",
        "--context",
        "age:18,30",
        "--utility=yes",
    )
    assert run(*words) == 0
    out = capsys.readouterr().out
    quote = "`" if dialect in ("spark", "bigquery") else '"'
    assert f"{quote}s{quote}.{quote}decisions{quote}" in out
    assert "--count row_count" in out and "then '18 to under 30'" in out


def test_the_printed_statement_runs_and_its_result_is_read_back(
    files: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import csv
    import shlex

    import duckdb

    options = ("--decision", "answer", "--group", "sex", "--context", "dept,age:18,30", "--utility", "yes=1,maybe\\, later=1")
    options = (*options[:-1], 'yes=1,"maybe, later"=1')
    results = []
    for dialect, path in (("duckdb", files["log.parquet"]), ("sqlite", files["log.db"])):
        query = ("--query", f"select * from '{path}'") if dialect == "duckdb" else ("--table", "decisions")
        assert run("certify", "--print-sql", dialect, *query, *options) == 0
        comment, _, statement = capsys.readouterr().out.partition("\n")
        if dialect == "duckdb":
            result = duckdb.sql(statement)
            header, rows = result.columns, result.fetchall()
        else:
            with sqlite3.connect(path) as database:
                cursor = database.execute(statement)
                header, rows = [entry[0] for entry in cursor.description], cursor.fetchall()
            database.close()
        with (tmp_path / "result.csv").open("w", newline="") as file:
            csv.writer(file).writerows([header, *rows])
        command = shlex.split(comment.partition("then: ")[2])[1:]
        command[1] = str(tmp_path / "result.csv")
        assert main([*command, "--format=json"]) in (0, 3)
        results.append(result_of(capsys.readouterr().out)["metrics"]["local"]["ratio"])
    assert run("certify", files["log.csv"], *options, "--format=json") in (0, 3)
    assert {result_of(capsys.readouterr().out)["metrics"]["local"]["ratio"]} == set(results)


NAMES = st.text(st.characters(exclude_characters="\x00", exclude_categories=["Cs"]), min_size=1, max_size=8)


@given(st.lists(NAMES, min_size=1, max_size=3, unique_by=lambda name: name.lower()), st.text(max_size=8))
def test_names_and_labels_are_no_sql(names: list[str], label: str) -> None:
    """Quotes, comments and semicolons in names of columns and tables, and in labels, stay what they are."""
    with sqlite3.connect(":memory:") as database:
        held = ", ".join(identifier(name, "sqlite") for name in names)
        table = identifier(names[0] + "'; drop table x", "sqlite")
        database.execute(f"create table {table} ({held})")
        value = label.encode("utf-8", "replace").decode().replace("\x00", "")
        database.execute(f"insert into {table} values ({', '.join('?' * len(names))})", [value] * len(names))
        found = database.execute(count_statement(names, table, "sqlite")).fetchall()
    database.close()
    assert found == [(*[value] * len(names), 1)]


def test_a_schema_that_is_not_utf8(tmp_path: Path) -> None:
    """SQLite's own message quotes the bytes."""
    path = tmp_path / "log.db"
    with sqlite3.connect(path) as connection:
        connection.execute("create table t (answer, sex)")
        connection.execute("insert into t values ('yes', 'f')")
    connection.close()
    whole = path.read_bytes()
    for text in (b"(answer, sex)", b"TABLE t", b"create", b"answer"):
        for name in (b"t", text):
            path.write_bytes(whole.replace(name, b"\xf2" + name[1:]))
            for look in (lambda: read_log(f"sqlite:{path}", ["sex"], table="t"), lambda: survey_log(f"sqlite:{path}", table="t")):
                with contextlib.suppress(InputError):
                    look()


@pytest.mark.parametrize("content", [b"\xef", b"\xef\xbb"])
@pytest.mark.parametrize("command", [["inspect"], ["certify", "--decision", "a", "--group", "b", "--utility", "1"]])
def test_a_cut_byte_order_mark_is_not_utf8(tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes, command: list[str]) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    for more in ([], ["--engine", "duckdb"], ["--count", "c"] if len(command) > 1 else []):
        assert main([command[0], str(path), *command[1:], *more]) == 2
        said = f"fairaudit: {path}: line 1 is not UTF-8 (byte 0xef); save the file as UTF-8, or name its encoding"
        assert capsys.readouterr().err == f"{said}, such as encoding='cp1252' (--encoding cp1252)\n"


@pytest.mark.parametrize("text", ["", ".", "a.", "a b; drop", 'a"b', '"a'])
def test_names_of_tables(text: str) -> None:
    if text == "a b; drop":
        assert table_name(text, "duckdb") == '"a b; drop"'
        return
    with pytest.raises(InputError):
        table_name(text, "duckdb")


def bad_line(path: Path, line: str, rows: int) -> Path:
    """A log with one bad line among many."""
    good = b"yes,f,x,1\nno,m,x,2\nno,f,y,3\nyes,m,y,4\n"
    half = rows // 8
    path.write_bytes(b"answer,sex,dept,age\n" + good * half + line.encode("utf-8", "surrogateescape") + b"\n" + good * half)
    return path


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("yes,f,x", "has 3 cells where the header has 4"),
        ("yes,f,x,1,2", "has 5 cells where the header has 4"),
        ("yes,f,x,1,", "has 5 cells where the header has 4"),
        ("yes,f,x,1,,,", "has 7 cells where the header has 4"),
        ('yes,"f"x,x,1', "text follows the end of a quoted cell"),
        ("yes,f,x,\udcff", "is not UTF-8 (byte 0xff)"),
        ("yes,f,x,\x00", "has a NUL character"),
        ("yes,,x,1", "the label is missing (1 in all)"),
    ],
)
@pytest.mark.parametrize("engine", ["duckdb", "python"])
def test_one_bad_line_among_many_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str], line: str, words: str, engine: str) -> None:
    path = bad_line(tmp_path / "log.csv", line, 40_000)
    before = sorted(tmp_path.iterdir())
    assert run("certify", path, *COMMAND, "--engine", engine, "-o", tmp_path / "c.json") == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and words in err
    assert "line 20002" in err
    assert sorted(tmp_path.iterdir()) == before


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3])


def _scribble(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[4:400] = b"\xff" * 396
    path.write_bytes(bytes(data))


def _footer(path: Path) -> None:
    data = path.read_bytes()
    start = len(data) - 8 - int.from_bytes(data[-8:-4], "little")
    path.write_bytes(data[:start] + b"\xff" * 32 + data[start + 32 :])


@pytest.mark.parametrize("spoil", [_cut, _scribble, _footer])
def test_damaged_parquet_is_refused(
    files: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str], spoil: Callable[[Path], None]
) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(Path(files["log.parquet"]).read_bytes())
    spoil(path)
    assert run("certify", path, *COMMAND, "-o", tmp_path / "c.json") == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and err.startswith("fairaudit: ")
    assert [entry.name for entry in tmp_path.iterdir()] == ["log.parquet"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('{"answer": "yes", "sex": "f", "dept": "x"}\n{"answer": "no", "sex"\n', "line 2"),
        ('{"answer": "yes", "sex": 1, "dept": "x"}\n{"answer": "no", "sex": "1", "dept": "x"}\n', "different values with the same text"),
        ('{"answer": "yes", "sex": {"a": 1}, "dept": "x"}\n', "a label is a text, a number or a truth value"),
        ('{"answer": "yes", "sex": "f"}\n', "there is no column 'dept'"),
        ('{"answer": "yes", "sex": "f", "dept": "x"}\n{"answer": "no", "dept": "x"}\n', "the label is missing"),
        ('{"answer": "yes", "sex": "\\ud800", "dept": "x"}\n', "fairaudit: "),
        ("", "fairaudit: "),
        ("[1, 2]\n", "fairaudit: "),
    ],
)
def test_json_lines_that_do_not_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str, words: str) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text(content)
    assert run("certify", path, *COMMAND, "-o", tmp_path / "c.json") == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and words in err
    assert [entry.name for entry in tmp_path.iterdir()] == ["log.jsonl"]


def test_files_that_do_not_belong_together(files: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import duckdb

    other = tmp_path / "other.csv"
    other.write_text("answer,sex,age\nyes,f,1\n")
    dangling = tmp_path / "z.parquet"
    dangling.symlink_to(tmp_path / "gone.parquet")
    (tmp_path / "a.parquet").write_bytes(Path(files["log.parquet"]).read_bytes())
    mixed = tmp_path / "mixed"
    mixed.mkdir()
    duckdb.sql(f"copy (select 'yes' as answer, 1 as sex, 'x' as dept) to '{mixed}/1.parquet'")
    duckdb.sql(f"copy (select 'yes' as answer, 'f' as sex, 'x' as dept) to '{mixed}/2.parquet'")
    for words, said in (
        ([files["log.csv"], other], "the header line differs"),
        ([files["log.csv"], other, "--engine=duckdb"], "the header line differs"),
        ([files["log.csv"], files["log.parquet"]], "one format"),
        ([tmp_path / "none*.parquet"], "none that the pattern fits"),
        ([tmp_path / "*.parquet"], "there is no such file"),
        ([files["log.csv"], files["log.csv"]], "named twice"),
        ([mixed / "*.parquet"], "write it with one type in files that are read together"),
        ([tmp_path], "this is a directory"),
        ([files["log.db"]], "is a database"),
        ([f"sqlite:{files['log.db']}"], "--table"),
        ([f"sqlite:{files['log.db']}", "--table", "nothing"], "no such table"),
        ([f"sqlite:{tmp_path}/none.db", "--table", "t"], "there is no such file"),
        ([f"duckdb:{tmp_path}/none.db", "--table", "t"], "there is no such file"),
        ([files["log.csv"], "--table", "t"], "goes with a database"),
        (["oracle://me:secret@host/db", "--table", "t"], "fairaudit: "),
    ):
        assert run("certify", *words, *COMMAND, "-o", tmp_path / "c.json") == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and said in err, (words, err)
        assert "secret" not in err
    assert not (tmp_path / "c.json").exists()


def test_patterns_in_names_are_not_patterns(tmp_path: Path) -> None:
    for name in ("a[1].csv", "a*.csv", "a?.csv", "it's.csv", "a;b.csv"):
        path = tmp_path / name
        path.write_text("u,a\ny,f\n")
        assert read_log(path, ["u", "a"], engine="duckdb").rows == 1


def test_counts_need_not_be_csv(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Counts and probabilities in Parquet and in databases, for every command that reads tables."""
    import duckdb

    rows = "('yes', 'f', 3, 0.75), ('no', 'f', 1, 0.25), ('yes', 'm', 1, 0.5), ('no', 'm', 1, 0.5)"
    table = f"select * from (values {rows}) t(answer, sex, n, p)"
    duckdb.sql(f"copy ({table}) to '{tmp_path}/t.parquet'")
    duckdb.sql(f"copy ({table}) to '{tmp_path}/t.jsonl' (format json)")
    with sqlite3.connect(tmp_path / "t.db") as database:
        database.execute("create table t (answer, sex, n, p)")
        database.executescript(f"insert into t values {rows}")
    database.close()
    (tmp_path / "audit.toml").write_text(
        '[law]\ntable = "t.parquet"\ndecision = "answer"\ngroup = "sex"\ncount = "n"\n[utility]\nvalues = {yes = 1}\n'
    )
    sources = ([f"{tmp_path}/t.parquet"], [f"{tmp_path}/t.jsonl"], [f"sqlite:{tmp_path}/t.db", "--table", "t"])
    for words in sources:
        for value in ("--count=n", "--probability=p"):
            assert run("certify", *words, "--decision=answer", "--group=sex", value, "--utility=yes", "--format=json") in (0, 3)
            found = result_of(capsys.readouterr().out)
            assert found["metrics"]["local"]["ratio"] == "3/2"
        assert run("worst-case", *words, "--decision=answer", "--group=sex", "--count=n", "--tau=0.1") == 0
        capsys.readouterr()
    assert run("certify", tmp_path / "audit.toml", "--format=json") in (0, 3)
    assert result_of(capsys.readouterr().out)["metrics"]["local"]["ratio"] == "3/2"


def test_rows_of_counts_that_are_equal_add_up_and_probabilities_do_not() -> None:
    tally = Tally.of("t", ("u", "a", "n"), [("y", "f", 2, 2), ("n", "f", 1, 1), ("y", "m", "0.5", 4), ("n", "m", 1, 1)])
    assert Law.from_counts(tally, decision="u", group="a", count="n").weights.tolist() == [[2, 8], [2, 4]]
    with pytest.raises(InputError, match="occurs 2 times"):
        Law.from_probabilities(tally, decision="u", group="a", probability="n")


@pytest.mark.parametrize("memory", ["lots", "-1GB", "5", "1e9 GB", ""])
def test_an_amount_of_memory(files: dict[str, str], memory: str) -> None:
    with pytest.raises(InputError, match="is not an amount such as"):
        read_log(files["log.parquet"], COLUMNS, memory=memory)


@pytest.mark.parametrize(
    "query",
    [
        "select 1) as log; copy (select 1) to '{written}'; select * from (select 1",
        "select 'yes' as answer, 'f' as sex) as log; copy (select 1) to '{written}' --",
    ],
)
def test_a_query_of_duckdb_cannot_write_files(files: dict[str, Path], tmp_path: Path, query: str) -> None:
    """A database that is opened for reading does not keep statements from writing elsewhere."""
    written = tmp_path / "written.csv"
    database, asked = f"duckdb:{files['log.duckdb']}", query.format(written=written)
    for look in (lambda: read_log(database, ["answer", "sex"], query=asked), lambda: survey_log(database, query=asked)):
        with pytest.raises(InputError, match=r"one, a SELECT|DuckDB cannot read it"):
            look()
    assert not written.exists()
