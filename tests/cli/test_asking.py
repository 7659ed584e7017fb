"""`certify TABLE` alone: questions on a terminal, a command to try elsewhere; both give the certificate of that command."""

from __future__ import annotations

import os
import pty
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from fairaudit.cli import main

TABLE = "Dept,Gender,Admit,Freq\n" + "".join(
    f"{x},{a},{u},{n}\n"
    for x, a, u, n in (
        ("A", "f", "yes", 89), ("A", "f", "no", 19), ("A", "m", "yes", 512), ("A", "m", "no", 313),
        ("B", "f", "yes", 17), ("B", "f", "no", 8), ("B", "m", "yes", 353), ("B", "m", "no", 207),
    )
)  # fmt: skip


def on_terminal(words: list[str], answers: list[str]) -> tuple[str, int]:
    """Run the command on a terminal, and give its answers as soon as it asks."""
    master, terminal = pty.openpty()
    child = subprocess.Popen([sys.executable, "-m", "fairaudit", *words], stdin=terminal, stdout=terminal, stderr=terminal)
    os.close(terminal)
    said, left = b"", list(answers)
    while True:
        try:
            part = os.read(master, 1 << 16)
        except OSError:
            break
        if not part:
            break
        said += part
        if said.rstrip(b" ").endswith(b"]") and left:
            os.write(master, left.pop(0).encode() + b"\n")
    os.close(master)
    return said.decode().replace("\r", ""), child.wait(60)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "admissions.csv"
    path.write_text(TABLE)
    return path


def command_in(said: str) -> list[str]:
    return shlex.split(next(line for line in said.splitlines() if line.strip().startswith("fairaudit certify")))[1:]


def test_enter_takes_what_was_guessed(table: Path, tmp_path: Path) -> None:
    said, code = on_terminal(["certify", str(table), "-o", str(tmp_path / "asked.json")], [""] * 5)
    assert code == 0, said
    command = command_in(said)
    assert command[2:] == ["--decision", "Admit", "--group", "Gender", "--context", "Dept", "--count", "Freq", "--utility", "yes"]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


def test_answers_are_corrected_and_asked_again(table: Path, tmp_path: Path) -> None:
    answers = ["Admitt", "Admit,Dept", "Admit", "maybe", "no", "bad", "harm", "Sex", "-", "Gender,Gender", "Gender", '"', "-"]
    said, code = on_terminal(["certify", str(table), "-o", str(tmp_path / "asked.json")], answers)
    assert code == 0, said
    for expected in (
        "did you mean 'Admit'?",
        "One column is needed",
        "'maybe' is none of them",
        "known: 'good', 'harm'",
        "no column 'Sex'",
    ):
        assert expected in said
    command = command_in(said)
    assert command[2:] == ["--decision", "Admit", "--group", "Gender", "--count", "Freq", "--utility", "no", "--burden"]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


def test_where_nobody_can_be_asked_a_command_is_proposed(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", str(table)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("fairaudit: no column was named")
    command = shlex.split(err.partition("to try: ")[2])[1:]
    assert main(command) == 0


def test_labels_with_commas_and_names_with_dashes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "odd.csv"
    path.write_text('-decision,"sex, given",n\n"yes, at once",f,3\nno,f,4\n"yes, at once",m,5\nno,m,1\n')
    said, code = on_terminal(["certify", str(path)], [""] * 5)
    assert code == 0, said
    assert main(command_in(said)) == 0
    capsys.readouterr()


def test_a_file_that_cannot_be_read_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, content in (("gone.csv", None), ("empty.csv", ""), ("odd.xlsx", "PK\x03\x04")):
        path = tmp_path / name
        if content is not None:
            path.write_text(content)
        assert main(["certify", str(path)]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert name in err


def test_the_end_of_the_input_interrupts(table: Path) -> None:
    said, code = on_terminal(["certify", str(table)], ["\x04"])
    assert code == 130, said
