"""What is said of further draws: what it would take if the truth were as measured, and no verdict that chance alone suggests."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from envelopes import envelope

import fairaudit as fa
from fairaudit.cli import main

YES = {"yes": 1}


def counts(f: tuple[int, int], m: tuple[int, int]) -> fa.Law:
    return fa.Law.from_array([[f[0], f[1]], [m[0], m[1]]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])


def test_noise_is_not_taken_for_truth() -> None:
    """Two groups with one and the same chance: whatever the draws look like, nobody is told that more of them would show "exceeds"."""
    pick = np.random.default_rng(5)
    seen = above = 0
    for _ in range(150):
        f, m = pick.binomial(40, 0.4, size=2).tolist()
        result = fa.certify(counts((f, 40 - f), (m, 40 - m)), YES, max_local_ratio="5/4")
        for _, planned in result.further_draws:
            seen += 1
            if result.intervals["local"].lower > 1:
                continue
            above += result.local.ratio > 1.25
            assert planned.decides != "exceeds"
            assert "exceeds" not in planned.sentence
            assert "if the truth were as measured" in planned.sentence or planned.total is None
            if result.local.ratio > 1.25:
                assert "do not exclude that all groups are equal" in planned.sentence and planned.total_if_equal > 0
    assert seen > 100 and above > 30


def test_equal_groups_need_as_many_as_is_said() -> None:
    """Fresh draws of two groups with the one mean that both have decide about as often as is said; a third of them seldom do."""
    (_, planned) = fa.certify(counts((20, 20), (13, 27)), YES, max_local_ratio="5/4").further_draws[0]
    assert planned.decides is None
    pick = np.random.default_rng(2)
    often = []
    for n in ((80 + planned.total_if_equal) // 2, (80 + planned.total_if_equal) // 6):
        drawn = pick.binomial(n, 33 / 80, (60, 2)).tolist()
        often.append(sum(fa.certify(counts((f, n - f), (m, n - m)), YES, max_local_ratio="5/4").verdict == "within" for f, m in drawn))
    assert often[0] == pytest.approx(48, abs=9) and often[1] < 24


def test_a_difference_that_is_established_may_be_expected_to_show() -> None:
    result = fa.certify(counts((210, 190), (150, 250)), YES, max_local_ratio="5/4")
    (_, planned) = result.further_draws[0]
    assert result.intervals["local"].lower > 1
    assert planned.decides == "exceeds" and planned.total_if_equal is None
    assert "would decide (exceeds) with probability 80 %" in planned.sentence and "group=f over group=m needs them" in planned.sentence
    assert "if the truth were as measured (a ratio of 1.4)" in planned.sentence


@pytest.mark.parametrize("times", [1, 5])
def test_units_are_counted_once(times: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Runs with rows in four cells, once or five times in each: what it takes is a number of runs, not of rows."""
    pick = np.random.default_rng(1)
    rows: list[tuple[Any, ...]] = [
        (run, x, a, "yes" if pick.random() < 0.5 else "no") for run in range(60) for x in "pq" for a in "fm" for _ in range(times)
    ]
    path = tmp_path / "log.csv"
    path.write_text("run,x,a,u\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
    columns = ["--decision", "u", "--group", "a", "--context", "x", "--unit", "run", "--utility", "yes"]
    assert main(["certify", str(path), *columns, "--max-local-ratio", "5/4", "--format", "json"]) == 3
    (planned,) = envelope(capsys.readouterr().out)["details"]["further_draws"]
    assert "further units of 'run'" in planned["sentence"]
    total = planned["total"] or planned["total_if_equal"]
    assert total > 0
    if planned["total"]:
        assert (
            planned["total"] <= max(planned["draws"]) + 1 and planned["pair_draws"] is None and sum(planned["draws"]) > 3 * planned["total"]
        )


@pytest.mark.parametrize("digits", [150, 155, 300, 320, 3000])
def test_utilities_beyond_floating_point_are_no_failure(digits: int) -> None:
    """The interval is exact at every size; only the estimate is in floating point."""
    law = fa.Law.from_counts(
        {"d": ["a", "b", "c"] * 2, "g": ["x"] * 3 + ["y"] * 3, "n": [5, 6, 7, 8, 9, 10]}, decision="d", group="g", count="n"
    )
    greatest = 10**digits
    found = fa.certify(law, {"a": greatest, "b": Fraction(greatest, 2)}, max_local_ratio=2)
    small = fa.certify(law, {"a": 1, "b": "1/2"}, max_local_ratio=2)
    assert found.local is not None and small.local is not None
    assert (found.local.ratio, found.verdict) == (small.local.ratio, small.verdict)
    assert found.intervals["local"].upper == pytest.approx(float(small.intervals["local"].upper), rel=1e-3)
    ((_, planned),) = found.further_draws
    assert (planned.total is None) is (digits > 300)
