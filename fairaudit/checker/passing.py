"""An interval of the local ratio by ends of single cells, proved while the cells of the table pass by: none of them is held."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from .claims import METHODS
from .header import Cell, Header
from .intervals import BoxEvidence, Interval, Listed, Proven, Unproven
from .moved_ends import EndMove, MovedEnds
from .plain_ends import BITS, PlainEnds
from .rationals import INFINITY, Rational
from .regions import check_ends, check_levels, check_lower, check_single, pair_at, scaled_box
from .samples import Range, common_range, counts_of
from .tails import Sample
from .work import spend

KNOWN = 1 << 9  # different counts whose samples are remembered: many cells of a large table have equal ones


def passing_box(interval: Interval, moves: Sequence[EndMove] = ()) -> PassingBox | None:
    """What proves an interval of counts while cells pass by, if it lists few ends of single cells, and what follows where these move."""
    evidence = interval.evidence
    if not isinstance(evidence, BoxEvidence) or interval.units is not None or interval.difference or interval.quantity != "local":
        return None
    if not isinstance(evidence.upper, Listed) or not isinstance(evidence.lower, Listed) or interval.method != METHODS[0]:
        return None
    return PassingBox(interval, evidence, evidence.upper, evidence.lower, moves)


class PassingBox:
    """What the cells of each context add to the proof of an interval, of counts and a utility that depends on the decision alone."""

    def __init__(self, interval: Interval, evidence: BoxEvidence, upper: Listed, lower: Listed, moves: Sequence[EndMove]) -> None:
        self.interval, self.evidence = interval, evidence
        self.upper, self.lower = (dict(zip(given.cells, given.ends, strict=True)) for given in (upper, lower))
        self.coming = sorted({*self.upper, *self.lower}, reverse=True)  # the numbers of the listed cells that did not pass yet
        self.bound = None if interval.ratio[1] == INFINITY else Fraction(*interval.ratio[1])
        self.plain = PlainEnds(evidence.levels[0], interval.method)
        self.known: dict[tuple[tuple[int, ...], Rational], tuple[Sample, tuple[int, int]]] = {}
        self.cells, self.blocks, self.used, self.spanned = 0, 0, 0, 0
        self.range: Range | None = None
        self.moved = [MovedEnds(move) for move in (moves if interval.each else ())]
        self.needs_plain = self.bound is not None or any(moved.move.upper for moved in self.moved)
        self.fault = ""

    def begin(self, header: Header) -> None:
        """Read the first line."""
        if header.utility is not None:
            self.range = common_range(self.interval, header.utility)
        for moved in self.moved:
            moved.begin(header)

    def take(self, cells: Sequence[Cell]) -> None:
        """Take in the cells of a context."""
        if self.range is None or self.fault or len(cells) < 2:
            return
        try:
            self._take(cells, self.range)
        except Unproven as error:
            self.fault = str(error)

    def _take(self, cells: Sequence[Cell], known: Range) -> None:
        first, number = self.cells, self.blocks
        self.cells, self.blocks = first + len(cells), number + 1
        spend(2 * len(cells))
        informative = len(cells) if known.low < known.high else 0  # no cell of counts is without draws
        self.used, self.spanned = self.used + informative, max(self.spanned, min(2, informative))
        pair = self.evidence.pair
        if (self.coming and self.coming[-1] < self.cells) or (pair is not None and pair[0] == number):
            self._take_listed(cells, [self._sample(cell, known)[0] for cell in cells], first, number)
            return
        limits = known.low << BITS, known.high << BITS
        spend(8 * len(cells) * (1 + len(self.moved)))
        around = self._around(cells, known)
        if around is not None and self._cannot_matter(cells, around, limits):
            return
        ends = [self._sample(cell, known)[1] for cell in cells]
        if self.bound is not None:
            check_single(ends, number, self.bound)
        for moved in self.moved:
            moved.take_plain(cells, ends, limits, known.unit << BITS)

    def _around(self, cells: Sequence[Cell], known: Range) -> tuple[int, int] | None:
        """What holds the plain ends of all cells of a context, in the same multiples as theirs; None where it is not quickly found."""
        counts, unit, width = [cell.mass[0] for cell in cells], known.unit, known.high - known.low
        if not width or (max(counts) * unit).bit_length() > 128 or any(d != 1 or n % total for _, _, (_, total), (n, d), _, _ in cells):
            return None
        means = [(n << BITS) // d for _, _, _, _, (n, d), _ in cells]  # rounded down
        low, high, one = min(means) * unit - (known.low << BITS), (max(means) + 1) * unit - (known.low << BITS), width << BITS
        if low < 0 or high - unit > one:
            return None
        least, most = self.plain.around(min(counts), low, min(one, high), one)
        return (known.low << BITS) + width * least, (known.low << BITS) + width * most

    def _cannot_matter(self, cells: Sequence[Cell], ends: tuple[int, int], limits: tuple[int, int]) -> bool:
        """Whether cells with such ends keep the bound, and change nothing of what follows where they move."""
        if self.bound is not None and ends[1] * self.bound.denominator > ends[0] * self.bound.numerator:
            return False
        return not any(moved.needs(cells, [ends], limits) for moved in self.moved)

    def _sample(self, cell: Cell, known: Range) -> tuple[Sample, tuple[int, int]]:
        """What was drawn in a cell, and its plain ends as multiples of a number that all cells have in common."""
        key = cell.law[0], cell.mass
        found = self.known.get(key)
        if found is None:
            sample = known.sample(counts_of(cell), cell.utility)
            found = sample, (self.plain.numerators(sample) if self.needs_plain else (0, 0))
            if len(self.known) >= KNOWN:
                self.known.clear()
            self.known[key] = found
        return found

    def _take_listed(self, cells: Sequence[Cell], samples: Sequence[Sample], first: int, number: int) -> None:
        """Take in a context some of whose cells are listed, or whose cells prove the lower end."""
        numbers = range(first, first + len(samples))
        while self.coming and self.coming[-1] < numbers.stop:
            self.coming.pop()
        for name, listed, level in (("upper", self.upper, 0), ("lower", self.lower, 1)):
            here = [i for i in numbers if i in listed]
            own = [samples[i - first] for i in here]
            check_ends(own, [listed[i] for i in here], self.evidence.levels[level], self.interval.method, name)
        outer = [
            self.upper[i] if i in self.upper else (self.plain.of(sample, 0), self.plain.of(sample, 1))
            for i, sample in zip(numbers, samples, strict=True)
        ]
        inner = [self.lower.get(i, sample.range) for i, sample in zip(numbers, samples, strict=True)]
        if self.bound is not None:
            check_single(scaled_box(outer), number, self.bound)
        if self.evidence.pair is not None and self.evidence.pair[0] == number:
            forms = [({i: 1}, 1) for i in range(len(samples))]
            check_lower(self.interval.ratio[0], *pair_at((0, *self.evidence.pair[1:]), [forms]), inner)
        for moved in self.moved:
            ends = [(Fraction(*low), Fraction(*high)) for low, high in (outer if moved.move.upper else inner)]
            moved.take_cells(cells, ends, (samples[0].low, samples[0].high))

    def proven(self) -> Proven:
        """Say what is proven, now that all cells have passed."""
        if self.fault:
            raise Unproven(self.fault)
        if not self.blocks or self.range is None:
            raise Unproven("the table does not give this quantity")
        check_levels(self.interval, self.evidence, self.used, self.spanned)
        if self.coming:
            raise Unproven(f"the ends of a cell {self.coming[0]} of {self.cells} are listed")
        if self.evidence.pair is not None and self.evidence.pair[0] >= self.blocks:
            raise Unproven("the pair is not one that is compared")
        by = "binomial" if self.range.binary or not self.used else self.interval.method
        found = {moved.move: moved.found() for moved in self.moved} if self.interval.each else None
        return Proven(self.interval.ratio, 1 - Fraction(*self.interval.confidence), self.interval.scope, by, self.interval.each, found)
