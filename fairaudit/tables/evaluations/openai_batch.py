"""Outputs of batches of OpenAI: a line for each request, in any order."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from fairaudit.tables.evaluations.chat import declined, message
from fairaudit.tables.evaluations.json_text import LINE, having, json_lines, objects, only, part, said
from fairaudit.tables.evaluations.replies import OK, fault_of, refused_of
from fairaudit.tables.evaluations.samples import Format, Outcome, Run, Sample, ended

__all__ = ["KEYS", "OPENAI_BATCH"]

KEYS = ("custom_id", "response")


def _run(path: str) -> Run:
    return Run(format=OPENAI_BATCH.name, producer="OpenAI Batch", model=only(said(path, "model")["model"]))


def _samples(path: str, _: Collection[str]) -> Iterator[Sample]:
    for line, row in json_lines(path):
        having(row, KEYS, path, line, "an output of a batch")
        yield Sample(row, _outcome(row), LINE, (line,))


def _body(row: Mapping[str, Any]) -> Mapping[str, Any]:
    return part(part(row, "response"), "body")


def _outcome(row: Mapping[str, Any]) -> Outcome:
    body = _body(row)
    failed = row.get("error") is not None or body.get("error") is not None
    status = part(row, "response").get("status_code")
    if failed and (declined(row) or refused_of(status, body)):
        return "refused"
    items, fault = body.get("output"), fault_of(status, body)
    if failed or (fault and not (status == OK and isinstance(items, list))):
        return "error"
    answer = None if fault else message(body)
    parts = [each for item in objects(items) for each in objects(item.get("content"))]
    if (answer is not None and answer.refusal) or any(each.get("type") == "refusal" for each in parts):
        return "refused"
    return ended(part(body, "incomplete_details").get("reason") if answer is None else answer.ended)


OPENAI_BATCH = Format(
    "openai",
    _run,
    _samples,
    key=("custom_id",),
    question="custom_id",
    answers=("response.body.choices[0].message.content", "response.body.output[last].content[last].text"),
    parts=(
        *("custom_id", "response.body.choices[0].message.content", "response.body.output[last].content[last].text"),
        *("response.body.choices[0].finish_reason", "eval.model"),
    ),
)
