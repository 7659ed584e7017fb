"""`fairaudit navigation office|maps|render|route`. Imports nothing heavy before it runs."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli.output import Answer, add_format

if TYPE_CHECKING:
    from collections.abc import Callable

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

    form = argparse.RawDescriptionHelpFormatter
    parser = commands.add_parser(
        "navigation",
        help="maps and candidate routes of a scanned floor",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=form,
        allow_abbrev=False,
    )
    actions = parser.add_subparsers(metavar="ACTION", required=True, parser_class=type(parser))
    office = actions.add_parser("office", help="write a synthetic office, with scenario files", allow_abbrev=False)
    office.set_defaults(run=_office)
    office.add_argument("folder", metavar="DIR", help="a new folder")
    office.add_argument(
        "--seed", metavar="N", type=int, help="a random floor plan instead of the one of the examples; without scenario files"
    )
    office.add_argument("--spacing", metavar="M", type=float, default=0.04, help="distance of neighbouring points in metres (default 0.04)")
    maps = actions.add_parser("maps", help="build the maps of a scan", allow_abbrev=False)
    maps.set_defaults(run=_maps)
    maps.add_argument(
        "scan",
        metavar="SCAN",
        help="S3DIS folder, text (.txt, .xyz, .csv, .asc, also .gz), .ply, .pcd, .las, .laz, .e57, .npy, recording of ROS "
        "(.mcap, .db3, .bag, folder), map.yaml of ROS, or MovingAI .map",
    )
    maps.add_argument("-o", "--folder", metavar="DIR", required=True, help="where to write")
    _add_reading(maps)
    _add_grid(maps)
    render.add(actions)
    route = actions.add_parser("route", help="export the route to the chosen candidate", allow_abbrev=False)
    route.set_defaults(run=_route)
    route.add_argument("candidates", metavar="CANDIDATES.json", help="a candidate set that render wrote")
    route.add_argument("chosen", metavar="LABEL", help="label or index of the chosen candidate")
    route.add_argument("-o", "--output", metavar="FILE", required=True, help="a .csv or .json file: x, y in metres, heading in radians")
    for action in (office, maps, route):
        add_format(action)


def _add_reading(maps: argparse.ArgumentParser) -> None:
    maps.add_argument(
        "--columns", metavar="NAMES", help="what the columns of text or npy are, such as x,y,z,i,r,g,b; other names are left out"
    )
    maps.add_argument("--topic", metavar="NAME", help="topic of a recording")
    maps.add_argument("--message", choices=("first", "last"), help="which of several messages of a recording")
    maps.add_argument("--unit", metavar="UNIT", help="unit of the coordinates: m, cm, mm or ft (default: m, or mm if that is likely)")
    maps.add_argument("--up", metavar="AXIS", help="which way is up: z, y, x, -z, -y or -x (default: z, or y if that is likely)")
    maps.add_argument("--no-level", action="store_true", help="do not level a leaning floor")
    maps.add_argument("--keep-stray", action="store_true", help="do not remove points that have hardly any others around them")


def _add_grid(maps: argparse.ArgumentParser) -> None:
    maps.add_argument("--resolution", metavar="M", type=float, help="side of a cell in metres (default 0.05)")
    maps.add_argument("--bounds", metavar="X,Y,X,Y", help="least x and y, greatest x and y, in metres")
    maps.add_argument("--band", metavar="LOW,HIGH", help="heights of traversable ground above the floor (default -0.15,0.15)")
    for name, said in (
        ("floor", "z of the floor (default: found)"),
        ("ceiling", "height above the floor from which unlabelled points are the ceiling (default 2)"),
        ("clearance", "height up to which the way must be clear (default 1.5)"),
        ("robot-radius", "radius of the robot (default 0)"),
    ):
        maps.add_argument(f"--{name}", metavar="M", type=float, help=said)


def _answer(action: str, result: dict[str, Any], text: Callable[[], str], sentence: str) -> Answer:
    return Answer("navigation", sentence=sentence, result=lambda: {"action": action, **result}, text=text)


def _office(arguments: argparse.Namespace) -> Answer:
    from importlib.resources import files

    from fairaudit.errors import InputError
    from fairaudit.files import write_atomically
    from fairaudit.plugins.navigation.office import hr_office, random_office, write_office
    from fairaudit.words import plain

    folder = Path(arguments.folder)
    if not 0.01 <= arguments.spacing <= 1:
        raise InputError(f"--spacing is {arguments.spacing}; 0.01 to 1 metre is accepted")
    if arguments.seed is not None and arguments.seed < 0:
        raise InputError(f"--seed is {arguments.seed}; an integer of at least 0 is accepted")
    plan = hr_office() if arguments.seed is None else random_office(arguments.seed)
    count = write_office(plan, folder / "area", spacing=arguments.spacing)
    said = f"{count:,} points, {len(plan.rooms)} rooms, {len(plan.doors)} doors: {folder / 'area'}"
    examples = []
    if arguments.seed is None:
        for example in sorted(files("fairaudit.plugins.navigation").joinpath("examples").iterdir(), key=lambda entry: entry.name):
            write_atomically(folder / example.name, [example.read_bytes()])
            examples.append(folder / example.name)
    result = {"points": count, "rooms": len(plan.rooms), "doors": len(plan.doors), "area": folder / "area", "examples": examples}
    return _answer("office", result, lambda: "\n".join(map(plain, [said, *(f"example: {path}" for path in examples)])), f"{said}.")


def _maps(arguments: argparse.Namespace) -> Answer:
    from fairaudit.plugins.navigation.render import draw_maps
    from fairaudit.plugins.navigation.scenario import read_scan
    from fairaudit.words import plain

    options: dict[str, Any] = {
        name: value
        for name in ("resolution", "floor", "ceiling", "clearance", "robot_radius")
        if (value := getattr(arguments, name)) is not None
    }
    for name, count in (("bounds", 4), ("band", 2)):
        text = getattr(arguments, name)
        if text is not None:
            options[name] = _list(text, name, count)
    if sys.stderr.isatty():
        print(f"reading {plain(arguments.scan)} …", file=sys.stderr)
    reading: dict[str, Any] = {
        name: value for name in ("topic", "message", "unit", "up") if (value := getattr(arguments, name)) is not None
    }
    if arguments.columns is not None:
        reading["columns"] = tuple(name.strip() for name in arguments.columns.split(","))
    reading.update({name: False for name, given in (("level", arguments.no_level), ("stray", arguments.keep_stray)) if given})
    maps, points, _ = read_scan(Path(arguments.scan), reading, options)
    draw_maps(maps, points, Path(arguments.folder))
    frame = maps.frame
    lines = [f"note: {note}" for note in (points.notes if points else ())]
    if points is not None:
        lines.append(
            f"{len(points):,} points" + (f" in {len(points.rooms)} rooms" if points.rooms else "") + f", floor at z = {maps.floor:g} m"
        )
    size = f"{frame.rows} × {frame.columns} cells of {frame.resolution:g} m from ({frame.x:g}, {frame.y:g})"
    lines.append(f"{size}, {int(maps.free.sum()):,} of them traversable")
    lines.append(f"maps: {arguments.folder}")
    result = {
        "folder": arguments.folder,
        "points": None if points is None else len(points),
        "notes": list(points.notes) if points else [],
        "frame": {"x": frame.x, "y": frame.y, "resolution": frame.resolution, "rows": frame.rows, "columns": frame.columns},
        "traversable": int(maps.free.sum()),
    }
    return _answer("maps", result, lambda: "\n".join(map(plain, lines)), f"{size}, {int(maps.free.sum()):,} of them traversable.")


def _list(text: str, name: str, count: int) -> tuple[float, ...]:
    from math import isfinite

    from fairaudit.errors import InputError, shown

    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        values = ()
    if len(values) != count or not all(isfinite(value) for value in values):
        raise InputError(f"--{name} is {shown(text)}; {count} numbers separated by commas are accepted")
    return values


def _route(arguments: argparse.Namespace) -> Answer:
    from itertools import pairwise
    from math import atan2

    from fairaudit.errors import InputError
    from fairaudit.files import write_atomically
    from fairaudit.words import plain

    candidate, points = _chosen(Path(arguments.candidates), arguments.chosen)
    headings = [atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)]
    poses = [(x, y, round(heading, 6)) for (x, y), heading in zip(points, [*headings, *headings[-1:]] or [0.0], strict=True)]
    output = Path(arguments.output)
    if output.suffix.lower() == ".csv":
        text = "x,y,heading\n" + "".join(f"{x!r},{y!r},{heading!r}\n" for x, y, heading in poses)
    elif output.suffix.lower() == ".json":
        text = json.dumps({"label": candidate["label"], "length": candidate["length"], "poses": poses}, ensure_ascii=False, indent=1) + "\n"
    else:
        raise InputError(f"{output}: a route ends in .csv or .json")
    write_atomically(output, [text.encode()])
    said = f"route to {candidate['label']}, {len(poses)} poses: {output}"
    result = {"label": candidate["label"], "length": candidate["length"], "poses": len(poses), "output": output}
    return _answer("route", result, lambda: plain(said), f"R{said[1:]}.")


def _chosen(path: Path, chosen: str) -> tuple[dict[str, Any], list[tuple[float, float]]]:
    """The chosen entry of a candidate set, and its waypoints."""
    from fairaudit.errors import InputError, nearest, shown
    from fairaudit.plugins.navigation.render import FORMAT

    try:
        document = json.loads(path.read_bytes())
        if document["format"] != FORMAT:
            raise InputError(f"{path}: the format is {shown(document['format'])}; {FORMAT} is accepted")
        by_name = {key: entry for entry in document["candidates"] for key in (str(entry["index"]), entry["label"])}
        if chosen not in by_name:
            raise InputError(f"{path} has no candidate {shown(chosen)}; {nearest(chosen, by_name)}")
        found = by_name[chosen]
        points = [(float(x), float(y)) for x, y in found["waypoints"]]
        if not points:
            raise KeyError("waypoints")
        return {"label": str(found["label"]), "length": float(found["length"])}, points
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: the file cannot be read: {error.strerror}") from None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise InputError(f"{path}: this is not a candidate set; candidates.json of fairaudit navigation render was expected") from None
