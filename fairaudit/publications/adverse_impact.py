"""The adverse impact ratio of credit and insurance: the rate of each group beside that of a control group that was named."""

from __future__ import annotations

from collections.abc import Sequence

from fairaudit.errors import InputError, nearest, shown
from fairaudit.publications.comparison import (
    count_of,
    lead,
    points,
    publication_of,
    reading,
    said_of_same,
    same_groups,
    section,
    sheets,
    sheets_by,
)
from fairaudit.publications.counts import Counts, Decisions, facts_of
from fairaudit.publications.publication import Page, Publication, Section
from fairaudit.publications.withholding import Withholding, parts_of, said_of

__all__ = ["adverse_impact"]

RULE = "air"

CONTROL = "the control group"

ABOUT = (
    (
        "Ratio: the rate of the group divided by that of the control group, which was named and not chosen by its rate; it is more than 1 "
        "where the group fares better, and there is none where nobody of the control group was selected and somebody of the group was."
    ),
    "Four fifths is a rule of thumb from employment. No lending regulator has made a number law, and this page judges none.",
    (
        "The standardized mean difference, which is often printed beside this ratio, is left out: it needs the spread of a score, and a "
        "certificate of decisions holds no scores."
    ),
)


def adverse_impact(
    decisions: Decisions,
    favourable: Sequence[str],
    control: Sequence[str],
    by: Sequence[Sequence[str]] = (),
    withholding: Withholding | None = None,
) -> Publication:
    """Compare each group with a control group.

    Parameters
    ----------
    decisions : Decisions
        What was decided.
    favourable : sequence of str
        Which decisions count as selected: approved, say.
    control : sequence of str
        The labels of the control group: one of each column that is compared by, as ``label`` or ``column=label``.
    by : sequence of sequences of str
        The columns by which groups are formed; by default each, and all together.
    withholding : Withholding, optional
        Which groups are withheld.

    Raises
    ------
    InputError
        If the control group is not named by one label of each column, or has no people.
    """
    counts = decisions.selected(favourable)
    sets = sheets_by(counts.columns, by)
    named = _controls(counts, {name: None for columns in sets for name in columns}, control)

    def choice(part: Counts) -> int:
        label = tuple(named[name] for name in part.columns)
        if label in part.withheld:
            raise InputError(
                f"--control: the group {shown(', '.join(label))} is withheld, so that nothing could be compared with it; name a greater "
                "group, or choose columns with --by"
            )
        if label not in part.groups or not part.applicants[part.groups.index(label)]:
            raise InputError(
                f"--control: nobody is of the group {shown(', '.join(label))}; name one with people, or choose columns with --by"
            )
        return part.groups.index(label)

    same = same_groups(counts, sets)
    found = sheets([part for part in parts_of(counts, sets, withholding) if part.columns not in same], choice)
    number = count_of(found)
    facts = [("Control group", ", ".join(f"{name} {shown(label)}" for name, label in named.items()))]
    page = Page(
        title="Adverse impact ratios",
        lead=lead(number, CONTROL),
        points=points(number),
        facts=(*facts, *facts_of(decisions, counts, favourable, totals=withholding is None), *said_of_same(same), *said_of(withholding)),
        sections=(
            *(section(sheet, CONTROL, number["comparisons"]) for sheet in found),
            Section("How to read this", (*ABOUT, *reading(number["comparisons"], CONTROL))),
        ),
    )
    return publication_of(RULE, page, found, decisions, favourable, control=named)


def _controls(counts: Counts, columns: dict[str, None], control: Sequence[str]) -> dict[str, str]:
    """The label of the control group in each column."""
    there = {name: {group[counts.columns.index(name)]: None for group in counts.groups} for name in columns}
    known = {name: {label: None for label in labels if (name, label) not in counts.silent} for name, labels in there.items()}
    named: dict[str, str] = {}
    for text in control:
        column, _, rest = text.partition("=")
        fits = [(name, text) for name in columns if text in known[name]]
        fits += [(column, rest)] if rest in known.get(column, ()) else []
        if not fits:
            labels = dict.fromkeys(label for name in columns for label in known[name])
            raise InputError(f"--control: there is no group {shown(text)}; {nearest(text, labels)}")
        if len(fits) > 1:
            spelled = " or ".join(f"{name}={label}" for name, label in fits)
            raise InputError(f"--control {shown(text)} is a label of several columns; write {spelled}")
        ((name, label),) = fits
        if name in named:
            raise InputError(f"--control names {shown(named[name])} and {shown(label)} of the column {shown(name)}; name one")
        named[name] = label
    for name in columns:
        if name not in named:
            raise InputError(
                f"--control names no label of the column {shown(name)}; {nearest('', known[name])} (or choose columns with --by)"
            )
    return {name: named[name] for name in columns}
