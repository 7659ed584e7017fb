"""One ordered pair of groups in T13, exactly: its upper envelopes, its sum at a value, and Newton's method on it."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import accumulate
from math import inf

from fairaudit.exact.extended import ONE, Extended
from fairaudit.privacy.columns import Column

MANY = 200
"""Columns beyond which comparing each of them takes longer than adding all of them up first."""

Points = tuple[Column, ...]
"""What decisions are worth to the first and the second group: (A, B), falling in both, each best at some rate of exchange."""


def envelope(tops: Sequence[int], lows: Sequence[int]) -> Points:
    """Decisions (A, B) that maximise s·A − B for some s from 0 to infinity, in falling order of s.

    Of decisions that are equally good at some s, two remain that are the only best ones beside it.

    Examples
    --------
    >>> envelope([0, 2, 1, 3, 1], [1, 3, 1, 9, 2])
    ((3, 9), (2, 3), (1, 1))
    """
    kept: list[Column] = []
    for a, b in sorted(set(zip(tops, lows, strict=True)), key=lambda point: (-point[0], point[1])):
        if kept and b >= kept[-1][1]:
            continue
        while len(kept) > 1 and (kept[-2][1] - kept[-1][1]) * (kept[-1][0] - a) <= (kept[-1][1] - b) * (kept[-2][0] - kept[-1][0]):
            kept.pop()
        kept.append((a, b))
    return tuple(kept)


def best_sums(columns: Sequence[Column], blocks: Iterable[Points], value: Fraction) -> Column:
    """Σ p and Σ q of the policy that maximises Σ p − V·Σ q, and of those with the same maximum has the greatest Σ q.

    Source: T13.

    Parameters
    ----------
    columns : sequence of (int, int)
        Released values by the likelihood ratio of the two groups, falling.
    blocks : iterable of Points
        For every released context what decisions are worth; p = P·A and q = Q·B.
    value : Fraction
        V.

    Examples
    --------
    >>> best_sums([(2, 1), (1, 2)], [((3, 3), (1, 1))], Fraction(1))
    (7, 5)
    """
    if len(columns) > MANY:
        return _best_sums_of_many(columns, blocks, value)
    n, d = value.numerator, value.denominator
    top = low = 0
    for points in blocks:
        at, (a, b) = 0, points[0]
        taken_p = taken_q = 0
        for p, q in columns:
            while at + 1 < len(points) and d * p * (a - points[at + 1][0]) < n * q * (b - points[at + 1][1]):
                top, low = top + taken_p * a, low + taken_q * b
                taken_p = taken_q = 0
                at += 1
                a, b = points[at]
            taken_p, taken_q = taken_p + p, taken_q + q
        top, low = top + taken_p * a, low + taken_q * b
    return top, low


def _best_sums_of_many(columns: Sequence[Column], blocks: Iterable[Points], value: Fraction) -> Column:
    """The same for many columns: where the best decision changes is looked for by bisection, since comparing long numbers takes long."""
    n, d = value.numerator, value.denominator
    sums = [(0, 0), *zip(accumulate(p for p, _ in columns), accumulate(q for _, q in columns), strict=True)]
    top = low = 0
    for points in blocks:
        start = 0
        for (a, b), (a2, b2) in zip(points, [*points[1:], (0, 0)], strict=True):
            end = len(columns) if (a, b) == points[-1] else _first_below(columns, n * (b - b2), d * (a - a2), start)
            top, low = top + (sums[end][0] - sums[start][0]) * a, low + (sums[end][1] - sums[start][1]) * b
            start = end
    return top, low


def _first_below(columns: Sequence[Column], top: int, bottom: int, start: int) -> int:
    """The first column, from a place on, whose ratio is below top/bottom."""
    return bisect_left(columns, True, lo=start, key=lambda column: bool(column[0] * bottom < top * column[1]))


def greatest_above(columns: Sequence[Column], blocks: Sequence[Points], value: Extended) -> Extended | None:
    """The greatest ratio of a pair of groups over all policies, by Newton's method, if it is above a value of at least 1; else None.

    Source: T13.

    Examples
    --------
    >>> greatest_above([(2, 1), (1, 2)], [((3, 3), (1, 1))], Fraction(1))
    Fraction(7, 5)
    """
    found = None
    while isinstance(value, Fraction):
        top, low = best_sums(columns, blocks, value)
        if top * value.denominator <= value.numerator * low:
            break
        found = value = Fraction(top, low) if low else inf
    return found


def attained(columns: Sequence[Column], blocks: Sequence[Points], value: Fraction) -> bool:
    """Whether the greatest ratio of a pair, which is not above a value over 1, is that value."""
    top, low = best_sums(columns, blocks, max(value, ONE))
    return low > 0 and top * value.denominator == value.numerator * low
