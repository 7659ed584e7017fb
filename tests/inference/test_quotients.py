"""Quotients over a box against its corners."""

from __future__ import annotations

from math import inf
from random import Random

from hypothesis import given
from hypothesis import strategies as st
from interval_oracle import (
    F,
    corner_ratios,
)

from fairaudit.inference.quotients import greatest_ratio, least_ratio


@given(st.data())
def test_linear_fractional_maximum_is_that_of_the_corners(data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 5))
    number = st.integers(0, 6).map(F)
    ends = [tuple(sorted(data.draw(st.tuples(number, number)))) for _ in range(n)]
    w, v = ({i: x for i in range(n) if (x := data.draw(number))} for _ in range(2))
    if not w or not v:
        return
    corners = corner_ratios(w, v, ends)
    found = greatest_ratio(tuple(w.items()), tuple(v.items()), ends)
    if inf in corners or not any(all(lo == 0 for i, (lo, _) in enumerate(ends) if i in form) for form in (w, v)):
        assert found == max(corners)
    assert found >= max(c for c in corners if c != inf)
    random = Random(0)
    for _ in range(20):
        h = [lo + (hi - lo) * F(random.randint(0, 4), 4) for lo, hi in ends]
        top, bottom = (sum((x * h[i] for i, x in form.items()), F(0)) for form in (w, v))
        value = (F(1) if top == 0 else inf) if bottom == 0 else top / bottom
        assert value <= max(found, 1)
        assert value >= min(least_ratio(tuple(w.items()), tuple(v.items()), ends), 1)
