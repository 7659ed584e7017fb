"""Ends of the means of cells, each wrong with at most a stated probability, its level; proved in integers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from math import ceil, floor, log, sqrt
from typing import Literal

import numpy as np

from fairaudit.exact.enclosures import log_fixed
from fairaudit.inference.cells import Cell, Ends, informative, shares
from fairaudit.inference.comparisons import Comparison, Form
from fairaudit.inference.float_tails import closed_ends, float_end, float_upper_ends
from fairaudit.inference.levels import equal_share
from fairaudit.inference.rounding import BITS
from fairaudit.inference.tails import ONE, tail_bound

Method = Literal["hoeffding-kl", "empirical-bernstein", "intersection"]

DIGITS = 7  # of an end, rounded outwards: one part in a million wider, and short to read and to check

MOST_FORMS = 64  # cells of one mean, beyond which its ends would take seconds to find again

NEAR = 1e-9  # how much less a guess may be than the power of ten that it means


def _excluded(cell: Cell, mean: Fraction, side: Literal["lower", "upper"], level: Fraction) -> bool:
    return tail_bound(cell, mean, side) * level.denominator <= level.numerator << BITS


def _bernstein_excluded(cell: Cell, mean: Fraction, side: Literal["lower", "upper"], level: Fraction) -> bool:
    """Whether a mean lies beyond the empirical Bernstein bound of Maurer and Pontil (theorem 4), decided in integers."""
    n, width = cell.draws, cell.high - cell.low
    if n < 2 or cell.squares is None:
        return False
    distance = (mean - cell.mean if side == "lower" else cell.mean - mean) / width
    variance = max(Fraction(0), (cell.squares - cell.total**2 / n) / (n - 1) / width**2)
    _, high = log_fixed(2 * level.denominator, level.numerator, BITS)
    logarithm = Fraction(high, ONE)
    rest = distance - 7 * logarithm / (3 * (n - 1))
    return rest >= 0 and rest**2 >= 2 * variance * logarithm / n


def cell_ends(cell: Cell, level: Fraction, method: Method = "hoeffding-kl") -> Ends:
    """Bound the mean of a cell from below and above, each end wrong with probability at most `level`.

    Parameters
    ----------
    cell : Cell
        The draws.
    level : Fraction
        Probability of error of one end, in (0, 1).
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For draws that are not binary; the intersection takes the better of the two, each at half the level. Binary draws have
        binomial ends (Clopper and Pearson up to 5,000 draws).

    Returns
    -------
    tuple of Fraction
        Lower and upper end, rounded outwards to about seven digits and proved in integers; the range of the cell if it has no draws.

    Examples
    --------
    >>> cell_ends(Cell(10, Fraction(0), None, Fraction(0), Fraction(1), True), Fraction(1, 40))
    (Fraction(0, 1), Fraction(771243, 2500000))
    """
    if not cell.informative:
        return cell.low, cell.high
    width = cell.high - cell.low
    scaled = Cell(
        cell.draws,
        cell.successes,
        None if cell.binary or cell.squares is None else (cell.squares - 2 * cell.low * cell.total + cell.draws * cell.low**2) / width**2,
        Fraction(0),
        Fraction(1),
        cell.binary,
    )
    low, high = _unit_ends(scaled, level, "hoeffding-kl" if cell.binary else method)
    return cell.low + width * low, cell.low + width * high


@lru_cache(maxsize=200_000)
def _unit_ends(cell: Cell, level: Fraction, method: Method) -> Ends:
    if method == "intersection":
        half = equal_share(level, 2)
        (a, b), (c, d) = (_unit_ends(cell, half, each) for each in ("hoeffding-kl", "empirical-bernstein"))
        return max(a, c), min(b, d)
    return _search(cell, level, method, "upper"), _search(cell, level, method, "lower")


def _search(cell: Cell, level: Fraction, method: Method, side: Literal["lower", "upper"]) -> Fraction:
    """Find the outermost grid point that is proved to be excluded: the lower end is excluded by the upper tail, and vice versa."""
    outside = _bernstein_excluded if method == "empirical-bernstein" else _excluded
    guess = min(max(_guess(cell, float(level), method, side), 0.0), 1.0)
    scale = 10 ** (DIGITS - 1 + min(300, max(0, ceil(-log(guess) / log(10) - NEAR)) if guess > 0 else 0))
    at = floor(Fraction(guess) * scale) if side == "upper" else ceil(Fraction(guess) * scale)
    inward = 1 if side == "upper" else -1

    def proved(i: int) -> bool:
        return outside(cell, Fraction(i, scale), side, level)

    def beyond(i: int) -> bool:
        return i <= 0 if inward > 0 else i >= scale

    step = 1
    while not beyond(at) and not proved(at):
        at -= inward * step
        step *= 2
    if beyond(at):
        if step <= 2:
            return Fraction(0 if inward > 0 else 1)
        at = 0 if inward > 0 else scale
    while step >= 1:
        further = at + inward * step
        if 0 < further < scale and proved(further):
            at = further
        else:
            step //= 2
    return Fraction(at, scale)


def _guess(cell: Cell, level: float, method: Method, side: Literal["lower", "upper"]) -> float:
    n, k = cell.draws, float(cell.total)
    if method == "empirical-bernstein":
        if n < 2 or cell.squares is None:
            return 0.0 if side == "upper" else 1.0
        variance = max(0.0, float((cell.squares - cell.total**2 / n) / (n - 1)))
        radius = sqrt(2 * variance * log(2 / level) / n) + 7 * log(2 / level) / (3 * (n - 1))
        return k / n - radius if side == "upper" else k / n + radius
    return float_end(n, k, level, cell.binary, side)


def ends_of_cells(comparison: Comparison, level: Fraction, method: Method) -> list[Ends]:
    """Ends of all cells: of those that are informative and compared at this level, of the others the range."""
    used = set(comparison.used) if level else set()
    return [ends_of(comparison, i, level, method) if i in used else comparison.range_of(i) for i in range(len(comparison.cells))]


def ends_of(comparison: Comparison, cell: int, level: Fraction, method: Method) -> Ends:
    """Ends of the mean of one cell; with decisions of unknown meaning the lower end of the least, the upper one of the most it may be."""
    least, most = comparison.valued[0][cell], comparison.valued[-1][cell]
    low, high = cell_ends(least, level, method)
    return (low, high) if most is least else (low, cell_ends(most, level, method)[1])


def form_ends(comparison: Comparison, form: Form, confidence: Fraction, method: Method) -> Ends | None:
    """Between which ends a mean lies in the population, by itself at a confidence; None where it is of too many cells."""
    if len(form) > MOST_FORMS:
        return None
    level = (1 - confidence) / 2 / max(1, sum(any(cells[i].informative for cells in comparison.valued) for i, _ in form))
    found = [(ends_of(comparison, i, level, method), w) for i, w in form]
    return sum((w * lo for (lo, _), w in found), Fraction(0)), sum((w * hi for (_, hi), w in found), Fraction(0))


def guessed_ends(comparison: Comparison, used: set[int], level: float) -> tuple[list[float], list[float]]:
    """Ends of the used cells in floats, all at once; the others have their range."""
    low, high = _guessed(comparison.valued[0], used, level)
    return low, _guessed(comparison.valued[1], used, level)[1] if comparison.meanings else high


def _guessed(cells: Sequence[Cell], used: set[int], level: float) -> tuple[list[float], list[float]]:
    """Ends of the used cells in floats, all at once, by the formula of `_float_tail` for many draws; the others have their range."""
    shared = {id(end): end for cell in cells for end in (cell.low, cell.high)}  # most cells share their ends
    floats = {key: float(end) for key, end in shared.items()}
    low, high = [floats[id(cell.low)] for cell in cells], [floats[id(cell.high)] for cell in cells]
    known = informative(cells)
    at = sorted(i for i in used if known[i])
    n = np.array([cells[i].draws for i in at], dtype=np.float64)
    k = n * shares([cells[i] for i in at])
    binary = np.array([cells[i].binary for i in at])
    upper, lower = float_upper_ends(n, k, binary, level), 1 - float_upper_ends(n, n - k, binary, level)
    for i, a, b in zip(at, lower.tolist(), upper.tolist(), strict=True):
        low[i], high[i] = low[i] + (high[i] - low[i]) * a, low[i] + (high[i] - low[i]) * b
    return low, high


def wide_ends(cells: Sequence[Cell], level: Fraction, digits: int = 9) -> list[Ends]:
    """Ends of cells in closed form, which the sharp tail excludes too, rounded outwards to some digits on the scale of [0, 1]."""
    share, draws = shares(cells), np.array([float(cell.draws) for cell in cells])
    below, above = closed_ends(share, -log(float(level)) / draws)
    low, high = below * (1 - 1e-6) - 1e-9, above * (1 + 1e-6) + 1e-9
    low, high = np.maximum(0, np.floor(low * 1e9)), np.minimum(1e9, np.ceil(high * 1e9))
    least, most = (10 ** np.maximum(0, np.floor(np.log10(np.maximum(end, 1))) + 1 - digits) for end in (low, high))
    grid = np.floor(low / least) * least, np.minimum(1e9, np.ceil(high / most) * most)
    listed = zip(cells, *(found.astype(np.int64).tolist() for found in grid), strict=True)
    known: dict[tuple[int, int, int], Fraction] = {}

    def between(cell: Cell, part: int) -> Fraction:
        key = id(cell.low), id(cell.high), part
        found = known.get(key)
        if found is None:
            share = Fraction(part, 10**9)
            found = known[key] = share if not cell.low and cell.high == 1 else cell.low + (cell.high - cell.low) * share
        return found

    return [(between(cell, a), between(cell, b)) for cell, a, b in listed]
