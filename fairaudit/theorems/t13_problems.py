"""Which ordered pairs of groups T13 has to look at: one of each kind, by likelihood ratios and utility tables, the first in input order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fairaudit.errors import InputError
from fairaudit.model.mechanism import Mechanism
from fairaudit.tables.values import INT64
from fairaudit.theorems.t13_laws import FilterLaws, filter_laws
from fairaudit.theorems.t13_tables import Ints, Tables

MAX_PROBLEMS = 10_000_000
"""Pairs that are held in memory."""


class TooManyPairs(InputError):  # noqa: N818
    """More pairs of groups differ than are held in memory."""


@dataclass(frozen=True)
class Problems:
    """Ordered pairs of groups of different kinds, in input order: by context, group in the numerator, group in the denominator.

    Attributes
    ----------
    laws : FilterLaws
        The likelihood ratios of each kind of pair of rows of the filter.
    kind : ndarray of int64
        The kind of pair of rows.
    higher, lower : ndarray of int64
        The utility tables of the two groups.
    rank : ndarray of int64
        Position in input order, rising.
    groups : int
        Number of true groups.
    """

    laws: FilterLaws
    kind: Ints
    higher: Ints
    lower: Ints
    rank: Ints
    groups: int

    def __len__(self) -> int:
        """Number of pairs."""
        return len(self.rank)

    def place(self, at: int) -> tuple[int, int, int]:
        """Context, group in the numerator and group in the denominator, by position."""
        rest, lower = divmod(int(self.rank[at]), self.groups)
        context, higher = divmod(rest, self.groups)
        return context, higher, lower


def different_pairs(mechanism: Mechanism, releases: int, tables: Tables) -> Problems:
    """List one ordered pair of groups for each kind of pair of rows and each two utility tables that occur together.

    Raises
    ------
    InputError
        If there are too many.
    """
    laws = filter_laws(mechanism, releases)
    groups, count = tables.of.shape[1], len(tables.bottoms)
    found = _Found(repeats=count < tables.of.size)
    for a in range(groups):
        of_pair = laws.of_row(a)
        compared = (tables.of[:, a : a + 1] >= 0) & (tables.of >= 0)
        compared[:, a] = False
        context, b = np.nonzero(compared)
        key = (of_pair[b] * count + tables.of[context, a]) * count + tables.of[context, b]
        found.add(key, (np.array(tables.contexts)[context] * groups + a) * groups + b, at_once=count == 1)
        if count == 1 and len(found.keys) == laws.different:
            break
    found.merge()
    order = np.argsort(found.ranks)
    keys, ranks = found.keys[order], found.ranks[order]
    return Problems(laws, keys // (count * count), keys // count % count, keys % count, ranks, groups)


class _Found:
    """Keys of pairs that were found, each with the least rank at which it was."""

    def __init__(self, *, repeats: bool) -> None:
        self.keys, self.ranks = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        self._repeats, self._waiting, self._count = repeats, list[tuple[Ints, Ints]](), 0

    def add(self, keys: Ints, ranks: Ints, *, at_once: bool) -> None:
        """Take note of keys, at once or when many have come together."""
        self._waiting.append((keys, ranks))
        self._count += len(keys)
        if at_once or self._count > MAX_PROBLEMS // 2:
            self.merge()

    def merge(self) -> None:
        """Keep each key once, with its least rank; refuse too many."""
        waiting = [(self.keys, self.ranks), *self._waiting]
        keys, ranks = (np.concatenate(parts) for parts in zip(*waiting, strict=True))
        self._waiting, self._count = [], 0
        if self._repeats and len(keys):
            span = int(ranks.max()) + 1
            if int(keys.max()) < INT64 // span:  # sorting single numbers is twenty times as fast
                keys, ranks = np.divmod(np.sort(keys * span + ranks), span)
            else:
                order = np.lexsort((ranks, keys))
                keys, ranks = keys[order], ranks[order]
            first = np.concatenate(([True], keys[1:] != keys[:-1]))
            keys, ranks = keys[first], ranks[first]
        if len(keys) > MAX_PROBLEMS:
            raise TooManyPairs(
                f"more than {MAX_PROBLEMS} pairs of groups differ in utility or filter, too many for the greatest ratio over all policies; "
                "fewer groups or contexts, or a utility that ignores the group, are accepted"
            )
        self.keys, self.ranks = keys, ranks
