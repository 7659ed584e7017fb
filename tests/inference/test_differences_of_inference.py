"""Intervals of differences: how often they err, what proves them, and what they do not depend on."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from math import comb, prod
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interval_oracle import binary, bound_exact, one_block, scaled
from pair_oracle import rarity

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.differences import difference_drivers, difference_interval
from fairaudit.inference.pair_exact import order_scale
from fairaudit.inference.table_comparisons import global_comparison, local_comparison

F = Fraction
CELL = st.integers(1, 40).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n)))
MEANS = ((0.5, 0.5), (0.6, 0.4), (0.3, 0.6), (0.9, 0.8), (0.2, 0.2), (1.0, 0.5), (0.0, 0.1), (0.05, 0.0))


def pairs(comparison: Comparison, confidence: str = "0.95", **options: Any) -> Any:
    return difference_interval(comparison, confidence, region="pairs", independent=True, **options)


def signed_cell(cell: tuple[int, int], low: Fraction, high: Fraction) -> Cell:
    n, k = cell
    return Cell(n, n * low + k * (high - low), None, low, high, binary=True)


def recheck(found: Any, comparison: Comparison) -> None:
    """What docs/certificate-samples.md asks of the evidence, by another reading, to fifteen digits where tails are summed."""
    evidence, alpha = found.evidence, 1 - found.confidence
    ends = evidence["ends"]
    members = [[form[0][0] for form in block] for block in comparison.blocks]
    if evidence["region"] == "box":
        used, beta, other = len(comparison.used), *(F(evidence["levels"][name]) for name in ("upper", "lower"))
        if not evidence["independent"]:
            spent = [2 * beta, 2 * used * other] if ends == "each" else [2 * beta + (2 * used - 2) * other]
            assert all(each <= alpha for each in spent)
        boxes = [[(F(a), F(b)) for a, b in evidence[name]] for name in ("upper", "lower")]
        for box, level in zip(boxes, (beta, other), strict=True):
            for i, (lo, hi) in enumerate(box):
                cell = evidence["cells"][i]
                if lo > F(cell["range"][0]):
                    n, k, p = scaled(cell, lo)
                    assert bound_exact(n, n - k, 1 - p, cell["binary"], level)
                if hi < F(cell["range"][1]):
                    assert bound_exact(*scaled(cell, hi), cell["binary"], level)
        upper, lower = boxes
        couples = [(i, j) for block in members for i, j in permutations(block, 2)]
        assert found.upper == max(upper[i][1] - upper[j][0] for i, j in couples)
        assert found.lower == max(F(0), *(lower[i][0] - lower[j][1] for i, j in couples))
        return
    cells = comparison.cells
    width, share = cells[0].high - cells[0].low, alpha if ends == "each" else alpha / 2
    couples = [(i, j) for block in members for i, j in permutations(block, 2)]
    levels = share, share / len(couples)
    scales = [order_scale(level * (1 if ends == "each" else 2)) for level in levels]

    def holds(i: int, j: int, limit: Fraction, which: int, knots: Any) -> bool:
        counts = int(cells[i].successes), cells[i].draws, int(cells[j].successes), cells[j].draws
        return rarity(counts, limit / width, levels[which], [F(q) for q in knots], scales[which], True) <= 1

    if evidence["upper"] is None:
        assert found.upper == width
    else:
        assert all(holds(*couple, found.upper, 0, knots) for couple, knots in zip(couples, evidence["upper"], strict=True))
    assert (found.lower > 0) == (evidence["lower"] is not None)
    if evidence["lower"] is not None:
        b, i, j = evidence["lower"]["pair"]
        assert holds(members[b][j], members[b][i], -found.lower, 1, evidence["lower"]["knots"])


@given(
    st.lists(CELL, min_size=2, max_size=4), st.sampled_from(["0.5", "0.95", "0.999"]), st.sampled_from(["together", "each"]), st.booleans()
)
@settings(max_examples=20, deadline=None)
def test_its_evidence_proves_it(cells: list[tuple[int, int]], confidence: str, ends: Any, exact: bool) -> None:
    comparison = one_block(*(signed_cell(cell, F(-1), F(1, 2)) for cell in cells))
    found = (pairs if exact else difference_interval)(comparison, confidence, ends=ends)
    assert found.lower >= 0 and found.upper <= F(3, 2)
    recheck(found, comparison)


@pytest.mark.parametrize(("n", "m"), [(4, 3), (1, 4), (1, 1), (7, 2)])
@pytest.mark.parametrize("confidence", ["0.5", "0.9"])
@pytest.mark.parametrize("exact", [True, False])
def test_each_end_errs_no_more_often_than_it_says(n: int, m: int, confidence: str, exact: bool) -> None:
    """All outcomes of two cells, at true means of 0 and 1 too."""
    of = pairs if exact else difference_interval
    outcomes = [(k, j) for k in range(n + 1) for j in range(m + 1)]
    for ends, alpha in (("each", 1 - float(confidence)), ("together", 1 - float(confidence))):
        found = {(k, j): of(one_block(binary(n, k), binary(m, j)), confidence, ends=ends) for k, j in outcomes}
        for p, q in MEANS:
            missed = [0.0, 0.0, 0.0]
            for (k, j), interval in found.items():
                chance = comb(n, k) * p**k * (1 - p) ** (n - k) * comb(m, j) * q**j * (1 - q) ** (m - j)
                below, above = float(interval.upper) < abs(p - q) - 1e-12, float(interval.lower) > abs(p - q) + 1e-12
                missed = [missed[0] + chance * below, missed[1] + chance * above, missed[2] + chance * (below or above)]
            assert max(missed[:2]) <= alpha + 1e-12, (p, q)
            assert ends == "each" or missed[2] <= alpha + 1e-12, (p, q)


def test_ends_that_never_err_would_be_too_wide() -> None:
    n = 7
    found = {(k, j): pairs(one_block(binary(n, k), binary(n, j)), "0.6", ends="each") for k in range(n + 1) for j in range(n + 1)}
    worst = [0.0, 0.0]
    for p, q in ((0.5, 0.5), (0.7, 0.4), (0.9, 0.3), (0.55, 0.45)):
        chances = {key: prod(comb(n, k) * r**k * (1 - r) ** (n - k) for k, r in zip(key, (p, q), strict=True)) for key in found}
        missed = [
            sum(c for key, c in chances.items() if found[key].upper < p - q),
            sum(c for key, c in chances.items() if found[key].lower > p - q),
        ]
        worst = [max(one, other) for one, other in zip(worst, missed, strict=True)]
    assert worst[0] > 0.25 and worst[1] > 0.1


@given(st.lists(CELL, min_size=2, max_size=3), st.sampled_from([("-1", "1"), ("-5", "-3"), ("0", "7"), ("-1/3", "1/7")]), st.booleans())
@settings(max_examples=10, deadline=None)
def test_it_scales_with_the_unit_and_does_not_depend_on_the_origin(
    cells: list[tuple[int, int]], ends: tuple[str, str], exact: bool
) -> None:
    low, high = map(F, ends)
    of = pairs if exact else difference_interval
    one, other = of(one_block(*(binary(*cell) for cell in cells))), of(one_block(*(signed_cell(cell, low, high) for cell in cells)))
    assert (other.lower, other.upper) == (one.lower * (high - low), one.upper * (high - low))


def test_department_a_of_berkeley() -> None:
    """The page's figures: .130 to .266, one-sided; by the lattice of limits the upper end is 533/2000."""
    law = fa.Law.from_array([[89, 19], [512, 313]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    compared = local_comparison(law, fa.Utility({"yes": 1}).on(law))
    found = pairs(compared, "0.95", ends="each")
    assert found.upper == F(533, 2000) and found.lower < F(13, 100)
    both = pairs(compared, "0.9", ends="together")  # a two-sided upper end at 90 % is the one-sided one at 95 %
    assert both.upper == found.upper


def test_forms_of_several_cells_are_compared_over_the_box() -> None:
    cells = (binary(50, 40), binary(60, 12), binary(40, 20))
    half = F(1, 2)
    comparison = Comparison(cells, ((((0, half), (1, half)), ((1, half), (2, half)), ((2, F(1)),)),))
    found = difference_interval(comparison, "0.9", ends="each")
    outer = [(F(a), F(b)) for a, b in found.evidence["upper"]]
    inner = [(F(a), F(b)) for a, b in found.evidence["lower"]]
    weights = [{0: half, 1: half}, {1: half, 2: half}, {2: F(1)}]
    corners = [[ends[i][c >> i & 1] for i in range(3)] for ends in (outer,) for c in range(8)]
    couples = [*permutations(weights, 2)]

    def apart(one: dict[int, Fraction], other: dict[int, Fraction], at: list[Fraction]) -> Fraction:
        return sum((w * at[i] for i, w in one.items()), F(0)) - sum((w * at[i] for i, w in other.items()), F(0))

    assert found.upper == max(apart(*couple, at) for couple in couples for at in corners)
    corners = [[inner[i][c >> i & 1] for i in range(3)] for c in range(8)]
    assert found.lower == max(F(0), *(min(apart(*couple, at) for at in corners) for couple in couples))
    assert difference_drivers(
        Comparison(cells, comparison.blocks, ((None, ({"g": "a"}, {"g": "b"}, {"g": "c"})),)), found.evidence, found.upper
    )[1]


def test_many_cells_end_where_few_do() -> None:
    """Of many cells only those that decide have narrow ends."""
    pick = np.random.default_rng(3)
    cells = tuple(binary(40, int(k)) for k in pick.binomial(40, 0.5, 150))
    blocks = tuple(tuple(((i + j, F(1)),) for j in range(3)) for i in range(0, 150, 3))
    comparison = Comparison(cells, blocks)
    found = difference_interval(comparison, "0.95", ends="each")
    recheck(found, comparison)
    from fairaudit.inference.ends import ends_of_cells

    ends = ends_of_cells(comparison, F(found.evidence["levels"]["upper"]), "hoeffding-kl")
    assert found.upper == max(ends[i][1] - ends[j][0] for block in range(0, 150, 3) for i, j in permutations(range(block, block + 3), 2))


def won(xs: list[Fraction], ys: list[Fraction], limit: Fraction) -> Fraction:
    """What bets on the contrast of all pairings won against E(x) ≥ E(y) + limit, from the page: elementary symmetric means, exactly."""
    pairs = min(len(xs), len(ys))
    most = pairs**2 * (F(1, len(xs)) + F(1, len(ys)))
    made = [bet for k in range(64) for bet in (F(15, 16) / 2**k, F(2, 3) / 2**k)]
    stop = next(i for i, bet in enumerate(made) if bet**2 * most <= 24)

    def means(values: list[Fraction]) -> list[Fraction]:
        sums = [F(1)] + [F(0)] * pairs
        for v in values:
            for k in range(pairs, 0, -1):
                sums[k] += v * sums[k - 1]
        return [e / comb(len(values), k) for k, e in enumerate(sums)]

    found = []
    for bet in made[: stop + 1]:
        of_x, of_y = means([1 + bet * (limit - x) / 2 for x in xs]), means([bet * y / 2 for y in ys])
        found.append(sum((comb(pairs, k) * of_y[k] * of_x[pairs - k] for k in range(pairs + 1)), F(0)))
    return sum(found, F(0)) / len(found)


@given(st.lists(st.lists(st.integers(1, 6), min_size=3, max_size=3), min_size=2, max_size=3), st.sampled_from(["each", "together"]))
@settings(max_examples=15, deadline=None)
def test_contrasts_prove_what_the_page_says(counts: list[list[int]], ends: Any) -> None:
    law = fa.Law.from_array(counts, kind="counts", decisions=["a", "b", "c"])
    values = [F(-1), F(0), F(2)]
    compared = local_comparison(law, fa.Utility(dict(zip("abc", values, strict=True)), signed=True).on(law))
    found = difference_interval(compared, "0.8", region="contrasts", independent=True, ends=ends)
    draws = [[(v + 1) / 3 for v, n in zip(values, row, strict=True) for _ in range(n)] for row in counts]
    couples = [*permutations(range(len(draws)), 2)]
    level = F(1, 5) / (1 if ends == "each" else 2)
    assert F(found.evidence["levels"]["lower"]) == level / len(couples)
    if found.upper < 3:
        assert all(won(draws[i], draws[j], found.upper / 3) * level >= 1 for i, j in couples)
        assert any(won(draws[i], draws[j], found.upper / 3 - F(1, 1000)) * level < 1 for i, j in couples)
    if found.lower > 0:
        _, i, j = found.evidence["pair"]
        assert won(draws[j], draws[i], -found.lower / 3) * level / len(couples) >= 1


def test_what_is_not_bounded_is_refused() -> None:
    law = fa.Law.from_array([[9, 1, 3], [5, 5, 2]], kind="counts")
    table = fa.Utility({"0": 1, "1": -1}, signed=True).on(law)
    compared = local_comparison(law, table)
    with pytest.raises(InputError, match="the exact pair bound needs independent cells"):
        pairs(compared)
    with pytest.raises(InputError, match="is not accepted"):
        difference_interval(compared, "1")
    with pytest.raises(InputError, match="method"):
        difference_interval(compared, method="gauss")  # type: ignore[arg-type]
    assert difference_interval(compared).methods == ("hoeffding-kl",)
    assert global_comparison(law, table).cells[0].low == -1


SETTINGS = {
    "three values, three groups": ((-1, 0, 2), [(0.2, 0.5, 0.3), (0.3, 0.4, 0.3), (0.25, 0.5, 0.25)], (30, 5, 60)),
    "one draw beside many": ((-1, 0, 1), [(0.5, 0.0, 0.5), (0.1, 0.1, 0.8)], (1, 80)),
    "all the same": ((-3, -1, 1), [(0.0, 1.0, 0.0), (0.0, 1.0, 0.0)], (10, 12)),
}


@pytest.mark.parametrize("method", ["hoeffding-kl", "empirical-bernstein", "intersection", "contrasts"])
@pytest.mark.parametrize("name", SETTINGS)
def test_many_valued_draws_are_covered(name: str, method: Any) -> None:
    values, laws, sizes = SETTINGS[name]
    pick = np.random.default_rng(11)
    means = [sum(v * p for v, p in zip(values, law, strict=True)) for law in laws]
    true, misses, count = max(means) - min(means), [0, 0], 25 if method == "contrasts" else 100
    for _ in range(count):
        array = [pick.multinomial(n, law).tolist() for n, law in zip(sizes, laws, strict=True)]
        law = fa.Law.from_array(array, kind="counts", decisions=["a", "b", "c"])
        compared = local_comparison(law, fa.Utility(dict(zip("abc", values, strict=True)), signed=True).on(law))
        options = {"region": "contrasts", "independent": True} if method == "contrasts" else {"method": method}
        found = difference_interval(compared, "0.5", ends="each", **options)
        misses = [misses[0] + (float(found.upper) < true - 1e-9), misses[1] + (float(found.lower) > true + 1e-9)]
    assert max(misses) <= {25: 24, 100: 80}[count]  # at 50 %: more would have a probability below one in a million
