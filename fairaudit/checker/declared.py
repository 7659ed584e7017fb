"""What was declared of a policy behind filters: read, and against the table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from .json_values import Labels, read_list, read_object, read_strings
from .rationals import ONE, Rational, at_most, extreme_positions, read_rational
from .table import Table, constants
from .text import Finding, finding_of, malformed, shown

SCALARS = ("gamma", "m", "tau", "lipschitz", "global_tau", "max_drift")


@dataclass(frozen=True)
class DeclaredIn:
    """What was declared of one context: gamma, m, tau, or some of them."""

    context: Labels
    values: dict[str, Rational]


def read_declared(value: object, where: str) -> tuple[dict[str, Rational], tuple[DeclaredIn, ...]]:
    """Read what was declared of all contexts, and of single ones."""
    members = read_object(value, where, (), optional=(*SCALARS, "by_context"))
    scalars = {key: read_rational(item, f"{where}.{key}", nonnegative=True) for key, item in members.items() if key != "by_context"}
    if "max_drift" in scalars and not at_most(scalars["max_drift"], ONE):
        raise malformed(f"{where}.max_drift", "must be at most 1")
    if "by_context" not in members:
        return scalars, ()
    entries = tuple(
        _read_entry(item, f"{where}.by_context[{i}]") for i, item in enumerate(read_list(members["by_context"], f"{where}.by_context"))
    )
    if not entries:
        raise malformed(f"{where}.by_context", "must not be empty")
    if len({entry.context for entry in entries}) < len(entries):
        raise malformed(f"{where}.by_context", "lists a context twice")
    return scalars, entries


def _read_entry(value: object, where: str) -> DeclaredIn:
    members = read_object(value, where, ("context",), optional=("gamma", "m", "tau"))
    values = {key: read_rational(item, f"{where}.{key}", nonnegative=True) for key, item in members.items() if key != "context"}
    if not values:
        raise malformed(where, "must have gamma, m or tau")
    return DeclaredIn(read_strings(members["context"], f"{where}.context"), values)


def check_declared(declared: Mapping[str, Rational], by_context: Sequence[DeclaredIn], table: Table) -> Iterator[Finding]:
    """Compare what was declared with the table, which it must not contradict."""
    own = constants(table)
    if "global_tau" in declared:
        means = [table.figures.of_group(a)[1] for a in table.figures.populated()]
        own["global_tau"] = means[extreme_positions(means)[1]]
    for key, value in declared.items():
        if key != "max_drift":  # which is about other policies
            yield _bounded(f"subject.declared.{key}", key, value, own[key])
    last = -1
    for i, entry in enumerate(by_context):
        where = f"subject.declared.by_context[{i}]"
        place = table.header.contexts.index(entry.context) if entry.context in table.header.contexts else -1
        fault = (
            "" if place > last else "contexts are not in the order of the true contexts" if place >= 0 else "there is no such true context"
        )
        yield finding_of(f"{where} is about {shown(list(entry.context))}", not fault, fault)
        if place >= 0:
            last = max(last, place)
            for key, value in entry.values.items():
                yield _bounded(f"{where}.{key}", key, value, _in_context(table, place)[key])


def _in_context(table: Table, context: int) -> dict[str, Rational]:
    """Find the constants of a true context."""
    groups = len(table.header.groups)
    cells = table.cells[context * groups : (context + 1) * groups]
    gains = [entry for cell in cells for entry in cell.utility if entry is not None]
    means = [cell.expectation for cell in cells]
    top, low = extreme_positions(gains)
    return {"gamma": gains[top], "m": gains[low], "tau": means[extreme_positions(means)[1]]}


def _bounded(name: str, key: str, value: Rational, own: object) -> Finding:
    """Find whether a declared constant allows for what the table has."""
    pair = (own, value) if key in ("gamma", "lipschitz") else (value, own)
    true = isinstance(own, tuple) and at_most(*pair)
    return finding_of(f"{name} is {shown(value)}", true, "" if true else f"the table gives {shown(own)}")
