"""Columns of exact numbers as arrays: over one denominator, or laid out in rows, each over a denominator of its own.

A number is top · 10^power / bottom in 64 bits wherever it can be; what cannot is a pair of Python integers. Nothing is rounded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import gcd, lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.number_texts import DIGITS, Integers, read_number_texts
from fairaudit.exact.rationals import common_denominator

__all__ = ["NumberColumn", "added"]


SAFE = 2.0**62
"""What is below this as a float is below 2^63 as an integer, though the float was rounded a few times."""

TENS = np.array([10**power for power in range(DIGITS + 1)], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class NumberColumn:
    """Non-negative exact numbers.

    Attributes
    ----------
    tops, powers, bottoms : ndarray of int64
        Each number is top · 10^power / bottom.
    others : mapping of int to (int, int)
        Numbers that do not fit, by place, as numerator and denominator.

    Examples
    --------
    >>> column, left = NumberColumn.of_texts(["0.5", "1/3", "0." + "3" * 30])
    >>> [str(column[place]) for place in range(2)], left
    (['1/2', '1/3'], [2])
    """

    tops: Integers
    powers: Integers
    bottoms: Integers
    others: Mapping[int, tuple[int, int]] = field(default_factory=dict)

    @staticmethod
    def of_texts(texts: Sequence[str]) -> tuple[NumberColumn, list[int]]:
        """Read texts; also the places of those that have to be read one at a time."""
        found = read_number_texts(texts)
        return NumberColumn(found.tops, found.powers, found.bottoms), found.left.tolist()

    def __len__(self) -> int:
        """How many numbers there are."""
        return len(self.tops)

    def __getitem__(self, place: int) -> Fraction:
        """The number at a place."""
        return Fraction(*self.pair(place))

    def pair(self, place: int) -> tuple[int, int]:
        """The number at a place as numerator and denominator, not necessarily in lowest terms."""
        if place in self.others:
            return self.others[place]
        top, power, bottom = int(self.tops[place]), int(self.powers[place]), int(self.bottoms[place])
        return (top * 10**power, bottom) if power >= 0 else (top, bottom * 10**-power)

    def over_one_denominator(self) -> tuple[NDArray[Any], int]:
        """All numbers as integers, int64 if their sum fits, over their least common denominator.

        Raises
        ------
        InputError
            If that denominator has more than 100,000 digits.

        Examples
        --------
        >>> column, _ = NumberColumn.of_texts(["0.5", "0.25", "1/3"])
        >>> [part.tolist() if hasattr(part, "tolist") else part for part in column.over_one_denominator()]
        [[6, 3, 4], 12]
        """
        if self.others or (self.bottoms != 1).any():
            whole, bottom = common_denominator([self.pair(place) for place in range(len(self))])
            common = gcd(bottom, *whole)
            return _array([top // common for top in whole]), bottom // common
        if not self.tops.any():
            return self.tops, 1
        places = max(0, -int(self.powers.min()))
        shifts = self.powers + places
        bottom = 10**places
        if _fits(self.tops, shifts).all() and float((self.tops * 10.0 ** np.minimum(shifts, DIGITS + 1)).sum()) < SAFE:
            tops = self.tops * TENS[np.where(self.tops > 0, shifts, 0)]
            common = gcd(bottom, int(np.gcd.reduce(tops)))
            return tops // common, bottom // common
        wide = _raised(self.tops, shifts)
        common = gcd(bottom, *wide.tolist())
        return _array((wide // common).tolist()), bottom // common

    def rows(self, places: Integers, shape: tuple[int, int]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Lay the numbers out in rows, each as integers over a denominator of its own.

        Parameters
        ----------
        places : ndarray of int64
            Where each number stands in the matrix, counted row by row; no place occurs twice, and the others are 0.
        shape : (int, int)
            Rows and columns.

        Returns
        -------
        matrix : ndarray
            The integers: int64 if the sum of every row fits, else Python integers.
        bottoms : ndarray
            The denominator of each row, int64 or Python integers.

        Raises
        ------
        InputError
            If the denominator of a row has more than 100,000 digits.

        Examples
        --------
        >>> column, _ = NumberColumn.of_texts(["0.5", "0.5", "1/3", "2/3"])
        >>> matrix, bottoms = column.rows(np.arange(4), (2, 2))
        >>> matrix.tolist(), bottoms.tolist()
        ([[5, 5], [1, 2]], [10, 3])
        """
        tops, powers = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64)
        tops.flat[places], powers.flat[places] = self.tops, self.powers
        divided = bool((self.bottoms != 1).any())
        if not divided:
            decimals = np.maximum(-powers.min(axis=1), 0)
            shifts = powers + decimals[:, None]
            matrix, small = _shifted(tops, shifts)
            small &= decimals <= DIGITS
            bottoms: NDArray[Any] = TENS[np.where(small, decimals, 0)]
        else:
            own = np.ones(shape, dtype=np.int64)
            own.flat[places] = self.bottoms
            matrix, bottoms, small = _over_common(tops, powers, own)
        odd = np.zeros(shape[0], dtype=np.bool_)
        odd[places[list(self.others)] // shape[1]] = True
        if small.all() and not odd.any():
            return matrix, bottoms
        matrix, bottoms = matrix.astype(object), bottoms.astype(object)
        wide = ~small & ~odd
        if divided:
            odd |= wide
        elif wide.any():
            matrix[wide] = _raised(tops[wide], shifts[wide])
            bottoms[wide] = _raised(np.ones(int(wide.sum()), dtype=np.int64), decimals[wide])
        self._fill(odd, places, matrix, bottoms)
        return matrix, bottoms

    def _fill(self, odd: NDArray[np.bool_], places: Integers, matrix: NDArray[Any], bottoms: NDArray[Any]) -> None:
        """Fill the given rows one at a time."""
        width = matrix.shape[1]
        members: dict[int, list[int]] = {row: [] for row in np.flatnonzero(odd).tolist()}
        for member in np.flatnonzero(odd[places // width]).tolist():
            members[int(places[member]) // width].append(member)
        for row, held in members.items():
            whole, bottoms[row] = common_denominator([self.pair(member) for member in held])
            matrix[row] = 0
            matrix[row, places[held] % width] = np.array(whole, dtype=object)


def _fits(tops: Integers, shifts: Integers) -> NDArray[np.bool_]:
    """Whether top · 10^shift fits 64 bits."""
    return np.asarray((tops == 0) | ((shifts <= DIGITS) & (tops * 10.0 ** np.minimum(shifts, DIGITS + 1) < SAFE)))


def _shifted(tops: Integers, shifts: Integers) -> tuple[Integers, NDArray[np.bool_]]:
    """Top · 10^shift of a matrix, and of which rows the sum fits 64 bits; other rows mean nothing."""
    sums = (tops * 10.0 ** np.minimum(shifts, DIGITS + 1)).sum(axis=1)
    small = (sums < SAFE) & _fits(tops, shifts).all(axis=1)
    return tops * TENS[np.where(small[:, None] & (tops > 0), shifts, 0)], small


def _raised(tops: Integers, shifts: Integers) -> NDArray[Any]:
    """Top · 10^shift in Python integers."""
    kinds, which = np.unique(shifts, return_inverse=True)
    powers = np.empty(len(kinds), dtype=object)
    powers[:] = [10**shift for shift in kinds.tolist()]
    return np.asarray(tops.astype(object) * powers[which].reshape(tops.shape))


def _over_common(tops: Integers, powers: Integers, own: Integers) -> tuple[Integers, Integers, NDArray[np.bool_]]:
    """Rows of top · 10^power / bottom over their common denominators, these, and which rows fit 64 bits; other rows mean nothing."""
    small = np.all((np.abs(powers) <= DIGITS) & _fits(tops, powers) & _fits(own, -powers), axis=1)
    bounded = np.where(small[:, None], powers, 0)
    tops, own = tops * TENS[np.maximum(bounded, 0)], own * TENS[np.maximum(-bounded, 0)]
    bottoms = own.max(axis=1)
    left = np.flatnonzero((bottoms[:, None] % own != 0).any(axis=1))
    if len(left):
        bottoms[left], fits = _least_common(own[left])
        small[left] &= fits
    factors = np.where(small[:, None], bottoms[:, None] // own, 1)
    small &= (tops * factors.astype(np.float64)).sum(axis=1) < SAFE
    return tops * np.where(small[:, None], factors, 1), bottoms, small


def _least_common(numbers: Integers) -> tuple[Integers, NDArray[np.bool_]]:
    """Least common multiple of each row, by halves, and of which rows it fits 64 bits."""
    fits = np.ones(len(numbers), dtype=np.bool_)
    while numbers.shape[1] > 1:
        half = numbers.shape[1] // 2
        left, right, rest = numbers[:, :half], numbers[:, half : 2 * half], numbers[:, 2 * half :]
        factor = right // np.gcd(left, right)
        fits &= (left * factor.astype(np.float64) < SAFE).all(axis=1)
        numbers = np.where(fits[:, None], np.concatenate((left * factor, rest), axis=1), 1)
    return numbers[:, 0], fits


def _array(listed: Sequence[int]) -> NDArray[Any]:
    """Integers as int64 if their sum fits, else as Python integers."""
    return np.array(listed, dtype=np.int64 if sum(map(abs, listed)) <= np.iinfo(np.int64).max else object)


def added(parts: Sequence[tuple[Any, int]]) -> tuple[Any, int]:
    """Add quotients of integers, or of arrays of integers, by halves so that the numbers stay short for long.

    Raises
    ------
    InputError
        If their denominator has more digits than the figures of a certificate may have.

    Examples
    --------
    >>> added([(1, 4), (1, 6)])
    (5, 12)
    """
    while len(parts) > 1:
        pairs = []
        for (a, b), (c, d) in zip(parts[::2], parts[1::2], strict=False):
            bottom = lcm(b, d)
            if bottom.bit_length() > 300_000:
                raise InputError(
                    "the exact global figures of this table need more than 90,000 digits; give the probabilities as decimals of the "
                    "same length, so that rows share a denominator"
                )
            pairs.append((a * (bottom // b) + c * (bottom // d), bottom))
        parts = [*pairs, *parts[len(parts) // 2 * 2 :]]
    return parts[0]
