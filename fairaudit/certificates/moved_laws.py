"""Whether a new table is still within the radius of a verdict on an old one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

from fairaudit.certificates.reader import Subject
from fairaudit.measures.limits import limit_text
from fairaudit.model.law import Law
from fairaudit.tables.values import Label
from fairaudit.words import approximate, place

Place = tuple[Label, Label]


def radius_notes(old: Mapping[str, Any], before: Subject | None, after: Subject | None) -> Iterator[str]:
    """Say of each verdict on the old table whether the new one left its radius (T16).

    Samples move by chance, so that verdicts on a population, whose radius is that of the population, are left out.

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
    radii = [c for c in old["claims"] if c["by"] == "T16" and c["scope"] == "this law" and c["quantity"].endswith("_radius")]
    if not radii or before is None or after is None:
        return
    moved = _moved(before.law, after.law)
    names = before.law.columns
    for claim in radii:
        quantity, unit, _ = claim["quantity"].split("_")
        verdict = f"the old verdict {claim['evidence']['verdict']} ({limit_text(quantity, unit, Fraction(claim['evidence']['limit']))})"
        if claim["value"] == "inf":
            yield f"{verdict} holds whatever an update does to the decisions of the cells"
            continue
        radius, within = Fraction(claim["value"]), claim["evidence"]["verdict"] == "within"
        if quantity == "global" and not _same_shares(before.law, after.law):
            yield f"{verdict} has a radius only where the contexts of each group stay distributed as they were, and they did not"
            continue
        if not moved:
            continue
        (x, a), far = max(moved.items(), key=lambda item: item[1])
        where = place({**dict(zip(names.context, x, strict=True)), **dict(zip(names.group, a, strict=True))})
        holds = far <= radius if within else far < radius
        limit = f"{approximate(100 * radius, 'down')} % for which {verdict} holds"
        by = f"{approximate(100 * far, 'down' if not holds else 'up')} %"
        yield f"cell {where} moved by {by}, beyond the {limit}" if not holds else f"no cell moved by more than {by}, within the {limit}"


def _moved(one: Law, other: Law) -> dict[Place, Fraction]:
    """The total variation between the laws of each cell of both tables; 1 where one of them has no such cell."""
    was, now = _laws(one), _laws(other)
    found: dict[Place, Fraction] = {}
    for key in dict.fromkeys((*was, *now)):
        first, second = was.get(key), now.get(key)
        found[key] = Fraction(1)
        if first is not None and second is not None:
            labels = first.keys() | second.keys()
            found[key] = sum((abs(first.get(u, Fraction(0)) - second.get(u, Fraction(0))) for u in labels), Fraction(0)) / 2
    return found


def _laws(law: Law) -> dict[Place, dict[str, Fraction]]:
    found: dict[Place, dict[str, Fraction]] = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        row = law.row(cell)
        total = sum(row)
        found[law.contexts[x], law.groups[a]] = {u: Fraction(w, total) for u, w in zip(law.decisions, row, strict=True) if w}
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
