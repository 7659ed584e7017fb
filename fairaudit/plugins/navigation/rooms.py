"""Rooms and doors: of scans whose points are labelled, by these; else where free space is wide, and where it narrows to a door."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import ceil, isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.files import read_bytes
from fairaudit.libraries import library
from fairaudit.plugins.navigation.grids import Frame
from fairaudit.plugins.navigation.maps import Maps
from fairaudit.plugins.navigation.readers import Points

NOWHERE = -1
SAME_DOOR = 0.6
NARROWEST, WIDEST = 0.6, 1.4  # doors
WIDER = 0.12  # by how much half the width of a room is more than that of its doors
LEAST_ROOM = 1.5  # m²
COARSEST = 0.2
SPECK = 0.02  # m²
FURNITURE = 2.6  # what stands alone and is no longer is furniture …
WALL, STUB = 0.4, 0.5  # … unless it is as thin as a wall, and longer than this and than three times its thickness
JAMB, INTO, ACROSS = 0.5, 0.075, 1.5  # a wall beside a door is thinner; how far inside that is looked at, and how far across

Mask = NDArray[np.bool_]
Cells = NDArray[np.int64]
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Rooms:
    """The rooms of a floor, labelled or found."""

    frame: Frame
    names: tuple[str, ...]
    owner: NDArray[np.integer[Any]] = field(repr=False)  # of each cell of the frame, the position in names of its room, or -1
    graph: Any = field(repr=False)  # the topological map, as `topology` makes it


def rooms_of(maps: Maps, points: Points | None, names: str | Path | None = None) -> tuple[Rooms | None, tuple[str, ...]]:
    """Rooms of a scan or map as they are labelled, else as they are found; and a note of what was found, or why nothing was."""
    if points is not None and points.rooms:
        if names is not None:
            raise InputError("the scan has rooms with names of their own; room_names goes with scans and maps without")
        return Rooms(maps.frame, points.rooms, footprints(points, maps.frame), topology(points)), ()
    try:
        rooms = find_rooms(maps.ground, maps.frame, read_names(Path(names)) if names is not None else ())
    except InputError as error:
        if names is not None:
            raise
        return None, (f"no rooms: {error}",)
    doors = sum(len(edge["doors"]) for *_, edge in rooms.graph.edges(data=True))
    return rooms, (f"rooms are not labelled; found: {len(rooms.names)}, and doors between them: {doors}",)


def topology_json(graph: Any) -> dict[str, Any]:
    """Nodes (each with ``id``) and edges (each with ``source`` and ``target``) as plain lists, with the attributes of `topology`."""
    return {
        "nodes": [{"id": room, **graph.nodes[room]} for room in graph.nodes],
        "edges": [{"source": first, "target": second, **graph.edges[first, second]} for first, second in graph.edges],
    }


def _graph(names: Sequence[str], kinds: Sequence[str], owner: NDArray[np.integer[Any]], frame: Frame) -> Any:
    """Rooms without doors; each is at the centre of its cell that is nearest to the mean of them."""
    from scipy.ndimage import find_objects

    graph = library("networkx", "navigation").Graph()
    boxes = find_objects(owner + 1, len(names))
    for room, (name, kind, box) in enumerate(zip(names, kinds, boxes, strict=True)):
        cells = np.argwhere(owner[box] == room) + [side.start for side in box] if box else np.empty((0, 2), int)
        at = list(frame.centre(*cells[((cells - cells.mean(axis=0)) ** 2).sum(axis=1).argmin()].tolist())) if len(cells) else None
        graph.add_node(name, kind=kind, at=at, area=round(len(cells) * frame.resolution**2, 2), exits=[])
    return graph


def _add_door(graph: Any, pair: tuple[str, str], door: dict[str, Any], apart: float = 0.0) -> None:
    """Add a door between two rooms, or an exit of one if both are the same, unless there is one nearer than that."""
    if pair[0] != pair[1] and not graph.has_edge(*pair):
        graph.add_edge(*pair, doors=[])
    doors = graph.nodes[pair[0]]["exits"] if pair[0] == pair[1] else graph.edges[pair]["doors"]
    if not any(np.hypot(door["at"][0] - other["at"][0], door["at"][1] - other["at"][1]) < apart for other in doors):
        doors.append({"name": f"door {len(doors) + 1}"} | door)


def footprints(points: Points, frame: Frame) -> NDArray[np.int16]:
    """Find which room of an annotated scan each cell of a frame belongs to: its position in ``points.rooms``, or -1.

    A room is where its floor is; one without a floor is where its other points are, its ceiling and doors apart. A cell that two rooms
    claim belongs to the one that has more points in it, the first among equals.
    """
    if not points.rooms:
        raise InputError("this scan has no rooms; a topological map needs an S3DIS area with its room folders")
    size = frame.rows * frame.columns
    owner, most = np.full(size, NOWHERE, np.int16), np.zeros(size, np.int64)
    for number, room in enumerate(points.rooms):
        parts = [part for part in points.parts if part.room == room]
        used = [part for part in parts if part.kind == "floor"] or [part for part in parts if part.kind not in ("ceiling", "door")]
        counts = np.zeros(size, np.int64)
        for part in used:
            cells = frame.cells(points.xyz[part.start : part.stop, :2])
            counts += np.bincount(cells[cells >= 0], minlength=size)
        more = counts > most
        owner[more], most[more] = number, counts[more]
    return owner.reshape(frame.rows, frame.columns)


def topology(points: Points, *, resolution: float = 0.1, reach: float = 0.6) -> Any:
    """Find the rooms of an annotated scan and which of them a door joins.

    Rooms are laid out on cells of `resolution` metres, and those on the two sides of a door are looked for up to `reach` metres from it.

    Returns
    -------
    networkx.Graph
        Nodes: rooms, with ``kind``, ``at`` (the middle of the floor, metres), ``area`` (m²) and ``exits`` (doors that lead to no scanned
        room). Edges: pairs of rooms, with ``doors``, each a ``name``, ``at`` and ``width``. Openings without a door are no edges.

    Notes
    -----
    A shut door lies in a wall: one room is before and one behind it. If both sides are in one room, the door stands open, and the rooms are
    those at its two ends. Doors of one pair of rooms nearer than 0.6 m to each other are one door that both rooms list.
    """
    xy = points.xyz[:, :2]
    frame = Frame.around((*xy.min(axis=0).tolist(), *xy.max(axis=0).tolist()), resolution)
    owner = footprints(points, frame)
    graph = _graph(points.rooms, [room.rsplit("_", 1)[0] for room in points.rooms], owner, frame)
    for part in points.parts:
        if part.kind == "door" and part.room is not None:
            at, axes, extents = _box(xy[part.start : part.stop])
            found = _sides(owner, frame, at, axes, extents, reach)
            pair = _different(*found)
            if pair is None and min(side.max() for side in found) > 0.5:
                pair = _different(*_sides(owner, frame, at, axes[::-1], (extents[1], extents[0] + resolution), reach))
            door = {"name": f"{part.room}/{part.name}", "at": at.round(3).tolist(), "width": round(2 * extents[1], 3)}
            _add_door(graph, (points.rooms[pair[0]], points.rooms[pair[1]]) if pair else (part.room, part.room), door, SAME_DOOR)
    return graph


def _box(xy: Numbers) -> tuple[Numbers, Numbers, tuple[float, float]]:
    """Middle of a door's footprint, its short and its long axis, and half its extents along them."""
    mean = xy.mean(axis=0)
    axes = np.linalg.eigh((xy - mean).T @ (xy - mean))[1].T
    ends = np.quantile((xy - mean) @ axes.T, (0.01, 0.99), axis=0)
    depth, length = np.ptp(ends, axis=0) / 2
    return mean + ends.mean(axis=0) @ axes, axes, (float(depth), float(length))


def _sides(owner: NDArray[np.int16], frame: Frame, at: Numbers, axes: Numbers, extents: tuple[float, float], reach: float) -> list[Numbers]:
    """For both sides of a box along its first axis, the share of the probes that met each room."""
    step = frame.resolution / 2
    away = extents[0] + step * np.arange(1, ceil(reach / step) + 1)
    lateral = np.linspace(-extents[1], extents[1], max(3, ceil(2 * extents[1] / step)))
    sides = []
    for outward in (away, -away):
        cells = frame.cells((at + outward[:, None, None] * axes[0] + lateral[None, :, None] * axes[1]).reshape(-1, 2))
        met = owner.ravel()[cells[cells >= 0]]
        sides.append(np.bincount(met[met != NOWHERE], minlength=int(owner.max()) + 1) / len(cells))
    return sides


def _different(before: Numbers, behind: Numbers) -> tuple[int, int] | None:
    """Two different rooms, one of each side, that most probes met, or None."""
    pairs = np.where(np.outer(before, behind) > 0, before[:, None] + behind, 0.0)
    np.fill_diagonal(pairs, 0.0)
    first, second = divmod(int(pairs.argmax()), len(behind))
    return (first, second) if pairs[first, second] else None


def find_rooms(free: Mask, frame: Frame, names: Sequence[tuple[float, float, str]] = ()) -> Rooms:
    """Find rooms and doors of a map without labels.

    Free are cells without walls, furniture and what is unknown, whatever the size of the robot. Rooms are free space and the furniture that
    stands alone in it, of at least 1.5 m²; doors are 0.6 to 1.4 m wide. Names go by a point in the room, in metres; the other rooms are
    called ``room 1``, ``room 2`` … from the top of the map. Cells larger than 0.2 m are refused, and so is a map without a room.

    Notes
    -----
    Obstacles that stand alone are furniture if they are no longer than 2.6 m and no thin piece of wall. Watershed by the distance to
    what is left cuts free space where it narrows. Two pieces are one room unless the way between them is that of a door: at most 1.4 m
    wide, narrower than both by 0.24 m, and between the ends of two walls less than 0.5 m thick.

    Examples
    --------
    >>> free = np.ones((40, 100), dtype=bool)
    >>> free[:, 50:52] = False  # a wall …
    >>> free[20:30, 50:52] = True  # … with a door
    >>> rooms = find_rooms(free, Frame(0.0, 0.0, 0.1, 40, 100), [(9.0, 1.0, "kitchen")])
    >>> rooms.names, rooms.graph.edges["room 1", "kitchen"]["doors"][0]["width"]
    (('room 1', 'kitchen'), 1.0)
    """
    from scipy.ndimage import distance_transform_edt, find_objects, label

    cell = frame.resolution
    if cell > COARSEST:
        raise InputError(f"cells of {cell:g} m are too coarse to tell doors from rooms; at most {COARSEST:g} m are accepted")
    morphology, segmentation = library("skimage.morphology", "navigation"), library("skimage.segmentation", "navigation")
    floor = _without_furniture(np.pad(free, 1), cell)
    far, nearest = distance_transform_edt(floor, return_indices=True)
    half = np.where(floor, (far - 0.5) * cell, 0.0)
    tops, _ = label(morphology.h_maxima(np.where(half < NARROWEST / 2, 0.0, half), WIDER / 2), np.ones((3, 3)))
    space = _Space(cell, floor, half, nearest)
    pieces = segmentation.watershed(-half, tops, mask=floor, connectivity=2)
    borders = list(_borders(pieces))
    while (joined := _joined(pieces, borders, space)) is not None:
        pieces = joined
        borders = list(_borders(pieces))
    kept = np.flatnonzero(np.bincount(pieces.ravel())[1:] * cell**2 >= LEAST_ROOM) + 1
    if not len(kept):
        raise InputError(f"the map has no free space of {LEAST_ROOM:g} m² or more, and so no room")
    boxes = find_objects(pieces)
    kept = np.array(sorted(kept, key=lambda piece: [side.start for side in boxes[piece - 1]]))
    number = np.full(int(pieces.max()) + 1, NOWHERE, np.int32)
    number[kept] = np.arange(len(kept))
    owner = number[pieces][1:-1, 1:-1]
    called = _called(owner, frame, names)
    graph = _graph(called, ["room"] * len(called), owner, frame)
    for border in borders:
        first, second = number[border.first], number[border.second]
        ends = _ends(border, space) if first != NOWHERE and second != NOWHERE else None
        width = (float(np.hypot(*(ends[0] - ends[1]))) - 1) * cell if ends else 0.0
        if ends and width >= NARROWEST:
            row, column = np.rint((ends[0] + ends[1]) / 2).astype(int) - 1
            _add_door(graph, (called[first], called[second]), {"at": list(frame.centre(int(row), int(column))), "width": round(width, 3)})
    return Rooms(frame, called, owner, graph)


@dataclass(frozen=True)
class _Space:
    """Free space without furniture, with an edge of a cell: half its width at each cell, in metres, and the nearest obstacle."""

    cell: float
    floor: Mask
    half: NDArray[np.float64]
    nearest: NDArray[np.int32]


@dataclass(frozen=True)
class _Border:
    """Cells at which two pieces touch each other, in one place."""

    first: int
    second: int
    cells: tuple[Cells, Cells]


def _without_furniture(free: Mask, cell: float) -> Mask:
    """Fill in specks, close the holes of walls, and take away what stands alone."""
    from scipy.ndimage import binary_closing, find_objects, label

    around = np.ones((3, 3))
    blobs, _ = label(~free, around)
    speck = np.bincount(blobs.ravel()) * cell**2 < max(SPECK, 3.5 * cell**2)
    walls = ~free & ~speck[blobs]
    reach = max(1, round(0.05 / cell))
    walls = binary_closing(np.pad(walls, reach), np.ones((2 * reach + 1, 2 * reach + 1), bool))[reach:-reach, reach:-reach]
    blobs, _ = label(walls, around)
    for number, box in enumerate(find_objects(blobs), start=1):
        sides = [(side.stop - side.start) * cell for side in box]
        if max(sides) <= FURNITURE and number != blobs[0, 0]:
            thing = blobs[box] == number
            long = float(np.hypot(*sides))
            thick = float(thing.sum()) * cell**2 / long
            if thick > WALL or long < max(3 * thick, STUB):
                walls[box][thing] = False
    return np.asarray(~walls)


def _borders(pieces: NDArray[np.int32]) -> Iterator[_Border]:
    """Where pieces touch, also at corners; the outermost cells belong to none."""
    from scipy.ndimage import label

    ends = []
    for step in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there = np.roll(pieces, np.negative(step), (0, 1))
        at = np.stack(np.nonzero((pieces != there) & (pieces > 0) & (there > 0)))
        pair = np.sort([pieces[*at], there[*at]], axis=0)
        ends += [np.concatenate([pair, at]), np.concatenate([pair, at + np.array(step)[:, None]])]
    table = np.unique(np.concatenate(ends, axis=1), axis=1)
    for part in np.split(table, np.flatnonzero((np.diff(table[:2], axis=1) != 0).any(axis=0)) + 1, axis=1):
        if part.size:
            at = part[2:] - part[2:].min(axis=1, keepdims=True)
            mask = np.zeros(at.max(axis=1) + 1, bool)
            mask[*at] = True
            places, count = label(mask, np.ones((3, 3)))
            for place in range(1, count + 1):
                here = part[:, places[*at] == place]
                yield _Border(int(part[0, 0]), int(part[1, 0]), (here[2], here[3]))


def _joined(pieces: NDArray[np.int32], borders: list[_Border], space: _Space) -> NDArray[np.int32] | None:
    """Make one of pieces that no door divides, the widest ways first; None if there are none.

    What is too small or too narrow to be a room is known only when all else is joined.
    """
    if not borders:
        return None
    size = int(pieces.max()) + 1
    widest = np.zeros(size)
    np.maximum.at(widest, pieces.ravel(), space.half.ravel())
    area = np.bincount(pieces.ravel(), minlength=size) * space.cell**2
    ways = np.array([space.half[border.cells].max() for border in borders])
    ends = np.array([(border.first, border.second) for border in borders])
    order = np.argsort(-ways, kind="stable")
    doorless = np.array([2 * way > WIDEST or not _between_walls(border, space) for way, border in zip(ways, borders, strict=True)], bool)
    for join in (doorless, ways > widest[ends].min(axis=1) - WIDER, area[ends].min(axis=1) < LEAST_ROOM):
        group, settled = np.arange(size), np.zeros(size, bool)
        for place in order[join[order]]:
            if join is doorless or not settled[ends[place]].any():
                one, other = np.sort(group[ends[place]])
                group[group == other] = one
                settled[ends[place]] = True
        if join.any():
            return group[pieces].astype(np.int32)
    return None


def _ends(border: _Border, space: _Space) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """The obstacles on both sides of a way where it is widest, as it is at its narrowest there; None if it has but one side."""
    best = int(space.half[border.cells].argmax())
    here = np.array([cells[best] for cells in border.cells])
    sides = space.nearest[:, border.cells[0], border.cells[1]].T.astype(np.float64)
    others = sides[(sides - here) @ (sides[best] - here) < 0]
    return (sides[best], others[np.hypot(*(others - here).T).argmin()]) if len(others) else None


def _between_walls(border: _Border, space: _Space) -> bool:
    """Whether a way is between the ends of two walls; a way between furniture and a wall has a side that goes on."""
    ends = _ends(border, space)
    if ends is None:
        return bool(2 * space.half[border.cells].max() < NARROWEST)  # a hole in a wall
    along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    across, inside = np.array([-along[1], along[0]]), max(INTO / space.cell - 0.5, 0.0) * along
    return all(_thickness(at, across, space) <= JAMB for at in (ends[0] - inside, ends[1] + inside))


def _thickness(at: NDArray[np.float64], across: NDArray[np.float64], space: _Space) -> float:
    """How far obstacles reach from a point to both sides, in metres."""
    steps = np.arange(0, ACROSS / space.cell, 0.5)
    total = 0
    for sign in (1, -1):
        cells = np.clip(np.rint(at + sign * steps[:, None] * across), 0, np.subtract(space.floor.shape, 1))  # the outermost are not free
        free = space.floor[*cells.astype(np.int64).T]
        total += int(free.argmax()) if free.any() else len(steps)
    return total / 2 * space.cell


def _called(owner: NDArray[np.int32], frame: Frame, names: Sequence[tuple[float, float, str]]) -> tuple[str, ...]:
    called = [f"room {number}" for number in range(1, int(owner.max()) + 2)]
    given: dict[int, str] = {}
    for x, y, name in names:
        room = int(owner[frame.cell(x, y)])
        if room == NOWHERE:
            raise InputError(f"the name {shown(name)} at ({x:g}, {y:g}) is in no room that was found; a point on free floor is accepted")
        if room in given or name in given.values():
            raise InputError(f"the name {shown(name)} at ({x:g}, {y:g}) is given twice, or its room has two; each room has one name")
        given[room] = name
    for room, name in given.items():
        if name in called and called.index(name) != room:
            raise InputError(f"{shown(name)} is the number of another room; give this room a name of its own")
    return tuple(given.get(room, number) for room, number in enumerate(called))


def read_names(path: Path) -> tuple[tuple[float, float, str], ...]:
    """Read names of rooms: lines ``x,y,name``, where the point in metres is anywhere in the room."""
    try:
        lines = [line for line in csv.reader(read_bytes(path).decode("utf-8").splitlines()) if line]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: the file cannot be read: {error}") from None
    found = []
    for number, line in enumerate(lines, start=1):
        try:
            x, y, name = line
            found.append((float(x), float(y), name.strip()))
        except ValueError:
            found.append((nan, nan, ""))
        if not (isfinite(found[-1][0] + found[-1][1]) and found[-1][2]):
            raise InputError(f"{path}, line {number}: {shown(','.join(line))} is not x,y,name, such as 2.5,1,kitchen")
    return tuple(found)
