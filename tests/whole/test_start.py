"""What commands load: nothing that they do not need, however much is installed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fairaudit.cli import main

ROOT = Path(__file__).resolve().parents[2]

EXAMPLE = ("certify", "--example", "ucb-admissions")

COMMANDS: dict[tuple[str, ...], tuple[int, set[str]]] = {
    ("--version",): (4, {"numpy", "dataclasses", "importlib.metadata"}),
    ("--help",): (16, {"numpy", "dataclasses", "inspect"}),
    ("certify", "--help"): (24, {"numpy", "importlib.metadata"}),
    ("certify", "--list-examples"): (40, {"importlib.metadata", "fairaudit.audits"}),
    EXAMPLE: (114, {"importlib.metadata", "jinja2", "fairaudit.theorems.case", "fairaudit.model.policy", "fairaudit.inference.anytime"}),
    (*EXAMPLE, "-o", "certificate.json"): (114, {"importlib.metadata", "jinja2", "fairaudit.reports.page"}),
    (*EXAMPLE, "--confidence", "none", "--format", "json"): (120, {"importlib.metadata", "jinja2"}),
}
"""How many modules of its own a command may load, and some that it may not."""

NEVER = {
    "scipy",
    "pandas",
    "duckdb",
    "narwhals",
    "cvxpy",
    "matplotlib",
    "numpy.random",
    "numpy.ma",
    "fairaudit.checker",
    "fairaudit.verified",
}


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_command_loads_what_it_needs(command: tuple[str, ...], tmp_path: Path) -> None:
    most, others = COMMANDS[command]
    code = (
        "import contextlib, json, os, sys; from fairaudit.cli import main\n"
        "with contextlib.redirect_stdout(open(os.devnull, 'w')), contextlib.suppress(SystemExit): main(sys.argv[1:])\n"
        "print(json.dumps(sorted(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *command],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = json.loads(done.stdout)
    assert {*loaded} & (NEVER | others) == set()
    assert len([name for name in loaded if name.startswith("fairaudit")]) <= most


def test_numpy_starts_no_threads_for_a_command_unless_somebody_asks_for_them(monkeypatch: pytest.MonkeyPatch) -> None:
    for given, kept in ((None, "1"), ("4", "4")):
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", given) if given else monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
        main(["certify", "--list-examples"])
        assert os.environ["OPENBLAS_NUM_THREADS"] == kept
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    with pytest.raises(SystemExit):
        main(["--version"])
    assert "OPENBLAS_NUM_THREADS" not in os.environ
