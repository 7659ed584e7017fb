"""What stands on a page as pictures and tables: rates of groups on one scale, contexts ranked, what is known of a ratio, every row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isfinite
from typing import Any

from fairaudit.certificates.reader import number
from fairaudit.reports.charts import Axis, linear, logarithmic
from fairaudit.reports.content import Content
from fairaudit.reports.expectations import MEMBERS, PANELS
from fairaudit.reports.ladder import Rung, Step, by_scope
from fairaudit.reports.overview import Overview, of_content
from fairaudit.reports.overview_parts import rate_text
from fairaudit.reports.rows import Ranked, Row, context_rows, of_line, ranked, table_rows
from fairaudit.reports.unknown_groups import UnknownRange, as_ratio
from fairaudit.reports.words import Value, clip
from fairaudit.words import percent

__all__ = ["Chart", "Known", "Views"]

SHOW_RANKED = 10  # contexts of the ranking that are not folded

MOST_GROUPS = 40  # groups whose means over all contexts stand on a page


@dataclass(frozen=True)
class Chart:
    """Groups that are compared with each other, each with its marks on the scale.

    Attributes
    ----------
    title : str
        Where they are compared.
    apart : Value
        How far apart they are.
    rows : tuple of (Row, str)
        The groups; of many the worst and the best.
    folded : tuple of (Row, str)
        Those between.
    more : int
        How many are in neither.
    limited : bool
        Whether a limit stands in the picture.
    """

    title: str
    apart: Value
    rows: tuple[tuple[Row, str], ...]
    folded: tuple[tuple[Row, str], ...]
    more: int
    limited: bool


@dataclass(frozen=True)
class Known:
    """What is known of a ratio, with one scale for all of it."""

    title: str
    axis: Axis
    steps: tuple[tuple[Step, str], ...]
    rest: tuple[Rung, ...]


@dataclass(frozen=True, eq=False)
class Views:
    """The pictures and tables of a page."""

    page: Content

    @cached_property
    def rates(self) -> bool:
        """Whether what groups get are rates, to be said in per cent."""
        return self.overview is not None and self.overview.rates

    @cached_property
    def overview(self) -> Overview | None:
        """What the audit comes to; None without a table."""
        return of_content(self.page, groups=MOST_GROUPS)

    def amount(self, value: Value) -> str:
        """What a group gets, in per cent where it is a rate."""
        return rate_text(value) if self.rates else value.decimal

    def between(self, ends: tuple[Value, Value]) -> str:
        """An interval of what a group gets."""
        low, high = map(self.amount, ends)
        return f"{low.removesuffix(' %')} to {high}"

    @property
    def left_out(self) -> Sequence[str]:
        """What was left out or merged."""
        return self.page.prepared if self.overview is None else self.overview.left_out

    @property
    def as_read(self) -> Sequence[str]:
        """The same, after which decisions count as the contrary of those that count."""
        return (*([self.overview.others] if self.overview is not None and self.overview.others else []), *self.left_out)

    @cached_property
    def group_column(self) -> str:
        """The names of the columns of groups, as the labels stand in the rows."""
        return clip(" / ".join(self.page.document["subject"]["columns"]["group"]))

    @cached_property
    def context_column(self) -> str:
        """The same of contexts; empty where there are none."""
        return clip(" / ".join(self.page.document["subject"]["columns"]["context"]))

    @cached_property
    def recorded(self) -> bool:
        """Whether it is known how many decisions were recorded of each group."""
        return self.page.subject is not None and self.page.subject.law.kind == "counts"

    @cached_property
    def limits(self) -> dict[str, list[Value]]:
        """The targets, by quantity, as ratios or, of utilities that can be negative, as differences."""
        found: dict[str, list[Value]] = {"local": [], "global": []}
        for target in self.page.document["targets"]:
            if target["quantity"] in found and (target["unit"] == "difference") == self.page.signed:
                found[target["quantity"]].append(Value(number(target["limit"])) if self.page.signed else as_ratio(target))
        return found

    @property
    def amount_name(self) -> str:
        """What is compared, at the head of a column."""
        return clip(self.overview.amount, 30) if self.overview is not None else self.page.amount.capitalize()

    @property
    def over_units(self) -> bool:
        """Whether what stands for all contexts are means over units."""
        lines = () if self.overview is None else self.overview.groups
        return any(line.gets.size is not None and line.gets.size.units is not None for line in lines)

    @property
    def units_within(self) -> bool:
        """Whether, within a context, intervals are about means over units."""
        return any(row.over_units for _, rows in self._panels for row in rows)

    @property
    def apart_name(self) -> str:
        """How far a group is from the best one, at the head of a column."""
        return "From the best" if self.page.signed else "Ratio to the best"

    # What each group gets

    @cached_property
    def _ranked(self) -> tuple[list[Ranked], int]:
        of = self.page.expectations
        return ([], 0) if of is None else ranked(of)

    @cached_property
    def _overall(self) -> list[Row]:
        lines = () if self.overview is None else self.overview.groups
        return [of_line(line, lines[-1].gets.mean.value) for line in lines]

    @cached_property
    def _panels(self) -> list[tuple[Ranked, list[Row]]]:
        of = self.page.expectations
        if of is None:
            return []
        return [(one, context_rows(of, *one.cells, burden=self.page.burden, most=MEMBERS)) for one in self._ranked[0][:PANELS]]

    @cached_property
    def axis(self) -> Axis:
        """The scale of what groups get: one for all of them."""
        rows = [*self._overall, *(row for _, rows in self._panels for row in rows)]
        seen = [value for row in rows for value in (row.value, *(row.ends or ()), *([row.before] if row.before else []))]
        return linear(seen, percent=self.rates)

    @cached_property
    def overall(self) -> Chart | None:
        """The groups over all contexts; where there is one context, in that."""
        of = self.page.expectations
        if of is None or not (self._overall or self._panels):
            return None
        if self._overall and self.overview is not None:
            single = len(of.subject.law.contexts) == 1
            size = len(self._overall) + self.overview.more_groups
            title = "All decisions" if single else "All contexts together"
            return self._chart(title, self._overall[0].apart, self._overall, size, ("local", "global") if single else ("global",))
        if len(of.subject.law.contexts) > 1:
            return None
        one, rows = self._panels[0]
        return self._chart("All decisions", one.apart, rows, one.cells[1] - one.cells[0], ("local", "global"))

    @cached_property
    def contexts(self) -> list[Chart]:
        """The groups of the most unequal contexts."""
        if self.page.expectations is None or len(self.page.expectations.subject.law.contexts) == 1:
            return []
        return [self._chart(one.title, one.apart, rows, one.cells[1] - one.cells[0], ("local",)) for one, rows in self._panels]

    def _chart(self, title: str, apart: Value, rows: list[Row], size: int, quantities: tuple[str, ...]) -> Chart:
        best: Fraction = Fraction(next(row for row in rows if row.best).value.value)
        edges = [edge for name in quantities for limit in self.limits[name] for edge in self._edge(best, limit)]
        far = None
        if edges:
            far = (min(edges), self.axis.high) if self.page.burden else (self.axis.low, max(edges))
        marks = []
        for row in rows:
            track = self.axis.track(
                dots=[(row.value, "first" if row.best else "")],
                whiskers=[row.ends] if row.ends else [],
                rings=[row.before] if row.before else [],
                limits=edges,
                beyond=far,
            )
            marks.append((row, track))
        between = marks[MEMBERS - 1 : -1] if len(marks) > MEMBERS else []
        first = [*marks[: MEMBERS - 1], marks[-1]] if between else marks
        return Chart(title, apart, tuple(first), tuple(between), size - len(marks), bool(edges))

    def _edge(self, best: Fraction, limit: Value) -> list[float]:
        """Where a group would reach the limit, compared with the best one of the table."""
        if not isfinite(float(limit)) or not isfinite(float(Value(best))):
            return []
        if self.page.signed:
            return [float(best) + float(limit) if self.page.burden else float(best) - float(limit)]
        return [float(best) * float(limit) if self.page.burden else float(best) / float(limit)]

    @property
    def limited(self) -> bool:
        """Whether a target is set."""
        return any(self.limits.values())

    @property
    def whiskers(self) -> bool:
        """Whether intervals stand in them."""
        return any(row.ends for row in (*self._overall, *(row for _, rows in self._panels for row in rows)))

    @property
    def rings(self) -> bool:
        """Whether they show what would be without filters."""
        return any(row.before for _, rows in self._panels for row in rows)

    @cached_property
    def confidence(self) -> str:
        """At which confidence each interval of a group holds by itself."""
        found = self.page.document.get("intervals", {}).values()
        return next((percent(number(entry["confidence"])) for entry in found), "")

    @cached_property
    def rows(self) -> list[Row]:
        """Every group of every context; empty where there are too many for a page."""
        of = self.page.expectations
        return [] if of is None else table_rows(of, burden=self.page.burden)

    @property
    def sure_rows(self) -> bool:
        """Whether any of these has an interval."""
        return any(row.ends for row in self.rows)

    @property
    def cells(self) -> int:
        """How many rows the complete table has."""
        return 0 if self.page.subject is None else len(self.page.subject.law.cell_group)

    # Contexts, ranked

    @cached_property
    def ratio_axis(self) -> Axis:
        """The scale of the ratios of contexts."""
        ratios = [one.apart for one in self._ranked[0]]
        return linear([*ratios, *self.limits["local"]]) if self.page.signed else logarithmic([*ratios, *self.limits["local"]])

    @cached_property
    def ranking(self) -> list[tuple[Ranked, str]]:
        """The contexts, the furthest apart first; empty where there is only one."""
        of = self.page.expectations
        if of is None or len(of.subject.law.contexts) == 1:
            return []
        limits, axis = self.limits["local"], self.ratio_axis
        far = (min(limits, key=float), Value(number("inf"))) if limits else None
        return [(one, axis.track(bars=[(one.apart, "measured")], limits=limits, beyond=far)) for one in self._ranked[0]]

    @property
    def first(self) -> list[tuple[Ranked, str]]:
        """Those that are not folded."""
        return self.ranking[:SHOW_RANKED]

    @property
    def others(self) -> list[tuple[Ranked, str]]:
        """Those that are."""
        return self.ranking[SHOW_RANKED:]

    @property
    def unranked(self) -> int:
        """How many contexts are not in the list."""
        return self._ranked[1] - len(self._ranked[0])

    # What is known

    @cached_property
    def known(self) -> list[Known]:
        """What is known of both ratios, scope by scope."""
        return [self._known(name, rungs) for name, rungs in self.page.ladders.items()]

    def _known(self, name: str, rungs: Sequence[Rung]) -> Known:
        steps, rest = by_scope(rungs)
        axis = logarithmic([value for step in steps for value in (step.low, step.high)])
        limits = [step.high for step in steps if step.kind == "target"]
        far = (min(limits, key=float), Value(number("inf"))) if limits else None
        title = "Within contexts" if name == "local" else "Overall"
        marks = [(step, axis.track(**_marks(step), limits=limits, beyond=far)) for step in steps]
        return Known(title, axis, tuple(marks), tuple(rest))

    def any(self, *kinds: str) -> bool:
        """Whether something of these kinds is known of a ratio."""
        return any(step.kind in kinds for known in self.known for step, _ in known.steps)

    def whoever(self, found: UnknownRange) -> tuple[Axis, str]:
        """The range of a ratio, whoever the unknown are, with its scale."""
        axis = logarithmic([found.greatest, found.labelled, *found.limits])
        far = (min(found.limits, key=float), Value(number("inf"))) if found.limits else None
        return axis, axis.track(dots=[(found.labelled, "")], whiskers=[(found.least, found.greatest)], limits=found.limits, beyond=far)


def _marks(step: Step) -> dict[str, Any]:
    if step.kind == "measured":
        return {"dots": [(step.high, "first")]}
    if step.kind == "unfiltered":
        return {"rings": [step.high]}
    if step.kind == "interval":
        return {"whiskers": [(step.low, step.high)]}
    if step.kind == "least":
        return {"whiskers": [(step.low, Value(number("inf")))]}
    return {"bars": [(step.high, step.kind)]} if step.kind == "bound" else {}
