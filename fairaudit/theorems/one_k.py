"""One k per ordered pair: the multipliers that prove a bound.

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

from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any, TypeVar

from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import at_least
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.privacy.pairs import PairLaw, hockey_stick, pair_laws, power
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.tables.values import Label
from fairaudit.theorems.assumptions import FRESH
from fairaudit.theorems.bound import NO_FLOOR, Bound, Floor, floor_terms, gap_premise
from fairaudit.theorems.constants import read_range

Gap = Any | Callable[[Label, Label], Any]

T = TypeVar("T")


# One k per ordered pair


def worst_pair(
    pairs: Iterable[T], best: Callable[[T], tuple[Fraction, Fraction]], proves: Callable[[T, Fraction], Fraction]
) -> tuple[Fraction, tuple[Fraction, ...]]:
    """Greatest of the pairs' best values, and multipliers that prove it for all of them; pairs that an earlier k proves add none.

    Source: the one-k certificate; Coq `certificate_one_k`.
    """
    found = sorted(((*best(pair), pair) for pair in pairs), key=lambda entry: -entry[0])
    value = found[0][0] if found else Fraction(1)
    kept: list[Fraction] = []
    for _, k, pair in found:
        if k not in kept and not any(proves(pair, other) <= value for other in kept):
            kept.append(k)
    return value, tuple(sorted(kept, reverse=True))


def power_ratio(pair: PairLaw, level: Fraction) -> tuple[Fraction, Fraction]:
    """The greatest power at a level, divided by it, and the k that proves it.

    Source: the one-k certificate; Coq `certificate_exact`.
    """
    gained, k = power(pair, level)
    return gained / level, k


def _classes(mechanism: Mechanism, gap: Gap) -> list[tuple[PairLaw, Fraction]]:
    """Distinct ordered pairs of rows, each with the greatest K of the input pairs that have this form."""
    if not callable(gap):
        number = at_least("K", gap, 0)
        return [(pair, number) for pair in worst_pair_laws(mechanism)]
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


def additive_bound(
    theorem: str,
    mechanism: Mechanism,
    gamma: Any,
    tau: Any,
    gap: Gap,
    floor: Floor,
    weight: Callable[[Fraction, Fraction], Fraction],
) -> Bound:
    """R ≤ k + (K + w·H_k)/τ, with w = γ (T1) or γ − K (T3), capped at γ/τ.

    Source: T1 and T3; Coq `T1_one_k`, `T3_K_one_k`.
    """
    top, low = read_range(gamma, tau)
    classes = [(pair, min(number, top)) for pair, number in _classes(mechanism, gap)]
    largest = max((number for _, number in classes), default=Fraction(0))
    constants = {"gamma": top, "tau": low, "K": largest}
    scope, extra = floor_terms(floor, f"{low}", any_filter=False, trivial=low == 0)
    assumptions = (FRESH, gap_premise(largest), *extra)
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

    value, multipliers = worst_pair(classes, best, proves)
    return Bound(theorem, "local_ratio", value, constants, multipliers, assumptions, scope)


def _pure(pair: PairLaw) -> Extended:
    p, q = pair.columns[0]
    return Fraction(p, q) if q else inf
