"""How likely audits decide, against all tables enumerated and judged by the exact methods."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from math import sqrt

import numpy as np
import pytest
from interval_oracle import F, binary, one_block
from scipy.stats import binom

from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison, Form
from fairaudit.inference.interval import Region
from fairaudit.inference.power import Audit, Chances, Side, _greatest
from fairaudit.inference.quotients import greatest_ratio
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.rejections import Supposed
from fairaudit.inference.verdicts import verdict

LIMIT = Fraction(5, 4)


def supposed(draws: int, share: float) -> Supposed:
    return Supposed(draws, share, sqrt(share * (1 - share)), 0.0, 1.0, True)


def audit(rows: list[list[tuple[int, float]]], side: Side, region: Region, limit: Fraction = LIMIT) -> Audit:
    cells = [cell for row in rows for cell in row]
    places = iter(range(len(cells)))
    blocks = tuple(tuple(((next(places), F(1)),) for _ in row) for row in rows)
    compared = Comparison((Cell(1, F(0), None, F(0), F(1), True),) * len(cells), blocks)
    listed = [supposed(n, p) for n, p in cells]
    return Audit(
        compared, listed, side, float(limit), F(1, 20), "hoeffding-kl", region != "box", lambda _: region, compared.pairs, len(cells), 2
    )


def enumerated(cells: list[tuple[int, float]], side: Side, region: Region, limit: Fraction) -> float:
    """The probability of the verdict, by every table of one block."""
    total = 0.0
    for counts in product(*(range(n + 1) for n, _ in cells)):
        chance = float(np.prod([binom.pmf(k, n, p) for k, (n, p) in zip(counts, cells, strict=True)]))
        if chance > 3e-4:
            compared = one_block(*(binary(n, k) for k, (n, _) in zip(counts, cells, strict=True)))
            interval = ratio_interval(compared, region=region, independent=region != "box", ends="each")
            total += chance * (verdict(interval, max_ratio=limit) == side)
    return total


@pytest.mark.parametrize("region", ["box", "pairs", "product"])
@pytest.mark.parametrize(
    ("cells", "side", "limit"),
    [
        ([(12, 0.8), (15, 0.8)], "within", F(2)),
        ([(14, 0.9), (10, 0.3)], "exceeds", F(5, 4)),
        ([(8, 0.95), (9, 0.9)], "within", F(2)),
    ],
)
def test_the_chance_is_that_of_all_tables(cells: list[tuple[int, float]], side: Side, limit: Fraction, region: Region) -> None:
    found = Chances(audit([cells], side, region, limit)).at(1).power
    assert found == pytest.approx(enumerated(cells, side, region, limit), abs=0.1)


@pytest.mark.parametrize("region", ["box", "pairs", "product"])
@pytest.mark.parametrize(("rows", "side"), [([[0.5, 0.5]] * 3, "within"), ([[0.5, 0.3, 0.5], [0.5, 0.5, 0.5]], "exceeds")])
def test_more_draws_decide_no_less_often(rows: list[list[float]], side: Side, region: Region) -> None:
    chances = Chances(audit([[(1, p) for p in row] for row in rows], side, region))
    powers = [chances.at(n).power for n in (50, 100, 200, 400, 800, 1600, 3200, 6400, 12800)]
    assert all(b >= a - 0.03 for a, b in pairwise(powers))
    assert powers[0] < 0.2 and powers[-1] > 0.99


@pytest.mark.parametrize("region", ["box", "pairs", "product"])
def test_equal_blocks_are_as_different_ones(region: Region) -> None:
    """Blocks that are alike are simulated once; with means that differ by next to nothing every one is."""
    alike = Chances(audit([[(1, 0.5), (1, 0.5)]] * 5, "within", region)).at(900).power
    apart = Chances(audit([[(1, 0.5 + i * 1e-9), (1, 0.5)] for i in range(5)], "within", region)).at(900).power
    assert alike == pytest.approx(apart, abs=0.04)


def test_the_pair_that_decides() -> None:
    chances = Chances(audit([[(1, 0.5), (1, 0.5)], [(1, 0.5), (1, 0.45), (1, 0.48)]], "within", "pairs"))
    chance = chances.at(1500)
    assert chance.pair == (1, 0, 1) and set(chances.deciding(chance)) >= {2, 3}
    exceeding = Chances(audit([[(1, 0.5), (1, 0.45)], [(1, 0.3), (1, 0.5)]], "exceeds", "box"))
    assert exceeding.at(300).pair == (1, 1, 0) and exceeding.deciding(exceeding.at(300)) == (2, 3)


def test_forms_of_several_cells() -> None:
    """A form that is one cell by two names has the power of that cell; quotients of forms are the exact ones."""
    plain = audit([[(1, 0.5), (1, 0.5)]], "within", "box", F(2))
    halves: tuple[Form, ...] = (((0, F(1, 2)), (2, F(1, 2))), ((1, F(1)),))
    cells = (*plain.comparison.cells, plain.comparison.cells[0])
    apart = Audit(
        Comparison(cells, (halves,)),
        [*plain.supposed, supposed(1, 0.5)],
        "within",
        2.0,
        F(1, 20),
        "hoeffding-kl",
        False,
        lambda _: "box",
        2,
        3,
        3,
    )
    powers = [Chances(each).at(n).power for each in (plain, apart) for n in (60, 200)]
    assert powers[0] < powers[1] and powers[2] < powers[3]
    top, bottom = ((0, F(1, 3)), (1, F(2, 3))), ((0, F(1, 2)), (2, F(1, 2)))
    ends = [(F(1, 5), F(1, 2)), (F(0), F(3, 4)), (F(1, 8), F(1, 4))]
    floats = {i: (np.array([float(a)]), np.array([float(b)])) for i, (a, b) in enumerate(ends)}
    for one, other in ((top, bottom), (bottom, top)):
        assert _greatest(one, other, floats)[0] == pytest.approx(float(greatest_ratio(one, other, ends)))
