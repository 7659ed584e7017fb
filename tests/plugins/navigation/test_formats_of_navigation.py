"""Formats of point clouds: what each format's own library wrote is read as it was written, and what is damaged gets one sentence."""

from __future__ import annotations

import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.readers import READERS, Points, read_bag_grid, read_points

RANDOM = np.random.default_rng(3)
XYZ = np.round(RANDOM.uniform(-5, 5, (300, 3)), 3)
RGB = RANDOM.integers(0, 256, (300, 3)).astype(np.uint8)
NOWHERE = "1 of 300 points have no finite coordinates and were left out"


def packed(rgb: np.ndarray) -> np.ndarray:
    """Three bytes in the bits of a float, as PCL writes them."""
    wide = rgb.astype(np.uint32)
    return (wide[:, 0] << 16 | wide[:, 1] << 8 | wide[:, 2]).view(np.float32)


def pcd(path: Path, encoding: str) -> None:
    pypcd4 = pytest.importorskip("pypcd4")
    xyz = XYZ.astype(np.float32)
    xyz[7, 1] = np.nan
    columns = [xyz[:, 2], packed(RGB), xyz[:, 0], xyz[:, 1], np.zeros(300, np.uint8)]
    types = [np.float32, np.float32, np.float32, np.float32, np.uint8]
    pypcd4.PointCloud.from_points(columns, ["z", "rgb", "x", "y", "label"], types).save(path, encoding=pypcd4.Encoding(encoding))


def las(path: Path, colours: int = 256, ground: int = 0) -> None:
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.scales, header.offsets = [0.001] * 3, [0, 0, 0]
    content = laspy.LasData(header)
    content.x, content.y, content.z = XYZ.T
    for number, name in enumerate(("red", "green", "blue")):
        setattr(content, name, RGB[:, number].astype(np.uint16) * colours)
    content.classification[:ground] = 2
    content.write(path)


def e57(path: Path) -> None:
    """Two scans, the second one turned by a quarter and moved by its pose."""
    pye57 = pytest.importorskip("pye57")
    names = ("cartesianX", "cartesianY", "cartesianZ", "colorRed", "colorGreen", "colorBlue")
    with pye57.E57(str(path), mode="w") as content:
        content.write_scan_raw(dict(zip(names, [*XYZ[:200].T, *RGB[:200].T], strict=True)))
        moved = XYZ[200:] - [1, 2, 3]
        local = np.stack([moved[:, 1], -moved[:, 0], moved[:, 2]])
        turn = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
        content.write_scan_raw(dict(zip(names, [*local, *RGB[200:].T], strict=True)), rotation=turn, translation=np.array([1.0, 2.0, 3.0]))


def bag(path: Path, storage: str, *, big: bool = False, clouds: int = 1, grid: bool = False) -> None:
    """A recording of ROS 2 with rows that are longer than their points."""
    writing = pytest.importorskip("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="map")
    order = ">" if big else "<"
    kind = np.dtype({"names": ["x", "y", "z", "rgb"], "formats": [order + "f4"] * 4, "offsets": [0, 4, 8, 16], "itemsize": 32})
    rows = np.zeros((3, 100), kind)
    for number, name in enumerate("xyz"):
        rows[name] = XYZ[:, number].reshape(3, 100)
    rows["rgb"] = packed(RGB).reshape(3, 100)
    data = np.pad(rows.view(np.uint8).reshape(3, 3200), ((0, 0), (0, 8))).reshape(-1)
    field = types["sensor_msgs/msg/PointField"]
    fields = [field(name=n, offset=o, datatype=7, count=1) for n, o in (("x", 0), ("y", 4), ("z", 8), ("rgb", 16))]
    cloud = types["sensor_msgs/msg/PointCloud2"](
        header=header, height=3, width=100, fields=fields, is_bigendian=big, point_step=32, row_step=3208, data=data, is_dense=True
    )
    pose = types["geometry_msgs/msg/Pose"](
        position=types["geometry_msgs/msg/Point"](x=-1.0, y=2.0, z=0.0),
        orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
    )
    info = types["nav_msgs/msg/MapMetaData"](map_load_time=stamp, resolution=0.05, width=3, height=2, origin=pose)
    cells = types["nav_msgs/msg/OccupancyGrid"](header=header, info=info, data=np.array([0, 100, -1, 50, 65, 19], np.int8))
    kinds = {"mcap": writing.StoragePlugin.MCAP, "sqlite3": writing.StoragePlugin.SQLITE3}
    with writing.Writer(path, version=9, storage_plugin=kinds[storage]) as writer:
        for topic, message, times in (("/points", cloud, clouds), ("/map", cells, int(grid))):
            if times:
                link = writer.add_connection(topic, message.__msgtype__, typestore=store)
                for time in range(times):
                    writer.write(link, time, store.serialize_cdr(message, message.__msgtype__))


def same(points: Points, tolerance: float = 1e-6, left: int | None = None) -> None:
    kept = np.arange(300) != left
    assert np.abs(points.xyz - XYZ[kept]).max() < tolerance and (points.rgb == RGB[kept]).all()


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_pcd_of_its_library(tmp_path: Path, encoding: str) -> None:
    pcd(tmp_path / "scan.pcd", encoding)
    points = read_points(tmp_path / "scan.pcd")
    assert points.notes == (NOWHERE,)
    if encoding == "ascii":  # ten decimals do not hold the bits of a colour
        assert np.abs(points.xyz - np.delete(XYZ, 7, axis=0)).max() < 1e-6
    else:
        same(points, left=7)


@pytest.mark.parametrize(("name", "colours"), [("scan.las", 256), ("scan.las", 1), ("scan.laz", 257)])
def test_las_and_laz_of_their_library(tmp_path: Path, name: str, colours: int) -> None:
    if name.endswith("z"):
        pytest.importorskip("lazrs")
    las(tmp_path / name, colours)
    same(read_points(tmp_path / name))


def test_ground_of_las_is_the_floor(tmp_path: Path) -> None:
    las(tmp_path / "scan.las", ground=120)
    points = read_points(tmp_path / "scan.las")
    assert [(part.kind, part.start, part.stop) for part in points.parts] == [("floor", 0, 120), (None, 120, 300)]
    assert "120 points of the class ground" in points.notes[0]
    same(points)


def test_e57_of_its_library_with_poses(tmp_path: Path) -> None:
    e57(tmp_path / "scan.e57")
    points = read_points(tmp_path / "scan.e57")
    same(points)
    assert points.notes == ("2 scans were joined, each by its own pose",)


@pytest.mark.parametrize(("storage", "big"), [("mcap", False), ("sqlite3", True)])
def test_recordings_of_their_library(tmp_path: Path, storage: str, big: bool) -> None:
    bag(tmp_path / "run", storage, big=big)
    (tmp_path / "run" / "attachments").mkdir()
    for path in (tmp_path / "run", next(file for file in (tmp_path / "run").iterdir() if file.suffix in (".mcap", ".db3"))):
        if path.suffix == ".db3":
            continue  # a file of sqlite3 alone says less than its folder
        points = read_points(path)
        assert np.abs(points.xyz - XYZ).max() < 1e-6 and ("'map'" in points.notes[0])
        assert big or (points.rgb == RGB).all()
    assert {name.split("/")[-1] for name in points.files} <= {"metadata.yaml", "run.mcap", "run.db3", "run_0.mcap"}


def test_topics_and_messages_are_chosen(tmp_path: Path) -> None:
    bag(tmp_path / "two", "mcap", grid=True)
    with pytest.raises(InputError, match=r"several topics: /points \(PointCloud2, 1\), /map \(OccupancyGrid, 1\)"):
        read_points(tmp_path / "two")
    with pytest.raises(InputError, match=r"no topic '/point'.*did you mean '/points'"):
        read_points(tmp_path / "two", topic="/point")
    with pytest.raises(InputError, match="has an OccupancyGrid, which is a map"):
        read_points(tmp_path / "two", topic="/map")
    same(read_points(tmp_path / "two", topic="/points"))
    grid = read_bag_grid(tmp_path / "two", "/map", None)
    assert grid is not None and grid.states.tolist() == [[50, 65, 19], [0, 100, -1]]
    assert grid.free.tolist() == [[False, False, True], [True, False, False]]
    assert (grid.frame.x, grid.frame.y, grid.frame.resolution) == (-1.0, 2.0, 0.05)
    bag(tmp_path / "many", "mcap", clouds=3)
    with pytest.raises(InputError, match='3 messages; message = "first" or "last"'):
        read_points(tmp_path / "many")
    same(read_points(tmp_path / "many", message="last"))


def test_npy(tmp_path: Path) -> None:
    path = tmp_path / "scan.npy"
    np.save(path, np.hstack([XYZ, RGB]))
    same(read_points(path))
    np.save(path, np.hstack([RGB[:, ::-1], XYZ, np.ones((300, 1))]).astype(">f8"))
    same(read_points(path, columns=("b", "g", "r", "x", "y", "z", "label")))
    np.save(path, XYZ.T)
    with pytest.raises(InputError, match=r"its shape is \(3, 300\)"):
        read_points(path)
    np.save(path, np.array([{}]), allow_pickle=True)
    with pytest.raises(InputError, match="not an npy file"):
        read_points(path)


@pytest.mark.parametrize(
    ("name", "head", "separator", "columns"),
    [
        ("scan.csv", "Z,X,Y,Red,Green,Blue,Label\n", ",", ()),
        ("scan.txt", "", ";", ("z", "x", "y", "r", "g", "b", "-")),
        ("scan.asc", "//Z X Y R G B Label\n", " ", ()),
        ("scan.xyz.gz", "", "\t", ("z", "x", "y", "r", "g", "b", "w")),
    ],
)
def test_text_of_any_order(tmp_path: Path, name: str, head: str, separator: str, columns: tuple[str, ...]) -> None:
    import gzip

    words = [["nan" if row == 5 else f"{x:.3f}" for x in XYZ[row, [2, 0, 1]]] + [*map(str, RGB[row]), "1.5"] for row in range(300)]
    text = head + "".join(separator.join(line) + "\n" for line in words)
    (tmp_path / name).write_bytes(gzip.compress(text.encode()) if name.endswith("gz") else text.encode())
    points = read_points(tmp_path / name, columns=columns)
    same(points, left=5)
    assert points.notes == (NOWHERE,)


def test_ply_of_any_order(tmp_path: Path) -> None:
    plyfile = pytest.importorskip("plyfile")
    for order, colour in (("<", "u1"), (">", "u2"), ("=", "f4")):
        kinds = [("nx", "f4"), ("z", "f8"), *((c, colour) for c in ("blue", "green", "red")), ("y", "f4"), ("x", "f8")]
        table = np.zeros(300, [(name, kind) for name, kind in kinds])
        for number, name in enumerate("xyz"):
            table[name] = XYZ[:, number]
        for number, name in enumerate(("red", "green", "blue")):
            table[name] = RGB[:, number] * {"u1": 1.0, "u2": 257.0, "f4": 1 / 255}[colour]
        table["z"][9] = np.inf
        element = plyfile.PlyElement.describe(table, "vertex")
        plyfile.PlyData([element], byte_order=order).write(str(tmp_path / "scan.ply"))
        points = read_points(tmp_path / "scan.ply")
        same(points, left=9)
        assert points.notes == (NOWHERE,)


def test_files_of_the_libraries_own_tests() -> None:
    """The compressed cloud against its text; LAS against its bytes, by the format's published layout."""
    pytest.importorskip("pypcd4")
    pytest.importorskip("laspy")
    folder = Path(__file__).with_name("scans")
    lines = (folder / "ascii.pcd").read_text().split("DATA ascii\n")[1].split("\n")
    numbers = np.array([line.split() for line in lines if line], float)
    for name in ("ascii.pcd", "binary_compressed.pcd"):
        points = read_points(folder / name)
        assert len(points) == 213 and np.abs(points.xyz - numbers[:, :3]).max() < 1e-5
        assert (points.rgb[:, 0] == numbers[:, 3].astype(np.float32).view(np.uint32) >> 16 & 255).all()
    data = (folder / "autzen.las").read_bytes()
    start, size, count = struct.unpack_from("<I", data, 96)[0], *struct.unpack_from("<HI", data, 105)
    scales, offsets = np.frombuffer(data, "<f8", 3, 131), np.frombuffer(data, "<f8", 3, 155)
    table = np.frombuffer(data, np.uint8, size * count, start).reshape(count, size)
    xyz = np.ascontiguousarray(table[:, :12]).view("<i4") * scales + offsets
    ground = (table[:, 15] & 31) == 2
    points = read_points(folder / "autzen.las")
    assert len(points) == count == 106 and np.allclose(points.xyz, np.concatenate([xyz[ground], xyz[~ground]]), atol=1e-9, rtol=0)
    assert points.parts[0].kind == "floor" and points.parts[0].stop == ground.sum() == 24


def written(folder: Path, ending: str) -> Path:
    path = folder / f"scan{ending}"
    if ending == ".pcd":
        pcd(path, "binary_compressed")
    elif ending in (".las", ".laz"):
        las(path)
    elif ending == ".e57":
        e57(path)
    elif ending == ".npy":
        np.save(path, XYZ)
    elif ending == ".ply":
        plyfile = pytest.importorskip("plyfile")
        table = np.array([tuple(row) for row in XYZ], [("x", "f4"), ("y", "f4"), ("z", "f4")])
        plyfile.PlyData([plyfile.PlyElement.describe(table, "vertex")]).write(str(path))
    else:
        bag(folder / "run", "mcap")
        path = next((folder / "run").glob("*.mcap"))
    return path


@pytest.mark.parametrize("ending", [*READERS, ".mcap"])
def test_damage_gives_a_sentence_or_points(tmp_path: Path, ending: str) -> None:
    """Cut at every tenth, empty, of another format, and with single bytes turned: never a traceback, never points that are no numbers."""
    path = written(tmp_path, ending)
    whole = path.read_bytes()
    assert len(read_points(path)) in (299, 300)
    random = np.random.default_rng(1)
    broken = [whole[: len(whole) * part // 10] for part in range(10)] + [b"junk" * 100, b"\0" * 5000]
    for _ in range(40):
        turned = bytearray(whole)
        turned[int(random.integers(min(len(whole), 600)))] ^= 1 << int(random.integers(8))
        broken.append(bytes(turned))
    refused = 0
    for data in broken:
        path.write_bytes(data)
        try:
            points = read_points(path)
        except InputError as error:
            refused += 1
            assert "\n" not in str(error) and (str(path) in str(error) or "reach to" in str(error))
        else:
            assert np.isfinite(points.xyz).all() and 0 < len(points) <= 300
    assert refused >= 12 and path.exists()


def test_bytes_in_the_wrong_order_are_refused(tmp_path: Path) -> None:
    pypcd4 = pytest.importorskip("pypcd4")
    for xyz in (XYZ, np.round(XYZ)):
        turned = xyz.astype(np.float32).byteswap()
        turned[~np.isfinite(turned)] = 0
        pypcd4.PointCloud.from_xyz_points(turned).save(tmp_path / "scan.pcd")
        with pytest.raises(InputError, match="its bytes are in the wrong order"):
            read_points(tmp_path / "scan.pcd")


def test_other_formats_are_refused_with_a_list(tmp_path: Path) -> None:
    (tmp_path / "scan.fbx").write_bytes(b"Kaydara")
    with pytest.raises(InputError, match=r"end in '.fbx' are not read; .txt, .xyz, .csv, .asc, .ply, .pcd, .las, .laz, .e57, .npy, .mcap"):
        read_points(tmp_path / "scan.fbx")
    (tmp_path / "scan.txt").write_text("1 2 3 4\n")
    for columns, said in (
        (("x", "y", "y", "z"), "each once"),
        (("x", "y", "i", "j"), "are accepted"),
        (("x", "y", "z", "r"), "none of these"),
    ):
        with pytest.raises(InputError, match=said):
            read_points(tmp_path / "scan.txt", columns=columns)
    with pytest.raises(InputError, match="--columns with a name for each"):
        read_points(tmp_path / "scan.txt")
    with pytest.raises(InputError, match="is no recording of ROS"):
        read_points(tmp_path / "scan.txt", topic="/points")


MEASURE = """
import resource, sys
from fairaudit.plugins.navigation.ground import prepare
from fairaudit.plugins.navigation.readers import read_points
import scipy.spatial, pandas
for name in ("pypcd4", "laspy", "plyfile"):
    __import__(name)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
points = prepare(read_points(sys.argv[1]))
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / (points.xyz.nbytes + points.rgb.nbytes))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the greatest memory is in other units elsewhere")
@pytest.mark.parametrize("ending", [".npy", ".pcd", ".laz"])
def test_memory_is_at_most_four_times_the_points(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"scan{ending}"
    count = 700_000
    xyz = np.random.default_rng(0).uniform(0, [50, 40, 0.01], (count, 3)).astype(np.float32)
    xyz[: count // 2, 2] += 2.5
    if ending == ".npy":
        np.save(path, xyz)
    elif ending == ".pcd":
        pypcd4 = pytest.importorskip("pypcd4")
        pypcd4.PointCloud.from_xyz_points(xyz).save(path, encoding=pypcd4.Encoding.BINARY_COMPRESSED)
    else:
        laspy = pytest.importorskip("laspy")
        content = laspy.LasData(laspy.LasHeader(point_format=7, version="1.4"))
        content.x, content.y, content.z = xyz.T
        content.write(path)
    done = subprocess.run([sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 4.0
