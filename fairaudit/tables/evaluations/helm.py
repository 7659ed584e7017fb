"""Runs of HELM: a folder with ``scenario_state.json``, whose requests are the samples, or that file itself."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.evaluations.json_text import Document, document, leading, number, part, text
from fairaudit.tables.evaluations.samples import Format, Outcome, Run, Sample, ended, fixed

__all__ = ["HELM", "STATE"]

STATE, STATISTICS, SPEC = "scenario_state.json", "per_instance_stats.json", "run_spec.json"

SEPARATE = "multiple_choice_separate"

NONE = "none"
"""The perturbation of what was asked as it stands in the data set."""


def _run(path: str) -> Run:
    asked = _adapter(path)
    if text(asked, "method").startswith(SEPARATE):
        raise InputError(
            f"{path}: by its method {shown(text(asked, 'method'))} each choice was a request of its own, so that no request holds an "
            "answer; a run with the method multiple_choice_joint does"
        )
    return Run(
        format=HELM.name,
        producer="HELM",
        model=text(asked, "model") or text(asked, "model_deployment"),
        task=_name(path),
        epochs=max(1, number(asked, "num_train_trials") or 1),
        fixed=fixed(asked),
    )


def _samples(path: str, wanted: Collection[str]) -> Iterator[Sample]:
    statistics = _statistics(path) if not wanted or "stats" in wanted else {}
    with _state(path) as read:
        for key in read.members():
            if key != "request_states":
                read.skip()
                continue
            for place in read.elements():
                row = read.value()
                if not isinstance(row, dict) or not isinstance(row.get("instance"), dict) or not isinstance(row.get("result"), dict):
                    raise InputError(f"{path}, request {place + 1}: there is no instance or no result, so this is no request of HELM")
                identity = _identity(part(row, "instance").get("id"), row, part(row, "instance"))
                more = {"answer": _answer(row), "perturbation": _perturbation(row)}
                yield Sample(
                    {**row, **more, "stats": statistics.get(identity, {})}, _outcome(row), "request {} ({})", (place + 1, identity[0])
                )
        read.end()


def _answer(row: Mapping[str, Any]) -> Any:
    """The first completion without blanks around it, or the choice that it names; nothing if it names none."""
    said = text(_completion(row), "text").strip()
    choices = row.get("output_mapping")
    return choices.get(said) if isinstance(choices, dict) else said


def _completion(row: Mapping[str, Any]) -> Mapping[str, Any]:
    return leading(part(row, "result").get("completions"))


def _outcome(row: Mapping[str, Any]) -> Outcome:
    if part(row, "result").get("success") is not True or not _completion(row):
        return "error"
    return ended(part(_completion(row), "finish_reason").get("reason"))


def _perturbation(row: Mapping[str, Any]) -> str:
    """What was changed in the question; perturbations of one name differ in what else they say."""
    change = part(row, "instance").get("perturbation")
    if not isinstance(change, dict):
        return NONE
    said = {key: value for key, value in change.items() if key not in ("name", "robustness", "fairness", "computed_on")}
    return " ".join([text(change, "name"), *(f"{key}={value}" for key, value in sorted(said.items()))])


def _identity(name: object, request: Mapping[str, Any], changed: Mapping[str, Any]) -> tuple[str, ...]:
    return (str(name), _perturbation({"instance": changed}), str(request.get("train_trial_index", 0)))


def _statistics(path: str) -> dict[tuple[str, ...], dict[str, Any]]:
    """Scores by instance, perturbation and trial, from the file that stands beside the requests."""
    _, file = _beside(_file(path))
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    if not file.exists():
        return found
    with document(str(file)) as read:
        for _ in read.elements():
            entry = read.value()
            if not isinstance(entry, dict) or not isinstance(entry.get("stats"), list):
                raise InputError(f"{file}: an entry has no list of stats, so these are no scores of HELM")
            scores = {text(part(score, "name"), "name"): score.get("mean") for score in entry["stats"] if isinstance(score, dict)}
            found[_identity(entry.get("instance_id"), entry, entry)] = scores
    return found


def _adapter(path: str) -> Mapping[str, Any]:
    with _state(path) as read:
        for key in read.members():
            if key == "adapter_spec" and read.peek() == "{":
                found: dict[str, Any] = read.value()
                return found
            read.skip()
    raise InputError(f'{path}: there is no "adapter_spec", so this is no run of HELM; name its folder, or the {STATE} in it')


def _name(path: str) -> str:
    spec, _ = _beside(_file(path))
    if not spec.exists():
        return ""
    with document(str(spec)) as read:
        for key in read.members():
            if key == "name":
                found = read.value()
                return found if isinstance(found, str) else ""
            read.skip()
    return ""


def _beside(log: Path) -> tuple[Path, Path]:
    """The files beside the requests that say what was run, and what it scored, where they are there."""
    return log.with_name(SPEC), log.with_name(STATISTICS)


def _file(path: str) -> Path:
    return Path(path, STATE) if Path(path).is_dir() else Path(path)


@contextmanager
def _state(path: str) -> Iterator[Document]:
    with document(str(_file(path))) as read:
        yield read


HELM = Format(
    "helm",
    _run,
    _samples,
    key=("instance.id", "perturbation", "train_trial_index"),
    question="instance.id",
    repetition="train_trial_index",
    single=("perturbation",),
    answers=("answer", "result.completions[0].text"),
    parts=(
        *("instance.id", "instance.split", "instance.sub_split", "instance.extra_data", "train_trial_index", "perturbation"),
        *("answer", "result.completions[0].text", "stats", "eval.model", "eval.task"),
    ),
    beside=_beside,
)
