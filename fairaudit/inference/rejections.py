"""Which draws of two cells show that a ratio of means is less than a limit: in floats, for plans, never for conclusions.

Each region of an interval has its own rule, and all of them are monotone: fewer successes in the first cell, or more in the second, reject
whatever was rejected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, exp, inf, log, sqrt
from typing import Any, Literal

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.inference.ends import Method
from fairaudit.inference.float_tails import float_ends, float_tails
from fairaudit.inference.pair_exact import GUARD, order_scale
from fairaudit.inference.paired_betting import bets
from fairaudit.inference.product_region import SLACK
from fairaudit.inference.symmetric_betting import MOST_PAIRS

Side = Literal["lower", "upper"]

MEANS = 24  # of the second cell at which a staircase is weighed: with twice as many, sizes stay the same to a hundredth

REACH = 9  # standard errors: what lies beyond is left out

ALONG = 80  # means along the boundary of a product region

GRID = 80  # sums at which ends are found; between them they are nearly straight

CHUNK = 4096  # pairs of sums at a time

STAIRCASES = 40  # of different pairs, the decisive ones first; the thresholds of others follow from theirs


@dataclass(frozen=True)
class Supposed:
    """A cell as a plan supposes it: so many draws, with this mean and standard deviation on the scale on which the range is [0, 1]."""

    draws: float
    share: float
    deviation: float
    low: float
    high: float
    binary: bool

    @property
    def mean(self) -> float:
        """The mean of a draw."""
        return self.low + (self.high - self.low) * self.share

    def grown(self, factor: float) -> Supposed:
        """The same cell with more draws."""
        return Supposed(max(1, ceil(self.draws * factor * (1 - 1e-12))), self.share, self.deviation, self.low, self.high, self.binary)

    def sums(self, generator: np.random.Generator, shape: tuple[int, ...]) -> Floats:
        """Sums of its draws, of tables that are simulated."""
        n, p = int(self.draws), self.share
        if self.deviation**2 >= p * (1 - p) * (1 - 1e-9):
            return generator.binomial(n, p, shape).astype(np.float64)
        return np.clip(generator.normal(n * p, sqrt(n) * self.deviation, shape), 0, n)


Rejects = Callable[[Supposed, Floats, Supposed, Floats, float], Any]
"""By cell and sums of the first, those of the second, and the limit: of each table whether the ratio of their means is shown to be less."""


def by_boxes(level: float, method: Method) -> Rejects:
    """The rule of the box: the upper end of the first cell over the lower end of the second."""

    def rejects(one: Supposed, sums: Floats, other: Supposed, others: Floats, limit: float) -> Any:
        return end_of_sums(one, sums, level, method, "upper") <= limit * end_of_sums(other, others, level, method, "lower")

    return rejects


def end_of_sums(cell: Supposed, sums: Floats, level: float, method: Method, side: Side) -> Floats:
    """An end of the mean of a cell, for each sum."""
    if not level or cell.low == cell.high:
        return np.full(sums.shape, cell.low if side == "lower" else cell.high)
    at, back = np.unique(sums, return_inverse=True)
    if len(at) > GRID:
        grid = np.linspace(at[0], at[-1], GRID)
        ends = np.interp(at, grid, _unit_end(cell, grid, level, method, side))
    else:
        ends = _unit_end(cell, at, level, method, side)
    found: Floats = (cell.low + (cell.high - cell.low) * ends)[back].reshape(sums.shape)
    return found


def _unit_end(cell: Supposed, sums: Floats, level: float, method: Method, side: Side) -> Floats:
    n = cell.draws
    if cell.binary or method == "hoeffding-kl":
        return float_ends(n, sums, level, side, binary=cell.binary)
    if method == "intersection":
        first, second = (_unit_end(cell, sums, level / 2, each, side) for each in ("hoeffding-kl", "empirical-bernstein"))
        return np.maximum(first, second) if side == "lower" else np.minimum(first, second)
    radius = inf if n < 2 else cell.deviation * sqrt(2 * log(2 / level) / n) + 7 * log(2 / level) / (3 * (n - 1))
    return np.clip(sums / n + (radius if side == "upper" else -radius), 0.0, 1.0)


def by_products(guard: float, c: float) -> Rejects:
    """The rule of the product region: along the limit, within the ends at the guard, no product of tails is above c."""

    def rejects(one: Supposed, sums: Floats, other: Supposed, others: Floats, limit: float) -> Any:
        # The ladder of an end has its slack of the way from the ratio of the draws.
        limit = exp((log(limit) + SLACK * log(one.mean / other.mean)) / (1 + SLACK)) if one.mean * other.mean > 0 else limit
        tops, of_top = np.unique(sums, return_inverse=True)
        bottoms, of_bottom = np.unique(others, return_inverse=True)
        highest = end_of_sums(one, tops, guard, "hoeffding-kl", "upper")
        lowest = end_of_sums(other, bottoms, guard, "hoeffding-kl", "lower")
        last = max(float(highest.max()) / limit, float(lowest.max()))
        means = np.linspace(float(lowest.min()), last, ALONG)
        above = float_tails(other.draws, other.draws - bottoms[:, None], 1 - _share(other, means), binary=other.binary)
        below = float_tails(one.draws, tops[:, None], _share(one, limit * means), binary=one.binary)
        above[means <= lowest[:, None]] = 0.0
        below[limit * means >= highest[:, None]] = 0.0
        pairs, back = np.unique(of_top.ravel() * len(bottoms) + of_bottom.ravel(), return_inverse=True)
        top, bottom = np.divmod(pairs, len(bottoms))
        parts = np.array_split(np.arange(len(pairs)), len(pairs) // CHUNK + 1)
        most = np.concatenate([(below[top[part]] * above[bottom[part]]).max(axis=1) for part in parts])
        return ((most <= c) & (lowest[bottom] > 0))[back].reshape(sums.shape)

    return rejects


def _share(cell: Supposed, means: Floats) -> Floats:
    """Means on the scale on which the range is [0, 1]."""
    found: Floats = (means - cell.low) / (cell.high - cell.low)
    return np.clip(found, 0.0, 1.0)


def by_pairs(level: Fraction) -> Rejects:
    """The rule of the exact pair bound, a staircase; the box of means, which depends on the draws, is put around what is expected."""
    shifts: list[float] = []
    scale = float(order_scale(level))

    def rejects(one: Supposed, sums: Floats, other: Supposed, others: Floats, limit: float) -> Any:
        bound = limit * other.high / one.high
        usual = _usual_threshold(one, other, bound, float(level), scale)
        if len(shifts) < STAIRCASES:
            found = _threshold(one, other, bound, float(level), scale)
            shifts.append(found - usual if abs(found) < inf else 0.0)
        else:
            found = usual + max(shifts)
        with np.errstate(divide="ignore"):
            order = np.log(score_end(one.draws, sums, scale, 1)) - np.log(score_end(other.draws, others, scale, -1))
        return order <= found

    return rejects


def by_contrasts(level: Fraction) -> Rejects:
    """The rule of bets on contrasts, with what they win to the second order: the mean and the spread of the draws."""

    def rejects(one: Supposed, sums: Floats, other: Supposed, others: Floats, limit: float) -> Any:
        n, m = int(one.draws), int(other.draws)
        pairs = min(n, m, MOST_PAIRS)
        bound = limit * other.high / one.high
        means = [(cell.low + (cell.high - cell.low) * s / cell.draws) / cell.high for cell, s in ((one, sums), (other, others))]
        spread = [((cell.high - cell.low) / cell.high * cell.deviation) ** 2 / cell.draws for cell in (one, other)]
        gap, variance = bound * means[1] - means[0], spread[0] + bound**2 * spread[1]
        made = [float(bet) for bet in bets(pairs**2 * (Fraction(1, n) + Fraction(1, m)))]
        won = [pairs * np.log1p(bet * gap) - (pairs * bet) ** 2 * variance / (1 + bet * gap) ** 2 / 2 for bet in made]
        return np.logaddexp.reduce(won) - log(len(made)) >= -log(level)

    return rejects


def score_end(draws: float, sums: Floats, scale: float, side: int) -> Floats:
    """The end of the score interval on one side, exactly 0 where it is."""
    root = np.sqrt(scale * (sums * (draws - sums) / draws + scale / 4))
    found: Floats = (sums + scale / 2 + side * root) / (draws + scale)
    return np.where(sums > 0, found, 0.0) if side < 0 else found


def _usual_threshold(one: Supposed, other: Supposed, limit: float, level: float, scale: float) -> float:
    """The logarithm of the greatest T that rejects, as many draws have it."""
    from scipy.special import ndtri

    errors = [sqrt((1 - p) / p / (cell.draws + 1)) for cell in (one, other) for p in [(cell.draws * cell.share + 0.5) / (cell.draws + 1)]]
    return log(limit) + sqrt(scale) * sum(errors) + float(ndtri(level)) * sqrt(errors[0] ** 2 + errors[1] ** 2)


def _threshold(one: Supposed, other: Supposed, limit: float, level: float, scale: float) -> float:
    """The same for these draws: the staircase has at most the level at every mean of the null in the box."""
    from scipy.special import betaincinv

    n, m = one.draws, other.draws
    guard = float(GUARD) * level
    (low, high), (other_low, other_high) = (
        (
            float(betaincinv(k, rest + 1, guard / 4)) if k > 0 else 0.0,
            float(betaincinv(k + 1, rest, 1 - guard / 4)) if rest > 0 else 1.0,
        )
        for cell in (one, other)
        for k, rest in [(cell.draws * cell.share, cell.draws * (1 - cell.share))]
    )
    start, stop = max(other_low, low / limit), min(other_high, high / limit, 1 / limit)
    if start >= stop:
        return inf if one.share < limit * other.share else -inf
    means = np.linspace(sqrt(start), sqrt(stop), MEANS) ** 2
    outcomes, law = _laws(n, np.minimum(limit * means, 1.0))
    others, other_law = _laws(m, means)
    tails = np.zeros((MEANS, len(others) + 1))
    tails[:, :-1] = np.cumsum(other_law[:, ::-1], axis=1)[:, ::-1]
    top, bottom = score_end(n, outcomes, scale, 1), score_end(m, others, scale, -1)
    goal = level - guard

    def kept(order: float) -> bool:
        return bool((law * tails[:, np.searchsorted(bottom, top / exp(order))]).sum(axis=1).max() <= goal)

    with np.errstate(divide="ignore"):
        below, above = float(np.log(top[0] / bottom[-1])) - 1, min(float(np.log(top[-1]) - np.log(bottom[bottom > 0][0])) + 1, 700.0)
    for _ in range(40):
        middle = (below + above) / 2
        below, above = (middle, above) if kept(middle) else (below, middle)
    return below


def _laws(draws: float, means: Floats) -> tuple[Floats, Floats]:
    """The binomial laws with some means, by the outcomes that are likely at one of them."""
    from scipy.special import gammaln, xlog1py, xlogy

    margin = REACH * sqrt(draws) / 2 + REACH**2 / 2
    outcomes = np.arange(max(0, ceil(draws * means.min() - margin)), min(draws, int(draws * means.max() + margin)) + 1, dtype=np.float64)
    p = means[:, None]
    logs = -gammaln(outcomes + 1) - gammaln(draws - outcomes + 1) + xlogy(outcomes, p) + xlog1py(draws - outcomes, -p)
    law: Floats = np.exp(logs - logs.max(axis=1, keepdims=True))
    return outcomes, law / law.sum(axis=1, keepdims=True)
