"""Grids: their frame in metres, occupancy maps of ROS, and grid maps of the MovingAI benchmarks."""

from __future__ import annotations

import hashlib
import json
import re
import warnings
from dataclasses import dataclass, field
from math import cos, floor, isfinite, sin
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fairaudit.errors import InputError, shown
from fairaudit.files import check_keys, read_bytes, write_together
from fairaudit.libraries import library

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
MAX_CELLS = 1_000_000_000
PASSABLE, BLOCKED = b".GS", b"@OTW"
MOVING_AI = re.compile(rb"type \S+\n(height|width) (\d{1,9})\n(?!\1)(height|width) (\d{1,9})\nmap\n")
MAP_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode", "map_type")
MODES, PICTURES = ("trinary", "scale", "raw"), (".pgm", ".png", ".bmp")


@dataclass(frozen=True)
class Frame:
    """Where the cells of a grid lie: row 0 is the top row, column 0 the left one, as in a picture.

    Examples
    --------
    >>> frame = Frame(0.0, 0.0, 0.5, rows=4, columns=6)
    >>> frame.cell(0.1, 0.1), frame.centre(3, 0)
    ((3, 0), (0.25, 0.25))
    """

    x: float  # of the lower left corner of the grid, in metres
    y: float
    resolution: float  # side of a cell, in metres
    rows: int
    columns: int
    yaw: float = 0.0  # by what angle it is turned about this corner, in radians, counterclockwise; at 0, rows lie along x

    def __post_init__(self) -> None:
        """Refuse what is no grid, and grids too large to be meant."""
        if not (isfinite(self.resolution) and self.resolution > 0):
            raise InputError(f"the resolution is {self.resolution}; a length in metres above 0, such as 0.05, is accepted")
        if not (isfinite(self.x) and isfinite(self.y) and isfinite(self.yaw)):
            raise InputError(f"the origin of the map is ({self.x}, {self.y}) with yaw {self.yaw}; finite numbers are accepted")
        if self.rows < 1 or self.columns < 1:
            raise InputError(f"the map has {self.rows} rows and {self.columns} columns; at least one cell is needed")
        if self.rows * self.columns > MAX_CELLS:
            cells = f"{self.rows:,} × {self.columns:,} cells of {self.resolution:g} m"
            raise InputError(f"a map of {cells} would need more than {MAX_CELLS:,} cells; use a coarser resolution or bounds")

    @classmethod
    def around(cls, bounds: tuple[float, float, float, float], resolution: float) -> Frame:
        """Frame of whole cells, at multiples of the resolution, that covers ``(least x, least y, greatest x, greatest y)``."""
        cls(0.0, 0.0, resolution, 1, 1)  # refuses what is no resolution
        ends = [value / resolution for value in bounds]
        if not all(isfinite(end) and abs(end) < 2**53 for end in ends):
            raise InputError(f"the bounds {bounds} cannot be divided into cells of {resolution} m")
        left, low, right, high = (floor(end) for end in ends)
        return cls(left * resolution, low * resolution, resolution, high - low + 1, right - left + 1)

    def cells(self, xy: ArrayLike) -> NDArray[np.int64]:
        """Position of the cell of each point, in reading order; -1 off the grid."""
        x, y = np.asarray(xy, np.float64).T
        along = np.floor((cos(self.yaw) * (x - self.x) + sin(self.yaw) * (y - self.y)) / self.resolution)
        up = np.floor((cos(self.yaw) * (y - self.y) - sin(self.yaw) * (x - self.x)) / self.resolution)
        inside = (along >= 0) & (along < self.columns) & (up >= 0) & (up < self.rows)
        return np.where(inside, (self.rows - 1 - up) * self.columns + along, -1).astype(np.int64)

    def points(self, rows: ArrayLike, columns: ArrayLike) -> NDArray[np.float64]:
        """Centres of cells in metres; halves and more are their corners."""
        along = (np.asarray(columns) + 0.5) * self.resolution
        up = (self.rows - np.asarray(rows) - 0.5) * self.resolution
        turned = cos(self.yaw) * along - sin(self.yaw) * up, sin(self.yaw) * along + cos(self.yaw) * up
        return np.stack([self.x + turned[0], self.y + turned[1]], axis=-1)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the cell in which a point lies; a point off the grid is refused."""
        found = int(self.cells([(x, y)])[0]) if isfinite(x) and isfinite(y) else -1
        if found < 0:
            ends = (-0.5, self.rows - 0.5), (-0.5, self.columns - 0.5)
            corners = self.points(*np.meshgrid(*ends)).reshape(4, 2)
            (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
            reach = f"from ({left:g}, {low:g}) to ({right:g}, {high:g}) metres"
            raise InputError(f"the point ({x:g}, {y:g}) is not on the map, which reaches {reach}")
        return found // self.columns, found % self.columns

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """Return the middle of a cell in metres, to a tenth of a millimetre."""
        x, y = self.points(row, column).tolist()
        return round(x, 4), round(y, 4)


@dataclass(frozen=True)
class OccupancyGrid:
    """A map of cells that are free, occupied or unknown; what is not free is an obstacle."""

    frame: Frame
    states: NDArray[np.int8] = field(repr=False)  # occupancy from 0 (free) to 100 (occupied), -1 where it is unknown, as ROS has it
    free_below: int = 1  # cells whose occupancy is less are free

    def __post_init__(self) -> None:
        """Refuse what would make occupied cells free."""
        if not 1 <= self.free_below <= OCCUPIED:
            raise InputError(f"free_below is {self.free_below}; a percentage from 1 to 100 is accepted")

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which cells are free."""
        return np.asarray((self.states >= FREE) & (self.states < self.free_below))

    @property
    def sha256(self) -> str:
        """Digest of frame and cells."""
        frame = self.frame
        where = f"{frame.x!r} {frame.y!r} {frame.resolution!r} {frame.rows} {frame.columns}" + (f" {frame.yaw!r}" if frame.yaw else "")
        return hashlib.sha256(where.encode() + b"\n" + self.states.tobytes()).hexdigest()


def read_grid(path: str | Path, free_below: int = 1) -> OccupancyGrid:
    """Read an occupancy map of ROS (``map.yaml``, which names a picture) or a grid map of MovingAI (``.map``).

    Cells whose occupancy is less than `free_below`, a percentage, are free; that matters in the modes scale and raw, where it is any number
    from 0 to 100. A cell of a MovingAI map is 1 m, and its y, which points down there, is the row.

    Notes
    -----
    Pictures mean what they mean to the map server of Nav2, in its single precision: occupied from occupied_thresh on, free up to
    free_thresh, unknown between (in the mode scale 0 to 100 in proportion), unknown where transparent; in the mode raw, grey values up
    to 100 are occupancies and others unknown. A turned map keeps its cells; its frame is turned.
    """
    path = Path(path)
    data = read_bytes(path)
    try:
        return _ros(path, data, free_below) if path.suffix.lower() in (".yaml", ".yml") else _moving_ai(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _ros(path: Path, data: bytes, free_below: int) -> OccupancyGrid:
    yaml = library("yaml", "navigation")
    try:
        document = yaml.safe_load(data.decode("utf-8"))
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        raise InputError(f"this is not a YAML file{f' (line {mark.line + 1})' if mark else ''}; a map file of ROS was expected") from None
    if not isinstance(document, dict):
        raise InputError("this is not a map file of ROS, which says image, resolution, origin and thresholds")
    check_keys({str(key): value for key, value in document.items()}, MAP_KEYS, "the file")
    image, origin = document.get("image"), document.get("origin")
    if not isinstance(image, str):
        raise InputError("the key image must name a picture")
    if not (isinstance(origin, list) and len(origin) in (2, 3)):
        raise InputError(f"origin is {shown(origin)}; [x, y, yaw] of the lower left corner is accepted, in metres and radians")
    x, y, yaw = ([_number(value, "origin") for value in origin] + [0.0])[:3]
    said = {key: document.get(key, usual) for key, usual in (("negate", 0), ("mode", "trinary"), ("map_type", "occupancy"))}
    said["mode"] = str(said["mode"]).lower()
    for key, accepted in (("negate", (0, 1)), ("mode", MODES), ("map_type", ("occupancy",))):
        if said[key] not in accepted:
            raise InputError(f"{key} is {shown(said[key])}; {' or '.join(map(str, accepted))} is accepted")
    occupied, free, side = (_number(document.get(key), key) for key in ("occupied_thresh", "free_thresh", "resolution"))
    if not 0 <= free <= occupied <= 1:
        raise InputError(f"free_thresh is {free:g} and occupied_thresh {occupied:g}; 0 ≤ free ≤ occupied ≤ 1 is accepted")
    grey, opaque = _picture(path.parent / image)
    rows, columns = grey.shape
    frame = Frame(x, y, side, rows, columns, yaw)
    if said["mode"] == "raw":
        return OccupancyGrid(frame, np.where(grey <= OCCUPIED, grey, UNKNOWN).astype(np.int8), free_below)
    dark = grey.astype(np.float32) / np.float32(255)
    if not said["negate"]:
        dark = 1 - dark
    low, high = np.float32(free), np.float32(occupied)
    between = np.full(grey.shape, UNKNOWN, np.float32)
    if said["mode"] == "scale":
        between = np.floor((dark - low) / (np.float32(occupied - free) or np.float32(1)) * 100 + np.float32(0.5))
    states = np.select([~opaque, dark <= low, dark >= high], [UNKNOWN, FREE, OCCUPIED], between).astype(np.int8)
    return OccupancyGrid(frame, states, free_below)


def _number(value: Any, key: str) -> float:
    if value is None:
        raise InputError(f"the key {key} is missing")
    try:
        number = float("nan" if isinstance(value, bool) else value)
    except (ValueError, OverflowError, TypeError):
        number = float("nan")
    if not isfinite(number):
        raise InputError(f"{key} has the value {shown(value)}; a finite number is accepted")
    return number


def _picture(path: Path) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Grey values of a picture, and which pixels are opaque."""
    pil = library("PIL.Image", "navigation")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # large maps are meant
            with pil.open(path) as picture:
                if picture.mode.startswith(("I", "F")):
                    raise InputError(f"{path.name} has more than 8 bits per channel; save it as an 8-bit greyscale picture")
                clear = "A" in picture.mode or "transparency" in picture.info
                opaque = np.asarray(picture.convert("RGBA"))[:, :, 3] == 255 if clear else np.ones(picture.size[::-1], np.bool_)
                return np.asarray(picture.convert("L")), opaque
    except InputError:
        raise
    except FileNotFoundError:
        beside = sorted(p.name for p in path.parent.glob("*") if p.suffix.lower() in PICTURES)
        offer = f"; write {beside[0]} into the key image, if it is meant" if len(beside) == 1 else ""
        raise InputError(f"the picture {path.name} is not there{offer}") from None
    except (OSError, ValueError, SyntaxError, MemoryError, pil.DecompressionBombError) as error:
        raise InputError(f"the picture {path.name} cannot be read: {error}") from None


def write_ros_map(grid: OccupancyGrid, path: str | Path) -> None:
    """Write a map for ROS: ``path`` (a ``.yaml`` file) and a pgm picture beside it, with the values that map_saver writes.

    `read_grid` gives it back, what is neither free nor occupied as unknown.
    """
    path = Path(path)
    picture, frame = path.with_suffix(".pgm"), grid.frame
    values = np.select([grid.free, grid.states == OCCUPIED], [254, 0], 205).astype(np.uint8)
    text = (
        f"image: {json.dumps(picture.name, ensure_ascii=False)}\nresolution: {frame.resolution!r}\n"
        f"origin: [{frame.x!r}, {frame.y!r}, {frame.yaw!r}]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    head = f"P5\n{frame.columns} {frame.rows}\n255\n"
    write_together([(picture, [head.encode(), values.tobytes()]), (path, [text.encode()])])


def _moving_ai(data: bytes) -> OccupancyGrid:
    data = data.replace(b"\r\n", b"\n")
    head = MOVING_AI.match(data)
    if head is None:
        raise InputError("this is not a grid map: it should begin with the lines type octile, height N, width N and map")
    sizes = {head[1]: int(head[2]), head[3]: int(head[4])}
    rows, columns = sizes[b"height"], sizes[b"width"]
    frame = Frame(0.0, 0.0, 1.0, rows, columns)
    body = data[head.end() :].rstrip().split(b"\n")
    if len(body) != rows:
        raise InputError(f"height says {rows} rows of cells, and the number found is {len(body)}")
    for number, line in enumerate(body, start=5):
        if len(line) != columns:
            raise InputError(f"width says {columns} cells a line, and line {number} has {len(line)}")
    cells = np.frombuffer(b"".join(body), np.uint8).reshape(rows, columns)
    known = np.isin(cells, list(PASSABLE + BLOCKED))
    if not known.all():
        row, column = np.argwhere(~known)[0]
        raise InputError(f"line {row + 5}, column {column + 1}: {shown(chr(cells[row, column]))} is no terrain; . G S @ O T W are accepted")
    return OccupancyGrid(frame, np.where(np.isin(cells, list(PASSABLE)), FREE, OCCUPIED).astype(np.int8))
