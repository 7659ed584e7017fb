"""Numeric columns cut into intervals, exactly: `age:18,30,45,65`."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number, decimal_text, option_value, rational
from fairaudit.tables.label_text import label_text
from fairaudit.tables.tally import Tally, merged

__all__ = ["Bins", "apply_bins"]

RAW = "="


@dataclass(frozen=True)
class Bins:
    """Intervals of a numeric column; each holds its lower edge.

    Attributes
    ----------
    edges : tuple of str
        The edges as decimals, rising.
    limits : tuple of Fraction
        The same as numbers.

    Examples
    --------
    >>> bins = Bins.of("age", ["18", "30"])
    >>> bins.labels
    ('under 18', '18 to under 30', '30 and over')
    >>> bins.label_of("29.99"), bins.label_of(30)
    ('18 to under 30', '30 and over')
    """

    edges: tuple[str, ...]
    limits: tuple[Fraction, ...]

    refused = "not a finite number"

    @staticmethod
    @answered
    def of(name: str, edges: Sequence[Number]) -> Bins:
        """Read rising edges.

        Raises
        ------
        InputError
            If they are not decimals, or do not rise.
        """
        limits = []
        texts = []
        for edge in edges:
            try:
                limits.append(Fraction(*(option_value(edge))))
                texts.append(_decimal(limits[-1]))
            except InputError as error:
                raise InputError(f"an edge of the intervals of column {shown(name)}: {error}") from None
        if not texts:
            raise InputError(f"the intervals of column {shown(name)} have no edge; write them as {name}:18,30,65")
        for low, high, text in zip(limits, limits[1:], texts[1:], strict=False):
            if high <= low:
                raise InputError(f"the edges of the intervals of column {shown(name)} must rise, and {text} does not")
        return Bins(tuple(texts), tuple(limits))

    @property
    def labels(self) -> tuple[str, ...]:
        """Label of each interval, from the lowest."""
        between = [f"{low} to under {high}" for low, high in zip(self.edges, self.edges[1:], strict=False)]
        return (f"under {self.edges[0]}", *between, f"{self.edges[-1]} and over")

    def label_of(self, value: object) -> str | None:
        """Label of a number: a text is the rational that it says, a float is compared with the edges rounded to floats.

        Raises
        ------
        InputError
            If it is not a finite number.
        """
        if label_text(value) is None:
            return None
        if isinstance(value, bool):
            raise InputError(f"{shown(value)} is not a number such as 12, 0.25, 1e-3 or 1/3")
        exact = Fraction(*rational(value))
        limits = [Fraction(float(limit)) for limit in self.limits] if isinstance(value, float) else self.limits
        return self.labels[sum(exact >= limit for limit in limits)]


def apply_bins(tally: Tally, bins: Mapping[str, Bins], cut: Collection[str] = (), tied: Collection[str] = ()) -> Tally:
    """Replace numbers by the labels of their intervals.

    Parameters
    ----------
    tally : Tally
        The log.
    bins : mapping of str to Bins
        The intervals.
    cut : collection of str
        Columns that an engine has cut already.
    tied : collection of str
        Columns that an engine has cut where float64 decides, and has left as ``=`` and the text where it does not.

    Raises
    ------
    InputError
        If a value is not a number; the message says where it occurs.
    """
    if not bins:
        return tally
    levels = dict(tally.levels)
    for name, intervals in bins.items():
        found: list[Any] = []
        for level, value in enumerate(tally.levels[name]):
            try:
                if value == Bins.refused and name in cut:
                    raise InputError("there are values that are infinite or not numbers")
                done = value is None or name in cut or (name in tied and not value.startswith(RAW))
                found.append(value if done else intervals.label_of(value.removeprefix(RAW) if name in tied else value))
            except InputError as error:
                at = int(np.flatnonzero(tally.codes[name] == level)[0])
                raise InputError(f"{tally.name}: column {shown(name)}, {tally.locate(at)}: {error}; intervals need numbers") from None
        levels[name] = found
    return merged(replace(tally, levels=levels))


def _decimal(value: Fraction) -> str:
    """Digits of a number with finitely many decimals."""
    text = decimal_text(value)
    if "/" in text or len(text.strip("-").replace(".", "").lstrip("0")) > 30:
        raise InputError("it has more than 30 decimals or digits; write it as a decimal such as 18 or 0.5")
    return text
