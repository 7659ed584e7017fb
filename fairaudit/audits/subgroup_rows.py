"""A log read for its subgroups: the rows by attributes and decisions."""

from __future__ import annotations

import os
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.audits.reading import Reading, read_rows
from fairaudit.certificates.subgroup_table import SubgroupTable
from fairaudit.errors import InputError, naming, shown
from fairaudit.exact.rationals import exact
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.tables.columns import LabelledRows, sort_labels
from fairaudit.tables.engines.request import Report
from fairaudit.tables.label_text import label_text
from fairaudit.tables.labels import spellings
from fairaudit.tables.preparation import Entry
from fairaudit.tables.sources import Source, source_name
from fairaudit.tables.values import distinct, exact_floats, numbers
from fairaudit.theorems.t18_search import entries

__all__ = ["SubgroupLog", "read_subgroup_log"]

MOST_COUNTS = 500_000_000  # numbers of rows that are held: 4 GB


@dataclass(frozen=True)
class SubgroupLog:
    """A log that was read.

    Attributes
    ----------
    table : SubgroupTable
        Its rows.
    preparation : tuple of mapping
        What was done to it before it was counted.
    notes : tuple of str
        What was noticed.
    spellings : tuple of mapping
        Labels that differ in spelling alone.
    """

    table: SubgroupTable
    preparation: tuple[Entry, ...]
    notes: tuple[str, ...]
    spellings: tuple[Entry, ...]


def read_subgroup_log(source: Source, reading: Reading, utility: Utility | None, *, report: Report | None = None) -> SubgroupLog:
    """Read a log by attributes (the groups of the reading) and decisions.

    Raises
    ------
    InputError
        If it cannot be read, there is no utility, or counts are no whole numbers.
    """
    if not reading.group:
        raise InputError(f"no attribute was named; name at least one with {reading.spelled('attributes')}")
    read = read_rows(source, reading, report=report)
    with naming(source_name(source) if isinstance(source, (str, os.PathLike, list, tuple)) else None):
        return _counted(read, reading, utility)


def _counted(read: LabelledRows, reading: Reading, utility: Utility | None) -> SubgroupLog:
    weights = _weights(read, reading)
    coded = [sort_labels(*read.labels[name]) for name in reading.group]
    u, decisions = sort_labels(*read.labels[reading.decision])
    worth = (
        _worth_by_row(read, reading, u, decisions)
        if reading.utility_column is not None
        else _worth(utility, reading, u, decisions, weights)
    )
    codes, listed = worth
    sizes = [len(labels) for _, labels in coded]
    entry = entries([part for part, _ in coded], sizes, len(u))
    size = int(entry.max()) + 1
    if size * len(listed) > MOST_COUNTS:
        raise InputError(f"{size} combinations of attributes with {len(listed)} decisions are more than {MOST_COUNTS} numbers; name fewer")
    counts = np.zeros((size, len(listed)), dtype=np.int32 if int(weights.sum()) < 1 << 31 else np.int64)  # half the memory
    np.add.at(counts, (entry, codes), weights)
    places = np.zeros((size, len(coded)), dtype=np.int64)
    for column, (part, _) in enumerate(coded):
        places[entry, column] = part
    there = counts.sum(axis=1) > 0
    if not there.any():
        raise InputError("every count is zero; nothing is left to audit")
    attributes = []
    places = places[there]
    for column, (name, (_, labels)) in enumerate(zip(reading.group, coded, strict=True)):
        used, places[:, column] = distinct(places[:, column])
        attributes.append((name, tuple(labels[i] for i in used.tolist())))
    table = SubgroupTable(reading.decision, tuple(attributes), tuple(listed), places, counts[there])
    named = [(reading.decision, list(dict.fromkeys(label for label, _ in listed))), *attributes]
    return SubgroupLog(table, read.preparation, read.notes, spellings(named))


def _weights(read: LabelledRows, reading: Reading) -> NDArray[np.int64]:
    """How many decisions each row stands for."""
    if reading.count is None:
        return read.counts
    values, scale = numbers(read.values[reading.count], reading.count, read.locate)
    if values.dtype.kind == "f":
        values, scale = exact_floats(values)
    weights = [value * n for value, n in zip(values.tolist(), read.counts.tolist(), strict=True)]
    if scale != 1 or sum(weights) >= 1 << 53:
        raise InputError(f"column {shown(reading.count)} has to count rows: whole numbers that add up to less than 2^53 are accepted")
    return np.array(weights, dtype=np.int64)


def _worth(
    utility: Utility | None, reading: Reading, u: NDArray[np.int64], decisions: list[str], weights: NDArray[np.int64]
) -> tuple[NDArray[np.int64], list[tuple[str, Fraction]]]:
    """The decisions, those that the utility names and nobody got included, each with what it is worth."""
    if utility is None:
        raise InputError(f"no utility was given; give {reading.spelled('utility')} or {reading.spelled('utility_column')}")
    if utility.entries is not None:
        raise InputError("the utility has to depend on the decision alone; for one that varies name the column that holds it")
    occurring = np.zeros(len(decisions), dtype=np.int64)
    np.add.at(occurring, u, weights)
    laid = utility.on(Law.from_array([np.maximum(occurring, 1).tolist()] * 2, kind="counts", decisions=decisions))
    order = sorted(range(len(laid.law.decisions)), key=laid.law.decisions.__getitem__)
    place = {laid.law.decisions[i]: at for at, i in enumerate(order)}
    listed = [(laid.law.decisions[i], Fraction(int(laid.values[i]), laid.scale)) for i in order]
    return np.array([place[label] for label in decisions], dtype=np.int64)[u], listed


def _worth_by_row(
    read: LabelledRows, reading: Reading, u: NDArray[np.int64], decisions: list[str]
) -> tuple[NDArray[np.int64], list[tuple[str, Fraction]]]:
    """The different decisions with what they were worth, as a column says."""
    name = reading.utility_column or ""
    values: list[Any] = [decisions[i] for i in u.tolist()] if name == reading.decision else read.values[name]
    known: dict[tuple[type, Any], Fraction] = {}
    pairs: list[tuple[str, Fraction]] = []
    for position, (label, value) in enumerate(zip(u.tolist(), values, strict=True)):
        key = type(value), value
        if key not in known:
            try:
                if label_text(value) is None:
                    raise InputError("the utility is missing")
                known[key] = exact(value)
                if known[key] < 0:
                    raise InputError(f"{shown(value)} is negative; utilities are at least 0")
            except InputError as error:
                raise InputError(f"column {shown(name)}, {read.locate(position)}: {error}") from None
        pairs.append((decisions[label], known[key]))
    listed = sorted(set(pairs))
    place = {pair: at for at, pair in enumerate(listed)}
    return np.array([place[pair] for pair in pairs], dtype=np.int64), listed
