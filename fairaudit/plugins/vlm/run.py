"""Running an experiment: draw what is shown, ask what has no answer yet, within limits and a budget; resumable at any moment."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import secrets
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.cli.output import rewritten
from fairaudit.errors import InputError, shown
from fairaudit.plugins.vlm.analyse import TABLE
from fairaudit.plugins.vlm.answers import Reading, read_answer
from fairaudit.plugins.vlm.client import Bucket, Client, Reply, pause_before, request_body
from fairaudit.plugins.vlm.experiment import Experiment, Model, Slots
from fairaudit.plugins.vlm.images import image_kind, image_name
from fairaudit.plugins.vlm.journal import Draw, Journal, Work
from fairaudit.plugins.vlm.makers import answer_text, embedded
from fairaudit.plugins.vlm.shares import drawn
from fairaudit.plugins.vlm.tokens import Size, capped, picture_size, request_size, usage

__all__ = ["MAX_UNREADABLE", "Budget", "Report", "estimate", "run"]

BATCH = 500
MAX_UNREADABLE = 20
FAULT_RETRIES = 2
LONGEST_WAIT = 600.0
KEPT = 100_000


@dataclass
class Budget:
    """What may still be spent: money and tokens, over all runs of a journal.

    What a request may use at the most is set aside before it is sent: its cap, or the most that any request used, if that was more. Once
    one used more than was set aside for it, requests go one by one.
    """

    money: float | None = None
    tokens: int | None = None
    prices: tuple[float, float] = (0.0, 0.0)
    spent_money: float = 0.0
    spent_tokens: int = 0
    held: tuple[int, int] = (0, 0)
    largest: tuple[int, int] = (0, 0)
    alone: bool = False

    def cost(self, used: tuple[int, int]) -> float:
        """In the currency of the prices, which are per million tokens."""
        return (used[0] * self.prices[0] + used[1] * self.prices[1]) / 1_000_000

    def most(self, size: Size) -> tuple[int, int]:
        """Tokens in and out that a request may use at the most."""
        return max(size.most, self.largest[0]), max(size.answer, self.largest[1])

    def reserve(self, most: tuple[int, int]) -> bool:
        """Set aside what a request may use; False if that would go beyond the budget, or another one has to come back first."""
        held = self.held[0] + most[0], self.held[1] + most[1]
        if self.alone and any(self.held):
            return False
        if self.money is not None and self.spent_money + self.cost(held) > self.money:
            return False
        if self.tokens is not None and self.spent_tokens + sum(held) > self.tokens:
            return False
        self.held = held
        return True

    def settle(self, most: tuple[int, int], used: tuple[int, int]) -> None:
        """Replace what was set aside by what was used, and learn from it."""
        self.held = self.held[0] - most[0], self.held[1] - most[1]
        self.spent_tokens += sum(used)
        self.spent_money += self.cost(used)
        self.alone = self.alone or used[1] > most[1] or (used[0] > most[0] and self.largest[0] > 0)
        self.largest = max(self.largest[0], used[0]), max(self.largest[1], used[1])


@dataclass
class Report:
    """How a run ended: `faults` counts what met with faults of the server only, `notes` says what the server does with the limits."""

    total: int = 0
    answered: int = 0
    unanswered: list[str] = field(default_factory=list)
    stopped: str = ""
    faults: int = 0
    notes: dict[str, str] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        """Whether everything has an answer."""
        return self.answered == self.total


def progress(model: str, report: Report, budget: Budget, say: Callable[[str], None]) -> Callable[[int], None]:
    """What counts answers, and says spend, rate and time left."""
    first, start = report.answered, time.monotonic()

    def step(count: int) -> None:
        report.answered += count
        rate, left = (report.answered - first) / max(time.monotonic() - start, 1e-9), report.total - report.answered
        spend = f", {budget.spent_money:.4f} spent" if budget.spent_money else ""
        say(f"{model}: {report.answered}/{report.total} answers{spend}, {rate:.1f}/s, {left / rate:.0f} s left")

    return step


def estimate(experiment: Experiment, model: Model, journal: Journal | None = None) -> dict[str, Any]:
    """Calls, tokens (roughly those sent, at the most those received) and money; with a journal of what is left of it.

    `cost` is None without prices, and `pictures_known` says whether the tokens of the pictures are. Where a filter is drawn
    from, the number of calls is that of another drawing than the run's.
    """
    cells = experiment.cells()
    counted = Counter((setting, seen, slots) for setting, _, _, _, seen, slots in _cells(experiment))
    most = {(seen, slots): n for (_, seen, slots), n in reversed(counted.most_common())}  # settings share answers to equal requests
    total, answered = sum(most.values()), 0
    if journal is not None and model.key in journal.models():
        total, answered = journal.size(model.key)
    pictures = {image_name(path): picture_size(path) for path in set(experiment.images.values())}
    sizes = [request_size(capped(request_body(experiment, model, *cell)), pictures) for cell in cells]
    share = Fraction(total - answered, len(cells)) if model.maker == "endpoint" else 0
    used = int(share * sum(s.likely for s in sizes)), int(share * sum(s.answer for s in sizes))
    prices = model.price_input, model.price_output
    return {
        "model": model.key,
        "calls": total,
        "answered": answered,
        "input_tokens": used[0],
        "output_tokens": used[1],
        "cost": Budget(prices=prices).cost(used) if any(prices) and model.maker == "endpoint" else None,
        "pictures_known": all(s.known for s in sizes),
    }


def run(
    experiment: Experiment,
    model: Model,
    journal: Journal,
    *,
    budget: Budget | None = None,
    below: Callable[[int], int] = secrets.randbelow,
    ask_again: bool = False,
    max_unreadable: int = MAX_UNREADABLE,
    go_on: Callable[[str], bool] = lambda _: False,
) -> Report:
    """Ask a model everything that the experiment wants to know and that the journal does not hold yet.

    A first run writes its plan into the journal, with all draws of the filters, before the first request. `below` is the source of the
    randomness of an embedded decision maker (filters always use the operating system's). `ask_again`: also what met with faults of the
    server only. After `max_unreadable` answers in a row that choose nothing (0: never) the run stops, unless `go_on`, which is asked
    with a sentence why, says otherwise.

    Raises
    ------
    InputError
        If the key is missing, the host cannot be reached, the server refuses the request as such, or the journal cannot be written.
    """
    limit = budget or Budget()
    if limit.money is not None and not (model.price_input > 0 and model.price_output > 0) and model.maker == "endpoint":
        raise InputError("a limit on the cost needs both prices: give --price-input and --price-output, or price_input and price_output")
    for name, value in (("cost", limit.money), ("tokens", limit.tokens), ("number of unreadable answers", max_unreadable)):
        if value is not None and not 0 <= value < inf:
            raise InputError(f"the limit on the {name} is {shown(value)}; a number of at least 0 is accepted")
    limit.spent_tokens, limit.spent_money, _ = journal.spent()
    limit.prices = model.price_input, model.price_output
    limit.spent_money += limit.cost((journal.unpriced(), 0)) if limit.prices[0] > limit.prices[1] else limit.cost((0, journal.unpriced()))
    if model.maker != "endpoint":
        maker = embedded(experiment, model)
    if model.key not in journal.models():
        _plan(experiment, model, journal)
    works = journal.open_work(model.key, ask_again=ask_again)
    total, done = journal.size(model.key)
    report = Report(total, done)
    with rewritten() as say:
        step = progress(model.key, report, limit, say)
        if model.maker != "endpoint":
            for start in range(0, len(works), BATCH):
                part = works[start : start + BATCH]
                attempts = journal.intend(part, 0, 0.0)
                texts = [answer_text(experiment, drawn(maker.probabilities(w.context, w.slots), below)) for w in part]
                journal.record([(w, a, 0, "text/plain", t, 0, 0, 0.0) for w, a, t in zip(part, attempts, texts, strict=True)])
                step(len(part))
        while works and model.maker == "endpoint":
            asking = _Asking(experiment, model, journal, limit, report, step, max_unreadable)
            asyncio.run(asking.all(works))
            if asking.fatal:
                raise InputError(asking.fatal)
            if not asking.in_a_row >= max_unreadable > 0 or not report.stopped or not go_on(report.stopped):
                break
            works, report.stopped = journal.open_work(model.key, ask_again=ask_again), ""
    report.faults = journal.unanswered_faults(model.key)
    return report


class _Asking:
    """Asking an endpoint, several requests at a time."""

    def __init__(
        self,
        experiment: Experiment,
        model: Model,
        journal: Journal,
        budget: Budget,
        report: Report,
        step: Callable[[int], None],
        limit: int,
    ) -> None:
        self.experiment, self.model, self.journal, self.budget = experiment, model, journal, budget
        self.report, self.step, self.limit, self.before = report, step, limit, report.answered
        self.files = {image_name(path): path for path in set(experiment.images.values())}
        self.sizes = {name: picture_size(path) for name, path in self.files.items()}
        self.requests = Bucket(model.requests_per_minute)
        self.fatal, self.in_a_row, self.measured = "", 0, False

    async def all(self, works: list[Work]) -> None:
        """Ask everything, or until something says stop; what is in flight then is still waited for.

        Requests go one by one until one was answered, so that its usage is known, and what is wrong is found out once.
        """
        bodies = {digest: self.journal.request(digest) for digest in {work.request for work in works}}
        sizes = {digest: request_size(body, self.sizes) for digest, body in bodies.items()}
        self.tokens = Bucket(self.model.tokens_per_minute, max(size.likely + size.answer for size in sizes.values()))
        self.budget.largest = self.journal.largest(self.model.key)
        self.budget.alone = self.budget.largest[1] > max(size.answer for size in sizes.values())
        queue = iter(works)

        async def worker(*, first: bool = False) -> None:
            for work in queue:
                if self.fatal or self.report.stopped:
                    return
                try:
                    why = await self.one(work, bodies[work.request], sizes[work.request])
                except InputError as error:
                    self.fatal, why = self.fatal or str(error), ""
                if why:
                    self.report.unanswered.append(f"{work.request[:12]} trial {work.trial}: {why}")
                    if self.report.answered == self.before and not self.fatal and not self.report.stopped:
                        self.fatal = f"{self.model.base_url} gives no answer: {why}; what was answered before is kept, run again to go on"
                if first and self.measured:
                    return

        async with Client(self.model, lambda reply: replace(self.read(reply), reason="")) as self.client, asyncio.TaskGroup() as tasks:
            await worker(first=True)
            for _ in range(min(self.model.concurrency, len(works))):
                tasks.create_task(worker())

    def read(self, reply: Reply) -> Reading:
        """What a reply says."""
        return read_answer(self.experiment, reply.status, reply.content_type, reply.body)

    async def one(self, work: Work, body: dict[str, Any], size: Size) -> str:
        """Ask until there is an answer; why there is none, if the attempts are used up."""
        retry = 0
        while (most := await self.reserved(size)) is not None:
            await self.requests.take()
            await self.tokens.take(size.likely + size.answer)
            if self.fatal or self.report.stopped:
                self.budget.settle(most, (0, 0))
                break
            faults = self.journal.fault_count(work)
            (attempt,) = self.journal.intend([work], sum(most), self.budget.cost(most))
            name = f"{work.request[:32]}-{work.trial}/{self.journal.run}{f'/{faults}' if faults else ''}"
            reply = await self.client.send(self.pictured(body), name)
            came = reply if isinstance(reply, Reply) else reply.reply
            if came is not None:
                counted = usage(came.body)
                used = counted or (most if came.status < 300 else (most[0], 0))
                kept = came.body if isinstance(reply, Reply) else came.body[:KEPT]
                entry = (work, attempt, came.status, came.content_type, kept, *used, self.budget.cost(used))
                self.journal.record([entry], "" if isinstance(reply, Reply) else reply.why)
                self.budget.settle(most, used)
            if isinstance(reply, Reply):
                self.answered(reply, counted, size)
                break
            if came is None:
                self.journal.failed(attempt, ("lost: " if reply.lost else "") + reply.why)
                self.budget.settle(most, most if reply.lost else (0, 0))
            if reply.again == "never":
                self.fatal = f"{self.model.base_url} does not accept the request: {reply.why}; what was answered is kept"
            if reply.wait > LONGEST_WAIT:
                self.report.stopped = f"the server asks to wait {reply.wait:g} s ({reply.why}); run again then"
            if reply.again == "now":
                continue
            if self.fatal or self.report.stopped or retry >= min(self.model.retries, 100 if came is None else FAULT_RETRIES):
                return reply.why
            self.requests.block(reply.wait)
            await asyncio.sleep(pause_before(retry, reply.wait))
            retry += 1
        return ""

    async def reserved(self, size: Size) -> tuple[int, int] | None:
        """Set aside what a request may use; what is in flight may turn out cheaper than was set aside for it. None: the run stops."""
        while not self.fatal and not self.report.stopped:
            most = self.budget.most(size)
            if self.budget.reserve(most):
                return most
            if any(self.budget.held):
                await asyncio.sleep(0.01)
            else:
                may = f"use {sum(most)} tokens" + (f" and cost {self.budget.cost(most):.4g}" if self.budget.money is not None else "")
                self.report.stopped = f"the budget does not allow another request, which may {may}; run again with a larger one to go on"
        return None

    def pictured(self, body: dict[str, Any]) -> dict[str, Any]:
        """A request with its pictures in place of their names."""

        def picture(entry: dict[str, Any]) -> dict[str, Any]:
            path = self.files.get(str(entry.get("url")))
            data = path.read_bytes() if path else b""
            return {"url": f"data:{image_kind(data[:8])};base64,{base64.b64encode(data).decode()}"} if path else entry

        found: dict[str, Any] = json.loads(json.dumps(body), object_hook=picture) if self.files else body
        return found

    def answered(self, reply: Reply, used: tuple[int, int] | None, size: Size) -> None:
        """Count an answer, and stop after too many in a row that choose nothing."""
        self.measured = self.measured or reply.status == 200
        self.step(1)
        reading = self.read(reply)
        self.in_a_row = 0 if reading.kind in ("choice", "probabilities") else self.in_a_row + 1
        if self.in_a_row >= self.limit > 0 and self.report.answered < self.report.total:
            last = f"the last one is {reading.kind} ({shown(reading.reason, 120)})"
            self.report.stopped = (
                f"{self.in_a_row} answers in a row choose nothing, {last}; look at the prompt and the output cap, "
                "or run again to go on (--max-unreadable sets how many stop a run)"
            )
        if used is None and reply.status == 200:
            self.report.notes["usage"] = "the server does not say what an answer used: each counts as what it may use at the most"
        elif used is not None and used[1] > size.answer:
            self.report.notes["cap"] = (
                f"the server does not keep the output cap: an answer of at most {size.answer} tokens used {used[1]}; "
                "requests go one by one, and a limit may be exceeded by what one of them uses"
            )


def _plan(experiment: Experiment, model: Model, journal: Journal) -> None:
    """Draw everything that will be shown, number the repetitions of each request, and write that down."""
    bodies: dict[tuple[str, Slots], tuple[str, str]] = {}
    counted: Counter[tuple[int, str]] = Counter()
    draws = []
    for setting, context, people, trial, seen, slots in _cells(experiment):
        if (seen, slots) not in bodies:
            body = {"shown": [seen, slots], "request": capped(request_body(experiment, model, seen, slots))}
            text = json.dumps(body, ensure_ascii=False, separators=(",", ":"))
            bodies[seen, slots] = hashlib.sha256(text.encode()).hexdigest(), text
        digest = bodies[seen, slots][0]
        draws.append(Draw(model.key, setting, context, people, trial, seen, slots, digest, counted[setting, digest]))
        counted[setting, digest] += 1
    journal.plan(draws, bodies.values())


def _cells(experiment: Experiment) -> Iterator[tuple[int, str, tuple[str, ...], int, str, Slots]]:
    """Setting, true context, order, trial, and what is shown."""
    if experiment.design != "end-to-end":
        for context, slots in experiment.cells():
            people = tuple(" ".join(profile) for profile in slots)
            for trial in range(experiment.trials):
                yield TABLE, context, people, trial, context, slots
    if experiment.design == "table":
        return
    for number, setting in enumerate(experiment.settings):
        contexts, profiles = experiment.context_filter(setting), experiment.profile_filter(setting)
        for context in experiment.contexts:
            for order in experiment.orders:
                for trial in range(experiment.trials):
                    seen = contexts.release(context)
                    released = [profiles.release(profile) for profile in experiment.slots(order)]
                    slots = tuple(given if isinstance(given, tuple) else (given,) for given in released)
                    yield number, context, order, trial, seen, slots
