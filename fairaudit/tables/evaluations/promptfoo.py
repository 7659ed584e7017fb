"""Results of promptfoo: ``-o results.json``, or ``.jsonl`` with a result on each line."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from fairaudit.tables.evaluations.json_text import LINE, document, first_keys, having, json_lines, number, objects, only, part, text
from fairaudit.tables.evaluations.samples import Format, Outcome, Run, Sample, ended

__all__ = ["KEYS", "PROMPTFOO", "WHOLE"]

KEYS = ("promptIdx", "testIdx", "testCase", "vars")

WHOLE = ("evalId", "results")

FAILED = 2
"""What `failureReason` is where no answer came; an answer that did not pass has another."""


def _run(path: str) -> Run:
    if not _whole(path):
        return Run(format=PROMPTFOO.name, producer="promptfoo")
    version, expected = "", None
    prompts: list[tuple[str, str]] = []
    with document(path) as read:
        for key in read.members():
            if key == "metadata":
                version = text(_object(read.value()), "promptfooVersion")
            elif key == "results" and read.peek() == "{":
                for inner in read.members():
                    if inner == "stats":
                        counts = _object(read.value())
                        said = [number(counts, name) for name in ("successes", "failures", "errors")]
                        expected = None if None in said else sum(each or 0 for each in said)
                    elif inner == "prompts":
                        prompts = [(text(each, "raw"), text(each, "provider")) for each in objects(read.value())]
                    else:
                        read.skip()
            else:
                read.skip()
        read.end()
    return Run(
        format=PROMPTFOO.name,
        producer=f"promptfoo {version}".strip(),
        model=only({provider for _, provider in prompts}) if len(set(prompts)) == len(prompts) else "",
        expected=expected,
    )


def _samples(path: str, _: Collection[str]) -> Iterator[Sample]:
    if not _whole(path):
        for line, row in json_lines(path):
            yield _sample(row, path, line)
        return
    with document(path) as read:
        for key in read.members():
            if key != "results" or read.peek() != "{":
                read.skip()
                continue
            for inner in read.members():
                if inner != "results":
                    read.skip()
                    continue
                for place in read.elements():
                    yield _sample(_object(read.value()), path, place + 1, "result {}")
        read.end()


def _sample(row: Mapping[str, Any], path: str, place: int, form: str = LINE) -> Sample:
    having(row, KEYS, path, place, "a result of promptfoo", form)
    return Sample(row, _outcome(row), form, (place,))


def _outcome(row: Mapping[str, Any]) -> Outcome:
    response = part(row, "response")
    if row.get("failureReason") == FAILED or response.get("error") is not None or not response:
        return "error"
    if response.get("isRefusal") is True:
        return "refused"
    return ended(response.get("finishReason"))


def _whole(path: str) -> bool:
    """Whether a file holds all results in one object."""
    return set(WHOLE) <= first_keys(path, [frozenset(WHOLE)])[0].keys()


def _object(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


PROMPTFOO = Format(
    "promptfoo",
    _run,
    _samples,
    key=("promptIdx", "testIdx"),
    apart=("promptIdx",),
    answers=("response.output",),
    parts=(
        "response.output",
        "response.isRefusal",
        "vars",
        "metadata",
        "provider",
        "promptIdx",
        "testIdx",
        "success",
        "score",
        "eval.model",
    ),
)
