"""What theorems guarantee about a policy behind filters: each kind of the registry in turn, where it has what it needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import groupby

from fairaudit.theorems.assumptions import DECISION_ONLY, GROUP_FREE, INDEPENDENT
from fairaudit.theorems.bound import GAP, MULTIPLIES, Bound
from fairaudit.theorems.case import NEEDS, Case
from fairaudit.theorems.registry import KINDS, Kind

CONFIRMED = (GROUP_FREE, DECISION_ONLY, INDEPENDENT, f"the group filter {MULTIPLIES}", GAP)
"""How the sentences begin that a bound rests on and that the table and its filters show: the checker finds the same out by itself."""


def applicable_bounds(case: Case, tau: Fraction | None) -> Iterator[Bound]:
    """What theorems guarantee about a deployment, as far as it is finite: see docs/certificate-policy.md.

    Parameters
    ----------
    case : Case
        The policy behind filters.
    tau : Fraction or None
        The floor that its table shows: the least expected utility that is compared.
    """
    bounding = [kind for kind in KINDS if kind.applies is not None]
    for floored, kinds in groupby(bounding, key=lambda kind: kind.floored):
        together = list(kinds)
        for at in case.above(tau) if floored else [case]:
            for kind in together:
                bound = applied(kind, at)
                if bound is not None:
                    yield bound


def to_judge(bound: Bound) -> tuple[str, ...]:
    """Those assumptions of a bound that no table confirms; the others are checked when the bound is made, and by the checker."""
    return tuple(text for text in bound.assumptions if not text.startswith(CONFIRMED))


def applied(kind: Kind, case: Case) -> Bound | None:
    """A bound by a kind of claim; one that rests on more, or less, than the kind says is a mistake in one of the two."""
    if kind.applies is None or not all(NEEDS[need](case) for need in kind.needs):
        return None
    bound = kind.applies(case)
    if bound is None:
        return None
    if bound.scope not in kind.scopes or set(to_judge(bound)) != set(kind.sentences(bound.scope, bound.constants)):
        raise AssertionError(f"the bound by {kind.id} for {bound.scope} rests on {to_judge(bound)}, which is not what the registry says")
    return replace(bound, theorem=kind.by)
