"""Several certificates by one command, as hooks hand them over; one of them is in tests/verified/."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from attested import statement_of
from envelopes import envelope

from fairaudit import audit
from fairaudit.cli import main


@pytest.fixture
def certificates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """One that is within its target, one that exceeds it, one that is false, and no certificate."""
    monkeypatch.chdir(tmp_path)
    table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    columns = {"decision": "hired", "group": "sex", "count": "n"}
    for name, limit in (("within", 2), ("exceeds", "5/4")):
        audit(table, **columns, utility="yes", max_local_ratio=limit, confidence=None).save(f"{name}.json")
    Path("false.json").write_text(Path("within.json").read_text("utf-8").replace('"3/2"', '"4/3"'), "utf-8")
    Path("no.json").write_text("{}")
    return ["within.json", "exceeds.json", "false.json", "no.json"]


@pytest.mark.parametrize(
    ("names", "options", "code"),
    [
        (("within", "exceeds"), (), 0),
        (("within", "exceeds"), ("--require", "within"), 1),
        (("false", "within"), (), 1),
        (("within", "no"), (), 2),
        (("no", "false"), (), 1),
    ],
)
def test_several_are_checked_and_none_hides_another(
    certificates: list[str], capsys: pytest.CaptureFixture[str], names: tuple[str, ...], options: tuple[str, ...], code: int
) -> None:
    files = [f"{name}.json" for name in names]
    assert main(["verify", *files, *options]) == code
    assert [line for line in capsys.readouterr().out.splitlines() if line[:-1] in files] == [f"{file}:" for file in files]
    assert main(["verify", *files, *options, "--quiet"]) == code
    assert capsys.readouterr() == ("", "")


def test_several_answers_as_json(certificates: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", *certificates[:2], "--format", "json"]) == 0
    text, found, decoder = capsys.readouterr().out, [], json.JSONDecoder()
    while text.strip():
        answer, end = decoder.raw_decode(text.lstrip())
        found.append(answer["verdict"])
        text = text.lstrip()[end:]
    assert found == ["within", "exceeds"]


def test_a_table_is_that_of_one_certificate(certificates: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", *certificates[:2], "--table", "t.jsonl"]) == 2
    assert "--table is the table of one certificate" in capsys.readouterr().err


@pytest.mark.parametrize(("changes", "code", "true"), [({}, 0, True), ({"table": {"sha256": "0" * 64}}, 1, False)])
def test_an_attestation_as_json(
    certificates: list[str], capsys: pytest.CaptureFixture[str], changes: dict[str, object], code: int, true: bool
) -> None:
    Path("a.json").write_text(json.dumps(statement_of(Path("within.json"), **changes)))
    assert main(["verify", "within.json", "--attestation", "a.json", "--format", "json"]) == code
    answer = envelope(capsys.readouterr().out)
    found = answer["result"]["attestation"]
    assert (answer["result"]["true"], found["true"], found["signature"]) == (true, true, "none")
    assert (answer["verdict"], answer["result"]["stated_verdict"]) == ("within" if true else "none", "within")
    assert {entry["statement"]: entry["true"] for entry in found["statements"]}["rows.read is 80, as many as were counted and dropped"]
    assert "; of the attestation " in answer["sentence"]


def test_an_attestation_is_about_one_certificate(certificates: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", *certificates[:2], "--attestation", "a.json"]) == 2
    assert "--attestation is that of one certificate" in capsys.readouterr().err
    assert main(["verify", "--export", "c.pyz", "--attestation", "a.json"]) == 2
    assert not Path("c.pyz").exists()
    assert main(["verify", certificates[0], "--attestation", "a.json"]) == 2
    assert "a.json" in capsys.readouterr().err
