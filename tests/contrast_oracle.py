"""What bets on contrasts won, by definition, in fractions: pair by pair, and over every way to pair the draws of two cells."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import permutations, product
from math import prod

F = Fraction


def bets(spread: Fraction) -> list[Fraction]:
    """The greatest bets 15/16·2^-i and 2/3·2^-i, in falling order, until λ²·spread is 24 or less."""
    ordered = sorted((base / 2**i for base in (F(15, 16), F(2, 3)) for i in range(60)), reverse=True)
    last = next(i for i, bet in enumerate(ordered) if bet**2 * spread <= 24)
    return ordered[: last + 1]


def gain(x: Fraction, y: Fraction, limit: Fraction, claim: str) -> Fraction:
    return limit * y - x if claim == "ratio" else (limit - x + y) / 2


def paired(counts: Mapping[tuple[Fraction, Fraction], int], limit: Fraction, claim: str) -> Fraction:
    made = bets(F(2 * sum(counts.values())))
    won = [prod((1 + bet * gain(x, y, limit, claim)) ** n for (x, y), n in counts.items()) for bet in made]
    return sum(won, F(0)) / F(len(made))


def symmetric(xs: Sequence[Fraction], ys: Sequence[Fraction], limit: Fraction, claim: str) -> Fraction:
    """The average over all lists of m different draws of x, and all of y, which meet in their order."""
    m = min(len(xs), len(ys))
    if m == 0:
        return F(1)
    made = bets(m**2 * (F(1, len(xs)) + F(1, len(ys))))
    won = [
        prod(1 + bet * gain(x, y, limit, claim) for x, y in zip(some, others, strict=True))
        for bet in made
        for some, others in product(permutations(xs, m), permutations(ys, m))
    ]
    return sum(won, F(0)) / F(len(won))


def value(number: tuple[int, int]) -> Fraction:
    return F(number[0]) * F(2) ** number[1]


def is_just_below(number: tuple[int, int], exact: Fraction, bits: int = 100) -> bool:
    return exact * (1 - F(1, 2**bits)) <= value(number) <= exact


def outcomes(law: Mapping[object, Fraction], draws: int) -> Iterable[tuple[tuple[object, ...], Fraction]]:
    """Every list of so many independent draws, with its probability."""
    for found in product(law.items(), repeat=draws):
        yield tuple(value for value, _ in found), prod((chance for _, chance in found), start=F(1))


def tally(values: Iterable[object]) -> dict[object, int]:
    found: dict[object, int] = {}
    for each in values:
        found[each] = found.get(each, 0) + 1
    return found
