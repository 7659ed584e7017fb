"""Hypotheses tested by intervals: a claimed ε, and an effect beside a noise floor."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import Extended, extended_text
from fairaudit.exact.rationals import Number, option_value
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.draws import unit_columns
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval, Region
from fairaudit.inference.levels import confidence_level, equal_share
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.theorems.assumptions import FRESH
from fairaudit.words import brief

__all__ = ["EpsilonRefutation", "NoiseFloor", "noise_floor", "refute_epsilon"]


@brief
@dataclass(frozen=True, repr=False)
class EpsilonRefutation:
    """What end-to-end draws say about a claimed ε (T11), and what must be accepted for that.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> fa.refute_epsilon(result.comparisons["local"], "1.01").refuted
    False
    """

    refuted: bool
    interval: Interval
    exp_epsilon: Extended
    sentence: str
    assumptions: tuple[str, ...] = ()


@brief
@dataclass(frozen=True, repr=False)
class NoiseFloor:
    """An effect beside the ratio under edits that should not matter; both intervals hold together at the stated confidence.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> fa.noise_floor(result.comparisons["local"], result.comparisons["local"]).rises
    False
    """

    effect: Interval
    placebo: Interval
    rises: bool
    sentence: str


@answered
def refute_epsilon(
    comparison: Comparison,
    exp_epsilon: Number,
    confidence: Number = "0.95",
    *,
    method: Method = "hoeffding-kl",
    region: Region = "box",
    independent: bool = False,
) -> EpsilonRefutation:
    """Test a claimed ε by decisions drawn end to end, at true contexts and groups, through the deployed filter (T11).

    Every draw needs a release of its own. Decisions through one release are one draw of the filter, however many they are: the release is
    then the sampling unit (`Law.from_log` with ``unit=``), and what is tested is the ratio of the means over releases, to which T11
    applies as well, as long as how many decisions a release has depends on nothing but the context and itself.

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
    EpsilonRefutation
        Refuted if the lower end of R is above e^ε: then the filter is not ε-private, or its draws are not fresh and independent, except
        with probability 1 − confidence. Not refuted is no proof of anything.

    Raises
    ------
    InputError
        If e^ε is below 1, or cells of a context differ in their range, so that g depends on the group.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no"] * 2, "sex": ["f", "f", "m", "m"], "n": [900, 100, 100, 900]}
    >>> draws = fa.audit(table, decision="hired", group="sex", count="n", utility="yes").comparisons["local"]
    >>> refute_epsilon(draws, 2).refuted, refute_epsilon(draws, 9).refuted
    (True, False)
    """
    infinite = exp_epsilon == inf or exp_epsilon == "inf"
    claimed: Extended = inf if infinite else Fraction(*option_value(exp_epsilon))
    if claimed < 1:
        raise InputError(f"e^ε = {shown(exp_epsilon)} is not accepted; it is at least 1")
    if any(
        len({(comparison.cells[i].low, comparison.cells[i].high) for form in block for i, _ in form}) > 1 for block in comparison.blocks
    ):
        raise InputError("the range of the utility differs between groups; a utility that depends on the group refutes nothing")
    interval = ratio_interval(comparison, confidence, method=method, region=region, independent=independent, ends="lower")
    refuted = interval.lower > claimed
    of = " of the means over units" if interval.estimand == "mean over units" else ""
    said = f"the ratio{of} is at least {float(interval.lower):.6g} at confidence {extended_text(interval.confidence)}"
    if refuted:
        sentence = f"{said}, above e^ε = {shown(str(exp_epsilon))}: the filter is not what it claims, or its draws are not independent."
    else:
        sentence = f"{said}, not above e^ε = {shown(str(exp_epsilon))}: these draws do not refute the claim, and prove nothing for it."
    if comparison.units is None:
        shared = "Every decision counts as one release of the filter; if some shared a release, name it as the sampling unit (--unit)."
    else:
        shared = f"Every unit of {unit_columns(comparison.units)} counts as one release of the filter, however many decisions it has."
    return EpsilonRefutation(refuted, interval, claimed, f"{sentence} {shared}", (FRESH, *interval.assumptions))


@answered
def noise_floor(
    effect: Comparison,
    placebo: Comparison,
    confidence: Number = "0.95",
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

    Examples
    --------
    >>> import fairaudit as fa
    >>> def compared(yes_f, yes_m):
    ...     table = {"hired": ["yes", "no"] * 2, "sex": ["f", "f", "m", "m"], "n": [yes_f, 1000 - yes_f, yes_m, 1000 - yes_m]}
    ...     return fa.audit(table, decision="hired", group="sex", count="n", utility="yes").comparisons["local"]
    >>> noise_floor(compared(600, 300), compared(500, 490)).rises
    True
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
