"""T7: total variation distances from the supremum of the ratio over all utilities."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any, Literal

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import Extended
from fairaudit.theorems.assumptions import GROUP_FREE
from fairaudit.theorems.bound import THIS_LAW, Bound, finite_constants
from fairaudit.theorems.constants import read_ratio

# T7: distances from suprema


def t7(supremum: Any, *, quantity: Literal["equalized_odds", "demographic_parity"] = "equalized_odds") -> Bound:
    """T7: from the supremum R* of the ratio over all utilities that ignore the group, a distance of at most (R*−1)/(R*+1).

    Source: T7; Coq `T7_symmetric`, `T7_equalized_odds`, `T7_demographic_parity`, `T7_filter`.

    Parameters
    ----------
    supremum : number, str or Bound
        R* ≥ 1 (or `math.inf`): local for equalized odds, global over g(u) for demographic parity. Of the bounds only T2 is accepted,
        for equalized odds: it holds for all utilities at once, while T3 and its like belong to one utility and its floor.
    quantity : {"equalized_odds", "demographic_parity"}
        Which distance.

    Returns
    -------
    Bound
        On the total variation distance; 1 when R* is infinite.

    Raises
    ------
    InputError
        If R* is below 1, or is a bound that does not hold for all utilities.

    Examples
    --------
    >>> from fairaudit.theorems.t02 import t2
    >>> t7(3).value, t7(t2(3)).scope
    (Fraction(1, 2), 'any policy behind this filter')
    """
    if quantity not in ("equalized_odds", "demographic_parity"):
        raise InputError(f"quantity={shown(quantity)} is not accepted; use 'equalized_odds' or 'demographic_parity'")
    if isinstance(supremum, Bound):
        if supremum.theorem != "T2" or quantity != "equalized_odds":
            raise InputError(f"a bound by {supremum.theorem} on {supremum.quantity} does not bound {quantity}; T2 bounds equalized odds")
        assumptions = tuple(sentence for sentence in supremum.assumptions if sentence != GROUP_FREE)
        return replace(supremum, theorem="T7", quantity=quantity, value=_halved(supremum.value), assumptions=assumptions, note="")
    ratio = read_ratio("the supremum", supremum)
    return Bound("T7", quantity, _halved(ratio), finite_constants(supremum=ratio), (), (), THIS_LAW)


def t7_pair(first: Any, second: Any) -> Fraction:
    """T7 for one pair of groups: TV ≤ (R1−1)(R2−1)/(R1·R2−1) from the one-sided suprema R1 = max P/Q and R2 = max Q/P.

    Source: T7; Coq `T7_product`, `T7_one_sided`.

    Parameters
    ----------
    first, second : number or str
        R1, R2 ≥ 1, or `math.inf`.

    Returns
    -------
    Fraction
        The bound, in [0, 1]; 0 as soon as one of them is 1.

    Raises
    ------
    InputError
        If one is below 1.

    Examples
    --------
    >>> t7_pair(2, 3), t7_pair(2, float("inf")), t7_pair(1, 1)
    (Fraction(2, 5), Fraction(1, 2), Fraction(0, 1))
    """
    one, other = read_ratio("the first supremum", first), read_ratio("the second supremum", second)
    if one == 1 or other == 1:
        return Fraction(0)
    if isinstance(one, Fraction) and isinstance(other, Fraction):
        return (one - 1) * (other - 1) / (one * other - 1)
    finite = one if isinstance(one, Fraction) else other
    return 1 - 1 / finite if isinstance(finite, Fraction) else Fraction(1)


def _halved(ratio: Extended) -> Fraction:
    return (ratio - 1) / (ratio + 1) if isinstance(ratio, Fraction) else Fraction(1)
