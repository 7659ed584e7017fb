"""How an error budget is split: every split of a confidence among statements that are to hold together stands here.

Each function keeps one inequality, named in its docstring, so that the errors of all statements add up to α = 1 − confidence at most;
tests check each exactly.

Of a ratio bounded from the ends of cells, let K be the number of cells with draws, s the greatest number of them in the two forms of one
compared pair, and [lo, hi] the ends of a cell.

* *Upper end.* Let the pair attain R (it is unknown, but does not depend on the draws) and let w, v be its weights. Each cell needs
  one end only: hi where w > R·v, lo where w < R·v. If these s ends hold, the greatest quotient of this pair over the box is at least
  R. So s ends of level β suffice, however many cells there are.
* *Lower end.* The pair that gives the greatest lower end does depend on the draws, so all 2K ends, of level β', have to hold. With
  β' ≤ β the s ends above are among them.
* *Both* hold with probability at least 1 − s·β − (2K − s)·β' by the union bound, which asks for no independence between cells. With
  independent cells (1 − β − β')^s·(1 − 2β')^(K − s) is enough. Always s·β = (2K − s)·β', so that nobody can choose β after the draws.
* *Each* by itself: the upper end fails with probability at most s·β, with independent cells (1 − β)^s is its chance; the lower one, which
  has nothing to share with it then, fails with at most 2K·β', and (1 − 2β')^K is its chance.

Cells of a stream that appear late share a budget that was set aside for them: the weights K/((j + K − 1)(j + K)), j = 1, 2, …, sum
to 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import ceil, floor, log, log1p
from typing import Any, Literal

from fairaudit.errors import InputError, shown
from fairaudit.exact.enclosures import log_fixed
from fairaudit.exact.rationals import option_value
from fairaudit.inference.rounding import BITS

Holding = Literal["together", "each", "lower", "upper"]
"""How an error is spent on the ends of an interval: on both together, on each by itself, or on one alone, the other being trivial."""

PairLevels = list[dict[frozenset[int], Fraction]]
"""By blocks, the level of each unordered pair of cells."""

SIDAK_CELLS = 2_000  # powers of exact levels grow with the cells, and at 95 % gain a fortieth of a level: with more cells the union bound

GUARD = Fraction(4, 5)
"""The part of an error that guards single cells; the rest is for products of tails.

With 1/2 the upper end of three cells of 100 draws is 2 % lower, that of one cell of 20 draws beside two of 1,000 is 10 % higher; with 19/20
it is the other way round, by 3 % each."""


def confidence_level(value: Any) -> Fraction:
    """Read a confidence in (0, 1); a float is the decimal that it is printed as."""
    try:
        level = Fraction(*option_value(value))
    except InputError as error:
        raise InputError(f"confidence: {error}") from None
    if not 0 < level < 1:
        raise InputError(f"a confidence of {shown(value)} is not accepted; it lies between 0 and 1, such as 0.95")
    return level


def equal_share(alpha: Fraction, statements: int) -> Fraction:
    """Error of each of some statements that are to hold together, or of a single one: statements·share ≤ α.

    Examples
    --------
    >>> equal_share(Fraction(1, 20), 2), equal_share(Fraction(1, 20), 0)
    (Fraction(1, 40), Fraction(1, 20))
    """
    return alpha / max(1, statements)


# The ends of cells


def box_levels(cells: int, span: int, alpha: Fraction, *, independent: bool, ends: Holding = "together") -> tuple[Fraction, Fraction]:
    """Levels β and β' of one end of a cell, for the upper and for the lower end of the ratio; 0 for an end that was not asked for.

    Together s·β + (2K − s)·β' ≤ α, or, of independent cells, (1 − β − β')^s·(1 − 2β')^(K − s) ≥ 1 − α. An upper end by itself s·β ≤ α or
    (1 − β)^s ≥ 1 − α, a lower one 2K·β' ≤ α or (1 − 2β')^K ≥ 1 − α. No level is above 1/2, beyond which the ends of a cell would cross.

    Examples
    --------
    >>> box_levels(4, 2, Fraction(1, 20), independent=False)
    (Fraction(1, 80), Fraction(1, 240))
    >>> box_levels(4, 2, Fraction(1, 20), independent=False, ends="each")
    (Fraction(1, 40), Fraction(1, 160))
    """
    if not cells:
        return Fraction(0), Fraction(0)
    if ends == "each":
        upper, _ = box_levels(cells, span, alpha, independent=independent, ends="upper")
        _, lower = box_levels(cells, span, alpha, independent=independent, ends="lower")
        return upper, lower
    share = alpha / 2 if ends == "together" else alpha
    upper = min(share / span, Fraction(1, 2)) if ends != "lower" else Fraction(0)
    lower = share / (2 * cells - span if ends == "together" else 2 * cells) if ends != "upper" else Fraction(0)
    if not independent or cells > SIDAK_CELLS:
        return upper, lower
    # Scale both levels by the greatest factor that the product of the cells' chances allows.
    span = 0 if ends == "lower" else span
    low, high = 1.0, 2.0
    rate, rest = float(upper + lower), float(2 * lower)
    goal = log1p(-float(alpha))
    for _ in range(60):
        middle = (low + high) / 2
        fits = middle * max(rate, rest) < 1 and span * log1p(-middle * rate) + (cells - span) * log1p(-middle * rest) >= goal
        low, high = (middle, high) if fits else (low, middle)
    factor = min(Fraction(floor(low * 10**9) - 1, 10**9), 1 / (2 * max(upper, lower)))
    if factor <= 1 or not _independent_levels(cells, span, alpha, upper * factor, lower * factor):
        return upper, lower
    return upper * factor, lower * factor


def _independent_levels(cells: int, span: int, alpha: Fraction, upper: Fraction, lower: Fraction) -> bool:
    return (1 - upper - lower) ** span * (1 - 2 * lower) ** (cells - span) >= 1 - alpha


def pair_errors(pairs: int, alpha: Fraction, ends: Holding) -> tuple[Fraction | None, Fraction | None]:
    """The error of the upper end of each of M ordered pairs, and of each lower end; None for an end that was not asked for.

    The pair that attains R is one, so that its upper end may err with all of an end's error; the pair that proves the lower end depends on
    the draws, so that M lower ends share it. Both ends share α if they are to hold together.

    Examples
    --------
    >>> pair_errors(2, Fraction(1, 20), "each"), pair_errors(2, Fraction(1, 20), "together")
    ((Fraction(1, 20), Fraction(1, 40)), (Fraction(1, 40), Fraction(1, 80)))
    """
    share = alpha / 2 if ends == "together" else alpha
    return None if ends == "lower" else share, None if ends == "upper" else share / pairs


@dataclass(frozen=True)
class _ProductLevels:
    """b, c for the upper end and b', c' for the lower end."""

    upper: tuple[Fraction, Fraction] | None
    lower: tuple[Fraction, Fraction] | None


@lru_cache(maxsize=1_000)
def product_levels(cells: int, pairs: int, alpha: Fraction, ends: Holding) -> _ProductLevels:
    """Split an error between the guards and the products of tails.

    2b + (2K − 2)·b' + f(b, c) + (M − 1)·f(b', c') ≤ α with b' ≤ b and c' ≤ c; an upper end by itself 2b + f(b, c) ≤ α, a lower one by
    itself 2K·b' + M·f(b', c') ≤ α; f is `product_area`, M the number of ordered pairs. With K = 1 two ends count in the place of 2K − 2.
    """
    together = ends == "together"
    share = alpha / 2 if together else alpha
    upper = lower = None
    if ends != "lower":
        upper = _with_product(GUARD * share / 2, (1 - GUARD) * share)
    if ends != "upper":
        guards = max(2, 2 * cells - 2) if together else 2 * cells
        lower = _with_product(GUARD * share / guards, (1 - GUARD) * share / (pairs - 1 if together else pairs))
    if together and upper and lower:
        lower = (lower[0], min(lower[1], upper[1]))
    return _ProductLevels(upper, lower)


def _with_product(guard: Fraction, budget: Fraction) -> tuple[Fraction, Fraction]:
    """The guard b rounded down, and the greatest c, of about six digits, with c·log(c/b²) − c + b² ≤ budget."""
    guard = _rounded_down(guard)
    low, high = float(guard) ** 2, float(guard)
    for _ in range(100):
        middle = (low + high) / 2
        fits = middle * log(middle / float(guard) ** 2) - middle + float(guard) ** 2 <= float(budget)
        low, high = (middle, high) if fits else (low, middle)
    c = _rounded_down(Fraction(low))
    while c > guard**2 and product_area(guard, c) > budget:
        c -= c / 1_000
    return guard, max(c, guard**2)


def product_area(guard: Fraction, c: Fraction) -> Fraction:
    """Upper bound of the area where both tails exceed b and their product is at most c, for b² ≤ c ≤ b."""
    ratio = c / guard**2
    _, high = log_fixed(ratio.numerator, ratio.denominator, BITS)
    return c * Fraction(high, 1 << BITS) - c + guard**2


def _rounded_down(value: Fraction) -> Fraction:
    scale = 10 ** (6 + max(0, ceil(-log(value) / log(10))))
    return Fraction(value.numerator * scale // value.denominator, scale)


# Statements of a stream


def weight(rank: int, expected: int) -> Fraction:
    """K/((j + K − 1)(j + K)): what the j-th to appear gets of the budget. Σ_j weight(j) = 1, over any number of them less.

    Examples
    --------
    >>> [str(weight(j, 1)) for j in (1, 2, 3)], sum(weight(j, 4) for j in range(1, 10_000)) < 1
    (['1/2', '1/6', '1/12'], True)
    """
    return Fraction(expected, (rank + expected - 1) * (rank + expected))


def arrival_levels(ranks: Sequence[Sequence[int]], expected: int, alpha: Fraction) -> list[list[Fraction]]:
    """Level of each end of each cell of a stream, by blocks; `ranks` are those of first appearance: Σ 2·level ≤ α over all cells."""
    return [[equal_share(alpha * weight(rank, expected), 2) for rank in block] for block in ranks]


def pair_levels(ranks: Sequence[Sequence[int]], expected: int, alpha: Fraction) -> PairLevels:
    """Level of each unordered pair of a block, for either direction; `ranks` are those of first appearance, by block.

    The cells that found others of their block are counted in order, j = 1, 2, …; the j-th shares α·weight(j) among the two directions
    of its pairs with those that it found: Σ 2·level ≤ α over all pairs.
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


def window_share(number: int) -> Fraction:
    """The part of the error that the windows have together, which window 1, 2, … gets: 1/(i(i + 1)). Σ_i window_share(i) = 1."""
    return Fraction(1, number * (number + 1))


def constancy_error(stream: Fraction, window: Fraction, number: int) -> Fraction:
    """Error of the whole stream plus those of all windows up to this one, when a window's share is an error of `window`.

    Windows 1 … n have n/(n + 1) of what all windows have together, which is n² times what window n has.

    Examples
    --------
    >>> constancy_error(Fraction(1, 20), Fraction(1, 20) * window_share(2), 2) == Fraction(1, 20) * (1 + window_share(1) + window_share(2))
    True
    """
    return stream + number * number * window
