"""What is said to have been drawn follows from the questions that were counted, not from names or from what a log says of itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.tables.evaluations.repetition import Questions

ASKED: dict[str, Any] = {"decision": "scores.choice.answer", "group": "metadata.race", "utility": "A", "confidence": 0.9}
QUESTIONS = "questions were drawn; epochs of a question count once"
ANSWERS = "the questions are fixed; the model's answers were drawn"


def inspect_log(path: Path, *, epochs: int = 1, said: int | None = None, temperature: float = 1, model: str = "m", task: str = "t") -> str:
    """A log of 40 questions, each asked in some epochs; what it says of its epochs need not be so."""
    samples = [
        {
            "id": number,
            "epoch": epoch,
            "uuid": f"{number}-{epoch}-{model}",
            "metadata": {"race": "bw"[number % 2], "topic": "xy"[number // 2 % 2]},
            "scores": {"choice": {"answer": "AB"[number // 4 % 2]}},
        }
        for number in range(40)
        for epoch in range(1, epochs + 1)
    ]
    about = {"model": model, "task": task, "config": {"epochs": epochs if said is None else said}, "dataset": {"samples": 40}}
    about |= {"model_generate_config": {"temperature": temperature}}
    path.write_text(json.dumps({"version": 2, "status": "success", "eval": about, "plan": {}, "samples": samples}))
    return str(path)


def of_log(*paths: str, **asked: Any) -> Any:
    return json.loads(fa.audit([*paths] if len(paths) > 1 else paths[0], **{**ASKED, **asked}).certificate.text)


def drawn(*paths: str, **asked: Any) -> str:
    return str(of_log(*paths, **asked)["subject"]["evaluation"]["drawn"])


@pytest.mark.parametrize("unit", [["id", "epoch"], ["id", "uuid"], ["uuid"], ["id", '"epoch"'], ['"id"', "epoch"], ['"id"', '"epoch"']])
def test_units_that_part_epochs_are_answers_to_fixed_questions(tmp_path: Path, unit: list[str]) -> None:
    assert drawn(inspect_log(tmp_path / "a.json", epochs=3), unit=unit) == ANSWERS
    with pytest.raises(InputError, match="says temperature 0: the questions are fixed"):
        of_log(inspect_log(tmp_path / "b.json", epochs=3, temperature=0), unit=unit)


@pytest.mark.parametrize("unit", ["id", '"id"'])
def test_epochs_of_a_question_count_once_however_its_path_is_written(tmp_path: Path, unit: str) -> None:
    assert drawn(inspect_log(tmp_path / "a.json", epochs=3, temperature=0), unit=unit) == QUESTIONS


@pytest.mark.parametrize("unit", [["id", "file"], ["id", "eval.model"], ["id", "uuid"], ["id", "epoch", "file"]])
def test_another_file_or_model_makes_no_other_question(tmp_path: Path, unit: list[str]) -> None:
    paths = inspect_log(tmp_path / "a.json"), inspect_log(tmp_path / "b.json", model="n")
    with pytest.raises(InputError, match=r"takes one question for several: id '0' is in more than one unit.*--unit id counts"):
        of_log(*paths, unit=unit)
    assert drawn(*paths, unit="id") == QUESTIONS


def test_a_file_of_another_task_has_other_questions(tmp_path: Path) -> None:
    paths = inspect_log(tmp_path / "a.json"), inspect_log(tmp_path / "b.json", task="u")
    with pytest.raises(InputError, match="the logs are of several tasks"):
        of_log(*paths, unit="id")
    assert [drawn(*paths, unit=["id", apart]) for apart in ("file", "eval.task", 'eval."task"')] == [QUESTIONS] * 3


@pytest.mark.parametrize(
    "asked", [{}, {"context": "file"}, {"context": "eval.model"}, {"group": "file"}, {"context": "id"}, {"group": "id"}]
)
def test_one_question_in_several_files_needs_a_unit(tmp_path: Path, asked: dict[str, str]) -> None:
    for model in ("m", "n"):
        paths = inspect_log(tmp_path / "a.json"), inspect_log(tmp_path / "b.json", model=model)
        with pytest.raises(InputError, match=r"is there several times|several models were asked the same|is there twice"):
            of_log(*paths, **asked)


def test_copies_of_a_log_are_no_further_questions(tmp_path: Path) -> None:
    paths = [inspect_log(tmp_path / f"{name}.json") for name in "abcdef"]
    alone = of_log(paths[0], unit="id")["intervals"]["local"]["ratio"]
    found = of_log(*paths, context="file", unit="id")["intervals"]
    assert found["local"]["ratio"][1] == "inf" or [*map(float_of, found["local"]["ratio"])] >= [*map(float_of, alone)]
    assert {*found} == {"local"}


def float_of(text: str) -> float:
    above, _, below = text.partition("/")
    return float(above) / float(below or 1)


@pytest.mark.parametrize("said", [0, 1, 2])
def test_epochs_are_counted_and_not_believed(tmp_path: Path, said: int) -> None:
    path = inspect_log(tmp_path / "a.json", epochs=4, said=said)
    with pytest.raises(InputError, match="each question was asked 4 times"):
        of_log(path, missing_samples="accept")
    assert of_log(path, unit="id")["subject"]["evaluation"]["epochs"] == 4


def shared_log(path: Path, models: str = "m", epochs: str = "") -> str:
    """Samples in the form of Every Eval Ever; epochs, where there are any, are numbers in the metadata."""
    rows = [
        {
            "schema_version": "0.2.2",
            "interaction_type": "single_turn",
            "evaluation_name": "t",
            "model_id": model,
            "sample_id": f"s{number}",
            "answer_attribution": [{"is_terminal": True, "extracted_value": "AB"[number // 4 % 2]}],
            "metadata": {"race": "bw"[number % 2], **({"epoch": int(epoch)} if epoch else {})},
        }
        for number in range(40)
        for model in models
        for epoch in epochs or [""]
    ]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return str(path)


def test_models_and_epochs_within_a_file_are_seen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = {"decision": "answer"}
    for name, models, epochs, unit in (("a", "m", "", False), ("b", "mn", "", True), ("c", "m", "12", True)):
        assert main(["inspect", shared_log(tmp_path / f"{name}.jsonl", models, epochs)]) == 0
        assert ("--unit sample_id" in capsys.readouterr().out) == unit
    assert drawn(shared_log(tmp_path / "one.jsonl"), **asked) == QUESTIONS
    models = shared_log(tmp_path / "models.jsonl", "mn")
    with pytest.raises(InputError, match="sample_id 's0' is there several times; --unit sample_id"):
        of_log(models, **asked)
    with pytest.raises(InputError, match="takes one question for several"):
        of_log(models, unit=["sample_id", "model_id"], **asked)
    assert drawn(models, unit="sample_id", **asked) == QUESTIONS
    epochs = shared_log(tmp_path / "epochs.jsonl", epochs="12")
    with pytest.raises(InputError, match="each question was asked 2 times"):
        of_log(epochs, **asked)
    assert drawn(epochs, unit=["sample_id", "metadata.epoch"], **asked) == ANSWERS


def test_two_runs_of_a_task_are_the_same_questions(tmp_path: Path) -> None:
    rows = [
        {"doc_id": n, "filter": "none", "doc": {"race": "bw"[n % 2]}, "resps": [["A"]], "filtered_resps": ["AB"[n // 4 % 2]]}
        for n in range(40)
    ]
    paths = [tmp_path / f"samples_t_2026-01-0{day}T00-00-00.0.jsonl" for day in (1, 2)]
    for path in paths:
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    asked = {"decision": "filtered_resps[0]", "group": "doc.race"}
    assert drawn(str(paths[0]), **asked) == QUESTIONS
    with pytest.raises(InputError, match="takes one question for several: doc_id '0' is in more than one unit because"):
        of_log(*map(str, paths), unit=["doc_id", "file"], **asked)
    with pytest.raises(InputError, match="doc_id '0' is there several times"):
        of_log(*map(str, paths), context="file", **asked)


def test_a_unit_of_several_questions_is_a_unit(tmp_path: Path) -> None:
    path = inspect_log(tmp_path / "a.json", epochs=2)
    assert (
        drawn(path, unit=["metadata.race", "metadata.topic"], confidence=None) == "sampling units were drawn; samples of a unit count once"
    )


def test_units_are_told_apart_that_have_one_hash() -> None:
    assert hash((-1,)) == hash((-2,))
    for names, again in (((-1,), (-2,)), True), (((-1,), (-1,)), False), (((None,), ("None",)), True):
        questions = Questions()
        for unit in names:
            questions.add("task", "q", "1", unit)
        assert bool(questions.again) is again
    questions = Questions()
    questions.add("task", "q", "1", (-1,))
    questions.add("task", "q", "2", (-2,))
    assert questions.apart


def test_questions_are_of_their_task() -> None:
    questions = Questions()
    for task in "tu":
        questions.add(task, "1", None, (task, 1))
    assert (questions.again, questions.repetitions, questions.apart) == ("", 1, False)
    questions.add("t", "1", None, ("v", 1))
    assert questions.again == "1"
