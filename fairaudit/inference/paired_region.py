"""Intervals of groups that were seen in the same units: every pair of groups by bets on its contrast within the units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import chain
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.exact.extended import Extended, extended_text
from fairaudit.exact.rationals import exact
from fairaudit.inference.cells import Profiles
from fairaudit.inference.comparisons import Comparison, Place
from fairaudit.inference.levels import Holding, equal_share
from fairaudit.theorems.assumptions import BY_DESIGN, DRAWS, ONE_ROW, PAIRED, UNITS

if TYPE_CHECKING:
    from fairaudit.inference.paired_betting import Contrasts


MOST_STEPS = 40_000_000
"""Of those that docs/certificate.md lets a document ask of its reader."""

TIE = 1e-9
"""Within which floats take what two pairs won for the same."""


def fits_units(comparison: Comparison) -> bool:
    """Whether groups are to be compared within units: enough units were seen in both groups of every pair.

    It depends on which units were seen where, and on no decision. A unit that is missing in one group of a pair counts as what is worst for
    the claim: that costs more than comparing within units gains where more units are missing than the square root of their number. Where
    units are missing by design, pairs leave them out: then they need half of the units of the smaller group.
    """
    if not comparison.profiles or not comparison.single or any(block_range(comparison, b) <= 0 for b, _ in enumerate(comparison.blocks)):
        return False
    from fairaudit.inference.paired_betting import bets

    steps = 0
    for profiles in comparison.profiles:
        total, groups = sum(profiles.values()), len(next(iter(profiles)))
        both = np.zeros((groups, groups), dtype=np.int64)
        for values, n in profiles.items():
            seen = np.array([value is not None for value in values])
            both += n * np.outer(seen, seen)
        alone = both.diagonal()
        smaller = np.minimum(alone[:, None], alone[None, :])
        enough = 2 * both >= smaller if comparison.missing == "drop" else (total - both) ** 2 <= total
        if not (enough & (both > 0)).all():
            return False
        different = {value for values in profiles for value in values}
        contrasts = min(len(profiles), len(different) ** 2)
        each = 2 * len(bets(Fraction(2 * total))) * (56 + 8 * (total // contrasts).bit_length())
        steps += groups * (groups - 1) * (contrasts * (each + 20) + 10 * len(profiles))
    return steps <= MOST_STEPS


def block_range(comparison: Comparison, block: int) -> Fraction:
    """The greatest utility that could have been drawn in a block; ratios have the origin 0."""
    return max(comparison.cells[form[0][0]].high for form in comparison.blocks[block])


def paired_interval(comparison: Comparison, alpha: Fraction, ends: Holding) -> tuple[Fraction, Extended, dict[str, Any]]:
    """Both ends of the ratio, from contrasts within units, with their evidence.

    The pair that attains R does not depend on the draws, so that the greatest of all upper ends needs no correction for many pairs; of the
    lower end what the bets on all pairs won is averaged, however units and contexts hang together.
    """
    pairs = _Pairs(comparison)
    share = equal_share(alpha, 2) if ends == "together" else alpha
    upper = inf if ends == "lower" else pairs.upper(share)
    lower = Fraction(1) if ends == "upper" else pairs.lower(share)
    levels = {name: None if ends == other else extended_text(share) for name, other in (("upper", "lower"), ("lower", "upper"))}
    return lower, upper, {"levels": levels, "missing": comparison.missing, "profiles": [*map(listed_profiles, comparison.profiles)]}


def paired_assumptions(comparison: Comparison) -> tuple[str, ...]:
    """What the reader must accept in the place of independent draws within a cell."""
    of_draws = (DRAWS, UNITS, ONE_ROW)
    design = (BY_DESIGN,) if comparison.missing == "drop" else ()
    return (PAIRED, *design, *(said for said in comparison.assumptions if said not in of_draws))


def listed_profiles(profiles: Profiles) -> list[list[Any]]:
    """Profiles as a certificate lists them, in the order of their values."""
    ordered = sorted(profiles.items(), key=lambda entry: tuple(-1 if value is None else value for value in entry[0]))
    return [[n, [None if value is None else extended_text(value) for value in values]] for values, n in ordered]


def read_profiles(listed: Sequence[Sequence[Sequence[Any]]]) -> tuple[Profiles, ...]:
    """Read the profiles of a certificate back.

    Examples
    --------
    >>> read_profiles([[[3, ["1", None]]]])
    ({(Fraction(1, 1), None): 3},)
    """
    known: dict[str | None, Fraction | None] = {None: None}
    for text in {text for block in listed for _, values in block for text in values if text is not None}:
        known[text] = exact(text)
    return tuple({tuple(known[text] for text in values): n for n, values in block} for block in listed)


def paired_drivers(comparison: Comparison, lower: Fraction, upper: Extended) -> tuple[Place | None, Place | None]:
    """The pair that won most by the lower end, and the one that won least by the upper end; None for an end of 1."""
    from fairaudit.inference.paired_betting import GREATEST

    pairs = _Pairs(comparison)
    first = last = None
    if lower > 1:
        won = pairs.won(1 / float(lower))
        b, i, j = comparison.places[int(np.flatnonzero(won >= won.max() - TIE)[0])]
        first = b, j, i
    if upper > 1:
        won = pairs.won(float(GREATEST if upper == inf else upper))
        last = comparison.places[int(np.flatnonzero(won <= won.min() + TIE)[0])]
    return first, last


@dataclass(frozen=True)
class _Pairs:
    """All ordered pairs of groups that are compared, with the contrasts of their units."""

    comparison: Comparison

    @cached_property
    def contrasts(self) -> list[Contrasts]:
        """Their contrasts."""
        from fairaudit.inference.paired_betting import ordered_pairs

        compared, drop = self.comparison, self.comparison.missing == "drop"
        ranges = [(Fraction(0), block_range(compared, b)) for b, _ in enumerate(compared.blocks)]
        listed = [ordered_pairs(profiles, limits, drop=drop) for profiles, limits in zip(compared.profiles, ranges, strict=True)]
        return [*chain.from_iterable(listed)]

    @cached_property
    def arrays(self) -> tuple[Floats, Floats, Floats, Any, Floats, Any]:
        """Values and counts of all pairs one after the other, where each begins, the bets, and which of them each pair makes."""
        x, y, n = (np.concatenate([pair.arrays[k] for pair in self.contrasts]) for k in range(3))
        starts = np.cumsum([0, *(len(pair.counts) for pair in self.contrasts[:-1])])
        numbers = np.array([len(pair.bets) for pair in self.contrasts])
        longest = max((pair.bets for pair in self.contrasts), key=len)
        made = np.arange(len(longest))[:, None] < numbers[None, :]
        return x, y, n, starts, np.array([float(bet) for bet in longest]), made

    def won(self, limit: float) -> Floats:
        """Logarithms of what the bets against E(x) ≥ limit·E(y) won, for all pairs, in floats."""
        x, y, n, starts, listed, made = self.arrays
        gain = limit * y - x
        each = np.array([np.add.reduceat(np.log1p(bet * gain) * n, starts) for bet in listed])
        each[~made] = -inf
        top = each.max(axis=0)
        found: Floats = top + np.log(np.exp(each - top).sum(axis=0) / made.sum(axis=0))
        return found

    def upper(self, level: Fraction) -> Extended:
        """The least limit below which the ratios of all pairs are proved to be."""
        from fairaudit.inference.paired_betting import is_below, least_limit

        def proved(limit: Fraction) -> bool:
            return all(is_below(pair, limit, level) for pair in self.contrasts)

        return max(least_limit(lambda limit: float(self.won(limit).min()), proved, level, "ratio"), Fraction(1))

    def lower(self, level: Fraction) -> Fraction:
        """The greatest limit above which the greatest ratio is proved to be, or 1."""
        from fairaudit.inference.paired_betting import greatest_limit, is_above, log_mean

        def proved(limit: Fraction) -> bool:
            return is_above(self.contrasts, limit, level)

        return greatest_limit(lambda limit: log_mean(self.won(limit)), proved, level, "ratio")
