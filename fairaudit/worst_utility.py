"""The utility of a class that makes a law look worst: sup of the local or global ratio over g, enclosed between exact ends.

R_lo is attained by a utility that is exactly in the class; R_hi is proved for all of the class by weak duality. Floats only search:
whatever a solver answers, wrong answers can loosen [R_lo, R_hi] or end in a refusal, but not make it false.

A class that only has a range [m, γ] and one common floor is solved in closed form (T3, T4 on the rows P(·|x,a)); then R_lo = R_hi. Other
classes are linear-fractional programs, one per ordered pair of groups, solved by HiGHS (Charnes–Cooper), whose vertex and multipliers are
solved again in rationals. For multipliers y ≥ 0 of the constraints A v ≤ b and a box around the variables v, every R with

    F(R) = Σ_j max over the box of c_j(R)·v_j + y·b ≤ 0,   c(R) = p − R·q − y·A,

bounds p·v/q·v, however the multipliers were found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import gcd, inf, isqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact import InputError, log_enclosure
from fairaudit.fairness import Witness, global_fairness, least_expectation, local_fairness
from fairaudit.law import Law
from fairaudit.utility import Utility
from fairaudit.utility_class import Ball, LinearRow, Setting, UtilityClass, lay_out

__all__ = ["WorstCase", "worst_case"]

Extended = Fraction | float
Quantity = Literal["local", "global"]
Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
UNIT = 2.0**-53
HUGE = 1e300
ENTRIES = 1_000_000
LOOKED_AT = 64
FEW = 256
ROUNDING = 2**44
TOLERANCES = (1e-9, 1e-7, 1e-11, 1e-5)
LARGEST = Fraction(10) ** 200
ZERO, ONE = Fraction(0), Fraction(1)


@dataclass(frozen=True, eq=False)
class WorstCase:
    """The worst utility of a class for a law, between exact ends.

    Attributes
    ----------
    law : Law
        The law.
    utility_class : UtilityClass
        The class.
    quantity : {"local", "global"}
        Which ratio.
    upper, lower : Fraction or float
        R_hi, proved for every utility of the class, and R_lo, attained by `utility`; `math.inf` where the ratio is unbounded.
    witness : Witness
        The pair that attains `lower`, and its two expected utilities.
    method : {"closed form", "lp", "conic"}
        How it was found.
    certified : bool
        Whether the class that `upper` is about is the class itself: false for a ball, of which `upper` bounds a box around it.
    estimate : float or None
        The solver's own value, where it is not certified.
    by : {"T3", "lp-dual"}
        How `upper` is proved.
    theta : tuple of Fraction or None
        The parameters of `utility` in a family.
    """

    law: Law
    utility_class: UtilityClass
    quantity: Quantity
    upper: Extended
    lower: Extended
    witness: Witness
    method: Literal["closed form", "lp", "conic"]
    by: Literal["T3", "lp-dual"]
    theta: tuple[Fraction, ...] | None = None
    certified: bool = True
    estimate: float | None = None
    setting: Any = field(default=None, repr=False)
    values: Mapping[int, Sequence[Fraction]] = field(default_factory=dict, repr=False)
    """g by row of the utility (cells, or positions of contexts in a blind class); γ where none is given."""
    proof: Callable[[], dict[str, Any]] = field(default=dict, repr=False)
    shown: tuple[Mapping[int, Sequence[Fraction]], tuple[Fraction, ...] | None] | None = field(default=None, repr=False)
    """Another utility (and θ) for the certificate, where under the worst one groups without the floor differ more."""

    @property
    def gap(self) -> float:
        """Relative gap (R_hi − R_lo)/R_lo."""
        if self.upper == self.lower:
            return 0.0
        if not isinstance(self.upper, Fraction) or not isinstance(self.lower, Fraction):
            return inf
        gap = (self.upper - self.lower) / self.lower
        return float(gap) if gap < 10**300 else inf

    @cached_property
    def evidence(self) -> dict[str, Any]:
        """What proves `upper`, as docs/certificate-worst-case.md lists it, numbers as `Fraction`."""
        return self.proof()

    @cached_property
    def utility(self) -> Utility:
        """The worst utility, exactly in the class: the same g(u) in every context where that is in the class too."""
        return _utility(self.setting, self.values)

    @property
    def certified_utility(self) -> Utility:
        """The utility for the certificate: the worst one, unless there groups that do not keep the floor differ more."""
        return self.utility if self.shown is None else _utility(self.setting, self.shown[0])

    @property
    def certified_theta(self) -> tuple[Fraction, ...] | None:
        """Its parameters in a family."""
        return self.theta if self.shown is None else self.shown[1]

    @property
    def bounded_class(self) -> UtilityClass:
        """The class that `upper` bounds: the class itself, or, for a ball, the box around it."""
        of: UtilityClass = self.setting.of
        return of

    def keeps_floor(self, witness: Witness) -> bool:
        """Tell whether the groups that have to keep the floor do so under `certified_utility`, for a pair in this context."""
        setting: Setting = self.setting
        values = self.values if self.shown is None else self.shown[0]
        return _keeps_floor(setting, values, witness)


def _keeps_floor(setting: Setting, values: Mapping[int, Sequence[Fraction]], witness: Witness) -> bool:
    if setting.of.tau is None:
        return True
    if setting.of.tau_on == "pair":
        return bool(min(witness.expectations) >= setting.of.tau)
    block = _block_of(setting, witness)
    return all(_value(setting, member, values) >= setting.of.tau for member in setting.members[block])


def _block_of(setting: Setting, witness: Witness) -> int:
    if witness.context is None:
        return 0
    labels = [None if place is None else setting.law.context_label(setting.contexts[place]) for place in setting.places]
    return labels.index(witness.context)


def _utility(setting: Setting, values: Mapping[int, Sequence[Fraction]]) -> Utility:
    """A utility from its rows; γ where none is given."""
    law, of = setting.law, setting.of
    rows = {tuple(row) for row in values.values()}
    if of.blind and not of.couples and len(rows) == 1:
        everywhere = Utility(dict(zip(law.decisions, next(iter(rows)), strict=True)))
        if len(values) == len(setting.contexts):
            return everywhere
        if setting.quantity == "local" and (least_expectation(law, everywhere.on(law)) or ZERO) >= of.floor > 0:
            return everywhere
    entries = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        row = values.get(setting.place_of[cell] if of.blind else cell)
        for u, label in enumerate(law.decisions):
            value = of.gamma if row is None else row[u]
            entries[label, law.contexts[x], law.groups[a]] = (value.numerator, value.denominator)
    if len(set(entries.values())) == 1:
        return Utility(dict.fromkeys(law.decisions, Fraction(*next(iter(entries.values())))))
    return Utility({}, entries)


def worst_case(law: Law, utility_class: UtilityClass, quantity: Quantity = "local") -> WorstCase:
    """Find the utility of a class for which a law looks worst.

    Parameters
    ----------
    law : Law
        The law P(u|x,a).
    utility_class : UtilityClass
        The class 𝒢.
    quantity : {"local", "global"}
        Whether groups are compared within each context, or by their means over contexts.

    Returns
    -------
    WorstCase
        R_lo ≤ sup over 𝒢 of R ≤ R_hi, exact ends, with the utility that attains R_lo and the proof of R_hi.

    Raises
    ------
    InputError
        If the class is empty, does not fit the law, or nothing can be compared. Source: theory, worst-case g; T3, T4 and T6.

    Examples
    --------
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> worst_case(law, UtilityClass(tau="1/4")).upper
    Fraction(2, 1)
    >>> found = worst_case(law, UtilityClass(tau="3/4", order=["no", "yes"]))
    >>> found.lower, found.upper, found.utility.values["no"]
    (Fraction(7, 6), Fraction(7, 6), Fraction(1, 2))
    """
    setting = lay_out(law, utility_class, quantity)
    if utility_class.closed_form:
        return _closed_form(setting)
    if utility_class.ball is not None:
        return _conic(setting)
    return _linear(setting)


# The closed form: one common floor


@dataclass(frozen=True, eq=False)
class _Rows:
    """Laws of the members compared, sorted into blocks: in floats, and exactly."""

    floats: Floats
    starts: Indices
    exact: Callable[[int], list[int]]
    sources: list[int]
    """The cell or group of each member."""
    stored: NDArray[Any] | None = None
    """The rows as they are stored: members with equal stored rows are surely equal."""

    def block(self, member: int) -> int:
        return int(np.searchsorted(self.starts, member, side="right")) - 1


@dataclass(frozen=True)
class _Range:
    """γ, m and the floor, exactly and in floats."""

    gamma: Fraction
    m: Fraction
    floor: Fraction

    @property
    def width(self) -> Fraction:
        return self.gamma - self.m

    @cached_property
    def start(self) -> Fraction:
        """Least E_Q φ for g = m + (γ − m)φ."""
        return (self.floor - self.m) / self.width

    @cached_property
    def scaled(self) -> tuple[float, float, float]:
        """(γ − m)/τ, m/τ and the start; the first infinite where floats do not reach."""
        if self.width > self.floor * 10**290 or 0 < self.start < Fraction(1, 10**290):
            return inf, 0.0, 0.0
        return float(self.width / self.floor), float(self.m / self.floor), float(self.start)


def _closed_form(setting: Setting) -> WorstCase:
    of, rows = setting.of, _rows(setting)
    span = _Range(of.gamma, of.m, of.floor)
    if not span.width:
        return _closed(setting, ONE, (int(rows.starts[0]), int(rows.starts[0]) + 1), [of.gamma] * rows.floats.shape[1], rows, lambda: [ONE])
    if not span.floor:
        ratio, column, pair = _greatest_quotient(rows)
        values = [ZERO] * rows.floats.shape[1]
        values[column] = of.gamma
        return _closed(setting, ratio, pair, values, rows, lambda: [ratio] if isinstance(ratio, Fraction) else [])
    sieve = _Sieve(rows, span)
    best = sieve.run()
    return _closed(setting, best.ratio, best.pair, best.values, rows, sieve.multipliers)


def _rows(setting: Setting) -> _Rows:
    """Rows P(·|x,a) of compared cells, or P(u,x|a) of the global groups."""
    law = setting.law
    if setting.quantity == "local":
        cells = np.flatnonzero(law.compared)
        weights = law.weights if len(cells) == len(law.weights) else law.weights[cells]
        sizes = [len(block) for block in setting.members]
        floats = law.float_rows(cells)
        starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        return _Rows(floats, starts, lambda i: law.row(int(cells[i])), cells.tolist(), weights)
    n, places = setting.n, setting.place_of
    listed: list[list[int]] = []
    coefficients, totals = law.mixing
    for a in law.global_groups:
        row = [0] * (len(setting.contexts) * n)
        for cell in np.flatnonzero(law.cell_group == a).tolist():
            c = int(coefficients[cell])
            if c:
                row[places[cell] * n : (places[cell] + 1) * n] = [c * v for v in law.row(cell)]
        listed.append(row)
    floats = np.array([[v / totals[a] for v in row] for a, row in zip(law.global_groups, listed, strict=True)], dtype=np.float64)
    return _Rows(floats, np.array([0, len(listed)], dtype=np.int64), listed.__getitem__, list(law.global_groups))


def _greatest_quotient(rows: _Rows) -> tuple[Extended, int, tuple[int, int]]:
    """Greatest P(j|a)/P(j|a') (T6), exact, with its column and pair."""
    floats, edges = rows.floats, rows.starts[:-1]
    error = (2 * floats.shape[1] + 16) * UNIT
    top, low = np.maximum.reduceat(floats, edges), np.minimum.reduceat(floats, edges)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        quotient = np.where(low > 0, top / low, np.where(top > 0, np.inf, 1.0))
    tiny = (low < HUGE**-1) & (top > 0)
    upper = np.where(tiny, np.inf, quotient * (1 + 3 * error))
    lower = np.where(tiny, 1.0, quotient * (1 - 3 * error))
    best: tuple[Extended, int, tuple[int, int]] = (ONE, 0, (int(edges[0]), int(edges[0]) + 1))
    for block, column in np.argwhere(upper >= max(1.0, float(lower.max(initial=1.0)))).tolist():
        members = range(int(rows.starts[block]), int(rows.starts[block + 1]))
        near = floats[members.start : members.stop, column]
        highest, least = float(near.max()), float(near.min())
        wanted = [
            i
            for i, v in zip(members, near.tolist(), strict=True)
            if v >= highest * (1 - 3 * error) or v <= least * (1 + 3 * error) or v < HUGE**-1
        ]
        values = [(Fraction(row[column], sum(row)), i) for i in wanted for row in (rows.exact(i),)]
        (high, i), (small, j) = max(values, key=lambda e: (e[0], -e[1])), min(values)
        ratio: Extended = high / small if small else (inf if high else ONE)
        if ratio > best[0]:
            best = (ratio, column, (i, j))
        if ratio == inf:
            break
    return best


@dataclass(frozen=True)
class _Best:
    """The exact answer for an ordered pair of rows, the k that proves it, and the utility row that attains it."""

    ratio: Fraction
    k: Fraction
    values: list[Fraction]
    pair: tuple[int, int]


def _most_powerful(rows: _Rows, pair: tuple[int, int], span: _Range) -> _Best:
    """T3 and T4 for one ordered pair: the greatest E_P g/E_Q g over m ≤ g ≤ γ with E_Q g at least the floor.

    With g = m + (γ − m)φ the ratio along the Neyman–Pearson curve is greatest where s = E_Q φ is least, or at a vertex.
    """
    p, q = rows.exact(pair[0]), rows.exact(pair[1])
    top, bottom = sum(p), sum(q)
    scale = gcd(top, bottom)
    up, down = bottom // scale, top // scale
    parts = [(v * up, w * down, j) for j, (v, w) in enumerate(zip(p, q, strict=True)) if v or w]
    whole = top * up  # both rows now sum to it
    infinite = [part for part in parts if not part[1]]
    finite = sorted((part for part in parts if part[1]), key=lambda part: Fraction(part[0], part[1]), reverse=True)
    start, width, m = span.start, span.width, span.m
    phi = {j: ONE for _, _, j in infinite}
    s, power = ZERO, Fraction(sum(v for v, _, _ in infinite), whole)

    def ratio(level: Fraction, value: Fraction) -> Fraction:
        return (m + width * value) / (m + width * level)

    position = 0
    while position < len(finite) and s + Fraction(finite[position][1], whole) <= start:
        v, w, j = finite[position]
        s, power, phi[j] = s + Fraction(w, whole), power + Fraction(v, whole), ONE
        position += 1
    if s < start:
        v, w, j = finite[position]
        share = (start - s) / Fraction(w, whole)
        s, power, phi[j] = start, power + share * Fraction(v, whole), share
    k = Fraction(finite[position][0], finite[position][1]) if position < len(finite) else ZERO
    best, chosen = ratio(s, power), dict(phi)
    while position < len(finite) and m:
        v, w, j = finite[position]
        if Fraction(v, w) <= best:
            break
        rest = 1 - phi.get(j, ZERO)
        s, power, phi[j] = s + rest * Fraction(w, whole), power + rest * Fraction(v, whole), ONE
        position += 1
        best, chosen = ratio(s, power), dict(phi)
        k = best
    return _Best(best, k, [m + width * chosen.get(j, ZERO) for j in range(len(p))], pair)


class _Sieve:
    """Finds the greatest ratio over all ordered pairs of a block, evaluating exactly only what could be it.

    Every k bounds every pair, R ≤ k + max(0, (γ − m)·H_k − (k − 1)·m)/τ (T4), at the price of one pass; a pair whose bound with a rigorous
    error stays below the best exact ratio is out, and that k proves so in the certificate.
    """

    def __init__(self, rows: _Rows, span: _Range) -> None:
        self.rows, self.span = rows, span
        self.used: list[Fraction] = []
        self.cache: dict[tuple[tuple[int, ...], tuple[int, ...]], _Best] = {}
        self.best: _Best | None = None
        self.rest: tuple[Indices, Indices] = (np.zeros(0, np.int64), np.zeros(0, np.int64))

    def error(self, k: Any) -> Any:
        """Bound on the float error of the bound at k."""
        slope, least, _ = self.span.scaled
        n = self.rows.floats.shape[1]
        return (slope + least + 1.0) * (1.0 + k) * (4 * n + 64) * UNIT

    @property
    def level(self) -> float:
        """A float that is surely at most the best exact ratio."""
        if self.best is None:
            return 1.0
        return float(min(self.best.ratio, Fraction(10) ** 300)) * (1 - 4 * UNIT)

    def at(self, k: Any, sticks: Floats) -> Floats:
        """Upper bounds of ratios, from float hockey sticks H_k."""
        slope, least, _ = self.span.scaled
        with np.errstate(over="ignore", invalid="ignore"):
            bound: Floats = k + np.maximum(slope * sticks - (k - 1.0) * least, 0.0) + self.error(k)
        return np.nan_to_num(bound, nan=np.inf, posinf=np.inf)

    def everywhere(self, k: float) -> Iterator[tuple[Indices, int, Floats]]:
        """Bounds at k of all ordered pairs, by blocks of one size: first rows of blocks, size, bounds (block, higher, lower)."""
        rows = self.rows
        sizes = np.diff(rows.starts)
        n = rows.floats.shape[1]
        ones = np.ones(n)
        for size in np.unique(sizes).tolist():
            every = rows.starts[:-1][sizes == size]
            step = max(1, 200_000 // (size * n))
            for begin in range(0, len(every), step):
                base = every[begin : begin + step]
                block = rows.floats[base[:, None] + np.arange(size)]
                scaled = block * k
                buffer = np.empty_like(block)
                sticks = np.empty((len(base), size, size))
                for i in range(size):
                    np.maximum(block[:, i : i + 1], scaled, out=buffer)
                    sticks[:, i] = buffer @ ones
                sticks -= k
                np.maximum(sticks, 0.0, out=sticks)
                bounds = self.at(k, sticks)
                bounds[:, np.arange(size), np.arange(size)] = 0.0
                if rows.stored is not None:
                    # Rows that agree in floats may still differ exactly.
                    alike = np.flatnonzero((block == block[:, :1]).all(axis=(1, 2)))
                    stored = rows.stored[base[alike][:, None] + np.arange(size)]
                    bounds[alike[(stored == stored[:, :1]).all(axis=(1, 2))]] = 0.0
                yield base, size, bounds

    def run(self) -> _Best:
        slope, _, _ = self.span.scaled
        first = (int(self.rows.starts[0]), int(self.rows.starts[0]) + 1)
        self.best = _Best(ONE, ONE, [self.span.gamma] * self.rows.floats.shape[1], first)
        if slope == inf or sum(size * (size - 1) for size in np.diff(self.rows.starts).tolist()) <= FEW // 4:
            self._everything()
            return self.best
        self._seed()
        for _ in range(2):
            # The bound at k is at least k, so a k at the ratio itself would rule out nobody.
            level = self.level
            k = min(float(self.best.k), max(level - 4 * float(self.error(level)), 0.0))
            highs, lows, bounds = self._above(k)
            self._note(k)
            self.rest = (highs, lows)
            if len(highs) <= LOOKED_AT:
                break
            before = self.best
            self._try(highs, lows, bounds)
            if self.best is before:
                break
        self._finish()
        return self.best

    def _note(self, k: float) -> None:
        exact = Fraction(k)
        if exact not in self.used:
            self.used.append(exact)

    def _seed(self) -> None:
        """Look at the pairs that are farthest apart in total variation."""
        tops: list[tuple[Floats, Indices, Indices]] = []
        for base, size, bounds in self.everywhere(1.0):
            flat = bounds.reshape(len(base), -1)
            chosen = flat.argmax(axis=1)
            tops.append((flat[np.arange(len(base)), chosen], base + chosen // size, base + chosen % size))
        values, highs, lows = (np.concatenate(part) for part in zip(*tops, strict=True))
        keep = values > 0
        self._try(highs[keep], lows[keep], values[keep])

    def _above(self, k: float) -> tuple[Indices, Indices, Floats]:
        """Ordered pairs whose bound at k exceeds the best ratio."""
        found: list[tuple[Indices, Indices, Floats]] = []
        level = self.level
        for base, size, bounds in self.everywhere(k):
            where = np.flatnonzero(bounds > level)
            block, pair = where // (size * size), where % (size * size)
            found.append((base[block] + pair // size, base[block] + pair % size, bounds.ravel()[where]))
        highs, lows, values = (np.concatenate(part) for part in zip(*found, strict=True))
        return highs, lows, values

    def _try(self, highs: Indices, lows: Indices, bounds: Floats) -> None:
        """Evaluate the most promising pairs in floats, and the best of them exactly."""
        if not len(highs):
            return
        most = np.argsort(-bounds)[:LOOKED_AT]
        values, _ = self._curve(highs[most], lows[most])
        at = most[int(np.argmax(values))]
        self._evaluate(int(highs[at]), int(lows[at]))

    def _curve(self, highs: Indices, lows: Indices) -> tuple[Floats, Floats]:
        """Ratios and multipliers of pairs by sorting, in floats, without an error bound."""
        slope, least, start = self.span.scaled
        ratios, ks = np.empty(len(highs)), np.empty(len(highs))
        step = max(1, ENTRIES // self.rows.floats.shape[1])
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            p, q = self.rows.floats[highs[part]], self.rows.floats[lows[part]]
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                quotient = np.nan_to_num(np.where(q > 0, p / q, np.where(p > 0, np.inf, -1.0)), nan=-1.0, posinf=np.inf)
            order = np.argsort(-quotient, axis=1)
            p, q = np.take_along_axis(p, order, 1), np.take_along_axis(q, order, 1)
            quotient = np.take_along_axis(quotient, order, 1)
            power, level = np.cumsum(p, axis=1), np.cumsum(q, axis=1)
            count = np.minimum((level <= start).sum(axis=1), level.shape[1] - 1)
            line = np.arange(len(p))
            slopes = np.clip(np.nan_to_num(quotient[line, count], posinf=0.0), 0.0, HUGE)
            before_s = np.where(count > 0, level[line, count - 1], 0.0)
            before_p = np.where(count > 0, power[line, count - 1], 0.0)
            with np.errstate(over="ignore", invalid="ignore"):
                value = least + slope * (before_p + np.nan_to_num(np.maximum(start - before_s, 0.0) * slopes))
            k = slopes
            if least > 0:
                after = np.where(level >= start, (least + slope * power) / (least + slope * level), 0.0)
                greatest = after.max(axis=1)
                k = np.where(greatest > value, greatest, k)
                value = np.maximum(value, greatest)
            ratios[part], ks[part] = value, k
        return ratios, ks

    def _pair_bounds(self, highs: Indices, lows: Indices, ks: Floats) -> Floats:
        """Rigorous float bounds of pairs, each at its own k."""
        bounds = np.empty(len(highs))
        step = max(1, ENTRIES // self.rows.floats.shape[1])
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            k = ks[part]
            sticks = np.maximum(self.rows.floats[highs[part]] - k[:, None] * self.rows.floats[lows[part]], 0.0).sum(axis=1)
            bounds[part] = self.at(k, sticks)
        return bounds

    def _finish(self) -> None:
        """Evaluate exactly every pair that could still be better."""
        highs, lows = self.rest
        if not len(highs):
            return
        values, ks = self._curve(highs, lows)
        at = int(np.argmax(values))
        self._evaluate(int(highs[at]), int(lows[at]))
        bounds = self._pair_bounds(highs, lows, ks)
        for i in np.flatnonzero(bounds > self.level).tolist():
            if bounds[i] > self.level:
                self._evaluate(int(highs[i]), int(lows[i]))

    def _everything(self) -> None:
        """Evaluate all pairs exactly, where floats do not reach."""
        highs: list[int] = []
        lows: list[int] = []
        for start, end in zip(self.rows.starts[:-1].tolist(), self.rows.starts[1:].tolist(), strict=True):
            for i in range(start, end):
                for j in range(start, end):
                    if i != j:
                        highs.append(i)
                        lows.append(j)
                        self._evaluate(i, j)
        self.rest = (np.array(highs), np.array(lows))

    def _exactly(self, high: int, low: int) -> _Best:
        keys = []
        for member in (high, low):
            row = self.rows.exact(member)
            common = gcd(*row)
            keys.append(tuple(v // common for v in row))
        key = (keys[0], keys[1])
        if key not in self.cache:
            self.cache[key] = _most_powerful(self.rows, (high, low), self.span)
        return self.cache[key]

    def _evaluate(self, high: int, low: int) -> None:
        found = self._exactly(high, low)
        if self.best is None or found.ratio > self.best.ratio:
            self.best = _Best(found.ratio, found.k, found.values, (high, low))

    def multipliers(self) -> list[Fraction]:
        """Return k such that each ordered pair is proved by one of them."""
        assert self.best is not None  # noqa: S101 - run comes first
        span, level = self.span, self.level
        listed = list(self.used)
        highs, lows = self.rest
        candidates = [self.best.k]
        exactly = self.span.scaled[0] == inf
        while len(highs):
            k = candidates.pop() if candidates else self._exactly(int(highs[0]), int(lows[0])).k
            covered = np.zeros(len(highs), dtype=bool)
            if len(highs) > FEW and not exactly:
                value = float(k)
                covered = self._pair_bounds(highs, lows, np.full(len(highs), value)) <= level
                if value != k and covered.any():
                    listed.append(Fraction(value))
            for i in np.flatnonzero(~covered)[: len(highs) if exactly else FEW].tolist():
                covered[i] = _proved(self.rows, (int(highs[i]), int(lows[i])), k, span, self.best.ratio)
            listed.append(k)
            highs, lows = highs[~covered], lows[~covered]
        return list(dict.fromkeys(listed)) or [ONE]


def _proved(rows: _Rows, pair: tuple[int, int], k: Fraction, span: _Range, ratio: Fraction) -> bool:
    """Whether k proves the ratio for a pair, exactly."""
    p, q = rows.exact(pair[0]), rows.exact(pair[1])
    top, bottom = sum(p), sum(q)
    stick = Fraction(
        sum(max(0, v * bottom * k.denominator - k.numerator * w * top) for v, w in zip(p, q, strict=True)), top * bottom * k.denominator
    )
    return k * span.floor + max(ZERO, span.width * stick - (k - 1) * span.m) <= ratio * span.floor


def _closed(
    setting: Setting,
    ratio: Extended,
    pair: tuple[int, int],
    values: Sequence[Fraction],
    rows: _Rows,
    multipliers: Callable[[], list[Fraction]],
) -> WorstCase:
    block, of, n = rows.block(pair[0]), setting.of, setting.n
    high, low = rows.sources[pair[0]], rows.sources[pair[1]]
    place = setting.places[block]
    table = {place: list(values)} if place is not None else {}
    if place is None:
        table = {i: list(values[i * n : (i + 1) * n]) for i in range(len(setting.contexts))}
    if ratio == 1:
        table = {i: [of.gamma] * n for i in range(len(setting.contexts))}
    lower, witness, raised = _raised(setting, block, (high, low), table)
    if lower != ratio:  # the theory says that this cannot be; if it were, the claims would still be right
        lower = min(lower, ratio)
    by: Literal["T3", "lp-dual"] = "T3" if of.tau is None or of.tau_on == "all" else "lp-dual"

    def proof() -> dict[str, Any]:
        if by == "T3":
            return {"multipliers": multipliers()}
        if not isinstance(ratio, Fraction):
            return {"pairs": []}
        return _pairs_by_sticks(setting, ratio, multipliers())

    return WorstCase(setting.law, of, setting.quantity, ratio, lower, witness, "closed form", by, None, True, None, setting, raised, proof)


def _pairs_by_sticks(setting: Setting, ratio: Fraction, multipliers: Sequence[Fraction]) -> dict[str, Any]:
    """Write the k of the closed form as multipliers R − k of the floor of the lower group."""
    entries = []
    for block, pair in _needed(setting, ratio):
        for k in multipliers:
            # Without a floor above m the box alone proves the ratio.
            found = {1: ratio - k} if setting.of.floor > setting.of.m and ratio > k else {}
            if setting.proves(block, pair, found, ratio):
                entries.append(_entry(setting, block, pair, found))
                break
        else:
            raise InputError("the proof of the worst case could not be completed")
    return {"pairs": entries}


def _needed(setting: Setting, ratio: Extended) -> Iterator[tuple[int, tuple[int, int]]]:
    """Ordered pairs that the certificate must prove."""
    if ratio == inf or setting.of.cap <= ratio:
        return
    for block, members in enumerate(setting.members):
        if setting.quantity == "local" and setting.of.blind and all(setting.row(c) == setting.row(members[0]) for c in members):
            continue
        for high in members:
            for low in members:
                if high != low:
                    yield block, (high, low)


def _entry(setting: Setting, block: int, pair: tuple[int, int], multipliers: Mapping[int, Fraction]) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    place = setting.places[block]
    groups = list(pair)
    if place is not None:
        entry["context"] = setting.contexts[place]
        groups = [setting.group_of[cell] for cell in pair]
    entry |= {"higher": groups[0], "lower": groups[1]}
    entry["multipliers"] = [(number, multipliers[number]) for number in sorted(multipliers) if multipliers[number]]
    return entry


def _raised(
    setting: Setting, block: int, pair: tuple[int, int], table: dict[int, list[Fraction]]
) -> tuple[Extended, Witness, dict[int, list[Fraction]]]:
    """Mix a utility with the constant γ until all compared groups keep the floor, and find the pair that attains the ratio.

    The ratio does not fall: the numerator grows, and the least denominator is the floor. (The pair's own numerator is at least its
    denominator, so that only the other groups can force the mixture.)
    """
    gamma, floor = setting.of.gamma, setting.of.floor
    means = {member: _value(setting, member, table) for member in setting.members[block]}
    share = max([(floor - v) / (gamma - v) for v in means.values() if v < floor], default=ZERO)
    if share:
        table = {key: [v + share * (gamma - v) for v in row] for key, row in table.items()}
        means = {member: v + share * (gamma - v) for member, v in means.items()}
    high = max(means.values())
    least = min(means.values())
    first = pair[0] if means[pair[0]] == high else next(m for m in means if means[m] == high)
    second = pair[1] if means[pair[1]] == least else next(m for m in means if means[m] == least)
    if first == second:
        first, second = pair
    return _ratio(means[first], means[second]), _witness(setting, block, (first, second), (means[first], means[second])), table


def _ratio(top: Fraction, bottom: Fraction) -> Extended:
    if bottom:
        return top / bottom
    return inf if top else ONE


def _value(setting: Setting, member: int, table: Mapping[int, Sequence[Fraction]]) -> Fraction:
    """Mean of a member under a utility, γ where the utility says nothing."""
    total = ZERO
    for v, p in setting.mean(member).items():
        row, u = divmod(v, setting.n)
        total += p * (table[row][u] if row in table else setting.of.gamma)
    return total


def _witness(setting: Setting, block: int, pair: tuple[int, int], values: tuple[Fraction, Fraction]) -> Witness:
    law, place = setting.law, setting.places[block]
    groups = pair if place is None else (setting.group_of[pair[0]], setting.group_of[pair[1]])
    context = None if place is None else law.context_label(setting.contexts[place])
    return Witness(context, law.group_label(groups[0]), law.group_label(groups[1]), values)


# Linear programs


@dataclass(frozen=True, eq=False)
class _Program:
    """Maximise p·v/q·v over A v ≤ b and a box; rows carry their numbers among the constraints of the class."""

    variables: list[int]
    low: list[Fraction]
    high: list[Fraction]
    rows: list[tuple[list[tuple[int, Fraction]], Fraction]]
    numbers: list[int]
    p: list[Fraction]
    q: list[Fraction]
    floor: int | None
    """The row that keeps q·v at the floor."""
    cap: Extended

    def ratio(self, point: Sequence[Fraction]) -> Extended:
        return _ratio(_dot(self.p, point), _dot(self.q, point))

    def feasible(self, point: Sequence[Fraction]) -> bool:
        inside = all(low <= v <= high for low, v, high in zip(self.low, point, self.high, strict=True))
        return inside and all(self.slack(i, point) >= 0 for i in range(len(self.rows)))

    def slack(self, row: int, point: Sequence[Fraction]) -> Fraction:
        terms, bound = self.rows[row]
        return bound - sum((a * point[j] for j, a in terms), ZERO)

    @cached_property
    def floats(self) -> tuple[Any, Floats, Floats, Floats, Floats, Floats]:
        """A (sparse), b, p, q and the box, in floats."""
        from scipy.sparse import csr_array

        entries = [(i, j, _float(a)) for i, (terms, _) in enumerate(self.rows) for j, a in terms]
        at = np.array([(i, j) for i, j, _ in entries], dtype=np.int64).reshape(-1, 2)
        matrix = csr_array(
            (np.array([a for _, _, a in entries], dtype=np.float64), (at[:, 0], at[:, 1])), shape=(len(self.rows), len(self.p))
        )
        listed = ([bound for _, bound in self.rows], self.p, self.q, self.low, self.high)
        b, p, q, low, high = (np.array([_float(v) for v in values], dtype=np.float64) for values in listed)
        return matrix, b, p, q, low, high

    def excess(self, multipliers: Mapping[int, Fraction], ratio: Fraction) -> tuple[Fraction, Fraction]:
        """F(ratio) and its slope to the right."""
        c = self.reduced(multipliers, ratio)
        total = sum((y * self.rows[i][1] for i, y in multipliers.items()), ZERO)
        slope = ZERO
        for value, q, low, high in zip(c, self.q, self.low, self.high, strict=True):
            at = high if value > 0 or (value == 0 and q < 0) else low
            total += value * at
            slope -= q * at
        return total, slope

    def reduced(self, multipliers: Mapping[int, Fraction], ratio: Fraction) -> list[Fraction]:
        """Coefficients p − ratio·q − y·A."""
        c = [p - ratio * q for p, q in zip(self.p, self.q, strict=True)]
        for i, y in multipliers.items():
            for j, a in self.rows[i][0]:
                c[j] -= y * a
        return c


@dataclass(frozen=True)
class _Solved:
    """What is known of a pair: R_hi with its multipliers (by row), and an exact point of the class, if one was found."""

    upper: Extended
    multipliers: dict[int, Fraction]
    point: list[Fraction] | None
    empty: bool = False


def _float(value: Fraction) -> float:
    """Round to a float that a solver can work with; only its search depends on it."""
    return float(max(min(value, LARGEST), -LARGEST))


def _dot(left: Sequence[Fraction], right: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(left, right, strict=True) if a), ZERO)


def _solve_lp(c: Floats, a: Any, b: Floats, equal: tuple[Any, Floats] | None, bounds: Any) -> tuple[Floats, Floats] | None:
    """Minimise c·x over A x ≤ b by HiGHS; returns x and the multipliers of the rows, or nothing. Nothing that it says is believed."""
    import warnings

    from scipy.optimize import linprog

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            options: dict[str, Any] = {"A_eq": equal[0], "b_eq": equal[1]} if equal else {}
            found = linprog(c, A_ub=a, b_ub=b, bounds=bounds, method="highs-ds", **options)
    except (ValueError, ArithmeticError, RuntimeError):
        return None
    if found.status != 0 or found.x is None:
        return None
    return np.asarray(found.x, dtype=np.float64), -np.asarray(found.ineqlin.marginals, dtype=np.float64)


def _ask(c: Floats, a: Any, b: Floats, equal: tuple[Any, Floats] | None, bounds: Any) -> tuple[Floats, Floats] | None:
    """Ask the solver, and drop answers that are not even numbers of the right shape."""
    try:
        found = _solve_lp(c, a, b, equal, bounds)
    except Exception:  # whatever a solver does, it only may cost tightness
        return None
    if found is None or len(found[0]) != len(c) or len(found[1]) != len(b):
        return None
    return found if np.isfinite(found[0]).all() and np.isfinite(found[1]).all() else None


@dataclass(frozen=True, eq=False)
class _Answer:
    """What the solver said: a point, the multipliers of the rows, and the point in the coordinates of Charnes and Cooper."""

    point: Floats
    multipliers: Floats
    stretched: Floats | None = None
    """w = (v − low)·s, then s = 1/q·v."""


def _charnes_cooper(program: _Program) -> _Answer | None:
    """Solve the fractional program in w = (v − low)·s and s = 1/q·v, which is measured in units of 1/floor."""
    from scipy.sparse import csr_array, diags_array, hstack, vstack

    matrix, b, p, q, low, high = program.floats
    n = len(p)
    width = high - low
    unit = 1.0 if program.floor is None else max(_float(-program.rows[program.floor][1]), 1e-13)
    top = hstack([matrix, csr_array(((matrix @ low - b) / unit)[:, None])])
    sides = hstack([diags_array(np.ones(n)), csr_array((-width / unit)[:, None])])
    one = csr_array(np.append(q, q @ low / unit)[None, :])
    a = vstack([top, sides], format="csr")
    found = _ask(-np.append(p, p @ low / unit), a, np.zeros(a.shape[0]), (one, np.ones(1)), (0, None))
    if found is None or found[0][-1] <= 0:
        return None
    stretched = np.append(found[0][:-1], found[0][-1] / unit)
    point = np.nan_to_num(low + stretched[:-1] / stretched[-1], nan=0.0, posinf=HUGE, neginf=-HUGE)
    return _Answer(np.clip(point, low, high), found[1][: len(b)], stretched)


def _stretched_vertex(program: _Program, answer: _Answer, tolerance: float) -> list[Fraction] | None:
    """As `_vertex`, in the coordinates of Charnes and Cooper, where values far below γ can still be told apart."""
    if answer.stretched is None:
        return None
    matrix, b, _, _, low, high = program.floats
    w, s = answer.stretched[:-1], float(answer.stretched[-1])
    n, scale = len(w), tolerance * max(float(np.abs(w).max()), 1e-300)
    if not np.isfinite(scale):
        return None
    at_low, at_high = w <= scale, (high - low) * s - w <= scale
    equations: list[tuple[dict[int, Fraction], Fraction]] = [
        ({**dict(enumerate(program.q)), n: _dot(program.q, program.low)}, ONE),
        *(({j: ONE}, ZERO) for j in np.flatnonzero(at_low).tolist()),
        *(({j: ONE, n: program.low[j] - program.high[j]}, ZERO) for j in np.flatnonzero(at_high & ~at_low).tolist()),
    ]
    if len(b):
        slack = (b - matrix @ low) * s - matrix @ w
        size = np.abs(b - matrix @ low) * s + abs(matrix) @ np.abs(w) + 1e-300
        tight = np.flatnonzero(slack <= tolerance * size)
        for i in tight[np.argsort(-answer.multipliers[tight], kind="stable")].tolist():
            terms, bound = program.rows[i]
            equations.append(({**dict(terms), n: sum((a * program.low[j] for j, a in terms), -bound)}, ZERO))
    guess = {j: Fraction(float(v)) for j, v in enumerate(answer.stretched)}
    solved = _eliminate(equations, guess)
    if solved is None or solved[n] <= 0:
        return None
    values = [lo + solved[j] / solved[n] for j, lo in enumerate(program.low)]
    return values if program.feasible(values) else None


def _at_ratio(program: _Program, ratio: Extended) -> tuple[Floats, Floats] | None:
    """Maximise p·v − ratio·q·v; multipliers of an optimum of at most 0 prove the ratio."""
    matrix, b, p, q, low, high = program.floats
    factor = _float(ratio) if isinstance(ratio, Fraction) else HUGE
    return _ask(-(p - factor * q), matrix, b, None, np.column_stack((low, high)))


def _rounded(multipliers: Floats) -> dict[int, Fraction]:
    """Multipliers as dyadic rationals ≥ 0."""
    found = {}
    for i in np.flatnonzero(multipliers > 0).tolist():
        value = Fraction(round(Fraction(float(multipliers[i])) * ROUNDING), ROUNDING)
        if value:
            found[i] = value
    return found


def _least_ratio(program: _Program, multipliers: Mapping[int, Fraction], start: Fraction) -> tuple[Extended, dict[int, Fraction]]:
    """Least R ≥ start that multipliers prove, exactly: F is convex and piecewise linear, so Newton's method from the left ends there.

    Where there is a floor, its multiplier may also grow with R, which proves some R whatever the multipliers are.
    """
    best: tuple[Extended, dict[int, Fraction]] = (inf, {})
    ratio = start
    for _ in range(len(program.p) + 2):
        total, slope = program.excess(multipliers, ratio)
        if total <= 0:
            best = (ratio, dict(multipliers))
            break
        if slope >= 0:
            break
        ratio -= total / slope
    if program.floor is not None and best[0] != start:
        others = {i: y for i, y in multipliers.items() if i != program.floor}
        k = start - multipliers.get(program.floor, ZERO)
        total, _ = program.excess(others, k)
        grown = max(ZERO, total) / -program.rows[program.floor][1]
        if k + grown < start:
            grown = start - k
        if k + grown < best[0]:
            best = (k + grown, {**others, program.floor: grown})
    return best


def _vertex(program: _Program, point: Floats, multipliers: Floats, tolerance: float) -> list[Fraction] | None:
    """Solve the constraints that look tight exactly; None if the result is not in the class."""
    matrix, b, _, _, low, high = program.floats
    width = np.maximum(high - low, 1e-300)
    at_low, at_high = (point - low) <= tolerance * width, (high - point) <= tolerance * width
    values = [
        lo if is_low else hi if is_high else Fraction(v)
        for lo, hi, is_low, is_high, v in zip(program.low, program.high, at_low.tolist(), at_high.tolist(), point.tolist(), strict=True)
    ]
    free = {j for j, (one, other) in enumerate(zip(at_low.tolist(), at_high.tolist(), strict=True)) if not (one or other)}
    if len(b):
        slack = b - matrix @ point
        scale = np.abs(b) + abs(matrix) @ np.maximum(np.abs(low), np.abs(high)) + 1e-300
        tight = np.flatnonzero(slack <= tolerance * scale)
        equations = []
        for i in tight[np.argsort(-multipliers[tight], kind="stable")].tolist():
            terms, bound = program.rows[i]
            rest = bound - sum((a * values[j] for j, a in terms if j not in free), ZERO)
            equations.append(({j: a for j, a in terms if j in free}, rest))
        solved = _eliminate(equations, {j: values[j] for j in free})
        if solved is None:
            return None
        for j, value in solved.items():
            values[j] = value
    return values if program.feasible(values) else None


def _eliminate(
    equations: Sequence[tuple[dict[int, Fraction], Fraction]], guess: Mapping[int, Fraction], needed: int | None = None
) -> dict[int, Fraction] | None:
    """Solve sparse linear equations in rationals; unknowns that they leave free keep their guess.

    None if one of the first `needed` (all by default) contradicts those before it; later ones that do are left out.
    """
    needed = len(equations) if needed is None else needed
    pivots: list[tuple[int, dict[int, Fraction], Fraction]] = []
    where: dict[int, int] = {}
    for number, (given, bound) in enumerate(equations):
        terms, rest = {j: a for j, a in given.items() if a}, bound
        while terms:
            known = [where[j] for j in terms if j in where]
            if not known:
                break
            unknown, others, value = pivots[min(known)]
            factor = terms.pop(unknown)
            rest -= factor * value
            for j, a in others.items():
                terms[j] = terms.get(j, ZERO) - factor * a
                if not terms[j]:
                    del terms[j]
        if not terms:
            if rest and number < needed:
                return None
            continue
        pivot = min(terms, key=lambda j: (terms[j].denominator.bit_length() + terms[j].numerator.bit_length(), j))
        factor = terms.pop(pivot)
        where[pivot] = len(pivots)
        pivots.append((pivot, {j: a / factor for j, a in terms.items()}, rest / factor))
    solved = dict(guess)
    for unknown, others, value in reversed(pivots):
        solved[unknown] = value - sum((a * solved[j] for j, a in others.items()), ZERO)
    return solved


def _mixed(program: _Program, point: Floats, interior: Sequence[Fraction]) -> list[Fraction]:
    """Move a point of floats towards a point that is exactly in the class, until it is in the class too."""
    values = [min(max(Fraction(v), low), high) for v, low, high in zip(point.tolist(), program.low, program.high, strict=True)]
    share = ZERO
    for i in range(len(program.rows)):
        miss = -program.slack(i, values)
        if miss > 0:
            share = max(share, miss / (miss + program.slack(i, interior)))
    return [v + share * (w - v) for v, w in zip(values, interior, strict=True)]


def _exact_multipliers(program: _Program, point: Sequence[Fraction], multipliers: Floats, ratio: Fraction) -> Iterator[dict[int, Fraction]]:
    """Yield multipliers that are exactly complementary to a point, first on the rows that the solver used, then on all tight ones.

    They make the coefficients of variables inside their box exactly zero, and, where that leaves a choice, other coefficients that the
    solver made nearly zero.
    """
    inner = [j for j, (low, v, high) in enumerate(zip(program.low, point, program.high, strict=True)) if low < v < high]
    tight = [i for i in range(len(program.rows)) if program.slack(i, point) == 0]
    guess = _rounded(multipliers)
    used = [i for i in tight if i in guess]
    matrix, _, p, q, _, _ = program.floats
    left = np.abs(p - _float(ratio) * q - matrix.T @ multipliers)
    left[inner] = np.inf
    close = np.flatnonzero(left <= 1e-9 * max(1.0, _float(ratio)))
    wished = [*inner, *close[np.argsort(left[close], kind="stable")].tolist()]
    columns: dict[int, dict[int, Fraction]] = {j: {} for j in wished}
    wanted = set(tight)
    for i in wanted:
        for j, a in program.rows[i][0]:
            if j in columns:
                columns[j][i] = a
    for rows in (used, tight):
        allowed = set(rows)
        equations = [({i: a for i, a in columns[j].items() if i in allowed}, program.p[j] - ratio * program.q[j]) for j in wished]
        solved = _eliminate(equations, {i: guess.get(i, ZERO) for i in rows}, len(inner))
        if solved is not None and all(y >= 0 for y in solved.values()):
            yield {i: y for i, y in solved.items() if y}


def _solve(program: _Program, interior: list[Fraction] | None) -> _Solved:
    """Enclose the greatest ratio of a program."""
    if program.cap == inf:
        ray = _ray(program)
        if ray is not None:
            return _Solved(inf, {}, ray)
    answer = _charnes_cooper(program)
    if answer is None:
        found = _at_ratio(program, ONE)
        if found is None:
            return _Solved(program.cap, {}, interior)
        answer = _Answer(*found)
    best = interior
    upper: Extended = inf
    proof: dict[int, Fraction] = {}
    for exact in _vertices(program, answer, interior):
        if best is None or program.ratio(exact) >= program.ratio(best):
            best = exact
        if program.ratio(best) == inf:
            return _Solved(inf, {}, best)
        bound, found_proof = _prove(program, best, answer.multipliers)
        if bound < upper:
            upper, proof = bound, found_proof
        if upper == program.ratio(best):
            break
    else:
        bound, found_proof = _prove(program, best, answer.multipliers)
        if bound < upper:
            upper, proof = bound, found_proof
    return _Solved(upper, proof, best) if upper <= program.cap else _Solved(program.cap, {}, best)


def _vertices(program: _Program, answer: _Answer, interior: list[Fraction] | None) -> Iterator[list[Fraction]]:
    """Yield exact points of the class near the solver's: by rounding what looks tight, in two coordinates, and by mixing."""
    found = False
    for tolerance in TOLERANCES:
        exact = _vertex(program, answer.point, answer.multipliers, tolerance)
        if exact is not None:
            found = True
            yield exact
            break
    for tolerance in TOLERANCES:
        exact = _stretched_vertex(program, answer, tolerance)
        if exact is not None:
            found = True
            yield exact
            break
    if interior is not None and not found:
        yield _mixed(program, answer.point, interior)


def _prove(program: _Program, exact: list[Fraction] | None, multipliers: Floats) -> tuple[Extended, dict[int, Fraction]]:
    """Find the least proved R_hi: with exact multipliers first, then with rounded ones, then with those of another program."""
    attained = program.ratio(exact) if exact is not None else ONE
    if not isinstance(attained, Fraction):
        return inf, {}
    start = max(attained, ONE)
    best: tuple[Extended, dict[int, Fraction]] = (inf, {})
    if exact is not None and start == attained:
        for solved in _exact_multipliers(program, exact, multipliers, start):
            best = min(best, _least_ratio(program, solved, start), key=lambda e: e[0])
            if best[0] == start:
                return best
    best = min(best, _least_ratio(program, _rounded(multipliers), start), key=lambda e: e[0])
    if best[0] > start * (1 + Fraction(1, 10**9)):
        again = _at_ratio(program, start)
        if again is not None:
            best = min(best, _least_ratio(program, _rounded(again[1]), start), key=lambda e: e[0])
            for solved in _refined(program, again, start):
                best = min(best, _least_ratio(program, solved, start), key=lambda e: e[0])
    return best


def _refined(program: _Program, found: tuple[Floats, Floats], ratio: Fraction) -> Iterator[dict[int, Fraction]]:
    """Yield exact multipliers from the solution of a program at a fixed ratio."""
    for tolerance in TOLERANCES:
        exact = _vertex(program, found[0], found[1], tolerance)
        if exact is not None:
            yield from _exact_multipliers(program, exact, found[1], ratio)
            return


def _ray(program: _Program) -> list[Fraction] | None:
    """Find a point of the class at which q·v = 0 < p·v, exactly."""
    row = ([(j, q) for j, q in enumerate(program.q) if q], ZERO)
    wide = _Program(
        program.variables, program.low, program.high, [*program.rows, row], program.numbers, program.p, program.q, None, program.cap
    )
    matrix, b, p, _, low, high = wide.floats
    found = _ask(-p, matrix, b, None, np.column_stack((low, high)))
    if found is None:
        return None
    for tolerance in TOLERANCES:
        point = _vertex(wide, np.clip(found[0], low, high), found[1], tolerance)
        if point is not None and program.ratio(point) == inf:
            return point
    return None


def _phase_one(program: _Program) -> tuple[list[Fraction] | None, dict[int, Fraction] | None]:
    """Look for a point inside the class, or for multipliers that prove it empty."""
    from scipy.sparse import csr_array, hstack

    matrix, b, p, _, low, high = program.floats
    if not len(b):
        return list(program.low), None
    a = hstack([matrix, csr_array(-np.ones((len(b), 1)))], format="csr")
    bounds = np.vstack((np.column_stack((low, high)), [[-np.inf, np.inf]]))
    found = _ask(np.append(np.zeros(len(p)), 1.0), a, b, None, bounds)
    if found is None:
        return None, None
    proof = _rounded(found[1])
    if _emptiness(program, proof) > 0:
        return None, proof
    values = [min(max(Fraction(v), lo), hi) for v, lo, hi in zip(found[0][:-1].tolist(), program.low, program.high, strict=True)]
    if program.feasible(values):
        return values, None
    for tolerance in TOLERANCES:
        exact = _vertex(program, np.clip(found[0][:-1], low, high), found[1], tolerance)
        if exact is not None:
            return exact, None
    return None, None


def _emptiness(program: _Program, multipliers: Mapping[int, Fraction]) -> Fraction:
    """By how much multipliers contradict the constraints: positive proves that no point satisfies them (Farkas)."""
    nothing = [ZERO] * len(program.p)
    bare = _Program(program.variables, program.low, program.high, program.rows, program.numbers, nothing, nothing, None, inf)
    return -bare.excess(multipliers, ZERO)[0]


class _Linear:
    """All pairs of a class of linear constraints, the most promising first."""

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.solved: dict[tuple[int, tuple[int, int]], tuple[_Program, _Solved]] = {}
        self.phase: dict[Any, tuple[list[Fraction] | None, dict[int, Fraction] | None]] = {}
        self.sticks: dict[tuple[int, tuple[int, int]], Fraction] = {}

    def program(self, block: int, pair: tuple[int, int]) -> _Program:
        """The program of an ordered pair: the whole class if constraints couple contexts, else only what concerns the pair.

        A utility of two groups extends to the others: the same g where the class is blind, g(·,b) = min(γ, g(·,a) + L·d(a,b), …) in a
        Lipschitz class. Mixed with the constant γ it keeps all floors at no loss (see `_raised`).
        """
        setting = self.setting
        floors = setting.floors(block, pair)
        offset = len(floors)
        if setting.of.couples:
            variables = list(range(setting.size))
            numbers = [*range(offset), *range(offset, offset + setting.numbering(block).end)]
        else:
            variables = sorted({v for member in pair for v in self._variables(member)})
            numbers = [floors.index(pair[1])] if floors else []
            numbers += [offset + i for i in self._numbers(block, pair)]
        position = {v: j for j, v in enumerate(variables)}
        rows, kept = [], []
        for number in numbers:
            terms, bound = setting.constraint(block, pair, number)
            if terms or bound < 0:  # an empty row with a negative bound contradicts itself
                rows.append(([(position[v], a) for v, a in terms.items()], bound))
                kept.append(number)
        floor = kept.index(floors.index(pair[1])) if floors and setting.of.tau > 0 else None
        p, q = ([vector.get(v, ZERO) for v in variables] for vector in (setting.vector(member) for member in pair))
        low, high = zip(*(setting.box(v) for v in variables), strict=True)
        return _Program(variables, list(low), list(high), rows, kept, p, q, floor, setting.of.cap)

    def _cells(self, member: int) -> list[int]:
        return [member] if self.setting.quantity == "local" else [i for i, a in enumerate(self.setting.group_of) if a == member]

    def _variables(self, member: int) -> Iterator[int]:
        setting = self.setting
        for cell in self._cells(member):
            yield from (setting.variable(cell, u) for u in range(setting.n))

    def _numbers(self, block: int, pair: tuple[int, int]) -> Iterator[int]:
        """Constraints on the utilities of a pair, but the floors."""
        setting = self.setting
        cells = [self._cells(member) for member in pair]
        if setting.order:
            slots = {setting.cells[setting.place_of[c]][0] if setting.of.blind else c for listed in cells for c in listed}
            for cell in sorted(slots):
                yield from setting.order_numbers(block, cell)
        if setting.of.lipschitz is not None:
            second = {setting.place_of[cell]: cell for cell in cells[1]}
            for cell in cells[0]:
                other = second.get(setting.place_of[cell])
                if other is not None:
                    yield from setting.distance_numbers(block, cell, other)
                    yield from setting.distance_numbers(block, other, cell)

    def solve(self, block: int, pair: tuple[int, int]) -> tuple[_Program, _Solved]:
        key = (block, pair)
        if key not in self.solved:
            program = self.program(block, pair)
            interior: list[Fraction] | None = list(program.high)
            if self.setting.of.couples:
                which = (block, pair if self.setting.of.tau_on == "pair" else None)
                if which not in self.phase:
                    self.phase[which] = _phase_one(program)
                interior, empty = self.phase[which]
                if empty is not None:
                    self.solved[key] = program, _Solved(ZERO, empty, None, empty=True)
                    return self.solved[key]
            self.solved[key] = program, _solve(program, interior)
        return self.solved[key]

    def run(self) -> WorstCase:
        """Solve pair after pair until no other can be worse."""
        setting = self.setting
        best: tuple[Extended, int, tuple[int, int], dict[int, list[Fraction]], Witness, Any] | None = None
        upper: Extended = ONE
        empty = True
        for bound, k, block, pair in self._ranked():
            if best is not None and bound <= best[0]:
                self.sticks[block, pair] = k
                empty = False
                continue
            program, found = self.solve(block, pair)
            if found.empty:
                continue
            empty = False
            upper = max(upper, found.upper)
            if found.point is not None:
                candidate = self._attained(block, pair, program, found.point)
                if best is None or candidate[0] > best[0]:
                    best = candidate
            if best is not None and best[0] == inf:
                break
        if empty:
            raise InputError("no utility is in the class: its constraints contradict each other or the floor")
        if best is None:
            raise InputError("no utility that is exactly in the class was found; give its constraints as short decimals")
        upper = max(upper, best[0])
        final = upper
        shown = self._shown(best) if setting.of.couples and setting.of.tau is not None else None
        return WorstCase(
            setting.law,
            setting.of,
            setting.quantity,
            final,
            best[0],
            best[4],
            "lp",
            "lp-dual",
            best[5],
            True,
            None,
            setting,
            best[3],
            lambda: self.evidence(final),
            shown,
        )

    def _shown(self, best: Any) -> tuple[dict[int, list[Fraction]], tuple[Fraction, ...] | None] | None:
        """Find a utility under which no pair without the floor differs more, where the worst one is not of that kind.

        It keeps the floor on all that is compared in all contexts; the pairs that promise most are tried.
        """
        setting = self.setting
        measure = local_fairness if setting.quantity == "local" else global_fairness

        def fits(table: dict[int, list[Fraction]]) -> Extended | None:
            found = measure(setting.law, _utility(setting, table).on(setting.law))
            return found.ratio if found is not None and _keeps_floor(setting, table, found.witness) else None

        if fits(best[3]) is not None:
            return None
        ranked = sorted(
            (key for key, (_, found) in self.solved.items() if not found.empty), key=lambda key: self.solved[key][1].upper, reverse=True
        )
        greatest: Any = None
        for block, pair in ranked[:LOOKED_AT]:
            program = self.program(block, pair)
            floors = [
                ([(j, -c) for j, c in setting.vector(member).items()], -setting.of.tau) for members in setting.members for member in members
            ]
            wide = replace(program, rows=[*program.rows, *floors], numbers=[*program.numbers, *(-1 for _ in floors)])
            interior, empty = _phase_one(wide)
            if empty is not None:
                break
            found = _solve(wide, interior)
            if found.point is not None:
                table, theta = self._table(wide, found.point)
                ratio = fits(table)
                if ratio is not None and (greatest is None or ratio > greatest[0]):
                    greatest = ratio, table, theta
        return None if greatest is None else greatest[1:]

    def _attained(
        self, block: int, pair: tuple[int, int], program: _Program, point: Sequence[Fraction]
    ) -> tuple[Extended, int, tuple[int, int], dict[int, list[Fraction]], Witness, Any]:
        """The ratio of a point of the class, with the whole utility."""
        setting = self.setting
        table, theta = self._table(program, point)
        if setting.of.couples:
            values = (_value(setting, pair[0], table), _value(setting, pair[1], table))
            if values[1] > values[0]:
                pair, values = (pair[1], pair[0]), (values[1], values[0])
            return _ratio(*values), block, pair, table, _witness(setting, block, pair, values), theta
        if not setting.of.blind:
            self._extend(table)
        ratio, witness, raised = _raised(setting, block, pair, table)
        return ratio, block, pair, raised, witness, None

    def _table(self, program: _Program, point: Sequence[Fraction]) -> tuple[dict[int, list[Fraction]], tuple[Fraction, ...] | None]:
        """Rows of the utility that a point of a program stands for, and θ."""
        setting = self.setting
        table: dict[int, list[Fraction]] = {}
        if setting.of.family is not None and setting.features is not None:
            for place in range(len(setting.cells)):
                for cell in setting.slots(place):
                    table[place if setting.of.blind else cell] = [_dot(phi, point) for phi in setting.features[cell]]
            return table, tuple(point)
        for v, value in zip(program.variables, point, strict=True):
            row, u = divmod(v, setting.n)
            table.setdefault(row, [setting.of.gamma] * setting.n)[u] = value
        return table, None

    def _extend(self, table: dict[int, list[Fraction]]) -> None:
        """Give the other groups the greatest utility that the class allows beside the pair's."""
        setting = self.setting
        if setting.of.lipschitz is None:
            return
        known = dict(table)
        for place in {setting.place_of[cell] for cell in known}:
            anchors = [cell for cell in setting.cells[place] if cell in known]
            for cell in setting.cells[place]:
                if cell not in known:
                    table[cell] = [
                        min([setting.of.gamma, *(known[other][u] + setting.reach(other, cell) for other in anchors)])
                        for u in range(setting.n)
                    ]

    def _ranked(self) -> list[tuple[float, Fraction, int, tuple[int, int]]]:
        """All ordered pairs with a cheap rigorous bound and the k that gives it, greatest first."""
        setting = self.setting
        pairs = [(block, (i, j)) for block, members in enumerate(setting.members) for i in members for j in members if i != j]
        if setting.of.cap > 10**250 or setting.of.gamma > 10**250 or setting.of.family is not None:
            return [(inf, ZERO, block, pair) for block, pair in pairs]
        rows = _rows(setting)
        index = {(block, source): i for i, source in enumerate(rows.sources) for block in (rows.block(i),)}
        highs = np.array([index[block, pair[0]] for block, pair in pairs])
        lows = np.array([index[block, pair[1]] for block, pair in pairs])
        width = setting.of.gamma - setting.of.m
        if setting.of.blind:
            gaps = np.zeros(len(pairs))
        elif setting.of.lipschitz is None:
            gaps = np.full(len(pairs), float(width))
        else:
            gaps = np.array([float(min(width, self._gap(pair))) for _, pair in pairs])
        best, ks = np.full(len(pairs), np.inf), np.zeros(len(pairs))
        cap = float(min(setting.of.cap, Fraction(10) ** 6))
        for k in (0.0, *(round(k * 64) / 64 for k in np.geomspace(1.0, max(cap, 1.001), 24).tolist())):
            bounds = self._bounds(rows, highs, lows, gaps, k)
            better = bounds < best
            best[better], ks[better] = bounds[better], k
        order = np.argsort(-best, kind="stable").tolist()
        return [(float(best[i]), Fraction(float(ks[i])), *pairs[i]) for i in order]

    def _gap(self, pair: tuple[int, int]) -> Fraction:
        setting = self.setting
        a, b = pair if setting.quantity == "global" else (setting.group_of[pair[0]], setting.group_of[pair[1]])
        gap: Fraction = setting.of.lipschitz * (ONE if setting.metric is None else setting.metric[a][b])
        return gap

    def _bounds(self, rows: _Rows, highs: Indices, lows: Indices, gaps: Floats, k: float) -> Floats:
        """R ≤ k + max(0, Σ_u max over g of P·min(γ, g + K) − k·Q·g)/τ, rounded up."""
        of = self.setting.of
        gamma, m, floor = float(of.gamma), float(of.m), float(of.floor)
        bounds = np.empty(len(highs))
        n, chain = rows.floats.shape[1], self.setting.chain
        error = (gamma / floor + 1.0) * (1.0 + k) * (8 * n + 128) * UNIT
        step = max(1, ENTRIES // n)
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            p, q = rows.floats[highs[part]], k * rows.floats[lows[part]]
            gap = gaps[part, None]
            difference = p - q
            if chain is not None:
                # A monotone utility is m plus steps: the best one is m + (γ − m) on an upper set of the chain, in each context.
                tails = np.cumsum(difference.reshape(len(p), -1, len(chain))[:, :, chain[::-1]], axis=2).max(axis=2)
                total = m * difference.sum(axis=1) + (gamma - m) * np.maximum(tails, 0.0).sum(axis=1)
                bounds[part] = k + np.maximum(total, 0.0) / floor + error
                continue
            apart = np.where(difference > 0, difference * gamma, difference * m) + np.minimum(p, q) * gap
            total = np.minimum(apart, p * gamma - q * m).sum(axis=1)
            bounds[part] = k + np.maximum(total, 0.0) / floor + error
        return bounds

    def evidence(self, ratio: Extended) -> dict[str, Any]:
        """Multipliers for every ordered pair that needs them, each checked exactly."""
        entries = []
        for block, pair in _needed(self.setting, ratio):
            assert isinstance(ratio, Fraction)  # noqa: S101 - nothing is needed for infinity
            for found in self._proofs(block, pair, ratio):
                if self.setting.proves(block, pair, found, ratio):
                    entries.append(_entry(self.setting, block, pair, found))
                    break
            else:
                raise InputError("the proof of the worst case could not be completed; give a floor (tau) to the class")
        return {"pairs": entries}

    def _proofs(self, block: int, pair: tuple[int, int], ratio: Fraction) -> Iterator[dict[int, Fraction]]:
        """Yield multipliers by constraint number that may prove a ratio for a pair."""
        key = (block, pair)
        if key in self.sticks:
            yield self._from_stick(block, pair, self.sticks[key], ratio)
        if self.setting.of.family is None:
            yield {}
        program, found = self.solve(block, pair)
        if found.empty:
            objective, _ = program.excess({}, ratio)
            scale = max(ZERO, objective) / _emptiness(program, found.multipliers)
            yield {program.numbers[i]: y * scale for i, y in found.multipliers.items()}
            return
        named = {program.numbers[i]: y for i, y in found.multipliers.items()}
        yield named
        if program.floor is not None and isinstance(found.upper, Fraction):
            number = program.numbers[program.floor]
            yield {**named, number: named.get(number, ZERO) + ratio - found.upper}
        again = _at_ratio(program, ratio)
        if again is not None:
            for proof in _refined(program, again, ratio):
                yield {program.numbers[i]: y for i, y in proof.items()}
            _, proof = _least_ratio(program, _rounded(again[1]), ratio)
            yield {program.numbers[i]: y for i, y in proof.items()}

    def _from_stick(self, block: int, pair: tuple[int, int], k: Fraction, ratio: Fraction) -> dict[int, Fraction]:
        """Write the k of a cheap bound as multipliers: R − k on the floor of the lower group, and what joins the two utilities."""
        setting = self.setting
        of = setting.of
        found: dict[int, Fraction] = {}
        floors = setting.floors(block, pair)
        if floors and of.tau > of.m and ratio > k:
            found[floors.index(pair[1])] = ratio - k
        else:
            k = ratio
        if setting.chain is not None:
            found |= self._up_the_chain(block, pair, k, len(floors))
        if of.blind or of.lipschitz is None:
            return found
        second = {setting.place_of[cell]: cell for cell in self._cells(pair[1])}
        means = setting.vector(pair[0]), setting.vector(pair[1])
        for cell in self._cells(pair[0]):
            other = second.get(setting.place_of[cell])
            if other is None:
                continue
            reach = setting.reach(cell, other)
            for u, number in enumerate(setting.distance_numbers(block, cell, other)):
                p = means[0].get(setting.variable(cell, u), ZERO)
                q = k * means[1].get(setting.variable(other, u), ZERO)
                apart = (p - q) * (of.gamma if p > q else of.m) + min(p, q) * reach
                if min(p, q) > 0 and apart < p * of.gamma - q * of.m:
                    found[len(floors) + number] = min(p, q)
        return found

    def _up_the_chain(self, block: int, pair: tuple[int, int], k: Fraction, offset: int) -> dict[int, Fraction]:
        """Multipliers of the order that push what is positive in P − k·Q up the chain, where it cancels what is negative."""
        setting = self.setting
        high, low = setting.vector(pair[0]), setting.vector(pair[1])
        found: dict[int, Fraction] = {}
        for cell in sorted({setting.cells[setting.place_of[c]][0] for member in pair for c in self._cells(member)}):
            pushed = ZERO
            for number, (u, _) in zip(setting.order_numbers(block, cell), setting.order, strict=True):
                v = setting.variable(cell, u)
                pushed = max(ZERO, pushed + high.get(v, ZERO) - k * low.get(v, ZERO))
                if pushed:
                    found[offset + number] = pushed
        return found


def _linear(setting: Setting) -> WorstCase:
    return _Linear(setting).run()


# Convex classes


def _root_above(value: Fraction) -> Fraction:
    """Round the square root of a rational up."""
    scale = 2**96
    return Fraction(isqrt(value.numerator * scale * scale // value.denominator) + 1, scale)


def _reference(setting: Setting) -> dict[int, list[Fraction]]:
    """The reference of a ball by row of the utility."""
    law, ball = setting.law, setting.of.ball
    assert ball is not None  # noqa: S101 - only classes with a ball come here
    table = ball.reference.on(law)
    if table.law is not law:
        raise InputError("the reference of the ball names a decision that does not occur; leave it out")
    found: dict[int, list[Fraction]] = {}
    for place, cells in enumerate(setting.cells):
        for cell in cells:
            row = [Fraction(v, table.scale) for v in table.row(cell)]
            if min(row) <= 0 or (table.given is not None and not table.given[cell].all()):
                raise InputError("the reference of the ball is not positive for every decision; give it a positive value everywhere")
            if found.setdefault(place if setting.of.blind else cell, row) != row:
                raise InputError("the reference of the ball depends on the group, but the class is blind; set blind=False")
    return found


def _interval(centre: Fraction, ball: Ball) -> tuple[Fraction, Fraction]:
    """Ends between which a value stays when the divergence of the row is at most the radius, rounded outward.

    χ²: (g − g0)² ≤ r·g0. KL, with x = g/g0 − 1 and c = r/g0: (1 + x)·log(1 + x) − x is at least x²/(2 + 2x/3) for x ≥ 0, and x²/2 below.
    """
    if ball.divergence == "chi2":
        reach = _root_above(ball.radius * centre)
        return centre - reach, centre + reach
    c = ball.radius / centre
    return centre * (1 - _root_above(2 * c)), centre * (1 + c / 3 + _root_above(c * c / 9 + 2 * c))


def _divergence(values: Sequence[Fraction], centres: Sequence[Fraction], ball: Ball) -> Fraction:
    """Divergence of a row from the reference, rounded up."""
    if ball.divergence == "chi2":
        return sum(((g - g0) ** 2 / g0 for g, g0 in zip(values, centres, strict=True)), ZERO)
    total = ZERO
    for g, g0 in zip(values, centres, strict=True):
        total += g0 - g
        if g > g0:
            total += g * Fraction(log_enclosure((g / g0).as_integer_ratio())[1])
        elif 0 < g < g0:
            total -= g * Fraction(log_enclosure((g0 / g).as_integer_ratio())[0])
    return total


def _conic(setting: Setting) -> WorstCase:
    """A ball: bounded by a box around it, and attained by the solver's utility, moved towards the reference until it is surely inside."""
    of, law = setting.of, setting.law
    if of.family is not None or of.ball is None:
        raise InputError("a ball and a family do not go together; give one")
    centres, ball = _reference(setting), of.ball
    rows = list(of.rows)
    for row, values in centres.items():
        x = setting.contexts[row] if of.blind else int(law.cell_context[row])
        a = None if of.blind else law.groups[setting.group_of[row]]
        for label, centre in zip(law.decisions, values, strict=True):
            low, high = _interval(centre, ball)
            rows += [LinearRow([(law.contexts[x], a, label, 1)], high), LinearRow([(law.contexts[x], a, label, -1)], -low)]
    outer = _Linear(lay_out(law, replace(of, ball=None, rows=tuple(rows)), setting.quantity))
    box = outer.run()
    best: tuple[Extended, dict[int, list[Fraction]], Witness] | None = None
    estimate = 1.0
    for _, _, block, pair in outer._ranked():
        program = outer.program(block, pair)
        found = _conic_point(program, centres, ball, setting.n)
        if found is None:
            continue
        estimate = max(estimate, found[1])
        inside = _into_ball(program, found[0], centres, ball, setting.n)
        if inside is not None:
            attained = outer._attained(block, pair, program, inside)
            if best is None or attained[0] > best[0]:
                best = attained[0], attained[3], attained[4]
    if best is None:
        raise InputError(
            "no utility that is exactly in the ball was found; the reference itself has to keep the floor and the other constraints"
        )
    ratio, table, witness = best
    return replace(
        box, utility_class=of, lower=ratio, witness=witness, method="conic", certified=False, estimate=estimate, values=table, shown=None
    )


def _conic_point(program: _Program, centres: Mapping[int, Sequence[Fraction]], ball: Ball, n: int) -> tuple[Floats, float] | None:
    """Solve the fractional program over the ball by Clarabel, in y = v·s and s = 1/q·v."""
    import warnings

    import cvxpy

    cp: Any = cvxpy
    matrix, b, p, q, low, high = program.floats
    y, s = cp.Variable(len(p)), cp.Variable(nonneg=True)
    constraints = [q @ y == 1, y >= low * s, y <= high * s]
    if len(b):
        constraints.append(matrix.toarray() @ y <= b * s)
    for row, values in centres.items():
        at = [program.variables.index(row * n + u) for u in range(n)]
        centre = np.array([float(v) for v in values])
        if ball.divergence == "chi2":
            spread = cp.quad_over_lin(cp.multiply(1 / np.sqrt(centre), y[at] - centre * s), s)
        else:
            spread = cp.sum(cp.kl_div(y[at], centre * s))
        constraints.append(spread <= float(ball.radius) * s)
    problem = cp.Problem(cp.Maximize(p @ y), constraints)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            problem.solve(solver=cp.CLARABEL)
    except (cp.SolverError, ValueError, ArithmeticError):
        return None
    if y.value is None or s.value is None or not s.value > 0 or not np.isfinite(y.value).all():
        return None
    return np.clip(y.value / s.value, low, high), float(problem.value)


def _into_ball(program: _Program, point: Floats, centres: Mapping[int, Sequence[Fraction]], ball: Ball, n: int) -> list[Fraction] | None:
    """Mix a point with the reference until it is exactly in the ball and the linear constraints."""
    position = {v: j for j, v in enumerate(program.variables)}
    reference = list(program.high)
    for row, values in centres.items():
        for u, value in enumerate(values):
            reference[position[row * n + u]] = value
    if not program.feasible(reference):
        return None
    start = [
        min(max(Fraction(round(v * 2**40), 2**40), lo), hi) for v, lo, hi in zip(point.tolist(), program.low, program.high, strict=True)
    ]
    share = Fraction(0)
    for step in range(-36, 1):
        values = [v + share * (w - v) for v, w in zip(start, reference, strict=True)]
        near = all(
            _divergence([values[position[row * n + u]] for u in range(n)], centre, ball) <= ball.radius for row, centre in centres.items()
        )
        if near and program.feasible(values):
            return values
        share = Fraction(2) ** step
    return reference
