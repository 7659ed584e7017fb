"""The tutorial from a real scan to a certificate: its commands as they stand there, in the folder that it asks for."""

from __future__ import annotations

import hashlib
import re
import shlex
import shutil
from pathlib import Path

import pytest

from fairaudit.cli import main

DOCS = Path(__file__).resolve().parents[3] / "docs"
PAGE = (DOCS / "robot-from-a-scan.md").read_text("utf-8")
BLOCK = re.compile(r"^```(sh|text)\n(.*?)^```", re.MULTILINE | re.DOTALL)
EXCEEDS, COLUMNS = 1, 80


def test_the_tutorial_does_what_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for file in ("room_scan1.pcd", "room.toml", "room-experiment.toml"):
        shutil.copy(DOCS / "scan" / file, tmp_path)
    assert f"SHA-256 `{hashlib.sha256((tmp_path / 'room_scan1.pcd').read_bytes()).hexdigest()}`" in PAGE
    monkeypatch.chdir(tmp_path)
    codes, printed = [], ""
    for language, text in BLOCK.findall(PAGE):
        if language == "sh":
            commands = [shlex.split(line)[1:] for line in text.replace("\\\n", " ").splitlines()]
            codes += [(" ".join(words[:2]), main(words)) for words in commands]
            printed = " ".join(capsys.readouterr().out.split())  # on the page, long lines are broken
        else:
            assert [part for part in text.split("…\n") if " ".join(part.split()) not in printed] == []
    assert max(len(line) for block in BLOCK.findall(PAGE) for line in block[1].splitlines()) <= COLUMNS
    assert [name.split()[0] for name, _ in codes] == ["navigation"] * 3 + ["experiment"] * 2 + ["verify", "navigation"]
    assert {name for name, code in codes if code} == {"experiment certify"}
    assert dict(codes)["experiment certify"] == EXCEEDS
    for name in ("candidates", "traversability"):
        shown = DOCS / "pictures" / f"scan-{name}.png"
        assert shown.read_bytes() == (tmp_path / "room-candidates" / f"{name}.png").read_bytes()
