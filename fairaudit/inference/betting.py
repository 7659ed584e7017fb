"""Test martingales: what a gambler wins who bets against a supposed mean of a cell, and the means that this excludes.

The utility of each decision is scaled to [0, 1]. For a supposed mean p of a cell, a gambler who bets the share λ on every decision has

    1 + λ·(x₁ − p), times 1 + λ·(x₂ − p), and so on,

which is a test martingale if every decision has the mean p given the past, and a supermartingale if it has less. So is a mixture over
bets λ that were fixed in advance; a mixture is a function of how often each value came, and nothing else. By Ville's inequality it ever
reaches 1/β with probability at most β: a mean at which it has can be excluded, at any moment, by anybody who looks. Here the bets are
min(2^i, 15/(16p)), and a part of the money is never bet; the wealth falls in p, and exchanging x, p for 1 − x, 1 − p gives that against
means that are too great.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import ceil, floor, log, log10
from typing import Literal

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.inference.rounding import Number, number_below, power_below, product_below, sum_below

Side = Literal["above", "below"]

BETS = range(-16, 5)  # powers of 2: the least is best for differences that only 10^11 decisions show, the greatest for means below 1/17

CENTRE = -2  # 1/4 is the best bet where the mean is 1/16 above a supposed 1/2, which about a thousand decisions show

IDLE = Fraction(1, 32)  # is never bet: in a product of two wealths a cell that says nothing takes no more than this factor

CAP = Fraction(15, 16)  # of p: a bet leaves at least a sixteenth of the money, whatever comes

# Shares fall with the square of the distance from the centre; 29/20 is the greatest number of twentieths with which all money is at most 1.
SHARES = tuple(Fraction(29, 20) / ((abs(i - CENTRE) + 2) * (abs(i - CENTRE) + 3)) for i in BETS)

DIGITS = 7  # of an end, as in `ends`

_LAMBDAS = 2.0 ** np.array(BETS, dtype=np.float64)

_LOG_SHARES = np.log(np.array([float(share) for share in SHARES]))

LOG_IDLE = log(float(IDLE))


@dataclass(frozen=True)
class ValueCounts:
    """How often each value was drawn in a cell, the values scaled to [0, 1].

    Examples
    --------
    >>> ValueCounts({Fraction(0): 40, Fraction(1): 60}).draws
    100
    """

    counts: dict[Fraction, int] = field(hash=False)

    @property
    def draws(self) -> int:
        """Number of decisions."""
        return sum(self.counts.values())

    @cached_property
    def mean(self) -> Fraction:
        """Mean of the values."""
        return sum((x * n for x, n in self.counts.items()), Fraction(0)) / self.draws

    @cached_property
    def arrays(self) -> tuple[Floats, Floats]:
        """Values and counts in floats."""
        return np.array([float(x) for x in self.counts]), np.array([float(n) for n in self.counts.values()])

    def log_wealth(self, means: Floats, side: Side) -> Floats:
        """Logarithm of the wealth against each of some means, in floats."""
        x, n = self.arrays
        return log_wealth(x, n, means) if side == "above" else log_wealth(1 - x, n, 1 - means)


def log_wealth(values: Floats, counts: Floats, means: Floats) -> Floats:
    """Logarithm of the wealth against supposed means, in floats: for searching and simulations, not for conclusions.

    Parameters
    ----------
    values : ndarray, shape (values,)
        The different values, in [0, 1].
    counts : ndarray, shape (..., values)
        How often each was drawn.
    means : ndarray, shape (...)
        The supposed means, in [0, 1]; shapes are broadcast.

    Returns
    -------
    ndarray
        The logarithm of the mixture over bets: great where the draws say that the mean is above the supposed one.

    Examples
    --------
    >>> float(log_wealth(np.array([0.0, 1.0]), np.array([40.0, 60.0]), np.array(0.3)).round(3))
    15.066
    """
    p = np.asarray(means)[..., None]
    with np.errstate(divide="ignore"):
        bets = np.minimum(_LAMBDAS, float(CAP) / p)
    terms = np.broadcast_to(_LOG_SHARES, np.broadcast_shapes(bets.shape, (*counts.shape[:-1], 1))).copy()
    for k in range(len(values)):
        terms += counts[..., k, None] * np.log1p(bets * (values[k] - p))
    top = np.maximum(terms.max(axis=-1), LOG_IDLE)
    return np.asarray(top + np.log(np.exp(terms - top[..., None]).sum(axis=-1) + np.exp(LOG_IDLE - top)))


def wealth(drawn: ValueCounts, mean: Fraction, side: Side) -> Number:
    """Bound the wealth against a mean from below, in integers: (m, e) says at least m·2^e.

    Examples
    --------
    >>> m, e = wealth(ValueCounts({Fraction(0): 40, Fraction(1): 60}), Fraction(3, 10), "above")
    >>> round(log(m * 2**e), 3)
    15.066
    """
    if not (mean > 0 if side == "above" else mean < 1):
        raise ValueError("a mean at the end of the range cannot be tested")
    draws = [(x if side == "above" else 1 - x, n) for x, n in drawn.counts.items() if n]
    p = mean if side == "above" else 1 - mean
    cap = CAP / p
    parts: list[Number] = [number_below(IDLE)]
    capped = Fraction(0)
    for i, share in zip(BETS, SHARES, strict=True):
        bet = Fraction(2) ** i
        if bet >= cap:
            capped += share
        else:
            parts.append(_bet(draws, p, bet, share))
    if capped:
        parts.append(_bet(draws, p, cap, capped))
    return sum_below(parts)


def wealth_reaches(parts: Sequence[Number], level: Fraction) -> bool:
    """Whether the product of wealths is at least 1/level."""
    product: Number = (level.numerator, 0)
    for m, e in parts:
        product = product[0] * m, product[1] + e
    m, e = product
    return m << e >= level.denominator if e >= 0 else m >= level.denominator << -e


def _bet(draws: Sequence[tuple[Fraction, int]], p: Fraction, bet: Fraction, share: Fraction) -> Number:
    total = number_below(share)
    for x, n in draws:
        total = product_below(total, power_below(number_below(1 + bet * (x - p)), n))
    return total


def betting_end(drawn: ValueCounts, level: Fraction, side: Side, exact: bool) -> Fraction:
    """The outermost mean that is excluded: too low a one ("above") or too high ("below")."""
    if side == "below":
        return 1 - betting_end(ValueCounts({1 - x: n for x, n in drawn.counts.items()}), level, "above", exact)
    if not drawn.mean:
        return Fraction(0)
    need = -log(float(level)) + 1e-9
    guess = greatest_excluded(drawn, need)
    scale = 10 ** (DIGITS - 1 + max(0, ceil(-log10(guess)))) if guess > 0 else 1
    at = floor(Fraction(guess) * scale)
    for step in (1, 10, 1000, 10**5):
        if at <= 0:
            return Fraction(0)
        if not exact or wealth_reaches([wealth(drawn, Fraction(at, scale), "above")], level):
            return Fraction(at, scale)
        at -= step
    return Fraction(0)


def greatest_excluded(drawn: ValueCounts, need: float) -> float:
    """The greatest mean against which the logarithm of the wealth is at least `need`."""
    low, high = 0.0, float(drawn.mean)
    x, n = drawn.arrays
    # Several points at once shrink the bracket by a factor of 32 in each round; the first rounds are logarithmic, for small means.
    low = 1e-300
    for _ in range(12):
        points = np.exp(np.linspace(log(low), log(high), 33)) if high > 1.5 * low else np.linspace(low, high, 33)
        reached = log_wealth(x, n, points) >= need
        if not reached[0]:
            return 0.0
        last = int(np.flatnonzero(reached)[-1])
        if last == 32:
            return high
        low, high = float(points[last]), float(points[last + 1])
    return low
