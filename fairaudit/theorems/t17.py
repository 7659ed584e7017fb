"""T17: several fresh releases of the same group that one memory sees.

The filter of n releases is the n-fold product of the filter of one, so that T3, T4 and T13 hold of it exactly as they stand: what they ask
is the hockey-stick sums of its ordered pairs of rows, which `trade_offs.worst_pair_laws` counts by likelihood ratio, releases
included. Values do not decrease in n, since a policy may forget a release; so where a target breaks is found by bisection.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf
from typing import Any

from fairaudit.exact.extended import ONE, Extended
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.releases import MAX_RELEASES, check_releases
from fairaudit.privacy.columns import TooManyColumns
from fairaudit.privacy.pairs import PairLaw
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.theorems.assumptions import RELEASES
from fairaudit.theorems.bound import Bound
from fairaudit.theorems.constants import read_ratio
from fairaudit.theorems.t13_range import UtilityRange, least_ratio, least_ratio_above, read_utility_range, t13_range


def t17(mechanism: Mechanism, releases: int, *, gamma: Any = 1, m: Any = 0, gap: Any = 0, tau: Any = 0) -> Bound:
    """T17: the ratio of every policy that sees n fresh releases of the group, for every utility of a range; attained.

    Source: T17; Coq `T17_releases`, `T17_merged`, `T17_krr_classes`.

    Parameters
    ----------
    mechanism : Mechanism
        The group filter of one release.
    releases : int
        n, 1 to 10,000.
    gamma, m : number or str
        Greatest and least utility.
    gap : number or str
        K, the most by which the utilities of two groups differ for the same decision and context.
    tau : number or str
        A floor that every compared expected utility keeps; 0 for none.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range, or the releases have too many different likelihood ratios to be counted exactly.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="11/20")
    >>> [t17(coin, n, tau="3/10").value for n in (1, 2)]
    [Fraction(11, 9), Fraction(4, 3)]
    """
    declared = read_utility_range(gamma, m, gap, tau)
    bound = t13_range(((pair, declared) for pair in worst_pair_laws(mechanism, releases=releases)), floored=declared.tau > 0)
    said = (RELEASES.format(releases=releases),) if releases > 1 else ()
    return replace(bound, theorem="T17", assumptions=(*bound.assumptions, *said))


def t17_without_end(mechanism: Mechanism, *, gamma: Any = 1, m: Any = 0, gap: Any = 0, tau: Any = 0) -> Extended:
    """The least bound on the ratio that holds for any number of releases. Parameters and errors as in `t17`.

    Source: T17; Coq `T17_monotone`, `T17_monotone_hockey_stick`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> t17_without_end(RandomizedResponse(["a", "b"], keep_probability="11/20"), tau="3/10")
    Fraction(10, 3)
    """
    return _without_end(mechanism, read_utility_range(gamma, m, gap, tau))


@dataclass(frozen=True)
class LastRelease:
    """Up to how many releases a target holds.

    Attributes
    ----------
    releases : int or inf
        The greatest n at which the ratio of every policy is at most the target; 0 if one release breaks it, `math.inf` if none does.
    exact : bool
        Whether the next one breaks it; otherwise it was not counted, and the target may hold for more.
    """

    releases: int | float
    exact: bool


def last_release(
    mechanism: Mechanism, max_ratio: Any, *, gamma: Any = 1, m: Any = 0, gap: Any = 0, tau: Any = 0, most: int = MAX_RELEASES
) -> LastRelease:
    """The greatest number of releases at which every policy keeps a target.

    Source: T17.

    Parameters
    ----------
    mechanism, gamma, m, gap, tau
        As in `t17`.
    max_ratio : number or str
        The greatest ratio that is accepted, at least 1.
    most : int
        How far to look.

    Raises
    ------
    InputError
        As `t17`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="11/20")
    >>> last_release(coin, 2, tau="3/10")
    LastRelease(releases=15, exact=True)
    """
    declared, target = read_utility_range(gamma, m, gap, tau), read_ratio("max_ratio", max_ratio)
    check_releases(most)
    if _without_end(mechanism, declared) <= target:
        return LastRelease(inf, True)
    holds, breaks = 0, most + 1
    try:
        while breaks - holds > 1:
            middle = min(max(1, 2 * holds), most) if breaks > most else (holds + breaks) // 2
            if _greatest(worst_pair_laws(mechanism, releases=middle), declared) <= target:
                holds = middle
            else:
                breaks = middle
    except TooManyColumns:
        return LastRelease(holds, False)
    return LastRelease(holds, breaks <= most)


def _without_end(mechanism: Mechanism, declared: UtilityRange) -> Extended:
    """What ever more releases approach: rows that differ are told apart in the end."""
    apart = ((1, 0), (0, 1))
    pairs = (pair if len(pair.columns) == 1 else PairLaw(apart, 1, pair.first, pair.second) for pair in worst_pair_laws(mechanism))
    return _greatest(pairs, declared)


def _greatest(pairs: Iterable[PairLaw], declared: UtilityRange) -> Extended:
    """The greatest ratio over pairs of rows, behind the floor if there is one."""
    above = declared.tau > declared.m
    return max((least_ratio_above(pair, declared)[0] if above else least_ratio(pair, declared) for pair in pairs), default=ONE)
