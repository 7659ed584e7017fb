"""Frames, occupancy maps of ROS and grid maps of MovingAI."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, UNKNOWN, Frame, OccupancyGrid, read_grid, write_ros_map

pytest.importorskip("yaml")
pytest.importorskip("PIL")


@settings(max_examples=60)
@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.sampled_from([0.01, 0.05, 0.08, 0.25, 1.0]), st.integers(1, 400), st.integers(1, 400))
def test_every_centre_lies_in_its_cell(x: float, y: float, resolution: float, rows: int, columns: int) -> None:
    frame = Frame(x, y, resolution, rows, columns)
    for row, column in {(0, 0), (rows - 1, columns - 1), (rows // 2, columns // 3)}:
        assert frame.cell(*frame.centre(row, column)) == (row, column)


def test_frames_that_are_refused() -> None:
    with pytest.raises(InputError, match="more than 1,000,000,000 cells"):
        Frame(0, 0, 0.05, 100_000, 10_001)
    assert Frame(0, 0, 0.05, 100_000, 10_000).rows == 100_000
    with pytest.raises(InputError, match="more than 1,000,000,000 cells"):
        Frame.around((0, 0, 1e6, 1e6), 0.01)
    for resolution in (0.0, -1.0, float("nan"), float("inf"), 1e-300):
        with pytest.raises(InputError):
            Frame.around((0, 0, 1, 1), resolution)
    with pytest.raises(InputError, match="is not on the map, which reaches from"):
        Frame(0, 0, 1, 2, 2).cell(2.0, 1.0)


def test_turtlebot_map(data: Path, tmp_path: Path) -> None:
    """Free cells counted from the bytes of the picture; written back and read again unchanged, to the byte of every pixel."""
    source = data / "maps" / "turtlebot3_map.pgm"
    shutil.copy(source, tmp_path / "map.pgm")
    shutil.copy(data / "maps" / "turtlebot3_map.yaml", tmp_path / "map.yaml")
    grid = read_grid(tmp_path / "map.yaml")
    pixels = source.read_bytes()[-384 * 384 :]
    assert grid.free.sum() == pixels.count(254) == 7939
    assert (grid.states == OCCUPIED).sum() == pixels.count(0) and (grid.states == UNKNOWN).sum() == pixels.count(205)
    assert grid.frame == Frame(-10.0, -10.0, 0.05, 384, 384)
    write_ros_map(grid, tmp_path / "again.yaml")
    again = read_grid(tmp_path / "again.yaml")
    assert (again.states == grid.states).all() and again.frame == grid.frame
    assert (tmp_path / "again.pgm").read_bytes()[-384 * 384 :] == pixels


def test_map_whose_picture_was_renamed(data: Path) -> None:
    with pytest.raises(InputError, match=r"map.pgm is not there; write turtlebot3_map.pgm into the key image"):
        read_grid(data / "maps" / "turtlebot3_map.yaml")


@settings(max_examples=40)
@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 2**32), st.floats(-100, 100), st.sampled_from([0.05, 0.1, 1 / 3]))
def test_any_map_survives_writing(tmp_path_factory, rows: int, columns: int, seed: int, x: float, resolution: float) -> None:
    states = np.random.default_rng(seed).choice(np.array([FREE, OCCUPIED, UNKNOWN], np.int8), (rows, columns))
    grid = OccupancyGrid(Frame(x, -x, resolution, rows, columns, x / 9), states)
    path = tmp_path_factory.mktemp("map") / "m.yaml"
    write_ros_map(grid, path)
    again = read_grid(path)
    assert again.frame == grid.frame and (again.states == states).all()


YAML = "image: m.png\nresolution: 0.5\norigin: [-1, -2, 0]\nnegate: {negate}\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("mode", ["L", "RGB", "P", "RGBA"])
def test_thresholds_and_origin(tmp_path: Path, negate: int, mode: str) -> None:
    """Thresholds are strict, what is transparent is unknown, and the origin is the lower left corner."""
    from PIL import Image

    shades = np.array([[255, 254, 206], [205, 100, 89], [88, 1, 0]], np.uint8)
    picture = Image.fromarray(255 - shades if negate else shades).convert(mode)
    if mode == "RGBA":
        picture.putpixel((0, 0), (255, 255, 255, 7) if not negate else (0, 0, 0, 7))
    picture.save(tmp_path / "m.png")
    (tmp_path / "m.yaml").write_text(YAML.format(negate=negate))
    grid = read_grid(tmp_path / "m.yaml")
    free = [[mode != "RGBA", True, True], [False] * 3, [False] * 3]  # (255-205)/255 = 0.19608 is not below 0.196
    assert grid.free.tolist() == free
    assert (grid.states == OCCUPIED).tolist() == [[False] * 3, [False, False, True], [True] * 3]  # (255-89)/255 = 0.651 > 0.65
    assert grid.frame.cell(-0.9, -1.9) == (2, 0)


def served(shades: np.ndarray, clear: np.ndarray, mode: str, negate: int, free: float, occupied: float) -> list[list[int]]:
    """What the map server of Nav2 publishes, cell by cell, in single precision."""
    single, cells = np.float32, []
    for row, hidden in zip(shades.tolist(), clear.tolist(), strict=True):
        cells.append([])
        for shade, gone in zip(row, hidden, strict=True):
            p = single(shade) / single(255)
            p = p if negate else single(1) - p
            cell = -1
            if mode == "raw":
                cells[-1].append(shade if shade <= 100 else -1)
                continue
            if p >= single(occupied):
                cell = 100
            if p <= single(free):
                cell = 0
            if mode == "scale" and single(free) < p < single(occupied):
                cell = int(float((p - single(free)) / single(occupied - free) * single(100)) + 0.5)
            cells[-1].append(-1 if gone else cell)
    return cells


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(["trinary", "scale", "raw", "Scale"]),
    st.integers(0, 1),
    st.sampled_from([(0.196, 0.65), (0.25, 0.65), (0.2, 0.8), (0.0, 1.0), (0.01, 0.99), (0.5, 0.5)]),
    st.sampled_from(["png", "pgm", "bmp"]),
    st.integers(0, 2**32),
)
def test_every_mode_is_what_the_map_server_publishes(tmp_path_factory, mode, negate, thresholds, ending, seed) -> None:
    from PIL import Image

    folder, (free, occupied) = tmp_path_factory.mktemp("map"), thresholds
    shades = np.arange(256, dtype=np.uint8).reshape(16, 16)
    clear = np.random.default_rng(seed).random((16, 16)) < (0.2 if ending == "png" else 0)
    picture = Image.fromarray(shades)
    if ending == "png":
        picture = picture.convert("LA")
        picture.putalpha(Image.fromarray(np.where(clear, seed % 255, 255).astype(np.uint8)))
    picture.save(folder / f"m.{ending}")
    (folder / "m.yaml").write_text(
        f"image: m.{ending}\nmap_type: occupancy\nmode: {mode}\nresolution: 0.05\norigin: [1, 2, 0.3]\nnegate: {negate}\n"
        f"occupied_thresh: {occupied}\nfree_thresh: {free}\n"
    )
    grid = read_grid(folder / "m.yaml")
    assert grid.states.tolist() == served(shades, clear, mode.lower(), negate, free, occupied)
    assert grid.frame == Frame(1.0, 2.0, 0.05, 16, 16, 0.3) and (grid.free == (grid.states == 0)).all()
    assert (read_grid(folder / "m.yaml", 30).free == ((grid.states >= 0) & (grid.states < 30))).all()


def test_percentages_that_would_free_obstacles_are_refused(tmp_path: Path) -> None:
    for below in (0, 101, -3):
        with pytest.raises(InputError, match="a percentage from 1 to 100"):
            OccupancyGrid(Frame(0, 0, 1, 1, 1), np.zeros((1, 1), np.int8), below)


@settings(max_examples=80)
@given(st.floats(-7, 7), st.integers(1, 40), st.integers(1, 40), st.floats(-50, 50), st.sampled_from([0.02, 0.05, 1.0]))
def test_a_turned_frame_is_the_level_one_turned(yaw: float, rows: int, columns: int, x: float, resolution: float) -> None:
    """Each cell's centre is that of the level frame, turned about the lower left corner; and lies in the cell."""
    level, frame = Frame(x, -x, resolution, rows, columns), Frame(x, -x, resolution, rows, columns, yaw)
    for row, column in {(0, 0), (rows - 1, columns - 1), (rows // 2, columns // 3)}:
        right, up = (column + 0.5) * resolution, (rows - row - 0.5) * resolution
        turned = complex(x, -x) + complex(right, up) * complex(np.cos(yaw), np.sin(yaw))
        assert frame.centre(row, column) == pytest.approx((turned.real, turned.imag), abs=1e-4)
        assert frame.cell(*frame.centre(row, column)) == (row, column) == level.cell(*level.centre(row, column))
    far = complex(x, -x) + complex(-1.0, rows * resolution / 2) * complex(np.cos(yaw), np.sin(yaw))
    with pytest.raises(InputError, match="is not on the map, which reaches from"):
        frame.cell(far.real, far.imag)


def test_a_map_turned_by_quarters_is_the_picture_turned(tmp_path: Path) -> None:
    """A picture with yaw of a quarter against the picture whose pixels were turned: the same cells, at the same places, are free."""
    random = np.random.default_rng(4)
    states = random.choice(np.array([FREE, OCCUPIED, UNKNOWN], np.int8), (7, 11))
    for quarters in range(4):
        write_ros_map(OccupancyGrid(Frame(0.0, 0.0, 0.5, 7, 11, quarters * np.pi / 2), states), tmp_path / "turned.yaml")
        pixels = np.rot90(states, quarters)
        left, low = {0: (0.0, 0.0), 1: (-3.5, 0.0), 2: (-5.5, -3.5), 3: (0.0, -5.5)}[quarters]
        write_ros_map(OccupancyGrid(Frame(left, low, 0.5, *pixels.shape), pixels), tmp_path / "level.yaml")
        turned, level = read_grid(tmp_path / "turned.yaml"), read_grid(tmp_path / "level.yaml")
        for row, column in np.ndindex(7, 11):
            assert level.states[level.frame.cell(*turned.frame.centre(row, column))] == turned.states[row, column]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("origin: [-1, -2, 0]", "origin: [-1, -2, .inf]"), "a finite number is accepted"),
        (("origin: [-1, -2, 0]", "origin: 3"), "of the lower left corner is accepted"),
        (("resolution: 0.5", "resolution: -1"), "the resolution is -1"),
        (("resolution: 0.5\n", ""), "the key resolution is missing"),
        (("resolution: 0.5", "resolution: .nan"), "a finite number is accepted"),
        (("resolution: 0.5", "resolutoin: 0.5"), "did you mean 'resolution'"),
        (("free_thresh: 0.196", "free_thresh: 0.9"), "0 ≤ free ≤ occupied ≤ 1"),
        (("negate: 0", "negate: maybe"), "negate is 'maybe'; 0 or 1"),
        (("image: m.png", "image: none.png"), "the picture none.png is not there"),
        (("image: m.png", "image: [1]"), "must name a picture"),
        (("image: m.png", "image: m.yaml"), "the picture m.yaml cannot be read"),
        (("negate: 0", "mode: rough"), "mode is 'rough'; trinary or scale or raw is accepted"),
        (("negate: 0", "map_type: voxel"), "map_type is 'voxel'; occupancy is accepted"),
        (("image: m.png", "{image: : ["), "not a YAML file (line 1)"),
        (("image: m.png\n", "!!python/object/apply:os.getcwd []\n"), "not a YAML file"),
    ],
)
def test_bad_map_files(tmp_path: Path, change: tuple[str, str], said: str) -> None:
    from PIL import Image

    Image.new("L", (2, 2), 254).save(tmp_path / "m.png")
    (tmp_path / "m.yaml").write_text(YAML.format(negate=0).replace(*change))
    with pytest.raises(InputError) as caught:
        read_grid(tmp_path / "m.yaml")
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_sixteen_bits_and_yaml_lists_are_refused(tmp_path: Path) -> None:
    (tmp_path / "m.png").write_bytes(b"P5\n2 1\n65535\n\x00\x01\x02\x03")
    (tmp_path / "m.yaml").write_text(YAML.format(negate=0))
    with pytest.raises(InputError, match="more than 8 bits"):
        read_grid(tmp_path / "m.yaml")
    (tmp_path / "m.yaml").write_text("- 1\n")
    with pytest.raises(InputError, match="not a map file of ROS"):
        read_grid(tmp_path / "m.yaml")


MAP = "type octile\nheight 2\nwidth 3\nmap\n.G@\nSTW\n"


def test_moving_ai_terrain(tmp_path: Path) -> None:
    (tmp_path / "a.map").write_text(MAP)
    grid = read_grid(tmp_path / "a.map")
    assert grid.free.astype(int).tolist() == [[1, 1, 0], [1, 0, 0]]
    (tmp_path / "a.map").write_bytes(MAP.replace("\n", "\r\n").encode())
    assert (read_grid(tmp_path / "a.map").states == grid.states).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("type octile", "octile"), "should begin with the lines type octile"),
        (("height 2", "height x"), "height N, width N and map"),
        (("height 2", "height 3"), "height says 3 rows of cells, and the number found is 2"),
        (("STW", "ST"), "width says 3 cells a line, and line 6 has 2"),
        (("G", "x"), "line 5, column 2: 'x' is no terrain"),
        (("width 3", "height 3"), "height N, width N and map"),
        (("height 2", "height 999999999"), "more than 1,000,000,000 cells"),
    ],
)
def test_bad_grid_maps(tmp_path: Path, change: tuple[str, str], said: str) -> None:
    (tmp_path / "a.map").write_text(MAP.replace(*change))
    with pytest.raises(InputError) as caught:
        read_grid(tmp_path / "a.map")
    assert said in str(caught.value)


@settings(max_examples=100)
@given(st.binary(max_size=200))
def test_no_bytes_give_anything_but_a_map_or_a_sentence(tmp_path_factory, data: bytes) -> None:
    folder = tmp_path_factory.mktemp("map")
    (folder / "m.png").write_bytes(data)
    (folder / "m.yaml").write_text(YAML.format(negate=0))
    (folder / "n.yaml").write_bytes(data)
    (folder / "n.map").write_bytes(data)
    (folder / "o.map").write_bytes(MAP.encode() + data)
    for name in ("m.yaml", "n.yaml", "n.map", "o.map"):
        try:
            read_grid(folder / name)
        except InputError as error:
            assert "\n" not in str(error)
