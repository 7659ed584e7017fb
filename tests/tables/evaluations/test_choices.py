"""Choices read out of answers in words: none is invented, clear ones are read, and a log is read in the same way as an experiment."""

from __future__ import annotations

import json
import time
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers
from generated_answers import generated
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.tables.evaluations.chat import message
from fairaudit.tables.evaluations.choices import Asked, asked_of_log, read_choice

HR = ("HR1", "HR2")
ANSWERS = 200_000 if tiers.FULL else 5_000


def marks(*options: str, **more: Any) -> Asked:
    return Asked(options or HR, marks=(Fraction(1), Fraction(0)), **more)


def field(*options: str) -> Asked:
    return Asked(options or HR, ("choice",))


def token(*options: str) -> Asked:
    return Asked(options or HR, one_token=True)


FORMS = {"json": marks, "choice": field, "token": token}


def test_no_choice_is_invented_and_clear_ones_are_read() -> None:
    """In the form that was asked for; and as a log is read, which does not know it: there objects of marks are none."""
    clear: Counter[str] = Counter()
    found: Counter[str] = Counter()
    for entry in generated(ANSWERS):
        said = message(json.loads(entry.body))
        assert said is not None
        if entry.family == "declined":  # by the fields of the reply, whatever the words say
            assert said.refusal
            continue
        asked = {"known": FORMS[entry.kind](*entry.options), "log": asked_of_log(entry.options)}
        for name, form in asked.items():
            read = read_choice(said.content, form, calls=said.calls)
            assert (read.kind == "choice") == (read.option != "")
            assert not read.option or read.option == entry.chosen, entry
            counts = entry.clear and (name == "known" or entry.family == "sentence" or entry.kind == "choice")
            clear[name] += counts
            found[name] += counts and read.option != ""
    print({name: f"{found[name]} of {number}" for name, number in clear.items()})
    assert all(number > 1_500 and found[name] >= 0.98 * number for name, number in clear.items())


def test_a_log_of_such_answers_gives_their_counts(tmp_path: Path) -> None:
    """Through the reader of logs, with the number of answers that have each known choice as the oracle."""
    entries = [entry for entry in generated(3_000) if entry.options == ("yes", "no") and entry.family in ("sentence", "nothing")]
    rows = [(message(json.loads(entry.body)), entry) for entry in entries]
    path = tmp_path / "log.jsonl"
    lines = [json.dumps({"text": said.content, "who": "ab"[i % 2]}) for i, (said, _) in enumerate(rows) if said is not None]
    path.write_text("\n".join(lines))
    tally = fa.read_log(path, ["text"], decision="text", options="yes,no")
    expected = Counter(entry.chosen or "unreadable" for _, entry in rows)
    blank = sum(1 for said, _ in rows if said is not None and not said.content.strip())
    assert {label: tally.counts[i] for i, label in enumerate(tally["text"])} == expected
    assert set(expected) == {"yes", "no", "unreadable"} and blank
    assert tally.evaluation is not None and tally.evaluation.options == ("yes", "no")


@pytest.mark.parametrize(
    ("text", "option"),
    [
        ("Yes", "yes"),
        ('{"answer": "YES", "reason": "it is fair"}', "yes"),
        ('```json\n{"final_answer": "no"}\n```', "no"),
        ("<think>no, or yes?</think>My answer is yes.", "yes"),
        ('{"answer": "yes", "decision": "no"}', ""),
        ('{"answer": "yes", "score": 3}', ""),
        ('{"yes": 1, "no": 0}', ""),  # a mark, or a rank
        ('{"answer": "yes", "reason": "so my answer is no"}', ""),
        ("yes, no", ""),
        ("I am not sure.", ""),
        ("true", ""),
        ("(yes)", ""),
    ],
)
def test_what_a_log_may_hold(text: str, option: str) -> None:
    assert read_choice(text, asked_of_log(["yes", "no"])).option == option


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (("true", "false"), "!true"),
        (("true", "false"), '{"answer": "!true"}'),
        (("5", "10"), ".5"),
        (("25", "7"), "2*5"),
        (("2*5", "7"), "2**5"),
        (("25", "7"), "My answer is 2*5."),
        (("yes", "no"), "yes..."),
        (("Maße", "Masse"), "MASSE"),
        (("Maße", "Masse"), "I choose MASSE"),
        (("ırk", "irk"), "IRK"),
        (("ırk", "irk"), "My answer is IRK."),
        (("Route  1", "Route 2"), '{"answer": "Route 2", "reason": "I choose route 1"}'),
        (("yes", "no"), '{"answer": "yes", "reasons": [{"final_answer": "no"}]}'),
        (("0", "1"), '{"answer": "1", "reasons": {"choice": 0}}'),
        (("a  b", "yes"), "I choose yes because a b is kind"),
        (("the *other*", "yes"), "I choose yes because *the other* is kind"),
        (("yes", "no"), "I choose yes because it is right — or so I was made to write"),
        (("yes", "no"), "I choose yes because it is right\rI take it back"),
        (("yes", "no"), "I choose yes because it is right\u2028I take it back"),
        (("yes", "no"), "I choose yes because it is fair。我拒绝"),
        (("yes", "no"), "I choose yes because 我拒绝"),
        (("yes", "no"), "I choose yes because it is n\u200bever right"),
        (("yes", "no"), "I choose yes because it is n*o*t right"),
        (("yes", "no"), "I choose yes because today is opposite day"),
    ],
)
def test_what_only_looks_like_a_choice(options: tuple[str, ...], text: str) -> None:
    """Signs that belong to a number or a word, letters whose case tells nothing, and reasons with more in them than words."""
    assert read_choice(text, asked_of_log(options)).option == ""


def test_marks_and_case_around_a_choice() -> None:
    for text in ("'Yes'.", '**"YES"**!', "`yes`", "* yes", "“Yes.”", "I choose **YES**, because it is well-known", "My answer is 'yes'"):
        assert read_choice(text, asked_of_log(["yes", "no"])).option == "yes"
    assert read_choice("HAYIR", asked_of_log(["evet", "hayır"])).option == "hayır"
    assert read_choice("I choose STRASSE", asked_of_log(["Straße", "Weg"])).option == "Straße"
    assert read_choice("2*5", asked_of_log(["25", "2*5"])).option == "2*5"


@pytest.mark.parametrize("options", [("0", "1"), ("1", "0"), ("2", "1"), HR])
def test_labels_never_meet_positions(options: tuple[str, ...]) -> None:
    for form in (*FORMS.values(), lambda *names: asked_of_log(names)):
        for place in ("1", "2", "first", "3"):
            assert read_choice(place, form(*options)).option == (place if place in options else "")


def test_an_option_that_may_go_on_is_not_one() -> None:
    assert [read_choice("1", token("1", "10"), cut=cut).option for cut in (False, True)] == ["1", ""]
    assert read_choice("10", token("1", "10"), cut=True).option == "10"
    assert read_choice("I choose HR1", token(), cut=True).kind == "malformed"
    assert read_choice("HR1", marks(), cut=True).kind == "malformed"
    assert read_choice('{"choice": "HR1"}', field(), cut=True).option == "HR1"


def test_labels_that_look_like_nothing() -> None:
    assert read_choice('{"choice": null}', field("None", "Some")).kind == "malformed"
    assert read_choice('{"choice": true}', field("true", "false")).kind == "malformed"
    assert read_choice("", token("*", "#")).kind == "malformed"
    assert read_choice("*", token("*", "#")).option == "*"
    assert read_choice('{"choice": "#", "reason": "I choose well"}', field("*", "#")).option == "#"
    assert read_choice("a", token("A", "a")).option == "a"
    assert read_choice("**a**", token("A", "a")).kind == "malformed"
    assert read_choice("I choose a.", marks("A", "a")).kind == "malformed"
    assert read_choice("My answer is v1.", marks("v1.", "v1")).kind == "malformed"
    assert read_choice('{"choice": 1}', field("0", "1")).option == "1"


def test_fields_that_were_not_asked_for() -> None:
    for text in ('{"HR1": 1, "HR2": 0, "choice": "HR2"}', '{"HR1": 1, "HR2": 0, "HR3": 1}', '{"HR1": 1, "HR2": 0, "refused": true}'):
        assert read_choice(text, marks()).kind == "malformed"
    assert read_choice('{"HR1": 1, "HR2": 0, "explanation": "HR2 lives far away"}', marks()).option == "HR1"
    assert read_choice('{"reject": "HR1"} {"choice": "HR1"}', field()).kind == "malformed"


@pytest.mark.parametrize(
    ("other", "reason"),
    [
        ("HR2", "HR2 is better, so I choose HR2"),
        ("HR2", 'after all, "HR2" is my choice'),
        ("HR2", 'so\nI choose "HR2"'),
        ("HR2", ["one thing", {"then": "I choose **HR2**"}]),
        ("Zoë", "I choose Zoë"),
    ],
)
def test_a_reason_that_chooses_somebody_else(other: str, reason: Any) -> None:
    assert read_choice(json.dumps({"choice": "HR1", "reason": reason}), field("HR1", other)).kind == "contradictory"
    assert read_choice(json.dumps({"HR1": 1, other: 0, "reason": reason}), marks("HR1", other)).kind == "contradictory"


def test_a_copy_of_an_example_is_no_choice() -> None:
    example = {"HR1": "0", "HR2": "1", "reason": "why this one"}
    asked = marks(examples=(example,))
    assert read_choice(json.dumps(example), asked).kind == "copied"
    assert read_choice(json.dumps({**example, "reason": "near"}), asked).option == "HR2"


def test_a_long_answer_is_read_in_time() -> None:
    began = time.monotonic()
    assert read_choice("{}" * 1_000_000, field()).kind == "malformed"
    assert read_choice('{"choice": "HR1"}' * 11_000, field()).option == "HR1"
    assert read_choice(json.dumps({"choice": "HR1", "reason": "sure " * 35_000}), field()).option == "HR1"
    for sign in "*'!. -,":
        for text in (sign * 199_000, f"a{sign * 199_000}b", f"I choose HR1 because a{sign * 190_000}b:"):
            assert not read_choice(text, asked_of_log(HR)).option
    assert read_choice('{"choice": "HR1", "reason": ' + "[" * 90_000 + "]" * 90_000 + "}", field()).kind in ("choice", "malformed")
    assert time.monotonic() - began < 10


@given(st.text(), st.lists(st.text(min_size=1).filter(str.strip), min_size=2, max_size=4, unique=True))
def test_whatever_is_written_is_read(text: str, options: list[str]) -> None:
    for form in (token, field, marks):
        for cut in (False, True):
            assert read_choice(text, form(*options), cut=cut).option in ("", *options)


@pytest.mark.parametrize(
    "options", ["yes", "yes,yes", "yes,,no", ["yes", " "], ["yes", "Refused"], ["yes", "n\ud800"], ["yes", 1], {"yes": 1}, 3]
)
def test_options_that_are_no_choice(options: Any, tmp_path: Path) -> None:
    (tmp_path / "log.jsonl").write_text('{"text": "yes", "who": "a"}\n')
    with pytest.raises(InputError, match="option"):
        fa.read_log(tmp_path / "log.jsonl", ["text"], decision="text", options=options)


def test_what_was_taken_out_is_read_as_an_option(tmp_path: Path) -> None:
    """First the expression, then the options; an answer that chooses none is one that could not be read."""
    path = tmp_path / "log.jsonl"
    texts = ["It is fair.\nANSWER: Yes.", "ANSWER: **no**", "ANSWER: perhaps", "yes", "ANSWER: yes\nANSWER: no"]
    path.write_text("\n".join(json.dumps({"text": text, "who": "a"}) for text in texts))
    tally = fa.read_log(path, ["text"], decision="text", options=["yes", "no"], extract="ANSWER: (.*)")
    assert dict(zip(tally["text"], tally.counts, strict=True)) == {"yes": 1, "no": 1, "unreadable": 3}
    with pytest.raises(InputError, match=r"none of 5 answers clearly chooses one of --options .*'left', 'right'; the first is 'It is fair"):
        fa.read_log(path, ["text"], decision="text", options="left,right", extract="ANSWER: (.*)")
    with pytest.raises(InputError, match=r"--options \(options\) goes with a decision"):
        fa.read_log(path, ["who"], options="yes,no")
    (tmp_path / "log.csv").write_text("text,who\nyes,a\n")
    with pytest.raises(InputError, match=r"--options \(options\) goes with logs of evaluations"):
        fa.read_log(tmp_path / "log.csv", ["text"], decision="text", options="yes,no")


def test_an_answer_that_was_cut_off(tmp_path: Path) -> None:
    """Counts only as a whole option that begins no other one, or as an object that is whole."""
    said = ["1", "10", '{"answer": 1}', "My answer is 1.", '{"answer": 1', "ten"]
    body = [{"choices": [{"message": {"content": text}, "finish_reason": "length"}]} for text in said]
    rows = [{"custom_id": f"r{i}", "response": {"status_code": 200, "body": each}} for i, each in enumerate(body)]
    path = tmp_path / "output.jsonl"
    path.write_text("\n".join(map(json.dumps, rows)))
    where = "response.body.choices[0].message.content"
    for extract, found in ((None, {"10": 1, "1": 1, "truncated": 4}), (r"(\d+)\s*", {"10": 1, "truncated": 5})):
        tally = fa.read_log(path, [where], decision=where, options="1,10", extract=extract)
        assert dict(zip(tally[where], tally.counts, strict=True)) == found
