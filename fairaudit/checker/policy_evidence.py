"""The evidence of claims about the greatest ratio over policies, as it stands."""

from __future__ import annotations

from dataclasses import dataclass

from .json_values import Labels, read_object, read_strings


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
    members = read_object(value, where, ("context", "higher", "lower"))
    context = None if members["context"] is None else read_strings(members["context"], f"{where}.context")
    return Attained(context, *(read_strings(members[key], f"{where}.{key}") for key in ("higher", "lower")))
