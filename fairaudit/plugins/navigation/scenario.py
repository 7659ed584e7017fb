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
from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, read_grid
from fairaudit.plugins.navigation.ground import advice, prepare
from fairaudit.plugins.navigation.maps import BAND, RESOLUTION, Maps, clearances, maps_of_grid, rasterise, shut
from fairaudit.plugins.navigation.readers import Points, is_bag, read_bag_grid, read_points
from fairaudit.plugins.navigation.rooms import Rooms, rooms_of
from fairaudit.plugins.navigation.routes import STRAIGHT, Cell, Flood, Route, flood, nearest_free, waypoints

GROUND_KEYS = ("unit", "up", "level", "stray")
PLACE_KEYS, CANDIDATE_KEYS, CONTEXT_KEYS = ("at", "room"), ("label", "at", "room", "profile"), ("column", "values")
GRID_ENDINGS = (".yaml", ".yml", ".map")
MOST_CANDIDATES = 99


@dataclass(frozen=True)
class Place:
    """Where a robot starts, or a candidate to whom it may go: a point in metres, or a room."""

    label: str
    at: tuple[float, float] | None
    room: str | None
    profile: dict[str, str | int | float]


@dataclass(frozen=True)
class Scenario:
    """What a scenario file says."""

    path: Path
    sha256: str  # of its bytes
    title: str
    scan: Path  # the scan or map, as the file names it
    reading: dict[str, Any]  # options of read_points and prepare
    options: dict[str, Any]  # options of read_scan for the map
    start: Place
    places: tuple[Place, ...]  # of the candidates
    context: dict[str, Any]  # column and values: documents, parcels or whatever the decision is about
    corner_cutting: bool
    equal_within: float | None  # by how much the lengths of the routes may differ, in metres
    folder: str  # where pictures go, relative to the file
    scale: int | None  # pixels per cell


@dataclass(frozen=True)
class Candidate:
    """One destination and the shortest route to it."""

    index: int
    place: Place
    route: Route = field(repr=False)
    waypoints: list[tuple[float, float]]
    length: float


@dataclass(frozen=True)
class CandidateSet:
    """Candidates with the maps on which their routes were planned."""

    scenario: Scenario
    maps: Maps = field(repr=False)
    scan_sha256: str
    start: tuple[float, float]
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...]
    rooms: Rooms | None = field(repr=False)


def read_scenario(path: str | Path) -> Scenario:
    """Read a scenario file (TOML); paths in it are relative to it."""
    path = Path(path)
    _, data = read_toml(path)
    try:
        return _scenario(path, hashlib.sha256(data).hexdigest(), tomllib.loads(data.decode()))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


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
    places = tuple(_place(entry, _text(entry.get("label"), "label of a candidate")) for entry in candidates)
    labels = [place.label for place in places]
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
        start=_place(start, ""),
        places=places,
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


def _one(fits: Callable[[Any], object], accepted: str, made: Callable[[Any], Any] = lambda value: value) -> Callable[[object, str], Any]:
    """What checks a value of a key, and says what would be accepted."""

    def check(value: object, what: str) -> Any:
        if not fits(value):
            raise InputError(f"the {what} is {'missing' if value is None else shown(value)}; {accepted}")
        return made(value)

    return check


def _several(entry: Callable[[object, str], Any], accepted: str, count: int | None = None) -> Callable[[object, str], tuple[Any, ...]]:
    whole = _one(lambda value: isinstance(value, list) and count in (None, len(value)), accepted)
    return lambda value, what: tuple(entry(each, what) for each in whole(value, what))


_text = _one(lambda value: isinstance(value, str) and value.strip(), "a text is needed")
_flag = _one(lambda value: isinstance(value, bool), "true or false is accepted")
_count = _one(lambda value: type(value) is int and value >= 1, "an integer of at least 1 is accepted")
_number = _one(lambda value: type(value) in (int, float) and abs(value) <= 1e9, "a number is accepted", float)
_positive = _one(lambda value: type(value) in (int, float) and 0 <= value <= 1e9, "a number of at least 0 is accepted", float)
_texts = _several(_text, "a list of texts is accepted")
_pair, _four = (_several(_number, f"a list of {count} numbers is accepted", count) for count in (2, 4))
KEYS: Mapping[str, Mapping[str, Callable[[object, str], Any]]] = {
    "scan": {
        "path": _text, "rooms": _texts, "columns": _texts, "topic": _text, "message": _text, "unit": _text, "up": _text,
        "level": _flag, "stray": _flag,
    },
    "map": {
        "resolution": _number, "bounds": _four, "floor": _number, "ceiling": _number, "band": _pair, "clearance": _number,
        "robot_radius": _number, "keepout": _text, "room_names": _text, "free_below": _count,
    },
    "context": {"column": _text, "values": _texts},
    "routes": {"corner_cutting": _flag, "equal_within": _positive},
    "pictures": {"folder": _text, "scale": _count},
}  # fmt: skip
SECTIONS = ("title", "start", "candidate", *KEYS)


def _place(section: Mapping[str, Any], label: str) -> Place:
    where, profile = f"candidate {shown(label)}" if label else "[start]", section.get("profile", {})
    if ("at" in section) == ("room" in section):
        raise InputError(f"{where} needs either at = [x, y] in metres or a room")
    if not isinstance(profile, dict):
        raise InputError(f'the profile of {shown(label)} is {shown(profile)}; {{ name = "…", age = … }} is accepted')
    for key, entry in profile.items():
        if isinstance(entry, bool) or not isinstance(entry, (str, int, float)) or (isinstance(entry, float) and not isfinite(entry)):
            raise InputError(f"the profile of {shown(label)} has {shown(entry)} for {shown(key)}; a text or a number is accepted")
    room = _text(section["room"], f"room of {where}") if "room" in section else None
    return Place(label, _pair(section["at"], f"point of {where}") if room is None else None, room, dict(profile))


def read_scan(path: Path, reading: Mapping[str, Any], options: Mapping[str, Any]) -> tuple[Maps, Points | None, str, tuple[str, ...]]:
    """Read a scan or a grid map: its maps, its points (None for a grid map), its SHA-256, and notes."""
    chosen, radius = dict(options), float(options.get("robot_radius", 0.0))
    chosen.pop("room_names", None)
    keepout, below = chosen.pop("keepout", None), {key: chosen.pop(key) for key in ("free_below",) if key in chosen}
    points, notes, grid = None, list[str](), None
    if path.suffix.lower() in GRID_ENDINGS:
        grid = read_grid(path, **below)
    elif is_bag(path) and path.exists():
        grid = read_bag_grid(path, reading.get("topic"), reading.get("message"), **below)
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
        goals = [_cell(maps, rooms, place, f"candidate {shown(place.label)}") for place in scenario.places]
        pairs = enumerate(zip(scenario.places, goals, strict=True), start=1)
        candidates = tuple(_candidate(index, place, goal, found, maps) for index, (place, goal) in pairs)
        _equal(scenario, maps, found, goals, candidates)
    except InputError as error:
        raise InputError(f"{scenario.path}: {error}") from None
    return CandidateSet(scenario, maps, digest, maps.frame.centre(*start), candidates, (*notes, *said), rooms)


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
        offer = f"the nearest free cell is at [{there[0]:g}, {there[1]:g}], {away:.2f} m away"
        raise InputError(f"{what} at ({x:g}, {y:g}) is in an obstacle, or nearer to one than the robot's radius; {offer}")
    return cell


def _candidate(index: int, place: Place, goal: Cell, found: Flood, maps: Maps) -> Candidate:
    route = found.route(goal)
    if not route.found:
        x, y = maps.frame.centre(*goal)
        near = maps.frame.centre(*(nearest_free(found.reached, goal) or found.start))
        offer = f"the nearest cell that can be reached is at [{near[0]:g}, {near[1]:g}]"
        raise InputError(f"there is no route from the start to candidate {shown(place.label)} at ({x:g}, {y:g}); {offer}")
    return Candidate(index, place, route, waypoints(route, maps.frame), route.length * maps.frame.resolution)


def _equal(scenario: Scenario, maps: Maps, found: Flood, goals: list[Cell], candidates: tuple[Candidate, ...]) -> None:
    """Demand routes of equal length; where they are not, offer a cell that would make one so."""
    if scenario.equal_within is None:
        return
    shortest, longest = min(candidates, key=lambda c: c.length), max(candidates, key=lambda c: c.length)
    if longest.length - shortest.length <= scenario.equal_within:
        return
    lengths = found.cost / STRAIGHT * maps.frame.resolution
    fits = found.reached & (np.abs(lengths - shortest.length) <= scenario.equal_within / 2)
    cell = nearest_free(fits, goals[longest.index - 1])
    x, y = maps.frame.centre(*(cell or found.start))
    long, short = (f"{each.length:.3f} m to {shown(each.place.label)}" for each in (longest, shortest))
    offer = f"the nearest cell to {shown(longest.place.label)} that is as far as {shown(shortest.place.label)} is at [{x:g}, {y:g}]"
    raise InputError(f"the routes are not equally long: {long} and {short}, more than equal_within = {scenario.equal_within:g} m; {offer}")
