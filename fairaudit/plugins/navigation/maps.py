"""Top view and traversability of a scan, on one frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, UNKNOWN, Frame, OccupancyGrid
from fairaudit.plugins.navigation.readers import Points

BAND = (-0.15, 0.15)
CLEARANCE = 1.5
CEILING = 2.0
RESOLUTION = 0.05
CHUNK = 1 << 15
PASSABLE = "door"  # a door stands in a robot's way only while it is shut
FLOOR_SLAB, FLOOR_SHARE = 0.1, 0.02


@dataclass(frozen=True)
class Maps:
    """What a scan says of a floor: one frame for all."""

    frame: Frame
    rgb: NDArray[np.uint8] = field(repr=False)  # of the highest point of each cell, white if there is none; shades if all have one colour
    height: NDArray[np.float64] = field(repr=False)  # its z in metres, -inf where there is none
    free: NDArray[np.bool_] = field(repr=False)  # which cells can be traversed
    floor: float  # its z in metres
    ground: NDArray[np.bool_] = field(repr=False)  # which cells are free, whatever the robot's radius and a keepout mask

    @property
    def grid(self) -> OccupancyGrid:
        """Traversability as an occupancy map: cells that no point fell into are unknown."""
        states = np.where(self.free, FREE, np.where(np.isfinite(self.height), OCCUPIED, UNKNOWN)).astype(np.int8)
        return OccupancyGrid(self.frame, states)


def rasterise(
    points: Points,
    resolution: float = RESOLUTION,
    *,
    bounds: tuple[float, float, float, float] | None = None,
    floor: float | None = None,
    ceiling: float = CEILING,
    band: tuple[float, float] = BAND,
    clearance: float = CLEARANCE,
    robot_radius: float = 0.0,
) -> Maps:
    """Build the top view and the traversability map of a scan.

    Parameters
    ----------
    resolution : float
        Side of a cell in metres.
    bounds : tuple of float, optional
        Least x and y, greatest x and y of the map, in metres; those of the points by default.
    floor : float, optional
        z of the floor; found by `floor_height` by default. The other heights are metres above it.
    ceiling : float
        Where there are no labels, points higher than this are taken for the ceiling and dropped; where there are, those of the class
        ceiling are.
    band : tuple of float
        A cell is traversable if it has a point between these heights …
    clearance : float
        … and none above the band and up to this height, the robot's, other than of a door. At or below the band's upper end, this second
        condition is void.
    robot_radius : float
        Cells nearer than this to an obstacle are not traversable either.

    Notes
    -----
    Cells without a point are obstacles. A map without a point, or of more than 1e9 cells, is refused. The band alone would let the robot
    through walls and tables, which have points near the floor too; the clearance is what keeps it out.

    Examples
    --------
    >>> import numpy as np
    >>> from fairaudit.plugins.navigation.readers import Part
    >>> xyz = np.array([[0.5, 0.5, 0.0], [1.5, 0.5, 0.0], [1.5, 0.5, 0.7]])
    >>> rgb = np.array([[9, 9, 9], [9, 9, 9], [200, 100, 0]], dtype=np.uint8)
    >>> maps = rasterise(Points(xyz, rgb, (Part(0, 3),), {}), 1.0, floor=0.0)
    >>> maps.free[1, 1:3].tolist(), maps.rgb[1, 2].tolist()
    ([True, False], [200, 100, 0])
    """
    _check(ceiling, band, clearance, robot_radius)
    ground = floor_height(points) if floor is None else floor
    if bounds is not None and not (bounds[0] < bounds[2] and bounds[1] < bounds[3]):
        raise InputError(f"bounds are {list(bounds)}; least x, least y, greatest x, greatest y are accepted")
    tight = Frame.around(bounds or (*points.xyz[:, :2].min(axis=0).tolist(), *points.xyz[:, :2].max(axis=0).tolist()), resolution)
    # one cell more than needed on each side, so that rounding never moves a point off the map
    frame = Frame(tight.x - resolution, tight.y - resolution, resolution, tight.rows + 2, tight.columns + 2)
    size = frame.rows * frame.columns
    top, colours = np.full(size, -inf), np.full(size, -1, np.int32)
    low, blocked = np.zeros(size, np.bool_), np.zeros(size, np.bool_)
    if bounds is not None:
        inner = np.array([frame.x, frame.y]) + frame.resolution
        outer = np.array([frame.x + (frame.columns - 1) * frame.resolution, frame.y + (frame.rows - 1) * frame.resolution])
        points = points.only(np.all((points.xyz[:, :2] >= inner) & (points.xyz[:, :2] < outer), axis=1))
    chunks = ((each, first) for each in points.parts if each.kind != "ceiling" for first in range(each.start, each.stop, CHUNK))
    for part, first in chunks:
        there = slice(first, min(first + CHUNK, part.stop))
        under = points.xyz[there, 2] <= (ground + ceiling if part.kind is None else inf)
        xyz, z = points.xyz[there][under], points.xyz[there, 2][under]
        cells = frame.cells(xyz[:, :2])
        raise_tops(top, colours, cells, z, points.rgb[there][under])
        low[cells.compress((z >= ground + band[0]) & (z <= ground + band[1]))] = True
        if part.kind != PASSABLE:
            blocked[cells.compress((z > ground + band[1]) & (z <= ground + clearance))] = True
    rgb = np.stack([(colours >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)], axis=1)  # -1 has all bits set: white
    if bounds is not None and not np.isfinite(top).any():
        raise InputError(f"no point of the scan lies within the bounds {list(bounds)}")
    seen = np.isfinite(top)
    if seen.any() and (rgb[seen] == rgb[seen][0]).all():  # heights instead: the floor light, what is 2 m high dark
        rgb[seen] = (230 - 190 * np.clip((top[seen] - ground) / 2.0, 0.0, 1.0)).astype(np.uint8)[:, None]
    shape = (frame.rows, frame.columns)
    free = (low & ~blocked).reshape(shape)
    return Maps(frame, rgb.reshape(*shape, 3), top.reshape(shape), inflate(free, robot_radius / frame.resolution), ground, free)


def raise_tops(
    top: NDArray[np.float64], colours: NDArray[np.int32], cells: NDArray[np.int64], z: NDArray[np.float64], rgb: NDArray[np.uint8]
) -> None:
    """Keep in each cell the highest point, and of equally high ones that of the greatest colour, so that their order does not matter."""
    raised = np.flatnonzero(z >= top[cells])
    cells, z = cells[raised], z[raised]
    before = top[cells]
    np.maximum.at(top, cells, z)
    now = top[cells]
    colours[cells[now > before]] = -1
    highest = z == now
    red, green, blue = rgb[raised[highest]].T.astype(np.int32)
    np.maximum.at(colours, cells[highest], red << 16 | green << 8 | blue)


def _check(ceiling: float, band: tuple[float, float], clearance: float, robot_radius: float) -> None:
    if not (len(band) == 2 and isfinite(band[0]) and isfinite(band[1]) and band[0] < band[1]):
        raise InputError(f"band is {list(band)}; two heights in metres, the lower one first, are accepted")
    for name, value in (("ceiling", ceiling), ("clearance", clearance), ("robot_radius", robot_radius)):
        if not (isfinite(value) and value >= 0):
            raise InputError(f"{name} is {value}; a length in metres of at least 0 is accepted")


def floor_height(points: Points) -> float:
    """Find the height of the floor.

    It is the median z of the points of the class floor; without any, that of the lowest slab of 10 cm that holds at least 2 % of all points
    (the highest slab within the next 20 cm if that is fuller, for floors that lean or are noisy).
    """
    labelled = [points.xyz[part.start : part.stop, 2] for part in points.parts if part.kind == "floor"]
    if labelled:
        return round(float(np.median(np.concatenate(labelled))), 4)
    z = np.sort(points.xyz[:, 2])
    held = np.searchsorted(z, z + FLOOR_SLAB, side="right") - np.arange(len(z))
    first = int(np.argmax(held >= FLOOR_SHARE * len(z)))
    near = slice(first, int(np.searchsorted(z, z[first] + 2 * FLOOR_SLAB, side="right")))
    best = first + int(np.argmax(held[near]))
    return round(float(np.median(z[best : best + int(held[best])])), 4)


def inflate(free: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
    """Keep the free cells in which a disc fits: those at whose centre one of this radius, in cells, touches no obstacle.

    What lies off the map is an obstacle, and so is an obstacle's whole cell, whatever corner of it is nearest.

    Examples
    --------
    >>> inflate(np.ones((4, 4), dtype=bool), 1.0).astype(int).tolist()
    [[0, 0, 0, 0], [0, 1, 1, 0], [0, 1, 1, 0], [0, 0, 0, 0]]
    """
    if radius <= 0:
        return free
    return clearances(free) > radius + sqrt(0.5)


def clearances(free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Distance of each cell's centre to that of the nearest obstacle, in cells."""
    from scipy.ndimage import distance_transform_edt

    return np.asarray(distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1], np.float64)


def maps_of_grid(grid: OccupancyGrid, robot_radius: float = 0.0) -> Maps:
    """Show an occupancy map as a scan is shown: free cells white, obstacles black, unknown cells grey."""
    _check(CEILING, BAND, CLEARANCE, robot_radius)
    shade = np.select([grid.free, grid.states == UNKNOWN], [255, 205], 150 - 1.5 * grid.states).astype(np.uint8)
    rgb = np.repeat(shade[:, :, None], 3, axis=2)
    free = inflate(grid.free, robot_radius / grid.frame.resolution)
    return Maps(grid.frame, rgb, np.where(grid.states == UNKNOWN, -inf, 0.0), free, 0.0, grid.free)


def shut(frame: Frame, mask: OccupancyGrid) -> NDArray[np.bool_]:
    """Find the cells at whose centre a keepout mask is occupied, or in which the centre of an occupied cell of the mask lies."""
    kept = np.append(mask.states.ravel() == OCCUPIED, False)
    columns = np.arange(frame.columns)
    closed = np.array([kept[mask.frame.cells(frame.points(np.full_like(columns, row), columns))] for row in range(frame.rows)])
    there = frame.cells(mask.frame.points(*np.nonzero(mask.states == OCCUPIED)))
    closed.ravel()[there[there >= 0]] = True
    return closed
