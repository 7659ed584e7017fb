"""The best filter for a target: least expected distortion, found in floating point, repaired and measured exactly.

A filter M(ã|a) costs Σ P(a)·M(ã|a)·c(a,ã), by default the probability that a lie is released. For a known policy the target
E(x,a) ≤ R*·E(x,a') is linear in M, and so is a cap M(ã|a) ≤ e^ε·M(ã|a'): a linear program, solved by HiGHS. Its answer is only a proposal.
It is made an exactly stochastic table of rationals, by solving the active constraints exactly or by rounding to a grid, and then mixed with
a filter inside the constraints (as a rule one that hides the group) by the least amount on the grid for which every constraint holds in
integers. The dual answer, rounded too, gives an exact lower bound on what any filter costs.

Without a policy, at a declared floor t, one k that serves all ordered pairs of rows makes the guarantee T3 linear,
H_k(M_a, M_a') ≤ t·(R* − k). Every k is sound; the search takes the best one. One k for each ordered pair can be better still: for two
groups, equally frequent, 0/1 distortion, t = 0.5 and R* = 1.4 a common k costs 0.375, and k = (0.6, 1.4) costs 0.357; that set of filters
is not convex, and is not searched.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from itertools import product
from math import gcd, inf, log, sqrt
from typing import Any

import numpy as np

from fairaudit import bounds, privacy
from fairaudit.calibration import calibrate, calibrate_policy
from fairaudit.columns import Label, label_text
from fairaudit.exact import InputError, at_least, common_denominator, exp_enclosure, log_enclosure, nearest, option_value, rational, shown
from fairaudit.fairness import local_fairness
from fairaudit.limits import ALONE, one_limit, without_bare_limits
from fairaudit.mechanism import Constant, Factor, Identity, Mechanism, RandomizedResponse
from fairaudit.policy import Policy
from fairaudit.utility import Utility

__all__ = ["Design", "Frontier", "design", "design_model_free", "frontier"]

Rows = Sequence[Sequence[int]]
Row = list[tuple[int, Fraction]]
Distortion = Mapping[Any, Any] | Sequence[Sequence[Any]] | Callable[[Any, Any], Any]

GRID = 10**12
DUAL_GRID = 1 << 60
TARGET_BITS = 80
MAX_GROUPS = 100
MAX_ENTRIES = 2_000_000
MAX_MODEL_FREE = 16
MAX_UNKNOWNS = 90
EASY_BITS = 256
GAP = 10**9
MOST_BITS = 12_000
GRID_POINTS = 9
GOLDEN_STEPS = 10
BISECTIONS = 30
MOST_EXCESS = 1 << 20
TIGHT = 1e-9


@dataclass(frozen=True)
class Design:
    """A filter for a target, or why there is none.

    Attributes
    ----------
    target : Fraction or None
        The target as a ratio R*, rounded down where it was given as a logarithm; None for a cap on ε alone.
    max_exp_epsilon : Fraction or None
        The cap e^ε, rounded down where it was given as ε; None for no cap.
    feasible : bool
        Whether a filter was found; see `reason`.
    mechanism : Mechanism or None
        The filter, exactly stochastic.
    distortion : Fraction or None
        Its expected distortion Σ P(a)·M(ã|a)·c(a,ã), exact.
    truth_kept : Fraction or None
        Σ P(a)·M(a|a), exact.
    lower_bound : Fraction or None
        No filter that meets target and cap has less distortion: from rounded dual multipliers, exact whatever their rounding. None for a
        design without a policy, where the search covers one common k only, except for a cap alone.
    achieved : Fraction or float or None
        The exact ratio of the policy behind the filter, or the ratio that is guaranteed for every policy; at most the target.
    exp_epsilon : Fraction or float
        e^ε of the filter, exact, of the whole tuple.
    multipliers : tuple of Fraction
        Without a policy, one k for every ordered pair that proves `achieved`, as in `fairaudit.bounds`.
    method : str
        How the filter was made.
    scope : str
        What `achieved` covers: "this law", or any policy behind this filter (that keeps the floor, where one is declared).
    assumptions : tuple of str
        What the reader must judge.
    response_distortion, response_truth_kept : Fraction or None
        The same two figures for the randomized response that `calibrate` or `calibrate_policy` finds for the target, held to the cap; the
        design is never worse. None if there is none.
    reason : str
        Why there is no filter, or what else is to be said.
    """

    target: Fraction | None
    max_exp_epsilon: Fraction | None
    feasible: bool
    mechanism: Mechanism | None
    distortion: Fraction | None
    truth_kept: Fraction | None
    lower_bound: Fraction | None
    achieved: Fraction | float | None
    exp_epsilon: Fraction | float
    multipliers: tuple[Fraction, ...]
    method: str
    scope: str
    assumptions: tuple[str, ...]
    response_distortion: Fraction | None = None
    response_truth_kept: Fraction | None = None
    reason: str = ""

    @property
    def epsilon(self) -> tuple[Decimal, Decimal]:
        """Enclosure of ε of the whole filter, in nats."""
        pair = (self.exp_epsilon.numerator, self.exp_epsilon.denominator) if isinstance(self.exp_epsilon, Fraction) else (1, 0)
        lo, hi = log_enclosure(pair)
        return Decimal(lo), Decimal(hi)


@dataclass(frozen=True)
class Frontier:
    """Designs of one setting for several targets.

    Attributes
    ----------
    designs : tuple of Design
        One for each target, in the order given.
    """

    designs: tuple[Design, ...]

    @property
    def rows(self) -> list[dict[str, Fraction | float | None]]:
        """Target against truth kept, as a table for `pandas.DataFrame`: exact numbers, None where there is no filter."""
        return [
            {
                "max_ratio": d.target,
                "truth_kept": d.truth_kept,
                "distortion": d.distortion,
                "lower_bound": d.lower_bound,
                "achieved_ratio": d.achieved,
                "exp_epsilon": d.exp_epsilon if d.feasible else None,
                "response_truth_kept": d.response_truth_kept,
                "response_distortion": d.response_distortion,
            }
            for d in self.designs
        ]


@dataclass(frozen=True, eq=False)
class _Problem:
    """What is asked for, in integers; inputs and outputs are the same labels."""

    labels: tuple[Label, ...]
    columns: tuple[str, ...]
    weights: tuple[int, ...]
    prices: tuple[tuple[int, ...], ...]
    """P(a)·c(a,ã) over `price_scale`."""
    price_scale: int
    target: Fraction | None
    cap: Fraction | None
    gains: tuple[tuple[tuple[int, ...], ...], ...] = ()
    """For each context and true group Σ_u T(u|x,ã)·g(u,x,a) over ã, up to a factor for each context."""
    level: Fraction | None = None
    """The declared floor, for a design without a policy."""

    @property
    def size(self) -> int:
        return len(self.labels)

    @property
    def group_free(self) -> bool:
        return all(row == block[0] for block in self.gains for row in block)

    def cost(self, rows: Rows, bottom: int) -> Fraction:
        total = sum(p * v for prices, row in zip(self.prices, rows, strict=True) for p, v in zip(prices, row, strict=True))
        return Fraction(total, self.price_scale * bottom)

    def truth(self, rows: Rows, bottom: int) -> Fraction:
        return Fraction(sum(w * row[i] for i, (w, row) in enumerate(zip(self.weights, rows, strict=True))), sum(self.weights) * bottom)

    def holds(self, rows: Rows, bottom: int) -> bool:
        """Whether a stochastic table meets cap and target, in integers."""
        if self.cap is not None:
            top, under = self.cap.numerator, self.cap.denominator
            if any(max(column) * under > min(column) * top for column in zip(*rows, strict=True)):
                return False
        if self.target is None:
            return True
        if self.level is not None:
            return bounds.t3_mechanism(self.mechanism(rows, bottom), self.level, floor="declared").value <= self.target
        top, under = self.target.numerator, self.target.denominator
        for block in self.gains:
            means = [sum(v * g for v, g in zip(row, gains, strict=True)) for row, gains in zip(rows, block, strict=True)]
            if max(means) * under > min(means) * top:
                return False
        return True

    def mechanism(self, rows: Rows, bottom: int) -> Mechanism:
        common = gcd(bottom, *(v for row in rows for v in row))
        table = tuple(tuple(v // common for v in row) for row in rows)
        return Mechanism((Factor(self.labels, self.labels, table, bottom // common),), self.columns)

    def rows_of(self, mechanism: Mechanism) -> tuple[list[list[int]], int]:
        """A filter of the same labels as a table in this order."""
        place = {label: j for j, label in enumerate(mechanism.outputs)}
        order = [place[label] for label in self.labels]
        return [[row[j] for j in order] for row in (mechanism.row(label) for label in self.labels)], mechanism.denominator


@dataclass(frozen=True)
class _Program:
    """The linear program: rows ≤ 0 over the table's entries and auxiliary variables ≥ 0; every row of the table sums to 1."""

    size: int
    variables: int
    rows: list[Row]
    lifts: dict[int, list[int]] = field(default_factory=dict)
    """For an auxiliary variable the rows in which its coefficient is 1."""


@without_bare_limits(ALONE)
def design(
    policy: Policy,
    utility: Utility | Mapping[Any, Any],
    *,
    max_ratio: Any = None,
    max_log: Any = None,
    population: Any = None,
    distortion: Distortion | None = None,
    max_epsilon: Any = None,
    max_exp_epsilon: Any = None,
) -> Design:
    """Find the filter of least expected distortion for a known policy.

    The filter acts on the groups of the policy as they are: where a group is a tuple of attributes, on the joint tuples, so that a product
    of filters is a special case. Contexts are not filtered.

    Parameters
    ----------
    policy : Policy
        The known policy; it needs a law for every group in every context.
    utility : Utility or mapping
        g; it may depend on the group, but then a target may be infeasible.
    max_ratio : number or str, optional
        Target R* ≥ 1 for R; one under 1 is least over greatest, so that 0.8 is 5/4.
    max_log : number or str, optional
        Target L* ≥ 0 for L, its natural logarithm. At most one of the two; none for a cap alone.
    population : array_like, mapping or Law, optional
        P(x,a) as in `Policy.behind`; only P(a) matters here. Without one, groups are equally frequent.
    distortion : mapping, table or callable, optional
        c(a,ã) ≥ 0: a mapping from (a, ã), in which pairs with ã = a may be left out and are 0; a square table in the order of the policy's
        groups; or a callable of two labels (texts, or tuples for several columns). By default 1 for a lie.
    max_epsilon : number or str, optional
        Cap on ε of the filter, in nats.
    max_exp_epsilon : number or str, optional
        The same as e^ε ≥ 1. At most one of the two.

    Returns
    -------
    Design
        The filter with its exact figures, or why there is none; scope "this law". Source: section 6 of docs/theory.md.

    Raises
    ------
    InputError
        If a number is out of range, neither target nor cap is given, or the distortion names unknown groups.

    Examples
    --------
    >>> policy = Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> found = design(policy, {"hire": 1}, max_ratio=2)
    >>> found.achieved, found.truth_kept, found.response_truth_kept < found.truth_kept
    (Fraction(2, 1), Fraction(23, 28), True)
    """
    target = _target(max_ratio, max_log)
    cap = _cap(max_epsilon, max_exp_epsilon)
    _something(target, cap)
    law = policy.law
    if not law.complete:
        raise InputError("the policy lacks a law for some group in some context; a design needs every group in every context")
    count = len(law.groups)
    if count > MAX_GROUPS or count * count * len(law.contexts) > MAX_ENTRIES:
        size = f"{count} groups in {len(law.contexts)} contexts"
        raise InputError(f"the policy has {size}; a design accepts up to {MAX_GROUPS} groups, and fewer with many contexts")
    wanted = utility if isinstance(utility, Utility) else Utility(utility)
    mass = policy.behind(group=Identity(law.groups), population=population).mass
    weights = [1] * count if mass is None else [sum(mass[i::count]) for i in range(count)]
    problem = _problem(law.groups, law.columns.group, weights, distortion, target, cap)
    problem = replace(problem, gains=_gains(policy, wanted))

    def measured(mechanism: Mechanism) -> Fraction | float:
        table = wanted.on(policy.behind(group=mechanism, population=population).law)
        found = local_fairness(table.law, table)
        return Fraction(1) if found is None else found.ratio

    found = _best(problem, _policy_response(problem, policy, wanted))
    if found.mechanism is not None:
        found = replace(found, achieved=measured(found.mechanism))
    return _checked(replace(found, scope=bounds.THIS_LAW, assumptions=(bounds.FRESH,)))


@without_bare_limits(ALONE)
def design_model_free(
    groups: int | Sequence[Any] | Mapping[str, int | Sequence[Any]],
    *,
    max_ratio: Any = None,
    max_log: Any = None,
    tau: Any = 0,
    gamma: Any = 1,
    population: Mapping[Any, Any] | Sequence[Any] | None = None,
    distortion: Distortion | None = None,
    max_epsilon: Any = None,
    max_exp_epsilon: Any = None,
) -> Design:
    """Find a filter of small expected distortion that guarantees a target for every policy that keeps a floor.

    The search covers the filters that one k certifies for all ordered pairs of rows, H_k(M_a, M_a') ≤ t·(R* − k) with t = τ/γ: a linear
    program for each k, on a grid and then by golden section. Every k is sound, and the filter is measured at the end by the exact T3. One k
    for each ordered pair can be better (see the module), and is not searched. Without a floor the target is a cap e^ε ≤ R* (T2).

    Parameters
    ----------
    groups : int, sequence, or mapping of name to int or sequence
        Number or labels of the groups (tuples for several columns); for several attributes the filter acts on the joint tuples.
    max_ratio, max_log, distortion, max_epsilon, max_exp_epsilon
        As in `design`.
    tau, gamma : number or str
        Declared floor of every group's expected utility behind the filter (0 for none), and the greatest utility.
    population : mapping or sequence, optional
        P(a) up to a factor, by group or in the order of the groups; equally frequent by default.

    Returns
    -------
    Design
        The filter, for any policy behind it that keeps the floor. With equally frequent groups and 0/1 distortion it is randomized
        response, the best filter that a common k certifies.

    Raises
    ------
    InputError
        As in `design`, and if `gamma` is below `tau`.

    Examples
    --------
    >>> found = design_model_free(2, max_ratio="1.4", tau="0.5")
    >>> found.distortion, found.achieved
    (Fraction(3, 8), Fraction(7, 5))
    >>> design_model_free(["a", "b", "c"], max_exp_epsilon=2).truth_kept
    Fraction(1, 2)
    """
    target = _target(max_ratio, max_log)
    cap = _cap(max_epsilon, max_exp_epsilon)
    _something(target, cap)
    floor, top = at_least("tau", tau, 0), at_least("gamma", gamma, 0)
    if top == 0:
        raise InputError("gamma is 0; a utility that is always 0 treats everybody alike, and needs no filter")
    if floor > top:
        raise InputError(f"tau is {shown(tau)}, above gamma, which is {shown(gamma)}; a floor of at most the greatest utility is accepted")
    attributes = _attributes(groups)
    labels = tuple(sum(parts, ()) for parts in product(*attributes.values()))
    if len(labels) > MAX_GROUPS:
        raise InputError(f"there are {len(labels)} joint groups; a design accepts up to {MAX_GROUPS}")
    columns = tuple(attributes) if isinstance(groups, Mapping) else ()
    problem = _problem(labels, columns, _masses(population, labels), distortion, target, cap)
    level = floor / top
    if target is not None and level == 0:
        problem = replace(problem, cap=target if cap is None else min(cap, target), target=None)
    elif target is not None and level * target < 1:
        problem = replace(problem, level=level)
    else:
        problem = replace(problem, target=None)
    found = _best(problem, _free_response(problem, target, attributes, floor, top))
    if problem.level is not None:
        found = replace(found, lower_bound=None)
    found = replace(found, target=target, max_exp_epsilon=cap)
    mechanism = found.mechanism
    if mechanism is None:
        return found
    if target is not None and level > 0:
        if problem.level is None:
            proof = bounds.floor_cap(top, floor, floor="declared")
            found = replace(found, reason="the floor alone keeps the ratio under the target, whatever the filter")
        else:
            proof = bounds.t3_mechanism(mechanism, level, floor="declared")
    else:
        proof = bounds.t2(found.exp_epsilon)
    assumptions = tuple(text for text in proof.assumptions if not text.startswith("the group filter multiplies"))
    return _checked(replace(found, achieved=proof.value, multipliers=proof.multipliers, scope=proof.scope, assumptions=assumptions))


@without_bare_limits(ALONE)
def frontier(
    *,
    max_ratio: Iterable[Any] | None = None,
    max_log: Iterable[Any] | None = None,
    policy: Policy | None = None,
    utility: Utility | Mapping[Any, Any] | None = None,
    **options: Any,
) -> Frontier:
    """Design for several targets: how much truth each of them costs.

    Parameters
    ----------
    max_ratio, max_log : iterable of number or str, optional
        Targets for R, or for L, its natural logarithm; exactly one of the two.
    policy, utility
        As in `design`; without a policy `design_model_free` is asked, whose `groups` are then among the options.
    **options
        As in `design` or `design_model_free`.

    Returns
    -------
    Frontier
        The designs; `rows` is the table.

    Examples
    --------
    >>> found = frontier(max_ratio=["1.2", "1.4"], groups=2, tau="0.5")
    >>> [str(row["truth_kept"]) for row in found.rows]
    ['5/9', '5/8']
    """
    asked = {name: value for name, value in (("max_ratio", max_ratio), ("max_log", max_log)) if value is not None}
    if len(asked) != 1:
        raise InputError("give the targets as one of max_ratio, limits on the ratio, and max_log, limits on its natural logarithm")
    ((name, targets),) = asked.items()
    if policy is None:
        if "groups" not in options:
            raise InputError("neither a policy nor groups were given; give a policy with its utility, or groups")
        return Frontier(tuple(design_model_free(**{name: target}, **options) for target in targets))
    if utility is None:
        raise InputError("a policy was given without a utility; give both")
    return Frontier(tuple(design(policy, utility, **{name: target}, **options) for target in targets))


# From input to integers


def _target(max_ratio: Any, max_log: Any) -> Fraction | None:
    """The target as a ratio, rounded down where a logarithm was given; None for a cap alone."""
    if max_ratio is None and max_log is None:
        return None
    unit, limit = one_limit(max_ratio, max_log)
    return limit if unit == "ratio" else _exp_below("max_log", limit)


def _cap(epsilon: Any, factor: Any) -> Fraction | None:
    if epsilon is not None and factor is not None:
        raise InputError("max_epsilon and max_exp_epsilon were given; give at most one")
    if factor is not None:
        number = at_least("max_exp_epsilon", factor, 0)
        if number < 1:
            raise InputError(f"max_exp_epsilon is {shown(factor)}; a factor e^ε of at least 1 is accepted")
        return number
    return None if epsilon is None else _exp_below("max_epsilon", epsilon)


def _exp_below(name: str, value: Any) -> Fraction:
    """Exponential of the value, rounded down, and at least 1."""
    number = at_least(name, value, 0)
    if number > 10_000:
        raise InputError(f"{name} is {shown(value)}; a number from 0 to 10,000 is accepted")
    low, _ = exp_enclosure((number.numerator, number.denominator), TARGET_BITS)
    return max(Fraction(1), Fraction(low, 1 << TARGET_BITS)) if number else Fraction(1)


def _something(target: Fraction | None, cap: Fraction | None) -> None:
    if target is None and cap is None:
        raise InputError("neither a target nor a cap on epsilon was given; the identity filter distorts nothing")


def _attributes(groups: int | Sequence[Any] | Mapping[str, int | Sequence[Any]]) -> dict[str, tuple[Label, ...]]:
    listed = groups if isinstance(groups, Mapping) else {"group": groups}
    result = {}
    for name, values in listed.items():
        if isinstance(values, int) and not isinstance(values, bool) and values > MAX_GROUPS:
            raise InputError(f"the attribute {shown(name)} has {values} values; a design accepts up to {MAX_GROUPS} joint groups")
        if isinstance(values, (str, bool)) or not isinstance(values, (int, Sequence)):
            raise InputError(
                f"the values of the attribute {shown(name)} are {shown(values)}; a number of values or a list of labels is accepted"
            )
        labels = tuple(_label(value) for value in (range(values) if isinstance(values, int) else values))
        if len(labels) < 2 or len(set(labels)) != len(labels) or len({len(label) for label in labels}) > 1:
            raise InputError(f"the attribute {shown(name)} needs at least two values, all different")
        result[name] = labels
    if not result:
        raise InputError("no attribute was given; name at least one")
    return result


def _masses(population: Mapping[Any, Any] | Sequence[Any] | None, labels: tuple[Label, ...]) -> list[int]:
    if population is None:
        return [1] * len(labels)
    if isinstance(population, Mapping):
        given = {_label(key): at_least("population", value, 0) for key, value in population.items()}
        for label in given:
            if label not in labels:
                raise InputError(
                    f"the population names the group {shown(', '.join(label))}; {nearest(', '.join(label), map(', '.join, labels))}"
                )
        numbers = [given.get(label, Fraction(0)) for label in labels]
    else:
        numbers = [at_least("population", value, 0, _reader(population)) for value in population]
        if len(numbers) != len(labels):
            raise InputError(f"the population has {len(numbers)} masses for {len(labels)} groups; give one for each")
    if not any(numbers):
        raise InputError("every mass of the population is zero; at least one must be positive")
    return common_denominator([(v.numerator, v.denominator) for v in numbers])[0]


def _reader(given: Any) -> Callable[[object], tuple[int, int]]:
    """How numbers are read: entries of an array as what they store, others as options."""
    return rational if isinstance(given, np.ndarray) else option_value


def _label(value: Any) -> Label:
    texts = [label_text(part) for part in (value if isinstance(value, tuple) else (value,))]
    if not texts or None in texts:
        raise InputError(f"{shown(value)} is not a group; a label, or a tuple of labels for several columns, is accepted")
    return tuple(text for text in texts if text is not None)


def _problem(
    labels: tuple[Label, ...],
    columns: tuple[str, ...],
    weights: Sequence[int],
    distortion: Distortion | None,
    target: Fraction | None,
    cap: Fraction | None,
) -> _Problem:
    costs = _costs(distortion, labels)
    flat, bottom = common_denominator([(c.numerator, c.denominator) for row in costs for c in row])
    size = len(labels)
    prices = tuple(tuple(weights[a] * flat[a * size + j] for j in range(size)) for a in range(size))
    return _Problem(labels, columns, tuple(weights), prices, bottom * sum(weights), target, cap)


def _costs(distortion: Distortion | None, labels: tuple[Label, ...]) -> list[list[Fraction]]:
    if distortion is None:
        return [[Fraction(int(a != b)) for b in labels] for a in labels]

    def number(a: Label, b: Label, value: Any) -> Fraction:
        return at_least(f"the distortion of {', '.join(a)} released as {', '.join(b)}", value, 0, _reader(distortion))

    if callable(distortion):
        bare = [label[0] if len(label) == 1 else label for label in labels]
        return [[number(a, b, distortion(x, y)) for b, y in zip(labels, bare, strict=True)] for a, x in zip(labels, bare, strict=True)]
    if not isinstance(distortion, Mapping):
        table = np.asarray(distortion, dtype=object)
        if table.shape != (len(labels), len(labels)):
            raise InputError(
                f"the distortion is a table of shape {table.shape}; it must be {len(labels)} by {len(labels)}, groups by groups"
            )
        return [[number(a, b, v) for b, v in zip(labels, row, strict=True)] for a, row in zip(labels, table.tolist(), strict=True)]
    given: dict[tuple[Label, Label], Fraction] = {}
    for key, value in distortion.items():
        if not isinstance(key, tuple) or len(key) != 2:
            raise InputError(f"the distortion has the key {shown(key)}; a pair of a true and a released group is accepted")
        pair = (_label(key[0]), _label(key[1]))
        for label in pair:
            if label not in labels:
                raise InputError(
                    f"the distortion names the group {shown(', '.join(label))}; {nearest(', '.join(label), map(', '.join, labels))}"
                )
        given[pair] = number(*pair, value)
    for a, b in product(labels, repeat=2):
        if a != b and (a, b) not in given:
            raise InputError(f"the distortion of {', '.join(a)} released as {', '.join(b)} is missing; give every pair of different groups")
    return [[given.get((a, b), Fraction(0)) for b in labels] for a in labels]


def _gains(policy: Policy, utility: Utility) -> tuple[tuple[tuple[int, ...], ...], ...]:
    """Σ_u T(u|x,ã)·g(u,x,a) for each context, true group and released group; contexts in which all are 0 are left out."""
    law = policy.law
    count = len(law.groups)
    # Behind a filter that hides the group every decision that can follow has weight, so that a utility with gaps is refused here.
    table = utility.on(policy.behind(group=Constant(law.groups)).law)
    blocks = []
    for start in range(0, len(law.cell_context), count):
        rows = [law.row(start + j) for j in range(count)]
        whole, _ = common_denominator([(1, sum(row)) for row in rows])
        gains: list[list[int]] = []
        for a in range(count):
            if a and table.by_decision:
                gains.append(gains[0])
                continue
            values = table.row(start + a)[: len(law.decisions)]
            gains.append(
                [scale * sum(w * g for w, g in zip(row, values, strict=True) if w) for scale, row in zip(whole, rows, strict=True)]
            )
        common = gcd(*(v for row in gains for v in row))
        if common:
            blocks.append(tuple(tuple(v // common for v in row) for row in gains))
    return tuple(blocks)


# Choosing among filters


def _best(problem: _Problem, response: Sequence[Mechanism]) -> Design:
    """The cheapest of everything that was proposed and meets the constraints exactly; `response` is what it is compared with."""
    proposed = [(mechanism, "randomized response") for mechanism in response]
    proposed += [(_constant(problem), "the same release for everybody")]
    lower: Fraction | None = None
    reason = ""
    symmetric = _symmetric(problem)
    if symmetric is not None:
        proposed.insert(0, (symmetric, "randomized response, exactly solved"))
        lower = problem.cost(*problem.rows_of(symmetric))
    else:
        found, lower, reason = _searched(problem)
        proposed = [*found, *proposed]
    figures: list[tuple[Fraction, Fraction, int, Mechanism, str]] = []
    for mechanism, method in proposed:
        rows, bottom = problem.rows_of(mechanism)
        if problem.holds(rows, bottom):
            figures.append((problem.cost(rows, bottom), -problem.truth(rows, bottom), len(figures), mechanism, method))
    compared = min(((c, -t) for c, t, _, m, _ in figures if any(m is r for r in response)), default=(None, None))
    answer = Design(
        problem.target, problem.cap, False, None, None, None, lower, None, inf, (), "", "", (), compared[0], compared[1], reason
    )
    if not figures:
        return answer
    cost, lie, _, mechanism, method = min(figures, key=lambda entry: entry[:3])
    return replace(
        answer,
        feasible=True,
        mechanism=mechanism if mechanism.columns else replace(mechanism, columns=problem.columns),
        distortion=cost,
        truth_kept=-lie,
        exp_epsilon=privacy.exp_epsilon(mechanism),
        method=method,
        reason="",
    )


def _checked(found: Design) -> Design:
    """Refuse to return what is not on target."""
    over = found.target is not None and found.achieved is not None and found.achieved > found.target
    if found.mechanism is not None and (over or (found.max_exp_epsilon is not None and found.exp_epsilon > found.max_exp_epsilon)):
        raise InputError("the filter that was found exceeds the target or the cap; this is a fault of the program, please report it")
    return found


def _constant(problem: _Problem) -> Mechanism:
    totals = [sum(column) for column in zip(*problem.prices, strict=True)]
    return replace(Constant(problem.labels, problem.labels[totals.index(min(totals))]), columns=problem.columns)


def _symmetric(problem: _Problem) -> Mechanism | None:
    """Randomized response in closed form, where all groups look alike: any filter can then be averaged over all renamings of the groups."""
    size = problem.size
    off = {problem.prices[a][j] for a in range(size) for j in range(size) if a != j}
    on = {problem.prices[a][a] for a in range(size)}
    if (problem.gains and problem.target is not None) or len(off) > 1 or len(on) > 1 or min(on) > min(off):
        return None
    factor: Fraction | None = problem.cap
    if problem.target is not None and problem.level is not None:
        part = problem.level * (problem.target - 1)
        options = [problem.target, (1 - problem.level) / (1 - problem.level * problem.target)]
        options += [(1 + (size - 1) * part) / (1 - part)] if part < 1 else []
        factor = max(options) if factor is None else min(factor, max(options))
    if factor is None:
        return replace(Identity(problem.labels), columns=problem.columns)
    return replace(RandomizedResponse(problem.labels, exp_epsilon=factor), columns=problem.columns)


def _policy_response(problem: _Problem, policy: Policy, utility: Utility) -> list[Mechanism]:
    """The calibrated randomized response, and one over the joint tuples that is also held to the cap."""
    if problem.target == 1:
        return [RandomizedResponse(problem.labels, exp_epsilon=1)]
    found = [_joint_response(problem)]
    if problem.target is not None:
        found.append(calibrate_policy(policy, utility, max_ratio=problem.target).mechanism)
    if problem.cap is not None:
        found.append(RandomizedResponse(problem.labels, exp_epsilon=problem.cap))
    return [mechanism for mechanism in found if mechanism is not None]


def _joint_response(problem: _Problem) -> Mechanism | None:
    """Randomized response over the labels that keeps as much as the constraints allow, by bisection on the grid."""
    size = problem.size

    def attempt(step: int) -> tuple[list[list[int]], int]:
        return [[step * (size - 1) if i == j else GRID - step for j in range(size)] for i in range(size)], GRID * (size - 1)

    low, high = -(-GRID // size), GRID + 1
    if not problem.holds(*attempt(low)):
        uniform = RandomizedResponse(problem.labels, exp_epsilon=1)
        return uniform if problem.holds(*problem.rows_of(uniform)) else None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if problem.holds(*attempt(middle)) else (low, middle)
    return problem.mechanism(*attempt(low))


def _free_response(
    problem: _Problem, target: Fraction | None, attributes: Mapping[str, tuple[Label, ...]], tau: Fraction, gamma: Fraction
) -> list[Mechanism]:
    """The calibrated randomized response, for each attribute and over the joint tuples, and the latter at the cap."""
    found = [RandomizedResponse(problem.labels, exp_epsilon=1)]
    if target is not None and target > 1:
        settings: list[Any] = [attributes, problem.labels] if len(attributes) > 1 else [attributes]
        for groups in settings:
            calibrated = calibrate(max_ratio=target, groups=groups, tau=tau, gamma=gamma)
            found += [calibrated.mechanism] if calibrated.mechanism is not None else []
    if problem.cap is not None:
        found.append(RandomizedResponse(problem.labels, exp_epsilon=problem.cap))
    return found


# The linear program and what is made of its answer


def _searched(problem: _Problem) -> tuple[list[tuple[Mechanism, str]], Fraction | None, str]:
    """Filters by linear programming, an exact lower bound on the distortion where there is one, and why nothing was found."""
    if problem.level is not None and problem.target is not None:
        return _searched_over_k(problem, problem.level, problem.target), None, ""
    program = _program(problem)
    prices = _prices(problem)
    solved = _solve(program, prices)
    if solved is None:
        deepest = _deepest(problem)
        inside = deepest is not None and problem.holds(deepest, GRID)
        return (
            ([(problem.mechanism(deepest, GRID), "linear program, well inside the constraints")], None, "")
            if inside and deepest
            else ([], None, _why_not(problem))
        )
    values, duals = solved
    lower = _dual_bound(program, prices, duals)
    found: list[tuple[Mechanism, str]] = []
    repaired = _repaired(problem, values[: problem.size**2])
    if repaired is not None:
        found.append((repaired, "linear program, rounded and mixed until exact"))
    close = repaired is not None and problem.cost(*problem.rows_of(repaired)) - lower < Fraction(1, GAP)
    vertex = _vertex(problem, program, values, EASY_BITS if close else MOST_BITS)
    if vertex is not None:
        found.append((vertex, "linear program, exactly solved"))
    if not found:
        return found, lower, "a filter may exist, but none was found that holds exactly; a slightly larger target leaves room for rounding"
    return found, lower, ""


def _prices(problem: _Problem) -> list[Fraction]:
    return [Fraction(v, problem.price_scale) for row in problem.prices for v in row]


def _program(problem: _Problem, *, slack: bool = False) -> _Program:
    """Target and cap as rows ≤ 0: m ≤ E(x,a) ≤ R*·m for a least mean m of each context, b ≤ M(ã|a) ≤ e^ε·b for each release.

    With `slack` every row is loosened by the last variable.
    """
    size = problem.size
    rows: list[Row] = []
    lifts: dict[int, list[int]] = {}
    following = size * size

    def between(least: int, groups: Iterable[Row], factor: Fraction) -> None:
        for row in groups:
            lifts.setdefault(least, []).append(len(rows))
            rows.append([(least, Fraction(1)), *((v, -c) for v, c in row)])
            rows.append([*row, (least, -factor)])

    if problem.target is not None:
        for block in problem.gains:
            top = max(v for row in block for v in row)
            means = [[(a * size + j, Fraction(v, top)) for j, v in enumerate(row) if v] for a, row in enumerate(block)]
            between(following, means, problem.target)
            following += 1
    if problem.cap is not None:
        for j in range(size):
            between(following, [[(a * size + j, Fraction(1))] for a in range(size)], problem.cap)
            following += 1
    if slack:
        rows = [[*row, (following, Fraction(-1))] for row in rows]
        following += 1
    return _Program(size, following, rows, lifts)


def _solve(program: _Program, prices: Sequence[Fraction], *, slack: bool = False) -> tuple[list[float], list[float]] | None:
    """Solve in floating point: the variables and the multipliers of the rows, or None if there is no solution.

    The prices are of the table's entries, or, with `slack`, of nothing but the last variable, which may then be negative.
    """
    from scipy.sparse import csr_array

    owner = [i for i, row in enumerate(program.rows) for _ in row]
    place = [v for row in program.rows for v, _ in row]
    entries = [float(c) for row in program.rows for _, c in row]
    matrix = csr_array((entries, (owner, place)), shape=(len(program.rows), program.variables)) if program.rows else None
    scale = max((float(p) for p in prices), default=0.0) or 1.0
    costs = [float(p) / scale for p in prices] + [0.0] * (program.variables - len(prices))
    lower = [0.0] * program.variables
    if slack:
        costs[-1], lower[-1] = 1.0, -1.0
    solved = _linear(costs, matrix, [0.0] * len(program.rows), program.size, lower)
    if solved is None:
        return None
    values, duals = solved
    return values, [d * scale for d in duals]


def _linear(
    costs: Sequence[float], matrix: Any, limits: Sequence[float], size: int, lower: Sequence[float]
) -> tuple[list[float], list[float]] | None:
    """Minimise over tables whose rows sum to 1 by the simplex method."""
    from scipy.optimize import linprog
    from scipy.sparse import csr_array

    square = size * size
    sums: Any = csr_array(
        (np.ones(square), (np.repeat(np.arange(size), size), np.arange(square))),
        shape=(size, len(costs)),
    )
    limit: Any = np.array(limits) if matrix is not None else None
    solved: Any = linprog(
        np.array(costs),
        A_ub=matrix,
        b_ub=limit,
        A_eq=sums,
        b_eq=np.ones(size),
        bounds=[(low, None) for low in lower],
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if solved.status != 0:
        return None
    duals = [-float(d) for d in solved.ineqlin.marginals] if matrix is not None else []
    return [float(v) for v in solved.x], duals


def _combination(program: _Program, duals: Sequence[float]) -> dict[int, Fraction]:
    """Σ y_i·row_i for multipliers y ≥ 0 near the given ones for which no auxiliary variable has a negative coefficient."""
    exact = [Fraction(max(0, round(d * DUAL_GRID)), DUAL_GRID) for d in duals]
    total: dict[int, Fraction] = {}

    def add(i: int, amount: Fraction) -> None:
        for v, c in program.rows[i]:
            total[v] = total.get(v, Fraction(0)) + amount * c

    for i, y in enumerate(exact):
        if y:
            add(i, y)
    for v, lifting in program.lifts.items():
        if total.get(v, 0) < 0:
            add(max(lifting, key=lambda i: exact[i]), -total[v])
    return total


def _dual_bound(program: _Program, prices: Sequence[Fraction], duals: Sequence[float]) -> Fraction:
    """No table costs less: Σ_a min_ã of price plus Σ y_i·row_i, for any y ≥ 0."""
    total = _combination(program, duals)
    size = program.size

    def least(extra: Mapping[int, Fraction]) -> Fraction:
        return sum((min(prices[v] + extra.get(v, 0) for v in range(a * size, (a + 1) * size)) for a in range(size)), start=Fraction(0))

    return max(least(total), least({}))


def _why_not(problem: _Problem) -> str:
    """Why no filter meets the target, with a proof in integers where the multipliers give one, and about what would be in reach."""
    if problem.target is None or problem.group_free:
        return "the linear program was not solved"
    loosened = _solve(_program(problem, slack=True), [], slack=True)
    proved = loosened is not None and _refuted(_program(problem), loosened[1])
    known = "proved exactly" if proved else "as far as floating point tells"
    said = f"no filter meets the target, because the utility itself depends on the group ({known})"

    def reached(excess: Fraction, target: Fraction = problem.target) -> bool:
        return _solve(_program(replace(problem, target=target * (1 + excess))), _prices(problem)) is not None

    low, high = Fraction(0), Fraction(1)
    while not reached(high):
        if high > MOST_EXCESS:
            return f"{said}; change the utility or the policy, or loosen the cap"
        low, high = high, high * 2
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if reached(middle) else (middle, high)
    reach = float(problem.target * (1 + high))
    return f"{said}; a target ratio of about {reach:.6g} (log {log(reach):.6g}) is within reach"


def _refuted(program: _Program, duals: Sequence[float]) -> bool:
    """Whether the multipliers prove that no table meets all rows: Σ y_i·row_i is positive at every table."""
    total = _combination(program, duals)
    size = program.size
    return sum((min(total.get(v, Fraction(0)) for v in range(a * size, (a + 1) * size)) for a in range(size)), start=Fraction(0)) > 0


def _deepest(problem: _Problem) -> list[list[int]] | None:
    """Among all tables the one that is farthest inside the constraints, rounded to the grid."""
    solved = _solve(_program(problem, slack=True), [], slack=True)
    return None if solved is None else _rounded(solved[0][: problem.size**2], problem.size)


def _rounded(values: Sequence[float], size: int) -> list[list[int]]:
    """A table on the grid, rows summing to it exactly; entries that are zero but for noise are zero."""
    rows = []
    for a in range(size):
        row = [max(0, round(v * GRID)) if v > TIGHT else 0 for v in values[a * size : (a + 1) * size]]
        row[row.index(max(row))] += GRID - sum(row)
        rows.append(row)
    return rows


def _repaired(problem: _Problem, values: Sequence[float]) -> Mechanism | None:
    """Round, then mix with a filter inside the constraints by the least amount on the grid for which all of them hold.

    What is mixed in is the average row for everybody; where the utility depends on the group that may be outside, and the table with the
    greatest slack is taken. The constraints, and T3, are convex along the mixture and hold at its end, so that bisection finds the least.
    """
    size = problem.size
    rows = _rounded(values, size)
    inside: list[tuple[Rows, int]] = [([[sum(column) for column in zip(*rows, strict=True)]] * size, GRID * size)]
    if not problem.group_free:
        deepest = _deepest(problem)
        inside += [(deepest, GRID)] if deepest is not None else []
    found: list[tuple[Fraction, Mechanism]] = []
    for table, bottom in inside:

        def mixed(step: int, table: Rows = table, bottom: int = bottom) -> tuple[list[list[int]], int]:
            part = bottom // GRID
            mixture = [
                [(GRID - step) * part * v + step * w for v, w in zip(row, other, strict=True)]
                for row, other in zip(rows, table, strict=True)
            ]
            return mixture, GRID * bottom

        step = _least_step(lambda step: problem.holds(*mixed(step)))
        if step is not None:
            answer = mixed(step)
            found.append((problem.cost(*answer), problem.mechanism(*answer)))
    return min(found, key=lambda entry: entry[0])[1] if found else None


def _least_step(holds: Callable[[int], bool]) -> int | None:
    """The least step from 0 to `GRID` from which on a condition holds; None if it does not hold at the end."""
    if holds(0):
        return 0
    low, high = 0, 1
    while not holds(high):
        if high == GRID:
            return None
        low, high = high, min(2 * high, GRID)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def _vertex(problem: _Problem, program: _Program, values: Sequence[float], bits: int) -> Mechanism | None:
    """Solve the constraints that are active at the answer exactly; None where that is hard, long, or does not hold."""
    size = problem.size
    unknowns = [v for v, value in enumerate(values) if value > TIGHT]
    if len(unknowns) > MAX_UNKNOWNS:
        return None
    place = {v: i for i, v in enumerate(unknowns)}
    tight = []
    for row in program.rows:
        terms = [(place[v], c) for v, c in row if v in place]
        if terms and abs(sum(float(c) * values[unknowns[i]] for i, c in terms)) < TIGHT:
            tight.append((terms, Fraction(0)))
    sums = [([(place[v], Fraction(1)) for v in range(a * size, (a + 1) * size) if v in place], Fraction(1)) for a in range(size)]
    solution = _solved_exactly([*sums, *tight], len(unknowns))
    if solution is None:
        return None
    flat = [solution[place[v]] if v in place else Fraction(0) for v in range(size * size)]
    if any(v < 0 for v in flat):
        return None
    whole, bottom = common_denominator([(v.numerator, v.denominator) for v in flat])
    rows = [whole[a * size : (a + 1) * size] for a in range(size)]
    return problem.mechanism(rows, bottom) if bottom.bit_length() <= bits and problem.holds(rows, bottom) else None


def _solved_exactly(equations: Iterable[tuple[Row, Fraction]], count: int) -> list[Fraction] | None:
    """The one solution of linear equations, by elimination in integers; None if there is none, or more than one, or it is very long."""
    pivots: dict[int, list[int]] = {}
    for terms, value in equations:
        whole, _ = common_denominator([*((c.numerator, c.denominator) for _, c in terms), (value.numerator, value.denominator)])
        row = [0] * (count + 1)
        for (i, _), c in zip(terms, whole, strict=False):
            row[i] += c
        row[count] = whole[-1]
        for i, pivot in pivots.items():
            if row[i]:
                row = _eliminated(row, pivot, i)
        first = next((i for i in range(count) if row[i]), None)
        if first is None:
            if row[count]:
                return None
            continue
        for i, pivot in pivots.items():
            if pivot[first]:
                pivots[i] = _eliminated(pivot, row, first)
        pivots[first] = row
        if max(map(abs, row)).bit_length() > 4 * MOST_BITS:
            return None
    if len(pivots) < count:
        return None
    return [Fraction(pivots[i][count], pivots[i][i]) for i in range(count)]


def _eliminated(row: list[int], pivot: list[int], at: int) -> list[int]:
    """Subtract a multiple of the pivot row so that the entry vanishes; the result is divided by what is common."""
    common = gcd(row[at], pivot[at])
    up, down = pivot[at] // common, row[at] // common
    result = [up * v - down * w for v, w in zip(row, pivot, strict=True)]
    divisor = gcd(*result)
    return [v // divisor for v in result] if divisor > 1 else result


# Without a policy: one k for all ordered pairs


def _searched_over_k(problem: _Problem, level: Fraction, target: Fraction) -> list[tuple[Mechanism, str]]:
    """The best filters that one k certifies. At the ends of its range, R* and (1 − t·R*)/(1 − t), k is a cap on ε."""
    least = (1 - level * target) / (1 - level)
    widest = max(target, 1 / least)
    capped = replace(problem, target=None, level=None, cap=widest if problem.cap is None else min(widest, problem.cap))
    found, _, _ = _searched(capped)
    if target == 1:
        return found
    if problem.size > MAX_MODEL_FREE:
        raise InputError(
            f"a design without a policy accepts up to {MAX_MODEL_FREE} groups that differ in frequency or distortion, not {problem.size}; "
            "with equal frequencies and the default distortion there is no such limit"
        )
    tables = _tables_over_k(problem, level, target, least)
    for values in tables:
        repaired = _repaired(problem, values)
        if repaired is not None:
            found.append((repaired, "linear program for one common k, rounded and mixed until exact"))
    return found


def _tables_over_k(problem: _Problem, level: Fraction, target: Fraction, least: Fraction) -> list[list[float]]:
    """Grid, then golden section around its best point; the best table of each."""
    low, high = float(least), float(target)
    known: dict[float, tuple[float, list[float]]] = {}

    def value(k: float) -> float:
        if k not in known:
            known[k] = _solve_for_k(problem, float(level), float(target), k)
        return known[k][0]

    inside = [low * (high / low) ** (i / (GRID_POINTS + 1)) for i in range(1, GRID_POINTS + 1)]
    points = sorted({*inside, *([1.0] if low < 1 < high else [])})
    best = min(range(len(points)), key=lambda i: value(points[i]))
    tables = [known[points[best]][1]]
    left, right = ([low, *points][best], [*points, high][best + 1])
    ratio = (sqrt(5) - 1) / 2
    inner, outer = right - ratio * (right - left), left + ratio * (right - left)
    for _ in range(GOLDEN_STEPS):
        if value(inner) <= value(outer):
            right, outer = outer, inner
            inner = right - ratio * (right - left)
        else:
            left, inner = inner, outer
            outer = left + ratio * (right - left)
    finest = min(known, key=value)
    tables.append(known[finest][1])
    return [table for table in tables if table]


def _solve_for_k(problem: _Problem, level: float, target: float, k: float) -> tuple[float, list[float]]:
    """The least distortion in floating point among filters that k certifies, and the table; Σ_ã s ≤ t·(R* − k), s ≥ M(ã|a) − k·M(ã|a')."""
    from scipy.sparse import coo_array

    size = problem.size
    square, pairs = size * size, size * (size - 1)
    first, second = (np.array(side) for side in zip(*((a, b) for a in range(size) for b in range(size) if a != b), strict=True))
    column = np.arange(size)
    count = pairs * size
    slack = square + np.arange(count)
    excess = np.arange(count)
    owner = [excess, excess, excess, count + np.repeat(np.arange(pairs), size)]
    place = [(first[:, None] * size + column).ravel(), (second[:, None] * size + column).ravel(), slack, slack]
    entries = [np.ones(count), np.full(count, -k), np.full(count, -1.0), np.ones(count)]
    limits = [0.0] * count + [level * (target - k)] * pairs
    variables = square + count
    if problem.cap is not None:
        cells = np.arange(square)
        floor = variables + cells % size
        start = count + pairs
        owner += [start + cells, start + cells, start + square + cells, start + square + cells]
        place += [floor, cells, cells, floor]
        entries += [np.ones(square), np.full(square, -1.0), np.ones(square), np.full(square, -float(problem.cap))]
        limits += [0.0] * (2 * square)
        variables += size
    matrix = coo_array((np.concatenate(entries), (np.concatenate(owner), np.concatenate(place))), shape=(len(limits), variables)).tocsr()
    prices = [float(p) for p in _prices(problem)]
    scale = max(prices) or 1.0
    solved = _linear([p / scale for p in prices] + [0.0] * (variables - square), matrix, limits, size, [0.0] * variables)
    if solved is None:
        return inf, []
    values = solved[0][:square]
    return sum(p * v for p, v in zip(prices, values, strict=True)), values
