"""Exact values on real tables, each worked out from the published counts."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from pathlib import Path

import pytest

from fairaudit import Law, Utility, certify, read_csv
from fairaudit.tables.examples import example

F = Fraction


@pytest.mark.parametrize(
    ("decision", "local", "overall"),
    [("Admitted", F(24475, 18432), F(2198330, 1498887)), ("Rejected", F(11268, 5225), F(3439098, 2739655))],
)
def test_berkeley(data: Path, decision: str, local: Fraction, overall: Fraction) -> None:
    table = read_csv(data / "ucb_admissions.csv")
    law = Law.from_counts(table, decision="Admit", group="Gender", context="Dept", count="Freq")
    result = certify(law, {decision: 1})
    assert (result.local.ratio, result.global_.ratio) == (local, overall)
    assert result.local.witness.context == {"Dept": "A"}


def test_embedded_berkeley_equals_the_published_counts(data: Path) -> None:
    def counts(table: object) -> dict[tuple[str, ...], str]:
        return dict(zip(zip(table["Dept"], table["Gender"], table["Admit"], strict=True), table["Freq"], strict=True))

    assert counts(example("ucb-admissions").table()) == counts(read_csv(data / "ucb_admissions.csv"))


def test_pandas_and_csv_agree(data: Path) -> None:
    import pandas as pd

    frame = pd.read_csv(data / "ucb_admissions.csv")
    options = {"decision": "Admit", "group": "Gender", "context": "Dept", "count": "Freq"}
    one, two = (certify(Law.from_counts(t, **options), {"Admitted": 1}) for t in (frame, read_csv(data / "ucb_admissions.csv")))
    assert one.certificate.text == two.certificate.text
    shown = one.to_frame()
    assert shown.shape == (12, 5)
    assert shown.set_index(["Dept", "Gender"]).loc[("A", "Female"), "expectation"] == F(89, 108)


@pytest.mark.parametrize(
    ("model", "local", "job", "overall"),
    [
        ("gpt-3.5-turbo", F(43, 19), "financial analyst", F(589, 428)),
        ("gpt-4", F(147, 103), "HR specialist", F(272, 223)),
        (None, F(43, 19), "financial analyst", F(557, 437)),
    ],
)
def test_resume_ranking(data: Path, model: str | None, local: Fraction, job: str, overall: Fraction) -> None:
    table = read_csv(data / "gpt_resume_first_counts.csv")
    keep = [i for i, m in enumerate(table["model"]) if model in (None, m)]
    part = {name: [table[name][i] for i in keep] for name in table.columns}
    context = "job" if model else ["model", "job"]
    law = Law.from_counts(part, decision="decision", group="group", context=context, count="n")
    result = certify(law, {"first": 1})
    assert (result.local.ratio, result.global_.ratio) == (local, overall)
    assert result.local.witness.context["job"] == job


@pytest.mark.parametrize(
    ("utility", "context", "local", "where", "overall"),
    [
        ({"maybe": 1, "yes": 1}, "model", F(3, 2), "claude-sonnet", F(471, 439)),
        ({"maybe": "0.5", "yes": 1}, "model", F(39, 28), "claude-haiku", F(305, 292)),
        ({"yes": 1}, "jd", inf, None, F(27086, 24497)),
    ],
)
def test_hiring_names(data: Path, utility: dict[str, object], context: str, local: object, where: str | None, overall: Fraction) -> None:
    law = Law.from_log(read_csv(data / "hiringbias_firstname.csv"), decision="recommend_interview", group="name", context=context)
    result = certify(law, Utility(utility))
    assert (result.local.ratio, result.global_.ratio) == (local, overall)
    assert where is None or result.local.witness.context == {context: where}
