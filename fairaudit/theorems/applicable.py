"""Which theorems apply to a policy behind filters, what they guarantee there, and which of their assumptions a reader must judge."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import inf
from typing import Any, Literal

import numpy as np

from fairaudit.measures.ratios import local_fairness
from fairaudit.model.law import Law
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.privacy.epsilon_delta import exp_epsilon
from fairaudit.privacy.pairs import joint_ratios
from fairaudit.theorems.bound import ANY_POLICY, DECISION_ONLY, FLOORED, FRESH, GROUP_FREE, INDEPENDENT, POPULATION, Bound
from fairaudit.theorems.t01 import floor_cap, t1, t1_paper
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t03 import t3_approx, t3_general
from fairaudit.theorems.t04 import t4
from fairaudit.theorems.t05 import t5_decision, t5_independent
from fairaudit.theorems.t12 import t12

ANY_CONTEXT_FILTER = "this policy and group filter, any context filter that releases these contexts"

CONFIRMED = (
    GROUP_FREE,
    DECISION_ONLY,
    INDEPENDENT,
    "the group filter multiplies",
    "the utilities of two groups differ",
)

PAIR_RATIOS = 500_000

TOO_WIDE = (
    f"the bounds by T1, T3 and T4 for this filter are left out: its pairs of rows have more than {PAIR_RATIOS} joint likelihood ratios, "
    "which no certificate may ask a reader to go through"
)


def for_any_sampled(theorem: str, scope: str, declared: Mapping[str, Any]) -> bool:
    """Whether a bound holds for whatever policy was sampled, and rests on declared constants only."""
    needs: tuple[str, ...] | None = {"T2": (), "T5": (), "T5-decision": (), "T4": ("gamma", "m")}.get(theorem)
    if scope == FLOORED:
        needs = ("gamma",)
    elif scope != ANY_POLICY:
        needs = None
    return needs is not None and all(name in declared for name in needs)


def applicable_bounds(
    deployment: Deployment, table: UtilityTable, tau: Fraction | None, declared: Mapping[str, Fraction], law: Law
) -> Iterator[Bound]:
    """What theorems guarantee about a deployment, as far as it is finite: see docs/certificate-policy.md."""
    group = deployment.group_filter
    gamma, m = declared.get("gamma", table.gamma), declared.get("m", table.m)
    gap = declared.get("lipschitz", table.lipschitz())
    factor, narrow = exp_epsilon(group), joint_ratios(group) <= PAIR_RATIOS
    if gap == 0:
        if factor < inf:
            yield t2(factor)
        raw = local_fairness(deployment.shown_law, _by_context(table, deployment.shown_law))
        own: Fraction | float = raw.ratio if raw else Fraction(1)
        if min(factor, own) < inf:
            yield t12(factor, own)
        if m > 0 and narrow:
            yield t4(group, gamma, m)
        least = _policy_floor(deployment, table)
        if factor < inf and least > 0:
            yield t3_approx(factor, 0, least / gamma, floor="policy")
    floors: list[tuple[Literal["table", "declared"], Fraction | None]] = [("table", tau), ("declared", declared.get("tau"))]
    for floor, low in floors:
        if low is None or low == 0:
            continue
        cap = floor_cap(gamma, low, floor=floor)
        cap = replace(cap, theorem="floor", multipliers=(), assumptions=(FRESH, *cap.assumptions))
        yield cap
        found = [t1(group, gamma, low, gap, floor=floor)] if narrow else []
        if factor < inf:
            found.append(replace(t1_paper(factor, 0, gamma, low, gap, floor=floor), theorem="T1-paper", multipliers=()))
        if low <= gamma - gap and narrow:
            found.append(t3_general(group, gamma, low, gap, floor=floor))
        yield from (bound for bound in found if bound.value < cap.value)
    yield from _global_bounds(deployment, table, gap, factor, law)


def _global_bounds(deployment: Deployment, table: UtilityTable, gap: Fraction, factor: Fraction | float, law: Law) -> Iterator[Bound]:
    if law.global_groups and factor < inf:
        if gap == 0 and law.independent:
            bound = t5_independent(t2(factor))
            yield replace(bound, multipliers=(), assumptions=(*bound.assumptions, POPULATION))
        spread = _composition(deployment, law)
        if table.by_decision and spread < inf:
            bound = t5_decision(factor, table, released_ratio=spread)
            yield replace(bound, theorem="T5-decision", constants={"composition": Fraction(spread)}, multipliers=())
    released = deployment.filtered_contexts_law
    if released is not None and table.by_decision:
        before = local_fairness(released, replace(table, law=released))
        if before is not None and before.ratio < inf:
            yield Bound("T8", "local_ratio", before.ratio, {}, (), (FRESH, DECISION_ONLY), ANY_CONTEXT_FILTER)


def _by_context(table: UtilityTable, law: Law) -> UtilityTable:
    """Lay a utility that does not depend on the group out over other groups in the same contexts."""
    if table.by_decision:
        return replace(table, law=law)
    first = table.law.starts[:-1]
    return replace(table, law=law, values=np.repeat(table.values[first], np.diff(law.starts), axis=0))


def _policy_floor(deployment: Deployment, table: UtilityTable) -> Fraction:
    """Least Σ_u T(u|x̃,ã)·g(u,x,a) over what the policy can be shown: a floor for every filter that releases the same values."""
    law = deployment.policy.law
    least: Fraction | None = None
    utilities = {
        x: {tuple(table.row(cell)) for cell in range(start, end)} for x, (start, end) in enumerate(pairwise(table.law.starts.tolist()))
    }
    for x, cell in deployment.shown_cells:
        row = law.row(cell)
        for values in utilities[x]:
            value = Fraction(sum(w * g for w, g in zip(row, values, strict=True)), sum(row) * table.scale)
            least = value if least is None or value < least else least
    return least if least is not None else Fraction(0)


def _composition(deployment: Deployment, law: Law) -> Fraction | float:
    """Greatest P(x̃|a)/P(x̃|a') over released contexts and ordered pairs of groups of positive mass."""
    mass = np.array(law.cell_mass, dtype=object).reshape(len(law.contexts), len(law.groups))[:, list(law.global_groups)]
    context = deployment.context_filter
    shown_mass = mass if context is None else np.array([context.row(x) for x in law.contexts], dtype=object).T @ mass
    totals = mass.sum(axis=0)
    worst: Fraction | float = Fraction(1)
    for row in shown_mass:
        shares = [Fraction(v, t) for v, t in zip(row.tolist(), totals.tolist(), strict=True)]
        top, low = max(shares), min(shares)
        if top > 0:
            worst = max(worst, top / low if low else inf)
    return worst


def to_judge(bound: Bound) -> tuple[str, ...]:
    """Those assumptions of a bound that no table confirms; the others are checked when the bound is made, and by the checker."""
    return tuple(text for text in bound.assumptions if not text.startswith(CONFIRMED))
