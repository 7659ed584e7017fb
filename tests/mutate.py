"""Measure the power of the tests: change one module in many small ways, and count the changes that the tests notice (``make mutate``).

Each tier of tests runs once on a copy of the tree, to learn which tests reach which line. Then each mutant replaces the module in the copy.
The tests that reach its line run, quickest first, until one fails; then the others of their files, which may find cached what the line
gave. A mutant that survives a tier meets the next one. The working tree is only read.

Docstrings, annotations, decorators, texts and messages stay as they are. Lines that only other processes reach count as not reached.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import importlib.util
import multiprocessing
import os
import random
import re
import shutil
import signal
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import coverage
import pytest

TIERS = {"default": ("not deep",), "deep": ("deep or again",), "all": ("not deep", "deep or again")}
LONGEST = 120.0  # seconds of tests that a mutant meets in one tier
HEAVY = ("numpy", "scipy.optimize", "scipy.special", "pandas", "duckdb")  # imported once for all runs, where tests import it
GRACE = 30.0  # seconds beyond four times what the tests took without a mutant
LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "build", "dist", ".*_cache", ".hypothesis", "__pycache__", "*.vo*", "*.glob", "*.aux")
SWAPS = "Lt LtE GtE, LtE Lt Gt, Gt GtE LtE, GtE Gt Lt, Eq NotEq, NotEq Eq, In NotIn, NotIn In, Is IsNot, IsNot Is"
CALCULATIONS = "Add Sub, Sub Add, Mult FloorDiv, Div Mult, FloorDiv Mult, Mod FloorDiv, Pow Mult, LShift RShift, RShift LShift"
OPERATORS = {getattr(ast, old): [getattr(ast, name) for name in new] for old, *new in map(str.split, f"{SWAPS}, {CALCULATIONS}".split(","))}
CALLED = {"min": "max", "max": "min", "any": "all", "all": "any", "floor": "ceil", "ceil": "floor"}
UNCHANGED = {"annotation", "returns", "decorator_list", "bases"}


class Mutant(NamedTuple):
    """A part of the source, by its bytes, another text for it, and the lines of the statement that it is in."""

    start: int
    end: int
    new: str
    lines: range


class Reached(NamedTuple):
    """What a tier says without a mutant: seconds of each test that passes, which of them reach a line, and what they import."""

    seconds: dict[str, float]
    by_line: dict[int, set[str]]
    heavy: list[str]


def mutants(source: str) -> list[Mutant]:
    """All mutants of a module, in the order of the source."""
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def found(node: ast.AST, lines: range) -> Iterator[Mutant]:
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            lines = range(node.lineno, body[0].lineno if body and body[0].lineno > node.lineno else (node.end_lineno or 0) + 1)
        for at, new in _changes(node):
            place = starts[at.lineno - 1] + at.col_offset, starts[(at.end_lineno or 0) - 1] + (at.end_col_offset or 0)
            yield Mutant(*place, new, lines)
        if isinstance(node, (ast.Raise, ast.JoinedStr)) or (isinstance(node, ast.Assign) and "__all__" in ast.unparse(node.targets[0])):
            return
        for field, value in ast.iter_fields(node):
            for child in value if isinstance(value, list) else [value]:
                strict = isinstance(child, ast.keyword) and child.arg == "strict"
                if isinstance(child, ast.AST) and field not in UNCHANGED and not strict:
                    yield from found(child, lines)

    return sorted(set(found(ast.parse(source), range(0))), key=lambda one: one[:3])


def _changes(node: ast.AST) -> Iterator[tuple[Any, str]]:
    """Parts of a node, and what takes their places."""

    def anew(**fields: Any) -> str:
        return f"({ast.unparse(type(node)(**{**vars(node), **fields}))})"

    match node:
        case ast.Compare(ops=ops):
            for i, op in enumerate(ops):
                yield from ((node, anew(ops=[*ops[:i], new(), *ops[i + 1 :]])) for new in OPERATORS[type(op)])
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            if not any(isinstance(side, (ast.JoinedStr, ast.Tuple, ast.List)) or _is_text(side) for side in (left, right)):
                yield from ((node, anew(op=new())) for new in OPERATORS[type(op)])
        case ast.BoolOp(op=op):
            yield node, anew(op=ast.And() if isinstance(op, ast.Or) else ast.Or())
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            yield node, f"({ast.unparse(operand)})"
        case ast.Call(func=ast.Name(id=name) as called) if name in CALLED:
            yield called, CALLED[name]
        case ast.Constant(value=bool(value)):
            yield node, str(not value)
        case ast.Constant(value=int(value)):
            yield from ((node, f"({new})") for new in (value + 1, value - 1))
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Break() | ast.Continue():
            yield node, "pass"
        case ast.Raise(exc=exc) if exc is None or "AssertionError" not in ast.unparse(exc):
            yield node, "pass"
        case ast.Return(value=ast.Compare() | ast.BoolOp() as value):
            yield value, f"(not ({ast.unparse(value)}))"
    match node:
        case ast.If(test=test) | ast.IfExp(test=test):
            yield from ((test, new) for new in ("True", "False"))
        case ast.While(test=test) if not isinstance(test, ast.Constant):
            yield test, "False"
        case ast.comprehension(ifs=ifs):
            yield from ((test, "True") for test in ifs)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))


def tests_of(file: Path) -> list[str]:
    """The module for its examples, test files of its folder, and those that import it, directly or through a helper."""
    module = ".".join(file.with_suffix("").parts)
    package, _, name = module.rpartition(".")
    texts = {path: path.read_text("utf-8") for path in Path("tests").rglob("*.py") if path.name != "conftest.py"}
    named = re.compile(rf"\b{re.escape(module)}\b|from {re.escape(package)} import .*\b{name}\b")
    found, before = {path for path, text in texts.items() if named.search(text)}, -1
    while before < len(found):
        before = len(found)
        helpers = "|".join(re.escape(path.stem) for path in found if not path.name.startswith("test_"))
        found |= {path for path, text in texts.items() if helpers and re.search(rf"^(?:from|import) (?:{helpers})\b", text, re.MULTILINE)}
    found |= {*Path("tests", *file.parent.parts[1:]).glob("*.py")}
    return [str(path) for path in (file, *sorted(found)) if path == file or path.name.startswith("test_")]


def in_child(work: Callable[[], Any], timeout: float | None = None) -> Any:
    """What a function gives in a process of its own, which has imported what we have; None if it takes too long or ends otherwise."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)

    def child() -> None:
        os.setsid()
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        sender.send(work())

    process = context.Process(target=child)
    process.start()
    sender.close()
    try:
        return receiver.recv() if receiver.poll(timeout) else None
    except EOFError:
        return None
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid or 0, signal.SIGKILL)
        process.join()


class Copy:
    """A copy of the working tree, in which tests run on mutants of one module."""

    def __init__(self, root: Path, tree: Path, file: Path, tests: list[str]) -> None:
        shutil.copytree(root, tree, ignore=LEFT_OUT, symlinks=True)
        if (root.parent / "shared").is_dir():
            (tree.parent / "shared").symlink_to(root.parent / "shared")  # sample data, beside the checkout
        self.root, self.tree, self.file, self.written = root, tree, tree / file, 0
        self.tests = tests or tests_of(file)

    def write(self, source: bytes) -> None:
        """Put a source into the copy; bytecode is made anew, as no two have one time."""
        self.file.write_bytes(source)
        self.written += 1
        os.utime(self.file, (self.written * 10, self.written * 10))
        Path(importlib.util.cache_from_source(str(self.file))).unlink(missing_ok=True)

    def pytest(self, marks: str, plugin: object, tests: list[str], *options: str) -> int:
        """Run the tests of a tier, in this process."""
        os.chdir(self.tree)
        os.environ["PYTHONPATH"] = str(self.tree)
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # or every run compiles all modules
        sys.dont_write_bytecode = False
        if not marks.startswith("not "):
            os.environ["FAIRAUDIT_DEEP"] = "1"
        moved = {str(self.root): str(self.tree), "": str(self.tree), str(self.root / "tests"): str(self.tree / "tests")}
        sys.path[:] = [str(self.tree), *(moved.get(path, path) for path in sys.path)]
        return int(pytest.main(["-q", "-n", "0", "-p", "no:cacheprovider", "-m", marks, *options, *tests], plugins=[plugin]))

    def mutated(self, marks: str, tests: list[str]) -> int:
        """Run some tests of a tier, until one fails."""
        return self.pytest(marks, Chosen(tests), sorted({test.partition("::")[0] for test in tests}), "-x")

    def reached(self, marks: str) -> Reached:
        """Run a tier without a mutant."""
        tracer, plugin = coverage.Coverage(data_file=None, config_file=False, include=[str(self.file)]), Watching()
        plugin.tracer = tracer
        tracer.start()
        self.pytest(marks, plugin, self.tests)
        tracer.stop()
        by_line = {line: set(names) for line, names in tracer.get_data().contexts_by_lineno(str(self.file)).items()}
        seconds = {test: sum(times) for test, times in plugin.passed.items() if len(times) == 3}
        return Reached(seconds, by_line, [name for name in HEAVY if name in sys.modules])


class Watching:
    """Tells the tracer which test runs, and notes how long each takes."""

    tracer: coverage.Coverage

    def __init__(self) -> None:
        self.passed: defaultdict[str, list[float]] = defaultdict(list)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.tracer.switch_context(nodeid)

    def pytest_runtest_logfinish(self) -> None:
        self.tracer.switch_context("")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.outcome == "passed":
            self.passed[report.nodeid].append(report.duration)


class Chosen:
    """Runs some tests alone, in their order."""

    def __init__(self, tests: list[str]) -> None:
        self.places = {test: place for place, test in enumerate(tests)}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted((item for item in items if item.nodeid in self.places), key=lambda item: self.places[item.nodeid])


def chosen(reached: Reached, lines: range) -> list[str]:
    """Tests for a mutant of some lines, as many as take `LONGEST` seconds; of lines that imports run, all that reach any."""
    names = set().union(*(reached.by_line.get(line, set()) for line in lines))
    names = set().union(*reached.by_line.values()) if "" in names else names
    files = {test.partition("::")[0] for test in names}
    found, total = [], 0.0
    for seconds, test in sorted(((seconds, test) for test, seconds in reached.seconds.items()), key=lambda one: (one[1] not in names, one)):
        if test.partition("::")[0] in files and (not found or total + seconds <= LONGEST):
            found.append(test)
            total += seconds
    return found


def main() -> None:
    """Read the command line, and print what survives."""
    parser = argparse.ArgumentParser(description="Change one module in many small ways, and count the changes that its tests notice.")
    parser.add_argument("file", type=Path, help="the module, such as fairaudit/theorems/t15.py")
    parser.add_argument("--mutants", type=int, default=40, help="how many (40)")
    parser.add_argument("--seed", type=int, default=0, help="which ones (0)")
    parser.add_argument("--tier", choices=TIERS, default="all", help="of the tests: default, deep, or all: one after the other (all)")
    parser.add_argument("--marks", nargs="+", help="tiers as pytest's -m expects them, in place of --tier")
    parser.add_argument("--tests", nargs="*", help="test files, in place of those of the module's folder and those that import it")
    parser.add_argument("--lines", type=int, nargs=2, help="mutants of these lines alone")
    options = parser.parse_args()
    source = options.file.read_bytes()
    first, last = options.lines or (1, len(source))
    every = [one for one in mutants(source.decode()) if first <= source.count(b"\n", 0, one.start) + 1 <= last]
    left = sorted(random.Random(options.seed).sample(every, min(options.mutants, len(every))))
    number, tested = len(left), dict.fromkeys(left, 0)
    print(f"{options.file}: {number} of {len(every)} mutants, seed {options.seed}")
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path.cwd(), Path(folder, "tree").resolve(), options.file, options.tests)
        for marks in options.marks or TIERS[options.tier]:
            copy.write(source)
            reached = in_child(lambda marks=marks: copy.reached(marks))  # type: ignore[misc]
            if reached is None:
                sys.exit(f"{options.file}: the tests did not end without a mutant, either")
            for name in reached.heavy:
                importlib.import_module(name)
            survived, late = [], 0
            for one in left:
                tests = chosen(reached, one.lines)
                tested[one] += len(tests)
                copy.write(source[: one.start] + one.new.encode() + source[one.end :])
                limit = GRACE + 4 * sum(reached.seconds[test] for test in tests)
                code = in_child(lambda marks=marks, tests=tests: copy.mutated(marks, tests), limit) if tests else 0  # type: ignore[misc]
                late += code is None
                if code in (0, 5):
                    survived.append(one)
            left = survived
            print(f"-m '{marks}': {len(reached.seconds)} tests; {number - len(left)} of {number} killed so far, {late} here by time")
            for one in left:
                line = source.count(b"\n", 0, one.start) + 1
                old = re.sub(r"\s+", " ", source[one.start : one.end].decode())
                print(f"survived {tested[one]} tests: {options.file}:{line}: {old} -> {one.new}", flush=True)


if __name__ == "__main__":
    main()
