"""What theorems guarantee about a policy behind filters: each kind of the registry in turn, where it has what it needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby
from typing import TYPE_CHECKING, get_args

from fairaudit.measures.limits import Quantity
from fairaudit.theorems.assumptions import DECISION_ONLY, GROUP_FREE, INDEPENDENT
from fairaudit.theorems.bound import ANY_POLICY, ANY_UTILITY, ANY_UTILITY_FLOORED, FLOORED, GAP, MULTIPLIES, THIS_LAW, THIS_POLICY, Bound
from fairaudit.theorems.kind import Kind
from fairaudit.theorems.registry import KINDS

if TYPE_CHECKING:
    from fairaudit.theorems.case import Case
    from fairaudit.theorems.supremum import Supremum


CONFIRMED = (GROUP_FREE, DECISION_ONLY, INDEPENDENT, f"the group filter {MULTIPLIES}", GAP)
"""How the sentences begin that a bound rests on and that the table and its filters show: the checker finds the same out by itself."""


@dataclass(frozen=True)
class Guarantees:
    """What is guaranteed behind filters.

    Attributes
    ----------
    suprema : tuple of Supremum
        The greatest ratios that T13 finds, by scope.
    bounds : tuple of Bound
        What theorems bound besides.
    """

    suprema: tuple[Supremum, ...] = ()
    bounds: tuple[Bound, ...] = ()


def guarantees(case: Case, tau: Fraction | None, *, all_bounds: bool = False) -> Guarantees:
    """What theorems guarantee about a deployment, as far as it is finite: see docs/certificate-policy.md.

    Parameters
    ----------
    case : Case
        The policy behind filters.
    tau : Fraction or None
        The floor that its table shows: the least expected utility that is compared.
    all_bounds : bool
        Whether to list bounds that T13 makes superfluous, too.
    """
    from fairaudit.theorems.case import NEEDS
    from fairaudit.theorems.supremum import Supremum

    found = [
        kind.reaches(case, quantity)
        for kind in KINDS
        if kind.reaches is not None and all(NEEDS[need](case) for need in kind.needs)
        for quantity in get_args(Quantity)
    ]
    suprema = tuple(one for one in found if isinstance(one, Supremum))
    ranges = tuple(one for one in found if isinstance(one, Bound))
    reached = {(f"{one.quantity}_ratio", one.scope) for one in suprema} | {(one.quantity, one.scope) for one in ranges}
    bounds = applicable_bounds(case, tau, None if all_bounds else frozenset(reached))
    return Guarantees(suprema, (*bounds, *ranges))


def applicable_bounds(case: Case, tau: Fraction | None, reached: frozenset[tuple[str, str]] | None = None) -> Iterator[Bound]:
    """What theorems other than T13 bound.

    Parameters
    ----------
    case, tau
        As in `guarantees`.
    reached : set of (quantity, scope), optional
        What T13 says something of: what it makes superfluous is left out.
    """
    bounding = [kind for kind in KINDS if kind.applies is not None]
    for floored, kinds in groupby(bounding, key=lambda kind: kind.floored):
        together = list(kinds)
        for at in case.above(tau) if floored else [case]:
            for kind in together:
                bound = None if reached is not None and _superfluous(kind, at, reached) else applied(kind, at)
                if bound is not None:
                    yield bound


def _superfluous(kind: Kind, case: Case, reached: frozenset[tuple[str, str]]) -> bool:
    """Whether something that is at least as sharp is said of the same scope, or of a wider one.

    Of a policy that was sampled only the declared range of the utility holds for whatever it decides.
    """
    scope = (FLOORED if case.floor == "declared" else THIS_LAW) if kind.floored else kind.scopes[0]
    if scope == THIS_LAW:  # the figure itself is exact
        return True
    if scope == THIS_POLICY:  # T12 is attained
        return kind.by == "T3"
    wider = {ANY_POLICY: ANY_UTILITY, FLOORED: ANY_UTILITY_FLOORED}
    if case.deployment.policy.law.kind != "counts":
        return (kind.quantities[0], scope) in reached
    decides = case.gap == 0 or "lipschitz" in case.declared
    return decides and (kind.quantities[0], wider.get(scope, "")) in reached


def to_judge(bound: Bound) -> tuple[str, ...]:
    """Those assumptions of a bound that no table confirms; the others are checked when the bound is made, and by the checker."""
    return tuple(text for text in bound.assumptions if not text.startswith(CONFIRMED))


def applied(kind: Kind, case: Case) -> Bound | None:
    """A bound by a kind of claim; one that rests on more, or less, than the kind says is a mistake in one of the two."""
    from fairaudit.theorems.case import NEEDS

    if kind.applies is None or not all(NEEDS[need](case) for need in kind.needs):
        return None
    bound = kind.applies(case)
    if bound is None or not all(NEEDS[need](case) for need in kind.asks(bound.scope)):
        return None
    listed = kind.sentences(bound.scope, bound.quantity, bound.constants)
    if bound.scope not in kind.scopes or set(to_judge(bound)) != set(listed):
        raise AssertionError(f"the bound by {kind.id} for {bound.scope} rests on {to_judge(bound)}, which is not what the registry says")
    return replace(bound, theorem=kind.by)
