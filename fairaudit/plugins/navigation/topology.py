"""The topological map of an annotated scan: rooms, and the doors between them."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.libraries import library
from fairaudit.plugins.navigation.grids import Frame
from fairaudit.plugins.navigation.readers import Part, Points

__all__ = ["footprints", "middle", "topology", "topology_json"]

RESOLUTION = 0.1
REACH = 0.6
SAME_DOOR = 0.6
NOWHERE = -1


def footprints(points: Points, frame: Frame) -> NDArray[np.int16]:
    """Find which room each cell of a frame belongs to.

    Parameters
    ----------
    points : Points
        An annotated scan.
    frame : Frame
        The cells.

    Returns
    -------
    array of int16, shape (rows, columns)
        Position in ``points.rooms``, or -1. A room is where its floor is; one without a floor is where its other points are, its ceiling
        and doors apart. A cell that two rooms claim belongs to the one that has more points in it, the first among equals.

    Raises
    ------
    InputError
        If the scan has no rooms.
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


def topology(points: Points, *, resolution: float = RESOLUTION, reach: float = REACH) -> Any:
    """Find the rooms of an annotated scan and which of them a door joins.

    Parameters
    ----------
    points : Points
        An annotated scan of an S3DIS area.
    resolution : float
        Side of the cells on which rooms are laid out, in metres.
    reach : float
        How far from a door to look for the rooms on its two sides, in metres; more than a wall is thick.

    Returns
    -------
    networkx.Graph
        Nodes: rooms, with ``kind``, ``at`` (the middle of the floor, metres), ``area`` (m²) and ``exits`` (doors that lead to no scanned
        room). Edges: pairs of rooms, with ``doors``, each a ``name``, ``at`` and ``width``. Openings without a door are no edges.

    Raises
    ------
    InputError
        If the scan has no rooms, or networkx is missing.

    Notes
    -----
    A shut door lies in a wall: one room is before and one behind it. If both sides are in one room, the door stands open, and the rooms are
    those at its two ends. Doors of one pair of rooms nearer than 0.6 m to each other are one door that both rooms list.
    """
    networkx = library("networkx", "navigation")
    xy = points.xyz[:, :2]
    low, high = xy.min(axis=0), xy.max(axis=0)
    frame = Frame.around((float(low[0]), float(low[1]), float(high[0]), float(high[1])), resolution)
    owner = footprints(points, frame)
    graph = networkx.Graph()
    for number, room in enumerate(points.rooms):
        rows, columns = np.nonzero(owner == number)
        at = middle(rows, columns, frame) if len(rows) else None
        graph.add_node(room, kind=room.rsplit("_", 1)[0], at=at, area=round(len(rows) * resolution**2, 2), exits=[])
    for part in points.parts:
        if part.kind == "door" and part.room is not None:
            _add_door(graph, points, part, owner, frame, reach)
    return graph


def middle(rows: NDArray[np.int64], columns: NDArray[np.int64], frame: Frame) -> list[float]:
    """Centre of the cell of a room that is nearest to the mean of its cells."""
    best = int(((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2).argmin())
    return list(frame.centre(int(rows[best]), int(columns[best])))


def _add_door(graph: Any, points: Points, part: Part, owner: NDArray[np.int16], frame: Frame, reach: float) -> None:
    middle, along, across, length, depth = _box(points.xyz[part.start : part.stop, :2])
    door = {"name": f"{part.room}/{part.name}", "at": [round(float(v), 3) for v in middle], "width": round(2 * length, 3)}
    before, behind = _rooms(owner, frame, (middle, across, along), (depth, length / 2), reach)
    pair = _different(before, behind)
    if pair is None and min(max(before.values(), default=0.0), max(behind.values(), default=0.0)) > 0.5:
        pair = _different(*_rooms(owner, frame, (middle, along, across), (length, depth + frame.resolution), reach))
    if pair is None:
        exits = graph.nodes[part.room]["exits"]
        if not any(_near(door, other) for other in exits):
            exits.append(door)
        return
    first, second = (points.rooms[number] for number in pair)
    if not graph.has_edge(first, second):
        graph.add_edge(first, second, doors=[])
    doors = graph.edges[first, second]["doors"]
    if not any(_near(door, other) for other in doors):
        doors.append(door)


def _near(door: dict[str, Any], other: dict[str, Any]) -> bool:
    return float(np.hypot(door["at"][0] - other["at"][0], door["at"][1] - other["at"][1])) < SAME_DOOR


def _box(xy: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float, float]:
    """Middle, long and short axis of a door's footprint, and half its extents along them."""
    centred = xy - xy.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    across, along = axes[:, 0], axes[:, 1]
    ends = [np.quantile(centred @ axis, (0.01, 0.99)) for axis in (along, across)]
    middle = xy.mean(axis=0) + along * ends[0].mean() + across * ends[1].mean()
    length, depth = (float(end[1] - end[0]) / 2 for end in ends)
    return middle, along, across, length, depth


_Axes = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def _rooms(owner: NDArray[np.int16], frame: Frame, axes: _Axes, extents: tuple[float, float], reach: float) -> list[dict[int, float]]:
    """Rooms on the two sides of a box, each with the share of the probes that met it."""
    middle, outward, sideward = axes
    step = frame.resolution / 2
    away = extents[0] + step * np.arange(1, ceil(reach / step) + 1)
    lateral = np.linspace(-extents[1], extents[1], max(3, ceil(2 * extents[1] / step)))
    found = []
    for sign in (1.0, -1.0):
        probes = middle + (sign * away)[:, None, None] * outward + lateral[None, :, None] * sideward
        cells = frame.cells(probes.reshape(-1, 2))
        numbers, counts = np.unique(owner.ravel()[cells[cells >= 0]], return_counts=True)
        found.append({int(n): int(c) / len(cells) for n, c in zip(numbers, counts, strict=True) if n != NOWHERE})
    return found


def _different(before: dict[int, float], behind: dict[int, float]) -> tuple[int, int] | None:
    """Return two different rooms, one of each side, that most probes met, or None."""
    pairs = [(before[a] + behind[b], -a, -b) for a in before for b in behind if a != b]
    if not pairs:
        return None
    _, first, second = max(pairs)
    return -first, -second


def topology_json(graph: Any) -> dict[str, Any]:
    """Return nodes and edges as plain lists, for JSON.

    Returns
    -------
    dict
        ``nodes`` (each with ``id``) and ``edges`` (each with ``source`` and ``target``), with the attributes of `topology`.
    """
    return {
        "nodes": [{"id": room, **graph.nodes[room]} for room in graph.nodes],
        "edges": [{"source": first, "target": second, **graph.edges[first, second]} for first, second in graph.edges],
    }
