"""T3: a utility that ignores the group, or depends on it by at most K, with a floor; exact for a known filter."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from math import inf
from typing import Any, Literal

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import Extended
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.pairs import hockey_stick
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.theorems.assumptions import FRESH, GROUP_FREE
from fairaudit.theorems.bound import Bound, Floor, finite_constants, floor_terms, privacy_premise
from fairaudit.theorems.case import Case
from fairaudit.theorems.constants import read_factor, read_level, read_probability
from fairaudit.theorems.one_k import Gap, additive_bound, power_ratio, worst_pair

# T3: utility that ignores the group, floor


def t3_approx(exp_epsilon: Any, delta: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for (ε,δ)-privacy: R ≤ min{1/t, e^ε + δ/t, (1 − e^(−ε)·(1 − δ − t))/t}; attained.

    Source: T3; Coq `T3_eps_delta`, `T3_sharp`.

    Parameters
    ----------
    exp_epsilon, delta : number or str
        As in `t1_paper`.
    t : number or str
        Floor as a part of the greatest utility, τ/γ in (0, 1].
    floor : {"table", "declared", "policy"}
        Where the floor comes from, as in `floor_cap`.

    Returns
    -------
    Bound
        On the local ratio; its one multiplier is 0, e^ε or e^(−ε), after the term that is least.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> t3_approx(2, 0, "0.5").value, t3_approx(2, 0, "0.5").multipliers
    (Fraction(3, 2), (Fraction(1, 2),))
    """
    factor, part, level = read_factor(exp_epsilon), read_probability("delta", delta), read_level(t)
    value, k = approx_dp_ratio(factor, part, level)
    scope, extra = floor_terms(floor, f"{level} of the greatest utility", any_filter=True)
    assumptions = (FRESH, GROUP_FREE, privacy_premise(factor, part), *extra)
    return Bound("T3", "local_ratio", value, finite_constants(exp_epsilon=factor, delta=part, t=level), (k,), assumptions, scope)


def t3_mechanism(mechanism: Mechanism, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for a known group filter: the greatest power at level t over its ordered pairs of rows, divided by t; attained by some policy.

    Source: T3; Coq `T3_one_k`, `T3_power`, `T3_exact`.

    Parameters
    ----------
    mechanism : Mechanism
        The group filter.
    t : number or str
        Floor as a part of the greatest utility, in (0, 1].
    floor : {"table", "declared", "policy"}
        As in `floor_cap`. A policy's own floor gives the scope "this law" here: the value belongs to this filter, and another filter of
        the same ε can do worse.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If t is outside (0, 1].

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> t3_mechanism(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"), "0.5").value
    Fraction(3, 2)
    """
    level = read_level(t)
    value, multipliers = worst_pair(
        worst_pair_laws(mechanism), lambda pair: power_ratio(pair, level), lambda pair, k: k + hockey_stick(pair, k) / level
    )
    scope, extra = floor_terms(floor, f"{level} of the greatest utility", any_filter=False)
    return Bound("T3", "local_ratio", value, {"t": level}, multipliers, (FRESH, GROUP_FREE, *extra), scope)


def t3_randomized_response(k: int, keep_probability: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for k-ary randomized response in closed form; equal to `t3_mechanism`.

    With keep probability p ≥ 1/k and q = (1 − p)/(k − 1): p/q where t ≤ q, 1 + (p − q)/t between, (1 − (1 − t)·q/p)/t where t ≥ 1 − p.

    Source: T3; Coq `T3_krr`, `T3_krr_attained`, `T3_krr_least`.

    Parameters
    ----------
    k : int
        Number of values, at least 2.
    keep_probability : number or str
        p in [1/k, 1].
    t : number or str
        Floor as a part of the greatest utility, in (0, 1].
    floor : {"table", "declared", "policy"}
        As in `t3_mechanism`.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range; below 1/k the truth is less likely than each lie, and the closed form does not hold.

    Examples
    --------
    >>> [t3_randomized_response(4, "0.4", t).value for t in ("0.1", "0.5", "0.8")]
    [Fraction(2, 1), Fraction(7, 5), Fraction(9, 8)]
    """
    if isinstance(k, bool) or not isinstance(k, int) or k < 2:
        raise InputError(f"the number of values is {shown(k)}; an integer of at least 2 is accepted")
    keep, level = read_probability("keep_probability", keep_probability), read_level(t)
    if keep < Fraction(1, k):
        raise InputError(f"keep_probability is {keep}, below 1/{k}: the truth would be less likely than each lie; give at least 1/{k}")
    lie = (1 - keep) / (k - 1)
    if level <= lie:
        multiplier, value = keep / lie, keep / lie
    elif level <= 1 - keep:
        multiplier, value = Fraction(1), 1 + (keep - lie) / level
    else:
        multiplier, value = lie / keep, (1 - (1 - level) * lie / keep) / level
    scope, extra = floor_terms(floor, f"{level} of the greatest utility", any_filter=False)
    constants = {"values": Fraction(k), "keep_probability": keep, "t": level}
    response = f"the group filter is randomized response over {k} values that keeps the truth with probability {keep}"
    return Bound("T3", "local_ratio", value, constants, (multiplier,), (FRESH, GROUP_FREE, response, *extra), scope)


def t3_curve(vertices: Sequence[tuple[Any, Any]], t: Any, *, orders: Literal["both", "one"], floor: Floor = "table") -> Bound:
    """T3 for a trade-off function given by its vertices: R ≤ (1 − f(t))/t.

    Source: T3; Coq `T3_tradeoff`.

    Parameters
    ----------
    vertices : sequence of (number, number)
        (α, f(α)) from α = 0 to (1, 0): falling, convex, at most 1 − α. f(α) is the least 1 − E_P φ over tests φ with E_Q φ ≤ α.
    t : number or str
        Floor as a part of the greatest utility, in (0, 1].
    orders : {"both", "one"}
        Which ordered pairs of rows lie above f. With "both" every pair does in both orders, and max(f, f⁻¹) holds. With "one" a pair may
        do so in one order only (the curve of a single ordered pair, say); the other order lies above f⁻¹, and min(f, f⁻¹) is what counts.
    floor : {"table", "declared", "policy"}
        As in `floor_cap`.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If the vertices are not those of a trade-off function, or t is out of range.

    Examples
    --------
    >>> lopsided = [(0, "0.5"), (1, 0)]
    >>> [t3_curve(lopsided, "0.5", orders=orders).value for orders in ("both", "one")]
    [Fraction(3, 2), Fraction(2, 1)]
    """
    level = read_level(t)
    if orders not in ("both", "one"):
        raise InputError(f"orders={shown(orders)} is not accepted; use 'both' or 'one'")
    curve = _curve(vertices)
    found = [_on_curve(curve, level), _on_curve(_inverse(curve), level)]
    height, slope = max(found) if orders == "both" else min(found)
    multipliers = (slope,) if orders == "both" else tuple(sorted({k for _, k in found}, reverse=True))
    both = "in both orders" if orders == "both" else "in at least one order"
    premise = f"the trade-off function of every pair of rows of the group filter lies above the stated curve {both}"
    scope, extra = floor_terms(floor, f"{level} of the greatest utility", any_filter=True)
    return Bound("T3", "local_ratio", (1 - height) / level, {"t": level}, multipliers, (FRESH, GROUP_FREE, premise, *extra), scope)


def t3_general(mechanism: Mechanism, gamma: Any, tau: Any, K: Gap = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T3 for a utility that may depend on the group: R ≤ (K + (γ−K)·(1 − f(τ/(γ−K))))/τ where τ ≤ γ − K, else γ/τ; never above `t1`.

    Parameters, result and errors as in `t1`.

    Source: T3; Coq `T3_K_one_k`, `T3_K_power`, `T3_K_tradeoff`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> from fairaudit.theorems.t01 import t1
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.6")
    >>> t3_general(coin, 1, "0.4", "0.1").value, t1(coin, 1, "0.4", "0.1").value
    (Fraction(5, 3), Fraction(7, 4))
    """
    return additive_bound("T3", mechanism, gamma, tau, K, floor, lambda top, gap: top - gap)


def t3_in(case: Case) -> Bound | None:
    """T3 in a case with a floor; None where the floor by itself proves as much, or is too high for T3."""
    if case.tau > case.gamma - case.gap or not case.narrow:
        return None
    bound = t3_general(case.deployment.group_filter, case.gamma, case.tau, case.gap, floor=case.floor)
    return bound if bound.value < case.cap else None


def t3_any_filter_in(case: Case) -> Bound | None:
    """T3 in a case, for every group filter of its ε: the floor is that of the policy.

    Source: T3; Coq `T3_any_filter`, `pure_dp_hockey_stick`.
    """
    least = policy_floor(case)
    return t3_approx(case.exp_epsilon, 0, least / case.gamma, floor="policy") if case.exp_epsilon < inf and least > 0 else None


def policy_floor(case: Case) -> Fraction:
    """Least Σ_u T(u|x̃,ã)·g(u,x,a) over what the policy can be shown: a floor for every filter that releases the same values."""
    law, table = case.deployment.policy.law, case.utility
    least: Fraction | None = None
    utilities = {
        x: {tuple(table.row(cell)) for cell in range(start, end)} for x, (start, end) in enumerate(pairwise(table.law.starts.tolist()))
    }
    for x, cell in case.deployment.shown_cells:
        row = law.row(cell)
        for values in utilities[x]:
            value = Fraction(sum(w * g for w, g in zip(row, values, strict=True)), sum(row) * table.scale)
            least = value if least is None or value < least else least
    return least if least is not None else Fraction(0)


def approx_dp_ratio(factor: Extended, delta: Fraction, level: Fraction) -> tuple[Fraction, Fraction]:
    """(1 − f(t))/t of (ε,δ), and its k.

    Source: T3; Coq `T3_eps_delta`.
    """
    terms = [(1 / level, Fraction(0))]
    if isinstance(factor, Fraction):
        terms += [(factor + delta / level, factor), ((1 - (1 - delta - level) / factor) / level, 1 / factor)]
    return min(terms)


# Curves and enclosures


def _curve(vertices: Sequence[tuple[Any, Any]]) -> list[tuple[Fraction, Fraction]]:
    curve = [(read_probability("a vertex", x), read_probability("a vertex", y)) for x, y in vertices]
    if len(curve) < 2 or curve[0][0] != 0 or curve[-1][0] != 1 or curve[-1][1] != 0:
        raise InputError("the vertices of a trade-off function run from level 0 to the vertex (1, 0)")
    if any(y > 1 - x for x, y in curve):
        raise InputError("a trade-off function is at most 1 minus the level; a vertex lies above that")
    slopes = []
    for (x, y), (x2, y2) in pairwise(curve):
        if x2 <= x or y2 > y:
            raise InputError("the vertices of a trade-off function have rising levels and values that do not rise")
        slopes.append((y2 - y) / (x2 - x))
    if any(right < left for left, right in pairwise(slopes)):
        raise InputError("the vertices are not those of a convex function; a trade-off function is convex")
    return curve


def _inverse(curve: list[tuple[Fraction, Fraction]]) -> list[tuple[Fraction, Fraction]]:
    """Vertices of f⁻¹(β) = min{α : f(α) ≤ β}."""
    first_zero = next(i for i, (_, y) in enumerate(curve) if y == 0)
    turned = [(y, x) for x, y in reversed(curve[: first_zero + 1])]
    return turned if turned[-1][0] == 1 else [*turned, (Fraction(1), Fraction(0))]


def _on_curve(curve: list[tuple[Fraction, Fraction]], level: Fraction) -> tuple[Fraction, Fraction]:
    """f(t) and the k = −f'(t) of the piece that ends at or contains t."""
    for (x, y), (x2, y2) in pairwise(curve):
        if level <= x2:
            k = (y - y2) / (x2 - x)
            return y2 + k * (x2 - level), k
    raise AssertionError
