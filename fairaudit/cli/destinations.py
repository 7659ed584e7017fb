"""Where a command writes: refused before the work is done, if it cannot be written or is one of the files that are read."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.tables.sources import is_audit_file, is_database

if TYPE_CHECKING:
    from fairaudit.audits.faces import Picture
    from fairaudit.certificates.certificate import Certificate
    from fairaudit.reports.report import Draw
    from fairaudit.verified.verification import Certified

__all__ = [
    "add_output",
    "check_forms",
    "check_output",
    "documents",
    "drawing",
    "named_in",
    "refuse_output",
    "refuse_twice",
    "write_outputs",
]


def add_output(group: Any) -> None:
    """Declare where a command writes its certificate, and what it writes besides."""
    group.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        action="append",
        help="write the certificate (.json), a page for people (.html), that in print (.pdf), markdown (.md) or a picture of what each "
        "group gets (.svg, .png); may be given several times",
    )
    group.add_argument("--report", metavar="FILE", dest="output", action="append", help="the same as -o")
    group.add_argument("--no-table", action="store_true", help="keep the table out of the certificate (it is written beside it)")


def documents(arguments: argparse.Namespace) -> list[str]:
    """The outputs that people read, of those that were named."""
    from fairaudit.reports.endings import form_of

    return [name for name in arguments.output or [] if form_of(name) != "json"]


def check_output(arguments: argparse.Namespace, more: Sequence[str] = (), *, undrawn: str = "") -> None:
    """Refuse outputs that cannot be written, or must not be, before the work is done; more are written than those that were named.

    Of what is `undrawn` there is no picture.

    Raises
    ------
    InputError
        If there is one.
    """
    from fairaudit.errors import InputError
    from fairaudit.reports.endings import form_of

    names: list[str] = [*(arguments.output or []), *more]
    stated = [arguments.attest] if getattr(arguments, "attest", None) is not None else []
    kept = [arguments.keep] if getattr(arguments, "keep", None) is not None else []
    inputs = list(_read(arguments)) if names or kept else []
    tables = _tables_beside([Path(name) for name in names if Path(name).suffix.lower() == ".json"])
    written, query = (*names, *stated, *kept, *tables), getattr(arguments, "query", None) or ""
    named = [path for path in written if re.search(rf"(?<![\w.-]){re.escape(Path(path).name)}(?![\w-])", query)]
    inputs.append((named, "a file that the query names,"))
    for read, what in inputs:
        for path in written:
            refuse_output(path, read, what)
    check_forms(names)
    for name in names if undrawn else ():
        if form_of(name) == "picture":
            raise InputError(f"{name}: there is no picture of {undrawn}; name .json, .html, .pdf or .md")
    for name in names if arguments.no_table else ():
        if form_of(name) == "picture":
            raise InputError(f"{name} would show what single groups get, which --no-table keeps back; leave one away")
    if arguments.no_table and not any(form_of(name) == "json" for name in names):
        raise InputError("--no-table needs -o FILE.json, to write the certificate and its table separately")
    refuse_twice([*names, *stated, *kept])
    if kept:
        refuse_twice([*tables, *kept])
    if stated:
        refuse_twice([*tables, *stated])
        if not stated[0].lower().endswith(".json"):
            raise InputError(f"--attest {stated[0]} does not end in .json, as an attestation does; name a file FILE.json")


def _tables_beside(certificates: Sequence[Path]) -> list[str]:
    if not certificates:
        return []
    from fairaudit.certificates.certificate import table_beside

    return [str(table_beside(path)) for path in certificates]


def check_forms(names: Sequence[str]) -> None:
    """Refuse files whose name does not say what to write, or whose making needs what is not installed."""
    from fairaudit.reports.endings import form_of

    forms = {form_of(name) for name in names}
    if "html" in forms:
        from fairaudit.reports.page import check_extra

        check_extra()
    if "pdf" in forms:
        from fairaudit.reports.paper import check_extra as check_paper

        check_paper()
    if "picture" in forms:
        from fairaudit.plots import check_extra as check_plots

        check_plots()


def refuse_twice(names: Sequence[str]) -> None:
    """Refuse a file that is named twice.

    Raises
    ------
    InputError
        If one is.
    """
    from fairaudit.errors import InputError

    for i, name in enumerate(names):
        if any(os.path.realpath(name) == os.path.realpath(other) for other in names[:i]):
            raise InputError(f"{name} is named twice; name a file for each")


def write_outputs(
    *made: tuple[Certificate | Certified, Sequence[str]],
    attestation: tuple[str, bytes] | None = None,
    before: Sequence[tuple[Path, Iterable[bytes]]] = (),
) -> list[str]:
    """Write certificates that were just made to their files, to each as its ending says: all of them, or none.

    Parameters
    ----------
    *made : (Certificate or Result, sequence of str)
        A certificate, or what has one, and the names of its files.
    attestation : (str, bytes), optional
        The file of a statement of the certificate, and what it holds; pages show it.
    before : sequence of (Path, iterable of bytes)
        Further files, of which the certificate was made.

    Returns
    -------
    list of str
        What can be verified of the first: the certificate, and its table where that stands beside it, else a page.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    from fairaudit.certificates.certificate import table_beside
    from fairaudit.files import write_together
    from fairaudit.reports.endings import form_of

    stated = None if attestation is None else attestation[1]
    files = [file for subject, names in made for file in _files(subject, names, stated)]
    beside = [] if attestation is None else [(Path(attestation[0]), [attestation[1]])]
    write_together([*before, *beside, *files])
    first, names = made[0]
    certificate = _certificate(first)
    for name in names:
        if form_of(name) == "json":
            return [name] if certificate.table is None else [name, str(table_beside(Path(name)))]
    return [name for name in names if form_of(name) == "html"][:1]


def _certificate(made: Certificate | Certified) -> Certificate:
    from fairaudit.certificates.certificate import Certificate

    return made if isinstance(made, Certificate) else made.certificate


def _files(made: Certificate | Certified, names: Sequence[str], attestation: bytes | None) -> list[tuple[Path, Iterable[bytes]]]:
    from fairaudit.errors import FalseCertificate
    from fairaudit.reports.endings import form_of

    if all(form_of(name) == "json" for name in names):
        return [file for name in names for file in _certificate(made).files(name)]
    from fairaudit.reports.report import files_of

    try:
        return files_of(made, names, attestation=attestation, draw=drawing(names))
    except FalseCertificate as error:
        raise RuntimeError(str(error)) from None


def drawing(names: Sequence[str], picture: Picture = "expectations") -> Draw | None:
    """What draws the pictures among these files; nothing is loaded where there is none."""
    from fairaudit.reports.endings import form_of

    if all(form_of(name) != "picture" for name in names):
        return None
    from fairaudit.plots import drawn

    return partial(drawn, picture=picture)


def refuse_output(name: str, read: Sequence[str], what: str = "the table") -> None:
    """Refuse a file that cannot be written, or is one of those that are read.

    Raises
    ------
    InputError
        If it is one of these.
    """
    from fairaudit.errors import InputError

    path = Path(name)
    try:
        fault = _fault(path, read, what)
    except (OSError, ValueError) as error:
        fault = f"cannot be written: {getattr(error, 'strerror', None) or error}"
    if fault:
        raise InputError(f"{path} {fault}")


def _read(arguments: argparse.Namespace) -> Iterator[tuple[list[str], str]]:
    """Files that are read, and what they are."""
    given = arguments.table if isinstance(arguments.table, list) else [arguments.table]
    yield [file for table in given if isinstance(table, str) for file in _behind(table)], "the table"
    for name, what in (
        ("from_monitor", "the state of the monitor"),
        ("map", "the file of --map"),
        ("group_probability", "the table of probabilities"),
        ("placebo", "the table of --placebo"),
    ):
        if isinstance(path := getattr(arguments, name, None), str):
            yield _behind(path), what
    yield [name for table in given if isinstance(table, str) for name in named_in(table)], "a file that the audit file names,"


def named_in(audit: str) -> list[str]:
    """The files that an audit file names; none of any other file."""
    from fairaudit.audits.sections import files_in
    from fairaudit.errors import InputError
    from fairaudit.files import read_toml

    if not is_audit_file(audit):
        return []
    try:
        document = read_toml(Path(audit))[0]
    except InputError:  # which the command says when it reads it
        return []
    return [file for name in files_in(document) for file in _behind(str(Path(audit).parent / name))]


def _behind(name: str) -> list[str]:
    """The files that are read for a name; of a name that stands for none the reader says what is wrong with it."""
    from fairaudit.audits.origin import files_behind
    from fairaudit.errors import InputError

    try:
        return files_behind(name)
    except (InputError, OSError, ValueError):
        return [] if is_database(name) else [name]


def _fault(path: Path, read: Sequence[str], what: str) -> str:
    """Why a file must not be written; empty if nothing is wrong."""
    if path.is_dir():
        return "is a directory; name a file to write"
    if not path.parent.is_dir():
        return f"cannot be written: there is no directory {path.parent}"
    if not os.access(path.parent, os.W_OK | os.X_OK):
        return f"cannot be written: nothing may be written in {path.parent}"
    try:
        found = path.stat()
    except FileNotFoundError:
        return ""
    if not path.is_file():
        return "is a device or a pipe; name a file to write"
    same = any(os.path.samestat(found, Path(name).stat()) for name in read if Path(name).exists())
    return f"is {what} itself; name another file to write" if same else ""
