"""T13 for an unknown utility in a declared range: a known filter, every policy behind it, every g in [m, γ].

Let K be the most by which the utilities of two groups differ for the same decision and context, at most γ − m. Then V bounds the
ratio of an ordered pair of rows P, Q, for every policy and every such utility, exactly if

    K + (γ − K − m)·H_V(P, Q) ≤ m·(V − 1).

For K = 0 that is T4, for m = 0 = K it is T2, and for m = 0 < K nothing finite holds. Where every policy keeps a floor τ under what
the second group gets, k + max(0, K + (γ − K − m)·H_k − (k − 1)·m)/τ bounds the ratio for every k ≥ 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf, lcm
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import ZERO, Extended
from fairaudit.exact.rationals import at_least
from fairaudit.measures.limits import Quantity
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.columns import joined_columns, merged_columns
from fairaudit.privacy.pairs import PairLaw, hockey_stick, kinds_of_pairs, kinds_of_row, likelier, power
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.theorems.assumptions import DECLARED_FLOOR, DECLARED_RANGE, FRESH, POPULATION
from fairaudit.theorems.bound import ANY_UTILITY, ANY_UTILITY_FLOORED, Bound
from fairaudit.theorems.constants import read_range
from fairaudit.theorems.one_k import worst_pair


@dataclass(frozen=True)
class UtilityRange:
    """What is declared of a utility, and of what every policy pays.

    Attributes
    ----------
    gamma, m : Fraction
        Greatest and least utility.
    gap : Fraction
        K, at most γ − m.
    tau : Fraction
        A floor under the expected utility of the second group of each pair; 0 for none.
    """

    gamma: Fraction
    m: Fraction
    gap: Fraction = ZERO
    tau: Fraction = ZERO

    @property
    def span(self) -> Fraction:
        """γ − K − m, what the decision can change for both groups alike."""
        return self.gamma - self.gap - self.m


Ranged = tuple[PairLaw, UtilityRange]
"""An ordered pair of rows with the range of the utility by which it is compared."""


def read_utility_range(gamma: Any, m: Any = 0, gap: Any = 0, tau: Any = 0) -> UtilityRange:
    """Read the constants; a gap above γ − m is γ − m.

    Raises
    ------
    InputError
        If one is no number of at least 0, γ is 0, or m or τ is above γ.

    Examples
    --------
    >>> read_utility_range(3, 1, 5)
    UtilityRange(gamma=Fraction(3, 1), m=Fraction(1, 1), gap=Fraction(2, 1), tau=Fraction(0, 1))
    """
    top, floor = read_range(gamma, tau)
    least, difference = at_least("m", m, 0), at_least("K", gap, 0)
    if least > top:
        raise InputError(f"m is {shown(m)}, above gamma, which is {shown(gamma)}; the least utility is at most the greatest")
    return UtilityRange(top, least, min(difference, top - least), floor)


def range_value(pairs: Iterable[PairLaw], gamma: Any, m: Any = 0, gap: Any = 0) -> Extended:
    """The least V that bounds the ratio of every one of the pairs, for every policy and every utility of the range.

    Source: T13.

    Parameters
    ----------
    pairs : iterable of PairLaw
        Ordered pairs of rows of the filter.
    gamma, m, gap : number or str
        Greatest and least utility, and K.

    Returns
    -------
    Fraction or float
        V ≥ 1, exact; `math.inf` where no finite V holds.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = worst_pair_laws(RandomizedResponse(["a", "b"], keep_probability="2/3"))
    >>> range_value(coin, 3, 1), range_value(coin, 1), range_value(coin, 3, 1, "1/2"), range_value(coin, 1, 0, "1/2")
    (Fraction(7, 5), Fraction(2, 1), Fraction(5, 3), inf)
    """
    declared = read_utility_range(gamma, m, gap)
    return max((least_ratio(pair, declared) for pair in pairs), default=Fraction(1))


def least_ratio(pair: PairLaw, declared: UtilityRange) -> Extended:
    """The least V of one ordered pair without a floor, the greatest (K + m + span·P(S))/(m + span·Q(S)) over sets S of outputs.

    H_V is the greatest P(S) − V·Q(S), and only sets of the greatest likelihood ratios matter.

    Source: T13.
    """
    scale = lcm(declared.gamma.denominator, declared.m.denominator, declared.gap.denominator)
    span, rest = int(declared.span * scale), pair.denominator
    least, gap = int(declared.m * scale) * rest, int(declared.gap * scale) * rest
    if least == 0:
        p, q = pair.columns[0]
        return Fraction(p, q) if q and not gap else inf
    best, under, taken = gap + least, least, -1
    # The outputs likelier than V have a greater ratio than V unless V is the greatest.
    while (count := likelier(pair, best, under)) != taken:
        chosen, taken = pair.columns[:count], count
        best, under = gap + least + span * sum(p for p, _ in chosen), least + span * sum(q for _, q in chosen)
    return Fraction(best, under)


def proved_ratio(pair: PairLaw, declared: UtilityRange, k: Fraction) -> Fraction:
    """What k ≥ 0 proves where the floor τ is kept: k + max(0, K + span·H_k − (k − 1)·m)/τ; k = 0 proves γ/τ.

    Source: T13.
    """
    excess = declared.gap + declared.span * hockey_stick(pair, k) - (k - 1) * declared.m
    return k + max(ZERO, excess) / declared.tau


def least_ratio_above(pair: PairLaw, declared: UtilityRange) -> tuple[Fraction, Fraction]:
    """The least that one k proves where the floor is kept, and that k.

    The right side is convex in k. Without the maximum it falls until span·Q(outputs of ratio above k) reaches τ − m, as in the test of
    Neyman and Pearson, and the maximum is 0 from the ratio that holds without a floor.

    Source: T13.
    """
    bare = least_ratio(pair, declared)
    if declared.tau <= declared.m:
        k = bare
    else:
        missing = declared.tau - declared.m
        k = min(bare, power(pair, missing / declared.span)[1]) if missing <= declared.span else ZERO
    multiplier = k if isinstance(k, Fraction) else ZERO
    return proved_ratio(pair, declared, multiplier), multiplier


def t13_range(
    ranged: Iterable[Ranged], *, quantity: Quantity = "local", floored: bool = False, assumptions: Sequence[str] | None = None
) -> Bound:
    """T13 for every policy and every utility of a declared range, from pairs of rows with the ranges by which they are compared.

    Source: T13; Coq `T13_range`, `T13_range_floor`, `T13_range_cap`, `T13_range_sharp`.

    Parameters
    ----------
    ranged : iterable of (PairLaw, UtilityRange)
        As `in_each_range` lists them for the local ratio, and `in_population` for the global one.
    quantity : {"local", "global"}
        What is bounded.
    floored : bool
        Whether the policies keep the floors, which then are above 0.
    assumptions : sequence of str, optional
        What the reader must accept; by default what one range says, of the contexts alike.

    Returns
    -------
    Bound
        On the ratio; its multipliers are for the floors.

    Raises
    ------
    InputError
        If a floor is 0 and `floored` was asked for.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.7")
    >>> t13_range(in_each_range(coin, [read_utility_range(1, "0.1", 0, "1/2")])).value
    Fraction(73, 37)
    >>> t13_range(in_each_range(coin, [read_utility_range(1, 0, 0, "1/2")]), floored=True).value
    Fraction(11, 7)
    """
    listed = list(ranged)
    ranges = list(dict.fromkeys(declared for _, declared in listed))
    if floored and any(declared.tau == 0 for declared in ranges):
        raise InputError("a floor is 0; a bound for policies that keep a floor needs one above 0 in every context")
    multipliers: tuple[Fraction, ...] = ()
    value: Extended
    if floored:
        value, multipliers = worst_pair(listed, lambda one: least_ratio_above(*one), lambda one, k: proved_ratio(*one, k))
    else:
        value = max((least_ratio(*one) for one in listed), default=Fraction(1))
    if assumptions is None:
        assumptions = tuple(dict.fromkeys(text for declared in ranges for text in range_sentences(declared, floored=floored)))
        assumptions = (FRESH, *assumptions, *((POPULATION,) if quantity == "global" else ()))
    note = "" if isinstance(value, Fraction) else "one group may get nothing where another gets something"
    name = "local_ratio" if quantity == "local" else "global_ratio"
    constants = _constants(ranges[0], floored=floored) if len(ranges) == 1 else {}
    return Bound("T13", name, value, constants, multipliers, tuple(assumptions), ANY_UTILITY_FLOORED if floored else ANY_UTILITY, note=note)


def range_sentences(declared: UtilityRange, *, floored: bool) -> tuple[str, ...]:
    """What the reader must judge of a range, and of its floor."""
    said = DECLARED_RANGE.format(m=declared.m, gamma=declared.gamma, lipschitz=declared.gap)
    return (said, *((DECLARED_FLOOR.format(tau=declared.tau),) if floored else ()))


def in_each_range(mechanism: Mechanism, ranges: Iterable[UtilityRange], releases: int = 1) -> Iterator[Ranged]:
    """The pairs of rows of a filter among which every worst one is, with each of the different ranges, one for each kind of context."""
    different = list(dict.fromkeys(ranges))
    return ((pair, declared) for pair in worst_pair_laws(mechanism, releases=releases) for declared in different)


def in_population(mechanism: Mechanism, mass: Sequence[int], ranges: Sequence[UtilityRange], releases: int = 1) -> Iterator[Ranged]:
    """The pairs of rows P(x|a)·M_A(ã|a) of groups with mass; each second group has its own range, with the floor of its mean.

    A context filter gives nothing here, since the utility may depend on the context.

    Parameters
    ----------
    mechanism : Mechanism
        The group filter.
    mass : sequence of int
        P(x,a) up to a factor, contexts first, or the groups in each context.
    ranges : sequence of UtilityRange
        One for each true group.
    releases : int
        How many releases of the group one memory sees.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="2/3")
    >>> max(least_ratio(*one) for one in in_population(coin, [3, 1, 1, 3], [read_utility_range(1)] * 2))
    Fraction(6, 1)
    """
    count = len(ranges)
    rows = [tuple(mass[a::count]) for a in range(count)]
    present = [a for a in range(count) if any(rows[a])]
    kinds = kinds_of_pairs(mechanism, releases)
    columns = list(kinds.examples)
    labels = mechanism.inputs
    shares = list(dict.fromkeys(rows[a] for a in present))
    place = {row: i for i, row in enumerate(shares)}
    mixed = {
        (i, j): merged_columns((p * sum(second), q * sum(first)) for p, q in zip(first, second, strict=True))
        for i, first in enumerate(shares)
        for j, second in enumerate(shares)
    }
    seen: set[tuple[int, int, int, UtilityRange]] = set()
    for a in present:
        of_row = kinds_of_row(mechanism, kinds, a)
        for b in present:
            key = (of_row[b], place[rows[a]], place[rows[b]], ranges[b])
            if a != b and key not in seen:
                seen.add(key)
                joint = joined_columns(columns[of_row[b]], mixed[key[1], key[2]])
                yield PairLaw(joint, sum(p for p, _ in joint), labels[a], labels[b]), ranges[b]


def _constants(declared: UtilityRange, *, floored: bool) -> dict[str, Fraction]:
    constants = {"gamma": declared.gamma, "g_min": declared.m, "K": declared.gap}
    return constants | {"tau": declared.tau} if floored else constants
