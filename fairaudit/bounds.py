"""Bounds on fairness ratios that follow from the privacy of the filters (theorems T1 to T12), each with its evidence.

Throughout, E(x,a) is the expected utility of group a in context x, R the greatest ratio of two of them in one context, γ the greatest
and m the least utility, τ a floor under every compared E(x,a), t = τ/γ, K the greatest difference of utility between two groups for the
same decision and context (L_A·d), and H_k(P,Q) = Σ max(0, P − kQ) the hockey stick of an ordered pair of rows of the group filter.

A bound is proved by one rational k per ordered pair of rows, its multiplier, through one inequality, valid for every k ≥ 0:

======== ============================================== =====================================
theorem  inequality                                     holds because
======== ============================================== =====================================
T1       R ≤ k + (K + γ·H_k)/τ                          E(a) ≤ K + k·E(a') + γ·H_k
T2       R ≤ k where H_k = 0                            P ≤ k·Q
T3       R ≤ k + (K + (γ − K)·H_k)/τ                    the utility of a is at most min(γ, that of a' + K)
T4       R ≤ k + max(0, (γ − m)·H_k − (k − 1)·m)/τ      utilities lie in [m, γ]
T10      chance ratio ≤ k + H_k(exchange)/τ             exchanging two persons changes two profiles
T12      R ≤ (1 + R0·k)/(R0 + k) where H_k = 0          P ≤ k·Q and Q ≤ k·P
======== ============================================== =====================================

Each is taken together with the cap R ≤ γ/τ, for which the multiplier 0 stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, permutations, product
from math import erfc, gcd, inf, isqrt, lcm, nextafter, sqrt
from statistics import NormalDist
from typing import Any, Literal, TypeVar

from fairaudit.columns import Label
from fairaudit.exact import InputError, at_least, exp_enclosure, log_enclosure, shown
from fairaudit.fairness import cell_expectation
from fairaudit.law import Law
from fairaudit.mechanism import Factor, Mechanism
from fairaudit.privacy import PairLaw, hockey_stick, pair_laws, power
from fairaudit.utility import UtilityTable

__all__ = [
    "Bound",
    "context_ratio",
    "exchange_laws",
    "floor_cap",
    "t1",
    "t1_paper",
    "t1_tight",
    "t2",
    "t3_approx",
    "t3_curve",
    "t3_gdp",
    "t3_general",
    "t3_mechanism",
    "t3_randomized_response",
    "t3_renyi",
    "t3_zcdp",
    "t4",
    "t5_decision",
    "t5_floor",
    "t5_general",
    "t5_independent",
    "t7",
    "t7_pair",
    "t8_applies",
    "t10",
    "t10_floor",
    "t11_refutes",
    "t12",
]

Extended = Fraction | float
Floor = Literal["table", "declared", "policy"]
Distance = Any | Callable[[Label, Label], Any]
T = TypeVar("T")

THIS_LAW = "this law"
THIS_POLICY = "this policy and context filter, any group filter at most this epsilon that releases the same values"
ANY_POLICY = "any policy behind this filter"
FLOORED = "any policy behind this filter that keeps the declared floor"

FRESH = (
    "the filter's draws for group and context are independent of each other and of everything else, fresh for each decision, and the "
    "decision depends on group and context only through what the filters release"
)
GROUP_FREE = "the utility does not depend on the group"
DECISION_ONLY = "the utility depends on the decision alone"
INDEPENDENT = "context and group are independent in the population"
POPULATION = "the contexts of each group are distributed as in the stated population"
ORDER = (
    "the order of the candidates is drawn uniformly from all orders, independently of everything else, unseen by the policy and fresh for "
    "each decision; the same filter serves every candidate, and nothing else travels with a candidate"
)
BITS = 128
MAX_EXPONENT = 10_000
GAUSS_SLACK = 2.0**-34
LEAST_LEVEL = 1e-290


@dataclass(frozen=True)
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


# T1: any utility, floor


def floor_cap(gamma: Any, tau: Any, *, floor: Floor = "table") -> Bound:
    """Bound R by γ/τ, with no privacy at all.

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
    top, low = _range(gamma, tau)
    scope, extra = _floor_terms(floor, f"{low}", any_filter=True, trivial=low == 0)
    if floor == "policy":
        extra = (FRESH,)
    if low == 0:
        return Bound("T1", "local_ratio", inf, {"gamma": top, "tau": low}, (), extra, scope, note="a floor of 0 caps nothing")
    return Bound("T1", "local_ratio", top / low, {"gamma": top, "tau": low}, (Fraction(0),), extra, scope)


def t1(mechanism: Mechanism, gamma: Any, tau: Any, K: Distance = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T1, tight: the least over k of k + (K + γ·H_k)/τ, greatest over the ordered pairs of rows, capped at γ/τ.

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
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> bound = t1(RandomizedResponse(["a", "b"], keep_probability="0.7"), 1, "0.5", "0.1")
    >>> bound.value, bound.multipliers
    (Fraction(62, 35), (Fraction(3, 7),))
    """
    return _additive("T1", mechanism, gamma, tau, K, floor, lambda top, _: top)


def t1_paper(exp_epsilon: Any, delta: Any, gamma: Any, tau: Any, K: Any = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T1 as the paper states it: R ≤ e^ε·(1 + (K + δγ)/τ), capped at γ/τ; never below `t1_tight`.

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

    Examples
    --------
    >>> t1_tight(2, 0, 1, 0, "0.1").note
    'with a floor of 0 and K or delta above 0 one group may get nothing where another gets something'
    """
    return _privacy_floor(exp_epsilon, delta, gamma, tau, K, floor, lambda e, excess: e + excess)


# T2: pure privacy, no floor


def t2(exp_epsilon: Any) -> Bound:
    """T2: behind a purely ε-private group filter R ≤ e^ε, for every policy and every utility that ignores the group; no floor.

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
    factor = _factor(exp_epsilon)
    note = "" if isinstance(factor, Fraction) else "the filter is not purely private: some output is possible for one group only"
    assumptions = (FRESH, GROUP_FREE, _private(factor, Fraction(0)))
    return Bound("T2", "local_ratio", factor, _finite(exp_epsilon=factor), _kept(factor), assumptions, ANY_POLICY, note=note)


# T3: utility that ignores the group, floor


def t3_approx(exp_epsilon: Any, delta: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for (ε,δ)-privacy: R ≤ min{1/t, e^ε + δ/t, (1 − e^(−ε)·(1 − δ − t))/t}; attained.

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
    factor, part, level = _factor(exp_epsilon), _probability("delta", delta), _level(t)
    value, k = _approximate(factor, part, level)
    scope, extra = _floor_terms(floor, f"{level} of the greatest utility", any_filter=True)
    assumptions = (FRESH, GROUP_FREE, _private(factor, part), *extra)
    return Bound("T3", "local_ratio", value, _finite(exp_epsilon=factor, delta=part, t=level), (k,), assumptions, scope)


def t3_mechanism(mechanism: Mechanism, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for a known group filter: the greatest power at level t over its ordered pairs of rows, divided by t; attained by some policy.

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
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> t3_mechanism(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"), "0.5").value
    Fraction(3, 2)
    """
    level = _level(t)
    value, multipliers = _worst(
        pair_laws(mechanism), lambda pair: _power_ratio(pair, level), lambda pair, k: k + hockey_stick(pair, k) / level
    )
    scope, extra = _floor_terms(floor, f"{level} of the greatest utility", any_filter=False)
    return Bound("T3", "local_ratio", value, {"t": level}, multipliers, (FRESH, GROUP_FREE, *extra), scope)


def t3_randomized_response(k: int, keep_probability: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for k-ary randomized response in closed form; equal to `t3_mechanism`.

    With keep probability p ≥ 1/k and q = (1 − p)/(k − 1): p/q where t ≤ q, 1 + (p − q)/t between, (1 − (1 − t)·q/p)/t where t ≥ 1 − p.

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
    keep, level = _probability("keep_probability", keep_probability), _level(t)
    if keep < Fraction(1, k):
        raise InputError(f"keep_probability is {keep}, below 1/{k}: the truth would be less likely than each lie; give at least 1/{k}")
    lie = (1 - keep) / (k - 1)
    if level <= lie:
        multiplier, value = keep / lie, keep / lie
    elif level <= 1 - keep:
        multiplier, value = Fraction(1), 1 + (keep - lie) / level
    else:
        multiplier, value = lie / keep, (1 - (1 - level) * lie / keep) / level
    scope, extra = _floor_terms(floor, f"{level} of the greatest utility", any_filter=False)
    constants = {"values": Fraction(k), "keep_probability": keep, "t": level}
    response = f"the group filter is randomized response over {k} values that keeps the truth with probability {keep}"
    return Bound("T3", "local_ratio", value, constants, (multiplier,), (FRESH, GROUP_FREE, response, *extra), scope)


def t3_gdp(mu: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for μ-Gaussian privacy: R ≤ Φ(Φ⁻¹(t) + μ)/t, in floating point, enlarged by a relative 2⁻³⁴ and capped at 1/t.

    Not certified: Φ was evaluated in float64, whose error is far below the margin but is not proved here. Below t = 1e-290, where float64
    has no digits to spare, the value is 1/t.

    Parameters
    ----------
    mu : number or str
        μ ≥ 0, for every ordered pair of inputs.
    t, floor
        As in `t3_approx`.

    Returns
    -------
    Bound
        On the local ratio, `certified` false.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> round(float(t3_gdp(1, "0.5").value), 6), t3_gdp(1, "0.5").certified
    (1.682689, False)
    """
    shift, level = at_least("mu", mu, 0), _level(t)
    value = 1 / level
    rough = float(level)
    if Fraction(rough) < level:
        rough = nextafter(rough, 1.0)
    if shift == 0:
        value = Fraction(1)
    elif LEAST_LEVEL < rough < 1.0 and shift < 100:
        reached = erfc(-(NormalDist().inv_cdf(rough) + float(shift)) / sqrt(2)) / 2
        value = min(value, Fraction(nextafter(reached * (1 + GAUSS_SLACK), inf)) / level)
    scope, extra = _floor_terms(floor, f"{level} of the greatest utility", any_filter=True)
    premise = f"the group filter is {shift}-Gaussian differentially private for every ordered pair of its inputs"
    note = "evaluated in floating point and rounded up; not certified"
    return Bound("T3", "local_ratio", value, {"mu": shift, "t": level}, (), (FRESH, GROUP_FREE, premise, *extra), scope, False, note)


def t3_renyi(order: Any, rho: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for Rényi privacy of order α: the least of e^((α−1)ρ/α)·t^(−1/α), (1 − e^(−ρ)·(1−t)^(α/(α−1)))/t and 1/t, rounded up.

    The value is a rigorous rational upper end, but the exponentials behind it are not among what a certificate can show in integers:
    `certified` is false for that reason alone.

    Parameters
    ----------
    order : number or str
        α > 1.
    rho : number or str
        Rényi divergence of that order in nats, ρ ≥ 0, for every ordered pair of inputs.
    t, floor
        As in `t3_approx`.

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
    >>> round(float(t3_renyi(2, "0.1", "0.5").value), 6)
    1.486722
    """
    alpha, loss, level = at_least("order", order, 1), at_least("rho", rho, 0), _level(t)
    if alpha == 1:
        raise InputError("the order is 1; an order above 1 is accepted")
    ends = [1 / level]
    if loss == 0:
        ends.append(Fraction(1))
    elif level < 1:
        ends += _exp_up(((alpha - 1) * loss + _log_up(1 / level)) / alpha)
        ends.append((1 - _exp_down(loss + alpha / (alpha - 1) * _log_up(1 / (1 - level)))) / level)
    premise = f"the Rényi divergence of order {alpha} between any two rows of the group filter is at most {loss}"
    return _enclosed(min(ends), {"order": alpha, "rho": loss, "t": level}, premise, floor)


def t3_zcdp(rho: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for ρ-zCDP: log R ≤ 2√(ρ·log(1/t)) − ρ where ρ < log(1/t), R ≤ (1 − e^(−(√ρ + √log(1/(1−t)))²))/t, and 1/t; the least.

    Rounded up and not certified, for the reason given at `t3_renyi`.

    Parameters
    ----------
    rho : number or str
        ρ ≥ 0: the Rényi divergence of every order α is at most ρα, for every ordered pair of inputs.
    t, floor
        As in `t3_approx`.

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
    >>> round(float(t3_zcdp("0.1", "0.1").value), 6)
    2.362464
    """
    loss, level = at_least("rho", rho, 0), _level(t)
    ends = [1 / level]
    if loss == 0:
        ends.append(Fraction(1))
    elif level < 1:
        depth, other = _log_up(1 / level), _log_up(1 / (1 - level))
        if loss < depth:
            ends += _exp_up(2 * _root_up(loss * depth) - loss)
        ends.append((1 - _exp_down(loss + other + 2 * _root_up(loss * other))) / level)
    premise = f"the group filter is {loss}-zero-concentrated differentially private for every ordered pair of its inputs"
    return _enclosed(min(ends), {"rho": loss, "t": level}, premise, floor)


def t3_curve(vertices: Sequence[tuple[Any, Any]], t: Any, *, orders: Literal["both", "one"], floor: Floor = "table") -> Bound:
    """T3 for a trade-off function given by its vertices: R ≤ (1 − f(t))/t.

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
    level = _level(t)
    if orders not in ("both", "one"):
        raise InputError(f"orders={shown(orders)} is not accepted; use 'both' or 'one'")
    curve = _curve(vertices)
    found = [_on_curve(curve, level), _on_curve(_inverse(curve), level)]
    height, slope = max(found) if orders == "both" else min(found)
    multipliers = (slope,) if orders == "both" else tuple(sorted({k for _, k in found}, reverse=True))
    both = "in both orders" if orders == "both" else "in at least one order"
    premise = f"the trade-off function of every pair of rows of the group filter lies above the stated curve {both}"
    scope, extra = _floor_terms(floor, f"{level} of the greatest utility", any_filter=True)
    return Bound("T3", "local_ratio", (1 - height) / level, {"t": level}, multipliers, (FRESH, GROUP_FREE, premise, *extra), scope)


def t3_general(mechanism: Mechanism, gamma: Any, tau: Any, K: Distance = 0, *, floor: Floor = "table") -> Bound:  # noqa: N803
    """T3 for a utility that may depend on the group: R ≤ (K + (γ−K)·(1 − f(τ/(γ−K))))/τ where τ ≤ γ − K, else γ/τ; never above `t1`.

    Parameters, result and errors as in `t1`.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.6")
    >>> t3_general(coin, 1, "0.4", "0.1").value, t1(coin, 1, "0.4", "0.1").value
    (Fraction(5, 3), Fraction(7, 4))
    """
    return _additive("T3", mechanism, gamma, tau, K, floor, lambda top, gap: top - gap)


# T4: utility with a floor of its own


def t4(mechanism: Mechanism, gamma: Any, g_min: Any, tau: Any = None, *, floor: Floor = "table") -> Bound:
    """T4: utilities in [m, γ] with m > 0. R ≤ the least over k of k + max(0, (γ−m)·H_k − (k−1)·m)/τ, greatest over ordered pairs.

    That is the greatest (m + (γ−m)(1−f(s)))/(m + (γ−m)s) over s ≥ (τ−m)/(γ−m), exactly. Waiting times and positions are such utilities.

    Parameters
    ----------
    mechanism : Mechanism
        The group filter.
    gamma, g_min : number or str
        Greatest and least utility, 0 ≤ m ≤ γ, γ > 0.
    tau : number or str, optional
        Floor under every compared expected utility, m ≤ τ ≤ γ. Left out it is m, and the bound holds for every policy.
    floor : {"table", "declared", "policy"}
        As in `t3_mechanism`; without meaning when τ is m.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range, or the floor is 0.

    Examples
    --------
    >>> from fairaudit.mechanism import Identity, RandomizedResponse
    >>> t4(RandomizedResponse(["a", "b"], keep_probability="0.9"), 3, 1).value
    Fraction(7, 3)
    >>> t4(Identity(["a", "b"]), 3, 1).value
    Fraction(3, 1)
    """
    top, least = _range(gamma, 0)[0], at_least("g_min", g_min, 0)
    low = least if tau is None else at_least("tau", tau, 0)
    if least > top:
        raise InputError(f"g_min is {least}, above gamma, which is {top}; the least utility is at most the greatest")
    if not least <= low <= top:
        raise InputError(f"tau is {low}; a floor between g_min, which is {least}, and gamma, which is {top}, is accepted")
    if low == 0:
        raise InputError("tau is 0; this bound needs a floor above 0, or a least utility above 0")
    value, multipliers = _worst(
        pair_laws(mechanism),
        lambda pair: _least_over_k(pair, top, least, low),
        lambda pair, k: _with_least(k, hockey_stick(pair, k), top, least, low),
    )
    scope, extra = _floor_terms(floor, f"{low}", any_filter=False, trivial=low == least)
    assumptions = (FRESH, GROUP_FREE, *extra)
    return Bound("T4", "local_ratio", value, {"gamma": top, "g_min": least, "tau": low}, multipliers, assumptions, scope)


# T5: from local to global


def t5_independent(local_ratio: Any) -> Bound:
    """T5: where context and group are independent the global ratio is at most the local one.

    Parameters
    ----------
    local_ratio : number, str or Bound
        R ≥ 1 (or `math.inf`) of a law, or a bound on it, whose evidence, assumptions and scope then carry over.

    Returns
    -------
    Bound
        On the global ratio. Without independence it is false: every context can be fair while the groups are spread differently.

    Raises
    ------
    InputError
        If the ratio is below 1, or the bound is on something else.

    Examples
    --------
    >>> t5_independent(t2(2)).quantity
    'global_ratio'
    """
    if isinstance(local_ratio, Bound):
        if local_ratio.quantity != "local_ratio":
            raise InputError(f"the bound is on {local_ratio.quantity}; T5 starts from a bound on the local ratio")
        return replace(local_ratio, theorem="T5", quantity="global_ratio", assumptions=(*local_ratio.assumptions, INDEPENDENT))
    ratio = _ratio("the local ratio", local_ratio)
    return Bound("T5", "global_ratio", ratio, _finite(local_ratio=ratio), (), (INDEPENDENT,), THIS_LAW)


def t5_general(law: Law, utility: UtilityTable) -> Bound:
    """T5 without independence: the global ratio is at most the greatest P(x|a)·E(x,a) / (P(x|a')·E(x,a')) over contexts and pairs.

    Parameters
    ----------
    law : Law
        The law, with its population.
    utility : UtilityTable
        The utility on that law.

    Returns
    -------
    Bound
        On the global ratio. It is at most R times `context_ratio`.

    Raises
    ------
    InputError
        If the law has no population over which two groups can be compared.

    Examples
    --------
    >>> from fairaudit.utility import Utility
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [3, 1]]], kind="counts", decisions=["yes", "no"])
    >>> t5_general(law, Utility({"yes": 1}).on(law)).value
    Fraction(3, 2)
    """
    shares = _shares(law)
    parts: dict[int, dict[int, Fraction]] = {group: {} for group in shares}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        if a in shares and shares[a].get(x):
            parts[a][x] = shares[a][x] * Fraction(*cell_expectation(law, utility, cell))
    value = _termwise(parts)
    return Bound("T5", "global_ratio", value, {}, (), (POPULATION,), THIS_LAW)


def context_ratio(law: Law, context_filter: Mechanism | None = None) -> Extended:
    """Find the greatest P(x|a)/P(x|a') over contexts and groups; with a filter, the same of the released contexts x̃.

    Parameters
    ----------
    law : Law
        The law, with its population.
    context_filter : Mechanism, optional
        The context filter; its inputs are the contexts of the law.

    Returns
    -------
    Fraction or float
        At least 1; `math.inf` if a context occurs in one group only.

    Raises
    ------
    InputError
        If the law has no population over which two groups can be compared, or the filter does not know a context.

    Examples
    --------
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [3, 1]]], kind="counts")
    >>> context_ratio(law)
    Fraction(3, 2)
    """
    shares = _shares(law)
    if context_filter is None:
        return _termwise(shares)
    released: dict[int, dict[int, Fraction]] = {}
    for group, masses in shares.items():
        mixed = released.setdefault(group, {})
        for x, mass in masses.items():
            for place, weight in enumerate(context_filter.row(law.contexts[x])):
                if weight and mass:
                    mixed[place] = mixed.get(place, Fraction(0)) + mass * Fraction(weight, context_filter.denominator)
    return _termwise(released)


def t5_decision(
    exp_epsilon_group: Any, utility: UtilityTable, *, released_ratio: Any = inf, exp_epsilon_context: Any = inf, context_ratio: Any = inf
) -> Bound:
    """T5 for g = g(u): the global ratio is at most e^(ε_A) times the greatest P(x̃|a)/P(x̃|a').

    That in turn is at most e^(ε_X) and at most the greatest P(x|a)/P(x|a').

    Parameters
    ----------
    exp_epsilon_group : number or str
        e^(ε_A) ≥ 1 of the group filter (or `math.inf`).
    utility : UtilityTable
        The utility; it must depend on the decision alone (for g(u,x) the statement is false).
    released_ratio, exp_epsilon_context, context_ratio : number or str
        What is known, each ≥ 1: the greatest P(x̃|a)/P(x̃|a') (see `context_ratio`), e^(ε_X) of the context filter, the greatest
        P(x|a)/P(x|a'). The least of them counts.

    Returns
    -------
    Bound
        On the global ratio, for every policy.

    Raises
    ------
    InputError
        If the utility depends on more than the decision, or a number is below 1.

    Examples
    --------
    >>> from fairaudit.utility import Utility
    >>> law = Law.from_array([[1, 1], [1, 1]], decisions=["yes", "no"], kind="counts")
    >>> t5_decision(2, Utility({"yes": 1}).on(law), exp_epsilon_context=3).value
    Fraction(6, 1)
    """
    if not utility.by_decision:
        raise InputError("the utility depends on context or group; this bound holds only for a utility that depends on the decision alone")
    factor = _factor(exp_epsilon_group)
    spreads = {
        "released_ratio": _ratio("released_ratio", released_ratio),
        "exp_epsilon_context": _ratio("exp_epsilon_context", exp_epsilon_context),
        "context_ratio": _ratio("context_ratio", context_ratio),
    }
    least = min(spreads.values())
    value = factor * least
    within = spreads["exp_epsilon_context"]
    spread = _private(within, Fraction(0), "the context filter") if within == least < inf else POPULATION
    assumptions = (FRESH, DECISION_ONLY, _private(factor, Fraction(0)), spread)
    constants = _finite(exp_epsilon_group=factor, **spreads)
    note = "" if isinstance(value, Fraction) else "neither filter nor population bounds the ratio"
    return Bound("T5", "global_ratio", value, constants, _kept(factor), assumptions, ANY_POLICY, note=note)


def t5_floor(law: Law, mechanism: Mechanism, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for the global ratio: the rows P(x|a)·M(ã|a) in place of the filter's, and the floor under the group means.

    Parameters
    ----------
    law : Law
        The law, for its population.
    mechanism : Mechanism
        The group filter; its inputs are the groups of the law.
    t : number or str
        Floor under every group's mean utility, as a part of the greatest utility, in (0, 1].
    floor : {"table", "declared", "policy"}
        As in `t3_mechanism`.

    Returns
    -------
    Bound
        On the global ratio, for a utility that ignores the group (it may depend on the context).

    Raises
    ------
    InputError
        If t is out of range, there is no population, or the filter does not know a group.

    Examples
    --------
    >>> from fairaudit.mechanism import Constant
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [3, 1]]], kind="counts", groups=["a", "b"])
    >>> t5_floor(law, Constant(["a", "b"]), "0.5").value
    Fraction(4, 3)
    """
    level = _level(t)
    shares = _shares(law)
    contexts = sorted({x for masses in shares.values() for x in masses})
    bottom = lcm(*(mass.denominator for masses in shares.values() for mass in masses.values()))
    rows = []
    for group, masses in shares.items():
        row = mechanism.row(law.groups[group])
        rows.append(tuple(int(masses.get(x, 0) * bottom) * weight for x in contexts for weight in row))
    names = tuple(law.groups[group] for group in shares)
    outputs = tuple((*law.contexts[x], *released) for x in contexts for released in mechanism.outputs)
    joint = Mechanism((Factor(names, outputs, tuple(rows), bottom * mechanism.denominator),))
    found = t3_mechanism(joint, level, floor=floor)
    scope, extra = _floor_terms(floor, f"{level} of the greatest utility", any_filter=False, mean=True)
    return replace(found, theorem="T5", quantity="global_ratio", assumptions=(FRESH, GROUP_FREE, POPULATION, *extra), scope=scope)


# T7: distances from suprema


def t7(supremum: Any, *, quantity: Literal["equalized_odds", "demographic_parity"] = "equalized_odds") -> Bound:
    """T7: from the supremum R* of the ratio over all utilities that ignore the group, a distance of at most (R*−1)/(R*+1).

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
    ratio = _ratio("the supremum", supremum)
    return Bound("T7", quantity, _halved(ratio), _finite(supremum=ratio), (), (), THIS_LAW)


def t7_pair(first: Any, second: Any) -> Fraction:
    """T7 for one pair of groups: TV ≤ (R1−1)(R2−1)/(R1·R2−1) from the one-sided suprema R1 = max P/Q and R2 = max Q/P.

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
    one, other = _ratio("the first supremum", first), _ratio("the second supremum", second)
    if one == 1 or other == 1:
        return Fraction(0)
    if isinstance(one, Fraction) and isinstance(other, Fraction):
        return (one - 1) * (other - 1) / (one * other - 1)
    finite = one if isinstance(one, Fraction) else other
    return 1 - 1 / finite if isinstance(finite, Fraction) else Fraction(1)


# T8: filtering the context


def t8_applies(law: Law, utility: UtilityTable, context_filter: Mechanism) -> tuple[bool, str]:
    """Tell whether T8 applies: then a context filter cannot raise the local ratio above that of the law with unfiltered contexts.

    Parameters
    ----------
    law : Law
        The law with unfiltered contexts, its group filter and policy fixed.
    utility : UtilityTable
        The utility.
    context_filter : Mechanism
        The context filter; inputs and outputs are labels of contexts.

    Returns
    -------
    tuple of (bool, str)
        Whether it applies, and if not, why: the utility depends on more than the decision, or the filter can release something that is
        not itself a context in which all groups are compared. Nothing of the kind holds for the global ratio.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> from fairaudit.utility import Utility
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [0, 0]]], kind="counts", decisions=["yes", "no"])
    >>> t8_applies(law, Utility({"yes": 1}).on(law), RandomizedResponse(["0", "1"], keep_probability="0.7"))
    (False, "the filter can release the context '1', in which not all groups are compared")
    """
    if not utility.by_decision:
        return False, "the utility depends on context or group"
    members: dict[Label, int] = {}
    for x in law.cell_context.tolist():
        members[law.contexts[x]] = members.get(law.contexts[x], 0) + 1
    emitted = [any(row) for row in zip(*(context_filter.row(label) for label in context_filter.inputs), strict=True)]
    for label, possible in zip(context_filter.outputs, emitted, strict=True):
        if possible and members.get(label, 0) < len(law.groups):
            return False, f"the filter can release the context {shown(', '.join(label))}, in which not all groups are compared"
    return True, ""


# T10: two persons in one decision


def t10(profile_exp_epsilon: Any, tau: Any = None, *, floor: Floor = "table") -> Bound:
    """T10: in uniformly random order the chances of two persons differ by a factor of at most e^(2ε), ε of one profile's filter.

    Both profiles are filtered and exchanging two persons changes both: hence 2ε. With a floor under every chance, T3 at 2ε.

    Parameters
    ----------
    profile_exp_epsilon : number or str
        e^ε ≥ 1 of the filter of one profile (the whole tuple), or `math.inf`.
    tau : number or str, optional
        Floor under the chance of every compared person, in (0, 1/2].
    floor : {"table", "declared", "policy"}
        Where that floor comes from, as in `floor_cap`.

    Returns
    -------
    Bound
        On the selection ratio. It says nothing about slots: report the effect of the position apart.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> t10(2).value, t10(2, "0.4").value
    (Fraction(4, 1), Fraction(17, 8))
    """
    factor = _factor(profile_exp_epsilon)
    doubled = factor * factor
    constants = _finite(profile_exp_epsilon=factor, exp_epsilon=doubled)
    premise = _private(factor, Fraction(0), "each candidate's profile filter")
    if tau is None:
        note = "" if isinstance(factor, Fraction) else "the profile filter is not purely private; give a floor"
        return Bound("T10", "selection_ratio", doubled, constants, _kept(doubled), (FRESH, ORDER, premise), ANY_POLICY, note=note)
    chance = _chance(tau)
    value, k = _approximate(doubled, Fraction(0), chance)
    scope, extra = _floor_terms(floor, f"{chance}", any_filter=True, chance=True)
    return Bound("T10", "selection_ratio", value, {**constants, "tau": chance}, (k,), (FRESH, ORDER, premise, *extra), scope)


def t10_floor(mechanism: Mechanism, tau: Any, *, floor: Floor = "table") -> Bound:
    """T10 with a floor under the chances and a known profile filter: the power at level τ of the exchange of two profiles, divided by τ.

    Parameters
    ----------
    mechanism : Mechanism
        The filter of one profile.
    tau : number or str
        Floor under the chance of every compared person, in (0, 1/2].
    floor : {"table", "declared", "policy"}
        As in `t3_mechanism`.

    Returns
    -------
    Bound
        On the selection ratio; the multipliers refer to `exchange_laws`.

    Raises
    ------
    InputError
        If the floor is out of range.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> t10_floor(RandomizedResponse(["a", "b", "c"], exp_epsilon=2), "0.4").value
    Fraction(57, 32)
    """
    chance = _chance(tau)
    value, multipliers = _worst(
        exchange_laws(mechanism), lambda pair: _power_ratio(pair, chance), lambda pair, k: k + hockey_stick(pair, k) / chance
    )
    scope, extra = _floor_terms(floor, f"{chance}", any_filter=False, chance=True)
    return Bound("T10", "selection_ratio", value, {"tau": chance}, multipliers, (FRESH, ORDER, *extra), scope)


def exchange_laws(mechanism: Mechanism) -> tuple[PairLaw, ...]:
    """List the distinct pairs M(a)⊗M(b) against M(b)⊗M(a): what a policy sees before and after two candidates are exchanged.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> exchange_laws(RandomizedResponse(["a", "b"], exp_epsilon=2))[0].columns
    ((4, 1), (4, 4), (1, 4))
    """
    found: dict[tuple[tuple[int, int], ...], PairLaw] = {}
    for pair in pair_laws(mechanism):
        sums: dict[tuple[int, int], list[int]] = {}
        for (p, q), (r, s) in product(pair.columns, repeat=2):
            top, bottom = p * s, q * r
            common = gcd(top, bottom)
            if common:
                total = sums.setdefault((top // common, bottom // common), [0, 0])
                total[0] += top
                total[1] += bottom
        listed = sorted(sums.values(), key=lambda entry: (entry[1] > 0, -Fraction(*entry) if entry[1] else 0))
        common = gcd(*(v for entry in listed for v in entry))
        columns = tuple((p // common, q // common) for p, q in listed)
        found.setdefault(columns, PairLaw(columns, sum(p for p, _ in columns), pair.first, pair.second))
    return tuple(found.values())


# T11 and T12


def t11_refutes(measured_ratio_lower: Any, exp_epsilon: Any) -> bool:
    """T11: a measured ratio above e^ε refutes that the filter is ε-private or that its draws are fresh and independent.

    The utility must ignore the group and be fixed beforehand, and the decisions must come through the deployed filter at true values:
    a law composed from a known filter and policy can refute nothing.

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
    factor = _factor(exp_epsilon)
    measured = inf if _infinite(measured_ratio_lower) else at_least("the measured ratio", measured_ratio_lower, 0)
    return bool(measured > factor)


def t12(exp_epsilon: Any, raw_ratio: Any) -> Bound:
    """T12: a pure ε contracts the policy's own ratio R0: R ≤ (1 + R0·e^ε)/(R0 + e^ε), that is tanh(L/2) ≤ tanh(L0/2)·tanh(ε/2).

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
    factor, raw = _factor(exp_epsilon), _ratio("the policy's own ratio", raw_ratio)
    if isinstance(factor, Fraction) and isinstance(raw, Fraction):
        value: Extended = (1 + raw * factor) / (raw + factor)
    else:
        value = min(factor, raw)
    note = "" if isinstance(value, Fraction) else "neither the filter nor the policy bounds the ratio"
    assumptions = (FRESH, GROUP_FREE, _private(factor, Fraction(0)))
    return Bound(
        "T12", "local_ratio", value, _finite(exp_epsilon=factor, raw_ratio=raw), _kept(factor), assumptions, THIS_POLICY, note=note
    )


# Reading numbers


def _infinite(value: object) -> bool:
    return isinstance(value, float) and value == inf


def _ratio(name: str, value: Any) -> Extended:
    return inf if _infinite(value) else at_least(name, value, 1)


def _factor(exp_epsilon: Any) -> Extended:
    return _ratio("exp_epsilon (e to the power epsilon)", exp_epsilon)


def _probability(name: str, value: Any) -> Fraction:
    number = at_least(name, value, 0)
    if number > 1:
        raise InputError(f"{name} is {shown(value)}; a number from 0 to 1 is accepted")
    return number


def _level(t: Any) -> Fraction:
    number = at_least("t", t, 0)
    if not 0 < number <= 1:
        raise InputError(f"t is {shown(t)}; a floor above 0 and at most 1, as a part of the greatest utility, is accepted")
    return number


def _chance(tau: Any) -> Fraction:
    number = at_least("tau", tau, 0)
    if not 0 < number <= Fraction(1, 2):
        raise InputError(f"tau is {shown(tau)}; a chance above 0 and at most 1/2, that of every one of at least two persons, is accepted")
    return number


def _range(gamma: Any, tau: Any) -> tuple[Fraction, Fraction]:
    top, low = at_least("gamma", gamma, 0), at_least("tau", tau, 0)
    if top == 0:
        raise InputError("gamma is 0; the greatest utility must be above 0")
    if low > top:
        raise InputError(f"tau is {shown(tau)}, above gamma, which is {shown(gamma)}; a floor of at most the greatest utility is accepted")
    return top, low


# Words


def _floor_terms(
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
        return FLOORED, (f"every {who} is at least {amount} behind the filter (declared)",)
    return (THIS_POLICY if floor == "policy" and any_filter else THIS_LAW), ()


def _private(factor: Extended, delta: Fraction, who: str = "the group filter") -> str:
    more = f" plus {delta}" if delta else ""
    return f"{who} multiplies the probability of any event by at most {factor}{more} between any two inputs, in either order"


def _gap(gap: Fraction) -> str:
    return f"the utilities of two groups differ by at most {gap} for the same decision and context" if gap else GROUP_FREE


def _finite(**numbers: Extended) -> dict[str, Fraction]:
    return {name: value for name, value in numbers.items() if isinstance(value, Fraction)}


def _kept(factor: Extended) -> tuple[Fraction, ...]:
    return (factor,) if isinstance(factor, Fraction) else ()


# One k per ordered pair


def _worst(
    pairs: Iterable[T], best: Callable[[T], tuple[Fraction, Fraction]], proves: Callable[[T, Fraction], Fraction]
) -> tuple[Fraction, tuple[Fraction, ...]]:
    """Greatest of the pairs' best values, and multipliers that prove it for all of them; pairs that an earlier k proves add none."""
    found = sorted(((*best(pair), pair) for pair in pairs), key=lambda entry: -entry[0])
    value = found[0][0] if found else Fraction(1)
    kept: list[Fraction] = []
    for _, k, pair in found:
        if k not in kept and not any(proves(pair, other) <= value for other in kept):
            kept.append(k)
    return value, tuple(sorted(kept, reverse=True))


def _power_ratio(pair: PairLaw, level: Fraction) -> tuple[Fraction, Fraction]:
    gained, k = power(pair, level)
    return gained / level, k


def _classes(mechanism: Mechanism, gap: Distance) -> list[tuple[PairLaw, Fraction]]:
    """Distinct ordered pairs of rows, each with the greatest K of the input pairs that have this form."""
    if not callable(gap):
        number = at_least("K", gap, 0)
        return [(pair, number) for pair in pair_laws(mechanism)]
    found: dict[tuple[tuple[int, int], ...], tuple[PairLaw, Fraction]] = {}
    rows = {label: mechanism.row(label) for label in mechanism.inputs}
    for first, second in permutations(rows, 2):
        number = at_least(f"K of {first} and {second}", gap(first, second), 0)
        two = Factor((first, second), mechanism.outputs, (rows[first], rows[second]), mechanism.denominator)
        # A factor of two inputs has this ordered pair and the reverse; both get K, which is that of a metric.
        for pair in pair_laws(Mechanism((two,))):
            known = found.get(pair.columns)
            if known is None or known[1] < number:
                found[pair.columns] = (pair, number)
    return list(found.values())


def _additive(
    theorem: str,
    mechanism: Mechanism,
    gamma: Any,
    tau: Any,
    gap: Distance,
    floor: Floor,
    weight: Callable[[Fraction, Fraction], Fraction],
) -> Bound:
    """R ≤ k + (K + w·H_k)/τ, with w = γ (T1) or γ − K (T3), capped at γ/τ."""
    top, low = _range(gamma, tau)
    classes = [(pair, min(number, top)) for pair, number in _classes(mechanism, gap)]
    largest = max((number for _, number in classes), default=Fraction(0))
    constants = {"gamma": top, "tau": low, "K": largest}
    scope, extra = _floor_terms(floor, f"{low}", any_filter=False, trivial=low == 0)
    assumptions = (FRESH, _gap(largest), *extra)
    if low == 0:
        pure = max((_pure(pair) for pair, _ in classes), default=Fraction(1))
        if largest == 0 and isinstance(pure, Fraction):
            return Bound(theorem, "local_ratio", pure, constants, (pure,), assumptions, scope)
        return Bound(theorem, "local_ratio", inf, constants, (), assumptions, scope, note=NO_FLOOR)

    def best(entry: tuple[PairLaw, Fraction]) -> tuple[Fraction, Fraction]:
        pair, number = entry
        span = weight(top, number)
        if span < low:
            return top / low, Fraction(0)
        gained, k = power(pair, low / span)
        value = (number + span * gained) / low
        return (value, k) if value < top / low else (top / low, Fraction(0))

    def proves(entry: tuple[PairLaw, Fraction], k: Fraction) -> Fraction:
        pair, number = entry
        return top / low if k == 0 else k + (number + weight(top, number) * hockey_stick(pair, k)) / low

    value, multipliers = _worst(classes, best, proves)
    return Bound(theorem, "local_ratio", value, constants, multipliers, assumptions, scope)


NO_FLOOR = "with a floor of 0 and K or delta above 0 one group may get nothing where another gets something"


def _pure(pair: PairLaw) -> Extended:
    p, q = pair.columns[0]
    return Fraction(p, q) if q else inf


def _privacy_floor(
    exp_epsilon: Any, delta: Any, gamma: Any, tau: Any, gap: Any, floor: Floor, value_of: Callable[[Fraction, Fraction], Fraction]
) -> Bound:
    factor, part, number = _factor(exp_epsilon), _probability("delta", delta), at_least("K", gap, 0)
    top, low = _range(gamma, tau)
    constants = _finite(exp_epsilon=factor, delta=part, gamma=top, tau=low, K=number)
    scope, extra = _floor_terms(floor, f"{low}", any_filter=True, trivial=low == 0)
    assumptions = (FRESH, _gap(number), _private(factor, part), *extra)
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


def _approximate(factor: Extended, delta: Fraction, level: Fraction) -> tuple[Fraction, Fraction]:
    """(1 − f(t))/t of (ε,δ), and its k."""
    terms = [(1 / level, Fraction(0))]
    if isinstance(factor, Fraction):
        terms += [(factor + delta / level, factor), ((1 - (1 - delta - level) / factor) / level, 1 / factor)]
    return min(terms)


def _with_least(k: Fraction, stick: Fraction, top: Fraction, least: Fraction, low: Fraction) -> Fraction:
    """What a k proves by T4."""
    return k + max(Fraction(0), (top - least) * stick - (k - 1) * least) / low


def _least_over_k(pair: PairLaw, top: Fraction, least: Fraction, low: Fraction) -> tuple[Fraction, Fraction]:
    """Least value that one k proves by T4, and that k.

    The right side is convex and piecewise linear in k. It bends at the likelihood ratios and where the maximum with 0 does; there it equals
    the greatest ratio of means over the levels from (τ−m)/(γ−m) up, so that this ratio is the only other candidate.
    """
    if top == least:
        return Fraction(1), Fraction(1)
    scale = lcm(top.denominator, least.denominator, low.denominator)
    base, floor = int(least * scale), int(low * scale)
    span, bottom = int(top * scale) - base, pair.denominator
    start = (floor - base) * bottom  # of the levels, all of which are taken times span and bottom

    def with_least(n: int, d: int, stick: int) -> tuple[int, int]:
        """What n/d proves, with H_k = stick / (d * bottom)."""
        return n * floor * bottom + max(0, span * stick - (n - d) * base * bottom), d * floor * bottom

    tried = [(with_least(0, 1, bottom), (0, 1))]
    greatest = 0, 1
    spent, gained = 0, 0
    for p, q in pair.columns:
        if q:
            tried.append((with_least(p, q, gained * q - p * spent), (p, q)))
            entered = max(spent * span, start)
            if entered <= (spent + q) * span:
                above = q * (base * bottom + gained * span) + p * (entered - spent * span)
                below = q * (base * bottom + entered)
                if above * greatest[1] > greatest[0] * below:
                    greatest = above, below
        spent, gained = spent + q, gained + p
    stick = sum(max(0, p * greatest[1] - greatest[0] * q) for p, q in pair.columns)
    tried.append((with_least(*greatest, stick), greatest))
    best, k = tried[0]
    for value, other in tried[1:]:
        order = value[0] * best[1] - best[0] * value[1]
        if order < 0 or (order == 0 and other[0] * k[1] < k[0] * other[1]):
            best, k = value, other
    return Fraction(*best), Fraction(*k)


# Curves and enclosures


def _curve(vertices: Sequence[tuple[Any, Any]]) -> list[tuple[Fraction, Fraction]]:
    curve = [(_probability("a vertex", x), _probability("a vertex", y)) for x, y in vertices]
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


def _log_up(ratio: Fraction) -> Fraction:
    return Fraction(log_enclosure((ratio.numerator, ratio.denominator))[1])


def _exp_up(exponent: Fraction) -> list[Fraction]:
    """Upper end of e^q, or nothing where q is too large to matter."""
    if exponent > MAX_EXPONENT:
        return []
    return [Fraction(exp_enclosure((exponent.numerator, exponent.denominator), BITS)[1], 1 << BITS)]


def _exp_down(exponent: Fraction) -> Fraction:
    """Lower end of e^(−q)."""
    return 1 / _exp_up(exponent)[0] if exponent <= MAX_EXPONENT else Fraction(0)


def _root_up(value: Fraction) -> Fraction:
    scale = 1 << BITS
    return Fraction(isqrt(value.numerator * scale * scale // value.denominator) + 1, scale)


def _enclosed(value: Fraction, constants: dict[str, Fraction], premise: str, floor: Floor) -> Bound:
    scope, extra = _floor_terms(floor, f"{constants['t']} of the greatest utility", any_filter=True)
    note = "the upper end of an enclosure of a real number; the enclosure is not part of the certificate"
    return Bound("T3", "local_ratio", value, constants, (), (FRESH, GROUP_FREE, premise, *extra), scope, False, note)


def _halved(ratio: Extended) -> Fraction:
    return (ratio - 1) / (ratio + 1) if isinstance(ratio, Fraction) else Fraction(1)


# Populations


def _shares(law: Law) -> dict[int, dict[int, Fraction]]:
    """P(x|a) of the globally compared groups."""
    if not law.global_groups:
        raise InputError("the table has no population over which groups could be compared; give weights, or every group in every context")
    sums = dict.fromkeys(law.global_groups, 0)
    cells = list(zip(law.cell_context.tolist(), law.cell_group.tolist(), law.cell_mass, strict=True))
    for _, group, mass in cells:
        if group in sums:
            sums[group] += mass
    shares: dict[int, dict[int, Fraction]] = {group: {} for group in sums}
    for x, group, mass in cells:
        if group in shares:
            shares[group][x] = Fraction(mass, sums[group])
    return shares


def _termwise(parts: dict[int, dict[int, Fraction]]) -> Extended:
    """Greatest ratio of two groups' terms; terms that are zero in both compare nothing."""
    worst: Extended = Fraction(1)
    for first, second in permutations(parts.values(), 2):
        for x, top in first.items():
            bottom = second.get(x, Fraction(0))
            if top and not bottom:
                return inf
            if top:
                worst = max(worst, top / bottom)
    return worst
