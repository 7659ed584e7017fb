"""What a table may be, and how one is named in a message. Nothing heavy is imported here."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from typing import Literal, Protocol

from fairaudit.errors import without_passwords

__all__ = [
    "ACCEPTED",
    "Frame",
    "SameContent",
    "Source",
    "Table",
    "database_file",
    "in_database",
    "is_audit_file",
    "is_database",
    "source_name",
]

DATABASE = re.compile(r"(sqlite|duckdb|delta):|[a-z][a-z0-9+.-]*://")


class Frame(Protocol):
    """A table with named columns: a frame or relation of pandas, polars, pyarrow, DuckDB or PySpark, lazy or not, or a `Tally`."""

    @property
    def columns(self) -> object:
        """The columns or their names."""


Table = Frame | Mapping[str, object]
"""Columns by name: a frame, or a mapping of column to list; to mypy, lists of texts beside lists of numbers are objects."""

Path = str | os.PathLike[str]

Source = Table | Path | Sequence[Path]
"""What can be audited: a table; or the name of a file, a folder, a pattern or a database, or several files."""


SameContent = Literal["refuse", "accept"]
"""What becomes of several files with the same content."""

ACCEPTED = "leave one out, or accept both with same_content='accept' (--same-content accept)"
"""What to do about them."""


def source_name(source: object) -> str:
    """Name a table in a message; passwords in URLs are left out.

    Examples
    --------
    >>> source_name("postgresql://me:secret@host/db"), source_name(["a.csv", "b.csv"])
    ('postgresql://me:…@host/db', 'a.csv and 1 more')
    """
    if isinstance(source, (list, tuple)) and source:
        return source_name(source[0]) if len(source) == 1 else f"{source_name(source[0])} and {len(source) - 1} more"
    if isinstance(source, (str, os.PathLike)):
        return without_passwords(os.fspath(source))
    name = getattr(source, "name", None)  # a frame may have a column of that name
    return name if isinstance(name, str) else f"the {type(source).__name__}"


def is_database(source: object) -> bool:
    """Whether a table is named by a URL."""
    return isinstance(source, str) and DATABASE.match(source) is not None


def database_file(url: str) -> str | None:
    """The file of a database that is one; None of any other name.

    Examples
    --------
    >>> database_file("sqlite:logs/hiring.db"), database_file("duckdb:///data/log.db"), database_file("postgresql://host/hiring")
    ('logs/hiring.db', '/data/log.db', None)
    """
    scheme, _, file = url.partition(":")
    return re.sub("^//", "", file) if scheme in ("sqlite", "duckdb") else None


def in_database(source: object) -> bool:
    """Whether a table is named by a URL and has no files: no file has that name, and it is no Delta table, which is a folder of files.

    Examples
    --------
    >>> in_database("sqlite:log.db"), in_database("delta:log"), in_database("log.csv")
    (True, False, False)
    """
    return isinstance(source, str) and is_database(source) and not source.startswith("delta:") and not os.path.exists(source)  # noqa: PTH110


def is_audit_file(source: object) -> bool:
    """Whether this is the name of an audit file.

    Examples
    --------
    >>> is_audit_file("AUDIT.toml"), is_audit_file("log.csv"), is_audit_file({"hired": ["yes"]})
    (True, False, False)
    """
    return isinstance(source, (str, os.PathLike)) and os.fspath(source).endswith(".toml")
