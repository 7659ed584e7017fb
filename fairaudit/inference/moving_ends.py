"""Cells of a population of which only ends are known, and which drift: for `fairaudit.theorems.t16` in the place of a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.inference.cells import Cell, Ends
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.interval import Interval
from fairaudit.inference.plain_ends import PlainEnds, ends_of_evidence
from fairaudit.theorems.t16 import Form

SLACK = 1e-9  # more than float64 loses in a few operations on numbers up to 1


@dataclass(frozen=True)
class MovingMean:
    """The mean of a cell between two ends, which moves by η times the range and not out of it."""

    ends: Ends
    least: Fraction
    most: Fraction
    bottom: int = 1

    @property
    def most_seen(self) -> Fraction:
        """The same as the greatest: what is seen of the population is not known."""
        return self.most

    @property
    def least_seen(self) -> Fraction:
        """The same as the least."""
        return self.least

    def end(self, form: Form, amount: Fraction, *, up: bool) -> Fraction:  # noqa: ARG002
        """The greatest or least expectation within a drift."""
        a, b = self.by_variation(amount, up=up)
        return a + b * amount

    def by_variation(self, eta: Fraction, *, up: bool) -> tuple[Fraction, Fraction]:
        """The end within about η as a line."""
        width, (low, high) = self.most - self.least, self.ends
        if up:
            return (high, width) if high + eta * width < self.most else (self.most, Fraction(0))
        return (low, -width) if low - eta * width > self.least else (self.least, Fraction(0))

    def by_factor(self, f: Fraction, *, up: bool) -> tuple[Any, Any, Any]:
        """Nothing follows from ends alone."""
        raise NotImplementedError


class MovingEnds:
    """Cells between ends that hold together, in blocks of those that are compared.

    Parameters
    ----------
    comparison : Comparison
        What is compared, each form being one cell.
    ends : sequence of pair of Fraction
        The ends of all cells.

    Examples
    --------
    >>> from fairaudit.inference.comparisons import unit_form
    >>> cells = [Cell(10, Fraction(5), None, Fraction(0), Fraction(1), True)] * 2
    >>> moving = MovingEnds(Comparison(tuple(cells), ((unit_form(0), unit_form(1)),)), [(Fraction(1, 4), Fraction(3, 4))] * 2)
    >>> [str(moving.mean(0).end("radius", Fraction(1, 10), up=up)) for up in (False, True)]
    ['3/20', '17/20']
    """

    def __init__(self, comparison: Comparison, ends: Sequence[Ends]) -> None:
        blocks = [[form[0][0] for form in block] for block in comparison.blocks]
        self.blocks_of = blocks
        self.cells = [i for block in blocks for i in block]
        self.starts: NDArray[np.int64] = np.concatenate(([0], np.cumsum([len(block) for block in blocks], dtype=np.int64)))
        self.all: Sequence[Cell] = comparison.cells
        self.ends = ends

    def mean(self, i: int) -> MovingMean:
        """One of the means."""
        cell = self.all[self.cells[i]]
        return MovingMean(self.ends[self.cells[i]], cell.low, cell.high)

    def places(self, pair: tuple[int, int]) -> tuple[int, int]:
        """The positions of a pair among all means that are compared."""
        return pair

    def blocks(
        self,
        form: Form,  # noqa: ARG002
        amount: Fraction,
        limit: Fraction,
        among: Sequence[int] | None,
        *,
        within: bool,
    ) -> list[int]:
        """Blocks some pair of which may be above 0, those that floats find highest first."""
        low, high = self._outer if within and self._outer else self._nearest
        least, most = self._ranges
        v, way = float(limit), float(amount) * (most - least)
        upper, lower = np.minimum(most, high + way), np.maximum(least, low - way)
        edges = self.starts[:-1]
        if within:
            found = np.maximum.reduceat(upper, edges) - v * np.minimum.reduceat(lower, edges)
        else:
            found = np.maximum.reduceat(lower, edges) - v * np.minimum.reduceat(upper, edges)
        possible = np.flatnonzero(found > -(1 + v) * SLACK * float(most.max(initial=1)))
        if among is not None:
            possible = np.intersect1d(possible, np.array(among, dtype=np.int64))
        return [int(b) for b in possible[np.argsort(-found[possible], kind="stable")].tolist() if len(self.blocks_of[b]) > 1]

    @cached_property
    def _outer(self) -> tuple[Floats, Floats] | None:
        """Numbers little below the lower ends and little above the upper ones, where most follow from the draws."""
        if not isinstance(self.ends, PlainEnds):
            return None
        low, high = self.ends.floats
        return low[self.cells], high[self.cells]

    @cached_property
    def _nearest(self) -> tuple[Floats, Floats]:
        """The ends in floats."""
        if self._outer and isinstance(self.ends, PlainEnds) and not self.ends.reach:  # those of ranges, and some that are listed
            return self._outer
        ends = [self.ends[i] for i in self.cells]
        return _in_floats([low for low, _ in ends]), _in_floats([high for _, high in ends])

    @cached_property
    def _ranges(self) -> tuple[Floats, Floats]:
        cells = [self.all[i] for i in self.cells]
        return _in_floats([cell.low for cell in cells]), _in_floats([cell.high for cell in cells])


def _in_floats(column: Sequence[Fraction]) -> Floats:
    shared = {id(value): value for value in column}  # most cells share some of their ends
    floats = {key: float(value) for key, value in shared.items()}
    return np.array([floats[id(value)] for value in column])


def ends_that_hold(interval: Interval, comparison: Comparison) -> tuple[Sequence[Ends], Sequence[Ends]] | None:
    """The ends of single cells on which an interval rests, for its upper and for its lower end; None where it rests on pairs of cells."""
    evidence = interval.evidence
    boxed = interval.region == "box" and interval.ends == "each" and "betting" not in interval.methods
    if not boxed or not comparison.single or comparison.units is not None:
        return None
    return ends_of_evidence(comparison, evidence, "upper"), ends_of_evidence(comparison, evidence, "lower")
