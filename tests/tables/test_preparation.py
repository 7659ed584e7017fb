"""What was done to a log before it was counted stands in the certificate, and what was left out under every claim."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from certificate_changes import named_anew
from certificates import outcome
from envelopes import result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit.certificates.certificate import Certificate, schema
from fairaudit.certificates.compare import compare_documents as compare
from fairaudit.cli import main
from fairaudit.model.utility_class import UtilityClass
from fairaudit.reports.markdown import markdown
from fairaudit.tables.labels import merge_labels

SCHEMA = Draft202012Validator(schema())


def run(*words: Any) -> int:
    return main([str(word) for word in words])


def accepted(certificate: Certificate) -> Any:
    document = json.loads(certificate.text)
    SCHEMA.validate(document)
    assert outcome(document) == "true"
    return document


def anew(document: Any) -> Any:
    """With the digests that go with what it now says of the log."""
    return json.loads(named_anew(json.dumps(document).encode()))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """1,300 decisions, 1,100 of them without a group: among those with one there is parity, among all of them there is a ratio of 9."""
    rows = ["yes,f"] * 50 + ["no,f"] * 50 + ["yes,m"] * 50 + ["no,m"] * 50 + ["yes,"] * 950 + ["no,"] * 150
    path = tmp_path / "log.csv"
    path.write_text("answer,sex\n" + "\n".join(rows) + "\n")
    return path


def test_decisions_that_are_left_out_leave_a_trace(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--decision", "answer", "--group", "sex", "--utility", "yes", "--missing", "drop", "--max-local-ratio", "5/4")
    assert run("certify", log, *words, "-o", tmp_path / "c.json", "--confidence", "none") == 0
    line = "As read: 1,100 of 1,300 decisions have a missing label and were left out ('sex': 1,100)"
    assert line in " ".join(capsys.readouterr().out.split())
    assert run("certify", log, *words, "--confidence", "none", "--verbose") == 0
    out, _ = capsys.readouterr()
    assert "Before it was counted\n  - 1,100 of 1,300 decisions have a missing label and were left out ('sex': 1,100)" in out
    document = json.loads((tmp_path / "c.json").read_text())
    said = {"step": "left out", "reason": "missing label", "decisions": "1100", "of": "1300", "columns": {"sex": "1100"}, "groups": []}
    assert document["subject"]["preparation"] == [said]
    sentence = "1100 of 1300 decisions have a missing label and were left out; they are taken to be no different from the others"
    assert document["claims"] and all(sentence in claim["assumptions"] for claim in document["claims"])
    assert run("verify", tmp_path / "c.json") == 0
    assert "1100 of 1300 decisions" in capsys.readouterr().out
    assert run("certify", log, *words, "--format", "json") in (0, 3)
    assert result_of(capsys.readouterr().out)["subject"]["preparation"] == [said]
    for name in ("page.html", "page.md"):
        assert run("report", tmp_path / "c.json", "-o", tmp_path / name) == 0
        assert "1100 of 1300 decisions" in (tmp_path / name).read_text()


@pytest.mark.parametrize("source", ["csv", "parquet", "pandas", "polars", "mapping"])
def test_every_reader_leaves_the_same_trace(log: Path, source: str, tmp_path: Path) -> None:
    import pandas as pd
    import polars as pl

    frame = pd.read_csv(log)
    table: Any = {
        "csv": lambda: fa.read_log(log, ["answer", "sex"]),
        "parquet": lambda: (frame.to_parquet(tmp_path / "log.parquet"), fa.read_log(tmp_path / "log.parquet", ["answer", "sex"]))[1],
        "pandas": lambda: frame,
        "polars": lambda: pl.from_pandas(frame).lazy(),
        "mapping": lambda: {name: [None if v != v else v for v in frame[name]] for name in frame},
    }[source]()
    law = fa.Law.from_log(table, decision="answer", group="sex", missing="drop")
    expected = {"step": "left out", "reason": "missing label", "decisions": "1100", "of": "1300", "columns": {"sex": "1100"}, "groups": []}
    assert list(law.preparation) == [expected]
    accepted(fa.certify(law, {"yes": 1}).certificate)
    law = fa.Law.from_log(table, decision="answer", group="sex", missing="group")
    assert list(law.preparation) == [{"step": "level", "column": "sex", "label": "(missing)", "decisions": "1100"}]
    accepted(fa.certify(law, {"yes": 1}).certificate)


@settings(max_examples=60, deadline=None)
@given(
    rows=st.lists(
        st.tuples(
            st.sampled_from(["yes", "no", ""]),
            st.sampled_from(["f", "m", ""]),
            st.sampled_from(["p", "q", ""]),
            st.fractions(min_value=0, max_value=9, max_denominator=7),
        ),
        min_size=8,
        max_size=40,
    )
)
def test_amounts_are_decisions_against_a_plain_count(rows: list[tuple[str, str, str, Fraction]]) -> None:
    rows += [("yes", "f", "p", Fraction(1)), ("no", "m", "p", Fraction(1, 2))]
    table = {name: [str(row[i]) for row in rows] for i, name in enumerate("uaxn")}
    names = {"decision": "u", "group": "a", "context": "x", "count": "n"}
    law = fa.Law.from_counts(table, **names, missing="drop")
    lost = sum((row[3] for row in rows if not all(row[:3])), Fraction(0))
    if lost:
        by_column = {name: sum((row[3] for row in rows if not row[i]), Fraction(0)) for i, name in enumerate("uax")}
        [entry] = law.preparation
        assert Fraction(entry["decisions"]) == lost and Fraction(entry["of"]) == sum(row[3] for row in rows)
        assert {name: Fraction(n) for name, n in entry["columns"].items()} == {name: n for name, n in by_column.items() if n}
    else:
        assert law.preparation == ()
    accepted(fa.certify(law, {"yes": 1}, confidence=None).certificate)
    law = fa.Law.from_counts(table, **names, missing="group")
    assert {entry["column"]: Fraction(entry["decisions"]) for entry in law.preparation} == {
        name: n for i, name in enumerate("uax") if (n := sum((row[3] for row in rows if not row[i]), Fraction(0)))
    }
    accepted(fa.certify(law, {"yes": 1} if "yes" in law.decisions else {law.decisions[0]: 1}, confidence=None).certificate)


def test_blank_rows_of_a_table_of_counts_are_no_decisions(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("u,a,n\nyes,f,3\nno,f,1\nyes,m,1\nno,m,1\n,,\n,,\n")
    law = fa.Law.from_counts(fa.read_csv(path), decision="u", group="a", count="n", missing="drop")
    assert law.preparation == () and law.notes == ()
    path.write_text("u,a,n\nyes,f,3\nno,f,1\nyes,m,1\nno,,\n")
    with pytest.raises(fa.InputError, match="line 5: the number is missing"):
        fa.Law.from_counts(fa.read_csv(path), decision="u", group="a", count="n", missing="drop")


def prepared_counts() -> fa.Result:
    rows = [("yes", "f", 3), ("no", "f", 1), ("yes", "m", 1), ("no", "m", "1/2"), ("no", "", "9/4"), ("", "", 1), ("", "f", 2)]
    table = {name: [row[i] for row in rows] for i, name in enumerate("uan")}
    return fa.certify(fa.Law.from_counts(table, decision="u", group="a", count="n", missing="drop"), {"yes": 1}, confidence=None)


def prepared_levels() -> fa.Result:
    rows = [("yes", "f", "p", 3), ("no", "f", "p", 1), ("yes", "m", "p", 1), ("no", "", "p", 2), ("no", "m", "", 4), ("", "f", "", 5)]
    table = {name: [row[i] for row in rows] for i, name in enumerate("uaxn")}
    law = fa.Law.from_counts(table, decision="u", group="a", context="x", count="n", missing="group")
    return fa.certify(law, {"yes": 1}, confidence=None)


def prepared_log() -> fa.Result:
    import pandas as pd

    ages = [1, 17, 18, 64.5, 65, 90] * 5
    sexes = ["f", "F ", "m", "woman", "m", "F "] * 5
    frame = pd.DataFrame({"u": ["yes", "no", "yes", "Yes", "no", "no"] * 5, "sex": sexes, "age": ages})
    tally = fa.read_log(frame, ["u", "sex", "age"], bins={"age": [18, "64.5"]})
    table = merge_labels(tally, ["u", "sex", "age"], fold=True, label_map={"sex": {"woman": "f"}})
    return fa.certify(fa.Law.from_log(table, decision="u", group="sex", context="age"), {"yes": 1})


def prepared_probabilities() -> fa.Result:
    table = {"u": ["yes", "no"] * 3, "a": ["f", "f", "m", "m", "", ""], "p": ["1/4", "3/4", "1/3", "2/3", "1/2", "1/2"]}
    return fa.certify(fa.Law.from_probabilities(table, decision="u", group="a", probability="p", missing="drop"), {"yes": 1})


def prepared_policy() -> fa.Result:
    table = {"u": ["yes", "no"] * 3, "a": ["f", "f", "m", "m", "", ""], "n": [3, 1, 4, 1, 5, 9]}
    policy = fa.Policy.from_counts(table, decision="u", group="a", count="n", missing="drop")
    return fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4")), {"yes": 1}, confidence="0.9")


def prepared_scores() -> fa.Result:
    table = {"points": [1, 2, 3, 4, "", 5], "a": ["f", "f", "m", "m", "m", ""]}
    return fa.audit(table, score="points", above="median", group="a", missing="drop")


KINDS = [prepared_counts, prepared_levels, prepared_log, prepared_probabilities, prepared_policy, prepared_scores]


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_done_is_accepted_and_nothing_else(kind: Callable[[], fa.Result]) -> None:
    document = accepted(kind().certificate)
    entries = document["subject"]["preparation"]
    assert entries

    def changed(place: int, **keys: Any) -> str:
        mutant = copy.deepcopy(document)
        entry = mutant["subject"]["preparation"][place]
        entry.update(keys)
        mutant["subject"]["preparation"][place] = {key: value for key, value in entry.items() if value is not None}
        return outcome(anew(mutant))

    for i, entry in enumerate(entries):
        assert changed(i, more="1").startswith("malformed") and changed(i, step="other").startswith("malformed")
        for key in entry:
            assert changed(i, **{key: None}) != "true" and changed(i, **{key: 7}).startswith("malformed")
        for key in {"decisions", "rows"} & entry.keys():
            for value in ("0", "-1", "1e3", "01", str(Fraction(entry[key]) + 1), str(Fraction(entry[key]) / 2)):
                exact = kind in (prepared_counts, prepared_levels) or entry["step"] == "left out"
                assert changed(i, **{key: value}) != "true" or not exact, (entry, value)
        if entry["step"] == "left out":
            assert changed(i, of=str(Fraction(entry["of"]) + 1)) != "true"
            assert changed(i, reason="other").startswith("malformed")
            assert (
                changed(i, columns={}) != "true"
                and changed(i, columns={"other": entry["decisions" if "decisions" in entry else "rows"]}) != "true"
            )
            assert changed(i, columns=dict.fromkeys(entry["columns"], "1000000")) == "false"
            for claim in range(len(document["claims"])):
                mutant = copy.deepcopy(document)
                listed = mutant["claims"][claim]["assumptions"]
                mutant["claims"][claim]["assumptions"] = [text for text in listed if "left out" not in text]
                assert outcome(mutant).startswith(f"incomplete: claims[{claim}]")
            mutant = copy.deepcopy(document)
            del mutant["subject"]["preparation"]
            assert outcome(anew(mutant)).startswith("incomplete: subject.preparation does not say")
            assert outcome(mutant) == "false"
        if "label" in entry:
            assert changed(i, label="nobody") == "false"
        if entry["step"] == "level":
            assert changed(i, lines="1", decisions=None, rows=None).startswith("malformed")
        if entry["step"] == "folded":
            assert changed(i, **{"from": ["somebody else"]}) == "false" and changed(i, **{"from": [entry["label"]]}).startswith("malformed")
        if entry["step"] == "intervals":
            assert changed(i, edges=["18", "65"]) == "false" and changed(i, edges=["129/2", "18"]).startswith("malformed")
        if entry["step"] == "mapped":
            assert changed(i, **{"from": ["m"]}) == "false"
    for order in (entries[::-1], [*entries, entries[-1]]):
        mutant = copy.deepcopy(document)
        mutant["subject"]["preparation"] = order
        assert order == entries or outcome(mutant).startswith("malformed")
    mutant = copy.deepcopy(document)
    mutant["subject"]["preparation"] = []
    assert outcome(mutant).startswith("malformed")


def test_notebooks_say_it_too() -> None:
    assert "21/4 of 43/4 decisions have a missing label" in prepared_counts()._repr_html_()


def test_what_was_done_is_told_in_order() -> None:
    assert [dict(entry) for entry in prepared_log().preparation] == [
        {"step": "intervals", "column": "age", "edges": ["18", "129/2"]},
        {"step": "mapped", "column": "sex", "label": "f", "from": ["woman"]},
        {"step": "folded", "column": "u", "label": "yes", "from": ["Yes"]},
        {"step": "folded", "column": "sex", "label": "f", "from": ["F "]},
    ]


def test_certificates_of_before_are_refused_by_name() -> None:
    document = accepted(prepared_counts().certificate)
    del document["subject"]["preparation"]
    for claim in document["claims"]:
        claim["assumptions"] = ["2 of 6 rows have a missing label and were left out; they are taken to be no different from the others"]
    assert outcome(anew(document)).startswith("incomplete: subject.preparation does not say what was left out")


def test_worst_cases_assume_it_too() -> None:
    law = prepared_counts().law
    document = accepted(fa.certify_worst_case(fa.worst_case(law, UtilityClass(tau="1/4"))))
    assert all("left out" in claim["assumptions"][-1] for claim in document["claims"])


def test_a_comparison_says_what_was_done_to_one_log_only() -> None:
    rows = [("yes", "f", 3), ("no", "f", 1), ("yes", "m", 1), ("no", "m", 2)]
    table = {name: [row[i] for row in rows] for i, name in enumerate("uan")}
    plain = fa.certify(fa.Law.from_counts(table, decision="u", group="a", count="n"), {"yes": 1}, confidence=None)
    notes = compare(plain.certificate.document, prepared_counts().certificate.document).notes
    assert any(note.startswith("only now: 21/4 of 43/4 decisions have a missing label") for note in notes)


def test_intervals_read_in_parts_are_recorded(tmp_path: Path) -> None:
    import duckdb

    from fairaudit.audits.in_parts import certify_in_parts

    rows = ", ".join(f"('{u}', '{a}', {age})" for u in ("yes", "no") for a in "fm" for age in (17, 20, 70))
    duckdb.sql(f"copy (select * from (values {rows}) t(u, a, age)) to '{tmp_path}/t.parquet'")
    names = {"decision": "u", "group": "a", "context": "age"}
    parts = certify_in_parts(tmp_path / "t.parquet", {"yes": 1}, **names, bins={"age": [18, 65]}, confidence=None)
    tally = fa.read_log(tmp_path / "t.parquet", ["u", "a", "age"], bins={"age": [18, 65]})
    whole = fa.certify(fa.Law.from_log(tally, **names), {"yes": 1}, confidence=None)
    assert parts.certificate.document["subject"]["preparation"] == whole.certificate.document["subject"]["preparation"]
    accepted(whole.certificate)


def test_a_monitor_records_lines_that_it_could_not_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = [json.dumps({"sex": sex, "answer": answer}) for sex in "fm" for answer in ("yes", "no") for _ in range(20)]
    bad = ["{", "nothing", json.dumps({"answer": "yes"}), json.dumps({"sex": "", "answer": "no"}), json.dumps({"sex": [1], "answer": "no"})]
    log = tmp_path / "log.jsonl"
    log.write_text("\n".join([*good, *bad]) + "\n")
    audit = ("--decision", "answer", "--group", "sex", "--utility", "yes", "--max-local-ratio", "5/4")
    assert run("monitor", log, "--state", tmp_path / "s.db", *audit) == 3
    assert run("certify", "--from-monitor", tmp_path / "s.db", "-o", tmp_path / "c.json") == 3
    assert "2 lines of the log could not be counted and were left out (unreadable line)" in " ".join(capsys.readouterr().out.split())
    document = json.loads((tmp_path / "c.json").read_text())
    assert document["subject"]["preparation"] == [
        {"step": "left out", "reason": reason, "lines": n}
        for reason, n in (("unreadable line", "2"), ("missing label", "2"), ("unusable value", "1"))
    ]
    SCHEMA.validate(document)
    assert outcome(document) == "true" and all(sum("left out" in t for t in c["assumptions"]) == 3 for c in document["claims"])
    for change in ({"lines": "3"}, {"lines": "0"}, {"lines": "3/2"}, {"reason": "laziness"}, {"of": "9"}):
        mutant = copy.deepcopy(document)
        mutant["subject"]["preparation"][0].update(change)
        assert outcome(anew(mutant))[:4] in ("inco", "malf")
        assert outcome(mutant) != "true"


def test_a_report_of_a_log_to_which_nothing_was_done_says_nothing() -> None:
    law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    certificate = fa.certify(law, {"yes": 1}).certificate
    assert not {"preparation", "spellings"} & certificate.document["subject"].keys()
    assert "Before it was counted" not in markdown(certificate.document)


def test_what_was_left_out_stands_before_what_was_cut(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Three columns in intervals fill the lines of the first screen: who is not in the figures must stand above them."""
    path = tmp_path / "log.csv"
    rows = [f"{'yes' if i % 3 else 'no'},{25 + i % 30},{20 + i % 7},{'' if i % 10 == 0 else 60 + i % 17}" for i in range(60)]
    path.write_text("ill,age,weight,pressure\n" + "\n".join(rows) + "\n")
    columns = ("--decision", "ill", "--group", "age:30,40", "--context", "weight:23,25,pressure:70", "--utility", "yes")
    assert run("certify", path, *columns, "--missing", "drop") == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "As read: 6 of 60 decisions have a missing label and were left out ('pressure': 6; by group: " in said
