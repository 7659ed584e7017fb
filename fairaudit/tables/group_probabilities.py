"""P(group | cell) from a table: what surname-and-place methods give, exact or as intervals."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, naming, shown
from fairaudit.tables.arriving import is_frame, unreadable
from fairaudit.tables.csv import read_csv
from fairaudit.tables.engines.logs import read_log, survey_log
from fairaudit.tables.engines.paths import form
from fairaudit.tables.sources import Source, is_database, source_name
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import Label, column, combine, encode, locator, numbers
from fairaudit.words import brief

__all__ = ["GroupProbabilities", "read_group_probabilities"]

RESIDUE = Fraction(1, 10**6)
"""By how much probabilities of a cell may miss the sum 1."""

NUMBERS = {"probability", "low", "high"}


@brief
@dataclass(frozen=True, repr=False)
class GroupProbabilities:
    """P(group | cell), exact or between two ends.

    Attributes
    ----------
    name : str
        Name of the table, for messages.
    keys : tuple of str
        Columns of the cells.
    groups : tuple of tuple of str
        The groups, in order of appearance.
    ends : dict
        For each cell the least and the greatest probability of each group: the same where they are known, else as tight as it follows from
        their sum, which is 1.
    notes : tuple of str
        What was noticed while reading.
    """

    name: str
    keys: tuple[str, ...]
    groups: tuple[Label, ...]
    ends: dict[Label, tuple[tuple[Fraction, ...], tuple[Fraction, ...]]]
    notes: tuple[str, ...] = ()


def read_group_probabilities(source: Source, group: Sequence[str]) -> GroupProbabilities:
    """Read a table of P(group | cell): columns of the group, ``probability``, or ``low`` and ``high``, and all others say which cell.

    Parameters
    ----------
    source : path, frame or mapping
        The table, a row for each cell and group.
    group : sequence of str
        Columns of the group.

    Raises
    ------
    InputError
        If it is no such table; the message names the line.

    Examples
    --------
    >>> table = {"zip": ["1", "1", "2", "2"], "race": ["a", "b", "a", "b"], "probability": ["0.8", "0.2", "1/5", "4/5"]}
    >>> found = read_group_probabilities(table, ["race"])
    >>> found.keys, found.groups, found.ends["2",][0]
    (('zip',), (('a',), ('b',)), (Fraction(1, 5), Fraction(4, 5)))
    """
    name = source_name(source) if isinstance(source, (str, os.PathLike)) else "group_probability"
    table = _table(source)
    with naming(name):
        columns = [str(column) for column in (table.columns if hasattr(table, "columns") else table)]
        _check_columns(columns, group)
        keys = tuple(column for column in columns if column not in {*group, *NUMBERS})
        if not keys:
            raise InputError("there is no column that says which cell a row is about, such as a surname or a place")
        return _read(name, table, keys, tuple(group), exact="probability" in columns)


def _table(source: Any) -> Any:
    """The rows, with their lines where the source is a text."""
    if isinstance(source, (str, os.PathLike)):
        path = os.fspath(source)
        if not is_database(path) and form(path) == "csv":
            return read_csv(path)
        return read_log(path, [column.name for column in survey_log(path).columns])
    if is_frame(source):
        return read_log(source, list(source.columns))
    if not isinstance(source, Mapping) and not hasattr(source, "columns"):
        raise unreadable(source)
    return source


def _check_columns(columns: Sequence[str], group: Sequence[str]) -> None:
    for name in group:
        if name not in columns:
            raise InputError(f"there is no column {shown(name)}, which --group names; the columns are {', '.join(map(shown, columns))}")
    given = NUMBERS & set(columns)
    if given not in ({"probability"}, {"low", "high"}):
        found = f"; found {', '.join(map(shown, sorted(given)))}" if given else ""
        raise InputError(f"a column 'probability' is needed, or the two columns 'low' and 'high'{found}")


def _read(name: str, table: Any, keys: tuple[str, ...], group: tuple[str, ...], *, exact: bool) -> GroupProbabilities:
    if exact and hasattr(table, "with_numbers"):
        table = table.with_numbers(["probability"])
    elif hasattr(table, "with_numbers"):
        table = table.with_numbers(["low", "high"])
    locate = locator(table)
    cells, cell_labels = _labels(table, keys, locate)
    groups, group_labels = _labels(table, group, locate)
    ends = [_numbers(table, part, locate) for part in (("probability",) if exact else ("low", "high"))]
    found: dict[tuple[int, int], tuple[Fraction, Fraction]] = {}
    first: dict[int, int] = {}
    for i, place in enumerate(zip(cells, groups, strict=True)):
        low, high = ends[0][i], ends[-1][i]
        if low > high:
            raise InputError(f"{locate(i)}: low is {low} and high is {high}; low is at most high")
        if place in found or (isinstance(table, Tally) and table.counts[i] > 1):
            raise InputError(
                f"{locate(i)}: {_named(keys, cell_labels[place[0]])} has the group {_named(group, group_labels[place[1]])} twice"
            )
        found[place] = low, high
        first.setdefault(place[0], i)
    read: dict[Label, tuple[tuple[Fraction, ...], tuple[Fraction, ...]]] = {}
    mended = 0
    for cell, i in first.items():
        where, missing = f"{locate(i)}: {_named(keys, cell_labels[cell])}", [a for a in range(len(group_labels)) if (cell, a) not in found]
        if missing:
            raise InputError(
                f"{where} lacks the group {_named(group, group_labels[missing[0]])}; list each group in each cell, if only with 0"
            )
        least, most = (tuple(found[cell, a][end] for a in range(len(group_labels))) for end in (0, 1))
        if exact:
            mended += sum(least) != 1
            least = most = _summed_to_one(least, where)
        read[cell_labels[cell]] = _tightened(least, most, where)
    if len(group_labels) < 2:
        raise InputError(f"there is one group only, {_named(group, group_labels[0])}; ratios compare at least two")
    notes = (*getattr(table, "notes", ()), *([_said(mended)] if mended else []))
    return GroupProbabilities(name, keys, tuple(group_labels), read, notes)


def _said(mended: int) -> str:
    one = mended == 1
    return (
        f"the probabilities of {mended} {'cell' if one else 'cells'} do not sum to 1 exactly, by less than 1e-6; "
        f"the difference was added to the most probable group of {'it' if one else 'each'}"
    )


def _labels(table: Any, columns: Sequence[str], locate: Callable[[int], str]) -> tuple[list[int], list[Label]]:
    parts = []
    for name in columns:
        codes, texts = encode(values := column(table, name), name, locate)
        if (codes < 0).any():
            raise InputError(f"column {shown(name)}, {locate(int((codes < 0).argmax()))}: the label is empty")
        parts.append((codes, texts))
    codes, labels = combine(parts, len(values))
    if not len(codes):
        raise InputError("there are no rows")
    return codes.tolist(), labels


def _numbers(table: Any, name: str, locate: Callable[[int], str]) -> list[Fraction]:
    tops, bottom = numbers(column(table, name), name, locate, "share")
    found = [Fraction(top) / bottom for top in tops.tolist()]
    for i, value in enumerate(found):
        if not 0 <= value <= 1:
            raise InputError(f"column {shown(name)}, {locate(i)}: {value} is no probability; a number from 0 to 1 is")
    return found


def _named(columns: Sequence[str], label: Label) -> str:
    return ", ".join(f"{column}={shown(text)}" for column, text in zip(columns, label, strict=True))


def _summed_to_one(shares: tuple[Fraction, ...], where: str) -> tuple[Fraction, ...]:
    """Add what is missing to the greatest: dividing by the sum would give each cell a denominator of its own."""
    missing = 1 - sum(shares, Fraction(0))
    if abs(missing) > RESIDUE:
        raise InputError(f"{where}: the probabilities sum to {float(1 - missing):.9g}; they sum to 1, up to 1e-6")
    most = sorted(range(len(shares)), key=lambda a: -shares[a])[0]
    return (*shares[:most], shares[most] + missing, *shares[most + 1 :])


def _tightened(low: tuple[Fraction, ...], high: tuple[Fraction, ...], where: str) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """What the sum, which is 1, leaves of intervals."""
    least, most = sum(low, Fraction(0)), sum(high, Fraction(0))
    if not least <= 1 <= most:
        raise InputError(
            f"{where}: no probabilities in these intervals sum to 1; they sum to {float(least):.6g} at least and {float(most):.6g} at most"
        )
    return (
        tuple(max(one, 1 - most + other) for one, other in zip(low, high, strict=True)),
        tuple(min(other, 1 - least + one) for one, other in zip(low, high, strict=True)),
    )
