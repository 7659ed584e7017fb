"""A log that may grow, be rotated or be cut off while it is read."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from fairaudit.errors import InputError
from fairaudit.streams.readers import line_ends
from fairaudit.streams.state import Place
from fairaudit.tables.sources import ACCEPTED, SameContent

__all__ = ["Log"]


CHUNK = 200_000  # bytes read at once: a few thousand decisions, so that a follower looks and commits several times a second

EDGE = 1_024  # bytes at either end of what was read that tell a log from another one

LONGEST = 1 << 24  # 16 MB: a file without line ends is noticed before it fills the memory


class Log:
    """A log file, or standard input, from a place on.

    Parameters
    ----------
    path : str
        The file, or ``-``.
    place : Place
        Where an earlier reader stopped; a new place begins at the beginning.
    same_content : {"refuse", "accept"}
        What becomes of another log that holds what was read before.

    Attributes
    ----------
    notes : list of str
        What was noticed: rotation, truncation, a line without an end. Whoever reads them clears them.
    """

    def __init__(self, path: str, place: Place, same_content: SameContent = "refuse") -> None:
        self.path, self.notes = path, list[str]()
        self.place = replace(place, path=path)
        self._earlier = [*place.earlier]
        if place.offset and place.path != path:
            self._earlier.append([place.path, place.inode, place.device, place.offset, place.head, place.tail])
        self._head = b""
        self.ended = False
        if path == "-":
            self.file: BinaryIO = open(sys.stdin.fileno(), "rb", buffering=0, closefd=False)  # noqa: SIM115
            self.regular = False
            self.place = Place(path, letters=place.letters, earlier=self._earlier)
            return
        self.file = self._open(path)
        found = os.fstat(self.file.fileno())
        self.regular = stat.S_ISREG(found.st_mode)
        if not self.regular:
            self.place = Place(path, letters=place.letters, earlier=self._earlier)
        elif place.offset and place.path == path:
            self._resume(place, found)
        else:
            self._refuse_read(found, same_content)
            self._begin(found)

    def _open(self, path: str) -> BinaryIO:
        try:
            return Path(path).open("rb", buffering=0)
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror or error}") from None

    def _refuse_read(self, found: os.stat_result, same_content: SameContent) -> None:
        """Refuse a log that is one that was read before, or that holds or begins with what one held."""
        for path, inode, device, offset, head, tail in self._earlier:
            if not offset or not self._same(Place(path, offset=offset, head=head, tail=tail), self.file):
                continue
            said = ""
            if (inode, device) == (found.st_ino, found.st_dev):
                both = f"{self.path} was" if path == self.path else f"{self.path} and {path} are one file, which was"
                said = f"{both} read before, and another log since; each line is counted once: use another state"
            elif same_content == "refuse" and (found.st_size == offset or offset >= 2 * EDGE):
                said = f"{self.path} begins with what was read from {path} before; each line is counted once: {ACCEPTED}"
            if said:
                self.file.close()
                raise InputError(said)

    def _begin(self, found: os.stat_result) -> None:
        self.place = Place(self.path, found.st_ino, found.st_dev, letters=self.place.letters, earlier=self._earlier)
        self._head = b""
        self.file.seek(0)

    def _same(self, place: Place, file: BinaryIO) -> bool:
        """Whether a file has the bytes at its edges that were read before."""
        if os.fstat(file.fileno()).st_size < place.offset:
            return False
        ends = _edges(file, place.offset)
        return (_digest(ends[0]), _digest(ends[1])) == (place.head, place.tail)

    def _resume(self, place: Place, found: os.stat_result) -> None:
        if self._same(place, self.file):
            self._go_on(place, found)
            return
        earlier = self._renamed(place)
        if earlier is not None:
            self.notes.append(f"{self.path} was rotated; the rest of the earlier file is read first")
            self.file.close()
            self.file = earlier
            self._go_on(place, os.fstat(earlier.fileno()))
            return
        if (found.st_ino, found.st_dev) == (place.inode, place.device):
            self.notes.append(f"{self.path} was cut off or rewritten; it is read from its beginning")
        else:
            self.notes.append(
                f"{self.path} was rotated, and the earlier file is not beside it: what it had after byte {place.offset} is lost"
            )
        self._begin(found)

    def _go_on(self, place: Place, found: os.stat_result) -> None:
        self.place = replace(place, inode=found.st_ino, device=found.st_dev)
        self._head = _edges(self.file, place.offset)[0]
        self.file.seek(place.offset)

    def _renamed(self, place: Place) -> BinaryIO | None:
        """The earlier file under another name in the same directory."""
        for other in sorted(Path(self.path).parent.glob(f"{Path(self.path).name}?*")):
            try:
                if other.is_file() and (other.stat().st_ino, other.stat().st_dev) == (place.inode, place.device):
                    file = other.open("rb", buffering=0)
                    if self._same(place, file):
                        return file
                    file.close()
            except OSError:
                continue
        return None

    def chunks(self, *, follow: bool) -> Iterator[tuple[bytes, int, Place]]:
        """Yield whole lines, the number of the first, and the place after them, until the end of what there is.

        A last line without an end is yielded, with one, when the log is not followed; the place remembers it.
        """
        rest = b""
        while True:
            data = self.file.read(CHUNK)
            if not data:
                if rest and not (follow and self.regular):
                    yield from self._advance(rest + b"\n", len(rest), open_line=True)
                    rest = b""
                if self.regular and self._rotated():
                    if rest:
                        yield from self._advance(rest + b"\n", len(rest), open_line=True)
                        rest = b""
                    self._switch()
                    continue
                self.ended = not self.regular
                if rest and self.regular:
                    self.file.seek(self.place.offset)
                return
            if self.place.open_line:
                data = self._continued(data)
            data = rest + data
            cut = data.rfind(b"\n") + 1
            if cut:
                rest = data[cut:]
                yield from self._advance(data[:cut], cut, open_line=False)
            else:
                rest = data
                if len(rest) > LONGEST:
                    raise InputError(f"{self.path}, line {self.place.line}, is longer than {LONGEST} bytes; it is no log of decisions")

    def _continued(self, data: bytes) -> bytes:
        """Skip what belongs to a line that was read before it had an end."""
        end = data.find(b"\n") + 1 or len(data)
        if data[:end].strip():
            self.notes.append(f"{self.path}, line {self.place.line - 1}, was read before it was finished; what was added to it is not read")
        self.place = replace(self.place, offset=self.place.offset + end, open_line=not data[:end].endswith(b"\n"))
        return data[end:]

    def _advance(self, data: bytes, size: int, *, open_line: bool) -> Iterator[tuple[bytes, int, Place]]:
        before, offset = self.place, self.place.offset + size
        if len(self._head) < EDGE:
            self._head = (self._head + data[:size])[:EDGE]
        tail = data[:size][-EDGE:]
        if size < EDGE and self.regular:
            tail = _edges(self.file, offset)[1]
        self.place = replace(
            before, offset=offset, line=before.line + line_ends(data), head=_digest(self._head), tail=_digest(tail), open_line=open_line
        )
        yield data, before.line, self.place

    def _rotated(self) -> bool:
        """Whether the path now names another file, or this one became shorter than what was read."""
        try:
            named = Path(self.path).stat()
        except OSError:
            return False
        own = os.fstat(self.file.fileno())
        return (named.st_ino, named.st_dev) != (own.st_ino, own.st_dev) or own.st_size < self.place.offset

    def _switch(self) -> None:
        own = os.fstat(self.file.fileno())
        fresh = self._open(self.path)
        found = os.fstat(fresh.fileno())
        if (found.st_ino, found.st_dev) != (own.st_ino, own.st_dev) and self._same(self.place, fresh):
            self.file.close()
            self.file = fresh
            self._go_on(self.place, found)
            return
        if self.place.offset:
            cut = (found.st_ino, found.st_dev) == (own.st_ino, own.st_dev)
            self.notes.append(f"{self.path} was {'cut off' if cut else 'rotated'}; it is read from its beginning")
        self.file.close()
        self.file = fresh
        self._begin(found)


def _edges(file: BinaryIO, offset: int) -> tuple[bytes, bytes]:
    size = min(EDGE, offset)
    return os.pread(file.fileno(), size, 0), os.pread(file.fileno(), size, offset - size)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:32]
