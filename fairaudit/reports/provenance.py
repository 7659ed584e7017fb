"""Who made a certificate, of what: what of its attestation was checked, what is only stated, and what only the files can tell."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from fairaudit import __version__
from fairaudit.attestations.statement import Source, Statement
from fairaudit.attestations.verification import stated_in
from fairaudit.errors import FalseCertificate
from fairaudit.exact.rationals import rational_text
from fairaudit.reports.words import clip

__all__ = ["TITLE", "Provenance", "amount_text", "intro", "provenance_of"]

TITLE = "Who made this, of what"

LISTED = 20  # sources that are listed

LONG = 600  # characters of a text that are shown

LONG_OPTIONS = 4_000

UNSIGNED = "The attestation is not signed: whoever can change its file could have written it."

UNCHECKED_SIGNATURE = (
    "The attestation is in an envelope with a signature, which was not checked when this was made: that needs the signer's public key. Get "
    "it from the signer, not from whoever gave you these files."
)


@dataclass(frozen=True)
class Provenance:
    """What an attestation says, apart by what speaks for it.

    Attributes
    ----------
    checked : tuple of str
        What was compared with the certificate when this was made, in sentences.
    signature : str
        What is known of the signature.
    stated : tuple of (str, str)
        What nobody can check, by what it is.
    unstated : str
        What is not even stated; empty if all is.
    sources : tuple of (str, str, str, str)
        Name, rows, bytes and digest of what is said to have been read.
    more : int
        How many further sources there are.
    options : str
        How the table is said to have been made, as JSON.
    statement : Statement
        The attestation itself.
    signed : bool
        Whether it is in an envelope.
    """

    checked: tuple[str, ...]
    signature: str
    stated: tuple[tuple[str, str], ...]
    unstated: str
    sources: tuple[tuple[str, str, str, str], ...]
    more: int
    options: str
    statement: Statement
    signed: bool = False

    @property
    def file(self) -> str:
        """What its file is called beside the certificate."""
        return "attestation.dsse.json" if self.signed else "attestation.json"

    @property
    def with_it(self) -> str:
        """What the command that verifies the certificate needs to check it, too."""
        return f"--attestation {self.file}{' --key SIGNER.pub.pem' if self.signed else ''}"


def provenance_of(attestation: bytes, certificate: bytes, table: str, *, compared: bool) -> Provenance:
    """What an attestation says of a certificate.

    Parameters
    ----------
    attestation : bytes
        The bytes of its file.
    certificate : bytes
        Those of the certificate's.
    table : str
        The digest of the certificate's table.
    compared : bool
        Whether the checker compared what was counted with the table before (`fairaudit.verified.verification.checked`).

    Raises
    ------
    InputError
        If it is no attestation.
    FalseCertificate
        If it is about another certificate or table, or does not add up.
    """
    found, envelope = stated_in(attestation)
    digest = hashlib.sha256(certificate).hexdigest()
    named = next((subject.name for subject in found.subjects if subject.sha256 == digest), None)
    if named is None:
        raise FalseCertificate(f"the attestation is about another file: the SHA-256 of that of the certificate is {digest}")
    if found.table != table:
        raise FalseCertificate(f"the attestation is about another table: that of the certificate has the digest {table}")
    if not found.rows.add_up:
        raise FalseCertificate("the attestation does not add up: what was read is not what was counted and left out")
    return Provenance(
        checked=tuple(_checked(found, named, compared=compared)),
        signature=UNSIGNED if envelope is None else UNCHECKED_SIGNATURE,
        stated=tuple(_stated(found)),
        unstated=_unstated(found),
        sources=tuple(map(_source, found.sources[:LISTED])),
        more=max(0, len(found.sources) - LISTED),
        statement=found,
        signed=envelope is not None,
        options=clip(json.dumps(dict(found.options), ensure_ascii=False, separators=(", ", ": ")), LONG_OPTIONS) if found.options else "",
    )


def _checked(found: Statement, named: str, *, compared: bool) -> Iterator[str]:
    rows = found.rows
    dropped = [f"{amount_text(amount)} left out ({clip(reason, LONG)})" for reason, amount in rows.dropped.items() if amount] or [
        "none left out"
    ]
    agrees = "nothing in the certificate contradicts it" if compared else "the table, which is not in the certificate, was not compared"
    counts = f"{amount_text(rows.read)} {rows.unit} were read, {amount_text(rows.counted)} counted, {', '.join(dropped)}"
    yield f"It is about the file of this certificate, byte for byte, under the name {clip(named, LONG)}."
    yield f"It names the certificate's table by its digest, {found.table}."
    yield f"It states that {counts}: that adds up, and {agrees}."


def _stated(found: Statement) -> list[tuple[str, str]]:
    said = found.stated
    period = None if said.period is None else f"{said.period[0]} to {said.period[1]}"
    listed = [
        ("Issued by", said.issuer),
        ("Contact", said.contact),
        ("Title", said.title),
        ("System", said.system),
        ("Version", said.system_version),
        ("Decisions from", period),
        ("Made at", f"{found.issued_at[:10]} {found.issued_at[11:19]} UTC"),
        ("Made with", ", ".join(f"{name} {version}" for name, version in found.versions.items())),
        ("Command", shlex.join(["fairaudit", *found.command])),
    ]
    return [(name, clip(text, LONG)) for name, text in listed if text is not None]


def _unstated(found: Statement) -> str:
    said = found.stated
    names = {"who issued it": said.issuer, "a title": said.title, "the system": said.system, "the period of the decisions": said.period}
    missing = [name for name, value in names.items() if value is None]
    return f"Not stated: {', '.join(missing)}." if missing else ""


def _source(source: Source) -> tuple[str, str, str, str]:
    what = source.query if source.query is not None else f"table {source.table}" if source.table is not None else ""
    name = clip(source.name + (f": {what}" if what else ""), LONG)
    rows = "not counted by itself" if source.rows is None else f"{source.rows:,}"
    return name, rows, "–" if source.bytes is None else f"{source.bytes:,}", source.sha256 or "none"


def amount_text(value: Fraction) -> str:
    """Write how many there were, as people read it."""
    return f"{value.numerator:,}" if value.denominator == 1 else rational_text((value.numerator, value.denominator))


def intro() -> str:
    """The sentence with which the section begins."""
    return (
        "A certificate is about a table and does not say where that comes from. An attestation that came with it does. A part of what it "
        f"says was compared with the certificate when this was made, by fairaudit {__version__}; the rest somebody has to be believed."
    )
