"""Scenario files: a scan, a start, destinations and profiles, from which a set of candidate routes is planned."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from fairaudit.errors import InputError, nearest, shown
from fairaudit.files import check_keys, read_section, read_toml
from fairaudit.plugins.navigation.formats import is_bag, read_bag_grid
from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, OccupancyGrid, read_grid
from fairaudit.plugins.navigation.ground import advice, prepare
from fairaudit.plugins.navigation.maps import BAND, RESOLUTION, Maps, clearances, maps_of_grid, rasterise, shut
from fairaudit.plugins.navigation.readers import Points, read_points
from fairaudit.plugins.navigation.rooms import Rooms, rooms_of
from fairaudit.plugins.navigation.routes import Cell, Flood, Route, flood, nearest_free, waypoints

__all__ = ["Candidate", "CandidateSet", "Place", "Scenario", "plan_candidates", "read_scan", "read_scenario", "scenarios_of"]

GROUND_KEYS = ("unit", "up", "level", "stray")
PLACE_KEYS, CANDIDATE_KEYS, CONTEXT_KEYS = ("at", "room"), ("label", "at", "room", "profile"), ("column", "values")
GRID_ENDINGS = (".yaml", ".yml", ".map")
MOST_CANDIDATES = 99


@dataclass(frozen=True)
class Place:
    """Where a robot starts or is to go: a point in metres, or a room."""

    at: tuple[float, float] | None = None
    room: str | None = None


@dataclass(frozen=True)
class Scenario:
    """What a scenario file says; labels, places and profiles have one entry per candidate."""

    path: Path
    sha256: str  # of its bytes
    title: str
    scan: Path  # the scan or map, as the file names it
    reading: dict[str, Any]  # options of read_points and prepare
    options: dict[str, Any]  # options of read_scan for the map
    start: Place
    labels: tuple[str, ...]
    places: tuple[Place, ...]
    profiles: tuple[dict[str, str | int | float], ...]
    context: dict[str, Any]  # column and values: documents, parcels or whatever the decision is about
    corner_cutting: bool
    equal_within: float | None  # by how much the lengths of the routes may differ, in metres
    folder: str  # where pictures go, relative to the file
    scale: int | None  # pixels per cell


@dataclass(frozen=True)
class Candidate:
    """One destination and the shortest route to it."""

    index: int
    label: str
    profile: dict[str, str | int | float]
    room: str | None
    route: Route = field(repr=False)
    waypoints: list[tuple[float, float]]
    length: float


@dataclass(frozen=True)
class CandidateSet:
    """Candidates with the maps on which their routes were planned; `points` is None where the scan was a grid map."""

    scenario: Scenario
    maps: Maps = field(repr=False)
    points: Points | None = field(repr=False)
    scan_sha256: str
    start: tuple[float, float]
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...]
    rooms: Rooms | None = field(repr=False)


def read_scenario(path: str | Path) -> Scenario:
    """Read a scenario file (TOML); paths in it are relative to it."""
    path = Path(path)
    data, document = _document(path)
    try:
        return _scenario(path, hashlib.sha256(data).hexdigest(), document)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def scenarios_of(path: str | Path) -> list[Scenario]:
    """Read a scenario file, or the scenario files beside an experiment file that draw the pictures of its section [images]."""
    path = Path(path)
    document = _document(path)[1]
    images = document.get("images")
    if "scan" in document or not isinstance(images, dict):
        return [read_scenario(path)]
    texts = [
        text for entry in images.values() for text in (entry.values() if isinstance(entry, dict) else [entry]) if isinstance(text, str)
    ]
    folders = dict.fromkeys(str(Path(text).parent) for text in texts)
    beside: dict[str, Scenario] = {}
    for file in sorted(path.parent.glob("*.toml")):
        if "scan" in _document(file)[1]:
            scenario = read_scenario(file)
            beside.setdefault(str(Path(scenario.folder)), scenario)
    for folder in folders:
        if folder not in beside:
            raise InputError(f"{path}: no scenario file beside it draws pictures into {shown(folder)}; {nearest(folder, beside)}")
    return [beside[folder] for folder in folders]


def _document(path: Path) -> tuple[bytes, dict[str, Any]]:
    data = read_toml(path)[1]
    return data, tomllib.loads(data.decode())


def _scenario(path: Path, digest: str, document: Mapping[str, Any]) -> Scenario:
    if "scan" not in document:
        raise InputError("there is no section [scan]; a scenario file says which scan, start and candidates there are")
    check_keys(document, SECTIONS, "the file")
    candidates = document.get("candidate", [])
    if not (isinstance(candidates, list) and candidates and all(isinstance(entry, dict) for entry in candidates)):
        raise InputError("there are no candidates; each is a section [[candidate]] with label and at = [x, y] or room")
    if len(candidates) > MOST_CANDIDATES:
        raise InputError(f"there are {len(candidates)} candidates; at most {MOST_CANDIDATES} are accepted")
    for entry in candidates:
        check_keys(entry, CANDIDATE_KEYS, "[[candidate]]")
    labels = tuple(_text(entry.get("label"), "label of a candidate") for entry in candidates)
    for label in labels:
        if labels.count(label) > 1:
            raise InputError(f"two candidates have the label {shown(label)}; give each its own")
    scan, options, context, routes, pictures = (_section(document, name) for name in ("scan", "map", "context", "routes", "pictures"))
    start = read_section(document, "start")
    check_keys(start, PLACE_KEYS, "[start]")
    for key in {"keepout", "room_names"} & options.keys():
        options[key] = path.parent / options[key]
    for key in CONTEXT_KEYS if context else ():
        if key not in context:
            raise InputError(f"the {key} of [context] is missing; column and values are needed")
    return Scenario(
        path=path,
        sha256=digest,
        title=_text(document.get("title", path.stem), "title"),
        scan=Path(_text(scan.pop("path", None), "path of [scan]")),
        reading=scan,
        options=options,
        start=_place(start, "[start]"),
        labels=labels,
        places=tuple(_place(entry, f"candidate {shown(label)}") for entry, label in zip(candidates, labels, strict=True)),
        profiles=tuple(_profile(entry.get("profile", {}), label) for entry, label in zip(candidates, labels, strict=True)),
        context={key: list(value) if key == "values" else value for key, value in context.items()},
        corner_cutting=routes.get("corner_cutting", False),
        equal_within=routes.get("equal_within"),
        folder=pictures.get("folder", f"{path.stem}-candidates"),
        scale=pictures.get("scale"),
    )


def _section(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    section = read_section(document, name)
    check_keys(section, tuple(KEYS[name]), f"[{name}]")
    return {key: KEYS[name][key](value, f"{key} of [{name}]") for key, value in section.items()}


def _text(value: object, what: str) -> str:
    if not (isinstance(value, str) and value.strip()):
        raise InputError(f"the {what} is {'missing' if value is None else shown(value)}; a text is needed")
    return value


def _texts(value: object, what: str) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise InputError(f"the {what} are {shown(value)}; a list of texts is accepted")
    return tuple(_text(entry, f"entry of the {what}") for entry in value)


def _flag(value: object, what: str) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"the {what} is {shown(value)}; true or false is accepted")
    return value


def _count(value: object, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise InputError(f"the {what} is {shown(value)}; an integer of at least 1 is accepted")
    return value


def _number(value: object, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value) or abs(value) > 1e9:
        raise InputError(f"the {what} is {shown(value)}; a number is accepted")
    return float(value)


def _positive(value: object, what: str) -> float:
    if (number := _number(value, what)) < 0:
        raise InputError(f"the {what} is {value}; at least 0 is accepted")
    return number


def _numbers(count: int) -> Callable[[object, str], tuple[float, ...]]:
    def check(value: object, what: str) -> tuple[float, ...]:
        if not (isinstance(value, list) and len(value) == count):
            raise InputError(f"the {what} is {shown(value)}; a list of {count} numbers is accepted")
        return tuple(_number(entry, what) for entry in value)

    return check


KEYS: Mapping[str, Mapping[str, Callable[[object, str], Any]]] = {
    "scan": {
        "path": _text, "rooms": _texts, "columns": _texts, "topic": _text, "message": _text, "unit": _text, "up": _text,
        "level": _flag, "stray": _flag,
    },
    "map": {
        "resolution": _number, "bounds": _numbers(4), "floor": _number, "ceiling": _number, "band": _numbers(2), "clearance": _number,
        "robot_radius": _number, "keepout": _text, "room_names": _text, "free_below": _count,
    },
    "context": {"column": _text, "values": _texts},
    "routes": {"corner_cutting": _flag, "equal_within": _positive},
    "pictures": {"folder": _text, "scale": _count},
}  # fmt: skip
SECTIONS = ("title", "start", "candidate", *KEYS)


def _place(section: Mapping[str, Any], where: str) -> Place:
    if ("at" in section) == ("room" in section):
        raise InputError(f"{where} needs either at = [x, y] in metres or a room")
    if "room" in section:
        return Place(room=_text(section["room"], f"room of {where}"))
    x, y = _numbers(2)(section["at"], f"point of {where}")
    return Place(at=(x, y))


def _profile(value: object, label: str) -> dict[str, str | int | float]:
    if not isinstance(value, dict):
        raise InputError(f'the profile of {shown(label)} is {shown(value)}; {{ name = "…", age = … }} is accepted')
    for key, entry in value.items():
        if isinstance(entry, bool) or not isinstance(entry, (str, int, float)) or (isinstance(entry, float) and not isfinite(entry)):
            raise InputError(f"the profile of {shown(label)} has {shown(entry)} for {shown(key)}; a text or a number is accepted")
    return dict(value)


def read_scan(path: Path, reading: Mapping[str, Any], options: Mapping[str, Any]) -> tuple[Maps, Points | None, str, tuple[str, ...]]:
    """Read a scan or a grid map: its maps, its points (None for a grid map), its SHA-256, and notes."""
    chosen, radius = dict(options), float(options.get("robot_radius", 0.0))
    chosen.pop("room_names", None)
    keepout, below = chosen.pop("keepout", None), {key: chosen.pop(key) for key in ("free_below",) if key in chosen}
    points, notes, grid = None, [], _grid(path, reading, below)
    if grid is None:
        if below:
            raise InputError(f"{path} is a scan; free_below goes with maps")
        points = read_points(path, **{key: value for key, value in reading.items() if key not in GROUND_KEYS})
        points = prepare(points, **{key: value for key, value in reading.items() if key in GROUND_KEYS})
        maps, digest = rasterise(points, chosen.pop("resolution", RESOLUTION), **chosen), points.sha256
        low, high = (maps.floor + height for height in options.get("band", BAND))
        notes = [*points.notes, *advice(points, maps.frame.resolution, radius, (low, high))]
    else:
        odd = [key for key in chosen if key != "robot_radius"]
        odd += [key for key in reading if not is_bag(path) or key not in ("topic", "message")]
        if odd:
            raise InputError(f"{path} is a grid map, with a resolution of its own; {odd[0]} does not go with it")
        maps, digest = maps_of_grid(grid, radius), grid.sha256
    if keepout is not None:
        mask = read_grid(keepout)
        closed = shut(maps.frame, mask)
        between = int(((mask.states > FREE) & (mask.states < OCCUPIED)).sum())
        notes.append(f"the keepout mask {keepout.name} shuts {int(closed.sum()):,} cells (SHA-256 of its cells {mask.sha256})")
        if between:
            notes.append(f"{between:,} cells of the keepout mask are neither free nor occupied, and shut nothing")
        maps = replace(maps, free=maps.free & ~closed)
    return maps, points, digest, tuple(notes)


def _grid(path: Path, reading: Mapping[str, Any], below: Mapping[str, int]) -> OccupancyGrid | None:
    """Grid map of a file, or None if it is a scan."""
    if path.suffix.lower() in GRID_ENDINGS:
        return read_grid(path, **below)
    return read_bag_grid(path, reading.get("topic"), reading.get("message"), **below) if is_bag(path) and path.exists() else None


def plan_candidates(scenario: Scenario) -> CandidateSet:
    """Build the maps of a scenario and plan the route to each candidate.

    If the start or a destination is not free, the nearest free cell is offered, not taken; and where the lengths differ by more than is
    allowed, the nearest cell that would make them equal.
    """
    try:
        maps, points, digest, notes = read_scan(scenario.path.parent / scenario.scan, scenario.reading, scenario.options)
        rooms, said = rooms_of(maps, points, scenario.options.get("room_names"))
        start = _cell(maps, rooms, scenario.start, "the start")
        found = flood(maps.free, start, corner_cutting=scenario.corner_cutting)
        goals = [
            _cell(maps, rooms, place, f"candidate {shown(label)}") for label, place in zip(scenario.labels, scenario.places, strict=True)
        ]
        candidates = tuple(_candidate(scenario, maps, found, index, goal) for index, goal in enumerate(goals))
        _equal(scenario, maps, found, goals, candidates)
    except InputError as error:
        raise InputError(f"{scenario.path}: {error}") from None
    return CandidateSet(scenario, maps, points, digest, maps.frame.centre(*start), candidates, (*notes, *said), rooms)


def _cell(maps: Maps, rooms: Rooms | None, place: Place, what: str) -> Cell:
    """Cell of a place: that of a point, or the one of a room that is farthest from obstacles."""
    if place.room is not None:
        if rooms is None or place.room not in rooms.names:
            known = rooms.names if rooms is not None else ()
            raise InputError(f"{what} is in the room {shown(place.room)}, which the scan does not have; {nearest(place.room, known)}")
        inside = maps.free & (rooms.owner == rooms.names.index(place.room))
        if not inside.any():
            raise InputError(f"{what} is in the room {shown(place.room)}, which has no free cell; a smaller robot_radius may help")
        room = np.where(inside, clearances(maps.free), -1.0)
        row, column = divmod(int(room.argmax()), maps.frame.columns)
        return row, column
    x, y = place.at or (0.0, 0.0)
    try:
        cell = maps.frame.cell(x, y)
    except InputError as error:
        raise InputError(f"{what}: {error}") from None
    if not maps.free[cell]:
        other = nearest_free(maps.free, cell)
        if other is None:
            raise InputError(f"{what} at ({x:g}, {y:g}) is not free, and neither is any other cell; look at the options of [map]")
        there = maps.frame.centre(*other)
        away = float(np.hypot(there[0] - x, there[1] - y))
        raise InputError(
            f"{what} at ({x:g}, {y:g}) is in an obstacle, or nearer to one than the robot's radius; the nearest free cell is at "
            f"[{there[0]:g}, {there[1]:g}], {away:.2f} m away"
        )
    return cell


def _candidate(scenario: Scenario, maps: Maps, found: Flood, index: int, goal: Cell) -> Candidate:
    label = scenario.labels[index]
    route = found.route(goal)
    if not route.found:
        there = maps.frame.centre(*goal)
        nearby = nearest_free(found.reached, goal)
        offer = maps.frame.centre(*(nearby or found.start))
        raise InputError(
            f"there is no route from the start to candidate {shown(label)} at ({there[0]:g}, {there[1]:g}); the nearest cell that can be "
            f"reached is at [{offer[0]:g}, {offer[1]:g}]"
        )
    length = route.length * maps.frame.resolution
    return Candidate(index + 1, label, scenario.profiles[index], scenario.places[index].room, route, waypoints(route, maps.frame), length)


def _equal(scenario: Scenario, maps: Maps, found: Flood, goals: list[Cell], candidates: tuple[Candidate, ...]) -> None:
    """Demand routes of equal length; where they are not, offer a cell that would make one so."""
    if scenario.equal_within is None:
        return
    shortest, longest = min(candidates, key=lambda c: c.length), max(candidates, key=lambda c: c.length)
    if longest.length - shortest.length <= scenario.equal_within:
        return
    lengths = found.lengths * maps.frame.resolution
    fits = found.reached & (np.abs(lengths - shortest.length) <= scenario.equal_within / 2)
    cell = nearest_free(fits, goals[longest.index - 1])
    x, y = maps.frame.centre(*(cell or found.start))
    raise InputError(
        f"the routes are not equally long: {longest.length:.3f} m to {shown(longest.label)} and {shortest.length:.3f} m to "
        f"{shown(shortest.label)}, where equal_within allows a difference of {scenario.equal_within:g} m; the nearest cell to "
        f"{shown(longest.label)} that is as far as {shown(shortest.label)} is at [{x:g}, {y:g}]"
    )
