"""`attest` on the command line: keys are made, statements signed, and nothing secret is printed."""

from __future__ import annotations

import json
import os
import re
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from attested import statement_of
from envelopes import envelope

import fairaudit as fa
from fairaudit.attestations.envelope import read_envelope
from fairaudit.attestations.keys import read_public_key
from fairaudit.cli import main

LONG = "correct horse battery staple"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FAIRAUDIT_KEY_PASSPHRASE", raising=False)
    table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    fa.audit(table, decision="hired", group="sex", utility="yes", confidence=None).save("certificate.json")
    Path("a.json").write_text(json.dumps(statement_of(Path("certificate.json"))))


def secrets_of(path: str) -> list[str]:
    return [line for line in Path(path).read_text().splitlines() if not line.startswith("-")]


def test_from_a_key_to_a_signed_attestation(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["attest", "--new-key", "key.pem"]) == 0
    assert main(["attest", "a.json", "--sign-key", "key.pem"]) == 0
    said = "".join(capsys.readouterr())
    assert read_public_key("key.pub.pem").id in said and all(line not in said for line in secrets_of("key.pem"))
    command = re.search(r"To check it: fairaudit (.*)", said)
    assert command is not None and command[1] == "verify certificate.json --attestation a.dsse.json --key key.pub.pem"
    assert main(command[1].split()) == 0
    found = read_envelope(Path("a.dsse.json").read_bytes())
    assert found is not None and found.payload == Path("a.json").read_bytes()


def test_answers_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["attest", "--new-key", "key.pem", "--format", "json"]) == 0
    made = envelope(capsys.readouterr().out)
    assert made["format"] == "fairaudit-key/1"
    key = made["result"]["keyid"]
    assert made["result"] == {"private": "key.pem", "public": "key.pub.pem", "keyid": key, "encrypted": False}
    assert main(["attest", "a.json", "--sign-key", "key.pem", "-o", "s.json", "--format", "json"]) == 0
    assert envelope(capsys.readouterr().out)["result"] == {
        "file": "s.json",
        "keyid": key,
        "signatures": 1,
        "subjects": ["certificate.json"],
    }
    assert main(["verify", "certificate.json", "--attestation", "s.json", "--key", "key.pub.pem", "--format", "json"]) == 0
    found = envelope(capsys.readouterr().out)["result"]["attestation"]
    assert (found["signature"], found["key"]) == ("checked", key)


def test_two_may_sign(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("one", "two"):
        main(["attest", "--new-key", f"{name}.pem"])
    assert main(["attest", "a.json", "--sign-key", "one.pem"]) == 0
    assert main(["attest", "a.dsse.json", "--sign-key", "one.pem", "-o", "both.json"]) == 2
    assert "signed by this key already" in capsys.readouterr().err
    assert main(["attest", "a.dsse.json", "--sign-key", "two.pem", "-o", "both.json"]) == 0
    assert "1 other signature stays, not checked" in capsys.readouterr().out
    for name in ("one", "two"):
        assert main(["verify", "certificate.json", "--attestation", "both.json", "--key", f"{name}.pub.pem", "--quiet"]) == 0


def test_the_public_key_is_named_only_where_it_is_that_of_the_private_one(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("one", "two"):
        main(["attest", "--new-key", f"{name}.pem"])
    Path("one.pub.pem").write_bytes(Path("two.pub.pem").read_bytes())
    Path("two.pub.pem").unlink()
    capsys.readouterr()
    for name in ("one", "two"):
        assert main(["attest", "a.json", "--sign-key", f"{name}.pem", "-o", f"{name}.json"]) == 0
        assert f"--attestation {name}.json --key PUB.pem\n" in capsys.readouterr().out


def test_no_signature_is_written_over(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("one", "two", "three"):
        main(["attest", "--new-key", f"{name}.pem"])
    assert main(["attest", "a.json", "--sign-key", "one.pem"]) == 0
    first = Path("a.dsse.json").read_bytes()
    for words in ("a.json --sign-key two.pem", "a.json --sign-key two.pem -o a.dsse.json"):
        capsys.readouterr()
        assert main(["attest", *words.split()]) == 2
        out, err = capsys.readouterr()
        assert out == "" and "holds 1 signature of the same attestation that would be lost" in err
        assert Path("a.dsse.json").read_bytes() == first
    command = re.search(r"it gets one more: fairaudit (.*)", err)
    assert command is not None and main(command[1].split()) == 0
    assert "a.dsse.json is now signed by the key" in capsys.readouterr().out
    for name in ("one", "two"):
        assert main(["verify", "certificate.json", "--attestation", "a.dsse.json", "--key", f"{name}.pub.pem", "--quiet"]) == 0
    both = Path("a.dsse.json").read_bytes()
    for output in ([], ["-o", "a.dsse.json"]):
        assert main(["attest", "a.dsse.json", "--sign-key", "two.pem", *output]) == 2
    assert main(["attest", "a.json", "--sign-key", "one.pem"]) == 2  # that of the second would be lost
    document = json.loads(Path("a.json").read_text())
    document["predicate"]["title"] = "Another"
    Path("b.json").write_text(json.dumps(document))
    assert main(["attest", "b.json", "--sign-key", "three.pem", "-o", "a.dsse.json"]) == 2
    assert "holds something else than this attestation" in capsys.readouterr().err
    assert Path("a.dsse.json").read_bytes() == both
    assert not [path for path in Path().iterdir() if path.suffix == ".part"]


def test_what_loses_no_signature_is_written_again() -> None:
    main(["attest", "--new-key", "one.pem"])
    Path("s.json").write_bytes(Path("a.json").read_bytes())
    for _ in range(2):
        assert main(["attest", "a.json", "--sign-key", "one.pem", "-o", "s.json"]) == 0
    found = read_envelope(Path("s.json").read_bytes())
    assert found is not None and len(found.signatures) == 1


def test_a_public_key_does_not_sign(capsys: pytest.CaptureFixture[str]) -> None:
    main(["attest", "--new-key", "key.pem"])
    for mode in (0o644, 0o600):
        Path("key.pub.pem").chmod(mode)
        assert main(["attest", "a.json", "--sign-key", "key.pub.pem"]) == 2
        assert "key.pub.pem is a public key, by which everybody checks; sign with the private one" in capsys.readouterr().err


def test_a_certificate_is_not_signed(capsys: pytest.CaptureFixture[str]) -> None:
    main(["attest", "--new-key", "key.pem"])
    assert main(["attest", "certificate.json", "--sign-key", "key.pem"]) == 2
    assert "it is a certificate; give the file that `fairaudit certify --attest FILE` writes" in capsys.readouterr().err


def test_the_page_tells_how_two_sign() -> None:
    page = (Path(__file__).parents[2] / "docs" / "attestation.md").read_text("utf-8")
    (script,) = [block for block in re.findall(r"```sh\n(.*?)```", page, re.DOTALL) if "--sign-key officer.pem" in block]
    shutil.copy("a.json", "attestation.json")
    for words in ("--new-key auditor.pem", "--new-key officer.pem"):
        assert main(["attest", *words.split()]) == 0
    assert main(["attest", "attestation.json", "--sign-key", "auditor.pem"]) == 0
    for line in script.splitlines():
        assert main(line.split()[1:]) == 0
    assert main(["verify", "certificate.json", "--attestation", "attestation.dsse.json", "--key", "auditor.pub.pem", "--quiet"]) == 0


@pytest.mark.parametrize(
    "words",
    [
        "",
        "a.json",
        "--sign-key key.pem",
        "a.json --sign-key nowhere.pem",
        "nowhere.json --sign-key key.pem",
        "a.json --sign-key key.pub.pem",
        "a.json --sign-key a.json",
        "a.json --sign-key key.pem -o a.json",
        "a.json --sign-key key.pem -o key.pem",
        "a.json --sign-key key.pem -o nowhere/s.json",
        "a.json --sign-key key.pem -o other.pub.pem",
        "a.json --sign-key key.pem -o signed.txt",
        "a.json --sign-key key.pem -o certificate.json",
        "a.json --sign-key key.pem -o log.json",
        "a.json --sign-key key.pem --passphrase",
        "certificate.json --sign-key key.pem",
        "key.pem --sign-key key.pem",
        "--new-key key.pem",
        "--new-key other.txt",
        "--new-key other.pem a.json",
        "--new-key other.pem --sign-key key.pem",
        "--new-key other.pem -o s.json",
        "--new-key other.pem --passphrase",
    ],
)
def test_what_cannot_be_done_is_refused_in_a_sentence_and_leaves_nothing(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["attest", "--new-key", "key.pem"])
    Path("other.pub.pem").write_text("somebody's key")
    Path("log.json").write_text("[]")
    capsys.readouterr()
    before = {path.name: path.read_bytes() for path in Path().iterdir()}
    assert main(["attest", *words.split()]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("fairaudit") and err.count("\n") == 1
    assert {path.name: path.read_bytes() for path in Path().iterdir()} == before
    assert all(line not in err for line in secrets_of("key.pem"))


def test_a_passphrase_of_the_environment(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("FAIRAUDIT_KEY_PASSPHRASE", "short")
    assert main(["attest", "--new-key", "key.pem"]) == 2
    monkeypatch.setenv("FAIRAUDIT_KEY_PASSPHRASE", LONG)
    assert main(["attest", "--new-key", "key.pem"]) == 0
    assert "ENCRYPTED" in Path("key.pem").read_text()
    assert main(["attest", "a.json", "--sign-key", "key.pem"]) == 0
    monkeypatch.setenv("FAIRAUDIT_KEY_PASSPHRASE", LONG[::-1])
    assert main(["attest", "a.json", "--sign-key", "key.pem", "-o", "s.json"]) == 2
    monkeypatch.delenv("FAIRAUDIT_KEY_PASSPHRASE")
    assert main(["attest", "a.json", "--sign-key", "key.pem", "-o", "s.json"]) == 2
    said = "".join(capsys.readouterr())
    assert "nobody can be asked" in said and "not the right one" in said
    assert all(secret not in said for secret in (LONG, LONG[::-1], *secrets_of("key.pem"))) and not Path("s.json").exists()


def on_terminal(*words: str, answer: str = "") -> tuple[int, str]:
    """Run the command on a terminal of its own, and give what is seen there."""
    process, terminal = pytest.importorskip("pty").fork()
    if process == 0:
        os.execv(sys.executable, [sys.executable, "-m", "fairaudit", *words])  # noqa: S606
    seen, until, answered = b"", time.monotonic() + 60, not answer
    while time.monotonic() < until:
        if select.select([terminal], [], [], 0.2)[0]:
            try:
                read = os.read(terminal, 4096)
            except OSError:
                break
            if not read:
                break
            seen += read
        if not answered and b"Passphrase of" in seen:
            os.write(terminal, answer.encode() + b"\n")
            answered = True
    os.close(terminal)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), seen.decode().replace("\r\n", "\n")


def test_on_a_terminal_a_passphrase_is_made_and_shown_once_and_asked_for_unseen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(fa.__file__).parents[1]))
    code, seen = on_terminal("attest", "--new-key", "key.pem", "--passphrase")
    passphrase = re.findall(r"shown this once: (\S+)", seen)
    assert code == 0 and len(passphrase) == 1 and seen.count(passphrase[0]) == 1
    code, seen = on_terminal("attest", "a.json", "--sign-key", "key.pem", answer=passphrase[0])
    assert code == 0 and passphrase[0] not in seen
    code, seen = on_terminal("attest", "a.json", "--sign-key", "key.pem", "-o", "s.json", answer="wrong-" + passphrase[0])
    assert code == 2 and "not the right one" in seen and passphrase[0] not in seen and "Traceback" not in seen
    assert main(["verify", "certificate.json", "--attestation", "a.dsse.json", "--key", "key.pub.pem", "--quiet"]) == 0


def test_without_signatures_nothing_of_cryptography_is_loaded() -> None:
    code = (
        "import sys; from fairaudit.cli import main; "
        "assert main(['verify', 'certificate.json', '--attestation', 'a.json', '--quiet']) == 0; assert main(['attest']) == 2; "
        "assert not [name for name in sys.modules if name.split('.')[0] == 'cryptography']"
    )
    environment = os.environ | {"PYTHONPATH": str(Path(fa.__file__).parents[1])}
    assert subprocess.run([sys.executable, "-c", code], check=False, env=environment, capture_output=True).returncode == 0


def test_the_page_tells_how_openssl_checks_a_signature() -> None:
    page = (Path(__file__).parents[2] / "docs" / "attestation.md").read_text("utf-8")
    (script,) = [block for block in re.findall(r"```sh\n(.*?)```", page, re.DOTALL) if "openssl" in block]
    for words in ("--new-key auditor.pem", "--new-key other.pem", "a.json --sign-key auditor.pem -o attestation.dsse.json"):
        assert main(["attest", *words.split()]) == 0
    if shutil.which("openssl") is None or shutil.which("python3") is None:
        pytest.skip("openssl is not installed")
    codes = [
        subprocess.run(["sh", "-ec", text], check=False, capture_output=True).returncode
        for text in (script, script.replace("auditor.pub.pem", "other.pub.pem"))
    ]
    assert codes[0] == 0 != codes[1]


def test_what_cannot_be_read_is_said_but_not_if_nothing_is_to_be_said(capsys: pytest.CaptureFixture[str]) -> None:
    for words in ("--attestation nowhere.json", "--attestation a.json --key nowhere.pem", "--attestation a.json --key a.json"):
        assert main(["verify", "certificate.json", *words.split()]) == 2
        assert capsys.readouterr().err.count("\n") == 1
        assert main(["verify", "certificate.json", *words.split(), "--quiet"]) == 2
        assert capsys.readouterr() == ("", "")


def test_a_key_in_place_of_its_file_is_not_repeated(capsys: pytest.CaptureFixture[str]) -> None:
    main(["attest", "--new-key", "key.pem"])
    capsys.readouterr()
    text = Path("key.pem").read_text()
    for words in (
        ["attest", "a.json", "--sign-key", text],
        ["attest", "--new-key", text],
        ["attest", "--new-key", "other.pem", "--passphrase", LONG],
        ["verify", "certificate.json", "--attestation", "a.json", "--key", text],
        ["verify", "certificate.json", "--attestation", "key.pem"],
        ["verify", "certificate.json", "--attestation", "key.pem", "--key", "key.pub.pem"],
        ["verify", "key.pem"],
    ):
        assert main(words) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1
        assert all(secret not in err for secret in (*secrets_of("key.pem"), LONG))
    for key in (text, text.encode(), text.encode() + Path("key.pub.pem").read_bytes()):
        with pytest.raises(fa.InputError) as found:
            fa.verify("certificate.json", attestation="a.json", key=key)
        assert all(secret[:20] not in str(found.value) for secret in secrets_of("key.pem"))
    with pytest.raises(fa.InputError):
        fa.verify("certificate.json", attestation="a.json", key=text.splitlines())  # type: ignore[arg-type]


def test_a_public_key_may_be_given_as_bytes() -> None:
    main(["attest", "--new-key", "key.pem"])
    main(["attest", "a.json", "--sign-key", "key.pem"])
    assert fa.verify("certificate.json", attestation="a.dsse.json", key=Path("key.pub.pem").read_bytes())
