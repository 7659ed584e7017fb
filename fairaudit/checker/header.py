"""The header of a table: columns, population, decisions, groups, contexts, utility and filters; and what a cell is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from .json_values import (
    Labels,
    check_distinct,
    read_choice,
    read_digest,
    read_hexadecimal,
    read_label_lists,
    read_object,
    read_string,
    read_strings,
)
from .laws import Law
from .rationals import Rational, read_signed
from .text import malformed

TABLE_FORMAT = "fairaudit-table/1"
OF_LOG = ("preparation", "evaluation")  # what a subject says of the log; the header names the digest of each


@dataclass(frozen=True)
class Columns:
    """The names of the columns of a table."""

    decision: str
    group: tuple[str, ...]
    context: tuple[str, ...]
    truth: str | None = None


@dataclass(frozen=True)
class Positive:
    """Which decisions and which true label count as positive, as the certificate states it."""

    decision: tuple[str, ...]
    truth: str


@dataclass(frozen=True)
class Subject:
    """What the certificate and the header of the table have to agree on."""

    kind: str
    columns: Columns
    population: str


@dataclass(frozen=True)
class Header:
    """The first line of a table."""

    subject: Subject
    decisions: tuple[str, ...]
    groups: tuple[Labels, ...]
    contexts: tuple[Labels, ...]
    utility: tuple[Rational, ...] | None
    truths: tuple[str, ...] | None = None  # the true labels
    profiles: Mapping[str, str] = field(default_factory=dict)  # by quantity the digest of what units got in all groups
    unknown: bool = False  # whether there are lines about decisions of unknown group
    log: Mapping[str, str] = field(default_factory=dict)  # digests of what the subject says of the log


class Cell(NamedTuple):
    """What is known of (x,a): P(u|x,a) is ``law``, M(x,a) is ``mass`` and E(x,a) is ``expectation``."""

    context: int
    group: int
    law: Law
    mass: Rational
    expectation: Rational
    utility: Sequence[Rational | None]


class UnknownRow(NamedTuple):
    """The decisions of unknown group in a context: how many there are of each, and what these are worth."""

    context: int
    counts: Sequence[Rational]
    utility: Sequence[Rational | None]

    @property
    def by_value(self) -> list[tuple[Rational, int]]:
        """What those that occur are worth, and how many there are."""
        return [(value, count[0]) for value, count in zip(self.utility, self.counts, strict=True) if value is not None and count[0]]


def _read_columns(value: object, where: str) -> Columns:
    members = read_object(value, where, ("decision", "group", "context"), optional=("truth",))
    columns = Columns(
        read_string(members["decision"], f"{where}.decision"),
        read_strings(members["group"], f"{where}.group"),
        read_strings(members["context"], f"{where}.context"),
        read_string(members["truth"], f"{where}.truth") if "truth" in members else None,
    )
    names = (columns.decision, *columns.group, *columns.context, *([] if columns.truth is None else [columns.truth]))
    if not columns.group:
        raise malformed(f"{where}.group", "must name at least one column")
    if len(set(names)) != len(names):
        raise malformed(where, "names a column twice")
    return columns


def read_subject(members: Mapping[str, object], where: str) -> Subject:
    """Read kind, columns and population, which stand in the certificate and in the header of the table."""
    kind = read_choice(members["kind"], f"{where}.kind", ("counts", "probabilities", "policy"))
    populations = ("counts",) if kind == "counts" else ("weights", "equal")
    population = read_choice(members["population"], f"{where}.population", populations)
    columns = _read_columns(members["columns"], f"{where}.columns")
    if kind != "counts" and columns.truth is not None:
        raise malformed(f"{where}.columns.truth", "must not be there: only counts have true labels")
    return Subject(kind, columns, population)


def has_truth(value: object) -> bool:
    """Whether an object has a column of true labels."""
    columns = value.get("columns") if isinstance(value, dict) else None
    return isinstance(columns, dict) and "truth" in columns


def read_positive(value: object, where: str) -> Positive:
    """Read which decisions and which true label count as positive."""
    members = read_object(value, where, ("decision", "truth"))
    decisions = read_strings(members["decision"], f"{where}.decision")
    check_distinct(decisions, f"{where}.decision")
    return Positive(decisions, read_string(members["truth"], f"{where}.truth"))


def read_header(value: object, where: str) -> Header:
    """Read the first line of a table; the filters of a policy are left to ``read_filters``."""
    keys = ["format", "kind", "columns", "population", "decisions", "groups", "contexts", "utility"]
    keys += ["filters"] * is_about_policy(value) + ["truths"] * has_truth(value)
    members = read_object(value, where, keys, optional=("salt", "profiles", "unknown", *OF_LOG))
    read_choice(members["format"], f"{where}.format", (TABLE_FORMAT,))
    if "salt" in members:
        read_hexadecimal(members["salt"], f"{where}.salt", "0123456789abcdefABCDEF", 32)
    subject = read_subject(members, where)
    decisions = read_strings(members["decisions"], f"{where}.decisions")
    check_distinct(decisions, f"{where}.decisions")
    utility = members["utility"]
    header = Header(
        subject,
        decisions,
        read_label_lists(members["groups"], f"{where}.groups", len(subject.columns.group)),
        read_label_lists(members["contexts"], f"{where}.contexts", len(subject.columns.context)),
        None if utility is None else tuple(read_signed(utility, f"{where}.utility", len(decisions))),
    )
    if "truths" in members:
        header = replace(header, truths=read_strings(members["truths"], f"{where}.truths"))
        check_distinct(header.truths or (), f"{where}.truths")
    if "unknown" in members:
        if subject.kind != "counts" or header.truths is not None or members["unknown"] is not True:
            raise malformed(f"{where}.unknown", "must be true where it is stated, and only of counts without true labels")
        header = replace(header, unknown=True)
    if "profiles" in members:
        digests = read_object(members["profiles"], f"{where}.profiles", (), optional=("local", "global"))
        header = replace(header, profiles={name: read_digest(value, f"{where}.profiles.{name}") for name, value in digests.items()})
    return replace(header, log=read_log_digests(members, where))


def read_log_digests(members: Mapping[str, object], where: str) -> dict[str, str]:
    """Read from the header of a table the digests of what the subject says of the log."""
    return {key: read_digest(members[key], f"{where}.{key}") for key in OF_LOG if key in members}


def is_about_policy(value: object) -> bool:
    """Whether an object says that it is about a policy behind filters."""
    return isinstance(value, dict) and value.get("kind") == "policy"
