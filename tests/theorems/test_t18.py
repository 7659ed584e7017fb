"""T18: the ratio of a subgroup and the rest, and what no part of a subgroup can reach."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import inf

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fairaudit.theorems.t18 import refinements_below, subgroup_ratio

CLASSES = st.lists(
    st.tuples(st.integers(0, 4), st.integers(0, 3), st.integers(0, 4)), min_size=1, max_size=4, unique_by=lambda item: item[1]
)


@pytest.mark.parametrize(
    ("own", "expected"), [((20, 9), Fraction(1)), ((20, 8), Fraction(5, 4)), ((10, 7), Fraction(21, 11)), ((10, 2), Fraction(8, 3))]
)
def test_the_example_of_the_page(own: tuple[int, int], expected: Fraction) -> None:
    assert subgroup_ratio(*own, 40, 18)[0] == expected


def test_the_trap_of_the_page() -> None:
    assert subgroup_ratio(2, 2, 20, 4)[0] == 9
    assert subgroup_ratio(4, 4, 20, 4)[0] == inf
    assert not refinements_below([6, 4], [0, 1], 20, 4, 2, Fraction(10))


def best(inside: Sequence[int], outside: Sequence[int], values: Sequence[int], least: int) -> Fraction | float:
    """The greatest ratio over all parts of a subgroup, by how many rows of each value they take; 0 if there is none."""
    everybody = sum(inside) + sum(outside)
    total = sum(n * v for n, v in zip(inside, values, strict=True)) + sum(n * v for n, v in zip(outside, values, strict=True))
    found: Fraction | float = Fraction(0)
    for taken in product(*(range(n + 1) for n in inside)):
        j, part = sum(taken), sum(n * v for n, v in zip(taken, values, strict=True))
        if least <= j < everybody:
            own, rest = Fraction(part, j), Fraction(total - part, everybody - j)
            found = max(found, Fraction(1) if own == rest else max(own, rest) / min(own, rest) if min(own, rest) else inf)
    return found


@given(CLASSES, st.integers(1, 6), st.fractions(1, 8, max_denominator=6))
@example([(6, 0, 10), (4, 1, 0)], 2, Fraction(10))
@example([(2, 0, 0), (2, 1, 0)], 1, Fraction(5))
def test_what_is_left_out_is_what_cannot_reach_the_limit(classes: list[tuple[int, int, int]], least: int, limit: Fraction) -> None:
    classes = sorted(classes, key=lambda item: item[1])
    inside, values, outside = ([item[i] for item in classes] for i in range(3))
    everybody = sum(inside) + sum(outside)
    total = sum((a + b) * v for a, v, b in classes)
    if everybody:
        reached = best(inside, outside, values, least)
        assert refinements_below(inside, values, everybody, total, least, limit) == (reached < limit)
        assert refinements_below(inside, values, everybody, total, least, inf) == (reached < inf)
