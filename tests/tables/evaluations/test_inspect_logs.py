"""Logs of Inspect, as the library itself wrote them with its mock model; its own reader is the oracle."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from collections import Counter
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from inspect_runs import EPOCHS, FAILING, KILLED_AFTER, QUESTIONS, answer_of
from made_by_inspect import logs_of, with_zstd

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.tables.evaluations import inspect_logs
from fairaudit.tables.evaluations.detection import detect
from fairaudit.tables.evaluations.samples import Run, Sample

TESTS = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return logs_of("inspect_runs.py", tmp_path_factory.mktemp("runs"))


def read(path: Path, *wanted: str) -> tuple[Run, list[Sample]]:
    found = detect(str(path))
    assert found is inspect_logs.INSPECT
    return found.run(str(path)), list(found.samples(str(path), wanted))


def by_key(samples: list[Sample]) -> dict[tuple[object, object], Sample]:
    found = {(sample.row["id"], sample.row["epoch"]): sample for sample in samples}
    assert len(found) == len(samples)
    return found


@pytest.mark.parametrize("name", ["loans.eval", "loans.json", "in-parts/loans.eval", "failed.eval", "killed.eval", "limited.eval"])
def test_the_library_reads_the_same(runs: Path, name: str) -> None:
    run, samples = read(runs / name)
    oracle = json.loads((runs / name).with_suffix(".oracle").read_text() if "/" not in name else (runs / "loans.oracle").read_text())
    assert run.status == oracle["status"]
    found = by_key(samples)
    assert len(found) == len(oracle["samples"])
    for expected in oracle["samples"]:
        sample = found[expected["id"], expected["epoch"]]
        row = sample.row
        assert {name: [score.get("answer"), score["value"]] for name, score in row.get("scores", {}).items()} == expected["answers"]
        assert row["metadata"] == {**expected["metadata"], "rate": Decimal("0.1")}
        outcomes = {"content_filter": "refused", "max_tokens": "truncated", "stop": "read", None: "error"}
        assert sample.outcome == ("error" if expected["error"] else outcomes[expected["stop"]])


@pytest.mark.deep
@pytest.mark.parametrize("name", ["loans.eval", "loans.json"])
def test_shuffled_choices_mean_what_they_meant(runs: Path, name: str) -> None:
    """The model sees the choices in another order each time and names a letter; in the log each letter is the choice of the data set."""
    run, samples = read(runs / name)
    assert (run.expected, run.epochs, run.model, run.task) == (QUESTIONS * EPOCHS, EPOCHS, "mockllm/model", "loans")
    assert run.producer.startswith("inspect_ai 0.")
    assert run.fixed == ""
    known = {"grant": ("A", "read"), "refuse": ("B", "read"), "decline": ("", "refused"), "cut": ("", "truncated"), "prose": ("", "read")}
    for sample in samples:
        row = sample.row
        kind = answer_of(int(str(row["id"]).removeprefix("q")), row["epoch"])
        assert row["eval"]["model"] == "mockllm/model"
        if kind == "fail":
            assert sample.outcome == "error"
            assert "choice" not in row.get("scores", {})
        else:
            assert (row["scores"]["choice"]["answer"], sample.outcome) == known[kind]


@pytest.mark.deep
def test_the_accuracy_of_the_library_is_no_share_of_answers(runs: Path) -> None:
    """It averages the epochs of a question first, so that an answer counts twice where the other one never came."""
    _, samples = read(runs / "loans.eval")
    right: dict[object, list[bool]] = {}
    for sample in samples:
        if sample.outcome != "error":
            right.setdefault(sample.row["id"], []).append(sample.row["scores"]["choice"]["value"] == "C")
    assert [len(answers) for name, answers in right.items() if name == FAILING] == [1]
    share = Fraction(sum(map(sum, right.values())), sum(map(len, right.values())))
    averaged = sum((Fraction(sum(answers), len(answers)) for answers in right.values()), Fraction(0)) / len(right)
    accuracy = json.loads((runs / "loans.oracle").read_text())["accuracy"]
    assert accuracy == pytest.approx(float(averaged), abs=1e-12)
    assert share != averaged


@pytest.mark.deep
@pytest.mark.parametrize("name", ["loans.eval", "loans.json", "in-parts/loans.eval"])
def test_a_table_has_the_counts_of_an_independent_count(runs: Path, name: str) -> None:
    oracle = json.loads((runs / "loans.oracle").read_text())
    words = {"content_filter": "refused", "max_tokens": "truncated"}
    expected = Counter(
        (words.get(each["stop"]) or each["answers"]["choice"][0] or "unreadable", each["metadata"]["race"])
        for each in oracle["samples"]
        if not each["error"]
    )
    columns = ["scores.choice.answer", "metadata.race"]
    tally = fa.read_log(runs / name, [*columns, "id"], decision=columns[0], unit="id", errors="drop")
    found: Counter[tuple[str, str]] = Counter()
    for *labels, count in zip(*(tally[column] for column in columns), tally.counts, strict=True):
        found[labels[0], labels[1]] += int(count)
    assert found - Counter({("error", "black"): 1}) == expected
    assert tally.evaluation is not None
    assert (tally.evaluation.expected, tally.evaluation.read) == (48, 48)


@pytest.mark.deep
def test_a_run_that_says_success_may_have_answered_nothing(runs: Path) -> None:
    run, samples = read(runs / "failed.eval")
    assert run.status == "success"
    assert Counter(sample.outcome for sample in samples) == {"error": QUESTIONS * EPOCHS}


@pytest.mark.deep
def test_a_run_that_was_killed_holds_what_it_had(runs: Path) -> None:
    run, samples = read(runs / "killed.eval")
    assert (run.status, run.expected) == ("started", QUESTIONS * EPOCHS)
    assert len(samples) == KILLED_AFTER


def test_a_log_that_was_cut_off_is_no_archive(runs: Path, tmp_path: Path) -> None:
    path = tmp_path / "cut.eval"
    for name in ("loans.eval", "killed.eval"):
        whole = (runs / name).read_bytes()
        for length in (100, len(whole) // 2, len(whole) - 1):
            path.write_bytes(whole[:length])
            refused(path, r"the archive cannot be read: it was cut or damaged")
            with pytest.raises(InputError, match=r"cut\.eval: the archive cannot be read: it was cut or damaged"):
                fa.read_log(path, ["scores.choice.answer"])


@pytest.mark.deep
def test_a_limited_run_expects_no_more_than_it_asked(runs: Path) -> None:
    run, samples = read(runs / "limited.eval")
    assert (run.expected, run.epochs, len(samples)) == (5, 1, 5)
    assert run.fixed == "seed 7"


def test_only_what_is_wanted_is_kept(runs: Path) -> None:
    for name in ("loans.eval", "loans.json", "in-parts/loans.eval"):
        for sample in read(runs / name, "metadata")[1]:
            assert set(sample.row) <= {"id", "epoch", "error", "invalidation", "output", "limit", "metadata", "eval"}
            assert sample.row["metadata"]["race"] in ("black", "white")
        assert all("events" in sample.row for sample in read(runs / "loans.eval", "events")[1])


HEADER = {
    "version": 2,
    "status": "success",
    "eval": {"model": "m", "task": "t", "dataset": {"samples": 9, "sample_ids": [1]}, "config": {"epochs": 1}},
    "plan": {"config": {"temperature": 0}},
}

SAMPLE = {
    "id": 1,
    "epoch": 1,
    "output": {"choices": [{"stop_reason": "stop"}]},
    "scores": {"s": {"answer": "attachment://t1", "value": "C"}},
    "metadata": {"race": "x"},
    "events": [{"n": n} for n in range(9)],
    "attachments": {"t1": "yes", "t2": "no"},
}


def archive(path: Path, members: dict[str, object], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with with_zstd.ZipFile(path, "w", method) as made:
        for name, value in members.items():
            made.writestr(name, value if isinstance(value, (str, bytes)) else json.dumps(value))
    return path


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, 93])
def test_old_and_new_methods_of_compression_are_read(tmp_path: Path, method: int) -> None:
    path = archive(tmp_path / "a.eval", {"header.json": HEADER, "samples/1_epoch_1.json": SAMPLE}, method)
    run, (sample,) = read(path)
    assert (run.expected, run.fixed, run.producer) == (1, "temperature 0", "inspect_ai")
    assert sample.row["scores"]["s"]["answer"] == "yes"
    assert "events" not in sample.row
    assert sample.where == "sample 1, epoch 1"


@pytest.mark.parametrize(
    ("change", "outcome"),
    [
        ({}, "read"),
        ({"error": {"message": "no"}}, "error"),
        ({"invalidation": {"author": "me"}}, "error"),
        ({"limit": {"type": "token", "limit": 5}}, "truncated"),
        ({"output": {"choices": [{"stop_reason": "model_length"}]}}, "truncated"),
        ({"output": {"choices": [{"stop_reason": "length"}]}}, "truncated"),
        ({"output": {"choices": [{"stop_reason": "content_filter"}]}, "error": {}}, "error"),
        ({"output": {"choices": [{"stop_reason": "content_filter"}]}, "limit": {}}, "refused"),
        ({"output": {"choices": [], "stop_reason": None}}, "read"),
        ({"output": None}, "read"),
    ],
)
def test_what_became_of_a_sample(tmp_path: Path, change: dict[str, object], outcome: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({**HEADER, "samples": [{**SAMPLE, **change}]}))
    assert [sample.outcome for sample in read(path)[1]] == [outcome]


@pytest.mark.parametrize(
    ("model", "run", "steps", "words"),
    [
        ({"seed": 4}, {}, [], "seed 4"),
        ({"temperature": 0.0}, {"temperature": 1.0}, [], ""),
        ({"temperature": 1.0}, {"temperature": 0.0}, [], "temperature 0"),
        ({}, {}, [{"solver": "generate", "params": {"tool_calls": "loop", "temperature": 0.0, "seed": 9}}], "temperature 0"),
        ({"seed": 4}, {}, [{"solver": "generate", "params": {"seed": None}}, 5], ""),
        ({}, {}, [{"solver": "shuffle", "params": {"seed": 9}}], ""),
    ],
)
def test_settings_nearest_to_the_answer_count(
    tmp_path: Path, model: dict[str, Any], run: dict[str, Any], steps: list[Any], words: str
) -> None:
    path = tmp_path / "a.json"
    header = {"version": 2, "status": "success", "eval": {"model_generate_config": model}, "plan": {"config": run, "steps": steps}}
    path.write_text(json.dumps({**header, "samples": []}))
    assert read(path)[0].fixed == words


def test_names_of_members_are_data(tmp_path: Path) -> None:
    names = ["samples/../../etc/x_epoch_1.json", "samples/a/b_epoch_1.json", "samples/\x1b[31m_epoch_1.json", "notes.txt", "samples/x.txt"]
    members = {name: {**SAMPLE, "id": name} for name in names}
    found = read(archive(tmp_path / "a.eval", {"header.json": HEADER, **members}))[1]
    assert [sample.row["id"] for sample in found] == names[:3]
    assert "\x1b" not in found[2].where
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.eval"]


def refused(path: Path, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        read(path)
    message = str(caught.value)
    assert path.name in message
    assert "\n" not in message


def test_what_is_no_log_is_refused_in_a_sentence(tmp_path: Path) -> None:
    good = {"header.json": HEADER, "samples/1_epoch_1.json": SAMPLE}
    for number, (change, words) in enumerate(
        [
            ({"header.json": {"version": 2}}, 'no "eval" in the header'),
            ({"header.json": "{"}, "header.json.*cut"),
            ({"samples/1_epoch_1.json": "[1]"}, "1_epoch_1.json.*{ was expected"),
            ({"samples/1_epoch_1.json": json.dumps(SAMPLE)[:-9]}, "1_epoch_1.json.*cut"),
            ({"samples/1_epoch_1.json": json.dumps(SAMPLE) + "{}"}, "1_epoch_1.json.*the end of the file was expected"),
            ({"samples/1_epoch_1.json": {"epoch": 1}}, "has no id or no epoch"),
            ({"samples/1_epoch_1.json": b'{"id": "\xff"}'}, "not UTF-8"),
            ({"samples/1_epoch_1.json": '{"id": ' + "[" * 100_000}, "nested too deeply"),
            ({"samples/1_epoch_1.json": '{"id": ' + "1" * 5000 + "}"}, "no JSON"),
        ]
    ):
        refused(archive(tmp_path / f"{number}.eval", {**good, **change}), words)


def test_a_damaged_archive_is_refused_in_a_sentence(tmp_path: Path) -> None:
    whole = archive(tmp_path / "a.eval", {"header.json": HEADER, "samples/1_epoch_1.json": SAMPLE}, 93).read_bytes()
    encrypted, other, spoilt, deflated = (tmp_path / f"{name}.eval" for name in ("encrypted", "other", "spoilt", "deflated"))
    member = whole.index(b"samples/1_epoch_1.json")
    central = whole.rindex(b"samples/1_epoch_1.json") - 46
    assert whole[central : central + 4] == b"PK\x01\x02"
    encrypted.write_bytes(whole[: central + 8] + b"\x01" + whole[central + 9 :])
    refused(encrypted, "the member is encrypted")
    other.write_bytes(whole[: central + 10] + b"\x62" + whole[central + 11 :])
    refused(other, "compressed by method 98")
    spoilt.write_bytes(whole[: member + 40] + b"\xff\xff\xff\xff" + whole[member + 44 :])
    refused(spoilt, "cut or damaged")
    data = archive(deflated, {"header.json": HEADER, "samples/1_epoch_1.json": SAMPLE}).read_bytes()
    deflated.write_bytes(data[: member + 40] + b"\xff\xff\xff\xff" + data[member + 44 :])


@pytest.mark.parametrize("step", [7])
def test_no_cut_or_change_of_bytes_ends_in_a_traceback(tmp_path: Path, step: int) -> None:
    path = tmp_path / "a.eval"
    for method in (zipfile.ZIP_DEFLATED, 93):
        whole = archive(path, {"header.json": HEADER, "samples/1_epoch_1.json": SAMPLE}, method).read_bytes()
        for at in range(4, len(whole), step):
            for damaged in (whole[:at], whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :]):
                path.write_bytes(damaged)
                try:
                    if detect(str(path)) is not None:
                        inspect_logs.INSPECT.run(str(path))
                    list(inspect_logs.INSPECT.samples(str(path), ()))
                except InputError as error:
                    assert "a.eval" in str(error)


def test_a_bomb_is_refused_before_it_fills_the_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fairaudit.tables.evaluations.json_text.LARGEST", 2**21)
    bomb = '{"id": "' + " " * 2**24 + '"}'
    refused(archive(tmp_path / "a.eval", {"header.json": HEADER, "samples/1_epoch_1.json": bomb}, 93), "more than 2,097,152 characters")


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="the standard library reads zstd from Python 3.14 on")
def test_without_zstd_it_is_said_what_to_install(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.eval", {"header.json": HEADER, "samples/1_epoch_1.json": SAMPLE}, 93)
    lines = "import sys; sys.modules['backports.zstd'] = None; from fairaudit.tables.evaluations.detection import detect; "
    made = subprocess.run([sys.executable, "-c", f"{lines} p = sys.argv[1]; detect(p).run(p)", path], capture_output=True, text=True)
    assert made.stderr.splitlines()[-1] == (
        f"fairaudit.errors.InputError: {path} needs zstd: pip install 'fairaudit-certify[evals]', "
        "or write the log anew by: inspect log convert --to json --output-dir DIR"
    )
