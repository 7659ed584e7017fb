"""Hypotheses tested by intervals: a claimed ε, and an effect beside a noise floor."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import Extended, extended_text
from fairaudit.exact.rationals import option_value
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval, Region
from fairaudit.inference.levels import confidence_level, equal_share
from fairaudit.inference.ratio_intervals import ratio_interval


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
    said = f"the ratio{of} is at least {float(interval.lower):.6g} at confidence {extended_text(interval.confidence)}"
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
    each = 1 - equal_share(1 - level, 2)
    options: dict[str, Any] = {"method": method, "region": region, "independent": independent}
    first, second = (ratio_interval(comparison, each, **options) for comparison in (effect, placebo))
    rises = first.lower > second.upper
    shown_ends = [f"[{float(i.lower):.4g}, {float(i.upper):.4g}]" for i in (first, second)]
    relation = "rises above" if rises else "does not rise above"
    of = " (means over units)" if "mean over units" in (first.estimand, second.estimand) else ""
    sentence = (
        f"The ratio of the groups{of} lies in {shown_ends[0]}, that of the placebo in {shown_ends[1]}, both at confidence "
        f"{extended_text(level)}: the effect {relation} the noise floor."
    )
    return NoiseFloor(first, second, rises, sentence)
