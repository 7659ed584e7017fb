"""A monitor: reads decisions, keeps the counts, and says at any moment what they show."""

from __future__ import annotations

import contextlib
import json
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, replace
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.extended import extended_text
from fairaudit.inference.changes import Change, withdrawn_by
from fairaudit.inference.detectors import Detection
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import window_share
from fairaudit.inference.time_pairs import TimePairs
from fairaudit.inference.verdicts import Verdict, foremost_verdict
from fairaudit.measures.limits import LIMITS, Quantity
from fairaudit.streams.detection import Detectors
from fairaudit.streams.labels import NO_VALUE, LabelResolver
from fairaudit.streams.left_out import LeftOut, Why
from fairaudit.streams.letters import MISSING, UNREADABLE, UNUSABLE, DeadLetters
from fairaudit.streams.looks import (
    QUANTITIES,
    ByTime,
    Look,
    asked_targets,
    contradiction,
    interval_of,
    look,
    pair_labels,
    target_verdict,
    withdrawn,
)
from fairaudit.streams.readers import Batch, Decoder, Key, Row, decoder, moment, refuse_samples
from fairaudit.streams.seasons import by_time, compared, judged_by_time
from fairaudit.streams.state import Counts, State
from fairaudit.streams.subjects import Subject, subject
from fairaudit.streams.tail import Log
from fairaudit.tables.sources import SameContent
from fairaudit.tables.values import Label

COMMIT_SECONDS = 0.1  # what a crash may cost: the lines of this time are read again

FIRST_LOOKS = 1_000  # an interval hardly moves in fewer decisions

LOOKS = 1.02  # nor in 2 % more: an eager monitor of n decisions looks about 50·log(n) times

PATIENCE = 40  # looking for alarms takes one fortieth of the time

FIRST_CHECK, CHECKS = 1_000, 1.25  # after how many decisions the whole stream is asked whether it is under a detector's limit, and again

FUTURE = 86_400.0  # a day: wrong time zones pass, wrong years do not


class Monitor:
    r"""Reads a log into a state, and looks at it.

    Parameters
    ----------
    state : State
        Where counts are kept.
    path : str
        The log, or ``-``.
    letters : str or None
        File for lines that cannot be counted.
    same_content : {"refuse", "accept"}
        What becomes of another log that holds, or begins with, what was read before; the same file is always refused.

    Raises
    ------
    InputError
        If the log or that file cannot be used.

    Examples
    --------
    >>> import fairaudit as fa
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with open(folder + "/log.csv", "w") as log:
    ...         _ = log.write("hired,sex\n" + "yes,f\nyes,m\nno,m\n" * 200)
    ...     with fa.monitor(folder + "/log.csv", decision="hired", group="sex", utility="yes") as watch:
    ...         watch.catch_up().events, watch.events, watch.alarms
    (600, 600, [])
    """

    def __init__(self, state: State, path: str, letters: str | None = None, same_content: SameContent = "refuse") -> None:
        self.state, self.settings = state, state.settings
        place = state.place()
        self.log = Log(path, place, same_content)
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
            "parts": 0,
            "under": {},
            "check": FIRST_CHECK,
        } | state.get("tally", {})
        self.left_out = LeftOut(state.get("left_out"), self.tally)
        self._letters = self._open_letters(letters, place.letters)
        self.total, self.window = state.counts(), Counts()
        self._labels = LabelResolver(self.settings, state.decisions(), self.total.order)
        if self._letters is not None and self.tally["letters"] != self._letters.path:
            # Known before the first line is written, so that a kill before the first commit leaves nothing behind.
            opened = asdict(replace(place, letters=self._letters.length))
            state.commit({}, [], [], {"tally": self.tally | {"letters": self._letters.path}, "place": opened})
        self.tally["letters"] = None if self._letters is None else self._letters.path
        if self.tally["window"]:
            self.window = state.counts(self.tally["window"])
        self.alarms = state.alarms()
        self.part = state.counts(-self.tally["parts"]) if self.tally["parts"] else Counts()
        stopped = self.withdrawn | {alarm["detected"] for alarm in self.alarms if "detected" in alarm}
        self._detectors = Detectors(self.settings, self.total.order, state.get("detectors", {}), stopped)
        self._time_pairs = TimePairs(state.get("time_pairs")) if self.settings.pair_by_time else None
        if self._time_pairs is not None:
            for (context, _), rank in self.total.order.items():
                self._time_pairs.join(context, rank)
        self._values = [Fraction(utility) for _, utility in self._labels.decisions]
        self._line: int | None = place.line - 1 if place.offset else None
        self.closed: list[dict[str, Any]] = []
        self.notes: list[str] = []
        self._decoder: Decoder | None = None
        self._pending: dict[int, Counts] = {}
        self._uncounted: Counter[Any] = Counter()
        self._known: set[Any] = set()
        self._new_cells: set[tuple[Label, Label]] = set()
        self._truth: tuple[bool, ...] = ()
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
                self._place, self._line = place, place.line - 1
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

    def catch_up(self, *, eager: bool = False) -> Look:
        """Read all that there is, and say what it shows.

        Parameters
        ----------
        eager : bool
            As for `read`.
        """
        for _ in self.read(eager=eager):
            pass
        return self.look()

    def __enter__(self) -> Monitor:
        """Keep the log and the state open for a block."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close both."""
        self.close()

    def commit(self) -> None:
        """Store everything that was read."""
        place = getattr(self, "_place", None)
        if place is None and not (self._new_alarms or self._pending):
            return
        entries: dict[str, Any] = {"tally": self.tally, "left_out": self.left_out.kept()}
        if self.settings.run_length:
            entries["detectors"] = self._detectors.kept()
        if self._time_pairs is not None:
            entries["time_pairs"] = self._time_pairs.kept()
        if place is not None:
            if self._letters is not None:
                place = replace(place, letters=self._letters.flush())
            entries["place"] = asdict(replace(place, header=self._header))
        orders = {-self.tally["parts"]: self.part.order, self.tally["window"]: self.window.order, 0: self.total.order}
        added = {window: Counts(orders.get(window, counts.order), counts.n) for window, counts in self._pending.items()}
        self.state.commit(added, self._labels.take_new(), self._new_alarms, entries)
        self._pending, self._new_alarms = {}, []

    def look(self) -> Look:
        """What the whole stream shows now, as far as no window contradicts it."""
        self._compare_window()
        if self._new_alarms:
            self.commit()
        found = self._look()
        if self._time_pairs is None:
            return found
        return judged_by_time(self.settings, found, self._by_time(self._time_pairs))

    def _by_time(self, tallies: TimePairs) -> ByTime:
        whole = None if "local" in self.withdrawn else self.subject()
        return by_time(self.settings, self.total.order, tallies, whole)

    def _look(self) -> Look:
        found, gone = look(self.settings, self.subject(), self.events), self.withdrawn
        detected = {alarm["detected"] for alarm in self.alarms if "detected" in alarm}
        if not gone and not detected:
            return found
        parts = [self._look_at_window()] if self.tally["window"] and gone else []
        parts += [self.look_since()] if detected else []
        above = {name: part for part in reversed(parts) for name, judged in part.verdicts.items() if judged == "exceeds"}
        verdicts = dict(found.verdicts)
        for name, judged in found.verdicts.items():
            if LIMITS[name][0] in gone:
                verdicts[name] = "exceeds" if name in self._exceeded or name in above else "changed"
            elif LIMITS[name][0] in detected and judged == "inconclusive" and name in above:
                verdicts[name] = "exceeds"
        asked = {LIMITS[name][0] for name in verdicts} or gone
        overall: Verdict = "changed" if gone & asked else foremost_verdict(verdicts.values())
        pairs = {name: pair for name, pair in found.pairs.items() if verdicts[name] == found.verdicts[name] and LIMITS[name][0] not in gone}
        pairs |= {name: part.pairs[name] for name, part in above.items() if name not in pairs and name in part.pairs}
        return Look(found.events, {q: ends for q, ends in found.intervals.items() if q not in gone}, verdicts, overall, pairs)

    @property
    def decisions(self) -> list[tuple[str, str]]:
        """Labels and utilities of the decisions, by number."""
        return self._labels.decisions

    @property
    def withdrawn(self) -> frozenset[Quantity]:
        """The quantities whose interval a window or a detector contradicts."""
        return withdrawn(self.settings, self.alarms)

    @property
    def _contradicted(self) -> frozenset[Quantity]:
        """Those of them that a window contradicts, as the certificate proves."""
        return withdrawn(self.settings, [alarm for alarm in self.alarms if "window" in alarm])

    def look_since(self) -> Look:
        """What the decisions since the last alarm of a detector show, by a budget of their own."""
        found = subject(self.settings, self.part, self.decisions)
        return look(self.settings, found, self.part.events, window_share(self.tally["parts"]))

    @property
    def _exceeded(self) -> set[str]:
        """Targets that were exceeded at some moment, or in some window."""
        return {name for alarm in self.alarms for name in ([alarm["target"]] if "target" in alarm else alarm["exceeds"])}

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
            asked = {name: limit for name, limit in asked_targets(self.settings, quantity).items() if name in waiting}
            interval = interval_of(self.settings, found, quantity, exact=False) if asked else None
            if interval and any(target_verdict(interval, name, limit) == "exceeds" for name, limit in asked.items()):
                if self._time_pairs is not None and quantity in compared(self.settings) and self._by_time(self._time_pairs).confounds:
                    continue
                interval = interval_of(self.settings, found, quantity) or interval
                for name, limit in asked.items():
                    if target_verdict(interval, name, limit) == "exceeds":
                        self._alarm(name, interval)
        self._watch_since()
        if self._new_alarms:
            self.commit()

    def _watch_since(self) -> None:
        """Raise an alarm for each target of a detector's ratio that the decisions since its alarm exceed."""
        detected = {alarm["detected"] for alarm in self.alarms if "detected" in alarm}
        waiting = {name for name in self.settings.targets or {} if LIMITS[name][0] in detected and name not in self._exceeded}
        if not waiting or waiting.isdisjoint(name for name, judged in self.look_since().verdicts.items() if judged == "exceeds"):
            return
        found, share = subject(self.settings, self.part, self.decisions), window_share(self.tally["parts"])
        for name in sorted(waiting):
            quantity = LIMITS[name][0]
            interval = interval_of(self.settings, found, quantity, share)
            if interval and target_verdict(interval, name, asked_targets(self.settings, quantity)[name]) == "exceeds":
                self._alarm(name, interval, part=self.tally["parts"])

    def _alarm(self, name: str, interval: Interval, **where: int) -> None:
        limit, lower = (self.settings.targets or {})[name], extended_text(interval.lower)
        self._raise({"target": name, "limit": limit, "lower": lower, "pair": pair_labels(interval.pairs[0]), **where})

    def _compare_window(self) -> None:
        """Raise an alarm for each quantity for which the current window contradicts the whole stream for the first time."""
        if not self.tally["window"] or len(self._contradicted) == len(QUANTITIES):
            return
        whole, part = self.subject(), subject(self.settings, self.window, self.decisions)
        for quantity in QUANTITIES:
            found = None if quantity in self._contradicted else contradiction(self.settings, whole, part, self.tally["window"], quantity)
            if found is not None:
                self._changed(found)

    def _changed(self, found: Change) -> None:
        asked = asked_targets(self.settings, found.quantity)
        self._raise(
            {
                "changed": found.quantity,
                "window": found.window.number,
                "window_events": self._window_events,
                "stream": [extended_text(found.stream.lower), extended_text(found.stream.upper)],
                "ratio": [extended_text(found.part.lower), extended_text(found.part.upper)],
                "error": str(1 - found.confidence),
                "exceeds": [name for name, limit in asked.items() if target_verdict(found.part, name, limit) == "exceeds"],
                "window_order": [[list(x), list(a)] for x, a in self.window.order],
                "window_counts": [[rank, number, n] for (rank, number), n in self.window.n.items()],
            }
        )

    def _detect(self, cell: tuple[Label, Label], number: int) -> None:
        """Show a decision to the detectors; what they find may withdraw what was said about the whole stream."""
        if self.events >= self.tally["check"]:
            self.tally["check"] = int(self.events * CHECKS)
            for quantity in self._detectors.running:
                self._note_under(quantity)
        for quantity, found in self._detectors.take(cell, self._value(number), (self.events, self.tally["clock"])):
            self._detected(quantity, found)

    def _value(self, number: int) -> Fraction:
        """The utility of a decision."""
        for extra in self.decisions[len(self._values) :]:
            self._values.append(Fraction(extra[1]))
        return self._values[number]

    def _note_under(self, quantity: Quantity) -> None:
        """Remember when the interval of the whole stream first was under the limit of the detector."""
        if quantity in self.tally["under"]:
            return
        limit, whole = self._detectors.running[quantity].limit, self.subject()
        for exact in (False, True):
            interval = interval_of(self.settings, whole, quantity, exact=exact)
            if interval is None or interval.upper > limit:
                return
        self.tally["under"][quantity] = self.events

    def _detected(self, quantity: Quantity, found: Detection) -> None:
        """Raise the alarm of a detector, and begin to count anew."""
        if quantity not in self._detectors.running:  # another alarm of this decision withdrew it
            return
        self._note_under(quantity)
        entry = self._detectors.entry(quantity, found)
        if quantity in self.tally["under"]:
            entry |= {"changed": quantity, "under": self.tally["under"][quantity]}
        self._raise(entry)
        stopped = withdrawn_by(quantity, contexts=bool(self.settings.context)) if "changed" in entry else frozenset({quantity})
        self._detectors.stop(stopped)
        if -self.tally["parts"] in self._pending and self.tally["parts"]:
            self._pending[-self.tally["parts"]].order = dict(self.part.order)
        self.tally["parts"] += 1
        self.part = Counts()

    def _raise(self, entry: dict[str, Any]) -> None:
        """Keep an alarm with the counts of the moment; it is stored with the next commit."""
        alarm = entry | {
            "events": self.events,
            "line": self._line,
            "clock": self.tally["clock"],
            "order": [[list(x), list(a)] for x, a in self.total.order],
            "counts": [[rank, number, n] for (rank, number), n in self.total.n.items()],
            "dead": self.tally["dead"],
            "reasons": dict(self.tally["reasons"]),
            "left_out": self.left_out.kept(),
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
        elif line == 1:
            refuse_samples(data, self.log.path)
        if self._decoder is None:
            self._decoder = decoder(self.settings)
        in_order = bool(self.settings.window or self._detectors.running or self.settings.pair_by_time)
        batch = self._decoder.batch(data, line, itemise=in_order)
        if batch.rows is None:
            if self._decoder.truth != self._truth:  # 1 and true are equal keys, and different labels
                self._flush()
                self._truth = self._decoder.truth
            if self._countable(batch.counts):
                self._known.update(batch.counts)
                self._uncounted.update(batch.counts)
                return
            batch = self._decoder.batch(data, line, itemise=True)
        self._flush()
        self._take_rows(batch, data, line)

    def _countable(self, keys: Iterable[Key]) -> bool:
        """Whether every line of a chunk can be counted, besides those that were gathered before."""
        new = set(self._new_cells)
        for key in keys:  # in order of appearance
            if key not in self._known:
                what = self._labels.resolve(key)
                if isinstance(what, str):
                    return False
                if what[0] not in self.total.order:
                    new.add(what[0])
        if not self._labels.room_for(new):
            return False
        self._new_cells = new
        return True

    def _flush(self) -> None:
        """Count what was gathered from chunks that were decoded as a whole."""
        for key, n in self._uncounted.items():
            what = self._labels.resolve(key)
            if not isinstance(what, str):
                self._count(*what, n)
        self._uncounted.clear()
        self._known.clear()
        self._new_cells.clear()

    def _take_header(self, data: bytes, line: int) -> tuple[bytes, int]:
        if line == 1:
            cut = data.find(b"\n") + 1
            self._header_line, data, line = data[:cut].rstrip(b"\r\n"), data[cut:], 2
        else:
            self._header_line = self.state.place().header.encode("utf-8", "surrogateescape")
        self._decoder = decoder(self.settings, self._header_line)
        return data, line

    def _take_rows(self, batch: Batch, data: bytes, line: int) -> None:
        bad, lines = batch.bad[::-1], list[bytes]()
        if self.settings.event_id or self.settings.unit:
            self.state.begin()

        def refuse(number: int, kind: str, reason: str, key: Key) -> None:
            if not lines:
                lines.extend(data.split(b"\n"))
            self._dead(number, kind, reason, lines[number - line], self._labels.group(key))

        for row in batch.rows or ():
            while bad and bad[-1][0] < row.line:
                number, reason, key = bad.pop()
                refuse(number, UNREADABLE, reason, key)
            reason = self._take_row(row)
            if reason:
                refuse(row.line, MISSING if reason.startswith(NO_VALUE) else UNUSABLE, reason, row.key)
        for number, reason, key in reversed(bad):
            refuse(number, UNREADABLE, reason, key)

    def _take_row(self, row: Row) -> str:
        """Count one decision; say why if it cannot be."""
        settings, extra = self.settings, list(row.extra)
        what = self._labels.resolve(row.key)
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
                return self._left_out("early", what[0])
            self._tick(when)
        if settings.event_id and not self.state.first_seen([f"event {identity!r}"])[0]:
            return self._left_out("repeats", what[0])
        if settings.unit:
            if any(part is None or part == "" for part in extra):
                return f"no unit in column {shown(settings.unit[[p is None or p == '' for p in extra].index(True)])}"
            if not self.state.first_seen([json.dumps(["unit", *map(str, extra), *what[0]])])[0]:
                return self._left_out("repeats", what[0])
        self._line = row.line
        self._count(*what, 1)
        if self._time_pairs is not None:
            cell, decided = what
            self._time_pairs.take(cell[0], self.total.order[cell], self._value(decided))
        if self._detectors.running:
            self._detect(*what)
        return ""

    def _left_out(self, why: Why, cell: tuple[Label, Label]) -> str:
        self.tally[why] += 1
        self.left_out.add(why, cell[1])
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
        for window, counts in ((0, self.total), (self.tally["window"], self.window), (-self.tally["parts"], self.part)):
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
        """Judge the window that ends here for the last time, and keep what it showed."""
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

    # Dead letters

    def _open_letters(self, path: str | None, length: int) -> DeadLetters | None:
        try:
            return None if path is None else DeadLetters(path, length, self.tally["letters"])
        except InputError:
            self.log.file.close()
            raise

    def _dead(self, line: int, kind: str, reason: str, text: bytes, group: Label | None = None) -> None:
        self.tally["dead"] += 1
        self.left_out.add("dead", group)
        self.tally["reasons"][kind] = self.tally["reasons"].get(kind, 0) + 1
        if self._letters is not None:
            self._letters.write(line, reason, text)

    def close(self) -> None:
        """Close the files."""
        with contextlib.suppress(OSError):
            self.log.file.close()
        if self._letters is not None:
            self._letters.close()
        self.state.close()
