"""Verdicts: what an interval says of a target, and which of several verdicts stands for all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

from fairaudit.exact.enclosures import compare_log
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.inference.interval import Interval
from fairaudit.measures.limits import ALONE, one_limit, without_bare_limits

Verdict = Literal["none", "within", "exceeds", "inconclusive", "depends", "changed"]

SEVERITY: dict[str, int] = {"none": 0, "within": 1, "inconclusive": 2, "depends": 3, "exceeds": 4, "changed": 5}
"""The verdict on all targets is the severest: what is not known is no reason to pass, and a contradicted ratio leaves nothing to judge."""


def foremost_verdict(verdicts: Iterable[Verdict]) -> Verdict:
    """The verdict on all targets: the severest of theirs, "none" without any.

    Examples
    --------
    >>> foremost_verdict(["within", "inconclusive"]), foremost_verdict([])
    ('inconclusive', 'none')
    """
    return max(verdicts, key=SEVERITY.__getitem__, default="none")


def exit_code(verdict: Verdict, verdicts: Iterable[Verdict]) -> int:
    """0 within or no target, 1 a target is exceeded, 3 inconclusive, depends, or changed without an exceeded target.

    Parameters
    ----------
    verdict : {"none", "within", "exceeds", "inconclusive", "depends", "changed"}
        That on all targets.
    verdicts : iterable
        Those on each.

    Examples
    --------
    >>> exit_code("changed", ["changed", "exceeds"]), exit_code("changed", ["changed"])
    (1, 3)
    """
    if verdict == "changed":
        return 1 if "exceeds" in verdicts else 3
    return {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3, "depends": 3}[verdict]


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
        "within" if the upper end is at most the limit, "exceeds" if the lower end is above it; "inconclusive" if neither is so, and if both
        are, as may be where the ends cross.

    Examples
    --------
    >>> from fractions import Fraction
    >>> verdict((Fraction(1), Fraction(6, 5)), max_log=0.2), verdict((Fraction(1), Fraction(4, 3)), max_ratio="5/4")
    ('within', 'inconclusive')
    >>> verdict((Fraction(4, 3), Fraction(6, 5)), max_ratio="5/4")
    'inconclusive'
    """
    lower, upper = (interval.lower, interval.upper) if isinstance(interval, Interval) else interval
    unit, limit = one_limit(max_ratio, max_log)
    if unit == "ratio":
        within, exceeds = upper <= limit, lower > limit
    else:
        pair = (limit.numerator, limit.denominator)
        within, exceeds = compare_log(extended_pair(upper), pair) <= 0, compare_log(extended_pair(lower), pair) > 0
    return "inconclusive" if within == exceeds else "within" if within else "exceeds"
