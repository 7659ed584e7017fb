"""Of which groups decisions were left out before a log was counted: as stated, and against the table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from .header import Header
from .json_values import Labels, read_list, read_object, read_strings
from .rationals import ZERO, Rational, at_most, read_rational, sum_of
from .table import Table
from .text import malformed, shown

SAID = 6  # groups that are named


class LeftOutOf(NamedTuple):
    """How many decisions (or rows) of a group were left out, and of how many."""

    group: Labels
    amount: Rational
    of: Rational


class Groups(NamedTuple):
    """The columns of groups, their labels, how many decisions each has if that is known, and whether some have none of them."""

    columns: Labels
    labels: frozenset[Labels]
    amounts: Mapping[Labels, Rational] | None
    unlabelled: bool


def read_amount(value: object, where: str, unit: str) -> Rational:
    """Read how many decisions, rows or lines something is about."""
    amount = read_rational(value, where, nonnegative=True)
    if amount[0] == 0 or (unit != "decisions" and amount[1] != 1):
        raise malformed(where, f"must be {'positive' if unit == 'decisions' else 'a positive integer'}, not {shown(amount)}")
    return amount


def read_groups(value: object, where: str, unit: str, width: int) -> tuple[LeftOutOf, ...]:
    """Read of which groups decisions were left out: in the order of their labels, each once."""
    found = []
    for i, item in enumerate(read_list(value, where)):
        place = f"{where}[{i}]"
        members = read_object(item, place, ("group", unit, "of"))
        label = read_strings(members["group"], f"{place}.group")
        amount, of = (read_amount(members[key], f"{place}.{key}", unit) for key in (unit, "of"))
        if len(label) != width:
            raise malformed(f"{place}.group", f"must have {width} labels")
        if not at_most(amount, of):
            raise malformed(place, "leaves out more than there is")
        found.append(LeftOutOf(label, amount, of))
    if any(one.group >= other.group for one, other in pairwise(found)):
        raise malformed(where, "must list groups in the order of their labels, each once")
    return tuple(found)


def fault_of_groups(amount: Rational, columns: Iterable[tuple[str, Rational]], listed: Sequence[LeftOutOf], known: Groups) -> str:
    """Say why decisions cannot have been left out of these groups: what is left is in the table, what is of no group lacks a label."""
    for own in listed:
        left = sum_of([own.of, (-own.amount[0], own.amount[1])])
        there = known.amounts.get(own.group, ZERO) if known.amounts is not None else None
        if there is None and own.group not in known.labels and left[0]:
            return f"the table has no group {shown(list(own.group))}"
        if there is not None and left != there:
            return f"the table gives {shown(there)} of the group {shown(list(own.group))}"
    rest = sum_of([amount, *((-own.amount[0], own.amount[1]) for own in listed)])
    without = [missing for column, missing in columns if column in known.columns]
    if not all(at_most(missing, rest) for missing in [ZERO, *without]):
        return "more decisions are of groups than have a label in all of their columns"
    if not known.unlabelled and not at_most(rest, sum_of([ZERO, *without])):
        return "fewer decisions are of groups than have a label in all of their columns"
    return ""


def groups_of(table: Table, header: Header) -> Groups:
    """What the table shows of its groups: how many decisions each has, where they are counted by true cells."""
    columns = header.subject.columns.group
    amounts = None
    if header.subject.kind == "counts":
        figures = table.figures
        amounts = dict(zip([header.groups[a] for a in figures.populated()], figures.masses(), strict=True))
    return Groups(columns, frozenset(header.groups), amounts, header.unknown)


def left_out_by_group(listed: Iterable[tuple[LeftOutOf, str]]) -> str:
    """Say of which groups decisions were left out, the group that lost the greatest share first; nothing if of none that is known."""
    lost = sorted(listed, key=lambda found: -Fraction(*found[0].amount) / Fraction(*found[0].of))
    said = [f"{shown(own.amount)} of the {shown(own.of)} {unit} on {', '.join(map(shown, own.group))}" for own, unit in lost[:SAID]]
    more = [f"some on {len(lost) - SAID} more groups"] if len(lost) > SAID else []
    return f"Left out for a missing label: {', '.join([*said, *more])}." if said else ""
