"""T13: the greatest ratio over all policies."""

from __future__ import annotations

from math import inf
from random import Random

import pytest
from theorem_oracle import F
from worst_policy_oracle import Setting, by_enumeration, by_linear_program, random_setting

from fairaudit.theorems.supremum import Supremum
from fairaudit.theorems.t13 import greatest_ratio

TWO_THIRDS = [[F(2, 3), F(1, 3)], [F(1, 3), F(2, 3)]]


def found(setting: Setting, quantity: str) -> Supremum:
    """T13 of a setting that is compared."""
    result = greatest_ratio(*setting.subject(), quantity)
    assert result is not None
    return result


def place(setting: Setting, result: Supremum) -> tuple[int | None, int, int] | None:
    """Where a supremum says that it is attained, by position."""
    deployment, _ = setting.subject()
    if result.higher is None or result.lower is None:
        assert (result.context, result.higher, result.lower, result.value) == (None, None, None, 1)
        return None
    context = None if result.context is None else deployment.contexts.index(result.context)
    return context, deployment.groups.index(result.higher), deployment.groups.index(result.lower)


def test_the_examples_of_the_theory_page() -> None:
    assert found(Setting([TWO_THIRDS], [[[F(1), F(3)]] * 2]), "local").value == F(7, 5)
    shares = [[F(3, 4), F(1, 4)], [F(1, 4), F(3, 4)]]
    crossed = Setting([TWO_THIRDS], [[[F(1), F(2)]] * 2, [[F(3), F(1)]] * 2], None, shares)
    local, overall = found(crossed, "local"), found(crossed, "global")
    assert (local.value, place(crossed, local)) == (F(7, 5), (1, 0, 1))
    assert (overall.value, place(crossed, overall)) == (F(12, 7), (None, 1, 0))
    assert found(Setting([TWO_THIRDS], [[[F(1), F(2)]] * 2]), "local").value == F(5, 4)
    by_group = Setting([TWO_THIRDS], [[[F(1), F(1)], [F(0), F(2)]]])
    result = found(by_group, "local")
    assert (result.value, place(by_group, result)) == (inf, (0, 0, 1))
    assert by_enumeration(next(sums for _, a, _, sums in by_group.sums("local") if a == 1)) == 2


@pytest.mark.parametrize("quantity", ["local", "global"])
@pytest.mark.parametrize("uses", ["decision", "context", "group"])
def test_value_and_place_are_those_of_the_linear_program(uses: str, quantity: str) -> None:
    for seed in range(60):
        setting = random_setting(Random(f"{uses} {quantity} {seed}"), uses=uses, most_groups=4)
        ratios = [(by_linear_program(sums), (x, a, b)) for x, a, b, sums in setting.sums(quantity)]
        result = greatest_ratio(*setting.subject(), quantity)
        if not ratios:
            assert result is None
            continue
        assert result is not None
        value = max(v for v, _ in ratios)
        assert result.value == value
        assert place(setting, result) == (None if value == 1 else next(where for v, where in ratios if v == value))


def test_a_linear_program_and_an_enumeration_of_policies_agree() -> None:
    for seed in range(40):
        setting = random_setting(Random(f"both {seed}"), uses="group", most_groups=3)
        for _, _, _, sums in setting.sums("local"):
            if len(sums[0][0]) ** len(sums[0]) <= 700:
                assert by_enumeration(sums) == by_linear_program(sums)
