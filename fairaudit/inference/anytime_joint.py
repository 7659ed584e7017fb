"""The joint region of a stream, for cells that are a martingale together: bets on the draws of two cells at once.

To exclude "μ_x ≥ r·μ_y" of two cells, for a supposed mean q of y (utilities scaled to [0, 1] by the greatest one),

    e(q) = Σ w Π(1 − λ(x − r·q)) Π(1 + λ'(y − q))

over bets (λ, λ') that were fixed in advance. At q = μ_y this is a nonnegative supermartingale, so the ratio r is excluded, for ever, once
e(q) ≥ 1/c for every q from the least mean to min(1, 1/r). Each bet is log-concave in q, hence between two knots at least the lesser of its
values at them; the sum of those is what a ladder proves. Searched in floats, proved in integers.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise, permutations
from math import inf, log

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.inference.anytime_product import StreamProduct
from fairaudit.inference.anytime_search import MAX_KNOTS, decimal_near
from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.levels import PairLevels
from fairaudit.inference.rounding import Number, number_below, power_below, product_below, sum_below

JOINT = tuple(Fraction(1, 2**k) for k in range(1, 8))

SINGLE = (Fraction(1, 4), Fraction(1, 2))

CAP = Fraction(15, 16)

SLACK = 0.02  # of the logarithm of what was won, for the steps between knots

POINTS = 300  # of a first grid of means, and of a second one where the first is least

LARGEST = 1e9  # a greater ratio is not looked for

Bet = tuple[Fraction, Fraction, Fraction]
Limits = tuple[Fraction, Fraction]


def joint_bets(ratios: Sequence[Fraction]) -> list[Bet]:
    """The bets on the cell that is supposed to be the higher one and on the other one, each with its share of the money.

    Examples
    --------
    >>> bets = joint_bets([Fraction(1), Fraction(5, 4)])
    >>> len(bets), sum(share for _, _, share in bets), bets[7][:2]
    (18, Fraction(1, 1), (Fraction(1, 2), Fraction(5, 8)))
    """
    joint = [(bet, min(CAP, ratio * bet), Fraction(4, 5) / (len(JOINT) * len(ratios))) for ratio in ratios for bet in JOINT]
    nothing, share = Fraction(0), Fraction(1, 20)
    return joint + [(bet, nothing, share) for bet in SINGLE] + [(nothing, bet, share) for bet in SINGLE]


def joint_log_wealth(
    higher: tuple[Floats, Floats], lower: tuple[Floats, Floats], ratio: float, means: Floats, bets: Sequence[Bet]
) -> Floats:
    """Logarithm of what each bet has won, its share included, at some means of the lower cell: shape (bets, means). In floats.

    Parameters
    ----------
    higher, lower : pair of ndarray
        Values in [0, 1] and how often each was drawn.
    ratio : float
        By how much the mean of the first is supposed to be greater at least.
    means : ndarray
        Supposed means of the second.
    bets : sequence
        As `joint_bets` lists them.
    """
    one, other, shares = (np.array([float(bet[k]) for bet in bets]) for k in range(3))
    found: Floats = np.repeat(np.log(shares)[:, None], len(means), axis=1)
    for (values, counts), bet, sign, centre in ((higher, one, -1.0, ratio * means), (lower, other, 1.0, means)):
        for value, n in zip(values, counts, strict=True):
            found = found + n * np.log1p(sign * bet[:, None] * (value - centre))
    return found


def _log_sum(logs: Floats) -> Floats:
    top = logs.max(axis=0)
    return np.asarray(top + np.log(np.exp(logs - top).sum(axis=0)))


class JointSearch:
    """Ends of the ratio that joint bets prove, and ladders that could prove them, in floats.

    Parameters
    ----------
    cells : list of list of ValueCounts
        What was drawn, by blocks, scaled to [0, 1] by the greatest utility.
    levels : list of dict
        The level of each pair of a block.
    limits : pair of Fraction
        The range of the utility.
    bets : list
        As `joint_bets` lists them.
    """

    def __init__(self, cells: list[list[ValueCounts]], levels: PairLevels, limits: Limits, bets: list[Bet]) -> None:
        self.cells, self.levels, self.limits, self.bets = cells, levels, limits, bets
        self.least, self.top = float(limits[0] / limits[1]), float(limits[1])

    def upper(self) -> tuple[float, tuple[int, int, int] | None]:
        """Least r such that μ_i ≤ r·μ_j is proved for all pairs, at least 1, and the block, i and j that need it."""
        best, where = 1.0, None
        for _, b, i, j in sorted(self._pairs(), reverse=True):
            if best < inf and not self._excluded(b, i, j, best):
                best, where = self._smallest(b, i, j, best), (b, i, j)
        return best, where

    def lower(self) -> tuple[float, tuple[int, int, int] | None]:
        """Greatest proved R with μ_j ≥ R·μ_i, and the block, the higher j and the lower i."""
        best, where = 1.0, None
        for ratio, b, i, j in sorted(self._pairs()):
            if ratio < best and self._excluded(b, i, j, best):
                low, high = max(ratio, 1 / LARGEST), best
                while high > low * (1 + 1e-7):
                    middle = (low * high) ** 0.5
                    low, high = (low, middle) if self._excluded(b, i, j, middle) else (middle, high)
                best, where = high, (b, j, i)
        return 1 / best, where

    def ladder(self, b: int, pairs: Sequence[tuple[int, int]], ratio: Fraction) -> list[Fraction] | None:
        """Knots that should prove μ_i ≤ ratio·μ_j for all of some pairs of a block, or None if floats see none."""
        low, most = self.limits[0], min(self.limits[1], self.limits[1] / ratio)
        if ratio * low >= self.limits[1]:
            return [self.limits[1]]
        knots, at = list[Fraction](), low
        while len(knots) < MAX_KNOTS:
            before = [self._logs(b, i, j, float(ratio), np.array([float(at) / self.top])) for i, j in pairs]
            near, far = float(at), float(most)
            for _ in range(4):
                tried = np.linspace(near, far, 25)[1:]
                held = np.ones(len(tried), dtype=bool)
                for (i, j), own in zip(pairs, before, strict=True):
                    logs = np.minimum(own, self._logs(b, i, j, float(ratio), tried / self.top))
                    held &= _log_sum(logs) >= self._need(b, i, j) + 1e-7
                if held.all():
                    near = far
                    break
                first = int(np.argmin(held))
                near, far = (near if not first else float(tried[first - 1])), float(tried[first])
            if near >= float(most):
                return knots or [(low + most) / 2]
            if near <= float(at) or near <= 0:
                return None
            knot = decimal_near(near, up=False, digits=12)
            if not at < knot < most:
                return None
            knots.append(knot)
            at = knot
        return None

    def _pairs(self) -> list[tuple[float, int, int, int]]:
        """All ordered pairs, with the quotient of their means."""
        found = []
        for b, block in enumerate(self.cells):
            means = [float(cell.mean) for cell in block]
            for i, j in permutations(range(len(block)), 2):
                found.append((means[i] / means[j] if means[j] else inf if means[i] else 1.0, b, i, j))
        return found

    def _smallest(self, b: int, i: int, j: int, low: float) -> float:
        high = 2 * low
        while not self._excluded(b, i, j, high):
            low, high = high, high**2 if high > 64 else 2 * high
            if low > LARGEST:
                return inf
        while high > low * (1 + 1e-7):
            middle = (low * high) ** 0.5
            low, high = (low, middle) if self._excluded(b, i, j, middle) else (middle, high)
        return high

    def _excluded(self, b: int, i: int, j: int, ratio: float) -> bool:
        """Whether joint bets exclude μ_i ≥ ratio·μ_j, in floats."""
        most = min(1.0, 1 / ratio)
        if most <= self.least:
            return True
        grid = self._angles(self.least, most)
        won = _log_sum(self._logs(b, i, j, ratio, grid))
        at, need = int(won.argmin()), self._need(b, i, j) + SLACK
        if won[at] < need:
            return False
        closer = self._angles(float(grid[max(0, at - 1)]), float(grid[min(at + 1, len(grid) - 1)]))
        return bool(_log_sum(self._logs(b, i, j, ratio, closer)).min() >= need)

    def _angles(self, low: float, high: float) -> Floats:
        return np.asarray(np.sin(np.linspace(np.arcsin(low**0.5), np.arcsin(high**0.5), POINTS)) ** 2)

    def _logs(self, b: int, i: int, j: int, ratio: float, means: Floats) -> Floats:
        return joint_log_wealth(self.cells[b][i].arrays, self.cells[b][j].arrays, ratio, means, self.bets)

    def _need(self, b: int, i: int, j: int) -> float:
        return -log(float(self.levels[b][frozenset((i, j))]))


class StreamJoint(StreamProduct):
    """Joint bets on two cells: narrower than products where utilities are not rare, for cells that are a martingale together.

    Parameters
    ----------
    cells : list of list of ValueCounts
        What was drawn, by blocks, scaled to [0, 1] by the range.
    ranks : list of list of int
        The ranks of the cells in order of first appearance.
    expected : int
        About how many cells were expected.
    limits : pair of Fraction
        The range of the utility.
    alpha : Fraction
        The error.
    ratios : sequence of Fraction
        How much greater bets on the lower cell are.
    """

    def __init__(
        self,
        cells: list[list[ValueCounts]],
        ranks: list[list[int]],
        expected: int,
        limits: Limits,
        alpha: Fraction,
        ratios: Sequence[Fraction],
    ) -> None:
        super().__init__(cells, ranks, expected, limits, alpha)
        self.bets = joint_bets(ratios)
        low, high = limits
        self.scaled = [
            [ValueCounts({(low + (high - low) * value) / high: n for value, n in cell.counts.items()}) for cell in block] for block in cells
        ]
        self.search: JointSearch = JointSearch(self.scaled, self.levels, limits, self.bets)  # type: ignore[assignment]
        self._known: dict[tuple[int, int, bool, Fraction], list[Number]] = {}

    def _holds(self, b: int, pairs: Sequence[tuple[int, int]], knots: Sequence[Fraction], ratio: Fraction) -> bool:
        low, top = self.limits
        most = min(top, top / ratio)
        if ratio * low >= top:
            return True
        points = [low, *knots, most]
        for i, j in pairs:
            level = self.levels[b][frozenset((i, j))]
            won = [self._won(b, i, j, ratio, point) for point in points]
            for before, after in pairwise(won):
                least = [min(one, other, key=_as_order) for one, other in zip(before, after, strict=True)]
                m, e = sum_below(least)
                reached = m * level.numerator
                if (reached << e if e >= 0 else reached) < (level.denominator if e >= 0 else level.denominator << -e):
                    return False
        return True

    def _won(self, b: int, i: int, j: int, ratio: Fraction, point: Fraction) -> list[Number]:
        top = self.limits[1]
        one, other = self._products(b, i, True, ratio * point / top), self._products(b, j, False, point / top)
        shares = [number_below(share) for _, _, share in self.bets]
        return [product_below(share, product_below(x, y)) for share, x, y in zip(shares, one, other, strict=True)]

    def _products(self, b: int, cell: int, higher: bool, mean: Fraction) -> list[Number]:
        key = b, cell, higher, mean
        if key not in self._known:
            made: dict[Fraction, Number] = {}
            for bets in self.bets:
                bet = bets[0 if higher else 1]
                if bet not in made:
                    made[bet] = (1, 0)
                    for value, n in self.scaled[b][cell].counts.items():
                        factor = number_below(1 + (mean - value if higher else value - mean) * bet)
                        made[bet] = product_below(made[bet], power_below(factor, n))
            self._known[key] = [made[bets[0 if higher else 1]] for bets in self.bets]
        return self._known[key]


def _as_order(number: Number) -> tuple[int, Fraction]:
    m, e = number
    return m.bit_length() + e, Fraction(m, 1 << m.bit_length())
