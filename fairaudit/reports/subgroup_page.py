"""A certificate of the most unequal subgroups, as one self-contained page or as markdown."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from fairaudit.reports.content import UNCHECKED, refusing_other_documents
from fairaudit.reports.markdown import code, prose, table
from fairaudit.reports.page import digest, embedded, templates
from fairaudit.reports.subgroup_content import HEADLINES, describe_subgroups

__all__ = ["subgroup_html", "subgroup_markdown"]


@refusing_other_documents
def subgroup_html(document: Mapping[str, Any], *, checked: str = "") -> str:
    """Write a certificate of the format ``fairaudit-subgroups/1`` as a page, which loads nothing and runs nothing.

    Parameters
    ----------
    document : mapping
        The certificate; it is believed here.
    checked : str
        A sentence on who checked it.
    """
    environment, markup = templates()
    page = describe_subgroups(document)
    css = files("fairaudit.reports").joinpath("page.css").read_text("utf-8")
    headline = HEADLINES[page.verdict]
    text: str = environment.get_template("subgroups.html.j2").render(
        page=page,
        headline=headline[0].upper() + headline[1:],
        checked=checked or UNCHECKED,
        unchecked=not checked,
        css=markup(css),
        embedded=markup(embedded(document)),
        policy=f"default-src 'none'; style-src '{digest(css)}'; base-uri 'none'; form-action 'none'",
    )
    return text


@refusing_other_documents
def subgroup_markdown(document: Mapping[str, Any], *, checked: str = "") -> str:
    """Write a certificate of the format ``fairaudit-subgroups/1`` as markdown.

    Parameters
    ----------
    document : mapping
        The certificate; it is believed here.
    checked : str
        A sentence on who checked it.
    """
    page = describe_subgroups(document)
    first = page.rows[0]
    said = f"{code(first.name)}, {first.rows} rows: {first.mean} against {first.rest} for everybody else, a ratio of {first.ratio}."
    lines = [
        f"## The most unequal subgroups: {HEADLINES[page.verdict]}",
        said if first.exact != "1" else page.lead,
        checked or UNCHECKED,
    ]
    lines += [f"- {verdict}: {name}, judged of this: {prose(judged)}" for verdict, name, judged in page.targets]
    rows = [(code(row.name), row.rows, row.mean, row.rest, row.ratio, row.interval, row.exact) for row in page.rows]
    lines += [table(("subgroup", "rows", "mean", "rest", "ratio", "interval", "exactly"), rows), page.compared]
    lines += [text for text in (page.together, "\n".join(f"- {prose(assumed)}" for assumed in page.assumptions)) if text]
    return "\n\n".join(lines) + "\n"
