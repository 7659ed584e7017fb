"""What decisions are worth to each group in T13: the tables g(·,x,a) locally, G_a(x̃,·) globally, each different one once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import gcd
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.extended import ZERO
from fairaudit.measures.limits import Quantity
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.theorems.supremum import Floors
from fairaudit.theorems.t13_exact import Points, envelope

Block = tuple[int, ...]

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Tables:
    """The different utility tables that are compared.

    Attributes
    ----------
    blocks : tuple
        For each table what every decision is worth: locally in one block, globally in one for each released context.
    bottoms : tuple of int
        What the entries of each table are divided by.
    scales : tuple of Fraction
        For each table what its entries are multiplied by so that of all tables that it is compared with the greatest entry is 1.
    contexts : tuple of int
        True contexts within which groups are compared; those with the same tables as one before them, or surely with less, are left out.
        A single 0 for group means.
    of : ndarray of int64, shape (contexts, groups)
        The table of every group in each of these contexts; −1 where a group is not compared.
    floors : tuple of Fraction
        Where there are floors, that of a group with each table when it is the lower one, in the unit of entries over `bottoms`. Contexts
        are then left out only if they have the same tables and the same floor as one before them.
    standing : tuple of int
        Where there are floors, for each true context the place in `contexts` of that which stands for it.
    """

    blocks: tuple[tuple[Block, ...], ...]
    bottoms: tuple[int, ...]
    scales: tuple[Fraction, ...]
    contexts: tuple[int, ...]
    of: Ints
    floors: tuple[Fraction, ...] = ()
    standing: tuple[int, ...] = ()

    def envelopes(self, first: int, second: int) -> list[Points]:
        """What decisions are worth to a pair of groups with these tables, for each block, over one denominator."""
        common = gcd(self.bottoms[first], self.bottoms[second])
        one, two = self.bottoms[second] // common, self.bottoms[first] // common
        pairs = zip(self.blocks[first], self.blocks[second], strict=True)
        return [envelope([v * one for v in top], [v * two for v in low]) for top, low in pairs]


def utility_tables(deployment: Deployment, utility: UtilityTable, quantity: Quantity, floors: Floors | None = None) -> Tables | None:
    """The tables of a quantity; None where it is not compared, or where a utility that some policy would attain was not given."""
    if utility.given is not None:
        return None
    return _local(deployment, utility, floors) if quantity == "local" else _global(deployment, utility, floors)


def _local(deployment: Deployment, utility: UtilityTable, floors: Floors | None) -> Tables:
    """Rows g(·,x,a), divided by the greatest common divisor of their context."""
    groups = len(deployment.groups)
    listed: dict[tuple[tuple[Block, ...], Fraction], int] = {}
    standing = []
    alike: tuple[Fraction, Block, int] | None = None
    for x, rows in enumerate(_rows_by_context(utility, groups, len(deployment.contexts) if floors is not None else 1)):
        common = gcd(*(v for row in rows for v in row)) or 1
        reduced = tuple(tuple(v // common for v in row) for row in rows)
        free = len(set(reduced)) == 1
        ends = max(reduced[0]), min(reduced[0])
        if floors is not None:
            # Free of the group: two decisions are enough.
            key = (ends,) if free else reduced, floors.cells[x] * utility.scale / common
            standing.append(listed.setdefault(key, x))
        elif not free:
            listed.setdefault((reduced, ZERO), x)
        else:
            # Moreover, of such contexts only the first with the greatest γ/m counts.
            slope = Fraction(ends[1], ends[0]) if ends[0] else Fraction(1)
            if alike is None or slope < alike[0]:
                alike = slope, ends, x
    if alike is not None:
        listed[(alike[1],), ZERO] = alike[2]
    ordered = sorted(listed.items(), key=lambda entry: entry[1])
    width = max((len(row) for rows, _ in listed for row in rows), default=2)
    numbers: dict[tuple[int, Block, Fraction], int] = {}
    of = []
    for (different, floor), _ in ordered:
        unit = max(v for row in different for v in row)
        places = [numbers.setdefault((unit, _padded(row, width), floor), len(numbers)) for row in different]
        of.append(places if len(places) == groups else places * groups)
    contexts = tuple(x for _, x in ordered)
    place = {x: i for i, x in enumerate(contexts)}
    return Tables(
        tuple((row,) for _, row, _ in numbers),
        (1,) * len(numbers),
        tuple(Fraction(1, max(unit, 1)) for unit, _, _ in numbers),
        contexts,
        np.array(of, dtype=np.int64),
        tuple(floor for _, _, floor in numbers) if floors is not None else (),
        tuple(place[x] for x in standing),
    )


def _rows_by_context(utility: UtilityTable, groups: int, contexts: int) -> Iterable[list[Block]]:
    """Rows g(·,x,a) of every context; a single one, so many times, where g is the same in all of them."""
    if utility.by_decision:
        yield from [[tuple(utility.row(0))]] * contexts
        return
    every = [tuple(row) for row in utility.values.tolist()]
    for start in range(0, len(every), groups):
        yield every[start : start + groups]


def _padded(row: Block, width: int) -> Block:
    """The row with its last decision listed again, so that all rows have the same length."""
    return row + row[-1:] * (width - len(row))


def _global(deployment: Deployment, utility: UtilityTable, floors: Floors | None) -> Tables | None:
    """G_a(x̃,·) of the groups that have mass; released contexts in which these are proportional are one block."""
    compared = list(deployment.law.global_groups)
    if not compared:
        return None
    worth, totals = means_by_release(deployment, utility, compared)
    width = worth.shape[2]
    merged: dict[Block, int] = {}
    for row in worth.reshape(len(worth), -1).tolist():
        common = gcd(*row)
        if common:
            key = tuple(v // common for v in row)
            merged[key] = merged.get(key, 0) + common
    flat = [[times * v for v in key] for key, times in merged.items()] or [[0] * (width * len(compared))]
    least = _mean_floors(deployment, floors) if floors is not None else [ZERO] * len(deployment.groups)
    numbers: dict[tuple[int, tuple[Block, ...], Fraction], int] = {}
    of = np.full(len(deployment.groups), -1, dtype=np.int64)
    for place, group in enumerate(compared):
        own = [row[place * width : (place + 1) * width] for row in flat]
        common = gcd(totals[place], *(v for row in own for v in row))
        table = tuple(tuple(v // common for v in row) for row in own)
        key = totals[place] // common, table, least[group] * utility.scale
        of[group] = numbers.setdefault(key, len(numbers))
    blocks: tuple[tuple[Block, ...], ...] = tuple(table for _, table, _ in numbers)
    bottoms = tuple(total for total, _, _ in numbers)
    if len(set(zip(blocks, bottoms, strict=True))) == 1:  # all groups have the same: γ and m of every block add up
        blocks = (((sum(map(max, blocks[0])), sum(map(min, blocks[0]))),),) * len(numbers)
    greatest = max(Fraction(max(map(max, table)), total) for table, total in zip(blocks, bottoms, strict=True))
    scales = tuple(1 / (total * (greatest or Fraction(1))) for total in bottoms)
    kept = tuple(floor for _, _, floor in numbers) if floors is not None else ()
    return Tables(blocks, bottoms, scales, (0,), of[None, :], kept)


def _mean_floors(deployment: Deployment, floors: Floors) -> list[Fraction]:
    """What the floors say about the mean of every group: that of the means, or the mean of those of its contexts if that is more."""
    mass = np.array(deployment.law.cell_mass, dtype=object).reshape(len(deployment.contexts), -1)
    sums = np.array(floors.cells, dtype=object) @ mass
    means = [Fraction(above) / int(total) if total else ZERO for above, total in zip(sums, mass.sum(axis=0), strict=True)]
    return [max(floors.overall, mean) for mean in means]


def means_by_release(deployment: Deployment, utility: UtilityTable, groups: list[int]) -> tuple[NDArray[Any], list[int]]:
    """G_a(x̃,u) = Σ_x P(x∣a) M_X(x̃∣x) g(u,x,a), by released context, group and decision, and what the numbers of each group are over.

    They are integers; the denominator of g is left out.
    """
    shape = len(deployment.contexts), len(deployment.groups)
    mass = np.array(deployment.law.cell_mass, dtype=object).reshape(shape)[:, groups]
    g = utility.values.astype(object)
    values = g[None, None, :] if utility.by_decision else g.reshape(*shape, -1)[:, groups]
    released, bottom = _release(deployment.context_filter, mass[:, :, None] * values)
    return released, [int(v) * bottom for v in mass.sum(axis=0)]


def _release(context_filter: Mechanism | None, tensor: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """Σ_x M_X(x̃∣x)·tensor[x, …], factor by factor, as integers over a denominator."""
    if context_filter is None:
        return tensor, 1
    rest = tensor.shape[1:]
    tensor = tensor.reshape(*(len(factor.inputs) for factor in context_filter.factors), *rest)
    for axis, factor in enumerate(context_filter.factors):
        tensor = _spread(factor, tensor, axis)
    return tensor.reshape(-1, *rest), context_filter.denominator


def _spread(factor: Factor, tensor: NDArray[Any], axis: int) -> NDArray[Any]:
    """Σ_i rows[i][j]·tensor[…, i, …] along an axis; identity plus rank one where the factor is of that form."""
    mixing = factor.mixing
    if mixing is None:
        return np.moveaxis(np.tensordot(np.array(factor.rows, dtype=object), tensor, axes=(0, axis)), 0, axis)
    diagonal, base = mixing
    shape = [1] * tensor.ndim
    shape[axis] = len(base)
    whole = tensor.sum(axis=axis, keepdims=True)
    result: NDArray[Any] = tensor * diagonal + whole * np.array(base, dtype=object).reshape(shape)
    return result
