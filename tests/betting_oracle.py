"""The wealth of a gambler by its definition, in fractions."""

from __future__ import annotations

from fractions import Fraction

F = Fraction

SHARES = {i: F(29, 20) / ((abs(i + 2) + 2) * (abs(i + 2) + 3)) for i in range(-16, 5)}


def by_definition(counts: dict[Fraction, int], p: Fraction) -> Fraction:
    total = F(1, 32)
    for i, share in SHARES.items():
        bet = min(F(2) ** i, F(15, 16) / p)
        part = share
        for x, n in counts.items():
            part *= (1 + bet * (x - p)) ** n
        total += part
    return total


def mirrored(counts: dict[Fraction, int]) -> dict[Fraction, int]:
    return {1 - x: n for x, n in counts.items()}
