"""What a moment of a stream shows: intervals, verdicts, and windows that contradict the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError
from fairaudit.inference.anytime import stream_interval
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import window_share
from fairaudit.inference.verdicts import Verdict, exit_code, foremost_verdict, verdict
from fairaudit.measures.limits import LIMITS, Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.streams.settings import Settings
from fairaudit.streams.subjects import Subject

QUANTITIES: tuple[Quantity, ...] = ("local", "global")


@dataclass(frozen=True)
class Look:
    """What a moment shows.

    Attributes
    ----------
    events : int
        Decisions that count.
    intervals : dict
        For "local" and "global" the ends of R, where groups can be compared and no window contradicts them; estimates in floats unless
        a verdict rests on them.
    verdicts : dict
        For each target its verdict, decided exactly.
    verdict : {"none", "within", "exceeds", "inconclusive", "changed"}
        Of all targets together; "changed" if what one of them rests on was contradicted.
    pairs : dict
        For each target the pair of groups behind the end that decided it: the lower one for "exceeds", else the upper one.
    """

    events: int
    intervals: dict[str, tuple[float, float]]
    verdicts: dict[str, Verdict]
    verdict: Verdict
    pairs: Mapping[str, Witness | None] = field(default_factory=dict)

    @property
    def exit_code(self) -> int:
        """0 within or no target, 1 a target is exceeded, 3 inconclusive, or changed without an exceeded target."""
        return exit_code(self.verdict, self.verdicts.values())


@dataclass(frozen=True)
class Contradiction:
    """A window and the whole stream until then, whose intervals have no ratio in common: not both come from one constant ratio.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio.
    number : int
        The window's.
    whole, part : Interval
        That of the whole stream and that of the window, proved.
    """

    quantity: Quantity
    number: int
    whole: Interval
    part: Interval

    @property
    def error(self) -> Fraction:
        """Probability with which the interval of the whole stream and one of the windows up to this are ever disjoint under constancy."""
        shares = sum((window_share(i) for i in range(1, self.number + 1)), Fraction(0))
        return (1 - self.whole.confidence) + (1 - self.part.confidence) / window_share(self.number) * shares


def contradiction(settings: Settings, whole: Subject | None, part: Subject | None, number: int, quantity: Quantity) -> Contradiction | None:
    """Whether a window contradicts the whole stream; estimated in floats first, and then proved."""
    for exact in (False, True):
        one = interval_of(settings, whole, quantity, exact=exact)
        other = interval_of(settings, part, quantity, window_share(number), exact=exact)
        if one is None or other is None or not (one.upper < other.lower or other.upper < one.lower):
            return None
    return Contradiction(quantity, number, one, other) if one is not None and other is not None else None


def withdrawn(settings: Settings, alarms: list[dict[str, Any]]) -> frozenset[Quantity]:
    """The quantities of which nothing is said any more about the whole stream.

    If the ratio within contexts changed, the means of cells did, and all rests on them. A global ratio also changes with the mix of
    contexts, of which the ratio within them needs nothing.
    """
    found = {alarm["changed"] for alarm in alarms if "changed" in alarm}
    if "local" in found or (found and not settings.context):
        return frozenset(QUANTITIES)
    return frozenset({"global"}) if found else frozenset()


def pair_labels(pair: Witness | None) -> dict[str, Any] | None:
    """The labels of a pair of groups, as an alarm keeps them."""
    return None if pair is None else {"context": pair.context, "higher": pair.higher, "lower": pair.lower}


def look(settings: Settings, found: Subject | None, events: int, share: Fraction = Fraction(1)) -> Look:
    """Judge all targets. Ends are floats first; a verdict other than inconclusive is given only by ends that are proved."""
    verdicts: dict[str, Verdict] = dict.fromkeys(settings.targets or {}, "inconclusive")
    intervals: dict[str, tuple[float, float]] = {}
    pairs: dict[str, Witness | None] = {}
    for quantity in QUANTITIES:
        interval = interval_of(settings, found, quantity, share, exact=False)
        if interval is None:
            continue
        asked = asked_targets(settings, quantity)
        if any(target_verdict(interval, name, limit) != "inconclusive" for name, limit in asked.items()):
            interval = interval_of(settings, found, quantity, share) or interval
            verdicts |= {name: target_verdict(interval, name, limit) for name, limit in asked.items()}
        pairs |= {name: interval.pairs[0 if verdicts[name] == "exceeds" else 1] for name in asked}
        intervals[quantity] = float(interval.lower), float(interval.upper)
    overall = foremost_verdict(verdicts.values())
    return Look(events, intervals, verdicts, overall, pairs)


def interval_of(
    settings: Settings, found: Subject | None, quantity: Quantity, share: Fraction = Fraction(1), *, exact: bool = True
) -> Interval | None:
    """The interval of a quantity, or None if nothing is compared yet. Quantities with targets share the error."""
    if found is None:
        return None
    alpha = (1 - Fraction(settings.confidence)) * share / max(1, len(settings.named))
    try:
        return stream_interval(found.law, found.utility.on(found.law), found.arrivals, quantity, settings.limits, 1 - alpha, exact=exact)
    except InputError:
        return None


def asked_targets(settings: Settings, quantity: Quantity) -> dict[str, str]:
    return {name: limit for name, limit in (settings.targets or {}).items() if LIMITS[name][0] == quantity}


def target_verdict(interval: Interval, name: str, limit: str) -> Verdict:
    return verdict(interval, **{f"max_{LIMITS[name][1]}": limit})
