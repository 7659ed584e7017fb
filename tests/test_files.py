"""Saved files: whole or not there at all, whenever the writer dies."""

from __future__ import annotations

import os
import pickle
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from certificate_kinds import (
    assert_accepted,
    small_counts,
)
from needs import POSIX

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import Certificate
from fairaudit.files import write_atomically, write_together

# Files appear whole or not at all

SAVER = """
import pickle, sys
from pathlib import Path
certificates = pickle.loads(Path(sys.argv[1]).read_bytes())
print("ready", flush=True)
while True:
    for certificate in certificates:
        certificate.save(sys.argv[2])
"""


def killed_while_saving(pickled: Path, target: Path, delay: float) -> None:
    command_line = [sys.executable, "-c", SAVER, str(pickled), str(target)]
    with subprocess.Popen(command_line, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        ready = process.stdout.readline()
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, process.stderr.read()
        assert ready == b"ready\n"


def big(seed: int, embed: bool) -> Certificate:
    pick = random.Random(seed)
    array = [[[pick.randint(1, 10**6), pick.randint(1, 10**6)] for _ in range(2)] for _ in range(2000)]
    return fa.certify(fa.Law.from_array(array, kind="counts"), {"0": 1}, confidence=None, embed_table=embed).certificate


@POSIX
def test_kill_while_saving(tmp_path: Path) -> None:
    """Killed at any moment, a save leaves the old file or the new one, and never a part of one."""
    pick = random.Random(1)
    certificates = [big(1, True), big(2, True)]
    for certificate in certificates:
        assert_accepted(certificate)
    whole = {certificate.text.encode() for certificate in certificates}
    (tmp_path / "pickled").write_bytes(pickle.dumps(certificates))
    target = tmp_path / "c.json"
    kills = 0
    while kills < 10 or not target.exists():
        assert kills < 100
        killed_while_saving(tmp_path / "pickled", target, pick.uniform(0, 0.15 + 0.01 * kills))
        assert not target.exists() or target.read_bytes() in whole
        kills += 1
    assert checker.main([str(target)]) == 0


@POSIX
def test_kill_while_saving_a_table(tmp_path: Path) -> None:
    pick = random.Random(2)
    certificate = big(3, False)
    assert certificate.table is not None
    whole, text = b"".join(certificate.table.lines()), certificate.text.encode()
    assert_accepted(certificate)
    (tmp_path / "pickled").write_bytes(pickle.dumps([certificate]))
    kills, complete, partial = 0, 0, 0
    while kills < 10 or not (complete and partial):  # until some kills have hit a save in its middle, and some not
        assert kills < 100
        directory = tmp_path / str(kills)
        directory.mkdir()
        killed_while_saving(tmp_path / "pickled", directory / "c.json", pick.uniform(0, 0.02 + 0.01 * kills))
        kills += 1
        beside = directory / "c.table.jsonl"
        assert not beside.exists() or beside.read_bytes() == whole
        if (directory / "c.json").exists():  # then its table is there too
            assert (directory / "c.json").read_bytes() == text and beside.exists()
            complete += 1
        partial += any(path.name.endswith(".part") for path in directory.iterdir())


def test_failure_while_saving(tmp_path: Path) -> None:
    def lines() -> Iterator[bytes]:
        yield b"x" * 10**6
        raise RuntimeError("in the middle")

    target = tmp_path / "c.json"
    target.write_bytes(b"before")
    with pytest.raises(RuntimeError, match="in the middle"):
        write_atomically(target, lines())
    assert [path.name for path in tmp_path.iterdir()] == ["c.json"] and target.read_bytes() == b"before"
    with pytest.raises(fa.InputError, match="directory"):
        small_counts().certificate.save(tmp_path)
    with pytest.raises(fa.InputError, match="cannot be written"):
        small_counts().certificate.save(tmp_path / "nowhere" / "c.json")


def test_saved_files_have_ordinary_permissions(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    for path in small_counts(embed_table=False).certificate.save(tmp_path / "c.json"):
        assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode
        assert os.access(path, os.R_OK)


@pytest.mark.parametrize("links", [True, False])
def test_a_failure_between_two_files_puts_back_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool) -> None:
    if not links:  # as on file systems where a file has one name
        monkeypatch.setattr(os, "link", lambda *_: (tmp_path / "no link").stat())
    old, new, last = tmp_path / "old", tmp_path / "new", tmp_path / "last"
    old.write_bytes(b"before")
    old.chmod(0o640)
    before = old.stat()

    def lines() -> Iterator[bytes]:
        yield b"x"
        (last / "full").mkdir(parents=True)

    with pytest.raises(fa.InputError, match="last cannot be written: "):
        write_together([(old, [b"after"]), (new, [b"after"]), (last, lines())])
    assert old.read_bytes() == b"before" and old.stat().st_mode == before.st_mode and (old.stat().st_ino == before.st_ino or not links)
    assert {path.name for path in tmp_path.iterdir()} == {"old", "last"}


def test_half_a_copy_does_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a full disc whose files have one name."""

    def full(_: Path, old: str) -> None:
        Path(old).write_bytes(b"bef")
        raise OSError(28, "No space left on device")

    (tmp_path / "a").write_bytes(b"before")
    monkeypatch.setattr(os, "link", lambda *_: (tmp_path / "no link").stat())
    monkeypatch.setattr(shutil, "copy2", full)
    with pytest.raises(fa.InputError, match="a cannot be written: No space left"):
        write_together([(tmp_path / "a", [b"after"]), (tmp_path / "b", [b"after"])])
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"before"}


def test_what_cannot_be_put_back_stays_beside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_bytes(b"before")
    replace, calls = os.replace, []

    def once(*names: Path) -> None:
        calls.append(names)
        if len(calls) > 1:
            raise OSError(5, "the disc is gone")
        replace(*names)

    monkeypatch.setattr(os, "replace", once)
    with pytest.raises(fa.InputError, match="the disc is gone"):
        write_together([(tmp_path / "a", [b"after"]), (tmp_path / "b", [b"after"])])
    [kept] = tmp_path.glob(".fairaudit-*.part")
    assert kept.read_bytes() == b"before"


def test_what_was_there_is_not_kept_once_all_is_written(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).write_bytes(b"before")
    write_together([(tmp_path / name, [b"after"]) for name in ("a", "b")])
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"after", "b": b"after"}


@pytest.mark.parametrize("rights", [0o600, 0o640, 0o444])
def test_a_file_keeps_its_rights(tmp_path: Path, rights: int) -> None:
    path = tmp_path / "c.json"
    path.write_bytes(b"before")
    path.chmod(rights)
    write_atomically(path, [b"after"])
    assert path.read_bytes() == b"after" and path.stat().st_mode & 0o7777 == rights
