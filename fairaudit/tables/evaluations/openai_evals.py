"""Records of OpenAI evals: a line for each event, of which those of type ``match`` are the samples."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.evaluations.json_text import LINE, first_row, having, json_lines, opened, part, text
from fairaudit.tables.evaluations.samples import Format, Run, Sample

__all__ = ["KEYS", "OPENAI_EVALS"]

KEYS = ("run_id", "event_id", "sample_id", "type", "data")

MATCH = "match"


def _run(path: str) -> Run:
    spec = part(first_row(path), "spec")
    models = spec.get("completion_fns")
    model = models[0] if isinstance(models, list) and models and isinstance(models[0], str) else text(spec, "model_name")
    with opened(path) as file:
        whole = any(b'"final_report"' in line for line in file)
    return Run(
        format=OPENAI_EVALS.name,
        producer="OpenAI evals",
        model=model,
        task=text(spec, "eval_name"),
        status="" if not spec else "with a final report" if whole else "without a final report",
    )


def _samples(path: str, _: Collection[str]) -> Iterator[Sample]:
    asked: dict[Any, int] = {}
    answered: set[Any] = set()
    for line, row in json_lines(path):
        if "spec" in row or "final_report" in row:
            continue
        having(row, KEYS, path, line, "an event of OpenAI evals")
        name = row["sample_id"]
        if name is None:
            continue
        if not isinstance(name, (str, int)):
            raise InputError(f"{path}, line {line}: the sample_id is {shown(name)}; a text or a number is expected")
        if row["type"] == MATCH:
            answered.add(name)
            yield Sample(row, "read", LINE, (line,))
        else:
            asked.setdefault(name, line)
    for name, line in asked.items():
        if name not in answered:
            yield Sample({"sample_id": name, "type": MATCH, "data": {}}, "error", LINE, (line,))


OPENAI_EVALS = Format(
    "openai-evals",
    _run,
    _samples,
    key=("sample_id",),
    question="sample_id",
    answers=("data.sampled",),
    parts=("sample_id", "data", "eval.model", "eval.task"),
)
