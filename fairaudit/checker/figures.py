"""The figures of a table, while its cells pass by: the greatest ratios, differences and distances of groups, with their witnesses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from .header import Cell, Header
from .laws import Law, gains_of, mean_of, widest_distance
from .rationals import ZERO, Rational, RunningTotal, at_most, extreme_positions, reduced, widest_gap, widest_ratio

EXPECTED_DIFFERENCES = ("local_difference", "global_difference")  # of expectations, which may be of any sign; stated both, or neither


@dataclass(frozen=True)
class Maximum:
    """The value of a metric and its witness; ``place`` is the context (if any), the higher and the lower, as indices."""

    value: Rational
    witness: dict[str, object]
    place: tuple[int | None, int, int]


@dataclass(frozen=True)
class Setting:
    """Where groups are compared; local figures have a context, suprema a decision."""

    groups: Sequence[int]
    context: int | None = None
    decision: int | None = None

    def witness(self, header: Header, higher: int, lower: int) -> dict[str, object]:
        """Name the place and the two groups that stand at the given positions."""
        names: dict[str, object] = {}
        columns = header.subject.columns
        if self.context is not None:
            names["context"] = dict(zip(columns.context, header.contexts[self.context], strict=True))
        if self.decision is not None:
            names["decision"] = header.decisions[self.decision]
        names["higher"] = dict(zip(columns.group, header.groups[self.groups[higher]], strict=True))
        names["lower"] = dict(zip(columns.group, header.groups[self.groups[lower]], strict=True))
        return names


T = TypeVar("T")

BITS = 32  # to which numbers are rounded before they are compared exactly
LONG = 1 << 200  # a denominator by which that would take long


class Greatest(Generic[T]):
    """The greatest value of a metric over the settings so far; the first one that attains it is kept."""

    def __init__(self, widest: Callable[[Sequence[T]], tuple[Rational, int, int]], details: Callable[[T, T], dict[str, object]]) -> None:
        self.widest, self.details = widest, details
        self.value: Rational = ZERO  # of nothing; no metric is less
        self.found: tuple[Setting, int, int, T, T] | None = None

    def offer(self, values: Sequence[T], groups: Sequence[int], context: int | None, decision: int | None = None) -> None:
        """Compare the values of some groups."""
        value, higher, lower = self.widest(values)
        if self.found is None or not at_most(value, self.value):
            self.value = value
            self.found = Setting(groups, context, decision), higher, lower, values[higher], values[lower]

    def keeps_ratio(self, rounded: Sequence[int]) -> bool:
        """Whether no ratio of numbers exceeds the greatest so far; they are rounded down to multiples of 2^-BITS."""
        if self.found is None or not rounded:
            return False
        low = min(rounded)
        return low >= 0 and (max(rounded) + 1) * self.value[1] <= low * self.value[0]

    def keeps_gap(self, rounded: Sequence[int]) -> bool:
        """The same of their differences."""
        if self.found is None or not rounded:
            return False
        return (max(rounded) + 1 - min(rounded)) * self.value[1] <= self.value[0] << BITS

    def keeps_distance(self, rounded: Sequence[Sequence[int]]) -> bool:
        """The same of the distances of laws, each of which is at most half the sum of how far the two are from any third one."""
        if self.found is None or not rounded:
            return False
        middle = [sum(column) // len(rounded) for column in zip(*rounded, strict=True)]
        far: list[int] = sorted(sum([abs(a - b) for a, b in zip(own, middle, strict=True)]) for own in rounded)
        return (far[-1] + far[-2] + 2 * len(middle)) * self.value[1] <= 2 * self.value[0] << BITS

    def maximum(self, header: Header) -> Maximum | None:
        """The value and its witness, if anything was compared."""
        if self.found is None:
            return None
        setting, higher, lower, one, other = self.found
        witness = setting.witness(header, higher, lower) | self.details(one, other)
        return Maximum(reduced(*self.value), witness, (setting.context, setting.groups[higher], setting.groups[lower]))


def _rounded(values: Sequence[Rational]) -> list[int]:
    """Round down to multiples of 2^-BITS; nothing if that would not be quick."""
    if any(d > LONG for _, d in values):
        return []
    return [(n << BITS) // d for n, d in values]


def _rounded_laws(laws: Sequence[Law]) -> list[list[int]]:
    """The probabilities of the decisions, likewise."""
    if any(total > LONG for _, total in laws):
        return []
    return [[(weight << BITS) // total for weight in weights] for weights, total in laws]


class ComparedGroups:
    """The metrics that compare groups, be it in each context or once; the difference of expectations only if it is asked for."""

    def __init__(self, header: Header, expectations_only: bool, differences: bool) -> None:
        def raised(left: Law, right: Law) -> dict[str, object]:
            (p, m), (q, n) = left, right
            return {"decisions": [u for u, a, b in zip(header.decisions, p, q, strict=True) if a * n > b * m]}

        def both(name: str) -> Callable[[Rational, Rational], dict[str, object]]:
            return lambda left, right: {name: [reduced(*left), reduced(*right)]}

        self.header, self.expectations_only = header, expectations_only
        self.apart = Greatest[Rational](widest_gap, both("expectations")) if differences else None
        self.means = Greatest[Rational](widest_ratio, both("expectations"))
        self.laws = Greatest[Law](widest_distance, raised)
        self.single = Greatest[Rational](widest_ratio, both("probabilities"))

    def add(self, groups: Sequence[int], laws: Sequence[Law], means: Sequence[Rational], context: int | None = None) -> None:
        """Compare at least two groups, unless rounded numbers show that nothing here exceeds what was found."""
        rounded = _rounded(means)
        if not self.means.keeps_ratio(rounded):
            self.means.offer(means, groups, context)
        if self.apart is not None and not self.apart.keeps_gap(rounded):
            self.apart.offer(means, groups, context)
        if self.expectations_only:
            return
        shares = _rounded_laws(laws)
        if not self.laws.keeps_distance(shares):
            self.laws.offer(laws, groups, context)
        columns = [*zip(*shares, strict=True)] or [()] * len(self.header.decisions)
        for u, column in enumerate(columns):
            if not self.single.keeps_ratio(column):
                self.single.offer([(weights[u], total) for weights, total in laws], groups, context, u)

    def maxima(self, ratio: str, distance: str, supremum: str) -> dict[str, Maximum | None]:
        """The metrics by these names."""
        metrics = {ratio: self.means.maximum(self.header)}
        if self.apart is not None:
            metrics[f"{ratio}_difference"] = self.apart.maximum(self.header)
        if not self.expectations_only:
            metrics |= {distance: self.laws.maximum(self.header), supremum: self.single.maximum(self.header)}
        return metrics


class Watcher(Protocol):
    """What follows the cells of a table besides."""

    def begin(self, header: Header) -> None:
        """Read the first line."""

    def take(self, cells: Sequence[Cell]) -> None:
        """Take in the cells of a context."""


class Figures:
    """What the cells of a table add up to, while they pass by in their order.

    Only the cells of one context are held at a time.  What stays grows with the labels of the header: a number for
    each context, and a vector for each group.  Besides, ``rarer`` holds for each context that has cells of some groups
    but not of all either those groups or the others, whichever are fewer: no more than what ``not_compared`` has to name.
    """

    def __init__(
        self, header: Header, expectations_only: bool = False, differences: bool = False, watchers: Sequence[Watcher] = ()
    ) -> None:
        n = len(header.groups)
        self.watchers = watchers
        for watcher in watchers:
            watcher.begin(header)
        self.header, self.cells = header, 0
        self.local = ComparedGroups(header, expectations_only, differences)
        self.sizes = [0] * len(header.contexts)  # the number of cells
        self.rarer: dict[int, tuple[int, ...]] = {}
        self.with_cells = [False] * n
        self.laws = [RunningTotal() for _ in range(n)]  # the sum of M(x,a) P(.|x,a) over the cells of positive mass, by group
        self.gains = None if header.utility is None else gains_of(header.utility)
        self.means = [RunningTotal() for _ in range(n)] if self.gains is None else []  # likewise, of M(x,a) E(x,a)
        self.reference: list[Rational] | None = None  # the masses of the first complete context in which one is positive
        self.proportional = True  # the masses of complete contexts, to the reference
        self.tau: Rational | None = None
        self.ends: tuple[Rational, Rational] | None = None  # of the utilities that stand with the cells
        self.spread = ZERO
        self.held: list[Cell] = []

    def add(self, cell: Cell) -> None:
        """Take in the next cell."""
        if self.held and self.held[0].context != cell.context:
            self._take()
        self.held.append(cell)

    def of_all(self) -> Figures:
        """Take in what is held: no cell follows."""
        if self.held:
            self._take()
        return self

    def _take(self) -> None:
        """Take in the cells of a context, all of which are held."""
        cells, self.held = self.held, []
        context, groups = cells[0].context, [cell.group for cell in cells]
        self.cells += len(cells)
        self.sizes[context] = len(cells)
        for watcher in self.watchers:
            watcher.take(cells)
        self._add_up(cells)
        if self.gains is None:
            self._take_utilities(cells)
        if len(cells) == len(self.header.groups):
            self._take_masses([cell.mass for cell in cells])
        elif 2 * len(cells) <= len(self.header.groups):
            self.rarer[context] = tuple(groups)
        else:
            self.rarer[context] = _others(groups, len(self.header.groups))
        if len(cells) > 1:
            means = [cell.expectation for cell in cells]
            rounded = _rounded(means)
            if self.tau is None or not rounded or min(rounded) * self.tau[1] < self.tau[0] << BITS:
                least = means[extreme_positions(means)[1]]
                if self.tau is None or not at_most(self.tau, least):
                    self.tau = least
            self.local.add(groups, [cell.law for cell in cells], means, context)

    def _add_up(self, cells: Sequence[Cell]) -> None:
        for _, group, (weights, total), mass, expectation, _ in cells:
            self.with_cells[group] = True
            if mass[0]:
                times, rest = divmod(mass[0], total) if mass[1] == 1 else (0, 1)
                n, d = reduced(mass[0], mass[1] * total) if rest else (times, 1)
                self.laws[group].add([n * weight for weight in weights], d)
                if self.gains is None:
                    self.means[group].add([mass[0] * expectation[0]], mass[1] * expectation[1])

    def _take_utilities(self, cells: Sequence[Cell]) -> None:
        """Compare the entries of utilities that stand with the cells: in all, and of each decision in this context."""
        utilities = {cell.utility for cell in cells}
        given = [*{g for utility in utilities for g in utility if g is not None}, *(self.ends or ())]
        top, low = extreme_positions(given)
        self.ends = given[top], given[low]
        if len(utilities) == 1:
            return
        for column in zip(*utilities, strict=True):
            entries = [g for g in set(column) if g is not None]
            if len(entries) > 1:
                i, j = extreme_positions(entries)
                (n, d), (p, q) = entries[i], entries[j]
                if not at_most((n * q - p * d, d * q), self.spread):
                    self.spread = reduced(n * q - p * d, d * q)

    def _take_masses(self, masses: list[Rational]) -> None:
        """Compare the masses of a complete context with the reference.

        With r the reference and r_p > 0, the masses m are a multiple of r exactly if m_a r_p = m_p r_a for all a.
        """
        if self.reference is None:
            if any(n for n, _ in masses):
                self.reference = masses
        elif self.proportional:
            p = next(i for i, (n, _) in enumerate(self.reference) if n)
            (n, d), (k, e) = self.reference[p], masses[p]
            above, below = n * e, k * d  # r_p and m_p over one denominator
            self.proportional = all(m[0] * above * r[1] == r[0] * below * m[1] for m, r in zip(masses, self.reference, strict=True))

    def complete(self) -> bool:
        """Say whether every group has a cell in every context (no cell occurs twice)."""
        return self.cells == len(self.header.contexts) * len(self.header.groups)

    def independent(self) -> bool:
        """Decide whether context and group are independent: M(x,a) M = M(x,.) M(.,a) for all x and a.

        Let there be a cell for each x and a.  If all masses are 0, this holds, and there is no reference.  Else let
        r_a = M(z,a) be the reference, R > 0 the sum of r, and M > 0.  If it holds, then M(.,a) = r_a M / R because of z, and
        M(x,a) = (M(x,.) / R) r_a: the masses of each context are a multiple of r.  If they are, M(x,a) = c_x r_a with
        c_x = 0 where all masses are 0 (as in the contexts before z), and with C the sum of c both sides are c_x r_a C R.
        """
        return self.complete() and self.proportional

    def missing(self, context: int) -> Sequence[int]:
        """List the groups without a cell in a context."""
        size, n = self.sizes[context], len(self.header.groups)
        if size in (0, n):
            return range(0 if size else n)
        return _others(self.rarer[context], n) if 2 * size <= n else self.rarer[context]

    def populated(self) -> list[int]:
        """List the groups of positive mass."""
        return [a for a, law in enumerate(self.laws) if law.parts]

    def masses(self) -> list[Rational]:
        """List the masses of the groups of positive mass."""
        sums = (self.laws[a].value() for a in self.populated())
        return [reduced(sum(numerators), denominator) for numerators, denominator in sums]

    def of_group(self, group: int) -> tuple[Law, Rational]:
        """Compute P(.|a) and the mean of E(.,a) of a group of positive mass."""
        summed, denominator = self.laws[group].value()
        total = sum(summed)  # the mass of the group is total / denominator
        law = tuple(summed), total
        if self.gains is not None:  # g(u): the mean is that of the law
            return law, mean_of(*law, self.gains)
        (n,), d = self.means[group].value()
        return law, reduced(n * denominator, d * total)


def _others(numbers: Iterable[int], below: int) -> tuple[int, ...]:
    known = set(numbers)
    return tuple(i for i in range(below) if i not in known)
