"""What an answer says: a choice, or one of the ways in which it is none. Reading never changes what the journal holds."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from fairaudit.errors import InputError
from fairaudit.exact.rationals import rational
from fairaudit.plugins.vlm.experiment import Experiment

__all__ = ["UNREADABLE", "Reading", "read_answer", "usage"]

UNREADABLE = "unreadable"
Kind = Literal["choice", "probabilities", "malformed", "refused", "contradictory"]
FENCE = re.compile(r"\A\s*```[a-zA-Z]*\s*\n(.*?)\n?\s*```\s*\Z", re.DOTALL)


@dataclass(frozen=True)
class Reading:
    """An answer, read.

    Attributes
    ----------
    kind : {"choice", "probabilities", "malformed", "refused", "contradictory"}
        What it is.
    decision : str
        The option that was chosen, or ``unreadable``.
    reason : str
        The reason that the model stated, or why the answer could not be read.
    probabilities : tuple of Fraction or None
        Of the options by slot, for first-token probabilities; what they lack to 1 is unreadable.
    """

    kind: Kind
    decision: str
    reason: str
    probabilities: tuple[Fraction, ...] | None = None


class _DuplicateKeyError(ValueError):
    """A key that occurs twice."""


def read_answer(experiment: Experiment, status: int, content_type: str, body: bytes) -> Reading:
    """Read a raw answer.

    Parameters
    ----------
    experiment : Experiment
        Which options there are, and how a choice is marked.
    status : int
        HTTP status; 0 for embedded decision makers, whose body is the text of the answer itself.
    content_type : str
        As the server said.
    body : bytes
        The answer as it came.

    Returns
    -------
    Reading
        Always one; what cannot be read is ``malformed``, a server or model that declines is ``refused``, and an answer that chooses none
        or several is ``contradictory``.
    """
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError:
        return _none("malformed", "the answer is not UTF-8")
    if status == 0:
        return _content(experiment, text)
    if status != 200:
        return _none("refused", _error_text(text))
    if "json" not in content_type.lower():
        return _none("malformed", f"the content type is {content_type!r}, not JSON")
    try:
        choice = _parse(text)["choices"][0]
        message = choice["message"]
        refusal, content = message.get("refusal"), message.get("content")
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError) as error:
        return _none("malformed", f"the answer is not a chat completion: {_short(error)}")
    if refusal or choice.get("finish_reason") == "content_filter":
        return _none("refused", str(refusal or "content filter"))
    if experiment.answer == "logprobs":
        return _logprobs(experiment, choice)
    if not isinstance(content, str):
        return _none("malformed", "the message has no text")
    return _content(experiment, content)


def usage(status: int, body: bytes) -> tuple[int, int] | None:
    """Tokens in and out as a server counted them, or None."""
    if status != 200:
        return None
    try:
        counted = json.loads(body)["usage"]
        found = int(counted["prompt_tokens"]), int(counted["completion_tokens"])
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return found if min(found) >= 0 else None


def _content(experiment: Experiment, text: str) -> Reading:
    if experiment.answer == "token":
        word = text.strip().strip(".\"'")
        slots = [option for i, option in enumerate(experiment.options, 1) if word in (option, str(i))]
        return Reading("choice", slots[0], "") if len(slots) == 1 else _none("malformed", "the answer is not a single option")
    fenced = FENCE.match(text)
    try:
        given = _parse(fenced.group(1) if fenced else text)
    except _DuplicateKeyError as error:
        return _none("contradictory", str(error))
    except (ValueError, RecursionError) as error:
        return _none("malformed", f"the answer is not JSON: {_short(error)}")
    if not isinstance(given, dict):
        return _none("malformed", "the answer is not a JSON object")
    reason = given.get("reason")
    said = reason if isinstance(reason, str) else ""
    values = []
    for option in experiment.options:
        if option not in given:
            return _none("malformed", f"{option} is missing")
        try:
            values.append(Fraction(*rational(given[option])))
        except InputError:
            return _none("malformed", f"{option} has no number")
    chosen, *others = experiment.marks
    picked = [option for option, value in zip(experiment.options, values, strict=True) if value == chosen]
    if len(picked) != 1 or any(value not in others for value in values if value != chosen):
        return _none("contradictory", said)
    return Reading("choice", picked[0], said)


def _logprobs(experiment: Experiment, choice: Any) -> Reading:
    try:
        first = choice["logprobs"]["content"][0]
        listed = {str(entry["token"]): float(entry["logprob"]) for entry in [*first["top_logprobs"], first]}
    except (KeyError, IndexError, TypeError, ValueError):
        return _none("malformed", "the answer has no log-probabilities of its first token")
    if any(math.isnan(value) or value > 1e-6 for value in listed.values()):
        return _none("malformed", "a log-probability is not at most 0")
    mass = [Fraction(0)] * len(experiment.options)
    for token, value in listed.items():
        for i, option in enumerate(experiment.options):
            if token.strip() in (option, str(i + 1)):
                mass[i] += Fraction(min(1.0, math.exp(value)))
    total = sum(mass)
    if total > Fraction(101, 100):
        return _none("malformed", "the probabilities of the first token add up to more than 1")
    if total > 1:
        mass = [value / total for value in mass]
    return Reading("probabilities", UNREADABLE, "", tuple(mass))


def _parse(text: str) -> Any:
    def pairs(found: Sequence[tuple[str, Any]]) -> dict[str, Any]:
        keys = [key for key, _ in found]
        if len(set(keys)) < len(keys):
            raise _DuplicateKeyError(f"the key {next(k for k in keys if keys.count(k) > 1)!r} occurs twice")
        return dict(found)

    return json.loads(text, object_pairs_hook=pairs)


def _none(kind: Kind, reason: str) -> Reading:
    return Reading(kind, UNREADABLE, reason)


def _error_text(text: str) -> str:
    try:
        return str(json.loads(text)["error"]["message"])
    except (ValueError, KeyError, TypeError, RecursionError):
        return text[:200]


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:120]
