"""Routes: optimal by published lengths and by an independent search, legal, and equal for equal input."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from math import inf, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.grids import Frame, read_grid
from fairaudit.plugins.navigation.routes import DIAGONAL, STRAIGHT, Route, flood, nearest_free, waypoints


def routes(
    free: np.ndarray, start: tuple[int, int], goals: Iterable[tuple[int, int]], *, corner_cutting: bool = False
) -> tuple[Route, ...]:
    found = flood(free, start, corner_cutting=corner_cutting)
    return tuple(found.route(goal) for goal in goals)


def all_lengths(free: np.ndarray, *, corner_cutting: bool) -> np.ndarray:
    """Lengths between all pairs of cells, from the definition, by loops and √2 as a float."""
    rows, columns = free.shape
    edges: list[tuple[int, int, float]] = []
    for r in range(rows):
        for c in range(columns):
            for i in (-1, 0, 1):
                for j in (-1, 0, 1):
                    a, b = r + i, c + j
                    if (i, j) == (0, 0) or not (0 <= a < rows and 0 <= b < columns and free[r, c] and free[a, b]):
                        continue
                    if i and j and not corner_cutting and not (free[r, b] and free[a, c]):
                        continue
                    edges.append((r * columns + c, a * columns + b, sqrt(2) if i and j else 1.0))
    source, target, cost = zip(*edges, strict=True) if edges else ((), (), ())
    size = rows * columns
    places = np.array([source, target], dtype=np.int32)
    return dijkstra(coo_array((cost, (places[0], places[1])), shape=(size, size)).tocsr())


def assert_legal(route: Route, free: np.ndarray, start: tuple[int, int], goal: tuple[int, int], *, corner_cutting: bool) -> None:
    cells = [tuple(cell) for cell in route.cells.tolist()]
    assert cells[0] == start and cells[-1] == goal and all(free[cell] for cell in cells)
    for (r, c), (a, b) in pairwise(cells):
        assert max(abs(r - a), abs(c - b)) == 1
        assert corner_cutting or (free[r, b] and free[a, c])


def test_arena_has_the_published_lengths(data: Path) -> None:
    grid = read_grid(data / "maps" / "arena.map")
    lines = (data / "maps" / "arena.map.scen").read_text().splitlines()[1:]
    assert len(lines) == 160
    for _, _, _, _, x, y, goal_x, goal_y, length in map(str.split, lines):
        start, goal = (int(y), int(x)), (int(goal_y), int(goal_x))
        (route,) = routes(grid.free, start, [goal])
        assert abs(route.length - float(length)) <= 6e-4
        assert_legal(route, grid.free, start, goal, corner_cutting=False)


@settings(max_examples=60)
@given(st.integers(1, 9), st.integers(1, 9), st.floats(0, 0.6), st.integers(0, 2**32), st.booleans())
def test_every_pair_of_random_maps(rows: int, columns: int, share: float, seed: int, corner_cutting: bool) -> None:
    free = np.random.default_rng(seed).random((rows, columns)) >= share
    truth = all_lengths(free, corner_cutting=corner_cutting)
    cells = [(int(r), int(c)) for r, c in np.argwhere(free)]
    for start in cells:
        for goal, route in zip(cells, routes(free, start, cells, corner_cutting=corner_cutting), strict=True):
            length = truth[start[0] * columns + start[1], goal[0] * columns + goal[1]]
            assert route.found == (length < inf)
            if route.found:
                assert abs(route.length - length) < 1e-9
                assert_legal(route, free, start, goal, corner_cutting=corner_cutting)
            else:
                assert route.length == inf and waypoints(route, Frame(0, 0, 1, rows, columns)) == []


def test_larger_random_maps() -> None:
    random = np.random.default_rng(3)
    for share in (0.1, 0.3, 0.4):
        free = random.random((60, 50)) >= share
        truth = all_lengths(free, corner_cutting=False)
        for start in random.permutation(np.argwhere(free))[:5].tolist():
            lengths = flood(free, (start[0], start[1])).cost / STRAIGHT
            expected = truth[start[0] * 50 + start[1]].reshape(60, 50)
            assert (np.isfinite(lengths) == np.isfinite(expected)).all()
            assert np.allclose(lengths[np.isfinite(lengths)], expected[np.isfinite(expected)], atol=1e-9, rtol=0)


def test_costs_order_routes_as_the_root_of_two_does() -> None:
    """The fraction of the costs is a convergent of √2, so no fraction with a smaller denominator lies between the two."""
    assert abs(DIAGONAL**2 - 2 * STRAIGHT**2) == 1
    assert DIAGONAL * 1_000_000_000 < 2**53


def test_ties_are_broken_the_same_way() -> None:
    free = np.random.default_rng(1).random((40, 40)) >= 0.2
    free[0, 0] = free[39, 39] = True
    first, second = routes(free, (0, 0), [(39, 39)]), routes(free.copy(), (0, 0), [(39, 39), (0, 0)])
    assert (first[0].cells == second[0].cells).all()
    assert second[1].cells.tolist() == [[0, 0]] and second[1].length == 0 and second[1].found


def test_waypoints_are_the_turns(tmp_path: Path) -> None:
    free = np.ones((3, 4), bool)
    free[1, 1:] = False
    (route,) = routes(free, (0, 3), [(2, 3)])
    frame = Frame(10.0, 20.0, 0.5, 3, 4)
    assert waypoints(route, frame) == [(11.75, 21.25), (10.25, 21.25), (10.25, 20.25), (11.75, 20.25)]
    assert (route.straight, route.diagonal, route.length) == (8, 0, 8.0)


def test_cells_that_are_not_free_are_refused() -> None:
    free = np.array([[True, False]])
    for start, goal in (((0, 1), (0, 0)), ((0, 0), (0, 1)), ((0, 0), (0, 2)), ((-1, 0), (0, 0))):
        with pytest.raises(InputError, match="is not a free cell"):
            routes(free, start, [goal])


def test_nearest_free() -> None:
    free = np.zeros((5, 5), bool)
    assert nearest_free(free, (2, 2)) is None
    free[0, 2] = free[2, 4] = free[4, 4] = True
    assert nearest_free(free, (2, 2)) == (0, 2)
    assert nearest_free(free, (4, 3)) == (4, 4)


def test_route_through_turtlebot_map(data: Path, tmp_path: Path) -> None:
    """From the robot's start to the far end of the map, around the pillars, by the length of an independent search."""
    (tmp_path / "map.pgm").write_bytes((data / "maps" / "turtlebot3_map.pgm").read_bytes())
    (tmp_path / "map.yaml").write_bytes((data / "maps" / "turtlebot3_map.yaml").read_bytes())
    pytest.importorskip("yaml")
    grid = read_grid(tmp_path / "map.yaml")
    rows, columns = np.nonzero(grid.free)
    box = grid.free[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    start = grid.frame.cell(-2.0, -0.5)
    shifted = (start[0] - int(rows.min()), start[1] - int(columns.min()))
    found = flood(box, shifted)
    far = divmod(int(np.where(found.reached, found.cost, -1).argmax()), box.shape[1])
    route = found.route(far)
    assert_legal(route, box, shifted, far, corner_cutting=False)
    truth = all_lengths_from(box, shifted)
    assert abs(route.length - truth[far]) < 1e-9 and route.length > 80


def maze(side: int, random: np.random.Generator) -> np.ndarray:
    """Corridors one cell wide, by Wilson's walks without memory of what was visited: some loops, some dead ends."""
    free = np.zeros((side, side), bool)
    cell, free[1, 1] = (1, 1), True
    for _ in range(side * side):
        i, j = ((0, 2), (2, 0), (0, -2), (-2, 0))[int(random.integers(4))]
        r, c = cell[0] + i, cell[1] + j
        if 0 < r < side and 0 < c < side:
            free[r, c] = free[cell[0] + i // 2, cell[1] + j // 2] = True
            cell = (r, c)
    return free


def rooms(side: int, random: np.random.Generator) -> np.ndarray:
    """Walls every few cells, each with a door or two."""
    free = np.ones((side, side), bool)
    free[8::9], free[:, 8::9] = False, False
    for wall in range(8, side, 9):
        for first in range(0, side - 8, 9):
            free[wall, first + int(random.integers(8))] = free[first + int(random.integers(8)), wall] = True
    return free


@pytest.mark.parametrize("seed", range(20))
def test_generated_maps_have_the_lengths_of_an_independent_search(seed: int) -> None:
    random = np.random.default_rng(seed)
    free = (maze, rooms, lambda side, random: random.random((side, side)) > 0.3)[seed % 3](63, random)
    places = [(int(r), int(c)) for r, c in random.permutation(np.argwhere(free))[:12]]
    truth = all_lengths_from(free, places[0])
    lengths = flood(free, places[0]).cost / STRAIGHT
    assert (np.isfinite(lengths) == np.isfinite(truth)).all()
    assert np.allclose(lengths[np.isfinite(truth)], truth[np.isfinite(truth)], atol=1e-9, rtol=0)
    for goal, route in zip(places, routes(free, places[0], places), strict=True):
        assert route.length == pytest.approx(truth[goal], abs=1e-9)
        if route.found:
            assert_legal(route, free, places[0], goal, corner_cutting=False)


def all_lengths_from(free: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    """Lengths from one cell by the standard library's heap, with √2 as a float."""
    import heapq

    length = np.full(free.shape, inf)
    length[start] = 0.0
    heap = [(0.0, start)]
    while heap:
        here, (r, c) = heapq.heappop(heap)
        if here > length[r, c]:
            continue
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                a, b = r + i, c + j
                if not (0 <= a < free.shape[0] and 0 <= b < free.shape[1] and free[a, b] and free[r, b] and free[a, c]):
                    continue
                there = here + sqrt(i * i + j * j)
                if there < length[a, b] - 1e-12:
                    length[a, b] = there
                    heapq.heappush(heap, (there, (a, b)))
    return length
