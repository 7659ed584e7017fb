"""What `inspect` proposes for logs of evaluations runs as it stands, or says what is missing; so do the questions of `certify`."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from fairaudit.audits.sample_roles import roles_of_samples
from fairaudit.cli import main
from fairaudit.tables.engines.survey import Samples, Seen, Survey

LOGS = Path(__file__).parents[1] / "tables" / "evaluations" / "logs"
CHOICE = "samples_loan_choice_2026-11-23T10-03-17.214307.jsonl"
TEXT = "samples_loan_text_2026-11-23T10-04-39.117764.jsonl"
MATH = "samples_math_perturbed_full_2026-01-21T03-44-18.458309.jsonl"

COMPLETE = {
    f"lm-eval/{CHOICE}": "--decision argmax(filtered_resps[*][0]) --group doc.region --utility 0",
    f"lm-eval/{TEXT}": "--decision filtered_resps[0] --group doc.region --utility Yes --where filter=strict",
    "promptfoo/loans.json": "--decision response.output --group metadata.race --unit metadata.person --utility yes --where promptIdx=0 "
    "--errors bound",
}
COMPLETE["promptfoo/loans.jsonl"] = COMPLETE["promptfoo/loans.json"]

NOBODY = "nothing in the log says whom a question is about; name a file that does with --join FILE:{}, and its column with --group"

LACKING = {
    "openai-evals/loans.jsonl": ["sample_id"],
    "eee/arc_easy_samples.jsonl": ["sample_id"],
    "eee/mmlu_samples.jsonl": ["sample_id"],
    "inspect/data_arc_qwen.json": ["id"],
    "openai/output.jsonl": ["custom_id"],
    "helm/published": ["instance.id", "answers are texts"],
    "helm/simple_mcqa": ["instance.id"],
    f"lm-eval/published/{MATH}": ["answers are texts; --extract takes decisions out of them"],
}


def proposed(capsys: pytest.CaptureFixture[str], path: Path) -> tuple[list[str], list[str], bool]:
    """The command of `inspect`, what it says of it, and whether it lacks nothing; the screen and what programs get agree."""
    assert main(["inspect", str(path), "--format", "json"]) == 0
    result = json.loads(capsys.readouterr().out)["result"]
    assert main(["inspect", str(path)]) == 0
    screen = capsys.readouterr().out
    assert screen.splitlines()[-1].strip() == shlex.join(result["command"])
    assert ("A command to try" in screen) == result["complete"] != ("A command to complete" in screen)
    return result["command"], result["said"], result["complete"]


def test_every_log_is_looked_at() -> None:
    found = {str(path.parent.relative_to(LOGS)) for path in LOGS.rglob("*") if path.is_file() and path.name != "README.md"}
    assert found == {str(Path(name).parent) if Path(name).suffix else name for name in COMPLETE | LACKING}


@pytest.mark.parametrize("name", COMPLETE)
def test_a_command_that_lacks_nothing_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    command, _, complete = proposed(capsys, LOGS / name)
    assert complete and " ".join(command[3:]) == COMPLETE[name]
    assert main(command[1:]) in (0, 1, 3)


@pytest.mark.parametrize("name", LACKING)
def test_what_is_missing_is_said(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    command, said, complete = proposed(capsys, LOGS / name)
    assert not complete and {"COL", "DECISION"} & {*command}
    for words in LACKING[name]:
        assert any(words in text for text in said) if " " in words else NOBODY.format(words) in said


def test_a_command_that_is_completed_as_it_says_runs(capsys: pytest.CaptureFixture[str]) -> None:
    command, _, _ = proposed(capsys, LOGS / "openai" / "output.jsonl")
    command[command.index("COL")] = "region"
    assert main([*command[1:], "--join", f"{LOGS / 'openai' / 'prompts.csv'}:custom_id"]) in (0, 1, 3)
    capsys.readouterr()
    command, _, _ = proposed(capsys, LOGS / "lm-eval" / "published" / MATH)
    command[command.index("DECISION")] = "1"
    assert main([*command[1:], "--extract", "([0-9])"]) in (0, 1, 3)


def test_two_models_are_compared_where_nobody_is_named() -> None:
    columns = [Seen("id", {str(n): 2 for n in range(9)}, 9, 0), Seen("scores.x.answer", {"A": 10, "B": 8}, 2, 0)]
    models = Seen("eval.model", {"a": 9, "b": 9}, 2, 0)
    samples = Samples("inspect", "scores.x.answer", "id", 0, question="id", short=True)
    found = roles_of_samples(Survey(18, (*columns, models)), samples)
    assert (found.group, found.unit, found.utility, found.missing_samples, found.said) == (("eval.model",), "id", "A", True, ())


@pytest.mark.parametrize(
    ("columns", "unit"),
    [
        ({"vars.topic": 2, "vars.applicant": 8, "vars.text": 9}, "vars.applicant"),
        ({"vars.topic": 2, "vars.text": 9, "prompt.raw": 9}, "vars.text"),
        ({"vars.a": 3, "vars.b": 4, "prompt.raw": 12}, "prompt.raw"),
        ({"score": 2}, "PATH"),
    ],
)
def test_what_tells_questions_apart_without_an_id(columns: dict[str, int], unit: str) -> None:
    seen = [Seen(name, {f"{name} {n}": 24 // number for n in range(number)}, number, 0) for name, number in columns.items()]
    answer = Seen("response.output", {"no": 12, "yes": 12}, 2, 0)
    found = roles_of_samples(
        Survey(24, (*seen, answer, Seen("metadata.sex", {"f": 12, "m": 12}, 2, 0))), Samples("promptfoo", answer.name, "PATH", 0)
    )
    assert (found.unit, found.group, found.utility) == (unit, ("metadata.sex",), "yes")


def test_an_answer_that_is_an_object_has_its_decision_inside(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = {"promptIdx": 0, "testCase": {}, "failureReason": 0}
    rows = [
        result
        | {
            "testIdx": n,
            "vars": {"name": f"n{n // 2}", "sex": "fm"[n // 2 % 2]},
            "response": {"output": {"hire": ["yes", "no"][n % 3 % 2]}},
        }
        for n in range(16)
    ]
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, rows)))
    command, _, complete = proposed(capsys, tmp_path / "log.jsonl")
    assert complete and command[3:] == [
        *["--decision", "response.output.hire", "--group", "vars.sex", "--unit", "vars.name", "--utility", "yes"]
    ]
    assert main(command[1:]) == 0


def test_a_label_that_only_refused_answers_have_is_not_counted_and_groups_may_be_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [
        {
            "promptIdx": 0,
            "testCase": {},
            "failureReason": 0,
            "testIdx": n,
            "vars": {"name": f"n{n}", "sex": ("f", "m", "f", "m", None)[n % 5]},
            "response": {"output": ["yes", "no", "maybe"][n % 3], "isRefusal": n % 3 == 0},
        }
        for n in range(24)
    ]
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, rows)))
    command, _, complete = proposed(capsys, tmp_path / "log.jsonl")
    assert complete and command[command.index("--utility") + 1] in ("no", "maybe") and command[-2:] == ["--missing", "drop"]
    assert main(command[1:]) == 0
