"""Sticky releases in an SQLite file, for many threads and processes at once."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

from fairaudit.arguments import answered_class
from fairaudit.errors import InputError, shown

__all__ = ["ReleaseStore"]


FORMAT = "fairaudit-releases/1"

SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE releases (filter TEXT, attribute TEXT, subject TEXT, released TEXT NOT NULL, PRIMARY KEY (filter, attribute, subject))
  WITHOUT ROWID;
"""

FIND = "SELECT released FROM releases WHERE filter = ? AND attribute = ? AND subject = ?"

PATIENCE = 60.0  # seconds to wait for other processes that write


@answered_class()
class ReleaseStore:
    """Keeps the first release of each filter, attribute and subject in a file.

    Any number of threads and processes on one machine may use the file at once, each by a `ReleaseStore` of its own or a shared one.

    Parameters
    ----------
    path : str or path
        The SQLite file; it is made if there is none.

    Raises
    ------
    InputError
        If the file cannot be used, or is something else.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     store = ReleaseStore(folder + "/releases.db")
    ...     store.setdefault(("digest", "sex", "Ada"), "f"), store.setdefault(("digest", "sex", "Ada"), "m")
    ('f', 'f')
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = str(Path(path).absolute())
        with self._open() as db:
            if not db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                db.execute("BEGIN IMMEDIATE")
                if not db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                    for statement in SCHEMA.split(";\n"):
                        db.execute(statement)
                    db.execute("INSERT INTO meta VALUES ('format', ?)", (FORMAT,))
                db.execute("COMMIT")
            tables = {name for (name,) in db.execute("SELECT name FROM sqlite_master")}
            if not tables >= {"meta", "releases"} or db.execute("SELECT value FROM meta WHERE key = 'format'").fetchone() != (FORMAT,):
                raise InputError(f"{shown(self.path)} is not a store of releases; name another file")

    def setdefault(self, key: tuple[str, str, str], default: object) -> Any:
        """Keep a release unless there is one, and return what is kept, when it is on disk.

        Parameters
        ----------
        key : tuple of str
            Filter, attribute and subject, as `Mechanism.release_key` writes them.
        default : str or tuple of str
            The release to keep.

        Returns
        -------
        str or tuple of str
            The release that is kept.

        Raises
        ------
        InputError
            If the file cannot be read or written.
        """
        with self._open() as db:
            row = db.execute(FIND, key).fetchone()
            if row is None:
                db.execute("BEGIN IMMEDIATE")
                db.execute("INSERT INTO releases VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING", (*key, json.dumps(default)))
                row = db.execute(FIND, key).fetchone()
                db.execute("COMMIT")
            kept = json.loads(row[0])
        return tuple(kept) if isinstance(kept, list) else kept

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        """A connection for one operation, which no other thread or forked process has."""
        try:
            with closing(sqlite3.connect(self.path, isolation_level=None, timeout=PATIENCE)) as db:
                db.execute("PRAGMA synchronous = FULL")
                yield db
        except (sqlite3.Error, UnicodeDecodeError, json.JSONDecodeError) as error:
            raise InputError(f"{shown(self.path)} cannot be used as a store of releases: {error}") from None
