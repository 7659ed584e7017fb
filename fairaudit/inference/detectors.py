"""Change by an e-detector: pairs of decisions of two groups, and sums of bets that a ratio is above a limit from some moment on.

Of two groups i and j the next unpaired decision of the other group completes a pair; extras are dropped. For "E_i/E_j is above R*" let
Z = (g_i/R* − g_j)/γ ≥ −1 and

    M_n = (M_{n−1} + 1)(1 + λZ_n),  M_0 = 0,

for each bet λ; it is the sum, over all moments at which the ratio might have changed, of what a bet since then has won. While
E_i ≤ R*·E_j, E[Z_n | past] ≤ 0, so M_n − n is a supermartingale. With K directions (ordered pairs of groups) the mean M of all bets and
directions rises by at most 2/K in the mean whenever a pair serves both of its directions; let n be the sum of those, the pairs per
direction. M − n is a supermartingale, so an alarm at M ≥ B comes after B pairs per direction or more in the mean, and before the n-th with
probability at most n/B. A pair must come about whatever its first decision was. All steps round down; n is rounded up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import exp
from typing import Any

from fairaudit.exact.enclosures import compare_log
from fairaudit.inference.pairing import Moment, Pairing
from fairaudit.words import brief

BETS = 6  # λ = 1/2, 1/4, …, 1/64

BITS = 64  # of the fraction of a sum

ONE = 1 << BITS

CACHED = 100_000  # pairs of values whose factors are remembered


@brief
@dataclass(frozen=True, repr=False)
class Detection:
    """An alarm: the mean of two groups has come apart by more than the limit.

    Attributes
    ----------
    higher, lower : int
        The numbers of the two members.
    since : tuple of (int, float or None)
        The first decision after which the bets did best: the estimated moment.
    pairs : Fraction
        Pairs per direction until the alarm: by then a false one has come with probability at most this over the run length.
    directions : int
        How many directions were watched.
    """

    higher: int
    lower: int
    since: Moment
    pairs: Fraction
    directions: int


@dataclass
class _Direction:
    """The sums of one direction by bets, and of each the best product since some moment."""

    sums: list[int] = field(default_factory=lambda: [0] * BETS)
    best: list[int] = field(default_factory=lambda: [ONE] * BETS)
    since: list[Moment] = field(default_factory=lambda: [(0, None)] * BETS)

    def learn(self, factors: Sequence[int], first: Moment) -> int:
        """Take a pair in; returns by how much the sums rose together."""
        sums, best = self.sums, self.best
        before = sum(sums)
        for k, factor in enumerate(factors):
            sums[k] = (sums[k] + ONE) * factor >> BITS
            if best[k] <= ONE:
                best[k], self.since[k] = ONE, first
            best[k] = best[k] * factor >> BITS
        return sum(sums) - before


class Detector:
    """Watches all ordered pairs of the members of each block.

    Parameters
    ----------
    limit : Fraction
        R*, at least 1.
    gamma : Fraction
        The greatest utility; the least is at least 0.
    run_length : int
        B, pairs per direction to a false alarm, in the mean, at least.
    kept : list, optional
        What `kept` returned: goes on from there.

    Examples
    --------
    >>> detector = Detector(Fraction(5, 4), Fraction(1), 1000)
    >>> for k in range(400):
    ...     for member, value in ((1, Fraction(1)), (2, Fraction(k % 2))):
    ...         found = detector.take("job", member, value, (k, None))
    ...         if found:
    ...             break
    ...     else:
    ...         continue
    ...     break
    >>> found.higher, found.lower, found.since, found.pairs
    (1, 2, (0, None), Fraction(61, 1))
    """

    def __init__(self, limit: Fraction, gamma: Fraction, run_length: int, kept: Sequence[Any] | None = None) -> None:
        self.limit, self.gamma, self.run_length = limit, gamma, run_length
        self._directions: dict[tuple[int, int], tuple[_Direction, _Direction]] = {}
        self._factors: dict[tuple[Fraction, Fraction], tuple[int, ...]] = {}
        self._elapsed: int = kept[0] if kept else 0
        pairs: Sequence[Any] = kept[1] if kept else ()
        self._pairing = Pairing(pair[:5] for pair in pairs)
        for a, b, _, _, _, complete, *directions in pairs:
            if complete:
                forth, back = (_Direction(sums, best, [tuple(at) for at in since]) for sums, best, since in directions)
                self._directions[a, b] = forth, back
        self._total = sum(sum(direction.sums) for both in self._directions.values() for direction in both)

    @property
    def directions(self) -> int:
        """How many directions are watched: two of each pair of members with a pair of decisions."""
        return 2 * len(self._directions)

    @property
    def pairs(self) -> Fraction:
        """Pairs per direction so far, rounded up."""
        return Fraction(self._elapsed, ONE)

    def kept(self) -> list[Any]:
        """All that is to be remembered, as JSON can hold it; its size is that of the table, whatever the number of decisions."""
        pairs = []
        for a, b, *open_pair in self._pairing.kept():
            both = self._directions.get((a, b))
            sums = [[one.sums, one.best, [list(at) for at in one.since]] for one in both or (_Direction(), _Direction())]
            pairs.append([a, b, *open_pair, both is not None, *sums])
        return [self._elapsed, pairs]

    def join(self, block: Any, member: int) -> None:
        """Make a member known; members join in the same order whenever a watch is resumed."""
        self._pairing.join(block, member)

    def take(self, block: Any, member: int, value: Fraction, at: Moment) -> Detection | None:
        """Take a decision in; returns the alarm, if it raises one.

        Parameters
        ----------
        block : hashable
            Within which members are compared.
        member : int
            Whose decision it is.
        value : Fraction
            Its utility.
        at : tuple of (int, float or None)
            Its number, and its time.
        """
        completed = self._pairing.take(block, member, value, at)
        for pair in completed:
            if pair.members not in self._directions:
                self._directions[pair.members] = _Direction(), _Direction()
            self._elapsed += -(-2 * ONE // self.directions)
            forth, back = self._directions[pair.members]
            self._total += forth.learn(self._betting(pair.one, pair.other), pair.first)
            self._total += back.learn(self._betting(pair.other, pair.one), pair.first)
        reached = completed and self._total >= self.run_length * self.directions * BETS << BITS
        return self._detection() if reached else None

    def _betting(self, higher: Fraction, lower: Fraction) -> tuple[int, ...]:
        """1 + λZ for each bet, in units of 2^−64, rounded down."""
        found = self._factors.get((higher, lower))
        if found is None:
            if len(self._factors) >= CACHED:
                self._factors.clear()
            z = (higher / self.limit - lower) / self.gamma
            found = tuple(ONE + (z.numerator << BITS - k) // z.denominator for k in range(1, BETS + 1))
            self._factors[higher, lower] = found
        return found

    def _detection(self) -> Detection:
        in_order = sorted(self._directions.items(), key=lambda item: item[0])
        sides = [side for (a, b), (forth, back) in in_order for side in (((a, b), forth), ((b, a), back))]
        (higher, lower), direction = max(sides, key=lambda side: sum(side[1].sums))
        bet = max(range(BETS), key=direction.best.__getitem__)
        return Detection(higher, lower, direction.since[bet], self.pairs, self.directions)


def ratio_above(limit: Fraction, unit: str) -> Fraction | None:
    """The least ratio that is known not to be under a limit on the ratio or its logarithm; None where no ratio is as great as that.

    Examples
    --------
    >>> ratio_above(Fraction(5, 4), "ratio"), round(float(ratio_above(Fraction(1, 5), "log")), 6), ratio_above(Fraction(10**6), "log")
    (Fraction(5, 4), 1.221403, None)
    """
    if unit == "ratio":
        return limit
    if limit > 500:
        return None
    ratio = Fraction(exp(float(limit)))
    while compare_log((ratio.numerator, ratio.denominator), (limit.numerator, limit.denominator)) < 0:
        ratio *= 1 + Fraction(1, 2**40)
    return ratio
