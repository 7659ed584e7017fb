"""The statement beside a certificate: who made it, of which files, when and how. Its form is docs/attestation.md."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import date, datetime
from fractions import Fraction
from typing import Any, Literal

from fairaudit.attestations.strict import DIGITS, check_data, check_text, decoded, object_of
from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import parse_rational, rational_text
from fairaudit.tables.number_form import TEXT_FORM
from fairaudit.words import brief

__all__ = [
    "OPTIONS",
    "PREDICATE_TYPE",
    "STATEMENT_TYPE",
    "Rows",
    "Source",
    "Stated",
    "Statement",
    "Subject",
    "read_statement",
    "split_period",
]

STATEMENT_TYPE = "https://in-toto.io/Statement/v1"

PREDICATE_TYPE = "urn:uuid:bd6d62ae-1fd3-4a67-b7b5-0c71c96f4a12"

MOST_REASONS = 100

OPTIONS = (
    "decision",
    "group",
    "context",
    "truth",
    "positive",
    "count",
    "probability",
    "weight",
    "wide",
    "total",
    "unit",
    "utility",
    "utility_column",
    "score",
    "missing",
    "unknown",
    "fold_labels",
    "label_map",
    "bins",
    "skip",
    "table",
    "query",
    "signed",
    "audit",
    "log_format",
    "extract",
    "options",
    "join",
    "where",
    "errors",
    "missing_samples",
    "recipe",
    "same_content",
    *TEXT_FORM,
)
"""What `options` may say of how the table of a certificate was made."""


RUN = ("format", "producer", "model", "task", "status")
"""What `run` may say of a source that is an evaluation log, the first of them always."""


@dataclass(frozen=True)
class Subject:
    """A file that a statement is about.

    Attributes
    ----------
    name : str
        Its name, without folders.
    sha256 : str
        The digest of its bytes.
    """

    name: str
    sha256: str


@dataclass(frozen=True)
class Source:
    """What a table was read from.

    Attributes
    ----------
    name : str
        Of a file its name without folders; of a database, what kind it is and its name.
    sha256 : str or None
        The digest of the file as it was read; None of what has no bytes that stay: databases, pipes, frames.
    bytes : int or None
        How many these are.
    rows : int or None
        How many rows were read from it, where they were counted by themselves.
    query, table : str or None
        Of a database: the query, or the name of the table.
    run : mapping of str to str
        Of an evaluation log its format, and what it says of itself: producer, model, task, status.
    """

    name: str
    sha256: str | None = None
    bytes: int | None = None
    rows: int | None = None
    query: str | None = None
    table: str | None = None
    run: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Rows:
    """How much was read, counted and dropped.

    Attributes
    ----------
    unit : {"decisions", "rows"}
        What is counted: decisions, or rows of a table of probabilities.
    read, counted : Fraction
        How many there were, and how many are in the certificate's table.
    dropped : mapping of str to Fraction
        How many were left out, by reason.

    Examples
    --------
    >>> Rows("decisions", Fraction(10), Fraction(7), {"missing label": Fraction(3)}).add_up
    True
    """

    unit: Literal["decisions", "rows"]
    read: Fraction
    counted: Fraction
    dropped: Mapping[str, Fraction] = field(default_factory=dict)

    @property
    def add_up(self) -> bool:
        """Whether what was read is what was counted and what was dropped."""
        return self.read == self.counted + sum(self.dropped.values())


@dataclass(frozen=True)
class Stated:
    """What only somebody says: nothing of it can be checked.

    Attributes
    ----------
    issuer, contact : str or None
        Who made the audit, and how to reach them.
    title : str or None
        What the audit is called.
    system, system_version : str or None
        What was audited.
    period : (str, str) or None
        First and last day of the decisions, such as ``2025-01-01``.
    """

    issuer: str | None = None
    contact: str | None = None
    title: str | None = None
    system: str | None = None
    system_version: str | None = None
    period: tuple[str, str] | None = None


@brief
@dataclass(frozen=True, repr=False)
class Statement:
    """Who made a certificate, of which files, when and how: an in-toto Statement.

    Attributes
    ----------
    subjects : tuple of Subject
        The certificate's file.
    table : str
        The digest of the certificate's table.
    sources : tuple of Source
        What the table was read from.
    rows : Rows
        How much was read, counted and dropped.
    options : mapping
        How the table was made, as `fairaudit.attestations.options` says it.
    command : tuple of str
        The command that was run; nobody runs it again.
    versions : mapping of str to str
        Which programs made it.
    issued_at : str
        When, such as ``2026-01-15T09:00:00Z``.
    stated : Stated
        What only the issuer says.

    Examples
    --------
    >>> digest = "0" * 64
    >>> rows = Rows("decisions", Fraction(2), Fraction(2))
    >>> made = Statement((Subject("c.json", digest),), digest, (Source("log.csv", digest, 40, 2),), rows,
    ...     {"decision": "hired"}, ("certify", "log.csv"), {"fairaudit": "0.1.0"}, "2026-01-15T09:00:00Z", Stated(issuer="A. Auditor"))
    >>> read_statement(made.text.encode()) == made
    True
    """

    subjects: tuple[Subject, ...]
    table: str
    sources: tuple[Source, ...]
    rows: Rows
    options: Mapping[str, Any]
    command: tuple[str, ...]
    versions: Mapping[str, str]
    issued_at: str
    stated: Stated = Stated()

    @property
    def document(self) -> dict[str, Any]:
        """The JSON document of docs/attestation.md."""
        stated = self.stated
        period = None if stated.period is None else dict(zip(("start", "end"), stated.period, strict=True))
        said = {
            "issuer": _given({"name": stated.issuer, "contact": stated.contact}) or None,
            "title": stated.title,
            "system": _given({"name": stated.system, "version": stated.system_version}) or None,
            "period": period,
        }
        rows = self.rows
        return {
            "_type": STATEMENT_TYPE,
            "subject": [{"name": subject.name, "digest": {"sha256": subject.sha256}} for subject in self.subjects],
            "predicateType": PREDICATE_TYPE,
            "predicate": {
                **_given(said),
                "issuedAt": self.issued_at,
                "table": {"sha256": self.table},
                "sources": [
                    {"name": source.name, "sha256": source.sha256, "bytes": source.bytes, "rows": source.rows}
                    | _given({"query": source.query, "table": source.table, "run": dict(source.run) or None})
                    for source in self.sources
                ],
                "rows": {
                    "unit": rows.unit,
                    "read": _amount(rows.read),
                    "counted": _amount(rows.counted),
                    "dropped": {reason: _amount(amount) for reason, amount in rows.dropped.items()},
                },
                "options": dict(self.options),
                "command": list(self.command),
                "versions": dict(self.versions),
            },
        }

    @property
    def text(self) -> str:
        """The document as JSON, in ASCII and indented; it is read again before it is given, so that nobody is handed what is refused.

        Raises
        ------
        InputError
            If something in it has no place in a statement, such as a text of several lines.
        """
        text = json.dumps(self.document, indent=1, ensure_ascii=True) + "\n"
        read_statement(text.encode("ascii"))
        return text


def read_statement(raw: bytes, name: str = "the attestation") -> Statement:
    """Read a statement; whatever is not of its form is refused, and nothing that it says is believed or checked here.

    Parameters
    ----------
    raw : bytes
        The bytes of the statement: of a signed one the payload.
    name : str
        What messages call it.

    Returns
    -------
    Statement
        The statement.

    Raises
    ------
    InputError
        If it is not of the form.
    """
    try:
        return _statement(decoded(raw))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _statement(document: Any) -> Statement:
    if isinstance(document, dict) and str(document.get("format", "")).startswith("fairaudit-certificate/"):
        raise InputError("it is a certificate; give the file that `fairaudit certify --attest FILE` writes beside it")
    top = object_of(document, "the document", ("_type", "subject", "predicateType", "predicate"))
    for key, wanted in (("_type", STATEMENT_TYPE), ("predicateType", PREDICATE_TYPE)):
        if top[key] != wanted:
            raise InputError(f"{key} is {shown(top[key])}; {wanted!r} is accepted")
    subjects = tuple(_subject(entry, where) for where, entry in _entries(top["subject"], "subject"))
    always = ("issuedAt", "table", "sources", "rows", "options", "command", "versions")
    held = object_of(top["predicate"], "predicate", always, ("issuer", "title", "system", "period"))
    table = _digest(object_of(held["table"], "table", ("sha256",))["sha256"], "table.sha256")
    sources = tuple(_source(entry, where) for where, entry in _entries(held["sources"], "sources"))
    command = tuple(check_text(entry, where) for where, entry in _entries(held["command"], "command"))
    versions = _texts_by_key(held["versions"], "versions")
    if "fairaudit" not in versions:
        raise InputError("versions lacks the key 'fairaudit'")
    options = object_of(held["options"], "options", (), OPTIONS)
    check_data(options, "options")
    for name, entries in (("subject", subjects), ("sources", sources), ("command", command)):
        if not entries:
            raise InputError(f"{name} is empty; at least one entry is needed")
    return Statement(subjects, table, sources, _rows(held["rows"]), options, command, versions, _moment(held["issuedAt"]), _stated(held))


def _entries(value: Any, where: str) -> list[tuple[str, Any]]:
    if not isinstance(value, list):
        raise InputError(f"{where} is {shown(value)}; a list is accepted")
    return [(f"{where}[{position}]", entry) for position, entry in enumerate(value)]


def _name(value: Any, where: str) -> str:
    text = check_text(value, where)
    if not text or "/" in text:
        raise InputError(f"{where} is {shown(text)}; a name without folders is accepted")
    return text


def _digest(value: Any, where: str) -> str:
    if not isinstance(value, str) or not re.fullmatch("[0-9a-f]{64}", value):
        raise InputError(f"{where} is {shown(value)}; the 64 hexadecimal digits of a SHA-256 are accepted")
    return value


def _whole(value: Any, where: str) -> int:
    if type(value) is not int or value < 0:
        raise InputError(f"{where} is {shown(value)}; a whole number from 0 is accepted")
    return value


def _optional(read: Callable[[Any, str], Any], value: Any, where: str) -> Any:
    return None if value is None else read(value, where)


def _texts_by_key(value: Any, where: str) -> dict[str, str]:
    if not isinstance(value, dict):
        raise InputError(f"{where} is {shown(value)}; an object is accepted")
    return {check_text(key, f"a key of {where}"): check_text(entry, f"{where}[{shown(key)}]") for key, entry in value.items()}


def _subject(value: Any, where: str) -> Subject:
    held = object_of(value, where, ("name", "digest"))
    digest = object_of(held["digest"], f"{where}.digest", ("sha256",))["sha256"]
    return Subject(_name(held["name"], f"{where}.name"), _digest(digest, f"{where}.digest.sha256"))


def _source(value: Any, where: str) -> Source:
    held = object_of(value, where, ("name", "sha256", "bytes", "rows"), ("query", "table", "run"))
    digest, size = _optional(_digest, held["sha256"], f"{where}.sha256"), _optional(_whole, held["bytes"], f"{where}.bytes")
    if (digest is None) != (size is None):
        raise InputError(f"{where} has one of sha256 and bytes; both are accepted, or null for both")
    of_database = {key: check_text(held[key], f"{where}.{key}") for key in ("query", "table") if key in held}
    if of_database and (digest is not None or len(of_database) > 1):
        raise InputError(f"{where} has {' and '.join(of_database)}, of which a database has one, and a file none")
    run = object_of(held["run"], f"{where}.run", RUN[:1], RUN[1:]) if "run" in held else {}
    said = {key: _said(run, key, f"{where}.run.{key}") or "" for key in run}
    rows = _optional(_whole, held["rows"], f"{where}.rows")
    return Source(_name(held["name"], f"{where}.name"), digest, size, rows, **of_database, run=said)


def _rows(value: Any) -> Rows:
    held = object_of(value, "rows", ("unit", "read", "counted", "dropped"))
    unit: Any = held["unit"]
    if unit not in ("decisions", "rows"):
        raise InputError(f"rows.unit is {shown(unit)}; 'decisions' and 'rows' are accepted")
    if not isinstance(held["dropped"], dict):
        raise InputError(f"rows.dropped is {shown(held['dropped'])}; an object is accepted")
    if len(held["dropped"]) > MOST_REASONS:
        raise InputError(f"rows.dropped has {len(held['dropped'])} reasons; at most {MOST_REASONS} are accepted")
    where = "a key of rows.dropped"
    dropped = {check_text(reason, where): _quantity(amount, f"rows.dropped[{shown(reason)}]") for reason, amount in held["dropped"].items()}
    return Rows(unit, _quantity(held["read"], "rows.read"), _quantity(held["counted"], "rows.counted"), dropped)


def _quantity(value: Any, where: str) -> Fraction:
    """A number of decisions or rows: whole, or a text where it is not, or too long."""
    if not isinstance(value, str):
        return Fraction(_whole(value, where))
    try:
        found = Fraction(*parse_rational(value))
    except InputError:
        found = Fraction(-1)
    if found < 0 or _amount(found) != value:
        raise InputError(f'{where} is {shown(value)}; a whole number from 0, or a fraction in lowest terms such as "5/2", is accepted')
    return found


def _amount(value: Fraction) -> int | str:
    small = value.denominator == 1 and value.numerator < 10**DIGITS
    return value.numerator if small else rational_text((value.numerator, value.denominator))


def _moment(value: Any) -> str:
    text = check_text(value, "issuedAt")
    with suppress(ValueError):
        if re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", text, re.ASCII):
            datetime.fromisoformat(text)
            return text
    raise InputError(f"issuedAt is {shown(text)}; a moment such as 2026-01-15T09:00:00Z is accepted")


def _stated(held: Mapping[str, Any]) -> Stated:
    issuer = object_of(held["issuer"], "issuer", ("name",), ("contact",)) if "issuer" in held else {}
    system = object_of(held["system"], "system", ("name",), ("version",)) if "system" in held else {}
    period = object_of(held["period"], "period", ("start", "end")) if "period" in held else None
    return Stated(
        issuer=_said(issuer, "name", "issuer.name"),
        contact=_said(issuer, "contact", "issuer.contact"),
        title=_said(held, "title", "title"),
        system=_said(system, "name", "system.name"),
        system_version=_said(system, "version", "system.version"),
        period=None if period is None else _period(period["start"], period["end"]),
    )


def _said(held: Mapping[str, Any], key: str, where: str) -> str | None:
    if key not in held:
        return None
    text = check_text(held[key], where)
    if not text.strip():
        raise InputError(f"{where} is empty; leave it out")
    return text


def split_period(text: str, name: str = "period") -> tuple[str, str]:
    """Give the first and the last day of a period, such as ``2025-01-01/2025-12-31``.

    Raises
    ------
    InputError
        If they are not such days; the message gives it this name.

    Examples
    --------
    >>> split_period("2025-01-01/2025-12-31")
    ('2025-01-01', '2025-12-31')
    """
    start, slash, end = text.partition("/")
    if not slash:
        raise InputError(f"{name} is {shown(text)}; START/END is accepted, such as 2025-01-01/2025-12-31")
    return _period(start, end)


def _period(start: object, end: object) -> tuple[str, str]:
    first, last = _day(start), _day(end)
    if first > last:
        raise InputError(f"the period ends on {last}, before it begins on {first}")
    return first, last


def _day(value: object) -> str:
    text = check_text(value, "a day of the period")
    with suppress(ValueError):
        if date.fromisoformat(text).isoformat() == text:
            return text
    raise InputError(f"the period has the day {shown(text)}; a day such as 2025-01-01 is accepted")


def _given(entries: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entries.items() if value is not None}
