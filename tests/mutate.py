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
import gc
import importlib.util
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import coverage
import pytest

TIERS = {"default": ("not deep",), "deep": ("deep or again",), "all": ("not deep", "deep or again")}
LONGEST = 120.0  # seconds of tests that a mutant meets in one tier
ANEW = 9  # the code of a mutant that takes effect only where its module is imported anew
GRACE = 20.0  # seconds beyond four times what the tests took without a mutant
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

    def put_into(self, source: bytes) -> bytes:
        """The source with the mutant."""
        return source[: self.start] + self.new.encode() + source[self.end :]


class Reached(NamedTuple):
    """What a tier says without a mutant: seconds of each test that passes, which of them reach a line."""

    seconds: dict[str, float]
    by_line: dict[int, set[str]]

    def limit(self, tests: list[str]) -> float:
        """Seconds after which a mutant counts as noticed."""
        return GRACE + 4 * sum(self.seconds[test] for test in tests)


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


def in_child(work: Callable[[], Any], limit: float | None = None) -> Any:
    """What a function gives in a process of its own, which has imported what we have; None if it ends otherwise, or takes too long.

    The limit is one of processor time, whatever else the machine has to do; ten times as long is too long in any case.
    """
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)

    def child() -> None:
        os.setsid()
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 1))
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        sender.send(work())

    process = context.Process(target=child)
    process.start()
    sender.close()
    try:
        return receiver.recv() if receiver.poll(limit and 10 * limit) else None
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

    def reached(self, marks: str) -> Reached:
        """Run a tier without a mutant."""
        tracer, plugin = coverage.Coverage(data_file=None, config_file=False, include=[str(self.file)]), Watching()
        plugin.tracer = tracer
        tracer.start()
        self.pytest(marks, plugin, self.tests)
        tracer.stop()
        by_line = {line: set(names) for line, names in tracer.get_data().contexts_by_lineno(str(self.file)).items()}
        seconds = {test: sum(times) for test, times in plugin.passed.items() if len(times) == 3}
        return Reached(seconds, by_line)

    def tried(self, marks: str, reached: Reached, left: list[Mutant], source: bytes) -> list[int | None]:
        """Run the tests of each mutant; 0 or 5 for each that survives, None for each that takes too long."""
        self.write(source)
        tests = {test: None for one in left for test in chosen(reached, one.lines)}
        if not tests:
            return [0 for _ in left]
        plugin = Trying(self, reached, left, source)
        codes = in_child(lambda: (self.pytest(marks, plugin, sorted({*map(name_of, tests)})), plugin.codes)[1])
        for place, one in enumerate(left):
            if codes[place] == ANEW:
                self.write(one.put_into(source))
                tests = chosen(reached, one.lines)
                run = partial(self.pytest, marks, Chosen(tests), sorted({*map(name_of, tests)}), "-x")
                codes[place] = in_child(run, reached.limit(tests))
        return codes


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


class Trying:
    """Runs the tests of each mutant in a process of its own, forked after all were collected; gives its exit code, or None."""

    def __init__(self, copy: Copy, reached: Reached, left: list[Mutant], source: bytes) -> None:
        self.copy, self.reached, self.left, self.source, self.codes = copy, reached, left, source, list[int | None]()

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        items = {item.nodeid: item for item in session.items}
        for one in self.left:
            tests = chosen(self.reached, one.lines)
            changed = one.put_into(self.source)
            self.copy.write(changed)

            def work(tests: list[str] = tests, changed: bytes = changed, one: Mutant = one) -> int:
                at_import = any("" in self.reached.by_line.get(line, ()) for line in one.lines)
                if at_import or not exchanged(str(self.copy.file), changed):
                    return ANEW
                found = [items[test] for test in tests if test in items]
                for item, following in zip(found, [*found[1:], None], strict=True):
                    item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
                    if session.testsfailed:
                        return 1
                return 0

            self.codes.append(in_child(work, self.reached.limit(tests)) if tests else 0)
        return True


def exchanged(file: str, source: bytes) -> bool:
    """Whether all functions of a module that is imported already could be given the code of another source."""
    found: defaultdict[str, list[CodeType]] = defaultdict(list)
    codes = [compile(source, file, "exec")]
    while codes:
        inner = [const for const in codes.pop().co_consts if isinstance(const, CodeType)]
        codes += inner
        for code in inner:
            found[code.co_qualname].append(code)
    for each in gc.get_objects():
        if isinstance(each, FunctionType) and each.__code__.co_filename == file:
            try:
                (each.__code__,) = found[each.__code__.co_qualname]
            except ValueError:  # two of one name, or other variables of an outer function
                return False
    return True


def name_of(test: str) -> str:
    """The file of a test."""
    return test.partition("::")[0]


def chosen(reached: Reached, lines: range) -> list[str]:
    """Tests for a mutant of some lines, as many as take `LONGEST` seconds; of lines that imports run, all that reach any."""
    names = set().union(*(reached.by_line.get(line, set()) for line in lines))
    names = set().union(*reached.by_line.values()) if "" in names else names
    files = {name_of(test) for test in names}
    found, total = [], 0.0
    for seconds, test in sorted(((seconds, test) for test, seconds in reached.seconds.items()), key=lambda one: (one[1] not in names, one)):
        if name_of(test) in files and (not found or total + seconds <= LONGEST):
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
            reached = in_child(partial(copy.reached, marks))
            if reached is None:
                sys.exit(f"{options.file}: the tests did not end without a mutant, either")
            codes = copy.tried(marks, reached, left, source)
            for one in left:
                tested[one] = len(chosen(reached, one.lines))
            late = codes.count(None)
            left = [one for one, code in zip(left, codes, strict=True) if code in (0, 5)]
            print(f"-m '{marks}': {len(reached.seconds)} tests; {number - len(left)} of {number} killed so far, {late} here by time")
            for one in left:
                line = source.count(b"\n", 0, one.start) + 1
                old = re.sub(r"\s+", " ", source[one.start : one.end].decode())
                print(f"survived {tested[one]} tests of -m '{marks}': {options.file}:{line}: {old} -> {one.new}", flush=True)


if __name__ == "__main__":
    main()
