"""Which format a log of an evaluation has, from its content."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError
from fairaudit.tables.evaluations import every_eval_ever, helm, inspect_logs, lm_eval, openai_batch, openai_evals, promptfoo
from fairaudit.tables.evaluations.json_text import first_keys, part
from fairaudit.tables.evaluations.samples import Format

__all__ = ["FORMATS", "could_be", "detect", "files_of_log", "format_of"]

FORMATS = {
    known.name: known
    for known in (
        inspect_logs.INSPECT,
        lm_eval.LM_EVAL,
        every_eval_ever.EVERY_EVAL_EVER,
        helm.HELM,
        promptfoo.PROMPTFOO,
        openai_batch.OPENAI_BATCH,
        openai_evals.OPENAI_EVALS,
    )
}
"""The formats by their names."""

KEYS: tuple[tuple[frozenset[str], Format], ...] = (
    (frozenset(("version", "status", "eval")), inspect_logs.INSPECT),
    (frozenset(lm_eval.KEYS), lm_eval.LM_EVAL),
    (frozenset(every_eval_ever.KEYS), every_eval_ever.EVERY_EVAL_EVER),
    (frozenset(("adapter_spec", "request_states")), helm.HELM),
    (frozenset(promptfoo.WHOLE), promptfoo.PROMPTFOO),
    (frozenset(promptfoo.KEYS), promptfoo.PROMPTFOO),
    (frozenset(openai_batch.KEYS), openai_batch.OPENAI_BATCH),
    (frozenset(openai_evals.KEYS), openai_evals.OPENAI_EVALS),
)


def detect(path: str) -> Format | None:
    """Say which format a file or folder has; None if it is no log of an evaluation, such as plain JSON lines.

    Raises
    ------
    InputError
        If it cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "samples.jsonl"
    ...     _ = path.write_text('{"doc_id": 0, "doc": {}, "resps": [["yes"]], "filtered_resps": ["yes"]}')
    ...     found = detect(str(path))
    >>> found.name
    'lm-eval'
    """
    if Path(path).is_dir():
        return helm.HELM if Path(path, helm.STATE).is_file() else None
    if inspect_logs.is_zip(path):
        return inspect_logs.INSPECT if inspect_logs.is_archive(path) else None
    first, listed = first_keys(path, [needed for needed, _ in KEYS])
    if first.keys() >= lm_eval.RESULTS:
        raise InputError(f"{path}: these are the results of a run of lm-evaluation-harness; its samples stand beside, in samples_*.jsonl")
    found = format_of(first)
    if listed and found is not None:
        raise InputError(
            f"{path}: what this list holds looks like a log of {found.name}, which is read from lines or a file of its own and not from a "
            "list; write each element on a line"
        )
    return found


def could_be(path: str, named: str) -> bool:
    """Whether the first object of a file has the keys of a format, whatever other one it has the keys of, too.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "samples.jsonl"
    ...     _ = path.write_text('{"doc_id": 0, "doc": {}, "resps": [["yes"]], "filtered_resps": ["yes"]}')
    ...     could_be(str(path), "lm-eval"), could_be(str(path), "helm")
    (True, False)
    """
    if Path(path).is_dir() or inspect_logs.is_zip(path):
        return False
    first, _ = first_keys(path, [needed for needed, _ in KEYS])
    return any(needed <= first.keys() for needed, known in KEYS if known.name == named)


def format_of(first: Mapping[str, Any]) -> Format | None:
    """Say which format the first object of a file has, None if none.

    Examples
    --------
    >>> format_of({"custom_id": "a", "response": {"body": {}}}).name, format_of({"custom_id": "a", "response": "yes"})
    ('openai', None)
    """
    if {"run_id", "eval_name"} <= part(first, "spec").keys():
        return openai_evals.OPENAI_EVALS
    found = next((found for needed, found in KEYS if needed <= first.keys()), None)
    plain = found is openai_batch.OPENAI_BATCH and not isinstance(first["response"], (dict, type(None)))
    return None if plain else found


def files_of_log(path: str) -> list[str]:
    """The file of a log, and those that stand beside it and are read with it; none of what is no log in JSON.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for name in ("scenario_state.json", "run_spec.json"):
    ...         _ = Path(folder, name).write_text('{"adapter_spec": {}, "request_states": []}')
    ...     found = files_of_log(folder)
    >>> [Path(name).name for name in found]
    ['scenario_state.json', 'run_spec.json']
    """
    try:
        known = detect(path)
    except (InputError, OSError, ValueError):  # of which the reader says what is wrong
        return []
    if known is None:
        return []
    log = Path(path, helm.STATE) if Path(path).is_dir() else Path(path)
    return [str(log), *(str(file) for file in known.beside(log) if file.is_file())]
