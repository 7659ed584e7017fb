"""Quotients of two forms over a box of means: the greatest and the least, exactly, and the pair that attains them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Sized
from dataclasses import replace
from fractions import Fraction
from heapq import nsmallest
from itertools import permutations
from math import inf
from typing import Any

from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import quotient
from fairaudit.inference.comparisons import Comparison, Form, form_mean

AllEnds = Sequence[tuple[Any, Any]] | Mapping[int, tuple[Any, Any]]  # by cell

DECISIVE_CELLS = 100  # up to here narrow ends of every cell take less than a second

FOREMOST = 30  # blocks that bounds in closed form put first; the one that decides is seldom behind them, and nothing rests on it


def are_many(cells: Sized) -> bool:
    """Whether only the cells that decide an end are looked at closely, because all of them would take long."""
    return len(cells) > DECISIVE_CELLS


def greatest_ratio(top: Form, bottom: Form, ends: AllEnds) -> Any:
    """Maximise Σ w·h / Σ v·h over a box of non-negative h, exactly.

    The maximum is at a threshold: h at its upper end where w/v is greater than the maximum, else at its lower end.

    Parameters
    ----------
    top, bottom : tuple of (int, number)
        The weights w and v, by cell.
    ends : sequence of pairs
        Lower and upper end of each cell.

    Returns
    -------
    Fraction or float
        The maximum, `math.inf` if the denominator can vanish and the numerator with it cannot; 0/0 is 1.

    Examples
    --------
    >>> half = Fraction(1, 2)
    >>> greatest_ratio(((0, half), (1, half)), ((1, Fraction(1)),), [(Fraction(1), Fraction(2))] * 2)
    Fraction(3, 2)
    """
    w, v = dict(top), dict(bottom)
    ordered = sorted({**w, **v}, key=lambda i: -w[i] / v[i] if i in w and i in v else -inf if i in w else 0)
    above = sum(x * ends[i][0] for i, x in top)
    below = sum(x * ends[i][0] for i, x in bottom)
    best = quotient(above, below)
    for i in ordered:
        gap = ends[i][1] - ends[i][0]
        if gap:
            above += w.get(i, 0) * gap
            below += v.get(i, 0) * gap
            best = max(best, quotient(above, below))
    return best


def least_ratio(top: Form, bottom: Form, ends: AllEnds) -> Any:
    """Minimise Σ w·h / Σ v·h over a box of non-negative h, exactly; see `greatest_ratio`."""
    value = greatest_ratio(bottom, top, ends)
    return 0 if value == inf else 1 / value if value else inf


def extreme_ratio(comparison: Comparison, ends: AllEnds, *, upper: bool) -> tuple[Any, tuple[int, int, int] | None]:
    """Greatest maximum (or minimum) of a quotient over all compared pairs, clipped at 1, and where: block, higher, lower."""
    best: Any = Fraction(1)
    where = None
    bound = greatest_ratio if upper else least_ratio
    for b, block in enumerate(comparison.blocks):
        for i, j in extreme_candidates(block, ends):
            if _surely_less(block[i], block[j], ends, best, upper=upper):
                continue
            value = bound(block[i], block[j], ends)
            if value > best or (where is None and value == best):
                best, where = value, (b, i, j)
            if best == inf:
                return best, where
    return best, where


def _surely_less(top: Form, bottom: Form, ends: Any, than: Any, *, upper: bool) -> bool:
    """Whether floats, which are right to fifteen digits here, find a quotient of two cells well below a number."""
    if len(top) > 1 or len(bottom) > 1 or top[0][0] == bottom[0][0] or top[0][1] != bottom[0][1]:
        return False
    above, below, least = (_rounded(v) for v in (ends[top[0][0]][upper], ends[bottom[0][0]][not upper], than))
    return all(1e-100 < v < 1e100 for v in (above, below, least)) and above / below < least * (1 - 1e-9)


def extreme_candidates(block: tuple[Form, ...], ends: AllEnds) -> Iterable[tuple[int, int]]:
    """Ordered pairs that can be extreme: all of them, unless every form is a cell of its own."""
    if len(block) < 3 or any(len(form) > 1 for form in block) or len({form[0][0] for form in block}) < len(block):
        return permutations(range(len(block)), 2)
    found = []
    lows, highs = ([ends[form[0][0]][k] for form in block] for k in (0, 1))
    for numerators, denominators in ((highs, lows), (lows, highs)):
        tops, bottoms = _two_least([-value for value in numerators]), _two_least(denominators)
        found += [(i, j) for i in tops for j in bottoms if i != j]
    return found


def _two_least(values: Sequence[Any]) -> list[int]:
    """Positions of the two least values, the first of equal ones. Rounding keeps the order, so floats leave few to compare."""
    rounded = [_rounded(value) for value in values]
    second = nsmallest(2, rounded)[-1]
    return sorted((i for i, value in enumerate(rounded) if value <= second), key=lambda i: (values[i], i))[:2]


def _rounded(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def vanishing_pair(comparison: Comparison, ends: AllEnds) -> tuple[int, int, int] | None:
    """Which pair is most unequal in the draws, of those whose quotient is infinite somewhere in a box."""
    best: Extended = -1.0
    where = None
    for b, block in enumerate(comparison.blocks):
        bottoms = [j for j, form in enumerate(block) if not any(ends[i][0] for i, _ in form)] if len(block) > 1 else []
        means = [form_mean(comparison, form) for form in block] if bottoms else []
        ranked = sorted(range(len(means)), key=lambda i: -means[i])
        for j in bottoms:
            tops = (i for i in ranked if i != j and greatest_ratio(block[i], block[j], ends) == inf)
            i = next(tops, None)
            if i is not None and (value := quotient(means[i], means[j])) > best:
                best, where = value, (b, i, j)
            if best == inf:
                return where
    return where


def sample_ratio(comparison: Comparison) -> Extended | None:
    """The ratio of the table itself, found once for each comparison; None if a cell has no draws."""
    kept = comparison.__dict__
    if "sample_ratio" not in kept:
        kept["sample_ratio"] = _sample_ratio(comparison)
    return kept["sample_ratio"]  # type: ignore[no-any-return]


def _sample_ratio(comparison: Comparison) -> Extended | None:
    cells, blocks = comparison.cells, comparison.blocks
    if not all(cell.draws or cell.low == cell.high for cell in cells):
        return None
    if are_many(cells) and comparison.single and moderate_ranges(comparison):
        rounded = [cell.total.numerator / (cell.total.denominator * cell.draws) if cell.draws else float(cell.low) for cell in cells]
        promises = []
        for block in blocks:
            of_block = [rounded[form[0][0]] for form in block]
            top, low = max(of_block), min(of_block)
            promises.append(top / low if low else inf if top else 1.0)
        best = max(promises)
        if best == inf:
            return inf
        blocks = tuple(block for block, promise in zip(blocks, promises, strict=True) if promise > best * (1 - 1e-9))
    means = {i: (cells[i].mean if cells[i].draws else cells[i].low,) * 2 for block in blocks for form in block for i, _ in form}
    estimate: Extended
    estimate, _ = extreme_ratio(replace(comparison, blocks=blocks), means, upper=True)
    return estimate


def moderate_ranges(comparison: Comparison) -> bool:
    """Whether no range is so great or small that floats could not hold its quotients."""
    ends = {id(cell.low): cell.low for cell in comparison.cells} | {id(cell.high): cell.high for cell in comparison.cells}
    return all(not end or abs(end.numerator.bit_length() - end.denominator.bit_length()) < 300 for end in ends.values())
