"""Which draws show that a ratio is less than a limit, against the exact rules."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from interval_oracle import F, binary, bounded, one_block

from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.cells import Cell
from fairaudit.inference.ends import cell_ends
from fairaudit.inference.float_tails import float_ends, float_tail, float_tails
from fairaudit.inference.levels import product_levels
from fairaudit.inference.pair_exact import Pair, order_scale, pair_excludes
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.rejections import Rejects, Supposed, by_boxes, by_contrasts, by_pairs, by_products, end_of_sums
from fairaudit.inference.symmetric_betting import upper_end

LEVEL = F(1, 20)


def cell(draws: int, share: float) -> Supposed:
    return Supposed(draws, share, sqrt(share * (1 - share)), 0.0, 1.0, True)


def one(rejects: Rejects, k: int, n: int, other: int, m: int, limit: float) -> bool:
    """Whether a table rejects, with the cells supposed as it has them."""
    shares = (k + 0.5) / (n + 1), (other + 0.5) / (m + 1)
    first, second = cell(n, shares[0]), cell(m, shares[1])
    return bool(rejects(first, np.array([float(k)]), second, np.array([float(other)]), limit)[0])


tables = st.integers(5, 120).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@given(tables, tables, st.sampled_from([F(1, 20), F(1, 400)]), st.integers(11, 40))
def test_a_staircase_is_that_of_the_exact_bound(table: tuple[int, int], other: tuple[int, int], level: Fraction, tenths: int) -> None:
    """Where the exact bound decides at limits a tenth on either side alike, the floats decide as it does."""
    limit = F(tenths, 10)
    pair = Pair(*table, *other, order_scale(level))
    below, above = (pair_excludes(pair, limit * times, level) is not None for times in (F(9, 10), F(11, 10)))
    if below == above:
        assert one(by_pairs(level), *table, *other, float(limit)) == above


@given(tables, tables, st.integers(11, 40))
def test_the_box_is_that_of_the_ends(table: tuple[int, int], other: tuple[int, int], tenths: int) -> None:
    limit = F(tenths, 10)
    high = cell_ends(binary(table[1], table[0]), LEVEL)[1]
    low = cell_ends(binary(other[1], other[0]), LEVEL)[0]
    if abs(high - limit * low) > 1e-5:
        assert one(by_boxes(float(LEVEL), "hoeffding-kl"), *table, *other, float(limit)) == (high <= limit * low)


@pytest.mark.parametrize(("k", "other"), [(60, 60), (75, 60), (30, 80), (95, 90)])
def test_the_product_is_that_of_its_ladder(k: int, other: int) -> None:
    """The upper end of two cells: floats reject a limit a little above it, and none a little below."""
    compared = one_block(binary(100, k), binary(110, other))
    levels = product_levels(2, 2, LEVEL, "each").upper
    assert levels is not None
    rule = by_products(*map(float, levels))
    upper = float(ratio_interval(compared, region="product", independent=True, ends="each").upper)
    found = [max(one(rule, k, 100, other, 110, upper * t), one(rule, other, 110, k, 100, upper * t)) for t in (1.04, 0.96)]
    both = [one(rule, k, 100, other, 110, upper * t) and one(rule, other, 110, k, 100, upper * t) for t in (1.04, 0.96)]
    assert both == [True, False] and found[0]


@given(
    st.lists(st.sampled_from([F(0), F(1, 4), F(1, 2), F(1)]), min_size=4, max_size=60),
    st.sampled_from(["hoeffding-kl", "empirical-bernstein", "intersection"]),
)
def test_ends_of_many_values(values: list[Fraction], method: str) -> None:
    drawn = bounded(values)
    deviation = sqrt(float(drawn.squares / drawn.draws - drawn.mean**2) * drawn.draws / (drawn.draws - 1))
    like = Supposed(drawn.draws, float(drawn.mean), deviation, 0.0, 1.0, False)
    low, high = (end_of_sums(like, np.array([float(drawn.total)]), 0.05, method, side) for side in ("lower", "upper"))
    assert (low[0], high[0]) == pytest.approx(tuple(map(float, cell_ends(drawn, LEVEL, method))), abs=1e-5)


@given(st.integers(1, 12_000), st.data(), st.booleans(), st.sampled_from([0.05, 0.001]))
def test_ends_and_tails_of_arrays_are_those_of_numbers(n: int, data: st.DataObject, two_valued: bool, level: float) -> None:
    k = data.draw(st.integers(0, n))
    exact = cell_ends(Cell(n, F(k), F(k), F(0), F(1), two_valued), Fraction(str(level)))
    low, high = (float_ends(n, np.array([float(k)]), level, side, binary=two_valued) for side in ("lower", "upper"))
    assert (low[0], high[0]) == pytest.approx(tuple(map(float, exact)), abs=1e-5)
    p = data.draw(st.floats(0, 1))
    assert float_tails(n, np.array([float(k)]), np.array([p]), binary=two_valued)[0] == pytest.approx(float_tail(n, k, p, two_valued))


def test_sums_have_the_mean_and_spread_that_is_supposed() -> None:
    pick = np.random.default_rng(1)
    for each in (cell(100, 0.3), Supposed(100, 0.3, 0.1, 0.0, 1.0, False), cell(7, 0.0), cell(7, 1.0)):
        sums = each.sums(pick, (20_000,))
        assert sums.mean() == pytest.approx(each.draws * each.share, abs=0.15)
        assert sums.std() == pytest.approx(sqrt(each.draws) * each.deviation, rel=0.03)
        assert sums.min() >= 0 and sums.max() <= each.draws


@pytest.mark.parametrize("size", [(60, 60), (200, 80), (400, 400)])
@pytest.mark.parametrize(("one", "other"), [((1, 8, 1), (1, 8, 1)), ((4, 2, 4), (5, 2, 3)), ((6, 3, 1), (3, 4, 3))])
def test_bets_on_contrasts_win_about_as_much(one: tuple[int, ...], other: tuple[int, ...], size: tuple[int, int]) -> None:
    """The limit from which on a table rejects, against that of the sums over all pairings: within a tenth of its distance."""
    tallies = [{F(v, 2): w * n // 10 for v, w in enumerate(weights)} for weights, n in zip((one, other), size, strict=True)]
    counts = [ValueCounts(tally) for tally in tallies]
    exact = float(upper_end(*counts, LEVEL))
    cells = []
    for tally in tallies:
        n = sum(tally.values())
        mean = sum(v * w for v, w in tally.items()) / n
        cells.append(
            (Supposed(n, float(mean), sqrt(sum(w * (v - mean) ** 2 for v, w in tally.items()) / n), 0.0, 1.0, False), n * float(mean))
        )
    (top, k), (bottom, m) = cells
    rule = by_contrasts(LEVEL)
    tried = np.exp(np.linspace(-1, 3, 4001))
    found = next(r for r in tried if rule(top, np.array([k]), bottom, np.array([m]), float(r))[0])
    apart = abs(np.log(exact / (top.share / bottom.share)))
    assert np.log(found) == pytest.approx(np.log(exact), abs=0.1 * apart + 0.002)
