"""Point clouds of formats that a library reads: PLY, PCD, LAS and LAZ, E57, npy, and the bags of ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import islice
from math import atan2
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown
from fairaudit.libraries import library

if TYPE_CHECKING:
    from fairaudit.plugins.navigation.grids import OccupancyGrid

__all__ = ["BAGS", "READERS", "Block", "is_bag", "read_message"]

Block = tuple[NDArray[np.float64], NDArray[np.uint8], str | None]
"""Coordinates and colours of some points, and their class if the file says one."""

GREY = 128
BAGS = (".mcap", ".db3", ".bag")
CLOUD, GRID = "sensor_msgs/msg/PointCloud2", "nav_msgs/msg/OccupancyGrid"
KINDS = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
COLOURS = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
GROUND = 2


@contextmanager
def _said(path: Path, what: str) -> Iterator[None]:
    """Say in one sentence what a library does not read."""
    try:
        yield
    except InputError:
        raise
    except (Exception, MemoryError) as error:  # what a library raises on damaged bytes is not to be foreseen
        lines = str(error).strip().splitlines() or [type(error).__name__]
        why = "it is damaged or cut short" if isinstance(error, (KeyError, IndexError)) else lines[0][:200]
        raise InputError(f"{path}: this is not {what}: {why}") from None


def _block(path: Path, columns: Mapping[str, Any]) -> Block:
    """Coordinates and colours of named columns, whatever their order and types."""
    for axis in "xyz":
        if axis not in columns:
            raise InputError(f"{path}: the points have no property {shown(axis)}; x, y and z are needed")
    xyz = np.empty((len(columns["x"]), 3))
    for number, axis in enumerate("xyz"):
        xyz[:, number] = columns[axis]
    return xyz, _colours(path, columns, len(xyz)), None


def _colours(path: Path, columns: Mapping[str, Any], count: int) -> NDArray[np.uint8]:
    """Colours of 8 or 16 bits, of 0 to 1, or packed into the bits of one number, as PCL and ROS have them; grey if there are none."""
    for name in ("rgb", "rgba"):
        if name in columns and np.asarray(columns[name]).dtype.itemsize == 4:
            packed = np.ascontiguousarray(columns[name])
            bits = packed.view(packed.dtype.newbyteorder("=").str.replace("f", "u").replace("i", "u"))
            bits = bits if packed.dtype.isnative else bits.byteswap()
            return np.stack([(bits >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)], axis=1)
    names = next((names for names in COLOURS if all(name in columns for name in names)), None)
    rgb = np.full((count, 3), GREY, np.uint8)
    if names is None or not count:
        return rgb
    values = [np.asarray(columns[name]) for name in names]
    most = max(float(value.max()) for value in values)
    scale = 255.0 if most <= 1 and values[0].dtype.kind == "f" else 1.0 if most <= 255 else 1 / 256
    if not (min(float(value.min()) for value in values) >= 0 and most <= 65535):
        raise InputError(f"{path}: a colour in {', '.join(names)} is out of range; 0 to 255, 0 to 65,535 or 0 to 1 is accepted")
    for number, value in enumerate(values):
        rgb[:, number] = value if value.dtype == np.uint8 else value * scale + (scale > 1) / 2
    return rgb


def _ply(path: Path, _columns: Sequence[str], _notes: list[str]) -> Iterator[Block]:
    plyfile = library("plyfile", "navigation")
    with _said(path, "a PLY file of points"):
        content = plyfile.PlyData.read(str(path))
        if "vertex" not in content:
            raise InputError(f"{path}: this is not a PLY file of points: it has no element named vertex")
        data = content["vertex"].data
        yield _block(path, {name: data[name] for name in data.dtype.names or ()})


def _pcd(path: Path, _columns: Sequence[str], notes: list[str]) -> Iterator[Block]:
    pypcd4 = library("pypcd4", "scans")
    with _said(path, "a PCD file"):
        cloud = pypcd4.PointCloud.from_path(path)
        data, meta = cloud.pc_data.reshape(-1), cloud.metadata
        if len(data) != meta.points:
            raise InputError(f"{path}: the header says {meta.points:,} points and {len(data):,} are there; the file is cut short")
        if tuple(meta.viewpoint) != (0, 0, 0, 1, 0, 0, 0):
            notes.append("the file says from where it was seen; its points were not moved by that")
        yield _block(path, {name: data[name] for name in data.dtype.names})


def _las(path: Path, _columns: Sequence[str], notes: list[str]) -> Iterator[Block]:
    laspy = library("laspy", "scans")
    with _said(path, "a LAS or LAZ file"):
        content = laspy.read(path)
        said = content.header.point_count
        if len(content.points) != said:
            raise InputError(f"{path}: the header says {said:,} points and {len(content.points):,} are there; the file is cut short")
        names = [name for name in ("red", "green", "blue") if name in content.point_format.dimension_names]
        xyz, rgb, _ = _block(path, {name: content[name] for name in ("x", "y", "z", *names)})
        ground = np.asarray(content.classification) == GROUND
        if ground.any():
            notes.append(f"the floor is that of the {int(ground.sum()):,} points of the class ground")
        for chosen, kind in ((ground, "floor"), (~ground, None)):
            if chosen.all():
                yield xyz, rgb, kind
            elif chosen.any():
                yield xyz[chosen], rgb[chosen], kind


def _e57(path: Path, _columns: Sequence[str], notes: list[str]) -> Iterator[Block]:
    pye57 = library("pye57", "e57")
    with _said(path, "an E57 file"):
        pye57.libe57.ImageFile(str(path), "r").close()  # the class below leaves a half-made object behind if this fails
        content = pye57.E57(str(path))
        if content.scan_count > 1:
            notes.append(f"{content.scan_count} scans were joined, each by its own pose")
        names = {"cartesianX": "x", "cartesianY": "y", "cartesianZ": "z", "colorRed": "red", "colorGreen": "green", "colorBlue": "blue"}
        for number in range(content.scan_count):
            read = content.read_scan(number, colors=True, ignore_missing_fields=True)
            yield _block(path, {said: read[name] for name, said in names.items() if name in read})
        content.close()


def _npy(path: Path, columns: Sequence[str], _notes: list[str]) -> Iterator[Block]:
    with _said(path, "an npy file of numbers"):
        table = np.load(path, mmap_mode="r", allow_pickle=False)
        if table.dtype.names:
            yield _block(path, {name: table[name].reshape(-1) for name in table.dtype.names})
            return
        usual = {3: "xyz", 6: "xyzrgb"}.get(table.shape[1] if table.ndim == 2 else 0, "")
        if table.ndim != 2 or table.dtype.kind not in "fiu" or len(columns or usual) != table.shape[1]:
            said = f" with the columns {', '.join(columns)}" if columns else ", or --columns with a name for each column,"
            raise InputError(f"{path}: its shape is {table.shape} and its type {table.dtype}; N×3 or N×6 numbers{said} are accepted")
        yield _block(path, {name: table[:, number] for number, name in enumerate(columns or usual)})


def is_bag(path: Path) -> bool:
    """Whether a path names a recording of ROS."""
    return path.suffix.lower() in BAGS or (path / "metadata.yaml").is_file()


def read_message(path: Path, topic: str | None = None, which: str | None = None) -> tuple[Any, str]:
    """Read the point cloud or the occupancy grid of a recording of ROS 1 or 2, and in which frame it is; `which` is first or last."""
    reading, types = library("rosbags.highlevel", "scans"), library("rosbags.typesys", "scans")
    with _said(path, "a recording of ROS"), reading.AnyReader([path], default_typestore=types.get_typestore(types.Stores.LATEST)) as bag:
        known = {link.topic: link for link in bag.connections if link.msgtype in (CLOUD, GRID)}
        listed = ", ".join(f"{name} ({link.msgtype.rsplit('/', 1)[1]}, {link.msgcount})" for name, link in known.items())
        if not known:
            raise InputError(f"{path}: no topic of this recording has messages of the type PointCloud2 or OccupancyGrid")
        if topic is None and len(known) > 1:
            raise InputError(f"{path} has several topics: {listed}; topic says which")
        if topic is not None and topic not in known:
            raise InputError(f"{path} has no topic {shown(topic)} with a PointCloud2 or OccupancyGrid; {nearest(topic, known)}")
        link = known[topic or next(iter(known))]
        if link.msgcount > 1 and which is None:
            raise InputError(f'{path}: {link.topic} has {link.msgcount} messages; message = "first" or "last" says which')
        raws = (raw for _, _, raw in bag.messages(connections=[link]))
        kept = deque(raws if which == "last" else islice(raws, 1), maxlen=1)
        if not kept:
            raise InputError(f"{path}: {link.topic} has no message")
        message = bag.deserialize(kept[0], link.msgtype)
        return message, str(message.header.frame_id)


def read_bag(path: Path, notes: list[str], topic: str | None, which: str | None) -> Iterator[Block]:
    """Points of a PointCloud2."""
    message, frame = read_message(path, topic, which)
    with _said(path, "a recording with a PointCloud2"):
        if not hasattr(message, "point_step"):
            raise InputError(f"{path}: this topic has an OccupancyGrid, which is a map and no scan")
        order = "><"[not message.is_bigendian]
        formats = [(order + KINDS[field.datatype - 1], (field.count,) if field.count > 1 else ()) for field in message.fields]
        named: Any = {"names": [f.name for f in message.fields], "formats": formats, "offsets": [f.offset for f in message.fields]}
        named["itemsize"] = message.point_step
        kind = np.dtype(named)
        steps = (message.row_step, message.point_step)
        data = np.ndarray((message.height, message.width), kind, np.ascontiguousarray(message.data), strides=steps).reshape(-1)
        notes.append(f"the points are in the frame {shown(frame)}; transforms are not applied")
        yield _block(path, {name: data[name] for name in kind.names or ()})


def read_bag_grid(path: Path, topic: str | None, which: str | None, free_below: int = 20) -> OccupancyGrid | None:
    """Occupancy map of a recording, or None if the topic has a point cloud; what is free is by default what map_saver writes as free."""
    from fairaudit.plugins.navigation.grids import UNKNOWN, Frame, OccupancyGrid

    message, _ = read_message(path, topic, which)
    if hasattr(message, "point_step"):
        return None
    with _said(path, "a recording with an OccupancyGrid"):
        info, turn = message.info, message.info.origin.orientation
        if max(abs(turn.x), abs(turn.y)) > 1e-6:
            raise InputError(f"{path}: the map is tilted; only maps that are level are accepted")
        cells = np.asarray(message.data, np.int8).reshape(info.height, info.width)[::-1]
        at, yaw = info.origin.position, 2 * atan2(turn.z, turn.w) if turn.z else 0.0
        frame = Frame(at.x, at.y, round(float(info.resolution), 6), info.height, info.width, yaw)
        return OccupancyGrid(frame, np.where((cells >= 0) & (cells <= 100), cells, UNKNOWN).astype(np.int8), free_below)


READERS: Mapping[str, Callable[[Path, Sequence[str], list[str]], Iterator[Block]]] = {
    ".ply": _ply, ".pcd": _pcd, ".las": _las, ".laz": _las, ".e57": _e57, ".npy": _npy,
}  # fmt: skip
