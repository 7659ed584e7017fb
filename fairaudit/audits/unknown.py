"""How far decisions without a recorded group can move ratios, whoever they are (T15): bounds, what attains them, what tips a target."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import ceil, floor, inf
from typing import TYPE_CHECKING, Literal

import numpy as np

from fairaudit.audits.targets import Target
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.enclosures import compare_log
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.exact.rationals import Number, option_value, quotient
from fairaudit.inference.verdicts import Verdict
from fairaudit.measures.limits import Limit, Quantity
from fairaudit.measures.ratios import Ratio
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import Label, LabelLike, names
from fairaudit.words import WHOEVER, brief

if TYPE_CHECKING:
    from fairaudit.theorems.t15 import Block
    from fairaudit.theorems.t15_assignments import Assignment


__all__ = ["Levels", "Reached", "Share", "Tips", "Whoever", "ask_shares", "judged_whoever", "refuse_beside_unknown_groups", "whoever"]

MOST_STEPS = 20_000
"""How many assignments of a context are gone through for its least ratio."""

TRIED = 8  # contexts whose assignments are gone through, one after the other

OTHERS = "*"
"""Stands for all who are of none of the groups, where shares are named."""


@dataclass(frozen=True)
class Share:
    """Between which shares of the unknown decisions are of a group, or, if that is None, of none of the groups; declared."""

    group: int | None
    low: Fraction
    high: Fraction


@dataclass(frozen=True)
class Place:
    """Two groups in a context, or over all of them, as indices."""

    context: int | None
    higher: int
    lower: int


@dataclass(frozen=True)
class Levels:
    """In a context, or over all of them, no assignment has a greater least mean than `low` and a smaller greatest mean than `high`."""

    context: int | None
    low: Fraction
    high: Fraction


@dataclass(frozen=True)
class Reached:
    """An assignment under which no ratio is greater than this: for the contexts that need one, values and how many each group receives."""

    ratio: Extended
    assigned: tuple[tuple[int | None, tuple[Fraction, ...], Assignment], ...]


@brief
@dataclass(frozen=True, repr=False)
class Whoever:
    """Between which ends a ratio lies, whoever the decisions of unknown group are.

    Attributes
    ----------
    quantity : {"local", "global"}
        Of which ratio.
    unknown : int
        How many decisions have no recorded group.
    of : int
        Of how many.
    greatest : Fraction or float
        The greatest ratio, which is attained.
    place : Place
        Where.
    received : tuple of int
        How many unknown decisions the two groups receive there: the first those that are worth most, the second those that are worth least.
    least : Fraction or float
        No assignment has a smaller ratio than this.
    proof : Place, Levels, int or None
        What shows that: two groups that are so far apart in all assignments, how far all groups can be levelled, or a context all of whose
        assignments were gone through (−1 for all contexts together); None where it is 1.
    reached : Reached or None
        The assignment with the smallest ratio that was found.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m", "?", "?"], "n": [3, 1, 2, 2, 1, 1]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", unknown=["?"])
    >>> result.whoever[0].greatest, result.whoever[0].reached.ratio
    (Fraction(2, 1), Fraction(1, 1))
    """

    quantity: Quantity
    unknown: int
    of: int
    greatest: Extended
    place: Place
    received: tuple[int, int]
    least: Extended
    proof: Place | Levels | int | None
    reached: Reached | None


@dataclass(frozen=True)
class Tips:
    """For how many unknown decisions the verdict on those with a group stands, whoever they are: one more could change it.

    Where the verdict is "exceeds", more may be needed: so many by the pair that is named.
    """

    labelled: Literal["within", "exceeds"]
    rows: int
    place: Place


def ask_shares(given: Mapping[LabelLike | Label, Sequence[Number]], law: Law) -> tuple[Share, ...]:
    """Read declared shares of the unknown decisions.

    Raises
    ------
    InputError
        If there is no such group, shares are not between 0 and 1, or they cannot all hold.
    """
    found: dict[int | None, Share] = {}
    if OTHERS in given and (OTHERS,) in law.groups:
        raise InputError("'*' stands for none of the groups where shares are named, and a group has this label; map it to another one")
    for label, ends in given.items():
        parts = label.split("/") if isinstance(label, str) and len(law.columns.group) > 1 else label
        name = OTHERS if label == OTHERS else names(parts)  # type: ignore[arg-type]
        if name != OTHERS and name not in law.groups:
            known = [", ".join(group) for group in law.groups]
            raise InputError(
                f"the share of unknown groups names {shown(', '.join(name))}, which is no group; {nearest(', '.join(name), known)}"
            )
        if isinstance(ends, str) or len(ends) != 2:
            raise InputError(f"the share of {shown(', '.join(name))} among unknown groups needs two numbers, such as 0.4 and 0.6")
        low, high = (Fraction(*option_value(end)) for end in ends)
        if not 0 <= low <= high <= 1:
            raise InputError(
                f"the share of {shown(', '.join(name))} among unknown groups is from {low} to {high}; it must rise, from 0 to 1"
            )
        place = None if name == OTHERS else law.groups.index(name)
        found[place] = Share(place, low, high)
    shares = tuple(sorted(found.values(), key=lambda share: len(law.groups) if share.group is None else share.group))
    if sum(share.low for share in shares) > 1:
        raise InputError("the least shares of the unknown groups add up to more than 1; nobody could be assigned so")
    if len(shares) == len(law.groups) + 1 and sum(share.high for share in shares) < 1:
        raise InputError("the greatest shares of the unknown groups add up to less than 1; nobody could be assigned so")
    return shares


def refuse_beside_unknown_groups(law: Law, *, difference: bool, drift: bool) -> None:
    """Refuse differences of expectations, and a second objection, where groups are unknown.

    Raises
    ------
    InputError
        If one is asked for.
    """
    if drift and law.unknown is not None:
        raise InputError("unknown groups do not go with max_drift (--max-drift): one objection at a time; leave one of them out")
    if difference and law.unknown is not None:
        raise InputError("unknown groups go with ratios: differences (difference, max_difference) are not stated of them; leave these out")


@dataclass(frozen=True)
class _Blocks:
    """What is compared, with its unknown rows."""

    law: Law
    utility: UtilityTable
    shares: tuple[Share, ...]

    @cached_property
    def weights(self) -> list[list[int]]:
        return [[w // self.law.scale for w in row] for row in self.law.weights.tolist()]

    @cached_property
    def sums(self) -> list[int]:
        gains = self.utility.values.tolist()
        rows = [gains] * len(self.weights) if self.utility.by_decision else gains
        return [sum(w * g for w, g in zip(row, own, strict=True)) for row, own in zip(self.weights, rows, strict=True)]

    @cached_property
    def unknown(self) -> dict[int, dict[int, int]]:
        """For each context that has unknown rows how many there are of each utility."""
        found: dict[int, dict[int, int]] = {}
        held = self.law.unknown
        for place, (x, row) in enumerate(zip(held.contexts.tolist(), held.weights.tolist(), strict=True) if held else ()):
            gains = self.utility.values.tolist() if self.utility.by_decision else self.utility.unknown[place]
            for weight, gain in zip(row, gains, strict=True):
                if weight:
                    own = found.setdefault(x, {})
                    own[gain or 0] = own.get(gain or 0, 0) + weight // self.law.scale
        return found

    def block(self, groups: Sequence[int], counts: Sequence[int], sums: Sequence[int], rows: Mapping[int, int]) -> Block:
        """Groups that are compared, and unknown rows."""
        from fairaudit.theorems.t15 import Block

        total = sum(rows.values())
        limits = {share.group: (floor(share.low * total), ceil(share.high * total)) for share in self.shares}
        away = [limits.get(group, (0, total)) for group in (*(set(range(len(self.law.groups))) - set(groups)), None)]
        own = [limits.get(group, (0, total)) for group in groups]
        values = sorted(rows, reverse=True)
        return Block(
            tuple(counts),
            tuple(sums),
            tuple(values),
            tuple(rows[value] for value in values),
            tuple(low for low, _ in own),
            tuple(high for _, high in own),
            (sum(low for low, _ in away), min(total, sum(high for _, high in away))),
        )

    def local(self) -> Iterator[tuple[int, tuple[int, ...], Block]]:
        """Each context that is compared and has unknown rows: its groups, and the block."""
        for x, rows in self.unknown.items():
            first, last = np.searchsorted(self.law.cell_context, [x, x + 1]).tolist()
            if last - first > 1:
                groups = tuple(self.law.cell_group[first:last].tolist())
                yield x, groups, self.block(groups, [*map(sum, self.weights[first:last])], self.sums[first:last], rows)

    def overall(self) -> tuple[tuple[int, ...], Block]:
        """All contexts together."""
        counts, sums = dict.fromkeys(self.law.global_groups, 0), dict.fromkeys(self.law.global_groups, 0)
        for group, row, total in zip(self.law.cell_group.tolist(), self.weights, self.sums, strict=True):
            if group in counts:
                counts[group], sums[group] = counts[group] + sum(row), sums[group] + total
        rows: dict[int, int] = {}
        for own in self.unknown.values():
            for value, number in own.items():
                rows[value] = rows.get(value, 0) + number
        return tuple(counts), self.block([*counts], [*counts.values()], [*sums.values()], rows)

    def elsewhere(self) -> tuple[Extended, Place] | None:
        """The greatest ratio within contexts without unknown rows, and where it is."""
        found: tuple[Extended, Place] | None = None
        starts = self.law.starts.tolist()
        for first, last in pairwise(starts):
            x = int(self.law.cell_context[first])
            if last - first > 1 and x not in self.unknown:
                means = [Fraction(self.sums[i], sum(self.weights[i])) for i in range(first, last)]
                ratio = quotient(max(means), min(means))
                if found is None or ratio > found[0]:
                    high, low = means.index(max(means)), means.index(min(means))
                    low = low if low != high else 1
                    found = ratio, Place(x, int(self.law.cell_group[first + high]), int(self.law.cell_group[first + low]))
        return found


def whoever(law: Law, utility: UtilityTable, measured: Mapping[Quantity, Ratio | None], shares: tuple[Share, ...]) -> tuple[Whoever, ...]:
    """Find between which ends the ratios lie, whoever the decisions of unknown group are.

    Raises
    ------
    InputError
        If counts are not whole.
    """
    if law.unknown is None:
        return ()
    unknown = int(law.unknown.weights.sum()) // law.scale
    if not law.whole or any(w % law.scale for w in law.unknown.weights.ravel().tolist()) or unknown > 10**18:
        raise InputError(
            "unknown groups need whole counts of at most 10^18: each unknown decision belongs to one group, and weights to several"
        )
    blocks = _Blocks(law, utility, shares)
    of = unknown + sum(map(sum, blocks.weights))
    found = []
    if measured["local"] is not None:
        found.append(_local(blocks, unknown, of))
    if measured["global"] is not None:
        groups, block = blocks.overall()
        found.append(_range("global", {None: (groups, block)}, None, (unknown, of, utility.scale)))
    return tuple(found)


def _local(blocks: _Blocks, unknown: int, of: int) -> Whoever:
    held: dict[int | None, tuple[tuple[int, ...], Block]] = {x: (groups, block) for x, groups, block in blocks.local()}
    return _range("local", held, blocks.elsewhere(), (unknown, of, blocks.utility.scale))


def _range(
    quantity: Quantity,
    blocks: Mapping[int | None, tuple[tuple[int, ...], Block]],
    elsewhere: tuple[Extended, Place] | None,
    amounts: tuple[int, int, int],
) -> Whoever:
    """Both ends of a ratio, the greatest of those of its blocks."""
    from fairaudit.theorems.t15 import greatest

    unknown, of, scale = amounts
    tops = {x: pair for x, (_, block) in blocks.items() if (pair := greatest(block)) is not None}
    high = max(((pair.ratio, x) for x, pair in tops.items()), default=None, key=lambda one: one[0])
    if elsewhere is not None and (high is None or elsewhere[0] >= high[0]):
        ratio, place, received = *elsewhere, (0, 0)
    elif high is not None:
        pair, groups = tops[high[1]], blocks[high[1]][0]
        ratio, place, received = pair.ratio, Place(high[1], groups[pair.higher], groups[pair.lower]), pair.received
    else:
        raise AssertionError
    least, proof, reached = _least(blocks, {x: pair.ratio for x, pair in tops.items()}, elsewhere, scale)
    return Whoever(quantity, unknown, of, ratio, place, received, least, proof, reached)


def _least(
    blocks: Mapping[int | None, tuple[tuple[int, ...], Block]],
    tops: Mapping[int | None, Extended],
    elsewhere: tuple[Extended, Place] | None,
    scale: int,
) -> tuple[Extended, Place | Levels | int | None, Reached | None]:
    """A lower end, what proves it, and the assignment with the smallest ratio that was found."""
    from fairaudit.theorems.t15 import least_apart, levels
    from fairaudit.theorems.t15_assignments import least_of_all, levelled

    floor_ = Fraction(1) if elsewhere is None else elsewhere[0]
    least: Extended = floor_
    proof: Place | Levels | int | None = None if elsewhere is None or floor_ == 1 else elsewhere[1]
    found: dict[int | None, tuple[Extended, Assignment]] = {}
    lacking = False
    bound = floor_
    for x in sorted(tops, key=lambda x: tops[x], reverse=True):
        groups, block = blocks[x]
        if tops[x] <= bound:
            break
        apart = least_apart(block)
        if apart is not None and apart.ratio > least:
            least, proof = apart.ratio, Place(x, groups[apart.higher], groups[apart.lower])
        if len(groups) > 2:
            low, high = levels(block)
            if (ends := quotient(high, low)) > least:
                least, proof = ends, Levels(x, low / scale, high / scale)
        level = levelled(block)
        if level is None:
            lacking = True
            continue
        found[x] = level
        bound = max(bound, level[0])
    for _ in range(TRIED):
        last = max(found, default=None, key=lambda x: found[x][0])
        if lacking or not found or found[last][0] <= least:
            break
        exact = least_of_all(blocks[last][1], MOST_STEPS)
        if exact is None:
            break
        found[last] = exact
        if exact[0] > least:
            least, proof = exact[0], -1 if last is None else last
    if lacking:
        return least, proof, None
    ratio = max([floor_, *(level for level, _ in found.values())])
    return least, proof, _reached(blocks, tops, found, ratio, scale)


def _reached(
    blocks: Mapping[int | None, tuple[tuple[int, ...], Block]],
    tops: Mapping[int | None, Extended],
    found: Mapping[int | None, tuple[Extended, Assignment]],
    ratio: Extended,
    scale: int,
) -> Reached | None:
    """The assignment of those contexts that could have a greater ratio; None if one of them has none."""
    from fairaudit.theorems.t15_assignments import levelled

    assigned = []
    levels = {x: found.get(x) or levelled(blocks[x][1]) for x in tops if tops[x] > ratio}
    if None in levels.values():
        return None
    ratio = max([ratio, *(level[0] for level in levels.values() if level is not None)])
    for x in sorted((x for x in levels if tops[x] > ratio), key=lambda x: -1 if x is None else x):
        level, block = levels[x], blocks[x][1]
        if level is None:
            raise AssertionError
        used = [i for i, row in enumerate(level[1]) if any(row)]
        assigned.append((x, tuple(Fraction(block.values[i], scale) for i in used), tuple(level[1][i] for i in used)))
    return Reached(ratio, tuple(assigned))


def judged_whoever(
    found: Sequence[Whoever], limits: Sequence[Limit], law: Law, utility: UtilityTable, measured: Mapping[Quantity, Ratio | None]
) -> tuple[Target, ...]:
    """Judge limits of this table, whoever the decisions of unknown group are."""
    ends = {one.quantity: one for one in found}
    targets = []
    for quantity, unit, limit in limits:
        own = ends.get(quantity)
        verdict = "inconclusive" if own is None else _verdict(own, limit, unit)
        tips = None
        labelled = measured[quantity]
        if verdict in ("depends", "inconclusive") and labelled is not None and unit == "ratio":
            tips = _tips(law, utility, quantity, limit, labelled)
        targets.append(Target(quantity, limit, unit, verdict, under=WHOEVER, tips=tips))
    return tuple(targets)


def _verdict(own: Whoever, limit: Fraction, unit: str) -> Verdict:
    """Within or exceeds where every assignment is, depends where some is and some is not."""
    if _at_most(own.greatest, limit, unit):
        return "within"
    if not _at_most(own.least, limit, unit):
        return "exceeds"
    return "depends" if own.reached is not None and _at_most(own.reached.ratio, limit, unit) else "inconclusive"


def _at_most(value: Extended, limit: Fraction, unit: str) -> bool:
    if unit == "ratio" or value == inf:
        return value <= limit
    return compare_log(extended_pair(value), (limit.numerator, limit.denominator)) <= 0


def _tips(law: Law, utility: UtilityTable, quantity: Quantity, limit: Fraction, labelled: Ratio) -> Tips | None:
    """How many unknown decisions it takes at least to change the verdict on the labelled ones, without limits on who they are."""
    from fairaudit.theorems.t15 import greatest, rows_until_above, rows_until_below

    blocks = _Blocks(law, utility, ())
    held: list[tuple[int | None, tuple[int, ...], Block]] = [*blocks.local()] if quantity == "local" else [(None, *blocks.overall())]
    best: tuple[int, Place] | None = None
    exceeds = labelled.ratio > limit
    for x, groups, block in held:
        if exceeds:
            needed = rows_until_below(block, limit)
            if needed is not None and needed[0] and (best is None or needed[0] > best[0]):
                best = needed[0], Place(x, groups[needed[1].higher], groups[needed[1].lower])
            continue
        rows = rows_until_above(block, limit, None if best is None else best[0])
        if rows is not None:
            pair = greatest(block.freely(rows))
            if pair is not None:
                best = rows, Place(x, groups[pair.higher], groups[pair.lower])
    return None if best is None else Tips("exceeds" if exceeds else "within", best[0] - 1, best[1])
