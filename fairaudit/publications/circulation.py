"""Which counts of linked tables may be published so that no small one can be computed: decided in whole numbers, by flows.

A count is small if it is below a given least one, 0 included: a rate of 0 % or 100 % says of everybody in a group what happened to them.  A
group is published whole (everybody, those selected, the rate) or not at all, and every group that is not bears the same mark: two marks
would say which of them is the small one.

A table with its margins is a circulation: from a node ``all`` to the rows, from there through the cells to the columns, and back.  Every
count is what one arc carries, and whoever knows the published ones knows that the others are whole numbers of at least 0 that make a
circulation with them, and no more.  What an arc can carry then is an interval of whole numbers, both ends of which maximum flows
find exactly.  So it is decided, not estimated, that of each count that is not published the figures say either that it is not small, or
nothing below the least one.  This is asked of large counts, too: else whoever knows that small ones are open would know of a count which
must be 4 or more that it is not small, and with that more of the others.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

__all__ = ["LEAST", "Arc", "Parts", "is_small", "published"]

LEAST = 10
"""The count below which a table that is published whole is remarked on."""

Parts = tuple[int, ...]
"""How many people of a group there are of each kind."""

Name = TypeVar("Name", bound=Hashable)
"""Of a group, whatever tells it from the others."""


@dataclass(frozen=True)
class Arc:
    """A group of people who are counted, as an arc of the circulation.

    Attributes
    ----------
    tail, head : hashable
        The nodes that it leads from and to: for a cell of a table its row and its column, for a margin ``all`` and a row, or a column and
        ``all``.
    parts : tuple of int
        How many of them there are of each kind, such as those selected and those not; every arc has the same kinds.
    """

    tail: Hashable
    head: Hashable
    parts: Parts


def is_small(parts: Iterable[int | Fraction], least: int) -> bool:
    """Whether some count of a group is below the least one: those selected, those not, or all.

    Examples
    --------
    >>> is_small((12, 30), 10), is_small((12, 9), 10), is_small((0, 30), 10)
    (False, True, True)
    """
    return any(part < least for part in parts)


def published(arcs: Mapping[Name, Arc], order: Sequence[Name], least: int) -> frozenset[Name]:
    """Which groups may be published, those first that come first.

    All are if no count is small.  Otherwise a group is published if none of its counts is small, and if with those before it every count
    that is not published is known not to be small, or could still be anything from 0 to ``least - 1``.

    Parameters
    ----------
    arcs : mapping of name to Arc
        All groups whose counts are linked, those that nobody means to publish, too: as much flows into each node as out of it.
    order : sequence of names
        Those that are to be published, the most important first.
    least : int
        The least count that is not small.

    Returns
    -------
    frozenset of names
        Those that may be published, together.

    Examples
    --------
    A table of two rows and two columns with one small cell: beside its margins, none of its cells may be published.

    >>> cells = {"fa": Arc("f", "a", (40, 30)), "fb": Arc("f", "b", (20, 3)), "ma": Arc("m", "a", (50, 40)), "mb": Arc("m", "b", (60, 70))}
    >>> rows = {"f": Arc("all", "f", (60, 33)), "m": Arc("all", "m", (110, 110))}
    >>> columns = {"a": Arc("a", "all", (90, 70)), "b": Arc("b", "all", (80, 73))}
    >>> sorted(published(rows | columns | cells, ["f", "m", "a", "b", "mb", "ma", "fa", "fb"], 10))
    ['a', 'b', 'f', 'm']
    """
    _check(arcs)
    if not any(is_small(arc.parts, least) for arc in arcs.values()):
        return frozenset(order)
    kinds = range(max((len(arc.parts) for arc in arcs.values()), default=0))
    chosen: frozenset[Name] = frozenset()
    ways: list[dict[Name, Ways]] = [{} for _ in kinds]
    for name in order:
        if not is_small(arcs[name].parts, least) and all(_is_open(arcs, chosen, name, kind, least, ways[kind]) for kind in kinds):
            chosen |= {name}
    return chosen


def _check(arcs: Mapping[Name, Arc]) -> None:
    """Refuse what is no circulation: a margin that is absent would be taken for one that everybody knows to be 0."""
    over: dict[Hashable, list[int]] = {}
    for arc in arcs.values():
        for node, sign in ((arc.tail, -1), (arc.head, 1)):
            sums = over.setdefault(node, [0] * len(arc.parts))
            for kind, part in enumerate(arc.parts):
                sums[kind] += sign * part
    for node, sums in over.items():
        if any(sums):
            raise ValueError(f"what flows into {node!r} does not flow out: {sums}")


Ways = frozenset[tuple[Hashable, Hashable]]
"""The pairs of nodes between which something moves, to show how much a count can change."""


def _is_open(arcs: Mapping[Name, Arc], known: frozenset[Name], new: Name, kind: int, least: int, ways: dict[Name, Ways]) -> bool:
    """Whether, with a new one known, every other count of a kind is known not to be small, or could be anything small.

    The ways that show the second are kept: they show it again as long as none of them leads over an arc that has become known since.
    """
    known |= {new}
    room = _room(arcs, known, kind)
    closed = {(arcs[new].tail, arcs[new].head), (arcs[new].head, arcs[new].tail)}
    for name, arc in arcs.items():
        if name in known or (name in ways and not closed & ways[name]):
            continue
        low, high, used = _range(room, arc, arc.parts[kind], least - 1)
        if low < least and (low or high < least - 1):
            return False
        if not low:
            ways[name] = used
    return True


Room = dict[Hashable, dict[Hashable, int]]
"""By how much the counts between two nodes can change together: forwards by as much as you like, backwards by what there is."""

LIMITLESS = 1 << 200


def _room(arcs: Mapping[Name, Arc], known: frozenset[Name], kind: int) -> Room:
    room: Room = {}
    for name, arc in arcs.items():
        forth, back = room.setdefault(arc.tail, {}), room.setdefault(arc.head, {})
        if name not in known:
            forth[arc.head] = forth.get(arc.head, 0) + LIMITLESS
            back[arc.tail] = back.get(arc.tail, 0) + arc.parts[kind]
    return room


def _range(room: Room, arc: Arc, now: int, most: int) -> tuple[int, int, Ways]:
    """What the count of an arc that is not published can be, up to `most`, and what moves to reach its ends; nothing is changed in the end.

    It can be every whole number between both: moving one of a kind along a cycle of groups that are not published gives the next.
    """
    room[arc.tail][arc.head] -= LIMITLESS
    room[arc.head][arc.tail] -= now
    less, down = _flow(room, arc.tail, arc.head, now)
    more, up = _flow(room, arc.head, arc.tail, max(most - now, 0))
    room[arc.tail][arc.head] += LIMITLESS
    room[arc.head][arc.tail] += now
    return now - less, now + more, down | up


def _flow(room: Room, source: Hashable, sink: Hashable, wanted: int) -> tuple[int, Ways]:
    """How much of what is wanted can flow, along shortest ways, and over what; nothing is changed in the end."""
    found, ways = 0, []
    while found < wanted:
        way = _way(room, source, sink)
        if not way:
            break
        much = min(wanted - found, *(room[a][b] for a, b in way))
        _push(room, way, much)
        ways.append((way, much))
        found += much
    for way, much in ways:
        _push(room, way, -much)
    return found, frozenset(pair for way, _ in ways for pair in way)


def _push(room: Room, way: list[tuple[Hashable, Hashable]], much: int) -> None:
    for a, b in way:
        room[a][b] -= much
        room[b][a] = room[b].get(a, 0) + much


def _way(room: Room, source: Hashable, sink: Hashable) -> list[tuple[Hashable, Hashable]]:
    """A shortest way on which something can still flow; empty if there is none."""
    before: dict[Hashable, Hashable] = {source: source}
    waiting = deque([source])
    while waiting and sink not in before:
        node = waiting.popleft()
        for to, open_ in room[node].items():
            if open_ and to not in before:
                before[to] = node
                waiting.append(to)
    if sink not in before:
        return []
    way = []
    while sink != source:
        way.append((before[sink], sink))
        sink = before[sink]
    return way[::-1]
