"""`verify`: a certificate checked by the independent checker, and with it what somebody attests of it, signature included."""

from __future__ import annotations

import os
from typing import Literal

from fairaudit.arguments import answered
from fairaudit.attestations.envelope import Envelope, read_envelope
from fairaudit.attestations.keys import read_public_key
from fairaudit.attestations.statement import Statement, read_statement
from fairaudit.attestations.strict import MAX_BYTES
from fairaudit.errors import InputError
from fairaudit.files import read_bounded
from fairaudit.verified.verification import CertificateLike, Signed, Verification, verification_of

__all__ = ["read_attestation", "signed_by", "stated_in", "verify"]


@answered
def verify(
    certificate: CertificateLike,
    table: str | os.PathLike[str] | None = None,
    require: Literal["within"] | None = None,
    *,
    attestation: bytes | str | os.PathLike[str] | None = None,
    key: bytes | str | os.PathLike[str] | None = None,
) -> Verification:
    """Check every statement of a certificate, in exact integer arithmetic and with none of the code that wrote it.

    Parameters
    ----------
    certificate : Certificate, Result, mapping, bytes or path
        The certificate, or the file that holds it: its own, or the page of a report, of which only the certificate in it is checked.
    table : path, optional
        The file of the canonical table, where the certificate does not hold it.
    require : {"within"}, optional
        The verdict that the certificate must state, too.
    attestation : path or bytes, optional
        The file that says who made the certificate, of which files: what of it can be checked is checked.
    key : path or bytes, optional
        The signer's public key (extra ``sign``), by which the attestation must be signed. Without it an attestation in an envelope is
        compared, but not `ok`.

    Returns
    -------
    Verification
        A finding for each statement; it is true where it is `ok`.

    Raises
    ------
    InputError
        If it is no complete certificate of the format, no attestation or no key, or a file cannot be read.
    TableNeeded
        If the certificate does not hold its table, and none was given.

    Examples
    --------
    >>> from fairaudit.audits.from_table import audit
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    >>> certificate = audit(table, decision="hired", group="sex", utility="yes").certificate
    >>> verify(certificate).sentence
    "all 45 statements are true of the table; the stated verdict is 'none'"
    >>> certificate.document["metrics"]["local"]["ratio"] = "9"
    >>> verify(certificate).false[0].detail
    'the table gives 1'
    """
    if attestation is None:
        if key is not None:
            raise InputError("key is the signer's of an attestation; give attestation, too, or leave it away")
        return verification_of(certificate, table, require)
    raw = attestation if isinstance(attestation, bytes) else read_attestation(attestation)
    name = "the attestation" if isinstance(attestation, bytes) else os.fspath(attestation)
    return verification_of(certificate, table, require, raw if key is None else signed_by(raw, key, name))


def read_attestation(path: str | os.PathLike[str]) -> bytes:
    """Read the file of an attestation, which is not long.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    return read_bounded(path, MAX_BYTES, "attestation")


def stated_in(raw: bytes, name: str = "the attestation") -> tuple[Statement, Envelope | None]:
    """Read the statement in an attestation, and the envelope around one that is signed; a signature is not looked at.

    Raises
    ------
    InputError
        If it is no attestation.
    """
    envelope = read_envelope(raw, name)
    return read_statement(raw if envelope is None else envelope.payload, name), envelope


def signed_by(raw: bytes, key: bytes | str | os.PathLike[str], name: str = "the attestation") -> Signed:
    """Find whether an attestation is signed by a key: then exactly the bytes that were signed are all that is to be read of it.

    Parameters
    ----------
    raw : bytes
        The bytes of its file.
    key : path or bytes
        The file of the public key, or its bytes.
    name : str
        What messages call the attestation.

    Raises
    ------
    InputError
        If the file of the key holds none that is accepted, or the envelope is not of its form.
    """
    public = read_public_key(key)
    envelope = read_envelope(raw, name)
    if envelope is None:
        return Signed(public.id, None, "it is not signed at all", "The file is not signed; did you mean the envelope (.dsse.json)?")
    if not envelope.is_signed_by(public):
        return Signed(public.id, None, "no signature of the envelope is by this key, or what was signed was altered")
    return Signed(public.id, envelope.payload)
