"""The topological map as a picture: nodes, doors and the route are where they should be, from the command and from a scenario."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skimage")
from PIL import Image

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, Frame, OccupancyGrid, write_ros_map
from fairaudit.plugins.navigation.maps import maps_of_grid
from fairaudit.plugins.navigation.prompts import RED, draw_topology, rooms_on
from fairaudit.plugins.navigation.rooms import rooms_of
from fairaudit.plugins.navigation.routes import flood
from fairaudit.plugins.navigation.scenario import plan_candidates, read_scenario


def three(cell: float = 0.1) -> OccupancyGrid:
    """Three rooms in a row; the first door is at (2.5, 1.5), the second at (5.6, 2.4)."""
    free = np.zeros((40, 90), bool)
    free[5:35, 5:24] = free[5:35, 26:55] = free[5:35, 57:85] = free[20:29, 24:26] = free[11:20, 55:57] = True
    return OccupancyGrid(Frame(0.0, 0.0, cell, 40, 90), np.where(free, FREE, OCCUPIED).astype(np.int8))


def test_route_is_red_on_its_doors_and_nowhere_else() -> None:
    maps = maps_of_grid(three(), 0.2)
    rooms, (said,) = rooms_of(maps, None)
    assert rooms is not None
    assert said == "rooms are not labelled; found: 3, and doors between them: 2"
    route = flood(maps.free, maps.frame.cell(1.0, 1.0)).route(maps.frame.cell(4.0, 1.0))
    assert [room for room, _ in rooms_on(route, rooms)] == [0, 1]
    picture = draw_topology(maps, rooms, route)
    assert {label.text for label in picture.labels} == set(rooms.names)
    pixels = np.asarray(Image.open(io.BytesIO(picture.png)))
    assert draw_topology(maps, rooms, route).png == picture.png

    def at(x: float, y: float) -> tuple[int, ...]:
        row, column = maps.frame.cell(x, y)
        return tuple(pixels[picture.top + int((row + 0.5) * picture.scale), picture.left + int((column + 0.5) * picture.scale)].tolist())

    doors = [door["at"] for *_, edge in rooms.graph.edges(data=True) for door in edge["doors"]]
    assert [at(*door) == RED for door in doors] == [True, False]
    assert at(*rooms.graph.nodes["room 2"]["at"]) == RED  # the star
    assert at(*rooms.graph.nodes["room 3"]["at"]) != RED
    alone = np.asarray(Image.open(io.BytesIO(draw_topology(maps, rooms).png)))
    assert not (alone == RED).all(axis=2).any()


def test_labels_overlap_neither_each_other_nor_the_frame() -> None:
    maps = maps_of_grid(three())
    rooms, _ = rooms_of(maps, None)
    assert rooms is not None
    picture = draw_topology(maps, rooms)
    boxes = [(*label.corner, label.corner[0] + label.size[0], label.corner[1] + label.size[1]) for label in picture.labels]
    for number, (left, top, right, bottom) in enumerate(boxes):
        assert 0 <= left < right <= picture.width
        assert 0 <= top < bottom <= picture.height
        assert not any(left < r and x < right and top < b and y < bottom for x, y, r, b in boxes[:number])
    with pytest.raises(InputError, match="larger than 16384"):
        draw_topology(maps, rooms, scale=1000)


def test_found_rooms_of_a_map_in_commands_and_scenarios(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_ros_map(three(), tmp_path / "floor.yaml")
    (tmp_path / "names.csv").write_text("1,1,lobby\n7,1,office\n")
    words = ["navigation", "maps", str(tmp_path / "floor.yaml"), "-o", str(tmp_path / "maps")]
    assert main([*words, "--room-names", str(tmp_path / "names.csv")]) == 0
    assert "found: 3, and doors between them: 2" in capsys.readouterr().out
    assert '"id": "office"' in (tmp_path / "maps" / "topology.json").read_text()
    assert (tmp_path / "maps" / "topology.png").exists()
    scenario = tmp_path / "scenario.toml"
    text = '[scan]\npath = "floor.yaml"\n[map]\nroom_names = "names.csv"\nrobot_radius = 0.3\n[start]\nroom = "lobby"\n'
    scenario.write_text(text + '[[candidate]]\nlabel = "A"\nroom = "office"\n[[candidate]]\nlabel = "B"\nroom = "room 2"\n')
    found = plan_candidates(read_scenario(scenario))
    assert [candidate.place.room for candidate in found.candidates] == ["office", "room 2"]
    assert found.candidates[0].waypoints[-1][0] > 5.7
    assert main(["navigation", "render", str(scenario)]) == 0
    assert sorted(path.name for path in (tmp_path / "scenario-candidates").glob("topology*")) == [
        "topology-1.png", "topology-2.png", "topology.json", "topology.png",
    ]  # fmt: skip
    scenario.write_text(text + '[[candidate]]\nlabel = "A"\nroom = "room 1"\n')
    with pytest.raises(InputError, match=r"room 1.*which the scan does not have"):
        plan_candidates(read_scenario(scenario))


def test_maps_without_rooms_are_drawn_all_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_ros_map(three(1.0), tmp_path / "coarse.yaml")
    words = ["navigation", "maps", str(tmp_path / "coarse.yaml"), "-o", str(tmp_path / "maps")]
    assert main(words) == 0
    assert "note: no rooms: cells of 1 m are too coarse" in capsys.readouterr().out
    assert not (tmp_path / "maps" / "topology.json").exists()
    (tmp_path / "names.csv").write_text("1,1,lobby\n")
    assert main([*words, "--room-names", str(tmp_path / "names.csv")]) == 2
