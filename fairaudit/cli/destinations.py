"""Where a command writes: refused before the work is done, if it cannot be written or is one of the files that are read."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from fairaudit.tables.sources import is_database

__all__ = ["check_output", "refuse_output"]


def check_output(arguments: argparse.Namespace) -> None:
    """Refuse an output that cannot be written, or must not be, before the work is done."""
    from fairaudit.errors import InputError

    if getattr(arguments, "report", None) is not None:
        _check_page(arguments)
    if arguments.output is None:
        if arguments.no_table:
            raise InputError("--no-table needs -o FILE, to write the certificate and its table separately")
        return
    refuse_output(arguments.output, _tables(arguments))


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


def _check_page(arguments: argparse.Namespace) -> None:
    """Refuse a page that cannot be written, before the work is done."""
    from fairaudit.errors import InputError
    from fairaudit.reports.page import check_extra

    refuse_output(arguments.report, _tables(arguments))
    if arguments.output is not None and os.path.realpath(arguments.output) == os.path.realpath(arguments.report):
        raise InputError("-o and --report name the same file; the certificate and its page need one each")
    check_extra()


def _tables(arguments: argparse.Namespace) -> list[str]:
    """Files that are read."""
    tables = arguments.table if isinstance(arguments.table, list) else [arguments.table]
    return [table for table in tables if isinstance(table, str) and not is_database(table)]


def _fault(path: Path, read: Sequence[str], what: str) -> str:
    """Why a file must not be written; empty if nothing is wrong."""
    if path.is_dir():
        return "is a directory; name a file to write"
    if not path.parent.is_dir():
        return f"cannot be written: there is no directory {path.parent}"
    try:
        found = path.stat()
    except FileNotFoundError:
        return ""
    if not path.is_file():
        return "is a device or a pipe; name a file to write"
    same = any(os.path.samestat(found, Path(name).stat()) for name in read if Path(name).exists())
    return f"is {what} itself; name another file to write" if same else ""
