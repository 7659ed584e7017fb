"""The exact pair bound by definition: order, staircase and ladder from decimals and scipy, and what is excluded at all outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import beta, binom

GUARD = 0.02


@lru_cache(maxsize=1 << 17)
def score_ends(k: int, n: int, scale: Fraction) -> tuple[int, int]:
    """Both ends of the score interval times 2^64, rounded down, by decimals of 80 digits."""
    with localcontext() as context:
        context.prec = 80
        z2 = Decimal(scale.numerator) / scale.denominator
        root = (z2 * (Decimal(k * (n - k)) / n + z2 / 4)).sqrt()
        lower, upper = ((k + z2 / 2 + sign * root) / (n + z2) * 2**64 for sign in (-1, 1))
        return (int(lower) if k else 0), int(upper)


def staircase(counts: tuple[int, int, int, int], scale: Fraction, difference: bool) -> list[int]:
    """For each k the least k' that is ordered no later than the observed pair; one more than the draws if there is none."""
    k, n, other, m = counts
    top, bottom = score_ends(k, n, scale)[1], score_ends(other, m, scale)[0]
    ends = [score_ends(i, m, scale)[0] for i in range(m + 1)]
    found = []
    for i in range(n + 1):
        upper = score_ends(i, n, scale)[1]
        first = (j for j, low in enumerate(ends) if (upper - low <= top - bottom if difference else upper * bottom <= top * low))
        found.append(next(first, m + 1))
    return found


def image(knot: float, limit: float, difference: bool) -> float:
    return min(max(knot + limit if difference else knot * limit, 0.0), 1.0)


def rarity(
    counts: tuple[int, int, int, int], limit: Fraction, level: Fraction, knots: Sequence[Fraction], scale: Fraction, difference: bool
) -> float:
    """How far the hardest condition of a ladder is from failing: at most 1 if the knots prove the limit, more than 1 if they do not."""
    k, n, other, m = counts
    if not knots or knots[0] < 0 or knots[-1] > 1 or any(q <= p for p, q in pairwise(knots)) or (not difference and not other):
        return 2.0
    q = np.array([float(x) for x in knots])
    p = np.array([image(x, float(limit), difference) for x in q])
    share = float(level) * GUARD / 4
    start, stop = binom.sf(other - 1, m, q[0]) / share, binom.cdf(k, n, p[-1]) / share
    if len(q) == 1:
        full = 0.0 if limit * knots[0] >= 1 or (difference and limit + knots[0] >= 1) else 9.0
        return float(min(stop if q[0] == 0 else 9.0, max(start, min(stop, full))))
    begins = 0.0 if q[0] == 0 or p[0] == 0 else min(start, binom.sf(k - 1, n, p[0]) / share)
    ends = 0.0 if q[-1] == 1 or p[-1] == 1 else min(stop, binom.cdf(other, m, q[-1]) / share)
    stairs = np.array(staircase(counts, scale, difference))
    weights = [float(binom.pmf(np.arange(n + 1), n, a) @ binom.sf(stairs - 1, m, b)) for a, b in zip(p, q[1:], strict=False)]
    return float(max(begins, ends, max(weights) / (float(level) * (1 - GUARD))))


def levels_of_rejection(n: int, m: int, limit: float, level: float, scale: Fraction, difference: bool, points: int) -> Any:
    """For each outcome β plus the chance, at the worst means of its box that were tried, of outcomes ordered no later."""
    tops, lows = [score_ends(k, n, scale)[1] for k in range(n + 1)], [score_ends(k, m, scale)[0] for k in range(m + 1)]
    order = np.array([[a - b if difference else a / b if b else np.inf for b in lows] for a in tops], dtype=float)
    places = np.unique(order, return_inverse=True)[1].reshape(order.shape)
    share = GUARD * level / 4
    k, other = np.arange(n + 1), np.arange(m + 1)
    with np.errstate(invalid="ignore"):
        low, high = np.where(k > 0, beta.ppf(share, k, n - k + 1), 0), np.where(k < n, beta.ppf(1 - share, k + 1, n - k), 1)
        other_low = np.where(other > 0, beta.ppf(share, other, m - other + 1), 0)
        other_high = np.where(other < m, beta.ppf(1 - share, other + 1, m - other), 1)
    first, last = (ends + limit if difference else ends * limit for ends in (other_low, other_high))
    worst = np.full(order.shape, np.nan)  # where no means of the box are tried
    worst[high[:, None] < first[None, :]] = 0.0  # no means of the box are in the null
    worst[low[:, None] > last[None, :]] = 1.0 - GUARD * level  # all are, none on its boundary
    for q in np.sin(np.linspace(0, np.pi / 2, points + 1)) ** 2:
        p = limit + q if difference else limit * q
        if not 0 <= p <= 1:
            continue
        joint = binom.pmf(k, n, p)[:, None] * binom.pmf(other, m, q)[None, :]
        values = np.cumsum(np.bincount(places.ravel(), joint.ravel(), places.max() + 1))[places]
        inside = ((low <= p) & (p <= high))[:, None] & ((other_low <= q) & (q <= other_high))[None, :]
        worst = np.where(inside, np.fmax(worst, values), worst)
    worst += GUARD * level
    if not difference:
        worst[:, 0] = 1.0
    return worst
