"""The samples in a table, and the expected utilities that are compared as weighted sums of their means."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, product

from .header import Cell
from .intervals import ContrastEvidence, Interval, Unproven
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
Part = tuple[Sequence[int], Sequence[Rational | None]]  # the counts of the decisions, and their utilities
Units = Sequence[tuple[int, Sequence[int]]]  # how many draws had which counts
Draws = Sequence[tuple[int, Fraction]]  # how many draws had which value


def _sample(parts: Sequence[Part], units: Units | None, limits: tuple[Fraction, Fraction], declared: bool) -> tuple[Sample, Draws]:
    """Pool counts, and say how often each value was drawn; the units say which rows of a single part belong to one draw.

    Draws are of two values only if the utility says so of whatever could have been drawn, which a declared range and units do not.
    """
    low, high = limits
    pooled: Counter[Rational | None] = Counter()
    for counts, utility in parts:
        for count, g in zip(counts, utility, strict=True):
            pooled[g] += count
    values = {g: Fraction(*g) for g in pooled if g is not None}
    draws = [(pooled[g], value) for g, value in values.items() if pooled[g]]
    binary = units is None and not declared and None not in pooled and all(value in (low, high) for value in values.values())
    if units is not None:
        [(_, utility)] = parts
        rows = [
            (n, [(count, values[g]) for count, g in zip(counts, utility, strict=True) if count and g is not None]) for n, counts in units
        ]
        draws = [(n, weighted_sum(own) / sum(c for c, _ in own)) for n, own in rows]
    spend(40 * len(draws))
    total, squares = (weighted_sum((n, value**power) for n, value in draws) for power in (1, 2))
    return Sample(sum(n for n, _ in draws), total, squares, low, high, binary), draws


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


def whole_counts(cell: Cell, table: Table) -> list[int]:
    """List how often each decision was drawn in a cell."""
    (weights, total), (n, d) = cell.law, cell.mass
    if n % (d * total):
        raise Unproven(f"the counts are not integers {place_of(table, cell)}")
    return [weight * (n // (d * total)) for weight in weights]


class Sampling:
    """What the samples of an interval are taken from."""

    def __init__(self, interval: Interval, table: Table) -> None:
        self.interval, self.table = interval, table
        self.declared = interval.limits is not None
        self.partly = any(None in cell.utility for cell in table.cells)
        given = {g for cell in table.cells for g in cell.utility} if self.partly else set()
        self.greatest = max((Fraction(*g) for g in given if g is not None), default=Fraction(0))

    def limits(self, cells: Iterable[Cell]) -> tuple[Fraction, Fraction]:
        """The range of g in some cells; if g is not given somewhere, it may be anything up to the greatest one there is."""
        if self.interval.limits is not None:
            return self.interval.limits
        if self.partly:
            return Fraction(0), self.greatest
        values = [Fraction(*g) for cell in cells for g in set(cell.utility) if g is not None]
        return min(Fraction(0), *values), max(Fraction(0), *values)

    def of_counts(self) -> Comparison:
        """Take a sample from each cell that is compared, or from each group, whose rows are pooled over the contexts."""
        table, units = self.table, self.interval.units
        blocks = compared_cells(self.interval.quantity, table)
        pools = [*chain.from_iterable(blocks)]
        if units is not None and len(units) != len(pools):
            raise Unproven(f"units must be listed for {len(pools)} cells, not for {len(units)}")
        tallied = isinstance(self.interval.evidence, ContrastEvidence)
        samples: list[Sample] = []
        tallies: list[Tally] = []
        for i, cells in enumerate(pools):
            parts: list[Part] = [(whole_counts(cell, table), cell.utility) for cell in cells]
            if units is not None:
                counts, _ = parts[0]
                rows = [[n * count for count in row] for n, row in units[i]]
                if any(len(row) != len(counts) for row in rows) or [*map(sum, zip(*rows, strict=True))] != counts:
                    raise Unproven(f"units[{i}] do not add up to the counts {place_of(table, cells[0])}")
            sample, draws = _sample(parts, None if units is None else units[i], self.limits(cells), self.declared)
            samples.append(sample)
            if tallied:
                tallies.append(_tally(draws))
        numbers = iter(range(len(samples)))
        return Comparison(samples, [[({next(numbers): 1}, 1) for _ in block] for block in blocks], False, tallies)

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
                        samples.append(_sample([(counts, cell.utility)], None, self.limits([cell]), self.declared)[0])
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
