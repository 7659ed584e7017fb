"""What reports say of decisions whose group was not recorded: between which ends a ratio lies, whoever they are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import exp
from typing import Any

from fairaudit.audits.sentences import pair_text
from fairaudit.certificates.reader import number
from fairaudit.measures.ratios import Witness
from fairaudit.reports.words import Value, named
from fairaudit.theorems.registry import without_objection
from fairaudit.words import WHOEVER, approximate, noun

__all__ = ["UnknownRange", "as_ratio", "unknown_ranges"]


SHOW_ASSIGNED = 8  # contexts whose assignment is listed; the certificate has all


@dataclass(frozen=True)
class UnknownRange:
    """Between which ends a ratio lies, whoever the decisions of unknown group are.

    Attributes
    ----------
    quantity : {"local", "global"}
        Of which ratio.
    amounts : tuple of str
        How many decisions have no recorded group, and of how many.
    least, greatest : Value
        The ends; the greatest ratio is attained.
    reached : Value or None
        The smallest ratio that was found for some assignment.
    labelled : Value
        The ratio of the decisions that have a group.
    limits : tuple of Value
        The targets on this ratio, as ratios.
    tips : tuple of str
        What it takes to change the verdict of the decisions that have a group.
    completions : tuple of (str, tuple of str)
        Who the unknown would have to be for the greatest ratio, and for the smallest one that was found.
    """

    quantity: str
    amounts: tuple[str, str]
    least: Value
    greatest: Value
    reached: Value | None
    labelled: Value
    limits: tuple[Value, ...]
    tips: tuple[str, ...]
    completions: tuple[tuple[str, tuple[str, ...]], ...]

    @property
    def opening(self) -> str:
        """How many decisions have no recorded group."""
        return f"Of {self.amounts[1]} decisions, {self.amounts[0]} have no recorded group"

    @property
    def ends(self) -> str:
        """The range; which ratio is possible where the lower end may not be."""
        sharp = self.reached is None or self.reached.value == self.least.value
        near = "" if sharp or self.reached is None else f" ({self.reached.decimal} is possible)"
        return f"between {self.least.decimal}{near} and {self.greatest.decimal}"

    @property
    def sentence(self) -> str:
        """All of it in words."""
        name = "the ratio within contexts" if self.quantity == "local" else "the ratio over all"
        return f"{self.opening}; whoever they are, {name} is {self.ends}; among those with a group it is {self.labelled.decimal}"


def unknown_ranges(document: Mapping[str, Any], groups: Mapping[tuple[str, ...] | None, Sequence[Sequence[str]]]) -> list[UnknownRange]:
    """Read the ranges of a certificate, or of what it is made of.

    Parameters
    ----------
    document : mapping
        The certificate: ``subject``, ``metrics``, ``claims`` and ``targets``.
    groups : mapping
        For each context, and for all together (None), the groups that are compared there; empty where that is not known.
    """
    ends = {
        (claim["quantity"].removesuffix("_ratio"), claim["relation"]): claim
        for claim in document["claims"]
        if without_objection(claim["scope"])[1] == WHOEVER
    }
    entry = next((step for step in document["subject"].get("preparation", ()) if step["step"] == "unknown"), None)
    found = []
    for quantity in ("local", "global"):
        most, least = ends.get((quantity, "<=")), ends.get((quantity, ">="))
        metric = document["metrics"][quantity]
        if entry is None or most is None or least is None or metric is None:
            continue
        reached = least["evidence"]["reached"]
        own = [target for target in document["targets"] if target["quantity"] == quantity]
        found.append(
            UnknownRange(
                quantity,
                (f"{int(entry['decisions']):,}", f"{int(entry['of']):,}"),
                Value(number(least["value"]), "down"),
                Value(number(most["value"]), "up"),
                None if reached is None else Value(number(reached["ratio"]), "up"),
                Value(number(metric["ratio"])),
                tuple(as_ratio(target) for target in own),
                tuple(_tips(target, document["subject"]["columns"]) for target in own if "tips" in target),
                tuple(_completions(most, least, document["subject"]["columns"], groups)),
            )
        )
    return found


def as_ratio(target: Mapping[str, Any]) -> Value:
    """The limit of a target as a ratio, near it where it is one on a logarithm."""
    limit = number(target["limit"])
    return Value(limit) if target["unit"] == "ratio" else Value(exp(min(700.0, float(limit))), rational=False)


def _place(entry: Mapping[str, Any], columns: Mapping[str, Any]) -> Witness:
    """The pair of an entry, as witnesses have it."""
    context = dict(zip(columns["context"], entry["context"], strict=True)) if "context" in entry else None
    higher, lower = (dict(zip(columns["group"], entry[key], strict=True)) for key in ("higher", "lower"))
    return Witness(context, higher, lower, (Fraction(1), Fraction(1)))


def _tips(target: Mapping[str, Any], columns: Mapping[str, Any]) -> str:
    """For how many unknown decisions the verdict of the others stands."""
    tips = target["tips"]
    pair, rows = _place(tips["pair"], columns), int(tips["rows"])
    said = "meet the target" if tips["labelled"] == "within" else "exceed it"
    changes = "can change that" if tips["labelled"] == "within" else "might change that"
    if rows == 0:
        return f"those with a group {said}, and a single unknown one assigned to {pair_text(pair, named)} {changes}"
    still = f"any {rows:,} of the unknown ones leave that as it is"
    return f"those with a group {said}, and {still}; one more {changes} ({pair_text(pair, named)})"


def _completions(
    most: Mapping[str, Any],
    least: Mapping[str, Any],
    columns: Mapping[str, Any],
    groups: Mapping[tuple[str, ...] | None, Sequence[Sequence[str]]],
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Who the unknown would have to be at both ends."""
    top = most["evidence"]["completion"]
    pair = _place(top, columns)
    where = f"in {named(pair.context)}: " if pair.context else ""
    high, low = (int(rows) for rows in top["received"])
    line = f"{where}{named(pair.higher)} gets the {high:,} worth most, {named(pair.lower)} the {low:,} worth least"
    yield f"for the greatest ratio, {approximate(number(most['value']))}", (line,)
    reached = least["evidence"]["reached"]
    if reached is None:
        return
    lines = []
    for entry in reached["assigned"][:SHOW_ASSIGNED]:
        context = tuple(entry["context"]) if "context" in entry else None
        names = groups.get(context, ())
        at = f"in {named(dict(zip(columns['context'], context, strict=True)))}: " if context else ""
        given = [
            f"{int(rows):,} worth {approximate(number(value))} to {named(dict(zip(columns['group'], name, strict=True)))}"
            for value, row in zip(entry["values"], entry["counts"], strict=True)
            for rows, name in zip(row, names, strict=False)
            if rows != "0"
        ]
        lines.append(at + (", ".join(given) or "none to the groups"))
    if more := len(reached["assigned"]) - SHOW_ASSIGNED:
        lines += [f"and {more:,} more {noun(more, 'context')}, in the certificate"] if more > 0 else []
    yield f"for a ratio of {approximate(number(reached['ratio']))}", tuple(lines or ["any, as long as it keeps the limits"])
