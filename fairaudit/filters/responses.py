"""Lines of randomized responses, from total privacy to none, along which filters are calibrated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import inf, prod
from typing import Any, Literal

from fairaudit.model.mechanism import Identity, Mechanism, Product, RandomizedResponse
from fairaudit.model.policy import Policy

Split = Literal["equal-epsilon", "equal-keep", "most-truth"]

SPLITS: tuple[Split, ...] = ("equal-epsilon", "equal-keep", "most-truth")

GRID = 10**12
"""Probabilities of filters are decimals of twelve digits where that costs nothing: long enough for any use, short enough to be read."""

SEARCH_STEPS = 1 << 50
"""Steps along a line of filters, finer than the grid, so that rounding down to the grid alone decides the answer."""


def alphabets(policy: Policy) -> dict[str, tuple[Any, ...]]:
    """What a filter of a policy's groups acts on: each attribute by itself if all combinations occur, else the combinations."""
    law = policy.law
    each = {name: tuple(dict.fromkeys(label[i] for label in law.groups)) for i, name in enumerate(law.columns.group)}
    if prod(len(values) for values in each.values()) == len(law.groups):
        return each
    return {" and ".join(law.columns.group): law.groups}


def response_factor(mechanism: Mechanism) -> Fraction | float:
    """e^ε of a product of randomized responses."""
    total: Fraction | float = Fraction(1)
    for part in mechanism.factors:
        keep, lie = part.rows[0][0], part.rows[0][1]
        total = inf if lie == 0 else total * Fraction(keep, lie)
    return total


def rounded_keep(keep: Fraction) -> Fraction:
    """A probability rounded down to the grid."""
    return Fraction(keep.numerator * GRID // keep.denominator, GRID)


@dataclass(frozen=True)
class ResponseLine:
    """Filters from total privacy (s = 0) to none (s = 1), in growing order of what they let through.

    The keep probability of an attribute with k values is T/(T + (k − 1)·F) for T and F linear in s. With equal ε, T = 1 + s and F = 1 − s:
    s is that of a coin, and e^ε = (1 + s)/(1 − s). With equal keep probabilities the odds of the truth, s : 1 − s, are tilted where one
    attribute is to be kept more often than another, and are never below those that hide it.
    """

    attributes: Mapping[str, tuple[Any, ...]]
    split: Split
    tilts: tuple[Fraction, ...] = ()

    @property
    def equal_epsilon(self) -> bool:
        """Whether all attributes are kept with the same ε."""
        return len(self.attributes) == 1 or self.split == "equal-epsilon"

    def filters(self, keeps: Sequence[Fraction]) -> Mechanism:
        """The filter that keeps the attributes with these probabilities, but none below one over the number of its values."""
        return _together(
            {
                name: RandomizedResponse(values, keep_probability=max(Fraction(1, len(values)), keep))
                for (name, values), keep in zip(self.attributes.items(), keeps, strict=True)
            }
        )

    def on_grid(self, step: int) -> Mechanism:
        """The filter at s = step/`SEARCH_STEPS`, its keep probabilities rounded down."""
        return self.filters([rounded_keep(keep) for keep in self.keeps(Fraction(step, SEARCH_STEPS))])

    def keeps(self, s: Fraction) -> list[Fraction]:
        """Keep probabilities, exact."""
        return [
            max(Fraction(1, k), top / (top + rest)) if top + rest else Fraction(0)
            for k, (top, rest) in zip(self._sizes, self._odds(s), strict=True)
        ]

    def pieces(self) -> Iterator[tuple[Fraction, Fraction, list[int]]]:
        """Intervals of s, the greatest first, each with the attributes whose keep probability rises there."""
        starts = [Fraction(0) if self.equal_epsilon else 1 / (1 + tilt * (k - 1)) for k, tilt in zip(self._sizes, self._tilts, strict=True)]
        for low, high in reversed(list(pairwise(sorted({Fraction(0), *starts, Fraction(1)})))):
            yield low, high, [i for i, start in enumerate(starts) if start <= low]

    def weight(self, s: Fraction, rising: Sequence[int]) -> Fraction:
        """What every probability behind the filter is multiplied with to be a polynomial of s, of the degree `len(rising)`."""
        odds = self._odds(s)
        return prod((odds[i][0] + odds[i][1] for i in rising), start=Fraction(1))

    @property
    def _sizes(self) -> list[int]:
        return [len(values) for values in self.attributes.values()]

    @property
    def _tilts(self) -> tuple[Fraction, ...]:
        return self.tilts or (Fraction(1),) * len(self.attributes)

    def _odds(self, s: Fraction) -> list[tuple[Fraction, Fraction]]:
        """The weights of the truth and of all lies together."""
        if self.equal_epsilon:
            return [(1 + s, (k - 1) * (1 - s)) for k in self._sizes]
        return [(s * tilt, 1 - s) for tilt in self._tilts]


def identity_filter(attributes: Mapping[str, tuple[Any, ...]]) -> Mechanism:
    """The filter that releases every attribute as it is."""
    return _together({name: Identity(values) for name, values in attributes.items()})


def _together(parts: Mapping[str, Mechanism]) -> Mechanism:
    return next(iter(parts.values())) if len(parts) == 1 else Product(parts)
