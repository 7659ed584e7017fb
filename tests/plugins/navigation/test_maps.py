"""Maps of a scan against plain loops over its points, and the pictures drawn of them."""

from __future__ import annotations

from itertools import pairwise
from math import hypot, inf
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.plugins.navigation import maps as maps_module
from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, UNKNOWN, Frame, OccupancyGrid
from fairaudit.plugins.navigation.maps import floor_height, inflate, rasterise, shut
from fairaudit.plugins.navigation.readers import Part, Points, read_points
from fairaudit.plugins.navigation.routes import flood


def cloud(xyz: np.ndarray, kinds: list[str | None], seed: int = 0) -> Points:
    """Points whose parts are runs of equal kinds."""
    rgb = np.random.default_rng(seed).integers(0, 255, (len(xyz), 3)).astype(np.uint8)
    bounds = [0, *(i for i in range(1, len(kinds)) if kinds[i] != kinds[i - 1]), len(kinds)]
    parts = tuple(Part(a, b, None, kinds[a]) for a, b in pairwise(bounds))
    return Points(xyz, rgb, parts, {})


@settings(max_examples=60)
@given(st.integers(1, 120), st.integers(0, 2**32), st.sampled_from([0.1, 0.25, 1.0]), st.booleans(), st.booleans())
def test_maps_are_what_the_definition_says(size: int, seed: int, resolution: float, labelled: bool, bounded: bool) -> None:
    """Highest point that is no ceiling, a point in the band, none but a door's in the way: by loops, in chunks of seven points."""
    random = np.random.default_rng(seed)
    xyz = np.round(random.uniform(-1.0, 2.0, (size, 3)) * [1, 1, 1.5], 2)
    kinds: list[str | None] = [str(k) for k in random.choice(["floor", "ceiling", "wall", "door"], size)] if labelled else [None] * size
    points = cloud(xyz, kinds, seed)
    bounds = (-0.6, -0.4, 1.1, 0.9) if bounded else None
    before, maps_module.CHUNK = maps_module.CHUNK, 7
    try:
        maps = rasterise(points, resolution, floor=0.0, ceiling=1.8, band=(-0.2, 0.3), clearance=1.0, bounds=bounds)
    except InputError as error:
        assert bounded and "no point of the scan lies within" in str(error)
        return
    finally:
        maps_module.CHUNK = before
    frame = maps.frame
    top: dict[tuple[int, int], tuple[float, list[int]]] = {}
    low, blocked = set(), set()
    inner = (
        frame.x + resolution,
        frame.y + resolution,
        frame.x + (frame.columns - 1) * resolution,
        frame.y + (frame.rows - 1) * resolution,
    )
    for (x, y, z), colour, kind in zip(xyz.tolist(), points.rgb.tolist(), kinds, strict=True):
        if kind == "ceiling" or (kind is None and z > 1.8) or (bounded and not (inner[0] <= x < inner[2] and inner[1] <= y < inner[3])):
            continue
        cell = frame.cell(x, y)
        if cell not in top or (z, colour) > top[cell]:
            top[cell] = (z, colour)
        if -0.2 <= z <= 0.3:
            low.add(cell)
        if 0.3 < z <= 1.0 and kind != "door":
            blocked.add(cell)
    one_colour = len({tuple(colour) for _, colour in top.values()}) == 1
    for row in range(frame.rows):
        for column in range(frame.columns):
            height, colour = top.get((row, column), (-inf, [255, 255, 255]))
            assert maps.height[row, column] == pytest.approx(height, abs=1e-9)
            assert one_colour or maps.rgb[row, column].tolist() == colour
            assert maps.free[row, column] == ((row, column) in low and (row, column) not in blocked)
    states = maps.grid.states
    assert ((states == UNKNOWN) == ~np.isfinite(maps.height)).all() and ((states == FREE) == maps.free).all()


def test_order_of_points_does_not_matter() -> None:
    random = np.random.default_rng(8)
    xyz = np.round(random.uniform(0, 2, (3000, 3)), 1)
    points = cloud(xyz, [None] * 3000)
    order = random.permutation(3000)
    shuffled = Points(points.xyz[order], points.rgb[order], points.parts, {})
    one, other = (rasterise(p, 0.2, floor=0.0) for p in (points, shuffled))
    assert (one.rgb == other.rgb).all() and (one.height == other.height).all() and (one.free == other.free).all()


def test_band_alone_is_the_papers_rule() -> None:
    xyz = np.array([[0.5, 0.5, 0.0], [1.5, 0.5, 0.05], [1.5, 0.5, 1.0], [2.5, 0.5, 1.0]])
    points = cloud(xyz, [None] * 4)
    assert rasterise(points, 1.0, floor=0.0).free[1, 1:4].tolist() == [True, False, False]
    assert rasterise(points, 1.0, floor=0.0, clearance=0.0).free[1, 1:4].tolist() == [True, True, False]


@settings(max_examples=60)
@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 2**32), st.floats(0, 4))
def test_a_disc_fits_where_it_is_said_to(rows: int, columns: int, seed: int, radius: float) -> None:
    """Safe: no kept cell has an obstacle's square within the radius. Not much looser than needed: a cell that is dropped has one within
    the radius and the diagonal of a cell."""
    free = np.random.default_rng(seed).random((rows, columns)) > 0.15
    kept = inflate(free, radius)
    around = np.zeros((rows + 2, columns + 2), bool)
    around[1:-1, 1:-1] = free
    obstacles = np.argwhere(~around) - 1
    for row in range(rows):
        for column in range(columns):
            gap = min(hypot(max(abs(r - row) - 0.5, 0), max(abs(c - column) - 0.5, 0)) for r, c in obstacles)
            if kept[row, column]:
                assert free[row, column] and gap >= radius - 1e-9
            elif free[row, column]:
                assert gap <= radius + 0.71


@settings(max_examples=40)
@given(st.integers(0, 2**32), st.floats(-4, 4), st.floats(-4, 4), st.sampled_from([0.03, 0.1, 0.4]))
def test_a_keepout_mask_shuts_what_it_covers(seed: int, yaw: float, turn: float, side: float) -> None:
    """By loops over the cells of both: the mask at the centre of a cell, and centres of the mask's cells in it."""
    random = np.random.default_rng(seed)
    states = random.choice(np.array([FREE, OCCUPIED, UNKNOWN, 60], np.int8), (9, 6), p=[0.5, 0.3, 0.1, 0.1])
    frame, mask = Frame(0, 0, 0.1, 8, 12, turn), OccupancyGrid(Frame(*random.uniform(-0.5, 1, 2), side, 9, 6, yaw), states)

    def there(one: Frame, other: Frame, row: int, column: int) -> tuple[int, int] | None:
        try:
            return one.cell(*other.points(row, column))
        except InputError:
            return None

    closed = {there(frame, mask.frame, *cell) for cell in np.ndindex(9, 6) if states[cell] == OCCUPIED}
    for cell in np.ndindex(8, 12):
        at = there(mask.frame, frame, *cell)
        assert shut(frame, mask)[cell] == (cell in closed or (at is not None and states[at] == OCCUPIED))


def test_floor_height() -> None:
    random = np.random.default_rng(2)
    z = np.concatenate([random.normal(0.4, 0.01, 3000), random.uniform(0.4, 3.0, 4000), random.normal(3.0, 0.01, 9000), [-2.0] * 20])
    xyz = np.zeros((len(z), 3))
    xyz[:, 2] = z
    assert abs(floor_height(cloud(xyz, [None] * len(z))) - 0.4) < 0.02
    assert floor_height(cloud(np.array([[0, 0, 1.0], [0, 0, 2.0], [0, 0, 9.0]]), ["floor", "floor", "wall"])) == 1.5
    assert floor_height(cloud(np.array([[0, 0, 1.0]]), [None])) == 1.0


def test_resolution_that_needs_too_many_cells() -> None:
    points = cloud(np.array([[0.0, 0, 0], [100.0, 100.0, 0]]), [None, None])
    with pytest.raises(InputError, match="would need more than 1,000,000,000 cells"):
        rasterise(points, 0.003)
    for options in (
        {"resolution": 0.0},
        {"band": (1.0, 0.0)},
        {"clearance": -1.0},
        {"robot_radius": inf},
        {"bounds": (1.0, 0.0, 0.0, 1.0)},
    ):
        with pytest.raises(InputError):
            rasterise(points, **options)  # type: ignore[arg-type]


def test_real_scan_and_a_route_across(data: Path) -> None:
    """A room with desks and cabinets along its walls; the way to the door leads around what stands in the middle."""
    points = read_points(data / "scans" / "room_scan1.txt.gz")
    maps = rasterise(points, 0.08, bounds=(-4.0, -3.0, 5.0, 4.0))
    assert maps.floor == pytest.approx(-1.27, abs=0.05)
    start, goal = maps.frame.cell(-1.2, 0.6), maps.frame.cell(1.5, -0.4)
    assert maps.free[start] and maps.free[goal]
    route = flood(maps.free, start).route(goal)
    straight = hypot(2.7, 1.0) / 0.08
    assert route.found and straight - 2 <= route.length < 2 * straight
    assert not maps.free[maps.frame.cell(-2.4, 1.0)]  # a desk at the wall
    shades = maps.rgb[np.isfinite(maps.height)]
    assert len(np.unique(shades, axis=0)) > 50  # a scan of one colour is shown by height
