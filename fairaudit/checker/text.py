"""What keeps a document from being checked."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass


class FormatError(ValueError):
    """The document is not a well-formed certificate (or table) of the format, which is named if it is another one."""

    form: str = ""


class Incomplete(FormatError):
    """The certificate does not state what its claims assume."""


class TooMuch(FormatError):
    """Checking the certificate would take more work than a document of its length is given."""


class NotAnAttestation(FormatError):
    """The document that should be an attestation is not a well-formed one."""


class TableNeeded(Exception):
    """The table is not embedded in the certificate and was not given."""


def printable(text: str) -> str:
    """Escape what could steer a terminal: control, format, bidi, surrogate, private and unassigned characters."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escaped(ord(c)) for c in text)


def _escaped(code: int) -> str:
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"


def shown(value: object) -> str:
    """Show a label, a rational, a witness and so on in one short line."""
    text = _shown(value)
    return text if len(text) <= 400 else text[:400] + " [...]"


def _shown(value: object) -> str:
    match value:
        case (int(numerator), int(denominator)):
            return shown_rational(numerator, denominator)
        case dict():
            return "{" + ", ".join(f"{_shown(key)}: {_shown(item)}" for key, item in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(_shown(item) for item in value) + "]"
        case str() if len(value) > 400:
            return json.dumps(value[:400] + " [...]", ensure_ascii=False)
        case _:
            return json.dumps(value, ensure_ascii=False)


def shown_rational(numerator: int, denominator: int) -> str:
    """Show a rational; a long one by its length."""
    if denominator == 0:
        return "inf"
    bits = max(numerator.bit_length(), denominator.bit_length())
    if bits > 1500:  # Python may refuse to write long numbers, and nobody would read them
        return f"(a rational of about {bits * 3 // 10} digits)"
    return str(numerator) if denominator == 1 else f"{numerator}/{denominator}"


def malformed(where: str, what: str) -> FormatError:
    """Make the error that something in the document is not as the format has it."""
    return FormatError(printable(f"{where} {what}"))


@dataclass(frozen=True)
class Finding:
    """One statement of a certificate, and whether it is true."""

    statement: str
    true: bool
    detail: str
    assumes: tuple[str, ...] = ()  # what only the reader can judge


@dataclass(frozen=True)
class Outline:
    """What a document says in short, in words: of which nothing holds but if all its statements are true."""

    table: str = ""  # where it is
    targets: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()
    assumptions: tuple[tuple[str, tuple[str, ...]], ...] = ()  # each with what the statements that rest on it are about
    log: tuple[str, ...] = ()  # from which the table was counted, as stated


@dataclass(frozen=True)
class Counted:
    """What a document and its table say of the log: what was counted, and what was left out."""

    table: str  # its digest
    unit: str  # decisions, or rows of a table of probabilities
    exactly: tuple[int, int] | None  # how many were counted; nothing where the table does not tell
    most: int  # how many rows there can have been
    dropped: tuple[tuple[str, tuple[int, int]], ...] | None  # by reason; nothing where the document does not say
    log: str | None = None  # the format of the evaluation log, if it is of one


@dataclass(frozen=True)
class Attested:
    """What was found out about the attestation of a certificate, of which no finding is about the certificate."""

    findings: tuple[Finding, ...]
    said: tuple[str, ...]  # sentences on what is only stated
    signature: str  # none, unchecked or checked
    key: str = ""  # by which it was checked: the SHA-256 of the public key
    perhaps: str = ""  # where it does not belong to the certificate: what was perhaps mixed up

    @property
    def ok(self) -> bool:
        """Whether every statement is true."""
        return all(finding.true for finding in self.findings)


@dataclass(frozen=True)
class Report:
    """What was found out about every statement, and the verdict that the certificate states."""

    findings: tuple[Finding, ...]
    verdict: str
    outline: Outline = Outline()
    of_page: bool = False  # whether the document stood in a page
    counted: Counted | None = None
    attested: Attested | None = None  # where an attestation was given

    @property
    def ok(self) -> bool:
        """Whether every statement is true."""
        return all(finding.true for finding in self.findings)


def finding_of(statement: str, true: bool, detail: str = "", assumes: Iterable[str] = ()) -> Finding:
    """State a finding, which nothing in the document can disguise."""
    return Finding(printable(statement), true, printable(detail), tuple(assumes))


def compared(name: str, stated: object, actual: object) -> Finding:
    """Find whether what is stated is what the table gives."""
    true = stated == actual
    return finding_of(f"{name} is {shown(stated)}", true, "" if true else f"the table gives {shown(actual)}")


def compared_file(lines: Iterable[bytes], digest: str) -> Finding:
    """Find whether a file beside a certificate that holds its table is that table."""
    found = hashlib.sha256()
    for line in lines:
        found.update(line)
    return compared("the digest of the table file", found.hexdigest(), digest)
