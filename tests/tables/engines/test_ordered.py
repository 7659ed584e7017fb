"""A table of counts or probabilities is the same, and is refused in the same words, whoever reads its text."""

from __future__ import annotations

import csv
import io
import random
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.audits import reading
from fairaudit.audits.audit_file import read_audit
from fairaudit.cli import main
from fairaudit.tables.engines.logs import log_request
from fairaudit.tables.engines.ordered import read_ordered

LABELS = [
    "a",
    " a",
    "A",
    "007",
    "7",
    "1.0",
    "",
    " ",
    "NaN",
    "null",
    "\u202ea",
    "e\u0301",
    'x"y',
    "x,y",
    "x;y",
    "x\ny",
    "\ufeff",
    "-",
    "日本",
    "'",
]
NUMBERS = ["3", "5", "1", "0", "007", "12", "1.0", "1e3", "1/3", "9223372036854775808", "999999999999999", "0.1", "0,5"]
WRONG = ["-1", "", "nan", "inf", "x", "1,234", "٣", "1_0", "0x1", " 5", "\x00", "1e99999", "1/0"]


def outcome(path: Path, asked: dict[str, Any], *, by_engine: bool) -> str:
    """The certificate with what is said of it, or why there is none."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reading, "SMALL", -1 if by_engine else 10**18)
        try:
            found = fa.audit(path, **asked)
        except fa.InputError as error:
            return str(error)
    return found.certificate.text + repr(found.law.notes) + found.sentence


def text_of(rows: list[list[str]], data: st.DataObject) -> bytes:
    """A delimited text, as somebody might have exported it."""
    delimiter = data.draw(st.sampled_from([",", ",", ";", "\t", "|"]))
    quoting = data.draw(st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONE]))
    ending = data.draw(st.sampled_from(["\n", "\n", "\r\n", "\r"]))
    written = io.StringIO()
    writer = csv.writer(
        written, delimiter=delimiter, quoting=quoting, lineterminator=ending, escapechar="\\" if quoting == csv.QUOTE_NONE else None
    )
    writer.writerows(rows)
    text = written.getvalue()
    if data.draw(st.integers(0, 5)) == 0:
        place = data.draw(st.integers(0, len(text)))
        text = text[:place] + data.draw(st.sampled_from(["\n", ending, ending * 2, '"', delimiter, "\x00", " ", "é"])) + text[place:]
    mark = "\ufeff" if data.draw(st.integers(0, 5)) == 0 else ""
    return (mark + text).encode(data.draw(st.sampled_from(["utf-8"] * 9 + ["latin-1"])), "replace")


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_both_readers_say_the_same_of_any_text(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    path = tmp_path_factory.mktemp("texts") / "table.csv"
    number = st.sampled_from(NUMBERS + (WRONG if data.draw(st.integers(0, 4)) == 0 else []))
    label = st.sampled_from(data.draw(st.sampled_from([LABELS, LABELS[:2], ["a", "b", "c"]])))
    row = st.tuples(st.sampled_from(["yes", "no"]), label, label, number, number).map(list)
    rows = data.draw(st.lists(row, max_size=14))
    header = data.draw(st.sampled_from([["u", "a", "x", "n", "w"], ["u", "A", "a", "n", "w"], ["u", "a", "", "n", "n"]]))
    path.write_bytes(text_of([header, *rows], data))
    group, context = ("a", "A" if "A" in header else "x")
    asked = {
        "decision": "u",
        "group": group,
        "context": context,
        "missing": data.draw(st.sampled_from(["error", "drop", "group", "unknown"])),
    }
    kind = data.draw(st.sampled_from(["count", "count", "probability", "weight", "utility", "fold"]))
    asked |= {"count": "n", "utility": "yes"} if kind in ("count", "fold") else {}
    asked |= {"probability": "n", "utility": "yes"} if kind in ("probability", "weight") else {}
    asked |= {"count": "n", "utility_column": "w"} if kind == "utility" else {}
    asked |= {"weight": "w"} if kind == "weight" else {"fold_labels": True} if kind == "fold" else {}
    assert outcome(path, asked, by_engine=True) == outcome(path, asked, by_engine=False)


def test_an_engine_reads_big_tables_and_the_rows_keep_their_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = random.Random(1)
    shops = [f"s{drawn.randrange(10**6)}" for _ in range(30_000)]
    path = tmp_path / "big.csv"
    counts = [(shop, sex, hired, drawn.randrange(1, 10**6)) for shop in shops for sex in "fm" for hired in ("yes", "no")]
    path.write_text("shop,note,n,sex,hired\n" + "".join(f"{shop},,{n},{sex},{hired}\n" for shop, sex, hired, n in counts))
    request = log_request(["hired", "sex", "shop", "n"], count="n")
    table = read_ordered(str(path), request, ["n"])
    assert table is not None and len(table) == len(counts)
    assert [*table["shop"]] == [shop for shop, *_ in counts] and table["sex"][:3] == ["f", "f", "m"]
    assert isinstance(table["n"], np.ndarray) and table["n"].tolist() == [n for *_, n in counts]
    assert [table.locate(i) for i in (0, 70_000, len(counts) - 1)] == ["line 2", "line 70002", f"line {len(counts) + 1}"]
    law = fa.Law.from_counts(table, decision="hired", group="sex", context="shop", count="n")
    assert law.contexts == tuple((shop,) for shop in dict.fromkeys(shops)) and law.decisions == ("yes", "no")
    assert int(law.weights.sum()) == sum(n for *_, n in counts)
    monkeypatch.setattr(reading, "SMALL", 10**6)
    monkeypatch.setattr(reading, "read_csv", None)
    assert (
        fa.audit(path, decision="hired", group="sex", context="shop", count="n", utility="yes", confidence=None).law.contexts
        == law.contexts
    )


def test_probabilities_never_pass_through_a_float(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "p.csv"
    long = "0.333333333333333333333333333333333333333333333"
    rest = "0.666666666666666666666666666666666666666666667"
    path.write_text(f"u,a,p\nyes,f,{long}\nno,f,{rest}\nyes,m,1/7\nno,m,6/7\n")
    monkeypatch.setattr(reading, "SMALL", -1)
    law = fa.audit(path, decision="u", group="a", probability="p", utility="yes").law
    rows = [[Fraction(w, sum(row)) for w in row] for row in law.weights.tolist()]
    assert rows == [[Fraction(long), Fraction(rest)], [Fraction(1, 7), Fraction(6, 7)]]


def test_a_bad_cell_of_a_big_table_is_named_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    good = "".join(f"s{i},{sex},{hired},{i % 7}\n" for i in range(2000) for sex in "fm" for hired in ("yes", "no"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reading, "SMALL", 10_000)
    words = ["certify", "t.csv", "--decision", "hired", "--group", "sex", "--context", "shop", "--count", "n", "--utility", "yes"]
    for line, said in (
        ("s1,f,yes,many\n", "t.csv: column 'n', line 8002: 'many' is not a number"),
        ("s1,f,yes,-3\n", "t.csv: column 'n', line 8002: '-3' is negative; numbers of at least 0 are accepted"),
        ("s1,,yes,3\n", "t.csv: column 'sex', line 8002: the label is missing (1 in all)"),
        ("s1,f,yes\n", "t.csv: line 8002 has 3 cells where the header has 4"),
        ('s1,f,"yes,3\n', "t.csv: line 8003: a quoted cell is not closed before the end of the file"),
        ("\n\ns1,f,yes,1/0\n", "t.csv: column 'n', line 8004: "),
    ):
        Path("t.csv").write_text("shop,sex,hired,n\n" + good + line + "s2,f,no,3\n")
        assert main(words) == 2
        assert said in capsys.readouterr().err
    assert main([word if word != "shop" else "shp" for word in words]) == 2
    assert "t.csv: there is no column 'shp'; known: 'shop', 'sex', 'hired', 'n'; did you mean 'shop'?" in capsys.readouterr().err


@pytest.mark.parametrize("role", ["count", "probability"])
def test_an_audit_file_reads_its_table_as_the_command_line_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, role: str) -> None:
    """By the same engine where it is big, to the same certificate, and in the same words where something is wrong with it."""
    path, asked = tmp_path / "table.csv", tmp_path / "AUDIT.toml"
    cells = ["5", "7", "1", "2"] if role == "count" else ["0.3", "0.7", "0.123456789012345678901", "0.876543210987654321099"]
    rows = [f"{'yes' if i % 2 else 'no'},{'fm'[i // 2 % 2]},{i // 4},other,{cells[i % 4]}" for i in range(40)]
    asked.write_text(
        f"[law]\ntable = 'table.csv'\ndecision = 'hired'\ngroup = 'sex'\ncontext = 'shop'\n{role} = 'n'\n[utility]\nvalues = {{yes = 1}}\n"
    )
    by_engine: list[str] = []

    def read(*given: Any) -> Any:
        by_engine.append(given[0])
        return read_ordered(*given)

    monkeypatch.setattr("fairaudit.tables.engines.ordered.read_ordered", read)
    for header, last in (("hired,sex,shop,note,n", ""), ("hired,sex,shop,note,m", ""), ("hired,sex,shop,note,n", "yes,f,9,,x\n")):
        path.write_text("\n".join([header, *rows]) + "\n" + last)
        said = []
        for small in (10**18, -1):
            monkeypatch.setattr(reading, "SMALL", small)
            try:
                found = read_audit(str(asked))
                assert isinstance(found.subject, fa.Law)
                said.append(fa.certify(found.subject, found.utility).certificate.text)
            except fa.InputError as error:
                said.append(str(error))
        assert said[0] == said[1]
    assert by_engine == [str(path)] * 3
