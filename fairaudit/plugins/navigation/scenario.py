"""Scenario files: a scan, a start, destinations and profiles, from which a set of candidate routes is planned."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from fairaudit.errors import InputError, nearest, shown
from fairaudit.plugins.navigation.formats import is_bag, read_bag_grid
from fairaudit.plugins.navigation.grids import OccupancyGrid, read_grid
from fairaudit.plugins.navigation.ground import advice, prepare
from fairaudit.plugins.navigation.maps import BAND, RESOLUTION, Maps, clearances, maps_of_grid, rasterise
from fairaudit.plugins.navigation.readers import Points, read_points
from fairaudit.plugins.navigation.routes import Cell, Flood, Route, flood, nearest_free, waypoints
from fairaudit.plugins.navigation.topology import footprints

__all__ = ["Candidate", "CandidateSet", "Place", "Scenario", "plan_candidates", "read_scan", "read_scenario", "scenarios_of"]

SECTIONS = ("title", "scan", "map", "start", "candidate", "context", "routes", "pictures")
FILE_KEYS, GROUND_KEYS = ("rooms", "columns", "topic", "message"), ("unit", "up", "level", "stray")
SCAN_KEYS, MAP_KEYS = ("path", *FILE_KEYS, *GROUND_KEYS), ("resolution", "bounds", "floor", "ceiling", "band", "clearance", "robot_radius")
PLACE_KEYS, CANDIDATE_KEYS = ("at", "room"), ("label", "at", "room", "profile")
CONTEXT_KEYS, ROUTE_KEYS, PICTURE_KEYS = ("column", "values"), ("corner_cutting", "equal_within"), ("folder", "scale")
GRID_ENDINGS = (".yaml", ".yml", ".map")
MOST_CANDIDATES = 99


@dataclass(frozen=True)
class Place:
    """Where a robot starts or is to go: a point in metres, or a room."""

    at: tuple[float, float] | None = None
    room: str | None = None


@dataclass(frozen=True)
class Scenario:
    """What a scenario file says.

    Attributes
    ----------
    path : Path
        The file.
    sha256 : str
        Digest of its bytes.
    title : str
        What it is about.
    scan : Path
        The scan or map, as the file names it.
    reading : dict
        Options of `read_points` and `prepare`.
    options : dict
        Options of `rasterise`.
    start : Place
        Where the robot is.
    labels, places, profiles : tuple
        One entry per candidate.
    context : dict
        ``column`` and ``values``: documents, parcels or whatever the decision is about.
    corner_cutting : bool
        Whether routes may cut corners.
    equal_within : float or None
        By how much the lengths of the routes may differ, in metres.
    folder : str
        Where pictures go, relative to the file.
    scale : int or None
        Pixels per cell.
    """

    path: Path
    sha256: str
    title: str
    scan: Path
    reading: dict[str, Any]
    options: dict[str, Any]
    start: Place
    labels: tuple[str, ...]
    places: tuple[Place, ...]
    profiles: tuple[dict[str, str | int | float], ...]
    context: dict[str, Any]
    corner_cutting: bool
    equal_within: float | None
    folder: str
    scale: int | None


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
    notes: tuple[str, ...] = ()


def read_scenario(path: str | Path) -> Scenario:
    """Read a scenario file (TOML); paths in it are relative to it.

    Raises
    ------
    InputError
        If it is not of the form; the message names the file and the key.
    """
    path = Path(path)
    data, document = _document(path)
    try:
        return _scenario(path, hashlib.sha256(data).hexdigest(), document)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def scenarios_of(path: str | Path) -> list[Scenario]:
    """Read a scenario file, or the scenario files beside an experiment file that draw the pictures of its section [images].

    Raises
    ------
    InputError
        If a file is not of the form, or no scenario draws into the folder of a picture.
    """
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
    try:
        data = path.read_bytes()
        return data, tomllib.loads(data.decode("utf-8"))
    except (FileNotFoundError, IsADirectoryError):
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: the file cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise InputError(f"{path}: this is not a TOML file: {error}") from None


def _scenario(path: Path, digest: str, document: Mapping[str, Any]) -> Scenario:
    if "scan" not in document:
        raise InputError("there is no section [scan]; a scenario file says which scan, start and candidates there are")
    _known(document, SECTIONS, "the file")
    scan, start = _section(document, "scan", SCAN_KEYS), _section(document, "start", PLACE_KEYS)
    options = _options(_section(document, "map", MAP_KEYS))
    candidates = document.get("candidate", [])
    if not (isinstance(candidates, list) and candidates and all(isinstance(entry, dict) for entry in candidates)):
        raise InputError("there are no candidates; each is a section [[candidate]] with label and at = [x, y] or room")
    if len(candidates) > MOST_CANDIDATES:
        raise InputError(f"there are {len(candidates)} candidates; at most {MOST_CANDIDATES} are accepted")
    for entry in candidates:
        _known(entry, CANDIDATE_KEYS, "[[candidate]]")
    labels = tuple(_text(entry.get("label"), "label of a candidate") for entry in candidates)
    for label in labels:
        if labels.count(label) > 1:
            raise InputError(f"two candidates have the label {shown(label)}; give each its own")
    context = _section(document, "context", CONTEXT_KEYS)
    routes, pictures = _section(document, "routes", ROUTE_KEYS), _section(document, "pictures", PICTURE_KEYS)
    equal, scale = routes.get("equal_within"), pictures.get("scale")
    if scale is not None and (isinstance(scale, bool) or not isinstance(scale, int) or scale < 1):
        raise InputError(f"[pictures] scale is {shown(scale)}; a number of pixels per cell of at least 1 is accepted")
    cutting = routes.get("corner_cutting", False)
    if not isinstance(cutting, bool):
        raise InputError(f"[routes] corner_cutting is {shown(cutting)}; true or false is accepted")
    return Scenario(
        path=path,
        sha256=digest,
        title=_text(document.get("title", path.stem), "title"),
        scan=Path(_text(scan.get("path"), "path of [scan]")),
        reading={key: _reading(key, value) for key, value in scan.items() if key != "path"},
        options=options,
        start=_place(start, "[start]"),
        labels=labels,
        places=tuple(_place(entry, f"candidate {shown(label)}") for entry, label in zip(candidates, labels, strict=True)),
        profiles=tuple(_profile(entry.get("profile", {}), label) for entry, label in zip(candidates, labels, strict=True)),
        context={
            "column": _text(context.get("column"), "column of [context]"),
            "values": list(_texts(context.get("values"), "values of [context]")),
        }
        if context
        else {},
        corner_cutting=cutting,
        equal_within=None if equal is None else _number(equal, "equal_within of [routes]", least=0.0),
        folder=_text(pictures.get("folder", f"{path.stem}-candidates"), "folder of [pictures]"),
        scale=scale,
    )


def _known(section: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    for key in section:
        if key not in keys:
            raise InputError(f"{where} has the unknown key {shown(key)}; {nearest(key, keys)}")


def _section(document: Mapping[str, Any], name: str, keys: tuple[str, ...]) -> dict[str, Any]:
    section = document.get(name, {})
    if not isinstance(section, dict):
        raise InputError(f"{name} must be a section [{name}], not {shown(section)}")
    _known(section, keys, f"[{name}]")
    return section


def _text(value: object, what: str) -> str:
    if not (isinstance(value, str) and value.strip()):
        raise InputError(
            f"the {what} is {shown(value)}; a text is needed" if value is not None else f"the {what} is missing; a text is needed"
        )
    return value


def _texts(value: object, what: str) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise InputError(f"the {what} are {shown(value)}; a list of texts is accepted")
    return tuple(_text(entry, f"entry of the {what}") for entry in value)


def _reading(key: str, value: object) -> Any:
    if key in ("rooms", "columns"):
        return _texts(value, f"{key} of [scan]")
    if key not in ("level", "stray"):
        return _text(value, f"{key} of [scan]")
    if not isinstance(value, bool):
        raise InputError(f"[scan] {key} is {shown(value)}; true or false is accepted")
    return value


def _number(value: object, what: str, least: float | None = None) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value) or abs(value) > 1e9:
        raise InputError(f"the {what} is {shown(value)}; a number is accepted")
    if least is not None and value < least:
        raise InputError(f"the {what} is {value}; at least {least:g} is accepted")
    return float(value)


def _numbers(value: object, what: str, count: int) -> tuple[float, ...]:
    if not (isinstance(value, list) and len(value) == count):
        raise InputError(f"the {what} is {shown(value)}; a list of {count} numbers is accepted")
    return tuple(_number(entry, what) for entry in value)


def _options(section: dict[str, Any]) -> dict[str, Any]:
    sizes = {"bounds": 4, "band": 2}
    return {
        key: _numbers(value, f"{key} of [map]", sizes[key]) if key in sizes else _number(value, f"{key} of [map]")
        for key, value in section.items()
    }


def _place(section: Mapping[str, Any], where: str) -> Place:
    if ("at" in section) == ("room" in section):
        raise InputError(f"{where} needs either at = [x, y] in metres or a room")
    if "room" in section:
        return Place(room=_text(section["room"], f"room of {where}"))
    x, y = _numbers(section["at"], f"point of {where}", 2)
    return Place(at=(x, y))


def _profile(value: object, label: str) -> dict[str, str | int | float]:
    if not isinstance(value, dict):
        raise InputError(f'the profile of {shown(label)} is {shown(value)}; {{ name = "…", age = … }} is accepted')
    for key, entry in value.items():
        if isinstance(entry, bool) or not isinstance(entry, (str, int, float)) or (isinstance(entry, float) and not isfinite(entry)):
            raise InputError(f"the profile of {shown(label)} has {shown(entry)} for {shown(key)}; a text or a number is accepted")
    return dict(value)


def read_scan(path: Path, reading: Mapping[str, Any], options: Mapping[str, Any]) -> tuple[Maps, Points | None, str]:
    """Read a scan or a grid map, and build the maps.

    Returns
    -------
    tuple
        The maps, the points (None for a grid map), and the SHA-256 of the scan.

    Raises
    ------
    InputError
        If it cannot be read, or an option does not go with it.
    """
    grid = _grid(path, reading)
    if grid is None:
        points = read_points(path, **{key: value for key, value in reading.items() if key in FILE_KEYS})
        points = prepare(points, **{key: value for key, value in reading.items() if key in GROUND_KEYS})
        chosen = dict(options)
        maps = rasterise(points, chosen.pop("resolution", RESOLUTION), **chosen)
        low, high = (maps.floor + height for height in options.get("band", BAND))
        said = advice(points, maps.frame.resolution, float(options.get("robot_radius", 0.0)), (low, high))
        return maps, replace(points, notes=(*points.notes, *said)), points.sha256
    odd = [key for key in options if key != "robot_radius"] + [
        key for key in reading if not is_bag(path) or key not in ("topic", "message")
    ]
    if odd:
        raise InputError(f"{path} is a grid map, with a resolution of its own; {odd[0]} does not go with it")
    frame = grid.frame
    content = f"{frame.x!r} {frame.y!r} {frame.resolution!r} {frame.rows} {frame.columns}\n".encode() + grid.states.tobytes()
    return maps_of_grid(grid, float(options.get("robot_radius", 0.0))), None, hashlib.sha256(content).hexdigest()


def _grid(path: Path, reading: Mapping[str, Any]) -> OccupancyGrid | None:
    """Grid map of a file, or None if it is a scan."""
    if path.suffix.lower() in GRID_ENDINGS:
        return read_grid(path)
    return read_bag_grid(path, reading.get("topic"), reading.get("message")) if is_bag(path) and path.exists() else None


def plan_candidates(scenario: Scenario) -> CandidateSet:
    """Build the maps of a scenario and plan the route to each candidate.

    Parameters
    ----------
    scenario : Scenario
        From `read_scenario`.

    Returns
    -------
    CandidateSet
        One route per candidate.

    Raises
    ------
    InputError
        If the start or a destination is not free (the nearest free cell is offered, not taken) or cannot be reached, or if the lengths
        differ by more than is allowed.
    """
    try:
        maps, points, digest = read_scan(scenario.path.parent / scenario.scan, scenario.reading, scenario.options)
        start = _cell(maps, points, scenario.start, "the start")
        found = flood(maps.free, start, corner_cutting=scenario.corner_cutting)
        goals = [
            _cell(maps, points, place, f"candidate {shown(label)}") for label, place in zip(scenario.labels, scenario.places, strict=True)
        ]
        candidates = tuple(_candidate(scenario, maps, found, index, goal) for index, goal in enumerate(goals))
        _equal(scenario, maps, found, goals, candidates)
    except InputError as error:
        raise InputError(f"{scenario.path}: {error}") from None
    return CandidateSet(scenario, maps, points, digest, maps.frame.centre(*start), candidates, points.notes if points else ())


def _cell(maps: Maps, points: Points | None, place: Place, what: str) -> Cell:
    """Cell of a place: that of a point, or the one of a room that is farthest from obstacles."""
    if place.room is not None:
        if points is None or place.room not in points.rooms:
            known = points.rooms if points is not None else ()
            raise InputError(f"{what} is in the room {shown(place.room)}, which the scan does not have; {nearest(place.room, known)}")
        inside = maps.free & (footprints(points, maps.frame) == points.rooms.index(place.room))
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
