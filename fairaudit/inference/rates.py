"""Rates given the true label, with intervals of their differences in the population from which the decisions were drawn."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

from fairaudit.inference.differences import DifferenceInterval, difference_of_rates
from fairaudit.measures.rates import KINDS, OVERALL, RatesGivenTruth, blocks
from fairaudit.theorems.assumptions import DECLARED_POSITIVE, GIVEN_TRUTH, POOLED
from fairaudit.words import brief


@brief
@dataclass(frozen=True, eq=False, repr=False)
class GivenTruth(RatesGivenTruth):
    """Rates given the true label, with intervals as far as they are claimed.

    Attributes
    ----------
    intervals : dict of str to DifferenceInterval
        Intervals of differences in the population, by the names of `differences`.
    """

    intervals: dict[str, DifferenceInterval] = field(default_factory=dict)


def with_intervals(given: RatesGivenTruth, confidence: Fraction) -> GivenTruth:
    """Bound the differences in the population from which the decisions were drawn, each by itself at this confidence."""
    return GivenTruth(
        given.law,
        given.positive,
        {name: _interval(given, name, confidence) for name, found in given.differences.items() if found is not None},
    )


def _interval(given: RatesGivenTruth, name: str, confidence: Fraction) -> DifferenceInterval:
    suffix = OVERALL if name.endswith(OVERALL) else ""
    compared = [block for kind in (KINDS if name.startswith("equalized") else KINDS[:1]) for block in blocks(given.rates[kind + suffix])]
    draws = [[(int(rate.positives), int(rate.draws)) for rate in block] for block in compared]
    assumptions = (GIVEN_TRUTH, *((POOLED,) if suffix else ()), DECLARED_POSITIVE, *given.law.assumptions)
    return difference_of_rates(draws, confidence, assumptions)
