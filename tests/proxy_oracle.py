"""Random cells of groups that nobody recorded, and what linear programs say of them; nothing of the package is used."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from math import inf

import numpy as np
from scipy.optimize import linprog

Row = tuple[list[tuple[Fraction, int]], tuple[Fraction, ...], tuple[Fraction, ...]]

GAINS = ([0, 1], [0, 1, 2], [1, 2, 5], [0, 0, 1], [0, 3], [0, 0])


def random_rows(rng: random.Random, groups: int, *, intervals: bool = False, cells: int = 4) -> list[Row]:
    """Cells with zeros and ties, in which each group has more than no rows for certain; probabilities exact or as tight intervals."""
    while True:
        gains, rows = rng.choice(GAINS), []
        for _ in range(rng.randint(2, cells)):
            counted = [(Fraction(gain), rng.randint(0, 4)) for gain in gains]
            if not sum(count for _, count in counted):
                counted[0] = (counted[0][0], 1)
            parts = [rng.choice([0, 0, 1, 2, 3, 5]) for _ in range(groups)]
            parts[rng.randrange(groups)] += 1
            shares = [Fraction(part, sum(parts)) for part in parts]
            low = high = tuple(shares)
            if intervals:
                wide = [Fraction(rng.randint(0, 3), 10) for _ in shares]
                least = [max(Fraction(0), share - width) for share, width in zip(shares, wide, strict=True)]
                most = [min(Fraction(1), share + width) for share, width in zip(shares, wide, strict=True)]
                low = tuple(max(one, 1 - sum(most) + other) for one, other in zip(least, most, strict=True))
                high = tuple(min(other, 1 - sum(least) + one) for one, other in zip(least, most, strict=True))
            rows.append((counted, low, high))
        if all(sum(low[a] for _, low, _ in rows) for a in range(groups)):
            return rows


def random_shares(rng: random.Random, row: Row) -> tuple[Fraction, ...]:
    """Shares within intervals, at their ends more often than not."""
    _, low, high = row
    found, left, order = list(low), 1 - sum(low), list(range(len(low)))
    rng.shuffle(order)
    for k, a in enumerate(order):
        room = sum(high[b] - low[b] for b in order[k + 1 :])
        least, most = max(Fraction(0), left - room), min(high[a] - low[a], left)
        step = least + (most - least) * Fraction(rng.choice([0, 0, 10, 10, rng.randint(0, 10)]), 10)
        found[a] += step
        left -= step
    return tuple(found)


class Program:
    """Homogenised joint laws of cell, utility and group: the mean of each group is linear in them after its mass is fixed."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self.rows, self.groups = rows, len(rows[0][1])
        self.places = [(w, v, a) for w, (gains, _, _) in enumerate(rows) for v in range(len(gains)) for a in range(self.groups)]
        self.size = len(self.places) + 2  # and λ, z
        self.equal: list[list[Fraction]] = []
        for w, (gains, low, _) in enumerate(rows):
            rows_of_cell = sum(count for _, count in gains)
            for a in range(self.groups):
                self.equal.append(self._sum(lambda p, w=w, a=a: p[0] == w and p[2] == a, rows_of_cell * low[a]))
            for v, (_, count) in enumerate(gains):
                self.equal.append(self._sum(lambda p, w=w, v=v: p[:2] == (w, v), Fraction(count)))

    def _sum(self, chosen: object, share: Fraction) -> list[Fraction]:
        return [Fraction(bool(chosen(place))) for place in self.places] + [-share, Fraction(0)]  # type: ignore[operator]

    def mean(self, a: int) -> list[Fraction]:
        """The coefficients of λ times the mean of a group."""
        mass = sum(sum(count for _, count in gains) * low[a] for gains, low, _ in self.rows)
        return [self.rows[w][0][v][0] / mass if b == a else Fraction(0) for w, v, b in self.places] + [Fraction(0), Fraction(0)]

    def least(self) -> tuple[list[Fraction], list[tuple[list[Fraction], Fraction]]]:
        """Minimise z where 1 ≤ λE_a ≤ z: the costs, and the rows A v ≤ b."""
        bounds = []
        for a in range(self.groups):
            mean = self.mean(a)
            bounds += [([-c for c in mean], Fraction(-1)), ([*mean[:-1], Fraction(-1)], Fraction(0))]
        return [Fraction(0)] * (self.size - 1) + [Fraction(1)], bounds

    def quotient(self, a: int, b: int, sign: int) -> tuple[list[Fraction], list[tuple[list[Fraction], Fraction]]]:
        """Maximise (sign 1) or minimise E_a where λE_b = 1."""
        mean = self.mean(b)
        return [-sign * c for c in self.mean(a)], [(mean, Fraction(1)), ([-c for c in mean], Fraction(-1))]

    def highs(self, costs: list[Fraction], bounds: list[tuple[list[Fraction], Fraction]]) -> tuple[int, float]:
        """Status and value by HiGHS."""
        found = linprog(
            np.array(costs, dtype=float),
            A_ub=np.array([row for row, _ in bounds], dtype=float),
            b_ub=np.array([b for _, b in bounds], dtype=float),
            A_eq=np.array(self.equal, dtype=float),
            b_eq=np.zeros(len(self.equal)),
            method="highs",
        )
        return found.status, found.fun if found.status == 0 else inf

    def exactly(self, costs: list[Fraction], bounds: list[tuple[list[Fraction], Fraction]]) -> tuple[int, Fraction | float]:
        """Status and value by a simplex in rationals."""
        rows = [([*row, *(Fraction(i == j) for j in range(len(bounds)))], b) for i, (row, b) in enumerate(bounds)]
        rows += [([*row, *([Fraction(0)] * len(bounds))], Fraction(0)) for row in self.equal]
        return simplex([*costs, *([Fraction(0)] * len(bounds))], rows)


def most_beyond(rows: Sequence[Row], wanted: Sequence[tuple[int, Fraction, int]]) -> float:
    """By how much sums of utilities can be beyond given means, all together: 0 if groups can have these means at once and no more.

    Parameters
    ----------
    rows : sequence
        Cells with intervals.
    wanted : sequence of (int, Fraction, int)
        A group, a mean, and 1 for more than it or -1 for less.
    """
    groups = len(rows[0][1])
    places = [(w, v, a) for w, (gains, _, _) in enumerate(rows) for v in range(len(gains)) for a in range(groups)]
    costs = [-float(sum((sign * (rows[w][0][v][0] - mean) for b, mean, sign in wanted if a == b), Fraction(0))) for w, v, a in places]
    equal, counts, limits, bounds = [], [], [], []
    for w, (gains, low, high) in enumerate(rows):
        size = sum(count for _, count in gains)
        for v, (_, count) in enumerate(gains):
            equal.append([float(place[:2] == (w, v)) for place in places])
            counts.append(float(count))
        for a in range(groups):
            own = [float(place[0] == w and place[2] == a) for place in places]
            limits += [own, [-one for one in own]]
            bounds += [float(size * high[a]), -float(size * low[a])]
    found = linprog(costs, A_ub=limits, b_ub=bounds, A_eq=equal, b_eq=counts, method="highs")
    assert found.status == 0
    return -float(found.fun)


def simplex(costs: list[Fraction], rows: list[tuple[list[Fraction], Fraction]]) -> tuple[int, Fraction | float]:
    """Minimise c·x over A x = b, x ≥ 0, by Bland's rule; 0 and the value, 2 if nothing is feasible, 3 if it is unbounded."""
    size, count = len(costs), len(rows)
    table = []
    for i, (row, b) in enumerate(rows):
        sign = -1 if b < 0 else 1
        table.append([*(sign * c for c in row), *(Fraction(i == j) for j in range(count)), sign * b])
    basis = list(range(size, size + count))
    for phase in (1, 2):
        goal = [Fraction(phase == 1 and j >= size) if phase == 1 or j >= size else costs[j] for j in range(size + count)] + [Fraction(0)]
        for i, j in enumerate(basis):
            if goal[j]:
                goal = [one - goal[j] * other for one, other in zip(goal, table[i], strict=True)]
        while True:
            entering = next((j for j in range(size + (count if phase == 1 else 0)) if goal[j] < 0), None)
            if entering is None:
                break
            ways = [(table[i][-1] / table[i][entering], basis[i], i) for i in range(count) if table[i][entering] > 0]
            if not ways:
                return 3, -inf
            leaving = min(ways)[2]
            pivot = table[leaving][entering]
            table[leaving] = [c / pivot for c in table[leaving]]
            for i in range(count):
                if i != leaving and table[i][entering]:
                    factor = table[i][entering]
                    table[i] = [one - factor * other for one, other in zip(table[i], table[leaving], strict=True)]
            factor = goal[entering]
            goal = [one - factor * other for one, other in zip(goal, table[leaving], strict=True)]
            basis[leaving] = entering
        if phase == 1:
            if goal[-1] != 0:
                return 2, inf
            for i in range(count):  # artificial variables at 0 leave the basis where they can
                if basis[i] >= size:
                    other = next((j for j in range(size) if table[i][j]), None)
                    if other is not None:
                        pivot = table[i][other]
                        table[i] = [c / pivot for c in table[i]]
                        for k in range(count):
                            if k != i and table[k][other]:
                                factor = table[k][other]
                                table[k] = [one - factor * two for one, two in zip(table[k], table[i], strict=True)]
                        basis[i] = other
    return 0, -goal[-1]
