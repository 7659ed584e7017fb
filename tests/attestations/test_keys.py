"""Keys: written where nobody else reads them, read only where nobody else can, and never said aloud."""

from __future__ import annotations

import base64
import os
import re
import stat
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric import ec, ed448, rsa, x25519
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey
from cryptography.hazmat.primitives.serialization import BestAvailableEncryption, Encoding, NoEncryption, PrivateFormat, PublicFormat
from needs import POSIX

from fairaudit.attestations.keys import (
    LOW_ORDER,
    PREFIX,
    PRIME,
    PublicKey,
    new_key,
    new_passphrase,
    public_key_of,
    read_private_key,
    read_public_key,
)
from fairaudit.cli import main
from fairaudit.errors import InputError

LONG = "correct horse battery staple"


def never() -> str:
    raise AssertionError("nobody is to be asked")


@pytest.fixture(params=[0o000, 0o022, 0o077])
def umask(request: pytest.FixtureRequest) -> Iterator[int]:
    before = os.umask(request.param)
    yield request.param
    os.umask(before)


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.skipif(os.name != "posix", reason="rights of files are those of POSIX")
def test_a_private_key_is_for_its_owner_alone(umask: int, tmp_path: Path) -> None:
    made = new_key(tmp_path / "key.pem")
    assert (mode(made.private), mode(made.public)) == (0o600, 0o644 & ~umask)
    assert public_key_of(read_private_key(made.private, never)) == read_public_key(made.public)


@pytest.mark.skipif(os.name != "posix", reason="rights of files are those of POSIX")
def test_it_is_so_from_the_first_byte_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the file is when it appears, and whenever it is looked at while it is written: nothing is ever there for others."""
    seen: list[tuple[str, int, int]] = []
    opened, synced = os.open, os.fsync

    def look() -> None:
        seen.extend((path.name, mode(path), path.stat().st_size) for path in tmp_path.iterdir() if not path.name.endswith(".pub.pem"))

    def open_and_look(*args: object, **kwargs: object) -> int:
        handle: int = opened(*args, **kwargs)  # type: ignore[arg-type]
        look()
        return handle

    def sync_and_look(handle: int) -> None:
        look()
        synced(handle)

    monkeypatch.setattr(os, "open", open_and_look)
    monkeypatch.setattr(os, "fsync", sync_and_look)
    before = os.umask(0)
    try:
        new_key(tmp_path / "key.pem")
    finally:
        os.umask(before)
    assert {(name, rights) for name, rights, _ in seen} == {("key.pem", 0o600)}
    assert seen[0][2] == 0 and seen[-1][2] > 0


@pytest.mark.parametrize("there", ["key.pem", "key.pub.pem"])
@pytest.mark.parametrize("kind", ["file", "link", "dangling link", "folder"])
def test_nothing_is_written_over(there: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "other").write_text("mine")
    path = tmp_path / there
    if kind == "file":
        path.write_text("mine")
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to(tmp_path / ("other" if kind == "link" else "nowhere"))
    with pytest.raises(InputError, match=f"{there} is there already"):
        new_key(tmp_path / "key.pem")
    assert {each.name for each in tmp_path.iterdir()} == {there, "other"}
    assert (tmp_path / "other").read_text() == "mine"


def test_of_many_at_once_one_makes_the_key(tmp_path: Path) -> None:
    made: list[str] = []
    refused: list[str] = []
    ready = threading.Barrier(16)

    def make() -> None:
        ready.wait()
        try:
            made.append(new_key(tmp_path / "key.pem").id)
        except InputError as error:
            refused.append(str(error))

    threads = [threading.Thread(target=make) for _ in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1 and len(refused) == 15 and all("is there already" in text for text in refused)
    assert read_public_key(tmp_path / "key.pub.pem").id == made[0] == public_key_of(read_private_key(tmp_path / "key.pem", never)).id


def test_a_key_that_cannot_be_finished_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left"):
        new_key(tmp_path / "key.pem")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["key", "key.txt", "key.pub.pem", "nowhere/key.pem", "a\0.pem"])
def test_names_that_are_none(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        new_key(tmp_path / name)


@pytest.mark.skipif(os.name != "posix", reason="rights of files are those of POSIX")
@pytest.mark.parametrize("rights", [0o640, 0o604, 0o644, 0o660, 0o620, 0o601])
def test_a_key_that_others_can_touch_is_not_used(rights: int, tmp_path: Path) -> None:
    made = new_key(tmp_path / "key.pem")
    made.private.chmod(rights)
    with pytest.raises(InputError, match="can be read by others"):
        read_private_key(made.private, never)


def test_a_passphrase_protects_a_key(tmp_path: Path) -> None:
    made = new_key(tmp_path / "key.pem", LONG)
    assert made.encrypted and b"BEGIN ENCRYPTED PRIVATE KEY" in made.private.read_bytes()
    assert public_key_of(read_private_key(made.private, lambda: LONG)).id == made.id
    for wrong in ("", LONG + " ", "x" * 5000, "\udcff"):
        with pytest.raises(InputError, match="the passphrase is not the right one") as found:
            read_private_key(made.private, lambda wrong=wrong: wrong)
        assert found.value.__suppress_context__ and (not wrong or wrong not in str(found.value))


@pytest.mark.parametrize("short", ["", "secret", "x" * 19, "x" * 501])
def test_a_passphrase_that_can_be_guessed_is_refused(short: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="20 to 500") as found:
        new_key(tmp_path / "key.pem", short)
    assert (not short or short not in str(found.value)) and list(tmp_path.iterdir()) == []


def test_passphrases_that_are_made_differ_and_are_long() -> None:
    made = {new_passphrase() for _ in range(1000)}
    assert len(made) == 1000 and all(re.fullmatch("([a-km-np-z2-9]{5}-){4}[a-km-np-z2-9]{5}", text) for text in made)
    assert len(set("".join(made)) - {"-"}) == 32


def pem_of(make: Callable[[], object]) -> Callable[[Path], bytes]:
    return lambda _: make().public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)  # type: ignore[attr-defined, no-any-return]


def wrapped(der: bytes, label: str = "PUBLIC KEY") -> bytes:
    return f"-----BEGIN {label}-----\n{base64.b64encode(der).decode()}\n-----END {label}-----\n".encode()


OTHERS: dict[str, Callable[[Path], bytes]] = {
    "RSA": pem_of(lambda: rsa.generate_private_key(65537, 2048)),
    "EC": pem_of(lambda: ec.generate_private_key(ec.SECP256R1())),
    "X25519": pem_of(x25519.X25519PrivateKey.generate),
    "Ed448": pem_of(ed448.Ed448PrivateKey.generate),
    "a private key": lambda path: path.with_name("key.pem").read_bytes(),
    "a private key after the public one": lambda path: path.read_bytes() + path.with_name("key.pem").read_bytes(),
    "two keys": lambda path: path.read_bytes() * 2,
    "DER": lambda path: read_public_key(path).der,
    "raw bytes": lambda path: read_public_key(path).der[-32:],
    "a byte less": lambda path: wrapped(read_public_key(path).der[:-1]),
    "a byte more": lambda path: wrapped(read_public_key(path).der + b"\0"),
    "a certificate": lambda path: wrapped(read_public_key(path).der, "CERTIFICATE"),
    "text before it": lambda path: b"Trust me\n" + path.read_bytes(),
    "bad base64": lambda path: path.read_bytes().replace(b"MCow", b"M*ow"),
    "nothing": lambda _: b"",
    "a long file": lambda path: path.read_bytes() + b"\n" * (1 << 17),
    "OpenSSH": lambda _: Ed25519PrivateKey.generate().public_key().public_bytes(Encoding.OpenSSH, PublicFormat.OpenSSH),
    "a number beyond the field": lambda _: wrapped(PREFIX + (PRIME + 3).to_bytes(32, "little")),
}
WEAK = [(y | sign << 255).to_bytes(32, "little") for y in sorted(LOW_ORDER) for sign in (0, 1)]
OTHERS |= {f"low order {i}": lambda _, raw=raw: wrapped(PREFIX + raw) for i, raw in enumerate(WEAK)}


@pytest.mark.parametrize("make", OTHERS.values(), ids=OTHERS)
def test_what_is_no_public_key_of_ed25519_is_refused(make: Callable[[Path], bytes], tmp_path: Path) -> None:
    path = tmp_path / "other.pem"
    path.write_bytes(make(new_key(tmp_path / "key.pem").public))
    with pytest.raises(InputError) as found:
        read_public_key(path)
    secret = [line for line in (tmp_path / "key.pem").read_text().splitlines() if not line.startswith("-")]
    assert all(line not in str(found.value) for line in secret)


def test_a_key_with_other_ends_of_lines_is_the_same(tmp_path: Path) -> None:
    path = new_key(tmp_path / "key.pem").public
    other = tmp_path / "windows.pem"
    other.write_bytes(b"\n" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert read_public_key(other) == read_public_key(path)


def added(one: tuple[int, int], other: tuple[int, int]) -> tuple[int, int]:
    """The sum of two points of the curve of RFC 8032."""
    d = -121665 * pow(121666, -1, PRIME) % PRIME
    (x1, y1), (x2, y2) = one, other
    t = d * x1 * x2 * y1 * y2 % PRIME
    return (x1 * y2 + x2 * y1) * pow(1 + t, -1, PRIME) % PRIME, (y1 * y2 + x1 * x2) * pow(1 - t, -1, PRIME) % PRIME


def test_the_points_of_low_order_are_these() -> None:
    """Eight times each is the neutral point, and of the eight points there are five different y."""
    d, root = -121665 * pow(121666, -1, PRIME) % PRIME, pow(2, (PRIME - 1) // 4, PRIME)
    points = set()
    for y in LOW_ORDER:
        square = (y * y - 1) * pow(d * y * y + 1, -1, PRIME) % PRIME
        x = pow(square, (PRIME + 3) // 8, PRIME)
        x = x if x * x % PRIME == square else x * root % PRIME
        assert x * x % PRIME == square
        points |= {(x, y), (-x % PRIME, y)}
    assert len(points) == 8
    for point in points:
        doubled = point
        for _ in range(3):
            doubled = added(doubled, doubled)
        assert doubled == (0, 1)


def test_under_the_neutral_point_anybody_signs_which_is_why_it_is_refused() -> None:
    """What cryptography accepts: R = A = the neutral point and S = 0, for every message."""
    neutral = (1).to_bytes(32, "little")
    Ed25519PublicKey.from_public_bytes(neutral).verify(neutral + bytes(32), b"anything")


def test_a_signature_has_one_spelling() -> None:
    """S + L is refused by cryptography, as RFC 8032 has it, and so is a point beyond the field."""
    private = Ed25519PrivateKey.generate()
    key, message = public_key_of(private), b"message"
    signature = private.sign(message)
    order = 2**252 + 27742317777372353535851937790883648493
    s = int.from_bytes(signature[32:], "little")
    assert key.verifies(signature, message)
    for k in range(1, 15):
        assert not key.verifies(signature[:32] + (s + k * order).to_bytes(32, "little"), message)
    for size in (0, 63, 65, 128):
        assert not key.verifies((signature * 2)[:size], message)


PRIVATE: dict[str, Callable[[], bytes]] = {
    "RSA": lambda: rsa.generate_private_key(65537, 2048).private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()),
    "EC": lambda: ec.generate_private_key(ec.SECP256R1()).private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()),
    "traditional EC": lambda: ec.generate_private_key(ec.SECP256R1()).private_bytes(
        Encoding.PEM, PrivateFormat.TraditionalOpenSSL, NoEncryption()
    ),
    "X25519": lambda: x25519.X25519PrivateKey.generate().private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()),
    "OpenSSH": lambda: Ed25519PrivateKey.generate().private_bytes(Encoding.PEM, PrivateFormat.OpenSSH, NoEncryption()),
    "a public key": lambda: Ed25519PrivateKey.generate().public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo),
    "damaged": lambda: (
        Ed25519PrivateKey.generate().private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()).replace(b"MC4C", b"MC5C")
    ),
    "another kind, protected": lambda: ec.generate_private_key(ec.SECP256R1()).private_bytes(
        Encoding.PEM, PrivateFormat.PKCS8, BestAvailableEncryption(LONG.encode())
    ),
    "nothing": lambda: b"",
    "cut off": lambda: b"-----BEGIN PRIVATE KEY-----\n",
}


@pytest.mark.parametrize("make", PRIVATE.values(), ids=PRIVATE)
def test_what_is_no_private_key_of_ed25519_is_refused(make: Callable[[], bytes], tmp_path: Path) -> None:
    path = tmp_path / "key.pem"
    path.touch(0o600)
    path.write_bytes(make())
    with pytest.raises(InputError) as found:
        read_private_key(path, lambda: LONG)
    assert found.value.__suppress_context__ or found.value.__context__ is None
    for line in path.read_text().splitlines():
        assert line.startswith("-") or line not in str(found.value)


def test_openssl_reads_our_keys(tmp_path: Path) -> None:
    made = new_key(tmp_path / "key.pem", LONG)
    try:
        words = ["openssl", "pkey", "-in", str(made.private), "-passin", "stdin", "-pubout"]
        found = subprocess.run(words, input=LONG.encode(), capture_output=True, check=True)
    except FileNotFoundError:
        pytest.skip("openssl is not installed")
    assert found.stdout == made.public.read_bytes() == read_public_key(made.public).pem


def test_without_cryptography_one_sentence_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "cryptography", None)
    for act in (
        lambda: new_key(tmp_path / "key.pem"),
        lambda: read_private_key(tmp_path / "key.pem", never),
        lambda: PublicKey(PREFIX + bytes(32)).verifies(bytes(64), b""),
    ):
        with pytest.raises(InputError, match=r"fairaudit-certify\[sign\]"):
            act()
    assert main(["attest", "--new-key", str(tmp_path / "key.pem")]) == 2
    assert list(tmp_path.iterdir()) == []


@POSIX
def test_a_key_may_come_through_a_pipe_that_is_its_owners_alone(tmp_path: Path) -> None:
    """As from a password manager: `--sign-key <(pass show key)`."""
    made = new_key(tmp_path / "key.pem")
    for rights, fits in ((0o600, True), (0o644, False)):
        pipe = tmp_path / f"{rights}"
        os.mkfifo(pipe)
        pipe.chmod(rights)

        def feed(pipe: Path = pipe) -> None:
            with suppress(BrokenPipeError):
                pipe.write_bytes(made.private.read_bytes())

        feeding = threading.Thread(target=feed)
        feeding.start()
        if fits:
            assert public_key_of(read_private_key(pipe, never)).id == made.id
        else:
            with pytest.raises(InputError, match="can be read by others"):
                read_private_key(pipe, never)
        feeding.join(1)
