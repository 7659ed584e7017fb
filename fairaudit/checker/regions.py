"""Intervals proven by a region that holds all means: a box of their ends, or a product by ladders.

A ladder is a list of knots between which the tails of two independent means are small together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from heapq import nlargest, nsmallest
from itertools import chain, pairwise, permutations, product, repeat
from math import prod
from typing import TypeVar

from .claims import METHODS
from .intervals import BoxEvidence, Ends, Interval, Ladder, LadderEvidence, Listed, PairEvidence, Place, Unproven
from .pair_exact import Pair, fault_of_ladder, order_scale
from .plain_ends import PlainEnds, completed
from .rationals import INFINITY, ONE, Affine, Rational, as_pair, at_most, bits_of, over_common_denominator
from .samples import Comparison
from .split import chosen_by, halves_of, seed_of
from .tails import PRECISION, Sample, Tail, are_far, fault_of_ends, log_form, reach_of, tail_rarity, tails_at_most
from .text import shown
from .work import spend

T = TypeVar("T")

GUARD = Fraction(4, 5)  # of the error of a product is for single means, the rest for two at once


def pair_at(place: Place, blocks: Sequence[Sequence[T]]) -> tuple[T, T]:
    """Find the two that a place names, the higher one first."""
    block, higher, lower = place
    if block >= len(blocks) or max(higher, lower) >= len(blocks[block]) or higher == lower:
        raise Unproven("the pair is not one that is compared")
    return blocks[block][higher], blocks[block][lower]


def check_named(ratio: tuple[Rational, Rational], pair: Place | None) -> None:
    """Make sure that a box names the pair that proves its lower end."""
    if (ratio[0] == ONE) is not (pair is None):
        raise Unproven("a pair has to be named exactly if the lower end is more than 1")


def check_given(ratio: tuple[Rational, Rational], upper: Sequence[Ladder] | None, lower: tuple[Place, Ladder] | None, blocks: int) -> None:
    """Make sure that there are the ladders that the ends of a ratio need."""
    if (ratio[1] == INFINITY) is not (upper is None) or (ratio[0] == ONE) is not (lower is None):
        raise Unproven("there must be ladders exactly for a finite upper end, and for a lower end of more than 1")
    if upper is not None and len(upper) != blocks:
        raise Unproven(f"there must be {blocks} ladders, not {len(upper)}")


def check_rising(knots: Ladder, where: str) -> None:
    """Make sure that knots are a ladder."""
    if not knots or knots[0] <= 0 or any(q <= p for p, q in pairwise(knots)):
        raise Unproven(f"{where} is not a strictly rising list of positive knots")


def prove_by_box(
    interval: Interval, evidence: BoxEvidence, comparison: Comparison, used: int, spanned: int, tops: Sequence[Sample] | None = None
) -> tuple[Ends, Ends]:
    """Make sure that ends of all means, which are given back, prove an interval of the ratio.

    ``used`` samples say something, and no two forms rest on more than ``spanned`` of them together.  Upper ends are those of
    ``tops``, where draws can have meant more than the samples say.
    """
    blocks = comparison.blocks
    outer, inner = check_box(interval, evidence, comparison.samples, used, spanned, tops)
    low, high = interval.ratio
    if high != INFINITY:
        box = scaled_box(outer)
        for number, block in enumerate(blocks):
            _check_block(block, number, Fraction(*high), box)
    if evidence.pair is not None:
        check_lower(low, *pair_at(evidence.pair, blocks), inner)
    return outer, inner


def check_lower(ratio: Rational, higher: Affine, lower: Affine, inner: Ends) -> None:
    """Make sure that one form is at least ``ratio`` times another one everywhere in a box."""
    box = scaled_box(inner)
    nothing = not any(box[i][0] for i in {*higher[0], *lower[0]})  # 0/0 is 1
    if nothing or not _at_most_times(lower, higher, Fraction(ratio[1], ratio[0]), box):
        raise Unproven("the least quotient of the pair is less than the lower end")


def check_box(
    interval: Interval, evidence: BoxEvidence, samples: Sequence[Sample], used: int, spanned: int, tops: Sequence[Sample] | None = None
) -> tuple[Ends, Ends]:
    """Make sure that the ends of means hold at their levels, which the confidence leaves room for; give back those of all means."""
    check_levels(interval, evidence, used, spanned)
    beta, other = evidence.levels
    for name, given, level in (("upper", evidence.upper, beta), ("lower", evidence.lower, other)):
        if isinstance(given, Listed):
            numbers, ends = given.cells, given.ends
            if numbers and numbers[-1] >= len(samples):
                raise Unproven(f"{name} lists the ends of a cell {numbers[-1]} of {len(samples)}")
        else:
            numbers, ends = [*range(len(samples))], given
            if len(ends) != len(samples):
                raise Unproven(f"{name} must list the ends of {len(samples)} cells, not of {len(ends)}")
        own = [samples[i] for i in numbers]
        if tops is None:
            check_ends(own, ends, level, interval.method, name)
        else:
            _check_outer_ends(own, [tops[i] for i in numbers], ends, level, interval.method, name)
    of_level = PlainEnds(beta, interval.method)
    high = samples if tops is None else tops
    return completed(evidence.upper, samples, high, of_level), completed(evidence.lower, samples, high, None)


def check_levels(interval: Interval, evidence: BoxEvidence, used: int, spanned: int) -> None:
    """Make sure that the confidence leaves room for the levels, and that a pair is named where the lower end needs one."""
    confidence = Fraction(*interval.confidence)
    beta, other = evidence.levels
    if not (0 < beta < 1 and 0 < other < 1 if used else beta == other == 0):
        raise Unproven("the levels must be positive and less than 1, or 0 where nothing was drawn")
    if not interval.each and spanned * beta != (2 * used - spanned) * other:  # or the draws could have chosen how to split the error
        raise Unproven(f"the level for the upper end must be {2 * used - spanned}/{spanned} times that for the lower one")
    # How likely the ends of a cell that matter are wrong, and of how many cells: for the upper end, for the lower one, and for both.
    of_upper, of_lower, of_both = [(beta, spanned)], [(2 * other, used)], [(beta + other, spanned), (2 * other, used - spanned)]
    for wrong in (of_upper, of_lower) if interval.each else (of_both,):
        plain = sum((error * cells for error, cells in wrong), Fraction(0))
        if plain > 1 - confidence and not (interval.independent and _all_hold(wrong, confidence)):
            raise Unproven(f"the levels add up to {shown(as_pair(plain))}")
    if not interval.difference:
        check_named(interval.ratio, evidence.pair)


def check_ends(samples: Sequence[Sample], listed: Ends, level: Fraction, method: str, name: str) -> None:
    """Make sure that the draws of some samples exclude what is beyond their ends: quickly of those far from it, else exactly."""
    reach = reach_of(level) if level else 0
    spend(40 * len(samples))
    for i, (sample, ends) in enumerate(zip(samples, listed, strict=True)):
        if level and (sample.binary or method == METHODS[0]) and are_far(sample, ends, reach):
            continue
        lo, hi = ends
        if fault := fault_of_ends(sample, Fraction(*lo), Fraction(*hi), level, method):
            raise Unproven(f"{name}[{i}] {fault}")


def _check_outer_ends(samples: Sequence[Sample], tops: Sequence[Sample], listed: Ends, level: Fraction, method: str, name: str) -> None:
    """Make sure that draws exclude what is below the lower ends, and the same draws at their most what is above the upper ones."""
    reach = reach_of(level) if level else 0
    spend(80 * len(samples))
    for i, (sample, top, (lo, hi)) in enumerate(zip(samples, tops, listed, strict=True)):
        for one, ends in ((sample, (lo, (sample.high_parts, sample.unit))), (top, ((top.low_parts, top.unit), hi))):
            if level and (one.binary or method == METHODS[0]) and are_far(one, ends, reach):
                continue
            if fault := fault_of_ends(one, Fraction(*ends[0]), Fraction(*ends[1]), level, method):
                raise Unproven(f"{name}[{i}] {fault}")
        if not at_most(lo, hi):
            raise Unproven(f"{name}[{i}] are not ends")


def _all_hold(wrong: Sequence[tuple[Fraction, int]], confidence: Fraction) -> bool:
    """Decide whether all ends that matter are right with the probability ``confidence``, when the cells are independent.

    ``wrong`` lists how likely those of a cell are wrong at most, and of how many cells that is so.
    """
    right = [(1 - error, cells) for error, cells in wrong]
    if any(chance <= 0 for chance, _ in right):
        return False
    used = sum(cells for _, cells in right)
    if used <= 1000:
        bits = used * sum(bits_of(chance) for chance, _ in right)
        spend(4, bits, bits + bits_of(confidence))
        return prod((chance**cells for chance, cells in right), start=Fraction(1)) >= confidence
    return log_form([*((Fraction(cells), chance) for chance, cells in right), (Fraction(-1), confidence)]) >= 0


def scaled_box(box: Ends) -> list[tuple[int, int]]:
    """Multiply all ends by one number, which no quotient depends on."""
    ends, _ = over_common_denominator([*chain.from_iterable(box)])
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


def _too_far_apart(ends: Mapping[int, tuple[int, int]], ratio: Fraction) -> tuple[int, int] | None:
    """Find two different means of which one can be more than ``ratio`` times the other one, if there are any, by their ends."""
    tops, bottoms = nlargest(2, ends, key=lambda i: ends[i][1]), nsmallest(2, ends, key=lambda i: ends[i][0])
    outer = [(tops[0], bottoms[0])] if tops[0] != bottoms[0] else [(tops[0], *bottoms[1:]), (*tops[1:], bottoms[0])]
    apart = (pair for pair in outer if len(pair) == 2 and ends[pair[0]][1] * ratio.denominator > ends[pair[1]][0] * ratio.numerator)
    return next(apart, None)


def _beyond(i: int, j: int, number: int) -> Unproven:
    return Unproven(f"forms {i} and {j} of block {number} can have a greater quotient than the upper end")


def check_single(ends: Sequence[tuple[int, int]], number: int, ratio: Fraction) -> None:
    """Make sure that no mean of different single cells can be more than ``ratio`` times another one of their block."""
    lows, highs = zip(*ends, strict=True)
    if max(highs) * ratio.denominator > min(lows) * ratio.numerator and (pair := _too_far_apart(dict(enumerate(ends)), ratio)):
        raise _beyond(*pair, number)


def _check_block(block: Sequence[Affine], number: int, ratio: Fraction, box: Sequence[tuple[int, int]]) -> None:
    """Make sure that no form of a block can be more than ``ratio`` times another one."""
    single = [i for form, unit in block if len(form) == 1 for i in form if form[i] == unit]
    if len(single) == len(block):  # then the greatest and the least end decide, of different cells
        spend(4 * len(block))
        if (pair := _too_far_apart({i: box[i] for i in single}, ratio)) is None:
            return
        raise _beyond(single.index(pair[0]), single.index(pair[1]), number)
    ends = [(sum(c * box[i][side] for i, c in form.items()), unit) for side in (0, 1) for form, unit in block]
    values, unit = over_common_denominator(ends)
    spend(4 * len(values) + len(block) ** 2, max(map(int.bit_length, values)) + unit.bit_length(), 256 + bits_of(ratio))
    least = [ratio.numerator * value for value in values[: len(block)]]
    greatest = [ratio.denominator * value for value in values[len(block) :]]
    for (i, top), (j, bottom) in product(enumerate(greatest), enumerate(least)):
        # Most pairs are far from it, even if the cells that two forms share were different ones.
        if top > bottom and i != j and not _at_most_times(block[i], block[j], ratio, box):
            raise _beyond(i, j, number)


def prove_by_ladders(interval: Interval, evidence: LadderEvidence, comparison: Comparison, used: int) -> None:
    """Make sure that ladders prove an interval of the ratio; ``used`` samples say something."""
    samples, blocks = comparison.samples, comparison.blocks
    if not interval.independent:
        raise Unproven("a product is for independent cells only")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in blocks for form, unit in block):
        raise Unproven("a product is for forms of a single cell only")
    if interval.method != "hoeffding-kl" and not all(sample.binary for sample in samples if sample.informative):
        raise Unproven("a product is for binary cells or hoeffding-kl only")
    (b, c), (other_b, other_c) = evidence.levels
    if not (b * b <= c <= b < 1 and other_b * other_b <= other_c <= other_b < 1):
        raise Unproven("the levels b, c must keep b^2 <= c <= b < 1")
    if not interval.each and (other_b > b or other_c > c):
        raise Unproven("the levels for the lower end must be no greater than those for the upper one")
    pairs = sum(len(block) * (len(block) - 1) for block in blocks)
    share = (1 - Fraction(*interval.confidence)) / (1 if interval.each else 2)
    of_lower = (2 * used, pairs) if interval.each else (max(2, 2 * used - 2), pairs - 1)  # ends of means, and pairs, that can be wrong
    for (level, product_level), (ends, products) in zip(evidence.levels, ((2, 1), of_lower), strict=True):
        if ends * level > GUARD * share or products * _area(level, product_level) > (1 - GUARD) * share:
            raise Unproven("the levels take more of the error than there is for them")
    members = [[next(iter(form)) for form, _ in block] for block in blocks]
    low, high = interval.ratio
    check_given(interval.ratio, evidence.upper, evidence.lower, len(blocks))
    if evidence.upper is not None:
        for number, (block, ladder) in enumerate(zip(members, evidence.upper, strict=True)):
            cells = {i: samples[i] for i in block}
            _check_ladder(ladder, cells, cells, Fraction(*high), b, c, f"upper[{number}]")
    if evidence.lower is not None:
        place, ladder = evidence.lower
        pair_at(place, blocks)
        higher, lower = members[place[0]][place[1]], members[place[0]][place[2]]
        if higher == lower:
            raise Unproven("the forms of the pair are equal")
        one, another = {lower: samples[lower]}, {higher: samples[higher]}
        _check_ladder(ladder, one, another, Fraction(low[1], low[0]), other_b, other_c, "lower")


def prove_by_pairs(interval: Interval, evidence: PairEvidence, comparison: Comparison, names: Sequence[Sequence[bytes]]) -> None:
    """Make sure that ladders prove an interval of the ratio, each of one ordered pair of cells of two-valued draws.

    The pair that attains the ratio is one, whatever is drawn; the pair that proves the lower end is one of all of them, or that which one
    half of the draws chooses, of cells with these names.
    """
    if not interval.independent:
        raise Unproven("the exact pair bound is for independent cells only")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in comparison.blocks for form, unit in block):
        raise Unproven("the exact pair bound is for forms of a single cell only")
    blocks = [[comparison.samples[next(iter(form))] for form, _ in block] for block in comparison.blocks]
    if any(not sample.binary or sample.low != 0 or sample.high <= 0 for block in blocks for sample in block):
        raise Unproven("the exact pair bound is for draws that are 0 or one positive number only")
    pairs = sum(len(block) * (len(block) - 1) for block in blocks)
    share = (1 - Fraction(*interval.confidence)) / (1 if interval.each else 2)
    least = share / (pairs if evidence.seed is None else 1)
    if evidence.levels != (share, least):
        raise Unproven(f"the levels must be {shown(as_pair(share))} and {shown(as_pair(least))}")
    # What orders the outcomes follows from the level of a one-sided end.
    upper, lower = (order_scale(level * (1 if interval.each else 2)) for level in evidence.levels)
    low, high = interval.ratio
    check_given(interval.ratio, evidence.upper, evidence.lower, pairs)
    if evidence.upper is not None:
        ordered = [pair for block in blocks for pair in permutations(block, 2)]
        for number, (pair, ladder) in enumerate(zip(ordered, evidence.upper, strict=True)):
            _check_pair(pair, Fraction(*high), share, upper, ladder, f"upper[{number}]")
    tested = blocks if evidence.seed is None else _second_halves(evidence, evidence.seed, names, blocks)
    if evidence.lower is not None:
        place, ladder = evidence.lower
        one, other = pair_at(place, tested)
        _check_pair((other, one), Fraction(low[1], low[0]), least, lower, ladder, "lower")


def _second_halves(evidence: PairEvidence, seed: str, names: Sequence[Sequence[bytes]], blocks: list[list[Sample]]) -> list[list[Sample]]:
    """Split the draws again: the halves that test, after making sure of the seed and that the other halves choose the pair."""
    counts = [[(_successes(sample), sample.draws) for sample in block] for block in blocks]
    if seed != seed_of(names, counts):
        raise Unproven("the seed is not that of the names and counts of the cells")
    if evidence.lower is None:
        return blocks
    halves = [[*map(halves_of, repeat(seed), *part)] for part in zip(names, counts, strict=True)]
    first = [[half for half, _ in block] for block in halves]
    if evidence.lower[0] != chosen_by(first, [[sample.high for sample in block] for block in blocks], names):
        raise Unproven("the first half chooses another pair")
    return [[_of_half(sample, *half) for sample, (_, half) in zip(*part, strict=True)] for part in zip(blocks, halves, strict=True)]


def _of_half(sample: Sample, successes: int, draws: int) -> Sample:
    """Some draws of a sample of those that are 0 or another number."""
    total, squares = (successes * sample.high_parts**power for power in (1, 2))
    return sample._replace(draws=draws, total_parts=total, squares_parts=squares)


def _successes(sample: Sample) -> int:
    """Count the draws that are not 0."""
    number = sample.total / sample.high
    if number.denominator != 1:
        raise Unproven("the counts are not integers")
    return number.numerator


def _check_pair(pair: tuple[Sample, Sample], ratio: Fraction, level: Fraction, scale: Fraction, knots: Ladder, where: str) -> None:
    """Make sure that knots prove that one mean is less than ``ratio`` times another one."""
    one, other = pair
    k, m = map(_successes, pair)
    spend(8, bits_of(ratio), bits_of(one.high, other.high))
    fault = fault_of_ladder(Pair((k, one.draws), (m, other.draws), scale, False), ratio * other.high / one.high, level, knots)
    if fault:
        raise Unproven(f"{where} {fault}")


def _area(b: Fraction, c: Fraction) -> Fraction:
    """Bound the probability that independent uniform u and v exceed b while uv is at most c: c log(c/b^2) - c + b^2."""
    if b == 0:
        return Fraction(0)
    return c * Fraction(-log_form([(Fraction(1), b * b / c)]), 1 << PRECISION) - c + b * b


def _check_ladder(
    knots: Ladder, tops: Mapping[int, Sample], bottoms: Mapping[int, Sample], ratio: Fraction, b: Fraction, c: Fraction, where: str
) -> None:
    """Make sure that a ladder proves of all different tops and bottoms that the mean of the top is at most ``ratio`` times the other."""
    check_rising(knots, where)
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
