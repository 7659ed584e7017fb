"""Intervals of a ratio: evidence, exact coverage, widths, and what is refused."""

from __future__ import annotations

import time
from fractions import Fraction
from itertools import permutations, product
from math import comb, inf, log, prod
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
import tiers
from interval_oracle import (
    F,
    binary,
    bounded,
    by_unit,
    one_block,
    recheck,
)
from scipy import stats

from fairaudit import Law, Utility, read_csv
from fairaudit.errors import InputError
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.table_comparisons import global_comparison, local_comparison
from fairaudit.inference.tails import tail_bound
from fairaudit.inference.verdicts import verdict


@pytest.mark.parametrize("ends", ["together", "each", "lower", "upper"])
@pytest.mark.parametrize(
    "options", [{}, {"independent": True}, {"independent": True, "region": "product"}], ids=["box", "sidak", "product"]
)
def test_evidence_is_enough(options: dict[str, Any], ends: Any) -> None:
    random = Random(11)
    for _ in range(6):
        blocks, cells = [], []
        for _ in range(random.randint(1, 2)):
            block = []
            for _ in range(random.randint(2, 4)):
                n = random.choice([1, 12, 60, 200])
                block.append(((len(cells), F(1)),))
                cells.append(binary(n, random.randint(0, n)))
            blocks.append(tuple(block))
        comparison = Comparison(tuple(cells), tuple(blocks))
        found = ratio_interval(comparison, "0.9", ends=ends, **options)
        assert found.lower >= 1 and found.upper >= found.lower
        assert found.lower <= found.estimate <= found.upper
        recheck(found.evidence, found.lower, found.upper)


@pytest.mark.parametrize("method", ["hoeffding-kl", "empirical-bernstein", "intersection"])
def test_evidence_of_bounded_draws_is_enough(method: Any) -> None:
    random = Random(3)
    cells = [bounded([F(random.randint(k, 10), 10) for _ in range(300)]) for k in (0, 2, 5)]
    found = ratio_interval(one_block(*cells), method=method)
    recheck(found.evidence, found.lower, found.upper)
    assert found.methods == (method,)


@pytest.mark.parametrize(
    "options", [{}, {"independent": True}, {"independent": True, "region": "product"}], ids=["box", "sidak", "product"]
)
def test_evidence_proves_no_more(options: dict[str, Any]) -> None:
    found = ratio_interval(one_block(binary(100, 60), binary(80, 20), binary(120, 70)), **options)
    recheck(found.evidence, found.lower, found.upper)
    for lower, upper in ((found.lower, found.upper * F(97, 100)), (found.lower * F(103, 100), found.upper)):
        with pytest.raises(AssertionError):
            recheck(found.evidence, lower, upper)


def test_equal_cells_are_told_apart() -> None:
    cell = binary(50, 25)
    found = ratio_interval(one_block(cell, cell, cell), independent=True, region="product")
    recheck(found.evidence, found.lower, found.upper)
    other = ratio_interval(one_block(binary(50, 25), binary(50, 25), binary(50, 25)), independent=True, region="product")
    assert found.upper == other.upper > 1


def test_a_pair_of_unequal_sizes_is_not_confused_with_itself() -> None:
    """A small cell may not be compared with itself, which would widen the region."""
    found = ratio_interval(one_block(binary(20, 10), binary(2000, 1000)), independent=True, region="product")
    recheck(found.evidence, found.lower, found.upper)
    boxed = ratio_interval(one_block(binary(20, 10), binary(2000, 1000)), independent=True)
    assert found.upper < 1.02 * boxed.upper


def test_many_draws_verify_quickly() -> None:
    cells = [binary(10**8, 3 * 10**7 + 1000 * i) for i in range(20)]
    for options in ({}, {"independent": True}, {"independent": True, "region": "product"}):
        found = ratio_interval(one_block(*cells), **options)
        assert 1 <= found.lower <= found.upper < 1.01
    evidence = ratio_interval(one_block(*cells)).evidence
    start = time.perf_counter()
    for name in ("upper", "lower"):
        level = F(evidence["levels"][name])
        for cell, (lo, hi) in zip(cells, evidence[name], strict=True):
            assert tail_bound(cell, F(hi), "lower") <= level * 2**128
            assert tail_bound(cell, F(lo), "upper") <= level * 2**128
    assert time.perf_counter() - start < 1


def errors(p: list[Fraction], n: list[int], confidence: Fraction, **options: Any) -> tuple[Fraction, Fraction, Fraction]:
    """Probabilities that the lower end, the upper end, or either is on the wrong side of the true ratio, over all outcomes."""
    true = max((a / b if b else inf if a else F(1)) for a, b in permutations(p, 2))
    above = below = either = F(0)
    for outcome in product(*[range(m + 1) for m in n]):
        chance = prod((comb(m, k) * q**k * (1 - q) ** (m - k) for m, k, q in zip(n, outcome, p, strict=True)), start=F(1))
        if chance:
            found = ratio_interval(one_block(*map(binary, n, outcome)), confidence, **options)
            above += chance * (found.lower > true)
            below += chance * (found.upper < true)
            either += chance * (not found.lower <= true <= found.upper)
    return above, below, either


REGIONS = pytest.mark.parametrize(
    "options", [{}, {"independent": True}, {"independent": True, "region": "product"}], ids=["box", "sidak", "product"]
)
SMALL = pytest.mark.parametrize(
    ("p", "n"),
    [
        ([F(1, 2), F(1, 2)], [5, 5]),
        ([F(9, 10), F(1, 20)], [6, 3]),
        ([F(1, 3), F(1, 3), F(1, 3)], [3, 2, 3]),
        ([F(1), F(1, 2)], [4, 5]),
        ([F(0), F(1, 2)], [4, 4]),
        ([F(3, 4), F(1, 2), F(1, 2)], [2, 3, 2]),
    ],
)


@pytest.mark.parametrize("ends", ["together", "lower", "upper"])
@REGIONS
@SMALL
def test_exact_coverage(p: list[Fraction], n: list[int], options: dict[str, Any], ends: Any) -> None:
    assert errors(p, n, F(4, 5), ends=ends, **options)[2] <= F(1, 5)


@pytest.mark.parametrize("confidence", [F(1, 2), F(19, 20)], ids=["50 %", "95 %"])
@REGIONS
@SMALL
def test_each_end_is_wrong_no_more_often_than_it_says(
    p: list[Fraction], n: list[int], options: dict[str, Any], confidence: Fraction
) -> None:
    above, below, either = errors(p, n, confidence, ends="each", **options)
    assert max(above, below) <= 1 - confidence and either <= 2 * (1 - confidence)


def test_at_half_confidence_ends_are_seen_to_be_wrong() -> None:
    """So the test above can fail: with all of the error an end errs more often than both together may at half of it."""
    above, below, _ = errors([F(1, 5), F(4, 5)], [12, 12], F(1, 2), ends="each", independent=True)
    assert F(1, 20) < below <= F(1, 2) and 0 < above <= F(1, 2)


@pytest.mark.parametrize("confidence", [F(1, 2), F(19, 20)], ids=["50 %", "95 %"])
@REGIONS
def test_ends_by_themselves_lie_within_those_that_hold_together(options: dict[str, Any], confidence: Fraction) -> None:
    random = Random(5)
    for _ in range(8):
        sizes = [random.choice([3, 20, 150]) for _ in range(random.randint(2, 4))]
        comparison = one_block(*(binary(n, random.randint(0, n)) for n in sizes))
        each, both, half = (
            ratio_interval(comparison, level, ends=ends, **options)
            for level, ends in ((confidence, "each"), (confidence, "together"), (1 - (1 - confidence) / 2, "each"))
        )
        for wider in (both, half):
            assert wider.lower <= each.lower and each.upper <= wider.upper


def bonferroni(cells: list[Cell]) -> tuple[float, float]:
    """Clopper–Pearson for each cell at α/(2K), the ratio of extremes."""
    ends = [stats.binomtest(int(c.total), c.draws).proportion_ci(1 - 0.05 / len(cells), method="exact") for c in cells]
    lower = max((a.low / b.high for a, b in permutations(ends, 2)), default=1.0)
    upper = max(a.high / b.low if b.low > 0 else inf for a, b in permutations(ends, 2))
    return max(1.0, lower), upper


WIDTHS = [
    *[([p] * k, [n] * k) for k, p, n in [(2, 0.5, 50), (2, 0.1, 1000), (5, 0.3, 100), (40, 0.5, 900)]],
    ([0.6, 0.3], [200, 200]),
    ([0.9, 0.05], [300, 300]),
    ([0.5, 0.5], [50, 1000]),
    ([0.2, 0.3, 0.5], [100, 100, 100]),
    ([0.1 + 0.04 * i for i in range(10)], [500] * 10),
    ([0.9, 0.05, 0.05], [300] * 3),
    ([0.95, 0.04, 0.5, 0.5], [400] * 4),
    ([0.99, 0.97], [100, 100]),
    ([0.02] * 6, [1000] * 6),
]


def median_widths(p: list[float], n: list[int], repetitions: int) -> dict[str, float]:

    generator = np.random.default_rng(7)
    widths: dict[str, list[float]] = {"bonferroni": [], "box": [], "sidak": [], "product": [], "pairs": [], "default": []}
    for _ in range(repetitions):
        cells = [binary(m, int(k)) for m, k in zip(n, generator.binomial(n, p), strict=True)]
        lower, upper = bonferroni(cells)
        if upper == inf:
            continue
        widths["bonferroni"].append(log(upper / lower))
        options: dict[str, dict[str, Any]] = {"box": {}, "sidak": {"independent": True}}
        options |= {region: {"independent": True, "region": region} for region in ("product", "pairs")}
        for name, chosen in options.items():
            found = ratio_interval(one_block(*cells), **chosen)
            widths[name].append(log(found.upper) - log(found.lower))
        widths["default"].append(widths[default_region(one_block(*cells), independent=True).replace("box", "sidak")][-1])
    return {name: float(np.median(values)) for name, values in widths.items()}


def test_widths_against_bonferroni() -> None:
    found = [median_widths(p, n, tiers.size(1, 3, 9)) for p, n in WIDTHS]
    for (p, n), widths in zip(WIDTHS, found, strict=True):
        print(len(p), n[0], {name: round(value, 4) for name, value in widths.items()})
    assert all(w["box"] <= w["bonferroni"] * (1 + 1e-5) for w in found)
    assert all(w["sidak"] < w["bonferroni"] for w in found)
    assert all(w["default"] < w["bonferroni"] for w in found)
    assert all(w["product"] < 1.03 * w["bonferroni"] for w in found)
    assert all(w["default"] == w["pairs"] < 0.95 * min(w["sidak"], w["product"]) for w in found)
    assert sum(w["product"] < 0.9 * w["bonferroni"] for w in found) >= len(found) / 2


def test_what_cannot_be() -> None:
    for cell in ((5, 6), (-1, 0)):
        with pytest.raises(InputError):
            binary(*cell)
    with pytest.raises(InputError):
        Cell(4, F(1, 2), None, F(0), F(1), True)
    nothing = ratio_interval(
        one_block(Cell(0, F(0), None, F(1), F(3), True), Cell(0, F(0), None, F(1), F(3), True)), region="product", independent=True
    )
    assert (nothing.lower, nothing.upper, nothing.region) == (1, 3, "box")
    recheck(nothing.evidence, nothing.lower, nothing.upper)
    with pytest.raises(InputError, match="nothing is compared"):
        ratio_interval(one_block(binary(5, 2)))
    with pytest.raises(InputError, match="product region"):
        ratio_interval(one_block(binary(5, 2), binary(5, 2)), region="product")
    law = Law.from_array([[[1, 1], [1, 1]], [[0, 0], [3, 1]]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    assert len(local_comparison(law, Utility({"yes": 1}).on(law)).cells) == 2
    with pytest.raises(InputError, match="no counts"):
        global_comparison(law, Utility({"yes": 1}).on(law), {(("1",), ("f",)): 1})
    with pytest.raises(InputError, match="masses"):
        global_comparison(law, Utility({"yes": 1}).on(law), {(("1",), ("m",)): 0})


def test_resume_rankings_with_the_run_as_unit(data: Path) -> None:
    """One winner per run: the groups share their runs, so that cells are dependent."""
    runs = read_csv(data / "bloomberg_gpt_rankings.csv")
    counts = read_csv(data / "gpt_resume_first_counts.csv")
    rows: dict[str, list[str]] = {"job": [], "group": [], "decision": [], "run": []}
    for model, job, batch, run, ranked in zip(*(runs[c] for c in ("model", "job", "batch", "run_id", "ranked_order")), strict=True):
        if model == "gpt-4" and batch != "oversampled" and ranked:
            for group in sorted(ranked.split()):
                for name, value in zip(
                    rows, (job, group, "first" if ranked.split()[0] == group else "not_first", f"{job} {batch} {run}"), strict=True
                ):
                    rows[name].append(value)
    comparison = by_unit(rows, Utility({"first": 1}), decision="decision", group="group", context="job")
    assert comparison.dependent and all(cell.binary for cell in comparison.cells)
    published = {
        (job, group): int(n)
        for model, job, group, u, n in zip(*(counts[c] for c in ("model", "job", "group", "decision", "n")), strict=True)
        if model == "gpt-4" and u == "first"
    }
    assert {(x[0], a[0]): int(c.total) for c in comparison.cells for x, a in [c.label]} == published
    found = ratio_interval(comparison)
    assert found.estimate == F(147, 103)
    assert found.lower == 1 and 2.1 < found.upper < 2.12
    assert verdict(found, max_ratio="5/4") == "inconclusive"


def test_first_places_of_gpt35_are_unequal(data: Path) -> None:
    table = read_csv(data / "gpt_resume_first_counts.csv")
    keep = [i for i, m in enumerate(table["model"]) if m == "gpt-3.5-turbo"]
    part = {name: [table[name][i] for i in keep] for name in table.columns}
    law = Law.from_counts(part, decision="decision", group="group", context="job", count="n")
    found = ratio_interval(local_comparison(law, Utility({"first": 1}).on(law)))
    assert found.estimate == F(43, 19)
    assert 1.24 < found.lower < 1.25 < found.upper < 3.5
    assert verdict(found, max_ratio="5/4") == "inconclusive"
    assert verdict(found, max_ratio="6/5") == "exceeds"
