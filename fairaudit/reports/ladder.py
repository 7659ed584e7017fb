"""What is known of a ratio, from the table to the guarantee, and how much truth a filter may tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, log, prod
from typing import Any, Literal

from fairaudit.certificates.reader import Subject, number, ratio
from fairaudit.errors import InputError
from fairaudit.exact.enclosures import exp_enclosure
from fairaudit.filters.calibration import calibrate
from fairaudit.measures.limits import limit_text
from fairaudit.model.mechanism import Mechanism
from fairaudit.reports.words import REACH, Value, claimed, how, scope
from fairaudit.theorems.bound import ANY_POLICY, FLOORED
from fairaudit.theorems.registry import is_sampled
from fairaudit.words import approximate

__all__ = ["Calibrated", "Rung", "Step", "by_scope", "calibration", "ladder"]


CALIBRATED_GROUPS = 64  # groups up to which a page says how much truth a filter may tell: less than a second


@dataclass(frozen=True)
class Rung:
    """A number on the ladder of a quantity: measured, bounded, or asked for."""

    kind: Literal["measured", "unfiltered", "bound", "least", "target"]
    name: str
    scope: str
    value: Value


@dataclass(frozen=True)
class Calibrated:
    """How much truth a filter may tell for each target, and where the audited filter stands."""

    points: tuple[tuple[float, float], ...]
    here: tuple[float, float] | None
    target: float | None
    assumption: str


@dataclass(frozen=True)
class Step:
    """What is known of a ratio for one scope: a value, an upper bound, a lower one, or both ends of an interval."""

    kind: Literal["measured", "unfiltered", "interval", "bound", "least", "target"]
    name: str
    scope: str
    low: Value
    high: Value


def by_scope(rungs: Sequence[Rung]) -> tuple[list[Step], list[Rung]]:
    """The sharpest that is known for each scope, and the bounds that it makes superfluous.

    Examples
    --------
    >>> rungs = [Rung("bound", "at most, by a theorem", "any policy", Value(Fraction(n))) for n in (2, 3)]
    >>> steps, rest = by_scope([Rung("least", "at least, by a theorem", "any policy", Value(Fraction(1))), *rungs])
    >>> steps[0].kind, steps[0].name, float(steps[0].high), len(rest)
    ('interval', 'between, by a theorem', 2.0, 1)
    """
    steps = [Step(r.kind, r.name, r.scope, r.value, r.value) for r in rungs if r.kind not in ("bound", "least")]
    best: dict[str, dict[str, Rung]] = {}
    for rung in (*(r for r in rungs if r.kind == "bound"), *(r for r in reversed(rungs) if r.kind == "least")):
        best.setdefault(rung.scope, {}).setdefault(rung.kind, rung)
    for about, found in best.items():
        if len(found) == 1:
            steps += [Step(r.kind, r.name, about, r.value, r.value) for r in found.values()]
            continue
        least, most = found["least"], found["bound"]
        alike = least.name.removeprefix("at least, ") == most.name.removeprefix("at most, ")
        name = f"between, {most.name.removeprefix('at most, ')}" if alike else f"{least.name}; {most.name}"
        steps.append(Step("interval", name, about, replace(least.value, rounding="down"), replace(most.value, rounding="up")))
    order = ("measured", "unfiltered", "interval", "least", "bound", "target")
    kept = [rung for found in best.values() for rung in found.values()]
    rest = [r for r in rungs if r.kind in ("bound", "least") and not any(r is one for one in kept)]
    return sorted(steps, key=lambda step: (order.index(step.kind), float(step.high))), rest


def ladder(document: Mapping[str, Any], name: Literal["local", "global"]) -> list[Rung]:
    """What is known of a ratio, smallest first: measured values, bounds and targets; empty where it was not measured."""
    metrics = document["metrics"]
    measured = ratio(metrics[name])
    if measured is None:
        return []
    kind = "the table" if document["subject"]["kind"] != "policy" else "the policy behind its filters"
    rungs = [Rung("measured", f"measured: {kind}", "this law", Value(measured.ratio))]
    before = ratio((metrics.get("unfiltered") or {}).get(name))
    if before is not None:
        rungs.append(Rung("unfiltered", "measured: the policy without filters", "the policy itself", Value(before.ratio)))
    over_units = ratio(document.get("intervals", {}).get(name, {}).get("measured"))
    if over_units is not None:
        rungs.append(Rung("measured", f"measured: {kind}, mean over units", "this law", Value(over_units.ratio)))
    for claim in document["claims"]:
        if _over_policies(claim, name):
            rungs.append(_supremum(claim))
        if claim["quantity"] != f"{name}_ratio" or claim["relation"] == "=":
            continue
        bounded: Literal["bound", "least"] = "bound" if claim["relation"] == "<=" else "least"
        source = "" if is_sampled(claim["scope"]) else f" ({claim['by']})"
        title = f"{'at most' if bounded == 'bound' else 'at least'}, {how(claim)}{source}"
        of = ", mean over units" if over_units is not None and "interval" in claim["evidence"] else ""
        rungs.append(Rung(bounded, title, scope(claim["scope"]) + of, claimed(claim)))
    for target in document["targets"]:
        if target["quantity"] != name or target["unit"] == "difference":
            continue
        limit = number(target["limit"])
        shown = Value(limit) if target["unit"] == "ratio" else _exponential(limit)
        said = limit_text(name, target["unit"], Fraction(limit))
        of = f", {target['estimand']}" if "estimand" in target else ""
        rungs.append(Rung("target", f"target: {said}", scope(target["judged"]) + of, shown))
    return sorted(rungs, key=lambda rung: (float(rung.value), rung.kind != "measured"))


def _over_policies(claim: Mapping[str, Any], name: str) -> bool:
    """Whether a claim says what policies behind the filters can do to a ratio at most."""
    return bool(claim["by"] == "T13" and claim["quantity"] == f"{name}_ratio_supremum")


def _supremum(claim: Mapping[str, Any]) -> Rung:
    """The greatest ratio of the policies of a scope, which some policy has, or an upper bound of it."""
    attained = "the worst that it can be" if claim["relation"] == "=" else "at most"
    return Rung("bound", f"{REACH.get(claim['scope'], 'any policy')}: {attained} (T13)", scope(claim["scope"]), claimed(claim))


def calibration(document: Mapping[str, Any], subject: Subject | None) -> Calibrated | None:
    """How much truth a filter like the audited one may tell for each target; None where no filter was audited."""
    if subject is None or subject.deployment is None:
        return None
    try:
        return _calibrated(document, subject.deployment.group_filter)
    except InputError:
        return None


def _exponential(limit: Fraction | float) -> Value:
    if not isinstance(limit, Fraction) or limit > 700:
        return Value(inf)
    low, _ = exp_enclosure((limit.numerator, limit.denominator), 64)
    return Value(Fraction(low, 1 << 64), "down", rational=False)


def _calibrated(document: Mapping[str, Any], mechanism: Mechanism) -> Calibrated | None:
    """Calibrate filters with the alphabets of this one for a range of targets."""
    about = document["subject"]
    sizes = [len(factor.inputs) for factor in mechanism.factors]
    if prod(sizes) > CALIBRATED_GROUPS or min(sizes) < 2:
        return None
    constants = {key: number(text) for key, text in {**about["utility"], **about["declared"]}.items() if isinstance(text, str)}
    declared = "tau" in about["declared"] and constants["tau"] > 0
    if constants["lipschitz"] > 0 and not declared:
        return None
    tau = constants["tau"] if declared else Fraction(0)
    widest = min(3.0, log(constants["gamma"] / tau) if declared else 3.0)
    asked = [_target_log(target) for target in document["targets"] if target["quantity"] == "local" and target["unit"] != "difference"]
    points = []
    for step in range(1, 13):
        target = Fraction(round(widest * step / 12 * 1000), 1000)
        if target <= 0:
            continue
        found = calibrate(
            max_log=target,
            groups={str(i): size for i, size in enumerate(sizes)},
            gamma=constants["gamma"],
            tau=tau,
            lipschitz=constants["lipschitz"],
        )
        if found.feasible:
            points.append((float(target), float(prod(found.keep_probabilities))))
    if len(points) < 2:
        return None
    assumption = (
        f"any policy that gives every group an expected utility of at least {approximate(tau)} behind the filter"
        if declared
        else "any policy whatever, by privacy alone"
    )
    return Calibrated(tuple(points), _standing(document, mechanism, declared=declared), asked[0] if asked else None, assumption)


def _standing(document: Mapping[str, Any], mechanism: Mechanism, *, declared: bool) -> tuple[float, float] | None:
    """The guarantee of the audited filter for any policy, and the probability that it releases the truth."""
    if any(factor.inputs != factor.outputs for factor in mechanism.factors):
        return None
    scopes = {ANY_POLICY, *((FLOORED,) if declared else ())}
    values = [
        number(c["value"])
        for c in document["claims"]
        if c["scope"] in scopes and (c["quantity"] == "local_ratio" or _over_policies(c, "local"))
    ]
    best = min(values, default=inf)
    kept = prod(min(Fraction(row[i], f.denominator) for i, row in enumerate(f.rows)) for f in mechanism.factors)
    return None if best == inf else (log(best), float(kept))


def _target_log(target: Mapping[str, str]) -> float:
    limit = float(number(target["limit"]))
    return limit if target["unit"] == "log" else log(limit)
