"""Random bytes and damaged tables through the command line: an exit code and a sentence, whatever is in the file.

``FAIRAUDIT_FUZZ=100000 pytest tests/tables/test_tables.py`` tries that many of each kind.
"""

from __future__ import annotations

import contextlib
import io
import os
import shlex
import tempfile
import unicodedata
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from damage import PIECES, TABLES, damaged, filled
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fairaudit.cli import main

EXAMPLES = int(os.environ.get("FAIRAUDIT_FUZZ", "300"))
SEEDED = "FAIRAUDIT_FUZZ" not in os.environ
STEERING = {"Cc", "Cf", "Cs", "Co", "Zl", "Zp"}
fuzzed = settings(
    max_examples=EXAMPLES,
    derandomize=SEEDED,
    database=None,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example],
)
FORMS = (
    ("--decision=d", "--group=g", "--context=x", "--count=n", "--utility=yes"),
    ("--decision=d", "--group=g", "--context=x", "--probability=n", "--utility=yes=1,no=0.5"),
    ("--decision=d", "--group=g,x", "--utility-column=n"),
    ("--group=g", "--utility-column=n", "--context=x"),
    ("--decision=d", "--group=g", "--probability=n", "--weight=x", "--utility=yes"),
    ("--decision=d", "--group=g,x", "--utility=no,yes=1/3"),
)
MORE = (
    (),
    ("--missing=drop",),
    ("--missing=group", "--format=json"),
    ("--max-local-log=0.1", "--confidence=none"),
    ("--max-global-ratio=5/4", "--confidence=none", "--top=1"),
)


def outcome(words: Sequence[str]) -> tuple[int, str, str]:
    """Exit code and what was printed, of the command line in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(words)
        except SystemExit as stop:
            code = -1 if not isinstance(stop.code, int) else stop.code
    return code, out.getvalue(), err.getvalue()


def judge(words: Sequence[str], code: int, out: str, err: str) -> None:
    """Whether that is what the command line promises."""
    assert code in (0, 1, 2, 3), words
    lines = err.removesuffix("\n").split("\n") if err else []
    sentences = [line for line in lines if not line.startswith("note: ")]
    assert all(c == "\n" or unicodedata.category(c) not in STEERING for c in out + err), (words, out, err)
    if code == 2:
        assert out == ""
        assert len(sentences) == 1, (words, err)
        assert sentences[0].startswith("fairaudit: "), (words, err)
    else:
        assert out
        assert sentences == [], (words, err)


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="fairaudit-fuzz-") as name:
        yield Path(name)


def audit(folder: Path, content: bytes, options: Sequence[str]) -> None:
    table, certificate = folder / "table.csv", folder / "out.json"
    table.write_bytes(content)
    words = ["certify", str(table), "-o", str(certificate), *options]
    code, out, err = outcome(words)
    judge(words, code, out, err)
    assert {path.name for path in folder.iterdir()} == ({"table.csv"} if code == 2 else {"table.csv", "out.json"})
    if code != 2:
        verified, said, complaint = outcome(["verify", str(certificate)])
        judge(["verify"], verified, said, complaint)
        assert verified == 0, said
        certificate.unlink()


def look(folder: Path, content: bytes) -> None:
    table = folder / "table.csv"
    table.write_bytes(content)
    code, out, err = outcome(["inspect", str(table)])
    judge(["inspect"], code, out, err)
    assert code in (0, 2)
    if code == 2:
        return
    command = out.splitlines()[-1]
    if "\\" in command or "COL" in command:  # characters that were escaped for the terminal, or something to fill in
        return
    code, out, err = outcome(shlex.split(command)[1:])
    judge([command], code, out, err)
    assert "there is no column" not in err, (command, err)
    assert "does not occur" not in err, (command, err)
    assert "unrecognized" not in err, (command, err)


@given(st.one_of(st.binary(max_size=60), st.lists(st.sampled_from(PIECES), max_size=30).map(b"".join)), st.sampled_from(FORMS))
@fuzzed
def test_random_bytes(folder: Path, content: bytes, form: tuple[str, ...]) -> None:
    audit(folder, content, form)
    look(folder, content)


@given(damaged(), st.sampled_from(FORMS), st.sampled_from(MORE))
@fuzzed
def test_damaged_tables(folder: Path, content: bytes, form: tuple[str, ...], more: tuple[str, ...]) -> None:
    audit(folder, content, (*form, *more))
    look(folder, content)


@given(filled(), st.sampled_from(FORMS), st.sampled_from(MORE))
@fuzzed
def test_odd_cells(folder: Path, content: bytes, form: tuple[str, ...], more: tuple[str, ...]) -> None:
    audit(folder, content, (*form, *more))
    look(folder, content)


WORDS = st.one_of(st.text(max_size=20), st.text("yesnodgx ,=\"'\n\r-\\0123456789/.e\x1b\u202e\udcff", max_size=12))
OPTIONS = ("--utility", "--group", "--context", "--decision", "--max-local-log", "--top", "--count", "-o", "")


@given(WORDS, st.sampled_from(OPTIONS))
@fuzzed
def test_random_words(folder: Path, text: str, option: str) -> None:
    """Values of options; the table is good."""
    assume(option or not text.startswith(("-o", "--o")))  # those would write somewhere else
    (folder / "table.csv").write_bytes(TABLES[0])
    output = folder / "output"
    output.mkdir(exist_ok=True)
    value = f"{output}/{text.replace('/', '')}" if option == "-o" else text
    assume(value != f"{output}/..")
    words = ["certify", str(folder / "table.csv"), *FORMS[0], "--confidence=none", *([option, value] if option else [text])]
    code, out, err = outcome(words)
    written = list(output.iterdir())
    for path in written:
        path.unlink()
    output.rmdir()
    if not (code == 0 and out.startswith("usage: ")):  # -h
        judge(words, code, out, err.replace("fairaudit certify: ", "fairaudit: ", 1) if code == 2 else err)
        assert len(written) == (option == "-o" and code == 0)
