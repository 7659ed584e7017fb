"""Spreadsheets, files of statistics programs, archives, UTF-16 and titles above the header: the same certificate, or one sentence."""

from __future__ import annotations

import bz2
import csv
import datetime
import gzip
import io
import lzma
import random
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import COLUMNS, as_csv, certificate, log

import fairaudit as fa
from fairaudit import InputError
from fairaudit.tables.csv import read_csv
from fairaudit.tables.engines.logs import read_log, survey_log

openpyxl = pytest.importorskip("openpyxl")
pd = pytest.importorskip("pandas")
pyreadstat = pytest.importorskip("pyreadstat")
pytest.importorskip("python_calamine")

PACKED: dict[str, Any] = {".gz": gzip.compress, ".bz2": bz2.compress, ".xz": lzma.compress}

TITLE = "Decisions of 2024 (confidential)"


ROWS = [{**row, "dept": row["dept"].removeprefix("=")} for row in log()]  # a spreadsheet would take =z for a formula


def _frame() -> Any:
    return pd.DataFrame(ROWS)


def _plain() -> dict[str, list[Any]]:
    return {column: [row[column] for row in ROWS] for column in ROWS[0]}


def _text(skip: int = 0) -> str:
    return "".join([f"{TITLE}\n", "\n"][:skip]) + as_csv(ROWS)


def _make(folder: Path, name: str) -> Path:
    path = folder / name
    frame = _frame()
    if name.endswith((".xlsx", ".ods")):
        frame.to_excel(str(path), index=False)
    elif name.endswith(".dta"):
        frame.to_stata(path, write_index=False, version=118)
    elif name.endswith(".sav"):
        pyreadstat.write_sav(frame, path)
    elif name.endswith(".feather"):
        frame.to_feather(path)
    elif name.endswith(".orc"):
        frame.to_orc(path, index=False)
    elif name.endswith(".zip"):
        inside = name.removesuffix(".zip")
        held = _make(folder, inside).read_bytes() if "." in inside else _text().encode()
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(f"export/{inside}", held)
            archive.writestr("__MACOSX/._x", b"")
    else:
        path.write_text(_text(), encoding={"little.csv": "utf-16-le", "big.csv": "utf-16-be"}.get(name, "utf-16"))
        if name in ("little.csv", "big.csv"):
            mark = "\ufeff".encode(f"utf-16-{name[:-4][:1]}e")
            path.write_bytes(mark + path.read_bytes())
    return path


KINDS = ("a.xlsx", "a.ods", "a.dta", "a.sav", "a.feather", "a.orc", "a.csv", "little.csv", "big.csv", "text.zip", "a.xlsx.zip", "a.sav.zip")


@pytest.mark.parametrize("name", KINDS)
def test_every_file_gives_the_certificate_of_the_rows(tmp_path: Path, name: str) -> None:
    path = _make(tmp_path, name)
    assert certificate(read_log(path, COLUMNS)) == certificate(_plain())
    seen = survey_log(path)
    assert seen.rows == len(log())
    assert {column.name for column in seen.columns} >= set(COLUMNS)
    assert certificate(read_log([path], COLUMNS, engine="duckdb")) == certificate(_plain())


@pytest.mark.parametrize("name", ["a.xlsx", "a.csv"])
def test_what_is_above_the_header_is_named_and_skipped(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    if name == "a.xlsx":
        book = openpyxl.Workbook()
        book.active.append([TITLE])
        book.active.append([])
        for row in csv.reader(io.StringIO(_text())):
            book.active.append(row)
        book.save(path)
    else:
        path.write_text(_text(2))
    with pytest.raises(InputError, match=r"line 1 has 'Decisions of 2024 .*--skip 2"):
        read_log(path, COLUMNS)
    assert certificate(read_log(path, COLUMNS, skip=2)) == certificate(_plain())
    with pytest.raises(InputError, match="were to be skipped"):
        read_log(path, COLUMNS, skip=1_000_000)
    with pytest.raises(InputError, match="cannot be skipped"):
        read_log(path, COLUMNS, skip=-1)


def test_a_title_is_named_with_every_separator(tmp_path: Path) -> None:
    for separator in ",;\t|":
        path = tmp_path / "titled.csv"
        path.write_text(f"{TITLE}\n" + separator.join("abc") + "\n" + separator.join("xyz") + "\n")
        with pytest.raises(InputError, match="--skip 1"):
            read_csv(path)
    path.write_text(f"\n\n{TITLE},,\n\na,b,c\nx,y,z\nx,y,z\n")
    with pytest.raises(InputError, match=r"line 3 has .*--skip 4"):
        read_csv(path)


cells = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), max_size=6)


@given(st.lists(st.tuples(cells, cells, cells), min_size=1, max_size=8))
@settings(deadline=None)
def test_a_table_with_a_whole_header_has_no_title(rows: list[tuple[str, str, str]]) -> None:
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows([("decision", "a;b", "group|x"), *rows])
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        path.write_text(text.getvalue(), encoding="utf-8")
        assert read_csv(path).columns == ["decision", "a;b", "group|x"]


def test_columns_without_a_name_are_numbered(tmp_path: Path) -> None:
    path = tmp_path / "indexed.csv"
    _frame().to_csv(path)
    assert read_csv(path).columns[0] == "column 1"
    assert certificate(read_log(path, COLUMNS)) == certificate(_plain())
    assert certificate(read_log(path, COLUMNS, engine="duckdb")) == certificate(_plain())


def test_cells_are_the_labels_that_they_show(tmp_path: Path) -> None:
    path = tmp_path / "cells.xlsx"
    book = openpyxl.Workbook()
    values = (0.1, 3.0, True, datetime.date(2024, 5, 1), "two\nlines", None, 12345678901234)
    book.active.append([f"c{i}" for i in range(len(values))])
    book.active.append([])
    book.active.append(values)
    book.save(path)
    seen = {column.name: list(column.levels) for column in survey_log(path).columns}
    assert seen == {
        "c0": ["0.1"], "c1": ["3"], "c2": ["true"], "c3": ["2024-05-01"], "c4": ["two lines"], "c5": [], "c6": ["12345678901234"]
    }  # fmt: skip
    with pytest.raises(InputError, match=r"cells\.xlsx: .*line 3: the label is missing"):
        fa.audit(path, decision="c1", group="c5", count="c0", utility="3")


def test_codes_have_the_labels_of_their_file(tmp_path: Path) -> None:
    path = tmp_path / "coded.sav"
    frame = pd.DataFrame({"sex": [0, 1, 9, None], "hired": [1.0, 0.0, 1.0, 0.5]})
    pyreadstat.write_sav(frame, path, variable_value_labels={"sex": {0: "woman", 1: "man"}})
    seen = {column.name: (column.levels, column.missing) for column in survey_log(path).columns}
    assert seen == {"sex": ({"9": 1, "man": 1, "woman": 1}, 1), "hired": ({"1": 2, "0": 1, "0.5": 1}, 0)}


def test_counts_and_audit_files_take_them_too(tmp_path: Path) -> None:
    table = fa.example("ucb-admissions").table()
    pd.DataFrame({name: table[name] for name in table.columns}).to_excel(tmp_path / "ucb.xlsx", index=False)
    asked: dict[str, Any] = {"decision": "Admit", "group": "Gender", "context": "Dept", "count": "Freq", "utility": "Admitted"}
    result = fa.audit(tmp_path / "ucb.xlsx", **asked, confidence=None)
    assert str(result.local.ratio) == "24475/18432"


@pytest.mark.parametrize(
    ("name", "held", "options", "said"),
    [
        ("two.zip", {"a.csv": b"a,b\n1,2\n", "b.csv": b"a,b\n1,2\n"}, {}, r"holds 2 files \('a.csv', 'b.csv'\)"),
        ("bad.zip", b"PK\x03\x04rubbish", {}, "cannot be unpacked"),
        ("trap.zip", {"a.csv": b"a,b\n" * 3_000_000}, {}, "unpacks to 12,000,000 bytes"),
        ("bad.xlsx", {"[Content_Types].xml": b"<x/>"}, {}, "the spreadsheet cannot be read"),
        ("old.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1rest", {}, "the spreadsheet cannot be read"),
        ("bad.sav", b"rubbish", {}, "the file cannot be read"),
        ("bad.feather", b"ARROW1rubbish", {}, "the file cannot be read"),
        ("bad.orc", b"ORCrubbish", {}, "the file cannot be read"),
        ("odd.csv", b"\xff\xfea", {}, "begins like UTF-16 and is none"),
        ("a.csv", b"a,b\n1,2\n", {"table": "x"}, "a table goes with a database"),
        ("a.csv", b"a,b\n1,2\n", {"skip": 1, "table": "x"}, "a sheet of a spreadsheet"),
        ("a.jsonl", b'{"a": 1, "b": 2}\n', {"skip": 1}, "lines are skipped above the header of text"),
        ("a.csv", b"a,b\n1,2\n", {"skip": 2}, "the file has no more than that|header line but no rows|the file is empty"),
    ],
)
def test_what_cannot_be_converted_is_refused(tmp_path: Path, name: str, held: Any, options: dict[str, Any], said: str) -> None:
    path = tmp_path / name
    if isinstance(held, bytes):
        path.write_bytes(held)
    else:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for inside, data in held.items():
                archive.writestr(inside, data)
    with pytest.raises(InputError, match=said) as refused:
        read_log(path, ["a", "b"], **options)
    assert "fairaudit-" not in str(refused.value)
    assert str(refused.value).count(str(path)) <= 1


def test_sheets_are_named(tmp_path: Path) -> None:
    path = tmp_path / "two.xlsx"
    with pd.ExcelWriter(path) as writer:
        _frame().to_excel(writer, sheet_name="log", index=False)
        pd.DataFrame({"note": ["x"]}).to_excel(writer, sheet_name="notes", index=False)
    with pytest.raises(InputError, match="the sheets 'log', 'notes'; name one"):
        read_log(path, COLUMNS)
    with pytest.raises(InputError, match=r"no sheet 'logs'.*did you mean 'log'"):
        read_log(path, COLUMNS, table="logs")
    assert certificate(read_log(path, COLUMNS, table="log")) == certificate(_plain())


def test_random_bytes_are_refused_in_a_sentence(tmp_path: Path) -> None:
    source = random.Random(5)
    book = _make(tmp_path, "a.xlsx").read_bytes()
    stata = _make(tmp_path, "a.dta").read_bytes()
    for number in range(60):
        name, good = (("x.xlsx", book), ("x.dta", stata))[number % 2]
        altered = bytearray(good)
        for _ in range(source.randrange(1, 30)):
            altered[source.randrange(len(altered))] = source.randrange(256)
        path = tmp_path / name
        path.write_bytes(altered[: source.randrange(4, len(altered) + 1)])
        try:
            read_log(path, COLUMNS)
        except InputError as error:
            assert "\n" not in str(error)


PROMPTFOO = Path(__file__).parents[1] / "evaluations" / "logs" / "promptfoo" / "loans.jsonl"


def _zipped(held: bytes, name: str) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, held)
    return made.getvalue()


@pytest.mark.parametrize(
    ("name", "packed", "said"),
    [
        ("log.zip", lambda held: _zipped(held, "log.jsonl"), "log.zip: what is inside is a log of promptfoo.*unpack it first"),
        ("log.zip", lambda held: _zipped(held, "log.csv"), "log.zip: what is inside is a log of promptfoo.*unpack it first"),
        ("log.zip", lambda held: _zipped(gzip.compress(held), "log.gz"), "what is inside is a log of promptfoo.*unpack it first"),
        ("log.zip", lambda held: _zipped(_zipped(held, "log.jsonl"), "b.zip"), "what is inside is a log of promptfoo.*unpack it first"),
        ("log.zip", lambda held: _zipped(held.decode().encode("utf-16"), "log.jsonl"), "is a log of promptfoo.*save it as UTF-8 first"),
        ("log.jsonl", lambda held: held.decode().encode("utf-16"), "log.jsonl: what is inside is a log of promptfoo.*save it as UTF-8"),
        ("run.eval.gz", lambda _: gzip.compress(_zipped(b"{}", "_journal/start.json")), "is an archive.*unpack it first"),
    ],
)
def test_a_packed_log_of_an_evaluation_is_never_read_as_rows(tmp_path: Path, name: str, packed: Any, said: str) -> None:
    path = tmp_path / name
    path.write_bytes(packed(PROMPTFOO.read_bytes()))
    for look in (lambda: survey_log(path), lambda: read_log(path, ["score"])):
        with pytest.raises(InputError, match=said):
            look()


@pytest.mark.parametrize("name", ["log.txt.gz", "log.jsonl.bz2", "log.csv.xz"])
def test_packed_objects_whose_name_does_not_say_so_are_never_read_as_rows(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(PACKED[path.suffix](b'{"sex": "f", "hired": "yes"}\n{"sex": "m", "hired": "no"}\n'))
    for look in (lambda: survey_log(path), lambda: read_log(path, ["sex"])):
        with pytest.raises(InputError, match=r"begins like JSON, and is no log of a known format.*\.jsonl\.gz"):
            look()


@pytest.mark.parametrize("name", ["log.csv", "log", "log.txt.gz", "log.csv.gz", "log.jsonl.bz2", "log.xz"])
def test_a_log_of_an_evaluation_is_known_whatever_its_name(tmp_path: Path, name: str) -> None:
    path, held = tmp_path / name, PROMPTFOO.read_bytes()
    path.write_bytes(PACKED.get(path.suffix, bytes)(held))
    found = survey_log(path)
    assert found.samples is not None and found.samples.format == "promptfoo"
    with pytest.raises(InputError, match=r"samples have no answer"):
        read_log(path, ["response.output", "vars.person"], decision="response.output")


def test_spark_reads_no_log_of_an_evaluation(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"loans\.jsonl is a log of promptfoo, which Spark does not read; leave the engine out"):
        read_log(PROMPTFOO, ["score"], engine="spark")


def test_headers_that_begin_like_json_are_headers(tmp_path: Path) -> None:
    for name, packed in (("a.csv", bytes), ("a.csv.bz2", bz2.compress)):
        path = tmp_path / name
        path.write_bytes(packed(b"[sex],[hired]\nf,yes\n"))
        assert read_log(path, ["[sex]", "[hired]"]).rows == 1


def test_a_folder_of_logs_is_named_by_a_pattern_of_logs(tmp_path: Path) -> None:
    (tmp_path / "run.eval").write_bytes(b"")
    with pytest.raises(InputError, match=r"this is a directory; name a file, or a pattern such as '.*\*\.eval'"):
        survey_log(tmp_path)
