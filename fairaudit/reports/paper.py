"""The page of a report in print: a PDF of all of it, which is the same for the same page and holds the certificate as an attachment."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import PurePath
from typing import Any

from fairaudit.certificates.certificate import FORMAT, Certificate
from fairaudit.errors import InputError
from fairaudit.reports.content import describe
from fairaudit.reports.page import templates
from fairaudit.reports.rows import table_rows
from fairaudit.reports.views import Views

__all__ = ["check_extra", "print_page", "printed"]

DATE = datetime(1980, 1, 1, tzinfo=UTC)
"""Of the attachment: what is printed says when something was, and where; the file itself is the same whenever it is made."""

DRAWN = {"fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin", "opacity", "font-size", "font-weight"}
"""Properties of shapes, which are not passed down to a drawing from the style of the page around it."""

VARIABLE = re.compile(r"var\(\s*(--[\w-]+)\s*\)")


def printed(page: str, document: Mapping[str, Any], beside: Mapping[str, bytes] | None = None) -> bytes:
    """Print the page of a report, with every row of its table.

    Parameters
    ----------
    page : str
        The page.
    document : mapping
        The certificate that it is about, which is attached.
    beside : mapping of str to bytes, optional
        Further files that are attached, by their names; one called ``certificate.json`` takes the place of the certificate.

    Returns
    -------
    bytes
        The PDF.

    Raises
    ------
    InputError
        If WeasyPrint or a library that it needs is missing.
    """
    weasyprint = _weasyprint()
    held = {"certificate.json": Certificate(dict(document)).text.encode("ascii"), **(beside or {})}
    attached = [
        weasyprint.Attachment(string=content, name=name, description=f"The {PurePath(name).stem}", created=DATE, modified=DATE)
        for name, content in held.items()
    ]
    before, _, after = page.rpartition("</main>")
    return print_page(
        f"{before}{_further(document, attested=next((name for name in held if name != 'certificate.json'), ''))}</main>{after}", attached
    )


def print_page(page: str, attachments: Sequence[Any] = ()) -> bytes:
    """Print a page as it is.

    Raises
    ------
    InputError
        If WeasyPrint or a library that it needs is missing.
    """
    weasyprint = _weasyprint()
    from weasyprint.urls import URLFetcher

    paper = weasyprint.CSS(string=files("fairaudit.reports").joinpath("paper.css").read_text("utf-8"))
    found = weasyprint.HTML(string=_drawn(page), url_fetcher=URLFetcher(allowed_protocols=()))
    pdf: bytes = found.write_pdf(stylesheets=[paper], attachments=[*attachments])
    return pdf


def _further(document: Mapping[str, Any], *, attested: str) -> str:
    """What stands in print alone: every row, and how to verify what is attached."""
    environment, _ = templates()
    table = document["subject"]["table"]
    views = Views(describe(document)) if document["format"] == FORMAT else None
    of = None if views is None else views.page.expectations
    rows = [] if views is None or of is None else table_rows(of, burden=views.page.burden, most=None)
    text: str = environment.get_template("paper.html.j2").render(
        views=views, rows=rows, sure=any(row.ends for row in rows), held="header" in table, digest=table["sha256"], attested=attested
    )
    return text


def check_extra() -> None:
    """Refuse when what prints need is not installed.

    Raises
    ------
    InputError
        Naming what to install.
    """
    templates()
    _weasyprint()


def _weasyprint() -> Any:
    try:
        import weasyprint
    except ImportError:
        raise InputError("a PDF needs WeasyPrint; install the extra: pip install 'fairaudit-certify[pdf]', or ask for .html") from None
    except OSError as error:  # what it calls is not there
        library = str(error).partition("'")[2].partition("'")[0] or "a library"
        raise InputError(
            f"a PDF needs {library}, which is not installed; install Pango: apt install libpango-1.0-0 libpangoft2-1.0-0 "
            "libharfbuzz-subset0, or brew install pango, or ask for .html"
        ) from None
    return weasyprint


def _drawn(page: str) -> str:
    """Put into each drawing the rules of the page's style that are about shapes."""
    style = re.search("<style>(.*?)</style>", page, re.DOTALL)
    rules = "".join(_rules_of_shapes(style[1])) if style else ""
    return re.sub(r"(<svg\b[^>]*>)", lambda opening: f"{opening[1]}<style>{rules}</style>", page)


def _rules_of_shapes(css: str) -> Iterator[str]:
    """The rules of a style that are about shapes, with the values that variables have in print."""
    import tinycss2

    rules = [*_rules(tinycss2.parse_stylesheet(css, skip_comments=True, skip_whitespace=True))]
    values = {
        found.name: tinycss2.serialize(found.value).strip() for rule in rules for found in _declared(rule) if found.name.startswith("--")
    }
    for rule in rules:
        said = []
        for found in _declared(rule):
            value = VARIABLE.sub(lambda name: values.get(name[1], name[0]), tinycss2.serialize(found.value))
            if found.name in DRAWN and "var(" not in value:
                said.append(f"{found.name}:{value.strip()}")
        if said:
            yield f"{tinycss2.serialize(rule.prelude).strip()}{{{';'.join(said)}}}"


def _rules(nodes: Iterable[Any]) -> Iterator[Any]:
    """Rules that hold in print, in their order."""
    import tinycss2

    for node in nodes:
        if node.type == "qualified-rule":
            yield node
        elif node.type == "at-rule" and node.lower_at_keyword == "media" and tinycss2.serialize(node.prelude).strip() == "print":
            yield from _rules(tinycss2.parse_rule_list(node.content, skip_comments=True, skip_whitespace=True))


def _declared(rule: Any) -> list[Any]:
    import tinycss2

    found = tinycss2.parse_blocks_contents(rule.content, skip_comments=True, skip_whitespace=True)
    return [entry for entry in found if entry.type == "declaration"]
