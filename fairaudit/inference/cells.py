"""Cells: independent draws of a number in a known range, all with the same mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.extended import extended_text

Ends = tuple[Fraction, Fraction]
"""A lower and an upper end."""

Profiles = Mapping[tuple[Fraction | None, ...], int]
"""How many units of a context got these values in its groups, None where a unit was not seen."""


@dataclass(frozen=True)
class Cell:
    """Independent draws of a number between `low` and `high`, all with the same mean.

    Attributes
    ----------
    draws : int
        How many.
    total : Fraction
        Their sum.
    squares : Fraction or None
        The sum of their squares, for the empirical Bernstein method.
    low, high : Fraction
        The known range of one draw.
    binary : bool
        Whether a draw takes no other values than `low` and `high`.
    label : tuple
        What to call it.

    Examples
    --------
    >>> Cell(10, Fraction(3), None, Fraction(0), Fraction(1), True).mean
    Fraction(3, 10)
    """

    draws: int
    total: Fraction
    squares: Fraction | None
    low: Fraction
    high: Fraction
    binary: bool
    label: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what no draws can give."""
        low, low_bottom = self.low.numerator, self.low.denominator
        high, high_bottom = self.high.numerator, self.high.denominator
        total, bottom = self.total.numerator, self.total.denominator
        above, below = total * low_bottom - self.draws * low * bottom, self.draws * high * bottom - total * high_bottom
        width = high * low_bottom - low * high_bottom
        if self.draws < 0 or width < 0 or above < 0 or below < 0:
            raise InputError(f"{self.draws} draws between {self.low} and {self.high} cannot sum to {self.total}")
        if self.binary and width and above * high_bottom % (bottom * width):
            raise InputError(f"{self.draws} draws, each {self.low} or {self.high}, cannot sum to {self.total}")

    @property
    def informative(self) -> bool:
        """Whether its mean is estimated: it has draws, and they could have come out differently."""
        return self.draws > 0 and self.high > self.low

    @property
    def mean(self) -> Fraction:
        """Mean of the draws."""
        return Fraction(self.total.numerator, self.total.denominator * self.draws)

    @property
    def successes(self) -> Fraction:
        """The sum on the scale on which the range is [0, 1]; for binary draws the number of high ones."""
        return (self.total - self.draws * self.low) / (self.high - self.low)

    @cached_property
    def share(self) -> float:
        """The mean on that scale, correctly rounded."""
        (low, under), (high, over), (total, bottom) = (v.as_integer_ratio() for v in (self.low, self.high, self.total))
        return (total * under - self.draws * low * bottom) * over / (bottom * (high * under - low * over) * self.draws)


def informative(cells: Sequence[Cell]) -> list[bool]:
    """Whether each cell is informative; of many cells most share their ends."""
    lows, highs = {id(cell.low): cell.low for cell in cells}, {id(cell.high): cell.high for cell in cells}
    if len(lows) == len(highs) == 1:
        [low], [high] = lows.values(), highs.values()
        return [cell.draws > 0 for cell in cells] if high > low else [False] * len(cells)
    wide: dict[tuple[int, int], bool] = {}
    found = []
    for cell in cells:
        key = id(cell.low), id(cell.high)
        if key not in wide:
            wide[key] = cell.high > cell.low
        found.append(wide[key] and cell.draws > 0)
    return found


def shares(cells: Sequence[Cell]) -> NDArray[np.float64]:
    """The share of each cell; of many cells most are sums of whole numbers between 0 and 1."""
    unit = {(id(cell.low), id(cell.high)): cell for cell in cells}.values()
    if all(not cell.low and cell.high == 1 for cell in unit) and all(cell.total.denominator == 1 for cell in cells):
        sums, draws = [cell.total.numerator for cell in cells], [cell.draws for cell in cells]
        if max(draws, default=0) < 2**53:  # whose quotients numpy rounds as Python does
            return np.array(sums, dtype=np.float64) / np.array(draws, dtype=np.float64)
    return np.array([cell.share for cell in cells], dtype=np.float64)


def pooled_cell(parts: Sequence[Cell], label: tuple[Any, ...]) -> Cell:
    """The draws of some cells as those of one, in the range that holds theirs."""
    low, high = min(cell.low for cell in parts), max(cell.high for cell in parts)
    binary = all(cell.binary and (cell.low, cell.high) in ((low, high), (low, low), (high, high)) for cell in parts)
    squares = exact_sum([cell.squares or Fraction(0) for cell in parts])
    total = exact_sum([cell.total for cell in parts])
    return Cell(sum(cell.draws for cell in parts), total, squares, low, high, binary, label)


def exact_sum(listed: Sequence[Fraction]) -> Fraction:
    """Add up fractions over one denominator."""
    bottom = lcm(*{value.denominator for value in listed})
    return Fraction(sum(value.numerator * (bottom // value.denominator) for value in listed), bottom)


def cell_entries(cells: Sequence[Cell]) -> list[dict[str, Any]]:
    """Cells as evidence lists them."""
    texts: dict[tuple[int, int], list[str]] = {}  # most cells share their ends
    entries = []
    for cell in cells:
        key = id(cell.low), id(cell.high)
        ends = texts.get(key) or texts.setdefault(key, [extended_text(cell.low), extended_text(cell.high)])
        squares = None if cell.squares is None else extended_text(cell.squares)
        entries.append({"draws": cell.draws, "sum": extended_text(cell.total), "squares": squares, "range": [*ends], "binary": cell.binary})
    return entries
