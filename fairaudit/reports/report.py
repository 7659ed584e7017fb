"""`report`: a certificate as a page or as markdown, after it was checked."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from fairaudit.arguments import answered
from fairaudit.errors import FalseCertificate, InputError, nearest, shown
from fairaudit.files import write_atomically
from fairaudit.reports.markdown import markdown
from fairaudit.reports.page import html
from fairaudit.reports.proxy_content import FORMAT as PROXIES
from fairaudit.reports.proxy_page import proxy_html, proxy_markdown
from fairaudit.reports.subgroup_content import FORMAT as SUBGROUPS
from fairaudit.reports.subgroup_page import subgroup_html, subgroup_markdown
from fairaudit.verified.verification import CertificateLike, checked, opened

__all__ = ["report"]

FORMATS: dict[str, Callable[..., str]] = {"html": html, "markdown": markdown}

OF_OTHERS: dict[str, dict[str, Callable[..., str]]] = {
    PROXIES: {"html": proxy_html, "markdown": proxy_markdown},
    SUBGROUPS: {"html": subgroup_html, "markdown": subgroup_markdown},
}


@answered
def report(
    certificate: CertificateLike,
    path: str | os.PathLike[str] | None = None,
    *,
    format: Literal["html", "markdown"] = "html",  # noqa: A002
    table: str | os.PathLike[str] | None = None,
) -> str:
    """Write a certificate as a self-contained page that people read, or as markdown; it is checked first, as `verify` does.

    Parameters
    ----------
    certificate : Certificate, Result, mapping, bytes or path
        The certificate.
    path : path, optional
        Where to write the report; by default it is only returned.
    format : {"html", "markdown"}
        What to write; pages need the extra ``report``.
    table : path, optional
        The file of the canonical table, where the certificate does not hold it; nothing of it goes into the report. Without it the report
        says that nobody checked the certificate.

    Returns
    -------
    str
        The report.

    Raises
    ------
    FalseCertificate
        If a statement is false; then nothing is written.
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
    if format not in FORMATS:
        raise InputError(f"format={shown(format)} is not accepted; {nearest(str(format), FORMATS)}")
    target = None if path is None else Path(path)
    if target is not None and isinstance(certificate, (str, os.PathLike)) and target.exists() and target.samefile(certificate):
        raise InputError(f"{target} is the certificate itself; name another file to write")
    found = opened(certificate, table)
    try:
        said = checked(found)
    except FalseCertificate as error:
        raise FalseCertificate(f"{error}; no report was written") from None
    faces = OF_OTHERS.get(str(found.form), FORMATS)
    text = faces[format](found.document, checked=said)
    if target is not None:
        write_atomically(target, [text.encode("utf-8")])
    return text
