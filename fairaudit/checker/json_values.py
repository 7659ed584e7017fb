"""JSON and its types: values of the wrong type are refused where they are read."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from .text import FormatError, malformed, shown

Labels = tuple[str, ...]


@dataclass(frozen=True)
class _OtherNumber:
    """A JSON number that the format has no place for; the check of the type where it stands rejects it."""

    token: str


def _number(token: str) -> object:
    return int(token) if len(token) <= 18 and token != "-0" else _OtherNumber(token)


def _members(pairs: list[tuple[str, object]]) -> dict[str, object]:
    members = dict(pairs)
    if len(members) != len(pairs):
        [(repeated, _)] = Counter(key for key, _ in pairs).most_common(1)
        raise FormatError(f"an object repeats the key {shown(repeated)}")
    return members


_DECODER = json.JSONDecoder(object_pairs_hook=_members, parse_int=_number, parse_float=_OtherNumber, parse_constant=_OtherNumber)


def decoded(raw: bytes, where: str) -> object:
    """Decode JSON; an object that repeats a key is refused, and of numbers only short integers are taken."""
    try:
        return _DECODER.decode(raw.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise malformed(where, f"is not UTF-8 at byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise malformed(where, f"is not JSON: {error}") from None
    except RecursionError:
        raise malformed(where, "is nested too deeply") from None
    except FormatError as error:
        raise malformed(where, f"is not acceptable: {error}") from None


_OPENING, _CLOSING = b'<script type="application/json" id="certificate">', b"</script>"


def without_page(raw: bytes) -> bytes:
    """Take the certificate out of the page of a report; JSON is given back as it is."""
    if raw.startswith(b"%PDF-"):
        raise malformed("the file", "is a PDF, which people read; check the certificate that is attached to it, or the page")
    start = raw.lstrip(b" \t\r\n")[:9].lower()
    if start.startswith(b"{"):
        return raw
    if start != b"<!doctype":
        raise malformed(
            "the file", f"{'holds something else' if start else 'is empty'}; give the .json that fairaudit wrote, or its page (.html)"
        )
    _, opening, rest = raw.partition(_OPENING)
    held, closing, after = rest.partition(_CLOSING)
    if not opening or not closing or _OPENING in after:
        raise malformed(
            "the page",
            "does not hold one certificate, as the page of a report does; check the certificate itself, such as the certificate.json "
            "beside a page of `fairaudit publish`",
        )
    return held


def other_kind(document: object) -> str:
    """Say what a document is, where it is another one of those that fairaudit writes than the one that is due; nothing where it is none."""
    if not isinstance(document, dict):
        return ""
    form = document.get("format")
    if isinstance(form, str) and form.startswith("fairaudit-certificate/"):
        return "a certificate"
    if isinstance(form, str) and form.startswith("fairaudit-publication/"):
        return "a summary of `fairaudit publish`"
    if "predicateType" in document:
        return "an attestation"
    return "a signed attestation" if {"payload", "payloadType", "signatures"} <= document.keys() else ""


_ENCODER = json.JSONEncoder(ensure_ascii=True, sort_keys=True, separators=(",", ":"))


def canonical_text(value: object) -> bytes:
    """Write a value as a line of the canonical text of a table: sorted keys, ASCII, no blanks."""
    try:
        return _ENCODER.encode(value).encode("ascii") + b"\n"
    except (TypeError, RecursionError):
        raise malformed("the table", "holds a number that the format has no place for, or is nested too deeply") from None


def described_type(value: object) -> str:
    """Name the type of a JSON value."""
    if value is None or isinstance(value, bool):
        return shown(value)
    names = {int: "a number", _OtherNumber: "a number", str: "a string", list: "a list", dict: "an object"}
    return names[type(value)]


def read_object(value: object, where: str, keys: Sequence[str], optional: Sequence[str] = ()) -> dict[str, object]:
    """Read an object with all of some keys, perhaps some of others, and no further ones."""
    if not isinstance(value, dict):
        raise malformed(where, f"must be an object, not {described_type(value)}")
    for key in keys:
        if key not in value:
            raise malformed(where, f"lacks the key {shown(key)}")
    known = {*keys, *optional}
    for key in value:
        if key not in known:
            raise malformed(where, f"has the unknown key {shown(key)}")
    return value


def read_object_of_strings(value: object, where: str) -> dict[str, object]:
    """Read an object of strings with any keys."""
    members = read_object(value, where, (), optional=tuple(value) if isinstance(value, dict) else ())
    for key, item in members.items():
        read_string(key, f"a key of {where}")
        read_string(item, f"{where}[{shown(key)}]")
    return members


def read_list(value: object, where: str, length: int | None = None) -> list[object]:
    """Read a list, of some length if that is given."""
    if not isinstance(value, list):
        raise malformed(where, f"must be a list, not {described_type(value)}")
    if length is not None and len(value) != length:
        raise malformed(where, f"must have {length} entries, not {len(value)}")
    return value


_SURROGATE = re.compile("[\ud800-\udfff]")


def read_string(value: object, where: str) -> str:
    """Read a string of Unicode scalar values."""
    if not isinstance(value, str):
        raise malformed(where, f"must be a string, not {described_type(value)}")
    if not value.isascii() and _SURROGATE.search(value):
        raise malformed(where, "holds a lone surrogate, which is not a Unicode scalar value")
    return value


def read_strings(value: object, where: str, length: int | None = None) -> tuple[str, ...]:
    """Read a list of strings."""
    return tuple(read_string(item, f"{where}[{i}]") for i, item in enumerate(read_list(value, where, length)))


def read_choice(value: object, where: str, choices: Sequence[str]) -> str:
    """Read one of some strings."""
    text = read_string(value, where)
    if text not in choices:
        raise malformed(where, f"must be one of {shown(list(choices))}, not {shown(text)}")
    return text


def read_integer(value: object, where: str, below: int | None = None) -> int:
    """Read an integer of at least 0, and perhaps below a limit."""
    if isinstance(value, _OtherNumber):
        raise malformed(where, f"must be an integer of at most 18 digits, not {value.token[:40]}{'…' * (len(value.token) > 40)}")
    if type(value) is not int:  # True is an instance of int, and no index
        raise malformed(where, f"must be an integer, not {described_type(value)}")
    if value < 0 or (below is not None and value >= below):
        raise malformed(where, f"is out of range: {value}")
    return value


def read_boolean(value: object, where: str) -> bool:
    """Read true or false."""
    if not isinstance(value, bool):
        raise malformed(where, f"must be true or false, not {described_type(value)}")
    return value


def read_hexadecimal(value: object, where: str, digits: str, length: int) -> str:
    """Read so many hexadecimal digits."""
    text = read_string(value, where)
    if len(text) != length or not set(text) <= set(digits):
        raise malformed(where, f"must be {length} hexadecimal digits")
    return text


def read_digest(value: object, where: str) -> str:
    """Read a SHA-256 in lower case."""
    return read_hexadecimal(value, where, "0123456789abcdef", 64)


def read_label_lists(value: object, where: str, width: int) -> tuple[Labels, ...]:
    """Read different lists of labels, each of which has one label for each column."""
    lists = tuple(read_strings(item, f"{where}[{i}]", width) for i, item in enumerate(read_list(value, where)))
    check_distinct(lists, where)
    return lists


def check_distinct(items: Sequence[object], where: str) -> None:
    """Refuse an empty list, and one that lists something twice."""
    if not items:
        raise malformed(where, "must not be empty")
    if len(set(items)) != len(items):
        raise malformed(where, "lists something twice")
