"""Delimited text files, read as text: numbers stay what the file says until they are parsed exactly."""

from __future__ import annotations

import codecs
import csv
import io
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from operator import itemgetter
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.tables import compressed
from fairaudit.tables.number_form import PLAIN, NumberForm, NumberKind, plain_numbers
from fairaudit.tables.preparation import Entry
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column
from fairaudit.words import brief

__all__ = [
    "SMALL",
    "CsvTable",
    "Layout",
    "count_csv",
    "decimal_commas",
    "first_row",
    "layout",
    "line_of_row",
    "number_of_lines",
    "opened",
    "read_csv",
    "same_layout",
    "text_lines",
    "title_rows",
    "titled",
]

SMALL = 4_000_000  # bytes that our own reader takes less time for than DuckDB takes to be imported
HEAD = 200_000  # characters that say which separator and which decimal mark a file has
TOP = 50  # rows that say whether a table begins with a title
EMPTY = "the file is empty; a header line and at least one row were expected"
NO_TEXT = dict.fromkeys((b"\xff\xfe", b"\xfe\xff"), "the file is UTF-16; save it as UTF-8") | dict.fromkeys(
    (b"PK\x03\x04", b"PAR1", compressed.ZSTANDARD),
    "the file is not text (it looks like Zstandard, a spreadsheet or Parquet); save it as CSV",
)
DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}


@brief
@dataclass(frozen=True, repr=False)
class CsvTable:
    """A table of texts, with the line of the file on which each row ends.

    Attributes
    ----------
    name : str
        File name, for messages.
    texts : mapping of str to sequence of str
        Column name to its cells; counts may be an array of integers.
    lines : sequence of int
        Line number of each row.
    delimiter : str
        What separates the columns.
    notes : tuple of str
        What was noticed while reading.
    preparation : tuple of mapping
        What was done to labels since (`fairaudit.tables.preparation`).

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = fa.example("ucb-admissions").table()
    >>> len(table), table["Gender"][:2]
    (24, ['Male', 'Male'])
    """

    name: str
    texts: Mapping[str, Sequence[str] | NDArray[np.int64]]
    lines: Sequence[int] = field(repr=False)
    delimiter: str = ","
    notes: tuple[str, ...] = ()
    preparation: tuple[Entry, ...] = ()

    @property
    def columns(self) -> list[str]:
        """Column names, in order."""
        return list(self.texts)

    def __getitem__(self, name: str) -> Any:
        """Cells of a column."""
        return self.texts[name]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.lines)

    def locate(self, position: int) -> str:
        """Name the line of a row."""
        return f"line {self.lines[position]}"

    def with_numbers(self, columns: Iterable[str] | Mapping[str, NumberKind], form: NumberForm = PLAIN) -> CsvTable:
        """Write the numbers of columns with decimal points, without separators and signs (`plain_numbers`).

        A mapping says what kind of numbers each column holds; else they are taken for shares.

        Raises
        ------
        InputError
            If the marks of a column could be either, or a number is not written as declared.
        """
        kinds: Mapping[str, NumberKind] = columns if isinstance(columns, Mapping) else dict.fromkeys(columns, "share")
        texts, notes = dict(self.texts), list(self.notes)
        for name, kind in kinds.items():
            cells = texts.get(name)
            if cells is None or isinstance(cells, np.ndarray) or (form == PLAIN and kind == "share" and "," not in "".join(cells)):
                continue
            found = plain_numbers(name, cells, self.locate, form, kind)
            if found is not None:
                texts[name] = found
                notes += decimal_commas(name, cells, form)
        return replace(self, texts=texts, notes=tuple(notes))


def decimal_commas(name: str, cells: Iterable[Any], form: NumberForm) -> list[str]:
    """Say that the commas of a column, of which nothing was declared, were taken for decimal commas; nothing where it has none."""
    taken = form == PLAIN and any("," in cell for cell in cells if isinstance(cell, str))
    return [f"the numbers in column {shown(name)} have decimal commas"] if taken else []


@dataclass(frozen=True)
class Layout:
    """How a delimited text file is laid out: its delimiter and the columns of its header line."""

    delimiter: str
    columns: tuple[str, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """What is worth saying of it."""
        return () if self.delimiter == "," else (f"the columns are separated by {DELIMITERS[self.delimiter]}",)


@answered
def read_csv(path: str | os.PathLike[str]) -> CsvTable:
    """Read a delimited text file (UTF-8, with a header line), compressed or not.

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

    Examples
    --------
    >>> from fairaudit.tables.examples import example
    >>> table = read_csv(example("ucb-admissions").path)
    >>> table.columns, len(table)
    (['Dept', 'Gender', 'Admit', 'Freq'], 24)
    """
    name = os.fspath(path)
    if not name:
        raise InputError("the name of the table is empty; name a CSV file")
    try:
        return _parse(Path(path).name, _text(Path(path)))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def layout(path: str | os.PathLike[str]) -> Layout:
    """Read the header line of a delimited text file.

    Raises
    ------
    InputError
        If there is none; the message does not name the file.
    """
    with opened(Path(path)) as file:
        start = file.read(HEAD).decode("utf-8-sig", "replace")
    if not start.strip():
        raise InputError(EMPTY)
    delimiter = _delimiter(start)
    _refuse_title(start, delimiter)
    _, header = next(_rows(text_lines(Path(path)), delimiter))
    return Layout(delimiter, _header(header))


def count_csv(paths: Sequence[str], columns: Sequence[str], report: Callable[[int], None] | None = None) -> Tally:
    """Count the equal rows of delimited text files, which have the same columns, reading each once and line by line.

    Parameters
    ----------
    paths : sequence of str
        The files.
    columns : sequence of str
        The columns that matter.
    report : callable, optional
        Told now and then how many rows have been read.

    Returns
    -------
    Tally
        The different rows with their counts; `Tally.locate` names the line on which one occurs first.

    Raises
    ------
    InputError
        If a file is not such a file; the message names the file and the line.
    """
    counts: dict[tuple[str, ...], int] = {}
    first: dict[tuple[str, ...], str] = {}
    found: Layout | None = None
    read = 0
    for path in paths:
        where = f"{path}, " if len(paths) > 1 else ""
        try:
            found = same_layout(found, layout(path))
            picked = [_position(found, name) for name in columns]
            pick = itemgetter(*picked) if len(picked) > 1 else lambda row, only=picked[0]: (row[only],)
            width, before = len(found.columns), read
            rows = _rows(text_lines(Path(path)), found.delimiter)
            next(rows)
            for line, row in rows:
                if len(row) != width:
                    raise InputError(_wrong_width(line, len(row), width))
                key = pick(row)
                if key in counts:
                    counts[key] += 1
                else:
                    counts[key], first[key] = 1, f"{where}line {line}"
                read += 1
                if report is not None and not read % 100_000:
                    report(read)
            if read == before:
                raise InputError("the file has a header line but no rows")
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    places = list(first.values())
    cells = ((*key, count) for key, count in counts.items())
    tally = Tally.of(Path(paths[0]).name, columns, cells, find=lambda _, i: places[i], notes=found.notes if found else ())
    return tally.conserving(read, "fairaudit")


def first_row(paths: Sequence[str], wanted: Mapping[int, str]) -> str:
    """Name the line of the first row whose cells, given by their positions, are as wanted."""
    for path in paths:
        rows = _rows(text_lines(Path(path)), layout(path).delimiter)
        for line, row in rows:
            if all(row[position] == text for position, text in wanted.items()):
                return f"{path}, line {line}" if len(paths) > 1 else f"line {line}"
    return "a row"


def line_of_row(path: str, position: int) -> int:
    """Number of the line on which a row of a text ends, of which the first has the position 0.

    Raises
    ------
    InputError
        If the text has no such row any more.
    """
    rows = _rows(text_lines(Path(path)), layout(path).delimiter)
    found = next(islice(rows, position + 1, None), None)
    if found is None:
        raise InputError(f"{path}: the file changed while it was read")
    return found[0]


def number_of_lines(paths: Sequence[str]) -> int | None:
    """Count the lines of texts, blank ones among them; None if what is compressed cannot be opened here."""
    feeds = 0
    try:
        for path in paths:
            last = b"\n"
            with opened(Path(path)) as file:
                while block := file.read(1 << 24):
                    feeds, last = feeds + block.count(b"\n"), block
            feeds += not last.endswith(b"\n")
    except InputError:
        return None
    return feeds


def same_layout(known: Layout | None, found: Layout) -> Layout:
    """Refuse a file whose header differs from that of the first."""
    if known is not None and found != known:
        raise InputError(
            "the header line differs from that of the first file; files that are read together have the same columns in one order"
        )
    return found


def _position(found: Layout, name: str) -> int:
    column(dict.fromkeys(found.columns, ()), name)
    return found.columns.index(name)


def _wrong_width(line: int, cells: int, width: int) -> str:
    return f"line {line} has {cells} {'cell' if cells == 1 else 'cells'} where the header has {width}"


def opened(path: Path, unfit: Mapping[bytes, str] = NO_TEXT) -> AbstractContextManager[IO[bytes]]:
    """Open a file of text, or what is inside if it is compressed."""
    return compressed.opened(path, unfit)


def _text(path: Path) -> str:
    with opened(path) as file:
        data = file.read()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(_not_utf8(_line(data, error.start), data[error.start])) from None
    if b"\x00" in data:
        raise InputError(_nul(_line(data, data.index(0))))
    if not text.strip():
        raise InputError(EMPTY)
    return text


def text_lines(path: Path) -> Iterator[str]:
    """Lines of a text file with their ends; lines end as the CSV reader ends them."""
    with opened(path) as file:
        reader = io.TextIOWrapper(file, encoding="utf-8-sig", newline="")
        line = 0
        try:
            for text in reader:
                line += 1
                if "\x00" in text:
                    raise InputError(_nul(line))
                yield text
        except UnicodeDecodeError:
            pass
        else:
            reader.detach()
            if line or not _is_cut_mark(path):
                return
    raise InputError(_not_utf8(*_first_bad_byte(path)))


def _is_cut_mark(path: Path) -> bool:
    """Whether a file is the beginning of a byte order mark and nothing else, which the decoder takes for no text at all."""
    with opened(path) as file:
        return file.read(3) in (b"\xef", b"\xef\xbb")


def _first_bad_byte(path: Path) -> tuple[int, int]:
    """Line and value of the first byte that is not UTF-8."""
    decoder, line, ended = codecs.getincrementaldecoder("utf-8")(), 1, b""
    with opened(path) as file:
        while True:
            data = file.read(1 << 20)
            kept = decoder.getstate()[0]
            try:
                decoder.decode(data, final=not data)
            except UnicodeDecodeError as error:
                whole = kept + data
                return line + _line(ended + whole[: error.start], len(ended) + error.start) - 1, whole[error.start]
            if not data:
                raise InputError("the file changed while it was read")
            # A carriage return at the end of a block may belong to a line feed at the start of the next.
            block = ended + kept + data
            block = block[: len(block) - len(decoder.getstate()[0])]
            ended = b"\r" if block.endswith(b"\r") else b""
            line += _line(block, len(block) - len(ended)) - 1


def _not_utf8(line: int, byte: int) -> str:
    proposed = "name its encoding, such as encoding='cp1252' (--encoding cp1252)"
    return f"line {line} is not UTF-8 (byte 0x{byte:02x}); save the file as UTF-8, or {proposed}"


def _nul(line: int) -> str:
    return f"line {line} has a NUL character; a text file was expected"


def _line(data: bytes, position: int) -> int:
    """Number of the line that a byte is on; lines end as the CSV reader ends them."""
    return len(re.findall(rb"\r\n?|\n", data[:position])) + 1


def _parse(name: str, text: str, *, labels: bool = False) -> CsvTable:
    delimiter = _delimiter(text)
    _refuse_title(text[:HEAD], delimiter)
    rows = _rows(io.StringIO(text, newline=""), delimiter)
    _, first = next(rows)
    header = _header(first, labels=labels)
    cells: list[list[str]] = []
    lines: list[int] = []
    for line, row in rows:
        if len(row) != len(header):
            raise InputError(_wrong_width(line, len(row), len(header)))
        cells.append(row)
        lines.append(line)
    if not cells:
        raise InputError("the file has a header line but no rows")
    columns = {column: list(values) for column, values in zip(header, zip(*cells, strict=True), strict=True)}
    return CsvTable(name, columns, lines, delimiter, Layout(delimiter, header).notes)


def _header(row: Sequence[str], *, labels: bool = False) -> tuple[str, ...]:
    """The names of columns, told apart where they are missing or repeated; of a matrix they are labels, which nobody may make up."""
    names = list(row)
    if not labels:
        names = [name if name.strip() else f"column {position}" for position, name in enumerate(row, 1)]
        times = Counter(names)
        names = [f"{name} (column {position})" if times[name] > 1 else name for position, name in enumerate(names, 1)]
    known: set[str] = set()
    for position, name in enumerate(names, 1):
        if not name.strip():
            raise InputError(f"column {position} has no name in the header line; name every column")
        if name in known:
            raise InputError(f"the column name {shown(name)} occurs twice in the header line; give each column its own name")
        known.add(name)
    return tuple(names)


def title_rows(rows: Sequence[Sequence[str]]) -> int:
    """How many rows at the top are a title, and no header: the first has something in its first cell, and in few others.

    Examples
    --------
    >>> title_rows([["Admissions 1973"], [], ["Dept", "Gender", "Admit"], ["A", "f", "yes"], ["A", "m", "no"]])
    2
    >>> title_rows([["Dept", "Gender", "Admit"], ["A", "f", "yes"]])
    0
    """
    filled = [sum(1 for cell in row if cell.strip()) for row in rows]
    below = [cells for cells in filled[1:] if cells]
    usual = max(sorted(below, reverse=True), key=below.count, default=0)
    if not rows or not rows[0] or not rows[0][0].strip() or 2 * filled[0] > usual:
        return 0
    return next(number for number, cells in enumerate(filled) if cells >= usual)


def titled(line: int, row: Sequence[str], skip: int) -> InputError:
    """Say that a table begins with a title."""
    text = next(cell for cell in row if cell.strip())
    return InputError(
        f"line {line} has {shown(text, 60)} where a header was expected, which looks like a title; skip what is above the header "
        f"(--skip {skip})"
    )


def _refuse_title(start: str, delimiter: str) -> None:
    """Refuse a text that begins with a title; where no delimiter is on its first line, those below may be separated by any."""
    for separator in DELIMITERS if _width(start, delimiter) == 1 else (delimiter,):
        reader = csv.reader(io.StringIO(start, newline=""), delimiter=separator, strict=True)
        rows: list[tuple[int, list[str]]] = []
        with suppress(csv.Error):
            rows.extend((reader.line_num, row) for row in islice(reader, TOP) if row or rows)
        if title := title_rows([row for _, row in rows]):
            raise titled(rows[0][0], rows[0][1], rows[title - 1][0])


def _rows(lines: Iterable[str], delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Rows that are not blank, with the number of the line on which each ends."""
    reader = csv.reader(lines, delimiter=delimiter, strict=True)
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
    return max(DELIMITERS, key=lambda delimiter: _width(text, delimiter))


def _width(text: str, delimiter: str) -> int:
    """How many cells the first line has."""
    try:
        return len(next(csv.reader(io.StringIO(text.lstrip("\r\n")[:HEAD], newline=""), delimiter=delimiter)))
    except (csv.Error, StopIteration):
        return 0
