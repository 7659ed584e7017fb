"""Samples in the form of Every Eval Ever: ``*_samples.jsonl``, a line for each sample and metric."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from fairaudit.tables.evaluations.json_text import LINE, first_row, having, json_lines, only, part, said, text
from fairaudit.tables.evaluations.samples import Format, Run, Sample, ended

__all__ = ["EVERY_EVAL_EVER", "KEYS"]

KEYS = ("schema_version", "interaction_type", "answer_attribution")


def _run(path: str) -> Run:
    found = said(path, "model_id", "evaluation_name", "epoch")
    return Run(
        format=EVERY_EVAL_EVER.name,
        producer=f"Every Eval Ever {text(first_row(path), 'schema_version')}",
        model=only(found["model_id"]),
        task=only(found["evaluation_name"]),
        epochs=max(1, len(found["epoch"])),
    )


def _samples(path: str, _: Collection[str]) -> Iterator[Sample]:
    for line, row in json_lines(path):
        having(row, KEYS, path, line, "a sample of Every Eval Ever")
        outcome = ended(part(row, "metadata").get("stop_reason"))
        yield Sample({**row, "answer": _answer(row)}, outcome if row.get("error") is None else "error", LINE, (line,))


def _answer(row: Mapping[str, Any]) -> Any:
    """The value that was taken out of the answer at its end, if one was."""
    steps = row["answer_attribution"]
    ends = [step for step in steps if isinstance(step, dict) and step.get("is_terminal")] if isinstance(steps, list) else []
    return ends[-1].get("extracted_value") if ends else None


EVERY_EVAL_EVER = Format(
    "eee",
    _run,
    _samples,
    key=("model_id", "evaluation_id", "evaluation_name", "evaluation_result_id", "sample_id", "metadata.epoch"),
    question="sample_id",
    repetition="metadata.epoch",
    task="evaluation_name",
    single=("evaluation_name", "evaluation_result_id"),
    answers=("answer", "output.raw[0]"),
    parts=(
        *("sample_id", "metadata", "evaluation_name", "evaluation_result_id", "answer", "output.raw"),
        *("evaluation.score", "evaluation.is_correct", "eval.model", "eval.task"),
    ),
)
