"""A certificate of the most unequal subgroups, as one self-contained page or as markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fairaudit.reports.content import UNCHECKED, refusing_other_documents
from fairaudit.reports.markdown import code, prose, provenance_lines, table
from fairaudit.reports.page import scriptless
from fairaudit.reports.provenance import Provenance
from fairaudit.reports.subgroup_content import HEADLINES, describe_subgroups
from fairaudit.words import noun

__all__ = ["subgroup_html", "subgroup_markdown"]


@refusing_other_documents
def subgroup_html(document: Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate of the format ``fairaudit-subgroups/1`` as a page, which loads nothing and runs nothing.

    Parameters
    ----------
    document : mapping
        The certificate; it is believed here.
    checked : str
        A sentence on who checked it.
    provenance : Provenance, optional
        What its attestation says.
    """
    page = describe_subgroups(document)
    first = ("worst", "Who fares most unequally")
    return scriptless(
        "subgroups.html.j2", "The most unequal subgroups", page, HEADLINES[page.verdict], document, checked, first, provenance
    )


@refusing_other_documents
def subgroup_markdown(document: Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate of the format ``fairaudit-subgroups/1`` as markdown.

    Parameters
    ----------
    document : mapping
        The certificate; it is believed here.
    checked : str
        A sentence on who checked it.
    provenance : Provenance, optional
        What its attestation says.
    """
    page = describe_subgroups(document)
    first = page.rows[0]
    said = (
        f"{code(first.name)}, {first.rows} {noun(first.rows, 'row')}: {first.mean} against {first.rest} for everybody "
        f"else, a ratio of {first.ratio}."
    )
    lines = [
        f"## The most unequal subgroups: {HEADLINES[page.verdict]}",
        said if first.exact != "1" else page.lead,
        checked or UNCHECKED,
    ]
    lines += [f"- {verdict}: {name}, judged of this: {prose(judged)}" for verdict, name, judged in page.targets]
    rows = [(code(row.name), row.rows, row.mean, row.rest, row.ratio, row.interval, row.exact) for row in page.rows]
    lines += [table(("subgroup", "rows", "mean", "rest", "ratio", "interval", "exactly"), rows), page.compared]
    lines += [text for text in (page.together, "\n".join(f"- {prose(assumed)}" for assumed in page.assumptions)) if text]
    return "\n\n".join([*lines, *provenance_lines(provenance)]) + "\n"
