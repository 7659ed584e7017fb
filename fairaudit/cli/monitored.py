"""`fairaudit certify --from-monitor STATE`: a certificate of what a monitor has counted."""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.cli.population import OF_SAMPLES
from fairaudit.measures.limits import LIMITS
from fairaudit.tables.number_form import TEXT_FORM

if TYPE_CHECKING:
    from fairaudit.cli.output import Answer

TALLIED = (
    ("dead", "lines could not be counted"),
    ("repeats", "decisions were repeats and left out"),
    ("early", "decisions were made before --since and left out"),
)


SETTLED = (
    "table",
    "example",
    "decision",
    "group",
    "context",
    "count",
    "probability",
    "weight",
    "wide",
    "total",
    "utility",
    "utility_column",
    "confidence",
    "no_table",
    "in_parts",
    "burden",
    "fold_labels",
    "map",
    *TEXT_FORM,
    *OF_SAMPLES,
    *LIMITS,
)
"""Options that a state answers, or that its certificates do not have."""


def _refuse_settled(arguments: argparse.Namespace) -> None:
    from fairaudit.errors import InputError

    for name in SETTLED:
        if getattr(arguments, name):
            raise InputError(f"--{name.replace('_', '-')} was settled when the monitor began; {arguments.from_monitor} remembers it")


def certify_state(arguments: argparse.Namespace) -> Answer:
    """`fairaudit certify --from-monitor`: a certificate of what a state holds, at the settings of its audit."""
    from fairaudit.audits.certify import certify
    from fairaudit.cli.attesting import attesting
    from fairaudit.cli.certified import certified
    from fairaudit.cli.destinations import check_output
    from fairaudit.errors import InputError
    from fairaudit.inference.levels import window_share
    from fairaudit.inference.time_pairs import TimePairs
    from fairaudit.streams.left_out import LeftOut, said
    from fairaudit.streams.letters import reasons
    from fairaudit.streams.seasons import by_time
    from fairaudit.streams.state import State
    from fairaudit.streams.subjects import alarm_counts, subject, window_of
    from fairaudit.tables.preparation import unread

    _refuse_settled(arguments)
    check_output(arguments)
    stated = attesting(arguments, again=False)
    state = State(arguments.from_monitor, read_only=True)
    settings, counts, decisions = state.settings, state.counts(), state.decisions()
    tally, alarms = state.get("tally", {}), state.alarms()
    part = state.counts(-tally["parts"]) if tally.get("parts") else None
    tallies = TimePairs(state.get("time_pairs")) if settings.pair_by_time else None
    whole, lost = counts, LeftOut(state.get("left_out"), tally)
    state.close()
    if arguments.at_alarm:
        if not alarms:
            raise InputError(f"{arguments.from_monitor}: no alarm has been raised")
        provable = [alarm for alarm in alarms if "detected" not in alarm and "part" not in alarm]
        if not provable or any("changed" in alarm for alarm in alarms[: alarms.index(provable[0])]):
            raise InputError(
                f"{arguments.from_monitor}: the first alarm is that of a detector, which only the monitor can raise; leave out --at-alarm"
            )
        counts, alarms = alarm_counts(provable[0]), provable[:1]
    moment = alarms[0] if arguments.at_alarm else None
    changes = sorted((alarm for alarm in alarms if "changed" in alarm and "window" in alarm), key=lambda alarm: alarm["changed"] != "local")
    if changes:
        moment = changes[0]
        counts = alarm_counts(moment)
    confidence, dead = Fraction(settings.confidence), reasons(tally, moment)
    if moment is not None:
        lost = LeftOut(moment.get("left_out"), moment)
    detected = None if changes else next((alarm for alarm in reversed(alarms) if "changed" in alarm and part is not None), None)
    if detected is not None and part is not None:
        counts, confidence = part, 1 - (1 - confidence) * window_share(tally["parts"])
        last = next(alarm for alarm in reversed(alarms) if "detected" in alarm)
        dead = dict(Counter(dead) - Counter(reasons(tally, last)))
        lost = lost.since(LeftOut(last.get("left_out"), last))
    if tallies is not None and not changes and detected is None:
        paired = by_time(settings, whole.order, tallies, subject(settings, whole, decisions))
        if paired.confounds:
            raise InputError(
                f"{arguments.from_monitor}: time confounds, as pairs in time show: a certificate takes means to be constant, and they are "
                "not; make the time (the hour, the month) a context"
            )
    if stated is not None and (moment is not None or detected is not None or tally.get("repeats") or tally.get("early")):
        raise InputError(
            f"{arguments.from_monitor}: --attest says how much was read and why the rest was dropped, which is not known here: "
            "a part of the decisions is certified, or some were left out as repeats or as made before --since"
        )
    found = subject(settings, counts, decisions)
    if found is None:
        raise InputError(f"{arguments.from_monitor}: no two groups have been counted {'since the ratio changed' if detected else 'yet'}")
    found = replace(found, law=replace(found.law, preparation=tuple(unread(reason, n) for reason, n in dead.items())))
    targets: dict[str, Any] = dict(settings.targets or {})
    declared = {"m": settings.low, "gamma": settings.high}
    options: dict[str, Any] = {"confidence": confidence, "arrivals": found.arrivals, "burden": settings.burden}
    changed = (changes[0]["changed"], window_of(settings, changes[0], decisions)) if changes else None
    result = certify(found.law, found.utility, declared=declared, changed=changed, **options, **targets)
    notes = [f"the certificate is about the first {changes[0]['events']} decisions, at which the change showed"] if changes else []
    if detected is not None:
        notes.append(
            f"the {detected['detected']} ratio changed, as a detector says that only the monitor can run; the certificate is about the "
            f"decisions since its last alarm, after {last['events']} decisions"
        )
    if tallies is not None:
        notes.append("pairs in time are not part of a certificate: it takes means to be constant")
    amounts, by_group = tally | {"dead": sum(dead.values())}, said(lost.entry(settings.group, counts.by_group()), "dead_letters")
    said_of = {"dead": f": {by_group}" if by_group else ""}
    notes += [f"{amounts[key]} {what}{said_of.get(key, '')}" for key, what in TALLIED if amounts.get(key)]
    return certified(arguments, result, [], notes, stated)
