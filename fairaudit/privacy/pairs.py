"""Ordered pairs of rows of a filter, reduced to their likelihood ratios; a product is never multiplied out."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.model.releases import check_releases
from fairaudit.privacy.columns import Budget, Column, joined_columns, merged_columns, powered_columns
from fairaudit.tables.values import Label

Pair = tuple[Label, Label]

Positions = tuple[int, ...]

MAX_KINDS = 1_000_000
"""Kinds are held in memory, each with its columns."""

MAX_RELEASE_WORK = 2_000_000_000
"""Products of columns, times the bits of their numbers, that are formed for several releases: some ten seconds."""


@dataclass(frozen=True)
class PairLaw:
    """An ordered pair of rows of a filter, reduced to its likelihood ratios.

    Outputs with the same ratio p/q are one column: that keeps every hockey-stick, trade-off and Rényi quantity of the pair.

    Attributes
    ----------
    columns : tuple of (int, int)
        ``(p, q)`` over `denominator`, strictly falling in p/q, with q = 0 first.
    denominator : int
        Common denominator; the p and the q each sum to it.
    first, second : tuple of str
        The first ordered pair of different inputs found with this form.
    """

    columns: tuple[Column, ...]
    denominator: int
    first: Label
    second: Label


def pair_laws(mechanism: Mechanism, releases: int = 1) -> tuple[PairLaw, ...]:
    """List the distinct ordered pairs of rows over all pairs of different inputs.

    A product of three randomized responses has seven, however many inputs it has.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    releases : int
        How often it releases the same value, each time with fresh randomness: the rows are then those of all releases together.

    Raises
    ------
    InputError
        If the releases have too many different likelihood ratios to be counted exactly.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b", "c"], keep_probability="0.5")
    >>> pair_laws(coin)[0].columns
    ((2, 1), (1, 1), (1, 2))
    >>> pair_laws(coin, releases=2)[0].columns
    ((4, 1), (4, 2), (5, 5), (2, 4), (1, 4))
    """
    return tuple(
        PairLaw(columns, sum(p for p, _ in columns), _input(mechanism, first), _input(mechanism, second))
        for columns, (first, second) in kinds_of_pairs(mechanism, releases).examples.items()
        if first != second
    )


def joint_ratios(mechanism: Mechanism, releases: int = 1) -> int:
    """Bound the likelihood ratios of the different pairs of rows, which claims about any policy go through; long numbers count more.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    releases : int
        How often it releases the same value.

    Raises
    ------
    InputError
        If the releases have too many different likelihood ratios to be counted exactly.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> joint_ratios(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"))
    4
    """
    count, bits = 1, 0
    for factor in mechanism.factors:
        count *= 1 + sum(len(pair.columns) for pair in pair_laws(Mechanism((factor,)), releases))
        bits += releases * factor.denominator.bit_length()
    return count * (1 + (bits >> 8)) ** 2


def hockey_stick(pair: PairLaw, k: Fraction) -> Fraction:
    """H_k(P, Q) = Σ max(0, P − kQ), exact: the δ of this ordered pair at e^ε = k ≥ 0.

    Source: docs/theory.md; Coq `dp_hockey_stick`, `dp_functions`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> hockey_stick(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], Fraction(1))
    Fraction(2, 5)
    """
    above = pair.columns[: likelier(pair, k.numerator, k.denominator)]
    gained, spent = sum(p for p, _ in above), sum(q for _, q in above)
    return Fraction(gained * k.denominator - k.numerator * spent, k.denominator * pair.denominator)


def likelier(pair: PairLaw, top: int, bottom: int) -> int:
    """How many columns have a likelihood ratio above top/bottom: they are the first.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> likelier(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], 2, 1)
    1
    """
    return bisect_left(pair.columns, True, key=lambda column: column[0] * bottom <= top * column[1])


def power(pair: PairLaw, level: Fraction) -> tuple[Fraction, Fraction]:
    """Neyman–Pearson: the greatest E_P φ over tests φ with E_Q φ ≤ level, and the likelihood ratio k at which the best test is cut.

    The two satisfy power = k·level + H_k(P, Q), and no other k gives less: that k is the certificate of theorem T3.

    Source: T3; Coq `certificate_exact`.

    Parameters
    ----------
    pair : PairLaw
        The ordered pair.
    level : Fraction
        In (0, 1].

    Returns
    -------
    tuple of Fraction
        1 − f(level), where f is the trade-off function of the ordered pair, and k.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> power(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], Fraction(1, 10))
    (Fraction(7, 30), Fraction(7, 3))
    """
    spent, gained = 0, 0
    target = level * pair.denominator
    for p, q in pair.columns:
        if q and (spent + q) * target.denominator >= target.numerator:
            ratio = Fraction(p, q)
            return (gained + ratio * (target - spent)) / pair.denominator, ratio
        spent += q
        gained += p
    return Fraction(1), Fraction(0)


def pair_law(mechanism: Mechanism, first: Any, second: Any, releases: int = 1, budget: Budget | None = None) -> PairLaw:
    """Reduce one ordered pair of inputs to its likelihood ratios, over one release or several together, within a budget.

    Raises
    ------
    InputError
        If the filter does not know one of them, and as `pair_laws`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Constant
    >>> pair_law(Constant(["a", "b"]), "a", "b").columns
    ((1, 1),)
    """
    places = zip(mechanism.factors, mechanism.locate(first), mechanism.locate(second), strict=True)
    columns: tuple[Column, ...] = ((1, 1),)
    budget = budget or release_budget(releases)
    for factor, i, j in places:
        more = powered_columns(merged_columns(zip(factor.rows[i], factor.rows[j], strict=True)), releases, budget)
        columns = joined_columns(columns, more, budget)
    ends = [_input(mechanism, mechanism.locate(value)) for value in (first, second)]
    return PairLaw(columns, sum(p for p, _ in columns), ends[0], ends[1])


def release_budget(releases: int) -> Budget | None:
    """What may be spent on the columns of several releases; None of one."""
    return None if check_releases(releases) == 1 else Budget(MAX_RELEASE_WORK)


@dataclass(frozen=True)
class PairKinds:
    """The kinds of ordered pairs of inputs, pairs of equal inputs included.

    Attributes
    ----------
    examples : dict
        Columns of the kind to the positions of an ordered pair; different inputs if there are such. The order numbers the kinds.
    steps : list
        For each factor: the kind of each pair of its inputs (None: kind 0 for equal inputs and the last kind for others), and the kind that
        the pair of the factors before it becomes with that.
    """

    examples: dict[tuple[Column, ...], tuple[Positions, Positions]]
    steps: list[tuple[NDArray[np.int64] | None, NDArray[np.int64]]]


def kinds_of_pairs(mechanism: Mechanism, releases: int = 1) -> PairKinds:
    """The kinds of ordered pairs of inputs over one release or several, factor by factor; the product is never multiplied out."""
    budget = release_budget(releases)
    found: dict[tuple[Column, ...], tuple[Positions, Positions]] = {((1, 1),): ((), ())}
    steps = []
    for factor in mechanism.factors:
        once, of_pair = factor_kinds(factor)
        classes = {powered_columns(columns, releases, budget): pair for columns, pair in once.items()}
        if len(found) * len(classes) > MAX_KINDS:
            raise InputError(f"the filter has more than {MAX_KINDS} kinds of ordered pairs; use fewer or simpler factors")
        numbers: dict[tuple[Column, ...], int] = {}
        joint: dict[tuple[Column, ...], tuple[Positions, Positions]] = {}
        steps.append((of_pair, np.zeros((len(found), len(classes)), dtype=np.int64)))
        for old, (columns, (first, second)) in enumerate(found.items()):
            for new, (more, (i, j)) in enumerate(classes.items()):
                both = joined_columns(columns, more, budget)
                pair = ((*first, i), (*second, j))
                known = joint.setdefault(both, pair)
                if known[0] == known[1] and pair[0] != pair[1]:
                    joint[both] = pair
                steps[-1][1][old, new] = numbers.setdefault(both, len(numbers))
        found = joint
    return PairKinds(found, steps)


def kinds_of_row(mechanism: Mechanism, kinds: PairKinds, row: int) -> list[int]:
    """Kinds of the pairs of one input with every input."""
    sizes = [len(f.inputs) for f in mechanism.factors]
    result = np.zeros(1, dtype=np.int64)
    for size, place, (of_pair, step) in zip(sizes, np.unravel_index(row, sizes), kinds.steps, strict=True):
        if of_pair is None:
            these = np.full(size, step.shape[1] - 1)
            these[place] = 0
        else:
            these = of_pair[place]
        result = step[result[:, None], these[None, :]].ravel()
    listed: list[int] = result.tolist()
    return listed


def factor_kinds(factor: Factor) -> tuple[dict[tuple[Column, ...], tuple[int, int]], NDArray[np.int64] | None]:
    """Kinds of the ordered pairs of rows of a factor with an example of each, and the kind of each pair."""
    size = len(factor.inputs)
    alike = pairs_alike(factor)
    pairs = [(0, 0), (0, 1)] if alike else [(i, j) for i in range(size) for j in range(size)]
    found: dict[tuple[Column, ...], tuple[int, int]] = {}
    numbers: dict[tuple[Column, ...], int] = {}
    listed = []
    for i, j in pairs:
        columns = merged_columns(zip(factor.rows[i], factor.rows[j], strict=True))
        known = found.setdefault(columns, (i, j))
        if known[0] == known[1] and i != j:
            found[columns] = (i, j)
        listed.append(numbers.setdefault(columns, len(numbers)))
    return found, None if alike else np.array(listed, dtype=np.int64).reshape(size, size)


def pairs_alike(factor: Factor) -> bool:
    """Whether all ordered pairs of different rows have the same form, as in randomized response."""
    return len(factor.inputs) > 1 and factor.mixing is not None and len(set(factor.mixing[1])) == 1


def _input(mechanism: Mechanism, places: Sequence[int]) -> Label:
    return sum((f.inputs[i] for f, i in zip(mechanism.factors, places, strict=True)), ())


def flat_position(mechanism: Mechanism, places: Sequence[int]) -> int:
    """Position among all inputs."""
    at = 0
    for factor, i in zip(mechanism.factors, places, strict=True):
        at = at * len(factor.inputs) + i
    return at


def any_pair(mechanism: Mechanism) -> Pair | None:
    """Two different inputs; None if there is one only."""
    at = next((n for n, f in enumerate(mechanism.factors) if len(f.inputs) > 1), None)
    if at is None:
        return None
    first = [0] * len(mechanism.factors)
    second = [int(n == at) for n in range(len(first))]
    return _input(mechanism, first), _input(mechanism, second)
