"""JSON read piece by piece agrees with the parser of the standard library, wherever the pieces end."""

from __future__ import annotations

import gzip
import io
import json
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.tables.evaluations import json_text
from fairaudit.tables.evaluations.json_text import Document, document, only, said

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.decimals(allow_nan=False, allow_infinity=False, places=3) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=4),
    max_leaves=12,
)


def reader(data: bytes, size: int) -> Document:
    stream = io.BytesIO(data)
    return Document("a.json", lambda _: stream.read(size))


def whole(read: Document, deep: int) -> Any:
    """Take a value by its members and elements, so many levels deep."""
    kind = read.peek()
    if not deep or kind not in ("{", "["):
        return read.value()
    if kind == "{":
        return {key: whole(read, deep - 1) for key in read.members()}
    return [whole(read, deep - 1) for _ in read.elements()]


def taken(read: Document) -> list[Any]:
    found = [read.value() for _ in read.members()]
    read.end()
    return found


def dumped(value: object) -> str:
    return json.dumps(value, default=lambda number: float(number), ensure_ascii=False).encode("utf-8", "replace").decode()


@given(VALUES, st.integers(1, 9), st.integers(0, 3), st.sampled_from((None, 1)))
def test_pieces_of_any_size_give_what_the_parser_gives(value: object, size: int, deep: int, indent: int | None) -> None:
    data = json.dumps(value, default=float, indent=indent).encode()
    read = reader(data, size)
    assert whole(read, deep) == json.loads(data, parse_float=Decimal)
    read.end()
    read = reader(data + b" 1", size)
    read.skip()
    assert read.peek() == "1"


@given(st.dictionaries(st.text(max_size=3), VALUES, min_size=1, max_size=3), st.integers(1, 9), st.integers(0, 3), st.data())
def test_what_is_cut_is_refused(value: object, size: int, deep: int, data: st.DataObject) -> None:
    text = dumped(value).encode()
    read = reader(text[: data.draw(st.integers(0, len(text) - 1))], size)
    with pytest.raises(InputError, match=r"a\.json: "):
        whole(read, deep)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"a": 1,}', "character 9: a name in quotes was expected, not '}'"),
        ('{"a" 1}', "character 6: : was expected, not '1'"),
        ('{"a": 1 "b": 2}', "character 9: , or } was expected, not '\"'"),
        ('{"a": 1, "a": 2}', "character 12: the key 'a' stands twice in an object"),
        ('{"b": {"a": 1, "a": 2}}', "character 7: the key 'a' stands twice in an object"),
        ('{"a": 1}}', "character 9: the end of the file was expected"),
        ('{"a": nope}', "character 7: expecting value"),
        ('{"a": "\n"}', "character 8: invalid control character"),
        ("[1]", "character 1: { was expected, not '\\['"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(text: str, words: str) -> None:
    for size in (1, 3, 100):
        with pytest.raises(InputError, match=rf"a\.json: no JSON at {words}"):
            taken(reader(text.encode(), size))


def test_a_fault_is_found_without_reading_on() -> None:
    asked = 0

    def endless(size: int) -> bytes:
        nonlocal asked
        asked += size
        return b"[1 2" + b" " * (size - 4)

    with pytest.raises(InputError, match="character 4"):
        Document("a.json", endless).value()
    assert asked == json_text.PIECE


def test_one_value_at_a_time_is_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(json_text, "PIECE", 64)
    monkeypatch.setattr(json_text, "LARGEST", 1000)
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"samples": [{"n": n, "text": "x" * 100} for n in range(500)], "long": "x" * 9000}))
    with document(str(path)) as read:
        keys = read.members()
        assert next(keys) == "samples"
        assert [read.value()["n"] for _ in read.elements()] == list(range(500))
        assert next(keys) == "long"
        with pytest.raises(InputError, match="a single value has more than 1,000 characters"):
            read.value()


def test_what_is_packed_is_read_and_may_be_cut(tmp_path: Path) -> None:
    path = tmp_path / "a.json.gz"
    data = gzip.compress(b'\xef\xbb\xbf{"a": 1.10, "b": "\xe2\x80\xa8"}')
    path.write_bytes(data)
    with document(str(path)) as read:
        assert read.value() == {"a": Decimal("1.10"), "b": "\u2028"}
    path.write_bytes(data[:-12])
    with pytest.raises(InputError, match=r"a\.json\.gz.*cut"), document(str(path)) as read:
        read.value()


def test_what_keys_say_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text('{"model": "a", "in": {"model" : "b\\"c"}, "other": "x"}\n{"model": null, "models": "d"}\n')
    assert said(str(path), "model", "other", "absent") == {"model": {"a", 'b"c'}, "other": {"x"}, "absent": set()}
    assert only({"a"}) == "a"
    assert only({"a", "b"}) == only(set()) == ""
