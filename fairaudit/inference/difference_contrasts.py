"""Differences of independent cells of draws of several values: every pair of cells by itself, by bets on the contrast of their draws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf, sqrt
from typing import Any

from fairaudit.exact.extended import extended_text
from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison, Place
from fairaudit.inference.contrast_region import fits_contrasts
from fairaudit.inference.levels import Holding, pair_errors
from fairaudit.inference.pair_region import LOOKED_AT
from fairaudit.inference.symmetric_betting import is_below, upper_end


def fits_difference_contrasts(comparison: Comparison) -> bool:
    """Whether contrasts bound the differences of these cells, if they are independent: as for ratios, and one range for all of them.

    A difference does not depend on the origin, so that it is asked of the same cells with a range from 0 on.
    """
    ranges = {
        (comparison.cells[i].low, comparison.cells[i].high) for block in comparison.blocks if len(block) > 1 for ((i, _), *_) in block
    }
    if len(ranges) != 1 or any(low == high for low, high in ranges):
        return False
    raised = tuple(
        Cell(cell.draws, cell.total - cell.draws * cell.low, None, Fraction(0), cell.high - cell.low, cell.binary)
        for cell in comparison.cells
    )
    return fits_contrasts(replace(comparison, cells=raised))


def difference_contrasts_interval(comparison: Comparison, alpha: Fraction, ends: Holding) -> tuple[Fraction, Fraction, dict[str, Any]]:
    """Both ends of the difference, each ordered pair by itself, with their evidence: the pair that proves the lower end.

    As for ratios, the upper ends of all pairs need no correction, and their lower ends share one error.
    """
    contrasts = _Contrasts(comparison, alpha, ends)
    upper = contrasts.upper()
    lower, place = contrasts.lower()
    levels = {name: extended_text(level) for name, level in zip(("upper", "lower"), contrasts.errors, strict=True)}
    return lower, upper, {"levels": levels, "upper": None, "lower": None, "pair": None if place is None else list(place)}


def difference_contrasts_driver(comparison: Comparison, alpha: Fraction, ends: Holding, upper: Fraction) -> Place | None:
    """The pair that drives the upper end: the first, by floats, that is not excluded a little below it."""
    contrasts = _Contrasts(comparison, alpha, ends)
    below = upper - contrasts.width / 100
    return next((place for place in contrasts.ranked(upper=True) if not contrasts.excludes(place, below)), None)


@dataclass(frozen=True)
class _Contrasts:
    """The pairs of cells that are compared, with the levels of their ends."""

    comparison: Comparison
    alpha: Fraction
    ends: Holding

    @cached_property
    def errors(self) -> tuple[Fraction, Fraction]:
        """The levels of the upper end of a pair, and of the lower one."""
        upper, lower = pair_errors(self.comparison.pairs, self.alpha, self.ends)
        return upper or Fraction(0), lower or Fraction(0)

    @cached_property
    def width(self) -> Fraction:
        """That of the range of a draw, which is the same everywhere."""
        cell = self.comparison.cells[self.comparison.cells_of(self.comparison.places[0])[0]]
        return cell.high - cell.low

    @cached_property
    def drawn(self) -> list[ValueCounts]:
        """How often each value was drawn, on the scale on which the range is [0, 1]."""
        tallies = zip(self.comparison.cells, self.comparison.tallies, strict=True)
        return [ValueCounts({(v - cell.low) / self.width: n for v, n in sorted(tally.items()) if n}) for cell, tally in tallies]

    def excludes(self, place: Place, limit: Fraction) -> bool:
        """Whether the difference of a pair is proved to be less than a limit."""
        i, j = self.comparison.cells_of(place)
        return is_below(self.drawn[i], self.drawn[j], limit / self.width, self.errors[0], "difference")

    def end(self, place: Place, *, lower: bool) -> Fraction:
        """The upper end of the difference of a pair, or of the opposite one for its lower end."""
        i, j = reversed(self.comparison.cells_of(place)) if lower else self.comparison.cells_of(place)
        found = upper_end(self.drawn[i], self.drawn[j], self.errors[lower], "difference")
        return self.width if found == inf else min(Fraction(found) * self.width, self.width)

    def ranked(self, *, upper: bool) -> list[Place]:
        """Pairs by the ends that floats expect, those that decide first."""
        terms = []
        for cell, drawn in zip(self.comparison.cells, self.drawn, strict=True):
            values, counts = drawn.arrays
            mean = float(values @ counts) / cell.draws
            terms.append((mean, (float((values - mean) ** 2 @ counts) + 0.25) / (cell.draws + 1) ** 2))

        def promise(place: Place) -> float:
            (one, error), (other, second) = (terms[i] for i in self.comparison.cells_of(place))
            return one - other + (2 if upper else -3) * sqrt(error + second)

        return sorted(self.comparison.places, key=promise, reverse=True)

    def upper(self) -> Fraction:
        """The greatest upper end of a pair."""
        end = Fraction(0)
        for place in self.ranked(upper=True):
            if end < self.width and not self.excludes(place, end):
                end = max(end, self.end(place, lower=False))
        return end

    def lower(self) -> tuple[Fraction, Place | None]:
        """The greatest lower end of those pairs that are furthest apart, and its pair."""
        best, found = Fraction(0), None
        for place in self.ranked(upper=False)[:LOOKED_AT]:
            value = -self.end(place, lower=True)
            if value > best:
                best, found = value, place
        return best, found
