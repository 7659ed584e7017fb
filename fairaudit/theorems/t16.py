"""T16: how far the laws of single cells may move while a verdict stands, and the worst and best ratio within a declared drift.

Let B(s) and T(s) be what the lowest and the highest mass s of a cell's law contribute to its expectation E. If the law moves by a total
variation of at most η, its expectation lies between E + mη − T(η) and E + γη − B(η), m and γ being the least and greatest utility of the
cell over all decisions. If each probability changes by a factor of at most f, it lies between fB(s) + (E − B(s))/f and
fT(s) + (E − T(s))/f with s = 1/(1 + f). All four are attained. Cells move each on its own; overall the distribution of contexts in each
group is held fixed, so that a group's mean has the mean of these ends.

A verdict on R ≤ V stands as long as a piecewise linear function of η, or one with quadratic pieces of f, does not change its sign. Floats
find the pairs and pieces that matter, with an error bound that rules out all others; what is stated is decided in integers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf, isqrt
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT, compare_log, exp_enclosure
from fairaudit.exact.extended import ONE, ZERO, Extended, extended_pair
from fairaudit.exact.rationals import quotient
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.words import brief

__all__ = ["Extreme", "LawRadius", "Moving", "can_drift", "differing", "drifted_extremes", "law_radius", "moved_row"]

Form = Literal["radius", "factor"]
"""How a move is measured: total variation, or the factor by which probabilities change."""

STEP = 10**12
"""Radii that are irrational are rounded inwards to so many parts of one."""

MOST_FLOAT_CELLS = 1_000
"""Of float rows, which share no denominator, so many cells have exact means over contexts."""

LARGEST_EXPONENT = 10_000
"""Of limits on logarithms."""

SAFE = 1 << 62


@brief
@dataclass(frozen=True, repr=False)
class LawRadius:
    """How far every cell of a table may move, each on its own, while a verdict on it stands.

    Attributes
    ----------
    verdict : {"within", "exceeds"}
        The verdict on the table.
    form : {"radius", "factor"}
        Whether the move is a total variation, or the factor by which probabilities change.
    value : Fraction or float
        With "within" the verdict stands up to this value, with "exceeds" below it; `math.inf` if no move changes it.
    exact : bool
        Whether a move by this value, or one as close to it as one likes, changes the verdict. Otherwise the value is rounded inwards.
    pair : tuple or None
        Where it changes: the higher and the lower cell, or, overall, the positions of two groups; None if nothing changes it.
    """

    verdict: Literal["within", "exceeds"]
    form: Form
    value: Extended
    exact: bool
    pair: tuple[int, int] | None


@brief
@dataclass(frozen=True, repr=False)
class Extreme:
    """The greatest or the least ratio within a drift, and the pair of cells, or of groups overall, that attains it.

    Attributes
    ----------
    value : Fraction or float
        The ratio.
    pair : tuple or None
        The higher and the lower one; None where the ratio is 1.
    """

    value: Extended
    pair: tuple[int, int] | None


def can_drift(law: Law, table: UtilityTable, quantity: Quantity) -> bool:
    """Whether drift is measured: every decision of a cell has a utility of at least 0, and of float rows there are few means to be had."""
    return table.given is None and not table.signed and not (quantity == "global" and law.floating and len(law.weights) > MOST_FLOAT_CELLS)


# One mean


class Moves(Protocol):
    """A mean that can move: its ends, and those of its range, over `bottom`."""

    @property
    def most(self) -> Any:
        """What it is at the most."""

    @property
    def least(self) -> Any:
        """What it is at the least."""

    @property
    def most_seen(self) -> Any:
        """What it is at the most by decisions that are made at all."""

    @property
    def least_seen(self) -> Any:
        """What it is at the least by those."""

    @property
    def bottom(self) -> int:
        """The denominator."""

    def end(self, form: Form, amount: Fraction, *, up: bool) -> Fraction:
        """The greatest or least expectation within a drift."""

    def by_variation(self, eta: Fraction, *, up: bool) -> tuple[Any, Any]:
        """The end within about η as a line."""

    def by_factor(self, f: Fraction, *, up: bool) -> tuple[Any, Any, Any]:
        """The end within a factor of about f, times f, as af² + bf + c."""


class Mean:
    """The expectation of a cell, or the mean of some cells over contexts, and what its lowest and highest mass contribute to it.

    Parameters
    ----------
    weights : array of int, shape (cells, decisions)
        The laws, each up to its own factor.
    values : array of int
        The utilities, of all cells or of each.
    shares : sequence of int or None
        By which the rows are multiplied to be added up, if not by 1.
    scale : int
        The denominator of the utilities.
    """

    def __init__(self, weights: NDArray[Any], values: NDArray[Any], shares: Sequence[int] | None, scale: int) -> None:
        if shares is not None:
            some = [i for i, share in enumerate(shares) if share]
            weights, values = weights[some], values if values.ndim == 1 else values[some]
            shares = [shares[i] for i in some]
        g = np.broadcast_to(values, weights.shape)
        order = np.argsort(g, axis=1, kind="stable")
        g, w = np.take_along_axis(g, order, axis=1), np.take_along_axis(weights, order, axis=1)
        bound = (1 if shares is None else max(shares)) * (int(w.max()) + 1) * (int(g.max()) + 1) * w.shape[1] * len(w)
        if bound < SAFE:
            g, w = g.astype(np.int64), w.astype(np.int64)
        else:
            g, w = g.astype(object), w.astype(object)
        if shares is not None:
            w = w * np.array(shares, dtype=w.dtype)[:, None]
        self.sizes = w.sum(axis=1)
        self.bottom = int(self.sizes.sum()) * scale
        self.mean = int((w * g).sum())
        self.most, self.least = int((self.sizes * g[:, -1]).sum()), int((self.sizes * g[:, 0]).sum())
        there = w > 0
        rows = np.arange(len(w))
        first, last = there.argmax(axis=1), w.shape[1] - 1 - there[:, ::-1].argmax(axis=1)
        self.most_seen, self.least_seen = int((self.sizes * g[rows, last]).sum()), int((self.sizes * g[rows, first]).sum())
        self.rising, self.falling = _Pieces(w, g, self.sizes), _Pieces(w[:, ::-1], g[:, ::-1], self.sizes)

    def contributed(self, s: Fraction, *, top: bool) -> tuple[int, int]:
        """What the highest, or lowest, mass about s contributes, as a line a + bs over `bottom`."""
        return (self.falling if top else self.rising).line(s)

    def end(self, form: Form, amount: Fraction, *, up: bool) -> Fraction:
        """The greatest or least expectation within a drift."""
        if form == "radius":
            a, b = self.by_variation(amount, up=up)
            return (a + b * amount) / self.bottom
        s = 1 / (1 + amount)
        a, b = self.contributed(s, top=up)
        part = a + b * s
        return (amount * part + (self.mean - part) / amount) / self.bottom

    def by_variation(self, eta: Fraction, *, up: bool) -> tuple[int, int]:
        """The end within about η as a line over `bottom`."""
        a, b = self.contributed(eta, top=not up)
        return self.mean - a, (self.most if up else self.least) - b

    def by_factor(self, f: Fraction, *, up: bool) -> tuple[int, int, int]:
        """The end within a factor of about f, times f, as af² + bf + c over `bottom`."""
        a, b = self.contributed(1 / (1 + f), top=up)
        return a, b, self.mean - a - b


class _Pieces:
    """What the first mass of some rows contributes, decisions being in a certain order: one line for each row and decision."""

    def __init__(self, w: NDArray[Any], g: NDArray[Any], sizes: NDArray[Any]) -> None:
        before = np.zeros_like(w)
        before[:, 1:] = np.cumsum(w, axis=1)[:, :-1]
        taken = np.zeros_like(w)
        taken[:, 1:] = np.cumsum(w * g, axis=1)[:, :-1]
        self.before, self.sizes = before, sizes
        self.starts = taken - before * g
        self.slopes = sizes[:, None] * g

    @cached_property
    def edges(self) -> Floats:
        """Where pieces begin, in floats."""
        return np.array(self.before / self.sizes[:, None], dtype=np.float64)

    def line(self, s: Fraction) -> tuple[int, int]:
        """The sum of the lines at s."""
        at = float(s)
        begun = self.edges <= at
        for i, k in np.argwhere(np.abs(self.edges - at) <= 1e-9).tolist():
            begun[i, k] = int(self.before[i, k]) * s.denominator <= int(self.sizes[i]) * s.numerator
        piece = np.maximum(begun.sum(axis=1) - 1, 0)[:, None]
        return int(np.take_along_axis(self.starts, piece, axis=1).sum()), int(np.take_along_axis(self.slopes, piece, axis=1).sum())


# One ordered pair


def _sign(high: Moves, low: Moves, limit: Fraction, form: Form, amount: Fraction, *, within: bool) -> Fraction:
    """What keeps its sign while a verdict stands: at most 0 of *within*, above 0 of *exceeds*."""
    return high.end(form, amount, up=within) - limit * low.end(form, amount, up=not within)


def _stands_for_ever(high: Moves, low: Moves, limit: Fraction, form: Form, *, within: bool) -> bool:
    """Whether no move whatever changes what a pair says of a verdict that it gives."""
    if form == "radius":
        one = Fraction(high.most if within else high.least, high.bottom)
        other = Fraction(low.least if within else low.most, low.bottom)
        return one <= limit * other if within else one > limit * other
    one = Fraction(high.most_seen if within else high.least_seen, high.bottom)
    other = Fraction(low.least_seen if within else low.most_seen, low.bottom)
    return one <= limit * other if within else one >= limit * other


def _radius_of_pair(high: Moves, low: Moves, limit: Fraction, form: Form, *, within: bool) -> tuple[Extended, Extended]:
    """How far a verdict that a pair gives stands by it: twice where that is exact, else where it stands and where not."""
    if _stands_for_ever(high, low, limit, form, within=within):
        return inf, inf
    if form == "radius":
        return (_first_zero(high, low, limit, within=within),) * 2
    return _factor_of_pair(high, low, limit, within=within)


def _first_zero(high: Moves, low: Moves, limit: Fraction, *, within: bool) -> Fraction:
    """Newton's method from the left: of a concave, or convex, function no tangent crosses 0 beyond the first zero."""
    eta = ZERO
    while True:
        a, b = high.by_variation(eta, up=within)
        c, d = low.by_variation(eta, up=not within)
        slope = Fraction(b, high.bottom) - limit * Fraction(d, low.bottom)
        start = Fraction(a, high.bottom) - limit * Fraction(c, low.bottom)
        if start + slope * eta == 0:
            return eta
        eta = -start / slope


def _factor_of_pair(high: Moves, low: Moves, limit: Fraction, *, within: bool) -> tuple[Fraction, Fraction]:
    """The factor at which a pair changes its sign: twice where it is rational, else between two ends."""

    def stands(f: Fraction) -> bool:
        value = _sign(high, low, limit, "factor", f, within=within)
        return value <= 0 if within else value > 0

    low_end, high_end = ONE, Fraction(2)
    while stands(high_end):
        low_end, high_end = high_end, high_end**2
    while high_end - low_end > low_end / STEP:
        root = _root_of_piece(high, low, limit, (low_end + high_end) / 2, within=within)
        if root is not None and low_end <= root[0] <= root[1] <= high_end:
            inner, outer = root
            if inner == outer and _sign(high, low, limit, "factor", inner, within=within) == 0:
                return root
            if stands(inner) and not stands(outer):
                return root
        middle = (low_end + high_end) / 2
        middle = Fraction(round(middle * (1 << 60)), 1 << 60)
        low_end, high_end = (middle, high_end) if stands(middle) else (low_end, middle)
    return low_end, high_end


def _root_of_piece(high: Moves, low: Moves, limit: Fraction, at: Fraction, *, within: bool) -> tuple[Fraction, Fraction] | None:
    """The zero of the quadratic piece about a factor: twice if it is rational, else between two ends."""
    one, other = high.by_factor(at, up=within), low.by_factor(at, up=not within)
    a, b, c = (low.bottom * limit.denominator * p - high.bottom * limit.numerator * q for p, q in zip(one, other, strict=True))
    if a == 0:
        return None if b == 0 else (Fraction(-c, b), Fraction(-c, b))
    square = b * b - 4 * a * c
    if square < 0:
        return None
    if isqrt(square) ** 2 == square:
        roots = [Fraction(-b + sign * isqrt(square), 2 * a) for sign in (1, -1)]
        near = min(roots, key=lambda r: abs(r - at))
        return near, near
    fine = (STEP * 1000) ** 2
    whole = isqrt(square * fine)
    nearest = min((Fraction(-b * STEP * 1000 + sign * whole, 2 * a * STEP * 1000) for sign in (1, -1)), key=lambda r: abs(r - at))
    inner = Fraction(nearest * STEP // 1, STEP)
    return inner - Fraction(1, STEP), inner + Fraction(2, STEP)


# All pairs


class Moved(Protocol):
    """Means that are compared and can move: of a table, or between ends of cells."""

    starts: NDArray[np.int64]

    def mean(self, i: int) -> Moves:
        """One of the means."""

    def places(self, pair: tuple[int, int]) -> tuple[int, int]:
        """Where a pair is."""

    def blocks(self, form: Form, amount: Fraction, limit: Fraction, among: Sequence[int] | None, *, within: bool) -> list[int]:
        """Blocks some pair of which may be above 0, those that floats find highest first."""


class Moving:
    """The means that are compared, in blocks: contexts with the means of their cells, or one block of group means.

    Parameters
    ----------
    law, table : Law, UtilityTable
        The table, of which `can_drift` holds for the quantity.
    quantity : {"local", "global"}
        Which ratio; overall, the distribution of contexts in each group is held fixed.

    Examples
    --------
    >>> import fairaudit as fa
    >>> law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    >>> moving = Moving(law, fa.Utility({"yes": 1}).on(law), "local")
    >>> [str(moving.mean(1).end("radius", Fraction(1, 10), up=up)) for up in (False, True)]
    ['3/10', '1/2']
    """

    def __init__(self, law: Law, table: UtilityTable, quantity: Quantity) -> None:
        self.law, self.table, self.overall = law, table, quantity == "global"
        self.known: dict[int, Mean] = {}
        self.alike: dict[tuple[int, ...], Mean] = {}
        if self.overall:
            self.starts = np.array([0, len(law.global_groups)])
        else:
            self.cells = np.flatnonzero(law.compared)
            edges = np.flatnonzero(np.diff(law.cell_context[self.cells])) + 1
            self.starts = np.concatenate(([0], edges, [len(self.cells)]))

    def mean(self, i: int) -> Mean:
        """One of the means, exact."""
        if i not in self.known:
            self.known[i] = self._of_group(i) if self.overall else self._of_cell(int(self.cells[i]))
        return self.known[i]

    def _of_cell(self, cell: int) -> Mean:
        values = self.table.values if self.table.by_decision else self.table.values[cell]
        row = np.array(self.law.row(cell), dtype=object)
        key = (*row.tolist(), *values.tolist())
        if key not in self.alike:
            self.alike[key] = Mean(row[None, :], values, None, self.table.scale)
        return self.alike[key]

    def _of_group(self, i: int) -> Mean:
        law, table = self.law, self.table
        cells = np.flatnonzero(law.cell_group == law.global_groups[i])
        shares: Sequence[int] | None = None
        if law.population != "counts":
            coefficients, _ = law.mixing
            shares = [int(coefficients[c]) for c in cells.tolist()]
        weights = np.array([law.row(c) for c in cells.tolist()], dtype=object) if law.floating else law.weights[cells]
        return Mean(weights, table.values if table.by_decision else table.values[cells], shares, table.scale)

    def places(self, pair: tuple[int, int]) -> tuple[int, int]:
        """Cells of the law, or positions among the groups that are compared overall."""
        return pair if self.overall else (int(self.cells[pair[0]]), int(self.cells[pair[1]]))

    @cached_property
    def _floats(self) -> tuple[Floats, Floats, Floats, float]:
        """Of all cells: probabilities and utilities, from the least one on, in a unit that makes the greatest 1; and their error."""
        law, values = self.law, self.table.values
        top = max(int(values.max()), 1)
        unit = (
            values.astype(np.float64) / top
            if values.dtype != object
            else np.array([int(v) / top for v in values.ravel()]).reshape(values.shape)
        )
        p = law.float_rows(np.arange(len(law.weights)) if self.overall else self.cells)
        if unit.ndim == 1:
            order = np.argsort(unit, kind="stable")
            p, g = p[:, order], unit[order]
        else:
            g = unit if self.overall else unit[self.cells]
            by = np.argsort(g, axis=1, kind="stable")
            p, g = np.take_along_axis(p, by, axis=1), np.take_along_axis(g, by, axis=1)
        expected = (p * g).sum(axis=1)
        return p, g, expected, 16 * (p.shape[1] + 4) ** 2 * UNIT

    def _ends(self, form: Form, amount: float, some: NDArray[np.int64] | slice) -> tuple[Floats, Floats, float]:
        """Least and greatest expectation of some cells within a drift, in floats, and a bound of their error."""
        p, g, expected, slack = self._floats
        p, expected = p[some], expected[some]
        g = g if g.ndim == 1 else g[some]
        s = amount if form == "radius" else 1 / (1 + amount)
        lowest = _first_mass(p, g, s)
        highest = _first_mass(p[:, ::-1], g[..., ::-1], s)
        if form == "radius":
            return expected + g[..., 0] * s - highest, expected + g[..., -1] * s - lowest, slack
        return (
            amount * lowest + (expected - lowest) / amount,
            amount * highest + (expected - highest) / amount,
            slack * (amount + 2),
        )

    def blocks(self, form: Form, amount: Fraction, limit: Fraction, among: Sequence[int] | None, *, within: bool) -> list[int]:
        """Blocks some pair of which may be above 0, those that floats find highest first."""
        if self.overall:
            return [0] if self.starts[1] > 1 else []
        numbers = np.arange(len(self.starts) - 1) if among is None else np.array(among, dtype=np.int64)
        if not len(numbers) or limit > 1e100 or amount > 1e100:
            return [int(b) for b in numbers]
        if among is None:
            some: NDArray[np.int64] | slice = slice(None)
            edges = self.starts[:-1]
        else:
            sizes = self.starts[numbers + 1] - self.starts[numbers]
            edges = np.concatenate(([0], np.cumsum(sizes)[:-1]))
            some = np.concatenate([np.arange(self.starts[b], self.starts[b + 1]) for b in numbers.tolist()])
        low, high, slack = self._ends(form, float(amount), some)
        v = float(limit)
        if within:
            found = np.maximum.reduceat(high, edges) - v * np.minimum.reduceat(low, edges)
        else:
            found = np.maximum.reduceat(low, edges) - v * np.minimum.reduceat(high, edges)
        possible = np.flatnonzero(found > -(1 + v) * (slack + 8 * UNIT * (1 + float(amount))))
        return [int(numbers[k]) for k in possible[np.argsort(-found[possible], kind="stable")].tolist()]


def _first_mass(p: Floats, g: Floats, s: float) -> Floats:
    """What the first mass s of each row contributes."""
    left = np.full(len(p), s)
    found = np.zeros(len(p))
    for k in range(p.shape[1]):
        part = np.minimum(p[:, k], left)
        found += part * (g[k] if g.ndim == 1 else g[:, k])
        left = left - part
    return found


def law_radius(moving: Moved, decided: Extended, limit: Fraction, unit: str, form: Form) -> LawRadius:
    """Find how far every cell of a table may move, each on its own, while the verdict on a limit stands.

    Source: T16.

    Parameters
    ----------
    moving : Moving
        What is compared.
    decided : Fraction or float
        The ratio of the table; of ends of cells that are known alone, the end of the ratio that decides.
    limit : Fraction
        The limit on the ratio, at least 1, or on its logarithm, at least 0.
    unit : {"ratio", "log"}
        Which of the two.
    form : {"radius", "factor"}
        Whether the move is a total variation, or the factor by which probabilities change.

    Returns
    -------
    LawRadius
        The verdict and how far it stands.

    Examples
    --------
    >>> import fairaudit as fa
    >>> law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    >>> table = fa.Utility({"yes": 1}).on(law)
    >>> from fairaudit.measures.ratios import local_fairness
    >>> found = law_radius(Moving(law, table, "local"), local_fairness(law, table).ratio, Fraction(2), "ratio", "radius")
    >>> found.verdict, found.value, found.exact
    ('within', Fraction(1, 10), True)
    """
    if unit == "ratio" or limit == 0:
        bound = ONE if unit == "log" else limit
        within = decided <= bound
        return _searched(moving, bound, form, within=within)
    within = compare_log(extended_pair(decided), (limit.numerator, limit.denominator)) <= 0
    if limit > LARGEST_EXPONENT:
        return LawRadius("within" if within else "exceeds", form, ZERO if form == "radius" else ONE, exact=False, pair=None)
    bits = 128
    while True:
        low, high = (Fraction(end, 1 << bits) for end in exp_enclosure((limit.numerator, limit.denominator), bits))
        if decided <= low if within else decided > high:
            break
        bits *= 2
    found = _searched(moving, low if within else high, form, within=within)
    if found.value == inf:
        return found
    return replace(found, value=Fraction(int(Fraction(found.value) * STEP), STEP), exact=False)


def _searched(compared: Moved, limit: Fraction, form: Form, *, within: bool) -> LawRadius:
    """The least radius of the pairs of *within*, the greatest of *exceeds*: a pair that is above 0 at the best so far has a better one."""
    verdict: Literal["within", "exceeds"] = "within" if within else "exceeds"
    start = ZERO if form == "radius" else ONE
    best: Extended = inf if within else start
    beyond: Extended = best
    pair: tuple[int, int] | None = None
    # Moves that are far, from which a search for *within* begins
    amount = ONE if form == "radius" else Fraction(1 << 40)
    open_blocks = compared.blocks(form, amount if within else start, limit, None, within=within)
    if within and form == "factor":
        open_blocks = list(range(len(compared.starts) - 1)) if compared.starts[-1] else []
    if within and open_blocks:
        # The pair that is most unequal here leaves few others to be looked at.
        at_start = compared.blocks(form, start, limit, None, within=True) or compared.blocks(form, start, ONE, None, within=True)
        for block in at_start[:1]:
            _, first = _greatest(compared, block, form, start, limit, within=True)
            best, beyond = _radius_of_pair(compared.mean(first[0]), compared.mean(first[1]), limit, form, within=True)
            pair = first if best != inf else None
        if best != inf:
            open_blocks = compared.blocks(form, Fraction(best), limit, open_blocks, within=True)
    while open_blocks:
        block = open_blocks[0]
        moved = False
        while True:
            if within and best == inf:
                found = _pair_that_flips(compared, block, limit, form)
                if found is None:
                    break
            else:
                value, found = _greatest(compared, block, form, Fraction(best if within else beyond), limit, within=within)
                if value <= 0:
                    break
            one, other = compared.mean(found[0]), compared.mean(found[1])
            best, beyond = _radius_of_pair(one, other, limit, form, within=within)
            pair, moved = found, True
            if best == inf:
                return LawRadius(verdict, form, inf, exact=True, pair=None if within else compared.places(found))
        open_blocks = open_blocks[1:]
        if moved:
            open_blocks = compared.blocks(form, Fraction(best if within else beyond), limit, open_blocks, within=within)
    return LawRadius(verdict, form, best, best == beyond, None if pair is None else compared.places(pair))


def _greatest(
    compared: Moved, block: int, form: Form, amount: Fraction, limit: Fraction, *, within: bool
) -> tuple[Fraction, tuple[int, int]]:
    """The ordered pair of a block with the greatest sign."""
    members = range(int(compared.starts[block]), int(compared.starts[block + 1]))
    tops = {i: compared.mean(i).end(form, amount, up=within) for i in members}
    bottoms = {i: compared.mean(i).end(form, amount, up=not within) for i in members}
    high = sorted(members, key=lambda i: -tops[i])[:2]
    low = sorted(members, key=lambda i: bottoms[i])[:2]
    return max(((tops[i] - limit * bottoms[j], (i, j)) for i in high for j in low if i != j), key=lambda one: one[0])


def _pair_that_flips(compared: Moved, block: int, limit: Fraction, form: Form) -> tuple[int, int] | None:
    """A pair of a block that some move takes above a limit."""
    members = range(int(compared.starts[block]), int(compared.starts[block + 1]))
    seen = form == "factor"

    def top(i: int) -> Fraction:
        mean = compared.mean(i)
        return Fraction(mean.most_seen if seen else mean.most, mean.bottom)

    def bottom(i: int) -> Fraction:
        mean = compared.mean(i)
        return Fraction(mean.least_seen if seen else mean.least, mean.bottom)

    tops, bottoms = sorted(members, key=lambda i: -top(i))[:2], sorted(members, key=bottom)[:2]
    return next(((i, j) for i in tops for j in bottoms if i != j and top(i) > limit * bottom(j)), None)


# Within a declared drift


def drifted_extremes(compared: Moved, drift: Fraction) -> tuple[Extreme, Extreme] | None:
    """Find the greatest and the least ratio of all tables whose cells are, each on its own, within a total variation of those of this one.

    Source: T16.

    Parameters
    ----------
    compared : Moving
        What is compared.
    drift : Fraction
        The total variation, from 0 to 1.

    Returns
    -------
    tuple of Extreme or None
        The greatest and the least; None where nothing is compared.

    Examples
    --------
    >>> import fairaudit as fa
    >>> law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    >>> [str(one.value) for one in drifted_extremes(Moving(law, fa.Utility({"yes": 1}).on(law), "local"), Fraction(1, 20))]
    ['11/7', '1']
    """
    if len(compared.starts) < 2 or compared.starts[1] < 2:
        return None
    return _extreme(compared, drift, worst=True), _extreme(compared, drift, worst=False)


def _extreme(compared: Moved, drift: Fraction, *, worst: bool) -> Extreme:
    """The greatest quotient of an upper and a lower end, or of a lower and an upper one, of a block; at least 1."""
    best: Extended = ONE
    pair: tuple[int, int] | None = None
    blocks = compared.blocks("radius", drift, ONE, None, within=worst)
    while blocks and best != inf:
        members = range(int(compared.starts[blocks[0]]), int(compared.starts[blocks[0] + 1]))
        tops = {i: compared.mean(i).end("radius", drift, up=worst) for i in members}
        bottoms = {i: compared.mean(i).end("radius", drift, up=not worst) for i in members}
        high = sorted(members, key=lambda i: -tops[i])[:2]
        low = sorted(members, key=lambda i: bottoms[i])[:2]
        moved = False
        for i in high:
            for j in low:
                value = quotient(tops[i], bottoms[j]) if i != j else ONE
                if value > best:
                    best, pair, moved = value, (i, j), True
        blocks = blocks[1:]
        if moved and best != inf:
            blocks = compared.blocks("radius", drift, Fraction(best), blocks, within=worst)
    return Extreme(best, None if pair is None else compared.places(pair))


def moved_row(row: Sequence[int], values: Sequence[int], form: Form, amount: Fraction, *, up: bool) -> list[Fraction]:
    """A law within a drift of a given one that has the greatest, or the least, expectation of all.

    Parameters
    ----------
    row, values : sequence of int
        The law, up to a factor, and the utilities.
    form, amount
        The drift.
    up : bool
        Whether the greatest is wanted.

    Returns
    -------
    list of Fraction
        Its probabilities.

    Examples
    --------
    >>> [str(p) for p in moved_row([2, 3], [1, 0], "radius", Fraction(1, 10), up=False)]
    ['3/10', '7/10']
    >>> [str(p) for p in moved_row([1, 3], [1, 0], "factor", Fraction(2), up=True)]
    ['1/2', '1/2']
    """
    total = sum(row)
    p = [Fraction(w, total) for w in row]
    order = sorted(range(len(row)), key=lambda u: values[u], reverse=not up)
    if form == "radius":
        left = amount
        moved = [*p]
        for u in order:
            part = min(p[u], left)
            moved[u] -= part
            left -= part
        moved[order[-1]] += amount - left
        return moved
    left = 1 - sum(p, ZERO) / amount
    moved = [q / amount for q in p]
    for u in reversed(order):
        part = min(left, p[u] * (amount - 1 / amount))
        moved[u] += part
        left -= part
    return moved


def differing(first: Sequence[Fraction], second: Sequence[Fraction]) -> Fraction:
    """Total variation of two laws.

    Examples
    --------
    >>> differing([Fraction(1, 2), Fraction(1, 2)], [Fraction(2, 5), Fraction(3, 5)])
    Fraction(1, 10)
    """
    return sum((abs(p - q) for p, q in zip(first, second, strict=True)), ZERO) / 2
