"""Readers of scans: every format against what was written, every fault with its line."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.plugins.navigation import readers
from fairaudit.plugins.navigation.readers import read_points

millimetres = st.integers(-50_000, 50_000)
colours = st.integers(0, 255)


@settings(max_examples=40)
@given(
    st.lists(st.tuples(millimetres, millimetres, millimetres, colours, colours, colours), min_size=1, max_size=60),
    st.sampled_from([" ", "  ", "\t"]),
    st.sampled_from(["\n", "\r\n"]),
    st.booleans(),
)
def test_text_is_read_as_written(tmp_path_factory, rows, blank, ending, final) -> None:
    """Against exact integers of millimetres, for every block size down to two lines."""
    text = ending.join(blank.join([*(f"{v / 1000:.3f}" for v in row[:3]), *(str(c) for c in row[3:])]) for row in rows) + ending * final
    path = tmp_path_factory.mktemp("scan") / "scan.txt"
    path.write_bytes(text.encode())
    before = readers.BLOCK
    try:
        for block in (64, before):
            readers.BLOCK = block
            points = read_points(path)
            assert np.rint(points.xyz * 1000).astype(int).tolist() == [list(row[:3]) for row in rows]
            assert points.rgb.tolist() == [list(row[3:]) for row in rows]
    finally:
        readers.BLOCK = before
    assert points.files == {"scan.txt": hashlib.sha256(text.encode()).hexdigest()} and points.sha256 == points.files["scan.txt"]


def test_three_columns_are_grey_and_gzip_is_the_same(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("1 2 3\n\n4 5 6\n")
    with gzip.open(tmp_path / "a.txt.gz", "wt") as file:
        file.write("1 2 3\n\n4 5 6\n")
    plain, packed = read_points(tmp_path / "a.txt"), read_points(tmp_path / "a.txt.gz")
    assert plain.xyz.tolist() == packed.xyz.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert (plain.rgb == 128).all() and plain.parts[0].kind is None
    assert plain.sha256 != packed.sha256  # the digest is that of the file


GOOD = "1 2 3 10 20 30\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "there are no points"),
        ("\n \n", "there are no points"),
        (GOOD + "1 2 3 4 5\n", "line 2: the number of columns is 5; 6 were expected"),
        (GOOD * 3 + "\n1 2 3 4 5 6 7\n" + GOOD, "line 5: the number of columns is 7; 6 were expected"),
        ("1 2\n", "line 1: the number of columns is 2; x y z or x y z r g b"),
        ("x y\n" + GOOD, "line 1: the number of columns is 2; x y z or x y z r g b was expected, or --columns"),
        ("x y w\n1 2 3\n", "line 1: 'x' is not a number"),
        (GOOD + "1 2 3 4 5 nan\n", "line 2: 'nan' is not a number"),
        (GOOD + "1 2 nan 4 5\n", "line 2: the number of columns is 5; 6 were expected"),
        (GOOD + "1 1e999 3 4 5 6\n", "line 2: '1e999' is too large"),
        (GOOD + "1 2 3 4 5 256\n", "line 2: the colour '256' is not an integer from 0 to 255"),
        (GOOD + "1 2 3 4 5 -1\n", "line 2: the colour '-1' is not an integer from 0 to 255"),
        (GOOD + "1 2 3 4.5 5 1\n", "line 2: the colour '4.5' is not an integer from 0 to 255"),
        (GOOD + "1,5 2 3 4 5 6\n", "line 2: '1,5' is not a number"),
        (GOOD + '"1" 2 3 4 5 6\n', "line 2: '\"1\"' is not a number"),
        (GOOD + "1_0 2 3 4 5 6\n", "line 2: '1_0' is not a number"),
        (GOOD + "1 2 3 4 5 6\x00\n", "line 2: '6\\x00' is not a number"),
        ("1 2 3\n1 2 3 4 5 6\n", "line 2: the number of columns is 6; 3 were expected"),
        ("a" * 70_000, "line 1: more than 65,536 characters"),
    ],
)
def test_faults_name_their_line(tmp_path: Path, text: str, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "scan.txt"
    path.write_bytes(text.encode())
    for block in (1 << 24, 32):
        monkeypatch.setattr(readers, "BLOCK", block)
        with pytest.raises(InputError) as caught:
            read_points(path)
        message = str(caught.value)
        if block != 32 or "characters" not in said:
            assert said in message.replace("\\\\", "\\") and str(path) in message


@settings(max_examples=150)
@given(st.binary(max_size=120))
def test_no_bytes_give_anything_but_points_or_a_sentence(tmp_path_factory, data: bytes) -> None:
    folder = tmp_path_factory.mktemp("scan")
    for name in ("scan.txt", "scan.txt.gz", "scan.ply"):
        path = folder / name
        path.write_bytes(data)
        try:
            points = read_points(path)
        except InputError as error:
            assert "\n" not in str(error)
        else:
            assert np.isfinite(points.xyz).all() and len(points)


@settings(max_examples=100)
@given(st.binary(max_size=60), st.integers(0, 400))
def test_broken_ply_gives_a_sentence(tmp_path_factory, junk: bytes, cut: int) -> None:
    pytest.importorskip("plyfile")
    path = tmp_path_factory.mktemp("scan") / "scan.ply"
    whole = _ply(np.arange(12.0).reshape(4, 3), np.zeros((4, 3), np.uint8), text=False, path=path)
    path.write_bytes(whole[:cut] + junk)
    try:
        read_points(path)
    except InputError as error:
        assert "\n" not in str(error)


def test_truncated_gzip_is_an_error(tmp_path: Path) -> None:
    whole = gzip.compress((GOOD * 1000).encode())
    for data in (whole[:-20], b"\x1f\x8b" + b"junk" * 9, b"no gzip"):
        path = tmp_path / "scan.txt.gz"
        path.write_bytes(data)
        with pytest.raises(InputError, match="cannot be read"):
            read_points(path)


def test_missing_file_and_folder_without_rooms(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_points(tmp_path / "none.txt")
    with pytest.raises(InputError, match=r"no room in this folder"):
        read_points(tmp_path)


def _ply(xyz: np.ndarray, rgb: np.ndarray, *, text: bool, path: Path, colour: tuple[str, ...] = ("red", "green", "blue")) -> bytes:
    from plyfile import PlyData, PlyElement

    kinds = [("x", "f8"), ("y", "f8"), ("z", "f8"), *((name, "u1") for name in colour)]
    vertices = np.array([tuple(p) + tuple(c) for p, c in zip(xyz, rgb, strict=True)], dtype=kinds)
    PlyData([PlyElement.describe(vertices, "vertex")], text=text).write(str(path))
    return path.read_bytes()


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("colour", [("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue")])
def test_ply_is_read_as_written(tmp_path: Path, text: bool, colour: tuple[str, ...]) -> None:
    pytest.importorskip("plyfile")
    random = np.random.default_rng(5)
    xyz, rgb = np.round(random.normal(size=(50, 3)), 3), random.integers(0, 256, (50, 3)).astype(np.uint8)
    _ply(xyz, rgb, text=text, path=tmp_path / "scan.ply", colour=colour)
    points = read_points(tmp_path / "scan.ply")
    assert points.xyz.tolist() == xyz.tolist() and points.rgb.tolist() == rgb.tolist()


def test_ply_faults(tmp_path: Path) -> None:
    pytest.importorskip("plyfile")
    path = tmp_path / "scan.ply"
    _ply(np.array([[0, 0, 0], [0, np.nan, 1]]), np.zeros((2, 3)), text=False, path=path)
    assert read_points(path).notes == ("1 of 2 points have no finite coordinates and were left out",)
    _ply(np.empty((0, 3)), np.zeros((0, 3)), text=False, path=path)
    with pytest.raises(InputError, match="no points"):
        read_points(path)
    path.write_text("ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n1\n")
    with pytest.raises(InputError, match="no element named vertex"):
        read_points(path)
    path.write_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n")
    with pytest.raises(InputError, match="no property 'y'"):
        read_points(path)


def _room(folder: Path, annotations: dict[str, str]) -> None:
    (folder / "Annotations").mkdir(parents=True)
    for name, text in annotations.items():
        (folder / "Annotations" / name).write_bytes(text.encode("latin-1"))


def test_s3dis_area(tmp_path: Path) -> None:
    _room(tmp_path / "office_10", {"floor_1.txt": GOOD * 2, "chair_2.txt": GOOD, "chair_10.txt": GOOD})
    _room(tmp_path / "office_2", {"floor_1.txt": GOOD, "stairs_1.txt": GOOD * 3, ".hidden.txt": "junk"})
    (tmp_path / "lobby_1").mkdir()
    (tmp_path / "lobby_1" / "lobby_1.txt").write_text(GOOD * 4)
    (tmp_path / "Area_1_alignmentAngle.txt").write_text("## junk")
    points = read_points(tmp_path)
    assert points.rooms == ("lobby_1", "office_2", "office_10") and not all(part.kind for part in points.parts)
    assert [(p.room, p.kind, p.name, p.stop - p.start) for p in points.parts] == [
        ("lobby_1", None, "lobby_1", 4),
        ("office_2", "floor", "floor_1", 1),
        ("office_2", "clutter", "stairs_1", 3),
        ("office_10", "chair", "chair_2", 1),
        ("office_10", "chair", "chair_10", 1),
        ("office_10", "floor", "floor_1", 2),
    ]
    assert any("'stairs'" in note and "clutter" in note for note in points.notes) and any("lobby_1" in note for note in points.notes)
    assert len(points.files) == 6 and "office_2/Annotations/floor_1.txt" in points.files
    some = read_points(tmp_path, rooms=("office_2",))
    assert some.rooms == ("office_2",) and len(some) == 4
    assert len(read_points(tmp_path / "office_2")) == 4
    with pytest.raises(InputError, match=r"no room 'office_3'.*did you mean 'office_2'"):
        read_points(tmp_path, rooms=("office_3",))
    (tmp_path / "office_2" / "Annotations" / "floor_1.txt").write_text(" \n")
    with pytest.raises(InputError, match=r"floor_1.txt: there are no points"):
        read_points(tmp_path)


def test_known_bad_byte(tmp_path: Path) -> None:
    """The three places where a published file has the byte 0x10: for a blank, for a digit of a colour, for a digit of a coordinate."""
    text = "-1.5 2.5 3.0 185\x10187 188\n" + "1 2 3 103.0\x100000 4 5\n" + "19.302 -9.1\x100 1.785 146 137 106\n" + GOOD
    _room(tmp_path / "hallway_6", {"ceiling_1.txt": text})
    points = read_points(tmp_path / "hallway_6")
    assert points.rgb[:2].tolist() == [[185, 187, 188], [103, 4, 5]]
    assert points.xyz[2].tolist() == [19.302, -9.1, 1.785]
    digest = hashlib.sha256(text.encode("latin-1")).hexdigest()
    assert [("line 1" in n, "line 2" in n, "line 3" in n, "a blank" in n, digest in n) for n in points.notes] == [
        (True, False, False, True, True),
        (False, True, False, False, True),
        (False, False, True, False, True),
    ]
    _room(tmp_path / "hallway_7", {"ceiling_1.txt": GOOD + "1 2 3 4\x10x 5\n"})
    with pytest.raises(InputError, match=r"ceiling_1.txt: line 2: it holds the byte 0x10, and neither"):
        read_points(tmp_path / "hallway_7")
    other = tmp_path / "other.txt"
    other.write_bytes((GOOD + "1 2 3 4 5\x15 6\n").encode("latin-1"))
    with pytest.raises(InputError, match="line 2: "):
        read_points(other)


def test_real_scan(data: Path) -> None:
    points = read_points(data / "scans" / "room_scan1.txt.gz")
    assert len(points) == 112_586
    assert points.xyz[0].tolist() == [0.1072, 0.0529, 1.6858] and (points.rgb == 128).all()
