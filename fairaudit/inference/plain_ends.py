"""Plain ends: those that follow from draws and a level in closed form, so that evidence need not list them.

They are defined in docs/certificate-samples.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, lru_cache
from math import inf, isqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import log_fixed
from fairaudit.exact.rationals import rational
from fairaudit.inference.cells import Cell, Ends, informative, shares
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.quotients import extreme_ratio, vanishing_pair

BITS = 32
UNIT = 1 << BITS
SLACK = 2.0 ** (1 - BITS)  # more than rounding to a multiple of 1/UNIT, and what float64 loses beside it


@lru_cache(maxsize=64)
def _reach(level: Fraction) -> int:
    """The least integer that is at least UNIT·log(1/level)."""
    extra = 64
    while True:
        low, high = (-(-end >> extra) for end in log_fixed(level.denominator, level.numerator, BITS + extra))
        if low == high:
            return high
        extra *= 2


def _root(square: int, divisor: int) -> int:
    """The least integer whose square is at least a quotient."""
    quotient = -(-square // divisor)
    return isqrt(quotient - 1) + 1 if quotient else 0


@lru_cache(maxsize=100_000)
def plain_lower(draws: int, part: int, whole: int, reach: int) -> int:
    """The plain lower end of draws with the mean part/whole on the scale where the range is [0, 1], in units of 1/UNIT.

    Examples
    --------
    >>> round(plain_lower(100, 50, 100, _reach(Fraction(1, 40))) / UNIT, 7)  # 1/2 - sqrt(log(40)/200), which is Hoeffding's bound
    0.3641898
    """
    far = UNIT - _by_squares(draws, whole - part, whole, reach)
    few = draws * part * UNIT
    halvings = -(-13 * (few + reach * whole) // (9 * few)) if part else UNIT
    return far if halvings > BITS else max(far, part * UNIT // (whole << halvings))


def _by_squares(draws: int, part: int, whole: int, reach: int) -> int:
    """The least p > z = part/whole with n(p − z)² ≥ 2vλ, v being the greatest t(1 − t) between z and p, in units of 1/UNIT; else 1."""
    if 2 * part < whole and draws * (whole - 2 * part) ** 2 * UNIT >= 2 * reach * whole * whole:  # p is no more than 1/2: v = p(1 − p)
        a, b = draws * UNIT, 2 * reach
        root = _root(b * UNIT * UNIT * (4 * a * part * (whole - part) + b * whole * whole), 1)
        return -(-(UNIT * (2 * a * part + b * whole) + root) // (2 * whole * (a + b)))
    root = _root(reach * UNIT * (whole * whole if 2 * part < whole else 4 * part * (whole - part)), 2 * draws)
    return min(UNIT, -(-(part * UNIT + root) // whole))


def _parts(cell: Cell) -> tuple[int, int]:
    """The mean of the draws on the scale where the range is [0, 1], as a quotient."""
    (low, under), (high, over), (total, bottom) = (value.as_integer_ratio() for value in (cell.low, cell.high, cell.total))
    return (total * under - cell.draws * low * bottom) * over, cell.draws * bottom * (high * under - low * over)


class PlainEnds(Sequence[Ends]):
    """Ends of all cells of a comparison: those that are listed, and the plain ones of the others, each found where it is asked for.

    Parameters
    ----------
    comparison : Comparison
        The cells.
    level : Fraction
        The level of the ends, 0 if there are none.
    listed : mapping of int to pair of Fraction
        The ends of some cells.
    """

    def __init__(self, comparison: Comparison, level: Fraction, listed: Mapping[int, Ends]) -> None:
        self.comparison, self.listed = comparison, listed
        self.reach = _reach(level) if level else 0
        self._known: dict[tuple[int, int, int], Fraction] = {}

    def __len__(self) -> int:
        """How many cells there are."""
        return len(self.comparison.cells)

    def __getitem__(self, i: Any) -> Any:
        """The ends of a cell."""
        found = self.listed.get(i)
        if found is not None:
            return found
        valued = self.comparison.valued
        return self._end(valued[0][i], 0), self._end(valued[-1][i], 1)

    def _end(self, cell: Cell, side: int) -> Fraction:
        if not cell.informative or not self.reach:
            return (cell.low, cell.high)[side]
        part, whole = _parts(cell)
        j = UNIT - plain_lower(cell.draws, whole - part, whole, self.reach) if side else plain_lower(cell.draws, part, whole, self.reach)
        key = id(cell.low), id(cell.high), j
        found = self._known.get(key)
        if found is None:  # most cells share their range
            share = Fraction(j, UNIT)
            found = self._known[key] = share if not cell.low and cell.high == 1 else cell.low + (cell.high - cell.low) * share
        return found

    @cached_property
    def floats(self) -> tuple[Floats, Floats]:
        """Numbers below the lower ends of all cells, and above the upper ones; those of what is listed, too, but for rounding."""
        sides = [_side(self._rounded[0], self.reach, upper=False), _side(self._rounded[-1], self.reach, upper=True)]
        low, high = sides
        for i, (below, above) in self.listed.items():
            low[i], high[i] = float(below) * (1 - 1e-12), float(above) * (1 + 1e-12)
        return low, high

    @property
    def _rounded(self) -> list[_Rounded]:
        """What all ends of a comparison follow from, found once for each comparison."""
        kept = self.comparison.__dict__
        if "rounded" not in kept:
            kept["rounded"] = [_in_floats(cells) for cells in self.comparison.valued]
        return kept["rounded"]  # type: ignore[no-any-return]

    def at(self, level: Fraction) -> PlainEnds:
        """The same at another level, of which nothing is listed."""
        return PlainEnds(self.comparison, level, {})


class _Rounded(NamedTuple):
    """The ranges of cells, and the draws and means of those that are informative, in floats."""

    least: Floats
    most: Floats
    drawn: NDArray[np.int64]
    draws: Floats
    shares: Floats


def _in_floats(cells: Sequence[Cell]) -> _Rounded:
    shared = {id(end): float(end) for end in {id(end): end for cell in cells for end in (cell.low, cell.high)}.values()}
    least, most = (np.array([shared[id(end)] for end in ends]) for ends in ([c.low for c in cells], [c.high for c in cells]))
    drawn = np.flatnonzero(informative(cells))
    own = [cells[i] for i in drawn.tolist()]
    return _Rounded(least, most, drawn, np.array([cell.draws for cell in own], dtype=np.float64), shares(own))


def _side(cells: _Rounded, reach: int, *, upper: bool) -> Floats:
    found: Floats = (cells.most if upper else cells.least).copy()
    if reach and len(cells.drawn):
        own = float_plain(1 - cells.shares if upper else cells.shares, cells.draws, reach / UNIT) - SLACK
        end = np.minimum(1, 1 - own) if upper else np.maximum(0, own)
        found[cells.drawn] = cells.least[cells.drawn] + (cells.most - cells.least)[cells.drawn] * end
    return np.asarray(found * (1 + 1e-12 if upper else 1 - 1e-12))


def float_plain(z: Floats, draws: Floats, reach: float) -> Floats:
    """The lower ends of `plain_lower` in floats, by the means; of few successes a number no greater."""
    cost, rest = reach / draws, 1 - z
    early = (1 - 2 * rest) ** 2 >= 2 * cost
    late = rest + np.sqrt(np.where(rest < 0.5, cost / 2, 2 * cost * z * rest))
    far = 1 - np.where((rest < 0.5) & early, (rest + cost + np.sqrt(cost * cost + 2 * cost * z * rest)) / (1 + 2 * cost), late)
    with np.errstate(divide="ignore", over="ignore"):
        few = z * 2.0 ** -np.floor(1 + 13 / 9 * (1 + 1e-12) * (1 + reach / np.maximum(1e-300, draws * z)))
    return np.asarray(np.maximum(0, np.maximum(far, few)))


def ends_of_evidence(comparison: Comparison, evidence: Mapping[str, Any], side: str) -> Sequence[Ends]:
    """The ends of all cells on which the upper or the lower end of a box rests, by what evidence lists of them."""
    given, known = evidence[side], dict[str, Fraction]()

    def read(text: str) -> Fraction:
        found = known.get(text)
        if found is None:
            found = known[text] = Fraction(*rational(text))
        return found

    if not isinstance(given, Mapping):
        return [(read(low), read(high)) for low, high in given]
    listed = {i: (read(low), read(high)) for i, (low, high) in zip(given["cells"], given["ends"], strict=True)}
    level = read(evidence["levels"]["upper"]) if side == "upper" else Fraction(0)
    return PlainEnds(comparison, level, listed)


def by_promise(comparison: Comparison, ends: PlainEnds) -> list[tuple[float, int]]:
    """Numbers above the greatest quotient of the cells of each block, falling, with the number of the block: of blocks of single cells."""
    blocks = [[form[0][0] for form in block] for block in comparison.blocks]
    low, high = (side[[i for block in blocks for i in block]] for side in ends.floats)
    starts = np.cumsum([0, *map(len, blocks)])[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        top, bottom = np.maximum.reduceat(high, starts), np.minimum.reduceat(low, starts)
        found = np.where(bottom > 0, top / bottom, np.where(top > 0, np.inf, 0.0))
    order = np.argsort(-found, kind="stable")
    return [*zip(found[order].tolist(), order.tolist(), strict=True)]


def foremost(comparison: Comparison, ends: PlainEnds, most: int) -> list[int]:
    """The numbers of so many blocks in which plain ends are furthest apart, or of all if there are no more."""
    if len(comparison.blocks) <= most:
        return [*range(len(comparison.blocks))]
    blocks = [[form[0][0] for form in block] for block in comparison.blocks]
    low, high = (side[[i for block in blocks for i in block]] for side in ends.floats)
    starts = np.cumsum([0, *map(len, blocks)])[:-1]
    apart = np.maximum.reduceat(low, starts) / np.maximum(1e-300, np.minimum.reduceat(high, starts))
    return sorted(np.argsort(-apart, kind="stable")[:most].tolist())


def greatest_of(comparison: Comparison, ends: Sequence[Ends]) -> tuple[Any, tuple[int, int, int] | None]:
    """Where a quotient is greatest over a box, as `extreme_ratio` finds it, of many cells only in the blocks that may have it."""
    if not isinstance(ends, PlainEnds):
        return extreme_ratio(comparison, ends, upper=True)
    best: Any = Fraction(1)
    where: tuple[int, int, int] | None = None
    for value, place in by_promise(comparison, ends):
        if value * (1 + 1e-9) < best:
            break
        found, pair = extreme_ratio(replace(comparison, blocks=(comparison.blocks[place],)), ends, upper=True)
        if pair and (where is None or found > best or (found == best and place < where[0])):
            best, where = found, (place, *pair[1:])
        if best == inf:
            break
    return best, where


def vanishing_of(comparison: Comparison, ends: Sequence[Ends]) -> tuple[int, int, int] | None:
    """What `vanishing_pair` finds, of many cells only in the blocks where a lower end may be 0."""
    if not isinstance(ends, PlainEnds):
        return vanishing_pair(comparison, ends)
    places = sorted(place for value, place in by_promise(comparison, ends) if value == inf)
    found = vanishing_pair(replace(comparison, blocks=tuple(comparison.blocks[place] for place in places)), ends)
    return None if found is None else (places[found[0]], *found[1:])
