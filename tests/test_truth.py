"""Equalized odds by both of its meanings: the paper's, within contexts, and the usual one, given the true label."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.report import html, markdown

NAME = "parity within contexts (the paper's equalized odds)"
LOG = {"hired": ["yes", "no", "yes", "yes", "no", "no"], "sex": list("ffmmfm"), "dept": list("ABABAB")}


@pytest.mark.parametrize("context", ["dept", None])
def test_the_papers_quantity_has_its_own_name_and_stands_only_beside_contexts(
    context: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = fa.certify(fa.Law.from_log(LOG, decision="hired", group="sex", context=context), {"yes": 1}, confidence=None)
    table = tmp_path / "log.csv"
    table.write_text("\n".join(",".join(row) for row in [tuple(LOG), *zip(*LOG.values(), strict=True)]) + "\n")
    saved = tmp_path / "certificate.json"
    options = ["--decision", "hired", "--group", "sex", *(["--context", context] if context else []), "--utility", "yes", "-o", str(saved)]
    assert main(["certify", str(table), *options]) == 0
    text = capsys.readouterr().out
    assert main(["compare", str(saved), str(saved)]) == 0
    compared = capsys.readouterr().out
    document = json.loads(saved.read_text())
    figures = markdown(document).split("###")[0]
    for shown in (text, compared, result._repr_html_(), figures, html(document).split("<table")[0].replace("&#39;", "'")):
        assert shown.casefold().count(NAME) == (1 if context else 0)
        assert "equalized odds" not in shown.casefold().replace(NAME, "")
    assert "equalized_odds" in document["metrics"]
