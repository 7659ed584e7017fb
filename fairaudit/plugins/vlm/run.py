"""Running an experiment: draw what is shown, ask what has no answer yet, within limits and a budget; resumable at any moment."""

from __future__ import annotations

import asyncio
import hashlib
import json
import secrets
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError
from fairaudit.plugins.vlm.answers import usage
from fairaudit.plugins.vlm.client import Bucket, Client, Failure, Reply, estimated_tokens, pause_before, request_body
from fairaudit.plugins.vlm.experiment import Experiment, Model, Slots
from fairaudit.plugins.vlm.journal import Draw, Journal, Work
from fairaudit.plugins.vlm.makers import answer_text, embedded
from fairaudit.plugins.vlm.shares import drawn

__all__ = ["Budget", "Estimate", "Progress", "Report", "estimate", "run"]

TABLE = -1
BATCH = 500


@dataclass
class Budget:
    """What may still be spent: money and tokens, over all runs of a journal."""

    money: float | None = None
    tokens: int | None = None
    spent_money: float = 0.0
    spent_tokens: int = 0
    held_money: float = 0.0
    held_tokens: int = 0

    def reserve(self, tokens: int, money: float) -> bool:
        """Set aside the estimate of a request; False if that would go beyond the budget."""
        if self.money is not None and self.spent_money + self.held_money + money > self.money:
            return False
        if self.tokens is not None and self.spent_tokens + self.held_tokens + tokens > self.tokens:
            return False
        self.held_money += money
        self.held_tokens += tokens
        return True

    def settle(self, tokens: int, money: float, real_tokens: int, real_money: float) -> None:
        """Replace what was set aside by what it cost."""
        self.held_money -= money
        self.held_tokens -= tokens
        self.spent_money += real_money
        self.spent_tokens += real_tokens


@dataclass(frozen=True)
class Estimate:
    """What a run will ask and cost at the most, roughly."""

    model: str
    calls: int
    answered: int
    input_tokens: int
    output_tokens: int
    cost: float


@dataclass
class Report:
    """How a run ended."""

    total: int = 0
    answered: int = 0
    unanswered: list[str] = field(default_factory=list)
    stopped: str = ""

    @property
    def complete(self) -> bool:
        """Whether everything has an answer."""
        return self.answered == self.total and not self.stopped


class Progress:
    """Calls, spend, rate and time left, on one line of a terminal."""

    def __init__(self, model: str, total: int, done: int, budget: Budget) -> None:
        self._model, self._total, self._done, self._first, self._budget = model, total, done, done, budget
        self._start = self._last = time.monotonic()
        self._on = sys.stderr is not None and sys.stderr.isatty()

    def step(self, count: int = 1) -> None:
        """Count answers."""
        self._done += count
        now = time.monotonic()
        if self._on and (now - self._last > 0.2 or self._done == self._total):
            self._last = now
            rate = (self._done - self._first) / max(now - self._start, 1e-9)
            left = (self._total - self._done) / rate if rate else 0.0
            spend = f", {self._budget.spent_money:.4f} spent" if self._budget.spent_money else ""
            line = f"{self._model}: {self._done}/{self._total} answers{spend}, {rate:.1f}/s, {left:.0f} s left"
            sys.stderr.write("\r\x1b[K" + "".join(c if c.isprintable() else "?" for c in line[:120]))
            sys.stderr.flush()

    def end(self) -> None:
        """Leave the line."""
        if self._on:
            sys.stderr.write("\n")


def estimate(experiment: Experiment, model: Model, journal: Journal | None = None) -> Estimate:
    """Calls, tokens and money of an experiment; with a journal of what is left of it."""
    size = len(list(_cells(experiment)))
    open_share = 1.0
    answered = 0
    if journal is not None and model.key in journal.models():
        total, answered = journal.size(model.key)
        open_share, size = (total - answered) / total, total
    cells = experiment.cells()
    tokens = [estimated_tokens(request_body(experiment, model, x, slots, pictures=False)) for x, slots in cells]
    calls = size if open_share < 1 or experiment.design == "end-to-end" else len(cells) * experiment.trials
    share = (calls - answered) / len(cells)
    into, out = int(share * sum(t[0] for t in tokens)), int(share * sum(t[1] for t in tokens))
    if model.maker != "endpoint":
        into = out = 0
    return Estimate(model.key, calls, answered, into, out, _cost(model, into, out))


def run(
    experiment: Experiment,
    model: Model,
    journal: Journal,
    *,
    budget: Budget | None = None,
    below: Callable[[int], int] = secrets.randbelow,
) -> Report:
    """Ask a model everything that the experiment wants to know and that the journal does not hold yet.

    Parameters
    ----------
    experiment : Experiment
        What to ask.
    model : Model
        Whom.
    journal : Journal
        Where answers are kept; a first run writes its plan, with all draws of the filters, before the first request.
    budget : Budget, optional
        Where to stop.
    below : callable
        Source of the randomness of an embedded decision maker; the operating system's by default. Filters always use the latter.

    Returns
    -------
    Report
        Complete, or why not.

    Raises
    ------
    InputError
        If the key is missing, the host cannot be reached, the server refuses the request as such, or the journal cannot be written.
    """
    limit = budget or Budget()
    limit.spent_tokens, limit.spent_money, _ = journal.spent()
    if model.maker != "endpoint":
        maker = embedded(experiment, model)
    if model.key not in journal.models():
        _plan(experiment, model, journal)
    works = journal.open_work(model.key)
    total, done = journal.size(model.key)
    report = Report(total, done)
    progress = Progress(model.key, total, done, limit)
    try:
        if model.maker != "endpoint":
            for start in range(0, len(works), BATCH):
                part = works[start : start + BATCH]
                attempts = journal.intend(part, 0, 0.0)
                texts = [answer_text(experiment, drawn(maker.probabilities(w.context, w.slots), below)) for w in part]
                journal.record([(w, a, 0, "text/plain", t, 0, 0, 0.0) for w, a, t in zip(part, attempts, texts, strict=True)])
                report.answered += len(part)
                progress.step(len(part))
        elif works:
            _ask(experiment, model, journal, works, limit, report, progress)
    finally:
        progress.end()
    return report


def _ask(
    experiment: Experiment, model: Model, journal: Journal, works: list[Work], budget: Budget, report: Report, progress: Progress
) -> None:
    try:
        asyncio.run(_all(experiment, model, journal, works, budget, report, progress))
    except* InputError as group:
        found: BaseException = group
        while isinstance(found, BaseExceptionGroup):
            found = found.exceptions[0]
        raise found from None


async def _all(
    experiment: Experiment, model: Model, journal: Journal, works: list[Work], budget: Budget, report: Report, progress: Progress
) -> None:
    cells = {(w.context, w.slots) for w in works}
    sizes = {cell: estimated_tokens(request_body(experiment, model, *cell, pictures=False)) for cell in cells}
    requests = Bucket(model.requests_per_minute)
    tokens = Bucket(model.tokens_per_minute, largest=max(sum(size) for size in sizes.values()))
    queue, before = iter(works), report.answered
    async with Client(model) as client, asyncio.TaskGroup() as tasks:

        async def worker() -> None:
            for work in queue:
                if report.stopped:
                    return
                why = await one(work, sizes[work.context, work.slots])
                if why:
                    report.unanswered.append(f"{work.request[:12]} trial {work.trial}: {why}")
                    if report.answered == before:
                        raise InputError(f"{model.base_url} gives no answer: {why}; what was answered before is kept, run again to go on")

        async def one(work: Work, size: tuple[int, int]) -> str:
            """Ask until there is an answer; why there is none, if the attempts are used up."""
            body = request_body(experiment, model, work.context, work.slots)
            held, money = sum(size), _cost(model, *size)
            why = ""
            for retry in range(model.retries + 1):
                await _reserve(budget, report, held, money)
                await requests.take()
                await tokens.take(held)
                if report.stopped:
                    return ""
                (attempt,) = journal.intend([work], held, money)
                reply = await client.send(body, f"{work.request[:32]}-{work.trial}")
                if isinstance(reply, Reply):
                    counted = usage(reply.status, reply.body) or (size if reply.status == 200 else (0, 0))
                    cost = _cost(model, *counted)
                    journal.record([(work, attempt, reply.status, reply.content_type, reply.body, *counted, cost)])
                    budget.settle(held, money, sum(counted), cost)
                    report.answered += 1
                    progress.step()
                    return ""
                why = _no_answer(journal, budget, model, attempt, reply, held, money)
                if reply.wait:
                    requests.block(reply.wait)
                if retry < model.retries:
                    await asyncio.sleep(pause_before(retry, reply.wait))
            return why

        for _ in range(min(model.concurrency, len(works))):
            tasks.create_task(worker())


async def _reserve(budget: Budget, report: Report, tokens: int, money: float) -> None:
    """Set aside what a request may cost; what is in flight may turn out cheaper than was set aside for it."""
    while not report.stopped and not budget.reserve(tokens, money):
        if not budget.held_tokens:
            report.stopped = "the budget does not allow another request"
        else:
            await asyncio.sleep(0.02)


def _no_answer(journal: Journal, budget: Budget, model: Model, attempt: int, failure: Failure, tokens: int, money: float) -> str:
    journal.failed(attempt, ("lost: " if failure.lost else "") + failure.why)
    budget.settle(tokens, money, tokens if failure.lost else 0, money if failure.lost else 0.0)
    if not failure.retry:
        raise InputError(f"{model.base_url} does not accept the request: {failure.why}; what was answered is kept")
    return failure.why


def _plan(experiment: Experiment, model: Model, journal: Journal) -> None:
    """Draw everything that will be shown, number the repetitions of each request, and write that down."""
    bodies: dict[tuple[str, Slots], tuple[str, str]] = {}
    counted: Counter[tuple[int, str]] = Counter()
    draws = []
    for setting, context, people, trial, seen, slots in _cells(experiment):
        if (seen, slots) not in bodies:
            body = {"shown": [seen, slots], "request": request_body(experiment, model, seen, slots, pictures=False)}
            text = json.dumps(body, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
            bodies[seen, slots] = hashlib.sha256(text.encode()).hexdigest(), text
        digest = bodies[seen, slots][0]
        draws.append(Draw(model.key, setting, context, people, trial, seen, slots, digest, counted[setting, digest]))
        counted[setting, digest] += 1
    journal.plan(draws, bodies.values())


def _cells(experiment: Experiment) -> Iterator[tuple[int, str, tuple[str, ...], int, str, Slots]]:
    """Setting, true context, order, trial, and what is shown."""
    if experiment.design == "table":
        for context, slots in experiment.cells():
            people = tuple(" ".join(profile) for profile in slots)
            for trial in range(experiment.trials):
                yield TABLE, context, people, trial, context, slots
        return
    for number, setting in enumerate(experiment.settings):
        contexts, profiles = experiment.context_filter(setting), experiment.profile_filter(setting)
        for context in experiment.contexts:
            for order in experiment.orders:
                for trial in range(experiment.trials):
                    seen = context if contexts is None else contexts.release(context)
                    slots = tuple(_tuple(profiles.release(profile)) for profile in experiment.slots(order))
                    yield number, context, order, trial, seen, slots


def _tuple(released: Any) -> tuple[str, ...]:
    return released if isinstance(released, tuple) else (released,)


def _cost(model: Model, into: int, out: int) -> float:
    """In the currency of the prices, which are per million tokens."""
    return (into * model.price_input + out * model.price_output) / 1_000_000


def folder_of(experiment: Experiment, given: str | None) -> Path:
    """Where journal, tables, certificates and figure of an experiment are."""
    return Path(given) if given is not None else Path(experiment.name)
