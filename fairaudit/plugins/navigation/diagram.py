"""The topological map as a picture: rooms are nodes at their middles, doors are on the edges between them, and a route is highlighted."""

from __future__ import annotations

from itertools import groupby, pairwise
from math import ceil, hypot
from typing import Any

import numpy as np

from fairaudit.errors import InputError
from fairaudit.libraries import library
from fairaudit.plugins.navigation.look import INK, PAPER, RED, colour, line_width, text_size
from fairaudit.plugins.navigation.maps import Maps
from fairaudit.plugins.navigation.prompts import FAR, LARGEST_SIDE, LAYOUT_SIDE, TARGET_SIDE, Picture, Point, Sheet, disc, finished, star
from fairaudit.plugins.navigation.rooms import Rooms
from fairaudit.plugins.navigation.routes import Route
from fairaudit.plugins.navigation.topology import NOWHERE

__all__ = ["draw_topology", "rooms_on"]

TINT, SHADE = 0.25, 0.45  # share of colour in the floor of a room, and in its furniture
PASSING = 0.4  # metres in a room that are no visit


def rooms_on(route: Route, rooms: Rooms) -> list[tuple[int, Point]]:
    """Rooms through which a route goes, and where it enters each (row, column); one that it only grazes, as in a doorway, is left out."""
    owner = rooms.owner[tuple(route.cells.T)]
    visits = [(int(room), [place for place, _ in cells]) for room, cells in groupby(enumerate(owner), key=lambda cell: cell[1])]
    ends = (0, len(owner) - 1)
    long = [
        (room, places[0])
        for room, places in visits
        if room != NOWHERE and (len(places) * rooms.frame.resolution >= PASSING or places[0] == ends[0] or places[-1] == ends[1])
    ]
    return [(room, tuple(route.cells[next(cells)[1]].tolist())) for room, cells in groupby(long, key=lambda visit: visit[0])]


def draw_topology(maps: Maps, rooms: Rooms, route: Route | None = None, *, scale: int | None = None) -> Picture:
    """Draw the topological map over the rooms, and on it in red the rooms and doors of a route, from a circle to a star.

    Parameters
    ----------
    maps : Maps
        The floor.
    rooms : Rooms
        Its rooms, from `rooms_of`.
    route : Route, optional
        The rooms through which it goes are joined by the doors nearest to it; where there is none between two, directly.
    scale : int, optional
        Pixels per cell; by default as many as make the longer side about 768 pixels.

    Returns
    -------
    Picture
        The picture, with the name of each room near its node.

    Raises
    ------
    InputError
        If a library is missing, or the picture would be larger than 16,384 pixels.
    """
    image, drawing = library("PIL.Image", "navigation"), library("PIL.ImageDraw", "navigation")
    rows, columns = rooms.owner.shape
    factor = max(1, round(TARGET_SIDE / max(rows, columns))) if scale is None else scale
    side = factor * max(rows, columns)
    if factor < 1 or side > LARGEST_SIDE:
        raise InputError(f"a picture of {side} pixels is larger than {LARGEST_SIDE}; use a smaller scale or bounds")
    size, line, step = text_size(side), line_width(side), ceil(side / LAYOUT_SIDE)
    ring = max(1, round(line / 3))

    def pixel(at: Any) -> Point | None:
        cell = int(rooms.frame.cells([at])[0]) if at is not None else -1
        return (size + (cell % columns + 0.5) * factor, size + (cell // columns + 0.5) * factor) if cell >= 0 else None

    nodes = {room: at for room, node in rooms.graph.nodes(data=True) if (at := pixel(node["at"])) is not None}
    edges = [
        (first, second, at)
        for first, second, edge in rooms.graph.edges(data=True)
        for door in edge["doors"]
        if first in nodes and second in nodes and (at := pixel(door["at"])) is not None
    ]
    visits = rooms_on(route, rooms) if route is not None else []
    passed = [(rooms.names[room], (size + (column + 0.5) * factor, size + (row + 0.5) * factor)) for room, (row, column) in visits]
    names = [name for name, _ in passed]
    chosen = []
    for (first, _), (second, (x, y)) in pairwise(visit for visit in passed if visit[0] in nodes):
        doors = [door for *pair, door in edges if {*pair} == {first, second}]
        chosen.append([nodes[first], *sorted(doors, key=lambda door: hypot(door[0] - x, door[1] - y))[:1], nodes[second]])

    picture = image.new("RGB", (columns * factor + 2 * size, rows * factor + 2 * size), PAPER)
    floor = image.fromarray(_floor(maps, rooms))
    picture.paste(floor.resize((columns * factor, rows * factor), image.Resampling.NEAREST), (size, size))
    kept = image.new("1", (ceil(picture.width / step), ceil(picture.height / step)))
    pens = ((drawing.Draw(kept), step), (drawing.Draw(picture), 1))
    for pen, by in pens:
        paper, ink, red = (1, 1, 1) if by > 1 else (PAPER, INK, RED)
        paths = [([nodes[first], door, nodes[second]], ink, line // 2 + 1) for first, second, door in edges]
        for path, fill, wide in [*paths, *((path, red, line) for path in chosen)]:
            for border, hue in ((2 * ring, paper), (0, fill)):
                pen.line([(x / by, y / by) for x, y in path], fill=hue, width=ceil((wide + border) / by), joint="curve")
        red_doors = {path[1] for path in chosen if len(path) == 3}
        for *_, (x, y) in edges:
            box = [(x - line) / by, (y - line) / by, (x + line) / by, (y + line) / by]
            pen.rectangle(box, fill=red if (x, y) in red_doors else paper, outline=ink, width=ceil(ring / by))
        for name, (x, y) in nodes.items():
            at = (x / by, y / by)
            disc(pen, at, (2 * line + ring) / by, ink)
            disc(pen, at, 2 * line / by, red if name in names[1:-1] else paper)
            if name in names[:1]:
                disc(pen, at, line / by, ink)
            if name in names[-1:]:
                star(pen, at, (3 * line + ring) / by, ink)
                star(pen, at, 2.5 * line / by, red)
    sheet = Sheet(np.array(kept), step, size)
    labels = [label for name, at in nodes.items() for label in sheet.put(name, at, RED if name in names else INK)]
    if len(sheet.taken) * step > picture.height:
        picture, drawn = image.new("RGB", (picture.width, len(sheet.taken) * step), PAPER), picture
        picture.paste(drawn, (0, 0))
    pen = drawing.Draw(picture)
    for label in labels:
        label.point(pen, ring, FAR * line)
    for label in labels:
        label.draw(pen, ring)
    return finished(picture, (size, size, factor), labels)


def _floor(maps: Maps, rooms: Rooms) -> Any:
    """Rooms in pale colours, their furniture in darker ones, other floor white, walls dark, and what was not seen light."""
    hues = np.array([colour(number % 7, 0) for number in range(len(rooms.names))] + [PAPER])
    tint = np.where(maps.ground, TINT, SHADE)[..., None]
    inside = (1 - tint) * 255 + tint * hues[rooms.owner]
    outside = np.select([maps.ground, np.isfinite(maps.height)], [255, 90], 225)[..., None]
    return np.where((rooms.owner != NOWHERE)[..., None], inside, outside).astype(np.uint8)
