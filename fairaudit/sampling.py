"""Intervals for fairness ratios of a population from which a table was drawn, at a stated confidence, for finite samples.

A **cell** is a set of independent draws of a number in a known range, all with the same mean. Expected utilities are **forms**, weighted
sums of cell means: a single cell for a plain table, the filters' probabilities for a policy behind filters, P(x|a) for a group mean. A
**block** is a set of forms that are compared with each other, a context for the local ratio. The ratio R is the greatest quotient of two
forms of one block.

Every cell gets a lower and an upper end, each wrong with at most a stated probability, its level. Let K be the number of cells with
draws, s the greatest number of them in the two forms of one compared pair, 1 − α the confidence, and [lo, hi] the ends.

* *Upper end.* Let the pair attain R (it is unknown, but does not depend on the draws) and let w, v be its weights. Each cell needs one
  end only: hi where w > R·v, lo where w < R·v. If these s ends hold, the greatest quotient of this pair over the box is at least R. So
  s ends of level β suffice, however many cells there are.
* *Lower end.* The pair that gives the greatest lower end does depend on the draws, so all 2K ends, of level β', have to hold. With
  β' ≤ β the s ends above are among them.
* *Both* hold with probability at least 1 − s·β − (2K − s)·β' by the union bound, which asks for no independence between cells. With
  independent cells (1 − β − β')^s·(1 − 2β')^(K − s) is enough.

The **product region**, for independent cells and forms of a single cell, replaces the corners of the box. If u and v are the tail
probabilities of the two cells of a pair at their true means, then u and v are independent and stochastically at least uniform, and
P(u ≤ b or v ≤ b or u·v ≤ c) ≤ 2b + f, f = c·log(c/b²) − c + b² (for b² ≤ c ≤ b). With (b, c) for the pair that attains R and (b', c') for
all M ordered pairs, the error is at most 2b + (2K − 2)·b' + f + (M − 1)·f'.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, lru_cache
from heapq import heapify, heapreplace, nlargest, nsmallest
from itertools import permutations, product
from math import ceil, comb, exp, floor, inf, isqrt, lcm, log, log1p, pi, sqrt
from operator import mul
from statistics import NormalDist
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fairaudit.columns import Label, names
from fairaudit.exact import (
    InputError,
    approximate,
    compare_log,
    exp_enclosure,
    log_enclosure,
    log_fixed,
    nearest,
    option_value,
    quotient,
    rational,
    rational_text,
    shown,
)
from fairaudit.fairness import Ratio, Witness
from fairaudit.law import MAX_DRAWS, Law, Units
from fairaudit.limits import ALONE, one_limit, without_bare_limits
from fairaudit.mechanism import Mechanism
from fairaudit.policy import Policy
from fairaudit.utility import Utility, UtilityTable

__all__ = [
    "Cell",
    "Comparison",
    "DifferenceInterval",
    "FilterTest",
    "Interval",
    "NoiseFloor",
    "Planning",
    "cell_ends",
    "default_region",
    "difference_interval",
    "drivers",
    "further_draws",
    "global_comparison",
    "greatest_ratio",
    "least_ratio",
    "local_comparison",
    "noise_floor",
    "plan",
    "policy_comparison",
    "ratio_interval",
    "sampled_population_interval",
    "tail_bound",
    "test_filter",
    "verdict",
]

Method = Literal["hoeffding-kl", "empirical-bernstein", "intersection"]
Region = Literal["box", "product"]
Side = Literal["both", "lower", "upper"]
Form = tuple[tuple[int, Fraction], ...]
Ends = tuple[Fraction, Fraction]
AllEnds = Sequence[tuple[Any, Any]] | Mapping[int, tuple[Any, Any]]  # by cell
Extended = Fraction | float
Estimand = Literal["mean over rows", "mean over units"]
Floats = NDArray[np.float64]

GREATEST_PLANNED = 10**300
EXACT_DRAWS = 5_000
BITS = 128
ONE = 1 << BITS
WORK = 192
DIGITS = 7
PI_BELOW = Fraction(333, 106)
SIDAK_CELLS = 2_000
GUARD = Fraction(4, 5)
SLACK = 0.02
MAX_KNOTS = 400
GRID = 60
TIGHT_CELLS = 500
DECISIVE_CELLS = 100
FOREMOST = 30
NARROWED = 3

OWN_RANGE = "whatever could have been drawn in a cell has a utility between 0 and the greatest that a decision has there"
DRAWS = (
    "the draws within a cell are independent, each with the law of the cell, and how many there are does not depend on how they came out"
)
CELLS = "the draws of different cells are independent of each other"
DECLARED = "utility, method and confidence were chosen without looking at the draws"
ONE_ROW = "a sampling unit can have no more than one row in a cell, as is the case here"
UNITS = (
    "different sampling units are independent, how many there are does not depend on how they came out, and the mean over the rows of a "
    "unit in a cell has the same expectation for all units: it is estimated by the mean over units, which is not the mean over rows"
)
GIVEN_TRUTH = (
    "given the true labels, the decisions are independent, each positive with the rate of its cell, and how many there are of a true label "
    "does not depend on how they came out"
)
DECLARED_POSITIVE = "positive labels, method and confidence were chosen without looking at the draws"
POOLED = "the contexts of each group were drawn from its population, not set by design"
POPULATION = "the contexts of each group are distributed as in the stated population"


@dataclass(frozen=True)
class Cell:
    """Independent draws of a number between `low` and `high`, all with the same mean.

    Attributes
    ----------
    draws : int
        How many.
    total : Fraction
        Their sum.
    squares : Fraction or None
        The sum of their squares, for the empirical Bernstein method.
    low, high : Fraction
        The known range of one draw.
    binary : bool
        Whether a draw takes no other values than `low` and `high`.
    label : tuple
        What to call it.

    Examples
    --------
    >>> Cell(10, Fraction(3), None, Fraction(0), Fraction(1), True).mean
    Fraction(3, 10)
    """

    draws: int
    total: Fraction
    squares: Fraction | None
    low: Fraction
    high: Fraction
    binary: bool
    label: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what no draws can give."""
        low, low_bottom = self.low.numerator, self.low.denominator
        high, high_bottom = self.high.numerator, self.high.denominator
        total, bottom = self.total.numerator, self.total.denominator
        above, below = total * low_bottom - self.draws * low * bottom, self.draws * high * bottom - total * high_bottom
        width = high * low_bottom - low * high_bottom
        if self.draws < 0 or low < 0 or width < 0 or above < 0 or below < 0:
            raise InputError(f"{self.draws} draws between {self.low} and {self.high} cannot sum to {self.total}")
        if self.binary and width and above * high_bottom % (bottom * width):
            raise InputError(f"{self.draws} draws, each {self.low} or {self.high}, cannot sum to {self.total}")

    @property
    def informative(self) -> bool:
        """Whether its mean is estimated: it has draws, and they could have come out differently."""
        return self.draws > 0 and self.high > self.low

    @property
    def mean(self) -> Fraction:
        """Mean of the draws."""
        return Fraction(self.total.numerator, self.total.denominator * self.draws)

    @property
    def successes(self) -> Fraction:
        """The sum on the scale on which the range is [0, 1]; for binary draws the number of high ones."""
        return (self.total - self.draws * self.low) / (self.high - self.low)

    @property
    def share(self) -> float:
        """The mean on that scale, correctly rounded."""
        (low, under), (high, over), (total, bottom) = (v.as_integer_ratio() for v in (self.low, self.high, self.total))
        return (total * under - self.draws * low * bottom) * over / (bottom * (high * under - low * over) * self.draws)


@dataclass(frozen=True)
class Comparison:
    """Cells, and the blocks of forms in their means that are compared.

    Attributes
    ----------
    cells : tuple of Cell
        The cells.
    blocks : tuple of tuple of forms
        A form is a tuple of (cell index, weight > 0).
    labels : tuple
        For each block its context and the groups of its forms, as mappings from column to label (the context is None over all contexts).
    dependent : bool
        Whether cells are known to share draws or sampling units, so that they cannot be declared independent.
    assumptions, notes : tuple of str
        What the reader must accept, and what was noticed.
    limits : pair of Fraction or None
        The declared range of g.
    units : Units or None
        The sampling units of the log.
    """

    cells: tuple[Cell, ...]
    blocks: tuple[tuple[Form, ...], ...]
    labels: tuple[tuple[dict[str, str] | None, tuple[dict[str, str], ...]], ...] = ()
    dependent: bool = False
    assumptions: tuple[str, ...] = (DRAWS, DECLARED)
    notes: tuple[str, ...] = ()
    limits: Ends | None = None
    units: Units | None = None

    @property
    def estimand(self) -> Estimand:
        """What the means of the cells are: over rows, or, where units have several rows in a cell, over units of the mean of each."""
        return "mean over units" if self.units and self.units.repeated else "mean over rows"

    @cached_property
    def of_units(self) -> Ratio | None:
        """The ratio of the sample as the mean over units, with its witness; None where a unit has one row in a cell."""
        if self.estimand == "mean over rows":
            return None
        best: tuple[Extended, int, int, int] | None = None
        for number, block in enumerate(self.blocks):
            means = [self.cells[i].mean for ((i, _),) in block]
            low, high = means.index(min(means)), means.index(max(means))
            if means[low] == means[high]:
                found: tuple[Extended, int, int] = Fraction(1), 0, 1
            elif means[low]:
                found = means[high] / means[low], high, low
            else:
                found = inf, next(i for i, mean in enumerate(means) if mean), low
            if best is None or found[0] > best[0]:
                best = found[0], number, *found[1:]
        if best is None:
            return None
        ratio, *place = best
        witness = _witness(self, place)
        return None if witness is None else Ratio(ratio, witness)

    @cached_property
    def used(self) -> tuple[int, ...]:
        """The informative cells of blocks with at least two forms, in order."""
        found = {i for block in self.blocks if len(block) > 1 for form in block for i, _ in form}
        return tuple(i for i in sorted(found) if self.cells[i].informative)

    @cached_property
    def span(self) -> int:
        """s, the greatest number of informative cells in the two forms of a compared pair."""
        used = set(self.used)
        best = 0
        for block in self.blocks:
            supports = {frozenset(i for i, _ in form if i in used) for form in block} if len(block) > 1 else set()
            sizes = sorted((len(support) for support in supports), reverse=True)
            if len(supports) == 1 or sizes[:1] == [1]:
                best = max([best, sum(sizes[:2])])
            elif sum(sizes[:2]) > best:
                best = max([best, *(len(p | q) for p, q in permutations(supports, 2))])
        return best

    @cached_property
    def single(self) -> bool:
        """Whether every form is one cell."""
        return all(len(form) == 1 and form[0][1] == 1 for block in self.blocks for form in block)

    @property
    def pairs(self) -> int:
        """M, the number of ordered pairs that are compared."""
        return sum(len(block) * (len(block) - 1) for block in self.blocks)


@dataclass(frozen=True)
class Interval:
    """A confidence interval of a fairness ratio.

    Attributes
    ----------
    lower : Fraction
        At least 1.
    upper : Fraction or float
        Possibly `math.inf`.
    estimate : Fraction or float or None
        The ratio of the sample itself, of the means that are estimated; None if a cell has no draws.
    confidence : Fraction
        The probability, before the draws, that both ends are right (or the one that was asked for).
    region : {"box", "product"}
        How the ends of the cells are joined.
    methods : tuple of str
        How the ends of the cells were found.
    assumptions : tuple of str
        What the reader must accept.
    evidence : dict
        What a checker needs, as docs/certificate-samples.md describes it.
    pairs : pair of Witness or None, optional
        Of a stream, the pairs that drive the lower and the upper end; `drivers` finds those of others.
    estimand : {"mean over rows", "mean over units"}
        Of what the ratio is bounded: with sampling units of several rows in a cell, of the means over units.
    of_units : Ratio or None
        Then the ratio of the sample itself as the mean over units, with its witness.
    """

    lower: Fraction
    upper: Extended
    estimate: Extended | None
    confidence: Fraction
    region: Region
    methods: tuple[str, ...]
    assumptions: tuple[str, ...]
    evidence: dict[str, Any]
    pairs: tuple[Witness | None, Witness | None] = (None, None)
    estimand: Estimand = "mean over rows"
    of_units: Ratio | None = None

    @cached_property
    def log(self) -> tuple[Decimal, Decimal]:
        """Both ends on the scale of L, rounded outwards."""
        return Decimal(log_enclosure(_pair(self.lower))[0]), Decimal(log_enclosure(_pair(self.upper))[1])


@dataclass(frozen=True)
class FilterTest:
    """What end-to-end draws say about a claimed ε (T11)."""

    refuted: bool
    interval: Interval
    exp_epsilon: Extended
    sentence: str


@dataclass(frozen=True)
class NoiseFloor:
    """An effect beside the ratio under edits that should not matter; both intervals hold together at the stated confidence."""

    effect: Interval
    placebo: Interval
    rises: bool
    sentence: str


@dataclass(frozen=True)
class Planning:
    """An estimate for planning, not a guarantee.

    Attributes
    ----------
    draws : tuple of int or None
        Draws per cell (in all for `plan`, further ones for `further_draws`); None if no number up to the limit would do.
    decides : {"within", "exceeds"} or None
        Which verdict they are expected to give; None also where nothing is expected, because what was measured may be chance alone.
    sentence : str
        The same in words.
    total : int or None
        How many further draws that is, or, of a log with sampling units, how many further units.
    total_if_equal : int or None
        How many it would be if all compared groups were equal, where the draws do not exclude that.
    """

    draws: tuple[int, ...] | None
    decides: Literal["within", "exceeds"] | None
    sentence: str
    total: int | None = None
    total_if_equal: int | None = None


# What is compared


def local_comparison(law: Law, utility: UtilityTable, limits: tuple[Any, Any] | None = None) -> Comparison:
    """Set up the local ratio of a plain table of counts.

    The draws of a law with sampling units (`Law.from_log` with ``unit=``) are its units: in each cell a unit counts once, with the mean
    of the utility over its rows there, so that dependence inside a unit is allowed for. What is estimated is then the mean over units,
    whatever the number of their rows. Units with rows in several cells make the cells dependent.

    Parameters
    ----------
    law : Law
        Counts, all of them integers.
    utility : UtilityTable
        The utility on it.
    limits : pair of numbers, optional
        The range of g over everything that could be drawn, seen or not; by default from 0 to the greatest value that g has here.

    Returns
    -------
    Comparison
        One cell and one form for each (x,a) that is compared; a block for each context.

    Raises
    ------
    InputError
        If the law holds probabilities or fractional counts: they carry no sample size.

    Examples
    --------
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> [cell.mean for cell in local_comparison(law, Utility({"yes": 1}).on(law)).cells]
    [Fraction(3, 4), Fraction(1, 2)]
    >>> law = Law.from_log({"a": list("ffmm"), "u": ["yes", "no", "no", "no"], "run": [1, 1, 1, 2]}, decision="u", group="a", unit="run")
    >>> [(cell.draws, cell.mean) for cell in local_comparison(law, Utility({"yes": 1}).on(law)).cells]
    [(1, Fraction(1, 2)), (2, Fraction(0, 1))]
    """
    scope = _Range(utility, limits)
    cells = scope.cells(law.compared)
    blocks: list[tuple[Form, ...]] = []
    labels = []
    held = law.cell_group.tolist()
    names_of = {a: law.group_label(a) for a in {*held}}
    first = 0
    for start, end in zip(law.starts[:-1].tolist(), law.starts[1:].tolist(), strict=True):
        if end - start < 2:
            continue
        blocks.append(tuple(_unit_form(i) for i in range(first, first + end - start)))
        first += end - start
        labels.append((law.context_label(int(law.cell_context[start])), tuple(names_of[a] for a in held[start:end])))
    drawn = (UNITS,) if law.units and law.units.repeated else (DRAWS, *((ONE_ROW,) if law.units else ()))
    assumptions = (*drawn, scope.assumption, DECLARED, *law.assumptions)
    notes = _unit_notes(law.units, cells) if law.units else ()
    dependent = bool(law.units and law.units.spanning)
    return Comparison(tuple(cells), tuple(blocks), tuple(labels), dependent, assumptions, notes, units=law.units)


def global_comparison(
    law: Law, utility: UtilityTable, population: Mapping[tuple[Label, Label], Any] | None = None, limits: tuple[Any, Any] | None = None
) -> Comparison:
    """Set up the global ratio of a plain table of counts.

    Parameters
    ----------
    law : Law
        Counts, all of them integers.
    utility : UtilityTable
        The utility on it.
    population : mapping from (context, group) to number, optional
        P(x,a) up to a common factor, exact. Without one the contexts of each group count as drawn from its population: then the rows
        of a group are independent draws of (x,u) given a, their utilities have the mean Ē(a), and a group is one cell.
    limits : pair of numbers, optional
        As for `local_comparison`.

    Returns
    -------
    Comparison
        A single block with a form for each group.

    Raises
    ------
    InputError
        As for `local_comparison`; if the population names a cell without counts; or if a sampling unit has several rows with one group,
        which are then no independent draws.
    """
    if law.units and not law.units.once_per_group:
        raise InputError(
            f"units of {_column_names(law.units)} have several rows with the same group, which are no independent draws of it; "
            "an interval for the global ratio needs one row for each unit and group"
        )
    scope = _Range(utility, limits)
    if population is None:
        groups = law.global_groups
        pooled = scope.pooled(groups)
        labels = ((None, tuple(law.group_label(a) for a in groups)),)
        assumptions = (DRAWS, POOLED, scope.assumption, DECLARED, *law.assumptions)
        forms = (tuple(_unit_form(i) for i in range(len(pooled))),)
        return Comparison(tuple(pooled), forms, labels, bool(law.units), assumptions, units=law.units)
    cells = scope.cells(np.ones(len(law.weights), dtype=np.bool_))
    place = {cell.label: i for i, cell in enumerate(cells)}
    weights: dict[Label, list[tuple[int, Fraction]]] = {a: [] for a in law.groups}
    for key, mass in _masses(population).items():
        if not mass:
            continue
        if key not in place:
            raise InputError(f"the population gives mass to {shown(key)}, for which there are no counts")
        weights[key[1]].append((place[key], mass))
    present = [(law.group_label(k), a) for k, a in enumerate(law.groups) if weights[a]]
    block = tuple(_normalised(weights[a]) for _, a in present)
    labels = ((None, tuple(label for label, _ in present)),)
    assumptions = (DRAWS, POPULATION, scope.assumption, DECLARED, *law.assumptions)
    return Comparison(tuple(cells), (block,), labels, bool(law.units), assumptions, units=law.units)


def policy_comparison(
    policy: Policy,
    utility: Utility,
    group: Mechanism,
    context: Mechanism | None = None,
    population: Mapping[tuple[Label, Label], Any] | None = None,
    *,
    local: bool = True,
    limits: tuple[Any, Any] | None = None,
) -> Comparison:
    """Set up a ratio of the law that a sampled policy induces behind filters.

    Parameters
    ----------
    policy : Policy
        From counts, all of them integers. Pairs (x̃,ã) without draws are allowed: their means are only known to lie in the range of g.
    utility : Utility
        The utility over true contexts and groups.
    group : Mechanism
        The filter of the group; its inputs are the true groups.
    context : Mechanism, optional
        The filter of the context; without one contexts are released as they are.
    population : mapping from (context, group) to number, optional
        P(x,a) up to a common factor, for the global ratio; without one contexts weigh equally.
    local : bool
        Whether to compare groups within each context, or their means over contexts.
    limits : pair of numbers, optional
        As for `local_comparison`.

    Returns
    -------
    Comparison
        One cell for each (x̃,ã) when g depends on the decision alone, else one for each (x,x̃,ã), or (x,x̃,ã,a) when g depends on the
        group; these share draws and are marked as dependent.

    Raises
    ------
    InputError
        If the policy was not sampled, or the utility of a decision is not given.
    """
    law = utility.over(policy.law)
    policy = replace(policy, law=law)
    declared = None if limits is None else _limits(limits)
    contexts = law.contexts if context is None else context.inputs
    made, forms, shared = _policy_forms(policy, utility, group, context, declared)
    group_names, context_names = law.columns.group, law.columns.context
    a_labels = tuple(dict(zip(group_names, a, strict=True)) for a in group.inputs)
    said = _range_said(*(declared or (min(cell.low for cell in made), max(cell.high for cell in made))))
    assumptions = (DRAWS, said if declared or utility.entries is None else OWN_RANGE, DECLARED, *law.assumptions)
    if local:
        blocks = tuple(tuple(forms[x, a] for a in group.inputs) for x in contexts)
        places = tuple((dict(zip(context_names, x, strict=True)), a_labels) for x in contexts)
        return Comparison(tuple(made), blocks, places, shared, assumptions)
    masses = _masses(population) if population is not None else {(x, a): Fraction(1) for x in contexts for a in group.inputs}
    for key in masses:
        if key not in forms:
            raise InputError(f"the population names {shown(key)}, which is not a true context and group of the filters")
    means = []
    for a, label in zip(group.inputs, a_labels, strict=True):
        weights: dict[int, Fraction] = {}
        for x in contexts:
            for i, w in forms[x, a]:
                weights[i] = weights.get(i, Fraction(0)) + w * masses.get((x, a), Fraction(0))
        listed = [(i, w) for i, w in weights.items() if w]
        if listed:
            means.append((label, _normalised(listed)))
    labels = ((None, tuple(label for label, _ in means)),)
    block = tuple(form for _, form in means)
    return Comparison(tuple(made), (block,), labels, shared, (*assumptions, POPULATION))


def _counts(law: Law, cell: int) -> list[int]:
    if law.kind != "counts":
        raise InputError("probabilities carry no sample size; an interval needs counts, or a log")
    row: list[int] = law.weights[cell].tolist()
    if law.scale != 1:
        for u, w in zip(law.decisions, row, strict=True):
            if w % law.scale:
                where = {**law.context_label(int(law.cell_context[cell])), **law.group_label(int(law.cell_group[cell]))}
                raise InputError(
                    f"the count of {shown(u)} at {where} is not whole; an interval needs whole counts, because a weighted count carries "
                    "no sample size"
                )
        row = [w // law.scale for w in row]
    if sum(row) > MAX_DRAWS:
        raise InputError(f"{shown(str(sum(row)))} decisions in one cell are not accepted as draws; an interval needs at most 10^18")
    return row


class _Range:
    """A utility with the range that a draw of it can have."""

    def __init__(self, utility: UtilityTable, limits: tuple[Any, Any] | None) -> None:
        self.utility = utility
        self.declared = None if limits is None else _limits(limits)
        own = self.declared is None and not utility.by_decision
        self.assumption = OWN_RANGE if own else _range_said(*(self.declared or (Fraction(0), utility.gamma)))
        if utility.given is not None and self.declared is None:
            self.declared = Fraction(0), utility.gamma
        self.common = _scaled(_values(utility, 0), self.declared) if utility.by_decision and utility.given is None else None

    def cells(self, chosen: NDArray[np.bool_]) -> list[Cell]:
        """The cells of a law, those that are chosen."""
        law, units = self.utility.law, self.utility.law.units
        at = np.flatnonzero(chosen)
        places = zip(law.cell_context[at].tolist(), law.cell_group[at].tolist(), strict=True)
        labels = [(law.contexts[x], law.groups[a]) for x, a in places]
        if self.common and not (units and units.repeated) and _summable(law, self.common):
            return self._summed(law.weights[at], labels)
        return [self._cell(i, label) for i, label in zip(at.tolist(), labels, strict=True)]

    def pooled(self, groups: Sequence[int]) -> list[Cell]:
        """A cell for each group, of its rows in all contexts."""
        law = self.utility.law
        labels = [(law.groups[a],) for a in groups]
        if self.common and _summable(law, self.common, over_contexts=True):
            sums = np.zeros((len(law.groups), law.weights.shape[1]), dtype=np.int64)
            np.add.at(sums, law.cell_group, law.weights)
            return self._summed(sums[list(groups)], labels)
        cells = self.cells(np.ones(len(law.weights), dtype=np.bool_))
        return [
            _pool([cells[i] for i in np.flatnonzero(law.cell_group == a).tolist()], label) for a, label in zip(groups, labels, strict=True)
        ]

    def _summed(self, weights: NDArray[np.int64], labels: Sequence[tuple[Any, ...]]) -> list[Cell]:
        values = self.common
        assert values is not None  # noqa: S101
        bottom, low, high, binary = values.bottom, values.low, values.high, values.binary
        return [
            Cell(n, Fraction(total, bottom), Fraction(squares, bottom * bottom), low, high, binary, label)
            for (n, total, squares), label in zip((weights @ np.array([[1, v, v * v] for v in values.whole])).tolist(), labels, strict=True)
        ]

    def _cell(self, index: int, label: tuple[Any, ...]) -> Cell:
        row = _counts(self.utility.law, index)
        values = self.common or _scaled(_values(self.utility, index), self.declared)
        cell = _cell(row, values, label)
        units = self.utility.law.units
        if units and units.repeated:
            cell = _by_unit(cell, units.profiles[index], values.values)
        return cell


def _summable(law: Law, values: _Scaled, *, over_contexts: bool = False) -> bool:
    """Whether sums over the draws of a cell, or of all, fit into 64 bits with their squares, and no value is outside the range."""
    if law.kind != "counts" or law.scale != 1 or law.weights.dtype != np.int64 or values.outside:
        return False
    most = 2 * float(law.weights.sum(dtype=np.float64)) if over_contexts else int(law.weights.max()) * law.weights.shape[1]
    return bool(most <= MAX_DRAWS and int(most) * max(1, max(values.whole) ** 2) < 2**63)


def _range_said(low: Fraction, high: Fraction) -> str:
    return f"whatever could have been drawn has a utility between {_text(low)} and {_text(high)}"


def _limits(limits: tuple[Any, Any]) -> tuple[Fraction, Fraction]:
    low, high = (Fraction(*option_value(v)) for v in limits)
    if not 0 <= low <= high:
        raise InputError(f"a utility between {low} and {high} is not accepted; the limits are at least 0, the lower one first")
    return low, high


def _values(utility: UtilityTable, cell: int) -> list[Fraction]:
    """Values of g in a cell; one that was not given (nothing was drawn there) counts as the greatest."""
    row = [Fraction(v, utility.scale) for v in utility.row(cell)]
    if utility.given is None:
        return row
    return [v if g else utility.gamma for v, g in zip(row, utility.given[cell].tolist(), strict=True)]


@dataclass(frozen=True)
class _Scaled:
    """Values of g in a cell, also as integers over one denominator; their range, which lie outside it, whether they are its ends."""

    values: tuple[Fraction, ...]
    whole: tuple[int, ...]
    bottom: int
    low: Fraction
    high: Fraction
    outside: tuple[int, ...]
    binary: bool


def _scaled(values: Sequence[Fraction], declared: tuple[Fraction, Fraction] | None) -> _Scaled:
    low, high = declared or (Fraction(0), max(values))
    bottom = lcm(*(v.denominator for v in values))
    whole = tuple(v.numerator * (bottom // v.denominator) for v in values)
    outside = tuple(i for i, v in enumerate(values) if not low <= v <= high)
    # Where a range was declared, what could have been drawn is only known to lie in it; that two values were seen does not make them all.
    return _Scaled(tuple(values), whole, bottom, low, high, outside, declared is None and {*values} <= {low, high})


def _cell(row: Sequence[int], values: _Scaled, label: tuple[Any, ...]) -> Cell:
    for i in values.outside:
        if row[i]:
            raise InputError(f"a utility of {values.values[i]} was drawn, outside the declared limits {values.low} and {values.high}")
    total = Fraction(sum(map(mul, row, values.whole)), values.bottom)
    squares = Fraction(sum(w * v * v for w, v in zip(row, values.whole, strict=True)), values.bottom**2)
    return Cell(sum(row), total, squares, values.low, values.high, values.binary, label)


def _column_names(units: Units) -> str:
    listed = ", ".join(map(shown, units.columns))
    return f"column{'s' if len(units.columns) > 1 else ''} {listed}"


def _unit_notes(units: Units, cells: Sequence[Cell]) -> tuple[str, ...]:
    drawn = f"{sum(cell.draws for cell in cells)} draws, one for each unit of {_column_names(units)} in each cell"
    if not units.spanning:
        return (drawn,)
    return drawn, f"{units.spanning} of {units.total} units have rows in several cells, so cells are not independent"


def _by_unit(cell: Cell, profiles: Sequence[tuple[int, tuple[int, ...]]], values: Sequence[Fraction]) -> Cell:
    """The same cell with the mean over the rows of a unit as one draw."""
    draws, total, squares = 0, Fraction(0), Fraction(0)
    for n, rows in profiles:
        mean = sum((w * v for w, v in zip(rows, values, strict=True)), Fraction(0)) / sum(rows)
        draws, total, squares = draws + n, total + n * mean, squares + n * mean * mean
    return replace(cell, draws=draws, total=total, squares=squares, binary=False)


def _pool(parts: Sequence[Cell], label: tuple[Any, ...]) -> Cell:
    low, high = min(cell.low for cell in parts), max(cell.high for cell in parts)
    binary = all(cell.binary and (cell.low, cell.high) in ((low, high), (low, low), (high, high)) for cell in parts)
    squares = _sum([cell.squares or Fraction(0) for cell in parts])
    total = _sum([cell.total for cell in parts])
    return Cell(sum(cell.draws for cell in parts), total, squares, low, high, binary, label)


def _sum(listed: Sequence[Fraction]) -> Fraction:
    """Add up fractions over one denominator."""
    bottom = lcm(*{value.denominator for value in listed})
    return Fraction(sum(value.numerator * (bottom // value.denominator) for value in listed), bottom)


def _policy_forms(
    policy: Policy, utility: Utility, group: Mechanism, context: Mechanism | None, declared: tuple[Fraction, Fraction] | None
) -> tuple[list[Cell], dict[tuple[Label, Label], Form], bool]:
    """Cells of a sampled policy, E(x,a) as forms in them, and whether cells share draws."""
    law = policy.law
    place = {(law.contexts[x], law.groups[a]): _counts(law, i) for i, (x, a) in enumerate(_cell_places(law))}
    nothing = [0] * len(law.decisions)
    by_decision = utility.entries is None
    by_group = not by_decision and _depends_on_group(utility)
    index: dict[tuple[Any, ...], int] = {}
    made: list[Cell] = []
    forms: dict[tuple[Label, Label], Form] = {}
    for x in law.contexts if context is None else context.inputs:
        shown_x = [(x, Fraction(1))] if context is None else _released(context, x)
        for a in group.inputs:
            form = []
            for (seen_x, p), (seen_a, q) in product(shown_x, _released(group, a)):
                key: tuple[Any, ...] = (seen_x, seen_a) if by_decision else (seen_x, seen_a, x, a) if by_group else (seen_x, seen_a, x)
                if key not in index:
                    index[key] = len(made)
                    row = place.get((seen_x, seen_a), nothing)
                    made.append(_cell(row, _scaled(_utility_row(utility, law.decisions, x, a), declared), key))
                form.append((index[key], p * q))
            forms[x, a] = tuple(form)
    return made, forms, len({key[:2] for key in index}) < len(index)


def _cell_places(law: Law) -> Iterable[tuple[int, int]]:
    return zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)


def _unit_form(cell: int) -> Form:
    return ((cell, Fraction(1)),)


def _normalised(weights: Sequence[tuple[int, Fraction]]) -> Form:
    total = sum((w for _, w in weights), Fraction(0))
    return tuple((i, w / total) for i, w in weights)


def _masses(population: Mapping[tuple[Label, Label], Any]) -> dict[tuple[Label, Label], Fraction]:
    masses = {(names(x), names(a)): Fraction(*option_value(v)) for (x, a), v in population.items()}
    if any(v < 0 for v in masses.values()) or not any(masses.values()):
        raise InputError("the population needs masses of at least 0, one of them positive")
    return masses


def _released(mechanism: Mechanism, value: Label) -> list[tuple[Label, Fraction]]:
    return [(out, Fraction(w, mechanism.denominator)) for out, w in zip(mechanism.outputs, mechanism.row(value), strict=True) if w]


def _depends_on_group(utility: Utility) -> bool:
    first: dict[tuple[str, Label], tuple[int, int]] = {}
    return any(first.setdefault((u, x), pair) != pair for (u, x, _), pair in (utility.entries or {}).items())


def _utility_row(utility: Utility, decisions: Sequence[str], x: Label, a: Label) -> list[Fraction]:
    if utility.entries is None:
        return [utility.values.get(u, Fraction(0)) for u in decisions]
    for u in decisions:
        if (u, x, a) not in utility.entries:
            raise InputError(f"the utility of decision {shown(u)} in context {x} for group {a} is not given")
    return [Fraction(*utility.entries[u, x, a]) for u in decisions]


# Tails


def tail_bound(cell: Cell, mean: Fraction, side: Literal["lower", "upper"]) -> int:
    """Bound the probability of a sum as small, or as large, as the observed one.

    Parameters
    ----------
    cell : Cell
        The draws.
    mean : Fraction
        The supposed mean of one draw.
    side : {"lower", "upper"}
        Whether sums at most, or at least, the observed one are meant.

    Returns
    -------
    int
        An upper bound of the probability in units of 2^-128, at most 2^128. Binary draws, up to 5,000 of them: the binomial tail, every
        step rounded up. More: exp(−n·kl) times min(1, 1/((1 − ρ)·sqrt(2πk(n−k)/n))), ρ the ratio of the two extreme terms (Stirling's
        bound for the extreme term, a geometric series for the others). Others: exp(−n·kl), which holds for all draws in [0, 1] because
        exp is convex.

    Examples
    --------
    >>> ten = Cell(10, Fraction(0), None, Fraction(0), Fraction(1), True)
    >>> tail_bound(ten, Fraction(1, 2), "lower") == 2**118
    True
    """
    if not cell.informative:
        return ONE
    width = cell.high - cell.low
    p = (mean - cell.low) / width
    k = cell.successes
    if side == "upper":
        p, k = 1 - p, cell.draws - k
    if p <= 0 or k == cell.draws:
        return ONE
    if p >= 1:
        return ONE if k == cell.draws else 0
    return _below(cell.draws, k, p, cell.binary)


@lru_cache(maxsize=200_000)
def _below(n: int, k: Fraction, p: Fraction, binary: bool) -> int:
    """Upper bound of P(sum ≤ k), 0 < p < 1, k < n, in units of 2^-BITS."""
    if not binary:
        return _chernoff(n, k, p, sharp=False)
    if n > EXACT_DRAWS:
        return _chernoff(n, k, p, sharp=True)
    top, bottom = p.numerator, p.denominator
    rest = bottom - top
    last = int(k)
    start = min(last, (n + 1) * top // bottom)
    high, high_at = _power_above(top, bottom, start)
    low, low_at = _power_above(rest, bottom, n - start)
    at = high_at + low_at + BITS
    term = comb(n, start) * high * low
    first = term << at if at >= 0 else -(-term >> -at)
    total = first
    for i, step in ((start, -1), (start, 1)):
        term = first
        while i > 0 if step < 0 else i < last:
            up, down = (i * rest, (n - i + 1) * top) if step < 0 else ((n - i) * top, (i + 1) * rest)
            term = -(-term * up // down)
            i += step
            if term <= 1:
                total += i + 1 if step < 0 else last - i + 1
                break
            total += term
    return min(total, ONE)


def _power_above(top: int, bottom: int, exponent: int) -> tuple[int, int]:
    """Mantissa m and exponent e with m·2^e ≥ (top/bottom)^exponent, barely."""
    shift = WORK + bottom.bit_length() - top.bit_length()
    base, base_at = -(-(top << shift) // bottom), -shift
    result, at = 1, 0
    while exponent:
        if exponent & 1:
            result, at = _rounded_up(result * base, at + base_at)
        base, base_at = _rounded_up(base * base, 2 * base_at)
        exponent >>= 1
    return result, at


def _rounded_up(mantissa: int, at: int) -> tuple[int, int]:
    drop = mantissa.bit_length() - WORK
    return (-(-mantissa >> drop), at + drop) if drop > 0 else (mantissa, at)


def _chernoff(n: int, k: Fraction, p: Fraction, *, sharp: bool) -> int:
    """exp(−n·kl(k/n, p)), with the factor for binomial tails if `sharp`, rounded up; units of 2^-BITS."""
    if k >= n * p:
        return ONE
    bits = BITS + 16 + n.bit_length()
    exponent = 0
    for part, expected in ((k, n * p), (n - k, n * (1 - p))):
        if part:
            ratio = part / expected
            low, _ = log_fixed(ratio.numerator, ratio.denominator, bits)
            exponent += part.numerator * low // part.denominator
    if exponent <= 0:
        return ONE
    if exponent >= 90 << bits:
        return 1
    low, _ = exp_enclosure((exponent, 1 << bits), BITS + 16)
    value = -(-(1 << (2 * BITS + 16)) // low)
    if sharp and k:
        ratio = k * (1 - p) / ((n - k + 1) * p)
        if ratio < 1:
            square = n / (2 * PI_BELOW * k * (n - k) * (1 - ratio) ** 2)
            if square < 1:
                root = isqrt((square.numerator << 2 * BITS) // square.denominator) + 1
                value = -(-value * root >> BITS)
    return min(value, ONE)


def _excluded(cell: Cell, mean: Fraction, side: Literal["lower", "upper"], level: Fraction) -> bool:
    return tail_bound(cell, mean, side) * level.denominator <= level.numerator << BITS


def _bernstein_excluded(cell: Cell, mean: Fraction, side: Literal["lower", "upper"], level: Fraction) -> bool:
    """Whether a mean lies beyond the empirical Bernstein bound of Maurer and Pontil (theorem 4), decided in integers."""
    n, width = cell.draws, cell.high - cell.low
    if n < 2 or cell.squares is None:
        return False
    distance = (mean - cell.mean if side == "lower" else cell.mean - mean) / width
    variance = max(Fraction(0), (cell.squares - cell.total**2 / n) / (n - 1) / width**2)
    _, high = log_fixed(2 * level.denominator, level.numerator, BITS)
    logarithm = Fraction(high, ONE)
    rest = distance - 7 * logarithm / (3 * (n - 1))
    return rest >= 0 and rest**2 >= 2 * variance * logarithm / n


# Ends of a cell


def cell_ends(cell: Cell, level: Fraction, method: Method = "hoeffding-kl") -> Ends:
    """Bound the mean of a cell from below and above, each end wrong with probability at most `level`.

    Parameters
    ----------
    cell : Cell
        The draws.
    level : Fraction
        Probability of error of one end, in (0, 1).
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For draws that are not binary; the intersection takes the better of the two, each at half the level. Binary draws have
        binomial ends (Clopper and Pearson up to 5,000 draws).

    Returns
    -------
    tuple of Fraction
        Lower and upper end, rounded outwards to about seven digits and proved in integers; the range of the cell if it has no draws.

    Examples
    --------
    >>> cell_ends(Cell(10, Fraction(0), None, Fraction(0), Fraction(1), True), Fraction(1, 40))
    (Fraction(0, 1), Fraction(771243, 2500000))
    """
    if not cell.informative:
        return cell.low, cell.high
    width = cell.high - cell.low
    scaled = Cell(
        cell.draws,
        cell.successes,
        None if cell.binary or cell.squares is None else (cell.squares - 2 * cell.low * cell.total + cell.draws * cell.low**2) / width**2,
        Fraction(0),
        Fraction(1),
        cell.binary,
    )
    low, high = _unit_ends(scaled, level, "hoeffding-kl" if cell.binary else method)
    return cell.low + width * low, cell.low + width * high


@lru_cache(maxsize=200_000)
def _unit_ends(cell: Cell, level: Fraction, method: Method) -> Ends:
    if method == "intersection":
        (a, b), (c, d) = (_unit_ends(cell, level / 2, each) for each in ("hoeffding-kl", "empirical-bernstein"))
        return max(a, c), min(b, d)
    return _search(cell, level, method, "upper"), _search(cell, level, method, "lower")


def _search(cell: Cell, level: Fraction, method: Method, side: Literal["lower", "upper"]) -> Fraction:
    """Find the outermost grid point that is proved to be excluded: the lower end is excluded by the upper tail, and vice versa."""
    outside = _bernstein_excluded if method == "empirical-bernstein" else _excluded
    guess = min(max(_guess(cell, float(level), method, side), 0.0), 1.0)
    scale = 10 ** (DIGITS - 1 + min(300, max(0, ceil(-log(guess) / log(10))) if guess > 0 else 0))
    at = floor(Fraction(guess) * scale) if side == "upper" else ceil(Fraction(guess) * scale)
    inward = 1 if side == "upper" else -1

    def proved(i: int) -> bool:
        return outside(cell, Fraction(i, scale), side, level)

    def beyond(i: int) -> bool:
        return i <= 0 if inward > 0 else i >= scale

    step = 1
    while not beyond(at) and not proved(at):
        at -= inward * step
        step *= 2
    if beyond(at):
        if step <= 2:
            return Fraction(0 if inward > 0 else 1)
        at = 0 if inward > 0 else scale
    while step >= 1:
        further = at + inward * step
        if 0 < further < scale and proved(further):
            at = further
        else:
            step //= 2
    return Fraction(at, scale)


def _guess(cell: Cell, level: float, method: Method, side: Literal["lower", "upper"]) -> float:
    n, k = cell.draws, float(cell.total)
    if method == "empirical-bernstein":
        if n < 2 or cell.squares is None:
            return 0.0 if side == "upper" else 1.0
        variance = max(0.0, float((cell.squares - cell.total**2 / n) / (n - 1)))
        radius = sqrt(2 * variance * log(2 / level) / n) + 7 * log(2 / level) / (3 * (n - 1))
        return k / n - radius if side == "upper" else k / n + radius
    return _float_end(n, k, level, cell.binary, side)


def _float_end(n: float, k: float, level: float, binary: bool, side: Literal["lower", "upper"]) -> float:
    """An end in floats: a guess, and what planning uses."""
    if binary and n <= EXACT_DRAWS:
        from scipy.special import betaincinv

        if side == "upper":
            return float(betaincinv(k, n - k + 1, level)) if k > 0 else 0.0
        return float(betaincinv(k + 1, n - k, 1 - level)) if k < n else 1.0
    if side == "upper":
        return 1 - _float_end(n, n - k, level, binary, "lower") if k >= n / 2 else _float_solve(n, k, level, binary, upper=False)
    return _float_solve(n, k, level, binary, upper=True) if k < n else 1.0


def _float_solve(n: float, k: float, level: float, binary: bool, *, upper: bool) -> float:
    low, high = (k / n, 1.0) if upper else (0.0, k / n)
    for _ in range(200):
        middle = (low + high) / 2
        if middle in (low, high):
            break
        inside = _float_tail(n, k if upper else n - k, middle if upper else 1 - middle, binary) > level
        if inside == upper:
            low = middle
        else:
            high = middle
    return high if upper else low


def _float_tail(n: float, k: float, p: float, binary: bool) -> float:
    """P(sum ≤ k) in floats, by the same formulas as `_below`."""
    if k >= n or p <= 0:
        return 1.0
    if p >= 1:
        return 0.0
    if binary and n <= EXACT_DRAWS:
        from scipy.special import bdtr

        return float(bdtr(k, int(n), p))
    if k >= n * p:
        return 1.0
    exponent = (k * log(k / (n * p)) if k else 0.0) + (n - k) * (log((n - k) / n) - log1p(-p))
    value = exp(-max(exponent, 0.0))
    if binary and k:
        ratio = k * (1 - p) / ((n - k + 1) * p)
        if ratio < 1:
            value *= min(1.0, sqrt(n / (2 * pi * k * (n - k))) / (1 - ratio))
    return value


# Quotients over a box


def greatest_ratio(top: Form, bottom: Form, ends: AllEnds) -> Any:
    """Maximise Σ w·h / Σ v·h over a box of non-negative h, exactly.

    The maximum is at a threshold: h at its upper end where w/v is greater than the maximum, else at its lower end.

    Parameters
    ----------
    top, bottom : tuple of (int, number)
        The weights w and v, by cell.
    ends : sequence of pairs
        Lower and upper end of each cell.

    Returns
    -------
    Fraction or float
        The maximum, `math.inf` if the denominator can vanish and the numerator with it cannot; 0/0 is 1.

    Examples
    --------
    >>> half = Fraction(1, 2)
    >>> greatest_ratio(((0, half), (1, half)), ((1, Fraction(1)),), [(Fraction(1), Fraction(2))] * 2)
    Fraction(3, 2)
    """
    w, v = dict(top), dict(bottom)
    ordered = sorted({**w, **v}, key=lambda i: -w[i] / v[i] if i in w and i in v else -inf if i in w else 0)
    above = sum(x * ends[i][0] for i, x in top)
    below = sum(x * ends[i][0] for i, x in bottom)
    best = quotient(above, below)
    for i in ordered:
        gap = ends[i][1] - ends[i][0]
        if gap:
            above += w.get(i, 0) * gap
            below += v.get(i, 0) * gap
            best = max(best, quotient(above, below))
    return best


def least_ratio(top: Form, bottom: Form, ends: AllEnds) -> Any:
    """Minimise Σ w·h / Σ v·h over a box of non-negative h, exactly; see `greatest_ratio`."""
    value = greatest_ratio(bottom, top, ends)
    return 0 if value == inf else 1 / value if value else inf


def _extreme(comparison: Comparison, ends: AllEnds, *, upper: bool) -> tuple[Any, tuple[int, int, int] | None]:
    """Greatest maximum (or minimum) of a quotient over all compared pairs, clipped at 1, and where: block, higher, lower."""
    best: Any = Fraction(1)
    where = None
    bound = greatest_ratio if upper else least_ratio
    for b, block in enumerate(comparison.blocks):
        for i, j in _candidates(block, ends):
            if _surely_less(block[i], block[j], ends, best, upper=upper):
                continue
            value = bound(block[i], block[j], ends)
            if value > best or (where is None and value == best):
                best, where = value, (b, i, j)
            if best == inf:
                return best, where
    return best, where


def _surely_less(top: Form, bottom: Form, ends: Any, than: Any, *, upper: bool) -> bool:
    """Whether floats, which are right to fifteen digits here, find a quotient of two cells well below a number."""
    if len(top) > 1 or len(bottom) > 1 or top[0][0] == bottom[0][0] or top[0][1] != bottom[0][1]:
        return False
    above, below, least = (_rounded(v) for v in (ends[top[0][0]][upper], ends[bottom[0][0]][not upper], than))
    return all(1e-100 < v < 1e100 for v in (above, below, least)) and above / below < least * (1 - 1e-9)


def _candidates(block: tuple[Form, ...], ends: AllEnds) -> Iterable[tuple[int, int]]:
    """Ordered pairs that can be extreme: all of them, unless every form is a cell of its own."""
    if len(block) < 3 or any(len(form) > 1 for form in block) or len({form[0][0] for form in block}) < len(block):
        return permutations(range(len(block)), 2)
    found = []
    lows, highs = ([ends[form[0][0]][k] for form in block] for k in (0, 1))
    for numerators, denominators in ((highs, lows), (lows, highs)):
        tops, bottoms = _two_least([-value for value in numerators]), _two_least(denominators)
        found += [(i, j) for i in tops for j in bottoms if i != j]
    return found


def _two_least(values: Sequence[Any]) -> list[int]:
    """Positions of the two least values, the first of equal ones. Rounding keeps the order, so floats leave few to compare."""
    rounded = [_rounded(value) for value in values]
    second = nsmallest(2, rounded)[-1]
    return sorted((i for i, value in enumerate(rounded) if value <= second), key=lambda i: (values[i], i))[:2]


def _rounded(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


# Levels


def box_levels(cells: int, span: int, alpha: Fraction, *, independent: bool, side: Side = "both") -> tuple[Fraction, Fraction]:
    """Levels of one end for the upper and for the lower end of the ratio; 0 for an end that was not asked for.

    Examples
    --------
    >>> box_levels(4, 2, Fraction(1, 20), independent=False)
    (Fraction(1, 80), Fraction(1, 240))
    """
    if not cells:
        return Fraction(0), Fraction(0)
    share = {"both": alpha / 2, "upper": alpha, "lower": alpha}[side]
    upper = share / span if side != "lower" else Fraction(0)
    lower = share / (2 * cells - span if side == "both" else 2 * cells) if side != "upper" else Fraction(0)
    if not independent or cells > SIDAK_CELLS:
        return upper, lower
    # Scale both levels by the greatest factor that the product of the cells' chances allows.
    low, high = 1.0, 2.0
    rate, rest = float(upper + lower), float(2 * lower)
    goal = log1p(-float(alpha))
    for _ in range(60):
        middle = (low + high) / 2
        fits = middle * max(rate, rest) < 1 and span * log1p(-middle * rate) + (cells - span) * log1p(-middle * rest) >= goal
        low, high = (middle, high) if fits else (low, middle)
    factor = Fraction(floor(low * 10**9) - 1, 10**9)
    if factor <= 1 or not _independent_levels(cells, span, alpha, upper * factor, lower * factor):
        return upper, lower
    return upper * factor, lower * factor


def _independent_levels(cells: int, span: int, alpha: Fraction, upper: Fraction, lower: Fraction) -> bool:
    return (1 - upper - lower) ** span * (1 - 2 * lower) ** (cells - span) >= 1 - alpha


@dataclass(frozen=True)
class _ProductLevels:
    """b, c for the upper end and b', c' for the lower end."""

    upper: tuple[Fraction, Fraction] | None
    lower: tuple[Fraction, Fraction] | None


@lru_cache(maxsize=1_000)
def _product_levels(cells: int, pairs: int, alpha: Fraction, side: Side) -> _ProductLevels:
    share = {"both": alpha / 2, "upper": alpha, "lower": alpha}[side]
    upper = lower = None
    if side != "lower":
        upper = _with_product(GUARD * share / 2, (1 - GUARD) * share)
    if side != "upper":
        ends = max(2, 2 * cells - 2) if side == "both" else 2 * cells
        lower = _with_product(GUARD * share / ends, (1 - GUARD) * share / (pairs - 1 if side == "both" else pairs))
    if upper and lower:
        lower = (lower[0], min(lower[1], upper[1]))
    return _ProductLevels(upper, lower)


def _with_product(guard: Fraction, budget: Fraction) -> tuple[Fraction, Fraction]:
    """The guard b rounded down, and the greatest c, of about six digits, with c·log(c/b²) − c + b² ≤ budget."""
    guard = _rounded_down(guard)
    low, high = float(guard) ** 2, float(guard)
    for _ in range(100):
        middle = (low + high) / 2
        fits = middle * log(middle / float(guard) ** 2) - middle + float(guard) ** 2 <= float(budget)
        low, high = (middle, high) if fits else (low, middle)
    c = _rounded_down(Fraction(low))
    while c > guard**2 and product_area(guard, c) > budget:
        c -= c / 1_000
    return guard, max(c, guard**2)


def product_area(guard: Fraction, c: Fraction) -> Fraction:
    """Upper bound of the area where both tails exceed b and their product is at most c, for b² ≤ c ≤ b."""
    ratio = c / guard**2
    _, high = log_fixed(ratio.numerator, ratio.denominator, BITS)
    return c * Fraction(high, ONE) - c + guard**2


def _rounded_down(value: Fraction) -> Fraction:
    scale = 10 ** (6 + max(0, ceil(-log(value) / log(10))))
    return Fraction(value.numerator * scale // value.denominator, scale)


# Intervals


def confidence_level(value: Any) -> Fraction:
    """Read a confidence in (0, 1); a float is the decimal that it is printed as."""
    level = Fraction(*option_value(value))
    if not 0 < level < 1:
        raise InputError(f"a confidence of {shown(value)} is not accepted; it lies between 0 and 1, such as 0.95")
    return level


def ratio_interval(
    comparison: Comparison,
    confidence: Any = "0.95",
    *,
    method: Method = "hoeffding-kl",
    region: Region = "box",
    independent: bool = False,
    side: Side = "both",
) -> Interval:
    """Bound the greatest quotient of two compared forms at a confidence, for finite samples.

    Parameters
    ----------
    comparison : Comparison
        What is compared.
    confidence : number or str
        The probability with which both ends are to hold.
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For cells whose draws are not binary; to be chosen before looking.
    region : {"box", "product"}
        "product" is narrower where the two cells of a pair are about equally uncertain (by about a fifth on the logarithmic scale); it
        needs independent cells, forms of one cell each, and not the empirical Bernstein method.
    independent : bool
        Whether the draws of different cells are independent, which the reader must then accept.
    side : {"both", "lower", "upper"}
        Which ends the confidence is spent on; the other end is trivial.

    Returns
    -------
    Interval
        Both ends with evidence.

    Raises
    ------
    InputError
        If the confidence is not in (0, 1), the method is not known, nothing is compared, or the region does not fit.

    Examples
    --------
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> found = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)), "0.95")
    >>> round(float(found.lower), 2), found.estimate, round(float(found.upper), 2)
    (1.96, Fraction(3, 1), 4.74)
    """
    level = confidence_level(confidence)
    if method not in get_args(Method):
        raise InputError(f"the method {shown(method)} is not known; {nearest(str(method), get_args(Method))}")
    if not any(len(block) > 1 for block in comparison.blocks):
        raise InputError("nothing is compared: no context has two groups")
    if independent and comparison.dependent:
        raise InputError("cells share draws or sampling units, so they are not independent")
    if region == "product" and not (independent and comparison.single and method == "hoeffding-kl"):
        raise InputError(
            "the product region needs independent cells, expected utilities that are the mean of one cell each, and binary utilities or "
            "the method hoeffding-kl; use the box"
        )
    alpha = 1 - level
    used = comparison.used
    region = region if used else "box"
    found = _product(comparison, alpha, side) if region == "product" else _box(comparison, alpha, method, independent, side)
    lower, upper, evidence = found
    kinds = {"binomial" if comparison.cells[i].binary else method for i in used}
    assumptions = (*comparison.assumptions, *((CELLS,) if independent else ()))
    evidence = {
        "confidence": _text(level),
        "side": side,
        "region": region,
        "independent": independent,
        "method": method,
        "cells": _cell_entries(comparison.cells),
        "blocks": [[[[i, _text(w)] for i, w in form] for form in block] for block in comparison.blocks],
        **evidence,
    }
    made = Interval(lower, upper, _estimate(comparison), level, region, tuple(sorted(kinds)), assumptions, evidence)
    return replace(made, estimand=comparison.estimand, of_units=comparison.of_units)


def drivers(comparison: Comparison, evidence: Mapping[str, Any]) -> tuple[Witness | None, Witness | None]:
    """Name the pairs that drive the lower and the upper end of an interval, with the means of their draws.

    Parameters
    ----------
    comparison : Comparison
        What was compared, with labels.
    evidence : mapping
        The evidence of the interval, as it has it or as a certificate stores it.

    Returns
    -------
    pair of Witness or None
        The pair that proves the lower end, and the one that attains the upper end: the greatest quotient over the box, or, for the product
        region, the greatest upper end of a pair by itself. Of pairs without an upper end it is the one that is most unequal in the draws,
        other ties go to input order; None for an end of 1 and for one that was not asked for.

    Examples
    --------
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> compared = local_comparison(law, Utility({"yes": 1}).on(law))
    >>> [found.higher for found in drivers(compared, ratio_interval(compared).evidence)]
    [{'group': 'f'}, {'group': 'f'}]
    """
    upper: tuple[int, int, int] | None = None
    if evidence["region"] == "box":
        lower = evidence["pair"]
        if evidence["upper"] is not None:
            ends = [(Fraction(*rational(a)), Fraction(*rational(b))) for a, b in evidence["upper"]]
            greatest, upper = _extreme(comparison, ends, upper=True)
            upper = _vanishing(comparison, ends) if greatest == inf else upper if greatest > 1 else None
    else:
        lower = None if evidence["lower"] is None else evidence["lower"]["pair"]
        levels = evidence["levels"]["upper"]
        if levels is not None:
            upper = _product_driver(comparison, Fraction(*rational(levels[0])), Fraction(*rational(levels[1])))
    return _witness(comparison, lower), _witness(comparison, upper)


def _vanishing(comparison: Comparison, ends: AllEnds) -> tuple[int, int, int] | None:
    """Which pair is most unequal in the draws, of those whose quotient is infinite somewhere in a box."""
    best: Extended = -1.0
    where = None
    for b, block in enumerate(comparison.blocks):
        bottoms = [j for j, form in enumerate(block) if not any(ends[i][0] for i, _ in form)] if len(block) > 1 else []
        means = [_mean(comparison, form) for form in block] if bottoms else []
        ranked = sorted(range(len(means)), key=lambda i: -means[i])
        for j in bottoms:
            tops = (i for i in ranked if i != j and greatest_ratio(block[i], block[j], ends) == inf)
            i = next(tops, None)
            if i is not None and (value := quotient(means[i], means[j])) > best:
                best, where = value, (b, i, j)
            if best == inf:
                return where
    return where


def _mean(comparison: Comparison, form: Form) -> Fraction:
    cells = [(comparison.cells[i], w) for i, w in form]
    return sum((w * (cell.mean if cell.draws else cell.low) for cell, w in cells), Fraction(0))


def _witness(comparison: Comparison, found: Sequence[int] | None) -> Witness | None:
    if found is None:
        return None
    block, higher, lower = found
    context, groups = comparison.labels[block]
    forms = comparison.blocks[block]
    return Witness(context, groups[higher], groups[lower], (_mean(comparison, forms[higher]), _mean(comparison, forms[lower])))


def _product_driver(comparison: Comparison, guard: Fraction, c: Fraction) -> tuple[int, int, int] | None:
    """Which pair has the greatest upper end by itself; the box of ends at the guard bounds that of each pair, so few are looked at."""
    ends: dict[int, Ends] = {}
    reach = []
    for b, block in enumerate(comparison.blocks):
        members = [form[0][0] for form in block] if len(block) > 1 else []
        ends |= {i: cell_ends(comparison.cells[i], guard) for i in members}
        means = [_mean(comparison, form) for form in block]
        reach += [
            (-quotient(ends[i][1], ends[j][0]), -quotient(means[h], means[k]), b, h, k)
            for (h, i), (k, j) in permutations(enumerate(members), 2)
        ]
    best, where = 1.0, None
    for most, _, b, h, k in sorted(reach):
        if -most <= best:
            break
        top, bottom = (replace(comparison.cells[comparison.blocks[b][form][0][0]]) for form in (h, k))
        found = _reach([top], [bottom], guard, c)
        if found > best:
            best, where = found, (b, h, k)
    return where


def _estimate(comparison: Comparison) -> Extended | None:
    """The ratio of the table itself; None if a cell has no draws."""
    cells, blocks = comparison.cells, comparison.blocks
    if not all(cell.draws or cell.low == cell.high for cell in cells):
        return None
    if len(cells) > DECISIVE_CELLS and comparison.single and _moderate(comparison):
        rounded = [cell.total.numerator / (cell.total.denominator * cell.draws) if cell.draws else float(cell.low) for cell in cells]
        promises = []
        for block in blocks:
            of_block = [rounded[form[0][0]] for form in block]
            top, low = max(of_block), min(of_block)
            promises.append(top / low if low else inf if top else 1.0)
        best = max(promises)
        if best == inf:
            return inf
        blocks = tuple(block for block, promise in zip(blocks, promises, strict=True) if promise > best * (1 - 1e-9))
    means = {i: (cells[i].mean if cells[i].draws else cells[i].low,) * 2 for block in blocks for form in block for i, _ in form}
    estimate: Extended
    estimate, _ = _extreme(replace(comparison, blocks=blocks), means, upper=True)
    return estimate


def default_region(comparison: Comparison, method: Method = "hoeffding-kl", *, independent: bool) -> Region:
    """Choose a region by what is known before the draws: the product for three or more independent cells of similar size.

    With two cells the product is usually a fifth narrower than the box, but some per cent wider where one of the two is much the more
    uncertain, which is not known beforehand; there the box is taken, whose levels are then those of Bonferroni or better.
    """
    sizes = [comparison.cells[i].draws for i in comparison.used]
    fits = independent and not comparison.dependent and comparison.single and method == "hoeffding-kl"
    return "product" if fits and 2 < len(sizes) <= TIGHT_CELLS and max(sizes) <= 100 * min(sizes) else "box"


def _box(
    comparison: Comparison, alpha: Fraction, method: Method, independent: bool, side: Side
) -> tuple[Fraction, Extended, dict[str, Any]]:
    upper_level, lower_level = box_levels(len(comparison.used), comparison.span, alpha, independent=independent, side=side)
    binary = all(comparison.cells[i].binary for i in comparison.used)
    many = len(comparison.used) > DECISIVE_CELLS and comparison.single and (binary or method == "hoeffding-kl") and _moderate(comparison)
    find = _decisive_ends if many else _every_end
    outer, upper, _ = find(comparison, upper_level, method, upper=True)
    inner, lower, where = find(comparison, lower_level, method, upper=False)
    evidence = {
        "levels": {"upper": _text(upper_level), "lower": _text(lower_level)},
        "upper": None if side == "lower" else [[_text(a), _text(b)] for a, b in outer],
        "lower": None if side == "upper" else [[_text(a), _text(b)] for a, b in inner],
        "pair": list(where) if where and lower > 1 and side != "upper" else None,
    }
    return Fraction(1) if side == "upper" else lower, inf if side == "lower" else upper, evidence


def _moderate(comparison: Comparison) -> bool:
    """Whether no range is so great or small that floats could not hold its quotients."""
    ends = {end for cell in comparison.cells for end in (cell.low, cell.high) if end}
    return all(abs(end.numerator.bit_length() - end.denominator.bit_length()) < 300 for end in ends)


def _all_ends(comparison: Comparison, level: Fraction, method: Method) -> list[Ends]:
    used = set(comparison.used) if level else set()
    return [cell_ends(cell, level, method) if i in used else (cell.low, cell.high) for i, cell in enumerate(comparison.cells)]


def _every_end(
    comparison: Comparison, level: Fraction, method: Method, *, upper: bool
) -> tuple[list[Ends], Any, tuple[int, int, int] | None]:
    """Ends of all cells, the greatest maximum (or minimum) of a quotient over them, and where it is."""
    ends = _all_ends(comparison, level, method)
    return (ends, *_extreme(comparison, ends, upper=upper))


def _decisive_ends(
    comparison: Comparison, level: Fraction, method: Method, *, upper: bool
) -> tuple[list[Ends], Any, tuple[int, int, int] | None]:
    """The same for many cells, of which only those that decide have ends as narrow as can be.

    For the maximum the others have ends by a cheaper inequality, which their block's quotients cannot lift above it; for the minimum, where
    one pair is enough, they have their whole range.
    """
    if not level:
        return _every_end(comparison, level, method, upper=upper)
    used = set(comparison.used)
    find = _decisive_upper if upper else _decisive_lower
    ends, best, where = find(comparison, used, level, method)
    return ends, best, where


def _decisive_upper(
    comparison: Comparison, used: set[int], level: Fraction, method: Method
) -> tuple[list[Ends], Any, tuple[int, int, int] | None]:
    """Narrow the outermost ends of a block until those are as narrow as can be, or the block cannot decide."""
    cells, blocks = comparison.cells, comparison.blocks
    wide = dict(zip(comparison.used, _wide_ends([cells[i] for i in comparison.used], level), strict=True))
    ends = [wide.get(i, (cell.low, cell.high)) for i, cell in enumerate(cells)]
    low, high = ([float(end[k]) for end in ends] for k in (0, 1))
    narrow = [i not in used for i in range(len(cells))]

    def promise(members: list[int]) -> tuple[float, set[int]]:
        """Greatest quotient of two cells of a block in floats, and the cells that it can be of."""
        if len(members) < 2:
            return 0.0, set()
        tops, bottoms = nlargest(2, members, key=high.__getitem__), nsmallest(2, members, key=low.__getitem__)
        if tops[0] != bottoms[0]:
            tops, bottoms = tops[:1], bottoms[:1]
        pairs = [(i, j) for i in tops for j in bottoms if i != j]
        return max(high[i] / low[j] if low[j] else inf if high[i] else 0.0 for i, j in pairs), {*tops, *bottoms}

    listed = [[form[0][0] for form in block] for block in blocks]
    best: Any = Fraction(1)
    where: tuple[int, int, int] | None = None
    for value, place in sorted(((promise(members)[0], -b) for b, members in enumerate(listed)), reverse=True):
        if best == inf or value * (1 + 1e-9) < best:
            break
        while True:
            value, outer = promise(listed[-place])
            open_cells = {i for i in outer if not narrow[i]}
            if value * (1 + 1e-9) < best or not open_cells:
                break
            for i in open_cells:
                ends[i], narrow[i] = cell_ends(cells[i], level, method), True
                low[i], high[i] = map(float, ends[i])
        if value * (1 + 1e-9) < best:
            continue
        found, pair = _extreme(Comparison(cells, (blocks[-place],)), ends, upper=True)
        if pair and (found > best or where is None):
            best, where = found, (-place, *pair[1:])
    return ends, best, where


def _decisive_lower(
    comparison: Comparison, used: set[int], level: Fraction, method: Method
) -> tuple[list[Ends], Any, tuple[int, int, int] | None]:
    """Narrow the cells that floats find furthest apart; any pair proves a lower end, so nothing rests on the floats."""
    cells, blocks = comparison.cells, comparison.blocks
    ends = [(cell.low, cell.high) for cell in cells]
    low, high = _guessed_ends(cells, used, float(level))
    promises = []
    for place, block in enumerate(blocks):
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
            ends[i] = cell_ends(cells[i], level, method)
        found, pair = _extreme(Comparison(cells, (block,)), ends, upper=False)
        if pair and (found > best or where is None):
            best, where = found, (-place, *pair[1:])
    return ends, best, where


def _guessed_ends(cells: Sequence[Cell], used: set[int], level: float) -> tuple[list[float], list[float]]:
    """Ends of the used cells in floats, all at once, by the formula of `_float_tail` for many draws; the others have their range."""
    low, high = ([float(end) for end in listed] for listed in ([cell.low for cell in cells], [cell.high for cell in cells]))
    at = sorted(used)
    n = np.array([cells[i].draws for i in at], dtype=np.float64)
    k = n * np.array([cells[i].share for i in at])
    binary = np.array([cells[i].binary for i in at])
    upper, lower = _float_uppers(n, k, binary, level), 1 - _float_uppers(n, n - k, binary, level)
    for i, a, b in zip(at, lower.tolist(), upper.tolist(), strict=True):
        low[i], high[i] = low[i] + (high[i] - low[i]) * a, low[i] + (high[i] - low[i]) * b
    return low, high


def _float_uppers(n: Floats, k: Floats, binary: NDArray[np.bool_], level: float) -> Floats:
    below, above = k / n, np.ones(len(n))
    with np.errstate(all="ignore"):
        for _ in range(50):
            p = (below + above) / 2
            exponent = np.where(k > 0, k * np.log(k / (n * p)), 0) + (n - k) * (np.log((n - k) / n) - np.log1p(-p))
            ratio = k * (1 - p) / ((n - k + 1) * p)
            factor = np.where(binary & (k > 0) & (ratio < 1), np.minimum(1, np.sqrt(n / (2 * pi * k * (n - k))) / (1 - ratio)), 1)
            inside = np.exp(-np.maximum(exponent, 0)) * factor > level
            below, above = np.where(inside, p, below), np.where(inside, above, p)
    found: Floats = np.where(k < n, above, 1.0)
    return found


def _wide_ends(cells: Sequence[Cell], level: Fraction) -> list[Ends]:
    """Ends of cells in closed form, which the sharp tail excludes too."""
    share, draws = np.array([cell.share for cell in cells]), np.array([float(cell.draws) for cell in cells])
    below, above = _closed_ends(share, -log(float(level)) / draws)
    low, high = below * (1 - 1e-6) - 1e-9, above * (1 + 1e-6) + 1e-9
    grid = (np.maximum(0, np.floor(low * 1e9)), np.minimum(1e9, np.ceil(high * 1e9)))
    listed = zip(cells, *(found.astype(np.int64).tolist() for found in grid), strict=True)
    return [(_between(cell, a), _between(cell, b)) for cell, a, b in listed]


def _closed_ends(share: Floats, cost: Floats) -> tuple[Floats, Floats]:
    """Where n·D reaches n·cost by bounds in closed form: D ≥ 2(z − μ)², and D ≥ (z − μ)²/(2·max(z, μ))."""
    square = np.sqrt(cost / 2)
    below = np.maximum(share - square, share - np.sqrt(2 * share * cost))
    above = np.minimum(share + square, share + cost + np.sqrt(2 * share * cost + cost * cost))
    return np.maximum(below, 0.0), np.minimum(above, 1.0)


def _between(cell: Cell, billionths: int) -> Fraction:
    if not cell.low and cell.high == 1:
        return Fraction(billionths, 10**9)
    return cell.low + (cell.high - cell.low) * Fraction(billionths, 10**9)


def _text(value: Extended) -> str:
    top, bottom = _pair(value)
    small = bottom > 0 and top.bit_length() + bottom.bit_length() < 1_000  # in lowest terms already
    return (f"{top}/{bottom}" if bottom > 1 else str(top)) if small else rational_text((top, bottom))


def _pair(value: Extended) -> tuple[int, int]:
    return (1, 0) if isinstance(value, float) else (value.numerator, value.denominator)


def _cell_entries(cells: Sequence[Cell]) -> list[dict[str, Any]]:
    texts: dict[tuple[int, int], list[str]] = {}  # most cells share their ends
    entries = []
    for cell in cells:
        key = id(cell.low), id(cell.high)
        ends = texts.get(key) or texts.setdefault(key, [_text(cell.low), _text(cell.high)])
        squares = None if cell.squares is None else _text(cell.squares)
        entries.append({"draws": cell.draws, "sum": _text(cell.total), "squares": squares, "range": [*ends], "binary": cell.binary})
    return entries


# Differences of rates


@dataclass(frozen=True)
class DifferenceInterval:
    """A confidence interval of the greatest difference of two rates.

    Attributes
    ----------
    lower, upper : Fraction
        Between 0 and 1.
    confidence : Fraction
        The probability, before the draws, that both ends are right.
    assumptions : tuple of str
        What the reader must accept.
    evidence : dict
        What a checker needs, as docs/certificate-samples.md describes it.
    """

    lower: Fraction
    upper: Fraction
    confidence: Fraction
    assumptions: tuple[str, ...]
    evidence: dict[str, Any]


def difference_interval(
    blocks: Sequence[Sequence[tuple[int, int]]], confidence: Any, *, pooled: bool = False, others: tuple[str, ...] = ()
) -> DifferenceInterval:
    """Bound the greatest difference between two rates of one block, from the binomial ends of each.

    Parameters
    ----------
    blocks : sequence of sequence of (int, int)
        Rates that are compared with each other, at least two in a block: how many draws were positive, and how many there were.
    confidence : number
        Between 0 and 1.
    pooled : bool
        Whether the draws of a rate were pooled over contexts.
    others : tuple of str
        Further assumptions.

    Returns
    -------
    DifferenceInterval
        The interval.

    Examples
    --------
    >>> found = difference_interval([[(90, 100), (50, 100)]], "0.95")
    >>> round(float(found.lower), 3), round(float(found.upper), 3)
    (0.197, 0.571)
    """
    level = confidence_level(confidence)
    cells = [Cell(n, Fraction(k), None, Fraction(0), Fraction(1), binary=True) for block in blocks for k, n in block]
    numbers = iter(range(len(cells)))
    places = [[next(numbers) for _ in block] for block in blocks]
    upper_level, lower_level = box_levels(len(cells), 2, 1 - level, independent=False)
    outer, upper = _outer_difference(cells, places, upper_level)
    inner, lower = _inner_difference(cells, places, lower_level)
    evidence = {
        "confidence": _text(level),
        "levels": {"upper": _text(upper_level), "lower": _text(lower_level)},
        "upper": [[_text(a), _text(b)] for a, b in outer],
        "lower": [[_text(a), _text(b)] for a, b in inner],
        "difference": [_text(lower), _text(upper)],
    }
    assumptions = (GIVEN_TRUTH, *((POOLED,) if pooled else ()), DECLARED_POSITIVE, *others)
    return DifferenceInterval(lower, upper, level, assumptions, evidence)


def _widest(members: Sequence[int], tops: Sequence[Fraction], bottoms: Sequence[Fraction]) -> tuple[Fraction, int, int]:
    """Greatest difference of the top of a rate and the bottom of another one, and where it is."""
    first, low = nlargest(2, members, key=tops.__getitem__), nsmallest(2, members, key=bottoms.__getitem__)
    return max((tops[i] - bottoms[j], i, j) for i in first for j in low if i != j)


def _outer_difference(cells: Sequence[Cell], places: Sequence[Sequence[int]], level: Fraction) -> tuple[list[Ends], Fraction]:
    """Ends of all rates, as narrow as can be where they decide, and the greatest difference that they allow."""
    many = len(cells) > DECISIVE_CELLS
    ends = _wide_ends(cells, level) if many else [cell_ends(cell, level) for cell in cells]
    narrow = [not many] * len(cells)
    low, high = ([end[k] for end in ends] for k in (0, 1))
    heap = [(-found, number, i, j) for number, members in enumerate(places) for found, i, j in [_widest(members, high, low)]]
    heapify(heap)
    while True:
        negative, number, i, j = heap[0]
        wide = [cell for cell in (i, j) if not narrow[cell]]
        if not wide:
            return ends, min(Fraction(1), -negative)
        for cell in wide:
            own = cell_ends(cells[cell], level)
            low[cell], high[cell] = max(own[0], low[cell]), min(own[1], high[cell])
            ends[cell], narrow[cell] = (low[cell], high[cell]), True
        found, i, j = _widest(places[number], high, low)
        heapreplace(heap, (-found, number, i, j))


def _inner_difference(cells: Sequence[Cell], places: Sequence[Sequence[int]], level: Fraction) -> tuple[list[Ends], Fraction]:
    """Ends of all rates, of which one pair proves that there is such a difference; where they do not decide, the whole range."""
    if len(cells) <= DECISIVE_CELLS:
        ends = [cell_ends(cell, level) for cell in cells]
        chosen = places
    else:
        wide = _wide_ends(cells, level)
        low, high = ([end[k] for end in wide] for k in (0, 1))
        promising = nlargest(FOREMOST, (_widest(members, low, high) for members in places))
        ends = [(Fraction(0), Fraction(1))] * len(cells)
        for i in {cell for _, *pair in promising for cell in pair}:
            ends[i] = cell_ends(cells[i], level)
        chosen = [pair for _, *pair in promising]
    low, high = ([end[k] for end in ends] for k in (0, 1))
    return ends, max(Fraction(0), *(_widest(members, low, high)[0] for members in chosen))


# The product region


def _product(comparison: Comparison, alpha: Fraction, side: Side) -> tuple[Fraction, Extended, dict[str, Any]]:
    levels = _product_levels(len(comparison.used), comparison.pairs, alpha, side)
    own = [replace(cell) for cell in comparison.cells]  # cells are told apart by identity, equal ones included
    blocks = [[own[form[0][0]] for form in block] for block in comparison.blocks if len(block) > 1]
    entry: dict[str, Any] = {"levels": {"upper": None, "lower": None}, "upper": None, "lower": None}
    upper: Extended = inf
    lower = Fraction(1)
    if levels.upper:
        entry["levels"]["upper"] = [_text(v) for v in levels.upper]
        upper = max((_ladder_bound(cells, cells, *levels.upper) for cells in blocks), default=Fraction(1))
        upper = max(upper, Fraction(1))
        if upper != inf:
            knots = [_ladder(cells, cells, Fraction(upper), *levels.upper) for cells in blocks]
            if None in knots:
                upper = inf
            else:
                entry["upper"] = [[_text(q) for q in listed] for listed in knots if listed is not None]
    if levels.lower:
        entry["levels"]["lower"] = [_text(v) for v in levels.lower]
        lower, entry["lower"] = _product_lower(replace(comparison, cells=tuple(own)), levels.lower)
    return lower, upper, entry


def _product_lower(comparison: Comparison, level: tuple[Fraction, Fraction]) -> tuple[Fraction, dict[str, Any] | None]:
    """Lower end from the few pairs whose cells are furthest apart: one pair proves it, and all pairs share the error."""
    ends = _all_ends(comparison, level[0], "hoeffding-kl")
    ranked = []
    for b, block in enumerate(comparison.blocks):
        pairs = _candidates(block, ends) if len(block) > 1 else []
        ranked += [(least_ratio(block[i], block[j], ends), -b, -i, -j) for i, j in pairs]
    best, found = Fraction(1), None
    for _, b, i, j in sorted(ranked, reverse=True)[:3]:
        block = comparison.blocks[-b]
        low, high = (comparison.cells[block[k][0][0]] for k in (-j, -i))
        bound = _ladder_bound([low], [high], *level)
        if bound != inf and 0 < bound < 1 / best:
            knots = _ladder([low], [high], Fraction(bound), *level)
            if knots is not None:
                best, found = 1 / Fraction(bound), {"pair": [-b, -i, -j], "knots": [_text(q) for q in knots]}
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
        return _float_tail(self.draws, self.draws - self.successes, 1 - p, self.binary) if self.draws and self.width else 1.0

    def below(self, mean: float) -> float:
        """Lower tail at a mean."""
        p = (mean - self.low) / self.width if self.width else 1.0
        return _float_tail(self.draws, self.successes, p, self.binary) if self.draws and self.width else 1.0


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
    best = _reach(tops, bottoms, guard, c)
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


def _reach(tops: Sequence[Cell], bottoms: Sequence[Cell], guard: Fraction, c: Fraction) -> float:
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


# An estimated population


def sampled_population_interval(
    comparison: Comparison, counts: Sequence[Sequence[int]], confidence: Any = "0.95", *, method: Method = "hoeffding-kl"
) -> Interval:
    """Bound the global ratio when P(x|a) is itself estimated, from a sample of its own, in the same error.

    P(·|a) lies in the box of its binomial ends and sums to 1; over that region the greatest and least group means are found exactly, by
    filling up the contexts in order. The two groups of a pair are taken apart (a shared cell may be at its upper end in one and at its
    lower in the other), which is sound and not tight.

    Parameters
    ----------
    comparison : Comparison
        A local comparison: for each context a block with a form for each group, in the same order.
    counts : sequence of sequence of int
        How often each context (row) was seen for each group (column).
    confidence, method
        As for `ratio_interval`.

    Returns
    -------
    Interval
        Of the global ratio.

    Raises
    ------
    InputError
        If the counts do not fit.
    """
    level = confidence_level(confidence)
    groups = len(comparison.blocks[0]) if comparison.blocks else 0
    if len(counts) != len(comparison.blocks) or any(len(row) != groups for row in counts) or groups < 2:
        raise InputError("the counts of contexts need one row for each context and one column for each of at least two groups")
    if any(len(block) != groups for block in comparison.blocks):
        raise InputError("an estimated population needs every group in every context")
    if any(not isinstance(n, int) or isinstance(n, bool) or n < 0 for row in counts for n in row):
        raise InputError("an estimated population needs whole counts of at least 0")
    totals = [sum(row[a] for row in counts) for a in range(groups)]
    if 0 in totals:
        raise InputError("an estimated population needs at least one draw of every group")
    used = len(comparison.used)
    shares = len(counts) * groups if len(counts) > 1 else 0
    end = (1 - level) / (2 * (used + shares)) if used + shares else Fraction(1, 2)
    ends = _all_ends(comparison, end, method)
    population = [
        [cell_ends(Cell(totals[a], Fraction(row[a]), None, Fraction(0), Fraction(1), True), end) for row in counts] for a in range(groups)
    ]
    means = []
    for a in range(groups):
        low, high = ([sum((w * ends[i][side] for i, w in block[a]), Fraction(0)) for block in comparison.blocks] for side in (0, 1))
        means.append((-_fill([-v for v in low], population[a]), _fill(high, population[a])))
    box = Comparison(comparison.cells, (tuple(_unit_form(a) for a in range(groups)),))
    upper, _ = _extreme(box, means, upper=True)
    lower, _ = _extreme(box, means, upper=False)
    estimate = None
    if all(cell.draws for cell in comparison.cells):
        point = [
            sum(
                (
                    Fraction(row[a], totals[a]) * w * comparison.cells[i].mean
                    for row, block in zip(counts, comparison.blocks, strict=True)
                    for i, w in block[a]
                ),
                Fraction(0),
            )
            for a in range(groups)
        ]
        estimate, _ = _extreme(box, [(v, v) for v in point], upper=True)
    evidence = {
        "confidence": _text(level),
        "method": method,
        "cells": _cell_entries(comparison.cells),
        "blocks": [[[[i, _text(w)] for i, w in form] for form in block] for block in comparison.blocks],
        "counts": [list(row) for row in counts],
        "level": _text(end),
        "ends": [[_text(a), _text(b)] for a, b in ends],
        "population": [[[_text(a), _text(b)] for a, b in row] for row in population],
    }
    kinds = {"binomial", *("binomial" if comparison.cells[i].binary else method for i in comparison.used)}
    assumptions = (*comparison.assumptions, "the sample of the population was drawn independently from that population")
    return Interval(lower, upper, estimate, level, "box", tuple(sorted(kinds)), assumptions, evidence)


def _fill(values: Sequence[Fraction], shares: Sequence[Ends]) -> Fraction:
    """Maximise Σ p·v over lo ≤ p ≤ hi, Σ p = 1: raise p from lo in falling order of v."""
    rest = 1 - sum(low for low, _ in shares)
    total = sum((low * v for (low, _), v in zip(shares, values, strict=True)), Fraction(0))
    for v, (low, high) in sorted(zip(values, shares, strict=True), key=lambda pair: -pair[0]):
        step = min(rest, high - low)
        total += step * v
        rest -= step
    return total


# What follows from an interval


@without_bare_limits(ALONE)
def verdict(
    interval: Interval | tuple[Extended, Extended], *, max_ratio: Any = None, max_log: Any = None
) -> Literal["within", "exceeds", "inconclusive"]:
    """Judge a target by an interval.

    Parameters
    ----------
    interval : Interval or pair
        The interval of R.
    max_ratio, max_log : number or str, optional
        The limit on R (one under 1 is least over greatest), or on L, its natural logarithm; exactly one of the two.

    Returns
    -------
    {"within", "exceeds", "inconclusive"}
        "within" if the upper end is at most the limit, "exceeds" if the lower end is above it.

    Examples
    --------
    >>> verdict((Fraction(1), Fraction(6, 5)), max_log=0.2), verdict((Fraction(1), Fraction(4, 3)), max_ratio="5/4")
    ('within', 'inconclusive')
    """
    lower, upper = (interval.lower, interval.upper) if isinstance(interval, Interval) else interval
    unit, limit = one_limit(max_ratio, max_log)
    if unit == "ratio":
        return "within" if upper <= limit else "exceeds" if lower > limit else "inconclusive"
    pair = (limit.numerator, limit.denominator)
    if compare_log(_pair(upper), pair) <= 0:
        return "within"
    return "exceeds" if compare_log(_pair(lower), pair) > 0 else "inconclusive"


def test_filter(
    comparison: Comparison,
    exp_epsilon: Any,
    confidence: Any = "0.95",  # noqa: PT028
    *,
    method: Method = "hoeffding-kl",  # noqa: PT028
    region: Region = "box",  # noqa: PT028
    independent: bool = False,  # noqa: PT028
) -> FilterTest:
    """Test a claimed ε by decisions drawn end to end, at true contexts and groups, through the deployed filter (T11).

    Parameters
    ----------
    comparison : Comparison
        The local comparison of the draws, made with a utility that ignores the group and was fixed beforehand.
    exp_epsilon : number or str
        e^ε ≥ 1, or ``"inf"``.
    confidence, method, region, independent
        As for `ratio_interval`; the whole error is spent on the lower end.

    Returns
    -------
    FilterTest
        Refuted if the lower end of R is above e^ε: then the filter is not ε-private, or its draws are not fresh and independent, except
        with probability 1 − confidence. Not refuted is no proof of anything.

    Raises
    ------
    InputError
        If e^ε is below 1, or cells of a context differ in their range, so that g depends on the group.
    """
    infinite = exp_epsilon == inf or exp_epsilon == "inf"
    claimed: Extended = inf if infinite else Fraction(*option_value(exp_epsilon))
    if claimed < 1:
        raise InputError(f"e^ε = {shown(exp_epsilon)} is not accepted; it is at least 1")
    if any(
        len({(comparison.cells[i].low, comparison.cells[i].high) for form in block for i, _ in form}) > 1 for block in comparison.blocks
    ):
        raise InputError("the range of the utility differs between groups; a utility that depends on the group refutes nothing")
    interval = ratio_interval(comparison, confidence, method=method, region=region, independent=independent, side="lower")
    refuted = interval.lower > claimed
    of = " of the means over units" if interval.estimand == "mean over units" else ""
    said = f"the ratio{of} is at least {float(interval.lower):.6g} at confidence {_text(interval.confidence)}"
    if refuted:
        sentence = f"{said}, above e^ε = {shown(str(exp_epsilon))}: the filter is not what it claims, or its draws are not independent."
    else:
        sentence = f"{said}, not above e^ε = {shown(str(exp_epsilon))}: these draws do not refute the claim, and prove nothing for it."
    return FilterTest(refuted, interval, claimed, sentence)


test_filter.__test__ = False  # type: ignore[attr-defined]


def noise_floor(
    effect: Comparison,
    placebo: Comparison,
    confidence: Any = "0.95",
    *,
    method: Method = "hoeffding-kl",
    region: Region = "box",
    independent: bool = False,
) -> NoiseFloor:
    """Compare a ratio between groups with the ratio under edits that should not matter.

    Parameters
    ----------
    effect, placebo : Comparison
        The two tables, with the same utility.
    confidence : number or str
        With which both intervals hold together; each has half of the error.
    method, region, independent
        As for `ratio_interval`.

    Returns
    -------
    NoiseFloor
        The effect rises above the floor if its lower end is above the upper end of the placebo.
    """
    level = confidence_level(confidence)
    each = 1 - (1 - level) / 2
    options: dict[str, Any] = {"method": method, "region": region, "independent": independent}
    first, second = (ratio_interval(comparison, each, **options) for comparison in (effect, placebo))
    rises = first.lower > second.upper
    shown_ends = [f"[{float(i.lower):.4g}, {float(i.upper):.4g}]" for i in (first, second)]
    relation = "rises above" if rises else "does not rise above"
    of = " (means over units)" if "mean over units" in (first.estimand, second.estimand) else ""
    sentence = (
        f"The ratio of the groups{of} lies in {shown_ends[0]}, that of the placebo in {shown_ends[1]}, both at confidence {_text(level)}: "
        f"the effect {relation} the noise floor."
    )
    return NoiseFloor(first, second, rises, sentence)


# Planning, in floats


@without_bare_limits(ALONE)
def further_draws(
    comparison: Comparison,
    confidence: Any = "0.95",
    *,
    max_ratio: Any = None,
    max_log: Any = None,
    interval: Interval | None = None,
    greatest: int = 10**12,
) -> Planning:
    """Estimate how many more draws would decide a target, if the truth were as measured and all cells grew alike.

    What was measured is itself subject to chance. Where the draws do not exclude that all compared groups are equal, a measured ratio
    above the limit is no reason to expect "exceeds": then no verdict is expected, and what equal groups would need is said, too.

    Parameters
    ----------
    comparison : Comparison
        The draws so far.
    confidence : number or str
        Of the interval; it is planned for with the box, and hoeffding-kl where draws are not binary.
    max_ratio, max_log
        The target, as for `verdict`.
    interval : Interval, optional
        The interval so far, which says whether equal groups are excluded; by default what the box is expected to give.
    greatest : int
        Give up when a cell would need more draws than this.

    Returns
    -------
    Planning
        A planning estimate: about one time in two the draws will not suffice.

    Examples
    --------
    >>> law = Law.from_array([[12, 28], [8, 32]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> planned = further_draws(local_comparison(law, Utility({"yes": 1}).on(law)), max_ratio="5/4")
    >>> planned.decides, planned.total > 0, planned.total_if_equal > 0
    (None, True, True)
    """
    level = confidence_level(confidence)
    cells = comparison.cells
    if any(not cells[i].draws for block in comparison.blocks for form in block for i, _ in form):
        return Planning(None, None, "Planning estimate: some cells have no draws; draw from every cell first.")
    if any(cell.high > GREATEST_PLANNED for cell in cells):
        return Planning(None, None, "Planning estimate: none for utilities above 10^300, which floating point does not hold.")
    goal = _float_limit(max_ratio, max_log)

    def least_factor(means: Sequence[float]) -> tuple[float, Literal["within", "exceeds"] | None]:
        expected = _expectation(comparison, means, level, 0.0)

        def decides(factor: float) -> Literal["within", "exceeds"] | None:
            lower, upper = expected(lambda i: max(cells[i].draws, ceil(cells[i].draws * factor)))
            return "within" if upper <= goal else "exceeds" if lower > goal else None

        found: tuple[float, Literal["within", "exceeds"] | None] = _least(decides, greatest / max(cell.draws for cell in cells))
        return found

    means = [float(cell.mean) for cell in cells]
    factor, found = least_factor(means)
    lower = interval.lower if interval else _expectation(comparison, means, level, 0.0)(lambda i: cells[i].draws)[0]
    equal_factor, equal = least_factor(_equal_means(comparison)) if lower <= 1 else (1.0, None)
    more = None if found is None else tuple(max(0, ceil(cell.draws * factor) - cell.draws) for cell in cells)
    total, if_equal = _further(comparison, factor, found), _further(comparison, equal_factor, equal)
    by_chance = lower <= 1 and found != "within"
    sentence = _planned(comparison, (total, factor), None if by_chance else found)
    if by_chance:
        needed = "no number of draws would decide" if if_equal is None else f"it would take about {if_equal}"
        sentence += f" These draws do not exclude that all groups are equal, and their ratio may be chance alone; if so, {needed}."
    return Planning(more, None if by_chance else found, sentence, total, if_equal)


def _equal_means(comparison: Comparison) -> list[float]:
    """Means of the cells if the forms of each block were equal, as near to the draws as that."""
    cells = comparison.cells
    sets = [[i for form in block for i, _ in form] for block in comparison.blocks] if comparison.single else [list(range(len(cells)))]
    means = [float(cell.mean) for cell in cells]
    for members in sets:
        pooled = float(_sum([cells[i].total for i in members]) / sum(cells[i].draws for i in members))
        for i in members:
            means[i] = min(max(pooled, float(cells[i].low)), float(cells[i].high))
    return means


def _further(comparison: Comparison, factor: float, found: str | None) -> int | None:
    """How many further draws a factor means, or further units, which count once however many cells they have rows in."""
    if found is None:
        return None
    units = comparison.units
    counts = [units.total] if units and units.total else [cell.draws for cell in comparison.cells]
    return sum(max(0, ceil(count * factor) - count) for count in counts)


def _planned(comparison: Comparison, further: tuple[int | None, float], found: str | None) -> str:
    """What it would take if the truth were as measured."""
    measured, (total, factor) = _estimate(comparison), further
    ratio = "" if measured is None else f" (a ratio of {approximate(measured)})"
    start = f"Planning estimate, not a guarantee: if the truth were as measured{ratio},"
    if total is None:
        return f"{start} no number of further draws would be expected to decide."
    units = comparison.units
    what = f"units of {', '.join(map(shown, units.columns))}" if units and units.total else "draws"
    verdict = "" if found is None else f" ({found})"
    return f"{start} about {total} further {what}, {factor:.3g} times as many in all, would decide{verdict}."


@without_bare_limits(ALONE)
def plan(
    guesses: Comparison | Sequence[Any],
    confidence: Any = "0.95",
    *,
    max_ratio: Any = None,
    max_log: Any = None,
    power: float = 0.8,
    limits: tuple[Any, Any] = (0, 1),
    binary: bool = True,
    greatest: int = 10**12,
) -> Planning:
    """Estimate the draws per cell, the same in each, that would show that a target is kept or exceeded, before any are taken.

    Parameters
    ----------
    guesses : sequence of numbers, sequence of such sequences, or Comparison
        The supposed means of the groups of one context, or of each of several; or a comparison whose cell means are the guesses.
    confidence : number or str
        Of the interval.
    max_ratio, max_log
        The target, as for `verdict`.
    power : float
        How likely it should roughly be, in [0.5, 1), that the draws suffice if the guesses are right.
    limits, binary
        The range of the utility, and whether it takes no values between.
    greatest : int
        Give up beyond this number of draws per cell.

    Returns
    -------
    Planning
        A planning estimate, in floats.

    Raises
    ------
    InputError
        If a guess lies outside the limits or the power is not in [0.5, 1).

    Examples
    --------
    >>> plan(["0.5", "0.5"], max_log="0.2").draws
    (973, 973)
    """
    if not 0.5 <= power < 1:
        raise InputError(f"a power of {shown(power)} is not accepted; it lies between 0.5 and 1")
    level = confidence_level(confidence)
    if isinstance(guesses, Comparison):
        comparison = replace(
            guesses, cells=tuple(replace(c, draws=max(1, c.draws), total=c.total if c.draws else c.high) for c in guesses.cells)
        )
        means = [float(cell.mean) for cell in comparison.cells]
    else:
        low, high = _limits(limits)
        listed = [list(part) if isinstance(part, (list, tuple)) else [part] for part in guesses]
        rows = listed if any(len(part) > 1 for part in listed) else [[part[0] for part in listed]]
        values = [[Fraction(*option_value(guess)) for guess in row] for row in rows]
        if any(len(row) < 2 for row in values) or any(not low <= v <= high for row in values for v in row):
            raise InputError(f"guesses are needed for at least two groups of each context, between {low} and {high}")
        if high > GREATEST_PLANNED:
            raise InputError("a plan needs utilities of at most 10^300, as far as floating point goes; divide all of them by one number")
        means = [float(v) for row in values for v in row]
        places = iter(range(len(means)))
        blocks = tuple(tuple(_unit_form(next(places)) for _ in row) for row in values)
        comparison = Comparison((Cell(1, low, None, low, high, binary),) * len(means), blocks)
    goal, shift = _float_limit(max_ratio, max_log), NormalDist().inv_cdf(power)

    expected = _expectation(comparison, means, level, shift)

    def decides(draws: float) -> Literal["within", "exceeds"] | None:
        lower, upper = expected(lambda _: ceil(draws))
        return "within" if upper <= goal else "exceeds" if lower > goal else None

    draws, found = _least(decides, greatest)
    if found is None:
        return Planning(None, None, "Planning estimate: no number of draws is expected to decide; the guesses are too close to the limit.")
    count = ceil(draws)
    return Planning(
        (count,) * len(means),
        found,
        f"Planning estimate, not a guarantee: if the guesses are right, about {count} draws per cell would show {found!r}.",
    )


def _float_limit(max_ratio: Any, max_log: Any) -> float:
    unit, limit = one_limit(max_ratio, max_log)
    return exp(min(limit, Fraction(700))) if unit == "log" else float(min(limit, Fraction(10**300)))


def _least(decides: Callable[[float], Any], greatest: float) -> tuple[float, Any]:
    """Least number ≥ 1 from which on a verdict is expected, by doubling and halving."""
    high = 1.0
    while decides(high) is None:
        if high >= greatest:
            return high, None
        high = min(2 * high, greatest)
    low = high / 2
    while high > 1 and high - low > max(0.5 / greatest, 1e-3 * high):
        middle = (low + high) / 2
        low, high = (low, middle) if decides(middle) is not None else (middle, high)
    return high, decides(high)


def _expectation(
    comparison: Comparison, means: Sequence[float], level: Fraction, shift: float
) -> Callable[[Callable[[int], int]], tuple[float, float]]:
    """The interval that the box is expected to give, by the draws of each cell; with a shift, against so many standard errors.

    Of many blocks only those are looked at that ends in closed form put first.
    """
    cells, used = comparison.cells, set(comparison.used)
    levels = box_levels(len(used), comparison.span, 1 - level, independent=False)
    many = len(used) > DECISIVE_CELLS and comparison.single
    flat = np.array([form[0][0] for block in comparison.blocks for form in block]) if many else np.zeros(0, dtype=np.int64)
    starts = np.cumsum([0, *map(len, comparison.blocks[:-1])])
    low, high = (np.array([float(end) for end in ends])[flat] for ends in ([c.low for c in cells], [c.high for c in cells]))
    share = (np.array(means)[flat] - low) / np.where(high > low, high - low, 1)

    def foremost(draws: Callable[[int], int], each: float, *, upper: bool) -> tuple[tuple[Form, ...], ...]:
        cost = -log(each) / np.array([float(draws(i)) for i in flat.tolist()])
        below, above = (low + (high - low) * end for end in _closed_ends(share, cost))
        top, bottom = (above, below) if upper else (below, above)
        with np.errstate(all="ignore"):
            promised = np.maximum.reduceat(top, starts) / np.minimum.reduceat(bottom, starts)
        return tuple(comparison.blocks[b] for b in np.argsort(-np.nan_to_num(promised), kind="stable")[:FOREMOST].tolist())

    def end(i: int, n: int, each: float) -> tuple[float, float]:
        cell = cells[i]
        least, width = float(cell.low), float(cell.high - cell.low)
        if i not in used:
            return least, least + width
        p = (means[i] - least) / width
        error = shift * sqrt(p * (1 - p) / n) if shift else 0.0
        # Both ends of the ratio suffer when a numerator or denominator deviates towards its own end.
        below, above = max(0.0, p - error), min(1.0, p + error)
        return (
            least + width * _float_end(n, n * below, each, cell.binary, "upper"),
            least + width * _float_end(n, n * above, each, cell.binary, "lower"),
        )

    def expected(draws: Callable[[int], int]) -> tuple[float, float]:
        sides = []
        for upper, each in zip((True, False), map(float, levels), strict=True):
            blocks = foremost(draws, each, upper=upper) if many else comparison.blocks
            needed = {i for block in blocks for form in block for i, _ in form}
            ends = {i: end(i, draws(i), each) for i in needed}
            value, _ = _extreme(replace(comparison, blocks=blocks), ends, upper=upper)
            sides.append(float(value))
        return sides[1], sides[0]

    return expected
