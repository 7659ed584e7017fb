"""T13 near a policy: the greatest ratio over all policies within a total variation of this one, and how far a verdict stands.

Write o for what the filters release (x̃,ã), p(o,u) and q(o,u) for what the decision u at o adds to the expected utility of the two
groups of an ordered pair: locally M_X(x̃|x)·M_A(ã|a)·g(u,x,a), globally the mean of that over P(x|a). For c = p − Vq and policies T' with
TV(T'(·|o), T(·|o)) ≤ η at every o, the greatest Σ T'c is Σ_o [Σ_u T·c + the gain of moving mass η from the decisions with the least c to
the one with the greatest]. The ratio of every such policy is at most V ≥ 1 exactly if that is at most 0 for every ordered pair.

Passes over all pairs are made in floats, with an error bound that rules pairs out; those that are left are decided in integers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import gcd, inf, lcm, prod
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT, compare_log, exp_enclosure
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.exact.rationals import Number, at_least
from fairaudit.measures.limits import Quantity, Unit, read_limit
from fairaudit.measures.ratios import global_fairness, local_fairness
from fairaudit.model.law import Law
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import INT64, Label
from fairaudit.theorems.supremum import Supremum
from fairaudit.words import brief

__all__ = ["DriftRadius", "drift_radius", "greatest_ratio_near", "near_steps", "read_drift"]


Whole = NDArray[Any]
"""An array of integers: int64, or Python integers."""

Positions = NDArray[np.int64]

Place = tuple[tuple[int, int], Fraction, Literal[1, -1]]
"""What is looked at: α and β, the drift, and whether it is to be at most 0 or at least."""

CHUNK = 1 << 18  # numbers that are looked at together

FEW = 64  # pairs that are looked at closely for one that moves a search

SAFE = 1 << 62  # what fits int64 with a bit to spare

TINY = 2.0**-1060  # far more than the underflow of one term

STEP = Fraction(1, 10**12)  # of radii that are irrational

LARGEST_EXPONENT = 10_000  # of limits on logarithms; e^10,000 has 4,343 digits


@brief
@dataclass(frozen=True, repr=False)
class DriftRadius:
    """How far, in total variation, the law of the decision may move from that of a policy while a verdict on it stands.

    Attributes
    ----------
    verdict : {"within", "exceeds", "inconclusive"}
        The verdict on the policy itself; inconclusive where nothing is compared.
    radius : Fraction
        With "within": all policies up to and including this distance are within the limit. With "exceeds": all policies nearer than this
        exceed it. The distance counts for everything that the filters release, each on its own.
    always : bool
        Whether the verdict holds for every policy behind the filters; the radius is then 1.
    exact : bool
        Whether some policies beyond the radius, as close to it as one likes, have another verdict. It is a lower end otherwise: with
        "exceeds", where one pair of groups has to exceed for all policies alike, and with a limit on a logarithm.

    Examples
    --------
    >>> DriftRadius("within", Fraction(1, 10), always=False)
    DriftRadius(verdict='within', radius=Fraction(1, 10), always=False, exact=True)
    """

    verdict: Literal["within", "exceeds", "inconclusive"]
    radius: Fraction
    always: bool
    exact: bool = True


def greatest_ratio_near(deployment: Deployment, utility_table: UtilityTable, quantity: Quantity, drift: Number) -> Supremum | None:
    """Find the greatest ratio over all policies within a total variation of this one, for everything that the filters release.

    Source: T13.

    Parameters
    ----------
    deployment : Deployment
        The policy and its filters, one release of each.
    utility_table : UtilityTable
        The utility on the law that they induce.
    quantity : {"local", "global"}
        Which ratio.
    drift : number or str
        η, from 0 (this policy) to 1 (any policy).

    Returns
    -------
    Supremum or None
        The greatest ratio, exact, the first pair of groups that attains it, and the policy that does; None where nothing is compared, or
        where g is not given for some decision.

    Raises
    ------
    InputError
        If the drift is not from 0 to 1, or the deployment sees more than one release.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([["1/2", "1/4", "1/4"], ["1/4", "1/4", "1/2"]], decisions=["yes", "later", "no"], groups=["f", "m"])
    >>> deployment = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4"))
    >>> utility = fa.Utility({"yes": 4, "later": 2, "no": 1}).on(deployment.law)
    >>> [str(greatest_ratio_near(deployment, utility, "local", drift).value) for drift in (0, "1/20", 1)]
    ['41/35', '211/169', '13/7']
    """
    distance = read_drift(drift)
    found = _comparison(deployment, utility_table, quantity)
    if found is None:
        return None
    value: Extended = inf
    pair = found.first_infinite(distance)
    weights = (0, -1)
    if pair is None:
        value, pair = _greatest(found, distance)
        weights = (value.denominator, -value.numerator)
    if pair is None:
        return Supremum(quantity, value)
    block, i, j = (int(part) for part in found.pairs[pair])
    context = found.contexts[block] if found.contexts else None
    return Supremum(
        quantity, value, context=context, higher=found.groups[i], lower=found.groups[j], rows=found.attaining_rows(pair, weights, distance)
    )


def drift_radius(deployment: Deployment, utility_table: UtilityTable, quantity: Quantity, limit: Number, unit: Unit) -> DriftRadius:
    """Find the largest total variation up to which the verdict on a policy, within a limit or not, holds for every policy.

    For each ordered pair the greatest Σ T'(p − R*q) over the policies within η is concave, piecewise linear and does not fall in η.
    *Within* stands up to the last η at which it is at most 0 for every pair. *Exceeds* stands while one pair has Σ T'(p − R*q) > 0
    for every policy; where different policies exceed by different pairs it may stand longer, so that the radius is a lower end.

    Source: T13.

    Parameters
    ----------
    deployment, utility_table, quantity
        As in `greatest_ratio_near`.
    limit : number or str
        The limit R* on the ratio, or on its natural logarithm.
    unit : {"ratio", "log"}
        Which of the two. The radius for a logarithm is irrational, and given too small by at most 10⁻¹².

    Returns
    -------
    DriftRadius
        The verdict, and how far it stands; a radius of 0, which is not exact, where g is not given for some decision.

    Raises
    ------
    InputError
        If the limit is not one, or the deployment sees more than one release.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([["1/2", "1/4", "1/4"], ["1/4", "1/4", "1/2"]], decisions=["yes", "later", "no"], groups=["f", "m"])
    >>> deployment = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4"))
    >>> utility = fa.Utility({"yes": 4, "later": 2, "no": 1}).on(deployment.law)
    >>> drift_radius(deployment, utility, "local", "5/4", "ratio")
    DriftRadius(verdict='within', radius=Fraction(11, 216), always=False, exact=True)
    """
    at = read_limit(f"max_{quantity}_{unit}", limit)
    measured = (local_fairness if quantity == "local" else global_fairness)(utility_table.law, utility_table)
    found = _comparison(deployment, utility_table, quantity)
    if measured is None:
        return DriftRadius("inconclusive", ZERO, always=False)
    rational = ONE if unit == "log" and at == 0 else at if unit == "ratio" else None
    within = compare_log(measured.pair, (at.numerator, at.denominator)) <= 0 if rational is None else measured.ratio <= rational
    if found is None:
        return DriftRadius("within" if within else "exceeds", ZERO, always=False, exact=False)
    return _radius_of_log(found, at, measured.ratio, within=within) if rational is None else _radius(found, rational, within=within)


def near_steps(deployment: Deployment, utility_table: UtilityTable, quantity: Quantity, found: Supremum | None = None) -> int:
    """Bound the steps that a claim about the policies near this one asks of a reader: see "Work" in docs/certificate.md.

    Parameters
    ----------
    deployment, utility_table, quantity
        As in `greatest_ratio_near`.
    found : Supremum, optional
        What was found, whose digits count.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> deployment = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="2/3"))
    >>> near_steps(deployment, fa.Utility({"hire": 3, "pass": 1}).on(deployment.law), "local")
    144
    """
    local, context_filter = quantity == "local", deployment.context_filter
    groups = len(deployment.groups) if local else len(deployment.law.global_groups)
    shown_to = len(deployment.contexts)
    if context_filter is not None:
        reached = ([[v > 0 for v in row] for row in factor.rows] for factor in context_filter.factors)
        shown_to = prod(sum(map(sum, rows)) if local else sum(map(any, zip(*rows, strict=True))) for rows in reached)
    released = prod(sum(map(any, zip(*factor.rows, strict=True))) for factor in deployment.group_filter.factors)
    numbers = [deployment.group_filter.denominator, context_filter.denominator if context_filter else 1, utility_table.scale]
    numbers += [int(utility_table.values.max()), 1 if local else sum(deployment.law.cell_mass)]
    if found is not None and isinstance(found.value, Fraction):
        numbers += [max(found.value.as_integer_ratio())]
    left, right = sum(map(int.bit_length, numbers)), deployment.released_rows[1].bit_length()
    each = (20 + 8 * len(utility_table.law.decisions)) * (1 + (left >> 8)) * (1 + (right >> 8))
    return groups * (groups - 1) * shown_to * released * each


def read_drift(value: object, name: str = "drift") -> Fraction:
    """Read a total variation, from 0 to 1.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> read_drift("0.05")
    Fraction(1, 20)
    """
    distance = at_least(name, value, 0)
    if distance > 1:
        raise InputError(f"{name} is {shown(value)}; a total variation distance from 0 to 1 is accepted")
    return distance


# What is compared


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Ordered pairs of groups in blocks: one for each true context locally, one globally.

    Attributes
    ----------
    filter_rows : ndarray, shape (groups, ã)
        M_A of the compared groups, as integers with one sum.
    gains : ndarray, shape (blocks, groups or 1, x̃, decisions)
        What the filter's rows are multiplied with: M_X(x̃|x)·g(u,x,a) locally, its mean over P(x|a) globally, as integers of one unit. One
        group stands for all where they do not differ.
    policy : ndarray, shape (blocks or 1, x̃, ã, decisions)
        T, as integers.
    total : int
        What each row of T sums to.
    groups : tuple of tuple of str
        Labels of the groups.
    contexts : tuple of tuple of str
        Labels of the blocks; none globally.
    odds : ndarray, shape (blocks, x̃), or None
        M_X locally, as integers with one sum; None globally, and without a context filter.
    """

    filter_rows: Whole
    gains: Whole
    policy: Whole
    total: int
    groups: tuple[Label, ...]
    contexts: tuple[Label, ...]
    odds: Whole | None
    _ends: dict[Fraction, tuple[Whole, Whole]] = field(default_factory=dict, repr=False)

    @cached_property
    def pairs(self) -> Positions:
        """Block, higher and lower group of every ordered pair, in order."""
        count = len(self.groups)
        higher, lower = np.nonzero(~np.eye(count, dtype=bool))
        blocks = np.repeat(np.arange(len(self.gains)), len(higher))
        return np.column_stack((blocks, np.tile(higher, len(self.gains)), np.tile(lower, len(self.gains))))

    @property
    def blind(self) -> bool:
        """Whether the gains of all groups are the same: then the best and worst that a policy can do at o are the same for all pairs."""
        return bool(self.gains.shape[1] == 1)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of released contexts, of released groups, and of decisions."""
        return self.gains.shape[2], self.filter_rows.shape[1], self.gains.shape[3]

    @cached_property
    def greatest(self) -> tuple[int, int]:
        """The greatest entries of the filter's rows and of the gains."""
        return int(self.filter_rows.max()), int(self.gains.max())

    @cached_property
    def floats(self) -> tuple[Floats, Floats, Floats]:
        """Filter's rows, gains up to a factor, and policy, each entry off by a relative 2⁻⁵² at most, underflow aside."""
        return (
            _floats(self.filter_rows, int(self.filter_rows[0].sum())),
            _floats(self.gains, max(self.greatest[1], 1)),
            _floats(self.policy, self.total),
        )

    @cached_property
    def merged(self) -> tuple[Floats, Floats]:
        """For a bound: gains, indexed [decision, block, group, x̃], and what T gives each group, [block, group, x̃, ã].

        The x̃ that a context is shown as are one: policies that are near T at each of them are so on average.
        """
        _, gains, policy = self.floats
        if self.odds is not None:
            policy = np.einsum("by,yau->bau", _floats(self.odds, int(self.odds[0].sum())), policy[0])[:, None]
            gains = gains.sum(axis=2, keepdims=True)
        given = np.matmul(gains.swapaxes(1, 2), policy.swapaxes(2, 3)).swapaxes(1, 2)
        return np.ascontiguousarray(np.moveaxis(gains, 3, 0)), np.ascontiguousarray(given)

    def ends(self, drift: Fraction) -> tuple[Whole, Whole]:
        """For blind gains: the greatest and the least that policies within the drift give, by block and ã."""
        if drift not in self._ends:
            bottom = self.total * drift.denominator
            kind = _kind(2 * self.shape[0] * bottom * self.greatest[1])
            masses, gains = _as(self.policy, kind) * drift.denominator, _as(self.gains, kind).swapaxes(1, 2)
            most, least = (sign * _raised(sign * gains, masses, drift.numerator * self.total)[0].sum(axis=1) for sign in (1, -1))
            self._ends.clear()
            self._ends[drift] = most, least
        return self._ends[drift]

    def chunks(self, pairs: Positions, width: int) -> Iterator[tuple[slice, tuple[Positions, ...]]]:
        """Cut a list of pairs into parts of which each takes so many numbers."""
        step = max(1, CHUNK // width)
        for start in range(0, len(pairs), step):
            part = slice(start, start + step)
            yield part, tuple(self.pairs[pairs[part]].T)

    def terms(self, chosen: tuple[Positions, ...], arrays: tuple[Whole | Floats, ...]) -> tuple[Any, Any, Any]:
        """p, q and T of chosen pairs, each indexed [pair, x̃, ã, u]."""
        block, higher, lower = chosen
        rows, gains, policy = arrays
        one, other = (rows[group][:, None, :, None] for group in (higher, lower))
        gain, gain_of_other = ((gains[block, 0 if self.blind else group])[:, :, None, :] for group in (higher, lower))
        return one * gain, other * gain_of_other, policy[block if len(policy) > 1 else np.zeros_like(block)]

    def screen(self, pairs: Positions, weights: tuple[int, int], drift: Fraction) -> tuple[Floats, Floats]:
        """The greatest Σ T'(αp + βq) of the pairs up to a positive factor of each pair's own, and how far that is off at most.

        A sum over U decisions of rounded entries, sorted and accumulated, is off by less than (8U + 64)·2⁻⁵³ times the greatest |αp| + |βq|
        at o; these add up, over n values of o, to at most |α|·(sum over x̃ of the first group's greatest gain) + |β|·(that of the second).
        """
        alpha, beta = _as_floats(weights)
        if self.blind:
            return self._screen_blind(pairs, alpha, beta, drift)
        middle = np.empty(len(pairs))
        for part, chosen in self.chunks(pairs, prod(self.shape)):
            p, q, masses = self.terms(chosen, self.floats)
            value, _ = _raised(alpha * p + beta * q, masses, float(drift))
            middle[part] = value.reshape(len(value), -1).sum(axis=1)
        return middle, self._slack(self._sizes(pairs, weights))

    def rough(self, pairs: Positions, weights: tuple[int, int], drift: Fraction, sign: int) -> tuple[Floats, Floats]:
        """What sign·(the greatest Σ T'(αp + βq)) of the pairs is at most, sooner and less closely than in `screen`, and their sizes.

        No mass gains more than what the best decision is above the worst, and a policy within the drift moves as much from every decision.
        Rounding errors are fewer than those of `screen`.
        """
        sizes = self._sizes(pairs, weights)
        if self.blind:
            middle, slack = self.screen(pairs, weights, drift)
            return sign * middle + slack, sizes
        alpha, beta = _as_floats(weights)
        rows, moved, (gains, given) = self.floats[0], float(drift), self.merged
        bound = np.empty(len(pairs))
        for part, (block, higher, lower) in self.chunks(pairs, gains.shape[0] * gains.shape[3] * rows.shape[1]):
            one, other = alpha * rows[higher][:, None], beta * rows[lower][:, None]
            values = one * gains[:, block, higher][..., None]
            values += other * gains[:, block, lower][..., None]
            most, kept = values.max(axis=0), one * given[block, higher] + other * given[block, lower]
            top = np.minimum(kept + moved * (most - values.min(axis=0)), most) if sign > 0 else moved * (kept - most) - kept
            bound[part] = top.sum(axis=(1, 2))
        return bound + self._slack(sizes), sizes

    def _sizes(self, pairs: Positions, weights: tuple[int, int]) -> Floats:
        """What no |Σ T'(αp + βq)| exceeds but for rounding."""
        alpha, beta = _as_floats(weights)
        tops = self.floats[1].max(axis=3).sum(axis=2)
        block, higher, lower = self.pairs[pairs].T
        one, other = (tops[block, 0 if self.blind else group] for group in (higher, lower))
        sizes: Floats = np.maximum(abs(alpha) * one + abs(beta) * other, TINY)
        return sizes

    def _slack(self, sizes: Floats) -> Floats:
        contexts, released, decisions = self.shape
        error = (8 * decisions + 64 + 4 * contexts * released) * UNIT * 1.1
        return error * sizes + contexts * released * decisions * TINY

    def _screen_blind(self, pairs: Positions, alpha: float, beta: float, drift: Fraction) -> tuple[Floats, Floats]:
        most, least = self.ends(drift)
        scale = max(int(most.max()), 1)
        high, low = _floats(most, scale), _floats(least, scale)
        rows, released = self.floats[0], self.shape[1]
        middle, slack = np.empty(len(pairs)), np.empty(len(pairs))
        for part, (block, higher, lower) in self.chunks(pairs, released):
            weight = alpha * rows[higher] + beta * rows[lower]
            middle[part] = np.where(weight > 0, weight * high[block], weight * low[block]).sum(axis=1)
            slack[part] = (2 * released + 32) * UNIT * 1.1 * (abs(alpha) + abs(beta)) * high[block].max(axis=1)
        return middle, slack + released * TINY

    def sums(self, pairs: Positions, weights: tuple[int, int], drift: Fraction) -> tuple[Whole, Whole]:
        """The greatest Σ T'(αp + βq), exact up to a common positive factor, and, among the policies that attain it, the greatest Σ T'q."""
        alpha, beta = weights
        top, gain = self.greatest
        contexts, released, decisions = self.shape
        reach = (abs(alpha) + abs(beta)) * top * gain
        factor = top * gain + 1
        bottom = self.total * drift.denominator
        kind = _kind(2 * max(contexts * released * bottom * reach, reach * factor))
        total, second = np.empty(len(pairs), dtype=kind), np.empty(len(pairs), dtype=kind)
        if self.blind:
            most, least = (_as(end, kind) for end in self.ends(drift))
            rows = _as(self.filter_rows, kind)
            for part, (block, higher, lower) in self.chunks(pairs, released):
                weight = alpha * rows[higher] + beta * rows[lower]
                chosen = np.where(weight >= 0, most[block], least[block])
                total[part], second[part] = (weight * chosen).sum(axis=1), (rows[lower] * chosen).sum(axis=1)
            return total, second
        arrays = tuple(_as(array, kind) for array in (self.filter_rows, self.gains, self.policy))
        for part, chosen_pairs in self.chunks(pairs, contexts * released * decisions):
            p, q, masses = self.terms(chosen_pairs, arrays)
            values = alpha * p + beta * q
            moved = _moved(values * factor + q, masses * drift.denominator, drift.numerator * self.total)
            total[part], second[part] = ((moved * each).reshape(len(p), -1).sum(axis=1) for each in (values, q))
        return total, second

    def line(self, pair: int, weights: tuple[int, int], drift: Fraction) -> tuple[Fraction, Fraction]:
        """The greatest Σ T'(αp + βq) of one pair at a drift, and its slope to the right, in one unit."""
        alpha, beta = weights
        arrays = tuple(_as(array, object) for array in (self.filter_rows, self.gains, self.policy))
        p, q, masses = self.terms(tuple(self.pairs[[pair]].T), arrays)
        values, slopes = _raised(alpha * p + beta * q, masses * drift.denominator, drift.numerator * self.total)
        return Fraction(int(values.sum()), self.total * drift.denominator), Fraction(int(slopes.sum()))

    def first_infinite(self, drift: Fraction) -> int | None:
        """The first pair of which some policy within the drift gives the lower group nothing and the higher something."""
        movable = drift.numerator * self.total // drift.denominator
        gives, shown_to = self.gains > 0, self.filter_rows > 0
        lost = ~np.repeat(np.any(np.all(gives, axis=3), axis=2), len(self.groups) if self.blind else 1, axis=1)
        for block, group in np.argwhere(lost).tolist():
            lost[block, group] = self._can_lose(block, group, movable)
        pairs = np.flatnonzero(lost[self.pairs[:, 0], self.pairs[:, 2]])
        block, higher, lower = self.pairs[pairs].T
        one, other = (gives[block, 0 if self.blind else group] for group in (higher, lower))
        reached_alone = (shown_to[higher] & ~shown_to[lower]).any(axis=1)
        possible = (one & ~other).any(axis=(1, 2)) | (one.any(axis=(1, 2)) & reached_alone)
        for at in np.flatnonzero(possible).tolist():
            free = one[at][:, None, :] & shown_to[higher[at]][:, None]
            free &= ~(other[at][:, None, :] & shown_to[lower[at]][:, None])
            if drift == 0:
                free &= self.policy[block[at] if len(self.policy) > 1 else 0] > 0
            if free.any():
                return int(pairs[at])
        return None

    def _can_lose(self, block: int, group: int, movable: int) -> bool:
        """Whether a group's utility in a block can become 0 by moving so much mass at each o."""
        gives = self.gains[block, 0 if self.blind else group] > 0
        policy = self.policy[block if len(self.policy) > 1 else 0][:, self.filter_rows[group] > 0]
        return bool((np.where(gives[:, None, :], policy, 0).sum(axis=2) <= movable).all())

    def attaining_rows(self, pair: int, weights: tuple[int, int], drift: Fraction) -> tuple[tuple[Fraction, ...], ...]:
        """The policy with the greatest Σ T'(αp + βq), and of these the greatest Σ T'q (Σ T'p where α = 0); T where that is all the same."""
        alpha, beta = weights
        block, higher, lower = self.pairs[[pair]].T
        p, q, masses = self.terms(
            (block, higher, lower), tuple(_as(array, object) for array in (self.filter_rows, self.gains, self.policy))
        )
        keys = (alpha * p + beta * q) * (self.greatest[0] * self.greatest[1] + 1) + (q if alpha else p)
        masses = masses * drift.denominator
        moved = np.where((keys == keys[..., :1]).all(axis=3, keepdims=True), masses, _moved(keys, masses, drift.numerator * self.total))
        rows = _as(self.policy, object) * drift.denominator
        rows[block[0] if len(rows) > 1 else 0] = moved[0]
        bottom = self.total * drift.denominator
        return tuple(tuple(Fraction(mass, bottom) for mass in row) for row in rows.reshape(-1, rows.shape[3]).tolist())


def _comparison(deployment: Deployment, utility_table: UtilityTable, quantity: Quantity) -> _Comparison | None:
    """Lay out what is compared; None where nothing is, or where g is not given for some decision."""
    if deployment.releases > 1:
        raise InputError(f"policies near this one are those that see one release of a group; here one memory sees {deployment.releases}")
    positions = tuple(range(len(deployment.groups))) if quantity == "local" else deployment.law.global_groups
    if len(positions) < 2 or utility_table.given is not None:
        return None
    policy, total = deployment.released_rows
    law = utility_table.law
    unused = len(law.decisions) - policy.shape[2]
    if unused:
        policy = np.concatenate((policy, np.zeros((*policy.shape[:2], unused), dtype=policy.dtype)), axis=2)
    groups, contexts = deployment.groups, deployment.contexts
    rows = np.array([deployment.group_filter.row(a) for a in groups], dtype=object)
    rows = rows[list(positions)][:, (rows > 0).any(axis=0)]
    utilities = utility_table.values.astype(object)
    if not utility_table.by_decision:
        utilities = utilities.reshape(len(contexts), len(groups), -1)[:, list(positions)]
    mixing = deployment.context_filter
    odds = np.array([mixing.row(x) for x in contexts], dtype=object) if mixing else None
    if odds is not None:
        odds = odds[:, (odds > 0).any(axis=0)]
    gains = _gains(utilities, odds, len(contexts)) if quantity == "local" else _mean_gains(utilities, odds, deployment.law, positions)
    if (gains == gains[:, :1]).all():
        gains = gains[:, :1]
    return _Comparison(
        filter_rows=_lowest(rows),
        gains=_lowest(gains),
        policy=policy[:, None] if mixing is None and quantity == "local" else policy[None],
        total=total,
        groups=tuple(groups[a] for a in positions),
        contexts=contexts if quantity == "local" else (),
        odds=odds if quantity == "local" else None,
    )


def _gains(utilities: Whole, odds: Whole | None, contexts: int) -> Whole:
    """M_X(x̃|x)·g(u,x,a) up to one factor, indexed [x, group, x̃, decision]; without a filter, x̃ = x alone."""
    if utilities.ndim == 1:
        utilities = np.broadcast_to(utilities, (contexts, 1, len(utilities)))
    gains = utilities[:, :, None, :]
    return gains if odds is None else gains * odds[:, None, :, None]


def _mean_gains(utilities: Whole, odds: Whole | None, law: Law, positions: tuple[int, ...]) -> Whole:
    """Σ_x P(x|a)·M_X(x̃|x)·g(u,x,a) up to one factor, indexed [0, group, x̃, decision]."""
    masses = np.array(law.cell_mass, dtype=object).reshape(len(law.contexts), -1)[:, list(positions)]
    totals = masses.sum(axis=0).tolist()
    masses = masses * np.array([lcm(*totals) // total for total in totals], dtype=object)
    if utilities.ndim == 1:
        released: Whole = masses if odds is None else odds.T @ masses
        return (released.T[:, :, None] * utilities)[None]
    gains: Whole = (masses[:, :, None] * utilities).swapaxes(0, 1)
    return (gains if odds is None else np.stack([odds.T @ gain for gain in gains]))[None]


def _lowest(array: Whole) -> Whole:
    """Divide integers by their greatest common divisor, and keep them as int64 where they fit."""
    reduced: Whole = array // max(gcd(*array.ravel().tolist()), 1)
    return reduced.astype(np.int64) if int(reduced.max()) <= INT64 else reduced


def _floats(array: Whole, bottom: int) -> Floats:
    """Integers divided by another, in float64."""
    if array.dtype == object or bottom > INT64:
        return np.array([value / bottom for value in array.ravel().tolist()], dtype=np.float64).reshape(array.shape)
    divided: Floats = array / bottom
    return divided


def _as_floats(weights: tuple[int, int]) -> tuple[float, float]:
    """α and β, of which the greater is 1."""
    largest = max(map(abs, weights))
    alpha, beta = (weight / largest for weight in weights)
    return alpha, beta


def _kind(bound: int) -> Any:
    """The type of integers that holds everything up to a bound."""
    return np.int64 if bound < SAFE else object


def _as(array: Whole, kind: Any) -> Whole:
    return array if array.dtype == kind else array.astype(kind)


# Moving mass


def _raised(values: Any, masses: Any, budget: Any) -> tuple[Any, Any]:
    """Σ masses·values along the last axis after moving so much mass from the least values to the greatest, and its slope in the budget."""
    order = np.argsort(values, axis=-1, kind="stable")
    ranked = np.take_along_axis(values, order, axis=-1)
    shape = np.broadcast_shapes(values.shape, masses.shape)
    ordered = np.take_along_axis(np.broadcast_to(masses, shape), np.broadcast_to(order, shape), axis=-1)
    gaps = ranked[..., -1:] - ranked
    ends = np.cumsum(ordered, axis=-1)
    taken = np.diff(np.minimum(ends, budget), axis=-1, prepend=0)
    return (ordered * ranked + taken * gaps).sum(axis=-1), np.where(ends > budget, gaps, 0).max(axis=-1)


def _moved(keys: Whole, masses: Whole, budget: int) -> Whole:
    """The masses after moving so much of them from the least keys to the greatest."""
    order = np.argsort(keys, axis=-1, kind="stable")
    ordered = np.take_along_axis(masses, order, axis=-1)
    taken = np.diff(np.minimum(np.cumsum(ordered, axis=-1), budget), axis=-1, prepend=0)
    left = ordered - taken
    left[..., -1] += taken.sum(axis=-1)
    moved: Whole = np.empty_like(left)
    np.put_along_axis(moved, order, left, axis=-1)
    return moved


# Searches: floats say where to look, integers say what is so


def _settle(
    found: _Comparison, start: Fraction, at: Callable[[Fraction], Place], move: Callable[[int, Fraction], Fraction | None]
) -> tuple[Fraction | None, Positions]:
    """Move a point until no pair is above 0 there; say which pairs floats could not tell from 0. None if `move` says that there is no end.

    A pair that is at most 0 at a point stays so at all later points.
    """
    point, left = start, np.arange(len(found.pairs))
    while True:
        weights, drift, sign = at(point)
        bound, sizes = found.rough(left, weights, drift, sign)
        left, relative = left[bound > 0], (bound / sizes)[bound > 0]
        if len(left) > FEW:
            likely = left[np.argpartition(-relative, FEW)[:FEW]]
            middle, slack = found.screen(likely, weights, drift)
            best = int(np.argmax(sign * middle))
            moved = move(int(likely[best]), point) if sign * middle[best] > slack[best] else point
            if moved is None:
                return None, left
            if moved != point:
                point = moved
                continue
        middle, slack = found.screen(left, weights, drift)
        open_still = sign * middle + slack > 0
        left, middle = left[open_still], sign * middle[open_still]
        if not len(left):
            return point, left
        moved = move(int(left[np.argmax(middle)]), point)
        if moved == point:
            sums = sign * found.sums(left, weights, drift)[0]
            above = np.flatnonzero(sums > 0)
            if not len(above):
                return point, left
            moved = move(int(left[np.argmax(sums)]), point)
            left = left[above]
        if moved is None:
            return None, left
        point = moved


def _greatest(found: _Comparison, drift: Fraction) -> tuple[Fraction, int | None]:
    """The greatest ratio, which is finite, and the first pair that attains it; no pair if it is 1."""

    def newton(pair: int, value: Fraction) -> Fraction | None:
        while True:
            sums, lower = found.sums(np.array([pair]), (value.denominator, -value.numerator), drift)
            if sums[0] <= 0:
                return value
            value += Fraction(int(sums[0]), int(lower[0]) * value.denominator)

    value, left = _settle(found, ONE, lambda value: ((value.denominator, -value.numerator), drift, 1), newton)
    if value is None or value == 1:
        return ONE, None
    sums, lower = found.sums(left, (value.denominator, -value.numerator), drift)
    return value, int(left[(sums == 0) & (lower > 0)][0])


def _radius(found: _Comparison, limit: Fraction, *, within: bool) -> DriftRadius:
    """How far a verdict stands for a rational limit."""
    weights = (limit.denominator, -limit.numerator) if within else (-limit.denominator, limit.numerator)

    def crossing(pair: int, drift: Fraction) -> tuple[Fraction, Fraction] | None:
        """Where a concave function that does not fall reaches 0, at a drift or later, and its slope from there; None if it does not."""
        while True:
            value, slope = found.line(pair, weights, drift)
            if value >= 0:
                return drift, slope
            if slope == 0 or drift - value / slope > 1:
                return None
            drift -= value / slope

    def earlier(pair: int, radius: Fraction) -> Fraction:
        end = crossing(pair, ZERO)
        return min(radius, end[0]) if end and end[1] else radius

    def later(pair: int, radius: Fraction) -> Fraction | None:
        end = crossing(pair, radius)
        return end[0] if end else None

    if within:
        radius, _ = _settle(found, ONE, lambda drift: (weights, drift, 1), earlier)
        return DriftRadius("within", radius or ZERO, always=radius == 1)
    radius, _ = _settle(found, ZERO, lambda drift: (weights, drift, -1), later)
    return DriftRadius("exceeds", ONE if radius is None else radius, always=radius is None, exact=radius is None)


def _radius_of_log(found: _Comparison, limit: Fraction, ratio: Extended, *, within: bool) -> DriftRadius:
    """How far a verdict stands for a limit on the logarithm above 0, whose exponential is irrational: rounded down to 12 decimals."""
    verdict: Literal["within", "exceeds"] = "within" if within else "exceeds"
    if limit > LARGEST_EXPONENT and not within:
        return DriftRadius(verdict, ZERO, always=False, exact=False)
    exponent = min(limit, Fraction(LARGEST_EXPONENT))
    bits = 128
    while True:
        low, high = (Fraction(end, 1 << bits) for end in exp_enclosure((exponent.numerator, exponent.denominator), bits))
        if (ratio <= low) if within else (ratio > high):
            inner, outer = (_radius(found, end, within=within) for end in ((low, high) if within else (high, low)))
            if inner.always or (not outer.always and outer.radius - inner.radius <= STEP):
                break
        bits *= 2
    if inner.always:
        return inner
    return DriftRadius(verdict, inner.radius // STEP * STEP, always=False, exact=False)
