"""A certificate with its attestation: true ones pass, and of thousands that were altered none does."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from attested import altered, places, statement_of
from cryptography.hazmat.primitives.asymmetric import ec, ed448, rsa, x25519
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

import fairaudit as fa
from fairaudit import checker
from fairaudit.attestations.envelope import PAYLOAD_TYPE, Envelope, Signature
from fairaudit.attestations.keys import PREFIX, NewKey, PublicKey, new_key, read_private_key
from fairaudit.attestations.statement import read_statement
from fairaudit.attestations.verification import signed_by
from fairaudit.cli import main

TABLE = {"hired": ["yes", "no", "yes", "no", "yes"], "sex": ["f", "f", "m", "m", None], "n": [30, 10, 20, 20, 7]}


@dataclass(frozen=True)
class Case:
    """A certificate, what is attested of it, and who signed that."""

    certificate: Path
    statement: dict[str, Any]
    key: NewKey
    report: checker.Report

    @property
    def payload(self) -> bytes:
        return json.dumps(self.statement, indent=1).encode() + b"\n"

    @property
    def envelope(self) -> Envelope:
        return signed(self.payload, self.key)

    def code(self, raw: bytes, key: Path | None = None, other: Path | None = None) -> int:
        """What `verify` exits with for an attestation with a key, of this certificate, which was checked once, or of another one."""
        certificate = (other or self.certificate).read_bytes()
        report = self.report if other is None else checker.check(certificate)
        try:
            found = checker.check_attestation(signed_by(raw, key or self.key.public), certificate, report)
        except (fa.InputError, checker.NotAnAttestation):
            return 2
        return 0 if found.ok else 1


def never() -> str:
    raise AssertionError("nobody is to be asked")


def signed(payload: bytes, *keys: NewKey) -> Envelope:
    found = Envelope(payload)
    for key in keys:
        found = found.signed(read_private_key(key.private, never))
    return found


def certified(path: Path, **changes: Any) -> Path:
    fa.audit(TABLE | changes, decision="hired", group="sex", count="n", utility="yes", confidence=None, missing="drop").save(path)
    return path


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    folder = tmp_path_factory.mktemp("attested")
    path = certified(folder / "certificate.json")
    return Case(path, statement_of(path), new_key(folder / "key.pem"), checker.check(path.read_bytes()))


def given(case: Case, tmp_path: Path, raw: bytes) -> list[str]:
    path = tmp_path / "attestation.json"
    path.write_bytes(raw)
    return ["verify", str(case.certificate), "--attestation", str(path)]


def test_a_signed_attestation_is_true_by_the_key_of_its_signer(case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    raw = case.envelope.text.encode()
    words = given(case, tmp_path, raw)
    assert case.code(raw) == main([*words, "--key", str(case.key.public)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"It is signed by the key {case.key.id}, and unaltered since." in said and "no signature shows" in said
    found = fa.verify(case.certificate, attestation=tmp_path / "attestation.json", key=case.key.public)
    assert found.ok and found.exit_code == 0 and found.attestation is not None and found.attestation.signature == "checked"
    assert found.sentence.endswith("; of the attestation all 8 statements are true")
    assert fa.verify(case.certificate, attestation=raw, key=case.key.public) == found


def test_without_the_key_a_signature_is_not_checked(case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    raw = case.envelope.text.encode()
    assert main(given(case, tmp_path, raw)) == 3
    assert "signature was NOT checked" in " ".join(capsys.readouterr().out.split())
    found = fa.verify(case.certificate, attestation=raw)
    assert not found and found.exit_code == 3 and found.false == () and found.sentence.endswith(", its signature was not checked")
    with pytest.raises(fa.FalseCertificate, match="its signature was not checked"):
        found.require()


def test_one_that_is_not_signed_is_true_without_a_key_and_false_with_one(
    case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = given(case, tmp_path, case.payload)
    assert main(words) == 0 and main([*words, "--key", str(case.key.public)]) == 1
    said = capsys.readouterr().out
    assert f"FALSE  the attestation is signed by the key {case.key.id} (it is not signed at all)" in said
    assert " ".join(said.split()).endswith("this certificate. The file is not signed; did you mean the envelope (.dsse.json)?")
    assert fa.verify(case.certificate, attestation=case.payload).ok
    found = fa.verify(case.certificate, attestation=case.payload, key=case.key.public)
    assert (found.ok, found.exit_code, len(found.false)) == (False, 1, 1)


def test_a_false_statement_is_false_however_well_it_is_signed(case: Case, tmp_path: Path) -> None:
    for path, value in (
        (("subject", 0, "digest", "sha256"), "0" * 64),
        (("predicate", "table", "sha256"), "0" * 64),
        (("predicate", "rows", "counted"), 81),
        (("predicate", "rows", "read"), 86),
        (("predicate", "rows", "dropped"), {}),
    ):
        wrong = signed(json.dumps(altered(case.statement, path, lambda _, value=value: value)).encode(), case.key)
        assert case.code(wrong.text.encode()) == 1
        assert main([*given(case, tmp_path, wrong.text.encode()), "--quiet"]) == 1


def test_any_of_several_signers_may_be_asked_for(case: Case, tmp_path: Path) -> None:
    other, third = new_key(tmp_path / "other.pem"), new_key(tmp_path / "third.pem")
    raw = signed(case.payload, case.key, other).text.encode()
    assert [case.code(raw, key.public) for key in (case.key, other, third)] == [0, 0, 1]


def test_what_makes_no_sense_together_is_refused(case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    certificate, key = str(case.certificate), str(case.key.public)
    for words in (["--key", key], ["--attestation", key], ["--attestation", str(tmp_path)], ["--attestation", "nowhere", "--key", key]):
        assert main(["verify", certificate, *words]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1
    for options in (
        {"key": key},
        {"attestation": "nowhere"},
        {"attestation": b""},
        {"attestation": b"{}", "key": "nowhere"},
        {"attestation": 7},
    ):
        with pytest.raises(fa.InputError):
            fa.verify(certificate, **options)


def test_a_page_is_another_file(case: Case, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    fa.report(case.certificate, page)
    raw = case.envelope.text.encode()
    assert not fa.verify(page, attestation=raw, key=case.key.public)
    both = case.statement | {"subject": [*case.statement["subject"], *statement_of_file(page)]}
    raw = signed(json.dumps(both).encode(), case.key).text.encode()
    assert fa.verify(page, attestation=raw, key=case.key.public) and fa.verify(case.certificate, attestation=raw, key=case.key.public)


def statement_of_file(path: Path) -> list[dict[str, Any]]:
    from hashlib import sha256

    return [{"name": path.name, "digest": {"sha256": sha256(path.read_bytes()).hexdigest()}}]


# Whatever is altered


def with_payload(case: Case, payload: bytes) -> bytes:
    """Another statement under the same signature."""
    return Envelope(payload, case.envelope.signatures).text.encode()


def altered_payloads(case: Case) -> Iterator[bytes]:
    """A bit of each byte; each value by another one; other blanks; a key twice."""
    payload = case.payload
    for i in range(len(payload)):
        yield with_payload(case, payload[:i] + bytes([payload[i] ^ 1 << i % 8]) + payload[i + 1 :])
    for path, value in places(case.statement):
        for other in (None, True, 0, 8, -1, 0.5, "", "0" * 64, [], {}, [value], {"a": value}):
            if json.dumps(other) != json.dumps(value):
                yield with_payload(case, json.dumps(altered(case.statement, path, lambda _, other=other: other), indent=1).encode() + b"\n")
    for form in ({"indent": 2}, {"separators": (",", ":")}, {"sort_keys": True}, {}):
        yield with_payload(case, json.dumps(case.statement, **form).encode())
    for text in (
        payload + b"\n",
        payload[:-1],
        b" " + payload,
        b"\xef\xbb\xbf" + payload,
        payload.replace(b"\n", b"\r\n"),
        payload * 2,
        b"",
    ):
        yield with_payload(case, text)
    for name in (b'"title"', b'"counted"', b'"subject"', b'"sha256"'):
        yield with_payload(case, payload.replace(name, name + b": 1, " + name, 1))


def altered_envelopes(case: Case) -> Iterator[bytes]:
    """Each bit of the signature; other types; the signature of something else; base64 in other spellings."""
    (signature,) = case.envelope.signatures
    for i in range(512):
        value = bytearray(signature.value)
        value[i // 8] ^= 1 << i % 8
        yield Envelope(case.payload, (Signature(signature.key_id, bytes(value)),)).text.encode()
    order = 2**252 + 27742317777372353535851937790883648493
    s = int.from_bytes(signature.value[32:], "little")
    for k in range(1, 15):
        yield Envelope(case.payload, (Signature("", signature.value[:32] + (s + k * order).to_bytes(32, "little")),)).text.encode()
    private = read_private_key(case.key.private, never)
    for message in (case.payload, base64.b64encode(case.payload), b"DSSEv1 28 application/vnd.in-toto+json 0 ", PAYLOAD_TYPE.encode()):
        yield Envelope(case.payload, (Signature(signature.key_id, private.sign(message)),)).text.encode()
    document = json.loads(case.envelope.text)
    text, payload, sig = case.envelope.text.encode(), document["payload"], document["signatures"][0]["sig"]
    for name in (
        "application/json",
        "",
        "application/vnd.in-toto+json ",
        "Application/vnd.in-toto+json",
        "text/plain",
        None,
        7,
        [PAYLOAD_TYPE],
    ):
        yield json.dumps(document | {"payloadType": name}).encode()
    for spelled in (
        payload + "\n",
        payload[:-4] + " " + payload[-4:],
        payload + "=",
        payload.rstrip("=") or "",
        f"\ufeff{payload}",
        payload[:-4],
    ):
        if spelled != payload:
            yield json.dumps(document | {"payload": spelled}).encode()
    for spelled in (
        sig.rstrip("="),
        sig + "=",
        sig.replace("==", "=A"),
        sig[:-3] + chr(ord(sig[-3]) + 1) + "==",
        sig[:40],
        "",
        sig + sig,
        None,
        [sig],
    ):
        yield json.dumps(document | {"signatures": [{"keyid": signature.key_id, "sig": spelled}]}).encode()
    for listed in ([], None, {}, [None], document["signatures"] * 101, [[]], document["signatures"][0]):
        yield json.dumps(document | {"signatures": listed}).encode()
    for name in document:
        yield json.dumps({key: value for key, value in document.items() if key != name}).encode()
        yield text.replace(f'"{name}":'.encode(), f'"{name}": {json.dumps(document[name])}, "{name}":'.encode(), 1)
        yield json.dumps(document | {name.upper(): 1}).encode()
    yield from (text[:-20], text * 2, text + b"\0", b"[" + text + b"]", b"", b"[" * 100_000, b'{"a":' * 100_000, text + b" " * (1 << 24))
    yield from (
        json.dumps(case.statement | document).encode(),
        json.dumps({"payload": case.statement} | document | case.statement).encode(),
    )
    yield Envelope(case.envelope.text.encode(), case.envelope.signatures).text.encode()
    yield case.payload


def altered_keys(case: Case, folder: Path) -> Iterator[Path]:
    """Each bit of the key; keys of others; keys of other kinds; the private one."""
    der = case.key.public.read_bytes().splitlines()[1]
    raw = base64.b64decode(der)

    def written(content: bytes) -> Path:
        path = folder / "altered.pem"
        path.write_bytes(content)
        return path

    for i in range(8 * len(raw)):
        bits = bytearray(raw)
        bits[i // 8] ^= 1 << i % 8
        yield written(PublicKey(bytes(bits)).pem)
    for i in range(20):
        yield new_key(folder / f"{i}.pem").public
    makers: list[Callable[[], Any]] = [
        lambda: rsa.generate_private_key(65537, 2048),
        lambda: ec.generate_private_key(ec.SECP256R1()),
        x25519.X25519PrivateKey.generate,
        ed448.Ed448PrivateKey.generate,
    ]
    for make in makers:
        yield written(make().public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo))
    yield case.key.private
    yield from (
        written(PREFIX + raw[-32:]),
        written(b""),
        written(PublicKey(PREFIX + bytes(32)).pem),
        written(case.key.public.read_bytes() * 2),
    )


def test_of_thousands_that_were_altered_none_is_accepted(case: Case, tmp_path: Path) -> None:
    good = case.envelope.text.encode()
    assert case.code(good) == 0
    tried = 0
    for raw in (*altered_payloads(case), *altered_envelopes(case)):
        tried += 1
        assert case.code(raw) != 0, raw[:3000]
    for path in altered_keys(case, tmp_path):
        tried += 1
        assert case.code(good, path) != 0, path.read_bytes()
    for i in range(40):  # of other tables, under the same key
        other = certified(tmp_path / f"{i}.json", n=[31 + i, 10, 20, 20, 7])
        raw = signed(json.dumps(statement_of(other)).encode(), case.key).text.encode()
        assert case.code(raw, other=other) == 0
        tried += 3
        assert case.code(raw) == 1
        assert case.code(good, other=other) == 1
        named = altered(statement_of(other), ("subject", 0), lambda _: case.statement["subject"][0])
        assert case.code(signed(json.dumps(named).encode(), case.key).text.encode()) == 1  # this file, that table
    assert tried >= 2000, tried


def test_the_command_refuses_what_the_functions_refuse(case: Case, tmp_path: Path) -> None:
    """One of every hundred of them, by the command itself, in both ways of giving a key."""
    found = [*altered_payloads(case), *altered_envelopes(case)][::100]
    for raw in found:
        assert main([*given(case, tmp_path, raw), "--key", str(case.key.public), "--quiet"]) == case.code(raw) != 0
    assert len(found) > 20


def test_bytes_that_were_not_verified_are_never_read(case: Case) -> None:
    """Under a wrong signature a payload that cannot be read is as false as any other: nobody looked at it."""
    for payload in (b"\xff", b"{", b"[" * 100_000, case.payload + b" "):
        assert case.code(with_payload(case, payload)) == 1
        assert case.code(signed(payload, case.key).text.encode()) == (2 if payload != case.payload + b" " else 0)


# Two readers

HOSTILE: tuple[Any, ...] = (
    *({str(i): 1 for i in range(count)} for count in (100, 101)),
    *(
        None,
        True,
        0,
        8,
        -1,
        10**17,
        10**18,
        10**30,
        0.5,
        "",
        " ",
        "\t",
        "x",
        "a/b",
        "5/2",
        "4/2",
        "1" + "0" * 18,
        "9" * 18,
        "0",
        "\x85",
        "\ud800",
    ),
    *(
        "\u202e",
        "a" * 4096,
        "a" * 4097,
        [],
        {},
        ["x"],
        {"x": "y"},
        "A" * 64,
        "0" * 64,
        "2025-12-31",
        "2025-1-31",
        "2025-02-30",
        "２０２５-01-01",
    ),
    *(
        "2026-01-15T24:00:00Z",
        "2026-01-15T09:00:60Z",
        "2026-01-15t09:00:00z",
        {"name": "x"},
        json.loads("[" * 12 + "]" * 12),
        json.loads("[" * 9 + "]" * 9),
    ),
)


def test_the_writers_reader_and_the_checkers_accept_the_same(case: Case) -> None:
    """They share no code: what one refuses, the other refuses, wherever in a statement it stands."""
    certificate, seen = case.certificate.read_bytes(), {True: 0, False: 0}
    for path, value in places(case.statement):
        more = [value | {"more": 1}, {"": "", **value}] if isinstance(value, dict) else []
        for other in (*HOSTILE, *more):
            raw = json.dumps(altered(case.statement, path, lambda _, other=other: other)).encode()
            accepted = []
            for reader in (lambda raw: checker.check_attestation(raw, certificate, case.report), read_statement):
                try:
                    reader(raw)
                    accepted.append(True)
                except (fa.InputError, checker.NotAnAttestation):
                    accepted.append(False)
            assert accepted[0] == accepted[1], (path, other)
            seen[accepted[0]] += 1
    assert min(seen.values()) > 200
