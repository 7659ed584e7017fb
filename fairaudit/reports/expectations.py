"""What each group gets: the expected utilities of a certificate's table, with intervals where decisions were drawn, and their ratios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, get_args

import numpy as np

from fairaudit.audits.sentences import Size, amount_text
from fairaudit.audits.undecided import Undecided, with_meanings
from fairaudit.certificates.reader import Subject
from fairaudit.inference.cells import Ends
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ends import Method, form_ends
from fairaudit.inference.table_comparisons import global_comparison, local_comparison
from fairaudit.measures.expectations import cell_expectation
from fairaudit.model.utility import Utility, UtilityTable
from fairaudit.reports.words import Value, named, quotient
from fairaudit.tables.values import Label

__all__ = ["Expectations", "Matrix", "Member", "Panel"]


PANELS = 8  # contexts on a page; the table has all

MEMBERS = 12  # groups of a context on a page


@dataclass(frozen=True)
class Member:
    """A group of a panel: what it gets on average, with an interval for the population where draws allow one."""

    label: str
    value: Value
    ends: tuple[Value, Value] | None
    before: Value | None
    weight: str
    over_units: Value | None = None


@dataclass(frozen=True)
class Panel:
    """Groups that are compared with each other, most favoured first; only some of them when there are many."""

    title: str
    members: tuple[Member, ...]
    size: int
    ratio: Value


@dataclass(frozen=True)
class Matrix:
    """Ratios of the expected utility of the row's group to that of the column's."""

    title: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    ratios: tuple[tuple[Value | None, ...], ...]
    size: int


@dataclass(frozen=True, eq=False)
class Expectations:
    """Expected utilities of the groups of a table.

    Attributes
    ----------
    subject : Subject
        The table.
    intervals : mapping
        The intervals of the certificate, by quantity.
    undecided : Undecided or None
        Which decisions may have meant anything: ends for the population then hold whatever they did.
    """

    subject: Subject
    intervals: Mapping[str, Any]
    undecided: Undecided | None = None

    @cached_property
    def panels(self) -> list[Panel]:
        """The most unequal contexts, with what each group gets; empty without a table."""
        law = self.subject.law
        values = self.values
        blocks = [(a, b) for a, b in pairwise(law.starts.tolist()) if b - a > 1]
        spread = {block: self.spread(values[slice(*block)]) for block in blocks}
        worst = sorted(blocks, key=spread.__getitem__, reverse=True)[:PANELS]
        panels = []
        for start, end in worst:
            context = law.context_label(int(law.cell_context[start]))
            ends, units = self.ends("local", context), self.over_units(context)
            entries = [
                (
                    law.group_label(int(law.cell_group[i])),
                    values[i],
                    None if self.before is None else self.before[i],
                    self.amount([i]),
                )
                for i in range(start, end)
            ]
            panel = self._panel(named(context) or "All decisions", entries, ends, spread[start, end])
            if units:
                members = tuple(replace(member, over_units=Value(units[member.label])) for member in panel.members)
                panel = replace(panel, members=members)
            panels.append(panel)
        return panels

    def over_units(self, context: dict[str, str]) -> dict[str, Fraction]:
        """What the groups of a context get as mean over units, where the certificate has an interval of those."""
        comparison = self.comparisons.get("local")
        if comparison is None or comparison.of_units is None:
            return {}
        place = next((i for i, (x, _) in enumerate(comparison.labels) if x == context), None)
        if place is None:  # with fewer than two groups
            return {}
        groups = zip(comparison.labels[place][1], comparison.blocks[place], strict=True)
        return {named(label): comparison.cells[form[0][0]].mean for label, form in groups}

    @cached_property
    def overall(self) -> Panel | None:
        """Means of the groups over all contexts, where they are compared and there are several contexts."""
        if not self.subject.law.global_groups or (len(self.subject.law.contexts) == 1 and self.panels):
            return None
        means = self.means
        law = self.subject.law
        entries = [(law.group_label(a), value, None, self.amount(np.flatnonzero(law.cell_group == a).tolist())) for a, value in means]
        values = [value for _, value in means]
        return self._panel("All contexts together", entries, self.ends("global", None), self.spread(values))

    @property
    def signed(self) -> bool:
        """Whether utilities can be negative, so that groups are apart by differences and not by factors."""
        return self.subject.utility.signed

    def spread(self, values: Sequence[Fraction]) -> Any:
        """How far apart the groups of a panel are."""
        return max(values) - min(values) if self.signed else quotient(max(values), min(values))

    def _panel(self, title: str, entries: Sequence[tuple[dict[str, str], Fraction, Fraction | None, str]], ends: Any, spread: Any) -> Panel:
        ordered = sorted(entries, key=lambda entry: -entry[1])
        size = len(ordered)
        if size > MEMBERS:
            ordered = ordered[: MEMBERS // 2] + ordered[-MEMBERS // 2 :]
        members = []
        for label, value, before, weight in ordered:
            found = ends(label)
            sure = None if found is None else (Value(found[0], "down"), Value(found[1], "up"))
            members.append(Member(named(label), Value(value), sure, None if before is None else Value(before), weight))
        return Panel(title, tuple(members), size, Value(spread))

    @cached_property
    def values(self) -> list[Fraction]:
        """E(x,a)."""
        found = self.subject
        return [Fraction(*cell_expectation(found.law, found.utility, cell)) for cell in range(len(found.law.weights))]

    @cached_property
    def before(self) -> list[Fraction] | None:
        """E(x,a) without the filters."""
        deployment = self.subject.deployment
        if deployment is None or deployment.unfiltered is None:
            return None
        law, utility = deployment.unfiltered, replace(self.subject.utility, law=deployment.unfiltered)
        return [Fraction(*cell_expectation(law, utility, cell)) for cell in range(len(law.weights))]

    @cached_property
    def means(self) -> list[tuple[int, Fraction]]:
        """Of each group that is compared over all contexts its mean."""
        law = self.subject.law
        sums: dict[int, list[Fraction | int]] = {a: [0, 0] for a in law.global_groups}
        for cell, (a, mass) in enumerate(zip(law.cell_group.tolist(), law.cell_mass, strict=True)):
            if a in sums and mass:
                sums[a][0] += mass * self.values[cell]
                sums[a][1] += mass
        return [(a, Fraction(top) / bottom) for a, (top, bottom) in sums.items()]

    def amount(self, cells: Sequence[int]) -> str:
        """How much was recorded in some cells; units where one has several decisions, in a cell by itself."""
        law = self.subject.law
        if law.kind != "counts":
            return ""
        total = Fraction(sum(sum(law.row(cell)) for cell in cells), law.scale)
        by_unit = law.units is not None and law.units.repeated and len(cells) == 1
        return amount_text(Size(total, sum(n for n, _ in law.units.profiles[cells[0]]) if law.units is not None and by_unit else None))

    def ends(self, quantity: Literal["local", "global"], context: dict[str, str] | None) -> Any:
        """A function from a group to the ends of what it gets in the population, each by itself at the confidence of the certificate."""
        comparison, entry = self.comparisons.get(quantity), self.intervals.get(quantity)
        if comparison is None or entry is None or entry["method"] not in get_args(Method):  # of a stream, looked at more than once
            return lambda _label: None
        place_of = next((i for i, (x, _) in enumerate(comparison.labels) if x == context), None)
        if place_of is None:
            return lambda _label: None
        forms = {
            tuple(label.values()): form for label, form in zip(comparison.labels[place_of][1], comparison.blocks[place_of], strict=True)
        }
        confidence = Fraction(entry["confidence"])

        def ends(label: dict[str, str]) -> Ends | None:
            form = forms.get(tuple(label.values()))
            return None if form is None else form_ends(comparison, form, confidence, entry["method"])

        return ends

    @cached_property
    def comparisons(self) -> dict[str, Comparison]:
        """The draws behind each interval of the certificate."""
        face, table = self._compared(self.subject.utility), self.subject.utility
        if self.undecided is None:
            return face
        return with_meanings(lambda _, valued, __: self._compared(valued), face, self.undecided, _as_utility(table), table)

    def _compared(self, utility: UtilityTable) -> dict[str, Comparison]:
        """The draws behind each interval, with such a utility."""
        from fairaudit.inference.policy_comparisons import policy_comparison

        found: dict[str, Comparison] = {}
        for quantity, entry in self.intervals.items():
            limits = None if entry["limits"] is None else (entry["limits"][0], entry["limits"][1])
            deployment = self.subject.deployment
            if deployment is not None:
                law = self.subject.law
                cells = zip(law.cell_context.tolist(), law.cell_group.tolist(), law.cell_mass, strict=True)
                masses: dict[tuple[Label, Label], Any] | None = {(law.contexts[x], law.groups[a]): mass for x, a, mass in cells}
                found[quantity] = policy_comparison(
                    deployment.policy,
                    _as_utility(utility),
                    deployment.group_filter,
                    deployment.context_filter,
                    masses,
                    local=quantity == "local",
                    limits=limits,
                )
            elif quantity == "local":
                found[quantity] = local_comparison(self.subject.law, utility, limits)
            elif self.subject.law.units is None:
                found[quantity] = global_comparison(self.subject.law, utility, limits=limits)
        return found

    @cached_property
    def matrices(self) -> list[Matrix]:
        """Pairwise ratios within the most unequal contexts, then overall; none of utilities that can be negative."""
        if self.signed:
            return []
        listed = [self._matrix(panel) for panel in self.panels]
        return [*listed, self._matrix(self.overall)] if self.overall else listed

    def _matrix(self, panel: Panel) -> Matrix:
        members = panel.members
        ratios = tuple(
            tuple(None if i == j else Value(quotient(a.value.value, b.value.value)) for j, b in enumerate(members))
            for i, a in enumerate(members)
        )
        names = tuple(member.label for member in members)
        return Matrix(panel.title, names, names, ratios, panel.size)


def _as_utility(utility: UtilityTable) -> Utility:
    """The utility that a table lays out."""
    law = utility.law
    if utility.by_decision:
        return Utility({u: Fraction(v, utility.scale) for u, v in zip(law.decisions, utility.values.tolist(), strict=True)})
    entries = {
        (u, law.contexts[x], law.groups[a]): (v, utility.scale)
        for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))
        for u, v in zip(law.decisions, utility.row(cell), strict=True)
    }
    return Utility({}, entries)
