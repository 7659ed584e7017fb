"""What a server of a chat interface sent: an answer, a refusal, or a fault. They are told apart by structure, never by a word."""

from __future__ import annotations

import json
import re
from typing import Any

from fairaudit.errors import shown
from fairaudit.tables.evaluations.chat import declined, wrong
from fairaudit.tables.evaluations.choices import whole_number

__all__ = ["OK", "explanation", "fault", "fault_of", "parsed", "refused", "refused_of"]

OK = 200
MARKUP = re.compile(r"(?is)<(script|style)\b.*?(?:</\1>|\Z)|<[^<>]{0,2000}>")


def parsed(body: bytes) -> Any:
    """A JSON body, or a `ValueError` if it is not JSON in UTF-8."""
    try:
        return json.loads(body.decode("utf-8"), parse_int=whole_number)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def fault(status: int, content_type: str, body: bytes) -> str:
    """Why a reply is no answer; empty if it is one, or a refusal.

    Examples
    --------
    >>> fault(200, "text/html", b"<html>Please sign in</html>")
    "a reply of the type 'text/html', not JSON"
    >>> fault(200, "application/json", b'{"choices": [{"message": {"content": "1"}}]}')
    ''
    """
    if refused(status, body):
        return ""
    if status != OK:
        return f"status {status}"
    if not body.strip():
        return "an empty reply"
    if "event-stream" in content_type.lower() or body.lstrip().startswith((b"data:", b"event:")):
        return "a stream of events instead of one reply"
    if "json" not in content_type.lower():
        return f"a reply of the type {shown(content_type.partition(';')[0])}, not JSON"
    try:
        document = parsed(body)
    except UnicodeDecodeError:
        return "a reply that is not UTF-8"
    except ValueError:
        return "a reply that is not JSON, or breaks off"
    return fault_of(status, document)


def fault_of(status: object, document: Any) -> str:
    """The same of a reply that a log holds parsed.

    Examples
    --------
    >>> fault_of(503, {}), fault_of(200, {"choices": []})
    ('status 503', 'a reply without choices')
    """
    if refused_of(status, document):
        return ""
    return wrong(document) if status == OK else f"status {shown(status)}"


def refused(status: int, body: bytes) -> bool:
    """Whether the fields of an error say that a content filter stopped the request.

    Examples
    --------
    >>> refused(400, b'{"error": {"code": "content_filter", "message": "no"}}'), refused(403, b"<h1>Blocked for your safety</h1>")
    (True, False)
    """
    try:
        return refused_of(status, parsed(body))
    except ValueError:
        return False


def refused_of(status: object, document: Any) -> bool:
    """The same of a reply that a log holds parsed: whatever the server itself has broken down over is no refusal.

    Examples
    --------
    >>> [refused_of(status, {"error": {"code": "content_filter"}}) for status in (200, 400, 500)]
    [True, True, False]
    """
    return isinstance(status, int) and (status == OK or 400 <= status < 500) and declined(document)


def explanation(body: bytes) -> str:
    """The server's own words, escaped and clipped: the message of its error, or what its page says; empty if it says nothing.

    Examples
    --------
    >>> print(explanation(b'{"error": {"message": "The model gpt-9 does not exist"}}'))
    'The model gpt-9 does not exist'
    """
    try:
        found = parsed(body)
    except ValueError:
        found = None
    found = found[0] if isinstance(found, list) and found else found
    while isinstance(found, dict):
        found = next((found[name] for name in ("error", "message", "detail") if found.get(name)), None)
    text = found if isinstance(found, str) else MARKUP.sub(" ", body[:100_000].decode("utf-8", "replace"))
    said = " ".join(text.split())
    return shown(said, 200) if said else ""
