"""T15, second part: cells of rows of which shares belong to groups, the slices that groups can take, and the most equal completion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf, lcm

from fairaudit.exact.extended import Extended

__all__ = ["Cell", "Cells", "Mixture", "Union", "beyond", "level", "members", "mixture_means", "proxy_cells", "ratio"]

Union = int
"""A set of groups as bits."""

Mixture = tuple[tuple[Fraction, tuple[int, ...]], ...]
"""Shares of orders: in each cell the groups take the rows in this order, from the least utility up."""


@dataclass(frozen=True)
class Cell:
    """The rows of a cell.

    Attributes
    ----------
    gains : tuple of (int, int)
        Utility and number of rows, in increasing order of the utility.
    low, high : tuple of int
        How many of them belong to each group, at least and at most.
    """

    gains: tuple[tuple[int, int], ...]
    low: tuple[int, ...]
    high: tuple[int, ...]

    @cached_property
    def rows(self) -> int:
        """How many there are."""
        return sum(count for _, count in self.gains)

    def within(self, union: Union) -> tuple[int, int]:
        """How many rows belong to a union of groups, at least and at most."""
        inside, outside = [0, 0], [0, 0]
        for a, (low, high) in enumerate(zip(self.low, self.high, strict=True)):
            part = inside if union >> a & 1 else outside
            part[0] += low
            part[1] += high
        return max(inside[0], self.rows - outside[1]), min(inside[1], self.rows - outside[0])

    def worst(self, rows: int) -> int:
        """Sum of the utilities of so many rows of the least utility."""
        total = 0
        for gain, count in self.gains:
            taken = min(rows, count)
            total += gain * taken
            rows -= taken
            if not rows:
                break
        return total

    def best(self, rows: int) -> int:
        """Sum of the utilities of so many rows of the greatest utility."""
        return self.total - self.worst(self.rows - rows)

    @cached_property
    def total(self) -> int:
        """Sum of all utilities."""
        return sum(gain * count for gain, count in self.gains)


@dataclass(frozen=True)
class Cells:
    """Cells whose rows are compared with each other.

    Attributes
    ----------
    cells : tuple of Cell
        The cells.
    scale : int
        What a row counts.
    unit : int
        Denominator of the utilities.
    groups : int
        How many groups there are.
    """

    cells: tuple[Cell, ...]
    scale: int
    unit: int
    groups: int

    @cached_property
    def exact(self) -> bool:
        """Whether the shares are known."""
        return all(cell.low == cell.high for cell in self.cells)

    @cached_property
    def worst(self) -> tuple[list[int], list[int]]:
        """Of known shares, by union of groups: the sum of the utilities of its worst slices, and its rows."""
        unions = 1 << self.groups
        sums, rows = [0] * unions, [0] * unions
        for cell in self.cells:
            own = [0] * unions
            for union in range(1, unions):
                last = union & -union
                own[union] = own[union ^ last] + cell.low[last.bit_length() - 1]
                rows[union] += own[union]
                sums[union] += cell.worst(own[union])
        return sums, rows

    def ends(self, union: Union) -> tuple[Fraction, Fraction]:
        """The least and the greatest mean that a union of groups can have: the best slices are what the worst ones leave."""
        if self.exact:
            sums, rows = self.worst
            best = sums[-1] - sums[len(sums) - 1 - union]
            return Fraction(sums[union], rows[union] * self.unit), Fraction(best, rows[union] * self.unit)
        limits = [cell.within(union) for cell in self.cells]
        return self._end(limits, up=False), self._end(limits, up=True)

    def _end(self, limits: Sequence[tuple[int, int]], *, up: bool) -> Fraction:
        """Newton's method: whatever is better (or worse) than the mean so far is taken, as far as the limits allow."""
        value: Fraction | None = None
        while True:
            total = rows = 0
            for cell, (low, high) in zip(self.cells, limits, strict=True):
                taken = low if value is None else min(max(beyond(cell, value, up=up), low), high)
                total += cell.best(taken) if up else cell.worst(taken)
                rows += taken
            found = Fraction(total, rows)
            if found == value:
                return found / self.unit
            value = found


def beyond(cell: Cell, value: Fraction | float, *, up: bool, ties: bool = False) -> int:
    """How many rows have more than a utility (or less); with ties, as many as it.

    Examples
    --------
    >>> cell = Cell(((0, 3), (1, 2)), (2,), (2,))
    >>> beyond(cell, Fraction(1, 2), up=True), beyond(cell, Fraction(1), up=True), beyond(cell, Fraction(1), up=True, ties=True)
    (2, 0, 2)
    """
    return sum(count for gain, count in cell.gains if (gain > value if up else gain < value) or (ties and gain == value))


def ratio(above: Fraction, below: Fraction) -> Extended:
    """A quotient, where 0/0 is 1 and anything else over 0 is infinite."""
    return above / below if below else (inf if above else Fraction(1))


def proxy_cells(rows: Iterable[tuple[Sequence[tuple[Fraction, int]], Sequence[Fraction], Sequence[Fraction]]], groups: int) -> Cells:
    """Cells of rows, of each the utilities with their counts, and the least and greatest share of each group.

    Examples
    --------
    >>> half, shares = Fraction(1, 2), [Fraction(4, 5), Fraction(1, 5)]
    >>> found = proxy_cells([([(Fraction(1), 2), (Fraction(0), 2)], shares, shares)], 2)
    >>> found.cells[0].low, found.scale
    ((16, 4), 5)
    """
    listed = [([(gain, count) for gain, count in gains if count], low, high) for gains, low, high in rows]
    scale = lcm(*(share.denominator for _, low, high in listed for share in (*low, *high)))
    unit = lcm(*(gain.denominator for gains, _, _ in listed for gain, _ in gains))
    cells = []
    for gains, low, high in listed:
        counted: dict[int, int] = {}
        for gain, count in gains:
            whole = gain.numerator * (unit // gain.denominator)
            counted[whole] = counted.get(whole, 0) + count * scale
        size = sum(counted.values())
        least, most = ([size // share.denominator * share.numerator for share in shares] for shares in (low, high))
        cells.append(Cell(tuple(sorted(counted.items())), tuple(least), tuple(most)))
    return Cells(tuple(cells), scale, unit, groups)


def members(union: Union) -> tuple[int, ...]:
    """The groups of a union."""
    return tuple(a for a in range(union.bit_length()) if union >> a & 1)


def level(cells: Cells) -> Mixture:
    """The completion of known shares that is the most equal: no other has a greater least mean, and none a smaller greatest mean.

    The union that must have the greatest mean takes the worst slices, and so on with what is left: those are the sums; each step then goes
    from an order of the groups through the sums to where a further union takes its worst slices, which at most as many steps as there are
    groups bring to an order itself.
    """
    full = (1 << cells.groups) - 1
    worst, rows = cells.worst
    sums = [Fraction(0)] * cells.groups
    done = 0
    while done != full:
        rest = [union for union in range(1, full + 1) if not union & done]
        block = max(rest, key=lambda union: (Fraction(worst[done | union] - worst[done], rows[union]), union.bit_count()))
        for a in members(block):
            sums[a] = Fraction(worst[done | block] - worst[done], rows[block]) * rows[1 << a]
        done |= block
    return tuple(_orders(sums, worst, full))


def _orders(sums: list[Fraction], worst: list[int], full: Union) -> Iterator[tuple[Fraction, tuple[int, ...]]]:
    """Write sums as a mixture of orders of the groups."""
    left = Fraction(1)
    while True:
        tight = sorted((union for union in range(full + 1) if _sum(sums, union) == worst[union]), key=int.bit_count)
        order: list[int] = []
        reached = 0
        while reached != full:
            following = next(union for union in tight if union & reached == reached and union != reached)
            order += members(following & ~reached)
            reached = following
        corner, before = [Fraction(0)] * len(sums), 0
        for a in order:
            corner[a] = Fraction(worst[before | 1 << a] - worst[before])
            before |= 1 << a
        if corner == sums:
            yield left, tuple(order)
            return
        away = [one - other for one, other in zip(sums, corner, strict=True)]
        step = min((_sum(sums, union) - worst[union]) / -drop for union in range(full + 1) if (drop := _sum(away, union)) < 0)
        yield left * step / (1 + step), tuple(order)
        left /= 1 + step
        sums = [one + step * other for one, other in zip(sums, away, strict=True)]


def _sum(sums: Sequence[Fraction], union: Union) -> Fraction:
    return sum((sums[a] for a in members(union)), Fraction(0))


def mixture_means(cells: Cells, mixture: Mixture) -> list[Fraction]:
    """The means of the groups where the shares are known and each order has its share of every cell."""
    sums = [Fraction(0)] * cells.groups
    for share, order in mixture:
        for cell in cells.cells:
            before = 0
            for a in order:
                after = before + cell.low[a]
                sums[a] += share * (cell.worst(after) - cell.worst(before))
                before = after
    return [total / (cells.unit * sum(cell.low[a] for cell in cells.cells)) for a, total in enumerate(sums)]
