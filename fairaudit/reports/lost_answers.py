"""What reports say of an evaluation log: how it was read, and which of its answers decide nothing, by group."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.errors import shown
from fairaudit.model.law import Law
from fairaudit.reports.overview_parts import rate_text
from fairaudit.reports.words import Value, clip, named
from fairaudit.words import noun

__all__ = ["LostAnswers", "lost_answers", "lost_text"]

HEADS = ("answers", "refused", "not understood", "cut off")

ERRORS = {"drop": "error, left out", "bound": "error, kept"}

SHOW_GROUPS = 3  # in a sentence

SHOW_CONTEXTS = 10  # in a table


ABOUT = {
    "questions were drawn": "questions like these",
    "the questions are fixed": "answers to these questions",
    "sampling units were drawn": "units like these",
    "samples were drawn": "samples like these",
}
"""Of what intervals speak, by how the sentence begins that says what was drawn."""


@dataclass(frozen=True)
class OfGroup:
    """Of a group how many answers there are, and how many of them decide nothing.

    Attributes
    ----------
    label : str
        The group, escaped.
    context : str
        Within which context, escaped; empty over all.
    asked : int or None
        How many answers there are, those that ended in an error included; None where that is not known.
    counts : mapping of str to int
        How many of them decide nothing, by kind.
    """

    label: str
    context: str
    asked: int | None
    counts: Mapping[str, int]

    @property
    def lost(self) -> int:
        """How many decide nothing."""
        return sum(self.counts.values())

    @property
    def share(self) -> Fraction:
        """Which part of all that is."""
        return Fraction(self.lost, self.asked) if self.asked else Fraction(0)

    @property
    def words(self) -> str:
        """Of how many, and in per cent."""
        return f"{self.label} {self.lost:,}" + (f" of {self.asked:,} ({rate_text(Value(self.share))})" if self.asked else "")

    @property
    def cells(self) -> tuple[str, ...]:
        """What the columns of `HEADS` say."""
        from fairaudit.tables.evaluations.samples import NOTHING_DECIDED

        share = f" ({rate_text(Value(self.share))})" if self.asked else ""
        asked = "" if self.asked is None else f"{self.asked:,}"
        return (asked, *(f"{self.counts.get(kind, 0):,}" for kind in NOTHING_DECIDED), f"{self.lost:,}{share}")


@dataclass(frozen=True)
class LostAnswers:
    """What is said of an evaluation log.

    Attributes
    ----------
    read : tuple of str
        How it was read, and what was drawn.
    caution : str
        Which answers decide nothing, and of whom; empty where there are none.
    groups : tuple of OfGroup
        The same by group, the one that lost most first; empty where no answer is lost, or by group it is not known.
    cells : tuple of OfGroup
        The same within contexts, the most unequal one first; empty where there are not several, or how many answers they have is not known.
    more : int
        How many contexts in which answers are lost are not among them.
    heads : tuple of str
        What the columns of a table say.
    """

    read: tuple[str, ...]
    caution: str
    groups: tuple[OfGroup, ...]
    cells: tuple[OfGroup, ...]
    more: int
    heads: tuple[str, ...]


def lost_answers(said: Mapping[str, Any] | None, law: Law | None) -> LostAnswers | None:
    """Say what a certificate says of an evaluation log.

    Parameters
    ----------
    said : mapping or None
        Its `subject.evaluation`.
    law : Law or None
        Its table, where that is at hand.

    Examples
    --------
    >>> answers = {"read": 17, "refused": 2, "unreadable": 0, "truncated": 0, "error": 1}
    >>> said = {"format": "inspect", "epochs": 1, "errors": "drop", "answers": answers, "drawn": "samples were drawn",
    ...         "samples": {"expected": 20, "read": 20, "counted": 20, "rows": 20},
    ...         "cells": [{"context": [], "group": ["b"], "read": 7, "refused": 2, "error": 1}]}
    >>> print(lost_answers(said, None).caution)
    Lost answers: 3 of 20 decide nothing: 2 were refused, 1 ended in an error and were left out. By group: b 3.
    """
    if said is None:
        return None
    from fairaudit.tables.evaluations.samples import NOTHING_DECIDED, VERBS

    answers, dropped = said["answers"], said["errors"] == "drop"
    groups = _by_group(said["cells"], law, dropped=dropped)
    contexts = _by_context(said["cells"], law, dropped=dropped)
    listed = [f"{answers[kind]:,} {VERBS[kind]}" for kind in NOTHING_DECIDED if answers[kind]]
    if answers["error"]:
        listed[-1] += " and were left out" if dropped else " and are kept as decisions of their own"
    lost = sum(answers[kind] for kind in NOTHING_DECIDED)
    caution = f"Lost answers: {lost:,} of {sum(answers.values()):,} decide nothing: {', '.join(listed)}." if lost else ""
    if lost and groups:
        caution += f" By group: {_some(groups)}."
    if contexts and _gap(contexts[0]) > _gap(groups):
        caution += f" Most unequal within {contexts[0][0].context}: {_some(contexts[0])}."
    if absent := _missing(said):
        caution = f"{caution} Missing: {absent}.".strip()
    cells = tuple(one for listed in contexts[:SHOW_CONTEXTS] for one in listed)
    heads = (*HEADS, ERRORS.get(said["errors"], "error"), "decide nothing")
    return LostAnswers(tuple(_read(said)), caution, groups, cells, max(0, len(contexts) - SHOW_CONTEXTS), heads)


def lost_text(said: Mapping[str, Any] | None, law: Law | None) -> str:
    """The same in lines for a terminal; empty where nothing is said of a log."""
    from fairaudit.tables.evaluations.samples import NOTHING_DECIDED, VERBS

    found = lost_answers(said, law)
    if found is None:
        return ""
    lines = [
        "How the evaluation log was read",
        *(f"  - {text}" for text in found.read),
        *([f"  - {found.caution}"] if found.caution else []),
    ]
    for group in (*found.groups, *found.cells):
        counts = ", ".join(f"{group.counts[kind]:,} {VERBS[kind]}" for kind in NOTHING_DECIDED if group.counts.get(kind))
        lines.append(f"    {f'{group.context}: ' if group.context else ''}{group.words}{f': {counts}' if counts else ''}")
    if found.more:
        lines.append(f"    and {found.more:,} more {noun(found.more, 'context, not', 'contexts, none of them')} more unequal")
    return "\n".join(lines)


def _about(drawn: str) -> str:
    """Of what an interval speaks, by what was drawn; nothing where nothing was."""
    what = next((about for words, about in ABOUT.items() if drawn.startswith(words)), "")
    return f", so that an interval is about other {what}" if what else ""


def _read(said: Mapping[str, Any]) -> Iterator[str]:
    """How answers were found, and what was drawn."""
    from fairaudit.tables.evaluations.recipes.known import KNOWN

    samples = said["samples"]
    of = f" of {samples['expected']:,}" if samples["expected"] is not None else ""
    asked = f", each question asked {said['epochs']:,} times" if said["epochs"] > 1 else ""
    unit = f" (sampling unit: {', '.join(clip(name, 60) for name in said['unit'])})" if "unit" in said else ""
    drawn = f"{said['drawn']}{unit}{_about(said['drawn'])}"
    yield (
        f"an evaluation log ({clip(said['format'], 40)}) with {samples['read']:,}{of} "
        f"{noun(samples['expected'] or samples['read'], 'sample')}{asked}: {drawn}"
    )
    how = []
    if "recipe" in said:
        known = KNOWN.get(said["recipe"].partition(":")[0])
        none = f"; a sample makes none where {', or where '.join(known.without)}" if known is not None else ""
        how.append(f"rows were made of samples by the recipe {clip(said['recipe'], 40)}{none}")
    if "where" in said:
        conditions = [f"{clip(entry['path'], 60)} is {shown(entry['value'], 60)}" for entry in said["where"]]
        how.append(
            f"only the {samples['counted']:,} {noun(samples['counted'], 'sample counts', 'samples count')} in which "
            f"{' and '.join(conditions)}"
        )
    if "join" in said:
        how.append(f"rows of another file were joined by {clip(said['join'], 60)}")
    if "extract" in said:
        how.append(f"the answer is what the expression {shown(said['extract'], 120)} takes out of it")
    if "options" in said:
        names = ", ".join(shown(option, 40) for option in said["options"][:20])
        how.append(f"an answer in words counts as the one of {names} that it clearly chooses, and otherwise as unreadable")
    yield from how


def _missing(said: Mapping[str, Any]) -> str:
    samples = said["samples"]
    absent = 0 if samples["expected"] is None else samples["expected"] - samples["read"]
    return (
        f"{absent:,} of {samples['expected']:,} {noun(samples['expected'], 'sample')} {noun(absent, 'is', 'are')} not in the log"
        if absent
        else ""
    )


def _by_group(cells: Sequence[Mapping[str, Any]] | None, law: Law | None, *, dropped: bool) -> tuple[OfGroup, ...]:
    """Add up cells by group, those that lost the greatest part first; nothing where cells are not listed, or none lost an answer."""
    from fairaudit.tables.evaluations.samples import NOTHING_DECIDED

    counts: dict[tuple[str, ...], Counter[str]] = {}
    for cell in cells or ():
        counts.setdefault(tuple(cell["group"] or ()), Counter()).update({kind: cell[kind] for kind in NOTHING_DECIDED if kind in cell})
    if not counts:
        return ()
    asked: Counter[tuple[str, ...]] = Counter()
    if law is not None:
        for group, total in zip(law.cell_group.tolist(), law.totals.tolist(), strict=True):
            asked[law.groups[group]] += int(total) // law.scale
        if law.unknown is not None:
            asked[()] += int(law.unknown.weights.sum()) // law.scale
        for label, lost in counts.items() if dropped else ():
            asked[label] += lost["error"]
    return _sorted(counts, asked, "")


def _by_context(cells: Sequence[Mapping[str, Any]] | None, law: Law | None, *, dropped: bool) -> list[tuple[OfGroup, ...]]:
    """The same within each context in which answers are lost, the most unequal first; nothing where there are not several contexts."""
    from fairaudit.tables.evaluations.samples import NOTHING_DECIDED

    if law is None or len(law.contexts) < 2 or law.unknown is not None:
        return []
    asked: dict[tuple[str, ...], Counter[tuple[str, ...]]] = {}
    for context, group, total in zip(law.cell_context.tolist(), law.cell_group.tolist(), law.totals.tolist(), strict=True):
        asked.setdefault(law.contexts[context], Counter())[law.groups[group]] += int(total) // law.scale
    counts: dict[tuple[str, ...], dict[tuple[str, ...], Counter[str]]] = {}
    for cell in cells or ():
        context, label = tuple(cell["context"]), tuple(cell["group"] or ())
        counts.setdefault(context, {})[label] = Counter({kind: cell[kind] for kind in NOTHING_DECIDED if kind in cell})
        asked.setdefault(context, Counter())[label] += cell.get("error", 0) if dropped else 0
    found = [_sorted(own, asked[context], named(dict(zip(law.columns.context, context, strict=True)))) for context, own in counts.items()]
    return sorted(found, key=lambda own: (-_gap(own), -sum(group.lost for group in own), own[0].context))


def _sorted(counts: Mapping[tuple[str, ...], Counter[str]], asked: Mapping[tuple[str, ...], int], context: str) -> tuple[OfGroup, ...]:
    """Groups, those that lost the greatest part first."""
    found = [
        OfGroup(clip(" / ".join(label)) if label else "without a recorded group", context, asked.get(label), dict(counts.get(label, {})))
        for label in {**asked, **counts}
    ]
    return tuple(sorted(found, key=lambda group: (-group.share, -group.lost, group.label)))


def _gap(groups: Sequence[OfGroup]) -> Fraction:
    """How far apart the parts are that groups lost."""
    return groups[0].share - groups[-1].share


def _some(groups: Sequence[OfGroup]) -> str:
    """The groups that lost the greatest parts, and the one that lost the smallest."""
    if len(groups) <= SHOW_GROUPS:
        return ", ".join(group.words for group in groups)
    first = ", ".join(group.words for group in groups[: SHOW_GROUPS - 1])
    return f"{first}, … {groups[-1].words}"
