"""Likelihood ratios of all ordered pairs of rows of a filter, exactly and in floats, all of them and a few that stand for them.

S of T13 is a sum of convex functions of the likelihood ratio: moving the mass of a ratio to two others around it, its mean kept, can only
make S greater. So a few ratios are enough to rule most pairs of groups out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.columns import Column
from fairaudit.privacy.pairs import PairKinds, kinds_of_pairs, kinds_of_row
from fairaudit.theorems.t13_tables import Ints

LEVELS = 2, 8
"""How many likelihood ratios stand for all of a pair, before all of them are looked at."""


@dataclass(frozen=True)
class RatioLaw:
    """Masses P and Q of likelihood ratios, shape (kinds of pairs, ratios), and how far sums over them may be off, relatively.

    The ratios of a kind come first; what follows up to the greatest number of ratios is 0.
    """

    p: Floats
    q: Floats
    sizes: Ints
    error: Floats


@dataclass(frozen=True, eq=False)
class FilterLaws:
    """The kinds of ordered pairs of rows of a filter, over one release or several.

    Attributes
    ----------
    mechanism : Mechanism
        The filter.
    columns : list of tuple of (int, int)
        The likelihood ratios of each kind, falling.
    different : int
        How many kinds have pairs of different inputs.
    levels : list of RatioLaw
        The same in floats: a few ratios of each, more, and all.
    """

    mechanism: Mechanism
    columns: list[tuple[Column, ...]]
    different: int
    levels: list[RatioLaw]
    _kinds: PairKinds

    def of_row(self, row: int) -> Ints:
        """The kind of the pair of one input with every input."""
        return np.array(kinds_of_row(self.mechanism, self._kinds, row), dtype=np.int64)


@lru_cache(maxsize=1)
def filter_laws(mechanism: Mechanism, releases: int) -> FilterLaws:
    """The kinds of pairs of a filter; kept for the next question about the same filter.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> filter_laws(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"), 1).columns
    [((1, 1),), ((2, 1), (1, 1), (1, 2))]
    """
    kinds = kinds_of_pairs(mechanism, releases)
    columns = list(kinds.examples)
    different = sum(first != second for first, second in kinds.examples.values())
    whole = _law(columns)
    levels = [*(_joined(whole, level) for level in LEVELS if level < whole.p.shape[1]), whole]
    return FilterLaws(mechanism, columns, different, levels, kinds)


def _law(columns: Sequence[tuple[Column, ...]]) -> RatioLaw:
    """All likelihood ratios of all kinds, each mass off by at most a unit."""
    p, q = np.zeros((2, len(columns), max(map(len, columns))))
    for i, kind in enumerate(columns):
        bottom = sum(top for top, _ in kind)
        p[i, : len(kind)] = [top / bottom for top, _ in kind]
        q[i, : len(kind)] = [low / bottom for _, low in kind]
    return RatioLaw(p, q, np.array([len(kind) for kind in columns]), np.full(len(columns), 2 * UNIT))


def _joined(law: RatioLaw, count: int) -> RatioLaw:
    """Move the masses of every kind to `count` of its ratios, both ends among them, so that sums can only become greater.

    A ratio between two that stay is a combination of them with weights of at least 0; what rounding leaves over is part of the error.
    """
    places, sizes = np.arange(count), law.sizes[:, None]
    ends = np.where(sizes > count, np.rint(places * (sizes - 1) / (count - 1)), places).astype(np.int64)
    p, q = np.take_along_axis(law.p, ends, 1), np.take_along_axis(law.q, ends, 1)
    at = np.arange(law.p.shape[1])
    left = np.clip((ends[:, None, :] <= at[None, :, None]).sum(axis=2) - 1, 0, count - 2)
    p1, p2, q1, q2 = (np.take_along_axis(v, side, 1) for v in (p, q) for side in (left, left + 1))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        across = p1 * q2 - p2 * q1
        one, two = (law.p * q2 - p2 * law.q) / across, (p1 * law.q - law.p * q1) / across
    one, two = (np.clip(np.nan_to_num(v, nan=0.0, posinf=0.0, neginf=0.0), 0.0, None) for v in (one, two))
    here, next_ = np.take_along_axis(ends, left, 1) == at, np.take_along_axis(ends, left + 1, 1) == at
    one, two = np.where(here, 1.0, np.where(next_, 0.0, one)), np.where(here, 0.0, np.where(next_, 1.0, two))
    weights = np.zeros(p.shape)
    rows = np.broadcast_to(np.arange(len(p))[:, None], left.shape)
    np.add.at(weights, (rows, left), one)
    np.add.at(weights, (rows, left + 1), two)
    error = law.error + (law.p.shape[1] + 8) * UNIT * (weights * np.maximum(p, q)).sum(axis=1)
    over = [np.abs(v - (one * v1 + two * v2)) + 4 * UNIT * (v + one * v1 + two * v2) for v, v1, v2 in ((law.p, p1, p2), (law.q, q1, q2))]
    error += np.maximum(*(part.sum(axis=1) for part in over))
    return RatioLaw(p * weights, q * weights, np.minimum(law.sizes, count), error)
