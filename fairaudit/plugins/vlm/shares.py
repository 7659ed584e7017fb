"""Probabilities of answers: of makers that know them, from scores, and drawn from exactly."""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from itertools import accumulate
from math import lcm

import fairaudit as fa
from fairaudit.plugins.vlm.analyse import exact_table, shown_policy
from fairaudit.plugins.vlm.experiment import Experiment, Slots, read_experiment

GRAIN = 1 << 53
DIGITS = Context(prec=40)
"""Decimal arithmetic, in which e^x is correctly rounded: the same on every machine, as that of floats is not."""


class Maker(ABC):
    """A decision maker whose probabilities are known: what runs of an experiment ask, and what `fairaudit.policies` is supplied with.

    Parameters
    ----------
    experiment : Experiment or str, optional
        What is asked: an experiment, or as `read_experiment` takes it; by default the document delivery that ships with fairaudit.
    """

    def __init__(self, experiment: Experiment | str = "document-delivery") -> None:
        self.experiment = experiment if isinstance(experiment, Experiment) else read_experiment(experiment)

    @abstractmethod
    def probabilities(self, context: str, slots: Slots) -> tuple[Fraction, ...]:
        """Of each slot, exact; what they lack to 1 is an answer that is no choice."""

    def table(self) -> fa.Policy:
        """The policy, exact, over everything that can be shown."""
        return shown_policy(self.experiment, exact_table(self.experiment, self.probabilities))


def softmax(scores: list[float]) -> tuple[Fraction, ...]:
    """Shares of e^score as multiples of 2^-53 that add up to 1, the same on every machine.

    Each is rounded down, in decimal arithmetic of 40 digits; what that lacks to 1 goes to the greatest.

    Examples
    --------
    >>> softmax([0.0, 0.0])
    (Fraction(1, 2), Fraction(1, 2))
    """
    with localcontext(DIGITS):
        top = Decimal(max(scores))
        parts = [(Decimal(score) - top).exp() for score in scores]
        total = sum(parts)
        shares = [int(part * GRAIN / total) for part in parts]
    shares[scores.index(max(scores))] += GRAIN - sum(shares)
    return tuple(Fraction(share, GRAIN) for share in shares)


def drawn(probabilities: tuple[Fraction, ...], below: Callable[[int], int]) -> int | None:
    """Draw a place exactly by its probability, or None for what they lack to 1."""
    bottom = lcm(*(value.denominator for value in probabilities))
    place = bisect_right([*accumulate(int(value * bottom) for value in probabilities)], below(bottom))
    return place if place < len(probabilities) else None
