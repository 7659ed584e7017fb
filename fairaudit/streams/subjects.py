"""What a stream counted, as a law with its utility and the order of arrival."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError
from fairaudit.inference.anytime import Arrivals
from fairaudit.inference.changes import Window
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.streams.detection import limit_of
from fairaudit.streams.settings import Settings
from fairaudit.streams.state import Counts

GREATEST = 16  # of the ratios of joint bets: beyond, a bet on the lower cell is as great as it can be anyway


@dataclass(frozen=True)
class Subject:
    """What was counted, as `certify` takes it."""

    law: Law
    utility: Utility
    arrivals: Arrivals

    def window(self, number: int) -> Window:
        """The same as a window of a stream."""
        table = self.utility.on(self.law)
        return Window(number, table.law, table, self.arrivals)


def joint_ratios(settings: Settings) -> tuple[Fraction, ...]:
    """The ratios of joint bets: 1, and the limits of the targets; none if bets are separate.

    Examples
    --------
    >>> made = Settings(group=("sex",), decision="hired", utility={"yes": "1"}, targets={"max_local_log": "0.2"}, bets="joint")
    >>> joint_ratios(made)
    (Fraction(1, 1), Fraction(1221, 1000))
    """
    if settings.bets != "joint":
        return ()
    limits = [limit_of(settings, quantity) for quantity in ("local", "global")]
    near = [Fraction(round(1000 * limit), 1000) for limit in limits if limit is not None and limit < GREATEST]
    return tuple(dict.fromkeys([Fraction(1), *near]))


def subject(settings: Settings, counts: Counts, decisions: list[tuple[str, str]]) -> Subject | None:
    """Turn counts into a law, its utility and the order of arrival; None as long as there are no two groups."""
    if len({group for _, group in counts.order}) < 2:
        return None
    names = (*settings.context, *settings.group)
    table: dict[str, list[Any]] = {name: [] for name in names}
    table[settings.decision], amount = [], list[int]()
    count_name = next(name for name in ("count", "count_", "count__", "n", "n_", "number") if name not in table)
    for (context, group), rank in counts.order.items():
        for number, (label, _) in enumerate(decisions):
            for name, text in zip(names, (*context, *group), strict=True):
                table[name].append(text)
            table[settings.decision].append(label)
            amount.append(counts.n.get((rank, number), 0))
    law = Law.from_counts(
        {**table, count_name: amount}, decision=settings.decision, group=settings.group, context=settings.context, count=count_name
    )
    utility = Utility(dict(decisions))
    return Subject(law, utility, Arrivals(tuple(counts.order), settings.expected, settings.joint, joint_ratios(settings)))


def alarm_counts(alarm: dict[str, Any]) -> Counts:
    """What had been counted when an alarm was raised."""
    order = {(tuple(x), tuple(a)): rank for rank, (x, a) in enumerate(alarm["order"], 1)}
    return Counts(order, {(rank, number): n for rank, number, n in alarm["counts"]})


def window_of(settings: Settings, alarm: dict[str, Any], decisions: list[tuple[str, str]]) -> Window:
    """The window that contradicted the stream, as it was when the alarm was raised."""
    found = subject(settings, alarm_counts({"order": alarm["window_order"], "counts": alarm["window_counts"]}), decisions)
    if found is None:
        raise InputError("the window of an alarm holds no two groups; the state was altered")
    return found.window(alarm["window"])
