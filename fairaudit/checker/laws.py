"""Laws of the decision: integer weights and their sum, their means, and the total variation distance of two of them."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from math import gcd
from operator import mul

from .rationals import ZERO, Rational, Vector, at_most, extreme_positions, over_common_denominator, reduced
from .work import keep, spend

Law = tuple[tuple[int, ...], int]  # integer weights of the decisions, and their sum


def reduced_law(weights: Sequence[int], total: int) -> Law:
    """Divide by the common factor: then equal laws have equal weights, which saves comparisons later."""
    if (bits := total.bit_length()) > 256:
        spend(2 * len(weights), bits, bits)
        keep(len(weights), bits)
    divisor = gcd(*weights)
    return (tuple(weights), total) if divisor == 1 else (tuple([weight // divisor for weight in weights]), total // divisor)


def gains_of(utility: Sequence[Rational | None]) -> Vector:
    """Write the utilities of the decisions over one denominator; one that is not given belongs to no decision that was made."""
    return over_common_denominator([ZERO if entry is None else entry for entry in utility])


def mean_of(weights: Sequence[int], total: int, gains: Vector) -> Rational:
    """Compute the mean of the utility under integer weights with this sum."""
    if total.bit_length() + gains[1].bit_length() > 256:
        spend(2 * len(weights), total.bit_length(), max(map(int.bit_length, gains[0])) + gains[1].bit_length())
    return reduced(sum(map(mul, weights, gains[0])), total * gains[1])


def expectation(law: Law, utility: Sequence[Rational | None]) -> Rational:
    """Compute the mean of a utility under a law."""
    return mean_of(*law, gains_of(utility))


def widest_distance(laws: Sequence[Law]) -> tuple[Rational, int, int]:
    """Find the greatest total variation distance of two of the laws, and the first positions that attain it."""
    bits = max(total.bit_length() for _, total in laws)
    if len(laws[0][0]) <= 2:  # the distance is the difference of the probabilities of the first decision
        values = [(weights[0], total) for weights, total in laws]
        top, low = extreme_positions(values)
        (n, d), (p, q) = values[top], values[low]
        spend(3, bits, bits)
        return ((n * q - p * d, d * q), min(top, low), max(top, low)) if n * q > p * d else (ZERO, 0, 1)
    # The first pair that attains a positive maximum consists of first occurrences, so that repetitions can be left out.
    first: dict[tuple[int, ...], int] = {}
    for i, (weights, _) in enumerate(laws):
        first.setdefault(weights, i)
    places = list(first.values())
    each = 10 + 2 * len(laws[0][0])
    spend(len(places) * (len(places) * len(laws[0][0]) // 40 + each))
    screen = _Screen([laws[i] for i in places]) if len(places) > 32 else None
    best: tuple[Rational, int, int] = (ZERO, 0, 1)
    for at, i in enumerate(places):
        others = screen.farther(best[0]) if screen else range(len(places) - at - 1)
        spend(len(others) * each, bits, bits)
        for later in others:
            j = places[at + 1 + later]
            distance = _distance(laws[i], laws[j])
            if not at_most(distance, best[0]):
                best = distance, i, j
        if best[0][0] == best[0][1]:  # no distance exceeds 1
            break
    return best


def _distance(left: Law, right: Law) -> Rational:
    (p, m), (q, n) = left, right
    return sum([e for a, b in zip(p, q, strict=True) if (e := a * n - b * m) > 0]), m * n


class _Screen:
    """A quick test that leaves only those pairs of many laws whose distance may exceed a bound.

    It works on probabilities that are rounded down to multiples of 2^-28.  Then p - q is less than one unit above the
    difference of the rounded numbers, so that the distance of two laws on d decisions is at most d units above the sum
    of the positive differences of the rounded numbers.  That sum is formed for one law and all later ones at once: for
    each decision a long integer holds the numbers of all laws in lanes of 32 bits.  The highest bit of a lane is set
    before a subtraction; it is still set afterwards exactly if the difference is not negative, and no lane borrows
    from its neighbour.
    """

    def __init__(self, laws: Sequence[Law]) -> None:
        rounded = [[(weight << 28) // total for weight in weights] for weights, total in laws]
        self.lanes = len(laws)
        self.ones = self._packed([1] * self.lanes)
        self.columns = [self._packed(column) for column in zip(*rounded, strict=True)]

    @staticmethod
    def _packed(values: Sequence[int]) -> int:
        return int.from_bytes(struct.pack(f"<{len(values)}I", *values), "little")

    def farther(self, bound: Rational) -> list[int]:
        """Take the next law off; list those of the later ones (0 is the next) whose distance from it may exceed the bound."""
        own = [column & 0xFFFFFFFF for column in self.columns]
        self.lanes -= 1
        self.ones >>= 32
        self.columns = [column >> 32 for column in self.columns]
        signs = self.ones << 31
        sums = 0
        for number, column in zip(own, self.columns, strict=True):
            differences = (column | signs) - number * self.ones
            positive = differences & signs
            sums += differences & (positive - (positive >> 31))
        least = max(0, (bound[0] << 28) // bound[1] - len(own) + 1)  # of the sums that are worth a closer look
        if not ((sums | signs) - least * self.ones) & signs:
            return []
        found = struct.unpack(f"<{self.lanes}I", sums.to_bytes(4 * self.lanes, "little"))
        return [i for i, total in enumerate(found) if total >= least]
