"""One label in several spellings: said before anything else, in the certificate too, and merged where that is asked for."""

from __future__ import annotations

import copy
import json
import sqlite3
import unicodedata
from pathlib import Path
from typing import Any

import pytest
from certificates import outcome
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import schema
from fairaudit.cli import main
from fairaudit.tables.labels import merge_labels, read_label_map, spellings
from fairaudit.tables.tally import Tally

SCHEMA = Draft202012Validator(schema())
LOG = "answer,race,age\n" + "\n".join(
    ["yes,Black,1"] * 6
    + ["no,BLACK,1.0"] * 3
    + ["Yes, Black,01"] * 2
    + ["yes,Jose\u0301,2"] * 2
    + ["no,Jos\u00e9,2"] * 3
    + ["no,White,2"] * 4
)
WORDS = ("--decision", "answer", "--group", "race", "--utility", "yes", "--confidence", "none")


def run(*words: Any) -> int:
    return main([str(word) for word in words])


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text(LOG + "\n", encoding="utf-8")
    return path


def test_spellings_come_before_the_headline(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("certify", log, *WORDS, "--context", "age", "-o", tmp_path / "c.json") == 0
    out, _ = capsys.readouterr()
    assert out.index("' Black', 'BLACK' and 'Black' count as") < out.index("--fold-labels") < out.index("answer=yes within")
    assert run("certify", log, *WORDS, "--context", "age", "--verbose") == 0
    out, _ = capsys.readouterr()
    first = out.index("SPELLINGS")
    assert (
        first == 0
        and "' Black', 'BLACK' and 'Black' count as different labels" in out
        and out.index("--fold-labels") < out.index("NO TARGET")
    )
    document = json.loads((tmp_path / "c.json").read_text())
    assert document["subject"]["spellings"] == [
        {"column": "answer", "labels": ["Yes", "yes"]},
        {"column": "race", "labels": [" Black", "BLACK", "Black"]},
        {"column": "race", "labels": ["Jose\u0301", "Jos\u00e9"]},
        {"column": "age", "labels": ["01", "1", "1.0"]},
    ]
    SCHEMA.validate(document)
    assert outcome(document) == "true"
    for name in ("page.html", "page.md"):
        assert run("report", tmp_path / "c.json", "-o", tmp_path / name) == 0
        text = (tmp_path / name).read_text()
        assert text.index("differ in spelling alone") < text.index("is favoured over")
    assert run("inspect", log) == 0
    assert "'BLACK' and 'Black' count as different labels" in capsys.readouterr().out


def test_the_list_of_spellings_is_that_of_the_table(log: Path) -> None:
    law = fa.Law.from_log(fa.read_log(log, ["answer", "race"]), decision="answer", group="race")
    document = json.loads(fa.certify(law, {"yes": 1}).certificate.text)
    assert outcome(document) == "true"
    listed = document["subject"]["spellings"]
    for other in (listed[::-1], listed[1:], [*listed, listed[0]], [{**listed[0], "labels": listed[0]["labels"][::-1]}, *listed[1:]]):
        mutant = copy.deepcopy(document)
        mutant["subject"]["spellings"] = other
        assert outcome(mutant) == "false"
    for other in ([], {}, [{"column": "race"}], [{**listed[0], "more": 1}], "none", None):
        mutant = copy.deepcopy(document)
        mutant["subject"]["spellings"] = other
        assert outcome(mutant).startswith("malformed")
    del document["subject"]["spellings"]
    assert outcome(document).startswith('incomplete: subject lacks the key "spellings"')
    law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    document = json.loads(fa.certify(law, {"yes": 1}).certificate.text)
    document["subject"]["spellings"] = [{"column": "decision", "labels": ["yes", "no"]}]
    assert outcome(document) == "false"


CHARACTERS = "aAbBßẞſsKkKÅåÅe\u0301\u0345\u00e9İiı \t\u00a0\u2003019.+-eE\U0001e900\U0001e922\u1c90\u10d0"


@settings(max_examples=300, deadline=None)
@given(st.lists(st.text(CHARACTERS, min_size=1, max_size=5).filter(str.strip), min_size=3, max_size=30, unique=True))
def test_the_writer_and_the_checker_find_the_same(labels: list[str]) -> None:
    law = fa.Law.from_array([[[1, 2]] * len(labels)], kind="counts", groups=labels)
    certificate = fa.certify(law, {"0": 1}, confidence=None).certificate
    assert checker.check(certificate.text.encode()).ok
    classes = certificate.document["subject"].get("spellings", [])
    for entry in classes:
        forms = {" ".join(unicodedata.normalize("NFKC", label).casefold().split()) for label in entry["labels"]}
        folded = {unicodedata.normalize("NFC", form).casefold() for form in forms}
        assert len(folded) == 1 or len({float(form) for form in forms}) == 1
        assert all(unicodedata.ucd_3_2_0.category(c) != "Cn" for label in entry["labels"] for c in label)


def test_folding_and_a_map_in_every_reader(log: Path, tmp_path: Path) -> None:
    import duckdb
    import pandas as pd
    import polars as pl

    frame = pd.read_csv(log, dtype=str, keep_default_na=False)
    frame.to_parquet(tmp_path / "log.parquet")
    frame.to_json(tmp_path / "log.jsonl", orient="records", lines=True)
    with sqlite3.connect(tmp_path / "log.db") as database:
        frame.to_sql("log", database, index=False)
    database.close()
    (tmp_path / "map.toml").write_text('[race]\n"White" = "black"\n"BLACK" = "x"\n', encoding="utf-8")
    option = ("--fold-labels", "--map", tmp_path / "map.toml")
    texts = set()
    for source in (
        [log],
        [log, "--engine", "duckdb"],
        [tmp_path / "log.parquet"],
        [tmp_path / "log.jsonl"],
        [f"sqlite:{tmp_path}/log.db", "--table", "log"],
    ):
        assert run("certify", *source, *WORDS, *option, "-o", tmp_path / "c.json") == 0
        texts.add((tmp_path / "c.json").read_text())
        assert run("verify", tmp_path / "c.json") == 0
    label_map = read_label_map(tmp_path / "map.toml")
    lists = {name: frame[name].tolist() for name in frame}
    relation = duckdb.from_df(frame)
    for table in (
        lists,
        frame,
        pl.from_pandas(frame),
        *(fa.read_log(f, ["answer", "race"]) for f in (frame, relation, pl.from_pandas(frame).lazy())),
    ):
        law = fa.Law.from_log(merge_labels(table, ["answer", "race"], fold=True, label_map=label_map), decision="answer", group="race")
        texts.add(fa.certify(law, {"yes": 1}, confidence=None).certificate.text)
    assert len(texts) == 1
    subject = json.loads(texts.pop())["subject"]
    assert subject["preparation"] == [
        {"step": "mapped", "column": "race", "label": "black", "from": ["White"]},
        {"step": "mapped", "column": "race", "label": "x", "from": ["BLACK"]},
        {"step": "folded", "column": "answer", "label": "yes", "from": ["Yes"]},
        {"step": "folded", "column": "race", "label": "Jos\u00e9", "from": ["Jose\u0301"]},
        {"step": "folded", "column": "race", "label": "black", "from": [" Black", "Black"]},
    ]
    assert subject["table"]["header"]["groups"] == [["Jos\u00e9"], ["black"], ["x"]]
    assert [row["weights"] for row in subject["table"]["rows"]] == [["3", "2"], ["4", "8"], ["3", "0"]]


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.tuples(st.text("aAäÄ ", min_size=1, max_size=2).filter(str.strip), st.sampled_from(["f", "m"]), st.integers(1, 5)),
        min_size=1,
        max_size=20,
    )
)
def test_the_most_frequent_spelling_stays(rows: list[tuple[str, str, int]]) -> None:
    rows = [*rows, ("b", "f", 1), ("b", "m", 1)]
    written = [(u, a) for u, a, n in rows for _ in range(n)]
    tally = merge_labels(
        Tally.of("log", ("u", "a"), [(u, a, sum(1 for row in written if row == (u, a))) for u, a in dict.fromkeys(written)]),
        ["u", "a"],
        fold=True,
    )
    listed = merge_labels({"u": [u for u, _ in written], "a": [a for _, a in written]}, ["u", "a"], fold=True)
    laws = [fa.Law.from_log(table, decision="u", group="a") for table in (tally, listed)]
    assert laws[0].decisions == laws[1].decisions and laws[0].weights.tolist() == laws[1].weights.tolist()

    def form(text: str) -> str:
        return " ".join(text.upper().split())

    for label in laws[0].decisions:
        alike = [u for u, _ in written if form(u) == form(label)]
        assert alike.count(label) == max(map(alike.count, alike))
        assert label == min(u for u in alike if alike.count(u) == alike.count(label))
        assert sum(u == label for u in laws[0].decisions) == 1
    assert sum(laws[0].totals) == len(written)


def test_maps_that_do_not_fit_are_refused(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "map.toml"
    for text, said in (
        ('[race]\n"Blak" = "Black"', "the label 'Blak', which does not occur; known: "),
        ('[rase]\n"Black" = "B"', "a column 'rase', which is no decision, group, context or true label; known: "),
        ('[race]\n"Black" = ""', "which is a missing one"),
        ('[race]\n"Black" = 1', "the new label is a text"),
        ('race = "Black"', "is no table"),
        ('[race]\n"Black" = "x"\n"White" = "X"', "which folding would merge"),
        ("[race", "this is not a TOML file"),
    ):
        file.write_text(text, encoding="utf-8")
        assert run("certify", log, *WORDS, "--map", file, "--fold-labels", "-o", tmp_path / "c.json") == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and said in err, err
    assert run("certify", log, *WORDS, "--map", tmp_path / "none.toml") == 2
    assert "none.toml: there is no such file" in capsys.readouterr().err
    file.write_text('[race]\n"BLACK" = "Black"\n"Black" = "BLACK"\n')  # not followed: they change places
    assert run("certify", log, *WORDS, "--map", file, "-o", tmp_path / "c.json") == 0
    document = json.loads((tmp_path / "c.json").read_text())
    assert [entry["from"] for entry in document["subject"]["preparation"]] == [["Black"], ["BLACK"]]
    assert outcome(document) == "true"
    assert not (tmp_path / "none.json").exists()


def test_probabilities_of_merged_labels_are_not_added(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "p.csv"
    path.write_text("u,a,p\nyes,f,0.5\nno,f,0.5\nyes,F,0.25\nno,F,0.75\nyes,m,1\n")
    words = ("--decision", "u", "--group", "a", "--probability", "p", "--utility", "yes", "--fold-labels")
    assert run("certify", path, *words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "line 4" in err and "give counts" in err
    path.write_text("u,a,p\nyes,f,0.5\nno,f,0.5\nyes,m,0.25\nNo,m,0.75\n")
    assert run("certify", path, *words, "-o", tmp_path / "c.json") == 0
    document = json.loads((tmp_path / "c.json").read_text())
    assert document["subject"]["preparation"] == [{"step": "folded", "column": "u", "label": "No", "from": ["no"]}]
    assert outcome(document) == "true"


def test_counts_worst_cases_and_audit_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "t.csv").write_text("u,a,n\nyes,f,3\nno,f,1\nyes,F,1\nno,m,2\nyes,m,2\n")
    (tmp_path / "map.toml").write_text('[a]\n"F" = "f"\n')
    words = ("--decision", "u", "--group", "a", "--count", "n")
    assert run("certify", tmp_path / "t.csv", *words, "--utility", "yes", "--fold-labels", "-o", tmp_path / "c.json") == 0
    folded = json.loads((tmp_path / "c.json").read_text())
    assert [row["weights"] for row in folded["subject"]["table"]["rows"]] == [["1", "4"], ["2", "2"]] or folded["subject"]["table"][
        "header"
    ]["decisions"] == ["yes", "no"]
    assert run("worst-case", tmp_path / "t.csv", *words, "--fold-labels", "--tau", "0.2", "-o", tmp_path / "w.json") == 0
    assert json.loads((tmp_path / "w.json").read_text())["subject"]["preparation"] == folded["subject"]["preparation"]
    assert run("verify", tmp_path / "w.json") == 0
    for keys in ("fold_labels = true", 'map = "map.toml"'):
        (tmp_path / "audit.toml").write_text(
            f'[law]\ntable = "t.csv"\ndecision = "u"\ngroup = "a"\ncount = "n"\n{keys}\n[utility]\nvalues = {{ yes = 1 }}\n'
        )
        assert run("certify", tmp_path / "audit.toml", "-o", tmp_path / "a.json") == 0
        document = json.loads((tmp_path / "a.json").read_text())
        assert document["metrics"] == folded["metrics"] and document["subject"]["preparation"][0]["from"] in (["F"], ["f"])
    (tmp_path / "audit.toml").write_text(
        '[law]\ntable = "t.csv"\ndecision = "u"\ngroup = "a"\nfold_labels = 1\n[utility]\nvalues = {yes = 1}\n'
    )
    capsys.readouterr()
    assert run("certify", tmp_path / "audit.toml") == 2 and "true or false" in capsys.readouterr().err


def test_utilities_name_labels_after_merging(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--decision", "answer", "--group", "race", "--confidence", "none", "--fold-labels")
    printed = []
    for spelling in ("yes", "Yes", " YES ", "no=0,YES=1"):
        assert run("certify", log, *words, "--utility", spelling) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1] == printed[2] == printed[3]
    assert "answer=yes: race=Black 72.7 % (8 of 11)" in printed[0]
    assert run("certify", log, *words, "--utility", "Yes,YES=1") == 2
    assert "the utility names the decision 'yes' twice, as 'Yes' and 'YES'" in capsys.readouterr().err
    assert run("certify", log, *words, "--utility", "Yess") == 2
    assert "'Yess', which does not occur; known: 'no', 'yes'" in capsys.readouterr().err
    (tmp_path / "u.csv").write_text("answer,race,worth\nyes,f,2\nYES,m,2\nno,f,1\nno,F,1\n")
    assert run("certify", tmp_path / "u.csv", "--decision", "answer", "--group", "race", "--utility-column", "worth", "--fold-labels") == 0
    assert run("certify", log, *WORDS, "--fold-labels", "--context", "age", "--in-parts") == 2
    assert "--in-parts does not go with --fold-labels" in capsys.readouterr().err


def test_labels_that_only_later_versions_of_unicode_know_are_passed_over() -> None:
    adlam = ["\U0001e900", "\U0001e922"]
    assert adlam[0].casefold() == adlam[1] and spellings([("a", adlam)]) == ()
    law = fa.Law.from_log(merge_labels({"u": ["y", "n", "y"], "a": [*adlam, "b"]}, ["u", "a"], fold=True), decision="u", group="a")
    assert [entry["step"] for entry in law.preparation] == ["folded"]
    assert checker.check(fa.certify(law, {"y": 1}).certificate.text.encode()).ok


@given(st.lists(st.text("aAbB1.0 \x1c\t-é", max_size=4), unique=True))
def test_labels_that_are_plainly_different_are_no_spellings_of_each_other(labels: list[str]) -> None:
    """A label beyond ASCII makes each of them be looked at by itself."""
    assert spellings([("x", labels)]) == spellings([("x", [*labels, "ü" * 9])])
