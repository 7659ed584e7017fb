"""Bounds for products of tables, whose ordered pairs of rows are not enumerated: those that no other dominates give the same bounds."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from math import prod
from types import ModuleType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from seven_tables import TOTAL, outer_pairs, seven_tables

from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.privacy import trade_offs
from fairaudit.privacy.pairs import hockey_stick, pair_laws
from fairaudit.theorems import one_k, t03, t04, t10, t13_range, t17
from fairaudit.theorems.bound import Bound

F = Fraction
MODULES: tuple[ModuleType, ...] = (one_k, t03, t04, t10, t13_range, t17)


@st.composite
def factors(draw: st.DrawFn) -> Factor:
    """A table of whole weights, with zeros and equal rows."""
    inputs, outputs = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    rows = draw(st.lists(st.lists(st.integers(0, 4), min_size=outputs, max_size=outputs).filter(any), min_size=inputs, max_size=inputs))
    bottom = prod(map(sum, rows))
    exact = tuple(tuple(v * (bottom // sum(row)) for v in row) for row in rows)
    return Factor(tuple((str(i),) for i in range(inputs)), tuple((str(j),) for j in range(outputs)), exact, bottom)


LEVELS = st.sampled_from([F(1, 7), F(2, 5), F(1)])


@settings(max_examples=40, deadline=None)
@given(st.lists(factors(), min_size=1, max_size=3), LEVELS, st.sampled_from([F(0), F(1, 10)]), st.integers(1, 3))
def test_bounds_are_those_of_all_pairs(parts: list[Factor], level: Fraction, least: Fraction, releases: int) -> None:
    mechanism = Mechanism(tuple(parts))
    makers: list[Callable[[], Bound]] = [
        lambda: t03.t3_mechanism(mechanism, level),
        lambda: t04.t4(mechanism, 1, least, tau=max(least, level)),
        lambda: t10.t10_floor(mechanism, min(level, F(1, 2))),
        lambda: one_k.additive_bound("T1", mechanism, 1, level, F(1, 20), "declared", lambda top, _: top),
        lambda: one_k.additive_bound("T1", mechanism, 1, 0, 0, "declared", lambda top, _: top),
        lambda: t17.t17(mechanism, releases, m=least, gap="1/20", tau=max(least, level)),
        lambda: t17.t17(mechanism, releases, m=least, gap="1/20"),
    ]
    every = [make() for make in makers]
    end = t17.t17_without_end(mechanism, m=least, tau=level), t17.last_release(mechanism, 3, m=least, tau=level, most=6)
    with pytest.MonkeyPatch.context() as patch:
        for module in MODULES:
            patch.setattr(module, "worst_pair_laws", partial(trade_offs.worst_pair_laws, few=0))
        found = [make() for make in makers]
        assert end == (t17.t17_without_end(mechanism, m=least, tau=level), t17.last_release(mechanism, 3, m=least, tau=level, most=6))
    assert [bound.value for bound in found] == [bound.value for bound in every]
    for pair in pair_laws(mechanism):
        assert any(k + hockey_stick(pair, k) / level <= found[0].value for k in found[0].multipliers)


def test_a_product_of_many_tables_has_its_bound() -> None:
    mechanism = seven_tables()

    def power(both: tuple[list[int], list[int]]) -> Fraction:
        """By Neyman and Pearson, at the level 1/10."""
        gained, left = F(0), F(TOTAL, 10)
        for p, q in sorted(zip(*both, strict=True), key=lambda column: -F(*column)):
            part = min(F(1), left / q)
            gained, left = gained + part * p, left - part * q
        return gained / TOTAL

    worst = max(map(power, outer_pairs(mechanism)))
    assert t03.t3_mechanism(mechanism, "1/10").value == worst * 10
