"""The box of a stream: ends of every cell by itself, which hold at every moment."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any

from fairaudit.exact.extended import extended_text
from fairaudit.exact.rationals import quotient
from fairaudit.inference.betting import ValueCounts, betting_end
from fairaudit.inference.interval import Places
from fairaudit.inference.levels import arrival_levels


class StreamBox:
    """Ends of every cell by itself: nothing is assumed of cells together."""

    places: Places = (None, None)

    def __init__(
        self, cells: list[list[ValueCounts]], ranks: list[list[int]], expected: int, limits: tuple[Fraction, Fraction], alpha: Fraction
    ) -> None:
        self.cells, self.limits = cells, limits
        self.levels = arrival_levels(ranks, expected, alpha)

    def _ends(self, *, exact: bool) -> list[list[tuple[Fraction, Fraction]]]:
        low, high = self.limits
        found = []
        for block, levels in zip(self.cells, self.levels, strict=True):
            unit = [
                (betting_end(cell, level, "above", exact), betting_end(cell, level, "below", exact))
                for cell, level in zip(block, levels, strict=True)
            ]
            found.append([(low + (high - low) * a, low + (high - low) * b) for a, b in unit])
        return found

    def _ratios(self, ends: list[list[tuple[Fraction, Fraction]]]) -> tuple[Fraction, Fraction | float, list[int] | None]:
        lower, pair, outer = Fraction(1), None, None
        means = [[low + (high - low) * cell.mean for cell in block] for low, high in [self.limits] for block in self.cells]
        unequal: Fraction | float = 0
        greatest: Fraction | float = Fraction(1)
        for b, block in enumerate(ends):
            for i, j in permutations(range(len(block)), 2):
                most, apart = quotient(block[i][1], block[j][0]), quotient(means[b][i], means[b][j])
                if most > greatest or (most == greatest == inf and apart > unequal):
                    greatest, outer, unequal = most, [b, i, j], apart
                least = block[i][0] / block[j][1] if block[j][1] else Fraction(0)
                if least > lower:
                    lower, pair = least, [b, i, j]
        self.places = pair, outer
        return lower, greatest, pair

    def places_of(self, evidence: Mapping[str, Any]) -> Places:
        """Where the pairs behind both ends are that a certificate stores."""
        listed = iter([(Fraction(a), Fraction(b)) for a, b in evidence["upper"]])
        self._ratios([[next(listed) for _ in block] for block in self.cells])
        return evidence["pair"], self.places[1]

    def estimate(self) -> tuple[Fraction, Fraction | float]:
        """Both ends of the ratio in floats, for a display."""
        return self._ratios(self._ends(exact=False))[:2]

    def prove(self) -> tuple[Fraction, Fraction | float, dict[str, Any]]:
        """Both ends of the ratio, proved, with their evidence."""
        ends = self._ends(exact=True)
        lower, upper, pair = self._ratios(ends)
        listed = [[extended_text(a), extended_text(b)] for block in ends for a, b in block]
        return lower, upper, {"upper": listed, "lower": listed, "pair": pair}
