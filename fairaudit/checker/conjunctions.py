"""Conjunctions of attribute values, counted anew: the table by attributes, the search, and the bound that ends it."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from math import prod
from struct import unpack

from .header import read_log_digests
from .json_values import (
    Labels,
    canonical_text,
    check_distinct,
    decoded,
    read_choice,
    read_hexadecimal,
    read_integer,
    read_list,
    read_object,
    read_string,
    read_strings,
)
from .rationals import Rational, over_common_denominator, read_rational
from .text import malformed
from .work import grant_bytes, keep, spend

SUBGROUP_TABLE = "fairaudit-subgroup-table/1"

FIELD = 64  # bits of each of the numbers that are kept as one: the rows with each value
MOST_ROWS = 1 << 60

Condition = tuple[int, int]  # an attribute and one of its values, by position
Conjunction = tuple[Condition, ...]

_LINE = re.compile(
    rb"\[\[((?:0|[1-9][0-9]{0,17})(?:,(?:0|[1-9][0-9]{0,17}))*)\],\[((?:0|[1-9][0-9]{0,17})(?:,(?:0|[1-9][0-9]{0,17}))*)\]\]\n"
)


@dataclass(frozen=True)
class SubgroupTable:
    """How many rows have which attributes and which value."""

    decision: str
    attributes: Labels
    labels: tuple[Labels, ...]
    decisions: tuple[tuple[str, Rational], ...]
    values: tuple[int, ...]  # what decisions are worth, rising, as integers over the unit
    unit: int
    entries: Mapping[int, int]  # by the values of all attributes, as one number, how many rows have each value, as one number
    by_decision: tuple[int, ...]  # how many rows have each decision
    lines: int
    digest: str
    log: Mapping[str, str]  # the digest of what the certificate says of the log

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """How many values each attribute has."""
        return tuple(map(len, self.labels))

    def unpacked(self, packed: int) -> tuple[int, ...]:
        """The numbers that are kept as one."""
        size = len(self.values)
        return unpack(f"<{size}Q", packed.to_bytes(size * FIELD // 8, "little"))

    def total(self, counts: Sequence[int]) -> int:
        """What rows get together."""
        return sum(n * value for n, value in zip(counts, self.values, strict=True))


@dataclass(frozen=True)
class _Head:
    """The first line of a table."""

    decision: str
    attributes: Labels
    labels: tuple[Labels, ...]
    decisions: tuple[tuple[str, Rational], ...]
    log: Mapping[str, str]


def _read_head(value: object, where: str) -> _Head:
    members = read_object(value, where, ("format", "columns", "labels", "decisions"), optional=("salt", "preparation"))
    read_choice(members["format"], f"{where}.format", (SUBGROUP_TABLE,))
    if "salt" in members:
        read_hexadecimal(members["salt"], f"{where}.salt", "0123456789abcdefABCDEF", 32)
    decision, attributes = read_columns(members["columns"], f"{where}.columns")
    labels = tuple(
        read_strings(item, f"{where}.labels[{i}]")
        for i, item in enumerate(read_list(members["labels"], f"{where}.labels", len(attributes)))
    )
    for i, own in enumerate(labels):
        check_distinct(own, f"{where}.labels[{i}]")
    decisions = []
    for i, item in enumerate(read_list(members["decisions"], f"{where}.decisions")):
        label, worth = read_list(item, f"{where}.decisions[{i}]", 2)
        place = f"{where}.decisions[{i}]"
        decisions.append((read_string(label, place), read_rational(worth, place, nonnegative=True)))
    check_distinct(decisions, f"{where}.decisions")
    return _Head(decision, attributes, labels, tuple(decisions), read_log_digests(members, where))


def read_columns(value: object, where: str) -> tuple[str, Labels]:
    """Read the names of the columns: that of the decision and those of the attributes."""
    members = read_object(value, where, ("decision", "attributes"))
    decision, attributes = read_string(members["decision"], f"{where}.decision"), read_strings(members["attributes"], f"{where}.attributes")
    check_distinct(attributes, f"{where}.attributes")
    if decision in attributes:
        raise malformed(where, "names a column twice")
    return decision, attributes


def embedded_lines(value: Sequence[object]) -> Iterator[tuple[str, object, bytes]]:
    """Give the header and the rows in the certificate as lines."""
    for i, item in enumerate(value):
        where = "subject.table.header" if i == 0 else f"subject.table.rows[{i - 1}]"
        yield where, item, canonical_text(item)


def lines_of_subgroups(lines: Iterable[bytes]) -> Iterator[tuple[str, object, bytes]]:
    """Decode the lines of a table file, and make sure that they are canonical."""
    for number, line in enumerate(lines, 1):
        where = f"line {number} of the table"
        grant_bytes(len(line))
        if plain := _LINE.fullmatch(line):
            yield where, [[*map(int, part.split(b","))] for part in plain.groups()], line
            continue
        value = decoded(line, where)
        if line != canonical_text(value):
            raise malformed(where, "is not the canonical text of its value, ended by one line feed")
        yield where, value, line


def _numbers(value: object, where: str, length: int) -> list[int]:
    items = read_list(value, where, length)
    for item in items:
        read_integer(item, where)
    return items  # type: ignore[return-value]


def read_subgroup_table(lines: Iterator[tuple[str, object, bytes]]) -> SubgroupTable:
    """Read a table: rows with the same attributes are one line, and the lines rise."""
    digest = hashlib.sha256()
    first = next(lines, None)
    if first is None:
        raise malformed("the table", "is empty")
    digest.update(first[2])
    head = _read_head(first[1], first[0])
    values, unit = over_common_denominator([worth for _, worth in head.decisions])
    rising = sorted(set(values))
    places = {value: i for i, value in enumerate(rising)}
    shifts = [FIELD * places[value] for value in values]
    if (bits := max(value.bit_length() for value in values)) > FIELD:
        spend(len(values) ** 2, bits)
    sizes = [len(own) for own in head.labels]
    entries: dict[int, int] = {}
    by_decision = [0] * len(values)
    last = -1
    bits = sum(map(int.bit_length, sizes)) + FIELD * len(rising)
    cost, room = 4 + (len(sizes) + len(values)) // 8, 4 + bits // 256
    for where, value, line in lines:
        digest.update(line)
        spend(cost, bits)
        keep(room)
        codes, counts = read_list(value, where, 2)
        key = 0
        for code, size in zip(_numbers(codes, where, len(sizes)), sizes, strict=True):
            if code >= size:
                raise malformed(where, f"has the position {code} of a label of which there are {size}")
            key = key * size + code
        if key <= last:
            raise malformed(where, "does not come after the line before")
        last = key
        packed = 0
        for i, n in enumerate(_numbers(counts, where, len(values))):
            packed += n << shifts[i]
            by_decision[i] += n
        if not packed:
            raise malformed(where, "has no rows")
        entries[key] = packed
    if not 0 < sum(by_decision) < MOST_ROWS:
        raise malformed("the table", "has no rows, or too many")
    return SubgroupTable(
        head.decision,
        head.attributes,
        head.labels,
        head.decisions,
        tuple(rising),
        unit,
        entries,
        tuple(by_decision),
        len(entries),
        digest.hexdigest(),
        head.log,
    )


def every_set(table: SubgroupTable, depth: int) -> Iterator[tuple[tuple[int, ...], Mapping[int, int]]]:
    """Count the rows by the values of each set of 1 to ``depth`` attributes, once.

    Attributes are cut into depth + 1 runs: whatever set is asked for lacks one of them.  So it is counted from what is left when that run
    is summed out, which has fewer entries, and so on.
    """
    done: set[tuple[int, ...]] = set()
    waiting: list[tuple[tuple[int, ...], Mapping[int, int]]] = [(tuple(range(len(table.sizes))), table.entries)]
    while waiting:
        own, counted = waiting.pop()
        if len(own) <= depth:
            yield own, counted
        if len(own) == 1:
            continue
        runs = min(depth + 1, len(own)) if len(own) > depth else len(own)
        ends = [len(own) * i // runs for i in range(runs + 1)]
        for start, end in pairwise(ends):
            spend(20 + len(own) // 4)
            left = own[:start] + own[end:]
            if left not in done:
                done.add(left)
                keep(4 + len(left) // 4)
                waiting.append((left, _summed_out(counted, table.sizes, own, start, end)))


def _summed_out(counted: Mapping[int, int], sizes: Sequence[int], own: Sequence[int], start: int, end: int) -> dict[int, int]:
    """Sum a run of attributes out of a set."""
    spend(len(own), sum(sizes[a].bit_length() for a in own))
    low = prod(sizes[a] for a in own[end:])
    high = low * prod(sizes[a] for a in own[start:end])
    spend(4 * len(counted), high.bit_length())
    found: dict[int, int] = {}
    get = found.get
    for key, packed in counted.items():
        left = key // high * low + key % low
        found[left] = get(left, 0) + packed
    keep(3 * len(found))
    return found


def conditions_of(key: int, own: Sequence[int], sizes: Sequence[int]) -> Conjunction:
    """The values of a set of attributes that one number stands for."""
    found = []
    for attribute in reversed(own):
        key, value = divmod(key, sizes[attribute])
        found.append((attribute, value))
    return tuple(reversed(found))


def reaches(rows: int, total: int, everybody: tuple[int, int], limit: Rational) -> bool:
    """Decide whether the mean of some rows and that of the rest have a ratio, the greater over the less, of at least a limit."""
    own, rest = total * (everybody[0] - rows), (everybody[1] - total) * rows
    if own == rest:
        return limit[0] <= limit[1]
    return max(own, rest) * limit[1] >= limit[0] * min(own, rest)


def none_reaches(counts: Sequence[int], values: Sequence[int], everybody: tuple[int, int], least: int, limit: Rational) -> bool:
    """Decide by T18 that no part of some rows, of at least so many and not all rows, has a ratio of at least a limit.

    A part of j rows gets between what the j least and what the j greatest values are; between the ends of a class of equal values it is
    enough to look at both ends, because what is compared is concave in j.
    """
    n, total = everybody
    most = min(sum(counts), n - 1)
    if most < least:
        return True
    spend(4 * len(counts) ** 2 + 8, total.bit_length() + n.bit_length(), limit[0].bit_length())
    falling = [*zip(counts, values, strict=True)][::-1]
    for classes, greatest in ((falling, True), (falling[::-1], False)):
        ends = [*accumulate(count for count, _ in classes)]
        for j in (least, most, *(end for end in ends if least < end < most)):
            part, left = 0, j
            for count, value in classes:
                taken = min(count, left)
                part, left = part + taken * value, left - taken
            own, rest = part * (n - j), (total - part) * j
            above, below = (own, rest) if greatest else (rest, own)
            if above * limit[1] >= limit[0] * below:
                return False
    return True
