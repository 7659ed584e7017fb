"""Rationals: pairs ``(numerator, denominator)`` of integers; infinity is ``(1, 0)``.

Cross-multiplication orders all of them, infinity included.  Where no infinity occurs and speed does not matter, they are
``Fraction``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import chain
from math import gcd, lcm, prod
from operator import add

from .json_values import described_type, read_list
from .text import FormatError, malformed, shown
from .work import keep, spend

MAX_DIGITS = 100_000  # of a numerator or a denominator: quotients of numbers with thousands of digits, summed over a table, have so many

Rational = tuple[int, int]
ZERO: Rational = (0, 1)
ONE: Rational = (1, 1)
INFINITY: Rational = (1, 0)
_RATIONAL = re.compile(r"(-?)(0|[1-9][0-9]*)(?:/([1-9][0-9]*))?")


def _whole(digits: str) -> int:
    """Read decimal digits by halves: Python refuses to read long numbers at once."""
    if len(digits) <= 500:
        return int(digits)
    half = len(digits) // 2
    scale: int = 10**half
    return _whole(digits[:-half]) * scale + _whole(digits[-half:])


def read_rational(value: object, where: str, nonnegative: bool = False) -> Rational:
    """Read a rational in lowest terms, a string like ``"3/2"`` or ``"3"``."""
    match = _RATIONAL.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        got = shown(value) if isinstance(value, str) else described_type(value)
        raise malformed(where, f'must be a rational, a string like "3/2" or "3", not {got}')
    sign, above, below = match.groups()
    if len(above) > MAX_DIGITS or (below is not None and len(below) > MAX_DIGITS):
        raise malformed(where, f"has more than {MAX_DIGITS} digits")
    if len(above) > 500 or (below is not None and len(below) > 500):
        digits = max(len(above), len(below or ""))
        spend(3, 4 * digits, 4 * digits)
        keep(1, 4 * (len(above) + len(below or "")))
    numerator = _whole(above)
    denominator = 1 if below is None else _whole(below)
    if below is not None and (denominator == 1 or gcd(numerator, denominator) != 1):
        raise malformed(where, f"is not in lowest terms: {shown(value)}")
    if sign and numerator == 0:
        raise malformed(where, 'must be written "0", not "-0"')
    if sign and nonnegative:
        raise malformed(where, f"must not be negative: {shown(value)}")
    return (-numerator if sign else numerator), denominator


def read_extended(value: object, where: str) -> Rational:
    """Read a rational or ``"inf"``."""
    return INFINITY if value == "inf" else read_rational(value, where)


@lru_cache(maxsize=1 << 14)
def _short(text: str) -> Rational:
    """Read a rational that is not negative and has few digits: tables repeat those."""
    return read_rational(text, "", nonnegative=True)


def read_rationals(value: object, where: str, length: int) -> list[Rational]:
    """Read so many rationals that are not negative."""
    items = read_list(value, where, length)
    try:
        return [_short(item) if isinstance(item, str) and len(item) <= 40 else read_rational(item, "", nonnegative=True) for item in items]
    except FormatError:  # to be said again with its place
        return [read_rational(item, f"{where}[{i}]", nonnegative=True) for i, item in enumerate(items)]


def read_signed(value: object, where: str, length: int | None = None) -> list[Rational]:
    """Read rationals of either sign, so many if a length is given."""
    return [read_rational(item, f"{where}[{i}]") for i, item in enumerate(read_list(value, where, length))]


def read_two(value: object, where: str) -> tuple[Fraction, Fraction]:
    """Read two rationals that are not negative, as fractions."""
    first, second = read_rationals(value, where, 2)
    return Fraction(*first), Fraction(*second)


def read_two_signed(value: object, where: str) -> tuple[Fraction, Fraction]:
    """Read two rationals of either sign, as fractions."""
    first, second = read_signed(value, where, 2)
    return Fraction(*first), Fraction(*second)


def _pair(item: object) -> tuple[Rational, Rational]:
    if type(item) is list and len(item) == 2 and type(item[0]) is type(item[1]) is str and len(item[0]) + len(item[1]) <= 40:
        return _short(item[0]), _short(item[1])
    first, second = read_rationals(item, "", 2)
    return first, second


def read_pairs(value: object, where: str, signed: bool = False) -> list[tuple[Rational, Rational]]:
    """Read pairs of rationals, of which there may be very many; not negative ones unless they are signed."""
    items = read_list(value, where)
    if signed:
        both = [read_signed(item, f"{where}[{i}]", 2) for i, item in enumerate(items)]
        return [(first, second) for first, second in both]
    try:
        return [_pair(item) for item in items]
    except FormatError:  # to be said again with its place
        for i, item in enumerate(items):
            read_rationals(item, f"{where}[{i}]", 2)
        raise


def written(value: Rational) -> str:
    """Write a finite rational in full, as the format has it."""
    numerator, denominator = value
    sign = "-" * (numerator < 0)
    return sign + _decimal_digits(abs(numerator)) + (f"/{_decimal_digits(denominator)}" if denominator != 1 else "")


def _decimal_digits(number: int) -> str:
    """Write a number by halves: Python refuses to write long ones at once."""
    if number.bit_length() <= 1500:
        return str(number)
    half = number.bit_length() * 3 // 20
    upper, lower = divmod(number, 10**half)
    return _decimal_digits(upper) + _decimal_digits(lower).zfill(half)


def bits_of(*values: Fraction | Rational) -> int:
    """Count the bits of some rationals together."""
    total = 0
    for value in values:
        n, d = (value.numerator, value.denominator) if isinstance(value, Fraction) else value
        total += n.bit_length() + d.bit_length()
    return total


def as_pair(value: Fraction) -> Rational:
    """Write a fraction as a pair of integers."""
    return value.numerator, value.denominator


def reduced(numerator: int, denominator: int) -> Rational:
    """Bring a rational to lowest terms."""
    if denominator.bit_length() > 512:
        spend(3, numerator.bit_length(), denominator.bit_length())
    divisor = gcd(numerator, denominator)
    return numerator // divisor, denominator // divisor


def negated(value: Rational) -> Rational:
    """Change the sign."""
    return -value[0], value[1]


def product_of(factors: Iterable[Rational]) -> Rational:
    """Multiply rationals, infinite ones included."""
    numerators, denominators = zip(*factors, strict=True)
    for numbers in (numerators, denominators):
        bits = sum(number.bit_length() for number in numbers)
        spend(1, bits, bits)
    return reduced(prod(numerators), prod(denominators))


def at_most(left: Rational, right: Rational) -> bool:
    """Decide whether one rational is at most another one, infinity included."""
    return left[0] * right[1] <= right[0] * left[1]


def common_denominator(denominators: Iterable[int]) -> int:
    """Find the least common multiple."""
    common = 1
    for denominator in denominators:
        if (bits := common.bit_length()) > 256:
            spend(3, bits, denominator.bit_length())
        common = lcm(common, denominator)
    return common


def over_common_denominator(values: Sequence[Rational]) -> tuple[list[int], int]:
    """Write rationals as integers over one denominator."""
    common = common_denominator({denominator for _, denominator in values})
    if common == 1:
        return [numerator for numerator, _ in values], 1
    if (bits := common.bit_length()) > 256:
        spend(2 * len(values), bits, max(d.bit_length() + n.bit_length() for n, d in values))
        keep(len(values), 2 * bits)
    return [numerator * (common // denominator) for numerator, denominator in values], common


def _spend_on_order(first: Rational, rest: Sequence[Rational]) -> None:
    """Count the steps of comparing numbers with the extremes of those before."""
    values = [first, *rest]
    bits = max(max(map(max, values)), -min(map(min, values))).bit_length()
    spend(4 * len(rest), bits, bits)


def extreme_positions(values: Iterable[Rational]) -> tuple[int, int]:
    """Find the positions of the first greatest and the first least of some rationals."""
    first, *rest = values
    _spend_on_order(first, rest)
    greatest, least = first, first
    top, low = 0, 0
    for i, value in enumerate(rest, 1):
        if value[0] * greatest[1] > greatest[0] * value[1]:
            greatest, top = value, i
        if value[0] * least[1] < least[0] * value[1]:
            least, low = value, i
    return top, low


def maximum(values: Sequence[Rational]) -> Rational:
    """Find the greatest of some rationals, in lowest terms."""
    return reduced(*values[extreme_positions(values)[0]])


def widest_ratio(values: Sequence[Rational]) -> tuple[Rational, int, int]:
    """Find the greatest ratio of two of the values, and the first positions (higher, lower) that attain it."""
    top, low = extreme_positions(values)
    (n, d), (p, q) = values[top], values[low]
    if n * q == p * d:  # all values are equal, possibly to 0: every ratio is 1
        return ONE, 0, 1
    if p == 0:  # any positive value over 0 is infinite, not only the greatest
        return INFINITY, next(i for i, value in enumerate(values) if value[0] > 0), low
    return (n * q, d * p), top, low


def quotient(top: Rational, bottom: Rational) -> Rational:
    """Divide, 0/0 being 1 and c/0 infinite."""
    if not bottom[0]:
        return INFINITY if top[0] else ONE
    return top[0] * bottom[1], top[1] * bottom[0]


def greatest_quotient(tops: Sequence[Rational], bottoms: Sequence[Rational]) -> Rational:
    """The greatest quotient of the end of one and another end of another one, at least 1."""
    i, j = extreme_positions(tops)[0], extreme_positions(bottoms)[1]
    if i != j:
        pairs = [(i, j)]
    else:
        rest = [k for k in range(len(tops)) if k != i]
        second, other = (rest[extreme_positions([ends[k] for k in rest])[side]] for side, ends in ((0, tops), (1, bottoms)))
        pairs = [(second, j), (i, other)]
    best = ONE
    for one, another in pairs:
        found = quotient(tops[one], bottoms[another])
        best = found if not at_most(found, best) else best
    return best


def widest_gap(values: Sequence[Rational]) -> tuple[Rational, int, int]:
    """Find the greatest difference of two of the values, and the first positions (higher, lower) that attain it."""
    top, low = extreme_positions(values)
    (n, d), (p, q) = values[top], values[low]
    spend(3, d.bit_length(), q.bit_length())
    return (ZERO, 0, 1) if n * q == p * d else ((n * q - p * d, d * q), top, low)


Vector = tuple[list[int], int]  # numerators over one denominator


class RunningTotal:
    """A running sum of vectors of rationals, in which long denominators occur in few additions only.

    Each part is the sum of 2^rank terms, but for those that were added where the denominator was the same already.  The
    ranks of the parts decrease, as the digits of a binary counter do: two parts of one rank become one of the next.
    """

    def __init__(self) -> None:
        self.parts: list[tuple[int, Vector]] = []

    def add(self, numerators: list[int], denominator: int) -> None:
        """Add a vector."""
        if (bits := denominator.bit_length()) > 256:
            keep(len(numerators), 2 * bits)
        parts = self.parts
        if parts and parts[-1][1][1] == denominator:
            own = parts[-1][1][0]
            own[:] = map(add, own, numerators)
            return
        rank, term = 0, (numerators, denominator)
        while parts and parts[-1][0] == rank:
            term = _sum_of_two(parts.pop()[1], term)
            rank += 1
        parts.append((rank, term))

    def value(self) -> Vector:
        """The sum of what was added, at least one vector."""
        rank, term = self.parts.pop()
        while self.parts:
            rank, part = self.parts.pop()
            term = _sum_of_two(part, term)
        self.parts.append((rank, term))
        return term


def _sum_of_two(left: Vector, right: Vector) -> Vector:
    one, other = left[1].bit_length(), right[1].bit_length()
    if one + other > 256:
        widest = max(map(int.bit_length, chain(left[0], right[0])))
        spend(2 * len(left[0]) + 3, one + other, max(widest, one, other))
        keep(len(left[0]), one + other + widest)
    divisor = gcd(left[1], right[1])
    p, q = right[1] // divisor, left[1] // divisor
    return [a * p + b * q for a, b in zip(left[0], right[0], strict=True)], left[1] * p


def sum_of(values: Iterable[Rational]) -> Rational:
    """Add up rationals, at least one."""
    total = RunningTotal()
    for n, d in values:
        total.add([n], d)
    (numerator,), denominator = total.value()
    return reduced(numerator, denominator)


def fraction_sum(values: Iterable[Fraction]) -> Fraction:
    """Add up fractions, at least one."""
    return Fraction(*sum_of((value.numerator, value.denominator) for value in values))


def weighted_sum(terms: Iterable[tuple[int, Fraction]]) -> Fraction:
    """Add up multiples of fractions."""
    return Fraction(*sum_of([ZERO, *((n * value.numerator, value.denominator) for n, value in terms)]))


# An affine form in the variables: integer coefficients over one denominator, that of the constant under CONSTANT.  A
# constraint A v <= b is kept as its slack b - A v, an affine form that is at least 0 on the class.
Affine = tuple[dict[int, int], int]

CONSTANT = -1


def affine_sum(terms: Iterable[tuple[Rational, Affine]]) -> Affine:
    """Add up multiples of affine forms."""
    kept = [(n, d * denominator, form) for (n, d), (form, denominator) in terms if n]
    common = common_denominator({d for _, d, _ in kept})
    count = sum(len(form) for _, _, form in kept)
    bits = max((n.bit_length() + max(map(int.bit_length, form.values()), default=0) for n, _, form in kept), default=0)
    spend(3 * count, bits + common.bit_length(), bits)
    keep(count, bits + common.bit_length())
    total: dict[int, int] = {}
    for n, d, form in kept:
        factor = n * (common // d)
        for j, coefficient in form.items():
            total[j] = total.get(j, 0) + factor * coefficient
    return total, common


def constant_form(value: Rational) -> Affine:
    """Write a rational as an affine form."""
    return {CONSTANT: value[0]}, value[1]
