"""The differences of expected utilities of one audit: those of the table, and what the draws say of the population."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.differences import DifferenceInterval, default_difference_region, difference_drivers, difference_interval
from fairaudit.inference.ends import Method
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.limits import Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.words import brief

__all__ = ["Differences", "bound_differences"]


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Differences:
    """What is said of the differences of expected utilities.

    Attributes
    ----------
    measured : dict
        The greatest difference in the table, under ``"local"`` (within contexts) and ``"global"``; None where nothing can be compared.
    intervals : dict of str to DifferenceInterval
        Intervals of the differences of the population behind counts, where there is one.
    """

    measured: Mapping[Quantity, MeanDifference | None]
    intervals: Mapping[Quantity, DifferenceInterval] = field(default_factory=dict)
    comparisons: Mapping[Quantity, Comparison] = field(default_factory=dict, repr=False)

    @cached_property
    def drivers(self) -> Mapping[Quantity, tuple[Witness | None, Witness | None]]:
        """For each interval the pairs of groups that drive its lower and its upper end."""
        return {
            quantity: difference_drivers(self.comparisons[quantity], found.evidence, found.upper)
            for quantity, found in self.intervals.items()
        }

    @cached_property
    def two_sided(self) -> Mapping[Quantity, DifferenceInterval]:
        """Of the differences with a target, the interval both ends of which hold together."""
        found: dict[Quantity, DifferenceInterval] = {}
        for quantity, own in self.intervals.items():
            if own.ends == "each":
                method, independent = own.evidence["method"], own.evidence["independent"]
                compared = self.comparisons[quantity]
                found[quantity] = difference_interval(compared, own.confidence, method=method, region=own.region, independent=independent)
        return found


def bound_differences(
    measured: Mapping[Quantity, MeanDifference | None],
    comparisons: Mapping[Quantity, Comparison],
    errors: Mapping[Quantity, Fraction],
    named: set[Quantity],
    *,
    method: Method | None,
    independent: bool,
) -> Differences:
    """Bound the differences in the population, each at its error; of those with a target each end holds by itself."""
    intervals: dict[Quantity, DifferenceInterval] = {}
    for quantity, comparison in comparisons.items():
        alpha = errors[quantity]
        region = default_difference_region(comparison, method, independent=independent, alpha=alpha)
        intervals[quantity] = difference_interval(
            comparison,
            1 - alpha,
            method=method or "hoeffding-kl",
            region=region,
            independent=independent,
            ends="each" if quantity in named else "together",
        )
    return Differences(measured, intervals, comparisons)
