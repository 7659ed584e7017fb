"""Linear programs over distributions with a few floors, solved exactly.

A policy is a distribution of decisions for every output. The greatest Σ c·T over policies T with Σ e·T ≥ f for some rows e is found by the
simplex method in integers, on the decisions that are best at some prices of the floors that were tried: prices that prove that no others
are needed end the search. One policy that keeps the floors is known from the start, so that there always is an answer.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.linear_programs import ask_solver, distribution_sums

MORE = 4
"""Floors that are taken note of at a time."""

WORTH_ASKING = 1_000
"""Decisions at outputs, times floors, from which on a solver is asked first."""

NEARLY = 1e-7
"""What solvers reach as a rule."""

Whole = NDArray[Any]
"""An array of Python integers."""


@dataclass(frozen=True, eq=False)
class Floored:
    """Policies that keep floors.

    Attributes
    ----------
    rows : ndarray, shape (floors, outputs, decisions)
        What must reach a floor, as Python integers.
    floors : list of int
        The floors, all positive.
    start : ndarray, shape (outputs, decisions)
        A policy that keeps them, as Python integers.
    whole : int
        What its rows sum to.
    """

    rows: Whole
    floors: list[int]
    start: Whole
    whole: int


@dataclass(frozen=True, eq=False)
class Optimum:
    """A policy that maximises Σ c·T, and prices y ≥ 0 of floors with Σ_o max_u (c + Σ y·e) = Σ y·f + Σ c·T, which prove it.

    Attributes
    ----------
    policy : ndarray, shape (outputs, decisions)
        The policy, as integers.
    whole : int
        What its rows sum to.
    prices : dict of int to Fraction
        y > 0 by floor.
    """

    policy: Whole
    whole: int
    prices: dict[int, Fraction]


class Search:
    """Answers for one set of policies; what one answer needed is where the next one starts."""

    def __init__(self, policies: Floored) -> None:
        self._policies = policies
        self._tried = np.zeros(policies.start.shape, dtype=bool)
        self._active: list[int] = []

    def greatest(self, costs: Whole) -> Optimum:
        """Maximise Σ c·T.

        Examples
        --------
        >>> rows = np.array([[[3, 0], [7, 0]]], dtype=object)
        >>> half = Floored(rows, [5], np.array([[1, 0], [1, 0]], dtype=object), 1)
        >>> found = Search(half).greatest(np.array([[4, 0], [-4, 0]], dtype=object))
        >>> found.policy.tolist(), found.whole, found.prices
        ([[7, 0], [2, 5]], 7, {0: Fraction(4, 7)})
        """
        rows, floors = self._policies.rows, self._policies.floors
        self._propose(costs)
        self._add(costs)
        while True:
            policy, whole, prices = self._restricted(costs)
            kept = (rows * policy).sum(axis=(1, 2)).tolist()
            missed = [i for i, floor in enumerate(floors) if kept[i] < floor * whole]
            self._active += sorted(missed, key=lambda i: Fraction(kept[i], floors[i]))[:MORE]
            if not self._add(sum((y * rows[i] for i, y in prices.items()), whole * costs)) and not missed:
                return Optimum(policy, whole, {i: Fraction(y, whole) for i, y in prices.items() if y})

    def _propose(self, costs: Whole) -> None:
        """Try what is nearly best at the prices that a solver finds, where that saves time."""
        if self._tried.size * len(self._policies.floors) < WORTH_ASKING:
            return
        try:
            worth = (costs / max(1, abs(costs).max())).astype(np.float64)
            rows = (self._policies.rows / np.array(self._policies.floors, dtype=object)[:, None, None]).astype(np.float64)
        except OverflowError:
            return
        outputs, decisions = worth.shape
        sums = distribution_sums([range(o * decisions, (o + 1) * decisions) for o in range(outputs)], worth.size)
        answer = ask_solver(-worth.ravel(), -rows.reshape(len(rows), -1), -np.ones(len(rows)), sums, (0, 1))
        if answer is not None:
            worth += np.tensordot(answer[1], rows, axes=1)
            self._tried |= worth >= worth.max(axis=1)[:, None] - NEARLY
            self._active += [i for i in np.flatnonzero(answer[1] > NEARLY).tolist() if i not in self._active]

    def _add(self, worth: Whole) -> bool:
        """Try the best decisions of every output where none of them was tried."""
        best = worth == worth.max(axis=1)[:, None]
        best &= ~(best & self._tried).any(axis=1)[:, None]
        self._tried |= best
        return bool(best.any())

    def _restricted(self, costs: Whole) -> tuple[Whole, int, dict[int, int]]:
        """The best mixture of the known policy with those that take decisions that were tried, and prices of the active floors.

        Policy and prices are over one denominator. Outputs with one decision that was tried are one in the tableau.
        """
        known, active = self._policies, self._active
        open_ = np.flatnonzero(self._tried.sum(axis=1) > 1)
        alone = self._tried.copy()
        alone[open_] = False
        at, decisions = np.nonzero(self._tried[open_])
        outputs = open_[at]
        n, r, m = len(at), len(open_), len(active)
        lines = np.concatenate((known.rows[active], costs[None]))
        tableau = np.zeros((r + 1 + m + 1, n + 2 + m + 1), dtype=object)
        tableau[at, np.arange(n)] = 1
        tableau[r, n] = 1
        tableau[: r + 1, n + 1] = known.whole
        tableau[: r + 1, -1] = 1
        tableau[r + 1 :, :n] = -lines[:, outputs, decisions]
        tableau[r + 1 :, n] = -lines[:, alone].sum(axis=1)
        tableau[r + 1 :, n + 1] = -(lines * known.start).sum(axis=(1, 2))
        tableau[np.arange(r + 1, r + 1 + m), np.arange(n + 2, n + 2 + m)] = 1
        tableau[r + 1 : -1, -1] = [-known.floors[i] for i in active]
        basis = [*np.searchsorted(at, np.arange(r)).tolist(), *range(n, n + 1), *range(n + 2, n + 2 + m)]
        tableau[r + 1 :] -= tableau[r + 1 :, basis[: r + 1]] @ tableau[: r + 1]
        whole = _pivot(tableau, 1, basis, r, n + 1)  # the known policy keeps all floors
        whole = _simplex(tableau, whole, basis)
        shares = dict(zip(basis, tableau[:-1, -1].tolist(), strict=True))
        policy = known.start * shares.get(n + 1, 0) + alone.astype(object) * shares.get(n, 0)
        policy[outputs, decisions] += np.array([shares.get(j, 0) for j in range(n)], dtype=object)
        return policy, whole, dict(zip(active, tableau[-1, n + 2 : -1].tolist(), strict=True))


def _simplex(tableau: Whole, whole: int, basis: list[int]) -> int:
    """Pivot until no column gains; after a pivot that gained nothing the first column that gains is taken, so that it ends."""
    stalled = False
    while True:
        gains = tableau[-1, :-1]
        gaining = np.flatnonzero(gains < 0)
        if not len(gaining):
            return whole
        column = int(gaining[0] if stalled else gaining[np.argmin(gains[gaining])])
        rows = np.flatnonzero(tableau[:-1, column] > 0).tolist()
        row = min(rows, key=lambda i: (Fraction(tableau[i, -1], tableau[i, column]), basis[i]))
        stalled = tableau[row, -1] == 0
        whole = _pivot(tableau, whole, basis, row, column)


def _pivot(tableau: Whole, whole: int, basis: list[int], row: int, column: int) -> int:
    """Exchange a column for that of a row, in integers over a denominator, which becomes another."""
    pivot, kept = tableau[row, column], tableau[row].copy()
    tableau[:] = (tableau * pivot - np.outer(tableau[:, column], kept)) // whole
    tableau[row] = kept
    basis[row] = column
    return int(pivot)
