"""T14: what an unrecorded factor could explain, against exact linear programs, random factors, and the example of the page.

All 5,000 programs and 20,000 factors: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t14.py
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import inf
from random import Random
from typing import Any

import pytest
import tiers
from hypothesis import given
from hypothesis import strategies as st
from theorem_oracle import F, maximize, ratio

from fairaudit.errors import InputError
from fairaudit.theorems.t14 import HiddenContext, attaining, balanced_strength, frontier, least_change, least_ratio

PROGRAMS = 5_000 if tiers.FULL else 300
FACTORS = 20_000 if tiers.FULL else 2_000
DIRECTIONS = ("both", "higher", "lower")
STRENGTHS = (F(1), F(5, 4), F(2), F(3), F(7, 2), F(20))


def random_hidden(rng: Random) -> HiddenContext:
    m: Any = rng.choice((*STRENGTHS, inf))
    return HiddenContext(rng.choice(STRENGTHS), m, rng.choice(("both", "higher", "lower")))


def greatest_quotient(values: list[Fraction], k: Fraction, direction: str) -> Any:
    """The greatest Σ p·values over Σ q·values of two laws within k of each other, as a linear program; infinite where it has no bound."""
    n = len(values)
    nonnegative = []
    for v in range(n):
        p, q = ([F(int(i == v)) for i in range(n)] for _ in range(2))
        if direction in ("both", "higher"):
            nonnegative.append([*(-x for x in p), *(k * x for x in q), 0])  # p ≤ kq
        if direction in ("both", "lower"):
            nonnegative.append([*(k * x for x in p), *(-x for x in q), 0])  # q ≤ kp
    same_mass = [F(1)] * n + [F(-1)] * n + [F(0)]
    one = [F(0)] * n + values + [F(-1)]  # Σ q·values = 1, the mass being free
    least = maximize(2 * n, [F(0)] * n + [-v for v in values] + [0], [same_mass, [F(1)] * n + [F(0)] * n + [F(-1)]], nonnegative)
    if least == 0 and direction == "lower" and k > 1:  # the other group can get nothing where the first gets something
        return inf
    return maximize(2 * n, values + [F(0)] * n + [0], [same_mass, one], nonnegative)


def test_the_bound_is_the_optimum_of_a_linear_program() -> None:
    """Over all laws of a factor, for values of it that take both ends of what m allows, with ties, zeros, and values between."""
    rng = Random(tiers.fresh(14))
    for _ in range(PROGRAMS):
        hidden = random_hidden(rng)
        finite = isinstance(hidden.m, Fraction)
        low, high = (F(1), hidden.m) if isinstance(hidden.m, Fraction) else (F(0), F(1))
        values = [low, high, *(rng.choice((low, high, low + (high - low) * F(rng.randint(0, 4), 4))) for _ in range(rng.randint(0, 3)))]
        rng.shuffle(values)
        best = greatest_quotient(values, hidden.k, hidden.direction)
        seen = rng.choice([F(rng.randint(1, 30), rng.randint(1, 30)) + 1, F(1), inf])
        bound = least_ratio(seen, hidden)
        if best == inf:
            assert not finite and hidden.remaining == 0
            assert bound == 1
        else:
            assert best * hidden.remaining == 1
            assert bound == (inf if seen == inf else max(F(1), seen / best))


@pytest.mark.parametrize(("k", "m", "direction"), [*product(STRENGTHS, (*STRENGTHS, inf), DIRECTIONS)])
def test_a_factor_leaves_no_more_than_the_bound(k: Fraction, m: Any, direction: Any) -> None:
    """The witness: its laws and expectations keep what is declared, give the ratio that was seen, and leave exactly the bound."""
    hidden = HiddenContext(k, m, direction)
    p, q, values = attaining(hidden)
    assert sum(p) == sum(q) == 1
    for a, b in zip(p, q, strict=True):
        assert direction == "lower" or a <= k * b
        assert direction == "higher" or b <= k * a
    assert max(values) <= m * min(values) or m == inf
    if hidden.remaining == 0:
        return
    for left in (F(1), F(3, 2), F(7)):
        high, low = ([left * v for v in values], list(values))
        seen = ratio(sum(x * y for x, y in zip(p, high, strict=True)), sum(x * y for x, y in zip(q, low, strict=True)))
        both = [v for v in range(2) if p[v] and q[v]]
        assert max(ratio(high[v], low[v]) for v in both) <= left == least_ratio(seen, hidden)


def random_law(rng: Random, size: int, zeros: bool) -> list[Fraction]:
    weights = [0 if zeros and rng.random() < 0.2 else rng.randint(1, 9) for _ in range(size)]
    weights[rng.randrange(size)] += 1
    return [F(w, sum(weights)) for w in weights]


def needs_k(p: list[Fraction], q: list[Fraction]) -> Any:
    return max(ratio(a, b) for a, b in zip(p, q, strict=True))


def spread(values: list[Fraction]) -> Any:
    return ratio(max(values), min(values))


def test_no_random_factor_leaves_less_and_some_come_near() -> None:
    """Laws and expectations at random, zeros and values that one group never has included; k and m are what they turn out to need."""
    rng, tried, nearest = Random(tiers.fresh(15)), 0, inf
    while tried < FACTORS:
        size, sharp = rng.randint(2, 4), rng.random() < 0.3
        p, q = random_law(rng, size, zeros=True), random_law(rng, size, zeros=True)
        e, f = ([F(rng.choice((0, 1, 1, 2, 3, 5))) for _ in range(size)] for _ in range(2))
        if sharp:  # close to the witness
            k, m = rng.choice(STRENGTHS), rng.choice(STRENGTHS)
            (p, q, f), size = map(list, attaining(HiddenContext(k, m))), 2
            e = [F(rng.randint(1, 4)) * v for v in [f[0]] for _ in "1"] + [F(rng.randint(1, 4)) * f[1]]
        means = [sum(w * v for w, v in zip(law, values, strict=True)) for law, values in ((p, e), (q, f))]
        both = [v for v in range(size) if p[v] and q[v]]
        seen = ratio(*means)
        if not both or seen < 1:
            continue
        tried += 1
        left = max(max(ratio(e[v], f[v]), ratio(f[v], e[v])) for v in both)
        of_a, of_b = ([values[v] for v in range(size) if law[v]] for law, values in ((p, e), (q, f)))
        forward, backward = needs_k(p, q), needs_k(q, p)
        if max(forward, backward) < inf:
            m = min(spread(of_a), spread(of_b))
            bound = least_ratio(seen, HiddenContext(max(forward, backward), m))
            assert left >= bound
            nearest = min(nearest, left - bound)
        if forward < inf:
            assert left >= least_ratio(seen, HiddenContext(forward, spread(of_b), "higher"))
        if backward < inf:
            assert left >= least_ratio(seen, HiddenContext(backward, spread(of_a), "lower"))
    assert nearest < F(1, 10**4)


def test_m_of_the_other_group_is_not_enough_where_a_value_is_seen_in_one_alone() -> None:
    """The trap of the one-sided forms: P(v|a) ≤ 2 P(v|a'), a constant for a, and a' gets what it does where a never is."""
    p, q, e, f = [F(1), F(0)], [F(1, 2), F(1, 2)], [F(2), F(2)], [F(2), F(0)]
    seen = ratio(sum(x * y for x, y in zip(p, e, strict=True)), sum(x * y for x, y in zip(q, f, strict=True)))
    assert needs_k(p, q) == 2 and spread(e) == 1 and seen == 2
    assert ratio(e[0], f[0]) == 1 < least_ratio(seen, HiddenContext(F(2), F(1), "higher")) == 2


def test_the_example_of_the_page() -> None:
    assert least_ratio("3/2", "2,2") == F(6, 5)
    assert least_ratio("3/2", "2,2,higher") == F(9, 8)
    assert least_change(F(3, 2), F(2)) == 4
    assert least_ratio("3/2", "2,inf") == 1
    assert least_ratio("3", "2,inf") == F(3, 2)
    assert least_ratio(inf, "2,2") == inf
    assert least_ratio(inf, "2,inf,lower") == 1
    assert least_ratio(inf, "1,inf,lower") == inf


strengths = st.fractions(min_value=1, max_value=1000, max_denominator=500)
ratios = st.fractions(min_value=F(1001, 1000), max_value=10**12, max_denominator=10**6)


@given(strengths, strengths)
def test_both_forms_are_in_order(k: Fraction, m: Fraction) -> None:
    both, higher, lower = (HiddenContext(k, m, direction).remaining for direction in DIRECTIONS)  # type: ignore[arg-type]
    assert 0 < lower <= higher <= both <= 1


@given(ratios, st.fractions(min_value=1, max_value=50, max_denominator=50))
def test_a_frontier_is_exactly_what_is_too_weak(seen: Fraction, to: Fraction) -> None:
    if seen <= to:
        return
    found = frontier(seen, to)
    for k, m in found.pairs:
        assert k > found.excess and m > found.excess
        assert seen * HiddenContext(k, m).remaining == to
        assert seen * HiddenContext(k, m - F(1, 10**9)).remaining > to
        assert seen * HiddenContext(k - F(1, 10**9), m).remaining > to
    assert len(found.pairs) == (4 if seen / to <= 10**9 else 0)
    b = found.balanced
    assert isinstance(b, Fraction)
    assert seen * HiddenContext(b, b).remaining >= to
    more = b + F(1, 10**6)
    assert seen * HiddenContext(more, more).remaining < to


def test_nothing_explains_what_one_group_never_gets() -> None:
    assert balanced_strength(inf) == inf
    assert frontier(inf).pairs == ()
    assert least_change(F(2), F(2)) == least_change(F(2), F(3, 2)) == inf


@pytest.mark.parametrize("given_", ["2", "2,3,up", "1/2,3", "3,1/2", "inf,2", "2,3,both,1", 2, ("x", "2"), ()])
def test_what_is_no_hidden_context_is_refused(given_: Any) -> None:
    with pytest.raises(InputError, match=r"hidden_context|accepted|number"):
        HiddenContext.of(given_)
