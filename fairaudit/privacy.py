"""Exact privacy of a filter: pure ε, the privacy profile δ(ε), the trade-off curve, per ordered pair of inputs and worst.

Everything is local privacy: any two values of the alphabet are adjacent, and pairs are ordered, P = M(·|a) against Q = M(·|a').
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import gcd, prod

from fairaudit.columns import Label
from fairaudit.mechanism import Factor, Mechanism

__all__ = ["PairLaw", "hockey_stick", "pair_laws", "power"]

Column = tuple[int, int]


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


def pair_laws(mechanism: Mechanism) -> tuple[PairLaw, ...]:
    """List the distinct ordered pairs of rows over all pairs of different inputs.

    A product of three randomized responses has seven, however many inputs it has.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> pair_laws(RandomizedResponse(["a", "b", "c"], keep_probability="0.5"))[0].columns
    ((2, 1), (1, 1), (1, 2))
    """
    classes = [_factor_classes(factor) for factor in mechanism.factors]
    found: dict[tuple[Column, ...], PairLaw] = {}
    for parts in product(*classes):
        examples = [example for _, example in parts]
        if all(i == j for i, j in examples):
            continue
        columns = _joined([columns for columns, _ in parts])
        if columns not in found:
            first = sum((f.inputs[i] for f, (i, _) in zip(mechanism.factors, examples, strict=True)), ())
            second = sum((f.inputs[j] for f, (_, j) in zip(mechanism.factors, examples, strict=True)), ())
            found[columns] = PairLaw(columns, sum(p for p, _ in columns), first, second)
    return tuple(found.values())


def hockey_stick(pair: PairLaw, k: Fraction) -> Fraction:
    """H_k(P, Q) = Σ max(0, P − kQ), exact: the δ of this ordered pair at e^ε = k ≥ 0.

    Examples
    --------
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> hockey_stick(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], Fraction(1))
    Fraction(2, 5)
    """
    top, bottom = k.numerator, k.denominator
    return Fraction(sum(max(0, p * bottom - top * q) for p, q in pair.columns), bottom * pair.denominator)


def power(pair: PairLaw, level: Fraction) -> tuple[Fraction, Fraction]:
    """Neyman–Pearson: the greatest E_P φ over tests φ with E_Q φ ≤ level, and the likelihood ratio k at which the best test is cut.

    The two satisfy power = k·level + H_k(P, Q), and no other k gives less: that k is the certificate of theorem T3.

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
    >>> from fairaudit.mechanism import RandomizedResponse
    >>> power(pair_laws(RandomizedResponse(["a", "b"], keep_probability="0.7"))[0], Fraction(1, 10))
    (Fraction(7, 30), Fraction(7, 3))
    """
    spent, gained = 0, 0
    target = level * pair.denominator
    for p, q in pair.columns:
        if q and spent + q >= target:
            ratio = Fraction(p, q)
            return (gained + ratio * (target - spent)) / pair.denominator, ratio
        spent += q
        gained += p
    return Fraction(1), Fraction(0)


def _factor_classes(factor: Factor) -> list[tuple[tuple[Column, ...], tuple[int, int]]]:
    """Forms of the ordered pairs of rows of a factor, with an example of each: a pair of different inputs if there is one."""
    size = len(factor.inputs)
    mixing = factor.mixing
    if mixing is not None and len(set(mixing[1])) == 1 and size > 1:
        pairs: Iterable[tuple[int, int]] = [(0, 0), (0, 1)]
    else:
        pairs = product(range(size), repeat=2)
    found: dict[tuple[Column, ...], tuple[int, int]] = {}
    for i, j in pairs:
        columns = _merged(zip(factor.rows[i], factor.rows[j], strict=True))
        known = found.setdefault(columns, (i, j))
        if known[0] == known[1] and i != j:
            found[columns] = (i, j)
    return [(columns, example) for columns, example in found.items()]


def _merged(entries: Iterable[Column]) -> tuple[Column, ...]:
    """Join the columns of equal likelihood ratio, in falling order of the ratio, over the least common denominator."""
    sums: dict[Column, list[int]] = {}
    for p, q in entries:
        common = gcd(p, q)
        if common:
            total = sums.setdefault((p // common, q // common), [0, 0])
            total[0] += p
            total[1] += q
    listed = sorted(sums.values(), key=lambda pair: (pair[1] > 0, -Fraction(pair[0], pair[1]) if pair[1] else 0))
    common = gcd(*(v for pair in listed for v in pair))
    return tuple((p // common, q // common) for p, q in listed)


def _joined(parts: list[tuple[Column, ...]]) -> tuple[Column, ...]:
    """Columns of a product of independent pairs."""
    return _merged((prod(p for p, _ in entries), prod(q for _, q in entries)) for entries in product(*parts))
