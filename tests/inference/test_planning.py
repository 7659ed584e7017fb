"""How many draws would decide."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from interval_oracle import (
    F,
    binary,
    bounded,
    one_block,
    sampled_policy,
)

import fairaudit as fa
from fairaudit import Law, RandomizedResponse, Utility
from fairaudit.errors import InputError
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.interval import Selection
from fairaudit.inference.planning import further_draws, plan
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.inference.verdicts import verdict


def decided(
    rows: list[list[float]],
    draws: tuple[int, ...],
    side: str,
    *,
    independent: bool,
    limit: str,
    runs: int = 40,
    select: Selection = "bonferroni",
) -> float:
    """How often an audit decides on a side."""
    pick = np.random.default_rng(len(draws))
    found = 0
    for _ in range(runs):
        counts = [binary(n, int(pick.binomial(n, p))) for n, p in zip(draws, [p for row in rows for p in row], strict=True)]
        places = iter(range(len(counts)))
        blocks = tuple(tuple(((next(places), F(1)),) for _ in row) for row in rows)
        labels = tuple(({"x": str(x)}, tuple({"a": str(a)} for a in range(len(row)))) for x, row in enumerate(rows))
        compared = Comparison(tuple(counts), blocks, labels)
        region = default_region(compared, independent=independent)
        interval = ratio_interval(compared, region=region, independent=independent, ends="each", select=select)
        found += verdict(interval, max_ratio=limit) == side
    return found / runs


@pytest.mark.parametrize(
    ("rows", "independent", "limit"),
    [
        ([[0.5, 0.5]], False, "2"),
        ([[0.3, 0.3, 0.2]], False, "3"),
        ([[0.5, 0.2]], True, "5/4"),
        ([[0.6, 0.6]], True, "3/2"),
        ([[0.5, 0.5], [0.7, 0.5]], True, "2"),
    ],
)
def test_an_audit_that_follows_a_plan_decides_as_often_as_it_says(rows: list[list[float]], independent: bool, limit: str) -> None:
    found = plan([[str(p) for p in row] for row in rows], max_ratio=limit, independent=independent)
    assert found.draws is not None and found.decides is not None and found.power is not None and 0.8 <= found.power < 0.9
    assert decided(rows, found.draws, found.decides, independent=independent, limit=limit) == pytest.approx(found.power, abs=0.2)


def test_half_of_the_draws_may_choose() -> None:
    rows = [[0.6, 0.2], [0.5, 0.5], [0.5, 0.5]]
    guesses = [[str(p) for p in row] for row in rows]
    found = plan(guesses, max_ratio="5/4", independent=True, select="half-split")
    assert found.draws is not None and found.decides == "exceeds" and found.power is not None and found.cells == (0, 1)
    assert found.method is not None and "half of the draws" in found.method
    often = decided(rows, found.draws, "exceeds", independent=True, limit="5/4", select="half-split")
    assert often == pytest.approx(found.power, abs=0.2)
    within = [plan(["0.5", "0.5"], max_ratio=2, independent=True, select=each).draws for each in ("bonferroni", "half-split")]
    assert within[0] == within[1]
    with pytest.raises(InputError, match="half-split"):
        plan(guesses, max_ratio="5/4", select="half-split")


def test_many_values_in_independent_cells() -> None:
    """The method that certify takes for them, and audits that follow decide as often as is said."""
    assert plan(["0.5", "0.5"], max_ratio=2, independent=True, binary=False).method == "bets on the contrast of draws"
    pick = np.random.default_rng(3)

    def drawn(n: int) -> Comparison:
        rows = pick.multinomial(n, [0.2, 0.6, 0.2], 2)
        law = Law.from_array(rows, kind="counts", decisions=["no", "half", "yes"])
        return local_comparison(law, Utility({"yes": 1, "half": "0.5"}).on(law))

    law = Law.from_array([[10, 30, 10], [10, 30, 10]], kind="counts", decisions=["no", "half", "yes"])
    compared = local_comparison(law, Utility({"yes": 1, "half": "0.5"}).on(law))
    interval = ratio_interval(compared, region="contrasts", independent=True, ends="each")
    found = further_draws(compared, max_ratio="4/3", interval=interval)
    assert found.method == "bets on the contrast of draws" and found.draws is not None and found.decides == "within"
    n = 50 + found.draws[0]
    ends = [ratio_interval(drawn(n), region="contrasts", independent=True, ends="each") for _ in range(40)]
    assert sum(verdict(each, max_ratio="4/3") == "within" for each in ends) / 40 == pytest.approx(0.8, abs=0.2)


def test_the_figures_of_another_simulation() -> None:
    """Sizes at which a simulation of the whole exact method found a power a little above 0.8: within a tenth."""
    half, three = "0.5", "0.3"
    for guesses, draws in (
        ([[half, half]], 385),
        ([[half, half]] * 6, 605),
        ([[half] * 8], 740),
        ([[half, three]], 322),
        ([[half, three], *[[half, half]] * 5], 465),
        ([[half] * 7 + [three]], 357),
    ):
        found = plan(guesses, max_ratio="5/4", independent=True)
        assert found.draws is not None and 0.9 * draws < found.draws[0] < 1.04 * draws
        assert found.method == "the exact pair bound"


@given(
    st.lists(st.integers(1, 9), min_size=2, max_size=4),
    st.sampled_from(["3/2", "2", "3"]),
    st.booleans(),
    st.floats(0.5, 0.95),
    st.floats(0.5, 0.95),
)
def test_more_power_takes_no_fewer_draws(tenths: list[int], limit: str, independent: bool, power: float, other: float) -> None:
    low, high = (plan([F(p, 10) for p in tenths], max_ratio=limit, independent=independent, power=each) for each in sorted((power, other)))
    assert low.decides == high.decides
    if high.draws is not None:
        assert low.draws is not None and low.draws[0] <= high.draws[0]
        assert low.power is not None and high.power is not None and low.power >= min(power, other) and high.power >= max(power, other)
    ratio = F(max(tenths), min(tenths))
    assert low.decides == (None if ratio == F(limit) else "exceeds" if ratio > F(limit) else "within")


def test_the_limit_itself_is_not_decided() -> None:
    found = plan(["0.5", "0.4"], max_ratio="5/4", independent=True)
    assert found.draws is None and "the limit itself" in found.sentence and "90 %" in found.sentence
    assert plan(["0.5", "0.5"], max_log=0).draws is None
    measured = further_draws(one_block(binary(400, 200), binary(400, 160)), max_ratio="5/4")
    assert measured.draws is None and measured.decides is None and "that is the limit itself" in measured.sentence


def test_which_cells_need_the_draws() -> None:
    found = plan([["0.5", "0.45"], ["0.8", "0.8"], ["0.5", "0.45"]], max_ratio="3/2", independent=True)
    assert found.cells == (0, 1, 4, 5) and found.pair is not None and found.pair.expectations == (F(1, 2), F(9, 20))
    assert found.draws is not None and found.fewest is not None
    assert found.fewest[2] == found.fewest[3] < found.draws[2] / 2 and found.fewest[0] == found.draws[0]
    shown = plan([["0.5", "0.2", "0.5"], ["0.5", "0.5", "0.5"]], max_ratio="5/4", independent=True)
    assert shown.decides == "exceeds" and shown.cells == (0, 1, 2) and shown.fewest is None


def test_unequal_cells() -> None:
    found = plan(["0.5", "0.5"], max_ratio="3/2", shares=["0.5", "2"])
    equal = plan(["0.5", "0.5"], max_ratio="3/2")
    assert found.draws is not None and equal.draws is not None and found.draws[1] == 4 * found.draws[0]
    assert found.draws[0] < equal.draws[0] < found.draws[1] and found.total == sum(found.draws) > sum(equal.draws)
    assert (
        plan([["0.5", "0.5"]] * 2, max_ratio=2, shares=[1, 2]).draws == plan([["0.5", "0.5"]] * 2, max_ratio=2, shares=[[1, 2]] * 2).draws
    )
    for shares in ([1], [1, 0], [[1, 2], [1]]):
        with pytest.raises(InputError, match="shares"):
            plan(["0.5", "0.5"], max_ratio=2, shares=shares)


def test_units_vary_as_much_as_they_can() -> None:
    rows, units = (plan(["0.5", "0.5"], max_ratio=2, units=each) for each in (False, True))
    assert rows.draws is not None and units.draws is not None and units.draws[0] > rows.draws[0]
    assert "units per cell" in units.sentence and "vary as much as they can" in units.sentence


def test_planning_agrees_with_what_happens() -> None:
    small = one_block(binary(40, 20), binary(40, 20))
    assert verdict(ratio_interval(small, ends="each"), max_log="0.2") == "inconclusive"
    more = further_draws(small, max_log="0.2")
    assert more.decides == "within" and "estimate" in more.sentence and more.draws is not None
    n = 40 + more.draws[0]
    assert decided([[0.5, 0.5]], (n, n), "within", independent=False, limit="1.2214") == pytest.approx(0.8, abs=0.2)
    again = further_draws(one_block(binary(60, 45), binary(60, 15)), max_log="0.2")
    assert again.draws == (0, 0) and "as many draws, taken anew" in again.sentence
    chance = further_draws(one_block(binary(40, 21), binary(40, 14)), max_log="0.2")
    assert chance.decides is None and chance.draws[0] > 0 and chance.total > 0 and chance.total_if_equal > 0
    assert "if the truth were as measured (a ratio of 1.5)" in chance.sentence and "may be chance alone" in chance.sentence
    exceeding = further_draws(one_block(binary(400, 210), binary(400, 150)), max_log="0.2")
    assert exceeding.decides == "exceeds" and exceeding.draws[0] > 0 and exceeding.total_if_equal is None
    assert further_draws(one_block(binary(40, 30), binary(40, 20)), max_ratio="3/2").draws is None
    assert further_draws(one_block(binary(40, 20), Cell(0, F(0), None, F(0), F(1), True)), max_log="0.2").draws is None
    assert further_draws(one_block(binary(40, 20), binary(40, 0)), max_ratio=3).decides == "exceeds"
    assert further_draws(one_block(binary(40, 0), binary(40, 0)), max_ratio=3).draws is None


def table(*rows: tuple[tuple[int, int], tuple[int, int]]) -> Comparison:
    law = Law.from_array(np.array([[[k, n - k] for k, n in row] for row in rows]), kind="counts", decisions=["yes", "no"])
    return local_comparison(law, Utility({"yes": 1}).on(law))


def test_the_pair_that_needs_the_draws_is_named() -> None:
    compared = table(((25, 50), (20, 50)), ((400, 800), (400, 800)))
    plain = further_draws(compared, max_ratio="3/2")
    interval = ratio_interval(compared, region="pairs", independent=True, ends="each")
    found = further_draws(compared, max_ratio="3/2", interval=interval)
    for each in (plain, found):
        assert each.pair is not None and each.pair.expectations == (F(1, 2), F(2, 5)) and each.decides == "within"
        assert each.draws is not None and each.draws[2:] == (0, 0) and each.pair_draws is not None
        assert each.pair_draws[0] == each.pair_draws[1] <= each.draws[0] and each.total == sum(each.draws)
        assert f"about {each.pair_draws[0]} and {each.pair_draws[1]}." in each.sentence
    assert found.method == "the exact pair bound" and sum(found.pair_draws) < 0.6 * sum(plain.pair_draws)


def test_to_show_that_a_limit_is_exceeded_takes_one_pair() -> None:
    compared = table(((30, 50), (12, 50)), ((40, 80), (40, 80)))
    interval = ratio_interval(compared, region="pairs", independent=True, ends="each")
    found = further_draws(compared, max_ratio="2", interval=interval)
    assert found.decides == "exceeds" and found.draws is not None and found.pair_draws is not None
    assert found.draws == (*found.pair_draws, 0, 0) and found.total == sum(found.pair_draws) > 0


def test_draws_that_vary_less_need_be_fewer() -> None:
    near = one_block(*[bounded([F(2, 5), F(1, 2), F(3, 5)] * 10)] * 2)
    far = one_block(*[bounded([F(0), F(1, 2), F(1)] * 10)] * 2)
    first, second = (further_draws(each, max_ratio="3/2") for each in (near, far))
    assert first.total is not None and second.total is not None and first.total < second.total


def test_plan() -> None:
    half = plan(["0.5", "0.5"], max_log="0.2", power=0.5).draws[0]
    assert half < plan(["0.5", "0.5"], max_log="0.2").draws[0] < plan(["0.5", "0.5", "0.5"], max_log="0.2", power=0.9).draws[0]
    assert plan(["0.5", "0.4"], max_log="0.1").decides == "exceeds"
    assert plan(["2", "2"], max_log="0.2", limits=(1, 4), binary=False).draws is not None
    assert plan(["0.5", "0"], max_ratio=2).decides == "exceeds" and plan(["0", "0"], max_ratio=2).draws is None
    guessed = policy_comparison(sampled_policy(), Utility({"yes": 1}), RandomizedResponse(["f", "m", "o"], keep_probability="0.4"))
    assert plan(guessed, max_log="0.3").decides == "within"
    for bad in (["0.5"], ["0.5", "2"]):
        with pytest.raises(InputError):
            plan(bad, max_log="0.2")
    with pytest.raises(InputError, match="power"):
        plan(["0.5", "0.5"], max_log="0.2", power=1)


def test_planning_for_many_cells() -> None:
    """Contexts that are alike are simulated once; of different ones those that decide."""
    pick = np.random.default_rng(1)
    law = Law.from_array(pick.integers(30, 90, (300, 3, 2)), kind="counts")
    found = further_draws(local_comparison(law, Utility({"0": 1, "1": "0.25"}).on(law)), max_ratio="2.5")
    assert found.decides == "within" and found.pair is not None and found.pair.expectations[1] < F(1, 2)
    thousands = Law.from_array(np.concatenate([np.array([[[700, 500], [500, 700]]]), np.full((1200, 2, 2), 600)]), kind="counts")
    one = further_draws(local_comparison(thousands, Utility({"0": 1}).on(thousands)), max_ratio="3/2")
    assert one.decides == "within" and one.draws is not None and one.draws[0] > 0 and not any(one.draws[2:])
    many = plan([[Fraction(1, 2)] * 2] * 2_000, max_ratio="5/4")
    few = plan([[Fraction(1, 2)] * 2] * 20, max_ratio="5/4")
    assert many.draws is not None and few.draws is not None and few.draws[0] < many.draws[0] < 2 * few.draws[0]


def test_groups_that_are_certain_need_draws_by_their_sizes() -> None:
    certain = {"u": ["yes", "yes"], "g": ["a", "b"], "n": [5, 9]}
    result = fa.audit(certain, decision="u", group="g", count="n", utility="yes", max_local_ratio=2)
    ((_, planned),) = result.further_draws
    few = next(n for n in range(1, 99) if 2 * 0.025 ** (1 / n) > 1)  # each cell's lower end is at half the error
    assert result.verdict == "inconclusive" and planned.draws == (few - 5, 1) and planned.power == 1
    more = certain | {"n": [5 + planned.draws[0], 9 + planned.draws[1]]}
    assert fa.audit(more, decision="u", group="g", count="n", utility="yes", max_local_ratio=2).verdict == "within"
    for shares in ((5, 9), (9, 5)):
        fewest = fa.plan([1, 1], max_ratio=2, shares=shares).draws
        assert min(fewest) == few, fewest
