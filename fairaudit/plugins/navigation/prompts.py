"""Visual prompts: maps with routes from a circle to stars, labels that cover nothing that matters, an index and a scale bar."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import ceil, cos, floor, hypot, log10, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.libraries import library
from fairaudit.plugins.navigation.look import FAINT, INK, PAPER, RED, colour, line_width, set_text, text_size
from fairaudit.plugins.navigation.maps import Maps
from fairaudit.plugins.navigation.routes import Route

__all__ = ["Label", "Picture", "draw", "view"]

TARGET_SIDE = 768
LARGEST_SIDE = 16_384
LAYOUT_SIDE = 256  # labels are placed on a grid of about so many cells
MARGIN, SLIMMEST = 1.5, 0.5  # metres around routes; the shorter side of a view, as a share of the longer one
OUTSIDE = 0.4  # how much of the box of a room's name may lie outside the room
FAR = 5  # widths of a route; a label farther away than this from what it names has a line to it

Point = tuple[float, float]
Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Label:
    """A text in a picture: the upper left corner and the size of its box, the pixel that it is about, and how it is drawn."""

    text: str
    corner: tuple[int, int]
    size: tuple[int, int]
    at: Point
    border: Colour = field(repr=False)
    letters: list[tuple[tuple[int, int], str, Any]] = field(repr=False)

    def draw(self, pen: Any, width: int) -> None:
        """Draw the box and the letters."""
        (x, y), (wide, high) = self.corner, self.size
        pen.rectangle([x, y, x + wide - 1, y + high - 1], fill=PAPER, outline=self.border, width=width)
        for (dx, dy), text, face in self.letters:
            pen.text((x + dx, y + dy), text, fill=INK, font=face, anchor="ls")

    def point(self, pen: Any, width: int, least: float) -> None:
        """Draw a line to what it is about, if that is farther away than this."""
        x, y = (min(max(v, low), low + extent) for v, low, extent in zip(self.at, self.corner, self.size, strict=True))
        if self.border != FAINT and hypot(x - self.at[0], y - self.at[1]) > least:
            for fill, wide in ((PAPER, 3 * width), (INK, width)):
                pen.line([(x, y), self.at], fill=fill, width=wide)


@dataclass(frozen=True)
class Picture:
    """A picture as a PNG file.

    Attributes
    ----------
    png : bytes
        The file; equal input gives equal bytes, with the same version of the libraries and the same fonts.
    width, height : int
        Size in pixels.
    pixels_sha256 : str
        SHA-256 of the RGB values in reading order, which no version of a compressor changes.
    left, top, scale : int
        Where the map's upper left corner is, and how many pixels a cell has.
    labels : tuple of Label
        What is written, and where.
    """

    png: bytes = field(repr=False)
    width: int
    height: int
    pixels_sha256: str
    left: int
    top: int
    scale: int
    labels: tuple[Label, ...]

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
    """Draw a map, alone or with routes.

    Parameters
    ----------
    rgb : array of uint8, shape (rows, columns, 3)
        The map.
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
        Side of a cell in metres; with it, a scale bar is drawn.
    scale : int, optional
        Pixels per cell; by default as many as make the longer side about 768 pixels.

    Returns
    -------
    Picture
        The picture; a map alone has no margin.

    Raises
    ------
    InputError
        If pillow or matplotlib is missing, the map would be larger than 16,384 pixels, or no font has a letter.
    """
    image, drawing = library("PIL.Image", "navigation"), library("PIL.ImageDraw", "navigation")
    rows, columns = rgb.shape[:2]
    factor = max(1, round(TARGET_SIDE / max(rows, columns))) if scale is None else scale
    side = factor * max(rows, columns)
    if factor < 1 or side > LARGEST_SIDE:
        raise InputError(
            f"a picture of {factor} × {max(rows, columns)} pixels is larger than {LARGEST_SIDE}; use a smaller scale or bounds"
        )
    floorplan = image.fromarray(np.ascontiguousarray(rgb)).resize((columns * factor, rows * factor), image.Resampling.NEAREST)
    if not routes:
        return finished(floorplan, (0, 0, factor), [])
    size, line = text_size(side), line_width(side)
    left, top, ring = size, 3 * size, max(1, round(line / 3))
    width, height = max(floorplan.width + 2 * left, 16 * size), floorplan.height + top + left
    paths = [[(left + (c + 0.5) * factor, top + (r + 0.5) * factor) for r, c in route.cells.tolist()] for route in routes]
    shown = range(len(routes)) if chosen is None else (chosen,)
    fills = [colour(number, 0) if chosen is None else RED for number in range(len(routes))]

    sheet = Sheet(_kept(paths, width, height, top, (line + 4 * ring, 3 * line + 2 * ring), step := ceil(side / LAYOUT_SIDE)), step, size)
    goals = [sheet.put(f"{n + 1} {name}", path[-1], fills[n]) for n, (path, name) in enumerate(zip(paths, names, strict=True))]
    labels = [*sheet.put("start", paths[0][0], INK), *(label for n in shown for label in goals[n])]
    labels += sheet.put_rooms(*rooms, (left, top, factor)) if rooms else []

    picture = image.new("RGB", (width, max(height, len(sheet.taken) * step)), PAPER)
    picture.paste(floorplan, (left, top))
    pen = drawing.Draw(picture)
    for label in labels:
        label.point(pen, ring, FAR * line)
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
    if chosen is not None:
        letters, extent = set_text(str(chosen + 1), 3 * size // 2, width)
        labels.append(Label(str(chosen + 1), (size // 2, 0), extent, (0, 0), PAPER, letters))
    if resolution is not None:
        labels.append(_bar(pen, resolution / factor, width, size, ring))
    for label in labels:
        label.draw(pen, ring)
    return finished(picture, (left, top, factor), labels)


def finished(picture: Any, place: tuple[int, int, int], labels: Sequence[Label]) -> Picture:
    buffer = io.BytesIO()
    picture.save(buffer, "PNG")
    digest = hashlib.sha256(picture.tobytes()).hexdigest()
    return Picture(buffer.getvalue(), picture.width, picture.height, digest, *place, tuple(labels))


def _kept(paths: Sequence[list[Point]], width: int, height: int, top: int, wide: tuple[int, int], step: int) -> NDArray[np.bool_]:
    """Where no label may be, in squares of so many pixels: the head of the picture, the routes, and a disc around each of their ends."""
    kept = library("PIL.Image", "navigation").new("1", (width // step, height // step))
    pen = library("PIL.ImageDraw", "navigation").Draw(kept)
    pen.rectangle([0, 0, kept.width, top / step], fill=1)
    for path in paths:
        pen.line([(x / step, y / step) for x, y in path], fill=1, width=ceil(wide[0] / step) + 1)
        for x, y in (path[0], path[-1]):
            disc(pen, (x / step, y / step), wide[1] / step + 1, 1)
    return np.array(kept)


def disc(pen: Any, at: Point, radius: float, fill: Any) -> None:
    pen.ellipse([at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius], fill=fill)


def star(pen: Any, at: Point, radius: float, fill: Any) -> None:
    reach = [radius * (1.0, 0.5)[k % 2] for k in range(10)]
    pen.polygon([(at[0] + r * sin(pi * k / 5), at[1] - r * cos(pi * k / 5)) for k, r in enumerate(reach)], fill=fill)


def _bar(pen: Any, metres: float, width: int, size: int, ring: int) -> Label:
    """Draw a scale bar into the upper right corner, of 1, 2 or 5 times a power of ten, where a pixel is so many metres."""
    power = 10.0 ** floor(log10(metres * width / 4))
    length = power * max(k for k in (1, 2, 5) if k * power <= metres * width / 4 or k == 1)
    low, first, last = 2 * size, width - size - round(length / metres), width - size
    pen.line([(first, size), (first, low), (last, low), (last, size)], fill=INK, width=ring)
    letters, (wide, high) = set_text(f"{length:g} m", size, width)
    return Label(f"{length:g} m", (first - wide, low - high + size // 2), (wide, high), (first, low), PAPER, letters)


def _stretches(paths: Sequence[list[Point]], shown: Sequence[int], steps: int) -> Iterator[tuple[int, list[Point], int]]:
    """Pieces of so many steps, each with its route; what several routes share is that of each in turn, and has a turn's number."""
    sharers: dict[tuple[int, tuple[Point, ...]], list[int]] = {}
    for number in shown:
        for first in range(0, len(paths[number]), steps):
            sharers.setdefault((first // steps, tuple(paths[number][first : first + steps + 1])), []).append(number)
    for (piece, stretch), numbers in sharers.items():
        turn, sharer = divmod(piece, len(numbers))
        yield numbers[sharer], list(stretch), turn


@dataclass
class Sheet:
    """Where a picture is taken, in squares of so many pixels, and the height of letters."""

    taken: NDArray[np.bool_]
    step: int
    size: int

    def put(self, text: str, at: Point, border: Colour, room: NDArray[np.bool_] | None = None) -> list[Label]:
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

    def put_rooms(self, names: Sequence[str], owner: NDArray[np.integer[Any]], place: tuple[int, int, int]) -> Iterator[Label]:
        """Name rooms in their middles, or as near to these as there is place."""
        left, top, factor = place
        rows, columns = (
            np.clip(((np.arange(squares) + 0.5) * self.step - edge) // factor, -1, cells).astype(int)
            for squares, edge, cells in zip(self.taken.shape, (top, left), owner.shape, strict=True)
        )
        coarse = np.pad(owner, ((0, 1), (0, 1)), constant_values=-1)[np.ix_(rows, columns)]
        for number, name in enumerate(names):
            room = coarse == number
            if room.any():
                y, x = ((where.mean() + 0.5) * self.step for where in np.nonzero(room))
                yield from self.put(name, (float(x), float(y)), FAINT, room)


def _outside(mask: NDArray[np.bool_], rows: int, columns: int) -> NDArray[np.float64]:
    """Which share of each box of so many squares, by its upper left one, a mask does not cover; it covers nothing beyond the picture."""
    from scipy.ndimage import uniform_filter

    share = uniform_filter((~mask).astype(float), (rows, columns), mode="constant", cval=1.0, origin=(-(rows // 2), -(columns // 2)))
    return np.asarray(share, np.float64)
