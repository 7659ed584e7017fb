"""What a certificate says of an evaluation log: whatever of it the table contradicts is refused, however it is altered."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import tiers
from certificate_changes import named_anew, same, strictly
from certificate_kinds import outcome
from evaluation_changes import QUESTIONS, SAMPLES, UNITS, audited, changed_evaluations, drawn_log, log_of, may_be_true, traded_counts

import fairaudit as fa

ROWS = [("A", "a", "age", 6), ("B", "a", "age", 3), ("A", "b", "age", 4), ("refused", "b", "age", 2), ("error", "b", "age", 1)]
ALTERATIONS = 10_000 if tiers.FULL else 2_000


def document(rows: list[tuple[Any, ...]] = ROWS, errors: str = "drop", **options: Any) -> Any:
    return json.loads(audited(log_of(rows, errors=errors), **options).certificate.text)


@pytest.mark.parametrize("errors", ["drop", "bound"])
def test_no_alteration_that_says_something_false_of_the_table_is_accepted(errors: str) -> None:
    accepted = altered = 0
    seed = 0
    while altered < ALTERATIONS / 2:
        seed += 1
        original = json.loads(audited(drawn_log(seed, errors=errors), confidence=None if seed % 10 else 0.95).certificate.text)
        assert may_be_true(original, json.dumps(original).encode()) and outcome(json.dumps(original).encode()) == "true"
        for mutant in (*changed_evaluations(original, seed, 60), *traded_counts(original)):
            altered += 1
            assert outcome(mutant) != "true" or same(strictly(mutant)["subject"], original["subject"]), mutant.decode()
            true = outcome(named_anew(mutant)) == "true"
            assert true == may_be_true(original, mutant), mutant.decode()
            accepted += true
    assert accepted > 10  # of what no table shows


@pytest.mark.parametrize(
    ("path", "value", "result"),
    [
        (("answers", "refused"), 1, "false"),
        (("answers", "refused"), -2, "malformed"),
        (("answers", "refused"), "2", "malformed"),
        (("answers", "refused"), 2.0, "malformed"),
        (("answers", "read"), 12, "false"),
        (("answers", "error"), 0, "false"),
        (("answers", "lost"), 0, "malformed"),
        (("cells",), [], "false"),
        (("cells",), None, "malformed"),
        (("cells", 0, "refused"), 1, "false"),
        (("cells", 0, "refused"), 0, "malformed"),
        (("cells", 0, "read"), 5, "false"),
        (("cells", 0, "error"), 2, "false"),
        (("cells", 0, "group"), ["a"], "false"),
        (("cells", 0, "group"), None, "false"),
        (("cells", 0, "group"), ["b", "b"], "malformed"),
        (("samples", "rows"), 17, "false"),
        (("samples", "read"), 15, "malformed"),
        (("samples", "expected"), 15, "malformed"),
        (("errors",), "bound", "malformed"),
        (("errors",), "refuse", "malformed"),
        (("errors",), "ignore", "malformed"),
        (("epochs",), 0, "malformed"),
        (("epochs",), 2, "malformed"),
        (("drawn",), "everything was drawn", "malformed"),
        (("unit",), [], "malformed"),
        (("extract",), "", "malformed"),
        (("unlabelled",), 1, "false"),
        (("unlabelled",), 2, "malformed"),
        (("question",), "number", "true"),
        (("question",), "topic", "malformed"),
        (("question",), "", "malformed"),
        (("recipe",), "bbq", "false"),
        (("recipe",), "bbq-accuracy:answer", "true"),
        (("recipe",), "mine", "malformed"),
        (("each",), "answers[*]", "malformed"),
        (("samples",), {"expected": 16, "read": 16, "counted": 15, "rows": 16}, "false"),
        (("format",), "helm", "true"),
        (("extract",), "^(yes|no)", "true"),
        (("options",), ["A", "B"], "true"),
        (("options",), ["A", "C", "B"], "true"),
        (("options",), ["A", "C"], "false"),
        (("options",), ["a", "b"], "false"),
        (("options",), ["A"], "malformed"),
        (("options",), ["A", "A"], "malformed"),
        (("options",), [], "malformed"),
        (("options",), "A,B", "malformed"),
    ],
)
def test_what_is_changed(path: tuple[Any, ...], value: Any, result: str) -> None:
    changed = document()
    place = changed["subject"]["evaluation"]
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    mutant = json.dumps(changed).encode()
    assert outcome(named_anew(mutant)) == result
    assert outcome(mutant) == ("malformed" if result == "malformed" else "false")


def test_decisions_are_options_as_far_as_labels_stay_what_they_are(tmp_path: Path) -> None:
    """Labels that were folded, a level for what is missing and decisions of a utility that do not occur are no other choice."""
    path = tmp_path / "log.jsonl"
    texts = ["yes", "YES", "no", None]
    path.write_text("\n".join(json.dumps({"text": text, "who": "ab"[i % 2]}) for text in texts for i in range(6)))
    options: dict[str, Any] = {"options": ["yes", "YES", "no", "perhaps"], "missing": "group", "fold_labels": True}
    result = fa.audit(path, decision="text", group="who", utility={"yes": 1, "never": 1}, confidence=None, **options)
    assert set(result.law.decisions) == {"(missing)", "YES", "no", "never"}
    document = json.loads(result.certificate.text)
    assert outcome(json.dumps(document).encode()) == "true"
    document["subject"]["evaluation"]["options"] = ["Yes", "yes", "perhaps"]
    assert outcome(named_anew(json.dumps(document).encode())) == "false"


def test_missing_samples_have_to_be_assumed_away() -> None:
    changed = document()
    changed["subject"]["evaluation"]["samples"]["expected"] = 20
    assert outcome(named_anew(json.dumps(changed).encode())) == "malformed"


def test_a_table_of_fractions_is_of_no_log() -> None:
    changed = document(confidence=None)
    for row in changed["subject"]["table"]["rows"]:
        row["weights"] = [f"{weight}/7" if weight not in ("0",) else weight for weight in row["weights"]]
    assert outcome(json.dumps(changed).encode()) == "malformed"


def test_a_unit_that_nobody_named_carries_no_interval() -> None:
    rows = [(d, r, t, q, n) for (d, r, t, n) in ROWS for q in (1, 2)]
    log = log_of(rows, ("answer", "race", "topic", "id"), errors="drop", epochs=12)
    changed = json.loads(audited(log, unit="id").certificate.text)
    assert outcome(json.dumps(changed).encode()) == "true"
    assert changed["subject"]["evaluation"]["unit"] == ["id"]
    del changed["subject"]["evaluation"]["unit"]
    assert outcome(json.dumps(changed).encode()) == "malformed"


@pytest.mark.parametrize(
    ("read", "unit", "changes", "result"),
    [
        ({}, "id", {}, "true"),
        ({}, "id", {"question": "doc_id"}, "malformed"),
        ({}, "id", {"question": None}, "malformed"),
        ({}, "id", {"drawn": UNITS}, "malformed"),
        ({}, "id", {"question": "doc_id", "drawn": UNITS}, "true"),
        ({}, "id", {"drawn": SAMPLES}, "malformed"),
        ({"drawn": "answers", "question": "topic"}, None, {}, "true"),
        ({"drawn": "answers", "question": "topic"}, None, {"question": "id"}, "malformed"),
        ({"drawn": "answers", "question": "topic"}, None, {"question": None}, "malformed"),
        ({"drawn": "answers", "question": "topic"}, None, {"question": None, "drawn": SAMPLES}, "malformed"),
        ({"drawn": "answers", "question": "topic"}, None, {"drawn": QUESTIONS}, "malformed"),
        ({"drawn": "answers", "question": "topic"}, None, {"question": "id", "drawn": QUESTIONS}, "malformed"),
    ],
)
def test_answers_to_one_question_are_independent_only_where_the_question_is_the_unit_or_of_the_cell(
    read: dict[str, Any], unit: str | None, changes: dict[str, Any], result: str
) -> None:
    rows = [(d, r, t, q, n) for (d, r, t, n) in ROWS for q in (1, 2)]
    log = log_of(rows, ("answer", "race", "topic", "id"), errors="drop", epochs=12, **read)
    changed = json.loads(audited(log, unit=unit).certificate.text)
    said = changed["subject"]["evaluation"] | changes
    changed["subject"]["evaluation"] = {key: value for key, value in said.items() if value is not None or key == "expected"}
    assert outcome(named_anew(json.dumps(changed).encode())) == result


def bbq_certificate(recipe: str, **options: Any) -> Any:
    return json.loads(fa.audit(bbq_file(options.pop("path")), recipe=f"{recipe}:answer", utility="yes", **options).certificate.text)


def bbq_file(path: Path) -> Path:
    """Twelve questions, of which two name nobody whom a stereotype is about, and a third says itself who is meant."""
    rows = []
    for number in range(12):
        people = ("old", "old") if number in (4, 9) else ("old", "nonOld")
        rows.append(
            {
                "example_id": number,
                "question_polarity": "neg",
                "context_condition": "disambig" if number % 3 else "ambig",
                "category": "Age",
                "answer_info": {"ans0": ["x", people[0]], "ans1": ["y", people[1]], "ans2": ["z", "unknown"]},
                "additional_metadata": {"stereotyped_groups": ["old"]},
                "label": number % 2 if number % 3 else 2,
                "answer": "ABC"[number % 3],
                "parts": ["p", "q"],
            }
        )
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return path


@pytest.mark.parametrize(("recipe", "left", "per"), [("bbq", 2, 2), ("bbq-accuracy", 5, 1)])
def test_a_recipe_makes_so_many_rows_of_each_sample_that_makes_any(tmp_path: Path, recipe: str, left: int, per: int) -> None:
    """And what it makes no row of is among what was left out."""
    original = bbq_certificate(recipe, path=tmp_path / "log.jsonl", confidence=None)
    assert outcome(json.dumps(original).encode()) == "true"
    samples = original["subject"]["evaluation"]["samples"]
    assert samples == {"expected": None, "read": 12, "counted": 12, "rows": per * (12 - left)}
    assert [entry for entry in original["subject"]["preparation"] if entry["step"] == "left out"] == [
        {"step": "left out", "reason": "unusable value", "lines": str(left)}
    ]
    for number in (11, 13, 24):
        changed = json.loads(json.dumps(original))
        changed["subject"]["evaluation"]["samples"] |= {"read": number, "counted": number}
        assert outcome(named_anew(json.dumps(changed).encode())) == "false", number
    text = json.dumps(original).replace(f'"lines": "{left}"', f'"lines": "{left - 1}"')
    assert outcome(named_anew(text.replace(f"{left} lines of the log", f"{left - 1} lines of the log").encode())) == "false"
    without = json.loads(json.dumps(original))
    del without["subject"]["evaluation"]["recipe"]
    assert outcome(named_anew(json.dumps(without).encode())) == "false"


def test_a_list_that_is_taken_apart_makes_a_row_for_each_of_its_elements_and_at_least_one(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    rows = [{"id": n, "race": "ab"[n % 2], "said": [{"text": "yes"}] * (n % 4) or None, "d": "yes"} for n in range(20)]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    for named in ({"decision": "said[*].text", "missing": "drop"}, {"decision": "d", "group": ["race"], "context": "said[*].text"}):
        options: dict[str, Any] = {"group": "race", "missing": "drop", **named}
        original = json.loads(fa.audit(path, unit="id", utility="yes", **options).certificate.text)
        said = original["subject"]["evaluation"]
        assert said["each"] == "said[*]" and said["samples"]["rows"] == sum(max(1, n % 4) for n in range(20))
        assert outcome(json.dumps(original).encode()) == "true"
        for samples, each, result in (
            ({"read": 36, "counted": 36}, True, "false"),
            ({"read": 35, "counted": 35}, True, "true"),
            ({}, False, "false"),
        ):
            changed = json.loads(json.dumps(original))
            changed["subject"]["evaluation"]["samples"] |= samples
            if not each:
                del changed["subject"]["evaluation"]["each"]
            assert outcome(named_anew(json.dumps(changed).encode())) == result


def screen(document: Any, path: Path) -> str:
    path.write_text(json.dumps(document))
    asked = [sys.executable, "-m", "fairaudit.checker", "--verbose", str(path)]
    ran = subprocess.run(asked, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return " ".join(ran.stdout.split())


def test_what_no_table_shows_is_said(tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    given = document()
    unseen = "Of which groups the errors are that were left out the table does not show: nothing here checks it."
    assert unseen in screen(given, path)
    assert unseen not in screen(document(errors="bound"), path)
    assert "that the table does not have" not in screen(given, path)
    (cell,) = given["subject"]["evaluation"]["cells"]
    given["subject"]["evaluation"]["cells"] = [
        {key: value for key, value in cell.items() if key != "error"},
        {"context": ["zzz"], "group": ["b"], "read": 0, "error": 1},
    ]
    given = json.loads(named_anew(json.dumps(given).encode()))
    assert "1 errors are of cells that the table does not have" in screen(given, path)


def test_that_answers_to_one_question_cannot_be_told_apart_is_said(tmp_path: Path) -> None:
    rows = [(d, r, t, q, n) for (d, r, t, n) in ROWS for q in (1, 2)]
    log = log_of(rows, ("answer", "race", "topic", "id"), errors="drop", epochs=12)
    said = screen(json.loads(audited(log, unit="id").certificate.text), tmp_path / "certificate.json")
    assert "Each question was asked up to 12 times, and which answers are to one question is not in the table." in said
