"""What a moment of a stream shows: intervals, verdicts, and windows that contradict the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError
from fairaudit.inference.anytime import stream_interval
from fairaudit.inference.changes import Change, disjoint, withdrawn_by
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import window_share
from fairaudit.inference.verdicts import Verdict, exit_code, foremost_verdict, verdict
from fairaudit.measures.limits import LIMITS, Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.streams.settings import Settings
from fairaudit.streams.subjects import Subject
from fairaudit.words import brief

QUANTITIES: tuple[Quantity, ...] = ("local", "global")


@brief
@dataclass(frozen=True, repr=False)
class ByTime:
    """What pairs in time show.

    Attributes
    ----------
    pairs : int
        How many pairs of decisions there were.
    lower, upper : float
        At some time the local ratio was above the lower end; it is below the upper one if it is constant in time. Estimates in floats
        unless a verdict rests on them.
    confidence : Fraction
        Of both ends, at every moment.
    exceeded : tuple of str
        Targets above which the ratio was at some time, as is proved.
    pair : dict
        The pair of groups behind the lower end, if that is above 1.
    confounds : bool
        Whether the interval of the whole stream has no ratio in common with the ends: then means are not constant.
    error : Fraction
        The probability with which that would ever be said of constant means, at most.
    """

    pairs: int
    lower: float
    upper: float
    confidence: Fraction
    exceeded: tuple[str, ...]
    pair: Witness | None
    confounds: bool
    error: Fraction


@brief
@dataclass(frozen=True, repr=False)
class Look:
    r"""What a moment shows.

    Attributes
    ----------
    events : int
        Decisions that count.
    intervals : dict
        For "local" and "global" the ends of R, where groups can be compared and no window contradicts them; estimates in floats unless
        a verdict rests on them.
    verdicts : dict
        For each target its verdict, decided exactly.
    verdict : {"none", "within", "exceeds", "inconclusive", "depends", "changed"}
        Of all targets together; "changed" if what one of them rests on was contradicted.
    pairs : dict
        For each target the pair of groups behind the end that decided it: the lower one for "exceeds", else the upper one.
    by_time : ByTime, optional
        What pairs in time show, where they were asked for.

    Examples
    --------
    >>> import fairaudit as fa
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with open(folder + "/log.csv", "w") as log:
    ...         _ = log.write("hired,sex\n" + "yes,f\nyes,m\nno,m\n" * 200)
    ...     with fa.monitor(folder + "/log.csv", decision="hired", group="sex", utility="yes", max_local_ratio="5/4") as watch:
    ...         found = watch.catch_up()
    >>> found.events, found.verdicts, found.exit_code
    (600, {'max_local_ratio': 'exceeds'}, 1)
    """

    events: int
    intervals: dict[str, tuple[float, float]]
    verdicts: dict[str, Verdict]
    verdict: Verdict
    pairs: Mapping[str, Witness | None] = field(default_factory=dict)
    by_time: ByTime | None = None

    @property
    def exit_code(self) -> int:
        """0 within or no target, 1 a target is exceeded, 3 inconclusive, or changed without an exceeded target."""
        return exit_code(self.verdict, self.verdicts.values())


def contradiction(settings: Settings, whole: Subject | None, part: Subject | None, number: int, quantity: Quantity) -> Change | None:
    """Whether a window contradicts the whole stream; estimated in floats first, and then proved."""
    for exact in (False, True):
        one = interval_of(settings, whole, quantity, exact=exact)
        other = interval_of(settings, part, quantity, window_share(number), exact=exact)
        if part is None or one is None or other is None or not disjoint(one, other):
            return None
        found = Change(quantity, part.window(number), one, other)
    return found


def withdrawn(settings: Settings, alarms: list[dict[str, Any]]) -> frozenset[Quantity]:
    """The quantities of which nothing is said any more about the whole stream, because a window contradicted it."""
    gone: frozenset[Quantity] = frozenset()
    return gone.union(*(withdrawn_by(alarm["changed"], contexts=bool(settings.context)) for alarm in alarms if "changed" in alarm))


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
    try:
        table, level = found.utility.on(found.law), 1 - settings.alpha * share
        return stream_interval(found.law, table, found.arrivals, quantity, settings.limits, level, exact=exact)
    except InputError:
        return None


def asked_targets(settings: Settings, quantity: Quantity) -> dict[str, str]:
    """The targets on a quantity, with their limits."""
    return {name: limit for name, limit in (settings.targets or {}).items() if LIMITS[name][0] == quantity}


def target_verdict(interval: Interval, name: str, limit: str) -> Verdict:
    """What an interval says of the target of this name."""
    return verdict(interval, **{f"max_{LIMITS[name][1]}": limit})
