"""The product region of a stream, for cells that are a martingale together.

Two cells are compared by the product of the wealth against one mean and the wealth against the other, again a supermartingale, so that
all pairs of means whose product reaches 1/β are excluded. The ends are found in floats (`anytime_search`) and proved in integers here, by
ladders; the proofs are in docs/certificate-monitor.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise, permutations
from math import inf
from typing import Any

from fairaudit.exact.extended import extended_text
from fairaudit.inference.anytime_search import PairSearch, decimal_near
from fairaudit.inference.betting import IDLE, ValueCounts, wealth, wealth_reaches
from fairaudit.inference.interval import Places
from fairaudit.inference.levels import pair_levels
from fairaudit.inference.rounding import Number, number_below

ATTEMPTS = 8  # to prove an end that floats found, each at twice the distance from it


class StreamProduct:
    """Products of the wealths of two cells: narrower, for cells that are a martingale together."""

    places: Places = (None, None)

    def __init__(
        self, cells: list[list[ValueCounts]], ranks: list[list[int]], expected: int, limits: tuple[Fraction, Fraction], alpha: Fraction
    ) -> None:
        self.cells, self.limits = cells, limits
        self.levels = pair_levels(ranks, expected, alpha)
        self.search = PairSearch(cells, self.levels, limits)

    def estimate(self) -> tuple[Fraction, Fraction | float]:
        """Both ends of the ratio in floats, for a display."""
        lower, pair = self.search.lower()
        upper, outer = self.search.upper()
        self.places = pair, outer
        return Fraction(lower), Fraction(upper) if upper < inf else inf

    def places_of(self, evidence: Mapping[str, Any]) -> Places:
        """Where the pairs behind both ends are that a certificate stores."""
        return None if evidence["lower"] is None else evidence["lower"]["pair"], self.search.upper()[1]

    def prove(self) -> tuple[Fraction, Fraction | float, dict[str, Any]]:
        """Both ends of the ratio, proved, with their evidence."""
        upper, ladders, outer = self._prove_upper()
        lower, proof = self._prove_lower()
        self.places = None if proof is None else proof["pair"], outer
        return lower, upper, {"upper": ladders, "lower": proof}

    def _prove_upper(self) -> tuple[Fraction | float, list[list[str]] | None, tuple[int, int, int] | None]:
        ratio, where = self.search.upper()
        for attempt in range(ATTEMPTS):
            if ratio == inf:
                break
            exact = max(Fraction(1), decimal_near(ratio, up=True))
            ladders = []
            for b, block in enumerate(self.cells):
                ladder = self._ladder(b, list(permutations(range(len(block)), 2)), exact)
                if ladder is None:
                    break
                ladders.append([extended_text(knot) for knot in ladder])
            else:
                return exact, ladders, where
            ratio *= 1 + 0.002 * 2**attempt
        return inf, None, where

    def _prove_lower(self) -> tuple[Fraction, dict[str, Any] | None]:
        ratio, where = self.search.lower()
        for attempt in range(ATTEMPTS):
            exact = decimal_near(ratio, up=False)
            if where is None or exact <= 1:
                break
            b, higher, lower = where
            ladder = self._ladder(b, [(lower, higher)], 1 / exact)
            if ladder is not None:
                return exact, {"pair": [b, higher, lower], "knots": [extended_text(knot) for knot in ladder]}
            ratio /= 1 + 0.002 * 2**attempt
        return Fraction(1), None

    def _ladder(self, b: int, pairs: Sequence[tuple[int, int]], ratio: Fraction) -> list[Fraction] | None:
        """Knots that prove μ_i ≤ ratio·μ_j for all of some pairs i, j of a block, or None."""
        knots = self.search.ladder(b, pairs, ratio)
        return knots if knots is not None and self._holds(b, pairs, knots, ratio) else None

    def _holds(self, b: int, pairs: Sequence[tuple[int, int]], knots: Sequence[Fraction], ratio: Fraction) -> bool:
        """Whether the knots prove it, in integers: between any two of them the wealths at the outer means reach the level together."""
        low, high = self.limits
        idle = number_below(IDLE)
        levels = self.levels[b]

        def below(i: int, mean: Fraction) -> Number | None:
            """Wealth of a top against a mean; None if its mean cannot be so great."""
            return None if mean >= high else idle if mean <= low else wealth(self.cells[b][i], (mean - low) / (high - low), "below")

        def above(j: int, mean: Fraction) -> Number:
            """Wealth of a bottom against a mean."""
            return idle if mean <= low else wealth(self.cells[b][j], (mean - low) / (high - low), "above")

        tops, bottoms = sorted({i for i, _ in pairs}), sorted({j for _, j in pairs})
        before: list[tuple[Fraction | None, Fraction | None]] = [(None, knots[0])]
        before += pairwise(knots)
        before.append((knots[-1], None))
        for p, q in before:
            if (p is None and q is not None and q <= low) or (q is None and p is not None and p >= high):
                continue
            ups = {i: idle if p is None else below(i, ratio * p) for i in tops}
            downs = {j: idle if q is None else above(j, q) for j in bottoms}
            for i, j in pairs:
                one = ups[i]
                if one is not None and not wealth_reaches([one, downs[j]], levels[frozenset((i, j))]):
                    return False
        return True
