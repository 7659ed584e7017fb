"""T12: pure privacy contracts the policy's own ratio."""

from __future__ import annotations

from fractions import Fraction
from math import inf

import pytest
from theorem_oracle import F, deployments, pure, random_row, ratio

from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t12 import t12


@pytest.mark.parametrize("uses", ["context", "decision"])
def test_no_deployment_exceeds_the_contraction(uses: str) -> None:
    for _, d in deployments(300, uses=uses):
        raw: Fraction | float = F(1)
        for x in d.contexts:
            responses = [d.response(x, released, 0) for released in range(len(d.rows_a[0]))]
            raw = max(raw, ratio(max(responses), min(responses)))
        e = pure(d.rows_a)
        bound = t12(e, raw)
        assert d.local <= bound.value <= min(t2(e).value, raw)
        assert bound.scope == "this policy and context filter, any group filter at most this epsilon that releases the same values"


@pytest.mark.parametrize(("e", "raw"), [(F(2), F(3)), (F(1), F(5)), (F(7, 3), F(1)), (F(100), F(10**6))])
def test_attained_by_two_values(e: Fraction, raw: Fraction) -> None:
    """Two released values with responses R0 and 1, and randomized response between them."""
    keep = e / (1 + e)
    means = [keep * raw + (1 - keep), (1 - keep) * raw + keep]
    assert ratio(*means) == t12(e, raw).value == (1 + raw * e) / (raw + e)


def test_attained_without_a_floor() -> None:
    e = F(3)
    means = [e / (1 + e), 1 / (1 + e)]
    assert ratio(*means) == t12(e, inf).value == e


def test_hyperbolic_tangents_multiply() -> None:
    for e, raw in ((F(2), F(3)), (F(5, 4), F(9))):
        value = t12(e, raw).value
        assert (value - 1) / (value + 1) == (e - 1) / (e + 1) * (raw - 1) / (raw + 1)


def test_ends() -> None:
    assert t12(inf, 4).value == 4
    assert t12(4, inf).value == 4
    assert t12(inf, inf).value == inf
    assert t12(inf, inf).note
    assert t12(inf, 4).multipliers == ()


def test_the_contraction_is_of_the_released_values_and_not_of_the_groups() -> None:
    """With fewer released values reachable the ratio over the groups alone would be too small a start."""
    shown = 0
    for rng, d in deployments(200, uses="decision"):
        size = len(d.rows_a[0])
        if size < 3:
            continue
        responses = [F(1)] * (size - 1) + [F(9)]
        two = [random_row(rng, size, zeros=False) for _ in range(2)]
        means = [sum(p * h for p, h in zip(row, responses, strict=True)) for row in two]
        partial = ratio(max(responses[:2]), min(responses[:2]))
        reached = max(ratio(means[0], means[1]), ratio(means[1], means[0]))
        assert reached <= t12(pure(two), 9).value
        shown += reached > t12(pure(two), partial).value
    assert shown
