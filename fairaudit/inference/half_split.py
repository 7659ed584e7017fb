"""The half-split: one half of the draws chooses a pair of cells, the other half tests it alone, at the full error.

Given the first half the pair is fixed, and the second half is independent of it, so that the test needs no correction for many pairs. Which
draws are in which half follows from the counts by SHA-256, as docs/certificate-samples.md says byte by byte: neither the order of a log nor
that of a table has a say, and other counts have another split.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from hashlib import sha256
from itertools import permutations

from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.pair_exact import score_ends

MOST_DRAWS = 10**6
"""Of all cells together: a reader hashes each."""

SCALE = Fraction(4)  # z² of the score ends by which the first half chooses

Counts = tuple[int, int]
"""Successes and draws."""


@dataclass(frozen=True)
class HalfSplit:
    """The halves of the draws of independent cells of two values.

    Attributes
    ----------
    comparison : Comparison
        What is compared, with labels; every form is one cell.

    Examples
    --------
    >>> from fairaudit.inference.table_comparisons import local_comparison
    >>> from fairaudit.model.law import Law
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> split = HalfSplit(local_comparison(law, Utility({"yes": 1}).on(law)))
    >>> split.seed[:8], split.halves(0), split.chosen
    ('4b8c1619', ((45, 50), (45, 50)), [(0, 0, 1)])
    """

    comparison: Comparison

    @cached_property
    def names(self) -> list[bytes]:
        """The canonical text of the labels of each cell."""
        found = [b""] * len(self.comparison.cells)
        for block, (context, groups) in zip(self.comparison.blocks, self.comparison.labels, strict=True):
            for ((i, _),), group in zip(block, groups, strict=True):
                label = {"context": context, "group": group}
                found[i] = json.dumps(label, ensure_ascii=True, sort_keys=True, separators=(",", ":")).encode("ascii")
        return found

    @cached_property
    def seed(self) -> str:
        """The digest of the labels and counts of all cells, in the order of their names."""
        lines = [b"%b %d %d\n" % (self.names[i], *self.counts(i)) for block in self.comparison.blocks for ((i, _),) in block]
        return sha256(b"".join(sorted(lines))).hexdigest()

    def counts(self, cell: int) -> Counts:
        """How many draws of a cell are the greater value, and how many there are."""
        own = self.comparison.cells[cell]
        return int(own.successes), own.draws

    def halves(self, cell: int) -> tuple[Counts, Counts]:
        """The half of a cell's draws that chooses, no greater than the other, and the one that tests."""
        k, n = self.counts(cell)
        start = bytes.fromhex(self.seed) + sha256(self.names[cell]).digest()
        ranks = [sha256(start + i.to_bytes(8, "big")).digest() for i in range(n)]  # the draws in order of their values
        first = sorted(range(n), key=ranks.__getitem__)[: n // 2]
        chosen = sum(i >= n - k for i in first)
        return (chosen, n // 2), (k - chosen, n - n // 2)

    @cached_property
    def chosen(self) -> list[tuple[int, int, int]]:
        """The block and the positions of the pair that the first half finds furthest apart; none if no two cells have draws there.

        That is the one with the greatest quotient of the lower score end of the first cell over the upper one of the second; ties go to the
        first names.
        """
        best: tuple[Fraction, bytes, bytes] | None = None
        found: list[tuple[int, int, int]] = []
        for b, block in enumerate(self.comparison.blocks):
            cells = [form[0][0] for form in block]
            ends = [self._ends(i) for i in cells]
            for one, other in permutations(range(len(cells)), 2):
                top, bottom = ends[one], ends[other]
                if top is None or bottom is None:
                    continue
                promise = top[0] / bottom[1], self.names[cells[one]], self.names[cells[other]]
                if best is None or promise[0] > best[0] or (promise[0] == best[0] and promise[1:] < best[1:]):
                    best, found = promise, [(b, one, other)]
        return found

    def _ends(self, cell: int) -> tuple[Fraction, Fraction] | None:
        """Score ends of the mean of a cell's first half."""
        k, n = self.halves(cell)[0]
        lower, upper = score_ends(k, n, SCALE) if n else (0, 0)
        high = self.comparison.cells[cell].high
        return (lower * high, upper * high) if n else None
