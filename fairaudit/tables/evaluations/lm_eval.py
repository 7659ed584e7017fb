"""Logs of lm-evaluation-harness: ``samples_TASK_DATE.jsonl``, a line for each question and filter."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from fairaudit.tables.evaluations.json_text import LINE, document, first_row, having, json_lines, part, text
from fairaudit.tables.evaluations.samples import Format, Run, Sample, fixed

__all__ = ["KEYS", "LM_EVAL", "RESULTS"]

KEYS = ("doc_id", "resps", "filtered_resps")

RESULTS = frozenset(("results", "configs", "n-samples", "higher_is_better"))

NAME = re.compile(r"samples_(?P<task>.+)_(?P<date>\d{4}-\d\d-\d\dT[\d.:-]+)\.jsonl(?:\.gz)?")

SEED = 1234
"""The harness's own, where a model behind an interface is given none."""

ABOVE = ("config", "configs", "lm_eval_version", "model_name", "n-samples")


def _beside(log: Path) -> tuple[Path, ...]:
    """The file of results beside samples, where their name says when they were taken."""
    named = NAME.fullmatch(log.name)
    return (log.with_name(f"results_{named['date']}.json"),) if named else ()


def _run(path: str) -> Run:
    named = NAME.fullmatch(Path(path).name)
    results = _results(_beside(Path(path))[0]) if named else {}
    task = named["task"] if named else ""
    questions = part(part(results, "n-samples"), task).get("effective")
    filters = part(part(results, "configs"), task).get("filter_list")
    version = text(results, "lm_eval_version")
    model = part(results, "config")
    first = first_row(path)
    return Run(
        format=LM_EVAL.name,
        producer=f"lm-eval {version}" if version else "lm-eval",
        model=text(results, "model_name") or text(model, "model"),
        task=task,
        expected=questions * max(1, len(filters) if isinstance(filters, list) else 1) if isinstance(questions, int) else None,
        fixed=fixed({"seed": _seed(model), **part(part(part(first, "arguments"), "gen_args_0"), "arg_1"), **part(model, "gen_kwargs")}),
    )


def _seed(model: Mapping[str, Any]) -> int | None:
    """Give the seed that is sent with each question: models behind an interface have one unless they are given another."""
    given = model.get("model_args")
    if isinstance(given, str):
        given = dict(pair.partition("=")[::2] for pair in given.split(","))
    seed = given.get("seed") if isinstance(given, dict) else None
    if seed is None:
        return SEED if text(model, "model").endswith("completions") else None
    return int(seed) if isinstance(seed, (int, str)) and str(seed).isdecimal() else None


def _results(path: Path) -> Mapping[str, Any]:
    """Read the file of results that stands beside the samples, if there is one."""
    if not path.exists():
        return {}
    found: dict[str, Any] = {}
    with document(str(path)) as read:
        for key in read.members():
            if key in ABOVE:
                found[key] = read.value()
            else:
                read.skip()
    return found


def _samples(path: str, _: Collection[str]) -> Iterator[Sample]:
    for line, row in json_lines(path):
        having(row, KEYS, path, line, "a sample of lm-evaluation-harness")
        yield Sample(row, "read", LINE, (line,))


LM_EVAL = Format(
    "lm-eval",
    _run,
    _samples,
    key=("doc_id", "filter"),
    question="doc_id",
    single=("filter",),
    answers=("argmax(filtered_resps[*][0])", "filtered_resps[0]"),
    parts=("doc_id", "doc", "filter", "filtered_resps", "acc", "acc_norm", "exact_match", "eval.model", "eval.task"),
    beside=_beside,
)
