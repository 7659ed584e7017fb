"""The checker as a command, in each of the ways to run it."""

import ast
import copy
import hashlib
import io
import os
import py_compile
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path
from typing import Any

import pytest
import tiers
from plain_certificates import CHECKER, COUNTS, LIMITS, checker, detached, edited, make, raw

from fairaudit.cli import main

ROOT = CHECKER.parents[1]
HOSTILE = "raise SystemExit('a hostile module was imported')\n"
WAYS = ["module", "command", "folder", "file"]


@pytest.fixture
def good() -> dict[str, Any]:
    return make(COUNTS, ["1", "0"], limits=LIMITS)


def test_command(tmp_path: Path, good: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    path, table = tmp_path / "c.json", tmp_path / "t.jsonl"
    path.write_bytes(raw(good))
    assert checker.main([str(path), "--require", "within"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("All ") and "is kept in the table" in " ".join(out.split()) and "true   " not in out
    assert checker.main([str(path), "--verbose"]) == 0
    said, _, statements = capsys.readouterr().out.partition("\n\nStatements\n")
    assert f"{said}\n" == out and all(line.startswith("true   ") for line in statements.splitlines()) and "verdict is" in statements
    path.write_bytes(raw(edited(copy.deepcopy(good), "verdict", "none")))
    assert checker.main([str(path)]) == 1
    assert capsys.readouterr().out.startswith("FALSE  verdict")
    path.write_bytes(raw(make(COUNTS, ["1", "0"])))
    assert checker.main([str(path)]) == 0 and checker.main([str(path), "--require", "within"]) == 1
    outside, lines = detached(good)
    path.write_bytes(raw(outside))
    table.write_bytes(b"".join(lines))
    assert checker.main([str(path)]) == 3
    assert checker.main([str(path), "--table", str(table)]) == 0
    assert checker.main([str(path), "--table", str(tmp_path)]) == 2


@pytest.mark.parametrize("arguments", [[], ["nowhere"], ["."], ["a\0b"], ["x", "--require", "exceeds"], ["x", "--req", "within"]])
def test_usage(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert checker.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err and not captured.out and "Traceback" not in captured.err


def test_nothing_steers_the_terminal(tmp_path: Path, good: dict[str, Any]) -> None:
    evil = "\x1b[2J\u202e\u2028\ufeff\ue000\u0378\U000e0001é"
    path = tmp_path / "c.json"
    for place in ("claims.0.quantity", "metrics.local.witness.higher.G", "targets.0.judged", "verdict", "format", evil):
        path.write_bytes(raw(edited(copy.deepcopy(good), place, evil)))
        for encoding in ("utf-8", "ascii"):
            done = subprocess.run(
                [sys.executable, str(CHECKER), str(path)],
                capture_output=True,
                env=os.environ | {"PYTHONIOENCODING": encoding},
                check=False,
            )
            assert done.returncode in (1, 2) and b"Traceback" not in done.stderr
            printed = (done.stdout + done.stderr).decode(encoding)
            assert all(c.isprintable() or c == "\n" for c in printed)
            assert "\\u202e" in printed and "\\u2028" in printed


def test_low_digit_limit(tmp_path: Path, good: dict[str, Any]) -> None:
    path = tmp_path / "c.json"
    path.write_bytes(raw(edited(good, "metrics.local.ratio", "9" * 5000)))
    done = subprocess.run([sys.executable, "-X", "int_max_str_digits=640", str(CHECKER), str(path)], capture_output=True, check=False)
    assert done.returncode == 1 and not done.stderr


def test_closed_streams(tmp_path: Path, good: dict[str, Any]) -> None:
    """The exit code tells what is true even where nothing can be printed."""
    path = tmp_path / "c.json"
    for certificate, code in ((good, 0), (edited(copy.deepcopy(good), "verdict", "none"), 1)):
        path.write_bytes(raw(certificate))
        for closed in (">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            script = f'"$1" -I "$2" "$3" {closed}'
            done = subprocess.run(["sh", "-c", script, "sh", sys.executable, str(CHECKER), str(path)], capture_output=True, check=False)
            assert done.returncode == code and not done.stderr


def test_output_goes_to_any_stream(tmp_path: Path, good: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.json"
    path.write_bytes(raw(good))
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stdout", stream)
    assert checker.main([str(path)]) == 0
    assert stream.getvalue().endswith(" are the right ones.\n")


def copied(to: Path) -> Path:
    """A copy of the checker's folder, as docs/verify.md says."""
    return Path(shutil.copytree(CHECKER, to, ignore=shutil.ignore_patterns("__pycache__")))


def exported(to: Path) -> Path:
    assert main(["verify", "--export", str(to)]) == 0
    return to


def started(way: str, place: Path) -> list[str]:
    """The command line before the arguments; what it needs lies in a place."""
    if way == "module":
        return [sys.executable, "-m", "fairaudit.checker"]
    if way == "command":
        return [sys.executable, "-m", "fairaudit", "verify"]
    return [sys.executable, "-I", "-S", str(copied(place / "any name") if way == "folder" else exported(place / "checker.pyz"))]


def ran(command: list[str], *arguments: str, cwd: Path) -> tuple[int, str, str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([*command, *arguments], cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def files(tmp_path: Path, good: dict[str, Any]) -> Path:
    """Certificates that are true, false, incomplete, broken, and apart from their table."""
    folder = tmp_path / "files"
    folder.mkdir()
    outside, lines = detached(copy.deepcopy(good))
    incomplete = copy.deepcopy(good)
    incomplete["subject"]["table"]["header"]["groups"][1] = ["A0"]  # differs from a0 in case alone, which is not stated
    documents = {"within": good, "none": make(COUNTS, ["1", "0"]), "false": edited(copy.deepcopy(good), "verdict", "none")}
    for name, document in {**documents, "incomplete": incomplete, "apart": outside}.items():
        (folder / f"{name}.json").write_bytes(raw(document))
    (folder / "note.md").write_bytes("# Prüfung\n".encode("utf-16"))
    (folder / "empty.json").write_bytes(b"")
    (folder / "broken.json").write_bytes(raw(good)[:-3])
    (folder / "table.jsonl").write_bytes(b"".join(lines))
    (folder / "other.jsonl").write_bytes(b"".join(lines[:-1]))
    (folder / "published").mkdir()
    (folder / "published" / "certificate.json").write_bytes(raw(good))
    (folder / "published" / "summary.json").write_bytes(b'{"format": "fairaudit-publication/1"}')
    (folder / "published" / "index.html").write_bytes(b"<!DOCTYPE html><p>Rates</p>")
    (folder / "stated.json").write_bytes(b'{"_type": "", "predicateType": "", "subject": [], "predicate": {}}')
    (folder / "signed.json").write_bytes(b'{"payload": "", "payloadType": "", "signatures": []}')
    return folder


SAID = (
    (["within.json"], 0, "statements are true of the table, which the certificate holds"),
    (["within.json", "--require", "within"], 0, "is kept in the table."),
    (["within.json", "--verbose"], 0, 'true   verdict is "within"'),
    (["none.json"], 0, "No target was set."),
    (["none.json", "--require", "within"], 1, "The verdict 'within' is required, but 'none' is stated."),
    (["false.json"], 1, "FALSE  verdict"),
    (["apart.json", "--table", "table.jsonl"], 0, "statements are true of the table, which is in the file that was given"),
    (["apart.json", "--table", "other.jsonl"], 1, "FALSE  subject.table.sha256"),
    (["incomplete.json"], 2, 'The certificate is incomplete: subject lacks the key "spellings"'),
    (["broken.json"], 2, "Not a certificate of the format fairaudit-certificate/1: the certificate is not JSON"),
    (["nowhere.json"], 2, 'Cannot read or write "nowhere.json": No such file or directory.'),
    (["."], 2, 'Cannot read or write ".": Is a directory; give a file in it.'),
    (["published"], 2, 'Cannot read or write "published": Is a directory; give certificate.json in it.'),
    (["published/index.html"], 2, "check the certificate itself, such as the certificate.json beside a page of `fairaudit publish`."),
    (["published/summary.json"], 2, "the file is a summary of `fairaudit publish`; give the certificate, such as the certificate.json"),
    (["stated.json"], 2, "the file is an attestation; give the certificate, and this one with --attestation."),
    (["signed.json"], 2, "the file is a signed attestation; give the certificate, and this one with --attestation."),
    (["note.md"], 2, "the file holds something else; give the .json that fairaudit wrote, or its page (.html)."),
    (["empty.json"], 2, "the file is empty; give the .json that fairaudit wrote, or its page (.html)."),
    (["apart.json"], 3, "the file of the table has to be given: add --table FILE."),
)
"""What the command is asked, its exit code, and a part of what it says."""


@pytest.mark.parametrize("way", WAYS)
def test_every_way_says_the_same(way: str, tmp_path: Path, files: Path) -> None:
    """One way says all of it, the others every third thing; all of them everything with ``FAIRAUDIT_FULL=1``."""
    command = started(way, tmp_path)
    full = way == WAYS[0] or tiers.FULL
    for arguments, code, said in SAID if full else SAID[WAYS.index(way) - 1 :: 3]:
        got, out, err = ran(command, *arguments, cwd=files)
        assert got == code, (arguments, out, err)
        assert said in (err if code > 1 else out).replace("\n", " ") and not (out if code > 1 else err), arguments
        if "--verbose" not in arguments:
            assert ran(command, *arguments, "--quiet", cwd=files) == (code, "", "")


def test_every_way_prints_the_same(tmp_path: Path, files: Path) -> None:
    outputs = {ran(started(way, tmp_path), "within.json", cwd=files) for way in WAYS}
    assert len(outputs) == 1


def test_a_copy_needs_nothing_and_leaves_nothing(tmp_path: Path, files: Path) -> None:
    folder = copied(tmp_path / "copy" / "any name")
    before = sorted(folder.rglob("*"))
    command = [sys.executable, "-I", "-S", "-B", str(folder)]
    assert ran(command, "within.json", cwd=files)[0] == 0
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("way", ["folder", "file"])
def test_files_beside_are_not_imported(way: str, tmp_path: Path, files: Path) -> None:
    """Neither in the folder that one works in nor where the checker lies, whatever module of the standard library they are named after."""
    command = started(way, tmp_path)
    for name in ("json", "re", "argparse", "hashlib", "fractions", "dataclasses", "text", "checker"):
        for place in (tmp_path, files):
            (place / f"{name}.py").write_text(HOSTILE)
    assert ran(command, "within.json", cwd=files)[0] == 0
    assert ran(command, "within.json", cwd=files)[1] == ran(started("module", tmp_path), str(files / "within.json"), cwd=ROOT)[1]


def test_files_within_do_not_stand_in_for_standard_ones(tmp_path: Path, files: Path) -> None:
    folder = copied(tmp_path / "checker")
    for name in ("json", "re", "argparse", "hashlib", "fractions", "dataclasses", "struct"):
        (folder / f"{name}.py").write_text(HOSTILE)
    assert ran([sys.executable, "-I", "-S", str(folder)], "within.json", cwd=files)[0] == 0


def test_what_was_compiled_before_is_not_run(tmp_path: Path, files: Path) -> None:
    """Compiled files that Python would take unseen in place of the text."""
    folder = copied(tmp_path / "checker")
    hostile = tmp_path / "hostile.py"
    hostile.write_text(HOSTILE)
    for path in folder.glob("*.py"):
        if path.name != "__main__.py":
            to = folder / "__pycache__" / f"{path.stem}.{sys.implementation.cache_tag}.pyc"
            py_compile.compile(str(hostile), str(to), doraise=True, invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH)
    assert ran([sys.executable, "-I", "-S", str(folder)], "within.json", cwd=files)[0] == 0


def test_export_is_the_same_everywhere(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    one = exported(tmp_path / "checker.pyz")
    digest = hashlib.sha256(one.read_bytes()).hexdigest()
    assert capsys.readouterr().out == f"{digest}  {one}\n"
    monkeypatch.setenv("TZ", "Pacific/Kiritimati")
    monkeypatch.setattr(time, "time", lambda: 0.0)
    other = exported(tmp_path / "other.pyz")
    assert other.read_bytes() == one.read_bytes()
    exported(one)  # what is there is replaced, as by every command that writes a file
    assert one.read_bytes() == other.read_bytes()


def test_export_holds_the_files_as_they_are(tmp_path: Path) -> None:
    with zipfile.ZipFile(exported(tmp_path / "checker.pyz")) as archive:
        entries = archive.infolist()
        texts = {entry.filename: archive.read(entry) for entry in entries}
    assert [entry.filename for entry in entries] == sorted(texts)
    shapes = {
        (e.date_time, e.compress_type, e.external_attr, e.create_system, e.create_version, e.extract_version, e.extra) for e in entries
    }
    assert shapes == {((1980, 1, 1, 0, 0, 0), zipfile.ZIP_STORED, 0o100644 << 16, 3, 20, 20, b"")}
    main_file = texts.pop("__main__.py")
    assert texts == {f"checker/{path.name}": path.read_bytes() for path in CHECKER.glob("*.py")}
    run = [ast.unparse(statement).split("\n")[0] for statement in ast.parse(main_file).body[1:]]
    assert run == ["import sys", "if sys.version_info < (3, 10):", "from checker import main", "sys.exit(main())"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "no certificate is named; give CERTIFICATE.json, or --export FILE.pyz"),
        (["--table", "x"], "no certificate is named"),
        (["x", "--export", "y"], "--export writes the checker and checks nothing"),
        (["--export", "."], "name a file to write"),
        (["--export", "nowhere/checker.pyz"], "cannot be written"),
    ],
)
def test_export_and_checking_are_apart(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", *arguments]) == 2
    captured = capsys.readouterr()
    assert said in captured.err and not captured.out and captured.err.count("\n") == 1


@pytest.mark.parametrize("way", ["folder", "file"])
def test_an_old_python_is_told_so(tmp_path: Path, way: str) -> None:
    """What it would say first is a fault of syntax, and its exit code that of a false statement."""
    run = started(way, tmp_path)[-1]
    old = (
        f"import runpy, sys; sys.version_info = (3, 9, 18); sys.argv = ['checker', 'c.json']; runpy.run_path({run!r}, run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", old], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "The checker needs Python 3.10 or later, and this is 3.9.\n")
