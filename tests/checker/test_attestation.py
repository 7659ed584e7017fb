"""Attestations as the checker reads them: true ones pass, and none that differs in what can be checked."""

from __future__ import annotations

import base64
import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from attested import altered, places, statement_of
from evaluation_changes import audited, drawn_log

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.cli.checking import zipped_checker

TABLE = {
    "hired": ["yes", "no", "yes", "no", "yes"],
    "sex": ["f", "f", "m", "m", None],
    "n": ["30", "10", "20", "41/2", "7"],
}
COLUMNS: dict[str, Any] = {"decision": "hired", "group": "sex", "count": "n", "utility": "yes", "confidence": None}


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    """Of a table with a fraction of a decision, and with seven that have no group."""
    path = tmp_path / "certificate.json"
    fa.audit(TABLE, **COLUMNS, missing="drop").save(path)
    return path


def written(path: Path, value: object) -> str:
    """The name of a file with these bytes, or this document."""
    path.write_bytes(value if isinstance(value, bytes) else json.dumps(value).encode())
    return str(path)


def code_of(certificate: Path, value: object) -> int:
    """What the checker exits with."""
    return checker.main([str(certificate), "--attestation", written(certificate.with_name("attestation.json"), value), "--quiet"])


def enveloped(value: object, **changes: Any) -> dict[str, Any]:
    payload = base64.b64encode(value if isinstance(value, bytes) else json.dumps(value).encode()).decode()
    signature = {"keyid": "0" * 64, "sig": base64.b64encode(bytes(64)).decode()}
    return {"payload": payload, "payloadType": "application/vnd.in-toto+json", "signatures": [signature]} | changes


def test_a_true_attestation(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = written(certificate.with_name("a.json"), statement_of(certificate))
    assert json.loads(Path(said).read_text())["predicate"]["rows"] == {
        "unit": "decisions",
        "read": "175/2",
        "counted": "161/2",
        "dropped": {"missing label": 7},
    }
    assert checker.main([str(certificate), "--attestation", said]) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert "The attestation fits" in words and "It is not signed" in words and "certificate could have written it" in words
    only = words.partition("only stated")[2]
    for stated in (
        "Example Audits",
        "audits@example.org",
        "Screening of applicants",
        "Screener",
        "4.2",
        "2025-12-31",
        "2026-01-15T09:00:00Z",
    ):
        assert stated in only
    assert 'Whether the table was counted from "log.csv", "postgresql" (without digest), only the log tells, counted again' in only
    assert checker.main([str(certificate), "--attestation", said, "--verbose"]) == 0
    assert "true   rows.counted is 161/2" in capsys.readouterr().out


def test_what_is_absent_is_said_to_be_absent(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = statement_of(certificate)
    for key in ("issuer", "title", "system", "period"):
        del whole["predicate"][key]
    assert checker.main([str(certificate), "--attestation", written(certificate.with_name("a.json"), whole)]) == 0
    assert "No issuer or title or system or period is stated." in " ".join(capsys.readouterr().out.split())


def test_an_envelope_is_compared_but_its_signature_is_not_checked(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = written(certificate.with_name("a.json"), enveloped(statement_of(certificate)))
    assert checker.main([str(certificate), "--attestation", said]) == 3
    assert "signature was NOT checked" in " ".join(capsys.readouterr().out.split())
    assert checker.main([str(certificate), "--attestation", said, "--require", "within", "--quiet"]) == 1
    false = statement_of(certificate, table={"sha256": "0" * 64})
    assert code_of(certificate, enveloped(false)) == 1


FALSE: dict[str, tuple[tuple[Any, ...], Any]] = {
    "another file": (("subject", 0, "digest", "sha256"), "0" * 64),
    "another table": (("predicate", "table", "sha256"), "0" * 64),
    "more read": (("predicate", "rows", "read"), 88),
    "fewer counted": (("predicate", "rows", "counted"), 80),
    "none dropped": (("predicate", "rows", "dropped"), {}),
    "another reason": (("predicate", "rows", "dropped"), {"unreadable line": 7}),
    "another unit": (("predicate", "rows", "unit"), "rows"),
}


@pytest.mark.parametrize(("path", "value"), FALSE.values(), ids=FALSE)
def test_what_a_table_contradicts_is_false(certificate: Path, path: tuple[Any, ...], value: object) -> None:
    assert code_of(certificate, altered(statement_of(certificate), path, lambda _: value)) == 1


def test_amounts_that_add_up_to_what_the_table_contradicts_are_false(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = {"unit": "decisions", "read": "175/2", "counted": "159/2", "dropped": {"missing label": 8}}
    said = written(certificate.with_name("a.json"), statement_of(certificate, rows=rows))
    assert checker.main([str(certificate), "--attestation", said]) == 1
    out = capsys.readouterr().out
    assert "FALSE  rows.counted is 159/2 (the table gives 161/2)" in out
    assert "2 of 7 statements of the attestation are FALSE" in out and "only stated" not in out


def test_a_false_certificate_is_not_helped_by_a_true_attestation(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    certificate.write_text(certificate.read_text().replace('"verdict": "none"', '"verdict": "within"', 1))
    assert code_of(certificate, statement_of(certificate)) == 1
    checker.main([str(certificate), "--attestation", str(certificate.with_name("attestation.json"))])
    assert "The attestation fits a certificate that is FALSE" in " ".join(capsys.readouterr().out.split())


MALFORMED: dict[str, Callable[[dict[str, Any]], Any]] = {
    "no JSON": lambda _: b"{",
    "nothing": lambda _: b"",
    "a list": lambda whole: [whole],
    "two documents": lambda whole: json.dumps(whole).encode() * 2,
    "UTF-16": lambda whole: json.dumps(whole).encode("utf-16"),
    "a byte order mark": lambda whole: b"\xef\xbb\xbf" + json.dumps(whole).encode(),
    "a certificate": lambda _: {"format": "fairaudit-certificate/1"},
    "another type": lambda whole: whole | {"_type": "https://in-toto.io/Statement/v0.1"},
    "another predicate": lambda whole: whole | {"predicateType": "https://slsa.dev/provenance/v1"},
    "an unknown key": lambda whole: whole | {"more": 1},
    "no subject": lambda whole: whole | {"subject": []},
    "a key twice": lambda whole: json.dumps(whole).replace('"title":', '"title": "x", "title":', 1).encode(),
    "a fraction that is whole": lambda whole: altered(whole, ("predicate", "rows", "counted"), lambda _: "80"),
    "a fraction not in lowest terms": lambda whole: altered(whole, ("predicate", "rows", "counted"), lambda _: "322/4"),
    "a float": lambda whole: altered(whole, ("predicate", "rows", "counted"), lambda _: 80.5),
    "a huge number": lambda whole: json.dumps(whole).replace("812345", "9" * 5000).encode(),
    "minus zero": lambda whole: json.dumps(whole).replace("812345", "-0").encode(),
    "not a number": lambda whole: json.dumps(whole).replace("812345", "NaN").encode(),
    "a digest without bytes": lambda whole: altered(whole, ("predicate", "sources", 0, "bytes"), lambda _: None),
    "a file with a query": lambda whole: altered(whole, ("predicate", "sources", 0), lambda held: held | {"query": "SELECT 1"}),
    "a query and a table": lambda whole: altered(whole, ("predicate", "sources", 1), lambda held: held | {"table": "t"}),
    "an option that is not known": lambda whole: altered(whole, ("predicate", "options"), lambda held: held | {"run": "rm"}),
    "an option of nothing": lambda whole: altered(whole, ("predicate", "options", "skip"), lambda _: None),
    "a fraction among options": lambda whole: altered(whole, ("predicate", "options", "skip"), lambda _: 0.5),
    "deep options": lambda whole: altered(whole, ("predicate", "options", "utility"), lambda _: json.loads("[" * 20 + "]" * 20)),
    "very deep options": lambda whole: json.dumps(whole).replace('["sex"]', "[" * 100_000 + "]" * 100_000).encode(),
    "a control character": lambda whole: altered(whole, ("predicate", "title"), lambda _: "a\x1b[31mb"),
    "a lone surrogate": lambda whole: json.dumps(whole).replace("Screening", "\\ud800").encode(),
    "a long text": lambda whole: altered(whole, ("predicate", "title"), lambda _: "a" * 4097),
    "a blank title": lambda whole: altered(whole, ("predicate", "title"), lambda _: " "),
    "a folder": lambda whole: altered(whole, ("predicate", "sources", 0, "name"), lambda _: "home/log.csv"),
    "no such day": lambda whole: altered(whole, ("predicate", "period", "end"), lambda _: "2025-02-29"),
    "an end before the start": lambda whole: altered(whole, ("predicate", "period", "end"), lambda _: "2024-12-31"),
    "no such moment": lambda whole: altered(whole, ("predicate", "issuedAt"), lambda _: "2026-01-15T25:00:00Z"),
    "a moment elsewhere": lambda whole: altered(whole, ("predicate", "issuedAt"), lambda _: "2026-01-15T09:00:00+01:00"),
    "digits of another script": lambda whole: altered(whole, ("predicate", "period", "start"), lambda _: "٢٠٢٥-01-01"),
    "many reasons": lambda whole: altered(whole, ("predicate", "rows", "dropped"), lambda _: {str(i): 1 for i in range(101)}),
    "an empty command": lambda whole: altered(whole, ("predicate", "command"), lambda _: []),
    "no version of fairaudit": lambda whole: altered(whole, ("predicate", "versions"), lambda _: {"python": "3"}),
    "another payload": lambda whole: enveloped(whole, payloadType="application/json"),
    "no signature": lambda whole: enveloped(whole, signatures=[]),
    "many signatures": lambda whole: enveloped(whole, signatures=enveloped(whole)["signatures"] * 101),
    "a short signature": lambda whole: enveloped(whole, signatures=[{"sig": "AAAA"}]),
    "a signature of nothing": lambda whole: enveloped(whole, signatures=[{"keyid": ""}]),
    "more in an envelope": lambda whole: enveloped(whole) | {"more": 1},
    "an envelope and a statement": lambda whole: enveloped(whole) | whole,
    "an envelope in an envelope": lambda whole: enveloped(enveloped(whole)),
    "blanks in base64": lambda whole: enveloped(whole, payload=enveloped(whole)["payload"] + "\n"),
    "base64 for addresses": lambda _: enveloped("?>" * 30, payload=base64.urlsafe_b64encode(b"?>" * 30).decode()),
    "a payload that is no text": lambda whole: enveloped(whole, payload=[1]),
    "a payload that is no JSON": lambda _: enveloped(b"\xff"),
}


@pytest.mark.parametrize("change", MALFORMED.values(), ids=MALFORMED)
def test_what_is_malformed_is_refused_in_a_sentence(
    certificate: Path, change: Callable[[dict[str, Any]], Any], capsys: pytest.CaptureFixture[str]
) -> None:
    name = written(certificate.with_name("a.json"), change(statement_of(certificate)))
    assert checker.main([str(certificate), "--attestation", name]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("Not an attestation: ") and err.count("\n") == 1 and len(err) < 700


def test_base64_has_one_spelling(certificate: Path) -> None:
    """Two bits of the last digit before one padding, or four before two, are not used: they have to be zero."""
    whole = json.dumps(statement_of(certificate)).encode()
    for pad in range(3):
        text = enveloped(whole + b" " * ((pad - len(whole)) % 3))["payload"]
        assert code_of(certificate, enveloped(b"", payload=text)) == 3
        for last in "".join(set("AEIMQUYcgkosw048BCDFGH")) if pad else "":
            other = text.rstrip("=")[:-1] + last + "=" * text.count("=")
            decoded = base64.b64decode(other)
            if decoded == base64.b64decode(text) and other != text:
                assert code_of(certificate, enveloped(b"", payload=other)) == 2


def test_every_value_of_a_wrong_type_is_refused(certificate: Path) -> None:
    """Nothing but the values of options may have another type; null stands for sources alone."""
    whole = statement_of(certificate)
    accepted = set()
    for path, value in places(whole):
        for other in (None, True, 7, -7, 0.5, "x", [], {}, [value], {"x": value}):
            if json.dumps(other) != json.dumps(value) and code_of(certificate, altered(whole, path, lambda _, x=other: x)) == 0:
                accepted.add(".".join(map(str, path)))
    stated = {"subject.0.name", "predicate.issuer.name", "predicate.issuer.contact", "predicate.title", "predicate.system.name"}
    stated |= {"predicate.system.version", "predicate.command.0", "predicate.command.1", "predicate.command.2", "predicate.command.3"}
    stated |= {"predicate.versions.fairaudit", "predicate.versions.python", "predicate.options"}
    stated |= {f"predicate.sources.{i}.{key}" for i, key in ((0, "name"), (0, "bytes"), (0, "rows"), (1, "name"), (1, "rows"))}
    assert {name for name in accepted if not name.startswith("predicate.options.")} == stated


def test_a_run_is_of_the_format_of_the_log(tmp_path: Path, certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A certificate of no evaluation log has none."""
    of_log = tmp_path / "log.json"
    of_log.write_bytes(audited(drawn_log(3, errors="drop")).certificate.text.encode())
    whole = statement_of(of_log)
    assert whole["predicate"]["sources"][0]["run"] == {"format": "inspect", "model": "a/b"} and code_of(of_log, whole) == 0
    run = ("predicate", "sources", 0, "run")
    for value, code in ({"format": "helm"}, 1), ({"format": "inspect", "status": "success"}, 0), ({"format": " "}, 2), ({"model": "a"}, 2):
        assert code_of(of_log, altered(whole, run, lambda _, given=value: given)) == code
    for path in ((*run, "format"), (*run, "model")):
        for wrong in (None, 7, [], {}, "", "\x00"):
            assert code_of(of_log, altered(whole, path, lambda _, given=wrong: given)) == 2
    other = altered(statement_of(certificate), ("predicate", "sources", 0), lambda held: held | {"run": {"format": "inspect"}})
    capsys.readouterr()
    assert code_of(certificate, other) == 1
    assert checker.main([str(certificate), "--attestation", str(certificate.with_name("attestation.json"))]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert 'FALSE sources[0].run.format is "inspect" (the certificate is of no evaluation log)' in said


def test_what_a_database_was_asked_for_is_what_the_options_say(certificate: Path) -> None:
    """Without a log, too: a file that is rewritten as the result of an invented query is one of which the options say nothing."""
    whole = statement_of(certificate)
    file, database = whole["predicate"]["sources"]
    without = {key: value for key, value in database.items() if key != "query"}
    for sources, options, code in (
        ([file, database], {"query": "SELECT 1"}, 0),
        ([file, database], {"query": "SELECT 2"}, 1),
        ([file, database], {"table": "SELECT 1"}, 1),
        ([file, database], {"group": ["sex"]}, 1),
        ([file, database], {"audit": {"law": {"table": "log.csv"}}}, 1),
        ([file], {"query": "SELECT 1"}, 1),
        ([without], {"query": "SELECT 1"}, 1),
        ([without | {"table": "log"}], {"table": "log"}, 0),
        ([without | {"table": "log"}], {"table": "hr.log"}, 1),
        ([file], {"table": "the first sheet"}, 0),
        ([file, database], {}, 0),  # by which nothing is read again
    ):
        assert code_of(certificate, statement_of(certificate, sources=sources, options=options)) == code, (sources, options)


def test_other_files_that_it_names_are_not_checked(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = statement_of(certificate)
    for others, said in (
        (0, ""),
        (1, "It names 1 other file, which was not checked."),
        (2, "It names 2 other files, which were not checked."),
    ):
        more = [{"name": f"{place}.json", "digest": {"sha256": str(place) * 64}} for place in range(others)]
        name = written(certificate.with_name("a.json"), whole | {"subject": [*whole["subject"], *more]})
        assert checker.main([str(certificate), "--attestation", name]) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert (f"Files that it names besides, which were not checked: {others}." in said) is (others > 0)


def test_a_file_that_is_long_is_not_read_to_its_end(certificate: Path, tmp_path: Path) -> None:
    with (tmp_path / "long.json").open("wb") as file:
        file.truncate(1 << 34)
    assert checker.main([str(certificate), "--attestation", str(tmp_path / "long.json"), "--quiet"]) == 2


def test_a_page_is_another_file_than_its_certificate(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = certificate.with_suffix(".html")
    fa.report(certificate, page)
    said = written(certificate.with_name("a.json"), statement_of(certificate))
    assert checker.main([str(page), "--attestation", said]) == 1
    assert "FALSE  a subject is the file that was checked" in capsys.readouterr().out


def paragraph_of(capsys: pytest.CaptureFixture[str]) -> str:
    """What is said of an attestation, without its false statements."""
    return " ".join(capsys.readouterr().out.split("\n\n")[-1].split())


def test_what_was_perhaps_mixed_up_is_said_and_false_all_the_same(
    certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page, other, again = (tmp_path / name for name in ("page.html", "other.json", "again.json"))
    fa.report(certificate, page)
    fa.audit(TABLE | {"n": ["30", "10", "20", "20", "7"]}, **COLUMNS, missing="drop").save(other)
    again.write_bytes(certificate.read_bytes() + b"\n")
    said = written(tmp_path / "a.json", statement_of(certificate))
    unreliable = (
        'FALSE. Do not rely on it, nor on whoever is said to have made this certificate. The attestation is about "certificate.json"'
    )
    for given, perhaps in (
        (page, "; what was given is a page that shows a certificate, which is another file: check the .json itself."),
        (other, ", with another table: it belongs to another certificate, or one of the two was altered."),
        (again, ", another file of the same table: one that was written at another time, or one of the two was altered."),
    ):
        assert checker.main([str(given), "--attestation", said]) == 1
        assert paragraph_of(capsys).endswith(unreliable + perhaps)
    many = statement_of(certificate)
    many["subject"] = [{"name": f"{i}.json", "digest": {"sha256": f"{i:064}"}} for i in range(5)]
    assert checker.main([str(certificate), "--attestation", written(tmp_path / "many.json", many)]) == 1
    assert 'about "0.json", "1.json", "2.json" and 2 more, another file' in paragraph_of(capsys)
    many["subject"] = [{"name": "c\u202e.json", "digest": {"sha256": "0" * 64}}]
    assert checker.main([str(certificate), "--attestation", written(tmp_path / "many.json", many)]) == 1
    assert 'about "c\\u202e.json", another file' in paragraph_of(capsys)
    wrong = altered(statement_of(certificate), ("predicate", "rows", "counted"), lambda _: 80)
    assert checker.main([str(certificate), "--attestation", written(tmp_path / "wrong.json", wrong)]) == 1
    assert paragraph_of(capsys).endswith("said to have made this certificate.")


def test_what_is_given_in_place_of_an_attestation_is_named(certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for value, kind in (
        (certificate.read_bytes(), "a certificate"),
        ({"format": "fairaudit-publication/1"}, "a summary of `fairaudit publish`"),
        (enveloped(enveloped(statement_of(certificate))), "a signed attestation"),
    ):
        assert checker.main([str(certificate), "--attestation", written(tmp_path / "a.json", value)]) == 2
        assert f"Not an attestation: the file is {kind}; give the one that" in capsys.readouterr().err


def test_certificates_of_other_kinds(tmp_path: Path) -> None:
    """Of a table of probabilities the rows that were left out tell how many were counted."""
    path = tmp_path / "c.json"
    table = {"u": ["yes", "no"] * 3, "g": ["f", "f", "m", "m", None, None], "p": ["0.3", "0.7", "0.5", "0.5", "0.1", "0.9"]}
    fa.audit(table, decision="u", group="g", probability="p", utility="yes", missing="drop").save(path)
    digest = json.loads(path.read_text())["subject"]["table"]["sha256"]
    document = statement_of(path, table={"sha256": digest})
    for rows, code in (
        ({"unit": "rows", "read": 6, "counted": 4, "dropped": {"missing label": 2}}, 0),
        ({"unit": "rows", "read": 5, "counted": 3, "dropped": {"missing label": 2}}, 1),
        ({"unit": "decisions", "read": 6, "counted": 4, "dropped": {"missing label": 2}}, 1),
    ):
        assert code_of(path, altered(document, ("predicate", "rows"), lambda _, rows=rows: rows)) == code
    fa.audit({key: column[:4] for key, column in table.items()}, decision="u", group="g", probability="p", utility="yes").save(path)
    for counted, code in ((4, 0), (5, 1), (0, 1)):
        rows = {"unit": "rows", "read": counted, "counted": counted, "dropped": {}}
        assert code_of(path, statement_of(path, rows=rows)) == code


def test_decisions_of_unknown_group_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    fa.audit(TABLE | {"sex": ["f", "f", "m", "m", "?"], "n": [30, 10, 20, 20, 7]}, **COLUMNS, unknown=["?"]).save(path)
    document = statement_of(path)
    assert document["predicate"]["rows"]["counted"] == 87 and code_of(path, document) == 0


def test_subgroups_count_rows_as_decisions(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    table = {"u": ["yes", "no", "yes", "no"] * 9, "a": ["x", "y", "x", "x"] * 9, "b": ["p", "q", "q", "p"] * 9}
    fa.subgroups(table, decision="u", attributes=["a", "b"], utility="yes", min_rows=2).certificate.save(path)
    for counted, code in ((36, 0), (35, 1)):
        rows = {"unit": "decisions", "read": counted, "counted": counted, "dropped": {}}
        digest = json.loads(path.read_text())["subject"]["table"]["sha256"]
        assert code_of(path, statement_of(path, rows=rows, table={"sha256": digest})) == code


def test_of_groups_that_nobody_recorded_what_was_dropped_is_only_stated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("u,x\nyes,a\nno,a\nyes,b\nno,b\n,b\n")
    (tmp_path / "groups.csv").write_text("x,g,probability\na,f,0.5\na,m,0.5\nb,f,0.2\nb,m,0.8\n")
    path = tmp_path / "c.json"
    words = f"--decision u --group g --group-probability {tmp_path}/groups.csv --utility yes --missing drop -o {path}"
    assert main(["certify", str(tmp_path / "log.csv"), *words.split()]) == 0
    for counted, dropped, code in ((4, 1, 0), (4, 7, 0), (5, 0, 1)):
        rows = {"unit": "decisions", "read": counted + dropped, "counted": counted, "dropped": {"missing label": dropped}}
        assert code_of(path, statement_of(path, rows=rows)) == code
    capsys.readouterr()
    assert checker.main([str(path), "--attestation", written(tmp_path / "a.json", statement_of(path))]) == 0
    assert "What was dropped is only stated, too" in " ".join(capsys.readouterr().out.split())


def test_the_checker_as_one_file(certificate: Path) -> None:
    archive = certificate.with_name("checker.pyz")
    archive.write_bytes(zipped_checker())
    assert "checker/attestation.py" in zipfile.ZipFile(BytesIO(archive.read_bytes())).namelist()
    whole = statement_of(certificate)
    for document, code in ((whole, 0), (enveloped(whole), 3), (statement_of(certificate, table={"sha256": "0" * 64}), 1), ({}, 2)):
        name = written(certificate.with_name("a.json"), document)
        words = [sys.executable, "-I", "-S", str(archive), str(certificate), "--attestation", name]
        found = subprocess.run(words, capture_output=True, text=True, check=False)
        assert found.returncode == code, found.stderr
        assert main(["verify", str(certificate), "--attestation", name, "--quiet"]) == code
