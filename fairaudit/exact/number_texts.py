"""Many texts of numbers read at once, exactly: whole numbers and decimals of up to 18 digits, and quotients of such whole numbers.

Whatever is written otherwise is left to `parse_rational`, so that both accept the same and say the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["NumberTexts", "read_number_texts"]


Integers = NDArray[np.int64]

DIGITS = 18
"""Significant digits, and powers of ten, that always fit 64 bits."""

WIDEST = 40
"""Longer texts are left to be read one at a time."""

BLOCK = 1 << 14
"""Texts that are read together: their columns of characters stay in the cache."""

ZERO, POINT, SLASH, MINUS, PLUS = b"0./-+"


@dataclass(frozen=True, eq=False)
class NumberTexts:
    """Numbers top · 10^power / bottom, one for each text.

    Attributes
    ----------
    tops : ndarray of int64
        Of at most 18 digits, and at least 0.
    powers : ndarray of int64
        From −1,017 to 999; not 0 only where the bottom is 1.
    bottoms : ndarray of int64
        Positive, of at most 18 digits.
    left : ndarray of int64
        Places of texts that have another form: they are to be read one at a time.
    """

    tops: Integers
    powers: Integers
    bottoms: Integers
    left: Integers


def read_number_texts(texts: Sequence[str]) -> NumberTexts:
    """Read texts as the rationals that they say, all at once.

    Parameters
    ----------
    texts : sequence of str
        The texts, without blanks around them.

    Returns
    -------
    NumberTexts
        The numbers, and the places of texts that are no number of at most 18 digits, or are negative, or no number at all.

    Examples
    --------
    >>> found = read_number_texts(["0.25", "12", "1/3", "2.5e-07", "-1", "a half"])
    >>> found.tops.tolist(), found.powers.tolist(), found.bottoms.tolist(), found.left.tolist()
    ([25, 12, 1, 25, 0, 0], [-2, 0, 0, -8, 0, 0], [1, 1, 3, 1, 1, 1], [4, 5])
    """
    characters, fitting = _characters(texts)
    count = len(characters)
    tops, powers, bottoms = (np.zeros(count, dtype=np.int64) for _ in range(3))
    for first in range(0, count, BLOCK):
        some = slice(first, first + BLOCK)
        tops[some], powers[some], bottoms[some], good = _read(np.ascontiguousarray(characters[some].T))
        fitting[some] &= good
    left = np.flatnonzero(~fitting)
    tops[left], powers[left], bottoms[left] = 0, 0, 1
    return NumberTexts(tops, powers, bottoms, left)


def _characters(texts: Sequence[str]) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """The characters of each text in a row, filled up with zeros, and which texts they are all of."""
    listed = list(texts)
    fitting = np.ones(len(listed), dtype=np.bool_)
    try:
        array = np.array(listed, dtype=f"S{WIDEST + 1}")  # longer ones are cut
    except UnicodeEncodeError:
        fitting = np.array([text.isascii() for text in listed], dtype=np.bool_)
        array = np.array([text if text.isascii() else "" for text in listed], dtype=f"S{WIDEST + 1}")
    if "\0" in "".join(listed):  # a text that ends in such characters would lose them
        fitting &= np.array(["\0" not in text for text in listed], dtype=np.bool_)
    matrix = np.frombuffer(array.tobytes(), dtype=np.uint8).reshape(len(array), WIDEST + 1)
    fitting &= matrix[:, WIDEST] == 0
    matrix = matrix[:, :WIDEST]
    used = np.flatnonzero(matrix.any(axis=0))
    return matrix[:, : (int(used[-1]) + 1 if len(used) else 1)], fitting


def _read(matrix: NDArray[np.uint8]) -> tuple[Integers, Integers, Integers, NDArray[np.bool_]]:
    """Read a block whose characters are in columns: tops, powers, bottoms, and which texts have an accepted form."""
    count = matrix.shape[1]
    place = np.arange(len(matrix), dtype=np.int8)[:, None]
    digit = matrix - np.uint8(ZERO) < 10
    lengths = _first(matrix == 0, place)
    inside = place < lengths
    e = (matrix | np.uint8(0x20)) == ord("e")
    point, slash = matrix == POINT, matrix == SLASH
    sign = (matrix == MINUS) | (matrix == PLUS)
    marks = [part.sum(axis=0, dtype=np.int8) for part in (e, point, slash, sign)]
    at_e, at_point, at_slash = (np.minimum(_first(part, place), lengths) for part in (e, point, slash))
    end = np.minimum(at_e, at_slash)
    whole = digit & (place < end)
    tops, digits, first = _integers(matrix, whole)
    good = (np.where(inside, digit | e | point | slash | sign, matrix == 0)).all(axis=0) & (digits <= DIGITS) & first
    good &= (marks[0] <= 1) & (marks[1] <= 1) & (marks[2] <= 1) & ((at_point <= end) | (marks[1] == 0))
    good &= (marks[0] + marks[2] <= 1) & (marks[1] + marks[2] <= 1) & (marks[3] <= marks[0])
    places = np.where(marks[1] > 0, end - at_point - 1, 0).astype(np.int64)
    powers = -places
    if marks[0].any():
        signed = sign & (place == at_e + 1)
        power = digit & (place > at_e)
        exponents, _, some = _integers(matrix, power)
        raised = marks[0] > 0
        good &= ~raised | (some & (power.sum(axis=0, dtype=np.int8) <= 3) & (signed.sum(axis=0, dtype=np.int8) == marks[3]))
        down = (signed & (matrix == MINUS)).any(axis=0)
        powers = powers + np.where(raised & good, np.where(down, -exponents, exponents), 0)
    bottoms = np.ones(count, dtype=np.int64)
    if marks[2].any():
        below, length, some = _integers(matrix, digit & (place > at_slash))
        divided = marks[2] > 0
        good &= ~divided | (some & (length <= DIGITS) & (below > 0))
        bottoms = np.where(divided & good, below, 1)
    return tops, powers, bottoms, good


def _first(marked: NDArray[np.bool_], place: NDArray[np.int8]) -> NDArray[np.int8]:
    """The first place of each column that is marked, and if there is none the number of places."""
    return np.asarray(np.where(marked, place, np.int8(len(marked))).min(axis=0))


def _integers(matrix: NDArray[np.uint8], digit: NDArray[np.bool_]) -> tuple[Integers, NDArray[np.int8], NDArray[np.bool_]]:
    """The integers that chosen digits say, how many digits they have from the first that is not 0, and whether there is any digit.

    An integer of more than 18 digits is none of the results.
    """
    found = np.zeros(matrix.shape[1], dtype=np.int64)
    place = np.arange(len(matrix), dtype=np.int8)[:, None]
    digits = (digit & (place >= _first(digit & (matrix != ZERO), place))).sum(axis=0, dtype=np.int8)
    factor = digit * np.uint8(9) + np.uint8(1)
    value = (matrix - np.uint8(ZERO)) * digit
    for row in np.flatnonzero(digit.any(axis=1)).tolist():
        found *= factor[row]
        found += value[row]
    return found, np.asarray(digits), np.asarray(digit.any(axis=0))
