"""Files: which there are, and what they hold."""

from __future__ import annotations

import glob
import os
import re
import shutil
import stat
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from fairaudit.errors import InputError, shown
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.csv import SMALL, count_csv
from fairaudit.tables.engines.folders import refuse_table_formats, table_format
from fairaudit.tables.engines.request import Request
from fairaudit.tables.tally import Tally

__all__ = ["SMALL", "Form", "expand", "form"]


Form = Literal["csv", "json", "parquet", "sqlite", "duckdb", "delta", "utf-16", "zip", "spreadsheet", "statistics", "arrow", "orc"]

OLD_SPREADSHEET = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"

STATISTICS = (".dta", ".sav", ".zsav", ".por", ".sas7bdat", ".xpt")

JSON_NAME = re.compile(r".*\.(jsonl|ndjson|json)(\.(gz|zst))?", re.IGNORECASE)

NO_TABLES = (
    (b"%pdf-", "a PDF"),
    (b"<!doctype html", "a web page"),
    (b"<html", "a web page"),
    (b"{\\rtf", "a document"),
    (b"\x89png", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
)
"""How files begin that hold no table, in small letters."""


def read_text(paths: Sequence[str], request: Request) -> Tally:
    """Count the rows of delimited text line by line: what every other reader of such files has to agree with."""
    told = request.report
    tally = count_csv(paths, request.columns, None if told is None else lambda rows: told(None, rows))
    return apply_bins(tally, request.bins)


def expand(sources: Sequence[str]) -> list[str]:
    """List the files that names and patterns stand for.

    Raises
    ------
    InputError
        If there are none.
    """
    paths: list[str] = []
    for source in sources:
        if not source:
            raise InputError("the name of the table is empty; name a CSV file")
        try:
            literal = os.path.lexists(source)
        except ValueError as error:
            raise InputError(f"{source}: the file cannot be read: {error}") from None
        if literal or not glob.has_magic(source):
            paths.append(source)
            continue
        found = sorted(path for path in glob.glob(source, recursive=True) if not Path(path).is_dir())  # noqa: PTH207
        if not found:
            raise InputError(f"{source}: there is no such file, and none that the pattern fits")
        paths += found
    known: set[str] = set()
    for path in paths:
        if path in known:
            raise InputError(f"{path} is named twice; each file is read once")
        known.add(path)
    refuse_table_formats(path for path in paths if os.path.exists(path) and not os.path.isdir(path))  # noqa: PTH110, PTH112
    return paths


def form(path: str) -> Form:
    """Say what a file holds, by its first bytes and, for JSON, its name.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    try:
        with Path(path).open("rb") as file:
            start = file.read(64)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except IsADirectoryError:
        return _form_of_folder(Path(path))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    _refuse_no_table(path, start)
    if start.startswith(b"PAR1") or path.lower().endswith((".parquet", ".parq", ".pq")):
        return "parquet"
    if start.startswith(b"SQLite format 3\x00"):
        return "sqlite"
    if start[8:12] == b"DUCK":
        return "duckdb"
    return _form_to_convert(path, start) or ("json" if JSON_NAME.fullmatch(path) else "csv")


def _refuse_no_table(path: str, start: bytes) -> None:
    """Refuse what could be read as a text of one column, and is no table."""
    if b'"format": "fairaudit-' in start:
        raise InputError(f"{path} is a certificate; fairaudit verify checks it, and an audit is made of the table")
    for mark, what in NO_TABLES:
        if start.lower().startswith(mark):
            raise InputError(f"{path} is {what}; save the table in it as CSV or as a spreadsheet, and name that file")


def _form_to_convert(path: str, start: bytes) -> Form | None:
    """What is written anew before it is read (`fairaudit.tables.engines.converted`)."""
    if start.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if start.startswith(b"PK\x03\x04"):
        return _form_of_archive(path)
    if start.startswith(OLD_SPREADSHEET):
        return "spreadsheet"
    if start.startswith((b"ARROW1", b"FEA1")):
        return "arrow"
    if start.startswith(b"ORC"):
        return "orc"
    return "statistics" if path.lower().endswith(STATISTICS) else None


def _form_of_archive(path: str) -> Form:
    """Spreadsheets are archives, too."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, OSError):
        return "zip"
    return "spreadsheet" if "[Content_Types].xml" in names or ("mimetype" in names and "content.xml" in names) else "zip"


def _form_of_folder(folder: Path) -> Form:
    """A Delta table is a folder; other folders are refused, with a pattern for what they hold."""
    if table_format(folder) == "Delta":
        return "delta"
    refuse_table_formats([str(folder)])
    nested = next(folder.glob("*.parquet"), None) is None and next(folder.glob("*/**/*.parquet"), None) is not None
    logs = next(folder.glob("*.eval"), None) is not None
    pattern = shown(str(folder / ("*.eval" if logs else "**/*.parquet" if nested else "*.parquet")), 300)
    raise InputError(f"{folder}: this is a directory; name a file, or a pattern such as {pattern}")


@contextmanager
def regular(paths: list[str]) -> Iterator[list[str]]:
    """Copy what can be read only once (a pipe) into a temporary file, which is removed afterwards."""
    made: list[str] = []
    try:
        listed: list[str] = []
        for path in paths:
            try:
                ordinary = not stat.S_ISFIFO(Path(path).stat().st_mode)
            except (OSError, ValueError):
                ordinary = True
            if not ordinary:
                handle, path = tempfile.mkstemp(prefix="fairaudit-pipe-")
                made.append(path)
                with os.fdopen(handle, "wb") as copy, Path(paths[len(listed)]).open("rb") as pipe:
                    shutil.copyfileobj(pipe, copy)
            listed.append(path)
        yield listed
    except OSError as error:
        raise InputError(f"the input cannot be read: {error.strerror or error}") from None
    finally:
        for path in made:
            Path(path).unlink(missing_ok=True)
