"""Decisions whose group was not recorded: between which ends the ratios lie, whoever they are (T15), and what tips a target.

Each unknown decision belongs to one of the groups that are compared or to nobody who is, and each of these receives a number of them
between two limits.  In one block, a context or all of them together, a group of n decisions that sum to S has the mean of these and its
rows.  For one pair and fixed numbers of rows the ratio is greatest with the greatest rows above and the smallest below.  The mean with the
greatest rows rises while the next row lies above it and falls from then on, so that of the numbers of rows that a pair may have, each alone
or together, the best ones are the nearest to those at which both turn; if only their sum is fixed, every split is judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from .claims import WHOEVER, Claim
from .header import UnknownRow
from .json_values import Labels
from .rationals import INFINITY, ONE, ZERO, Rational, at_most, over_common_denominator, reduced, widest_ratio
from .table import Table, counts_are_whole, globally_compared
from .text import shown
from .unknown_evidence import Assigned, Evidence, Share, Tips
from .work import keep, spend


class Ordered:
    """Rows in some order, equal ones together: what the first so many of them sum to."""

    def __init__(self, rows: Sequence[tuple[int, int]]) -> None:
        self.rows = rows
        self.ends = [0]
        for _, number in rows:
            self.ends.append(self.ends[-1] + number)

    def sum(self, count: int) -> int:
        """Sum the first rows."""
        spend(len(self.rows))
        total = 0
        for value, number in self.rows:
            taken = min(number, count)
            total, count = total + value * taken, count - taken
        return total

    def turn(self, size: int, total: int, falling: bool) -> int:
        """Say after how many rows the mean of a group that begins with so many and such a sum no longer moves the right way."""
        spend(len(self.rows))
        for place, (value, number) in enumerate(self.rows):
            if value * size <= total if falling else value * size >= total:
                return self.ends[place]
            size, total = size + number, total + value * number
        return self.ends[-1]


@dataclass(frozen=True)
class Block:
    """A context, or all together: its groups with how many decisions they have and what these sum to, and the unknown ones.

    All sums and values are integers over ``below``.
    """

    context: int | None
    groups: tuple[int, ...]
    sizes: tuple[int, ...]
    sums: tuple[int, ...]
    values: tuple[tuple[int, int], ...]  # of the unknown decisions, greatest first, with their numbers
    below: int
    limits: tuple[tuple[int, int], ...]  # of how many each group receives
    rest: tuple[int, int]  # and all together who are not compared

    @cached_property
    def greatest(self) -> Ordered:
        """The unknown rows, greatest first."""
        return Ordered(self.values)

    @cached_property
    def smallest(self) -> Ordered:
        """The unknown rows, smallest first."""
        return Ordered(self.values[::-1])

    @cached_property
    def unknown(self) -> int:
        """The number of unknown rows."""
        return sum(number for _, number in self.values)

    def together(self, chosen: Sequence[int]) -> tuple[int, int]:
        """Bound how many rows some groups can receive together, so that all others keep to their limits."""
        low, high = self.all_limits
        least, most = (sum(self.limits[a][end] for a in chosen) for end in (0, 1))
        return max(least, self.unknown - high + most), min(most, self.unknown - low + least)

    @cached_property
    def all_limits(self) -> tuple[int, int]:
        """How many rows all receivers get at least and at most."""
        low, high = (sum(limit[end] for limit in (*self.limits, self.rest)) for end in (0, 1))
        return low, high

    @cached_property
    def most(self) -> list[int]:
        """For each group the number of the greatest rows with which its mean is greatest."""
        return [
            _between(self.together([a]), self.greatest.turn(n, s, True)) for a, (n, s) in enumerate(zip(self.sizes, self.sums, strict=True))
        ]

    @cached_property
    def worst(self) -> list[int]:
        """For each group the number of the smallest rows with which its mean is least."""
        return [
            _between(self.together([a]), self.smallest.turn(n, s, False))
            for a, (n, s) in enumerate(zip(self.sizes, self.sums, strict=True))
        ]

    def ratio(self, higher: int, lower: int, i: int, j: int) -> Rational:
        """The ratio of two groups that receive so many of the greatest and of the smallest rows."""
        n, m = self.sizes[higher] + i, self.sizes[lower] + j
        above, under = (self.sums[higher] + self.greatest.sum(i)) * m, (self.sums[lower] + self.smallest.sum(j)) * n
        spend(20, above.bit_length(), under.bit_length())
        return reduced(above, under) if under else INFINITY if above else ONE

    def excess(self, higher: int, lower: int, i: int, j: int, limit: Rational) -> int:
        """By how much the first mean exceeds the limit times the second one, times a positive number."""
        n, m = self.sizes[higher] + i, self.sizes[lower] + j
        one, other = (self.sums[higher] + self.greatest.sum(i)) * m, (self.sums[lower] + self.smallest.sum(j)) * n
        spend(20, max(one.bit_length(), other.bit_length()), max(limit).bit_length())
        return limit[1] * one - limit[0] * other

    def freely(self, rows: int) -> Block:
        """The same without limits, but at most so many rows to all groups together."""
        spend(len(self.groups))
        limits = tuple((0, rows) for _ in self.groups)
        return replace(self, limits=limits, rest=(self.unknown - rows, self.unknown))


def _between(limits: tuple[int, int], wanted: int) -> int:
    return min(max(wanted, limits[0]), limits[1])


def pair_stays(block: Block, higher: int, lower: int, limit: Rational, below: bool = False) -> bool:
    """Decide whether the ratio of an ordered pair is at most a limit in all assignments, or even below it."""
    i, j = block.most[higher], block.worst[lower]
    if not at_most(ONE, limit) and block.sums[lower] + block.smallest.sum(j) == 0:
        return False  # 0/0 = 1 is above the limit
    if block.excess(higher, lower, i, j, limit) <= -below:
        return True
    total = _between(block.together([higher, lower]), i + j)
    if total == i + j:
        return False
    (low, high), (least, most) = block.together([higher]), block.together([lower])
    low, high = max(low, total - most), min(high, total - least)
    inner = {*block.greatest.ends, *(total - end for end in block.smallest.ends)}
    ends = sorted({low, high, *(end for end in inner if low < end < high)})
    spend(len(ends) * max(1, len(ends).bit_length()))
    segments = zip(ends, ends[1:] or ends, strict=False)
    return all(_greatest_excess(block, (higher, lower), total, segment, limit) <= -below for segment in segments)


def _greatest_excess(block: Block, pair: tuple[int, int], total: int, segment: tuple[int, int], limit: Rational) -> int:
    """Find the greatest excess of all splits of some rows where both groups take rows of one value: it is a quadratic there."""

    def excess(i: int) -> int:
        return block.excess(*pair, i, total - i, limit)

    start, end = segment
    places = {start, end}
    if end - start > 1:
        first, second = excess(start + 1) - excess(start), excess(start + 2) - excess(start + 1)
        bend = second - first
        if bend < 0:  # its top is where the differences change their sign
            top = start + max(0, -(first // bend))
            places |= {min(place, end) for place in (top - 1, top, top + 1, top + 2) if place >= start}
    return max(map(excess, places))


def stays(block: Block, limit: Rational) -> bool:
    """Decide whether no ratio of two groups is above a limit of at least 1 in any assignment."""
    groups = range(len(block.groups))
    low = {a: (block.sums[a] + block.smallest.sum(block.worst[a]), block.sizes[a] + block.worst[a]) for a in groups}
    longest = max(max(mean).bit_length() for mean in low.values())
    spend(2 * len(low) * max(1, len(low).bit_length()), longest, longest)
    rising = sorted(groups, key=lambda a: _Key(low[a]))
    for a in groups:
        for b in rising:
            if b != a and block.excess(a, b, block.most[a], block.worst[b], limit) <= 0:
                break  # the others have greater means
            if b != a and not pair_stays(block, a, b, limit):
                return False
    return True


class _Key:
    """Orders rationals."""

    def __init__(self, value: Rational) -> None:
        self.value = value

    def __lt__(self, other: _Key) -> bool:
        return self.value[0] * other.value[1] < other.value[0] * self.value[1]


def _holds_apart(block: Block, low: Rational, high: Rational) -> bool:
    """Decide whether no assignment has all means above the first level, and none all below the second.

    If all means are at least m, the groups below m received of the rows above m what they lacked, each row being given once: the sum of
    max(0, m n - S) over groups is at most that of max(0, v - m) over rows.  The one less the other does not fall in m.  If it is not
    negative at a level and rises there, no greater m is possible.  Likewise from above.
    """
    spend(4 * (len(block.groups) + len(block.values)), max(low).bit_length() + max(high).bit_length(), max(block.sums).bit_length())
    cells = list(zip(block.sums, block.sizes, strict=True))
    (n, d), (p, q) = (low[0] * block.below, low[1]), (high[0] * block.below, high[1])
    lacking = sum(max(0, n * size - d * total) for total, size in cells) - sum(max(0, d * v - n) * rows for v, rows in block.values)
    rises = any(d * total <= n * size for total, size in cells) or any(d * v > n for v, _ in block.values)
    beyond = sum(max(0, q * total - p * size) for total, size in cells) - sum(max(0, p - q * v) * rows for v, rows in block.values)
    falls = any(q * total >= p * size for total, size in cells) or any(q * v < p for v, _ in block.values)
    return lacking >= 0 and rises and beyond >= 0 and falls


def _all_reach(block: Block, ratio: Rational) -> bool:
    """Go through all assignments, those being the same that give each group as many rows and as much, and decide whether none is below."""
    groups, bits = len(block.groups), (block.unknown * block.values[0][0]).bit_length() if block.values else 0
    states = {(0,) * (2 * groups)}
    for value, number in block.values:
        further: set[tuple[int, ...]] = set()
        for state in states:
            for row in _spreads(number, groups):
                spend(40 * groups, bits)  # tuples are much slower than numbers
                further.add(tuple(map(sum, zip(state, (*row, *(value * part for part in row)), strict=True))))
        keep(len(further) * 2 * groups, bits)
        states = further
    for state in states:
        if _within(block, state[:groups]):
            spend(8 * groups)
            means = [(s + g, n + r) for s, g, n, r in zip(block.sums, state[groups:], block.sizes, state[:groups], strict=True)]
            if not at_most(ratio, widest_ratio(means)[0]):
                return False
    return True


def _spreads(number: int, groups: int) -> Iterator[tuple[int, ...]]:
    if groups == 0:
        yield ()
        return
    for first in range(number + 1):
        for rest in _spreads(number - first, groups - 1):
            yield (first, *rest)


def _within(block: Block, received: Sequence[int]) -> bool:
    """Whether so many rows for each group keep all limits."""
    left = block.unknown - sum(received)
    inside = all(low <= rows <= high for (low, high), rows in zip(block.limits, received, strict=True))
    return inside and block.rest[0] <= left <= block.rest[1]


class UnknownGroups:
    """The blocks of a table with unknown decisions, and what is true of them."""

    def __init__(self, table: Table, shares: Sequence[Share]) -> None:
        self.table, self.shares = table, shares
        header = table.header
        self.places = {label: a for a, label in enumerate(header.groups)}
        self.contexts = {label: x for x, label in enumerate(header.contexts)}
        self.rows: dict[int, UnknownRow] = {row.context: row for row in table.unknown}

    @cached_property
    def fault(self) -> str:
        """Say why nothing is known: counts have to be whole, utilities not to depend on the group, and shares to be possible."""
        if not self.table.unknown:
            return "every decision has a group"
        if not counts_are_whole(self.table) or any(n[1] != 1 for row in self.table.unknown for n in row.counts):
            return "counts are not whole"
        for cell in self.table.cells if self.table.header.utility is None else ():
            row = self.rows.get(cell.context)
            if row is not None and any(g is not None and h is not None and g != h for g, h in zip(cell.utility, row.utility, strict=True)):
                return "the utility depends on the group, so that of unknown decisions is not known"
        if any(share.group is not None and share.group not in self.places for share in self.shares):
            return "a share is declared of a group that the table does not have"
        total = reduced(*_sum([share.least for share in self.shares]))
        everybody = len(self.shares) == len(self.places) + 1
        if not at_most(total, ONE) or (everybody and not at_most(ONE, reduced(*_sum([share.most for share in self.shares])))):
            return "the declared shares cannot all hold"
        return ""

    def _block(self, context: int | None, means: Mapping[int, tuple[int, Rational]], rows: Sequence[tuple[Rational, int]]) -> Block:
        """Put groups with their sizes and sums, and the unknown rows, over one denominator."""
        flat, below = over_common_denominator([*(total for _, total in means.values()), *(value for value, _ in rows)])
        numbers: dict[int, int] = {}
        for value, (_, number) in zip(flat[len(means) :], rows, strict=True):
            numbers[value] = numbers.get(value, 0) + number
        unknown = sum(numbers.values())
        spend(2 * len(self.shares) + 4, unknown.bit_length())
        limits = {None if share.group is None else self.places[share.group]: _limits(share, unknown) for share in self.shares}
        away = [limit for a, limit in limits.items() if a not in means]
        free = len(self.places) + 1 - len(means) - len(away)  # receivers that are not compared and of which nothing is declared
        rest = sum(low for low, _ in away), min(unknown, sum(high for _, high in away) + free * unknown)
        own = tuple(limits.get(a, (0, unknown)) for a in means)
        sizes = tuple(size for size, _ in means.values())
        return Block(
            context, tuple(means), sizes, tuple(flat[: len(means)]), tuple(sorted(numbers.items(), reverse=True)), below, own, rest
        )

    @cached_property
    def local(self) -> dict[int | None, Block]:
        """The contexts that are compared."""
        found: dict[int | None, Block] = {}
        for x, cells in enumerate(self.table.by_context()):
            if len(cells) > 1:
                means = {cell.group: (cell.mass[0], _times(cell.mass, cell.expectation)) for cell in cells}
                found[x] = self._block(x, means, self.rows[x].by_value if x in self.rows else ())
        return found

    @cached_property
    def overall(self) -> dict[int | None, Block]:
        """All contexts together."""
        means: dict[int, tuple[int, Rational]] = {}
        compared = set(globally_compared(self.table))
        for a, cells in enumerate(self.table.by_group()):
            if a in compared:
                size = sum(cell.mass[0] for cell in cells)
                means[a] = size, reduced(*_sum([_times(cell.mass, cell.expectation) for cell in cells]))
        rows = [pair for row in self.table.unknown for pair in row.by_value]
        return {None: self._block(None, means, rows)} if means else {}

    def blocks(self, quantity: str) -> dict[int | None, Block]:
        """What is compared for a ratio."""
        return self.local if quantity.startswith("local") else self.overall

    def find(self, quantity: str, context: Labels | None) -> Block | None:
        """The block of that name."""
        if context is not None and context not in self.contexts:
            return None
        return self.blocks(quantity).get(None if context is None else self.contexts[context])

    def pair(self, block: Block, pair: tuple[Labels, Labels]) -> tuple[int, int] | None:
        """Two different groups of a block, by name."""
        places = [self.places.get(label) for label in pair]
        if places[0] == places[1] or not all(place in block.groups for place in places):
            return None
        one, other = (block.groups.index(place) for place in places if place is not None)
        return one, other

    def fault_of(self, claim: Claim) -> str:
        """Say what is wrong with a claim about an end; nothing if it is true."""
        evidence = claim.evidence
        if not isinstance(evidence, Evidence):
            raise AssertionError
        return self.fault or (self._fault_of_greatest if claim.key[1] == "<=" else self._fault_of_least)(
            claim.key[0], claim.value, evidence
        )

    def _fault_of_greatest(self, quantity: str, value: Rational, evidence: Evidence) -> str:
        if evidence.place is None or evidence.place.pair is None:
            raise AssertionError
        block = self.find(quantity, evidence.place.context)
        pair = None if block is None else self.pair(block, evidence.place.pair)
        if block is None or pair is None:
            return "the pair is not compared"
        i, j = evidence.received
        inside = all(low <= rows <= high for (low, high), rows in ((block.limits[a], n) for a, n in zip(pair, (i, j), strict=True)))
        low, high = block.together(pair)
        if not inside or not low <= i + j <= high:
            return "the pair cannot receive so many unknown decisions"
        if block.ratio(*pair, i, j) != value:
            return f"the pair attains {shown(block.ratio(*pair, i, j))}"
        if not all(stays(other, value) for other in self.blocks(quantity).values()):
            return "there are assignments with a greater ratio"
        return ""

    def _fault_of_least(self, quantity: str, value: Rational, evidence: Evidence) -> str:
        if value == ONE and evidence.place is not None:
            return "the proof of a ratio of at least 1 is null"
        if value != ONE:
            block = None if evidence.place is None else self.find(quantity, evidence.place.context)
            if block is None or evidence.place is None or at_most(value, ONE):
                return "no context proves it"
            pair = None if evidence.place.pair is None else self.pair(block, evidence.place.pair)
            if evidence.place.pair is not None and pair is None:
                return "the pair is not compared"
            if evidence.levels is not None:
                (n, d), (p, q) = evidence.levels
                if not _holds_apart(block, *evidence.levels) or not at_most(value, reduced(p * d, n * q) if n else INFINITY if p else ONE):
                    return "the groups can be levelled further"
            elif pair is None and not _all_reach(block, value):
                return "there are assignments with a smaller ratio"
            if pair is not None and not pair_stays(block, pair[1], pair[0], (value[1], value[0])):
                return "the pair has a smaller ratio in some assignment"
        return "" if evidence.reached is None else self._fault_of_reached(quantity, evidence.reached, evidence.assigned)

    def _fault_of_reached(self, quantity: str, ratio: Rational, assigned: Sequence[Assigned]) -> str:
        """Say what is wrong with an assignment under which no ratio is said to be greater; blocks without one stay below it anyway."""
        if not at_most(ONE, ratio):
            return "no ratio is below 1"
        left = dict(self.blocks(quantity))
        for entry in assigned:
            place = None if entry.context is None else self.contexts.get(entry.context)
            block = left.pop(place, None) if entry.context is None or place is not None else None
            if block is None:
                return "an assignment is for a context that is not compared, or has one"
            means = _means(block, entry)
            if means is None:
                return "an assignment breaks a limit"
            if not at_most(widest_ratio(means)[0], ratio):
                return f"an assignment has the ratio {shown(reduced(*widest_ratio(means)[0]))}"
        return "" if all(stays(block, ratio) for block in left.values()) else "a context without an assignment can have a greater ratio"

    def fault_of_tips(self, quantity: str, limit: Rational, labelled: Rational, tips: Tips) -> str:
        """Say what is wrong with the number of unknown decisions that cannot change what the others say."""
        block = self.find(quantity, tips.place.context)
        pair = None if block is None or tips.place.pair is None else self.pair(block, tips.place.pair)
        if self.fault or block is None or pair is None or tips.rows >= block.unknown:
            return self.fault or "the pair that tips is not compared, or has not so many unknown decisions"
        if tips.labelled != ("within" if at_most(labelled, limit) else "exceeds"):
            return "those with a group say the opposite by themselves"
        if tips.labelled == "exceeds":
            back = (limit[1], limit[0])
            above = not at_most(block.ratio(*pair, 0, 0), limit)
            holds = above and pair_stays(block.freely(tips.rows), pair[1], pair[0], back, below=True)
            return "" if holds else f"so many unknown decisions can bring the pair down to {shown(limit)}"
        if pair_stays(block.freely(tips.rows + 1), *pair, limit):
            return "one more decision does not bring the pair above the limit"
        fine = all(stays(other.freely(min(tips.rows, other.unknown)), limit) for other in self.blocks(quantity).values())
        return "" if fine else f"so many unknown decisions can bring a pair above {shown(limit)}"


def _means(block: Block, entry: Assigned) -> list[Rational] | None:
    """The means of the groups of a block with the rows that they receive; nothing if that is not possible."""
    numbers = {reduced(value, block.below): (value, number) for value, number in block.values}
    received, sums = [0] * len(block.groups), list(block.sums)
    for name, row in zip(entry.values, entry.counts, strict=True):
        value, number = numbers.get(name, (0, 0))
        if len(row) != len(block.groups) or sum(row) > number:
            return None
        spend(2 * len(row))
        for a, rows in enumerate(row):
            received[a], sums[a] = received[a] + rows, sums[a] + value * rows
    return [(s, n + r) for s, n, r in zip(sums, block.sizes, received, strict=True)] if _within(block, received) else None


def _limits(share: Share, unknown: int) -> tuple[int, int]:
    """How many of the unknown decisions may be of a group, rounded outward."""
    return share.least[0] * unknown // share.least[1], -(-share.most[0] * unknown // share.most[1])


def _times(mass: Rational, mean: Rational) -> Rational:
    return reduced(mass[0] * mean[0], mass[1] * mean[1])


def _sum(values: Sequence[Rational]) -> tuple[int, int]:
    flat, below = over_common_denominator(values or [ZERO])
    return sum(flat), below


def judge_whoever(limit: Rational, decide: Callable[[Rational, Rational], bool], quantity: str, true_claims: Sequence[Claim]) -> str:
    """Judge a limit by what is true whoever the unknown are: within or exceeds by all assignments, depends if there is one on each side."""
    verdict = "inconclusive"
    claims = {claim.key[1]: claim for claim in true_claims if claim.key[0] == f"{quantity}_ratio" and claim.key[3].endswith(WHOEVER)}
    most, least = claims.get("<="), claims.get(">=")
    above = most is not None and not decide(most.value, limit)
    if most is not None and not above:
        verdict = "within"
    elif least is not None and not decide(least.value, limit):
        verdict = "exceeds"
    elif above and least is not None and isinstance(least.evidence, Evidence) and least.evidence.reached is not None:
        verdict = "depends" if decide(least.evidence.reached, limit) else verdict
    return verdict
