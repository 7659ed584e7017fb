"""`fairaudit verify`: check a certificate with the independent checker, and nothing else."""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
from collections.abc import Iterable
from typing import Any


def add(commands: Any) -> None:
    """Declare the options."""
    parser = commands.add_parser(
        "verify",
        help="check a certificate",
        description="Check every statement of a certificate, in exact integer arithmetic and with none of the code that wrote it.",
        epilog="exit codes: 0 all true; 1 a statement is false, or the required verdict is not there; 2 bad input; 3 the table is needed",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("certificate", metavar="CERTIFICATE.json", help="the certificate")
    parser.add_argument("--table", metavar="FILE", help="the canonical table, when the certificate does not hold it")
    parser.add_argument("--require", choices=("within",), help="also fail unless the verdict is 'within'")


def run(arguments: argparse.Namespace) -> int:
    """Hand over to the checker."""
    from fairaudit import checker

    options = [f"--table={arguments.table}"] if arguments.table is not None else []
    options += [f"--require={arguments.require}"] if arguments.require is not None else []
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        code = checker.main([*options, "--", arguments.certificate])
    for line in said.getvalue().splitlines():
        print(f"fairaudit: {checker.printable(arguments.certificate)}: {line}", file=sys.stderr)
    return code


def checked(raw: bytes, table: Iterable[bytes] | None, name: str) -> tuple[str, str]:
    """Check a certificate as `verify` does.

    Returns
    -------
    tuple of str
        What is false, or nothing; and a sentence on what was checked.

    Raises
    ------
    InputError
        If it is no certificate of the format.
    """
    from fairaudit import __version__, checker
    from fairaudit.errors import InputError

    try:
        found = checker.check(raw, table)
    except checker.TableNeeded:
        return "", "The table was not at hand when this was made: its statements are repeated unchecked."
    except checker.FormatError as error:
        raise InputError(f"{name} is not a certificate of the format {checker.CERTIFICATE_FORMAT}: {error}") from None
    false = [finding for finding in found.findings if not finding.true]
    if false:
        first = f"{false[0].statement}{f' ({false[0].detail})' if false[0].detail else ''}"
        return f"{name}: {len(false)} of {len(found.findings)} statements are FALSE, the first: {first}", ""
    return "", f"Checked when this was made: all {len(found.findings)} statements are true of the table (fairaudit verify, {__version__})."
