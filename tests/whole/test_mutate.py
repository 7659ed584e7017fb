"""The tool behind ``make mutate``, on a small project: what it changes, what survives, and that it leaves the tree alone."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import mutate
import pytest

TOY = '''"""A module."""

from functools import cache


def larger(a: int, b: int = 0) -> int:
    """The larger one of two."""
    return a if a > b else b


@cache
def twice(a: int) -> int:
    if a < 0:
        raise ValueError(f"{a + 1} is negative")
    return a + a
'''

TESTS = """from toy.numbers import larger, twice


def test_larger():
    assert larger(2, 1) == larger(1, 2) == 2


def test_that_it_runs():
    twice(3)


def test_what_is_cached():
    assert twice(3) == 6
"""


def changed(source: str) -> set[tuple[str, str]]:
    """What is replaced, and by what."""
    return {(source.encode()[one.start : one.end].decode(), one.new) for one in mutate.mutants(source)}


def test_mutants_are_small_errors_of_what_is_calculated() -> None:
    assert changed(TOY) == {
        ("0", "(1)"),
        ("0", "(-1)"),
        ("a > b", "(a >= b)"),
        ("a > b", "(a <= b)"),
        ("a > b", "True"),
        ("a > b", "False"),
        ("a < 0", "(a <= 0)"),
        ("a < 0", "(a >= 0)"),
        ("a < 0", "True"),
        ("a < 0", "False"),
        ('raise ValueError(f"{a + 1} is negative")', "pass"),
        ("a + a", "(a - a)"),
    }


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = min(a, -1)", {("min", "max"), ("-1", "(1)"), ("1", "(2)"), ("1", "(0)")}),
        ("x = not a or b", {("not a or b", "(not a and b)"), ("not a", "(a)")}),
        ("return a <= b", {("a <= b", "(a < b)"), ("a <= b", "(a > b)"), ("a <= b", "(not (a <= b))")}),
        ("while a: f(a)", {("a", "False"), ("f(a)", "pass")}),
        ("x = [a for a in b if a]", {("a", "True")}),
        ("é = a * (b // c)", {("a * (b // c)", "(a // (b // c))"), ("b // c", "(b * c)")}),
        ("zip(a, b, strict=True)", {("zip(a, b, strict=True)", "pass")}),
        ("'a' + b", set()),
        ("__all__ = ['a'][:1]", set()),
    ],
)
def test_each_kind_of_mutant(source: str, expected: set[tuple[str, str]]) -> None:
    assert changed(source) == expected


def test_a_mutant_replaces_what_it_names_and_nothing_else() -> None:
    data = TOY.encode()
    for one in mutate.mutants(TOY):
        compile(data[: one.start] + one.new.encode() + data[one.end :], "toy", "exec")
        assert data.count(b"\n", 0, one.start) + 1 in one.lines


def test_survivors_are_listed_and_the_tree_stays_as_it_is(tmp_path: Path) -> None:
    files = {"toy/__init__.py": "", "toy/numbers.py": TOY, "tests/test_numbers.py": TESTS, "pyproject.toml": "[tool.pytest.ini_options]\n"}
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    command = [sys.executable, mutate.__file__, "toy/numbers.py", "--lines", "13", "15"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert "toy/numbers.py: 8 of 8 mutants, seed 0\n" in done
    survived = re.findall(r"^survived \d+ tests of -m 'not deep': toy/numbers.py:(\d+): (.*)$", done, re.MULTILINE)
    assert [(int(line), change) for line, change in survived] == [
        (13, "a < 0 -> (a <= 0)"),
        (13, "a < 0 -> False"),
        (13, "0 -> (-1)"),
        (13, "0 -> (1)"),
        (14, 'raise ValueError(f"{a + 1} is negative") -> pass'),
    ]
    assert re.search(r"^-m 'not deep': 3 tests; 3 of 8 killed so far, 0 here by time$", done, re.MULTILINE)
    assert len(re.findall(r"^survived 0 tests of -m 'deep or again': toy", done, re.MULTILINE)) == len(survived)
    assert re.search(r"^-m 'deep or again': 0 tests; 3 of 8 killed so far, 0 here by time$", done, re.MULTILINE)
    assert {str(path.relative_to(tmp_path)): path.read_text() for path in tmp_path.rglob("*") if path.is_file()} == files
