"""What a result says in words: which pair of groups decided, who is favoured over whom, and how many decisions stand behind it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache
from math import floor, inf
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fairaudit.errors import shown
from fairaudit.exact.rationals import quotient
from fairaudit.inference.verdicts import SEVERITY, verdict
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns
from fairaudit.tables.values import Label
from fairaudit.words import BENEFIT, ENDS_CROSS, THE_INTERVAL, THIS_TABLE, Words, approximate, noun, percent, place

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.audits.targets import Target
    from fairaudit.model.mechanism import Mechanism
    from fairaudit.model.policy import Deployment

__all__ = [
    "Deciding",
    "Size",
    "Sizes",
    "amount_text",
    "caution",
    "change_text",
    "decide",
    "evaluation_of",
    "few_of_policy",
    "foremost",
    "identifier_text",
    "pair_text",
    "sentence",
    "size_text",
    "sizes",
]


FEW = 10
"""Of fewer draws a single other outcome moves a proportion by more than a tenth."""

LEVELS = 10
"""A column with fewer labels than this is not called an identifier, however few decisions each has."""

Drivers = tuple[Witness | None, Witness | None]


@dataclass(frozen=True)
class Size:
    """How much was recorded of a group.

    Attributes
    ----------
    decisions : Fraction
        Decisions, or the sum of their weights.
    units : int or None
        Sampling units, where a unit can have several decisions.
    """

    decisions: Fraction
    units: int | None = None

    @property
    def draws(self) -> Fraction | int:
        """Units, where there are any, else decisions."""
        return self.decisions if self.units is None else self.units

    @property
    def few(self) -> bool:
        """Whether there are fewer than ten draws."""
        return self.draws < FEW

    @property
    def text(self) -> str:
        """Decisions, for a person: whole numbers as they are, sums of weights rounded down, to one decimal or four digits."""
        if self.decisions.denominator == 1:
            return f"{int(self.decisions):,}"
        if self.decisions < 100:
            return approximate(self.decisions, "down")
        return f"{Decimal(floor(10 * self.decisions)) / 10:,.1f}"


Sizes = tuple[Size, Size]


@dataclass(frozen=True)
class Deciding:
    """What decided the verdict on a target.

    Attributes
    ----------
    quantity : {"local", "global"}
        What the target limits.
    verdict : {"within", "exceeds", "inconclusive"}
        Its verdict.
    end : {"table", "lower", "upper"}
        Whether the ratio of the table was compared with the limit, or which end of what is known of the population: the lower one for
        "exceeds", else the upper one.
    value : Fraction or float
        That ratio or end.
    by : str
        ``"this table"``, ``"the interval"``, the theorem that gave the upper end, or ``"the ends cross"``: of what is known of the
        population the lower end is above the limit and the upper one is not.
    confidence : Fraction or None
        What was judged: the population at this confidence, or the table.
    pair : Witness or None
        The pair of groups whose ratio or end it is, with what each gets in the table; None where a theorem bounds every pair, where nothing
        is known of the population, and where all groups are alike.
    unit : {"ratio", "difference"}
        What `value` is.
    """

    quantity: Literal["local", "global"]
    verdict: Literal["none", "within", "exceeds", "inconclusive", "depends", "changed"]
    end: Literal["table", "lower", "upper"]
    value: Fraction | float
    by: str
    confidence: Fraction | None
    pair: Witness | None
    unit: Literal["ratio", "difference"] = "ratio"


def decide(target: Target, measured: Ratio | None, lower: Fraction | float | None, drivers: Drivers) -> Deciding | None:
    """Say what decided a target; None where nothing could be compared, or a window contradicts the stream.

    Parameters
    ----------
    target : Target
        The target, judged.
    measured : Ratio or None
        Its quantity in the table.
    lower : Fraction or float or None
        The lower end of its interval, where there is one.
    drivers : pair of Witness or None
        The pairs behind the lower and the upper end of that interval.
    """
    if measured is None or target.verdict == "changed" or (target.confidence is not None and target.verdict == "exceeds" and lower is None):
        return None
    if target.confidence is None or (target.under and target.verdict != "exceeds"):
        return Deciding(target.quantity, target.verdict, "table", measured.ratio, THIS_TABLE, None, measured.witness)
    if target.verdict == "exceeds":
        return Deciding(target.quantity, "exceeds", "lower", lower or Fraction(1), THE_INTERVAL, target.confidence, drivers[0])
    value, by = target.upper or (inf, THE_INTERVAL)
    if target.verdict == "inconclusive" and lower is not None and lower > value and not _above(value, target):
        return Deciding(target.quantity, target.verdict, "upper", value, ENDS_CROSS, target.confidence, None)
    pair = drivers[1] if by == THE_INTERVAL and target.upper else None
    return Deciding(target.quantity, target.verdict, "upper", value, by, target.confidence, pair)


def _above(end: Fraction | float, target: Target) -> bool:
    """Whether an end is above the limit of a target."""
    return verdict((Fraction(1), end), **{f"max_{target.unit}": target.limit}) != "within"


def foremost(verdicts: Iterable[str], found: Iterable[Deciding | None]) -> Deciding | None:
    """What decided the first target of those that determine the verdict on all: "exceeds" before "inconclusive" before "within"."""
    judged = zip(verdicts, found, strict=True)
    return max(judged, key=lambda target: SEVERITY[target[0]], default=("none", None))[1]


def pair_text(witness: Witness, name: Callable[[Mapping[str, str]], str] = place) -> str:
    """Name a pair of groups, the one with the higher expectation first.

    Examples
    --------
    >>> pair_text(Witness({"Dept": "A"}, {"sex": "f"}, {"sex": "m"}, (Fraction(1), Fraction(1, 2))))
    'Dept=A: sex=f over sex=m'
    """
    where = f"{name(witness.context)}: " if witness.context else ""
    return f"{where}{name(witness.higher)} over {name(witness.lower)}"


def size_text(found: Sizes | None) -> str:
    """How much was recorded of the two groups of a pair, in brackets; empty where that is not known.

    Examples
    --------
    >>> size_text((Size(Fraction(108)), Size(Fraction(1825)))), size_text((Size(Fraction(31, 2), 3), Size(Fraction(20), 4)))
    ('(n = 108 and 1,825)', '(n = 3 and 4 units, 15.5 and 20 decisions)')
    """
    if found is None:
        return ""
    one, other = found
    if one.units is None or other.units is None:
        return f"(n = {one.text} and {other.text})"
    return f"(n = {one.units:,} and {other.units:,} units, {one.text} and {other.text} decisions)"


def change_text(
    quantity: str,
    window: int,
    stream: tuple[Fraction | float, Fraction | float],
    ratio: tuple[Fraction | float, Fraction | float],
    confidence: Fraction,
) -> str:
    """Say that a window contradicts the stream."""
    ends = [f"{approximate(low, 'down')} to {approximate(high, 'up')}" for low, high in (ratio, stream)]
    return (
        f"The {quantity} ratio changed: {ends[0]} in window {window}, {ends[1]} in the whole stream until then; a constant ratio would "
        f"show this with probability at most {approximate(1 - confidence, 'up')}."
    )


def evaluation_of(result: Result) -> dict[str, Any] | None:
    """What is said of the evaluation log that was counted, if it was one; its cells only where the table may be disclosed."""
    law = result.law
    if law.evaluation is None:
        return None
    from fairaudit.certificates.evaluation import evaluation_entry

    return evaluation_entry(law, law.evaluation, cells=result.embed is not False)


def lost_text(said: Mapping[str, Any] | None) -> str:
    """Say how many answers of an evaluation log decide nothing, and how many samples are not in it; empty where all are there.

    Examples
    --------
    >>> lost_text({"answers": {"read": 17, "refused": 2, "error": 1}, "samples": {"expected": 24, "read": 20}})
    'Of 20 answers of the evaluation log 3 decide nothing. Of 24 samples 4 are not in the log.'
    """
    if said is None:
        return ""
    answers, samples = said["answers"], said["samples"]
    lost = sum(answers.values()) - answers["read"]
    absent = 0 if samples["expected"] is None else samples["expected"] - samples["read"]
    found = (
        [
            (
                f"Of {sum(answers.values()):,} {noun(sum(answers.values()), 'answer')} of the evaluation log {lost:,} "
                f"{'decides' if lost == 1 else 'decide'} nothing."
            )
        ]
        if lost
        else []
    )
    return " ".join(
        [
            *found,
            *(
                [
                    (
                        f"Of {samples['expected']:,} {noun(samples['expected'], 'sample')} {absent:,} "
                        f"{'is' if absent == 1 else 'are'} not in the log."
                    )
                ]
                if absent
                else []
            ),
        ]
    )


def sentence(
    deciding: Deciding | None,
    local: Ratio | None,
    global_: Ratio | None,
    words: Words = BENEFIT,
    *,
    sizes_of: Callable[[Witness], Sizes | None] = lambda _: None,
    name: Callable[[Mapping[str, str]], str] = place,
    contexts: bool = True,
    mean: str = "in the table",
) -> str:
    """Say who is favoured over whom, where, and by what factor: of the pair that decided, or the most unequal one where there is no target.

    Parameters
    ----------
    deciding : Deciding or None
        What decided the verdict, where a target was judged.
    local, global_ : Ratio or None
        Both quantities in the table.
    words : Words
        How to speak of what is compared.
    sizes_of : callable
        Gives how much was recorded of a pair.
    name : callable
        Names a group or context.
    contexts : bool
        Whether there are contexts.
    mean : str
        What the expectations of a pair behind an interval are.

    Returns
    -------
    str
        One or two sentences.
    """
    say = _Speaker(words, sizes_of, name, "over all contexts, " if contexts else "")
    if deciding is not None:
        return say.decided(deciding, local if deciding.quantity == "local" else global_, mean)
    if local is None:
        opening = "No context has two groups, so nobody is compared within a context; "
        return opening + (say.table(global_) if global_ else "nothing else can be compared either.")
    if local.ratio == 1:
        if global_ is None or global_.ratio == 1:
            return f"All groups that are compared have the same {words.amount} in every context."
        why = "because groups are spread differently over them, "
        return f"In every context all compared groups have the same {words.amount}, but {say.table(global_, why)}"
    return _capital(say.table(local))


@dataclass(frozen=True)
class _Speaker:
    """The parts of a sentence."""

    words: Words
    sizes_of: Callable[[Witness], Sizes | None]
    name: Callable[[Mapping[str, str]], str]
    everywhere: str

    def table(self, measured: Ratio, why: str = "", of: str = "") -> str:
        """What the table shows of its most unequal pair."""
        witness = measured.witness
        where = self._where(witness) + why
        if measured.ratio == 1:
            return f"{where}all compared groups have the same {self.words.amount}{of}."
        factor = (
            f"{approximate(measured.ratio)} times {self.words.much}"
            if isinstance(measured.ratio, Fraction)
            else "so R and log R are infinite"
        )
        who = f"{self.name(witness.higher)} {self.words.worse} {self.name(witness.lower)}"
        return f"{where}{who}: {self.words.amounts(witness.expectations)}{of}, {factor}{self._size(witness)}."

    def decided(self, deciding: Deciding, measured: Ratio | None, mean: str) -> str:
        """What decided, with what the table shows beside it."""
        if deciding.end == "table" and measured is not None:
            return _capital(self.table(measured))
        pair, end, much = deciding.pair, deciding.value, self.words.much
        if pair is None:
            beside = "" if measured is None else f" {_capital(self.table(measured, of=' in the table'))}"
            return f"{self._for_all(deciding)}{beside}"
        sure = f"in the population, at confidence {percent(deciding.confidence or 0)}"
        where, high, low = self._where(pair), self.name(pair.higher), self.name(pair.lower)
        amounts, size = f"{self.words.amounts(pair.expectations)} {mean}", self._size(pair)
        if deciding.end == "lower":
            ratio = quotient(*pair.expectations)
            factor = f", {approximate(ratio)} times {much}" if isinstance(ratio, Fraction) else ""
            least = f"at least {approximate(end, 'down')} times {sure}"
            return _capital(f"{where}{high} {self.words.worse} {low}: {amounts}{factor}, and {least}{size}.")
        if deciding.verdict == "within":
            most = f"comes closest to the limit: at most {approximate(end, 'up')} times {much} {sure}"
        elif end == inf:
            most = f"leaves it open, without an upper end {sure}"
        else:
            most = f"leaves it open: up to {approximate(end, 'up')} times {much} {sure}"
        return _capital(f"{where}{high} over {low} {most}; {amounts}{size}.")

    def _for_all(self, deciding: Deciding) -> str:
        """What holds for every pair of groups."""
        if deciding.end == "lower":
            least = f"At least {approximate(deciding.value, 'down')} times {self.words.much} in the population"
            return f"{least}, at confidence {percent(deciding.confidence or 0)}, for a pair of groups that only the table names."
        much = f"{approximate(deciding.value, 'up')} times {self.words.much}"
        if deciding.by == ENDS_CROSS:
            return f"The ends cross: the lower one is above the limit, the upper one ({much}) is not, so nothing is decided."
        if deciding.by != THE_INTERVAL:
            if deciding.verdict == "within":
                return f"{deciding.by} bounds every pair of groups: at most {much}."
            return f"{deciding.by} gives the smallest upper end, for every pair of groups: {much}."
        if deciding.value == inf:
            return "Nothing bounds the population behind the table from above."
        return f"The interval bounds every pair of groups by {much} in the population, at confidence {percent(deciding.confidence or 0)}."

    def _where(self, witness: Witness) -> str:
        if witness.context is None:
            return self.everywhere
        return f"in {self.name(witness.context)}, " if witness.context else ""

    def _size(self, witness: Witness) -> str:
        found = size_text(self.sizes_of(witness))
        return f" {found}" if found else ""


def _capital(text: str) -> str:
    """The same with a capital letter where it begins with a word of ours, not with a label."""
    return text[:1].upper() + text[1:] if text.startswith(("in ", "over all contexts", "all compared")) else text


def sizes(law: Law, witnesses: Sequence[Witness]) -> list[Sizes | None]:
    """How much was recorded of the two groups of each pair; None where probabilities were given, or the contexts are not those of the law.

    Of a pair within a context that is its two cells, over all contexts all rows of its two groups.
    """
    if law.kind != "counts":
        return [None] * len(witnesses)
    wanted = {tuple(w.context.values()) for w in witnesses if w.context is not None}
    context_of = {label: i for i, label in enumerate(law.contexts) if label in wanted}
    group_of = {label: i for i, label in enumerate(law.groups)}

    @cache
    def over_contexts(group: int) -> Size | None:
        chosen = law.totals[law.cell_group == group].tolist()
        return Size(Fraction(sum(chosen), law.scale)) if chosen else None

    def of(context: Label | None, group: int) -> Size | None:
        if context is None:
            return over_contexts(group)
        first, last = np.searchsorted(law.cell_context, [context_of.get(context, -1), context_of.get(context, -1) + 1]).tolist()
        for cell in range(first, last):
            if law.cell_group[cell] == group:
                units = law.units.profiles[cell] if law.units is not None and law.units.repeated else None
                return Size(Fraction(sum(law.row(cell)), law.scale), None if units is None else sum(n for n, _ in units))
        return None

    found: list[Sizes | None] = []
    for witness in witnesses:
        context = None if witness.context is None else tuple(witness.context.values())
        one, other = (of(context, group_of[tuple(labels.values())]) for labels in (witness.higher, witness.lower))
        found.append(None if one is None or other is None else (one, other))
    return found


def caution(witness: Witness | None, found: Sizes | None, identifiers: str, name: Callable[[Mapping[str, str]], str] = place) -> str:
    """What to know before a headline: that a column looks like an identifier, or that hardly any decisions stand behind it.

    Examples
    --------
    >>> pair = Witness({"Dept": "A"}, {"sex": "f"}, {"sex": "m"}, (Fraction(1), Fraction(1, 2)))
    >>> caution(pair, (Size(Fraction(3)), Size(Fraction(100))), "")
    'Only 3 decisions stand behind sex=f in Dept=A.'
    """
    said = [identifiers] if identifiers else []
    if witness is not None and found is not None:
        where = f" in {name(witness.context)}" if witness.context else ""
        few = [(size, labels) for size, labels in zip(found, (witness.higher, witness.lower), strict=True) if size.few]
        verbs = [f"stand{'s' if size.draws == 1 else ''} " if i == 0 else "" for i, (size, _) in enumerate(few)]
        listed = [f"{amount_text(size)} {verb}behind {name(labels)}" for verb, (size, labels) in zip(verbs, few, strict=True)]
        said += [f"Only {' and '.join(listed)}{where}."] if few else []
    return " ".join(said)


def few_of_policy(deployment: Deployment | None, witness: Witness | None) -> str:
    """Say if hardly any decisions show what a policy does with something that its filters can show it of a pair of groups."""
    if deployment is None or witness is None or deployment.policy.law.kind != "counts":
        return ""
    law, contexts = deployment.policy.law, deployment.contexts if witness.context is None else (tuple(witness.context.values()),)
    groups = [tuple(labels.values()) for labels in (witness.higher, witness.lower)]
    seen_groups = {label for group in groups for label in _released(deployment.group_filter, group)}
    filtered = deployment.context_filter
    seen = {label for context in contexts for label in ([context] if filtered is None else _released(filtered, context))}
    totals = [
        (Fraction(sum(law.row(cell)), law.scale), x, a)
        for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))
        if law.contexts[x] in seen and law.groups[a] in seen_groups
    ]
    if not totals or not (least := Size(min(totals)[0])).few:
        return ""
    _, x, a = min(totals)
    where = f" in {place(law.context_label(x))}" if law.contexts[x] else ""
    return f"Only {amount_text(least)} show{'s' if least.draws == 1 else ''} what the policy does with {place(law.group_label(a))}{where}."


def _released(mechanism: Mechanism, value: Label) -> list[Label]:
    return [out for out, weight in zip(mechanism.outputs, mechanism.row(value), strict=True) if weight]


def amount_text(size: Size) -> str:
    """How much was recorded of a group, in words.

    Examples
    --------
    >>> amount_text(Size(Fraction(1825))), amount_text(Size(Fraction(12), 1))
    ('1,825 decisions', '1 unit (12 decisions)')
    """
    if size.units is not None:
        return f"{size.units:,} {noun(size.units, 'unit')} ({size.text} decisions)"
    return f"{size.text} {noun(size.decisions, 'decision')}"


def identifier_text(law: Law, columns: Columns, contexts: Sequence[Any] | None = None) -> str:
    """Name the columns of groups and contexts that have nearly as many labels as there are decisions, as an identifier has.

    Parameters
    ----------
    law : Law
        What was counted.
    columns : Columns
        The names of the columns.
    contexts : sequence of labels, optional
        The labels of the contexts, where the law does not have them.
    """
    if law.kind != "counts":
        return ""
    rows = Fraction(sum(law.cell_mass), law.scale)
    listed = [(columns.group, law.groups), (columns.context, law.contexts if contexts is None else contexts)]
    said = []
    for names, labels in listed:
        for i, column in enumerate(names):
            levels = len({label[i] for label in labels})
            if levels >= LEVELS and 2 * levels >= rows:
                said.append(f"The column {shown(column)} has {levels:,} labels in {Size(rows).text} decisions, like an identifier.")
    return " ".join(said)


def headline_pair(deciding: Deciding | None, local: Ratio | None, global_: Ratio | None) -> Witness | None:
    """The pair of groups that the sentence of a result is about."""
    if deciding is not None and deciding.pair is not None:
        return deciding.pair
    if deciding is not None:
        measured = local if deciding.quantity == "local" else global_
    else:
        measured = global_ if local is None or (local.ratio == 1 and global_ is not None and global_.ratio > 1) else local
    return None if measured is None else measured.witness
