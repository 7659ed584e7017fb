"""Readers of scans: S3DIS folders, text of points (also compressed by gzip), PLY, PCD, LAS and LAZ, E57, npy, and the bags of ROS."""

from __future__ import annotations

import gzip
import hashlib
import io
import re
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice
from math import atan2
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown
from fairaudit.libraries import library
from fairaudit.plugins.navigation.grids import UNKNOWN, Frame, OccupancyGrid

CLASSES = ("ceiling", "floor", "wall", "beam", "column", "window", "door", "table", "chair", "sofa", "bookcase", "board", "clutter")
"""The classes of S3DIS annotations; anything else is clutter."""

Block = tuple[NDArray[np.float64], NDArray[np.uint8], str | None]
"""Coordinates and colours of some points, and their class if the file says one."""

TEXTS = (".txt", ".xyz", ".csv", ".asc", ".txt.gz", ".xyz.gz", ".csv.gz", ".asc.gz")
BAGS = (".mcap", ".db3", ".bag")
CLOUD, GRID = "sensor_msgs/msg/PointCloud2", "nav_msgs/msg/OccupancyGrid"
KINDS = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
COLOURS = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
GREY, GROUND = 128, 2
LARGEST, LEAST = 1e9, 1e-9
BLOCK, LONGEST_LINE = 1 << 22, 1 << 16
_NUMBER = re.compile(rb"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_NOWHERE = re.compile(rb"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_BAD_BYTE = b"\x10"


@dataclass(frozen=True)
class Part:
    """Consecutive points of a scan that belong to one object."""

    start: int
    stop: int
    room: str | None = None  # its folder
    kind: str | None = None  # one of CLASSES, or None without annotations
    name: str = ""  # the file, without its ending


@dataclass(frozen=True)
class Points:
    """A coloured point cloud whose points may be labelled."""

    xyz: NDArray[np.float64] = field(repr=False)  # n × 3, in metres; z points up
    rgb: NDArray[np.uint8] = field(repr=False)  # n × 3; grey where the file has none
    parts: tuple[Part, ...] = field(repr=False)  # objects; they cover all points in order
    files: dict[str, str] = field(repr=False)  # path within the scan and SHA-256 of each file that was read
    notes: tuple[str, ...] = ()  # what was noticed or repaired while reading

    def only(self, kept: NDArray[np.bool_]) -> Points:
        """Return the points that are kept, each still of its object."""
        before = np.concatenate([[0], np.cumsum(kept)])
        moved = (replace(part, start=int(before[part.start]), stop=int(before[part.stop])) for part in self.parts)
        return replace(self, xyz=self.xyz[kept], rgb=self.rgb[kept], parts=tuple(part for part in moved if part.stop > part.start))

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.xyz)

    @property
    def rooms(self) -> tuple[str, ...]:
        """Names of the rooms, in order."""
        return tuple(dict.fromkeys(part.room for part in self.parts if part.room is not None))

    @property
    def sha256(self) -> str:
        """Digest of the scan: of its only file, or of the list of the digests and paths of its files."""
        if len(self.files) == 1:
            return next(iter(self.files.values()))
        listed = "".join(f"{digest}  {name}\n" for name, digest in sorted(self.files.items()))
        return hashlib.sha256(listed.encode()).hexdigest()


def read_points(
    path: str | Path,
    *,
    rooms: Sequence[str] = (),
    columns: Sequence[str] = (),
    topic: str | None = None,
    message: str | None = None,
) -> Points:
    r"""Read a scan.

    Parameters
    ----------
    path : path-like
        A folder of S3DIS (an area with its rooms, or one room); text with one point per line (.txt, .xyz, .csv, .asc, also .gz; colours 0
        to 255); .ply, .pcd, .las, .laz, .e57, .npy; a recording of ROS (.mcap, .db3, .bag, or a folder).
    rooms : sequence of str
        Only these rooms of an area; all by default.
    columns : sequence of str
        What the columns of text or npy are: x, y, z, r, g, b in any order, any other name for what is left out. By default the names in
        the first line, else x, y, z and, of six, r, g, b.
    topic, message : str, optional
        Topic of a recording, and "first" or "last" where it has several messages.

    Notes
    -----
    There is at least one point, and points are as the file has them; `ground.prepare` makes them stand upright on a level floor. Those
    without finite coordinates are left out, and counted in the notes. The message of an error names the file and the line.

    A room of S3DIS is read from its annotations, which hold each of its points once, with a class; a room without annotations is read from
    ``room/room.txt``. The byte 0x10 of a few published files is read as a blank or the digit 0, whichever gives the line its columns.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "scan.txt"
    >>> _ = file.write_text("0 0 0 255 0 0\n1 2.5 0.1 0 255 0\n")
    >>> points = read_points(file)
    >>> len(points), points.xyz[1].tolist(), points.rgb[0].tolist()
    (2, [1.0, 2.5, 0.1], [255, 0, 0])
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: there is no such file or folder")
    if rooms and (is_bag(path) or not path.is_dir()):
        raise InputError(f"{path} is one scan; rooms can be chosen in an S3DIS area only")
    if (topic or message) and not is_bag(path):
        raise InputError(f"{path} is no recording of ROS; topic and message do not go with it")
    if message not in (None, "first", "last"):
        raise InputError(f"message is {shown(message)}; first or last is accepted")
    if columns and not path.name.lower().endswith((*TEXTS, ".npy")):
        raise InputError(f"{path} says itself what its columns are; columns go with text and npy")
    colours = sum(name in ("r", "g", "b") for name in columns)
    if columns and (len(set(columns) & set("xyz")) < 3 or colours not in (0, 3) or any(columns.count(name) > 1 for name in "xyzrgb")):
        raise InputError(f"the columns are {shown(','.join(columns))}; x, y, z, and r, g, b or none of these, each once, are accepted")
    ending, notes = path.suffix.lower(), list[str]()
    if path.is_dir() and not is_bag(path):
        return _joined(path, _folders(path, rooms, notes), notes)
    reader = READERS.get(ending) or (_text if path.name.lower().endswith(TEXTS) else None)
    if is_bag(path) or reader:
        blocks = reader(path, columns, notes) if reader else _bag(path, notes, topic, message)
        return _joined(path, [(path, None, None, blocks)], notes)
    known = ", ".join((*TEXTS[:4], *READERS, *BAGS))
    raise InputError(f"{path}: scans that end in {shown(ending)} are not read; {known}, and folders of S3DIS and ROS are")


_Source = tuple[Path, str | None, str | None, Iterator[Block]]  # a file, its room, its class, and its points


def _joined(path: Path, sources: Iterable[_Source], notes: list[str]) -> Points:
    """Blocks of points as they are read, joined once at the end, so that at most two copies exist."""
    xyz, rgb, parts, files = list[NDArray[np.float64]](), list[NDArray[np.uint8]](), list[Part](), dict[str, str]()
    count, root = 0, path if path.is_dir() else path.parent
    for file, room, kind, blocks in sources:
        first, read = count, 0
        for points, colours, own in blocks:
            whole = np.isfinite(points).all(axis=1)
            xyz.append(points if whole.all() else points[whole])
            rgb.append(colours if whole.all() else colours[whole])
            start, read, count = count, read + len(points), count + len(xyz[-1])
            if start > first and parts[-1].kind == (own or kind):
                start = parts.pop().start
            if count > start:
                parts.append(Part(start, count, room, own or kind, file.name.removesuffix(".gz").rsplit(".", 1)[0]))
        left = read - (count - first)
        if count == first:
            raise InputError(f"{file}: there are no points in this file" + (f" with finite coordinates, of {left:,}" if left else ""))
        if left:
            notes.append(f"{left:,} of {read:,} points have no finite coordinates and were left out")
        for each in sorted(part for part in file.iterdir() if part.is_file()) if file.is_dir() else [file]:
            with each.open("rb") as opened:
                files[each.relative_to(root).as_posix()] = hashlib.file_digest(opened, "sha256").hexdigest()
    all_xyz, xyz = xyz[0] if len(xyz) == 1 else np.concatenate(xyz), []
    all_rgb = rgb[0] if len(rgb) == 1 else np.concatenate(rgb)
    far = max(float(all_xyz.max()), -float(all_xyz.min()))
    if far > LARGEST or 0 < far < LEAST:
        raise InputError(f"the coordinates of {parts[0].name} reach to {far:g}; this is no scan, unless its bytes are in the wrong order")
    return Points(all_xyz, all_rgb, tuple(parts), files, tuple(dict.fromkeys(notes)))


def _natural(path: Path) -> list[Any]:
    """Order names as people do: room_2 before room_10."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", path.name) if part]


def _folders(path: Path, rooms: Sequence[str], notes: list[str]) -> Iterator[_Source]:
    def is_room(folder: Path) -> bool:
        return (folder / "Annotations").is_dir() or (folder / f"{folder.name}.txt").is_file()

    folders = [path] if is_room(path) else sorted((f for f in path.iterdir() if f.is_dir() and is_room(f)), key=_natural)
    if not folders:
        raise InputError(f"{path}: there is no room in this folder; S3DIS has room/room.txt or room/Annotations/class_1.txt")
    known = [folder.name for folder in folders]
    for room in rooms:
        if room not in known:
            raise InputError(f"{path} has no room {shown(room)}; {nearest(room, known)}")
    for folder in (folder for folder in folders if not rooms or folder.name in rooms):
        annotations, whole = folder / "Annotations", folder / f"{folder.name}.txt"
        files = sorted((f for f in annotations.glob("*.txt") if f.is_file() and f.name[0] != "."), key=_natural)
        for file in files:
            kind = file.stem.rsplit("_", 1)[0]
            if kind not in CLASSES:
                notes.append(f"the class {shown(kind)} is not one of S3DIS; its points are clutter")
            yield file, folder.name, kind if kind in CLASSES else "clutter", _text(file, (), notes)
        if not files and not whole.is_file():
            raise InputError(f"{annotations}: there are no annotations in this folder; class_1.txt was expected")
        if not files:
            notes.append(f"room {folder.name} has no annotations; its points have no class")
            yield whole, folder.name, None, _text(whole, (), notes)


def _text(path: Path, names: Sequence[str], notes: list[str]) -> Iterator[Block]:
    """Points of a text file, in blocks of whole lines."""
    separator, after = b"", 1
    try:
        with gzip.open(path) if path.name.lower().endswith(".gz") else path.open("rb") as file:
            while lines := file.readlines(BLOCK):
                line, after = after, after + len(lines)
                if max(map(len, lines)) > LONGEST_LINE:
                    what = f"more than {LONGEST_LINE:,} characters; a text file with one point per line was expected"
                    long = next(n for n, text in enumerate(lines, start=line) if len(text) > LONGEST_LINE)
                    raise InputError(f"{path}: line {long}: {what}")
                if not separator and not b"".join(lines).isspace():
                    separator, names = _layout(path, lines, line, names)
                if separator not in (b"", b" "):
                    lines = [text.replace(separator, b" ") for text in lines]
                if not b"".join(lines).isspace():
                    yield _numbers(path, lines, line, names, notes)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _layout(path: Path, lines: list[bytes], line: int, names: Sequence[str]) -> tuple[bytes, Sequence[str]]:
    """Find the separator and the names of the columns by the first line that is not blank; a line of names becomes a blank one."""
    position = next(n for n, text in enumerate(lines) if text.strip())
    separator = next((mark for mark in (b",", b";") if mark in lines[position]), b" ")
    words = lines[position].lstrip(b"/#").replace(separator, b" ").split()
    heads = [{"red": "r", "green": "g", "blue": "b"}.get(head, head) for head in (w.decode("latin-1").strip('"').lower() for w in words)]
    if set(heads) >= set("xyz") and all(heads.count(name) == 1 for name in "xyz"):
        lines[position] = b"\n"
        return separator, names or heads
    if not names and _BAD_BYTE in lines[position]:
        return separator, "xyzrgb"  # the files with this byte have six columns
    if not names and len(words) not in (3, 6):
        said = f"the number of columns is {len(words)}; x y z or x y z r g b was expected, or --columns with a name for each"
        raise InputError(f"{path}: line {line + position}: {said}")
    return separator, names or "xyzrgb"[: len(words)]


def _numbers(path: Path, lines: list[bytes], line: int, names: Sequence[str], notes: list[str]) -> Block:
    """Parse a block: fast if all is regular, else line by line."""
    values = _parsed(b"".join(lines), names)
    if values is None:
        rows = (_row(path, text, number, names, notes) for number, text in enumerate(lines, start=line))
        values = np.array([row for row in rows if row])
    xyz = np.ascontiguousarray(values[:, [list(names).index(axis) for axis in "xyz"]])
    if not set(names) >= set("rgb"):
        return xyz, np.full(xyz.shape, GREY, np.uint8), None
    return xyz, values[:, [list(names).index(colour) for colour in "rgb"]].astype(np.uint8), None


def _parsed(block: bytes, names: Sequence[str]) -> NDArray[np.float64] | None:
    """Numbers of a block, or None if anything about it is irregular."""
    import pandas as pd

    if b"\0" in block:  # pandas 2.2 reads 6\0 as 6
        return None
    try:
        frame = pd.read_csv(
            io.BytesIO(block), sep=r"\s+", header=None, dtype=np.float64, quoting=3, engine="c", encoding="latin-1", low_memory=False
        )
    except (ValueError, OverflowError):  # ParserError and EmptyDataError are ValueErrors
        return None
    values = frame.to_numpy()
    if values.shape[1] != len(names) or not np.isfinite(values).all():  # a short line is filled up with nan
        return None
    colours = values[:, [number for number, name in enumerate(names) if name in ("r", "g", "b")]]
    return values if ((colours >= 0) & (colours <= 255) & (colours == np.floor(colours))).all() else None


def _fault(text: bytes, names: Sequence[str]) -> str:
    words = text.split()
    if not words:
        return ""
    for position, word in enumerate(words):
        said = shown(word.decode("ascii", "backslashreplace"))
        colour = len(words) == len(names) and names[position] in ("r", "g", "b")
        if _NOWHERE.fullmatch(word) and not colour:
            continue
        if not _NUMBER.fullmatch(word):
            return f"{said} is not a number such as 1.25"
        if not np.isfinite(float(word)):
            return f"{said} is too large"
        if colour and not (float(word).is_integer() and 0 <= float(word) <= 255):
            return f"the colour {said} is not an integer from 0 to 255"
    return "" if len(words) == len(names) else f"the number of columns is {len(words)}; {len(names)} were expected"


def _row(path: Path, text: bytes, line: int, names: Sequence[str], notes: list[str]) -> list[float]:
    """Numbers of a line; the byte 0x10 in it is a blank or the digit 0, whichever gives the line its columns."""
    fault = _fault(text, names)
    if fault and _BAD_BYTE in text:
        fault = "it holds the byte 0x10, and neither a blank nor the digit 0 in its place gives a point"
        for meant, said in ((b"0", "the digit 0"), (b" ", "a blank")):
            if not _fault(candidate := text.replace(_BAD_BYTE, meant), names):
                mended, note, fault = candidate, said, ""
        if not fault:
            text, digest = mended, hashlib.sha256(path.read_bytes()).hexdigest()
            notes.append(f"{path.name}, line {line}: the byte 0x10 was read as {note} (SHA-256 of the file {digest})")
    if fault:
        raise InputError(f"{path}: line {line}: {fault}")
    return [float(word) for word in text.split()]


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


def _message(path: Path, topic: str | None, which: str | None) -> tuple[Any, str]:
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


def _bag(path: Path, notes: list[str], topic: str | None, which: str | None) -> Iterator[Block]:
    """Points of a PointCloud2."""
    message, frame = _message(path, topic, which)
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
    message, _ = _message(path, topic, which)
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
