"""Intervals for a stream, at every moment: by what bets on the draws of two cells at once have won."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise, permutations

from .betting import StreamProof
from .intervals import Interval, Ladder, StreamEvidence, Unproven
from .paired_betting import Wealth, power, quotient, reaches, times, total
from .rationals import ONE, as_pair, at_most, bits_of
from .regions import check_given, check_rising, pair_at
from .table import Table
from .text import shown
from .work import keep, spend

JOINT = [Fraction(1, 2**k) for k in range(1, 8)]  # bets on the one cell; those on the other are some ratios times as great
CAP = Fraction(15, 16)  # but no greater than this
SINGLE = [Fraction(1, 4), Fraction(1, 2)]  # bets on one cell alone
JOINTLY, SINGLY = Fraction(4, 5), Fraction(1, 20)  # the share of all joint bets together, and of each single one
NONE = Fraction(0)


def bets_of(ratios: Sequence[Fraction]) -> list[tuple[Fraction, Fraction, Fraction]]:
    """List the bets: on the cell that is said to be the higher one, on the other one, and the share of the money."""
    joint = [(bet, min(CAP, ratio * bet), JOINTLY / (len(JOINT) * len(ratios))) for ratio in ratios for bet in JOINT]
    return joint + [(bet, NONE, SINGLY) for bet in SINGLE] + [(NONE, bet, SINGLY) for bet in SINGLE]


def prove_stream(interval: Interval, evidence: StreamEvidence, table: Table) -> None:
    """Make sure that the evidence of a stream proves its interval."""
    proof = StreamProof(interval, evidence, table)
    if evidence.ratios:
        JointProof(proof, evidence.ratios).prove()
    else:
        proof.prove()


class JointProof:
    """What the counts of a stream prove by joint bets."""

    def __init__(self, proof: StreamProof, ratios: Sequence[Fraction]) -> None:
        self.proof, self.bets = proof, bets_of(ratios)
        self.top = proof.high
        self.tallies = [
            [{(proof.low + (proof.high - proof.low) * value) / self.top: n for value, n in tally.items()} for tally in block]
            for block in proof.blocks
        ]
        self.known: dict[tuple[int, int, bool, Fraction], list[Wealth]] = {}

    def prove(self) -> None:
        """Make sure that the evidence proves the interval."""
        low, high = self.proof.interval.ratio
        if not at_most(ONE, low) or not at_most(ONE, high):
            raise Unproven("no ratio is less than 1")
        evidence, blocks = self.proof.evidence, self.proof.blocks
        check_given(self.proof.interval.ratio, evidence.ladders, evidence.proof, len(blocks))
        levels = self.proof.levels()
        if evidence.ladders is not None:
            for b, ladder in enumerate(evidence.ladders):
                keep(4 * len(blocks[b]) ** 2)
                self._check(ladder, b, [*permutations(range(len(blocks[b])), 2)], Fraction(*high), levels[b], f"upper[{b}]")
        if evidence.proof is not None:
            pair_at(evidence.proof[0], blocks)
            b, higher, lower = evidence.proof[0]
            self._check(evidence.proof[1], b, [(lower, higher)], Fraction(low[1], low[0]), levels[b], "lower")

    def _check(
        self, knots: Ladder, b: int, pairs: Sequence[tuple[int, int]], ratio: Fraction, levels: dict[int, Fraction], where: str
    ) -> None:
        """Make sure that knots prove of pairs (higher, lower) that the mean of the first is less than ``ratio`` times the other."""
        check_rising(knots, where)
        most = min(self.top, self.top / ratio)
        if ratio * self.proof.low >= self.top:  # so it is for all means in the range
            return
        if not self.proof.low < knots[0] <= knots[-1] < most:
            raise Unproven(f"{where} has a knot that is not between {shown(as_pair(self.proof.low))} and {shown(as_pair(most))}")
        points = [self.proof.low, *knots, most]
        ranks = self.proof.ranks[b]
        for i, j in pairs:
            level = levels[max(ranks[i], ranks[j])]
            won = [self._won(b, i, j, ratio, point) for point in points[:1]]
            for p, q in pairwise(points):
                won = [won[-1], self._won(b, i, j, ratio, q)]
                spend(40 * len(self.bets), 128, 128)
                least = [
                    times(_lesser(one, other), quotient(*as_pair(share))) for one, other, (_, _, share) in zip(*won, self.bets, strict=True)
                ]
                if not reaches(total(least), level):
                    raise Unproven(f"{where} does not hold between {shown(as_pair(p))} and {shown(as_pair(q))} for cells {i} and {j}")

    def _won(self, b: int, i: int, j: int, ratio: Fraction, point: Fraction) -> list[Wealth]:
        """What each bet has won if the mean of the lower cell is here, and that of the higher one at least ``ratio`` times as great."""
        against, upon = self._products(b, i, True, ratio * point / self.top), self._products(b, j, False, point / self.top)
        return [times(one, other) for one, other in zip(against, upon, strict=True)]

    def _products(self, b: int, cell: int, higher: bool, mean: Fraction) -> list[Wealth]:
        """What the draws of one cell contribute to each bet: against a mean of the higher cell, or upon the lower one's being greater."""
        key = b, cell, higher, mean
        if key not in self.known:
            tally = self.tallies[b][cell]
            different = {bet[0] if higher else bet[1] for bet in self.bets}
            bits = bits_of(mean) + max(map(bits_of, tally), default=0) + max(map(bits_of, different))
            spend(len(different) * (60 + sum(60 + 8 * n.bit_length() for n in tally.values())), bits, bits)
            keep(2 * len(self.bets) + bits // 256)
            made = {bet: _product(tally, -bet if higher else bet, mean) for bet in different}
            self.known[key] = [made[bet[0] if higher else bet[1]] for bet in self.bets]
        return self.known[key]


def _product(tally: dict[Fraction, int], bet: Fraction, mean: Fraction) -> Wealth:
    found: Wealth = (1, 0)
    for value, n in tally.items():
        factor = 1 + bet * (value - mean)
        found = times(found, power(quotient(factor.numerator, factor.denominator), n))
    return found


def _lesser(one: Wealth, other: Wealth) -> Wealth:
    if not one[0] or not other[0]:
        return (0, 0)
    difference = one[0].bit_length() + one[1] - other[0].bit_length() - other[1]
    if difference:
        return one if difference < 0 else other
    least = min(one[1], other[1])
    return one if one[0] << one[1] - least <= other[0] << other[1] - least else other
