"""Trade-off curves and privacy profiles, exactly, and the Gaussian privacy that a curve implies."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import inf, lcm
from statistics import NormalDist

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number, at_least, option_value
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.columns import Column, joined_columns
from fairaudit.privacy.currencies import GDP
from fairaudit.privacy.pairs import MAX_KINDS, PairLaw, factor_kinds, pair_law, pair_laws, release_budget
from fairaudit.words import brief

FEW_KINDS = 1_000
"""Kinds of ordered pairs that are all looked at."""


@brief
@dataclass(frozen=True, repr=False)
class TradeOff:
    """A trade-off curve: the least false-negative rate of any test of two inputs at a given false-positive rate.

    Attributes
    ----------
    vertices : tuple of (Fraction, Fraction)
        (false-positive rate α, false-negative rate β), α rising from 0 to 1; the curve is convex and linear between them.

    Examples
    --------
    >>> import fairaudit as fa
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> fa.trade_off(coin).vertices
    ((Fraction(0, 1), Fraction(1, 1)), (Fraction(1, 4), Fraction(1, 4)), (Fraction(1, 1), Fraction(0, 1)))
    """

    vertices: tuple[tuple[Fraction, Fraction], ...]

    def beta(self, alpha: Number) -> Fraction:
        """Return the least false-negative rate at a false-positive rate from 0 to 1, exact.

        Raises
        ------
        InputError
            If `alpha` is not a number from 0 to 1.

        Examples
        --------
        >>> from fairaudit.model.mechanism import RandomizedResponse
        >>> trade_off(RandomizedResponse(["a", "b"], keep_probability="0.7")).beta("0.1")
        Fraction(23, 30)
        """
        at = Fraction(*option_value(alpha))
        if not 0 <= at <= 1:
            raise InputError(f"alpha is {shown(alpha)}; a false-positive rate from 0 to 1 is accepted")
        return interpolated(self.vertices, at)

    def profile(self) -> Profile:
        """The privacy profile of a symmetric curve, exact, as `fairaudit.privacy.trade_offs.profile` says."""
        edges = [((b1 - b2) / (a2 - a1), a1, b1) for (a1, b1), (a2, b2) in pairwise(self.vertices)]
        found = [(k, 1 - b - k * a) for k, a, b in edges if k > 1]
        return Profile(((Fraction(1), max(1 - b - a for a, b in self.vertices)), *reversed(found)))

    def gdp(self) -> GDP:
        """The least μ with f ≥ G_μ, not certified, as `fairaudit.privacy.trade_offs.gdp` says."""
        if self.vertices[0][1] < 1 or self.vertices[-2][1] == 0:
            return GDP(inf)
        mu = max((_upper_quantile(a) + _upper_quantile(b) for a, b in self.vertices[1:-1]), default=0.0)
        return GDP(mu * (1 + 1e-9) + 1e-12 if mu > 0 else 0.0)


@brief
@dataclass(frozen=True, repr=False)
class Profile:
    """The privacy profile: the least δ as a function of k = e^ε ≥ 1.

    Attributes
    ----------
    vertices : tuple of (Fraction, Fraction)
        (k, δ), k rising from 1; the profile is convex, linear between vertices and constant after the last.

    Examples
    --------
    >>> import fairaudit as fa
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> fa.trade_off(coin).profile().delta(2)
    Fraction(1, 4)
    """

    vertices: tuple[tuple[Fraction, Fraction], ...]

    def delta(self, exp_epsilon: Number) -> Fraction:
        """δ at a rational e^ε ≥ 1, exact."""
        k = at_least("exp_epsilon", exp_epsilon, 1)
        return self.vertices[-1][1] if k >= self.vertices[-1][0] else interpolated(self.vertices, k)


def pair_trade_off(law: PairLaw) -> TradeOff:
    """Trade-off curve of one ordered pair (Neyman–Pearson): tests of its second input, the null, against its first.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> from fairaudit.privacy.pairs import pair_law
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.7")
    >>> [(str(a), str(b)) for a, b in pair_trade_off(pair_law(coin, "a", "b")).vertices]
    [('0', '1'), ('3/10', '3/10'), ('1', '0')]
    """
    return TradeOff(tuple((Fraction(a, law.denominator), Fraction(b, law.denominator)) for a, b in _corners(law)))


@answered
def trade_off(mechanism: Mechanism) -> TradeOff:
    """Trade-off curve of the filter: the lower convex hull of those of all ordered pairs, hence symmetric.

    It is the greatest f for which the filter is f-DP (Dong, Roth and Su, 2022).

    Parameters
    ----------
    mechanism : Mechanism
        The filter.

    Returns
    -------
    TradeOff
        The curve.

    Raises
    ------
    InputError
        If the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> len(trade_off(RandomizedResponse(["a", "b", "c"], keep_probability="0.7")).vertices)
    4
    """
    return lower_hull(worst_pair_laws(mechanism))


def profile(mechanism: Mechanism) -> Profile:
    """Privacy profile, exact and complete: δ at every e^ε ≥ 1.

    δ(k) = max over α of 1 − f(α) − kα, so its breakpoints are the slopes of the trade-off curve.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> [(str(k), str(d)) for k, d in profile(RandomizedResponse(["a", "b"], keep_probability="0.7")).vertices]
    [('1', '2/5'), ('7/3', '0')]
    """
    return trade_off(mechanism).profile()


def gdp(mechanism: Mechanism) -> GDP:
    """Gaussian differential privacy: the least μ with f ≥ G_μ, in floating point, raised by 1e-9 of itself and 1e-12, not certified.

    G_μ is convex and f linear between its vertices, so it is enough to compare there: μ = max of −Φ⁻¹(α) − Φ⁻¹(β). Infinite where f meets
    an axis before (0, 1) and (1, 0), that is, where supports differ.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Identity, RandomizedResponse
    >>> gdp(Identity(["a", "b"])).mu, round(gdp(RandomizedResponse(["a", "b"], keep_probability="0.7")).mu, 6)
    (inf, 1.048801)
    """
    return trade_off(mechanism).gdp()


def _corners(law: PairLaw) -> list[Column]:
    """Vertices (α, β) of the pair's trade-off curve, over its denominator."""
    alpha, beta = 0, law.denominator
    corners: list[Column] = []
    for p, q in law.columns:
        if q and not corners:
            corners.append((0, beta))
        alpha += q
        beta -= p
        if q:
            corners.append((alpha, beta))
    return corners


def lower_hull(laws: Sequence[PairLaw]) -> TradeOff:
    """Lower convex hull of the trade-off curves of the pairs and of perfect privacy."""
    scale = lcm(*(law.denominator for law in laws))
    lowest: dict[int, int] = {0: scale, scale: 0}
    for law in laws:
        factor = scale // law.denominator
        for alpha, beta in _corners(law):
            a, b = alpha * factor, beta * factor
            if b < lowest.get(a, scale + 1):
                lowest[a] = b
    chain: list[Column] = []
    for a, b in sorted(lowest.items()):
        while len(chain) > 1 and (chain[-1][0] - chain[-2][0]) * (b - chain[-2][1]) <= (chain[-1][1] - chain[-2][1]) * (a - chain[-2][0]):
            chain.pop()
        chain.append((a, b))
    return TradeOff(tuple((Fraction(a, scale), Fraction(b, scale)) for a, b in chain))


def interpolated(vertices: Sequence[tuple[Fraction, Fraction]], at: Fraction) -> Fraction:
    """The value at a point of a piecewise linear curve, exactly."""
    right = bisect_left(vertices, at, key=lambda vertex: vertex[0])
    if vertices[right][0] == at:
        return vertices[right][1]
    (x1, y1), (x2, y2) = vertices[right - 1 : right + 1]
    return y1 + (y2 - y1) * (at - x1) / (x2 - x1)


def _upper_quantile(tail: Fraction) -> float:
    """−Φ⁻¹(tail), a bound from above where the tail is too small for a float."""
    if 2 * tail > 1:
        return -_upper_quantile(1 - tail)
    small = float(tail)
    if small > 1e-300:
        return -NormalDist().inv_cdf(small)
    # 1 − Φ(x) ≤ exp(−x²/2)/2
    return math.sqrt(2 * (math.log(tail.denominator) - math.log(tail.numerator) - math.log(2)))


def undominated(laws: Sequence[PairLaw]) -> tuple[PairLaw, ...]:
    """Pairs whose trade-off curve is not everywhere at or above that of another pair kept."""
    if len(laws) > 200:
        return tuple(laws)
    kept: list[tuple[PairLaw, TradeOff]] = []

    def above(upper: TradeOff, lower: TradeOff) -> bool:
        return all(interpolated(lower.vertices, a) <= b for a, b in upper.vertices)

    for law in laws:
        curve = pair_trade_off(law)
        if not any(above(curve, other) for _, other in kept):
            kept = [(one, other) for one, other in kept if not above(other, curve)]
            kept.append((law, curve))
    return tuple(law for law, _ in kept)


def worst_pair_laws(mechanism: Mechanism, few: int = FEW_KINDS, releases: int = 1) -> tuple[PairLaw, ...]:
    """Ordered pairs of rows among which every worst case is: greatest δ, lowest trade-off curve, greatest divergence.

    All pairs where they are of few kinds. Otherwise those that no other dominates, factor by factor: a pair (P, Q) whose trade-off curve is
    nowhere below that of (P', Q') is what some channel makes of it (Blackwell), and beside any independent pair the same channel makes
    (P⊗R, Q⊗S) of (P'⊗R, Q'⊗S). So a product of tables is not enumerated: of a factor with three rows often two of seven kinds are left.
    Several releases are such a product, and so are two candidates that are exchanged: P⊗Q against Q⊗P.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    few : int
        How many kinds are few.
    releases : int
        How often the filter releases the same value, as for `pair_laws`.

    Raises
    ------
    InputError
        If the filter still has too many kinds of ordered pairs, or the releases too many different likelihood ratios.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Product, RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b", "c"], keep_probability="0.5")
    >>> both = Product({"one": coin, "two": coin})
    >>> len(pair_laws(both)), [(law.first, law.second) for law in worst_pair_laws(both, few=0)]
    (2, [(('a', 'a'), ('b', 'b'))])
    """
    kinds = [factor_kinds(factor)[0] for factor in mechanism.factors]
    if math.prod(map(len, kinds)) <= few:
        return pair_laws(mechanism, releases)
    found: tuple[PairLaw, ...] = (PairLaw(((1, 1),), 1, (), ()),)
    for factor, pairs in zip(mechanism.factors, kinds, strict=True):
        own = [PairLaw(columns, sum(p for p, _ in columns), factor.inputs[i], factor.inputs[j]) for columns, (i, j) in pairs.items()]
        worst = undominated([law for law in own if law.first != law.second] or own)
        if len(found) * len(worst) > MAX_KINDS:
            raise InputError(f"the filter has more than {MAX_KINDS} kinds of ordered pairs; use fewer or simpler factors")
        joint: dict[tuple[Column, ...], PairLaw] = {}
        for law in found:
            for more in worst:
                columns = joined_columns(law.columns, more.columns)
                first, second = (*law.first, *more.first), (*law.second, *more.second)
                joint.setdefault(columns, PairLaw(columns, sum(p for p, _ in columns), first, second))
        found = undominated(list(joint.values()))
    different = [law for law in found if law.first != law.second]
    if releases == 1:
        return tuple(different)
    budget = release_budget(releases)
    return tuple(pair_law(mechanism, law.first, law.second, releases, budget) for law in different)
