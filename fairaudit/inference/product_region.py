"""The product region, for independent cells and forms of a single cell, which replaces the corners of the box.

If u and v are the tail probabilities of the two cells of a pair at their true means, then u and v are independent and
stochastically at least uniform, and P(u ≤ b or v ≤ b or u·v ≤ c) ≤ 2b + f, f = c·log(c/b²) − c + b² (for b² ≤ c ≤ b). With (b, c)
for the pair that attains R and (b', c') for all M ordered pairs, the error is at most 2b + (2K − 2)·b' + f + (M − 1)·f'.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import permutations
from math import ceil, exp, floor, inf, log
from typing import Any

from fairaudit.exact.extended import Extended, extended_text
from fairaudit.exact.rationals import quotient
from fairaudit.inference.cells import Cell, Ends
from fairaudit.inference.comparisons import Comparison, form_mean
from fairaudit.inference.ends import DIGITS, cell_ends, ends_of_cells
from fairaudit.inference.float_tails import float_tail
from fairaudit.inference.levels import Holding, product_levels
from fairaudit.inference.quotients import extreme_candidates, least_ratio
from fairaudit.inference.rounding import BITS
from fairaudit.inference.tails import tail_bound

SLACK = 0.02  # of log(upper end/estimate), on top of the least ratio: a quarter of it buys 0.5 % for twice the knots

MAX_KNOTS = 400  # a ladder takes about ten; a search that needs as many is better started from a greater ratio

GRID = 60  # means along the boundary of the region: with twice as many the ends stay the same to four digits


def product_driver(comparison: Comparison, guard: Fraction, c: Fraction) -> tuple[int, int, int] | None:
    """Which pair has the greatest upper end by itself; the box of ends at the guard bounds that of each pair, so few are looked at."""
    ends: dict[int, Ends] = {}
    reach = []
    for b, block in enumerate(comparison.blocks):
        members = [form[0][0] for form in block] if len(block) > 1 else []
        ends |= {i: cell_ends(comparison.cells[i], guard) for i in members}
        means = [form_mean(comparison, form) for form in block]
        reach += [
            (-quotient(ends[i][1], ends[j][0]), -quotient(means[h], means[k]), b, h, k)
            for (h, i), (k, j) in permutations(enumerate(members), 2)
        ]
    best, where = 1.0, None
    for most, _, b, h, k in sorted(reach):
        if -most <= best:
            break
        top, bottom = (replace(comparison.cells[comparison.blocks[b][form][0][0]]) for form in (h, k))
        found = pair_reach([top], [bottom], guard, c)
        if found > best:
            best, where = found, (b, h, k)
    return where


def product_interval(comparison: Comparison, alpha: Fraction, ends: Holding) -> tuple[Fraction, Extended, dict[str, Any]]:
    """Both ends of the ratio by ladders over the product region, with their evidence."""
    levels = product_levels(len(comparison.used), comparison.pairs, alpha, ends)
    own = [replace(cell) for cell in comparison.cells]  # cells are told apart by identity, equal ones included
    blocks = [[own[form[0][0]] for form in block] for block in comparison.blocks if len(block) > 1]
    entry: dict[str, Any] = {"levels": {"upper": None, "lower": None}, "upper": None, "lower": None}
    upper: Extended = inf
    lower = Fraction(1)
    if levels.upper:
        entry["levels"]["upper"] = [extended_text(v) for v in levels.upper]
        upper = max((_ladder_bound(cells, cells, *levels.upper) for cells in blocks), default=Fraction(1))
        upper = max(upper, Fraction(1))
        if upper != inf:
            knots = [_ladder(cells, cells, Fraction(upper), *levels.upper) for cells in blocks]
            if None in knots:
                upper = inf
            else:
                entry["upper"] = [[extended_text(q) for q in listed] for listed in knots if listed is not None]
    if levels.lower:
        entry["levels"]["lower"] = [extended_text(v) for v in levels.lower]
        lower, entry["lower"] = _product_lower(replace(comparison, cells=tuple(own)), levels.lower)
    return lower, upper, entry


def _product_lower(comparison: Comparison, level: tuple[Fraction, Fraction]) -> tuple[Fraction, dict[str, Any] | None]:
    """Lower end from the few pairs whose cells are furthest apart: one pair proves it, and all pairs share the error."""
    ends = ends_of_cells(comparison, level[0], "hoeffding-kl")
    ranked = []
    for b, block in enumerate(comparison.blocks):
        pairs = extreme_candidates(block, ends) if len(block) > 1 else []
        ranked += [(least_ratio(block[i], block[j], ends), -b, -i, -j) for i, j in pairs]
    best, found = Fraction(1), None
    for _, b, i, j in sorted(ranked, reverse=True)[:3]:
        block = comparison.blocks[-b]
        low, high = (comparison.cells[block[k][0][0]] for k in (-j, -i))
        bound = _ladder_bound([low], [high], *level)
        if bound != inf and 0 < bound < 1 / best:
            knots = _ladder([low], [high], Fraction(bound), *level)
            if knots is not None:
                best, found = 1 / Fraction(bound), {"pair": [-b, -i, -j], "knots": [extended_text(q) for q in knots]}
    return best, found


def _ladder(tops: Sequence[Cell], bottoms: Sequence[Cell], ratio: Fraction, guard: Fraction, c: Fraction) -> list[Fraction] | None:
    """Prove that mean(top)/mean(bottom) ≤ ratio wherever both tails exceed `guard` and their product c, for all pairs of cells.

    The proof is a rising list of means q_0, q_1, …: at q_0 every upper tail of a bottom cell is at most `guard`; at (ratio·q_{j-1}, q_j)
    the product of the tails is at most c; at ratio times the last one every lower tail of a top cell is at most `guard`.
    """
    tops, bottoms = _foremost(tops, tops=True), _foremost(bottoms, tops=False)
    at = min(cell_ends(cell, guard)[0] for cell in bottoms)
    end = max(cell_ends(cell, guard)[1] for cell in tops)
    knots = [at]
    if at <= 0:
        return None
    while ratio * at < end:
        above = ratio * at
        tails = [tail_bound(cell, above, "lower") if above < cell.high else 0 for cell in tops]
        further = _next_knot(tops, tails, bottoms, at, c)
        if further is None or len(knots) > MAX_KNOTS:
            return None
        knots.append(further)
        at = further
    return knots


def _next_knot(tops: Sequence[Cell], tails: Sequence[int], bottoms: Sequence[Cell], at: Fraction, c: Fraction) -> Fraction | None:
    """Largest mean found at which the product of the tails of any two different cells is at most c."""
    if max(tails) == 0:
        return max(cell.high for cell in bottoms)
    heights = [max((t for top, t in zip(tops, tails, strict=True) if top is not cell), default=0) / 2.0**BITS for cell in bottoms]
    goal = float(c) * (1 - 1e-6)
    low, high = float(at), float(max(cell.high for cell in bottoms))
    listed = _floats(bottoms)
    for _ in range(45):
        middle = (low + high) / 2
        tail = max(cell.above(middle) * height for cell, height in zip(listed, heights, strict=True))
        low, high = (middle, high) if tail <= goal else (low, middle)
    scale = 10 ** (DIGITS + 2 + max(0, ceil(-log(low) / log(10))))
    for shrink in (1.0, 1 - 1e-7, 1 - 1e-5):
        q = Fraction(floor(at * scale) + floor((low - float(at)) * shrink * scale), scale)
        if q <= at:
            return None
        products = (
            t * tail_bound(cell, q, "upper") for top, t in zip(tops, tails, strict=True) for cell in bottoms if cell is not top and t
        )
        if all(product * c.denominator <= c.numerator << 2 * BITS for product in products):
            return q
    return None


@dataclass(frozen=True)
class _FloatCell:
    """A cell in floats, for searching."""

    draws: int
    successes: float
    low: float
    width: float
    binary: bool

    def above(self, mean: float) -> float:
        """Upper tail at a mean."""
        p = (mean - self.low) / self.width if self.width else 1.0
        return float_tail(self.draws, self.draws - self.successes, 1 - p, self.binary) if self.draws and self.width else 1.0

    def below(self, mean: float) -> float:
        """Lower tail at a mean."""
        p = (mean - self.low) / self.width if self.width else 1.0
        return float_tail(self.draws, self.successes, p, self.binary) if self.draws and self.width else 1.0


def _floats(cells: Sequence[Cell]) -> list[_FloatCell]:
    return [
        _FloatCell(c.draws, float(c.successes) if c.high > c.low else 0.0, float(c.low), float(c.high - c.low), c.binary) for c in cells
    ]


def _foremost(cells: Sequence[Cell], *, tops: bool) -> list[Cell]:
    """Leave out cells whose tails two others with as many draws exceed everywhere."""
    classes: dict[tuple[Any, ...], list[Cell]] = {}
    for cell in cells:
        classes.setdefault((cell.draws, cell.low, cell.high, cell.binary), []).append(cell)
    return [cell for listed in classes.values() for cell in sorted(listed, key=lambda c: -c.total if tops else c.total)[:2]]


def _ladder_bound(tops: Sequence[Cell], bottoms: Sequence[Cell], guard: Fraction, c: Fraction) -> Extended:
    """Find a ratio, as small as the search gets, for which `_ladder` has a proof; infinite if there is none."""
    tops, bottoms = _foremost(tops, tops=True), _foremost(bottoms, tops=False)
    best = pair_reach(tops, bottoms, guard, c)
    if best == inf:
        return inf
    middle = float(min(cell.mean if cell.draws else cell.low for cell in bottoms))
    center = float(max(cell.mean if cell.draws else cell.high for cell in tops)) / max(middle, 1e-300)
    gap = SLACK * max(abs(log(best / center)) if center > 0 else 1.0, 1e-9)
    for _ in range(12):
        bound = best * exp(gap)
        scale = 10 ** (DIGITS + max(0, ceil(-log(min(bound, 1.0)) / log(10))) + max(0, ceil(-log(min(gap, 1.0)) / log(10))))
        ratio = Fraction(ceil(bound * scale), scale)
        if _ladder(tops, bottoms, ratio, guard, c) is not None:
            return ratio
        gap *= 1.7
    return inf


def pair_reach(tops: Sequence[Cell], bottoms: Sequence[Cell], guard: Fraction, c: Fraction) -> float:
    """The greatest quotient of a top and another bottom in the region, in floats; infinite if a bottom can vanish."""
    start = float(min(cell_ends(cell, guard)[0] for cell in bottoms))
    end = float(max(cell_ends(cell, guard)[1] for cell in tops))
    if start <= 0:
        return inf
    # Along the boundary of the region: for each q the greatest p whose product of tails exceeds c.
    float_tops, float_bottoms = _floats(tops), _floats(bottoms)
    greatest = float(max(cell.high for cell in bottoms))
    middle = float(min(cell.mean if cell.draws else cell.low for cell in bottoms))
    stop = min(greatest, max(2 * middle - start, 1.5 * start))
    best = end / stop
    p = 0.0
    for i in range(GRID + 1):
        q = start + (stop - start) * i / GRID
        above = [cell.above(q) for cell in float_bottoms]
        heights = [max((t for bottom, t in zip(bottoms, above, strict=True) if bottom is not top), default=0.0) for top in tops]
        low, high = p, end
        for _ in range(30):
            half = (low + high) / 2
            inside = any(cell.below(half) * height > float(c) for cell, height in zip(float_tops, heights, strict=True))
            low, high = (half, high) if inside else (low, half)
        p = low
        best = max(best, high / q)
    return best
