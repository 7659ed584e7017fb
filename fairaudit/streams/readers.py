"""Logs of decisions: lines as they come, from a growing file or a pipe, turned into counts."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from decimal import Decimal, InvalidOperation
from operator import attrgetter, itemgetter
from typing import Any, Literal

import numpy as np

from fairaudit.errors import InputError, nearest, shown
from fairaudit.streams.settings import Settings
from fairaudit.tables.evaluations.paths import ABSENT, Path, is_path, read_path
from fairaudit.words import noun

__all__ = ["Batch", "Row", "decoder", "line_ends", "moment", "refuse_samples"]


Key = tuple[Any, ...]

Bad = tuple[int, str, Key]

LABELS = 200  # that a column may have for a decoder that knows them: with more, looking them up costs what it saves

RELEARN = 50  # times a decoder is made anew for labels that it did not know; a column of identifiers would have it made for ever


@dataclass(frozen=True, slots=True)
class Row:
    """One decision: the line, the labels that it is counted by, and what else was asked for (event id, time, unit)."""

    line: int
    key: Key
    extra: tuple[Any, ...] = ()


@dataclass
class Batch:
    """What some lines said.

    Attributes
    ----------
    counts : Counter
        How often each combination of context, group and decision occurred, in order of first appearance; used when `rows` is None.
    rows : list of Row or None
        The decisions one by one, if they are needed so.
    bad : list of (int, str, tuple)
        Lines that cannot be read, why, and their labels as far as they can be read; empty where none can.
    """

    counts: Counter[Key] = field(default_factory=Counter)
    rows: list[Row] | None = None
    bad: list[Bad] = field(default_factory=list)


class _Json:
    """Reads lines of JSON, fast where msgspec is installed, and line by line where it is not or a line needs it."""

    def __init__(self, settings: Settings) -> None:
        self.labels = (*settings.context, *settings.group, settings.decision)
        self.extra = tuple(name for name in (settings.event_id, settings.time, *settings.unit) if name is not None)
        self.counted = len(self.labels)
        self.numeric = settings.utility is None
        self.truth: tuple[bool, ...] = (False,) * self.counted
        self.known: list[set[Any]] = [set() for _ in self.labels]
        self.learnt = 0
        self.literal: Callable[[bytes], list[Any]] | None = None
        self.paths = {name: path for name in (*self.labels, *self.extra) if is_path(name) and (path := _path(name)) is not None}
        self.general = None if self.paths else _fast_decoder(self.labels, self.extra, self._types())
        self.fields = _fields(self.counted + len(self.extra))

    def batch(self, data: bytes, line: int, *, itemise: bool = False) -> Batch:
        """Read whole lines; `line` is the number of the first."""
        batch = Batch()
        found = None if itemise or self.extra else self._fast(data)
        if found is None:
            batch.rows = []
            self._rows(data, line, batch.rows, batch.bad)
        else:
            batch.counts = Counter({self.fields(event): n for event, n in Counter(found).items()})
            if not self.literal:
                self._learn(batch.counts)
        return batch

    def _fast(self, data: bytes) -> list[Any] | None:
        """Decode all lines at once, if each is an object and its labels are of the expected kinds.

        Labels are text or integers in some columns, text or truth values in others: not both in one, because 1 and true are equal to
        Python. A line break between } and { is never inside a JSON value, so that objects and lines are then the same.
        """
        number = _objects(data)
        if not number or self.general is None:
            return None
        for decode in (self.literal, self.general):
            try:
                found = decode(data) if decode else None
            except ValueError:  # of the JSON, of the kind of a label, or of the encoding
                self.literal = None
                continue
            if found is not None:
                return found if len(found) == number else None
        kinds = self._kinds(data)
        if kinds == self.truth:
            return None
        self.truth = kinds
        self.general = _fast_decoder(self.labels, self.extra, self._types())
        return self._fast(data)

    def _kinds(self, data: bytes) -> tuple[bool, ...]:
        """Which labels of the first line are truth values; once a column had one it is not asked again."""
        try:
            first = json.loads(data[: data.find(b"\n")])
        except (ValueError, RecursionError):
            return self.truth
        return tuple(truth or isinstance(first.get(name), bool) for truth, name in zip(self.truth, self.labels, strict=True))

    def _types(self) -> list[Any]:
        types: list[Any] = [str | bool | None if truth else str | int | None for truth in self.truth]
        return [*types[:-1], Decimal | None] if self.numeric else types

    def _learn(self, counts: Counter[Key]) -> None:
        """Make a decoder that knows the labels seen so far, which is faster; the general one reads what it does not know."""
        if self.learnt >= RELEARN or self.general is None:
            return
        self.learnt += 1
        types = self._types()
        for place, names in enumerate(zip(*counts, strict=True)):
            self.known[place].update(names)
            if len(self.known[place]) <= LABELS and all(isinstance(name, str) for name in self.known[place]):
                types[place] = Literal[(None, *sorted(self.known[place]))]
        self.literal = _fast_decoder(self.labels, self.extra, types)

    def _rows(self, data: bytes, line: int, rows: list[Row], bad: list[Bad]) -> None:
        """Read lines one by one; a part that can be decoded as a whole is, so that one bad line among millions costs little."""
        found = self._fast(data)
        if found is not None:
            keys = map(self.fields, found)
            rows += [Row(line + k, key[: self.counted], key[self.counted :]) for k, key in enumerate(keys)]
            return
        middle = len(data) // 2
        cut = data.rfind(b"\n", 0, middle) + 1 or data.find(b"\n", middle) + 1
        if 0 < cut < len(data):
            self._rows(data[:cut], line, rows, bad)
            self._rows(data[cut:], line + line_ends(data[:cut]), rows, bad)
        elif data.strip():
            self._single(data, line, rows, bad)

    def _single(self, text: bytes, line: int, rows: list[Row], bad: list[Bad]) -> None:
        try:
            event = json.loads(text.decode("utf-8"), parse_float=Decimal, parse_constant=_refuse)
        except UnicodeDecodeError:
            bad.append((line, "not UTF-8", ()))
        except (ValueError, RecursionError, InvalidOperation):
            bad.append((line, "not JSON", ()))
        else:
            if not isinstance(event, dict):
                bad.append((line, "not a JSON object", ()))
                return
            found, fault = dict(event), ""
            for name, path in self.paths.items():
                if name not in event:
                    try:
                        found[name] = path.of(event)
                    except InputError as error:
                        fault = fault or str(error)
            labels, extra = (
                tuple(None if (v := found.get(name)) is ABSENT else v for name in names) for names in (self.labels, self.extra)
            )
            if fault:
                bad.append((line, fault, labels))
            else:
                rows.append(Row(line, labels, extra))


def _path(name: str) -> Path | None:
    """A path into a line, which is one decision; None of what can be the name of a column alone."""
    try:
        path = read_path(name)
    except InputError:
        return None
    if path.each is not None:
        raise InputError(f"{shown(name, 200)} makes several rows of a line, and a line of a stream is one decision; name an element")
    return path


def line_ends(data: bytes) -> int:
    """Number of line ends; several times faster than `bytes.count`."""
    return int(np.count_nonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n")))


def _objects(data: bytes) -> int:
    """Number of lines if every one begins with { and ends with }, else 0."""
    octets = np.frombuffer(data, dtype=np.uint8)
    ends = np.flatnonzero(octets == ord("\n"))
    if not len(ends) or ends[0] < 2 or data[:1] != b"{" or (octets[ends[:-1] + 1] != ord("{")).any():
        return 0
    last = octets[ends - 1]
    return len(ends) if ((last == ord("}")) | ((last == ord("\r")) & (octets[ends - 2] == ord("}")))).all() else 0


def refuse_samples(data: bytes, path: str) -> None:
    r"""Refuse a log of an evaluation, of which a line is no decision by itself.

    Raises
    ------
    InputError
        If the first line that is not empty is of such a log.

    Examples
    --------
    >>> refuse_samples(b'{"sex":"f","answer":"yes"}\n', "log.jsonl")
    """
    from fairaudit.tables.evaluations.detection import format_of

    try:
        first = json.loads(data.lstrip().partition(b"\n")[0], parse_float=str)
    except (ValueError, RecursionError):
        return  # which is said of the line
    known = format_of(first) if isinstance(first, dict) else None
    if known is not None:
        raise InputError(
            f"{path}: this is a log of {known.name}, in which a question may have several lines, and a line no answer; a stream is of "
            "decisions that were drawn by themselves, and fairaudit certify counts such logs"
        )


def _refuse(constant: str) -> Any:
    raise ValueError(constant)


def _fields(number: int) -> Callable[[Any], Key]:
    get = attrgetter(*(f"f{i}" for i in range(number)))
    return get if number > 1 else lambda row: (get(row),)


def _fast_decoder(labels: tuple[str, ...], extra: tuple[str, ...], types: list[Any]) -> Callable[[bytes], list[Any]] | None:
    """A reader that builds no dictionary and skips what is not asked for; None if msgspec is not installed, or refuses a name."""
    try:
        import msgspec
    except ImportError:
        return None
    declared = [*zip(labels, types, strict=True), *((name, str | int | float | None) for name in extra)]
    if any(character in '\\"' or character < " " for name, _ in declared for character in name):
        return None
    listed = [(f"f{i}", typed, msgspec.field(name=name, default=None)) for i, (name, typed) in enumerate(declared)]
    decode: Callable[[bytes], list[Any]] = msgspec.json.Decoder(msgspec.defstruct("Event", listed, gc=False, frozen=True)).decode_lines
    return decode


class _Csv:
    """Reads rows of CSV, after a header; a row is one line."""

    truth: tuple[bool, ...] = ()

    def __init__(self, settings: Settings, header: Iterable[str]) -> None:
        self.header = [name.strip() for name in header]
        labels = (*settings.context, *settings.group, settings.decision)
        extra = tuple(name for name in (settings.event_id, settings.time, *settings.unit) if name is not None)
        for name in (*labels, *extra):
            if name not in self.header:
                raise InputError(f"there is no column {shown(name)}; {nearest(name, self.header)}")
        places = [self.header.index(name) for name in (*labels, *extra)]
        self.get: Callable[[list[str]], Key] = itemgetter(*places) if len(places) > 1 else lambda row: (row[places[0]],)
        self.counted, self.itemised = len(labels), bool(extra)

    def batch(self, data: bytes, line: int, *, itemise: bool = False) -> Batch:
        """Read whole lines; `line` is the number of the first."""
        batch, lines = Batch(), line_ends(data)
        width = len(self.header)
        if not (itemise or self.itemised):
            rows = self._whole(data)
            if rows is not None and len(rows) == lines and all(len(row) == width for row in rows):
                batch.counts.update(map(self.get, rows))
                return batch
        batch.rows = []
        for k, raw in enumerate(data.split(b"\n")[:lines]):
            if raw.strip():
                self._single(raw, line + k, batch, width)
        return batch

    def _whole(self, data: bytes) -> list[list[str]] | None:
        """All rows at once, if no quotation mark could join lines."""
        if b'"' in data:
            return None
        try:
            return list(csv.reader(data.decode("utf-8").split("\n")[:-1], strict=True))
        except (UnicodeDecodeError, csv.Error):
            return None

    def _single(self, raw: bytes, line: int, batch: Batch, width: int) -> None:
        try:
            rows = list(csv.reader([raw.decode("utf-8").rstrip("\r")], strict=True))
        except UnicodeDecodeError:
            batch.bad.append((line, "not UTF-8", ()))
            return
        except csv.Error:
            batch.bad.append((line, "not a row of CSV on one line", ()))
            return
        if len(rows) != 1 or len(rows[0]) != width:
            said = f"{(found := len(rows[0]) if rows else 0)} {noun(found, 'value')} where the header has {width}"
            batch.bad.append((line, said, ()))
            return
        key = self.get(rows[0])
        if batch.rows is not None:
            batch.rows.append(Row(line, key[: self.counted], key[self.counted :]))


Decoder = _Json | _Csv


def decoder(settings: Settings, header: bytes | None = None) -> Decoder:
    r"""Make a reader of lines; one of CSV needs the header line.

    Raises
    ------
    InputError
        If the header lacks a column.

    Examples
    --------
    >>> reader = decoder(Settings(group=("sex",), decision="answer", utility={"yes": "1"}))
    >>> batch = reader.batch(b'{"sex":"f","answer":"yes"}\n{"sex":', 1, itemise=True)
    >>> [row.key for row in batch.rows]
    [('f', 'yes')]
    """
    if settings.layout == "jsonl":
        return _Json(settings)
    try:
        text = (header or b"").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("the header of the log is not UTF-8") from None
    return _Csv(settings, next(csv.reader([text.rstrip("\r\n")]), []))


def moment(value: Any) -> float:
    """Read a time: seconds since 1970, or a date and time of ISO 8601 (UTC unless it says otherwise).

    Raises
    ------
    InputError
        If it is neither.

    Examples
    --------
    >>> moment("1970-01-02T00:00:00Z"), moment(1.5), moment("1970-01-01")
    (86400.0, 1.5, 0.0)
    """
    try:
        if isinstance(value, (int, float, Decimal)) and not isinstance(value, bool):
            seconds = float(value)
        else:
            text = str(value).strip()
            try:
                read = datetime.fromisoformat(text)
                seconds = (read if read.tzinfo else read.replace(tzinfo=UTC)).timestamp()
            except ValueError:
                seconds = float(text)
    except (ValueError, OverflowError):
        seconds = float("nan")
    if not abs(seconds) < 1e12:
        raise InputError(f"{shown(value)} is not a time; seconds since 1970 or a date such as 2026-01-31T12:00:00Z are accepted")
    return seconds
