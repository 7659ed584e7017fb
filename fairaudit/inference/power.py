"""How likely an audit decides, if its cells have supposed means: simulated tables, in floats, for plans, never for conclusions.

`within` needs every ordered pair to show that its ratio is less than the limit, `exceeds` one pair that shows the contrary. Blocks are
independent of each other, so that equal ones are simulated once; of cells that are alike the greatest and the least sum decide.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf, log, sqrt
from typing import Literal

import numpy as np

from fairaudit.exact.dense import Floats
from fairaudit.inference.comparisons import Comparison, Form
from fairaudit.inference.ends import Method
from fairaudit.inference.half_split import SCALE
from fairaudit.inference.interval import Region, Selection
from fairaudit.inference.levels import box_levels, pair_errors, product_levels
from fairaudit.inference.rejections import Rejects, Supposed, by_boxes, by_contrasts, by_pairs, by_products, end_of_sums, score_end

Side = Literal["within", "exceeds"]

TABLES = 4_000

MOST_SUMS = 300_000  # that are simulated for one block

FOREMOST = 30  # different blocks, those first that decide

EASIER = 2.0  # times as many standard errors from the limit as the pair that decides: a pair that fails, or is found, next to never

SEED = 20


@dataclass(frozen=True)
class Audit:
    """An audit that is planned.

    Attributes
    ----------
    comparison : Comparison
        What is compared; draws and sums of its cells are not looked at.
    supposed : sequence of Supposed
        For each of its cells how it comes out; the draws are those of one unit of size.
    side : {"within", "exceeds"}
        The verdict that is wanted.
    limit : float
        Of the ratio.
    alpha : Fraction
        The error of the end that decides.
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For draws of more than two values.
    independent : bool
        Whether cells are declared independent.
    region : callable
        By the size, the region that the audit will use.
    pairs, used, span : int
        Ordered pairs, informative cells, and how many of those are in two forms: of all that is compared, of which only the part that
        decides may be listed here.
    select : {"bonferroni", "half-split"}
        How `exceeds` finds its pair.
    only : tuple of int or None
        A block and the higher and lower form of the only pair that is to be shown.
    """

    comparison: Comparison
    supposed: Sequence[Supposed]
    side: Side
    limit: float
    alpha: Fraction
    method: Method
    independent: bool
    region: Callable[[float], Region]
    pairs: int
    used: int
    span: int
    select: Selection = "bonferroni"
    only: tuple[int, int, int] | None = None


@dataclass(frozen=True)
class Chance:
    """How likely the verdict is.

    Attributes
    ----------
    power : float
        Its probability.
    pair : tuple of int or None
        Block, higher and lower form of the pair that decides: the one that most often leaves it open, or most often shows it.
    rates : tuple
        For each pair of classes of each block how often it does.
    cells : tuple of int
        Those of the pairs that most often show it, if half of the draws chooses one.
    """

    power: float
    pair: tuple[int, int, int] | None
    rates: tuple[tuple[float, _Block, tuple[int, int]], ...] = ()
    cells: tuple[int, ...] = ()


Kept = tuple[tuple[Supposed, int], ...]
"""Different cells of a block, each with how many of them there are."""


@dataclass(frozen=True)
class _Block:
    """A block as all those with the same cells are."""

    places: tuple[int, ...]
    classes: Kept
    pairs: tuple[tuple[int, int], ...]  # of classes, the higher one first


@dataclass(frozen=True)
class Chances:
    """The chances of an audit, by its size."""

    audit: Audit

    def at(self, factor: float) -> Chance:
        """The probability of the verdict with so many times the draws."""
        region = self.audit.region(factor)
        if not self.audit.comparison.single:
            return self._of_forms(factor)
        if self.audit.select == "half-split" and region != "pairs":  # certify refuses it
            return Chance(0.0, None)
        if self.audit.select == "half-split" and self.audit.side == "exceeds":
            return self._of_halves(factor)
        rejects = self._rule(region)
        open_, found = 1.0, list[tuple[float, _Block, tuple[int, int]]]()
        for number, block in enumerate(self.blocks):
            chance, of_pairs = self._block(block, factor, rejects, number)
            open_ *= chance ** len(block.places)
            found += [(of, block, pair) for of, pair in zip(of_pairs, block.pairs, strict=False)]
        _, block, pair = max(found, key=lambda one: one[0])
        return Chance(open_ if self.audit.side == "within" else 1 - open_, self._place(block, pair), tuple(found))

    def deciding(self, chance: Chance) -> tuple[int, ...]:
        """The cells of the pairs that decide at least half as often as the one that does most often."""
        if chance.cells:
            return chance.cells
        most = max((rate for rate, _, _ in chance.rates), default=0.0)
        found = set()
        for rate, block, pair in chance.rates:
            if rate >= most / 2:
                kinds = {block.classes[c][0] for c in pair}
                forms = [form for b in block.places for form in self.audit.comparison.blocks[b]]
                found |= {i for ((i, _),) in forms if self.audit.supposed[i] in kinds}
        return tuple(sorted(found))

    def fewest(self, factor: float, loss: float) -> list[float]:
        """For each block how many times the draws it needs, if so many times in all blocks are enough, and a little power may be lost."""
        rejects = self._rule(self.audit.region(factor))
        share = loss / sum(len(block.places) for block in self.blocks)
        least = [1.0] * len(self.audit.comparison.blocks)
        last = 1.0
        for number, block in enumerate(self.blocks):

            def enough(times: float, block: _Block = block, number: int = number) -> bool:
                return self._block(block, times, rejects, number)[0] >= 1 - share

            last = factor
            if enough(factor):
                low = 1.0
                while last > 1.02 * low:
                    middle = sqrt(low * last)
                    low, last = (low, middle) if enough(middle) else (middle, last)
                last = 1.0 if last <= 1.02 and enough(1.0) else last
            for b in block.places:
                least[b] = last
        seen = {b for block in self.blocks for b in block.places}
        return [last if b not in seen else times for b, times in enumerate(least)]

    def _block(self, block: _Block, factor: float, rejects: Rejects, number: int) -> tuple[float, list[float]]:
        """How likely a block passes (`within`), or shows nothing (`exceeds`); and for each pair how often it does what decides."""
        within = self.audit.side == "within"
        tables = max(TABLES // 4, min(TABLES * len(block.places), MOST_SUMS // sum(many for _, many in block.classes)))
        cells = [cell.grown(factor) for cell, _ in block.classes]
        extremes: dict[int, tuple[Floats, Floats]] = {}
        for c in {c for pair in block.pairs for c in pair}:
            sums = cells[c].sums(np.random.default_rng([SEED, number, c]), (tables, block.classes[c][1]))
            extremes[c] = sums.min(axis=1), sums.max(axis=1)
        passes, of_pairs = np.ones(tables, dtype=np.bool_), []
        for high, low in block.pairs:
            if within:
                shown = rejects(cells[high], extremes[high][1], cells[low], extremes[low][0], self.audit.limit)
                passes &= shown
                of_pairs.append(1 - float(shown.mean()))
            else:
                shown = rejects(cells[low], extremes[low][0], cells[high], extremes[high][1], 1 / self.audit.limit)
                passes &= ~shown
                of_pairs.append(float(shown.mean()))
            if not of_pairs[-1] or not passes.any():  # the others are further from the limit, or change nothing
                break
        return float(passes.mean()), of_pairs

    def _rule(self, region: Region) -> Rejects:
        """By which draws of two cells an audit shows what is wanted."""
        alpha, upper = self.audit.alpha, self.audit.side == "within"
        if region in ("pairs", "contrasts"):
            level = pair_errors(self.audit.pairs, alpha, "each")[0 if upper else 1] or alpha
            return by_pairs(level) if region == "pairs" else by_contrasts(level)
        if region == "product":
            levels = product_levels(self.audit.used, self.audit.pairs, alpha, "each")
            guard, c = (levels.upper if upper else levels.lower) or (alpha, alpha)
            return by_products(float(guard), float(c))
        return by_boxes(self._box_level, self.audit.method)

    @cached_property
    def _box_level(self) -> float:
        audit = self.audit
        levels = box_levels(audit.used, audit.span, audit.alpha, independent=audit.independent, ends="each")
        return float(levels[0 if audit.side == "within" else 1])

    @cached_property
    def blocks(self) -> list[_Block]:
        """The different blocks with the pairs that decide, the foremost first."""
        supposed = self.audit.supposed
        if self.audit.only is not None:
            b, *pair = self.audit.only
            high, low = (supposed[self.audit.comparison.blocks[b][k][0][0]] for k in pair)
            return [_Block((b,), ((high, 1), (low, 1)), ((0, 1),))]
        seen: dict[Kept, list[int]] = {}
        for b, block in enumerate(self.audit.comparison.blocks):
            if len(block) > 1:
                counted = Counter(supposed[form[0][0]] for form in block)
                key = tuple(sorted(counted.items(), key=lambda item: (item[0].mean, item[0].draws, item[0].deviation, item[0].high)))
                seen.setdefault(key, []).append(b)
        distances = {key: _distances(key, self.audit.limit, self.audit.side) for key in seen}
        nearest = min(min(of.values()) for of in distances.values())
        found = []
        for key in sorted(seen, key=lambda key: min(distances[key].values()))[:FOREMOST]:
            ranked = sorted(
                (d, key[pair[1]][0].draws, pair) for pair, d in distances[key].items()
            )  # of two as near, the one with fewer draws below
            pairs = tuple(pair for d, _, pair in ranked if d <= _reach(nearest))
            found.append(_Block(tuple(seen[key]), key, pairs or (ranked[0][2],)))
        return found

    def _place(self, block: _Block, pair: tuple[int, int]) -> tuple[int, int, int]:
        """A pair of cells that are in these classes."""
        forms = self.audit.comparison.blocks[block.places[0]]
        high, low = (block.classes[c][0] for c in pair)
        at = next(i for i, form in enumerate(forms) if self.audit.supposed[form[0][0]] == high)
        return block.places[0], at, next(j for j, form in enumerate(forms) if j != at and self.audit.supposed[form[0][0]] == low)

    def _of_halves(self, factor: float) -> Chance:
        """The chance that the second half of the draws shows the pair which the first half finds furthest apart."""
        compared, supposed = self.audit.comparison, self.audit.supposed
        listed = [compared.blocks[b] for b in ([self.audit.only[0]] if self.audit.only else range(len(compared.blocks)))]
        blocks = [np.array([form[0][0] for form in block]) for block in listed if len(block) > 1]
        if self.audit.only:
            blocks = [blocks[0][list(self.audit.only[1:])]]
        tables = max(TABLES // 8, min(TABLES, 3 * MOST_SUMS // sum(map(len, blocks))))
        generator = np.random.default_rng(SEED)
        furthest, chosen = np.full(tables, -inf), np.zeros((2, tables), dtype=np.int64)
        with np.errstate(divide="ignore"):
            for block in blocks:
                ends = np.array([self._first_half(supposed[i].grown(factor), generator, tables) for i in block.tolist()])
                high, low = ends[:, 0].argmax(axis=0), ends[:, 1].argmin(axis=0)
                every = np.arange(tables)
                apart = np.where(high == low, -inf, ends[high, 0, every] - ends[low, 1, every])
                better = apart > furthest
                furthest[better] = apart[better]
                chosen[:, better] = block[high[better]], block[low[better]]
        kinds = {cell: number for number, cell in enumerate(dict.fromkeys(supposed))}
        kind = np.array([kinds[cell] for cell in supposed])
        codes = np.where(furthest > -inf, kind[chosen[0]] * len(kinds) + kind[chosen[1]], -1)
        rejects, shown, cells = by_pairs(self.audit.alpha), np.zeros(tables, dtype=np.bool_), list(kinds)
        for code in sorted({*codes.tolist()} - {-1}):
            at = codes == code
            top, bottom = (cells[c].grown(factor) for c in divmod(code, len(kinds)))
            top, bottom = (replace(cell, draws=cell.draws - cell.draws // 2) for cell in (top, bottom))
            of_top, of_bottom = (cell.sums(generator, (int(at.sum()),)) for cell in (top, bottom))
            shown[at] = rejects(bottom, of_bottom, top, of_top, 1 / self.audit.limit)
        found = Counter(zip(*chosen[:, shown].tolist(), strict=True)) if shown.any() else Counter({tuple(blocks[0][:2].tolist()): 1})
        often = {pair for pair, times in found.items() if times >= max(found.values()) / 2}
        return Chance(
            float(shown.mean()), self._of_cells(*found.most_common(1)[0][0]), (), tuple(sorted({i for pair in often for i in pair}))
        )

    @staticmethod
    def _first_half(cell: Supposed, generator: np.random.Generator, tables: int) -> tuple[Floats, Floats]:
        """Logarithms of the ends by which the first half of a cell's draws chooses; without draws it is never chosen."""
        half = cell.draws // 2
        if not half:
            return np.full(tables, -inf), np.full(tables, inf)
        sums, scale = replace(cell, draws=half).sums(generator, (tables,)), float(SCALE)
        low, high = (np.log(score_end(half, sums, scale, side)) + log(cell.high) for side in (-1, 1))
        return low, high

    def _of_cells(self, high: int, low: int) -> tuple[int, int, int]:
        """The block of two cells, and where they are in it."""
        for b, block in enumerate(self.audit.comparison.blocks):
            members = [form[0][0] for form in block]
            if high in members:
                return b, members.index(high), members.index(low)
        raise ValueError(high)

    def _of_forms(self, factor: float) -> Chance:
        """The chance for forms of several cells, over the box."""
        compared, within, limit = self.audit.comparison, self.audit.side == "within", self.audit.limit
        used = sorted({i for block in compared.blocks for form in block for i, _ in form})
        tables = max(TABLES // 8, min(TABLES, MOST_SUMS // len(used)))
        ends = {}
        for i in used:
            cell = self.audit.supposed[i].grown(factor)
            sums = cell.sums(np.random.default_rng([SEED, i]), (tables,))
            low, high = (end_of_sums(cell, sums, self._box_level, self.audit.method, side) for side in ("lower", "upper"))
            ends[i] = low, high
        decided = np.full(tables, within)
        best: tuple[float, tuple[int, int, int]] | None = None
        for b, block in enumerate(compared.blocks):
            for i, top in enumerate(block):
                for j, bottom in enumerate(block):
                    if i == j:
                        continue
                    shown = _greatest(top, bottom, ends) <= limit if within else _greatest(bottom, top, ends) < 1 / limit
                    decided = decided & shown if within else decided | shown
                    of = 1 - float(shown.mean()) if within else float(shown.mean())
                    if best is None or of > best[0]:
                        best = of, (b, i, j)
        return Chance(float(decided.mean()), best[1] if best else None)


def _reach(nearest: float) -> float:
    """How far from the limit a pair may be so as to decide now and then, by the nearest one; of `exceeds` distances are negative."""
    return nearest * EASIER if nearest > 0 else nearest / EASIER


def _distances(classes: Kept, limit: float, side: Side) -> dict[tuple[int, int], float]:
    """For each pair of classes how many standard errors its ratio is below the limit; those that decide are the least."""
    found = {}
    for i, (high, many) in enumerate(classes):
        for j, (low, _) in enumerate(classes):
            if i != j or many > 1:
                found[i, j] = _distance(high, low, limit)
    if side == "exceeds":
        return {pair: d for pair, d in found.items() if d < 0} or found
    return found


def _distance(high: Supposed, low: Supposed, limit: float) -> float:
    if low.mean <= 0:
        return -inf
    if high.mean <= 0:
        return inf
    variance = sum(((cell.high - cell.low) / cell.mean * cell.deviation) ** 2 / cell.draws for cell in (high, low))
    gap = log(limit) - log(high.mean / low.mean)
    return gap / sqrt(variance) if variance > 0 else inf if gap > 0 else -inf


def _greatest(top: Form, bottom: Form, ends: dict[int, tuple[Floats, Floats]]) -> Floats:
    """The greatest quotient of two forms over a box of means: its threshold is at a cell, in an order that does not depend on the ends."""
    w, v = ({i: float(x) for i, x in form} for form in (top, bottom))
    above, below = (sum(x * ends[i][0] for i, x in form.items()) for form in (w, v))
    with np.errstate(divide="ignore", invalid="ignore"):
        best = np.where((above == 0) & (below == 0), 1.0, above / below)
        for i in sorted({**w, **v}, key=lambda i: -w[i] / v[i] if i in w and i in v else -inf if i in w else 0.0):
            gap = ends[i][1] - ends[i][0]
            above, below = above + w.get(i, 0.0) * gap, below + v.get(i, 0.0) * gap
            best = np.fmax(best, np.where((above == 0) & (below == 0), 1.0, above / below))
    found: Floats = best
    return found
