"""A window of a stream that contradicts the whole stream until then."""

from __future__ import annotations

from fractions import Fraction
from itertools import chain

from .findings import Finding, compared, finding_of
from .header import Cell
from .interval_proofs import prove_interval
from .intervals import Change, Proven, Unproven
from .rationals import at_most, bits_of
from .rows import read_table
from .table import Table, place_of
from .text import shown
from .work import spend, working_on


def check_change(change: Change, table: Table) -> tuple[list[Finding], Proven | None]:
    """Check that the window contradicts the stream, and say what holds of the window."""
    working_on("the window that contradicts the stream")
    names = chain(["changed.table.header"], (f"changed.table.rows[{i}]" for i in range(len(change.lines) - 1)))
    part = read_table((name, value, None) for name, value in zip(names, change.lines, strict=True))
    findings = [
        compared("changed.table.sha256", change.digest, part.digest),
        compared("changed.table.cells", change.cells, part.rows * len(part.header.decisions)),
    ]
    fault, proven = "", None
    try:
        _check_part(part, table)
        stream, proven = prove_interval(change.stream, table), prove_interval(change.ratio, part)
        if change.stream.limits != change.ratio.limits or change.stream.region != change.ratio.region:
            raise Unproven("the window has another range, or another region, than the stream")
        if at_most(stream.ratio[0], proven.ratio[1]) and at_most(proven.ratio[0], stream.ratio[1]):
            raise Unproven("the two intervals have a ratio in common")
        if change.confidence > 1 - stream.error - change.window**2 * proven.error:
            raise Unproven("the intervals of the stream and of the windows do not hold together at this confidence")
    except Unproven as error:
        fault, proven = str(error), None
    ends = [" and ".join(map(shown, interval.ratio)) for interval in (change.ratio, change.stream)]
    statement = f"changed: the {change.quantity} ratio is between {ends[0]} in window {change.window}, between {ends[1]} in the stream"
    findings.append(finding_of(statement, not fault, fault))
    return findings, proven


def _check_part(part: Table, whole: Table) -> None:
    """Make sure that a window is part of a stream: the same columns, decisions and utility, and in no cell more decisions."""
    one, other = part.header, whole.header
    if one.subject != other.subject or one.decisions != other.decisions or one.utility is None or one.utility != other.utility:
        raise Unproven("the window has other columns, decisions or utilities than the stream")
    counts = {(whole.header.contexts[cell.context], whole.header.groups[cell.group]): _counts(cell) for cell in whole.cells}
    for cell in part.cells:
        listed = counts.get((part.header.contexts[cell.context], part.header.groups[cell.group]))
        if listed is None or any(n > m for n, m in zip(_counts(cell), listed, strict=True)):
            raise Unproven(f"the window has more decisions than the stream {place_of(part, cell)}")


def _counts(cell: Cell) -> list[Fraction]:
    weights, total = cell.law
    spend(40 * len(weights), total.bit_length(), bits_of(Fraction(*cell.mass)))
    return [Fraction(*cell.mass) * weight / total for weight in weights]
