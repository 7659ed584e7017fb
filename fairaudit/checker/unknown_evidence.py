"""The evidence of what is claimed of decisions of unknown group, as it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .json_values import Labels, read_choice, read_list, read_object, read_strings
from .rationals import ONE, Rational, at_most, read_extended, read_rational
from .text import malformed


@dataclass(frozen=True)
class Share:
    """Between which shares of the unknown decisions are of a group, or of none if that is None, as declared."""

    group: Labels | None
    least: Rational
    most: Rational


@dataclass(frozen=True)
class Place:
    """A context, none for all together, and perhaps two groups."""

    context: Labels | None
    pair: tuple[Labels, Labels] | None


@dataclass(frozen=True)
class Assigned:
    """How many unknown decisions of each value the groups of a block receive."""

    context: Labels | None
    values: tuple[Rational, ...]
    counts: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Evidence:
    """What a claim of one of the two ends shows."""

    place: Place | None  # where the greatest ratio is attained, or what proves the least one
    levels: tuple[Rational, Rational] | None = None  # the least mean cannot be above the first, nor the greatest below the second
    received: tuple[int, int] = (0, 0)
    reached: Rational | None = None  # a ratio that some assignment does not exceed
    assigned: tuple[Assigned, ...] = ()


@dataclass(frozen=True)
class Tips:
    """How many unknown decisions cannot change what the others say by themselves, and the pair for which one more could."""

    labelled: str
    rows: int
    place: Place


def read_shares(value: object, where: str) -> tuple[Share, ...]:
    """Read the declared shares."""
    found: list[Share] = []
    for i, item in enumerate(read_list(value, where)):
        members = read_object(item, f"{where}[{i}]", ("group", "least", "most"))
        group = None if members["group"] is None else read_strings(members["group"], f"{where}[{i}].group")
        least, most = (read_rational(members[key], f"{where}[{i}].{key}", nonnegative=True) for key in ("least", "most"))
        if not (at_most(least, most) and at_most(most, ONE)):
            raise malformed(f"{where}[{i}]", "must have shares that rise, from 0 to 1")
        found.append(Share(group, least, most))
    if not found or len({share.group for share in found}) < len(found):
        raise malformed(where, "must name groups, each once")
    return tuple(found)


def _read_rows(value: object, where: str) -> int:
    rows, below = read_rational(value, where, nonnegative=True)
    if below != 1:
        raise malformed(where, "must be a whole number")
    return rows


def _read_place(members: Mapping[str, object], where: str) -> Place:
    context = read_strings(members["context"], f"{where}.context") if "context" in members else None
    if "higher" not in members:
        return Place(context, None)
    return Place(context, (read_strings(members["higher"], f"{where}.higher"), read_strings(members["lower"], f"{where}.lower")))


def read_evidence(value: object, where: str, key: tuple[str, str, str, str]) -> Evidence:
    """Read the evidence of a claim of an end."""
    local = ("context",) if key[0] == "local_ratio" else ()
    if key[1] == "<=":
        shown = read_object(value, where, ("completion",))["completion"]
        place = read_object(shown, f"{where}.completion", (*local, "higher", "lower", "received"))
        one, other = read_list(place["received"], f"{where}.completion.received", 2)
        received = _read_rows(one, f"{where}.completion.received[0]"), _read_rows(other, f"{where}.completion.received[1]")
        return Evidence(_read_place(place, f"{where}.completion"), received=received)
    members = read_object(value, where, ("proof", "reached"))
    proof: Place | None = None
    levels: tuple[Rational, Rational] | None = None
    if members["proof"] is not None:
        named = members["proof"] if isinstance(members["proof"], dict) else {}
        own = ("higher", "lower") if "higher" in named else ("levels",) if "levels" in named else ()
        stated = read_object(members["proof"], f"{where}.proof", (*local, *own))
        proof = _read_place(stated, f"{where}.proof")
        if "levels" in stated:
            low, high = (
                read_rational(item, f"{where}.proof.levels", True) for item in read_list(stated["levels"], f"{where}.proof.levels", 2)
            )
            levels = low, high
    if members["reached"] is None:
        return Evidence(proof, levels)
    reached = read_object(members["reached"], f"{where}.reached", ("ratio", "assigned"))
    listed = read_list(reached["assigned"], f"{where}.reached.assigned")
    assigned = tuple(_read_assigned(item, f"{where}.reached.assigned[{i}]", local) for i, item in enumerate(listed))
    return Evidence(proof, levels, reached=read_extended(reached["ratio"], f"{where}.reached.ratio"), assigned=assigned)


def _read_assigned(value: object, where: str, local: tuple[str, ...]) -> Assigned:
    members = read_object(value, where, (*local, "values", "counts"))
    context = read_strings(members["context"], f"{where}.context") if local else None
    listed = read_list(members["values"], f"{where}.values")
    values = tuple(read_rational(item, f"{where}.values[{i}]", nonnegative=True) for i, item in enumerate(listed))
    counts = tuple(
        tuple(_read_rows(rows, f"{where}.counts[{i}][{a}]") for a, rows in enumerate(read_list(item, f"{where}.counts[{i}]")))
        for i, item in enumerate(read_list(members["counts"], f"{where}.counts", len(values)))
    )
    if len(set(values)) < len(values):
        raise malformed(f"{where}.values", "lists a value twice")
    return Assigned(context, values, counts)


def read_tips(value: object, where: str, quantity: str) -> Tips:
    """Read how many unknown decisions cannot change what the others say."""
    members = read_object(value, where, ("labelled", "rows", "pair"))
    local = ("context",) if quantity == "local" else ()
    place = _read_place(read_object(members["pair"], f"{where}.pair", (*local, "higher", "lower")), f"{where}.pair")
    labelled = read_choice(members["labelled"], f"{where}.labelled", ("within", "exceeds"))
    return Tips(labelled, _read_rows(members["rows"], f"{where}.rows"), place)
