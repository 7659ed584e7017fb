"""`fairaudit navigation office|maps|render|route`. Imports nothing heavy before it runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format
from fairaudit.errors import InputError
from fairaudit.files import write_atomically

DESCRIPTION = """\
From a scanned floor to the candidate routes that a decision maker is shown: a scan is read, its top view, traversability and topological
maps are built, and the shortest route to each candidate is planned and drawn. Needs the extra navigation."""
EPILOG = """\
exit codes: 0 done; 2 bad input

examples:
  fairaudit navigation office example                                an office to try, with scenario files
  fairaudit navigation render example/documents.toml                 its candidate routes as pictures
  fairaudit navigation maps scan.txt.gz --resolution 0.08 -o maps    the maps of any scan
  fairaudit navigation route example/documents-candidates/candidates.json HR2 -o route.csv"""


def add(commands: Any) -> None:
    """Declare the options."""
    from fairaudit.plugins.navigation import render

    parser = add_command(commands, "navigation", None, "maps and candidate routes of a scanned floor", DESCRIPTION, EPILOG)
    actions = parser.add_subparsers(metavar="ACTION", required=True, parser_class=type(parser))
    office = add_command(actions, "office", _office, "write a synthetic office, with scenario files", "")
    office.add_argument("folder", metavar="DIR", help="a new folder")
    maps = add_command(actions, "maps", _maps, "build the maps of a scan", "")
    maps.add_argument(
        "scan",
        metavar="SCAN",
        help="S3DIS folder, text (.txt, .xyz, .csv, .asc, also .gz), .ply, .pcd, .las, .laz, .e57, .npy, recording of ROS "
        "(.mcap, .db3, .bag, folder), map.yaml of ROS, or MovingAI .map",
    )
    maps.add_argument("-o", "--folder", metavar="DIR", required=True, help="where to write")
    for name, metavar, said in OPTIONS:
        maps.add_argument(f"--{name}", metavar=metavar, type=TYPES.get(metavar, str), help=said)
    maps.add_argument("--message", choices=("first", "last"), help="which of several messages of a recording")
    for name, key, said in SWITCHES:
        maps.add_argument(f"--{name}", dest=key, action="store_const", const=False, help=said)
    render.add(actions)
    route = add_command(actions, "route", _route, "export routes, for a robot to drive", "")
    route.add_argument("candidates", metavar="CANDIDATES.json", help="a candidate set that render wrote")
    route.add_argument("chosen", metavar="LABEL", nargs="?", help="label or index of the chosen candidate (default, for .geojson: all)")
    route.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        required=True,
        help=".csv or .json: x, y in metres, heading in radians; .path.yaml: nav_msgs/Path; .waypoints.yaml: waypoints of Nav2; "
        ".geojson: route graph of Nav2",
    )
    for action in (office, maps, route):
        add_format(action)


def numbers(text: str) -> list[float]:
    """Read numbers separated by commas."""
    return [float(word) for word in text.split(",")]


TYPES: dict[str, Callable[[str], Any]] = {"M": float, "PERCENT": int, "MASK": Path, "X,Y,X,Y": numbers, "LOW,HIGH": numbers}
OPTIONS = (
    ("columns", "NAMES", "what the columns of text or npy are, such as x,y,z,i,r,g,b; other names are left out"),
    ("topic", "NAME", "topic of a recording"),
    ("unit", "UNIT", "unit of the coordinates: m, cm, mm or ft (default: m, or mm if that is likely)"),
    ("up", "AXIS", "which way is up: z, y, x, -z, -y or -x (default: z, or y if that is likely)"),
    ("resolution", "M", "side of a cell in metres (default 0.05)"),
    ("bounds", "X,Y,X,Y", "least x and y, greatest x and y, in metres"),
    ("band", "LOW,HIGH", "heights of traversable ground above the floor (default -0.15,0.15)"),
    ("floor", "M", "z of the floor (default: found)"),
    ("ceiling", "M", "height above the floor from which unlabelled points are the ceiling (default 2)"),
    ("clearance", "M", "height up to which the way must be clear (default 1.5)"),
    ("robot-radius", "M", "radius of the robot (default 0)"),
    ("keepout", "MASK", "a map.yaml whose occupied cells are not to be entered"),
    ("room-names", "FILE", "lines x,y,name: names of rooms that are not labelled, each by a point in it (default: room 1, room 2 …)"),
    ("free-below", "PERCENT", "occupancy below which cells of a map are free (default 1, of a recording 20)"),
)


SWITCHES = (
    ("no-level", "level", "do not level a leaning floor"),
    ("keep-stray", "stray", "do not remove points that have hardly any others around them"),
)


def _answer(action: str, result: dict[str, Any], lines: Iterable[str], sentence: str) -> Answer:
    from fairaudit.words import plain

    text = "\n".join(map(plain, lines))
    return Answer("navigation", sentence=sentence, result=lambda: {"action": action, **result}, text=lambda: text)


def _office(arguments: argparse.Namespace) -> Answer:
    from importlib.resources import files

    from fairaudit.plugins.navigation.office import write_office

    folder = Path(arguments.folder)
    count = write_office(folder / "area")
    said = f"{count:,} points: {folder / 'area'}"
    examples = []
    for example in sorted(files("fairaudit.plugins.navigation").joinpath("examples").iterdir(), key=lambda entry: entry.name):
        examples.append(folder / example.name)
        write_atomically(examples[-1], [example.read_bytes()])
    result = {"points": count, "area": folder / "area", "examples": examples}
    return _answer("office", result, [said, *(f"example: {path}" for path in examples)], f"{said}.")


def _maps(arguments: argparse.Namespace) -> Answer:
    from dataclasses import asdict

    from fairaudit.plugins.navigation.render import draw_maps
    from fairaudit.plugins.navigation.rooms import rooms_of
    from fairaudit.plugins.navigation.scenario import KEYS, read_scan
    from fairaudit.words import plain

    reading, options = (
        {name: value for name in KEYS[section] if (value := getattr(arguments, name, None)) is not None} for section in ("scan", "map")
    )
    if "columns" in reading:
        reading["columns"] = tuple(name.strip() for name in arguments.columns.split(","))
    for name in {"bounds", "band"} & options.keys():
        options[name] = KEYS["map"][name](options[name], f"value of --{name}")
    if sys.stderr.isatty():
        print(f"reading {plain(arguments.scan)} …", file=sys.stderr)
    maps, points, _, notes = read_scan(Path(arguments.scan), reading, options)
    rooms, said = rooms_of(maps, points, arguments.room_names)
    draw_maps(maps, rooms, Path(arguments.folder))
    frame, lines = maps.frame, [f"note: {note}" for note in (*notes, *said)]
    if points is not None:
        where = f" in {len(points.rooms)} rooms" if points.rooms else ""
        lines.append(f"{len(points):,} points{where}, floor at z = {maps.floor:g} m")
    size = f"{frame.rows} × {frame.columns} cells of {frame.resolution:g} m from ({frame.x:g}, {frame.y:g})"
    size += (f", turned by {frame.yaw:g}" if frame.yaw else "") + f", {int(maps.free.sum()):,} of them traversable"
    result = {
        "folder": arguments.folder,
        "points": None if points is None else len(points),
        "notes": [*notes, *said],
        "frame": asdict(frame),
        "traversable": int(maps.free.sum()),
    }
    return _answer("maps", result, [*lines, size, f"maps: {arguments.folder}"], f"{size}.")


def _route(arguments: argparse.Namespace) -> Answer:
    from fairaudit.plugins.navigation.exports import ENDINGS, read_candidates

    output = Path(arguments.output)
    ending = next((ending for ending in ENDINGS if output.name.lower().endswith(ending)), None)
    if ending is None:
        raise InputError(f"{output}: a route ends in {', '.join(ENDINGS)}")
    routes = read_candidates(Path(arguments.candidates), arguments.chosen)
    if len(routes) > 1 and ending != ".geojson":
        raise InputError(f"{output} holds one route; name a candidate, such as {routes[0].label}")
    write_atomically(output, [ENDINGS[ending](routes).encode()])
    listed, poses = ", ".join(route.label for route in routes), sum(len(route.points) for route in routes)
    said = f"oute{'s' if len(routes) > 1 else ''} to {listed}, {poses} poses: {output}"
    result = {"label": listed, "length": sum(route.length for route in routes), "poses": poses, "output": output}
    return _answer("route", result, [f"r{said}"], f"R{said}.")
