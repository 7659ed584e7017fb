"""The monitor against a plain count of its log: states, kills, rotation, repeats, clocks and unreadable lines."""

from __future__ import annotations

import contextlib
import json
import math
import random
import re
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers
from envelopes import envelopes, result_of
from needs import POSIX

import fairaudit
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.model.law import Law
from fairaudit.streams import readers as reader
from fairaudit.streams.settings import Settings
from fairaudit.streams.state import State
from fairaudit.streams.stream import Monitor
from fairaudit.tables.engines.logs import read_log

SETTINGS = Settings(group=("sex",), context=("job",), decision="answer", utility={"yes": "1"})
OPTIONS = ["--decision", "answer", "--group", "sex", "--context", "job", "--utility", "yes"]


def event(rng: random.Random, **more: Any) -> dict[str, Any]:
    sex = rng.choice("fm")
    answer = "yes" if rng.random() < (0.6 if sex == "f" else 0.4) else rng.choice(["no", "later"])
    return {"job": rng.choice(["cook", "clean"]), "sex": sex, "answer": answer, **more}


def write(path: Path, events: list[Any], mode: str = "w") -> Path:
    with path.open(mode) as file:
        file.writelines((text if isinstance(text, str) else json.dumps(text)) + "\n" for text in events)
    return path


def events(number: int, seed: int = 0, **more: Any) -> list[dict[str, Any]]:
    rng = random.Random(seed)
    return [event(rng, **{key: value(k) for key, value in more.items()}) for k in range(number)]


def expected(listed: list[dict[str, Any]]) -> Counter[Any]:
    return Counter((e["job"], e["sex"], e["answer"] if e["answer"] == "yes" else "(other)") for e in listed)


def counted(monitor: Monitor) -> Counter[Any]:
    cells = {rank: cell for cell, rank in monitor.total.order.items()}
    found: Counter[Any] = Counter()
    for (rank, number), n in monitor.total.n.items():
        (job,), (sex,) = cells[rank]
        found[job, sex, monitor.decisions[number][0]] += n
    return found


def run(path: Path, state: Path | None = None, settings: Settings = SETTINGS, letters: Path | None = None) -> Monitor:
    monitor = Monitor(State(None if state is None else str(state), settings), str(path), None if letters is None else str(letters))
    try:
        for _ in monitor.read():
            pass
    finally:
        monitor.close()
    return monitor


@pytest.mark.parametrize("fast", [True, False])
def test_everything_is_counted_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fast: bool) -> None:
    if not fast:
        monkeypatch.setitem(sys.modules, "msgspec", None)
    listed = events(5_000)
    monitor = run(write(tmp_path / "log.jsonl", listed))
    assert counted(monitor) == expected(listed)
    order = list(dict.fromkeys(((e["job"],), (e["sex"],)) for e in listed))
    assert list(monitor.total.order) == order


@pytest.mark.parametrize("fast", [True, False])
def test_labels_are_read_alike_with_and_without_the_fast_reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fast: bool) -> None:
    if not fast:
        monkeypatch.setitem(sys.modules, "msgspec", None)
    lines = [
        '{"job":1,"sex":true,"answer":"yes"}',
        '{"job":1,"sex":"true","answer":"no"}',
        '{"job":true,"sex":"f","answer":"yes"}',
        '{"job":1.50,"sex":"f","answer":"yes"}',
        '{"job":"1.5","sex":"f","answer":"yes"}',
        ' {"job":"é","sex":"f","answer":"yes","job":"ü"} ',
        "",
        '{"job":"ü","sex":"f","answer":"yes"}\r',
        '{"job":12345678901234567890123,"sex":"f","answer":"yes"}',
    ]
    monitor = run(write(tmp_path / "log.jsonl", lines * 3))
    assert counted(monitor) == Counter(
        {
            ("1", "true", "yes"): 3,
            ("1", "true", "(other)"): 3,
            ("true", "f", "yes"): 3,
            ("1.5", "f", "yes"): 6,
            ("ü", "f", "yes"): 6,
            ("12345678901234567890123", "f", "yes"): 3,
        }
    )
    assert not monitor.tally["dead"]


def test_labels_of_another_kind_later_on_are_other_labels(tmp_path: Path) -> None:
    lines = [f'{{"job":{job},"sex":"{sex}","answer":"yes"}}' for job in ("1", "true", "1", "0", "false") for sex in "fm" * 2_500]
    monitor = run(write(tmp_path / "log.jsonl", lines))
    assert counted(monitor) == {
        (job, sex, "yes"): n for job, n in (("1", 5_000), ("true", 2_500), ("0", 2_500), ("false", 2_500)) for sex in "fm"
    }


def test_labels_are_those_of_the_log_read_at_once(tmp_path: Path) -> None:
    values = [
        "true",
        "false",
        "1",
        "1.0",
        "1.50",
        "1e23",
        "1E-7",
        "-0.0",
        "0.1",
        "12345678901234567890123",
        "9007199254740993",
        '"é"',
        '"1.x"',
    ]
    lines = [f'{{"job":{value},"sex":"{sex}","answer":"yes"}}' for value in values for sex in "fm"]
    log = write(tmp_path / "log.jsonl", lines)
    monitor = run(log)
    law = Law.from_log(read_log(log, ("answer", "sex", "job")), decision="answer", group="sex", context="job")
    assert {job for job, _, _ in counted(monitor)} == {job for (job,) in law.contexts}
    assert ("99999999999999991611392",) in law.contexts and ("true",) in law.contexts


def test_a_state_with_labels_of_earlier_spelling_is_refused(tmp_path: Path) -> None:
    log = write(tmp_path / "log.jsonl", ['{"job":true,"sex":"f","answer":"yes"}', '{"job":"cook","sex":"m","answer":"no"}'])
    for label in ("True", "1.0", "1e-07"):
        state = tmp_path / f"{label}.db"
        run(log, state)
        with sqlite3.connect(state) as database:
            database.execute("delete from meta where key = 'spelling'")
            database.execute("update cells set context = ? where context = ?", (json.dumps([label]), json.dumps(["true"])))
        database.close()
        with pytest.raises(InputError, match=f"holds the label '{label}', which earlier versions wrote.*start a new state"):
            run(log, state)
    with sqlite3.connect(state) as database:
        database.execute("update cells set context = ? where context = ?", (json.dumps(["other"]), json.dumps([label])))
    database.close()
    assert run(log, state).total.order


BAD = {
    "not json": "not JSON",
    '{"job":"cook","sex":"f","answer":"yes"} {"job":"cook","sex":"f","answer":"yes"}': "not JSON",
    "[1]": "not a JSON object",
    '{"job":"cook","sex":"f","answer":"yes"': "not JSON",
    '{"job":"cook","answer":"yes"}': "no value in column 'sex'",
    '{"job":"cook","sex":null,"answer":"yes"}': "no value in column 'sex'",
    '{"job":"cook","sex":" ","answer":"yes"}': "no value in column 'sex'",
    '{"job":["cook"],"sex":"f","answer":"yes"}': "column 'job' holds no label",
    '{"job":"cook","sex":"f","answer":NaN}': "not JSON",
    '{"job":"\\ud800","sex":"f","answer":"yes"}': "column 'job'",
    "[" * 100_000: "not JSON",
}


def test_unreadable_lines_go_to_the_dead_letters_with_line_and_reason(tmp_path: Path) -> None:
    listed: list[Any] = list(events(3_000))
    where = {}
    for k, text in enumerate(BAD):
        listed.insert(137 * (k + 1), text)
    for number, text in enumerate(listed, 1):
        if isinstance(text, str):
            where[number] = BAD[text]
    monitor = run(write(tmp_path / "log.jsonl", listed), letters=tmp_path / "dead.jsonl")
    letters = [json.loads(line) for line in (tmp_path / "dead.jsonl").read_text().splitlines()]
    assert {letter["line"]: letter["reason"] for letter in letters}.keys() == where.keys()
    for letter in letters:
        assert letter["reason"].startswith(where[letter["line"]])
        assert letter["text"] == listed[letter["line"] - 1][:2000]
    assert counted(monitor) == expected([e for e in listed if isinstance(e, dict)])
    assert monitor.tally["dead"] == len(BAD)


def test_dead_letters_of_a_run_that_never_committed_are_taken_back(tmp_path: Path) -> None:
    log = write(tmp_path / "log.jsonl", [*["broken"] * 3, *events(20)])
    letters = tmp_path / "dead"
    letters.write_text("of another audit\n")
    state = State(str(tmp_path / "state.db"), SETTINGS)
    cut = Monitor(state, str(log), str(letters))
    cut._dead(1, "unreadable line", "not JSON", b"broken")
    cut._letters.flush()  # written, and then killed before anything was committed
    state.close()
    cut._letters.close()
    cut.log.file.close()
    state = State(str(tmp_path / "state.db"), SETTINGS)
    monitor = Monitor(state, str(log), str(letters))
    for _ in monitor.read():
        pass
    monitor.close()
    lines = letters.read_text().splitlines()
    assert lines[0] == "of another audit" and [json.loads(line)["line"] for line in lines[1:]] == [1, 2, 3]


def test_a_log_of_which_nothing_counts_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.txt"
    log.write_text("answer,sex\nyes,f\nyes,m\n")
    command = ["monitor", str(log), "--decision", "answer", "--group", "sex", "--utility", "yes"]
    assert main(command) == 2
    assert "none of 3 lines could be counted as jsonl" in capsys.readouterr().err
    assert main([*command, "--log-format", "csv", "--max-local-ratio", "2"]) == 3


def test_bytes_that_are_no_text_are_dead_letters(tmp_path: Path) -> None:
    log = write(tmp_path / "log.jsonl", events(10))
    with log.open("ab") as file:
        file.write(b'{"job":"\xff","sex":"f","answer":"yes"}\n')
    write(log, events(10), "a")
    monitor = run(log)
    assert (monitor.events, monitor.tally["dead"]) == (20, 1)


def csv_log(path: Path, listed: list[dict[str, Any]], end: str = "\n") -> Path:
    path.write_text("sex,answer,job\n" + "\n".join(f"{e['sex']},{e['answer']},{e['job']}" for e in listed) + end)
    return path


def test_csv_is_counted_alike_and_resumed(tmp_path: Path) -> None:
    listed = events(2_000)
    settings = Settings(group=("sex",), context=("job",), decision="answer", utility={"yes": "1"}, layout="csv")
    log = csv_log(tmp_path / "log.csv", listed[:1_000])
    state = tmp_path / "s.db"
    run(log, state, settings)
    with log.open("a") as file:
        file.write('f,"yes",cook\nf,yes\nf,"yes\n' + "\n".join(f"{e['sex']},{e['answer']},{e['job']}" for e in listed[1_000:]) + "\n")
    monitor = run(log, state, settings)
    assert counted(monitor) == expected([*listed, {"sex": "f", "answer": "yes", "job": "cook"}])
    assert monitor.tally["dead"] == 2


def test_a_header_without_a_column_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("sex,anwser,job\nf,yes,cook\n")
    with pytest.raises(InputError, match=r"there is no column 'answer'.*did you mean 'anwser'"):
        run(tmp_path / "log.csv", settings=Settings(group=("sex",), decision="answer", utility={"yes": "1"}, layout="csv"))


def test_a_log_that_grows_is_read_on(tmp_path: Path) -> None:
    listed = events(3_000)
    log, state = tmp_path / "log.jsonl", tmp_path / "s.db"
    for k in range(3):
        write(log, listed[1_000 * k : 1_000 * (k + 1)], "a")
        monitor = run(log, state)
    assert counted(monitor) == expected(listed)


def test_a_line_without_an_end_is_counted_once(tmp_path: Path) -> None:
    listed = events(20)
    log, state = write(tmp_path / "log.jsonl", listed[:10]), tmp_path / "s.db"
    log.write_text(log.read_text().rstrip("\n"))
    assert run(log, state).events == 10
    with log.open("a") as file:
        file.write("\n")
    write(log, listed[10:], "a")
    assert counted(run(log, state)) == expected(listed)


def test_rotation_and_truncation_are_noticed(tmp_path: Path) -> None:
    listed = events(4_000)
    log, state = write(tmp_path / "log.jsonl", listed[:1_000]), tmp_path / "s.db"
    run(log, state)
    write(log, listed[1_000:1_500], "a")
    log.rename(tmp_path / "log.jsonl.1")
    write(log, listed[1_500:2_500])
    monitor = run(log, state)  # the rest of the renamed file, then the new one
    assert counted(monitor) == expected(listed[:2_500])
    assert any("rotated" in note for note in monitor.notes)
    write(log, listed[2_500:3_000])  # cut off, and written anew: shorter
    monitor = run(log, state)
    assert counted(monitor) == expected(listed[:3_000])
    assert any("cut off" in note for note in monitor.notes)
    log.unlink()
    (tmp_path / "keep").write_text("so that the number of the file is not used again")
    write(log, listed[3_000:])  # longer, and another file
    monitor = run(log, state)
    assert counted(monitor) == expected(listed)


def test_rotation_while_following_is_noticed(tmp_path: Path) -> None:
    listed = events(900)
    log = write(tmp_path / "log.jsonl", listed[:300])
    monitor = Monitor(State(None, SETTINGS), str(log))
    list(monitor.read(follow=True))
    with log.open("a") as file:
        file.write(json.dumps(listed[300])[:20])
    list(monitor.read(follow=True))
    assert monitor.events == 300
    with log.open("a") as file:
        file.write(json.dumps(listed[300])[20:] + "\n")
    write(log, listed[301:600], "a")
    log.rename(tmp_path / "old")
    write(log, listed[600:])
    list(monitor.read(follow=True))
    assert counted(monitor) == expected(listed)
    monitor.close()


def test_another_audits_state_is_refused(tmp_path: Path) -> None:
    log, state = write(tmp_path / "log.jsonl", events(10)), tmp_path / "s.db"
    run(log, state)
    for change in ({"confidence": "0.9"}, {"utility": {"no": "1"}}, {"context": ()}, {"expected": 5}):
        other = Settings(**{**vars(SETTINGS), **change})
        with pytest.raises(InputError, match=f"another audit: {next(iter(change))} is"):
            State(str(state), other)
    for text in (b"", b"no database", b"SQLite format 3\x00" + bytes(2000)):
        (tmp_path / "other").write_bytes(text)
        with pytest.raises(InputError):
            State(str(tmp_path / "other"))


def test_an_altered_audit_is_refused(tmp_path: Path) -> None:
    log, path = write(tmp_path / "log.jsonl", events(10)), tmp_path / "s.db"
    run(log, path)
    state = State(str(path), SETTINGS)
    state.db.execute("UPDATE meta SET value = replace(value, '19/20', '99/100') WHERE key = 'audit'")
    state.close()
    with pytest.raises(InputError, match="altered"):
        State(str(path))


def test_a_second_writer_is_refused_and_readers_are_not(tmp_path: Path) -> None:
    path = tmp_path / "s.db"
    monitor = Monitor(State(str(path), SETTINGS), str(write(tmp_path / "log.jsonl", events(500))))
    list(monitor.read())
    with pytest.raises(InputError, match="in use by another monitor"):
        State(str(path), SETTINGS)
    assert main(["certify", "--from-monitor", str(path), "-o", str(tmp_path / "c.json")]) == 0
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    monitor.close()
    State(str(path), SETTINGS).close()


def test_repeats_are_dropped_by_event_id(tmp_path: Path) -> None:
    listed = events(500, id=lambda k: f"e{k}")
    rng = random.Random(4)
    doubled = [e for e in listed for _ in range(rng.choice([1, 1, 3]))]
    settings = Settings(**{**vars(SETTINGS), "event_id": "id"})
    log, state = write(tmp_path / "log.jsonl", doubled), tmp_path / "s.db"
    monitor = run(log, state, settings)
    assert counted(monitor) == expected(listed)
    assert monitor.tally["repeats"] == len(doubled) - len(listed)
    write(log, [*listed, {"job": "cook", "sex": "f", "answer": "yes"}], "a")
    monitor = run(log, state, settings)
    assert counted(monitor) == expected(listed)
    assert monitor.tally["dead"] == 1


def test_a_unit_counts_once_in_each_cell(tmp_path: Path) -> None:
    listed = events(2_000, seed=9, person=lambda k: k % 300)
    settings = Settings(**{**vars(SETTINGS), "unit": ("person",)})
    monitor = run(write(tmp_path / "log.jsonl", listed), settings=settings)
    first = {(e["person"], e["job"], e["sex"]): e for e in reversed(listed)}
    assert counted(monitor) == expected(list(first.values()))
    assert set(monitor.look().intervals) == {"local"}


def test_clocks_that_go_back_and_times_to_come(tmp_path: Path) -> None:
    stamps = [100, 200, 150, "1970-01-01T00:05:00Z", "1970-01-01T01:05:00+01:00", 90, "never", None, time.time() + 10**6, 400]
    listed = [{"job": "cook", "sex": "fm"[k % 2], "answer": "yes", "t": stamp} for k, stamp in enumerate(stamps)]
    settings = Settings(**{**vars(SETTINGS), "time": "t", "since": "1970-01-01T00:01:40", "window": "100s"})
    monitor = run(write(tmp_path / "log.jsonl", listed), settings=settings)
    assert (monitor.events, monitor.tally["early"], monitor.tally["back"], monitor.tally["dead"]) == (6, 1, 1, 3)
    assert monitor.tally["clock"] == 400
    assert [entry["events"] for entry in monitor.closed] + [monitor.window.events] == [1, 2, 2, 1]


def test_windows_have_budgets_that_sum_to_the_error(tmp_path: Path) -> None:
    from fairaudit.inference.levels import window_share

    assert sum(window_share(number) for number in range(1, 2_000)) < 1
    listed = events(2_500)
    settings = Settings(**{**vars(SETTINGS), "window": "1000"})
    state = tmp_path / "s.db"
    monitor = run(write(tmp_path / "log.jsonl", listed), state, settings)
    assert [entry["events"] for entry in monitor.closed] == [1_000, 1_000]
    widths = [entry["intervals"]["local"][1] for entry in monitor.closed]
    assert min(widths) > 1
    stored = State(str(state), settings)
    assert [stored.counts(window).events for window in (0, 1, 2, 3)] == [2_500, 1_000, 1_000, 500]
    stored.close()


def test_a_cell_that_comes_late_leaves_the_others_their_budget(tmp_path: Path) -> None:
    listed = events(4_000)
    before = run(write(tmp_path / "a.jsonl", listed)).look()
    monitor = run(
        write(tmp_path / "b.jsonl", [*listed, {"job": "late", "sex": "f", "answer": "yes"}, {"job": "late", "sex": "m", "answer": "no"}])
    )
    after = monitor.look()
    assert after.intervals["local"][0] == pytest.approx(before.intervals["local"][0], rel=1e-9)
    assert after.intervals["local"][1] == float("inf")  # nothing is known of the late ones, and nobody is fair by default


def test_utilities_from_a_column_are_exact_or_rounded(tmp_path: Path) -> None:
    lines = ['{"sex":"f","pay":0.1}', '{"sex":"m","pay":"1/3"}', '{"sex":"m","pay":1e-1}', '{"sex":"f","pay":7}', '{"sex":"f","pay":"x"}']
    log = write(tmp_path / "log.jsonl", lines)
    settings = Settings(group=("sex",), decision="pay", high="2")
    monitor = run(log, settings=settings)
    assert monitor.decisions == [("1/10", "1/10"), ("1/3", "1/3")]
    assert monitor.tally["dead"] == 2
    monitor = run(log, settings=Settings(group=("sex",), decision="pay", high="2", step="1/4"))
    assert [Fraction(g) for _, g in monitor.decisions] == [0, Fraction(1, 4)]


def test_settings_refuse_what_cannot_be_audited() -> None:
    for change, message in (
        ({"group": ()}, "no group column"),
        ({"group": ("job",)}, "used twice"),
        ({"low": "1", "high": "1"}, "cannot be monitored"),
        ({"utility": {"yes": "2"}}, "outside the range"),
        ({"utility": {"(other)": "1"}}, "stands for"),
        ({"low": "1/2", "utility": {"yes": "1"}}, "begins at 0"),
        ({"step": "0"}, "step"),
        ({"expected": 0}, "expected cells"),
        ({"since": "2026"}, "--time"),
        ({"layout": "xml"}, "not known"),
        ({"targets": {"max_local_ratio": "0"}}, "a ratio above 0"),
        ({"confidence": "1"}, "confidence"),
        ({"unit": ("id",), "targets": {"max_global_log": "1"}}, "global"),
    ):
        with pytest.raises(InputError, match=message):
            Settings(**{**vars(SETTINGS), **change})


def test_an_alarm_is_raised_at_the_first_moment_and_stays(tmp_path: Path) -> None:
    rng = random.Random(1)
    listed = [{"job": "cook", "sex": s, "answer": "yes" if rng.random() < (0.8 if s == "f" else 0.4) else "no"} for s in "fm" * 2_000]
    log, state = write(tmp_path / "log.jsonl", listed), tmp_path / "s.db"
    args = ["monitor", str(log), "--state", str(state), *OPTIONS, "--max-local-ratio", "5/4", "--exit-on", "exceeds", "--format", "json"]
    assert main(args) == 1
    stored = State(str(state))
    raised = stored.alarms()
    stored.close()
    (alarm,) = [alarm for alarm in raised if "detected" not in alarm]  # a detector sees sooner that the ratio is above the limit
    assert alarm["target"] == "max_local_ratio" and Fraction(alarm["lower"]) > Fraction(5, 4)
    assert alarm["events"] == sum(n for *_, n in alarm["counts"]) <= 4_000
    assert main(["monitor", "--state", str(state)]) in (1, 3)  # the rest; the alarm stays
    assert main(["certify", "--from-monitor", str(state), "--at-alarm", "-o", str(tmp_path / "c.json")]) == 1
    document = json.loads((tmp_path / "c.json").read_text())
    assert document["intervals"]["local"]["ratio"][0] == alarm["lower"]
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    assert run(log, state, Settings(**{**vars(SETTINGS), "targets": {"max_local_ratio": "5/4"}, "run_length": 20_000})).alarms == raised


# Change


def turned(settings: Settings, before: int = 6_000, after: int = 3_000) -> list[dict[str, Any]]:
    """Equal treatment, until men get half of what they got."""
    rng = random.Random(7)
    listed = []
    for k in range(before + after):
        sex = rng.choice("fm")
        chance = 0.25 if sex == "m" and k >= before else 0.5
        listed.append({"job": "cook", "sex": sex, "answer": "yes" if rng.random() < chance else "no"})
    return listed


TURNED = Settings(
    group=("sex",), context=("job",), decision="answer", utility={"yes": "1"}, window="1500", targets={"max_local_ratio": "3/2"}
)


def test_a_window_that_contradicts_the_stream_is_no_within(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The whole stream stays under 3/2 while its last windows are above: it said WITHIN and exit 0, over a window that exceeds."""
    log, state = write(tmp_path / "log.jsonl", turned(TURNED)), tmp_path / "s.db"
    args = ["monitor", str(log), "--state", str(state), *OPTIONS, "--window", "1500", "--max-local-ratio", "3/2", "--run-length", "0"]
    assert main([*args, "--format", "text", "--prometheus", str(tmp_path / "f.prom")]) == 1
    out = capsys.readouterr().out
    assert "WITHIN" not in out and "CHANGED" in out and "ALARM: the local ratio changed" in out
    assert "local ratio R " not in out  # the interval of the whole stream is withdrawn
    assert 'fairaudit_changed{quantity="local"} 1' in (tmp_path / "f.prom").read_text()
    assert main(["monitor", "--state", str(state), "--format", "json"]) == 1
    entry = envelopes(capsys.readouterr().out)[-1]["result"]
    assert entry["verdict"] == "changed" and entry["ratio"] == {}
    assert [target["verdict"] for target in entry["targets"]] == ["exceeds"]
    (alarm,) = [a for a in entry["alarms"] if "changed" in a]
    assert alarm["changed"] == "local" and alarm["exceeds"] == ["max_local_ratio"]
    assert Fraction(alarm["stream"][1]) < Fraction(alarm["ratio"][0])
    assert Fraction(alarm["error"]) == Fraction(1, 20) + sum(Fraction(1, 20 * i * (i + 1)) for i in range(1, alarm["window"] + 1))


def certified(tmp_path: Path, state: Path, code: int) -> dict[str, Any]:
    target = tmp_path / "changed.json"
    assert main(["certify", "--from-monitor", str(state), "-o", str(target), "--report", str(tmp_path / "page.html"), "--verbose"]) == code
    assert main(["verify", str(target)]) == 0
    assert main(["verify", str(target), "--require", "within"]) == 1
    assert (
        "The local ratio changed" in (tmp_path / "page.html").read_text()
        or "The global ratio changed" in (tmp_path / "page.html").read_text()
    )
    return json.loads(target.read_text())


def test_a_certificate_of_a_stream_that_changed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It claims nothing of one constant ratio, proves the contradiction from both tables, and cannot be made to say more."""
    jsonschema = pytest.importorskip("jsonschema")
    log, state = write(tmp_path / "log.jsonl", turned(TURNED)), tmp_path / "s.db"
    args = ["monitor", str(log), "--state", str(state), *OPTIONS, "--window", "1500", "--max-local-ratio", "3/2", "--max-global-log", "9"]
    args += ["--run-length", "0"]
    assert main([*args, "--format", "json"]) == 1
    entry = envelopes(capsys.readouterr().out)[-1]["result"]
    (alarm,) = [a for a in entry["alarms"] if "changed" in a]
    document = certified(tmp_path, state, 1)
    out = capsys.readouterr().out
    assert "The local ratio changed" in out and "WITHIN" not in out
    window = document["changed"]["window"]
    assert re.search(rf"EXCEEDS +local ratio at most 1\.5 .*: between [\d.]+ and [\d.]+ in window {window}, at confidence", out), out
    judged = document["changed"]["assumptions"]
    assert main(["report", str(tmp_path / "changed.json"), "--format", "markdown"]) == 0
    told = capsys.readouterr().out
    assert len(judged) == 5 and all(f"- {text}\n" in out and text in told.replace("<code>", "") for text in judged[:-1])
    assert f"- {judged[-1]}\n" in out and "the change of the ratio" in told
    assert (document["verdict"], [t["verdict"] for t in document["targets"]]) == ("changed", ["exceeds", "changed"])
    assert "intervals" not in document and not any(c["scope"].startswith("population") for c in document["claims"])
    assert document["changed"]["ratio"]["ratio"] == alarm["ratio"] and document["changed"]["stream"]["ratio"] == alarm["stream"]
    assert Fraction(document["changed"]["confidence"]) == 1 - Fraction(alarm["error"])
    schema = json.loads((Path(fairaudit.__file__).parent / "certificates" / "certificate.schema.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(document)

    def forged(change: Any) -> int:
        copy = json.loads(json.dumps(document))
        change(copy)
        (tmp_path / "forged.json").write_text(json.dumps(copy))
        return main(["verify", str(tmp_path / "forged.json")])

    changed = document["changed"]
    stream = {"local": changed["stream"]}
    most = math.isqrt(int(Fraction(9, 10) / (1 - Fraction(changed["ratio"]["confidence"]))))
    plain = {k: v for k, v in document.items() if k != "changed"}
    for change, code in (
        (lambda d: d.update(verdict="within"), 1),
        (lambda d: d["targets"][1].update(verdict="within"), 1),
        (lambda d: d["targets"][0].update(verdict="changed"), 1),
        (lambda d: d["changed"].update(confidence="24/25"), 1),
        (lambda d: d["changed"].update(window=changed["window"] + 1), 1),
        (lambda d: d["changed"].update(window=most, confidence="1/1000"), 1),  # chosen among so many, it exceeds nothing at 19/20
        (lambda d: d["changed"]["ratio"].update(ratio=["3", changed["ratio"]["ratio"][1]]), 1),
        (lambda d: d["changed"]["stream"].update(ratio=["1", "101/100"]), 1),
        (lambda d: d["changed"].update(ratio=changed["stream"], table=d["subject"]["table"]), 1),
        (lambda d: d["changed"]["table"]["rows"][0].update(weights=["1", "0"]), 1),
        (lambda d: d["changed"]["assumptions"].pop(), 2),
        (lambda d: d["changed"].update(more=1), 2),
        (lambda d: d["changed"].update(window=0), 2),
        (lambda d: d.update(intervals=stream), 2),
        (lambda d: (d.clear(), d.update(plain)), 1),
    ):
        assert forged(change) == code, change.__code__.co_firstlineno
    capsys.readouterr()


def test_a_change_without_an_exceeded_target_ends_with_3(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write(tmp_path / "log.jsonl", turned(TURNED))
    args = ["monitor", str(log), *OPTIONS, "--window", "1500", "--format", "json"]
    assert main([*args, "--max-local-ratio", "9"]) == 3
    assert envelopes(capsys.readouterr().out)[-1]["result"]["targets"][0]["verdict"] == "changed"
    assert main(args) == 3  # without a target
    assert envelopes(capsys.readouterr().out)[-1]["result"]["verdict"] == "changed"
    assert main([*args, "--max-local-ratio", "9", "--exit-on", "changed"]) == 3
    capsys.readouterr()


@pytest.mark.parametrize("seed", range(2))
def test_a_constant_stream_is_not_said_to_change(tmp_path: Path, seed: int) -> None:
    monitor = run(write(tmp_path / "log.jsonl", events(4_000, seed)), settings=Settings(**{**vars(SETTINGS), "window": "500"}))
    assert monitor.alarms == [] and monitor.withdrawn == frozenset()


def test_the_mix_of_contexts_touches_the_global_ratio_alone(tmp_path: Path) -> None:
    """Groups that move between contexts change the global ratio; within each context nothing changes."""
    rng = random.Random(3)
    listed = []
    for k in range(24_000):
        sex, late = rng.choice("fm"), k >= 16_000
        job = "cook" if rng.random() < ((0.95 if sex == "f" else 0.05) if late else 0.5) else "clean"
        listed.append({"job": job, "sex": sex, "answer": "yes" if rng.random() < (0.9 if job == "cook" else 0.1) else "no"})
    targets = {"max_local_ratio": "2", "max_global_ratio": "2"}
    settings = Settings(**{**vars(SETTINGS), "window": "2000", "targets": targets})
    log, path = write(tmp_path / "log.jsonl", listed), tmp_path / "s.db"
    found = run(log, path, settings)
    assert found.withdrawn == frozenset({"global"})
    assert {a.get("changed") for a in found.alarms} >= {"global"}
    again = Monitor(State(str(path), settings), str(log))
    shown = again.look()
    again.close()
    assert shown.verdict == "changed" and set(shown.intervals) == {"local"}
    assert shown.verdicts == {"max_local_ratio": "within", "max_global_ratio": "exceeds"} and shown.exit_code == 1
    document = certified(tmp_path, path, 1)
    assert [t["verdict"] for t in document["targets"]] == ["within", "exceeds"] and document["verdict"] == "changed"
    assert set(document["intervals"]) == {"local"} and document["changed"]["quantity"] == "global"
    only = run(log, settings=Settings(**{**vars(settings), "targets": {"max_local_ratio": "2"}}))
    assert only.withdrawn == frozenset({"global"})


def test_joint_bets_are_declared_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, state = write(tmp_path / "log.jsonl", events(3_000)), tmp_path / "s.db"
    asked = ["monitor", str(log), "--state", str(state), *OPTIONS, "--max-local-ratio", "6/5"]
    assert main([*asked, "--bets", "joint"]) == 1
    last = envelopes(capsys.readouterr().out)[-1]["result"]
    assert main(["certify", "--from-monitor", str(state), "-o", str(tmp_path / "c.json"), "--report", str(tmp_path / "p.html")]) == 1
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    document = json.loads((tmp_path / "c.json").read_text())
    interval = document["intervals"]["local"]
    assert interval["region"] == "joint" and interval["levels"]["ratios"] == ["1", "6/5"]
    assert [float(Fraction(end)) for end in interval["ratio"]] == pytest.approx(last["ratio"]["local"], rel=5e-3)
    capsys.readouterr()
    assert main(asked) == 2
    assert "bets is 'joint' there and 'separate' here" in capsys.readouterr().err
    assert main(["monitor", str(log), *OPTIONS, "--bets", "joint", "--unit", "answer"]) == 2
    assert "joint bets (--bets joint) need" in capsys.readouterr().err
    assert main(["monitor", "--state", str(state)]) == 1
    changing = write(tmp_path / "changing.jsonl", turned(TURNED))
    args = ["monitor", str(changing), "--state", str(tmp_path / "t.db"), *OPTIONS, "--window", "1500", "--bets", "joint"]
    assert main([*args, "--max-local-ratio", "3/2", "--run-length", "0"]) == 1
    assert certified(tmp_path, tmp_path / "t.db", 1)["changed"]["ratio"]["region"] == "joint"


# Change by a detector


def worsened(before: int = 8_000, after: int = 3_000) -> list[dict[str, Any]]:
    """Equal treatment, until men get half of what they got; a second of the clock for each decision."""
    return [event | {"at": 10**9 + k} for k, event in enumerate(turned(TURNED, before, after))]


DETECTING = [*OPTIONS, "--time", "at", "--max-local-ratio", "5/4"]


def test_a_detector_says_since_when_the_ratio_is_above_the_limit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Withdrawn is what was said about the whole stream; the certificate is about the decisions since the alarm, and claims no change."""
    log, state = write(tmp_path / "log.jsonl", worsened()), tmp_path / "s.db"
    assert main(["monitor", str(log), "--state", str(state), *DETECTING, "--format", "json"]) == 1
    entries = [entry["result"] for entry in envelopes(capsys.readouterr().out)]
    alarm, entry = next(e for e in entries if e["event"] == "alarm"), entries[-1]
    assert alarm["detected"] == alarm["changed"] == "local" and alarm["limit"] == "5/4"
    assert alarm["pair"] == {"context": {"job": "cook"}, "higher": {"sex": "f"}, "lower": {"sex": "m"}}
    assert 7_800 < alarm["since"]["decision"] <= 8_300 and alarm["since"]["clock"] == 10**9 + alarm["since"]["decision"] - 1
    assert 8_000 < alarm["events"] <= 10_000 and alarm["under"] < 8_000 and alarm["line"] == alarm["events"]
    assert (alarm["run_length"], alarm["directions"]) == (20_000, 2)
    pairs = Fraction(alarm["error"]) * 20_000
    assert pairs == int(pairs) and alarm["events"] / 4 < pairs < alarm["events"] / 2
    assert entry["verdict"] == "changed" and entry["ratio"] == {} and entry["targets"][0]["verdict"] == "exceeds"
    assert entry["since_alarm"]["events"] == 11_000 - alarm["events"] and entry["since_alarm"]["confidence"] == "39/40"
    assert main(["certify", "--from-monitor", str(state), "-o", str(tmp_path / "c.json")]) == 1
    assert f"the decisions since its last alarm, after {alarm['events']} decisions" in capsys.readouterr().err
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    document = json.loads((tmp_path / "c.json").read_text())
    assert "changed" not in document and document["intervals"]["local"]["confidence"] == "39/40" and document["verdict"] == "exceeds"
    counted_since = Counter(e["sex"] for e in worsened()[alarm["events"] :])
    weights = [sum(map(int, row["weights"])) for row in document["subject"]["table"]["rows"]]
    assert sorted(weights) == sorted(counted_since.values())
    assert main(["certify", "--from-monitor", str(state), "--at-alarm"]) in (1, 2)
    capsys.readouterr()
    assert main(["monitor", "--state", str(state), "--format", "text"]) == 1
    said = capsys.readouterr().out
    assert "CHANGED" in said and "since the alarm: " in said and "20000 pairs of decisions per direction or more in the mean" in said


def test_a_detector_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    listed = worsened()
    chosen = Settings(**{**vars(SETTINGS), "targets": {"max_local_ratio": "5/4"}, "run_length": 20_000, "time": "at"})
    whole = run(write(tmp_path / "whole.jsonl", listed), tmp_path / "whole.db", chosen)
    log, state = tmp_path / "log.jsonl", tmp_path / "s.db"
    for k in range(0, len(listed), 1_700):
        write(log, listed[k : k + 1_700], "a")
        parts = run(log, state, chosen)
    detected = [
        [alarm | {"counts": sorted(alarm["counts"])} for alarm in monitor.alarms if "detected" in alarm] for monitor in (whole, parts)
    ]
    assert detected[0] == detected[1] and len(detected[0]) == 1
    assert (whole.part.n, whole.total.n) == (parts.part.n, parts.total.n) and whole.part.events == 11_000 - detected[0][0]["events"]


def test_a_ratio_that_was_always_above_the_limit_is_not_said_to_change(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = random.Random(4)
    listed = [{"job": "cook", "sex": s, "answer": "yes" if rng.random() < (0.5 if s == "f" else 0.25) else "no"} for s in "fm" * 3_000]
    assert main(["monitor", str(write(tmp_path / "log.jsonl", listed)), *OPTIONS, "--max-local-ratio", "5/4", "--format", "json"]) == 1
    entries = [entry["result"] for entry in envelopes(capsys.readouterr().out)]
    [alarm] = [e for e in entries if e["event"] == "alarm" and "detected" in e]
    assert "changed" not in alarm and entries[-1]["verdict"] == "exceeds" and set(entries[-1]["ratio"]) == {"local", "global"}


def test_without_a_target_or_with_units_there_is_no_detector(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write(tmp_path / "log.jsonl", events(50, person=lambda k: k))
    for options, code in (
        ([], 0),
        (["--run-length", "500"], 2),
        (["--max-local-ratio", "5/4", "--unit", "person"], 3),
        (["--max-local-ratio", "5/4", "--unit", "person", "--run-length", "500"], 2),
        (["--max-local-ratio", "5/4", "--run-length", "99"], 2),
        (["--max-local-ratio", "5/4", "--run-length", "100"], 3),
        (["--max-local-log", "900"], 0),
    ):
        assert main(["monitor", str(log), *OPTIONS, *options]) == code, options
    capsys.readouterr()


def test_a_state_that_began_without_a_detector_goes_on_without(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, state = write(tmp_path / "log.jsonl", events(50)), tmp_path / "s.db"
    asked = ["monitor", str(log), "--state", str(state), *OPTIONS, "--max-local-ratio", "5/4"]
    assert main([*asked, "--run-length", "0"]) == 3
    assert main(asked) == 3
    stored = State(str(state), read_only=True)
    assert stored.settings.run_length == 0 and "run_length" not in stored.settings.text
    stored.close()
    capsys.readouterr()
    assert main([*asked, "--run-length", "500"]) == 2
    assert "run_length is 0 there and 500 here" in capsys.readouterr().err


# Kills

KILLS = 50 if tiers.FULL else 3


def start(log: Path, state: Path, letters: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "fairaudit", "monitor", str(log), "--state", str(state), *OPTIONS, "--event-id", "id"]
    command += ["--max-local-ratio", "8/5", "--dead-letters", str(letters), "--every", "0.05", "--pair-by-time"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=Path(__file__).resolve().parents[2])


@POSIX
def test_kills_at_random_moments_lose_nothing_and_count_nothing_twice(tmp_path: Path) -> None:
    rng = random.Random(8)
    listed: list[Any] = events(60_000 if tiers.FULL else 30_000, id=lambda k: k)
    for k in range(80):
        listed.insert(97 * k, f"broken {k}")
    log = write(tmp_path / "log.jsonl", listed)
    begun = time.monotonic()
    assert start(log, tmp_path / "whole.db", tmp_path / "whole.dead").wait() in (0, 1, 3)
    whole = time.monotonic() - begun
    killed, halfway, fresh = 0, 0, True
    for _ in range(20 * KILLS):
        begun = time.monotonic()
        process = start(log, tmp_path / "killed.db", tmp_path / "killed.dead")
        try:
            process.wait(rng.uniform(0.3, 1.1) * whole)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            killed, fresh = killed + 1, False
            halfway += 0 < offset(tmp_path / "killed.db") < log.stat().st_size
        if killed >= KILLS and halfway:
            break
        if process.returncode >= 0:  # it came to the end: begin again, until there were enough kills
            same(tmp_path)
            whole = time.monotonic() - begun if fresh else whole
            fresh = True
            for name in ("killed.db", "killed.db-wal", "killed.db-shm", "killed.dead"):
                (tmp_path / name).unlink(missing_ok=True)
    print(f"{killed} kills, {halfway} of them with a part of the log counted")
    assert killed >= KILLS and halfway
    assert start(log, tmp_path / "killed.db", tmp_path / "killed.dead").wait() in (0, 1, 3)
    same(tmp_path)


def offset(path: Path) -> int:
    """How far a state has come; 0 before it is one."""
    if not path.exists():
        return 0
    with contextlib.suppress(InputError):
        state = State(str(path), read_only=True)
        place = state.place()
        state.close()
        return place.offset
    return 0


def same(tmp_path: Path) -> None:
    for name in ("whole", "killed"):
        assert main(["certify", "--from-monitor", str(tmp_path / f"{name}.db"), "-o", str(tmp_path / f"{name}.json")]) in (0, 1, 3)
    found = []
    for name in ("whole", "killed"):
        state = State(str(tmp_path / f"{name}.db"), read_only=True)
        found.append((state.get("detectors"), state.get("time_pairs")))
        state.close()
    assert found[0] == found[1] and set(found[0][0]) == {"local"} and len(found[0][1][1]) == 2
    for end in ("json", "dead"):
        whole, killed = ((tmp_path / f"{name}.{end}").read_bytes() for name in ("whole", "killed"))
        if whole != killed:  # without a comparison line by line, which takes long
            pytest.fail(f"the {end} of the resumed monitor differs: {len(whole)} and {len(killed)} bytes")


# The command line


def test_a_certificate_of_a_state_verifies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, state = write(tmp_path / "log.jsonl", events(3_000)), tmp_path / "s.db"
    assert main(["monitor", str(log), "--state", str(state), *OPTIONS, "--max-local-ratio", "2"]) in (0, 3)
    last = envelopes(capsys.readouterr().out)[-1]["result"]
    code = main(["certify", "--from-monitor", str(state), "-o", str(tmp_path / "c.json"), "--format", "json"])
    document = result_of(capsys.readouterr().out)
    assert last["verdict"] == document["verdict"] and code == {"within": 0, "inconclusive": 3}[last["verdict"]]
    assert float(Fraction(document["intervals"]["local"]["ratio"][1])) == pytest.approx(last["ratio"]["local"][1], rel=1e-3)
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    assert main(["certify", "--from-monitor", str(state), "--confidence", "0.5"]) == 2


def test_the_command_refuses_bad_input_in_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write(tmp_path / "log.jsonl", events(10))
    for arguments in (
        ["monitor"],
        ["monitor", str(log)],
        ["monitor", str(tmp_path / "none.jsonl"), *OPTIONS],
        ["monitor", str(log), *OPTIONS, "--window", "x"],
        ["monitor", str(log), *OPTIONS, "--utility-column", "pay"],
        ["monitor", str(log), *OPTIONS, "--state", str(log)],
        ["monitor", str(log), *OPTIONS, "--baseline", str(log)],
        ["monitor", str(log), *OPTIONS, "--dead-letters", str(tmp_path)],
        ["certify", "--from-monitor", str(tmp_path / "none.db")],
    ):
        assert main(arguments) == 2
        said = capsys.readouterr()
        assert not said.out and said.err.startswith("fairaudit: ") and said.err.count("\n") == 1, arguments


def test_intervals_are_refused_and_quoted_names_are_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    named = [{**e, "age:18": e["job"]} for e in events(300)]
    log = write(tmp_path / "log.jsonl", named)
    given = ["--decision", "answer", "--utility", "yes"]
    for options, said in (
        (["--group", "sex", "--context", "job,age:18,30"], "--context 'age:18,30' cuts numbers into intervals"),
        (["--group", "sex,age:18"], "--group 'age:18' cuts numbers into intervals"),
    ):
        assert main(["monitor", str(log), *given, *options, "--state", str(tmp_path / "watch.db")]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and said in err and "'\"age:18\"'" in err
        assert not (tmp_path / "watch.db").exists()
    lines = []
    for context in ("job", '"age:18"'):
        assert main(["monitor", str(log), *given, "--group", "sex", "--context", context, "--format", "json"]) == 0
        lines.append(envelopes(capsys.readouterr().out)[-1]["result"]["ratio"])
    assert lines[0] == lines[1]


def test_a_baseline_says_whether_the_ratio_changed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = random.Random(2)

    def fair(p: float, q: float) -> list[dict[str, str]]:
        return [{"job": "cook", "sex": s, "answer": "yes" if rng.random() < (p if s == "f" else q) else "no"} for s in "fm" * 3_000]

    first, second = write(tmp_path / "a.jsonl", fair(0.5, 0.5)), write(tmp_path / "b.jsonl", fair(0.8, 0.3))
    main(["monitor", str(first), "--state", str(tmp_path / "a.db"), *OPTIONS])
    main(["certify", "--from-monitor", str(tmp_path / "a.db"), "-o", str(tmp_path / "a.json")])
    capsys.readouterr()
    for log, verdict in ((first, "no change shown"), (second, "greater")):
        main(["monitor", str(log), *OPTIONS, "--baseline", str(tmp_path / "a.json")])
        change = envelopes(capsys.readouterr().out)[-1]["result"]["change"]
        assert change["local"]["verdict"] == verdict
        assert change["local"]["confidence"] == "9/10"
    columns = ["--decision", "answer", "--group", "sex", "--context", "job", "--utility", "yes", "--max-local-ratio", "2"]
    main(["certify", str(first), *columns, "-o", str(tmp_path / "b.json")])
    capsys.readouterr()
    main(["monitor", str(second), *OPTIONS, "--baseline", str(tmp_path / "b.json")])
    change = envelopes(capsys.readouterr().out)[-1]["result"]["change"]
    assert (change["local"]["verdict"], change["local"]["confidence"]) == (
        "greater",
        "17/20",
    )  # each end of the target's has an error of 1/20
    assert change["global"]["confidence"] == "9/10"


def test_prometheus_gets_a_whole_file(tmp_path: Path) -> None:
    log = write(tmp_path / "log.jsonl", events(500))
    main(["monitor", str(log), *OPTIONS, "--max-local-log", "0.2", "--prometheus", str(tmp_path / "f.prom")])
    lines = (tmp_path / "f.prom").read_text().splitlines()
    assert "fairaudit_decisions_total 500" in lines
    assert sum(line.startswith('fairaudit_ratio{quantity="local"') for line in lines) == 2


def test_standard_input_is_read(tmp_path: Path) -> None:
    log = write(tmp_path / "log.jsonl", events(300))
    command = [sys.executable, "-m", "fairaudit", "monitor", "-", *OPTIONS]
    with log.open() as file:
        done = subprocess.run(command, stdin=file, capture_output=True, text=True, cwd=Path(__file__).resolve().parents[2])
    assert done.returncode == 0, done.stderr
    assert envelopes(done.stdout)[-1]["result"]["decisions"] == 300


def test_times_are_read() -> None:
    assert reader.moment("2026-01-01T00:00:00+01:00") == reader.moment("2025-12-31T23:00:00Z")
    for bad in ("yesterday", None, True, "inf", 1e13, [1]):
        with pytest.raises(InputError, match="is not a time"):
            reader.moment(bad)


def test_a_baseline_says_whether_decisions_left_the_radius_of_its_verdict(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def decided(f: int, m: int, job: str = "cook") -> list[dict[str, str]]:
        """Of 100 women and 100 men; those who get nothing get one of two labels."""
        return [
            {"job": job, "sex": s, "answer": "yes" if k < yes else "no" if k % 2 else "later"}
            for s, yes in (("f", f), ("m", m))
            for k in range(100)
        ]

    made = tmp_path / "c.json"
    columns = ["--decision", "answer", "--group", "sex", "--context", "job", "--utility", "yes", "--confidence", "none"]

    def watched(log: list[dict[str, str]], *given: str) -> tuple[dict[str, Any], str]:
        options = ["monitor", str(write(tmp_path / "new.jsonl", log)), *(given or OPTIONS), "--baseline", str(made)]
        main([*options, "--format", "json"])
        answer = envelopes(capsys.readouterr().out)[-1]
        main([*options, "--format", "text"])
        return answer["result"]["radii"][0], capsys.readouterr().out

    # 1/2 against 2/5 and a limit of 2 have the radius 1/10.
    main(["certify", str(write(tmp_path / "old.jsonl", decided(50, 40))), *columns, "--max-local-ratio", "2", "-o", str(made)])
    capsys.readouterr()
    for log, moved, left in ((decided(50, 40), "0", False), (decided(60, 30), "1/10", False), (decided(61, 35), "11/100", True)):
        radius, text = watched(log)
        assert (radius["radius"], radius["moved"], radius["left"], radius["verdict"]) == ("1/10", moved, left, "within")
        assert f" {radius['sentence']} (the decisions so far)" in " ".join(text.split())
        assert max(map(len, text.splitlines())) <= 80 and "per second" not in text
    assert watched(decided(61, 35))[0]["cell"] == {"job": "cook", "sex": "f"}
    assert watched([*decided(50, 40), *decided(50, 40, "clean")])[0]["left"] is True  # the verdict was of no such context
    other = ["--decision", "answer", "--group", "sex", "--utility", "yes"]
    assert watched(decided(50, 40), *other)[0]["sentence"].endswith("says nothing of a table with other columns")
    worth = [*OPTIONS[:-1], "yes=2"]
    assert watched(decided(50, 40), *worth)[0]["sentence"].endswith("says nothing of a utility whose range is another one")

    # No update whatever changes a verdict that the range of the utility gives.
    main(
        [
            "certify",
            str(tmp_path / "old.jsonl"),
            *columns[:-4],
            "--utility",
            "yes=2,no=1,later=1",
            *columns[-2:],
            "--max-local-ratio",
            "2",
            "-o",
            str(made),
        ]
    )
    capsys.readouterr()
    found, _ = watched([*decided(99, 1), *decided(1, 99, "clean")], *OPTIONS[:-1], "yes=2,no=1,later=1")
    assert (found["radius"], found["left"], found["moved"]) == ("inf", False, None)
    assert watched(decided(50, 40))[0]["left"] is None  # here what is not listed is worth 0

    # A limit that is exceeded: the cells of a context that has no decision yet may be those that exceed it.
    old = [*decided(50, 40), *decided(50, 49, "clean")]
    main(["certify", str(write(tmp_path / "old.jsonl", old)), *columns, "--max-local-ratio", "8/7", "-o", str(made)])
    capsys.readouterr()
    assert watched(old)[0]["left"] is False
    seen, text = watched(decided(50, 40))
    assert seen["left"] is None and "2 of its cells have no decision so far" in " ".join(text.split())
    assert watched([*decided(48, 40), *decided(50, 49, "clean")])[0]["left"] is True


def test_columns_are_paths_into_lines(tmp_path: Path) -> None:
    listed = events(300, 3)
    nested = [{"who": {"sex": e["sex"]}, "job": e["job"], "out": [{"text": "draft"}, {"text": e["answer"]}]} for e in listed]
    log = write(tmp_path / "log.jsonl", [*nested[:200], {"who": {"sex": "f"}, "job": "cook", "out": {"text": "yes"}}, *nested[200:]])
    settings = Settings(group=("who.sex",), context=("job",), decision="out[last].text", utility={"yes": "1"})
    with contextlib.closing(Monitor(State(None, settings), str(log), str(tmp_path / "dead"))) as monitor:
        list(monitor.read())
        assert counted(monitor) == expected(listed)
        assert monitor.tally["dead"] == 1
    with pytest.raises(InputError, match=r"a line of a stream is one decision; name an element"):
        reader.decoder(Settings(group=("who.sex",), decision="out[*].text", utility={"yes": "1"}))


@pytest.mark.parametrize("form", ["file", "blank lines", "standard input"])
def test_lines_of_an_evaluation_are_no_decisions(tmp_path: Path, capsys: pytest.CaptureFixture[str], form: str) -> None:
    """A question that two filters read has two lines, and an answer that never came has one."""
    source = next((Path(__file__).parents[1] / "tables" / "evaluations" / "logs" / "lm-eval").glob("samples_loan_text_*.jsonl"))
    log = write(
        tmp_path / "log.jsonl", ["", *source.read_text().splitlines()] if form == "blank lines" else source.read_text().splitlines()
    )
    asked = ["--decision", "filtered_resps[0]", "--group", "doc.region", "--utility", "yes", "--format", "json"]
    command = [sys.executable, "-m", "fairaudit", "monitor", "-", *asked]
    if form == "standard input":
        ran = subprocess.run(command, input=log.read_bytes(), capture_output=True, check=False)
        code, out, err = ran.returncode, ran.stdout.decode(), ran.stderr.decode()
    else:
        code = main(["monitor", str(log), *asked])
        out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "this is a log of lm-eval, in which a question may have several lines" in err and "fairaudit certify" in err


def test_a_line_with_an_exponent_of_many_digits_is_no_decision(tmp_path: Path) -> None:
    lines = ['{"job":"cook","sex":"f","answer":"yes"}', '{"job":1e99999999999999999999999,"sex":"m","answer":"no"}']
    assert run(write(tmp_path / "log.jsonl", lines)).tally["dead"] == 1


def test_a_log_that_a_state_has_counted_is_counted_once_under_whatever_name(tmp_path: Path) -> None:
    import shutil

    day, state = tmp_path / "day1.csv", tmp_path / "watch.db"
    day.write_text("hired,sex\n" + "yes,f\nno,m\n" * 300)

    def watched(path: Path, **more: Any) -> int:
        with fairaudit.monitor(path, state=state, decision="hired", group="sex", utility="yes", **more) as watch:
            return watch.catch_up().events

    assert watched(day) == 600
    copy, link, hard = Path(shutil.copy(day, tmp_path / "copy.csv")), tmp_path / "link.csv", tmp_path / "hard.csv"
    link.symlink_to(day)
    hard.hardlink_to(day)
    other = tmp_path / "day2.csv"
    other.write_text("hired,sex\n" + "no,f\nyes,m\n" * 200)
    assert watched(other) == 1000
    for again in (day, copy, link, hard):
        with pytest.raises(InputError, match="each line is counted once") as refused:
            watched(again)
        assert str(again) in str(refused.value) and str(day) in str(refused.value)
    with pytest.raises(InputError, match="are one file"):
        watched(link, same_content="accept")
    assert watched(copy, same_content="accept") == 1600


def test_short_logs_that_begin_alike_are_two_logs(tmp_path: Path) -> None:
    state = tmp_path / "watch.db"
    for name, times, events in (("monday.csv", 1, 2), ("tuesday.csv", 2, 6)):
        (tmp_path / name).write_text("hired,sex\n" + "yes,f\nno,m\n" * times)
        with fairaudit.monitor(tmp_path / name, state=state, decision="hired", group="sex", utility="yes") as watch:
            assert watch.catch_up().events == events
