"""What runs of the checker when it checks a plain certificate: docs/verify.md lists it, with the digest of the checker as one file.

`python tests/trusted_files.py` writes both into the page, `python tests/trusted_files.py --release` with the digest of this version.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import inspect
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
CHECKER = ROOT / "fairaudit" / "checker"
PAGE = ROOT / "docs" / "verify.md"
UNRELEASED = "made from the tree; `fairaudit verify --export` prints it"


def _loaded() -> ModuleType:
    """A checker of its own, in which nothing is cached."""
    spec = importlib.util.spec_from_file_location("traced_checker", CHECKER / "__init__.py", submodule_search_locations=[str(CHECKER)])
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["traced_checker"] = module
    spec.loader.exec_module(module)
    return module


def plain_certificates(folder: Path) -> list[list[str]]:
    """Certificates of a table of counts without intervals, without and with targets, with the table within and beside it."""
    import fairaudit as fa

    columns = {
        "answer": ["yes", "maybe", "no"] * 5,
        "sex": ["f"] * 3 + ["m"] * 3 + ["f"] * 3 + ["m"] * 3 + ["f"] * 3,
        "department": ["A"] * 6 + ["B"] * 6 + ["C"] * 3,
        "n": [30, 3, 10, 20, 0, 20, 5, 5, 5, 4, 1, 9, 2, 0, 2],
    }
    law = fa.Law.from_counts(columns, decision="answer", group="sex", context="department", count="n")
    arguments: list[list[str]] = []
    for i, options in enumerate(({}, {"max_local_ratio": "4/3", "max_global_log": "0.3"}, {"embed_table": False})):
        path = folder / f"{i}.json"
        _, *beside = fa.certify(law, {"yes": 1, "maybe": "1/2"}, confidence=None, **options).certificate.save(path)
        arguments.append([str(path), *(part for table in beside for part in ("--table", str(table)))])
    return arguments


def executed(arguments: Iterable[list[str]]) -> dict[str, set[str]]:
    """Trace the command: the functions that run, by file; what runs when files are imported is left out."""
    checker = _loaded()
    functions: dict[str, set[str]] = {}
    inside = f"{CHECKER}/"

    def trace(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        if (
            event == "call" and code.co_filename.startswith(inside) and code.co_flags & inspect.CO_NEWLOCALS
        ):  # no module, no body of a class
            functions.setdefault(Path(code.co_filename).name, set()).add(code.co_qualname.partition(".<locals>")[0])

    before = sys.gettrace()
    for each in arguments:
        sys.settrace(trace)
        try:
            code = checker.main(each)
        finally:
            sys.settrace(before)
        assert code == 0
    return functions


def lines_of(name: str, functions: set[str]) -> int:
    """Count the lines of some functions of a file."""
    tree = ast.parse((CHECKER / name).read_text("utf-8"))
    found = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    for kind in tree.body:
        if isinstance(kind, ast.ClassDef):
            found |= {f"{kind.name}.{node.name}": node for node in kind.body if isinstance(node, ast.FunctionDef)}
    outside = functions - found.keys()
    assert outside <= {"<lambda>", "<genexpr>", "<listcomp>", "<dictcomp>", "<setcomp>"}
    return sum((found[name].end_lineno or 0) - found[name].lineno + 1 for name in functions - outside)


def order() -> list[str]:
    """The files in the order in which they are read, as the import contract has it."""
    contract = (ROOT / "pyproject.toml").read_text("utf-8").partition('containers = ["fairaudit.checker"]')[2]
    layers = re.findall(r'"(\w+)"', contract.partition("layers = [")[2].partition("]")[0])
    return [f"{name}.py" for name in reversed(layers)]


def listed(functions: dict[str, set[str]]) -> str:
    """The table of files: all their lines, and those of the functions that run."""
    names = [name for name in order() if name in functions]
    rows = [(name, len((CHECKER / name).read_text("utf-8").splitlines()), lines_of(name, functions[name])) for name in names]
    rows.append(("together", sum(n for _, n, _ in rows), sum(n for _, _, n in rows)))
    cells = [f"| {f'`{name}`' if '.' in name else name} | {n:,} | {run:,} |" for name, n, run in rows]
    return "\n".join(["| file | lines | of functions that run |", "| --- | --: | --: |", *cells])


def digest() -> str:
    """The SHA-256 of the checker as one file."""
    from fairaudit.cli.checking import zipped_checker

    return hashlib.sha256(zipped_checker()).hexdigest()


def released() -> bool:
    """Whether the changelog has a date, or nothing, where a version that is still to come says so."""
    heading = re.search(r"^## .*$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert heading is not None
    return "unreleased" not in heading[0].lower()


def written(page: str, functions: dict[str, set[str]], version: str, value: str) -> str:
    """The page with the list of files, and with the row of a version."""
    begin, end = "<!-- files -->\n\n", "\n\n<!-- end of files -->"
    before, rest = page.split(begin)
    page = before + begin + listed(functions) + end + rest.split(end)[1]
    row = f"| {version} | {value} |"
    there = re.compile(rf"^\| {re.escape(version)} \|.*$", re.MULTILINE)
    if there.search(page):
        return there.sub(row, page)
    before, head, rest = page.partition("| release | SHA-256 of `checker.pyz` |\n| --- | --- |\n")
    return f"{before}{head}{row}\n{rest}"


if __name__ == "__main__":
    import contextlib
    import io
    import tempfile

    from fairaudit import __version__

    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        found = executed(plain_certificates(Path(folder)))
    value = f"`{digest()}`" if "--release" in sys.argv or released() else UNRELEASED
    PAGE.write_text(written(PAGE.read_text("utf-8"), found, __version__, value), "utf-8")
