"""Rows of JSON of no known format: a line each, the elements of one list, or objects one after another."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Any

from fairaudit.errors import InputError, kind_of
from fairaudit.tables.evaluations.json_text import document, json_lines
from fairaudit.tables.evaluations.samples import Format, Run, Sample
from fairaudit.tables.values import refuse_tally

__all__ = ["ROWS", "json_rows"]

LINES = re.compile(r"\.(jsonl|ndjson)(\.\w+)?$", re.IGNORECASE)


def json_rows(path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    r"""Objects of a file, each with where it stands.

    Raises
    ------
    InputError
        If the file cannot be read, or something in it is no object.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "log.json"
    ...     _ = path.write_text('[{"p": 0.10},\n {"p": 1}]')
    ...     list(json_rows(str(path)))
    [('row 1', {'p': Decimal('0.10')}), ('row 2', {'p': 1})]
    """
    with document(path) as read:
        listed = read.peek() == "["
        if not listed and LINES.search(path):
            for line, row in json_lines(path):
                yield f"line {line}", row
            return
        for number in read.elements() if listed else _values(read):
            row = read.value()
            if not isinstance(row, dict):
                raise InputError(f"{path}: row {number + 1} is {kind_of(row)}; each row is an object")
            yield f"row {number + 1}", row
        read.end()


def _values(read: Any) -> Iterator[int]:
    """Count values that stand one after another."""
    count = 0
    while read.peek():
        yield count
        count += 1


def _rows(path: str, _: Collection[str]) -> Iterator[Sample]:
    for where, row in json_rows(path):
        refuse_tally(row)
        yield Sample(row, "read", where)


ROWS = Format("", lambda _: Run(""), _rows)
"""JSON of no known format."""
