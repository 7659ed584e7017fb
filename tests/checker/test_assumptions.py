"""Claims list what they rest on: each sentence that the pages of the format ask for, and no other."""

from __future__ import annotations

import copy
import json
import re
from typing import Any

import pytest
import tiers
from assumptions import needed, sentences
from certificates import KINDS, outcome, random_certificate

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.reports.text import summary

SEEDS = range(4 * len(KINDS))


def document(seed: int) -> Any:
    return json.loads(random_certificate(seed).text)


def of_halves() -> Any:
    law = fa.Law.from_array([[30, 10], [20, 20]], kind="counts", decisions=["yes", "no"])
    return json.loads(fa.certify(law, {"yes": 1}, independent=True, select="half-split").certificate.text)


def test_the_sentences_of_the_pages_are_those_of_the_checker() -> None:
    known = {text for name, text in vars(checker.sentences).items() if name.isupper() and isinstance(text, str)}
    for name, text in sentences().items():
        assert re.sub(r"\{[^{}]*\}", "{}", text) in {re.sub(r"\{[^{}]*\}", "{}", one) for one in known}, name


@pytest.mark.parametrize("seed", SEEDS)
def test_every_claim_of_the_writer_lists_what_the_pages_ask_for(seed: int) -> None:
    written = document(seed)
    for claim in written["claims"]:
        extra = [text for text in claim["assumptions"] if text not in needed(claim, written)]
        assert set(needed(claim, written)) <= set(claim["assumptions"])
        assert all("left out" in text or text == sentences()["one-row"] for text in extra)
        assert len(set(claim["assumptions"])) == len(claim["assumptions"])
    assert outcome(written) == "true"


def test_the_writer_lists_every_sentence_of_the_pages_somewhere() -> None:
    written = [*map(document, SEEDS), of_halves()]
    listed = {text for one in written for claim in one["claims"] for text in claim["assumptions"]}
    rest = {name for name, text in sentences().items() if text not in listed and "{" not in text}
    assert not rest


def test_a_split_is_listed_as_the_pages_ask() -> None:
    written = of_halves()
    population = [claim for claim in written["claims"] if claim["by"] == "pair-exact"]
    assert population and all(set(claim["assumptions"]) == set(needed(claim, written)) for claim in population)
    assert all(sentences()["split"] in claim["assumptions"] for claim in population)


@pytest.mark.parametrize("seed", range(len(KINDS)))
def test_no_sentence_can_be_taken_away_added_altered_or_repeated(seed: int) -> None:
    """Of a third of the claims, and of all with ``FAIRAUDIT_FULL=1``."""
    written = document(seed)
    claims = list(enumerate(written["claims"]))
    for i, claim in claims if tiers.FULL else claims[seed % 3 :: 3] or claims:
        listed = claim["assumptions"]
        for j, text in enumerate(listed):
            without = [*listed[:j], *listed[j + 1 :]]
            if text != sentences()["one-row"]:
                found = change(written, i, without)
                assert found.startswith(f"incomplete: claims[{i}]") or (len(written["claims"]) > 1 and "left out" in text), found
                assert json.dumps(text, ensure_ascii=False) in found
            assert change(written, i, [*without, text.replace("not", "now") + "."])[:4] in ("inco", "malf")
            assert change(written, i, [*listed, text]).startswith("malformed")
        assert change(written, i, [*listed, "all is well"]).startswith("malformed")
        assert change(written, i, listed[::-1]) == "true"


def change(written: Any, claim: int, assumptions: list[str]) -> str:
    changed = copy.deepcopy(written)
    changed["claims"][claim]["assumptions"] = assumptions
    return outcome(changed)


def test_what_was_left_out_of_the_log_is_asked_of_every_claim() -> None:
    written = document(next(i for i, kind in enumerate(KINDS) if kind.__name__ == "left_out"))
    [text] = {text for claim in written["claims"] for text in claim["assumptions"] if "left out" in text}
    for claim in written["claims"][1:]:
        claim["assumptions"].remove(text)
    assert outcome(written).startswith("incomplete: claims[1]")


@pytest.mark.parametrize("name", ["sample", "policy", "stream"])
def test_figures_do_not_stand_without_the_claims_that_say_what_they_rest_on(name: str) -> None:
    for seed in (seed for seed in SEEDS if KINDS[seed % len(KINDS)].__name__ == name):
        written = document(seed)
        written["claims"] = [claim for claim in written["claims"] if not claim["scope"].startswith("population")]
        if written["subject"]["kind"] == "policy" and "intervals" not in written:
            written["claims"] = []
        assert outcome(written).startswith("incomplete: there is no claim") or outcome(written) == "false"


def test_the_command_refuses_in_one_sentence(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    law = fa.Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    written = json.loads(fa.certify(law, {"yes": 1}, independent=True, max_local_ratio=5).certificate.text)
    for claim in written["claims"]:
        claim["assumptions"] = [text for text in claim["assumptions"] if text != sentences()["cells"]]
    path = tmp_path / "c.json"
    path.write_text(json.dumps(written))
    assert main(["verify", str(path)]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1 and sentences()["cells"] in printed.err
    assert "local_ratio" in printed.err and "incomplete" in printed.err


@pytest.mark.parametrize("confidence", [None, "0.9"])
def test_the_text_lists_every_sentence(confidence: Any) -> None:
    table = {"u": ["yes", "no"] * 3, "a": ["f", "f", "m", "m", "", ""], "n": [3, 1, 4, 1, 5, 9]}
    law = fa.Law.from_counts(table, decision="u", group="a", count="n", missing="drop")
    response = fa.RandomizedResponse(["f", "m"], keep_probability=1)  # with which no theorem guarantees anything
    policy = fa.Policy.from_counts(table, decision="u", group="a", count="n", missing="drop")
    for subject in (law, policy.behind(group=response)):
        result = fa.certify(subject, {"yes": 1}, confidence=confidence)
        text = summary(result, 3, [])
        listed = {sentence for claim in result.claims for sentence in claim.assumptions}
        assert listed and all(f"- {sentence}\n" in text for sentence in listed)
