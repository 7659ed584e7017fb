"""Whether a new table is still within the radius of a verdict on an old one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.certificates.reader import Subject, number
from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import limit_text
from fairaudit.model.law import Law
from fairaudit.tables.values import Label
from fairaudit.words import approximate, brief, place

Place = tuple[Label, Label]

Laws = dict[Place, dict[Any, Fraction]]


@brief
@dataclass(frozen=True, repr=False)
class Departure:
    """Whether a new table left the radius of a verdict on an old one.

    Attributes
    ----------
    claim : mapping
        The claim about the radius.
    left : bool or None
        Whether some cell moved beyond it; None where that is not known, or the radius says nothing of the new table.
    cell : dict of str to str or None
        The cell that moved furthest.
    moved : Fraction or None
        How far, as total variation.
    sentence : str
        All of it in words.
    """

    claim: Mapping[str, Any]
    left: bool | None
    cell: Mapping[str, str] | None
    moved: Fraction | None
    sentence: str

    @property
    def radius(self) -> Extended:
        """The radius; infinite where the verdict stands whatever moves."""
        return number(self.claim["value"])


def radii_of_table(old: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The claims about radii of verdicts on the table itself: samples move by chance, so that a population's say nothing of a new one."""
    return [c for c in old["claims"] if c["by"] == "T16" and c["scope"] == "this law" and c["quantity"].endswith("_radius")]


def radius_notes(old: Mapping[str, Any], before: Subject | None, after: Subject | None) -> Iterator[str]:
    """Say of each verdict on the old table whether the new one left its radius (T16).

    Parameters
    ----------
    old : mapping
        The old certificate.
    before, after : Subject or None
        Both tables; None where a certificate does not hold its own.

    Yields
    ------
    str
        A sentence for each verdict that has a radius.
    """
    radii = radii_of_table(old)
    if not radii or before is None or after is None:
        return
    yield from (found.sentence for found in _departures(radii, before.law, after.law, _laws(before.law), _laws(after.law)))


def departures_so_far(old: Mapping[str, Any], before: Subject, after: Subject) -> Iterator[Departure]:
    """The same of decisions that go on coming, by how much each is worth: cells without any so far, and labels, are no difference.

    Source: T16. A cell's ends depend on the law of its utility and on its range alone.

    Parameters
    ----------
    old : mapping
        The old certificate.
    before, after : Subject
        Its table, and what was counted so far.

    Yields
    ------
    Departure
        One for each verdict that has a radius.
    """
    radii = radii_of_table(old)
    was, now = (_laws(found.law, _worth(found)) for found in (before, after))
    ranges = {key: (min(worth), max(worth)) for key, worth in _places(before)}
    widest = min(low for low, _ in ranges.values()), max(high for _, high in ranges.values())
    silent = ""
    if (before.law.columns.group, before.law.columns.context) != (after.law.columns.group, after.law.columns.context):
        silent = "says nothing of a table with other columns"
    elif not all(low <= value <= high for key, law in now.items() for low, high in [ranges.get(key, widest)] for value in law):
        silent = "says nothing of a utility whose range is another one"
    if silent:
        yield from (Departure(claim, None, None, None, f"{_verdict(claim)} {silent}") for claim in radii)
        return
    missing = len(was.keys() - now.keys())
    for found in _departures(radii, before.law, after.law, {key: was[key] for key in was if key in now}, now):
        if missing and found.left is False and found.claim["evidence"]["verdict"] == "exceeds":
            said = f"{_verdict(found.claim)} has a radius, and {missing} of its cells have no decision so far"
            yield Departure(found.claim, None, found.cell, found.moved, said)
        elif found.radius == inf and not before.utility.by_decision:  # cells that come new, and other shares, may have another range
            yield replace(found, left=None)
        else:
            yield found


def _verdict(claim: Mapping[str, Any]) -> str:
    quantity, unit, _ = claim["quantity"].split("_")
    return f"the old verdict {claim['evidence']['verdict']} ({limit_text(quantity, unit, Fraction(claim['evidence']['limit']))})"


def _departures(radii: list[Mapping[str, Any]], before: Law, after: Law, was: Laws, now: Laws) -> Iterator[Departure]:
    moved = _moved(was, now)
    names = before.columns
    for claim in radii:
        verdict, radius, within = _verdict(claim), number(claim["value"]), claim["evidence"]["verdict"] == "within"
        if radius == inf:
            yield Departure(claim, False, None, None, f"{verdict} holds whatever an update does to the decisions of the cells")
            continue
        if claim["quantity"].startswith("global") and not _same_shares(before, after):
            said = f"{verdict} has a radius only where the contexts of each group stay distributed as they were, and they did not"
            yield Departure(claim, None, None, None, said)
            continue
        if not moved:
            continue
        (x, a), far = max(moved.items(), key=lambda item: item[1])
        cell = {**dict(zip(names.context, x, strict=True)), **dict(zip(names.group, a, strict=True))}
        holds = far <= radius if within else far < radius
        limit = f"{approximate(100 * Fraction(radius), 'down')} % for which {verdict} holds"
        by = f"{approximate(100 * far, 'down' if not holds else 'up')} %"
        said = f"no cell moved by more than {by}, within the {limit}" if holds else f"cell {place(cell)} moved by {by}, beyond the {limit}"
        yield Departure(claim, not holds, cell, far, said)


def _moved(was: Laws, now: Laws) -> dict[Place, Fraction]:
    """The total variation between the laws of each cell of both tables; 1 where one of them has no such cell."""
    found: dict[Place, Fraction] = {}
    for key in dict.fromkeys((*was, *now)):
        first, second = was.get(key), now.get(key)
        found[key] = Fraction(1)
        if first is not None and second is not None:
            labels = first.keys() | second.keys()
            found[key] = sum((abs(first.get(u, Fraction(0)) - second.get(u, Fraction(0))) for u in labels), Fraction(0)) / 2
    return found


Worth = Callable[[int], list[Fraction]]


def _worth(found: Subject) -> Worth:
    """What each decision of a cell is worth."""
    table = found.utility
    if table.by_decision:
        same = [Fraction(int(v), table.scale) for v in table.values.tolist()]
        return lambda _: same
    return lambda cell: [Fraction(int(v), table.scale) for v in table.values[cell].tolist()]


def _places(of: Subject) -> Iterator[tuple[Place, list[Fraction]]]:
    worth = _worth(of)
    for cell, (x, a) in enumerate(zip(of.law.cell_context.tolist(), of.law.cell_group.tolist(), strict=True)):
        yield (of.law.contexts[x], of.law.groups[a]), worth(cell)


def _laws(law: Law, worth: Worth | None = None) -> Laws:
    """The law of the decision of each cell, or of what it is worth."""
    found: Laws = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        row = law.row(cell)
        total, own = sum(row), found.setdefault((law.contexts[x], law.groups[a]), {})
        for u, w in zip(law.decisions if worth is None else worth(cell), row, strict=True):
            if w:
                own[u] = own.get(u, Fraction(0)) + Fraction(w, total)
    return found


def _same_shares(one: Law, other: Law) -> bool:
    """Whether the contexts of each group have the same shares."""
    return _shares(one) == _shares(other)


def _shares(law: Law) -> dict[Place, Fraction]:
    totals: dict[int, int] = {}
    for a, mass in zip(law.cell_group.tolist(), law.cell_mass, strict=True):
        totals[a] = totals.get(a, 0) + mass
    listed = zip(law.cell_context.tolist(), law.cell_group.tolist(), law.cell_mass, strict=True)
    return {(law.contexts[x], law.groups[a]): Fraction(mass, totals[a]) for x, a, mass in listed if mass}
