"""How far every cell may drift while a verdict stands, and the ratios within a declared drift (T16), as results and claims have them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.audits.targets import Target
from fairaudit.certificates.numbers import number
from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import quotient
from fairaudit.inference.verdicts import Verdict, foremost_verdict
from fairaudit.inference.verdicts import verdict as interval_verdict
from fairaudit.measures.expectations import compared_expectations
from fairaudit.measures.limits import Quantity
from fairaudit.theorems.registry import ONE_SIDED
from fairaudit.words import DRIFTING, brief

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.inference.moving_ends import MovingEnds
    from fairaudit.model.policy import Deployment
    from fairaudit.model.utility import UtilityTable
    from fairaudit.theorems.t16 import Extreme, Form, LawRadius, Moving

__all__ = ["DriftedRatio", "TableRadius"]

FEW_CELLS = 20_000
"""Up to so many cells a reader sums the means of all groups exactly."""


@brief
@dataclass(frozen=True, repr=False)
class TableRadius:
    """How far every cell may move, each on its own, while the verdict on a target stands.

    Attributes
    ----------
    verdict : {"within", "exceeds"}
        The verdict.
    radius : Fraction or float
        As total variation: with "within" the verdict stands up to it, with "exceeds" below it; `math.inf` if no update changes it.
    exact : bool
        Whether some update by that much, or one as close to it as one likes, changes the verdict; else it is rounded inwards, or follows
        from ends of cells.
    factor, exact_factor : Fraction or float or None, bool
        Likewise the factor by which probabilities may change; None of a population.
    pair : tuple or None
        Where it changes first: context (None overall), higher and lower group.
    factor_pair : tuple or None
        Likewise by a factor.
    of_population : bool
        Whether the verdict is on the population.

    Examples
    --------
    >>> import fairaudit as fa
    >>> law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    >>> found = fa.certify(law, {"yes": 1}, max_local_ratio=2).drift_radii[0]
    >>> found.radius, found.exact, round(float(found.factor), 3)
    (Fraction(1, 10), True, 1.3)
    """

    verdict: Literal["within", "exceeds"]
    radius: Extended
    exact: bool
    factor: Extended | None
    exact_factor: bool
    pair: Pair | None
    factor_pair: Pair | None
    of_population: bool

    @property
    def always(self) -> bool:
        """Whether no update changes the verdict."""
        return self.radius == inf


Pair = tuple[dict[str, str] | None, dict[str, str], dict[str, str]]
"""Context, higher and lower group."""


@brief
@dataclass(frozen=True, repr=False)
class DriftedRatio:
    """The worst and the best ratio within the declared drift, of the table or of the population.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio.
    worst, best : Fraction or float
        The greatest and the least ratio; of a population no ratio is beyond them at the confidence of its interval.
    worst_pair, best_pair : tuple or None
        The pair that attains each: context (None overall), higher and lower group; None where it is 1.
    scope : str
        What they hold for.

    Examples
    --------
    >>> import fairaudit as fa
    >>> law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    >>> result = fa.certify(law, {"yes": 1}, max_local_ratio="3/2", max_drift="1/20")
    >>> [(found.quantity, str(found.worst), str(found.best)) for found in result.drifted], result.verdict
    ([('local', '11/7', '1'), ('global', '11/7', '1')], 'depends')
    """

    quantity: Quantity
    worst: Extended
    best: Extended
    worst_pair: Pair | None
    best_pair: Pair | None
    scope: str
    assumptions: tuple[str, ...] = ()


def radius_of(result: Result, target: Target, moving: Mapping[Quantity, Moving]) -> TableRadius | None:
    """How far cells may move while the verdict on a target stands; None where there is nothing to say."""
    from fairaudit.theorems.t16 import law_radius

    plain = not target.under and target.unit != "difference" and target.verdict in ("within", "exceeds")
    if not plain or result.changed is not None:
        return None
    if target.confidence is not None:
        return _of_population(result, target)
    measured = result.local if target.quantity == "local" else result.global_
    if measured is None or target.quantity not in moving:
        return None
    at = moving[target.quantity]
    found: dict[Form, LawRadius] = {form: law_radius(at, measured.ratio, target.limit, target.unit, form) for form in ("radius", "factor")}
    one, other = found["radius"], found["factor"]
    pairs = [_labels(result, target.quantity, each.pair) for each in (one, other)]
    return TableRadius(one.verdict, one.value, one.exact, other.value, other.exact, pairs[0], pairs[1], of_population=False)


def _labels(result: Result, quantity: Quantity, pair: tuple[int, int] | None) -> Pair | None:
    law = result.law
    if pair is None:
        return None
    if quantity == "global":
        higher, lower = (law.group_label(law.global_groups[i]) for i in pair)
        return None, higher, lower
    higher, lower = (law.group_label(int(law.cell_group[i])) for i in pair)
    return law.context_label(int(law.cell_context[pair[0]])), higher, lower


def _of_population(result: Result, target: Target) -> TableRadius | None:
    """The radius of a verdict that rests on ends of single cells, which the interval proves."""
    from fairaudit.theorems.t16 import law_radius

    interval = result.intervals.get(target.quantity)
    moving = moving_ends(result, target.quantity, upper=target.verdict == "within")
    if interval is None or moving is None:
        return None
    end = interval.upper if target.verdict == "within" else interval.lower
    if interval_verdict((interval.lower, interval.upper), **{f"max_{target.unit}": target.limit}) != target.verdict:
        return None
    found = law_radius(moving, end, target.limit, target.unit, "radius")
    pair = None if found.pair is None else _labels_of_cells(result, target.quantity, found.pair)
    return TableRadius(found.verdict, found.value, False, None, False, pair, None, of_population=True)


def moving_ends(result: Result, quantity: Quantity, *, upper: bool) -> MovingEnds | None:
    """Cells between the ends that an interval proves; None where it proves none of single cells."""
    from fairaudit.inference.moving_ends import MovingEnds, ends_that_hold

    interval, comparison = result.intervals.get(quantity), result.comparisons.get(quantity)
    if interval is None or comparison is None or result.deployment is not None or result.changed is not None:
        return None
    ends = ends_that_hold(interval, comparison)
    return None if ends is None else MovingEnds(comparison, ends[0] if upper else ends[1])


def _labels_of_cells(result: Result, quantity: Quantity, pair: tuple[int, int]) -> Pair:
    """Labels of the positions among the cells that are compared."""
    listed = result.comparisons[quantity].labels
    flat = [(context, group) for context, groups in listed for group in groups]
    return flat[pair[0]][0], flat[pair[0]][1], flat[pair[1]][1]


def drifted_of(result: Result, drift: Fraction, moving: Mapping[Quantity, Moving]) -> Iterator[DriftedRatio]:
    """The worst and the best ratio within a declared drift, of the table and, where ends of single cells hold, of the population."""
    from fairaudit.theorems.t16 import drifted_extremes

    for quantity, at in moving.items():
        found = drifted_extremes(at, drift)
        if found is None:
            continue
        yield _ratio(quantity, found, [_labels(result, quantity, one.pair) for one in found], "this law")
    for quantity, interval in result.intervals.items():
        one, other = (moving_ends(result, quantity, upper=upper) for upper in (True, False))
        if one is None or other is None:
            continue
        worst, best = drifted_extremes(one, drift), drifted_extremes(other, drift)
        if worst is None or best is None:
            continue
        both = worst[0], best[1]
        pairs = [None if one.pair is None else _labels_of_cells(result, quantity, one.pair) for one in both]
        yield _ratio(quantity, both, pairs, f"{ONE_SIDED}{number(interval.confidence)}", interval.assumptions)


def _ratio(
    quantity: Quantity, found: tuple[Extreme, Extreme], pairs: Sequence[Pair | None], scope: str, assumptions: tuple[str, ...] = ()
) -> DriftedRatio:
    worst, best = found
    return DriftedRatio(quantity, worst.value, best.value, pairs[0], pairs[1], scope, assumptions)


def under_drift(result: Result) -> Result:
    """The same result with its targets judged within the declared drift."""
    targets = tuple(_judged(target, result) for target in result.targets)
    verdict = foremost_verdict(target.verdict for target in targets)
    return replace(result, targets=targets, verdict=verdict)


def _judged(target: Target, result: Result) -> Target:
    found = next(
        (d for d in result.drifted if d.quantity == target.quantity and d.scope.startswith("this law") == (target.confidence is None)), None
    )
    if found is None and target.confidence is not None and target.quantity in result.comparisons:
        raise InputError(
            f"max_drift needs ends of single cells, and the {target.quantity} interval here rests on pairs of cells, or on units; "
            "judge the table (confidence none), or leave out what bounds pairs (independent, unit)"
        )
    ends = (Fraction(1), inf) if found is None else (found.best, found.worst)
    verdict: Verdict = interval_verdict(ends, **{f"max_{target.unit}": target.limit})
    if verdict == "inconclusive" and target.confidence is None and found is not None:
        verdict = "depends"
    return replace(target, verdict=verdict, under=DRIFTING, upper=None)


# Claims


def evidence_of(
    result: Result, quantity: Quantity, pair: Pair | None, form: Form, amount: Extended, bound: Any, *, worst: bool
) -> dict[str, Any]:
    """Where a claim holds with equality, and the groups whose means a reader has to sum exactly."""
    named = None
    if pair is not None:
        named = {
            "context": None if pair[0] is None else list(pair[0].values()),
            "higher": list(pair[1].values()),
            "lower": list(pair[2].values()),
        }
    followed = _followed(result, pair, form, amount, bound, worst=worst) if quantity == "global" else []
    return {"pair": named, "followed": [list(result.law.groups[a]) for a in followed]}


def _followed(result: Result, pair: Pair | None, form: Form, amount: Extended, bound: Any, *, worst: bool) -> list[int]:
    """All groups that are compared, of many cells only those of the pair if a quick bound is enough for the others."""
    law, table = result.law, result.utility
    groups = list(law.global_groups)
    if len(law.weights) <= FEW_CELLS or pair is None or not table.by_decision or bound is None:
        return groups
    named = {tuple(label.values()) for label in pair[1:]}
    own = [a for a in groups if law.groups[a] in named]
    means = compared_expectations(law, table, within_context=False)[0]
    ends = {a: _quick(mean, form, amount, table.gamma, table.m, worst=worst) for a, mean in zip(groups, means, strict=True)}
    moving = result.moving["global"]
    for a in own:
        mean = moving.mean(groups.index(a))
        if amount == inf:
            ends[a] = Fraction(mean.most_seen, mean.bottom), Fraction(mean.least_seen, mean.bottom)
        else:
            ends[a] = tuple(mean.end(form, Fraction(amount), up=up) for up in (worst, not worst))  # type: ignore[assignment]
    greatest = max(quotient(ends[a][0], ends[b][1]) for a in groups for b in groups if a != b)
    return own if greatest <= bound else groups


def _quick(mean: Fraction, form: Form, amount: Extended, gamma: Fraction, m: Fraction, *, worst: bool) -> tuple[Fraction, Fraction]:
    """What the end of a greatest mean cannot exceed, and that of a least one not fall below, whatever the laws are."""
    if amount == inf:
        return (gamma, m) if worst else (mean, mean)
    by = Fraction(amount)
    if form == "factor" and worst:
        high, low = min(gamma - (gamma - mean) / by, m + (mean - m) * by), max(m + (mean - m) / by, gamma - (gamma - mean) * by)
        return high, low
    if form == "factor":
        return mean, mean
    if worst:
        return min(gamma, mean + by * (gamma - m)), max(m, mean - by * (gamma - m))
    return (1 - by) * mean + by * m, (1 - by) * mean + by * gamma


def radius_evidence(result: Result, target: Target, found: TableRadius, form: Form) -> dict[str, Any]:
    """The evidence of a claim about a radius, with the limit and the verdict that it belongs to."""
    from fairaudit.theorems.t16 import drifted_extremes

    value = found.radius if form == "radius" else found.factor
    pair = found.pair if form == "radius" else found.factor_pair
    amount: Extended = Fraction(1) if form == "radius" and value == inf else value or Fraction(0)
    if found.of_population:
        own = evidence_of(result, "local", pair, form, amount, None, worst=True)
    else:
        bound = target.limit if target.unit == "ratio" else None
        own = evidence_of(result, target.quantity, pair, form, amount, bound, worst=found.verdict == "within")
        if found.verdict == "within" and form == "radius" and bound is None and target.limit:
            # Before the radius, from which it is rounded inwards, another pair may be the greatest.
            worst = drifted_extremes(result.moving[target.quantity], Fraction(amount))
            if worst is None or _labels(result, target.quantity, worst[0].pair) != pair:
                own["pair"] = None
    return {**own, "limit": number(target.limit), "verdict": found.verdict}


def measures_drift(result: Result) -> dict[Quantity, Moving]:
    """What is compared in the table, by quantity, where drift is measured."""
    from fairaudit.theorems.t16 import Moving, can_drift

    if result.deployment is not None or result.partial is not None:
        return {}
    quantities: list[Quantity] = [q for q, measured in (("local", result.local), ("global", result.global_)) if measured is not None]  # type: ignore[misc]
    return {
        quantity: Moving(result.law, result.utility, quantity) for quantity in quantities if can_drift(result.law, result.utility, quantity)
    }


def refuse_drift(deployment: Deployment | None, table: UtilityTable, max_drift: Any, *, of_differences: bool, stream: bool) -> None:
    """Refuse a declared drift of a table of which nothing would follow from it.

    Raises
    ------
    InputError
        If differences are asked for, groups are unknown, the table is that of a stream, or a utility is not given.
    """
    if max_drift is None or deployment is not None:
        return
    if of_differences:
        raise InputError("max_drift is about ratios; leave out differences, and certify them by themselves")
    if table.law.unknown is not None:
        raise InputError("max_drift does not go with decisions of unknown group: one objection at a time; leave one of them out")
    if stream:
        raise InputError("max_drift is about a table that was counted once, not about a stream; leave it out")
    if table.given is not None:
        raise InputError("max_drift needs the utility of every decision in every cell, and some are not given; list them with utility")
