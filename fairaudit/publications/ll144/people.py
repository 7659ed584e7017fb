"""Who is in which category by a certificate, and who is outside because a category is unknown."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.rationals import decimal_text
from fairaudit.publications.counts import Counts, Decisions, silent_of
from fairaudit.publications.ll144.categories import RACES, SEXES, Attribute, UnmappedError, attributes
from fairaudit.publications.ll144.tables import People, Unknown
from fairaudit.publications.withholding import Place
from fairaudit.words import noun

__all__ = ["Reading", "Scores", "cut_at", "left_out", "people_of", "read_labels", "scores_of"]


AGAIN = (
    "certify again with --missing group, which keeps people without a label as a level of their own, without --unknown, and name the other "
    "labels that say nothing here, with --unknown"
)


@dataclass(frozen=True)
class Reading:
    """What the labels of a certificate mean.

    Attributes
    ----------
    sex, race : Attribute or None
        The columns; None where one is not recorded.
    left_out : int
        People of whom a group label was missing, and whom the certificate left out before it counted decisions.
    notes : tuple of str
        What was left out for another reason, and what is remarkable about the decisions.
    """

    sex: Attribute | None
    race: Attribute | None
    left_out: int = 0
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Scores:
    """A median that cut scores in two: that of so many, of a column."""

    column: str
    median: str
    of: str


def read_labels(
    document: Mapping[str, Any],
    decisions: Decisions,
    *,
    sex: str | None,
    race: str | None,
    map_file: str | Path | None = None,
    unknown: Sequence[str] = (),
    available: bool = False,
) -> Reading:
    """Find out what the labels of the columns of sex and of race mean.

    Parameters
    ----------
    document : mapping
        The certificate.
    decisions : Decisions
        Its counts.
    sex, race : str or None
        Columns.
    map_file : path, optional
        Own labels and the categories that they mean.
    unknown : sequence of str
        Labels that say that a category is unknown. An empty label, and the level of people without a label, always say so.
    available : bool
        Whether each table is to have all people whose category in it is known.

    Raises
    ------
    InputError
        If a column is no group column, a label means nothing that is known, or the certificate does not say what is needed.
    """
    known = decisions.columns
    if sex is None and race is None:
        raise InputError(f"--rule ll144 needs --sex COL and --race COL, group columns of the certificate; {nearest('', known)}")
    for option, name in (("--sex", sex), ("--race", race)):
        if name is not None and name not in known:
            raise InputError(f"{option}: the certificate has no group column {shown(name)}; {nearest(name, known)}")
    if sex == race:
        raise InputError(f"--sex and --race both name {shown(sex)}; a column is one of them")
    preparation = document["subject"].get("preparation", ())
    wanted = {name: known for name, known in ((sex, SEXES), (race, RACES)) if name is not None}
    pairs = silent_of(document, decisions, unknown)
    silent = {name: {"", *unknown, *(label for column, label in pairs if column == name)} for name in wanted}
    made = {attribute.column: attribute for attribute in attributes(wanted, map_file, silent)}
    places = {name: known.index(name) for name in made}
    unmapped = {name: made[name].unmapped(group[place] for group in decisions.groups) for name, place in places.items()}
    if any(unmapped.values()):
        raise UnmappedError(unmapped, wanted)
    absent, notes = left_out(preparation, known)
    if available and len(known) > 1 and (absent or sum(decisions.unknown)):
        people = absent + sum(decisions.unknown)
        raise InputError(f"--unknown-in available: the certificate does not say which category of {people:,} people is unknown; {AGAIN}")
    return Reading(made.get(sex or ""), made.get(race or ""), absent, (*notes, *_remarks(preparation, decisions)))


def _remarks(preparation: Sequence[Mapping[str, Any]], decisions: Decisions) -> Iterator[str]:
    """What was done to the decisions before they were counted, and is not what the rule has in mind."""
    for entry in preparation:
        if entry["step"] == "level" and entry["column"] not in (*decisions.columns, *decisions.contexts):
            people = f"{int(entry['decisions']):,} {noun(int(entry['decisions']), 'person', 'people')}"
            yield f"Of {people} no decision is recorded; they count as people with the decision {shown(entry['label'])}."


def left_out(preparation: Sequence[Mapping[str, Any]], groups: Collection[str]) -> tuple[int, tuple[str, ...]]:
    """How many people were left out because a group label is missing; and what else was left out, in words.

    Raises
    ------
    InputError
        If the certificate does not say how many they are.

    Examples
    --------
    >>> left_out([{"step": "left out", "reason": "missing label", "decisions": "3", "of": "9", "columns": {"sex": "3"}}], ["sex"])
    (3, ())
    """
    people, notes = 0, []
    for entry in preparation:
        if entry["step"] != "left out":
            continue
        if "decisions" not in entry:
            notes.append(
                f"{int(entry['lines']):,} {noun(int(entry['lines']), 'line of the log was', 'lines of the log were')} "
                f"left out before anything was counted ({entry['reason']})."
            )
            continue
        without = _without_category(entry, groups)
        others = Fraction(entry["decisions"]) - without
        if others:
            names = ", ".join(shown(name) for name in entry["columns"] if name not in groups)
            amount = f"{others.numerator:,}" if others.denominator == 1 else others
            notes.append(
                f"{amount} {noun(amount, 'decision')} without a label in {names} {noun(amount, 'was', 'were')} left out "
                f"before anything was counted; nothing here is about them."
            )
        people += without
    return people, tuple(notes)


def _without_category(entry: Mapping[str, Any], groups: Collection[str]) -> int:
    """How many of the decisions that were left out lack a group label, where the numbers of each column say it."""
    total = Fraction(entry["decisions"])
    missing = {name: Fraction(amount) for name, amount in entry["columns"].items()}
    of_groups = [amount for name, amount in missing.items() if name in groups]
    of_others = [amount for name, amount in missing.items() if name not in groups]
    least, most = max([Fraction(0), *of_groups, total - sum(of_others)]), min(total, Fraction(sum(of_groups)))
    if least < most:
        raise InputError(
            f"the certificate left out {total} {noun(total, 'decision')} without a label in "
            f"{', '.join(map(shown, missing))}, and does not say how many "
            f"of them have no category: {least} to {most}; {AGAIN}"
        )
    if least.denominator > 1:
        raise InputError(f"the certificate left out {least} {noun(least, 'decision')} without a category, which is no number of people")
    return least.numerator


def people_of(reading: Reading, counts: Counts) -> tuple[People, Unknown]:
    """Add up the people of each sex and race, and those of whom a category is unknown, it is not recorded which.

    Raises
    ------
    InputError
        If a label means nothing that is known.
    """
    found: dict[Place, tuple[int, int]] = {}
    places = [(attribute, counts.columns.index(attribute.column) if attribute else 0) for attribute in (reading.sex, reading.race)]
    for group, n, s in zip(counts.groups, counts.applicants, counts.selected, strict=True):
        sex, race = (attribute.category(group[place]) if attribute else None for attribute, place in places)
        before = found.get((sex, race), (0, 0))
        found[sex, race] = before[0] + s, before[1] + n
    apart, selected = counts.unknown
    return found, Unknown(selected, apart - selected, reading.left_out)


def cut_at(document: Mapping[str, Any]) -> Iterator[str]:
    """Say that scores were cut at a number, where they were.

    Examples
    --------
    >>> next(cut_at({"subject": {"preparation": [{"step": "above", "column": "points", "limit": "129/2"}]}}))
    "Scores were cut at 64.5. The rule's scoring rate is of scores above the median of all who were scored."
    """
    for entry in document["subject"].get("preparation", ()):
        if entry["step"] == "above":
            limit = decimal_text(Fraction(entry["limit"]))
            yield f"Scores were cut at {limit}. The rule's scoring rate is of scores above the median of all who were scored."


def scores_of(document: Mapping[str, Any]) -> Scores | None:
    """The median at which scores were cut, where the decisions are that.

    Examples
    --------
    >>> scores_of({"subject": {"preparation": [{"step": "above median", "column": "points", "median": "129/2", "of": "168"}]}})
    Scores(column='points', median='64.5', of='168')
    """
    for entry in document["subject"].get("preparation", ()):
        if entry["step"] == "above median":
            return Scores(entry["column"], decimal_text(Fraction(entry["median"])), entry["of"])
    return None
