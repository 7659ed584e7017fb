"""Replies of chat completions, as logs keep them and as servers send them: what is said in them, and what is no answer."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["Message", "declined", "message", "wrong"]

FILTERED = frozenset(
    {"contentfilter", "contentpolicyviolation", "responsibleaipolicyviolation", "datainspectionfailed", "moderationblocked"}
)

ENDED_BY_FILTER = ("content_filter", "refusal", "safety")

TEXT = ("text", "output_text")


@dataclass(frozen=True)
class Message:
    """What the first choice of a reply says.

    Attributes
    ----------
    content : str
        Its text, of parts put together.
    calls : tuple
        Arguments of the tools that it calls.
    refusal : str
        Why it was declined, by a field of its own or by how it ended; empty if it was not.
    ended : str
        The reason for which it ended.
    """

    content: str
    calls: tuple[Any, ...]
    refusal: str
    ended: str


def wrong(document: Any) -> str:
    """Why a parsed reply is no chat completion; empty if it is one.

    Examples
    --------
    >>> wrong({"choices": [{"message": {"content": "yes"}}]}), wrong({"error": {"message": "no quota"}})
    ('', 'an error with status 200')
    """
    if not isinstance(document, dict):
        return "a reply that is no JSON object"
    choices = document.get("choices")
    if not isinstance(choices, list) or not choices:
        return "an error with status 200" if document.get("error") else "a reply without choices"
    if not isinstance(choices[0], dict) or not isinstance(choices[0].get("message"), dict):
        return "a choice without a message"
    return "an error in place of a choice" if choices[0].get("error") or choices[0].get("finish_reason") == "error" else ""


def message(document: Mapping[str, Any]) -> Message | None:
    """Read the first choice of a reply that is not `wrong`; None if it has parts or calls of a tool that cannot be read.

    Examples
    --------
    >>> message({"choices": [{"message": {"content": [{"type": "text", "text": "y"}, {"type": "text", "text": "es"}]}}]}).content
    'yes'
    """
    choice = document["choices"][0]
    given, ended = choice["message"], str(choice.get("finish_reason"))
    said = given.get("content")
    parts = said if isinstance(said, list) else ()
    try:
        content = "".join([part["text"] for part in parts if part.get("type") in TEXT] if parts else [said or ""])
        calls = tuple([call["function"]["arguments"] for call in given.get("tool_calls") or ()])
        refusals = [given.get("refusal"), *[part.get("refusal") for part in parts]]
    except (KeyError, TypeError, AttributeError):
        return None
    by_filter = "content filter" if ended.lower() in ENDED_BY_FILTER else ""
    return Message(content, calls, str(next(filter(None, refusals), by_filter)), ended)


def declined(document: Any) -> bool:
    """Whether the fields of an error say that a content filter stopped the request.

    Examples
    --------
    >>> declined({"error": {"code": "content_filter", "message": "no"}}), declined({"error": {"code": "invalid_api_key"}})
    (True, False)
    """
    first = document[0] if isinstance(document, list) and document else document
    return isinstance(first, dict) and not first.get("choices") and _filtered(first.get("error"))


def _filtered(entry: Any) -> bool:
    if not isinstance(entry, dict):
        return False
    codes = {re.sub("[^a-z]", "", str(entry.get(name)).lower()) for name in ("code", "type")}
    return bool(codes & FILTERED) or entry.get("filtered") is True or "flagged_input" in entry or any(map(_filtered, entry.values()))
