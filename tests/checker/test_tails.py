"""Tails of many draws, on either side of a level."""

import random
from fractions import Fraction
from itertools import product
from math import log, sqrt
from typing import Any

import pytest
import tiers
from hypothesis import example, given
from hypothesis import strategies as st
from interval_certificates import (
    GRID,
    F,
    accepted,
    below,
    cell_of,
    compare_readings,
    first,
    from_counts,
    interval,
    of_counts,
    tail,
    with_interval,
)
from interval_oracle import ends_hold
from plain_certificates import checker, make


@pytest.mark.parametrize("level", ["1/40", "1/3120", "1/1000000000"])
@pytest.mark.parametrize(
    ("n", "k"), [(1, 0), (1, 1), (2, 1), (40, 0), (40, 39), (300, 7), (1000, 800), (5000, 17), (5001, 2000), (10**8, 10**7)]
)
def test_tails_are_decided_on_either_side(n: int, k: int, level: str) -> None:
    """Of neighbours on a fine grid the checker accepts the one and not the other."""
    cell = cell_of([(k, F(1)), (n - k, F(0))], F(0), F(1), True)
    sample = checker.tails.Sample(n, k, k, 0, 1, 1, True)
    for lower in (True, False):
        if k == (n if lower else 0):
            assert not checker.tails.tails_at_most([sample.tail(F(1, 2), lower)], F(level))
            continue
        steps = 2**30
        at = first(steps, lambda i: i == steps or below(tail(cell, F(i if lower else steps - i, steps), lower), F(level)))  # noqa: B023
        for i, holds in ((at, True), (at - 1, False)):
            mean = F(i if lower else steps - i, steps)
            assert checker.tails.tails_at_most([sample.tail(mean, lower)], F(level)) is holds


def test_a_tail_that_is_the_level() -> None:
    for n, binary in product((1, 2, 3, 30), (True, False)):
        sample = checker.tails.Sample(n, 0, 0, 0, 3, 1, binary)
        for p in (F(1, 2), F(7, 8), F(999, 1000)):
            level = (1 - p) ** n
            assert checker.tails.tails_at_most([sample.tail(3 * p, True)], level)
            assert not checker.tails.tails_at_most([sample.tail(3 * p, True)], level * (1 - F(1, 10**100)))
            assert checker.tails.tails_at_most([sample.tail(3 * p, True)] * 2, level**2)
            assert not checker.tails.tails_at_most([sample.tail(3 * p, True)] * 2, level**2 * (1 - F(1, 10**100)))


def test_many_draws() -> None:
    """A hundred million draws in each of forty cells, by the quick bounds of both sides."""
    pick = random.Random(tiers.fresh(2))
    n = 10**8
    counts = {(x, a): pick.randint(30_000_000, 40_000_000) for x in range(20) for a in range(2)}
    weights = {cell: [str(k), str(n - k)] for cell, k in counts.items()}
    certificate = make(weights, ["1", "0"])
    cells, blocks = of_counts(certificate, "local", None, None)
    found = interval(cells, blocks)
    assert max(F(hi) - F(lo) for lo, hi in found["upper"]) <= F(3, GRID)
    full = with_interval(certificate, "local", found, "binomial")
    assert accepted(full)
    pick = random.Random(tiers.fresh(3))
    taken, refused = compare_readings(full, "local", from_counts(full, "local"), lambda changes: pick.sample(changes, 60))
    assert taken > 10 and refused > 10


@st.composite
def ends_about_the_edge(draw: st.DrawFn) -> tuple[Any, dict[str, Any], tuple[Fraction, Fraction], Fraction]:
    """Draws in a range, ends on both sides of where a quick test stops to see that they are excluded, and a level."""
    n = draw(st.one_of(st.integers(1, 40), st.integers(1, 20_000)))
    binary = draw(st.booleans())
    unit = draw(st.sampled_from([1, 2, 6]))
    low, width = draw(st.integers(0, 3)), draw(st.integers(1, 7))
    successes = draw(st.one_of(st.sampled_from([0, n]), st.integers(0, n)))
    more = 0 if binary else draw(st.integers(0, min(width - 1, (n - successes) * width)))
    total = n * low + successes * width + more
    level = F(1, draw(st.sampled_from([2, 20, 80, 10**4, 10**9])))
    z = (successes * width + more) / (n * width)
    ends = []
    for side in (-1, 1):
        factor = draw(st.floats(0.5, 2))
        step = factor * sqrt(2 * log(1 / level) / n * max(z * (1 - z), 1 / n))
        digits = 10 ** draw(st.integers(1, 9))
        p = F(round((z + side * step) * digits), digits)
        p = draw(st.sampled_from([p, p, p, p, F(0), F(1), 1 - p, F(round(z * digits), digits)]))
        ends.append((low + p * width) / F(unit))
    sample = checker.tails.Sample(n, total, 0, low, low + width, unit, binary)
    cell = {"draws": n, "sum": F(total, unit), "range": [F(low, unit), F(low + width, unit)], "binary": binary}
    return sample, cell, (ends[0], ends[1]), level


@given(ends_about_the_edge())
@example((checker.tails.Sample(5, 0, 0, 0, 1, 1, True), {}, (F(0), F(0)), F(1, 20)))
@example((checker.tails.Sample(5, 5, 5, 0, 1, 1, True), {}, (F(1), F(1)), F(1, 20)))
@example((checker.tails.Sample(0, 0, 0, 0, 1, 1, True), {}, (F(0), F(1)), F(1, 20)))
@example((checker.tails.Sample(5, 0, 0, 0, 0, 1, True), {}, (F(0), F(0)), F(1, 20)))
def test_what_is_quickly_seen_is_true(drawn: tuple[Any, dict[str, Any], tuple[Fraction, Fraction], Fraction]) -> None:
    """No ends are taken quickly that exact tails refuse."""
    sample, cell, (lo, hi), level = drawn
    pairs = lo.as_integer_ratio(), hi.as_integer_ratio()
    if checker.tails.are_far(sample, pairs, checker.tails.reach_of(level)):
        assert cell and ends_hold(cell, lo, hi, level, "hoeffding-kl")


@pytest.mark.parametrize("n", [5000, 5001, 10**6])
@pytest.mark.parametrize("share", [F(3, 10), F(1, 2), F(7, 10)])
def test_ends_that_are_far_are_quickly_seen(n: int, share: Fraction) -> None:
    """Where the draws are many it takes a sixth more than the narrowest ends of their inequality; half of it is never enough."""
    k = int(n * share)
    sample = checker.tails.Sample(n, k, k, 0, 1, 1, True)
    level = F(1, 1000)
    reach = checker.tails.reach_of(level)
    assert log(1 / level) <= reach / 2**checker.tails.COARSE <= log(1 / level) * (1 + 1e-12)
    for factor, enough in ((F(1, 2), False), (F(7, 6), True)):
        radius = F(round(sqrt(2 * log(1 / level) * share * (1 - share) / n) * factor * 10**9), 10**9)
        ends = (F(k, n) - radius).as_integer_ratio(), (F(k, n) + radius).as_integer_ratio()
        assert checker.tails.are_far(sample, ends, reach) is enough


def test_the_ends_are_inside_the_range_and_on_their_sides() -> None:
    sample = checker.tails.Sample(100, 50, 50, 0, 1, 1, True)
    reach = checker.tails.reach_of(F(1, 20))
    assert checker.tails.are_far(sample, ((1, 10), (9, 10)), reach)
    assert checker.tails.are_far(sample, ((0, 1), (1, 1)), reach)
    for ends in (((9, 10), (9, 10)), ((1, 10), (1, 10)), ((9, 10), (1, 10)), ((-1, 10), (9, 10)), ((1, 10), (11, 10)), ((1, 1), (0, 1))):
        assert not checker.tails.are_far(sample, ends, reach)
