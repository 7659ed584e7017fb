"""A certificate about groups that nobody recorded, as one self-contained page or as markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fairaudit.reports.content import UNCHECKED, refusing_other_documents
from fairaudit.reports.markdown import code, provenance_lines, table
from fairaudit.reports.page import scriptless
from fairaudit.reports.provenance import Provenance
from fairaudit.reports.proxy_content import HEADLINES, describe_proxies

__all__ = ["proxy_html", "proxy_markdown"]


@refusing_other_documents
def proxy_html(document: Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate of the format ``fairaudit-proxies/1`` as a page, which loads nothing and runs nothing.

    Parameters
    ----------
    document : mapping
        The certificate; it is believed here.
    checked : str
        A sentence on who checked it.
    provenance : Provenance, optional
        What its attestation says.
    """
    page = describe_proxies(document)
    title, first = "Groups that were not recorded", ("ranges", "What each group can have got")
    return scriptless("proxies.html.j2", title, page, HEADLINES[page.verdict], document, checked, first, provenance)


@refusing_other_documents
def proxy_markdown(document: Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate of the format ``fairaudit-proxies/1`` as markdown.

    Parameters
    ----------
    document : mapping
        The certificate; it is believed here.
    checked : str
        A sentence on who checked it.
    provenance : Provenance, optional
        What its attestation says.
    """
    page = describe_proxies(document)
    lines = [f"## Fairness audit of groups that were not recorded: {HEADLINES[page.verdict]}", page.lead, checked or UNCHECKED]
    lines += [f"- {verdict}: {name}" for verdict, name in page.targets]
    for panel in page.panels:
        lines.append(f"### {code(panel.title)}, {panel.said}")
        rows = [(code(bar.name), bar.said, bar.exact) for bar in (*panel.means, *panel.ratios)]
        lines.append(table(("mean of a group, ratio of two", "range", "exactly"), rows))
    lines.append("\n".join(f"- {text}" for text in page.assumptions))
    return "\n\n".join([*lines, *provenance_lines(provenance)]) + "\n"
