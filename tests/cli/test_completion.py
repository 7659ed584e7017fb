"""Completion as shells ask for it: by argcomplete's protocol, in bash with its own script, and in zsh where that is there."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = ["answer", "sex", "age group", "last, first", "$(touch x)"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a table, and a command `fairaudit` that is this tree's."""
    monkeypatch.chdir(tmp_path)
    rows = [
        ("yes", "f", "old", "x", "1"),
        ("no", "m", "young", "y", "2"),
        ("maybe so", "m", "young", "y", "2"),
        ("a\nb", "m", "", "y", "2"),
    ]
    with Path("decisions.csv").open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    Path("bin").mkdir()
    tool = tmp_path / "bin" / "fairaudit"
    tool.write_text(f'#!/bin/sh\nPYTHONPATH={ROOT} exec {sys.executable} -m fairaudit "$@"\n')
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tool.parent}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    return tmp_path


def completions(line: str) -> list[str]:
    """What is answered to the protocol: the line in the environment, words on descriptor 8, separated as it asks."""
    read, write = os.pipe()
    environment = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line.encode())),
        "COMP_TYPE": "9",
        "_ARGCOMPLETE_IFS": "\013",
        "_ARGCOMPLETE_COMP_WORDBREAKS": " \t\n\"'><=;|&(:",
        "_ARGCOMPLETE_SHELL": "bash",
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
    }
    words = ["bash", "-c", f"exec 8>&{write} 9>/dev/null; exec fairaudit"]
    done = subprocess.run(words, env=environment, pass_fds=(write,), capture_output=True, text=True, check=False)
    os.close(write)
    with os.fdopen(read) as answer:
        found = answer.read()
    assert (done.stdout, done.stderr) == ("", "")
    return [word.rstrip(" ") if not word.endswith("\\ ") else word for word in found.split("\013") if word]


CASES = {
    "fairaudit cert": ["certify"],
    "fairaudit certify --max-local-r": ["--max-local-ratio"],
    "fairaudit certify --missing ": ["error", "drop", "group", "undecided", "unknown"],
    "fairaudit certify --example u": ["ucb-admissions"],
    "fairaudit certify decisions.csv --decision ": ["answer", "sex", "age\\ group", "last,\\ first", "\\$\\(touch\\ x\\)"],
    "fairaudit certify decisions.csv --decision a": ["answer", "age\\ group"],
    "fairaudit certify decisions.csv --group s": ["sex"],
    "fairaudit certify decisions.csv --group sex,a": ["sex,answer", "sex,age\\ group"],
    "fairaudit certify decisions.csv --decision answer --utility ": ["no", "yes", "maybe\\ so"],
    "fairaudit certify decisions.csv --decision answer --utility yes=1,m": ["1,maybe\\ so"],
    "fairaudit certify decisions.csv --group sex --unknown ": ["f", "m"],
    "fairaudit certify decisions.csv --max-local-ratio ": [],
    "fairaudit certify absent.csv --decision ": [],
    "fairaudit certify . --decision ": [],
    "fairaudit certify postgresql://nobody@127.0.0.1:1/x --decision ": [],
    "fairaudit verify dec": ["decisions.csv"],
    "fairaudit experiment pl": ["plot"],
}


@pytest.mark.parametrize(("line", "expected"), CASES.items(), ids=list(CASES))
def test_what_a_line_can_go_on_with(folder: Path, line: str, expected: list[str]) -> None:
    assert sorted(completions(line)) == sorted(expected)


def test_of_a_big_file_only_the_header_is_read(folder: Path) -> None:
    with Path("big.csv").open("w") as file:
        file.write("answer,sex\n" + "yes,f\n" * 700_000)
    assert completions("fairaudit certify big.csv --decision a") == ["answer"]
    assert completions("fairaudit certify big.csv --decision answer --utility ") == []


def test_bash_completes_by_the_script_of_argcomplete(folder: Path) -> None:
    """The function that a key press calls, with what bash would set."""
    script = """
        eval "$(register-python-argcomplete fairaudit)"
        words='fairaudit certify decisions.csv --group s'
        COMP_LINE=$words COMP_POINT=${#words} COMP_TYPE=9 COMP_WORDS=($words) COMP_CWORD=4
        registered=$(complete -p fairaudit)
        called=${registered##*-F }
        "${called%% *}" fairaudit s --group
        printf '%s\\n' "${COMPREPLY[@]}"
    """
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["sex"], done.stderr


def test_zsh_completes_by_the_script_of_argcomplete(folder: Path) -> None:
    if shutil.which("zsh") is None:
        pytest.skip("zsh is not on this machine")
    script = """
        autoload -Uz compinit && compinit -u -D
        eval "$(register-python-argcomplete fairaudit)"
        _describe() { print -rl -- ${(P)2} }
        words=(fairaudit certify decisions.csv --group s) CURRENT=5 BUFFER='fairaudit certify decisions.csv --group s' CURSOR=${#BUFFER}
        service=fairaudit
        _python_argcomplete
    """
    done = subprocess.run(["zsh", "-f", "-c", script], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["sex:"], done.stderr  # a word, and its description


def test_global_completion_finds_the_mark(folder: Path) -> None:
    """`activate-global-python-argcomplete` completes commands whose module has the mark in its first kilobyte."""
    for module in ("cli/__init__.py", "__main__.py"):
        assert "PYTHON_ARGCOMPLETE_OK" in (ROOT / "fairaudit" / module).read_text("utf-8")[:1024]


def test_without_argcomplete_the_command_says_what_it_always_says(folder: Path) -> None:
    (folder / "argcomplete.py").write_text("raise ImportError\n")
    words = [sys.executable, "-m", "fairaudit"]
    environment = {**os.environ, "_ARGCOMPLETE": "1", "PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
