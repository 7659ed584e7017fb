"""Ends of cells: exact up to rounding outwards, and proved."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any

import pytest
from interval_oracle import (
    F,
    binary,
    bounded,
    ends_hold,
)
from scipy import stats

from fairaudit.inference.cells import Cell
from fairaudit.inference.ends import cell_ends


@pytest.mark.parametrize(
    ("n", "k"), [(1, 0), (1, 1), (7, 3), (10, 10), (40, 0), (100, 1), (100, 99), (1000, 500), (5000, 17), (5000, 4000)]
)
@pytest.mark.parametrize("level", [F(1, 40), F(1, 3120), F(1, 10**9)])
def test_ends_are_clopper_pearson_rounded_outwards(n: int, k: int, level: Fraction) -> None:
    lo, hi = cell_ends(binary(n, k), level)
    expected = stats.binomtest(k, n).proportion_ci(1 - 2 * float(level), method="exact")
    assert expected.low * (1 - 2e-6) <= lo <= expected.low * (1 + 1e-9)
    assert expected.high * (1 - 1e-9) <= hi <= expected.high + 2e-6
    cell = {"draws": n, "sum": k, "range": [0, 1], "binary": True}
    assert ends_hold(cell, lo, hi, level, "")
    near = 1 + F(1, 10**5)
    assert lo == 0 or not ends_hold(cell, lo * near, hi, level, "")
    assert hi == 1 or not ends_hold(cell, lo, hi / near, level, "")


@pytest.mark.parametrize("n", [5001, 10**8])
@pytest.mark.parametrize("share", ["0", "1e-7", "0.3", "0.5", "0.9999", "1"])
def test_ends_of_many_draws(n: int, share: str) -> None:
    k = int(F(share) * n)
    lo, hi = cell_ends(binary(n, k), F(1, 40))
    cell = {"draws": n, "sum": k, "range": [0, 1], "binary": True}
    assert ends_hold(cell, lo, hi, F(1, 40), "")
    assert lo <= F(k, n) <= hi
    expected = (stats.beta.ppf(0.025, k, n - k + 1) if k else 0, stats.beta.ppf(0.975, k + 1, n - k) if k < n else 1)
    assert lo <= expected[0] * (1 + 1e-9) and hi >= expected[1] * (1 - 1e-9)
    assert float(hi - lo) <= 1.1 * (expected[1] - expected[0]) + 2e-7


@pytest.mark.parametrize("method", ["hoeffding-kl", "empirical-bernstein", "intersection"])
@pytest.mark.parametrize("limits", [(F(0), F(1)), (F(1), F(5))])
def test_ends_of_bounded_draws_hold(method: Any, limits: tuple[Fraction, Fraction]) -> None:
    random = Random(5)
    low, high = limits
    for n in (1, 2, 30, 400):
        values = [low + (high - low) * F(random.randint(0, 8), 20) for _ in range(n)]
        cell = bounded(values, low, high)
        lo, hi = cell_ends(cell, F(1, 40), method)
        entry = {"draws": n, "sum": cell.total, "squares": cell.squares, "range": limits, "binary": False}
        assert ends_hold(entry, lo, hi, F(1, 40), method)
        assert lo <= cell.mean <= hi


def test_empirical_bernstein_wins_for_small_variance_only() -> None:
    quiet = bounded([F(1, 2), F(51, 100)] * 1000)
    loud = bounded([F(0), F(1)] * 1000)
    for cell, better in ((quiet, "empirical-bernstein"), (loud, "hoeffding-kl")):
        widths = {m: cell_ends(cell, F(1, 40), m)[1] - cell_ends(cell, F(1, 40), m)[0] for m in ("hoeffding-kl", "empirical-bernstein")}
        assert min(widths, key=lambda m: widths[m]) == better
        lo, hi = cell_ends(cell, F(1, 40), "intersection")
        assert widths[better] < hi - lo < max(widths.values())


def test_no_draws_and_no_range() -> None:
    assert cell_ends(Cell(0, F(0), None, F(1), F(4), True), F(1, 40)) == (1, 4)
    assert cell_ends(Cell(5, F(10), None, F(2), F(2), True), F(1, 40)) == (2, 2)
