"""T1: any utility, behind a group filter, with a floor under every compared expectation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.exact.rationals import at_least
from fairaudit.model.mechanism import Mechanism
from fairaudit.theorems.assumptions import FRESH
from fairaudit.theorems.bound import NO_FLOOR, Bound, Floor, finite_constants, floor_terms, gap_premise, privacy_premise
from fairaudit.theorems.case import Case
from fairaudit.theorems.constants import read_factor, read_probability, read_range
from fairaudit.theorems.one_k import Gap, additive_bound

# T1: any utility, floor


def floor_cap(gamma: Any, tau: Any, *, floor: Floor = "table") -> Bound:
    """Bound R by γ/τ, with no privacy at all.

    Source: T1; Coq `T1_cap`.

    Parameters
    ----------
    gamma, tau : number or str
        Greatest utility and floor, 0 ≤ τ ≤ γ, γ > 0.
    floor : {"table", "declared", "policy"}
        Where the floor comes from: read off the audited table (then the bound is about this law only), declared by a person, or the
        policy's own least expected utility over everything that the filters can release (then it survives a change of filter).

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> floor_cap(1, "0.3").value
    Fraction(10, 3)
    """
    top, low = read_range(gamma, tau)
    scope, extra = floor_terms(floor, f"{low}", any_filter=True, trivial=low == 0)
    if floor == "policy":
        extra = (FRESH,)
    if low == 0:
        return Bound("T1", "local_ratio", inf, {"gamma": top, "tau": low}, (), extra, scope, note="a floor of 0 caps nothing")
    return Bound("T1", "local_ratio", top / low, {"gamma": top, "tau": low}, (Fraction(0),), extra, scope)


def t1(mechanism: Mechanism, gamma: Any, tau: Any, K: Gap = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T1, tight: the least over k of k + (K + γ·H_k)/τ, greatest over the ordered pairs of rows, capped at γ/τ.

    Source: T1; Coq `T1_one_k`, `T1_filter`, `T1_pairs`.

    Parameters
    ----------
    mechanism : Mechanism
        The group filter.
    gamma, tau : number or str
        Greatest utility and floor, 0 ≤ τ ≤ γ, γ > 0.
    K : number, str or callable
        L_A·diam, or a function of two input labels (tuples of str) that gives L_A·d(a,a'); 0 for a utility that ignores the group.
    floor : {"table", "declared", "policy"}
        Where the floor comes from, as in `floor_cap`.

    Returns
    -------
    Bound
        On the local ratio. With τ = 0 it is infinite unless K = 0 and the filter is purely private.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> bound = t1(RandomizedResponse(["a", "b"], keep_probability="0.7"), 1, "0.5", "0.1")
    >>> bound.value, bound.multipliers
    (Fraction(62, 35), (Fraction(3, 7),))
    """
    return additive_bound("T1", mechanism, gamma, tau, K, floor, lambda top, _: top)


def t1_paper(exp_epsilon: Any, delta: Any, gamma: Any, tau: Any, K: Any = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T1 as the paper states it: R ≤ e^ε·(1 + (K + δγ)/τ), capped at γ/τ; never below `t1_tight`.

    Source: T1; Coq `T1_paper`, `T1_paper_log`.

    Parameters
    ----------
    exp_epsilon, delta : number or str
        e^ε ≥ 1 (or `math.inf`) and δ in [0, 1], for every ordered pair of inputs of the group filter.
    gamma, tau, K, floor
        As in `t1`; K is a number.

    Returns
    -------
    Bound
        On the local ratio; its multiplier e^ε proves the smaller value of `t1_tight` and therefore this one.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> t1_paper(2, "0.01", 1, "0.1").value, t1_tight(2, "0.01", 1, "0.1").value
    (Fraction(11, 5), Fraction(21, 10))
    """
    return _privacy_floor(exp_epsilon, delta, gamma, tau, K, floor, lambda e, excess: e * (1 + excess))


def t1_tight(exp_epsilon: Any, delta: Any, gamma: Any, tau: Any, K: Any = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T1, additive: R ≤ e^ε + (K + δγ)/τ, capped at γ/τ. Parameters, result and errors as in `t1_paper`.

    Source: T1; Coq `T1_additive`, `T1_tight`.

    Examples
    --------
    >>> t1_tight(2, 0, 1, 0, "0.1").note
    'with a floor of 0 and K or delta above 0 one group may get nothing where another gets something'
    """
    return _privacy_floor(exp_epsilon, delta, gamma, tau, K, floor, lambda e, excess: e + excess)


def floor_in(case: Case) -> Bound:
    """The cap by the floor of a case, about a policy behind filters."""
    cap = floor_cap(case.gamma, case.tau, floor=case.floor)
    return replace(cap, multipliers=(), assumptions=(FRESH, *cap.assumptions))


def t1_in(case: Case) -> Bound | None:
    """T1 in a case with a floor; None where the floor by itself proves as much."""
    if not case.narrow:
        return None
    bound = t1(case.deployment.group_filter, case.gamma, case.tau, case.gap, floor=case.floor)
    return bound if bound.value < case.cap else None


def t1_paper_in(case: Case) -> Bound | None:
    """T1 in the paper's form, in a case with a floor; None where the floor by itself proves as much."""
    bound = t1_paper(case.exp_epsilon, 0, case.gamma, case.tau, case.gap, floor=case.floor)
    return replace(bound, multipliers=()) if bound.value < case.cap else None


def _privacy_floor(
    exp_epsilon: Any, delta: Any, gamma: Any, tau: Any, gap: Any, floor: Floor, value_of: Callable[[Fraction, Fraction], Fraction]
) -> Bound:
    factor, part, number = read_factor(exp_epsilon), read_probability("delta", delta), at_least("K", gap, 0)
    top, low = read_range(gamma, tau)
    constants = finite_constants(exp_epsilon=factor, delta=part, gamma=top, tau=low, K=number)
    scope, extra = floor_terms(floor, f"{low}", any_filter=True, trivial=low == 0)
    assumptions = (FRESH, gap_premise(number), privacy_premise(factor, part), *extra)
    if low == 0:
        if number == 0 and part == 0 and isinstance(factor, Fraction):
            return Bound("T1", "local_ratio", factor, constants, (factor,), assumptions, scope)
        note = NO_FLOOR if number or part else "a floor of 0 and a filter that is not purely private bound nothing"
        return Bound("T1", "local_ratio", inf, constants, (), assumptions, scope, note=note)
    if isinstance(factor, Fraction):
        value = value_of(factor, (number + part * top) / low)
        if value < top / low:
            return Bound("T1", "local_ratio", value, constants, (factor,), assumptions, scope)
    return Bound("T1", "local_ratio", top / low, constants, (Fraction(0),), assumptions, scope)
