"""Where logs of models mislead whoever counts their lines, from the files to the table."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.tables.evaluations.detection import FORMATS, detect

LOGS = Path(__file__).with_name("logs")
CHOICE = next((LOGS / "lm-eval").glob("samples_loan_choice_*.jsonl"))
TEXT = next((LOGS / "lm-eval").glob("samples_loan_text_*.jsonl"))


def counted(source: Path, *columns: str, **asked: Any) -> Counter[tuple[object, ...]]:
    read = dict.fromkeys((*columns, *([asked["unit"]] if "unit" in asked else [])))
    tally = fa.read_log(source, list(read), decision=columns[0], **asked)
    rows = zip(*(tally[name] for name in columns), tally.counts, strict=True)
    found: Counter[tuple[object, ...]] = Counter()
    for *labels, count in rows:
        found[tuple(labels)] += int(count)
    return found


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_likelihoods_are_texts_and_the_greatest_is_the_choice() -> None:
    expected: Counter[tuple[object, ...]] = Counter()
    for row in lines(CHOICE):
        first, second = (float(value) for value, _ in row["filtered_resps"])
        expected[int(second > first), row["doc"]["region"]] += 1
    assert counted(CHOICE, "argmax(filtered_resps[*][0])", "doc.region") == expected


def test_rows_of_several_filters_are_not_added_up() -> None:
    with pytest.raises(InputError, match=r"repeated for each filter.*'strict', 'first'.*--where filter="):
        counted(TEXT, "filtered_resps[0]", "doc.region")
    found = counted(TEXT, "filtered_resps[0]", "doc.region", where={"filter": "strict"})
    assert found == Counter((row["filtered_resps"][0], row["doc"]["region"]) for row in lines(TEXT) if row["filter"] == "strict")


def test_repetitions_inside_a_row_are_draws_of_a_unit() -> None:
    asked = {"where": {"filter": "first"}}
    with pytest.raises(InputError, match="name with --unit"):
        counted(TEXT, "resps[0][*]", "doc.region", **asked)
    found = counted(TEXT, "resps[0][*]", "doc.region", unit="doc_id", **asked)
    assert sum(found.values()) == 24
    assert found == Counter((said, row["doc"]["region"]) for row in lines(TEXT) if row["filter"] == "first" for said in row["resps"][0])


def test_a_shortened_log_is_refused_or_said_to_be() -> None:
    path = next((LOGS / "lm-eval" / "published").glob("samples_*.jsonl"))
    with pytest.raises(InputError, match="holds 10 of 5000 samples"):
        counted(path, "exact_match", "doc.level")
    tally = fa.read_log(path, ["exact_match", "doc.level"], missing_samples="accept")
    assert tally.evaluation is not None
    assert tally.evaluation.missing == 4990


def test_a_metric_more_is_no_sample_more() -> None:
    path = LOGS / "eee" / "mmlu_samples.jsonl"
    with pytest.raises(InputError, match="repeated for each evaluation_result_id"):
        counted(path, "answer", "model_id")
    found = counted(path, "answer", "model_id", where={"evaluation_result_id": "exact_match:test"})
    assert sum(found.values()) == len({row["sample_id"] for row in lines(path) if row["evaluation_result_id"] == "exact_match:test"})


def test_a_copy_with_other_words_is_another_question() -> None:
    columns = ("answer", "train_trial_index")
    with pytest.raises(InputError, match=r"repeated for each perturbation.*'none', 'lowercase'"):
        counted(LOGS / "helm" / "simple_mcqa", *columns, unit="instance.id")
    assert counted(LOGS / "helm" / "simple_mcqa", *columns, unit="instance.id", where={"perturbation": "none"}) == Counter(
        {("unreadable", 0): 4, ("unreadable", 1): 4}
    )


def test_scores_are_a_column_of_utilities() -> None:
    found = counted(LOGS / "helm" / "published", "answer", "instance.split", "stats.exact_match")
    requests = json.loads((LOGS / "helm" / "published" / "scenario_state.json").read_text())["request_states"]
    assert sum(count for labels, count in found.items() if labels[2] == 1) == sum(
        any(
            reference["output"]["text"] == each["output_mapping"][each["result"]["completions"][0]["text"].strip()]
            for reference in each["instance"]["references"]
            if "correct" in reference["tags"]
        )
        for each in requests
    )


def test_two_providers_of_one_label_are_two(tmp_path: Path) -> None:
    columns = ("response.output", "metadata.race", "metadata.person", "provider.label")
    asked = {"unit": "metadata.person", "errors": "drop"}
    path = tmp_path / "same-label.json"
    written = (LOGS / "promptfoo" / "loans.json").read_text()
    path.write_text(written.replace('"label": "first"', '"label": "clerk"').replace('"label": "second"', '"label": "clerk"'))
    with pytest.raises(InputError, match=r"result 2: metadata.person 'p0' has the same labels in promptIdx 0 and 1.*--where promptIdx=0"):
        counted(path, *columns, **asked)
    for name in ("loans.json", "loans.jsonl"):
        assert sum(counted(LOGS / "promptfoo" / name, *columns, **asked).values()) == 24
        with pytest.raises(InputError, match="in promptIdx 0 and 1"):
            counted(LOGS / "promptfoo" / name, *columns[:3], **asked)
    assert sum(counted(path, *columns, **asked, where={"promptIdx": "1"}).values()) == 12
    results = json.loads(path.read_text())["results"]["results"]
    words = {2: "error", 1: None, 0: None}
    expected = Counter(
        (
            words[each["failureReason"]]
            or (
                "refused"
                if each["response"].get("isRefusal")
                else "truncated"
                if each["response"].get("finishReason") == "length"
                else None
            )
            or each["response"]["output"],
            each["metadata"]["race"],
            each["metadata"]["person"],
            each["promptIdx"],
        )
        for each in results
    )
    assert counted(path, *columns[:3], "promptIdx", **asked) == expected


def test_a_column_may_have_a_name_that_no_path_has(tmp_path: Path) -> None:
    path, name = tmp_path / "rows.jsonl", "height (6'2\")"
    path.write_text(json.dumps({"said": "yes", name: "tall"}))
    assert counted(path, "said", name) == Counter({("yes", "tall"): 1})
    with pytest.raises(InputError, match=r"rows.jsonl: the path .* cannot be read from .* on"):
        counted(path, "said", "width (6'2\")")


@pytest.mark.parametrize(
    "command", [["worst-case", "--group", "metadata.race"], ["subgroups", "--attributes", "metadata.race", "--utility", "yes"]]
)
def test_commands_that_could_not_say_what_was_lost_refuse_logs(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Before they are read: samples with errors are no reason to advise an option that the command has not."""
    name, *options = command
    assert main([name, str(LOGS / "promptfoo" / "loans.json"), "--decision", "response.output", *options]) == 2
    said = capsys.readouterr().err
    assert "loans.json: an evaluation log is audited by certify" in said
    assert "--errors" not in said


def test_an_index_of_a_test_is_no_question() -> None:
    with pytest.raises(InputError, match="promptfoo does not tell a repeated question from another one; name with --unit"):
        counted(LOGS / "promptfoo" / "loans.json", "response.output", "metadata.race", errors="drop")


def test_answers_of_a_real_model_are_joined_to_what_it_was_asked() -> None:
    path, regions = LOGS / "openai" / "output.jsonl", {}
    for line in (LOGS / "openai" / "prompts.csv").read_text().splitlines()[1:]:
        name, regions[name] = line.split(",")
    expected: Counter[tuple[object, ...]] = Counter()
    for row in lines(path):
        choice = (((row["response"] or {}).get("body") or {}).get("choices") or [None])[0]
        said = "error" if choice is None else choice["message"]["content"]
        cut = choice is not None and choice["finish_reason"] == "length" and said not in ("Yes", "No")
        expected["truncated" if cut else said if said in ("error", "Yes", "No") else "unreadable", regions[row["custom_id"]]] += 1
    join = f"{LOGS / 'openai' / 'prompts.csv'}:custom_id"
    decision = "response.body.choices[0].message.content"
    assert counted(path, decision, "region", join=join, extract="(Yes|No)", errors="drop") == expected
    assert {labels[0] for labels in expected} == {"Yes", "No", "unreadable", "truncated", "error"}


@pytest.mark.parametrize("extract", [r"^(yes|no)\b.*", r"(?s)(yes|no).*", "(yes|no)"])
def test_an_answer_that_was_cut_is_none_however_much_an_expression_passes_over(tmp_path: Path, extract: str) -> None:
    decision = "response.body.choices[0].message.content"
    said = [("yes, unless the applicant has defaulted, in which ca", "length"), ("yes, always", "stop"), ("no\n", "length")]
    bodies = [{"choices": [{"message": {"content": content}, "finish_reason": finish}]} for content, finish in said]
    rows = [{"custom_id": str(n), "response": {"status_code": 200, "body": body}, "error": None} for n, body in enumerate(bodies)]
    path = tmp_path / "output.jsonl"
    path.write_text("\n".join(map(json.dumps, rows)))
    assert counted(path, decision, extract=extract) == Counter({("truncated",): 1, ("yes",): 1, ("no",): 1})


@pytest.mark.parametrize(
    ("content", "finish", "found"),
    [("1", "length", "1"), (" 1\n", "length", "1"), ("1 is", "length", "truncated"), ("1 is", "stop", "1"), ("", "length", "truncated")],
)
def test_an_answer_that_is_nothing_but_a_decision_was_not_cut(tmp_path: Path, content: str, finish: str, found: str) -> None:
    """A model that is asked for one token is always cut off after it."""
    path = tmp_path / "output.jsonl"
    body = {"choices": [{"message": {"content": content, "refusal": None}, "finish_reason": finish}], "model": "m"}
    path.write_text(json.dumps({"custom_id": "a", "response": {"status_code": 200, "body": body}, "error": None}))
    decision = "response.body.choices[0].message.content"
    assert counted(path, decision, "response.body.model", extract="(1|2)") == Counter({(found, "m"): 1})
    words = {"stop": content.strip() or "unreadable", "length": "truncated"}
    assert counted(path, decision, "response.body.model") == Counter({(words[finish], "m"): 1})


DAMAGED = [
    CHOICE,
    LOGS / "eee" / "arc_easy_samples.jsonl",
    LOGS / "helm" / "simple_mcqa" / "scenario_state.json",
    LOGS / "promptfoo" / "loans.jsonl",
    LOGS / "promptfoo" / "loans.json",
    LOGS / "openai" / "output.jsonl",
    LOGS / "openai-evals" / "loans.jsonl",
    LOGS / "inspect" / "data_arc_qwen.json",
]


@pytest.mark.parametrize("source", DAMAGED, ids=lambda path: path.parent.name)
def test_damage_is_a_sentence_with_the_name_of_the_file(tmp_path: Path, source: Path) -> None:
    """Cut anywhere, or with a byte or a value exchanged: a log is read, or refused in a sentence, and never ends in a traceback."""
    whole, path = source.read_bytes(), tmp_path / source.name
    known = detect(str(source))
    assert known is not None
    values = [b"null", b"[]", b"{}", b'"x"', b"-1", b"1e999", b"NaN"]
    for step in range(24):
        at = step * len(whole) // 24
        end = whole.find(b",", at)
        for damaged in (whole[:at], whole[:at] + b"\xff" + whole[at + 1 :], whole[: at + 1] + values[step % 7] + whole[end:]):
            path.write_bytes(damaged)
            try:
                found = detect(str(path)) or known
                found.run(str(path))
                list(found.samples(str(path), ()))
            except InputError as error:
                assert source.name in str(error)
                assert "\n" not in str(error)


@pytest.mark.parametrize(
    "name",
    [
        "version",
        "eval",
        "samples",
        "dataset",
        "config",
        "packages",
        "model",
        "output",
        "choices",
        "error",
        "results",
        "resps",
        "filtered_resps",
        "arguments",
        "metadata",
        "answer_attribution",
        "instance",
        "result",
        "completions",
        "references",
        "adapter_spec",
        "response",
        "provider",
        "vars",
        "testCase",
        "prompts",
        "stats",
        "data",
        "sample_id",
        "spec",
        "perturbation",
        "output_mapping",
        "plan",
    ],
)
def test_values_of_another_kind_are_no_traceback(tmp_path: Path, name: str) -> None:
    def changed(value: Any, to: Any) -> Any:
        if isinstance(value, dict):
            return {key: to if key == name else changed(held, to) for key, held in value.items()}
        return [changed(held, to) for held in value] if isinstance(value, list) else value

    for source in DAMAGED:
        if f'"{name}"' not in (text := source.read_text()):
            continue
        path = tmp_path / source.name
        known = detect(str(source))
        assert known is not None
        for to in (None, 5, "x", [], {}, [5], [[]], {"x": None}, True):
            values = [json.loads(line) for line in text.splitlines()[:4]] if source.suffix == ".jsonl" else [json.loads(text)]
            path.write_text("\n".join(json.dumps(changed(value, to)) for value in values))
            for found in {known, detect(str(path)) or known}:
                try:
                    found.run(str(path))
                    list(found.samples(str(path), ()))
                except InputError as error:
                    assert source.name in str(error)


def test_each_format_has_a_log_here() -> None:
    found = {detect(str(path)) for path in LOGS.rglob("*") if not path.name.startswith("results_")}
    assert {known.name for known in found if known is not None} == {*FORMATS}
