"""The most unequal conjunctions of attribute values, found by counting, and the frontier beyond which nothing had to be counted."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.tables.values import distinct
from fairaudit.theorems.t18 import Side, refinements_below, subgroup_ratio
from fairaudit.words import brief

__all__ = ["Found", "Node", "Rows", "Worst", "conjunctions", "entries", "every_conjunction", "most_unequal"]

EXACT = 1 << 53
"""Integers below it are themselves as floats."""

SLACK = 1e-9
"""Far more than what rounding does to a ratio: what is closer than this to a limit is decided in integers."""

Condition = tuple[int, int]
"""An attribute and one of its values, by position."""

Conjunction = tuple[Condition, ...]


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Rows:
    """Rows of a log by what attributes they have: one entry for each combination that occurs.

    Attributes
    ----------
    codes : tuple of ndarray of int64
        For each attribute the positions of its values.
    sizes : tuple of int
        How many values each attribute has.
    counts : ndarray of int64, shape (entries, values)
        How many rows of an entry have each utility.
    values : tuple of int
        The utilities, rising from at least 0, as integers over one denominator.
    """

    codes: tuple[NDArray[np.int64], ...]
    sizes: tuple[int, ...]
    counts: NDArray[np.int64]
    values: tuple[int, ...]
    rows: int = field(init=False)
    total: int = field(init=False)

    def __post_init__(self) -> None:
        """Add up.

        Raises
        ------
        InputError
            If there are more rows than a float can count.
        """
        if float(self.counts.sum(dtype=np.float64)) >= EXACT / 2:
            raise InputError(f"the log has more than {EXACT // 2} rows, which is the most that is accepted")
        listed = self.counts.sum(axis=0).tolist()
        object.__setattr__(self, "rows", sum(listed))
        object.__setattr__(self, "total", sum(n * value for n, value in zip(listed, self.values, strict=True)))


@dataclass(frozen=True)
class Node:
    """A conjunction and how many rows it has with each utility."""

    conditions: Conjunction
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Found:
    """A conjunction, or several that have the same rows.

    Attributes
    ----------
    conditions : tuple of (int, int)
        The shortest.
    rows, total : int
        How many rows it has, and the sum of their utilities.
    ratio : Fraction or inf
        Its mean beside that of the rest, the greater over the less.
    side : {"more", "less", "equal"}
        Whether it gets more than the rest.
    same : tuple of conjunctions
        All others of the family that have the same rows.
    """

    conditions: Conjunction
    rows: int
    total: int
    ratio: Extended
    side: Side
    same: tuple[Conjunction, ...] = ()


@dataclass(frozen=True)
class Worst:
    """The most unequal conjunctions.

    Attributes
    ----------
    found : tuple of Found
        The most unequal ones, falling.
    limit : Fraction or inf
        No conjunction beside them is more unequal: the ratio of the last one, or 1 where all that there are were asked for.
    frontier : tuple of Node
        The conjunctions whose refinements were left out, since none is as unequal as that.
    """

    found: tuple[Found, ...]
    limit: Extended
    frontier: tuple[Node, ...]


def conjunctions(sizes: Sequence[int], depth: int) -> int:
    """How many conjunctions of 1 to `depth` conditions there are, whether rows have them or not.

    Examples
    --------
    >>> conjunctions([5] * 10, 3), conjunctions([5] * 10, 4)
    (16175, 147425)
    """
    depth = min(depth, len(sizes))
    ways = [1] + [0] * depth
    for size in sizes:
        for k in range(depth, 0, -1):
            ways[k] += ways[k - 1] * size
    return sum(ways[1:])


def most_unequal(
    rows: Rows, depth: int, least_rows: int, keep: int = 10, report: Callable[[float | None, int | None], None] | None = None
) -> Worst:
    """Find the conjunctions of 1 to `depth` conditions, with enough rows and not all of them, whose mean is furthest from that of the rest.

    Source: T18. Floats choose what is looked at; whatever is nearer to a limit than rounding reaches is looked at, and all that is
    returned is decided in integers.

    Parameters
    ----------
    rows : Rows
        The rows.
    depth : int
        How many conditions a conjunction has at most.
    least_rows : int
        How many rows it has at least.
    keep : int
        How many to find; those with the same rows count once.
    report : callable, optional
        Is told the share of attribute sets that were counted.

    Examples
    --------
    >>> sex, region = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    >>> rows = Rows((sex, region), (2, 2), np.array([[8, 2], [4, 6], [3, 7], [7, 3]]), (0, 1))
    >>> worst = most_unequal(rows, 2, 10, keep=2)
    >>> [(found.conditions, found.ratio) for found in worst.found]
    [(((0, 0), (1, 0)), Fraction(8, 3)), (((0, 1), (1, 0)), Fraction(21, 11))]
    """
    search = _Search(rows, min(depth, len(rows.sizes)), least_rows, keep, report)
    search.run()
    found = _findings(rows, search.candidates(), keep)
    limit: Extended = found[keep - 1].ratio if len(found) >= keep else Fraction(1)
    return Worst(tuple(found), limit, tuple(_frontier(rows, search.inner, least_rows, limit)))


def every_conjunction(rows: Rows, depth: int, least_rows: int, most: int = 1_000_000) -> list[tuple[Conjunction, int, int]] | None:
    """All conjunctions with enough rows and not all of them, the most unequal first: conditions, rows, and the sum of their utilities.

    None if there are more than `most`.

    Examples
    --------
    >>> rows = Rows((np.array([0, 1]),), (2,), np.array([[1, 3], [2, 2]]), (0, 1))
    >>> every_conjunction(rows, 1, 1)
    [(((0, 0),), 4, 3), (((0, 1),), 4, 2)]
    """
    search = _Search(rows, min(depth, len(rows.sizes)), least_rows, most + 1, None)
    search.run(most)
    if search.found > most:
        return None
    return [(name, n, total) for _, _, n, total, name in search.candidates()]


class _Search:
    """Counts by set of attributes, each set after the one without its last attribute."""

    def __init__(self, rows: Rows, depth: int, least_rows: int, keep: int, report: Callable[..., None] | None) -> None:
        self.rows, self.depth, self.least, self.keep, self.report = rows, depth, least_rows, keep, report
        self.exact = rows.total < EXACT
        self.own = rows.counts.sum(axis=1).astype(np.float64)
        self.entry, self.value = np.nonzero(rows.counts)
        self.times = rows.counts[self.entry, self.value].astype(np.float64)
        if self.exact:
            gains = self.times * np.array(rows.values, dtype=np.float64)[self.value]
            self.sums = np.bincount(self.entry, weights=gains, minlength=len(rows.counts))
        self.inner: dict[Conjunction, tuple[int, ...]] = {}
        self.seen: list[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[Any], list[Conjunction]]] = []
        self.waiting = 0
        self.found, self.most = 0, inf
        self.limit = 1.0
        self.done, self.sets = 0, sum(1 for k in range(1, depth + 1) for _ in combinations(range(len(rows.sizes)), k))

    def run(self, most: float = inf) -> None:
        """Count all that may matter; give up where more conjunctions have enough rows than `most`."""
        self.most = most
        cells = np.arange(len(self.own))
        self._refine(cells, np.zeros(len(cells), dtype=np.int64), [()], -1)

    def _refine(self, cells: NDArray[np.int64], node: NDArray[np.int64], nodes: list[Conjunction], last: int) -> None:
        """Refine conjunctions on one set of attributes by each later attribute; `node` says to which of them each of some cells belongs."""
        whole = len(cells) == len(self.own)
        for attribute in range(last + 1, len(self.rows.sizes)):
            if self.found > self.most:
                return
            self.done += 1
            if self.report is not None:
                self.report(self.done / self.sets, None)
            size = self.rows.sizes[attribute]
            codes = self.rows.codes[attribute]
            keys = node * size + (codes if whole else codes[cells])
            if len(nodes) * size > 4 * len(cells) + 1000:
                values, keys = distinct(keys)
            else:
                values = np.arange(len(nodes) * size)
            n: NDArray[Any] = np.bincount(keys, weights=self.own if whole else self.own[cells], minlength=len(values))
            enough = np.flatnonzero(n >= self.least)
            if not len(enough):
                continue
            made = [(*nodes[v // size], (attribute, v % size)) for v in values[enough].tolist()]
            deeper = len(made[0]) < self.depth and attribute + 1 < len(self.rows.sizes)
            counts = self._counts(keys, cells, len(values), enough) if deeper or not self.exact else None
            total: NDArray[Any]
            if counts is None:
                total = np.bincount(keys, weights=self.sums if whole else self.sums[cells], minlength=len(values))[enough]
            else:
                total = counts.astype(object) @ np.array(self.rows.values, dtype=object)
            self._note(n[enough], total, made)
            if deeper and counts is not None:
                self._descend(cells, keys, len(values), enough, made, counts, attribute)

    def _counts(self, keys: NDArray[np.int64], cells: NDArray[np.int64], width: int, enough: NDArray[np.int64]) -> NDArray[np.int64]:
        """How many rows of each conjunction have each utility."""
        place = np.full(width, -1, dtype=np.int64)
        place[enough] = np.arange(len(enough))
        of_entry = np.full(len(self.own), -1, dtype=np.int64)
        of_entry[cells] = place[keys]
        at = of_entry[self.entry]
        kept, values = at >= 0, len(self.rows.values)
        found = np.bincount(at[kept] * values + self.value[kept], weights=self.times[kept], minlength=len(enough) * values)
        return found.reshape(len(enough), values).astype(np.int64)

    def _descend(
        self,
        cells: NDArray[np.int64],
        keys: NDArray[np.int64],
        width: int,
        enough: NDArray[np.int64],
        made: list[Conjunction],
        counts: NDArray[np.int64],
        attribute: int,
    ) -> None:
        """Refine those conjunctions whose refinements may be as unequal as what was found."""
        self.inner.update(zip(made, map(tuple, counts.tolist()), strict=True))
        open_ = ~self._hopeless(counts)
        if not open_.any():
            return
        place = np.full(width, -1, dtype=np.int64)
        place[enough[open_]] = np.arange(int(open_.sum()))
        own = place[keys]
        kept = own >= 0
        still = [conjunction for conjunction, there in zip(made, open_.tolist(), strict=True) if there]
        if kept.all():
            self._refine(cells, own, still, attribute)
        else:
            self._refine(cells[kept], own[kept], still, attribute)

    def _note(self, n: NDArray[np.float64], total: NDArray[Any], made: list[Conjunction]) -> None:
        """Keep what is as unequal as the last of those that were asked for, and raise that limit."""
        self.found += int((n < self.rows.rows).sum())
        ratio = self._ratios(n, total) if self.exact else self._long_ratios(n, total)
        chosen = np.flatnonzero((n < self.rows.rows) & (ratio >= self.limit * (1 - SLACK)))
        if not len(chosen):
            return
        self.seen.append((ratio[chosen], n[chosen], total[chosen], [made[i] for i in chosen.tolist()]))
        self.waiting += len(chosen)
        if self.waiting > 4 * self.keep:
            self._raise_limit()

    def _raise_limit(self) -> None:
        """Find the ratio that conjunctions with surely different rows reach, as many as were asked for."""
        ratio, n, total = (np.concatenate([part[i] for part in self.seen]) for i in range(3))
        names = [name for part in self.seen for name in part[3]]
        order = np.argsort(-ratio, kind="stable")
        signatures: set[tuple[float, float]] = set()
        for i in order.tolist():
            signatures.add((n[i], total[i]))
            if len(signatures) == self.keep:
                self.limit = max(1.0, float(ratio[i]))
                break
        chosen = np.flatnonzero(ratio >= self.limit * (1 - SLACK))
        self.seen = [(ratio[chosen], n[chosen], total[chosen], [names[i] for i in chosen.tolist()])]
        self.waiting = -len(chosen)

    def _long_ratios(self, n: NDArray[np.float64], total: NDArray[Any]) -> NDArray[np.float64]:
        exact = (subgroup_ratio(int(a), b, self.rows.rows, self.rows.total)[0] for a, b in zip(n.tolist(), total.tolist(), strict=True))
        return np.array([inf if ratio == inf else float(min(ratio, 10**300)) for ratio in exact])

    def _ratios(self, n: NDArray[np.float64], total: NDArray[Any]) -> NDArray[np.float64]:
        total = total.astype(np.float64)
        own = total * np.maximum(self.rows.rows - n, 0)
        rest = np.maximum(float(self.rows.total) - total, 0) * n
        low, high = np.minimum(own, rest), np.maximum(own, rest)
        return np.where(high == low, 1.0, np.divide(high, low, out=np.full(len(n), inf), where=low > 0))

    def _hopeless(self, counts: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Of which conjunctions no refinement is as unequal as the limit, by more than rounding reaches."""
        n = counts.sum(axis=1)
        hopeless = np.ones(len(n), dtype=np.bool_)
        if not self.exact or self.limit == 1:
            return ~hopeless
        most = np.minimum(n, self.rows.rows - 1)
        values = np.array(self.rows.values, dtype=np.float64)
        for order in (slice(None), slice(None, None, -1)):
            parts, worth = counts[:, order], values[order]
            ends = np.cumsum(parts, axis=1)
            for at in range(-1, len(worth)):
                j = np.full(len(n), self.least) if at < 0 else ends[:, at]
                j = np.clip(j, self.least, most)
                taken = np.clip(j[:, None] - (ends - parts), 0, parts)
                hopeless &= self._ratios(j.astype(np.float64), taken @ worth) < self.limit * (1 - SLACK)
        return hopeless

    def candidates(self) -> list[tuple[Extended, Side, int, int, Conjunction]]:
        """What was kept, with exact ratios, the most unequal first, of those the shortest first."""
        known: dict[tuple[int, int], tuple[Extended, Side]] = {}
        listed = []
        for _, n, total, names in self.seen:
            for rows, gains, name in zip(n.tolist(), total.tolist(), names, strict=True):
                key = int(rows), int(gains)
                if key not in known:
                    known[key] = subgroup_ratio(*key, self.rows.rows, self.rows.total)
                listed.append((*known[key], *key, name))
        rank = {ratio: i for i, ratio in enumerate(sorted({ratio for ratio, *_ in listed}, reverse=True))}
        return sorted(listed, key=lambda entry: (rank[entry[0]], len(entry[4]), entry[4]))


def _findings(rows: Rows, candidates: Sequence[tuple[Extended, Side, int, int, Conjunction]], keep: int) -> list[Found]:
    """The first candidates with different rows, each with the others that have the same rows."""
    found: list[tuple[Found, list[Conjunction], NDArray[np.int64]]] = []
    alike: dict[tuple[int, int], list[int]] = {}
    for ratio, side, n, total, name in candidates:
        if len(found) >= keep and ratio != found[-1][0].ratio and (n, total) not in alike:
            continue
        same = next((i for i in alike.get((n, total), ()) if all((rows.codes[a][found[i][2]] == v).all() for a, v in name)), None)
        if same is not None:
            found[same][1].append(name)
        elif len(found) < keep:
            alike.setdefault((n, total), []).append(len(found))
            found.append((Found(name, n, total, ratio, side), [], _cells(rows, name)))
    return [Found(f.conditions, f.rows, f.total, f.ratio, f.side, tuple(same)) for f, same, _ in found]


def _cells(rows: Rows, conditions: Conjunction) -> NDArray[np.int64]:
    """The entries that have a conjunction."""
    cells = np.arange(len(rows.counts))
    for attribute, value in conditions:
        cells = cells[rows.codes[attribute][cells] == value]
    return cells


def _frontier(rows: Rows, inner: dict[Conjunction, tuple[int, ...]], least_rows: int, limit: Extended) -> Iterator[Node]:
    """The conjunctions, none a refinement of another in the order of attributes, whose refinements stay below the limit; in order."""
    closed: set[Conjunction] = set()
    if limit == 1:
        return
    for name in sorted(inner, key=lambda conditions: (len(conditions), conditions)):
        if any(name[:k] in closed for k in range(1, len(name))):
            continue
        if refinements_below(inner[name], rows.values, rows.rows, rows.total, least_rows, limit):
            closed.add(name)
            yield Node(name, inner[name])


def entries(codes: Sequence[NDArray[np.int64]], sizes: Sequence[int], rows: int) -> NDArray[np.int64]:
    """To which combination of attribute values each row belongs, in the order of the combinations."""
    key, span = np.zeros(rows, dtype=np.int64), 1
    for code, size in zip(codes, sizes, strict=True):
        if span * size >= 1 << 62:
            key, span = distinct(key)[1], rows
        key, span = key * size + code, span * size
    return distinct(key)[1]
