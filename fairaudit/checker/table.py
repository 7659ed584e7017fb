"""The decision table with its figures, the policy behind its filters, and the metrics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from .figures import ComparedGroups, Figures, Maximum
from .filters import Filter
from .header import Cell, Header, UnknownRow
from .laws import Law
from .rates import GivenTruth
from .rationals import ZERO, Rational, extreme_positions
from .text import shown

RATIOS = ("local", "global", "local_supremum", "global_supremum")


@dataclass(frozen=True)
class Table:
    """A decision table, the number of its rows, the digest of its canonical text, and the figures of its cells.

    The cells themselves are there if they were kept.  The table of a policy is that of the law which the policy and
    its filters induce.
    """

    header: Header
    kept: tuple[Cell, ...] | None
    rows: int
    digest: str
    figures: Figures
    policy: Policy | None = None
    given: GivenTruth | None = None
    unknown: tuple[UnknownRow, ...] = ()  # decisions of unknown group, which no figure is about

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells, which have to be there."""
        if self.kept is None:
            raise AssertionError
        return self.kept

    def by_context(self) -> list[list[Cell]]:
        """List the cells of each context."""
        lists: list[list[Cell]] = [[] for _ in self.header.contexts]
        for cell in self.cells:
            lists[cell.context].append(cell)
        return lists

    def by_group(self) -> list[list[Cell]]:
        """List the cells of each group."""
        lists: list[list[Cell]] = [[] for _ in self.header.groups]
        for cell in self.cells:
            lists[cell.group].append(cell)
        return lists


@dataclass(frozen=True)
class Policy:
    """What claims about a policy need to know of it besides the law that it induces with its filters.

    ``rows`` are the laws by released context and released group, ``by_context`` those by true context and released
    group, both for the released values that are reachable only.  ``draws`` tells how many decisions each of the rows
    was estimated from; it is empty when the policy is not a sample.
    """

    group: Filter
    context: Filter | None
    rows: list[list[Law]]
    by_context: list[list[Law]]
    unfiltered: Table | None
    draws: list[list[int]]
    header: Header  # with the labels of the policy's own rows
    drawn: int  # all draws together, also for what is never released
    releases: int = 1  # of a group, drawn afresh, that one memory sees


def _lacks_population(table: Table) -> bool:
    return table.header.subject.population == "equal" and not table.figures.complete()


def globally_compared(table: Table) -> list[int]:
    """List the groups whose means over the contexts are compared: none if these cannot be, or if there are fewer than two."""
    groups = [] if _lacks_population(table) else table.figures.populated()
    return groups if len(groups) > 1 else []


def measure(table: Table) -> dict[str, Maximum | None]:
    """Compute the metrics of a table, or if only these were asked for those that compare expectations.

    Of utilities below 0 there are no ratios, nor what bounds them: they depend on the origin.
    """
    local = table.figures.local
    overall = ComparedGroups(table.header, local.expectations_only, local.apart is not None)
    groups = globally_compared(table)
    if groups:
        laws, means = zip(*map(table.figures.of_group, groups), strict=True)
        overall.add(groups, laws, means)
    metrics = local.maxima("local", "equalized_odds", "local_supremum")
    metrics |= overall.maxima("global", "demographic_parity", "global_supremum")
    return metrics | dict.fromkeys(RATIOS) if is_signed(table) else metrics


def counts_are_whole(table: Table) -> bool:
    """Whether each count of each cell is whole, which their sum can be without them."""
    return all(cell.mass[1] == 1 and cell.mass[0] % cell.law[1] == 0 for cell in table.cells)  # laws are in lowest terms


def is_signed(table: Table) -> bool:
    """Whether some utility is below 0."""
    ends = table.header.utility or table.figures.ends or ()
    return any(n < 0 for n, _ in ends)


def constants(table: Table) -> dict[str, Rational | bool | None]:
    """Compute the constants of the utility g."""
    figures = table.figures
    given = table.header.utility or figures.ends or ()
    top, low = extreme_positions(given)
    return {
        "gamma": given[top],
        "m": given[low],
        "tau": figures.tau,
        "lipschitz": figures.spread,
        "depends_on_group": figures.spread != ZERO,
    }


def not_compared(table: Table) -> Iterator[dict[str, object]]:
    """List what the metrics leave out, and why."""
    header, figures = table.header, table.figures
    for x, label in enumerate(header.contexts):
        if missing := [list(header.groups[a]) for a in figures.missing(x)]:
            yield {"context": list(label), "groups": missing, "reason": "no decisions recorded"}
    for label, size in zip(header.contexts, figures.sizes, strict=True):
        if size < 2:
            yield {"context": list(label), "reason": "fewer than two groups"}
    populated = set(figures.populated())
    empty = [list(group) for a, group in enumerate(header.groups) if figures.with_cells[a] and a not in populated]
    if empty:
        yield {"groups": empty, "reason": "no population"}
    if _lacks_population(table):
        yield {"quantity": "global", "reason": "a group is missing in a context and no population was given"}
    elif len(populated) < 2:
        yield {"quantity": "global", "reason": "fewer than two groups"}
    if table.given is not None:
        yield from table.given.not_compared()


def place_of(table: Table, cell: Cell) -> str:
    """Say in words where a cell is."""
    return f"in context {shown(list(table.header.contexts[cell.context]))}, group {shown(list(table.header.groups[cell.group]))}"
