"""What a server of a chat interface sent: refusals are known by their fields, and its own words do no harm."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.tables.evaluations.replies import explanation, fault, fault_of, refused, refused_of

JSON = "application/json"
FILTERED = {"error": {"code": "content_filter", "message": "no"}}


def test_refusals_are_known_by_their_fields() -> None:
    gateway = {"error": {"code": "400", "message": "x", "provider_specific_fields": FILTERED["error"]}}
    moderation = {"error": {"code": 403, "message": "x", "metadata": {"reasons": ["violence"], "flagged_input": "…"}}}
    for status, document in ((400, FILTERED), (400, gateway), (403, moderation), (400, [FILTERED]), (200, FILTERED)):
        body = json.dumps(document).encode()
        assert refused(status, body) and refused_of(status, document)
        assert fault(status, JSON, body) == fault_of(status, document) == ""
    for document in ({"error": {"message": "content_filter safety"}}, {"error": "content_filter"}, {"content_filter": 1}, [], None):
        assert not refused(403, json.dumps(document).encode()) and not refused_of(403, document)
    assert not refused(500, json.dumps(FILTERED).encode())
    assert not refused(400, b"content_filter")


@pytest.mark.parametrize(
    ("status", "kind", "body", "why"),
    [
        (200, JSON, b"", "empty"),
        (200, JSON, b'data: {"choices": []}', "stream of events"),
        (200, "text/event-stream", b"{}", "stream of events"),
        (200, "text/html; charset=utf-8", b"<html>", "'text/html'"),
        (200, JSON, b"\xff", "not UTF-8"),
        (200, JSON, b'{"choices"', "breaks off"),
        (200, JSON, b"[" * 100_000, "breaks off"),
        (200, JSON, b'{"choices": []}', "without choices"),
        (429, JSON, b'{"choices": [{"message": {"content": "yes"}}]}', "status 429"),
    ],
)
def test_what_is_no_answer(status: int, kind: str, body: bytes, why: str) -> None:
    assert why in fault(status, kind, body)


@pytest.mark.parametrize("status", [None, "200", True, 200.5, 503])
def test_a_log_may_state_any_status(status: object) -> None:
    assert "status" in fault_of(status, {"choices": [{"message": {}}]})
    assert not refused_of(status, FILTERED)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda some: (
            st.lists(some)
            | st.dictionaries(
                st.sampled_from(["choices", "message", "error", "code", "usage", "prompt_tokens", "completion_tokens", "total_tokens"]),
                some,
            )
        ),
    )
)
def test_whatever_comes_is_told_apart_without_a_traceback(document: Any) -> None:
    for body in (json.dumps(document).encode(), json.dumps({"choices": [{"message": {}}], "usage": document}).encode()):
        for status in (200, 400, 500):
            assert isinstance(fault(status, JSON, body), str)
        assert explanation(body).isprintable()


def test_words_of_a_server_are_escaped_and_clipped() -> None:
    assert explanation(b"<html><style>b {}</style><h1>Not  here</h1></html>") == "'Not here'"
    assert explanation(b'{"detail": "\\u001b[31m\\u202eabc"}') == "'\\x1b[31m\\u202eabc'"
    assert len(explanation(b"x" * 5000)) == 200
    assert explanation(b"") == explanation(b"{}"[:0]) == ""
