"""What a table is read from, for a statement: the digests of its files, taken before they are read, and whether they stayed the same."""

from __future__ import annotations

import hashlib
import os
import re
import stat
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from fairaudit.attestations.statement import Source, check_text
from fairaudit.audits.sections import read_toml
from fairaudit.errors import InputError, shown
from fairaudit.tables.engines.paths import expand, form
from fairaudit.tables.sources import is_database

__all__ = ["Taken", "database_name", "refuse_credentials", "take"]

IN_URL = re.compile(r"://[^/@\s]*:[^/@\s]*@")

SECRET = re.compile(
    r"(?<![a-z])(password|passwd|passphrase|pwd|secret|api_?key|access_?key|auth_?token|access_?token)\s*(=>?|:)", re.IGNORECASE
)


@dataclass(frozen=True)
class Taken:
    """Sources as they were before anything was read.

    Attributes
    ----------
    sources : tuple of Source
        What was found.
    patterns : mapping of str to tuple of str
        The files for which each name that was given stood.
    seen : mapping of str to tuple of int
        Where each file was, how long, and when it was changed last.
    data : int or None
        Which source is the only one that holds rows of the table.
    """

    sources: tuple[Source, ...]
    patterns: Mapping[str, tuple[str, ...]]
    seen: Mapping[str, tuple[int, ...]]
    data: int | None

    def unchanged(self) -> None:
        """Refuse files that were changed since.

        Raises
        ------
        InputError
            If one was, or if a pattern or a folder stands for other files now.
        """
        for given, paths in self.patterns.items():
            if tuple(_listed(given)) != paths:
                raise InputError(f"{given} stands for other files than when the audit began; run it again when nobody writes there")
        for path, before in self.seen.items():
            if _state(path) != before:
                raise InputError(f"{path} was changed while it was read; run the audit again when nobody writes to it")

    def with_rows(self, rows: int | None) -> tuple[Source, ...]:
        """The sources, with the number of rows of the only one that holds some."""
        if rows is None or self.data is None:
            return self.sources
        return tuple(replace(source, rows=rows) if i == self.data else source for i, source in enumerate(self.sources))


def take(source: object, *, table: str | None = None, query: str | None = None, beside: Sequence[str] = ()) -> Taken:
    r"""Look at what a table will be read from, and take the digests of its files.

    Parameters
    ----------
    source : path, sequence of paths, URL or table in memory
        The table, or an audit file, with which come all files that it names.
    table, query : str, optional
        Of a database: what is read.
    beside : sequence of str
        Further files that are read.

    Returns
    -------
    Taken
        The sources. Databases, pipes and tables in memory have no digest.

    Raises
    ------
    InputError
        If a file cannot be read, or its name or the query has no place in a statement.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "log.csv"
    ...     _ = path.write_text("hired,sex\nyes,f\n")
    ...     taken = take(path)
    ...     taken.unchanged()
    >>> taken.sources[0].name, taken.sources[0].bytes, taken.sources[0].sha256[:8]
    ('log.csv', 16, 'a45891d4')
    """
    names = _names(source)
    if names is None:
        return Taken((Source("a table in memory"),), {}, {}, 0)
    audit = len(names) == 1 and names[0].endswith(".toml")
    data = _named_in(names[0], tables=True) if audit else names
    others = [*names, *_named_in(names[0], tables=False)] if audit else []
    found: list[Source] = []
    patterns: dict[str, tuple[str, ...]] = {}
    seen: dict[str, tuple[int, ...]] = {}
    holding: list[int] = []
    for given in dict.fromkeys((*data, *others, *beside)):
        if is_database(given) and not given.startswith("delta:") and not Path(given).exists():
            paths: tuple[str, ...] = ()
            found.append(_database(given, table, query))
        else:
            paths = patterns[given] = tuple(_listed(given))
            found += [_file(path, seen) for path in paths]
        if given in data:
            holding += range(len(found) - max(1, len(paths)), len(found))
    return Taken(tuple(found), patterns, seen, holding[0] if len(holding) == 1 else None)


def refuse_credentials(text: str, what: str, *, query: bool = False) -> None:
    """Refuse a text that holds what looks like credentials: a user with a password in a URL and, in a query, a password in any form.

    Raises
    ------
    InputError
        If it does; the message does not repeat it.

    Examples
    --------
    >>> refuse_credentials("SELECT * FROM log", "the query", query=True)
    >>> refuse_credentials("SELECT * FROM dblink('password=hush', 'log')", "the query", query=True)
    Traceback (most recent call last):
    fairaudit.errors.InputError: the query holds what looks like a password, which no attestation holds; leave it out
    """
    if IN_URL.search(text) or (query and SECRET.search(text)):
        raise InputError(f"{what} holds what looks like a password, which no attestation holds; leave it out")


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


def _names(source: object) -> list[str] | None:
    if isinstance(source, (str, os.PathLike)):
        return [os.fspath(source)]
    if isinstance(source, (list, tuple)) and source and all(isinstance(part, (str, os.PathLike)) for part in source):
        return [os.fspath(part) for part in source]
    return None


def _database(url: str, table: str | None, query: str | None) -> Source:
    if query is not None:
        refuse_credentials(query, "the query", query=True)
        check_text(query, "the query")
    return Source(_name(database_name(url)), table=None if query is not None else table, query=query)


def _listed(given: str) -> list[str]:
    """The files for which a name stands: those of a pattern, those of a folder, or itself."""
    listed: list[str] = []
    for path in expand([given.removeprefix("delta:") if not Path(given).exists() else given]):
        if Path(path).is_dir():
            form(path)  # which refuses all folders but those of Delta tables
            listed += sorted(str(inner) for inner in Path(path).rglob("*") if inner.is_file())
        else:
            listed.append(path)
    return listed


def _state(path: str) -> tuple[int, ...]:
    try:
        found = Path(path).stat()
    except OSError:
        return ()
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


def _file(path: str, seen: dict[str, tuple[int, ...]]) -> Source:
    """A file with its digest; none of what can be read only once."""
    try:
        if not stat.S_ISREG(Path(path).stat().st_mode):
            return Source("a pipe")
        before = _state(path)
        with Path(path).open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
            size = file.tell()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if seen.setdefault(path, before) != before or size != before[2]:
        raise InputError(f"{path} was changed while it was read; run the audit again when nobody writes to it")
    return Source(_name(Path(path).name), digest, size)


def _name(text: str) -> str:
    try:
        return check_text(text, "its name")
    except InputError as error:
        raise InputError(f"{shown(text)}: {error}; rename the file") from None


def _named_in(audit: str, *, tables: bool) -> list[str]:
    """The files that an audit file names: that of its table, or all others."""
    document, folder = read_toml(Path(audit))[0], Path(audit).parent
    about = [document.get(name) for name in ("law", "policy")]
    if tables:
        return [str(folder / name) for section in about if isinstance(name := _entry(section, "table"), str)]
    named = [_entry(section, "map") for section in about]
    named += [_entry(document.get(name), "table") for name in ("utility", "population")]
    filters = _sections(document.get("filter"))
    named += [section["table"] for section in filters if section.get("kind") == "table" and isinstance(section.get("table"), str)]
    return [str(folder / name) for name in named if isinstance(name, str)]


def _entry(section: Any, key: str) -> Any:
    return section.get(key) if isinstance(section, dict) else None


def _sections(value: Any) -> Iterable[dict[str, Any]]:
    """A section and those within it."""
    if isinstance(value, dict):
        yield value
        for inner in value.values():
            yield from _sections(inner)
