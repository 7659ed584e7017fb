"""T12: pure ε contracts the policy's own ratio."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.exact.extended import Extended
from fairaudit.measures.ratios import local_fairness
from fairaudit.theorems.assumptions import FRESH, GROUP_FREE
from fairaudit.theorems.bound import THIS_POLICY, Bound, as_multipliers, finite_constants, privacy_premise
from fairaudit.theorems.case import Case
from fairaudit.theorems.constants import read_factor, read_ratio


def t12(exp_epsilon: Any, raw_ratio: Any) -> Bound:
    """T12: a pure ε contracts the policy's own ratio R0: R ≤ (1 + R0·e^ε)/(R0 + e^ε), that is tanh(L/2) ≤ tanh(L0/2)·tanh(ε/2).

    Source: T12; Coq `T12_contraction`, `T12_any_filter`, `T12_tanh`, `T12_never_worse`, `T12_sharp`.

    Parameters
    ----------
    exp_epsilon : number or str
        e^ε ≥ 1 of the group filter, or `math.inf`.
    raw_ratio : number or str
        R0 ≥ 1, or `math.inf`: the greatest ratio of the policy's expected utilities between two released group values in one context,
        over the whole alphabet of released values, with the context filter in place.

    Returns
    -------
    Bound
        On the local ratio; never above e^ε or R0. No floor is needed.

    Raises
    ------
    InputError
        If a number is below 1.

    Examples
    --------
    >>> t12(2, 3).value, t12(2, float("inf")).value, t12(float("inf"), 3).value
    (Fraction(7, 5), Fraction(2, 1), Fraction(3, 1))
    """
    factor, raw = read_factor(exp_epsilon), read_ratio("the policy's own ratio", raw_ratio)
    if isinstance(factor, Fraction) and isinstance(raw, Fraction):
        value: Extended = (1 + raw * factor) / (raw + factor)
    else:
        value = min(factor, raw)
    note = "" if isinstance(value, Fraction) else "neither the filter nor the policy bounds the ratio"
    assumptions = (FRESH, GROUP_FREE, privacy_premise(factor, Fraction(0)))
    return Bound(
        "T12",
        "local_ratio",
        value,
        finite_constants(exp_epsilon=factor, raw_ratio=raw),
        as_multipliers(factor),
        assumptions,
        THIS_POLICY,
        note=note,
    )


def t12_in(case: Case) -> Bound | None:
    """T12 in a case: the policy's own ratio over everything that the filters can release, contracted; None if neither is finite."""
    released = case.deployment.shown_law
    raw = local_fairness(released, case.laid_over(released))
    bound = t12(case.exp_epsilon, raw.ratio if raw else 1)
    return bound if bound.value < inf else None
