"""Readers of scans: S3DIS folders, text files of points (also compressed by gzip), and the formats of `formats`."""

from __future__ import annotations

import gzip
import hashlib
import io
import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown
from fairaudit.plugins.navigation.formats import BAGS, GREY, READERS, Block, is_bag, read_bag

__all__ = ["CLASSES", "Part", "Points", "read_points"]

CLASSES = ("ceiling", "floor", "wall", "beam", "column", "window", "door", "table", "chair", "sofa", "bookcase", "board", "clutter")
"""The classes of S3DIS annotations; anything else is clutter."""

TEXTS = (".txt", ".xyz", ".csv", ".asc", ".txt.gz", ".xyz.gz", ".csv.gz", ".asc.gz")
LARGEST, LEAST = 1e9, 1e-9
BLOCK = 1 << 22
LONGEST_LINE = 1 << 16
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

    Returns
    -------
    Points
        At least one point, as the file has them; `ground.prepare` makes them stand upright on a level floor. Points without finite
        coordinates are left out, and counted in the notes.

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
    reader, ending = _Collected(path), path.suffix.lower()
    if rooms and (is_bag(path) or not path.is_dir()):
        raise InputError(f"{path} is one scan; rooms can be chosen in an S3DIS area only")
    if (topic or message) and not is_bag(path):
        raise InputError(f"{path} is no recording of ROS; topic and message do not go with it")
    if message not in (None, "first", "last"):
        raise InputError(f"message is {shown(message)}; first or last is accepted")
    _check_columns(path, columns)
    if is_bag(path):
        reader.add(path, read_bag(path, reader.notes, topic, message))
    elif path.is_dir():
        _read_folders(reader, path, rooms)
    elif ending in READERS:
        reader.add(path, READERS[ending](path, columns, reader.notes))
    elif path.name.lower().endswith(TEXTS):
        reader.add(path, _text(path, reader.notes, columns))
    else:
        known = ", ".join((*TEXTS[:4], *READERS, *BAGS))
        raise InputError(f"{path}: scans that end in {shown(ending)} are not read; {known}, and folders of S3DIS and ROS are")
    return reader.points()


def _check_columns(path: Path, columns: Sequence[str]) -> None:
    if not columns:
        return
    if not path.name.lower().endswith((*TEXTS, ".npy")):
        raise InputError(f"{path} says itself what its columns are; columns go with text and npy")
    colours = [name for name in columns if name in ("r", "g", "b")]
    if len(set(columns) & set("xyz")) < 3 or len(colours) not in (0, 3) or any(columns.count(name) > 1 for name in "xyzrgb"):
        raise InputError(f"the columns are {shown(','.join(columns))}; x, y, z, and r, g, b or none of these, each once, are accepted")


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

    def add(self, path: Path, blocks: Iterator[Block], room: str | None = None, kind: str | None = None) -> None:
        first, read = self.count, 0
        name = path.name.removesuffix(".gz").rsplit(".", 1)[0]
        for xyz, rgb, own in blocks:
            start, read = self.count, read + len(xyz)
            whole = np.isfinite(xyz).all(axis=1)
            self.xyz.append(xyz if whole.all() else xyz[whole])
            self.rgb.append(rgb if whole.all() else rgb[whole])
            self.count += len(self.xyz[-1])
            last = self.parts[-1] if start > first else None
            if last is not None and last.kind == (own or kind):
                self.parts[-1] = replace(last, stop=self.count)
            elif self.count > start:
                self.parts.append(Part(start, self.count, room, own or kind, name))
        left = read - (self.count - first)
        if self.count == first:
            raise InputError(f"{path}: there are no points in this file" + (f" with finite coordinates, of {left:,}" if left else ""))
        if left:
            self.notes.append(f"{left:,} of {read:,} points have no finite coordinates and were left out")
        for each in sorted(file for file in path.iterdir() if file.is_file()) if path.is_dir() else [path]:
            with each.open("rb") as file:
                self.files[each.relative_to(self.root).as_posix()] = hashlib.file_digest(file, "sha256").hexdigest()

    def points(self) -> Points:
        xyz, self.xyz = self.xyz[0] if len(self.xyz) == 1 else np.concatenate(self.xyz), []
        rgb, self.rgb = self.rgb[0] if len(self.rgb) == 1 else np.concatenate(self.rgb), []
        far = max(float(xyz.max()), -float(xyz.min()))
        if far > LARGEST or 0 < far < LEAST:
            raise InputError(
                f"the coordinates of {self.parts[0].name} reach to {far:g}; this is no scan, unless its bytes are in the wrong order"
            )
        return Points(xyz, rgb, tuple(self.parts), self.files, tuple(dict.fromkeys(self.notes)))


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


def _text(path: Path, notes: list[str], names: Sequence[str] = ()) -> Iterator[Block]:
    """Points of a text file, in blocks of whole lines."""
    separator, after = b"", 1
    try:
        with gzip.open(path) if path.name.lower().endswith(".gz") else path.open("rb") as file:
            while lines := file.readlines(BLOCK):
                line, after = after, after + len(lines)
                if max(map(len, lines)) > LONGEST_LINE:
                    what = f"more than {LONGEST_LINE:,} characters; a text file with one point per line was expected"
                    raise _fault_at(path, next(n for n, text in enumerate(lines, start=line) if len(text) > LONGEST_LINE), what)
                if not separator and not b"".join(lines).isspace():
                    separator, names = _layout(path, lines, line, names)
                if separator not in (b"", b" "):
                    lines = [text.replace(separator, b" ") for text in lines]
                if not (block := b"".join(lines)).isspace():
                    yield _numbers(path, block, lines, line, names, notes)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _fault_at(path: Path, line: int, what: str) -> InputError:
    return InputError(f"{path}: line {line}: {what}")


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
        said = f"there are {len(words)} columns; x y z or x y z r g b was expected, or --columns with a name for each"
        raise _fault_at(path, line + position, said)
    return separator, names or "xyzrgb"[: len(words)]


def _numbers(path: Path, block: bytes, lines: list[bytes], line: int, names: Sequence[str], notes: list[str]) -> Block:
    """Parse a block: fast if nothing is wrong with it, else line by line to say what."""
    if _BAD_BYTE in block:
        lines = [_repaired(path, text, number, names, notes) for number, text in enumerate(lines, start=line)]
        block = b"".join(lines)
    values = _parsed(block, lines, names)
    if values is None:
        faults = ((number, what) for number, text in enumerate(lines, start=line) if (what := _fault(text, names)))
        usual = (line, f"the lines from here to line {line + len(lines) - 1} cannot be read as numbers separated by blanks")
        raise _fault_at(path, *next(faults, usual))
    xyz = np.ascontiguousarray(values[:, [list(names).index(axis) for axis in "xyz"]])
    if not set(names) >= set("rgb"):
        return xyz, np.full(xyz.shape, GREY, np.uint8), None
    return xyz, values[:, [list(names).index(colour) for colour in "rgb"]].astype(np.uint8), None


def _parsed(block: bytes, lines: list[bytes], names: Sequence[str]) -> NDArray[np.float64] | None:
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
    odd = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if odd.size:  # a short line is filled up with nan, so what stands there is looked at
        written = [text for text in lines if text.strip()]
        if len(written) != len(values) or any(_fault(written[row], names) for row in odd):
            return None
    colours = values[:, [number for number, name in enumerate(names) if name in ("r", "g", "b") and number < values.shape[1]]]
    whole = ((colours >= 0) & (colours <= 255) & (colours == np.floor(colours))).all()
    return values if whole and values.shape[1] == len(names) else None


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
    return "" if len(words) == len(names) else f"there are {len(words)} columns where {len(names)} were expected"


def _repaired(path: Path, text: bytes, line: int, names: Sequence[str], notes: list[str]) -> bytes:
    """Replace the byte 0x10 by a blank or by the digit 0, whichever gives the line its columns."""
    if _BAD_BYTE not in text:
        return text
    for meant, said in ((b" ", "a blank"), (b"0", "the digit 0")):
        if not _fault(candidate := text.replace(_BAD_BYTE, meant), names):
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
            notes.append(f"{path.name}, line {line}: the byte 0x10 was read as {said} (SHA-256 of the file {digest})")
            return candidate
    raise _fault_at(path, line, "it holds the byte 0x10, and neither a blank nor the digit 0 in its place gives a point")
