"""Lines of a stream that were left out, counted by group wherever their group could be read; the order of the lines does not matter."""

from __future__ import annotations

from bisect import insort
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from fairaudit.tables.values import Label
from fairaudit.words import place, plain

__all__ = ["LeftOut", "Why", "said"]

Why = Literal["dead", "repeats", "early"]

WHY: dict[Why, str] = {"dead": "dead_letters", "repeats": "repeats", "early": "before_since"}
"""Why lines are left out, by their names in a state, and what JSON calls them."""

GROUPS = 1_000  # counted by themselves: a state is written several times a second, and a column of identifiers has more

LONGEST = 200  # characters of a group that is counted by itself

SHOWN = 6  # groups in a sentence


class LeftOut:
    """How many lines were left out of each group, of other groups, and of groups that are not known.

    Of more groups than are held, those with the shortest names are, and of equally short ones the first in the alphabet. A group that once
    made room is never held again, so that the counts of the others are complete in whatever order lines come.

    Parameters
    ----------
    kept : mapping
        What `kept` returned in an earlier run.
    tally : mapping
        How many lines were left out in all; those of which `kept` has nothing are of groups that are not known.

    Examples
    --------
    >>> found = LeftOut()
    >>> for group in [("f",), ("f",), ("m",), None]:
    ...     found.add("dead", group)
    >>> said(found.entry(["sex"], {("f",): 98}), "dead_letters")
    'sex=f 2 (98 counted), sex=m 1 (0 counted), group unknown 1'
    """

    def __init__(self, kept: Mapping[str, Any] | None = None, tally: Mapping[str, Any] | None = None) -> None:
        stored = kept or {}
        self.groups: dict[Label, Counter[str]] = {tuple(labels): Counter(counts) for labels, counts in stored.get("groups", ())}
        self.other: Counter[str] = Counter(stored.get("other", {}))
        self.unknown: Counter[str] = Counter(stored.get("unknown", {}))
        self._held = sorted(map(_rank, self.groups))
        for why in WHY:
            self.unknown[why] += max(0, (tally or {}).get(why, 0) - self.total(why))

    def total(self, why: Why) -> int:
        """How many lines were left out for a reason."""
        return sum(counts[why] for counts in (*self.groups.values(), self.other, self.unknown))

    def add(self, why: Why, group: Label | None) -> None:
        """Count a line; None is a group that cannot be read."""
        if group is None:
            self.unknown[why] += 1
        elif group in self.groups:
            self.groups[group][why] += 1
        elif sum(map(len, group)) > LONGEST or (len(self._held) >= GROUPS and _rank(group) > self._held[-1]):
            self.other[why] += 1
        else:
            self.groups[group] = Counter({why: 1})
            insort(self._held, _rank(group))
            if len(self._held) > GROUPS:
                self.other += self.groups.pop(self._held.pop()[1])

    def kept(self) -> dict[str, Any]:
        """What is to be stored."""
        listed = [[list(group), dict(self.groups[group])] for group in sorted(self.groups)]
        return {"groups": listed, "other": dict(self.other), "unknown": dict(self.unknown)}

    def since(self, earlier: LeftOut) -> LeftOut:
        """What was left out after an earlier moment of the same stream."""
        found = LeftOut()
        found.groups = {group: counts - earlier.groups.get(group, Counter()) for group, counts in self.groups.items()}
        gone = [counts for group, counts in earlier.groups.items() if group not in self.groups]
        found.other = self.other - sum(gone, earlier.other)
        found.unknown = self.unknown - earlier.unknown
        return found

    def entry(self, names: Sequence[str], counted: Mapping[Label, int]) -> dict[str, Any]:
        """The same for JSON, with how many decisions of each group were counted."""

        def amounts(counts: Mapping[str, int]) -> dict[str, int]:
            return {name: counts.get(why, 0) for why, name in WHY.items()}

        listed = [
            {"group": dict(zip(names, group, strict=True)), "counted": counted.get(group, 0), **amounts(self.groups[group])}
            for group in sorted(self.groups)
        ]
        return {"groups": listed, "other_groups": amounts(self.other), "unknown_group": amounts(self.unknown)}


def said(entry: Mapping[str, Any], name: str) -> str:
    """Of which groups lines were left out, greatest numbers first; nothing where no group is known."""
    found = sorted((own for own in entry["groups"] if own[name]), key=lambda own: -own[name])
    listed = [f"{plain(place(own['group']))} {own[name]} ({own['counted']} counted)" for own in found[:SHOWN]]
    others = entry["other_groups"][name] + sum(own[name] for own in found[SHOWN:])
    listed += [f"other groups {others}"] if others else []
    return ", ".join([*listed, *([f"group unknown {entry['unknown_group'][name]}"] if listed and entry["unknown_group"][name] else [])])


def _rank(group: Label) -> tuple[int, Label]:
    return sum(map(len, group)), group
