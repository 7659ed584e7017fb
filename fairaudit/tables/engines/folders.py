"""Folders that hold a table in a format of its own: its log says which of its files count, and the files alone are not the table."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable
from pathlib import Path

from fairaudit.errors import InputError, shown

__all__ = ["refuse_table_formats", "table_format"]

MARKS = {"_delta_log": "Delta", ".hoodie": "Hudi", "metadata/*.metadata.json*": "Iceberg"}
EXPORT = "or write its rows to Parquet files in another folder"
ADVICE = {
    "Delta": "name the folder of the table, as delta:{folder} (extra 'delta'), " + EXPORT,
    "Iceberg": "read it by a library for Iceberg, such as polars.scan_iceberg, and give the frame to fairaudit.read_log in Python, "
    + EXPORT,
    "Hudi": "read it by Spark with Hudi's package, and give the frame to fairaudit.read_log in Python, " + EXPORT,
}


def table_format(folder: Path) -> str:
    """Name the table format of a folder; empty if it is an ordinary one.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as made:
    ...     (Path(made) / "_delta_log").mkdir()
    ...     table_format(Path(made))
    'Delta'
    """
    for mark, name in MARKS.items():
        first = mark.partition("/")[0]
        if os.path.lexists(os.path.join(folder, first)) and (mark == first or glob.glob(mark, root_dir=folder)):  # noqa: PTH118, PTH207
            return name
    return ""


def refuse_table_formats(paths: Iterable[str]) -> None:
    """Refuse files that belong to a table whose own log says which of its files count.

    Parameters
    ----------
    paths : iterable of str
        Files and folders; every folder above them is looked at, because partitions are folders within the table.

    Raises
    ------
    InputError
        If one belongs to a Delta, Iceberg or Hudi table.
    """
    known: set[Path] = set()
    for path in paths:
        for place in dict.fromkeys((Path(path).absolute(), Path(path).resolve())):
            for folder in (*([] if place.is_file() else [place]), *place.parents):
                if folder in known:
                    break
                known.add(folder)
                if found := table_format(folder):
                    kind = f"{'an' if found == 'Iceberg' else 'a'} {found} table"
                    raise InputError(
                        f"{path}: this is part of {kind}, {shown(str(folder), 300)}, in which rows that were deleted or replaced stay in "
                        f"files that no longer count; {ADVICE[found].format(folder=folder)}"
                    )
