"""T1: any utility, a floor under the expected utilities."""

from __future__ import annotations

from fractions import Fraction
from math import inf

import pytest
from theorem_oracle import F, deployments, proved, pure, random_row, ratio, stick, table_filter, worst_stick

from fairaudit.model.mechanism import Identity, RandomizedResponse
from fairaudit.theorems.t01 import floor_cap, t1, t1_paper, t1_tight


@pytest.mark.parametrize("uses", ["group", "context", "decision"])
def test_the_ratio_never_exceeds_the_bound_and_a_multiplier_proves_every_pair(uses: str) -> None:
    finite = 0
    for _, d in deployments(250, uses=uses):
        gap, gamma, tau = d.gap, d.gamma, d.floor
        bound = t1(d.mechanism, gamma, tau, gap)
        assert d.local <= bound.value
        if tau == 0:
            assert bound.value == (pure(d.rows_a) if gap == 0 else inf)
            continue
        finite += 1
        assert bound.value <= floor_cap(gamma, tau).value
        assert proved(
            bound, d.rows_a, lambda p, q, k, c=(gap, gamma, tau): c[1] / c[2] if k == 0 else k + (c[0] + c[1] * stick(p, q, k)) / c[2]
        )
        candidates = {F(0), *(v / w for p in d.rows_a for q in d.rows_a for v, w in zip(p, q, strict=True) if w)}
        best = max(
            (min(k + (gap + gamma * stick(p, q, k)) / tau for k in candidates) for p in d.rows_a for q in d.rows_a if p is not q),
            default=F(1),
        )
        assert bound.value == min(gamma / tau, best)
    assert finite > 80


def test_the_forms_in_epsilon_and_delta_hold_and_are_ordered() -> None:
    for rng, d in deployments(250):
        k = rng.choice([F(1), F(3, 2), F(2), F(4)])
        delta, tau = worst_stick(d.rows_a, k), d.floor
        exact, tight, paper = t1(d.mechanism, d.gamma, tau, d.gap), *(f(k, delta, d.gamma, tau, d.gap) for f in (t1_tight, t1_paper))
        assert d.local <= exact.value <= tight.value <= paper.value
        if tau:
            assert all(d.expectation(x, a) <= k * d.expectation(x, b) + d.gap + delta * d.gamma
                       for x in d.contexts for a in d.groups for b in d.groups if a != b)  # fmt: skip


def test_a_metric_gives_each_pair_its_own_gap() -> None:
    for _, d in deployments(120):
        names = [tuple(str(part) for part in label) for label in d.mechanism.inputs]

        def gap(first: tuple[str, ...], second: tuple[str, ...], d=d, names=names) -> Fraction:  # type: ignore[no-untyped-def]
            a, b = names.index(first), names.index(second)
            return max(abs(block[a][u] - block[b][u]) for block in d.utility for u in d.decisions)

        if not d.floor:
            continue
        own, common = t1(d.mechanism, d.gamma, d.floor, gap), t1(d.mechanism, d.gamma, d.floor, d.gap)
        assert d.local <= own.value <= common.value


def test_without_privacy_the_cap_remains() -> None:
    assert t1(Identity(["a", "b"]), 2, "0.5").value == 4
    assert t1_tight(inf, 1, 2, "0.5").value == 4
    assert t1_tight(inf, 1, 2, "0.5").multipliers == (0,)


def test_a_floor_of_zero_bounds_nothing_unless_the_filter_is_pure() -> None:
    coin = RandomizedResponse(["a", "b"], keep_probability="0.6")
    assert t1(coin, 1, 0).value == F(3, 2)
    assert t1(coin, 1, 0).scope == "any policy behind this filter"
    for bound in (t1(coin, 1, 0, "0.1"), t1_tight(2, "0.1", 1, 0), t1_tight(2, 0, 1, 0, "0.1"), t1(Identity(["a", "b"]), 1, 0)):
        assert bound.value == inf
        assert bound.note


def test_the_floor_is_needed_at_the_denominator() -> None:
    """A floor under the favoured group alone proves nothing: the other group gets almost nothing, and the ratio is far above."""
    rows = [[F(1), F(0)], [F(1, 100), F(99, 100)]]
    means = [rows[0][0], rows[1][0]]
    assert ratio(means[0], means[1]) == 100
    assert t1(table_filter(rows), 1, means[0]).value == 1
    assert t1(table_filter(rows), 1, min(means)).value >= 100


def test_scopes_follow_the_origin_of_the_floor() -> None:
    coin = RandomizedResponse(["a", "b"], keep_probability="0.6")
    assert t1(coin, 1, "0.3").scope == "this law"
    declared = t1(coin, 1, "0.3", floor="declared")
    assert declared.scope == "any policy behind this filter that keeps the declared floor"
    assert "every compared group's expected utility is at least 3/10 behind the filter (declared)" in declared.assumptions
    assert (
        t1_tight(2, 0, 1, "0.3", floor="policy").scope
        == "this policy and context filter, any group filter at most this epsilon that releases the same values"
    )
    assert any("fresh for each decision" in sentence for sentence in declared.assumptions)


def test_the_floor_of_the_policy_survives_every_filter() -> None:
    seen = 0
    for rng, d in deployments(200):
        floor = d.policy_floor
        e, gamma, gap = pure(d.rows_a), d.gamma, d.gap
        if not floor or e == inf:
            continue
        seen += 1
        bound = t1_tight(e, 0, gamma, floor, gap, floor="policy")
        assert bound.scope == "this policy and context filter, any group filter at most this epsilon that releases the same values"
        for _ in range(4):
            d.rows_a = [random_row(rng, len(d.rows_a[0])) for _ in d.groups]
            if pure(d.rows_a) <= e or rng.random() < 0.3:
                assert d.floor >= floor
            if pure(d.rows_a) <= e:
                assert d.local <= bound.value
    assert seen > 30
