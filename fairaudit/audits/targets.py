"""Limits that were asked for, and how each is judged: of the table exactly, or of the population by its intervals and bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING

from fairaudit.exact.enclosures import compare_log
from fairaudit.inference.comparisons import Estimand
from fairaudit.inference.interval import Interval
from fairaudit.inference.verdicts import Verdict, foremost_verdict
from fairaudit.inference.verdicts import verdict as interval_verdict
from fairaudit.measures.limits import Limit, Quantity, Unit, limit_readings, limit_text
from fairaudit.measures.ratios import Ratio
from fairaudit.theorems.bound import Bound
from fairaudit.theorems.registry import BY_KEY, for_any_sampled
from fairaudit.words import THE_INTERVAL, brief

if TYPE_CHECKING:
    from fairaudit.audits.unknown import Tips
    from fairaudit.inference.changes import Change

__all__ = ["Target"]


@brief
@dataclass(frozen=True, repr=False)
class Target:
    """A limit on the local or global measure, and how it was judged.

    Attributes
    ----------
    quantity : {"local", "global"}
        What is limited.
    limit : Fraction
        The limit: on L or L̄ (``unit="log"``, nats), on R or R̄ (``unit="ratio"``), or on a difference (``unit="difference"``).
    unit : {"log", "ratio", "difference"}
        Which of them.
    verdict : {"within", "exceeds", "inconclusive", "depends", "changed"}
        Decided exactly; inconclusive when nothing was compared, the draws do not decide, or they decide both ways because the ends cross;
        depends when what was not recorded could make it either; changed when a window contradicts the stream.
    confidence : Fraction or None
        What was judged: the population behind the draws, all targets together at this confidence, or, if None, the table itself.
    upper : tuple of (Fraction or float, str) or None
        Of a target about the population, the smallest sound upper end, and where it comes from: a theorem, or the interval.
    estimand : {"mean over rows", "mean over units"}
        Of which means the ratio is judged.
    under : str
        The objection that it takes into account, if any: "whoever the unknown are", "with the declared hidden context", "within the
        declared drift" or "whatever the undecided meant".
    tips : Tips or None
        With unknown groups: how many decisions of unknown group could not change what those with a group say by themselves.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> [(target.quantity, target.unit, target.limit, target.verdict) for target in result.targets]
    [('local', 'ratio', Fraction(5, 4), 'inconclusive')]
    """

    quantity: Quantity
    limit: Fraction
    unit: Unit
    verdict: Verdict
    confidence: Fraction | None = None
    upper: tuple[Fraction | float, str] | None = None
    estimand: Estimand = "mean over rows"
    under: str = ""
    tips: Tips | None = None

    @property
    def text(self) -> str:
        """The limit in all its readings, as people read it."""
        return limit_text(self.quantity, self.unit, self.limit)

    @property
    def readings(self) -> dict[str, list[str]]:
        """The readings of the limit as a program reads them: what is exact as a rational twice, the rest between two decimals."""
        return limit_readings(self.unit, self.limit)


def judged_by_window(targets: tuple[Target, ...], verdict: Verdict, change: Change) -> tuple[tuple[Target, ...], Verdict]:
    """Of ratios that changed, a target is exceeded if it is in the window; nothing else is said."""

    def judge(target: Target) -> Target:
        if target.quantity not in change.withdrawn:
            return target
        own = target.quantity == change.quantity and interval_verdict(change.part, **{f"max_{target.unit}": target.limit}) == "exceeds"
        return replace(target, verdict="exceeds" if own else "changed", upper=None)

    judged_ = {target.quantity for target in targets} or change.withdrawn
    return tuple(map(judge, targets)), "changed" if judged_ & change.withdrawn else verdict


def judged(
    measured: Mapping[Quantity, Ratio | None],
    limits: Sequence[Limit],
    confidence: Fraction | None,
    intervals: Mapping[Quantity, Interval],
    found: tuple[Bound, ...] = (),
    declared: Mapping[str, Fraction] | None = None,
    *,
    group_free: bool = True,
) -> tuple[tuple[Target, ...], Verdict]:
    """Judge limits: of the table itself exactly, or, at a confidence, of the population by its intervals and bounds."""
    usable = [
        bound
        for bound in found
        if bound.certified
        and for_any_sampled(BY_KEY[bound.quantity, "<=", bound.theorem, bound.scope], bound.scope, declared or {}, group_free=group_free)
    ]
    targets = tuple(
        Target(quantity, limit, unit, _judge(measured[quantity], limit, unit))
        if confidence is None
        else _judge_population(quantity, limit, unit, confidence, intervals.get(quantity), usable)
        for quantity, unit, limit in limits
    )
    return targets, foremost_verdict(target.verdict for target in targets)


def _judge(measured: Ratio | None, limit: Fraction, unit: str) -> Verdict:
    if measured is None:
        return "inconclusive"
    if unit == "ratio":
        return "within" if measured.ratio <= limit else "exceeds"
    return "within" if compare_log(measured.pair, (limit.numerator, limit.denominator)) <= 0 else "exceeds"


def _judge_population(
    quantity: Quantity,
    limit: Fraction,
    unit: Unit,
    confidence: Fraction,
    interval: Interval | None,
    usable: Sequence[Bound],
) -> Target:
    """Judge a target for whatever law or policy was sampled: by its interval, and by theorems that rest on declared constants only."""
    ends: list[tuple[Fraction | float, str]] = []
    if interval is not None:
        ends.append((interval.upper, THE_INTERVAL))
    ends += [(bound.value, bound.theorem) for bound in usable if bound.quantity == f"{quantity}_ratio"]
    upper = min(ends, key=lambda end: end[0], default=None)
    lower = interval.lower if interval is not None else Fraction(1)
    verdict = interval_verdict((lower, upper[0] if upper else inf), **{f"max_{unit}": limit})
    return Target(quantity, limit, unit, verdict, confidence, upper, interval.estimand if interval is not None else "mean over rows")
