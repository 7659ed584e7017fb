"""Intervals of differences by bets on the contrasts of independent cells, each ordered pair of them by itself."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations

from .intervals import ContrastEvidence, Interval, Unproven
from .rationals import as_pair, bits_of
from .regions import pair_at
from .samples import Comparison
from .symmetric_betting import proves_below
from .text import shown
from .work import spend


def prove_difference_by_contrasts(interval: Interval, evidence: ContrastEvidence, comparison: Comparison) -> None:
    """Make sure that bets on the contrast of each ordered pair of cells prove an interval of the greatest difference.

    The range of a draw is the same in all cells, so that a difference of means is its width times one on the scale from 0 to 1. Nothing
    exceeds the width.
    """
    if not interval.independent:
        raise Unproven("contrasts of cells are for independent cells only")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in comparison.blocks for form, unit in block):
        raise Unproven("contrasts of cells are for forms of a single cell only")
    ranges = {(sample.low, sample.high) for sample in comparison.samples}
    if not comparison.tallies or len(ranges) != 1 or any(not sample.informative for sample in comparison.samples):
        raise Unproven("contrasts of a difference are for tables of counts only, whose cells have draws and one range")
    [(bottom, top)] = ranges
    width = top - bottom
    pairs = sum(len(block) * (len(block) - 1) for block in comparison.blocks)
    share = (1 - Fraction(*interval.confidence)) / (1 if interval.each else 2)
    if evidence.levels != (share, share / pairs):
        raise Unproven(f"the levels must be {shown(as_pair(share))} and {shown(as_pair(share / pairs))}")
    for tally in comparison.tallies:
        spend(6 * len(tally), max(map(bits_of, tally), default=0), bits_of(bottom, width))
    drawn = [{(value - bottom) / width: n for value, n in tally.items()} for tally in comparison.tallies]
    blocks = [[drawn[next(iter(form))] for form, _ in block] for block in comparison.blocks]
    low, high = (Fraction(*end) for end in interval.ratio)
    if low < 0 or (low == 0) is not (evidence.pair is None):
        raise Unproven("a pair has to be named exactly if the lower end is more than 0")
    for number, block in enumerate(blocks if high < width else []):
        for (i, one), (j, other) in permutations(enumerate(block), 2):
            if not proves_below(one, other, high / width, share, difference=True):
                raise Unproven(f"forms {i} and {j} of block {number} can be further apart than the upper end")
    if evidence.pair is not None:
        higher, lower = pair_at(evidence.pair, blocks)
        if not proves_below(lower, higher, -low / width, share / pairs, difference=True):
            raise Unproven("the pair does not prove the lower end")
