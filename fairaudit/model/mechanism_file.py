"""Filters from delimited text files: one row per input and output, or a table with a row per input and a column per output."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from fairaudit.arguments import answered
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.rationals import parse_rational, rational_text
from fairaudit.model.mechanism import Mechanism
from fairaudit.tables.csv import CsvTable, _parse, _text
from fairaudit.tables.values import names

__all__ = ["read_mechanism", "read_mechanism_with_notes"]


PROBABILITY = "probability"

CORNER = "(input)"

RESIDUE = Fraction(1, 10**6)


# The empty corner cell that many programs write, after leading blank lines.
_EMPTY_CORNER = re.compile(r'([\r\n]*)[ ]*(?:"[ ]*")?(?=[,;\t|])')


@answered
def read_mechanism(
    path: str | os.PathLike[str],
    *,
    input: str | Sequence[str] | None = None,  # noqa: A002
    output: str | Sequence[str] | None = None,
    probability: str | None = None,
) -> Mechanism:
    r"""Read a filter from a delimited text file, exactly.

    Two forms are accepted. *Long*: one row per input and output with columns for the true value, the released value and the probability;
    pairs without a row have probability 0. *Table*: labels of the inputs in the first column, of the outputs in the first row (its first
    cell may be empty). A file is long if columns are named here, or if it has a column ``probability`` and columns whose names start with
    ``input`` and with ``output``.

    Parameters
    ----------
    path : path-like
        The file.
    input, output : str or sequence of str, optional
        Columns of the true and of the released value; by default those whose names start so.
    probability : str, optional
        Column of the probability; ``probability`` by default.

    Returns
    -------
    Mechanism
        The filter, one table over all its columns. Rows that are off 1 by at most 1e-6 are normalised exactly.

    Raises
    ------
    InputError
        If it is not such a file; the message names line and column.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "filter.csv"
    ...     _ = path.write_text("true,f,m\nf,0.75,0.25\nm,0.25,0.75\n")
    ...     read_mechanism(path).probability("f", "m")
    Fraction(1, 4)
    """
    return read_mechanism_with_notes(path, input=input, output=output, probability=probability)[0]


def read_mechanism_with_notes(
    path: str | os.PathLike[str],
    *,
    input: str | Sequence[str] | None = None,  # noqa: A002
    output: str | Sequence[str] | None = None,
    probability: str | None = None,
) -> tuple[Mechanism, tuple[str, ...]]:
    """Read a filter as `read_mechanism` does, and say what was noticed."""
    name = os.fspath(path)
    if not name:
        raise InputError("the name of the filter's file is empty; name a CSV file")
    try:
        text = _text(Path(path))
        table = _parse(
            Path(path).name, _EMPTY_CORNER.sub(rf"\g<1>{CORNER}", text, count=1) if _EMPTY_CORNER.match(text) else text, labels=True
        )
        sides = names(input) or _starting(table, "input"), names(output) or _starting(table, "output")
        asked = bool(input or output or probability)
        if asked or (PROBABILITY in table.columns and all(sides)):
            return _long(table, *sides, probability or PROBABILITY)
        return _square(table)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _starting(table: CsvTable, word: str) -> tuple[str, ...]:
    return tuple(column for column in table.columns if column.strip().lower().startswith(word))


def _long(table: CsvTable, inputs: tuple[str, ...], outputs: tuple[str, ...], probability: str) -> tuple[Mechanism, tuple[str, ...]]:
    used = [*inputs, *outputs, probability]
    for what, side in (("input", inputs), ("output", outputs)):
        if not side:
            raise InputError(f"no column was named for the {what}, and no column's name starts with {what!r}; name it")
    for column in used:
        if column not in table.columns:
            raise InputError(f"there is no column {shown(column)}; {nearest(column, table.columns)}")
        if used.count(column) > 1:
            raise InputError(f"the column {shown(column)} is used twice; each column has one role")
    table = table.with_numbers([probability])
    cells: list[Fraction] = [_cell(table, probability, i, table.locate(i)) for i in range(len(table))]
    totals: dict[tuple[str, ...], tuple[Fraction, int]] = {}
    seen: dict[tuple[tuple[str, ...], tuple[str, ...]], int] = {}
    labels = (list(zip(*(table[column] for column in side), strict=True)) for side in (inputs, outputs))
    for i, (label, released) in enumerate(zip(*labels, strict=True)):
        if (first := seen.setdefault((label, released), i)) != i:
            said = f"the output {shown(', '.join(released))} for the input {shown(', '.join(label))}"
            raise InputError(f"{table.locate(i)}: {said} has a row on {table.locate(first)} already; each pair has one row")
        totals[label] = (totals.get(label, (Fraction(0), i))[0] + cells[i], i)
    for label, (total, last) in totals.items():
        _check_sum(total, f"{table.locate(last)}: up to here the probabilities of the input {shown(', '.join(label))}")
    mechanism = Mechanism.from_table(table, input=inputs, output=outputs, probability=probability)
    _check_inputs(len(totals))
    return replace(mechanism, columns=inputs), (*table.notes, *_residue([total for total, _ in totals.values()]))


def _square(table: CsvTable) -> tuple[Mechanism, tuple[str, ...]]:
    corner, *outputs = table.columns
    if not outputs:
        raise InputError(
            f"the file has one column, {shown(corner)}; a filter needs columns for input, output and probability, or a table with labels "
            "in the first row and the first column"
        )
    table = table.with_numbers(outputs)
    known: dict[str, int] = {}
    for i, label in enumerate(table[corner]):
        if not label.strip():
            raise InputError(f"{table.locate(i)}: the label in the first column is missing")
        if label in known:
            raise InputError(
                f"{table.locate(i)}: the input {shown(label)} has a row on {table.locate(known[label])} already; each input has one row"
            )
        known[label] = i
    rows = []
    for i in range(len(table)):
        rows.append([_cell(table, column, i, table.locate(i)) for column in outputs])
        _check_sum(sum(rows[-1], Fraction(0)), f"{table.locate(i)}: the probabilities of the input {shown(table[corner][i])}")
    _check_inputs(len(known))
    order = list(known) if set(known) == set(outputs) else outputs
    places = [outputs.index(label) for label in order]
    mechanism = Mechanism.from_array([[row[j] for j in places] for row in rows], list(known), order)
    named = () if corner == CORNER else (corner,)
    return replace(mechanism, columns=named), (*table.notes, *_residue([sum(row, Fraction(0)) for row in rows]))


def _cell(table: CsvTable, column: str, i: int, where: str) -> Fraction:
    text = table[column][i]
    try:
        if not text.strip():
            raise InputError("the probability is missing")
        value = Fraction(*parse_rational(text))
    except InputError as error:
        raise InputError(f"column {shown(column)}, {where}: {error}") from None
    if value < 0:
        raise InputError(f"column {shown(column)}, {where}: {shown(text)} is negative; probabilities from 0 to 1 are accepted")
    return value


def _check_sum(total: Fraction, what: str) -> None:
    if abs(total - 1) > RESIDUE:
        text = rational_text((total.numerator, total.denominator))
        raise InputError(f"{what} sum to {text if len(text) <= 20 else f'{float(total):.10g}'}; they must sum to 1")


def _check_inputs(count: int) -> None:
    if count < 2:
        raise InputError("the filter has a single input; privacy compares at least two")


def _residue(totals: Sequence[Fraction]) -> tuple[str, ...]:
    off = sum(total != 1 for total in totals)
    most = max(abs(total - 1) for total in totals)
    return (f"{off} of {len(totals)} rows are off 1 by up to {float(most):.2g} and were normalised exactly",) if off else ()
