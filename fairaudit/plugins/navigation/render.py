"""Draw what a scenario file describes: `fairaudit experiment render FILE`, also as `fairaudit navigation render FILE`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format
from fairaudit.errors import InputError
from fairaudit.files import write_atomically

if TYPE_CHECKING:
    from fairaudit.plugins.navigation.maps import Maps
    from fairaudit.plugins.navigation.rooms import Rooms
    from fairaudit.plugins.navigation.scenario import CandidateSet

DESCRIPTION = """\
Draw what a scenario file describes. It says which scan, start and candidates there are; the top view, the traversability map, one picture
per candidate with its route in red from a circle to a star and its index in the upper left corner, candidates.png with all of them, and
candidates.json with waypoints, lengths and digests are written into the folder that the file names (by default its own name and
-candidates)."""
EPILOG = """\
exit codes: 0 done; 2 bad input

examples:
  fairaudit navigation office example
  fairaudit experiment render example/documents.toml"""


def add(actions: Any) -> None:
    """Declare the options."""
    parser = add_command(actions, "render", run, "draw the candidate routes of a scenario file", DESCRIPTION, EPILOG)
    parser.add_argument("file", metavar="FILE", help="scenario file (.toml)")
    parser.add_argument("-o", "--folder", metavar="DIR", help="where to write, instead of the folder that the file names")
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.plugins.navigation.scenario import plan_candidates, read_scenario
    from fairaudit.words import plain

    scenario = read_scenario(arguments.file)
    found = plan_candidates(scenario)
    folder = Path(arguments.folder) if arguments.folder else scenario.path.parent / scenario.folder
    document = render(found, folder)
    lines = [scenario.title, *(f"note: {note}" for note in found.notes)]
    lines += [
        f"{c.index}  {c.place.label}: {c.length:.2f} m, {len(c.waypoints)} waypoints, {folder / picture_name(c.index)}"
        for c in found.candidates
    ]
    lines.append(f"candidate set: {folder / 'candidates.json'}")
    return Answer(
        "navigation",
        sentence=f"Candidate routes were drawn for {scenario.title}.",
        result=lambda: {"action": "render", "scenarios": [{"folder": folder, "candidate_set": document}]},
        text=lambda: "\n".join(map(plain, lines)),
    )


def picture_name(index: int) -> str:
    """Return the name of a candidate's picture."""
    return f"candidate-{index}.png"


def render(found: CandidateSet, folder: Path) -> dict[str, Any]:
    """Write pictures and candidate set of planned candidates into a folder, which is made if it is not there.

    Returns
    -------
    dict
        The candidate set, as ``candidates.json`` holds it. It is written last: where it is, the pictures are.
    """
    from dataclasses import asdict

    from fairaudit.plugins.navigation.exports import FORMAT
    from fairaudit.plugins.navigation.prompts import draw, draw_topology, view
    from fairaudit.plugins.navigation.routes import Route

    scenario, maps, rooms = found.scenario, found.maps, found.rooms
    draw_maps(maps, rooms, folder, scale=scenario.scale)
    part = view(maps, [candidate.route for candidate in found.candidates])
    shared: dict[str, Any] = {
        "routes": [Route(candidate.route.cells - [part[0].start, part[1].start]) for candidate in found.candidates],
        "names": [candidate.place.label for candidate in found.candidates],
        "rooms": (rooms.names, rooms.owner[part]) if rooms is not None else None,
        "resolution": maps.frame.resolution,
        "scale": scenario.scale,
    }
    write_atomically(folder / "candidates.png", [draw(maps.rgb[part], **shared).png])
    listed = []
    for candidate in found.candidates:
        picture = draw(maps.rgb[part], chosen=candidate.index - 1, **shared)
        write_atomically(folder / picture_name(candidate.index), [picture.png])
        if rooms is not None:
            diagram = draw_topology(maps, rooms, candidate.route, scale=scenario.scale)
            write_atomically(folder / f"topology-{candidate.index}.png", [diagram.png])
        listed.append(
            {
                "index": candidate.index,
                "label": candidate.place.label,
                "profile": candidate.place.profile,
                **({"room": candidate.place.room} if candidate.place.room else {}),
                "length": round(candidate.length, 4),
                "steps": {"straight": candidate.route.straight, "diagonal": candidate.route.diagonal},
                "waypoints": [list(point) for point in candidate.waypoints],
                "picture": picture_name(candidate.index),
                "picture_sha256": picture.sha256,
                "pixels_sha256": picture.pixels_sha256,
            }
        )
    document = {
        "format": FORMAT,
        "title": scenario.title,
        "scenario_sha256": scenario.sha256,
        "scan": {"path": scenario.scan.as_posix(), "sha256": found.scan_sha256, "notes": list(found.notes)},
        "frame": asdict(maps.frame),
        "view": {"row": part[0].start, "column": part[1].start, "left": picture.left, "top": picture.top, "scale": picture.scale},
        **({"context": scenario.context} if scenario.context else {}),
        "start": list(found.start),
        "candidates": listed,
    }
    _write_json(folder / "candidates.json", document)
    return document


def draw_maps(maps: Maps, rooms: Rooms | None, folder: Path, *, scale: int | None = None) -> None:
    """Write top view, traversability map (as a picture, and for ROS) and, where there are rooms, the topological map."""
    from fairaudit.plugins.navigation.grids import write_ros_map
    from fairaudit.plugins.navigation.maps import maps_of_grid
    from fairaudit.plugins.navigation.prompts import draw, draw_topology
    from fairaudit.plugins.navigation.rooms import topology_json

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be made: {error.strerror}") from None
    for name, rgb in (("top-view", maps.rgb), ("traversability", maps_of_grid(maps.grid).rgb)):
        write_atomically(folder / f"{name}.png", [draw(rgb, resolution=maps.frame.resolution, scale=scale).png])
    write_ros_map(maps.grid, folder / "map.yaml")
    if rooms is not None:
        _write_json(folder / "topology.json", topology_json(rooms.graph))
        write_atomically(folder / "topology.png", [draw_topology(maps, rooms, scale=scale).png])


def _write_json(path: Path, document: dict[str, Any]) -> None:
    write_atomically(path, [json.dumps(document, ensure_ascii=False, indent=1).encode(), b"\n"])
