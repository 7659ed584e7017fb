"""The folder of a publication: a page, a table for spreadsheets, a summary for programs, and the certificate that they rest on."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

from fairaudit.certificates.reader import subject as subject_of
from fairaudit.errors import InputError
from fairaudit.files import csv_text
from fairaudit.files import write_folder as write_whole
from fairaudit.publications.counts import Source
from fairaudit.publications.display import NONE, WITHHELD
from fairaudit.publications.publication import Page, Publication, Table
from fairaudit.publications.withholding import BESIDES, CHECKED, WHO, Private
from fairaudit.reports.lost_answers import lost_answers
from fairaudit.reports.page import UNBROKEN, digest, provenance_html, templates
from fairaudit.reports.provenance import TITLE as PROVENANCE
from fairaudit.reports.words import clip
from fairaudit.tables.preparation import parted, said, uncounted
from fairaudit.words import harmless, plain

__all__ = ["check_folder", "contents", "page", "summary", "write_folder"]

FORMAT = "fairaudit-publication/1"

CERTIFICATE, TABLE = "certificate.json", "certificate.table.jsonl"

OPTION = re.compile(r"(?<![\w-])--[a-z0-9-]*[a-z0-9]")
"""The name of an option, which is not broken where a line ends."""

FIGURE = re.compile(r"(<\N{NO-BREAK SPACE})?-?[0-9][0-9.,]*( %)?$")

NO_FIGURES = {NONE, WITHHELD, "left out", "none"}


def check_folder(name: str | os.PathLike[str]) -> None:
    """Refuse a folder that cannot be written, or in which something is.

    Raises
    ------
    InputError
        Saying what would be accepted.
    """
    path = Path(name)
    try:
        if path.exists() and not path.is_dir():
            raise InputError(f"{path} is a file; name a folder to make")
        if path.is_dir() and any(path.iterdir()):
            raise InputError(f"{path} is not empty; name a folder that is not there yet, or an empty one")
        if path.is_dir() and path.samefile(Path.cwd()):
            raise InputError(f"{path} is the current directory, which cannot be replaced; name a folder in it, or go elsewhere")
        parent = Path(os.path.realpath(path)).parent
        if not parent.is_dir():
            raise InputError(f"{path} cannot be made: there is no directory {path.parent}")
        if not os.access(parent, os.W_OK | os.X_OK):
            raise InputError(f"{path} cannot be made: nothing may be written in {path.parent}")
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{str(path)!r} cannot be made: {getattr(error, 'strerror', None) or error}") from None


def contents(
    publication: Publication, source: Source, again: str, private: Private | None = None, beside: Mapping[str, bytes] | None = None
) -> dict[str, bytes]:
    """The files of a publication, by name; the page says by which command it is made again of the others, those `beside` it included.

    Where the certificate is private neither it nor anything that rests on it is among them.

    Raises
    ------
    InputError
        If jinja2 is missing, or there is an attestation of a private certificate.
    """
    found = {
        "index.html": page(publication.page, source, private, again, tuple(beside or ())).encode("utf-8"),
        "table.csv": _table(publication).encode("utf-8"),
        "summary.json": (json.dumps(summary(publication, source, private), ensure_ascii=True, indent=1) + "\n").encode("ascii"),
    }
    found |= beside or {}
    if private is not None:
        if source.attestation is not None:
            raise InputError("--small does not go with --attestation, which tells counts that are withheld; give it with the certificate")
        return found
    found[CERTIFICATE] = source.raw
    if source.table is not None:
        found[TABLE] = source.table
    stated = source.provenance
    if source.attestation is not None and stated is not None:
        found[stated.file] = source.attestation
    return found


def write_folder(name: str | os.PathLike[str], found: Mapping[str, bytes]) -> None:
    """Write files into a folder, which appears whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written, or is not empty.
    """
    check_folder(name)
    write_whole(Path(name), found)


def summary(publication: Publication, source: Source, private: Private | None = None) -> dict[str, Any]:
    """What ``summary.json`` says; of a private certificate without its digest, from which counts could be guessed."""
    table = {"table_sha256": source.document["subject"]["table"]["sha256"]}
    whole = {"certificate": {"sha256": source.sha256} | table}
    return {
        "format": FORMAT,
        "rule": publication.rule,
        "title": publication.page.title,
        **({"certificate": table, "small": private.least} if private else whole),
        **({} if source.attestation is None else {"attestation": {"sha256": sha256(source.attestation).hexdigest()}}),
        **publication.summary,
    }


def page(shown: Page, source: Source, private: Private | None = None, again: str = "", beside: Sequence[str] = ()) -> str:
    """Write one page, which loads nothing and runs nothing.

    Parameters
    ----------
    shown : Page
        What it says.
    source : Source
        The certificate.
    private : Private, optional
        Who can check the page of a certificate that is not published: then it says nothing that only the certificate does.
    again : str
        The command that makes it again of the files beside it.
    beside : sequence of str
        Further files that it needs.

    Raises
    ------
    InputError
        If jinja2 is missing.
    """
    environment, markup = templates("fairaudit.publications")
    stated = source.provenance
    css = files("fairaudit.reports").joinpath("page.css").read_text("utf-8")
    subject = source.document["subject"]
    says: dict[str, Any] = {"said": CHECKED, "who": WHO, "prepared": uncounted(subject), "besides": BESIDES}
    if private is None:
        says = {
            "said": source.said,
            "provenance": None if stated is None else provenance_html(stated, saved=False),
            "stated": stated,
            "whose": PROVENANCE,
            "logged": of_log(source),
            "prepared": said({**subject, "preparation": map(parted, subject.get("preparation", ()))}),
            "sha256": source.sha256,
            "apart": TABLE if source.table is not None else "",
        }
    text: str = environment.get_template("publication.html.j2").render(
        page=shown,
        cell=clip,
        plain=plain,
        unbroken=UNBROKEN,
        right=_is_of_figures,
        whole=lambda text: markup(OPTION.sub(r'<span class="nb">\g<0></span>', str(markup.escape(plain(text))))),
        private=private,
        again=again,
        beside=beside,
        table_sha256=subject["table"]["sha256"],
        css=markup(css),
        policy=f"default-src 'none'; style-src '{digest(css)}'; base-uri 'none'; form-action 'none'",
        **says,
    )
    return text


def of_log(source: Source) -> tuple[str, ...]:
    """How an evaluation log was read, which answers decide nothing, and in which context most unequally; nothing of another table."""
    about = source.document["subject"]
    if "evaluation" not in about:
        return ()
    header, *rows = source.lines
    whole = {**source.document, "subject": {**about, "table": {**about["table"], "header": header, "rows": rows}}}
    held = subject_of(whole)
    found = lost_answers(about["evaluation"], None if held is None else held.law)
    return () if found is None else (*found.read, *([found.caution] if found.caution else []))


def _is_of_figures(table: Table, column: int) -> bool:
    """Whether a column of a table holds figures, which stand below each other by their last digits."""
    cells = [row[column] for row in table.rows]
    return column > 0 and any(FIGURE.match(cell) for cell in cells) and all(FIGURE.match(cell) or cell in NO_FIGURES for cell in cells)


def _table(publication: Publication) -> str:
    return csv_text(map(harmless, row) for row in (publication.header, *publication.rows))
