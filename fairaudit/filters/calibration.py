"""Which ε, and which keep probability, for a target: the least privacy whose guarantee is at or under it.

A rule for every policy has a guarantee that grows with the keep probability of a randomized response: with a smaller one, from one
over the number of values on, the release is that of the greater one, released once more at random, so that a policy behind it is also
one behind the greater. The answer is the greatest keep probability on a grid of 10⁻¹² whose guarantee, computed exactly at the filter
that is returned, does not exceed the target; or the greatest at all, where that is a short fraction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, prod
from typing import Any, Literal

from fairaudit.errors import Infeasible, InputError, nearest, shown
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.exact.rationals import Number, at_least
from fairaudit.filters.groups import Groups, read_attributes
from fairaudit.filters.responses import GRID, SEARCH_STEPS, SPLITS, ResponseLine, Split, identity_filter, response_factor, rounded_keep
from fairaudit.filters.targets import calibration_target, ratio_and_log
from fairaudit.measures.limits import ALONE, Quantity, without_bare_limits
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.currencies import Enclosure
from fairaudit.privacy.epsilon_delta import epsilon_enclosure
from fairaudit.theorems.assumptions import INDEPENDENT, POPULATION
from fairaudit.theorems.bound import ANY_POLICY, Bound
from fairaudit.theorems.t01 import floor_cap, t1_paper, t1_tight
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t03 import t3_approx
from fairaudit.theorems.t12 import t12
from fairaudit.theorems.t13_range import UtilityRange, in_each_range, read_utility_range, t13_range
from fairaudit.words import brief

Rule = Literal["exact", "sharp", "tight", "paper", "contraction"]


RULES: tuple[Rule, ...] = ("exact", "sharp", "tight", "paper", "contraction")

MAX_VALUES = 10_000
"""Values of one attribute: the filter is a square table over them, of which a product of filters is computed with."""

SHORT = 1_000_000
"""A fraction with a denominator of at most so much, less than half a step of the grid beyond what was found, is tried too."""

UNNEEDED = "the target holds without any filter; no privacy is needed"


@brief
@dataclass(frozen=True, repr=False)
class Calibration:
    """A filter for a target, or why there is none.

    Attributes
    ----------
    quantity : {"local", "global"}
        What the target limits.
    target : Fraction
        The target as a ratio R*, rounded down where it was given as a logarithm.
    rule : str
        Which guarantee was used.
    feasible : bool
        Whether a filter was found that meets the target.
    mechanism : Mechanism or None
        The filter; the identity if no privacy is needed, None if infeasible.
    keep_probabilities : tuple of Fraction
        Probability of releasing the truth, for each attribute; empty if infeasible.
    exp_epsilon : Fraction or float
        e^ε of the whole filter: of the tuple, not of one attribute; infinite for the identity.
    achieved : Fraction or None
        The guarantee at this filter, exact and at most the target; None if infeasible.
    scope : str
        What the guarantee covers.
    assumptions : tuple of str
        What the reader must judge.
    paper_keep_probabilities : tuple of Fraction
        What the paper's rule would keep; empty if it finds no filter, or there is no floor for it to use.
    reason : str
        Why it is infeasible and what would make it feasible, or why no privacy is needed.
    settled : bool
        Whether an infeasible target is proved to be so: by this rule, for every filter of this kind. If not, none was found.

    Examples
    --------
    >>> import fairaudit as fa
    >>> found = fa.calibrate(max_ratio="5/4", groups=2, tau="0.5")
    >>> found.require().keep_probabilities, found.achieved <= found.target
    ((Fraction(4, 7),), True)
    """

    quantity: Quantity
    target: Fraction
    rule: str
    feasible: bool
    mechanism: Mechanism | None
    keep_probabilities: tuple[Fraction, ...]
    exp_epsilon: Extended
    achieved: Extended | None
    scope: str
    assumptions: tuple[str, ...]
    paper_keep_probabilities: tuple[Fraction, ...] = ()
    reason: str = ""
    settled: bool = True

    def require(self) -> Calibration:
        """Give itself back, or refuse to go on without a filter.

        Raises
        ------
        Infeasible
            If no filter was found; the message is the reason.
        """
        if not self.feasible:
            raise Infeasible(self.reason)
        return self

    @property
    def epsilon(self) -> Enclosure:
        """Enclosure of ε of the whole filter, in nats."""
        return epsilon_enclosure(extended_pair(self.exp_epsilon))


@dataclass(frozen=True)
class _Setting:
    """The numbers of a calibration, exact."""

    gamma: Fraction
    tau: Fraction
    g_min: Fraction
    delta: Fraction
    gap: Fraction
    raw: Extended | None
    declared: UtilityRange


@without_bare_limits(ALONE)
def calibrate(
    *,
    max_ratio: Number | None = None,
    max_log: Number | None = None,
    quantity: Quantity = "local",
    groups: Groups,
    bound: Rule = "exact",
    gamma: Number = 1,
    tau: Number = 0,
    g_min: Number = 0,
    delta: Number = 0,
    lipschitz: Number = 0,
    diameter: Number = 1,
    raw_ratio: Number | None = None,
    split: Split = "equal-epsilon",
) -> Calibration:
    """Find the randomized response that keeps most truth and still guarantees a target.

    Parameters
    ----------
    max_ratio : number or str, optional
        Target for the ratio, R* > 1; one under 1 is least over greatest, so that 0.8 is 5/4.
    max_log : number or str, optional
        Target L* > 0 for its natural logarithm; exactly one of the two is given.
    quantity : {"local", "global"}
        What the target is for: R and L, or R̄ and L̄, whose target is met through L and needs context and group to be independent (T5).
    groups : int, sequence, or mapping of name to int or sequence
        Number (or labels) of the values of the attribute, or of each of several attributes that are filtered independently.
    bound : {"exact", "sharp", "tight", "paper", "contraction"}
        Which guarantee: the exact one for the very filter (T13: every policy, every utility of this range); T3 or T1 for its ε and `delta`,
        in their sharp, additive or the paper's form; T12 from `raw_ratio`, or from γ/g_min, which bounds the ratio of every policy.
    gamma, g_min : number or str
        Greatest and least utility. A least utility above 0 is a floor that every policy keeps.
    tau : number or str
        A floor of every group's expected utility behind the filter, to be declared; 0 for none.
    delta : number or str
        δ of the (ε,δ)-privacy that is asked for, where the rule knows the filter by ε and δ alone: "sharp", "tight", "paper". The
        randomized response that is returned has δ = 0.
    lipschitz, diameter : number or str
        L_A and diam of the utility; their product is the greatest difference of utility between two groups for the same decision and
        context.
    raw_ratio : number or str, optional
        The policy's own worst ratio over released values, for "contraction".
    split : {"equal-epsilon", "equal-keep", "most-truth"}
        How several attributes share: the same ε, the same keep probability, or the greatest probability that the whole tuple is true.

    Returns
    -------
    Calibration
        The filter with its guarantee re-checked, or why the target is infeasible. Source: section 4 of docs/theory.md.

    Raises
    ------
    InputError
        If a number is out of range, or a combination makes no sense.

    Examples
    --------
    >>> found = calibrate(max_log="0.2", groups=16, gamma=1, tau="0.3")
    >>> round(float(found.keep_probabilities[0]), 3), round(float(found.paper_keep_probabilities[0]), 3)
    (0.125, 0.075)
    """
    target = calibration_target(max_ratio, max_log, quantity)
    attributes = read_attributes(groups, MAX_VALUES)
    if bound not in RULES:
        raise InputError(f"bound={shown(bound)} is not accepted; {nearest(str(bound), RULES)}")
    if split not in SPLITS:
        raise InputError(f"split={shown(split)} is not accepted; {nearest(str(split), SPLITS)}")
    named = {"gamma": gamma, "tau": tau, "g_min": g_min, "delta": delta, "lipschitz": lipschitz, "diameter": diameter}
    setting = _setting(named, raw_ratio, bound)
    independent = (INDEPENDENT, POPULATION) if quantity == "global" else ()
    found = _search(target, bound, setting, attributes, split)
    paper = found if bound == "paper" else _search(target, "paper", setting, attributes, split)
    return replace(
        found,
        quantity=quantity,
        assumptions=(*found.assumptions, *independent),
        paper_keep_probabilities=paper.keep_probabilities,
    )


def calibrate_range(target: Fraction, groups: Groups, declared: UtilityRange) -> Calibration:
    """The calibration that is exact for a range of utilities, with or without a floor."""
    return calibrate(max_ratio=target, groups=groups, gamma=declared.gamma, tau=declared.tau, g_min=declared.m, lipschitz=declared.gap)


def _search(target: Fraction, rule: Rule, setting: _Setting, attributes: Mapping[str, tuple[Any, ...]], split: Split) -> Calibration:
    """Calibrate by one rule; the quantity is filled in by the caller."""
    guarantee = _guarantee(rule, setting)
    bare = identity_filter(attributes)
    if setting.tau > 0 and target * setting.tau >= setting.gamma and rule != "contraction":
        cap = guarantee(bare) if rule == "exact" else _for_every_policy(floor_cap(setting.gamma, setting.tau, floor="declared"), setting)
        return _result(target, rule, bare, cap, "the floor alone keeps the ratio under the target; no privacy is needed")

    def value(mechanism: Mechanism) -> Extended:
        return guarantee(mechanism).value

    def on_line(line: ResponseLine) -> Calibration:
        known = greatest_keep(target, line, setting.declared) if rule == "exact" else None
        return climb(target, rule, line, value, known)

    found = best_tilt(on_line, attributes, split)
    if found.mechanism is None:
        hidden = guarantee(ResponseLine(attributes, split).on_grid(0))
        return replace(found, reason=_why(rule, setting, hidden.value), scope=hidden.scope)
    proof = guarantee(found.mechanism)
    return replace(found, scope=proof.scope, assumptions=premises(proof))


def greatest_keep(target: Fraction, line: ResponseLine, declared: UtilityRange) -> Fraction | None:
    """The greatest keep probability of one attribute without a floor, in closed form; None where there is no such form.

    For V = R* ≥ 1 only the first column of the pairs counts in H_V = max(0, p − V·q) with q = (1 − p)/(k − 1).

    Source: T13.
    """
    if len(line.attributes) > 1 or declared.tau or not declared.span:
        return None
    (size,) = (len(values) for values in line.attributes.values())
    room = (declared.m * (target - 1) - declared.gap) / declared.span
    return ((size - 1) * room + target) / (size - 1 + target) if room >= 0 else None


def climb(
    target: Fraction, rule: str, line: ResponseLine, value: Callable[[Mechanism], Extended], known: Fraction | None = None
) -> Calibration:
    """The greatest filter of a line whose value, which grows along it, is at most the target; `known` is its keep probability."""
    bare = identity_filter(line.attributes)
    without = value(bare)
    if without <= target:
        return calibrated(target, rule, bare, without, UNNEEDED)
    if known is not None:
        mechanism = line.filters([known if known.denominator <= GRID else rounded_keep(known)])
        return _rechecked(target, rule, mechanism, value)
    if value(line.on_grid(0)) > target:
        return Calibration("local", target, rule, False, None, (), inf, None, "", ())
    low, high = 0, SEARCH_STEPS
    while high - low > 1:
        middle = (low + high) // 2
        if value(line.on_grid(middle)) <= target:
            low = middle
        else:
            high = middle
    last = line.on_grid(low)
    if len(last.factors) == 1:
        short = (_keep(last, 0) + Fraction(1, 2 * GRID)).limit_denominator(SHORT)
        if short > _keep(last, 0) and value(line.filters([short])) <= target:
            last = line.filters([short])
    return _rechecked(target, rule, last, value)


def _keep(mechanism: Mechanism, attribute: int) -> Fraction:
    """The probability that an attribute is released as it is."""
    factor = mechanism.factors[attribute]
    return Fraction(factor.rows[0][0], factor.denominator)


def _rechecked(target: Fraction, rule: str, mechanism: Mechanism, value: Callable[[Mechanism], Extended]) -> Calibration:
    achieved = value(mechanism)
    if achieved > target:
        raise InputError("the guarantee of the filter that was found exceeds the target; this is a fault of the program, please report it")
    return calibrated(target, rule, mechanism, achieved, "")


def calibrated(target: Fraction, rule: str, mechanism: Mechanism, achieved: Extended, reason: str) -> Calibration:
    """A calibration that found a filter; what it covers is filled in by the caller."""
    keeps = tuple(_keep(mechanism, i) for i in range(len(mechanism.factors)))
    return Calibration("local", target, rule, True, mechanism, keeps, response_factor(mechanism), achieved, "", (), reason=reason)


def _result(target: Fraction, rule: str, mechanism: Mechanism, proof: Bound, reason: str) -> Calibration:
    return replace(calibrated(target, rule, mechanism, proof.value, reason), scope=proof.scope, assumptions=premises(proof))


def premises(proof: Bound) -> tuple[str, ...]:
    """What the reader of a guarantee must judge."""
    return tuple(text for text in proof.assumptions if not text.startswith("the group filter multiplies"))


def _guarantee(rule: Rule, s: _Setting) -> Callable[[Mechanism], Bound]:
    """The bound of a rule as a function of the filter."""
    if rule == "exact":
        return lambda mechanism: _exact(mechanism, s.declared)

    def guarantee(mechanism: Mechanism) -> Bound:
        factor = response_factor(mechanism)
        if rule == "contraction":
            return t12(factor, s.gamma / s.g_min if s.raw is None else s.raw)
        if s.tau == 0:
            if s.gap == 0 and s.delta == 0:
                return t2(factor)
            return t1_tight(factor, s.delta, s.gamma, s.tau, s.gap, floor="declared")
        if rule == "paper":
            return t1_paper(factor, s.delta, s.gamma, s.tau, s.gap, floor="declared")
        if rule == "tight":
            return t1_tight(factor, s.delta, s.gamma, s.tau, s.gap, floor="declared")
        return t3_approx(factor, s.delta, s.tau / s.gamma, floor="declared")

    return lambda mechanism: _for_every_policy(guarantee(mechanism), s)


def _exact(mechanism: Mechanism, declared: UtilityRange) -> Bound:
    """T13 for every policy and every utility of the range; T2 says it of every utility that ignores the group, whatever its range."""
    if declared.tau == declared.m == declared.gap == 0:
        return t2(response_factor(mechanism))
    return t13_range(in_each_range(mechanism, [declared]), floored=declared.tau > 0)


def _for_every_policy(proof: Bound, s: _Setting) -> Bound:
    """The same bound, about every policy where the least utility is the floor: no policy can go below it."""
    if s.g_min == 0 or s.raw is not None or s.tau > s.g_min:
        return proof
    kept = (text for text in proof.assumptions if not text.endswith("(declared)"))
    return replace(proof, scope=ANY_POLICY, assumptions=(*kept, f"no utility is below {s.g_min}"))


def best_tilt(climb: Callable[[ResponseLine], Calibration], attributes: Mapping[str, tuple[Any, ...]], split: Split) -> Calibration:
    """Climb one line; for "most-truth", tilt the odds of single attributes as long as the whole tuple is true more often.

    For a given ε of the tuple the common keep probability is already the best: the gain d(log p)/dε = 1 − p is then the same for all
    attributes that are kept above 1/k. Guarantees that look at more than ε may leave a little to gain.
    """
    best = climb(ResponseLine(attributes, split))
    if split != "most-truth" or len(attributes) == 1 or not best.feasible or best.exp_epsilon == inf:
        return best
    tilts = (Fraction(1),) * len(attributes)
    stride = Fraction(1, 2)
    while stride >= Fraction(1, 32):
        improved = False
        for i in range(len(tilts)):
            for factor in (1 + stride, 1 / (1 + stride)):
                tried = tuple(tilt * factor if i == j else tilt for j, tilt in enumerate(tilts))
                found = climb(ResponseLine(attributes, split, tried))
                if found.feasible and prod(found.keep_probabilities) > prod(best.keep_probabilities):
                    best, tilts, improved = found, tried, True
        if not improved:
            stride /= 2
    return best


def _setting(named: Mapping[str, Any], raw_ratio: Any, rule: Rule) -> _Setting:
    exact = {name: at_least(name, value, 0) for name, value in named.items()}
    given = {name: shown(value) for name, value in named.items()}
    gap = exact["lipschitz"] * exact["diameter"]
    top, low, least = exact["gamma"], exact["tau"], exact["g_min"]
    if top == 0:
        raise InputError("gamma is 0; a utility that is always 0 treats everybody alike, and needs no filter")
    if exact["delta"] > 1:
        raise InputError(f"delta is {given['delta']}; a probability from 0 to 1 is accepted")
    for name, value in (("tau", low), ("g_min", least)):
        if value > top:
            raise InputError(f"{name} is {given[name]}, above gamma, which is {given['gamma']}; no utility can be above the greatest")
    if rule == "exact" and exact["delta"]:
        raise InputError(
            f'delta is {given["delta"]}, but bound="exact" looks at the very filter, whose delta is 0; leave it out, or use "tight"'
        )
    if rule == "contraction" and low:
        raise InputError(f"tau is {given['tau']}, but the contraction needs no floor; leave it out, or use another bound")
    declared = read_utility_range(top, least, gap, low if low > least else 0)
    # The least utility is itself a floor.
    low = max(low, least)
    raw = _raw_ratio(raw_ratio, rule, gap, exact["delta"], least)
    if rule == "sharp" and gap:
        raise InputError('bound="sharp" is for a utility that does not depend on the group; use "exact" or "tight" with lipschitz above 0')
    return _Setting(top, low, least, exact["delta"], gap, raw, declared)


def _raw_ratio(raw_ratio: Any, rule: Rule, gap: Fraction, delta: Fraction, least: Fraction) -> Extended | None:
    raw: Extended | None = None
    if rule == "contraction":
        if gap or delta:
            raise InputError("the contraction holds for delta = 0 and a utility that does not depend on the group (lipschitz 0)")
        if raw_ratio is not None:
            raw = inf if raw_ratio == "inf" else at_least("raw_ratio", raw_ratio, 1)
            if least:
                raise InputError("raw_ratio and g_min were both given; the contraction starts from one of them, for this policy or for all")
        elif least == 0:
            raise InputError(
                "the contraction needs raw_ratio, the policy's own ratio, or g_min above 0, which bounds the ratio of every policy"
            )
    elif raw_ratio is not None:
        raise InputError('raw_ratio goes with bound="contraction"')
    return raw


def _why(rule: Rule, s: _Setting, hidden: Extended) -> str:
    """Why even a filter that hides everything does not guarantee the target by this rule, and what would."""
    if hidden == inf:
        return (
            "without a floor no filter helps: a group may get nothing where another gets something, since the utility depends on the "
            "group or delta is positive; declare a floor tau or a least utility g_min above 0, or use a utility that does not depend on "
            "the group with delta = 0"
        )
    causes = []
    if s.gap:
        causes.append("the utility itself differs between groups (a smaller lipschitz or diameter helps)")
    if s.delta:
        causes.append("delta is positive (a smaller delta helps)")
    said = " and ".join(causes) or "this rule is too coarse"
    ratio, logarithm = ratio_and_log(Fraction(hidden))
    return (
        f"even a filter that hides everything guarantees only a ratio of {ratio} by this rule, because {said}; "
        f"a higher floor tau, or a target of at least {ratio} (log {logarithm}), is feasible"
        + ("" if rule in ("exact", "contraction") else '; so may be bound="exact"')
    )
