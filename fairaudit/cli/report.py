"""`fairaudit report`: a certificate as a page that people read, in print, or as markdown."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer

DESCRIPTION = """\
Write a certificate as one self-contained HTML page, as that in print (PDF), or as markdown. Every statement is checked first, as
`fairaudit verify` does; a false certificate gets no report, and one whose table is in another file that --table does not name, a report
marked as not checked. The page loads nothing, embeds the certificate, and recomputes its figures in the reader's browser."""


EPILOG = """\
exit codes: 0 written; 1 a statement of the certificate is false; 2 bad input

examples:
  fairaudit report certificate.json -o page.html -o page.pdf
  fairaudit report certificate.json --format markdown
  fairaudit report certificate.json --table certificate.table.jsonl -o page.html"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "report", run, "write a certificate as a page for people", DESCRIPTION, EPILOG)
    parser.add_argument("certificate", metavar="CERTIFICATE.json", help="the certificate")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        action="append",
        help="where to write: a page (.html), that in print (.pdf), markdown (.md), the certificate itself (.json); may be given several "
        "times (standard output by default)",
    )
    parser.add_argument("--format", choices=("html", "markdown"), help="what to write to standard output (html)")
    parser.add_argument(
        "--table",
        metavar="FILE",
        help="the canonical table, to check a certificate that does not hold it; nothing of it goes into the report",
    )


def run(arguments: argparse.Namespace) -> Answer | int:
    """Do the work."""
    from fairaudit.cli.destinations import check_forms, refuse_output, refuse_twice
    from fairaudit.errors import FalseCertificate, InputError
    from fairaudit.files import write_together
    from fairaudit.reports.endings import form_of
    from fairaudit.reports.report import files_of, report
    from fairaudit.words import plain

    names: list[str] = arguments.output or []
    for name in names:
        refuse_output(name, [arguments.certificate], "the certificate")
        refuse_output(name, [arguments.table] if arguments.table is not None else [])
        if arguments.format not in (None, form_of(name)):
            raise InputError(f"--format {arguments.format} does not go with {name}, whose ending says what is written; leave one away")
    refuse_twice(names)
    check_forms(names)
    try:
        if names:
            write_together(files_of(arguments.certificate, names, arguments.table))
            return 0
        text = report(arguments.certificate, format=arguments.format, table=arguments.table)
    except FalseCertificate as error:
        print(f"fairaudit: {plain(str(error))}", file=sys.stderr)
        return 1
    return Answer("report", result=dict, text=lambda: text.rstrip("\n"))
