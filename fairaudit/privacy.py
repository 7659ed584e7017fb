"""Exact privacy of a filter: pure ε, privacy profile, trade-off curve, Rényi, zCDP, GDP and composition, per ordered pair and worst.

Everything is local privacy: any two values of the alphabet are adjacent, and pairs are ordered, P = M(·|a) against Q = M(·|a').
What is rational is returned as a `Fraction`; what is irrational as an enclosure, two decimals rounded outward. Only `gdp` is not certified.
Units are nats. An e^ε is passed as `exp_epsilon`, because then δ is rational; an ε goes to `delta_at`.

Definitions: hockey-stick divergence and privacy profile, Balle, Barthe and Gaboardi (2018); trade-off functions and GDP, Dong, Roth and Su
(2022); Rényi DP, Mironov (2017); zCDP, Bun and Steinke (2016).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import MAX_EMAX, MIN_EMIN, ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from heapq import heappop, heappush, nlargest
from itertools import pairwise
from math import gcd, inf, lcm, prod
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fairaudit.columns import Label
from fairaudit.exact import InputError, at_least, exp_enclosure, log_enclosure, option_value, shown
from fairaudit.mechanism import Factor, Mechanism

__all__ = [
    "GDP",
    "ApproxDP",
    "AttributeDP",
    "Composition",
    "PairLaw",
    "PairPrivacy",
    "PairTable",
    "Profile",
    "PureDP",
    "RenyiDP",
    "TradeOff",
    "approx_dp",
    "compose",
    "delta",
    "delta_at",
    "exp_epsilon",
    "gdp",
    "hockey_stick",
    "pair_law",
    "pair_laws",
    "pair_trade_off",
    "per_pair",
    "power",
    "profile",
    "pure_dp",
    "renyi",
    "trade_off",
    "zCDP",
    "zcdp",
]

Column = tuple[int, int]
Pair = tuple[Label, Label]
Enclosure = tuple[Decimal, Decimal]
Positions = tuple[int, ...]

EXP_BITS = 64
MAX_KINDS = 1_000_000
MAX_TABLE = 2**28
MAX_POWER_WORK = 100_000_000
GRID = 4_096
MASS_BITS = 96
TAIL_BITS = 80
ZCDP_GAP = Fraction(1, 1000)
ZCDP_EVALUATIONS = 300
SHOWN_DIGITS = 20


@dataclass(frozen=True)
class AttributeDP:
    """Pure differential privacy when one attribute changes and the others stay: never the figure of the whole tuple.

    Attributes
    ----------
    column : str
        Name of the column, or its position from 1 if the filter's columns have no names.
    exp_epsilon : Fraction or inf
        e^ε, exact.
    epsilon : tuple of Decimal
        Enclosure of ε, in nats.
    pair : pair of inputs, or None
        Two inputs of the filter's factor that differ in this attribute only and attain e^ε; None if no two do.
    """

    column: str
    exp_epsilon: Fraction | float
    epsilon: Enclosure
    pair: Pair | None


@dataclass(frozen=True)
class PureDP:
    """Pure differential privacy of the whole tuple: any two inputs of the filter are adjacent.

    Attributes
    ----------
    exp_epsilon : Fraction or inf
        e^ε, exact: the greatest likelihood ratio over all ordered pairs; inf if supports differ.
    epsilon : tuple of Decimal
        Enclosure of ε, in nats.
    pair : pair of inputs, or None
        An ordered pair of different inputs that attains it; None if there is only one input.
    attributes : tuple of AttributeDP
        The same when only one attribute changes.
    """

    exp_epsilon: Fraction | float
    epsilon: Enclosure
    pair: Pair | None
    attributes: tuple[AttributeDP, ...]


@dataclass(frozen=True)
class ApproxDP:
    """(ε, δ)-differential privacy at a rational e^ε.

    Attributes
    ----------
    exp_epsilon : Fraction
        e^ε ≥ 1.
    delta : Fraction
        The least δ, exact; the total variation distance at e^ε = 1.
    pair : pair of inputs, or None
        An ordered pair of different inputs that attains it.
    """

    exp_epsilon: Fraction
    delta: Fraction
    pair: Pair | None


@dataclass(frozen=True)
class RenyiDP:
    """Rényi differential privacy.

    Attributes
    ----------
    order : Fraction
        The order, greater than 1.
    epsilon : tuple of Decimal
        Enclosure of the greatest Rényi divergence over all ordered pairs, in nats.
    """

    order: Fraction
    epsilon: Enclosure


@dataclass(frozen=True)
class zCDP:  # noqa: N801
    """Zero-concentrated differential privacy.

    Attributes
    ----------
    rho : tuple of Decimal
        Enclosure of the least ρ with Rényi divergence at most ρ·order at every order above 1.
    """

    rho: Enclosure


@dataclass(frozen=True)
class GDP:
    """Gaussian differential privacy.

    Attributes
    ----------
    mu : float
        The least μ whose Gaussian trade-off curve lies below the filter's, computed in floating point and not certified.
    """

    mu: float


@dataclass(frozen=True)
class PairLaw:
    """An ordered pair of rows of a filter, reduced to its likelihood ratios.

    Outputs with the same ratio p/q are one column: that keeps every hockey-stick, trade-off and Rényi quantity of the pair.

    Attributes
    ----------
    columns : tuple of (int, int)
        ``(p, q)`` over `denominator`, strictly falling in p/q, with q = 0 first.
    denominator : int
        Common denominator; the p and the q each sum to it.
    first, second : tuple of str
        The first ordered pair of different inputs found with this form.
    """

    columns: tuple[Column, ...]
    denominator: int
    first: Label
    second: Label


def pair_laws(mechanism: Mechanism) -> tuple[PairLaw, ...]:
    """List the distinct ordered pairs of rows over all pairs of different inputs.

    A product of three randomized responses has seven, however many inputs it has.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> pair_laws(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"))[0].columns
    ((2, 1), (1, 1), (1, 2))
    """
    return tuple(
        PairLaw(columns, sum(p for p, _ in columns), _input(mechanism, first), _input(mechanism, second))
        for columns, (first, second) in _kinds(mechanism).examples.items()
        if first != second
    )


def joint_ratios(mechanism: Mechanism) -> int:
    """Bound the likelihood ratios of the different pairs of rows, which bounds with multipliers go through; long numbers count more.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> joint_ratios(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"))
    4
    """
    count, bits = 1, 0
    for factor in mechanism.factors:
        count *= 1 + sum(len(pair.columns) for pair in pair_laws(Mechanism((factor,))))
        bits += factor.denominator.bit_length()
    return count * (1 + (bits >> 8)) ** 2


def hockey_stick(pair: PairLaw, k: Fraction) -> Fraction:
    """H_k(P, Q) = Σ max(0, P − kQ), exact: the δ of this ordered pair at e^ε = k ≥ 0.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> hockey_stick(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], Fraction(1))
    Fraction(2, 5)
    """
    top, bottom = k.numerator, k.denominator
    return Fraction(sum(max(0, p * bottom - top * q) for p, q in pair.columns), bottom * pair.denominator)


def power(pair: PairLaw, level: Fraction) -> tuple[Fraction, Fraction]:
    """Neyman–Pearson: the greatest E_P φ over tests φ with E_Q φ ≤ level, and the likelihood ratio k at which the best test is cut.

    The two satisfy power = k·level + H_k(P, Q), and no other k gives less: that k is the certificate of theorem T3.

    Parameters
    ----------
    pair : PairLaw
        The ordered pair.
    level : Fraction
        In (0, 1].

    Returns
    -------
    tuple of Fraction
        1 − f(level), where f is the trade-off function of the ordered pair, and k.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> power(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], Fraction(1, 10))
    (Fraction(7, 30), Fraction(7, 3))
    """
    spent, gained = 0, 0
    target = level * pair.denominator
    for p, q in pair.columns:
        if q and spent + q >= target:
            ratio = Fraction(p, q)
            return (gained + ratio * (target - spent)) / pair.denominator, ratio
        spent += q
        gained += p
    return Fraction(1), Fraction(0)


def pair_law(mechanism: Mechanism, first: Any, second: Any) -> PairLaw:
    """Reduce one ordered pair of inputs to its likelihood ratios.

    Raises
    ------
    InputError
        If the filter does not know one of them.

    Examples
    --------
    >>> from fairaudit.mechanism import Constant
    >>> pair_law(Constant(["a", "b"]), "a", "b").columns
    ((1, 1),)
    """
    places = zip(mechanism.factors, mechanism.locate(first), mechanism.locate(second), strict=True)
    columns: tuple[Column, ...] = ((1, 1),)
    for factor, i, j in places:
        columns = _joined(columns, _merged(zip(factor.rows[i], factor.rows[j], strict=True)))
    ends = [_input(mechanism, mechanism.locate(value)) for value in (first, second)]
    return PairLaw(columns, sum(p for p, _ in columns), ends[0], ends[1])


def pure_dp(mechanism: Mechanism) -> PureDP:
    """Pure differential privacy, exact: of the whole tuple, and when one attribute changes.

    The greatest ratio of an output's probabilities is that of the column's greatest entry to its least; over the factors of a product the
    ratios multiply, that is, ε add up.

    Examples
    --------
    >>> from fairaudit.mechanism import Product, RandomizedResponse
    >>> coin = RandomizedResponse(["f", "m"], keep_probability="0.7")
    >>> found = pure_dp(Product({"sex": coin, "age": coin}))
    >>> found.exp_epsilon, found.pair, [a.exp_epsilon for a in found.attributes]
    (Fraction(49, 9), (('f', 'f'), ('m', 'm')), [Fraction(7, 3), Fraction(7, 3)])
    """
    attributes: list[AttributeDP] = []
    top, bottom = 1, 1
    first: list[str] = []
    second: list[str] = []
    for factor in mechanism.factors:
        ratio, i, j = _extreme(factor.rows, range(len(factor.inputs)))
        top, bottom = (top * ratio[0], bottom * ratio[1]) if bottom and ratio[1] else (1, 0)
        first += factor.inputs[i]
        second += factor.inputs[j]
        for part in range(factor.width):
            number = len(attributes)
            column = mechanism.columns[number] if number < len(mechanism.columns) else str(number + 1)
            attributes.append(_attribute(factor, part, column))
    pair = (tuple(first), tuple(second))
    return PureDP(_fraction(top, bottom), _log((top, bottom)), pair if pair[0] != pair[1] else _any_pair(mechanism), tuple(attributes))


def exp_epsilon(mechanism: Mechanism) -> Fraction | float:
    """e^ε of pure differential privacy of the whole tuple, exact; inf if the supports of two rows differ.

    Examples
    --------
    >>> from fairaudit.mechanism import Identity, RandomizedResponse
    >>> exp_epsilon(RandomizedResponse(["a", "b"], keep_probability="0.7")), exp_epsilon(Identity(["a", "b"]))
    (Fraction(7, 3), inf)
    """
    return pure_dp(mechanism).exp_epsilon


def approx_dp(mechanism: Mechanism, exp_epsilon: Any) -> ApproxDP:
    """The least δ of (ε, δ)-differential privacy at a rational e^ε, with an ordered pair that attains it.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : number or str
        e^ε ≥ 1, such as ``"7/3"``.

    Raises
    ------
    InputError
        If e^ε is not a number of at least 1, or the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> approx_dp(RandomizedResponse(["a", "b"], keep_probability="0.7"), 1)
    ApproxDP(exp_epsilon=Fraction(1, 1), delta=Fraction(2, 5), pair=(('a',), ('b',)))
    """
    k = at_least("exp_epsilon", exp_epsilon, 1)
    if _dense(mechanism):
        rows, bottoms = _multiplied_out(mechanism)
        top, bottom, at = 0, 1, None
        for i, (tops, scale) in enumerate(zip(_dense_hockey(rows, bottoms, k), bottoms, strict=True)):
            for j, (value, other) in enumerate(zip(tops, bottoms, strict=True)):
                if i != j and (at is None or value * bottom > top * scale * other):
                    top, bottom, at = value, scale * other, (i, j)
        pair = (mechanism.inputs[at[0]], mechanism.inputs[at[1]]) if at else None
        return ApproxDP(k, Fraction(top, bottom * k.denominator), pair)
    worst = max(pair_laws(mechanism), key=lambda law: hockey_stick(law, k), default=None)
    if worst is None:
        return ApproxDP(k, Fraction(0), None)
    return ApproxDP(k, hockey_stick(worst, k), (worst.first, worst.second))


def delta(mechanism: Mechanism, exp_epsilon: Any) -> Fraction:
    """The least δ at a rational e^ε ≥ 1, exact: the greatest Σ max(0, P − e^ε·Q) over all ordered pairs.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.7")
    >>> delta(coin, 1), delta(coin, 2), delta(coin, "7/3")
    (Fraction(2, 5), Fraction(1, 10), Fraction(0, 1))
    """
    return approx_dp(mechanism, exp_epsilon).delta


def delta_at(mechanism: Mechanism, epsilon: Any) -> Fraction:
    """Return a δ for which the filter is (ε, δ)-differentially private; above the least one by less than 2^-60.

    e^ε is irrational unless ε = 0; it is rounded down, and δ(·) does not increase and falls by at most the step in e^ε.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    epsilon : number or str
        ε from 0 to 10,000, in nats.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> float(delta_at(RandomizedResponse(["a", "b"], keep_probability="0.7"), "0.5"))
    0.20538361878996156
    """
    return delta(mechanism, _exp_below(epsilon))


@dataclass(frozen=True)
class TradeOff:
    """A trade-off curve: the least false-negative rate of any test of two inputs at a given false-positive rate.

    Attributes
    ----------
    vertices : tuple of (Fraction, Fraction)
        (false-positive rate α, false-negative rate β), α rising from 0 to 1; the curve is convex and linear between them.
    """

    vertices: tuple[tuple[Fraction, Fraction], ...]

    def beta(self, alpha: Any) -> Fraction:
        """Return the least false-negative rate at a false-positive rate from 0 to 1, exact.

        Raises
        ------
        InputError
            If `alpha` is not a number from 0 to 1.

        Examples
        --------
        >>> from fairaudit.mechanism import RandomizedResponse
        >>> trade_off(RandomizedResponse(["a", "b"], keep_probability="0.7")).beta("0.1")
        Fraction(23, 30)
        """
        at = Fraction(*option_value(alpha))
        if not 0 <= at <= 1:
            raise InputError(f"alpha is {shown(alpha)}; a false-positive rate from 0 to 1 is accepted")
        return _interpolated(self.vertices, at)

    def profile(self) -> Profile:
        """The privacy profile of a symmetric curve, exact, as `fairaudit.privacy.profile` says."""
        edges = [((b1 - b2) / (a2 - a1), a1, b1) for (a1, b1), (a2, b2) in pairwise(self.vertices)]
        found = [(k, 1 - b - k * a) for k, a, b in edges if k > 1]
        return Profile(((Fraction(1), max(1 - b - a for a, b in self.vertices)), *reversed(found)))

    def gdp(self) -> GDP:
        """The least μ with f ≥ G_μ, not certified, as `fairaudit.privacy.gdp` says."""
        if self.vertices[0][1] < 1 or self.vertices[-2][1] == 0:
            return GDP(inf)
        mu = max((_upper_quantile(a) + _upper_quantile(b) for a, b in self.vertices[1:-1]), default=0.0)
        return GDP(mu * (1 + 1e-9) + 1e-12 if mu > 0 else 0.0)


@dataclass(frozen=True)
class Profile:
    """The privacy profile: the least δ as a function of k = e^ε ≥ 1.

    Attributes
    ----------
    vertices : tuple of (Fraction, Fraction)
        (k, δ), k rising from 1; the profile is convex, linear between vertices and constant after the last.
    """

    vertices: tuple[tuple[Fraction, Fraction], ...]

    def delta(self, exp_epsilon: Any) -> Fraction:
        """δ at a rational e^ε ≥ 1, exact."""
        k = at_least("exp_epsilon", exp_epsilon, 1)
        return self.vertices[-1][1] if k >= self.vertices[-1][0] else _interpolated(self.vertices, k)


def pair_trade_off(law: PairLaw) -> TradeOff:
    """Trade-off curve of one ordered pair (Neyman–Pearson): tests of its second input, the null, against its first.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.7")
    >>> [(str(a), str(b)) for a, b in pair_trade_off(pair_law(coin, "a", "b")).vertices]
    [('0', '1'), ('3/10', '3/10'), ('1', '0')]
    """
    return TradeOff(tuple((Fraction(a, law.denominator), Fraction(b, law.denominator)) for a, b in _corners(law)))


def trade_off(mechanism: Mechanism) -> TradeOff:
    """Trade-off curve of the filter: the lower convex hull of those of all ordered pairs, hence symmetric.

    It is the greatest f for which the filter is f-DP (Dong, Roth and Su, 2022).

    Raises
    ------
    InputError
        If the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> len(trade_off(RandomizedResponse(["a", "b", "c"], keep_probability="0.7")).vertices)
    4
    """
    return _hull(pair_laws(mechanism))


def profile(mechanism: Mechanism) -> Profile:
    """Privacy profile, exact and complete: δ at every e^ε ≥ 1.

    δ(k) = max over α of 1 − f(α) − kα, so its breakpoints are the slopes of the trade-off curve.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> [(str(k), str(d)) for k, d in profile(RandomizedResponse(["a", "b"], keep_probability="0.7")).vertices]
    [('1', '2/5'), ('7/3', '0')]
    """
    return trade_off(mechanism).profile()


class PairPrivacy(NamedTuple):
    """Privacy of one ordered pair of inputs: ``exp_epsilon`` is the greatest P/Q, ``delta`` Σ max(0, P − kQ)."""

    first: Label
    second: Label
    exp_epsilon: Fraction | float
    delta: Fraction


@dataclass(frozen=True, eq=False)
class PairTable:
    """Exact e^ε and δ of every ordered pair of inputs; iterating gives a `PairPrivacy` for each pair of different inputs.

    Attributes
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : Fraction
        The k at which δ is taken.
    """

    mechanism: Mechanism
    exp_epsilon: Fraction
    _values: list[tuple[Fraction | float, Fraction]] = field(repr=False)
    _kinds_of: Callable[[int], list[int]] = field(repr=False)
    _examples: list[tuple[int, int]] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of ordered pairs of different inputs."""
        size = prod(len(f.inputs) for f in self.mechanism.factors)
        return size * (size - 1)

    def __iter__(self) -> Iterator[PairPrivacy]:
        """Go through the pairs, the second input varying fastest."""
        inputs, values = self.mechanism.inputs, self._values
        for i, first in enumerate(inputs):
            for j, kind in enumerate(self._kinds_of(i)):
                if i != j:
                    yield PairPrivacy(first, inputs[j], *values[kind])

    def at(self, first: Any, second: Any) -> PairPrivacy:
        """Look one ordered pair up."""
        i, j = (_flat(self.mechanism, self.mechanism.locate(value)) for value in (first, second))
        return PairPrivacy(self.mechanism.inputs[i], self.mechanism.inputs[j], *self._values[self._kinds_of(i)[j]])

    def top(self, count: int) -> list[PairPrivacy]:
        """List the most distinguishable ordered pairs, by e^ε and then δ, one for each kind of pair."""
        inputs = self.mechanism.inputs
        worst = nlargest(count, ((value, -n) for n, value in enumerate(self._values) if self._examples[n][0] != self._examples[n][1]))
        return [PairPrivacy(inputs[self._examples[-n][0]], inputs[self._examples[-n][1]], *value) for value, n in worst]


def per_pair(mechanism: Mechanism, exp_epsilon: Any = 1) -> PairTable:
    """Exact e^ε and δ of every ordered pair of inputs.

    Products are evaluated once for each kind of pair, other tables in vectorised integer arithmetic.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : number or str
        The e^ε ≥ 1 at which δ is taken; 1 gives the total variation distance.

    Raises
    ------
    InputError
        If e^ε is not a number of at least 1, or the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> table = per_pair(RandomizedResponse(["a", "b"], keep_probability="0.7"), 2)
    >>> len(table), table.at("b", "a").exp_epsilon, [pair.delta for pair in table]
    (2, Fraction(7, 3), [Fraction(1, 10), Fraction(1, 10)])
    """
    k = at_least("exp_epsilon", exp_epsilon, 1)
    if _dense(mechanism):
        rows, bottoms = _multiplied_out(mechanism)
        size = len(rows)
        ratios = _dense_ratios(rows, bottoms)
        values: list[tuple[Fraction | float, Fraction]] = []
        for i, tops in enumerate(_dense_hockey(rows, bottoms, k)):
            scale = bottoms[i] * k.denominator
            values += [(_fraction(*ratios[i * size + j]), Fraction(top, scale * bottoms[j])) for j, top in enumerate(tops)]
        return PairTable(
            mechanism, k, values, lambda i: list(range(i * size, (i + 1) * size)), [divmod(n, size) for n in range(size * size)]
        )
    kinds = _kinds(mechanism)
    evaluated: list[tuple[Fraction | float, Fraction]] = []
    for columns in kinds.examples:
        law = PairLaw(columns, sum(p for p, _ in columns), (), ())
        evaluated.append((_fraction(*columns[0]), hockey_stick(law, k)))
    examples = [(_flat(mechanism, first), _flat(mechanism, second)) for first, second in kinds.examples.values()]
    return PairTable(mechanism, k, evaluated, lambda i: _kinds_of_row(mechanism, kinds, i), examples)


def renyi(mechanism: Mechanism, order: Any) -> RenyiDP:
    """Rényi differential privacy: the greatest divergence log(Σ P^order·Q^(1−order))/(order − 1) over all ordered pairs, enclosed.

    The divergences of a product's factors add up. Candidates for the greatest are found in floating point with an error bound, and
    evaluated in decimals rounded outward; powers of integer order are exact before that rounding.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    order : number or str
        The order, greater than 1.

    Raises
    ------
    InputError
        If the order is not a number greater than 1 and at most 10^6.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> low, high = renyi(RandomizedResponse(["a", "b"], keep_probability="0.7"), 2).epsilon
    >>> float(low), high - low < Decimal("1e-18")
    (0.5663954749208014, True)
    """
    at = Fraction(*option_value(order))
    if not 1 < at <= 10**6:
        raise InputError(f"the order is {shown(order)}; an order greater than 1, at most 1000000, is accepted")
    tables = _tables(mechanism)
    if tables is None:
        return RenyiDP(at, (Decimal("inf"), Decimal("inf")))
    low, high = _moment(tables, at)
    return RenyiDP(at, _outward(low / (at - 1), high / (at - 1)))


def zcdp(mechanism: Mechanism) -> zCDP:
    """Zero-concentrated differential privacy: ρ = sup of D_order/order over all orders above 1, enclosed to a relative gap of 10^-3.

    With D_order the greatest Rényi divergence over ordered pairs, K(order) = (order − 1)·D_order is a maximum of convex functions (sums of
    them over factors) with K(1) = 0, hence convex, and D does not decrease. So on an interval of orders K lies below its chord, whose
    quotient by order·(order − 1) has its maximum in closed form; up to the first order evaluated D/order is at most D there; beyond the
    last it is at most ε/order. The interval with the greatest bound is halved until that bound is close to the best evaluated order.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> low, high = zcdp(RandomizedResponse(["a", "b"], keep_probability="0.7")).rho
    >>> low <= high <= low * Decimal("1.001"), round(float(high), 2)
    (True, 0.34)
    """
    tables = _tables(mechanism)
    if tables is None:
        return zCDP((Decimal("inf"), Decimal("inf")))
    limit = pure_dp(mechanism)
    if limit.exp_epsilon == 1:
        return zCDP((Decimal(0), Decimal(0)))
    last = Fraction(limit.epsilon[1])
    known: dict[Fraction, tuple[Fraction, Fraction]] = {}
    best = Fraction(0)

    def evaluate(order: Fraction) -> None:
        nonlocal best
        if order not in known:
            known[order] = _moment(tables, order)
        best = max(best, known[order][0] / (order * (order - 1)))

    def bound(left: Fraction, right: Fraction) -> Fraction:
        if not right:
            return last / left
        return _chord_bound(left, right, known[left][1], known[right][1]) if left > 1 else known[right][1] / (right - 1)

    start = Fraction(65, 64)
    evaluate(start)
    # Orders from `left` to `right`; a right end of 0 stands for infinity.
    intervals: list[tuple[Fraction, Fraction, Fraction]] = []
    for left, right in ((Fraction(1), start), (start, Fraction(0))):
        heappush(intervals, (-bound(left, right), left, right))
    while -intervals[0][0] > best * (1 + ZCDP_GAP) and len(known) < ZCDP_EVALUATIONS:
        _, left, right = heappop(intervals)
        middle = _between(left, right)
        evaluate(middle)
        for ends in ((left, middle), (middle, right)):
            heappush(intervals, (-bound(*ends), *ends))
    return zCDP(_outward(best, max(best, -intervals[0][0])))


def gdp(mechanism: Mechanism) -> GDP:
    """Gaussian differential privacy: the least μ with f ≥ G_μ, in floating point, raised by 1e-9 of itself and 1e-12, not certified.

    G_μ is convex and f linear between its vertices, so it is enough to compare there: μ = max of −Φ⁻¹(α) − Φ⁻¹(β). Infinite where f meets
    an axis before (0, 1) and (1, 0), that is, where supports differ.

    Examples
    --------
    >>> from fairaudit.mechanism import Identity, RandomizedResponse
    >>> gdp(Identity(["a", "b"])).mu, round(gdp(RandomizedResponse(["a", "b"], keep_probability="0.7")).mu, 6)
    (inf, 1.048801)
    """
    return trade_off(mechanism).gdp()


@dataclass(frozen=True)
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
    """

    releases: int
    exp_epsilon: Fraction | float
    epsilon: Enclosure
    exact: bool
    laws: tuple[PairLaw, ...] = field(repr=False)

    def delta(self, exp_epsilon: Any) -> Fraction:
        """δ at a rational e^ε ≥ 1: the least one if `exact`, else an upper bound."""
        k = at_least("exp_epsilon", exp_epsilon, 1)
        if k >= self.exp_epsilon:
            return Fraction(0)
        return min(Fraction(1), max((hockey_stick(law, k) for law in self.laws), default=Fraction(0)))

    def delta_at(self, epsilon: Any) -> Fraction:
        """Return a δ for which the releases are (ε, δ)-differentially private, as `fairaudit.privacy.delta_at` does."""
        return self.delta(_exp_below(epsilon))


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
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> twice = compose(RandomizedResponse(["a", "b"], keep_probability="0.7"), 2)
    >>> twice.exact, twice.exp_epsilon, twice.delta(1), twice.delta("7/3")
    (True, Fraction(49, 9), Fraction(2, 5), Fraction(7, 25))
    """
    if isinstance(releases, bool) or not isinstance(releases, int) or not 1 <= releases <= 100_000:
        raise InputError(f"the number of releases is {shown(releases)}; a whole number from 1 to 100000 is accepted")
    once = exp_epsilon(mechanism)
    together = once**releases if isinstance(once, Fraction) else inf
    epsilon = _log(_ratio(together))
    laws = _undominated(pair_laws(mechanism))
    if exact is not False:
        composed = _exact_powers(laws, releases, inf if exact else MAX_POWER_WORK)
        if composed is not None:
            return Composition(releases, together, epsilon, True, composed)
    if len(laws) > 8:
        laws = (_dominating(_hull(laws)),)
    return Composition(releases, together, epsilon, False, tuple(_bounded_power(law, releases) for law in laws))


@dataclass(frozen=True)
class _Kinds:
    """The kinds of ordered pairs of inputs, pairs of equal inputs included.

    Attributes
    ----------
    examples : dict
        Columns of the kind to the positions of an ordered pair; different inputs if there are such. The order numbers the kinds.
    steps : list
        For each factor: the kind of each pair of its inputs (None: kind 0 for equal inputs and the last kind for others), and the kind that
        the pair of the factors before it becomes with that.
    """

    examples: dict[tuple[Column, ...], tuple[Positions, Positions]]
    steps: list[tuple[NDArray[np.int64] | None, NDArray[np.int64]]]


def _kinds(mechanism: Mechanism) -> _Kinds:
    found: dict[tuple[Column, ...], tuple[Positions, Positions]] = {((1, 1),): ((), ())}
    steps = []
    for factor in mechanism.factors:
        classes, of_pair = _factor_kinds(factor)
        if len(found) * len(classes) > MAX_KINDS:
            raise InputError(f"the filter has more than {MAX_KINDS} kinds of ordered pairs; use fewer or simpler factors")
        numbers: dict[tuple[Column, ...], int] = {}
        joint: dict[tuple[Column, ...], tuple[Positions, Positions]] = {}
        steps.append((of_pair, np.zeros((len(found), len(classes)), dtype=np.int64)))
        for old, (columns, (first, second)) in enumerate(found.items()):
            for new, (more, (i, j)) in enumerate(classes.items()):
                both = _joined(columns, more)
                pair = ((*first, i), (*second, j))
                known = joint.setdefault(both, pair)
                if known[0] == known[1] and pair[0] != pair[1]:
                    joint[both] = pair
                steps[-1][1][old, new] = numbers.setdefault(both, len(numbers))
        found = joint
    return _Kinds(found, steps)


def _kinds_of_row(mechanism: Mechanism, kinds: _Kinds, row: int) -> list[int]:
    """Kinds of the pairs of one input with every input."""
    sizes = [len(f.inputs) for f in mechanism.factors]
    result = np.zeros(1, dtype=np.int64)
    for size, place, (of_pair, step) in zip(sizes, np.unravel_index(row, sizes), kinds.steps, strict=True):
        if of_pair is None:
            these = np.full(size, step.shape[1] - 1)
            these[place] = 0
        else:
            these = of_pair[place]
        result = step[result[:, None], these[None, :]].ravel()
    listed: list[int] = result.tolist()
    return listed


def _factor_kinds(factor: Factor) -> tuple[dict[tuple[Column, ...], tuple[int, int]], NDArray[np.int64] | None]:
    """Kinds of the ordered pairs of rows of a factor with an example of each, and the kind of each pair."""
    size = len(factor.inputs)
    alike = _alike(factor)
    pairs = [(0, 0), (0, 1)] if alike else [(i, j) for i in range(size) for j in range(size)]
    found: dict[tuple[Column, ...], tuple[int, int]] = {}
    numbers: dict[tuple[Column, ...], int] = {}
    listed = []
    for i, j in pairs:
        columns = _merged(zip(factor.rows[i], factor.rows[j], strict=True))
        known = found.setdefault(columns, (i, j))
        if known[0] == known[1] and i != j:
            found[columns] = (i, j)
        listed.append(numbers.setdefault(columns, len(numbers)))
    return found, None if alike else np.array(listed, dtype=np.int64).reshape(size, size)


def _alike(factor: Factor) -> bool:
    """Whether all ordered pairs of different rows have the same form, as in randomized response."""
    return len(factor.inputs) > 1 and factor.mixing is not None and len(set(factor.mixing[1])) == 1


def _merged(entries: Iterable[Column]) -> tuple[Column, ...]:
    """Join the columns of equal likelihood ratio, in falling order of the ratio, over the least common denominator."""
    sums: dict[Column, int] = {}
    for p, q in entries:
        common = gcd(p, q)
        if common:
            ratio = (p // common, q // common)
            sums[ratio] = sums.get(ratio, 0) + common
    # Two ratios with denominators below 2^b differ by more than 2^-2b, so their first 2b binary places differ.
    places = 2 * max(q for _, q in sums).bit_length()
    listed = sorted(sums, key=lambda ratio: (ratio[1] > 0, -((ratio[0] << places) // ratio[1]) if ratio[1] else 0))
    common = gcd(*sums.values())
    return tuple((p * (sums[p, q] // common), q * (sums[p, q] // common)) for p, q in listed)


def _joined(columns: tuple[Column, ...], more: tuple[Column, ...]) -> tuple[Column, ...]:
    """Columns of two independent pairs together."""
    if len(more) == 1:
        return columns
    return more if len(columns) == 1 else _merged((p * r, q * s) for p, q in columns for r, s in more)


def _input(mechanism: Mechanism, places: Sequence[int]) -> Label:
    return sum((f.inputs[i] for f, i in zip(mechanism.factors, places, strict=True)), ())


def _flat(mechanism: Mechanism, places: Sequence[int]) -> int:
    """Position among all inputs."""
    at = 0
    for factor, i in zip(mechanism.factors, places, strict=True):
        at = at * len(factor.inputs) + i
    return at


def _any_pair(mechanism: Mechanism) -> Pair | None:
    at = next((n for n, f in enumerate(mechanism.factors) if len(f.inputs) > 1), None)
    if at is None:
        return None
    first = [0] * len(mechanism.factors)
    second = [int(n == at) for n in range(len(first))]
    return _input(mechanism, first), _input(mechanism, second)


def _extreme(rows: Sequence[Sequence[int]], among: Iterable[int]) -> tuple[Column, int, int]:
    """The greatest ratio of two entries of one column, ``(1, 0)`` if it is infinite, and the rows of the two."""
    chosen = list(among)
    best, at = (1, 1), (chosen[0], chosen[0])
    for column in zip(*(rows[i] for i in chosen), strict=True):
        high, low = max(column), min(column)
        if high * best[1] > best[0] * low:
            best, at = (high, low), (chosen[column.index(high)], chosen[column.index(low)])
            if not low:
                return (1, 0), *at
    return best, *at


def _attribute(factor: Factor, part: int, column: str) -> AttributeDP:
    """The greatest ratio over the inputs that differ in one part only."""
    groups: dict[Label, list[int]] = {}
    for i, label in enumerate(factor.inputs):
        groups.setdefault(label[:part] + label[part + 1 :], []).append(i)
    best: tuple[Column, int, int] | None = None
    for among in groups.values():
        if len(among) > 1:
            found = _extreme(factor.rows, among)
            if found[1] == found[2]:
                found = (found[0], among[0], among[1])
            if best is None or found[0][0] * best[0][1] > best[0][0] * found[0][1]:
                best = found
    if best is None:
        return AttributeDP(column, Fraction(1), _log((1, 1)), None)
    ratio, i, j = best
    return AttributeDP(column, _fraction(*ratio), _log(ratio), (factor.inputs[i], factor.inputs[j]))


def _fraction(top: int, bottom: int) -> Fraction | float:
    return Fraction(top, bottom) if bottom else inf


def _ratio(value: Fraction | float) -> Column:
    return (value.numerator, value.denominator) if isinstance(value, Fraction) else (1, 0)


def _log(ratio: Column) -> Enclosure:
    low, high = log_enclosure(ratio)
    return Decimal(low), Decimal(high)


def _exp_below(epsilon: Any) -> Fraction:
    """e^ε rounded down, by less than 2^-60."""
    try:
        top, bottom = option_value(epsilon)
    except InputError as error:
        raise InputError(f"epsilon: {error}") from None
    if top < 0:
        raise InputError(f"epsilon is {shown(epsilon)}; it must be at least 0")
    return max(Fraction(1), Fraction(exp_enclosure((top, bottom), EXP_BITS)[0], 1 << EXP_BITS))


def _dense(mechanism: Mechanism) -> bool:
    """Whether the table multiplied out has hardly more entries than there are kinds of pairs to look at."""
    kinds = prod(min(2, len(f.inputs)) if _alike(f) else len(f.inputs) * (len(f.inputs) - 1) + 1 for f in mechanism.factors)
    size = prod(len(f.inputs) for f in mechanism.factors)
    return 4 * kinds > size * size and size * size * prod(len(f.outputs) for f in mechanism.factors) <= MAX_TABLE


def _multiplied_out(mechanism: Mechanism) -> tuple[NDArray[Any], list[int]]:
    """The whole table as Python integers, each row in lowest terms, and what each row sums to."""
    table: NDArray[Any] = np.array([[1]], dtype=object)
    for factor in mechanism.factors:
        table = np.kron(table, np.array([[v // gcd(*row) for v in row] for row in factor.rows], dtype=object))
    return table, [sum(row) for row in table.tolist()]


def _dense_hockey(rows: NDArray[Any], bottoms: list[int], k: Fraction) -> Iterator[list[int]]:
    """Σ max(0, P − kQ) of all ordered pairs of rows i and j, row by row, as integers over ``k.denominator·bottoms[i]·bottoms[j]``."""
    dtype = np.int64 if max(bottoms) ** 2 * max(k.numerator, k.denominator) < 2**62 else object
    table, scales = rows.astype(dtype), np.array(bottoms, dtype=dtype)[:, None]
    for row, bottom in zip(table, bottoms, strict=True):
        gaps = (row * k.denominator)[None, :] * scales - table * (k.numerator * bottom)
        sums: list[int] = np.maximum(gaps, 0).sum(axis=1).tolist()
        yield sums


def _dense_ratios(rows: NDArray[Any], bottoms: list[int]) -> list[Column]:
    """The greatest P/Q of all ordered pairs of rows, a zero denominator for infinity."""
    table = rows.astype(np.int64 if max(bottoms) < 2**31 else object)
    top = np.zeros((len(rows), len(rows)), dtype=table.dtype)
    low = np.ones_like(top)
    for column in table.T:
        p, q = np.broadcast_to(column[:, None], top.shape), np.broadcast_to(column[None, :], top.shape)
        better = p * low > top * q
        top, low = np.where(better, p, top), np.where(better, q, low)
    pairs = zip(top.tolist(), low.tolist(), bottoms, strict=True)
    return [(p * other, q * own) for tops, lows, own in pairs for p, q, other in zip(tops, lows, bottoms, strict=True)]


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


def _hull(laws: Sequence[PairLaw]) -> TradeOff:
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


def _interpolated(vertices: Sequence[tuple[Fraction, Fraction]], at: Fraction) -> Fraction:
    right = bisect_left(vertices, at, key=lambda vertex: vertex[0])
    if vertices[right][0] == at:
        return vertices[right][1]
    (x1, y1), (x2, y2) = vertices[right - 1 : right + 1]
    return y1 + (y2 - y1) * (at - x1) / (x2 - x1)


@dataclass(frozen=True)
class _Table:
    """The rows of a factor that Rényi divergences need, with equal rows dropped and proportional columns joined.

    Attributes
    ----------
    rows : list of tuple of int
        Positive entries over `denominator`.
    denominator : int
        What each row sums to.
    logs : dict of int to (Decimal, Decimal)
        Enclosure of the logarithm of each entry.
    digits : int
        Precision.
    """

    rows: list[tuple[int, ...]]
    denominator: int
    logs: dict[int, Enclosure]
    digits: int


def _contexts(digits: int) -> tuple[Context, Context]:
    """Arithmetic that rounds down, and arithmetic that rounds up."""
    low, high = (Context(prec=digits, rounding=way, Emin=MIN_EMIN, Emax=MAX_EMAX) for way in (ROUND_FLOOR, ROUND_CEILING))
    return low, high


def _tables(mechanism: Mechanism) -> list[_Table] | None:
    """Each factor's table, or None if the supports of two rows differ."""
    tables = []
    for factor in mechanism.factors:
        rows = list(dict.fromkeys(factor.rows[:2] if _alike(factor) else factor.rows))
        columns: dict[tuple[int, ...], int] = {}
        for column in zip(*rows, strict=True):
            common = gcd(*column)
            if common:
                reduced = tuple(v // common for v in column)
                columns[reduced] = columns.get(reduced, 0) + common
        if any(0 in column for column in columns):
            return None
        if len(rows) == 1:
            continue
        rows = list(zip(*(tuple(v * times for v in column) for column, times in columns.items()), strict=True))
        digits = 32 + 2 * min(20, factor.denominator.bit_length() * 3 // 10)
        low, high = _contexts(digits)
        logs = {v: (low.next_minus(low.ln(v)), high.next_plus(high.ln(v))) for v in {v for row in rows for v in row}}
        tables.append(_Table(rows, factor.denominator, logs, digits))
    return tables


def _moment(tables: Sequence[_Table], order: Fraction) -> tuple[Fraction, Fraction]:
    """Enclosure of (order − 1)·D_order: over the factors, the sum of the greatest log Σ P^order·Q^(1−order)."""
    low, high = Fraction(0), Fraction(0)
    for table in tables:
        below, above = _table_moment(table, order)
        low += below
        high += above
    return low, high


def _table_moment(table: _Table, order: Fraction) -> tuple[Fraction, Fraction]:
    down, up = _contexts(table.digits)
    powers = {v: _power(v, table.logs[v], order, table.digits) for v in table.logs}
    # v^(1 − order) = v/v^order
    inverses = {v: (down.divide(v, high), up.divide(v, low)) for v, (low, high) in powers.items()}
    greatest: tuple[Decimal, Decimal] = (Decimal(table.denominator), Decimal(table.denominator))
    for i, j in _candidates(table, powers, inverses, down):
        low = high = Decimal(0)
        for p, q in zip(table.rows[i], table.rows[j], strict=True):
            low = down.fma(powers[p][0], inverses[q][0], low)
            high = up.fma(powers[p][1], inverses[q][1], high)
        greatest = (max(greatest[0], low), max(greatest[1], high))
    # The sum is at least the denominator (Jensen), so the logarithm is at least 0.
    at_least = down.ln(max(Decimal(1), down.divide(greatest[0], table.denominator)))
    at_most = up.ln(max(Decimal(1), up.divide(greatest[1], table.denominator)))
    return max(Fraction(0), Fraction(down.next_minus(at_least))), Fraction(up.next_plus(at_most))


def _power(value: int, log: Enclosure, order: Fraction, digits: int) -> Enclosure:
    """Enclosure of value^order for an integer value of at least 1."""
    down, up = _contexts(digits)
    if order.denominator == 1 and order <= 64:
        exact = Decimal(value**order.numerator)
        return down.plus(exact), up.plus(exact)
    low = down.exp(down.divide(down.multiply(max(Decimal(0), log[0]), order.numerator), order.denominator))
    high = up.exp(up.divide(up.multiply(log[1], order.numerator), order.denominator))
    return max(Decimal(1), down.next_minus(low)), up.next_plus(high)


def _candidates(table: _Table, powers: dict[int, Enclosure], inverses: dict[int, Enclosure], down: Context) -> list[tuple[int, int]]:
    """Ordered pairs of rows whose sum may be the greatest.

    Each sum is a dot product of positive floats, right to a relative (columns + 8) units of 2^-53; underflow is far below that, since
    the sums are at least the denominator. Columns are scaled so that the powers are at most 1. If the inverse powers overflow, all pairs
    are candidates.
    """
    size = len(table.rows)
    everything = [(i, j) for i in range(size) for j in range(size) if i != j]
    if size < 4:
        return everything
    greatest = [powers[max(column)][0] for column in zip(*table.rows, strict=True)]
    first = np.array([[float(down.divide(powers[v][0], g)) for v, g in zip(row, greatest, strict=True)] for row in table.rows])
    second = np.array([[float(down.multiply(inverses[v][0], g)) for v, g in zip(row, greatest, strict=True)] for row in table.rows])
    if not second.max() * len(greatest) < 1e290 or table.denominator < 1 or second.min() < 1e-280:
        return everything
    sums = first @ second.T
    np.fill_diagonal(sums, 0.0)
    margin = 4 * (len(greatest) + 16) * 2.0**-53
    return [(int(i), int(j)) for i, j in np.argwhere(sums >= sums.max() * (1 - margin))]


def _outward(low: Fraction, high: Fraction) -> Enclosure:
    """Decimals of 20 digits around two rationals."""
    down, up = _contexts(SHOWN_DIGITS)
    return down.divide(low.numerator, low.denominator), up.divide(high.numerator, high.denominator)


def _between(left: Fraction, right: Fraction) -> Fraction:
    """An order between two others, in the geometric middle of their distances from 1; `right` 0 stands for infinity."""
    if not right:
        return 1 + 4 * (left - 1)
    if left == 1:
        return 1 + (right - 1) / 8
    x, y = left - 1, right - 1
    middle = Fraction(math.sqrt(float(x) * float(y))).limit_denominator(max(64, 64 * math.ceil(1 / x)))
    return 1 + (middle if x < middle < y else (x + y) / 2)


def _chord_bound(left: Fraction, right: Fraction, at_left: Fraction, at_right: Fraction) -> Fraction:
    """Upper bound of ℓ(t)/(t(t − 1)) for left ≤ t ≤ right, 1 < left, where ℓ is the line through the two values, both positive.

    With slope s and root z of the line, the derivative vanishes where t² − 2zt + z = 0. For z > 1 the quotient rises from z to
    t* = z + √(z² − z), where it is s/(2t* − 1), and then falls. If there is no such t* between the ends, an end is the greatest.
    """
    ends = max(at_left / (left * (left - 1)), at_right / (right * (right - 1)))
    slope = (at_right - at_left) / (right - left)
    if slope <= 0:
        return ends
    root = left - at_left / slope
    inside = root * root - root
    if root <= 1:
        return ends
    scale = 1 << 64
    base = math.isqrt(inside.numerator * scale * scale // inside.denominator)
    if root + Fraction(base + 1, scale) < left or root + Fraction(base, scale) > right:
        return ends
    return max(ends, slope / (2 * root + Fraction(2 * base, scale) - 1))


def _upper_quantile(tail: Fraction) -> float:
    """−Φ⁻¹(tail), a bound from above where the tail is too small for a float."""
    if 2 * tail > 1:
        return -_upper_quantile(1 - tail)
    small = float(tail)
    if small > 1e-300:
        return -NormalDist().inv_cdf(small)
    # 1 − Φ(x) ≤ exp(−x²/2)/2
    return math.sqrt(2 * (math.log(tail.denominator) - math.log(tail.numerator) - math.log(2)))


def _undominated(laws: Sequence[PairLaw]) -> tuple[PairLaw, ...]:
    """Pairs whose trade-off curve is not everywhere at or above that of another pair kept."""
    if len(laws) > 200:
        return tuple(laws)
    kept: list[tuple[PairLaw, TradeOff]] = []

    def above(upper: TradeOff, lower: TradeOff) -> bool:
        return all(_interpolated(lower.vertices, a) <= b for a, b in upper.vertices)

    for law in laws:
        curve = pair_trade_off(law)
        if not any(above(curve, other) for _, other in kept):
            kept = [(one, other) for one, other in kept if not above(other, curve)]
            kept.append((law, curve))
    return tuple(law for law, _ in kept)


def _dominating(curve: TradeOff) -> PairLaw:
    """An ordered pair with this trade-off curve."""
    vertices = curve.vertices
    scale = lcm(*(v.denominator for vertex in vertices for v in vertex))
    entries = [(int((1 - vertices[0][1]) * scale), 0)]
    entries += [(int((b1 - b2) * scale), int((a2 - a1) * scale)) for (a1, b1), (a2, b2) in pairwise(vertices)]
    columns = _merged(entries)
    return PairLaw(columns, sum(p for p, _ in columns), (), ())


def _exact_powers(laws: Sequence[PairLaw], times: int, budget: float) -> tuple[PairLaw, ...] | None:
    """Each pair's n-fold power, or None if that takes more than the budget: products of columns times bits."""
    found = []
    for law in laws:
        bits = law.denominator.bit_length()
        # With two different ratios, t releases have at least t + 1 columns.
        if len(law.columns) > 1 and times**3 * bits * len(law.columns) > 3 * budget:
            return None
        columns: tuple[Column, ...] = law.columns
        for step in range(2, times + 1):
            budget -= len(columns) * len(law.columns) * (step * bits + 64)
            if budget < 0:
                return None
            columns = _joined(columns, law.columns)
        found.append(PairLaw(columns, sum(p for p, _ in columns), law.first, law.second))
    return tuple(found)


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
        tail.append((result.masses[i - result.start] << bits, result.masses[i - result.start] * inverse))
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
