"""What the pages show is what the program does."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
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


def test_the_example_of_the_readme_is_typed(tmp_path: Path) -> None:
    """As somebody's own file, with mypy as strict as it can be."""
    pytest.importorskip("mypy", reason="mypy is not installed (it is in the extra lint)")
    (example,) = blocks(ROOT / "README.md", "python")
    (tmp_path / "example.py").write_text(example)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", os.devnull, "--cache-dir", str(tmp_path / "cache"), "example.py"]
    done = subprocess.run(command, cwd=tmp_path, env={**os.environ, "MYPYPATH": str(ROOT)}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_readme_shows_the_first_result(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", "--example", "ucb-admissions"]) == 0
    printed = capsys.readouterr().out
    for page in (ROOT / "README.md", ROOT / "docs" / "start.md"):
        (shown,) = blocks(page, "text")
        for line in shown.splitlines():
            assert line == "…" or line in printed.splitlines()


@pytest.mark.parametrize(
    ("page", "codes"),
    [
        ("README.md", [("certify", 0), ("verify", 0), ("certify", 2)]),  # without a terminal nothing is asked
        ("docs/start.md", [("certify", 0), ("report", 0), ("verify", 0)]),
        ("docs/calibration.md", [("calibrate", 0), ("calibrate", 0)]),
    ],
)
def test_first_commands_are_accepted(page: str, codes: list[tuple[str, int]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "decisions.xlsx").write_bytes(b"")
    ran = []
    for text in blocks(ROOT / page, "sh"):
        for part in re.split(r"&&|(?<!\\)\n", text):
            words = shlex.split(part.replace("\\\n", " "))
            if words and words[0].endswith("fairaudit"):
                ran.append((words[1], main(words[1:])))
    assert ran == codes


def test_a_spreadsheet_without_options_is_answered_by_a_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl is not installed (it is in the extra test)")
    book, path = openpyxl.Workbook(), tmp_path / "decisions.xlsx"
    for row in [("answer", "sex", "department"), *[("yes", "f", "a"), ("no", "m", "b"), ("yes", "m", "a")] * 40]:
        book.active.append(row)
    book.save(path)
    assert main(["certify", str(path)]) == 2
    proposed = capsys.readouterr().err.partition("to try: fairaudit ")[2].strip()
    assert main(shlex.split(proposed)) == 0


def test_every_command_answers_a_question(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    commands = re.findall(r"^    ([a-z-]+)(?:\s|$)", capsys.readouterr().out, re.MULTILINE)
    assert len(commands) >= 14
    page = (ROOT / "docs" / "which-command.md").read_text("utf-8")
    assert [each for each in commands if f"`fairaudit {each}" not in page] == []


def test_pages_say_for_whom_they_are_before_anything_else() -> None:
    """A title, then a paragraph: no heading, no table, no code, no list."""
    first = {page.name: page.read_text("utf-8").split("\n\n", 2)[1] for page in PAGES}
    assert {name: text for name, text in first.items() if re.match(r"[#|`*-]|\d\.", text)} == {}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_tables_begin_after_a_blank_line(page: Path) -> None:
    """Or a comment, which no page shows: what follows a line of text is a part of it, and no table."""
    lines = page.read_text("utf-8").splitlines()
    heads = [number - 1 for number, line in enumerate(lines) if re.fullmatch(r"\|( ?:?-+:? ?\|)+", line)]
    assert [lines[head] for head in heads if head and lines[head - 1].strip() and not lines[head - 1].startswith("<!--")] == []
