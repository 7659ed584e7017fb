"""Columns of a table, whatever holds it: labels become codes, numbers become exact.

Labels are in order of first appearance, except those of logs, which are sorted: a log has no order that every engine would keep.
"""

from __future__ import annotations

import unicodedata
from array import array
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date, time
from decimal import Decimal
from fractions import Fraction
from itertools import islice
from typing import Any, Literal
from uuid import UUID

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact import InputError, common_denominator, nearest, rational, shown
from fairaudit.label_text import ACCEPTED, PLAIN, Reader, label_text, native_values
from fairaudit.preparation import Entry, Unit, in_order, left_out, level, words

__all__ = [
    "CodedTable",
    "Tally",
    "column",
    "combine",
    "counted",
    "distinct",
    "integers",
    "label_codes",
    "label_text",
    "locator",
    "merged",
    "names",
    "numbers",
    "plain",
    "read_columns",
]

Missing = Literal["error", "drop", "group"]
Label = tuple[str, ...]
Locate = Callable[[int], str]

BATCH = 50_000
MISSING_LABEL = "(missing)"
INT64 = 2**63 - 1
STEERING = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}


@dataclass(frozen=True, eq=False)
class Tally:
    """A log whose equal rows were counted: the distinct rows, and how often each occurs.

    It stands for the log wherever `Law.from_log` and `Utility.from_table` take a table.

    Attributes
    ----------
    name : str
        Name of what was read, for messages.
    codes : dict of str to ndarray of int64
        For each column the values of the distinct rows, as positions in its levels.
    levels : dict of str to list
        For each column its different values.
    counts : ndarray of int64
        How often each row occurs.
    notes : tuple of str
        What was noticed while reading.
    find : callable or None
        Says where a distinct row, given by its position, occurs first: ``line 5``.
    preparation : tuple of mapping
        What was done to the log before it was counted (`fairaudit.preparation`).

    Examples
    --------
    >>> tally = Tally.of("log", ("hired", "sex"), [("yes", "f", 3), ("no", "f", 1), ("yes", "m", 1)])
    >>> len(tally), tally.rows, tally["sex"]
    (3, 5, ['f', 'f', 'm'])
    """

    name: str
    codes: dict[str, NDArray[np.int64]]
    levels: dict[str, list[Any]]
    counts: NDArray[np.int64]
    notes: tuple[str, ...] = ()
    find: Callable[[Tally, int], str] | None = field(default=None, repr=False)
    preparation: tuple[Entry, ...] = ()

    @staticmethod
    def of(
        name: str,
        columns: Sequence[str],
        cells: Iterable[Sequence[Any]],
        *,
        read: Mapping[str, Reader] | None = None,
        equal: Collection[str] = (),
        find: Callable[[Tally, int], str] | None = None,
        notes: tuple[str, ...] = (),
    ) -> Tally:
        """Encode distinct rows as they come, each a value per column and then a count.

        Parameters
        ----------
        name : str
            Name of what was read.
        columns : sequence of str
            Its columns.
        cells : iterable of sequence
            The rows.
        read : mapping of str to callable, optional
            What makes values of a column of what the engine gives for them.
        equal : collection of str
            Columns in `read` of which different texts, as those of JSON, may have equal values; their rows are added up.
        find, notes
            As in the attributes.

        Raises
        ------
        InputError
            If two rows are equal, because values that the engine tells apart have become one; 0 and -0, and the forms of a missing
            value, are added up.
        """
        readers = {position: Reading(column, (read or {}).get(column)) for position, column in enumerate(columns)}
        later = {position for position, column in enumerate(columns) if column in equal}
        known: list[dict[type, dict[Hashable, int]]] = [{} for _ in columns]
        levels: list[list[Any]] = [[] for _ in columns]
        listed = [array("q") for _ in range(len(columns) + 1)]
        rows = iter(cells)
        while batch := list(islice(rows, BATCH)):
            *values, counts = zip(*batch, strict=True)
            listed[-1].extend(map(int, counts))
            for position, held in enumerate(values):
                part: Sequence[Any] = held
                if position not in later and (readers[position].read or len({*map(type, part)}) > 1 or type(part[0]) not in (str, int)):
                    part = list(map(readers[position], part))
                kinds = {*map(type, part)}
                codes = {kind: known[position].setdefault(kind, {}) for kind in kinds}
                for value in dict.fromkeys(part) if len(kinds) == 1 else part:
                    if value not in (own := codes[type(value)]):
                        own[value] = len(levels[position])
                        levels[position].append(value)
                if len(kinds) == 1:
                    listed[position].extend(map(codes[kinds.pop()].__getitem__, part))
                else:
                    listed[position].extend(codes[type(value)][value] for value in part)
        arrays = [np.array(part, dtype=np.int64) for part in listed]
        found = Tally(name, dict(zip(columns, arrays, strict=False)), dict(zip(columns, levels, strict=True)), arrays[-1], notes, find)
        return _unmarked(found.checked(), [readers[position] if position in later else None for position in range(len(columns))])

    def checked(self) -> Tally:
        """Give the tally back if its rows differ.

        Raises
        ------
        InputError
            If two rows are equal.
        """
        keys, span = np.zeros(len(self), dtype=np.int64), 1
        for column, codes in self.codes.items():
            size = len(self.levels[column]) or 1
            if span * size > INT64:
                keys, span = np.unique(keys, return_inverse=True)[1], len(self)
            keys, span = keys * size + codes, span * size
        values, first = np.unique(keys, return_index=True)
        if len(values) < len(keys):
            again = np.setdiff1d(np.arange(len(keys)), first)[0]
            raise InputError(
                f"{self.name}: rows that differ where they are held have become equal ({self.locate(int(again))}); "
                "cast the columns to text so that different values have different texts"
            )
        return self

    @property
    def columns(self) -> list[str]:
        """Column names, in order."""
        return list(self.codes)

    @property
    def rows(self) -> int:
        """How many rows were counted."""
        return int(self.counts.sum())

    def __len__(self) -> int:
        """Return the number of distinct rows."""
        return len(self.counts)

    def __getitem__(self, name: str) -> list[Any]:
        """Values of a column in the distinct rows."""
        levels = self.levels[name]
        return [levels[code] for code in self.codes[name].tolist()]

    def locate(self, position: int) -> str:
        """Name the first row that is equal to a distinct one; where rows have no place, name the row by its values."""
        if self.find is not None:
            return self.find(self, position)
        parts = [f"{name}={shown(self.levels[name][codes[position]], 30)}" for name, codes in self.codes.items()]
        return f"the row with {', '.join(parts)}"


@dataclass(frozen=True)
class CodedTable:
    """The columns of a table that an audit needs, without the rows that were left out.

    Attributes
    ----------
    codes : tuple of ndarray of int64
        Decision, context and group of each row, as codes.
    counts : ndarray of int64
        How many rows of the log each row stands for; one unless it is a `Tally`.
    decisions, contexts, groups : list
        What the codes stand for: in order of first appearance, or sorted.
    values : dict of str to list
        Cells of the other columns that were asked for.
    units : tuple of (ndarray of int64, list of str)
        Codes of the columns of the sampling unit, -1 where a label is missing, and what they stand for.
    truth : tuple of ndarray of int64 and list of str, or None
        Codes of the true labels, and what they stand for.
    locate : callable
        Maps a row's position to words for a message.
    notes : tuple of str
        What was done to rows with missing labels, in words.
    preparation : tuple of mapping
        What was done to the table before it was counted.
    """

    codes: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
    counts: NDArray[np.int64]
    decisions: list[str]
    contexts: list[Label]
    groups: list[Label]
    values: dict[str, list[Any]]
    locate: Locate
    notes: tuple[str, ...]
    units: tuple[tuple[NDArray[np.int64], list[str]], ...] = ()
    truth: tuple[NDArray[np.int64], list[str]] | None = None
    preparation: tuple[Entry, ...] = ()


def read_columns(
    table: Any,
    decision: str,
    group: Sequence[str],
    context: Sequence[str],
    others: Sequence[str],
    missing: Missing,
    unit: Sequence[str] = (),
    *,
    ordered: bool = False,
    truth: str | None = None,
    count: str | None = None,
    measured_in: Unit = "decisions",
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
        Columns of the sampling unit, which may be among the label columns.
    ordered : bool
        Whether labels are sorted (by code point) instead of listed as they appear.
    truth : str, optional
        Column of the true label.
    count : str, optional
        The column among `others` that says how many decisions a row stands for.
    measured_in : {"decisions", "rows"}
        What is left out: decisions, or rows of a table of probabilities.

    Returns
    -------
    CodedTable
        The codes.

    Raises
    ------
    InputError
        If a column is absent or used twice, columns differ in length, or a label is not usable.
    """
    labelled = (decision, *group, *context, *names(truth))
    lists = _lists(table, labelled, others)
    counts = counted(table, len(lists[decision]))
    where = locator(table)
    if missing not in ("error", "drop", "group"):
        raise InputError(f"missing={shown(missing)} is not accepted; use 'error', 'drop' or 'group'")
    coded = {name: _encoded(table, lists[name], name, where) for name in labelled}
    values = {name: lists[name] for name in others}
    absent = {name: codes < 0 for name, (codes, _) in coded.items()}
    weighed = _Weights(counts, None if count is None else values[count], count or "", np.all(list(absent.values()), axis=0), where)
    done: list[Entry] = []
    for name in labelled:
        coded[name] = _missing_labels(*coded[name], name, missing, where, counts)
        if missing == "group" and (amount := weighed(absent[name])):
            done.append(level(name, MISSING_LABEL, measured_in, amount))
    rows = len(lists[decision])
    units = label_codes(table, unit, where)
    for name, (codes, _) in zip(unit, units, strict=True):
        if unit.count(name) > 1:
            raise InputError(f"the column {shown(name)} is used twice; each column has one role")
        if len(codes) != rows:
            raise InputError(f"column {shown(name)} has {len(codes)} values and column {shown(decision)} {rows}; they must be equally long")
    keep = np.all([codes >= 0 for codes, _ in coded.values()], axis=0)
    if not keep.all():
        kept = np.flatnonzero(keep).tolist()
        if not kept:
            raise InputError("every row has a missing label; nothing is left to audit")
        if amount := weighed(~keep):
            done.append(left_out(measured_in, amount, weighed(keep) + amount, {name: weighed(absent[name]) for name in labelled}))
        counts = counts[keep]
        coded = {name: _recode(codes[keep], texts) for name, (codes, texts) in coded.items()}
        values = {name: [cells[i] for i in kept] for name, cells in values.items()}
        units = [_recode(codes[keep], texts) if (codes[keep] >= 0).all() else (codes[keep], texts) for codes, texts in units]
        everywhere = where

        def where(position: int) -> str:
            return everywhere(kept[position])

        rows = len(kept)
    notes = tuple(map(words, done))
    preparation = in_order((*getattr(table, "preparation", ()), *done), labelled, {name: texts for name, (_, texts) in coded.items()})
    u, decisions = coded[decision]
    x, contexts = combine([coded[name] for name in context], rows)
    a, groups = combine([coded[name] for name in group], rows)
    true = None if truth is None else coded[truth]
    if ordered:
        (u, decisions), (x, contexts), (a, groups) = _sorted(u, decisions), _sorted(x, contexts), _sorted(a, groups)
        true = true and _sorted(*true)
    return CodedTable((u, x, a), counts, decisions, contexts, groups, values, where, notes, tuple(units), true, preparation)


@dataclass(frozen=True)
class _Weights:
    """How many decisions rows stand for, where that is asked: as many as a column says, or else one for each row of the log.

    Blank rows, which have no label and no number either, stand for none.
    """

    counts: NDArray[np.int64]
    values: list[Any] | None
    column: str
    unlabelled: NDArray[np.bool_]
    locate: Locate

    def __call__(self, rows: NDArray[np.bool_]) -> Fraction:
        values = self.values
        if values is None:
            return Fraction(int(self.counts[rows].sum()))
        places = [i for i in np.flatnonzero(rows).tolist() if not self.unlabelled[i] or label_text(values[i]) is not None]
        if not places:
            return Fraction(0)
        listed, scale = numbers([values[i] for i in places], self.column, lambda position: self.locate(places[position]))
        if listed.dtype.kind == "f":
            listed, scale = exact_floats(listed)
        return Fraction(sum(n * times for n, times in zip(listed.tolist(), self.counts[places].tolist(), strict=True)), scale)


def _lists(table: Any, labelled: Sequence[str], others: Sequence[str]) -> dict[str, Any]:
    """Cells of the columns; of a `Tally` only the codes of those that are labels and nothing else."""
    used = [*labelled, *others]
    coded = set(labelled) & set(table.codes) if isinstance(table, Tally) else set()
    for name in used:
        if used.count(name) > 1:
            raise InputError(f"the column {shown(name)} is used twice; each column has one role")
    lists = {name: table.codes[name] if name in coded else column(table, name) for name in used}
    rows = len(lists[used[0]])
    for name, values in lists.items():
        if len(values) != rows:
            raise InputError(f"column {shown(name)} has {len(values)} values and column {shown(used[0])} {rows}; they must be equally long")
    if rows == 0:
        raise InputError("the table has no rows")
    return lists


def _missing_labels(
    codes: NDArray[np.int64], texts: list[str], name: str, missing: Missing, where: Locate, counts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], list[str]]:
    """Refuse missing labels, or make them a level, or leave them to be dropped."""
    absent = codes < 0
    if not absent.any() or missing == "drop":
        return codes, texts
    if missing == "error":
        at = int(np.flatnonzero(absent)[0])
        raise InputError(
            f"column {shown(name)}, {where(at)}: the label is missing ({int(counts[absent].sum())} in all); "
            "missing=drop (--missing drop) leaves such rows out, missing=group (--missing group) makes them a level"
        )
    if MISSING_LABEL in texts:
        raise InputError(f"column {shown(name)} already has a label {MISSING_LABEL!r}; rename it, or use missing=drop")
    return np.where(absent, len(texts), codes), [*texts, MISSING_LABEL]


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


def _in_order(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], list[int]]:
    """Number keys in order of first appearance."""
    values, inverse = distinct(keys)
    first = np.empty(len(values), dtype=np.int64)
    first[inverse[::-1]] = np.arange(len(keys) - 1, -1, -1)
    order = np.argsort(first)
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(values))
    return rank[inverse], values[order].tolist()


def _sorted(codes: NDArray[np.int64], labels: list[Any]) -> tuple[NDArray[np.int64], list[Any]]:
    """Sort labels by code point, and their codes with them."""
    order = sorted(range(len(labels)), key=labels.__getitem__)
    rank = np.empty(len(labels), dtype=np.int64)
    rank[order] = np.arange(len(labels))
    return rank[codes], [labels[i] for i in order]


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


def names(columns: str | Sequence[str] | None) -> tuple[str, ...]:
    """Column names as a tuple; a single name stands for itself."""
    if columns is None:
        return ()
    return (columns,) if isinstance(columns, str) else tuple(columns)


def counted(table: Any, rows: int) -> NDArray[np.int64]:
    """How many rows of the log each row of a table stands for."""
    return table.counts if isinstance(table, Tally) else np.ones(rows, dtype=np.int64)


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
    try:
        return native_values(values)
    except InputError as error:
        raise InputError(f"column {shown(name)}: {error}") from None


def _encoded(table: Any, values: list[Any], name: str, locate: Locate) -> tuple[NDArray[np.int64], list[str]]:
    """Codes of a column; of a `Tally` only the different values are looked at."""
    if not isinstance(table, Tally):
        return encode(values, name, locate)
    at = table.codes[name]

    def first(level: int) -> str:
        return locate(int(np.flatnonzero(at == level)[0]))

    codes, texts = encode(table.levels[name], name, first)
    return codes[at], texts


def label_codes(table: Any, columns: Sequence[str], locate: Locate) -> list[tuple[NDArray[np.int64], list[str]]]:
    """Codes of the labels in each column, -1 where one is missing, and the labels.

    Raises
    ------
    InputError
        If a column is not there, or holds no labels.

    Examples
    --------
    >>> [(codes, labels)] = label_codes({"sex": ["f", "", "f"]}, ["sex"], str)
    >>> codes.tolist(), labels
    ([0, -1, 0], ['f'])
    """
    held = table.codes if isinstance(table, Tally) else {}
    return [_encoded(table, [] if name in held else column(table, name), name, locate) for name in columns]


class _Mark(str):
    """What stands for -0 and for a missing value while rows are told apart."""

    __slots__ = ()


class _NotANumber:
    """What stands for a NaN, which equals no other."""


class Reading:
    """Values of a column as a `Tally` keeps them: numbers, truth values and texts; each different one is looked at once."""

    def __init__(self, column: str, read: Reader | None) -> None:
        self.column, self.read = column, read
        self.known: dict[tuple[type, Hashable], Any] = {}

    def __call__(self, value: Any) -> Any:
        """Read a value."""
        if isinstance(value, (float, np.floating)):
            return _zero_or_number(float(value))
        try:
            if isinstance(value, (date, time)):  # equal to others of another fold
                return self._plain(value)
            key = (type(value), value)
            if key not in self.known:
                self.known[key] = self._plain(value)
        except TypeError:
            raise InputError(f"column {shown(self.column)} holds {shown(value)}, which is not a label; {ACCEPTED}") from None
        except InputError as error:
            raise InputError(f"column {shown(self.column)}: {error}") from None
        return self.known[key]

    def _plain(self, value: Any) -> Any:
        if self.read is not None:
            value = self.read(value)
        if value is None:
            return None
        if type(value).__name__ in ("NAType", "NaTType"):
            return _Mark(type(value).__name__)
        if isinstance(value, np.generic) and not isinstance(value, (np.datetime64, np.timedelta64)):
            value = value.item()
        if isinstance(value, Decimal) and value.is_nan():
            return _NotANumber()
        return label_text(value) if isinstance(value, (date, time, UUID, np.datetime64)) else value


def _zero_or_number(value: float) -> Any:
    if value != value:
        return _NotANumber()
    return _Mark("-0") if value == 0 and str(value) == "-0.0" else value


def _unmarked(tally: Tally, readers: Sequence[Reading | None]) -> Tally:
    """Put values for what stands for them, and add up the rows that have become equal."""
    levels: dict[str, list[Any]] = {}
    for (name, held), reader in zip(tally.levels.items(), readers, strict=True):
        values = list(held if reader is None else map(reader, held))
        levels[name] = [
            (0.0 if value == "-0" else None) if type(value) is _Mark else None if type(value) is _NotANumber else value for value in values
        ]
    found = replace(tally, levels=levels)
    same = any(len({(type(value), value) for value in values}) < len(values) for values in levels.values())
    return merged(found) if same else found


def merged(tally: Tally) -> Tally:
    """Add up rows that have become equal."""
    codes: dict[str, Any] = {}
    levels: dict[str, list[Any]] = {}
    for name, values in tally.levels.items():
        known = {key: code for code, key in enumerate(dict.fromkeys((type(value), value) for value in values))}
        codes[name] = np.array([known[type(value), value] for value in values], dtype=np.int64)[tally.codes[name]]
        levels[name] = [value for _, value in known]
    keys = np.column_stack(list(codes.values()))
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    counts = np.zeros(len(first), dtype=np.int64)
    np.add.at(counts, inverse.ravel(), tally.counts)
    return replace(
        tally,
        codes={name: part[first] for name, part in codes.items()},
        levels=levels,
        counts=counts,
        find=lambda _, position: tally.locate(int(first[position])),
    )


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
