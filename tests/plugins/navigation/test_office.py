"""The synthetic office end to end: what the maps say is what the floor plan says."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pytest
import tiers
from offices import Plan, hr_office, random_office, write_office

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.maps import rasterise
from fairaudit.plugins.navigation.office import write_office as write_example
from fairaudit.plugins.navigation.readers import CLASSES, read_points
from fairaudit.plugins.navigation.routes import flood

networkx = pytest.importorskip("networkx")
from fairaudit.plugins.navigation.rooms import topology, topology_json  # noqa: E402

PLANS = 50 if tiers.FULL else 8


def truth(plan: Plan) -> networkx.Graph:
    graph = networkx.Graph()
    graph.add_nodes_from(room.name for room in plan.rooms)
    graph.add_edges_from(tuple(edge) for edge in plan.edges)
    return graph


def test_the_office_that_is_drawn_in_signs_is_the_fixed_plan(tmp_path: Path) -> None:
    """The rooms, doors and furniture of a plan in numbers, at their places; the same points each time."""
    plan = hr_office()
    count = write_example(tmp_path / "area")
    points = read_points(tmp_path / "area")
    assert len(points) == count and all(part.kind for part in points.parts)
    graph = topology(points)
    assert set(graph.nodes) == {room.name for room in plan.rooms} and {frozenset(edge) for edge in graph.edges} == plan.edges
    for pair, x, y in ((frozenset(edge), *door["at"]) for *edge, doors in graph.edges(data="doors") for door in doors):
        assert any(pair == frozenset(door.rooms) and (x, y) == pytest.approx(door.at, abs=0.11) for door in plan.doors)
    maps = rasterise(points, 0.1)
    for thing in plan.things:
        cell = maps.frame.cell((thing.box[0] + thing.box[2]) / 2, (thing.box[1] + thing.box[3]) / 2)
        assert not maps.free[cell] and maps.height[cell] == pytest.approx(thing.height, abs=0.001)
    for room in plan.rooms:
        assert 0.6 < sum(maps.free[cell] for cell in _cells(maps, room.box)) / len(_cells(maps, room.box)) <= 1.0
    write_example(tmp_path / "again")
    assert read_points(tmp_path / "again").sha256 == points.sha256
    with pytest.raises(InputError, match="is not empty"):
        write_example(tmp_path / "again")


@pytest.mark.parametrize("seed", [None, *range(PLANS)])
def test_rooms_doors_and_ways_are_those_of_the_plan(seed: int | None, tmp_path: Path) -> None:
    """Rooms, doors with their places, outer doors; and a robot gets from room to room exactly where doors lead."""
    plan = hr_office() if seed is None else random_office(seed)
    count = write_office(plan, tmp_path / "area", spacing=0.08, seed=seed or 0)
    points = read_points(tmp_path / "area")
    assert len(points) == count and all(part.kind for part in points.parts) and {part.kind for part in points.parts} <= set(CLASSES)
    graph = topology(points)
    expected = truth(plan)
    assert set(graph.nodes) == set(expected.nodes)
    assert {frozenset(edge) for edge in graph.edges} == plan.edges
    found = sorted((frozenset(edge[:2]), *door["at"]) for *edge, doors in graph.edges(data="doors") for door in doors)
    inner = [door for door in plan.doors if door.rooms[1]]
    assert len(found) == len(inner)
    for door in inner:
        places = [(x, y) for pair, x, y in found if pair == frozenset(door.rooms)]
        assert min(max(abs(x - door.at[0]), abs(y - door.at[1])) for x, y in places) < (0.7 if door.standing_open else 0.05)
    outer = [door for door in plan.doors if not door.rooms[1]]
    assert sorted(room for room, exits in graph.nodes(data="exits") for _ in exits) == sorted(door.rooms[0] for door in outer)

    maps = rasterise(points, 0.1, robot_radius=0.05)
    cells = {}
    for room in plan.rooms:
        inside = _cells(maps, room.box)
        cells[room.name] = next(cell for cell in inside[len(inside) // 2 :] if maps.free[cell])
    reached = {room: flood(maps.free, cell).reached for room, cell in cells.items()}
    for one, other in combinations(cells, 2):
        assert reached[one][cells[other]] == networkx.has_path(expected, one, other), (one, other)


def _cells(maps, box):
    (bottom, left), (top, right) = maps.frame.cell(box[0] + 0.1, box[1] + 0.1), maps.frame.cell(box[2] - 0.1, box[3] - 0.1)
    return [(r, c) for r in range(top, bottom + 1) for c in range(left, right + 1)]


def test_furniture_is_where_the_plan_has_it(tmp_path: Path) -> None:
    plan = hr_office()
    write_office(plan, tmp_path / "area", spacing=0.08)
    maps = rasterise(read_points(tmp_path / "area"), 0.1)
    for thing in plan.things:
        x, y = (thing.box[0] + thing.box[2]) / 2, (thing.box[1] + thing.box[3]) / 2
        cell = maps.frame.cell(x, y)
        assert not maps.free[cell] and maps.height[cell] == pytest.approx(thing.height, abs=0.001)
    for room in plan.rooms:
        share = sum(maps.free[cell] for cell in _cells(maps, room.box)) / len(_cells(maps, room.box))
        assert 0.6 < share <= 1.0


def test_topology_as_json_can_be_read_by_networkx(tmp_path: Path) -> None:
    import json

    write_office(hr_office(), tmp_path / "area", spacing=0.1)
    graph = topology(read_points(tmp_path / "area"))
    document = json.loads(json.dumps(topology_json(graph)))
    again = networkx.node_link_graph({**document, "directed": False, "multigraph": False, "graph": {}}, edges="edges")
    assert networkx.utils.graphs_equal(graph, again)
    assert graph.nodes["office_1"]["kind"] == "office" and graph.nodes["office_1"]["area"] == pytest.approx(3.8 * 3.6, rel=0.08)


def test_equal_seeds_give_equal_files(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_office(random_office(3), tmp_path / name, spacing=0.2, seed=7)
    assert read_points(tmp_path / "a").sha256 == read_points(tmp_path / "b").sha256


def test_whole_room_file_holds_the_annotated_points(tmp_path: Path) -> None:
    write_office(hr_office(), tmp_path / "area", spacing=0.2)
    room = tmp_path / "area" / "office_1"
    whole = sorted((room / "office_1.txt").read_text().splitlines())
    assert whole == sorted(line for file in (room / "Annotations").iterdir() for line in file.read_text().splitlines())


def test_folder_that_is_not_empty_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="is not empty"):
        write_office(hr_office(), tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["mine.txt"]


def test_scan_without_rooms_has_no_topology(tmp_path: Path) -> None:
    (tmp_path / "scan.txt").write_text("0 0 0\n1 1 1\n")
    with pytest.raises(InputError, match="has no rooms"):
        topology(read_points(tmp_path / "scan.txt"))
