"""Ends of means that drift (T16): the greatest ratio that a move of all cells allows, or cannot avoid, by ends of single cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from .header import Cell, Header
from .json_values import Labels
from .rationals import ONE, Rational, as_pair, at_most, greatest_quotient, reduced
from .work import spend


@dataclass(frozen=True)
class Side:
    """Of a mean of a pair: the end that counts, the end of its range, and the total variation from which on it is that."""

    end: Rational
    last: Rational
    reached: Rational
    constant: bool  # whether no factor changes it


@dataclass(frozen=True)
class Found:
    """The greatest ratio that a move allows, or cannot avoid, or what bounds it; and the sides of the pair that is named."""

    greatest: Rational
    pair: tuple[Side, Side] | None
    bounded: bool = False  # whether some means are not followed


Box = Sequence[tuple[Fraction, Fraction]]
Place = tuple[Labels | None, Labels, Labels]  # context, of overall means none, higher and lower group


class EndMove(NamedTuple):
    """How far each mean may move, as a part of its range; whether the upper end of the ratio counts; and the pair that is named."""

    eta: Fraction
    upper: bool
    place: Place | None


class MovedEnds:
    """What ends of means give when each may move: taken in by blocks of means that are compared."""

    def __init__(self, move: EndMove) -> None:
        self.move = move
        self.greatest = ONE
        self.sides: dict[Labels, Side] = {}
        self.context: int | None = None
        self.groups: Sequence[Labels] = ()

    def begin(self, header: Header) -> None:
        """Find the context of the pair, of cells that pass by."""
        context = None if self.move.place is None else self.move.place[0]
        self.groups = header.groups
        self.context = header.contexts.index(context) if context is not None and context in header.contexts else None

    def take(self, ends: Box, ranges: Box, groups: Sequence[Labels] | None) -> None:
        """Take in the means of a block; ``groups`` where the pair may be."""
        eta, upper, place = self.move
        spend(60 * len(ends))
        moved = [_moved(own, limits, eta) for own, limits in zip(ends, ranges, strict=True)]
        if len(moved) > 1:
            tops, bottoms = ([as_pair(own[side]) for own in moved] for side in ((1, 0) if upper else (0, 1)))
            found = greatest_quotient(tops, bottoms)
            self.greatest = self.greatest if at_most(found, self.greatest) else reduced(*found)
        if place is None or groups is None:
            return
        for label, (low, high), (least, most), (lo, hi) in zip(groups, moved, ranges, ends, strict=True):
            if label in place[1:]:
                up = upper is (label == place[1])
                way = (most - hi if up else lo - least) / (most - least) if most > least else Fraction(0)
                self.sides[label] = Side(as_pair(high if up else low), as_pair(most if up else least), as_pair(way), least == most)

    def take_cells(self, cells: Sequence[Cell], ends: Box, limits: tuple[Fraction, Fraction]) -> None:
        """Take in the cells of a context, which have one range."""
        groups = [self.groups[cell.group] for cell in cells] if cells[0].context == self.context else None
        self.take(ends, [limits] * len(cells), groups)

    def take_plain(self, cells: Sequence[Cell], ends: Sequence[tuple[int, int]], limits: tuple[int, int], unit: int) -> None:
        """Take in a context of which no end is listed: all are so many times 1/unit, the lower ones those of the range."""
        upper, least, most = self.move.upper, *limits
        if self.needs(cells, ends, limits):
            own = [(Fraction(low, unit), Fraction(high, unit)) for low, high in (ends if upper else [limits] * len(cells))]
            self.take_cells(cells, own, (Fraction(least, unit), Fraction(most, unit)))

    def needs(self, cells: Sequence[Cell], ends: Sequence[tuple[int, int]], limits: tuple[int, int]) -> bool:
        """Whether cells have to be looked at whose ends are these, or lie between them."""
        return cells[0].context == self.context or (self.move.upper and not self._cannot_matter(ends, *limits))

    def _cannot_matter(self, ends: Sequence[tuple[int, int]], least: int, most: int) -> bool:
        """Whether upper ends do not exceed the ratio so far, even if the greatest and the least one are of one cell."""
        (p, q), (n, d) = as_pair(self.move.eta), self.greatest
        lows, highs = zip(*ends, strict=True)
        way = p * (most - least)
        top, bottom = min(most * q, max(highs) * q + way), max(least * q, min(lows) * q - way)
        return bool(top * d <= n * bottom)

    def found(self) -> Found:
        """What has been found, now that all means have passed."""
        place = self.move.place
        if place is None or place[1] == place[2] or self.sides.keys() != {*place[1:]}:
            return Found(self.greatest, None)
        return Found(self.greatest, (self.sides[place[1]], self.sides[place[2]]))


def _moved(ends: tuple[Fraction, Fraction], limits: tuple[Fraction, Fraction], eta: Fraction) -> tuple[Fraction, Fraction]:
    least, most = limits
    way = eta * (most - least)
    return max(least, ends[0] - way), min(most, ends[1] + way)
