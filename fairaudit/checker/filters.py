"""Filters: products of stochastic matrices, what they do to laws, and the likelihood ratios of their rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, permutations, product
from math import gcd, prod
from operator import mul

from .header import Header
from .json_values import Labels, read_integer, read_label_lists, read_list, read_object, read_strings
from .laws import Law, reduced_law
from .rationals import (
    ONE,
    ZERO,
    Rational,
    common_denominator,
    maximum,
    over_common_denominator,
    product_of,
    read_rationals,
    reduced,
    widest_ratio,
)
from .text import TooMuch, malformed
from .work import keep, spend, working_on

PAIR_ENTRIES = 500_000  # of the joint likelihood ratios of pairs of rows of a product of filters
MAX_RELEASES = 10_000


def read_filters(header: Header, value: object, where: str) -> tuple[Filter, Filter | None, int]:
    """Read the filters of a policy, for its groups and perhaps for its contexts, and how often a group is released."""
    columns, decisions = header.subject.columns, len(header.decisions)
    filters = read_object(value, where, ("group", "context"), optional=("releases",))
    releases = 1
    if "releases" in filters:
        releases = read_integer(filters["releases"], f"{where}.releases", MAX_RELEASES + 1)
        if releases < 2:
            raise malformed(f"{where}.releases", "must be at least 2 where it is given")
    group = _read_filter(filters["group"], f"{where}.group", len(columns.group))
    context = None
    if filters["context"] is not None:
        context = _read_filter(filters["context"], f"{where}.context", len(columns.context))
    if group.size < 2:
        raise malformed(f"{where}.group", "has fewer than two inputs")
    working_on("the law that the filters induce")
    spend_on_law(context.size if context else len(header.contexts), group, decisions)
    return group, context, releases


def spend_on_law(true_contexts: int, group: Filter, decisions: int) -> None:
    """Count what it takes to write down the law that a policy and its filters induce."""
    spend(true_contexts * (group.size * (100 + 10 * decisions) + 3 * group.released * decisions))
    keep(true_contexts * (12 * group.size + max(group.size, group.released) * decisions))


def _read_filter(value: object, where: str, columns: int) -> Filter:
    factors = tuple(_read_factor(item, f"{where}[{i}]") for i, item in enumerate(read_list(value, where)))
    if not factors or sum(len(factor.inputs[0]) for factor in factors) != columns:
        raise malformed(where, f"must have factors that cover {columns} columns together")
    return Filter(factors)


def _read_factor(value: object, where: str) -> Factor:
    members = read_object(value, where, ("inputs", "outputs", "rows"))
    width = len(read_strings(next(iter(read_list(members["inputs"], f"{where}.inputs")), []), f"{where}.inputs[0]"))
    if width == 0:
        raise malformed(f"{where}.inputs", "must list labels")
    inputs = read_label_lists(members["inputs"], f"{where}.inputs", width)
    outputs = read_label_lists(members["outputs"], f"{where}.outputs", width)
    rows = [
        read_rationals(row, f"{where}.rows[{i}]", len(outputs))
        for i, row in enumerate(read_list(members["rows"], f"{where}.rows", len(inputs)))
    ]
    entries, total = over_common_denominator([entry for row in rows for entry in row])
    matrix = [entries[i : i + len(outputs)] for i in range(0, len(entries), len(outputs))]
    for i, row in enumerate(matrix):
        if sum(row) != total:
            raise malformed(f"{where}.rows[{i}]", "are probabilities that do not sum to 1")
    released = [j for j, column in enumerate(zip(*matrix, strict=True)) if any(column)]
    return Factor(inputs, tuple(outputs[j] for j in released), [[row[j] for j in released] for row in matrix], total)


@dataclass(frozen=True)
class _Map:
    """A linear map: row i of its matrix is ``scale * base`` plus some further ``(column, coefficient)``, over ``denominator``.

    Where a filter keeps the truth or else draws from one distribution, each row has one or two further entries.
    """

    base: Sequence[int]
    rows: Sequence[tuple[int, Sequence[tuple[int, int]]]]
    denominator: int

    def applied(self, values: list[int], step: int) -> list[int]:
        """Multiply along one axis of a tensor, the neighbours on which are ``step`` apart."""
        result: list[int] = []
        width = len(self.base)
        bits = max(map(int.bit_length, values))
        own = max(self.denominator.bit_length(), *map(int.bit_length, self.base))
        terms = width + len(self.rows) + sum(len(further) for _, further in self.rows)
        spend(len(values) // width * terms, bits, own)
        if bits + own > 256:
            keep(len(values) // width * len(self.rows), bits + own)
        for start in range(0, len(values), step * width):
            parts = [values[i : i + step] for i in range(start, start + step * width, step)]
            common = _combination(self.base, parts)
            for scale, further in self.rows:
                result += _combination([scale, *(c for _, c in further)], [common, *(parts[j] for j, _ in further)])
        return result


def _combination(coefficients: Sequence[int], vectors: Sequence[list[int]]) -> list[int]:
    kept = [(c, vector) for c, vector in zip(coefficients, vectors, strict=True) if c]
    if not kept:
        return [0] * len(vectors[0])
    factors = [c for c, _ in kept]
    return [sum(map(mul, factors, entries)) for entries in zip(*(vector for _, vector in kept), strict=True)]


def map_of(matrix: Sequence[Sequence[int]], total: int) -> _Map:
    """Find the base: the most frequent entry of each column; a row that follows it in half of its entries is a multiple of it."""
    entries = len(matrix) * len(matrix[0])
    spend(12 * entries, total.bit_length(), total.bit_length())
    base = [Counter(column).most_common(1)[0][0] for column in zip(*matrix, strict=True)]
    multiples: list[Rational] = []
    for row in matrix:
        ratios = Counter(reduced(entry, common) for entry, common in zip(row, base, strict=True) if common)
        [(multiple, count)] = ratios.most_common(1) or [(ZERO, 0)]
        multiples.append(multiple if 2 * count >= len(row) else ZERO)
    unit = common_denominator({d for _, d in multiples})
    if (bits := unit.bit_length()) > 256:
        spend(entries, bits, total.bit_length())
        keep(entries, bits + total.bit_length())
    rows: list[tuple[int, list[tuple[int, int]]]] = []
    for row, (n, d) in zip(matrix, multiples, strict=True):
        scale = n * (unit // d)
        rests = [entry * unit - scale * common for entry, common in zip(row, base, strict=True)]
        rows.append((scale, [(j, rest) for j, rest in enumerate(rests) if rest]))
    return _Map(base, rows, total * unit)


def map_through(values: list[int], maps: Sequence[_Map]) -> list[int]:
    """Apply each map along its own axis, the last of them varying fastest (but for a last axis that none of them touches)."""
    sizes = [len(m.base) for m in maps]
    width = len(values) // prod(sizes)
    for i in sorted(range(len(maps)), key=lambda i: len(maps[i].rows) > sizes[i]):  # what shrinks the tensor goes first
        values = maps[i].applied(values, width * prod(sizes[i + 1 :]))
        sizes[i] = len(maps[i].rows)
    return values


def mixed_laws(laws: Sequence[Law], maps: Sequence[_Map]) -> list[Law]:
    """Mix laws, listed by what is released (a last axis may be left alone), into the laws by what is true."""
    width = len(laws[0][0])
    common = common_denominator({total for _, total in laws})
    if (bits := common.bit_length()) > 256:
        spend(len(laws) * width, bits, bits)
        keep(len(laws) * width, bits)
    values = map_through([weight * (common // total) for weights, total in laws for weight in weights], maps)
    total = common * prod(m.denominator for m in maps)
    return [reduced_law(values[i : i + width], total) for i in range(0, len(values), width)]


def seen_in_contexts(rows: list[list[Law]], context: Filter | None) -> list[list[Law]]:
    """Mix the laws of a policy, by released context and released group, into those by true context and released group."""
    if context is None:
        return rows
    flat = mixed_laws([law for row in rows for law in row], context.maps)
    return [flat[i : i + len(rows[0])] for i in range(0, len(flat), len(rows[0]))]


Distribution = tuple[tuple[int, int], ...]  # pairs (p, q), sorted: what two rows give to the outputs, by likelihood ratio p/q


def by_likelihood_ratio(pairs: Iterable[tuple[int, int]]) -> Distribution:
    """Add up the pairs of equal p/q; outputs that neither row gives anything to are left out."""
    sums: Counter[tuple[int, int]] = Counter()
    for p, q in pairs:
        if divisor := gcd(p, q):
            sums[p // divisor, q // divisor] += divisor
    return tuple(sorted((p * n, q * n) for (p, q), n in sums.items()))


@dataclass(frozen=True)
class Factor:
    """One part of a filter, without the outputs that are never released; ``matrix`` is over ``total``."""

    inputs: tuple[Labels, ...]
    outputs: tuple[Labels, ...]
    matrix: list[list[int]]
    total: int

    @cached_property
    def map(self) -> _Map:
        """The matrix, to be applied to laws that are listed by output."""
        return map_of(self.matrix, self.total)

    @cached_property
    def exp_epsilon(self) -> Rational:
        """The greatest ratio of two entries of a column."""
        columns = ([(entry, 1) for entry in column] for column in zip(*self.matrix, strict=True))
        ratios = [widest_ratio(column)[0] for column in columns] if len(self.inputs) > 1 else [ONE]
        return maximum(ratios)

    @cached_property
    def kinds(self) -> tuple[list[Distribution], list[list[int]]]:
        """The different distributions of p/q over the ordered pairs of rows, and by pair which of them it has.

        The first one is that of a row with itself, which is also that of equal rows of different inputs.
        """
        rows, bits = len(self.matrix), self.total.bit_length()
        spend(rows * (rows - 1) * (len(self.outputs) + 4), bits, bits)
        keep(rows * rows // 4)
        found: dict[Distribution, int] = {((self.total, self.total),): 0}
        alike: dict[frozenset[tuple[tuple[int, int], int]], int] = {}
        which = [[0] * rows for _ in range(rows)]
        entries = 0
        for i, j in permutations(range(rows), 2):
            counts = frozenset(Counter(zip(self.matrix[i], self.matrix[j], strict=True)).items())
            number = alike.get(counts)
            if number is None:
                keep(4 * len(counts), bits)
                distribution = by_likelihood_ratio((p * n, q * n) for (p, q), n in counts)
                number = alike[counts] = found.setdefault(distribution, len(found))
                if number == len(found) - 1 > 0:
                    entries += sum(p > 0 for p, _ in distribution)
                    check_entries(entries, bits)
            which[i][j] = number
        return list(found), which

    def pairs(self) -> set[Distribution]:
        """List the different distributions of p/q over the ordered pairs of rows of different inputs; p = 0 adds nothing to any H_k."""
        distributions, which = self.kinds
        numbers = {number for i, row in enumerate(which) for j, number in enumerate(row) if i != j}
        return {tuple((p, q) for p, q in distributions[number] if p) for number in numbers}


@dataclass(frozen=True)
class Filter:
    """The product of its factors: they draw independently of each other."""

    factors: tuple[Factor, ...]

    @property
    def size(self) -> int:
        """The number of joint inputs."""
        return prod(len(factor.inputs) for factor in self.factors)

    @property
    def released(self) -> int:
        """The number of joint outputs that can be released."""
        return prod(len(factor.outputs) for factor in self.factors)

    @property
    def maps(self) -> list[_Map]:
        """The maps of the factors."""
        return [factor.map for factor in self.factors]

    @property
    def inputs(self) -> list[Labels]:
        """The joint inputs, the last factor varying fastest."""
        return [tuple(chain(*parts)) for parts in product(*(factor.inputs for factor in self.factors))]

    @property
    def outputs(self) -> list[Labels]:
        """The joint outputs that can be released."""
        return [tuple(chain(*parts)) for parts in product(*(factor.outputs for factor in self.factors))]

    def releases(self) -> list[list[int]]:
        """List for each joint input which of the joint outputs it can release."""
        size = prod(sum(map(bool, chain.from_iterable(factor.matrix))) for factor in self.factors)
        spend(2 * size)
        keep(size // 4)
        lists = [[0]]
        for factor in self.factors:
            own = [[j for j, entry in enumerate(row) if entry] for row in factor.matrix]
            lists = [[i * len(factor.outputs) + j for i in before for j in after] for before in lists for after in own]
        return lists

    def matrix(self) -> tuple[list[list[int]], int]:
        """Multiply out the probabilities of the joint outputs under each joint input, over one denominator."""
        bits = sum(factor.total.bit_length() for factor in self.factors)
        spend(self.size * self.released * 2, bits, bits)
        keep(self.size * self.released, bits)
        rows = [[1]]
        for factor in self.factors:
            rows = [[p * q for p in before for q in after] for before in rows for after in factor.matrix]
        return rows, prod(factor.total for factor in self.factors)

    @property
    def exp_epsilon(self) -> Rational:
        """The greatest ratio of the probabilities of one output under two inputs."""
        return product_of(factor.exp_epsilon for factor in self.factors)

    @cached_property
    def pairs(self) -> tuple[set[Distribution], int]:
        """The different distributions of p/q over ordered pairs of different joint inputs, and the unit of p and q.

        Two joint inputs differ in some factors, at least one, and agree in the others.
        """
        unit = 1
        differing: set[Distribution] = set()
        for factor in self.factors:
            agree: Distribution = ((factor.total, factor.total),)
            own = factor.pairs()
            before = differing
            entries = (1 + sum(map(len, before))) * (1 + sum(map(len, own)))
            bits = unit.bit_length() + factor.total.bit_length()
            check_entries(entries, bits)
            spend(20 * entries, bits, bits)
            keep(2 * entries, 2 * bits)
            differing = {_joint(pair, other) for pair in before for other in {*own, agree}}
            differing |= {_joint(((unit, unit),), other) for other in own}
            unit *= factor.total
        return differing, unit


def check_entries(entries: int, bits: int) -> None:
    """Refuse pairs of rows that have too many joint likelihood ratios, of so many bits."""
    if entries * (1 + (bits >> 8)) ** 2 > PAIR_ENTRIES:
        raise TooMuch(f"the pairs of rows of the group filter have more than {PAIR_ENTRIES} joint likelihood ratios")


def _joint(one: Distribution, other: Distribution) -> Distribution:
    return by_likelihood_ratio((p * r, q * s) for p, q in one for r, s in other)
