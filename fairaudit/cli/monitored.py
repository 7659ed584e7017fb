"""`fairaudit certify --from-monitor STATE`: a certificate of what a monitor has counted."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from fairaudit.measures.limits import LIMITS

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
    "utility",
    "utility_column",
    "confidence",
    "unit",
    "interval",
    "utility_range",
    "independent_cells",
    "two_sided",
    "placebo",
    "claimed_exp_epsilon",
    "no_table",
    "in_parts",
    "burden",
    "fold_labels",
    "map",
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
    from fairaudit.cli.certified import certified
    from fairaudit.cli.destinations import check_output
    from fairaudit.errors import InputError
    from fairaudit.streams.letters import reasons
    from fairaudit.streams.state import State
    from fairaudit.streams.subjects import alarm_counts, subject, window_of
    from fairaudit.tables.preparation import unread

    _refuse_settled(arguments)
    check_output(arguments)
    state = State(arguments.from_monitor, read_only=True)
    settings, counts, decisions = state.settings, state.counts(), state.decisions()
    tally, alarms = state.get("tally", {}), state.alarms()
    state.close()
    if arguments.at_alarm:
        if not alarms:
            raise InputError(f"{arguments.from_monitor}: no alarm has been raised")
        counts, alarms = alarm_counts(alarms[0]), alarms[:1]
    moment = alarms[0] if arguments.at_alarm else None
    changes = sorted((alarm for alarm in alarms if "changed" in alarm), key=lambda alarm: alarm["changed"] != "local")
    if changes:
        moment = changes[0]
        counts = alarm_counts(moment)
    found = subject(settings, counts, decisions)
    if found is None:
        raise InputError(f"{arguments.from_monitor}: no two groups have been counted yet")
    dead = reasons(tally, moment)
    found = replace(found, law=replace(found.law, preparation=tuple(unread(reason, n) for reason, n in dead.items())))
    targets: dict[str, Any] = dict(settings.targets or {})
    declared = {"m": settings.low, "gamma": settings.high}
    options: dict[str, Any] = {"confidence": settings.confidence, "arrivals": found.arrivals, "burden": settings.burden}
    changed = (changes[0]["changed"], window_of(settings, changes[0], decisions)) if changes else None
    result = certify(found.law, found.utility, declared=declared, changed=changed, **options, **targets)
    notes = [f"the certificate is about the first {changes[0]['events']} decisions, at which the change showed"] if changes else []
    notes += [f"{tally[key]} {what}" for key, what in TALLIED if tally.get(key)]
    return certified(arguments, result, [], notes)
