"""What the pages show is what the program does."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from fairaudit.cli import main

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    return [text for found, text in BLOCK.findall(page.read_text("utf-8")) if found == language]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Blocks of a page run in order in one namespace; a comment ``# …`` after a print is what it prints."""
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {}
    for text in blocks(page, "python"):
        exec(compile(text, page.name, "exec"), namespace)  # noqa: S102
        printed = capsys.readouterr().out
        for expected in re.findall(r"^print\(.*\)\s+# (.+)$", text, re.MULTILINE):
            assert expected in printed


def test_readme_shows_the_first_result(capsys: pytest.CaptureFixture[str]) -> None:
    (shown,) = blocks(ROOT / "README.md", "text")
    assert main(["certify", "--example", "ucb-admissions"]) == 0
    printed = capsys.readouterr().out
    for line in shown.splitlines():
        assert line == "…" or line in printed


def test_readme_commands_are_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "decisions.csv").write_text("answer,sex,age,department\nyes,f,30,a\nno,f,30,a\nmaybe,m,30,a\nyes,m,30,a\n")
    rows = ['{"answer":"yes","sex":"f","department":"a"}', '{"answer":"no","sex":"m","department":"a"}']
    (tmp_path / "decisions.jsonl").write_text("\n".join(rows * 5) + "\n")
    (tmp_path / "choices.csv").write_text("shown_order,chosen\nann bob,ann\nbob ann,ann\n")
    ran = []
    for text in blocks(ROOT / "README.md", "sh"):
        for part in re.split(r"&&|(?<!\\)\n", text):
            words = shlex.split(part.replace("\\\n", " "))
            if words and words[0].endswith("fairaudit"):
                ran.append((words[1], main(words[1:])))
    commands = [
        "certify",
        "verify",
        "report",
        "inspect",
        "certify",
        "plan",
        "monitor",
        "certify",
        "calibrate",
        "calibrate",
        "worst-case",
        "certify",
        "experiment",
    ]
    assert [command for command, _ in ran] == commands
    assert [code for _, code in ran] == [0, 0, 0, 0, 3, 0, 3, 3, 0, 0, 0, 0, 0]
