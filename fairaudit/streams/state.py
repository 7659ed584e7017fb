"""The state of a monitor in SQLite: counts and the place in the log, committed together, so that nothing is lost or counted twice."""

from __future__ import annotations

import hashlib
import json
import re
import sqlite3
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TextIO

from fairaudit.errors import InputError, shown
from fairaudit.streams.settings import EARLIER, RUN_LENGTH, Settings
from fairaudit.tables.values import Label

__all__ = ["Counts", "Place", "State"]


FORMAT = "fairaudit-monitor/1"  # of the state; another one is refused

SPELLING = 2  # of labels: 1 wrote true, 1.0 and 1e3 as Python does

OLD_SPELLING = re.compile(r"True|False|-?\d+\.0|-?\d+(\.\d+)?e[+-]\d+", re.ASCII)

SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE cells (window INTEGER, rank INTEGER, context TEXT NOT NULL, label TEXT NOT NULL, PRIMARY KEY (window, rank)) WITHOUT ROWID;
CREATE TABLE decisions (number INTEGER PRIMARY KEY, label TEXT NOT NULL UNIQUE, utility TEXT NOT NULL);
CREATE TABLE counts (window INTEGER, rank INTEGER, decision INTEGER, n INTEGER NOT NULL, PRIMARY KEY (window, rank, decision))
  WITHOUT ROWID;
CREATE TABLE seen (digest BLOB PRIMARY KEY) WITHOUT ROWID;
CREATE TABLE alarms (number INTEGER PRIMARY KEY, entry TEXT NOT NULL);
"""


@dataclass(frozen=True)
class Place:
    """Where in a log the next line begins, with what tells whether it is still the same log.

    Attributes
    ----------
    path : str
        The file; ``-`` for standard input.
    inode, device : int
        Its identity.
    offset : int
        Bytes that were read.
    line : int
        Number of the next line.
    head, tail : str
        Digests of the first and last bytes that were read.
    open_line : bool
        Whether the last line had no end.
    header : str
        The first line of CSV.
    letters : int
        Length of the file of dead letters.
    earlier : list
        Other logs that were read before: of each the path, inode, device, offset, head and tail.
    """

    path: str = ""
    inode: int = 0
    device: int = 0
    offset: int = 0
    line: int = 1
    head: str = ""
    tail: str = ""
    open_line: bool = False
    header: str = ""
    letters: int = 0
    earlier: list[list[Any]] = field(default_factory=list)


@dataclass
class Counts:
    """What was counted in the whole stream, or in a window: cells in order of first appearance, and how often each decision fell there."""

    order: dict[tuple[Label, Label], int] = field(default_factory=dict)
    n: dict[tuple[int, int], int] = field(default_factory=dict)

    def add(self, cell: tuple[Label, Label], decision: int, n: int) -> None:
        """Count a decision n times."""
        rank = self.order.setdefault(cell, len(self.order) + 1)
        self.n[rank, decision] = self.n.get((rank, decision), 0) + n

    @property
    def events(self) -> int:
        """Number of decisions."""
        return sum(self.n.values())

    def by_group(self) -> Counter[Label]:
        """Number of decisions of each group."""
        groups, found = {rank: group for (_, group), rank in self.order.items()}, Counter[Label]()
        for (rank, _), n in self.n.items():
            found[groups[rank]] += n
        return found


class State:
    """The state on disk, or in memory if no path is given.

    Raises
    ------
    InputError
        If the file is no state, or that of another audit.
    """

    def __init__(self, path: str | None, settings: Settings | None = None, *, read_only: bool = False) -> None:
        self.path = path
        self._lock: TextIO | None = None
        existing = path is not None and Path(path).exists() and Path(path).stat().st_size > 0
        if read_only and not existing:
            raise InputError(f"there is no state {path}")
        try:
            self.db = sqlite3.connect(path or ":memory:", isolation_level=None, timeout=2)
        except sqlite3.Error as error:
            raise InputError(f"{path} cannot be used as the state of a monitor: {error}") from None
        try:
            self.settings = self._begin(settings, existing=existing, read_only=read_only)
        except sqlite3.Error as error:
            self.close()
            raise InputError(f"{path} cannot be used as the state of a monitor: {error}") from None
        except InputError:
            self.close()
            raise

    def _begin(self, settings: Settings | None, *, existing: bool, read_only: bool) -> Settings:
        stored = self._stored() if existing else None
        if stored is None:
            if settings is None:
                missing = "no state was named" if self.path is None else f"there is no state {self.path}"
                raise InputError(f"{missing}, and no audit was described; name the columns and the utility")
            self._create(settings)
            return settings
        if settings is not None and settings.run_length == RUN_LENGTH and not stored.run_length:
            settings = replace(settings, run_length=0)  # it began without a detector, and goes on so unless another run length is named
        if settings is not None and settings.digest != stored.digest:
            raise InputError(f"{self.path} is the state of another audit: {'; '.join(settings.differences(stored))}; name another state")
        if not read_only:
            self._claim()
            self._refuse_old_spellings(stored)
        return stored

    def _refuse_old_spellings(self, settings: Settings) -> None:
        """Refuse to count on where truth values and numbers of JSON had other texts than now."""
        if settings.layout != "jsonl" or self.get("spelling") == SPELLING:
            return
        labels = {label for label, _ in settings.decisions}
        for parts in self.db.execute("SELECT context, label FROM cells"):
            labels.update(label for part in parts for label in json.loads(part))
        for label in sorted(labels):
            if OLD_SPELLING.fullmatch(label):
                raise InputError(
                    f"{self.path} holds the label {shown(label)}, which earlier versions wrote for truth values and numbers of JSON; "
                    "they are now true, false, and digits such as 1 and 0.5: start a new state"
                )
        self.db.execute("INSERT OR REPLACE INTO meta VALUES ('spelling', ?)", (str(SPELLING),))

    def _stored(self) -> Settings | None:
        row = self.db.execute("SELECT count(*) FROM sqlite_master WHERE name = 'meta'").fetchone()
        if not row[0]:
            raise InputError(f"{self.path} is not the state of a monitor; name another file")
        meta = dict(self.db.execute("SELECT key, value FROM meta WHERE key IN ('format', 'audit', 'digest')"))
        if meta.get("format") != FORMAT:
            raise InputError(f"{self.path} is not the state of a monitor of this version; name another file")
        if hashlib.sha256(meta["audit"].encode()).hexdigest() != meta["digest"]:
            raise InputError(f"{self.path} was altered: its audit does not have its digest")
        return Settings.from_text(meta["audit"])

    def _create(self, settings: Settings) -> None:
        self._claim()
        self.db.execute("BEGIN IMMEDIATE")
        for statement in SCHEMA.split(";\n"):
            self.db.execute(statement)
        for key, value in (("format", FORMAT), ("spelling", str(SPELLING)), ("audit", settings.text), ("digest", settings.digest)):
            self.db.execute("INSERT INTO meta VALUES (?, ?)", (key, value))
        self.db.executemany(
            "INSERT INTO decisions VALUES (?, ?, ?)", [(k, label, str(g)) for k, (label, g) in enumerate(settings.decisions)]
        )
        self.db.execute("COMMIT")

    def _claim(self) -> None:
        """Keep a second writer away for as long as this one lives; readers are welcome."""
        self.db.execute("PRAGMA journal_mode = WAL")
        self.db.execute("PRAGMA synchronous = NORMAL")
        if self.path is None:
            return
        try:
            import fcntl
        except ImportError:  # not a POSIX system: transactions still keep the counts whole
            return
        try:
            self._lock = Path(f"{self.path}.lock").open("w")  # noqa: SIM115
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if isinstance(error, BlockingIOError):
                raise InputError(f"{self.path} is in use by another monitor; wait until it ends, or name another state") from None
            raise InputError(f"{self.path}.lock cannot be written: {error.strerror or error}") from None

    def close(self) -> None:
        """Close the file."""
        self.db.close()
        if self._lock is not None:
            self._lock.close()

    def get(self, key: str, default: Any = None) -> Any:
        """Read an entry that was stored with `commit`."""
        row = self.db.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
        return default if row is None else json.loads(row[0])

    def place(self) -> Place:
        """Where to read on."""
        return Place(**self.get("place", {}))

    def decisions(self) -> list[tuple[str, str]]:
        """Labels and utilities of the decisions, by number."""
        return list(self.db.execute("SELECT label, utility FROM decisions ORDER BY number"))

    def counts(self, window: int = 0) -> Counts:
        """What was counted in a window; 0 is the whole stream."""
        found = Counts()
        for rank, context, group in self.db.execute("SELECT rank, context, label FROM cells WHERE window = ? ORDER BY rank", (window,)):
            found.order[tuple(json.loads(context)), tuple(json.loads(group))] = rank
        rows = self.db.execute("SELECT rank, decision, n FROM counts WHERE window = ? ORDER BY rank, decision", (window,))
        found.n = {(rank, decision): n for rank, decision, n in rows}
        return found

    def alarms(self) -> list[dict[str, Any]]:
        """The alarms that were raised, in order."""
        stored = [json.loads(entry) for (entry,) in self.db.execute("SELECT entry FROM alarms ORDER BY number")]
        return [{**alarm, "target": EARLIER.get(alarm["target"], alarm["target"])} if "target" in alarm else alarm for alarm in stored]

    def first_seen(self, keys: Iterable[str]) -> list[bool]:
        """Whether each key is seen for the first time, and remember it; within the transaction that `begin` opened."""
        found = []
        for key in keys:
            digest = hashlib.blake2b(key.encode("utf-8", "surrogatepass"), digest_size=16).digest()
            found.append(self.db.execute("INSERT OR IGNORE INTO seen VALUES (?)", (digest,)).rowcount == 1)
        return found

    def begin(self) -> None:
        """Open a transaction."""
        if not self.db.in_transaction:
            self.db.execute("BEGIN IMMEDIATE")

    def roll_back(self) -> None:
        """Forget what was not committed."""
        if self.db.in_transaction:
            self.db.execute("ROLLBACK")

    def commit(
        self,
        added: Mapping[int, Counts],
        decisions: Iterable[tuple[int, str, str]],
        alarms: Iterable[Mapping[str, Any]],
        entries: Mapping[str, Any],
    ) -> None:
        """Store what was counted since the last time, by window, and everything that belongs to it, at once.

        Parameters
        ----------
        added : mapping of int to Counts
            For each window, all its cells in order, and what is to be added to the counts.
        decisions : iterable of (number, label, utility)
            Decisions that are new.
        alarms : iterable of mapping
            Alarms that are new.
        entries : mapping
            Other things to remember, such as the place in the log.
        """
        self.begin()
        for window, counts in added.items():
            known = self.db.execute("SELECT count(*) FROM cells WHERE window = ?", (window,)).fetchone()[0]
            new = [(window, rank, json.dumps(x), json.dumps(a)) for (x, a), rank in counts.order.items() if rank > known]
            self.db.executemany("INSERT INTO cells VALUES (?, ?, ?, ?)", new)
            self.db.executemany(
                "INSERT INTO counts VALUES (?, ?, ?, ?) ON CONFLICT DO UPDATE SET n = n + excluded.n",
                [(window, rank, decision, n) for (rank, decision), n in counts.n.items()],
            )
        self.db.executemany("INSERT INTO decisions VALUES (?, ?, ?)", list(decisions))
        self.db.executemany("INSERT INTO alarms (entry) VALUES (?)", [(json.dumps(alarm),) for alarm in alarms])
        self.db.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", [(key, json.dumps(value)) for key, value in entries.items()])
        self.db.execute("COMMIT")
