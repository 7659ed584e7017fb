"""How many draws would decide a target: estimates in floats, not guarantees."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, exp, log, sqrt
from statistics import NormalDist
from typing import Any, Literal

import numpy as np

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number, option_value
from fairaudit.inference.cells import Cell, exact_sum
from fairaudit.inference.comparisons import Comparison, Form, unit_form
from fairaudit.inference.draws import declared_range
from fairaudit.inference.float_tails import closed_ends, float_end
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import box_levels, confidence_level
from fairaudit.inference.quotients import FOREMOST, are_many, extreme_ratio, sample_ratio
from fairaudit.measures.limits import ALONE, one_limit, without_bare_limits
from fairaudit.words import approximate, brief

GREATEST_UTILITY = 10**300  # what floats hold

GREATEST_DRAWS = 10**12  # per cell: nobody draws as many


@brief
@dataclass(frozen=True)
class Planning:
    """An estimate for planning, not a guarantee.

    Attributes
    ----------
    draws : tuple of int or None
        Draws per cell (in all for `plan`, further ones for `further_draws`); None if no number up to the limit would do.
    decides : {"within", "exceeds"} or None
        Which verdict they are expected to give; None also where nothing is expected, because what was measured may be chance alone.
    sentence : str
        The same in words.
    total : int or None
        How many further draws that is, or, of a log with sampling units, how many further units.
    total_if_equal : int or None
        How many it would be if all compared groups were equal, where the draws do not exclude that.

    Examples
    --------
    >>> import fairaudit as fa
    >>> found = fa.plan(["0.5", "0.5"], max_ratio="5/4")
    >>> found.draws, found.decides
    ((650, 650), 'within')
    """

    draws: tuple[int, ...] | None
    decides: Literal["within", "exceeds"] | None
    sentence: str
    total: int | None = None
    total_if_equal: int | None = None


@without_bare_limits(ALONE)
def further_draws(
    comparison: Comparison,
    confidence: Number = "0.95",
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    interval: Interval | None = None,
) -> Planning:
    """Estimate how many more draws would decide a target, if the truth were as measured and all cells grew alike.

    What was measured is itself subject to chance. Where the draws do not exclude that all compared groups are equal, a measured ratio
    above the limit is no reason to expect "exceeds": then no verdict is expected, and what equal groups would need is said, too.

    Parameters
    ----------
    comparison : Comparison
        The draws so far.
    confidence : number or str
        Of the end that decides; it is planned for with the box, and hoeffding-kl where draws are not binary.
    max_ratio, max_log
        The target, as for `verdict`.
    interval : Interval, optional
        The interval so far, which says whether equal groups are excluded; by default what the box is expected to give.

    Returns
    -------
    Planning
        A planning estimate: about one time in two the draws will not suffice.

    Examples
    --------
    >>> from fairaudit.inference.table_comparisons import local_comparison
    >>> from fairaudit.model.law import Law
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[12, 28], [8, 32]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> planned = further_draws(local_comparison(law, Utility({"yes": 1}).on(law)), max_ratio="5/4")
    >>> planned.decides, planned.total > 0, planned.total_if_equal > 0
    (None, True, True)
    """
    level = confidence_level(confidence)
    cells = comparison.cells
    if any(not cells[i].draws for block in comparison.blocks for form in block for i, _ in form):
        return Planning(None, None, "Planning estimate: some cells have no draws; draw from every cell first.")
    if any(cell.high > GREATEST_UTILITY for cell in cells):
        return Planning(None, None, "Planning estimate: none for utilities above 10^300, which floating point does not hold.")
    goal = _float_limit(max_ratio, max_log)

    def least_factor(means: Sequence[float]) -> tuple[float, Literal["within", "exceeds"] | None]:
        expected = _expectation(comparison, means, level, 0.0)

        def decides(factor: float) -> Literal["within", "exceeds"] | None:
            lower, upper = expected(lambda i: max(cells[i].draws, ceil(cells[i].draws * factor)))
            return "within" if upper <= goal else "exceeds" if lower > goal else None

        found: tuple[float, Literal["within", "exceeds"] | None] = _least(decides, GREATEST_DRAWS / max(cell.draws for cell in cells))
        return found

    means = [float(cell.mean) for cell in cells]
    factor, found = least_factor(means)
    lower = interval.lower if interval else _expectation(comparison, means, level, 0.0)(lambda i: cells[i].draws)[0]
    equal_factor, equal = least_factor(_equal_means(comparison)) if lower <= 1 else (1.0, None)
    more = None if found is None else tuple(max(0, ceil(cell.draws * factor) - cell.draws) for cell in cells)
    total, if_equal = _further(comparison, factor, found), _further(comparison, equal_factor, equal)
    by_chance = lower <= 1 and found != "within"
    sentence = _planned(comparison, (total, factor), None if by_chance else found)
    if by_chance:
        needed = "no number of draws would decide" if if_equal is None else f"it would take about {if_equal}"
        sentence += f" These draws do not exclude that all groups are equal, and their ratio may be chance alone; if so, {needed}."
    return Planning(more, None if by_chance else found, sentence, total, if_equal)


def _equal_means(comparison: Comparison) -> list[float]:
    """Means of the cells if the forms of each block were equal, as near to the draws as that."""
    cells = comparison.cells
    sets = [[i for form in block for i, _ in form] for block in comparison.blocks] if comparison.single else [list(range(len(cells)))]
    means = [float(cell.mean) for cell in cells]
    for members in sets:
        pooled = float(exact_sum([cells[i].total for i in members]) / sum(cells[i].draws for i in members))
        for i in members:
            means[i] = min(max(pooled, float(cells[i].low)), float(cells[i].high))
    return means


def _further(comparison: Comparison, factor: float, found: str | None) -> int | None:
    """How many further draws a factor means, or further units, which count once however many cells they have rows in."""
    if found is None:
        return None
    units = comparison.units
    counts = [units.total] if units and units.total else [cell.draws for cell in comparison.cells]
    return sum(max(0, ceil(count * factor) - count) for count in counts)


def _planned(comparison: Comparison, further: tuple[int | None, float], found: str | None) -> str:
    """What it would take if the truth were as measured."""
    measured, (total, factor) = sample_ratio(comparison), further
    ratio = "" if measured is None else f" (a ratio of {approximate(measured)})"
    start = f"Planning estimate, not a guarantee: if the truth were as measured{ratio},"
    if total is None:
        return f"{start} no number of further draws would be expected to decide."
    units = comparison.units
    what = f"units of {', '.join(map(shown, units.columns))}" if units and units.total else "draws"
    verdict = "" if found is None else f" ({found})"
    return f"{start} about {total} further {what}, {factor:.3g} times as many in all, would decide{verdict}."


@without_bare_limits(ALONE)
def plan(
    guesses: Comparison | Sequence[Number] | Sequence[Sequence[Number]],
    confidence: Number = "0.95",
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    power: float = 0.8,
    limits: tuple[Number, Number] = (0, 1),
    binary: bool = True,
) -> Planning:
    """Estimate the draws per cell, the same in each, that would show that a target is kept or exceeded, before any are taken.

    Parameters
    ----------
    guesses : sequence of numbers, sequence of such sequences, or Comparison
        The supposed means of the groups of one context, or of each of several; or a comparison whose cell means are the guesses.
    confidence : number or str
        Of the end that decides, as `certify` judges one target.
    max_ratio, max_log
        The target, as for `verdict`.
    power : float
        How likely it should roughly be, in [0.5, 1), that the draws suffice if the guesses are right.
    limits, binary
        The range of the utility, and whether it takes no values between.

    Returns
    -------
    Planning
        A planning estimate, in floats.

    Raises
    ------
    InputError
        If a guess lies outside the limits or the power is not in [0.5, 1).

    Examples
    --------
    >>> plan(["0.5", "0.5"], max_log="0.2").draws
    (807, 807)
    """
    if not 0.5 <= power < 1:
        raise InputError(f"a power of {shown(power)} is not accepted; it lies between 0.5 and 1")
    level = confidence_level(confidence)
    if isinstance(guesses, Comparison):
        comparison = replace(
            guesses, cells=tuple(replace(c, draws=max(1, c.draws), total=c.total if c.draws else c.high) for c in guesses.cells)
        )
        means = [float(cell.mean) for cell in comparison.cells]
    else:
        low, high = declared_range(limits)
        listed = [list(part) if isinstance(part, (list, tuple)) else [part] for part in guesses]
        rows = listed if any(len(part) > 1 for part in listed) else [[part[0] for part in listed]]
        values = [[Fraction(*option_value(guess)) for guess in row] for row in rows]
        if any(len(row) < 2 for row in values) or any(not low <= v <= high for row in values for v in row):
            raise InputError(f"guesses are needed for at least two groups of each context, between {low} and {high}")
        if high > GREATEST_UTILITY:
            raise InputError("a plan needs utilities of at most 10^300, as far as floating point goes; divide all of them by one number")
        means = [float(v) for row in values for v in row]
        places = iter(range(len(means)))
        blocks = tuple(tuple(unit_form(next(places)) for _ in row) for row in values)
        comparison = Comparison((Cell(1, low, None, low, high, binary),) * len(means), blocks)
    goal, shift = _float_limit(max_ratio, max_log), NormalDist().inv_cdf(power)

    expected = _expectation(comparison, means, level, shift)

    def decides(draws: float) -> Literal["within", "exceeds"] | None:
        lower, upper = expected(lambda _: ceil(draws))
        return "within" if upper <= goal else "exceeds" if lower > goal else None

    draws, found = _least(decides, GREATEST_DRAWS)
    if found is None:
        return Planning(None, None, "Planning estimate: no number of draws is expected to decide; the guesses are too close to the limit.")
    count = ceil(draws)
    return Planning(
        (count,) * len(means),
        found,
        f"Planning estimate, not a guarantee: if the guesses are right, about {count} draws per cell would show {found!r}.",
    )


def _float_limit(max_ratio: Any, max_log: Any) -> float:
    unit, limit = one_limit(max_ratio, max_log)
    return exp(min(limit, Fraction(700))) if unit == "log" else float(min(limit, Fraction(10**300)))


def _least(decides: Callable[[float], Any], greatest: float) -> tuple[float, Any]:
    """Least number ≥ 1 from which on a verdict is expected, by doubling and halving."""
    high = 1.0
    while decides(high) is None:
        if high >= greatest:
            return high, None
        high = min(2 * high, greatest)
    low = high / 2
    while high > 1 and high - low > max(0.5 / greatest, 1e-3 * high):
        middle = (low + high) / 2
        low, high = (low, middle) if decides(middle) is not None else (middle, high)
    return high, decides(high)


def _expectation(
    comparison: Comparison, means: Sequence[float], level: Fraction, shift: float
) -> Callable[[Callable[[int], int]], tuple[float, float]]:
    """The ends that the box is expected to give, by the draws of each cell; with a shift, against so many standard errors.

    Of many blocks only those are looked at that ends in closed form put first.
    """
    cells, used = comparison.cells, set(comparison.used)
    levels = box_levels(len(used), comparison.span, 1 - level, independent=False, ends="each")
    many = are_many(used) and comparison.single
    flat = np.array([form[0][0] for block in comparison.blocks for form in block]) if many else np.zeros(0, dtype=np.int64)
    starts = np.cumsum([0, *map(len, comparison.blocks[:-1])])
    low, high = (np.array([float(end) for end in ends])[flat] for ends in ([c.low for c in cells], [c.high for c in cells]))
    share = (np.array(means)[flat] - low) / np.where(high > low, high - low, 1)

    def foremost(draws: Callable[[int], int], each: float, *, upper: bool) -> tuple[tuple[Form, ...], ...]:
        cost = -log(each) / np.array([float(draws(i)) for i in flat.tolist()])
        below, above = (low + (high - low) * end for end in closed_ends(share, cost))
        top, bottom = (above, below) if upper else (below, above)
        with np.errstate(all="ignore"):
            promised = np.maximum.reduceat(top, starts) / np.minimum.reduceat(bottom, starts)
        return tuple(comparison.blocks[b] for b in np.argsort(-np.nan_to_num(promised), kind="stable")[:FOREMOST].tolist())

    def end(i: int, n: int, each: float) -> tuple[float, float]:
        cell = cells[i]
        least, width = float(cell.low), float(cell.high - cell.low)
        if i not in used:
            return least, least + width
        p = (means[i] - least) / width
        error = shift * sqrt(p * (1 - p) / n) if shift else 0.0
        # Both ends of the ratio suffer when a numerator or denominator deviates towards its own end.
        below, above = max(0.0, p - error), min(1.0, p + error)
        return (
            least + width * float_end(n, n * below, each, cell.binary, "upper"),
            least + width * float_end(n, n * above, each, cell.binary, "lower"),
        )

    def expected(draws: Callable[[int], int]) -> tuple[float, float]:
        sides = []
        for upper, each in zip((True, False), map(float, levels), strict=True):
            blocks = foremost(draws, each, upper=upper) if many else comparison.blocks
            needed = {i for block in blocks for form in block for i, _ in form}
            ends = {i: end(i, draws(i), each) for i in needed}
            value, _ = extreme_ratio(replace(comparison, blocks=blocks), ends, upper=upper)
            sides.append(float(value))
        return sides[1], sides[0]

    return expected
