"""Laws that move: the ends of expectations when each cell drifts by itself, followed while the cells of a table pass by.

Within total variation eta the greatest expectation has moved the lowest mass eta to the greatest utility of the cell.  Where each
probability may change by a factor f, it has f times the highest mass 1/(1 + f) and 1/f times the rest; with f infinite, the best seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from .header import Cell, Header
from .json_values import Labels
from .laws import gains_of
from .policy_evidence import Attained
from .rationals import INFINITY, ONE, ZERO, Rational, RunningTotal, at_most, extreme_positions, greatest_quotient, quotient, reduced
from .work import spend

Ends = tuple[Rational, Rational]  # the least and the greatest expectation


@dataclass(frozen=True)
class Move:
    """How far each cell may move: by total variation, or by a factor, which may be infinite."""

    by_factor: bool
    amount: Rational


class Cellwise:
    """A cell's law with its utilities, from the least one on, over common denominators."""

    def __init__(self, cell: Cell, known: dict[object, tuple[list[int], list[int], int]]) -> None:
        utility = cell.utility
        if utility not in known:
            gains, unit = gains_of(utility)
            order = sorted(range(len(gains)), key=gains.__getitem__)
            known[utility] = order, [gains[u] for u in order], unit
        order, self.gains, self.unit = known[utility]
        weights, self.total = cell.law
        self.weights = [weights[u] for u in order]
        spend(8 + 4 * len(order), self.total.bit_length(), self.unit.bit_length() + max(map(int.bit_length, self.gains)))

    def range(self, seen: bool) -> Ends:
        """The least and the greatest utility, of all decisions or of those that are made."""
        gains = [g for g, w in zip(self.gains, self.weights, strict=True) if w] if seen else self.gains
        return (gains[0], self.unit), (gains[-1], self.unit)

    def reached(self, up: bool) -> Rational:
        """The total variation from which on the end is that of the range."""
        end = self.gains[-1 if up else 0]
        return self.total - sum(w for g, w in zip(self.gains, self.weights, strict=True) if g == end), self.total

    def ends(self, move: Move) -> Ends:
        """The least and the greatest expectation within a move."""
        if move.amount == INFINITY:
            return self.range(True)
        rising, falling = list(zip(self.weights, self.gains, strict=True)), list(zip(self.weights[::-1], self.gains[::-1], strict=True))
        p, q = move.amount
        spend(12 * len(rising), self.total.bit_length() + self.unit.bit_length(), p.bit_length() + q.bit_length())
        mean = sum(w * g for w, g in rising)
        if not move.by_factor:
            low, high = (
                mean * q + p * self.total * end - _first(part, p * self.total, q)
                for part, end in ((falling, self.gains[0]), (rising, self.gains[-1]))
            )
            below = self.total * q * self.unit
        else:
            least, most = (_first(part, q * self.total, p + q) for part in (rising, falling))
            low, high = (p * p * part + q * q * (mean * (p + q) - part) for part in (least, most))
            below = p * q * (p + q) * self.total * self.unit
        return (low, below), (high, below)


def _scaled(mean: Rational, end: Rational, p: int, q: int) -> Rational:
    """Multiply the distance from an end by p/q."""
    (n, d), (k, e) = mean, end
    return k * d * q + (n * e - k * d) * p, d * e * q


def _first(parts: Sequence[tuple[int, int]], left: int, unit: int) -> int:
    """What the first so much mass contributes, each weight counting so often."""
    found = 0
    for w, g in parts:
        part = min(w * unit, left)
        found += part * g
        left -= part
    return found


@dataclass
class Watch:
    """The greatest ratio that a move allows, or the greatest that it cannot avoid, while cells pass by; and the pair that is named.

    Of group means those of the groups in ``followed`` are summed exactly; of the others what no move exceeds is enough.
    """

    key: tuple[str, str, str, str]  # of the claim
    local: bool
    move: Move
    worst: bool
    place: Attained | None
    followed: frozenset[Labels]
    header: Header | None = None
    value: Rational = ONE  # of the local ratio, so far
    named: dict[Labels, Cellwise] = field(default_factory=dict)  # the two cells of the pair
    sums: dict[int, RunningTotal] = field(default_factory=dict)  # by group: low and high end
    reached: dict[int, Rational] = field(default_factory=dict)
    known: dict[object, tuple[list[int], list[int], int]] = field(default_factory=dict)
    open_utility: bool = False  # whether a utility is not given
    context: int | None = None
    groups: frozenset[int] = frozenset()
    pair: frozenset[int] = frozenset()
    ranges: dict[int, RunningTotal] = field(default_factory=dict)  # of the groups of the pair, the ends of what their cells can be worth

    def begin(self, header: Header) -> None:
        """Find the places of the labels."""
        self.header = header
        self.open_utility = header.utility is not None and None in header.utility
        at = {label: a for a, label in enumerate(header.groups)}
        self.groups = frozenset(at[label] for label in self.followed if label in at)
        named = () if self.place is None else (self.place.higher, self.place.lower)
        self.pair = frozenset(at[label] for label in named if label in at)
        if self.place is not None and self.place.context is not None and self.place.context in header.contexts:
            self.context = header.contexts.index(self.place.context)

    def take(self, cells: Sequence[Cell]) -> None:
        """Take in the cells of a context."""
        spend(4 * len(cells))
        if (self.header is None or self.header.utility is None) and any(None in cell.utility for cell in cells):
            self.open_utility = True
            return
        if not self.local:
            self._add_up(cells)
        elif len(cells) > 1:
            self._take_local(cells)

    def _take_local(self, cells: Sequence[Cell]) -> None:
        if self.place is not None and cells[0].context == self.context and self.header is not None:
            wanted = (self.place.higher, self.place.lower)
            self.named |= {label: Cellwise(cell, self.known) for cell in cells if (label := self.header.groups[cell.group]) in wanted}
        if self._cannot_matter(cells):
            return
        ends = [Cellwise(cell, self.known).ends(self.move) for cell in cells]
        spend(16 * len(cells))
        tops = [high if self.worst else low for low, high in ends]
        bottoms = [low if self.worst else high for low, high in ends]
        self.value = _greater(self.value, greatest_quotient(tops, bottoms))

    def _cannot_matter(self, cells: Sequence[Cell]) -> bool:
        """Whether quick bounds of the ends show that the ratio so far is not exceeded here."""
        if self.header is None or self.header.utility is None or self.value == INFINITY:
            return self.value == INFINITY
        means = [cell.expectation for cell in cells]
        top, low = extreme_positions(means)
        high, bottom = self.bounds(means[top], means[low])
        return at_most(quotient(high, bottom), self.value)

    def bounds(self, top: Rational, bottom: Rational) -> Ends:
        """What the end of a greatest mean cannot exceed, and that of a least one not fall below, whatever the laws are."""
        if self.header is None or self.header.utility is None:
            return INFINITY, ZERO
        (p, q), given = self.move.amount, [g for g in self.header.utility if g is not None]
        i, j = extreme_positions(given)
        gamma, m = given[i], given[j]
        if self.worst:
            if self.move.amount == INFINITY:
                return gamma, m
            if self.move.by_factor:
                # Above m and below gamma everything changes by the factor at most.
                high, low = _scaled(top, gamma, q, p), _scaled(bottom, m, q, p)
                further, deeper = _scaled(top, m, p, q), _scaled(bottom, gamma, p, q)
                return (high if at_most(high, further) else further), (low if at_most(deeper, low) else deeper)
            n, d = gamma[0] * m[1] - m[0] * gamma[1], gamma[1] * m[1]
            high = top[0] * q * d + p * n * top[1], top[1] * q * d
            low = bottom[0] * q * d - p * n * bottom[1], bottom[1] * q * d
            return (gamma if at_most(gamma, high) else high), (low if at_most(m, low) else m)
        if self.move.by_factor:
            return top, bottom
        ends = [((q - p) * mean[0] * end[1] + p * end[0] * mean[1], q * mean[1] * end[1]) for mean, end in ((top, m), (bottom, gamma))]
        return ends[0], ends[1]

    def _add_up(self, cells: Sequence[Cell]) -> None:
        for cell in cells:
            if cell.group in self.groups and cell.mass[0]:
                own = Cellwise(cell, self.known)
                (low, below), (high, _) = own.ends(self.move)
                n, d = _over(cell.mass, below, own.total)
                self.sums.setdefault(cell.group, RunningTotal()).add([n * low, n * high], d)
                if cell.group in self.pair:
                    (least, unit), (most, _) = own.range(self.move.by_factor)
                    self.ranges.setdefault(cell.group, RunningTotal()).add([cell.mass[0] * least, cell.mass[0] * most], cell.mass[1] * unit)
                    for up, other in ((False, -1 - cell.group), (True, cell.group)):
                        self.reached[other] = _greater(self.reached.get(other, ZERO), own.reached(up))

    def means(self, masses: dict[int, Rational]) -> dict[int, list[Rational]]:
        """Of the groups that are followed: low and high end; of those of the pair the ends of the range, too."""
        found = {}
        for a in self.sums:
            n, d = masses[a]
            summed = [self.sums[a].value(), *([self.ranges[a].value()] if a in self.ranges else [])]
            found[a] = [reduced(number * d, below * n) for numbers, below in summed for number in numbers]
        return found


def _over(mass: Rational, below: int, total: int) -> Rational:
    """Divide a mass by a denominator; often the sum of the weights is a factor of both."""
    n, d = mass
    return (n // total, d * (below // total)) if n % total == below % total == 0 else reduced(n, d * below)


def _greater(one: Rational, other: Rational) -> Rational:
    return one if at_most(other, one) else reduced(*other)
