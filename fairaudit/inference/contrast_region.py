"""Intervals of independent cells of draws of several values: every pair of cells by itself, by bets on the contrast of their draws."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from math import inf, log, sqrt
from typing import Any

from fairaudit.exact.extended import Extended, extended_text
from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.comparisons import Comparison, Place
from fairaudit.inference.levels import Holding, pair_errors
from fairaudit.inference.pair_region import LOOKED_AT
from fairaudit.inference.paired_betting import bets
from fairaudit.inference.symmetric_betting import MOST_PAIRS, is_below, upper_end

MOST_STEPS = 36_000_000
"""Of those that docs/certificate.md lets a document ask of its reader."""

MOST_VALUES = 3_000
"""Different ones in a cell."""

MOST_BITS = 128
"""Of a value, above or below: longer ones take the reader more steps."""


def contrast_steps(comparison: Comparison) -> float:
    """How many steps a reader may need to check the contrasts of all pairs; infinite if it is no matter of contrasts.

    It is one for independent cells with draws, some of them of more than two values, whose expected utilities are the mean of one cell.
    How the draws came out has no say in it, since nobody may choose a method by that: only how many they are, and which values there are.
    """
    cells = [comparison.cells[form[0][0]] for block in comparison.blocks if len(block) > 1 for form in block]
    if not comparison.drawn or not comparison.single or comparison.dependent or all(cell.binary for cell in cells):
        return inf
    if any(cell.low < 0 or cell.high <= 0 or not cell.draws for cell in cells) or 2_000 * comparison.pairs > MOST_STEPS:
        return inf
    if any(max(n.bit_length() for n in v.as_integer_ratio()) > MOST_BITS for tally in comparison.tallies for v in tally):
        return inf
    listed = comparison.listed and comparison.estimand == "mean over rows"
    of_values = []
    for cell, tally in zip(comparison.cells, comparison.tallies, strict=True):
        values = min(cell.draws, len(tally)) if listed else cell.draws
        if values > MOST_VALUES:
            return inf
        of_values.append(320 * values + (14 + 7 * values.bit_length()) * min(cell.draws - values, 128 * values))
    total, most = 0, 0
    for one, other in _pairs_of_cells(comparison):
        n, m = (comparison.cells[i].draws for i in (one, other))
        pairs = min(n, m, MOST_PAIRS)
        made = len(bets(pairs**2 * (Fraction(1, n) + Fraction(1, m))))
        steps = made * (2_000 + 60 * min(max(n, m), MOST_PAIRS) + of_values[one] + of_values[other])
        total, most = total + steps, max(most, steps)
    return total + most


def fits_contrasts(comparison: Comparison, most: float = MOST_STEPS) -> bool:
    """Whether contrasts bound the ratios of these cells, if they are independent, and are checked in so many steps."""
    return contrast_steps(comparison) <= most


def contrasts_interval(comparison: Comparison, alpha: Fraction, ends: Holding) -> tuple[Fraction, Extended, dict[str, Any]]:
    """Both ends of the ratio, each ordered pair by itself, with their evidence: the pair that proves the lower end.

    As for `pairs_interval`, the upper ends of all pairs need no correction, and their lower ends share one error.
    """
    contrasts = _Contrasts(comparison, alpha, ends)
    upper: Extended = inf if ends == "lower" else contrasts.upper()
    lower, place = (Fraction(1), None) if ends == "upper" else contrasts.lower()
    of_upper, of_lower = (None if level is None else extended_text(level) for level in contrasts.errors)
    levels = {"upper": of_upper, "lower": of_lower}
    return lower, upper, {"levels": levels, "upper": None, "lower": None, "pair": None if place is None else list(place)}


def contrasts_driver(comparison: Comparison, alpha: Fraction, ends: Holding, upper: Extended) -> Place | None:
    """The pair that drives the upper end: the first, by floats, that is not excluded a little below it; or the most unequal."""
    contrasts = _Contrasts(comparison, alpha, ends)
    if upper <= 1 or contrasts.errors[0] is None:
        return None
    if upper == inf:
        return next((place for place in contrasts.ranked(upper=True) if contrasts.end(place, lower=False) == inf), None)
    below = Fraction(upper) * (1 - Fraction(1, 100))
    return next((place for place in contrasts.ranked(upper=True) if below <= 1 or not contrasts.excludes(place, below)), None)


def _pairs_of_cells(comparison: Comparison) -> Iterator[tuple[int, int]]:
    for block in comparison.blocks:
        yield from permutations([form[0][0] for form in block], 2)


@dataclass(frozen=True)
class _Contrasts:
    """The pairs of cells that are compared, with the levels of their ends."""

    comparison: Comparison
    alpha: Fraction
    ends: Holding

    @cached_property
    def errors(self) -> tuple[Fraction | None, Fraction | None]:
        """The levels of the upper end of a pair, and of the lower one."""
        return pair_errors(self.comparison.pairs, self.alpha, self.ends)

    @cached_property
    def drawn(self) -> list[ValueCounts]:
        """How often each value was drawn, as a part of the greatest that there could be."""
        tallies = zip(self.comparison.cells, self.comparison.tallies, strict=True)
        return [ValueCounts({v / cell.high: n for v, n in sorted(tally.items()) if n}) for cell, tally in tallies]

    def most(self, place: Place) -> Extended:
        """The greatest ratio of a pair that the ranges of its cells allow."""
        one, other = (self.comparison.cells[i] for i in self.comparison.cells_of(place))
        return one.high / other.low if other.low else inf

    def excludes(self, place: Place, limit: Fraction) -> bool:
        """Whether the ratio of a pair is proved to be at most a limit."""
        i, j = self.comparison.cells_of(place)
        factor = self.comparison.cells[i].high / self.comparison.cells[j].high
        return limit >= self.most(place) or is_below(self.drawn[i], self.drawn[j], limit / factor, self.errors[0] or Fraction(0))

    def end(self, place: Place, *, lower: bool) -> Extended:
        """The upper end of the ratio of a pair, or the inverse of its lower end."""
        i, j = reversed(self.comparison.cells_of(place)) if lower else self.comparison.cells_of(place)
        found = upper_end(self.drawn[i], self.drawn[j], self.errors[1 if lower else 0] or Fraction(0))
        scaled = inf if found == inf else found * (self.comparison.cells[i].high / self.comparison.cells[j].high)
        return scaled if lower else min(scaled, self.most(place))

    def ranked(self, *, upper: bool) -> list[Place]:
        """Pairs by the ends that floats expect, those that decide first."""
        terms = []
        for cell, drawn in zip(self.comparison.cells, self.drawn, strict=True):
            values, counts = drawn.arrays
            mean = (float(values @ counts) + 0.5) / (cell.draws + 1)
            spread = float((values - mean) ** 2 @ counts) + 0.25
            terms.append((log(mean) + log(cell.high.numerator) - log(cell.high.denominator), spread / (mean * (cell.draws + 1)) ** 2))

        def promise(place: Place) -> float:
            (one, error), (other, second) = (terms[i] for i in self.comparison.cells_of(place))
            return one - other + (2 if upper else -3) * sqrt(error + second)

        return sorted(self.comparison.places, key=promise, reverse=True)

    def upper(self) -> Extended:
        """The greatest upper end of a pair."""
        end: Extended = Fraction(1)
        for place in self.ranked(upper=True):
            if end == inf:
                break
            if not self.excludes(place, Fraction(end)):
                end = max(end, self.end(place, lower=False))
        return end

    def lower(self) -> tuple[Fraction, Place | None]:
        """The greatest lower end of those pairs that are furthest apart, and its pair."""
        best, found = Fraction(1), None
        for place in self.ranked(upper=False)[:LOOKED_AT]:
            value = self.end(place, lower=True)
            if 0 < value < 1 / best:
                best, found = 1 / Fraction(value), place
        return best, found
