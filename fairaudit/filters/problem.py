"""What is asked of a filter, read from what was given, in integers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import gcd
from typing import Any

import numpy as np

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.dense import Numbers
from fairaudit.exact.rationals import Number, at_least, common_denominator
from fairaudit.filters.groups import number_reader, read_label
from fairaudit.filters.policy_sums import PolicySum
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.tables.values import Label, LabelsLike
from fairaudit.theorems.t13_range import UtilityRange, in_each_range, t13_range

Rows = Sequence[Sequence[int]]

Price = Callable[[str, str], Number] | Callable[[Label, Label], Number]

Distortion = (
    Mapping[tuple[str, str], Number]
    | Mapping[tuple[Label, Label], Number]
    | Mapping[tuple[LabelsLike, LabelsLike], Number]
    | Numbers
    | Price
)
"""c(a,ã): by pairs of groups, as a square table, or as a function."""

MAX_GROUPS = 100
"""Groups of a design: the linear program has an entry for every ordered pair of them, and its exact arithmetic grows faster."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What is asked for, in integers; inputs and outputs are the same labels."""

    labels: tuple[Label, ...]
    columns: tuple[str, ...]
    weights: tuple[int, ...]
    prices: tuple[tuple[int, ...], ...]
    """P(a)·c(a,ã) over `price_scale`."""
    price_scale: int
    target: Fraction | None
    cap: Fraction | None
    gains: tuple[tuple[tuple[int, ...], ...], ...] = ()
    """For each context and true group Σ_u T(u|x,ã)·g(u,x,a) over ã, up to a factor for each context."""
    sums: tuple[PolicySum, ...] = ()
    """What holds the target for every policy."""
    floored: UtilityRange | None = None
    """The range of the utility with a declared floor, which every policy keeps."""

    @property
    def size(self) -> int:
        """Number of groups."""
        return len(self.labels)

    @property
    def group_free(self) -> bool:
        """Whether the utility ignores the group, so that a filter that hides it meets every target."""
        return all(row == block[0] for block in self.gains for row in block)

    def cost(self, rows: Rows, bottom: int) -> Fraction:
        """The expected distortion of a table over a denominator."""
        total = sum(p * v for prices, row in zip(self.prices, rows, strict=True) for p, v in zip(prices, row, strict=True))
        return Fraction(total, self.price_scale * bottom)

    def truth(self, rows: Rows, bottom: int) -> Fraction:
        """The probability that the truth is released."""
        return Fraction(sum(w * row[i] for i, (w, row) in enumerate(zip(self.weights, rows, strict=True))), sum(self.weights) * bottom)

    def holds(self, rows: Rows, bottom: int) -> bool:
        """Whether a table is stochastic and meets cap and target, in integers."""
        if any(min(row) < 0 or sum(row) != bottom for row in rows):
            return False
        if self.cap is not None:
            top, under = self.cap.numerator, self.cap.denominator
            if any(max(column) * under > min(column) * top for column in zip(*rows, strict=True)):
                return False
        if self.target is None:
            return True
        if self.floored is not None:
            return t13_range(in_each_range(self.mechanism(rows, bottom), [self.floored]), floored=True).value <= self.target
        if not all(part.holds(rows, bottom) for part in self.sums):
            return False
        top, under = self.target.numerator, self.target.denominator
        for block in self.gains:
            means = [sum(v * g for v, g in zip(row, gains, strict=True)) for row, gains in zip(rows, block, strict=True)]
            if max(means) * under > min(means) * top:
                return False
        return True

    def mechanism(self, rows: Rows, bottom: int) -> Mechanism:
        """A table over a denominator as a filter, in lowest terms."""
        common = gcd(bottom, *(v for row in rows for v in row))
        table = tuple(tuple(v // common for v in row) for row in rows)
        return Mechanism((Factor(self.labels, self.labels, table, bottom // common),), self.columns)

    def rows_of(self, mechanism: Mechanism) -> tuple[list[list[int]], int]:
        """A filter of the same labels as a table in this order."""
        place = {label: j for j, label in enumerate(mechanism.outputs)}
        order = [place[label] for label in self.labels]
        return [[row[j] for j in order] for row in (mechanism.row(label) for label in self.labels)], mechanism.denominator


def read_problem(
    labels: tuple[Label, ...],
    columns: tuple[str, ...],
    weights: Sequence[int],
    distortion: Distortion | None,
    target: Fraction | None,
    cap: Fraction | None,
) -> Problem:
    """Read what is asked for; what holds the target is added by the caller."""
    costs = _costs(distortion, labels)
    flat, bottom = common_denominator([(c.numerator, c.denominator) for row in costs for c in row])
    size = len(labels)
    prices = tuple(tuple(weights[a] * flat[a * size + j] for j in range(size)) for a in range(size))
    return Problem(labels, columns, tuple(weights), prices, bottom * sum(weights), target, cap)


def _costs(distortion: Distortion | None, labels: tuple[Label, ...]) -> list[list[Fraction]]:
    if distortion is None:
        return [[Fraction(int(a != b)) for b in labels] for a in labels]

    def number(a: Label, b: Label, value: Any) -> Fraction:
        return at_least(f"the distortion of {', '.join(a)} released as {', '.join(b)}", value, 0, number_reader(distortion))

    if callable(distortion):
        price: Callable[[Any, Any], Number] = distortion
        bare = [label[0] if len(label) == 1 else label for label in labels]
        return [[number(a, b, price(x, y)) for b, y in zip(labels, bare, strict=True)] for a, x in zip(labels, bare, strict=True)]
    if not isinstance(distortion, Mapping):
        table = np.asarray(distortion, dtype=object)
        if table.shape != (len(labels), len(labels)):
            raise InputError(
                f"the distortion is a table of shape {table.shape}; it must be {len(labels)} by {len(labels)}, groups by groups"
            )
        return [[number(a, b, v) for b, v in zip(labels, row, strict=True)] for a, row in zip(labels, table.tolist(), strict=True)]
    given: dict[tuple[Label, Label], Fraction] = {}
    for key, value in distortion.items():
        if not isinstance(key, tuple) or len(key) != 2:
            raise InputError(f"the distortion has the key {shown(key)}; a pair of a true and a released group is accepted")
        pair = (read_label(key[0]), read_label(key[1]))
        for label in pair:
            if label not in labels:
                raise InputError(
                    f"the distortion names the group {shown(', '.join(label))}; {nearest(', '.join(label), map(', '.join, labels))}"
                )
        given[pair] = number(*pair, value)
    for a, b in product(labels, repeat=2):
        if a != b and (a, b) not in given:
            raise InputError(f"the distortion of {', '.join(a)} released as {', '.join(b)} is missing; give every pair of different groups")
    return [[given.get((a, b), Fraction(0)) for b in labels] for a in labels]
