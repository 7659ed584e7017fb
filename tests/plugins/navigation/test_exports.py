"""Routes and maps as robots are given them, read back by readers that know nothing of this project."""

from __future__ import annotations

import csv
import json
import re
from itertools import pairwise
from math import atan2, cos, hypot, pi, remainder, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.navigation.exports import read_candidates
from fairaudit.plugins.navigation.grids import Frame, OccupancyGrid, read_grid, write_ros_map
from fairaudit.plugins.navigation.render import render
from fairaudit.plugins.navigation.scenario import plan_candidates, read_scenario

yaml, networkx = pytest.importorskip("yaml"), pytest.importorskip("networkx")
pytest.importorskip("PIL")

WALLS = ["##############", "#......#.....#", "#......#.....#", "#............#", "#......#.....#", "#......#.....#", "##############"]
START, GOALS = (0.6, 0.6), {"far": (2.9, 1.4), "near": (1.1, 1.4), "2": (3.1, 0.4)}


def place(x: float, y: float, yaw: float) -> tuple[float, float]:
    """A point of the level map where the map is turned about its corner at (3, -2)."""
    return 3.0 + cos(yaw) * x - sin(yaw) * y, -2.0 + sin(yaw) * x + cos(yaw) * y


def planned(folder: Path, yaw: float, more: str = "") -> Path:
    """A candidate set on a map of two rooms, turned."""
    states = np.where(np.array([list(row) for row in WALLS]) == "#", 100, 0).astype(np.int8)
    write_ros_map(OccupancyGrid(Frame(3.0, -2.0, 0.25, 7, 14, yaw), states), folder / "hall.yaml")
    text = f'[scan]\npath = "hall.yaml"\n[start]\nat = {list(place(*START, yaw))}\n[map]\n{more}\n'
    text += "".join(f'[[candidate]]\nlabel = "{label}"\nat = {list(place(*at, yaw))}\n' for label, at in GOALS.items())
    (folder / "s.toml").write_text(text)
    render(plan_candidates(read_scenario(folder / "s.toml")), folder / "out")
    return folder / "out" / "candidates.json"


def exported(source: Path, label: str, ending: str) -> str:
    output = source.parent / f"route{ending}"
    assert main(["navigation", "route", str(source), *[label] * bool(label), "-o", str(output)]) == 0
    return output.read_text()


@pytest.mark.parametrize("yaw", [0.5, -2.0, pi / 2])
def test_routes_on_a_turned_map_are_the_routes_turned(tmp_path: Path, yaw: float) -> None:
    """Equal lengths and turns; and the map that is written has the yaw."""
    (tmp_path / "level").mkdir()
    level, turned = (json.loads(planned(*where).read_text()) for where in ((tmp_path / "level", 0.0), (tmp_path, yaw)))
    assert turned["frame"] == {**level["frame"], "yaw": yaw}
    for one, other in zip(level["candidates"], turned["candidates"], strict=True):
        assert (one["length"], one["steps"]) == (other["length"], other["steps"])
        assert one["pixels_sha256"] == other["pixels_sha256"]
        for (x, y), point in zip(one["waypoints"], other["waypoints"], strict=True):
            assert point == pytest.approx(place(x - 3.0, y + 2.0, yaw), abs=2e-4)
    written, source = read_grid(tmp_path / "out" / "map.yaml"), read_grid(tmp_path / "hall.yaml")
    assert written.frame == source.frame and (written.free == source.free).all()


def test_tables_of_a_route(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = planned(tmp_path, 0.0)
    rows = list(csv.reader(exported(source, "far", ".csv").splitlines()))
    assert rows[0] == ["x", "y", "heading"]
    assert [[float(x), float(y)] for x, y, _ in rows[1:]] == json.loads(source.read_text())["candidates"][0]["waypoints"]
    poses = json.loads(exported(source, "1", ".json"))["poses"]
    assert [[repr(v) for v in pose] for pose in poses] == rows[1:]
    assert poses[-1][2] == poses[-2][2] and "route to far, 5 poses" in capsys.readouterr().out


def message(store: Any, kind: str, value: dict[str, Any]) -> Any:
    """A message of a library from what a file says; fields that it does not name are those of an empty time, as in ROS."""
    if kind == "builtin_interfaces/msg/Time":
        return store.types[kind](**{"sec": 0, "nanosec": 0, **value})
    given = {}
    for name, (form, what) in store.fielddefs[kind][1]:
        held = value.get(name, {}) if name == "stamp" else value[name]
        kinds = {"NAME": lambda held, what=what: message(store, what, held), "BASE": lambda held: held}
        kinds["SEQUENCE"] = lambda held, what=what: [message(store, what[0][1], entry) for entry in held]
        given[name] = kinds[form.name](held)
    assert set(value) <= set(given)
    return store.types[kind](**given)


@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_paths_are_messages_of_ros(tmp_path: Path, yaw: float) -> None:
    """They fit nav_msgs/Path as a library defines it, to its bytes and back; poses are a cell apart at most, and each faces the next."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.LATEST)
    source = planned(tmp_path, yaw)
    path = message(store, "nav_msgs/msg/Path", yaml.safe_load(exported(source, "far", ".path.yaml")))
    again = store.deserialize_cdr(store.serialize_cdr(path, "nav_msgs/msg/Path"), "nav_msgs/msg/Path")
    assert again == path and path.header.frame_id == "map" == path.poses[-1].header.frame_id
    ends = json.loads(source.read_text())["candidates"][0]["waypoints"]
    poses = [(each.pose.position.x, each.pose.position.y, each.pose.orientation) for each in path.poses]
    assert list(poses[0][:2]) == ends[0] and list(poses[-1][:2]) == ends[-1] and len(poses) > len(ends)
    assert {tuple(point) for point in ends} <= {(x, y) for x, y, _ in poses}
    for (x, y, turn), (a, b, _) in pairwise(poses):
        assert 0 < hypot(a - x, b - y) < 0.2502
        assert remainder(2 * atan2(turn.z, turn.w) - atan2(b - y, a - x), 2 * pi) == pytest.approx(0, abs=1e-5)
        assert turn.x == turn.y == 0.0 and hypot(turn.z, turn.w) == pytest.approx(1, abs=1e-8)


def test_waypoints_are_those_that_nav2_loads(tmp_path: Path) -> None:
    source = planned(tmp_path, 0.5)
    listed = yaml.safe_load(exported(source, "far", ".waypoints.yaml"))["waypoints"]
    ends = json.loads(source.read_text())["candidates"][0]["waypoints"]
    assert list(listed) == [f"waypoint{number}" for number in range(len(ends) - 1)]
    for (x, y), waypoint in zip(ends[1:], listed.values(), strict=True):
        assert waypoint["pose"] == [x, y, 0.0]
        w, zero, none, z = waypoint["orientation"]
        assert zero == none == 0.0 and hypot(w, z) == pytest.approx(1, abs=1e-8)


@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_a_route_graph_leads_to_every_candidate_by_its_length(tmp_path: Path, yaw: float) -> None:
    """Read as the route server of Nav2 does: points first, then edges between their ids; searched by another library."""
    source = planned(tmp_path, yaw)
    document = json.loads(exported(source, "", ".geojson"))
    nodes = [each for each in document["features"] if each["geometry"]["type"] == "Point"]
    edges = [each for each in document["features"] if each["geometry"]["type"] == "MultiLineString"]
    ids = [each["properties"]["id"] for each in (*nodes, *edges)]
    assert sorted(ids) == list(range(len(ids))) and {each["properties"]["frame"] for each in nodes} == {"map"}
    at = {each["properties"]["id"]: each["geometry"]["coordinates"] for each in nodes}
    graph = networkx.DiGraph()
    for each in edges:
        said = each["properties"]
        ((first, last),) = each["geometry"]["coordinates"]
        assert (first, last) == (at[said["startid"]], at[said["endid"]])
        graph.add_edge(tuple(first), tuple(last), weight=said["cost"])
    assert all(graph.has_edge(b, a) for a, b in graph.edges)
    candidates = json.loads(source.read_text())
    for candidate in candidates["candidates"]:
        length = networkx.shortest_path_length(graph, tuple(candidates["start"]), tuple(candidate["waypoints"][-1]), "weight")
        assert length == pytest.approx(candidate["length"], abs=1e-3)
    assert len(json.loads(exported(source, "near", ".geojson"))["features"]) < len(document["features"])


def test_a_keepout_mask_closes_a_way(tmp_path: Path) -> None:
    """The door between the rooms shut by a mask of other cells: no route, and one round it where the mask leaves a gap."""
    open_way = json.loads(planned(tmp_path, 0.5).read_text())["candidates"][0]["length"]
    x, y = place(7 * 0.25, 0.25, 0.5)
    states = np.full((12, 2), 100, np.int8)
    write_ros_map(OccupancyGrid(Frame(x, y, 0.12, 12, 2, 0.5), states), tmp_path / "shut.yaml")
    with pytest.raises(InputError, match="there is no route from the start to candidate 'far'"):
        planned(tmp_path, 0.5, 'keepout = "shut.yaml"')
    states[:] = 0
    states[0] = 40
    write_ros_map(OccupancyGrid(Frame(x, y, 0.12, 12, 2, 0.5), states), tmp_path / "open.yaml")
    document = json.loads(planned(tmp_path, 0.5, 'keepout = "open.yaml"').read_text())
    assert document["candidates"][0]["length"] == open_way
    (note,) = [note for note in document["scan"]["notes"] if "keepout" in note]
    assert re.fullmatch(r"the keepout mask open.yaml shuts 0 cells \(SHA-256 of its cells [0-9a-f]{64}\)", note)
    with pytest.raises(InputError, match=r"none.yaml: there is no such file"):
        planned(tmp_path, 0.5, 'keepout = "none.yaml"')


def test_what_cannot_be_exported_is_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = planned(tmp_path, 0.0)
    whole = json.loads(source.read_text())
    files = {"cut.json": source.read_text()[:200], "other.json": '{"format": "else"}', "list.json": "[]"}
    for name, points in (("none", []), ("words", "none"), ("nan", [[1, float("nan")]])):
        files[f"{name}-at.json"] = json.dumps({**whole, "candidates": [{**whole["candidates"][0], "waypoints": points}]})
    files["empty.json"] = json.dumps({**whole, "candidates": []})
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(InputError, match=rf"{name}: (this is not a candidate set|the format is 'else')"):
            read_candidates(tmp_path / name)
    (tmp_path / "here.json").write_text(json.dumps({**whole, "candidates": [{**whole["candidates"][0], "waypoints": [[1, 2]]}]}))
    for words, said in (
        (f"{source} fax -o {tmp_path}/r.csv", "did you mean 'far'"),
        (f"{source} far -o {tmp_path}/r.txt", "ends in .csv, .json, .path.yaml, .waypoints.yaml, .geojson"),
        (f"{source} far -o {tmp_path}/r.yaml", "ends in .csv"),
        (f"{source} -o {tmp_path}/r.csv", "holds one route; name a candidate, such as far"),
        (f"{tmp_path}/none.json far -o {tmp_path}/r.csv", "no such file"),
        (f"{tmp_path}/here.json -o {tmp_path}/r.geojson", "a route graph needs an edge"),
    ):
        assert main(["navigation", "route", *words.split()]) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1
    assert not list(tmp_path.glob("r.*"))
