"""Which ε, and which keep probability, for a target: the least privacy whose guarantee is at or under it.

A rule for every policy has a guarantee that grows with the keep probability of a randomized response. The answer is the greatest keep
probability on a grid of 10⁻¹² whose guarantee, computed exactly at the filter that is returned, does not exceed the target. The ratio of a
known policy may fall and rise again where the utility depends on the group: E(a) ≤ R*·E(a') are then polynomials in one number, linear
for one attribute, and the greatest point at which all hold is found exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from itertools import chain, pairwise, permutations
from math import inf, log, prod
from typing import Any, Literal

from fairaudit import bounds
from fairaudit.bernstein import coefficients, greatest_nonnegative
from fairaudit.bounds import Bound
from fairaudit.exact import InputError, exp_enclosure, log_enclosure, nearest, option_value, shown
from fairaudit.fairness import compared_expectations, global_fairness, local_fairness
from fairaudit.law import Law
from fairaudit.limits import ALONE, Quantity, one_limit, without_bare_limits
from fairaudit.mechanism import Identity, Mechanism, Product, RandomizedResponse
from fairaudit.policy import Policy
from fairaudit.utility import Utility, UtilityTable

__all__ = ["Calibration", "alphabets", "calibrate", "calibrate_policy"]

Rule = Literal["paper", "tight", "sharp", "mechanism", "contraction"]
Split = Literal["equal-epsilon", "equal-keep", "most-truth"]
Blocks = list[list[Fraction]]

RULES: tuple[Rule, ...] = ("paper", "tight", "sharp", "mechanism", "contraction")
QUANTITIES: tuple[Quantity, ...] = ("local", "global")
SPLITS: tuple[Split, ...] = ("equal-epsilon", "equal-keep", "most-truth")
GRID = 10**12
TARGET_BITS = 80
SEARCH_STEPS = 1 << 50
UNNEEDED = "the target holds without any filter; no privacy is needed"


@dataclass(frozen=True)
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
    """

    quantity: Quantity
    target: Fraction
    rule: str
    feasible: bool
    mechanism: Mechanism | None
    keep_probabilities: tuple[Fraction, ...]
    exp_epsilon: Fraction | float
    achieved: Fraction | float | None
    scope: str
    assumptions: tuple[str, ...]
    paper_keep_probabilities: tuple[Fraction, ...] = ()
    reason: str = ""
    settled: bool = True

    @property
    def epsilon(self) -> tuple[Decimal, Decimal]:
        """Enclosure of ε of the whole filter, in nats."""
        lo, hi = log_enclosure(
            (self.exp_epsilon.numerator, self.exp_epsilon.denominator) if isinstance(self.exp_epsilon, Fraction) else (1, 0)
        )
        return Decimal(lo), Decimal(hi)


@dataclass(frozen=True)
class _Setting:
    """The numbers of a calibration, exact."""

    gamma: Fraction
    tau: Fraction
    g_min: Fraction
    delta: Fraction
    gap: Fraction
    raw: Fraction | float | None


@without_bare_limits(ALONE)
def calibrate(
    *,
    max_ratio: Any = None,
    max_log: Any = None,
    quantity: Quantity = "local",
    groups: int | Sequence[Any] | Mapping[str, int | Sequence[Any]],
    bound: Rule = "mechanism",
    gamma: Any = 1,
    tau: Any = 0,
    g_min: Any = 0,
    delta: Any = 0,
    lipschitz: Any = 0,
    diameter: Any = 1,
    raw_ratio: Any = None,
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
    bound : {"mechanism", "sharp", "tight", "paper", "contraction"}
        Which guarantee: T3 for the very filter; T3 or T1 for its ε and `delta`, in their sharp, additive or the paper's form; T12 from
        `raw_ratio`, or from γ/g_min, which bounds the ratio of every policy.
    gamma, g_min : number or str
        Greatest and least utility. A least utility above 0 is a floor that every policy keeps (T4).
    tau : number or str
        A floor of every group's expected utility behind the filter, to be declared; 0 for none.
    delta : number or str
        δ of the (ε,δ)-privacy that is asked for, where the rule knows the filter by ε and δ alone: "sharp", "tight", "paper". The
        randomized response that is returned has δ = 0.
    lipschitz, diameter : number or str
        L_A and diam of the utility; their product is the greatest difference between groups.
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
    target = _target(max_ratio, max_log, quantity)
    attributes = _attributes(groups)
    if bound not in RULES:
        raise InputError(f"bound={shown(bound)} is not accepted; {nearest(str(bound), RULES)}")
    if split not in SPLITS:
        raise InputError(f"split={shown(split)} is not accepted; {nearest(str(split), SPLITS)}")
    setting = _setting(gamma, tau, g_min, delta, lipschitz, diameter, raw_ratio, bound)
    independent = (bounds.INDEPENDENT, bounds.POPULATION) if quantity == "global" else ()
    found = _search(target, bound, setting, attributes, split)
    paper = found if bound == "paper" else _search(target, "paper", setting, attributes, split)
    return replace(
        found,
        quantity=quantity,
        assumptions=(*found.assumptions, *independent),
        paper_keep_probabilities=paper.keep_probabilities,
    )


@without_bare_limits(ALONE)
def calibrate_policy(
    policy: Policy,
    utility: Utility | Mapping[Any, Any],
    *,
    max_ratio: Any = None,
    max_log: Any = None,
    quantity: Quantity = "local",
    population: Any = None,
    split: Split = "equal-epsilon",
) -> Calibration:
    """Find the randomized response that keeps most truth and whose induced law, measured exactly, meets a target.

    Without filters on the context. For one attribute the answer is the greatest keep probability from 1/k on that meets the target
    (rounded down to 10⁻¹² where that meets it too), and an infeasible target is proved to be so: the ratio may fall and rise again where
    the utility depends on the group, or the target is for L̄, and all its pieces are looked at. With several attributes the same is
    done along one line of filters, the `split`; whether another combination meets a target that none on it meets is then left open,
    except where the measure cannot fall as the keep probabilities grow (T9: L, and a utility that ignores the group).

    Parameters
    ----------
    policy : Policy
        The known policy; its group alphabet is filtered.
    utility : Utility or mapping
        g.
    max_ratio, max_log, quantity
        As in `calibrate`.
    population : array_like, mapping or Law, optional
        As in `Policy.behind`.
    split : {"equal-epsilon", "equal-keep", "most-truth"}
        As in `calibrate`.

    Returns
    -------
    Calibration
        The filter; scope "this law".

    Raises
    ------
    InputError
        As in `calibrate`, and if the policy lacks a combination of its attributes' values.
    """
    target = _target(max_ratio, max_log, quantity)
    attributes = alphabets(policy)
    wanted = utility if isinstance(utility, Utility) else Utility(utility)
    measure = local_fairness if quantity == "local" else global_fairness

    def value(mechanism: Mechanism) -> Fraction | float:
        found = measure(*_induced(policy, mechanism, population, wanted))
        return inf if found is None else found.ratio

    def blocks(mechanism: Mechanism) -> Blocks:
        return compared_expectations(*_induced(policy, mechanism, population, wanted), within_context=quantity == "local")

    without = measure(*(unfiltered := _induced(policy, _identity(attributes), population, wanted)))
    if without is None:
        raise InputError("no two groups are compared, so that there is no ratio to calibrate for")
    if without.ratio <= target:
        found = _answer(target, "policy", _identity(attributes), without.ratio, UNNEEDED)
    else:
        found = _best_tilt(lambda line: _greatest(target, line, blocks, value), attributes, split)
    if not found.feasible:
        rises = quantity == "local" and not unfiltered[1].depends_on_group
        settled = found.settled and (len(attributes) == 1 or rises)
        found = replace(found, settled=settled, reason=_why_not(attributes, split, settled=settled))
    return replace(found, quantity=quantity, scope=bounds.THIS_LAW, assumptions=(bounds.FRESH,))


def _induced(policy: Policy, mechanism: Mechanism, population: Any, utility: Utility) -> tuple[Law, UtilityTable]:
    table = utility.on(policy.behind(group=mechanism, population=population).law)
    return table.law, table


def _greatest(
    target: Fraction, line: _Line, blocks: Callable[[Mechanism], Blocks], value: Callable[[Mechanism], Fraction | float]
) -> Calibration:
    """The last filter of a line whose induced law meets the target, found from polynomials and measured again."""
    settled = True
    for low, high, rising in line.pieces():
        places = [low + (high - low) * Fraction(j, max(1, len(rising))) for j in range(len(rising) + 1)]
        scaled = [[[e * line.weight(s, rising) for e in block] for block in blocks(line.filters(line.keeps(s)))] for s in places]
        constraints = [
            _constraints(target, [coefficients(values) for values in zip(*block, strict=True)]) for block in zip(*scaled, strict=True)
        ]
        point, sure = greatest_nonnegative(list(chain(*constraints)), low, high)
        if point is not None:
            return _measured(target, line, line.keeps(point), value)
        settled &= sure
    return Calibration("local", target, "policy", False, None, (), inf, None, "", (), settled=settled)


def _constraints(target: Fraction, means: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    """target·E(a') − E(a) for each ordered pair of groups, except where the coefficients alone show that it is nonnegative."""
    ends = [(max(mean), target * min(mean)) for mean in means]
    return [
        [target * below - above for above, below in zip(means[i], means[j], strict=True)]
        for i, j in permutations(range(len(means)), 2)
        if ends[i][0] > ends[j][1]
    ]


def _measured(target: Fraction, line: _Line, keeps: Sequence[Fraction], value: Callable[[Mechanism], Fraction | float]) -> Calibration:
    """The filter with these keep probabilities; with decimals of 12 digits instead of long fractions where those meet the target too."""
    short = all(keep.denominator <= GRID for keep in keeps)
    for tried in (keeps,) if short else ([_on_grid(keep) for keep in keeps], keeps):
        mechanism = line.filters(tried)
        achieved = value(mechanism)
        if achieved <= target:
            return _answer(target, "policy", mechanism, achieved, "")
    raise InputError("the ratio behind the filter that was found exceeds the target; this is a fault of the program, please report it")


def _why_not(attributes: Mapping[str, tuple[Any, ...]], split: Split, *, settled: bool) -> str:
    """Why no filter meets the target of a known policy, or that none was found."""
    if settled:
        return (
            "every keep probability from one over the number of values, which hides the group, up to 1 leaves more than the target (all of "
            "them were looked at, exactly); change the utility, the policy or the target"
        )
    if len(attributes) > 1:
        return (
            f"none was found among the filters of the split {split}; others, which keep the attributes with other probabilities, were not "
            "looked at; try another split, or fairaudit design, which looks at every filter"
        )
    return "none was found, and none was ruled out; try fairaudit design, which looks at every filter, or another target"


def alphabets(policy: Policy) -> dict[str, tuple[Any, ...]]:
    """What a filter of a policy's groups acts on: each attribute by itself if all combinations occur, else the combinations."""
    law = policy.law
    each = {name: tuple(dict.fromkeys(label[i] for label in law.groups)) for i, name in enumerate(law.columns.group)}
    if prod(len(values) for values in each.values()) == len(law.groups):
        return each
    return {" and ".join(law.columns.group): law.groups}


def _search(target: Fraction, rule: Rule, setting: _Setting, attributes: Mapping[str, tuple[Any, ...]], split: Split) -> Calibration:
    """Calibrate by one rule; the quantity is filled in by the caller."""
    guarantee = _guarantee(rule, setting)
    bare = _identity(attributes)
    if setting.tau > 0 and target * setting.tau >= setting.gamma and rule != "contraction":
        cap = _for_every_policy(bounds.floor_cap(setting.gamma, setting.tau, floor="declared"), setting)
        return _result(target, rule, bare, cap, "the floor alone keeps the ratio under the target; no privacy is needed")

    def climb(line: _Line) -> Calibration:
        return _climb(target, rule, line, lambda mechanism: guarantee(mechanism).value, lambda: guarantee(bare).value)

    found = _best_tilt(climb, attributes, split)
    if found.mechanism is None:
        hidden = guarantee(_Line(attributes, split).on_grid(0))
        return replace(found, reason=_why(rule, setting, hidden.value), scope=hidden.scope)
    proof = guarantee(found.mechanism)
    return replace(found, scope=proof.scope, assumptions=_judge(proof))


def _climb(
    target: Fraction, rule: str, line: _Line, value: Callable[[Mechanism], Fraction | float], bare: Callable[[], Fraction | float]
) -> Calibration:
    """The greatest step of a line of filters whose value, which grows along it, is at most the target."""
    without = bare()
    if without <= target:
        return _answer(target, rule, _identity(line.attributes), without, UNNEEDED)
    if value(line.on_grid(0)) > target:
        return Calibration("local", target, rule, False, None, (), inf, None, "", ())
    low, high = 0, SEARCH_STEPS
    while high - low > 1:
        middle = (low + high) // 2
        if value(line.on_grid(middle)) <= target:
            low = middle
        else:
            high = middle
    mechanism = line.on_grid(low)
    achieved = value(mechanism)
    if achieved > target:
        raise InputError("the guarantee of the filter that was found exceeds the target; this is a fault of the program, please report it")
    return _answer(target, rule, mechanism, achieved, "")


def _answer(target: Fraction, rule: str, mechanism: Mechanism, achieved: Fraction | float, reason: str) -> Calibration:
    keeps = tuple(Fraction(f.rows[0][0], f.denominator) for f in mechanism.factors)
    return Calibration("local", target, rule, True, mechanism, keeps, _factor(mechanism), achieved, "", (), reason=reason)


def _result(target: Fraction, rule: str, mechanism: Mechanism, proof: Bound, reason: str) -> Calibration:
    return replace(_answer(target, rule, mechanism, proof.value, reason), scope=proof.scope, assumptions=_judge(proof))


def _judge(proof: Bound) -> tuple[str, ...]:
    return tuple(text for text in proof.assumptions if not text.startswith("the group filter multiplies"))


def _factor(mechanism: Mechanism) -> Fraction | float:
    """e^ε of a product of randomized responses."""
    total: Fraction | float = Fraction(1)
    for part in mechanism.factors:
        keep, lie = part.rows[0][0], part.rows[0][1]
        total = inf if lie == 0 else total * Fraction(keep, lie)
    return total


def _guarantee(rule: Rule, s: _Setting) -> Callable[[Mechanism], Bound]:
    """The bound of a rule as a function of the filter."""

    def guarantee(mechanism: Mechanism) -> Bound:
        factor = _factor(mechanism)
        if rule == "contraction":
            return bounds.t12(factor, s.gamma / s.g_min if s.raw is None else s.raw)
        if s.tau == 0:
            if s.gap == 0 and s.delta == 0:
                return bounds.t2(factor)
            return bounds.t1_tight(factor, s.delta, s.gamma, s.tau, s.gap, floor="declared")
        if rule == "paper":
            return bounds.t1_paper(factor, s.delta, s.gamma, s.tau, s.gap, floor="declared")
        if rule == "tight":
            return bounds.t1_tight(factor, s.delta, s.gamma, s.tau, s.gap, floor="declared")
        if rule == "sharp":
            return bounds.t3_approx(factor, s.delta, s.tau / s.gamma, floor="declared")
        if s.gap == 0 and s.g_min > 0:
            return bounds.t4(mechanism, s.gamma, s.g_min, s.tau, floor="declared")
        if s.gap == 0:
            return bounds.t3_mechanism(mechanism, s.tau / s.gamma, floor="declared")
        return bounds.t3_general(mechanism, s.gamma, s.tau, s.gap, floor="declared")

    return lambda mechanism: _for_every_policy(guarantee(mechanism), s)


def _for_every_policy(proof: Bound, s: _Setting) -> Bound:
    """The same bound, about every policy where the least utility is the floor: no policy can go below it."""
    if s.g_min == 0 or s.raw is not None or s.tau > s.g_min:
        return proof
    kept = (text for text in proof.assumptions if not text.endswith("(declared)"))
    return replace(proof, scope=bounds.ANY_POLICY, assumptions=(*kept, f"no utility is below {s.g_min}"))


def _on_grid(keep: Fraction) -> Fraction:
    return Fraction(keep.numerator * GRID // keep.denominator, GRID)


@dataclass(frozen=True)
class _Line:
    """Filters from total privacy (s = 0) to none (s = 1), in growing order of what they let through.

    The keep probability of an attribute with k values is T/(T + (k − 1)·F) for T and F linear in s. With equal ε, T = 1 + s and F = 1 − s:
    s is that of a coin, and e^ε = (1 + s)/(1 − s). With equal keep probabilities the odds of the truth, s : 1 − s, are tilted where one
    attribute is to be kept more often than another, and are never below those that hide it.
    """

    attributes: Mapping[str, tuple[Any, ...]]
    split: Split
    tilts: tuple[Fraction, ...] = ()

    @property
    def equal_epsilon(self) -> bool:
        return len(self.attributes) == 1 or self.split == "equal-epsilon"

    def filters(self, keeps: Sequence[Fraction]) -> Mechanism:
        """The filter that keeps the attributes with these probabilities, but none below one over the number of its values."""
        return _together(
            {
                name: RandomizedResponse(values, keep_probability=max(Fraction(1, len(values)), keep))
                for (name, values), keep in zip(self.attributes.items(), keeps, strict=True)
            }
        )

    def on_grid(self, step: int) -> Mechanism:
        """The filter at s = step/`SEARCH_STEPS`, its keep probabilities rounded down."""
        return self.filters([_on_grid(keep) for keep in self.keeps(Fraction(step, SEARCH_STEPS))])

    def keeps(self, s: Fraction) -> list[Fraction]:
        """Keep probabilities, exact."""
        return [
            max(Fraction(1, k), top / (top + rest)) if top + rest else Fraction(0)
            for k, (top, rest) in zip(self._sizes, self._odds(s), strict=True)
        ]

    def pieces(self) -> Iterator[tuple[Fraction, Fraction, list[int]]]:
        """Intervals of s, the greatest first, each with the attributes whose keep probability rises there."""
        starts = [Fraction(0) if self.equal_epsilon else 1 / (1 + tilt * (k - 1)) for k, tilt in zip(self._sizes, self._tilts, strict=True)]
        for low, high in reversed(list(pairwise(sorted({Fraction(0), *starts, Fraction(1)})))):
            yield low, high, [i for i, start in enumerate(starts) if start <= low]

    def weight(self, s: Fraction, rising: Sequence[int]) -> Fraction:
        """What every probability behind the filter is multiplied with to be a polynomial of s, of the degree `len(rising)`."""
        odds = self._odds(s)
        return prod((odds[i][0] + odds[i][1] for i in rising), start=Fraction(1))

    @property
    def _sizes(self) -> list[int]:
        return [len(values) for values in self.attributes.values()]

    @property
    def _tilts(self) -> tuple[Fraction, ...]:
        return self.tilts or (Fraction(1),) * len(self.attributes)

    def _odds(self, s: Fraction) -> list[tuple[Fraction, Fraction]]:
        """The weights of the truth and of all lies together."""
        if self.equal_epsilon:
            return [(1 + s, (k - 1) * (1 - s)) for k in self._sizes]
        return [(s * tilt, 1 - s) for tilt in self._tilts]


def _best_tilt(climb: Callable[[_Line], Calibration], attributes: Mapping[str, tuple[Any, ...]], split: Split) -> Calibration:
    """Climb one line; for "most-truth", tilt the odds of single attributes as long as the whole tuple is true more often.

    For a given ε of the tuple the common keep probability is already the best: the gain d(log p)/dε = 1 − p is then the same for all
    attributes that are kept above 1/k. Guarantees that look at more than ε may leave a little to gain.
    """
    best = climb(_Line(attributes, split))
    if split != "most-truth" or len(attributes) == 1 or not best.feasible or best.exp_epsilon == inf:
        return best
    tilts = (Fraction(1),) * len(attributes)
    stride = Fraction(1, 2)
    while stride >= Fraction(1, 32):
        improved = False
        for i in range(len(tilts)):
            for factor in (1 + stride, 1 / (1 + stride)):
                tried = tuple(tilt * factor if i == j else tilt for j, tilt in enumerate(tilts))
                found = climb(_Line(attributes, split, tried))
                if found.feasible and prod(found.keep_probabilities) > prod(best.keep_probabilities):
                    best, tilts, improved = found, tried, True
        if not improved:
            stride /= 2
    return best


def _identity(attributes: Mapping[str, tuple[Any, ...]]) -> Mechanism:
    return _together({name: Identity(values) for name, values in attributes.items()})


def _together(parts: Mapping[str, Mechanism]) -> Mechanism:
    return next(iter(parts.values())) if len(parts) == 1 else Product(parts)


def _target(max_ratio: Any, max_log: Any, quantity: str) -> Fraction:
    """The target as a ratio, rounded down where a logarithm was given."""
    if quantity not in QUANTITIES:
        raise InputError(f"quantity={shown(quantity)} is not accepted; {nearest(str(quantity), QUANTITIES)}")
    unit, limit = one_limit(max_ratio, max_log)
    if unit == "ratio":
        if limit == 1:
            raise InputError(f"max_ratio is {shown(max_ratio)}; a ratio other than 1 is accepted (1 needs a filter that hides everything)")
        return limit
    if limit == 0:
        raise InputError(f"max_log is {shown(max_log)}; a logarithm above 0 is accepted (0 needs a filter that hides everything)")
    low, _ = exp_enclosure((limit.numerator, limit.denominator), TARGET_BITS)
    return max(Fraction(1), Fraction(low, 1 << TARGET_BITS))


def _attributes(groups: int | Sequence[Any] | Mapping[str, int | Sequence[Any]]) -> dict[str, tuple[Any, ...]]:
    listed = groups if isinstance(groups, Mapping) else {"group": groups}
    if not listed:
        raise InputError("no attribute was given; name at least one")
    result = {}
    for name, values in listed.items():
        labels = tuple(str(i) for i in range(values)) if isinstance(values, int) else tuple(values)
        if len(labels) < 2:
            raise InputError(f"the attribute {shown(name)} has {len(labels)} values; randomized response needs at least two")
        if len(labels) > 10_000:
            raise InputError(f"the attribute {shown(name)} has {len(labels)} values; at most 10,000 are accepted")
        result[name] = labels
    return result


def _setting(gamma: Any, tau: Any, g_min: Any, delta: Any, lipschitz: Any, diameter: Any, raw_ratio: Any, rule: Rule) -> _Setting:
    named = {"gamma": gamma, "tau": tau, "g_min": g_min, "delta": delta, "lipschitz": lipschitz, "diameter": diameter}
    exact: dict[str, Fraction] = {}
    for name, value in named.items():
        try:
            exact[name] = Fraction(*option_value(value))
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        if exact[name] < 0:
            raise InputError(f"{name} is {shown(value)}; it must be at least 0")
    gap = exact["lipschitz"] * exact["diameter"]
    top, low, least = exact["gamma"], exact["tau"], exact["g_min"]
    if top == 0:
        raise InputError("gamma is 0; a utility that is always 0 treats everybody alike, and needs no filter")
    if exact["delta"] > 1:
        raise InputError(f"delta is {shown(delta)}; a probability from 0 to 1 is accepted")
    for name, value in (("tau", low), ("g_min", least)):
        if value > top:
            raise InputError(f"{name} is {value}, above gamma, which is {top}; no utility can be above the greatest")
    if rule == "mechanism" and exact["delta"]:
        raise InputError(
            f'delta is {shown(delta)}, but bound="mechanism" looks at the very filter, whose delta is 0; leave it out, or use "tight"'
        )
    if rule == "contraction" and low:
        raise InputError(f"tau is {shown(tau)}, but the contraction needs no floor; leave it out, or use another bound")
    # The least utility is itself a floor.
    low = max(low, least)
    raw = _raw_ratio(raw_ratio, rule, gap, exact["delta"], least)
    if rule == "sharp" and gap:
        raise InputError(
            'bound="sharp" is for a utility that does not depend on the group; use "mechanism" or "tight" with lipschitz above 0'
        )
    return _Setting(top, low, least, exact["delta"], gap, raw)


def _raw_ratio(raw_ratio: Any, rule: Rule, gap: Fraction, delta: Fraction, least: Fraction) -> Fraction | float | None:
    raw: Fraction | float | None = None
    if rule == "contraction":
        if gap or delta:
            raise InputError("the contraction holds for delta = 0 and a utility that does not depend on the group (lipschitz 0)")
        if raw_ratio is not None:
            raw = inf if raw_ratio == "inf" else Fraction(*option_value(raw_ratio))
            if raw < 1:
                raise InputError(f"raw_ratio is {shown(raw_ratio)}; a ratio of at least 1 is accepted")
            if least:
                raise InputError("raw_ratio and g_min were both given; the contraction starts from one of them, for this policy or for all")
        elif least == 0:
            raise InputError(
                "the contraction needs raw_ratio, the policy's own ratio, or g_min above 0, which bounds the ratio of every policy"
            )
    elif raw_ratio is not None:
        raise InputError('raw_ratio goes with bound="contraction"')
    return raw


def _why(rule: Rule, s: _Setting, hidden: Fraction | float) -> str:
    """Why even a filter that hides everything does not guarantee the target by this rule, and what would."""
    if hidden == inf:
        return (
            "without a floor no filter helps: a group may get nothing where another gets something, since the utility depends on the "
            "group or delta is positive; declare a floor tau above 0, or use a utility that does not depend on the group with delta = 0"
        )
    causes = []
    if s.gap:
        causes.append("the utility itself differs between groups (a smaller lipschitz or diameter helps)")
    if s.delta:
        causes.append("delta is positive (a smaller delta helps)")
    said = " and ".join(causes) or "this rule is too coarse"
    return (
        f"even a filter that hides everything guarantees only a ratio of {float(hidden):.6g} by this rule, because {said}; "
        f"a higher floor tau, or a target of at least {float(hidden):.6g} (log {log(hidden):.6g}), is feasible"
        + ("" if rule in ("mechanism", "contraction") else '; so may be bound="mechanism"')
    )
