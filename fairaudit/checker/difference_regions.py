"""Intervals of differences proven by a region that holds all means: a box of their ends, or ladders of pairs of cells."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import permutations

from .intervals import Box, BoxEvidence, Interval, Ladder, PairEvidence, Unproven
from .pair_exact import Pair, fault_of_ladder, order_scale
from .rationals import Affine, as_pair, bits_of
from .regions import check_box, pair_at
from .samples import Comparison
from .tails import Sample
from .text import shown
from .work import spend


def prove_difference_by_box(interval: Interval, evidence: BoxEvidence, comparison: Comparison, used: int, spanned: int) -> None:
    """Make sure that ends of all means prove an interval of the greatest difference of two forms of one block.

    As for a ratio, the pair with the greatest difference needs one end of each of its means; which pair proves the lower end depends on
    the draws.
    """
    boxes = check_box(interval, evidence, comparison.samples, used, spanned)
    low, high = (Fraction(*end) for end in interval.ratio)
    outer, inner = ([(Fraction(*lo), Fraction(*hi)) for lo, hi in box] for box in boxes)
    for block in comparison.blocks:
        if _widest(block, outer, True) > high:
            raise Unproven("two means can be further apart than the upper end")
    if not low >= 0 or (low > 0 and not any(_widest(block, inner, False) >= low for block in comparison.blocks)):
        raise Unproven("no two means are surely as far apart as the lower end")


def _widest(block: Sequence[Affine], box: Box, upper: bool) -> Fraction:
    """The greatest difference that two forms of a block can have in a box, or the greatest one that they surely have."""
    if all(len(form) == 1 and [*form.values()] == [unit] for form, unit in block):
        ends = [box[next(iter(form))] for form, _ in block]
        spend(4 * len(ends), max(bits_of(*both) for both in ends))
        tops, bottoms = ([each[side] for each in ends] for side in (upper, not upper))
        low = sorted(range(len(bottoms)), key=bottoms.__getitem__)[:2]
        return max(top - bottoms[low[0] if i != low[0] else low[1]] for i, top in enumerate(tops))
    return max(_apart(one, other, box, upper) for one, other in permutations(block, 2))


def _apart(one: Affine, other: Affine, box: Box, upper: bool) -> Fraction:
    """The greatest, or the least, difference of two forms in a box."""
    (w, w_unit), (v, v_unit) = one, other
    units = w_unit.bit_length() + v_unit.bit_length()
    found = Fraction(0)
    for i in w.keys() | v.keys():
        coefficient = w.get(i, 0) * v_unit - v.get(i, 0) * w_unit
        end = box[i][(coefficient > 0) is upper]
        spend(8, units, bits_of(end) + bits_of(found))
        found += coefficient * end
    return found / (w_unit * v_unit)


def prove_difference_by_pairs(interval: Interval, evidence: PairEvidence, comparison: Comparison) -> None:
    """Make sure that ladders prove an interval of the greatest difference, each of one ordered pair of cells of two-valued draws.

    The two values are the same in all cells, so that a difference of means is their distance times a difference of shares.
    """
    if not interval.independent or evidence.seed is not None:
        raise Unproven("the exact pair bound of a difference is for independent cells, all of whose pairs share the error")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in comparison.blocks for form, unit in block):
        raise Unproven("the exact pair bound is for forms of a single cell only")
    blocks = [[comparison.samples[next(iter(form))] for form, _ in block] for block in comparison.blocks]
    ranges = {(sample.low, sample.high) for block in blocks for sample in block}
    if len(ranges) != 1 or any(not sample.binary or not sample.low < sample.high for block in blocks for sample in block):
        raise Unproven("the exact pair bound of a difference is for draws of two values only, the same two in all cells")
    [(bottom, top)] = ranges
    width = top - bottom
    pairs = sum(len(block) * (len(block) - 1) for block in blocks)
    share = (1 - Fraction(*interval.confidence)) / (1 if interval.each else 2)
    if evidence.levels != (share, share / pairs):
        raise Unproven(f"the levels must be {shown(as_pair(share))} and {shown(as_pair(share / pairs))}")
    # What orders the outcomes follows from the level of a one-sided end.
    upper, lower = (order_scale(level * (1 if interval.each else 2)) for level in evidence.levels)
    low, high = (Fraction(*end) for end in interval.ratio)
    if low < 0 or (low == 0) is not (evidence.lower is None):
        raise Unproven("there must be a ladder for a lower end exactly if it is more than 0")
    if evidence.upper is None:
        if high < width:
            raise Unproven("there must be ladders for an upper end that is less than the range of a draw")
    else:
        ordered = [pair for block in blocks for pair in permutations(block, 2)]
        if len(evidence.upper) != len(ordered):
            raise Unproven(f"there must be {len(ordered)} ladders, not {len(evidence.upper)}")
        for number, (pair, ladder) in enumerate(zip(ordered, evidence.upper, strict=True)):
            _check_pair(pair, high / width, share, upper, ladder, f"upper[{number}]")
    if evidence.lower is not None:
        place, ladder = evidence.lower
        one, other = pair_at(place, blocks)
        _check_pair((other, one), -low / width, share / pairs, lower, ladder, "lower")


def _check_pair(pair: tuple[Sample, Sample], limit: Fraction, level: Fraction, scale: Fraction, knots: Ladder, where: str) -> None:
    """Make sure that knots prove that the share of one cell is less than ``limit`` above that of another one."""
    one, other = pair
    successes = [(sample.total - sample.draws * sample.low) / (sample.high - sample.low) for sample in pair]
    if any(k.denominator != 1 for k in successes):
        raise Unproven(f"the counts of {where} are not integers")
    k, m = (number.numerator for number in successes)
    spend(8, bits_of(limit), bits_of(one.low, one.high))
    fault = fault_of_ladder(Pair((k, one.draws), (m, other.draws), scale, True), limit, level, knots)
    if fault:
        raise Unproven(f"{where} {fault}")
