"""The reader of delimited text: the same rows and lines by each of its functions, and the line that an error names."""

from __future__ import annotations

import csv
import io
from collections import Counter
from pathlib import Path
from random import Random

import pytest

from fairaudit.errors import InputError
from fairaudit.tables.csv import count_csv, first_row, layout, line_of_row, read_csv, same_layout, text_lines, title_rows

CELLS = ["a", "b", "1", "", " x ", 'a "b"', "1;2", "x,y", "two\nlines", "three\r\n\nlines", "é", "|", "a\tb"]


def written(rows: list[list[str]], delimiter: str, end: str) -> tuple[str, list[int]]:
    """A text, and the line on which each row ends, by the line ends in what is written so far."""
    text, lines = io.StringIO(newline=""), []
    quoting = csv.QUOTE_ALL if end == "\r" else csv.QUOTE_MINIMAL  # the writer leaves a line feed as it is where lines end otherwise
    writer = csv.writer(text, delimiter=delimiter, lineterminator=end, quoting=quoting)
    for row in rows:
        writer.writerow(row)
        before = text.getvalue().removesuffix(end).replace("\r\n", "\n").replace("\r", "\n")
        lines.append(before.count("\n") + 1)
    return text.getvalue(), lines


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_every_way_to_read_gives_the_same_rows_and_lines(tmp_path: Path, delimiter: str, end: str) -> None:
    pick, path = Random(f"{delimiter}{end}"), tmp_path / "log.csv"
    for width in (2, 3, 4):
        rows = [[pick.choice(CELLS) for _ in range(width)] for _ in range(30)]
        header = [f"c{i}" for i in range(width)]
        text, (_, *lines) = written([header, *rows], delimiter, end)
        path.write_bytes(text.encode())
        table = read_csv(path)
        assert (table.columns, list(table.lines), table.delimiter) == (header, lines, delimiter)
        assert [list(row) for row in zip(*(table[name] for name in header), strict=True)] == rows
        assert "".join(text_lines(path)) == text
        assert layout(path).columns == tuple(header)
        some = header[::-2]
        tally = count_csv([str(path)], some)
        read = [tuple(row[header.index(name)] for name in some) for row in rows]
        found = list(zip(*(tally[name] for name in some), strict=True))
        assert dict(zip(found, tally.counts.tolist(), strict=True)) == Counter(read) and tally.rows == len(rows)
        assert [tally.locate(i) for i in range(len(found))] == [f"line {lines[read.index(row)]}" for row in found]
        assert [line_of_row(str(path), i) for i in range(len(rows))] == lines
        for row in rows:
            assert first_row([str(path)], dict(enumerate(row))) == f"line {lines[rows.index(row)]}"


def test_of_several_files_lines_are_named_with_the_file(tmp_path: Path) -> None:
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    one.write_text("a,b\nx,1\n")
    two.write_text("a,b\nx,1\ny,2\n")
    tally = count_csv([str(one), str(two)], ["b"])
    assert (tally["b"], tally.counts.tolist()) == (["1", "2"], [2, 1])
    assert [tally.locate(0), tally.locate(1)] == [f"{one}, line 2", f"{two}, line 3"]
    assert first_row([str(one), str(two)], {0: "y"}) == f"{two}, line 3"
    assert first_row([str(one), str(two)], {0: "z"}) == "a row"
    two.write_text("b,a\n1,x\n")
    with pytest.raises(InputError, match="the header line differs from that of the first file"):
        count_csv([str(one), str(two)], ["b"])
    assert same_layout(None, layout(two)) == layout(two)
    with pytest.raises(InputError, match="the file changed while it was read"):
        line_of_row(str(one), 1)
    two.write_text("a,b\n")
    with pytest.raises(InputError, match=r"two.csv: the file has a header line but no rows"):
        count_csv([str(one), str(two)], ["b"])


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("shift", range(4))
def test_the_line_of_a_bad_byte_is_counted_across_blocks(tmp_path: Path, end: bytes, shift: int) -> None:
    """Blocks of 2^20 bytes end within a line end, and within a letter of two bytes."""
    path, line = tmp_path / "log.csv", "é".encode() * 2 + b"," + b"x" * (11 - len(end)) + end  # 16 bytes
    start = b"a,b" + b"c" * shift + end
    for lines in (1, (1 << 16) + 1):
        good = start + line * lines
        for bad in (b"\xc3", b"\xff" + end + b"x")[shift % 2 :]:
            path.write_bytes(good + b"ok," + bad)
            with pytest.raises(InputError, match=rf"^line {lines + 2} is not UTF-8 \(byte 0x{bad[0]:02x}\)"):
                list(text_lines(path))
        path.write_bytes(good + b"ok,\x00" + end)
        with pytest.raises(InputError, match=rf"^line {lines + 2} has a NUL character"):
            list(text_lines(path))


def test_columns_without_a_name_or_with_the_same_one_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("a,,b,a, \n1,2,3,4,5\n")
    assert read_csv(path).columns == ["a (column 1)", "column 2", "b", "a (column 4)", "column 5"]
    path.write_text("a,a (column 1),a\n1,2,3\n")
    with pytest.raises(InputError, match=r"the column name 'a \(column 1\)' occurs twice"):
        read_csv(path)


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        (["1,5", "2", "x"], ["1.5", "2", "x"]),
        (["1,500", "2,25"], ["1.500", "2.25"]),
        (["-,5", "+1,", "1,5e3", " 0,125 "], ["-.5", "+1.", "1.5e3", "0.125"]),
        (["0,125"], ["0.125"]),
        (["a,b", "1,5"], ["a,b", "1.5"]),
        (["1", "2"], ["1", "2"]),
        (["1,500", "2,250"], "may have a decimal comma or a thousands separator"),
        (["1,500,000"], "has thousands separators"),
        (["1,5", "2.5"], "has a decimal point"),
    ],
)
def test_decimal_commas_are_points_where_they_can_be_nothing_else(tmp_path: Path, cells: list[str], expected: list[str] | str) -> None:
    path = tmp_path / "log.csv"
    path.write_text("g;n\n" + "".join(f"f;{cell}\n" for cell in cells))
    if isinstance(expected, str):
        with pytest.raises(InputError, match=expected):
            read_csv(path).with_numbers(["n"])
        return
    found = read_csv(path).with_numbers(["g", "n", "other"])
    assert found["n"] == expected
    assert ("the numbers in column 'n' have decimal commas" in found.notes) == (expected != cells)
    path.write_text("g,n\n" + "".join(f'f,"{cell}"\n' for cell in cells))
    assert read_csv(path).with_numbers(["g", "n", "other"])["n"] == expected


@pytest.mark.parametrize(
    ("rows", "title"),
    [
        ([["T"], [], ["a", "b", "c"], ["1", "2", "3"]], 2),
        ([["T", ""], ["a", "b"], ["1", "2"]], 1),
        ([["T", "1973"], ["a", "b", "c", "d"], ["1", "2", "3", "4"]], 1),
        ([["T", "1973"], ["a", "b", "c"], ["1", "2", "3"]], 0),
        ([["", "x"], ["a", "b", "c", "d"]], 0),
        ([["a", "b"], ["1", "2"]], 0),
        ([["a"], ["1"], ["2"]], 0),
        ([[], ["a", "b", "c"]], 0),
        ([["T"]], 0),
        ([], 0),
    ],
)
def test_a_title_has_at_most_half_as_many_cells_as_the_rows(rows: list[list[str]], title: int) -> None:
    assert title_rows(rows) == title
