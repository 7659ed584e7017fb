"""Signed statements: what others verify, what of others is verified here, and what is read of an envelope."""

from __future__ import annotations

import base64
import json
import subprocess
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, load_der_public_key

from fairaudit.attestations.envelope import Envelope, Signature, read_envelope, signed_bytes
from fairaudit.attestations.keys import new_key, public_key_of, read_private_key
from fairaudit.errors import InputError

PAYLOADS = [b"", b"{}", b"\x00\xff " * 100, '{"a": "\u00e9"}'.encode()]


def never() -> str:
    raise AssertionError("nobody is to be asked")


@pytest.mark.parametrize("payload", PAYLOADS)
def test_what_is_written_is_read_again(payload: bytes) -> None:
    private, other = Ed25519PrivateKey.generate(), Ed25519PrivateKey.generate()
    once = Envelope(payload).signed(private)
    read = read_envelope(once.text.encode())
    assert read == once and read.is_signed_by(public_key_of(private)) and not read.is_signed_by(public_key_of(other))
    both = read.signed(other)
    assert both.is_signed_by(public_key_of(private)) and both.is_signed_by(public_key_of(other)) and both.payload == payload
    with pytest.raises(InputError, match="signed by this key already"):
        both.signed(private)


def test_the_example_of_the_protocol() -> None:
    """The bytes that the DSSE specification prints for "hello world" of another type, with our type in its place."""
    theirs = b"DSSEv1 29 http://example.com/HelloWorld 11 hello world"
    assert signed_bytes(b"hello world") == theirs.replace(b"29 http://example.com/HelloWorld", b"28 application/vnd.in-toto+json")


def test_the_hint_decides_nothing() -> None:
    """A signature counts whatever key it is said to be by, and none does because of what it is said to be by."""
    private, other = Ed25519PrivateKey.generate(), Ed25519PrivateKey.generate()
    key, (good,) = public_key_of(private), Envelope(b"{}").signed(private).signatures
    (bad,) = Envelope(b"{}").signed(other).signatures
    for name in ("", "0" * 64, public_key_of(other).id, "anything"):
        assert Envelope(b"{}", (Signature(name, good.value),)).is_signed_by(key)
        assert Envelope(b"{}", (Signature(key.id, bad.value), Signature(name, good.value))).is_signed_by(key)
        assert not Envelope(b"{}", (Signature(key.id, bad.value), Signature(name, bad.value))).is_signed_by(key)
    assert read_envelope(
        json.dumps(json.loads(Envelope(b"{}", (good,)).text) | {"signatures": [{"sig": base64.b64encode(good.value).decode()}]}).encode()
    )


@pytest.mark.parametrize("payload", PAYLOADS[1:])
def test_securesystemslib_verifies_ours_and_we_verify_theirs(payload: bytes) -> None:
    dsse = pytest.importorskip("securesystemslib.dsse", reason="securesystemslib is not installed (it is in the extra test)")
    signer = pytest.importorskip("securesystemslib.signer")
    exceptions = pytest.importorskip("securesystemslib.exceptions")
    private = Ed25519PrivateKey.generate()
    key = public_key_of(private)
    theirs = signer.SSlibKey.from_crypto(load_der_public_key(key.der), keyid=key.id)
    text = Envelope(payload).signed(private).text
    found = dsse.Envelope.from_dict(json.loads(text))
    assert found.payload == payload and found.pae() == signed_bytes(payload)
    assert list(found.verify([theirs], 1)) == [key.id]
    altered = dsse.Envelope.from_dict(json.loads(text) | {"payload": base64.b64encode(payload + b" ").decode()})
    with pytest.raises(exceptions.VerificationError):
        altered.verify([theirs], 1)

    made = dsse.Envelope(payload, "application/vnd.in-toto+json", {})
    made.sign(signer.CryptoSigner(private, theirs))
    read = read_envelope(json.dumps(made.to_dict()).encode())
    assert read is not None and read.payload == payload and read.is_signed_by(key)


def test_openssl_verifies_ours(tmp_path: Path) -> None:
    made = new_key(tmp_path / "key.pem")
    envelope = Envelope(b'{"_type": "x"}').signed(read_private_key(made.private, never))
    (tmp_path / "signed").write_bytes(b'DSSEv1 28 application/vnd.in-toto+json 14 {"_type": "x"}')
    (tmp_path / "sig").write_bytes(envelope.signatures[0].value)
    words = ["openssl", "pkeyutl", "-verify", "-rawin", "-pubin", "-inkey", str(made.public), "-sigfile", str(tmp_path / "sig")]
    try:
        for content, code in ((b"", 0), (b" ", 1)):
            (tmp_path / "message").write_bytes((tmp_path / "signed").read_bytes() + content)
            found = subprocess.run([*words, "-in", str(tmp_path / "message")], capture_output=True, check=False)
            assert found.returncode == code, found.stderr
    except FileNotFoundError:
        pytest.skip("openssl is not installed")


def test_a_statement_is_no_envelope() -> None:
    assert [read_envelope(text) for text in (b"{}", b'{"_type": 1}', b"[]", b"1", b'"payload"')] == [None] * 5


def test_what_an_envelope_says_wrongly_is_refused() -> None:
    good = json.loads(Envelope(b"{}").signed(Ed25519PrivateKey.generate()).text)
    (signature,) = good["signatures"]
    wrong = [
        *({key: value for key, value in good.items() if key != left} for left in good),
        *(good | {key: value} for key in good for value in (None, True, 7, 1.5, "!", [], {}, [1], [[]], good)),
        *(good | {"payload": text} for text in ("e30", "e30==", "e3 0=", "e31=", "e30=\n", "\u0435e30", 1234, 12341234)),
        *(good | {"signatures": [value]} for value in (None, {}, {"sig": 7}, signature | {"more": 1}, signature | {"sig": "AAAA"})),
        *(good | {"signatures": [signature | {"keyid": value}]} for value in (None, 7, "\x1b[31m", "a" * 5000)),
        good | {"signatures": [signature] * 101},
        good | {"more": 1},
        good | {"payloadType": "application/vnd.in-toto+json "},
        good | {"payloadType": "text/plain"},
    ]
    texts = [json.dumps(each).encode() for each in wrong if each != good]
    text = json.dumps(good).encode()
    texts += [b"", b"{", b"\xff", b"\xef\xbb\xbf" + text, text * 2, text.replace(b'"payload":', b'"payload": "", "payload":')]
    texts += [b"[" * 200_000, b'{"payload":' * 50_000, text + b" " * (1 << 24), text.replace(b'"e30="', b"9" * 100_000)]
    for each in texts:
        with pytest.raises(InputError) as found:
            read_envelope(each, "a.json")
        assert str(found.value).startswith("a.json: ") and len(str(found.value)) < 300


def test_blanks_around_an_envelope_change_nothing_that_was_signed() -> None:
    private = Ed25519PrivateKey.generate()
    envelope = Envelope(b"{}").signed(private)
    for text in (
        json.dumps(json.loads(envelope.text), indent=7),
        json.dumps(json.loads(envelope.text), separators=(",", ":")),
        f" {envelope.text}\n\n",
    ):
        assert read_envelope(text.encode()) == envelope


def test_nothing_of_a_private_key_is_in_an_envelope() -> None:
    private = Ed25519PrivateKey.generate()
    raw = private.private_bytes(Encoding.Raw, PrivateFormat.Raw, NoEncryption())
    text = Envelope(b"{}").signed(private).text
    assert raw.hex() not in text and base64.b64encode(raw).decode() not in text
