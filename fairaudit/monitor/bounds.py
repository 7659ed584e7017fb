"""Intervals for a stream of decisions that hold at every moment at once, however the moment to look is chosen.

The utility of each decision is scaled to [0, 1]. For a supposed mean p of a cell, a gambler who bets the share λ on every decision has

    1 + λ·(x₁ − p), times 1 + λ·(x₂ − p), and so on,

which is a test martingale if every decision has the mean p given the past, and a supermartingale if it has less. So is a mixture over
bets λ that were fixed in advance; a mixture is a function of how often each value came, and nothing else. By Ville's inequality it ever
reaches 1/β with probability at most β: a mean at which it has can be excluded, at any moment, by anybody who looks. Here the bets are
min(2^i, 15/(16p)), and a part of the money is never bet; the wealth falls in p, and exchanging x, p for 1 − x, 1 − p gives that against
means that are too great.

Two cells are compared by the product of the wealth against one mean and the wealth against the other, again a supermartingale, so that
all pairs of means whose product reaches 1/β are excluded. Cells that appear late share a budget that was set aside for them: the weights
K/((j + K − 1)(j + K)), j = 1, 2, …, sum to 1. The proofs are in docs/certificate-monitor.md.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, permutations
from math import ceil, floor, inf, log, log10
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.columns import Label
from fairaudit.exact import InputError, quotient, rational_text
from fairaudit.fairness import Witness
from fairaudit.law import Law
from fairaudit.sampling import DECLARED, Interval, confidence_level
from fairaudit.utility import UtilityTable

__all__ = [
    "Arrivals",
    "Change",
    "Tally",
    "Window",
    "change_of",
    "log_wealth",
    "stream_drivers",
    "stream_interval",
    "tallies",
    "wealth_reaches",
]

Floats = NDArray[np.float64]
Side = Literal["above", "below"]
Quantity = Literal["local", "global"]
Number = tuple[int, int]  # mantissa and exponent of 2, rounded down
Places = tuple[Sequence[int] | None, Sequence[int] | None]  # block, higher, lower: behind the lower and the upper end

BETS = range(-16, 5)
CENTRE = -2
IDLE = Fraction(1, 32)
CAP = Fraction(15, 16)
SHARES = tuple(Fraction(29, 20) / ((abs(i - CENTRE) + 2) * (abs(i - CENTRE) + 3)) for i in BETS)
BITS = 128
POINTS = 400
SLACK = 0.025
ROUNDING = 4e-3
MAX_KNOTS = 2_000
DIGITS = 7

_LAMBDAS = 2.0 ** np.array(BETS, dtype=np.float64)
_LOG_SHARES = np.log(np.array([float(share) for share in SHARES]))
_LOG_IDLE = log(float(IDLE))

PAST = "given everything recorded before it, each decision has the expected utility of its context and group as its mean"
OWN_PAST = "given the earlier decisions that count in its context and group, each such decision has their expected utility as its mean"
ORDER = "which contexts and groups appear, and in what order they first do, does not depend on how decisions come out"
MIX = "whatever came before, the context of a group's next decision has the same distribution, and so its expected utility stays the same"


@dataclass(frozen=True)
class Arrivals:
    """The order in which cells first appeared in a stream, and how the budget of error was laid out for them.

    Attributes
    ----------
    order : tuple of (context, group)
        The cells, each a pair of labels, in order of first appearance.
    expected : int
        About how many cells were expected when the stream began, K of the weights K/((j + K − 1)(j + K)); any number is sound.
    joint : bool
        Whether each decision has the mean of its cell given all earlier decisions, of other cells too. False if a sampling unit has
        rows in several cells; then the intervals are wider.
    """

    order: tuple[tuple[Label, Label], ...]
    expected: int = 4
    joint: bool = True


@dataclass(frozen=True, eq=False)
class Window:
    """A part of a stream, counted by itself.

    Attributes
    ----------
    number : int
        Its number, from 1 on: the error that all windows share is divided as 1/(i(i + 1)).
    law : Law
        What was counted in it.
    utility : UtilityTable
        The utility on it.
    arrivals : Arrivals
        The order in which its own cells first appeared.
    """

    number: int
    law: Law
    utility: UtilityTable
    arrivals: Arrivals


@dataclass(frozen=True, eq=False)
class Change:
    """A window that contradicts the stream: their intervals have no ratio in common.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio.
    window : Window
        The window.
    stream, part : Interval
        The interval of the whole stream until then, and that of the window.
    """

    quantity: Quantity
    window: Window
    stream: Interval
    part: Interval

    @property
    def confidence(self) -> Fraction:
        """One minus the probability that, for a constant ratio, the stream and a window up to this one ever contradict each other."""
        n = self.window.number
        return self.stream.confidence - n * n * (1 - self.part.confidence)

    @property
    def withdrawn(self) -> frozenset[Quantity]:
        """The ratios of which nothing is claimed any more: means that changed are behind both, the mix of contexts behind one."""
        return frozenset({"global"} if self.quantity == "global" and self.window.law.columns.context else {"local", "global"})


@dataclass(frozen=True)
class Tally:
    """How often each value was drawn in a cell, the values scaled to [0, 1].

    Examples
    --------
    >>> Tally({Fraction(0): 40, Fraction(1): 60}).draws
    100
    """

    counts: dict[Fraction, int] = field(hash=False)

    @property
    def draws(self) -> int:
        """Number of decisions."""
        return sum(self.counts.values())

    @cached_property
    def mean(self) -> Fraction:
        """Mean of the values."""
        return sum((x * n for x, n in self.counts.items()), Fraction(0)) / self.draws

    @cached_property
    def arrays(self) -> tuple[Floats, Floats]:
        """Values and counts in floats."""
        return np.array([float(x) for x in self.counts]), np.array([float(n) for n in self.counts.values()])

    def log_wealth(self, means: Floats, side: Side) -> Floats:
        """Logarithm of the wealth against each of some means, in floats."""
        x, n = self.arrays
        return log_wealth(x, n, means) if side == "above" else log_wealth(1 - x, n, 1 - means)


# The wealth


def log_wealth(values: Floats, counts: Floats, means: Floats) -> Floats:
    """Logarithm of the wealth against supposed means, in floats: for searching and simulations, not for conclusions.

    Parameters
    ----------
    values : ndarray, shape (values,)
        The different values, in [0, 1].
    counts : ndarray, shape (..., values)
        How often each was drawn.
    means : ndarray, shape (...)
        The supposed means, in [0, 1]; shapes are broadcast.

    Returns
    -------
    ndarray
        The logarithm of the mixture over bets: great where the draws say that the mean is above the supposed one.

    Examples
    --------
    >>> float(log_wealth(np.array([0.0, 1.0]), np.array([40.0, 60.0]), np.array(0.3)).round(3))
    15.066
    """
    p = np.asarray(means)[..., None]
    with np.errstate(divide="ignore"):
        bets = np.minimum(_LAMBDAS, float(CAP) / p)
    terms = np.broadcast_to(_LOG_SHARES, np.broadcast_shapes(bets.shape, (*counts.shape[:-1], 1))).copy()
    for k in range(len(values)):
        terms += counts[..., k, None] * np.log1p(bets * (values[k] - p))
    top = np.maximum(terms.max(axis=-1), _LOG_IDLE)
    return np.asarray(top + np.log(np.exp(terms - top[..., None]).sum(axis=-1) + np.exp(_LOG_IDLE - top)))


def wealth(tally: Tally, mean: Fraction, side: Side) -> Number:
    """Bound the wealth against a mean from below, in integers: (m, e) says at least m·2^e.

    Examples
    --------
    >>> m, e = wealth(Tally({Fraction(0): 40, Fraction(1): 60}), Fraction(3, 10), "above")
    >>> round(log(m * 2**e), 3)
    15.066
    """
    if not (mean > 0 if side == "above" else mean < 1):
        raise ValueError("a mean at the end of the range cannot be tested")
    draws = [(x if side == "above" else 1 - x, n) for x, n in tally.counts.items() if n]
    p = mean if side == "above" else 1 - mean
    cap = CAP / p
    parts: list[Number] = [_number(IDLE)]
    capped = Fraction(0)
    for i, share in zip(BETS, SHARES, strict=True):
        bet = Fraction(2) ** i
        if bet >= cap:
            capped += share
        else:
            parts.append(_bet(draws, p, bet, share))
    if capped:
        parts.append(_bet(draws, p, cap, capped))
    return _sum(parts)


def wealth_reaches(parts: Sequence[Number], level: Fraction) -> bool:
    """Whether the product of wealths is at least 1/level."""
    product: Number = (level.numerator, 0)
    for m, e in parts:
        product = product[0] * m, product[1] + e
    m, e = product
    return m << e >= level.denominator if e >= 0 else m >= level.denominator << -e


def _bet(draws: Sequence[tuple[Fraction, int]], p: Fraction, bet: Fraction, share: Fraction) -> Number:
    total = _number(share)
    for x, n in draws:
        total = _times(total, _power(_number(1 + bet * (x - p)), n))
    return total


def _number(value: Fraction) -> Number:
    shift = BITS - value.numerator.bit_length() + value.denominator.bit_length()
    return _cut((value.numerator << shift) // value.denominator if shift >= 0 else value.numerator // (value.denominator << -shift), -shift)


def _cut(m: int, e: int) -> Number:
    drop = max(0, m.bit_length() - BITS)
    return m >> drop, e + drop


def _times(a: Number, b: Number) -> Number:
    return _cut(a[0] * b[0], a[1] + b[1])


def _power(base: Number, exponent: int) -> Number:
    result: Number = (1, 0)
    while exponent:
        if exponent & 1:
            result = _times(result, base)
        base = _times(base, base)
        exponent >>= 1
    return result


def _sum(parts: Sequence[Number]) -> Number:
    top = max(m.bit_length() + e for m, e in parts)
    at = top - 2 * BITS
    return sum(m << (e - at) if e >= at else m >> (at - e) for m, e in parts), at


# Cells of a stream, and their levels


def tallies(law: Law, utility: UtilityTable, limits: tuple[Fraction, Fraction], quantity: Quantity) -> list[list[tuple[Any, Tally]]]:
    """Blocks of cells that are compared, each with its label: for the local ratio by context, for the global one the groups.

    Raises
    ------
    InputError
        If a utility lies outside the limits.
    """
    low, high = limits
    found: dict[tuple[Label, Label], Counter[Fraction]] = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        counts: Counter[Fraction] = Counter()
        for n, g in zip(law.row(cell), utility.row(cell), strict=True):
            if n:
                value = Fraction(g, utility.scale)
                if not low <= value <= high:
                    raise InputError(f"a utility of {value} was recorded, outside the declared limits {low} and {high}")
                counts[(value - low) / (high - low) if high > low else Fraction(0)] += n // law.scale
        found[law.contexts[x], law.groups[a]] = counts
    if quantity == "global":
        pooled: dict[Label, Counter[Fraction]] = {law.groups[a]: Counter() for a in law.global_groups}
        for (_, group), counts in found.items():
            pooled[group].update(counts)
        return [[(group, Tally(dict(counts))) for group, counts in pooled.items()]] if pooled else []
    blocks: dict[Label, list[tuple[Any, Tally]]] = {}
    for (context, group), counts in found.items():
        blocks.setdefault(context, []).append(((context, group), Tally(dict(counts))))
    return [block for block in blocks.values() if len(block) > 1]


def weight(rank: int, expected: int) -> Fraction:
    """K/((j + K − 1)(j + K)): what the j-th to appear gets of the budget.

    Examples
    --------
    >>> [str(weight(j, 1)) for j in (1, 2, 3)], sum(weight(j, 4) for j in range(1, 10_000)) < 1
    (['1/2', '1/6', '1/12'], True)
    """
    return Fraction(expected, (rank + expected - 1) * (rank + expected))


def pair_levels(ranks: Sequence[Sequence[int]], expected: int, alpha: Fraction) -> list[dict[frozenset[int], Fraction]]:
    """Level of each unordered pair of a block, for either direction; `ranks` are those of first appearance, by block.

    The cells that found others of their block are counted in order, j = 1, 2, …; the j-th shares α·weight(j) among the two directions
    of its pairs with those that it found.
    """
    later = sorted(rank for block in ranks for rank in block if rank > min(block))
    place = {rank: j for j, rank in enumerate(later, 1)}
    levels = []
    for block in ranks:
        found: dict[frozenset[int], Fraction] = {}
        for b, rank in enumerate(block):
            earlier = [a for a, other in enumerate(block) if other < rank]
            for a in earlier:
                found[frozenset((a, b))] = alpha * weight(place[rank], -(-expected // 2)) / (2 * len(earlier))
        levels.append(found)
    return levels


# The interval


def stream_interval(
    law: Law,
    utility: UtilityTable,
    arrivals: Arrivals,
    quantity: Quantity,
    limits: tuple[Fraction, Fraction],
    confidence: Any = "0.95",
    *,
    exact: bool = True,
) -> Interval:
    """Bound a ratio of the process behind a stream, at every moment at once.

    Parameters
    ----------
    law : Law
        What was counted so far.
    utility : UtilityTable
        The utility on it.
    arrivals : Arrivals
        The order in which its cells first appeared.
    quantity : {"local", "global"}
        The worst ratio within a context, or that of the means of groups over all their decisions.
    limits : pair of Fraction
        The range of the utility, fixed in advance.
    confidence : number or str
        The probability that the interval is right at every moment.
    exact : bool
        Whether to prove the ends in integers and keep the evidence. Without, they are estimates in floats, for a display.

    Returns
    -------
    Interval
        The ends, with evidence as docs/certificate-monitor.md describes it.

    Raises
    ------
    InputError
        If nothing is compared, a utility lies outside the limits, or the order lacks a cell.

    Examples
    --------
    >>> from fairaudit import Utility
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> arrivals = Arrivals((((), ("f",)), ((), ("m",))))
    >>> found = stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "local", (Fraction(0), Fraction(1)))
    >>> round(float(found.lower), 2), round(float(found.upper), 2)
    (1.76, 6.19)
    """
    level = confidence_level(confidence)
    if quantity == "global" and not arrivals.joint and len(law.contexts) > 1:
        raise InputError(
            "a unit may have decisions with one group in several contexts, so the global ratio of a stream with units is not bounded"
        )
    blocks = tallies(law, utility, limits, quantity)
    if not any(len(block) > 1 for block in blocks):
        raise InputError("nothing is compared: no two groups have been seen together")
    order = _ranks(arrivals, quantity)
    try:
        ranks = [[order[label] for label, _ in block] for block in blocks]
    except KeyError as error:
        raise InputError(f"the order of arrival lacks {error.args[0]}") from None
    cells = [[tally for _, tally in block] for block in blocks]
    kind = _Product if arrivals.joint else _Box
    made = kind(cells, ranks, arrivals.expected, limits, 1 - level)
    lower, upper, evidence = made.prove() if exact else (*made.estimate(), {})
    assumptions = (PAST if arrivals.joint else OWN_PAST, *((MIX,) if quantity == "global" else ()), ORDER, _range(limits), DECLARED)
    means = _means(blocks, limits)
    estimate = max(quotient(max(block), min(block)) for block in means)
    evidence = {
        "confidence": _text(level),
        "side": "both",
        "region": "product" if arrivals.joint else "box",
        "independent": False,
        "method": "betting",
        "limits": [_text(limit) for limit in limits],
        "levels": {"expected": arrivals.expected, "order": [rank for block in ranks for rank in block]},
        **evidence,
    }
    region: Literal["product", "box"] = "product" if arrivals.joint else "box"
    pairs = _named(law, quantity, blocks, means, made.places)
    return Interval(lower, upper, estimate, level, region, ("betting",), (*assumptions, *law.assumptions), evidence, pairs)


def stream_drivers(
    law: Law, utility: UtilityTable, quantity: Quantity, evidence: Mapping[str, Any]
) -> tuple[Witness | None, Witness | None]:
    """Name the pairs that drive the lower and the upper end of an interval that a certificate stores, as `stream_interval` names them.

    Parameters
    ----------
    law : Law
        What was counted.
    utility : UtilityTable
        The utility on it.
    quantity : {"local", "global"}
        Which ratio is bounded.
    evidence : mapping
        The interval in the certificate.
    """
    limits = (Fraction(evidence["limits"][0]), Fraction(evidence["limits"][1]))
    blocks = tallies(law, utility, limits, quantity)
    order = iter(evidence["levels"]["order"])
    ranks = [[next(order) for _ in block] for block in blocks]
    kind = _Product if evidence["region"] == "product" else _Box
    cells = [[tally for _, tally in block] for block in blocks]
    made = kind(cells, ranks, evidence["levels"]["expected"], limits, 1 - Fraction(evidence["confidence"]))
    return _named(law, quantity, blocks, _means(blocks, limits), made.places_of(evidence))


def _means(blocks: Sequence[Sequence[tuple[Any, Tally]]], limits: tuple[Fraction, Fraction]) -> list[list[Fraction]]:
    return [[limits[0] + (limits[1] - limits[0]) * tally.mean for _, tally in block] for block in blocks]


def _named(
    law: Law, quantity: Quantity, blocks: Sequence[Sequence[tuple[Any, Tally]]], means: Sequence[Sequence[Fraction]], places: Places
) -> tuple[Witness | None, Witness | None]:
    """The pairs at these places, with their labels and means."""

    def witness(at: Sequence[int] | None) -> Witness | None:
        if at is None:
            return None
        b, i, j = at
        labels = [blocks[b][k][0] for k in (i, j)]
        groups = labels if quantity == "global" else [group for _, group in labels]
        higher, lower = (dict(zip(law.columns.group, group, strict=True)) for group in groups)
        context = None if quantity == "global" else dict(zip(law.columns.context, labels[0][0], strict=True))
        return Witness(context, higher, lower, (means[b][i], means[b][j]))

    return witness(places[0]), witness(places[1])


def change_of(stream: Interval, window: Window, quantity: Quantity, limits: tuple[Fraction, Fraction]) -> Change:
    """Prove that a window contradicts the stream.

    Raises
    ------
    InputError
        If their intervals have a ratio in common.
    """
    level = 1 - (1 - stream.confidence) / (window.number * (window.number + 1))
    part = stream_interval(window.law, window.utility, window.arrivals, quantity, limits, level)
    if not (stream.upper < part.lower or part.upper < stream.lower):
        raise InputError(f"window {window.number} does not contradict the stream: their intervals of the {quantity} ratio overlap")
    return Change(quantity, window, stream, part)


def _ranks(arrivals: Arrivals, quantity: Quantity) -> dict[Any, int]:
    if quantity == "local":
        return {cell: j for j, cell in enumerate(arrivals.order, 1)}
    return {group: j for j, group in enumerate(dict.fromkeys(group for _, group in arrivals.order), 1)}


def _range(limits: tuple[Fraction, Fraction]) -> str:
    low, high = limits
    return f"whatever could have been drawn has a utility between {_text(low)} and {_text(high)}"


def _text(value: Fraction | float) -> str:
    return rational_text((value.numerator, value.denominator) if isinstance(value, Fraction) else (1, 0))


class _Box:
    """Ends of every cell by itself: nothing is assumed of cells together."""

    places: Places = (None, None)

    def __init__(
        self, cells: list[list[Tally]], ranks: list[list[int]], expected: int, limits: tuple[Fraction, Fraction], alpha: Fraction
    ) -> None:
        self.cells, self.limits = cells, limits
        self.levels = [[alpha * weight(rank, expected) / 2 for rank in block] for block in ranks]

    def _ends(self, *, exact: bool) -> list[list[tuple[Fraction, Fraction]]]:
        low, high = self.limits
        found = []
        for block, levels in zip(self.cells, self.levels, strict=True):
            unit = [
                (_end(cell, level, "above", exact), _end(cell, level, "below", exact)) for cell, level in zip(block, levels, strict=True)
            ]
            found.append([(low + (high - low) * a, low + (high - low) * b) for a, b in unit])
        return found

    def _ratios(self, ends: list[list[tuple[Fraction, Fraction]]]) -> tuple[Fraction, Fraction | float, list[int] | None]:
        lower, pair, outer = Fraction(1), None, None
        means = [[low + (high - low) * cell.mean for cell in block] for low, high in [self.limits] for block in self.cells]
        unequal: Fraction | float = 0
        greatest: Fraction | float = Fraction(1)
        for b, block in enumerate(ends):
            for i, j in permutations(range(len(block)), 2):
                most, apart = quotient(block[i][1], block[j][0]), quotient(means[b][i], means[b][j])
                if most > greatest or (most == greatest == inf and apart > unequal):
                    greatest, outer, unequal = most, [b, i, j], apart
                least = block[i][0] / block[j][1] if block[j][1] else Fraction(0)
                if least > lower:
                    lower, pair = least, [b, i, j]
        self.places = pair, outer
        return lower, greatest, pair

    def places_of(self, evidence: Mapping[str, Any]) -> Places:
        """Where the pairs behind both ends are that a certificate stores."""
        listed = iter([(Fraction(a), Fraction(b)) for a, b in evidence["upper"]])
        self._ratios([[next(listed) for _ in block] for block in self.cells])
        return evidence["pair"], self.places[1]

    def estimate(self) -> tuple[Fraction, Fraction | float]:
        return self._ratios(self._ends(exact=False))[:2]

    def prove(self) -> tuple[Fraction, Fraction | float, dict[str, Any]]:
        ends = self._ends(exact=True)
        lower, upper, pair = self._ratios(ends)
        listed = [[_text(a), _text(b)] for block in ends for a, b in block]
        return lower, upper, {"upper": listed, "lower": listed, "pair": pair}


def _end(tally: Tally, level: Fraction, side: Side, exact: bool) -> Fraction:
    """The outermost mean that is excluded: too low a one ("above") or too high ("below")."""
    if side == "below":
        return 1 - _end(Tally({1 - x: n for x, n in tally.counts.items()}), level, "above", exact)
    if not tally.mean:
        return Fraction(0)
    need = -log(float(level)) + 1e-9
    guess = _solve(tally, need)
    scale = 10 ** (DIGITS - 1 + max(0, ceil(-log10(guess)))) if guess > 0 else 1
    at = floor(Fraction(guess) * scale)
    for step in (1, 10, 1000, 10**5):
        if at <= 0:
            return Fraction(0)
        if not exact or wealth_reaches([wealth(tally, Fraction(at, scale), "above")], level):
            return Fraction(at, scale)
        at -= step
    return Fraction(0)


def _solve(tally: Tally, need: float) -> float:
    """The greatest mean against which the logarithm of the wealth is at least `need`."""
    low, high = 0.0, float(tally.mean)
    x, n = tally.arrays
    # Several points at once shrink the bracket by a factor of 32 in each round; the first rounds are logarithmic, for small means.
    low = 1e-300
    for _ in range(12):
        points = np.exp(np.linspace(log(low), log(high), 33)) if high > 1.5 * low else np.linspace(low, high, 33)
        reached = log_wealth(x, n, points) >= need
        if not reached[0]:
            return 0.0
        last = int(np.flatnonzero(reached)[-1])
        if last == 32:
            return high
        low, high = float(points[last]), float(points[last + 1])
    return low


class _Product:
    """Products of the wealths of two cells: narrower, for cells that are a martingale together."""

    places: Places = (None, None)

    def __init__(
        self, cells: list[list[Tally]], ranks: list[list[int]], expected: int, limits: tuple[Fraction, Fraction], alpha: Fraction
    ) -> None:
        self.cells, self.limits = cells, limits
        self.levels = pair_levels(ranks, expected, alpha)
        self.low, self.width = float(limits[0]), float(limits[1] - limits[0])
        self.curves = [
            [_Curves(cell, max(-log(float(v)) for k, v in levels.items() if i in k) - _LOG_IDLE + 1) for i, cell in enumerate(block)]
            for block, levels in zip(cells, self.levels, strict=True)
        ]

    def estimate(self) -> tuple[Fraction, Fraction | float]:
        lower, pair = self._lower()
        upper, outer = self._upper()
        self.places = pair, outer
        return Fraction(lower), Fraction(upper) if upper < inf else inf

    def places_of(self, evidence: Mapping[str, Any]) -> Places:
        """Where the pairs behind both ends are that a certificate stores."""
        return None if evidence["lower"] is None else evidence["lower"]["pair"], self._upper()[1]

    def _theta(self, block: int, i: int, j: int) -> float:
        return -log(float(self.levels[block][frozenset((i, j))]))

    def _mean(self, unit: Any) -> Any:
        return self.low + self.width * unit

    def _unit(self, mean: Any) -> Any:
        return np.clip((mean - self.low) / self.width, 0, 1) if self.width else np.zeros_like(mean)

    def _upper(self) -> tuple[float, tuple[int, int, int] | None]:
        """Least r such that μ_i ≤ r·μ_j is proved for all pairs, at least 1, and the block, i and j that need it."""
        tried = []
        for b, curves in enumerate(self.curves):
            for i, j in permutations(range(len(curves)), 2):
                top, bottom = self._mean(curves[i].end), self._mean(curves[j].start)
                high, low = self._mean(curves[i].mean), self._mean(curves[j].mean)
                tried.append((-top / bottom if bottom > 0 else -inf, -high / low if low > 0 else -inf if high > 0 else -1.0, b, i, j))
        best, where = 1.0, None
        for most, _, b, i, j in sorted(tried):
            if -most <= best:
                break
            found = self._least(b, i, j)
            if found > best:
                best, where = found, (b, i, j)
        return best, where

    def _lower(self) -> tuple[float, tuple[int, int, int] | None]:
        """Greatest proved R with μ_j ≥ R·μ_i, and the block, the higher j and the lower i."""
        tried = []
        for b, curves in enumerate(self.curves):
            for i, j in permutations(range(len(curves)), 2):
                low, high = self._mean(curves[i].mean), self._mean(curves[j].mean)
                if high > low and self._mean(curves[j].start) > 0:
                    tried.append((low / high, b, i, j))
        best, where = 1.0, None
        for least, b, i, j in sorted(tried):
            if least >= best:
                break
            if self._feasible(b, i, j, best):
                found = self._least(b, i, j)
                if found < best:
                    best, where = found, (b, j, i)
        return 1 / best, where

    def _feasible(self, b: int, i: int, j: int, r: float) -> bool:
        """Whether μ_i ≤ r·μ_j is proved, in floats."""
        top, bottom = self.curves[b][i], self.curves[b][j]
        first, last = self._mean(bottom.start), min(self._mean(top.end), self.low + self.width) / r
        if first <= self.low and first > 0:
            first = self.low
        if first <= 0:
            return False
        if first >= last:
            return True
        q = np.concatenate([self._mean(bottom.grid), self._mean(top.grid) / r, [first, last]])
        q = q[(q >= first) & (q <= last)]
        total = top.below(self._unit(r * q)) + bottom.above(self._unit(q))
        return bool(total.min() >= self._theta(b, i, j) + SLACK)

    def _least(self, b: int, i: int, j: int) -> float:
        top, bottom = self.curves[b][i], self.curves[b][j]
        if self._mean(bottom.start) <= 0:
            return inf
        high = self._mean(top.end) / self._mean(bottom.start)
        low = max(self._mean(top.mean) / self._mean(bottom.mean), high * 1e-12)
        if not self._feasible(b, i, j, high):
            return inf
        while high > low * (1 + 1e-9):
            middle = float((low * high) ** 0.5)
            low, high = (low, middle) if self._feasible(b, i, j, middle) else (middle, high)
        return float(high)

    def prove(self) -> tuple[Fraction, Fraction | float, dict[str, Any]]:
        upper, ladders, outer = self._prove_upper()
        lower, proof = self._prove_lower()
        self.places = None if proof is None else proof["pair"], outer
        return lower, upper, {"upper": ladders, "lower": proof}

    def _prove_upper(self) -> tuple[Fraction | float, list[list[str]] | None, tuple[int, int, int] | None]:
        ratio, where = self._upper()
        for attempt in range(8):
            if ratio == inf:
                break
            exact = max(Fraction(1), _rounded(ratio, up=True))
            ladders = []
            for b, curves in enumerate(self.curves):
                every = range(len(curves))
                ladder = self._ladder(b, every, every, exact)
                if ladder is None:
                    break
                ladders.append([_text(knot) for knot in ladder])
            else:
                return exact, ladders, where
            ratio *= 1 + 0.002 * 2**attempt
        return inf, None, where

    def _prove_lower(self) -> tuple[Fraction, dict[str, Any] | None]:
        ratio, where = self._lower()
        for attempt in range(8):
            exact = _rounded(ratio, up=False)
            if where is None or exact <= 1:
                break
            b, higher, lower = where
            ladder = self._ladder(b, [lower], [higher], 1 / exact)
            if ladder is not None:
                return exact, {"pair": [b, higher, lower], "knots": [_text(knot) for knot in ladder]}
            ratio /= 1 + 0.002 * 2**attempt
        return Fraction(1), None

    def _ladder(self, b: int, tops: Sequence[int], bottoms: Sequence[int], ratio: Fraction) -> list[Fraction] | None:
        """Knots that prove μ_i ≤ ratio·μ_j for all different tops i and bottoms j, or None; found in floats, proved in integers."""
        curves, r = self.curves[b], float(ratio)
        low, high = self.limits
        pairs = [(i, j) for i in tops for j in bottoms if i != j]
        need = {(i, j): self._theta(b, i, j) + ROUNDING for i, j in pairs}
        start = max(self.low, min(self._mean(curves[j].above_inverse(need[i, j] - _LOG_IDLE)) for i, j in pairs))
        if start <= 0:
            return None
        knots = [_rounded(start, up=False)] if start > self.low else [low]
        if knots[0] <= 0:
            return None
        while len(knots) < MAX_KNOTS:
            reach = r * float(knots[-1])
            if knots[-1] >= high or ratio * knots[-1] >= high:
                break
            below = {i: float(curves[i].below(self._unit(np.array(reach)))) for i in {i for i, _ in pairs}}
            if all(below[i] + _LOG_IDLE >= need[i, j] for i, j in pairs):
                break
            further = min(self._mean(curves[j].above_inverse(need[i, j] - below[i])) for i, j in pairs)
            knot = high if further >= float(high) else _rounded(further, up=False, digits=10)
            if knot <= knots[-1]:
                return None
            knots.append(knot)
        else:
            return None
        return knots if self._holds(b, pairs, knots, ratio) else None

    def _holds(self, b: int, pairs: Sequence[tuple[int, int]], knots: Sequence[Fraction], ratio: Fraction) -> bool:
        low, high = self.limits
        idle = _number(IDLE)
        levels = self.levels[b]

        def below(i: int, mean: Fraction) -> Number | None:
            """Wealth of a top against a mean; None if its mean cannot be so great."""
            return None if mean >= high else idle if mean <= low else wealth(self.cells[b][i], (mean - low) / (high - low), "below")

        def above(j: int, mean: Fraction) -> Number:
            return idle if mean <= low else wealth(self.cells[b][j], (mean - low) / (high - low), "above")

        tops, bottoms = sorted({i for i, _ in pairs}), sorted({j for _, j in pairs})
        before: list[tuple[Fraction | None, Fraction | None]] = [(None, knots[0])]
        before += pairwise(knots)
        before.append((knots[-1], None))
        for p, q in before:
            if (p is None and q is not None and q <= low) or (q is None and p is not None and p >= high):
                continue
            ups = {i: idle if p is None else below(i, ratio * p) for i in tops}
            downs = {j: idle if q is None else above(j, q) for j in bottoms}
            for i, j in pairs:
                one = ups[i]
                if one is not None and not wealth_reaches([one, downs[j]], levels[frozenset((i, j))]):
                    return False
        return True


class _Curves:
    """The logarithms of both wealths of a cell on a grid of means, in floats."""

    def __init__(self, tally: Tally, need: float) -> None:
        self.mean = float(tally.mean)
        mirrored = Tally({1 - x: n for x, n in tally.counts.items()})
        self.start = _solve(tally, need) if self.mean > 0 else 0.0
        self.end = 1 - _solve(mirrored, need) if self.mean < 1 else 1.0
        angles = np.linspace(np.arcsin(np.sqrt(self.start)), np.arcsin(np.sqrt(self.end)), POINTS)
        grid: Floats = np.unique(np.clip(np.sin(angles) ** 2, self.start, self.end))
        self.grid = grid
        self._above = np.minimum.accumulate(tally.log_wealth(grid, "above"))
        self._below = np.maximum.accumulate(tally.log_wealth(grid, "below"))

    def above(self, means: Floats) -> Floats:
        """Logarithm of the wealth that says the mean is above these; a lower bound outside the grid."""
        found = np.interp(means, self.grid, self._above)
        return np.where(means > self.grid[-1], _LOG_IDLE, found)

    def below(self, means: Floats) -> Floats:
        """Logarithm of the wealth that says the mean is below these."""
        found = np.interp(means, self.grid, self._below)
        return np.where(means < self.grid[0], _LOG_IDLE, found)

    def above_inverse(self, need: float) -> float:
        """The greatest mean at which `above` is at least `need`; the start of the grid if there is none."""
        return 1.0 if need <= _LOG_IDLE else float(np.interp(need, self._above[::-1], self.grid[::-1]))


def _rounded(value: float, *, up: bool, digits: int = DIGITS) -> Fraction:
    """A decimal of some digits on the stated side of a positive number."""
    scale = Fraction(10) ** (digits - 1 - floor(log10(value)))
    scaled = Fraction(value) * scale
    return Fraction(ceil(scaled) if up else floor(scaled)) / scale
