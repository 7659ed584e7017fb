"""Grids: their frame in metres, occupancy maps of ROS, and grid maps with scenarios of the MovingAI benchmarks."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass, field
from math import floor, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown
from fairaudit.files import write_atomically
from fairaudit.libraries import library

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "Frame", "OccupancyGrid", "Pair", "read_grid", "read_scen", "write_ros_map"]

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
MAX_CELLS = 1_000_000_000
PASSABLE, BLOCKED = b".GS", b"@OTW"
MAP_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")
ROS_FREE_THRESHOLD, ROS_OCCUPIED_THRESHOLD = 0.196, 0.65


@dataclass(frozen=True)
class Frame:
    """Where the cells of a grid lie: row 0 is the top row (greatest y), column 0 the left one (least x), as in a picture.

    Attributes
    ----------
    x, y : float
        The lower left corner of the grid, in metres.
    resolution : float
        Side of a cell, in metres.
    rows, columns : int
        Size of the grid.

    Examples
    --------
    >>> frame = Frame(0.0, 0.0, 0.5, rows=4, columns=6)
    >>> frame.cell(0.1, 0.1), frame.centre(3, 0)
    ((3, 0), (0.25, 0.25))
    """

    x: float
    y: float
    resolution: float
    rows: int
    columns: int

    def __post_init__(self) -> None:
        """Refuse what is no grid, and grids too large to be meant."""
        if not (isfinite(self.resolution) and self.resolution > 0):
            raise InputError(f"the resolution is {self.resolution}; a length in metres above 0, such as 0.05, is accepted")
        if not (isfinite(self.x) and isfinite(self.y)):
            raise InputError(f"the origin of the map is ({self.x}, {self.y}); finite coordinates are accepted")
        if self.rows < 1 or self.columns < 1:
            raise InputError(f"the map has {self.rows} rows and {self.columns} columns; at least one cell is needed")
        if self.rows * self.columns > MAX_CELLS:
            raise InputError(
                f"a map of {self.rows:,} × {self.columns:,} cells of {self.resolution:g} m would need more than {MAX_CELLS:,} cells; "
                "use a coarser resolution or bounds"
            )

    @classmethod
    def around(cls, bounds: tuple[float, float, float, float], resolution: float) -> Frame:
        """Frame of whole cells, at multiples of the resolution, that covers ``(least x, least y, greatest x, greatest y)``."""
        if not (isfinite(resolution) and resolution > 0):
            raise InputError(f"the resolution is {resolution}; a length in metres above 0, such as 0.05, is accepted")
        ends = [value / resolution for value in bounds]
        if not all(isfinite(end) and abs(end) < 2**53 for end in ends):
            raise InputError(f"the bounds {bounds} cannot be divided into cells of {resolution} m")
        left, low, right, high = (floor(end) for end in ends)
        return cls(left * resolution, low * resolution, resolution, high - low + 1, right - left + 1)

    def contains(self, x: float, y: float) -> bool:
        """Whether a point lies on the grid."""
        column, up = floor((x - self.x) / self.resolution), floor((y - self.y) / self.resolution)
        return 0 <= column < self.columns and 0 <= up < self.rows

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the cell in which a point lies.

        Raises
        ------
        InputError
            If it is not on the grid.
        """
        if not (isfinite(x) and isfinite(y)) or not self.contains(x, y):
            right, high = self.x + self.columns * self.resolution, self.y + self.rows * self.resolution
            raise InputError(
                f"the point ({x:g}, {y:g}) is not on the map, which reaches from ({self.x:g}, {self.y:g}) to ({right:g}, {high:g}) metres"
            )
        return self.rows - 1 - floor((y - self.y) / self.resolution), floor((x - self.x) / self.resolution)

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """Return the middle of a cell in metres, to a tenth of a millimetre."""
        return (
            round(self.x + (column + 0.5) * self.resolution, 4),
            round(self.y + (self.rows - row - 0.5) * self.resolution, 4),
        )


@dataclass(frozen=True)
class OccupancyGrid:
    """A map of free, occupied and unknown cells; what is unknown is an obstacle.

    Attributes
    ----------
    frame : Frame
        Where the cells lie.
    states : array of int8, shape (rows, columns)
        0 free, 100 occupied, -1 unknown, as ROS has them.
    """

    frame: Frame
    states: NDArray[np.int8] = field(repr=False)

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which cells are free."""
        return np.asarray(self.states == FREE)


def read_grid(path: str | Path) -> OccupancyGrid:
    """Read an occupancy map of ROS (``map.yaml``, which names a pgm or png) or a grid map of MovingAI (``.map``).

    Parameters
    ----------
    path : path-like
        The file; its ending tells which.

    Returns
    -------
    OccupancyGrid
        In metres; a cell of a MovingAI map is 1 m, and its y, which points down there, is the row.

    Raises
    ------
    InputError
        If it is not such a file.
    """
    path = Path(path)
    try:
        return _ros(path) if path.suffix.lower() in (".yaml", ".yml") else _moving_ai(path)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except (FileNotFoundError, IsADirectoryError):
        raise InputError("there is no such file") from None
    except OSError as error:
        raise InputError(f"the file cannot be read: {error.strerror}") from None


def _ros(path: Path) -> OccupancyGrid:
    yaml = library("yaml", "navigation")
    try:
        document = yaml.safe_load(_bytes(path).decode("utf-8"))
    except (UnicodeDecodeError, yaml.YAMLError, RecursionError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        mark = getattr(error, "problem_mark", None)
        raise InputError(f"this is not a YAML file{f' (line {mark.line + 1})' if mark else ''}; a map file of ROS was expected") from None
    if not isinstance(document, dict):
        raise InputError("this is not a map file of ROS, which says image, resolution, origin and thresholds")
    for key in document:
        if key not in MAP_KEYS:
            raise InputError(f"it has the unknown key {shown(key)}; {nearest(str(key), MAP_KEYS)}")
    image = document.get("image")
    if not isinstance(image, str):
        raise InputError("the key image must name a picture")
    resolution = _number(document, "resolution")
    origin = document.get("origin")
    if not (isinstance(origin, list) and len(origin) in (2, 3)):
        raise InputError(f"origin is {shown(origin)}; [x, y, yaw] of the lower left corner is accepted")
    x, y, yaw = ([_finite(value, "origin") for value in origin] + [0.0])[:3]
    if yaw != 0:
        raise InputError(f"origin has the yaw {yaw:g}; rotated maps are not accepted, only yaw 0")
    negate = document.get("negate", 0)
    if negate not in (0, 1):
        raise InputError(f"negate is {shown(negate)}; 0 or 1 is accepted")
    mode = document.get("mode", "trinary")
    if mode not in ("trinary", "scale"):
        raise InputError(f"mode is {shown(mode)}; trinary or scale is accepted")
    occupied, free = _number(document, "occupied_thresh"), _number(document, "free_thresh")
    if not 0 <= free <= occupied <= 1:
        raise InputError(f"free_thresh is {free:g} and occupied_thresh {occupied:g}; 0 ≤ free ≤ occupied ≤ 1 is accepted")
    darkness, opaque = _picture(path.parent / image)
    light = darkness if negate else 255.0 - darkness
    probability = light / 255.0
    rows, columns = (int(n) for n in probability.shape)
    states = np.full((rows, columns), UNKNOWN, np.int8)
    states[probability > occupied] = OCCUPIED
    states[(probability < free) & opaque] = FREE
    return OccupancyGrid(Frame(x, y, resolution, rows, columns), states)


def _number(document: dict[str, Any], key: str) -> float:
    if key not in document:
        raise InputError(f"the key {key} is missing")
    return _finite(document[key], key)


def _finite(value: object, key: str) -> float:
    try:
        number = float(value) if isinstance(value, (int, float, str)) and not isinstance(value, bool) else float("nan")
    except (ValueError, OverflowError):
        number = float("nan")
    if not isfinite(number):
        raise InputError(f"{key} has the value {shown(value)}; a finite number is accepted")
    return number


def _picture(path: Path) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Mean of the colour channels, 0 to 255, and which pixels are opaque."""
    pil = library("PIL.Image", "navigation")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # large maps are meant
            with pil.open(path) as picture:
                if picture.mode.startswith(("I", "F")):
                    raise InputError(f"{path.name} has more than 8 bits per channel; save it as an 8-bit greyscale picture")
                array = np.asarray(picture.convert("RGBA" if "A" in picture.mode or "transparency" in picture.info else "RGB"))
    except InputError:
        raise
    except FileNotFoundError:
        beside = sorted(p.name for p in path.parent.glob("*") if p.suffix.lower() in (".pgm", ".png"))
        offer = f"; write {beside[0]} into the key image, if it is meant" if len(beside) == 1 else ""
        raise InputError(f"the picture {path.name} is not there{offer}") from None
    except (OSError, ValueError, SyntaxError, MemoryError, pil.DecompressionBombError) as error:
        raise InputError(f"the picture {path.name} cannot be read: {error}") from None
    opaque = array[:, :, 3] == 255 if array.shape[2] == 4 else np.ones(array.shape[:2], np.bool_)
    return array[:, :, :3].sum(axis=2, dtype=np.int64) / 3.0, opaque


def write_ros_map(grid: OccupancyGrid, path: str | Path) -> Path:
    """Write a map for ROS: ``path`` (a ``.yaml`` file) and a pgm picture beside it, with the values that map_saver writes.

    Parameters
    ----------
    grid : OccupancyGrid
        The map; `read_grid` gives it back unchanged.
    path : path-like
        The ``.yaml`` file.

    Returns
    -------
    Path
        The picture.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml"):
        raise InputError(f"{path}: a map file of ROS ends in .yaml")
    picture = path.with_suffix(".pgm")
    frame = grid.frame
    values = np.full(grid.states.shape, 205, np.uint8)
    values[grid.states == FREE] = 254
    values[grid.states == OCCUPIED] = 0
    write_atomically(picture, [f"P5\n{frame.columns} {frame.rows}\n255\n".encode(), values.tobytes()])
    lines = (
        f"image: {json.dumps(picture.name, ensure_ascii=False)}",
        f"resolution: {frame.resolution!r}",
        f"origin: [{frame.x!r}, {frame.y!r}, 0.0]",
        "negate: 0",
        f"occupied_thresh: {ROS_OCCUPIED_THRESHOLD}",
        f"free_thresh: {ROS_FREE_THRESHOLD}",
    )
    write_atomically(path, ["\n".join([*lines, ""]).encode()])
    return picture


def _moving_ai(path: Path) -> OccupancyGrid:
    data = _bytes(path)
    lines = data.replace(b"\r\n", b"\n").split(b"\n")
    header = [line.split() for line in lines[:4]]
    if len(header) < 4 or header[0][:1] != [b"type"] or header[3] != [b"map"]:
        raise InputError("this is not a grid map: it should begin with the lines type octile, height, width and map")
    sizes: dict[bytes, int] = {}
    for number in (1, 2):
        words = header[number]
        if len(words) != 2 or words[0] not in (b"height", b"width") or not words[1].isdigit() or len(words[1]) > 9:
            said = shown(lines[number].decode("ascii", "backslashreplace"))
            raise InputError(f"line {number + 1} is {said}; height N or width N was expected")
        sizes[words[0]] = int(words[1])
    if len(sizes) != 2:
        raise InputError("lines 2 and 3 must give the height and the width")
    rows, columns = sizes[b"height"], sizes[b"width"]
    frame = Frame(0.0, 0.0, 1.0, rows, columns)
    body = lines[4:]
    while body and not body[-1].strip():
        body.pop()
    if len(body) != rows:
        raise InputError(f"there are {len(body)} rows of cells where height says {rows}")
    for number, line in enumerate(body, start=5):
        if len(line) != columns:
            raise InputError(f"line {number} has {len(line)} cells where width says {columns}")
    cells = np.frombuffer(b"".join(body), np.uint8).reshape(rows, columns)
    known = np.isin(cells, list(PASSABLE + BLOCKED))
    if not known.all():
        row, column = np.argwhere(~known)[0]
        raise InputError(f"line {row + 5}, column {column + 1}: {shown(chr(cells[row, column]))} is no terrain; . G S @ O T W are accepted")
    return OccupancyGrid(frame, np.where(np.isin(cells, list(PASSABLE)), FREE, OCCUPIED).astype(np.int8))


@dataclass(frozen=True)
class Pair:
    """A start, a goal (row, column) and the optimal length between them, in cells, from a MovingAI scenario file."""

    start: tuple[int, int]
    goal: tuple[int, int]
    length: float


def read_scen(path: str | Path) -> list[Pair]:
    """Read a MovingAI scenario file.

    Raises
    ------
    InputError
        If it is not such a file; the message names the line.
    """
    try:
        lines = _bytes(Path(path)).decode("utf-8", "replace").splitlines()
        if not lines or lines[0].split()[:1] != ["version"]:
            raise InputError("line 1 should be version 1")
        found = []
        for number, line in enumerate(lines[1:], start=2):
            words = line.split()
            if not words:
                continue
            try:
                _, _, _, _, x, y, goal_x, goal_y, length = words
                found.append(Pair((int(y), int(x)), (int(goal_y), int(goal_x)), _finite(length, "length")))
            except ValueError:
                raise InputError(f"line {number} is not bucket, map, width, height, start x, y, goal x, y, length") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return found
