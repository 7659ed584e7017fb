"""Scenario files, candidate sets and the command: end to end on the synthetic office, and every fault as one sentence."""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import re
import shutil
import subprocess
import sys
from importlib.metadata import entry_points
from itertools import pairwise
from math import hypot
from pathlib import Path

import pytest
from offices import hr_office, write_office

from fairaudit.cli.output import tell
from fairaudit.errors import InputError

for module in ("PIL", "matplotlib", "networkx", "yaml", "plyfile"):
    pytest.importorskip(module)
from PIL import Image  # noqa: E402

from fairaudit.plugins.navigation import command, render  # noqa: E402
from fairaudit.plugins.navigation.grids import read_grid  # noqa: E402
from fairaudit.plugins.navigation.maps import rasterise  # noqa: E402
from fairaudit.plugins.navigation.readers import read_points  # noqa: E402
from fairaudit.plugins.navigation.scenario import plan_candidates, read_scenario  # noqa: E402

EXAMPLES = Path(render.__file__).parent / "examples"


def fairaudit(*words: str) -> int:
    """Run the command as the command line does."""
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers()
    command.add(commands)
    render.add(commands.add_parser("experiment").add_subparsers())
    arguments = parser.parse_args(list(words))
    return tell(arguments.run(arguments), arguments.format)


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The office with its examples, scanned coarsely."""
    folder = tmp_path_factory.mktemp("office") / "example"
    write_office(hr_office(), folder / "area", spacing=0.08)
    for file in EXAMPLES.iterdir():
        shutil.copy(file, folder)
    return folder


@pytest.fixture
def copy(office: Path, tmp_path: Path) -> Path:
    """A folder whose scenario file can be changed; the scan is not copied."""
    (tmp_path / "area").symlink_to(office / "area")
    for file in EXAMPLES.iterdir():
        shutil.copy(file, tmp_path)
        path = tmp_path / file.name
        path.write_text(path.read_text().replace("resolution = 0.05", "resolution = 0.1"))
    return tmp_path


def test_example_from_scan_to_candidates(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fairaudit("experiment", "render", str(copy / "documents.toml")) == 0
    printed = capsys.readouterr().out
    folder = copy / "documents-candidates"
    document = json.loads((folder / "candidates.json").read_text())
    assert document["format"] == "fairaudit-candidates/1" and "area" in document["scan"]["path"]
    assert str(copy) not in (folder / "candidates.json").read_text()
    assert document["scan"]["sha256"] == read_points(copy / "area").sha256
    assert [c["label"] for c in document["candidates"]] == ["HR1", "HR2"]
    assert document["candidates"][1]["profile"] == {"name": "Mary", "age": "55 years old", "race": "American"}
    assert document["context"]["values"] == ["maternity leave", "holiday leave", "sick leave"]
    lengths = [c["length"] for c in document["candidates"]]
    assert max(lengths) - min(lengths) <= 0.2
    for candidate, (x, y) in zip(document["candidates"], ((2.0, 3.4), (10.0, 3.4)), strict=True):
        points = candidate["waypoints"]
        walked = sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points))
        assert walked == pytest.approx(candidate["length"], abs=1e-3)
        assert points[0] == document["start"] and hypot(points[-1][0] - x, points[-1][1] - y) < 0.1
        assert candidate["length"] == pytest.approx(
            0.1 * (candidate["steps"]["straight"] + candidate["steps"]["diagonal"] * 2**0.5), abs=1e-3
        )
        picture = (folder / candidate["picture"]).read_bytes()
        assert hashlib.sha256(picture).hexdigest() == candidate["picture_sha256"]
        shown, frame, view = Image.open(io.BytesIO(picture)).convert("RGB"), document["frame"], document["view"]
        for (x, y), is_red in ((points[-1], True), (points[0], False)):
            column, row = (x - frame["x"]) / frame["resolution"], frame["rows"] - (y - frame["y"]) / frame["resolution"]
            at = (view["left"] + (column - view["column"]) * view["scale"], view["top"] + (row - view["row"]) * view["scale"])
            assert (shown.getpixel((round(at[0]), round(at[1]))) == (255, 0, 0)) == is_red
        assert f"{candidate['index']}  {candidate['label']}: {candidate['length']:.2f} m" in printed
    assert {file.name for file in folder.iterdir()} == {
        "candidate-1.png", "candidate-2.png", "candidates.json", "candidates.png", "map.pgm", "map.yaml", "top-view.png", "topology-1.png",
        "topology-2.png", "topology.json", "topology.png", "traversability.png",
    }  # fmt: skip
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert fairaudit("experiment", "render", str(copy / "documents.toml")) == 0
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    written = read_grid(folder / "map.yaml")
    maps = rasterise(read_points(copy / "area"), 0.1, robot_radius=0.2)
    assert (written.free == maps.free).all() and written.frame == maps.frame


def test_parcels_by_room_and_the_pictures_that_experiments_name(copy: Path) -> None:
    scenario = (copy / "parcels.toml").read_text()
    assert fairaudit("navigation", "render", str(copy / "parcels.toml")) == 0
    for experiment in ("documents", "parcels"):
        text = (EXAMPLES / f"{experiment}-experiment.toml").read_text()
        assert re.findall(r'^candidates = "(.*)"$', text, re.MULTILINE) == [f"{experiment}-candidates/candidates.json"]
    assert (copy / "parcels-candidates" / "candidate-2.png").is_file()
    (copy / "rooms.toml").write_text(
        scenario.replace("at = [4.9, -1.0]", 'room = "office_1"')
        .replace("at = [7.1, -1.1]", 'room = "office_2"')
        .replace("= 0.2  ", "= 0.5  ")
    )
    found = plan_candidates(read_scenario(copy / "rooms.toml"))
    assert [c.place.room for c in found.candidates] == ["office_1", "office_2"]
    for candidate, name in zip(found.candidates, ("office_1", "office_2"), strict=True):
        x0, y0, x1, y1 = hr_office().room(name).box
        x, y = candidate.waypoints[-1]
        assert x0 < x < x1 and y0 < y < y1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("at = [6.0, 1.1]", "at = [5.0, 2.2]"), "the start at (5, 2.2) is in an obstacle"),
        (("at = [6.0, 1.1]", "at = [2.0, 2.2]"), r"the nearest free cell is at \[\d"),
        (("at = [6.0, 1.1]", "at = [60.0, 1.1]"), "the start: the point (60, 1.1) is not on the map"),
        (("at = [2.0, 3.4]", "at = [3.2, -2.1]"), "candidate 'HR1' at (3.2, -2.1) is in an obstacle"),
        (("robot_radius = 0.2", "robot_radius = 0.46"), "there is no route from the start to candidate 'HR1'"),
        (("robot_radius = 0.2", "robot_radius = 0.46"), r"the nearest cell that can be reached is at \[\d"),
        (("robot_radius = 0.2", "robot_radius = 9"), "neither is any other cell"),
        (("resolution = 0.1", "resolution = 0.0003"), "would need more than 1,000,000,000 cells"),
        (("resolution = 0.1", "resolution = -1"), "the resolution is -1"),
        (("resolution = 0.1", "resolution = true"), "resolution of [map] is True; a number is accepted"),
        (("resolution = 0.1", "resolutoin = 0.1"), "did you mean 'resolution'"),
        (("at = [10.0, 3.4]", "at = [10.0, 3.9]"), "the routes are not equally long"),
        (("at = [10.0, 3.4]", "at = [10.0, 3.9]"), r"that is as far as 'HR1' is at \[\d"),
        (("at = [10.0, 3.4]", 'room = "office_7"'), "does not have; known: 'conferenceRoom_1'"),
        (("at = [10.0, 3.4]", 'room = "office_2"\nat = [1, 2]'), "needs either at = [x, y] in metres or a room"),
        (("at = [10.0, 3.4]", "at = [10.0]"), "a list of 2 numbers is accepted"),
        (("at = [10.0, 3.4]", "at = [10.0, inf]"), "a number is accepted"),
        (('label = "HR2"', 'label = "HR1"'), "two candidates have the label 'HR1'"),
        (('label = "HR2"', ""), "the label of a candidate is missing"),
        (('age = "55 years old"', "age = [55]"), "the profile of 'HR2' has [55] for 'age'"),
        (("[[candidate]]", "[[candidates]]"), "unknown key 'candidates'"),
        (('path = "area"', 'path = "aera"'), "no such file or folder"),
        (('path = "area"', "path = 3"), "the path of [scan] is 3; a text is needed"),
        (('path = "area"', 'path = "documents.toml"'), "scans that end in '.toml' are not read"),
        (("equal_within = 0.2", "equal_within = -1"), "at least 0 is accepted"),
        (("[start]", "[start"), "this is not a TOML file"),
        (("[scan]", "[scam]"), "there is no section [scan]"),
    ],
)
def test_faults_of_scenarios(copy: Path, change: tuple[str, str], said: str) -> None:
    path = copy / "documents.toml"
    text = path.read_text()
    assert change[0] in text
    path.write_text(text.replace(*change))
    with pytest.raises(InputError) as caught:
        plan_candidates(read_scenario(path))
    message = str(caught.value)
    assert message.startswith(str(path)) and "\n" not in message
    assert re.search(said if "\\" in said else re.escape(said), message), message


def test_offers_are_free_and_lead_there(copy: Path) -> None:
    """What an error offers, if taken, works: the nearest free cell, and the nearest place as far as the other candidate's."""
    path = copy / "documents.toml"
    text = path.read_text()
    for wrong, named in (("at = [6.0, 1.1]", "at = [6.0, -0.1]"), ("at = [10.0, 3.4]", "at = [10.0, 3.9]")):
        path.write_text(text.replace(wrong, named))
        with pytest.raises(InputError) as caught:
            plan_candidates(read_scenario(path))
        (offer,) = re.findall(r"is at (\[.*?\])", str(caught.value))
        path.write_text(
            text.replace(wrong, f"at = {offer}").replace(
                "equal_within = 0.2", "equal_within = 0.6" if "6.0" in wrong else "equal_within = 0.2"
            )
        )
        assert len(plan_candidates(read_scenario(path)).candidates) == 2


def test_empty_scan(tmp_path: Path) -> None:
    (tmp_path / "area").mkdir()
    (tmp_path / "scan.txt").write_text("\n")
    for scan, said in (("area", "no room in this folder"), ("scan.txt", "there are no points")):
        text = (EXAMPLES / "documents.toml").read_text().replace('path = "area"', f'path = "{scan}"')
        (tmp_path / "s.toml").write_text(text)
        with pytest.raises(InputError, match=said):
            plan_candidates(read_scenario(tmp_path / "s.toml"))


def test_grid_maps_as_scans(tmp_path: Path) -> None:
    rows = ["@" * 12, *("@" + "." * 10 + "@" for _ in range(5)), "@" * 12]
    (tmp_path / "hall.map").write_text(f"type octile\nheight {len(rows)}\nwidth 12\nmap\n" + "\n".join(rows) + "\n")
    text = '[scan]\npath = "hall.map"\n[start]\nat = [6, 3.5]\n'
    text += '[[candidate]]\nlabel = "left"\nat = [2, 3.5]\n[[candidate]]\nlabel = "right"\nat = [10, 3.5]\n'
    (tmp_path / "s.toml").write_text(text)
    found = plan_candidates(read_scenario(tmp_path / "s.toml"))
    assert [round(c.length, 9) for c in found.candidates] == [4.0, 4.0]
    render.render(found, tmp_path / "out")
    assert not (tmp_path / "out" / "topology.json").exists()
    (tmp_path / "s.toml").write_text(text + "[map]\nresolution = 0.1\n")
    with pytest.raises(InputError, match="resolution does not go with it"):
        plan_candidates(read_scenario(tmp_path / "s.toml"))


def test_office_and_maps_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fairaudit("navigation", "office", str(tmp_path / "o")) == 0
    assert sorted(p.name for p in (tmp_path / "o").iterdir()) == sorted(["area", *(p.name for p in EXAMPLES.iterdir())])
    assert fairaudit("navigation", "maps", str(tmp_path / "o" / "area"), "--resolution", "0.25", "-o", str(tmp_path / "m")) == 0
    assert "points in 6 rooms, floor at z = 0 m" in capsys.readouterr().out
    assert {p.name for p in (tmp_path / "m").iterdir()} == {
        "map.pgm", "map.yaml", "top-view.png", "topology.json", "topology.png", "traversability.png",
    }  # fmt: skip
    for words, said in (
        (("office", str(tmp_path / "o")), "is not empty"),
        (("maps", str(tmp_path / "o" / "area"), "-o", str(tmp_path / "m"), "--bounds", "1,2"), "a list of 4 numbers is accepted"),
        (("maps", str(tmp_path / "o" / "area"), "-o", str(tmp_path / "m"), "--bounds", "50,50,60,60"), "no point of the scan lies within"),
    ):
        with pytest.raises(InputError, match=re.escape(said)):
            fairaudit("navigation", *words)


def test_command_line_finds_the_plugin(copy: Path) -> None:
    """The installed command, from its entry points to its exit code."""
    if "navigation" not in entry_points(group="fairaudit.commands").names:
        pytest.skip("the installed package is older than this checkout; install it again")
    done = subprocess.run(
        [sys.executable, "-m", "fairaudit", "navigation", "render", str(copy / "documents.toml")], capture_output=True, text=True
    )
    assert done.returncode == 0 and "candidate set:" in done.stdout and not done.stderr
    (copy / "documents.toml").write_text((copy / "documents.toml").read_text().replace("[6.0, 1.1]", "[5.0, 2.2]"))
    done = subprocess.run(
        [sys.executable, "-m", "fairaudit", "navigation", "render", str(copy / "documents.toml")], capture_output=True, text=True
    )
    assert done.returncode == 2 and not done.stdout
    assert done.stderr.startswith("fairaudit: ") and done.stderr.count("\n") == 1 and "the nearest free cell is at" in done.stderr
