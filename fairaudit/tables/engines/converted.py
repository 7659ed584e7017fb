"""Files that are written anew as text or Parquet before they are read: spreadsheets, files of statistics programs, archives, UTF-16."""

from __future__ import annotations

import csv
import io
import os
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.compressed import is_compressed
from fairaudit.tables.csv import TOP, opened, title_rows, titled
from fairaudit.tables.engines.paths import Form, form
from fairaudit.tables.engines.request import Request
from fairaudit.tables.label_text import label_text
from fairaudit.tables.number_form import plain_numbers, unmistakable
from fairaudit.tables.tally import refuse_loss
from fairaudit.words import noun

if TYPE_CHECKING:
    from fairaudit.tables.evaluations.samples import Format

__all__ = ["check_encoding", "converted", "format_of_file", "refuse_another_format"]

BLOCK = 1 << 20
MOST_INSIDE = 1000  # times the size of an archive that its file may have: more is a trap, not a table
EXTRA = "pip install 'fairaudit-certify[files]'"


@contextmanager
def converted(paths: Sequence[str], request: Request) -> Iterator[tuple[list[str], bool]]:
    """Put a copy that readers understand in the place of each file that they do not, and say whether any was copied.

    Lines keep their numbers, and what is said of a copy is said of the file.

    Raises
    ------
    InputError
        If a file cannot be converted.
    """
    with tempfile.TemporaryDirectory(prefix="fairaudit-") as folder:
        names: dict[str, str] = {}
        listed: list[str] = []
        for number, path in enumerate(paths):
            place = Path(folder) / str(number)
            try:
                copy = _copied(path, place, request)
            except InputError as error:
                said = _of_originals(str(error), names)
                raise InputError(said if said.startswith(path) else f"{path}: {said}") from None
            if copy != path:
                names[copy] = path
            listed.append(copy)
        try:
            yield listed, bool(names)
        except InputError as error:
            said = _of_originals(str(error), names)
            if said == str(error):
                raise
            raise type(error)(said) from None


def format_of_file(path: str, *, named: bool = False) -> Format | None:
    """The format of an evaluation log, by its content whatever its name; None of a table, or of objects of a format that is `named`.

    Raises
    ------
    InputError
        If the file cannot be read, or is compressed and holds objects of no known format under a name that says nothing of them.
    """
    kind = "folder" if os.path.isdir(path) else form(path)  # noqa: PTH112
    if kind == "csv" and not _like_json(path):
        return None
    if kind not in ("folder", "json", "zip", "csv"):
        return None
    from fairaudit.tables.evaluations.detection import detect

    found = detect(path)
    if found is None and not named and kind == "csv" and _packed_objects(path):
        raise InputError(
            f"{path}: what is compressed begins like JSON, and is no log of a known format; unpack it first, or compress it by gzip, and "
            "let its name end in .jsonl.gz"
        )
    return found


def refuse_another_format(path: str, named: str) -> None:
    """Refuse a file that is no log of the format that was named, as its content says; JSON that does not say it may be one.

    Raises
    ------
    InputError
        If it is none, or cannot be read.
    """
    found = format_of_file(path, named=True)
    if found is not None:
        from fairaudit.tables.evaluations.detection import could_be

        if found.name != named and not could_be(path, named):
            raise InputError(f"{path} is a log of {found.name} by its content, and none of {named}; leave --log-format (log_format) out")
    elif not os.path.isdir(path) and not (form(path) == "json" or (form(path) == "csv" and _like_json(path))):  # noqa: PTH112
        raise InputError(f"{path} is no log of {named}: logs are JSON or lines of JSON, and those of inspect may be .eval files, too")


def _like_json(path: str) -> bool:
    """Whether a text begins as JSON does; refused if what is compressed is an archive."""
    try:
        start = _start(path)
    except InputError:
        return False  # what is wrong is said by the reader of tables
    if start.startswith(b"PK\x03\x04"):
        raise InputError(f"{path}: what is compressed is an archive, such as a log of inspect; unpack it first, and name what comes out")
    return start.startswith((b"{", b"[")) or not start


def _packed_objects(path: str) -> bool:
    """Whether an object begins what is compressed."""
    with Path(path).open("rb") as file:
        packed = is_compressed(file.read(6))
    return packed and _start(path).startswith(b"{")


def _start(path: str) -> bytes:
    """How a text begins, blanks aside."""
    with opened(Path(path)) as text:
        return text.read(BLOCK).removeprefix(b"\xef\xbb\xbf").lstrip()


def _refuse_log(copy: str, done: str) -> None:
    """Refuse a log of an evaluation that a copy is, rather than read it as rows."""
    known = format_of_file(copy)
    if known is not None:
        raise InputError(f"what is inside is a log of {known.name}, which is read from a file of its own; {done}")


def _of_originals(said: str, names: dict[str, str]) -> str:
    for copy, path in names.items():
        said = said.replace(copy, path).replace(f"{Path(path).name}.csv:", f"{Path(path).name}:")
    return said


def _copied(path: str, place: Path, request: Request) -> str:
    """The file itself, or a copy that can be read."""
    kind = form(path)
    if kind == "zip":
        place.mkdir(parents=True)
        inside = _unpacked(path, place)
        _refuse_log(inside, "unpack it first, and name what comes out")
        return _copied(inside, place / "inside", request)
    convert = CONVERSIONS.get(kind)
    if request.encoding is not None and kind not in ("csv", "utf-16", "zip"):
        raise InputError(f"an encoding is that of a text that is not UTF-8; this is {kind}")
    if convert is None and not request.skip and request.encoding is None:
        return path
    if request.table is not None and kind != "spreadsheet":
        raise InputError(f"a table is that of a database, or a sheet of a spreadsheet; this is {kind}")
    place.mkdir(parents=True)
    copy = place / f"{Path(path).name}{'.csv' if kind == 'statistics' else ''}"
    if convert is not None:
        convert(path, copy, request)
        if kind == "utf-16":
            _refuse_log(str(copy), "save it as UTF-8 first")
    elif request.encoding is not None:
        _decoded(path, copy, request)
    elif kind == "csv":
        _below(path, copy, request.skip)
    else:
        raise InputError(f"lines are skipped above the header of text and of spreadsheets; this is {kind}")
    return str(copy)


def _unpacked(path: str, place: Path) -> str:
    """The one file in an archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            inside = [info for info in archive.infolist() if not info.is_dir() and not info.filename.startswith("__MACOSX/")]
            if len(inside) != 1:
                names = f" ({', '.join(shown(info.filename) for info in inside[:5])})" if inside else ""
                raise InputError(f"the archive holds {len(inside)} files{names}, not one; unpack it and name what is to be read")
            (info,) = inside
            if info.flag_bits & 1:
                raise InputError("the archive is encrypted; unpack it first")
            if info.file_size > max(BLOCK, MOST_INSIDE * Path(path).stat().st_size):
                raise InputError(f"the archive says that it unpacks to {info.file_size:,} bytes; unpack it yourself, if you trust it")
            copy = place / (Path(info.filename).name or "table")
            with archive.open(info) as source, copy.open("wb") as target:
                shutil.copyfileobj(source, target, BLOCK)
            return str(copy)
    except (zipfile.BadZipFile, NotImplementedError, EOFError, OSError) as error:
        raise InputError(f"the archive cannot be unpacked: {error}") from None


def _below(path: str, copy: Path, skip: int) -> None:
    """The lines of a text below those to be skipped, which are left empty."""
    with opened(Path(path)) as source, copy.open("wb") as target:
        for _ in range(skip):
            if not source.readline():
                raise InputError(f"{skip} {noun(skip, 'line was', 'lines were')} to be skipped, and the file has no more than that")
            target.write(b"\n")
        shutil.copyfileobj(source, target, BLOCK)


def _decoded(path: str, copy: Path, request: Request) -> None:
    """The same text in UTF-8, of which the encoding was named."""
    encoding, line = check_encoding(request.encoding or ""), 0
    with opened(Path(path), {}) as source, copy.open("w", encoding="utf-8", newline="") as target:
        try:
            with io.TextIOWrapper(source, encoding=encoding, newline="") as lines:
                for line, text in enumerate(lines):
                    kept = text.removeprefix("\ufeff") if line == 0 else text
                    target.write("\n" if line < request.skip else kept)
        except UnicodeError as error:
            raise InputError(f"the text is not {encoding} (after line {line}: {error}); name the encoding in which it was saved") from None


def check_encoding(name: str) -> str:
    """Refuse an encoding that Python does not know, or that is not one of texts.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> check_encoding("latin-1")
    'latin-1'
    """
    try:
        if "a,\n".encode(name).decode(name) == "a,\n" and "escape" not in name.lower():
            return name
    except (LookupError, UnicodeError, ValueError):
        pass
    raise InputError(f"the encoding {shown(name)} is not known; cp1252, latin-1, utf-16 or another that Python knows is accepted")


def _from_utf16(path: str, copy: Path, request: Request) -> None:
    """The same text in UTF-8."""
    try:
        with Path(path).open(encoding="utf-16", newline="") as source, copy.open("w", encoding="utf-8", newline="") as target:
            for line, text in enumerate(source):
                target.write("\n" if line < request.skip else text)
    except UnicodeError as error:
        raise InputError(f"the file begins like UTF-16 and is none ({error}); save it as UTF-8") from None


def _from_spreadsheet(path: str, copy: Path, request: Request) -> None:
    """The rows of a sheet."""
    library = _library("python_calamine", "spreadsheets")
    try:
        with Path(path).open("rb") as file:  # what it is, is found from its bytes, not from its name
            book = library.CalamineWorkbook.from_filelike(file)
            sheets = {name: book.get_sheet_by_name(name) for name in book.sheet_names}
    except Exception as error:
        raise InputError(f"the spreadsheet cannot be read: {error}") from None
    if request.table is not None and request.table not in sheets:
        raise InputError(f"there is no sheet {shown(request.table)}; {nearest(request.table, list(sheets))}")
    filled = {name: sheet for name, sheet in sheets.items() if sheet.height and request.table in (None, name)}
    if len(filled) > 1:
        raise InputError(f"the file has the sheets {', '.join(map(shown, filled))}; name one with table (--table)")
    if not filled:
        raise InputError("the sheet is empty; a header line and at least one row were expected")
    (sheet,) = filled.values()
    _write(copy, _with_plain_numbers(sheet.to_python(skip_empty_area=False), request), request.skip)


def _with_plain_numbers(rows: Sequence[Sequence[Any]], request: Request) -> Sequence[Sequence[Any]]:
    """Cells of columns of numbers that are texts, with the numbers that they say; cells of numbers as texts that no mark makes unclear."""
    top = next((place for place, row in enumerate(rows) if place >= request.skip and any(cell != "" for cell in row)), len(rows))
    places = [place for place, cell in enumerate(rows[top] if top < len(rows) else ()) if cell in request.numeric]
    found = [list(row) for row in rows] if places else rows
    for place in places:
        lines = [line for line in range(top + 1, len(rows)) if place < len(rows[line])]
        held = [rows[line][place] for line in lines]
        texts = [cell if isinstance(cell, str) else "" for cell in held]
        plain = plain_numbers(str(rows[top][place]), texts, lambda at, lines=lines: f"line {lines[at] + 1}", request.form) or texts  # type: ignore[misc]
        for line, cell, text in zip(lines, held, plain, strict=True):
            found[line][place] = text if isinstance(cell, str) else unmistakable(cell)  # type: ignore[index]
    return found


def _from_statistics(path: str, copy: Path, request: Request) -> None:
    """The rows of a file of Stata, SPSS or SAS, codes with their labels."""
    library = _library("pyreadstat", "files of statistics programs")
    suffix = Path(path).suffix.lower().removeprefix(".")
    read = getattr(library, f"read_{'xport' if suffix == 'xpt' else 'sav' if suffix == 'zsav' else suffix}")
    try:
        columns, about = read(path, output_format="dict")
    except Exception as error:
        raise InputError(f"the file cannot be read: {error}") from None
    if request.skip:
        raise InputError("lines are skipped above the header of text and of spreadsheets; columns have names here")
    labels = about.variable_value_labels
    texts = [[labels[name].get(value, value) for value in held] if name in labels else held for name, held in columns.items()]
    _write(copy, _with_plain_numbers([list(columns), *zip(*texts, strict=True)], request), 0)


def _from_arrow(path: str, copy: Path, request: Request) -> None:
    """The same columns as Parquet."""
    arrow = _library("pyarrow", "Feather, Arrow and ORC files")
    import pyarrow.parquet as parquet

    if request.skip:
        raise InputError("lines are skipped above the header of text and of spreadsheets; columns have names here")
    try:
        if form(path) == "orc":
            import pyarrow.orc as orc

            table = orc.read_table(path)
        else:
            import pyarrow.feather as feather

            table = feather.read_table(path, memory_map=True)
        parquet.write_table(table, copy)
        refuse_loss(Path(path).name, parquet.read_metadata(copy).num_rows, table.num_rows, "pyarrow")
    except (arrow.ArrowException, OSError, ValueError) as error:
        raise InputError(f"the file cannot be read: {error}") from None


def _library(name: str, what: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(f"{what} need the library {name.replace('_', '-')}; {EXTRA}, or save the table as CSV") from None


def _write(copy: Path, rows: Sequence[Sequence[Any]], skip: int) -> None:
    """Write cells as the texts of their labels, each row on the line of its number; columns of nothing are left out."""
    if skip >= len(rows):
        raise InputError(f"{skip} {noun(skip, 'line was', 'lines were')} to be skipped, and the sheet has {len(rows)}")
    below = enumerate(rows[skip:], skip + 1)
    texts: list[list[str]] = [[]] * skip + [[_text(cell, line, place) for place, cell in enumerate(row, 1)] for line, row in below]
    width = max((place for row in texts for place, text in enumerate(row, 1) if text), default=0)
    if not width:
        raise InputError("the sheet is empty; a header line and at least one row were expected")
    first = next(number for number, row in enumerate(texts) if any(row))
    if title := title_rows(texts[first : first + TOP]):
        raise titled(first + 1, texts[first], first + title)
    with copy.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for row in texts:
            if any(row):
                writer.writerow((*row, *[""] * (width - len(row)))[:width])
            else:
                file.write("\n")


def _text(cell: Any, line: int, place: int) -> str:
    try:
        text = label_text(cell) or ""
    except InputError as error:
        raise InputError(f"line {line}, column {place}: {error}") from None
    return " ".join(text.splitlines()) if "\n" in text or "\r" in text else text


CONVERSIONS: dict[Form, Callable[[str, Path, Request], None]] = {
    "utf-16": _from_utf16,
    "spreadsheet": _from_spreadsheet,
    "statistics": _from_statistics,
    "arrow": _from_arrow,
    "orc": _from_arrow,
}
