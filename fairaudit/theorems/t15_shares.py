"""T15, second part: shares within intervals, searched for in floats and whole in the end, that make groups much alike or far apart.

Whatever is found here is one possible assignment; a search that fails costs a verdict, never truth.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from fairaudit.exact.linear_programs import ask_solver
from fairaudit.theorems.t15_cells import Cell, Cells, beyond

__all__ = ["equal_shares", "unequal_shares"]

FINER = 1_000
"""Parts of the least share that is told apart in the intervals."""

MOST_VARIABLES = 30_000
"""Of a linear program whose solver takes a second or two."""

ROUNDS = 6
"""How often two groups that are far apart are pulled farther."""


def equal_shares(cells: Cells) -> Iterator[Cells]:
    """Shares that let all groups have much the same mean."""
    fine = _finer(cells)
    yield _with(fine, (_repaired(cell, _proportional(cell)) for cell in fine.cells))
    if sum(len(cell.gains) for cell in cells.cells) * cells.groups <= MOST_VARIABLES:
        wishes = _of_equal_means(fine)
        if wishes is not None:
            yield _with(fine, (_repaired(cell, wish) for cell, wish in zip(fine.cells, wishes, strict=True)))


def unequal_shares(cells: Cells, a: int, b: int, above: Fraction, below: Fraction) -> Iterator[Cells]:
    """Shares that let one group have a great mean while another has a small one; alone, they have these means at best and at worst."""
    fine = _finer(cells)
    top, bottom, weight = above * cells.unit, below * cells.unit, Fraction(1)
    for _ in range(ROUNDS):
        slices = [_slices(cell, a, b, top, bottom, weight) for cell in fine.cells]
        yield _with(
            fine, (_repaired(cell, _proportional(cell), {a: up, b: down}) for cell, (up, down) in zip(fine.cells, slices, strict=True))
        )
        best = sum(cell.best(up) for cell, (up, _) in zip(fine.cells, slices, strict=True))
        worst = sum(cell.worst(down) for cell, (_, down) in zip(fine.cells, slices, strict=True))
        if not best or not worst:
            return
        found = Fraction(best, sum(up for up, _ in slices)), Fraction(worst, sum(down for _, down in slices))
        if found == (top, bottom):
            return
        (top, bottom), weight = found, Fraction(best, worst)


def _slices(cell: Cell, a: int, b: int, top: Fraction, bottom: Fraction, weight: Fraction) -> tuple[int, int]:
    """Rows for a group above and one below that gain most over what they have on average, as far as they leave room for each other."""
    (a_low, a_high), (b_low, b_high), (least, most) = (cell.within(union) for union in (1 << a, 1 << b, 1 << a | 1 << b))
    up = min(max(beyond(cell, top, up=True), a_low), a_high)
    down = min(max(beyond(cell, bottom, up=False), b_low), b_high)
    if least <= up + down <= most:
        return up, down
    both = least if up + down < least else most
    first, last = max(a_low, both - b_high), min(a_high, both - b_low)
    ends = {first, last}
    before = 0
    for _, count in cell.gains:
        before += count
        ends |= {min(max(turn, first), last) for turn in (cell.rows - before, both - before)}
    gained = {rows: cell.best(rows) - top * rows + weight * (bottom * (both - rows) - cell.worst(both - rows)) for rows in ends}
    up = max(sorted(ends), key=gained.__getitem__)
    return up, both - up


def _finer(cells: Cells) -> Cells:
    def times(counts: Sequence[int]) -> tuple[int, ...]:
        return tuple(FINER * count for count in counts)

    fine = (Cell(tuple((gain, FINER * count) for gain, count in cell.gains), times(cell.low), times(cell.high)) for cell in cells.cells)
    return replace(cells, cells=tuple(fine), scale=FINER * cells.scale)


def _with(cells: Cells, known: Iterable[Sequence[int]]) -> Cells:
    return replace(cells, cells=tuple(Cell(cell.gains, tuple(rows), tuple(rows)) for cell, rows in zip(cells.cells, known, strict=True)))


def _proportional(cell: Cell) -> list[int]:
    """Rows of each group that are as far from the least to the greatest for each."""
    room = sum(cell.high) - sum(cell.low)
    left = cell.rows - sum(cell.low)
    return [low + (left * (high - low) // room if room else 0) for low, high in zip(cell.low, cell.high, strict=True)]


def _repaired(cell: Cell, wish: Sequence[int], fixed: Mapping[int, int] | None = None) -> list[int]:
    """Rows of each group near a wish that are possible together; those of some groups are fixed."""
    fixed = fixed or {}
    found = [fixed[a] if a in fixed else min(max(rows, cell.low[a]), cell.high[a]) for a, rows in enumerate(wish)]
    for a, rows in enumerate(found):
        if a not in fixed:
            left = cell.rows - sum(found)
            found[a] = min(max(rows + left, cell.low[a]), cell.high[a])
    return found


def _of_equal_means(cells: Cells) -> list[list[int]] | None:
    """Ask a solver for rows whose groups are as near the mean of all as can be."""
    from scipy.sparse import csr_array

    mean = sum(cell.total for cell in cells.cells) / sum(cell.rows for cell in cells.cells)
    size = sum(cell.rows for cell in cells.cells)
    places = [(w, v, a) for w, cell in enumerate(cells.cells) for v in range(len(cell.gains)) for a in range(cells.groups)]
    groups, slack = cells.groups, len(places)
    rows: list[tuple[int, int, float]] = []
    bounds: list[float] = []
    for a in range(groups):
        for sign in (1.0, -1.0):
            own = ((j, sign * (cells.cells[w].gains[v][0] - mean) / size) for j, (w, v, b) in enumerate(places) if b == a)
            rows += [(len(bounds), j, value) for j, value in own] + [(len(bounds), slack, -1.0)]
            bounds.append(0.0)
    first = 0
    for cell in cells.cells:
        for a in range(groups):
            for sign, bound in ((1.0, cell.high[a]), (-1.0, -cell.low[a])):
                rows += [(len(bounds), first + v * groups + a, sign) for v in range(len(cell.gains))]
                bounds.append(float(bound))
        first += len(cell.gains) * groups
    equal = csr_array((np.ones(slack), (np.arange(slack) // groups, np.arange(slack))), shape=(slack // groups, slack + 1))
    counts = np.array([count for cell in cells.cells for _, count in cell.gains], dtype=np.float64)
    at = np.array([(i, j) for i, j, _ in rows])
    matrix = csr_array((np.array([value for *_, value in rows]), (at[:, 0], at[:, 1])), shape=(len(bounds), slack + 1))
    costs = np.append(np.zeros(slack), 1.0)
    limits = np.column_stack((np.zeros(slack + 1), np.full(slack + 1, np.inf)))
    found = ask_solver(costs, matrix, np.array(bounds), (equal, counts), limits)
    if found is None:
        return None
    wishes = [[0] * groups for _ in cells.cells]
    for (w, _, a), value in zip(places, found[0].tolist(), strict=False):
        wishes[w][a] += round(value)
    return wishes
