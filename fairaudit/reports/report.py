"""`report`: a certificate as a page, in print or as markdown, after it was checked."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fairaudit.arguments import answered
from fairaudit.attestations.verification import read_attestation
from fairaudit.audits.result import Result
from fairaudit.certificates.certificate import Certificate
from fairaudit.errors import FalseCertificate, InputError, nearest, shown
from fairaudit.files import write_together
from fairaudit.reports.endings import ENDINGS, Form, form_of
from fairaudit.reports.markdown import markdown
from fairaudit.reports.model_card import model_card
from fairaudit.reports.page import html
from fairaudit.reports.paper import printed
from fairaudit.reports.provenance import Provenance, provenance_of
from fairaudit.reports.proxy_content import FORMAT as PROXIES
from fairaudit.reports.proxy_page import proxy_html, proxy_markdown
from fairaudit.reports.subgroup_content import FORMAT as SUBGROUPS
from fairaudit.reports.subgroup_page import subgroup_html, subgroup_markdown
from fairaudit.verified.verification import CertificateLike, Opened, checked, opened

__all__ = ["files_of", "report"]

MODEL_CARD: Form = "model-card"

NO_PICTURE = "a report is no picture; Result.plot draws one, and so does fairaudit report"

Draw = Callable[[Result | Mapping[str, Any], str], bytes]

FORMATS: dict[str, Callable[..., str]] = {"html": html, "markdown": markdown, MODEL_CARD: model_card}

OF_OTHERS: dict[str, dict[str, Callable[..., str]]] = {
    PROXIES: {"html": proxy_html, "markdown": proxy_markdown},
    SUBGROUPS: {"html": subgroup_html, "markdown": subgroup_markdown},
}


@answered
def report(
    certificate: CertificateLike,
    path: str | os.PathLike[str] | None = None,
    *,
    format: Form | None = None,  # noqa: A002
    table: str | os.PathLike[str] | None = None,
    attestation: bytes | str | os.PathLike[str] | None = None,
) -> str:
    """Write a certificate as a self-contained page that people read, in print, or as markdown; it is checked first, as `verify` does.

    Parameters
    ----------
    certificate : Certificate, Result, mapping, bytes or path
        The certificate.
    path : path, optional
        Where to write the report, which its ending names: ``.html``, ``.pdf``, ``.md``, or ``.json`` for the certificate itself; by default
        it is only returned.
    format : {"html", "markdown", "model-card", "pdf", "json"}, optional
        What to write; by default what the ending of the path names, or a page. A model card is markdown, too, and ends in ``.md``. Pages
        need the extra ``report``, prints the extra ``pdf``.
    table : path, optional
        The file of the canonical table, where the certificate does not hold it; nothing of it goes into the report. Without it the report
        says that nobody checked the certificate.
    attestation : path or bytes, optional
        The file that says who made the certificate, of what (docs/attestation.md). It must fit the certificate, and stands in the report,
        what was checked of it apart from what is only stated.

    Returns
    -------
    str
        The report; of a print the page that was printed.

    Raises
    ------
    FalseCertificate
        If a statement of the certificate or of the attestation is false; then nothing is written.
    InputError
        If it is no certificate, the format is not known, or the file cannot be written.

    Examples
    --------
    >>> from fairaudit.audits.from_table import audit
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    >>> result = audit(table, decision="hired", group="sex", utility="yes")
    >>> report(result, format="markdown").splitlines()[0]
    '## Fairness audit: no target was set'
    """
    form = _form(format, path)
    given = attestation if attestation is None or isinstance(attestation, bytes) else read_attestation(attestation)
    subject = _read([] if path is None else [path], certificate, table, given)
    text = subject.text(form)
    if path is not None:
        write_together([(Path(path), [subject.file(text, form)])])
    return text


def files_of(
    certificate: CertificateLike,
    paths: Sequence[str | os.PathLike[str]],
    table: str | os.PathLike[str] | None = None,
    *,
    cards: bool = False,
    attestation: bytes | None = None,
    draw: Draw | None = None,
) -> list[tuple[Path, Iterable[bytes]]]:
    """Make files of a certificate, of each what its ending says, after it was checked.

    Parameters
    ----------
    certificate : Certificate, Result, mapping, bytes or path
        The certificate.
    paths : sequence of paths
        Files that end in ``.json``, ``.html``, ``.pdf``, ``.md``, ``.svg`` or ``.png``.
    table : path, optional
        The file of the canonical table, where the certificate does not hold it.
    cards : bool
        Whether what ends in ``.md`` is a model card.
    attestation : bytes, optional
        The bytes of an attestation, which stands in what people read.
    draw : callable, optional
        What makes the bytes of a picture, of the document of the certificate or a result, for a file of this name.

    Returns
    -------
    list of (Path, iterable of bytes)
        The files with their content, for `write_together`; with those of tables that stand beside certificates.

    Raises
    ------
    FalseCertificate
        If a statement is false, of the certificate or of the attestation.
    InputError
        If it is no certificate, or a name does not say what to write.
    """
    forms = [_form(MODEL_CARD, path) if cards else form_of(path) for path in paths]
    subject = _read(paths, certificate, table, attestation)
    made = certificate if isinstance(certificate, Certificate) else getattr(certificate, "certificate", Certificate(subject.found.document))
    page = subject.text("html") if {"html", "pdf"} & {*forms} else ""
    files: list[tuple[Path, Iterable[bytes]]] = []
    for path, form in zip(paths, forms, strict=True):
        if form == "json":
            files += made.files(path)
        elif form == "picture":
            if draw is None:
                raise InputError(f"{os.fspath(path)}: {NO_PICTURE}")
            files.append((Path(path), [draw(certificate if isinstance(certificate, Result) else subject.found.document, os.fspath(path))]))
        else:
            files.append((Path(path), [subject.file(subject.text(form) if form in ("markdown", MODEL_CARD) else page, form)]))
    return files


@dataclass(frozen=True)
class _Subject:
    """What is reported: a certificate that was checked, what was said of that, and what its attestation says."""

    found: Opened
    said: str
    attestation: bytes | None
    provenance: Provenance | None

    def text(self, form: Form) -> str:
        """The report as text; of a print the page that is printed."""
        if form == "json":
            return Certificate(self.found.document).text
        faces = OF_OTHERS.get(str(self.found.form), FORMATS)
        if form == MODEL_CARD and MODEL_CARD not in faces:
            raise InputError(f"{self.found.name}: a model card is made of a certificate of ratios, and this one is {self.found.form}")
        return faces["html" if form == "pdf" else form](self.found.document, checked=self.said, provenance=self.provenance)

    def file(self, text: str, form: Form) -> bytes:
        """The bytes of a file of the report."""
        if form != "pdf":
            return text.encode("utf-8")
        beside = {}
        if self.attestation is not None and self.provenance is not None:
            beside = {"certificate.json": self.found.raw, self.provenance.file: self.attestation}
        return printed(text, self.found.document, beside)


def _form(given: Form | None, path: str | os.PathLike[str] | None) -> Form:
    """What to write, by its name or by the ending of the path."""
    known = dict.fromkeys((*(form for form in ENDINGS.values() if form != "picture"), MODEL_CARD))
    if given is not None and given not in known:
        raise InputError(f"format={shown(given)} is not accepted; {nearest(str(given), known)}")
    if path is None:
        if given == "pdf":
            raise InputError("format='pdf' needs a path that ends in .pdf; a print is no text")
        return given or "html"
    form = form_of(path)
    if form == "picture":
        raise InputError(f"{os.fspath(path)}: {NO_PICTURE}")
    if (given, form) == (MODEL_CARD, "markdown"):
        return MODEL_CARD
    if given not in (None, form):
        raise InputError(f"format={shown(given)} does not go with {os.fspath(path)}; leave it away, or name a file that ends otherwise")
    return form


def _read(
    paths: Sequence[str | os.PathLike[str]],
    certificate: CertificateLike,
    table: str | os.PathLike[str] | None,
    attestation: bytes | None,
) -> _Subject:
    """Open a certificate and check it, with its attestation."""
    for target in map(Path, paths):
        if isinstance(certificate, (str, os.PathLike)) and target.exists() and target.samefile(certificate):
            raise InputError(f"{target} is the certificate itself; name another file to write")
    found = opened(certificate, table)
    try:
        said = checked(found, attestation)
        digest = found.document["subject"]["table"]["sha256"]
        stated = None if attestation is None else provenance_of(attestation, found.raw, digest, compared=bool(said))
        return _Subject(found, said, attestation, stated)
    except FalseCertificate as error:
        raise FalseCertificate(f"{error}; no report was written") from None
