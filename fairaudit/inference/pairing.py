"""Pairs in time: of two members of a block the next unpaired decision of the other one completes a pair, and extras are dropped."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

MOST_PAIRS = 1_000  # of members that are watched; those that are seen together later are not

Moment = tuple[int, float | None]
"""Number of a decision, and its time where there is one."""


class Completed(NamedTuple):
    """A pair of decisions: the two members, what each got, and when the first of both decisions was made."""

    members: tuple[int, int]
    one: Fraction
    other: Fraction
    first: Moment


@dataclass
class _Open:
    """Two members of a block, and whose decision waits for one of the other."""

    members: tuple[int, int]
    waiting: int | None = None
    value: Fraction = Fraction(0)
    first: Moment = (0, None)


class Pairing:
    """Pairs the decisions of all members of each block, two by two, from the moment on that both are known.

    Parameters
    ----------
    kept : iterable
        What `kept` returned: goes on from there.

    Examples
    --------
    >>> pairing, zero, one = Pairing(), Fraction(0), Fraction(1)
    >>> for number, (member, value) in enumerate([(1, one), (2, zero), (2, one), (1, one)]):
    ...     for pair in pairing.take("job", member, value, (number, None)):
    ...         print(pair.members, pair.one, pair.other, pair.first)
    (1, 2) 1 0 (1, None)
    """

    def __init__(self, kept: Iterable[Any] = ()) -> None:
        self._blocks: dict[Any, list[int]] = {}
        self._pairs: list[_Open] = []
        self._of: dict[int, list[_Open]] = {}
        for a, b, waiting, value, first in kept:
            self._add(_Open((a, b), waiting, Fraction(value), tuple(first)))

    def kept(self) -> list[list[Any]]:
        """All that is to be remembered, as JSON can hold it: of each two members what waits."""
        return [[*pair.members, pair.waiting, str(pair.value), list(pair.first)] for pair in self._pairs]

    def join(self, block: Any, member: int) -> None:
        """Make a member known; members join in the same order whenever a watch is resumed."""
        if member in self._of:
            if member not in self._blocks.setdefault(block, []):
                self._blocks[block].append(member)
            return
        self._of[member] = []
        others = self._blocks.setdefault(block, [])
        for other in others:
            if len(self._pairs) < MOST_PAIRS:
                self._add(_Open((other, member)))
        others.append(member)

    def _add(self, pair: _Open) -> None:
        self._pairs.append(pair)
        for member in pair.members:
            self._of.setdefault(member, []).append(pair)

    def take(self, block: Any, member: int, value: Fraction, at: Moment) -> list[Completed]:
        """Take a decision in; returns the pairs that it completes.

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
        if member not in self._of:
            self.join(block, member)
        completed = []
        for pair in self._of[member]:
            if pair.waiting is None:
                pair.waiting, pair.value, pair.first = member, value, at
            elif pair.waiting != member:
                one, other = (value, pair.value) if member == pair.members[0] else (pair.value, value)
                pair.waiting = None
                completed.append(Completed(pair.members, one, other, pair.first))
        return completed
