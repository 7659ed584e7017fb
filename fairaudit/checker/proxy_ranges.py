"""Groups that nobody recorded: what their means can be among cells of rows, of which each group has a share.

Whoever the members are, a union of groups takes a slice of each cell.  Its mean is least if all slices are the worst ones,
and greatest if they are the best ones; where a share may vary, more is taken of whatever is worse (or better) than the mean.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from math import lcm

from .rationals import INFINITY, ONE, Rational, as_pair, at_most, bits_of, fraction_sum
from .text import Finding, compared, finding_of, shown
from .work import keep, spend


@dataclass(frozen=True)
class Cell:
    """The rows of a cell in increasing order of their utility, and how many belong to each group, at least and at most.

    Rows are counted in parts, and utilities in units, of which all cells of a scope have the same.
    """

    gains: tuple[tuple[int, int], ...]
    rows: int
    low: tuple[int, ...]
    high: tuple[int, ...]

    @cached_property
    def ends(self) -> tuple[int, int]:
        """Add up the least rows of all groups, and the greatest."""
        return sum(self.low), sum(self.high)

    def limits(self, union: Collection[int]) -> tuple[int, int]:
        """Count the rows of a union of groups, at least and at most: all groups together have all rows."""
        least, most = sum(self.low[a] for a in union), sum(self.high[a] for a in union)
        low, high = self.ends
        return max(least, self.rows - high + most), min(most, self.rows - low + least)

    def first(self, count: int, backwards: bool = False) -> int:
        """Add up the utilities of so many rows from the worst on, or from the best on."""
        total = 0
        for gain, size in reversed(self.gains) if backwards else self.gains:
            taken = min(size, count)
            total += gain * taken
            count -= taken
        return total

    def beyond(self, value: Fraction, above: bool, ties: bool) -> int:
        """Count the rows whose utility is above a value, or below it; with ties those that have it, too."""
        return sum(size for gain, size in self.gains if (gain > value if above else gain < value) or (ties and gain == value))


@dataclass(frozen=True)
class Scope:
    """Cells whose groups are compared; the groups are those of which there are rows."""

    cells: tuple[Cell, ...]
    parts: int  # of a row
    units: int  # of a utility
    groups: tuple[int, ...]  # as the certificate numbers them

    @property
    def known(self) -> bool:
        """Whether it is known which share each group has."""
        return all(cell.low == cell.high for cell in self.cells)

    def spend_on_pass(self, bits: int) -> None:
        """Count the operations of looking once at each cell."""
        rows = max(cell.rows.bit_length() for cell in self.cells)
        spend(sum(4 * len(cell.gains) + len(cell.low) for cell in self.cells), rows, bits)

    def mean(self, union: Collection[int], greatest: bool) -> Fraction:
        """Find the least or the greatest mean of a union: what is beyond the mean so far is taken, until the mean stays."""
        limits = [cell.limits(union) for cell in self.cells]
        value = None
        fixed = all(low == high for low, high in limits)
        while True:
            self.spend_on_pass(64 if value is None else bits_of(value))
            taken = [
                low if value is None else min(max(cell.beyond(value, greatest, ties=False), low), high)
                for cell, (low, high) in zip(self.cells, limits, strict=True)
            ]
            found = Fraction(sum(cell.first(count, greatest) for cell, count in zip(self.cells, taken, strict=True)), sum(taken))
            if fixed or found == value:
                return found / self.units
            value = found

    def has_both(self, higher: int, greatest: Fraction, lower: int, least: Fraction) -> bool:
        """Say whether a group can have its greatest mean while another has its least, for some possible shares."""
        if self.known:
            return True
        self.spend_on_pass(bits_of(greatest, least))
        wanted = (((higher,), greatest * self.units, True), ((lower,), least * self.units, False))
        for cell in self.cells:
            ends = [0, 0]
            for union, value, above in wanted:
                low, high = cell.limits(union)
                for i, ties in enumerate((False, True)):
                    ends[i] += min(max(cell.beyond(value, above, ties), low), high)
            low, high = cell.limits((higher, lower))
            if ends[1] < low or ends[0] > high:
                return False
        return True


@dataclass(frozen=True)
class Extreme:
    """A stated end of the greatest ratio of two groups: two unions of groups prove it."""

    ratio: Rational
    higher: tuple[int, ...]
    lower: tuple[int, ...]
    sharp: bool


@dataclass(frozen=True)
class Completion:
    """A stated assignment of rows to groups: the groups take shares of each cell in some orders, from the worst row on."""

    ratio: Rational
    mixture: tuple[tuple[Fraction, tuple[int, ...]], ...]
    rows: tuple[tuple[Fraction, ...], ...] | None


@dataclass(frozen=True)
class Pair:
    """The stated range of the ratio of two groups, and whether its ends occur."""

    groups: tuple[int, int]
    ratio: tuple[Rational, Rational]
    sharp: tuple[bool, bool]


@dataclass(frozen=True)
class Range:
    """What is stated of the groups of a scope."""

    groups: tuple[int, ...]
    means: tuple[tuple[Fraction, Fraction], ...]
    pairs: tuple[Pair, ...]
    least: Extreme
    greatest: Extreme
    low: Completion
    high: Completion


def scope_of(cells: Sequence[tuple[Sequence[tuple[Fraction, int]], Sequence[Fraction], Sequence[Fraction]]]) -> Scope:
    """Put cells together: utilities with their counts of rows, and the least and the greatest share of each group."""
    parts = _common_multiple(share.denominator for _, low, high in cells for share in (*low, *high))
    units = _common_multiple(gain.denominator for gains, _, _ in cells for gain, count in gains if count)
    groups = tuple(a for a in range(len(cells[0][1])) if any(high[a] for _, _, high in cells))
    keep(sum(len(gains) + 2 * len(groups) for gains, _, _ in cells), parts.bit_length())
    found = []
    for gains, low, high in cells:
        rows = parts * sum(count for _, count in gains)
        spend(2 * len(groups) + len(gains), rows.bit_length(), parts.bit_length())
        least, most = ([rows // share.denominator * share.numerator for share in (ends[a] for a in groups)] for ends in (low, high))
        listed = sorted((gain.numerator * (units // gain.denominator), parts * count) for gain, count in gains if count)
        found.append(Cell(tuple(listed), rows, tuple(least), tuple(most)))
    tight = (
        Cell(cell.gains, cell.rows, *zip(*(cell.limits((a,)) for a in range(len(groups))), strict=True)) if groups else cell
        for cell in found
    )
    return Scope(tuple(tight), parts, units, groups)


def _common_multiple(denominators: Iterable[int]) -> int:
    found = 1
    for denominator in denominators:
        if found % denominator:
            spend(4, found.bit_length(), denominator.bit_length())
            found = lcm(found, denominator)
    return found


def ratio_of(above: Fraction, below: Fraction) -> Rational:
    """Divide means: 0/0 is 1, and anything else over 0 is infinite."""
    return as_pair(above / below) if below else INFINITY if above else ONE


def check_range(named: str, stated: Range, scope: Scope) -> Iterator[Finding]:
    """Check what is stated of the groups of a scope; these have been compared already."""
    at = {group: i for i, group in enumerate(scope.groups)}
    means = []
    for group, ends in zip(stated.groups, stated.means, strict=True):
        means.append((scope.mean((at[group],), greatest=False), scope.mean((at[group],), greatest=True)))
        yield compared(f"{named}: the mean of group {group}", _pairs(ends), _pairs(means[-1]))
    for pair, (a, b) in zip(stated.pairs, combinations(range(len(means)), 2), strict=True):
        spend(4, bits_of(*means[a]), bits_of(*means[b]))
        actual = ratio_of(means[a][0], means[b][1]), ratio_of(means[a][1], means[b][0])
        yield compared(f"{named}: the ratio of groups {pair.groups[0]} and {pair.groups[1]}", list(pair.ratio), list(actual))
        sharp = [scope.has_both(b, means[b][1], a, means[a][0]), scope.has_both(a, means[a][1], b, means[b][0])]
        yield compared(f"{named}: whether these ends occur", list(pair.sharp), sharp)
    yield from _check_ends(named, stated, scope, at, means)
    for name, completion, extreme in (("low", stated.low, stated.least), ("high", stated.high, stated.greatest)):
        yield _check_completion(f"{named}.{name}", completion, scope, at)
        yield compared(f"{named}: whether the ratio {shown(extreme.ratio)} occurs", extreme.sharp, completion.ratio == extreme.ratio)


def _pairs(ends: Iterable[Fraction]) -> list[Rational]:
    return [as_pair(end) for end in ends]


def _check_ends(
    named: str, stated: Range, scope: Scope, at: dict[int, int], means: Sequence[tuple[Fraction, Fraction]]
) -> Iterator[Finding]:
    """Check the ends of the greatest ratio: the means of two unions are means of the means of groups, and so is their ratio."""
    least, most = stated.least, stated.greatest
    forced = scope.mean([at[a] for a in least.higher], greatest=False)
    capped = scope.mean([at[a] for a in least.lower], greatest=True)
    proved = ratio_of(forced, capped)
    yield compared(f"{named}: the lower end of the greatest ratio", least.ratio, ONE if at_most(proved, ONE) else proved)
    if len(most.higher) != 1 or len(most.lower) != 1 or most.higher == most.lower:
        yield finding_of(f"{named}: the upper end of the greatest ratio is {shown(most.ratio)}", False, "two groups have to be named")
        return
    named_ratio = ratio_of(means[at[most.higher[0]]][1], means[at[most.lower[0]]][0])
    spend(2 * len(means) ** 2, *[bits_of(*(end for ends in means for end in ends))] * 2)
    all_ratios = [ratio_of(above[1], below[0]) for i, above in enumerate(means) for j, below in enumerate(means) if i != j]
    worst = next((ratio for ratio in all_ratios if not at_most(ratio, named_ratio)), named_ratio)
    yield compared(f"{named}: the upper end of the greatest ratio", most.ratio, worst)


def _check_completion(named: str, stated: Completion, scope: Scope, at: dict[int, int]) -> Finding:
    """Check that an assignment is possible, and that the greatest ratio of its groups is the stated one."""
    statement = f"{named} has the ratio {shown(stated.ratio)}"
    if fraction_sum(share for share, _ in stated.mixture) != 1:
        return finding_of(statement, False, "the shares of the mixture do not sum to 1")
    times, counts = _counts(stated, scope)
    for i, (cell, own) in enumerate(zip(scope.cells, counts, strict=True)):
        inside = all(low * times <= count <= high * times for low, count, high in zip(cell.low, own, cell.high, strict=True))
        if not inside or sum(own) != cell.rows * times:
            return finding_of(statement, False, f"the rows of cell {i} are not among those that are possible")
    sums = [Fraction(0) for _ in scope.groups]
    for share, order in stated.mixture:
        scope.spend_on_pass(bits_of(share) + times.bit_length())
        ordered = [at[group] for group in order]
        totals = [0] * len(sums)
        for cell, own in zip(scope.cells, counts, strict=True):
            for a, total in _slices(cell, own, ordered, times):
                totals[a] += total
        bits = bits_of(share, *sums)
        spend(4 * len(sums), bits, bits)
        sums = [one + share * total for one, total in zip(sums, totals, strict=True)]
    means = [total / sum(own[a] for own in counts) for a, total in enumerate(sums)]
    actual = ratio_of(max(means), min(means))
    return finding_of(statement, stated.ratio == actual, "" if stated.ratio == actual else f"it has {shown(actual)}")


def _counts(stated: Completion, scope: Scope) -> tuple[int, Sequence[Sequence[int]]]:
    """Count the rows of each cell and group in parts, and say how many of these are one part of the scope."""
    if stated.rows is None:
        return 1, [cell.low for cell in scope.cells]
    parts = lcm(scope.parts, _common_multiple(count.denominator for own in stated.rows for count in own))
    spend(2 * len(stated.rows) * len(scope.groups), parts.bit_length(), scope.parts.bit_length())
    keep(len(stated.rows) * len(scope.groups), parts.bit_length())
    return parts // scope.parts, [[count.numerator * (parts // count.denominator) for count in own] for own in stated.rows]


def _slices(cell: Cell, counts: Sequence[int], order: Sequence[int], times: int) -> Iterator[tuple[int, int]]:
    """Give each group in turn its rows from the worst on, and add up their utilities."""
    left = [(gain, size * times) for gain, size in reversed(cell.gains)]
    for a in order:
        wanted, total = counts[a], 0
        while wanted:
            gain, size = left.pop()
            taken = min(size, wanted)
            total += gain * taken
            wanted -= taken
            if taken < size:
                left.append((gain, size - taken))
        yield a, total
