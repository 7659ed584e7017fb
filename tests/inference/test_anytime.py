"""Intervals of streams: what they exclude, estimates for a display, what is refused."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any

import pytest
from betting_oracle import by_definition, mirrored
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.inference.anytime import Arrivals, stream_interval, value_counts
from fairaudit.inference.levels import pair_levels, weight
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

F = Fraction


UNIT = (F(0), F(1))


def law_of(counts: list[list[int]]) -> Law:
    groups = [f"g{i}" for i in range(len(counts))]
    return Law.from_array(counts, kind="counts", decisions=["no", "half", "yes"][: len(counts[0])], groups=groups)


def found(counts: list[list[int]], joint: bool, exact: bool = True) -> Any:
    law = law_of(counts)
    utility = Utility({"half": "1/2", "yes": 1} if len(counts[0]) == 3 else {"half": 1}).on(law)
    arrivals = Arrivals(tuple(((), group) for group in law.groups), 4, joint)
    return stream_interval(law, utility, arrivals, "local", UNIT, "0.9", exact=exact)


rows = st.lists(st.integers(0, 60), min_size=3, max_size=3).filter(any)


@settings(max_examples=5, deadline=None)
@given(st.lists(rows, min_size=2, max_size=3))
def test_products_exclude_every_pair_of_means_outside_the_interval(counts: list[list[int]]) -> None:
    """The ends against their meaning: every pair of means with a quotient outside has a product of wealths of 1/level."""
    interval = found(counts, joint=True)
    cells = [{F(0): row[0], F(1, 2): row[1], F(1): row[2]} for row in counts]
    [levels] = pair_levels([list(range(1, len(cells) + 1))], 4, F(1, 10))
    grid = [F(k, 16) for k in range(1, 16)]
    above = [[by_definition(cell, p) for p in grid] for cell in cells]
    below = [[by_definition(mirrored(cell), 1 - p) for p in grid] for cell in cells]
    for (i, j), (k, p), (m, q) in ((a, b, c) for a in permutations(range(len(cells)), 2) for b in enumerate(grid) for c in enumerate(grid)):
        level = levels[frozenset((i, j))]
        if interval.upper < inf and p > interval.upper * q:
            assert below[i][k] * above[j][m] * level >= 1
    if interval.lower > 1:
        assert any(
            all(
                below[i][k] * above[j][m] * levels[frozenset((i, j))] >= 1
                for k, p in enumerate(grid)
                for m, q in enumerate(grid)
                if q < interval.lower * p
            )
            for i, j in permutations(range(len(cells)), 2)
        )


@settings(max_examples=20, deadline=None)
@given(st.lists(rows, min_size=2, max_size=3))
def test_the_ends_of_a_box_are_excluded(counts: list[list[int]]) -> None:
    interval = found(counts, joint=False)
    for rank, (row, (low, high)) in enumerate(zip(counts, interval.evidence["upper"], strict=True), 1):
        cell = {F(0): row[0], F(1, 2): row[1], F(1): row[2]}
        level = F(1, 10) * weight(rank, 4) / 2
        assert F(low) == 0 or by_definition(cell, F(low)) * level >= 1
        assert F(high) == 1 or by_definition(mirrored(cell), 1 - F(high)) * level >= 1
        assert F(low) == 0 or by_definition(cell, F(low) * F(1_001, 1_000)) * level < F(11, 10)  # and hardly more could be


@pytest.mark.parametrize("joint", [True, False])
@pytest.mark.parametrize(
    "counts", [[[100, 0], [0, 100]], [[3, 0], [2, 0]], [[900, 100], [850, 150], [10, 0]], [[10**7, 10**6], [10**7, 10**6]]]
)
def test_estimates_for_a_display_are_the_proved_ends(counts: list[list[int]], joint: bool) -> None:
    proved, shown = found(counts, joint), found(counts, joint, exact=False)
    assert float(proved.lower) == pytest.approx(float(shown.lower), rel=1e-3)
    assert float(proved.upper) == pytest.approx(float(shown.upper), rel=1e-3)


def test_many_groups_with_different_means_are_bounded_in_one_ladder() -> None:
    counts = [[900 - 60 * k, 100 + 60 * k] for k in range(10)]
    proved, shown = found(counts, True), found(counts, True, exact=False)
    assert proved.upper < 20
    assert float(proved.upper) == pytest.approx(float(shown.upper), rel=1e-3)
    assert float(proved.lower) == pytest.approx(float(shown.lower), rel=1e-3)


def test_products_are_narrower_and_say_what_they_assume() -> None:
    product, box = found([[300, 700], [500, 500]], True), found([[300, 700], [500, 500]], False)
    assert box.lower < product.lower < F(7, 5) < product.upper < box.upper
    assert any("everything recorded before" in text for text in product.assumptions)
    assert not any("everything recorded before" in text for text in box.assumptions)


def test_values_are_scaled_to_the_range() -> None:
    law = law_of([[2, 1, 1], [4, 0, 0]])
    utility = Utility({"half": 2, "yes": 3}).on(law)
    [block] = value_counts(law, utility, (F(0), F(4)), "local")
    assert [tally.counts for _, tally in block] == [{F(0): 2, F(1, 2): 1, F(3, 4): 1}, {F(0): 4}]
    with pytest.raises(InputError, match="outside the declared limits"):
        value_counts(law, utility, (F(0), F(2)), "local")


def test_nothing_compared_is_refused() -> None:
    log = {"a": ["f", "m"], "x": ["1", "2"], "u": ["yes", "no"]}
    law = Law.from_log(log, decision="u", group="a", context="x")
    arrivals = Arrivals(((("1",), ("f",)), (("2",), ("m",))))
    with pytest.raises(InputError, match="no two groups"):
        stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "local", UNIT)
    assert stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "global", UNIT).upper == inf
