"""Scans that lean, lie on their side, are in millimetres or hold stray points, against the same scan as it should be."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest
import tiers
from offices import random_office, write_office

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.ground import advice, prepare
from fairaudit.plugins.navigation.maps import rasterise
from fairaudit.plugins.navigation.readers import Part, Points, read_points


def cloud(xyz: np.ndarray) -> Points:
    return Points(xyz, np.full(xyz.shape, 128, np.uint8), (Part(0, len(xyz)),), {})


def turned(xyz: np.ndarray, degrees: float, towards: float) -> np.ndarray:
    """Rodrigues' formula, about a level axis."""
    a, k = radians(degrees), np.array([cos(towards), sin(towards), 0.0])
    across = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.asarray(xyz @ (np.eye(3) + sin(a) * across + (1 - cos(a)) * across @ across).T)


def spoiled(points: Points, degrees: float, seed: int) -> Points:
    """One point of clutter in the air for 200 of the scan, and a tilt."""
    random = np.random.default_rng(seed)
    low, high = points.xyz.min(axis=0) - 0.5, points.xyz.max(axis=0) + 0.5
    air = random.uniform(low, high, (len(points) // 200, 3))
    return cloud(turned(np.concatenate([points.xyz, air]), degrees, random.uniform(0, 2 * pi)))


def noisy(points: Points, seed: int) -> Points:
    return cloud(points.xyz + np.random.default_rng(seed).normal(0, 0.005, points.xyz.shape))


def area(points: Points, resolution: float) -> float:
    """Traversable area, over four places of the grid: where walls fall within cells is not what is asked."""
    shifts = [(0.0, 0.0), (0.25, 0.5), (0.5, 0.0), (0.75, 0.5)]
    moved = (replace(points, xyz=points.xyz + np.array([x * resolution, y * resolution, 0.0])) for x, y in shifts)
    return float(np.mean([rasterise(each, resolution).free.sum() * resolution**2 for each in moved]))


def office(folder: Path, seed: int, spacing: float) -> Points:
    write_office(random_office(seed), folder, spacing=spacing)
    return cloud(read_points(folder).xyz)


@pytest.mark.parametrize("seed", range(50 if tiers.FULL else 2))
def test_a_leaning_office_has_the_area_of_the_level_one(tmp_path: Path, seed: int) -> None:
    level = noisy(office(tmp_path / "area", seed, 0.05 if tiers.FULL else 0.08), seed)
    base = area(level, 0.1 if tiers.FULL else 0.16)
    for degrees in (0, 1, 3, 5, 8) if tiers.FULL else (0, 3, 8):
        found = prepare(spoiled(level, degrees, 10 * seed + degrees))
        assert area(found, 0.1 if tiers.FULL else 0.16) == pytest.approx(base, rel=0.03)
        assert any(f"leaned by {degrees}.0" in note or f"leaned by {degrees - 1}.9" in note for note in found.notes) == (degrees > 0)
        assert any("were removed" in note for note in found.notes)


def test_a_leaning_real_room_has_the_area_of_the_level_one(data: Path) -> None:
    level = noisy(read_points(data / "scans" / "room_scan1.txt.gz"), 0)
    base = area(prepare(level), 0.1)
    for degrees in (0, 1, 2, 3, 5, 8) if tiers.FULL else (0, 5, 8):
        assert area(prepare(spoiled(level, degrees, degrees)), 0.1) == pytest.approx(base, rel=0.03)


def test_a_clean_level_office_stays_as_it_is(tmp_path: Path) -> None:
    write_office(random_office(4), tmp_path / "area", spacing=0.1)
    points = read_points(tmp_path / "area")
    found = prepare(points)
    assert found.notes == points.notes and (found.xyz == points.xyz).all() and found.parts == points.parts


def test_labels_stay_with_their_points(tmp_path: Path) -> None:
    write_office(random_office(4), tmp_path / "area", spacing=0.1)
    points = read_points(tmp_path / "area")
    kind = {tuple(point): part.kind for part in points.parts for point in points.xyz[part.start : part.stop].tolist()}
    far = points.xyz.copy()
    lost = [part.start for part in points.parts[::5]]
    far[lost] += [0, 0, 20.0]
    found = prepare(replace(points, xyz=far))
    assert len(found) == len(points) - len(lost) and found.parts[-1].stop == len(found)
    for part in found.parts:
        assert {kind[tuple(point)] for point in found.xyz[part.start : part.stop].tolist()} <= {part.kind}
    leaning = prepare(replace(points, xyz=turned(points.xyz, 4, 1.0)))
    floors = np.concatenate([leaning.xyz[part.start : part.stop, 2] for part in leaning.parts if part.kind == "floor"])
    assert np.ptp(floors) < 1e-6


def test_unit_and_up_are_found_and_said(tmp_path: Path) -> None:
    points = office(tmp_path / "area", 3, 0.1)
    flat = points.xyz[:, [1, 2, 0]]  # y is up, and x, y, z still turn the same way
    found = prepare(cloud(flat * 1000))
    assert np.allclose(found.xyz, points.xyz, atol=1e-9)
    assert "taken for the millimetre" in found.notes[0] and "y was taken for up" in found.notes[1]
    assert (prepare(cloud(flat), up="z").xyz == flat).all()
    for up, order in (("z", [0, 1, 2]), ("x", [2, 0, 1])):
        assert np.allclose(prepare(cloud(points.xyz[:, order] / 0.3048), up=up, unit="ft", level=False).xyz, points.xyz)
    for axis in ("-x", "-y", "-z"):
        upside = prepare(cloud(points.xyz), up=axis, level=False, stray=False).xyz
        assert (upside[:, 2] == -points.xyz[:, "xyz".index(axis[1])]).all()
        assert np.linalg.det(np.linalg.lstsq(points.xyz, upside, rcond=None)[0]) == pytest.approx(1.0)  # never mirrored
    for option in ({"up": "w"}, {"unit": "inch"}):
        with pytest.raises(InputError, match=next(iter(option.values()))):
            prepare(points, **option)


def test_a_corridor_is_no_room_on_its_side() -> None:
    """1.6 m wide and 3 m high: most of it faces y, and z is up all the same, which is said."""
    random = np.random.default_rng(4)
    sheets = [(random.uniform(0, [20, 1.6], (7000, 2)), z, 2) for z in (0, 3)] + [
        (random.uniform(0, [20, 3], (13000, 2)), y, 1) for y in (0, 1.6)
    ]
    xyz = np.concatenate([np.insert(flat, axis, at, axis=1) for flat, at, axis in sheets])
    found = prepare(cloud(xyz), stray=False)
    assert (found.xyz == xyz).all() and "z was taken for up" in found.notes[0]


def test_coarse_scans_get_the_right_advice() -> None:
    random = np.random.default_rng(2)
    axis = np.arange(0, 8, 0.08)
    x, y = (each.ravel() for each in np.meshgrid(axis, axis))
    floor = np.stack([x, y, np.zeros(len(x))], axis=1) + random.uniform(-0.004, 0.004, (len(x), 3))
    (said,) = advice(cloud(floor), 0.05, 0.0, (-0.15, 0.15))
    assert "too far apart for cells of 0.05 m" in said
    offered = float(said.split("a resolution of ")[1].split(" m")[0])
    assert advice(cloud(floor), offered, 0.0, (-0.15, 0.15)) == ()
    assert rasterise(cloud(floor), offered).free.sum() * offered**2 == pytest.approx(64, rel=0.06)
    assert "less than half a cell" in advice(cloud(floor), offered, 0.03, (-0.15, 0.15))[0]


def test_small_and_odd_clouds_pass() -> None:
    for xyz in (
        np.zeros((1, 3)),
        np.ones((500, 3)),
        np.random.default_rng(1).normal(size=(60, 3)),
        np.array([[0, 0, 0], [1e8, -1e8, 1e8]]),
    ):
        found = prepare(cloud(xyz))
        assert len(found) == len(xyz) and np.isfinite(found.xyz).all()
