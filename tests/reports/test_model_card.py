"""A model card is YAML that programs read and markdown that people read, whatever the labels are, and says no more than the certificate."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.attestations.statement import Rows, Source, Stated, Statement, Subject
from fairaudit.cli import main
from fairaudit.reports.model_card import FILL_IN, model_card, quoted, yaml_number
from fairaudit.reports.provenance import Provenance
from fairaudit.tables.examples import example

HOSTILE = [
    "---",
    "a: b\n---\n# c",
    "{{x}}",
    "<script>",
    "| x |",
    "&a *b !c",
    "\u202eabc",
    "\U0001f600",
    "yes",
    "1e5",
    "'\"\\",
    "- [ ] @all",
]


TABLE = "tabular-classification", "decision-log"


def run(*words: Any) -> int:
    return main([str(word) for word in words])


def parts(card: str) -> tuple[Any, str]:
    empty, front, rest = card.split("---\n", 2)
    assert not empty
    return yaml.safe_load(front), rest


def berkeley(**limits: Any) -> fa.Result:
    entry = example("ucb-admissions")
    names = {"decision": entry.decision, "group": entry.group, "context": entry.context, "count": entry.count}
    return fa.audit(entry.table(), **names, utility=entry.utility, **limits)


def test_the_card_of_berkeley(tmp_path: Path) -> None:
    result = berkeley(max_global_ratio="1.2")
    card = fa.report(result, format="model-card")
    index, text = parts(card)
    [entry] = index["model-index"]
    [found] = entry["results"]
    assert entry["name"].startswith(FILL_IN) and found["dataset"]["name"].startswith(FILL_IN)
    assert found["task"] == {"type": "tabular-classification"} and found["dataset"]["type"] == "decision-log"
    assert found["dataset"]["revision"] == result.certificate.document["subject"]["table"]["sha256"]
    metrics = {metric["type"]: metric for metric in found["metrics"]}
    # 1198/2691 against 557/1835, of all admissions of 1973
    assert metrics["fairaudit-global-ratio"]["value"] == 1.467
    assert metrics["fairaudit-global-ratio"]["name"].startswith("Global ratio, exactly 2198330/1498887; in the population at least 1.2")
    assert [*metrics] == [f"fairaudit-{name}" for name in ("local-ratio", "global-ratio", "equalized-odds", "demographic-parity")]
    assert "verified" not in str(index) and all({*metric} == {"type", "value", "name"} for metric in found["metrics"])
    for heading in ("## Bias, Risks, and Limitations", "#### Testing Data", "#### Factors", "#### Metrics", "### Results", "#### Summary"):
        assert f"\n{heading}\n" in text
    assert "* **exceeds**: global ratio at most 1.2" in text and "| <code>Female</code> | 557 of 1,835 | 30.4 % |" in text
    assert "all 50 statements are true of the table" in text
    assert fa.report(result, tmp_path / "card.md", format="model-card") == card == (tmp_path / "card.md").read_text()


def test_without_contexts_there_is_one_ratio() -> None:
    index, text = parts(model_card(fa.audit({"u": [1, 0, 1], "a": ["f", "f", "m"]}, decision="u", group="a", utility="1").certificate))
    assert [metric["type"] for metric in index["model-index"][0]["results"][0]["metrics"]] == [
        "fairaudit-global-ratio",
        "fairaudit-demographic-parity",
    ]
    assert "* `fairaudit-global-ratio`: how many times as great the expected utility of one group is as that of another, at most; 1" in text


def test_of_whom_the_figures_are_is_said() -> None:
    table = {"u": list("yynnyyn"), "a": list("ffffmm?")}
    index, text = parts(fa.report(fa.audit(table, decision="u", group="a", utility="y", unknown="?"), format="model-card"))
    # 2 of 4 against 2 of 2; the seventh is of either, and got nothing
    named = index["model-index"][0]["results"][0]["metrics"][0]["name"]
    assert named.startswith("Global ratio, exactly 2, of the decisions whose group is known; in the population")
    assert "#### Decisions without a recorded group\n\n* Of 7 decisions, 1 have no recorded group; whoever they are" in text
    policy = fa.Policy.from_counts({"u": ["y", "n"] * 2, "a": list("ffmm"), "n": [1, 2, 2, 1]}, decision="u", group="a", count="n")
    behind = fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4")), {"y": 1}, confidence=None)
    _, text = parts(fa.report(behind, format="model-card"))
    assert "* Audited: a policy behind privacy filters\n" in text and "* Group filter: " in text


def test_differences_and_true_labels_are_measures_too() -> None:
    table = {"u": list("yynnyyn"), "t": list("ynnyyny"), "a": list("ffffmmm"), "x": list("ppppppp")}
    for more in ({"truth": "t"}, {"difference": True}):
        result = fa.audit(table, decision="u", group="a", context="x", utility="y", **more)
        index, text = parts(model_card(result.certificate))
        for metric in index["model-index"][0]["results"][0]["metrics"]:
            key = metric["type"].removeprefix("fairaudit-").removesuffix("-ratio").replace("-", "_")
            entry = result.certificate.document["metrics"][key]
            exact = entry.get("ratio") or entry.get("value") or entry["difference"]
            assert f", exactly {exact}" in metric["name"] and abs(Fraction(metric["value"]) - Fraction(exact)) <= Fraction(exact) / 1000
            assert f"\n* `{metric['type']}`: " in text


@pytest.mark.parametrize("label", HOSTILE)
def test_hostile_labels_break_neither_yaml_nor_markdown(label: str) -> None:
    table = {label: [label, "no", label, "no"], "a" + label: ["f" + label, "f" + label, "m", "m"]}
    card = fa.report(fa.audit(table, decision=label, group="a" + label, utility={label: 1}), format="model-card")
    index, text = parts(card)
    assert [*index] == ["model-index"] and "<script>" not in text and "\u202e" not in text
    assert all(line == "---" for line in card.splitlines() if line.startswith("---")) and card.count("\n---\n") == 1


@given(st.text())
def test_every_text_is_one_scalar(text: str) -> None:
    if not any("\ud800" <= c <= "\udfff" for c in text):
        assert yaml.safe_load(f"a: {quoted(text)}\nb: 1") == {"a": text, "b": 1}


@given(st.fractions(0, 10**30, max_denominator=10**9), st.lists(st.fractions(0, 10**6, max_denominator=10**6), max_size=2))
def test_a_rounded_number_stays_on_its_side(value: Fraction, limits: list[Fraction]) -> None:
    text = yaml_number(value, limits)
    assert isinstance(yaml.safe_load(text), (int, float))
    shown = Fraction(text)
    assert abs(shown - value) <= value / 1000
    for side in (Fraction(1), *limits):
        assert float(side) == float(value) or (shown > side, shown < side) == (value > side, value < side)


def test_as_many_digits_as_tell_a_number_from_its_limit() -> None:
    assert yaml_number(1 + Fraction(1, 10**12)) == "1.000000000001"
    assert yaml_number(Fraction(4, 5) - Fraction(1, 10**9), [Fraction(4, 5)]) == "0.799999999"
    assert yaml.safe_load(yaml_number(float("inf"))) == "inf"


def test_what_has_no_card_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "c.json"
    path.write_text(berkeley().certificate.text)
    assert run("report", path, "--format", "model-card", "-o", tmp_path / "card.md") == 0
    assert (tmp_path / "card.md").read_text().startswith("---\nmodel-index:\n")
    assert run("report", path, "--format", "model-card", "-o", tmp_path / "card.html") == 2
    assert "--format model-card does not go with" in capsys.readouterr().err and not (tmp_path / "card.html").exists()
    assert run("report", path, "--format", "model-card", "--small", "10") == 2
    assert "--small does not go with --format model-card" in capsys.readouterr().err
    log = tmp_path / "log.csv"
    log.write_text("sex,age,u\n" + "f,1,y\nf,2,n\nm,1,y\nm,2,y\n" * 10)
    assert run("subgroups", log, "--decision", "u", "--attributes", "sex,age", "--utility", "y", "-o", tmp_path / "s.json") in (0, 3)
    assert run("report", tmp_path / "s.json", "--format", "model-card") == 2
    assert "a model card is made of a certificate of ratios" in capsys.readouterr().err


def provenance(**stated: Any) -> Provenance:
    rows = Rows("decisions", Fraction(10), Fraction(7), {"missing | label": Fraction(3)})
    source = Source("log <b>.csv", "1" * 64, 99, 10)
    made = ({"decision": "u"}, ("certify", "log.csv"), {"fairaudit": "0.1.0"}, "2026-01-15T09:00:00Z")
    statement = Statement((Subject("c.json", "0" * 64),), "2" * 64, (source,), rows, *made, Stated(**stated))
    return Provenance((), "", (), "", (), 0, "", statement)


@pytest.mark.parametrize(("extract", "task", "data"), [("^(yes|no)", "text-generation", "evaluation-log"), (None, *TABLE)])
def test_what_was_audited_has_its_type(tmp_path: Path, extract: str | None, task: str, data: str) -> None:
    """Answers of a model are text that was generated; labels of any other table are not."""
    (tmp_path / "log.jsonl").write_text("".join(f'{{"said": {{"text": "{u}"}}, "sex": "{a}"}}\n' for u in ("yes", "no") for a in "fm"))
    result = fa.audit(tmp_path / "log.jsonl", decision="said.text", group="sex", utility="yes", extract=extract, confidence=None)
    (found,) = parts(fa.report(result, format="model-card"))[0]["model-index"][0]["results"]
    assert (found["task"]["type"], found["dataset"]["type"]) == (task, data)


@pytest.mark.parametrize("name", ["Screener", *(text.replace("\n", " ") for text in HOSTILE)])
def test_what_is_attested_fills_the_names_in(name: str) -> None:
    stated = provenance(system=name, system_version="2.1", title=name, issuer=name, period=("2025-01-01", "2025-12-31"))
    index, text = parts(model_card(berkeley().certificate, provenance=stated))
    [entry] = index["model-index"]
    assert entry["name"] == f"{name} 2.1" and entry["results"][0]["dataset"]["name"] == name
    assert "* Period: <code>2025&#45;01&#45;01 to 2025&#45;12&#45;31</code>\n" in text and f"{FILL_IN}: which decisions" not in text
    assert "10 decisions read, 7 counted, 3 dropped (<code>missing &#124; label</code>)" in text and "<b>" not in text
    assert "no program can check it from here" in text and "\u202e" not in text
    partly, _ = parts(model_card(berkeley().certificate, provenance=provenance(issuer="A")))
    assert partly["model-index"][0]["name"].startswith(FILL_IN)


def test_the_way_of_a_publisher(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made, stated, card = (tmp_path / name for name in ("c.json", "a.json", "card.md"))
    names = ("--system", "Screener", "--system-version", "2", "--title", "Spring", "--issuer", "A", "--period", "2025-01-01/2025-12-31")
    assert run("certify", "--example", "ucb-admissions", "--confidence", "none", "-o", made, "--attest", stated, *names) == 0
    assert run("report", made, "--attestation", stated, "--format", "model-card", "-o", card) == 0
    index, text = parts(card.read_text())
    assert index["model-index"][0]["name"] == "Screener 2" and index["model-index"][0]["results"][0]["dataset"]["name"] == "Spring"
    assert "* 4,526 decisions read, 4,526 counted." in text and text.count(FILL_IN) == 2
    other = tmp_path / "other.json"
    other.write_text(berkeley(confidence=None, max_global_ratio=2).certificate.text)
    assert run("report", other, "--attestation", stated, "--format", "model-card") == 1
    assert "no report was written" in capsys.readouterr().err


def test_readers_of_model_cards_take_it() -> None:
    repocard = pytest.importorskip("huggingface_hub", reason="huggingface_hub is not installed")
    card = repocard.ModelCard(fa.report(berkeley(), format="model-card"))
    assert card.data.model_name.startswith(FILL_IN)
    found = {result.metric_type: result for result in card.data.eval_results}
    assert found["fairaudit-global-ratio"].metric_value == 1.467 and found["fairaudit-global-ratio"].verified is None
    assert found["fairaudit-local-ratio"].dataset_type == "decision-log"
    again = repocard.ModelCard(str(card))
    assert again.data.to_dict() == card.data.to_dict()
