"""Intervals for a stream of decisions that hold at every moment at once, however the moment to look is chosen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from fairaudit.errors import InputError
from fairaudit.exact.extended import extended_text
from fairaudit.exact.rationals import quotient
from fairaudit.inference.anytime_box import StreamBox
from fairaudit.inference.anytime_joint import StreamJoint
from fairaudit.inference.anytime_product import StreamProduct
from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.interval import Interval, Places
from fairaudit.inference.levels import confidence_level
from fairaudit.measures.limits import Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import Label
from fairaudit.theorems.assumptions import DECLARED, MIX, ORDER, OWN_PAST, PAST, range_said
from fairaudit.words import brief

MOST_RATIOS = 8  # of joint bets: each divides the money further


@brief
@dataclass(frozen=True, repr=False)
class Arrivals:
    """The order in which cells first appeared in a stream, and how the budget of error was laid out for them.

    Attributes
    ----------
    order : tuple of (context, group)
        The cells, each a pair of labels, in order of first appearance.
    expected : int
        About how many cells were expected when the stream began, K of the weights K/((j + K − 1)(j + K)); any number is sound.
    joint : bool
        Whether each decision has the mean of its cell given all earlier decisions, of other cells too. False if a sampling unit has
        rows in several cells; then the intervals are wider.
    ratios : tuple of Fraction
        Bet on the two cells of a pair at once, on the lower one by these factors as much: 1, and perhaps the limit of a target. Chosen
        beforehand; narrower than products of bets unless utilities are rare. Without any, by products.
    """

    order: tuple[tuple[Label, Label], ...]
    expected: int = 4
    joint: bool = True
    ratios: tuple[Fraction, ...] = ()

    def __post_init__(self) -> None:
        """Refuse bets that cannot be made."""
        if self.ratios and (not self.joint or min(self.ratios) <= 0 or len(self.ratios) > MOST_RATIOS):
            raise InputError(f"joint bets need cells that are a martingale together, and 1 to {MOST_RATIOS} positive ratios")

    @property
    def region(self) -> Literal["joint", "product", "box"]:
        """Which kind of evidence an interval has."""
        return "box" if not self.joint else "joint" if self.ratios else "product"


def value_counts(
    law: Law, utility: UtilityTable, limits: tuple[Fraction, Fraction], quantity: Quantity
) -> list[list[tuple[Any, ValueCounts]]]:
    """Blocks of cells that are compared, each with its label: for the local ratio by context, for the global one the groups.

    Raises
    ------
    InputError
        If a utility lies outside the limits.
    """
    low, high = limits
    found: dict[tuple[Label, Label], Counter[Fraction]] = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        counts: Counter[Fraction] = Counter()
        for n, g in zip(law.row(cell), utility.row(cell), strict=True):
            if n:
                value = Fraction(g, utility.scale)
                if not low <= value <= high:
                    raise InputError(f"a utility of {value} was recorded, outside the declared limits {low} and {high}")
                counts[(value - low) / (high - low) if high > low else Fraction(0)] += n // law.scale
        found[law.contexts[x], law.groups[a]] = counts
    if quantity == "global":
        pooled: dict[Label, Counter[Fraction]] = {law.groups[a]: Counter() for a in law.global_groups}
        for (_, group), counts in found.items():
            pooled[group].update(counts)
        return [[(group, ValueCounts(dict(counts))) for group, counts in pooled.items()]] if pooled else []
    blocks: dict[Label, list[tuple[Any, ValueCounts]]] = {}
    for (context, group), counts in found.items():
        blocks.setdefault(context, []).append(((context, group), ValueCounts(dict(counts))))
    return [block for block in blocks.values() if len(block) > 1]


def stream_interval(
    law: Law,
    utility: UtilityTable,
    arrivals: Arrivals,
    quantity: Quantity,
    limits: tuple[Fraction, Fraction],
    confidence: Any = "0.95",
    *,
    exact: bool = True,
) -> Interval:
    """Bound a ratio of the process behind a stream, at every moment at once.

    Parameters
    ----------
    law : Law
        What was counted so far.
    utility : UtilityTable
        The utility on it.
    arrivals : Arrivals
        The order in which its cells first appeared.
    quantity : {"local", "global"}
        The worst ratio within a context, or that of the means of groups over all their decisions.
    limits : pair of Fraction
        The range of the utility, fixed in advance.
    confidence : number or str
        The probability that the interval is right at every moment.
    exact : bool
        Whether to prove the ends in integers and keep the evidence. Without, they are estimates in floats, for a display.

    Returns
    -------
    Interval
        The ends, with evidence as docs/certificate-monitor.md describes it.

    Raises
    ------
    InputError
        If nothing is compared, a utility lies outside the limits, or the order lacks a cell.

    Examples
    --------
    >>> from fairaudit import Utility
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> arrivals = Arrivals((((), ("f",)), ((), ("m",))))
    >>> found = stream_interval(law, Utility({"yes": 1}).on(law), arrivals, "local", (Fraction(0), Fraction(1)))
    >>> round(float(found.lower), 2), round(float(found.upper), 2)
    (1.76, 6.19)
    """
    level = confidence_level(confidence)
    if quantity == "global" and not arrivals.joint and len(law.contexts) > 1:
        raise InputError(
            "a unit may have decisions with one group in several contexts, so the global ratio of a stream with units is not bounded"
        )
    blocks = value_counts(law, utility, limits, quantity)
    if not any(len(block) > 1 for block in blocks):
        raise InputError("nothing is compared: no two groups have been seen together")
    order = _ranks(arrivals, quantity)
    try:
        ranks = [[order[label] for label, _ in block] for block in blocks]
    except KeyError as error:
        raise InputError(f"the order of arrival lacks {error.args[0]}") from None
    cells = [[counts for _, counts in block] for block in blocks]
    made = _region(arrivals.region, cells, ranks, arrivals.expected, limits, 1 - level, arrivals.ratios)
    lower, upper, evidence = made.prove() if exact else (*made.estimate(), {})
    assumptions = (PAST if arrivals.joint else OWN_PAST, *((MIX,) if quantity == "global" else ()), ORDER, range_said(*limits), DECLARED)
    means = _means(blocks, limits)
    estimate = max(quotient(max(block), min(block)) for block in means)
    evidence = {
        "confidence": extended_text(level),
        "ends": "together",
        "region": arrivals.region,
        "independent": False,
        "method": "betting",
        "limits": [extended_text(limit) for limit in limits],
        "levels": {
            "expected": arrivals.expected,
            "order": [rank for block in ranks for rank in block],
            **({"ratios": [extended_text(ratio) for ratio in arrivals.ratios]} if arrivals.ratios else {}),
        },
        **evidence,
    }
    pairs = _named(law, quantity, blocks, means, made.places)
    return Interval(lower, upper, estimate, level, arrivals.region, ("betting",), (*assumptions, *law.assumptions), evidence, pairs)


def stream_drivers(
    law: Law, utility: UtilityTable, quantity: Quantity, evidence: Mapping[str, Any]
) -> tuple[Witness | None, Witness | None]:
    """Name the pairs that drive the lower and the upper end of an interval that a certificate stores, as `stream_interval` names them.

    Parameters
    ----------
    law : Law
        What was counted.
    utility : UtilityTable
        The utility on it.
    quantity : {"local", "global"}
        Which ratio is bounded.
    evidence : mapping
        The interval in the certificate.
    """
    limits = (Fraction(evidence["limits"][0]), Fraction(evidence["limits"][1]))
    blocks = value_counts(law, utility, limits, quantity)
    order = iter(evidence["levels"]["order"])
    ranks = [[next(order) for _ in block] for block in blocks]
    cells = [[counts for _, counts in block] for block in blocks]
    levels, alpha = evidence["levels"], 1 - Fraction(evidence["confidence"])
    ratios = tuple(map(Fraction, levels.get("ratios", ())))
    made = _region(evidence["region"], cells, ranks, levels["expected"], limits, alpha, ratios)
    return _named(law, quantity, blocks, _means(blocks, limits), made.places_of(evidence))


def _region(
    name: str,
    cells: list[list[ValueCounts]],
    ranks: list[list[int]],
    expected: int,
    limits: tuple[Fraction, Fraction],
    alpha: Fraction,
    ratios: tuple[Fraction, ...],
) -> StreamBox | StreamProduct:
    if name == "joint":
        return StreamJoint(cells, ranks, expected, limits, alpha, ratios)
    return (StreamProduct if name == "product" else StreamBox)(cells, ranks, expected, limits, alpha)


def _means(blocks: Sequence[Sequence[tuple[Any, ValueCounts]]], limits: tuple[Fraction, Fraction]) -> list[list[Fraction]]:
    return [[limits[0] + (limits[1] - limits[0]) * counts.mean for _, counts in block] for block in blocks]


def _named(
    law: Law, quantity: Quantity, blocks: Sequence[Sequence[tuple[Any, ValueCounts]]], means: Sequence[Sequence[Fraction]], places: Places
) -> tuple[Witness | None, Witness | None]:
    """The pairs at these places, with their labels and means."""

    def witness(at: Sequence[int] | None) -> Witness | None:
        if at is None:
            return None
        b, i, j = at
        labels = [blocks[b][k][0] for k in (i, j)]
        groups = labels if quantity == "global" else [group for _, group in labels]
        higher, lower = (dict(zip(law.columns.group, group, strict=True)) for group in groups)
        context = None if quantity == "global" else dict(zip(law.columns.context, labels[0][0], strict=True))
        return Witness(context, higher, lower, (means[b][i], means[b][j]))

    return witness(places[0]), witness(places[1])


def _ranks(arrivals: Arrivals, quantity: Quantity) -> dict[Any, int]:
    if quantity == "local":
        return {cell: j for j, cell in enumerate(arrivals.order, 1)}
    return {group: j for j, group in enumerate(dict.fromkeys(group for _, group in arrivals.order), 1)}
