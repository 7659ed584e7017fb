"""Intervals proven by ladders: knots between which the tails of two independent means are small together."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise

from .intervals import Interval, Ladder, LadderEvidence, Unproven
from .rationals import INFINITY, ONE, bits_of
from .samples import Comparison, forms_of
from .tails import PRECISION, Sample, Tail, log_form, tail_rarity, tails_at_most
from .work import spend


def prove_by_ladders(interval: Interval, evidence: LadderEvidence, comparison: Comparison, used: int) -> None:
    samples, blocks = comparison.samples, comparison.blocks
    if not interval.independent:
        raise Unproven("a product is for independent cells only")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in blocks for form, unit in block):
        raise Unproven("a product is for forms of a single cell only")
    if interval.method != "hoeffding-kl" and not all(sample.binary for sample in samples if sample.informative):
        raise Unproven("a product is for binary cells or hoeffding-kl only")
    (b, c), (other_b, other_c) = evidence.levels
    if not (b * b <= c <= b < 1 and other_b * other_b <= other_c <= other_b <= b and other_c <= c):
        raise Unproven("the levels b, c must keep b^2 <= c <= b < 1, and those for the lower end must be no greater")
    pairs = sum(len(block) * (len(block) - 1) for block in blocks)
    spent = 2 * b + max(2, 2 * used - 2) * other_b + _area(b, c) + (pairs - 1) * _area(other_b, other_c)
    if spent > 1 - Fraction(*interval.confidence):
        raise Unproven("the levels add up to more than the confidence leaves")
    members = [[next(iter(form)) for form, _ in block] for block in blocks]
    low, high = interval.ratio
    if (high == INFINITY) is not (evidence.upper is None) or (low == ONE) is not (evidence.lower is None):
        raise Unproven("there must be ladders exactly for a finite upper end, and for a lower end of more than 1")
    if evidence.upper is not None:
        if len(evidence.upper) != len(blocks):
            raise Unproven(f"there must be {len(blocks)} ladders, not {len(evidence.upper)}")
        for number, (block, ladder) in enumerate(zip(members, evidence.upper, strict=True)):
            cells = {i: samples[i] for i in block}
            _check_ladder(ladder, cells, cells, Fraction(*high), b, c, f"upper[{number}]")
    if evidence.lower is not None:
        place, ladder = evidence.lower
        forms_of(place, blocks)
        higher, lower = members[place[0]][place[1]], members[place[0]][place[2]]
        if higher == lower:
            raise Unproven("the forms of the pair are equal")
        one, another = {lower: samples[lower]}, {higher: samples[higher]}
        _check_ladder(ladder, one, another, Fraction(low[1], low[0]), other_b, other_c, "lower")


def _area(b: Fraction, c: Fraction) -> Fraction:
    """Bound the probability that independent uniform u and v exceed b while uv is at most c: c log(c/b^2) - c + b^2."""
    if b == 0:
        return Fraction(0)
    return c * Fraction(-log_form([(Fraction(1), b * b / c)]), 1 << PRECISION) - c + b * b


def _check_ladder(
    knots: Ladder, tops: Mapping[int, Sample], bottoms: Mapping[int, Sample], ratio: Fraction, b: Fraction, c: Fraction, where: str
) -> None:
    """Make sure that a ladder proves of all different tops and bottoms that the mean of the top is at most ``ratio`` times the other."""
    if not knots or knots[0] <= 0 or any(q <= p for p, q in pairwise(knots)):
        raise Unproven(f"{where} is not a strictly rising list of positive knots")
    for sample in bottoms.values():
        if knots[0] > sample.low and not (sample.informative and tails_at_most([sample.tail(knots[0], False)], b)):
            raise Unproven(f"{where} begins too high")
    for sample in tops.values():
        mean = ratio * knots[-1]
        if mean < sample.high and not (sample.informative and tails_at_most([sample.tail(mean, True)], b)):
            raise Unproven(f"{where} ends too low")
    certain: Tail = (1, Fraction(1), Fraction(1, 2), True)
    for number, (p, q) in enumerate(pairwise(knots)):
        spend(250 * (len(tops) + len(bottoms)), bits_of(ratio), bits_of(p))
        above = {i: s.tail(ratio * p, True) if s.informative else certain for i, s in tops.items() if ratio * p < s.high}
        below = {i: s.tail(q, False) if s.informative else certain for i, s in bottoms.items()}
        # For each top the likeliest bottom of another index is one of the two likeliest of all.
        likeliest = sorted((rarity, i) for i, tail in below.items() if (rarity := tail_rarity(tail)) is not None)[:2]
        for i, tail in above.items():
            bottom = next((j for _, j in likeliest if j != i), None)
            if bottom is not None and not tails_at_most([tail, below[bottom]], c):
                raise Unproven(f"{where} has too wide a step after knot {number}")
