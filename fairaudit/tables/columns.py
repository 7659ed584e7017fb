"""Columns of a table, whatever holds it: labels become codes, numbers become exact.

Labels are in order of first appearance, except those of logs, which are sorted: a log has no order that every
engine would keep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.tables.cells import Cells
from fairaudit.tables.csv import CsvTable
from fairaudit.tables.label_text import label_text
from fairaudit.tables.preparation import ByGroup, Entry, Unit, in_order, left_out, level, scored, unknown_groups, words
from fairaudit.tables.tally import Tally, counted
from fairaudit.tables.values import (
    Label,
    Locate,
    column,
    combine,
    distinct,
    encode,
    exact_floats,
    in_order_of_appearance,
    locator,
    names,
    numbers,
)
from fairaudit.words import noun

__all__ = ["CodedTable", "LabelledRows", "label_codes", "label_is_there", "read_columns", "read_labels", "sort_labels"]


Missing = Literal["error", "drop", "group", "unknown", "undecided"]

MISSING_LABEL = "(missing)"


@dataclass(frozen=True)
class CodedTable:
    """The columns of a table that an audit needs, without the rows that were left out.

    Attributes
    ----------
    codes : tuple of ndarray of int64
        Decision, context and group of each row, as codes; the group is −1 where it is unknown.
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


@dataclass(frozen=True)
class LabelledRows:
    """Label columns as codes, each by itself, and what else `CodedTable` has.

    Attributes
    ----------
    labels : dict of str to (ndarray of int64, list of str)
        Codes of each label column, and what they stand for.
    counts, values, locate, notes, units, preparation
        As of `CodedTable`.
    known : ndarray of bool
        Which rows have a group; of the others the codes of group columns mean nothing.
    """

    labels: dict[str, tuple[NDArray[np.int64], list[str]]]
    counts: NDArray[np.int64]
    values: dict[str, list[Any]]
    locate: Locate
    notes: tuple[str, ...]
    units: tuple[tuple[NDArray[np.int64], list[str]], ...]
    preparation: tuple[Entry, ...]
    known: NDArray[np.bool_]


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
    unknown: Sequence[str] = (),
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
    missing : {"error", "drop", "group", "unknown", "undecided"}
        What an empty label means; "unknown" is for group columns, "undecided" for the decision, and both are an error elsewhere.
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
    unknown : sequence of str
        Labels of group columns that name no group: a row with one of them in any group column is of unknown group.

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
    roles: dict[str, Any] = {"group": group, "unknown": unknown, "decision": decision}
    read = read_labels(table, labelled, others, missing, unit, count=count, measured_in=measured_in, **roles)
    coded, rows, known = read.labels, len(read.counts), read.known
    u, decisions = coded[decision]
    x, contexts = combine([coded[name] for name in context], rows)
    a, groups = combine([(coded[name][0][known], coded[name][1]) for name in group], int(known.sum()))
    true = None if truth is None else coded[truth]
    if ordered:
        (u, decisions), (x, contexts), (a, groups) = sort_labels(u, decisions), sort_labels(x, contexts), sort_labels(a, groups)
        true = true and sort_labels(*true)
    if not known.all():
        a, a[known] = np.full(rows, -1, dtype=np.int64), a
    return CodedTable(
        (u, x, a), read.counts, decisions, contexts, groups, read.values, read.locate, read.notes, read.units, true, read.preparation
    )


def read_labels(
    table: Any,
    labelled: Sequence[str],
    others: Sequence[str],
    missing: Missing,
    unit: Sequence[str] = (),
    *,
    count: str | None = None,
    measured_in: Unit = "decisions",
    group: Sequence[str] = (),
    unknown: Sequence[str] = (),
    decision: str | None = None,
) -> LabelledRows:
    """Read label columns as codes, each by itself, and fetch others; `read_columns` says what is accepted.

    Examples
    --------
    >>> read = read_labels({"sex": ["f", "m", "f"]}, ["sex"], [], "error")
    >>> [part.tolist() if hasattr(part, "tolist") else part for part in read.labels["sex"]]
    [[0, 1, 0], ['f', 'm']]
    """
    lists = _lists(table, labelled, others)
    counts = counted(table, len(lists[labelled[0]]))
    where = locator(table)
    _check_missing(missing)
    if missing == "undecided" and (decision is None or measured_in == "rows"):
        raise InputError("missing='undecided' (--missing undecided) goes with counts and logs of decisions, and here are none")
    coded = {name: _encoded(table, lists[name], name, where) for name in labelled}
    values = {name: lists[name] for name in others}
    absent = {name: codes < 0 for name, (codes, _) in coded.items()}
    weighed = _Weights(counts, None if count is None else values[count], count or "", np.all(list(absent.values()), axis=0), where)
    done: list[Entry] = []
    unknown, lost = _occurring(unknown, [coded[name][1] for name in group])
    named: dict[str, NDArray[np.bool_]] = {}
    for name in group:
        coded[name], named[name] = _unknown_labels(*coded[name], unknown, empty=missing == "unknown")
    prepared = getattr(table, "preparation", ())
    dropped = labelled if missing == "drop" else [name for name in labelled if name in scored(prepared)]
    keep = ~np.any([absent[name] for name in dropped], axis=0) if dropped else np.ones(len(counts), dtype=bool)
    for name in labelled:
        levels = missing == "group" or (missing == "undecided" and name == decision)
        own: Missing = "drop" if name in dropped else "group" if levels else "error" if missing == "undecided" else missing
        coded[name] = _missing_labels(*coded[name], name, own, where, counts)
        if own == "group" and (amount := weighed(absent[name] & keep)):
            done.append(level(name, MISSING_LABEL, measured_in, amount))
    rows = len(lists[labelled[0]])
    units = label_codes(table, unit, where)
    for name, (codes, _) in zip(unit, units, strict=True):
        if unit.count(name) > 1:
            raise InputError(f"the column {shown(name)} is used twice; each column has one role")
        if len(codes) != rows:
            raise InputError(
                f"column {shown(name)} has {len(codes)} {noun(len(codes), 'value')} and column {shown(labelled[0])} "
                f"{rows}; they must be equally long"
            )
    if not keep.all():
        kept = np.flatnonzero(keep).tolist()
        if not kept:
            raise InputError("every row has a missing label; nothing is left to audit")
        if amount := weighed(~keep):
            by_group = _by_group([coded[name] for name in group], list(named.values()), keep, weighed) if group else None
            by_column = {name: weighed(absent[name]) for name in dropped}
            done.append(left_out(measured_in, amount, weighed(keep) + amount, by_column, by_group))
        counts = counts[keep]
        coded = {name: _recode(codes[keep], texts) for name, (codes, texts) in coded.items()}
        values = {name: cells[kept] if isinstance(cells, np.ndarray) else [cells[i] for i in kept] for name, cells in values.items()}
        units = [_recode(codes[keep], texts) if (codes[keep] >= 0).all() else (codes[keep], texts) for codes, texts in units]
        everywhere = where

        def where(position: int) -> str:
            return everywhere(kept[position])

        rows = len(kept)
    named = {name: rows_of[keep] for name, rows_of in named.items()}
    known = np.ones(rows, dtype=bool) if not named else ~np.any(list(named.values()), axis=0)
    if not known.all():
        done += _unknown_entry(named, known, keep, weighed, measured_in, ["", *unknown] if missing == "unknown" else unknown)
        coded |= {name: _among(known, *coded[name]) for name in group}
    notes = (*lost, *map(words, done))
    labels = {name: [*texts, *(unknown if name in group else ())] for name, (_, texts) in coded.items()}
    preparation = in_order((*prepared, *done), labelled, labels)
    return LabelledRows(coded, counts, values, where, notes, tuple(units), preparation, known)


def _by_group(
    coded: Sequence[tuple[NDArray[np.int64], list[str]]], unknown: Sequence[NDArray[np.bool_]], keep: NDArray[np.bool_], weighed: _Weights
) -> ByGroup:
    """Of each group of which rows are not kept, how many decisions these stand for, and of how many."""
    there = np.all([codes >= 0 for codes, _ in coded], axis=0) & ~np.any(list(unknown), axis=0)
    lost = there & ~keep
    if not lost.any():
        return {}
    codes, labels = combine([(own[there], texts) for own, texts in coded], int(there.sum()))
    found = np.full(len(keep), -1, dtype=np.int64)
    found[there] = codes
    left, of = weighed.each(found, lost), weighed.each(found, np.isin(found, found[lost]) & there)
    return {labels[a]: (amount, of[a]) for a, amount in left.items() if amount}


def _among(known: NDArray[np.bool_], codes: NDArray[np.int64], texts: list[str]) -> tuple[NDArray[np.int64], list[str]]:
    """Codes of a column, and the labels that rows of known group have."""
    own, kept = _recode(codes[known], texts)
    everywhere = np.zeros(len(codes), dtype=np.int64)
    everywhere[known] = own
    return everywhere, kept


def _check_missing(missing: str) -> None:
    if missing not in get_args(Missing):
        raise InputError(f"missing={shown(missing)} is not accepted; use 'error', 'drop', 'group', 'unknown' or 'undecided'")


def _occurring(unknown: Sequence[str], held: Sequence[Sequence[str]]) -> tuple[list[str], tuple[str, ...]]:
    """Those of the labels that name no group which occur, and what is said of the others."""
    occurring = {text for texts in held for text in texts}
    lost = (label for label in unknown if label not in occurring)
    said = tuple(f"{shown(label)}, which counts as unknown, occurs in no group column" for label in lost)
    return [label for label in unknown if label in occurring], said


def _unknown_entry(
    named: dict[str, NDArray[np.bool_]],
    known: NDArray[np.bool_],
    kept: NDArray[np.bool_],
    weighed: _Weights,
    unit: Unit,
    labels: Sequence[str],
) -> list[Entry]:
    """Say how many of the rows that were kept have no group, by which columns; nothing where they stand for no decisions."""
    if not known.any():
        raise InputError("the group of every row is unknown; nothing is left to audit")
    amount = weighed.of(~known, kept)
    by_column = {name: weighed.of(rows, kept) for name, rows in named.items()}
    return [unknown_groups(unit, labels, amount, weighed.of(known, kept) + amount, by_column)] if amount else []


@dataclass(frozen=True)
class _Weights:
    """How many decisions rows stand for, where that is asked: as many as a column says, or else one for each row of the log.

    Blank rows, which have no label and no number either, stand for none.
    """

    counts: NDArray[np.int64]
    values: list[Any] | NDArray[np.int64] | None
    column: str
    unlabelled: NDArray[np.bool_]
    locate: Locate

    def of(self, rows: NDArray[np.bool_], kept: NDArray[np.bool_]) -> Fraction:
        """How many the rows stand for, which are given among those that were kept."""
        everywhere = np.zeros(len(kept), dtype=bool)
        everywhere[kept] = rows
        return self(everywhere)

    def __call__(self, rows: NDArray[np.bool_]) -> Fraction:
        values = self.values
        if values is None:
            return Fraction(int(self.counts[rows].sum()))
        if isinstance(values, np.ndarray):
            return Fraction(int((values[rows] * self.counts[rows]).sum()))
        _, listed, scale = self._listed(values, rows)
        return Fraction(sum(listed), scale)

    def each(self, codes: NDArray[np.int64], rows: NDArray[np.bool_]) -> dict[int, Fraction]:
        """How many those of the rows with each code stand for."""
        values = self.values
        if isinstance(values, list):
            at, listed, scale = self._listed(values, rows)
            sums = dict.fromkeys(codes[rows].tolist(), 0)
            for a, amount in zip(codes[at].tolist(), listed, strict=True):
                sums[a] += amount
            return {a: Fraction(amount, scale) for a, amount in sums.items()}
        amounts = self.counts if values is None else values * self.counts
        found, places = distinct(codes[rows])
        sums_of = np.zeros(len(found), dtype=np.int64)
        np.add.at(sums_of, places, amounts[rows])
        return dict(zip(found.tolist(), map(Fraction, sums_of.tolist()), strict=True))

    def _listed(self, values: list[Any], rows: NDArray[np.bool_]) -> tuple[list[int], list[int], int]:
        """Which of the rows stand for decisions, and how many, over one denominator."""
        places = [i for i in np.flatnonzero(rows).tolist() if not self.unlabelled[i] or label_text(values[i]) is not None]
        if not places:
            return [], [], 1
        listed, scale = numbers([values[i] for i in places], self.column, lambda position: self.locate(places[position]), "share")
        if listed.dtype.kind == "f":
            listed, scale = exact_floats(listed)
        return places, [n * times for n, times in zip(listed.tolist(), self.counts[places].tolist(), strict=True)], scale


def _lists(table: Any, labelled: Sequence[str], others: Sequence[str]) -> dict[str, Any]:
    """Cells of the columns; of a `Tally` only the codes of those that are labels and nothing else."""
    used = [*labelled, *others]
    coded = set(labelled) & set(table.codes) if isinstance(table, Tally) else set()
    for name in used:
        if used.count(name) > 1:
            raise InputError(f"the column {shown(name)} is used twice; each column has one role")
    lists = {name: table.codes[name] if name in coded else cells_of(table, name) for name in used}
    rows = len(lists[used[0]])
    for name, values in lists.items():
        if len(values) != rows:
            raise InputError(
                f"column {shown(name)} has {len(values)} {noun(len(values), 'value')} and column {shown(used[0])} {rows}; "
                f"they must be equally long"
            )
    if rows == 0:
        raise InputError("the table has no rows")
    return lists


def _unknown_labels(
    codes: NDArray[np.int64], texts: list[str], unknown: Sequence[str], *, empty: bool
) -> tuple[tuple[NDArray[np.int64], list[str]], NDArray[np.bool_]]:
    """Codes of a group column in which labels that name no group have been written as the first one that does, and which rows have them."""
    places = [place for place, text in enumerate(texts) if text in unknown]
    rows = np.isin(codes, places) | ((codes < 0) & empty)
    if not rows.any():
        return (codes, texts), rows
    first = next((place for place in range(len(texts)) if place not in set(places)), 0)
    return (np.where(rows, first, codes), texts or [""]), rows


def _missing_labels(
    codes: NDArray[np.int64], texts: list[str], name: str, missing: Missing, where: Locate, counts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], list[str]]:
    """Refuse missing labels, or make them a level, or leave them to be dropped."""
    absent = codes < 0
    if not absent.any() or missing == "drop":
        return codes, texts
    if missing in ("error", "unknown"):
        at = int(np.flatnonzero(absent)[0])
        raise InputError(
            f"column {shown(name)}, {where(at)}: the label is missing ({int(counts[absent].sum())} in all); "
            "missing=drop (--missing drop) leaves such rows out, missing=group (--missing group) makes them a level"
        )
    if MISSING_LABEL in texts:
        raise InputError(label_is_there(name))
    return np.where(absent, len(texts), codes), [*texts, MISSING_LABEL]


def label_is_there(name: str) -> str:
    """Say that missing labels would have the name of a label that a column has."""
    return f"column {shown(name)} already has a label {MISSING_LABEL!r}; rename it, or use missing=drop"


def sort_labels(codes: NDArray[np.int64], labels: list[Any]) -> tuple[NDArray[np.int64], list[Any]]:
    """Sort labels by code point, and their codes with them."""
    order = sorted(range(len(labels)), key=labels.__getitem__)
    rank = np.empty(len(labels), dtype=np.int64)
    rank[order] = np.arange(len(labels))
    return rank[codes], [labels[i] for i in order]


def _recode(codes: NDArray[np.int64], texts: list[str]) -> tuple[NDArray[np.int64], list[str]]:
    """Forget the labels that no row uses any more."""
    ranks, values = in_order_of_appearance(codes)
    return ranks, [texts[v] for v in values]


def _encoded(table: Any, values: Any, name: str, locate: Locate) -> tuple[NDArray[np.int64], list[str]]:
    """Codes of a column; of a `Tally` and of `Cells` only the different values are looked at."""
    if isinstance(table, Tally):
        at, levels = table.codes[name], table.levels[name]
    elif isinstance(values, Cells):
        at, levels = values.codes, values.levels
    else:
        return encode(values, name, locate)

    def first(level: int) -> str:
        return locate(int(np.flatnonzero(at == level)[0]))

    codes, texts = encode(levels, name, first)
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
    return [_encoded(table, [] if name in held else cells_of(table, name), name, locate) for name in columns]


def cells_of(table: Any, name: str) -> Any:
    """Values of a column: of a text that an engine read as it holds them, else as a list."""
    held = table.texts.get(name) if isinstance(table, CsvTable) else None
    return held if isinstance(held, (Cells, np.ndarray)) else column(table, name)
