"""How many draws would decide."""

from __future__ import annotations

import numpy as np
import pytest
from interval_oracle import (
    F,
    binary,
    one_block,
    sampled_policy,
)

from fairaudit import Law, RandomizedResponse, Utility
from fairaudit.errors import InputError
from fairaudit.inference import quotients
from fairaudit.inference.cells import Cell
from fairaudit.inference.planning import further_draws, plan
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.inference.verdicts import verdict


def test_planning_agrees_with_what_happens() -> None:
    small = one_block(binary(40, 20), binary(40, 20))
    assert verdict(ratio_interval(small, ends="each"), max_log="0.2") == "inconclusive"
    more = further_draws(small, max_log="0.2")
    assert more.decides == "within" and "estimate" in more.sentence
    n = 40 + more.draws[0]
    n += n % 2
    assert verdict(ratio_interval(one_block(binary(n, n // 2), binary(n, n // 2)), ends="each"), max_log="0.201") == "within"
    assert verdict(ratio_interval(one_block(binary(n // 2, n // 4), binary(n // 2, n // 4)), ends="each"), max_log="0.2") == "inconclusive"
    assert further_draws(one_block(binary(40, 30), binary(40, 10)), max_log="0.2").draws == (0, 0)
    chance = further_draws(one_block(binary(40, 21), binary(40, 14)), max_log="0.2")
    assert chance.decides is None and chance.draws[0] > 0 and chance.total > 0 and chance.total_if_equal > 0
    assert "if the truth were as measured (a ratio of 1.5)" in chance.sentence and "may be chance alone" in chance.sentence
    exceeding = further_draws(one_block(binary(400, 210), binary(400, 150)), max_log="0.2")
    assert exceeding.decides == "exceeds" and exceeding.draws[0] > 0 and exceeding.total_if_equal is None
    assert further_draws(one_block(binary(40, 30), binary(40, 20)), max_ratio="3/2").draws is None
    assert further_draws(one_block(binary(40, 20), Cell(0, F(0), None, F(0), F(1), True)), max_log="0.2").draws is None


def test_plan() -> None:
    half = plan(["0.5", "0.5"], max_log="0.2", power=0.5).draws[0]
    assert half < plan(["0.5", "0.5"], max_log="0.2").draws[0] < plan(["0.5", "0.5", "0.5"], max_log="0.2", power=0.9).draws[0]
    k = (half + 1) // 2
    assert verdict(ratio_interval(one_block(binary(2 * k, k), binary(2 * k, k)), ends="each"), max_log="0.2002") == "within"
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


@pytest.mark.parametrize("factor", [1, 100])
def test_planning_for_many_cells_looks_at_those_that_decide(monkeypatch: pytest.MonkeyPatch, factor: int) -> None:
    """The estimate is that of all cells."""
    pick = np.random.default_rng(factor)
    law = Law.from_array(pick.integers(30 * factor, 90 * factor, (60, 3, 2)), kind="counts")
    comparison = local_comparison(law, Utility({"0": 1, "1": "0.25"}).on(law))
    assert quotients.are_many(comparison.used)
    quick = further_draws(comparison, max_ratio="2.2")
    monkeypatch.setattr(quotients, "DECISIVE_CELLS", 10**9)
    assert not quotients.are_many(comparison.used)
    full = further_draws(comparison, max_ratio="2.2")
    assert quick.decides == full.decides is not None
    assert full.draws is not None
    assert quick.draws == pytest.approx(full.draws, rel=0.01)
