"""The four-fifths rule (29 CFR 1607.4 D): each group beside the one with the highest selection rate, with findings and no verdict."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

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

__all__ = ["four_fifths", "highest"]

RULE = "four-fifths"

LABOUR_FORCE = "The rule is meant for groups of at least 2 % of the labour force, which no table of decisions shows."

CHOSEN = (
    "The group that all are compared with was chosen because its rate is the highest. That makes differences look larger than those from a "
    "group that was named in advance, and no figure here corrects it; a small group may well have the highest rate by chance."
)

QUOTES = (
    (
        "“A selection rate for any race, sex, or ethnic group which is less than four-fifths (4/5) (or eighty percent) of the rate for the "
        "group with the highest rate will generally be regarded by the Federal enforcement agencies as evidence of adverse impact, while "
        "a greater than four-fifths rate will generally not be regarded by Federal enforcement agencies as evidence of adverse impact.”"
    ),
    (
        "“Smaller differences in selection rate may nevertheless constitute adverse impact, where they are significant in both statistical "
        "and practical terms or where a user's actions have discouraged applicants disproportionately on grounds of race, sex, or ethnic "
        "group.”"
    ),
    (
        "“Greater differences in selection rate may not constitute adverse impact where the differences are based on small numbers and are "
        "not statistically significant, or where special recruiting or other programs cause the pool of minority or female candidates to "
        "be atypical of the normal pool of applicants from that group.”"
    ),
    "Where numbers are too small to be reliable, the paragraph lets a longer period, or the same procedure used elsewhere, be considered.",
)


def highest(counts: Counts) -> int | None:
    """The place of the group with the highest rate; of several the one with the most people, then the first. None without two groups.

    Examples
    --------
    >>> highest(Counts(("g",), (("a",), ("b",), ("c",)), (4, 16, 9), (3, 12, 1)))
    1
    """
    there = [place for place, applied in enumerate(counts.applicants) if applied]
    if len(there) < 2:
        return None
    return max(there, key=lambda place: (Fraction(counts.selected[place], counts.applicants[place]), counts.applicants[place], -place))


def four_fifths(
    decisions: Decisions, favourable: Sequence[str], by: Sequence[Sequence[str]] = (), withholding: Withholding | None = None
) -> Publication:
    """What the four-fifths rule asks for.

    Parameters
    ----------
    decisions : Decisions
        What was decided.
    favourable : sequence of str
        Which decisions count as selected.
    by : sequence of sequences of str
        The columns by which groups are formed; by default each, and all together.
    withholding : Withholding, optional
        Which groups are withheld.

    Raises
    ------
    InputError
        If a column is none of the certificate.
    """
    counts = decisions.selected(favourable)
    tables = sheets_by(counts.columns, by)
    same = same_groups(counts, tables)
    found = sheets([part for part in parts_of(counts, tables, withholding) if part.columns not in same], highest)
    number = count_of(found)
    page = Page(
        title="Selection rates beside the four-fifths rule",
        lead=lead(number, "the group of the highest rate"),
        points=points(number),
        facts=(
            ("Rule", "29 CFR 1607.4 D, Uniform Guidelines on Employee Selection Procedures"),
            *facts_of(decisions, counts, favourable, totals=withholding is None),
            *said_of_same(same),
            *said_of(withholding),
        ),
        sections=(
            *(section(sheet, "the highest rate", number["comparisons"], LABOUR_FORCE) for sheet in found),
            Section("How to read this", (*reading(number["comparisons"], "the highest rate"), CHOSEN)),
            Section("What the rule says, both ways", quotes=QUOTES),
        ),
    )
    return publication_of(RULE, page, found, decisions, favourable)
