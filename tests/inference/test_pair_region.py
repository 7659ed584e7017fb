"""Intervals of independent cells of two-valued draws, every pair by itself: when they are taken, what proves them, how often they err."""

from __future__ import annotations

import copy
import json
from fractions import Fraction
from itertools import pairwise
from math import comb, inf
from typing import Any

import numpy as np
import pytest
from certificates import outcome
from hypothesis import given, settings
from hypothesis import strategies as st
from interval_oracle import binary, one_block, recheck

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ratio_intervals import default_region, drivers, ratio_interval
from fairaudit.inference.table_comparisons import local_comparison

F = Fraction
CELL = st.integers(1, 40).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n)))


def pairs(comparison: Comparison, confidence: str = "0.95", **options: Any) -> Any:
    return ratio_interval(comparison, confidence, region="pairs", independent=True, **options)


@given(
    st.lists(CELL, min_size=2, max_size=4),
    st.sampled_from(["0.5", "0.95", "0.999"]),
    st.sampled_from(["together", "each", "lower", "upper"]),
)
@settings(max_examples=15, deadline=None)
def test_its_evidence_proves_it(cells: list[tuple[int, int]], confidence: str, ends: Any) -> None:
    found = pairs(one_block(*(binary(n, k) for n, k in cells)), confidence, ends=ends)
    assert found.lower >= 1 and found.methods == ("pair-exact",)
    assert (found.upper == inf) == (ends == "lower" or any(k == 0 for _, k in cells))
    recheck(found.evidence, found.lower, found.upper)


def test_each_end_errs_as_often_as_it_says_and_nearly_so() -> None:
    """All outcomes of two cells, at a confidence at which errors are seen."""
    n, m = 8, 6
    found = {(k, j): pairs(one_block(binary(n, k), binary(m, j)), "0.6", ends="each") for k in range(n + 1) for j in range(m + 1)}
    worst = [0.0, 0.0]
    for p, q in ((0.5, 0.5), (0.6, 0.4), (0.3, 0.6), (0.9, 0.8), (0.2, 0.2), (0.95, 0.5)):
        true, missed = max(p / q, q / p), [0.0, 0.0]
        for (k, j), interval in found.items():
            chance = comb(n, k) * p**k * (1 - p) ** (n - k) * comb(m, j) * q**j * (1 - q) ** (m - j)
            missed[0] += chance * (interval.upper < true)
            missed[1] += chance * (interval.lower > true)
        assert max(missed) <= 0.4 + 1e-12, (p, q)
        worst = [max(pair) for pair in zip(worst, missed, strict=True)]
    assert min(worst) > 0.1  # ends that never err would be too wide


@pytest.mark.parametrize("ends", ["each", "together"])
def test_several_groups_err_no_more(ends: Any) -> None:
    pick, misses = np.random.default_rng(11), 0
    for _ in range(60):
        found = pairs(one_block(*(binary(30, int(k)) for k in pick.binomial(30, [0.5, 0.5, 0.4]))), "0.8", ends=ends)
        misses += found.lower > F(5, 4) or found.upper < F(5, 4)
    assert misses <= 60 * (0.4 if ends == "each" else 0.2) + 13  # three standard errors


def test_narrower_errors_are_nested() -> None:
    cells = one_block(binary(60, 40), binary(50, 22), binary(45, 30))
    ends = [pairs(cells, confidence, ends=how) for confidence in ("0.8", "0.95", "0.99") for how in ("each", "together")]
    assert all(one.upper <= other.upper for one, other in pairwise(ends) if one.evidence["ends"] == "each")
    assert [found.upper for found in ends[::2]] == sorted(found.upper for found in ends[::2])
    assert [found.lower for found in ends[::2]] == sorted((found.lower for found in ends[::2]), reverse=True)


def test_utilities_of_groups_scale_the_ratio() -> None:
    """A success that is worth three times as much in one group makes three times the ratio."""
    plain = pairs(one_block(binary(40, 30), binary(40, 20)), ends="each")
    worth = Cell(40, F(90), F(270), F(0), F(3), True)
    scaled = pairs(one_block(worth, binary(40, 20)), ends="each")
    assert scaled.upper == 3 * plain.upper
    recheck(scaled.evidence, scaled.lower, scaled.upper)


def test_independence_is_never_assumed() -> None:
    two = one_block(binary(40, 30), binary(40, 20))
    assert default_region(two, independent=True) == "pairs" and default_region(two, independent=False) == "box"
    with pytest.raises(InputError, match="exact pair bound needs independent cells"):
        ratio_interval(two, region="pairs")
    law = fa.Law.from_array([[30, 10], [20, 20]], kind="counts", decisions=["yes", "no"])
    assert fa.certify(law, {"yes": 1}).intervals["local"].region == "box"
    assert fa.certify(law, {"yes": 1}, independent=True).intervals["local"].region == "pairs"


@pytest.mark.parametrize(
    "other",
    [
        Cell(40, F(20), F(15), F(0), F(1), False),  # several values
        Cell(40, F(60), F(100), F(1), F(2), True),  # nobody gets nothing
        Cell(0, F(0), F(0), F(0), F(1), True),  # no draws
        Cell(10**6 + 1, F(10**5), F(10**5), F(0), F(1), True),  # too many
    ],
)
def test_other_cells_keep_another_region(other: Cell) -> None:
    assert default_region(one_block(binary(40, 30), other), independent=True) != "pairs"


def test_an_open_verdict_says_what_independence_would_give() -> None:
    law = fa.Law.from_array([[300, 100], [270, 130]], kind="counts", decisions=["yes", "no"])
    result = fa.certify(law, {"yes": 1}, max_local_ratio="6/5")
    assert result.verdict == "inconclusive"
    declared = fa.certify(law, {"yes": 1}, max_local_ratio="6/5", independent=True).intervals["local"]
    assert result.if_independent == {"local": (declared.lower, declared.upper)}
    assert not fa.certify(law, {"yes": 1}, max_local_ratio="6/5", independent=True).if_independent


def test_the_pair_behind_each_end_is_named() -> None:
    law = fa.Law.from_array([[50, 50], [90, 10], [5, 15]], kind="counts", decisions=["yes", "no"], groups=["a", "b", "c"])
    compared = local_comparison(law, fa.Utility({"yes": 1}).on(law))
    found = pairs(compared)
    lower, upper = drivers(compared, found.evidence, found.upper)
    assert lower is not None and (lower.higher, lower.lower) == ({"group": "b"}, {"group": "c"})
    assert upper is not None and (upper.higher, upper.lower) == ({"group": "b"}, {"group": "c"})
    nothing = fa.Law.from_array([[50, 50], [0, 20]], kind="counts", decisions=["yes", "no"], groups=["a", "b"])
    compared = local_comparison(nothing, fa.Utility({"yes": 1}).on(nothing))
    assert drivers(compared, pairs(compared).evidence, inf)[1].lower == {"group": "b"}  # type: ignore[union-attr]


def certificate(**options: Any) -> Any:
    law = fa.Law.from_array(
        [[[60, 40], [30, 70]], [[45, 55], [50, 50]]], kind="counts", decisions=["yes", "no"], groups=["f", "m"], contexts=["x", "y"]
    )
    return json.loads(fa.certify(law, {"yes": 1}, independent=True, **options).certificate.text)


def _altered(document: Any, change: Any) -> Any:
    made = copy.deepcopy(document)
    change(made["intervals"]["local"], made)
    return made


CHANGES = {
    "a smaller end": lambda i, _: i.update(ratio=[i["ratio"][0], str(F(i["ratio"][1]) - F(1, 100))]),
    "a greater lower end": lambda i, _: i.update(ratio=[str(F(i["ratio"][0]) + F(1, 100)), i["ratio"][1]]),
    "a level": lambda i, _: i["levels"].update(upper="1/10"),
    "a level of the lower end": lambda i, _: i["levels"].update(lower="1/20"),
    "another pair": lambda i, _: i["lower"].update(pair=[1, 0, 1]),
    "the pair the other way round": lambda i, _: i["lower"].update(pair=[0, 1, 0]),
    "a ladder too few": lambda i, _: i["upper"].pop(),
    "ladders exchanged": lambda i, _: i["upper"].reverse(),
    "a knot too few": lambda i, _: max(i["upper"], key=len).pop(1),
    "no last knot": lambda i, _: max(i["upper"], key=len).pop(),
    "no first knot": lambda i, _: max(i["upper"], key=len).pop(0),
    "dependent cells": lambda i, _: i.update(independent=False),
    "ends that hold each": lambda i, _: i.update(ends={"each": "together", "together": "each"}[i["ends"]]),
    "more confidence": lambda i, _: i.update(confidence="99/100"),
    "a declared range": lambda i, _: i.update(limits=["0", "2"]),
    "another method": lambda _, d: [c.update(by="binomial") for c in d["claims"] if c["by"] == "pair-exact"],
}


@pytest.mark.parametrize("target", [None, "2"])
@pytest.mark.parametrize("name", CHANGES)
def test_no_altered_evidence_is_accepted(name: str, target: str | None) -> None:
    honest = certificate(**({} if target is None else {"max_local_ratio": target}))
    assert honest["intervals"]["local"]["region"] == "pairs"
    assert outcome(honest) == "true"
    assert outcome(_altered(honest, CHANGES[name])) != "true"
