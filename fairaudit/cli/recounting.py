"""`fairaudit verify --recount`: the log counted again by the attestation, and what that showed."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli.source import option, progress

if TYPE_CHECKING:
    from fairaudit.attestations.recount import Recount
    from fairaudit.errors import InputError

__all__ = ["add_recount", "as_json", "as_text", "check_recount", "recount_of"]

WIDTH = 80


def add_recount(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--recount",
        metavar="LOG",
        nargs="+",
        action="extend",
        help="also count the log again as --attestation says, and name the first cell that differs",
    )
    parser.add_argument("--query", metavar="SQL", help="with --recount: the query of the attestation, which is run only if you give it")
    parser.add_argument("--engine", choices=("auto", "duckdb", "python", "spark"), help="with --recount: who reads files")
    parser.add_argument("--memory", metavar="SIZE", help="with --recount: what DuckDB may use before it spills to disk, such as 2GB")


def check_recount(arguments: argparse.Namespace) -> None:
    """Refuse options that do not go together.

    Raises
    ------
    InputError
        If there are such.
    """
    from fairaudit.errors import InputError

    if arguments.recount is not None and arguments.attestation is None:
        raise InputError("--recount goes with --attestation FILE, which says how the log was counted")
    for name in ("query", "engine", "memory"):
        if getattr(arguments, name) is not None and arguments.recount is None:
            raise InputError(f"{option(name)} goes with --recount LOG, the log that is counted again")


def recount_of(arguments: argparse.Namespace, certificate: str, attestation: bytes) -> Recount | InputError | None:
    """Count the log again, if that is asked for, with progress on a terminal; or say why that cannot be done.

    Parameters
    ----------
    arguments : Namespace
        What was asked for.
    certificate : str
        The file of the certificate, which has been checked.
    attestation : bytes
        The bytes of its file, or, where its signature was checked, exactly those that were signed.
    """
    if arguments.recount is None:
        return None
    from fairaudit.attestations.recount import attested_document, recounted
    from fairaudit.attestations.verification import stated_in
    from fairaudit.errors import InputError
    from fairaudit.verified.verification import table_lines

    source = arguments.recount if len(arguments.recount) > 1 else arguments.recount[0]
    lines = None if arguments.table is None else partial(table_lines, Path(arguments.table))
    asked = {"query": arguments.query, "engine": arguments.engine or "auto", "memory": arguments.memory}
    try:
        statement, _ = stated_in(attestation, arguments.attestation)
        document = attested_document(certificate, statement)
        with progress() as report:
            return recounted(document, lines, statement, source, **asked, report=report, spelled=option)
    except InputError as error:
        return error


def as_text(found: Recount | InputError) -> list[str]:
    """What the recount showed, in lines for a person; nothing where it could not be done, of which the message says why."""
    if isinstance(found, Exception):
        return []
    from textwrap import wrap

    listed = [f"{'differs' if entry.equal is False else 'equal  ' if entry.equal else 'unknown'}  {entry.line}" for entry in found.findings]
    return ["", *listed, *([""] if listed else []), *wrap(found.paragraph, WIDTH, break_long_words=False, break_on_hyphens=False)]


def as_json(found: Recount | InputError) -> dict[str, Any]:
    """What the recount showed, for programs; of one that could not be done why, and that nothing is known."""
    if isinstance(found, Exception):
        said = f"Nothing was recounted: {found}."
        return {"equal": None, "paragraph": said, "missing": [], "findings": [], "different_cells": 0, "first_cell": None}
    first = None if found.difference is None else found.difference.first
    return {
        "equal": None if found.exit_code == 3 else found.ok,
        "paragraph": found.paragraph,
        "missing": list(found.missing),
        "findings": [{"what": entry.what, "equal": entry.equal, "detail": entry.detail} for entry in found.findings],
        "different_cells": 0 if found.difference is None else found.difference.cells,
        "first_cell": first
        and {
            "context": first.context,
            "group": first.group,
            "numbers": [{"of": what, "certificate": own, "log": other} for what, own, other in first.numbers],
        },
    }
