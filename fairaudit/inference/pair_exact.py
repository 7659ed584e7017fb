"""What two independent binomial cells prove about the ratio, or the difference, of their means: the exact pair bound.

Of k_i successes in n_i draws with mean p_i, and k_j in n_j with mean p_j, the null p_i ≥ r·p_j (or p_i ≥ p_j + d) is rejected at a level ℓ.
All tables (k, k') are ordered by T = A(k)/L(k') (or A(k) − L(k')), A the upper and L the lower end of a score interval, so that those with
T at most the observed one are k' ≥ t(k): a staircase. Means within binomial ends, which miss with probability at most β = ℓ/50, are covered
by steps between rising knots q_0, q_1, … of p_j, and in each step

    Σ_k P(Bin(n_i, r·q_{m−1}) = k)·P(Bin(n_j, q_m) ≥ t(k)) ≤ ℓ − β,

which bounds the probability of the staircase because it falls in p_i and rises in p_j. Floats look for knots; integers decide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import accumulate, chain, repeat
from math import ceil, exp, floor, inf, isqrt, log, log10, sqrt
from typing import Literal

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import Extended

Contrast = Literal["ratio", "difference"]

MAX_DRAWS = 10**6  # of a cell: beyond, the box of ends takes its place

LEVELS = Fraction(1, 10**12), Fraction(9, 10)  # below, what 64 bits leave out is no longer small; above, nobody asks

GUARD = Fraction(1, 50)  # of the level is for means beyond the binomial ends

BITS = 64

ONE = 1 << BITS  # the greatest term of a binomial law, in fixed point

MAX_KNOTS = 250  # of a ladder: an end that needs more is within a part in a thousand of one that needs fewer

STEPS = 50  # of the lattice of limits in a standard error

GUESSES = 48  # means at which a search looks before it builds a ladder

MARGIN = 1e-6  # of the level: what a search leaves to rounding


def order_scale(level: Fraction) -> Fraction:
    """z² of the score ends that order the tables, by the level of a one-sided end; a two-sided end takes that of its one-sided one.

    Examples
    --------
    >>> order_scale(Fraction(1, 20)), order_scale(Fraction(1, 400)), order_scale(Fraction(1, 10**5))
    (Fraction(25, 16), Fraction(4, 1), Fraction(9, 1))
    """
    if level >= Fraction(1, 100):
        return Fraction(25, 16)
    return Fraction(4) if level >= Fraction(1, 2000) else Fraction(9)


@lru_cache(maxsize=1 << 17)
def score_ends(successes: int, draws: int, scale: Fraction) -> tuple[int, int]:
    """L and A: the ends of the score interval with z² = `scale`, in units of 2^-64, rounded down.

    Examples
    --------
    >>> [round(end / 2**64, 4) for end in score_ends(5, 10, Fraction(4))]
    [0.2327, 0.7673]
    """
    above, below = scale.numerator, scale.denominator
    square = above * (4 * below * successes * (draws - successes) + above * draws) * draws << 2 * BITS
    root = isqrt(square)
    middle = draws * (2 * below * successes + above) << BITS
    width = 2 * draws * (below * draws + above)
    return (middle - root - (root * root < square)) // width, (middle + root) // width


@dataclass(frozen=True)
class Pair:
    """Two independent cells of two-valued draws: the mean of the first over that of the second, or minus it.

    Attributes
    ----------
    successes, draws : int
        Of the first cell, at least one draw.
    other_successes, other_draws : int
        Of the second.
    scale : Fraction
        z² of the order, see `order_scale`.
    contrast : {"ratio", "difference"}
        Of the two means.
    """

    successes: int
    draws: int
    other_successes: int
    other_draws: int
    scale: Fraction
    contrast: Contrast = "ratio"

    @cached_property
    def first(self) -> _Cell:
        """The first cell for searches."""
        return _Cell(self.successes, self.draws)

    @cached_property
    def second(self) -> _Cell:
        """The second."""
        return _Cell(self.other_successes, self.other_draws)

    @cached_property
    def observed(self) -> tuple[int, int]:
        """A and L of what was drawn."""
        lower, _ = score_ends(self.other_successes, self.other_draws, self.scale)
        return score_ends(self.successes, self.draws, self.scale)[1], lower

    def within(self, k: int, other: int) -> bool:
        """Whether T at (k, other) is at most the observed one."""
        top, bottom = score_ends(k, self.draws, self.scale)[1], score_ends(other, self.other_draws, self.scale)[0]
        if self.contrast == "ratio":
            return top * self.observed[1] <= self.observed[0] * bottom
        return top - bottom <= self.observed[0] - self.observed[1]

    @cached_property
    def staircase(self) -> list[int]:
        """The least k' with T(k, k') at most the observed T, at most the end of the second cell's window, for each k of the first's."""
        low, stop = 0, self.second.stop
        high = stop
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if self.within(self.first.start, middle) else (middle + 1, high)
        found = [low]
        for k in range(self.first.start + 1, self.first.stop):
            while low < stop and not self.within(k, low):
                low += 1
            found.append(low)
        return found

    @cached_property
    def columns(self) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        """For each k' of the second cell's window how many k of the first's are in the staircase."""
        return np.searchsorted(np.array(self.staircase), np.arange(self.second.start, self.second.stop), side="right")

    def mean(self, other: Fraction, limit: Fraction) -> Fraction:
        """The least mean of the first cell in the null, by that of the second; in [0, 1]."""
        return min(max(limit * other if self.contrast == "ratio" else limit + other, Fraction(0)), Fraction(1))

    def float_mean(self, other: Floats, limit: float) -> Floats:
        """The same in floats."""
        return np.clip(limit * other if self.contrast == "ratio" else limit + other, 0.0, 1.0)

    def inverse(self, mean: float, limit: float) -> float:
        """The mean of the second cell that goes with one of the first."""
        return mean / limit if self.contrast == "ratio" else mean - limit


@dataclass(frozen=True)
class _Cell:
    """A binomial cell in floats, by the outcomes near the observed one: all others are less likely than 10^-16 at every mean of the box."""

    successes: int
    draws: int

    @cached_property
    def reach(self) -> int:
        rest = self.draws - self.successes
        return 300 + ceil(22 * sqrt(self.successes * rest / self.draws))

    @property
    def start(self) -> int:
        return max(0, self.successes - self.reach)

    @property
    def stop(self) -> int:
        return min(self.draws, self.successes + self.reach) + 1

    @cached_property
    def outcomes(self) -> Floats:
        return np.arange(self.start, self.stop, dtype=np.float64)

    @cached_property
    def logs(self) -> Floats:
        """Logarithms of the binomial coefficients, up to a constant."""
        k = self.outcomes[1:]
        return np.concatenate([[0.0], np.cumsum(np.log((self.draws - k + 1) / k))])

    def laws(self, means: Floats) -> Floats:
        """The law of the outcomes at some means: one row for each."""
        with np.errstate(divide="ignore", invalid="ignore"):
            odds = np.log(means / (1 - means))[..., None]
            logs = self.logs + (self.outcomes - self.successes) * odds
        logs = np.exp(logs - logs.max(axis=-1, keepdims=True))
        found: Floats = logs / logs.sum(axis=-1, keepdims=True)
        found[means <= 0] = self.outcomes == 0
        found[means >= 1] = self.outcomes == self.draws
        return found

    def ends(self, level: float) -> tuple[float, float]:
        """Binomial ends, each wrong with at most this probability."""
        from scipy.special import betaincinv

        k, rest = self.successes, self.draws - self.successes
        return float(betaincinv(k, rest + 1, level)) if k else 0.0, float(betaincinv(k + 1, rest, 1 - level)) if rest else 1.0


def pair_excludes(pair: Pair, limit: Fraction, level: Fraction) -> tuple[Fraction, ...] | None:
    """Decide whether the draws reject that the ratio (or difference) is at least a limit, and prove it.

    Parameters
    ----------
    pair : Pair
        The cells.
    limit : Fraction
        The supposed least ratio, positive; or difference, more than −1.
    level : Fraction
        Probability of error.

    Returns
    -------
    tuple of Fraction or None
        Rising knots that prove it in integers: one if the null is outside the box of binomial ends, a ladder otherwise. None if it is not
        rejected.

    Examples
    --------
    >>> pair = Pair(24, 341, 22, 373, order_scale(Fraction(1, 20)))
    >>> pair_excludes(pair, Fraction(7), Fraction(1, 20))
    (Fraction(50353, 2000000),)
    >>> pair_excludes(pair, Fraction(3, 2), Fraction(1, 20)) is None
    True
    """
    if not _searchable(pair, level):
        return None
    box = _box(pair, level)
    knots = _point(pair, limit, box) or _ladder(pair, limit, level, box)
    return knots if knots is not None and proves(pair, limit, level, knots) else None


@dataclass(frozen=True)
class PairBound:
    """The upper end of a ratio or difference, and knots that prove it; None where there is nothing to prove."""

    value: Extended
    knots: tuple[Fraction, ...] | None


def pair_upper(pair: Pair, level: Fraction) -> PairBound:
    """Bound the ratio (or difference) of two means from above.

    Parameters
    ----------
    pair : Pair
        The cells.
    level : Fraction
        Probability of error.

    Returns
    -------
    PairBound
        The least limit of a fixed lattice that the draws exclude, with its knots; infinite (1 for differences) if they exclude none. The
        lattice depends on the counts alone, so that a greater level gives no greater end.

    Examples
    --------
    >>> found = pair_upper(Pair(24, 341, 22, 373, order_scale(Fraction(1, 20))), Fraction(1, 20))
    >>> round(float(found.value), 2)
    1.93
    """
    nothing = PairBound(inf if pair.contrast == "ratio" else Fraction(1), None)
    if not _searchable(pair, level):
        return nothing
    lattice = _Lattice.of(pair)
    box = _box(pair, level)
    low, high = lattice.index(_least(pair, box)), lattice.index(_greatest(pair, box)) + 2
    seen: dict[int, tuple[Fraction, ...] | None] = {}

    def excluded(i: int) -> bool:
        seen[i] = pair_excludes(pair, lattice.limit(i), level)
        return seen[i] is not None

    at = _first(lambda i: _looks_excluded(pair, float(lattice.limit(i)), level, box), low, high)
    step = 1
    while not excluded(at):
        if at > high:
            return nothing
        low, at, step = at + 1, at + step, 2 * step
    if step > 2:
        at = _first(excluded, low, at)
    limit = lattice.limit(at)
    return PairBound(limit, seen[at]) if limit < 1 or pair.contrast == "ratio" else nothing


def _first(holds: Callable[[int], bool], low: int, high: int) -> int:
    """The least integer from `low` to `high` for which something holds that holds for all greater ones, and for `high`."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


Box = tuple[tuple[float, float], tuple[float, float]]
"""Ends of the first mean and of the second, in floats."""


def _searchable(pair: Pair, level: Fraction) -> bool:
    finite = pair.other_successes > 0 or pair.contrast == "difference"
    return finite and max(pair.draws, pair.other_draws) <= MAX_DRAWS and LEVELS[0] <= level <= LEVELS[1]


def _box(pair: Pair, level: Fraction) -> Box:
    share = float(level * GUARD / 4)
    return pair.first.ends(share), pair.second.ends(share)


def _least(pair: Pair, box: Box) -> float:
    """A limit that no draws exclude."""
    (low, _), (_, high) = box
    return max(low, 0.01 / pair.draws) / high if pair.contrast == "ratio" else low - high


def _greatest(pair: Pair, box: Box) -> float:
    """A limit beyond the box."""
    (_, high), (low, _) = box
    return high / low if pair.contrast == "ratio" else high - low


@dataclass(frozen=True)
class _Lattice:
    """Limits at equal distances: of the logarithms of ratios, or short decimals for differences."""

    parts: int
    ratio: bool

    @classmethod
    def of(cls, pair: Pair) -> _Lattice:
        """The lattice of a pair: at most a fiftieth of the standard error apart, and a thousandth."""
        variances = []
        for k, n in ((pair.successes, pair.draws), (pair.other_successes, pair.other_draws)):
            share = (k + 0.5) / (n + 1)
            variances.append((1 - share) / share / (n + 1) if pair.contrast == "ratio" else share * (1 - share) / (n + 1))
        parts = max(1000, ceil(STEPS / sqrt(sum(variances))))
        power = 10 ** (len(str(parts)) - 1)
        return cls(parts, True) if pair.contrast == "ratio" else cls(next(i * power for i in (1, 2, 5, 10) if i * power >= parts), False)

    def index(self, limit: float) -> int:
        """The last one up to a limit."""
        return floor((log(limit) if self.ratio else limit) * self.parts)

    def limit(self, i: int) -> Fraction:
        """The limit of a number, ratios rounded up to a few more digits than tell neighbours apart."""
        if not self.ratio:
            return Fraction(i, self.parts)
        return _decimal(exp(i / self.parts), len(str(self.parts)) + 2, up=True)


def _decimal(value: float, digits: int, *, up: bool) -> Fraction:
    """Round a float to so many digits."""
    if value <= 0:
        return Fraction(0)
    places = digits - 1 - floor(log10(value))
    scaled = Fraction(value) * Fraction(10) ** places
    return (ceil(scaled) if up else floor(scaled)) / Fraction(10) ** places


def _range(pair: Pair, limit: float, box: Box) -> tuple[float, float]:
    """Means of the second cell that are in the null and in the box, as far as the first cell's ends say."""
    (low, high), (other_low, other_high) = box
    first, last = (pair.inverse(mean, limit) for mean in (low, high))
    return max(other_low, first, pair.inverse(0.0, limit)), min(other_high, last)


def _looks_excluded(pair: Pair, limit: float, level: Fraction, box: Box) -> bool:
    """Whether the staircase is unlikely at some means of the null."""
    start, end = _range(pair, limit, box)
    if start >= end:
        return pair.inverse(box[0][0], limit) < end
    means = np.linspace(sqrt(start), sqrt(end), GUESSES) ** 2
    weights = np.zeros((GUESSES, len(pair.first.outcomes) + 1))
    np.cumsum(pair.first.laws(pair.float_mean(means, limit)), axis=1, out=weights[:, 1:])
    found = (pair.second.laws(means) * weights[:, pair.columns]).sum(axis=1)
    return bool(found.max() <= float(level * (1 - GUARD)))


def _digits(pair: Pair) -> int:
    """Of a knot: so many that its last one is a small part of a standard error."""
    return max(6, 3 + len(str(max(pair.draws, pair.other_draws) - 1)))


def _point(pair: Pair, limit: Fraction, box: Box) -> tuple[Fraction, ...] | None:
    """The lower end of the second mean, if what goes with it is beyond the upper end of the first."""
    (_, high), (low, _) = box
    knot = _decimal(low * (1 - 1e-9), _digits(pair), up=False)
    return (knot,) if float(pair.mean(knot, limit)) >= min(high * (1 + 1e-9), 1.0) else None


def _ladder(pair: Pair, limit: Fraction, level: Fraction, box: Box) -> tuple[Fraction, ...] | None:
    """Rising knots, each as far from the one before as the level allows; nothing if there are too many."""
    start, stop = _range(pair, float(limit), box)
    if start >= stop:
        return None
    goal = float(level * (1 - GUARD)) * (1 - MARGIN)
    digits = _digits(pair)
    end = min(_decimal(stop * (1 + 1e-9), digits, up=True), Fraction(1))
    knots = [_decimal(start * (1 - 1e-9), digits, up=False)]
    weights = np.zeros(len(pair.first.outcomes) + 1)
    while knots[-1] < end:
        law = pair.first.laws(np.array([float(pair.mean(knots[-1], limit))]))[0]
        np.cumsum(law, out=weights[1:])
        further = _furthest(pair.second, weights[pair.columns], float(knots[-1]), float(end), goal)
        knot = end if further >= float(end) else _decimal(further, digits, up=False)
        if knot <= knots[-1] or len(knots) > MAX_KNOTS:
            return None
        knots.append(knot)
    return tuple(knots)


def _furthest(cell: _Cell, weights: Floats, start: float, end: float, goal: float) -> float:
    """A mean, from `start` to `end`, at which the expected weight is at most a goal, and not much less; 0 if there is none."""

    def expected(mean: float) -> tuple[float, float]:
        law = cell.laws(np.array([mean]))[0] * weights
        total = float(law.sum())
        return total, float(law @ cell.outcomes) / total - cell.draws * mean if total > 0 else 0.0

    if expected(end)[0] <= goal:
        return end
    mean = start or 1e-3 / cell.draws
    low, high, room = 0.0, end, 0.0
    for _ in range(40):  # Newton's steps for the logarithm, by the logarithm of odds; halves where they leave the bracket
        total, slope = expected(mean)
        excess = log(goal / total) if total > 0 else inf
        if excess < 0:
            high = mean
        else:
            low, room = mean, room or excess
            if excess < room / 50:
                break
        if not low:
            return 0.0
        odds = mean / (1 - mean) * exp(min(excess / slope, 30.0)) if slope > 0 else inf
        mean = odds / (1 + odds) if low < odds / (1 + odds) < high else (low + high) / 2
    return low


def proves(pair: Pair, limit: Fraction, level: Fraction, knots: Sequence[Fraction]) -> bool:
    """Decide in integers whether knots prove that a limit is excluded at a level.

    Parameters
    ----------
    pair : Pair
        The cells.
    limit : Fraction
        Of the ratio or difference.
    level : Fraction
        Probability of error.
    knots : sequence of Fraction
        In [0, 1], rising.

    Returns
    -------
    bool
        False does not say that the limit is not excluded.
    """
    share = level * GUARD / 4
    others = [_law(pair.other_draws, q) for q in knots]
    ends = [_law(pair.draws, pair.mean(q, limit)) for q in knots]
    below = others[0].at_least(pair.other_successes, share)
    above = ends[-1].at_most(pair.successes, share)
    past = pair.mean(knots[-1], limit) == 1
    if len(knots) == 1:
        return (below and (above or past)) or (knots[0] == 0 and above)
    if not (below or ends[0].at_least(pair.successes, share) or knots[0] == 0 or pair.mean(knots[0], limit) == 0):
        return False
    if not (above or past or others[-1].at_most(pair.other_successes, share) or knots[-1] == 1):
        return False
    goal = level - level * GUARD
    return all(_weight(pair, law, other) <= goal * law.total * other.total for law, other in zip(ends, others[1:], strict=False))


@dataclass(frozen=True)
class _Law:
    """A binomial law: terms around the mode, sums of all terms before and after them, all rounded up; and the sum of all, rounded down."""

    draws: int
    start: int
    terms: tuple[int, ...]
    before: int
    after: int
    total: int

    @cached_property
    def tails(self) -> list[int]:
        """For each term the sum of it and of all that follow, then the sum of those after."""
        return [*accumulate(reversed(self.terms), initial=self.after)][::-1]

    def tail(self, least: int) -> int:
        """All from an outcome on."""
        at = least - self.start
        if at < 0:
            return self.tails[0] + self.before
        return 0 if least > self.draws else self.tails[min(at, len(self.terms))]

    def at_least(self, outcome: int, share: Fraction) -> bool:
        """Whether outcomes so great have at most a share."""
        return self.tail(outcome) <= share * self.total

    def at_most(self, outcome: int, share: Fraction) -> bool:
        """Whether outcomes so small have at most a share."""
        end = outcome + 1 - self.start
        return self.before + sum(self.terms[: max(0, end)]) + (self.after if end > len(self.terms) else 0) <= share * self.total


def _law(draws: int, mean: Fraction) -> _Law:
    """A binomial law by the quotients of successive terms, which fall from the mode outwards.

    A rounding adds less than a unit, and quotients up to 1 magnify none: a term is too great by less than its distance from the mode. When
    it is no greater than that distance it is the last, and a geometric series bounds the rest.
    """
    if not 0 < mean < 1:
        return _Law(draws, draws if mean else 0, (ONE,), 0, 0, ONE)
    yes, no = mean.numerator, mean.denominator - mean.numerator
    mode = (draws + 1) * yes // mean.denominator
    above, after = _side(draws - mode, mode, yes, no)
    below, before = _side(mode, draws - mode, no, yes)
    excess = sum(len(side) * (len(side) + 1) // 2 for side in (above, below))
    return _Law(draws, mode - len(below), (*reversed(below), ONE, *above), before, after, ONE + sum(above) + sum(below) - excess)


def _side(left: int, done: int, up: int, down: int) -> tuple[list[int], int]:
    """Terms on one side of the mode, of which there are `left`, and a bound of the sum of those that are not listed."""
    term, terms = ONE, list[int]()
    while left and term > len(terms):
        done += 1
        term = -(-term * left * up // (done * down))
        left -= 1
        terms.append(term)
    above, below = left * up, (done + 1) * down
    return terms, -(-term * above // (below - above)) if left else 0


def _weight(pair: Pair, law: _Law, other: _Law) -> int:
    """The staircase's part of the product of two laws, not yet divided by their totals."""
    stairs, start = pair.staircase, pair.first.start
    everything = other.tail(0)
    outside = law.before + law.after + sum(law.terms[: max(0, start - law.start)])
    inside = zip(law.terms[max(0, start - law.start) :], chain(stairs[max(0, law.start - start) :], repeat(stairs[-1])), strict=False)
    return outside * everything + sum(term * other.tail(stair) for term, stair in inside)
