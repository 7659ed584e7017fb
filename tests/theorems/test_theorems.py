"""Numbers out of range are refused in one sentence, and bounds are what their fields say."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from typing import Any

import pytest

from fairaudit.errors import InputError
from fairaudit.model.mechanism import RandomizedResponse
from fairaudit.theorems.bound import ANY_POLICY, FLOORED, THIS_LAW, THIS_POLICY, Bound
from fairaudit.theorems.t01 import floor_cap, t1, t1_paper, t1_tight
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t03 import t3_approx, t3_curve, t3_general, t3_mechanism, t3_randomized_response
from fairaudit.theorems.t03_currencies import t3_gdp, t3_renyi, t3_zcdp
from fairaudit.theorems.t04 import t4
from fairaudit.theorems.t05 import t5_independent
from fairaudit.theorems.t07 import t7, t7_pair
from fairaudit.theorems.t10 import t10, t10_floor
from fairaudit.theorems.t12 import t12

COIN = RandomizedResponse(["a", "b"], keep_probability="0.6")


@pytest.mark.parametrize(
    "call",
    [
        lambda: floor_cap(0, 0),
        lambda: floor_cap(1, 2),
        lambda: floor_cap(1, "x"),
        lambda: t1(COIN, 0, 0),
        lambda: t1(COIN, -1, 0),
        lambda: t1(COIN, 1, -1),
        lambda: t1(COIN, 1, 2),
        lambda: t1(COIN, 1, "0.5", -1),
        lambda: t1(COIN, 1, "0.5", lambda a, b: -1),
        lambda: t1(COIN, 1, "0.5", floor="none"),
        lambda: t1_paper(2, "1.5", 1, "0.5"),
        lambda: t1_paper(2, -1, 1, "0.5"),
        lambda: t1_tight("0.5", 0, 1, "0.5"),
        lambda: t1_tight(nan, 0, 1, "0.5"),
        lambda: t1_tight(2, 0, inf, "0.5"),
        lambda: t2("0.9"),
        lambda: t2(-inf),
        lambda: t3_approx(2, 0, 0),
        lambda: t3_approx(2, 0, "1.1"),
        lambda: t3_approx(2, 2, "0.5"),
        lambda: t3_mechanism(COIN, 0),
        lambda: t3_mechanism(COIN, -1),
        lambda: t3_general(COIN, 1, 2),
        lambda: t3_randomized_response(4, "0.2", "0.5"),
        lambda: t3_randomized_response(4, "1.2", "0.5"),
        lambda: t3_randomized_response(1, 1, "0.5"),
        lambda: t3_randomized_response(True, 1, "0.5"),
        lambda: t3_gdp(-1, "0.5"),
        lambda: t3_gdp(1, 0),
        lambda: t3_renyi(1, 1, "0.5"),
        lambda: t3_renyi("0.5", 1, "0.5"),
        lambda: t3_renyi(2, -1, "0.5"),
        lambda: t3_zcdp(-1, "0.5"),
        lambda: t3_curve([(0, 1), (1, 0)], "0.5", orders="some"),
        lambda: t4(COIN, 1, 2),
        lambda: t4(COIN, 2, 1, "0.5"),
        lambda: t4(COIN, 2, 1, 3),
        lambda: t4(COIN, 0, 0),
        lambda: t5_independent("0.5"),
        lambda: t7("0.5"),
        lambda: t7(2, quantity="local_ratio"),
        lambda: t7_pair(2, "0.5"),
        lambda: t10("0.5"),
        lambda: t10(2, "0.6"),
        lambda: t10(2, 0),
        lambda: t10_floor(COIN, "0.6"),
        lambda: t12(2, "0.5"),
        lambda: t12("0.5", 2),
    ],
)
def test_bad_numbers_are_refused_in_one_sentence(call: Callable[[], Any]) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_every_bound_states_its_assumptions_and_only_finite_constants() -> None:
    bounds = [
        t1(COIN, 1, "0.3"),
        t1_paper(2, 0, 1, "0.3"),
        t1_tight(inf, 0, 1, "0.3"),
        t2(inf),
        t3_approx(inf, 0, "0.5"),
        t3_mechanism(COIN, "0.5"),
        t3_randomized_response(2, "0.6", "0.5"),
        t3_gdp(1, "0.5"),
        t3_renyi(2, 1, "0.5"),
        t3_zcdp(1, "0.5"),
        t3_general(COIN, 1, "0.3", "0.1"),
        t3_curve([(0, 1), (1, 0)], "0.5", orders="both"),
        t4(COIN, 2, 1),
        t10(2),
        t10_floor(COIN, "0.3"),
        t12(inf, 2),
    ]
    for bound in bounds:
        assert isinstance(bound, Bound)
        assert any("independent of each other and of everything else, fresh for each decision" in text for text in bound.assumptions)
        assert inf not in bound.constants.values()
        assert bound.value >= 1
        assert bound.scope in {THIS_LAW, THIS_POLICY, ANY_POLICY, FLOORED}
        assert list(bound.multipliers) == sorted(set(bound.multipliers), reverse=True)
        assert bound.certified or not bound.multipliers
        assert bound.value != inf or bound.note
