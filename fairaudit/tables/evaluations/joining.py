"""Rows of another file that belong to samples: groups and contexts of people, say, by the id of what was asked."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.csv import read_csv
from fairaudit.tables.evaluations.json_rows import json_rows
from fairaudit.tables.label_text import label_text

__all__ = ["Joined", "joined_rows"]

JSON = re.compile(r"\.(jsonl|ndjson|json)(\.\w+)?$", re.IGNORECASE)


@dataclass
class Joined:
    """Rows by the label by which they belong to samples.

    Attributes
    ----------
    name : str
        The file.
    column : str
        The column of the label.
    columns : tuple of str
        All columns.
    rows : dict of str to mapping
        The rows.
    kinds : set of type
        Text and number, as far as the labels are these; none of CSV, where all is text.
    """

    name: str
    column: str
    columns: tuple[str, ...]
    rows: dict[str, Mapping[str, Any]]
    kinds: set[type] = field(default_factory=set)
    used: set[str] = field(default_factory=set)

    def of(self, value: Any) -> Mapping[str, Any]:
        """The row that belongs to a sample.

        Raises
        ------
        InputError
            If there is none.
        """
        label = label_text(value)
        if value is not None and self.kinds and (str in self.kinds) is not isinstance(value, str):
            raise InputError(
                f"{shown(self.column)} is {shown(value)} here, and is a number in some samples and a text in others, or in {self.name}; "
                "give it one form in all"
            )
        row = None if label is None else self.rows.get(label)
        if row is None or label is None:
            raise InputError(f"{self.name} has no row whose {shown(self.column)} is {shown(label)}")
        self.used.add(label)
        return row

    def refuse_unused(self) -> None:
        """Refuse rows that belong to no sample, because samples may be missing.

        Raises
        ------
        InputError
            If there are such.
        """
        unused = [label for label in self.rows if label not in self.used]
        if unused:
            listed = ", ".join(map(shown, unused[:10]))
            raise InputError(
                f"{len(unused)} of {len(self.rows)} rows of {self.name} belong to no sample ({listed}); if they were asked, samples are "
                "missing: --missing-samples accept goes on without them"
            )


def joined_rows(path: str, column: str) -> Joined:
    """Read the rows of a CSV file or of JSON lines.

    Raises
    ------
    InputError
        If the file cannot be read, has no such column, or has two rows with the same label in it.
    """
    rows: dict[str, Mapping[str, Any]] = {}
    columns: dict[str, None] = {}
    for where, row in _rows(path):
        if row.keys() != columns.keys():
            columns |= dict.fromkeys(row)
        value = row.get(column)
        label = label_text(value) if not isinstance(value, (list, dict)) else None
        if label is None:
            what = "is empty" if column in row else f"is not there; {nearest(column, row)}"
            raise InputError(f"{path}, {where}: {shown(column)} {what}")
        if label in rows:
            raise InputError(f"{path}, {where}: a row whose {shown(column)} is {shown(label)} is there already; each sample has one row")
        rows[label] = row
    if not rows:
        raise InputError(f"{path}: the file has no rows to join")
    typed = JSON.search(path) is not None
    kinds: set[type] = {str if isinstance(row[column], str) else int for row in rows.values()} if typed else set()
    if len(kinds) > 1:
        raise InputError(f"{path}: {shown(column)} is a number in some rows and a text in others; give it one form in all")
    return Joined(path, column, tuple(columns), rows, kinds)


def _rows(path: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    if JSON.search(path):
        yield from json_rows(path)
        return
    try:
        table = read_csv(path)
    except InputError as error:
        raise InputError(f"{error} (--join reads CSV and JSON lines)" if "not text" in str(error) else str(error)) from None
    names = list(table.columns)
    cells: Iterable[tuple[Any, ...]] = zip(*(table[name] for name in names), strict=True)
    for number, row in enumerate(cells, 1):
        yield f"row {number}", dict(zip(names, row, strict=True))
