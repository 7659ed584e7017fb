"""Readers of scans: S3DIS folders, text files of points (also compressed by gzip), and PLY."""

from __future__ import annotations

import gzip
import hashlib
import io
import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown

__all__ = ["CLASSES", "Part", "Points", "read_points"]

CLASSES = ("ceiling", "floor", "wall", "beam", "column", "window", "door", "table", "chair", "sofa", "bookcase", "board", "clutter")
"""The classes of S3DIS annotations; anything else is clutter."""

GREY = 128
BLOCK = 1 << 24
LONGEST_LINE = 1 << 16
_NUMBER = re.compile(rb"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_BAD_BYTE = b"\x10"


@dataclass(frozen=True)
class Part:
    """Consecutive points of a scan that belong to one object.

    Attributes
    ----------
    start, stop : int
        Range of the points.
    room : str or None
        The room's folder.
    kind : str or None
        One of `CLASSES`, or None without annotations.
    name : str
        The file, without its ending.
    """

    start: int
    stop: int
    room: str | None = None
    kind: str | None = None
    name: str = ""


@dataclass(frozen=True)
class Points:
    """A coloured point cloud whose points may be labelled.

    Attributes
    ----------
    xyz : array of float64, shape (n, 3)
        Coordinates in metres; z points up.
    rgb : array of uint8, shape (n, 3)
        Colours; grey where the file has none.
    parts : tuple of Part
        Objects; they cover all points in order.
    files : dict of str to str
        Each file that was read, by its path within the scan, and the SHA-256 of its bytes.
    notes : tuple of str
        What was noticed or repaired while reading.
    """

    xyz: NDArray[np.float64] = field(repr=False)
    rgb: NDArray[np.uint8] = field(repr=False)
    parts: tuple[Part, ...] = field(repr=False)
    files: dict[str, str] = field(repr=False)
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.xyz)

    @property
    def rooms(self) -> tuple[str, ...]:
        """Names of the rooms, in order."""
        return tuple(dict.fromkeys(part.room for part in self.parts if part.room is not None))

    @property
    def labelled(self) -> bool:
        """Whether every point has a class."""
        return all(part.kind is not None for part in self.parts)

    @property
    def sha256(self) -> str:
        """Digest of the scan: of its only file, or of the list of the digests and paths of its files."""
        if len(self.files) == 1:
            return next(iter(self.files.values()))
        listed = "".join(f"{digest}  {name}\n" for name, digest in sorted(self.files.items()))
        return hashlib.sha256(listed.encode()).hexdigest()


def read_points(path: str | Path, *, rooms: Sequence[str] = ()) -> Points:
    r"""Read a scan.

    Parameters
    ----------
    path : path-like
        A folder of S3DIS (an area with its rooms, or one room), a text file with lines ``x y z`` or ``x y z r g b`` (colours 0 to 255;
        compressed if its name ends in ``.gz``), or a ``.ply`` file.
    rooms : sequence of str
        Only these rooms of an area; all by default.

    Returns
    -------
    Points
        At least one point.

    Raises
    ------
    InputError
        If it is not such a scan; the message names the file and the line.

    Notes
    -----
    A room of S3DIS is read from its annotations, which hold each of its points once, with a class; a room without annotations is read from
    ``room/room.txt``. A few published files hold the byte 0x10 in place of a character. It is read as a blank if the line then has as many
    columns as the others, else as the digit 0 if the line then has; both are noted with the line and the digest of the file, anything else
    is an error.

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
    reader = _Collected(path)
    if path.is_dir():
        _read_folders(reader, path, rooms)
    elif rooms:
        raise InputError(f"{path} is one file; rooms can be chosen in an S3DIS area only")
    elif path.suffix.lower() == ".ply":
        reader.add(path, _ply(path))
    else:
        reader.add(path, _text(path, reader.notes))
    return reader.points()


class _Collected:
    """Blocks of points as they are read; joined once at the end, so that at most two copies exist."""

    def __init__(self, root: Path) -> None:
        self.root = root if root.is_dir() else root.parent
        self.xyz: list[NDArray[np.float64]] = []
        self.rgb: list[NDArray[np.uint8]] = []
        self.parts: list[Part] = []
        self.files: dict[str, str] = {}
        self.notes: list[str] = []
        self.count = 0

    def add(self, path: Path, blocks: Iterator[_Block], room: str | None = None, kind: str | None = None) -> None:
        start = self.count
        for xyz, rgb in blocks:
            self.xyz.append(xyz)
            self.rgb.append(rgb)
            self.count += len(xyz)
        if self.count == start:
            raise InputError(f"{path}: there are no points in this file")
        name = path.name.removesuffix(".gz").rsplit(".", 1)[0]
        self.parts.append(Part(start, self.count, room, kind, name))
        with path.open("rb") as file:
            self.files[path.relative_to(self.root).as_posix()] = hashlib.file_digest(file, "sha256").hexdigest()

    def points(self) -> Points:
        xyz, self.xyz = np.concatenate(self.xyz), []
        rgb, self.rgb = np.concatenate(self.rgb), []
        return Points(xyz, rgb, tuple(self.parts), self.files, tuple(dict.fromkeys(self.notes)))


_Block = tuple[NDArray[np.float64], NDArray[np.uint8]]


def _natural(path: Path) -> list[Any]:
    """Order names as people do: room_2 before room_10."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", path.name) if part]


def _is_room(folder: Path) -> bool:
    return (folder / "Annotations").is_dir() or (folder / f"{folder.name}.txt").is_file()


def _read_folders(reader: _Collected, path: Path, rooms: Sequence[str]) -> None:
    folders = [path] if _is_room(path) else sorted((f for f in path.iterdir() if f.is_dir() and _is_room(f)), key=_natural)
    if not folders:
        raise InputError(
            f"{path}: there is no room in this folder; room/room.txt or room/Annotations/class_1.txt was expected, as in S3DIS"
        )
    known = [folder.name for folder in folders]
    for room in rooms:
        if room not in known:
            raise InputError(f"{path} has no room {shown(room)}; {nearest(room, known)}")
    for folder in folders:
        if rooms and folder.name not in rooms:
            continue
        annotations = folder / "Annotations"
        files = sorted((f for f in annotations.glob("*.txt") if f.is_file() and f.name[0] != "."), key=_natural)
        for file in files:
            kind = file.stem.rsplit("_", 1)[0]
            if kind not in CLASSES:
                reader.notes.append(f"the class {shown(kind)} is not one of S3DIS; its points are clutter")
                kind = "clutter"
            reader.add(file, _text(file, reader.notes), folder.name, kind)
        if not files:
            whole = folder / f"{folder.name}.txt"
            if not whole.is_file():
                raise InputError(f"{annotations}: there are no annotations in this folder; class_1.txt was expected")
            reader.notes.append(f"room {folder.name} has no annotations; its points have no class")
            reader.add(whole, _text(whole, reader.notes), folder.name)


def _text(path: Path, notes: list[str]) -> Iterator[_Block]:
    """Points of a text file, in blocks of whole lines."""
    columns = 0
    try:
        with gzip.open(path) if path.name.endswith(".gz") else path.open("rb") as file:
            for block, line in _blocks(file):
                columns = columns or _columns(block, line)
                yield _numbers(path, block, line, columns, notes)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    except _BadLineError as error:
        raise InputError(f"{path}: line {error.line}: {error.what}") from None


class _BadLineError(Exception):
    def __init__(self, line: int, what: str) -> None:
        super().__init__(what)
        self.line, self.what = line, what


def _blocks(file: IO[bytes] | gzip.GzipFile) -> Iterator[tuple[bytes, int]]:
    """Blocks of whole lines that are not all blank, each with the number of its first line."""
    line, rest = 1, b""
    while True:
        read = file.read(BLOCK)
        end = read.rfind(b"\n") + 1
        if read and not end:
            rest += read
            if len(rest) > LONGEST_LINE:
                raise _BadLineError(line, f"more than {LONGEST_LINE:,} characters; a text file with one point per line was expected")
            continue
        block, rest = rest + read[:end], read[end:]
        if not read:
            block, rest = block + rest, b""
        if block.strip():
            yield block, line
        if not read:
            return
        line += block.count(b"\n")


def _columns(block: bytes, line: int) -> int:
    """Three or six, from the first line that is not blank."""
    number, words = next((n, t.split()) for n, t in enumerate(block.split(b"\n"), start=line) if t.strip())
    if _BAD_BYTE in b" ".join(words):
        return 6  # the files with this byte have six columns
    if len(words) not in (3, 6):
        raise _BadLineError(number, f"there are {len(words)} columns; x y z or x y z r g b, separated by blanks, was expected")
    return len(words)


def _numbers(path: Path, block: bytes, line: int, columns: int, notes: list[str]) -> _Block:
    """Parse a block: fast if nothing is wrong with it, else line by line to say what."""
    if _BAD_BYTE in block:
        block = _repaired(path, block, line, columns, notes)
    values = _parsed(block, columns)
    if values is None:
        raise _examined(block, line, columns)
    xyz = np.ascontiguousarray(values[:, :3])
    if columns == 3:
        return xyz, np.full(xyz.shape, GREY, np.uint8)
    return xyz, values[:, 3:].astype(np.uint8)


def _parsed(block: bytes, columns: int) -> NDArray[np.float64] | None:
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
    if values.shape[1] != columns or not np.isfinite(values).all():
        return None
    colours = values[:, 3:]
    if columns == 6 and not ((colours >= 0) & (colours <= 255) & (colours == np.floor(colours))).all():
        return None
    return values


def _examined(block: bytes, line: int, columns: int) -> _BadLineError:
    """Find the first line of a block that is not as it should be."""
    number = line
    for number, text in enumerate(block.split(b"\n"), start=line):
        what = _fault(text.removesuffix(b"\r"), columns)
        if what:
            return _BadLineError(number, what)
    return _BadLineError(line, f"the lines from here to line {number} cannot be read as numbers separated by blanks")


def _fault(text: bytes, columns: int) -> str:
    words = text.split()
    if not words:
        return ""
    for position, word in enumerate(words):
        said = shown(word.decode("ascii", "backslashreplace"))
        if not _NUMBER.fullmatch(word):
            return f"{said} is not a finite number such as 1.25"
        if not np.isfinite(float(word)):
            return f"{said} is too large"
        if len(words) == columns and position >= 3 and not (float(word).is_integer() and 0 <= float(word) <= 255):
            return f"the colour {said} is not an integer from 0 to 255"
    return "" if len(words) == columns else f"there are {len(words)} columns where the first line has {columns}"


def _repaired(path: Path, block: bytes, line: int, columns: int, notes: list[str]) -> bytes:
    """Replace the byte 0x10 by a blank or by the digit 0, whichever gives the line its columns."""
    lines = block.split(b"\n")
    for position, text in enumerate(lines):
        if _BAD_BYTE not in text:
            continue
        for meant, said in ((b" ", "a blank"), (b"0", "the digit 0")):
            candidate = text.replace(_BAD_BYTE, meant)
            if len(candidate.split()) == columns and not _fault(candidate.removesuffix(b"\r"), columns):
                with path.open("rb") as file:
                    digest = hashlib.file_digest(file, "sha256").hexdigest()
                notes.append(f"{path.name}, line {line + position}: the byte 0x10 was read as {said} (SHA-256 of the file {digest})")
                lines[position] = candidate
                break
        else:
            raise _BadLineError(line + position, "it holds the byte 0x10, and neither a blank nor the digit 0 in its place gives a point")
    return b"\n".join(lines)


def _ply(path: Path) -> Iterator[_Block]:
    from fairaudit.libraries import library

    plyfile = library("plyfile", "navigation")
    try:
        vertices = plyfile.PlyData.read(str(path))["vertex"].data
    except (plyfile.PlyParseError, KeyError, ValueError, OSError, EOFError, MemoryError, UnicodeError) as error:
        what = "it has no element named vertex" if isinstance(error, KeyError) else (str(error).splitlines() or ["it is cut short"])[0]
        raise InputError(f"{path}: this is not a PLY file of points: {what}") from None
    have = vertices.dtype.names or ()
    missing = [axis for axis in "xyz" if axis not in have]
    if missing:
        raise InputError(f"{path}: the vertices have no property {shown(missing[0])}; x, y and z are needed")
    xyz = np.empty((len(vertices), 3))
    for column, axis in enumerate("xyz"):
        xyz[:, column] = vertices[axis]
    wrong = np.flatnonzero(~np.isfinite(xyz).all(axis=1))
    if wrong.size:
        raise InputError(f"{path}: vertex {wrong[0]} has the coordinates {xyz[wrong[0]].tolist()}; finite numbers are accepted")
    rgb = np.full((len(vertices), 3), GREY, np.uint8)
    for names in (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")):
        if all(name in have for name in names):
            for column, name in enumerate(names):
                if vertices[name].dtype != np.uint8:
                    raise InputError(f"{path}: the property {name} is not of the type uchar; colours from 0 to 255 are accepted")
                rgb[:, column] = vertices[name]
            break
    if len(xyz):
        yield xyz, rgb
