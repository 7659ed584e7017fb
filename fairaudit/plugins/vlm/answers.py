"""What an answer says: a choice, or one of the ways in which it is none. Reading never changes what the journal holds.

Choices in words are read as in logs of evaluations (docs/evaluations.md, "Choices in words"); here is what a server sends around them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, Final, Literal

from fairaudit.errors import shown
from fairaudit.exact.rationals import exact
from fairaudit.plugins.vlm.experiment import Experiment
from fairaudit.plugins.vlm.journal import Answer
from fairaudit.tables.evaluations.chat import message
from fairaudit.tables.evaluations.choices import Asked, bare, objects_in, read_choice
from fairaudit.tables.evaluations.replies import explanation, fault, parsed, refused

__all__ = ["FAULT", "OPEN", "UNKNOWN", "UNREADABLE", "Reading", "answer_schema", "read_answer", "read_kept", "sampling_note"]

UNREADABLE = "unreadable"
FAULT: Final = "fault"
OPEN: Final = "open"
UNKNOWN = (UNREADABLE, FAULT, OPEN)
Kind = Literal["choice", "probabilities", "malformed", "refused", "contradictory", "copied", "fault", "open"]
TOOLS = (
    "choice", "choose", "answer", "submit", "decide", "decision", "select", "respond", "submit_choice", "submit_answer", "final_answer",
)  # fmt: skip
WHOLE = ("none", "stop", "tool_calls", "eos", "eos_token", "end_turn")  # how an answer ends that is whole
CUT = ("length", "max_tokens", "model_length")  # and one that was cut off
FULL = {"temperature": (1,), "top_k": (0, -1), "top_p": (1,), "min_p": (0,)}


@dataclass(frozen=True)
class Reading:
    """An answer, read."""

    kind: Kind  # what it is; ``copied`` is the example of the prompt, word for word, and ``fault`` no answer of the model at all
    decision: str  # the option that was chosen, or ``unreadable``, ``fault`` or ``open`` (nothing came yet)
    reason: str  # the reason that the model stated, or why the answer could not be read; of probabilities, where those of no option lie
    probabilities: tuple[Fraction, ...] | None = None  # first-token probabilities of the options by slot; what they lack to 1 is unreadable


def read_answer(experiment: Experiment, status: int, content_type: str, body: bytes) -> Reading:
    """Read a raw answer; the status is 0 for embedded decision makers, whose body is the text of the answer itself.

    What cannot be read is ``malformed``, a server or model that declines is ``refused``, and an answer that chooses none or several is
    ``contradictory``.
    """
    if status == 0:
        return _content(experiment, body.decode("utf-8", "replace"), (), whole=True)
    if refused(status, body):
        return _none("refused", explanation(body))
    wrong = fault(status, content_type, body)
    if wrong:
        return _none("fault", wrong)
    document = parsed(body)
    said = message(document)
    if said is None:
        return _none("malformed", "the message has parts or calls of a tool that cannot be read")
    if said.refusal:
        return _none("refused", said.refusal)
    given, ended = document["choices"][0], said.ended.casefold()
    calls = given["message"].get("tool_calls") or ()
    if ended not in (*WHOLE, *CUT):
        return _none("malformed", f"the answer ended by {shown(ended, 40)}")
    if experiment.answer == "logprobs":
        return _logprobs(experiment, given)
    if given["message"].get("function_call") or any(call["function"].get("name") not in TOOLS for call in calls):
        return _none("malformed", "a tool was called whose name is none of an answer's")
    return _content(experiment, said.content, said.calls, whole=ended in WHOLE)


def read_kept(experiment: Experiment, answer: Answer) -> Reading:
    """Read what a journal holds of a draw."""
    if answer.state == OPEN:
        return _none(OPEN, "")
    if answer.state == FAULT:  # whatever the part of it that was kept looks like
        return _none(FAULT, fault(answer.status, answer.content_type, answer.body) or "a reply that is not kept whole")
    return read_answer(experiment, answer.status, answer.content_type, answer.body)


def answer_schema(experiment: Experiment) -> dict[str, Any]:
    """Lay out the JSON schema of an answer; with ``kind = "choice"`` it has one field, so that no answer contradicts itself."""
    properties: dict[str, Any] = {"choice": {"type": "string", "enum": list(experiment.options)}}
    if experiment.answer == "json":
        properties = {option: {"type": "string", "enum": list(experiment.values)} for option in experiment.options}
        properties["reason"] = {"type": "string"}
    return {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def sampling_note(request: Mapping[str, Any]) -> str:
    """Say by how much the answers to a request are not draws of the model's own law, as far as its parameters say so."""
    set_, open_ = [name for name in FULL if name in request], [name for name in FULL if name not in request]
    shaped = [f"{name} = {request[name]}" for name in set_ if request[name] not in FULL[name]]
    said = [f"{', '.join(shaped)} reshaped or cut the model's probabilities"] if shaped else []
    if open_:
        said.append(
            f"{', '.join(open_)} {'was' if len(open_) == 1 else 'were'} left to the server, whose defaults may cut off rare answers "
            "(llama.cpp: top_k 40, top_p 0.95, min_p 0.05)"
        )
    return f"Answers are draws of the model as it was sampled: {'; '.join(said)}." if said else ""


def _content(experiment: Experiment, text: str, calls: Sequence[Any], *, whole: bool) -> Reading:
    read = read_choice(text, _asked(experiment), calls=calls, cut=not whole)
    return Reading("choice", read.option, read.reason) if read.kind == "choice" else _none(read.kind, read.reason)


def _asked(experiment: Experiment) -> Asked:
    """What an answer may look like."""
    form, marks = experiment.answer, tuple(map(exact, experiment.values))
    fields = ("choice",) * (form == "choice")
    return Asked(experiment.options, fields, marks * (form == "json"), form == "token", _examples(experiment.first_prompts))


def _logprobs(experiment: Experiment, choice: Any) -> Reading:
    try:
        first = choice["logprobs"]["content"][0]
        entries = list(first["top_logprobs"])
        entries += [first] if first["token"] not in [entry["token"] for entry in entries] else []
        listed = [(entry["token"], entry["logprob"]) for entry in entries]
    except (KeyError, IndexError, TypeError, ValueError):
        return _none("malformed", "the answer has no log-probabilities of its first token")
    if len(dict(listed)) < len(listed) or any(type(value) not in (int, float) or not value <= 1e-6 for _, value in listed):
        return _none("malformed", "a log-probability is no number that is at most 0, or a token is there twice")
    mass = dict.fromkeys(experiment.options, Fraction(0))
    outside = []
    for token, value in listed:
        share = Fraction(min(1.0, math.exp(value)))
        option = str(token).strip()
        if option in mass and not any(o != option and o.startswith(option) for o in mass):
            mass[option] += share
        elif share >= Fraction(1, 100):
            begun = [o for o in experiment.options if bare(o).startswith(bare(str(token)) or "\n") and o != option]
            outside.append(f"{float(share):.2f} on {shown(token)}{', where ' + begun[0] + ' begins' if begun else ''}")
    total = sum(mass.values())
    if total > Fraction(101, 100):
        return _none("malformed", "the probabilities of the first token add up to more than 1")
    scale = max(Fraction(1), total)
    said = f"{float(1 - total / scale):.2f} lies outside the options{': ' if outside else ''}{'; '.join(outside[:5])}"
    return Reading("probabilities", UNREADABLE, said, tuple(value / scale for value in mass.values()))


@lru_cache
def _examples(prompts: tuple[str, ...]) -> tuple[Any, ...]:
    """JSON objects in prompts."""
    return tuple(found for prompt in prompts for found in objects_in(prompt))


def _none(kind: Kind, reason: str) -> Reading:
    return Reading(kind, kind if kind in UNKNOWN else UNREADABLE, reason)
