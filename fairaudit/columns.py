"""Columns of a table, whatever holds it: labels become codes in order of first appearance, numbers become exact."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact import InputError, common_denominator, nearest, rational, shown

__all__ = ["CodedTable", "column", "integers", "label_text", "locator", "names", "numbers", "plain", "read_columns"]

Missing = Literal["error", "drop", "group"]
Label = tuple[str, ...]
Locate = Callable[[int], str]

MISSING_LABEL = "(missing)"
INT64 = 2**63 - 1
STEERING = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}


@dataclass(frozen=True)
class CodedTable:
    """The columns of a table that an audit needs, without the rows that were left out.

    Attributes
    ----------
    codes : tuple of ndarray of int64
        Decision, context and group of each row, as codes.
    decisions, contexts, groups : list
        What the codes stand for, in order of first appearance.
    values : dict of str to list
        Cells of the other columns that were asked for.
    locate : callable
        Maps a row's position to words for a message.
    notes, assumptions : tuple of str
        What was done to rows with missing labels.
    """

    codes: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
    decisions: list[str]
    contexts: list[Label]
    groups: list[Label]
    values: dict[str, list[Any]]
    locate: Locate
    notes: tuple[str, ...]
    assumptions: tuple[str, ...]


def read_columns(
    table: Any,
    decision: str,
    group: Sequence[str],
    context: Sequence[str],
    others: Sequence[str],
    missing: Missing,
    unit: Sequence[str] = (),
) -> CodedTable:
    """Read decision, group and context columns as codes, and fetch others.

    Parameters
    ----------
    table : DataFrame, mapping of str to sequence, or CsvTable
        The table.
    decision, group, context : str or sequence of str
        Label columns.
    others : sequence of str
        Columns to fetch as they are.
    missing : {"error", "drop", "group"}
        What an empty label means.
    unit : sequence of str
        Columns to fetch that may be among the label columns.

    Returns
    -------
    CodedTable
        The codes.

    Raises
    ------
    InputError
        If a column is absent or used twice, columns differ in length, or a label is not usable.
    """
    labelled = (decision, *group, *context)
    lists = _lists(table, labelled, [*others, *(name for name in unit if name not in labelled)])
    where = locator(table)
    if missing not in ("error", "drop", "group"):
        raise InputError(f"missing={shown(missing)} is not accepted; use 'error', 'drop' or 'group'")
    coded = {name: encode(lists[name], name, where) for name in labelled}
    notes: list[str] = []
    for name in labelled:
        coded[name], note = _missing_labels(*coded[name], name, missing, where)
        notes += note
    values = {name: lists[name] for name in (*others, *unit)}
    rows = len(lists[decision])
    keep = np.all([codes >= 0 for codes, _ in coded.values()], axis=0)
    assumptions: tuple[str, ...] = ()
    if not keep.all():
        kept = np.flatnonzero(keep).tolist()
        if not kept:
            raise InputError("every row has a missing label; nothing is left to audit")
        said = f"{rows - len(kept)} of {rows} rows have a missing label and were left out"
        notes.append(said)
        assumptions = (f"{said}; they are taken to be no different from the others",)
        coded = {name: _recode(codes[keep], texts) for name, (codes, texts) in coded.items()}
        values = {name: [cells[i] for i in kept] for name, cells in values.items()}
        everywhere = where

        def where(position: int) -> str:
            return everywhere(kept[position])

        rows = len(kept)
    u, decisions = coded[decision]
    x, contexts = combine([coded[name] for name in context], rows)
    a, groups = combine([coded[name] for name in group], rows)
    return CodedTable((u, x, a), decisions, contexts, groups, values, where, tuple(notes), assumptions)


def _lists(table: Any, labelled: Sequence[str], others: Sequence[str]) -> dict[str, list[Any]]:
    used = [*labelled, *others]
    for name in used:
        if used.count(name) > 1:
            raise InputError(f"the column {shown(name)} is used twice; each column has one role")
    lists = {name: column(table, name) for name in used}
    rows = len(lists[used[0]])
    for name, values in lists.items():
        if len(values) != rows:
            raise InputError(f"column {shown(name)} has {len(values)} values and column {shown(used[0])} {rows}; they must be equally long")
    if rows == 0:
        raise InputError("the table has no rows")
    return lists


def _missing_labels(
    codes: NDArray[np.int64], texts: list[str], name: str, missing: Missing, where: Locate
) -> tuple[tuple[NDArray[np.int64], list[str]], list[str]]:
    """Refuse missing labels, or make them a level, or leave them to be dropped."""
    absent = codes < 0
    if not absent.any() or missing == "drop":
        return (codes, texts), []
    count = int(absent.sum())
    if missing == "error":
        at = int(np.flatnonzero(absent)[0])
        raise InputError(
            f"column {shown(name)}, {where(at)}: the label is missing ({count} in all); "
            "missing=drop (--missing drop) leaves such rows out, missing=group (--missing group) makes them a level"
        )
    if MISSING_LABEL in texts:
        raise InputError(f"column {shown(name)} already has a label {MISSING_LABEL!r}; rename it, or use missing=drop")
    note = f"{count} rows without a label in column {shown(name)} form the level {MISSING_LABEL!r}"
    return (np.where(absent, len(texts), codes), [*texts, MISSING_LABEL]), [note]


def _in_order(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], list[int]]:
    """Number keys in order of first appearance."""
    values, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(values))
    return rank[inverse], values[order].tolist()


def _recode(codes: NDArray[np.int64], texts: list[str]) -> tuple[NDArray[np.int64], list[str]]:
    """Forget the labels that no row uses any more."""
    ranks, values = _in_order(codes)
    return ranks, [texts[v] for v in values]


def plain(text: str) -> str:
    r"""Escape characters that could steer a terminal or reorder text.

    Examples
    --------
    >>> plain("a\x1b[31mb\u202ec")
    'a\\x1b[31mb\\u202ec'
    """
    if text.isprintable():
        return text
    return "".join(c if unicodedata.category(c) not in STEERING else c.encode("unicode_escape").decode("ascii") for c in text)


def label_text(value: object) -> str | None:
    """Text of a label, or None for a missing one.

    Raises
    ------
    InputError
        If it is not a text, number, truth value or date.

    Examples
    --------
    >>> label_text("A"), label_text(3), label_text(True), label_text(""), label_text(float("nan"))
    ('A', '3', 'True', None, None)
    """
    if isinstance(value, str):
        try:
            value.encode("utf-8")
        except UnicodeEncodeError:
            raise InputError(f"the label {shown(value)} is not valid Unicode") from None
        return value if value.strip() else None
    if value is None or type(value).__name__ in ("NAType", "NaTType"):
        return None
    if isinstance(value, np.generic):
        return label_text(value.item())
    if isinstance(value, float):
        return None if value != value else repr(value)
    if isinstance(value, (bool, int)):
        return str(value)
    iso = getattr(value, "isoformat", None)
    if callable(iso):
        return str(iso())
    raise InputError(f"a label of type {type(value).__name__} is not accepted; use text, numbers, truth values or dates")


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
    if name not in known:
        raise InputError(f"there is no column {shown(name)}; {nearest(name, known)}")
    values = table[name]
    if getattr(values, "ndim", 1) != 1:
        raise InputError(f"the column name {shown(name)} occurs more than once; give each column its own name")
    return list(values.tolist() if hasattr(values, "tolist") else values)


def encode(values: list[Any], name: str, locate: Locate) -> tuple[NDArray[np.int64], list[str]]:
    """Codes of labels in order of first appearance; -1 where the label is missing."""
    kinds = set(map(type, values))
    keys: list[Hashable] = values if len(kinds) <= 1 else [(type(v), v) for v in values]
    try:
        first: dict[Hashable, int] = {}
        for position, key in enumerate(keys):
            if key not in first:
                first[key] = position
    except TypeError:
        raise InputError(f"column {shown(name)} holds values that are not labels; use text, numbers, truth values or dates") from None
    codes: dict[Hashable, int] = {}
    seen: dict[str, tuple[int, Any]] = {}
    for key, position in first.items():
        value = values[position]
        try:
            text = label_text(value)
        except InputError as error:
            raise InputError(f"column {shown(name)}, {locate(position)}: {error}") from None
        if text is None:
            codes[key] = -1
            continue
        code, other = seen.setdefault(text, (len(seen), value))
        if type(other) is not type(value) and other != value:
            raise InputError(
                f"column {shown(name)}, {locate(position)}: {shown(value)} and {shown(other)} are different values with the same text; "
                "make the column of one type"
            )
        codes[key] = code
    return np.fromiter(map(codes.__getitem__, keys), dtype=np.int64, count=len(keys)), list(seen)


def combine(parts: Sequence[tuple[NDArray[np.int64], list[str]]], rows: int) -> tuple[NDArray[np.int64], list[Label]]:
    """Join the codes of several columns into codes of tuples, in order of first appearance."""
    if not parts:
        return np.zeros(rows, dtype=np.int64), [()]
    if len(parts) == 1:
        return parts[0][0], [(text,) for text in parts[0][1]]
    joined = parts[0][0]
    labels: list[Label] = [(text,) for text in parts[0][1]]
    for codes, texts in parts[1:]:
        joined, values = _in_order(joined * len(texts) + codes)
        labels = [(*labels[v // len(texts)], texts[v % len(texts)]) for v in values]
    return joined, labels


def numbers(values: list[Any], name: str, locate: Locate) -> tuple[NDArray[Any], int]:
    """Numbers of a column, exact: float64 as they are, everything else as integers over one denominator.

    Negative numbers are an error.
    """
    kinds = set(map(type, values))
    if kinds == {float}:
        floats = np.array(values, dtype=np.float64)
        for bad, what in (
            (~np.isfinite(floats), "is not a finite number"),
            (floats < 0, "is negative; numbers of at least 0 are accepted"),
        ):
            if bad.any():
                at = int(np.flatnonzero(bad)[0])
                raise InputError(f"column {shown(name)}, {locate(at)}: {shown(values[at])} {what}")
        return floats, 1
    cache: dict[tuple[type, Any], tuple[int, int]] = {}
    pairs: list[tuple[int, int]] = []
    for position, value in enumerate(values):
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
                raise InputError(f"column {shown(name)}, {locate(position)}: {error}") from None
            if key is not None:
                cache[key] = pair
        pairs.append(pair)
    whole, bottom = common_denominator(pairs)
    return integers(whole), bottom


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
