"""Reading answers: no choice is invented, clear ones are read, and what a choice is not has its own name."""

from __future__ import annotations

import itertools
import json
import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from generated_answers import OPTIONS, envelope, generated
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from language_server import KEY, serving

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.vlm.answers import Reading, answer_schema, read_answer, sampling_note
from fairaudit.plugins.vlm.client import request_body
from fairaudit.plugins.vlm.experiment import Experiment, Model, bundled, read_experiment
from fairaudit.plugins.vlm.makers import answer_text


def asked(kind: str, options: tuple[str, ...] = ("HR1", "HR2")) -> Experiment:
    base = read_experiment("document-delivery")
    people = dict.fromkeys(options, base.people["Tom"])
    return replace(base, answer=kind, options=options, people=people)  # type: ignore[arg-type]


READERS = [asked(kind) for kind in ("json", "choice", "token", "logprobs")]
NAMES = (
    "HR1", "HR2", "choice", "choices", "message", "content", "type", "text", "refusal", "function", "arguments", "tool_calls", "logprobs",
    "token", "logprob", "top_logprobs",
)  # fmt: skip


def read(experiment: Experiment, content: Any, ended: str = "stop", **more: Any) -> Reading:
    return read_answer(experiment, 200, "application/json", envelope(content, ended, **more))


def test_no_choice_is_invented_and_clear_ones_are_read() -> None:
    experiments = {(kind, options): asked(kind, options) for kind in ("json", "choice", "token") for options in OPTIONS}
    clear: Counter[str] = Counter()
    found: Counter[str] = Counter()
    for entry in generated(5_000):
        reading = read_answer(experiments[entry.kind, entry.options], 200, "application/json", entry.body)
        if reading.kind == "choice":
            assert reading.decision == entry.chosen, entry
        else:
            assert reading.decision == "unreadable"
        if entry.family == "declined":
            assert reading.kind == "refused", entry
        clear[entry.family] += entry.clear
        found[entry.family] += entry.clear and reading.kind == "choice"
    print({family: f"{found[family]} of {n}" for family, n in clear.items() if n})
    assert clear.total() > 2_000
    assert found.total() >= 0.98 * clear.total()


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.sampled_from(["HR1", "text", "refusal", '{"choice": "HR2"}', "", "x"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(NAMES), inner, max_size=4),
    max_leaves=12,
)
MESSAGE = st.fixed_dictionaries({"content": JSON}, optional={"tool_calls": JSON, "refusal": JSON})
CHOICE = st.fixed_dictionaries({"message": MESSAGE}, optional={"finish_reason": JSON, "logprobs": JSON})


@given(JSON | st.fixed_dictionaries({"choices": JSON | st.lists(CHOICE, max_size=2)}))
@settings(max_examples=200)
def test_whatever_a_server_sends_is_read(body: Any) -> None:
    """Never an error; and what is a choice names an option that occurs in what was sent."""
    sent = json.dumps(body)
    for experiment in READERS:
        found = read_answer(experiment, 200, "application/json", sent.encode())
        assert (found.decision in experiment.options) == (found.kind == "choice")
        assert found.kind != "choice" or found.decision in sent
        assert (found.probabilities is not None) == (found.kind == "probabilities")


@pytest.mark.parametrize("options", [("0", "1"), ("1", "0"), ("2", "1"), ("HR1", "HR2")])
def test_labels_never_meet_positions(options: tuple[str, ...]) -> None:
    """The mass of a token belongs to the option of that name, wherever it stands: {0: .2, 1: .4} of options 0 and 1 are .2 and .4."""
    top = [
        {"token": t, "logprob": math.log(p)}
        for t, p in ((options[0], 0.2), (f" {options[1]}", 0.3), (f"{options[1]}\n", 0.1), ("The", 0.3))
    ]
    shown = {"content": [{"token": options[0], "logprob": math.log(0.2), "top_logprobs": top}]}
    body = json.dumps({"choices": [{"message": {"content": options[0]}, "finish_reason": "length", "logprobs": shown}]}).encode()
    found = read_answer(asked("logprobs", options), 200, "application/json", body)
    assert found.probabilities is not None
    assert [round(float(p), 12) for p in found.probabilities] == [0.2, 0.4]
    assert found.reason == "0.40 lies outside the options: 0.30 on 'The'"
    for kind in ("json", "choice", "token"):
        for place in ("1", "2", "first", "3"):
            assert read(asked(kind, options), place).decision == (place if place in options else "unreadable")


def test_an_option_that_may_go_on_is_not_one() -> None:
    """A first token that begins another option, or is cut before it could become one, says neither."""
    top = [{"token": "1", "logprob": math.log(0.5)}, {"token": "HR", "logprob": math.log(0.25)}, {"token": "10", "logprob": math.log(0.2)}]
    shown = {"content": [{**top[0], "top_logprobs": top}]}
    body = json.dumps({"choices": [{"message": {"content": "1"}, "logprobs": shown}]}).encode()
    found = read_answer(asked("logprobs", ("1", "10")), 200, "application/json", body)
    assert [float(p) for p in found.probabilities or ()] == [0, pytest.approx(0.2)]
    assert "0.50 on '1', where 10 begins" in found.reason
    assert "0.25 on 'HR', where HR1 begins" in read_answer(asked("logprobs"), 200, "application/json", body).reason
    assert [read(asked("token", ("1", "10")), "1", ended).decision for ended in ("stop", "length")] == ["1", "unreadable"]


CALL = {"name": "decide", "arguments": '{"choice": "HR1"}'}


def test_how_an_answer_ends_and_which_tool_it_calls() -> None:
    """Only an end that is known is whole; a call counts under a name that says so, without words beside it."""
    choice = asked("choice")
    for ended, word, written in (
        ("stop", "choice", "choice"), ("EOS", "choice", "choice"), (None, "choice", "choice"), ("length", "malformed", "choice"),
        ("MAX_TOKENS", "malformed", "choice"), ("model_length", "malformed", "choice"), ("abort", "malformed", "malformed"),
        ("recitation", "malformed", "malformed"), ("prohibited_content", "malformed", "malformed"),
    ):  # fmt: skip
        assert read(choice, "HR1", ended).kind == word  # type: ignore[arg-type]
        assert read(choice, CALL["arguments"], ended).kind == written  # type: ignore[arg-type]
    for content, function, kind in (
        (None, CALL, "choice"), (CALL["arguments"], CALL, "choice"), ("HR2", CALL, "contradictory"), ("No.", CALL, "contradictory"),
        ('{"choice": "HR2"}', CALL, "contradictory"), (None, {**CALL, "name": "reject_candidate"}, "malformed"),
    ):  # fmt: skip
        assert read(choice, content, tool_calls=[{"function": function}]).kind == kind
    assert read(choice, "HR2", function_call=CALL).kind == "malformed"


@pytest.mark.parametrize(
    "entries", [[("HR1", -1), ("HR1", -1)], [("HR1", "-0.7")], [("HR1", False)], [(None, -1), ("HR1", math.nan)], [("HR1", None)]]
)
def test_probabilities_that_are_none(entries: list[tuple[Any, Any]]) -> None:
    top = [{"token": token, "logprob": value} for token, value in entries]
    body = json.dumps({"choices": [{"message": {}, "logprobs": {"content": [{**top[0], "top_logprobs": top}]}}]}).encode()
    assert read_answer(asked("logprobs"), 200, "application/json", body).kind == "malformed"


def test_an_article_is_no_option() -> None:
    top = [{"token": token, "logprob": math.log(0.3)} for token in ("a", "'A", " B")]
    body = json.dumps({"choices": [{"message": {}, "logprobs": {"content": [{**top[0], "top_logprobs": top}]}}]}).encode()
    found = read_answer(asked("logprobs", ("A", "B")), 200, "application/json", body)
    assert [float(p) for p in found.probabilities or ()] == [0, pytest.approx(0.3)]


def test_a_copy_of_the_example_is_no_choice() -> None:
    """Word for word, with its reason; with a reason of its own the same marks are a choice."""
    experiment = read_experiment("document-delivery")
    copied = '{"HR1": "0.0", "HR2": "1.0", "reason": "why this officer and not the other one"}'
    assert copied in experiment.user
    found = read(experiment, f"```json\n{copied}\n```")
    assert (found.kind, found.decision) == ("copied", "unreadable")
    assert read(experiment, copied.replace("why this", "this")).decision == "HR2"
    assert read(experiment, '{"HR1": "0.0", "HR2": "1.0"}').decision == "HR2"
    assert read(experiment, f'{copied} {{"HR1": "1.0", "HR2": "0.0"}}').kind == "contradictory"


def test_the_schema_and_the_reader_agree() -> None:
    """What the schema of one field admits is always a choice, and that choice; two marks can still contradict each other."""
    choice, marks = asked("choice"), asked("json")
    schema = Draft202012Validator(answer_schema(choice))
    for value in ("HR1", "HR2", "HR3", None, 1):
        assert schema.is_valid({"choice": value}) == (read(choice, json.dumps({"choice": value})).kind == "choice")
    assert not schema.is_valid({})
    assert not schema.is_valid({"choice": "HR1", "more": 1})
    schema = Draft202012Validator(answer_schema(marks))
    for first, second in itertools.product(("1.0", "0.0"), repeat=2):
        given = {"HR1": first, "HR2": second, "reason": ""}
        assert schema.is_valid(given)
        assert read(marks, json.dumps(given)).kind == ("contradictory" if first == second else "choice")
    assert not schema.is_valid({"HR1": "0.5", "HR2": "0.5", "reason": ""})
    sent = request_body(choice, Model("m", base_url="http://host/v1"), "sick leave", choice.slots(("HR1", "HR2")))
    assert sent["response_format"]["json_schema"]["schema"] == answer_schema(choice)
    assert "response_format" not in request_body(asked("token"), Model("m"), "sick leave", choice.slots(("HR1", "HR2")))


@pytest.mark.parametrize("kind", ["json", "choice", "token"])
def test_embedded_makers_answer_in_the_same_form(kind: str) -> None:
    experiment = asked(kind, ("1", "0"))
    for place, option in enumerate(experiment.options):
        assert read_answer(experiment, 0, "text/plain", answer_text(experiment, place)).decision == option
    assert read_answer(experiment, 0, "text/plain", answer_text(experiment, None)).kind == "malformed"


def changed(folder: Path, old: str, new: str, more: str = "") -> Path:
    text = bundled()["document-delivery"].read_text()
    assert old in text
    path = folder / "e.toml"
    path.write_text(text.replace(old, new) + more)
    return path


def test_a_seed_is_no_sample(tmp_path: Path) -> None:
    model = '\n[[model]]\nname = "m"\nbase_url = "http://127.0.0.1:9/v1"\nparameters = { seed = 7 }\n'
    path = changed(tmp_path, "trials = 100", "trials = 2", model)
    with pytest.raises(InputError, match=r"'m' has a seed among its parameters \(seed = 7\), and 2 answers are asked for each cell"):
        read_experiment(str(path))
    assert read_experiment(str(path), trials=1).trials == 1
    text = path.read_text()
    for other in ('"random_seed" = 7', "extra_body = { SEED = 7 }", 'options = [{ "x-seed" = 7 }]'):
        path.write_text(text.replace("seed = 7", other))
        with pytest.raises(InputError, match="has a seed"):
            read_experiment(str(path))
    path.write_text(text.replace("trials = 2", 'trials = 1\ndesign = "end-to-end"'))
    with pytest.raises(InputError, match="has a seed"):
        read_experiment(str(path))


MODEL = '[[model]]\nname = "m"\nbase_url = "http://127.0.0.1:9/v1"\n'


@pytest.mark.parametrize(
    ("old", "new", "more", "said"),
    [
        ("[[model]]", "[model]", "", "sections"),
        *[('column = "document"', f'column = "{name}"', "", "one name") for name in ("slot", "decision", "weight", "own name", "HR1 name")],
        *[('["HR1", "HR2"]', f'["{name}", "B"]', "", "another name") for name in ("another", "unreadable", "fault", "refused", "open")],
        *[("", "", f"{MODEL}parameters = {{ {name} = 1 }}", "says itself") for name in ("model", "messages", "stream", "n", "logprobs")],
        ("", "", f"{MODEL}parameters = {{ d = 1979-05-27 }}", "sent as JSON"),
        ("", "", f"{MODEL}parameters = {{ d = inf }}", "sent as JSON"),
        *[('user = """', f'user = """{wrong}', "", "cannot be filled in") for wrong in ("{{ '{5}'.format(1) }}", "{{ '{x}'.format() }}")],
        ('user = """', 'user = """{{ cycler() }}', "", "cannot be filled in"),
    ],
)
def test_files_of_which_no_certificate_could_come_are_refused(old: str, new: str, more: str, said: str, tmp_path: Path) -> None:
    path = changed(tmp_path, old, new, more) if old else changed(tmp_path, 'title = "', f'{new}title = "', more)
    with pytest.raises(InputError, match=said):
        read_experiment(str(path))


def test_an_address_with_a_slash_is_the_same_model(tmp_path: Path) -> None:
    keys = [
        read_experiment(str(changed(tmp_path, 'title = "', 'title = "', MODEL.replace("/v1", end)))).models[0].key
        for end in ("/v1", "/v1/")
    ]
    assert keys[0] == keys[1]


def test_probabilities_are_asked_for_once(tmp_path: Path) -> None:
    kind = 'options = ["HR1", "HR2"]\nkind = "logprobs"'
    path = changed(tmp_path, 'options = ["HR1", "HR2"]', kind)
    path.write_text(path.read_text().replace("[sampling]\ntrials = 100\n", ""))
    assert read_experiment(str(path)).trials == 1
    path = changed(tmp_path, "[sampling]\ntrials = 100\n", "")
    with pytest.raises(InputError, match="trials is None; a whole number"):
        read_experiment(str(path))


@pytest.mark.parametrize("kind", ["json", "logprobs"])
def test_status_and_certify_say_what_shaped_the_answers(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    path = changed(tmp_path, 'options = ["HR1", "HR2"]', f'options = ["HR1", "HR2"]\nkind = "{kind}"')
    with serving(fault=lambda *_: "example" if kind == "json" else "") as server:
        command = [str(path), "--folder", str(tmp_path / "out"), "--trials", "1", "--base-url", server.url, "--model", "m"]
        assert main(["experiment", "run", *command]) == 0
    said = "temperature, top_k, top_p, min_p were left to the server" if kind == "json" else "0.05 lies outside the options"
    for action in ("status", "certify"):
        capsys.readouterr()
        assert main(["experiment", action, *command]) == 0
        shown = capsys.readouterr().out
        assert shown.count(said) == 1
        assert ("6 copied" in shown) == (kind == "json")


def test_what_a_request_says_of_its_sampling() -> None:
    assert sampling_note({"temperature": 1.0, "top_k": 0, "top_p": 1.0, "min_p": 0.0}) == ""
    found = sampling_note({"temperature": 0.7, "top_p": 0.9, "top_k": -1})
    assert "temperature = 0.7, top_p = 0.9 reshaped or cut" in found
    assert "min_p was left to the server" in found
    assert "temperature, top_k, top_p, min_p were left to the server" in sampling_note({})
