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
from fairaudit.exact.enclosures import exp_enclosure
from fairaudit.exact.rationals import at_least, common_denominator, option_value, rational
from fairaudit.measures.limits import one_limit
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.tables.label_text import label_text
from fairaudit.tables.values import Label
from fairaudit.theorems.t03 import t3_mechanism

Rows = Sequence[Sequence[int]]

Distortion = Mapping[Any, Any] | Sequence[Sequence[Any]] | Callable[[Any, Any], Any]

TARGET_BITS = 80

MAX_GROUPS = 100


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
    level: Fraction | None = None
    """The declared floor, for a design without a policy."""

    @property
    def size(self) -> int:
        return len(self.labels)

    @property
    def group_free(self) -> bool:
        return all(row == block[0] for block in self.gains for row in block)

    def cost(self, rows: Rows, bottom: int) -> Fraction:
        total = sum(p * v for prices, row in zip(self.prices, rows, strict=True) for p, v in zip(prices, row, strict=True))
        return Fraction(total, self.price_scale * bottom)

    def truth(self, rows: Rows, bottom: int) -> Fraction:
        return Fraction(sum(w * row[i] for i, (w, row) in enumerate(zip(self.weights, rows, strict=True))), sum(self.weights) * bottom)

    def holds(self, rows: Rows, bottom: int) -> bool:
        """Whether a stochastic table meets cap and target, in integers."""
        if self.cap is not None:
            top, under = self.cap.numerator, self.cap.denominator
            if any(max(column) * under > min(column) * top for column in zip(*rows, strict=True)):
                return False
        if self.target is None:
            return True
        if self.level is not None:
            return t3_mechanism(self.mechanism(rows, bottom), self.level, floor="declared").value <= self.target
        top, under = self.target.numerator, self.target.denominator
        for block in self.gains:
            means = [sum(v * g for v, g in zip(row, gains, strict=True)) for row, gains in zip(rows, block, strict=True)]
            if max(means) * under > min(means) * top:
                return False
        return True

    def mechanism(self, rows: Rows, bottom: int) -> Mechanism:
        common = gcd(bottom, *(v for row in rows for v in row))
        table = tuple(tuple(v // common for v in row) for row in rows)
        return Mechanism((Factor(self.labels, self.labels, table, bottom // common),), self.columns)

    def rows_of(self, mechanism: Mechanism) -> tuple[list[list[int]], int]:
        """A filter of the same labels as a table in this order."""
        place = {label: j for j, label in enumerate(mechanism.outputs)}
        order = [place[label] for label in self.labels]
        return [[row[j] for j in order] for row in (mechanism.row(label) for label in self.labels)], mechanism.denominator


# From input to integers


def read_target(max_ratio: Any, max_log: Any) -> Fraction | None:
    """The target as a ratio, rounded down where a logarithm was given; None for a cap alone."""
    if max_ratio is None and max_log is None:
        return None
    unit, limit = one_limit(max_ratio, max_log)
    return limit if unit == "ratio" else _exp_below("max_log", limit)


def read_cap(epsilon: Any, factor: Any) -> Fraction | None:
    if epsilon is not None and factor is not None:
        raise InputError("max_epsilon and max_exp_epsilon were given; give at most one")
    if factor is not None:
        number = at_least("max_exp_epsilon", factor, 0)
        if number < 1:
            raise InputError(f"max_exp_epsilon is {shown(factor)}; a factor e^ε of at least 1 is accepted")
        return number
    return None if epsilon is None else _exp_below("max_epsilon", epsilon)


def _exp_below(name: str, value: Any) -> Fraction:
    """Exponential of the value, rounded down, and at least 1."""
    number = at_least(name, value, 0)
    if number > 10_000:
        raise InputError(f"{name} is {shown(value)}; a number from 0 to 10,000 is accepted")
    low, _ = exp_enclosure((number.numerator, number.denominator), TARGET_BITS)
    return max(Fraction(1), Fraction(low, 1 << TARGET_BITS)) if number else Fraction(1)


def require_target_or_cap(target: Fraction | None, cap: Fraction | None) -> None:
    if target is None and cap is None:
        raise InputError("neither a target nor a cap on epsilon was given; the identity filter distorts nothing")


def read_attributes(groups: int | Sequence[Any] | Mapping[str, int | Sequence[Any]]) -> dict[str, tuple[Label, ...]]:
    listed = groups if isinstance(groups, Mapping) else {"group": groups}
    result = {}
    for name, values in listed.items():
        if isinstance(values, int) and not isinstance(values, bool) and values > MAX_GROUPS:
            raise InputError(f"the attribute {shown(name)} has {values} values; a design accepts up to {MAX_GROUPS} joint groups")
        if isinstance(values, (str, bool)) or not isinstance(values, (int, Sequence)):
            raise InputError(
                f"the values of the attribute {shown(name)} are {shown(values)}; a number of values or a list of labels is accepted"
            )
        labels = tuple(_label(value) for value in (range(values) if isinstance(values, int) else values))
        if len(labels) < 2 or len(set(labels)) != len(labels) or len({len(label) for label in labels}) > 1:
            raise InputError(f"the attribute {shown(name)} needs at least two values, all different")
        result[name] = labels
    if not result:
        raise InputError("no attribute was given; name at least one")
    return result


def read_masses(population: Mapping[Any, Any] | Sequence[Any] | None, labels: tuple[Label, ...]) -> list[int]:
    if population is None:
        return [1] * len(labels)
    if isinstance(population, Mapping):
        given = {_label(key): at_least("population", value, 0) for key, value in population.items()}
        for label in given:
            if label not in labels:
                raise InputError(
                    f"the population names the group {shown(', '.join(label))}; {nearest(', '.join(label), map(', '.join, labels))}"
                )
        numbers = [given.get(label, Fraction(0)) for label in labels]
    else:
        numbers = [at_least("population", value, 0, _reader(population)) for value in population]
        if len(numbers) != len(labels):
            raise InputError(f"the population has {len(numbers)} masses for {len(labels)} groups; give one for each")
    if not any(numbers):
        raise InputError("every mass of the population is zero; at least one must be positive")
    return common_denominator([(v.numerator, v.denominator) for v in numbers])[0]


def _reader(given: Any) -> Callable[[object], tuple[int, int]]:
    """How numbers are read: entries of an array as what they store, others as options."""
    return rational if isinstance(given, np.ndarray) else option_value


def _label(value: Any) -> Label:
    texts = [label_text(part) for part in (value if isinstance(value, tuple) else (value,))]
    if not texts or None in texts:
        raise InputError(f"{shown(value)} is not a group; a label, or a tuple of labels for several columns, is accepted")
    return tuple(text for text in texts if text is not None)


def read_problem(
    labels: tuple[Label, ...],
    columns: tuple[str, ...],
    weights: Sequence[int],
    distortion: Distortion | None,
    target: Fraction | None,
    cap: Fraction | None,
) -> Problem:
    costs = _costs(distortion, labels)
    flat, bottom = common_denominator([(c.numerator, c.denominator) for row in costs for c in row])
    size = len(labels)
    prices = tuple(tuple(weights[a] * flat[a * size + j] for j in range(size)) for a in range(size))
    return Problem(labels, columns, tuple(weights), prices, bottom * sum(weights), target, cap)


def _costs(distortion: Distortion | None, labels: tuple[Label, ...]) -> list[list[Fraction]]:
    if distortion is None:
        return [[Fraction(int(a != b)) for b in labels] for a in labels]

    def number(a: Label, b: Label, value: Any) -> Fraction:
        return at_least(f"the distortion of {', '.join(a)} released as {', '.join(b)}", value, 0, _reader(distortion))

    if callable(distortion):
        bare = [label[0] if len(label) == 1 else label for label in labels]
        return [[number(a, b, distortion(x, y)) for b, y in zip(labels, bare, strict=True)] for a, x in zip(labels, bare, strict=True)]
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
        pair = (_label(key[0]), _label(key[1]))
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
