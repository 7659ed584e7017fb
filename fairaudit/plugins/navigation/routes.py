"""Shortest routes on a grid: 8-connected, a diagonal step costs √2, and no corner is cut unless that is allowed."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.grids import Frame

Cell = tuple[int, int]

# Steps in the order in which ties are broken: along the axes first.
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
# 3880899/2744210 is a convergent of √2: no fraction with a smaller denominator lies between the two. Two routes whose numbers of diagonal
# steps differ by less than the denominator are therefore ordered as √2 orders them, and all sums are integers below 2^53, exact in float64.
DIAGONAL, STRAIGHT = 3_880_899, 2_744_210


@dataclass(frozen=True)
class Route:
    """A shortest route, or that there is none."""

    cells: NDArray[np.int64] = field(repr=False)  # row and column of each from start to goal; empty if the goal cannot be reached

    @property
    def found(self) -> bool:
        """Whether there is a route."""
        return len(self.cells) > 0

    @property
    def diagonal(self) -> int:
        """Number of diagonal steps."""
        return int((np.abs(np.diff(self.cells, axis=0)).sum(axis=1) == 2).sum())

    @property
    def straight(self) -> int:
        """Number of steps along an axis."""
        return max(len(self.cells) - 1, 0) - self.diagonal

    @property
    def length(self) -> float:
        """Length in cells, infinite if there is no route."""
        return self.straight + self.diagonal * sqrt(2.0) if self.found else inf


@dataclass(frozen=True)
class Flood:
    """Shortest distances from a start to every cell of a map."""

    start: Cell
    free: NDArray[np.bool_] = field(repr=False)
    cost: NDArray[np.float64] = field(repr=False)  # integers, 2,744,210 for a step along an axis; infinite where no route leads
    allowed: NDArray[np.uint8] = field(repr=False)  # bit k: whether the k-th step can be taken from a cell

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Which cells a route leads to."""
        return np.isfinite(self.cost)

    def route(self, goal: Cell) -> Route:
        """Walk back from a goal, a row and a column, along cells whose costs fit; every such walk is a shortest route.

        Of several the one is taken that goes on straight where it can and else takes the first direction of a fixed order.
        """
        _free(self.free, goal, "goal")
        if not np.isfinite(self.cost[goal]):
            return Route(np.empty((0, 2), np.int64))
        cells, (row, column), last = [goal], goal, 0
        while (row, column) != self.start:
            here, can = self.cost[row, column], int(self.allowed[row, column])
            for bit in (last, *range(8)):
                i, j = STEPS[bit]
                if can >> bit & 1 and self.cost[row + i, column + j] + (DIAGONAL if i and j else STRAIGHT) == here:
                    row, column, last = row + i, column + j, bit
                    break
            cells.append((row, column))
        return Route(np.array(cells[::-1], np.int64))


def flood(free: NDArray[np.bool_], start: Cell, *, corner_cutting: bool = False) -> Flood:
    """Find the shortest distances from a start, a row and a column, to all cells that are free; no corner is cut unless that is allowed.

    Dijkstra's algorithm (scipy), once for all goals, on integer costs. A route shorter than 3,880,000 cells is exactly optimal for √2, as
    it and every route as short have fewer than 2,744,210 diagonal steps; a longer one is within 1 + 1e-13 of the optimum.

    Examples
    --------
    >>> route = flood(np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], dtype=bool), (0, 0)).route((2, 2))
    >>> route.cells.tolist(), route.straight, route.diagonal
    ([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2]], 4, 0)
    """
    from scipy.sparse.csgraph import dijkstra

    _free(free, start, "start")
    allowed = _allowed(free, corner_cutting=corner_cutting)
    cost = dijkstra(_graph(allowed), indices=start[0] * free.shape[1] + start[1]).reshape(free.shape)
    return Flood(start, free, cost, allowed)


def _free(free: NDArray[np.bool_], cell: Cell, name: str) -> None:
    if not (0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1] and free[cell]):
        raise InputError(f"the {name} (row {cell[0]}, column {cell[1]}) is not a free cell of the map")


def _allowed(free: NDArray[np.bool_], *, corner_cutting: bool) -> NDArray[np.uint8]:
    """Bit k of a cell: whether the k-th step can be taken from it."""
    rows, columns = free.shape
    around = np.zeros((rows + 2, columns + 2), np.bool_)
    around[1:-1, 1:-1] = free
    allowed = np.zeros((rows, columns), np.uint8)
    for bit, (i, j) in enumerate(STEPS):
        can = free & around[1 + i : 1 + i + rows, 1 + j : 1 + j + columns]
        if i and j and not corner_cutting:
            can &= around[1 + i : 1 + i + rows, 1:-1]
            can &= around[1:-1, 1 + j : 1 + j + columns]
        allowed |= can.view(np.uint8) << np.uint8(bit)
    return allowed


def _graph(allowed: NDArray[np.uint8]) -> Any:
    """Sparse matrix of the costs of steps."""
    from scipy.sparse import csr_array

    cells, size = allowed.size, int(np.bitwise_count(allowed).sum(dtype=np.int64))
    if max(size, cells) > np.iinfo(np.int32).max:
        raise InputError(f"a map of {cells:,} cells with {size:,} steps is too large to plan on; use a coarser resolution or bounds")
    sources = [np.flatnonzero(allowed & np.uint8(1 << bit)).astype(np.int32) for bit in range(8)]
    targets = [there + np.int32(i * allowed.shape[1] + j) for there, (i, j) in zip(sources, STEPS, strict=True)]
    costs = np.repeat([float(DIAGONAL if i and j else STRAIGHT) for i, j in STEPS], [len(there) for there in sources])
    return csr_array((costs, (np.concatenate(sources), np.concatenate(targets))), shape=(cells, cells))


def waypoints(route: Route, frame: Frame) -> list[tuple[float, float]]:
    """Points in metres at which a robot starts, turns and arrives, at the centres of cells.

    Examples
    --------
    >>> route = flood(np.ones((3, 5), dtype=bool), (0, 0)).route((2, 4))
    >>> waypoints(route, Frame(0.0, 0.0, 0.5, 3, 5))
    [(0.25, 1.25), (1.25, 0.25), (2.25, 0.25)]
    """
    if not route.found:
        return []
    steps = np.diff(route.cells, axis=0)
    turns = np.flatnonzero((steps[1:] != steps[:-1]).any(axis=1)) + 1
    kept = [0, *turns.tolist(), len(route.cells) - 1] if len(route.cells) > 1 else [0]
    return [frame.centre(int(row), int(column)) for row, column in route.cells[kept]]


def nearest_free(free: NDArray[np.bool_], cell: Cell) -> Cell | None:
    """Return the free cell nearest to a cell (the first in reading order among equals), or None if no cell is free."""
    there = np.argwhere(free)
    if not len(there):
        return None
    away = ((there - np.array(cell)) ** 2).sum(axis=1)
    row, column = there[int(away.argmin())]
    return int(row), int(column)
