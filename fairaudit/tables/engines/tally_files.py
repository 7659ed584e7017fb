"""What a file of counts that `fairaudit.tally` wrote says of itself: where the counts are, and what was done before they were made."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.preparation import Entry
from fairaudit.tables.sources import ACCEPTED, SameContent
from fairaudit.tables.values import MARK

__all__ = ["KEY", "Said", "is_tally", "refuse_others", "said_by"]

KEY = MARK
"""Under which a Parquet file says so, in JSON; the column of this name is for those who do not look there."""

ENTRY = ("step", "column", "edges")
"""What it says of a column that was cut into intervals, in the order in which a certificate has it."""

AGAIN = "make it again by fairaudit tally"


@dataclass(frozen=True)
class Said:
    """What files of counts say of themselves.

    Attributes
    ----------
    count : str
        The column of the counts.
    preparation : tuple of mapping
        Which columns were cut into intervals (`fairaudit.tables.preparation`).
    values : dict of str to {"texts", "values", "none"}
        Whether the labels of a column were texts, or numbers and truth values, where they were counted.
    sources : tuple of str
        The SHA-256 of what each file held that was counted, unpacked; none of databases, of frames, and in files of earlier versions.
    """

    count: str
    preparation: tuple[Entry, ...]
    values: Mapping[str, str]
    sources: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The same in JSON."""
        said = {"count": self.count, "preparation": [dict(entry) for entry in self.preparation], "values": dict(self.values)}
        said |= {"sources": list(self.sources)} if self.sources else {}
        return json.dumps(said, ensure_ascii=True, sort_keys=True)

    def refuse(self, path: str, columns: Sequence[str], count: str | None, cut: Sequence[str]) -> None:
        """Refuse counts that are read as anything else, and intervals that are cut again.

        Raises
        ------
        InputError
            If they are.
        """
        if count != self.count:
            raise InputError(
                f"{path} is a tally: each of its rows stands for as many decisions as its column {shown(self.count)} says; name that "
                f"column with count (--count {self.count})"
            )
        for entry in self.preparation:
            if entry["column"] in cut and entry["column"] in columns:
                edges = ", ".join(entry["edges"])
                raise InputError(f"column {shown(entry['column'])} was cut at {edges} before {path} was counted; name it without edges")


def is_tally(path: str) -> bool:
    """Whether a file names the key of a tally where Parquet files describe themselves; whether it is one, `said_by` says."""
    if not os.path.isfile(path):  # noqa: PTH113
        return False
    try:
        with Path(path).open("rb") as file:
            end = file.seek(0, os.SEEK_END)
            file.seek(max(0, end - 8))
            length, mark = int.from_bytes(file.read(4), "little"), file.read(4)
            if mark != b"PAR1":
                return False
            file.seek(max(0, end - 8 - length))
            return KEY.encode() in file.read(length)
    except OSError:
        return False  # which the reader says


def said_by(connection: Any, paths: Sequence[str], listed: str, same_content: SameContent = "refuse") -> Said | None:
    """What Parquet files say of themselves; None if they are no tallies.

    Parameters
    ----------
    connection : DuckDBPyConnection
        Who reads them.
    paths : sequence of str
        The files.
    listed : str
        The same as they stand in a statement.
    same_content : {"refuse", "accept"}
        Whether several may count files of the same content.

    Raises
    ------
    InputError
        If only some are, they do not say the same, or two counted the same rows.
    """
    rows = connection.execute(f"select file_name, value from parquet_kv_metadata({listed}) where key = '{KEY}'::blob").fetchall()  # noqa: S608
    if not rows:
        return None
    places = {os.path.realpath(name): value for name, value in rows}
    found = {path: _read(path, places[place]) for path in paths if (place := os.path.realpath(path)) in places}
    first = next(iter(found))
    for path in paths:
        if path not in found:
            refuse_others(first, path)
        _refuse_differences(found[first], found[path], first, path)
    if same_content == "refuse":
        _refuse_same_rows(found)
    values = {name: kind for said in found.values() for name, kind in said.values.items() if kind != "none"}
    return Said(found[first].count, found[first].preparation, values, tuple(digest for said in found.values() for digest in said.sources))


def refuse_others(first: str, path: str) -> None:
    """Refuse a tally, the first, beside a file that is none."""
    raise InputError(f"{first} is a tally and {path} is none; count {path}, too (fairaudit tally), or leave it out")


def _refuse_same_rows(found: Mapping[str, Said]) -> None:
    """Refuse tallies of which two counted a file of the same content."""
    known: dict[str, str] = {}
    for path, said in found.items():
        for digest in said.sources:
            if (first := known.setdefault(digest, path)) != path:
                raise InputError(
                    f"{first} and {path} both count the file with the SHA-256 {digest[:12]}…; each row is counted once: {ACCEPTED}"
                )


def _refuse_differences(one: Said, other: Said, first: str, path: str) -> None:
    """Refuse files that were not counted in the same way."""
    if one.count != other.count:
        raise InputError(f"the counts are in column {shown(one.count)} of {first} and in column {shown(other.count)} of {path}; {AGAIN}")
    if one.preparation != other.preparation:
        raise InputError(f"{first} and {path} were cut into different intervals before they were counted; {AGAIN} with the same ones")
    for name, kind in one.values.items():
        if {kind, other.values.get(name, "none")} == {"texts", "values"}:
            where = (first, path) if kind == "texts" else (path, first)
            raise InputError(
                f"column {shown(name)} held texts where {where[0]} was counted, and numbers or truth values where {where[1]} was; one "
                "label could stand for two values: write the logs with one type"
            )


def _read(path: str, value: bytes) -> Said:
    """Read what a file says of itself, which anybody could have written."""
    try:
        said = json.loads(value)
        count, preparation, values = said["count"], said["preparation"], said["values"]
        fits = isinstance(count, str) and isinstance(preparation, list) and isinstance(values, dict)
        fits = fits and all(kind in ("texts", "values", "none") for kind in values.values())
        sources = said.get("sources", [])
        fits = fits and isinstance(sources, list) and all(isinstance(digest, str) for digest in sources)
        for entry in preparation if fits else ():
            fits = fits and {*entry} == {*ENTRY} and entry["step"] == "intervals" and isinstance(entry["column"], str)
            fits = fits and isinstance(entry["edges"], list) and all(isinstance(edge, str) for edge in entry["edges"])
    except (ValueError, TypeError, KeyError, RecursionError):
        fits = False
    if not fits:
        raise InputError(f"{path}: what this tally says of itself cannot be read; {AGAIN}")
    return Said(count, tuple({name: entry[name] for name in ENTRY} for entry in preparation), values, tuple(sources))
