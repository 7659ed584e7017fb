"""Routes of a candidate set for robots: as tables, as `nav_msgs/Path` and waypoints of ROS, and as the route graph of Nav2."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, ceil, cos, hypot, isfinite, sin
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.files import csv_text, read_bytes
from fairaudit.libraries import library

FORMAT = "fairaudit-candidates/1"
MAP = "map"
"""The coordinate frame of ROS that waypoints are in: that of map.yaml, its origin and yaw applied."""


@dataclass(frozen=True)
class Drive:
    """A route that a candidate set holds: points in metres, and the side of a cell of its map."""

    label: str
    length: float
    points: tuple[tuple[float, float], ...]
    resolution: float

    @property
    def poses(self) -> list[tuple[float, float, float]]:
        """Points with headings in radians, each towards the next; the last keeps that of the one before it."""
        headings = [round(atan2(b[1] - a[1], b[0] - a[0]), 6) for a, b in pairwise(self.points)] or [0.0]
        return [(x, y, heading) for (x, y), heading in zip(self.points, [*headings, *headings[-1:]], strict=False)]

    def dense(self) -> Drive:
        """Return the same route with points at most a cell apart."""
        found = list(self.points[:1])
        for a, b in pairwise(self.points):
            count = ceil(hypot(b[0] - a[0], b[1] - a[1]) / self.resolution - 1e-3)
            shares = [step / count for step in range(1, count + 1)]
            found += [(round(a[0] + (b[0] - a[0]) * share, 4), round(a[1] + (b[1] - a[1]) * share, 4)) for share in shares]
        return Drive(self.label, self.length, tuple(found), self.resolution)


def read_candidates(path: Path, chosen: str | None = None) -> list[Drive]:
    """Read the routes of a candidate set: all, or that to one candidate, by label or index."""
    try:
        document = json.loads(read_bytes(path))
        if document["format"] != FORMAT:
            raise InputError(f"{path}: the format is {shown(document['format'])}; {FORMAT} is accepted")
        side = float(document["frame"]["resolution"])
        drives, by_name = [], {}
        for entry in document["candidates"]:
            points = tuple((float(x), float(y)) for x, y in entry["waypoints"])
            if not (points and side > 0 and all(map(isfinite, (side, *sum(points, ()))))):
                raise ValueError
            drives.append(Drive(str(entry["label"]), float(entry["length"]), points, side))
            by_name.update({str(entry["index"]): drives[-1], drives[-1].label: drives[-1]})
        if chosen is not None and chosen not in by_name:
            raise InputError(f"{path} has no candidate {shown(chosen)}; {nearest(chosen, by_name)}")
        if not drives:
            raise ValueError
        return drives if chosen is None else [by_name[chosen]]
    except InputError:
        raise
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise InputError(f"{path}: this is not a candidate set; candidates.json of fairaudit navigation render was expected") from None


def _csv(drives: list[Drive]) -> str:
    return csv_text([("x", "y", "heading"), *drives[0].poses])


def _json(drives: list[Drive]) -> str:
    document = {"label": drives[0].label, "length": drives[0].length, "poses": drives[0].poses}
    return json.dumps(document, ensure_ascii=False, indent=1) + "\n"


def _yaml(document: Any) -> str:
    yaml = library("yaml", "navigation")
    return str(yaml.safe_dump(document, sort_keys=False, allow_unicode=True, default_flow_style=None, width=1000))


def _turn(heading: float) -> tuple[float, float]:
    """Return z and w of the quaternion of a heading."""
    return round(sin(heading / 2), 9), round(cos(heading / 2), 9)


def _path(drives: list[Drive]) -> str:
    """One message, as `ros2 topic pub` reads it."""
    poses = []
    for x, y, heading in drives[0].dense().poses:
        z, w = _turn(heading)
        pose = {"position": {"x": x, "y": y, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": z, "w": w}}
        poses.append({"header": {"frame_id": MAP}, "pose": pose})
    return _yaml({"header": {"frame_id": MAP}, "poses": poses})


def _waypoints(drives: list[Drive]) -> str:
    """Return waypoints after the start, as the panel of Nav2 in RViz loads them: the orientation is w, x, y, z."""
    listed = {}
    for number, (x, y, heading) in enumerate(drives[0].poses[1:] or drives[0].poses):
        z, w = _turn(heading)
        listed[f"waypoint{number}"] = {"pose": [x, y, 0.0], "orientation": [w, 0.0, 0.0, z]}
    return _yaml({"waypoints": listed})


def _graph(drives: list[Drive]) -> str:
    """Nodes where routes start, turn and end; an edge in each direction, whose cost is its length."""
    nodes = list(dict.fromkeys(point for drive in drives for point in drive.points))
    pairs = dict.fromkeys(pair for drive in drives for a, b in pairwise(drive.points) for pair in ((a, b), (b, a)))
    if not pairs:
        raise InputError("no candidate is away from the start; a route graph needs an edge")
    features: list[tuple[str, Any, dict[str, Any]]]
    features = [("Point", node, {"id": number, "frame": MAP}) for number, node in enumerate(nodes)]
    for number, (a, b) in enumerate(pairs, start=len(nodes)):
        said = {"id": number, "startid": nodes.index(a), "endid": nodes.index(b), "cost": round(hypot(b[0] - a[0], b[1] - a[1]), 4)}
        features.append(("MultiLineString", [[a, b]], said))
    listed = [{"type": "Feature", "properties": said, "geometry": {"type": kind, "coordinates": at}} for kind, at, said in features]
    return json.dumps({"type": "FeatureCollection", "name": "graph", "features": listed}, indent=1) + "\n"


ENDINGS: Mapping[str, Callable[[list[Drive]], str]] = {
    ".csv": _csv, ".json": _json, ".path.yaml": _path, ".waypoints.yaml": _waypoints, ".geojson": _graph,
}  # fmt: skip
"""What the name of a file ends in, and what it then holds."""
