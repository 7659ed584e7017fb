"""What no attestation holds, wherever it stands."""

from __future__ import annotations

import json
from typing import Any

import pytest

from fairaudit.attestations.strict import DIGITS, LONGEST, MAX_BYTES, check_data, check_text, decoded, object_of
from fairaudit.errors import InputError


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        (b'{"a": 1, "b": {"c": 1, "c": 1}}', "the key 'c' twice"),
        (b"[0.5]", "0.5 is not whole"),
        (b"[1e3]", "1e3 is not whole"),
        (b"[NaN]", "NaN is not whole"),
        (b"[-0]", "-0 is not accepted"),
        (b"[1" + b"0" * DIGITS + b"]", "whole numbers of up to 18 digits"),
        (b'"\xff"', "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b" " * (MAX_BYTES + 1), "longer than 16777216 bytes"),
    ],
)
def test_json_that_could_be_read_in_two_ways_is_refused(raw: bytes, said: str) -> None:
    with pytest.raises(InputError, match=said):
        decoded(raw)


def test_numbers_are_left_to_whoever_looks_at_them() -> None:
    assert decoded(b"[0.5, 1, %d]" % 10**DIGITS, numbers=False) == [0.5, 1, 10**DIGITS]
    assert decoded(b"[%d]" % (10**DIGITS - 1)) == [10**DIGITS - 1]
    with pytest.raises(InputError, match="twice"):
        decoded(b'{"a": 0.5, "a": 0.5}', numbers=False)


@pytest.mark.parametrize("text", [None, "a\nb", "\x1b[0m", "\ud800", "x" * (LONGEST + 1)])
def test_a_text_is_short_and_on_one_line(text: Any) -> None:
    assert check_text("x" * LONGEST, "it") and check_text("\u202e é", "it")
    with pytest.raises(InputError, match="it"):
        check_text(text, "it")
    with pytest.raises(InputError, match=r"it\['a'\]\[0\]"):
        check_data({"a": [text]}, "it")


def test_data_is_nested_up_to_a_depth() -> None:
    check_data(json.loads("[" * 12 + "]" * 12), "it")
    with pytest.raises(InputError, match="too deeply"):
        check_data(json.loads("[" * 14 + "]" * 14), "it")


def test_an_object_has_its_keys_and_no_others() -> None:
    assert object_of({"a": 1, "b": 2}, "it", ("a",), ("b",)) == {"a": 1, "b": 2}
    for value, said in (([], "an object is accepted"), ({"b": 1}, "lacks the key 'a'"), ({"a": 1, "c": 1}, "unknown key 'c'")):
        with pytest.raises(InputError, match=said):
            object_of(value, "it", ("a",), ("b",))
