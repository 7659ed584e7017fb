"""What bets on the contrast of two independent cells have won in the mean over all ways to pair their draws.

With ``m`` pairs, and a bet ``b`` that one mean is less than ``r`` times the other, that is the sum over ``k`` of
``C(m, k) (b r)^k e(k, y) e(m - k, 1 - b x)``, where ``e(k, v)`` is the mean over all sets of ``k`` draws of the product of their values.

If each draw ``v`` is taken with odds ``s v``, just ``k`` are taken with probability ``s^k C(n, k) e(k, v)`` over the product of all
``1 + s v``.  This holds for every ``s``; which one is chosen decides only how few bits suffice.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import comb, isqrt

from .paired_betting import MANTISSA, NOTHING, Wealth, bets_for, mean, power, quotient, reaches, times, total, trimmed
from .rationals import bits_of
from .work import keep, spend

MOST_PAIRS = 1000  # that are made of the draws at once
FINE = 128  # bits after the point in the search of what is only to be known nearly

Tally = Mapping[Fraction, int]  # how often each value was drawn, scaled to [0, 1]
Values = Sequence[tuple[Fraction, int]]
Law = tuple[int, list[int]]  # a first number, and the probabilities of it and of the next ones in units of 2^-MANTISSA, rounded down


def wealth_of(higher: Tally, lower: Tally, limit: Fraction, difference: bool) -> Wealth:
    """Bound from below what bets have won that the first of two means is less than a multiple of the second, or not that much greater."""
    won = [each for each, _ in _won(higher, lower, limit, difference)]
    return mean(won) if won else NOTHING


def proves_below(higher: Tally, lower: Tally, limit: Fraction, level: Fraction, difference: bool = False) -> bool:
    """Decide whether the ratio of the means of two cells, or their difference, is less than a limit at this level.

    No bet loses more than was bet, so that what some of them have won is enough.
    """
    won: list[Wealth] = []
    for each, made in _won(higher, lower, limit, difference):
        won.append(each)
        if reaches(mean([*won, *[NOTHING] * (made - len(won))]), level):
            return True
    return False


def _won(higher: Tally, lower: Tally, limit: Fraction, difference: bool) -> Iterator[tuple[Wealth, int]]:
    """List what the bets have won, the smallest one first, and how many they are."""
    if limit < (-1 if difference else 0) or not all(0 <= value <= 1 for tally in (higher, lower) for value in tally):
        return  # one could lose more than one has
    of_x, of_y = sum(higher.values()), sum(lower.values())
    pairs = min(of_x, of_y, MOST_PAIRS)
    if not pairs:
        yield (1, 0), 1
        return
    y = [(value, n) for value, n in lower.items() if n and value]
    bets = bets_for(pairs**2 * (Fraction(1, of_x) + Fraction(1, of_y)))
    for bet in reversed(bets):
        spend(10 * len(higher), bits_of(limit), bits_of(limit))
        x = [((1 + bet * (limit - value) / 2 if difference else 1 - bet * value), n) for value, n in higher.items() if n]
        yield _sum_of_terms(x, y, bet / 2 if difference else bet * limit, pairs, (of_x, of_y)), len(bets)


def _sum_of_terms(x: Values, y: Values, scale: Fraction, pairs: int, draws: tuple[int, int]) -> Wealth:
    """Add up C(pairs, k) scale^k e(k, y) e(pairs - k, x), rounded down."""
    of_x, of_y = draws
    spend(1_000)
    s, t = _odds(x, y, scale, pairs, draws)
    (least_x, xs), (least_y, ys) = _law(x, s), _law(y, t)
    first, last = max(least_y, pairs - least_x - len(xs) + 1), min(least_y + len(ys) - 1, pairs - least_x)
    if first > last:
        return NOTHING
    _spend_on_product(pairs * (of_x.bit_length() + of_y.bit_length()))
    factor = quotient(comb(pairs, first), comb(of_y, first) * comb(of_x, pairs - first))
    factor = times(factor, times(_power_of(scale / t, first), _power_of(1 / s, pairs - first)))
    for value, n in x:
        factor = times(factor, _power_of(1 + s * value, n))
    for value, n in y:
        factor = times(factor, _power_of(1 + t * value, n))
    step = scale * s / t
    bits = bits_of(step)
    spend(10 * (last - first + 1), bits, bits)
    terms = []
    for k in range(first, last + 1):
        terms.append(times(factor, (ys[k - least_y] * xs[pairs - k - least_x], -2 * MANTISSA)))
        if k < last:
            above = factor[0] * step.numerator * (of_x - pairs + k + 1) << MANTISSA
            factor = trimmed(above // (step.denominator * (of_y - k)), factor[1] - MANTISSA)
    return total(terms)


def _power_of(base: Fraction, exponent: int) -> Wealth:
    spend(10 + 8 * exponent.bit_length(), bits_of(base))
    return power(quotient(base.numerator, base.denominator), exponent)


def _odds(x: Values, y: Values, scale: Fraction, pairs: int, draws: tuple[int, int]) -> tuple[Fraction, Fraction]:
    """Choose s and t such that as many draws are taken from x and y in the mean as in the greatest term, nearly."""
    (of_x, of_y), one = draws, 1 << FINE
    x_fine, y_fine = ([(value.numerator * one // value.denominator, n) for value, n in values] for values in (x, y))
    spend(6 * (len(x) + len(y)), *([max(map(bits_of, (v for v, _ in (*x, *y))), default=0)] * 2))

    def taken(values: Sequence[tuple[int, int]], odds: int) -> int:
        spend(5 * len(values), 0, odds.bit_length())
        return sum(n * ((odds * value << FINE) // (odds * value + (1 << 2 * FINE))) for value, n in values)

    def other(odds: int) -> tuple[int, int]:
        k = max(0, pairs * one - taken(x_fine, odds))
        return k, scale.numerator * odds * ((of_x - pairs + 1) * one + k) // (scale.denominator * ((of_y + 1) * one - k))

    least, most = 0, 32 * 2 * FINE  # of numbers of six bits, from 2^-123 to 2^133
    while least < most:
        middle = (least + most) // 2
        k, odds = other(_sixth(middle))
        least, most = (least, middle) if taken(y_fine, odds) >= k else (middle + 1, most)
    s, t = _sixth(least), max(1, other(_sixth(least))[1])
    t = t >> (excess := max(0, t.bit_length() - 6)) << excess
    return Fraction(s, one), Fraction(t, one)


def _sixth(index: int) -> int:
    """Numbers of six bits, in their order: 32, ..., 63, 64, 66, ..., 126, 128, 132, ..."""
    return 32 + index % 32 << index // 32


def _law(values: Values, odds: Fraction) -> Law:
    """Find how many draws are taken with which probability."""
    laws = [_binomial(n, odds * value) for value, n in values] or [(0, [1 << MANTISSA])]
    while len(laws) > 1:
        ordered = sorted(laws, key=lambda law: len(law[1]))
        laws = [_joined(ordered[i], ordered[i + 1]) if i + 1 < len(ordered) else ordered[i] for i in range(0, len(ordered), 2)]
    return laws[0]


def _binomial(n: int, odds: Fraction) -> Law:
    """Find the probabilities of so many successes among n, as far as they are not less than a unit."""
    a, b = odds.numerator, odds.denominator
    mode = (n + 1) * a // (a + b)
    spend(40 + 4 * n.bit_length() + min(mode, n - mode), bits_of(odds))
    _spend_on_product(min(mode, n - mode) * n.bit_length())
    m, e = times(quotient(comb(n, mode), 1), times(power(quotient(a, a + b), mode), power(quotient(b, a + b), n - mode)))
    sides: list[list[int]] = []
    top = m << e + MANTISSA if e >= -MANTISSA else m >> -e - MANTISSA
    for up, down, most in ((b, a, mode), (a, b, n - mode)):
        # The i-th step away from the mode multiplies by the odds of the step times what is left over what is there.
        side, term, i = [], top, 0
        while i < most:
            if i % 64 == 0:
                spend(8 * min(64, most), MANTISSA, bits_of(odds))
                keep(min(64, most))
            term = term * up * (most - i) // (down * (n - most + i + 1))
            if not term:
                break
            side.append(term)
            i += 1
        sides.append(side)
    return mode - len(sides[0]), [*sides[0][::-1], top, *sides[1]]


def _spend_on_product(bits: int) -> None:
    """Count the steps of a product of two long numbers, which Python multiplies by thirds."""
    words = bits >> 8
    spend(2 * words * isqrt(words))


def _joined(one: Law, other: Law) -> Law:
    """Find the law of the sum of two independent numbers, by a product of integers with the probabilities as their digits."""
    count = len(one[1]) + len(other[1]) - 1
    width = (2 * MANTISSA + count.bit_length() + 7) // 8
    _spend_on_product(8 * width * min(len(one[1]), len(other[1])))
    spend(6 * count + 10)
    keep(count)
    left, right = (int.from_bytes(b"".join(p.to_bytes(width, "little") for p in law), "little") for _, law in (one, other))
    digits = (left * right).to_bytes(width * (count + 1), "little")
    sums = [int.from_bytes(digits[width * i : width * (i + 1)], "little") >> MANTISSA for i in range(count)]
    skipped = next((i for i, p in enumerate(sums) if p), count - 1)
    while len(sums) > skipped + 1 and not sums[-1]:
        sums.pop()
    return one[0] + other[0] + skipped, sums[skipped:]
