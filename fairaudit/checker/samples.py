"""The samples in a table, and the expected utilities that are compared as weighted sums of their means."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, product
from math import lcm
from operator import mul

from .header import Cell
from .intervals import ContrastEvidence, Interval, UnitEvidence, Unproven
from .laws import gains_of
from .rationals import Affine, Rational, affine_sum, sum_of, weighted_sum
from .table import Policy, Table, constants, globally_compared, place_of
from .tails import Sample
from .work import keep, spend


@dataclass(frozen=True)
class Comparison:
    """Samples, and by block the forms that are compared: expected utilities as weighted sums of the means of the samples."""

    samples: list[Sample]
    blocks: list[list[Affine]]
    shared: bool  # whether a draw occurs in several samples
    tallies: list[Tally]  # how often each value was drawn, by sample; only where the evidence is about that


Tally = dict[Fraction, int]
Utility = Sequence[Rational | None]  # of the decisions
Part = tuple[Sequence[int], Utility]  # how often they were made, and their utilities
Units = Sequence[tuple[int, Sequence[int]]]  # how many draws had which counts
Draws = Sequence[tuple[int, Fraction]]  # how many draws had which value


class Range:
    """The range of a utility and what it is counted in: a draw is so many times 1/unit.

    Draws are of two values only if the utility says so of whatever could have been drawn, which a declared range does not.
    """

    def __init__(self, utilities: Iterable[Utility], limits: tuple[Fraction, Fraction], declared: bool) -> None:
        listed = [(utility, gains_of(utility)) for utility in utilities]
        self.unit = lcm(*(limit.denominator for limit in limits), *(denominator for _, (_, denominator) in listed))
        self.low, self.high = (limit.numerator * (self.unit // limit.denominator) for limit in limits)
        self.gains = {utility: [gain * (self.unit // denominator) for gain in gains] for utility, (gains, denominator) in listed}
        self.squares = {utility: [gain * gain for gain in gains] for utility, gains in self.gains.items()}
        values = {gain for gains in self.gains.values() for gain in gains}
        self.binary = not declared and not any(None in utility for utility in self.gains) and values <= {self.low, self.high}

    def sample(self, counts: Sequence[int], utility: Utility) -> Sample:
        """Count what was drawn in a cell."""
        n, gains = sum(counts), self.gains[utility]
        spend(8 * len(counts), n.bit_length(), 2 * self.unit.bit_length())
        total = sum(map(mul, counts, gains))
        return Sample(n, total, sum(map(mul, counts, self.squares[utility])), self.low, self.high, self.unit, self.binary)

    def pooled(self, parts: Iterable[Part]) -> Sample:
        """Count what was drawn in several cells."""
        samples = [self.sample(counts, utility) for counts, utility in parts]
        n, total, squares = (sum(sample[i] for sample in samples) for i in range(3))
        return Sample(n, total, squares, self.low, self.high, self.unit, self.binary)

    def draws(self, parts: Iterable[Part]) -> Draws:
        """List how many draws had which value."""
        return [
            (count, Fraction(gain, self.unit))
            for counts, utility in parts
            for count, gain in zip(counts, self.gains[utility], strict=True)
            if count
        ]

    def means(self, utility: Utility, units: Units) -> Draws:
        """List how many units had which mean over their rows."""
        spend(40 * len(units) * len(utility))
        return [(n, Fraction(sum(map(mul, counts, self.gains[utility])), sum(counts) * self.unit)) for n, counts in units]

    def of_units(self, utility: Utility, units: Units) -> Sample:
        """Count draws that are the means over the rows of a unit: of other values than the two of a utility."""
        draws = self.means(utility, units)
        total, squares = (weighted_sum((n, value**power) for n, value in draws) for power in (1, 2))
        unit = lcm(self.unit, total.denominator, squares.denominator)
        low, high = (end * (unit // self.unit) for end in (self.low, self.high))
        return Sample(sum(n for n, _ in draws), int(total * unit), int(squares * unit**2), low, high, unit, False)


def _tally(draws: Draws) -> Tally:
    found: Tally = {}
    for n, value in draws:
        found[value] = found.get(value, 0) + n
    keep(2 * len(found))
    return found


def compared_cells(quantity: str, table: Table) -> list[list[list[Cell]]]:
    """List, by block, the cells behind each mean that is compared: a single one, or all of a group."""
    if quantity == "local":
        return [[[cell] for cell in cells] for cells in table.by_context() if len(cells) > 1]
    by_group = table.by_group()
    return [[by_group[a] for a in groups] for groups in [globally_compared(table)] if groups]


def counts_of(cell: Cell) -> list[int]:
    """List how often each decision was drawn in a cell."""
    (weights, total), (n, d) = cell.law, cell.mass
    if n % (d * total):
        raise Unproven("the counts are not integers")
    return [weight * (n // (d * total)) for weight in weights]


def whole_counts(cell: Cell, table: Table) -> list[int]:
    """The same of a cell that is named where they are not whole."""
    try:
        return counts_of(cell)
    except Unproven as error:
        raise Unproven(f"{error} {place_of(table, cell)}") from None


def common_range(interval: Interval, utility: Utility) -> Range:
    """The range of a utility of the decisions alone."""
    values = [Fraction(*g) for g in utility if g is not None]
    limits = interval.limits or (min(Fraction(0), *values), max(Fraction(0), *values))
    return Range({tuple(utility)}, limits, interval.limits is not None)


class Sampling:
    """What the samples of an interval are taken from."""

    def __init__(self, interval: Interval, table: Table) -> None:
        self.interval, self.table = interval, table
        self.declared = interval.limits is not None
        common = table.header.utility
        utilities = {cell.utility for cell in table.cells} if common is None else {common}
        self.partly = any(None in utility for utility in utilities)
        given = {g for utility in utilities for g in utility} if self.partly else set()
        self.greatest = max((Fraction(*g) for g in given if g is not None), default=Fraction(0))
        self.common = None if common is None else self._range({common})

    def _range(self, utilities: Iterable[Utility]) -> Range:
        """The range of g in some cells; if g is not given somewhere, it may be anything up to the greatest one there is."""
        if self.interval.limits is not None:
            limits = self.interval.limits
        elif self.partly:
            limits = Fraction(0), self.greatest
        else:
            values = [Fraction(*g) for utility in utilities for g in set(utility) if g is not None]
            limits = min(Fraction(0), *values), max(Fraction(0), *values)
        return Range(utilities, limits, self.declared)

    def range_of(self, cells: Iterable[Cell]) -> Range:
        """The range of g in some cells, for all of which it is often the same."""
        return self.common or self._range({cell.utility for cell in cells})

    def of_counts(self) -> Comparison:
        """Take a sample from each cell that is compared, or from each group, whose rows are pooled over the contexts."""
        table, units = self.table, self.interval.units
        if table.kept is None:
            return self._of_groups()
        blocks = compared_cells(self.interval.quantity, table)
        pools = [*chain.from_iterable(blocks)]
        if units is not None and len(units) != len(pools):
            raise Unproven(f"units must be listed for {len(pools)} cells, not for {len(units)}")
        tallied = isinstance(self.interval.evidence, ContrastEvidence | UnitEvidence)
        samples: list[Sample] = []
        tallies: list[Tally] = []
        for i, cells in enumerate(pools):
            known = self.range_of(cells)
            if units is None:
                parts = [(whole_counts(cell, table), cell.utility) for cell in cells]
                samples.append(known.sample(*parts[0]) if len(parts) == 1 else known.pooled(parts))
            else:
                [cell] = cells
                counts = whole_counts(cell, table)
                rows = [[n * count for count in row] for n, row in units[i]]
                if any(len(row) != len(counts) for row in rows) or [*map(sum, zip(*rows, strict=True))] != counts:
                    raise Unproven(f"units[{i}] do not add up to the counts {place_of(table, cell)}")
                parts = [(counts, cell.utility)]
                samples.append(known.of_units(cell.utility, units[i]))
            if tallied:
                tallies.append(_tally(known.draws(parts) if units is None else known.means(parts[0][1], units[i])))
        numbers = iter(range(len(samples)))
        return Comparison(samples, [[({next(numbers): 1}, 1) for _ in block] for block in blocks], False, tallies)

    def _of_groups(self) -> Comparison:
        """Take a sample from each group, of a table whose cells are not kept: what its laws add up to."""
        groups, utility = globally_compared(self.table), self.table.header.utility
        if utility is None or self.common is None:
            raise Unproven("the cells of the table are not kept")
        samples = []
        for a in groups:
            counts, unit = self.table.figures.laws[a].value()
            if unit != 1:
                raise Unproven("the counts are not integers")
            samples.append(self.common.sample(counts, utility))
        return Comparison(samples, [[({i: 1}, 1) for i in range(len(groups))]] if groups else [], False, [])

    def of_policy(self, policy: Policy) -> Comparison:
        """Take a sample from each released context and group, for each true context and group if the utility depends on them."""
        table = self.table
        if not policy.draws:
            raise Unproven("the rows of the policy do not say how many decisions were drawn")
        groups, unit = policy.group.matrix()
        if policy.context is None:
            contexts, scale = [[(x, 1)] for x in range(len(policy.rows))], 1
        else:
            matrix, scale = policy.context.matrix()
            contexts = [[(x, p) for x, p in enumerate(row) if p] for row in matrix]
        by_group, by_context = constants(table)["depends_on_group"], table.header.utility is None
        pairs = sum(map(len, contexts)) * sum(map(len, groups))
        spend(20 * pairs, (scale * unit).bit_length())
        keep(4 * pairs, (scale * unit).bit_length())
        numbers: dict[tuple[int, int, int, int], int] = {}
        samples: list[Sample] = []
        forms: list[Affine] = []
        for cell in table.cells:
            form: dict[int, int] = {}
            own = (cell.context if by_context else -1, cell.group if by_group else -1)
            for (x, p), (a, q) in product(contexts[cell.context], enumerate(groups[cell.group])):
                if q:
                    number = numbers.setdefault((x, a, *own), len(samples))
                    form[number] = p * q
                    if number == len(samples):
                        spend(100 + 40 * len(cell.utility))
                        keep(40)
                        weights, total = policy.rows[x][a]
                        counts = [weight * (policy.draws[x][a] // total) for weight in weights]
                        samples.append(self.range_of([cell]).sample(counts, cell.utility))
            forms.append((form, scale * unit))
        n = len(table.header.groups)
        blocks = [forms[i : i + n] for i in range(0, len(forms), n)]
        if self.interval.quantity == "global":
            means: list[Affine] = []
            for a in globally_compared(table):
                masses = [cell.mass for cell in table.by_group()[a]]
                above, below = sum_of(masses)
                means.append(affine_sum(((p * below, q * above), form) for (p, q), form in zip(masses, forms[a::n], strict=True)))
            blocks = [means] if means else []
        return Comparison(samples, blocks, len({place[:2] for place in numbers}) < len(numbers), [])
