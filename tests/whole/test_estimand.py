"""What a log with sampling units is judged by has a name: the mean over units; beside it stands the mean over rows."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from envelopes import envelope
from hypothesis import given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import schema
from fairaudit.certificates.compare import compare_documents as compare
from fairaudit.cli import main
from fairaudit.inference.hypothesis_tests import noise_floor
from fairaudit.inference.table_comparisons import local_comparison

F = Fraction


def lopsided(long: int = 3000, short: int = 3000) -> dict[str, list[Any]]:
    """Two groups whose persons answer alike, but for one who answers very often, always no."""
    rows: dict[str, list[Any]] = {"u": [], "a": [], "person": []}

    def add(person: int, group: str, decisions: list[str]) -> None:
        rows["u"] += decisions
        rows["a"] += [group] * len(decisions)
        rows["person"] += [person] * len(decisions)

    for i in range(2 * short):
        add(i, "fm"[i % 2], ["no" if i % 20 < 2 else "yes"])
    add(2 * short, "f", ["no"] * long)
    return rows


@cache
def result() -> fa.Result:
    law = fa.Law.from_log(lopsided(), decision="u", group="a", unit="person")
    return fa.certify(law, {"yes": 1}, max_local_ratio="5/4")


def accepted(document: dict[str, Any]) -> bool:
    return checker.check(json.dumps(document).encode()).ok


def test_both_means_stand_beside_the_interval() -> None:
    found = result()
    interval = found.intervals["local"]
    assert found.verdict == "within"
    assert interval.estimand == found.targets[0].estimand == "mean over units"
    # Of 3,001 units of f and 3,000 of m 2,700 said yes; f has 6,000 rows.
    assert interval.of_units.ratio == F(3001, 3000) and found.local.ratio == F(2)
    assert interval.of_units.witness.expectations == (F(9, 10), F(2700, 3001))
    assert any("2 as the mean over rows and 1 as the mean over units" in note for note in found.notes)
    document = found.certificate.document
    assert document["metrics"]["local"]["ratio"] == "2"
    stored = document["intervals"]["local"]
    assert (stored["estimand"], stored["measured"]["ratio"]) == ("mean over units", "3001/3000")
    assert document["targets"][0]["estimand"] == "mean over units"
    assert accepted(document)
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator(schema()).validate(document)


def test_text_page_and_markdown_show_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log.csv"
    path.write_text("u,a,person\n" + "".join(",".join(map(str, row)) + "\n" for row in zip(*lopsided().values(), strict=True)))
    command = ["certify", str(path), "--decision", "u", "--group", "a", "--unit", "person", "--utility", "yes", "--max-local-ratio", "5/4"]
    assert main([*command, "-o", str(tmp_path / "c.json"), "--verbose"]) == 0
    out, err = capsys.readouterr()
    first = out.splitlines()[0]
    assert first.startswith("WITHIN")
    assert "mean over units at least 1, at most 1.0" in first and "(1 in the table, and 2 as mean over rows)" in first
    assert "local ratio R, mean over units" in out and "the same, as mean over units" in out
    assert "2 as the mean over rows" in err
    assert main([*command, "--format", "json"]) == 0
    assert envelope(capsys.readouterr().out)["details"]["targets"][0]["estimand"] == "mean over units"
    assert main([*command, "--confidence", "none", "--verbose"]) == 1
    assert "(this table, mean over rows, decided exactly)" in capsys.readouterr().out
    document = json.loads((tmp_path / "c.json").read_text())
    from fairaudit.reports.markdown import markdown

    said = markdown(document)
    assert "(mean over units)" in said and "(mean over units, 1 in the table)" in said and ", mean over units |" in said
    assert main(["report", str(tmp_path / "c.json"), "-o", str(tmp_path / "page.html")]) == 0
    page = re.sub(r"<script.*?</script>", "", (tmp_path / "page.html").read_text(), flags=re.S)
    assert ", as mean over units:" in page and 'data-near="intervals.local.measured.ratio">1<' in page and "(mean over units)" in page


def test_without_units_nothing_is_new() -> None:
    rows = lopsided(1, 200)
    for unit in (None, "person"):  # with one row each, the mean over units is that over rows
        law = fa.Law.from_log(rows, decision="u", group="a", unit=unit)
        document = fa.certify(law, {"yes": 1}, max_local_ratio="5/4").certificate.document
        assert "estimand" not in json.dumps(document) and "measured" not in document["intervals"]["local"]
        assert accepted(document)


Change = Callable[[dict[str, Any]], Any]
FORGED: dict[str, Change] = {
    "another ratio": lambda d: d["intervals"]["local"]["measured"].update(ratio="2"),
    "another logarithm": lambda d: d["intervals"]["local"]["measured"].update(log=["0", "0"]),
    "the means over rows": lambda d: d["intervals"]["local"].update(measured=d["metrics"]["local"]),
    "another mean": lambda d: d["intervals"]["local"]["measured"]["witness"].update(expectations=["9/10", "1/2"]),
    "another pair": lambda d: d["intervals"]["local"]["measured"]["witness"].update(higher={"a": "f"}, lower={"a": "m"}),
}
MALFORMED: dict[str, tuple[Change, str]] = {
    "an interval of before": (lambda d: d["intervals"]["local"].pop("estimand"), 'intervals.local lacks the key "estimand"'),
    "without its figure": (lambda d: d["intervals"]["local"].pop("measured"), 'intervals.local lacks the key "measured"'),
    "no figure": (lambda d: d["intervals"]["local"].update(measured=None), "measured must not be null"),
    "a target of before": (lambda d: d["targets"][0].pop("estimand"), "targets[0] lacks the key 'estimand'"),
    "over rows": (lambda d: d["intervals"]["local"].update(estimand="mean over rows"), "intervals.local.estimand"),
    "without units": (lambda d: d["intervals"]["local"].pop("units"), 'unknown key "estimand"'),
    "of the table": (lambda d: d["targets"][0].update(judged="this table"), "targets[0] has the key 'estimand'"),
}


@pytest.mark.parametrize("change", FORGED)
def test_another_mean_over_units_is_false(change: str) -> None:
    document = json.loads(result().certificate.text)
    FORGED[change](document)
    checked = checker.check(json.dumps(document).encode())
    assert any(not f.true and f.statement.startswith("intervals.local:") and "measured" in f.detail for f in checked.findings)


@pytest.mark.parametrize("change", MALFORMED)
def test_what_is_estimated_must_be_said(change: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A certificate of before is refused in one sentence that names what is missing, and not called false."""
    document = json.loads(result().certificate.text)
    edit, words = MALFORMED[change]
    edit(document)
    path = tmp_path / "c.json"
    path.write_text(json.dumps(document))
    assert main(["verify", str(path)]) == 2
    out, err = capsys.readouterr()
    assert words in out + err and "FALSE" not in out + err


@settings(max_examples=40)
@given(st.data())
def test_the_mean_over_units_by_definition(data: st.DataObject) -> None:
    """Against the rows, unit by unit, for several contexts, groups and decisions; the checker agrees."""
    rows = data.draw(
        st.lists(
            st.tuples(st.sampled_from("pq"), st.sampled_from("fmo"), st.integers(0, 5), st.sampled_from("abc")), min_size=2, max_size=30
        )
    )
    if len({a for _, a, _, _ in rows}) < 2 or not {"a", "b"} & {u for *_, u in rows}:
        return
    table = {name: [str(row[i]) for row in rows] for i, name in enumerate(("x", "a", "unit", "u"))}
    worth = {"a": F(1), "b": F(1, 3), "c": F(0)}
    law = fa.Law.from_log(table, decision="u", group="a", context="x", unit="unit")
    found = fa.certify(law, {"a": 1, "b": "1/3"})
    cells: dict[tuple[str, str], dict[int, list[Fraction]]] = {}
    for x, a, unit, u in rows:
        cells.setdefault((x, a), {}).setdefault(unit, []).append(worth[u])
    several = any(len(own) > 1 for units in cells.values() for own in units.values())
    compared = [x for x in "pq" if sum(y == x for y, _ in cells) > 1]
    if not several or not compared:
        assert "local" not in found.intervals or found.intervals["local"].of_units is None
        return
    means = {place: sum(sum(own) / len(own) for own in units.values()) / len(units) for place, units in cells.items()}
    ratios = [
        F(1) if means[x, a] == means[x, b] else means[x, a] / means[x, b] if means[x, b] else float("inf")
        for x in compared
        for a in "fmo"
        for b in "fmo"
        if a != b and (x, a) in means and (x, b) in means
    ]
    assert found.intervals["local"].of_units.ratio == max(1, *ratios)
    assert accepted(found.certificate.document)


def test_other_findings_and_comparisons_name_it() -> None:
    law = fa.Law.from_log(lopsided(30, 60), decision="u", group="a", unit="person")
    comparison = local_comparison(law, fa.Utility({"yes": 1}).on(law))
    assert "The ratio of the groups (means over units) lies in" in noise_floor(comparison, comparison).sentence
    by_rows = fa.certify(fa.Law.from_log(lopsided(), decision="u", group="a"), {"yes": 1}, max_local_ratio="5/4")
    found = compare(by_rows.certificate.document, result().certificate.document)
    (local,) = [change for change in found.intervals if change.what == "local"]
    assert (local.direction, local.note[:46]) == ("changed", "about the mean over units instead of the mean ")
    assert any("judged by the mean over units" in change.note and change.direction == "worse" for change in found.targets)


def test_the_interval_covers_the_mean_over_units() -> None:
    """Persons who are asked more often get yes less often: intervals cover the mean over units, and miss the one over rows."""
    pick = np.random.default_rng(4)
    truth, missed, of_rows = 1.0, 0, 0
    for _ in range(25):
        table: dict[str, list[Any]] = {"u": [], "a": [], "person": []}
        for i in range(400):
            often = i % 2 == 0 and pick.random() < 0.2  # of group f one in five, who is asked 40 times
            times = 40 if often else 1
            chance = 0.1 if often else 0.6 if i % 2 == 0 else 0.5  # the mean over persons is 1/2 in both groups
            table["u"] += ["yes" if pick.random() < chance else "no" for _ in range(times)]
            table["a"] += ["fm"[i % 2]] * times
            table["person"] += [i] * times
        found = fa.certify(fa.Law.from_log(table, decision="u", group="a", unit="person"), {"yes": 1})
        interval = found.intervals["local"]
        missed += not float(interval.lower) <= truth <= float(interval.upper)
        of_rows += found.local.ratio > interval.upper
    assert missed <= 4 and of_rows > 12
