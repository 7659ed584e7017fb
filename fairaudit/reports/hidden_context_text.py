"""What an unrecorded factor could explain, as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING

from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import limit_text
from fairaudit.words import approximate, percent

if TYPE_CHECKING:
    from fairaudit.audits.hidden_context import Explanation
    from fairaudit.audits.result import Result
    from fairaudit.audits.targets import Target
    from fairaudit.theorems.t14 import Frontier, HiddenContext

__all__ = ["explained", "factor_text", "hidden_target", "left_text", "strength_text"]


def explained(result: Result) -> str:
    """What it would take to explain each ratio away, and what the declared factor leaves of it."""
    lines = []
    if result.explanations:
        lines.append(
            "Could something unrecorded explain it? Not unless it is k times as common in one group, and changes the outcome m times"
        )
        for quantity in ("local", "global"):
            judged = {target.confidence for target in result.targets if target.quantity == quantity}
            own = [_explanation(found, judged) for found in result.explanations if found.quantity == quantity]
            lines += [f"  {'; '.join(own)}"] if own else []
    if result.hidden_context is not None:
        lines.append(f"With {factor_text(result.hidden_context)}")
        for left in result.remaining:
            where = "in the table" if left.interval is None else f"in the population, at confidence {percent(left.interval.confidence)}"
            lines.append(f"  {left.quantity} ratio: {left_text(left.value)} {where}")
    return "\n".join(lines)


def left_text(value: Extended) -> str:
    """What is left of a ratio."""
    return "perhaps nothing is left" if value == 1 else f"at least {approximate(value, 'down')} is left"


def _explanation(found: Explanation, judged: Iterable[Fraction | None]) -> str:
    """What it takes for the figure, with one pair, or for the lower end of the population, and for the targets that are about it."""
    first, *targets = found.levels
    shown = targets if (found.interval is None) == (None in judged) else []
    down = "".join(f", down to {approximate(level.to)}: {strength_text(level)}" for level in shown)
    if found.interval is not None:
        return f"lower end {approximate(first.ratio, 'down')}: {strength_text(first)}{down}"
    pairs = f", or k = {approximate(first.pairs[0][0])} and m = {approximate(first.pairs[0][1], 'down')}" if first.pairs else ""
    return f"{found.quantity} ratio {approximate(first.ratio)}: {strength_text(first)}{pairs}{down}"


def strength_text(level: Frontier) -> str:
    """The balanced strength that it takes, rounded down."""
    return "nothing explains it" if not isinstance(level.balanced, Fraction) else f"k = m = {approximate(level.balanced, 'down')}"


def factor_text(hidden: HiddenContext) -> str:
    """A declared factor in words.

    Examples
    --------
    >>> from fairaudit.theorems.t14 import HiddenContext
    >>> factor_text(HiddenContext.of("2,3"))
    'an unrecorded factor that is at most 2 times as common in one group as in another and changes what one of them gets at most 3 times'
    """
    most, changes = map(_times, (hidden.k, hidden.m))
    where = {
        "both": f"{most} as common in one group as in another and changes what one of them gets",
        "higher": f"{most} as common in the group that gets more as in the other and changes what the other gets",
        "lower": f"{most} as common in the group that gets less as in the other and changes what the other gets",
    }[hidden.direction]
    return f"an unrecorded factor that is {where} {changes}"


def _times(value: Extended) -> str:
    return f"at most {approximate(value)} times" if isinstance(value, Fraction) else "any number of times"


def hidden_target(target: Target, result: Result) -> str:
    """A target that is judged with the declared hidden context."""
    own: Iterable[Extended] = [
        left.value
        for left in result.remaining
        if left.quantity == target.quantity and (left.interval is None) == (target.confidence is None)
    ]
    least = next(iter(own), Fraction(1))
    of = "this table" if target.confidence is None else f"population at confidence {percent(target.confidence)}"
    said = limit_text(target.quantity, target.unit, target.limit)
    beyond = "" if target.verdict == "exceeds" else "; how much more it may hide has no bound"
    return f"{said}: {left_text(least)}, with the declared hidden context ({of}){beyond}"
