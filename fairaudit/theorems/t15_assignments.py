"""Assignments of rows of unknown group under which groups are as alike as can be: found by levelling, or by going through all of them.

What is found here proves nothing by itself: the ratio of an assignment is computed from it, exactly, and that there is no better one is
known only after all were gone through.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from math import ceil, comb

from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import quotient
from fairaudit.theorems.t15 import Block, Pair, least_apart

__all__ = ["Assignment", "least_of_all", "levelled", "ratio_of"]

Assignment = tuple[tuple[int, ...], ...]
"""For each value of the unknown rows how many of them each group receives; the others go to nobody who is compared."""

LEVELS = 9  # between the two at which all groups can be levelled

HALVINGS = 50


def ratio_of(block: Block, assigned: Assignment) -> Extended | None:
    """The greatest ratio of two groups with the rows that they received; None if that breaks a limit.

    Examples
    --------
    >>> ratio_of(Block((4, 4), (3, 2), (1, 0), (1, 1), (0, 0), (2, 2), (0, 2)), ((0, 1), (1, 0)))
    Fraction(1, 1)
    """
    received = [sum(column) for column in zip(*assigned, strict=True)] if assigned else [0] * len(block.counts)
    over = block.unknown - sum(received)
    inside = all(low <= rows <= high for low, rows, high in zip(block.least, received, block.most, strict=True))
    if not inside or not block.rest[0] <= over <= block.rest[1]:
        return None
    if any(sum(row) > number for row, number in zip(assigned, block.numbers, strict=True)):
        return None
    gains = [sum(v * row[a] for v, row in zip(block.values, assigned, strict=True)) for a in range(len(block.counts))]
    means = [Fraction(s + g, n + r) for s, g, n, r in zip(block.sums, gains, block.counts, received, strict=True)]
    found: Extended = quotient(max(means), min(means))
    return found


def levelled(block: Block) -> tuple[Extended, Assignment] | None:
    """An assignment of a small ratio, if one was found that keeps the limits."""
    found = [(ratio, assigned) for assigned in _tried(block) if (ratio := ratio_of(block, assigned)) is not None]
    return min(found, default=None, key=lambda one: one[0])


def least_of_all(block: Block, most: int) -> tuple[Extended, Assignment] | None:
    """The least ratio over all assignments, and one that has it; None where going through them takes more than `most` steps.

    Assignments that give each group as many rows and as much are the same.
    """
    groups = len(block.counts)
    states: dict[tuple[int, ...], Assignment] = {(0,) * 2 * groups: ()}
    for value, number in zip(block.values, block.numbers, strict=True):
        most -= len(states) * comb(number + groups, groups)
        if most < 0:
            return None
        further: dict[tuple[int, ...], Assignment] = {}
        for state, assigned in states.items():
            for row in _spread(number, groups):
                own = tuple(held + part for held, part in zip(state, (*row, *(value * part for part in row)), strict=True))
                further.setdefault(own, (*assigned, row))
        states = further
    found = [(ratio, assigned) for assigned in states.values() if (ratio := ratio_of(block, assigned)) is not None]
    return min(found, default=None, key=lambda one: one[0])


@cache
def _spread(number: int, groups: int) -> tuple[tuple[int, ...], ...]:
    """All ways to give groups some of so many rows."""
    if not groups:
        return ((),)
    return tuple((first, *rest) for first in range(number + 1) for rest in _spread(number - first, groups - 1))


def _tried(block: Block) -> Iterator[Assignment]:
    """Assignments that may level the groups."""
    yield _Rows(block).filled()
    apart = least_apart(block)
    if apart is not None:
        yield _for_pair(block, apart)
    means = [s / n for s, n in zip(block.sums, block.counts, strict=True)]
    low, high = min(means), max(means)
    raised = _bisect(low, high, lambda level: _Rows(block).raises(level))
    lowered = _bisect(high, low, lambda level: _Rows(block).lowers(level))
    if raised >= lowered:
        for step in range(LEVELS):
            level = lowered + (raised - lowered) * step / (LEVELS - 1)
            rows = _Rows(block)
            if rows.raises(level) and rows.lowers(level):
                yield rows.filled()
        return
    for raising_first in (True, False):
        rows = _Rows(block)
        if raising_first and rows.raises(raised):
            rows.lowers(_bisect(high, low, rows.copy_lowers))
        elif not raising_first and rows.lowers(lowered):
            rows.raises(_bisect(low, high, rows.copy_raises))
        yield rows.filled()


def _bisect(start: float, end: float, reaches: Callable[[float], bool]) -> float:
    """The farthest level from `start` to `end` that can be reached, about."""
    if reaches(end):
        return end
    for _ in range(HALVINGS):
        middle = (start + end) / 2
        start, end = (middle, end) if reaches(middle) else (start, middle)
    return start


def _for_pair(block: Block, pair: Pair) -> Assignment:
    """The higher group receives so many of the smallest rows, the lower one of the greatest; others what their limits ask for."""
    rows = _Rows(block)
    rows.give(pair.higher, pair.received[0], range(len(block.values) - 1, -1, -1))
    rows.give(pair.lower, pair.received[1], range(len(block.values)))
    return rows.filled()


class _Rows:
    """Rows while they are handed out."""

    def __init__(self, block: Block) -> None:
        self.block = block
        self.left = list(block.numbers)
        self.given = [[0] * len(block.counts) for _ in block.values]
        self.received = [0] * len(block.counts)
        self.sums = list(block.sums)

    def copy(self) -> _Rows:
        """The same rows, to be handed out in another way."""
        other = _Rows(self.block)
        other.left, other.given = list(self.left), [list(row) for row in self.given]
        other.received, other.sums = list(self.received), list(self.sums)
        return other

    def give(self, group: int, rows: int, order: range | list[int]) -> int:
        """Give a group so many rows of the values at these places, as far as there are; say how many are lacking."""
        for place in order:
            some = min(rows, self.left[place], self.block.most[group] - self.received[group])
            if some <= 0:
                continue
            self.left[place] -= some
            self.given[place][group] += some
            self.received[group] += some
            self.sums[group] += some * self.block.values[place]
            rows -= some
        return rows

    def raises(self, level: float) -> bool:
        """Give groups below a level the greatest rows until they reach it; say whether that was possible."""
        return self._moves(level, 1, range(len(self.left)))

    def lowers(self, level: float) -> bool:
        """Give groups above a level the smallest rows until they are down to it; say whether that was possible."""
        return self._moves(level, -1, range(len(self.left) - 1, -1, -1))

    def copy_raises(self, level: float) -> bool:
        """Whether groups could be raised to a level."""
        return self.copy().raises(level)

    def copy_lowers(self, level: float) -> bool:
        """Whether groups could be lowered to a level."""
        return self.copy().lowers(level)

    def _moves(self, level: float, sign: int, order: range) -> bool:
        for group, labelled in enumerate(self.block.counts):
            for place in order:
                value = self.block.values[place]
                lacking = sign * (level * (labelled + self.received[group]) - self.sums[group])
                if lacking <= 0 or sign * (value - level) <= 0:
                    break
                wanted = ceil(min(lacking / (sign * (value - level)), self.left[place]))
                self.give(group, wanted, [place])
            short = sign * (level * (labelled + self.received[group]) - self.sums[group])
            if short > 1e-9 * (1 + abs(level)) * (labelled + self.received[group]):
                return False
        return True

    def filled(self) -> Assignment:
        """What was handed out, and so much more that the limits are kept, if that is possible: rows near the mean of who receives them."""
        block = self.block
        for group, low in enumerate(block.least):
            self.give(group, max(0, low - self.received[group]), self._near(group))
        for group in sorted(range(len(block.counts)), key=lambda a: -block.counts[a]):
            over = sum(self.left) - block.rest[1]
            self.give(group, max(0, over), self._near(group))
        return tuple(map(tuple, self.given))

    def _near(self, group: int) -> list[int]:
        mean = self.sums[group] / (self.block.counts[group] + self.received[group])
        return sorted(range(len(self.left)), key=lambda place: abs(self.block.values[place] - mean))
