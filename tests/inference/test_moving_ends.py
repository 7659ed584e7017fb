"""Cells that drift and of which only ends are known: those that follow from the draws are found where they are asked for."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit import Law, Utility
from fairaudit.inference import quotients
from fairaudit.inference.moving_ends import MovingEnds, ends_that_hold
from fairaudit.inference.plain_ends import PlainEnds
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.theorems.t16 import drifted_extremes, law_radius

F = Fraction


@given(
    st.integers(0, 10**6),
    st.sampled_from([{"0": 1}, {"0": 1, "1": "0.3"}, {"0": "0.5", "2": 2}]),
    st.fractions(0, F(1, 4), max_denominator=50),
    st.sampled_from([F(1), F(5, 4), F(2), F(50)]),
)
@settings(max_examples=60)
def test_ends_found_where_they_are_asked_for_give_what_a_list_of_them_gives(
    seed: int, utility: dict[str, object], drift: Fraction, limit: Fraction
) -> None:
    pick = np.random.default_rng(seed)
    counts = pick.integers(0, 10 ** pick.integers(1, 6), (pick.integers(1, 6), pick.integers(2, 6), 3)) + 1
    law = Law.from_array(counts, kind="counts")
    comparison = local_comparison(law, Utility(utility).on(law))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quotients, "DECISIVE_CELLS", 0)
        interval = ratio_interval(comparison, "0.95", ends="each")
    both = ends_that_hold(interval, comparison)
    assert both is not None
    for ends, decided in zip(both, (interval.upper, interval.lower), strict=True):
        assert isinstance(ends, PlainEnds)
        lazy, listed = MovingEnds(comparison, ends), MovingEnds(comparison, [*ends])
        assert drifted_extremes(lazy, drift) == drifted_extremes(listed, drift)
        if (decided <= limit) is (ends is both[0]):
            assert law_radius(lazy, decided, limit, "ratio", "radius") == law_radius(listed, decided, limit, "ratio", "radius")
