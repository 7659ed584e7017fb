"""What a certificate must prove of a class, pair by pair, and how multipliers are written down."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.worst.setting import Setting


def pairs_by_sticks(setting: Setting, ratio: Fraction, multipliers: Sequence[Fraction]) -> dict[str, Any]:
    """Write the k of the closed form as multipliers R − k of the floor of the lower group."""
    entries = []
    for block, pair in pairs_to_prove(setting, ratio):
        for k in multipliers:
            # Without a floor above m the box alone proves the ratio.
            found = {1: ratio - k} if setting.of.floor > setting.of.m and ratio > k else {}
            if setting.proves(block, pair, found, ratio):
                entries.append(evidence_entry(setting, block, pair, found))
                break
        else:
            raise InputError("the proof of the worst case could not be completed")
    return {"pairs": entries}


def pairs_to_prove(setting: Setting, ratio: Extended) -> Iterator[tuple[int, tuple[int, int]]]:
    """Ordered pairs that the certificate must prove."""
    if ratio == inf or setting.of.cap <= ratio:
        return
    for block, members in enumerate(setting.members):
        if setting.quantity == "local" and setting.of.blind and all(setting.row(c) == setting.row(members[0]) for c in members):
            continue
        for high in members:
            for low in members:
                if high != low:
                    yield block, (high, low)


def evidence_entry(setting: Setting, block: int, pair: tuple[int, int], multipliers: Mapping[int, Fraction]) -> dict[str, Any]:
    """The multipliers of a pair as a certificate lists them: by context, groups and number of the constraint."""
    entry: dict[str, Any] = {}
    place = setting.places[block]
    groups = list(pair)
    if place is not None:
        entry["context"] = setting.contexts[place]
        groups = [setting.group_of[cell] for cell in pair]
    entry |= {"higher": groups[0], "lower": groups[1]}
    entry["multipliers"] = [(number, multipliers[number]) for number in sorted(multipliers) if multipliers[number]]
    return entry
