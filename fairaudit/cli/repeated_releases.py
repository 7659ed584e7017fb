"""What `fairaudit privacy` says of fairness: the greatest ratio behind several fresh releases, and how many of them keep a target."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import add_limit, given_limit, limits_as_options

if TYPE_CHECKING:
    from fairaudit.exact.extended import Extended
    from fairaudit.model.mechanism import Mechanism

NUMBERS = {"gamma": "gamma", "m": "g_min", "tau": "tau"}
"""Constants of the utility, and what their options are called."""

OPTIONS = tuple(f"--{option.replace('_', '-')}" for option in NUMBERS.values())


@dataclass(frozen=True)
class Wanted:
    """What was asked for: how many releases, constants of the utility, targets as ratios with the unit in which they were given."""

    releases: int
    constants: dict[str, Any]
    targets: tuple[tuple[Fraction, str, Fraction], ...]


def add_utility(parser: Any) -> None:
    """Declare the options."""
    group = parser.add_argument_group("what the releases let a policy do, for a utility of this range (exact numbers)")
    group.add_argument("--tau", metavar="T", help="declared floor of every group's expected utility (0: none)")
    group.add_argument("--g-min", metavar="M", help="least utility (0)")
    group.add_argument("--gamma", metavar="G", help="greatest utility (1)")
    add_limit(group, several=True)


def read_wanted(arguments: argparse.Namespace, releases: int | None) -> Wanted | None:
    """What was asked for; None if nothing was."""
    from fairaudit.errors import InputError
    from fairaudit.model.releases import check_releases
    from fairaudit.theorems.t13_range import read_utility_range

    given = {name: getattr(arguments, option) for name, option in NUMBERS.items()}
    constants: dict[str, Any] = {name: text for name, text in given.items() if text is not None}
    limits = given_limit(arguments)
    if not constants and not limits:
        return None
    try:
        count = check_releases(1 if releases is None else releases)
        read_utility_range(**{"gamma": 1, **constants})
        targets = [_read_target(**limit) for limit in limits]
    except InputError as error:
        raise InputError(_as_options(limits_as_options(str(error)))) from None
    return Wanted(count, constants, tuple(targets))


def _read_target(max_ratio: str | None = None, max_log: str | None = None) -> tuple[Fraction, str, Fraction]:
    from fairaudit.filters.targets import read_target
    from fairaudit.measures.limits import one_limit

    return read_target(max_ratio, max_log) or Fraction(1), *one_limit(max_ratio, max_log)


def guaranteed(mechanism: Mechanism, wanted: Wanted) -> dict[str, Any]:
    """The greatest ratio of any policy that sees the releases, of one that sees a single one, and where targets break."""
    from fairaudit.measures.limits import limit_readings
    from fairaudit.privacy.epsilon_delta import exp_epsilon
    from fairaudit.theorems.t17 import last_release, t17, t17_without_end

    bound = t17(mechanism, wanted.releases, **wanted.constants)
    pure = exp_epsilon(mechanism)
    targets = []
    for target, unit, number in wanted.targets:
        last, within = last_release(mechanism, target, **wanted.constants), bound.value <= target
        held = max(last.releases, wanted.releases if within else 0)
        targets.append(
            {
                "max_ratio": target,
                "readings": limit_readings(unit, number),
                "verdict": "within" if within else "exceeds",
                "holds_to": None if held == inf else held,
                "breaks_at": held + 1 if last.exact and held < inf else None,
            }
        )
    return {
        "releases": wanted.releases,
        "gamma": bound.constants["gamma"],
        "g_min": bound.constants["g_min"],
        "tau": bound.constants.get("tau", Fraction(0)),
        "guarantee": _ratio(bound.value),
        "sticky": _ratio(t17(mechanism, 1, **wanted.constants).value),
        "without_end": _ratio(t17_without_end(mechanism, **wanted.constants)),
        "by_epsilon": _ratio(pure**wanted.releases if isinstance(pure, Fraction) else inf),
        "targets": targets,
        "scope": bound.scope,
        "assumptions": bound.assumptions,
    }


def _ratio(value: Extended) -> dict[str, Any]:
    """A ratio, with its logarithm between two ends."""
    from fairaudit.privacy.epsilon_delta import epsilon_enclosure

    return {"ratio": value, "log": epsilon_enclosure((value.numerator, value.denominator) if isinstance(value, Fraction) else (1, 0))}


def _as_options(message: str) -> str:
    """Call constants in a message what the options that give them are called."""
    for name, option in NUMBERS.items():
        if message.startswith((f"{name} ", f"{name}:")):
            return f"--{option.replace('_', '-')}{message.removeprefix(name)}".replace(", above gamma,", ", above --gamma,")
    counted = f"with {', '.join(OPTIONS)} or a target a whole number"
    return message.replace("the number of releases is", "--releases is").replace("a whole number", counted)


def guarantee_text(found: dict[str, Any]) -> str:
    """What a person reads."""
    n = found["releases"]
    rows = [(_times(n), "guarantee")] if n > 1 else []
    rows += [("one fresh release, or any number of sticky ones", "sticky"), ("any number of fresh releases", "without_end")]
    lines = [f"What the releases let a policy do, whatever it is   ({_range(found)})"]
    lines += [f"  {name:<{WIDTH}}{_at_most(found[key]['ratio'])}{_exactly(found[key]['ratio'])}" for name, key in rows]
    lines.append(f"  {_rule(n):<{WIDTH}}{_at_most(found['by_epsilon']['ratio'])}{_beside(found)}")
    lines.append(
        "  R is how many times as much one group can get as another in the same situation, where a policy uses what it remembers as\n"
        "  unfairly as it can. A fresh release is drawn anew; a sticky one is drawn once per person and replayed, retries included."
    )
    lines += [_target(target, found) for target in found["targets"]]
    return "\n".join(lines)


def guarantee_sentence(found: dict[str, Any]) -> str:
    """The same in a sentence or two."""
    said = f"For every policy that sees {_times(found['releases'])}: {_at_most(found['guarantee']['ratio'])} ({_range(found)})."
    return " ".join([said, *(_target(target, found) for target in found["targets"])])


WIDTH = 50


def _times(n: int) -> str:
    return f"{n} fresh releases" if n > 1 else "one fresh release"


def _rule(n: int) -> str:
    return f"by ε alone, e^({n}ε)" if n > 1 else "by ε alone, e^ε"


def _range(found: dict[str, Any]) -> str:
    floor = f"; every group's expected utility at least {found['tau']}" if found["tau"] else ""
    return f"utilities from {found['g_min']} to {found['gamma']}{floor}"


def _at_most(value: Extended) -> str:
    from fairaudit.words import approximate

    return f"R at most {approximate(value, 'up')}" if isinstance(value, Fraction) else "no bound"


def _exactly(value: Extended) -> str:
    from fairaudit.exact.extended import extended_text

    if not isinstance(value, Fraction) or value.numerator.bit_length() + value.denominator.bit_length() > 200:
        return ""
    return f"   exactly {extended_text(value)}"


def _beside(found: dict[str, Any]) -> str:
    """How the rule of ε compares with what holds."""
    from fairaudit.words import approximate

    ours, rule = found["guarantee"]["ratio"], found["by_epsilon"]["ratio"]
    if ours == rule:
        open_still = rule > 1 and not found["g_min"] and not found["tau"]
        return f"   ({'one' if rule == inf else 'less'} with a floor, --tau, or a least utility, --g-min)" if open_still else ""
    return "" if rule == inf else f"   {approximate(rule / ours)} times too large"


def _target(target: dict[str, Any], found: dict[str, Any]) -> str:
    from fairaudit.words import approximate

    said = f"Target: R at most {approximate(target['max_ratio'])}"
    last, breaks = target["holds_to"], target["breaks_at"]
    if last is None:
        return f"{said} holds however many releases there are."
    if last == 0:
        return f"{said} does not hold for a single release; a filter that tells the truth less often may keep it (fairaudit calibrate)."
    if breaks is None:
        return f"{said} holds for {_times(last)}; more were not counted."
    return (
        f"{said} holds for up to {_times(last)} and breaks at {breaks}. "
        f"With a sticky release it holds for good: {_at_most(found['sticky']['ratio'])}."
    )
