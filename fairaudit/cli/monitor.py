"""`fairaudit monitor`: watch a stream of decisions with bounds that hold at every moment."""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.options import add_command, add_limits, given_limits
from fairaudit.cli.output import Answer
from fairaudit.measures.limits import LIMITS

if TYPE_CHECKING:
    from fairaudit.cli.monitor_answers import Baseline, Screen
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

AUDIT = (
    *LOOKED_AT,
    *LIMITS,
    *("confidence", "expected_cells", "unit", "event_id", "time", "since", "window", "log_format", "burden", "run_length", "bets"),
    "pair_by_time",
)


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "monitor", run, CORE["monitor"], DESCRIPTION, EPILOG)
    parser.add_argument("log", metavar="LOG", nargs="?", help="the log: a file, or - for standard input; of a state, its own by default")
    _add_audit(parser)
    _add_running(parser)


def _add_audit(parser: argparse.ArgumentParser) -> None:
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
    audit.add_argument(
        "--run-length",
        metavar="B",
        type=_run_length,
        help="with a target: raise an alarm when the ratio comes to be above it; a false one comes after B pairs of decisions or more in "
        "the mean (default 20000; 0: none)",
    )
    audit.add_argument(
        "--bets",
        choices=("separate", "joint"),
        help="by what bounds are found: bets on single cells (default), or on both cells of a pair, narrower unless utilities are rare",
    )
    audit.add_argument(
        "--pair-by-time",
        action="store_const",
        const=True,
        help="also compare decisions made next to each other, whose means may move: says whether a ratio was above its target at some "
        "time, and whether seasons confound the whole stream (not part of certificates)",
    )
    audit.add_argument(
        "--log-format",
        choices=("jsonl", "csv"),
        help="how lines are written (default: by the name of the log); certify has an option of that name for logs of evaluations",
    )


def _add_running(parser: argparse.ArgumentParser) -> None:
    run_ = parser.add_argument_group("how to run")
    run_.add_argument("--state", metavar="FILE", help="keep the counts here, and go on where an earlier run stopped")
    run_.add_argument("--follow", action="store_true", help="wait for more when the log ends")
    run_.add_argument("--every", metavar="SECONDS", type=_seconds, default=2.0, help="how often to say what is known (default 2)")
    run_.add_argument(
        "--exit-on",
        choices=("exceeds", "changed"),
        help="stop at the first moment that a target is exceeded, with exit code 1; or also when the ratio changed",
    )
    run_.add_argument(
        "--same-content",
        choices=("refuse", "accept"),
        default="refuse",
        help="another log that begins with what the state has counted: refuse (default), or count it; the same file is always refused",
    )
    run_.add_argument("--dead-letters", metavar="FILE", help="where lines go that cannot be counted, with the reason")
    run_.add_argument(
        "--baseline",
        metavar="CERTIFICATE",
        help="say whether the ratios have changed since this certificate, and whether the decisions so far left the radius of its verdicts",
    )
    run_.add_argument("--prometheus", metavar="FILE", help="write the figures there for a Prometheus text-file collector")
    run_.add_argument(
        "--format",
        choices=("text", "json"),
        default=None,
        help="text for people, or a line of JSON each time (default: as standard output is a terminal or not)",
    )


def run(arguments: argparse.Namespace) -> Iterator[Answer]:
    """Do the work."""
    from fairaudit.cli.monitor_answers import Screen
    from fairaudit.cli.output import is_json
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
        monitor = Monitor(state, path, arguments.dead_letters, arguments.same_content)
    except InputError:
        state.close()
        raise
    screen = Screen(monitor, baseline, arguments.prometheus, json=is_json(arguments.format))
    try:
        yield from _watch(arguments, monitor, screen)
    finally:
        monitor.close()


def _watch(arguments: argparse.Namespace, monitor: Monitor, screen: Screen) -> Iterator[Answer]:
    """Answer with each alarm as it is raised, with what is known every few seconds, and with what is known at the end."""
    from fairaudit.errors import InputError

    said = time.monotonic()
    told = len(monitor.alarms)
    while True:
        for _ in monitor.read(follow=arguments.follow, eager=arguments.exit_on is not None):
            yield from map(screen.alarm, monitor.alarms[told:])
            told = len(monitor.alarms)
            if any(_ends_watch(alarm, arguments.exit_on) for alarm in monitor.alarms):
                code = 1 if any(_ends_watch(alarm, "exceeds") for alarm in monitor.alarms) else 3
                yield from (answer._replace(code=code) for answer in screen.look(last=True))
                return
            if time.monotonic() - said >= arguments.every:
                yield from screen.look()
                said = time.monotonic()
        if not arguments.follow or monitor.log.ended:
            break
        time.sleep(min(0.2, arguments.every))
        if time.monotonic() - said >= arguments.every:
            yield from screen.look()
            said = time.monotonic()
    if monitor.tally["dead"] and not (monitor.events or monitor.tally["repeats"] or monitor.tally["early"]):
        raise InputError(
            f"{monitor.log.path}: none of {monitor.tally['dead']} lines could be counted as {monitor.settings.layout}; name the columns "
            "of the log, and its form with --log-format (--dead-letters FILE lists the reasons)"
        )
    yield from screen.look(last=True)


def _ends_watch(alarm: dict[str, Any], asked: str | None) -> bool:
    return asked == "changed" or (asked == "exceeds" and bool(alarm.get("exceeds", True)))


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
    from fairaudit.streams.opening import default_run_length, window_length
    from fairaudit.streams.settings import Settings

    if (arguments.utility is None) == (arguments.utility_column is None):
        raise InputError("name one of --utility and --utility-column, such as --utility yes=1,maybe=0.5")
    if arguments.utility is not None and arguments.decision is None:
        raise InputError("no decision column was named; use --decision COL")
    if arguments.utility_column is not None and (arguments.decision is not None or arguments.utility_range is None):
        raise InputError("--utility-column takes the place of --decision, and needs --utility-range LOW,HIGH")
    utility = None if arguments.utility is None else utility_values(arguments.utility, "--utility")
    low, high = _range(arguments.utility_range, utility or {})
    targets, unit = given_limits(arguments), column_list(arguments.unit)
    return Settings(
        group=_labels("--group", arguments.group),
        context=_labels("--context", arguments.context),
        decision=arguments.decision or arguments.utility_column,
        utility=utility,
        low=low,
        high=high,
        step=arguments.utility_step,
        confidence=arguments.confidence or "0.95",
        targets=targets,
        expected=arguments.expected_cells or 4,
        unit=unit,
        event_id=arguments.event_id,
        time=arguments.time,
        since=arguments.since,
        window=None if arguments.window is None else window_length(arguments.window, "--window"),
        burden=bool(arguments.burden),
        bets=arguments.bets or "separate",
        pair_by_time=bool(arguments.pair_by_time),
        run_length=default_run_length(arguments.run_length, targets, unit),
        layout=arguments.log_format or ("csv" if str(arguments.log).endswith(".csv") else "jsonl"),
    )


def _range(text: str | None, utility: Mapping[str, str]) -> tuple[str, str]:
    """Least and greatest utility: as given, or from 0 to the greatest of those that are listed."""
    from fairaudit.errors import InputError
    from fairaudit.streams.opening import greatest

    if text is None:
        return "0", greatest(utility)
    low, comma, high = text.partition(",")
    if not comma:
        raise InputError("--utility-range is of the form LOW,HIGH, such as 0,1")
    return low.strip(), high.strip()


def _whole(text: str) -> int:
    if not re.fullmatch("[1-9][0-9]{0,6}", text):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number of at least 1")
    return int(text)


def _run_length(text: str) -> int:
    if not re.fullmatch("[0-9]{1,13}", text):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number of pairs, such as 20000, or 0")
    return int(text)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1
    if not 0.05 <= value <= 86_400:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number of seconds between 0.05 and 86400")
    return value


def _baseline(path: str) -> Baseline:
    """The ends of R in a certificate, with the confidence of both together; of a table without intervals, its exact figures."""
    from fairaudit.certificates.moved_laws import radii_of_table
    from fairaudit.certificates.reader import subject
    from fairaudit.cli.monitor_answers import Baseline
    from fairaudit.errors import InputError

    def end(text: str) -> Fraction | float:
        return inf if text == "inf" else Fraction(text)

    try:
        document = json.loads(Path(path).read_text("utf-8"))
        if document["format"] != "fairaudit-certificate/1":
            raise KeyError
        found: dict[str, tuple[Fraction | float, Fraction | float, Fraction]] = {}
        for quantity in ("local", "global"):
            interval, metric = document.get("intervals", {}).get(quantity), document["metrics"][quantity]
            if interval:
                error = (1 - Fraction(interval["confidence"])) * (2 if interval["ends"] == "each" else 1)
                found[quantity] = end(interval["ratio"][0]), end(interval["ratio"][1]), max(Fraction(0), 1 - error)
            elif metric:
                found[quantity] = end(metric["ratio"]), end(metric["ratio"]), Fraction(1)
        table = subject(document) if radii_of_table(document) else None
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, ZeroDivisionError):
        raise InputError(f"{path} is not a certificate; check it with fairaudit verify") from None
    return Baseline(found, document, table)
