"""The checker on contrasts of independent cells: what the writer proves it accepts, and whatever is altered it rejects.

All 2,400 alterations: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_symmetric_betting.py
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from math import inf, log
from typing import Any

import pytest
import tiers
from contrast_oracle import bets, is_just_below, symmetric, tally
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.checker import symmetric_betting as checker
from fairaudit.checker.text import TooMuch
from fairaudit.checker.work import CURRENT_WORK, MAX_BLOCKS, MAX_STEPS, Work
from fairaudit.inference import symmetric_betting as writer
from fairaudit.inference.betting import ValueCounts

F = Fraction
ALTERED = 2400 if tiers.FULL else 240
LEVEL = F(1, 20)

few = st.lists(st.sampled_from([F(0), F(1, 3), F(1, 2), F(1)]), min_size=1, max_size=4)


@settings(max_examples=60)
@given(few, few, st.fractions(F(0), F(3), max_denominator=40), st.booleans())
def test_wealth_is_the_average_over_all_pairings(xs: list[Fraction], ys: list[Fraction], limit: Fraction, difference: bool) -> None:
    exact = symmetric(xs, ys, limit, "difference" if difference else "ratio")
    assert is_just_below(checker.wealth_of(tally(xs), tally(ys), limit, difference), exact)  # type: ignore[arg-type]


@pytest.mark.parametrize("n", [3, 1_000, 10**6, 10**18])
def test_draws_that_are_all_the_same_are_a_power(n: int) -> None:
    x, y, limit, pairs = F(2, 3), F(1, 2), F(7, 5), min(n, 1_000)
    made = bets(pairs**2 * F(3, 2 * n))
    for difference, gain in ((False, limit * y - x), (True, (limit - x + y) / 2)):
        exact = sum(((1 + bet * gain) ** pairs for bet in made), F(0)) / len(made)
        assert is_just_below(checker.wealth_of({x: n}, {y: 2 * n}, limit, difference), exact, 118 - n.bit_length())


def cell(source: random.Random, n: int) -> dict[Fraction, int]:
    top = source.choice([1, 2, 10, 1000])
    power = source.choice([1, 1, 3])
    return tally(F(round(top * source.random() ** power), top) for _ in range(n))  # type: ignore[return-value]


def logarithm(number: tuple[int, int]) -> float:
    return log(number[0]) + number[1] * log(2)


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.sampled_from([7, 60, 300]), st.sampled_from([7, 60, 300]), st.sampled_from([F(1, 2), F(1), F(30)]))
def test_writer_and_checker_lose_no_more_than_their_last_bits(seed: int, n: int, m: int, limit: Fraction) -> None:
    source = random.Random(tiers.fresh(seed))
    x, y = cell(source, n), cell(source, m)
    for difference, kind in ((False, "ratio"), (True, "difference")):
        ours = checker.wealth_of(x, y, limit, difference)
        assert logarithm(ours) == pytest.approx(logarithm(writer.wealth(ValueCounts(x), ValueCounts(y), limit, kind)), abs=1e-9)  # type: ignore[arg-type]


Claim = tuple[dict[Fraction, int], dict[Fraction, int], Fraction, Fraction, bool]


def accepts(claim: Claim) -> bool:
    return checker.proves_below(*claim)


def claims() -> Iterator[Claim]:
    source = random.Random(tiers.fresh(29))
    while True:
        x, y = cell(source, source.choice([30, 80])), cell(source, source.choice([30, 80]))
        for difference, kind, nothing in ((False, "ratio", inf), (True, "difference", F(1))):
            end: Any = writer.upper_end(ValueCounts(x), ValueCounts(y), LEVEL, kind)  # type: ignore[arg-type]
            if end != nothing:
                yield x, y, end, LEVEL, difference


def moved(values: dict[Fraction, int], value: Fraction, to: Fraction) -> dict[Fraction, int]:
    return {**values, value: values[value] - 1, to: values.get(to, 0) + 1}


def altered(claim: Claim) -> Iterator[Claim]:
    """Claims that say more than was proved, of these cells or of cells that say less."""
    x, y, end, level, difference = claim
    less = (end - F(2, 10**7), end - F(1, 10), F(-2)) if difference else (end * (1 - F(2, 10**6)), end * F(99, 100), F(0), -end)
    for other in less:
        yield x, y, other, level, difference
    for part in (F(999, 1000), F(1, 2), F(1, 10**9)):
        yield x, y, end, level * part, difference
    for value in x:
        if value < 1:
            yield moved(x, value, F(1)), y, end, level, difference
            yield moved(x, value, min(F(1), value + F(1, 10))), y, end, level, difference
        yield moved(x, value, F(3, 2)), y, end, level, difference
    for value in y:
        if value > 0:
            yield x, moved(y, value, F(0)), end, level, difference
            yield x, moved(y, value, max(F(0), value - F(1, 10))), end, level, difference
        yield x, moved(y, value, F(-1)), end, level, difference
    yield {}, y, end, level, difference
    yield x, {}, end, level, difference


def test_what_the_writer_writes_is_accepted_and_what_is_altered_is_not() -> None:
    source, tried, made = random.Random(tiers.fresh(3)), 0, claims()
    while tried < ALTERED:
        claim = next(made)
        assert accepts(claim)
        alterations = [*altered(claim)]
        for other in source.sample(alterations, min(len(alterations), 30)):
            assert not accepts(other), other
            tried += 1


def work_of(x: dict[Fraction, int], y: dict[Fraction, int], limit: Fraction, steps: int = MAX_STEPS) -> Work:
    work = Work(steps)
    token = CURRENT_WORK.set(work)
    try:
        checker.wealth_of(x, y, limit, False)
    finally:
        CURRENT_WORK.reset(token)
    return work


TENTHS = {F(i, 10): 10**17 for i in range(11)}
THOUSANDTHS = {F(i, 1000): 1 for i in range(1000)}


def test_cells_of_many_draws_or_values_take_little_work() -> None:
    for limit in (F(101, 100), F(10**9), F(10**300), F(1, 10**300)):
        assert work_of(TENTHS, TENTHS, limit).steps > MAX_STEPS * 98 // 100
    taken = work_of(THOUSANDTHS, THOUSANDTHS, F(11, 10))
    assert taken.steps > MAX_STEPS * 9 // 10 and taken.blocks > MAX_BLOCKS * 9 // 10


@pytest.mark.parametrize(("x", "y"), [(TENTHS, TENTHS), (THOUSANDTHS, TENTHS), (TENTHS, THOUSANDTHS)])
def test_work_is_counted_before_it_is_done(x: dict[Fraction, int], y: dict[Fraction, int]) -> None:
    for steps in (100, 3_000, 30_000):
        with pytest.raises(TooMuch):
            work_of(x, y, F(11, 10), steps)
    with pytest.raises(TooMuch):
        work_of(x, y, F(10**10_000 + 1, 10**10_000))
