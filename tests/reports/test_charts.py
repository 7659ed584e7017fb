"""Scales and marks of pages: round numbers, and marks where their values stand."""

from __future__ import annotations

import re
from fractions import Fraction
from math import inf, log

from hypothesis import given
from hypothesis import strategies as st

from fairaudit.reports.charts import from_one, linear, logarithmic, steps
from fairaudit.reports.words import Value

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


def positions(marks: str, kind: str, key: str) -> list[float]:
    return [float(x) for x in re.findall(rf'class="{kind}"[^>]* {key}="([0-9.]+)%"', marks)]


@given(low=NUMBERS, high=NUMBERS)
def test_a_scale_holds_what_it_is_made_for(low: float, high: float) -> None:
    axis = linear([low, high])
    shown = [value for value, _ in axis.ticks]
    assert shown == sorted(set(shown)) and 2 <= len(shown) <= 14
    for value in (low, high):
        slack = 1e-8 * (axis.high - axis.low)
        assert abs(value) > 1e289 or axis.low - slack <= value <= axis.high + slack
        assert 0 <= axis.at(value) <= 100


@given(values=st.lists(st.floats(1, allow_infinity=True, allow_nan=False), min_size=1, max_size=5))
def test_a_logarithmic_scale_begins_at_parity(values: list[float]) -> None:
    axis = logarithmic(values)
    assert axis.at(1) == 0 and axis.ticks[0] == (1, "1") and 1 <= len(axis.ticks) <= 11
    assert [axis.at(value) for value in sorted(values)] == sorted(axis.at(value) for value in values)


def test_marks_stand_at_their_values() -> None:
    axis = linear([Fraction(1, 2), Fraction(9, 10)], percent=True)
    assert (axis.low, axis.high) == (0, 1)
    marks = axis.track(
        dots=[(Value(Fraction(1, 4)), "first")], whiskers=[(0.2, 0.4)], limits=[0.5], rings=[0.75], lines=[0.1], bars=[(0.6, "bound")]
    )
    assert positions(marks, "dot first", "cx") == [25] and positions(marks, "before", "cx") == [75]
    assert positions(marks, "whisker", "x1") == [20] and positions(marks, "whisker", "x2") == [40]
    assert (
        positions(marks, "limit", "x1") == [50]
        and positions(marks, "line", "x1") == [10]
        and positions(marks, "bar bound", "width") == [60]
    )


def test_ratios_stand_at_their_logarithms() -> None:
    axis = logarithmic([4])
    assert abs(axis.at(2) - 100 * log(2) / log(axis.high)) < 0.01 and axis.at(inf) == 100
    both = logarithmic([4], both=True)
    assert both.at(1) == 50 and abs(both.at(2) + both.at(0.5) - 100) < 0.02 and both.at(0) == 0


def test_steps_are_round() -> None:
    assert steps(0, 0.37) == [0, 0.1, 0.2, 0.3, 0.4] and steps(0, 1e-9)[1] == 2e-10 and steps(3, 3) == [3, 4]
    assert from_one(1.2) == [1, 1.05, 1.1, 1.15, 1.2]
