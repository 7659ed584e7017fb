"""Tails of many draws, on either side of a level."""

import random
from itertools import product

import pytest
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
from plain_certificates import checker, make


@pytest.mark.parametrize("level", ["1/40", "1/3120", "1/1000000000"])
@pytest.mark.parametrize(
    ("n", "k"), [(1, 0), (1, 1), (2, 1), (40, 0), (40, 39), (300, 7), (1000, 800), (5000, 17), (5001, 2000), (10**8, 10**7)]
)
def test_tails_are_decided_on_either_side(n: int, k: int, level: str) -> None:
    """Of neighbours on a fine grid the checker accepts the one and not the other."""
    cell = cell_of([(k, F(1)), (n - k, F(0))], F(0), F(1), True)
    sample = checker.tails.Sample(n, F(k), F(k), F(0), F(1), True)
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
        sample = checker.tails.Sample(n, F(0), F(0), F(0), F(3), binary)
        for p in (F(1, 2), F(7, 8), F(999, 1000)):
            level = (1 - p) ** n
            assert checker.tails.tails_at_most([sample.tail(3 * p, True)], level)
            assert not checker.tails.tails_at_most([sample.tail(3 * p, True)], level * (1 - F(1, 10**100)))
            assert checker.tails.tails_at_most([sample.tail(3 * p, True)] * 2, level**2)
            assert not checker.tails.tails_at_most([sample.tail(3 * p, True)] * 2, level**2 * (1 - F(1, 10**100)))


def test_many_draws() -> None:
    """A hundred million draws in each of forty cells, by the quick bounds of both sides."""
    pick = random.Random(2)
    n = 10**8
    counts = {(x, a): pick.randint(30_000_000, 40_000_000) for x in range(20) for a in range(2)}
    weights = {cell: [str(k), str(n - k)] for cell, k in counts.items()}
    certificate = make(weights, ["1", "0"])
    cells, blocks = of_counts(certificate, "local", None, None)
    found = interval(cells, blocks)
    assert max(F(hi) - F(lo) for lo, hi in found["upper"]) <= F(3, GRID)
    full = with_interval(certificate, "local", found, "binomial")
    assert accepted(full)
    pick = random.Random(3)
    taken, refused = compare_readings(full, "local", from_counts(full, "local"), lambda changes: pick.sample(changes, 60))
    assert taken > 10 and refused > 10
