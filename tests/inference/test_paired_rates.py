"""How rates changed in the units of two logs, and what that says of their ratios."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from typing import Any

import numpy as np
import pytest
import tiers
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from fairaudit.inference.paired_rates import greatest_change, paired_rates, units_alike

F = Fraction
ONE, NONE = F(1), F(0)
ALPHA = F(1, 10)


def profiles(old: Any, new: Any) -> dict[Any, int]:
    """How many units got what in the first and in the second log."""
    found: dict[Any, int] = {}
    for pair in zip(old, new, strict=True):
        key = tuple(F(int(value)) for value in pair)
        found[key] = found.get(key, 0) + 1
    return found


def won(pairs: dict[Any, int], limit: Fraction, *, up: bool, difference: bool = False) -> Fraction:
    """What bets against "the new mean is at least limit times the old one" (down: exchanged) won, by the formulas of the page, exactly."""
    units = sum(pairs.values())
    bets = [F(15, 16)]
    while bets[-1] ** 2 * 2 * units > 24:
        bets.append((F(15, 16), F(2, 3))[len(bets) % 2] / 2 ** (len(bets) // 2))
    total = F(0)
    for bet in bets:
        product = F(1)
        for (old, new), n in pairs.items():
            x, y = (new, old) if up else (old, new)
            gain = (limit - x + y) / 2 if difference else limit * y - x
            product *= (1 + bet * gain) ** n
        total += product
    return total / len(bets)


counts = st.lists(st.integers(0, 40), min_size=4, max_size=4).filter(lambda ns: sum(ns) > 10)


def of_counts(ns: list[int]) -> dict[Any, int]:
    return {pair: n for pair, n in zip(((NONE, NONE), (NONE, ONE), (ONE, NONE), (ONE, ONE)), ns, strict=True) if n}


@given(ns=counts)
@settings(max_examples=25)
def test_ends_are_proved_by_the_bets_of_the_page(ns: list[int]) -> None:
    pairs = of_counts(ns)
    (rate,) = paired_rates({(("x",), ("f",)): pairs}, ONE, ALPHA)
    level = 1 / (ALPHA / 2)
    assert rate.units == sum(ns) and rate.old == F(ns[2] + ns[3], sum(ns)) and rate.new == F(ns[1] + ns[3], sum(ns))
    if rate.ratio[1] != inf:
        assert won(pairs, F(rate.ratio[1]), up=True) >= level
    if rate.ratio[0] > 0:
        assert won(pairs, 1 / F(rate.ratio[0]), up=False) >= level
    for end, up in ((rate.difference[1], True), (-rate.difference[0], False)):
        assert end == 1 or won(pairs, end, up=up, difference=True) >= level
    assert rate.difference[0] <= rate.new - rate.old <= rate.difference[1]


@given(first=counts, second=counts)
@settings(max_examples=15)
def test_the_change_is_the_greatest_of_two_groups_of_a_context(first: list[int], second: list[int]) -> None:
    cells = {(("x",), ("f",)): of_counts(first), (("x",), ("m",)): of_counts(second), (("y",), ("f",)): of_counts([0, 40, 0, 1])}
    one, other, _ = paired_rates(cells, ONE, 6 * ALPHA / 2)  # three cells: each end at ALPHA/2, as those of the change
    products = [
        inf if high == inf or low == 0 else F(high) / F(low)
        for high, low in ((one.ratio[1], other.ratio[0]), (other.ratio[1], one.ratio[0]))
    ]
    assert greatest_change(cells, ONE, ALPHA) == max(1, *products)
    exchanged = {place: {pair[::-1]: n for pair, n in pairs.items()} for place, pairs in cells.items()}
    assert greatest_change(exchanged, ONE, ALPHA) == greatest_change(cells, ONE, ALPHA)


def test_units_that_are_not_in_both() -> None:
    both = {(ONE, ONE): 3}
    assert units_alike({(("x",), ("f",)): both}) and not units_alike({(("x",), ("f",)): {**both, (None, ONE): 1}})
    (rate,) = paired_rates({(("x",), ("f",)): {**both, (None, ONE): 5, (ONE, None): 2}}, ONE, ALPHA)
    assert rate.units == 3 and rate.new == 1
    (empty,) = paired_rates({(("x",), ("f",)): {(None, ONE): 5}}, ONE, ALPHA)
    assert empty.ratio == (0, inf) and empty.difference == (-1, 1)


def test_one_group_has_nothing_to_compare() -> None:
    assert greatest_change({(("x",), ("f",)): {(ONE, NONE): 9}, (("y",), ("f",)): {(NONE, ONE): 9}}, ONE, ALPHA) == 1


@pytest.mark.parametrize("same", [0.0, 0.9, 1.0])
def test_the_quotient_of_ratios_is_covered_however_logs_hang_together(same: float) -> None:
    """Three groups of two contexts; the second log repeats an answer of the first with the chance `same`."""
    generator = np.random.default_rng(7)
    means = {"f": (0.5, 0.6), "m": (0.5, 0.5), "x": (0.5, 0.5)}
    times, misses = 2000 if tiers.FULL else 40, 0
    for _ in range(times):
        cells = {}
        for context in "ab":
            for group, (old, new) in means.items():
                uniform = generator.random(80)
                again = np.where(generator.random(80) < same, uniform, generator.random(80))
                cells[(context,), (group,)] = profiles(uniform < old, again < new)
        found = greatest_change(cells, ONE, ALPHA)
        misses += found < F(6, 5)  # R = 1 and R' = 6/5
        rates = paired_rates(cells, ONE, ALPHA)
        true = {group: F(str(new)) / F(str(old)) for group, (old, new) in means.items()}
        misses += any(not rate.ratio[0] <= true[rate.group[0]] <= rate.ratio[1] for rate in rates)
    print(f"{misses} of {times} miss, at most {float(ALPHA)} wanted")
    assert stats.binom.sf(misses - 1, times, float(ALPHA)) >= 1e-6
