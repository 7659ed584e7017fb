"""The values of one column: labels as codes, in order of first appearance, and numbers as exact integers over one denominator."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import date, time
from decimal import Decimal
from typing import Any, TypeVar
from uuid import UUID

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, kind_of, nearest, shown
from fairaudit.exact.number_columns import NumberColumn
from fairaudit.exact.rationals import common_denominator, rational
from fairaudit.tables.label_text import PLAIN, label_text, native_values
from fairaudit.tables.number_form import NumberKind, bears_sign, plain_numbers

__all__ = [
    "MARK",
    "column",
    "combine",
    "distinct",
    "held_columns",
    "integers",
    "locator",
    "names",
    "numbers",
    "refuse_part_of_tally",
    "refuse_tally",
]

MARK = "fairaudit-tally/1"
"""A column of this name says that the rows are counts that `fairaudit.tally` wrote, whatever reads the file or holds a copy of it."""


Label = tuple[str, ...]

LabelLike = str | int | float | Decimal | date | time | UUID
"""What has one text as a label (`label_text`)."""

LabelsLike = LabelLike | tuple[LabelLike, ...]
"""The label of a group or context: of one column, or of several."""

T = TypeVar("T")

ByLabel = Mapping[str, T] | Mapping[int, T] | Mapping[bool, T] | Mapping[LabelLike, T]
"""Something for each label; several forms, because the keys of a mapping have one type."""

ByGroup = Mapping[str, T] | Mapping[int, T] | Mapping[Label, T] | Mapping[LabelsLike, T]
"""Something for each group."""

Locate = Callable[[int], str]

INT64 = 2**63 - 1


def distinct(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Different integers, rising, and the place of each one among them; without sorting where their range is small.

    Examples
    --------
    >>> [part.tolist() for part in distinct(np.array([7, 3, 7]))]
    [[3, 7], [1, 0, 1]]
    """
    low, high = (int(keys.min()), int(keys.max())) if len(keys) else (0, 0)
    if high - low > 4 * len(keys) + 1_000:
        values, places = np.unique(keys, return_inverse=True)
        return values, places
    present = np.zeros(high - low + 1, dtype=np.bool_)
    present[keys - low] = True
    return np.flatnonzero(present) + low, (np.cumsum(present) - 1)[keys - low]


def in_order_of_appearance(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], list[int]]:
    """Number keys in order of first appearance."""
    values, inverse = distinct(keys)
    first = np.empty(len(values), dtype=np.int64)
    first[inverse[::-1]] = np.arange(len(keys) - 1, -1, -1)
    order = np.argsort(first)
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(values))
    return rank[inverse], values[order].tolist()


def names(columns: str | Sequence[str] | None) -> tuple[str, ...]:
    """Column names as a tuple; a single name stands for itself."""
    if columns is None:
        return ()
    return (columns,) if isinstance(columns, str) else tuple(columns)


def locator(table: Any) -> Locate:
    """How to name a row in a message: a table may have a method `locate`; otherwise rows are counted from 1."""
    own = getattr(type(table), "locate", None)
    if own is None:
        return lambda position: f"row {position + 1}"
    return lambda position: str(own(table, position))


def column(table: Any, name: str) -> list[Any]:
    """Values of a column of a frame or mapping as a list of Python values."""
    known = [c for c in (table.columns if hasattr(table, "columns") else table) if isinstance(c, str)]
    refuse_tally(known)
    if name not in known:
        parts = [part.strip() for part in name.split(",")]
        if len(parts) > 1 and set(parts) <= set(known):
            raise InputError(
                f"there is no column {shown(name)}; did you mean the columns {' and '.join(map(shown, parts))}, a list of names?"
            )
        raise InputError(f"there is no column {shown(name)}; {nearest(name, known) if known else _nameless(table)}")
    try:
        values = table[name]
    except TypeError:
        raise InputError(f"{kind_of(table)} has columns, but cannot be asked for one; give the frame that it was made of") from None
    if isinstance(values, (str, bytes)) or not (hasattr(values, "__len__") or hasattr(values, "__iter__")):
        raise InputError(f"column {shown(name)} is {shown(values)}, {kind_of(values)}; a list of values, one for each row, is accepted")
    if getattr(values, "ndim", 1) != 1:
        if isinstance(table, Mapping):
            raise InputError(f"column {shown(name)} has shape {values.shape}; a list of values, one for each row, is accepted")
        raise InputError(f"the column name {shown(name)} occurs more than once; give each column its own name")
    try:
        return native_values(values)
    except InputError as error:
        raise InputError(f"column {shown(name)}: {error}") from None


def held_columns(table: Any) -> list[str]:
    """Names of the columns of a table in memory; none of a query that is still to be run."""
    if not (hasattr(table, "__len__") or hasattr(table, "num_rows")):
        return []
    held: Any = table
    if not isinstance(table, Mapping):
        held = getattr(table, "column_names", None) or getattr(table, "columns", ())
    return [name for name in held if isinstance(name, str)]


def refuse_tally(columns: Iterable[str]) -> None:
    """Refuse a table that was read from a tally as if each of its rows were one decision.

    Raises
    ------
    InputError
        If it has the column that marks one.
    """
    if MARK in columns:
        raise InputError(
            "these are counts that fairaudit tally wrote, not a log; give the file itself, FILE.parquet, with count (--count NAME), and "
            "without an engine"
        )


def refuse_part_of_tally(table: object) -> None:
    """Refuse what was read of some columns of a tally, where it still says so, as tables and datasets of Arrow do.

    Raises
    ------
    InputError
        If it does.
    """
    if not type(table).__module__.startswith("pyarrow"):
        return
    if MARK.encode() in (getattr(getattr(table, "schema", None), "metadata", None) or ()):
        refuse_tally([MARK])


def _nameless(table: Any) -> str:
    """What is wrong with a table none of whose columns is named by a text."""
    columns = list(table.columns if hasattr(table, "columns") else table)
    if not columns:
        return "the table has no columns"
    if isinstance(columns[0], tuple):
        return f"the names of its columns are tuples such as {shown(columns[0])}; make one text of each, such as '_'.join(name)"
    return f"the names of its columns are no texts, but such as {shown(columns[0])}; give each column a name"


def encode(values: list[Any], name: str, locate: Locate) -> tuple[NDArray[np.int64], list[str]]:
    """Codes of labels in order of first appearance; -1 where the label is missing."""
    keys = _keys(values, name, locate)
    first: dict[Hashable, int] = {}
    for position, key in enumerate(keys):
        if key not in first:
            first[key] = position
    codes: dict[Hashable, int] = {}
    seen: dict[str, tuple[int, Any]] = {}
    for key, position in first.items():
        value = values[position]
        text = _label(value, name, position, locate)
        if text is None:
            codes[key] = -1
            continue
        code, other = seen.setdefault(text, (len(seen), value))
        if other != value and not (type(other) is type(value) and type(value) not in PLAIN):
            raise InputError(
                f"column {shown(name)}, {locate(position)}: {shown(value)} and {shown(other)} are different values with the same text; "
                "make the column of one type"
            )
        codes[key] = code
    return np.fromiter(map(codes.__getitem__, keys), dtype=np.int64, count=len(keys)), list(seen)


def _keys(values: list[Any], name: str, locate: Locate) -> Sequence[Hashable]:
    """What tells the values of a column apart; dates and times by their texts, because Python takes two moments of one hour for equal."""
    kinds = set(map(type, values))
    if kinds <= PLAIN:
        return values if len(kinds) <= 1 else [(type(value), value) for value in values]
    return [
        (type(value), value if type(value) in PLAIN else _label(value, name, position, locate)) for position, value in enumerate(values)
    ]


def _label(value: Any, name: str, position: int, locate: Locate) -> str | None:
    try:
        return label_text(value)
    except InputError as error:
        raise InputError(f"column {shown(name)}, {locate(position)}: {error}") from None


def combine(parts: Sequence[tuple[NDArray[np.int64], list[str]]], rows: int) -> tuple[NDArray[np.int64], list[Label]]:
    """Join the codes of several columns into codes of tuples, in order of first appearance."""
    if not parts:
        return np.zeros(rows, dtype=np.int64), [()]
    if len(parts) == 1:
        return parts[0][0], [(text,) for text in parts[0][1]]
    joined = parts[0][0]
    labels: list[Label] = [(text,) for text in parts[0][1]]
    for codes, texts in parts[1:]:
        joined, values = in_order_of_appearance(joined * len(texts) + codes)
        labels = [(*labels[v // len(texts)], texts[v % len(texts)]) for v in values]
    return joined, labels


def numbers(values: list[Any] | NDArray[np.int64], name: str, locate: Locate, kind: NumberKind = "amount") -> tuple[NDArray[Any], int]:
    """Numbers of a column, exact: float64 as they are, everything else as integers over one denominator.

    Negative numbers are an error, and so are texts that could be two numbers. An array of integers was looked at before.
    """
    if isinstance(values, np.ndarray):
        return values, 1
    floats = float_numbers(values, name, locate)
    return exact_numbers(values, name, locate, kind).over_one_denominator() if floats is None else (floats, 1)


def float_numbers(values: list[Any] | NDArray[np.int64], name: str, locate: Locate) -> NDArray[np.float64] | None:
    """Numbers of a column of floats and nothing else; None of any other."""
    if isinstance(values, np.ndarray) or set(map(type, values)) != {float}:
        return None
    floats = np.array(values, dtype=np.float64)
    for bad, what in (
        (~np.isfinite(floats), "is not a finite number"),
        (floats < 0, "is negative; numbers of at least 0 are accepted"),
    ):
        if bad.any():
            at = int(np.flatnonzero(bad)[0])
            raise InputError(f"column {shown(name)}, {locate(at)}: {shown(values[at])} {what}")
    return floats


def exact_numbers(values: list[Any] | NDArray[np.int64], name: str, locate: Locate, kind: NumberKind = "amount") -> NumberColumn:
    """Numbers of a column, each exactly as it is. Negative numbers are an error, and so are texts that could be two numbers."""
    if isinstance(values, np.ndarray):
        return NumberColumn(values, np.zeros_like(values), np.ones_like(values))
    texts = values if set(map(type, values)) == {str} else list(map(number_text, values))
    column, left = NumberColumn.of_texts(texts)
    if _unclear(column, [values[position] for position in left]):
        plain = plain_numbers(name, values, locate, kind=kind)
        if plain is not None:
            return exact_numbers(plain, name, locate, "share")
    others: dict[int, tuple[int, int]] = {}
    cache: dict[tuple[type, Any], tuple[int, int]] = {}
    for position in left:
        value = values[position]
        key = (type(value), value) if isinstance(value, Hashable) else None
        pair = cache.get(key) if key is not None else None
        if pair is None:
            try:
                if label_text(value) is None:
                    raise InputError("the number is missing")
                pair = rational(value)
                if pair[0] < 0:
                    raise InputError(f"{shown(value)} is negative; numbers of at least 0 are accepted")
            except InputError as error:
                raise InputError(f"column {shown(name)}, {locate(position)}: {error}{bears_sign(value)}") from None
            if key is not None:
                cache[key] = pair
        others[position] = pair
    return replace(column, others=others)


def _unclear(column: NumberColumn, left: Sequence[Any]) -> bool:
    """Whether a look at each text is needed to say what its marks mean: all numbers of few decimals have three, or some have commas."""
    if any(isinstance(value, str) and ("," in value or "." in value) for value in left):
        return True
    decimals = column.tops[column.powers < 0]
    thousands = (decimals >= 1_000) & (decimals < 1_000_000) & (column.powers[column.powers < 0] == -3)
    return bool(len(decimals)) and bool(thousands.all())


def number_text(value: Any) -> str:
    """A text that says the same as a number exactly, or is empty."""
    if isinstance(value, str):
        return value
    return str(value) if type(value) is Decimal or (type(value) is int and abs(value) < INT64) else ""


def integers(values: Iterable[int]) -> NDArray[Any]:
    """Integers as int64 if their sum fits, else as Python integers."""
    listed = list(values)
    return np.array(listed, dtype=np.int64 if sum(map(abs, listed)) <= INT64 else object)


def exact_floats(values: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """Float64 counts as integers over one denominator."""
    if float(values.sum()) < 2.0**53 and bool(np.all(values == np.floor(values))):
        return values.astype(np.int64), 1
    whole, bottom = common_denominator([v.as_integer_ratio() for v in values.tolist()])
    return integers(whole), bottom
