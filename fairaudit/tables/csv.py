"""Delimited text files, read as text: numbers stay what the file says until they are parsed exactly."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from fairaudit.exact import InputError, shown

__all__ = ["CsvTable", "read_csv"]

DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
_DECIMAL_COMMA = re.compile(r"\s*[+-]?(\d+,\d*|,\d+)([eE][+-]?\d+)?\s*", re.ASCII)
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}(,\d{3})+\s*", re.ASCII)


@dataclass(frozen=True)
class CsvTable:
    """A table of texts, with the line of the file on which each row ends.

    Attributes
    ----------
    name : str
        File name, for messages.
    texts : dict of str to list of str
        Column name to its cells.
    lines : list of int
        Line number of each row.
    delimiter : str
        What separates the columns.
    notes : tuple of str
        What was noticed while reading.
    """

    name: str
    texts: dict[str, list[str]]
    lines: list[int] = field(repr=False)
    delimiter: str = ","
    notes: tuple[str, ...] = ()

    @property
    def columns(self) -> list[str]:
        """Column names, in order."""
        return list(self.texts)

    def __getitem__(self, name: str) -> list[str]:
        """Cells of a column."""
        return self.texts[name]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.lines)

    def locate(self, position: int) -> str:
        """Name the line of a row."""
        return f"line {self.lines[position]}"

    def with_numbers(self, columns: Iterable[str]) -> CsvTable:
        """Turn decimal commas into points in columns that hold numbers.

        A decimal comma is accepted only where commas do not separate the columns and where it cannot be a thousands separator: ``0,25``
        is, ``1,234`` alone is not.

        Raises
        ------
        InputError
            If a column's commas could be either.
        """
        texts, notes = dict(self.texts), list(self.notes)
        for name in columns:
            cells = texts.get(name)
            if self.delimiter == "," or cells is None or not any("," in cell for cell in cells):
                continue
            with_comma = [i for i, cell in enumerate(cells) if "," in cell]
            mixed = next((i for i, cell in enumerate(cells) if "." in cell), None)
            if mixed is not None:
                raise InputError(
                    f"column {shown(name)}, {self.locate(mixed)}: {shown(cells[mixed])} has a decimal point, and "
                    f"{shown(cells[with_comma[0]])} on {self.locate(with_comma[0])} a comma; use one of the two"
                )
            if all(_THOUSANDS.fullmatch(cells[i]) for i in with_comma):
                raise InputError(
                    f"column {shown(name)}, {self.locate(with_comma[0])}: {shown(cells[with_comma[0]])} may have a decimal comma or a "
                    "thousands separator; write it with a decimal point, or without separators"
                )
            texts[name] = [cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]
            notes.append(f"the numbers in column {shown(name)} have decimal commas")
        return replace(self, texts=texts, notes=tuple(notes))


def read_csv(path: str | os.PathLike[str]) -> CsvTable:
    """Read a delimited text file (UTF-8, with a header line).

    The delimiter (comma, semicolon, tab or bar) is found from the header line.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    CsvTable
        Its columns, usable wherever `Law` and `Utility` take a table.

    Raises
    ------
    InputError
        If it is not such a file; the message names the line.
    """
    name = os.fspath(path)
    if not name:
        raise InputError("the name of the table is empty; name a CSV file")
    try:
        return _parse(Path(path).name, _text(Path(path)))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file") from None
    except IsADirectoryError:
        raise InputError("this is a directory; name a CSV file") from None
    except (OSError, ValueError) as error:
        raise InputError(f"the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError("the file is UTF-16; save it as UTF-8")
    if data[:2] == b"\x1f\x8b" or data[:4] in (b"PK\x03\x04", b"PAR1"):
        raise InputError("the file is not text (it looks compressed, a spreadsheet or Parquet); save it as CSV")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"line {_line(data, error.start)} is not UTF-8 (byte 0x{data[error.start]:02x}); save the file as UTF-8") from None
    if b"\x00" in data:
        raise InputError(f"line {_line(data, data.index(0))} has a NUL character; a text file was expected")
    if not text.strip():
        raise InputError("the file is empty; a header line and at least one row were expected")
    return text


def _line(data: bytes, position: int) -> int:
    """Number of the line that a byte is on; lines end as the CSV reader ends them."""
    return len(re.findall(rb"\r\n?|\n", data[:position])) + 1


def _parse(name: str, text: str) -> CsvTable:
    delimiter = _delimiter(text)
    rows = _rows(text, delimiter)
    _, header = next(rows)
    known: set[str] = set()
    for position, column in enumerate(header):
        if not column.strip():
            raise InputError(f"column {position + 1} has no name in the header line; name every column")
        if column in known:
            raise InputError(f"the column name {shown(column)} occurs twice in the header line; give each column its own name")
        known.add(column)
    cells: list[list[str]] = []
    lines: list[int] = []
    for line, row in rows:
        if len(row) != len(header):
            raise InputError(f"line {line} has {len(row)} {'cell' if len(row) == 1 else 'cells'} where the header has {len(header)}")
        cells.append(row)
        lines.append(line)
    if not cells:
        raise InputError("the file has a header line but no rows")
    columns = {column: list(values) for column, values in zip(header, zip(*cells, strict=True), strict=True)}
    notes = () if delimiter == "," else (f"the columns are separated by {DELIMITERS[delimiter]}",)
    return CsvTable(name, columns, lines, delimiter, notes)


def _rows(text: str, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Rows that are not blank, with the number of the line on which each ends."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        for row in reader:
            if row:
                yield reader.line_num, row
    except csv.Error as error:
        what = {
            "field larger than field limit (131072)": "a cell has more than 131,072 characters",
            f"'{delimiter}' expected after '\"'": "text follows the end of a quoted cell; double the quotation marks inside it",
            "unexpected end of data": "a quoted cell is not closed before the end of the file",
        }.get(str(error), str(error))
        raise InputError(f"line {reader.line_num}: {what}") from None


def _delimiter(text: str) -> str:
    first = text.lstrip("\r\n")[:200_000]

    def width(delimiter: str) -> int:
        try:
            return len(next(csv.reader(io.StringIO(first, newline=""), delimiter=delimiter)))
        except (csv.Error, StopIteration):
            return 0

    return max(DELIMITERS, key=width)
