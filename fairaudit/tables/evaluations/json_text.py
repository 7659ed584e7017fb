"""JSON of any size: documents of which no more than one value is held at a time, and files with a value on each line."""

from __future__ import annotations

import codecs
import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from decimal import Decimal, InvalidOperation
from functools import partial
from itertools import islice
from pathlib import Path
from typing import IO, Any

from fairaudit.errors import InputError, kind_of, shown
from fairaudit.tables import compressed

__all__ = [
    "DECODER",
    "LINE",
    "Document",
    "document",
    "first_keys",
    "first_row",
    "having",
    "json_lines",
    "leading",
    "number",
    "objects",
    "only",
    "opened",
    "part",
    "said",
    "text",
]

LINE = "line {}"

LARGEST = 2**26
"""How many characters a single value may have; all others are held one by one."""

PIECE = 2**20

BEGINNING = 2**22
"""After how many bytes of a file no more is read than what says which format it has."""

ESCAPE = 12
"""How many characters an escaped character has at most, which is wrong until its end was read."""

EXPONENT = 3
"""How many characters after a whole number may yet belong to it."""

BEGUN = ("true", "false", "null", "NaN", "Infinity", "-Infinity", ".", "e-", "e+", "E-", "E+")
"""How words begin, and what follows the digits of a number."""

FEW = 1000

BLANKS = " \t\r\n"

BLANK = re.compile(r"[ \t\r\n]*")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object, unless a key stands in it twice: which of its values counts, no standard says."""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        again = next(key for place, key in enumerate(keys) if key in keys[:place])
        raise ValueError(f"the key {shown(again)} stands twice in an object")
    return found


def _reason(error: Exception) -> str:
    if isinstance(error, InvalidOperation):
        return "the exponent of a number has too many digits"
    return "a whole number has too many digits" if "int_max_str_digits" in str(error) else str(error)


DECODER = json.JSONDecoder(parse_float=Decimal, object_pairs_hook=_object)


SCAN: Callable[[str, int], tuple[Any, int]] = DECODER.scan_once  # type: ignore[attr-defined]  # of which no stub knows


def _scanned(text: str, start: int) -> tuple[Any, int]:
    """The value that begins in a text, and where it ends."""
    try:
        return SCAN(text, start)
    except StopIteration:
        return DECODER.raw_decode(text, start)  # which says what is wrong


def _whole(text: str) -> Any:
    """The value that a text without blanks around it is."""
    value, end = _scanned(text, 0)
    return value if end == len(text) else DECODER.decode(text)  # which says what is wrong


class Document:
    """A document of JSON, read from its beginning to its end; whoever reads it takes what each key or element stands before.

    Parameters
    ----------
    name : str
        What messages call it.
    read : callable
        Gives up to so many of the next bytes, none at the end.

    Examples
    --------
    >>> import io
    >>> document = Document("a.json", io.BytesIO(b'{"a": [1, 2.50], "b": {"c": null}}').read)
    >>> for key in document.members():
    ...     print(key, [document.value() for _ in document.elements()] if key == "a" else document.value())
    a [1, Decimal('2.50')]
    b {'c': None}
    >>> document.end()
    """

    def __init__(self, name: str, read: Callable[[int], bytes]) -> None:
        self.name = name
        self._read = read
        self._decode = codecs.getincrementaldecoder("utf-8-sig")().decode
        self._text = ""
        self._at = 0
        self._before = 0
        self._ended = False

    def value(self) -> Any:
        """Take a whole value."""
        while True:
            self.peek()
            try:
                value, end = _scanned(self._text, self._at)
            except json.JSONDecodeError as error:
                cut = self._perhaps_cut(error)
                if self._ended or not cut:
                    raise self._cut() if cut else self._wrong(error.msg, error.pos) from None
            except RecursionError:
                raise self._wrong("the value is nested too deeply", self._at) from None
            except (ValueError, InvalidOperation) as error:
                raise self._wrong(_reason(error), self._at) from None
            else:
                if end + EXPONENT <= len(self._text) or self._ended:
                    self._at = end
                    return value
            self._more()

    def whole(self) -> Any:
        """Take a value if all of it was read already and it is an object, a list or a text; else give None, and take nothing."""
        self.peek()
        try:
            value, end = _scanned(self._text, self._at)
        except (ValueError, RecursionError, InvalidOperation):
            return None
        if not isinstance(value, (dict, list, str)):
            return None
        self._at = end
        return value

    def skip(self) -> None:
        """Pass over a value, holding no more than one of those in it."""
        kind = self.peek()
        if kind not in ("{", "["):
            self.value()
        elif self.whole() is None:
            for _ in self.members() if kind == "{" else self.elements():
                self.value()

    def members(self) -> Iterator[str]:
        """Go through the keys of an object."""
        keys: set[str] = set()
        self._take("{")
        if self.peek() == "}":
            self._at += 1
            return
        while True:
            if self.peek() != '"':
                raise self._expected("a name in quotes")
            key = self.value()
            if key in keys:
                raise self._wrong(f"the key {shown(key)} stands twice in an object", self._at - 1)
            keys.add(key)
            self._take(":")
            yield key
            if self._take(",}") == "}":
                return

    def elements(self) -> Iterator[int]:
        """Go through the elements of a list."""
        self._take("[")
        if self.peek() == "]":
            self._at += 1
            return
        count = 0
        while True:
            yield count
            count += 1
            if self._take(",]") == "]":
                return

    def end(self) -> None:
        """Make sure that nothing follows."""
        if self.peek():
            raise self._expected("the end of the file")

    def peek(self) -> str:
        """Look at the first character of what comes next; nothing is an empty text."""
        while True:
            if self._text[self._at : self._at + 1] in BLANKS:
                self._at = BLANK.match(self._text, self._at).end()  # type: ignore[union-attr]
            if self._at < len(self._text):
                return self._text[self._at]
            if self._ended:
                return ""
            self._more()

    def _take(self, marks: str) -> str:
        found = self.peek()
        if not found or found not in marks:
            raise self._expected(" or ".join(marks))
        self._at += 1
        return found

    def _more(self) -> None:
        rest = self._text[self._at :]
        if len(rest) > LARGEST:
            raise self._wrong(f"a single value has more than {LARGEST:,} characters", self._at)
        try:
            data = self._read(max(PIECE, len(rest)))
            text = self._decode(data, not data)
        except UnicodeDecodeError:
            raise InputError(f"{self.name}: the text after character {self._before + len(self._text):,} is not UTF-8") from None
        self._before += self._at
        self._text, self._at, self._ended = rest + text, 0, not data

    def _perhaps_cut(self, error: json.JSONDecodeError) -> bool:
        rest = self._text[error.pos : error.pos + ESCAPE]
        if "escape" in error.msg:
            return len(rest) < ESCAPE and '"' not in rest
        return error.msg.startswith("Unterminated string") or any(word.startswith(rest) for word in BEGUN)

    def _expected(self, what: str) -> InputError:
        return self._cut() if not self.peek() else self._wrong(f"{what} was expected, not {self.peek()!r}", self._at)

    def _cut(self) -> InputError:
        return InputError(
            f"{self.name}: the file ends in the middle of a value (after character {self._before + len(self._text):,}); it was cut"
        )

    def _wrong(self, what: str, at: int) -> InputError:
        return InputError(f"{self.name}: no JSON at character {self._before + at + 1:,}: {what[0].lower()}{what[1:]}")


def opened(path: str) -> AbstractContextManager[IO[bytes]]:
    """Open a file, or what is inside if it is compressed; messages begin with its name."""
    unfit = {compressed.ZSTANDARD: "the file is compressed by Zstandard; unpack it first, or compress it by gzip"}
    return compressed.opened(Path(path), unfit, f"{path}: ")


@contextmanager
def document(path: str) -> Iterator[Document]:
    """Open a file that holds one document."""
    with opened(path) as file:
        yield Document(path, file.read)


def json_lines(path: str) -> Iterator[tuple[int, dict[str, Any]]]:
    r"""Give the number of each line that is not empty, and the object on it.

    Raises
    ------
    InputError
        If a line is no object.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "a.jsonl"
    ...     _ = path.write_text('{"a": 1}\n\n{"a": 2}\n')
    ...     list(json_lines(str(path)))
    [(1, {'a': 1}), (3, {'a': 2})]
    """
    with opened(path) as file:
        lines = iter(partial(file.readline, LARGEST), b"")
        for number, line in enumerate(lines, 1):
            if len(line) == LARGEST:
                raise InputError(f"{path}, line {number}: the line has more than {LARGEST:,} bytes")
            try:
                text = line.decode("utf-8-sig" if number == 1 else "utf-8").strip(" \t\r\n")
                if text:
                    value = _whole(text)
            except UnicodeDecodeError:
                raise InputError(f"{path}, line {number}: the text is not UTF-8") from None
            except RecursionError:
                raise InputError(f"{path}, line {number}: the value is nested too deeply") from None
            except json.JSONDecodeError as error:
                cut = "" if line.endswith(b"\n") else "; the file ends without a line break and may have been cut"
                place = f"{path}, line {number}, character {error.pos + 1}"
                raise InputError(f"{place}: no JSON: {error.msg[0].lower()}{error.msg[1:]}{cut}") from None
            except (ValueError, InvalidOperation) as error:
                raise InputError(f"{path}, line {number}: {_reason(error)}") from None
            if not text:
                continue
            if type(value) is not dict:
                raise InputError(f"{path}, line {number}: an object was expected, not {kind_of(value)}")
            yield number, value


def first_row(path: str) -> Mapping[str, Any]:
    """Give the first object of a file of JSON lines, empty if there is none."""
    return next((row for _, row in islice(json_lines(path), 1)), {})


def first_keys(path: str, decisive: Collection[frozenset[str]] = ()) -> tuple[Mapping[str, Any], bool]:
    """Give the keys at the top of the first object of a file, and whether it is the first element of a list.

    Each key has the first character of its value, nothing if that is null, an empty object in the place of one, and ``spec`` what is in it.
    What is no JSON has no keys. After a long beginning, and before a long value, no more is read than up to a set of keys that is decisive.

    Raises
    ------
    InputError
        If it cannot be read, or is no JSON after a long beginning.
    """
    found: dict[str, Any] = {}
    listed = False
    with opened(path) as file:
        if file.peek(1)[:1] not in (b"{", b"[", b"\xef", b" ", b"\n", b"\r", b"\t"):  # type: ignore[attr-defined]
            return found, listed
        count = 0

        def read(size: int) -> bytes:
            nonlocal count
            data = file.read(size)
            count += len(data)
            return data

        beginning = Document(path, read)
        try:
            listed = beginning.peek() == "["
            if listed and (next(beginning.elements(), None) is None or beginning.peek() != "{"):
                return found, listed
            for key in beginning.members():
                kind = beginning.peek()
                found[key] = {"n": None, "{": {}}.get(kind, kind)
                decided = any(keys <= found.keys() for keys in decisive)
                if decided and count > BEGINNING:
                    break
                if key == "spec":
                    found[key] = beginning.value()
                elif not decided or kind not in ("{", "["):
                    beginning.skip()
                elif beginning.whole() is None:
                    break
        except InputError:
            if count > BEGINNING:
                raise
    return found, listed


def said(path: str, *names: str) -> dict[str, set[str]]:
    """Give the texts that some keys have wherever they stand in a file of lines; no more than a few of each."""
    pattern = re.compile(rb'"(%s)"\s*:\s*("(?:[^"\\]|\\.)*")' % "|".join(names).encode())
    found: dict[bytes, set[bytes]] = {name.encode(): set() for name in names}
    with opened(path) as file:
        for line in file:
            for name, value in pattern.findall(line):
                if len(found[name]) < FEW:
                    found[name].add(value)
    try:
        return {name.decode(): {json.loads(value) for value in values} for name, values in found.items()}
    except ValueError:
        return {name: set() for name in names}


def only(values: Collection[str]) -> str:
    """Give the one text among some; empty if there are several or none."""
    return "".join(values) if len(values) == 1 else ""


def part(holder: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Give an object in an object, empty where there is none."""
    value = holder.get(name)
    return value if isinstance(value, dict) else {}


def objects(value: Any) -> list[Mapping[str, Any]]:
    """Give the objects of a list, none of anything else."""
    return [each for each in value if isinstance(each, dict)] if isinstance(value, list) else []


def leading(value: Any) -> Mapping[str, Any]:
    """Give the object that a list begins with, empty where it begins with none."""
    return value[0] if isinstance(value, list) and value and isinstance(value[0], dict) else {}


def text(holder: Mapping[str, Any], name: str) -> str:
    """Give a text in an object, empty where there is none."""
    value = holder.get(name)
    return value if isinstance(value, str) else ""


def number(holder: Mapping[str, Any], name: str) -> int | None:
    """Give a whole number in an object, None where there is none."""
    value = holder.get(name)
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def having(row: Mapping[str, Any], keys: Sequence[str], path: str, place: int, what: str, form: str = LINE) -> None:
    """Refuse a row that lacks a key which all rows of a format have.

    Raises
    ------
    InputError
        If it does.
    """
    for key in keys:
        if key not in row:
            raise InputError(f"{path}, {form.format(place)}: there is no {shown(key)}, so this is not {what}; files hold one format each")
