"""T11: a measured ratio above e^ε refutes the filter's claim, or its fresh and independent draws."""

from __future__ import annotations

from math import inf
from typing import Any

from fairaudit.exact.rationals import at_least
from fairaudit.theorems.constants import is_infinite, read_factor

# T11 and T12


def t11_refutes(measured_ratio_lower: Any, exp_epsilon: Any) -> bool:
    """T11: a measured ratio above e^ε refutes that the filter is ε-private or that its draws are fresh and independent.

    The utility must ignore the group and be fixed beforehand, and the decisions must come through the deployed filter at true values:
    a law composed from a known filter and policy can refute nothing.

    Source: T11; Coq `T11_refutation`, `T11_test`.

    Parameters
    ----------
    measured_ratio_lower : number or str
        Lower confidence bound of R, or R of an exactly known law, ≥ 0 or `math.inf`. 0/0 is parity, 1, which is no evidence.
    exp_epsilon : number or str
        e^ε ≥ 1, or `math.inf`.

    Returns
    -------
    bool
        Whether the claim of ε is refuted.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> t11_refutes("2.5", 2), t11_refutes(1, 1)
    (True, False)
    """
    factor = read_factor(exp_epsilon)
    measured = inf if is_infinite(measured_ratio_lower) else at_least("the measured ratio", measured_ratio_lower, 0)
    return bool(measured > factor)
