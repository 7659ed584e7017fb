"""Differences of expected utilities as text for a terminal: in the table, in the population, and against their limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fairaudit.audits.differences import NEGATIVE
from fairaudit.audits.sentences import size_text
from fairaudit.measures.limits import limit_text
from fairaudit.words import approximate, ends_text, percent, place, plain

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.audits.targets import Target
    from fairaudit.inference.differences import DifferenceInterval
    from fairaudit.measures.limits import Quantity

__all__ = ["difference_rows", "difference_target", "differences"]

NAMES = {"local": "local difference D", "global": "global difference"}


def difference_target(target: Target, result: Result) -> str:
    """A limit on a difference, and what is known of the difference."""
    said = limit_text(target.quantity, target.unit, target.limit)
    found = result.differences
    measured = None if found is None else found.measured[target.quantity]
    if found is None or measured is None:
        return f"{said}: nothing could be compared"
    value, interval = approximate(measured.value), found.intervals.get(target.quantity)
    if target.confidence is None:
        of = ", mean over rows" if result.law.units and result.law.units.repeated else ""
        return f"{said}: it is {value} (this table{of}, decided exactly)"
    if interval is None:
        return f"{said}: nothing bounds the population ({value} in the table)"
    low, high = approximate(interval.lower, "down"), approximate(interval.upper, "up")
    crossed = "; the ends cross" if interval.lower > interval.upper else ""
    of, beside = "", f"{value} in the table"
    if interval.of_units is not None:
        of, beside = f"{interval.estimand} ", f"{approximate(interval.of_units.value)} in the table, and {value} as mean over rows"
    return f"{said}: {of}at least {low}, at most {high}, each at {percent(interval.confidence)} ({beside}){crossed}"


def differences(result: Result) -> str:
    """The differences that were asked for: in the table, and in the population from which it was drawn."""
    found = result.differences
    if found is None:
        return ""
    lines = ["Differences of expected utilities"]
    for quantity, measured in found.measured.items():
        if measured is None:
            lines.append(f"  {NAMES[quantity]}: not compared")
            continue
        pair = measured.witness
        where = f"{plain(place(pair.context))}: " if pair.context else ""
        high, low = map(approximate, pair.expectations)
        sizes = size_text(result.sizes_of(pair))
        size = f" {sizes}" if sizes else ""
        who = f"{where}{plain(place(pair.higher))} {high}, {plain(place(pair.lower))} {low}{size}"
        lines.append(f"  {NAMES[quantity]}  {approximate(measured.value)}  {who}")
    if result.utility.signed:
        lines.append(f"  {NEGATIVE[0].upper()}{NEGATIVE[1:]}.")
    if found.intervals:
        lines += ["  In the population from which these decisions were drawn", *(f"  {row}" for row in difference_rows(found.intervals))]
        if len(found.intervals) == 2 and len({target.quantity for target in result.targets}) < 2:
            lines.append("    Each interval holds at its confidence by itself.")
        said = {text for interval in result.intervals.values() for text in interval.assumptions}
        texts = dict.fromkeys(text for interval in found.intervals.values() for text in interval.assumptions if text not in said)
        lines += ["  For you to judge", *(f"    - {plain(text)}" for text in texts)] if texts else []
    return "\n".join(lines)


def difference_rows(found: Mapping[Quantity, DifferenceInterval]) -> list[str]:
    """A line for each interval."""
    rows = []
    for quantity, own in found.items():
        each = own.ends == "each"
        ends = ends_text(approximate(own.lower, "down"), approximate(own.upper, "up"), each=each)
        of = "" if own.of_units is None else f", {own.estimand}"
        method = ", ".join(own.methods) or "nothing was drawn at random"
        sure = f"{'each at' if each else 'at confidence'} {percent(own.confidence)} ({method})"
        rows.append((f"{NAMES[quantity]}{of}", ends, sure))
    widths = [max(len(row[i]) for row in rows) for i in range(2)] if rows else []
    return ["  " + "  ".join([*(cell.ljust(width) for cell, width in zip(row[:2], widths, strict=True)), row[2]]) for row in rows]
