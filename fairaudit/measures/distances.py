"""Total variation distances between the decisions of two groups, within contexts and overall, each with its witness."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.measures.blocks import block_starts, equal_blocks
from fairaudit.model.law import Law
from fairaudit.tables.values import distinct
from fairaudit.words import brief

__all__ = ["Distance", "DistanceWitness", "demographic_parity", "equalized_odds", "most_unequal_distances"]


BLOCK = 1 << 17  # entries of a block that stay in the cache of one core


@brief
@dataclass(frozen=True, repr=False)
class DistanceWitness:
    """Where a total variation distance is attained: on the event that the decision is one of `decisions`."""

    context: dict[str, str] | None
    higher: dict[str, str]
    lower: dict[str, str]
    decisions: tuple[str, ...]


@brief
@dataclass(frozen=True, repr=False)
class Distance:
    """A greatest total variation distance between two groups, exact, with its witness.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> result.demographic_parity.value, result.demographic_parity.witness.decisions
    (Fraction(1, 4), ('yes',))
    """

    value: Fraction
    witness: DistanceWitness


@dataclass(frozen=True)
class _Rows:
    """Laws of members, sorted into blocks: floats with an absolute error bound per distance, and exact integer rows."""

    floats: Floats
    error: float
    starts: NDArray[np.int64]
    exact: Callable[[int], list[int]]
    exact_key: NDArray[Any]
    """The rows as they are stored: members with equal stored rows are surely equal."""


def demographic_parity(law: Law) -> Distance | None:
    """Demographic parity: the greatest total variation distance between P(·|a) and P(·|a'); None if undefined."""
    found = most_unequal_distances(law, 1, within_context=False)
    return found[0] if found else None


def equalized_odds(law: Law) -> Distance | None:
    """Equalized odds in the paper's form, conditioned on the context: the greatest distance between P(·|x,a) and P(·|x,a')."""
    found = most_unequal_distances(law, 1, within_context=True)
    return found[0] if found else None


def most_unequal_distances(law: Law, count: int, *, within_context: bool) -> tuple[Distance, ...]:
    """Rank pairs of groups by the total variation distance of their decisions.

    Parameters
    ----------
    law : Law
        The law.
    count : int
        How many pairs at the most.
    within_context : bool
        Whether groups are compared within each context (equalized odds) or over all (demographic parity).

    Returns
    -------
    tuple of Distance
        The most unequal pairs first; pairs that are equal are left out unless nothing else is there.
    """
    if within_context:
        cells = np.flatnonzero(law.compared)
        rows = _law_rows(law, cells)
        owner = law.cell_group[cells].tolist()
    else:
        owner = list(law.global_groups)
        rows = _mixed_rows(law)
        cells = np.zeros(len(owner), dtype=np.int64)
    results = []
    for value, i, j in _rank_distances(rows, count):
        p, q = rows.exact(i), rows.exact(j)
        total_p, total_q = sum(p), sum(q)
        chosen = tuple(u for u, v, w in zip(law.decisions, p, q, strict=True) if v * total_q > w * total_p)
        context = law.context_label(int(law.cell_context[cells[i]])) if within_context else None
        results.append(Distance(value, DistanceWitness(context, law.group_label(owner[i]), law.group_label(owner[j]), chosen)))
    return tuple(results)


def _law_rows(law: Law, cells: NDArray[np.int64]) -> _Rows:
    weights = law.weights if len(cells) == len(law.weights) else law.weights[cells]

    def exact(i: int) -> list[int]:
        return law.row(int(cells[i]))

    return _Rows(law.float_rows(cells), _distance_error(len(law.decisions)), block_starts(law, cells), exact, weights)


def _listed_rows(rows: Sequence[list[int]]) -> _Rows:
    starts = np.array([0, len(rows)] if rows else [0], dtype=np.int64)
    columns = len(rows[0]) if rows else 1
    return _Rows(
        _object_rows(rows).reshape(len(rows), columns),
        _distance_error(columns),
        starts,
        rows.__getitem__,
        np.array(rows, dtype=object).reshape(len(rows), columns),
    )


def _mixed_rows(law: Law) -> _Rows:
    """P(·|a) of the globally compared groups."""
    if law.population == "counts" or not law.global_groups:
        return _listed_rows(law.mixed_rows)
    floats, relative, _ = law.mixed_floats
    starts, own = np.array([0, len(floats)], dtype=np.int64), np.arange(len(floats))[:, None]
    return _Rows(floats, _distance_error(floats.shape[1]) + 4 * relative, starts, law.mixed_row, own)


def _object_rows(rows: Sequence[Sequence[int]]) -> Floats:
    return np.array([[w / total for w in row] for row in rows for total in (sum(row),)], dtype=np.float64)


def _distance_error(columns: int) -> float:
    """Bound on the error of Σ max(0, p − q): two rows with relative errors of (n+4) units each, differences, and the sum."""
    return (4 * columns + 64) * UNIT


def _rank_distances(rows: _Rows, count: int) -> list[tuple[Fraction, int, int]]:
    """Find the `count` greatest total variation distances as (value, first, second); equal pairs only if nothing else is there."""
    if len(rows.starts) < 2 or not len(rows.floats):
        return []
    _, firsts, seconds = _distance_candidates(rows, count)
    order = np.lexsort((seconds, firsts))
    classes: dict[tuple[int, ...], int] = {}
    class_of: dict[int, int] = {}

    def row_class(i: int) -> int:
        if i not in class_of:
            row = rows.exact(i)
            common = gcd(*row)
            class_of[i] = classes.setdefault(tuple(v // common for v in row), len(classes))
        return class_of[i]

    exact: dict[tuple[int, int], Fraction] = {}
    found: list[tuple[Fraction, int, int]] = []
    certain = 0
    for i, j in zip(firsts[order].tolist(), seconds[order].tolist(), strict=True):
        p, q = row_class(i), row_class(j)
        if p == q:
            continue
        key = (min(p, q), max(p, q))
        if key not in exact:
            exact[key] = _distance(rows.exact(i), rows.exact(j))
        found.append((exact[key], i, j))
        certain += exact[key] == 1
        if certain >= count:
            break
    best = heapq.nsmallest(count, found, key=lambda entry: (-entry[0], entry[1], entry[2]))
    return best or [(Fraction(0), 0, 1)]


def _distance(p: list[int], q: list[int]) -> Fraction:
    total_p, total_q = sum(p), sum(q)
    return Fraction(sum(max(0, v * total_q - w * total_p) for v, w in zip(p, q, strict=True)), total_p * total_q)


def _distance_candidates(rows: _Rows, count: int) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Pairs (first < second) whose float distance could be among the `count` greatest."""
    sizes = np.diff(rows.starts)
    sizes[equal_blocks(rows.exact_key, rows.starts, np.arange(len(sizes)))] = 0
    kept: list[tuple[Floats, NDArray[np.int64], NDArray[np.int64]]] = []
    floor = 0.0
    for size in distinct(sizes[sizes > 1])[0].tolist():
        blocks = np.flatnonzero(sizes == size)
        first_rows = rows.starts[:-1][blocks]
        for values, firsts, seconds in _block_distances(rows.floats, first_rows, size):
            if values.size > count:
                floor = max(floor, float(np.partition(values, values.size - count)[values.size - count]))
            good = values >= floor - 2 * rows.error
            kept.append((values[good], firsts[good], seconds[good]))
    if not kept:
        nothing = np.zeros(0, dtype=np.int64)
        return nothing.astype(np.float64), nothing, nothing
    values, firsts, seconds = (np.concatenate(part) for part in zip(*kept, strict=True))
    if values.size > count:
        floor = max(floor, float(np.partition(values, values.size - count)[values.size - count]))
    good = values >= floor - 2 * rows.error
    values, firsts, seconds = values[good], firsts[good], seconds[good]
    differ = np.ones(len(values), dtype=bool)
    close = np.flatnonzero(values <= 2 * rows.error)
    for part in np.array_split(close, max(1, len(close) * rows.floats.shape[1] // 10_000_000)):
        differ[part] = (rows.floats[firsts[part]] != rows.floats[seconds[part]]).any(axis=1)
    # Float rows that agree to the last bit may still differ exactly; only rows that are certainly equal may be skipped.
    doubtful = np.flatnonzero(~differ)
    if len(doubtful):
        differ[doubtful] = _exactly_different(rows, firsts[doubtful], seconds[doubtful])
    return values[differ], firsts[differ], seconds[differ]


def _exactly_different(rows: _Rows, firsts: NDArray[np.int64], seconds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Decide which pairs of rows differ as laws, evaluating every row once."""
    classes: dict[tuple[int, ...], int] = {}
    involved = np.unique(np.concatenate((firsts, seconds)))
    code = np.empty(len(rows.floats), dtype=np.int64)
    for i in involved.tolist():
        row = rows.exact(i)
        common = gcd(*row)
        code[i] = classes.setdefault(tuple(v // common for v in row), len(classes))
    return np.asarray(code[firsts] != code[seconds])


def _block_distances(
    floats: Floats, first_rows: NDArray[np.int64], size: int
) -> Iterator[tuple[Floats, NDArray[np.int64], NDArray[np.int64]]]:
    """Float distances of all pairs in blocks of one size, in chunks: vectorised over blocks when they are many, else over members."""
    if size * (size - 1) // 2 <= len(first_rows):
        step = max(1, 4_000_000 // max(1, size * floats.shape[1]))
        for begin in range(0, len(first_rows), step):
            base = first_rows[begin : begin + step]
            for i in range(size - 1):
                left = floats[base + i]
                for j in range(i + 1, size):
                    values = np.maximum(left - floats[base + j], 0.0).sum(axis=1)
                    yield values, base + i, base + j
        return
    ones = np.ones(floats.shape[1])
    step = max(1, BLOCK // (size * floats.shape[1]))
    for base in first_rows.tolist():
        block = floats[base : base + size]
        for start in range(0, size - 1, step):
            firsts = block[start : min(start + step, size - 1)]
            values = np.maximum(firsts[:, None] - block[None, start + 1 :], 0.0) @ ones
            first, second = np.nonzero(np.tri(*values.shape[::-1], dtype=np.bool_).T)
            yield values[first, second], base + start + first, base + start + 1 + second


PARITY_WITHIN = "parity within contexts (the paper's equalized odds)"
