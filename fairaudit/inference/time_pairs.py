"""Pairs in time: bounds of ratios of means that may move, by bets on the contrast of decisions that were made next to each other.

Where means move with time and the mix of groups does too, pooled means compare different times. In a pair of decisions of the groups i and
j, made next to each other, let x and y be what they got, as parts of the greatest utility. If at every time μ_i ≥ r·μ_j, a factor
1 + λ·(r·y − x) has at most the mean 1, given all earlier pairs, so its product over pairs is a nonnegative supermartingale, and so is the
mean over bets λ = 1/2, 1/4, …, 1/128, which were fixed in advance. By Ville's inequality it ever reaches 1/level with at most the
probability `level`. The bets depend on no number of pairs, and a product on their tally only.

That r is excluded says "not at every time": at *some* time μ_i < r·μ_j, so that μ_j/μ_i was above 1/r then. It bounds μ_i/μ_j from above
only if that ratio is constant in time, though the means may move. The means have to agree within a pair, and a pair must come about
whatever its first decision was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from typing import Any

from fairaudit.exact.extended import Extended
from fairaudit.inference.anytime_joint import JOINT
from fairaudit.inference.levels import pair_levels
from fairaudit.inference.paired_betting import Contrasts, crossing, log_wealth, upper_end
from fairaudit.inference.pairing import Pairing

Tally = dict[tuple[Fraction, Fraction], int]
"""How many pairs had these two values."""


class TimePairs:
    """Tallies of the pairs in time of all members of each block, two by two.

    Parameters
    ----------
    kept : list, optional
        What `kept` returned: goes on from there.

    Examples
    --------
    >>> tallies = TimePairs()
    >>> for member, value in ((1, 1), (2, 0), (2, 1), (2, 0), (1, 1)):
    ...     tallies.take("job", member, Fraction(value))
    >>> tallies.of(2, 1)
    {(Fraction(0, 1), Fraction(1, 1)): 1}
    """

    def __init__(self, kept: Sequence[Any] | None = None) -> None:
        open_pairs, tallies = kept or ((), ())
        self._pairing = Pairing(open_pairs)
        self._tallies: dict[tuple[int, int], Tally] = {
            (a, b): {(Fraction(one), Fraction(other)): n for one, other, n in tally} for a, b, tally in tallies
        }

    def kept(self) -> list[Any]:
        """All that is to be remembered, as JSON can hold it; its size is that of the table and of the values."""
        tallies = [[a, b, [[str(one), str(other), n] for (one, other), n in tally.items()]] for (a, b), tally in self._tallies.items()]
        return [self._pairing.kept(), tallies]

    def join(self, block: Any, member: int) -> None:
        """Make a member known; members join in the same order whenever a watch is resumed."""
        self._pairing.join(block, member)

    def take(self, block: Any, member: int, value: Fraction) -> None:
        """Take a decision in."""
        for pair in self._pairing.take(block, member, value, (0, None)):
            tally = self._tallies.setdefault(pair.members, {})
            tally[pair.one, pair.other] = tally.get((pair.one, pair.other), 0) + 1

    @property
    def pairs(self) -> int:
        """How many pairs there were."""
        return sum(sum(tally.values()) for tally in self._tallies.values())

    def of(self, one: int, other: int) -> Tally:
        """The tally of two members, with the values of the first one first."""
        if (one, other) in self._tallies:
            return self._tallies[one, other]
        return {(x, y): n for (y, x), n in self._tallies.get((other, one), {}).items()}


class _Contrasts(Contrasts):
    """Pairs in time, on which the same bets are made whatever their number."""

    @cached_property
    def bets(self) -> list[Fraction]:
        return list(JOINT)


@dataclass(frozen=True)
class PairedEnds:
    """Ends of the greatest ratio, by pairs in time.

    Attributes
    ----------
    lower : Fraction
        At some time a ratio was above it, if it is above 1.
    upper : Fraction or float
        All ratios are below it, if they are constant in time; possibly `math.inf`.
    pair : tuple of int or None
        The two members behind the lower end, the higher one first.
    """

    lower: Fraction
    upper: Extended
    pair: tuple[int, int] | None


def paired_ends(
    tallies: TimePairs, blocks: Sequence[Sequence[int]], expected: int, gamma: Fraction, alpha: Fraction, *, exact: bool = True
) -> PairedEnds:
    """Bound the greatest ratio of two members of a block by their pairs in time, at every moment at once.

    Parameters
    ----------
    tallies : TimePairs
        The pairs so far.
    blocks : sequence of sequence of int
        The members, which are numbered by their first appearance.
    expected : int
        About how many members will appear; any number is sound.
    gamma : Fraction
        The greatest utility; the least is at least 0.
    alpha : Fraction
        The probability that one of the ends, of any pair at any moment, is wrong.
    exact : bool
        Whether to prove the ends in integers. Without, they are estimates in floats, for a display.

    Examples
    --------
    >>> tallies = TimePairs()
    >>> for k in range(400):
    ...     for member in (1, 2):
    ...         tallies.take("job", member, Fraction(k % 4 == 0 or (member == 1 and k % 2)))
    >>> ends = paired_ends(tallies, [[1, 2]], 2, Fraction(1), Fraction(1, 20))
    >>> 2 < ends.lower < 3 < ends.upper < 5, ends.pair
    (True, (1, 2))
    """
    lower, pair = Fraction(1), None
    upper: Extended = Fraction(1)
    for block, levels in zip(blocks, pair_levels(blocks, expected, alpha), strict=True):
        for i, j in permutations(range(len(block)), 2):
            level = levels[frozenset((i, j))]
            made = _Contrasts({(x / gamma, y / gamma): n for (x, y), n in tallies.of(block[i], block[j]).items()})
            found = upper_end(made, level) if exact else _estimate(made, level)
            upper = max(upper, found)
            if found * lower < 1:
                lower, pair = 1 / Fraction(found), (block[j], block[i])
    return PairedEnds(lower, upper, pair)


def _estimate(made: Contrasts, level: Fraction) -> Extended:
    found = crossing(lambda limit: log_wealth(made, limit), level, "ratio")
    return found if found == float("inf") else Fraction(found)
