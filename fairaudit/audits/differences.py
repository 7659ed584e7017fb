"""Differences of expected utilities that were asked for: what is measured, bounded and judged of them, and what is said of the pair."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.audits.sentences import Deciding, Drivers, Sizes, size_text
from fairaudit.audits.targets import Target
from fairaudit.errors import InputError, shown
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.interval import Selection
from fairaudit.inference.verdicts import Verdict
from fairaudit.measures.differences import MeanDifference, global_difference, local_difference
from fairaudit.measures.limits import Limit, Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.words import THE_INTERVAL, THIS_TABLE, Words, approximate, percent

if TYPE_CHECKING:
    from fairaudit.inference.bounded_differences import Differences
    from fairaudit.model.policy import Deployment


__all__ = [
    "NEGATIVE",
    "NEGATIVE_RANGE",
    "bounded",
    "decide_difference",
    "difference_pair",
    "difference_sentence",
    "judged_differences",
    "measured_differences",
    "refuse_signed",
    "with_ratios",
]


NEGATIVE = "utilities can be negative: ratios depend on the origin, so that differences alone are stated"

NEGATIVE_RANGE = "no interval for a ratio is claimed: the declared range goes below 0, and ratios depend on the origin"


def measured_differences(law: Law, table: UtilityTable) -> dict[Quantity, MeanDifference | None]:
    """The greatest differences of a table, within contexts and over them."""
    return {"local": local_difference(law, table), "global": global_difference(law, table)}


def bounded(
    measured: Mapping[Quantity, MeanDifference | None],
    comparisons: Mapping[Quantity, Comparison],
    errors: Mapping[Quantity, Fraction],
    named: set[Quantity],
    **chosen: Any,
) -> Differences:
    """What the draws say of the differences (`bound_differences`), which audits of ratios do not load."""
    from fairaudit.inference.bounded_differences import bound_differences

    return bound_differences(measured, comparisons, errors, named, **chosen)


def refuse_signed(subject: Law | Deployment, table: UtilityTable, *, asked: bool, ratios: Sequence[Limit]) -> None:
    """Refuse what a utility that can be negative does not go with.

    Raises
    ------
    InputError
        If differences were not asked for, a ratio is limited, or the subject is a policy behind filters.
    """
    if not table.signed:
        return
    if not asked:
        raise InputError("utilities can be negative, and ratios depend on the origin; ask for differences (difference, --difference)")
    _refuse_limits(ratios)
    if not isinstance(subject, Law):
        raise InputError("a policy behind filters needs utilities of at least 0; audit the law that it gives, with differences")


def _refuse_limits(ratios: Sequence[Limit]) -> None:
    if ratios:
        quantity, unit, _ = ratios[0]
        raise InputError(
            f"max_{quantity}_{unit} limits a ratio, and utilities can be negative: ratios depend on the origin; give max_difference "
            "(--max-difference) or max_global_difference"
        )


def with_ratios(
    table: UtilityTable,
    comparisons: Mapping[Quantity, Comparison],
    declared: Mapping[str, Fraction],
    limits: Sequence[Limit],
    select: Selection,
) -> tuple[Mapping[Quantity, Comparison], tuple[str, ...]]:
    """What is compared by ratios, too: nothing where what could be drawn has a negative utility; and what is said of that.

    Raises
    ------
    InputError
        If a ratio is limited, or a pair was to be chosen by one, where there is none.
    """
    if not table.signed and not (comparisons and declared.get("m", Fraction(0)) < 0):
        return comparisons, ()
    _refuse_limits(limits)
    if select != "bonferroni":
        raise InputError(f"select {shown(select)} is for ratios, and utilities can be negative: leave it out")
    return {}, (NEGATIVE if table.signed else NEGATIVE_RANGE,)


def judged_differences(found: Differences, limits: Sequence[Limit], confidence: Fraction | None) -> tuple[Target, ...]:
    """Judge limits on differences: of the table itself exactly, or, at a confidence, of the population by its intervals."""
    targets = []
    for quantity, unit, limit in limits:
        measured, interval = found.measured[quantity], found.intervals.get(quantity)
        if confidence is None:
            verdict: Verdict = "inconclusive" if measured is None else "within" if measured.value <= limit else "exceeds"
            targets.append(Target(quantity, limit, unit, verdict))
            continue
        if interval is None:
            targets.append(Target(quantity, limit, unit, "inconclusive", confidence))
            continue
        within, exceeds = interval.upper <= limit, interval.lower > limit
        verdict = "inconclusive" if within == exceeds else "within" if within else "exceeds"
        upper = (interval.upper, THE_INTERVAL)
        targets.append(Target(quantity, limit, unit, verdict, confidence, upper, interval.estimand))
    return tuple(targets)


def decide_difference(
    target: Target, measured: MeanDifference | None, ends: tuple[Fraction, Fraction] | None, drivers: Drivers
) -> Deciding | None:
    """Say what decided a target on a difference; None where nothing could be compared or bounded."""
    if measured is None or (target.confidence is not None and ends is None):
        return None
    if target.confidence is None or ends is None:
        return Deciding(target.quantity, target.verdict, "table", measured.value, THIS_TABLE, None, measured.witness, "difference")
    if target.verdict == "exceeds":
        return Deciding(target.quantity, target.verdict, "lower", ends[0], THE_INTERVAL, target.confidence, drivers[0], "difference")
    return Deciding(target.quantity, target.verdict, "upper", ends[1], THE_INTERVAL, target.confidence, drivers[1], "difference")


def _headline(deciding: Deciding | None, measured: Mapping[Quantity, MeanDifference | None]) -> MeanDifference | None:
    """The difference that the sentence of a result is about."""
    return measured["local"] or measured["global"] if deciding is None else measured[deciding.quantity]


def difference_pair(deciding: Deciding | None, measured: Mapping[Quantity, MeanDifference | None]) -> Witness | None:
    """The pair of groups that the sentence is about: the one that decided, or the one that is furthest apart."""
    found = _headline(deciding, measured)
    return deciding.pair if deciding is not None and deciding.pair is not None else None if found is None else found.witness


def difference_sentence(
    deciding: Deciding | None,
    measured: Mapping[Quantity, MeanDifference | None],
    words: Words,
    *,
    sizes_of: Callable[[Witness], Sizes | None],
    name: Callable[[Mapping[str, str]], str],
    contexts: bool,
    mean: str = "in the table",
) -> str:
    """Say who is favoured over whom, where, and by how much more: of the pair that decided, or the one that is furthest apart."""
    found = _headline(deciding, measured)
    pair = difference_pair(deciding, measured)
    if found is None or pair is None:
        return "No two groups can be compared."
    where = f"In {name(pair.context)}, " if pair.context else "Over all contexts, " if pair.context is None and contexts else ""
    if not found.value and (deciding is None or deciding.end == "table"):
        return f"{where}all compared groups have the same {words.amount}."
    high, low = pair.expectations
    size = size_text(sizes_of(pair))
    sized = f" {size}" if size else ""
    apart = f"{words.amounts(pair.expectations)} {mean}, {approximate(high - low)} apart"
    if deciding is None or deciding.end == "table":
        apart = f"{words.amounts(pair.expectations)}, {approximate(high - low)} apart"
        return f"{where}{name(pair.higher)} {words.worse} {name(pair.lower)}: {apart}{sized}."
    sure = f"in the population, at confidence {percent(deciding.confidence or 0)}"
    if deciding.end == "lower":
        least = f"and at least {approximate(deciding.value, 'down')} {sure}"
        return f"{where}{name(pair.higher)} {words.worse} {name(pair.lower)}: {apart}, {least}{sized}."
    most = approximate(deciding.value, "up")
    how = f"comes closest to the limit: at most {most}" if deciding.verdict == "within" else f"leaves it open: up to {most}"
    return f"{where}{name(pair.higher)} over {name(pair.lower)} {how} {sure}; {apart}{sized}."
