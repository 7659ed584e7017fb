"""Contrasts within a unit: what a gambler wins who bets that of two groups one gets less than a multiple of the other.

A unit, a résumé or a prompt, is seen in several groups; let x and y be what it got in the groups i and j, scaled to [0, 1]. If E(x) is
at least r·E(y), a factor 1 + λ·(r·y − x) has at most the mean 1, and it is not negative for λ < 1. Its product over independent units,
averaged over bets λ that were fixed in advance, is therefore at least 1/level with at most the probability `level`, by Markov's
inequality, however x and y of one unit depend on each other. It rises in r: ratios above one that is excluded are excluded with it.
Against E(x) ≥ E(y) + d the factor is 1 + λ·(d − x + y)/2.

A ratio of all pairs is exceeded if the average of what the bets on all ordered pairs won is 1/level or more: if no pair exceeds it, each of
them wins at most 1 in the mean, and so does their average, whatever they have to do with each other.

A unit that was not seen in a group of its pair is taken as what is worst for the gambler, 1 for x and 0 for y; or it is left out, where it
is declared that units are missing by design. If a utility has one value only, its range says all, and nothing is bet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from math import ceil, exp, floor, inf, log, log10
from typing import Literal

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import Extended
from fairaudit.inference.betting import wealth_reaches
from fairaudit.inference.cells import Ends, Profiles
from fairaudit.inference.ends import DIGITS
from fairaudit.inference.rounding import Number, number_below, power_below, product_below, sum_below

Claim = Literal["ratio", "difference"]
"""Of what a limit is: E(x)/E(y), or E(x) − E(y) as a part of the width of the range."""

BETS = (Fraction(15, 16), Fraction(2, 3))  # and their halves: a bet leaves at least a sixteenth of the money, whatever comes

SPREAD = 24  # λ²·D, where bets end: the best ones for draws that just reach a level are not smaller

GREATEST = 10**9  # ratio that is looked for; beyond it the end is infinite

LEAST = {"ratio": 0, "difference": -1}  # limits at which no unit takes more than what was bet

STEPS = (0, 1, 10, 1000, 10**5)  # of its last digit, by which an end yields where rounding spoilt its proof


@dataclass(frozen=True)
class Contrasts:
    """How many units have each pair of values (x, y) in two groups, the values scaled to [0, 1].

    Examples
    --------
    >>> Contrasts({(Fraction(1), Fraction(0)): 3, (Fraction(1), Fraction(1)): 7}).units
    10
    """

    counts: dict[tuple[Fraction, Fraction], int]

    @property
    def units(self) -> int:
        """Number of units."""
        return sum(self.counts.values())

    @cached_property
    def bets(self) -> list[Fraction]:
        """The bets that are made on so many units."""
        return bets(Fraction(2 * self.units))

    @cached_property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Values, counts and bets in floats."""
        x, y = (np.array([float(pair[k]) for pair in self.counts]) for k in (0, 1))
        return x, y, np.array([float(n) for n in self.counts.values()]), np.array([float(bet) for bet in self.bets])


def bets(spread: Fraction) -> list[Fraction]:
    """15/16, 2/3, and their halves by turns, up to and with the first λ for which λ² times the spread of the contrast is at most 24.

    Examples
    --------
    >>> [str(bet) for bet in bets(Fraction(200))]
    ['15/16', '2/3', '15/32', '1/3']
    """
    found = [BETS[0]]
    while found[-1] ** 2 * spread > SPREAD:
        found.append(BETS[len(found) % 2] / 2 ** (len(found) // 2))
    return found


def contrasts(profiles: Profiles, higher: int, lower: int, limits: Ends, *, drop: bool = False) -> Contrasts:
    """Compare two groups of a context, unit by unit.

    Parameters
    ----------
    profiles : mapping
        How many units got these values in the groups of the context, None where a unit was not seen.
    higher, lower : int
        The positions of the groups i and j, of which E_i/E_j or E_i − E_j is to be bounded from above.
    limits : tuple of Fraction
        The declared range of the utility; for ratios its lower limit is 0.
    drop : bool
        Whether units that are missing in one of the two groups are left out, because they are missing by design.

    Examples
    --------
    >>> zero, one = Fraction(0), Fraction(1)
    >>> contrasts({(one, zero): 3, (one, None): 2}, 0, 1, (zero, Fraction(2))).counts
    {(Fraction(1, 2), Fraction(0, 1)): 5}
    """
    return _contrasts(*_scaled(profiles, limits), higher, lower, drop=drop)


def ordered_pairs(profiles: Profiles, limits: Ends, *, drop: bool = False) -> list[Contrasts]:
    """The contrasts of all ordered pairs of groups of a context, (0, 1), (0, 2), … first."""
    groups = len(next(iter(profiles), ()))
    scaled = _scaled(profiles, limits)
    return [_contrasts(*scaled, i, j, drop=drop) for i, j in permutations(range(groups), 2)]


def _scaled(profiles: Profiles, limits: Ends) -> tuple[list[Fraction], list[tuple[tuple[int, ...], int]]]:
    """Different values as parts of the range, and profiles as positions among them, -1 where a unit was not seen; none without a range."""
    low, high = limits
    values = sorted({value for profile in profiles for value in profile if value is not None})
    if values and not (low <= values[0] and values[-1] <= high):
        raise ValueError(f"a value of {values[0] if values[0] < low else values[-1]} is outside the range from {low} to {high}")
    if low == high:
        return [], []
    code: dict[Fraction | None, int] = {None: -1, **{value: k for k, value in enumerate(values)}}
    return [(value - low) / (high - low) for value in values], [(tuple(map(code.__getitem__, own)), n) for own, n in profiles.items()]


def _contrasts(values: Sequence[Fraction], coded: Sequence[tuple[tuple[int, ...], int]], i: int, j: int, *, drop: bool) -> Contrasts:
    seen: dict[tuple[int, int], int] = {}
    for codes, n in coded:
        two = codes[i], codes[j]
        seen[two] = seen.get(two, 0) + n
    counts: dict[tuple[Fraction, Fraction], int] = {}
    for (x, y), n in seen.items():
        if n and not (drop and min(x, y) < 0):
            pair = Fraction(1) if x < 0 else values[x], Fraction(0) if y < 0 else values[y]
            counts[pair] = counts.get(pair, 0) + n
    return Contrasts(dict(sorted(counts.items())))


def log_wealth(pair: Contrasts, limit: float, claim: Claim = "ratio") -> float:
    """Logarithm of what the bets against E(x) ≥ limit·E(y) won, in floats: for searching and simulations, not for conclusions.

    Examples
    --------
    >>> alike = Contrasts({(Fraction(0), Fraction(0)): 50, (Fraction(1), Fraction(1)): 50})
    >>> round(log_wealth(alike, 1.2), 3)
    7.318
    """
    x, y, n, bet = pair.arrays
    gain = limit * y - x if claim == "ratio" else (limit - x + y) / 2
    return log_mean(np.log1p(bet[:, None] * gain) @ n)


def log_mean(logarithms: Floats) -> float:
    """Logarithm of the mean of numbers that are given by theirs."""
    ordered = np.sort(logarithms, axis=None)  # so that the order in which they come changes no digit
    top = float(ordered[-1])
    return top + log(float(np.exp(ordered - top).mean())) if top > -inf else -inf


def wealth(pair: Contrasts, limit: Fraction, claim: Claim = "ratio") -> Number:
    """Bound the same from below, in integers: (m, e) says at least m·2^e; 0 where a bet could lose more than there is."""
    if limit < LEAST[claim]:
        return 0, 0
    won: list[Number] = []
    for bet in pair.bets:
        total: Number = (1, 0)
        for (x, y), n in pair.counts.items():
            gain = limit * y - x if claim == "ratio" else (limit - x + y) / 2
            total = product_below(total, power_below(number_below(1 + bet * gain), n))
        won.append(total)
    return mean_below(won)


def mean_below(numbers: Sequence[Number]) -> Number:
    """The mean of some numbers, rounded down."""
    return product_below(sum_below(numbers), number_below(Fraction(1, len(numbers))))


def is_below(pair: Contrasts, limit: Fraction, level: Fraction, claim: Claim = "ratio") -> bool:
    """Whether E(x)/E(y), or E(x) − E(y), is proved to be less than a limit, wrong with at most the probability `level`.

    Examples
    --------
    >>> alike = Contrasts({(Fraction(0), Fraction(0)): 50, (Fraction(1), Fraction(1)): 50})
    >>> is_below(alike, Fraction(6, 5), Fraction(1, 20)), is_below(alike, Fraction(1), Fraction(1, 20))
    (True, False)
    """
    return wealth_reaches([wealth(pair, limit, claim)], level)


def is_above(pairs: Sequence[Contrasts], limit: Fraction, level: Fraction, claim: Claim = "ratio") -> bool:
    """Whether the greatest ratio, or difference, is proved to be more than a limit, wrong with at most the probability `level`.

    Parameters
    ----------
    pairs : sequence of Contrasts
        All ordered pairs of groups of all contexts.
    limit, level : Fraction
        The limit, at least 1 for ratios and 0 for differences, and the probability of error.
    claim : {"ratio", "difference"}
        Of what the limit is.
    """
    opposite = 1 / limit if claim == "ratio" else -limit
    return wealth_reaches([mean_below([wealth(pair, opposite, claim) for pair in pairs])], level)


def upper_end(pair: Contrasts, level: Fraction, claim: Claim = "ratio") -> Extended:
    """The least limit below which E(x)/E(y), or E(x) − E(y), is proved to be, rounded up to about seven digits.

    Examples
    --------
    >>> alike = Contrasts({(Fraction(0), Fraction(0)): 50, (Fraction(1), Fraction(1)): 50})
    >>> float(upper_end(alike, Fraction(1, 20)))
    1.087427
    """
    return least_limit(lambda limit: log_wealth(pair, limit, claim), lambda limit: is_below(pair, limit, level, claim), level, claim)


def lower_end(pairs: Sequence[Contrasts], level: Fraction, claim: Claim = "ratio") -> Fraction:
    """The greatest limit above which the greatest ratio, or difference, of some ordered pairs is proved to be; else 1, or 0.

    Examples
    --------
    >>> apart = {(Fraction(0), Fraction(0)): 50, (Fraction(1), Fraction(0)): 25, (Fraction(1), Fraction(1)): 25}
    >>> float(lower_end(ordered_pairs(apart, (Fraction(0), Fraction(1))), Fraction(1, 20)))
    1.433139
    """
    if not pairs:
        return Fraction(1 if claim == "ratio" else 0)

    def won(limit: float) -> float:
        return log_mean(np.array([log_wealth(pair, limit, claim) for pair in pairs]))

    return greatest_limit(won, lambda limit: is_above(pairs, limit, level, claim), level, claim)


def greatest_limit(search: Callable[[float], float], proved: Callable[[Fraction], bool], level: Fraction, claim: Claim) -> Fraction:
    """The greatest limit that is proved; the logarithm of what was won against its opposite, a rising function, says where to look."""
    nothing = Fraction(1 if claim == "ratio" else 0)
    opposite = crossing(search, level, claim)
    guess = 1 / opposite if claim == "ratio" else -opposite
    if guess <= nothing:
        return nothing
    scale = decimal_scale(guess, claim)
    at = floor(Fraction(guess) * scale)
    for limit in (Fraction(at - step, scale) for step in STEPS):
        if limit > nothing and proved(limit):
            return limit
    return nothing


def least_limit(search: Callable[[float], float], proved: Callable[[Fraction], bool], level: Fraction, claim: Claim) -> Extended:
    """The least limit that is proved; the logarithm of what was won against it, a rising function, says where to look."""
    nothing: Extended = inf if claim == "ratio" else Fraction(1)
    guess = crossing(search, level, claim)
    if guess == inf:
        return nothing
    scale = decimal_scale(guess, claim)
    at = ceil(Fraction(guess) * scale)
    for limit in (Fraction(at + step, scale) for step in STEPS):
        if limit < nothing and proved(limit):
            return limit
    return nothing


def crossing(won: Callable[[float], float], level: Fraction, claim: Claim) -> float:
    """The limit at which the logarithm of what was won reaches that of 1/level, nearly; infinite if there is none in reach."""

    def rising(at: float) -> float:
        return won(exp(at) if claim == "ratio" else at) + log(float(level))

    step, reach = (log(2), log(GREATEST)) if claim == "ratio" else (1.0, 1.0)
    low = high = 0.0
    below = above = rising(0.0)
    while below >= 0 and low > -reach:
        low = max(2 * low - step, -reach)
        below = rising(low)
    while above < 0 and high < reach:
        high = min(2 * high + step, reach)
        above = rising(high)
    if above < 0:
        return inf
    kept = 0  # how often in a row the same end was moved: then the other one weighs half as much (the Illinois rule)
    for _ in range(100):
        if high - low <= 1e-10:
            break
        at = (low * above - high * below) / (above - below) if below > -inf else (low + high) / 2
        value = rising(at)
        if value >= 0:
            high, above, kept = at, value, max(1, kept + 1)
            below /= 2 if kept > 1 else 1
        else:
            low, below, kept = at, value, min(-1, kept - 1)
            above /= 2 if kept < -1 else 1
    return exp(high) if claim == "ratio" else high


def decimal_scale(limit: float, claim: Claim) -> int:
    """The power of ten of which an end is a multiple: about seven digits of a ratio, as many after the point of a difference."""
    return int(10**DIGITS if claim == "difference" else 10 ** (DIGITS - 1 + max(0, ceil(-log10(limit)))))
