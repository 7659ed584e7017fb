"""`monitor` opens a watch by settings that are those of the command."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main

ROWS = "yes,f\nyes,m\nno,m\n"
ASKED: dict[str, Any] = {"decision": "hired", "group": "sex", "utility": {"yes": 1}, "max_local_ratio": "5/4"}
OPTIONS = ["--decision", "hired", "--group", "sex", "--utility", "yes", "--max-local-ratio", "5/4"]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text("hired,sex\n" + ROWS * 100)
    return path


def test_the_state_of_one_is_that_of_the_other(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    state = log.parent / "watch.db"
    with fa.monitor(log, state=state, **ASKED) as watch:
        found = watch.catch_up()
    assert (found.events, found.verdict, found.exit_code) == (300, "exceeds", 1)
    with log.open("a") as file:
        file.write(ROWS * 10)
    assert main(["monitor", str(log), "--state", str(state), *OPTIONS]) == 1
    capsys.readouterr()
    with fa.monitor(log, state=state) as watch:  # the state knows its settings
        assert watch.catch_up().events == 330
    with pytest.raises(fa.InputError, match="is the state of another audit"):
        fa.monitor(log, state=state, **{**ASKED, "max_local_ratio": 2})
    with pytest.raises(fa.InputError, match="give one of utility"):
        fa.monitor(log, state=state, max_local_ratio=2)


def test_settings_are_read_as_on_the_command_line(log: Path) -> None:
    with fa.monitor(log, decision="hired", group=["sex"], utility="yes=2,no=0.5", confidence=0.99, window="2h", time="at") as watch:
        settings = watch.settings
    assert (settings.high, settings.confidence, settings.window, settings.layout) == ("2", "99/100", "7200s", "csv")
    assert settings.utility == {"yes": "2", "no": "1/2"}
    with fa.monitor(log, utility_column="worth", group="sex", utility_range=(0, 5), utility_step="0.5", log_format="jsonl") as watch:
        assert (watch.settings.decision, watch.settings.high, watch.settings.step, watch.settings.layout) == ("worth", "5", "1/2", "jsonl")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({}, "no audit was described"),
        ({"group": "sex"}, "give one of utility"),
        ({"group": "sex", "utility": "yes"}, "no decision column was named"),
        ({"group": "sex", "utility_column": "worth"}, "needs utility_range"),
        ({"decision": "hired", "utility": "yes"}, "no group column was named"),
        ({**ASKED, "window": "soon"}, "window 'soon' is not accepted"),
        ({**ASKED, "max_global": 2}, "max_global is not accepted"),
    ],
)
def test_refusals(log: Path, asked: dict[str, Any], said: str) -> None:
    with pytest.raises(fa.InputError, match=said):
        fa.monitor(log, **asked)


def test_the_same_log_gives_the_same_certificate_whatever_the_seed_of_hashes(tmp_path: Path) -> None:
    """Decisions of a utility column are numbered in the order in which they appear."""
    log = tmp_path / "pay.csv"
    log.write_text("pay,sex\n" + "".join(f"{k % 23},{'fm'[k % 2]}\n" for k in range(400)))
    found = set()
    for seed in "0123":
        state, certificate = tmp_path / f"{seed}.db", tmp_path / f"{seed}.json"
        watch = ["monitor", str(log), "--utility-column", "pay", "--group", "sex", "--utility-range", "0,22", "--utility-step", "1"]
        for words in ([*watch, "--state", str(state)], ["certify", "--from-monitor", str(state), "-o", str(certificate)]):
            done = subprocess.run(
                [sys.executable, "-m", "fairaudit", *words], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=False
            )
            assert done.returncode == 0, done.stderr
        found.add(certificate.read_bytes())
    assert len(found) == 1


def test_what_is_no_path_is_refused_in_one_sentence() -> None:
    with pytest.raises(fa.InputError, match="log is 3, an int; a path is accepted"):
        fa.monitor(3, **ASKED)  # type: ignore[arg-type]
