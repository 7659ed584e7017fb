"""What a report says of decisions of unknown meaning: how many there are, as what they count, and the ratios whatever they meant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.audits.undecided import Undecided
from fairaudit.certificates.reader import Subject, number
from fairaudit.exact.extended import Extended
from fairaudit.reports.overview_parts import how_many
from fairaudit.reports.words import Value, clip, named, scope
from fairaudit.theorems.bound import THIS_LAW
from fairaudit.theorems.registry import without_objection
from fairaudit.words import WHATEVER

__all__ = ["MeantRange", "least_meant", "undecided_lines", "undecided_of", "undecided_ranges", "undecided_said"]

NAMES = {"local": "the ratio within contexts", "global": "the ratio over all"}

SHOWN = 4
"""Labels that a line names."""


@dataclass(frozen=True)
class MeantRange:
    """Between which ends a ratio lies, whatever the undecided decisions meant.

    Attributes
    ----------
    quantity : str
        ``"local"`` or ``"global"``.
    about : str
        Of what: the table, or the population at a confidence.
    of_table : bool
        Whether it is of the table.
    face : Value or None
        The ratio at face value, of the table.
    least, greatest : Value
        The ends.
    within : str
        The context, escaped, in which groups may be as unequal as the greatest; empty where there is none, or it is of the population.
    """

    quantity: str
    about: str
    of_table: bool
    face: Value | None
    least: Value
    greatest: Value
    within: str = ""

    @property
    def name(self) -> str:
        """Which ratio."""
        return NAMES[self.quantity]

    @property
    def ends(self) -> str:
        """Both ends."""
        if self.least.value == self.greatest.value:
            return f"{self.least.decimal}"
        return f"from {self.least.decimal} to {self.greatest.decimal}"

    @property
    def of(self) -> str:
        """Of what, and within which context it is the greatest."""
        return f"{self.about}; the greatest within {self.within}" if self.within else self.about


def undecided_of(found: Mapping[str, Any]) -> Undecided | None:
    """The decisions that a document says are undecided."""
    stated = found["subject"].get("undecided")
    return None if stated is None else Undecided(tuple(stated["decisions"]), Fraction(stated["least"]), Fraction(stated["most"]))


def undecided_ranges(found: Mapping[str, Any]) -> list[MeantRange]:
    """The ranges of a document: of the table, then of the population."""
    ends: dict[tuple[str, str], dict[str, Any]] = {}
    within: dict[tuple[str, str], str] = {}
    columns = found["subject"]["columns"]["context"]
    for claim in found["claims"]:
        about, objection = without_objection(claim["scope"])
        if objection == WHATEVER:
            key = about, claim["quantity"].removesuffix("_ratio")
            ends.setdefault(key, {})[claim["relation"]] = number(claim["value"])
            pair = claim["evidence"].get("pair")
            if claim["relation"] == "<=" and columns and pair is not None and pair["context"] is not None:
                within[key] = named(dict(zip(columns, pair["context"], strict=True)))
    return [
        MeantRange(
            quantity,
            "the table" if about == THIS_LAW else scope(about),
            about == THIS_LAW,
            Value(number(found["metrics"][quantity]["ratio"])) if found["metrics"][quantity] else None,
            Value(both[">="], "down"),
            Value(both["<="], "up"),
            within.get((about, quantity), ""),
        )
        for (about, quantity), both in ends.items()
        if len(both) == 2
    ]


def least_meant(found: Mapping[str, Any]) -> dict[str, Extended] | None:
    """The least ratios of the table, whatever the undecided decisions meant; None where none is undecided."""
    if "undecided" not in found["subject"]:
        return None
    return {one.quantity: one.least.value for one in undecided_ranges(found) if one.of_table}


def undecided_said(found: Mapping[str, Any], subject: Subject | None) -> str:
    """Which decisions are undecided, how many they are, what they count as, and what they may have been worth; empty if there are none."""
    stated = found["subject"].get("undecided")
    if stated is None:
        return ""
    labels = [clip(label, 40) for label in stated["decisions"][:SHOWN]]
    more = len(stated["decisions"]) - SHOWN
    listed = ", ".join(labels) + (f" and {more} more" if more > 0 else "")
    least, most = (Value(number(stated[key])).decimal for key in ("least", "most"))
    return f"Undecided ({listed}): {_counted(stated['decisions'], subject)}; each may have been worth something from {least} to {most}."


def undecided_lines(found: Mapping[str, Any], subject: Subject | None) -> list[str]:
    """What the first screen says: how many there are, and the ratios of the table whatever they meant."""
    said = undecided_said(found, subject)
    if not said:
        return []
    ranges = [one for one in undecided_ranges(found) if one.of_table]
    if not found["subject"]["columns"]["context"]:
        return [said, *(f"Whatever they meant, the ratio is {one.ends}, in the table." for one in ranges[:1])]
    listed = " and ".join(f"{one.name} is {one.ends}" for one in ranges)
    return [said, *([f"Whatever they meant, {listed}, in the table."] if listed else [])]


def _counted(decisions: list[str], subject: Subject | None) -> str:
    """How many decisions are undecided, and what figures count them as."""
    if subject is None:
        return "decisions of unknown meaning"
    law, utility = subject.law, subject.utility
    at = [law.decisions.index(label) for label in decisions if label in law.decisions]
    worth = sorted({Fraction(int(utility.values[i]), utility.scale) for i in at}) if utility.by_decision else []
    face = f"counted as worth {' or '.join(Value(value).decimal for value in worth)}" if worth else "counted with the utility that is given"
    if law.kind != "counts" or subject.deployment is not None:
        return face
    lost = Fraction(sum(sum(row) for row in law.weights[:, at].tolist())) / law.scale
    return f"{how_many(lost)} of {how_many(Fraction(sum(law.totals.tolist())) / law.scale)} decisions, {face}"
