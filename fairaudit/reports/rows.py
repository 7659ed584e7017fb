"""Every group of a table as a row: how many decisions, at what rate, between which ends, and how far from the best group beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, Literal

from fairaudit.reports.expectations import Expectations
from fairaudit.reports.overview_parts import GroupLine, counted_decisions, how_many
from fairaudit.reports.words import Value, clip, named, quotient

__all__ = ["MOST_ROWS", "Ranked", "Row", "context_rows", "of_line", "ranked", "short", "table_rows"]


MOST_ROWS = 2_500  # rows of the complete table that stand on a page as they are: a second of work, and a file of a megabyte

MOST_RANKED = 50  # contexts of a ranking


@dataclass(frozen=True)
class Row:
    """A group, within a context or over all of them.

    Attributes
    ----------
    label : mapping
        The labels of the group, by column.
    context, group : str
        The labels without the names of their columns.
    title : str
        The labels with the names.
    decisions : str
        How many were recorded; empty where none were.
    counted : str
        How many of them count, where each is worth 1 or nothing.
    of : str
        Both in words.
    value : Value
        What the group gets on average.
    ends : pair of Value, or None
        Between which ends that is in the population, by itself at the confidence of the certificate.
    before : Value or None
        What it would be without filters.
    over_units : Value or None
        The mean over units.
    best : bool
        Whether no group beside it fares better.
    apart : Value
        How far it is from the best one: by what factor, or of utilities that can be negative, how much.
    """

    label: Mapping[str, str]
    context: str
    group: str
    title: str
    decisions: str
    counted: str
    of: str
    value: Value
    ends: tuple[Value, Value] | None = None
    before: Value | None = None
    over_units: Value | None = None
    best: bool = False
    apart: Value = Value(Fraction(1))  # noqa: RUF009

    @property
    def less(self) -> Value:
        """The same factor the other way round: the smaller mean over the greater one."""
        return Value(quotient(Fraction(1), self.apart.value) if isinstance(self.apart.value, Fraction) else Fraction(0))


@dataclass(frozen=True)
class Ranked:
    """A context with the groups that are furthest apart in it, and between which cells it stands."""

    title: str
    context: str
    apart: Value
    higher: Row
    lower: Row
    cells: tuple[int, int]


def short(labels: Mapping[str, str]) -> str:
    """Labels without the names of their columns.

    Examples
    --------
    >>> short({"sex": "f", "age": "<30"})
    'f / <30'
    """
    return clip(" / ".join(labels.values()))


def of_line(line: GroupLine, best: object) -> Row:
    """A group over all contexts, as an overview has it, beside the mean of the best one."""
    gets = line.gets
    return Row(
        label=gets.group,
        context="",
        group=gets.short,
        title=gets.label,
        decisions="" if gets.size is None else how_many(gets.size.decisions),
        counted="" if gets.counted is None else how_many(gets.counted),
        of=gets.of,
        value=gets.mean,
        ends=line.ends,
        best=gets.mean.value == best,
        apart=line.greatest,
    )


def context_rows(of: Expectations, start: int, end: int, *, burden: bool = False, most: int | None = None) -> list[Row]:
    """The groups of a context, with the cells from `start` to before `end`, the worst first. Of more than `most` the worst and the best."""
    rows = _compared(_cells(of, start, end), signed=of.signed, burden=burden)
    return _of_context(of, _ordered(rows, most, burden=burden), start)


def table_rows(of: Expectations, *, burden: bool = False, most: int | None = MOST_ROWS) -> list[Row]:
    """Every cell, in the order of the table; empty where there are too many for a page."""
    law, listed = of.subject.law, []
    if most is not None and len(law.cell_group) > most:
        return []
    for start, end in pairwise(law.starts.tolist()):
        if end > start:
            listed += _of_context(of, _compared(_cells(of, start, end), signed=of.signed, burden=burden), start)
    return listed


def ranked(of: Expectations) -> tuple[list[Ranked], int]:
    """The contexts in which groups are compared, the furthest apart first, and how many there are; the longest list is cut."""
    law, values = of.subject.law, of.values
    blocks = [(a, b) for a, b in pairwise(law.starts.tolist()) if b - a > 1]
    apart = {block: of.spread(values[slice(*block)]) for block in blocks}
    listed = []
    for start, end in sorted(blocks, key=apart.__getitem__, reverse=True)[:MOST_RANKED]:
        context = law.context_label(int(law.cell_context[start]))
        high, low = (choose(range(start, end), key=values.__getitem__) for choose in (max, min))
        pair = [_row(of, context, int(law.cell_group[i]), values[i], [i]) for i in (high, low)]
        listed.append(Ranked(named(context), short(context), Value(apart[start, end]), pair[0], pair[1], (start, end)))
    return listed, len(blocks)


def _cells(of: Expectations, start: int, end: int) -> list[Row]:
    law, before = of.subject.law, of.before
    context = law.context_label(int(law.cell_context[start]))
    units = of.over_units(context)
    found = [_row(of, context, int(law.cell_group[i]), of.values[i], [i]) for i in range(start, end)]
    if before is not None:
        found = [replace(row, before=Value(before[i])) for i, row in zip(range(start, end), found, strict=True)]
    return [replace(row, over_units=Value(units[name])) if (name := named(row.label)) in units else row for row in found]


def _row(of: Expectations, context: dict[str, str], group: int, value: Fraction, cells: Sequence[int]) -> Row:
    label = of.subject.law.group_label(group)
    decisions, counted = _recorded(of, cells), _counted(of, cells)
    return Row(
        label=label,
        context=short(context),
        group=short(label),
        title=named({**context, **label}),
        decisions=decisions,
        counted=counted,
        of=f"{counted} of {decisions}" if counted else f"n = {decisions}" if decisions else "",
        value=Value(value),
    )


def _of_context(of: Expectations, rows: list[Row], start: int) -> list[Row]:
    law = of.subject.law
    return _sure(of, rows, "local", law.context_label(int(law.cell_context[start])))


def _sure(of: Expectations, rows: list[Row], quantity: Literal["local", "global"], context: dict[str, str] | None) -> list[Row]:
    """The rows with the ends for the population, where draws allow them."""
    ends = of.ends(quantity, context)
    found = [ends(row.label) for row in rows]
    return [
        row if pair is None else replace(row, ends=(Value(pair[0], "down"), Value(pair[1], "up")))
        for row, pair in zip(rows, found, strict=True)
    ]


def _compared(rows: list[Row], *, signed: bool, burden: bool) -> list[Row]:
    """The rows with how far each is from the best of them."""
    values: list[Any] = [row.value.value for row in rows]
    best = (min if burden else max)(values, default=0)
    apart = [abs(best - value) if signed else quotient(max(best, value), min(best, value)) for value in values]
    return [replace(row, best=value == best, apart=Value(far)) for row, value, far in zip(rows, values, apart, strict=True)]


def _ordered(rows: list[Row], most: int | None, *, burden: bool) -> list[Row]:
    """The worst first and the best last."""
    rows = sorted(rows, key=lambda row: Fraction(row.value.value), reverse=burden)
    return rows if most is None or len(rows) <= most else [*rows[: most - 1], rows[-1]]


def _recorded(of: Expectations, cells: Sequence[int]) -> str:
    law = of.subject.law
    if law.kind != "counts":
        return ""
    return how_many(Fraction(sum(sum(law.row(cell)) for cell in cells), law.scale))


def _counted(of: Expectations, cells: Sequence[int]) -> str:
    law, utility = of.subject.law, of.subject.utility
    own = counted_decisions(utility) if law.kind == "counts" else []
    if not own:
        return ""
    return how_many(Fraction(sum(law.row(cell)[u] for cell in cells for u in own), law.scale))
