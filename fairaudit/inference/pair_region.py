"""Intervals of independent cells of two-valued draws: every pair of cells by itself, by the exact pair bound."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf, log, sqrt
from typing import Any

from fairaudit.exact.extended import Extended, extended_text
from fairaudit.inference.comparisons import Comparison, Place
from fairaudit.inference.half_split import MOST_DRAWS as MOST_TO_SPLIT
from fairaudit.inference.half_split import HalfSplit
from fairaudit.inference.interval import Selection
from fairaudit.inference.levels import Holding, pair_errors
from fairaudit.inference.pair_exact import LEVELS, MAX_DRAWS, Contrast, Pair, order_scale, pair_excludes, pair_upper

MOST_STEPS = 22_500_000
"""Of those that docs/certificate.md lets a document ask of its reader, who has a local and a global ratio to check."""

LADDER = 17_500
"""Steps of a ladder, by the square root of the draws of a cell; an interval takes about three, and its pairs a fortieth of one each."""

HASH = 9
"""Steps of a draw that is put into one of two halves."""

LOOKED_AT = 3
"""Pairs that floats find furthest apart, of which the best lower end is taken."""

WIDER = Fraction(1_001, 1_000)
"""How much wider an end is tried if the knots of some pair do not reach it."""


def fits_pairs(comparison: Comparison, alpha: Fraction, select: Selection = "bonferroni", contrast: Contrast = "ratio") -> bool:
    """Whether every pair that is compared is one of two cells of two-valued draws, few enough for ladders.

    For ratios the values are 0 and some positive number; for differences they are the same two in all cells.
    """
    cells = [comparison.cells[form[0][0]] for block in comparison.blocks if len(block) > 1 for form in block]
    two_valued = all(cell.binary and cell.low < cell.high and 0 < cell.draws <= MAX_DRAWS for cell in cells)
    if contrast == "ratio":
        two_valued = two_valued and all(cell.low == 0 for cell in cells)
    else:
        two_valued = two_valued and len({(cell.low, cell.high) for cell in cells}) == 1
    if not cells or not two_valued or not comparison.single or comparison.dependent:
        return False
    steps = LADDER * sqrt(max(cell.draws for cell in cells)) * (2.8 + comparison.pairs / 40)
    if select == "half-split":
        drawn = sum(cell.draws for cell in cells)
        steps += HASH * drawn if drawn <= MOST_TO_SPLIT else inf
    return steps <= MOST_STEPS and LEVELS[0] <= alpha / (2 * comparison.pairs) and alpha <= LEVELS[1]


def pairs_interval(
    comparison: Comparison, alpha: Fraction, ends: Holding, select: Selection = "bonferroni", contrast: Contrast = "ratio"
) -> tuple[Fraction, Extended, dict[str, Any]]:
    """Both ends of the ratio, or of the difference, each ordered pair by itself, with their evidence.

    The pair that attains R, or D, does not depend on the draws, so that the greatest of all upper ends needs no correction for many
    pairs; the pair that proves the lower end does, so that all of them share its error, unless one half of the draws chooses it for the
    other half.
    """
    pairs = _Pairs(comparison, alpha, ends, HalfSplit(comparison) if select == "half-split" else None, contrast)
    upper, knots = (pairs.greatest, None) if ends == "lower" else pairs.upper()
    lower, proof = (pairs.least, None) if ends == "upper" else pairs.lower()
    levels = {
        name: None if level is None else extended_text(level) for name, level in (("upper", pairs.errors[0]), ("lower", pairs.errors[1]))
    }
    split = {} if pairs.split is None else {"split": {"seed": pairs.split.seed}}
    return lower, upper, {"levels": levels, "upper": knots, "lower": proof, **split}


def pairs_driver(comparison: Comparison, alpha: Fraction, ends: Holding, upper: Extended, contrast: Contrast = "ratio") -> Place | None:
    """The pair that drives the upper end: the first, by floats, that is not excluded a little below it; or the most unequal."""
    pairs = _Pairs(comparison, alpha, ends, contrast=contrast)
    ranked = pairs.ranked(upper=True)
    if upper == inf:
        return next((place for place in ranked if not comparison.cells[comparison.cells_of(place)[1]].successes), None)
    below = Fraction(upper) * (1 - Fraction(1, 100))
    if upper <= pairs.least:
        return None
    return next((place for place in ranked if below <= pairs.least or pairs.knots(place, below, lower=False) is None), None)


@dataclass(frozen=True)
class _Pairs:
    """The pairs of cells that are compared, with the levels of their ends."""

    comparison: Comparison
    alpha: Fraction
    ends: Holding
    split: HalfSplit | None = None
    contrast: Contrast = "ratio"

    @property
    def least(self) -> Fraction:
        """Of ratios and differences of groups that are alike."""
        return Fraction(1 if self.contrast == "ratio" else 0)

    @property
    def greatest(self) -> Extended:
        """What no draws are needed for."""
        return inf if self.contrast == "ratio" else self.width

    @cached_property
    def width(self) -> Fraction:
        """How far apart the two values of a draw are, where they are the same everywhere."""
        cell = self.comparison.cells[self.comparison.cells_of(self.comparison.places[0])[0]]
        return cell.high - cell.low

    @cached_property
    def errors(self) -> tuple[Fraction | None, Fraction | None]:
        """The levels of the upper end of a pair, and of the lower one."""
        return pair_errors(self.comparison.pairs if self.split is None else 1, self.alpha, self.ends)

    def pair(self, place: Place, *, lower: bool) -> tuple[Pair, Fraction, Fraction]:
        """The pair for the upper end of its contrast (or for its lower end, exchanged), by what that is multiplied, and the level."""
        level = self.errors[1 if lower else 0] or Fraction(0)
        numbers = self.comparison.cells_of(place)[:: -1 if lower else 1]
        one, other = (self.comparison.cells[i] for i in numbers)
        (k, n), (m, size) = ((int(cell.successes), cell.draws) for cell in (one, other))
        if lower and self.split is not None:
            (k, n), (m, size) = (self.split.halves(i)[1] for i in numbers)
        # A two-sided end orders outcomes as its one-sided end does, so that it is never the narrower one.
        scale = order_scale(2 * level if self.ends == "together" else level)
        factor = one.high / other.high if self.contrast == "ratio" else self.width
        return Pair(k, n, m, size, scale, self.contrast), factor, level

    def knots(self, place: Place, limit: Fraction, *, lower: bool) -> tuple[Fraction, ...] | None:
        """What proves that a ratio, or a difference, is less than a limit; None if nothing does."""
        pair, factor, level = self.pair(place, lower=lower)
        return pair_excludes(pair, limit / factor, level)

    def ranked(self, *, upper: bool) -> list[Place]:
        """Pairs by the ends that floats expect, those that decide first."""

        def promise(place: Place) -> float:
            means, variance = [], 0.0
            for i in self.comparison.cells_of(place):
                cell = self.comparison.cells[i]
                share = (float(cell.successes) + 0.5) / (cell.draws + 1)
                of_ratio = self.contrast == "ratio"
                means.append(log(share) + log(float(cell.high)) if of_ratio else share)
                variance += (1 - share) / share / (cell.draws + 1) if of_ratio else (1 - share) * share / (cell.draws + 1)
            return means[0] - means[1] + (2 if upper else -3) * sqrt(variance)

        return sorted(self.comparison.places, key=promise, reverse=True)

    def upper(self) -> tuple[Extended, list[list[str]] | None]:
        """The greatest upper end of a pair, and knots for every pair."""
        end: Extended = self.least
        for place in self.ranked(upper=True):
            if end > self.least and self.knots(place, Fraction(end), lower=False) is not None:
                continue
            pair, factor, level = self.pair(place, lower=False)
            end = max(end, pair_upper(pair, level).value * factor)
            if end >= self.greatest:
                return self.greatest, None
        for _ in range(LOOKED_AT):
            found = [self.knots(place, Fraction(end), lower=False) for place in self.comparison.places]
            if None not in found:
                return end, [[extended_text(q) for q in knots or ()] for knots in found]
            end = end * WIDER if self.contrast == "ratio" else end + (WIDER - 1) * self.width
        return self.greatest, None

    def lower(self) -> tuple[Fraction, dict[str, Any] | None]:
        """The greatest lower end of those pairs that are furthest apart, or that of the pair which one half chose, and its knots."""
        best, proof = self.least, None
        for place in self.ranked(upper=False)[:LOOKED_AT] if self.split is None else self.split.chosen:
            pair, factor, level = self.pair(place, lower=True)
            found = pair_upper(pair, level)
            if found.knots is None or (self.contrast == "ratio" and found.value <= 0):
                continue
            exchanged = Fraction(found.value) * factor
            value = 1 / exchanged if self.contrast == "ratio" else -exchanged
            if value > best:
                best, proof = value, {"pair": list(place), "knots": [extended_text(q) for q in found.knots]}
        return best, proof
