"""Seasons: pairs in time in a monitor, what they say of targets, and the diagnostic where time confounds."""

from __future__ import annotations

import json
import random
from math import pi, sin
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelopes, result_of

import fairaudit
from fairaudit.cli import main
from fairaudit.streams.settings import Settings
from fairaudit.streams.state import State
from fairaudit.streams.stream import Monitor

OPTIONS = ["--decision", "hired", "--group", "sex", "--utility", "yes", "--pair-by-time"]


def seasonal(number: int, seed: int, worse: float = 1.0) -> list[dict[str, Any]]:
    """Arrivals .5 ± .4 and means .4 ± .3, in phase; in the second half of each season men have `worse` times that."""
    rng = random.Random(seed)
    listed = []
    for k in range(number):
        season = sin(2 * pi * k / 1_000)
        sex = "f" if rng.random() < 0.5 + 0.4 * season else "m"
        mean = (0.4 + 0.3 * season) * (worse if sex == "m" and season < 0 else 1)
        listed.append({"sex": sex, "hired": "yes" if rng.random() < mean else "no"})
    return listed


def write(path: Path, listed: list[dict[str, Any]], mode: str = "w") -> Path:
    with path.open(mode) as file:
        file.writelines(json.dumps(row) + "\n" for row in listed)
    return path


def test_seasons_that_confound_the_whole_stream_are_said_and_decide_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Treated alike, the groups have a pooled ratio of 1.857; nothing is exceeded, and no certificate of constant means is made."""
    log, state = write(tmp_path / "log.jsonl", seasonal(6_000, 1)), tmp_path / "s.db"
    asked = ["monitor", str(log), "--state", str(state), *OPTIONS, "--max-local-ratio", "5/4"]
    assert main([*asked, "--format", "json"]) == 3
    last = envelopes(capsys.readouterr().out)[-1]
    entry, found = last["result"], last["result"]["by_time"]
    assert entry["ratio"]["local"][0] > 1.5 and entry["verdict"] == entry["targets"][0]["verdict"] == "inconclusive"
    assert found["time_confounds"] and found["exceeded"] == [] and found["ratio"][0] == 1 and found["ratio"][1] < 1.3
    assert found["error"] == "1/10" and found["confidence"] == "19/20" and found["pairs"] > 1_000 and found["pair"] is None
    assert any("time confounds" in note for note in last["notes"]) and entry["alarms"] == []
    assert main(["monitor", "--state", str(state), "--format", "text"]) == 3
    said = capsys.readouterr().out
    assert "if the ratio is constant in time, means may move: it is at most" in said and "time confounds" in said
    assert main(["certify", "--from-monitor", str(state)]) == 2
    assert "time confounds" in capsys.readouterr().err


def test_a_ratio_that_is_too_great_in_some_season_exceeds_its_target(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write(tmp_path / "log.jsonl", seasonal(20_000, 2, 0.2))
    assert main(["monitor", str(log), *OPTIONS, "--max-local-ratio", "11/10", "--run-length", "0", "--format", "json"]) == 1
    entry = result_of(capsys.readouterr().out.splitlines()[-1])
    assert entry["by_time"]["exceeded"] == ["max_local_ratio"] and entry["by_time"]["ratio"][0] > 1.1
    assert entry["by_time"]["pair"] == {"context": {}, "higher": {"sex": "f"}, "lower": {"sex": "m"}}
    assert entry["targets"][0]["verdict"] == entry["verdict"] == "exceeds"


def test_constant_means_are_not_confounded_and_are_certified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = random.Random(3)
    listed = [{"sex": rng.choice("fm"), "hired": rng.choice(["yes", "no"])} for _ in range(4_000)]
    log, state = write(tmp_path / "log.jsonl", listed), tmp_path / "s.db"
    assert main(["monitor", str(log), "--state", str(state), *OPTIONS, "--max-local-ratio", "5/4", "--format", "json"]) == 0
    found = result_of(capsys.readouterr().out.splitlines()[-1])["by_time"]
    assert not found["time_confounds"] and found["ratio"][0] == 1 and found["ratio"][1] < 1.25
    assert main(["certify", "--from-monitor", str(state), "-o", str(tmp_path / "c.json")]) == 0
    assert "pairs in time are not part of a certificate" in capsys.readouterr().err


def test_an_upper_end_by_pairs_in_time_decides_no_verdict(tmp_path: Path) -> None:
    """Within the target only if the ratio is constant in time: the whole stream's interval is the one that may say within."""
    log = write(tmp_path / "log.jsonl", seasonal(6_000, 1))
    with fairaudit.monitor(log, decision="hired", group="sex", utility="yes", max_local_ratio=2, pair_by_time=True) as watch:
        found = watch.catch_up()
    assert found.by_time is not None and found.by_time.upper < 2 and found.verdict == "inconclusive"


def test_tallies_go_on_where_they_were_stopped(tmp_path: Path) -> None:
    chosen = Settings(group=("sex",), decision="hired", utility={"yes": "1"}, pair_by_time=True)
    listed = seasonal(3_000, 4)

    def kept(log: Path, path: Path) -> Any:
        monitor = Monitor(State(str(path), chosen), str(log))
        monitor.catch_up()
        monitor.close()
        state = State(str(path), read_only=True)
        found = state.get("time_pairs")
        state.close()
        return found

    whole = kept(write(tmp_path / "whole.jsonl", listed), tmp_path / "whole.db")
    for k in range(0, 3_000, 700):
        parts = kept(write(tmp_path / "log.jsonl", listed[k : k + 700], "a"), tmp_path / "parts.db")
    assert whole == parts and sum(n for *_, n in whole[1][0][2]) > 500


def test_pairs_are_declared_beforehand_and_refused_where_they_cannot_be_tallied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, state = write(tmp_path / "log.jsonl", seasonal(50, 5)), tmp_path / "s.db"
    asked = ["monitor", str(log), "--state", str(state), *OPTIONS]
    assert main(asked[:-1]) == 0
    stored = State(str(state), read_only=True)
    assert "pair_by_time" not in stored.settings.text
    stored.close()
    assert main(asked) == 2
    assert "pair_by_time is False there and True here" in capsys.readouterr().err
    assert main(["monitor", str(log), *OPTIONS, "--unit", "person"]) == 2
    column = ["--utility-column", "score", "--utility-range", "0,1", "--group", "sex", "--pair-by-time"]
    assert main(["monitor", str(log), *column]) == 2
    assert "--utility-step" in capsys.readouterr().err
    assert main(["monitor", str(log), *column, "--utility-step", "1/101"]) == 2
    assert main(["monitor", str(log), *OPTIONS[:-3], "--utility", ",".join(f"d{k}={k}" for k in range(102)), "--pair-by-time"]) == 2
