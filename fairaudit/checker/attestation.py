"""The attestation of a certificate: who made it, of which files; what of that a table shows, and what is only stated."""

from __future__ import annotations

import base64
import binascii
import hashlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from .json_values import decoded, described_type, other_kind, read_choice, read_digest, read_integer, read_list, read_object, read_string
from .rationals import ZERO, Rational, at_most, read_rational, sum_of
from .text import Attested, Counted, Finding, FormatError, NotAnAttestation, Report, compared, finding_of, malformed, printable, shown

STATEMENT_TYPE = "https://in-toto.io/Statement/v1"
PREDICATE_TYPE = "urn:uuid:bd6d62ae-1fd3-4a67-b7b5-0c71c96f4a12"
PAYLOAD_TYPE = "application/vnd.in-toto+json"
LONGEST_FILE = 1 << 24  # bytes
LONGEST_TEXT = 4096
MOST_SIGNATURES = 100
MOST_REASONS = 100
SIGNATURE_BYTES = 64
DEEPEST = 12  # levels of options
OPTIONS = (
    *("decision", "group", "context", "truth", "positive", "count", "probability", "weight", "wide", "total", "unit", "utility"),
    *("utility_column", "score", "missing", "unknown", "fold_labels", "label_map", "bins", "skip", "table", "query", "signed", "audit"),
    *("log_format", "extract", "options", "join", "where", "errors", "missing_samples", "recipe", "same_content"),
    *("encoding", "decimal", "thousands", "number_sign"),
)
RUN = ("format", "producer", "model", "task", "status")  # of an evaluation log, the first of them always
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f]")
_TIME = re.compile(r"\d{4}-\d\d-\d\d(T\d\d:\d\d:\d\dZ)?", re.ASCII)
_BASE64 = re.compile(r"[A-Za-z0-9+/]*={0,2}")


@dataclass(frozen=True)
class Signed:
    """What somebody who can check signatures found of an attestation: exactly the bytes that were signed, or why none were."""

    key: str  # the SHA-256 of the public key as DER
    payload: bytes | None
    why: str = ""
    perhaps: str = ""  # what was perhaps mixed up


@dataclass(frozen=True)
class Source:
    """What a table was read from."""

    name: str
    digest: str | None
    rows: int | None
    asked: tuple[tuple[str, str], ...] = ()  # of a database: its query or table
    run: tuple[tuple[str, str], ...] = ()  # of an evaluation log: its format, and what it says of itself


@dataclass(frozen=True)
class Statement:
    """An attestation as it stands: well formed, and perhaps untrue."""

    subjects: tuple[tuple[str, str], ...]  # name and digest
    table: str
    unit: str
    read: Rational
    counted: Rational
    dropped: tuple[tuple[str, Rational], ...]
    sources: tuple[Source, ...]
    options: Mapping[str, object]
    said: tuple[tuple[str, str], ...]  # what is only stated, by what it is about


def check_attestation(attestation: bytes | Signed, certificate: bytes, report: Report) -> Attested:
    """Compare what is attested with the bytes of a certificate's file, and with what was found of its table.

    Where somebody checked the signature, nothing but the bytes that were signed is read.
    """
    counted = report.counted
    if counted is None:
        raise AssertionError
    try:
        if isinstance(attestation, bytes):
            if len(attestation) > LONGEST_FILE:
                raise malformed("the file", f"is longer than {LONGEST_FILE} bytes")
            payload, enveloped = _payload(attestation)
            return _attested(payload, certificate, report, counted, "unchecked" if enveloped else "none")
        by_the_key = f"the attestation is signed by the key {attestation.key}"
        if attestation.payload is None:
            return Attested((finding_of(by_the_key, False, attestation.why),), (), "checked", attestation.key, attestation.perhaps)
        found = _attested(attestation.payload, certificate, report, counted, "checked")
        return replace(found, findings=(finding_of(by_the_key, True), *found.findings), key=attestation.key)
    except FormatError as error:
        raise NotAnAttestation(str(error)) from None


def _attested(payload: bytes, certificate: bytes, report: Report, counted: Counted, signature: str) -> Attested:
    document = decoded(payload, "the statement")
    if (kind := other_kind(document)) not in ("", "an attestation"):
        raise malformed("the file", f"is {kind}; give the one that `certify --attest` or `attest` wrote")
    stated = _read_statement(document)
    digest = hashlib.sha256(certificate).hexdigest()
    perhaps = "" if any(of == digest for _, of in stated.subjects) else printable(_mixed_up(stated, counted, of_page=report.of_page))
    return Attested(tuple(_compared(stated, digest, counted)), _said(stated, digest, counted), signature, perhaps=perhaps)


def _mixed_up(stated: Statement, counted: Counted, *, of_page: bool) -> str:
    """Say what an attestation is about, where that is not the file that was checked."""
    names = [shown(name) for name, _ in stated.subjects]
    about = f"The attestation is about {', '.join(names[:3])}{f' and {len(names) - 3:,} more' if len(names) > 3 else ''}"
    if stated.table != counted.table:
        return f"{about}, with another table: it belongs to another certificate, or one of the two was altered."
    if of_page:
        return f"{about}; what was given is a page that shows a certificate, which is another file: check the .json itself."
    return f"{about}, another file of the same table: one that was written at another time, or one of the two was altered."


def _payload(raw: bytes) -> tuple[bytes, bool]:
    """Take the bytes of the statement out of an envelope, whose signatures are not checked; and say whether there is one."""
    document = decoded(raw, "the file")
    if not isinstance(document, dict) or document.keys().isdisjoint(("payload", "payloadType", "signatures")):
        return raw, False
    members = read_object(document, "the envelope", ("payload", "payloadType", "signatures"))
    read_choice(members["payloadType"], "payloadType", (PAYLOAD_TYPE,))
    signatures = read_list(members["signatures"], "signatures")
    if not 0 < len(signatures) <= MOST_SIGNATURES:
        raise malformed("signatures", f"must be 1 to {MOST_SIGNATURES}, not {len(signatures)}")
    for i, item in enumerate(signatures):
        entry = read_object(item, f"signatures[{i}]", ("sig",), optional=("keyid",))
        if len(_read_base64(entry["sig"], f"signatures[{i}].sig")) != SIGNATURE_BYTES:
            raise malformed(f"signatures[{i}].sig", f"is not {SIGNATURE_BYTES} bytes long, as a signature of Ed25519 is")
        _read_text(entry.get("keyid", ""), f"signatures[{i}].keyid")
    return _read_base64(members["payload"], "payload"), True


def _read_base64(value: object, where: str) -> bytes:
    """Read base64 in the one way in which the bytes are written."""
    text = read_string(value, where)
    if _BASE64.fullmatch(text):
        try:
            found = base64.b64decode(text, validate=True)
        except binascii.Error:
            pass
        else:
            if base64.b64encode(found).decode("ascii") == text:
                return found
    raise malformed(where, "is not the base64 of any bytes, in the standard alphabet, with padding and without blanks")


def _read_statement(document: object) -> Statement:
    top = read_object(document, "the statement", ("_type", "subject", "predicateType", "predicate"))
    read_choice(top["_type"], "_type", (STATEMENT_TYPE,))
    read_choice(top["predicateType"], "predicateType", (PREDICATE_TYPE,))
    always = ("issuedAt", "table", "sources", "rows", "options", "command", "versions")
    held = read_object(top["predicate"], "predicate", always, ("issuer", "title", "system", "period"))
    rows = read_object(held["rows"], "rows", ("unit", "read", "counted", "dropped"))
    dropped = _members(rows["dropped"], "rows.dropped")
    if len(dropped) > MOST_REASONS:
        raise malformed("rows.dropped", f"has more than {MOST_REASONS} reasons")
    options = read_object(held["options"], "options", (), OPTIONS)
    _check_data(options, "options", 0)
    return Statement(
        tuple(_read_subject(item, where) for item, where in _entries(top["subject"], "subject")),
        read_digest(read_object(held["table"], "table", ("sha256",))["sha256"], "table.sha256"),
        read_choice(rows["unit"], "rows.unit", ("decisions", "rows")),
        _read_amount(rows["read"], "rows.read"),
        _read_amount(rows["counted"], "rows.counted"),
        tuple((reason, _read_amount(amount, f"rows.dropped[{shown(reason)}]")) for reason, amount in dropped.items()),
        tuple(_read_source(item, where) for item, where in _entries(held["sources"], "sources")),
        options,
        tuple(_read_said(held)),
    )


def _entries(value: object, where: str) -> list[tuple[object, str]]:
    listed = read_list(value, where)
    if not listed:
        raise malformed(where, "must not be empty")
    return [(item, f"{where}[{i}]") for i, item in enumerate(listed)]


def _members(value: object, where: str) -> Mapping[str, object]:
    """Read an object whose keys are any texts."""
    members = read_object(value, where, (), optional=tuple(value) if isinstance(value, dict) else ())
    for key in members:
        _read_text(key, f"a key of {where}")
    return members


def _read_text(value: object, where: str) -> str:
    text = read_string(value, where)
    if len(text) > LONGEST_TEXT:
        raise malformed(where, f"is longer than {LONGEST_TEXT} characters")
    if _CONTROL.search(text):
        raise malformed(where, "holds a control character")
    return text


def _read_name(value: object, where: str) -> str:
    text = _read_text(value, where)
    if not text or "/" in text:
        raise malformed(where, f"must be a name without folders, not {shown(text)}")
    return text


def _read_amount(value: object, where: str) -> Rational:
    """Read a whole number, or as text what is none or has more than 18 digits."""
    if not isinstance(value, str):
        return read_integer(value, where), 1
    amount = read_rational(_read_text(value, where), where, nonnegative=True)
    if amount[1] == 1 and len(value) <= 18:
        raise malformed(where, f"must be the number {value}, not a string")
    return amount


def _read_subject(value: object, where: str) -> tuple[str, str]:
    members = read_object(value, where, ("name", "digest"))
    digest = read_object(members["digest"], f"{where}.digest", ("sha256",))["sha256"]
    return _read_name(members["name"], f"{where}.name"), read_digest(digest, f"{where}.digest.sha256")


def _read_source(value: object, where: str) -> Source:
    members = read_object(value, where, ("name", "sha256", "bytes", "rows"), ("query", "table", "run"))
    digest, size, rows = members["sha256"], members["bytes"], members["rows"]
    if (digest is None) != (size is None):
        raise malformed(where, "must have both sha256 and bytes, or null for both")
    asked = tuple((key, _read_text(members[key], f"{where}.{key}")) for key in ("query", "table") if key in members)
    if len(asked) > (digest is None):
        raise malformed(where, "has a query or table, of which a database has one and a file none")
    if size is not None:
        read_integer(size, f"{where}.bytes")
    return Source(
        _read_name(members["name"], f"{where}.name"),
        None if digest is None else read_digest(digest, f"{where}.sha256"),
        None if rows is None else read_integer(rows, f"{where}.rows"),
        asked,
        _read_run(members["run"], f"{where}.run") if "run" in members else (),
    )


def _read_run(value: object, where: str) -> tuple[tuple[str, str], ...]:
    members = read_object(value, where, RUN[:1], RUN[1:])
    return tuple((key, _read_filled(members[key], f"{where}.{key}")) for key in RUN if key in members)


def _read_said(held: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    """Read what is only stated."""
    for name, more in (("issuer", "contact"), ("system", "version")):
        if name in held:
            members = read_object(held[name], name, ("name",), (more,))
            texts = [_read_filled(members[key], f"{name}.{key}") for key in ("name", more) if key in members]
            yield name, f"{shown(texts[0])}{''.join(f' ({more} {shown(text)})' for text in texts[1:])}"
    if "title" in held:
        yield "title", shown(_read_filled(held["title"], "title"))
    if "period" in held:
        period = read_object(held["period"], "period", ("start", "end"))
        start, end = (_read_time(period[key], f"period.{key}", "2025-01-01") for key in ("start", "end"))
        if end < start:
            raise malformed("period", f"ends on {end}, before it begins on {start}")
        yield "period", f"{start} to {end}"
    yield "time", _read_time(held["issuedAt"], "issuedAt", "2026-01-15T09:00:00Z")
    for item, where in _entries(held["command"], "command"):
        _read_text(item, where)
    versions = _members(held["versions"], "versions")
    for key in ("fairaudit", *versions):
        if key not in versions:
            raise malformed("versions", f"lacks the key {shown(key)}")
        _read_text(versions[key], f"versions[{shown(key)}]")


def _read_filled(value: object, where: str) -> str:
    text = _read_text(value, where)
    if not text.strip():
        raise malformed(where, "must not be blank")
    return text


def _read_time(value: object, where: str, example: str) -> str:
    """Read a day or a moment, which is written as the example is."""
    text = read_string(value, where)
    try:
        if len(text) == len(example) and _TIME.fullmatch(text) and datetime.fromisoformat(text.removesuffix("Z")):
            return text
    except ValueError:
        pass
    raise malformed(where, f"must be such as {example}, not {shown(text)}")


def _check_data(value: object, where: str, depth: int) -> None:
    """Refuse in options what is neither text, whole number, true or false, nor a list or object of such."""
    if depth > DEEPEST:
        raise malformed("options", "are nested too deeply")
    if isinstance(value, dict):
        for key, item in _members(value, where).items():
            _check_data(item, f"{where}[{shown(key)}]", depth + 1)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            _check_data(item, f"{where}[{i}]", depth + 1)
    elif isinstance(value, str):
        _read_text(value, where)
    elif type(value) not in (int, bool):
        raise malformed(where, f"must be a text or a whole number, not {described_type(value)}")


def _compared(stated: Statement, digest: str, counted: Counted) -> Iterator[Finding]:
    """Compare file, by its digest, table, sum, what was counted and dropped, the format of logs, and what databases were asked for."""
    names = [name for name, of in stated.subjects if of == digest]
    about = f"subject {shown(names[0])} is the file that was checked" if names else "a subject is the file that was checked"
    yield finding_of(about, bool(names), "" if names else f"the SHA-256 of that file is {digest}")
    yield compared("table.sha256", stated.table, counted.table)
    total = sum_of([stated.counted, *(amount for _, amount in stated.dropped)])
    sentence = f"rows.read is {shown(stated.read)}, as many as were counted and dropped"
    yield finding_of(sentence, stated.read == total, "" if stated.read == total else f"these are {shown(total)}")
    yield compared("rows.unit", stated.unit, counted.unit)
    if counted.exactly is not None:
        yield compared("rows.counted", stated.counted, counted.exactly)
    else:
        fits = stated.counted[1] == 1 and at_most((1, 1), stated.counted) and at_most(stated.counted, (counted.most, 1))
        yield finding_of(f"rows.counted is {shown(stated.counted)}", fits, "" if fits else f"the table has {counted.most} entries")
    if counted.dropped is not None:
        ours = {reason: amount for reason, amount in stated.dropped if amount != ZERO}
        yield compared("rows.dropped", ours, dict(counted.dropped))
    for i, source in enumerate(stated.sources):
        if source.run:
            of_run = dict(source.run)[RUN[0]]
            fault = "is of no evaluation log" if counted.log is None else "" if of_run == counted.log else f"says {shown(counted.log)}"
            yield finding_of(f"sources[{i}].run.format is {shown(of_run)}", not fault, fault and f"the certificate {fault}")
    if stated.options:
        yield from _asked(stated.sources, stated.options)


def _asked(sources: Sequence[Source], options: Mapping[str, object]) -> Iterator[Finding]:
    """Compare what databases were asked for with the options, by which a log is read again."""
    for i, source in enumerate(sources):
        for key, text in source.asked:
            fits = options.get(key) == text
            other = f"that is {shown(options[key])}" if key in options else f"there is no options.{key}"
            yield finding_of(f"sources[{i}].{key} is options.{key}", fits, "" if fits else other)
    if "query" in options and not any(key == "query" for source in sources for key, _ in source.asked):
        yield finding_of("options.query is that of a source", False, "no source has a query")


def _same_content(stated: Statement) -> Iterator[str]:
    """Say which sources are the same bytes; that is no fault, as whether the rows of both were counted is not stated."""
    names: dict[str, list[str]] = {}
    for source in stated.sources:
        if source.digest is not None:
            names.setdefault(source.digest, []).append(source.name)
    same = [f"{shown(held[0])} and {shown(held[1])}" for held in names.values() if len(held) > 1]
    if same:
        more = f" and {len(same) - 3:,} more pairs" if len(same) > 3 else ""
        meant = "; its options say that this was meant" if stated.options.get("same_content") == "accept" else ""
        yield f"Sources with the same content: {', '.join(same[:3])}{more}: if both are logs, each of their rows counts twice{meant}."


def _said(stated: Statement, digest: str, counted: Counted) -> tuple[str, ...]:
    """Say in sentences what is only stated, and what is not checked."""
    others = len({of for _, of in stated.subjects} - {digest})
    said = dict(stated.said)
    words = {"issuer": "issued by", "title": "titled", "system": "about the system", "period": "of decisions from"}
    parts = [f"{opening} {said[key]}" for key, opening in words.items() if key in said]
    unstated = [key for key in words if key not in said]
    runs = [source for source in stated.sources if source.run]
    of_runs = [f"{shown(source.name)} ({', '.join(f'{key} {shown(text)}' for key, text in source.run)})" for source in runs[:3]]
    of_runs += [f"{len(runs) - 3:,} more"] if len(runs) > 3 else []
    names = [f"{shown(source.name)}{'' if source.digest else ' (without digest)'}" for source in stated.sources[:3]]
    more = [f"{len(stated.sources) - 3:,} more"] if len(stated.sources) > 3 else []
    sentences = [
        f"What follows is only stated, and no check can see it: {', '.join([*parts, 'made at ' + said['time']])}; command and versions.",
        *([f"No {' or '.join(unstated)} is stated."] if unstated else []),
        *([f"Runs of evaluations, as their logs are said to name them: {', '.join(of_runs)}."] if runs else []),
        *([f"Files that it names besides, which were not checked: {others:,}."] if others else []),
        *_same_content(stated),
        *(["What was dropped is only stated, too: the certificate does not say."] if counted.dropped is None else []),
        f"Whether the table was counted from {', '.join([*names, *more])}, only the log tells, counted again (fairaudit verify --recount).",
    ]
    return tuple(map(printable, sentences))
