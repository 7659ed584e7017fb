"""Keys that sign attestations: Ed25519 alone, as PEM. What a private key or its passphrase is, no message says."""

from __future__ import annotations

import base64
import binascii
import contextlib
import os
import re
import secrets
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from fairaudit.errors import InputError
from fairaudit.files import read_bounded

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

__all__ = ["NewKey", "PublicKey", "new_key", "new_passphrase", "public_key_of", "read_private_key", "read_public_key"]

MAX_BYTES = 1 << 16  # of a file that holds a key

LEAST_PASSPHRASE = 20  # characters: PKCS#8 keys are derived from a passphrase so quickly that shorter ones can be guessed

PREFIX = bytes.fromhex("302a300506032b6570032100")  # of an Ed25519 public key as DER (RFC 8410), before its 32 bytes

PRIME = 2**255 - 19

LOW_ORDER = frozenset(
    (
        0,
        1,
        PRIME - 1,
        0x05FC536D880238B13933C6D305ACDFD5F098EFF289F4C345B027B2C28F95E826,
        0x7A03AC9277FDC74EC6CC392CFA53202A0F67100D760B3CBA4FD84D3D706A17C7,
    )
)
"""The y of all points of order 1, 2, 4 and 8: under such a key anybody can sign anything."""


@dataclass(frozen=True)
class PublicKey:
    """A public key.

    Attributes
    ----------
    der : bytes
        Its DER encoding, SubjectPublicKeyInfo.
    """

    der: bytes

    @property
    def id(self) -> str:
        """The SHA-256 of the DER encoding, as `keyid` has it."""
        return sha256(self.der).hexdigest()

    @property
    def pem(self) -> bytes:
        """The key as PEM."""
        return b"-----BEGIN PUBLIC KEY-----\n" + base64.b64encode(self.der) + b"\n-----END PUBLIC KEY-----\n"

    def verifies(self, signature: bytes, message: bytes) -> bool:
        """Whether a signature of a message is by this key."""
        check_extra()
        from cryptography.exceptions import InvalidSignature
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

        try:
            Ed25519PublicKey.from_public_bytes(self.der[len(PREFIX) :]).verify(signature, message)
        except InvalidSignature:
            return False
        return True


@dataclass(frozen=True)
class NewKey:
    """A pair of keys that was just written.

    Attributes
    ----------
    private, public : Path
        Their files.
    id : str
        The digest of the public key.
    encrypted : bool
        Whether a passphrase protects the private one.
    """

    private: Path
    public: Path
    id: str
    encrypted: bool


def check_extra() -> None:
    """Refuse when what signatures need is not installed.

    Raises
    ------
    InputError
        Naming the extra to install.
    """
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise InputError("signatures need cryptography; install fairaudit-certify[sign]") from None


def new_passphrase() -> str:
    """Make a passphrase of 125 random bits.

    Examples
    --------
    >>> len(new_passphrase())
    29
    """
    letters = "abcdefghijkmnpqrstuvwxyz23456789"
    return "-".join("".join(secrets.choice(letters) for _ in range(5)) for _ in range(5))


def new_key(path: str | os.PathLike[str], passphrase: str | None = None) -> NewKey:
    """Make a pair of keys: KEY.pem, which nobody else can read from its first byte on, and KEY.pub.pem.

    Parameters
    ----------
    path : path
        The file of the private key; its name ends in ``.pem``.
    passphrase : str, optional
        What protects it besides, of at least 20 characters.

    Raises
    ------
    InputError
        If a file is there already or cannot be written, or the passphrase is too short.
    """
    check_extra()
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import BestAvailableEncryption, Encoding, NoEncryption, PrivateFormat

    _refuse_content(path)
    private = Path(path)
    if private.suffix != ".pem" or private.name.endswith(".pub.pem"):
        raise InputError(f"{private} is no name for a private key; a name such as key.pem is accepted")
    if passphrase is not None and not LEAST_PASSPHRASE <= len(passphrase) <= 500:
        raise InputError(
            f"the passphrase has {len(passphrase)} characters; {LEAST_PASSPHRASE} to 500 are accepted, as the format makes guessing quick"
        )
    made, public = Ed25519PrivateKey.generate(), private.with_suffix(".pub.pem")
    key = public_key_of(made)
    protection = NoEncryption() if passphrase is None else BestAvailableEncryption(_bytes(passphrase))
    with _created(private, 0o600) as write_private, _created(public, 0o644) as write_public:
        write_private(made.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, protection))
        write_public(key.pem)
    return NewKey(private, public, key.id, passphrase is not None)


@contextlib.contextmanager
def _created(path: Path, mode: int) -> Iterator[Callable[[bytes], object]]:
    """Create a file that was not there, and take it away again if anything fails."""
    made = False
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0), mode)
        made = True
        with os.fdopen(handle, "wb") as file:
            if not mode & 0o077 and _is_open_to_others(os.fstat(handle)):
                raise InputError(f"{path} cannot be kept from others on this file system; name a file elsewhere")
            yield file.write
            file.flush()
            os.fsync(handle)
    except BaseException as error:
        if made:
            with contextlib.suppress(OSError):
                os.unlink(path)
        if isinstance(error, FileExistsError) and not made:
            raise InputError(f"{path} is there already, and no key is written over another; name a file that is not there") from None
        if isinstance(error, (OSError, ValueError)) and not isinstance(error, InputError):
            raise InputError(f"{path} cannot be written: {getattr(error, 'strerror', None) or 'it is no file name'}") from None
        raise


def _refuse_content(path: str | os.PathLike[str]) -> None:
    """Refuse the text of a key where the name of its file is due: no message is to repeat it."""
    if "KEY-----" in os.fspath(path) or "\n" in os.fspath(path).strip():
        raise InputError("what is given is no name of a file, and may be a key itself; give the name of the file that holds it")


def _is_open_to_others(found: os.stat_result) -> bool:
    return os.name == "posix" and bool(found.st_mode & 0o077)


def read_private_key(path: str | os.PathLike[str], passphrase: Callable[[], str]) -> Ed25519PrivateKey:
    """Read a private key, PKCS#8 as PEM, from a file that nobody else can read.

    Parameters
    ----------
    path : path
        The file.
    passphrase : callable
        Gives the passphrase, and is asked only where the key is protected by one.

    Raises
    ------
    InputError
        If it is no such key, others can read it, or the passphrase does not fit.
    """
    check_extra()
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    raw = _read(path, private=True)
    if b"PRIVATE KEY-----" not in raw or not re.match(rb"\s*-----BEGIN (ENCRYPTED )?PRIVATE KEY-----", raw):
        raise InputError(f"{path} is no private key as PEM in the form PKCS#8; `fairaudit attest --new-key` makes one")
    encrypted = b"-----BEGIN ENCRYPTED" in raw
    secret = _bytes(passphrase()) if encrypted else None
    try:
        found = load_pem_private_key(raw, secret)
    except (ValueError, TypeError, UnsupportedAlgorithm):
        why = "the passphrase is not the right one, or the file is damaged" if encrypted else "the file is damaged"
        raise InputError(f"{path} cannot be read as a private key: {why}") from None
    if not isinstance(found, Ed25519PrivateKey):
        raise InputError(f"{path} is a private key of another kind; Ed25519 is accepted")
    return found


def read_public_key(source: str | os.PathLike[str] | bytes) -> PublicKey:
    """Read a public key, SubjectPublicKeyInfo as PEM, from its file or the bytes of that.

    Raises
    ------
    InputError
        If it is none of Ed25519, or one under which anybody can sign.
    """
    raw = source if isinstance(source, bytes) else _read(source, private=False)
    path = "the key" if isinstance(source, bytes) else source
    if b"PRIVATE KEY" in raw:
        raise InputError(f"{path} is a private key, which its holder gives to nobody; give the public one, KEY.pub.pem")
    match = re.fullmatch(rb"\s*-----BEGIN PUBLIC KEY-----([A-Za-z0-9+/=\s]+)-----END PUBLIC KEY-----\s*", raw)
    der = b""
    if match is not None:
        with contextlib.suppress(binascii.Error):
            der = base64.b64decode(b"".join(match[1].split()), validate=True)
    if not der:
        raise InputError(f"{path} is no public key as PEM; one file with one -----BEGIN PUBLIC KEY----- is accepted")
    if not der.startswith(PREFIX) or len(der) != len(PREFIX) + 32:
        raise InputError(f"{path} is no public key of Ed25519, or a damaged one; keys of other kinds are not accepted")
    y = int.from_bytes(der[len(PREFIX) :], "little") & (2**255 - 1)
    if y >= PRIME or y in LOW_ORDER:
        raise InputError(f"{path} is no key that anybody holds: under it anybody can sign; ask the signer for another one")
    return PublicKey(der)


def public_key_of(private: Ed25519PrivateKey) -> PublicKey:
    """The public key of a private one."""
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

    return PublicKey(private.public_key().public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo))


def _read(path: str | os.PathLike[str], *, private: bool) -> bytes:
    """Read the file of a key; that of a private one only where nobody else can."""
    _refuse_content(path)

    def accept(found: os.stat_result, raw: bytes) -> None:
        if private and re.match(rb"\s*-----BEGIN PUBLIC KEY-----", raw) and b"PRIVATE KEY" not in raw:
            raise InputError(f"{path} is a public key, by which everybody checks; sign with the private one")
        if private and _is_open_to_others(found):
            raise InputError(f"{path} can be read by others, so that others may sign with it; `chmod 600` it, or make a new key")

    return read_bounded(path, MAX_BYTES, "key", accept)


def _bytes(passphrase: str) -> bytes:
    return passphrase.encode("utf-8", "surrogateescape")
