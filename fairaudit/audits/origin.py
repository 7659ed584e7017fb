"""Where a table comes from: the files that are read, as they are before that, so that it can be told later whether they were changed."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

from fairaudit.audits.sections import files_in
from fairaudit.errors import InputError
from fairaudit.files import read_toml
from fairaudit.model.utility import Utility
from fairaudit.tables.engines.paths import expand, form
from fairaudit.tables.sources import database_file, in_database, is_audit_file

if TYPE_CHECKING:
    from fairaudit.audits.reading import Reading

__all__ = ["Files", "Origin", "database_name", "files_behind", "files_of", "names_of", "origin_of", "paths_of", "state_of"]

State = tuple[int, ...]


@dataclass(frozen=True)
class Files:
    """What is read, as it was at a moment.

    Attributes
    ----------
    data, others : tuple of str
        The names that were given for what holds the rows of the table, and of what is read besides; of databases without server or user.
    listed : mapping of str to tuple of str
        The files for which each of them stands; of databases none.
    states : mapping of str to tuple of int
        Where each of these is, how long, when it was changed last, and by which links it is named; nothing of what can be read only once.
    read : set of tuple of int
        Where all that is read lies, databases among it.
    """

    data: tuple[str, ...]
    others: tuple[str, ...]
    listed: Mapping[str, tuple[str, ...]]
    states: Mapping[str, State]
    read: Set[State] = frozenset()

    def refuse(self, paths: Iterable[str | os.PathLike[str]]) -> None:
        """Refuse to write files that were read.

        Raises
        ------
        InputError
            If one is.
        """
        for path in paths:
            if state_of(os.fspath(path))[:2] in self.read:
                raise InputError(f"{os.fspath(path)} is a file that was read; name another file to write")


@dataclass(frozen=True)
class Origin:
    """What a result was made of.

    Attributes
    ----------
    files : Files or None
        What was read, as it was before; None of a table in memory.
    audit : dict or None
        The sections of an audit file.
    reading : Reading or None
        How a table was read, where it can be read again like that.
    utility : Utility or None
        What decisions were worth, where no column said it.
    positive : str or None
        The positive true label, where one was given.
    """

    files: Files | None
    audit: Mapping[str, Any] | None = None
    reading: Reading | None = None
    utility: Utility | None = field(default=None, repr=False)
    positive: str | None = None


def origin_of(
    source: object, reading: Reading | None = None, utility: Utility | None = None, *, positive: object = None, again: bool = True
) -> Origin | None:
    """Look at what is about to be read; nothing of what cannot be found, of which the reader says what is wrong.

    Parameters
    ----------
    source : Source
        The table, or the name of an audit file.
    reading, utility, positive
        How it is read.
    again : bool
        Whether they say all that is needed to make the same table again.
    """
    names = names_of(source)
    try:
        joined = None if reading is None else reading.access.extraction.join
        files = None if names is None else files_of(names, [] if joined is None else [joined[0]])
    except InputError:
        return None
    audit = read_toml(Path(names[0]))[0] if names is not None and len(names) == 1 and is_audit_file(names[0]) else None
    kept = reading if again else None
    return Origin(files, audit, kept, utility if kept is not None else None, None if positive is None else str(positive))


def names_of(source: object) -> list[str] | None:
    """The names that are given for a table; None of one in memory."""
    if isinstance(source, (str, os.PathLike)):
        return [os.fspath(source)]
    if isinstance(source, (list, tuple)) and source and all(isinstance(part, (str, os.PathLike)) for part in source):
        return [os.fspath(part) for part in source]
    return None


def files_of(names: Sequence[str], beside: Sequence[str] = ()) -> Files:
    """Look at files: those with these names, those that an audit file names, and further ones.

    Raises
    ------
    InputError
        If there is no such file.
    """
    audit = len(names) == 1 and is_audit_file(names[0])
    data, further = _held_in(names[0]) if audit else (names, [])
    held = {name: paths_of(name) for name in data if not in_database(name)}
    with_logs = [file for paths in held.values() for path in paths for file in _of_log(path)[1:]]
    others = [*(names if audit else []), *further, *beside, *(file for file in with_logs if file not in data)]
    listed = {_kept(name): tuple(held[name] if name in held else paths_of(name)) for name in dict.fromkeys((*data, *others))}
    states = {path: state_of(path) for paths in listed.values() for path in paths}
    behind = [file for name in (*data, *others) if in_database(name) for file in files_behind(name)]
    read = {state[:2] for state in (*states.values(), *map(state_of, behind)) if state}
    return Files(tuple(dict.fromkeys(map(_kept, data))), tuple(dict.fromkeys(map(_kept, others))), listed, states, read)


def database_name(url: str) -> str:
    """Name a database without its server, its user and its folders.

    Examples
    --------
    >>> database_name("postgresql://me:hush@db.example.org:5432/hiring?sslmode=require"), database_name("sqlite:/home/me/log.db")
    ('postgresql:hiring', 'sqlite:log.db')
    >>> database_name("postgresql://me:hush@db.example.org")
    'postgresql'
    """
    scheme, _, rest = url.partition(":")
    try:
        path = urlsplit(url).path if rest.startswith("//") else rest
    except ValueError:
        path = ""
    name = unquote(path.replace("\\", "/").rstrip("/").rpartition("/")[2])
    return scheme if not name or re.search(r"[/@:;=&]", name) else f"{scheme}:{name}"


def _kept(name: str) -> str:
    """A name that may be kept: of a database neither server nor user nor password."""
    return database_name(name) if in_database(name) else name


def paths_of(given: str) -> list[str]:
    """The files for which a name stands: those of a pattern, those of the folder of a Delta table, or itself; of a database none."""
    if in_database(given):
        return []
    delta = given.startswith("delta:") and not os.path.exists(given)  # noqa: PTH110
    listed: list[str] = []
    for path in expand([given.removeprefix("delta:") if delta else given]):
        if os.path.isdir(path) and (log := _of_log(path)):  # noqa: PTH112
            listed.append(log[0])
        elif os.path.isdir(path):  # noqa: PTH112
            form(path)  # which refuses all folders but those of Delta tables
            listed += sorted(str(inner) for inner in Path(path).rglob("*") if inner.is_file())
        else:
            listed.append(path)
    return listed


def _of_log(path: str) -> list[str]:
    """The file of an evaluation log, and those that are read with it; none of what cannot be one."""
    if not re.search(r"\.jsonl?(\.gz)?$", path, re.IGNORECASE) and not os.path.isdir(path):  # noqa: PTH112
        return []
    from fairaudit.tables.evaluations.detection import files_of_log

    return files_of_log(path)


def files_behind(given: str) -> list[str]:
    """The files that are read for a name: those of `paths_of`, and of a database that is a file this one."""
    file = database_file(given) if in_database(given) else None
    return paths_of(given) if file is None else [file]


def state_of(path: str) -> State:
    """Where a file is, how long, when it was changed last, and the links by which it is named; empty for what is not there, or no file."""
    try:
        found = Path(path).stat()
        links = [link.lstat() for link in (Path(path), *Path(path).parents) if link.is_symlink()]
    except (OSError, ValueError):
        return ()
    if not stat.S_ISREG(found.st_mode):
        return ()
    by = [number for link in links for number in (link.st_ino, link.st_ctime_ns)]
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns, *by


def _held_in(audit: str) -> tuple[list[str], list[str]]:
    """The files that an audit file names: that of its table, and all others."""
    document, folder = read_toml(Path(audit))[0], Path(audit).parent
    data = files_in({name: {key: _entry(document.get(name), key) for key in ("table", "files")} for name in ("law", "policy")})
    return [str(folder / name) for name in data], [str(folder / name) for name in files_in(document) if name not in data]


def _entry(section: Any, key: str) -> Any:
    return section.get(key) if isinstance(section, dict) else None
