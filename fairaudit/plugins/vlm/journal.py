"""The journal: every draw before it is used, every request before it is sent, every answer before it is read.

An SQLite file with a write-ahead log and synchronous FULL: what was committed survives a kill and a power cut. Answers are keyed by
(request, model, trial) and never overwritten; faults of the server are kept beside them and are no answers.
"""

from __future__ import annotations

import contextlib
import json
import secrets
import sqlite3
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError
from fairaudit.words import noun

__all__ = ["Answer", "Draw", "Journal", "Work"]

VERSION = "fairaudit-journal/2"


@dataclass(frozen=True)
class Work:
    """A request to be answered: the `trial`-th time that it is put to a model."""

    request: str
    model: str
    trial: int
    context: str
    slots: tuple[tuple[str, ...], ...]

    @property
    def named(self) -> dict[str, object]:
        """What names it in the tables."""
        return {"request": self.request, "model": self.model, "trial": self.trial}


Entry = tuple[Work, int, int, str, bytes, int, int, float]
"""Work, attempt, status, content type, body, tokens in and out, cost."""


@dataclass(frozen=True)
class Draw:
    """What is shown in one trial of a cell: drawn, and written down, before anything is sent."""

    model: str
    setting: int
    context: str
    people: tuple[str, ...]
    trial: int
    shown_context: str
    shown_slots: tuple[tuple[str, ...], ...]
    request: str
    occurrence: int

    @property
    def row(self) -> dict[str, Any]:
        """As journals and logs have it: what is shown stands together."""
        rest = {name: value for name, value in vars(self).items() if not name.startswith("shown_")}
        return rest | {"shown": [self.shown_context, self.shown_slots]}


@dataclass(frozen=True)
class Answer:
    """The raw answer to a draw."""

    draw: Draw
    state: str  # ``answer``, ``fault``: the last one that came, or ``open``: nothing came yet
    status: int
    content_type: str
    body: bytes
    input_tokens: int
    output_tokens: int
    cost: float


class Journal(contextlib.ExitStack):
    """An open journal of the experiment with a digest; it is made if it does not exist and `create` is set.

    A journal of another experiment, or planned with another number of trials, answers per cell, is refused.
    """

    def __init__(self, path: Path, digest: str, trials: int, *, create: bool) -> None:
        self.path = path
        if not create and not path.is_file():
            raise InputError(f"there is no journal {path}; start the experiment with fairaudit experiment run")
        super().__init__()
        with self._said():
            self._db = self.enter_context(contextlib.closing(sqlite3.connect(path, isolation_level=None, timeout=30)))
            if create:  # one that is only read stays as it is, to the byte
                self._db.execute("PRAGMA journal_mode=WAL")
            self._db.execute("PRAGMA synchronous=FULL")
            if create and not self._db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                pairs = (("version", VERSION), ("experiment", digest), ("trials", str(trials)), ("run", secrets.token_hex(8)))
                self._script(_sql("schema"), *(("INSERT INTO meta VALUES (?, ?)", pair) for pair in pairs))
        found, wrong = {}, ""
        with contextlib.suppress(sqlite3.Error):
            found = dict(self._db.execute("SELECT key, value FROM meta"))
        if found.get("version") != VERSION:
            wrong = f"is not a journal of the version that is read ({VERSION}); name another folder"
        elif found["experiment"] != digest:
            wrong = (
                f"belongs to another experiment file or to other pictures ({found['experiment'][:12]}, not {digest[:12]}); "
                "answers to other questions are not mixed: name another folder, or undo the change"
            )
        elif found["trials"] != str(trials):
            wrong = (
                f"was planned with {found['trials']} {noun(found['trials'], 'trial')} and not {trials}: sizes are "
                f"fixed before the first answer; name another folder"
            )
        if wrong:
            self.close()
            raise InputError(f"{path} {wrong}")
        self.run = found.get("run", "")  # a part of each idempotency key, so that a server answers another journal anew
        with self._said():
            for view in _sql("views").split(";\n"):
                self._db.execute(view)

    def _script(self, statements: str, *more: tuple[str, tuple[str, ...]]) -> None:
        with self.transaction():
            for statement, given in (*((text, ()) for text in statements.split(";\n")), *more):
                self._db.execute(statement, given)

    def claim(self) -> None:
        """Be the only one who runs this journal, until it is closed, or say that another one does."""
        with self._said():
            lock = self.enter_context(contextlib.closing(sqlite3.connect(f"{self.path.resolve()}.lock", isolation_level=None, timeout=0.2)))
            try:
                lock.execute("BEGIN EXCLUSIVE")
            except sqlite3.OperationalError as error:
                if "locked" not in str(error):
                    raise
                raise InputError(f"another process is running {self.path}; wait for it, or name another folder") from None

    @contextlib.contextmanager
    def transaction(self) -> Iterator[None]:
        """Everything in it is written, or nothing."""
        with self._said():
            self._db.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                with contextlib.suppress(sqlite3.Error):
                    self._db.execute("ROLLBACK")
                raise
            self._db.execute("COMMIT")

    def _rows(self, query: str, *given: object) -> list[Any]:
        with self._said():
            return self._db.execute(query, given).fetchall()

    def _insert(self, table: str, row: Mapping[str, object]) -> int:
        """Add a row, within a transaction; returns its number."""
        query = f"INSERT INTO {table} ({', '.join(row)}) VALUES ({', '.join('?' * len(row))})"  # noqa: S608
        return self._db.execute(query, tuple(row.values())).lastrowid or 0

    def models(self) -> list[str]:
        """Models that were planned, in order."""
        return [key for (key,) in self._rows("SELECT model FROM draws GROUP BY model ORDER BY min(id)")]

    def plan(self, draws: Iterable[Draw], requests: Iterable[tuple[str, str]]) -> None:
        """Write the draws of a model and the requests that they lead to, all at once."""
        with self.transaction():
            self._db.executemany("INSERT OR IGNORE INTO requests VALUES (?, ?)", requests)
            for draw in draws:
                self._insert("draws", {name: _list(v) if name in ("people", "shown") else v for name, v in draw.row.items()})

    def open_work(self, model: str, *, ask_again: bool = False) -> list[Work]:
        """What has no answer yet, first trials first; what met with a fault of the server only if it is to be asked again."""
        query = "SELECT request, occurrence, shown FROM unanswered WHERE model = ? AND (? OR NOT faulty) ORDER BY occurrence, first"
        rows = self._rows(query, model, ask_again)
        return [Work(request, model, trial, *_shown(text)) for request, trial, text in rows]

    def size(self, model: str) -> tuple[int, int]:
        """Different requests and trials of a model, and how many of them have an answer."""
        ((total,),) = self._rows("SELECT count(*) FROM (SELECT DISTINCT request, occurrence FROM draws WHERE model = ?)", model)
        ((done,),) = self._rows("SELECT count(*) FROM answers WHERE model = ?", model)
        return total, done

    def unanswered_faults(self, model: str) -> int:
        """Requests that met with faults of the server only."""
        return len(self._rows("SELECT 1 FROM unanswered WHERE model = ? AND faulty", model))

    def fault_count(self, work: Work) -> int:
        """How often a request met with a fault."""
        query = "SELECT 1 FROM faults WHERE request = ? AND model = ? AND trial = ?"
        return len(self._rows(query, work.request, work.model, work.trial))

    def request(self, digest: str) -> dict[str, Any]:
        """The body of a request as it was planned; pictures are named by their SHA-256."""
        ((text,),) = self._rows("SELECT body FROM requests WHERE hash = ?", digest)
        body: dict[str, Any] = json.loads(text)["request"]
        return body

    def largest(self, model: str) -> tuple[int, int]:
        """The most tokens in, and out, that one answer or fault used."""
        query = "SELECT coalesce(max(input_tokens), 0), coalesce(max(output_tokens), 0) FROM charged WHERE model = ?"
        ((sent, received),) = self._rows(query, model)
        return sent, received

    def spent(self, model: str | None = None) -> tuple[int, float, int]:
        """Tokens and money: of what came back as counted, of requests whose fate is unknown as reserved; and the number of these."""
        query = "SELECT sum(tokens), sum(cost), sum(lost) FROM spending WHERE ?1 IS NULL OR model = ?1"
        ((tokens, cost, lost),) = self._rows(query, model)
        return tokens or 0, cost or 0.0, lost or 0

    def unpriced(self) -> int:
        """Tokens that were spent without prices."""
        return int(self._rows("SELECT coalesce(sum(tokens), 0) FROM spending WHERE cost = 0")[0][0])

    def intend(self, works: Sequence[Work], tokens: int, cost: float) -> list[int]:
        """Write that requests are about to be sent; returns the numbers of the attempts."""
        row = {"started": time.time(), "tokens": tokens, "cost": cost}
        with self.transaction():
            return [self._insert("attempts", work.named | row) for work in works]

    def failed(self, attempt: int, result: str) -> None:
        """Write that an attempt brought no answer, and why."""
        with self.transaction():
            self._db.execute("UPDATE attempts SET ended = ?, result = ? WHERE id = ?", (time.time(), result, attempt))

    def record(self, entries: Sequence[Entry], why: str = "") -> None:
        """Write raw answers, or faults, if `why` says what was wrong."""
        now, table, result = time.time(), "faults" if why else "answers", f"fault: {why}" if why else "answered"
        names = ("attempt", "status", "content_type", "body", "input_tokens", "output_tokens", "cost")
        with self.transaction():
            for work, *rest in entries:
                self._insert(table, work.named | dict(zip(names, rest, strict=True)) | {"received": now})
                self._db.execute("UPDATE attempts SET ended = ?, result = ? WHERE id = ?", (now, result, rest[0]))

    def answers(self, model: str) -> Iterator[Answer]:
        """All draws in the order of the plan, with the answer, or the last fault, or nothing yet."""
        with self._said():
            rows = self._db.execute("SELECT * FROM replies WHERE model = ? ORDER BY id", (model,))
            for _, _, setting, context, people, trial, text, request, occurrence, *rest in rows:
                draw = Draw(model, setting, context, tuple(json.loads(people)), trial, *_shown(text), request, occurrence)
                yield Answer(draw, *rest)

    def repeated(self, model: str) -> bool:
        """Whether several answers to one request have the same id, of a length that is not met by chance."""
        return bool(self._rows("SELECT 1 FROM repeats WHERE model = ? LIMIT 1", model))

    def unknown_fate(self) -> list[dict[str, Any]]:
        """Requests that were sent and whose answer never came back: they may have been paid for."""
        names = ("request", "model", "trial", "moment", "result")
        rows = self._rows("SELECT request, model, trial, datetime(started, 'unixepoch', 'localtime'), result FROM unknown_fate ORDER BY id")
        return [dict(zip(names, row, strict=True)) for row in rows]

    def attempt_results(self, model: str) -> dict[str, int]:
        """How the attempts of a model ended, the server's own words (after a semicolon) left out."""
        return dict(self._rows("SELECT result, count(*) FROM ends WHERE model = ? GROUP BY result ORDER BY result", model))

    @contextlib.contextmanager
    def _said(self) -> Iterator[None]:
        """Turn what SQLite refuses into one sentence."""
        try:
            yield
        except sqlite3.Error as error:
            raise InputError(
                f"the journal {self.path} cannot be read or written: {error}; nothing that was written before is lost"
            ) from None


def _sql(name: str) -> str:
    return (Path(__file__).with_name("sql") / f"{name}.sql").read_text("utf-8")


def _shown(text: str) -> tuple[str, tuple[tuple[str, ...], ...]]:
    context, slots = json.loads(text)
    return context, tuple(map(tuple, slots))


def _list(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
