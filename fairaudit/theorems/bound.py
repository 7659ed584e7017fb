"""A bound on a fairness measure: what a theorem concludes, what it rests on, and the words for it.

Throughout, E(x,a) is the expected utility of group a in context x, R the greatest ratio of two of them in one context, γ the
greatest and m the least utility, τ a floor under every compared E(x,a), t = τ/γ, K the greatest difference of utility between
two groups for the same decision and context (L_A·d), and H_k(P,Q) = Σ max(0, P − kQ) the hockey stick of an ordered pair of
rows of the group filter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import Extended
from fairaudit.theorems.assumptions import FLOOR, GROUP_FREE
from fairaudit.words import brief

Floor = Literal["table", "declared", "policy"]


THIS_LAW = "this law"

THIS_POLICY = "this policy and context filter, any group filter at most this epsilon that releases the same values"

ANY_POLICY = "any policy behind this filter"

FLOORED = "any policy behind this filter that keeps the declared floor"

NEAR_POLICY = "any policy behind this filter within the declared drift of this one"

ANY_UTILITY = "any policy behind this filter, any utility of the declared range"

ANY_UTILITY_FLOORED = "any policy behind this filter that keeps the declared floor, any utility of the declared range"

ANY_CONTEXT_FILTER = "this policy and group filter, any context filter that releases these contexts"


@brief
@dataclass(frozen=True, repr=False)
class Bound:
    """An upper bound on a fairness measure, with what it rests on.

    Attributes
    ----------
    theorem : str
        Its number, such as ``"T3"``.
    quantity : str
        What is bounded: ``"local_ratio"``, ``"global_ratio"``, ``"selection_ratio"`` (ratios R; the measure is log R),
        ``"equalized_odds"`` or ``"demographic_parity"`` (total variation distances).
    value : Fraction or float
        The bound; `math.inf` if the theorem gives none.
    constants : mapping of str to Fraction
        The numbers that it was computed from; infinite ones are left out.
    multipliers : tuple of Fraction
        The evidence, in falling order: for every ordered pair of inputs at least one of these k proves the value (see the module).
    assumptions : tuple of str
        What the reader must accept.
    scope : str
        Which laws the bound covers.
    certified : bool
        Whether integers suffice to check it.
    note : str
        Why there is no finite bound, or how the value was rounded.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> bound = fa.audit(policy.behind(group=coin), utility="hire", all_bounds=True).bounds[0]
    >>> bound.theorem, bound.quantity, bound.value, bound.scope
    ('T2', 'local_ratio', Fraction(3, 1), 'any policy behind this filter')
    """

    theorem: str
    quantity: str
    value: Extended
    constants: Mapping[str, Fraction]
    multipliers: tuple[Fraction, ...]
    assumptions: tuple[str, ...]
    scope: str
    certified: bool = True
    note: str = ""


# Words


def floor_terms(
    floor: Floor, amount: str, *, any_filter: bool, trivial: bool = False, mean: bool = False, chance: bool = False
) -> tuple[str, tuple[str, ...]]:
    """Scope, and the sentence that a declared floor adds.

    `any_filter`: whether the bound depends on the filter through its privacy parameters alone; `trivial`: whether the floor holds for
    every policy by itself.
    """
    if floor not in ("table", "declared", "policy"):
        raise InputError(f"floor={shown(floor)} is not accepted; use 'table', 'declared' or 'policy'")
    if trivial:
        return ANY_POLICY, ()
    if floor == "declared":
        who = "compared person's chance" if chance else "compared group's mean utility" if mean else "compared group's expected utility"
        return FLOORED, (FLOOR.format(who=who, tau=amount),)
    return (THIS_POLICY if floor == "policy" and any_filter else THIS_LAW), ()


MULTIPLIES = "multiplies the probability of any event by at most"

GAP = "the utilities of two groups differ by at most"


def privacy_premise(factor: Extended, delta: Fraction, who: str = "the group filter") -> str:
    """The sentence that a filter is (ε,δ)-private; `factor` is e^ε."""
    more = f" plus {delta}" if delta else ""
    return f"{who} {MULTIPLIES} {factor}{more} between any two inputs, in either order"


def gap_premise(gap: Fraction) -> str:
    """The sentence about how far the utility depends on the group."""
    return f"{GAP} {gap} for the same decision and context" if gap else GROUP_FREE


def finite_constants(**numbers: Extended) -> dict[str, Fraction]:
    """The constants of a bound, without those that are infinite."""
    return {name: value for name, value in numbers.items() if isinstance(value, Fraction)}


def as_multipliers(factor: Extended) -> tuple[Fraction, ...]:
    """e^ε as the one multiplier; none where it is infinite."""
    return (factor,) if isinstance(factor, Fraction) else ()


NO_FLOOR = "with a floor of 0 and K or delta above 0 one group may get nothing where another gets something"
