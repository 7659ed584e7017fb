"""What an unrecorded factor would have to be to explain a ratio away, and targets that are judged with a declared one (T14)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, inf
from typing import TYPE_CHECKING, Any

from fairaudit.audits.targets import Target
from fairaudit.errors import InputError
from fairaudit.exact.enclosures import exp_enclosure
from fairaudit.exact.extended import Extended
from fairaudit.inference.interval import Interval
from fairaudit.inference.verdicts import verdict as interval_verdict
from fairaudit.measures.limits import Limit, Quantity
from fairaudit.measures.ratios import Ratio
from fairaudit.model.law import Law
from fairaudit.theorems.t14 import DIGITS, Frontier, HiddenContext, frontier, least_ratio
from fairaudit.words import HIDDEN, brief

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.model.policy import Deployment

__all__ = ["Explanation", "Remaining", "explanations", "judged_with_hidden_context", "read_hidden_context", "remaining_ratios"]


@brief
@dataclass(frozen=True, repr=False)
class Explanation:
    """What it would take of an unrecorded factor to explain a ratio away.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio.
    interval : Interval or None
        Of the population behind the draws the interval whose lower end is to be explained away; None for the ratio of the table.
    levels : tuple of Frontier
        What it would take to bring it down to 1, and to each target that it exceeds.
    """

    quantity: Quantity
    interval: Interval | None
    levels: tuple[Frontier, ...]


@brief
@dataclass(frozen=True, repr=False)
class Remaining:
    """What a declared hidden context leaves of a ratio at the least.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio.
    interval : Interval or None
        Of the population behind the draws the interval whose lower end it starts from; None for the ratio of the table.
    value : Fraction or float
        The bound.
    """

    quantity: Quantity
    interval: Interval | None
    value: Extended


def read_hidden_context(
    given: Any, subject: Law | Deployment, measured: Mapping[Quantity, Ratio | None], limits: Sequence[Limit], beside: Mapping[str, Any]
) -> HiddenContext | None:
    """Read what was declared, and refuse it where nothing can be said with it.

    Parameters
    ----------
    given : HiddenContext, str, sequence or None
        What was declared; None if nothing was.
    subject : Law or Deployment
        What is audited.
    measured : mapping
        The ratios that could be measured.
    limits : sequence
        The targets for them.
    beside : mapping of str to object
        Options that it does not go with, by name.

    Raises
    ------
    InputError
        If it is no hidden context, or goes with a policy behind filters, another option, or a target of which nothing was measured.
    """
    if given is None:
        return None
    hidden = HiddenContext.of(given)
    if not isinstance(subject, Law):
        raise InputError(
            "hidden_context is for tables of decisions; a policy behind filters decides by what they release, and by nothing unrecorded"
        )
    for name, other in beside.items():
        if other:
            raise InputError(f"hidden_context does not go with {name}; it says what is left of ratios of one table or log")
    for quantity, _, _ in limits:
        if measured[quantity] is None:
            raise InputError(f"hidden_context cannot judge the target for the {quantity} ratio, which cannot be measured")
    return hidden


def explanations(result: Result) -> Iterator[Explanation]:
    """What would explain the ratios of a result away: those of the table, and the lower ends for the population, as far as above 1.

    Nothing is said of differences, and of a policy behind filters, which decides by what the filters release and by nothing unrecorded.
    """
    if result.deployment is not None:
        return
    for seen in _seen(result):
        if seen.value > 1:
            targets = [target for target in result.targets if target.quantity == seen.quantity and target.unit != "difference"]
            below = sorted({to for target in targets if (to := _as_ratio(target, seen.value)) is not None and 1 < to < seen.value < inf})
            yield Explanation(seen.quantity, seen.interval, tuple(frontier(seen.value, to) for to in (Fraction(1), *below)))


def remaining_ratios(result: Result) -> Iterator[Remaining]:
    """What the declared hidden context leaves of each ratio."""
    if result.hidden_context is not None:
        for seen in _seen(result):
            yield Remaining(seen.quantity, seen.interval, least_ratio(seen.value, result.hidden_context))


def judged_with_hidden_context(
    hidden: HiddenContext,
    measured: Mapping[Quantity, Ratio | None],
    limits: Sequence[Limit],
    confidence: Fraction | None,
    intervals: Mapping[Quantity, Interval],
) -> tuple[Target, ...]:
    """Judge limits with a declared hidden context.

    What it leaves of the ratio exceeds a limit, or nothing is settled: how much a fair ratio may hide has no bound.
    """
    targets = []
    for quantity, unit, limit in limits:
        ratio, interval = measured[quantity], intervals.get(quantity)
        seen = ratio.ratio if ratio is not None else Fraction(1)
        if confidence is not None:
            seen = interval.lower if interval is not None else Fraction(1)
        verdict = interval_verdict((least_ratio(seen, hidden), inf), **{f"max_{unit}": limit})
        estimand = interval.estimand if interval is not None and confidence is not None else "mean over rows"
        targets.append(Target(quantity, limit, unit, verdict, confidence, None, estimand, HIDDEN))
    return tuple(targets)


def _seen(result: Result) -> Iterator[Remaining]:
    """The ratios of the table, then the lower ends for the population."""
    quantities: tuple[Quantity, ...] = ("local", "global")
    for quantity, ratio in zip(quantities, (result.local, result.global_), strict=True):
        if ratio is not None:
            yield Remaining(quantity, None, ratio.ratio)
    for quantity in quantities if result.undecided is None else ():
        if quantity in result.intervals:
            yield Remaining(quantity, result.intervals[quantity], result.intervals[quantity].lower)


def _as_ratio(target: Target, seen: Extended) -> Fraction | None:
    """The limit of a target as a ratio, that of a logarithm rounded up; None if it is far above what was seen."""
    if target.unit == "ratio":
        return target.limit
    if isinstance(seen, Fraction) and target.limit > seen.numerator.bit_length() - seen.denominator.bit_length() + 1:
        return None
    if target.limit > 1_000:
        return None
    _, high = exp_enclosure((target.limit.numerator, target.limit.denominator), 64)
    return Fraction(ceil(Fraction(high * 10**DIGITS, 1 << 64)), 10**DIGITS)
