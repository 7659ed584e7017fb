"""The search for the most unequal conjunctions against plain loops over all of them.

2,000 random logs: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t18_search.py
"""

from __future__ import annotations

from itertools import combinations
from math import lcm, prod
from random import Random

import numpy as np
import pytest
import tiers
from subgroup_oracle import Case, family, random_case, worst

from fairaudit.errors import InputError
from fairaudit.theorems.t18_search import Rows, conjunctions, entries, every_conjunction, most_unequal

CASES = 2000 if tiers.FULL else 200


def rows_of(case: Case, factor: int = 1) -> tuple[Rows, int, list[list[str]]]:
    """A case as arrays, with what its utilities were multiplied by, and the labels."""
    labels = [sorted({row[i] for row, _ in case.log}) for i in range(len(case.attributes))]
    codes = [np.array([labels[i].index(row[i]) for row, _ in case.log]) for i in range(len(labels))]
    entry = entries(codes, [len(own) for own in labels], len(case.log))
    scale = factor * lcm(*(value.denominator for _, value in case.log))
    got = [int(value * scale) for _, value in case.log]
    values = sorted(set(got))
    counts = np.zeros((int(entry.max()) + 1, len(values)), dtype=np.int64)
    np.add.at(counts, (entry, [values.index(value) for value in got]), 1)
    held = []
    for code in codes:
        own = np.zeros(len(counts), dtype=np.int64)
        own[entry] = code
        held.append(own)
    return Rows(tuple(held), tuple(len(own) for own in labels), counts, tuple(values)), scale, labels


@pytest.mark.parametrize("factor", [1, (1 << 70) + 1], ids=["short", "long"])
def test_the_search_finds_what_loops_find(factor: int) -> None:
    """Long utilities do not fit into a float."""
    rng, pruned = Random(tiers.fresh("subgroups")), 0
    for _ in range(CASES):
        case = random_case(rng)
        rows, scale, labels = rows_of(case, factor)
        found = most_unequal(rows, case.depth, case.least, case.keep)
        pruned += len(found.frontier)

        def said(conditions: tuple[tuple[int, int], ...], case: Case = case, labels: list[list[str]] = labels) -> dict[str, str]:
            return {case.attributes[a]: labels[a][v] for a, v in conditions}

        listed = [(said(f.conditions), f.rows, f.total, f.ratio, f.side, [said(other) for other in f.same]) for f in found.found]
        assert listed == [(e.conditions, len(e.rows), e.total * scale, e.ratio, e.side, same) for e, same in worst(case)]
    assert tiers.enough(pruned > CASES // 10)


def test_every_conjunction_is_listed() -> None:
    rng = Random(tiers.fresh("every"))
    for _ in range(CASES // 4):
        case = random_case(rng)
        rows, scale, _ = rows_of(case)
        listed = every_conjunction(rows, case.depth, case.least)
        assert listed is not None
        assert every_conjunction(rows, case.depth, case.least, len(listed)) == listed
        assert not listed or every_conjunction(rows, case.depth, case.least, len(listed) - 1) is None
        assert sorted((n, total) for _, n, total in listed) == sorted((len(e.rows), int(e.total * scale)) for e in family(case))


@pytest.mark.parametrize("sizes", [(2, 6), (1, 1, 1), (5,) * 4, (2, 3, 4, 5, 6)])
def test_conjunctions_are_counted_without_listing_them(sizes: tuple[int, ...]) -> None:
    for depth in range(1, 7):
        assert conjunctions(sizes, depth) == sum(prod(chosen) for k in range(1, depth + 1) for chosen in combinations(sizes, k))


def test_a_depth_beyond_the_attributes_adds_nothing() -> None:
    assert conjunctions((2, 3), 10**12) == conjunctions((2, 3), 2) == 11


def test_a_planted_subgroup_comes_first() -> None:
    rng = np.random.default_rng(7)
    codes = [rng.integers(0, 4, 20_000) for _ in range(6)]
    planted = (codes[0] == 1) & (codes[3] == 2) & (codes[5] == 0)
    got = (rng.random(20_000) < np.where(planted, 0.1, 0.4)).astype(int)
    counts = np.column_stack((1 - got, got))
    found = most_unequal(Rows(tuple(codes), (4,) * 6, counts, (0, 1)), 3, 200)
    assert found.found[0].conditions == ((0, 1), (3, 2), (5, 0))
    assert found.found[0].side == "less"


def test_progress_reaches_the_end() -> None:
    rng, told = Random(tiers.fresh("progress")), list[float]()
    rows, _, _ = rows_of(random_case(rng))
    most_unequal(rows, 2, 1, report=lambda share, _: told.append(share or 0))
    assert told == sorted(told)
    assert 0 < told[-1] <= 1


def test_more_rows_than_floats_count_are_refused() -> None:
    with pytest.raises(InputError, match="rows"):
        Rows((np.array([0]),), (1,), np.array([[1 << 53]]), (1,))
