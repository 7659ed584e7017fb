"""Columns (p, q) of an ordered pair of rows, one for each likelihood ratio p/q: merged, joined, and raised to powers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import comb, gcd, inf

from fairaudit.errors import InputError

Column = tuple[int, int]

MAX_EXPONENT = 64
"""Powers of one ratio are looked for up to this exponent."""


class TooManyColumns(InputError):  # noqa: N818
    """Several releases together have more likelihood ratios than are counted."""


@dataclass
class Budget:
    """How many products of columns may still be formed, each counted with the bits of its numbers."""

    left: float

    def afford(self, products: int, bits: int) -> None:
        """Refuse work that the budget does not allow."""
        if products * (bits + 64) > self.left:
            raise TooManyColumns(
                "so many releases of this filter have too many different likelihood ratios to be counted exactly; "
                "fewer releases, or a filter with fewer different probabilities, are accepted"
            )

    def spend(self, products: int, bits: int) -> None:
        """Take work from the budget."""
        self.afford(products, bits)
        self.left -= products * (bits + 64)


def merged_columns(entries: Iterable[Column]) -> tuple[Column, ...]:
    """Join the columns of equal likelihood ratio, in falling order of the ratio, over the least common denominator."""
    sums: dict[Column, int] = {}
    for p, q in entries:
        common = gcd(p, q)
        if common:
            ratio = (p // common, q // common)
            sums[ratio] = sums.get(ratio, 0) + common
    common = gcd(*sums.values())
    return tuple((p * (sums[p, q] // common), q * (sums[p, q] // common)) for p, q in _falling(sums))


def joined_columns(columns: tuple[Column, ...], more: tuple[Column, ...], budget: Budget | None = None) -> tuple[Column, ...]:
    """Columns of two independent pairs together."""
    if len(more) == 1:
        return columns
    if budget and len(columns) > 1:
        budget.spend(len(columns) * len(more), _bits(columns) + _bits(more))
    return more if len(columns) == 1 else merged_columns((p * r, q * s) for p, q in columns for r, s in more)


def _bits(columns: tuple[Column, ...]) -> int:
    return sum(p for p, _ in columns).bit_length()


def powered_columns(columns: tuple[Column, ...], times: int, budget: Budget | None = None) -> tuple[Column, ...]:
    """Columns of `times` independent pairs of the same form, as `joined_columns` would make them one after the other.

    Where the ratios are those of a geometric progression, as in randomized response, the columns are the coefficients of a power of a
    polynomial, each found from the ones before it. Otherwise they are convolved.

    Source: T17.

    Parameters
    ----------
    columns : tuple of (int, int)
        Distinct ratios in falling order; the p and the q have the same sum.
    times : int
        At least 1.
    budget : Budget, optional
        What may be spent.

    Returns
    -------
    tuple of (int, int)
        In falling order of the ratio, without a common factor.

    Raises
    ------
    TooManyColumns
        If that takes more than the budget.

    Examples
    --------
    >>> powered_columns(((2, 1), (1, 2)), 3)
    ((8, 1), (12, 6), (6, 12), (1, 8))
    >>> powered_columns(((1, 0), (1, 1), (0, 1)), 2)
    ((3, 0), (1, 1), (0, 3))
    """
    finite = [(p, q) for p, q in columns if p and q]
    if times == 1 or (len(finite) == 1 and len(columns) == 1) or not finite:
        return columns
    power = _power_of_finite(finite, times, budget or Budget(inf))
    whole = sum(p for p, _ in columns) ** times
    lost, gained = whole - sum(p for p, _ in power), whole - sum(q for _, q in power)
    power = [(lost, 0)] * (lost > 0) + power + [(0, gained)] * (gained > 0)
    common = gcd(*(value for column in power for value in column))
    return tuple((p // common, q // common) for p, q in power) if common > 1 else tuple(power)


def _power_of_finite(finite: Sequence[Column], times: int, budget: Budget) -> list[Column]:
    """The power of columns without zeros, in falling order of the ratio."""
    size, bits = len(finite), sum(p for p, _ in finite).bit_length()
    exponents = _progression([Fraction(p, q) for p, q in finite])
    if exponents is not None and exponents[0] * times < comb(times + size - 1, size - 1):
        budget.spend(exponents[0] * times * size, times * bits // 4)  # each step only multiplies by a small number
        tops = _coefficients([p for p, _ in finite], exponents, times)
        bottoms = _coefficients([q for _, q in finite], exponents, times)
        return [(p, q) for p, q in zip(reversed(tops), reversed(bottoms), strict=True) if p]
    # With two different ratios, t releases have at least t + 1 columns.
    budget.afford(times * times * size // 2, times * bits * 2 // 3)
    once = [((p // gcd(p, q), q // gcd(p, q)), gcd(p, q)) for p, q in finite]
    masses = dict(once)
    for step in range(2, times + 1):
        budget.spend(len(masses) * size, step * bits)
        masses = _convolved(masses, once)
    return [(p * masses[p, q], q * masses[p, q]) for p, q in _falling(masses)]


def _convolved(masses: Mapping[Column, int], more: Sequence[tuple[Column, int]]) -> dict[Column, int]:
    """Masses by likelihood ratio in lowest terms, after one more pair."""
    found: dict[Column, int] = {}
    for (p, q), mass in masses.items():
        for (r, s), other in more:
            one, two = gcd(p, s), gcd(q, r)
            ratio = (p // one) * (r // two), (q // two) * (s // one)
            found[ratio] = found.get(ratio, 0) + mass * other * one * two
    return found


def _falling(ratios: Iterable[Column]) -> list[Column]:
    """Ratios in lowest terms in falling order, infinity first."""
    listed = list(ratios)
    # Two ratios with denominators below 2^b differ by more than 2^-2b, so their first 2b binary places differ.
    places = 2 * max(q for _, q in listed).bit_length()
    return sorted(listed, key=lambda ratio: (ratio[1] > 0, -((ratio[0] << places) // ratio[1]) if ratio[1] else 0))


def _progression(ratios: Sequence[Fraction]) -> list[int] | None:
    """For ratios in falling order, whole numbers e such that ratio = least · r^e for one r > 1; None if there is no such r."""
    steps = [ratio / ratios[-1] for ratio in ratios[:-1]]
    root: Fraction | None = steps[0] if steps else None
    for step in steps[1:]:
        root = root and _common_root(root, step)
    if root is None:
        return None if steps else [0]
    exponents = {root**e: e for e in range(MAX_EXPONENT + 1)}
    return [exponents[step] for step in [*steps, Fraction(1)]] if exponents.keys() >= set(steps) else None


def _common_root(one: Fraction, other: Fraction) -> Fraction | None:
    """The greatest r of which two numbers above 1 are powers; None if none is found in a few steps."""
    for _ in range(MAX_EXPONENT):
        high, low = max(one, other), min(one, other)
        if high == low:
            return low
        if high.numerator % low.numerator or high.denominator % low.denominator:
            return None
        # Of powers of one r, the quotient is the power by the difference of the exponents.
        one, other = Fraction(high.numerator // low.numerator, high.denominator // low.denominator), low
        if one <= 1:
            return None
    return None


def _coefficients(masses: Sequence[int], exponents: Sequence[int], times: int) -> list[int]:
    """Coefficients of (Σ mass·z^exponent)^times, from z^0 up, by the recurrence of J. C. P. Miller: f·(fⁿ)' = n·f'·fⁿ."""
    terms = list(zip(exponents[:-1], masses[:-1], strict=True))
    least = masses[-1]
    found = [least**times]
    for k in range(1, exponents[0] * times + 1):
        total = sum((e * (times + 1) - k) * mass * found[k - e] for e, mass in terms if e <= k)
        found.append(total // (k * least))
    return found
