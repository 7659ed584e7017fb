"""How tables and arrays are laid out as a law: names of columns, weights and masses of cells, sampling units, true labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.exact.dense import least_and_sums
from fairaudit.exact.number_columns import NumberColumn
from fairaudit.exact.rationals import common_denominator, rational
from fairaudit.tables.columns import CodedTable
from fairaudit.tables.label_text import label_text
from fairaudit.tables.values import INT64, Label, Locate, combine, distinct, exact_floats, number_text, numbers
from fairaudit.words import brief, noun

__all__ = ["Columns", "Truth", "Units"]


Kind = Literal["counts", "probabilities"]


MAX_ENTRIES = 500_000_000  # numbers of a dense law: 4 GB as int64

MAX_TOGETHER = 50_000_000  # units times groups of which is looked up what they have in all groups of a context


@dataclass(frozen=True)
class Columns:
    """Names of the columns that a law was read from.

    Examples
    --------
    >>> import fairaudit as fa
    >>> fa.Columns("hired", ("sex", "age"), ("department",))
    Columns(decision='hired', group=('sex', 'age'), context=('department',), truth=None)
    """

    decision: str
    group: tuple[str, ...]
    context: tuple[str, ...] = ()
    truth: str | None = None


@brief
@dataclass(frozen=True, repr=False)
class Units:
    """Sampling units of a log: a run, a person, a profile, of which each may have several rows.

    Attributes
    ----------
    columns : tuple of str
        The columns that name them.
    total : int
        How many there are.
    spanning : int
        How many of them have rows in several cells.
    once_per_group : bool
        Whether no unit has two rows with the same group.
    profiles : tuple of tuple of (int, tuple of int)
        For each cell of the law the different counts of rows per decision that a unit has there, each after the number of such units.
    together : tuple of tuple of (int, tuple of int)
        For each context what its units have in all of its cells, each after the number of such units: positions in the profiles of these
        cells, −1 where the units have no rows. Empty if no unit has rows in two groups of a context.
    """

    columns: tuple[str, ...]
    total: int
    spanning: int
    once_per_group: bool
    profiles: tuple[tuple[tuple[int, tuple[int, ...]], ...], ...]
    together: tuple[tuple[tuple[int, tuple[int, ...]], ...], ...] = ()

    @property
    def repeated(self) -> bool:
        """Whether some unit has several rows in one cell."""
        return any(sum(rows) > 1 for cell in self.profiles for _, rows in cell)


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Truth:
    """True labels beside the decisions: what should have been decided.

    Attributes
    ----------
    labels : tuple of str
        The true labels, ordered as decisions are.
    weights : ndarray, shape (cells, labels, decisions)
        How the weights of each cell are spread over the true labels.
    """

    labels: tuple[str, ...]
    weights: NDArray[Any]


def dyadic(row: Sequence[float]) -> list[int]:
    """Floats as integers over a common power of two, up to that factor.

    Examples
    --------
    >>> dyadic([0.25, 0.75])
    [1, 3]
    """
    pairs = [value.as_integer_ratio() for value in row]
    bottom = max(d for _, d in pairs)
    return [n * (bottom // d) for n, d in pairs]


def dyadic_rows(rows: NDArray[Any]) -> NDArray[Any]:
    """Rows of non-negative floats as integers, each over a power of two of its own: int64 if all sums fit, else Python integers.

    Examples
    --------
    >>> [[v / sum(row) for v in row] for row in dyadic_rows(np.array([[0.25, 0.75], [0.0, 3.0]])).tolist()]
    [[0.25, 0.75], [0.0, 1.0]]
    """
    parts, exponents = np.frexp(rows.astype(np.float64, copy=False))
    tops = (parts * 2.0**53).astype(np.int64)
    shifts = np.where(tops > 0, exponents, 0).astype(np.int64)
    least = np.where(tops > 0, exponents, np.iinfo(np.int32).max).min(axis=1)
    shifts = np.where(tops > 0, shifts - least[:, None], 0)
    if int(shifts.max(initial=0)) <= 8 and rows.shape[1] <= 2:
        return np.asarray(tops << shifts)
    return np.asarray(tops.astype(object) << shifts.astype(object))


def spread_truth(
    coded: CodedTable, columns: Columns, weights: NDArray[Any], cell: NDArray[np.int64], cells: int, full: NDArray[np.bool_]
) -> Truth | None:
    """Spread the weights of the cells over the true labels."""
    if coded.truth is None:
        return None
    codes, labels = coded.truth
    shape = (cells, len(labels), len(coded.decisions))
    if prod(shape) > MAX_ENTRIES:
        raise InputError(
            f"column {shown(columns.truth)} has {len(labels)} true labels, which with {cells} combinations of context and group and "
            f"{len(coded.decisions)} decisions are more than {MAX_ENTRIES} entries"
        )
    spread = np.zeros(shape, dtype=weights.dtype)
    np.add.at(spread, (cell, codes, coded.codes[0]), weights)
    return Truth(tuple(labels), spread[full])


def sampling_units(coded: CodedTable, columns: tuple[str, ...], cell: NDArray[np.int64], cells: int) -> Units:
    """Which rows belong to which sampling unit, as far as an interval needs it."""
    for name, (found, _) in zip(columns, coded.units, strict=True):
        if (found < 0).any():
            at = int(np.flatnonzero(found < 0)[0])
            raise InputError(f"column {shown(name)}, {coded.locate(at)}: the sampling unit has no label; every row belongs to a unit")
    codes, texts = combine(coded.units, len(cell))
    u, x, a = coded.codes
    keys, pair = distinct(cell * len(texts) + codes)
    if len(keys) * len(coded.decisions) > MAX_ENTRIES:
        raise InputError(
            f"column {shown(name)}: {len(keys)} units in {cells} cells with {len(coded.decisions)} decisions are too many entries"
        )
    rows = np.zeros((len(keys), len(coded.decisions)), dtype=np.int64)
    np.add.at(rows, (pair, u), coded.counts)
    own = keys // len(texts)
    kinds, kind, times = np.unique(np.column_stack((own, rows)), axis=0, return_inverse=True, return_counts=True)
    profiles: list[list[tuple[int, tuple[int, ...]]]] = [[] for _ in range(cells)]
    for (where, *counts), n in zip(kinds.tolist(), times.tolist(), strict=True):
        profiles[where].append((n, tuple(counts)))
    _, per_unit = np.unique(keys % len(texts), return_counts=True)
    once = len(np.unique(a * len(texts) + codes)) == coded.counts.sum()
    first = np.searchsorted(kinds[:, 0], np.arange(cells))
    context_of = np.zeros(cells, dtype=np.int64)
    context_of[cell] = x
    joint = _together(own, keys % len(texts), kind.ravel() - first[own], context_of)
    return Units(columns, len(texts), int((per_unit > 1).sum()), once, tuple(map(tuple, profiles)), joint)


def _together(
    cell: NDArray[np.int64], unit: NDArray[np.int64], seen: NDArray[np.int64], context: NDArray[np.int64]
) -> tuple[tuple[tuple[int, tuple[int, ...]], ...], ...]:
    """What the units of each context have in all of its cells, of what they have in each; the contexts of the cells rise."""
    starts = np.searchsorted(context, np.arange(context[-1] + 2))
    widest = int(np.diff(starts).max())
    keys, pair = distinct(context[cell] * (int(unit.max()) + 1) + unit)
    if len(keys) == len(cell) or len(keys) * widest > MAX_TOGETHER:
        return ()
    held = np.full((len(keys), widest), -1, dtype=np.int64)
    held[pair, cell - starts[context[cell]]] = seen
    where = np.empty(len(keys), dtype=np.int64)
    where[pair] = context[cell]
    kind, span = where, int(seen.max()) + 2
    for column in held.T:
        _, kind = distinct(kind * span + column + 1)
    times = np.bincount(kind)
    example = np.empty(len(times), dtype=np.int64)
    example[kind] = np.arange(len(keys))
    found: list[list[tuple[int, tuple[int, ...]]]] = [[] for _ in range(len(starts) - 1)]
    sizes = np.diff(starts).tolist()
    for x, n, positions in zip(where[example].tolist(), times.tolist(), held[example].tolist(), strict=True):
        found[x].append((n, tuple(positions[: sizes[x]])))
    return tuple(map(tuple, found))


def copies_of_units(coded: CodedTable, columns: tuple[str, ...]) -> tuple[str, ...]:
    """A note, if units answered alike more often than their answers explain."""
    from fairaudit.model.replication import copies_note

    u, x, a = coded.codes
    note = copies_note(columns, combine(coded.units, len(u)), x, a, u, coded.counts)
    return (note,) if note else ()


def refuse_repeats(flat: NDArray[np.int64], coded: CodedTable, columns: Columns) -> None:
    order = np.argsort(flat, kind="stable")
    again = np.flatnonzero(flat[order][1:] == flat[order][:-1])
    if not len(again):
        return
    at = int(order[again + 1].min())
    first = int(np.flatnonzero(flat == flat[at])[0])
    u, x, a = (int(codes[at]) for codes in coded.codes)
    labels = zip(
        (columns.decision, *columns.context, *columns.group), (coded.decisions[u], *coded.contexts[x], *coded.groups[a]), strict=True
    )
    said = ", ".join(f"{name}={shown(text)}" for name, text in labels)
    merged = any(entry["step"] in ("mapped", "folded") for entry in coded.preparation)
    why = "; probabilities of labels that are merged cannot be added, because how often each occurs is not known: give counts" * merged
    raise InputError(
        f"{coded.locate(at)}: the probability of {said} was given before, on {coded.locate(first)}; each combination has one row{why}"
    )


def masses_of_cells(values: list[Any], name: str, cell: NDArray[np.int64], cells: int, where: Locate) -> tuple[int, ...]:
    listed, _ = numbers(values, name, where)
    if listed.dtype.kind == "f":
        listed, _ = exact_floats(listed)
    mass = np.zeros(cells, dtype=listed.dtype)
    mass[cell[::-1]] = listed[::-1]
    different = np.flatnonzero(mass[cell] != listed)
    if len(different):
        at = int(different[0])
        raise InputError(
            f"column {shown(name)}, {where(at)}: the mass {shown(values[at])} differs from that on other rows of the same context and group"
        )
    result = tuple(int(m) for m in mass.tolist())
    if not any(result):
        raise InputError(f"column {shown(name)}: every mass is zero; at least one must be positive")
    return result


def axis_labels(labels: Sequence[Any] | None, size: int, axis: str) -> list[Label]:
    if labels is None:
        return [(str(i),) for i in range(size)]
    listed = []
    for label in labels:
        parts = label if isinstance(label, tuple) else (label,)
        texts = []
        for part in parts:
            text = label_text(part)
            if text is None:
                raise InputError(f"a label of the {axis} is missing")
            texts.append(text)
        listed.append(tuple(texts))
    if len(listed) != size:
        raise InputError(f"{len(listed)} {noun(len(listed), 'label was', 'labels were')} given for {size} {axis}")
    if len(set(listed)) != len(listed):
        raise InputError(f"the labels of the {axis} are not all different")
    if len({len(label) for label in listed}) > 1:
        raise InputError(f"the labels of the {axis} have different numbers of parts")
    return listed


def array_entries(matrix: NDArray[Any], kind: Kind) -> tuple[NDArray[Any], int, NDArray[np.float64] | None, NDArray[Any] | None]:
    """Entries of an array, exact and checked: the denominator of counts, the row sums of floats, those of rows of other probabilities."""
    scale = 1
    sums, bottoms = None, None
    least: Any
    if matrix.dtype.kind == "f" and matrix.dtype.itemsize <= 8:
        if matrix.dtype != np.float32 or kind == "counts":
            matrix = matrix.astype(np.float64, copy=False)
        least, sums = least_and_sums(matrix)
        if not (np.isfinite(least) and (np.isfinite(sums).all() or np.isfinite(float(matrix.max())))):
            raise InputError("the array has an entry that is not a finite number")
    elif matrix.dtype.kind in "iu":
        least = int(matrix.min())
        wide = float(matrix.max()) * matrix.size >= 2.0**62 and int(matrix.astype(object).sum()) > INT64
        matrix, bottoms = matrix.astype(object if wide else np.int64), np.ones(len(matrix), dtype=np.int64)
    else:
        listed = matrix.ravel().tolist()
        column, left = NumberColumn.of_texts(list(map(number_text, listed)))
        column = replace(column, others={place: rational(listed[place]) for place in left})
        least = min((top for top, _ in column.others.values()), default=0)
        if least >= 0 and kind == "counts":
            flat, scale = column.over_one_denominator()
            matrix = flat.reshape(matrix.shape)
        elif least >= 0:
            matrix, bottoms = column.rows(np.arange(matrix.size), matrix.shape)
    if least < 0:
        raise InputError("the array has a negative entry; entries of at least 0 are accepted")
    if kind == "counts" and matrix.dtype.kind == "f":
        flat, scale = exact_floats(matrix.ravel())
        matrix = flat.reshape(matrix.shape)
    return matrix, scale, sums, bottoms


def default_names(stem: str, count: int) -> tuple[str, ...]:
    return (stem,) if count == 1 else tuple(f"{stem}{i + 1}" for i in range(count))


def array_mass(population: Any, kind: Kind, shape: tuple[int, int], full: NDArray[np.bool_]) -> tuple[int, ...]:
    if kind == "counts":
        raise InputError("counts carry their own population; give a population only with probabilities")
    given = np.asarray(population)
    if given.shape != shape:
        raise InputError(f"the population has shape {given.shape}; it must be {shape}, contexts by groups")
    pairs = [rational(v) for v in given.ravel().tolist()]
    if any(n < 0 for n, _ in pairs):
        raise InputError("the population has a negative mass; masses of at least 0 are accepted")
    whole, _ = common_denominator(pairs)
    if any(m > 0 and not f for m, f in zip(whole, full.tolist(), strict=True)):
        raise InputError("the population gives mass to a context and group without a law; give that cell a law, or mass 0")
    mass = tuple(m for m, f in zip(whole, full.tolist(), strict=True) if f)
    if not any(mass):
        raise InputError("every mass of the population is zero; at least one must be positive")
    return mass
