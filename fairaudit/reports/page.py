"""A report as one self-contained HTML page, which loads nothing; a program that is itself proved checks it in the reader's browser."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from fairaudit.certificates.certificate import Certificate
from fairaudit.errors import InputError
from fairaudit.reports.content import UNCHECKED, Content, describe, refusing_other_documents
from fairaudit.reports.hidden_context import area
from fairaudit.reports.pictures import curve, heat
from fairaudit.reports.provenance import TITLE as PROVENANCE
from fairaudit.reports.provenance import Provenance, intro
from fairaudit.reports.views import Views

if TYPE_CHECKING:
    from markupsafe import Markup

__all__ = ["UNBROKEN", "check_extra", "digest", "html", "provenance_html", "scriptless", "templates"]


UNBROKEN = "\u00a0%"  # which stays with its number


@refusing_other_documents
def html(certificate: Certificate | Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate as one self-contained HTML page.

    The page loads nothing. It shows the verdict, what each group gets, the bounds and what the reader has to judge, embeds the certificate,
    and has it checked in the reader's browser by the program of ``proofs/checker``. What the certificate says is believed here:
    `fairaudit report` checks it first.

    Parameters
    ----------
    certificate : Certificate or mapping
        The certificate, or its JSON document.
    checked : str
        A sentence on who checked the certificate when the page was made. Without one, the page of a certificate that does not hold its
        table says that it was not checked, and does not wear the colour of its verdict.
    provenance : Provenance, optional
        What its attestation says.

    Returns
    -------
    str
        The page.

    Raises
    ------
    InputError
        If jinja2 is missing, or the document does not have the shape of a certificate.

    Examples
    --------
    >>> from fairaudit import Law, certify
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> page = html(certify(law, {"yes": 1}).certificate)
    >>> page.startswith("<!DOCTYPE html>"), "3/2" in page
    (True, True)
    """
    environment, markup = templates()
    page = describe(certificate.document if isinstance(certificate, Certificate) else certificate)
    css, script = (files("fairaudit.reports").joinpath(name).read_text("utf-8") for name in ("page.css", "page.js"))
    script = script.replace('"verified.js"', _verified(), 1)
    views = Views(page)
    text: str = environment.get_template("page.html.j2").render(
        page=page,
        views=views,
        worth=lambda value: views.amount(value).replace(" %", UNBROKEN),
        between=lambda ends: views.between(ends).replace(" %", UNBROKEN),
        titles=_titles(page, views, stated=provenance is not None),
        provenance=None if provenance is None else provenance_html(provenance),
        pairs=[matrix for matrix in page.matrices if len(matrix.rows) > 2],
        checked=checked,
        unchecked="" if checked or page.subject is not None else UNCHECKED,
        css=markup(css),
        script=markup(script),
        embedded=markup(embedded(page.document)),
        policy=f"default-src 'none'; style-src '{digest(css)}'; script-src '{digest(script)}'; worker-src blob:; base-uri 'none'; "
        "form-action 'none'; require-trusted-types-for 'script'; trusted-types fairaudit",
        svg=markup,
        heat=heat,
        curve=markup(curve(page.calibration)) if page.calibration else "",
        area=lambda found: markup(area(found)),
        drawn=lambda found: markup(found.picture),
    )
    return text


def scriptless(
    template: str,
    title: str,
    page: Any,
    headline: str,
    document: Mapping[str, Any],
    checked: str,
    found: tuple[str, str],
    provenance: Provenance | None = None,
) -> str:
    """Write what is said of a certificate as a page without a script, by a template that extends ``scriptless.html.j2``.

    Its first section has the name and title `found`.
    """
    environment, markup = templates()
    css = files("fairaudit.reports").joinpath("page.css").read_text("utf-8")
    text: str = environment.get_template(template).render(
        page=page,
        title=title,
        headline=headline[0].upper() + headline[1:],
        checked=checked or UNCHECKED,
        svg=markup,
        sections=[
            found,
            *([("judge", "What you have to judge")] if page.assumptions else []),
            ("verify", "What to do next: verify it"),
            *([("provenance", PROVENANCE)] if provenance else []),
            ("audited", "What was audited"),
        ],
        unchecked=not checked,
        provenance=None if provenance is None else provenance_html(provenance),
        whose=PROVENANCE,
        css=markup(css),
        embedded=markup(embedded(document)),
        format=document["format"],
        policy=f"default-src 'none'; style-src '{digest(css)}'; base-uri 'none'; form-action 'none'",
    )
    return text


def provenance_html(found: Provenance, *, saved: bool = True) -> Any:
    """What stands of an attestation in a page, under a heading of the page's own; every text in it is escaped.

    Parameters
    ----------
    found : Provenance
        What the attestation says.
    saved : bool
        Whether the page holds the certificate, so that somebody may save it from there.

    Returns
    -------
    Markup
        The part of a page, for templates that escape; it wants the style of ``page.css``.
    """
    environment, markup = templates()
    return markup(environment.get_template("provenance.html.j2").render(found=found, intro=intro(), saved=saved))


def embedded(document: Mapping[str, Any]) -> str:
    """The JSON of a certificate as it may stand in a page."""
    text = json.dumps(document, ensure_ascii=True, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def check_extra() -> None:
    """Refuse when what pages need is not installed.

    Raises
    ------
    InputError
        Naming the extra to install.
    """
    templates()


@cache
def templates(package: str = "fairaudit.reports") -> tuple[Any, type[Markup]]:
    """What fills in the templates of a package, every text escaped."""
    try:
        from jinja2 import Environment, FunctionLoader, StrictUndefined
        from markupsafe import Markup
    except ImportError:
        raise InputError("a page needs jinja2; install the extra: pip install 'fairaudit-certify[report]', or ask for markdown") from None
    loader = FunctionLoader(lambda name: files(package).joinpath(name).read_text("utf-8"))
    return Environment(autoescape=True, loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True), Markup


@cache
def _verified() -> str:
    """The checker that is extracted from its proof, as a literal for the page's script, which runs it in a worker."""
    text = files("fairaudit.reports").joinpath("verified.js").read_text("utf-8")
    return json.dumps(text, ensure_ascii=True).replace("<", "\\u003c")


def digest(text: str) -> str:
    """The digest of a script or a style by which the policy of a page lets it in."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}"


def _titles(page: Content, views: Views, *, stated: bool) -> dict[str, str]:
    """The sections of a page, in order, with their titles."""
    gets = "bears" if page.burden else "gets"
    found = {
        "groups": (f"What each group {gets}", views.overall or page.subject is None),
        "contexts": ("Contexts, the most unequal first", views.ranking),
        "unknown": ("Decisions without a recorded group", page.unknown),
        "undecided": ("Undecided decisions", page.undecided),
        "every": ("Look up a group" if not views.context_column else "Look up a group or context", views.cells > 1),
        "left-out": ("How the table was read", True),
        "judge": ("What you have to judge", True),
        "verify": ("What to do next: verify it", True),
        "provenance": (PROVENANCE, stated),
        "found": ("The figures, exactly", True),
        "given": ("Given the true label", page.given_truth),
        "known": ("What is known, from the table to the guarantee", True),
        "unrecorded": ("Could something unrecorded explain it?", page.strengths or page.declared_factor),
        "drift": ("How much may change before this verdict falls", page.drifting),
        "truth": ("How much truth a filter may tell", page.calibration),
        "pairs": ("Pair by pair", any(len(matrix.rows) > 2 for matrix in page.matrices)),
        "audited": ("What was audited", True),
        "claims": ("Every statement", True),
    }
    return {name: title for name, (title, there) in found.items() if there}
