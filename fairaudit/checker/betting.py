"""Intervals for a stream, at every moment: by the wealth of bets against a mean."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise, permutations

from .header import Cell
from .intervals import Box, Interval, Ladder, StreamEvidence, Unproven
from .rationals import INFINITY, ONE, as_pair, at_most, bits_of
from .regions import check_given, check_named, check_rising, pair_at
from .samples import compared_cells, whole_counts
from .table import Table
from .text import shown
from .work import keep, spend

BETS = range(-16, 5)  # the shares that are bet are 2 to these powers, but at most CAP / mean
IDLE = Fraction(1, 32)  # of the money is never bet
CAP = Fraction(15, 16)  # of the money is bet at most, so that no draw takes all of it
MANTISSA = 160  # bits of a wealth and of what it is computed from, rounded down

Tally = dict[Fraction, int]  # how often each utility was drawn, scaled to [0, 1]
Wealth = tuple[int, int]  # m, e: a number of at least m 2^e
Levels = list[dict[int, Fraction]]  # by block, and by the rank of the later cell of a pair


def _share(bet: int) -> Fraction:
    """The part of the money that goes into a bet."""
    return Fraction(29, 20) / ((abs(bet + 2) + 2) * (abs(bet + 2) + 3))


def _trimmed(mantissa: int, exponent: int) -> Wealth:
    excess = max(0, mantissa.bit_length() - MANTISSA)
    return mantissa >> excess, exponent + excess


def _floored(value: Fraction) -> Wealth:
    n, d = value.numerator, value.denominator
    shift = max(0, MANTISSA + d.bit_length() - n.bit_length())
    return _trimmed((n << shift) // d, -shift)


def _power(base: Wealth, exponent: int) -> Wealth:
    """Raise to a power, every step rounded down."""
    result: Wealth = (1, 0)
    for digit in bin(exponent)[2:]:
        result = _trimmed(result[0] ** 2, 2 * result[1])
        if digit == "1":
            result = _trimmed(result[0] * base[0], result[1] + base[1])
    return result


def _wealth(tally: Tally, mean: Fraction) -> Wealth:
    """Bound from below what bets that the mean is greater than this one have won: mean > 0."""
    found = [_floored(IDLE)]
    bits = bits_of(mean) + max(map(bits_of, tally), default=0)
    spend(len(BETS) * (60 + sum(60 + 8 * n.bit_length() for n in tally.values())), bits, bits)
    a, b = mean.numerator, mean.denominator
    for power in BETS:
        bet = min(Fraction(2) ** power, CAP / mean)
        m, e = _floored(_share(power))
        for value, n in tally.items():
            below = bet.denominator * value.denominator * b
            above = below + bet.numerator * (value.numerator * b - a * value.denominator)  # 1 + bet (value - mean), over below
            excess = max(0, MANTISSA + below.bit_length() - above.bit_length())
            base, shift = _power(_trimmed((above << excess) // below, -excess), n)
            m, e = _trimmed(m * base, e + shift)
        found.append((m, e))
    least = max(m.bit_length() + e for m, e in found) - 2 * MANTISSA
    return _trimmed(sum(m << e - least if e >= least else m >> least - e for m, e in found), least)


def _reach(one: Wealth, other: Wealth, level: Fraction) -> bool:
    """Decide whether the product of two wealths is at least 1/level."""
    spend(10, bits_of(level), MANTISSA)
    m, e = one[0] * other[0] * level.numerator, one[1] + other[1]
    if (excess := m.bit_length() + e - level.denominator.bit_length()) not in (0, 1):
        return excess > 0
    return m << e >= level.denominator if e >= 0 else m >= level.denominator << -e


class StreamProof:
    """What the counts of a stream prove."""

    def __init__(self, interval: Interval, evidence: StreamEvidence, table: Table) -> None:
        self.interval, self.evidence = interval, evidence
        if table.header.subject.kind != "counts":
            raise Unproven("the table is not of the stated kind")
        if interval.independent or interval.limits is None or interval.limits[0] == interval.limits[1]:
            raise Unproven("a stream has a declared range with different limits, and cells that are not declared independent")
        self.low, self.high = interval.limits
        pools = compared_cells(interval.quantity, table)
        if not pools:
            raise Unproven("the table does not give this quantity")
        self.blocks = [[self._tally(cells, table) for cells in block] for block in pools]
        if len(evidence.order) != sum(map(len, self.blocks)):
            raise Unproven(f"the ranks of {sum(map(len, self.blocks))} cells must be listed, not of {len(evidence.order)}")
        ranks = iter(evidence.order)
        self.ranks = [[next(ranks) for _ in block] for block in self.blocks]
        self.error = 1 - Fraction(*interval.confidence)
        self.known: dict[tuple[int, int, Fraction, bool], Wealth] = {}

    def _tally(self, cells: Iterable[Cell], table: Table) -> Tally:
        tally: Tally = {}
        for cell in cells:
            for count, g in zip(whole_counts(cell, table), cell.utility, strict=True):
                if count and g is not None:
                    value = (Fraction(*g) - self.low) / (self.high - self.low)
                    tally[value] = tally.get(value, 0) + count
        return tally

    def _share(self, rank: int, expected: int) -> Fraction:
        """The part of the error for the cell, or pairs, of some rank: over all ranks these add up to 1."""
        return Fraction(expected, (rank + expected - 1) * (rank + expected))

    def _wealth(self, block: int, cell: int, mean: Fraction, above: bool) -> Wealth:
        """What a cell proves of its mean: that it is above, or below, another one inside the range."""
        key = block, cell, mean, above
        if key not in self.known:
            keep(20, bits_of(mean))
            tally, scaled = self.blocks[block][cell], (mean - self.low) / (self.high - self.low)
            self.known[key] = _wealth(tally, scaled) if above else _wealth({1 - value: n for value, n in tally.items()}, 1 - scaled)
        return self.known[key]

    def prove(self) -> None:
        """Make sure that the evidence proves the interval."""
        low, high = self.interval.ratio
        if not at_most(ONE, low) or not at_most(ONE, high):
            raise Unproven("no ratio is less than 1")
        if self.evidence.ends is not None:
            self._prove_by_box(self.evidence.ends)
        else:
            self._prove_by_ladders()

    def _prove_by_box(self, ends: Box) -> None:
        if len(ends) != len(self.evidence.order):
            raise Unproven(f"upper must list the ends of {len(self.evidence.order)} cells, not of {len(ends)}")
        remaining = iter(ends)
        box = [[next(remaining) for _ in block] for block in self.blocks]
        for b, block in enumerate(box):
            for i, (lo, hi) in enumerate(block):
                level = self.error * self._share(self.ranks[b][i], self.evidence.expected) / 2
                if not self.low <= lo <= hi <= self.high:
                    raise Unproven(f"the ends of cell {i} of block {b} are not ends in its range")
                if lo > self.low and not _reach(self._wealth(b, i, lo, True), (1, 0), level):
                    raise Unproven(f"the lower end {shown(as_pair(lo))} of cell {i} of block {b} is not excluded")
                if hi < self.high and not _reach(self._wealth(b, i, hi, False), (1, 0), level):
                    raise Unproven(f"the upper end {shown(as_pair(hi))} of cell {i} of block {b} is not excluded")
        low, high = (Fraction(*end) if end != INFINITY else None for end in self.interval.ratio)
        for b, block in enumerate(box):
            spend(20 * len(block) ** 2)
            for i, j in permutations(range(len(block)), 2):
                if high is not None and block[i][1] > high * block[j][0]:
                    raise Unproven(f"cells {i} and {j} of block {b} can have a greater quotient than the upper end")
        check_named(self.interval.ratio, self.evidence.pair)
        if self.evidence.pair is not None and low is not None:
            pair_at(self.evidence.pair, self.blocks)
            b, i, j = self.evidence.pair
            if not box[b][i][0] >= low * box[b][j][1] > 0:
                raise Unproven("the least quotient of the pair is less than the lower end")

    def levels(self) -> Levels:
        """For each block, the level of a pair, in either direction, by the rank of the later one of its cells.

        The cells that found others in their block share out the error in the order in which they came; each divides its part
        among the two directions of its pairs with those that it found.
        """
        first = [min(ranks) for ranks in self.ranks]
        later = sorted(rank for ranks, least in zip(self.ranks, first, strict=True) for rank in ranks if rank > least)
        number = {rank: i for i, rank in enumerate(later, 1)}
        expected = (self.evidence.expected + 1) // 2
        return [
            {last: self.error * self._share(number[last], expected) / (2 * found) for found, last in enumerate(sorted(ranks)) if found}
            for ranks in self.ranks
        ]

    def _prove_by_ladders(self) -> None:
        levels = self.levels()
        low, high = self.interval.ratio
        ladders, proof = self.evidence.ladders, self.evidence.proof
        check_given(self.interval.ratio, ladders, proof, len(self.blocks))
        if ladders is not None:
            for b, ladder in enumerate(ladders):
                keep(4 * len(self.blocks[b]) ** 2)
                pairs = [*permutations(range(len(self.blocks[b])), 2)]
                self._check_ladder(ladder, b, pairs, Fraction(*high), levels, f"upper[{b}]")
        if proof is not None:
            pair_at(proof[0], self.blocks)
            b, higher, lower = proof[0]
            self._check_ladder(proof[1], b, [(lower, higher)], Fraction(low[1], low[0]), levels, "lower")

    def _check_ladder(self, knots: Ladder, b: int, pairs: Sequence[tuple[int, int]], ratio: Fraction, levels: Levels, where: str) -> None:
        """Make sure that a ladder proves of pairs (top, bottom) that the mean of the top is at most ``ratio`` times the other."""
        check_rising(knots, where)
        idle = _floored(IDLE)
        steps: list[tuple[Fraction | None, Fraction | None]] = [*pairwise(knots)]
        if knots[0] > self.low:
            steps.append((None, knots[0]))
        if knots[-1] < self.high:
            steps.append((knots[-1], None))
        for p, q in steps:
            # The mean of the bottom is from p to q, that of the top more than ratio p.
            if p is not None and ratio * p >= self.high:
                continue
            top = None if p is None or ratio * p <= self.low else ratio * p
            bottom = None if q is None or q <= self.low else q
            tops = {i: idle if top is None else self._wealth(b, i, top, False) for i in {i for i, _ in pairs}}
            bottoms = {j: idle if bottom is None else self._wealth(b, j, bottom, True) for j in {j for _, j in pairs}}
            for i, j in pairs:
                if not _reach(tops[i], bottoms[j], levels[b][max(self.ranks[b][i], self.ranks[b][j])]):
                    raise Unproven(f"{where} does not hold between the knots {shown(p and as_pair(p))} and {shown(q and as_pair(q))}")
