"""A confidence interval of a fairness ratio, with its evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal

from fairaudit.exact.enclosures import log_enclosure
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.inference.comparisons import Estimand
from fairaudit.inference.levels import Holding
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.words import brief

Region = Literal["box", "product", "pairs", "contrasts", "paired", "joint"]

Selection = Literal["bonferroni", "half-split"]
"""How the lower end finds its pair: all pairs share the error, or half of the draws chooses one."""


@brief
@dataclass(frozen=True, repr=False)
class Interval:
    """A confidence interval of a fairness ratio.

    Attributes
    ----------
    lower : Fraction
        At least 1.
    upper : Fraction or float
        Possibly `math.inf`.
    estimate : Fraction or float or None
        The ratio of the sample itself, of the means that are estimated; None if a cell has no draws.
    confidence : Fraction
        The probability, before the draws, that the ends are right, as `ends` says.
    region : {"box", "product", "pairs", "contrasts", "paired", "joint"}
        How the ends of the cells are joined.
    methods : tuple of str
        How the ends of the cells were found.
    assumptions : tuple of str
        What the reader must accept.
    evidence : dict
        What a checker needs, as docs/certificate-samples.md describes it.
    pairs : pair of Witness or None, optional
        Of a stream, the pairs that drive the lower and the upper end; `drivers` finds those of others.
    estimand : {"mean over rows", "mean over units"}
        Of what the ratio is bounded: with sampling units of several rows in a cell, of the means over units.
    of_units : Ratio or None
        Then the ratio of the sample itself as the mean over units, with its witness.
    ends : {"together", "each", "lower", "upper"}
        Whether the confidence is that of both ends together, of each by itself, or of the only one that was asked for.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> found = result.intervals["local"]
    >>> round(float(found.lower), 3), round(float(found.upper), 3), found.confidence
    (1.0, 2.583, Fraction(19, 20))
    """

    lower: Fraction
    upper: Extended
    estimate: Extended | None
    confidence: Fraction
    region: Region
    methods: tuple[str, ...]
    assumptions: tuple[str, ...]
    evidence: dict[str, Any]
    pairs: tuple[Witness | None, Witness | None] = (None, None)
    estimand: Estimand = "mean over rows"
    of_units: Ratio | None = None
    ends: Holding = "together"

    @cached_property
    def log(self) -> tuple[Decimal, Decimal]:
        """Both ends on the scale of L, rounded outwards."""
        return Decimal(log_enclosure(extended_pair(self.lower))[0]), Decimal(log_enclosure(extended_pair(self.upper))[1])


Places = tuple[Sequence[int] | None, Sequence[int] | None]
"""Block, higher and lower of the pairs behind the lower and the upper end."""
