"""`fairaudit monitor`: watch a stream of decisions with bounds that hold at every moment."""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import add_limits, given_limits
from fairaudit.measures.limits import LIMITS, limit_readings, limit_text

if TYPE_CHECKING:
    from fairaudit.streams.looks import Look
    from fairaudit.streams.settings import Settings
    from fairaudit.streams.stream import Monitor


DESCRIPTION = """\
Watch the decisions of a deployed system as they come. The bounds hold at all moments at once: look as often as you like, and stop
whenever you like. The log has one decision per line, as JSON objects or as CSV with a header."""


EPILOG = """\
exit codes: 0 within the targets, or no target; 1 a target is exceeded; 2 bad input; 3 inconclusive, or the ratio changed

examples:
  fairaudit monitor decisions.jsonl --decision answer --group sex --context job --utility yes --max-local-ratio 5/4
  fairaudit monitor log.jsonl --state watch.db --decision answer --group sex --utility yes --max-local-ratio 0.8 --follow --exit-on exceeds
  fairaudit monitor --state watch.db --follow
  fairaudit certify --from-monitor watch.db -o certificate.json"""


LOOKED_AT: tuple[str, ...] = ("decision", "group", "context", "utility", "utility_column", "utility_range", "utility_step")

AUDIT = (*LOOKED_AT, *LIMITS, "confidence", "expected_cells", "unit", "event_id", "time", "since", "window", "input", "burden")

KEPT = ("target", "changed", "window", "stream", "ratio", "error", "exceeds", "events", "line")


def add(commands: Any) -> None:
    """Declare the options."""
    parser = commands.add_parser(
        "monitor",
        help="watch a stream of decisions",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("log", metavar="LOG", nargs="?", help="the log: a file, or - for standard input; of a state, its own by default")
    audit = parser.add_argument_group("what is audited (choose before the first decision; a state remembers it)")
    audit.add_argument("--decision", metavar="COL", help="what was decided")
    audit.add_argument("--group", metavar="COL", action="append", help="sensitive attribute; several form intersections")
    audit.add_argument("--context", metavar="COL", action="append", help="what may legitimately matter")
    audit.add_argument("--utility", metavar="SPEC", help="decision[=number],…; decisions that are not listed are worth 0")
    audit.add_argument("--utility-column", metavar="COL", help="column with the utility of each decision; needs --utility-range")
    audit.add_argument(
        "--burden", action="store_const", const=True, help="the utility counts a burden: the group with more of it is disadvantaged"
    )
    audit.add_argument("--utility-range", metavar="LOW,HIGH", help="least and greatest utility of anything that could come")
    audit.add_argument("--utility-step", metavar="Q", help="round the utilities of --utility-column to multiples of this, and audit that")
    audit.add_argument("--unit", metavar="COL", action="append", help="in each context and group, only the first decision of a unit counts")
    audit.add_argument("--event-id", metavar="COL", help="drop decisions whose id was seen before")
    add_limits(audit)
    audit.add_argument("--confidence", metavar="C", help="with which the bounds hold at every moment (default 0.95)")
    audit.add_argument(
        "--expected-cells", metavar="K", type=_whole, help="about how many combinations of context and group will appear (default 4)"
    )
    audit.add_argument("--time", metavar="COL", help="when it was decided: ISO 8601, or seconds since 1970")
    audit.add_argument("--since", metavar="TIME", help="earlier decisions do not count")
    audit.add_argument("--window", metavar="SIZE", help="judge windows too: a number of decisions, or a time such as 12h, 7d")
    audit.add_argument("--input", choices=("jsonl", "csv"), help="how the log is written (default: by its name)")
    run_ = parser.add_argument_group("how to run")
    run_.add_argument("--state", metavar="FILE", help="keep the counts here, and go on where an earlier run stopped")
    run_.add_argument("--follow", action="store_true", help="wait for more when the log ends")
    run_.add_argument("--interval", metavar="SECONDS", type=_seconds, default=2.0, help="how often to say what is known (default 2)")
    run_.add_argument(
        "--exit-on",
        choices=("exceeds", "changed"),
        help="stop at the first moment that a target is exceeded, with exit code 1; or also when a window contradicts the stream",
    )
    run_.add_argument("--dead-letters", metavar="FILE", help="where lines go that cannot be counted, with the reason")
    run_.add_argument("--baseline", metavar="CERTIFICATE", help="say whether the ratios have changed since this certificate")
    run_.add_argument("--prometheus", metavar="FILE", help="write the figures there for a Prometheus text-file collector")
    run_.add_argument("--format", choices=("text", "json"), default=None, help="text for people, or a line of JSON each time")


def run(arguments: argparse.Namespace) -> int:
    """Do the work."""
    from fairaudit.errors import InputError
    from fairaudit.streams.state import State
    from fairaudit.streams.stream import Monitor

    given = [name for name in AUDIT if getattr(arguments, name) is not None]
    settings = _settings(arguments) if given else None
    baseline = None if arguments.baseline is None else _baseline(arguments.baseline)
    state = State(arguments.state, settings)
    try:
        path = arguments.log or state.place().path
        if not path:
            raise InputError("no log was named; give a file, or - for standard input")
        monitor = Monitor(state, path, arguments.dead_letters)
    except InputError:
        state.close()
        raise
    screen = _Screen(arguments, monitor, baseline)
    try:
        return _watch(arguments, monitor, screen)
    finally:
        monitor.close()


def _watch(arguments: argparse.Namespace, monitor: Monitor, screen: _Screen) -> int:
    from fairaudit.errors import InputError

    said = time.monotonic()
    told = len(monitor.alarms)
    while True:
        for _ in monitor.read(follow=arguments.follow, eager=arguments.exit_on is not None):
            for alarm in monitor.alarms[told:]:
                screen.alarm(alarm)
            told = len(monitor.alarms)
            if any(_ends_watch(alarm, arguments.exit_on) for alarm in monitor.alarms):
                screen.show(monitor.look(), last=True)
                return 1 if any(_ends_watch(alarm, "exceeds") for alarm in monitor.alarms) else 3
            if time.monotonic() - said >= arguments.interval:
                screen.show(monitor.look())
                said = time.monotonic()
        if not arguments.follow or monitor.log.ended:
            break
        time.sleep(min(0.2, arguments.interval))
        if time.monotonic() - said >= arguments.interval:
            screen.show(monitor.look())
            said = time.monotonic()
    found = monitor.look()
    screen.show(found, last=True)
    if monitor.tally["dead"] and not (found.events or monitor.tally["repeats"] or monitor.tally["early"]):
        raise InputError(
            f"{monitor.log.path}: none of {monitor.tally['dead']} lines could be counted as {monitor.settings.layout}; name the columns "
            "of the log, and its form with --input (--dead-letters FILE lists the reasons)"
        )
    return found.exit_code


def _ends_watch(alarm: dict[str, Any], asked: str | None) -> bool:
    return asked == "changed" or (asked == "exceeds" and bool(alarm.get("exceeds", True)))


def _limit(target: Mapping[str, str]) -> str:
    """The limit of a target or alarm in words."""
    return limit_text(*LIMITS[target["target"]], Fraction(target["limit"]))


def _labels(option: str, given: list[str] | None) -> tuple[str, ...]:
    """Names of label columns; intervals, which `certify` cuts, are refused."""
    from fairaudit.cli.options import column_roles
    from fairaudit.errors import InputError, shown

    roles = column_roles(given)
    for name, edges in roles.edges.items():
        cut = f"{name}:{','.join(edges)}"
        raise InputError(
            f"{option} {shown(cut)} cuts numbers into intervals, which a monitor does not do; write the interval into the log as a column "
            f"of its own, or quote the name if it is one, as in '\"{name}:{edges[0]}\"'"
        )
    return roles.names


def _settings(arguments: argparse.Namespace) -> Settings:
    from fairaudit.cli.options import column_list
    from fairaudit.errors import InputError
    from fairaudit.model.utility import utility_values
    from fairaudit.streams.opening import greatest, window_length
    from fairaudit.streams.settings import Settings

    if (arguments.utility is None) == (arguments.utility_column is None):
        raise InputError("name one of --utility and --utility-column, such as --utility yes=1,maybe=0.5")
    if arguments.utility is not None and arguments.decision is None:
        raise InputError("no decision column was named; use --decision COL")
    if arguments.utility_column is not None and (arguments.decision is not None or arguments.utility_range is None):
        raise InputError("--utility-column takes the place of --decision, and needs --utility-range LOW,HIGH")
    utility = None if arguments.utility is None else utility_values(arguments.utility, "--utility")
    if arguments.utility_range is None:
        low, high = "0", greatest(utility or {})
    else:
        low, comma, high = arguments.utility_range.partition(",")
        if not comma:
            raise InputError("--utility-range is of the form LOW,HIGH, such as 0,1")
    return Settings(
        group=_labels("--group", arguments.group),
        context=_labels("--context", arguments.context),
        decision=arguments.decision or arguments.utility_column,
        utility=utility,
        low=low.strip(),
        high=high.strip(),
        step=arguments.utility_step,
        confidence=arguments.confidence or "0.95",
        targets=given_limits(arguments),
        expected=arguments.expected_cells or 4,
        unit=column_list(arguments.unit),
        event_id=arguments.event_id,
        time=arguments.time,
        since=arguments.since,
        window=None if arguments.window is None else window_length(arguments.window, "--window"),
        burden=bool(arguments.burden),
        layout=arguments.input or ("csv" if str(arguments.log).endswith(".csv") else "jsonl"),
    )


def _whole(text: str) -> int:
    if not re.fullmatch("[1-9][0-9]{0,6}", text):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number of at least 1")
    return int(text)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1
    if not 0.05 <= value <= 86_400:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number of seconds between 0.05 and 86400")
    return value


def _baseline(path: str) -> dict[str, tuple[float, float, Fraction]]:
    """The ends of R in a certificate, with the confidence of each; of a table without intervals, its exact figures."""
    from fairaudit.errors import InputError

    def end(text: str) -> float:
        return float("inf") if text == "inf" else float(Fraction(text))

    try:
        document = json.loads(Path(path).read_text("utf-8"))
        if document["format"] != "fairaudit-certificate/1":
            raise KeyError
        found = {}
        for quantity in ("local", "global"):
            interval, metric = document.get("intervals", {}).get(quantity), document["metrics"][quantity]
            if interval:
                found[quantity] = end(interval["ratio"][0]), end(interval["ratio"][1]), Fraction(interval["confidence"])
            elif metric:
                found[quantity] = end(metric["ratio"]), end(metric["ratio"]), Fraction(1)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, ZeroDivisionError):
        raise InputError(f"{path} is not a certificate; check it with fairaudit verify") from None
    return found


class _Screen:
    """Where the monitor says what it knows: a terminal that is refreshed, lines of text, or lines of JSON."""

    def __init__(self, arguments: argparse.Namespace, monitor: Monitor, baseline: dict[str, tuple[float, float, Fraction]] | None) -> None:
        self.monitor, self.baseline, self.prometheus = monitor, baseline, arguments.prometheus
        terminal = sys.stdout is not None and sys.stdout.isatty()
        self.json = arguments.format == "json" or (arguments.format is None and not terminal)
        self.refresh = terminal and not self.json
        self.height = 0
        self.began, self.before = time.monotonic(), monitor.events
        self.windows = 0

    def alarm(self, alarm: dict[str, Any]) -> None:
        """Say that a target is exceeded for the first time."""
        from fairaudit.words import plain

        entry = {key: value for key, value in alarm.items() if not key.endswith(("order", "counts"))}
        if self.json:
            if "target" in alarm:
                entry["readings"] = limit_readings(LIMITS[alarm["target"]][1], Fraction(alarm["limit"]))
            print(json.dumps({"alarm": entry}), flush=True)
        elif "changed" in alarm:
            self._clear()
            print(f"ALARM: {_contradicted(alarm)}", flush=True)
        else:
            self._clear()
            lower = float(Fraction(alarm["lower"]))
            said = f"ALARM: {_limit(alarm)}: exceeded after {alarm['events']} decisions (line {alarm['line']}), "
            print(plain(said) + f"R is at least {lower:.4g}{_who(alarm)}", flush=True)

    def show(self, found: Look, *, last: bool = False) -> None:
        """Say what is known now."""
        for note in self.monitor.notes:
            print(f"note: {note}", file=sys.stderr)
        self.monitor.notes.clear()
        entry = self._entry(found)
        if self.prometheus is not None:
            _write_prometheus(self.prometheus, entry)
        if self.json:
            for window in self.monitor.closed:
                print(json.dumps(_finite({"window_closed": window})), flush=True)
            print(json.dumps(_finite(entry)), flush=True)
        elif self.refresh or last:
            self._clear()
            lines = self._lines(entry)
            print("\n".join(lines), flush=True)
            self.height = 0 if last else len(lines)
        self.monitor.closed.clear()

    def _clear(self) -> None:
        if self.refresh and self.height:
            print(f"\x1b[{self.height}A\x1b[J", end="")
        self.height = 0

    def _entry(self, found: Look) -> dict[str, Any]:
        from fairaudit.streams.looks import pair_labels

        monitor, settings = self.monitor, self.monitor.settings
        order = monitor.total.order
        entry: dict[str, Any] = {
            "decisions": found.events,
            "contexts": len({x for x, _ in order}),
            "groups": len({a for _, a in order}),
            "per_second": round((found.events - self.before) / max(1e-9, time.monotonic() - self.began), 1),
            "confidence": settings.confidence,
            "ratio": {quantity: list(ends) for quantity, ends in found.intervals.items()},
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
            "alarms": [{key: alarm[key] for key in KEPT if key in alarm} for alarm in monitor.alarms],
            "dead_letters": monitor.tally["dead"],
            "repeats": monitor.tally["repeats"],
            "before_since": monitor.tally["early"],
            "clock_went_back": monitor.tally["back"],
        }
        if settings.window and monitor.tally["window"]:
            entry["window"] = monitor.window_entry()
        if self.baseline is not None:
            entry["change"] = {
                quantity: _change(found.intervals[quantity], self.baseline[quantity], settings)
                for quantity in found.intervals
                if quantity in self.baseline
            }
        return entry

    def _lines(self, entry: dict[str, Any]) -> list[str]:
        said = {
            "within": "WITHIN the targets",
            "exceeds": "EXCEEDS a target",
            "inconclusive": "INCONCLUSIVE so far",
            "none": "NO TARGET set",
            "changed": "CHANGED: the ratio did not stay the same",
        }
        amount = f"{entry['decisions']} decisions ({entry['per_second']:.0f} per second)"
        lines = [f"{said[entry['verdict']]} after {amount}; {entry['contexts']} contexts, {entry['groups']} groups"]
        for quantity, (low, high) in entry["ratio"].items():
            lines.append(f"  {quantity + ' ratio R':<16} {_ends(low, high)} at every moment, at confidence {entry['confidence']}")
        lines += [f"  {_limit(target)}: {target['verdict']}{_who(target)}" for target in entry["targets"]]
        for alarm in entry["alarms"]:
            if "changed" in alarm:
                lines.append(f"  {_contradicted(alarm)}")
            else:
                lines.append(f"  first alarm of {alarm['target']} after {alarm['events']} decisions (line {alarm['line']})")
        if "window" in entry:
            window = entry["window"]
            ends = ", ".join(f"{quantity} {_ends(low, high)}" for quantity, (low, high) in window["intervals"].items())
            lines.append(f"  window {window['window']}: {window['events']} decisions, {ends or 'nothing compared'}: {window['verdict']}")
        for quantity, change in entry.get("change", {}).items():
            lines.append(f"  {quantity} ratio against the baseline: {change['verdict']} (at confidence {change['confidence']})")
        counted = [(entry["dead_letters"], "could not be read"), (entry["repeats"], "repeats left out")]
        counted += [(entry["before_since"], "before --since"), (entry["clock_went_back"], "with a clock that went back")]
        lines += [f"  {n} lines {what}" for n, what in counted if n]
        return lines


def _contradicted(alarm: dict[str, Any]) -> str:
    """A contradiction between a window and the stream, in a sentence."""
    stream, window = (_ends(*(float(Fraction(end)) if end != "inf" else float("inf") for end in alarm[key])) for key in ("stream", "ratio"))
    return (
        f"the {alarm['changed']} ratio changed: {window} in window {alarm['window']}, {stream} in the whole stream until then "
        f"(after {alarm['events']} decisions); what was said about the whole stream is withdrawn. Were the ratio constant, this would "
        f"happen with probability at most {float(Fraction(alarm['error'])):.4g}"
    )


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


def _change(now: tuple[float, float], then: tuple[float, float, Fraction], settings: Settings) -> dict[str, Any]:
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
    return "inf" if value == float("inf") else value


def _write_prometheus(path: str, entry: dict[str, Any]) -> None:
    """Write the figures in the Prometheus text format, the whole file at once."""
    from fairaudit.files import write_atomically

    lines = []

    def metric(name: str, kind: str, help_text: str, samples: list[tuple[str, Any]]) -> None:
        lines.append(f"# HELP fairaudit_{name} {help_text}")
        lines.append(f"# TYPE fairaudit_{name} {kind}")
        for labels, value in samples:
            lines.append(f"fairaudit_{name}{labels} {'+Inf' if value == float('inf') else value}")

    metric("decisions_total", "counter", "Decisions that count.", [("", entry["decisions"])])
    metric("dead_letters_total", "counter", "Lines that could not be counted.", [("", entry["dead_letters"])])
    metric("repeats_total", "counter", "Decisions that were seen before.", [("", entry["repeats"])])
    ends = [
        (f'{{quantity="{q}",end="{side}"}}', value)
        for q, pair in entry["ratio"].items()
        for side, value in zip(("lower", "upper"), pair, strict=True)
    ]
    metric("ratio", "gauge", "Ends of the ratio R at every moment.", ends)
    ranks = {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3, "changed": 4}
    metric(
        "verdict",
        "gauge",
        "0 within, 1 exceeds, 3 inconclusive, 4 changed.",
        [(f'{{target="{t["target"]}"}}', ranks[t["verdict"]]) for t in entry["targets"]],
    )
    raised = [alarm for alarm in entry["alarms"] if "target" in alarm]
    metric("alarms_total", "counter", "Targets that were exceeded at some moment.", [("", len(raised))])
    changed = [(f'{{quantity="{q}"}}', int(any(a.get("changed") == q for a in entry["alarms"]))) for q in ("local", "global")]
    metric("changed", "gauge", "1 if a window contradicted the whole stream.", changed)
    write_atomically(Path(path), [("\n".join(lines) + "\n").encode("utf-8")])
