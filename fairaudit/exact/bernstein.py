"""Where polynomials are nonnegative, exactly: the greatest such point of an interval, or a proof that there is none.

A polynomial on an interval is written in the Bernstein basis. It lies between the least and the greatest of its coefficients, and the
first and the last of them are its values at the ends; halving the interval brings them closer to it (de Casteljau).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import comb, lcm

__all__ = ["coefficients", "greatest_nonnegative"]


Coefficients = tuple[int, ...]


HALVINGS = 60  # an interval is halved so often that a root between its ends no longer matters to twelve decimals

MOST_PARTS = 20_000  # a few seconds; what is undecided by then counts as not proved


def coefficients(values: Sequence[Fraction]) -> list[Fraction]:
    """Bernstein coefficients of the polynomial of degree n with the given values at 0, 1/n, …, 1.

    Parameters
    ----------
    values : sequence of Fraction
        n + 1 values, n at least 0.

    Returns
    -------
    list of Fraction
        The n + 1 coefficients on [0, 1].

    Examples
    --------
    >>> [str(b) for b in coefficients([Fraction(0), Fraction(1, 4), Fraction(1)])]
    ['0', '0', '1']
    """
    return [sum((w * v for w, v in zip(row, values, strict=True)), Fraction(0)) for row in _inverse(len(values) - 1)]


def greatest_nonnegative(polynomials: Sequence[Sequence[Fraction]], low: Fraction, high: Fraction) -> tuple[Fraction | None, bool]:
    """Find the greatest point of an interval at which all polynomials are at least 0.

    Parameters
    ----------
    polynomials : sequence of sequence of Fraction
        Their Bernstein coefficients on the interval, all of one degree.
    low, high : Fraction
        The interval, closed.

    Returns
    -------
    point : Fraction or None
        For degree 0 and 1 the greatest point, exactly; beyond, to 2^-60 of the interval, and suitable points that fill less than that
        between unsuitable ones may escape.
    settled : bool
        Without a point: whether it is proved that there is none.

    Examples
    --------
    >>> point, _ = greatest_nonnegative([[Fraction(3), Fraction(-1)], [Fraction(-1), Fraction(1)]], Fraction(0), Fraction(1))
    >>> str(point)
    '3/4'
    >>> greatest_nonnegative([[Fraction(1), Fraction(-1)], [Fraction(-2), Fraction(1)]], Fraction(0), Fraction(1))
    (None, True)
    """
    if any(max(p) < 0 for p in polynomials):
        return None, True
    left = [p for p in polynomials if min(p) < 0]
    if all(len(p) <= 2 for p in left):
        found = _linear(left)
        return (None, True) if found is None else (low + (high - low) * found, True)
    return _search([_integers(p) for p in left], low, high)


def _linear(lines: Sequence[Sequence[Fraction]]) -> Fraction | None:
    """The greatest u in [0, 1] at which all lines b0 + (b1 − b0)·u are at least 0; each of them is negative at one end."""
    least, greatest = Fraction(0), Fraction(1)
    for b0, b1 in lines:
        zero = b0 / (b0 - b1)
        if b0 < 0:
            least = max(least, zero)
        else:
            greatest = min(greatest, zero)
    return greatest if least <= greatest else None


def _search(polynomials: list[Coefficients], low: Fraction, high: Fraction) -> tuple[Fraction | None, bool]:
    """Halve from the right: parts where a polynomial is negative fall away, and so do polynomials that are nonnegative on a part."""
    waiting = [(polynomials, Fraction(0), Fraction(1))]
    settled = True
    for _ in range(MOST_PARTS):
        if not waiting:
            return None, settled
        left, a, b = waiting.pop()
        if any(max(p) < 0 for p in left):
            continue
        left = [p for p in left if min(p) < 0]
        if all(p[-1] >= 0 for p in left):
            return low + (high - low) * b, True
        if (b - a).denominator >= 1 << HALVINGS:
            if all(p[0] >= 0 for p in left):
                return low + (high - low) * a, True
            settled = False
            continue
        halves = [_halves(p) for p in left]
        middle = (a + b) / 2
        waiting += [([first for first, _ in halves], a, middle), ([second for _, second in halves], middle, b)]
    return None, False


def _halves(polynomial: Coefficients) -> tuple[Coefficients, Coefficients]:
    """Coefficients on both halves of the interval, up to one common factor."""
    row, first, second = list(polynomial), [], []
    degree = len(row) - 1
    for k in range(degree + 1):
        first.append(row[0] << (degree - k))
        second.append(row[-1] << (degree - k))
        row = [p + q for p, q in pairwise(row)]
    return tuple(first), tuple(reversed(second))


def _integers(polynomial: Sequence[Fraction]) -> Coefficients:
    bottom = lcm(*(b.denominator for b in polynomial))
    return tuple(b.numerator * (bottom // b.denominator) for b in polynomial)


@cache
def _inverse(degree: int) -> list[list[Fraction]]:
    """The matrix that turns values at 0, 1/n, …, 1 into Bernstein coefficients."""
    size = degree + 1
    points = [Fraction(j, max(1, degree)) for j in range(size)]
    rows = [
        [comb(degree, i) * u**i * (1 - u) ** (degree - i) for i in range(size)] + [Fraction(int(j == i)) for i in range(size)]
        for j, u in enumerate(points)
    ]
    for i in range(size):
        pivot = next(j for j in range(i, size) if rows[j][i])
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [entry / rows[i][i] for entry in rows[i]]
        for j in range(size):
            if j != i and rows[j][i]:
                rows[j] = [entry - rows[j][i] * own for entry, own in zip(rows[j], rows[i], strict=True)]
    return [row[size:] for row in rows]
