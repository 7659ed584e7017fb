"""Numbers as people write them: refused where they could be two numbers, read as declared, the same whatever reads them."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.tables.number_form import either, guessed, number_form, plain_numbers

DOT_COUNTS = "geschlecht;entscheidung;anzahl\nFrauen;bewilligt;943\nFrauen;abgelehnt;1.306\nMänner;bewilligt;1.257\nMänner;abgelehnt;812\n"
COUNTED: dict[str, Any] = {"decision": "entscheidung", "group": "geschlecht", "count": "anzahl", "utility": "bewilligt"}
RATIO = Fraction(1257, 1257 + 812) / Fraction(943, 943 + 1306)
"""60.8 % against 41.9 %."""


def _parquet(path: Path) -> object:
    import duckdb

    target = path.with_suffix(".parquet")
    duckdb.sql(f"copy (select * from read_csv('{path}', all_varchar=true)) to '{target}'")
    return target


def _mapping(path: Path) -> dict[str, list[str]]:
    rows = list(csv.DictReader(io.StringIO(path.read_text()), delimiter=";"))
    return {name: [row[name] for row in rows] for name in rows[0]}


def _frame(path: Path) -> object:
    import pandas as pd

    return pd.DataFrame(_mapping(path))


def _spreadsheet(path: Path) -> object:
    from openpyxl import Workbook

    book = Workbook()
    for row in csv.reader(io.StringIO(path.read_text()), delimiter=";"):
        book.active.append(row)
    book.save(path.with_suffix(".xlsx"))
    return path.with_suffix(".xlsx")


def _sqlite(path: Path) -> object:
    import sqlite3

    database = path.with_suffix(".db")
    with sqlite3.connect(database) as connection:
        connection.execute("create table log (geschlecht text, entscheidung text, anzahl text)")
        connection.executemany("insert into log values (?, ?, ?)", list(zip(*_mapping(path).values(), strict=True)))
    connection.close()
    return f"sqlite:{database}"


HOLDERS: dict[str, Callable[[Path], object]] = {
    "csv": lambda path: path,
    "parquet": _parquet,
    "mapping": _mapping,
    "pandas": _frame,
    "spreadsheet": _spreadsheet,
    "sqlite": _sqlite,
}


@pytest.fixture(params=HOLDERS)
def held(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, Any]:
    for module in {"parquet": ["duckdb"], "pandas": ["pandas"], "spreadsheet": ["openpyxl", "python_calamine"]}.get(request.param, []):
        pytest.importorskip(module)
    path = tmp_path / "dot_counts.csv"
    path.write_text(DOT_COUNTS)
    return {"source": HOLDERS[request.param](path), **({"table": "log"} if request.param == "sqlite" else {})}


def test_dots_that_could_separate_thousands_are_refused_whatever_holds_them(held: dict[str, Any]) -> None:
    with pytest.raises(
        InputError, match=r"'1\.306' may have a decimal point or a thousands separator.*--decimal \..*--thousands \.\) as 1306"
    ):
        fa.audit(**held, **COUNTED)


def test_declared_thousands_are_read_alike_whatever_holds_them(held: dict[str, Any]) -> None:
    result = fa.audit(**held, **COUNTED, thousands=".")
    assert result.global_.ratio == RATIO
    assert result.law.weights.sum() == 943 + 1306 + 1257 + 812


def test_declared_decimals_are_read_alike_whatever_holds_them(held: dict[str, Any]) -> None:
    result = fa.audit(**held, **COUNTED, decimal=".", confidence=None)
    women, men = Fraction(943) / (943 + Fraction("1.306")), Fraction("1.257") / (Fraction("1.257") + 812)
    assert result.global_.ratio == women / men


@pytest.mark.parametrize("line", [2, 3, 4, 5])
def test_one_number_of_other_form_shows_that_dots_are_decimals(tmp_path: Path, line: int) -> None:
    lines = DOT_COUNTS.splitlines()
    lines[line - 1] = lines[line - 1].rpartition(";")[0] + ";1.5"
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    assert fa.audit(tmp_path / "a.csv", **COUNTED, confidence=None).law.weights.sum() > 0


def test_utilities_follow_the_same_rule(tmp_path: Path) -> None:
    path = tmp_path / "thousand_dots.csv"
    path.write_text("geschlecht;gehalt\nw;943\nw;1.306\nm;1.257\nm;1.078\n")
    roles: dict[str, Any] = {"group": "geschlecht", "utility_column": "gehalt", "confidence": None}
    with pytest.raises(InputError, match=r"column 'gehalt', line 3: '1\.306' may have a decimal point"):
        fa.audit(path, **roles)
    assert fa.audit(path, **roles, thousands=".").global_.ratio == Fraction(1257 + 1078, 943 + 1306)
    with pytest.raises(InputError, match="may have a decimal point"):
        fa.audit(_mapping(path), **roles)


def test_commas_in_utilities_are_refused_or_read_as_declared(tmp_path: Path) -> None:
    path = tmp_path / "c_thou.csv"
    path.write_text('sex,salary\nf,"37,611"\nf,943\nm,"84,937"\nm,"28,271"\n')
    roles: dict[str, Any] = {"group": "sex", "utility_column": "salary", "confidence": None}
    with pytest.raises(InputError, match="'37,611' may have a decimal comma or a thousands separator"):
        fa.audit(path, **roles)
    assert fa.audit(path, **roles, thousands=",").global_.ratio == Fraction(84937 + 28271, 37611 + 943)


def test_wide_counts_follow_the_same_rule(tmp_path: Path) -> None:
    path = tmp_path / "dot_wide.csv"
    path.write_text("geschlecht;bewilligt;abgelehnt\nFrauen;943;1.306\nMänner;1.257;812\n")
    roles: dict[str, Any] = {"wide": ["bewilligt", "abgelehnt"], "group": "geschlecht", "utility": "bewilligt"}
    with pytest.raises(InputError, match="may have a decimal point or a thousands separator"):
        fa.audit(path, **roles)
    assert fa.audit(path, **roles, thousands=".").global_.ratio == RATIO


def test_probabilities_of_three_decimals_are_decimals(tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    path.write_text("d,g,p\nyes,f,1.000\nno,f,0\nyes,m,0.125\nno,m,0.875\n")
    assert fa.audit(path, decision="d", group="g", probability="p", utility="yes").global_.ratio == 8


def test_percent_and_currency_signs_are_read_where_they_are_declared(tmp_path: Path) -> None:
    path = tmp_path / "c_pct.csv"
    path.write_text("sex,salary\nf,51.2%\nf,88.0%\nm,64.8%\nm,7%\n")
    roles: dict[str, Any] = {"group": "sex", "utility_column": "salary", "confidence": None}
    with pytest.raises(InputError, match=r"'51\.2%' is not a number.*--number-sign %"):
        fa.audit(path, **roles)
    found = fa.audit(path, **roles, number_sign="%")
    assert found.global_.ratio == Fraction("139.2") / Fraction("71.8")
    assert max(found.global_.witness.expectations) == Fraction("0.696")


@pytest.mark.parametrize(
    ("texts", "form", "plain"),
    [
        (["1.419,78"], {"decimal": ",", "thousands": "."}, ["1419.78"]),
        (["1.419,78", "7,5"], {"thousands": "."}, ["1419.78", "7.5"]),
        (["1,306"], {"decimal": ","}, ["1.3060"]),
        (["1 306", "2\u202f500\u00a0000,5"], {"thousands": " ", "decimal": ","}, ["1306", "2500000.5"]),
        (["1'306.50", "1\u2019000"], {"thousands": "'"}, ["1306.50", "1000"]),
        (["-€ 1.306", "12 €"], {"thousands": ".", "signs": "€"}, ["-1306", "12"]),
        (["7,5", "12", None, 3], {}, ["7.5", "12", None, 3]),
    ],
)
def test_texts_are_written_plainly(texts: list[Any], form: dict[str, Any], plain: list[Any]) -> None:
    assert plain_numbers("n", texts, str, number_form(**form)) == plain


@pytest.mark.parametrize(
    ("texts", "form", "said"),
    [
        (["1.419,78"], {}, "has a dot and a comma"),
        (["1.419,78"], {"decimal": ","}, "--decimal , --thousands ."),
        (["1.306"], {"decimal": ","}, "--decimal , --thousands ."),
        (["1.306.000"], {}, "has thousands separators"),
        (["1.30"], {"thousands": "."}, "separates no group of three digits"),
        (["1.306,5.6"], {"thousands": "."}, "separates no group of three digits"),
        (["1,306"], {"decimal": "."}, "has a comma"),
        (["€5", "$5"], {"signs": ("€", "$")}, "a column has one currency"),
        (["51.2%", "0.4"], {"signs": "%"}, "all numbers of a column bear it, or none"),
    ],
)
def test_texts_that_are_not_as_declared_are_refused(texts: list[str], form: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said.replace("$", r"\$").replace(".", r"\.")):
        plain_numbers("n", texts, str, number_form(**form))


@pytest.mark.parametrize(
    "given",
    [
        {"decimal": ";"},
        {"thousands": "x"},
        {"decimal": ".", "thousands": "."},
        {"signs": "5"},
        {"signs": "e"},
        {"signs": "e5"},
        {"signs": " "},
    ],
)
def test_declarations_that_mean_nothing_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        number_form(**given)


def test_typed_cells_of_a_spreadsheet_stay_what_they_are(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    book = openpyxl.Workbook()
    for row in (("sex", "fee"), ("f", 1.306), ("f", "1.419,78"), ("m", 7.5), ("m", "2.000")):
        book.active.append(row)
    book.save(tmp_path / "fees.xlsx")
    found = fa.audit(tmp_path / "fees.xlsx", group="sex", utility_column="fee", thousands=".", confidence=None)
    assert found.global_.ratio == Fraction("2007.5") / Fraction("1421.086")


def test_a_text_of_another_encoding_is_refused_with_the_way_out_and_read_where_it_is_named(tmp_path: Path) -> None:
    path = tmp_path / "cp1252.csv"
    path.write_bytes(DOT_COUNTS.encode("cp1252"))
    with pytest.raises(InputError, match=r"line 4 is not UTF-8 \(byte 0xe4\).*--encoding cp1252"):
        fa.audit(path, **COUNTED, thousands=".")
    found = fa.audit(path, **COUNTED, thousands=".", encoding="cp1252")
    assert found.global_.ratio == RATIO
    assert ("Männer",) in found.law.groups
    with pytest.raises(InputError, match="is not ascii"):
        fa.audit(path, **COUNTED, thousands=".", encoding="ascii")
    with pytest.raises(InputError, match="the encoding 'rot13' is not known"):
        fa.audit(path, **COUNTED, encoding="rot13")


def test_utf_16_is_read_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(DOT_COUNTS.encode("utf-16"))
    assert fa.audit(tmp_path / "a.csv", **COUNTED, thousands=".").global_.ratio == RATIO


def test_the_command_that_inspect_proposes_reads_the_numbers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import json

    for name, content, words in (
        ("dot_counts", DOT_COUNTS, ["--thousands", "."]),
        ("comma_counts", 'sex,decision,n\nf,yes,943\nf,no,"1,306"\nm,yes,"1,257"\nm,no,812\n', ["--thousands", ","]),
        (
            "c_pct",
            "sex,salary\n" + "".join(f"{sex},{place}.{place % 7}%\n" for sex in "fm" for place in range(3, 40)),
            ["--number-sign", "%"],
        ),
    ):
        path = tmp_path / f"{name}.csv"
        path.write_text(content)
        assert main(["inspect", str(path), "--format", "json"]) == 0
        command = json.loads(capsys.readouterr().out)["result"]["command"]
        assert command[-2:] == words or words[0] in command
        assert main([*command[1:], "--confidence", "none"]) in (0, 3)
        capsys.readouterr()


def test_what_was_declared_is_attested_and_counted_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from fairaudit.attestations.options import options_of, reading_of
    from fairaudit.audits.reading import Access, Reading

    reading = Reading("d", ("g",), count="n", access=Access(encoding="cp1252", form=number_form(",", ".", "€")))
    said = options_of(reading, None)
    assert {name: said[name] for name in ("encoding", "decimal", "thousands", "number_sign")} == {
        "encoding": "cp1252",
        "decimal": ",",
        "thousands": ".",
        "number_sign": ["€"],
    }
    again, _ = reading_of(said)
    assert (again.access.encoding, again.access.form) == ("cp1252", reading.access.form)


def test_labels_that_are_no_numbers_are_not_guessed() -> None:
    assert guessed(["yes", "no"]) is None
    assert guessed(["12", "x1"]) is None


def test_a_percentage_with_an_exponent_is_no_number() -> None:
    assert plain_numbers("n", ["5e1%", "7.5%"], str, number_form(signs="%")) == ["5e1%", "7.5e-2"]


@pytest.mark.parametrize(
    ("texts", "says"), [(["943", "1.306"], True), (["1.306.000"], False), (["1.306,5", "7,5"], False), (["943"], False)]
)
def test_both_readings_are_said_where_they_exist(texts: list[str], says: bool) -> None:
    assert either(texts, number_form(thousands=".")) == ("'1.306' may be 1306 (--thousands .) or 1.306 (--decimal .)" if says else "")


def test_inspect_says_that_both_readings_exist(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "dot_counts.csv"
    path.write_text(DOT_COUNTS)
    assert main(["inspect", str(path)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "both readings exist in column 'anzahl': '1.257' may be 1257 (--thousands .) or 1.257 (--decimal .)" in shown
    path.write_text(DOT_COUNTS.replace("1.306", "1.306.000"))
    assert main(["inspect", str(path)]) == 0
    assert "both readings" not in " ".join(capsys.readouterr().out.split())


def _plainly(text: str, thousands: str, decimal: str) -> Fraction:
    """What a number says, by a plain reading of Python."""
    return Fraction(text.replace(thousands, "").replace(decimal, "."))


@pytest.mark.parametrize(("thousands", "decimal"), [(".", ","), (",", "."), ("'", "."), (" ", ",")])
def test_random_numbers_are_what_a_plain_reading_says(thousands: str, decimal: str) -> None:
    from random import Random

    from fairaudit.exact.rationals import parse_rational

    draw = Random(1306)
    texts = []
    for _ in range(200):
        whole = f"{draw.randrange(10 ** draw.randrange(1, 10)):,}".replace(",", thousands)
        texts.append(whole + (decimal + f"{draw.randrange(10**3):03d}"[: draw.randrange(1, 4)] if draw.random() < 0.5 else ""))
    plain = plain_numbers("n", texts, str, number_form(decimal, thousands), "amount") or texts
    assert [Fraction(*parse_rational(text)) for text in plain] == [_plainly(text, thousands, decimal) for text in texts]


AUDIT = """
[law]
table = "dot_counts.csv"
decision = "entscheidung"
group = "geschlecht"
count = "anzahl"
{more}
[utility]
values = {{ bewilligt = 1, abgelehnt = 0 }}
"""


def test_an_audit_file_declares_the_same(tmp_path: Path) -> None:
    (tmp_path / "dot_counts.csv").write_bytes(DOT_COUNTS.encode("cp1252"))
    path = tmp_path / "AUDIT.toml"
    path.write_text(AUDIT.format(more='encoding = "cp1252"'))
    with pytest.raises(InputError, match=r"'1\.306' may have a decimal point or a thousands separator"):
        fa.audit(path)
    path.write_text(AUDIT.format(more='encoding = "cp1252"\nthousands = "."'))
    found = fa.audit(path)
    assert (found.global_.ratio, found.law.weights.sum()) == (RATIO, 943 + 1306 + 1257 + 812)
    path.write_text(AUDIT.format(more='thousands = "x"'))
    with pytest.raises(InputError, match=r"\[law\] thousands 'x' is not accepted"):
        fa.audit(path)
    with pytest.raises(InputError, match="decimal"):
        fa.audit(path, decimal=",")


def test_an_audit_file_reads_a_utility_as_declared(tmp_path: Path) -> None:
    (tmp_path / "pay.csv").write_text("geschlecht;stufe;gehalt\nw;a;943\nw;b;1.306\nm;c;1.257\nm;d;1.078\n")
    path = tmp_path / "AUDIT.toml"
    law = '[law]\ntable = "pay.csv"\ndecision = "stufe"\ngroup = "geschlecht"\n{}\n[utility]\ncolumn = "gehalt"\n'
    path.write_text(law.format(""))
    with pytest.raises(InputError, match="may have a decimal point or a thousands separator"):
        fa.audit(path)
    path.write_text(law.format('thousands = "."'))
    assert fa.audit(path).global_.ratio == Fraction(1257 + 1078, 943 + 1306)


def test_intervals_are_refused_beside_a_decimal_comma(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("age;fee\n1.306;1.306,5\n12;7,5\n")
    with pytest.raises(InputError, match="are cut from numbers with a decimal point"):
        fa.audit(path, group="age", bins={"age": [18]}, utility_column="fee", thousands=".")


def test_numbers_of_statistics_programs_are_numbers(tmp_path: Path) -> None:
    pyreadstat, pandas = pytest.importorskip("pyreadstat"), pytest.importorskip("pandas")
    frame = pandas.DataFrame({"sex": ["f", "f", "m", "m"], "fee": [1.306, 1.251, 1.257, 2.125], "paid": ["1.306", "943", "1.257", "1.125"]})
    pyreadstat.write_dta(frame, str(tmp_path / "fees.dta"))
    roles: dict[str, Any] = {"group": "sex", "confidence": None}
    fees, paid = Fraction("3.382") / Fraction("2.557"), Fraction(1257 + 1125, 1306 + 943)
    for declared in ({}, {"thousands": "."}, {"decimal": ","}):
        assert fa.audit(tmp_path / "fees.dta", utility_column="fee", **roles, **declared).global_.ratio == fees
    assert fa.audit(tmp_path / "fees.dta", utility_column="paid", **roles, thousands=".").global_.ratio == paid
    with pytest.raises(InputError, match="may have a decimal point or a thousands separator"):
        fa.audit(tmp_path / "fees.dta", utility_column="paid", **roles)
