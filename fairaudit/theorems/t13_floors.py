"""T13 with floors: the greatest ratio over all policies that keep declared floors behind known filters, for a known utility.

First by one k for each ordered pair of groups, which is exact where only the floor of the lower group matters; then, behind filters that
are small enough to be multiplied out, by a linear program for each pair of which no k proves what some policy is seen to attain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.extended import ONE, Extended
from fairaudit.exact.mixtures import Floored, Search
from fairaudit.measures.limits import Quantity
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.theorems.bound import FLOORED
from fairaudit.theorems.supremum import Floors, PairProof, Supremum
from fairaudit.theorems.t13_one_k import OneK
from fairaudit.theorems.t13_problems import Problems, different_pairs
from fairaudit.theorems.t13_tables import Tables, means_by_release, utility_tables

MAX_CELLS = 100_000
"""Numbers of a policy, or of a group filter, that are multiplied out; and of floors times x̃ times decisions, forty times as many."""

EXACT_VARIABLES = 200
"""Linear programs with so many decisions at outputs are solved, however many floors there are."""

MAX_VARIABLES, MAX_ENTRIES = 2_000, 40_000
"""Others have at most so many, and so many times the number of floors."""

MAX_WORK, EACH = 3_000_000, 3_000
"""What all programs may come to, each with its entries and this besides: some ten seconds."""

Place = tuple[int | None, int, int]
"""A true context, or None for means, and the groups in the numerator and in the denominator."""

Cell = tuple[int | None, int]
"""A true context, or None for its mean, and a group."""

Whole = NDArray[Any]
"""An array of Python integers."""


def greatest_ratio_above(deployment: Deployment, utility_table: UtilityTable, quantity: Quantity, floors: Floors) -> Supremum | None:
    """T13: the greatest ratio of expected utilities over all policies that keep declared floors behind these filters.

    Source: T13.

    Parameters
    ----------
    deployment : Deployment
        The filters, the population, and a policy that keeps the floors.
    utility_table : UtilityTable
        The utility over the true contexts and groups; it may depend on decision, context and group.
    quantity : {"local", "global"}
        Whether groups are compared within contexts, or by their means.
    floors : Floors
        Of the expected utility of every group in each true context, and of the mean of every group that has mass.

    Returns
    -------
    Supremum or None
        With what proves it: for every ordered pair k is one of its multipliers or the value, or the pair is in `pairs`. Exact and attained
        by the policy in `rows`; otherwise an upper bound, where several releases are seen, or filters are too large to be multiplied out
        and more matters than the floor of the lower group. None where nothing is compared, or g is not given for some decision.

    Raises
    ------
    InputError
        If a linear program is needed, and the policy does not keep the floors.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([["0.9", "0.1"], ["0.8", "0.2"]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> deployment = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.7"))
    >>> utility = fa.Utility({"hire": 1, "pass": 0}).on(deployment.law)
    >>> found = greatest_ratio_above(deployment, utility, "local", Floors((Fraction(1, 2),)))
    >>> found.value, found.exact, found.rows
    (Fraction(11, 7), True, ((Fraction(1, 1), Fraction(0, 1)), (Fraction(2, 7), Fraction(5, 7))))
    """
    tables = utility_tables(deployment, utility_table, quantity, floors)
    if tables is None:
        return None
    problems = different_pairs(deployment.group_filter, deployment.releases, tables)
    one_k = OneK(problems, tables)
    value, at = one_k.greatest()
    found = _Found(value)
    small = max(deployment.released_rows[0].size, len(deployment.groups) * len(deployment.group_filter.outputs)) <= MAX_CELLS
    if deployment.releases == 1 and at is not None and small:
        behind = _Behind(deployment, utility_table, floors)
        x, first, second = problems.place(at)
        place = (x if quantity == "local" else None), first, second
        found = (
            _at_threshold(behind, place, value, one_k.bound(at)[1])
            or _by_programs(behind, place, one_k, lambda: _places(problems, tables, deployment, quantity))
            or found
        )
    result = Supremum(
        quantity,
        found.value,
        exact=found.value == 1,
        multipliers=one_k.multipliers(found.value) if isinstance(found.value, Fraction) else (),
        pairs=found.pairs,
        rows=found.rows,
        scope=FLOORED,
    )
    if found.place is None:
        return result
    context, higher, lower = found.place
    groups, contexts = deployment.groups, deployment.contexts
    return replace(result, exact=True, context=None if context is None else contexts[context], higher=groups[higher], lower=groups[lower])


@dataclass(frozen=True)
class _Found:
    """A bound, where it is attained if it is, by which policy, and what proves it for pairs that no k proves it for."""

    value: Extended
    place: Place | None = None
    rows: tuple[tuple[Fraction, ...], ...] = ()
    pairs: tuple[PairProof, ...] = ()


def _places(problems: Problems, tables: Tables, deployment: Deployment, quantity: Quantity) -> Iterator[tuple[int, Place]]:
    """Every ordered pair of groups, with the number of the one that stands for it."""
    keys = {key: at for at, key in enumerate(zip(*(v.tolist() for v in (problems.kind, problems.higher, problems.lower)), strict=True))}
    standing: list[tuple[int | None, int]] = list(enumerate(tables.standing)) if quantity == "local" else [(None, 0)]
    for a in range(len(deployment.groups)):
        kinds = problems.laws.of_row(a).tolist()
        for x, row in standing:
            of = tables.of[row].tolist()
            for b, kind in enumerate(kinds):
                if b != a and of[a] >= 0 and of[b] >= 0:
                    yield keys[kind, of[a], of[b]], (x, a, b)


class _Behind:
    """Policies behind filters that are multiplied out, o = (x̃,ã), for those x̃ that matter."""

    def __init__(self, deployment: Deployment, utility: UtilityTable, floors: Floors) -> None:
        self._deployment, self._utility = deployment, utility
        self.floors = floors
        self._programs: dict[int | None, _Program | None] = {}
        reached = np.array([deployment.group_filter.row(a) for a in deployment.groups], dtype=object)
        self.group_rows: Whole = reached[:, (reached > 0).any(axis=0)]
        start, self.whole = deployment.released_rows
        unused = len(utility.law.decisions) - start.shape[2]
        self.start: Whole = np.pad(start.astype(object), ((0, 0), (0, 0), (0, unused)))

    @cached_property
    def context_rows(self) -> Whole | None:
        """M_X over the x̃ that can be released, as integers."""
        mechanism = self._deployment.context_filter
        if mechanism is None:
            return None
        reached = np.array([mechanism.row(x) for x in self._deployment.contexts], dtype=object)
        rows: Whole = reached[:, (reached > 0).any(axis=0)]
        return rows

    @cached_property
    def _means(self) -> dict[int, tuple[Whole, int]]:
        """G_a(x̃,u) of the groups that have mass, as integers, and what they are over."""
        deployment = self._deployment
        mass = np.array(deployment.law.cell_mass, dtype=object).reshape(len(deployment.contexts), -1)
        groups = np.flatnonzero(mass.sum(axis=0) > 0).tolist()
        worth, totals = means_by_release(deployment, self._utility, groups)
        mechanism = deployment.context_filter
        if mechanism is not None:
            rows = np.array([mechanism.row(x) for x in deployment.contexts], dtype=object)
            worth = worth[(rows > 0).any(axis=0)]
        return {a: (worth[:, i], total * self._utility.scale) for i, (a, total) in enumerate(zip(groups, totals, strict=True))}

    def worth(self, cell: Cell) -> tuple[Whole, int]:
        """What a decision adds to an expected utility by x̃, before the group filter, as integers, and what they are over."""
        x, a = cell
        if x is None:
            return self._means[a]
        row = np.array(self._utility.row(x * len(self._deployment.groups) + a), dtype=object)
        shares = np.arange(len(self.start)) == x if self.context_rows is None else self.context_rows[x]
        return shares.astype(object)[:, None] * row, self._utility.scale * int(shares.sum())

    def floor(self, cell: Cell) -> Fraction:
        """The floor of an expected utility."""
        return self.floors.overall if cell[0] is None else self.floors.cells[cell[0]]

    def mean_floor(self, place: Place) -> Fraction:
        """What the floors say about the lower group of a pair."""
        x, _, a = place
        if x is not None:
            return self.floors.cells[x]
        mass = np.array(self._deployment.law.cell_mass, dtype=object).reshape(len(self._deployment.contexts), -1)[:, a]
        return max(self.floors.overall, Fraction(np.array(self.floors.cells, dtype=object) @ mass) / int(mass.sum()))

    def linked(self, x: int | None) -> tuple[list[int], list[Cell]]:
        """The x̃ that floors link with those of a context, all of them for means, and the floors that depend on them."""
        groups = range(len(self._deployment.groups))
        floored = {i for i, floor in enumerate(self.floors.cells) if floor > 0}
        every = range(len(self.start))
        if x is None or self.floors.overall > 0:
            means = self._means if self.floors.overall > 0 else {}
            return list(every), [*((i, a) for i in sorted(floored) for a in groups), *((None, a) for a in means)]
        releases = {i: {i} if self.context_rows is None else set(np.flatnonzero(self.context_rows[i] > 0).tolist()) for i in {*floored, x}}
        shown, linked = set(releases[x]), set[int]()
        while more := {i for i in floored - linked if releases[i] & shown}:
            linked |= more
            shown.update(*(releases[i] for i in more))
        return sorted(shown), [(i, a) for i in sorted(linked) for a in groups]

    def vector(self, cell: Cell, shown: list[int]) -> tuple[Whole, int]:
        """What a decision adds to an expected utility, by output (x̃,ã) and decision, as integers, and what they are over."""
        worth, bottom = self.worth(cell)
        rows = worth[shown][:, None, :] * self.group_rows[cell[1]][None, :, None]
        return rows.reshape(-1, rows.shape[2]), bottom * int(self.group_rows[0].sum())

    def pair(self, place: Place, shown: list[int]) -> tuple[Whole, Whole, int]:
        """P and q of a pair over one denominator."""
        x, higher, lower = place
        (p, above), (q, below) = (self.vector((x, group), shown) for group in (higher, lower))
        return p * below, q * above, above * below

    def keeps(self, policy: Whole, whole: int, shown: list[int], cells: list[Cell]) -> bool:
        """Whether a policy at some x̃ keeps floors."""
        blocks = policy.reshape(len(shown), self.group_rows.shape[1], -1)
        induced = np.array([self.group_rows @ block for block in blocks])
        unit = int(self.group_rows[0].sum()) * whole
        for cell in cells:
            worth, bottom = self.worth(cell)
            if Fraction(int((worth[shown] * induced[:, cell[1]]).sum()), bottom * unit) < self.floor(cell):
                return False
        return True

    def program(self, x: int | None) -> _Program | None:
        """The linear program of a context, or of means; None if it is too large."""
        if x not in self._programs:
            self._programs[x] = self._program(x)
        return self._programs[x]

    def _program(self, x: int | None) -> _Program | None:
        shown, cells = self.linked(x)
        start = self.start[shown].reshape(-1, self.start.shape[2])
        entries = start.size * len(cells)
        if start.size > EXACT_VARIABLES and (start.size > MAX_VARIABLES or entries > MAX_ENTRIES):
            return None
        rows, floors, units = [], [], []
        for cell in cells:
            row, bottom = self.vector(cell, shown)
            floor = self.floor(cell) * bottom
            rows.append(row * floor.denominator)
            floors.append(floor.numerator)
            units.append(bottom * floor.denominator)
        policies = Floored(np.array(rows, dtype=object).reshape(-1, *start.shape), floors, start, self.whole)
        if any(kept < floor * self.whole for kept, floor in zip((policies.rows * start).sum(axis=(1, 2)), floors, strict=True)):
            raise InputError("the policy does not keep the declared floors")
        return _Program(policies, shown, cells, units)

    def rows(self, policy: Whole, whole: int, shown: list[int]) -> tuple[tuple[Fraction, ...], ...]:
        """The whole policy, which elsewhere is the one of the deployment."""
        masses = self.start * whole
        masses[shown] = policy.reshape(len(shown), *masses.shape[1:]) * self.whole
        known: dict[int, Fraction] = {}
        bottom = whole * self.whole
        return tuple(tuple(known.setdefault(v, Fraction(v, bottom)) for v in row) for row in masses.reshape(-1, masses.shape[2]).tolist())


def _at_threshold(behind: _Behind, place: Place, value: Extended, k: Fraction | None) -> _Found | None:
    """The policy that decides by whether p − kq is greatest, mixed so that the lower group is at its floor, if it keeps all floors.

    Where all decisions are alike to the pair it is that of the deployment.
    """
    shown, cells = behind.linked(place[0])
    if len(cells) * len(shown) * behind.start.shape[2] > 40 * MAX_CELLS:
        return None
    p, q, bottom = behind.pair(place, shown)
    rate = value if k is None else k
    most = int(max(p.max(), q.max())) + 1
    excess = rate.denominator * p - rate.numerator * q if isinstance(rate, Fraction) else p - q * most
    start = behind.start[shown].reshape(p.shape)
    indifferent = ((excess == excess[:, :1]) & (q == q[:, :1])).all(axis=1)[:, None]
    more, less = (np.where(indifferent, start, behind.whole * _one_hot(excess * most + sign * q)) for sign in (1, -1))
    policy, whole = more, behind.whole
    if k is not None:
        high, low = int((more * q).sum()), int((less * q).sum())
        share = (behind.mean_floor(place) * bottom * whole - low) / (high - low) if high > low else ONE
        if not 0 <= share <= 1:
            return None
        policy = share.numerator * more + (share.denominator - share.numerator) * less
        whole *= share.denominator
    top, low = int((policy * p).sum()), int((policy * q).sum())
    attained = Fraction(top, low) == value if low else top > 0 and value == inf
    if not attained or not behind.keeps(policy, whole, shown, cells):
        return None
    return _Found(value, place, behind.rows(policy, whole, shown))


def _one_hot(values: Whole) -> Whole:
    """1 at the first greatest entry of each row."""
    found = np.zeros(values.shape, dtype=object)
    found[np.arange(len(values)), values.argmax(axis=1)] = 1
    return found


def _by_programs(behind: _Behind, first: Place, one_k: OneK, places: Callable[[], Iterator[tuple[int, Place]]]) -> _Found | None:
    """Newton's method with a linear program for each step, for pairs of which no k proves the greatest ratio so far."""
    value, best = ONE, _Found(ONE)
    proofs: dict[Place, PairProof] = {}
    members: dict[int, list[Place]] = {}
    open_, exceeding, work = [first], list[int](), 0
    while open_:
        place = open_.pop(0)
        program = behind.program(place[0])
        if program is None or work > MAX_WORK:
            return None
        work += program.policies.rows.size + EACH
        attained, proofs[place] = _newton(behind, program, place, value)
        if attained is not None:
            best = attained
            if not isinstance(best.value, Fraction):
                return best
            value = best.value
        if attained is not None or not members:
            exceeding = one_k.exceeding(value, MAX_WORK // EACH)
            if len(exceeding) > MAX_WORK // EACH:
                return None
            if not members:
                for at, member in places():
                    members.setdefault(at, []).append(member)
            exceeding.sort(key=lambda at: -one_k.bound(at)[0])
            open_ = [member for at in exceeding for member in members[at] if member not in proofs]
    return replace(best, pairs=tuple(proofs[member] for at in exceeding for member in members[at]))


@dataclass(frozen=True, eq=False)
class _Program:
    """The policies at linked x̃ that keep floors, the floors, and what their rows are multiplied with."""

    policies: Floored
    shown: list[int]
    cells: list[Cell]
    units: list[int]


def _newton(behind: _Behind, program: _Program, place: Place, value: Fraction) -> tuple[_Found | None, PairProof]:
    """The greatest ratio of a pair if it is above a value, and otherwise multipliers that prove that it is not."""
    p, q, bottom = behind.pair(place, program.shown)
    search, found = Search(program.policies), None
    while True:
        optimum = search.greatest(value.denominator * p - value.numerator * q)
        top, low = int((optimum.policy * p).sum()), int((optimum.policy * q).sum())
        if top * value.denominator <= value.numerator * low:
            unit = bottom * value.denominator
            floors = {program.cells[i]: y * program.units[i] / unit for i, y in optimum.prices.items()}
            return found, PairProof(*place, floors)
        rows = behind.rows(optimum.policy, optimum.whole, program.shown)
        if not low:
            return _Found(inf, place, rows), PairProof(*place, {})
        value = Fraction(top, low)
        found = _Found(value, place, rows)
