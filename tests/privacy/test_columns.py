"""Columns of likelihood ratios and their powers."""

from __future__ import annotations

from itertools import product
from math import prod
from random import Random

import pytest
import tiers

from fairaudit.privacy.columns import Budget, Column, TooManyColumns, joined_columns, merged_columns, powered_columns


def random_columns(rng: Random) -> tuple[Column, ...]:
    """Any, with zeros; ratios of a progression; those of randomized response."""
    size, kind = rng.randint(1, 4), rng.choice(["any", "progression", "response"])
    if kind == "any":
        tops, bottoms = ([rng.randint(0, 5) for _ in range(size)] for _ in range(2))
    elif kind == "progression":
        up, down = rng.choice([(2, 1), (3, 2), (4, 9), (1, 1)])
        exponents = [rng.randint(0, 6) for _ in range(size)]
        tops, bottoms = [up**e * down ** (6 - e) for e in exponents], [down**6] * size
    else:
        keep, other = rng.randint(1, 9), rng.randint(1, 9)
        tops, bottoms = [keep, other] + [other] * size, [other, keep] + [other] * size
    if not sum(tops) or not sum(bottoms):
        return random_columns(rng)
    return merged_columns((p * sum(bottoms), q * sum(tops)) for p, q in zip(tops, bottoms, strict=True))


def test_a_power_is_the_product_written_out() -> None:
    rng = Random(tiers.fresh("powers"))
    for _ in range(400):
        columns, times = random_columns(rng), rng.randint(1, 4)
        written_out = merged_columns((prod(p for p, _ in some), prod(q for _, q in some)) for some in product(columns, repeat=times))
        assert powered_columns(columns, times) == written_out


def test_a_power_of_powers_and_a_product_of_powers() -> None:
    rng = Random(tiers.fresh("powers of powers"))
    for _ in range(60):
        columns, more = random_columns(rng), random_columns(rng)
        assert powered_columns(powered_columns(columns, 2), 3) == powered_columns(columns, 6)
        assert joined_columns(powered_columns(columns, 2), powered_columns(columns, 3)) == powered_columns(columns, 5)
        both = powered_columns(joined_columns(columns, more), 2)
        assert both == joined_columns(powered_columns(columns, 2), powered_columns(more, 2))


@pytest.mark.parametrize("columns", [((11, 9), (9, 11)), ((7, 1), (2, 2), (1, 7)), ((7, 1), (2, 3), (1, 6))])
def test_a_budget_is_kept(columns: tuple[Column, ...]) -> None:
    budget = Budget(10_000_000)
    powered_columns(columns, 20, budget)
    assert 0 < budget.left < 10_000_000
    with pytest.raises(TooManyColumns, match="fewer releases"):
        powered_columns(columns, 10_000, budget)
