"""A publication with an attestation: in the folder byte for byte, on the page apart by what was checked, refused where it does not fit."""

from __future__ import annotations

import hashlib
import json
import re
import shlex
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from attested import written

import fairaudit as fa
from fairaudit.cli import main

RULES = {"ll144": ("--sex", "sex"), "four-fifths": (), "air": ("--control", "Male")}


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    table: dict[str, Any] = {"sex": ["Male", "Male", "Female", "Female"], "got": ["yes", "no"] * 2, "n": [3, 1, 2, 2]}
    fa.audit(table, decision="got", group="sex", count="n", utility="yes", confidence=None).save(tmp_path / "c.json")
    return tmp_path / "c.json"


def publish(certificate: Path, attestation: Path, rule: str = "ll144") -> int:
    out = str(certificate.with_name("out"))
    return main(["publish", str(certificate), "--rule", rule, *RULES[rule], "--attestation", str(attestation), "-o", out])


@pytest.mark.parametrize("rule", RULES)
def test_it_is_on_the_page_and_in_the_folder(rule: str, certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attestation = written(certificate, issuer={"name": "<b>Audits\u202e</b>"})
    assert publish(certificate, attestation, rule) == 0
    out = certificate.with_name("out")
    assert (out / "attestation.json").read_bytes() == attestation.read_bytes()
    page = (out / "index.html").read_text("utf-8")
    assert page.index("Who made this, of what") < page.index("What is said to have been read") < page.index('<h2 id="verify">')
    assert "&lt;b&gt;Audits\\u202e&lt;/b&gt;" in page
    assert "<b>Audits" not in page
    assert "The attestation is not signed" in page
    assert "fairaudit verify certificate.json --attestation attestation.json</pre>" in page
    digest = hashlib.sha256(attestation.read_bytes()).hexdigest()
    assert json.loads((out / "summary.json").read_text())["attestation"] == {"sha256": digest}
    capsys.readouterr()
    assert main(["verify", str(out / "certificate.json"), "--attestation", str(out / "attestation.json")]) == 0


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        (("--tool", "Screener", "--tool-version", "4.2", "--period", "2025-01-01/2025-12-31"), []),
        (("--tool", "Ranker"), ["The tool is 'Ranker' here, and 'Screener' in the attestation."]),
        (
            ("--tool", "Screener", "--tool-version", "4", "--period", "2025-01-01/2025-12-30"),
            [
                "The version of the tool is '4' here, and '4.2' in the attestation.",
                "The period of the data is '2025-01-01 to 2025-12-30' here, and '2025-01-01 to 2025-12-31' in the attestation.",
            ],
        ),
    ],
)
def test_what_is_stated_twice_and_differs_is_said(stated: tuple[str, ...], said: list[str], certificate: Path) -> None:
    more = ("--attestation", str(written(certificate)), "-o", str(certificate.with_name("out")), *stated)
    assert main(["publish", str(certificate), "--rule", "ll144", "--sex", "sex", *more]) == 0
    found = json.loads((certificate.with_name("out") / "summary.json").read_text())["findings"]
    assert [text for text in found if "attestation" in text] == said


@pytest.mark.parametrize(
    ("changes", "code", "said"),
    [
        ({"table": {"sha256": "0" * 64}}, 1, "nothing was published"),
        ({"rows": {"unit": "decisions", "read": 9, "counted": 8, "dropped": {}}}, 1, "nothing was published"),
        ({"rows": {"unit": "decisions", "read": 9, "counted": 9, "dropped": {}}}, 1, "nothing was published"),
        ({"more": "x"}, 2, "more"),
        ({"issuedAt": "today"}, 2, "today"),
    ],
)
def test_what_does_not_fit_is_refused(
    changes: dict[str, Any], code: int, said: str, certificate: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(certificate, written(certificate, **changes)) == code
    assert said in capsys.readouterr().err
    assert not certificate.with_name("out").exists()


def test_one_of_another_certificate_is_refused(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attestation = written(certificate)
    certificate.write_bytes(certificate.read_bytes() + b"\n")
    assert publish(certificate, attestation) == 1
    assert "nothing was published" in capsys.readouterr().err


def test_a_signature_is_not_said_to_be_checked(certificate: Path) -> None:
    pytest.importorskip("cryptography", reason="cryptography is not installed (it is in the extra sign)")
    key, signed = certificate.with_name("k.pem"), certificate.with_name("a.dsse.json")
    assert main(["attest", "--new-key", str(key)]) == 0
    assert main(["attest", str(written(certificate)), "--sign-key", str(key), "-o", str(signed)]) == 0
    assert publish(certificate, signed) == 0
    page = (certificate.with_name("out") / "index.html").read_text("utf-8")
    assert "with a signature, which was not checked" in page
    assert (certificate.with_name("out") / "attestation.dsse.json").read_bytes() == signed.read_bytes()


def test_it_does_not_go_with_counts_that_are_withheld(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("sex,got\n" + "Male,yes\nFemale,no\nMale,no\nFemale,yes\n" * 20)
    names = {name: str(tmp_path / name) for name in ("log.csv", "c.json", "c.table.jsonl", "a.json", "out")}
    made = ("--decision", "got", "--group", "sex", "--utility", "yes", "--no-table", "--attest", names["a.json"], "-o", names["c.json"])
    assert main(["certify", names["log.csv"], *made]) == 0
    whole = ("publish", names["c.json"], "--table", names["c.table.jsonl"], "--rule", "four-fifths", "-o", names["out"])
    assert main([*whole, "--small", "10", "--attestation", names["a.json"]]) == 2
    assert "--small does not go with --attestation" in capsys.readouterr().err
    assert not Path(names["out"]).exists()
    assert main([*whole, "--with-table", "--attestation", names["a.json"]]) == 0
    assert "--table certificate.table.jsonl --attestation attestation.json</pre>" in (tmp_path / "out" / "index.html").read_text("utf-8")


def test_a_signed_one_keeps_its_name_and_the_page_asks_for_the_key(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cryptography", reason="cryptography is not installed (it is in the extra sign)")
    key, signed, out = (certificate.with_name(name) for name in ("k.pem", "signed.json", "out"))
    assert main(["attest", "--new-key", str(key)]) == 0
    assert main(["attest", str(written(certificate)), "--sign-key", str(key), "-o", str(signed)]) == 0
    assert publish(certificate, signed) == 0
    assert (out / "attestation.dsse.json").read_bytes() == signed.read_bytes() and not (out / "attestation.json").exists()
    page = (out / "index.html").read_text("utf-8")
    (command,) = set(re.findall(r"fairaudit verify certificate.json[^<]*", page))
    assert "Get it from the signer, not from this folder" in page
    told = command.replace("SIGNER.pub.pem", str(key.with_name("k.pub.pem")))
    words = [str(out / word) if (out / word).is_file() else word for word in told.split()[1:]]
    capsys.readouterr()
    assert main(words) == 0
    assert main(["publish", *again(page, out)]) == 0
    assert same(out, out / "again")


def again(page: str, out: Path) -> list[str]:
    """The words after `publish` of the command on the page, with the files of the folder."""
    (found,) = re.findall(r"<pre>fairaudit publish (.*)</pre>", re.sub(r"</?span[^>]*>", "", page))
    return [str(out / word) if (out / word).is_file() or word == "again" else word for word in shlex.split(unescape(found))]


def same(one: Path, other: Path) -> bool:
    names = {path.name for path in one.iterdir() if path.is_file()}
    return names == {path.name for path in other.iterdir()} and all((one / n).read_bytes() == (other / n).read_bytes() for n in names)


def test_what_labels_mean_is_in_the_folder_that_is_made_again(certificate: Path) -> None:
    table: dict[str, Any] = {"sex": ["m", "m", "Female", "Female"], "got": ["yes", "no"] * 2, "n": [3, 1, 2, 2]}
    fa.audit(table, decision="got", group="sex", count="n", utility="yes", confidence=None).save(certificate)
    given, out = certificate.with_name("my map.toml"), certificate.with_name("out")
    given.write_bytes(b'# as told by the employer\r\n[sex]\r\n"m" = "Male"\r\n')
    words = ("--rule", "ll144", "--sex", "sex", "--categories", str(given), "--attestation", str(written(certificate)))
    assert main(["publish", str(certificate), *words, "-o", str(out)]) == 0
    assert (out / "categories.toml").read_bytes() == given.read_bytes()
    given.unlink()
    assert main(["publish", *again((out / "index.html").read_text("utf-8"), out)]) == 0
    assert same(out, out / "again")
