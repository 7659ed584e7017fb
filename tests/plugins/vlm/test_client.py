"""Asking a real server that misbehaves: one recorded outcome for each cell and trial, limits kept, nothing lost, nothing leaked."""

from __future__ import annotations

import asyncio
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
import tiers
from asking import asked, key, written
from hypothesis import given
from hypothesis import strategies as st
from language_server import completion, pick, serving
from needs import POSIX

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.vlm import client as client_module
from fairaudit.plugins.vlm.analyse import readings, tables
from fairaudit.plugins.vlm.client import Bucket, retry_after
from fairaudit.plugins.vlm.experiment import Model, read_experiment, with_overrides
from fairaudit.plugins.vlm.journal import Journal, Work
from fairaudit.plugins.vlm.run import Budget, run

__all__ = ["key"]


def test_limits_are_kept_at_the_server(tmp_path: Path) -> None:
    written(tmp_path, trials=10)
    with serving(delay=0.05) as server:
        _, _, report = asked(tmp_path, server, concurrency=3, requests_per_minute=600.0)
        assert report.complete
        assert server.most == 3
        times = sorted(server.arrivals)
    # At most the bucket (10) and what flows in meanwhile (590 a minute) can arrive; half a second allows for threads that start late.
    for i, first in enumerate(times):
        for j in range(i, len(times)):
            assert j - i + 1 <= 10 + (times[j] - first + 0.5) * 590 / 60


@given(st.floats(5, 5_000), st.lists(st.tuples(st.floats(0, 30), st.floats(0.01, 1)), min_size=1, max_size=60), st.floats(0.1, 3))
def test_no_minute_gets_more_than_its_limit(per_minute: float, calls: list[tuple[float, float]], largest: float) -> None:
    """A bucket on a clock of its own: whatever arrives when, each window of 60 seconds lets at most the limit through."""
    now = 0.0
    passed: list[tuple[float, float]] = []

    async def sleep(seconds: float) -> None:
        nonlocal now
        assert seconds > 0
        now += seconds

    async def everything() -> None:
        nonlocal now
        bucket = Bucket(per_minute, largest=largest, clock=lambda: now)
        for gap, share in calls:
            now += gap
            amount = share * largest
            await bucket.take(amount)
            passed.append((now, amount))

    patch = pytest.MonkeyPatch()
    with patch.context() as patched:
        patched.setattr(client_module.asyncio, "sleep", sleep)
        asyncio.run(everything())
    for i, (first, _) in enumerate(passed):
        assert sum(amount for moment, amount in passed[i:] if moment < first + 60) <= per_minute * (1 + 1e-9)


def test_tokens_per_minute_and_retry_after(tmp_path: Path) -> None:
    written(tmp_path, trials=3)
    with serving(fault=lambda key, attempt: "429" if attempt == 1 else "") as server:
        _, _, report = asked(tmp_path, server, tokens_per_minute=240_000.0, concurrency=2, parameters={"max_tokens": 100})
        assert report.complete
        assert set(server.attempts.values()) == {2}
        by_key: dict[str, list[float]] = {}
        for key, moment in zip(server.keys, server.arrivals, strict=True):
            by_key.setdefault(key, []).append(moment)
        assert all(second - first >= 0.19 for first, second in by_key.values())
    assert retry_after("Wed, 21 Oct 2015 07:28:00 GMT") == 0
    assert retry_after("nan") == 0
    assert retry_after("1e9") == 1e9


def test_a_budget_stops_cleanly_and_is_resumed(tmp_path: Path) -> None:
    written(tmp_path, trials=10)
    prices: dict[str, object] = {"price_input": 100.0, "price_output": 1000.0, "parameters": {"max_tokens": 300}}
    with serving() as server:
        experiment, model, report = asked(tmp_path, server, Budget(money=0.6), **prices)
        assert report.stopped
        asked_first = len(server.keys)
        # Each answer costs 120·100 + 30·1000 millionths: 0.042. Nothing is sent that could go beyond the budget.
        assert 0 < asked_first * 0.042 <= 0.6
        assert report.answered == asked_first
        _, _, report = asked(tmp_path, server, Budget(money=0.6), **prices)
        assert (report.answered, len(server.keys)) == (asked_first, asked_first)
        _, _, report = asked(tmp_path, server, Budget(tokens=40 * 150 + 700), **prices)
        assert report.complete
        assert Counter(server.attempts.values()) == {1: 40}
    with Journal(tmp_path / "journal.sqlite", experiment.digest, experiment.trials, create=False) as journal:
        assert journal.spent(model.key)[:2] == (40 * 150, pytest.approx(40 * 0.042))


def test_first_token_probabilities(tmp_path: Path) -> None:
    written(tmp_path, trials=7, kind='kind = "logprobs"')
    with serving(fault=lambda key, attempt: "no logprobs" if len(server.attempts) == 1 else "") as server:
        experiment, model, report = asked(tmp_path, server, concurrency=1)
    assert report.total == 4  # one call for each cell, whatever the trials
    assert all(body["logprobs"] and body["max_tokens"] == 1 for body in server.bodies)
    with Journal(tmp_path / "journal.sqlite", experiment.digest, experiment.trials, create=False) as journal:
        (table,) = tables(experiment, journal, model.key)
    assert not table.sampled
    found = sorted(tuple(round(float(row[u]), 9) for u in ("HR1", "HR2", "unreadable")) for row in table.rows.values())
    assert found == [(0.0, 0.0, 1.0), *[(0.8, 0.15, 0.05)] * 3]


def test_images_are_sent_whole_and_kept_by_their_digest(tmp_path: Path) -> None:
    import base64
    import hashlib

    picture = b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40
    (tmp_path / "route.png").write_bytes(picture)
    written(tmp_path, trials=1, more='[images]\nHR2 = "route.png"\n[images."sick leave"]\nHR1 = "route.png"')
    with serving() as server:
        _, _, report = asked(tmp_path, server)
        assert report.complete
        for body in server.bodies:
            content = body["messages"][-1]["content"]
            sent = [part["image_url"]["url"] for part in content if part["type"] == "image_url"]
            assert len(sent) == (2 if "sick leave" in content[0]["text"] else 1)
            assert {base64.b64decode(url.partition("base64,")[2]) for url in sent} == {picture}
    database = sqlite3.connect(tmp_path / "journal.sqlite")
    requests = [text for (text,) in database.execute("SELECT body FROM requests")]
    database.close()
    assert all(f"sha256:{hashlib.sha256(picture).hexdigest()}" in text and "base64" not in text for text in requests)
    # Another picture is another experiment.
    (tmp_path / "route.png").write_bytes(picture + b"x")
    with serving() as server, pytest.raises(InputError, match="another experiment file"):
        asked(tmp_path, server)


def test_nothing_hides_behind_a_retry(tmp_path: Path) -> None:
    """A request that the server refuses as such ends the run with its words; a wrong key is never repeated."""
    written(tmp_path)
    with serving(fault=lambda key, attempt: "bad request") as server:
        with pytest.raises(InputError, match="response_format is not supported"):
            asked(tmp_path, server, concurrency=1)
        assert len(server.keys) == 1
    with serving() as server, pytest.MonkeyPatch.context() as patch:
        patch.setenv("OPENAI_API_KEY", "sk-wrong-key-9999")
        with pytest.raises(InputError, match="401") as error:
            asked(tmp_path, server)
        assert "sk-wrong" not in str(error.value)
    for path in tmp_path.iterdir():
        assert b"sk-wrong" not in path.read_bytes()


def test_a_server_that_never_answers(tmp_path: Path) -> None:
    written(tmp_path)
    with serving(fault=lambda key, attempt: "500") as server, pytest.raises(InputError, match="gives no answer: status 500"):
        asked(tmp_path, server, retries=2)
    model = Model("m", base_url="http://127.0.0.1:9", retries=1)
    experiment = read_experiment(str(tmp_path / "test.toml"))
    with (
        Journal(tmp_path / "other.sqlite", experiment.digest, experiment.trials, create=True) as journal,
        pytest.raises(InputError, match="no connection"),
    ):
        run(experiment, model, journal)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"base_url": "http://127.0.0.1:999999/v1"}, "the base URL .* is not accepted"),
        ({"base_url": "http://[::1/v1"}, "the base URL .* is not accepted"),
        ({"base_url": "http://xn--/v1"}, "the address cannot be used"),
        ({"proxy": "ftp://me:hush@host"}, "the proxy that the environment names cannot be used"),
        ({"timeout": float("nan")}, "a positive number of seconds"),
        ({"price_input": -1.0}, "prices are numbers of at least 0"),
        ({"requests_per_minute": float("nan")}, "limits per minute are positive"),
        ({"concurrency": "4"}, "concurrency is '4', which is no int"),
    ],
)
def test_addresses_and_limits_that_cannot_be(
    changes: dict[str, object], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path)
    experiment = read_experiment(str(path))
    monkeypatch.setenv("HTTP_PROXY", str(changes.pop("proxy", "")))
    with (
        Journal(tmp_path / "journal.sqlite", experiment.digest, experiment.trials, create=True) as journal,
        pytest.raises(InputError, match=said) as error,
    ):
        run(experiment, with_overrides(Model("m", base_url="http://127.0.0.1:9", retries=0), changes), journal)
    assert "hush" not in str(error.value)


def test_two_runs_of_one_journal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path)
    experiment = read_experiment(str(path))
    (tmp_path / "out").mkdir()
    with Journal(tmp_path / "out" / "journal.sqlite", experiment.digest, experiment.trials, create=True) as journal:
        journal.claim()
        assert main(["experiment", "run", str(path), "--folder", str(tmp_path / "out"), "--maker", "stand-in"]) == 2
    assert "another process is running" in capsys.readouterr().err


def test_a_journal_is_claimed_once_under_all_its_names(tmp_path: Path) -> None:
    experiment = read_experiment(str(written(tmp_path)))
    names = [tmp_path / "journal.sqlite", tmp_path / "other.sqlite", tmp_path / "linked" / "journal.sqlite"]
    names[1].symlink_to(names[0])
    (tmp_path / "linked").symlink_to(tmp_path, target_is_directory=True)
    with Journal(names[0], experiment.digest, experiment.trials, create=True) as journal:
        journal.claim()
        for name in names:
            again = Journal(name, experiment.digest, experiment.trials, create=False)
            with again, pytest.raises(InputError, match="another process is running"):
                again.claim()


def test_two_profiles_that_read_alike(tmp_path: Path) -> None:
    """Tom A, of age B, and Tom, of age A B, are the same words in a prompt and in a table."""
    path = written(tmp_path)
    text = path.read_text()
    for old, new in (('"Mary"', '"Tom A"'), ('"55"', '"B"'), ('"25"', '"A B"')):
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    with pytest.raises(InputError, match="two profiles read alike"):
        read_experiment(str(path))
    path.write_text(text.replace('"A B"', '"A C"'))
    assert len(read_experiment(str(path)).people) == 2


def test_the_most_that_was_used_counts_every_fault(tmp_path: Path) -> None:
    """What is set aside for a request is the most that any reply used: of faults that an answer followed, too."""
    experiment = read_experiment(str(written(tmp_path)))
    model = Model("m", "stand-in")
    with Journal(tmp_path / "journal.sqlite", experiment.digest, experiment.trials, create=True) as journal:
        run(experiment, model, journal)
        assert journal.largest(model.key) == (0, 0)
        draw = next(iter(journal.answers(model.key))).draw
        work = Work(draw.request, draw.model, 99, draw.shown_context, draw.shown_slots)
        for used, why in (((900, 4), "cut"), ((7, 3000), "cut"), ((8, 5), "")):
            (attempt,) = journal.intend([work], 0, 0.0)
            journal.record([(work, attempt, 200, "text/plain", b"", *used, 0.0)], why)
        assert journal.largest(model.key) == (900, 3000)
        assert journal.spent(model.key)[0] == 904 + 3007 + 13


@POSIX
def test_a_full_disk_loses_nothing(tmp_path: Path) -> None:
    """The journal may grow to 320 KiB; then the file system refuses, as a full disk does."""
    path = written(tmp_path, trials=60)
    code = (
        "import resource, signal, sys; sys.dont_write_bytecode = True; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (327680, 327680));"
        "from fairaudit.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    with serving() as server:
        command = ["experiment", "run", str(path), "--folder", str(tmp_path / "out"), "--base-url", server.url, "--model", "m"]
        done = subprocess.run([sys.executable, "-c", code, *command, "--concurrency", "8"], capture_output=True, text=True, check=False)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith("fairaudit: the journal")
        assert done.stderr.count("\n") == 1
        database = sqlite3.connect(tmp_path / "out" / "journal.sqlite")
        kept = {f"{r[:32]}-{t}" for r, t in database.execute("SELECT request, trial FROM answers")}
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        database.close()
        first = set(server.keys)
        assert kept <= first
        assert len(first - kept) <= 8
        assert main(command) == 0
        assert {key for key, n in server.attempts.items() if n > 1} <= first - kept


@POSIX
def test_kill_at_random_moments(tmp_path: Path) -> None:
    """kill −9: no acknowledged answer is lost, none is paid for twice except those in flight, which are listed; the counts are the same."""
    trials, kills = (500, 40) if tiers.FULL else (30, 4)
    path = written(tmp_path, trials=trials)
    total = 4 * trials
    generator = random.Random(20)
    out = tmp_path / "out"
    with serving(delay=0.04) as server:
        command = [sys.executable, "-m", "fairaudit", "experiment", "run", str(path), "--folder", str(out), "--base-url", server.url]
        command += ["--model", "m", "--concurrency", "8"]
        kept: set[str] = set()
        killed = 0
        for _ in range(kills):
            goal = len(server.keys) + generator.randint(1, max(2, total // kills - 10))
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while len(server.keys) < goal and process.poll() is None:
                time.sleep(0.002)
            time.sleep(generator.uniform(0, 0.05))
            if process.poll() is None:
                process.send_signal(signal.SIGKILL)
                killed += 1
            process.wait()
            now = recorded(out)
            assert kept <= now
            kept = now
        assert killed == kills
        assert subprocess.run(command, check=False, capture_output=True).returncode == 0
        twice = {key for key, n in server.attempts.items() if n > 1}
        assert len(server.attempts) == total
        assert len(recorded(out)) == total
    experiment = read_experiment(str(path))
    with Journal(out / "journal.sqlite", experiment.digest, experiment.trials, create=False) as journal:
        (model,) = journal.models()
        lost = [f"{entry['request'][:32]}-{entry['trial']}" for entry in journal.unknown_fate()]
        (table,) = tables(experiment, journal, model)
        truth: Counter[tuple[object, str]] = Counter()
        for draw, _ in readings(experiment, journal, model):
            chosen = experiment.options[pick(f"{draw.request[:32]}-{draw.occurrence}")]
            truth[(draw.context, draw.shown_slots), chosen] += 1
        written_down = Counter(f"{r[:32]}-{t}" for r, t in journal._db.execute("SELECT request, trial FROM attempts"))
    assert twice <= set(lost)
    assert all(server.attempts[key] <= written_down[key] for key in server.attempts)  # each request was written down before it was sent
    assert len(lost) <= 8 * kills
    assert sum(server.attempts.values()) <= total + len(lost)
    assert {(cell, u): int(n) for cell, row in table.rows.items() for u, n in row.items()} == truth
    requests = sum(server.attempts.values())
    print(f"{killed} kills of a run of {total} calls: {requests} requests, {len(twice)} asked twice, {len(lost)} listed as in flight")


def recorded(folder: Path) -> set[str]:
    path = folder / "journal.sqlite"
    if not path.is_file():
        return set()
    database = sqlite3.connect(path)
    try:
        return {f"{r[:32]}-{t}" for r, t in database.execute("SELECT request, trial FROM answers")}
    except sqlite3.OperationalError:  # killed before the tables were made
        return set()
    finally:
        database.close()


def test_the_envelope_is_read_strictly() -> None:
    """What is no chat completion is a fault, whatever it is."""
    from fairaudit.plugins.vlm.answers import read_answer

    experiment = read_experiment("document-delivery")

    def kind(body: bytes, status: int = 200, content_type: str = "application/json") -> str:
        return read_answer(experiment, status, content_type, body).kind

    assert kind(completion('{"HR1": 1, "HR2": 0}')) == "choice"
    assert kind(completion('```json\n{"HR1": "1.0", "HR2": "0"}\n```')) == "choice"
    for content in ("", "{}", "[]", '{"HR1": "1.0"}', '{"HR1": "yes", "HR2": "no"}', '{"HR1": NaN, "HR2": 0}', "[" * 50_000):
        assert kind(completion(content)) == "malformed"
    for content in ('{"HR1": "0.0", "HR2": "0.0"}', '{"HR1": "0.7", "HR2": "0.3"}', '{"HR1": "1.0", "HR2": "0.5"}'):
        assert kind(completion(content)) == "contradictory"
    for body in (
        b"",
        b"null",
        b"[]",
        b'{"choices": []}',
        b'{"choices": [{}]}',
        b"\xff\xfe",
        b'{"choices": 1}',
        b'{"choices": [{"message": null}]}',
    ):
        assert kind(body) == "fault"
    assert kind(completion("x", finish_reason="content_filter")) == "refused"
