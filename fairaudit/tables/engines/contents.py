"""What files hold, so that no row is counted twice: a file and its link are one, and a copy, packed or not, holds the same rows."""

from __future__ import annotations

import os
import stat
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

from fairaudit.errors import InputError
from fairaudit.tables.compressed import is_compressed, opened, opened_stream
from fairaudit.tables.engines.paths import form
from fairaudit.tables.sources import ACCEPTED, SameContent

__all__ = ["digests_of", "refuse_twice"]

START = 1 << 16  # bytes at the beginning of two files that are compared before all are


def refuse_twice(paths: Sequence[str], same_content: SameContent, names: Mapping[str, str] | None = None) -> tuple[str, ...]:
    """Refuse files whose rows would be counted twice: one file under two names, or several with the same content.

    Contents are compared as they are read, unpacked; only of files that begin alike, and of plain ones only where they are as long.

    Parameters
    ----------
    paths : sequence of str
        The files; whatever is no regular file is passed over.
    same_content : {"refuse", "accept"}
        Whether copies are meant. One file under two names is always refused.
    names : mapping of str to str, optional
        How messages call files.

    Returns
    -------
    tuple of str
        Of copies that are accepted, what there is to say.

    Raises
    ------
    InputError
        If there are such files; the message names two.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for name in ("a.csv", "b.csv"):
    ...         _ = Path(folder, name).write_text("hired,sex")
    ...     refuse_twice([f"{folder}/a.csv", f"{folder}/b.csv"], "accept", {f"{folder}/a.csv": "a.csv", f"{folder}/b.csv": "b.csv"})
    ('a.csv and b.csv have the same content, and both are counted, as was asked for',)
    """
    called = names or {}
    places: dict[tuple[int, int], str] = {}
    files: list[str] = []
    for path in paths:
        try:
            found = Path(path).stat()
        except (OSError, ValueError):
            continue  # which the reader says
        if not stat.S_ISREG(found.st_mode):
            continue
        first = places.setdefault((found.st_dev, found.st_ino), path)
        if first != path:
            raise InputError(
                f"{called.get(first, first)} and {called.get(path, path)} are one file; each row is counted once: leave one out"
            )
        files.append(path)
    said = []
    for path, first in _copies(files):
        both = f"{called.get(first, first)} and {called.get(path, path)} have the same content"
        if same_content == "refuse":
            raise InputError(f"{both}; each row is counted once: {ACCEPTED}")
        said.append(f"{both}, and both are counted, as was asked for")
    return tuple(said)


def digests_of(paths: Sequence[str]) -> tuple[str, ...]:
    """Give the SHA-256 of what each regular file holds, unpacked; of what cannot be read none, which its reader says."""
    found = (_digest(path) for path in paths if os.path.isfile(path))  # noqa: PTH113
    return tuple(digest for digest in found if digest is not None)


def _copies(paths: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Files that hold the same as an earlier one, with that one."""
    if len(paths) < 2:
        return
    packed = {path for path in paths if _is_packed(path)}
    sizes: dict[int, list[str]] = {}
    for path in paths:
        sizes.setdefault(0 if packed else Path(path).stat().st_size, []).append(path)
    for alike in (held for held in sizes.values() if len(held) > 1):
        starts: dict[bytes, list[str]] = {}
        for path in alike:
            start = _start(path)
            if start:
                starts.setdefault(start, []).append(path)
        for same in starts.values():
            yield from _equal(same, packed)


def _equal(paths: Sequence[str], packed: set[str]) -> Iterator[tuple[str, str]]:
    """Files of the same beginning that hold the same as an earlier one; plain ones only where they are as long as another."""
    if len(paths) < 2:
        return
    lengths = [None if path in packed else Path(path).stat().st_size for path in paths]
    known: dict[str, str] = {}
    for path, length in zip(paths, lengths, strict=True):
        if length is not None and None not in lengths and lengths.count(length) < 2:
            continue
        digest = _digest(path)
        if digest is not None and (first := known.setdefault(digest, path)) != path and not _has_no_rows(path):
            yield path, first


def _is_packed(path: str) -> bool:
    try:
        with Path(path).open("rb") as file:
            start = file.read(6)
    except OSError:
        return False
    return is_compressed(start) or start.startswith(b"PK\x03\x04")


@contextmanager
def _content(path: str) -> Iterator[IO[bytes]]:
    """What a file holds as it is read: of an archive of one file this one, unpacked; of a spreadsheet its own bytes."""
    with ExitStack() as held:
        if form(path) == "zip":
            archive = held.enter_context(zipfile.ZipFile(path))
            inside = [info for info in archive.infolist() if not info.is_dir() and not info.filename.startswith("__MACOSX/")]
            if len(inside) != 1:
                raise InputError("the archive holds several files")  # which the reader says
            yield held.enter_context(opened_stream(held.enter_context(archive.open(inside[0]))))
        else:
            yield held.enter_context(opened(Path(path), {}))


def _start(path: str) -> bytes:
    """How what a file holds begins; nothing of what cannot be read."""
    try:
        with _content(path) as file:
            return file.read(START)
    except (InputError, OSError, EOFError, RuntimeError, NotImplementedError, zipfile.BadZipFile):
        return b""


def _digest(path: str) -> str | None:
    import hashlib

    try:
        with _content(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]
    except (InputError, OSError, EOFError, RuntimeError, NotImplementedError, zipfile.BadZipFile):
        return None


def _has_no_rows(path: str) -> bool:
    """Whether a Parquet file holds no row, as those that a cluster writes of parts in which there was none."""
    if form(path) != "parquet":
        return False
    import duckdb

    from fairaudit.tables.engines.duckdb import connected, literal, literal_path
    from fairaudit.tables.engines.request import Request

    try:
        with connected(Request((), {})) as connection:
            return connection.execute(f"select 1 from read_parquet({literal(literal_path(path))}) limit 1").fetchone() is None  # noqa: S608
    except duckdb.Error:
        return False  # which the reader says
