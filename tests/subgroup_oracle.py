"""Subgroups by plain loops over the rows of small logs, and random logs on which searches are tried."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product
from math import inf
from random import Random
from typing import Any

Log = list[tuple[tuple[str, ...], Fraction]]
"""Rows: the labels of the attributes, and what was got."""


@dataclass(frozen=True)
class Case:
    """A log and what is asked of it."""

    attributes: tuple[str, ...]
    log: Log
    depth: int
    least: int
    keep: int

    @property
    def columns(self) -> dict[str, list[Any]]:
        """The log as columns; the decision is what was got."""
        listed: dict[str, list[Any]] = {name: [labels[i] for labels, _ in self.log] for i, name in enumerate(self.attributes)}
        return {**listed, "got": [str(value) for _, value in self.log]}

    @property
    def worth(self) -> dict[str, str]:
        """What decisions are worth."""
        return {str(value): str(value) for _, value in self.log}


@dataclass(frozen=True)
class Entry:
    """A conjunction with its rows."""

    conditions: dict[str, str]
    rows: frozenset[int]
    total: Fraction
    ratio: Fraction | float
    side: str


def family(case: Case) -> list[Entry]:
    """All conjunctions with enough rows and not all of them: by number of conditions, then attributes and labels in their order."""
    labels = [sorted({row[i] for row, _ in case.log}) for i in range(len(case.attributes))]
    everything = sum((value for _, value in case.log), Fraction(0))
    found = []
    for size in range(1, case.depth + 1):
        names = []
        for chosen in combinations(range(len(case.attributes)), size):
            names += [tuple(zip(chosen, values, strict=True)) for values in product(*[labels[a] for a in chosen])]
        for name in sorted(names):
            rows = frozenset(i for i, (row, _) in enumerate(case.log) if all(row[a] == label for a, label in name))
            if case.least <= len(rows) < len(case.log):
                total = sum((case.log[i][1] for i in rows), Fraction(0))
                own, rest = total / len(rows), (everything - total) / (len(case.log) - len(rows))
                ratio = Fraction(1) if own == rest else max(own, rest) / min(own, rest) if min(own, rest) else inf
                side = "equal" if own == rest else "more" if own > rest else "less"
                found.append(Entry({case.attributes[a]: label for a, label in name}, rows, total, ratio, side))
    return found


def worst(case: Case) -> list[tuple[Entry, list[dict[str, str]]]]:
    """The most unequal ones with different rows, each with the others that have the same rows."""
    listed: list[tuple[Entry, list[dict[str, str]]]] = []
    for entry in sorted(family(case), key=lambda entry: -entry.ratio):
        same = next((others for first, others in listed if first.rows == entry.rows), None)
        if same is not None:
            same.append(entry.conditions)
        elif len(listed) < case.keep:
            listed.append((entry, []))
    return listed


def random_case(rng: Random, *, most_rows: int = 60) -> Case:
    """A log with attributes that may repeat each other or say nothing, several values with zeros, and a subgroup that differs."""
    width = rng.randint(1, 5)
    sizes = [rng.randint(1, 3) for _ in range(width)]
    values = rng.choice([[0, 1], [0, 1], [0, 1, 2], [0, Fraction(1, 2), 3], [1, 2], [0], [1, Fraction(7, 5), 4]])
    weights = [rng.random() ** 2 + 0.01 for _ in values]
    planted = {a: rng.randrange(sizes[a]) for a in rng.sample(range(width), rng.randint(0, min(2, width)))}
    log: Log = []
    for _ in range(rng.randint(2, most_rows)):
        codes = [rng.randrange(size) for size in sizes]
        if width > 1 and planted and len(planted) == 1:
            codes[-1] = codes[0] % sizes[-1]
        value = values[-1] if planted and all(codes[a] == v for a, v in planted.items()) else rng.choices(values, weights)[0]
        log.append((tuple("abc"[code] for code in codes), Fraction(value)))
    least = rng.randint(1, max(1, len(log) // rng.choice([3, 5, 10])))
    return Case(tuple(f"attribute {i}" for i in range(width)), log, rng.randint(1, 3), least, rng.choice([1, 2, 3, 10]))
