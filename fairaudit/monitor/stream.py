"""A monitor: reads decisions, keeps the counts, and says at any moment what they show."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import Any, Literal

from fairaudit.columns import Label, label_text
from fairaudit.exact import InputError, rational, rational_text, shown
from fairaudit.fairness import Witness
from fairaudit.label_text import json_number
from fairaudit.law import Law
from fairaudit.limits import LIMITS
from fairaudit.monitor.bounds import Arrivals, Quantity, Window, stream_interval
from fairaudit.monitor.reader import Batch, Decoder, Row, decoder, moment
from fairaudit.monitor.settings import OTHER, Settings
from fairaudit.monitor.state import Counts, State
from fairaudit.monitor.tail import Log
from fairaudit.sampling import Interval, verdict
from fairaudit.utility import Utility

__all__ = [
    "Contradiction",
    "Look",
    "Monitor",
    "Subject",
    "alarm_counts",
    "contradiction",
    "pair_labels",
    "reasons",
    "subject",
    "window_of",
    "window_share",
    "withdrawn",
]

Verdict = Literal["none", "within", "exceeds", "inconclusive", "changed"]
QUANTITIES: tuple[Quantity, ...] = ("local", "global")
RANK: dict[Verdict, int] = {"none": 0, "within": 1, "inconclusive": 2, "exceeds": 3, "changed": 4}
MAX_CELLS = 10_000
MAX_VALUES = 10_001
CACHED = 200_000
COMMIT_SECONDS = 0.1
FIRST_LOOKS = 1_000
LOOKS = 1.02
PATIENCE = 40
FUTURE = 86_400.0
SHOWN = 2_000
UNREADABLE, MISSING, UNUSABLE, UNKNOWN = "unreadable line", "missing label", "unusable value", "unknown reason"
NO_VALUE = "no value in column "


@dataclass(frozen=True)
class Subject:
    """What was counted, as `certify` takes it."""

    law: Law
    utility: Utility
    arrivals: Arrivals


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
        if self.verdict == "changed":
            return 1 if "exceeds" in self.verdicts.values() else 3
        return {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3}[self.verdict]


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
    return Subject(law, utility, Arrivals(tuple(counts.order), settings.expected, settings.joint))


def alarm_counts(alarm: dict[str, Any]) -> Counts:
    """What had been counted when an alarm was raised."""
    order = {(tuple(x), tuple(a)): rank for rank, (x, a) in enumerate(alarm["order"], 1)}
    return Counts(order, {(rank, number): n for rank, number, n in alarm["counts"]})


def window_of(settings: Settings, alarm: dict[str, Any], decisions: list[tuple[str, str]]) -> Window:
    """The window that contradicted the stream, as it was when the alarm was raised."""
    found = subject(settings, alarm_counts({"order": alarm["window_order"], "counts": alarm["window_counts"]}), decisions)
    if found is None:
        raise InputError("the window of an alarm holds no two groups; the state was altered")
    table = found.utility.on(found.law)
    return Window(alarm["window"], table.law, table, found.arrivals)


def pair_labels(pair: Witness | None) -> dict[str, Any] | None:
    """The labels of a pair of groups, as an alarm keeps them."""
    return None if pair is None else {"context": pair.context, "higher": pair.higher, "lower": pair.lower}


def reasons(tally: dict[str, Any], alarm: dict[str, Any] | None = None) -> dict[str, int]:
    """How many lines could not be counted so far, or when an alarm was raised, by reason.

    Examples
    --------
    >>> reasons({"dead": 5, "reasons": {"unreadable line": 3}})
    {'unreadable line': 3, 'unknown reason': 2}
    """
    known = tally if alarm is None or "dead" not in alarm else alarm
    listed = known.get("reasons", {})
    counts = {reason: listed.get(reason, 0) for reason in (UNREADABLE, MISSING, UNUSABLE)}
    counts[UNKNOWN] = known.get("dead", 0) - sum(counts.values())
    return {reason: n for reason, n in counts.items() if n}


def window_share(number: int) -> Fraction:
    """The part of the error that the windows have together, which window 1, 2, … gets: 1/(i(i+1))."""
    return Fraction(1, number * (number + 1))


def look(settings: Settings, found: Subject | None, events: int, share: Fraction = Fraction(1)) -> Look:
    """Judge all targets. Ends are floats first; a verdict other than inconclusive is given only by ends that are proved."""
    verdicts: dict[str, Verdict] = dict.fromkeys(settings.targets or {}, "inconclusive")
    intervals: dict[str, tuple[float, float]] = {}
    pairs: dict[str, Witness | None] = {}
    for quantity in QUANTITIES:
        interval = interval_of(settings, found, quantity, share, exact=False)
        if interval is None:
            continue
        asked = _asked(settings, quantity)
        if any(_judge(interval, name, limit) != "inconclusive" for name, limit in asked.items()):
            interval = interval_of(settings, found, quantity, share) or interval
            verdicts |= {name: _judge(interval, name, limit) for name, limit in asked.items()}
        pairs |= {name: interval.pairs[0 if verdicts[name] == "exceeds" else 1] for name in asked}
        intervals[quantity] = float(interval.lower), float(interval.upper)
    overall: Verdict = max(verdicts.values(), key=RANK.__getitem__, default="none")
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


def _asked(settings: Settings, quantity: Quantity) -> dict[str, str]:
    return {name: limit for name, limit in (settings.targets or {}).items() if LIMITS[name][0] == quantity}


def _texts(*ends: Fraction | float) -> list[str]:
    return [rational_text(end.as_integer_ratio()) if end != inf else "inf" for end in ends]


def _judge(interval: Interval, name: str, limit: str) -> Verdict:
    return verdict(interval, **{f"max_{LIMITS[name][1]}": limit})


class Monitor:
    """Reads a log into a state, and looks at it.

    Parameters
    ----------
    state : State
        Where counts are kept.
    path : str
        The log, or ``-``.
    letters : str or None
        File for lines that cannot be counted.

    Raises
    ------
    InputError
        If the log or that file cannot be used.
    """

    def __init__(self, state: State, path: str, letters: str | None = None) -> None:
        self.state, self.settings = state, state.settings
        place = state.place()
        self.log = Log(path, place)
        self._letters = self._open_letters(letters, place.letters)
        self.total, self.window = state.counts(), Counts()
        self.decisions = state.decisions()
        self._numbers = {label: number for number, (label, _) in enumerate(self.decisions)}
        self.tally: dict[str, Any] = {
            "dead": 0,
            "reasons": {},
            "repeats": 0,
            "early": 0,
            "back": 0,
            "clock": None,
            "window": 0,
            "index": None,
            "letters": None,
        } | state.get("tally", {})
        own = None if letters is None else os.path.realpath(letters)
        if self._letters is not None and self.tally["letters"] != own:
            # Known before the first line is written, so that a kill before the first commit leaves nothing behind.
            opened = asdict(replace(place, letters=self._letters.tell()))
            state.commit({}, [], [], {"tally": self.tally | {"letters": own}, "place": opened})
        self.tally["letters"] = own
        if self.tally["window"]:
            self.window = state.counts(self.tally["window"])
        self.alarms = state.alarms()
        self.closed: list[dict[str, Any]] = []
        self.notes: list[str] = []
        self._decoder: Decoder | None = None
        self._resolved: dict[Any, tuple[tuple[Label, Label], int] | str] = {}
        self._pending: dict[int, Counts] = {}
        self._uncounted: Counter[Any] = Counter()
        self._known: set[Any] = set()
        self._truth: tuple[bool, ...] = ()
        self._new_decisions: list[tuple[int, str, str]] = []
        self._new_alarms: list[dict[str, Any]] = []
        self.events = self.total.events
        self._window_events = self.window.events

    # Reading

    def read(self, *, follow: bool = False, eager: bool = False) -> Iterator[None]:
        """Read what there is, in parts; after each the counts are committed, and alarms raised.

        Parameters
        ----------
        follow : bool
            Whether a last line without an end may still get one.
        eager : bool
            Whether to look for alarms after every 1,000 decisions or 2 % more, whatever that costs; else it takes a fortieth of the time.
        """
        last, next_events, next_time = time.monotonic(), self.events, 0.0
        try:
            for data, line, place in self.log.chunks(follow=follow):
                self._take(data, line)
                self._place = place
                now = time.monotonic()
                if eager or now >= next_time or now - last > COMMIT_SECONDS:
                    self._flush()
                if (eager and self.events >= next_events) or (not eager and now >= next_time):
                    self._watch()
                    next_events = int(max(self.events + FIRST_LOOKS, self.events * LOOKS))
                    next_time = time.monotonic() + PATIENCE * (time.monotonic() - now)
                if now - last > COMMIT_SECONDS:
                    self.commit()
                    last = now
                    yield
            self._flush()
            self._watch()
            self.commit()
        except BaseException:
            self.state.roll_back()
            raise
        self.notes += self.log.notes
        self.log.notes.clear()
        yield

    def commit(self) -> None:
        """Store everything that was read."""
        place = getattr(self, "_place", None)
        if place is None and not (self._new_alarms or self._pending):
            return
        entries: dict[str, Any] = {"tally": self.tally}
        if place is not None:
            if self._letters is not None:
                self._letters.flush()
                place = replace(place, letters=self._letters.tell())
            entries["place"] = asdict(replace(place, header=self._header))
        orders = {self.tally["window"]: self.window.order, 0: self.total.order}
        added = {window: Counts(orders.get(window, counts.order), counts.n) for window, counts in self._pending.items()}
        self.state.commit(added, self._new_decisions, self._new_alarms, entries)
        self._pending, self._new_decisions, self._new_alarms = {}, [], []

    def look(self) -> Look:
        """What the whole stream shows now, as far as no window contradicts it."""
        self._compare_window()
        if self._new_alarms:
            self.commit()
        found, gone = look(self.settings, self.subject(), self.events), self.withdrawn
        if not gone:
            return found
        current = self._look_at_window()
        verdicts = dict(found.verdicts)
        for name in verdicts:
            if LIMITS[name][0] in gone:
                verdicts[name] = "exceeds" if name in self._exceeded or current.verdicts.get(name) == "exceeds" else "changed"
        judged = {LIMITS[name][0] for name in verdicts} or gone
        overall: Verdict = "changed" if gone & judged else max(verdicts.values(), key=RANK.__getitem__)
        pairs = {name: pair for name, pair in found.pairs.items() if LIMITS[name][0] not in gone}
        pairs |= {name: pair for name, pair in current.pairs.items() if name not in pairs and current.verdicts[name] == "exceeds"}
        return Look(found.events, {q: ends for q, ends in found.intervals.items() if q not in gone}, verdicts, overall, pairs)

    @property
    def withdrawn(self) -> frozenset[Quantity]:
        """The quantities whose interval a window contradicts."""
        return withdrawn(self.settings, self.alarms)

    @property
    def _exceeded(self) -> set[str]:
        """Targets that were exceeded at some moment, or in some window."""
        return {name for alarm in self.alarms for name in (alarm["exceeds"] if "changed" in alarm else [alarm["target"]])}

    def subject(self) -> Subject | None:
        """What was counted so far."""
        return subject(self.settings, self.total, self.decisions)

    def _watch(self) -> None:
        """Raise an alarm for each target that is exceeded for the first time, and where a window contradicts the stream."""
        self._compare_window()
        waiting = [name for name in self.settings.targets or {} if name not in self._exceeded]
        found = self.subject() if waiting else None
        for quantity in QUANTITIES:
            if quantity in self.withdrawn:
                continue
            asked = {name: limit for name, limit in _asked(self.settings, quantity).items() if name in waiting}
            interval = interval_of(self.settings, found, quantity, exact=False) if asked else None
            if interval and any(_judge(interval, name, limit) == "exceeds" for name, limit in asked.items()):
                interval = interval_of(self.settings, found, quantity) or interval
                for name, limit in asked.items():
                    if _judge(interval, name, limit) == "exceeds":
                        self._alarm(name, interval)

        if self._new_alarms:
            self.commit()

    def _alarm(self, name: str, interval: Interval, **where: int) -> None:
        limit, lower = (self.settings.targets or {})[name], rational_text(interval.lower.as_integer_ratio())
        self._raise({"target": name, "limit": limit, "lower": lower, "pair": pair_labels(interval.pairs[0]), **where})

    def _compare_window(self) -> None:
        """Raise an alarm for each quantity for which the current window contradicts the whole stream for the first time."""
        if not self.tally["window"] or len(self.withdrawn) == len(QUANTITIES):
            return
        whole, part = self.subject(), subject(self.settings, self.window, self.decisions)
        for quantity in QUANTITIES:
            found = None if quantity in self.withdrawn else contradiction(self.settings, whole, part, self.tally["window"], quantity)
            if found is not None:
                self._changed(found)

    def _changed(self, found: Contradiction) -> None:
        asked = _asked(self.settings, found.quantity)
        self._raise(
            {
                "changed": found.quantity,
                "window": found.number,
                "window_events": self._window_events,
                "stream": _texts(found.whole.lower, found.whole.upper),
                "ratio": _texts(found.part.lower, found.part.upper),
                "error": str(found.error),
                "exceeds": [name for name, limit in asked.items() if _judge(found.part, name, limit) == "exceeds"],
                "window_order": [[list(x), list(a)] for x, a in self.window.order],
                "window_counts": [[rank, number, n] for (rank, number), n in self.window.n.items()],
            }
        )

    def _raise(self, entry: dict[str, Any]) -> None:
        """Keep an alarm with the counts of the moment; it is stored with the next commit."""
        alarm = entry | {
            "events": self.events,
            "line": self._place.line - 1 if hasattr(self, "_place") else None,
            "clock": self.tally["clock"],
            "order": [[list(x), list(a)] for x, a in self.total.order],
            "counts": [[rank, number, n] for (rank, number), n in self.total.n.items()],
            "dead": self.tally["dead"],
            "reasons": dict(self.tally["reasons"]),
        }
        self.alarms.append(alarm)
        self._new_alarms.append(alarm)

    # Taking decisions in

    @property
    def _header(self) -> str:
        return self._header_line.decode("utf-8", "surrogateescape") if self.settings.layout == "csv" else ""

    _header_line = b""

    def _take(self, data: bytes, line: int) -> None:
        if self.settings.layout == "csv" and (line == 1 or self._decoder is None):
            data, line = self._take_header(data, line)
        if self._decoder is None:
            self._decoder = decoder(self.settings)
        batch = self._decoder.batch(data, line)
        if batch.rows is None:
            if self._decoder.truth != self._truth:  # 1 and true are equal keys, and different labels
                self._flush()
                self._truth = self._decoder.truth
            if not self.settings.window and not any(isinstance(self._resolve(key), str) for key in batch.counts.keys() - self._known):
                self._known.update(batch.counts)
                self._uncounted.update(batch.counts)
                return
            batch = self._decoder.batch(data, line, itemise=True)
        self._flush()
        self._take_rows(batch, data, line)

    def _flush(self) -> None:
        """Count what was gathered from chunks that were decoded as a whole."""
        for key, n in self._uncounted.items():
            what = self._resolve(key)
            if not isinstance(what, str):
                self._count(*what, n)
        self._uncounted.clear()
        self._known.clear()

    def _take_header(self, data: bytes, line: int) -> tuple[bytes, int]:
        if line == 1:
            cut = data.find(b"\n") + 1
            self._header_line, data, line = data[:cut].rstrip(b"\r\n"), data[cut:], 2
        else:
            self._header_line = self.state.place().header.encode("utf-8", "surrogateescape")
        self._decoder = decoder(self.settings, self._header_line)
        return data, line

    def _take_rows(self, batch: Batch, data: bytes, line: int) -> None:
        bad = [(number, UNREADABLE, reason) for number, reason in batch.bad]
        if self.settings.event_id or self.settings.unit:
            self.state.begin()
        for row in batch.rows or ():
            reason = self._take_row(row)
            if reason:
                bad.append((row.line, MISSING if reason.startswith(NO_VALUE) else UNUSABLE, reason))
        if bad:
            lines = data.split(b"\n")
            for number, kind, reason in sorted(bad):
                self._dead(number, kind, reason, lines[number - line])

    def _take_row(self, row: Row) -> str:
        """Count one decision; say why if it cannot be."""
        settings, extra = self.settings, list(row.extra)
        what = self._resolve(row.key)
        if isinstance(what, str):
            return what
        identity = extra.pop(0) if settings.event_id else None
        if settings.event_id and (identity is None or identity == ""):
            return f"no event id in column {shown(settings.event_id)}"
        if settings.time:
            try:
                when = moment(extra.pop(0))
            except InputError as error:
                return str(error)
            if when > time.time() + FUTURE:
                return "the time lies more than a day in the future"
            if settings.since is not None and when < moment(settings.since):
                self.tally["early"] += 1
                return ""
            self._tick(when)
        if settings.event_id and not self.state.first_seen([f"event {identity!r}"])[0]:
            self.tally["repeats"] += 1
            return ""
        if settings.unit:
            if any(part is None or part == "" for part in extra):
                return f"no unit in column {shown(settings.unit[[p is None or p == '' for p in extra].index(True)])}"
            if not self.state.first_seen([json.dumps(["unit", *map(str, extra), *what[0]])])[0]:
                self.tally["repeats"] += 1
                return ""
        self._count(*what, 1)
        return ""

    def _tick(self, when: float) -> None:
        """Advance the clock, which never goes back: a decision with an earlier time counts where the clock stands."""
        clock = self.tally["clock"]
        if clock is not None and when < clock:
            self.tally["back"] += 1
        self.tally["clock"] = when if clock is None else max(clock, when)

    def _count(self, cell: tuple[Label, Label], number: int, n: int) -> None:
        if self.settings.window:
            self._roll()
        for window, counts in ((0, self.total), (self.tally["window"], self.window)):
            if window or counts is self.total:
                counts.add(cell, number, n)
                pending = self._pending.setdefault(window, Counts())
                at = counts.order[cell], number
                pending.n[at] = pending.n.get(at, 0) + n
        self.events += n
        self._window_events += n

    def _roll(self) -> None:
        """Open the next window if the time or the number of decisions says so."""
        length = self.settings.window or ""
        index = int(self.tally["clock"] // float(length[:-1])) if length.endswith("s") else self.events // int(length)
        if index == self.tally["index"]:
            return
        if self.tally["window"]:
            self._close()
        self.tally["window"] += 1
        self.tally["index"] = index
        self.window, self._window_events = Counts(), 0

    def _close(self) -> None:
        number = self.tally["window"]
        pending = self._pending.get(number)
        if pending is not None:
            pending.order = dict(self.window.order)
        self._compare_window()
        found = self._look_at_window()
        for name, judged in found.verdicts.items():
            if judged == "exceeds" and name not in self._exceeded and LIMITS[name][0] in self.withdrawn:
                part = subject(self.settings, self.window, self.decisions)
                interval = interval_of(self.settings, part, LIMITS[name][0], window_share(number))
                if interval is not None:
                    self._alarm(name, interval, window=number)
        self.closed.append(self._entry(found))

    def window_entry(self) -> dict[str, Any]:
        """What the current window shows, by its own budget."""
        return self._entry(self._look_at_window())

    def _look_at_window(self) -> Look:
        found = subject(self.settings, self.window, self.decisions)
        return look(self.settings, found, self._window_events, window_share(self.tally["window"]))

    def _entry(self, found: Look) -> dict[str, Any]:
        return {
            "window": self.tally["window"],
            "index": self.tally["index"],
            "events": found.events,
            "intervals": found.intervals,
            "verdict": found.verdict,
        }

    def _resolve(self, key: tuple[Any, ...]) -> tuple[tuple[Label, Label], int] | str:
        """The cell and the decision that labels stand for, or why they stand for none."""
        kinds = (key, *map(type, key))
        try:
            found = self._resolved.get(kinds)
        except TypeError:  # a list or an object instead of a label
            return self._resolve_anew(key)
        if found is None:
            if len(self._resolved) >= CACHED:
                self._resolved.clear()
            found = self._resolved[kinds] = self._resolve_anew(key)
        if not isinstance(found, str) and found[0] not in self.total.order and len(self.total.order) >= MAX_CELLS:
            return f"more than {MAX_CELLS} combinations of context and group"
        return found

    def _resolve_anew(self, key: tuple[Any, ...]) -> tuple[tuple[Label, Label], int] | str:
        names = (*self.settings.context, *self.settings.group, self.settings.decision)
        labels = []
        for name, value in zip(names, key, strict=True):
            if isinstance(value, (list, dict)):
                return f"column {shown(name)} holds no label"
            try:
                text = label_text(json_number(str(value)) if isinstance(value, Decimal) else value)
            except InputError as error:
                return f"column {shown(name)}: {error}"
            if text is None:
                return f"{NO_VALUE}{shown(name)}"
            labels.append(text)
        contexts = len(self.settings.context)
        cell = tuple(labels[:contexts]), tuple(labels[contexts:-1])
        if self.settings.utility is not None:
            return cell, self._numbers.get(labels[-1], self._numbers[OTHER])
        try:
            return cell, self._value(key[-1], labels[-1])
        except InputError as error:
            return f"column {shown(names[-1])}: {error}"

    def _value(self, value: Any, text: str) -> int:
        """Number of the decision that a utility stands for."""
        exact = Fraction(*rational(text if isinstance(value, (str, float)) else value))
        if self.settings.step is not None:
            step = Fraction(self.settings.step)
            exact = round(exact / step) * step
        low, high = self.settings.limits
        if not low <= exact <= high:
            raise InputError(f"a utility of {shown(text)} is outside the range from {low} to {high}")
        label = rational_text((exact.numerator, exact.denominator))
        if label not in self._numbers:
            if len(self._numbers) >= MAX_VALUES:
                raise InputError(f"more than {MAX_VALUES} different utilities; round them (--utility-step)")
            self._numbers[label] = len(self._numbers)
            self.decisions.append((label, label))
            self._new_decisions.append((self._numbers[label], label, label))
        return self._numbers[label]

    # Dead letters

    def _open_letters(self, path: str | None, length: int) -> Any:
        """Open the file of dead letters, without what was written after the last commit."""
        if path is None:
            return None
        try:
            file = Path(path).open("ab")  # noqa: SIM115
            earlier = self.state.get("tally", {}).get("letters")
            if earlier == os.path.realpath(path) and file.tell() > length:
                file.truncate(length)
                file.seek(0, os.SEEK_END)
        except OSError as error:
            self.log.file.close()
            raise InputError(f"{path} cannot be written: {error.strerror or error}") from None
        return file

    def _dead(self, line: int, kind: str, reason: str, text: bytes) -> None:
        self.tally["dead"] += 1
        self.tally["reasons"][kind] = self.tally["reasons"].get(kind, 0) + 1
        if self._letters is not None:
            entry = {"line": line, "reason": reason, "text": text[:SHOWN].decode("utf-8", "backslashreplace")}
            self._letters.write(json.dumps(entry).encode("ascii") + b"\n")

    def close(self) -> None:
        """Close the files."""
        with contextlib.suppress(OSError):
            self.log.file.close()
        if self._letters is not None:
            self._letters.close()
        self.state.close()
