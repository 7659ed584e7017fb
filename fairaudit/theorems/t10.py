"""T10: two persons in one decision, in uniformly random order."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import gcd
from typing import Any

from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.pairs import PairLaw, hockey_stick
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.theorems.assumptions import FRESH
from fairaudit.theorems.bound import ANY_POLICY, Bound, Floor, as_multipliers, finite_constants, floor_terms, privacy_premise
from fairaudit.theorems.constants import read_chance, read_factor
from fairaudit.theorems.one_k import power_ratio, worst_pair
from fairaudit.theorems.t03 import approx_dp_ratio

RANDOM_ORDER = (
    "the order of the candidates is drawn uniformly from all orders, independently of everything else, unseen by the policy and fresh for "
    "each decision; the same filter serves every candidate, and nothing else travels with a candidate"
)


def t10(profile_exp_epsilon: Any, tau: Any = None, *, floor: Floor = "table") -> Bound:
    """T10: in uniformly random order the chances of two persons differ by a factor of at most e^(2ε), ε of one profile's filter.

    Both profiles are filtered and exchanging two persons changes both: hence 2ε. With a floor under every chance, T3 at 2ε.

    Source: T10; Coq `T10_persons`, `T10_floor_pure`, `T10_two_candidates`.

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
    factor = read_factor(profile_exp_epsilon)
    doubled = factor * factor
    constants = finite_constants(profile_exp_epsilon=factor, exp_epsilon=doubled)
    premise = privacy_premise(factor, Fraction(0), "each candidate's profile filter")
    if tau is None:
        note = "" if isinstance(factor, Fraction) else "the profile filter is not purely private; give a floor"
        return Bound(
            "T10", "selection_ratio", doubled, constants, as_multipliers(doubled), (FRESH, RANDOM_ORDER, premise), ANY_POLICY, note=note
        )
    chance = read_chance(tau)
    value, k = approx_dp_ratio(doubled, Fraction(0), chance)
    scope, extra = floor_terms(floor, f"{chance}", any_filter=True, chance=True)
    return Bound("T10", "selection_ratio", value, {**constants, "tau": chance}, (k,), (FRESH, RANDOM_ORDER, premise, *extra), scope)


def t10_floor(mechanism: Mechanism, tau: Any, *, floor: Floor = "table") -> Bound:
    """T10 with a floor under the chances and a known profile filter: the power at level τ of the exchange of two profiles, divided by τ.

    Source: T10; Coq `T10_floor`, `T10_two_candidates_floor`.

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
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> t10_floor(RandomizedResponse(["a", "b", "c"], exp_epsilon=2), "0.4").value
    Fraction(57, 32)
    """
    chance = read_chance(tau)
    value, multipliers = worst_pair(
        exchange_laws(mechanism), lambda pair: power_ratio(pair, chance), lambda pair, k: k + hockey_stick(pair, k) / chance
    )
    scope, extra = floor_terms(floor, f"{chance}", any_filter=False, chance=True)
    return Bound("T10", "selection_ratio", value, {"tau": chance}, multipliers, (FRESH, RANDOM_ORDER, *extra), scope)


def exchange_laws(mechanism: Mechanism) -> tuple[PairLaw, ...]:
    """List the distinct pairs M(a)⊗M(b) against M(b)⊗M(a): what a policy sees before and after two candidates are exchanged.

    Source: T10; Coq `T10_two_candidates_floor`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> exchange_laws(RandomizedResponse(["a", "b"], exp_epsilon=2))[0].columns
    ((4, 1), (4, 4), (1, 4))
    """
    found: dict[tuple[tuple[int, int], ...], PairLaw] = {}
    for pair in worst_pair_laws(mechanism):
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
