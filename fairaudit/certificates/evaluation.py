"""What a certificate says of the evaluation log that its table was counted from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from fairaudit.model.law import Law
from fairaudit.tables.evaluations.lost import drawn_said
from fairaudit.tables.evaluations.samples import ERROR, UNDECIDED, Evaluation
from fairaudit.tables.values import Label

__all__ = ["evaluation_entry", "left_out_of_log"]

Place = tuple[Label, Label]  # a context and a group, the empty one where it was not recorded


def evaluation_entry(law: Law, evaluation: Evaluation, *, cells: bool) -> dict[str, Any]:
    """How answers were found in the log, what was drawn, and how many of them decide nothing, in all and by cell.

    Parameters
    ----------
    law : Law
        Counts of the log.
    evaluation : Evaluation
        How it was read.
    cells : bool
        Whether cells are listed, which discloses some of their counts.
    """
    held = dict(_by_cell(law, evaluation))
    answers = {name: sum(counts.get(name, 0) for counts in held.values()) for name in ("read", *UNDECIDED, ERROR)}
    if evaluation.errors == "drop":
        answers[ERROR] = evaluation.lost
    given: dict[str, Any] = {
        "format": evaluation.format,
        "extract": evaluation.extract,
        "options": list(evaluation.options),
        "join": evaluation.join,
        "where": [{"path": path, "value": value} for path, value in evaluation.where],
        "recipe": evaluation.recipe,
        "each": evaluation.each,
        "epochs": evaluation.epochs,
        "question": evaluation.question,
        "unit": list(evaluation.unit),
        "drawn": drawn_said(evaluation),
    }
    return {
        **{key: value for key, value in given.items() if value not in (None, [], "")},
        "errors": evaluation.errors,
        "samples": {"expected": evaluation.expected, "read": evaluation.read, "counted": evaluation.counted, "rows": evaluation.rows},
        "answers": answers,
        **({"unlabelled": evaluation.unlabelled} if evaluation.unlabelled else {}),
        "cells": [_entry(place, counts) for place, counts in sorted(held.items()) if len(counts) > 1] if cells else None,
    }


def left_out_of_log(subject: Mapping[str, Any]) -> Iterator[dict[str, str]]:
    """What of an evaluation log was not counted, as entries of a preparation.

    Examples
    --------
    >>> said = {"errors": "drop", "answers": {"error": 3}, "samples": {"expected": 50, "read": 40, "rows": 40}}
    >>> [(entry["reason"], entry["rows"], entry["of"]) for entry in left_out_of_log({"evaluation": said})]
    [('error', '3', '40'), ('not in the log', '10', '50')]
    """
    said = subject.get("evaluation")
    if said is None:
        return
    samples = said["samples"]
    if said["errors"] == "drop":
        yield {"step": "left out", "reason": "error", "rows": str(said["answers"]["error"]), "of": str(samples["rows"])}
    if samples["expected"]:
        absent = samples["expected"] - samples["read"]
        yield {"step": "left out", "reason": "not in the log", "rows": str(absent), "of": str(samples["expected"])}


def _by_cell(law: Law, evaluation: Evaluation) -> Iterator[tuple[Place, dict[str, int]]]:
    """How many answers of each kind a cell has, those that decide nothing only where there are any."""
    dropped = {(entry.context, entry.group or ()): entry.count for entry in evaluation.dropped}
    places = [(law.contexts[x], law.groups[a]) for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)]
    parts: list[tuple[list[Place], Any]] = [(places, law.weights)]
    if law.unknown is not None:
        parts.append(([(law.contexts[x], ()) for x in law.unknown.contexts.tolist()], law.unknown.weights))
    for of, weights in parts:
        held = {name: weights[:, law.decisions.index(name)].tolist() for name in _kept(evaluation) if name in law.decisions}
        for i, (place, total) in enumerate(zip(of, weights.sum(axis=1).tolist(), strict=True)):
            lost = {name: int(counts[i]) for name, counts in held.items() if counts[i]}
            read = int(total) - sum(lost.values())
            if place in dropped:
                lost[ERROR] = dropped.pop(place)
            yield place, {"read": read, **lost}
    for place, count in dropped.items():
        yield place, {"read": 0, ERROR: count}


def _kept(evaluation: Evaluation) -> tuple[str, ...]:
    """Decisions of the table that an answer is counted as which decides nothing."""
    return (*UNDECIDED, ERROR) if evaluation.errors == "bound" else UNDECIDED


def _entry(place: Place, counts: dict[str, int]) -> dict[str, Any]:
    context, group = place
    return {"context": list(context), "group": list(group) or None, **counts}
