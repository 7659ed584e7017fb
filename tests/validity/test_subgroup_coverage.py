"""Intervals of all subgroups at once: how often one of them misses, over logs drawn anew, and how often a verdict is wrong.

2,000 logs: FAIRAUDIT_FULL=1 pytest -n0 tests/validity/test_subgroup_coverage.py
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest
import tiers

from fairaudit.inference.cells import Cell
from fairaudit.inference.subgroup_ends import both_ends, ratio_ends
from fairaudit.theorems.t18_search import Rows, conjunctions, entries, every_conjunction

LOGS = 2000 if tiers.FULL else 40

SIZES = (2, 3, 2)

CONFIDENCE = Fraction(4, 5)


def population() -> tuple[list[tuple[int, ...]], np.ndarray, np.ndarray]:
    """Cells, how common they are, and how often each gets something."""
    cells = list(product(*map(range, SIZES)))
    common = np.array([1 + (3 * i % 5) for i in range(len(cells))], dtype=float)
    gets = np.array([0.1 + 0.8 * (7 * i % 11) / 10 for i in range(len(cells))])
    return cells, common / common.sum(), gets


def true_ratios() -> dict[tuple[tuple[int, int], ...], float]:
    """The ratio of each conjunction in the population."""
    cells, common, gets = population()
    found = {}
    for size in (1, 2):
        for chosen in combinations(range(len(SIZES)), size):
            for values in product(*[range(SIZES[a]) for a in chosen]):
                name = tuple(zip(chosen, values, strict=True))
                inside = np.array([all(cell[a] == v for a, v in name) for cell in cells])
                own, rest = ((common * gets)[part].sum() / common[part].sum() for part in (inside, ~inside))
                found[name] = max(own / rest, rest / own)
    return found


@pytest.mark.parametrize("values", [2, 3], ids=["binary", "three values"])
def test_all_intervals_hold_together(values: int) -> None:
    """At 80 % confidence: more logs than that have no interval that misses, though hundreds of subgroups are looked at."""
    rng, truth = np.random.default_rng(values), true_ratios()
    cells, common, gets = population()
    codes = np.array(cells)
    family, missed, wrong = conjunctions(SIZES, 2), 0, 0
    for _ in range(LOGS):
        drawn = rng.choice(len(cells), size=int(rng.choice([60, 200, 600])), p=common)
        got = (rng.random(len(drawn)) < gets[drawn]).astype(int) * 2 if values == 2 else rng.binomial(2, gets[drawn])
        own = [codes[drawn, a] for a in range(len(SIZES))]
        entry = entries(own, SIZES, len(drawn))
        counts = np.zeros((int(entry.max()) + 1, 3), dtype=np.int64)
        np.add.at(counts, (entry, got), 1)
        held = np.zeros((len(counts), len(SIZES)), dtype=np.int64)
        held[entry] = codes[drawn]
        rows = Rows(tuple(held.T.copy()), SIZES, counts, (0, 1, 2))
        outside = exceeding = 0
        for name, n, total in every_conjunction(rows, 2, 1) or ():
            parts = [
                Cell(draws, Fraction(gains, 2), None, Fraction(0), Fraction(1), values == 2)
                for draws, gains in ((n, total), (rows.rows - n, rows.total - total))
            ]
            low, high = ratio_ends(*both_ends(parts[0], parts[1], CONFIDENCE, family))
            outside += not low <= truth[name] <= high
            exceeding += low > max(truth.values())
        missed += outside > 0
        wrong += exceeding > 0
    assert missed <= LOGS * (1 - CONFIDENCE)
    assert wrong <= missed
    print(f"{values} values: {missed} of {LOGS} logs have an interval that misses; {wrong} put a subgroup beyond the greatest ratio")
