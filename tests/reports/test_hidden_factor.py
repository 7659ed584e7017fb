"""Constructed factors leave what T14 says, with the table as it is."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.reports.hidden_factor import factors_text, just_enough
from fairaudit.theorems.t14 import HiddenContext, attaining, least_ratio

F = Fraction
NUMBERS = st.fractions(1, 8, max_denominator=9)
TITLE = "A constructed factor, which the table does not rule out"
AUDIT = '[law]\ntable = "log.csv"\ndecision = "u"\ngroup = "a"\ncount = "n"\nhidden_context = "2,2"\n[utility]\nvalues = { y = 1 }\n'


def audited(rows: list[int], utility: dict[str, int], **options: object) -> str:
    table = {"u": ["y", "n"] * 2, "a": ["f", "f", "m", "m"], "n": rows}
    return factors_text(fa.audit(table, decision="u", group="a", count="n", utility=utility, confidence=None, **options))


def test_the_example_of_the_theory() -> None:
    assert audited([30, 70, 20, 80], {"y": 1}, hidden_context="2,2") == (
        f"{TITLE}\n"
        "  local ratio: an unrecorded factor that 2/3 of a=f and 1/3 of a=m have\n"
        "    with it: a=f 0.36, a=m 0.3, a ratio of 1.2\n"
        "    without it: a=f 0.18, a=m 0.15, a ratio of 1.2\n"
        "  global ratio: an unrecorded factor that 2/3 of a=f and 1/3 of a=m have\n"
        "    with it: a=f 0.36, a=m 0.3, a ratio of 1.2\n"
        "    without it: a=f 0.18, a=m 0.15, a ratio of 1.2"
    )


def test_of_a_frontier_one_that_explains_the_ratio() -> None:
    assert "2/3 of a=f and 1/3 of a=m have\n    with it: a=f 0.4, a=m 0.4, a ratio of 1\n" in audited([30, 70, 20, 80], {"y": 1})


@pytest.mark.parametrize("options", [{"hidden_context": "2,2"}, {}])
def test_none_where_decisions_cannot_differ_so_much(options: dict[str, str]) -> None:
    """Nobody is worth less than 9/10 of anybody else, and all are worth about the same."""
    said = audited([90, 10, 10, 90], {"y": 10, "n": 9}, **options)
    assert said.count("none is constructed") == 2


def test_nothing_is_said_of_equal_groups_and_of_infinite_ratios() -> None:
    assert audited([1, 1, 1, 1], {"y": 1}, hidden_context="2,2") == audited([1, 1, 0, 2], {"y": 1}, hidden_context="2,2") == ""


@given(NUMBERS, NUMBERS, st.one_of(NUMBERS, st.just("inf")), st.sampled_from(["both", "higher", "lower"]))
def test_no_more_is_explained_than_the_whole_ratio(ratio: F, k: F, m: F | str, direction: str) -> None:
    declared = HiddenContext.of((k, m, direction))
    hidden = just_enough(ratio, declared)
    left = ratio * hidden.remaining
    assert left == least_ratio(ratio, declared) and hidden.k == k and 1 <= hidden.m <= declared.m
    one, other, worths = attaining(hidden)
    about = one if direction == "lower" else other
    mean = sum(p * worth for p, worth in zip(about, worths, strict=True))
    scaled = [worth / left if direction == "lower" else worth * left for worth in worths]
    beside = sum(p * worth for p, worth in zip(other if direction == "lower" else one, scaled, strict=True))
    assert (mean / beside if direction == "lower" else beside / mean) == ratio


@given(st.lists(st.integers(1, 30), min_size=4, max_size=4), st.sampled_from(["2,2", "3/2,3", "2,2,higher", "3/2,2,lower", "3,inf"]))
def test_what_is_printed_adds_up_to_the_table(rows: list[int], hidden: str) -> None:
    """Shares of those with and without it, times what they get, give what the groups get; nobody gets more than 1."""
    means = {"f": rows[0] / (rows[0] + rows[1]), "m": rows[2] / (rows[2] + rows[3])}
    for block in audited(rows, {"y": 1}, hidden_context=hidden).split("ratio: ")[1:]:
        if "none is constructed" in block:
            continue
        first, having, lacking = block.splitlines()[:3]
        for group, mean in means.items():
            share = re.search(rf"(\S+) of a={group}", first)
            assert share is not None
            part = {"all": F(1), "nobody": F(0)}.get(share[1]) if share[1] in ("all", "nobody") else F(share[1])
            got = [re.search(rf"a={group} ([0-9.]+)", line) for line in (having, lacking)]
            values = [0.0 if found is None else float(found[1]) for found in got]
            assert part is not None and all(0 <= value <= 1 for value in values)
            assert float(part) * values[0] + float(1 - part) * values[1] == pytest.approx(mean, rel=2e-3)


def test_by_the_option_and_by_the_key_of_an_audit_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("u,a,n\ny,f,30\nn,f,70\ny,m,20\nn,m,80\n")
    (tmp_path / "audit.toml").write_text(AUDIT)
    words = [str(tmp_path / "log.csv"), "--decision", "u", "--group", "a", "--count", "n", "--utility", "y", "--hidden-context", "2,2"]
    for asked in (words, [str(tmp_path / "audit.toml")]):
        assert main(["certify", *asked]) == 0
        assert TITLE not in capsys.readouterr().out
        assert main(["certify", *asked, "--show-completions", "--format", "text"]) == 0
        assert f"{TITLE}\n  local ratio: an unrecorded factor that 2/3 of a=f and 1/3 of a=m have\n" in capsys.readouterr().out
    assert main(["certify", *words[:-2], "--show-completions"]) == 2
    assert "with --hidden-context" in capsys.readouterr().err
