"""T15, part (i): rows whose group was not recorded, and how far the ratio can move, whoever they are.

A block is what is compared: one context, or all of them together. It has groups with labelled rows (count n, sum S of their utilities), and
rows of known utility and unknown group, each of which belongs to one of these groups or to nobody who is compared here. How many of them
a group receives has limits. All numbers are integers; a ratio is a fraction, 0/0 = 1 and c/0 is infinite.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from math import inf

from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import quotient

__all__ = ["Block", "Pair", "greatest", "least_apart", "levels", "rows_until_above", "rows_until_below"]


@dataclass(frozen=True)
class Block:
    """Groups with labelled rows, and rows of unknown group.

    Attributes
    ----------
    counts, sums : tuple of int
        For each group how many labelled rows it has, at least one, and what their utilities sum to.
    values, numbers : tuple of int
        The utilities of the unknown rows, greatest first, and how many rows have each.
    least, most : tuple of int
        How many of the unknown rows a group receives at least and at most.
    rest : tuple of int
        The same for all who are not compared here together.

    Examples
    --------
    >>> block = Block((4, 4), (3, 2), (1, 0), (1, 1), (0, 0), (2, 2), (0, 2))
    >>> greatest(block).ratio, least_apart(block)
    (Fraction(2, 1), None)
    """

    counts: tuple[int, ...]
    sums: tuple[int, ...]
    values: tuple[int, ...]
    numbers: tuple[int, ...]
    least: tuple[int, ...]
    most: tuple[int, ...]
    rest: tuple[int, int]

    @cached_property
    def unknown(self) -> int:
        """How many rows have no group."""
        return sum(self.numbers)

    @cached_property
    def top(self) -> Sums:
        """Sums of the greatest rows."""
        return Sums.of(self.values, self.numbers)

    @cached_property
    def bottom(self) -> Sums:
        """Sums of the smallest rows."""
        return Sums.of(self.values[::-1], self.numbers[::-1])

    @cached_property
    def ranges(self) -> tuple[tuple[int, int], ...]:
        """How many rows each group can receive, so that all others can keep to their limits."""
        low, high = sum(self.least) + self.rest[0], sum(self.most) + self.rest[1]
        return tuple(
            (max(own, self.unknown - high + most), min(most, self.unknown - low + own))
            for own, most in zip(self.least, self.most, strict=True)
        )

    def best(self, group: int) -> int:
        """With how many of the greatest rows the mean of a group is greatest."""
        low, high = self.ranges[group]
        return min(max(self._until(group, self.values, self.numbers, 1), low), high)

    def worst(self, group: int) -> int:
        """With how many of the smallest rows the mean of a group is least."""
        low, high = self.ranges[group]
        return min(max(self._until(group, self.values[::-1], self.numbers[::-1], -1), low), high)

    def _until(self, group: int, values: Sequence[int], numbers: Sequence[int], sign: int) -> int:
        """How many rows are added while each lies beyond the running mean; all of a value or none."""
        count, total, taken = self.counts[group], self.sums[group], 0
        for value, number in zip(values, numbers, strict=True):
            if sign * (value * count - total) <= 0:
                break
            count, total, taken = count + number, total + value * number, taken + number
        return taken

    def mean(self, group: int, rows: int, sums: Sums) -> tuple[int, int]:
        """The mean of a group with so many of the first rows, as numerator and denominator."""
        return self.sums[group] + sums(rows), self.counts[group] + rows

    def freely(self, rows: int) -> Block:
        """The same rows without limits, but at most so many of them to all groups that are compared."""
        nothing, some = (0,) * len(self.counts), (rows,) * len(self.counts)
        return replace(self, least=nothing, most=some, rest=(self.unknown - rows, self.unknown))


@dataclass(frozen=True)
class Sums:
    """Sums of the first rows of some order, in which equal values stand together: at the ends of values, and between them."""

    values: tuple[int, ...]
    ends: tuple[int, ...]
    totals: tuple[int, ...]

    @staticmethod
    def of(values: Sequence[int], numbers: Sequence[int]) -> Sums:
        """Of values, and how many rows have each."""
        products = (value * number for value, number in zip(values, numbers, strict=True))
        return Sums(tuple(values), tuple(accumulate(numbers, initial=0)), tuple(accumulate(products, initial=0)))

    def __call__(self, rows: int) -> int:
        """The sum of so many rows."""
        place = min(bisect_right(self.ends, rows), len(self.values)) - 1
        return 0 if place < 0 else self.totals[place] + self.values[place] * (rows - self.ends[place])


@dataclass(frozen=True)
class Pair:
    """A ratio of two groups, and how many of the unknown rows each of them receives for it: the first best ones, the second worst ones."""

    ratio: Extended
    higher: int
    lower: int
    received: tuple[int, int]


def greatest(block: Block) -> Pair | None:
    """The greatest ratio of two groups over all assignments; None where fewer than two are compared.

    The pairs are gone through from the one whose best and worst means are farthest apart, which mostly attains that.
    """
    groups = range(len(block.counts))
    if len(groups) < 2:
        return None
    up = {a: block.mean(a, block.best(a), block.top) for a in groups}
    down = {a: block.mean(a, block.worst(a), block.bottom) for a in groups}
    found: Pair | None = None
    falling = sorted(groups, key=lambda a: Fraction(*up[a]), reverse=True)
    rising = sorted(groups, key=lambda a: Fraction(*down[a]))
    for a in falling:
        for place, b in enumerate([b for b in rising if b != a]):
            if found is not None and _ratio(up[a], down[b]) <= found.ratio:
                if place == 0:
                    return found
                break
            pair = greatest_of(block, a, b)
            if found is None or pair.ratio > found.ratio:
                found = pair
    return found


def greatest_of(block: Block, higher: int, lower: int) -> Pair:
    """The greatest ratio of an ordered pair of groups over all assignments."""
    i, j = block.best(higher), block.worst(lower)
    total = _coupled(block, higher, lower, i + j)
    if total == i + j:
        return Pair(_at(block, higher, lower, i, j), higher, lower, (i, j))
    segments = list(_segments(block, higher, lower, total))
    ends = {*segments[0], *segments[-1], *(() if block.sums[lower] else _without_utility(block, total, segments))}
    ratio, at = max((_at(block, higher, lower, place, total - place), place) for place in ends)
    while ratio != inf:
        beyond, place = max(_farthest(block, higher, lower, total, segment, Fraction(ratio)) for segment in segments)
        if beyond <= 0:
            break
        at, ratio = place, _at(block, higher, lower, place, total - place)
    return Pair(ratio, higher, lower, (at, total - at))


def least_apart(block: Block) -> Pair | None:
    """The pair whose ratio is above 1 in all assignments by the greatest factor, with the least ratio that it has; None if there is none.

    The two numbers of rows are those that the higher group receives of the smallest and the lower one of the greatest.
    """
    groups = range(len(block.counts))
    down = [Fraction(*block.mean(a, block.worst(a), block.bottom)) for a in groups]
    up = [Fraction(*block.mean(a, block.best(a), block.top)) for a in groups]
    high, low = _at_both_ends(down, up)
    found: Pair | None = None
    for a in high:
        for b in low:
            if a == b or down[a] == 0:
                continue
            pair = greatest_of(block, b, a)
            if pair.ratio >= 1:
                continue
            ratio = inf if pair.ratio == 0 else 1 / Fraction(pair.ratio)
            if found is None or ratio > found.ratio:
                found = Pair(ratio, a, b, (pair.received[1], pair.received[0]))
    return found


def levels(block: Block) -> tuple[Fraction, Fraction]:
    """How high at most the least mean can be, and how low at least the greatest, by what all groups together lack of it.

    If all means are at least μ, the groups below it received from rows above it what they lacked: Σ max(0, μn − S) ≤ Σ max(0, v − μ), each
    row being given once. Likewise if all are at most w.

    Examples
    --------
    >>> levels(Block((2, 2, 2), (2, 1, 1), (1,), (1,), (0, 0, 0), (1, 1, 1), (0, 1)))
    (Fraction(3, 5), Fraction(1, 1))
    """
    rows, groups = list(zip(block.values, block.numbers, strict=True)), list(zip(block.sums, block.counts, strict=True))
    points = sorted({Fraction(0), *map(Fraction, block.values), *(Fraction(s, n) for s, n in groups)})

    def lacking(level: Fraction) -> Fraction:
        below = sum((max(Fraction(0), level * n - s) for s, n in groups), Fraction(0))
        return below - sum((max(Fraction(0), v - level) * number for v, number in rows), Fraction(0))

    def beyond(level: Fraction) -> Fraction:
        above = sum((max(Fraction(0), s - level * n) for s, n in groups), Fraction(0))
        return above - sum((max(Fraction(0), level - v) * number for v, number in rows), Fraction(0))

    low = max(point for point in points if lacking(point) <= 0)
    slope = sum(n for s, n in groups if s <= low * n) + sum(number for v, number in rows if v > low)
    high = min(point for point in points if beyond(point) <= 0)
    fall = sum(n for s, n in groups if s >= high * n) + sum(number for v, number in rows if v < high)
    return low - lacking(low) / slope, high + beyond(high) / fall


MANY, FEW = 24, 6  # of more groups only those at both ends are compared


def _at_both_ends(high: Sequence[Fraction], low: Sequence[Fraction]) -> tuple[list[int], list[int]]:
    """The groups of which pairs are looked at: all, or of many those with the greatest numbers and those with the least."""
    groups = list(range(len(high)))
    if len(groups) <= MANY:
        return groups, groups
    return sorted(groups, key=high.__getitem__)[-FEW:], sorted(groups, key=low.__getitem__)[:FEW]


def rows_until_above(block: Block, limit: Fraction, below: int | None = None) -> int | None:
    """The least number of unknown rows that, assigned to groups in the worst way, bring some ratio above a limit; None if none do.

    `below`: None is found, too, where so many rows or more are needed.
    """
    most = block.unknown if below is None else min(below - 1, block.unknown)

    def above(rows: int) -> bool:
        pair = greatest(block.freely(rows))
        return pair is not None and pair.ratio > limit

    return _first(most, above)


def rows_until_below(block: Block, limit: Fraction) -> tuple[int, Pair] | None:
    """How many unknown rows at least have to be assigned to groups before all ratios can be at most a limit; None if they never can.

    Each pair above the limit needs so many by itself, and the one that needs most is given, too, with its ratio and no rows; where other
    pairs are in the way, more may be needed.
    """
    means = [Fraction(s, n) for s, n in zip(block.sums, block.counts, strict=True)]
    needed, found = 0, Pair(Fraction(1), 0, 0, (0, 0))
    higher, lower = _at_both_ends(means, means)
    for a in higher:
        for b in lower:
            if means[a] <= limit * means[b]:
                continue

            def within(rows: int, a: int = a, b: int = b) -> bool:
                reverse = greatest_of(block.freely(rows), b, a).ratio
                return reverse * limit >= 1

            if not within(block.unknown):
                return None
            if not needed or not within(needed):
                needed, found = _first(block.unknown, within) or 0, Pair(quotient(means[a], means[b]), a, b, (0, 0))
    return needed, found


def _first(most: int, holds: Callable[[int], bool]) -> int | None:
    """The least number up to `most` for which something holds that then holds for all greater ones."""
    if most < 0 or not holds(most):
        return None
    low, high = 0, most
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def _ratio(one: tuple[int, int], other: tuple[int, int]) -> Extended:
    found: Extended = quotient(Fraction(*one), Fraction(*other))
    return found


def _at(block: Block, higher: int, lower: int, i: int, j: int) -> Extended:
    return _ratio(block.mean(higher, i, block.top), block.mean(lower, j, block.bottom))


def _coupled(block: Block, one: int, other: int, together: int) -> int:
    """The number next to `together` of rows that two groups can receive, so that all others can keep to their limits.

    With more rows than the first numbers want, or fewer, each row that is moved the right way is no loss, as the mean of a group is
    unimodal in the number of its rows: so the best assignment is at the nearest number.
    """
    low = block.unknown - sum(block.most) - block.rest[1] + block.most[one] + block.most[other]
    high = block.unknown - sum(block.least) - block.rest[0] + block.least[one] + block.least[other]
    return min(max(together, low), high)


Segment = tuple[int, int]


def _without_utility(block: Block, total: int, segments: Sequence[Segment]) -> Iterator[int]:
    """With how many rows of the first group the second one, which has no utility so far, receives as many rows without any as it can."""
    nothing = block.numbers[-1] if block.values and block.values[-1] == 0 else 0
    first, last = segments[0][0], segments[-1][1]
    if total - nothing <= last:
        yield max(first, total - nothing)


def _segments(block: Block, higher: int, lower: int, total: int) -> Iterator[Segment]:
    """Ranges of the number of rows of the first group within which it takes rows of one value, and the second one does."""
    first = max(block.ranges[higher][0], total - block.ranges[lower][1])
    last = min(block.ranges[higher][1], total - block.ranges[lower][0])
    inner = {end for end in (*block.top.ends, *(total - end for end in block.bottom.ends)) if first < end < last}
    ends = sorted({first, last, *inner})
    yield from zip(ends, ends[1:] or ends, strict=False)


def _farthest(block: Block, higher: int, lower: int, total: int, segment: Segment, limit: Fraction) -> tuple[int, int]:
    """Where in a segment the first mean exceeds the second one times a limit by most, both multiplied by both counts, and by how much."""
    start, end = segment

    def beyond(i: int) -> int:
        (s, n), (t, m) = block.mean(higher, i, block.top), block.mean(lower, total - i, block.bottom)
        return limit.denominator * s * m - limit.numerator * t * n

    places = {start, end}
    if end - start > 1:  # a quadratic in i
        one, two, three = beyond(start), beyond(start + 1), beyond(start + 2)
        square = three - 2 * two + one  # twice the leading coefficient
        if square < 0:
            vertex = Fraction(2 * (two - one) - square, -2 * square)  # after `start`
            near = start + vertex.numerator // vertex.denominator
            places |= {min(max(place, start), end) for place in (near, near + 1)}
    return max((beyond(i), i) for i in places)
