"""How many draws would decide a target: estimates in floats from simulated tables, not guarantees."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from math import ceil, exp, sqrt
from typing import Any

import numpy as np

from fairaudit.errors import InputError, shown
from fairaudit.exact.enclosures import compare_log
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.exact.rationals import Number, option_value
from fairaudit.inference.cells import Cell, exact_sum
from fairaudit.inference.comparisons import Comparison, unit_form, witness_of
from fairaudit.inference.draws import declared_range
from fairaudit.inference.interval import Interval, Region, Selection
from fairaudit.inference.levels import confidence_level
from fairaudit.inference.pair_region import fits_pairs
from fairaudit.inference.power import Audit, Chance, Chances, Side
from fairaudit.inference.quotients import extreme_ratio, sample_ratio
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.rejections import Supposed
from fairaudit.measures.limits import ALONE, Unit, one_limit, without_bare_limits
from fairaudit.measures.ratios import Witness
from fairaudit.words import approximate, brief, percent, place

GREATEST_UTILITY = 10**300  # what floats hold

GREATEST_DRAWS = 10**12  # per cell: nobody draws as many

MANY = 2_000  # cells: so many, whatever is declared about them, have the box

DECISIVE = 200  # contexts of so many cells, which are looked at

LOSS = 0.01  # of power, for a plan with fewer draws where they are not needed

METHODS = {
    "pairs": "the exact pair bound",
    "contrasts": "bets on the contrast of draws",
    "product": "the product region",
    "box": "the box of the ends of cells",
}
"""What a plan simulates, by region."""

SPLIT = ", of the pair that half of the draws chooses"


@brief
@dataclass(frozen=True, repr=False)
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
        How many draws that is in all (further ones for `further_draws`), or, of a log with sampling units, how many further units.
    total_if_equal : int or None
        How many it would be if all compared groups were equal, where the draws do not exclude that.
    power : float or None
        How likely they decide, as simulated.
    method : str or None
        What was simulated.
    pair : Witness or None
        The pair that decides, whose cells need the draws.
    pair_draws : tuple of int or None
        Of `further_draws`: how many further draws of its two cells would decide that pair by itself.
    cells : tuple of int
        Of `plan`: the cells that need the draws, by their place in `draws`.
    fewest : tuple of int or None
        Of `plan`: draws per cell that are about as good, fewer where they are not needed.

    Examples
    --------
    >>> import fairaudit as fa
    >>> found = fa.plan(["0.5", "0.5"], max_ratio="5/4", independent=True)
    >>> found.decides, 340 < found.draws[0] < 400
    ('within', True)
    """

    draws: tuple[int, ...] | None
    decides: Side | None
    sentence: str
    total: int | None = None
    total_if_equal: int | None = None
    power: float | None = None
    method: str | None = None
    pair: Witness | None = None
    pair_draws: tuple[int, int] | None = None
    cells: tuple[int, ...] = ()
    fewest: tuple[int, ...] | None = None


@dataclass(frozen=True)
class _Goal:
    """A limit, and the error that may be made."""

    unit: Unit
    limit: Fraction
    alpha: Fraction

    @property
    def ratio(self) -> float:
        """The limit of the ratio, in floats."""
        return exp(min(self.limit, Fraction(700))) if self.unit == "log" else float(min(self.limit, Fraction(10**300)))

    def side(self, ratio: Extended) -> Side | None:
        """On which side of the limit a ratio is; None if it is the limit."""
        if self.unit == "ratio":
            sign = (ratio > self.limit) - (ratio < self.limit)
        else:
            sign = compare_log(extended_pair(ratio), (self.limit.numerator, self.limit.denominator))
        return None if sign == 0 else "exceeds" if sign > 0 else "within"


@without_bare_limits(ALONE)
def further_draws(
    comparison: Comparison,
    confidence: Number = "0.95",
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    interval: Interval | None = None,
    power: float = 0.8,
) -> Planning:
    """Estimate how many more draws would decide a target, if the truth were as measured, and which cells need them.

    Of a context all cells grow alike, as far as it needs more; to show "exceeds", only the two of the pair that shows it.

    What was measured is itself subject to chance. Where the draws do not exclude that all compared groups are equal, a measured ratio
    above the limit is no reason to expect "exceeds": then no verdict is expected, and what equal groups would need is said, too.

    Parameters
    ----------
    comparison : Comparison
        The draws so far.
    confidence : number or str
        Of the end that decides.
    max_ratio, max_log
        The target, as for `verdict`.
    interval : Interval, optional
        The interval so far: it is planned for its method, and it says whether equal groups are excluded; by default the box.
    power : float
        How likely so many draws, taken anew, should decide.

    Returns
    -------
    Planning
        A planning estimate.

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
    cells = comparison.cells
    if not all(cell.draws for cell in cells) and any(not cells[i].draws for block in comparison.blocks for form in block for i, _ in form):
        return Planning(None, None, "Planning estimate: some cells have no draws; draw from every cell first.")
    if any(high > GREATEST_UTILITY for high in {id(cell.high): cell.high for cell in cells}.values()):
        return Planning(None, None, "Planning estimate: none for utilities above 10^300, which floating point does not hold.")
    goal = _Goal(*one_limit(max_ratio, max_log), 1 - confidence_level(confidence))
    interval = interval or ratio_interval(comparison, confidence, ends="each")
    method = None if interval.region == "contrasts" else interval.evidence["method"]
    select: Selection = "half-split" if "split" in interval.evidence else "bonferroni"
    design = _Design(comparison, goal, power, interval.evidence["independent"], method, select)
    measured = sample_ratio(comparison) or Fraction(1)
    side = goal.side(measured)
    means = [_rounded_mean(cell) for cell in cells]
    found = design.least(means, side)
    by_chance = interval.lower <= 1 and side != "within"
    if_equal = None
    if by_chance:
        equal = design.least(_equal_means(comparison), goal.side(Fraction(1)))
        if_equal = None if equal is None else equal.more
    sentence = _measured_sentence(comparison, measured, side, found, power, expected=not by_chance)
    if by_chance:
        needed = "no number of draws would decide" if if_equal is None else f"it would take about {if_equal}"
        sentence += f" These draws do not exclude that all groups are equal, and their ratio may be chance alone; if so, {needed}."
    if found is None or side is None:
        return Planning(None, None, sentence, None, if_equal)
    return Planning(
        found.draws, None if by_chance else side, sentence, found.more, if_equal, found.power, found.method, found.pair, found.pair_draws
    )


@dataclass(frozen=True)
class _Found:
    """A size that is expected to decide."""

    draws: tuple[int, ...]
    more: int
    times: float
    power: float
    method: str
    pair: Witness | None
    pair_draws: tuple[int, int] | None


@dataclass(frozen=True)
class _Design:
    """An audit that has been made, and is to be made again with more draws, shared among the cells as they were."""

    comparison: Comparison
    goal: _Goal
    power: float
    independent: bool
    method: Any
    select: Selection

    def least(self, means: Sequence[float], side: Side | None) -> _Found | None:
        """The least size that decides on a side, if the cells have these means."""
        compared = self.comparison
        if side is None:
            return None
        if side == "within" and _vanishing(compared, means):
            return None
        audit = self._audit(means, side)
        units = compared.units
        now = units.total if units and units.total else sum(cell.draws for cell in compared.cells)
        most = max(cell.draws for cell in compared.cells)
        chances = lru_cache(Chances(audit).at)
        size = _least(lambda n: chances(n / now).power >= self.power, now, GREATEST_DRAWS * now // most)
        if size is None:
            return None
        chance = chances(size / now)
        method = _method(audit, size / now)
        draws = tuple(ceil(cell.draws * size / now) - cell.draws for cell in compared.cells)
        if units or not compared.single:
            pair = None if chance.pair is None or not compared.labels else witness_of(compared, chance.pair)
            more = ceil(size) - now if units and units.total else sum(draws)
            return _Found(draws, more, size / now, chance.power, method, pair, None)
        pair, places, of_pair = self._pair(audit, chance)
        if side == "exceeds":
            draws = tuple(of_pair[places.index(i)] if i in places else 0 for i in range(len(draws)))
        else:
            times = dict(_by_cell(audit.comparison, Chances(audit).fewest(size / now, LOSS)))
            draws = tuple(ceil(cell.draws * times.get(i, 1.0)) - cell.draws for i, cell in enumerate(compared.cells))
        return _Found(draws, sum(draws), 1 + sum(draws) / now, chance.power, method, pair, of_pair)

    def _audit(self, means: Sequence[float], side: Side) -> Audit:
        """The audit, of many cells only with the contexts that decide."""
        compared = self.comparison
        if len(compared.cells) <= MANY or not compared.single:
            supposed = [_supposed(cell, mean) for cell, mean in zip(compared.cells, means, strict=True)]
            return _audit(compared, supposed, side, self.goal, self.independent, self.method, self.select)
        places = _foremost(compared, means)
        labels = tuple(compared.labels[b] for b in places) if compared.labels else ()
        part = replace(compared, blocks=tuple(compared.blocks[b] for b in places), labels=labels)
        listed = [Supposed(1, 0.0, 0.0, 0.0, 1.0, True)] * len(means)
        for block in part.blocks:
            for ((i, _),) in block:
                listed[i] = _supposed(compared.cells[i], means[i])
        whole = _audit(compared, listed, side, self.goal, self.independent, self.method, self.select)
        return replace(whole, comparison=part)

    def _pair(self, audit: Audit, chance: Chance) -> tuple[Witness | None, tuple[int, int], tuple[int, int]]:
        """The pair that decides, its cells, and how many further draws they need for it by itself."""
        compared = audit.comparison
        where = chance.pair or (0, 0, 1)
        high, low = (compared.blocks[where[0]][k][0][0] for k in where[1:])
        own = compared.cells[high].draws, compared.cells[low].draws
        chances = Chances(replace(audit, only=where))
        size = _least(lambda n: chances.at(n / sum(own)).power >= self.power, sum(own), GREATEST_DRAWS) or sum(own)
        more = ceil(own[0] * size / sum(own)) - own[0], ceil(own[1] * size / sum(own)) - own[1]
        return witness_of(compared, where) if compared.labels else None, (high, low), more


def _foremost(comparison: Comparison, means: Sequence[float]) -> list[int]:
    """The blocks whose greatest ratios, two standard errors up, are greatest."""
    blocks = [(b, [form[0][0] for form in block]) for b, block in enumerate(comparison.blocks) if len(block) > 1]
    flat = [i for _, members in blocks for i in members]
    greatest = np.array(_in_floats([comparison.cells[i].high for i in flat]))
    values = np.array([means[i] for i in flat])
    share = np.divide(values, greatest, out=np.zeros(len(flat)), where=values != 0)
    draws = np.array([comparison.cells[i].draws for i in flat], dtype=np.float64)
    share = (share * draws + 0.5) / (draws + 1)
    log_means = np.log(share) + np.log(greatest)
    errors = 2 * np.sqrt(np.maximum(1 - share, 0) / share / (draws + 1))
    starts = np.cumsum([0, *(len(members) for _, members in blocks[:-1])])
    apart = np.maximum.reduceat(log_means + errors, starts) - np.minimum.reduceat(log_means - errors, starts)
    return sorted(blocks[k][0] for k in np.argsort(-apart, kind="stable")[:DECISIVE].tolist())


def _by_cell(comparison: Comparison, of_blocks: Sequence[float]) -> list[tuple[int, float]]:
    """What holds for the cells of each block."""
    return [(i, times) for block, times in zip(comparison.blocks, of_blocks, strict=True) for ((i, _),) in block]


def _supposed(cell: Cell, mean: float) -> Supposed:
    """A cell that has so many draws and this mean, and whose draws vary as they did."""
    low, width = float(cell.low), float(cell.high - cell.low)
    if not width:
        return Supposed(cell.draws, 0.0, 0.0, low, low, cell.binary)
    share = min(max((mean - low) / width, 0.0), 1.0)
    variance = share * (1 - share)
    if cell.draws and not cell.binary and cell.squares is not None:
        variance = min(variance, float((cell.squares / cell.draws - cell.mean**2) / (cell.high - cell.low) ** 2))
    return Supposed(cell.draws, share, sqrt(max(variance, 0.0)), low, low + width, cell.binary)


def _audit(
    comparison: Comparison, supposed: Sequence[Supposed], side: Side, goal: _Goal, independent: bool, method: Any, select: Selection
) -> Audit:
    """The audit that `certify` would make, by its size: there may be too many draws for the exact pair bound."""
    of_sizes: dict[int, Region] = {}

    def region(factor: float) -> Region:
        if not independent or len(comparison.cells) > MANY:
            return "box"
        most = max(ceil(cell.draws * factor) for cell in supposed)
        if most not in of_sizes:
            sizes = [int(cell.grown(factor).draws) for cell in supposed]
            drawn = tuple(replace(cell, draws=n, total=n * cell.low) for cell, n in zip(comparison.cells, sizes, strict=True))
            grown = replace(comparison, cells=drawn)
            found = default_region(grown, method, independent=True, alpha=goal.alpha)
            if select == "half-split" and not fits_pairs(grown, goal.alpha, select):
                found = "box"
            of_sizes[most] = found if found in METHODS else "box"
        return of_sizes[most]

    used = {i for block in comparison.blocks if len(block) > 1 for form in block for i, _ in form}
    span = 2 if comparison.single else replace(comparison, cells=tuple(replace(c, draws=1, total=c.low) for c in comparison.cells)).span
    counts = comparison.pairs, sum(wide for i, wide in enumerate(_wide(comparison.cells)) if i in used), span
    return Audit(comparison, supposed, side, goal.ratio, goal.alpha, method or "hoeffding-kl", independent, region, *counts, select)


def _wide(cells: Sequence[Cell]) -> list[bool]:
    """Whether draws of each cell can differ; most cells share their ends."""
    shared = {(id(cell.low), id(cell.high)): cell for cell in cells}
    known = {key: cell.high > cell.low for key, cell in shared.items()}
    return [known[id(cell.low), id(cell.high)] for cell in cells]


def _method(audit: Audit, factor: float) -> str:
    """What is simulated at a size."""
    return METHODS[audit.region(factor)] + (SPLIT if audit.select == "half-split" and audit.side == "exceeds" else "")


def _vanishing(comparison: Comparison, means: Sequence[float]) -> bool:
    """Whether a form is supposed to have the mean 0, so that no number of draws bounds its ratios."""
    return not all(means) and any(not any(means[i] for i, _ in form) for block in comparison.blocks if len(block) > 1 for form in block)


def _least(enough: Callable[[int], bool], start: int, greatest: int) -> int | None:
    """The least size from a start on that is enough, to a part in 250, by doubling and halving."""
    low, high = start - 1, start
    while not enough(high):
        if high >= greatest:
            return None
        low, high = high, min(2 * high, greatest)
    while high - low > max(1, high // 250):
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def _equal_means(comparison: Comparison) -> list[float]:
    """Means of the cells if the forms of each block were equal, as near to the draws as that."""
    cells = comparison.cells
    sets = [[i for form in block for i, _ in form] for block in comparison.blocks] if comparison.single else [list(range(len(cells)))]
    means = [_rounded_mean(cell) for cell in cells]
    least, most = _in_floats([cell.low for cell in cells]), _in_floats([cell.high for cell in cells])
    for members in sets:
        total, draws = exact_sum([cells[i].total for i in members]), sum(cells[i].draws for i in members)
        pooled = total.numerator / (total.denominator * draws)
        for i in members:
            means[i] = min(max(pooled, least[i]), most[i])
    return means


def _rounded_mean(cell: Cell) -> float:
    """The mean of the draws of a cell, correctly rounded."""
    return cell.total.numerator / (cell.total.denominator * cell.draws)


def _in_floats(ends: Sequence[Fraction]) -> list[float]:
    """Ends of ranges, which most cells share."""
    shared = {key: float(end) for key, end in {id(end): end for end in ends}.items()}
    return [shared[id(end)] for end in ends]


def _measured_sentence(
    comparison: Comparison, measured: Extended, side: Side | None, found: _Found | None, power: float, *, expected: bool
) -> str:
    """What it would take if the truth were as measured."""
    start = f"Planning estimate, not a guarantee: if the truth were as measured (a ratio of {approximate(measured)}),"
    if side is None:
        return f"{start} no number of further draws would be expected to decide: that is the limit itself."
    if found is None:
        return f"{start} no number of further draws would be expected to decide."
    units = comparison.units
    what = f"units of {', '.join(map(shown, units.columns))}" if units and units.total else "draws"
    verdict = f" ({side})" if expected else ""
    chance = f"with probability {percent(Fraction(str(power)))}, by {found.method}"
    if found.more:
        said = f"{start} about {found.more} further {what}, {found.times:.4g} times as many in all, would decide{verdict} {chance}."
    else:
        said = f"{start} as many draws, taken anew, would decide{verdict} {chance}."
    if found.pair is None or not expected:
        return said
    where = f"{place(found.pair.context)}: " if found.pair.context else ""
    said += f" {where}{place(found.pair.higher)} over {place(found.pair.lower)} needs them"
    if found.pair_draws is None or found.pair_draws == (0, 0):
        return f"{said} most."
    most = "" if sum(found.pair_draws) == found.more else " most, by itself"
    return f"{said}{most or ':'} about {found.pair_draws[0]} and {found.pair_draws[1]}."


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
    independent: bool = False,
    shares: Sequence[Number] | Sequence[Sequence[Number]] | None = None,
    units: bool = False,
    select: Selection = "bonferroni",
) -> Planning:
    """Estimate the draws per cell that would show that a target is kept or exceeded, before any are taken.

    Tables are simulated from the guesses, and judged as `certify` would judge them.

    Parameters
    ----------
    guesses : sequence of numbers, sequence of such sequences, or Comparison
        The supposed means of the groups of one context, or of each of several; or a comparison whose cell means are the guesses.
    confidence : number or str
        Of the end that decides, as `certify` judges one target.
    max_ratio, max_log
        The target, as for `verdict`.
    power : float
        How likely it should be, in [0.5, 1), that the draws suffice if the guesses are right.
    limits, binary
        The range of the utility, and whether it takes no values between. If it does, draws are supposed to vary as much as they can.
    independent : bool
        Whether `certify` will be told that cells are independent of each other.
    shares : sequence of numbers, or of such sequences, optional
        The sizes of the groups in proportion to each other, the same in every context or for each; by default all are equal.
    units : bool
        Whether sampling units are counted, each with several rows in its cell, whose mean may then lie anywhere in the range.
    select : {"bonferroni", "half-split"}
        How `certify` will be told to find the pair that exceeds.

    Returns
    -------
    Planning
        A planning estimate, in floats.

    Raises
    ------
    InputError
        If a guess lies outside the limits, a share is not positive, or the power is not in [0.5, 1).

    Examples
    --------
    >>> found = plan(["0.5", "0.5"], max_log="0.2", shares=[1, 3])
    >>> found.draws[1] == 3 * found.draws[0], found.decides
    (True, 'within')
    """
    if not 0.5 <= power < 1:
        raise InputError(f"a power of {shown(power)} is not accepted; it lies between 0.5 and 1")
    goal = _Goal(*one_limit(max_ratio, max_log), 1 - confidence_level(confidence))
    if isinstance(guesses, Comparison):
        comparison = guesses
        exact = [cell.mean if cell.draws else cell.high for cell in guesses.cells]
    else:
        comparison, exact = _guessed(guesses, limits, binary=binary and not units, many=units)
    if independent and comparison.dependent:
        raise InputError("cells share draws or sampling units, so they are not independent")
    if select != "bonferroni" and not (independent and all(cell.binary for cell in comparison.cells)):
        raise InputError(f"select {shown(select)} needs independent cells of draws of two values; say so, or leave it out")
    weights = _weights(comparison, shares)
    ratio, _ = extreme_ratio(comparison, {i: (mean, mean) for i, mean in enumerate(exact)}, upper=True)
    side = goal.side(ratio)
    if side is None:
        return Planning(
            None,
            None,
            "Planning estimate: no number of draws decides, because the guesses have a ratio that is the limit itself; there an audit "
            f"stays inconclusive with probability {percent(1 - 2 * goal.alpha)} or more.",
        )
    means = [float(mean) for mean in exact]
    supposed = [replace(_supposed(cell, mean), draws=w) for cell, mean, w in zip(comparison.cells, means, weights, strict=True)]
    audit = _audit(comparison, supposed, side, goal, independent, None, select)
    chances = lru_cache(Chances(audit).at)
    possible = side == "exceeds" or not _vanishing(comparison, means)
    size = _least(lambda n: chances(float(n)).power >= power, 1, GREATEST_DRAWS) if possible else None
    if size is None:
        why = "the guesses are too close to the limit" if possible else "where a group gets nothing, as guessed, no ratio is bounded"
        return Planning(None, None, f"Planning estimate: no number of draws is expected to decide; {why}.")
    chance, method = chances(float(size)), _method(audit, size)
    draws = tuple(int(cell.grown(float(size)).draws) for cell in supposed)
    cells = Chances(audit).deciding(chance)
    fewest = None
    if side == "within" and len(comparison.blocks) > 1 and comparison.single:
        times = dict(_by_cell(comparison, Chances(audit).fewest(size, LOSS)))
        fewest = tuple(int(cell.grown(times.get(i, 1.0)).draws) for i, cell in enumerate(supposed))
    what = "units" if units else "draws"
    much = f"{draws[0]} {what} per cell" if len({*draws}) == 1 else f"{sum(draws)} {what}, {min(draws)} to {max(draws)} per cell,"
    widely = "" if all(cell.binary for cell in comparison.cells) else ", supposing that they vary as much as they can"
    sentence = (
        f"Planning estimate, not a guarantee: if the guesses are right, about {much} would show {side!r} with probability "
        f"{percent(round(chance.power, 2))}, by {method}{widely}."
    )
    return Planning(
        draws,
        side,
        sentence,
        sum(draws),
        power=chance.power,
        method=method,
        pair=_supposed_pair(comparison, chance.pair, exact),
        cells=cells,
        fewest=fewest if fewest and sum(fewest) < 0.95 * sum(draws) else None,
    )


def _supposed_pair(comparison: Comparison, pair: tuple[int, int, int] | None, means: Sequence[Fraction]) -> Witness | None:
    """Name a pair, with the means that are supposed."""
    found = witness_of(comparison, pair) if comparison.labels else None
    if found is None or pair is None:
        return None
    higher, lower = (sum((w * means[i] for i, w in comparison.blocks[pair[0]][k]), Fraction(0)) for k in pair[1:])
    return replace(found, expectations=(higher, lower))


def _guessed(guesses: Any, limits: tuple[Number, Number], *, binary: bool, many: bool) -> tuple[Comparison, list[Fraction]]:
    """The cells that are compared, by numbers of contexts and groups, and their supposed means."""
    low, high = declared_range(limits)
    listed = [list(part) if isinstance(part, (list, tuple)) else [part] for part in guesses]
    rows = listed if any(len(part) > 1 for part in listed) else [[part[0] for part in listed]]
    values = [[Fraction(*option_value(guess)) for guess in row] for row in rows]
    if any(len(row) < 2 for row in values) or any(not low <= v <= high for row in values for v in row):
        raise InputError(f"guesses are needed for at least two groups of each context, between {low} and {high}")
    if high > GREATEST_UTILITY:
        raise InputError("a plan needs utilities of at most 10^300, as far as floating point goes; divide all of them by one number")
    places = iter(range(sum(map(len, values))))
    blocks = tuple(tuple(unit_form(next(places)) for _ in row) for row in values)
    labels = tuple(
        ({"context": str(x)} if len(values) > 1 else None, tuple({"group": str(a)} for a in range(1, len(row) + 1)))
        for x, row in enumerate(values, 1)
    )
    cells = (Cell(1, low, None, low, high, binary),) * sum(map(len, values))
    tallies = [dict.fromkeys((low, (low + high) / 2, high), 0) for _ in cells]
    return Comparison(cells, blocks, labels, drawn=lambda: tallies, listed=not many), [v for row in values for v in row]


def _weights(comparison: Comparison, shares: Any) -> list[float]:
    """How many draws each cell has for each one of the cell that has the fewest."""
    if shares is None:
        return [1.0] * len(comparison.cells)
    sizes = [len(block) for block in comparison.blocks]
    listed = list(shares)
    rows = [list(row) for row in listed] if listed and isinstance(listed[0], (list, tuple)) else [listed] * len(sizes)
    values = [[Fraction(*option_value(share)) for share in row] for row in rows]
    if [len(row) for row in values] != sizes or any(v <= 0 for row in values for v in row):
        raise InputError("shares are needed for every group, greater than 0, the same in every context or a list for each context")
    least = min(v for row in values for v in row)
    return [float(v / least) for row in values for v in row]
