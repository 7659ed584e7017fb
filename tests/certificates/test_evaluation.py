"""What certificates of evaluation logs say: counted here from the rows of the log, and accepted by the checker and the schema."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

import pytest
from certificate_kinds import assert_accepted
from evaluation_changes import ANSWERS, LOST, NOTHING, QUESTIONS, audited, drawn_log, log_of

import fairaudit as fa
from fairaudit.audits.reading import Reading, read_law
from fairaudit.certificates.compare import compare_documents as compare
from fairaudit.errors import InputError
from fairaudit.tables.evaluations.samples import Run

COLUMNS = ("answer", "race", "topic")


@pytest.mark.parametrize("errors", ["drop", "bound"])
@pytest.mark.parametrize("seed", range(12))
def test_answers_are_those_of_the_log(seed: int, errors: str) -> None:
    log = drawn_log(seed, errors=errors)
    result = audited(log)
    assert_accepted(result.certificate)
    counts: dict[tuple[str, str], Counter[str]] = {}
    for answer, race, topic, number in zip(*(log[name] for name in COLUMNS), log.counts.tolist(), strict=True):
        counts.setdefault((topic, race), Counter())[answer if answer in LOST else "read"] += number
    said = json.loads(result.certificate.text)["subject"]["evaluation"]
    listed = {(entry["context"][0], entry["group"][0]): entry for entry in said["cells"]}
    assert sorted(listed) == sorted(place for place, own in counts.items() if own.total() > own["read"])
    for place, entry in listed.items():
        assert {name: entry[name] for name in entry if name not in ("context", "group")} == {"read": counts[place]["read"], **counts[place]}
    total = sum(counts.values(), Counter())
    assert said["answers"] == {name: total[name] for name in ("read", *LOST)}
    assert said["samples"] == dict.fromkeys(("expected", "read", "counted", "rows"), log.rows)
    left_out = [text for text in result.claims[0].assumptions if "ended in an error" in text]
    assert bool(left_out) == (errors == "drop" and total["error"] > 0)


def test_how_answers_were_found_is_stated() -> None:
    rows = [("A", "a", "age", 6), ("B", "b", "age", 3)]
    said: dict[str, Any] = {
        "extract": "^(A|B)",
        "join": "id",
        "where": (("filter", "first"),),
        "recipe": "bbq-accuracy",
        "options": ("A", "B"),
    }
    entry = json.loads(audited(log_of(rows, expected=None, read=20, **said), confidence=None).certificate.text)["subject"]["evaluation"]
    assert entry["where"] == [{"path": "filter", "value": "first"}] and (entry["extract"], entry["join"]) == ("^(A|B)", "id")
    assert entry["samples"] == {"expected": None, "read": 20, "counted": 9, "rows": 9} and entry["recipe"] == "bbq-accuracy"
    assert entry["options"] == ["A", "B"]


@pytest.mark.parametrize(
    ("unit", "said", "sentence"),
    [
        (None, {}, QUESTIONS),
        ("id", {"epochs": 3}, QUESTIONS),
        (["id", "epoch"], {"epochs": 3, "drawn": "answers"}, ANSWERS),
        (["id", "epoch"], {"epochs": 3, "drawn": "answers", "runs": (("run.eval", Run("inspect", fixed="temperature 0")),)}, NOTHING),
        (None, {"epochs": 3, "drawn": "answers", "question": "topic"}, ANSWERS),
        ("id", {"drawn": "units", "question": "metadata.number"}, "sampling units were drawn; samples of a unit count once"),
        (None, {"drawn": "units", "question": ""}, "samples were drawn, each of them by itself"),
    ],
)
def test_what_was_drawn_is_said_in_a_sentence(unit: Any, said: dict[str, Any], sentence: str) -> None:
    rows = [(answer, race, "age", question, epoch, 1) for answer in "AB" for race in "ab" for question in (1, 2) for epoch in (1, 2, 3)]
    log = log_of(rows, (*COLUMNS, "id", "epoch"), **said)
    confidence = None if sentence == NOTHING else 0.9
    if confidence is None:
        with pytest.raises(InputError, match="the log says temperature 0"):
            audited(log, unit=unit)
    certificate = audited(log, unit=unit, confidence=confidence).certificate
    assert_accepted(certificate)
    assert json.loads(certificate.text)["subject"]["evaluation"]["drawn"] == sentence


def test_a_table_that_is_not_disclosed_has_its_sums_alone() -> None:
    certificate = audited(drawn_log(1, errors="drop"), embed_table=False, confidence=None).certificate
    assert_accepted(certificate)
    said = json.loads(certificate.text)["subject"]["evaluation"]
    assert said["cells"] is None and "unlabelled" not in said


def test_decisions_of_unknown_group_have_no_group() -> None:
    rows = [("A", "a", "age", 6), ("B", "b", "age", 3), ("refused", "n/a", "age", 2), ("A", "n/a", "age", 1), ("error", "n/a", "age", 1)]
    law = fa.Law.from_log(log_of(rows, errors="drop"), decision="answer", group="race", context="topic", unknown=["n/a"])
    certificate = fa.certify(law, {"A": 1}).certificate
    assert_accepted(certificate)
    said = json.loads(certificate.text)["subject"]["evaluation"]
    assert said["cells"] == [{"context": ["age"], "group": None, "read": 1, "refused": 2, "error": 1}]


def test_labels_that_are_missing_are_left_out_beside_errors() -> None:
    rows = [("A", "a", "age", 6), ("B", "b", "age", 3), ("A", None, "age", 2), ("error", None, "age", 4), ("error", "a", "age", 1)]
    law = fa.Law.from_log(log_of(rows, errors="drop"), decision="answer", group="race", context="topic", missing="drop")
    result = fa.certify(law, {"A": 1})
    assert_accepted(result.certificate)
    said = json.loads(result.certificate.text)["subject"]["evaluation"]
    assert said["unlabelled"] == 4 and said["answers"]["error"] == 5 and said["samples"]["rows"] == 16
    assert [text.partition(";")[0] for text in result.claims[0].assumptions] == [
        "5 of 16 rows of the evaluation log ended in an error and were left out",
        "2 of 11 decisions have a missing label and were left out",
    ]


def test_a_policy_is_not_read_from_a_log_of_answers() -> None:
    law = fa.Law.from_log(drawn_log(1, errors="drop"), decision="answer", group="race", context="topic")
    groups = [group for (group,) in law.groups]
    deployment = fa.Policy(law).behind(group=fa.RandomizedResponse(groups, epsilon=1))
    with pytest.raises(InputError, match="not read from an evaluation log"):
        fa.certify(deployment, {"A": 1})


def test_a_new_log_of_which_more_was_left_out_is_not_better() -> None:
    rows = [("A", "a", "age", 40), ("B", "a", "age", 10), ("A", "b", "age", 20), ("B", "b", "age", 30)]
    fairer = [("A", "a", "age", 40), ("B", "a", "age", 10), ("A", "b", "age", 40), ("B", "b", "age", 10), ("error", "b", "age", 20)]
    old, new = (audited(log_of(one, errors="drop"), confidence=None).certificate.document for one in (rows, fairer))
    found = compare(old, new)
    assert "20 of 120 rows left out (error), 0 of 100 rows left out (error)" in found.gone
    assert not any(change.direction == "better" for change in (found.verdict, *found.metrics))
    short = audited(log_of(rows, expected=110), confidence=None).certificate.document
    assert "10 of 110 rows left out (not in the log), 0 of 100 rows left out (not in the log)" in compare(old, short).gone


def test_what_else_reads_a_log_says_what_was_left_out_or_refuses_it() -> None:
    log = log_of([("A", "a", "age", 6), ("B", "b", "age", 3), ("error", "b", "age", 2)], errors="drop")
    law = read_law(log, Reading("answer", ("race",)))
    assert law.notes == ("2 of 11 rows ended in an error and were left out",)
    with pytest.raises(InputError, match="an evaluation log is audited by certify"):
        fa.subgroups(log, decision="answer", attributes=["race", "topic"], utility="A")
