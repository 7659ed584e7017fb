"""From answers to certificates: two utilities, kept apart, and what answers that are no choice may have meant.

*Slot*: g of slot 1, A = the profiles by slot. It does not depend on A, so T2, T3, T9 and T12 apply; the bias of the position cancels.
*Person*: g of a person. It is written as a policy that is shown (slot of the person, profiles) and decides "chosen" or not; the filter
draws the slot with the order and the profiles with their own filters. Its ε is that of exchanging two profiles, 2·ε of one of them, so
that T2 on this filter is T10. With a fixed order the slot gives the person away, ε is infinite, and nothing is guaranteed.
*Position*: g of whoever stands in a slot, people in random order: the bias of the position alone.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, log
from typing import Any, Literal

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.plugins.vlm.answers import UNKNOWN, UNREADABLE, Reading, read_kept, sampling_note
from fairaudit.plugins.vlm.experiment import Experiment, Setting, Slots, fixed
from fairaudit.plugins.vlm.journal import Draw, Journal

__all__ = ["Finding", "Question", "Table", "certify", "tables"]

Question = Literal["slot", "person", "position"]
Number = Fraction | float
DRAWN = "drawn at random"
TABLE = -1
PROMPT = {"model", "messages", "response_format"}


@dataclass(frozen=True)
class Table:
    """What was decided in each cell."""

    setting: int  # the setting whose filter drew what was shown, or -1: asked cell by cell, so that filters are applied afterwards
    rows: Mapping[tuple[str, Slots], Mapping[str, Fraction]]  # by (context, slots): weights of options, ``unreadable``, ``fault``, ``open``
    sampled: bool  # whether the weights are counts, or else probabilities
    complete: bool  # whether nothing is left to be asked; what is left counts as decisions of unknown meaning
    kinds: Counter[str]  # how many answers were of which kind
    note: str = ""  # what shaped the answers, or where probabilities of no option lie
    fixed: str = ""  # why these are no independent draws, so that no interval is claimed


@dataclass(frozen=True)
class Finding:
    """One question at one setting."""

    question: Question
    setting: Setting
    result: fa.Result  # what the core found, with unreadable answers worth what an option that was not chosen is worth
    meanings: Mapping[str, tuple[Number, Number]]  # least and greatest local and global ratio over what unreadable answers may have meant
    interval: Mapping[str, tuple[Number, Number]]  # the same for the population at the confidence; empty without one
    exp_epsilon: Number  # e^ε of the filter of A: that of all attributes of all profiles shown, for the person that of an exchange
    bounds: Mapping[str, Number]  # the least bound of each theorem on the local ratio
    drawn: bool = False  # whether the filter was drawn from, end to end, rather than applied to a table of answers


def tables(experiment: Experiment, journal: Journal, model: str, *, as_shown: bool = False) -> list[Table]:
    """Read what a journal holds of a model: a table for each filter that was drawn from, or, as shown, one of all that was asked."""
    if model not in journal.models():
        raise InputError(f"the journal {journal.path} has no answers of {model}; its models: {', '.join(journal.models()) or 'none yet'}")
    found: dict[int, dict[tuple[str, Slots], dict[str, Fraction]]] = defaultdict(lambda: defaultdict(lambda: defaultdict(Fraction)))
    kinds: dict[int, Counter[str]] = defaultdict(Counter)
    shared: set[tuple[str, int]] = set()
    sampled, outside = experiment.answer != "logprobs", (Fraction(0), "")
    for draw, reading in readings(experiment, journal, model):
        setting = TABLE if as_shown else draw.setting
        if as_shown and (draw.request, draw.occurrence) in shared:
            continue
        shared.add((draw.request, draw.occurrence))
        kinds[setting][reading.kind] += 1
        cell = (draw.shown_context, draw.shown_slots) if setting == TABLE else (draw.context, experiment.slots(draw.people))
        if sampled:
            found[setting][cell][reading.decision] += 1
        else:
            shares = reading.probabilities or (Fraction(0),) * len(experiment.options)
            rest = 1 - sum(shares, Fraction(0))
            found[setting][cell] |= {**dict(zip(experiment.options, shares, strict=True)), reading.decision: rest}
            outside = max(outside, (rest, reading.reason if reading.probabilities else ""))
    note, same = f"Of the probabilities of a first token, in the cell with the most, {outside[1]}." if outside[1] else "", ""
    if sampled and " at http" in model:
        request = journal.request(draw.request)
        note, same = sampling_note(request), fixed({key: request[key] for key in request.keys() - PROMPT})
        if same:
            same = f"with {same} all answers to a request are one answer"
        elif journal.repeated(model):
            same = "several answers have one id, so that the server repeated what it had answered before"
    total, done = journal.size(model)
    complete = total == done + journal.unanswered_faults(model)
    return [Table(setting, dict(rows), sampled, complete, kinds[setting], note, same) for setting, rows in sorted(found.items())]


def readings(experiment: Experiment, journal: Journal, model: str) -> Iterable[tuple[Draw, Reading]]:
    """Every draw, and what its answer says."""
    for answer in journal.answers(model):
        yield answer.draw, read_kept(experiment, answer)


def exact_table(experiment: Experiment, probabilities: Any) -> Table:
    """Lay out the table of a decision maker whose probabilities are known."""
    rows = {}
    for context, slots in experiment.cells():
        shares = probabilities(context, slots)
        rows[context, slots] = {**dict(zip(experiment.options, shares, strict=True)), UNREADABLE: 1 - sum(shares)}
    return Table(-1, rows, sampled=False, complete=True, kinds=Counter())


def questions(experiment: Experiment) -> tuple[Question, ...]:
    """What can be asked: with a fixed order only what happens to people."""
    return ("slot", "person", "position") if experiment.order != "fixed" else ("person",)


def certify(
    experiment: Experiment,
    table: Table,
    setting: Setting,
    question: Question,
    *,
    confidence: Any = "0.95",
    targets: Mapping[str, str] | None = None,
) -> Finding:
    """Answer one question at one setting; `targets` are those of the experiment file by default.

    The confidence is for the population behind counts; None judges the table itself, as does a table of answers that are fixed.
    """
    drawn_already = table.setting >= 0
    level = confidence if table.sampled and not table.fixed else None
    frame = _frame(experiment, setting, question, filtered=not drawn_already)
    limits: Mapping[str, Any] = experiment.targets if targets is None else targets
    context_filter = None if drawn_already or setting.context_keep == 1 else experiment.context_filter(setting)
    policy = _policy(experiment, table, frame)
    declared = {"gamma": max(experiment.chosen, experiment.other), "m": min(experiment.chosen, experiment.other)}
    unknown = _unknown(table)
    result = fa.certify(
        policy.behind(group=frame.kernel, context=context_filter, population=_population(experiment, frame)),
        {frame.chosen: experiment.chosen, frame.not_chosen: experiment.other, **dict.fromkeys(unknown, experiment.other)},
        **limits,
        confidence=level,
        declared=declared,
        undecided=unknown,
    )
    filtered = frame.kernel if not drawn_already else _frame(experiment, setting, question, filtered=True).kernel
    factor: Number = inf if question == "position" else fa.pure_dp(filtered).exp_epsilon
    measured = (("local", result.local), ("global", result.global_))
    meanings: dict[str, tuple[Number, Number]] = {name: (ratio.ratio, ratio.ratio) for name, ratio in measured if ratio is not None}
    for found in result.whatever:  # whatever the answers meant, T2 holds of a table that a filter is applied to, and X is independent of A
        meanings[found.quantity] = (found.least, found.greatest if drawn_already else max(found.least, min(found.greatest, factor)))
    interval: dict[str, tuple[Number, Number]] = {quantity: (own.lower, own.upper) for quantity, own in result.intervals.items()}
    loosest_first = sorted(result.bounds, key=lambda bound: bound.value, reverse=True)
    best: dict[str, Number] = {bound.theorem: bound.value for bound in loosest_first if bound.quantity == "local_ratio"}
    if drawn_already and factor < inf:
        best["T2"] = factor
    return Finding(question, setting, result, meanings, interval, factor, best, drawn_already)


def _population(experiment: Experiment, frame: _Frame) -> dict[tuple[tuple[str, ...], tuple[str, ...]], Fraction] | None:
    """How often contexts occur, the same in every group; None if all occur alike."""
    weights = zip(experiment.contexts, experiment.context_weights, strict=bool(experiment.context_weights))
    return {((context,), label): weight for context, weight in weights for label in frame.kernel.inputs} or None


@dataclass(frozen=True)
class _Frame:
    """A question as a policy behind a filter: columns, the filter's table, and where each output is in the table of answers."""

    columns: tuple[str, ...]
    kernel: fa.Mechanism
    places: tuple[tuple[Slots, int | None], ...]
    chosen: str
    not_chosen: str


def _frame(experiment: Experiment, setting: Setting, question: Question, *, filtered: bool) -> _Frame:
    """Inputs, outputs and probabilities of a question; `places` says which slots an output shows, and which of them is the person's."""
    orders = experiment.orders
    shares = {order: experiment.shown_slots(setting, order) if filtered else {experiment.slots(order): Fraction(1)} for order in orders}
    rows: dict[tuple[str, ...], dict[tuple[Slots, int | None], Fraction]] = defaultdict(lambda: defaultdict(Fraction))
    labels = list(experiment.options) if question == "position" else list(experiment.people)
    if question == "slot":
        columns = tuple(f"{option} {name}" for option in experiment.options for name in experiment.attributes)
        chosen, other = experiment.options[0], "another"
        for order in orders:
            rows[sum(experiment.slots(order), ())] |= {(slots, None): p for slots, p in shares[order].items()}
    else:
        width = len(experiment.options)
        who = ("own", *(("other",) if width == 2 else tuple(f"other {i}" for i in range(1, width))))
        columns = ("slot", *(f"{name} {attribute}" for name in who for attribute in experiment.attributes))
        chosen, other = "chosen", "not chosen"
        for index, label in enumerate(labels):
            row = rows[_label(experiment, label, question)]
            for order in orders:
                slot = order.index(label) if question == "person" else index
                for slots, p in shares[order].items():
                    row[slots, slot] += p / len(orders)
    if len(rows) < len(orders if question == "slot" else labels):
        raise InputError("two people have the same profile; give them different ones")
    places = tuple(dict.fromkeys(place for row in rows.values() for place in row))
    outputs = tuple(_output(experiment, place) for place in places)
    table = [[row.get(place, Fraction(0)) for place in places] for row in rows.values()]
    return _Frame(columns, fa.Mechanism.from_array(table, tuple(rows), outputs), places, chosen, other)


def _label(experiment: Experiment, label: str, question: Question) -> tuple[str, ...]:
    """The true label of a person (own profile, then the others'), or of a slot in which anybody may stand."""
    width = len(experiment.attributes)
    if question == "position":
        return (label, *([DRAWN] * width * len(experiment.options)))
    others = [profile for name, profile in experiment.people.items() if name != label]
    slot = DRAWN if experiment.order != "fixed" else experiment.options[list(experiment.people).index(label)]
    return (slot, *experiment.people[label], *sum(others, ()))


def _output(experiment: Experiment, place: tuple[Slots, int | None]) -> tuple[str, ...]:
    slots, slot = place
    if slot is None:
        return sum(slots, ())
    return (experiment.options[slot], *slots[slot], *sum((profile for i, profile in enumerate(slots) if i != slot), ()))


def _policy(experiment: Experiment, table: Table, frame: _Frame) -> fa.Policy:
    """The answers as a policy of the question: rows of answers that several outputs share are repeated."""
    rows = []
    for (slots, slot), output in zip(frame.places, frame.kernel.outputs, strict=True):
        for context in experiment.contexts:
            row = table.rows.get((context, slots))
            if row is None:
                continue
            chosen = row.get(experiment.options[slot or 0], Fraction(0))
            rest = sum((row.get(option, Fraction(0)) for option in experiment.options), Fraction(0)) - chosen
            weights = {frame.chosen: chosen, frame.not_chosen: rest}
            weights |= {label: row.get(label, Fraction(0)) for label in _unknown(table)}
            rows += [(context, *output, decision, weight) for decision, weight in weights.items()]
    return _read(experiment, frame.columns, rows, sampled=table.sampled)


def shown_policy(experiment: Experiment, table: Table) -> fa.Policy:
    """P(U|X̃,Ã): which option is chosen when these profiles are shown by slot in this context."""
    columns = tuple(f"{option} {name}" for option in experiment.options for name in experiment.attributes)
    rows = [
        (context, *sum(slots, ()), decision, weight)
        for (context, slots), row in table.rows.items()
        for decision, weight in row.items()
        if weight or decision not in UNKNOWN
    ]
    return fa.Policy(replace(_read(experiment, columns, rows, sampled=table.sampled).law, undecided=_unknown(table)))


def _unknown(table: Table) -> tuple[str, ...]:
    """What is no decision of known meaning in a table."""
    return tuple(label for label in UNKNOWN if any(row.get(label) for row in table.rows.values()))


def _read(experiment: Experiment, group: Sequence[str], rows: Iterable[Sequence[Any]], *, sampled: bool) -> fa.Policy:
    """A policy from rows of context, group, decision and weight: a number of answers, or a probability."""
    names = (experiment.context_column, *group, "decision", "weight")
    listed = [[*labels, int(weight) if sampled else str(weight)] for *labels, weight in rows]
    columns = dict(zip(names, map(list, zip(*listed, strict=True)), strict=True))
    if sampled:
        return fa.Policy.from_counts(columns, decision="decision", group=group, context=experiment.context_column, count="weight")
    return fa.Policy.from_probabilities(columns, decision="decision", group=group, context=experiment.context_column, probability="weight")


def logarithm(value: Number) -> float:
    """For people and pictures; certificates compare ratios."""
    return inf if value == inf else log(value)
