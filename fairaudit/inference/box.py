"""The box: a ratio bounded by the ends of every cell by itself.

Of many cells only those that decide have ends as narrow as can be.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from heapq import nlargest, nsmallest
from math import inf
from typing import Any

from fairaudit.exact.extended import Extended, extended_text
from fairaudit.inference.cells import Ends
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ends import Method, ends_of, ends_of_cells, guessed_ends
from fairaudit.inference.levels import Holding, box_levels
from fairaudit.inference.plain_ends import PlainEnds, by_promise, foremost
from fairaudit.inference.quotients import are_many, extreme_ratio, moderate_ranges

FOREMOST = 10_000  # blocks in which ends in closed form are furthest apart, among which the one that decides is sought

NARROWED = 3  # cells on either side of a block that floats find outermost; ends in floats and in integers seldom order more of them apart


def box_interval(
    comparison: Comparison, alpha: Fraction, method: Method, independent: bool, ends: Holding
) -> tuple[Fraction, Extended, dict[str, Any]]:
    """Both ends of the ratio over the box of the ends of cells, with their evidence."""
    upper_level, lower_level = box_levels(len(comparison.used), comparison.span, alpha, independent=independent, ends=ends)
    binary = all(cells[i].binary for cells in comparison.valued for i in comparison.used)
    many = are_many(comparison.used) and comparison.single and (binary or method == "hoeffding-kl") and moderate_ranges(comparison)
    stated: Any
    if many:
        plain = PlainEnds(comparison, upper_level, {})
        listed, upper = _decisive_upper(comparison, plain, upper_level, method)
        shown, lower, where = _decisive_lower(comparison, plain.at(lower_level), lower_level, method)
        stated = _entry(listed if upper < inf else {}), _entry(shown if lower > 1 else {})
    else:
        outer, upper, _ = _every_end(comparison, upper_level, method, upper=True)
        inner, lower, where = _every_end(comparison, lower_level, method, upper=False)
        stated = _texts(outer), _texts(inner)
    evidence = {
        "levels": {"upper": extended_text(upper_level), "lower": extended_text(lower_level)},
        "upper": None if ends == "lower" else stated[0],
        "lower": None if ends == "upper" else stated[1],
        "pair": list(where) if where and lower > 1 and ends != "upper" else None,
    }
    return Fraction(1) if ends == "upper" else lower, inf if ends == "lower" else upper, evidence


def _texts(ends: Iterable[Ends]) -> list[list[str]]:
    return [[extended_text(low), extended_text(high)] for low, high in ends]


def _entry(listed: Mapping[int, Ends]) -> dict[str, Any]:
    """Ends of the cells that decide, by their numbers; those of the others follow (docs/certificate-samples.md)."""
    numbers = sorted(listed)
    return {"cells": numbers, "ends": _texts(listed[i] for i in numbers)}


def _every_end(
    comparison: Comparison, level: Fraction, method: Method, *, upper: bool
) -> tuple[list[Ends], Any, tuple[int, int, int] | None]:
    """Ends of all cells, the greatest maximum (or minimum) of a quotient over them, and where it is."""
    listed = ends_of_cells(comparison, level, method)
    return (listed, *extreme_ratio(comparison, listed, upper=upper))


def _decisive_upper(comparison: Comparison, plain: PlainEnds, level: Fraction, method: Method) -> tuple[dict[int, Ends], Any]:
    """The greatest maximum of a quotient of many cells, with the ends of those that decide; plain ends of the others prove no less.

    The outermost ends of a block are narrowed until they are as narrow as can be, or the block cannot decide.
    """
    listed: dict[int, Ends] = {}
    ends, used = PlainEnds(comparison, level, listed), set(comparison.used) if level else set()
    low, high = (side.tolist() for side in plain.floats)
    best: Any = Fraction(1)
    for value, place in by_promise(comparison, plain):
        if best == inf or value * (1 + 1e-9) < best:
            break
        members = [form[0][0] for form in comparison.blocks[place]]
        while True:
            value, outer = _promise(members, low, high)
            wide = [i for i in outer if i in used and i not in listed]
            if value * (1 + 1e-9) < best or not wide:
                break
            for i in wide:
                listed[i] = own = ends_of(comparison, i, level, method)
                low[i], high[i] = map(float, own)
        if value * (1 + 1e-9) >= best:
            found, pair = extreme_ratio(replace(comparison, blocks=(comparison.blocks[place],)), ends, upper=True)
            best = max(best, found) if pair else best
    return listed, best


def _promise(members: list[int], low: Sequence[float], high: Sequence[float]) -> tuple[float, set[int]]:
    """Greatest quotient of two cells of a block in floats, and the cells that it can be of."""
    if len(members) < 2:
        return 0.0, set()
    tops, bottoms = nlargest(2, members, key=high.__getitem__), nsmallest(2, members, key=low.__getitem__)
    if tops[0] != bottoms[0]:
        tops, bottoms = tops[:1], bottoms[:1]
    pairs = [(i, j) for i in tops for j in bottoms if i != j]
    return max(_over(high[i], low[j]) for i, j in pairs), {*tops, *bottoms}


def _over(above: float, below: float) -> float:
    return above / below if below else inf if above else 0.0


def _decisive_lower(
    comparison: Comparison, plain: PlainEnds, level: Fraction, method: Method
) -> tuple[dict[int, Ends], Any, tuple[int, int, int] | None]:
    """Narrow the cells that floats find furthest apart; any pair proves a lower end, so nothing rests on the floats."""
    blocks, used, listed = comparison.blocks, set(comparison.used) if level else set(), dict[int, Ends]()
    ends, places = PlainEnds(comparison, Fraction(0), listed), foremost(comparison, plain, FOREMOST)
    near = {form[0][0] for place in places for form in blocks[place]}
    low, high = guessed_ends(comparison, used & near, float(level)) if level else (side.tolist() for side in ends.floats)
    promises = []
    for place in places:
        block = blocks[place]
        members = [form[0][0] for form in block]
        most, least = max(map(low.__getitem__, members)), min(map(high.__getitem__, members))
        promises.append((most / least if least else inf if most else 0.0, -place))
    best: Any = Fraction(1)
    where: tuple[int, int, int] | None = None
    for value, place in sorted(promises, reverse=True):
        if best == inf or value * (1 + 1e-5) < best:
            break
        block = blocks[-place]
        members = [form[0][0] for form in block]
        outer = {*sorted(members, key=low.__getitem__)[-NARROWED:], *sorted(members, key=high.__getitem__)[:NARROWED]}
        for i in outer & used:
            listed[i] = ends_of(comparison, i, level, method)
        found, pair = extreme_ratio(replace(comparison, blocks=(block,)), ends, upper=False)
        if pair and (found > best or where is None):
            best, where = found, (-place, *pair[1:])
    return listed, best, where
