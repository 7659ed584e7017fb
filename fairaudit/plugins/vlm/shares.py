"""Probabilities of answers: from scores, and drawn from exactly."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import exp

GRAIN = 1 << 53


def softmax(scores: list[float]) -> tuple[Fraction, ...]:
    """Shares of e^score as multiples of 2^-53 that add up to 1.

    Examples
    --------
    >>> softmax([0.0, 0.0])
    (Fraction(1, 2), Fraction(1, 2))
    """
    top = max(scores)
    parts = [exp(score - top) for score in scores]
    shares = [int(part / sum(parts) * GRAIN) for part in parts]
    shares[parts.index(max(parts))] += GRAIN - sum(shares)
    return tuple(Fraction(share, GRAIN) for share in shares)


def drawn(probabilities: tuple[Fraction, ...], below: Callable[[int], int]) -> int | None:
    """Draw a place exactly by its probability, or None for what they lack to 1."""
    bottom = 1
    for value in probabilities:
        bottom = (
            max(bottom, value.denominator)
            if max(bottom, value.denominator) % min(bottom, value.denominator) == 0
            else bottom * value.denominator
        )
    point = below(bottom)
    for place, value in enumerate(probabilities):
        point -= int(value * bottom)
        if point < 0:
            return place
    return None
