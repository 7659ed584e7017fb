"""Who of several candidates was chosen: position and profile effects of an allocation, apart (theorem T10).

Each run shows n candidates in n slots, and one of them is chosen. What a slot gains by being first is one thing, what a person gains by
a name is another; the two are measured as two laws whose decisions are ``chosen`` and ``not chosen``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import comb, exp, factorial, log, log1p
from typing import Any

import numpy as np

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.model.law import Law
from fairaudit.tables.label_text import label_text
from fairaudit.tables.sources import Table
from fairaudit.tables.tally import counted
from fairaudit.tables.values import Locate, column, encode, locator, names
from fairaudit.words import brief

__all__ = ["Allocation", "read_allocation"]


CHOSEN, NOT_CHOSEN = "chosen", "not chosen"

FALSE_ALARM = 1 / 1000  # chance of the note about orders where orders were drawn evenly

FEW_ORDERS = 5_040  # the orders of seven candidates: up to here ways are counted exactly, beyond by a bound


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Allocation:
    """Position and profile effects of a table of choices.

    Attributes
    ----------
    position : Law
        Groups are slots (``1`` is the first): the chance of a slot to be chosen, whoever stands in it.
    profile : Law
        Groups are profiles: the chance of a profile to be chosen, averaged over the slots that it stood in.
    profile_by_position : Law
        The same within each slot: contexts are the context columns and the slot.
    runs : int
        Number of choices.
    slots : int
        Candidates per choice.
    imbalance : Fraction
        Greatest difference, over profiles and slots, between the share of a profile's runs in which it stood in the slot and 1/n: 0 for
        perfect counterbalancing, about 1 when slots were fixed.
    warnings : tuple of str
        What stands against reading the profile effect as one of the profile, and against a uniformly random order, which T10 needs. A
        log whose orders are drawn so gets a warning of the latter kind with probability at most 1/1,000.

    Examples
    --------
    >>> import fairaudit as fa
    >>> log = {"shown": ["ann bob", "bob ann"], "chosen": ["ann", "bob"]}
    >>> found = fa.read_allocation(log, slots="shown", winner="chosen")
    >>> found.runs, found.slots, found.position.groups
    (2, 2, (('1',), ('2',)))
    """

    position: Law
    profile: Law
    profile_by_position: Law
    runs: int
    slots: int
    imbalance: Fraction
    warnings: tuple[str, ...]


@answered
def read_allocation(
    table: Table, *, slots: str | Sequence[str], winner: str, context: str | Sequence[str] | None = None, separator: str | None = None
) -> Allocation:
    """Read a table with one choice per row. The order of its rows changes nothing.

    Parameters
    ----------
    table : DataFrame, mapping of str to sequence, CsvTable, or Tally
        The table; `read_log` gives the Tally of files of any size and of databases.
    slots : str or sequence of str
        One column for each slot, in order, holding the profile in it; or a single column that lists the profiles in order.
    winner : str
        Column of the profile that was chosen; where it lists several (a ranking), the first counts.
    context : str or sequence of str, optional
        Context columns.
    separator : str, optional
        What separates profiles in a list; blanks by default.

    Returns
    -------
    Allocation
        The effects.

    Raises
    ------
    InputError
        If a row lists fewer than two profiles, one twice, another number than the first row, or a winner that was not shown.

    Examples
    --------
    >>> runs = {"shown": ["ann bob", "bob ann", "ann bob", "bob ann"], "won": ["ann", "bob", "ann", "ann"]}
    >>> found = read_allocation(runs, slots="shown", winner="won")
    >>> found.position.weights.tolist(), found.profile.weights.tolist()
    ([[3, 1], [1, 3]], [[3, 1], [1, 3]])
    """
    where = locator(table)
    slot_columns, contexts = names(slots), names(context)
    if not slot_columns:
        raise InputError("no slot column was named; name one for each slot, or one that lists the candidates in order")
    lists = {name: column(table, name) for name in (*slot_columns, winner, *contexts)}
    counts = counted(table, len(lists[winner])).tolist()
    if not counts:
        raise InputError("the table has no rows")
    labels = [_labels(lists[name], name, where) for name in contexts]
    position: Counter[tuple[Any, ...]] = Counter()
    profile: Counter[tuple[Any, ...]] = Counter()
    by_position: Counter[tuple[Any, ...]] = Counter()
    orders: Counter[tuple[tuple[str, ...], tuple[str, ...]]] = Counter()
    stood: Counter[tuple[str, int]] = Counter()
    size = 0
    for i, count in enumerate(counts):
        order = _order([lists[name][i] for name in slot_columns], separator, f"column {shown(slot_columns[0])}, {where(i)}")
        size = size or len(order)
        if len(order) != size:
            raise InputError(
                f"{where(i)}: {len(order)} candidates are listed where another row has {size}; every choice has the same number"
            )
        chosen = _order([lists[winner][i]], separator, f"column {shown(winner)}, {where(i)}", least=1)[0]
        if chosen not in order:
            raise InputError(
                f"column {shown(winner)}, {where(i)}: {shown(chosen)} was chosen but is not among the candidates {shown(order)}"
            )
        x = tuple(texts[i] for texts in labels)
        orders[x, tuple(order)] += count
        for slot, person in enumerate(order, 1):
            decision = CHOSEN if person == chosen else NOT_CHOSEN
            position[(*x, slot, decision)] += count
            profile[(*x, person, decision)] += count
            by_position[(*x, slot, person, decision)] += count
            stood[person, slot] += count
    appearances: Counter[str] = Counter()
    for (person, _), count in stood.items():
        appearances[person] += count
    imbalance = max(
        abs(Fraction(stood[person, slot], appearances[person]) - Fraction(1, size)) for person in appearances for slot in range(1, size + 1)
    )
    return Allocation(
        position=_law(position, "slot", contexts),
        profile=_law(profile, "profile", contexts),
        profile_by_position=_law(by_position, "profile", (*contexts, "slot")),
        runs=sum(counts),
        slots=size,
        imbalance=imbalance,
        warnings=(*_warnings(stood, appearances, size, imbalance), *_order_warnings(orders, size)),
    )


def _labels(values: list[Any], name: str, where: Locate) -> list[str]:
    """Labels of a context column, none of which is missing."""
    codes, texts = encode(values, name, where)
    if len(absent := np.flatnonzero(codes < 0)):
        raise InputError(f"column {shown(name)}, {where(int(absent[0]))}: the label is missing; fill it in, or leave the row out")
    return [texts[code] for code in codes.tolist()]


def _order(cells: list[Any], separator: str | None, where: str, least: int = 2) -> list[str]:
    texts = [label_text(cell) for cell in cells]
    if any(text is None for text in texts):
        raise InputError(f"{where}: a candidate is missing")
    listed = [text for text in texts if text is not None]
    if len(listed) == 1:
        listed = [part.strip() for part in listed[0].split(separator) if part.strip()]
    if len(listed) < least:
        raise InputError(f"{where}: {shown(cells)} does not list {'two candidates or more' if least > 1 else 'a candidate'}")
    if len(set(listed)) != len(listed):
        raise InputError(f"{where}: {shown(cells)} lists a candidate twice")
    return listed


def _law(counts: Counter[tuple[Any, ...]], group: str, contexts: tuple[str, ...]) -> Law:
    keys = sorted(counts)  # slots are numbers here, so that the second comes before the tenth
    columns: dict[str, list[Any]] = {name: [str(key[i]) for key in keys] for i, name in enumerate((*contexts, group, "decision"))}
    columns["count"] = [counts[key] for key in keys]
    if len(columns) != len(contexts) + 3:
        raise InputError(f"a context column is named {group}, decision or count, which the effects use themselves; rename it")
    return Law.from_counts(columns, decision="decision", group=group, context=contexts, count="count")


def _warnings(stood: Counter[tuple[str, int]], appearances: Counter[str], size: int, imbalance: Fraction) -> list[str]:
    fixed = [person for person in appearances if max(stood[person, slot] for slot in range(1, size + 1)) == appearances[person]]
    if len(fixed) == len(appearances):
        said = "every profile always stood in the same slot: position and profile effects cannot be told apart, and no bound for a "
        return [f"{said}random order applies; draw the order at random"]
    found = []
    if fixed:
        found.append(
            f"{len(fixed)} of {len(appearances)} profiles always stood in the same slot; their effect is mixed with that of the slot"
        )
    # Under a uniformly random order a share of r runs strays from 1/n by more than 5 standard deviations about once in a million.
    strayed = [
        person
        for person, runs in appearances.items()
        for slot in range(1, size + 1)
        if (stood[person, slot] * size - runs) ** 2 > 25 * runs * (size - 1)
    ]
    if strayed and not fixed:
        found.append(
            f"the order was not balanced: a profile stood in a slot {float(imbalance):.0%} more or less often than 1 in {size}; "
            "the profile effect may be mixed with that of the slot"
        )
    return found


def _order_warnings(orders: Counter[tuple[tuple[str, ...], tuple[str, ...]]], size: int) -> list[str]:
    """Whether some orders of the candidates came too seldom, or too often, for orders drawn uniformly from all n!.

    Looked at are the runs of each context, and those of them that showed the same candidates; where candidates differ, an order is that
    of their names. In N uniform draws from n! orders

    * at most D different ones come with probability at most C(n!, D)·(D/n!)^N, and C(n!, D) is at most (e·n!/D)^D;
    * one of them comes as often as c times (or as seldom) with probability at most n!·e^(−N·KL(c/N, 1/n!)).
    """
    pools: dict[Any, Counter[tuple[Any, ...]]] = {}
    for (x, order), count in orders.items():
        place = {person: k for k, person in enumerate(sorted(order))}
        pattern = tuple(place[person] for person in order)
        for pool in ((x, frozenset(order)), (x,)):
            pools.setdefault(pool, Counter())[pattern] += count
    worst = min(((_order_probability(counts, factorial(size)), counts) for counts in pools.values()), key=lambda found: found[0])
    if worst[0] > log(FALSE_ALARM / (3 * len(pools))):
        return []
    counts = worst[1]
    missing = factorial(size) - len(counts)
    said = f"{len(counts)} of the {factorial(size)} orders occurred" if missing else f"one came {max(counts.values())} times"
    where = f"{said} in {sum(counts.values())} runs{' of one context' if len({pool[0] for pool in pools}) > 1 else ''}"
    return [f"the order of the candidates was not drawn uniformly from all orders: {where}; no bound for a random order applies"]


def _order_probability(counts: Counter[tuple[Any, ...]], possible: int) -> float:
    """Logarithm of a bound on the probability of orders that are as few, or as uneven, as these."""
    runs, different = sum(counts.values()), len(counts)
    ways = log(comb(possible, different)) if possible <= FEW_ORDERS else different * (1 + log(possible) - log(different))
    few = ways + runs * (log(different) - log(possible))
    extremes = [max(counts.values()), min(counts.values()) if different == possible else 0]
    return min(few, *(log(possible) - runs * _divergence(count / runs, log(possible)) for count in extremes))


def _divergence(p: float, surprise: float) -> float:
    """Relative entropy of a coin of probability p to one of probability e^(−surprise), in nats."""
    ends = (p * (log(p) + surprise) if p else 0.0, (1 - p) * (log1p(-p) - log1p(-exp(-surprise))) if p < 1 else 0.0)
    return sum(ends)
