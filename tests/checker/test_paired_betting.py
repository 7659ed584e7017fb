"""The checker on contrasts within units: what the writer proves it accepts, and whatever is altered it rejects.

All 2,400 alterations: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_paired_betting.py
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any

import pytest
import tiers
from contrast_oracle import bets, is_just_below, paired
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.checker import paired_betting as checker
from fairaudit.checker.intervals import Unproven
from fairaudit.checker.text import TooMuch
from fairaudit.checker.work import CURRENT_WORK, Work
from fairaudit.inference import paired_betting as writer

F = Fraction
ALTERED = 2400 if tiers.FULL else 240
LIMITS = (F(0), F(2))
LEVEL = F(1, 20)

values = st.sampled_from([F(0), F(1, 3), F(1, 2), F(1)])
counted = st.dictionaries(st.tuples(values, values), st.integers(1, 9), min_size=1, max_size=5)

Profiles = dict[tuple[Fraction | None, ...], int]


@given(st.integers(0, 10**7))
def test_bets_end_where_their_square_times_the_spread_is_24(spread: int) -> None:
    assert checker.bets_for(F(spread)) == bets(F(spread))


@given(counted, st.fractions(F(0), F(3), max_denominator=40), st.booleans())
def test_wealth_is_the_definition_barely_rounded_down(counts: Any, limit: Fraction, difference: bool) -> None:
    exact = paired(counts, limit, "difference" if difference else "ratio")
    assert is_just_below(checker.wealth_of(counts, limit, difference), exact)


@given(st.integers(0, 2**140), st.integers(-300, 300), st.fractions(F(1, 10**9), F(999, 1000)))
def test_reaching_a_level_is_decided_exactly(mantissa: int, exponent: int, level: Fraction) -> None:
    assert checker.reaches((mantissa, exponent), level) == (F(mantissa) * F(2) ** exponent * level >= 1)


def context(source: random.Random) -> Profiles:
    """Units of which the later groups often get what the first one gets."""
    found: Profiles = {}
    for _ in range(source.choice([20, 60, 150])):
        base = source.choice([F(0), F(1), F(2), F(2)])
        profile = [base if source.random() < 0.7 else source.choice([F(0), F(1, 2), F(2)]) for _ in range(3)]
        profile[2] = profile[2] * source.choice([0, 1])
        key = tuple(None if source.random() < 0.03 else value for value in profile)
        found[key] = found.get(key, 0) + 1
    return found


def cells_of(profiles: Profiles) -> list[dict[Fraction, int]]:
    cells: list[dict[Fraction, int]] = [{} for _ in range(3)]
    for profile, units in profiles.items():
        for cell, value in zip(cells, profile, strict=True):
            if value is not None:
                cell[value] = cell.get(value, 0) + units
    return cells


def accepts(claim: dict[str, Any], cells: Any) -> bool:
    """Whether the checker accepts of these cells what units, ends and levels say."""
    try:
        checker.check_units(claim["profiles"], cells, LIMITS, "units")
    except Unproven:
        return False
    found = {p: checker.contrasts_of(claim["profiles"], p, LIMITS, claim["drop"]) for p in permutations(range(3), 2)}
    difference = claim["difference"]
    below = all(end in (inf, None) or checker.proves_below(found[p], end, claim["level"], difference) for p, end in claim["upper"].items())
    lower = claim["lower"]
    return below and (lower == (0 if difference else 1) or checker.proves_above([*found.values()], lower, claim["level"], difference))


def claims() -> Iterator[tuple[dict[str, Any], Any]]:
    source = random.Random(tiers.fresh(17))
    while True:
        profiles, difference, drop = context(source), source.random() < 0.3, source.random() < 0.3
        kind: Any = "difference" if difference else "ratio"
        pairs = dict(zip(permutations(range(3), 2), writer.ordered_pairs(profiles, LIMITS, drop=drop), strict=True))
        upper = {p: writer.upper_end(pair, LEVEL, kind) for p, pair in pairs.items()}
        lower = writer.lower_end([*pairs.values()], LEVEL, kind)
        nothing = 1 if difference else inf
        kept = {p: None if end == nothing else end for p, end in upper.items()}
        claim = {"profiles": profiles, "upper": kept, "lower": lower, "level": LEVEL, "difference": difference, "drop": drop}
        yield claim, cells_of(profiles)


def altered(claim: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Claims that say more than was proved, and units that are not those of the cells."""
    difference, proved = claim["difference"], {p: end for p, end in claim["upper"].items() if end is not None}
    digit = F(2, 10**7) if difference else F(2, 10**6)
    for p, end in proved.items():
        for less in (end - digit, end - F(1, 10), F(-2)) if difference else (end * (1 - digit), end * F(99, 100), F(0), -end):
            yield {**claim, "upper": {**claim["upper"], p: less}}
        yield {**claim, "upper": {p: end}, "lower": 0 if difference else 1, "level": LEVEL * F(999, 1000)}
    for more in (claim["lower"] + digit, claim["lower"] * F(101, 100) + F(1, 100), F(10**6)):
        yield {**claim, "lower": more}
    for profile, units in claim["profiles"].items():
        others = {key: n for key, n in claim["profiles"].items() if key != profile}
        if profile != (None, None, None):
            yield {**claim, "profiles": {**others, profile: units + 1}}
            yield {**claim, "profiles": {**others, profile: -units}}
            yield {**claim, "profiles": others}
        for g in range(3):
            for value in (F(0), F(1, 2), F(7, 5), F(2), F(3), None):
                if value != profile[g]:
                    other = (*profile[:g], value, *profile[g + 1 :])
                    yield {**claim, "profiles": {**others, other: others.get(other, 0) + units}}
        yield {**claim, "profiles": {**others, profile[:2]: units}}


def test_what_the_writer_writes_is_accepted_and_what_is_altered_is_not() -> None:
    source, tried, made = random.Random(tiers.fresh(3)), 0, claims()
    while tried < ALTERED:
        claim, cells = next(made)
        assert accepts(claim, cells)
        alterations = [*altered(claim)]
        for other in source.sample(alterations, min(len(alterations), 40)):
            assert not accepts(other, cells), other
            tried += 1


def test_values_beyond_the_limits_and_equal_limits_prove_nothing() -> None:
    inside: Profiles = {(F(2), F(2)): 400}
    for limits, drop in ((LIMITS, False), (LIMITS, True)):
        assert checker.proves_below(checker.contrasts_of(inside, (0, 1), limits, drop), F(11, 10), LEVEL)
    with pytest.raises(Unproven, match="outside the limits"):
        checker.check_units(inside, [{F(2): 400}, {F(2): 400}], (F(0), F(1)), "units")
    assert not checker.proves_below(checker.contrasts_of(inside, (0, 1), (F(0), F(1)), drop=False), F(11, 10), LEVEL)
    nothing: Profiles = {(F(0), F(0)): 400}
    assert not checker.proves_below(checker.contrasts_of(nothing, (0, 1), (F(0), F(0)), drop=False), F(10**9), LEVEL)
    alike = checker.contrasts_of(inside, (0, 1), LIMITS, drop=False)
    assert not checker.proves_above([], F(1), LEVEL)
    assert not any(checker.proves_above([alike, alike], limit, LEVEL) for limit in (F(1, 2), F(0), F(-1)))
    assert not any(checker.proves_above([alike, alike], limit, LEVEL, difference=True) for limit in (F(-1, 2), F(100)))


def test_units_that_cancel_each_other_are_no_units() -> None:
    """One that got all in both groups and one that got nothing, written as two unlike ones less."""
    cells = [{F(0): 3, F(2): 3}, {F(0): 3, F(2): 3}]
    honest: Profiles = {(F(0), F(0)): 1, (F(2), F(2)): 1, (F(0), F(2)): 2, (F(2), F(0)): 2}
    forged: Profiles = {(F(0), F(0)): 4, (F(2), F(2)): 4, (F(0), F(2)): -1, (F(2), F(0)): -1}
    checker.check_units(honest, cells, LIMITS, "units")
    with pytest.raises(Unproven):
        checker.check_units(forged, cells, LIMITS, "units")


def test_missing_units_are_the_worst_or_dropped() -> None:
    lost: Profiles = {(F(2), F(2)): 200, (None, F(2)): 10, (F(0), None): 10, (None, None): 10}
    one, zero = F(1), F(0)
    assert checker.contrasts_of(lost, (0, 1), LIMITS, drop=False) == {(one, one): 210, (zero, zero): 10, (one, zero): 10}
    assert checker.contrasts_of(lost, (0, 1), LIMITS, drop=True) == {(one, one): 200}


def test_work_is_counted_before_it_is_done() -> None:
    token = CURRENT_WORK.set(Work(10_000, 1_000))
    try:
        with pytest.raises(TooMuch):
            checker.wealth_of({(F(i, 1000), F(1, 2)): 10**9 for i in range(1000)}, F(2), False)
    finally:
        CURRENT_WORK.reset(token)
