"""How many people of each group applied, and how many were selected, as whole numbers from a certificate that was checked."""

from __future__ import annotations

import io
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

from fairaudit.attestations.verification import read_attestation
from fairaudit.certificates.reader import FORMAT
from fairaudit.errors import FalseCertificate, InputError, TableNeeded, nearest, shown
from fairaudit.reports.provenance import Provenance, provenance_of
from fairaudit.tables.columns import MISSING_LABEL
from fairaudit.tables.values import Label
from fairaudit.verified.verification import checked, opened
from fairaudit.words import noun

__all__ = [
    "Counts",
    "Decisions",
    "Source",
    "check_unknown",
    "decisions_of",
    "facts_of",
    "favourable_of",
    "read_source",
    "silent_of",
    "summed_of",
    "worth_one",
]

WHOLE = re.compile(r"[0-9]{1,18}")

MOST = 10**11
"""People of a table: so many still take seconds to test, and no table counts more."""


@dataclass(frozen=True)
class Source:
    """A certificate that was checked and is true.

    Attributes
    ----------
    document : mapping
        Its JSON document.
    raw : bytes
        Its file.
    table : bytes or None
        The file of its table, where one was given.
    said : str
        Who checked it, and what was found.
    attestation : bytes or None
        The file of its attestation, where one was given; what can be checked of it is true.
    """

    document: Mapping[str, Any]
    raw: bytes
    table: bytes | None
    said: str
    attestation: bytes | None = None

    @cached_property
    def provenance(self) -> Provenance | None:
        """What the attestation says; None where there is none."""
        if self.attestation is None:
            return None
        return provenance_of(self.attestation, self.raw, self.document["subject"]["table"]["sha256"], compared=True)

    @property
    def sha256(self) -> str:
        """Digest of the file."""
        return sha256(self.raw).hexdigest()

    @property
    def lines(self) -> Iterator[Mapping[str, Any]]:
        """The lines of the table, the header first."""
        about = self.document["subject"]["table"]
        if "header" in about:
            yield about["header"]
            yield from about["rows"]
        elif self.table is not None:
            yield from map(json.loads, io.BytesIO(self.table))


def read_source(
    certificate: str | os.PathLike[str],
    table: str | os.PathLike[str] | None = None,
    attestation: str | os.PathLike[str] | None = None,
) -> Source:
    """Read a certificate, the file of its table and its attestation once, and check them; a signature is not looked at.

    Raises
    ------
    FalseCertificate
        If a statement is false.
    TableNeeded
        If the table is in another file, and none was given.
    InputError
        If it is no certificate of counts, or leaves open what decisions meant, or a file cannot be read.
    """
    found = opened(certificate, pages=False)
    if found.form != FORMAT:
        raise InputError(f"{found.name} is of the format {shown(found.form)}; what is published is made from one of the format {FORMAT}")
    held = None if table is None else _bytes(Path(table))
    stated = None if attestation is None else read_attestation(attestation)
    try:
        said = checked(replace(found, lines=None if held is None else io.BytesIO(held)), stated)
    except FalseCertificate as error:
        raise FalseCertificate(f"{error}; nothing was published") from None
    if not said:
        raise TableNeeded(f"{found.name} does not hold its table; give its file with --table")
    kind = found.document["subject"]["kind"]
    if kind != "counts":
        about = {"policy": "a policy behind filters"}.get(kind, kind)
        raise InputError(f"{found.name} is about {about} and counts nobody; a publication needs a certificate of counts")
    if open_ := found.document["subject"].get("undecided", {}).get("decisions"):
        first = f"{shown(open_[0])}{f' and {len(open_) - 1} more' if open_[1:] else ''}"
        worth = ",".join(f"{label}=0" for label in open_[:5])
        raise InputError(
            f"{found.name} leaves open what the decision {first} meant, and a published rate is one number, for which each decision counts "
            "as selected or not; fairaudit report shows the ranges, or certify (without --undecided) with a --utility that says what each "
            f"is worth, such as {shown(f'yes=1,{worth}', 200)}"
        )
    return Source(found.document, found.raw, held, said, stated)


def _bytes(path: Path) -> bytes:
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path} is a directory, a device or a pipe; name a file")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{str(path)!r} cannot be read: {getattr(error, 'strerror', None) or error}") from None


@dataclass(frozen=True)
class Decisions:
    """How often each decision fell on each group, over all contexts.

    Attributes
    ----------
    columns : tuple of str
        The columns of the groups.
    groups : tuple of Label
        The groups, in the order of the certificate; some may have no people.
    labels : tuple of str
        The decisions.
    counts : tuple of tuple of int
        For each group, how often each decision fell.
    unknown : tuple of int
        The same for people whose group is unknown.
    contexts : tuple of str
        The columns that were summed over.
    silent : frozenset of (str, str)
        Columns, and labels of them that say that the group is unknown.
    """

    columns: tuple[str, ...]
    groups: tuple[Label, ...]
    labels: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]
    unknown: tuple[int, ...]
    contexts: tuple[str, ...] = ()
    silent: frozenset[tuple[str, str]] = frozenset()

    def selected(self, favourable: Sequence[str]) -> Counts:
        """Count applicants, and those on whom one of these decisions fell."""
        places = [self.labels.index(label) for label in favourable]
        taken = tuple(sum(row[i] for i in places) for row in self.counts)
        unknown = sum(self.unknown), sum(self.unknown[i] for i in places)
        silent_in = self.columns if unknown[0] else ()
        return Counts(self.columns, self.groups, tuple(map(sum, self.counts)), taken, unknown, silent=self.silent, unknown_in=silent_in)


@dataclass(frozen=True)
class Counts:
    """Applicants and selected of each group.

    Attributes
    ----------
    columns : tuple of str
        The columns of the groups.
    groups : tuple of Label
        The groups; some may have no people.
    applicants, selected : tuple of int
        Of each group.
    unknown : (int, int)
        Applicants and selected whose group is unknown, who are in none of the groups.
    withheld : tuple of Label
        Further groups of which nothing may be said.
    why : str
        How many these are, and why.
    silent : frozenset of (str, str)
        Columns, and labels of them that say that the group is unknown.
    unknown_in : tuple of str
        Columns of which at least one is unknown of everybody whose group is.

    Examples
    --------
    >>> counts = Counts(("sex", "race"), (("f", "a"), ("f", "b"), ("m", "a")), (40, 10, 60), (4, 5, 9))
    >>> counts.by("sex")
    Counts(columns=('sex',), groups=(('f',), ('m',)), applicants=(50, 60), selected=(9, 9), unknown=(0, 0), withheld=(), why='')
    """

    columns: tuple[str, ...]
    groups: tuple[Label, ...]
    applicants: tuple[int, ...]
    selected: tuple[int, ...]
    unknown: tuple[int, int] = (0, 0)
    withheld: tuple[Label, ...] = ()
    why: str = ""
    silent: frozenset[tuple[str, str]] = field(default=frozenset(), repr=False)
    unknown_in: tuple[str, ...] = field(default=(), repr=False)

    def by(self, *columns: str) -> Counts:
        """The same people by some of the columns."""
        places = [self.columns.index(name) for name in columns]
        sums: dict[Label, list[int]] = {}
        for group, applied, taken in zip(self.groups, self.applicants, self.selected, strict=True):
            entry = sums.setdefault(tuple(group[i] for i in places), [0, 0])
            entry[0] += applied
            entry[1] += taken
        applicants, selected = zip(*sums.values(), strict=True)
        return Counts(columns, tuple(sums), applicants, selected, self.unknown, silent=self.silent, unknown_in=self.unknown_in)

    def known(self) -> Counts:
        """The same without the groups of which a label says that it is unknown: their people are added to those of unknown group.

        Examples
        --------
        >>> counts = Counts(("sex",), (("f",), ("(missing)",)), (40, 10), (4, 5), silent=frozenset({("sex", "(missing)")}))
        >>> counts.known()
        Counts(columns=('sex',), groups=(('f',),), applicants=(40,), selected=(4,), unknown=(10, 5), withheld=(), why='')
        """
        known = [self.silent.isdisjoint(zip(self.columns, group, strict=True)) for group in self.groups]
        if all(known):
            return self
        applicants, selected = (tuple(n for n, keep in zip(of, known, strict=True) if keep) for of in (self.applicants, self.selected))
        apart = sum(self.applicants) - sum(applicants), sum(self.selected) - sum(selected)
        return replace(
            self,
            groups=tuple(group for group, keep in zip(self.groups, known, strict=True) if keep),
            applicants=applicants,
            selected=selected,
            unknown=(self.unknown[0] + apart[0], self.unknown[1] + apart[1]),
            unknown_in=self.unknown_in or self.columns,
        )


def decisions_of(source: Source) -> Decisions:
    """Sum the table of a certificate over its contexts.

    Raises
    ------
    InputError
        If a count is no whole number of people.
    """
    lines = source.lines
    header = next(lines)
    labels = header["decisions"]
    counts = [[0] * len(labels) for _ in header["groups"]]
    unknown = [0] * len(labels)
    for row in lines:
        into, weights = (unknown, row["unknown"]) if "unknown" in row else (counts[row["group"]], row["weights"])
        for i, text in enumerate(weights):
            if not WHOLE.fullmatch(text):
                raise InputError(
                    f"the table has {shown(text)} decisions {shown(labels[i])}, which is no number of people (whole, of at most 18 digits)"
                )
            into[i] += int(text)
    people = sum(map(sum, counts)) + sum(unknown)
    if people > MOST:
        raise InputError(f"the table counts {people:,} decisions; at most {MOST:,} are published as those of people")
    return Decisions(
        tuple(header["columns"]["group"]),
        tuple(map(tuple, header["groups"])),
        tuple(labels),
        tuple(map(tuple, counts)),
        tuple(unknown),
        tuple(header["columns"]["context"]),
    )


def silent_of(document: Mapping[str, Any], decisions: Decisions, unknown: Sequence[str] = ()) -> frozenset[tuple[str, str]]:
    """Columns, and labels of them that say that the group is unknown: the level of those without a label, an empty one, those given.

    A certificate does not say of a level in which nobody is that it is one; its label does.
    """
    people: dict[tuple[str, str], int] = {}
    for group, counts in zip(decisions.groups, decisions.counts, strict=True):
        for pair in zip(decisions.columns, group, strict=True):
            people[pair] = people.get(pair, 0) + sum(counts)
    preparation = document["subject"].get("preparation", ())
    levels = {(entry["column"], entry["label"]) for entry in preparation if entry["step"] == "level"}
    levelled = {column for column, _ in levels}
    empty = {pair for pair, n in people.items() if pair[1] == MISSING_LABEL and not n and pair[0] not in levelled}
    return frozenset(pair for pair in people if pair in levels | empty or pair[1] in {"", *unknown})


def check_unknown(decisions: Decisions, unknown: Sequence[str]) -> None:
    """Refuse labels that would say that a group is unknown and that no group has.

    Raises
    ------
    InputError
        If there is one.
    """
    labels = sorted({label for group in decisions.groups for label in group})
    for label in unknown:
        if label not in labels:
            raise InputError(f"--unknown: no group has the label {shown(label)}; {nearest(label, labels)}")


def favourable_of(source: Source, given: Sequence[str] = ()) -> tuple[str, ...]:
    """Which decisions count as selected: those that are given, else those worth 1 where every decision is worth 0 or 1 to everybody.

    Raises
    ------
    InputError
        If one is not known, or none is given and the utility does not say it.
    """
    header = next(source.lines)
    labels = header["decisions"]
    for label in given:
        if label not in labels:
            raise InputError(f"--favourable: there is no decision {shown(label)}; {nearest(label, labels)}")
        if given.count(label) > 1:
            raise InputError(f"--favourable names {shown(label)} twice")
    if given:
        return tuple(given)
    found = worth_one(header)
    if source.document["subject"]["utility"].get("burden"):
        why = "the utility of the certificate counts a burden"
    elif not found:
        why = "the utility of the certificate does not say it by 0 and 1"
    else:
        return found
    raise InputError(f"which decisions count as selected? {why}; name them with --favourable ({nearest('', labels)})")


def worth_one(header: Mapping[str, Any]) -> tuple[str, ...]:
    """The decisions worth 1, by the header of a table; none where not every decision is worth 0 or 1 to everybody.

    Examples
    --------
    >>> worth_one({"decisions": ["no", "yes"], "utility": ["0", "1"]}), worth_one({"decisions": ["no", "yes"], "utility": ["0", "2"]})
    (('yes',), ())
    """
    worth = header["utility"] or ()
    return tuple(label for label, value in zip(header["decisions"], worth, strict=False) if value == "1") if {*worth} <= {"0", "1"} else ()


def facts_of(decisions: Decisions, counts: Counts, favourable: Sequence[str], *, totals: bool = True) -> tuple[tuple[str, str], ...]:
    """Who is counted, by what, and what counts as selected, for the head of a page: with how many people there are, or without."""
    known = counts.known()
    people, taken = sum(known.applicants), sum(known.selected)
    unknown, unknown_taken = known.unknown
    what = "group" if len(counts.columns) == 1 else " and ".join(counts.columns)
    found = [
        ("Selected", f"{', '.join(map(shown, favourable))} (of the decisions {', '.join(map(shown, decisions.labels))})"),
        *([("People", f"{people:,} of known {what}, {taken:,} of them selected")] if totals else []),
        ("Groups by", ", ".join(counts.columns)),
    ]
    if unknown and totals:
        some = f"{unknown:,} more {noun(unknown, 'person', 'people')}, {unknown_taken:,} of them selected"
        if len(counts.columns) == 1:
            some += ", who are in no group"
        else:
            some += f", of whom {' or '.join(counts.columns)} is unknown"
            some += "; a table by some of these has all of whom those are known" if not counts.unknown[0] else ""
            some += "; they are in no table" if unknown == counts.unknown[0] else ""
        found.append(("Group unknown", some))
    silent = sorted({label for _, label in counts.silent})
    if silent:
        found.append(("Labels that say that a group is unknown", ", ".join(map(shown, silent))))
    if not totals:
        found.append(("Group unknown", "whoever's group is unknown, if anybody's, is in no group here, and how many they are is not said"))
    return (*found, *summed_of(decisions))


def summed_of(decisions: Decisions) -> list[tuple[str, str]]:
    """What the head of a page says of contexts; nothing where there are none."""
    names = ", ".join(decisions.contexts)
    return [("Contexts", f"summed over {names}, whose differences these figures do not show")] if names else []
