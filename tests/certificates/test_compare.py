"""What moved between two certificates."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from certificate_kinds import FOUR, KINDS, admissions, small_counts
from envelopes import result_of
from hypothesis import given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.certificates.compare import compare_documents as compare
from fairaudit.cli import main as command
from fairaudit.testing import laws

RANK = {"none": 0, "within": 1, "inconclusive": 2, "exceeds": 3}


def made(yes: int, **options: Any) -> dict[str, Any]:
    law = fa.Law.from_array([[yes, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    return fa.certify(law, {"yes": 1}, **{"confidence": None, **options}).certificate.document


@pytest.mark.parametrize("kind", KINDS)
def test_a_certificate_is_like_itself(kind: Any) -> None:
    document = kind(**FOUR).certificate.document
    found = compare(document, document)
    assert not found.worse and not found.risen and found.cells == ()
    assert {c.direction for c in (found.verdict, *found.targets, *found.metrics, *found.intervals, *found.bounds)} == {"same"}


@given(data=st.data())
@settings(max_examples=60)
def test_moves_are_exact(data: st.DataObject) -> None:
    shape = {"max_contexts": 3, "max_groups": 3, "max_decisions": 2, "kinds": ("counts",), "complete": True}
    first, second = data.draw(laws(**shape)), data.draw(laws(**shape))
    utility = {first.decisions[0]: 1}
    one, two = (fa.certify(law, utility, max_local_ratio="5/4", confidence=None) for law in (first, second))
    found = compare(one.certificate.document, two.certificate.document)
    assert one.local is not None and two.local is not None
    better = "not comparable" if found.gone else "better"
    direction = "same" if one.local.ratio == two.local.ratio else "worse" if two.local.ratio > one.local.ratio else better
    assert found.metrics[0].direction == direction
    assert found.worse is (RANK[two.verdict] > RANK[one.verdict])
    for moved in found.cells:
        assert moved.old != moved.new
    distances = [abs(m.new - m.old) for m in found.cells if m.old is not None and m.new is not None]
    assert distances == sorted(distances, reverse=True)


def test_a_verdict_that_changes() -> None:
    found = compare(made(3, max_local_ratio="8/5"), made(5, max_local_ratio="8/5"))
    assert (found.verdict.old, found.verdict.new, found.verdict.direction) == ("within", "exceeds", "worse")
    assert found.worse and found.risen
    back = compare(made(5, max_local_ratio="8/5"), made(3, max_local_ratio="8/5"))
    assert back.verdict.direction == "better" and not back.worse and not back.risen
    assert [(m.group, m.old, m.new) for m in found.cells] == [({"group": "f"}, Fraction(3, 4), Fraction(5, 6))]


@pytest.mark.parametrize(
    ("old", "new", "worse", "note"),
    [
        ({"max_local_ratio": 2}, {}, True, "dropped"),
        ({}, {"max_local_ratio": 2}, False, "new"),
        ({}, {"max_local_ratio": "5/4"}, True, "new"),
        ({"max_local_ratio": 2}, {"max_local_ratio": 3}, True, "loosened from 2 to 3"),
        ({"max_local_ratio": 3}, {"max_local_ratio": 2}, False, "tightened"),
        ({"max_local_ratio": 90, "confidence": "0.9"}, {"max_local_ratio": 90}, True, "judged for this table"),
        ({"max_local_ratio": 90, "confidence": "0.9"}, {"max_local_ratio": 90, "confidence": "0.8"}, True, "4/5"),
    ],
)
def test_targets_that_are_not_the_same(old: dict[str, Any], new: dict[str, Any], worse: bool, note: str) -> None:
    found = compare(made(3, **old), made(3, **new))
    assert found.worse is worse
    assert note in found.targets[0].note


def test_intervals_that_do_not_overlap() -> None:
    def sampled(yes: int) -> dict[str, Any]:
        law = fa.Law.from_array([[yes, 1000 - yes], [500, 500]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
        return fa.certify(law, {"yes": 1}).certificate.document

    assert compare(sampled(510), sampled(900)).intervals[0].direction == "worse"
    assert compare(sampled(900), sampled(510)).intervals[0].direction == "better"
    near = compare(sampled(510), sampled(520)).intervals[0]
    assert near.direction == "changed" and "may be chance" in near.note
    law = fa.Law.from_array([[510, 490], [500, 500]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    judged = fa.certify(law, {"yes": 1}, max_local_ratio=2).certificate.document
    found = compare(sampled(510), judged).intervals[0]
    assert found.new is not None and found.new.startswith("at least 1, at most ")
    assert "the confidence is that of each end by itself, before of both ends together" in found.note
    assert compare(judged, judged).intervals[0].direction == "same"


def test_what_answers_another_question_is_refused() -> None:
    other_column = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", columns=fa.Columns("u", ("sex",)), decisions=["yes", "no"])
    other_utility = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    for law, utility, said in (
        (other_column, {"yes": 1}, "column"),
        (other_utility, {"yes": 2}, "utility of 'yes' is 1 in one and 2 in the"),
    ):
        document = fa.certify(law, utility, confidence=None).certificate.document
        with pytest.raises(fa.InputError, match=said):
            compare(made(3), document)
    worst = fa.certify_worst_case(fa.worst_case(other_utility, fa.UtilityClass(gamma=1, tau="0.3"))).document
    with pytest.raises(fa.InputError, match="class"):
        compare(made(3), worst)
    assert not compare(worst, worst).worse
    with pytest.raises(fa.InputError, match="no certificate"):
        compare(made(3), {"subject": {}})


def test_notes_say_what_is_not_comparable() -> None:
    more = fa.Law.from_array([[3, 1], [1, 1], [1, 4]], kind="counts", decisions=["yes", "no"], groups=["f", "m", "x"])
    found = compare(made(3), fa.certify(more, {"yes": 1}, confidence=None).certificate.document)
    assert any(note.startswith("groups: 0 only in the old table, 1 only in the new one") for note in found.notes)
    assert [(m.old, m.new) for m in found.cells] == [(None, Fraction(1, 5))]
    hidden = compare(made(3, embed_table=False), made(4))
    assert hidden.cells == () and any("does not hold its table" in note for note in hidden.notes)


def counts(rows: dict[tuple[str, str], tuple[int, int]], **options: Any) -> dict[str, Any]:
    """A certificate about (context, group) -> (yes, no)."""
    table: dict[str, list[Any]] = {"job": [], "sex": [], "answer": [], "n": []}
    for (job, sex), (yes, no) in rows.items():
        for answer, n in (("yes", yes), ("no", no)):
            for name, value in zip(table, (job, sex, answer, n), strict=True):
                table[name].append(value)
    law = fa.Law.from_counts(table, decision="answer", group="sex", context="job", count="n")
    return fa.certify(law, {"yes": 1}, **{"confidence": None, "max_local_ratio": 2, **options}).certificate.document


OLD = {("cook", "f"): (90, 10), ("cook", "m"): (80, 20), ("cook", "x"): (20, 80), ("clean", "f"): (50, 50), ("clean", "m"): (50, 50)}


@pytest.mark.parametrize(
    ("new", "said"),
    [
        ({k: v for k, v in OLD.items() if k[1] != "x"}, "group 'x' is not there any more"),
        ({k: v for k, v in OLD.items() if k[0] != "cook"}, "context 'cook' is not there any more"),
        (
            {("cook", "f"): (90, 10), ("cook", "m or x"): (100, 100), ("clean", "f"): (50, 50), ("clean", "m or x"): (50, 50)},
            "group 'm' is",
        ),
        ({**{k: v for k, v in OLD.items() if k[1] != "x"}, ("clean", "x"): (50, 50)}, "group 'x' in context 'cook' is not there any more"),
    ],
)
def test_what_is_gone_is_not_better(new: dict[Any, Any], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The worst group, or its context, is left out or merged into another: the verdict improves, fairness does not."""
    old, now = counts(OLD), counts(new)
    found = compare(old, now)
    assert (found.verdict.old, found.verdict.new, found.verdict.direction) == ("exceeds", "within", "not comparable")
    assert not found.worse and any(text.startswith(said) for text in found.gone)
    assert "better" not in {c.direction for c in (*found.targets, *found.metrics, *found.intervals, *found.bounds)}
    paths = [write(tmp_path, name, document) for name, document in (("old.json", old), ("new.json", now))]
    for form in ("text", "markdown"):
        assert command(["compare", *paths, "--format", form]) == 3
        out = capsys.readouterr().out
        assert "NOT COMPARABLE" in out and "BETTER" not in out and "better" not in out
    assert command(["compare", *paths, "--format", "json"]) == 3
    assert result_of(capsys.readouterr().out)["not_comparable"] == list(found.gone)
    assert command(["compare", *reversed(paths)]) == 1  # what comes and exceeds is worse
    capsys.readouterr()


def test_a_decision_that_is_gone_and_one_that_comes() -> None:
    def made(decisions: dict[str, tuple[int, int]]) -> dict[str, Any]:
        law = fa.Law.from_array([list(row) for row in zip(*decisions.values(), strict=True)], kind="counts", decisions=list(decisions))
        return fa.certify(law, {"yes": 1}, confidence=None).certificate.document

    three, two = made({"yes": (5, 5), "maybe": (4, 1), "no": (1, 4)}), made({"yes": (5, 4), "no": (5, 5)})
    assert compare(three, two).gone == ("decision 'maybe' is not there any more",)
    assert compare(two, three).gone == ()


def test_what_was_prepared_differently_is_not_better() -> None:
    new = {key: value for key, value in OLD.items() if key != ("cook", "x")} | {("cook", "x"): (80, 80)}

    def prepared(rows: dict[Any, Any], *entries: dict[str, Any]) -> dict[str, Any]:
        document = counts(rows)
        return {**document, "subject": {**document["subject"], **({"preparation": list(entries)} if entries else {})}}

    def left(n: int) -> dict[str, Any]:
        return {"step": "left out", "reason": "missing label", "decisions": str(n), "of": "1300", "columns": {"sex": str(n)}}

    folded = {"step": "folded", "column": "sex", "label": "f", "from": ["F"]}
    merged = {"step": "mapped", "column": "sex", "label": "f", "from": ["x"]}
    assert compare(prepared(OLD), prepared(new)).verdict.direction == "better"
    assert compare(prepared(OLD, left(10)), prepared(new, left(10))).gone == ()
    assert compare(prepared(OLD, left(10)), prepared(new, left(5))).gone == ()
    for before, now, said in (
        (prepared(OLD), prepared(new, left(1100)), "1100 of 1300 decisions left out (missing label), none before"),
        (prepared(OLD, left(10)), prepared(new, left(1100)), "1100 of 1300 decisions left out (missing label), 10 of 1300 decisions"),
        (prepared(OLD, merged), prepared(new), "in column 'sex', 'x' counts as 'f' in one and as a label of its own in the other"),
    ):
        found = compare(before, now)
        assert found.verdict.direction == "not comparable" and any(text.startswith(said) for text in found.gone), found.gone
    assert compare(prepared(OLD, folded), prepared(new)).gone == ()


def test_tables_that_are_not_there_show_no_progress() -> None:
    better = compare(counts(OLD, embed_table=False), counts({k: v for k, v in OLD.items() if k[1] != "x"}, embed_table=False))
    assert better.verdict.direction == "not comparable" and "does not hold its table" in better.gone[0]
    assert compare(counts(OLD, embed_table=False), counts(OLD)).gone == ()


# The command


def write(directory: Path, name: str, document: Any) -> str:
    path = directory / name
    path.write_text(json.dumps(document))
    return str(path)


def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, same = write(tmp_path, "old.json", made(3, max_local_ratio=2)), write(tmp_path, "same.json", made(4, max_local_ratio=2))
    worse = write(tmp_path, "worse.json", made(100, max_local_ratio="3/2"))
    assert command(["compare", old, same]) == 0
    assert command(["compare", old, same, "--fail-on", "rise"]) == 1
    assert command(["compare", same, old, "--fail-on", "rise"]) == 0
    assert command(["compare", old, worse]) == 1
    out = capsys.readouterr().out
    assert "local ratio   " in out and "1.5 (3/2) -> 1.6 (8/5)" in out and "exceeds" in out
    assert "1.067 times" in out and "0.9375 times" in out and "+0." in out
    false = made(3)
    false["metrics"]["local"]["ratio"] = "5/4"
    assert command(["compare", old, write(tmp_path, "false.json", false)]) == 2
    assert command(["compare", old, write(tmp_path, "other.json", admissions().certificate.document)]) == 2
    assert command(["compare", old, str(tmp_path / "absent.json")]) == 2
    assert command(["compare", old, old, "--top", "-1"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 4


@pytest.mark.parametrize("form", ["text", "json", "markdown"])
def test_formats(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = write(tmp_path, "old.json", small_counts(max_local_ratio="5/4", confidence="0.9").certificate.document)
    new = write(tmp_path, "new.json", small_counts(max_local_ratio="5/2", confidence=None).certificate.document)
    assert command(["compare", old, new, "--format", form]) == 1
    out = capsys.readouterr().out
    if form == "json":
        found = result_of(out)
        assert found["worse"] is True and found["moved"] == [] and found["metrics"][0]["old"] == "19/8"
    else:
        assert "WORSE" in out and "loosened from 5/4 to 5/2" in out and "19/8" in out


@pytest.mark.parametrize("form", ["text", "markdown"])
def test_a_bound_is_named_as_the_measure_that_it_bounds(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without its quantity's name in words, the paper's equalized odds would pass for those of the true label."""
    cells = [{("x", "f"): (yes, 4), ("x", "m"): (4, 4)} for yes in (4, 8)]
    files = [write(tmp_path, f"{i}.json", counts(rows)) for i, rows in enumerate(cells)]
    command(["compare", *files, "--format", form])
    out = capsys.readouterr().out
    assert "parity within contexts (the paper's equalized odds) by T7, about this law" in out
    assert "equalized odds by" not in out.replace("(the paper's equalized odds)", "") and "equalized_odds" not in out


def test_labels_are_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def hostile(yes: int) -> dict[str, Any]:
        groups = ["\x1b[31m<b>\u202e|@you", "m"]
        law = fa.Law.from_array([[yes, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=groups)
        return fa.certify(law, {"yes": 1}, confidence=None).certificate.document

    old, new = write(tmp_path, "old.json", hostile(3)), write(tmp_path, "new.json", hostile(4))
    for form in ("text", "json", "markdown"):
        assert command(["compare", old, new, "--format", form]) == 0
        out = capsys.readouterr().out
        assert "\x1b" not in out and "\u202e" not in out
        assert form != "markdown" or ("<b>" not in out and "@you" not in out)
