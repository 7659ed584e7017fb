"""Contrasts within units against their definition: every outcome of small laws, in fractions."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from math import inf, log
from typing import Any

import pytest
from contrast_oracle import bets as expected_bets
from contrast_oracle import is_just_below, outcomes, paired, tally, value
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.inference.paired_betting import (
    Contrasts,
    bets,
    contrasts,
    is_above,
    is_below,
    log_wealth,
    lower_end,
    ordered_pairs,
    upper_end,
    wealth,
)

F = Fraction
UNIT = (F(0), F(1))
HALF = F(1, 2)
CLAIMS = ["ratio", "difference"]

values = st.sampled_from([F(0), F(1, 3), HALF, F(1)])
counted = st.dictionaries(st.tuples(values, values), st.integers(1, 9), min_size=1, max_size=5)
limits = st.fractions(F(0), F(3), max_denominator=40)

# Laws of (x, y) with the greatest limit that is true of their means.
LAWS: list[tuple[dict[Any, Fraction], Fraction, Fraction]] = [
    ({(F(1), F(1)): F(1, 4), (F(0), F(1)): F(1, 4), (HALF, F(0)): F(1, 2)}, F(1), F(0)),
    ({(F(1), F(0)): F(1, 3), (F(1), HALF): F(1, 3), (F(0), F(1)): F(1, 3)}, F(4, 3), F(1, 6)),
    ({(F(0), F(1)): F(9, 10), (F(1), F(1)): F(1, 10)}, F(1, 10), F(-9, 10)),
    ({(F(1), F(1)): F(1, 20), (F(0), F(0)): F(19, 20)}, F(1), F(0)),
]


@given(st.integers(0, 10**7))
def test_bets_end_where_their_square_times_the_spread_is_24(spread: int) -> None:
    assert bets(F(spread)) == expected_bets(F(spread))


@given(counted, limits, st.sampled_from(CLAIMS))
def test_wealth_is_the_definition_barely_rounded_down(counts: dict[Any, int], limit: Fraction, claim: Any) -> None:
    pair, exact = Contrasts(counts), paired(counts, limit, claim)
    assert is_just_below(wealth(pair, limit, claim), exact)
    assert log_wealth(pair, float(limit), claim) == pytest.approx(log(exact), abs=1e-9)


@pytest.mark.parametrize("claim", CLAIMS)
@pytest.mark.parametrize("law", range(len(LAWS)))
@pytest.mark.parametrize("units", [1, 2, 4])
def test_the_expected_wealth_on_the_boundary_is_one(claim: Any, law: int, units: int) -> None:
    """Exactly 1 by definition, at most 1 as it is computed; and a level is reached with at most its probability."""
    chances, ratio, difference = LAWS[law]
    limit = ratio if claim == "ratio" else difference
    by_definition, computed = F(0), F(0)
    wrong = dict.fromkeys((F(9, 10), HALF, F(1, 3), F(1, 20)), F(0))
    for drawn, chance in outcomes(chances, units):
        counts: Any = tally(drawn)
        by_definition += chance * paired(counts, limit, claim)
        computed += chance * value(wealth(Contrasts(counts), limit, claim))
        for level in wrong:
            wrong[level] += chance * is_below(Contrasts(counts), limit, level, claim)
    assert by_definition == 1
    assert 1 - F(1, 2**100) <= computed <= 1
    assert all(error <= level for level, error in wrong.items())


@pytest.mark.parametrize("claim", CLAIMS)
@pytest.mark.parametrize("drop", [False, True])
def test_missing_units_win_nothing(claim: Any, drop: bool) -> None:
    """A unit is missing by its very values, which is worst; or by chance, if it is dropped: the expected wealth is 1 all the same."""
    chances, ratio, difference = LAWS[1]
    limit, units = (ratio if claim == "ratio" else difference), 3
    seen: dict[Any, Fraction] = {}
    for (x, y), chance in chances.items():
        for lost in (False, True):
            if drop:
                left, share = ((x, None) if lost else (x, y)), F(1, 4) if lost else F(3, 4)
            else:  # only what speaks against the claim is lost
                left, share = ((None if x == 1 else x, y if y else None) if lost else (x, y)), HALF
            seen[left] = seen.get(left, F(0)) + chance * share
    expected = {False: F(0), True: F(0)}
    for drawn, chance in outcomes(seen, units):
        profiles: Any = tally(drawn)
        for dropped in expected:
            expected[dropped] += chance * value(wealth(contrasts(profiles, 0, 1, UNIT, drop=dropped), limit, claim))
    assert 1 - F(1, 2**100) < expected[drop] <= 1
    assert drop or expected[True] > 1  # which is why nobody drops what is not missing by design


@pytest.mark.parametrize("claim", CLAIMS)
def test_the_average_over_all_pairs_errs_with_at_most_the_level(claim: Any) -> None:
    """Three groups that share their units, of which one ratio, or difference, is at the limit."""
    chances: dict[Any, Fraction] = {
        (F(1), F(0), F(1)): F(1, 4),
        (F(1), F(1), F(0)): F(1, 4),
        (F(1), F(0), F(0)): F(1, 4),
        (F(0), F(1), F(1)): F(1, 4),
    }
    limit = F(3, 2) if claim == "ratio" else F(1, 4)
    wrong = dict.fromkeys((F(9, 10), HALF, F(1, 5)), F(0))
    for drawn, chance in outcomes(chances, 4):
        profiles: Any = tally(drawn)
        pairs = ordered_pairs(profiles, UNIT)
        for level in wrong:
            wrong[level] += chance * is_above(pairs, limit, level, claim)
    assert all(error <= level for level, error in wrong.items())
    assert wrong[F(9, 10)] > 0  # it does speak


@settings(max_examples=30)
@given(counted, st.sampled_from(CLAIMS), st.sampled_from([HALF, F(1, 20), F(1, 1000)]))
def test_an_upper_end_is_the_least_limit_that_is_proved(counts: dict[Any, int], claim: Any, level: Fraction) -> None:
    end = upper_end(Contrasts(counts), level, claim)
    nothing = inf if claim == "ratio" else 1
    if end == nothing:
        assert paired(counts, F(10**8) if claim == "ratio" else 1 - F(1, 10**6), claim) < 1 / level
        return
    assert isinstance(end, Fraction)
    assert paired(counts, end, claim) * level >= 1
    less = end * (1 - F(2, 10**6)) if claim == "ratio" else end - F(2, 10**7)
    assert paired(counts, less, claim) * level < 1


profiled = st.dictionaries(st.tuples(*[st.sampled_from([F(0), HALF, F(1), None])] * 3), st.integers(1, 20), min_size=1, max_size=6)


@settings(max_examples=30)
@given(profiled, st.sampled_from(CLAIMS), st.booleans())
def test_a_lower_end_is_the_greatest_limit_that_is_proved(profiles: dict[Any, int], claim: Any, drop: bool) -> None:
    pairs, level = ordered_pairs(profiles, UNIT, drop=drop), HALF
    end = lower_end(pairs, level, claim)

    def won(limit: Fraction) -> Fraction:
        opposite = 1 / limit if claim == "ratio" else -limit
        return sum((paired(pair.counts, opposite, claim) for pair in pairs), F(0)) / len(pairs)

    nothing = 1 if claim == "ratio" else 0
    more = end * (1 + F(2, 10**6)) if claim == "ratio" else end + F(2, 10**7)
    assert end >= nothing
    assert end == nothing or won(end) * level >= 1
    assert (claim == "difference" and more > 1) or won(more) * level < 1
    assert end == nothing or end <= max(upper_end(pair, level, claim) for pair in pairs)


def test_ends_are_nested_and_order_changes_no_digit() -> None:
    source = random.Random(5)
    rows = [tuple(source.choice([F(0), F(1, 7), F(3, 10), F(1), None]) for _ in range(3)) for _ in range(80)]
    found = set()
    for _ in range(4):
        source.shuffle(rows)
        profiles: Any = tally(rows)
        pairs = ordered_pairs(profiles, UNIT)
        source.shuffle(pairs)
        ends = [
            sorted(upper_end(pair, level, claim) for pair in pairs) for level in (F(1, 20), F(1, 40)) for claim in ("ratio", "difference")
        ]
        assert all(a <= b for one, other in zip(ends[:2], ends[2:], strict=True) for a, b in zip(one, other, strict=True))
        found.add((*map(tuple, ends), lower_end(pairs, F(1, 2)), lower_end(pairs, F(1, 2), "difference")))
    assert len(found) == 1


def test_what_says_nothing_proves_nothing() -> None:
    level = F(1, 20)
    for profiles, limits_, drop in (
        ({}, UNIT, False),
        ({(F(1), None): 50}, UNIT, False),  # no unit was seen in the lower group
        ({(F(1), None): 50}, UNIT, True),
        ({(F(1), F(0)): 50}, UNIT, False),  # the lower group got nothing
        ({(F(0), F(0)): 50}, (F(0), F(0)), False),  # a utility of one value
    ):
        assert upper_end(contrasts(profiles, 0, 1, limits_, drop=drop), level) == inf  # type: ignore[arg-type]
    assert lower_end([], level) == 1
    assert value(wealth(contrasts({(F(0), F(0)): 50}, 0, 1, (F(0), F(0))), F(2))) == 1
    # One unit that got all: 1 + 15/16·(r − 1) is 20.
    assert upper_end(contrasts({(F(1), F(1)): 1}, 0, 1, UNIT), level) == F(21266667, 10**6)
    assert upper_end(contrasts({(F(1), F(0)): 50}, 0, 1, UNIT), level, "difference") == 1
    # The higher group was never seen: it got at most the most, of which the lower one got half.
    end = upper_end(contrasts({(None, HALF): 400}, 0, 1, UNIT), level)
    assert 2 < end < F(21, 10)
    with pytest.raises(ValueError, match="outside the range"):
        contrasts({(F(2), F(0)): 1}, 0, 1, UNIT)


def test_limits_at_which_a_bet_could_lose_more_than_there_is_are_never_proved() -> None:
    alike = Contrasts({(F(1), F(1)): 40})
    assert not is_below(alike, F(-100), F(9, 10)) and not is_below(alike, F(-100), F(9, 10), "difference")
    assert not is_above([alike, alike], F(100), F(9, 10), "difference")


def test_a_scale_changes_nothing() -> None:
    profiles: Any = {(x * 4, y * 4): 1 + i for i, (x, y) in enumerate(product([F(0), HALF, F(1)], repeat=2))}
    scaled: Any = {(x / 4, y / 4): n for (x, y), n in profiles.items()}
    assert contrasts(profiles, 1, 0, (F(0), F(4))) == contrasts(scaled, 1, 0, UNIT)
    shifted: Any = {(x - 3, y - 3): n for (x, y), n in profiles.items()}
    assert contrasts(profiles, 1, 0, (F(0), F(4))) == contrasts(shifted, 1, 0, (F(-3), F(1)))
