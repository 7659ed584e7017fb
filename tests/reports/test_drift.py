"""What reports say of drift: radii and ranges as the claims have them, pictures of the theorem's values, updates that attain them."""

from __future__ import annotations

import json
import random
import re
from fractions import Fraction
from math import inf, isfinite
from typing import Any
from xml.etree import ElementTree

import pytest
from certificate_kinds import admissions
from certificates import drifting

import fairaudit as fa
from fairaudit.audits.drift import TableRadius
from fairaudit.certificates.reader import number, subject
from fairaudit.cli import main
from fairaudit.reports.content import describe
from fairaudit.reports.drift import Standing, standings
from fairaudit.reports.drift_text import radius_lines
from fairaudit.reports.markdown import markdown
from fairaudit.reports.page import html

HEADING = "How much may change before this verdict falls"


def made(rows: list[list[Any]], limit: str, names: tuple[str, ...] = ("f", "m"), **options: Any) -> fa.Result:
    law = fa.Law.from_array(rows, kind="probabilities", decisions=["yes", "no"], groups=list(names), columns=fa.Columns("hired", ("sex",)))
    return fa.certify(law, {"yes": 1}, max_local_ratio=limit, **options)


def shown(result: fa.Result) -> list[Standing]:
    document = result.certificate.document
    return standings(document, subject(document), {})


def moved_ratio(law: fa.Law, eta: Fraction, *, worst: bool) -> Fraction | float:
    """R by definition where one of two decisions counts: the theorem's ends, pair by pair."""
    best: Fraction | float = Fraction(1)
    means = [(int(x), Fraction(law.row(c)[0], sum(law.row(c)))) for c, x in enumerate(law.cell_context.tolist())]
    sign = 1 if worst else -1
    for x, p in means:
        for y, q in means:
            if x == y:
                top, bottom = (min(max(v, Fraction(0)), Fraction(1)) for v in (p + sign * eta, q - sign * eta))
                best = max(best, top / bottom if bottom else (inf if top else Fraction(1)))
    return best


@pytest.mark.parametrize("seed", range(6))
def test_every_certificate_about_drift_has_a_section_with_a_picture(seed: int) -> None:
    document = json.loads(drifting(random.Random(seed)).text)
    page, text, found = html(document), markdown(document), describe(document).drifting
    radii = [claim for claim in document["claims"] if claim["by"] == "T16" and claim["quantity"].endswith("_radius")]
    assert bool(found) == (HEADING in page) == (HEADING in text)
    assert [one.mark for one in found if one.radius] == [number(claim["value"]) for claim in radii]
    for one in found:
        assert one.picture
        ElementTree.fromstring(f"<figure>{one.picture}</figure>")  # noqa: S314
        assert page.count(one.picture) == found.count(one)


@pytest.mark.parametrize("options", [{}, {"max_drift": "1/100"}])
def test_the_picture_has_the_values_of_the_theorem(options: dict[str, str]) -> None:
    result = admissions(max_local_ratio=2, confidence=None, **options)
    local = next(one for one in shown(result) if not one.overall)
    assert float(local.mark) in [eta for eta, _, _ in local.points]
    for eta, worst, best in local.points:
        at = next(e for i in range(41) if float(e := min(Fraction(1), 2 * Fraction(local.mark)) * Fraction(i, 40)) == eta)
        assert (worst, best) == tuple(float(moved_ratio(result.law, at, worst=w)) for w in (True, False))


def test_at_the_radius_the_curve_meets_the_limit() -> None:
    for limit, column in (("2", 1), ("10/9", 2)):
        one = shown(made([["1/2", "1/2"], ["2/5", "3/5"]], limit))[0]
        at = next(point for point in one.points if point[0] == float(one.mark))
        assert at[column] == float(Fraction(limit))


def test_updates_are_those_that_attain_it() -> None:
    one = shown(made([["1/2", "1/2"], ["2/5", "3/5"]], "2"))[0]
    assert one.mark == Fraction(1, 10)
    (title, cells), _ = one.updates
    assert title == "it changes with a little more than 10 % of the decisions"
    assert cells == ("in sex=f: yes from 50 % to 60 %", "in sex=m: yes from 40 % to 30 %")
    down = shown(made([["1/2", "1/2"], ["2/5", "3/5"]], "10/9"))[0]
    (title, cells), _ = down.updates
    rates = [Fraction(rate) / 100 for cell in cells for rate in re.findall(r"to ([\d.]+) %", cell)]
    assert title.startswith("the last pair comes down to the limit with 2.631 % ")
    assert abs(float(rates[0] / rates[1]) - 10 / 9) < 1e-3
    ends = shown(made([["1/2", "1/2"], ["2/5", "3/5"]], "2", max_drift="1/20"))[0]
    assert ends.updates[0] == ("for the greatest ratio, 1.571", ("in sex=f: yes from 50 % to 55 %", "in sex=m: yes from 40 % to 35 %"))


def test_a_verdict_that_no_update_changes_has_no_mark() -> None:
    law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    one = shown(fa.certify(law, {"yes": 1, "no": "1/2"}, max_local_ratio=2))[0]
    assert one.mark == inf and one.updates == () and 'class="here"' not in one.picture
    assert one.points[-1][:2] == (1.0, 2.0)


def test_infinite_ratios_leave_the_picture() -> None:
    one = shown(made([["1/2", "1/2"], [0, 1]], "2"))[0]
    assert not isfinite(one.points[0][1]) and "inf" not in one.picture.replace("infinite", "") and "nan" not in one.picture


def test_of_a_population_the_picture_begins_at_the_ends_of_the_interval() -> None:
    result = admissions(max_local_ratio=3)
    document = result.certificate.document
    one = next(one for one in describe(document).drifting if not one.overall)
    low, high = (float(Fraction(end)) for end in document["intervals"]["local"]["ratio"])
    assert one.points[0][1] <= high and one.points[0][2] >= low and one.points[0][1:] == pytest.approx((high, low), rel=1e-6)
    assert one.updates == () and "the population behind the decisions" in one.title


def test_without_a_table_there_are_words_alone() -> None:
    document = made([["1/2", "1/2"], ["2/5", "3/5"]], "2").certificate.document
    (one,) = standings(document, None, {})
    assert one.picture == "" and one.updates == () and "more than 10 %" in one.lines[0]


def test_labels_are_escaped() -> None:
    result = made([["1/2", "1/2"], ["2/5", "3/5"]], "2", ("<script>alert(1)</script>", "\u202em" + "w" * 5000))
    page = html(result.certificate)
    section = page[page.index('id="drift"') : page.index('id="left-out"')]
    assert "<script>" not in section and "\u202e" not in section and "w" * 500 not in section
    assert "<script>alert" not in markdown(result.certificate)


def test_the_last_of_several_pairs_above_the_limit_is_named_as_that() -> None:
    pair = ({}, {"sex": "f"}, {"sex": "m"})
    other = ({}, {"sex": "m"}, {"sex": "f"})
    found = TableRadius("exceeds", Fraction(1, 50), True, Fraction(5, 4), True, pair, other, of_population=False)
    lines = [*radius_lines(found, "local")]
    assert lines[1:] == [
        "the last pair above the limit: sex=f against sex=m",
        "the last pair above the limit by a factor: sex=m against sex=f",
    ]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ("--confidence", "none"),
            "it changes with a little more than 1.586 % of the decisions\n    in Dept=F, Gender=Female: Admitted from 7.038 %",
        ),
        (
            ("--confidence", "none", "--max-drift", "0.01"),
            "for the least ratio, 1.291\n    in Dept=A, Gender=Female: Admitted from 82.41 % to 81.41 %",
        ),
        ((), "are constructed of verdicts on the table"),
    ],
)
def test_the_command_prints_updates(options: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["certify", "--example", "ucb-admissions", "--max-local-ratio", "3" if not options else "2", "--format", "text"]
    assert main([*asked, *options, "--show-completions"]) == 0
    assert said in capsys.readouterr().out
    assert main([*asked, *options]) == 0
    assert said not in capsys.readouterr().out
