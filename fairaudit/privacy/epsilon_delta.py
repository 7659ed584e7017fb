"""Pure ε and (ε, δ) of a filter, exactly, worst over all ordered pairs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal
from fractions import Fraction

from fairaudit.arguments import answered
from fairaudit.exact.enclosures import exp_below, log_enclosure
from fairaudit.exact.rationals import Number, at_least, fraction
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.privacy.columns import Column
from fairaudit.privacy.currencies import ApproxDP, AttributeDP, Enclosure, PureDP
from fairaudit.privacy.multiplied_out import hockey_sticks_of_rows, whole_table, worth_multiplying_out
from fairaudit.privacy.pairs import any_pair, hockey_stick
from fairaudit.privacy.trade_offs import worst_pair_laws
from fairaudit.tables.values import Label

EXP_BITS = 64
"""e^ε is rounded to these binary digits, a few units of which stay below the 2^-60 that `delta_at` promises."""


@answered
def pure_dp(mechanism: Mechanism) -> PureDP:
    """Pure differential privacy, exact: of the whole tuple, and when one attribute changes.

    The greatest ratio of an output's probabilities is that of the column's greatest entry to its least; over the factors of a product the
    ratios multiply, that is, ε add up.

    Source: docs/theory.md; Coq `pure_dp_dp`.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.

    Returns
    -------
    PureDP
        e^ε exactly, with a pair of inputs that attains it.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Product, RandomizedResponse
    >>> coin = RandomizedResponse(["f", "m"], keep_probability="0.7")
    >>> found = pure_dp(Product({"sex": coin, "age": coin}))
    >>> found.exp_epsilon, found.pair, [a.exp_epsilon for a in found.attributes]
    (Fraction(49, 9), (('f', 'f'), ('m', 'm')), [Fraction(7, 3), Fraction(7, 3)])
    """
    attributes: list[AttributeDP] = []
    top, bottom = 1, 1
    first: list[str] = []
    second: list[str] = []
    for factor in mechanism.factors:
        ratio, i, j = _extreme(factor.rows, range(len(factor.inputs)))
        top, bottom = (top * ratio[0], bottom * ratio[1]) if bottom and ratio[1] else (1, 0)
        first += factor.inputs[i]
        second += factor.inputs[j]
        for part in range(factor.width):
            number = len(attributes)
            column = mechanism.columns[number] if number < len(mechanism.columns) else str(number + 1)
            attributes.append(_attribute(factor, part, column))
    pair = (tuple(first), tuple(second))
    return PureDP(
        fraction((top, bottom)),
        epsilon_enclosure((top, bottom)),
        pair if pair[0] != pair[1] else any_pair(mechanism),
        tuple(attributes),
    )


def exp_epsilon(mechanism: Mechanism) -> Fraction | float:
    """e^ε of pure differential privacy of the whole tuple, exact; inf if the supports of two rows differ.

    Source: docs/theory.md; Coq `pure_dp_products`.

    Examples
    --------
    >>> from fairaudit.model.mechanism import Identity, RandomizedResponse
    >>> exp_epsilon(RandomizedResponse(["a", "b"], keep_probability="0.7")), exp_epsilon(Identity(["a", "b"]))
    (Fraction(7, 3), inf)
    """
    return pure_dp(mechanism).exp_epsilon


def approx_dp(mechanism: Mechanism, exp_epsilon: Number) -> ApproxDP:
    """The least δ of (ε, δ)-differential privacy at a rational e^ε, with an ordered pair that attains it.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : number or str
        e^ε ≥ 1, such as ``"7/3"``.

    Raises
    ------
    InputError
        If e^ε is not a number of at least 1, or the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> approx_dp(RandomizedResponse(["a", "b"], keep_probability="0.7"), 1)
    ApproxDP(exp_epsilon=Fraction(1, 1), delta=Fraction(2, 5), pair=(('a',), ('b',)))
    """
    k = at_least("exp_epsilon", exp_epsilon, 1)
    if worth_multiplying_out(mechanism):
        rows, bottoms = whole_table(mechanism)
        top, bottom, at = 0, 1, None
        for i, (tops, scale) in enumerate(zip(hockey_sticks_of_rows(rows, bottoms, k), bottoms, strict=True)):
            for j, (value, other) in enumerate(zip(tops, bottoms, strict=True)):
                if i != j and (at is None or value * bottom > top * scale * other):
                    top, bottom, at = value, scale * other, (i, j)
        pair = (mechanism.inputs[at[0]], mechanism.inputs[at[1]]) if at else None
        return ApproxDP(k, Fraction(top, bottom * k.denominator), pair)
    worst = max(worst_pair_laws(mechanism), key=lambda law: hockey_stick(law, k), default=None)
    if worst is None:
        return ApproxDP(k, Fraction(0), None)
    return ApproxDP(k, hockey_stick(worst, k), (worst.first, worst.second))


@answered
def delta(mechanism: Mechanism, exp_epsilon: Number) -> Fraction:
    """The least δ at a rational e^ε ≥ 1, exact: the greatest Σ max(0, P − e^ε·Q) over all ordered pairs.

    Source: docs/theory.md; Coq `dp_hockey_stick`.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : number or str
        e^ε.

    Returns
    -------
    Fraction
        The least δ.

    Raises
    ------
    InputError
        If e^ε is below 1, or not a finite number.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> coin = RandomizedResponse(["a", "b"], keep_probability="0.7")
    >>> delta(coin, 1), delta(coin, 2), delta(coin, "7/3")
    (Fraction(2, 5), Fraction(1, 10), Fraction(0, 1))
    """
    return approx_dp(mechanism, exp_epsilon).delta


def delta_at(mechanism: Mechanism, epsilon: Number) -> Fraction:
    """Return a δ for which the filter is (ε, δ)-differentially private; above the least one by less than 2^-60.

    e^ε is irrational unless ε = 0; it is rounded down, and δ(·) does not increase and falls by at most the step in e^ε.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    epsilon : number or str
        ε from 0 to 10,000, in nats.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> float(delta_at(RandomizedResponse(["a", "b"], keep_probability="0.7"), "0.5"))
    0.20538361878996156
    """
    return delta(mechanism, exp_epsilon_below(epsilon))


def _extreme(rows: Sequence[Sequence[int]], among: Iterable[int]) -> tuple[Column, int, int]:
    """The greatest ratio of two entries of one column, ``(1, 0)`` if it is infinite, and the rows of the two."""
    chosen = list(among)
    best, at = (1, 1), (chosen[0], chosen[0])
    for column in zip(*(rows[i] for i in chosen), strict=True):
        high, low = max(column), min(column)
        if high * best[1] > best[0] * low:
            best, at = (high, low), (chosen[column.index(high)], chosen[column.index(low)])
            if not low:
                return (1, 0), *at
    return best, *at


def _attribute(factor: Factor, part: int, column: str) -> AttributeDP:
    """The greatest ratio over the inputs that differ in one part only."""
    groups: dict[Label, list[int]] = {}
    for i, label in enumerate(factor.inputs):
        groups.setdefault(label[:part] + label[part + 1 :], []).append(i)
    best: tuple[Column, int, int] | None = None
    for among in groups.values():
        if len(among) > 1:
            found = _extreme(factor.rows, among)
            if found[1] == found[2]:
                found = (found[0], among[0], among[1])
            if best is None or found[0][0] * best[0][1] > best[0][0] * found[0][1]:
                best = found
    if best is None:
        return AttributeDP(column, Fraction(1), epsilon_enclosure((1, 1)), None)
    ratio, i, j = best
    return AttributeDP(column, fraction(ratio), epsilon_enclosure(ratio), (factor.inputs[i], factor.inputs[j]))


def epsilon_enclosure(ratio: Column) -> Enclosure:
    """Enclose the logarithm of e^ε, given as a pair, in two decimals."""
    low, high = log_enclosure(ratio)
    return Decimal(low), Decimal(high)


def exp_epsilon_below(epsilon: Number) -> Fraction:
    """e^ε rounded down, by less than 2^-60."""
    return exp_below(at_least("epsilon", epsilon, 0), EXP_BITS)
