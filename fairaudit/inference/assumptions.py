"""What the reader of an interval must accept, one sentence each."""

from __future__ import annotations

from fractions import Fraction

from fairaudit.exact.extended import extended_text

OWN_RANGE = "whatever could have been drawn in a cell has a utility between 0 and the greatest that a decision has there"

DRAWS = (
    "the draws within a cell are independent, each with the law of the cell, and how many there are does not depend on how they came out"
)

CELLS = "the draws of different cells are independent of each other"

DECLARED = "utility, method and confidence were chosen without looking at the draws"

ONE_ROW = "a sampling unit can have no more than one row in a cell, as is the case here"

UNITS = (
    "different sampling units are independent, how many there are does not depend on how they came out, and the mean over the rows of a "
    "unit in a cell has the same expectation for all units: it is estimated by the mean over units, which is not the mean over rows"
)

GIVEN_TRUTH = (
    "given the true labels, the decisions are independent, each positive with the rate of its cell, and how many there are of a true label "
    "does not depend on how they came out"
)

DECLARED_POSITIVE = "positive labels, method and confidence were chosen without looking at the draws"

POOLED = "the contexts of each group were drawn from its population, not set by design"

POPULATION = "the contexts of each group are distributed as in the stated population"


def range_said(low: Fraction, high: Fraction) -> str:
    return f"whatever could have been drawn has a utility between {extended_text(low)} and {extended_text(high)}"


PAST = "given everything recorded before it, each decision has the expected utility of its context and group as its mean"

OWN_PAST = "given the earlier decisions that count in its context and group, each such decision has their expected utility as its mean"

ORDER = "which contexts and groups appear, and in what order they first do, does not depend on how decisions come out"

MIX = "whatever came before, the context of a group's next decision has the same distribution, and so its expected utility stays the same"
