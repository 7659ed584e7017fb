"""Random blocks of decisions of unknown group, and all assignments of them gone through one by one."""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction
from math import inf

from fairaudit.theorems.t15 import Block

Ratio = Fraction | float


def quotient(top: Fraction, bottom: Fraction) -> Ratio:
    """0/0 is 1, c/0 infinite."""
    return top / bottom if bottom else (inf if top else Fraction(1))


@dataclass(frozen=True)
class Enumerated:
    """The greatest and the least ratio, the greatest of each ordered pair, and what groups can receive and have: rows, and means."""

    greatest: Ratio
    least: Ratio
    pairs: dict[tuple[int, int], Ratio]
    received: set[tuple[int, ...]]
    means: list[list[Fraction]]


def enumerated(block: Block) -> Enumerated:
    """Give each row in turn to every group or to nobody, and look at all that keeps the limits."""
    groups = range(len(block.counts))
    states = {((0,) * len(groups), (0,) * len(groups))}
    for value, number in zip(block.values, block.numbers, strict=True):
        for _ in range(number):
            given = {
                (tuple(c + (a == b) for b, c in enumerate(counts)), tuple(s + value * (a == b) for b, s in enumerate(sums)))
                for counts, sums in states
                for a in groups
            }
            states |= given if block.rest[1] else set()
            states = states if block.rest[1] else given
    found: list[list[Fraction]] = []
    received: set[tuple[int, ...]] = set()
    for counts, sums in states:
        left = block.unknown - sum(counts)
        inside = all(low <= n <= high for low, n, high in zip(block.least, counts, block.most, strict=True))
        if inside and block.rest[0] <= left <= block.rest[1]:
            received.add(counts)
            found.append([Fraction(s + t, n + c) for s, t, n, c in zip(block.sums, sums, block.counts, counts, strict=True)])
    ratios = [quotient(max(means), min(means)) for means in found]
    pairs = {(a, b): max(quotient(means[a], means[b]) for means in found) for a in groups for b in groups if a != b}
    return Enumerated(max(ratios), min(ratios), pairs, received, found)


def random_block(pick: random.Random, most: int = 12) -> Block:
    """Two to four groups, two values or more, with ties and zeros, often with limits of every kind."""
    size = pick.choice([2, 2, 2, 3, 3, 4])
    kinds = pick.choice([(1, 0), (1, 0), (3, 1, 0), (5, 3, 2, 0), (4, 3, 1)])
    rows = [
        pick.choice(kinds)
        for _ in range(pick.randint(1, min(most, ({2: 12, 3: 8, 4: 6} if len(kinds) == 2 else {2: 9, 3: 6, 4: 4})[size])))
    ]
    values = sorted(set(rows), reverse=True)
    counts = [pick.choice([1, 1, 2, 3, 4, 8, 20]) for _ in range(size)]
    sums = [
        pick.choice([0, sum(pick.choice(kinds) for _ in range(n)), sum(pick.choice(kinds) for _ in range(n)), max(kinds) * n])
        for n in counts
    ]
    numbers, total = [rows.count(value) for value in values], len(rows)
    least, most_, rest = [0] * size, [total] * size, (0, total)
    while pick.random() < 0.55:
        least = [pick.choice([0, 0, 0, pick.randint(0, total)]) for _ in range(size)]
        most_ = [pick.choice([total, pick.randint(low, total)]) for low in least]
        low = pick.choice([0, 0, pick.randint(0, total)])
        rest = (low, pick.choice([total, low, pick.randint(low, total)]))
        if sum(least) + low <= total <= sum(most_) + rest[1]:
            break
        least, most_, rest = [0] * size, [total] * size, (0, total)
    return Block(tuple(counts), tuple(sums), tuple(values), tuple(numbers), tuple(least), tuple(most_), rest)
