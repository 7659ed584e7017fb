"""Rényi and zero-concentrated privacy: divergences of all orders, enclosed in decimals rounded outward."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import MAX_EMAX, MIN_EMIN, ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from heapq import heappop, heappush
from math import gcd
from typing import Any

import numpy as np

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import option_value
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.currencies import Enclosure, RenyiDP, zCDP
from fairaudit.privacy.epsilon_delta import pure_dp
from fairaudit.privacy.pairs import pairs_alike

ZCDP_GAP = Fraction(1, 1000)
"""ρ is enclosed to this relative width: three digits, which is what a privacy budget is stated in."""

ZCDP_EVALUATIONS = 300
"""Divergences that are evaluated at most on the way there; what is known by then is an enclosure, too."""

SHOWN_DIGITS = 20
"""Digits of an enclosure as it is shown: more than a double, so that rounding outward is never seen."""


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
    >>> from fairaudit.model.mechanism import RandomizedResponse
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
    >>> from fairaudit.model.mechanism import RandomizedResponse
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
        rows = list(dict.fromkeys(factor.rows[:2] if pairs_alike(factor) else factor.rows))
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
