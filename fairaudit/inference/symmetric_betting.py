"""Contrasts of two independent cells, averaged over all ways to pair their draws.

Let x and y be draws of the cells i and j, scaled to [0, 1]. Pair m draws of one with m of the other: if E(x) is at least r·E(y), the
product of 1 + λ·(r·y − x) over the pairs has at most the mean 1. So has its average over all pairings, which needs no seed:

    E_λ(r) = Σ_k C(m,k)·(λr)^k·ē_k(y)·ē_(m−k)(1 − λx),

where ē_k is the mean, over all sets of k draws, of their product. The bets are those of `paired_betting` for a contrast of the spread
m²·(1/n_x + 1/n_y), and m is the number of draws of the smaller cell, at most 1,000. Against E(x) ≥ E(y) + d it is
Σ_k C(m,k)·ē_k(λy/2)·ē_(m−k)(1 + λ(d − x)/2).

Exactly, an elementary symmetric mean is a probability: let each draw v be taken independently, with odds s·v; then the number that is
taken is k with probability s^k·C(n,k)·ē_k(v) / Π(1 + s·v). The law of that number is a convolution of binomial laws, one for each value,
which integers hold rounded down, with 128 bits after the point; a tilt s puts its bulk where the terms of the sum are greatest. Any s is
valid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from math import comb, inf, lgamma, log

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import Extended
from fairaudit.inference.betting import ValueCounts, wealth_reaches
from fairaudit.inference.paired_betting import LEAST, Claim, bets, least_limit, log_mean, mean_below
from fairaudit.inference.rounding import BITS, Number, number_below, power_below, product_below, sum_below

MANY_DRAWS = 10_000  # of two cells together, where sums in integers by the values take less time than those in floats by the draws

MOST_PAIRS = 1_000  # in one pairing: more take longer to check, and gain nothing but for rare events

Tally = Sequence[tuple[Fraction, int]]
"""Positive values, and how often each was drawn."""

Law = tuple[int, list[int]]
"""The least number that is taken with some probability, and the probabilities of it and the next ones in units of 2^-128, rounded down."""


def pairing(higher: ValueCounts, lower: ValueCounts) -> tuple[int, list[Fraction]]:
    """The number of pairs in one pairing, and the bets.

    Examples
    --------
    >>> cell = ValueCounts({Fraction(0): 40, Fraction(1): 60})
    >>> pairs, bets = pairing(cell, cell)
    >>> pairs, [str(bet) for bet in bets]
    (100, ['15/16', '2/3', '15/32', '1/3'])
    """
    pairs = min(higher.draws, lower.draws, MOST_PAIRS)
    return pairs, bets(pairs**2 * (Fraction(1, higher.draws) + Fraction(1, lower.draws)) if pairs else Fraction(0))


def log_wealth(higher: ValueCounts, lower: ValueCounts, claim: Claim = "ratio") -> Callable[[float], float]:
    """Logarithm of what the bets against E(x) ≥ limit·E(y) win, as a function of the limit, in floats: not for conclusions.

    Examples
    --------
    >>> cell = ValueCounts({Fraction(0): 40, Fraction(1): 60})
    >>> won = log_wealth(cell, cell)
    >>> round(won(1.2), 3), round(won(1.5), 3)
    (-0.505, 4.864)
    """
    pairs, made = pairing(higher, lower)
    if not pairs:
        return lambda _: 0.0
    bet = np.array([[float(each)] for each in made])
    (x, nx), (y, ny) = higher.arrays, lower.arrays
    k = np.arange(pairs + 1)
    choices = np.array([lgamma(pairs + 1) - lgamma(i + 1) - lgamma(pairs - i + 1) for i in range(pairs + 1)])
    of_y = choices + _log_means(y[None], ny, pairs)

    def won(limit: float) -> float:
        taken = of_x if claim == "ratio" else _log_means(1 + bet * (limit - x) / 2, nx, pairs)
        scale = bet * limit if claim == "ratio" else bet / 2
        return log_mean(of_y + k * np.log(scale) + taken[:, ::-1]) + log(pairs + 1)

    of_x = _log_means(1 - bet * x, nx, pairs) if claim == "ratio" else of_y
    return won


def _log_means(values: Floats, counts: Floats, most: int) -> Floats:
    """Logarithms of the elementary symmetric means ē_0, …, ē_most of several lists of draws.

    Divided by the power of the mean they are at most 1, while draws are added in rising order; what is too small for a float is left out.
    """
    draws = np.repeat(np.sort(values), counts[np.argsort(values[0])].astype(np.int64), axis=1)
    scale = draws.mean(axis=1, keepdims=True)
    scale[scale == 0] = 1
    found = np.zeros((len(draws), most + 1))
    found[:, 0] = 1
    for n in range(1, draws.shape[1] + 1):
        k = np.arange(1, min(n, most) + 1) / n
        found[:, 1 : len(k) + 1] = (1 - k) * found[:, 1 : len(k) + 1] + k * (draws[:, n - 1, None] / scale) * found[:, : len(k)]
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(found) + np.arange(most + 1) * np.log(scale))


def wealth(higher: ValueCounts, lower: ValueCounts, limit: Fraction, claim: Claim = "ratio") -> Number:
    """Bound from below, in integers, what the bets against E(x) ≥ limit·E(y) won: (m, e) says at least m·2^e.

    It is 1 if one cell has no draws, and 0 where a bet could lose more than there is.
    """
    pairs, made = pairing(higher, lower)
    if limit < LEAST[claim]:
        return 0, 0
    if not pairs:
        return 1, 0
    won = []
    for bet in made:
        xs = [(1 - bet * x if claim == "ratio" else 1 + bet * (limit - x) / 2, n) for x, n in sorted(higher.counts.items())]
        won.append(_contrast(xs, sorted(lower.counts.items()), bet * limit if claim == "ratio" else bet / 2, pairs))
    return mean_below(won)


def is_below(higher: ValueCounts, lower: ValueCounts, limit: Fraction, level: Fraction, claim: Claim = "ratio") -> bool:
    """Whether E(x)/E(y), or E(x) − E(y), is proved to be less than a limit, wrong with at most the probability `level`."""
    return wealth_reaches([wealth(higher, lower, limit, claim)], level)


def upper_end(higher: ValueCounts, lower: ValueCounts, level: Fraction, claim: Claim = "ratio") -> Extended:
    """The least limit below which E(x)/E(y), or E(x) − E(y), is proved to be, rounded up to about seven digits.

    Examples
    --------
    >>> half = Fraction(1, 2)
    >>> cell = ValueCounts({Fraction(0): 5, half: 40, Fraction(1): 5})
    >>> float(upper_end(cell, cell, Fraction(1, 20)))
    1.275479
    """
    many = higher.draws + lower.draws >= MANY_DRAWS + 100 * (len(higher.counts) + len(lower.counts))
    search = partial(_exact_log_wealth, higher, lower, claim) if many else log_wealth(higher, lower, claim)
    return least_limit(search, lambda limit: is_below(higher, lower, limit, level, claim), level, claim)


def _exact_log_wealth(higher: ValueCounts, lower: ValueCounts, claim: Claim, limit: float) -> float:
    mantissa, exponent = wealth(higher, lower, Fraction(limit), claim)
    return log(mantissa) + exponent * log(2) if mantissa else -inf


def _contrast(xs: Tally, ys: Tally, scale: Fraction, pairs: int) -> Number:
    """Σ_k C(m,k)·scale^k·ē_k(y)·ē_(m−k)(x), rounded down."""
    of_x, of_y = sum(n for _, n in xs), sum(n for _, n in ys)
    xs, ys = ([(v, n) for v, n in tally if v and n] for tally in (xs, ys))
    s, t = _tilts(xs, ys, float(scale), pairs, of_x, of_y)
    (first_x, px), (first_y, py) = _law_of_taken(xs, s), _law_of_taken(ys, t)
    first, last = max(first_y, pairs - first_x - len(px) + 1, 0), min(first_y + len(py) - 1, pairs - first_x, pairs)
    if first > last:
        return 0, 0
    factor = number_below(Fraction(comb(pairs, first), comb(of_y, first) * comb(of_x, pairs - first)))
    factors = [(scale / t, first), (1 / s, pairs - first), *((1 + s * v, n) for v, n in xs), *((1 + t * v, n) for v, n in ys)]
    for base, exponent in factors:
        factor = product_below(factor, power_below(number_below(base), exponent))
    terms = []
    for k in range(first, last + 1):
        terms.append(product_below(factor, (py[k - first_y] * px[pairs - k - first_x], -2 * BITS)))
        if k < last:
            factor = product_below(factor, number_below(scale * s * (of_x - pairs + k + 1) / (t * (of_y - k))))
    return sum_below(terms)


def _tilts(xs: Tally, ys: Tally, scale: float, pairs: int, of_x: int, of_y: int) -> tuple[Fraction, Fraction]:
    """Tilts of x and y at which as many draws as the greatest term of the sum has are taken in the mean, nearly."""
    (x, nx), (y, ny) = ((np.array([float(v) for v, _ in tally]), np.array([float(n) for _, n in tally])) for tally in (xs, ys))

    def tilt_of_y(s: float) -> tuple[float, bool]:
        k = max(0.0, pairs - float(nx @ (s * x / (1 + s * x))))
        t = scale * s * (of_x - pairs + k + 1) / (of_y - k + 1)
        return t, bool(ny @ (t * y / (1 + t * y)) >= k)

    low, high = -120 * 32, 120 * 32
    while high - low > 1:
        middle = (low + high) // 2
        if tilt_of_y(2 ** (middle / 32))[1]:
            high = middle
        else:
            low = middle
    s = 2 ** (high / 32)
    return _short(s), _short(tilt_of_y(s)[0])


def _short(value: float) -> Fraction:
    """A number of six binary digits near a float."""
    exponent = int(np.frexp(value)[1])
    return Fraction(max(1, round(value * 2.0 ** (6 - exponent)))) * Fraction(2) ** (exponent - 6)


def _law_of_taken(tally: Tally, tilt: Fraction) -> Law:
    """The law of the number of draws that are taken."""
    laws = [_binomial(n, tilt * v) for v, n in tally]
    while len(laws) > 1:
        laws = [*map(_convolved, laws[::2], laws[1::2]), *([laws[-1]] if len(laws) % 2 else [])]
    return laws[0] if laws else (0, [1 << BITS])


def _binomial(n: int, odds: Fraction) -> Law:
    """The law of the number of successes among n draws, from its mode outwards until less than a unit is left."""
    a, b = odds.numerator, odds.denominator
    mode = (n + 1) * a // (a + b)
    top = number_below(Fraction(comb(n, mode)))
    for base, exponent in ((Fraction(a, a + b), mode), (Fraction(b, a + b), n - mode)):
        top = product_below(top, power_below(number_below(base), exponent))
    below, above = [], [top[0] >> -top[1] - BITS if top[1] < -BITS else top[0] << top[1] + BITS]
    k, term = mode, above[0]
    while k > 0 and (term := term * k * b // ((n - k + 1) * a)):
        below.append(term)
        k -= 1
    k, term = mode, above[0]
    while k < n and (term := term * (n - k) * a // ((k + 1) * b)):
        above.append(term)
        k += 1
    return mode - len(below), below[::-1] + above


def _convolved(one: Law, other: Law) -> Law:
    """The law of a sum, by one product of integers that have the probabilities as digits."""
    width = (2 * BITS + max(len(one[1]), len(other[1])).bit_length() + 7) // 8
    a, b = (int.from_bytes(b"".join(p.to_bytes(width, "little") for p in law), "little") for _, law in (one, other))
    length = len(one[1]) + len(other[1]) - 1
    digits = (a * b).to_bytes(width * (length + 1), "little")
    law = [int.from_bytes(digits[i * width : (i + 1) * width], "little") >> BITS for i in range(length)]
    kept = [i for i, p in enumerate(law) if p]
    return one[0] + other[0] + kept[0], law[kept[0] : kept[-1] + 1]
