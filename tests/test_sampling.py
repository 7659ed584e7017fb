"""Intervals from samples: ends, quotients over a box, evidence, units, verdicts, and what follows from them."""

from __future__ import annotations

import json
import time
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise, permutations, product
from math import comb, exp, inf, log, prod
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import iv, mp
from scipy import stats

from fairaudit import Law, Policy, Product, RandomizedResponse, Utility, certify, checker, read_csv
from fairaudit.errors import InputError
from fairaudit.inference import quotients
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ends import cell_ends
from fairaudit.inference.estimated_population import sampled_population_interval
from fairaudit.inference.hypothesis_tests import noise_floor, test_filter
from fairaudit.inference.levels import box_levels, confidence_level
from fairaudit.inference.planning import further_draws, plan
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.quotients import greatest_ratio, least_ratio
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.table_comparisons import global_comparison, local_comparison
from fairaudit.inference.tails import tail_bound
from fairaudit.inference.verdicts import verdict
from fairaudit.model.mechanism import Identity

F = Fraction
ALPHA = F(1, 20)
ZERO, ONE = F(0), F(1)


def binary(n: int, k: int) -> Cell:
    return Cell(n, F(k), F(k), F(0), F(1), True)


def bounded(values: list[Fraction], low: Fraction = ZERO, high: Fraction = ONE) -> Cell:
    return Cell(len(values), sum(values, F(0)), sum((v * v for v in values), F(0)), low, high, False)


def by_unit(table: Any, utility: Utility, **columns: str) -> Comparison:
    law = Law.from_log(table, **columns, unit="run")  # type: ignore[arg-type]
    return local_comparison(law, utility.on(law))


def one_block(*cells: Cell) -> Comparison:
    return Comparison(cells, (tuple(((i, F(1)),) for i in range(len(cells))),))


# A second reading of docs/certificate-samples.md: exact sums, no code of the package.


def binomial_sum(n: int, k: int, a: int, b: int) -> int:
    """Σ_{i ≤ k} C(n,i) a^i b^(n−i), over the shorter side."""
    if 2 * k > n:
        return (a + b) ** n - binomial_sum(n, n - k - 1, b, a) if k < n else (a + b) ** n
    total, term = 0, 1
    for i in range(k + 1):
        total = total * b + term
        term = term * (n - i) * a // (i + 1)
    return total * b ** (n - k)


def bound_exact(n: int, k: Fraction, p: Fraction, is_binary: bool, level: Fraction) -> bool:
    """Whether B(n, k, p) ≤ level."""
    if p <= 0 or k == n:
        return level >= 1
    if p >= 1:
        return True
    if is_binary and n <= 5000:
        a, d = p.numerator, p.denominator
        return binomial_sum(n, int(k), a, d - a) * level.denominator <= level.numerator * d**n
    if k >= n * p:
        return level >= 1

    def enclosed(x: Fraction) -> Any:
        return iv.log(iv.mpf(x.numerator) / iv.mpf(x.denominator))

    def number(x: Fraction) -> Any:
        return iv.mpf(x.numerator) / iv.mpf(x.denominator)

    iv.dps = 60
    exponent = number(n - k) * enclosed((n - k) / (n * (1 - p)))
    if k:
        exponent += number(k) * enclosed(k / (n * p))
    room = exponent + enclosed(level)
    rho = k * (1 - p) / ((n - k + 1) * p)
    if is_binary and k and rho < 1:
        square = F(53 * n, 333) / (k * (n - k) * (1 - rho) ** 2)
        if square < 1:
            room -= enclosed(square) / 2
    return bool(room.a >= 0)


def scaled(cell: dict[str, Any], mean: Fraction) -> tuple[int, Fraction, Fraction]:
    low, high = map(F, cell["range"])
    n = cell["draws"]
    return n, (F(cell["sum"]) - n * low) / (high - low), (mean - low) / (high - low)


def informative(cell: dict[str, Any]) -> bool:
    return cell["draws"] > 0 and F(cell["range"][0]) < F(cell["range"][1])


def lower_tail(cell: dict[str, Any], mean: Fraction, level: Fraction) -> bool:
    n, k, p = scaled(cell, mean)
    return bound_exact(n, k, p, cell["binary"], level)


def upper_tail(cell: dict[str, Any], mean: Fraction, level: Fraction) -> bool:
    n, k, p = scaled(cell, mean)
    return bound_exact(n, n - k, 1 - p, cell["binary"], level)


def bernstein(cell: dict[str, Any], mean: Fraction, level: Fraction, above: bool) -> bool:
    n, k, p = scaled(cell, mean)
    low, high = map(F, cell["range"])
    if n < 2:
        return False
    variance = (F(cell["squares"]) - F(cell["sum"]) ** 2 / n) / (n - 1) / (high - low) ** 2
    mp.dps = 60
    lam = F(int(mp.ceil(mp.log(mp.mpf(2) * level.denominator / level.numerator) * 2**120)) + 2, 2**120)
    d = (p - k / n if above else k / n - p) - 7 * lam / (3 * (n - 1))
    return d >= 0 and d * d >= 2 * variance * lam / n


def ends_hold(cell: dict[str, Any], lo: Fraction, hi: Fraction, level: Fraction, method: str) -> bool:
    low, high = map(F, cell["range"])
    if not low <= lo <= hi <= high:
        return False
    if not informative(cell):
        return (lo, hi) == (low, high)
    if cell["binary"] or method == "hoeffding-kl":
        return (hi == high or lower_tail(cell, hi, level)) and (lo == low or upper_tail(cell, lo, level))
    if method == "empirical-bernstein":
        return (hi == high or bernstein(cell, hi, level, True)) and (lo == low or bernstein(cell, lo, level, False))
    half = level / 2
    return (hi == high or lower_tail(cell, hi, half) or bernstein(cell, hi, half, True)) and (
        lo == low or upper_tail(cell, lo, half) or bernstein(cell, lo, half, False)
    )


def corner_ratios(w: dict[int, Fraction], v: dict[int, Fraction], ends: list[tuple[Fraction, Fraction]]) -> list[Any]:
    cells = sorted({*w, *v})
    found = []
    for corner in product(*[ends[i] for i in cells]):
        h = dict(zip(cells, corner, strict=True))
        top, bottom = (sum((x * h[i] for i, x in form.items()), F(0)) for form in (w, v))
        found.append((F(1) if top == 0 else inf) if bottom == 0 else top / bottom)
    return found


def area(b: Fraction, c: Fraction) -> float:
    return float(c) * log(float(c / b**2)) - float(c) + float(b) ** 2


def recheck(evidence: dict[str, Any], lower: Any, upper: Any) -> None:
    """Check an interval by its evidence alone; small boxes by all corners."""
    evidence = json.loads(json.dumps(evidence))
    alpha = 1 - F(evidence["confidence"])
    cells, side = evidence["cells"], evidence["side"]
    blocks = [[{i: F(w) for i, w in form} for form in block] for block in evidence["blocks"]]
    used = {i for block in blocks if len(block) > 1 for form in block for i in form if informative(cells[i])}
    K = len(used)
    pairs = [(b, i, j) for b, block in enumerate(blocks) for i, j in permutations(range(len(block)), 2)]
    s = max(len({*blocks[b][i], *blocks[b][j]} & used) for b, i, j in pairs)
    M = len(pairs)
    if evidence["region"] == "box":
        beta, prime = F(evidence["levels"]["upper"]), F(evidence["levels"]["lower"])
        if K and side == "both":
            plain = s * beta + (2 * K - s) * prime <= alpha
            assert prime <= beta
        elif K:
            plain = s * beta <= alpha if side == "upper" else 2 * K * prime <= alpha
        else:
            plain = beta == prime == 0
        assert plain or (evidence["independent"] and (1 - beta - prime) ** s * (1 - 2 * prime) ** (K - s) >= 1 - alpha)
        ends = {}
        for name, level in (("upper", beta), ("lower", prime)):
            if evidence[name] is not None:
                ends[name] = [(F(a), F(b)) for a, b in evidence[name]]
                for cell, (lo, hi) in zip(cells, ends[name], strict=True):
                    assert ends_hold(cell, lo, hi, level, evidence["method"])
        if side != "lower":
            assert upper >= 1
            assert all(upper >= max(corner_ratios(blocks[b][i], blocks[b][j], ends["upper"])) for b, i, j in pairs)
        if side != "upper" and lower > 1:
            b, i, j = evidence["pair"]
            assert min(corner_ratios(blocks[b][i], blocks[b][j], ends["lower"])) >= lower
        return
    assert evidence["independent"]
    assert all(list(form.values()) == [1] for block in blocks for form in block)
    up, low = ([F(v) for v in evidence["levels"][k]] if evidence["levels"][k] else None for k in ("upper", "lower"))
    spent = 0.0
    for pair in (up, low):
        if pair:
            assert pair[0] ** 2 <= pair[1] <= pair[0]
    if side == "both":
        assert low[0] <= up[0] and low[1] <= up[1]
        spent = 2 * up[0] + max(2, 2 * K - 2) * low[0] + area(*up) + (M - 1) * area(*low)
    else:
        spent = 2 * up[0] + area(*up) if side == "upper" else 2 * K * low[0] + M * area(*low)
    assert spent <= float(alpha)
    if upper != inf:
        assert upper >= 1
        for block, knots in zip([b for b in blocks if len(b) > 1], evidence["upper"], strict=True):
            members = [next(iter(form)) for form in block]
            check_ladder(cells, members, members, upper, [F(q) for q in knots], *up)
    if lower > 1:
        b, i, j = evidence["lower"]["pair"]
        top, bottom = (next(iter(blocks[b][k])) for k in (j, i))
        check_ladder(cells, [top], [bottom], 1 / lower, [F(q) for q in evidence["lower"]["knots"]], *low)


def exact_tail(cell: dict[str, Any], mean: Fraction, lower: bool) -> Fraction:
    n, k, p = scaled(cell, mean)
    if not lower:
        k, p = n - k, 1 - p
    if p <= 0 or k == n:
        return F(1)
    if p >= 1:
        return F(0)
    assert cell["binary"] and n <= 5000
    a, d = p.numerator, p.denominator
    return F(binomial_sum(n, int(k), a, d - a), d**n)


def check_ladder(
    cells: list[dict[str, Any]], tops: list[int], bottoms: list[int], r: Fraction, q: list[Fraction], b: Fraction, c: Fraction
) -> None:
    assert q[0] > 0 and all(x < y for x, y in pairwise(q))
    assert all(q[0] <= F(cells[i]["range"][0]) or upper_tail(cells[i], q[0], b) for i in bottoms)
    for before, at in pairwise(q):
        left = {i: exact_tail(cells[i], r * before, True) for i in tops if r * before < F(cells[i]["range"][1])}
        right = {i: exact_tail(cells[i], at, False) for i in bottoms}
        assert all(t * u <= c for i, t in left.items() for j, u in right.items() if i != j)
    assert all(r * q[-1] >= F(cells[i]["range"][1]) or lower_tail(cells[i], r * q[-1], b) for i in tops)


# Tails and ends


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


@given(st.integers(1, 60), st.data())
def test_binomial_tail_is_the_exact_sum_rounded_up(n: int, data: st.DataObject) -> None:
    k = data.draw(st.integers(0, n))
    p = data.draw(st.fractions(0, 1, max_denominator=10**6))
    exact = sum((comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k + 1)), F(0))
    found = F(tail_bound(binary(n, k), p, "lower"), 2**128)
    assert exact <= found <= exact + F(1, 2**110)
    if p:
        assert tail_bound(binary(n, n - k), 1 - p, "upper") == tail_bound(binary(n, k), p, "lower")


@pytest.mark.parametrize(
    ("n", "k", "p"), [(5001, 2000, "0.41"), (10**6, 10, "3e-5"), (10**6, 1, "1e-5"), (10**5, 99_000, "0.9905"), (6000, 0, "0.001")]
)
def test_tail_of_many_draws_is_above_the_true_one_and_close(n: int, k: int, p: str) -> None:
    found = tail_bound(binary(n, k), F(p), "lower") / 2**128
    true = stats.binom.cdf(k, n, float(F(p)))
    assert true * (1 - 1e-9) <= found <= 1.35 * true
    assert found <= exp(-n * stats.entropy([k / n, 1 - k / n], [float(F(p)), 1 - float(F(p))])) * (1 + 1e-9)


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


def test_tails_bound_the_outcomes_of_bounded_draws() -> None:
    """P(exp(−n·kl) ≤ u) ≤ u at the true mean, by enumeration of all outcomes of three-valued draws."""
    values = [F(0), F(1, 3), F(1)]
    for chances in ([F(1, 2), F(1, 4), F(1, 4)], [F(1, 10), F(4, 5), F(1, 10)], [F(9, 10), F(0), F(1, 10)]):
        mean = sum((p * v for p, v in zip(chances, values, strict=True)), F(0))
        for n in (1, 3, 6):
            outcomes: dict[int, Fraction] = {}
            for a in range(n + 1):
                for b in range(n + 1 - a):
                    chance = F(comb(n, a) * comb(n - a, b)) * chances[0] ** a * chances[1] ** b * chances[2] ** (n - a - b)
                    cell = Cell(n, b * values[1] + (n - a - b), None, F(0), F(1), False)
                    tail = tail_bound(cell, mean, "lower")
                    outcomes[tail] = outcomes.get(tail, F(0)) + chance
            below = F(0)
            for tail in sorted(outcomes):
                below += outcomes[tail]
                assert below * 2**128 <= tail


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


# Quotients over a box


@given(st.data())
def test_linear_fractional_maximum_is_that_of_the_corners(data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 5))
    number = st.integers(0, 6).map(F)
    ends = [tuple(sorted(data.draw(st.tuples(number, number)))) for _ in range(n)]
    w, v = ({i: x for i in range(n) if (x := data.draw(number))} for _ in range(2))
    if not w or not v:
        return
    corners = corner_ratios(w, v, ends)
    found = greatest_ratio(tuple(w.items()), tuple(v.items()), ends)
    if inf in corners or not any(all(lo == 0 for i, (lo, _) in enumerate(ends) if i in form) for form in (w, v)):
        assert found == max(corners)
    assert found >= max(c for c in corners if c != inf)
    random = Random(0)
    for _ in range(20):
        h = [lo + (hi - lo) * F(random.randint(0, 4), 4) for lo, hi in ends]
        top, bottom = (sum((x * h[i] for i, x in form.items()), F(0)) for form in (w, v))
        value = (F(1) if top == 0 else inf) if bottom == 0 else top / bottom
        assert value <= max(found, 1)
        assert value >= min(least_ratio(tuple(w.items()), tuple(v.items()), ends), 1)


# Levels


@given(st.integers(1, 60), st.data(), st.sampled_from(["both", "lower", "upper"]), st.booleans())
def test_levels_are_allowed(cells: int, data: st.DataObject, side: Any, independent: bool) -> None:
    span = data.draw(st.integers(1, cells))
    upper, lower = box_levels(cells, span, ALPHA, independent=independent, side=side)
    assert 0 <= lower <= upper or side == "lower"
    if independent:
        assert (1 - upper - lower) ** span * (1 - 2 * lower) ** (cells - span) >= 1 - ALPHA
    else:
        assert (span * upper + (2 * cells - span) * lower if side == "both" else span * upper + 2 * cells * lower) == ALPHA
    plain = box_levels(cells, span, ALPHA, independent=False, side=side)
    assert upper >= plain[0] and lower >= plain[1]


# Intervals and their evidence


@pytest.mark.parametrize("side", ["both", "lower", "upper"])
@pytest.mark.parametrize(
    "options", [{}, {"independent": True}, {"independent": True, "region": "product"}], ids=["box", "sidak", "product"]
)
def test_evidence_is_enough(options: dict[str, Any], side: Any) -> None:
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
        found = ratio_interval(comparison, "0.9", side=side, **options)
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


# Exact coverage


def coverage(p: list[Fraction], n: list[int], side: Any, **options: Any) -> Fraction:
    """Probability that the interval contains the true ratio, over all outcomes."""
    true = max((a / b if b else inf if a else F(1)) for a, b in permutations(p, 2))
    covered = F(0)
    for outcome in product(*[range(m + 1) for m in n]):
        chance = prod((comb(m, k) * q**k * (1 - q) ** (m - k) for m, k, q in zip(n, outcome, p, strict=True)), start=F(1))
        if chance:
            found = ratio_interval(one_block(*map(binary, n, outcome)), "0.8", side=side, **options)
            covered += chance * (found.lower <= true <= found.upper)
    return covered


@pytest.mark.parametrize("side", ["both", "lower", "upper"])
@pytest.mark.parametrize(
    "options", [{}, {"independent": True}, {"independent": True, "region": "product"}], ids=["box", "sidak", "product"]
)
@pytest.mark.parametrize(
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
def test_exact_coverage(p: list[Fraction], n: list[int], options: dict[str, Any], side: Any) -> None:
    assert coverage(p, n, side, **options) >= F(4, 5)


# Widths


def bonferroni(cells: list[Cell]) -> tuple[float, float]:
    """Clopper–Pearson for each cell at α/(2K), the ratio of extremes."""
    ends = [stats.binomtest(int(c.total), c.draws).proportion_ci(1 - 0.05 / len(cells), method="exact") for c in cells]
    lower = max((a.low / b.high for a, b in permutations(ends, 2)), default=1.0)
    upper = max(a.high / b.low if b.low > 0 else inf for a, b in permutations(ends, 2))
    return max(1.0, lower), upper


WIDTHS = [
    *[([p] * k, [n] * k) for k, p, n in [(2, 0.5, 50), (2, 0.1, 1000), (5, 0.3, 100), (40, 0.5, 1000)]],
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
    import numpy as np

    generator = np.random.default_rng(7)
    widths: dict[str, list[float]] = {"bonferroni": [], "box": [], "sidak": [], "product": [], "default": []}
    for _ in range(repetitions):
        cells = [binary(m, int(k)) for m, k in zip(n, generator.binomial(n, p), strict=True)]
        lower, upper = bonferroni(cells)
        if upper == inf:
            continue
        widths["bonferroni"].append(log(upper / lower))
        for name, options in (("box", {}), ("sidak", {"independent": True}), ("product", {"independent": True, "region": "product"})):
            found = ratio_interval(one_block(*cells), **options)
            widths[name].append(log(found.upper) - log(found.lower))
        widths["default"].append(widths[default_region(one_block(*cells), independent=True).replace("box", "sidak")][-1])
    return {name: float(np.median(values)) for name, values in widths.items()}


def test_widths_against_bonferroni() -> None:
    found = [median_widths(p, n, 9) for p, n in WIDTHS]
    for (p, n), widths in zip(WIDTHS, found, strict=True):
        print(len(p), n[0], {name: round(value, 4) for name, value in widths.items()})
    assert all(w["box"] <= w["bonferroni"] * (1 + 1e-5) for w in found)
    assert all(w["sidak"] < w["bonferroni"] for w in found)
    assert all(w["default"] < w["bonferroni"] for w in found)
    assert all(w["product"] < 1.03 * w["bonferroni"] for w in found)
    assert sum(w["product"] < 0.9 * w["bonferroni"] for w in found) >= len(found) / 2


# Policies behind filters


def sampled_policy(drop: tuple[str, str] | None = None) -> Policy:
    rows = {"x": [], "a": [], "u": [], "n": []}
    random = Random(2)
    for x in "PQ":
        for a in "fmo":
            if (x, a) != drop:
                k = random.randint(20, 80)
                for u, n in (("yes", k), ("no", 100 - k)):
                    for name, value in zip("xaun", (x, a, u, n), strict=True):
                        rows[name].append(value)
    return Policy.from_counts(rows, decision="u", group="a", context="x", count="n")


def test_forms_are_the_induced_law() -> None:
    policy = sampled_policy()
    group = RandomizedResponse(["f", "m", "o"], keep_probability="0.6")
    context = RandomizedResponse(["P", "Q"], keep_probability="0.8")
    table = {(x, a): F(i + 1) for i, (x, a) in enumerate(product([("P",), ("Q",)], [("f",), ("m",), ("o",)]))}
    deployed = policy.behind(group=group, context=context, population=table)
    by_context = Utility.from_function(lambda u, x, a: (2 if x == ("P",) else 3) * (u == "yes"), deployed.law)
    by_group = Utility.from_function(lambda u, x, a: (2 if a == ("f",) else 3) * (u == "yes"), deployed.law)
    for utility, cells in ((Utility({"yes": 1}), 6), (by_context, 12), (by_group, 36)):
        values = utility.on(deployed.law)
        expected = {}
        for i, (x, a) in enumerate(zip(deployed.law.cell_context.tolist(), deployed.law.cell_group.tolist(), strict=True)):
            row = deployed.law.row(i)
            expected[x, a] = F(sum(w * g for w, g in zip(row, values.row(i), strict=True)), sum(row) * values.scale)
        comparison = policy_comparison(policy, utility, group, context)
        assert len(comparison.cells) == cells
        assert comparison.dependent == (cells > 6)
        for x, block in enumerate(comparison.blocks):
            for a, form in enumerate(block):
                assert sum(w * comparison.cells[i].mean for i, w in form) == expected[x, a]
        means = policy_comparison(policy, utility, group, context, table, local=False)
        for a, form in enumerate(means.blocks[0]):
            mass = [table[x, group.inputs[a]] for x in (("P",), ("Q",))]
            mean = (mass[0] * expected[0, a] + mass[1] * expected[1, a]) / sum(mass)
            assert sum(w * means.cells[i].mean for i, w in form) == mean
    found = ratio_interval(policy_comparison(policy, Utility({"yes": 1}), group, context))
    assert found.lower <= found.estimate <= found.upper
    recheck(found.evidence, found.lower, found.upper)
    identity = ratio_interval(policy_comparison(policy, Utility({"yes": 1}), Identity(["f", "m", "o"])))
    assert found.upper < identity.upper


def test_cells_without_draws_are_the_whole_range() -> None:
    group = RandomizedResponse(["f", "m", "o"], keep_probability="0.6")
    whole = policy_comparison(sampled_policy(), Utility({"yes": 1}), group)
    lacking = policy_comparison(sampled_policy(("Q", "m")), Utility({"yes": 1}), group)
    assert [c.draws for c in lacking.cells].count(0) == 1
    first, second = ratio_interval(whole), ratio_interval(lacking)
    assert second.upper > first.upper
    assert second.estimate is None
    recheck(second.evidence, second.lower, second.upper)


def test_attributes_filtered_apart() -> None:
    cells = {"x": ["P"] * 8, "s": list("ffffmmmm"), "g": list("aabbaabb"), "u": ["yes", "no"] * 4, "n": [30, 10, 20, 20, 10, 30, 15, 25]}
    policy = Policy.from_counts(cells, decision="u", group=["s", "g"], context="x", count="n")
    parts = {"s": RandomizedResponse(["f", "m"], keep_probability="0.7"), "g": RandomizedResponse(["a", "b"], keep_probability="0.9")}
    comparison = policy_comparison(policy, Utility({"yes": 1}), Product(parts))
    assert comparison.span == 4 == len(comparison.used)
    recheck(ratio_interval(comparison).evidence, *[getattr(ratio_interval(comparison), k) for k in ("lower", "upper")])


# The global ratio


def test_global_ratio_of_a_sample_pools_the_contexts(data: Path) -> None:
    law = Law.from_counts(read_csv(data / "ucb_admissions.csv"), decision="Admit", group="Gender", context="Dept", count="Freq")
    utility = Utility({"Admitted": 1}).on(law)
    pooled = global_comparison(law, utility)
    assert [(c.draws, c.binary) for c in pooled.cells] == [(2691, True), (1835, True)]
    found = ratio_interval(pooled)
    assert found.estimate == F(2198330, 1498887)
    assert 1.25 < found.lower < found.upper < 1.7
    local = ratio_interval(local_comparison(law, utility))
    assert local.estimate == F(24475, 18432)
    assert local.lower <= local.estimate <= local.upper
    equal = {((d,), (g,)): 1 for d in "ABCDEF" for g in ("Male", "Female")}
    stated = ratio_interval(global_comparison(law, utility, equal))
    assert stated.lower == 1
    recheck(stated.evidence, stated.lower, stated.upper)


def test_estimated_population() -> None:
    policy = sampled_policy()
    group = RandomizedResponse(["f", "m", "o"], keep_probability="0.9")
    comparison = policy_comparison(policy, Utility({"yes": 1}), group)
    counts = [[400, 300, 100], [200, 300, 500]]
    found = sampled_population_interval(comparison, counts)
    assert found.lower <= found.estimate <= found.upper
    table = {
        (x, a): F(counts[i][j], sum(row[j] for row in counts)) for i, x in enumerate([("P",), ("Q",)]) for j, a in enumerate(group.inputs)
    }
    known = ratio_interval(policy_comparison(policy, Utility({"yes": 1}), group, None, table, local=False))
    assert found.estimate == known.estimate
    assert found.upper > known.upper
    more = sampled_population_interval(comparison, [[10**6 * n for n in row] for row in counts])
    assert more.upper < found.upper
    # Every population and every mean within the evidence's ends is covered.
    ends = [(F(a), F(b)) for a, b in found.evidence["ends"]]
    random = Random(1)
    for _ in range(200):
        h = [random.choice(pair) for pair in ends]
        means = []
        for a, shares in enumerate(found.evidence["population"]):
            (lo, hi), other = ((F(v) for v in pair) for pair in shares)
            lo2, hi2 = other
            p = random.choice([max(lo, 1 - hi2), min(hi, 1 - lo2)])
            form = [sum(w * h[i] for i, w in block[a]) for block in comparison.blocks]
            means.append(p * form[0] + (1 - p) * form[1])
        assert max(means) / min(means) <= found.upper
    for bad in ([[1, 2, 3]], [[1, 2], [3, 4]], [[1, 2, 0], [1, 1, 0]], [[1.5, 1, 1], [1, 1, 1]]):
        with pytest.raises(InputError):
            sampled_population_interval(comparison, bad)


# Sampling units


def test_units_count_once() -> None:
    rows = {"a": [], "u": [], "run": []}
    random = Random(4)
    for run in range(60):
        for a in "fm":
            answer = random.choice(["yes", "no"])
            for _ in range(5):  # five copies of one answer
                rows["a"].append(a)
                rows["u"].append(answer)
                rows["run"].append(f"{run}{a}")
    law = Law.from_log(rows, decision="u", group="a")
    naive = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)))
    comparison = by_unit(rows, Utility({"yes": 1}), decision="u", group="a")
    honest = ratio_interval(comparison)
    assert [c.draws for c in comparison.cells] == [60, 60]
    assert not comparison.dependent
    assert honest.estimate == naive.estimate
    assert honest.upper > naive.upper
    recheck(honest.evidence, honest.lower, honest.upper)


def test_units_that_span_cells_are_not_independent() -> None:
    rows = {"a": list("fmfm"), "u": ["yes", "no", "yes", "yes"], "run": [1, 1, 2, 2]}
    comparison = by_unit(rows, Utility({"yes": 1}), decision="u", group="a")
    assert comparison.dependent and all(cell.binary for cell in comparison.cells)
    assert any("2 of 2 units" in note for note in comparison.notes)
    with pytest.raises(InputError, match="not independent"):
        ratio_interval(comparison, independent=True)
    rows["run"][0] = None
    with pytest.raises(InputError, match="row 1: the sampling unit has no label"):
        by_unit(rows, Utility({"yes": 1}), decision="u", group="a")


# What follows


def test_verdicts() -> None:
    assert verdict((F(1), inf), max_log=100) == "inconclusive"
    assert verdict((F(1), F(1)), max_log=0) == "within"
    assert verdict((F(3, 2), inf), max_log="0.4") == "exceeds"
    assert verdict((F(5, 4), F(2)), max_ratio="5/4") == "inconclusive"
    assert verdict(ratio_interval(one_block(binary(1, 1), binary(1, 1))), max_ratio="5/4") == "inconclusive"


def test_planning_agrees_with_what_happens() -> None:
    small = one_block(binary(40, 20), binary(40, 20))
    assert verdict(ratio_interval(small), max_log="0.2") == "inconclusive"
    more = further_draws(small, max_log="0.2")
    assert more.decides == "within" and "estimate" in more.sentence
    n = 40 + more.draws[0]
    n += n % 2
    assert verdict(ratio_interval(one_block(binary(n, n // 2), binary(n, n // 2))), max_log="0.201") == "within"
    assert verdict(ratio_interval(one_block(binary(n // 2, n // 4), binary(n // 2, n // 4))), max_log="0.2") == "inconclusive"
    assert further_draws(one_block(binary(40, 30), binary(40, 10)), max_log="0.2").draws == (0, 0)
    chance = further_draws(one_block(binary(40, 21), binary(40, 14)), max_log="0.2")
    assert chance.decides is None and chance.draws[0] > 0 and chance.total < chance.total_if_equal
    assert "if the truth were as measured (a ratio of 1.5)" in chance.sentence and "may be chance alone" in chance.sentence
    exceeding = further_draws(one_block(binary(400, 210), binary(400, 150)), max_log="0.2")
    assert exceeding.decides == "exceeds" and exceeding.draws[0] > 0 and exceeding.total_if_equal is None
    assert further_draws(one_block(binary(40, 30), binary(40, 20)), max_ratio="3/2").draws is None
    assert further_draws(one_block(binary(40, 20), Cell(0, F(0), None, F(0), F(1), True)), max_log="0.2").draws is None


def test_plan() -> None:
    half = plan(["0.5", "0.5"], max_log="0.2", power=0.5).draws[0]
    assert half < plan(["0.5", "0.5"], max_log="0.2").draws[0] < plan(["0.5", "0.5", "0.5"], max_log="0.2", power=0.9).draws[0]
    k = (half + 1) // 2
    assert verdict(ratio_interval(one_block(binary(2 * k, k), binary(2 * k, k))), max_log="0.2002") == "within"
    assert plan(["0.5", "0.4"], max_log="0.1").decides == "exceeds"
    assert plan(["0.5", "0.4"], max_ratio="5/4").draws is None
    assert plan(["2", "2"], max_log="0.2", limits=(1, 4), binary=False).draws is not None
    guessed = policy_comparison(sampled_policy(), Utility({"yes": 1}), RandomizedResponse(["f", "m", "o"], keep_probability="0.4"))
    assert plan(guessed, max_log="0.3").decides == "within"
    for bad in (["0.5"], ["0.5", "2"]):
        with pytest.raises(InputError):
            plan(bad, max_log="0.2")
    with pytest.raises(InputError, match="power"):
        plan(["0.5", "0.5"], max_log="0.2", power=1)


def test_a_filter_is_refuted_by_draws_that_are_too_unequal() -> None:
    law = Law.from_array([[900, 100], [100, 900]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    draws = local_comparison(law, Utility({"yes": 1}).on(law))
    assert test_filter(draws, 2).refuted
    found = test_filter(draws, 9)
    assert not found.refuted and "prove nothing" in found.sentence
    assert not test_filter(draws, "inf").refuted
    recheck(found.interval.evidence, found.interval.lower, found.interval.upper)
    by_group = Utility.from_function(lambda u, x, a: (1 if a == ("f",) else 2) * (u == "yes"), law).on(law)
    with pytest.raises(InputError, match="depends on the group"):
        test_filter(local_comparison(law, by_group), 2)
    with pytest.raises(InputError, match="at least 1"):
        test_filter(draws, "0.5")


def test_noise_floor() -> None:
    quiet, loud = one_block(binary(500, 250), binary(500, 250)), one_block(binary(500, 400), binary(500, 100))
    assert noise_floor(loud, quiet).rises
    found = noise_floor(quiet, loud)
    assert not found.rises and "does not rise above" in found.sentence
    assert found.effect.confidence == F(39, 40)


# The range of g


def test_what_was_not_seen_is_still_possible() -> None:
    law = Law.from_array([[10], [10]], kind="counts", decisions=["yes"], groups=["f", "m"])
    found = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)))
    assert found.lower == 1 and found.upper > 1
    values = Law.from_array([[5, 5], [5, 5]], kind="counts", decisions=["slow", "fast"], groups=["f", "m"])
    waiting = Utility({"slow": 4, "fast": 1}).on(values)
    assert not local_comparison(values, waiting).cells[0].binary
    closed = local_comparison(values, waiting, limits=(1, 4))
    # Only 1 and 4 were drawn, but anything between could have been: no binomial ends.
    assert not closed.cells[0].binary and any("between 1 and 4" in text for text in closed.assumptions)
    assert ratio_interval(closed).upper < ratio_interval(local_comparison(values, waiting)).upper
    with pytest.raises(InputError, match="outside the declared limits"):
        local_comparison(values, waiting, limits=(1, 3))
    for limits in ((3, 1), (-1, 4)):
        with pytest.raises(InputError, match="limits are at least 0"):
            local_comparison(values, waiting, limits=limits)


# Bad input


@pytest.mark.parametrize("value", [0, 1, "1.5", -1, "nan", float("nan"), True, None, "95%"])
def test_confidence_is_a_probability(value: Any) -> None:
    with pytest.raises(InputError):
        ratio_interval(one_block(binary(5, 2), binary(5, 2)), value)


def test_a_float_confidence_is_what_it_says() -> None:
    assert confidence_level(0.95) == F(19, 20) == confidence_level("19/20")


def test_only_whole_counts_carry_a_sample_size() -> None:
    table = {"u": ["yes", "no"] * 2, "a": ["f", "f", "m", "m"], "n": ["2.5", "1", "3", "1"]}
    law = Law.from_counts(table, decision="u", group="a", count="n")
    with pytest.raises(InputError, match="whole counts"):
        local_comparison(law, Utility({"yes": 1}).on(law))
    shares = Law.from_array([[0.5, 0.5], [0.2, 0.8]], decisions=["yes", "no"])
    with pytest.raises(InputError, match="no sample size"):
        local_comparison(shares, Utility({"yes": 1}).on(shares))
    policy = Policy.from_array([[0.5, 0.5], [0.2, 0.8]], decisions=["yes", "no"], groups=["f", "m"])
    with pytest.raises(InputError, match="no sample size"):
        policy_comparison(policy, Utility({"yes": 1}), Identity(["f", "m"]))


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


# Real data


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


def test_names_against_the_placebo(data: Path) -> None:
    names, edits = read_csv(data / "hiringbias_firstname.csv"), read_csv(data / "hiringbias_placebo.csv")
    utility = Utility({"yes": 1, "maybe": 1})
    tables = [
        Law.from_log(table, decision="recommend_interview", group=group, context="model")
        for table, group in ((names, "name"), (edits, "placebo"))
    ]
    effect, placebo = (local_comparison(law, utility.on(law)) for law in tables)
    found = noise_floor(effect, placebo)
    assert found.effect.estimate == F(3, 2)
    assert not found.rises


@pytest.mark.parametrize("factor", [1, 100])
def test_planning_for_many_cells_looks_at_those_that_decide(monkeypatch: pytest.MonkeyPatch, factor: int) -> None:
    """The estimate is that of all cells."""
    pick = np.random.default_rng(factor)
    law = Law.from_array(pick.integers(30 * factor, 90 * factor, (60, 3, 2)), kind="counts")
    comparison = local_comparison(law, Utility({"0": 1, "1": "0.25"}).on(law))
    quick = further_draws(comparison, max_ratio="2.2")
    monkeypatch.setattr(quotients, "DECISIVE_CELLS", 10**9)
    full = further_draws(comparison, max_ratio="2.2")
    assert quick.decides == full.decides is not None
    assert full.draws is not None
    assert quick.draws == pytest.approx(full.draws, rel=0.01)


@pytest.mark.parametrize("unit", ["1e-400", "1e-30", "1e30", "1e400"])
def test_many_cells_have_the_same_interval_in_every_unit_of_utility(unit: str) -> None:
    """Whether or not floats could hold the numbers."""
    law = Law.from_array(np.random.default_rng(5).integers(1, 100, (20, 8, 3)), kind="counts")
    known = ratio_interval(local_comparison(law, Utility({"0": 1, "1": "0.5"}).on(law)), "0.95")
    half = str(Decimal(unit) / 2)
    found = ratio_interval(local_comparison(law, Utility({"0": unit, "1": half}).on(law)), "0.95")
    assert found.upper == known.upper > 1
    assert abs(found.lower / known.lower - 1) < F(1, 100_000)


@given(st.integers(0, 10**6), st.booleans())
@settings(max_examples=25)
def test_many_cells_have_the_interval_of_all_of_them(seed: int, binary: bool) -> None:
    """Narrowing only the ends that decide changes no interval: the upper end is the same, and the lower one all but."""
    pick = np.random.default_rng(seed)
    law = Law.from_array(pick.integers(0, 10 ** pick.integers(1, 5), (pick.integers(1, 5), pick.integers(2, 12), 3)) + 1, kind="counts")
    utility = Utility({"0": 1} if binary else {"0": 1, "1": "0.3"}).on(law)
    comparison = local_comparison(law, utility)
    found = []
    for least in (10**9, 0):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(quotients, "DECISIVE_CELLS", least)
            found.append(ratio_interval(comparison, "0.95"))
    every, decisive = found
    assert decisive.upper == every.upper
    assert every.lower * F(999_999, 1_000_000) <= max(decisive.lower, F(1)) <= every.lower


@given(st.integers(0, 10**6), st.sampled_from(["binary", "many", "declared", "zero"]))
@settings(max_examples=12, deadline=None)
def test_certificates_of_many_cells_are_accepted(seed: int, kind: str) -> None:
    """Ends in closed form, sums over groups and the estimate, checked from the certificate alone."""
    pick = np.random.default_rng(seed)
    counts = pick.integers(0, 10 ** pick.integers(1, 6), (pick.integers(30, 60), 4, 3)) + (pick.random((1, 1, 3)) < 0.7)
    law = Law.from_array(counts + (counts.sum(axis=2, keepdims=True) == 0), kind="counts")
    utility = {"binary": {"0": 1}, "many": {"0": 3, "1": "0.7"}, "declared": {"0": "1.5", "1": 1, "2": "0.5"}, "zero": {"2": "1e-30"}}[kind]
    declared = {"gamma": 2, "m": "0.25"} if kind == "declared" else {}
    result = certify(law, utility, max_local_ratio=3, max_global_log="0.1", declared=declared)
    report = checker.check(result.certificate.text.encode())
    assert all(finding.true for finding in report.findings), [finding for finding in report.findings if not finding.true]
    assert result.intervals["local"].estimate == (result.local.ratio if result.local else None)
    assert result.intervals["global"].estimate == (result.global_.ratio if result.global_ else None)
