"""Intervals proven by ends of every mean: of a ratio of expected utilities, and of a difference of rates."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import chain, product

from .affine import Affine
from .intervals import METHODS, Box, BoxEvidence, DifferenceInterval, Interval, Unproven
from .rates import Share
from .rationals import INFINITY, ONE, as_pair, bits_of, over_common_denominator
from .samples import Comparison, forms_of
from .tails import Sample, fault_of_ends, log_form
from .text import shown
from .work import spend


def prove_difference(interval: DifferenceInterval, blocks: Sequence[Sequence[Share]]) -> None:
    """Make sure that the ends of all rates prove the interval of the greatest difference of two rates of one block."""
    samples = []
    for share in chain.from_iterable(blocks):
        if share.draws.denominator != 1 or share.positives.denominator != 1:
            raise Unproven("the counts are not integers")
        samples.append(Sample(share.draws.numerator, share.positives, share.positives, Fraction(0), Fraction(1), binary=True))
    beta, other = interval.levels
    if not 0 < other <= beta < 1:
        raise Unproven("the levels must be positive and less than 1, and that for the lower end no greater")
    # The pair with the greatest difference needs one end of each of its two rates; which pair proves the lower end depends on the draws.
    spent = 2 * beta + (2 * len(samples) - 2) * other
    if spent > 1 - interval.confidence:
        raise Unproven(f"the levels add up to {shown(as_pair(spent))}")
    for name, ends, level in (("upper", interval.upper, beta), ("lower", interval.lower, other)):
        if len(ends) != len(samples):
            raise Unproven(f"{name} must list the ends of {len(samples)} rates, not of {len(ends)}")
        for i, (sample, (lo, hi)) in enumerate(zip(samples, ends, strict=True)):
            if fault := fault_of_ends(sample, lo, hi, level, METHODS[0]):
                raise Unproven(f"{name}[{i}] {fault}")
    greatest, least, first = Fraction(0), Fraction(0), 0
    for block in blocks:
        outer, inner = (ends[first : first + len(block)] for ends in (interval.upper, interval.lower))
        first += len(block)
        greatest = max(greatest, _widest_gap([hi for _, hi in outer], [lo for lo, _ in outer]))
        least = max(least, _widest_gap([lo for lo, _ in inner], [hi for _, hi in inner]))
    low, high = (Fraction(*end) for end in interval.difference)
    if high < min(greatest, Fraction(1)):
        raise Unproven("two rates can be further apart than the upper end")
    if not 0 <= low <= least:
        raise Unproven("no two rates are surely as far apart as the lower end")


def _widest_gap(tops: Sequence[Fraction], bottoms: Sequence[Fraction]) -> Fraction:
    """The greatest top less the bottom of another one, of at least two."""
    low = sorted(range(len(bottoms)), key=bottoms.__getitem__)[:2]
    return max(top - bottoms[low[0] if i != low[0] else low[1]] for i, top in enumerate(tops))


def prove_by_box(interval: Interval, evidence: BoxEvidence, comparison: Comparison, used: int, spanned: int) -> None:
    samples, blocks = comparison.samples, comparison.blocks
    confidence = Fraction(*interval.confidence)
    beta, other = evidence.levels
    if not (0 < other <= beta < 1 if used else beta == other == 0):
        raise Unproven("the levels must be positive and less than 1, and that for the lower end no greater, or 0 where nothing was drawn")
    # One of the ends that matter is wrong with no greater probability than this.
    plain = spanned * beta + (2 * used - spanned) * other
    if plain > 1 - confidence and not (interval.independent and _all_hold(beta, other, used, spanned, confidence)):
        raise Unproven(f"the levels add up to {shown(as_pair(plain))}")
    for name, ends, level in (("upper", evidence.upper, beta), ("lower", evidence.lower, other)):
        if len(ends) != len(samples):
            raise Unproven(f"{name} must list the ends of {len(samples)} cells, not of {len(ends)}")
        for i, (sample, (lo, hi)) in enumerate(zip(samples, ends, strict=True)):
            if fault := fault_of_ends(sample, lo, hi, level, interval.method):
                raise Unproven(f"{name}[{i}] {fault}")
    low, high = interval.ratio
    if high != INFINITY:
        box = _scaled_box(evidence.upper)
        for number, block in enumerate(blocks):
            _check_block(block, number, Fraction(*high), box)
    if (low == ONE) is not (evidence.pair is None):
        raise Unproven("a pair has to be named exactly if the lower end is more than 1")
    if evidence.pair is not None:
        higher, lower = forms_of(evidence.pair, blocks)
        box = _scaled_box(evidence.lower)
        nothing = not any(box[i][0] for i in {*higher[0], *lower[0]})  # 0/0 is 1
        if nothing or not _at_most_times(lower, higher, Fraction(low[1], low[0]), box):
            raise Unproven("the least quotient of the pair is less than the lower end")


def _all_hold(beta: Fraction, other: Fraction, used: int, spanned: int, confidence: Fraction) -> bool:
    """Decide whether all ends that matter are right with the probability ``confidence``, when the cells are independent."""
    pair, rest = 1 - beta - other, 1 - 2 * other
    if pair <= 0 or rest <= 0:
        return False
    if used <= 1000:
        bits = used * (bits_of(pair) + bits_of(rest))
        spend(4, bits, bits + bits_of(confidence))
        return pair**spanned * rest ** (used - spanned) >= confidence
    return log_form([(Fraction(spanned), pair), (Fraction(used - spanned), rest), (Fraction(-1), confidence)]) >= 0


def _scaled_box(box: Box) -> list[tuple[int, int]]:
    """Multiply all ends by one number, which no quotient depends on."""
    ends, _ = over_common_denominator([as_pair(end) for ends in box for end in ends])
    return [*zip(ends[::2], ends[1::2], strict=True)]


def _at_most_times(one: Affine, other: Affine, ratio: Fraction, box: Sequence[tuple[int, int]]) -> bool:
    """Decide whether one form is at most ``ratio`` times another one everywhere in a box."""
    (w, w_unit), (v, v_unit) = one, other
    n, d = ratio.numerator * w_unit, ratio.denominator * v_unit
    units = w_unit.bit_length() + v_unit.bit_length()
    widest = max((box[i][1].bit_length() for i in w.keys() | v.keys()), default=0)
    spend(8 * (len(w) + len(v)), bits_of(ratio) + units, widest + units)
    greatest = 0
    for i in w.keys() | v.keys():
        coefficient = w.get(i, 0) * d - v.get(i, 0) * n
        greatest += coefficient * box[i][coefficient > 0]
    return greatest <= 0


def _check_block(block: Sequence[Affine], number: int, ratio: Fraction, box: Sequence[tuple[int, int]]) -> None:
    """Make sure that no form of a block can be more than ``ratio`` times another one."""
    ends = [(sum(c * box[i][side] for i, c in form.items()), unit) for side in (0, 1) for form, unit in block]
    values, unit = over_common_denominator(ends)
    spend(4 * len(values) + len(block) ** 2, max(map(int.bit_length, values)) + unit.bit_length(), 256 + bits_of(ratio))
    least = [ratio.numerator * value for value in values[: len(block)]]
    greatest = [ratio.denominator * value for value in values[len(block) :]]
    for (i, top), (j, bottom) in product(enumerate(greatest), enumerate(least)):
        # Most pairs are far from it, even if the cells that two forms share were different ones.
        if top > bottom and i != j and not _at_most_times(block[i], block[j], ratio, box):
            raise Unproven(f"forms {i} and {j} of block {number} can have a greater quotient than the upper end")
