"""Several releases of the same value with fresh randomness: exactly while that is cheap, else bounded from above."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from math import inf, lcm

from fairaudit.arguments import answered
from fairaudit.exact.rationals import Number, at_least
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.releases import check_releases
from fairaudit.privacy.columns import Budget, Column, TooManyColumns, merged_columns, powered_columns
from fairaudit.privacy.currencies import Enclosure
from fairaudit.privacy.epsilon_delta import epsilon_enclosure, exp_epsilon, exp_epsilon_below
from fairaudit.privacy.pairs import PairLaw, hockey_stick
from fairaudit.privacy.trade_offs import TradeOff, lower_hull, undominated, worst_pair_laws
from fairaudit.words import brief

MAX_POWER_WORK = 100_000_000
"""Products of columns, times the bits of their numbers, up to which powers are formed exactly."""

GRID = 4_096
"""Points over which the losses of a composition are spread: their spacing is what the bound on δ gives away."""

MASS_BITS = 96
"""Masses are rounded up to these binary digits: 16 more than the tails that are dropped."""

TAIL_BITS = 80
"""Tails of mass up to 2^-80 are moved to the safe side: a δ below 10^-24 is of no use to anybody."""


@brief
@dataclass(frozen=True, repr=False)
class Composition:
    """Several releases of the same value, each with fresh randomness.

    Attributes
    ----------
    releases : int
        How many.
    exp_epsilon : Fraction or inf
        e^ε of them together, exact.
    epsilon : tuple of Decimal
        Enclosure of ε.
    exact : bool
        Whether `delta` is the least δ; otherwise it is an upper bound.
    laws : tuple of PairLaw
        Ordered pairs for n releases, of which the greatest δ counts. If not exact they only serve to bound δ from above: their p are
        rounded up and their q down, and need not sum to the denominator.

    Examples
    --------
    >>> import fairaudit as fa
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> found = fa.compose(coin, 2)
    >>> found.exp_epsilon, found.delta(3), found.exact
    (Fraction(9, 1), Fraction(3, 8), True)
    """

    releases: int
    exp_epsilon: Fraction | float
    epsilon: Enclosure
    exact: bool
    laws: tuple[PairLaw, ...] = field(repr=False)

    @answered
    def delta(self, exp_epsilon: Number) -> Fraction:
        """δ at a rational e^ε ≥ 1: the least one if `exact`, else an upper bound."""
        k = at_least("exp_epsilon", exp_epsilon, 1)
        if k >= self.exp_epsilon:
            return Fraction(0)
        return min(Fraction(1), max((hockey_stick(law, k) for law in self.laws), default=Fraction(0)))

    @answered
    def delta_at(self, epsilon: Number) -> Fraction:
        """Return a δ for which the releases are (ε, δ)-differentially private, as `fairaudit.privacy.epsilon_delta.delta_at` does."""
        return self.delta(exp_epsilon_below(epsilon))


@answered
def compose(mechanism: Mechanism, releases: int, *, exact: bool | None = None) -> Composition:
    r"""Privacy of several releases of the same value with fresh randomness.

    Likelihood ratios multiply, so n releases of an ordered pair are the n-fold convolution of its columns; outputs of equal ratio merge.
    Pairs that another pair dominates (its trade-off curve lies nowhere above) are left out: domination survives composition.

    Where the exact convolution would take more than about a second (some hundred releases of randomized response, few of an arbitrary
    table), an upper bound is computed instead. It is sound: with x = q/p the inverse likelihood ratio of an output,

        δ(k) = E max(0, 1 − k·x₁⋯xₙ), outputs drawn independently from P, k ≥ 0.

    In each x the integrand is convex and does not increase, and lies between 0 and 1. So δ cannot fall when x is replaced, independently in
    each release, by a random X with E X ≤ x (Jensen); nor when a mass is rounded up; nor when a product of x is rounded down, in particular
    to 0, which is what is done with tails of mass below 2^-80. X is taken on a geometric grid r^i, r rational: between two neighbours, with
    the greater weight that makes E X ≤ x certain. Masses are integers over 2^96 rounded up, the powers of r rounded down at the end.
    If more than eight undominated pairs are left, their common lower convex hull, which dominates them all, is composed instead.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    releases : int
        How many, at least 1 and at most 100,000.
    exact : bool, optional
        True insists on the exact result, however long it takes; False on the bound. By default the exact result while it is cheap.

    Returns
    -------
    Composition
        e^ε exactly, and δ at any e^ε.

    Raises
    ------
    InputError
        If the number of releases is not accepted, or the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> twice = compose(RandomizedResponse(["a", "b"], keep_probability="0.7"), 2)
    >>> twice.exact, twice.exp_epsilon, twice.delta(1), twice.delta("7/3")
    (True, Fraction(49, 9), Fraction(2, 5), Fraction(7, 25))
    """
    check_releases(releases, 100_000)
    once = exp_epsilon(mechanism)
    together = once**releases if isinstance(once, Fraction) else inf
    epsilon = epsilon_enclosure(_ratio(together))
    laws = undominated(worst_pair_laws(mechanism))
    if exact is not False:
        composed = _exact_powers(laws, releases, inf if exact else MAX_POWER_WORK)
        if composed is not None:
            return Composition(releases, together, epsilon, True, composed)
    if len(laws) > 8:
        laws = (_dominating(lower_hull(laws)),)
    return Composition(releases, together, epsilon, False, tuple(_bounded_power(law, releases) for law in laws))


def _ratio(value: Fraction | float) -> Column:
    return (value.numerator, value.denominator) if isinstance(value, Fraction) else (1, 0)


def _dominating(curve: TradeOff) -> PairLaw:
    """An ordered pair with this trade-off curve."""
    vertices = curve.vertices
    scale = lcm(*(v.denominator for vertex in vertices for v in vertex))
    entries = [(int((1 - vertices[0][1]) * scale), 0)]
    entries += [(int((b1 - b2) * scale), int((a2 - a1) * scale)) for (a1, b1), (a2, b2) in pairwise(vertices)]
    columns = merged_columns(entries)
    return PairLaw(columns, sum(p for p, _ in columns), (), ())


def _exact_powers(laws: Sequence[PairLaw], times: int, budget: float) -> tuple[PairLaw, ...] | None:
    """Each pair's n-fold power, or None if that takes more than the budget."""
    left = Budget(budget)
    try:
        powers = [(law, powered_columns(law.columns, times, left)) for law in laws]
    except TooManyColumns:
        return None
    return tuple(PairLaw(columns, sum(p for p, _ in columns), law.first, law.second) for law, columns in powers)


@dataclass(frozen=True)
class _Losses:
    """Masses over 2^MASS_BITS at the inverse likelihood ratios r^start, r^(start + 1), …, and at 0."""

    start: int
    masses: list[int]
    infinite: int


def _bounded_power(law: PairLaw, times: int) -> PairLaw:
    """Columns whose hockey-stick sum bounds that of n releases from above; see `compose`."""
    if len(law.columns) == 1 and law.columns[0][1]:
        return law
    base, shift, ratio = _on_grid(law, times)
    result = _Losses(0, [1 << MASS_BITS], 0)
    while times:
        if times & 1:
            result = _convolved(result, base)
        times >>= 1
        base = _convolved(base, base) if times else base
    first = max(0, result.start)
    last = result.start + len(result.masses)
    bits = 64 + math.ceil(1.45 * max(0, last) * _grain(ratio, shift))
    columns = [(result.infinite << bits, 0)] if result.infinite else []
    # Ratios P/Q up to 1 count nothing at k ≥ 1. The powers of r are rounded down.
    inverse = (1 << bits) * pow(ratio, first) >> (shift * first)
    tail = []
    for i in range(first, last):
        if mass := result.masses[i - result.start]:
            tail.append((mass << bits, mass * inverse))
        inverse = inverse * ratio >> shift
    columns += reversed(tail)
    return PairLaw(tuple(columns), 1 << (MASS_BITS + bits), law.first, law.second)


def _on_grid(law: PairLaw, times: int) -> tuple[_Losses, int, int]:
    """One release, with each inverse likelihood ratio x replaced by a random one on the grid of expectation at most x.

    The grid is r = ratio/2^shift. With `ceiling[i]` ≥ 2^bits·r^i: the farther neighbour j is the first with ceiling[j] ≤ 2^bits·x, so that
    r^j ≤ x. The nearer, i = j − 1, gets what is left of the mass; E X ≤ x needs at least (1 − x/r^i)/(1 − r) of it at j, and putting
    ceiling[i] for r^i only makes that greater.
    """
    entries = [(p, q) for p, q in law.columns if p]
    losses = [math.log(p) - math.log(q) for p, q in entries if q]
    weights = [p / law.denominator for p, q in entries if q]
    widest = max(max(map(abs, losses), default=1.0), 1e-9)
    mean = sum(w * x for w, x in zip(weights, losses, strict=True))
    deviation = math.sqrt(sum(w * (x - mean) ** 2 for w, x in zip(weights, losses, strict=True)) * times)
    step = max(min(2 * times * widest, 22 * deviation + 2 * widest) / GRID, widest / GRID)
    step = widest / math.ceil(widest / step)  # so that randomized response lies on the grid
    shift = 40 + max(0, math.ceil(-math.log2(step)))
    ratio = min((1 << shift) - 1, max(1, int(Fraction(math.exp(-step)) * (1 << shift))))
    grain = _grain(ratio, shift)
    bits = 128 + math.ceil(1.5 * widest)
    least = math.floor(min(losses, default=0.0) / grain) - 3
    most = math.ceil(max(losses, default=0.0) / grain) + 3
    up = [1 << bits]
    for _ in range(max(0, most) + 3):
        up.append(-(-up[-1] * ratio >> shift))
    down = [1 << bits]
    for _ in range(max(0, -least) + 3):
        down.append(-(-(down[-1] << shift) // ratio))
    start = 1 - len(down)
    ceiling = down[:0:-1] + up
    falling = [-value for value in ceiling]
    masses = [0] * len(ceiling)
    infinite = 0
    for p, q in entries:
        mass = -(-(p << MASS_BITS) // law.denominator)
        far = bisect_left(falling, Fraction(-(q << bits), p)) if q else len(ceiling)
        if far == len(ceiling):
            infinite += mass
            continue
        part = mass
        if far:
            gap = p * ceiling[far - 1] - (q << bits)
            part = min(mass, max(0, -(-mass * gap * (1 << shift) // (p * ceiling[far - 1] * ((1 << shift) - ratio)))))
            masses[far - 1] += mass - part
        masses[far] += part
    return _trimmed(_Losses(start, masses, infinite)), shift, ratio


def _grain(ratio: int, shift: int) -> float:
    """−log(ratio/2^shift), about."""
    return -math.log1p(-(((1 << shift) - ratio) / (1 << shift)))


def _convolved(one: _Losses, other: _Losses) -> _Losses:
    """Product of two independent releases: both lists of masses packed into one integer each, so that one product convolves them."""
    slot = (2 * MASS_BITS + 16 + max(len(one.masses), len(other.masses)).bit_length()) // 8 + 1

    def packed(masses: Sequence[int]) -> int:
        return int.from_bytes(b"".join(mass.to_bytes(slot, "little") for mass in masses), "little")

    size = len(one.masses) + len(other.masses) - 1
    data = (packed(one.masses) * packed(other.masses)).to_bytes(slot * (size + 1), "little")
    masses = [-(-int.from_bytes(data[i * slot : (i + 1) * slot], "little") >> MASS_BITS) for i in range(size)]
    infinite = one.infinite * (sum(other.masses) + other.infinite) + sum(one.masses) * other.infinite
    return _trimmed(_Losses(one.start + other.start, masses, -(-infinite >> MASS_BITS)))


def _trimmed(losses: _Losses) -> _Losses:
    """Round the inverse likelihood ratios of tails of little mass down: at the end to 0, at the start to the next that stays."""
    little = 1 << (MASS_BITS - TAIL_BITS)
    masses, infinite = losses.masses, losses.infinite
    end, dropped = len(masses), 0
    while end > 1 and dropped + masses[end - 1] <= little:
        end -= 1
        dropped += masses[end]
    first, moved = 0, 0
    while first < end - 1 and moved + masses[first] <= little:
        moved += masses[first]
        first += 1
    kept = masses[first:end]
    kept[0] += moved
    return _Losses(losses.start + first, kept, infinite + dropped)
