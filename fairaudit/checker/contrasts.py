"""Intervals of ratios by bets on the contrasts of independent cells, each ordered pair of them by itself."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations

from .intervals import ContrastEvidence, Interval, Unproven
from .rationals import INFINITY, as_pair, bits_of
from .regions import check_named, pair_at
from .samples import Comparison
from .symmetric_betting import Tally, proves_below
from .tails import Sample
from .text import shown
from .work import spend

Drawn = tuple[Sample, Tally]  # what was drawn in a cell, and how often each value, as a part of the greatest one there could be


def prove_by_contrasts(interval: Interval, evidence: ContrastEvidence, comparison: Comparison) -> None:
    """Make sure that bets on the contrast of each ordered pair of cells prove an interval of the ratio.

    The pair that attains the ratio is one, whatever is drawn; the pair that proves the lower end is one of all of them.
    """
    if not interval.independent:
        raise Unproven("contrasts of cells are for independent cells only")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in comparison.blocks for form, unit in block):
        raise Unproven("contrasts of cells are for forms of a single cell only")
    if not comparison.tallies:
        raise Unproven("contrasts of cells are for tables of counts only")
    if any(sample.low < 0 or sample.high <= 0 or not sample.draws for sample in comparison.samples):
        raise Unproven("contrasts of cells are for cells with draws, of which none is worth less than nothing and some could be worth more")
    pairs = sum(len(block) * (len(block) - 1) for block in comparison.blocks)
    share = (1 - Fraction(*interval.confidence)) / (1 if interval.each else 2)
    if evidence.levels != (share, share / pairs):
        raise Unproven(f"the levels must be {shown(as_pair(share))} and {shown(as_pair(share / pairs))}")
    drawn = [_scaled(sample, tally) for sample, tally in zip(comparison.samples, comparison.tallies, strict=True)]
    blocks = [[drawn[next(iter(form))] for form, _ in block] for block in comparison.blocks]
    low, high = interval.ratio
    check_named(interval.ratio, evidence.pair)
    if high != INFINITY:
        for number, block in enumerate(blocks):
            for (i, one), (j, other) in permutations(enumerate(block), 2):
                if not _is_below(one, other, Fraction(*high), share):
                    raise Unproven(f"forms {i} and {j} of block {number} can have a greater quotient than the upper end")
    if evidence.pair is not None:
        higher, lower = pair_at(evidence.pair, blocks)
        if not _is_below(lower, higher, Fraction(low[1], low[0]), share / pairs):
            raise Unproven("the pair does not prove the lower end")


def _scaled(sample: Sample, tally: Tally) -> Drawn:
    spend(4 * len(tally), max(map(bits_of, tally), default=0), bits_of(sample.high))
    return sample, {value / sample.high: n for value, n in tally.items()}


def _is_below(one: Drawn, other: Drawn, limit: Fraction, level: Fraction) -> bool:
    """Decide whether the mean of one cell is at most a multiple of that of another, which their ranges may say by themselves."""
    (sample, tally), (base, values) = one, other
    spend(12, bits_of(limit), bits_of(sample.high, base.low, base.high))
    if sample.high <= limit * base.low:
        return True
    return proves_below(tally, values, limit * base.high / sample.high, level)
