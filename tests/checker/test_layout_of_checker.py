"""The checker as something to read: small files, one order, nothing that runs unseen; and what docs/verify.md says of it."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest
from trusted_files import CHECKER, PAGE, UNRELEASED, digest, executed, listed, order, plain_certificates, released, written

from fairaudit import __version__, checker

FILES = sorted(CHECKER.glob("*.py"))


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    return executed(plain_certificates(tmp_path_factory.mktemp("plain")))


def test_files_are_short() -> None:
    assert max(len(path.read_text("utf-8").splitlines()) for path in FILES) < 500


def test_the_order_of_reading_is_that_of_the_contract() -> None:
    table = (checker.__doc__ or "").partition("The files can be read")[2]
    named = [name for line in table.splitlines() for name in line.split("``")[1::2] if f"{name}.py" in order()]
    assert [f"{name}.py" for name in named] == [name for name in order() if name != "__main__.py"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_standard_library_is_all_that_is_needed(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            assert all(alias.name.partition(".")[0] in sys.stdlib_module_names for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level == 1 or (node.level == 0 and (node.module or "").partition(".")[0] in sys.stdlib_module_names)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_only_define(path: Path) -> None:
    """So that a file of which no function runs has no say in what is found."""
    allowed = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.ClassDef, ast.Assign, ast.AnnAssign)
    for statement in ast.parse(path.read_text("utf-8")).body:
        if isinstance(statement, ast.Expr):
            assert isinstance(statement.value, ast.Constant)
        elif isinstance(statement, ast.If):
            assert path.name == "__main__.py" and ast.unparse(statement.test) == "__name__ == '__main__'"
        else:
            assert isinstance(statement, allowed)
            targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", ast.Name())]
            assert all(
                isinstance(name, ast.Name | ast.Tuple) for target in targets for name in ast.walk(target) if isinstance(name, ast.expr)
            )


def test_the_page_lists_what_runs(functions: dict[str, set[str]]) -> None:
    page = PAGE.read_text("utf-8")
    row = next((line for line in page.splitlines() if line.startswith(f"| {__version__} |")), "").split("|")[2].strip()
    assert listed(functions) in page, "python tests/trusted_files.py writes the list"
    assert written(page, functions, __version__, row) == page


def test_the_page_has_the_digest_of_a_release() -> None:
    expected = f"`{digest()}`" if released() else UNRELEASED
    assert f"| {__version__} | {expected} |" in PAGE.read_text("utf-8"), "python tests/trusted_files.py writes the row"


def test_a_plain_certificate_needs_nothing_of_intervals_policies_and_classes(functions: dict[str, set[str]]) -> None:
    assert not functions.keys() & {
        "filters.py",
        "program.py",
        "worst_case.py",
        "bounds.py",
        "tails.py",
        "plain_ends.py",
        "passing.py",
        "moved_ends.py",
        "samples.py",
        "regions.py",
        "betting.py",
        "paired_betting.py",
        "symmetric_betting.py",
        "joint_betting.py",
    }
