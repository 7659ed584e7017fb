"""T4: utilities in [m, γ] with m above 0, for every policy."""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.rationals import at_least
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.pairs import PairLaw, hockey_stick
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.theorems.assumptions import FRESH, GROUP_FREE
from fairaudit.theorems.bound import Bound, Floor, floor_terms
from fairaudit.theorems.case import Case
from fairaudit.theorems.constants import read_range
from fairaudit.theorems.one_k import worst_pair

# T4: utility with a floor of its own


def t4(mechanism: Mechanism, gamma: Any, g_min: Any, tau: Any = None, *, floor: Floor = "table") -> Bound:
    """T4: utilities in [m, γ] with m > 0. R ≤ the least over k of k + max(0, (γ−m)·H_k − (k−1)·m)/τ, greatest over ordered pairs.

    That is the greatest (m + (γ−m)(1−f(s)))/(m + (γ−m)s) over s ≥ (τ−m)/(γ−m), exactly. Waiting times and positions are such utilities.

    Source: T4; Coq `T4_one_k`, `T4_any_policy`, `T4_certificate_exact`.

    Parameters
    ----------
    mechanism : Mechanism
        The group filter.
    gamma, g_min : number or str
        Greatest and least utility, 0 ≤ m ≤ γ, γ > 0.
    tau : number or str, optional
        Floor under every compared expected utility, m ≤ τ ≤ γ. Left out it is m, and the bound holds for every policy.
    floor : {"table", "declared", "policy"}
        As in `t3_mechanism`; without meaning when τ is m.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range, or the floor is 0.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Identity, RandomizedResponse
    >>> t4(RandomizedResponse(["a", "b"], keep_probability="0.9"), 3, 1).value
    Fraction(7, 3)
    >>> t4(Identity(["a", "b"]), 3, 1).value
    Fraction(3, 1)
    """
    top, least = read_range(gamma, 0)[0], at_least("g_min", g_min, 0)
    low = least if tau is None else at_least("tau", tau, 0)
    if least > top:
        raise InputError(f"g_min is {least}, above gamma, which is {top}; the least utility is at most the greatest")
    if not least <= low <= top:
        raise InputError(f"tau is {low}; a floor between g_min, which is {least}, and gamma, which is {top}, is accepted")
    if low == 0:
        raise InputError("tau is 0; this bound needs a floor above 0, or a least utility above 0")
    value, multipliers = worst_pair(
        worst_pair_laws(mechanism),
        lambda pair: _least_over_k(pair, top, least, low),
        lambda pair, k: _with_least(k, hockey_stick(pair, k), top, least, low),
    )
    scope, extra = floor_terms(floor, f"{low}", any_filter=False, trivial=low == least)
    assumptions = (FRESH, GROUP_FREE, *extra)
    return Bound("T4", "local_ratio", value, {"gamma": top, "g_min": least, "tau": low}, multipliers, assumptions, scope)


def t4_in(case: Case) -> Bound | None:
    """T4 in a case, with the least utility as the floor; None where that is 0."""
    return t4(case.deployment.group_filter, case.gamma, case.m) if case.m > 0 and case.narrow else None


def _with_least(k: Fraction, stick: Fraction, top: Fraction, least: Fraction, low: Fraction) -> Fraction:
    """What a k proves by T4.

    Source: T4; Coq `T4_one_k`.
    """
    return k + max(Fraction(0), (top - least) * stick - (k - 1) * least) / low


def _least_over_k(pair: PairLaw, top: Fraction, least: Fraction, low: Fraction) -> tuple[Fraction, Fraction]:
    """Least value that one k proves by T4, and that k.

    The right side is convex and piecewise linear in k. It bends at the likelihood ratios and where the maximum with 0 does; there it equals
    the greatest ratio of means over the levels from (τ−m)/(γ−m) up, so that this ratio is the only other candidate.

    Source: T4; Coq `T4_certificate_exact`.
    """
    if top == least:
        return Fraction(1), Fraction(1)
    scale = lcm(top.denominator, least.denominator, low.denominator)
    base, floor = int(least * scale), int(low * scale)
    span, bottom = int(top * scale) - base, pair.denominator
    start = (floor - base) * bottom  # of the levels, all of which are taken times span and bottom

    def with_least(n: int, d: int, stick: int) -> tuple[int, int]:
        """What n/d proves, with H_k = stick / (d * bottom)."""
        return n * floor * bottom + max(0, span * stick - (n - d) * base * bottom), d * floor * bottom

    tried = [(with_least(0, 1, bottom), (0, 1))]
    greatest = 0, 1
    spent, gained = 0, 0
    for p, q in pair.columns:
        if q:
            tried.append((with_least(p, q, gained * q - p * spent), (p, q)))
            entered = max(spent * span, start)
            if entered <= (spent + q) * span:
                above = q * (base * bottom + gained * span) + p * (entered - spent * span)
                below = q * (base * bottom + entered)
                if above * greatest[1] > greatest[0] * below:
                    greatest = above, below
        spent, gained = spent + q, gained + p
    stick = sum(max(0, p * greatest[1] - greatest[0] * q) for p, q in pair.columns)
    tried.append((with_least(*greatest, stick), greatest))
    best, k = tried[0]
    for value, other in tried[1:]:
        order = value[0] * best[1] - best[0] * value[1]
        if order < 0 or (order == 0 and other[0] * k[1] < k[0] * other[1]):
            best, k = value, other
    return Fraction(*best), Fraction(*k)
