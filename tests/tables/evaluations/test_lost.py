"""Samples without an answer: counted by the cell in which they would be, and taken out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from evaluation_changes import log_of

import fairaudit as fa
from fairaudit.audits.reading import Reading, read_law
from fairaudit.errors import InputError

ROWS = [("A", "a", "age", 6), ("B", "b", "age", 3), ("error", "b", "age", 2), ("error", "c", "home", 1)]


def test_errors_are_counted_by_cell_and_taken_out_also_where_nothing_else_is_left() -> None:
    law = fa.Law.from_log(log_of(ROWS, errors="drop"), decision="answer", group="race", context="topic")
    assert law.decisions == ("A", "B") and law.groups == (("a",), ("b",)) and law.weights.tolist() == [[6, 0], [0, 3]]
    assert law.evaluation is not None and law.evaluation.rows == 12
    assert [(entry.context, entry.group, entry.count) for entry in law.evaluation.dropped] == [
        (("age",), ("b",), 2),
        (("home",), ("c",), 1),
    ]
    assert law.assumptions == (
        "3 of 12 rows of the evaluation log ended in an error and were left out; they are taken to be no different from the others",
    )


def test_errors_that_are_bounded_stay() -> None:
    law = fa.Law.from_log(log_of(ROWS, errors="bound"), decision="answer", group="race", context="topic")
    assert law.decisions == ("A", "B", "error") and law.assumptions == ()


def test_labels_of_groups_are_merged_before_errors_are_counted() -> None:
    rows = [*ROWS, ("error", "B ", "age", 4)]
    law = read_law(log_of(rows, errors="drop"), Reading("answer", ("race",), ("topic",), fold_labels=True))
    assert law.evaluation is not None
    assert [(entry.context, entry.group, entry.count) for entry in law.evaluation.dropped] == [
        (("age",), ("b",), 6),
        (("home",), ("c",), 1),
    ]


@pytest.mark.parametrize("rows", [[("Refused", "a", "age", 1)], [("ERROR ", "b", "age", 1)]])
def test_a_decision_does_not_become_a_word_for_none_by_its_spelling(rows: list[tuple[str, str, str, int]]) -> None:
    log = log_of([*ROWS, ("refused", "a", "age", 1), *rows], errors="drop")
    with pytest.raises(InputError, match="says that an answer decided nothing"):
        read_law(log, Reading("answer", ("race",), ("topic",), fold_labels=True))


@pytest.mark.parametrize("label_map", [{"A": "refused"}, {"error": "B"}])
def test_a_map_neither_makes_nor_hides_answers_that_decide_nothing(label_map: dict[str, str]) -> None:
    with pytest.raises(InputError, match="says that an answer decided nothing"):
        read_law(log_of(ROWS, errors="drop"), Reading("answer", ("race",), ("topic",), label_map={"answer": label_map}))


def test_an_error_without_a_label_is_refused_or_belongs_to_no_cell() -> None:
    rows = [*ROWS, ("error", None, "age", 5)]
    with pytest.raises(InputError, match="the label is missing"):
        fa.Law.from_log(log_of(rows, errors="drop"), decision="answer", group="race", context="topic")
    dropped = fa.Law.from_log(log_of(rows, errors="drop"), decision="answer", group="race", context="topic", missing="drop")
    assert dropped.evaluation is not None and (dropped.evaluation.unlabelled, dropped.evaluation.lost) == (5, 8)
    unknown = fa.Law.from_log(log_of(rows, errors="drop"), decision="answer", group="race", context="topic", missing="unknown")
    assert unknown.evaluation is not None
    assert [(entry.group, entry.count) for entry in unknown.evaluation.dropped] == [(None, 5), (("b",), 2), (("c",), 1)]


def test_a_log_of_errors_alone_leaves_nothing() -> None:
    with pytest.raises(InputError, match="all 3 samples ended in an error"):
        fa.Law.from_log(log_of(ROWS[2:], errors="drop"), decision="answer", group="race", context="topic")


def test_samples_carry_no_counts_or_probabilities() -> None:
    rows = [(answer, race, number, 1) for answer in "AB" for race, number in (("a", 3), ("b", 4))]
    for columns in ({"count": "n"}, {"probability": "n"}):
        read = fa.Law.from_counts if "count" in columns else fa.Law.from_probabilities
        with pytest.raises(InputError, match="a sample in each row, and no counts, shares or probabilities"):
            read(log_of(rows, ("answer", "race", "n")), decision="answer", group="race", **columns)
    plain = log_of(rows, ("answer", "race", "n"), format="rows", where=(("kind", "count"),))
    law = fa.Law.from_counts(plain, decision="answer", group="race", count="n")
    assert law.weights.tolist() == [[3, 3], [4, 4]] and law.evaluation is None


def test_a_table_has_the_draws_with_which_its_log_was_read(tmp_path: Path) -> None:
    """Else epochs of a question would pass as draws by themselves, or a unit as a question."""
    log = tmp_path / "run.json"
    asked = {"model": "m", "task": "t", "config": {"epochs": 2}, "dataset": {"sample_ids": [*range(8)]}}
    samples = [
        {"id": n, "epoch": e, "metadata": {"race": "ab"[n % 2]}, "output": {}, "scores": {"choice": {"answer": "AB"[(n + e) % 2]}}}
        for n in range(8)
        for e in (1, 2)
    ]
    log.write_text(json.dumps({"version": 2, "status": "success", "eval": asked, "samples": samples}))
    columns: dict[str, Any] = {"decision": "scores.choice.answer", "group": "metadata.race"}
    names = [*columns.values(), "id", "epoch"]
    tally = fa.read_log(log, names, **columns, unit="id")
    read = fa.Law.from_log(tally, **columns, unit="id").evaluation
    assert read is not None and read.unit == ("id",) and read.question == "id"
    for unit in (None, "epoch", ["id", "epoch"]):
        with pytest.raises(
            InputError, match=r"the log was read with the sampling unit id, and the table is to have (none|epoch|id, epoch)"
        ):
            fa.Law.from_log(tally, **columns, unit=unit)
    each = fa.read_log(log, names, **columns)
    with pytest.raises(InputError, match="id is neither a context nor a group"):
        fa.Law.from_log(each, **columns)
    assert fa.Law.from_log(each, **columns, context="id").evaluation is not None
