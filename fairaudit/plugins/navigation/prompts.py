"""Visual prompts: maps with routes from a circle to stars, labels that cover nothing that matters, a scale bar; the topological map."""

from __future__ import annotations

import hashlib
import io
import textwrap
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import groupby, pairwise
from math import ceil, cos, floor, hypot, log10, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.libraries import library
from fairaudit.plugins.navigation.maps import Maps
from fairaudit.plugins.navigation.rooms import NOWHERE, Rooms
from fairaudit.plugins.navigation.routes import Route

RED, INK, PAPER, FAINT = (255, 0, 0), (20, 20, 20), (255, 255, 255), (170, 170, 170)
COLOURS = (  # after Okabe and Ito, for readers who see fewer colours
    (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0), (86, 180, 233), (240, 228, 66),
)  # fmt: skip
TEXT, LINE = 1 / 42, 1 / 120  # height of letters and width of a route, as shares of the map's longer side
LEAST_TEXT, LEAST_LINE = 14, 3
MOST_LINES, LEADING = 3, 1.3
SHAPED = {"R", "AL", "NSM"}  # bidirectional classes of letters that are joined, reordered or stacked
TARGET_SIDE, LARGEST_SIDE = 768, 16_384
LAYOUT_SIDE = 256  # labels are placed on a grid of about so many cells
MARGIN, SLIMMEST = 1.5, 0.5  # metres around routes; the shorter side of a view, as a share of the longer one
OUTSIDE = 0.4  # how much of the box of a room's name may lie outside the room
TINT, SHADE = 0.25, 0.45  # share of colour in the floor of a room, and in its furniture
PASSING = 0.4  # metres in a room that are no visit
FAR = 5  # widths of a route; a label farther away than this from what it names has a line to it

Point = tuple[float, float]
Colour = tuple[int, int, int]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Label:
    """A text in a picture: the upper left corner and the size of its box, the pixel that it is about, and how it is drawn."""

    text: str
    corner: tuple[int, int]
    size: tuple[int, int]
    at: Point
    border: Colour = field(repr=False)
    letters: list[tuple[tuple[int, int], str, Any]] = field(repr=False)


@dataclass(frozen=True)
class Picture:
    """A picture as a PNG file; equal input gives equal bytes, with the same version of the libraries and the same fonts."""

    png: bytes = field(repr=False)
    width: int  # in pixels
    height: int
    pixels_sha256: str  # of the RGB values in reading order, which no version of a compressor changes
    left: int  # where the map's upper left corner is
    top: int
    scale: int  # pixels per cell
    labels: tuple[Label, ...]  # what is written, and where

    @property
    def sha256(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.png).hexdigest()


def view(maps: Maps, routes: Sequence[Route]) -> tuple[slice, slice]:
    """Rows and columns that matter to routes: theirs, with a margin of 1.5 m or more, as far as anything was scanned there."""
    seen = np.argwhere(np.isfinite(maps.height))
    cells = np.concatenate([route.cells for route in routes])
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    longest = int((high - low).max())
    margin = max(ceil(MARGIN / maps.frame.resolution), longest // 4)
    room = np.maximum(margin, ceil((longest + 2 * margin) * SLIMMEST / 2) - (high - low) // 2)
    known = np.concatenate([seen, cells])
    low, high = np.maximum(low - room, known.min(axis=0)), np.minimum(high + room, known.max(axis=0) + 1)
    return slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))


def draw(
    rgb: NDArray[np.uint8],
    routes: Sequence[Route] = (),
    names: Sequence[str] = (),
    *,
    chosen: int | None = None,
    rooms: tuple[Sequence[str], NDArray[np.integer[Any]]] | None = None,
    resolution: float | None = None,
    scale: int | None = None,
) -> Picture:
    """Draw a map, alone or with routes; without these and scale bar it has no margin. More than 16,384 pixels are refused.

    Parameters
    ----------
    routes : sequence of Route
        From one start, each drawn along the centres of its cells; the start is a circle, and each goal a star.
    names : sequence of str
        What the goals are called; each is written beside its star, after its number.
    chosen : int, optional
        Draw the route at this position alone, in red, with its number (from 1) in the upper left corner. All that is common to such
        pictures has the same place in all of them. By default all are drawn, each with a colour and line style of its own.
    rooms : tuple, optional
        Names of rooms, and the position of each cell's room among them or -1. A name that finds no free place in its room is left out.
    resolution : float, optional
        Side of a cell in metres; with it, a scale bar is drawn above the map.
    scale : int, optional
        Pixels per cell; by default as many as make the longer side about 768 pixels.

    """
    canvas = Canvas(rgb, scale, (1, 3) if routes or resolution is not None else (0, 0))
    line, ring, factor = canvas.line, canvas.ring, canvas.factor
    paths = [[canvas.pixel(row, column) for row, column in route.cells.tolist()] for route in routes]
    fills = [colour(number, 0) if chosen is None else RED for number in range(len(routes))]

    def paint(pen: Any, shown: Sequence[int]) -> None:
        for fill, wide in ((PAPER, line + 4 * ring), (INK, line + 2 * ring)):
            for number in shown:
                pen.line(paths[number], fill=fill, width=wide, joint="curve")
        for number, stretch, turn in _stretches(paths, shown, max(1, round(4 * line / factor))):
            pen.line(stretch, fill=colour(number, turn) if chosen is None else RED, width=line, joint="curve")
        for radius, fill in ((2 * line + 2 * ring, PAPER), (2 * line + ring, INK), (2 * line, PAPER), (line, INK)):
            disc(pen, paths[0][0], radius, fill)
        for number in shown:
            for radius, fill in ((3 * line + 2 * ring, PAPER), (3 * line, INK), (3 * line - 2 * ring, fills[number])):
                star(pen, paths[number][-1], radius, fill)

    if routes:
        everything = range(len(routes))
        shown = everything if chosen is None else (chosen,)
        canvas.keep(lambda pen: paint(pen, everything), [(path[-1], 3 * line + 2 * ring) for path in paths])
        goals = [canvas.put(f"{n + 1} {name}", path[-1], fills[n]) for n, (path, name) in enumerate(zip(paths, names, strict=True))]
        canvas.labels += [*canvas.put("start", paths[0][0], INK), *(label for n in shown for label in goals[n])]
        if rooms:
            canvas.put_rooms(*rooms)
        canvas.point()
        paint(canvas.pen, shown)
    if chosen is not None:
        letters, extent = set_text(str(chosen + 1), 3 * canvas.size // 2, canvas.picture.width)
        canvas.labels.append(Label(str(chosen + 1), (canvas.size // 2, 0), extent, (0, 0), PAPER, letters))
    if resolution is not None:
        canvas.bar(resolution / factor)
    return canvas.finished()


def colour(number: int, piece: int) -> Colour:
    """Colour of a piece of the route of a candidate (from 0): the eighth to fourteenth are dashed, every second piece of them being light.

    Of the next seven every third piece is light, and so on.
    """
    style = number // len(COLOURS)
    return PAPER if style and piece % (style + 1) == style else COLOURS[number % len(COLOURS)]


def disc(pen: Any, at: Point, radius: float, fill: Any) -> None:
    """Draw a disc."""
    pen.ellipse([at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius], fill=fill)


def star(pen: Any, at: Point, radius: float, fill: Any) -> None:
    """Draw a star with five points."""
    reach = [radius * (1.0, 0.5)[k % 2] for k in range(10)]
    pen.polygon([(at[0] + r * sin(pi * k / 5), at[1] - r * cos(pi * k / 5)) for k, r in enumerate(reach)], fill=fill)


def _stretches(paths: Sequence[list[Point]], shown: Sequence[int], steps: int) -> Iterator[tuple[int, list[Point], int]]:
    """Pieces of so many steps, each with its route; what several routes share is that of each in turn, and has a turn's number."""
    sharers: dict[tuple[int, tuple[Point, ...]], list[int]] = {}
    for number in shown:
        for first in range(0, len(paths[number]), steps):
            sharers.setdefault((first // steps, tuple(paths[number][first : first + steps + 1])), []).append(number)
    for (piece, stretch), numbers in sharers.items():
        turn, sharer = divmod(piece, len(numbers))
        yield numbers[sharer], list(stretch), turn


class Canvas:
    """A map that is drawn on: its cells enlarged, a margin of so many heights of letters, and where labels may be put."""

    def __init__(self, rgb: NDArray[np.uint8], scale: int | None, margin: tuple[int, int]) -> None:
        """Take the map, pixels per cell, and the margin at the sides and above, in heights of letters."""
        self.image, self.drawing = library("PIL.Image", "navigation"), library("PIL.ImageDraw", "navigation")
        rows, columns = rgb.shape[:2]
        self.factor = max(1, round(TARGET_SIDE / max(rows, columns))) if scale is None else scale
        side = self.factor * max(rows, columns)
        if self.factor < 1 or side > LARGEST_SIDE:
            raise InputError(f"a picture of {side} pixels is larger than {LARGEST_SIDE}; use a smaller scale or bounds")
        self.size, self.line, self.step = max(LEAST_TEXT, round(side * TEXT)), max(LEAST_LINE, round(side * LINE)), ceil(side / LAYOUT_SIDE)
        self.ring, self.labels = max(1, round(self.line / 3)), list[Label]()
        self.left, self.top = (heights * self.size for heights in margin)
        wide, high = columns * self.factor, rows * self.factor
        self.head = self.top if self.top > self.left else 0  # for the number and the scale bar
        self.picture = self.image.new("RGB", (max(wide + 2 * self.left, 5 * self.head + self.left), high + self.top + self.left), PAPER)
        cells = self.image.fromarray(np.ascontiguousarray(rgb)).resize((wide, high), self.image.Resampling.NEAREST)
        self.picture.paste(cells, (self.left, self.top))
        self.pen = self.drawing.Draw(self.picture)
        self.taken: Mask = np.zeros((0, 0), np.bool_)

    def pixel(self, row: float, column: float) -> Point:
        """Middle of a cell."""
        return self.left + (column + 0.5) * self.factor, self.top + (row + 0.5) * self.factor

    def keep(self, paint: Callable[[Any], None], discs: Sequence[tuple[Point, float]] = ()) -> None:
        """Keep labels off what a function draws with a pen, discs, and the head of the picture."""
        reduce = library("skimage.measure", "navigation").block_reduce
        drawn = self.image.new("RGB", self.picture.size, (1, 2, 3))
        paint(pen := self.drawing.Draw(drawn))
        for at, radius in discs:
            disc(pen, at, radius, INK)
        self.taken = reduce((np.asarray(drawn) != (1, 2, 3)).any(axis=2), self.step, np.max)
        self.taken[: ceil(self.head / self.step)] = True

    def put(self, text: str, at: Point, border: Colour, room: Mask | None = None) -> list[Label]:
        """Put a label into the free place nearest to a point: in a room, or not at all; else anywhere, if need be below the map."""
        letters, (width, height) = set_text(text, self.size, 14 * self.size)
        rows, columns, y, x = ceil(height / self.step) + 1, ceil(width / self.step) + 1, at[1] / self.step, at[0] / self.step
        free = _outside(~self.taken, rows, columns) < 0.5 / (rows * columns)
        if room is not None:
            free &= _outside(room, rows, columns) <= OUTSIDE
        elif not free.any():
            self.taken = np.pad(self.taken, ((0, rows), (0, 0)))
            free = _outside(~self.taken, rows, columns) < 0.5 / (rows * columns)
        i, j = np.nonzero(free)
        if not len(i):
            return []
        gap = np.hypot(np.maximum(0, np.maximum(i - y, y - i - rows)), np.maximum(0, np.maximum(j - x, x - j - columns)))
        best = int((gap + np.hypot(i + rows / 2 - y, j + columns / 2 - x) / 100).argmin())
        row, column = int(i[best]), int(j[best])
        self.taken[row : row + rows, column : column + columns] = True
        return [Label(text, (column * self.step, row * self.step), (width, height), at, border, letters)]

    def put_rooms(self, names: Sequence[str], owner: NDArray[np.integer[Any]]) -> None:
        """Name rooms in their middles, or as near to these as there is place."""
        rows, columns = (
            np.clip(((np.arange(squares) + 0.5) * self.step - edge) // self.factor, -1, cells).astype(int)
            for squares, edge, cells in zip(self.taken.shape, (self.top, self.left), owner.shape, strict=True)
        )
        coarse = np.pad(owner, ((0, 1), (0, 1)), constant_values=-1)[np.ix_(rows, columns)]
        for number, name in enumerate(names):
            room = coarse == number
            if room.any():
                y, x = ((where.mean() + 0.5) * self.step for where in np.nonzero(room))
                self.labels += self.put(name, (float(x), float(y)), FAINT, room)

    def point(self) -> None:
        """Make room for labels below the map, and draw lines from those that are far from what they are about."""
        if len(self.taken) * self.step > self.picture.height:
            drawn, size = self.picture, (self.picture.width, len(self.taken) * self.step)
            self.picture = self.image.new("RGB", size, PAPER)
            self.picture.paste(drawn, (0, 0))
            self.pen = self.drawing.Draw(self.picture)
        for label in self.labels:
            x, y = (min(max(v, low), low + extent) for v, low, extent in zip(label.at, label.corner, label.size, strict=True))
            if label.border != FAINT and hypot(x - label.at[0], y - label.at[1]) > FAR * self.line:
                for fill, wide in ((PAPER, 3 * self.ring), (INK, self.ring)):
                    self.pen.line([(x, y), label.at], fill=fill, width=wide)

    def bar(self, metres: float) -> None:
        """Draw a scale bar into the upper right corner, of 1, 2 or 5 times a power of ten, where a pixel is so many metres."""
        size, width = self.size, self.picture.width
        power = 10.0 ** floor(log10(metres * width / 4))
        length = power * max(k for k in (1, 2, 5) if k * power <= metres * width / 4 or k == 1)
        low, first, last = 2 * size, width - size - round(length / metres), width - size
        self.pen.line([(first, size), (first, low), (last, low), (last, size)], fill=INK, width=self.ring)
        letters, (wide, high) = set_text(f"{length:g} m", size, width)
        self.labels.append(Label(f"{length:g} m", (first - wide, low - high + size // 2), (wide, high), (first, low), PAPER, letters))

    def finished(self) -> Picture:
        """Draw the labels, and save the picture."""
        for label in self.labels:
            (x, y), (wide, high) = label.corner, label.size
            self.pen.rectangle([x, y, x + wide - 1, y + high - 1], fill=PAPER, outline=label.border, width=self.ring)
            for (dx, dy), text, face in label.letters:
                self.pen.text((x + dx, y + dy), text, fill=INK, font=face, anchor="ls")
        buffer = io.BytesIO()
        self.picture.save(buffer, "PNG")
        digest = hashlib.sha256(self.picture.tobytes()).hexdigest()
        width, height = self.picture.size
        return Picture(buffer.getvalue(), width, height, digest, self.left, self.top, self.factor, tuple(self.labels))


def _outside(mask: Mask, rows: int, columns: int) -> NDArray[np.float64]:
    """Which share of each box of so many squares, by its upper left one, a mask does not cover; it covers nothing beyond the picture."""
    from scipy.ndimage import uniform_filter

    share = uniform_filter((~mask).astype(float), (rows, columns), mode="constant", cval=1.0, origin=(-(rows // 2), -(columns // 2)))
    return np.asarray(share, np.float64)


def rooms_on(route: Route, rooms: Rooms) -> list[tuple[int, Point]]:
    """Rooms through which a route goes, and where it enters each (row, column); one that it only grazes, as in a doorway, is left out."""
    owner = rooms.owner[tuple(route.cells.T)]
    ends = [0, *(np.flatnonzero(np.diff(owner)) + 1).tolist(), len(owner)]
    least = PASSING / rooms.frame.resolution
    long = [a for a, b in pairwise(ends) if owner[a] != NOWHERE and (b - a >= least or a == 0 or b == len(owner))]
    visits = [at for before, at in pairwise([None, *long]) if before is None or owner[at] != owner[before]]
    return [(int(owner[at]), tuple(route.cells[at].tolist())) for at in visits]


def draw_topology(maps: Maps, rooms: Rooms, route: Route | None = None, *, scale: int | None = None) -> Picture:
    """Draw the topological map over the rooms, and on it in red the rooms and doors of a route, from a circle to a star.

    The rooms through which a route goes are joined by the doors nearest to it; where there is none between two, directly. `scale` is pixels
    per cell, by default as many as make the longer side about 768 pixels.
    """
    canvas = Canvas(_floor(maps, rooms), scale, (1, 1))
    line, ring = canvas.line, canvas.ring

    def pixel(at: Any) -> Point | None:
        cell = int(rooms.frame.cells([at])[0]) if at is not None else -1
        return canvas.pixel(*divmod(cell, rooms.frame.columns)) if cell >= 0 else None

    nodes = {room: at for room, node in rooms.graph.nodes(data=True) if (at := pixel(node["at"])) is not None}
    edges = [
        (first, second, at)
        for first, second, edge in rooms.graph.edges(data=True)
        for door in edge["doors"]
        if first in nodes and second in nodes and (at := pixel(door["at"])) is not None
    ]
    visits = rooms_on(route, rooms) if route is not None else []
    passed = [(rooms.names[room], canvas.pixel(*cell)) for room, cell in visits]
    names = [name for name, _ in passed]
    chosen = []
    for (first, _), (second, (x, y)) in pairwise(visit for visit in passed if visit[0] in nodes):
        doors = [door for *pair, door in edges if {*pair} == {first, second}]
        chosen.append([nodes[first], *sorted(doors, key=lambda door: hypot(door[0] - x, door[1] - y))[:1], nodes[second]])
    red_doors = {path[1] for path in chosen if len(path) == 3}

    def paint(pen: Any) -> None:
        paths = [([nodes[first], door, nodes[second]], INK, line // 2 + 1) for first, second, door in edges]
        for path, fill, wide in [*paths, *((path, RED, line) for path in chosen)]:
            pen.line(path, fill=PAPER, width=wide + 2 * ring, joint="curve")
            pen.line(path, fill=fill, width=wide, joint="curve")
        for *_, (x, y) in edges:
            box = [x - line, y - line, x + line, y + line]
            pen.rectangle(box, fill=RED if (x, y) in red_doors else PAPER, outline=INK, width=ring)
        for name, at in nodes.items():
            disc(pen, at, 2 * line + ring, INK)
            disc(pen, at, 2 * line, RED if name in names[1:-1] else PAPER)
            if name in names[:1]:
                disc(pen, at, line, INK)
            if name in names[-1:]:
                star(pen, at, 3 * line + ring, INK)
                star(pen, at, 2.5 * line, RED)

    canvas.keep(paint)
    canvas.labels = [label for name, at in nodes.items() for label in canvas.put(name, at, RED if name in names else INK)]
    canvas.point()
    paint(canvas.pen)
    return canvas.finished()


def _floor(maps: Maps, rooms: Rooms) -> Any:
    """Rooms in pale colours, their furniture in darker ones, other floor white, walls dark, and what was not seen light."""
    hues = np.array([colour(number % 7, 0) for number in range(len(rooms.names))] + [PAPER])
    tint = np.where(maps.ground, TINT, SHADE)[..., None]
    inside = (1 - tint) * 255 + tint * hues[rooms.owner]
    outside = np.select([maps.ground, np.isfinite(maps.height)], [255, 90], 225)[..., None]
    return np.where((rooms.owner != NOWHERE)[..., None], inside, outside).astype(np.uint8)


def set_text(text: str, size: int, limit: int) -> tuple[list[tuple[tuple[int, int], str, Any]], tuple[int, int]]:
    """Break a text into at most three lines of so many pixels, and choose letters: DejaVu Sans, or fonts of the system for what it lacks.

    Returned are pieces, each with where its baseline starts, its letters and their font; and the width and height of a box around them.
    What does not fit is "…". A letter that no font has is refused.
    """
    text = unicodedata.normalize("NFC", text)
    for columns in range(min(len(text), max(1, 2 * limit // size)), 0, -1):
        pieces, boxes = [], []
        for number, line in enumerate(textwrap.wrap(text, columns, max_lines=MOST_LINES, placeholder="…")):
            x, y = 0, round(number * LEADING * size)
            for letters, face in _runs(line, size):
                pieces.append(((x, y), letters, face))
                boxes.append(np.add(face.getbbox(letters, anchor="ls"), (x, y, x, y)))
                x += round(face.getlength(letters))
        left, top = (int(v) for v in np.min(boxes, axis=0)[:2])
        right, bottom = (int(v) for v in np.max(boxes, axis=0)[2:])
        if right - left <= limit:
            break
    pad = size // 2
    placed = [((x - left + pad, y - top + pad), letters, face) for (x, y), letters, face in pieces]
    return placed, (right - left + 2 * pad, bottom - top + 2 * pad)


def _runs(line: str, size: int) -> list[tuple[str, Any]]:
    """Letters that go together, each with its font; where letters are shaped, one font has all of them."""
    fonts = library("PIL.ImageFont", "navigation")
    shaped = not SHAPED.isdisjoint(map(unicodedata.bidirectional, line))
    if shaped and not library("PIL.features", "navigation").check("raqm"):
        raise InputError(f"the letters of {shown(line)} are joined or stacked, which needs pillow with libraqm; others are accepted")
    engine = fonts.Layout.RAQM if shaped else fonts.Layout.BASIC
    found = [("".join(run), path) for path, run in groupby(line, _face)] if not shaped else [(line, _face(line))]
    return [(letters, fonts.truetype(path, size, layout_engine=engine)) for letters, path in found]


@lru_cache(maxsize=4096)
def _face(letters: str) -> str:
    """File of the first font that has all letters."""
    needed = {ord(letter) for letter in letters if not letter.isspace()}
    path = next((path for path in _fonts() if needed <= _codes(path)), None)
    if path is None:
        raise InputError(f"no font on this machine has the letters {shown(letters)}; install one, such as Noto Sans, or write others")
    return path


@lru_cache(maxsize=1)
def _fonts() -> list[str]:
    """Files of fonts: DejaVu Sans as matplotlib brings it, then those of the system by name."""
    first = str(Path(library("matplotlib", "navigation").get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"))
    paths = map(Path, library("matplotlib.font_manager", "navigation").findSystemFonts())
    return [first, *(str(path) for path in sorted(paths, key=lambda path: (path.name, path)))]


@lru_cache(maxsize=1024)
def _codes(path: str) -> frozenset[int]:
    """Letters that a font has; none if the file cannot be read."""
    try:
        return frozenset(library("matplotlib.ft2font", "navigation").FT2Font(path).get_charmap())
    except (OSError, RuntimeError):
        return frozenset()
