"""T2: a utility that ignores the group, behind a group filter with pure ε; no floor."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from fairaudit.theorems.assumptions import FRESH, GROUP_FREE
from fairaudit.theorems.bound import ANY_POLICY, Bound, as_multipliers, finite_constants, privacy_premise
from fairaudit.theorems.case import Case
from fairaudit.theorems.constants import read_factor

# T2: pure privacy, no floor


def t2(exp_epsilon: Any) -> Bound:
    """T2: behind a purely ε-private group filter R ≤ e^ε, for every policy and every utility that ignores the group; no floor.

    Source: T2; Coq `T2_pure`, `T2_sharp`, `T2_log`.

    Parameters
    ----------
    exp_epsilon : number or str
        e^ε ≥ 1, or `math.inf`.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If e^ε < 1.

    Examples
    --------
    >>> t2("7/3").value, t2("7/3").scope
    (Fraction(7, 3), 'any policy behind this filter')
    """
    factor = read_factor(exp_epsilon)
    note = "" if isinstance(factor, Fraction) else "the filter is not purely private: some output is possible for one group only"
    assumptions = (FRESH, GROUP_FREE, privacy_premise(factor, Fraction(0)))
    return Bound(
        "T2", "local_ratio", factor, finite_constants(exp_epsilon=factor), as_multipliers(factor), assumptions, ANY_POLICY, note=note
    )


def t2_in(case: Case) -> Bound:
    """T2 in a case that has a finite ε."""
    return t2(case.exp_epsilon)
