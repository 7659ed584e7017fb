"""What a monitor says: each alarm, each window that closed, and what is known at a moment; in words, and as JSON."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any

from fairaudit.cli.output import Answer
from fairaudit.measures.limits import LIMITS, limit_cells, limit_readings, limit_text
from fairaudit.words import noun

if TYPE_CHECKING:
    from fairaudit.certificates.reader import Subject
    from fairaudit.streams.looks import Look
    from fairaudit.streams.settings import Settings
    from fairaudit.streams.stream import Monitor

__all__ = ["Baseline", "Screen"]


@dataclass(frozen=True)
class Baseline:
    """A certificate: both ends of R with the confidence with which they hold, and its table where verdicts on it have a radius."""

    ends: Mapping[str, tuple[Fraction | float, Fraction | float, Fraction]]
    certificate: Mapping[str, Any]
    table: Subject | None


KEPT = ("target", "changed", "window", "stream", "ratio", "error", "exceeds", "events", "line")

DETECTED = ("detected", "limit", "pair", "since", "run_length", "directions", "under")

CONSTANT = "the ratio is constant in time, means may move"  # under which alone the upper end of pairs in time bounds the ratio

CONFOUNDS = "time confounds"

ADVICE = "make the time (the hour, the month) a context, or go by the pairs in time"

LEFT_OUT = {
    "dead_letters": "could not be read",
    "repeats": "repeats left out",
    "before_since": "before --since",
    "clock_went_back": "with a clock that went back",
}

HEADLINES = {
    "within": "WITHIN the targets",
    "exceeds": "EXCEEDS a target",
    "inconclusive": "INCONCLUSIVE so far",
    "none": "NO TARGET set",
    "changed": "CHANGED: the ratio did not stay the same",
}


class Screen:
    """Answers of a monitor; on a terminal, what was known is replaced by what is known now."""

    def __init__(self, monitor: Monitor, baseline: Baseline | None, prometheus: str | None, *, json: bool) -> None:
        self.monitor, self.baseline, self.prometheus = monitor, baseline, prometheus
        self._json = json
        self._refresh = sys.stdout is not None and sys.stdout.isatty() and not json
        self._height = 0
        self._began, self._before = time.monotonic(), monitor.events

    def alarm(self, alarm: dict[str, Any]) -> Answer:
        """Say that a target is exceeded for the first time, or that a window contradicts the stream."""
        from fairaudit.streams.left_out import LeftOut
        from fairaudit.streams.subjects import alarm_counts
        from fairaudit.words import plain

        entry = {key: value for key, value in alarm.items() if not key.endswith(("order", "counts"))}
        if "left_out" in alarm:
            entry["left_out"] = LeftOut(alarm["left_out"]).entry(self.monitor.settings.group, alarm_counts(alarm).by_group())
        if "detected" in alarm:
            entry["readings"] = limit_readings("ratio", Fraction(alarm["limit"]))
            said = _detected(alarm)
        elif "changed" in alarm:
            said = _contradicted(alarm)
        else:
            entry["readings"] = limit_readings(LIMITS[alarm["target"]][1], Fraction(alarm["limit"]))
            lower = float(Fraction(alarm["lower"]))
            said = f"{_limit(alarm)}: exceeded after {alarm['events']} {noun(alarm['events'], 'decision')} (line {alarm['line']}), "
            said = plain(said) + f"R is at least {lower:.4g}{_who(alarm)}"
        text = self._cleared() + "\n".join(_wrapped(f"ALARM: {said}"))
        return Answer(
            "monitor",
            verdict="changed" if "changed" in alarm else "inconclusive" if "detected" in alarm else "exceeds",
            sentence=f"{said[0].upper()}{said[1:]}.",
            result=lambda: {"event": "alarm", **entry},
            text=lambda: text,
        )

    def look(self, *, last: bool = False) -> Iterator[Answer]:
        """Say what is known now, after the windows that closed since."""
        found = self.monitor.look()
        notes, closed = tuple(self.monitor.notes), tuple(self.monitor.closed)
        if found.by_time is not None and found.by_time.confounds:
            notes += (f"{CONFOUNDS}: {ADVICE}",)
        self.monitor.notes.clear()
        self.monitor.closed.clear()
        entry = self._entry(found)
        if self.prometheus is not None:
            from fairaudit.cli.prometheus import write_prometheus

            write_prometheus(self.prometheus, entry)
        if self._json:
            yield from map(_closed, closed)
        lines = _lines(entry)
        text = ""
        if self._refresh or last:
            shown = [part for line in lines for part in _wrapped(line)]
            text = self._cleared() + "\n".join(shown)
            self._height = 0 if last else len(shown)
        yield Answer(
            "monitor",
            verdict=found.verdict,
            sentence=f"{lines[0]}.",
            notes=notes,
            result=lambda: {"event": "look", **_finite(entry)},
            text=lambda: text,
            code=found.exit_code,
        )

    def _cleared(self) -> str:
        """What removes the lines that were written last from a terminal."""
        height, self._height = self._height, 0
        return f"\x1b[{height}A\x1b[J" if self._refresh and height else ""

    def _entry(self, found: Look) -> dict[str, Any]:
        from fairaudit.inference.levels import window_share
        from fairaudit.streams.looks import pair_labels

        monitor, settings = self.monitor, self.monitor.settings
        order = monitor.total.order
        entry: dict[str, Any] = {
            "decisions": found.events,
            "contexts": len({x for x, _ in order}),
            "groups": len({a for _, a in order}),
            "per_second": round((found.events - self._before) / max(1e-9, time.monotonic() - self._began), 1),
            "confidence": settings.confidence,
            "ratio": found.intervals,
            "targets": [
                {
                    "target": name,
                    "limit": limit,
                    "readings": limit_readings(LIMITS[name][1], Fraction(limit)),
                    "verdict": found.verdicts[name],
                    "pair": pair_labels(found.pairs.get(name)),
                }
                for name, limit in (settings.targets or {}).items()
            ],
            "verdict": found.verdict,
            "alarms": [
                {key: alarm[key] for key in (*KEPT, *(DETECTED if "detected" in alarm else ())) if key in alarm} for alarm in monitor.alarms
            ],
            "dead_letters": monitor.tally["dead"],
            "repeats": monitor.tally["repeats"],
            "before_since": monitor.tally["early"],
            "clock_went_back": monitor.tally["back"],
        }
        if any(entry[name] for name in ("dead_letters", "repeats", "before_since")):
            entry["left_out"] = monitor.left_out.entry(settings.group, monitor.total.by_group())
        if found.by_time is not None:
            paired = found.by_time
            entry["by_time"] = {
                "pairs": paired.pairs,
                "ratio": [paired.lower, paired.upper],
                "confidence": str(paired.confidence),
                "assumption": CONSTANT,
                "exceeded": list(paired.exceeded),
                "pair": pair_labels(paired.pair),
                "time_confounds": paired.confounds,
                "error": str(paired.error),
            }
        if settings.window and monitor.tally["window"]:
            entry["window"] = monitor.window_entry()
        if monitor.tally["parts"]:
            since = monitor.look_since()
            confidence = 1 - (1 - Fraction(settings.confidence)) * window_share(monitor.tally["parts"])
            entry["since_alarm"] = {
                "events": since.events,
                "confidence": str(confidence),
                "intervals": since.intervals,
                "verdict": since.verdict,
            }
        if self.baseline is not None:
            entry["change"] = {
                quantity: _change(found.intervals[quantity], self.baseline.ends[quantity], settings)
                for quantity in found.intervals
                if quantity in self.baseline.ends
            }
            if self.baseline.table is not None:
                entry["radii"] = list(_radii(self.baseline.certificate, self.baseline.table, monitor))
        return entry


def _radii(certificate: Mapping[str, Any], table: Subject, monitor: Monitor) -> Iterator[dict[str, Any]]:
    """Whether what was counted so far left the radius of a verdict of the baseline."""
    from fairaudit.certificates.moved_laws import departures_so_far
    from fairaudit.certificates.numbers import number
    from fairaudit.certificates.reader import Subject

    now = monitor.subject()
    if now is None:
        return
    for found in departures_so_far(certificate, table, Subject(now.law, now.utility.on(now.law))):
        quantity, unit, _ = found.claim["quantity"].split("_")
        yield {
            "quantity": quantity,
            "unit": unit,
            "limit": found.claim["evidence"]["limit"],
            "verdict": found.claim["evidence"]["verdict"],
            "radius": number(found.radius),
            "moved": None if found.moved is None else number(found.moved),
            "cell": found.cell,
            "left": found.left,
            "sentence": found.sentence,
        }


def _closed(window: dict[str, Any]) -> Answer:
    return Answer(
        "monitor",
        verdict=window["verdict"],
        sentence=f"{_window(window)}.",
        result=lambda: {"event": "window", **_finite(window)},
        text=str,
    )


def _window(window: Mapping[str, Any]) -> str:
    ends = ", ".join(f"{quantity} {_ends(low, high)}" for quantity, (low, high) in window["intervals"].items())
    return (
        f"Window {window['window']}: {window['events']} {noun(window['events'], 'decision')}, "
        f"{ends or 'nothing compared'}: {window['verdict']}"
    )


def _lines(entry: dict[str, Any]) -> list[str]:
    from fairaudit.streams.left_out import said as left_out_of
    from fairaudit.words import plain

    size = ", ".join(f"{entry[f'{what}s']} {noun(entry[f'{what}s'], what)}" for what in ("context", "group"))
    lines = [f"{HEADLINES[entry['verdict']]} after {entry['decisions']} {noun(entry['decisions'], 'decision')}; {size}"]
    for quantity, (low, high) in entry["ratio"].items():
        lines.append(f"  {quantity + ' ratio R':<16} {_ends(low, high)} at every moment, at confidence {entry['confidence']}")
    lines += [f"  {_limit(target)}: {target['verdict']}{_who(target)}" for target in entry["targets"]]
    for alarm in entry["alarms"]:
        if "detected" in alarm:
            lines.append(f"  {_detected(alarm)}")
        elif "changed" in alarm:
            lines.append(f"  {_contradicted(alarm)}")
        else:
            lines.append(
                f"  first alarm of {alarm['target']} after {alarm['events']} {noun(alarm['events'], 'decision')} (line {alarm['line']})"
            )
    if "by_time" in entry:
        lines += _paired(entry["by_time"])
    if "window" in entry:
        said = _window(entry["window"])
        lines.append(f"  {said[0].lower()}{said[1:]}")
    if "since_alarm" in entry:
        part = entry["since_alarm"]
        ends = ", ".join(f"{quantity} {_ends(low, high)}" for quantity, (low, high) in part["intervals"].items())
        lines.append(
            f"  since the alarm: {part['events']} {noun(part['events'], 'decision')}, {ends or 'nothing compared'} at "
            f"every moment, at confidence "
            f"{part['confidence']}: {part['verdict']}"
        )
    for quantity, change in entry.get("change", {}).items():
        lines.append(f"  {quantity} ratio against the baseline: {change['verdict']} (at confidence {change['confidence']})")
    lines += [f"  {plain(radius['sentence'])} (the decisions so far)" for radius in entry.get("radii", ())]
    for name, what in LEFT_OUT.items():
        groups = left_out_of(entry["left_out"], name) if entry[name] and name != "clock_went_back" else ""
        lines += [f"  {entry[name]} {noun(entry[name], 'line')} {what}{groups and f': {groups}'}"] if entry[name] else []
    return lines


def _wrapped(line: str) -> list[str]:
    """A line in lines of a screen, each as far from the left, those after the first a little more."""
    from fairaudit.words import COLUMNS, wrapped

    text = line.lstrip(" ")
    indent = len(line) - len(text)
    return [" " * indent + part for part in wrapped(text, 2, COLUMNS - indent)]


def _paired(found: dict[str, Any]) -> list[str]:
    """What pairs in time show."""
    from fairaudit.words import approximate

    low, high = found["ratio"]
    lines = [f"  by {found['pairs']} {noun(found['pairs'], 'pair')} in time, at every moment, at confidence {found['confidence']}:"]
    said = "no ratio above 1 is shown at any time"
    if low > 1:
        said = f"at some time the local ratio was above {approximate(Fraction(low), 'down')}{_who(found)}"
    lines.append(f"    {said}{''.join(f'; {name} was exceeded' for name in found['exceeded'])}")
    if high < inf:
        lines.append(f"    if {CONSTANT}: it is at most {approximate(Fraction(high), 'up')}")
    if found["time_confounds"]:
        lines.append(
            f"    {CONFOUNDS}: the interval of the whole stream and this one have no ratio in common, which means that do not move would "
            f"ever show with probability at most {_probability(found['error'])}; {ADVICE}"
        )
    return lines


def _limit(target: Mapping[str, str]) -> str:
    """The limit of a target or alarm in words."""
    return limit_text(*LIMITS[target["target"]], Fraction(target["limit"]))


def _contradicted(alarm: dict[str, Any]) -> str:
    """A contradiction between a window and the stream, in a sentence."""
    stream, window = (_ends(*(float(Fraction(end)) if end != "inf" else inf for end in alarm[key])) for key in ("stream", "ratio"))
    return (
        f"the {alarm['changed']} ratio changed: {window} in window {alarm['window']}, {stream} in the whole stream until then "
        f"(after {alarm['events']} decisions); what was said about the whole stream is withdrawn. Were the ratio constant, this would "
        f"happen with probability at most {float(Fraction(alarm['error'])):.4g}"
    )


def _detected(alarm: dict[str, Any]) -> str:
    """What a detector found, in a sentence."""
    from datetime import UTC, datetime

    limit, least, log = limit_cells("ratio", Fraction(alarm["limit"]))
    above = f"above {limit} (least under {least} of the greatest; log {log})"
    decision, clock = alarm["since"]["decision"], alarm["since"]["clock"]
    when = "" if clock is None else f", {datetime.fromtimestamp(clock, UTC).isoformat(timespec='seconds')}"
    often = (
        f"While no ratio is above {limit}, such an alarm comes after {alarm['run_length']} pairs of decisions per direction or more in the "
        f"mean (directions watched: {alarm['directions']}), and by now with probability at most {_probability(alarm['error'])}"
    )
    found = f"after {alarm['events']} decisions (line {alarm['line']}), by pairs{_who(alarm)}; estimated moment: decision {decision}{when}"
    if "changed" not in alarm:
        return f"the {alarm['detected']} ratio is {above}, now or from the beginning: seen {found}. {often}"
    return (
        f"the {alarm['changed']} ratio changed: it is {above}, under which the whole stream was after {alarm['under']} decisions; "
        f"seen {found}; what was said about the whole stream is withdrawn. {often}"
    )


def _probability(error: str) -> str:
    from fairaudit.words import approximate

    return approximate(Fraction(error), "up")


def _who(target: dict[str, Any]) -> str:
    """The pair of groups behind the end that decided a target."""
    from fairaudit.words import place, plain

    if target.get("pair") is None:
        return ""
    context, higher, lower = (place(target["pair"][key] or {}) for key in ("context", "higher", "lower"))
    return plain(f", {f'{context}: ' if context else ''}{higher} over {lower}")


def _ends(low: float, high: float) -> str:
    """Both ends of a ratio, rounded outwards."""
    from fairaudit.words import approximate

    return f"{approximate(Fraction(low), 'down')} to {approximate(Fraction(high) if high < float('inf') else high, 'up')}"


def _change(now: tuple[float, float], then: tuple[Fraction | float, Fraction | float, Fraction], settings: Settings) -> dict[str, Any]:
    """Whether R has changed: both intervals hold together but with the sum of their errors."""
    low, high, confidence = then
    judged = "greater" if now[0] > high else "smaller" if now[1] < low else "no change shown"
    return {"verdict": judged, "baseline": [low, high], "confidence": str(max(Fraction(0), confidence - settings.alpha))}


def _finite(value: Any) -> Any:
    """The same with "inf" for infinity, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return "inf" if value == inf else value
