"""The command.

Exit codes: 0 every statement is true (and the required verdict is there); 1 a statement is false, or the required
verdict is not there; 2 not a complete certificate of this format, not readable, or wrong usage; 3 the table is not embedded and
was not given, or everything else is true but the signature of the attestation was not checked, which this checker cannot do.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from .attestation import LONGEST_FILE, Signed, check_attestation
from .certificate import CERTIFICATE_FORMAT
from .summary import exit_code, lines
from .text import FormatError, Incomplete, NotAnAttestation, Report, TableNeeded, TooMuch, malformed, printable, shown
from .verification import check

MAX_BYTES = 1 << 30  # of a certificate, and of one line of a table


def _check_files(path: str, table: str | None, attestation: str | bytes | Signed | None) -> Report:
    with open(path, "rb") as file:
        raw = file.read(MAX_BYTES + 1)
    if len(raw) > MAX_BYTES:
        raise malformed("the certificate", f"is longer than {MAX_BYTES} bytes")
    attested: bytes | Signed | None
    if isinstance(attestation, str):
        with open(attestation, "rb") as file:
            attested = file.read(LONGEST_FILE + 1)
    else:
        attested = attestation
    if table is None:
        report = check(raw)
    else:
        with open(table, "rb") as file:
            report = check(raw, iter(lambda: file.readline(MAX_BYTES), b""))
    return report if attested is None else replace(report, attested=check_attestation(attested, raw, report))


@dataclass(frozen=True)
class Refusal:
    """Why a certificate is not checked, and the exit code that says so."""

    message: str
    code: int


def _unreadable(error: OSError | ValueError) -> str:
    """Why a file cannot be read or written, without the number that the system has for it."""
    if isinstance(error, OSError) and error.strerror:
        hint = ""
        if isinstance(error.filename, str) and os.path.isdir(error.filename):
            there = os.path.isfile(os.path.join(error.filename, "certificate.json"))
            hint = f"; give {'certificate.json' if there else 'a file'} in it"
        return f"Cannot read or write{f' {shown(str(error.filename))}' if error.filename else ''}: {error.strerror}{hint}."
    return f"Cannot read or write: {error}."


def examine(path: str, table: str | None = None, attestation: str | bytes | Signed | None = None) -> Report | Refusal:
    """Check the file of a certificate, that of its table and that of its attestation if they are given; or say why that cannot be done.

    Of an attestation somebody may have read the bytes already, or checked the signature: then what was found is given instead.
    """
    try:
        return _check_files(path, table, attestation)
    except TableNeeded as error:
        return Refusal(str(error), 3)
    except Incomplete as error:
        return Refusal(f"The certificate is incomplete: {error}.", 2)
    except TooMuch as error:
        return Refusal(f"The certificate is not checked: {error}.", 2)
    except NotAnAttestation as error:
        return Refusal(f"Not an attestation: {error}.", 2)
    except FormatError as error:
        return Refusal(f"Not a certificate of the format {error.form or CERTIFICATE_FORMAT}: {error}.", 2)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        return Refusal(_unreadable(error), 2)
    except (MemoryError, OverflowError):
        return Refusal("The numbers in the certificate or its table need more memory than there is.", 2)


def _print(lines: Iterable[str]) -> None:
    if sys.stdout is None:  # standard output was closed; the exit code still tells
        return
    encoding = sys.stdout.encoding or "utf-8"
    try:
        for line in lines:
            print(printable(line).encode(encoding, "backslashreplace").decode(encoding))
        sys.stdout.flush()
    except BrokenPipeError:  # nobody reads on; the exit code still tells
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _failed(message: str, code: int) -> int:
    print(printable(message), file=sys.stderr)
    return code


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        The arguments, without the name of the program; those of the process by default.

    Returns
    -------
    int
        The exit code.
    """
    parser = argparse.ArgumentParser(prog="checker", description="Check a certificate.", allow_abbrev=False)
    parser.add_argument("certificate", help="the certificate, a JSON file, or a page that holds one")
    parser.add_argument("--table", metavar="FILE", help="the table, if the certificate does not embed it")
    parser.add_argument("--attestation", metavar="FILE", help="who made the certificate, of which files; its signature is not checked")
    parser.add_argument("--require", choices=["within"], help="fail unless the verdict is this one")
    more = parser.add_mutually_exclusive_group()
    more.add_argument("--verbose", action="store_true", help="print every statement and every assumption, too")
    more.add_argument("--quiet", action="store_true", help="print nothing; the exit code tells")
    try:
        arguments = parser.parse_args(argv)
    except SystemExit as stop:
        return 2 if stop.code else 0
    found = examine(arguments.certificate, arguments.table, arguments.attestation)
    if isinstance(found, Refusal):
        return found.code if arguments.quiet else _failed(found.message, found.code)
    try:
        if not arguments.quiet:
            _print(lines(found, arguments.require, verbose=arguments.verbose))
    except OSError as error:
        return _failed(_unreadable(error), 2)
    return exit_code(found, arguments.require)
