"""The header of a table: columns, population, decisions, groups, contexts, utility and filters; and what a cell is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from .filters import Filter, read_filter
from .json_values import Labels, check_distinct, read_choice, read_hexadecimal, read_label_lists, read_object, read_string, read_strings
from .laws import Law
from .rationals import Rational, read_rationals
from .text import malformed
from .work import keep, spend, working_on

TABLE_FORMAT = "fairaudit-table/1"


# The table


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
    group_filter: Filter | None = None  # of a policy, and of no other subject
    context_filter: Filter | None = None
    truths: tuple[str, ...] | None = None  # the true labels


class Cell(NamedTuple):
    """What is known of (x,a): P(u|x,a) is ``law``, M(x,a) is ``mass`` and E(x,a) is ``expectation``."""

    context: int
    group: int
    law: Law
    mass: Rational
    expectation: Rational
    utility: Sequence[Rational | None]


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
    members = read_object(value, where, ("decision", "truth"))
    decisions = read_strings(members["decision"], f"{where}.decision")
    check_distinct(decisions, f"{where}.decision")
    return Positive(decisions, read_string(members["truth"], f"{where}.truth"))


def read_header(value: object, where: str) -> Header:
    keys = ["format", "kind", "columns", "population", "decisions", "groups", "contexts", "utility"]
    of_policy = is_about_policy(value)
    members = read_object(value, where, keys + ["filters"] * of_policy + ["truths"] * has_truth(value), optional=("salt",))
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
        None if utility is None else tuple(read_rationals(utility, f"{where}.utility", len(decisions))),
    )
    if "truths" in members:
        header = replace(header, truths=read_strings(members["truths"], f"{where}.truths"))
        check_distinct(header.truths or (), f"{where}.truths")
    if not of_policy:
        return header
    filters = read_object(members["filters"], f"{where}.filters", ("group", "context"))
    group = read_filter(filters["group"], f"{where}.filters.group", len(subject.columns.group))
    context = None
    if filters["context"] is not None:
        context = read_filter(filters["context"], f"{where}.filters.context", len(subject.columns.context))
    if group.size < 2:
        raise malformed(f"{where}.filters.group", "has fewer than two inputs")
    true_contexts = context.size if context else len(header.contexts)
    working_on("the law that the filters induce")
    spend(true_contexts * (group.size * (100 + 10 * len(decisions)) + 3 * group.released * len(decisions)))
    keep(true_contexts * (12 * group.size + max(group.size, group.released) * len(decisions)))
    return replace(header, group_filter=group, context_filter=context)


def is_about_policy(value: object) -> bool:
    return isinstance(value, dict) and value.get("kind") == "policy"
