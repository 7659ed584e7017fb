"""Rooms and doors that nobody labelled: buildings whose truth is known, and maps that are none."""

from __future__ import annotations

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from buildings import building, scores
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.errors import InputError

pytest.importorskip("skimage")
from fairaudit.plugins.navigation.grids import Frame, read_grid
from fairaudit.plugins.navigation.rooms import Rooms, find_rooms, read_names

REPORTED = range(2000, 2050)  # never looked at while the rules were made


def doors_of(rooms: Rooms) -> list[dict[str, object]]:
    return [door for *_, edge in rooms.graph.edges(data=True) for door in edge["doors"]]


def test_rooms_and_doors_of_fifty_buildings() -> None:
    """Corridors, L-shaped rooms, open plans, furniture, noise, cells of 2.5 to 10 cm, walls at any angle."""
    total: Counter[str] = Counter()
    for seed in REPORTED:
        true = building(seed)
        rooms = find_rooms(true.grid.free, true.grid.frame)
        total.update(scores(true, rooms.owner.astype(np.int64), [door["at"] for door in doors_of(rooms)]))
    assert total["met"] >= 0.95 * total["rooms"], total
    assert total["close"] >= 0.95 * total["doors"], total
    assert total["met"] >= 0.9 * total["found"], total
    assert total["close"] >= 0.9 * total["listed"], total


TWO = np.zeros((40, 60), bool)  # cells of 10 cm; two rooms, a wall of 0.2 m, and in it a door of 0.9 m from y = 1.1 to 2
TWO[5:35, 5:24] = TWO[5:35, 26:55] = TWO[20:29, 24:26] = True


def test_width_and_place_of_a_door() -> None:
    rooms = find_rooms(TWO, Frame(0.0, 0.0, 0.1, *TWO.shape))
    (door,) = doors_of(rooms)
    assert rooms.names == ("room 1", "room 2")
    assert door["width"] == pytest.approx(0.9)
    assert door["at"] == pytest.approx([2.5, 1.55], abs=0.11)
    assert rooms.graph.nodes["room 1"]["area"] == pytest.approx(1.9 * 3, abs=0.2)


def test_a_wide_opening_is_no_door_and_a_wall_without_one_divides() -> None:
    free = TWO.copy()
    free[10:30, 24:26] = True
    assert find_rooms(free, Frame(0.0, 0.0, 0.1, *free.shape)).names == ("room 1",)
    free[:, 24:26] = False
    rooms = find_rooms(free, Frame(0.0, 0.0, 0.1, *free.shape))
    assert rooms.names == ("room 1", "room 2")
    assert doors_of(rooms) == []


@pytest.mark.parametrize(
    ("free", "cell", "said"),
    [
        (np.zeros((50, 50), bool), 0.05, "no free space of 1.5 m² or more"),
        (np.zeros((1, 1), bool), 0.05, "no free space"),
        (np.eye(60, dtype=bool), 0.05, "no free space"),
        (np.ones((50, 50), bool), 1.0, "cells of 1 m are too coarse"),
    ],
)
def test_maps_without_rooms(free: np.ndarray, cell: float, said: str) -> None:
    with pytest.raises(InputError, match=said):
        find_rooms(free, Frame(0.0, 0.0, cell, *free.shape))


def test_a_map_that_is_free_to_its_edges_is_one_room() -> None:
    rooms = find_rooms(np.ones((40, 70), bool), Frame(1.0, 2.0, 0.1, 40, 70))
    assert (rooms.owner == 0).all()
    assert rooms.graph.nodes["room 1"] == {"kind": "room", "at": [4.45, 4.05], "area": 28.0, "exits": []}


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 999), turns=st.integers(1, 3))
def test_a_map_turned_by_right_angles_has_as_many_rooms(seed: int, turns: int) -> None:
    """And equal input gives equal rooms."""
    true = building(seed % 40 + 3000)
    free = true.grid.free
    first, again = (find_rooms(free, true.grid.frame) for _ in range(2))
    assert (first.owner == again.owner).all()
    assert doors_of(first) == doors_of(again)
    if true.what.endswith("clutter 0.0, noise 0.0"):
        turned = np.rot90(free, turns)
        assert len(find_rooms(turned, Frame(0.0, 0.0, true.grid.frame.resolution, *turned.shape)).names) == len(first.names)


def test_names_of_rooms(tmp_path: Path) -> None:
    path = tmp_path / "names.csv"
    path.write_text("4,1,Küche\n\n", "utf-8")
    frame = Frame(0.0, 0.0, 0.1, *TWO.shape)
    rooms = find_rooms(TWO, frame, read_names(path))
    assert rooms.names == ("room 1", "Küche")
    assert rooms.graph.has_edge("room 1", "Küche")
    for line, said in (
        ("2.5,3,hall", "in no room that was found"),
        ("99,1,hall", "not on the map"),
        ("4,1,a\n4,2,b", "its room has two"),
        ("4,1,room 1", "number of another room"),
        ("4,1", "line 1: '4,1' is not x,y,name"),
        ("1,1,a\nx,y,b", "line 2"),
        ("nan,1,a", "line 1"),
    ):
        path.write_text(line, "utf-8")
        with pytest.raises(InputError, match=said):
            find_rooms(TWO, frame, read_names(path))
    with pytest.raises(InputError, match="no such file"):
        read_names(tmp_path / "none.csv")


def test_the_hall_of_pillars_is_one_room(data: Path, tmp_path: Path) -> None:
    """Nine pillars with 0.8 m between them, and a room each if they were walls."""
    shutil.copy(data / "maps" / "turtlebot3_map.pgm", tmp_path / "map.pgm")
    grid = read_grid(shutil.copy(data / "maps" / "turtlebot3_map.yaml", tmp_path))
    rooms = find_rooms(grid.free, grid.frame)
    assert len(rooms.names) == 1
    assert grid.free[rooms.owner == 0].sum() > 0.99 * grid.free.sum()
