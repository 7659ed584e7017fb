"""The evidence of claims about the greatest ratio over policies, as it stands."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from .json_values import Labels, read_integer, read_list, read_object, read_strings
from .rationals import Rational, read_rational, read_rationals
from .text import malformed


@dataclass(frozen=True)
class Attained:
    """Where a greatest ratio is attained; no context of group means."""

    context: Labels | None
    higher: Labels
    lower: Labels


def read_attained(value: object, where: str) -> Attained | None:
    """Read where a ratio is attained; null where it is 1."""
    if value is None:
        return None
    return _read_place(read_object(value, where, ("context", "higher", "lower")), where)


def _read_place(members: dict[str, object], where: str) -> Attained:
    context = None if members["context"] is None else read_strings(members["context"], f"{where}.context")
    return Attained(context, *(read_strings(members[key], f"{where}.{key}") for key in ("higher", "lower")))


@dataclass(frozen=True)
class Priced:
    """An ordered pair of groups, and multiples y of some floors: of a true context, or none for that of a mean, and a group."""

    place: Attained
    floors: tuple[tuple[int | None, int, Fraction], ...]


@dataclass(frozen=True)
class Witness:
    """A policy that keeps the floors and attains a ratio: its laws by released context and released group."""

    attained: Attained
    rows: list[list[list[Rational]]]


@dataclass(frozen=True)
class FlooredEvidence:
    """Why no policy that keeps the floors exceeds a ratio, and a policy that attains it, if one is needed."""

    multipliers: list[Fraction]
    pairs: list[Priced]
    policy: Witness | None


def read_multipliers(value: object, where: str) -> list[Fraction]:
    """Read multipliers k."""
    return [Fraction(*k) for k in read_rationals(value, where, len(read_list(value, where)))]


def read_floored(members: dict[str, object], where: str) -> FlooredEvidence:
    """Read the evidence of a claim about the policies that keep the declared floors."""
    pairs = [_read_priced(item, f"{where}.pairs[{i}]") for i, item in enumerate(read_list(members["pairs"], f"{where}.pairs"))]
    policy = None if members["policy"] is None else _read_witness(members["policy"], f"{where}.policy")
    return FlooredEvidence(read_multipliers(members["multipliers"], f"{where}.multipliers"), pairs, policy)


def _read_priced(value: object, where: str) -> Priced:
    members = read_object(value, where, ("context", "higher", "lower", "floors"))
    floors: list[tuple[int | None, int, Fraction]] = []
    for i, item in enumerate(read_list(members["floors"], f"{where}.floors")):
        place = f"{where}.floors[{i}]"
        context, group, worth = read_list(item, place, 3)
        y = Fraction(*read_rational(worth, f"{place}[2]", nonnegative=True))
        if not y:
            raise malformed(f"{place}[2]", "must be positive")
        floors.append((None if context is None else read_integer(context, f"{place}[0]"), read_integer(group, f"{place}[1]"), y))
    return Priced(_read_place(members, where), tuple(floors))


def _read_witness(value: object, where: str) -> Witness:
    members = read_object(value, where, ("attained", "rows"))
    attained = read_attained(members["attained"], f"{where}.attained")
    if attained is None:
        raise malformed(f"{where}.attained", "must not be null")
    rows: list[list[list[Rational]]] = []
    for i, row in enumerate(read_list(members["rows"], f"{where}.rows")):
        laws = enumerate(read_list(row, f"{where}.rows[{i}]"))
        places = ((law, f"{where}.rows[{i}][{j}]") for j, law in laws)
        rows.append([read_rationals(law, place, len(read_list(law, place))) for law, place in places])
    return Witness(attained, rows)
