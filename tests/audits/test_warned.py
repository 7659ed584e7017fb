"""What is said before any figure: labels that look undecided, counts that nobody named, weights that are no counts; and no false alarms.

The tables are those of the field: made up in the shape of real files.
"""

from __future__ import annotations

import json
import shlex
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.audits.column_names import SURVEY_WEIGHT, named
from fairaudit.cli import main

OPENQ = "grp,dec,n\nA,Bewilligt,300\nA,Abgelehnt,100\nA,offen,100\nB,Bewilligt,250\nB,Abgelehnt,50\nB,offen,200\n"
PEND = OPENQ.replace("Bewilligt", "granted").replace("Abgelehnt", "refused").replace("offen", "pending")
AGG = "sex,admitted,Anzahl\nf,yes,89\nf,no,19\nm,yes,512\nm,no,313\n"
WEIGHED = "employed,sex,PWGTP\n" + "".join(f"{'yes' if i % 3 else 'no'},{'fm'[i % 2]},{2000 + 97 * i}\n" for i in range(60))

OPENQ_WORDS = ("--decision", "dec", "--group", "grp", "--count", "n", "--utility")
AGG_WORDS = ("--decision", "admitted", "--group", "sex", "--utility", "yes")
WEIGHED_WORDS = ("--decision", "employed", "--group", "sex", "--utility", "yes", "--count", "PWGTP")


def held(folder: Path, text: str, name: str = "table.csv") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


def screen(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["certify", *words]) == 0
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("text", "good", "refused", "left"), [(OPENQ, "Bewilligt", "Abgelehnt", "offen"), (PEND, "granted", "refused", "pending")]
)
def test_a_label_that_looks_undecided_is_said_first_with_whom_it_hits(
    text: str, good: str, refused: str, left: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = held(tmp_path, text)
    plain = screen(capsys, path, *OPENQ_WORDS, good)
    assert f"Counted as not {good}: {left} 300, {refused} 150." in plain
    said = f"'{left}' looks undecided and counts as not '{good}': 200 of 500 decisions on 'B', 100 of 500 on 'A'."
    assert plain.index(said) < plain.index("60.0 % (300 of 500)")
    assert f"--undecided {left} bounds the ratio" in plain and f"{left}=0 in --utility" in plain
    settled = screen(capsys, path, *OPENQ_WORDS, good, "--undecided", left)
    assert "looks undecided" not in settled and f"Counted as not {good}: {refused} 150." in settled
    declared = screen(capsys, path, *OPENQ_WORDS, f"{good},{left}=0")
    assert "looks undecided" not in declared and f"Counted as not {good}: {left} 300, {refused} 150." in declared
    assert "looks undecided" not in screen(capsys, path, *OPENQ_WORDS, left)  # named as what counts


def test_warnings_change_no_byte_of_a_certificate(tmp_path: Path) -> None:
    path = held(tmp_path, OPENQ)
    for utility, name in (("Bewilligt", "plain.json"), ("Bewilligt,offen=0", "declared.json")):
        assert main(["certify", path, *OPENQ_WORDS, utility, "-o", str(tmp_path / name)]) == 0
    assert (tmp_path / "plain.json").read_bytes() == (tmp_path / "declared.json").read_bytes()
    assert main(["verify", str(tmp_path / "plain.json")]) == 0


def test_page_and_markdown_say_what_counts_as_what(tmp_path: Path) -> None:
    path = held(tmp_path, OPENQ)
    for name in ("page.html", "page.md"):
        assert main(["certify", path, *OPENQ_WORDS, "Bewilligt", "--report", str(tmp_path / name)]) == 0
        assert "Counted as not Bewilligt: offen 300, Abgelehnt 150." in (tmp_path / name).read_text("utf-8")


def test_programs_are_told_in_json_and_python(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = held(tmp_path, OPENQ)
    assert main(["certify", path, *OPENQ_WORDS, "Bewilligt", "--format", "json"]) == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    assert [note for note in notes if note.startswith("'offen' looks undecided")]
    assert main(["certify", path, *OPENQ_WORDS, "Bewilligt", "--verbose"]) == 0
    assert "note: 'offen' looks undecided" in capsys.readouterr().err
    result = fa.audit(path, decision="dec", group="grp", count="n", utility="Bewilligt")
    assert [text for text in result.warnings if text.startswith("'offen' looks undecided")] and "offen" in result._repr_html_()
    assert fa.audit(path, decision="dec", group="grp", count="n", utility="Bewilligt", undecided="offen").warnings == ()


def test_a_lexicon_of_ones_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, own = held(tmp_path, OPENQ.replace("offen", "parked")), held(tmp_path, "Parked\n", "own.txt")
    assert "undecided" not in screen(capsys, path, *OPENQ_WORDS, "Bewilligt")
    assert "'parked' looks undecided" in screen(capsys, path, *OPENQ_WORDS, "Bewilligt", "--lexicon", own)
    assert main(["inspect", path, "--lexicon", own]) == 0
    assert "--undecided parked" in capsys.readouterr().out
    assert main(["certify", path, *OPENQ_WORDS, "Bewilligt", "--lexicon", str(tmp_path / "none.txt")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_log_that_is_read_in_parts_is_warned_about(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [("yes", "f"), ("no", "f"), ("pending", "f"), ("yes", "m"), ("no", "m")] * 10
    path = str(tmp_path / "log.parquet")
    table = {"dec": [d for d, _ in rows], "grp": [g for _, g in rows], "dept": ["xy"[i % 2] for i in range(len(rows))]}
    pytest.importorskip("pyarrow.parquet").write_table(pytest.importorskip("pyarrow").table(table), path)
    words = ("--decision", "dec", "--group", "grp", "--context", "dept", "--utility", "yes", "--in-parts")
    assert "'pending' looks undecided and counts as not 'yes': 10 of 30 decisions on 'f'." in screen(capsys, path, *words)


def test_of_many_labels_and_groups_a_few_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    labels = ["yes", "no", "pending", "withdrawn", "open", "n/a"]
    path = held(tmp_path, "dec,grp,n\n" + "".join(f"{u},g{a},{10 + a}\n" for u in labels for a in range(9)))
    said = screen(capsys, path, *OPENQ_WORDS, "yes")
    assert "Counted as not yes: no 126, pending 126, withdrawn 126, and 2 more labels (252)." in said
    assert "and 1 more label look undecided and count as not 'yes'" in said and "some on 6 more groups" in said
    assert "and 2 more labels" in said


def test_a_utility_of_several_values_and_a_burden(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = held(tmp_path, OPENQ)
    said = screen(capsys, path, *OPENQ_WORDS, "Bewilligt=1,Abgelehnt=1/2")
    assert "Counted as worth 0: offen 300." in said and "'offen' looks undecided and counts as worth 0" in said
    assert "Counted as not Abgelehnt: Bewilligt 550, offen 300." in screen(capsys, path, *OPENQ_WORDS, "Abgelehnt", "--burden")


def test_answers_of_a_log_of_an_evaluation_are_no_alarm() -> None:
    """There `unknown` may be an answer, and what decides nothing is known."""
    law = fa.Law.from_log({"d": ["yes", "unknown"] * 2, "g": ["f", "f", "m", "m"]}, decision="d", group="g")
    assert fa.certify(law, fa.Utility({"yes": 1})).warnings == ()


@pytest.mark.parametrize("form", ["csv", "mapping", "pandas", "polars", "arrow"])
def test_counts_that_nobody_named(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = held(tmp_path, AGG)
    said = "Column 'Anzahl' looks like counts, and each row counts as one decision: --count Anzahl."
    rows = [line.split(",") for line in AGG.split()]
    table: dict[str, Any] = {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}
    if form == "csv":
        assert said in screen(capsys, path, *AGG_WORDS)
        assert said not in screen(capsys, path, *AGG_WORDS, "--count", "Anzahl")
        return
    source: Any = table
    if form != "mapping":
        library = pytest.importorskip({"pandas": "pandas", "polars": "polars", "arrow": "pyarrow"}[form])
        table["Anzahl"] = [int(number) for number in table["Anzahl"]]
        source = library.table(table) if form == "arrow" else library.DataFrame(table)
    warned = fa.audit(source, decision="admitted", group="sex", utility="yes").warnings
    assert warned == (said,)


INNOCENT = {
    "a log with ages": ("sex,admitted,age\n", [f"{'fm'[i % 2]},{'yes' if i % 3 else 'no'},{20 + i}\n" for i in range(40)]),
    "salaries": ("sex,admitted,salary\n", ["f,yes,52000\n", "f,no,48000\n", "m,yes,61000\n", "m,no,39000\n"]),
    "years": ("sex,admitted,year\n", ["f,yes,1999\n", "f,no,2001\n", "m,yes,2005\n", "m,no,2010\n"]),
    "identifiers": ("id,sex,admitted\n", ["101,f,yes\n", "102,f,no\n", "103,m,yes\n", "104,m,no\n"]),
    "numbers of rows": ("n,sex,admitted\n", ["1,f,yes\n", "2,f,no\n", "3,m,yes\n", "4,m,no\n"]),
    "people": ("sex,admitted,n\n", [f"{'fm'[i % 2]},{'yes' if i % 3 else 'no'},{i % 5}\n" for i in range(40)]),
    "flags": ("sex,admitted,n\n", ["f,yes,1\n", "f,no,0\n", "m,yes,1\n", "m,no,1\n"]),
    "fractions": ("sex,admitted,n\n", ["f,yes,1.5\n", "f,no,2.5\n", "m,yes,7\n", "m,no,3\n"]),
}


@pytest.mark.parametrize("name", INNOCENT)
def test_no_false_alarm_about_counts(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head, rows = INNOCENT[name]
    said = screen(capsys, held(tmp_path, head + "".join(rows)), *AGG_WORDS)
    assert "looks like" not in said and "survey weight" not in said


def test_a_table_of_counts_by_department_of_which_none_was_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [f"{x},{a},{u},{7 + i}" for i, (x, a, u) in enumerate((x, a, u) for x in "ABC" for a in "fm" for u in ("yes", "no"))]
    path = held(tmp_path, "dept,sex,admitted,Freq\n" + "\n".join(rows) + "\n")
    assert "Column 'Freq' looks like counts" in screen(capsys, path, *AGG_WORDS)
    doubled = held(tmp_path, "dept,sex,admitted,Freq\n" + "\n".join([*rows, *rows]) + "\n")
    assert "looks like counts" not in screen(capsys, doubled, *AGG_WORDS)


def test_counts_that_nobody_named_are_seen_with_thousands_separators(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = held(tmp_path, "sex;admitted;Anzahl\nf;yes;1.204\nf;no;310\nm;yes;2.310\nm;no;700\n")
    assert "Column 'Anzahl' looks like counts" in screen(capsys, path, *AGG_WORDS)


def test_a_database_is_not_read_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with closing(sqlite3.connect(tmp_path / "log.db")) as database, database:
        database.execute("create table log (sex, admitted, Anzahl)")
        database.executemany("insert into log values (?, ?, ?)", [line.split(",") for line in AGG.split()[1:]])
    assert "looks like counts" not in screen(capsys, f"sqlite:{tmp_path / 'log.db'}", "--table", "log", *AGG_WORDS)


def test_a_survey_weight_is_no_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    total = sum(2000 + 97 * i for i in range(60))
    path = held(tmp_path, WEIGHED)
    said = f"60 rows stand for {total:,} decisions: if 'PWGTP' is a survey weight, the intervals are not valid."
    text = screen(capsys, path, *WEIGHED_WORDS)
    assert text.index(said) < text.index("employed=yes")
    renamed = held(tmp_path, WEIGHED.replace("PWGTP", "applicants"))
    assert "survey weight" not in screen(capsys, renamed, *WEIGHED_WORDS[:-1], "applicants")
    one_row_a_cell = held(tmp_path, AGG.replace("Anzahl", "weight"))
    assert "survey weight" not in screen(capsys, one_row_a_cell, *AGG_WORDS, "--count", "weight")
    ones = held(tmp_path, "employed,sex,weight\n" + "yes,f,1\nno,f,1\nyes,m,1\nno,m,1\n" * 9)
    assert "survey weight" not in screen(capsys, ones, *WEIGHED_WORDS[:-1], "weight")


def test_a_weight_of_a_large_file_is_counted_in_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where equal rows are counted together, each is one row still."""
    path = held(tmp_path, "employed,sex,PERWT\n" + "yes,f,120\nno,f,80\nyes,m,95\nno,m,105\n" * 50)
    words = (*WEIGHED_WORDS[:-1], "PERWT")
    for engine in ("python", "duckdb"):
        assert "200 rows stand for 20,000 decisions" in screen(capsys, path, *words, "--engine", engine)


WEIGHTS = (
    "PWGTP pwgtp12 WGTP PERWT HHWT ASECWT WTFINL fnlwgt final_weight weight Weights w_wgt WTMEC2YR WTSSALL _LLCPWT pweight pspwght "
    "anweight survey.weight Gewicht Personengewicht Hochrechnungsfaktor phrf poids ponderacion fac_exp peso"
)
NO_WEIGHTS = "n Freq count age salary id year fweight freq_weight width weighted_by wait total twitter growth hwt_no"


@pytest.mark.parametrize("name", WEIGHTS.split())
def test_names_of_survey_weights(name: str) -> None:
    assert named(name, SURVEY_WEIGHT)


@pytest.mark.parametrize("name", NO_WEIGHTS.split())
def test_names_of_other_columns(name: str) -> None:
    assert not named(name, SURVEY_WEIGHT)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (OPENQ, "--decision dec --group grp --count n --utility Bewilligt --undecided offen"),
        (PEND, "--decision dec --group grp --count n --utility granted --undecided pending"),
        (AGG, "--decision admitted --group sex --count Anzahl --utility yes"),
        (WEIGHED, "--decision employed --group sex --utility yes"),
    ],
)
def test_what_inspect_proposes(table: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = held(tmp_path, table)
    assert main(["inspect", path]) == 0
    *lines, command = capsys.readouterr().out.splitlines()
    assert shlex.split(command)[3:] == expected.split()
    text = "\n".join(lines)
    assert ("refused, or not decided yet? --undecided bounds" in text) == ("--undecided" in expected)
    assert ("; offen=0 in --utility" in text) == ("offen" in expected)
    assert ("looks like counts: --count" in text) == ("--count" in expected)
    assert ("column 'PWGTP' looks like a survey weight, which is no count" in text) == ("PWGTP" in table)
    assert main(shlex.split(command)[1:]) == 0
    assert "looks undecided" not in capsys.readouterr().out


def test_inspect_never_proposes_what_is_not_applicable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [f"t{i},{race},{side}\n" for i in range(30) for race, side in (("white", "n/a"), ("black", "n/a"), ("white", "state"))]
    path = held(tmp_path, "trial,race,struck\n" + "".join(rows) + "t1,black,state\nt1,black,defense\n")
    assert main(["inspect", path]) == 0
    words = shlex.split(capsys.readouterr().out.splitlines()[-1])
    assert words[words.index("--utility") + 1] == "state"


def test_options_that_are_said_can_be_copied_into_a_shell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    label, own = 'in, "Prüfung"=x', held(tmp_path, 'in, "Prüfung"=x\n', "own.txt")
    path = held(tmp_path, 'dec,grp\nyes,f\n"in, ""Prüfung""=x",f\nyes,m\nno,m\n')
    words = ("--decision", "dec", "--group", "grp", "--utility", "yes", "--confidence", "none", "--lexicon", own)
    assert main(["certify", path, *words, "--format", "json"]) == 0
    (said,) = [note for note in json.loads(capsys.readouterr().out)["notes"] if label in note and "looks undecided" in note]
    copied = shlex.split(said[said.index("--undecided") : said.index(" bounds")])
    assert "looks undecided" not in screen(capsys, path, *words, *copied)
    (zero,) = shlex.split(said[said.index("; ") + 2 : said.index(" in --utility")])
    assert "looks undecided" not in screen(capsys, path, *words[:5], f"yes,{zero}", *words[6:])
