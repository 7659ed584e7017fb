"""`verify`: a certificate checked by the independent checker, with none of the code that wrote it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from typing import Any, Literal, Protocol

from fairaudit import __version__, checker
from fairaudit.certificates.certificate import Certificate
from fairaudit.certificates.reader import FORMAT, MAX_BYTES, OTHER_FORMATS, load
from fairaudit.checker import Attested, Finding, Signed
from fairaudit.errors import FalseCertificate, InputError, TableNeeded, kind_of
from fairaudit.inference.verdicts import Verdict
from fairaudit.words import brief, plain

__all__ = ["CertificateLike", "Certified", "Opened", "Signed", "Verification", "checked", "opened", "table_lines", "verification_of"]


class Certified(Protocol):
    """What has a certificate: a `Result`."""

    @property
    def certificate(self) -> Certificate:
        """The certificate."""


CertificateLike = Certificate | Certified | Mapping[str, object] | bytes | str | os.PathLike[str]
"""A certificate, what has one, its JSON document, the bytes of its file, or where the file is."""


@brief
@dataclass(frozen=True, repr=False)
class Verification:
    """What the checker found of each statement of a certificate.

    Attributes
    ----------
    findings : tuple of Finding
        Each with its ``statement``, whether it is ``true``, and a ``detail`` on what the table says instead.
    verdict : {"none", "within", "exceeds", "inconclusive", "depends", "changed"}
        The verdict that the certificate states.
    required : str or None
        The verdict that was required.
    attestation : Attested or None
        Of an attestation that was given: its own ``findings``, sentences on what is only stated (``said``), and whether its
        ``signature`` was "checked", is "unchecked", or there is "none".

    Examples
    --------
    >>> from fairaudit.audits.from_table import audit
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    >>> found = verification_of(audit(table, decision="hired", group="sex", utility="yes"))
    >>> found.ok, found.verdict, [finding.statement for finding in found.false]
    (True, 'none', [])
    """

    findings: tuple[Finding, ...]
    verdict: Verdict
    required: Literal["within"] | None = None
    attestation: Attested | None = None

    @property
    def false(self) -> tuple[Finding, ...]:
        """The statements that are false, those of an attestation included."""
        attested = () if self.attestation is None else self.attestation.findings
        return tuple(finding for finding in (*self.findings, *attested) if not finding.true)

    @property
    def _report(self) -> checker.Report:
        return checker.Report(self.findings, self.verdict, attested=self.attestation)

    @property
    def ok(self) -> bool:
        """Whether every statement is true, the verdict the one that was required, and no signature left unchecked."""
        return self.exit_code == 0

    def __bool__(self) -> bool:
        """Whether it is `ok`."""
        return self.ok

    @property
    def exit_code(self) -> int:
        """What `fairaudit verify` exits with: 0 if it is `ok`; 3 if but for that a signature was not checked; else 1."""
        return checker.exit_code(self._report, self.required)

    @property
    def sentence(self) -> str:
        """How many statements are true, and the verdict, in words."""
        return checker.summary_line(self._report, self.required)

    def _repr_html_(self) -> str:
        """What a notebook shows: the sentence, and the statements that are false."""
        found = ((finding.statement, finding.detail) for finding in self.false)
        listed = "".join(f"<li><bdi>{escape(plain(': '.join(filter(None, texts))))}</bdi></li>" for texts in found)
        return f"<p>{escape(self.sentence)}</p>{f'<ul>{listed}</ul>' if listed else ''}"

    def require(self) -> Verification:
        """Give itself back, or refuse to go on.

        Raises
        ------
        FalseCertificate
            If it is not `ok`.
        """
        if not self.ok:
            raise FalseCertificate(self.sentence)
        return self


def verification_of(
    certificate: CertificateLike | Opened,
    table: str | os.PathLike[str] | None = None,
    require: Literal["within"] | None = None,
    attestation: bytes | Signed | None = None,
) -> Verification:
    """Check every statement of a certificate, and of an attestation of it; what `fairaudit.verify` does, but for signatures.

    Parameters
    ----------
    certificate, table, require
        As `fairaudit.verify` has them; or a certificate that is at hand, with its table.
    attestation : bytes or Signed, optional
        The bytes of its file, or what was found of its signature.

    Raises
    ------
    InputError
        If one of them is not of its form, or cannot be read.
    TableNeeded
        If the certificate does not hold its table, and none was given.
    """
    if require not in (None, "within"):
        raise InputError(f"require={require!r} is not accepted; 'within' is")
    found = certificate if isinstance(certificate, Opened) else opened(certificate, table)
    report = _report(found)
    attested = None if attestation is None else _attested(attestation, found, report)
    verdict: Any = report.verdict
    return Verification(report.findings, verdict, require, attested)


@dataclass(frozen=True)
class Opened:
    """A certificate at hand, not checked.

    Attributes
    ----------
    document : dict
        Its JSON document.
    raw : bytes
        The bytes of its file.
    lines : iterable of bytes or None
        The lines of its table, where it does not hold it and they are at hand.
    name : str
        What messages call it.
    """

    document: dict[str, Any]
    raw: bytes
    lines: Iterable[bytes] | None
    name: str

    @property
    def form(self) -> object:
        """The format that the document names, whatever it is."""
        return self.document.get("format") if isinstance(self.document, dict) else None


def opened(certificate: CertificateLike, table: str | os.PathLike[str] | None = None, *, pages: bool = True) -> Opened:
    """Find the document of a certificate, and its table; in a page, too, if those are accepted.

    Raises
    ------
    InputError
        If a file cannot be read, or this is no certificate.
    """
    lines = None if table is None else table_lines(Path(table))
    if isinstance(certificate, (str, os.PathLike)):
        if str(certificate).lstrip().startswith("{"):
            raise InputError("the text is a document and no file name; give json.loads(text), or the name of its file")
        if not os.fspath(certificate):
            raise InputError("'' is no file name; name the file of the certificate")
        document, raw = load(certificate, (FORMAT, *OTHER_FORMATS), unwrap=_without_page if pages else _json_alone)
        return Opened(document, raw, lines, os.fspath(certificate))
    name = "the certificate"
    if isinstance(certificate, bytes):
        held = _without_page(certificate)
        try:
            document = json.loads(held)
        except (ValueError, RecursionError):
            raise InputError("these bytes are not JSON, as a certificate is") from None
        return Opened(document, certificate, lines, name)
    if isinstance(certificate, Mapping):
        try:
            return Opened(dict(certificate), Certificate(dict(certificate)).text.encode("ascii"), lines, name)
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError(f"the document cannot be written as JSON, as a certificate is: {error}") from None
    made = certificate if isinstance(certificate, Certificate) else getattr(certificate, "certificate", None)
    if not isinstance(made, Certificate):
        raise InputError(f"{kind_of(certificate)} is no certificate; give a Certificate, a Result, the document, or the path of the file")
    if lines is None and made.table is not None:
        lines = made.table.lines()
    return Opened(made.document, made.text.encode("ascii"), lines, name)


def _without_page(raw: bytes) -> bytes:
    try:
        return checker.without_page(raw)
    except checker.FormatError as error:
        raise InputError(str(error)) from None


def _json_alone(raw: bytes) -> bytes:
    if raw.lstrip().startswith(b"{"):
        return raw
    if raw.lstrip()[:9].lower() == b"<!doctype":
        raise InputError("it is a page; give the certificate itself, the .json that fairaudit certify wrote with it")
    raise InputError("it is no certificate; give the .json that fairaudit certify wrote, and of a log run that first")


def table_lines(path: Path) -> Iterable[bytes]:
    """Read the file of a table line by line; one that no table has is cut.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    try:
        with path.open("rb") as file:
            yield from iter(partial(file.readline, MAX_BYTES), b"")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from None


def _report(found: Opened) -> checker.Report:
    try:
        return checker.check(found.raw, found.lines)
    except checker.TableNeeded:
        raise TableNeeded(f"{found.name} does not hold its table; give the file of the table") from None
    except checker.FormatError as error:
        raise InputError(f"{found.name} is not a certificate of the format {error.form or checker.CERTIFICATE_FORMAT}: {error}") from None


def checked(found: Opened, attestation: bytes | None = None) -> str:
    """Say that a certificate was checked and is true; nothing, if its table is not at hand.

    Parameters
    ----------
    found : Opened
        The certificate.
    attestation : bytes, optional
        The bytes of an attestation, of which what can be checked must be true, too; its signature is not looked at.

    Raises
    ------
    FalseCertificate
        If a statement is false.
    InputError
        If it is no complete certificate of the format, or no attestation.
    """
    try:
        report = _report(found)
    except TableNeeded:
        return ""
    findings = report.findings
    _refuse_false(found.name, findings)
    if attestation is not None:
        attested = _attested(attestation, found, report)
        _refuse_false(f"the attestation of {found.name}", attested.findings, attested.perhaps)
    return f"Checked when this was made: all {len(findings)} statements are true of the table (fairaudit verify, {__version__})."


def _attested(attestation: bytes | Signed, found: Opened, report: checker.Report) -> Attested:
    try:
        return checker.check_attestation(attestation, found.raw, report)
    except checker.NotAnAttestation as error:
        raise InputError(f"the attestation is not one: {error}") from None


def _refuse_false(name: str, findings: Sequence[Finding], perhaps: str = "") -> None:
    false = [finding for finding in findings if not finding.true]
    if false:
        first = f"{false[0].statement}{f' ({false[0].detail})' if false[0].detail else ''}"
        raise FalseCertificate(
            f"{name}: {len(false)} of {len(findings)} statements are FALSE, the first: {first}{f'. {perhaps[:-1]}' if perhaps else ''}"
        )
