"""A signed statement: a DSSE envelope around exactly the bytes that were signed. Its form is docs/attestation.md."""

from __future__ import annotations

import base64
import binascii
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fairaudit.attestations.keys import PublicKey, public_key_of
from fairaudit.attestations.strict import LONGEST, decoded, object_of
from fairaudit.errors import InputError, shown

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

__all__ = ["PAYLOAD_TYPE", "Envelope", "Signature", "read_envelope", "signed_bytes"]

PAYLOAD_TYPE = "application/vnd.in-toto+json"

MOST_SIGNATURES = 100


@dataclass(frozen=True)
class Signature:
    """A signature, and the digest of the public key that it is said to be by, which proves nothing; it may be empty."""

    key_id: str
    value: bytes


@dataclass(frozen=True)
class Envelope:
    """The bytes of a statement with signatures.

    Attributes
    ----------
    payload : bytes
        The statement, byte for byte; nothing in it is read here.
    signatures : tuple of Signature
        One or more of them, but for an envelope that is still to be signed.
    """

    payload: bytes
    signatures: tuple[Signature, ...] = ()

    def is_signed_by(self, key: PublicKey) -> bool:
        """Whether one of the signatures is by this key; those that say so are tried first."""
        message = signed_bytes(self.payload)
        ordered = sorted(self.signatures, key=lambda signature: signature.key_id != key.id)
        return any(key.verifies(signature.value, message) for signature in ordered)

    def signed(self, private: Ed25519PrivateKey) -> Envelope:
        """The same envelope with one more signature.

        Raises
        ------
        InputError
            If it has one by this key already, or as many as it can have.
        """
        key = public_key_of(private)
        if self.is_signed_by(key):
            raise InputError("it is signed by this key already")
        if len(self.signatures) == MOST_SIGNATURES:
            raise InputError(f"it has {MOST_SIGNATURES} signatures already, which is as many as there may be")
        return Envelope(self.payload, (*self.signatures, Signature(key.id, private.sign(signed_bytes(self.payload)))))

    @property
    def text(self) -> str:
        """The envelope as JSON, in ASCII."""
        signatures = [{"keyid": signature.key_id, "sig": _base64(signature.value)} for signature in self.signatures]
        return json.dumps({"payload": _base64(self.payload), "payloadType": PAYLOAD_TYPE, "signatures": signatures}, indent=1) + "\n"


def signed_bytes(payload: bytes) -> bytes:
    """What is signed of a payload: its type and it, each after its length.

    Examples
    --------
    >>> signed_bytes(b"{}")
    b'DSSEv1 28 application/vnd.in-toto+json 2 {}'
    """
    return b"DSSEv1 %d %s %d %s" % (len(PAYLOAD_TYPE), PAYLOAD_TYPE.encode("ascii"), len(payload), payload)


def read_envelope(raw: bytes, name: str = "the attestation") -> Envelope | None:
    """Read an envelope; nothing that is in it is read, and no signature is checked.

    Parameters
    ----------
    raw : bytes
        The bytes of the file.
    name : str
        What messages call it.

    Returns
    -------
    Envelope or None
        None of what is no envelope, such as a statement that is not signed.

    Raises
    ------
    InputError
        If it is an envelope of another form, or no JSON.
    """
    try:
        return _envelope(raw)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _envelope(raw: bytes) -> Envelope | None:
    document = decoded(raw, numbers=False)
    if not isinstance(document, dict) or document.keys().isdisjoint(("payload", "payloadType", "signatures")):
        return None
    object_of(document, "the envelope", ("payload", "payloadType", "signatures"))
    if document["payloadType"] != PAYLOAD_TYPE:
        raise InputError(f"payloadType is {shown(document['payloadType'])}; {PAYLOAD_TYPE!r} is accepted")
    listed = document["signatures"]
    if not isinstance(listed, list) or not 0 < len(listed) <= MOST_SIGNATURES:
        raise InputError(f"signatures is no list of 1 to {MOST_SIGNATURES} signatures")
    return Envelope(_bytes(document["payload"], "payload"), tuple(_signature(entry, f"signatures[{i}]") for i, entry in enumerate(listed)))


def _signature(value: Any, where: str) -> Signature:
    object_of(value, where, ("sig",), ("keyid",))
    key_id, found = value.get("keyid", ""), _bytes(value["sig"], f"{where}.sig")
    if not isinstance(key_id, str) or len(key_id) > LONGEST or not key_id.isprintable():
        raise InputError(f"{where}.keyid is {shown(key_id)}; a text is accepted")
    if len(found) != 64:
        raise InputError(f"{where}.sig has {len(found)} bytes; a signature of Ed25519 has 64")
    return Signature(key_id, found)


def _bytes(value: Any, where: str) -> bytes:
    """Read base64 in the one way in which the bytes are written."""
    if isinstance(value, str) and value.isascii():
        try:
            found = base64.b64decode(value, validate=True)
        except binascii.Error:
            pass
        else:
            if _base64(found) == value:
                return found
    raise InputError(f"{where} is not the base64 of any bytes, in the standard alphabet, with padding and without blanks")


def _base64(value: bytes) -> str:
    return base64.b64encode(value).decode("ascii")
