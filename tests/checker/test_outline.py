"""What is said of a certificate in short: a limit on each side, of whom it holds, and nothing of narrower scopes that wider ones imply."""

from __future__ import annotations

from pathlib import Path

import fairaudit as fa
from fairaudit import checker
from fairaudit.checker.summary import paragraph
from fairaudit.cli import main

COUNTS = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}


def said_of(result: fa.Result) -> str:
    return paragraph(checker.check(result.certificate.text.encode()))


def test_published_counts() -> None:
    """Berkeley, 1973: 89 of 108 and 512 of 825 in department A, 1,198 of 2,691 and 557 of 1,835 overall."""
    law = fa.Law.from_counts(fa.example("ucb-admissions").table(), decision="Admit", group="Gender", context="Dept", count="Freq")
    said = said_of(fa.certify(law, {"Admitted": 1}, max_local_ratio="5/4", confidence=None))
    assert "The target that the worst ratio within a context is at most 5/4 (1.25) is exceeded in the table." in said
    assert f"The worst ratio within a context is {89 / 108 / (512 / 825):.4g} in the table." in said
    assert f"The worst ratio overall is {1198 / 2691 / (557 / 1835):.4g} in the table." in said
    assert "The figures for later updates rest on one assumption " in said and said.count("rests on none") == 1


def test_without_contexts_one_ratio_is_said_once() -> None:
    said = said_of(fa.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes", confidence=None))
    assert said.count("1.5 in the table") == 1 and "The worst ratio is 1.5 in the table." in said
    assert "It is about the table alone and rests on no assumptions." in said


def test_differences_have_their_name() -> None:
    said = said_of(fa.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes", max_difference="1/3", confidence=None))
    assert "The target that the worst difference is at most 1/3 (0.3333) is kept in the table." in said
    assert "The worst difference is 0.25 in the table." in said


def test_policies_are_said_to_the_widest_extent(tmp_path: Path) -> None:
    """What holds of any policy behind a filter is not said again of those that keep a floor, where that is no better."""
    assert main(["certify", "--example", "hr-filtered", "-o", str(tmp_path / "c.json")]) == 0
    said = paragraph(checker.check((tmp_path / "c.json").read_bytes()))
    assert "up to 2.334 for any policy behind this filter;" in said
    assert "2.334 for any policy behind this filter that keeps the declared floor" not in said
    assert "those for any policy behind this filter that keeps the declared floor rest on" in said


def test_of_a_class_the_figures_of_the_table_are_said_to_be_those_of_one_utility(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("u,a\n" + "yes,f\n" * 8 + "no,f\n" * 2 + "yes,m\n" * 4 + "no,m\n" * 6)
    words = ["worst-case", str(tmp_path / "t.csv"), "--decision", "u", "--group", "a", "--tau", "0.2", "-o", str(tmp_path / "c.json")]
    assert main(words) == 0
    said = paragraph(checker.check((tmp_path / "c.json").read_bytes()))
    assert "for every utility of the class" in said
    assert "A class of utilities is stated; what is said of the table is said of the one utility that the certificate holds." in said
    plain = said_of(fa.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes", confidence=None))
    assert "class of utilities" not in plain
