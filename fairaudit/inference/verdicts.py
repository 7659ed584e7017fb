"""What an interval says of a target."""

from __future__ import annotations

from typing import Any, Literal

from fairaudit.exact.enclosures import compare_log
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.inference.interval import Interval
from fairaudit.measures.limits import ALONE, one_limit, without_bare_limits

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
    >>> from fractions import Fraction
    >>> verdict((Fraction(1), Fraction(6, 5)), max_log=0.2), verdict((Fraction(1), Fraction(4, 3)), max_ratio="5/4")
    ('within', 'inconclusive')
    """
    lower, upper = (interval.lower, interval.upper) if isinstance(interval, Interval) else interval
    unit, limit = one_limit(max_ratio, max_log)
    if unit == "ratio":
        return "within" if upper <= limit else "exceeds" if lower > limit else "inconclusive"
    pair = (limit.numerator, limit.denominator)
    if compare_log(extended_pair(upper), pair) <= 0:
        return "within"
    return "exceeds" if compare_log(extended_pair(lower), pair) > 0 else "inconclusive"
